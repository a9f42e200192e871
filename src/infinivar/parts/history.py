"""State of a spring's hysteresis along a motion: over a closed cycle, settled, or over a run that starts without it.

The last axis of all arrays is time; between neighbouring instants the deflection counts as one-way.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from infinivar._core.array_namespace import Array, bisect, namespace, newton
from infinivar.errors import ParameterError
from infinivar.parts.elastic import Elastic

_ROUNDS = 50
"""Most cycles until the state repeats itself; each forgets it by the share of the way that is one-way."""

_SETTLED = 1e-12
"""Change of the state over a cycle, relative to the largest hysteresis force, at which it has settled."""

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
        raise ParameterError("hysteresis of a series spring has no derivatives: compute without it")
    force = np.asarray(force, dtype=float)
    rows = force.reshape(-1, force.shape[-1])
    found = [_one(one, row, closes) for one, row in zip(_each(spring, force.shape[:-1]), rows, strict=True)]
    deflection, hysteresis = (np.array(part).reshape(force.shape) for part in zip(*found, strict=True))
    return deflection, hysteresis


def _each(spring: Elastic, shape: tuple[int, ...]) -> list[Elastic]:
    """A spring for each row of forces; those of a sampled spring differ."""
    count = math.prod(shape)
    values = {one.name: getattr(spring, one.name) for one in dataclasses.fields(spring) if "unit" in one.metadata}  # type: ignore[arg-type]
    drawn = {name: value for name, value in values.items() if np.ndim(value)}
    if not drawn:
        return [spring] * count
    columns = {name: np.broadcast_to(value, (*shape, 1)).ravel().tolist() for name, value in drawn.items()}
    made = ({name: column[row] for name, column in columns.items()} for row in range(count))
    return [dataclasses.replace(spring, **own) for own in made]  # type: ignore[type-var]


def _one(spring: Elastic, force: np.ndarray, closes: bool) -> tuple[np.ndarray, np.ndarray]:
    assert spring.hysteresis is not None
    deflection, hysteresis = float(spring.deflection(force[:1])[0]), 0.0
    if not closes:
        return _branches(spring, force[0], force, deflection, hysteresis)
    last, before = float(force[-1]), hysteresis
    deflection = float(spring.deflection(force[-1:])[0])
    found, state = np.empty(0), np.empty(0)
    for _ in range(_ROUNDS):
        found, state = _branches(spring, last, force, deflection, before)
        deflection, settled = float(found[-1]), abs(state[-1] - before) <= _SETTLED * spring.hysteresis
        before = float(state[-1])
        if settled:
            break
    return found, state


def _branches(
    spring: Elastic, start: float, force: np.ndarray, deflection: float, hysteresis: float
) -> tuple[np.ndarray, np.ndarray]:
    """Deflection and hysteresis from a state under the force `start` on."""
    direction = np.sign(np.diff(force, prepend=start))
    moving = np.where(direction == 0, 0, np.arange(len(force)) + 1)
    heading = np.append(0.0, direction)[np.maximum.accumulate(moving)]
    ends = np.append(np.flatnonzero(np.diff(heading)) + 1, len(force))
    found, state = np.empty(len(force)), np.empty(len(force))
    begin = 0
    for end in ends:
        branch, sign = slice(begin, end), float(heading[begin])
        if sign:
            way = _deflected(spring, force[branch], deflection, hysteresis, sign)
            state[branch] = spring.hysteresis_after(hysteresis, way - deflection)
        else:
            way = np.full(end - begin, deflection)
            state[branch] = hysteresis
        found[branch] = way
        deflection, hysteresis, begin = float(way[-1]), float(state[end - 1]), end
    return found, state


def _deflected(spring: Elastic, force: np.ndarray, start: float, hysteresis: float, sign: float) -> np.ndarray:
    """Deflections on a branch without reversal: up with `sign` 1, down with -1."""
    largest = sign * float(spring.hysteresis or 0.0)

    def excess(x: np.ndarray) -> np.ndarray:
        return spring.force(x) + spring.hysteresis_after(hysteresis, x - start) - force

    def step(x: np.ndarray) -> np.ndarray:
        state = spring.hysteresis_after(hysteresis, x - start)
        stiffness = spring.derivatives(x, 1)[1] + spring.hysteresis_derivatives(state, np.float64(sign), 1)[1]
        return x - (spring.force(x) + state - force) / stiffness

    # The hysteresis force lies between its value at the start and its largest.
    ends = spring.deflection(force - largest), spring.deflection(force - hysteresis)
    low, high = ends if sign > 0 else ends[::-1]
    low, high = (np.maximum(low, start), high) if sign > 0 else (low, np.minimum(high, start))
    # The sum of a straight line and the exponential is concave along the way, so that Newton's method, started short of the
    # solution, converges; other springs are first bisected.
    straight = spring.shape == "linear"
    near = (low if sign > 0 else high) if straight else bisect(np, excess, low, high, _HALVINGS)
    found = newton(np, step, near, _POLISH)
    return np.maximum(found, start) if sign > 0 else np.minimum(found, start)
