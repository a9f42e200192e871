"""Compare a motion prescribed (inverse dynamics) with the same motion simulated under control, and explain the difference."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.simulate import Simulation, simulate
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import ParameterError
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.repeated import Repeated
from infinivar.motion.scenario import Scenario
from infinivar.transmission.rates import Varying
from infinivar.units import percent, plain, signed

LONGEST = 5.0
"""Longest cycle that a report simulates. [s]"""

_LEAD = 1.0
"""Settling time of the controllers before the evaluated cycle; at most one cycle. [s]"""
_NODES = 2000
"""Spline nodes of motion and force over a cycle."""
_STEPS = 400
"""Output steps over a cycle."""

_SMALL = 1e-3
"""Relative energy difference below which no digits are shown."""
_NAMED = 4
"""Number of parts of the difference that are named."""


def _places(size: float) -> int:
    """Number of decimals that shows two significant digits."""
    return max(0, 1 - math.floor(math.log10(size))) if 0.0 < size < math.inf else 0


@result
class TwoWays(Result):
    """Energy of one cycle by inverse dynamics and by simulation, windings at 25 °C.

    Attributes
    ----------
    prescribed, followed : float             Energy from the supply, prescribed and simulated. [J]
    as_turning : float                       Prescribed energy at the simulated cylinder speed; nan if the cylinder stops. [J]
    lost_prescribed, lost_followed           Losses by name. [J]
    rms_error : float                        RMS position error of the load. [m], [rad]
    rotary : bool                            Whether the load moves about a joint.
    stays : bool                             Whether the load rests for part of the cycle.
    speed_ripple : float                     Largest relative deviation of the cylinder speed; 0 without a cylinder. [-]
    stored : float                           Increase over the simulated cycle of the energy in inertias of drive and load. [J]
    """

    prescribed: float
    as_turning: float
    followed: float
    lost_prescribed: Mapping[str, float]
    lost_followed: Mapping[str, float]
    rms_error: float
    stays: bool
    speed_ripple: float
    stored: float
    simulation: Simulation
    rotary: bool = False

    @property
    def explanation(self) -> str:
        """Explanation of the difference between both energies."""
        total = self.followed - self.prescribed
        why = [*self.simulation.warnings, _error(self.rms_error, self.rotary)]
        if self.speed_ripple:
            why.append(
                f"the cylinder speed, prescribed as constant, varies by {percent(self.speed_ripple, 1)} as the cylinder's "
                "inertia stores and returns energy; with the simulated speed prescribed, the difference is "
                f"{signed(self.followed - self.as_turning, 2)} J"
            )
        if self.stays:
            why.append(
                "before a standstill the controllers first bring the load to rest, relying on only part of the friction"
            )
        share = f" ({percent(total / self.prescribed, 1, '+')})" if self.prescribed else ""
        places = _places(max(abs(total), _SMALL * abs(self.followed)))
        parts = self._parts(0.5 * 10.0**-places)
        where = ": " + ", ".join(f"{name} {change:+.{places}f} J" for name, change in parts.items()) if parts else ""
        return f"{total:+.{places}f} J{share}{where}; {'; '.join(why)}"

    def _parts(self, least: float) -> dict[str, float]:
        """Parts of the difference by decreasing size: losses, work on the load, stored energy; `least` is the smallest named. [J]

        The parts add up to the difference because both energy balances close.
        """
        names = dict.fromkeys([*self.lost_prescribed, *self.lost_followed])
        moved = {name: self.lost_followed.get(name, 0.0) - self.lost_prescribed.get(name, 0.0) for name in names}
        moved["stored in inertias"] = self.stored
        moved["work on the load"] = self.followed - self.prescribed - sum(moved.values())
        named = [name for name in sorted(moved, key=lambda name: -abs(moved[name])) if abs(moved[name]) >= least][
            :_NAMED
        ]
        rest = sum(change for name, change in moved.items() if name not in named)
        found = {name: moved[name] for name in named}
        return found if abs(rest) < least else {**found, "other": rest}


def two_ways(drive: AnyDrive, duty: DutyCycle) -> TwoWays:
    """Compute the energy of one cycle by inverse dynamics and by simulation.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive   Must have all values that simulation requires.
    duty : DutyCycle

    Returns
    -------
    TwoWays   The simulated cycle follows a settling time of one second, or one cycle if shorter.

    Raises
    ------
    ParameterError
        If the drive lacks a value that simulation requires, or the motion is a run.
    """
    if not duty.closed:
        raise ParameterError("duty must repeat to be simulated beside inverse dynamics; a run starts in motion")
    period, mass = duty.period, duty.moved_mass
    nodes = np.arange(_NODES) * (period / _NODES)
    position, course = duty.at(nodes)
    push = np.broadcast_to(np.asarray(course.force, dtype=float), nodes.shape)
    step = period / _STEPS
    lead = min(_STEPS, math.ceil(_LEAD / step))
    begin = (_STEPS - lead) * step
    scenario = Scenario(
        title=duty.title,
        duration=(lead + _STEPS) * step,
        output_step=step,
        motion=Repeated(period, position, begin, duty.axis),
        force=Repeated(period, push, begin, duty.axis) if np.any(push) else None,
        load_mass=None if duty.axis.rotary else mass or None,
        load_inertia=mass or None if duty.axis.rotary else None,
    )
    run = simulate(drive, scenario)
    instants = duty.instants(orders=drive.orders)
    point = drive.follow(instants.course, load_mass=mass)
    first = min(lead, len(run.trajectory.time) - 1)

    def over(values: Any) -> float:
        return float(values[-1] - values[first])

    trajectory = run.trajectory
    position_error = run.position_error[first:]
    prescribed = as_turning = float(np.mean(point.power_in)) * period
    ripple = 0.0
    if isinstance(drive, CoboticDrive):
        turning = run.columns["cylinder_speed_rad_s"][first:]
        ripple = float(np.max(np.abs(turning / drive.cylinder_speed - 1.0)))
        as_turning = _as_turning(drive, duty, turning)
    return TwoWays(
        prescribed=prescribed,
        as_turning=as_turning,
        followed=sum(over(values) for title, values in trajectory.supplied.items() if "supply" in title),
        lost_prescribed=FrozenDict({name: float(np.mean(loss)) * period for name, loss in point.losses.items()}),
        lost_followed=FrozenDict({name: over(values) for name, values in trajectory.lost.items()}),
        rms_error=float(np.sqrt(np.mean(position_error**2))),
        stays=bool(np.mean(np.asarray(instants.course.speed) == 0.0) > 0.02),
        speed_ripple=ripple,
        stored=sum(over(values) for values in trajectory.stored.values()),
        simulation=run,
        rotary=duty.axis.rotary,
    )


def _error(size: float, rotary: bool) -> str:
    return f"RMS angle error {plain(size, 2)} rad" if rotary else f"RMS position error {plain(1e3 * size, 2)} mm"


def _as_turning(drive: CoboticDrive, duty: DutyCycle, turning: np.ndarray) -> float:
    """Energy of a cycle by inverse dynamics at a cylinder speed given in equal time steps. [J]"""
    from scipy.interpolate import CubicSpline

    if len(turning) <= _STEPS or np.min(turning / drive.cylinder_speed) <= 0.0:
        return math.nan
    instants = duty.instants(orders=drive.orders)
    nodes = np.linspace(0.0, duty.period, len(turning))
    speed = CubicSpline(nodes, np.append(turning[:-1], turning[0]), bc_type="periodic")
    varying = Varying(speed(instants.time), speed(instants.time, 1))
    point = drive.follow(instants.course, load_mass=duty.moved_mass, cylinder_speed=varying)
    return float(np.mean(point.power_in)) * duty.period
