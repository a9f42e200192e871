"""Single numbers that a design comes to, as functions of the drive over any array namespace.

They can be differentiated exactly and evaluated for many designs at once: a drive whose values are arrays with a last axis
of length 1 gives an array of the leading axes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar import power
from infinivar._core.array_namespace import Array, namespace
from infinivar.analysis.cycles import performance
from infinivar.analysis.cycles.duty_cycle import duty_cycle, heating, motors_of, warmed
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.errors import InputError, ParameterError, nearest
from infinivar.limits import Demand, Limit, binding, words_of
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.parts import heat
from infinivar.study.requirement import Requirement
from infinivar.study.study import Study
from infinivar.units import plain

COVERAGE_LINES = 41
"""Lines of constant force on which coverage is measured, and points along each."""


def _within(drive: AnyDrive) -> str:
    return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A result that a design is judged by.

    Attributes
    ----------
    name, unit, words   For files, numbers and reports.
    better              Whether more of it is better, or less: 1 or -1.
    of                  Of a drive; nan where the drive cannot do it.
    beyond              What a drive exceeds there, in words; "" where it keeps all limits.
    of_limits           Whether the limits are the question, so that it has an answer beyond them, too.
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
    """An outcome of a study's drives.

    Parameters
    ----------
    study : Study
    kind : str           efficiency, loss: at an operating point; margin, coverage: in the required region; energy,
        temperature: of a duty cycle, settled and warm.
    speed, force         Of the operating point; of the corner at maximum force if left out. [m s^-1], [N]
    duty : str           Name of the duty cycle; the only one if left out.

    Raises
    ------
    InputError
        If there is no such kind or duty cycle.
    """
    if kind not in KINDS:
        raise InputError(f"{kind!r} is not one of {', '.join(KINDS)}{nearest(kind, KINDS)}")
    if kind in ("efficiency", "loss"):
        return _at_point(study.requirement, kind, speed, force)
    if kind in ("margin", "coverage"):
        return _over_region(study.requirement, kind)
    return _over_cycle(study, kind, duty)


def _at_point(required: Requirement, kind: str, speed: float | None, force: float | None) -> Outcome:
    corner_speed, corner_force = required.corners()["maximum force"]
    at = (corner_speed if speed is None else speed, corner_force if force is None else force)
    place = f"at {plain(at[1], 3)} N and {plain(at[0], 3)} m/s"
    outside = functools.partial(_beyond_at, speed=at[0], force=at[1])
    if kind == "efficiency":
        of = functools.partial(efficiency, speed=at[0], force=at[1])
        return Outcome(name=kind, unit="1", words=f"efficiency {place}", better=1, of=of, beyond=outside)
    of = functools.partial(loss, speed=at[0], force=at[1])
    return Outcome(name=kind, unit="W", words=f"loss {place}", better=-1, of=of, beyond=outside)


def _over_region(required: Requirement, kind: str) -> Outcome:
    words, of = {
        "margin": ("weakest margin in the required region", functools.partial(margin, required=required)),
        "coverage": ("share of the required region covered", functools.partial(coverage, required=required)),
    }[kind]
    outside = functools.partial(_beyond_over, required=required)
    return Outcome(name=kind, unit="1", words=words, better=1, of=of, beyond=outside, of_limits=True)


def _over_cycle(study: Study, kind: str, duty: str | None) -> Outcome:
    if duty is None and len(study.duty) == 1:
        duty = next(iter(study.duty))
    if duty is None or duty not in study.duty:
        known = ", ".join(study.duty) or "none; add a table [duty.NAME]"
        said = "say which duty cycle" if duty is None else f"there is no duty cycle {duty!r}{nearest(duty, study.duty)}"
        raise InputError(f"{kind}: {said}; the study has {known}")
    motion = study.duty[duty]
    outside = functools.partial(_beyond_in, duty=motion, travel=study.requirement.travel)
    if kind == "energy":
        words, of = f"energy from the supply a cycle of {motion.title or duty}", functools.partial(energy, duty=motion)
        return Outcome(name=kind, unit="J", words=words, better=-1, of=of, beyond=outside)
    words = f"highest winding temperature above the surroundings in {motion.title or duty}"
    of = functools.partial(temperature, duty=motion)
    return Outcome(name=kind, unit="K", words=words, better=-1, of=of, beyond=outside)


def _beyond_at(drive: AnyDrive, speed: float, force: float) -> str:
    """Limits that a drive exceeds at an operating point."""
    point = drive.operate(speed=speed, force=force)
    return _exceeded({(limit, "motor"): float(demand) for limit, demand in point.utilisation.items()})


def _beyond_over(drive: AnyDrive, required: Requirement) -> str:
    """Limits that a drive exceeds anywhere in the required region."""
    speed, force, _ = required.sample(COVERAGE_LINES)
    found = drive.operate(speed=speed, force=force).utilisation
    return _exceeded({(limit, "motor"): float(np.fmax.reduce(np.ravel(demand))) for limit, demand in found.items()})


def _beyond_in(drive: AnyDrive, duty: DutyCycle, travel: float | None) -> str:
    """Limits that a drive exceeds in a duty cycle, and windings that get too hot."""
    done = duty_cycle(drive, duty, travel=travel)
    hot = [f"{what} {found.verdict}" for what, found in done.heat.items() if found is not None and not found.bears]
    return "; ".join([clause for clause in [_exceeded(done.demands), *hot] if clause])


def _exceeded(demands: Mapping[Demand, float]) -> str:
    beyond = sorted(((demand, words_of(key)) for key, demand in demands.items() if demand > 1.0), reverse=True)
    named = ", ".join(f"{words} {plain(demand, 3)} times" for demand, words in beyond)
    return f"{named} what is allowed" if named else ""


def efficiency(drive: AnyDrive, speed: float, force: float) -> Array:
    """Efficiency at an operating point, whether or not limits are kept; nan where the wheel slips. [-]"""
    point = drive.operate(speed=np.asarray([speed]), force=np.asarray([force]))
    return power.efficiency(point.power_in, point.power_out + 0.0 * point.power_in)[..., 0]


def loss(drive: AnyDrive, speed: float, force: float) -> Array:
    """Power lost from supply to load at an operating point. [W]"""
    point = drive.operate(speed=np.asarray([speed]), force=np.asarray([force]))
    return (point.power_in - point.power_out)[..., 0]


def margin(drive: AnyDrive, required: Requirement) -> Array:
    """Weakest margin in the required region, allowance over demand. [-]"""
    return region(drive, required)[1]


def coverage(drive: AnyDrive, required: Requirement) -> Array:
    """Share of the required region in which every limit is kept, to a fraction of a cell: it changes smoothly. [-]

    Along lines of constant force, limits lie between points where the margin, taken as straight there, is 1.
    """
    return region(drive, required)[0]


def region(drive: AnyDrive, required: Requirement) -> tuple[Array, Array]:
    """Coverage and weakest margin, as `coverage` and `margin` tell them one by one. [-]"""
    speed, force, _ = required.sample(COVERAGE_LINES)
    lines = speed.reshape(-1, COVERAGE_LINES)
    reach = np.abs(lines[:, -1])
    heights = np.abs(force.reshape(-1, COVERAGE_LINES)[:, 0])
    _, found = binding(drive.operate(speed=speed, force=force).utilisation)
    xp = namespace(found)
    # Beyond twice the allowance it does not matter how much there is; a linear crossing then stays where it is.
    over = xp.clip(found, 0.0, 2.0) - 1.0
    over = xp.reshape(over, (*over.shape[:-1], *lines.shape))
    inside = xp.clip(over, 0.0, 1.0)
    size = xp.abs(over) + 1e-300
    share = (inside[..., 1:] + inside[..., :-1]) / (size[..., 1:] + size[..., :-1])
    along = xp.mean(share, axis=-1)
    weight = _trapezoid(heights) * reach
    return xp.sum(along * (weight / weight.sum()), axis=-1), -xp.max(-found, axis=-1)


def _trapezoid(heights: np.ndarray) -> np.ndarray:
    """Width that each line stands for; quadrants follow one another."""
    quadrants = np.split(heights, np.flatnonzero(np.diff(heights) < 0) + 1)
    halves = [0.5 * np.diff(one) for one in quadrants]
    return np.concatenate([np.append(half, 0.0) + np.append(0.0, half) for half in halves])


def energy(drive: AnyDrive, duty: DutyCycle) -> Array:
    """Energy from the supply in a cycle, windings at their settled mean temperature where data sheets tell it. [J]"""
    point, _ = _settled(drive, duty)
    drawn = point.power_in + 0.0 * point.power_out
    return namespace(drawn).mean(drawn, axis=-1) * duty.period


def temperature(drive: AnyDrive, duty: DutyCycle) -> Array:
    """Highest winding temperature of any motor above its surroundings, by `infinivar.parts.heat.settled`. [K]

    Raises
    ------
    ParameterError
        If no motor's data sheet has what the thermal model needs.
    """
    found = [highest for highest, _ in _windings(drive, duty, _cold(drive, duty)).values()]
    if not found:
        lacking = heat.missing(next(iter(motors_of(drive).values())))
        raise ParameterError(f"motor.{lacking[0]} is missing: the thermal model needs it")
    return functools.reduce(namespace(*found).maximum, found)[..., 0] - duty.ambient


def worked(drive: AnyDrive, duty: DutyCycle, travel: float | None) -> np.ndarray:
    """What many designs make of a duty cycle: energy [J], highest winding temperature [K] and whether they do it (1 or 0).

    With NumPy only. The temperature is nan where no data sheet tells, the energy where the wheel slips. (..., 3)
    """
    point, windings = _settled(drive, duty)
    motors = motors_of(drive)
    found = {**performance.demands(point)}
    if travel is not None:
        found[Limit.TRAVEL, "load"] = np.asarray(np.ptp(duty.instants().position) / travel)
    drawn = np.mean(point.power_in + 0.0 * point.power_out, axis=-1) * duty.period
    able, hottest = np.isfinite(drawn), np.full(drawn.shape, np.nan)
    for demand in found.values():
        able = able & (demand <= 1.0)
    for what, (highest, _) in windings.items():
        hottest = np.fmax(hottest, highest[..., 0])
        able = able & (highest[..., 0] <= np.ravel(motors[what].max_winding_temperature))
    return np.stack(np.broadcast_arrays(drawn, hottest, able.astype(float)), axis=-1)


def _cold(drive: AnyDrive, duty: DutyCycle) -> Any:
    return drive.follow(duty.instants().course, load_mass=duty.moved_mass)


def _windings(drive: AnyDrive, duty: DutyCycle, point: Any) -> dict[str, tuple[Array, Array]]:
    """Highest and mean settled temperature of each motor whose data sheet tells. [K]"""
    found = {}
    for what, motor in motors_of(drive).items():
        if not heat.missing(motor):
            current, friction = heating(point, what)
            current = current + np.zeros(duty.instants().time.shape)
            found[what] = heat.settled(motor, current, friction, duty.period, duty.ambient)
    return found


def _settled(drive: AnyDrive, duty: DutyCycle) -> tuple[Any, dict[str, tuple[Array, Array]]]:
    """The cycle with windings as warm as they get, and their temperatures."""
    point = _cold(drive, duty)
    windings = _windings(drive, duty, point)
    if windings:
        # A motor that would get hotter has to be stopped: it is as warm as it may be.
        xp = namespace(*(mean for _, mean in windings.values()))
        motors = motors_of(drive)
        warm = {what: xp.minimum(mean, motors[what].max_winding_temperature) for what, (_, mean) in windings.items()}
        point = warmed(drive, warm).follow(duty.instants().course, load_mass=duty.moved_mass)
    return point, windings
