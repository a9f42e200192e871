"""One round of a session on every display: energy by part and run-ups, heat and limits, for some numbers of axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar.analysis.shared_motor import run_up_energy
from infinivar.displays.handle_session import (
    PARTS,
    HandleSession,
    PartPower,
    cobotic_part,
    geared_part,
    stopped_part,
)
from infinivar.displays.pair import CONVENTIONAL, DisplayPair, Rival
from infinivar.drivetrain.drive import motor_side
from infinivar.limits import Limit
from infinivar.machines.many_legs import LeggedDrive

TURNING, STOPPED, RESTING = "cylinder turning", "stopped while idle", "stopped at rest"

_STOPS: Mapping[str, tuple[str, ...]] = {TURNING: (), STOPPED: ("idle",), RESTING: ("idle", "hold")}

WAYS = tuple(_STOPS)
"""Three ways to run the cobotic display. *At rest*: while idle and while a constant force is held."""

DISPLAYS = (*WAYS, CONVENTIONAL)
"""Of a pair without further rivals."""

RUN_UP = "run-up"

_SLOWER = tuple(0.2 ** (place / 10) for place in range(11))
"""Speeds of a cylinder over that set, among which a part of a session has the one of least loss."""


def round_of(pair: DisplayPair, session: HandleSession, counts: Sequence[int]) -> dict[str, np.ndarray]:
    """Energies, heat and limits of one pair in one round, without stability; the arrays of `DisplayComparison` for one variant.

    Parameters
    ----------
    pair : DisplayPair
    session : HandleSession
    counts : (N,) int   Numbers of axes.
    """
    rivals = pair.conventionals
    displays = (*WAYS, *rivals)
    shape = (len(displays), len(counts))
    energy = np.zeros((*shape, len(PARTS) + 1))
    user, winding, heating = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    limit, steering, stop = np.full(shape, "", dtype=object), np.zeros(len(counts)), np.zeros(len(counts))
    shares, time = session.shares, session.round_time
    resting, able = stopped_part(pair.cobotic), _unable(pair, session)
    for place, count in enumerate(counts):
        started = _started(pair, count, 1.0)
        slower, turning = _turning(pair, session, count)
        stop[place] = started / (turning["idle"].supply - resting.supply)
        steering[place] = sum(time * shares[part] * turning[part].steering for part in PARTS if shares[part] > 0.0)
        together = _together(pair, session, count)
        for row, display in enumerate(displays):
            cobotic = display in _STOPS
            stops = _STOPS.get(display, ())
            found = (
                turning | dict.fromkeys(stops, resting)
                if cobotic
                else {part: _of_rival(pair, rivals[display], session, part, count) for part in PARTS}
            )
            cells = _round(found, shares, time, pair.standby_power * (count + cobotic))
            # One run-up for each part at rest; a session that is nothing but rest never runs up.
            stopped = [part for part in stops if 0.0 < shares[part] < 1.0]
            restarted = started * len(stopped) if sum(shares[part] for part in stopped) < 1.0 else 0.0
            if cobotic:
                kept = [slower[part] for part in PARTS if shares[part] > 0.0 and part not in stops]
                restarted += _quickened(pair, count, kept)
            energy[row, place] = [*cells["energy"], restarted]
            user[row, place], winding[row, place] = cells["user"], cells["winding"]
            heating[row, place] = math.sqrt(cells["heating"])
            who = "cobotic" if cobotic else display
            reasons = (
                (able[who], able[who]),
                ("force and speed of all axes at once", not together[who]),
                (cells["limit"], cells["tightest"] > 1.0),
                ("motor continuous torque", cells["heating"] > 1.0),
            )
            limit[row, place] = next((words for words, exceeded in reasons if exceeded), "")
    return {
        "energy": energy,
        "steering": steering,
        "user": user,
        "winding": winding,
        "heating": heating,
        "feasible": limit == "",
        "limit": limit,
        "stop": stop,
    }


def _turning(pair: DisplayPair, session: HandleSession, count: int) -> tuple[dict[str, float], dict[str, PartPower]]:
    """Speed of the cylinder over that set, and the powers, of each part of a session."""
    factors = (1.0,) if pair.cylinder == "set" else _SLOWER
    speeds, powers = {}, {}
    for part in PARTS:
        for factor in factors:
            found = cobotic_part(
                replace(pair.cobotic, cylinder_speed=factor * pair.cobotic.cylinder_speed),
                session,
                part,
                axes=count,
                handle_mass=pair.handle_mass,
                slip_feedforward=pair.slip_feedforward,
            )
            within = found.tightest <= 1.0 and math.isfinite(found.supply)
            if part not in powers or (within and found.supply < powers[part].supply):
                speeds[part], powers[part] = factor, found
    return speeds, powers


def _started(pair: DisplayPair, count: int, factor: float) -> float:
    """Energy of a run-up from rest to a share of the speed set. [J]"""
    leg = replace(pair.cobotic, cylinder_speed=factor * pair.cobotic.cylinder_speed)
    return run_up_energy(LeggedDrive.of(leg, count), pair.run_up_time)


def _quickened(pair: DisplayPair, count: int, factors: Sequence[float]) -> float:
    """Energy to raise the speed from part to part; what a slower part gives back is lost. [J]"""
    if len({*factors}) < 2:
        return 0.0
    energies = [_started(pair, count, factor) for factor in factors]
    return sum(max(0.0, after - before) for before, after in zip(energies, (*energies[1:], energies[0]), strict=True))


def _of_rival(pair: DisplayPair, rival: Rival, session: HandleSession, part: str, count: int) -> PartPower:
    return geared_part(
        rival.drive,
        session,
        part,
        axes=count,
        handle_mass=pair.handle_mass,
        compensation=pair.compensation,
        friction_helps=pair.friction_helps,
        force_control=rival.force_control,
    )


def _together(pair: DisplayPair, session: HandleSession, count: int) -> dict[str, bool]:
    """Whether all axes of each display reach the speed required under the force required, at once and for any time."""
    speed, force = session.required_speed_at_force, session.required_force
    if not speed:
        return dict.fromkeys(("cobotic", *pair.conventionals), True)
    leg = pair.cobotic
    drag, _ = leg.guideway.operate(force=force, speed=speed, preload=leg.transmission.unbalanced_preload)
    element = leg.transmission.deliver(cylinder_speed=leg.cylinder_speed, link_speed=speed, link_force=force + drag)
    rubbing, _ = leg.turned(leg.cylinder_speed, element.torque, force + drag, legs=count)
    side = motor_side(
        leg.motor,
        leg.gearhead,
        output_torque=count * np.asarray(element.torque) + rubbing,
        output_speed=np.asarray(float(leg.cylinder_speed)),
    )
    demands = {**element.utilisation, **side.utilisation}
    return {
        "cobotic": all(float(np.asarray(demand)) <= 1.0 for demand in demands.values()),
        **{
            name: bool(one.drive.operate(speed=speed, force=force).limit == Limit.OK)
            for name, one in pair.conventionals.items()
        },
    }


def _unable(pair: DisplayPair, session: HandleSession) -> dict[str, str]:
    """What an axis of each display does not reach of force and speed required; "" if it reaches both."""
    drives = {"cobotic": pair.cobotic, **{name: one.drive for name, one in pair.conventionals.items()}}
    strong = {"cobotic": float(pair.cobotic.transmission.slip_force) > session.largest_force}
    for name, one in pair.conventionals.items():
        strong[name] = one.motors.gain * float(one.drive.motor.continuous_current) >= session.largest_force
    found = {}
    for name, drive in drives.items():
        fast = drive.operate(speed=session.required_speed, force=0.0).limit == Limit.OK
        found[name] = "" if fast and strong[name] else "largest force of an axis" if fast else "speed of an axis"
    return found


def _round(found: Mapping[str, PartPower], shares: Mapping[str, float], time: float, standby: float) -> dict[str, Any]:
    """Sums over a round, with standby power; parts without a share do not count, even beyond a limit."""
    kept = {part: found[part] for part in PARTS if shares[part] > 0.0}

    def mean(name: str) -> float:
        return sum(shares[part] * getattr(power, name) for part, power in kept.items())

    return {
        "energy": [time * shares[part] * (found[part].supply + standby) if part in kept else 0.0 for part in PARTS],
        "user": time * mean("user"),
        "winding": max(mean("winding"), mean("steering_winding")),
        "heating": max(mean("heating"), mean("steering_heating")),
        "tightest": max(map(_tightest, kept.values())),
        "limit": Limit(max(kept.values(), key=_tightest).limit).words,
    }


def _tightest(power: PartPower) -> float:
    return power.tightest if math.isfinite(power.supply) else math.inf
