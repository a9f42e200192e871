"""Fit the parameters of a drive to readings on a bench: estimates, intervals, and identifiability."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.described import derived, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.calibration.bench import FEW, Bench, Parameter
from infinivar.calibration.problem import Problem
from infinivar.errors import InputError
from infinivar.study.spreads import NORMAL_95

OUTLIER = 5.0
"""Deviation from the robust fit, in standard deviations, beyond which a run is excluded; one in a million good readings."""

_UNKNOWN = 1.0
"""Relative standard deviation at which a direction counts as not identifiable."""

_INVOLVED = 0.1
"""Component of a direction above which a parameter belongs to it."""

_MOST_ROUNDS = 5
"""Largest number of refits without the outliers of the previous fit; two are usual."""

_MOST_STEPS = 200
"""Step limit of a fit: a successful one needs about ten; with outliers and a wrong creep law, about a hundred."""

_ROUNDS = 4
"""Refits with the noise that the residuals show."""

_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""
_MORE = 5.0
"""Of the factor ``1 + 5/(n - p)`` that corrects a median of few residuals."""

DOUBT = 1e-3
"""Probability below which residuals exceed the sensor errors."""


@result
class Combination(Frozen):
    """An identifiable weighted sum of parameters that are not identifiable separately; the first weight is 1."""

    weights: Mapping[str, float] = reported()
    value: float = reported()
    deviation: float = reported(key="standard_deviation")


@result
class Fit(Frozen):
    """Parameters fitted to rig data.

    Attributes
    ----------
    names : names of the requested parameters.
    values : estimates by name, in SI; parameters not identifiable separately keep the study's proportions.
    covariance : (p, p) covariance in the identifiable directions. [SI]
    unidentifiable : (p, k) orthonormal directions of the scaled parameters that are not identifiable.
    problem : `Problem` of the runs used.
    unknowns : solution of that problem.
    outliers : indices of excluded runs.
    chi_square, freedom : sum of squared residuals and degrees of freedom.
    widened : factor on all deviations, above 1 if the residuals exceed the sensor errors.
    """

    names: tuple[str, ...]
    values: Mapping[str, float]
    covariance: np.ndarray
    unidentifiable: np.ndarray
    problem: Problem
    unknowns: np.ndarray
    outliers: tuple[int, ...]
    chi_square: float
    freedom: int
    widened: float

    @property
    def law(self) -> str:
        """Creep law of the fit."""
        return self.problem.law

    @property
    def deviations(self) -> Mapping[str, float]:
        """Standard deviations by name, in SI; inf for parameters that are not identifiable."""
        spread = np.where(_involved(self.unidentifiable), np.inf, np.sqrt(np.diag(self.covariance)))
        return FrozenDict(zip(self.names, spread.tolist(), strict=True))

    @derived()
    def combinations(self) -> tuple[Combination, ...]:
        """Sums that are identifiable although their terms are not."""
        return _combinations(self.problem, self.unidentifiable, self.values, self.covariance)

    @property
    def identifiable(self) -> tuple[str, ...]:
        """Parameters that are identifiable separately."""
        return tuple(name for name in self.names if math.isfinite(self.deviations[name]))

    def interval(self, name: str) -> tuple[float, float]:
        """Ends of the 95 % interval; infinite if not identifiable."""
        half = NORMAL_95 * self.deviations[name]
        return self.values[name] - half, self.values[name] + half

    @property
    def correlations(self) -> np.ndarray:
        """Correlations of the requested parameters; nan if not identifiable. (p, p)"""
        scale = np.asarray([self.deviations[name] for name in self.names])
        with np.errstate(invalid="ignore"):
            return np.where(np.isfinite(scale[:, None] * scale), self.covariance / (scale[:, None] * scale), np.nan)

    @derived("1")
    def _correlations(self) -> dict[str, dict[str, float]]:
        rows = zip(self.names, self.correlations.tolist(), strict=True)
        return {name: dict(zip(self.names, row, strict=True)) for name, row in rows}

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """What can be fitted to such readings, by name."""
        return self.problem.data.parameters

    @derived()
    def _parameters(self) -> dict[str, Any]:
        """Estimate and interval of each parameter, beside the study's value."""
        return {
            name: {
                "unit": self.parameters[name].unit,
                "value": self.values[name],
                "identifiable": name in self.identifiable,
                "standard_deviation": self.deviations[name],
                "interval_95": list(self.interval(name)),
                "study": self.problem.known[name],
            }
            for name in self.names
        }


@result
class Robust(Frozen):
    """A robust fit, in which no single run has much weight.

    Attributes
    ----------
    problem : the problem solved.
    unknowns : its solution.
    cost : sum of the soft absolute values of the residuals.
    beyond : (n,) bool, runs that deviate by more than `OUTLIER` standard deviations.
    """

    problem: Problem
    unknowns: np.ndarray
    cost: float
    beyond: np.ndarray


