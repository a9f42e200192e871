"""The least-squares problem of a geared drive: unknowns, scales and bounds; residuals in units of the noise that they show."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.calibration import fit as fitting
from infinivar.calibration.fit import Fit
from infinivar.calibration.geared import model
from infinivar.calibration.geared.model import Gains
from infinivar.calibration.unknowns import FARTHEST, STEP, UNPREDICTED, jacobian_of, start_of, values_of
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.study.rig import Rig
from infinivar.study.spreads import NORMAL_95

_FIRST = 0.05
"""First guess of the noise of a signal, over its root mean square."""

_LEAST = 1e-7
"""Least noise of a signal, over its root mean square: data without any keep finite weights."""

_ROUNDS = 4
"""Refits with the noise that the residuals show."""

_MOST_ALIKE = 0.9999
"""Factor on correlations of signals, which keeps their matrix invertible."""

_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""
_MORE = 5.0
"""Of the factor ``1 + 5/(n - p)`` that corrects a median of few residuals."""


class BenchData(Protocol):
    """Data of a geared drive: rows of readings, and what a drive would give."""

    @property
    def kind(self) -> str:
        """Word for the kind of data."""
        ...

    @property
    def name(self) -> str:
        """Name of the file."""
        ...

    @property
    def lines(self) -> tuple[int, ...]:
        """Line of each row in the file."""
        ...

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of the readings."""
        ...

    @property
    def read(self) -> np.ndarray:
        """Readings, (n, m)."""
        ...

    @property
    def shared_errors(self) -> bool:
        """Whether an error of one sensor is in the expected readings of several signals."""
        ...

    @property
    def usual(self) -> tuple[str, ...]:
        """Parameters fitted by default."""
        ...

    def __len__(self) -> int:
        """Number of rows."""
        ...

    def chosen(self, rows: Any) -> Any:
        """Select rows by index or mask."""
        ...

    def refusal(self, name: str) -> str | None:
        """Why a parameter cannot be fitted, or None."""
        ...

    def gain_deviations(self, rig: Rig) -> dict[str, float]:
        """Standard deviations of the errors common to all rows, by field of `Gains`."""
        ...

    def faults(self) -> dict[int, str]:
        """Reasons why rows cannot be used, by row."""
        ...

    def expected(self, drive: ConventionalDrive, values: Mapping[str, Any], gains: Gains) -> np.ndarray:
        """Expected readings, (..., n, m)."""
        ...


