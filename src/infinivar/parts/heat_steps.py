"""Cycles and runs of a motor's temperatures as steps of constant power, each an exact map; of one motor or of many."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.fields import given
from infinivar.parts.motor import Motor

COPPER = 0.0039
"""Temperature coefficient of the resistance of copper, relative to 25 °C. [1/K]"""
REFERENCE = 298.15
"""Temperature at which data sheets state the resistance. [K]"""
BOUND = 1e12
"""Largest growth of a temperature difference within a cycle; beyond it the winding counts as running away."""
MARGIN = 1e-9
"""Share of its limit by which a temperature may exceed it: rounding."""

_STEPS_PER_TIME_CONSTANT = 50
_LEAST_STEPS, _MOST_STEPS = 8, 4000
_LONGEST_STEP = 60.0
"""Longest time step, in multiples of the slower time constant."""


_LARGEST_RIPPLE = 25.0
"""Largest mean of the variation within a step that counts. [K]"""


def warmth(temperature: Any) -> Any:
    """Resistance of a winding at a temperature [K] over that at 25 °C.

    Source: maxon2020.
    """
    return 1.0 + COPPER * (temperature - REFERENCE)


class Nodes(NamedTuple):
    """Thermal data of a motor, or of many. [K/W], [s]"""

    winding_to_housing: Any
    housing_to_ambient: Any
    winding_time_constant: Any
    housing_time_constant: Any

    @property
    def capacities(self) -> tuple[Any, Any]:
        """Heat capacities of winding and housing. [J/K]"""
        return (
            self.winding_time_constant / self.winding_to_housing,
            self.housing_time_constant / self.housing_to_ambient,
        )

    def rates(
        self, winding_loss: Any, friction_power: Any, winding: Any, housing: Any, ambient: Any
    ) -> tuple[Any, Any]:
        """Time derivatives of the temperatures of winding and housing. [K/s]

        Parameters
        ----------
        winding_loss : (...,) float                With the resistance at the winding's temperature. [W]
        friction_power : (...,) float              Heat from friction and iron loss. [W]
        winding, housing, ambient : (...,) float   Temperatures. [K]

        Source: maxon2020; see `infinivar.parts.heat`.
        """
        inner, outer = self.capacities
        across = (winding - housing) / self.winding_to_housing
        left = (housing - ambient) / self.housing_to_ambient
        return (winding_loss - across) / inner, (friction_power + across - left) / outer


def nodes_of(motor: Motor) -> Nodes:
    """Thermal data of a motor, nan where missing."""
    return Nodes(*(given(getattr(motor, name), math.nan) for name in Nodes._fields))


def rates(motor: Motor, square_current: Any, friction_power: Any, ambient: float) -> tuple[np.ndarray, np.ndarray]:
    """Matrix A and vector b of ``d(T_w, T_h)/dt = A (T_w, T_h) + b``.

    Parameters
    ----------
    motor : Motor                     With all of `heat.NEEDED`; arrays of a last axis 1 for many.
    square_current : (..., n) float   Mean square of the current. [A^2]
    friction_power : (..., n) float   Heat from friction and iron loss. [W]
    ambient : float                   Ambient temperature. [K]

    Returns
    -------
    A, b : (..., n, 2, 2), (..., n, 2) float   [s^-1], [K s^-1]

    Source: maxon2020; see `infinivar.parts.heat`.
    """
    inner, outer = motor.winding_to_housing, motor.housing_to_ambient
    assert inner is not None
    assert outer is not None
    winding, housing = (
        given(motor.winding_time_constant, math.nan) / inner,
        given(motor.housing_time_constant, math.nan) / outer,
    )
    joule = motor.resistance * np.atleast_1d(np.asarray(square_current, dtype=float))
    friction = np.atleast_1d(np.asarray(friction_power, dtype=float))
    matrix = np.empty((*joule.shape, 2, 2))
    matrix[..., 0, 0] = (joule * COPPER - 1.0 / inner) / winding
    matrix[..., 0, 1] = 1.0 / (inner * winding)
    matrix[..., 1, 0] = 1.0 / (inner * housing)
    matrix[..., 1, 1] = -(1.0 / inner + 1.0 / outer) / housing
    vector = np.stack([joule * (1.0 - COPPER * REFERENCE) / winding, (friction + ambient / outer) / housing], axis=-1)
    return matrix, vector


class Steps(NamedTuple):
    """A cycle divided into steps of constant power, with what the power's variation within a step adds to the winding.

    With the winding at ``theta + r``, where r is the integral of the power's deviation from its mean over the step and vanishes
    at both ends of it, ``theta`` follows the mean power and ``A r``, whose mean over the step is part of the generator.
    """

    generators: np.ndarray
    """Generator of (theta, T_h, 1) for each step. (..., k, 3, 3) [s^-1]"""
    ends: np.ndarray
    """Times since the start of the cycle, beginning with 0. (k + 1,) [s]"""
    active: np.ndarray
    """Part of each step before the state has settled or run away. (..., k) [s]"""
    maps: np.ndarray
    """Exact map of (theta, T_h, 1) over each step. (..., k, 3, 3)"""
    edges: np.ndarray
    """Number of instants before each end. (k + 1,)"""
    ripple: np.ndarray
    """r at the end of each of the n instants, for the resistance at `REFERENCE`. (..., n) [K]"""

    def within(self, along: np.ndarray) -> np.ndarray:
        """Winding temperatures at the ends of instants, from the states (..., j + 1, 3) at the ends of the first j steps. [K]"""
        first, last = along[..., :-1, 0], along[..., 1:, 0]
        width = np.diff(self.edges)[: last.shape[-1]]
        step = np.repeat(np.arange(len(width)), width)
        share = (np.arange(len(step)) + 1.0 - self.edges[step]) / width[step]
        theta = first[..., step] + share * (last - first)[..., step]
        return theta + self.ripple[..., : len(step)] * (1.0 + COPPER * (theta - REFERENCE))

    def highest(self, along: np.ndarray) -> np.ndarray:
        """Highest winding temperature after the start, by the states at the ends of steps. (...,) [K]"""
        return np.maximum(along[..., 1:, 0].max(axis=-1), self.within(along).max(axis=-1))

    def mean(self, along: np.ndarray) -> np.ndarray:
        """Mean winding temperature, by the states at the ends of steps. (...,) [K]"""
        width, last = np.diff(self.edges), self.edges[-1]
        middle = 0.5 * (along[..., 1:, 0] + along[..., :-1, 0])
        lasting = np.add.reduceat(self.ripple, self.edges[:-1], axis=-1)
        return np.sum(middle * width + lasting * (1.0 + COPPER * (middle - REFERENCE)), axis=-1) / last


def step_count(winding_time_constant: Any, period: float, instants: int) -> np.ndarray:
    """Number of steps into which a cycle with that number of instants is divided, for each time constant [s]."""
    required = np.ceil(_STEPS_PER_TIME_CONSTANT * period / np.asarray(winding_time_constant, dtype=float))
    return np.minimum(np.clip(required, _LEAST_STEPS, _MOST_STEPS), instants).astype(int)


def steps(motor: Motor, current: Any, friction_power: Any, period: float, ambient: float) -> Steps:
    """Divide a cycle into steps of constant power.

    Parameters
    ----------
    motor : Motor                              With all of `heat.NEEDED`; many, as arrays of a last axis 1, must have the same
        `step_count`.
    current, friction_power : (..., n) float   At the midpoints of equal steps of the cycle. [A], [W]
    period : float                             [s]
    ambient : float                            [K]

    Source: maxon2020; see `infinivar.parts.heat`.
    """
    square = np.atleast_1d(np.asarray(current, dtype=float)) ** 2
    friction = np.broadcast_to(np.asarray(friction_power, dtype=float), square.shape)
    lag, slow = given(motor.winding_time_constant, math.nan), given(motor.housing_time_constant, math.nan)
    count = int(np.max(step_count(lag, period, square.shape[-1])))
    edges = np.linspace(0, square.shape[-1], count + 1).astype(int)
    width = np.diff(edges)
    mean, friction = (np.add.reduceat(values, edges[:-1], axis=-1) / width for values in (square, friction))
    matrix, vector = rates(motor, mean, friction, ambient)
    # Within a step, the integral of what the winding loss differs from its mean.
    warming = motor.resistance * given(motor.winding_to_housing, math.nan) / lag * (period / square.shape[-1])
    ripple = warming * np.cumsum(square - np.repeat(mean, width, axis=-1), axis=-1)
    lasting = np.add.reduceat(ripple, edges[:-1], axis=-1) / width
    # Far beyond, windings run away anyway.
    lasting = np.clip(lasting, -_LARGEST_RIPPLE, _LARGEST_RIPPLE)[..., None]
    added = lasting * matrix[..., :, 0]
    vector = vector + (1.0 - COPPER * REFERENCE) * added
    matrix[..., :, 0] += COPPER * added
    # r is larger in a warmer winding, and thus takes part in its warming.
    matrix[..., 0, :] /= 1.0 + COPPER * lasting
    vector[..., 0] /= 1.0 + COPPER * lasting[..., 0]
    generators = np.zeros((*matrix.shape[:-2], 3, 3))
    generators[..., :2, :2], generators[..., :2, 2] = matrix, vector
    ends = edges * (period / edges[-1])
    # A longer step has settled, or run away, before it ends; its exponential would lose all digits.
    longest = _LONGEST_STEP * np.maximum(slow, lag)
    grows = _fastest(matrix)
    active = np.minimum(np.diff(ends), np.minimum(longest, 2.0 * math.log(BOUND) / np.maximum(grows, 1.0 / longest)))
    return Steps(generators, ends, active, over(generators, active), edges, ripple)


def _fastest(matrix: np.ndarray) -> np.ndarray:
    """The larger eigenvalue of the upper left 2 x 2 part, real as no element off its diagonal is negative. (...,)"""
    a, b, c, d = (matrix[..., row, column] for row in (0, 1) for column in (0, 1))
    half = 0.5 * (a - d)
    return 0.5 * (a + d) + np.sqrt(half * half + b * c)


def over(generators: np.ndarray, time: Any) -> np.ndarray:
    """State maps over given times: exponentials of generators, in closed form.

    The two rates of a motor's temperatures, eigenvalues of the 2 x 2 matrix A, are real and differ, as each mass warms the other.
    A function of A is thus that of the rates, each times its projection; the part of the vector b is ``t phi(A t) b`` with
    ``phi(x) = (exp(x) - 1)/x``.
    """
    time = np.asarray(time, dtype=float)
    vector = generators[..., :2, 2]
    a, b, c, d = (generators[..., row, column] for row in (0, 1) for column in (0, 1))
    half = 0.5 * (a - d)
    spread = np.sqrt(half**2 + b * c)
    # spread - |half|, without cancellation
    little = b * c / (spread + np.abs(half))
    above, below = np.where(half > 0, spread + half, little), np.where(half > 0, little, spread - half)
    maps = np.zeros((*np.broadcast_shapes(a.shape, time.shape), 3, 3))
    for rate, first, second, sign in (
        (np.maximum(a, d) + little, above, below, 1.0),
        (np.minimum(a, d) - little, below, above, -1.0),
    ):
        rows = ((first, sign * b), (sign * c, second))
        onto = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2) / (2.0 * spread)[..., None, None]
        grown = rate * time
        lasting = time * np.where(grown == 0, 1.0, np.expm1(grown) / np.where(grown == 0, 1.0, grown))
        maps[..., :2, :2] += np.exp(grown)[..., None, None] * onto
        maps[..., :2, 2] += lasting[..., None] * np.einsum("...ij,...j->...i", onto, vector)
    maps[..., 2, 2] = 1.0
    return maps


class Windings(NamedTuple):
    """Temperatures of many motors, settled in a cycle or over a run. (k,) [K]"""

    highest: np.ndarray
    """Highest winding temperature at the ends of instants; inf where a motor never settles."""
    mean: np.ndarray
    """Mean winding temperature; inf where a motor never settles."""
    time: np.ndarray
    """Ends of the steps of a run; empty for a cycle. (n + 1,) [s]"""
    history: np.ndarray
    """Winding temperature at these times. (k, n + 1)"""


def windings(
    motor: Motor, current: np.ndarray, friction_power: Any, period: float, ambient: float, start: float | None = None
) -> Windings:
    """Winding temperatures of many motors, as `heat.heat` and `heat.heat_over_run` find them for one.

    Parameters
    ----------
    motor : Motor                       As for `steps`, with arrays of shape (k, 1).
    current, friction_power : (k, n) float   At the midpoints of equal steps of the cycle or run. [A], [W]
    period : float                      Of the cycle, or duration of the run. [s]
    ambient : float                     [K]
    start : float                       Temperature of winding and housing at the start of a run; None: a cycle that is
        repeated until it has settled. [K]

    Source: maxon2020; see `infinivar.parts.heat`.
    """
    found = steps(motor, current, friction_power, period, ambient)
    count = found.maps.shape[-3]
    if start is not None:
        state = np.broadcast_to(np.array([start, start, 1.0]), (*found.maps.shape[:-3], 3))
        along = _along(found.maps, state)
        highest = np.maximum(start, found.highest(along))
        return Windings(highest, found.mean(along), found.ends, along[..., 0])
    cycle = np.broadcast_to(np.eye(3), (*found.maps.shape[:-3], 3, 3))
    runs_away = np.zeros(cycle.shape[:-2], dtype=bool)
    for place in range(count):
        # A motor that has run away goes on from no growth, so that no number exceeds all others.
        cycle = np.where(runs_away[..., None, None], np.eye(3), found.maps[..., place, :, :] @ cycle)
        runs_away = runs_away | (cycle[..., :2, :2].max(axis=(-2, -1)) > BOUND)
    runs_away = runs_away | (_fastest(cycle) >= 1.0)
    cycle = np.where(runs_away[..., None, None], np.diag([0.0, 0.0, 1.0]), cycle)
    rest = np.linalg.solve(np.eye(2) - cycle[..., :2, :2], cycle[..., :2, 2:])[..., 0]
    state = np.concatenate([rest, np.ones((*rest.shape[:-1], 1))], axis=-1)
    with np.errstate(over="ignore", invalid="ignore"):
        along = _along(found.maps, state)
        highest, mean = (np.where(runs_away, np.inf, part) for part in (found.highest(along), found.mean(along)))
    return Windings(highest, mean, np.empty(0), np.empty((*highest.shape, 0)))


def _along(maps: np.ndarray, state: np.ndarray) -> np.ndarray:
    """States from the start of a cycle to its end. (..., k + 1, 3)"""
    found = [state]
    for place in range(maps.shape[-3]):
        found.append((maps[..., place, :, :] @ found[-1][..., None])[..., 0])
    return np.stack(found, axis=-2)
