"""State of a spring's hysteresis along a motion: over a closed cycle, settled, or over a run that starts without it.

The last axis of all arrays is time; between neighbouring instants the deflection counts as one-way.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from infinivar._core.array_namespace import Array, bisect, namespace, newton
from infinivar.errors import ParameterError
from infinivar.parts.elastic import Elastic

_SETTLED = 1e-14
"""Precision of the state that repeats itself, relative to the largest hysteresis force."""

_FINE = 0.01
"""Unit of travel over the sizes that round it."""

_HALVINGS, _POLISH = 8, 60
"""Steps of bisection, and most steps of Newton's method."""


def along_positions(spring: Elastic, position: Array, closes: bool) -> Array:
    """Hysteresis force of a parallel spring.

    Parameters
    ----------
    spring : Elastic          With hysteresis.
    position : (..., n) float [m] or [rad]
    closes : bool             Whether the last instant is followed by the first: then the state is periodic; else it is 0
        at the first instant.

    Returns
    -------
    (..., n) float   z at each instant. [N] or [N m]

    Source: dahl1968; along a one-way deflection z changes by an affine map, and these compose.
    """
    xp = namespace(spring, position)
    before = xp.concat([position[..., -1:] if closes else position[..., :1], position[..., :-1]], axis=-1)
    # Each step is z -> kept z + gained; after this loop, from the start to each instant.
    kept = spring.hysteresis_after(1.0 + 0.0 * position, position - before)
    gained = spring.hysteresis_after(0.0 * position, position - before)
    kept = kept - gained
    shift = 1
    while shift < position.shape[-1]:
        gained = xp.concat(
            [gained[..., :shift], gained[..., shift:] + kept[..., shift:] * gained[..., :-shift]], axis=-1
        )
        kept = xp.concat([kept[..., :shift], kept[..., shift:] * kept[..., :-shift]], axis=-1)
        shift *= 2
    if not closes:
        return gained
    whole = kept[..., -1:]
    still = whole == 1.0
    start = xp.where(still, 0.0, gained[..., -1:] / xp.where(still, 1.0, 1.0 - whole))
    return gained + kept * start


def under_forces(spring: Elastic, force: np.ndarray, closes: bool) -> tuple[np.ndarray, np.ndarray]:
    """Deflection and hysteresis force of a series spring.

    Parameters
    ----------
    spring : Elastic         With hysteresis.
    force : (..., n) float   Force on the load, elastic and hysteresis together. [N] or [N m]
    closes : bool            As in `along_positions`.

    Returns
    -------
    deflection, hysteresis : (..., n) float   [m] or [rad], [N] or [N m]

    Raises
    ------
    ParameterError
        If arrays are not those of NumPy.

    Source: dahl1968; the deflection on each branch between reversals of the force, by bisection and Newton's method.
    """
    if namespace(spring, force).__name__ != "numpy":
        raise ParameterError(
            "hysteresis of a series spring has no derivatives: choose another method, such as differences"
        )
    force, drawn = np.asarray(force, dtype=float), _drawn(spring)
    shape = np.broadcast_shapes(force.shape[:-1], *(np.shape(value)[:-1] for value in drawn.values()))
    rows = np.broadcast_to(force, (*shape, force.shape[-1])).reshape(-1, force.shape[-1])
    found = [_one(one, row, closes) for one, row in zip(_each(spring, drawn, shape), rows, strict=True)]
    deflection, hysteresis = (np.array(part).reshape(*shape, -1) for part in zip(*found, strict=True))
    return deflection, hysteresis


def _drawn(spring: Elastic) -> dict[str, np.ndarray]:
    """Values of a sampled spring: arrays that broadcast with the forces, the same at all instants."""
    values = {one.name: getattr(spring, one.name) for one in dataclasses.fields(spring) if "unit" in one.metadata}  # type: ignore[arg-type]
    return {name: value for name, value in values.items() if np.ndim(value)}


def _each(spring: Elastic, drawn: Mapping[str, np.ndarray], shape: tuple[int, ...]) -> list[Elastic]:
    """A spring for each row of forces; those of a sampled spring differ."""
    count = math.prod(shape)
    if not drawn:
        return [spring] * count
    columns = {name: np.broadcast_to(value, (*shape, 1)).ravel().tolist() for name, value in drawn.items()}
    made = ({name: column[row] for name, column in columns.items()} for row in range(count))
    return [dataclasses.replace(spring, **own) for own in made]  # type: ignore[type-var]


