"""Scalar outcomes of a design as functions of the drive, over any array namespace.

Outcomes can be differentiated exactly and evaluated for many designs at once: a drive whose values are arrays with a last
axis of length 1 gives an array of the leading axes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from infinivar import power
from infinivar._core.array_namespace import Array, namespace
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.duty_cycle import duty_cycle, warmed
from infinivar.analysis.cycles.performance import AnyDrive, heating, motors_of
from infinivar.analysis.plane import place
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import MovingPoint
from infinivar.errors import InputError, ParameterError, nearest
from infinivar.limits import Demand, Limit, binding, words_of
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.parts import heat
from infinivar.study.requirement import Requirement
from infinivar.study.study import Study
from infinivar.units import times

COVERAGE_LINES = 41
"""Number of lines of constant force on which coverage is computed, and of points on each."""


def _within(drive: AnyDrive) -> str:
    return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A scalar result that ranks designs.

    Attributes
    ----------
    name, unit, words   For file names, values and reports.
    better              1 if higher is better, -1 if lower is better.
    of                  Function of a drive; nan if infeasible.
    beyond              Function of a drive: the limits it exceeds, in words; "" if none.
    of_limits           Whether the outcome measures limits, and so remains meaningful beyond them.
    """

    name: str
    unit: str
    words: str
    better: int
    of: Callable[[AnyDrive], Array]
    beyond: Callable[[AnyDrive], str] = _within
    of_limits: bool = False


KINDS = ("efficiency", "loss", "margin", "coverage", "energy", "temperature")


def outcome(
    study: Study, kind: str, *, speed: float | None = None, force: float | None = None, duty: str | None = None
) -> Outcome:
    """Make an outcome for the drives of a study.

    Parameters
    ----------
    study : Study
    kind : str           efficiency or loss at an operating point; margin or coverage in the required region; energy or
        temperature in a duty cycle, settled and warm.
    speed, force         Operating point; by default the requirement's corner of maximum force. [m s^-1], [N], or [rad s^-1],
        [N m] about a joint
    duty : str           Of energy and temperature: name of the duty cycle; may be omitted if the study has only one.

    Raises
    ------
    InputError
        If the kind or the duty cycle does not exist, or the outcome needs a requirement that the study lacks.
    """
    if kind not in KINDS:
        raise InputError(f"{kind!r} is not one of {', '.join(KINDS)}{nearest(kind, KINDS)}")
    if duty is not None and kind not in ("energy", "temperature"):
        raise InputError(f"duty applies to energy and temperature; {kind} is no result of a duty cycle")
    if kind in ("efficiency", "loss"):
        return _at_point(study, kind, speed, force)
    if kind in ("margin", "coverage"):
        return _over_region(study.required(kind), kind)
    return _over_cycle(study, kind, duty)


def _at_point(study: Study, kind: str, speed: float | None, force: float | None) -> Outcome:
    if speed is None or force is None:
        corner = study.required(f"{kind} without {study.axis.speed if speed is None else study.axis.force}")
        corner_speed, corner_force = corner.corners()["maximum force"]
        speed, force = corner_speed if speed is None else speed, corner_force if force is None else force
    at = (speed, force)
    where = f"at {place(study.axis, force, speed)}"
    outside = functools.partial(_beyond_at, speed=at[0], force=at[1])
    if kind == "efficiency":
        of = functools.partial(efficiency, speed=at[0], force=at[1])
        return Outcome(name=kind, unit="1", words=f"efficiency {where}", better=1, of=of, beyond=outside)
    of = functools.partial(loss, speed=at[0], force=at[1])
    return Outcome(name=kind, unit="W", words=f"loss {where}", better=-1, of=of, beyond=outside)


def _over_region(required: Requirement, kind: str) -> Outcome:
    words, of = {
        "margin": ("tightest margin in the required region", functools.partial(margin, required=required)),
        "coverage": ("covered share of the required region", functools.partial(coverage, required=required)),
    }[kind]
    outside = functools.partial(_beyond_over, required=required)
    return Outcome(name=kind, unit="1", words=words, better=1, of=of, beyond=outside, of_limits=True)


def _over_cycle(study: Study, kind: str, duty: str | None) -> Outcome:
    if duty is None and len(study.duty) == 1:
        duty = next(iter(study.duty))
    if duty is None or duty not in study.duty:
        known = ", ".join(study.duty) or "none; add a table [duty.NAME]"
        missing = "choose one with duty" if study.duty else "a duty cycle is missing"
        said = missing if duty is None else f"unknown duty cycle {duty!r}{nearest(duty, study.duty)}"
        raise InputError(f"{kind}: {said}; duty cycles of the study: {known}")
    motion = study.duty[duty]
    outside = functools.partial(_beyond_in, duty=motion, travel=study.travel)
    if kind == "energy":
        words, of = f"energy {motion.per} of {motion.title or duty}", functools.partial(energy, duty=motion)
        return Outcome(name=kind, unit="J", words=words, better=-1, of=of, beyond=outside)
    words = f"highest winding temperature above ambient in {motion.title or duty}"
    of = functools.partial(temperature, duty=motion)
    return Outcome(name=kind, unit="K", words=words, better=-1, of=of, beyond=outside)