def robust(problem: Problem, start: np.ndarray | None = None) -> Robust:
    """Fit with a loss that grows linearly with the residual, which reveals outliers.

    Source: least_squares of SciPy, loss soft_l1.
    """
    start = problem.start if start is None else start
    unknowns, cost = _solved(
        problem, start, unidentifiable=_unidentifiable(problem, start), loss="soft_l1", tolerance=1e-6
    )
    return Robust(problem=problem, unknowns=unknowns, cost=cost, beyond=problem.farthest(unknowns) > OUTLIER)


def settled(found: Robust) -> Robust:
    """Refit without the outliers and update them until they no longer change.

    At most the farthest third of the runs is excluded from the next fit.

    Source: rousseeuw2006, concentration steps.
    """
    problem, unknowns, beyond = found.problem, found.unknowns, found.beyond
    for _ in range(_MOST_ROUNDS):
        far = problem.farthest(unknowns)
        aside = beyond & (far >= np.sort(far)[len(far) - max(int(FEW * len(far)), 1)])
        unknowns = estimate(problem, unknowns, aside).unknowns
        again = problem.farthest(unknowns) > OUTLIER
        if np.array_equal(again, beyond):
            break
        beyond = again
    return replace(found, unknowns=unknowns, beyond=beyond)


def fit(problem: Problem) -> Fit:
    """Calibrate with one model: a robust fit finds the outliers, weighted least squares without them the estimates.

    Where the rig states no noise, that of each signal is that of its residuals, so errors of the model count as noise. An error
    of a sensor on which the expected readings of several signals depend makes their residuals alike; the last fits count it once.

    Raises
    ------
    InputError
        If more than a third of the rows deviate like outliers.

    Source: Gauss-Newton covariance of weighted least squares; least_squares of SciPy (trust region, bounds); definition of
    feasible generalised least squares.
    """
    stated, found = problem.whitening is not None, robust(problem)
    for _ in range(0 if stated else _ROUNDS):
        off = np.abs(problem.of_rows(problem.residuals(found.unknowns)))
        problem = problem.heard(problem.noise * _robust_size(off, len(problem.names)))
        found = robust(problem, found.unknowns)
    found = settled(found)
    refuse_many(problem.data, int(np.count_nonzero(found.beyond)))
    done = estimate(problem, found.unknowns, found.beyond)
    return done if stated else _with_noise_left(problem, done, found.beyond)


def _with_noise_left(problem: Problem, done: Fit, outliers: np.ndarray) -> Fit:
    """The fit with the noise that its residuals show."""
    from scipy.special import stdtrit

    for _ in range(_ROUNDS):
        kept = done.problem
        off = kept.of_rows(kept.separate.residuals(done.unknowns))
        freedom = 1.0 - min((len(problem.names) - done.unidentifiable.shape[1]) / kept.readings, 0.9)
        problem = problem.heard(kept.noise * np.sqrt(np.mean(off**2, axis=0) / freedom)).decorrelated(off)
        done = estimate(problem, done.unknowns, outliers)
    # With few rows the noise itself is uncertain: intervals of Student's distribution.
    wider = float(stdtrit(max(done.freedom, 1), 0.975)) / NORMAL_95
    return replace(done, covariance=wider**2 * done.covariance)