@result
class Problem(Frozen):
    """Unknowns and residuals: parameters relative to a scale, then the errors of gains in standard deviations.

    Attributes
    ----------
    names : names of the fitted parameters.
    known : values of all parameters in the study. [SI]
    scales : scales of the fitted parameters. [SI]
    errors : names of the gains among the unknowns.
    noise : (m,) standard deviation of each signal.
    whitening : (m, m) matrix that maps the signals' residuals over their noise to independent ones; None if they are.
    """

    drive: ConventionalDrive
    rig: Rig
    data: Any
    names: tuple[str, ...]
    known: Mapping[str, float]
    scales: np.ndarray
    errors: tuple[str, ...]
    noise: np.ndarray
    whitening: np.ndarray | None = None

    @classmethod
    def of(cls, drive: ConventionalDrive, rig: Rig, data: BenchData, names: tuple[str, ...]) -> Problem:
        """Set up the problem of fitting parameters to data."""
        known, natural = model.known_values(drive), model.natural_scales(drive)
        deviations = data.gain_deviations(rig)
        return cls(
            drive=drive,
            rig=rig,
            data=data,
            names=names,
            known=FrozenDict(known),
            scales=np.asarray([max(known[name], natural[name]) for name in names]),
            errors=tuple(name for name, deviation in deviations.items() if deviation > 0),
            noise=_FIRST * _size(data),
        )

    @property
    def start(self) -> np.ndarray:
        """Unknowns at the study's values, moved inside the bounds."""
        return start_of(self)

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the unknowns: positive, divisors well above zero; a load share at which the gear is not jammed."""
        divisors = ("resistance", "torque_constant", "stribeck_speed")
        least = [1e-3 if name in divisors else 2.0 * STEP for name in self.names]
        most = [
            0.9 / scale if name == "load_share" else math.inf
            for name, scale in zip(self.names, self.scales, strict=True)
        ]
        gains = np.full(len(self.errors), FARTHEST)
        return np.concatenate([least, -gains]), np.concatenate([most, gains])

    @property
    def readings(self) -> int:
        """Number of readings that the fit uses."""
        return len(self.data) * len(self.noise)

    def values(self, unknowns: np.ndarray) -> dict[str, Any]:
        """Every parameter, in SI."""
        return values_of(self, unknowns)

    def gains(self, unknowns: np.ndarray) -> Gains:
        """Errors of the gains."""
        scales = self.data.gain_deviations(self.rig)
        place = len(self.names)
        return Gains(**{name: scales[name] * unknowns[..., place + i][..., None] for i, name in enumerate(self.errors)})

    def expected(self, unknowns: np.ndarray) -> np.ndarray:
        """Expected readings. (..., n, m)"""
        return self.data.expected(self.drive, self.values(unknowns), self.gains(unknowns))

    def residuals(self, unknowns: np.ndarray) -> np.ndarray:
        """Independent residuals of all readings and of the gains, in standard deviations. (..., n m + errors)"""
        off = self.off(unknowns)
        if self.whitening is not None:
            off = off @ self.whitening.T
        flat = off.reshape(*off.shape[:-2], -1)
        return np.concatenate([flat, unknowns[..., len(self.names) :]], axis=-1)

    def off(self, unknowns: np.ndarray) -> np.ndarray:
        """Residuals of the readings, each over the noise of its signal. (..., n, m)"""
        off = (self.data.read - self.expected(unknowns)) / self.noise
        return np.where(np.isfinite(off), off, UNPREDICTED)

    def jacobian(self, unknowns: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals, by central differences in one pass."""
        return jacobian_of(self.residuals, unknowns)

    def of_runs(self, residuals: np.ndarray) -> np.ndarray:
        """Residuals of the readings by row. (n, m)"""
        return residuals[: self.readings].reshape(len(self.data), -1)

    def farthest(self, unknowns: np.ndarray) -> np.ndarray:
        """Largest deviation of the readings of each row, in standard deviations. (n,)"""
        return np.abs(self.of_runs(self.residuals(unknowns))).max(axis=1)

    def without(self, rows: np.ndarray) -> Problem:
        """The problem without some of the rows."""
        return replace(self, data=self.data.chosen(~rows))

    def about(self, data: BenchData) -> Problem:
        """The same problem, with the same noise, for other rows."""
        return replace(self, data=data)

    def heard(self, noise: np.ndarray) -> Problem:
        """The problem with other noise."""
        return replace(self, noise=np.maximum(noise, _LEAST * _size(self.data)))

    def decorrelated(self, off: np.ndarray) -> Problem:
        """The problem with signals as correlated as residuals (n, m) of the readings, if the data share errors."""
        if not self.data.shared_errors or off.shape[1] < 2:
            return self
        products = off.T @ off
        size = np.sqrt(np.diag(products))
        together = _MOST_ALIKE * products / (size[:, None] * size) + (1.0 - _MOST_ALIKE) * np.eye(len(size))
        return replace(self, whitening=np.linalg.inv(np.linalg.cholesky(together)))


def _size(data: BenchData) -> np.ndarray:
    """Root mean square of each signal, a positive number. (m,)"""
    size = np.sqrt(np.mean(np.square(data.read), axis=0))
    return np.where(size > 0, size, 1.0)


def fit(problem: Problem) -> Fit:
    """Fit a geared drive: noise and outliers by robust fits, then weighted least squares with the noise that is left.

    The noise of each signal is that of its residuals, so errors of the model count as noise. An error of a sensor on which the
    expected readings of several signals depend makes their residuals alike; the last fits count it once.

    Raises
    ------
    InputError
        If more than a third of the rows deviate like outliers.

    Source: definition of feasible generalised least squares.
    """
    from scipy.special import stdtrit

    found = fitting.robust(problem)
    for _ in range(_ROUNDS):
        off = np.abs(problem.of_runs(problem.residuals(found.unknowns)))
        problem = problem.heard(problem.noise * _robust_size(off, len(problem.names)))
        found = fitting.robust(problem, found.unknowns)
    found = fitting.settled(found)
    fitting.refuse_many(problem.data, int(np.count_nonzero(found.beyond)))
    done = fitting.estimate(problem, found.unknowns, found.beyond)
    for _ in range(_ROUNDS):
        kept: Problem = done.problem
        off = kept.off(done.unknowns)
        freedom = 1.0 - min((len(problem.names) - done.untold.shape[1]) / kept.readings, 0.9)
        problem = problem.heard(kept.noise * np.sqrt(np.mean(off**2, axis=0) / freedom)).decorrelated(off)
        done = fitting.estimate(problem, done.unknowns, found.beyond)
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