def _beyond_at(drive: AnyDrive, speed: float, force: float) -> str:
    """Limits exceeded at an operating point."""
    point = drive.operate(speed=speed, force=force)
    return _exceeded({(limit, "motor"): float(demand) for limit, demand in point.utilisation.items()})


def _beyond_over(drive: AnyDrive, required: Requirement) -> str:
    """Limits exceeded anywhere in the required region."""
    speed, force, _ = required.sample(COVERAGE_LINES)
    found = drive.operate(speed=speed, force=force).utilisation
    return _exceeded({(limit, "motor"): float(np.fmax.reduce(np.ravel(demand))) for limit, demand in found.items()})


def _beyond_in(drive: AnyDrive, duty: DutyCycle, travel: float | None) -> str:
    """Limits exceeded and windings overheated in a duty cycle."""
    done = duty_cycle(drive, duty, travel=travel)
    hot = [
        f"{what} {found.verdict}" for what, found in done.heat.items() if found is not None and not found.within_limit
    ]
    return "; ".join([clause for clause in [_exceeded(done.demands), *hot] if clause])


def _exceeded(demands: Mapping[Demand, float]) -> str:
    beyond = sorted(((demand, words_of(key)) for key, demand in demands.items() if demand > 1.0), reverse=True)
    return ", ".join(f"{words} at {times(demand)} the allowance" for demand, words in beyond)


def efficiency(drive: AnyDrive, speed: float, force: float) -> Array:
    """Efficiency at an operating point, regardless of limits; nan where the wheel slips. [-]"""
    point = drive.operate(speed=np.asarray([speed]), force=np.asarray([force]))
    return power.efficiency(point.power_in, point.power_out + 0.0 * point.power_in)[..., 0]


def loss(drive: AnyDrive, speed: float, force: float) -> Array:
    """Total loss between supply and load at an operating point. [W]"""
    point = drive.operate(speed=np.asarray([speed]), force=np.asarray([force]))
    return (point.power_in - point.power_out)[..., 0]


def margin(drive: AnyDrive, required: Requirement) -> Array:
    """Tightest margin in the required region, allowance over demand. [-]"""
    return region(drive, required)[1]


def coverage(drive: AnyDrive, required: Requirement) -> Array:
    """Share of the required region within every limit; changes smoothly with the design. [-]

    On lines of constant force the margin is interpolated linearly between points; a limit lies where it equals 1.
    """
    return region(drive, required)[0]


def region(drive: AnyDrive, required: Requirement) -> tuple[Array, Array]:
    """Coverage and tightest margin together, as `coverage` and `margin` return them. [-]"""
    speed, force, _ = required.sample(COVERAGE_LINES)
    lines = speed.reshape(-1, COVERAGE_LINES)
    reach = np.abs(lines[:, -1])
    heights = np.abs(force.reshape(-1, COVERAGE_LINES)[:, 0])
    _, found = binding(drive.operate(speed=speed, force=force).utilisation)
    xp = namespace(found)
    # Clipping at twice the allowance leaves linear crossings in place.
    over = xp.clip(found, 0.0, 2.0) - 1.0
    over = xp.reshape(over, (*over.shape[:-1], *lines.shape))
    inside = xp.clip(over, 0.0, 1.0)
    size = xp.abs(over) + 1e-300
    share = (inside[..., 1:] + inside[..., :-1]) / (size[..., 1:] + size[..., :-1])
    along = xp.mean(share, axis=-1)
    weight = _trapezoid(heights) * reach
    return xp.sum(along * (weight / weight.sum()), axis=-1), -xp.max(-found, axis=-1)


def _trapezoid(heights: np.ndarray) -> np.ndarray:
    """Width represented by each line; quadrants follow one another."""
    quadrants = np.split(heights, np.flatnonzero(np.diff(heights) < 0) + 1)
    halves = [0.5 * np.diff(one) for one in quadrants]
    return np.concatenate([np.append(half, 0.0) + np.append(0.0, half) for half in halves])


def energy(drive: AnyDrive, duty: DutyCycle) -> Array:
    """Energy from the supply per cycle or over the run, windings at their mean temperature if data sheets allow it. [J]"""
    point, _ = _settled(drive, duty)
    drawn = point.power_in + 0.0 * point.power_out
    return namespace(drawn).mean(drawn, axis=-1) * duty.period


