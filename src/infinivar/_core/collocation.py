r"""Integration of stiff motions in short segments, by collocation at Radau points (order 5), with energies by its quadrature.

A sampled controller changes the inputs every millisecond, and contacts settle within microseconds. A one-step method has no
history to lose at a sample. All stages of a step are one call of the rates for several rows, and so are all columns of their
Jacobian, which is kept until it no longer serves. Powers are integrated by the quadrature of the same points, so that the
balance of energies is a measure of error that knows nothing of the states' scales: a step that misses it is shortened.

Source: hairer1996, section IV.8, for the method, its error estimate and its simplified Newton iteration.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

_ROOT = 6.0**0.5
POINTS = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])
"""Of a step, as shares of it."""

_NODES = np.concatenate([[0.0], POINTS])
_OTHERS = np.array([[other for other in range(4) if other != node] for node in range(4)])
_SCALES = np.prod(_NODES[:, None] - _NODES[_OTHERS], axis=-1)
"""Of the polynomial through the start and the points of a step."""

_A = np.array(
    [
        [(88.0 - 7.0 * _ROOT) / 360.0, (296.0 - 169.0 * _ROOT) / 1800.0, (-2.0 + 3.0 * _ROOT) / 225.0],
        [(296.0 + 169.0 * _ROOT) / 1800.0, (88.0 + 7.0 * _ROOT) / 360.0, (-2.0 - 3.0 * _ROOT) / 225.0],
        [(16.0 - _ROOT) / 36.0, (16.0 + _ROOT) / 36.0, 1.0 / 9.0],
    ]
)
_ERROR = np.array([-13.0 - 7.0 * _ROOT, -13.0 + 7.0 * _ROOT, -1.0]) / 3.0
_REAL = 3.0 + 3.0 ** (2.0 / 3.0) - 3.0 ** (1.0 / 3.0)

_ITERATIONS = 8
_MORE = 3
"""Most iterations beyond those that the states need, for the balance of energies, as long as they make it better."""

_NEWTON = 1e-3
"""Largest last change of an iteration, over the tolerance of the states."""

_SLOW = 0.03
"""Convergence rate above which the next step begins with a new Jacobian."""

_STALE, _LEFT = 0.1, 0.6
"""Missing energy over its tolerance, where it is the larger error, above which the next step begins with a new Jacobian, and
above which the iteration goes on: what it leaves is missing, and does not become less with the step."""

_DIFFERENCE = 1e-7
"""Change of a state in units of its scale, for slopes."""

_REACH = 4.0
"""Length of a step over that before it up to which its polynomial predicts."""

_STRICT = 0.01
"""Tolerance of the missing energy over that of the states: errors of the same sign add up over thousands of steps."""

_STRICTEST = 1e-3
"""Least share of that, where the energy missing so far is near what may be missing in all."""

_COASTING = 1e-3
"""Largest share of the stored energy that counts as moved in a step, beside that which passes."""

_COASTED = 0.1
"""The same in all segments together."""

MOVED = 1e-5
"""Size of a place, whatever its distance from an origin. [m] or [rad]"""

_UNFELT = 1e-12
"""Energy that counts as passed before a motion begins: what is missing in its first moments is little of the whole. [J]"""

_SMALLEST = 1e-12
"""Shortest step. [s]"""

CALLS, CALLS_EACH = 20_000, 1_000
"""Calls of the rates, or steps in C, that are few enough to go on, and as many more for each segment; ten to fifty are usual."""

_GROWTH, _SHRINKING, _SAFETY = 6.0, 0.1, 0.9


class Balance(NamedTuple):
    """What a motion passes, stores and demands at m states: rows."""

    power: np.ndarray
    """Powers to integrate. (m, p) [W]"""
    stored: np.ndarray
    """Stored energy, by time and state only. (m,) [J]"""
    demand: np.ndarray
    """Whose rise through 1 is an event, by time and state only. (m, d)"""


class Rates(NamedTuple):
    """What a motion does at m states: rows. Mostly the derivative alone is needed."""

    derivative: np.ndarray
    """(m, n) [s^-1]"""
    balance: Callable[[], Balance]
    """The rest, computed when called."""


class StuckError(Exception):
    """No step is short enough, or too many are needed: the time that was reached, and whether they are too many."""


class _End(NamedTuple):
    """Where a step ends, or the first one begins."""

    state: np.ndarray
    stored: float
    demand: np.ndarray


class Step(NamedTuple):
    """An accepted step: its ends, the states at its ends and points, the energies that passed, and demands at both ends."""

    begin: float
    end: float
    before: np.ndarray
    points: np.ndarray
    """(3, n)"""
    energy: np.ndarray
    """(p,) [J]"""
    demand_before: np.ndarray
    demand: np.ndarray

    def at(self, shares: np.ndarray) -> np.ndarray:
        """States at shares of the step, on the collocation polynomial. (m, n)"""
        away = shares[:, None] - _NODES
        weights = away[:, _OTHERS].prod(axis=-1) / _SCALES
        return weights[:, :1] * self.before + weights[:, 1:] @ self.points


class Collocation:
    """A motion in progress, from segment to segment.

    Parameters
    ----------
    rates : callable       Maps times (m,) and states (m, n) to `Rates`; called with other inputs in each segment.
    balance : (p,) float   Signs of the powers in the balance: 1 for those that feed the storage, -1 for those that drain it.
    scale : (n,) float     Size of each state, in addition to its magnitude.
    tolerance : float      Of the states over their size, and of the missing energy over that which passed.
    segments : int         How many there will be: the energy that is missing in each adds up.
    closure : float        Of the energy missing in all segments together, over the most that has passed and is stored.
    placed : int           How many states, at the front, are places: the size of their errors is `MOVED`.
    """

    def __init__(
        self,
        rates: Callable[[np.ndarray, np.ndarray], Rates],
        balance: np.ndarray,
        scale: np.ndarray,
        tolerance: float,
        segments: int = 1,
        closure: float = np.inf,
        placed: int = 0,
    ) -> None:
        """Nothing is known yet about steps and slopes."""
        self.rates, self.balance = rates, balance
        self.scale, self.tolerance = scale, tolerance
        # Where the origin of a place is, is arbitrary; and what is held must not jump.
        self.size, self.relative = scale.copy(), np.ones_like(scale)
        self.size[:placed], self.relative[:placed] = MOVED, 0.0
        self.coasting = min(_COASTING, _COASTED / segments)
        from scipy.linalg import get_lapack_funcs  # imported when needed: it takes long

        self.factor, self.solve = get_lapack_funcs(("getrf", "getrs"), dtype=np.float64)
        self.step = np.inf
        self.last: Step | None = None
        self.known: _End | None = None
        self.closure, self.spent, self.owed, self.most = closure, np.zeros(len(balance)), 0.0, _UNFELT
        self.slopes: np.ndarray | None = None
        self.factors: tuple[float, Any, Any] | None = None
        self.calls = self.done = 0

    def over(self, begin: float, end: float, state: np.ndarray, accept: Callable[[Step], None]) -> np.ndarray:
        """Integrate one segment without jumps of the inputs; returns the state at its end.

        Raises
        ------
        StuckError
            If no step is short enough, or far more are needed than motions of machines take.
        """
        # The rates at the start are found with those at the first points: a call costs much the same for four rows.
        time, first = begin, None
        if self.known is None or self.known.state is not state:
            found = self._one(begin, state).balance()
            self.known = _End(state, float(found.stored[0]), found.demand[0])
        growth = _GROWTH
        fresh, least = False, max(_SMALLEST, 1e-9 * (end - begin))
        self.step = min(self.step, end - begin)
        self.done += 1
        while end - time > 1e-9 * (end - begin):
            if self.calls > CALLS + CALLS_EACH * self.done:
                raise StuckError(time, True)
            left = end - time
            # The last steps of a segment are of one length.
            step = left / max(1.0, np.ceil(left / self.step - 1e-9))
            if self.slopes is None:
                self.slopes, fresh, self.factors = self._jacobian(time, state), True, None
            found, first = self._attempt(time, state, first, step)
            if found is None:
                if not fresh:
                    self.slopes = None
                    continue
                if step <= least:
                    raise StuckError(time, False)
                self.step, growth = 0.3 * step, 1.5
                continue
            error, made, after, reached, rate = found
            factor = min(growth, max(_SHRINKING, _SAFETY * max(error, 1e-12) ** -0.25))
            if error > 1.0:
                if step <= least:
                    raise StuckError(time, False)
                self.step = min(factor, 0.7) * step
                if not fresh:
                    self.slopes = None
                continue
            accept(made)
            self.owed += reached.stored - self.known.stored - float(self.balance @ made.energy)
            self.spent = self.spent + made.energy
            self.most = max(self.most, float(np.abs(self.spent).sum()) + reached.stored)
            self.last, self.known = made, reached
            time, state, first = made.end, reached.state, after
            fresh, growth = False, min(2.0 * growth, _GROWTH)
            if rate > _SLOW:
                self.slopes = None
            if factor < 1.0 or factor > 1.2:  # small changes are not worth new factors
                self.step = max(self.step, factor * step) if factor > 1.0 else factor * step
        return state

    def _one(self, time: float, state: np.ndarray) -> Rates:
        self.calls += 1
        return self.rates(np.array([time]), state[None])

    def _jacobian(self, time: float, state: np.ndarray) -> np.ndarray:
        """Derivatives of the rates by the states, (n, n)."""
        size = len(state)
        change = _DIFFERENCE * (np.abs(state) + self.scale)
        rows = np.empty((size + 1, size))
        rows[:] = state
        rows.flat[: size * size : size + 1] += change
        self.calls += 1
        found = self.rates(np.full(size + 1, time), rows).derivative
        return (found[:-1] - found[-1]).T / change

    def _factors(self, step: float) -> tuple[Any, Any]:
        """Solvers for the stages and for the error, of one step length."""
        if self.factors is None or self.factors[0] != step:
            assert self.slopes is not None
            size = len(self.slopes)
            stages = (-step * _A[:, None, :, None] * self.slopes[None, :, None, :]).reshape(3 * size, 3 * size)
            stages.flat[:: 3 * size + 1] += 1.0
            whole = -self.slopes
            whole.flat[:: size + 1] += _REAL / step
            self.factors = (step, self.factor(stages)[:2], self.factor(whole)[:2])
        return self.factors[1], self.factors[2]

    def _attempt(
        self, time: float, state: np.ndarray, first: np.ndarray | None, step: float
    ) -> tuple[tuple[float, Step, np.ndarray, _End, float] | None, np.ndarray | None]:
        """Error over the tolerance, the step, the derivatives after it, its end, and the rate of convergence; None if that
        fails. Beside it the derivatives at the start, if they are known."""
        stages, whole = self._factors(step)
        weight = 1.0 / (self.tolerance * (self.relative * np.abs(state) + self.size))
        times, size = time + step * POINTS, len(state)
        z = self._expected(times, state, step)
        before, rate, change, at, own = None, 0.0, z, None, slice(None)
        for left in reversed(range(_ITERATIONS)):
            self.calls += 1
            if first is None:
                at = self.rates(np.concatenate([[time], times]), np.concatenate([state[None], state + z]))
                first, own = at.derivative[0], slice(1, None)
            else:
                at, own = self.rates(times, state + z), slice(None)
            residual = step * (_A @ at.derivative[own]) - z
            change = self.solve(*stages, residual.ravel())[0].reshape(3, size)
            norm = _size(change * weight)
            if not math.isfinite(norm):
                return None, first
            if before is not None and before > 0.0:
                rate = norm / before
                if norm > _NEWTON and (rate >= 1.0 or norm * rate**left > _NEWTON * (1.0 - rate)):
                    return None, first
            if norm <= _NEWTON * max(1.0 - rate, 0.1):
                break
            z, before = z + change, norm
        else:
            return None, first
        assert first is not None
        assert at is not None
        estimate = self.solve(*whole, first + _ERROR @ z / step)[0]
        error = _size(estimate * weight)
        if error > 1.0:
            again = self._one(time, state + estimate).derivative[0]
            estimate = self.solve(*whole, again + _ERROR @ z / step)[0]
            error = _size(estimate * weight)
        # The last change is not applied, so that rates and energies are those of the points.
        rest = Balance(*(part[own] for part in at.balance()))
        missing, passed = self._missing(rest, step)
        for _ in range(_MORE):
            if not missing > max(error, _LEFT):
                break
            # The contacts are stiff: what is left of the iteration may be what is missing.
            self.calls += 1
            further = z + change
            again = self.rates(times, state + further)
            better = again.balance()
            least, gone = self._missing(better, step)
            if not least < missing:
                break
            z, at, rest, missing, passed = further, again, better, least, gone
            residual = step * (_A @ at.derivative) - z
            change = self.solve(*stages, residual.ravel())[0].reshape(3, size)
        if missing > max(error, _STALE):
            rate = max(rate, 2.0 * _SLOW)
        error, points = max(error, missing), state + z
        assert self.known is not None
        made = Step(time, float(times[-1]), state, points, passed, self.known.demand, rest.demand[-1])
        end = _End(points[-1], float(rest.stored[-1]), rest.demand[-1])
        return (error, made, at.derivative[-1], end, rate), first

    def _missing(self, rest: Balance, step: float) -> tuple[float, np.ndarray]:
        """Energy that a step leaves unaccounted for, over the tolerance, and the energies that passed."""
        assert self.known is not None
        passed = step * (_A[2] @ rest.power)
        here, there = self.known.stored, float(rest.stored[2])
        missing = there - here - float(self.balance @ passed)
        moved = float(np.abs(passed).sum()) + self.coasting * (here + there) + 1e-15
        strict = _STRICT * self.tolerance
        if missing * self.owed > 0.0:
            # Energy that goes to and fro counts in each step, but not in the balance of all.
            strict *= max(1.0 - abs(self.owed) / (self.closure * self.most), _STRICTEST)
        return abs(missing) / (strict * moved), passed

    def _expected(self, times: np.ndarray, state: np.ndarray, step: float) -> np.ndarray:
        """Changes of the state at the points, by the polynomial of the step before; none at first. (3, n)"""
        last = self.last
        if last is None or last.end - last.begin < step / _REACH or abs(last.end + step - times[-1]) > 0.5 * step:
            return np.zeros((3, len(state)))
        return last.at((times - last.begin) / (last.end - last.begin)) - state


def _size(values: np.ndarray) -> float:
    """Root of the mean square."""
    return math.sqrt(float(np.vdot(values, values)) / values.size)
