"""The least-squares problem of a calibration: unknowns, their scales and bounds, residuals in standard deviations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.calibration.bench import Bench, Error
from infinivar.study.rig import Rig

STEP = 1e-5
"""Step of differences for unknowns of order 1; the error is about 1e-10."""

BEND = "bend"
"""Name of the curvature error of a law among the unknowns."""

_FARTHEST = 100.0
"""Bound of the errors of the sensors, in standard deviations."""

_UNPREDICTED = 1e3
"""Residual, in standard deviations, of a reading that the model cannot predict, such as under slip."""

_FIRST = 0.05
"""First guess of the noise of a signal, over its root mean square."""

_LEAST = 1e-7
"""Least noise of a signal, over its root mean square: data without any keep finite weights."""

_MOST_ALIKE = 0.9999
"""Factor on correlations of signals, which keeps their matrix invertible."""


@result
class Problem(Frozen):
    """Unknowns and residuals of a calibration.

    Unknowns are the requested parameters, each relative to a scale, then the errors that rows have in common, in standard
    deviations. The known accuracy of the rig holds these near zero, which widens the intervals correctly.

    Attributes
    ----------
    drive, rig, data : the drive of the study, and its readings on the bench.
    names : names of the requested parameters.
    known : values of all parameters in the study. [SI]
    scales : scales of the requested parameters. [SI]
    errors : names of the common errors among the unknowns.
    noise : (m,) standard deviation of each signal; 1 where `whitening` states it.
    whitening : matrices (n, m, m) of the rows, or one of all, (m, m), that map the residuals of the signals over their noise to
        independent ones; None if they are.
    beside : drive with another law, the difference to which is uncertain by the share `bend`; None if the law is exact.
    """

    drive: Any
    rig: Rig
    data: Bench
    names: tuple[str, ...]
    known: Mapping[str, float]
    scales: np.ndarray
    errors: tuple[str, ...]
    noise: np.ndarray
    whitening: np.ndarray | None
    beside: Any = None
    bend: float = 0.0

    @classmethod
    def of(cls, drive: Any, rig: Rig, data: Bench, names: tuple[str, ...]) -> Problem:
        """Set up the problem of fitting parameters to readings."""
        sizes, whitening = data.scales(drive), data.whitening(drive, rig)
        return cls(
            drive=drive,
            rig=rig,
            data=data,
            names=names,
            known=data.known(drive),
            scales=np.asarray([sizes[name] for name in names]),
            errors=_errors(data, rig),
            noise=_FIRST * _size(data) if whitening is None else np.ones(len(data.signals)),
            whitening=whitening,
        )

    @property
    def start(self) -> np.ndarray:
        """Unknowns at the study's values, moved inside the bounds."""
        given = np.asarray([self.known[name] for name in self.names]) / self.scales
        return np.clip(np.concatenate([given, np.zeros(len(self.errors))]), *self.bounds)

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the unknowns: most parameters are positive, divisors well above zero, with room for a step of differences.

        Errors stay where the model is valid, as a fit with the wrong law could try a negative preload.
        """
        fitted = [self.data.parameters[name] for name in self.names]
        least = [
            1e-3 if one.divides else one.least / scale + 2.0 * STEP
            for one, scale in zip(fitted, self.scales, strict=True)
        ]
        most = [one.most / scale for one, scale in zip(fitted, self.scales, strict=True)]
        stated = self.data.errors(self.rig)
        ends = [stated.get(name, Error(1.0)) for name in self.errors]
        errors = np.asarray([min(_FARTHEST, 0.9 * end.most / end.deviation) for end in ends])
        return np.concatenate([least, -errors]), np.concatenate([most, errors])

    def values(self, unknowns: np.ndarray) -> dict[str, Any]:
        """Every parameter, fitted or from the study. [SI]"""
        fitted = {name: unknowns[..., i : i + 1] * self.scales[i] for i, name in enumerate(self.names)}
        return {**self.known, **fitted}

    def expected(self, unknowns: np.ndarray) -> np.ndarray:
        """Expected readings. (..., n, m)"""
        stated, values = self.data.errors(self.rig), self.values(unknowns)
        of = {name: unknowns[..., len(self.names) + i][..., None] for i, name in enumerate(self.errors)}
        off = {name: error.deviation * of[name] for name, error in stated.items() if name in of}
        found = self.data.expected(self.drive, self.rig, values, off)
        if self.beside is None:
            return found
        apart = found - self.data.expected(self.beside, self.rig, values, off)
        bent = np.isin(self.data.signals, self.data.uncertain) & np.isfinite(apart)
        return found + (self.bend * of[BEND])[..., None] * np.where(bent, apart, 0.0)

    def residuals(self, unknowns: np.ndarray) -> np.ndarray:
        """Independent residuals of all readings and of the common errors, in standard deviations.

        Parameters
        ----------
        unknowns : (..., k) float   One or more sets of unknowns.

        Returns
        -------
        (..., n m + errors) float
        """
        off = (self.data.read - self.expected(unknowns)) / self.noise
        predicted = np.isfinite(off)
        if self.whitening is not None:
            off = np.einsum("...ij,...j->...i", self.whitening, np.where(predicted, off, 0.0))
        flat = np.where(predicted, off, _UNPREDICTED).reshape(*off.shape[:-2], -1)
        return np.concatenate([flat, unknowns[..., len(self.names) :]], axis=-1)

    def jacobian(self, unknowns: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals, by central differences in one pass. (residuals, unknowns)"""
        steps = STEP * np.eye(unknowns.size)
        return ((self.residuals(unknowns + steps) - self.residuals(unknowns - steps)) / (2.0 * STEP)).T

    def of_rows(self, residuals: np.ndarray) -> np.ndarray:
        """Residuals of the readings by row. (n, m)"""
        return residuals[: len(self.data) * len(self.noise)].reshape(len(self.data), -1)

    @property
    def used(self) -> np.ndarray:
        """Mask of the readings that the fit uses. (n, m)"""
        all_ = np.ones((len(self.data), len(self.noise)), dtype=bool)
        return all_ if self.whitening is None else all_ & np.any(self.whitening != 0, axis=-1)

    @property
    def readings(self) -> int:
        """Number of readings that the fit uses."""
        return int(np.count_nonzero(self.used))

    @property
    def law(self) -> str:
        """Name of the model's creep law."""
        return self.drive.transmission.creep_law.name

    def farthest(self, unknowns: np.ndarray) -> np.ndarray:
        """Largest deviation of the readings of each row, in standard deviations. (n,)"""
        return np.abs(self.of_rows(self.residuals(unknowns))).max(axis=1)

    def first_off(self, unknowns: np.ndarray, row: int, far: float) -> tuple[str, float, float, float]:
        """The deviating reading of a row: signal, value read, value expected, and deviation.

        Whitened readings are ordered as the signals, each without the part explained by those before. Returned is the first
        beyond `far`, or the farthest if none is.
        """
        off = np.abs(self.of_rows(self.residuals(unknowns))[row])
        place = int(np.argmax(off > far)) if np.any(off > far) else int(np.argmax(off))
        read, expected = (float(values[row, place]) for values in (self.data.read, self.expected(unknowns)))
        return self.data.signals[place], read, expected, float(off[place])

    def under(self, drive: Any) -> Problem:
        """The problem with another model of the drive and the same weights."""
        return replace(self, drive=drive)

    def bending(self, beside: Any, deviation: float) -> Problem:
        """The problem with an uncertain law: readings vary by a share of their difference from those of another drive."""
        return replace(self, beside=beside, bend=deviation, errors=(*self.errors, BEND))

    def about(self, data: Bench) -> Problem:
        """The same problem for other rows, with the same noise where the residuals show it."""
        whitening = data.whitening(self.drive, self.rig)
        if whitening is None:
            return replace(self, data=data)
        bent = () if self.beside is None else (BEND,)
        return replace(self, data=data, errors=(*_errors(data, self.rig), *bent), whitening=whitening)

    def without(self, rows: np.ndarray) -> Problem:
        """The problem without some of the rows."""
        whitening = self.whitening
        if whitening is not None and whitening.ndim == 3:
            whitening = whitening[~rows]
        return replace(self, data=self.data.chosen(~rows), whitening=whitening)

    @property
    def separate(self) -> Problem:
        """The problem whose residuals are those of each signal, over its noise."""
        return replace(self, whitening=None)

    def heard(self, noise: np.ndarray) -> Problem:
        """The problem with other noise; the same for signals of sensors that are alike."""
        if self.data.alike:
            noise = np.full(noise.shape, np.sqrt(np.mean(np.square(noise))))
        return replace(self, noise=np.maximum(noise, _LEAST * _size(self.data)))

    def decorrelated(self, off: np.ndarray) -> Problem:
        """The problem with signals as correlated as residuals (n, m) of the readings, if the data share errors."""
        if not self.data.shared_errors or off.shape[1] < 2:
            return self
        products = off.T @ off
        size = np.sqrt(np.diag(products))
        together = _MOST_ALIKE * products / (size[:, None] * size) + (1.0 - _MOST_ALIKE) * np.eye(len(size))
        return replace(self, whitening=np.linalg.inv(np.linalg.cholesky(together)))


def _errors(data: Bench, rig: Rig) -> tuple[str, ...]:
    """Names of the common errors that are uncertain."""
    return tuple(name for name, error in data.errors(rig).items() if error.deviation > 0)


def _size(data: Bench) -> np.ndarray:
    """Root mean square of each signal, a positive number. (m,)"""
    size = np.sqrt(np.mean(np.square(data.read), axis=0))
    return np.where(size > 0, size, 1.0)