def temperature(drive: AnyDrive, duty: DutyCycle) -> Array:
    """Highest winding temperature of any motor above ambient, by `infinivar.parts.heat.settled`. [K]

    Raises
    ------
    ParameterError
        If no motor has the data that the thermal model requires.
    """
    found = [highest for highest, _ in _windings(drive, duty, _follower(drive, duty)(drive)).values()]
    if not found:
        lacking = heat.missing(next(iter(motors_of(drive).values())))
        raise ParameterError(f"motor.{lacking[0]} is missing: the thermal model requires it")
    return functools.reduce(namespace(*found).maximum, found)[..., 0] - duty.ambient


class Worked(NamedTuple):
    """Designs in a duty cycle; of plain numbers if there is one design."""

    energy: Array
    """From the supply per cycle or over the run; nan where the wheel slips. (...) [J]"""
    temperature: Array
    """Highest winding temperature of any motor; nan without thermal data. (...) [K]"""
    able: Array
    """Whether every limit is kept and no winding overheats. (...)"""
    demands: Array
    """Demand over allowance of every limit. (..., k) [-]"""
    limits: tuple[Demand, ...]
    """The limits, in the order of `demands`. (k,)"""


def in_cycle(drive: AnyDrive, duty: DutyCycle, travel: float | None) -> Worked:
    """Evaluate many designs in a duty cycle, over any array namespace; limits are those of `duty_cycle`."""
    point, windings = _settled(drive, duty)
    motors = motors_of(drive)
    found = {**performance.demands(point)}
    if not duty.closed:
        found = {
            key: demand for key, demand in found.items() if key not in {(Limit.THERMAL, what) for what in windings}
        }
    drawn = point.power_in + 0.0 * point.power_out
    xp = namespace(drawn, *found.values())
    if travel is not None:
        found[Limit.TRAVEL, "load"] = xp.asarray(np.ptp(duty.instants().position) / travel)
    drawn = xp.mean(drawn, axis=-1) * duty.period
    demands = xp.stack([demand + xp.zeros(drawn.shape) for demand in found.values()], axis=-1)
    able, hottest = xp.isfinite(drawn) & xp.all(demands <= 1.0, axis=-1), xp.nan + 0.0 * drawn
    for what, (highest, _) in windings.items():
        hot, limit = highest[..., 0], xp.asarray(motors[what].max_winding_temperature)
        hottest = xp.where(xp.isnan(hottest) | (hot > hottest), hot, hottest)
        able = able & (hot <= (limit[..., 0] if limit.ndim else limit))
    drawn, hottest, able = xp.broadcast_arrays(drawn, hottest, able)
    return Worked(drawn, hottest, able, demands, tuple(found))


def worked(drive: AnyDrive, duty: DutyCycle, travel: float | None) -> Array:
    """Energy [J], highest winding temperature [K] and feasibility (1 or 0) of `in_cycle` as one array. (..., 3)"""
    found = in_cycle(drive, duty, travel)
    xp = namespace(found.energy, found.able)
    return xp.stack([found.energy, found.temperature, xp.astype(found.able, xp.float64)], axis=-1)


def _follower(drive: AnyDrive, duty: DutyCycle) -> Callable[[Any], MovingPoint]:
    """How the drive, with windings at any temperature, follows the cycle: what does not depend on motors is computed once."""
    course, mass = duty.instants(orders=drive.orders).course, duty.moved_mass
    options: dict[str, Any] = {"load_mass": mass}
    if type(drive) is CoboticDrive:
        options["rolled"] = drive.roll(course, load_mass=mass)
    return lambda driven: driven.follow(course, **options)


def _windings(drive: AnyDrive, duty: DutyCycle, point: Any) -> dict[str, tuple[Array, Array]]:
    """Highest and mean winding temperature, settled or over the run, of each motor with thermal data. [K]"""
    found = {}
    for what, motor in motors_of(drive).items():
        if not heat.missing(motor):
            current, friction = heating(point, what)
            current = current + np.zeros(duty.instants().time.shape)
            options: dict[str, float] = {"ambient": duty.ambient}
            if duty.closed:
                found[what] = heat.settled(motor, current, friction, duty.period, **options)
            else:
                found[what] = heat.through_run(motor, current, friction, duty.period, start=duty.start, **options)
    return found


def _settled(drive: AnyDrive, duty: DutyCycle) -> tuple[Any, dict[str, tuple[Array, Array]]]:
    """Evaluate the cycle with settled windings; also return their temperatures."""
    follow = _follower(drive, duty)
    point = follow(drive)
    windings = _windings(drive, duty, point)
    if windings:
        # A motor that overheats must be stopped: its winding counts as at the permissible temperature.
        xp = namespace(*(mean for _, mean in windings.values()))
        motors = motors_of(drive)
        warm = {what: xp.minimum(mean, motors[what].max_winding_temperature) for what, (_, mean) in windings.items()}
        point = follow(warmed(drive, warm))
    return point, windings
