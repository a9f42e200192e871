"""Radii at which candidates can keep each limit, and the least power that they can draw; see `radius_bounds`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.limits import ROOT_MEAN_SQUARE, Demand, Limit
from infinivar.parts.gearhead import LAWS
from infinivar.parts.linear import Pulley
from infinivar.sizing.geared import closed_form
from infinivar.sizing.geared.candidates import Candidates
from infinivar.sizing.geared.closed_form import Linear, Warmth, friction_factors, warmth
from infinivar.sizing.geared.extremes import braking_places, extreme_places, least_places
from infinivar.sizing.geared.radius_bounds import Laurent, Radii, Resting, all_below, mean_square_below
from infinivar.sizing.geared.sampled import HOT
from infinivar.sizing.geared.tally import SPARE
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task, heat_counts

_AT_ONCE = 512
"""Candidates whose power is bounded together, so that intermediate arrays stay small."""
_CELLS = 48
"""Cells of a range of radii, in each of which the power is bounded."""
_LOOKS = (0.05, 0.35, 0.65, 0.95)
"""Radii at which the bound of the power is exact, as shares of a range on a logarithmic scale."""
_NOT_OF_PEAK_CURRENT = frozenset({Limit.THERMAL, Limit.VOLTAGE, Limit.SPEED})
"""Limits of a motor that do not bound its largest current."""
_BEYOND = 1e100
"""Stands for no bound; its square is still a number."""


class Load(NamedTuple):
    """What a task asks of a pulley of any radius of a range."""

    task: Task
    moving: np.ndarray
    """Force, acceleration and speed with the motion. (n, 3) [N], [m s^-2], [m s^-1]"""
    resting: np.ndarray
    """Size of the force at each instant at rest, in rising order. (m,) [N]"""
    drives: np.ndarray
    """Instants at which the motor drives at every radius; for constant gear friction, all of them. (n,) bool"""
    brakes: np.ndarray
    """Instants at which the load drives at every radius. (n,) bool"""
    others: dict[Demand, float]
    """Demands that depend on no candidate. [-]"""
    range: tuple[float, float]
    """Least and largest radius. [m]"""
    friction: float
    """Of the pulley. [N m]"""
    inertia: float
    """At the gear output. [kg m^2]"""

    @property
    def instants(self) -> int:
        """Number of instants."""
        return len(self.moving) + len(self.resting)


class WithResistance(NamedTuple):
    """Candidates with the values that a task needs."""

    drive: ConventionalDrive
    current: Linear
    heated: np.ndarray
    """Whether the winding temperature is known, and sets the resistance. (k,) bool"""
    low: np.ndarray
    high: np.ndarray
    """Least and largest resistance. (k,) [ohm]"""


def load_of(found: Candidates, task: Task, radii: tuple[float, float]) -> Load:
    """What a task asks of the pulley of the template, at any radius of a range."""
    template = found.template
    assert template.pulley is not None
    friction, inertia = template.pulley.shaft_friction, template.gear_output_inertia
    signals = task.signals(replace(template, output_inertia=None), Pulley(radius=1.0))
    force, acceleration, _ = signals.moving.T
    if not LAWS[found.loss_model].OF_LOAD:
        drives, brakes = np.ones(len(force), dtype=bool), np.zeros(len(force), dtype=bool)
    else:
        ends = np.array(radii)
        terms = force[:, None] * ends, inertia * acceleration[:, None] / ends
        drives = terms[0].min(axis=-1) + terms[1].min(axis=-1) + friction > 0.0
        brakes = terms[0].max(axis=-1) + terms[1].max(axis=-1) + friction <= 0.0
    return Load(task, signals.moving, signals.resting, drives, brakes, dict(signals.others), radii, friction, inertia)


def with_resistances(found: Candidates, task: Task, rows: np.ndarray) -> WithResistance:
    """Candidates with the values that a task needs."""
    assert found.template.pulley is not None
    heated, low, high = found.resistances(rows, task.coldest if isinstance(task, MotionTask) else np.nan)
    drive = closed_form.with_resistance(found.drives(rows, found.template.pulley), low)
    return WithResistance(drive, closed_form.linear(drive), heated, low, high)


def limits(found: Candidates, load: Load, rows: np.ndarray) -> Iterator[tuple[Demand, Radii]]:
    """Yield each limit with the radii at which candidates can keep it, in the order of `closed_form.demands`.

    Exact for constant gear friction, or without friction and inertia of the pulley, unless a winding temperature sets the
    resistance; else intervals that contain these radii.
    """
    low, high = load.range
    full = Radii(np.full(len(rows), low), np.full(len(rows), high))
    for key, demand in load.others.items():
        yield key, full if demand <= 1.0 else Radii(full.high + 1.0, full.low)
    who = with_resistances(found, load.task, rows)
    largest = float(load.moving[:, 2].max(initial=0.0))
    turning = largest * np.ravel(who.drive.gearhead.ratio)
    yield (
        (Limit.GEAR_SPEED, "gearhead"),
        full.both(_slow(turning, found.allowance(Limit.GEAR_SPEED, rows), high)),
    )
    for limit, unit in who.drive.gearhead.utilisation(1.0, 0.0).items():
        if limit == Limit.GEAR_SPEED:
            continue
        lasting = limit in ROOT_MEAN_SQUARE and load.task.root_mean_square
        gears, place = np.unique(1.0 / np.ravel(unit), return_inverse=True)
        each = _gear_torque(load, gears, lasting=lasting)
        yield (limit, "gearhead"), full.both(Radii(each.low[np.ravel(place)], each.high[np.ravel(place)]))
    yield (Limit.SPEED, "motor"), full.both(_slow(turning, found.allowance(Limit.SPEED, rows), high))
    yield (Limit.THERMAL, "motor"), full.both(_thermal(found, load, who, rows))
    for limit in who.drive.motor.ALLOWANCES:
        if limit not in _NOT_OF_PEAK_CURRENT and found.stated((limit, "motor"), rows).any():
            yield (limit, "motor"), full.both(_peak_current(load, who, _allowance(who.drive, limit)))
    yield (Limit.VOLTAGE, "motor"), full.both(_voltage(load, who))
    warm = warmth(found, load.task, rows)
    if warm is not None:
        cool = _cool(load, who, warm)
        yield HOT, full.both(Radii(np.where(warm.hopeless, np.inf, cool.low), cool.high))


def _slow(turning: np.ndarray, most: np.ndarray, high: float) -> Radii:
    """Radii from which a motor speed is within its bound: it falls as the radius grows."""
    least = np.where(np.isnan(most), 0.0, turning / (np.where(np.isnan(most), 1.0, most) * (1.0 + SPARE)))
    return Radii(least, np.full(len(least), high))


def _allowance(drive: ConventionalDrive, limit: Limit) -> np.ndarray:
    """Current that a limit of the motor allows. (k,) [A]"""
    found = np.ravel(drive.motor.utilisation(current=np.ones((1, 1)), voltage=0.0, speed=0.0)[limit])
    return 1.0 / np.maximum(found, 1.0 / _BEYOND)


def _gear_torque(load: Load, most: np.ndarray, *, lasting: bool) -> Radii:
    """Radii at which the output torque of gears is within bounds; inf is none."""
    bound, ones = np.minimum(most, _BEYOND) * (1.0 + SPARE), np.ones(len(most))
    if lasting:
        moving = _mean_square(
            _gram(load.moving, load.instants), ones, load.inertia * ones, 0.0 * ones, load.friction * ones
        )
        resting = _resting(load, ones, load.friction * ones)
        return mean_square_below(moving, resting, bound * bound, load.range)
    factors = (ones, load.inertia * ones, 0.0 * ones, load.friction * ones)
    return _peaks(load, [(load.moving, factors)], [(load.moving, factors)], (ones, load.friction * ones), bound)


def _peaks(
    load: Load,
    above: list[tuple[np.ndarray, tuple[np.ndarray, ...]]],
    under: list[tuple[np.ndarray, tuple[np.ndarray, ...]]],
    rest: tuple[np.ndarray, np.ndarray],
    bound: np.ndarray,
) -> Radii:
    """Radii at which a signal that is linear in y stays between bounds, in motion and at rest.

    Parameters
    ----------
    above, under   Points and factors, for the upper and the lower bound.
    rest           A and C >= 0 at rest, where the signal is ``max(A F r - C, 0)``.
    """
    found = Radii(np.zeros(len(bound)), np.full(len(bound), np.inf))
    for sign, parts in ((1.0, above), (-1.0, under)):
        for points, factors in parts:
            found = found.both(all_below(points, factors, bound, sign=sign))
    if load.resting.size:
        linear, friction = rest
        with np.errstate(divide="ignore"):
            most = (bound + friction) / (linear * float(load.resting[-1]))
        found = found.both(Radii(np.zeros(len(bound)), most))
    return found


def constants(load: Load, current: Linear, slope: np.ndarray) -> tuple[np.ndarray, ...]:
    """Factors of the current in ``A r + B/r + C``, with the slope while the motor or while the load drives."""
    return slope, slope * load.inertia + current.inertia, current.viscous, current.friction + slope * load.friction


def _sides(load: Load, current: Linear) -> tuple[list, list]:
    """Points and factors of the current: as it is the larger of its two forms, both bound it from above everywhere."""
    driving = constants(load, current, current.drive)
    if load.drives.all():
        return [(load.moving, driving)], [(load.moving, driving)]
    braking = constants(load, current, current.brake)
    above = [(load.moving, driving), (load.moving, braking)]
    return above, [(load.moving[load.drives], driving), (load.moving[load.brakes], braking)]


def _rest(load: Load, current: Linear) -> tuple[np.ndarray, np.ndarray]:
    """A and C of the current at rest."""
    return current.brake, current.brake * load.friction + current.friction


def _peak_current(load: Load, who: WithResistance, bound: np.ndarray) -> Radii:
    above, under = _sides(load, who.current)
    return _peaks(load, above, under, _rest(load, who.current), bound * (1.0 + SPARE))


def _voltage(load: Load, who: WithResistance) -> Radii:
    """Radii at which the voltage can be within the supply's, at the least or the largest resistance."""
    supply = np.ravel(who.drive.motor.voltage) * (1.0 + SPARE)

    def at(resistance: np.ndarray) -> Radii:
        def volts(parts: list) -> list:
            return [
                (points, (resistance * a, resistance * b, resistance * c + who.current.back_emf, resistance * d))
                for points, (a, b, c, d) in parts
            ]

        above, under = _sides(load, who.current)
        rest = tuple(resistance * one for one in _rest(load, who.current))
        return _peaks(load, volts(above), volts(under), rest, supply)  # type: ignore[arg-type]

    found = at(who.low)
    return found.either(at(who.high)) if (who.heated & (who.high != who.low)).any() else found