def _one(spring: Elastic, force: np.ndarray, closes: bool) -> tuple[np.ndarray, np.ndarray]:
    start = float(force[-1] if closes else force[0])
    hysteresis = _repeating(spring, force) if closes else 0.0
    return _branches(spring, start, force, _deflection(spring, start - hysteresis), hysteresis)


def _deflection(spring: Elastic, elastic: float) -> float:
    return float(spring.deflection(np.array([elastic]))[0])


def _repeating(spring: Elastic, force: np.ndarray) -> float:
    """Hysteresis force at the last instant of a cycle that repeats itself; 0 if the force never changes.

    A cycle maps the state at its end to that at its next end, and keeps the order of states and the range of the hysteresis
    force: its fixed point lies between the signs of the change over a cycle. Where a cycle forgets little of the state, it
    would take thousands of cycles to come near.
    """
    from scipy.optimize import brentq

    last, largest = float(force[-1]), float(spring.hysteresis or 0.0)
    heading, ends = _headings(last, force)
    turns = force[ends[heading[ends - 1] != 0] - 1]

    def change(state: float) -> float:
        return float(_branches(spring, last, turns, _deflection(spring, last - state), state)[1][-1]) - state

    if not len(turns):
        return 0.0
    # At an end without a change the force is fully built up; at both ends, the change is lost in rounding.
    rises, falls = change(-largest) > 0, change(largest) < 0
    if rises and falls:
        return float(brentq(change, -largest, largest, xtol=_SETTLED * largest))  # type: ignore[arg-type]
    return largest * (float(rises) - float(falls))


def _headings(start: float, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Direction in which the force changes last at each instant, 0 before it changes; and ends of each direction's branch."""
    direction = np.sign(np.diff(force, prepend=start))
    moving = np.where(direction == 0, 0, np.arange(len(force)) + 1)
    heading = np.append(0.0, direction)[np.maximum.accumulate(moving)]
    return heading, np.append(np.flatnonzero(np.diff(heading)) + 1, len(force))


def _branches(
    spring: Elastic, start: float, force: np.ndarray, deflection: float, hysteresis: float
) -> tuple[np.ndarray, np.ndarray]:
    """Deflection and hysteresis from a state under the force `start` on."""
    heading, ends = _headings(start, force)
    found, state = np.empty(len(force)), np.empty(len(force))
    begin = 0
    for end in ends:
        branch, sign = slice(begin, end), float(heading[begin])
        if sign:
            way = _travelled(spring, force[branch], deflection, hysteresis, sign)
            state[branch] = spring.hysteresis_after(hysteresis, way)
        else:
            way = np.zeros(end - begin)
            state[branch] = hysteresis
        found[branch] = deflection + way
        deflection, hysteresis, begin = float(found[end - 1]), float(state[end - 1]), end
    return found, state


def _travelled(spring: Elastic, force: np.ndarray, start: float, hysteresis: float, sign: float) -> np.ndarray:
    """Changes of the deflection on a branch without reversal: up with `sign` 1, down with -1."""
    largest = sign * float(spring.hysteresis or 0.0)

    # Travels from the start are solved for, as a presliding of nanometres would drown in the position. Their unit is small
    # for precision, and large beside the rounding of forces.
    forces = np.max(np.abs(force)) + abs(spring.preload) + abs(largest)
    unit = _FINE * (abs(start) + forces / float(np.ravel(spring.derivatives(np.array([start]), 1)[1])[0]))

    def excess(travel: np.ndarray) -> np.ndarray:
        return spring.force(start + travel) + spring.hysteresis_after(hysteresis, travel) - force

    def step(share: np.ndarray) -> np.ndarray:
        travel = unit * share
        state = spring.hysteresis_after(hysteresis, travel)
        stiffness = (
            spring.derivatives(start + travel, 1)[1] + spring.hysteresis_derivatives(state, np.float64(sign), 1)[1]
        )
        return share - excess(travel) / (stiffness * unit)

    # The hysteresis force lies between its value at the start and its largest.
    ends = spring.deflection(force - largest) - start, spring.deflection(force - hysteresis) - start
    low, high = ends if sign > 0 else ends[::-1]
    low, high = (np.maximum(low, 0.0), high) if sign > 0 else (low, np.minimum(high, 0.0))
    # The sum of a straight line and the exponential is concave along the way, so that Newton's method, started short of the
    # solution, converges; other springs are first bisected.
    straight = spring.shape == "linear"
    near = (low if sign > 0 else high) if straight else bisect(np, excess, low, high, _HALVINGS)
    found = unit * newton(np, step, near / unit, _POLISH)
    return np.maximum(found, 0.0) if sign > 0 else np.minimum(found, 0.0)