def _robust_size(off: np.ndarray, parameters: int) -> np.ndarray:
    """Standard deviation of residuals (n, m) from their median, without the rows that a fit of few passes through.

    Source: rousseeuw2006, with the factor for few rows.
    """
    exact = min(parameters // off.shape[1], len(off) - 1)
    freedom = max(len(off) - exact, 1)
    return np.median(np.sort(off, axis=0)[exact:], axis=0) / _NORMAL * (1.0 + _MORE / freedom)


def refuse_many(data: Bench, count: int, besides: str = "") -> None:
    """Raise InputError if the deviating runs are too many to be outliers; `besides` is what else may be wrong."""
    if count > FEW * len(data):
        raise InputError(
            f"{data.name}: {count} of {len(data)} runs deviate by more than {OUTLIER:g} standard deviations "
            "from a robust fit, too many for outliers: check the units in the header, the drive in the study, "
            f"and the sensor errors in [rig]{besides}"
        )


def estimate(problem: Problem, start: np.ndarray, outliers: np.ndarray) -> Fit:
    """Weighted least squares without the outliers, (n,) bool, starting from a robust fit."""
    kept = problem.without(outliers)
    unidentifiable = _unidentifiable(kept, start)
    unknowns, _ = _solved(kept, start, unidentifiable=unidentifiable)
    residuals = kept.residuals(unknowns)
    estimated = len(kept.names) - unidentifiable.shape[1]
    freedom = max(kept.readings - estimated, 0)
    chi_square = float(residuals @ residuals)
    widened = _widened(chi_square, freedom)
    covariance = widened**2 * _covariance(kept, unknowns, unidentifiable) * kept.scales[:, None] * kept.scales
    values = {name: float(unknowns[i] * kept.scales[i]) for i, name in enumerate(kept.names)}
    return Fit(
        names=kept.names,
        values=FrozenDict(values),
        covariance=covariance,
        unidentifiable=unidentifiable,
        problem=kept,
        unknowns=unknowns,
        outliers=tuple(np.flatnonzero(outliers).tolist()),
        chi_square=chi_square,
        freedom=freedom,
        widened=widened,
    )


def _solved(
    problem: Problem, start: np.ndarray, *, unidentifiable: np.ndarray, loss: str = "linear", tolerance: float = 1e-12
) -> tuple[np.ndarray, float]:
    """Solve least squares: unknowns and half the sum of the losses. In `unidentifiable` directions the study's values hold as
    prior with 100 % deviation."""
    from scipy.optimize import least_squares

    low, high = problem.bounds
    held = np.zeros((unidentifiable.shape[1], start.size))
    held[:, : len(problem.names)] = unidentifiable.T / _UNKNOWN
    found = least_squares(
        lambda x: np.concatenate([problem.residuals(x), held @ (x - problem.start)]),
        np.clip(start, low + 1e-9, high - 1e-9),
        lambda x: np.concatenate([problem.jacobian(x), held]),  # type: ignore[arg-type]
        (low, high),
        loss=loss,
        f_scale=2.0,
        xtol=tolerance,
        ftol=tolerance,
        gtol=tolerance,
        max_nfev=_MOST_STEPS,
    )
    return found.x, float(found.cost)


def information(jacobian: np.ndarray, parameters: int) -> np.ndarray:
    """Information on the first unknowns with the others marginalised (Schur complement)."""
    whole = jacobian.T @ jacobian
    own, shared, others = (
        whole[:parameters, :parameters],
        whole[:parameters, parameters:],
        whole[parameters:, parameters:],
    )
    return own if others.size == 0 else own - shared @ np.linalg.solve(others, shared.T)


def _unidentifiable(problem: Problem, unknowns: np.ndarray) -> np.ndarray:
    """Orthonormal directions of the scaled parameters that are not identifiable. (p, k)"""
    found, directions = np.linalg.eigh(information(problem.jacobian(unknowns), len(problem.names)))
    return directions[:, found < 1.0 / _UNKNOWN**2]


def _covariance(problem: Problem, unknowns: np.ndarray, unidentifiable: np.ndarray) -> np.ndarray:
    """Covariance of the scaled parameters, with 100 % deviation in the directions that are not identifiable."""
    determined = information(problem.jacobian(unknowns), len(problem.names))
    return np.linalg.inv(determined + unidentifiable @ unidentifiable.T / _UNKNOWN**2)


def _widened(chi_square: float, freedom: int) -> float:
    from scipy.special import chdtrc

    if freedom == 0 or chdtrc(freedom, chi_square) > DOUBT:
        return 1.0
    return math.sqrt(chi_square / freedom)


def _involved(unidentifiable: np.ndarray) -> np.ndarray:
    """Mask of the parameters that are not identifiable separately."""
    return np.any(np.abs(unidentifiable) > _INVOLVED, axis=1)


def _combinations(
    problem: Problem, unidentifiable: np.ndarray, values: Mapping[str, float], covariance: np.ndarray
) -> tuple[Combination, ...]:
    """Independent identifiable sums of parameters that are not identifiable separately, in row echelon form."""
    involved = _involved(unidentifiable)
    if not involved.any():
        return ()
    names = [name for name, part in zip(problem.names, involved, strict=True) if part]
    # Complement of the directions that are not identifiable, in the space of the parameters in SI.
    _, _, directions = np.linalg.svd(
        (np.eye(len(problem.names)) - unidentifiable @ unidentifiable.T)[np.ix_(involved, involved)]
    )
    space = directions[: max(len(names) - unidentifiable.shape[1], 0)] / problem.scales[involved]
    found = []
    for row in _echelon(space * problem.scales[involved].max()):
        weights = np.zeros(len(problem.names))
        weights[involved] = row
        value = sum(weight * values[name] for name, weight in zip(names, row, strict=True))
        found.append(
            Combination(
                weights=FrozenDict({name: float(w) for name, w in zip(names, row, strict=True) if abs(w) > 1e-6}),
                value=float(value),
                deviation=float(math.sqrt(weights @ covariance @ weights)),
            )
        )
    return tuple(found)


def _echelon(matrix: np.ndarray) -> list[np.ndarray]:
    """Nonzero rows of the reduced row echelon form."""
    rows, rank = matrix.copy(), 0
    size = np.abs(matrix).max(initial=0.0)
    for column in range(rows.shape[1]):
        if rank == len(rows):
            break
        pivot = rank + int(np.argmax(np.abs(rows[rank:, column])))
        if abs(rows[pivot, column]) < 1e-6 * size:
            continue
        rows[[rank, pivot]] = rows[[pivot, rank]]
        rows[rank] /= rows[rank, column]
        others = np.arange(len(rows)) != rank
        rows[others] -= rows[others, column : column + 1] * rows[rank]
        rank += 1
    return list(rows[:rank])