def _thermal(found: Candidates, load: Load, who: WithResistance, rows: np.ndarray) -> Radii:
    """Radii within the continuous torque: of the root mean square in a motion, of every point in the required region."""
    bound = _allowance(who.drive, Limit.THERMAL) * (1.0 + SPARE)
    if not load.task.root_mean_square:
        return _peak_current(load, who, bound / (1.0 + SPARE))
    made = mean_square_below(
        current_square(load, who.current), _resting_current(load, who.current), bound * bound, load.range
    )
    if not heat_counts(load.task):
        return made
    spared = found.stated(HOT, rows)
    return Radii(np.where(spared, load.range[0], made.low), np.where(spared, load.range[1], made.high))


def _gram(points: np.ndarray, count: int) -> np.ndarray:
    """Means over all instants of products of (y, 1). (4, 4)"""
    columns = np.concatenate([points, np.ones((len(points), 1))], axis=-1)
    return columns.T @ columns / max(count, 1)


def _mean_square(
    m: np.ndarray, first: np.ndarray, second: np.ndarray, third: np.ndarray, constant: np.ndarray
) -> Laurent:
    """Mean of ``(A r + B/r + C)^2`` as a function of r, from means of products (..., 4, 4) and factors as in `all_below`."""
    return Laurent(
        first * first * m[..., 0, 0],
        2.0 * constant * first * m[..., 0, 3],
        constant * constant * m[..., 3, 3] + 2.0 * first * (second * m[..., 0, 1] + third * m[..., 0, 2]),
        2.0 * constant * (second * m[..., 1, 3] + third * m[..., 2, 3]),
        second * second * m[..., 1, 1] + 2.0 * second * third * m[..., 1, 2] + third * third * m[..., 2, 2],
    )


