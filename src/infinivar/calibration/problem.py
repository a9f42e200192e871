"""The least-squares problem of a calibration: unknowns, their scales and bounds, residuals in standard deviations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infinivar._core.result import Frozen
from infinivar.calibration.data import COLUMNS, RigData
from infinivar.calibration.model import Errors, Readings, known_values, predict
from infinivar.calibration.unknowns import FARTHEST, STEP, UNPREDICTED, jacobian_of, start_of, values_of
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.rig import Rig

BEND = "creep bend"
"""Name of the curvature error of a creep law among the unknowns."""

_COUNTED = 1.0 / math.sqrt(6.0)
"""Standard deviation of the difference of two encoder counts."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Problem(Frozen):
    """Unknowns and residuals of a calibration.

    Unknowns are the requested parameters, each relative to a scale, then the session errors (`Errors`) in standard
    deviations. The known accuracy of the rig holds these near zero, which widens the intervals correctly.

    Attributes
    ----------
    names : names of the requested parameters.
    known : values of all parameters in the study. [SI]
    scales : scales of the requested parameters. [SI]
    errors : names of the session errors among the unknowns; masses by number.
    masses : index of the distinct mass of each run.
    whitening : (n, m, m) matrices that turn the errors of a run into independent unit errors.
    """

    drive: CoboticDrive
    rig: Rig
    data: RigData
    names: tuple[str, ...]
    known: Mapping[str, float]
    scales: np.ndarray
    errors: tuple[str, ...]
    masses: np.ndarray
    whitening: np.ndarray
    beside: str | None = None
    bend: float = 0.0

    @classmethod
    def of(cls, drive: CoboticDrive, rig: Rig, data: RigData, names: tuple[str, ...]) -> Problem:
        """Set up the problem of fitting parameters to runs."""
        known = known_values(drive)
        scales = np.asarray([abs(known[name]) or _natural(drive, known, name) for name in names])
        weighed, masses = np.unique(data.mass, return_inverse=True)
        found = [
            *(["current_gain"] if rig.current_gain_deviation > 0 else []),
            *(["preload"] if rig.preload_deviation > 0 else []),
            *(["steering_zero"] if rig.steering_zero_deviation > 0 else []),
            *(f"mass {i}" for i, mass in enumerate(weighed) if mass > 0 and rig.mass_deviation > 0),
        ]
        whitening = _whitening(drive, rig, data, known)
        return cls(drive, rig, data, names, known, scales, tuple(found), masses, whitening)

    @property
    def start(self) -> np.ndarray:
        """Unknowns at the study's values, moved inside the bounds by the step of differences."""
        return start_of(self)

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the unknowns: parameters are positive, divisors well above zero, with room for a step of differences.

        Session errors stay where the model is valid, as a fit with the wrong law could try a negative preload.
        """
        least = [1e-3 if name in ("creep_stiffness", "torque_constant") else 2.0 * STEP for name in self.names]
        room = 0.5 * math.pi - float(np.abs(self.data.steering_angle).max(initial=0.0))
        most = {"preload": (1.0, self.rig.preload_deviation), "steering_zero": (room, self.rig.steering_zero_deviation)}
        ends = [most.get(name, (math.inf, 1.0)) for name in self.errors]
        errors = np.asarray([min(FARTHEST, 0.9 * end / deviation) for end, deviation in ends])
        return np.concatenate([least, -errors]), np.concatenate([np.full(len(least), np.inf), errors])

    def values(self, unknowns: np.ndarray) -> dict[str, Any]:
        """Every parameter, in SI."""
        return values_of(self, unknowns)

    def session(self, unknowns: np.ndarray) -> Errors:
        """The session's errors, in SI."""
        scales = {
            "current_gain": self.rig.current_gain_deviation,
            "preload": self.rig.preload_deviation,
            "steering_zero": self.rig.steering_zero_deviation,
        }
        column = {name: unknowns[..., len(self.names) + i] for i, name in enumerate(self.errors)}
        off: dict[str, Any] = {
            name: column[name][..., None] * scale for name, scale in scales.items() if name in column
        }
        none = np.zeros(unknowns.shape[:-1])
        count = int(self.masses.max(initial=0)) + 1
        masses = np.stack([column.get(f"mass {i}", none) for i in range(count)], axis=-1)
        return Errors(**off, mass=self.rig.mass_deviation * masses[..., self.masses])

    def residuals(self, unknowns: np.ndarray) -> np.ndarray:
        """Residuals of all readings and of the session errors, in standard deviations.

        Parameters
        ----------
        unknowns : (..., k) float   One or more sets of unknowns.

        Returns
        -------
        (..., n m + errors) float
        """
        predicted = self._predicted(unknowns)
        off = np.stack([read - said for read, said in zip(_readings(self.data), predicted, strict=False)], axis=-1)
        off = np.where(np.isnan(off), UNPREDICTED, np.einsum("nij,...nj->...ni", self.whitening, off))
        flat = off.reshape(*off.shape[:-2], -1)
        return np.concatenate([flat, unknowns[..., len(self.names) :]], axis=-1)

    def _predicted(self, unknowns: np.ndarray) -> Readings:
        values, session = self.values(unknowns), self.session(unknowns)
        predicted = predict(self.drive, self.rig, self.data, values, session)
        if self.beside is None:
            return predicted
        other = predict(_under(self.drive, self.beside), self.rig, self.data, values, session)
        share = self.bend * unknowns[..., len(self.names) + self.errors.index(BEND)][..., None]
        more = predicted.link_travel + share * np.nan_to_num(predicted.link_travel - other.link_travel)
        return predicted._replace(link_travel=more)

    def jacobian(self, unknowns: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals, by central differences in one pass."""
        return jacobian_of(self.residuals, unknowns)

    def of_runs(self, residuals: np.ndarray) -> np.ndarray:
        """Residuals of the readings by run. (n, m)"""
        return residuals[: len(self.data) * self.whitening.shape[-1]].reshape(len(self.data), -1)

    @property
    def readings(self) -> int:
        """Number of readings that the fit uses."""
        return int(np.count_nonzero(np.any(self.whitening != 0, axis=-1)))

    @property
    def law(self) -> str:
        """Name of the model's creep law."""
        return self.drive.transmission.creep_law.name

    def farthest(self, unknowns: np.ndarray) -> np.ndarray:
        """Largest deviation of the readings of each run, in standard deviations. (n,)"""
        return np.abs(self.of_runs(self.residuals(unknowns))).max(axis=1)

    def first_off(self, unknowns: np.ndarray, row: int, far: float) -> tuple[str, str, float, float, float]:
        """The deviating reading of a run: name, unit, value read, value expected, and deviation.

        Whitened readings are ordered travel, current, voltage, each without the part explained by those before. Returned is
        the first beyond `far`, or the farthest if none is.
        """
        off = np.abs(self.of_runs(self.residuals(unknowns))[row])
        place = int(np.argmax(off > far)) if np.any(off > far) else int(np.argmax(off))
        name = Readings._fields[place]
        read, predicted = float(_readings(self.data)[place][row]), float(self._predicted(unknowns)[place][row])
        return name, COLUMNS[name], read, predicted, float(off[place])

    def under(self, law: str) -> Problem:
        """The problem with another creep law and the same weights."""
        return replace(self, drive=_under(self.drive, law))

    def bending(self, beside: str, deviation: float) -> Problem:
        """The problem with uncertain curvature: creep varies by a share of its difference from another law."""
        return replace(self, beside=beside, bend=deviation, errors=(*self.errors, BEND))

    def about(self, data: RigData) -> Problem:
        """The same problem for other runs."""
        other = Problem.of(self.drive, self.rig, data, self.names)
        return other if self.beside is None else other.bending(self.beside, self.bend)

    def without(self, rows: np.ndarray) -> Problem:
        """The problem without some of the runs."""
        keep = ~rows
        return replace(self, data=self.data.chosen(keep), masses=self.masses[keep], whitening=self.whitening[keep])


def _under(drive: CoboticDrive, law: str) -> CoboticDrive:
    return replace(drive, transmission=replace(drive.transmission, creep_law=law))


def _natural(drive: CoboticDrive, known: dict[str, float], name: str) -> float:
    """Scale of a parameter that is zero in the study."""
    element = drive.transmission
    if name == "guideway_friction":
        return 1e-3 * element.preload
    if name == "nominal_torque":
        return 0.1 * drive.motor.continuous_torque
    return 1e-3 * element.wheel_radius * element.slip_force


def _readings(data: RigData) -> tuple[np.ndarray, ...]:
    voltage = () if data.motor_voltage is None else (data.motor_voltage,)
    return data.link_travel, data.motor_current, *voltage


def _whitening(drive: CoboticDrive, rig: Rig, data: RigData, known: dict[str, float]) -> np.ndarray:
    """Whitening matrices from encoder counts, noise, and the resolution of the steering angle, which affects travel, current
    and voltage together."""
    width = len(_readings(data))
    turned = 1e-7
    more, less = (
        np.stack(predict(drive, rig, data, known, Errors(steering_zero=way * turned))[:width], axis=-1)
        for way in (1.0, -1.0)
    )
    by_angle = np.nan_to_num((more - less) / (2.0 * turned))
    mean = 1.0 / np.sqrt(np.maximum(rig.sample_rate * data.duration, 1.0))
    by_cylinder = np.nan_to_num(predict(drive, rig, data, known).link_travel / data.cylinder_angle)
    travel = _COUNTED * np.hypot(rig.link_resolution, by_cylinder * rig.cylinder_resolution)
    own = np.stack([travel, rig.current_noise * mean, rig.voltage_noise * mean][:width], axis=-1)
    own = np.maximum(own, 1e-12)  # keeps weights finite for a rig without noise
    angle = rig.steering_resolution / math.sqrt(12.0) * by_angle
    covariance = own[:, :, None] ** 2 * np.eye(width) + angle[:, :, None] * angle[:, None, :]
    found = np.linalg.inv(np.linalg.cholesky(covariance))
    found[~data.pressed, 0, :] = 0.0  # a lifted wheel moves no link
    return found