def _cool(load: Load, who: WithResistance, warm: Warmth) -> Radii:
    """Radii at which the lower bound of the winding temperature is permissible."""
    factor = warm.by_winding * who.low
    linear, square = friction_factors(who.drive)
    speeds = load.moving[:, 2]
    zero = np.zeros(len(factor))
    rubbed = Laurent(
        zero,
        zero,
        zero,
        warm.by_friction * linear * (speeds.sum() / max(load.instants, 1)),
        warm.by_friction * square * (speeds @ speeds / max(load.instants, 1)),
    )
    resting, root = _resting_current(load, who.current), np.sqrt(factor)
    resting = resting._replace(linear=root * resting.linear, friction=root * resting.friction)
    moving = current_square(load, who.current).times(factor).plus(rubbed)
    return mean_square_below(moving, resting, np.where(warm.known, 1.0, _BEYOND), load.range)


def _mechanical(
    m: np.ndarray, first: np.ndarray, second: np.ndarray, third: np.ndarray, constant: np.ndarray
) -> Laurent:
    """Mean of ``|v|/r (A r + B/r + C)`` as a function of r; arguments as for `_mean_square`."""
    zero = np.zeros_like(first)
    return Laurent(
        zero,
        zero,
        first * m[..., 2, 0],
        constant * m[..., 2, 3],
        second * m[..., 2, 1] + third * m[..., 2, 2],
    )


def _resting(load: Load, linear: np.ndarray, friction: np.ndarray) -> Resting:
    powers = np.stack([np.ones_like(load.resting), load.resting, load.resting**2], axis=-1)
    sums = np.concatenate([np.cumsum(powers[::-1], axis=0)[::-1], np.zeros((1, 3))])
    return Resting(load.resting, sums, max(load.instants, 1), linear, friction)


def _resting_current(load: Load, current: Linear) -> Resting:
    return _resting(load, *_rest(load, current))


def current_square(load: Load, current: Linear) -> Laurent:
    """Mean square of the current in motion, without the instants whose direction of power depends on the radius. [A^2]"""
    driving, braking = (_gram(load.moving[chosen], load.instants) for chosen in (load.drives, load.brakes))
    found = _mean_square(driving, *constants(load, current, current.drive))
    return found.plus(_mean_square(braking, *constants(load, current, current.brake)))


def least_power(found: Candidates, load: Load, rows: np.ndarray, bounds: Radii) -> np.ndarray:
    """Lower bound of the mean power from the supply over radii of each candidate. (k,) [W]

    The supply gives at least the mean of the motor's power over any choice of instants, the others counting as 0; of power that
    is fed back, at least its mean over all. For a choice that does not change with the radius that is a `Laurent` of the radius.
    Chosen are the instants of positive power at a few radii of each candidate, where the bound thus is exact at 25 °C.
    """
    least = np.empty(len(rows))
    for start in range(0, len(rows), _AT_ONCE):
        some = slice(start, start + _AT_ONCE)
        least[some] = _least_power(found, load, rows[some], Radii(bounds.low[some], bounds.high[some]))
    return least


def _least_power(found: Candidates, load: Load, rows: np.ndarray, bounds: Radii) -> np.ndarray:
    who = with_resistances(found, load.task, rows)
    rest = (who.low * _resting_current(load, who.current).at(bounds.low)[0])[:, None]
    edges = bounds.low[:, None] * (bounds.high / bounds.low)[:, None] ** np.linspace(0.0, 1.0, _CELLS + 1)
    sides = [
        (chosen, constants(load, who.current, slope))
        for chosen, slope in ((load.drives, who.current.drive), (load.brakes, who.current.brake))
    ]
    unsure = ~(load.drives | load.brakes)

    def power(grams: list[np.ndarray]) -> Laurent:
        total = None
        for gram, (_, factors) in zip(grams, sides, strict=True):
            winding, shaft = _mean_square(gram, *factors), _mechanical(gram, *factors)
            one = winding.times(who.low).plus(shaft.times(who.current.back_emf))
            total = one if total is None else total.plus(one)
        assert total is not None
        return total

    # The current is the larger of two forms, so that either bounds the mechanical power of unsure instants from below.
    everything = power([_gram(load.moving[chosen], load.instants) for chosen, _ in sides]).plus(
        _mechanical(_gram(load.moving[unsure], load.instants), *sides[1][1]).times(who.current.back_emf)
    )
    fed_back = everything.least_in(edges) + rest
    drawn = np.maximum(fed_back, 0.0)
    products = np.einsum("ni,nj->nij", *[np.concatenate([load.moving, np.ones((len(load.moving), 1))], axis=-1)] * 2)
    for share in _LOOKS:
        radius = bounds.low * (bounds.high / bounds.low) ** share
        grams = [
            np.tensordot(_positive(load, who, factors, radius, chosen), products[chosen], 1) / max(load.instants, 1)
            for chosen, factors in sides
        ]
        drawn = np.maximum(drawn, power(grams).least_in(edges) + rest)
    return closed_form.supplied(found.template.amplifier, fed_back, drawn).min(axis=-1)


def _positive(
    load: Load, who: WithResistance, factors: tuple[np.ndarray, ...], radius: np.ndarray, chosen: np.ndarray
) -> np.ndarray:
    """Where the power of the motor is positive at a radius of each candidate, among chosen instants. (k, n) of 0 and 1"""
    first, second, third, constant = factors
    points = load.moving[chosen]
    slopes = np.stack([first * radius, second / radius, third / radius], axis=-1)
    current = slopes @ points.T + constant[:, None]
    emf = (who.current.back_emf / radius)[:, None] * points[:, 2]
    return (current * (current * who.low[:, None] + emf) > 0.0).astype(float)


def region_points(task: RegionTask, template: ConventionalDrive) -> RegionTask:
    """Points of a required region that decide whether a candidate keeps its limits, at whatever radius."""
    points = task.signals(replace(template, output_inertia=None), Pulley(radius=1.0)).moving[:, [0, 2]]
    if not np.isfinite(points).all():  # out of reach
        return task
    places = np.union1d(extreme_places(points), least_places(points))
    if template.amplifier.regeneration == "none":
        places = np.union1d(places, braking_places(points))
    return replace(task, speed=task.speed[places], force=task.force[places])
