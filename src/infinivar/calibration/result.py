"""Results of calibrations: fit, identifiability, calibrated drive, and of a transmission the runs to measure next."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.fields import with_values
from infinivar._core.result import Result, result
from infinivar.calibration import fitted, geared, words
from infinivar.calibration.bench import LeftOut
from infinivar.calibration.fit import Fit
from infinivar.calibration.fitted import Fitted
from infinivar.calibration.geared import GearedBench
from infinivar.calibration.laws import LawChoice
from infinivar.calibration.plan import Plan
from infinivar.calibration.reduce import Efficiencies
from infinivar.calibration.transmission import RigData
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError
from infinivar.study.study import Study


@result
class Calibration(Result):
    """A drive calibrated with rig data.

    Attributes
    ----------
    study, name          The study and the drive in it.
    data                 Runs, without those excluded on request.
    laws                 Selection of the creep law, and the fit with the law used.
    left_out             Excluded runs (impossible readings or outliers) with reasons.
    efficiencies         Efficiencies of all runs by Eq 18.
    eq9                  Creep stiffness of all runs by Eq 9 and its standard deviation; nan unless the wheel is locked. [N]
    plan                 Proposed runs.
    """

    study: Study
    name: str = reported(key="drive")
    data: RigData
    laws: LawChoice = reported(key="creep_law")
    left_out: tuple[LeftOut, ...] = reported(key="left_out_lines")
    efficiencies: Efficiencies
    eq9: tuple[np.ndarray, np.ndarray]
    plan: Plan = reported(key="*")

    _also = (
        at("data.name", key="data"),
        at("fit", key="*"),
        at("fit.chi_square"),
        at("fit.freedom", key="degrees_of_freedom"),
        at("fit.widened", key="intervals_widened_by"),
    )

    @property
    def fit(self) -> Fit:
        """Estimates and intervals, including the uncertainty of the creep law."""
        return self.laws.fit

    @property
    def drive(self) -> CoboticDrive:
        """The drive of the study."""
        return cobotic(self.study, self.name)

    @property
    def calibrated(self) -> CoboticDrive:
        """The drive with the fitted values."""
        drive, values = self.drive, {row.path: row.value for row in self.rows}
        if drive.transmission.geometry is None or "transmission.creep_stiffness" not in values:
            return with_values(drive, values)
        # Measured groups and geometry exclude each other, so all groups replace the geometry together.
        groups = {
            path.removeprefix("transmission."): value
            for path, value in values.items()
            if path.startswith("transmission.")
        }
        element = replace(drive.transmission, geometry=None, steering_model="shear", **groups)
        steering = drive.steering and replace(
            drive.steering, patch_half_length=values.get("steering.patch_half_length")
        )
        others = {path: value for path, value in values.items() if not path.startswith(("transmission.", "steering."))}
        return with_values(replace(drive, transmission=element, steering=steering), others)

    @property
    def summary(self) -> str:
        """Law, and number of the data."""
        return f"{self.fit.law} creep law, {len(self.data) - len(self.left_out)} runs"

    @property
    def known(self) -> dict[str, float]:
        """Parameters of the study. [SI]"""
        return dict(self.fit.problem.known)

    @property
    def rows(self) -> tuple[Fitted, ...]:
        """Values in which the calibrated drive differs from the study's."""
        source = f"{Path(self.data.name).name}, {len(self.data) - len(self.left_out)} runs"
        return tuple(fitted.of_transmission(self.drive, self.fit, source))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings: the data contradict the study's creep law, or no law fits."""
        return tuple(words.warnings(self.laws))

    @derived()
    def remarks(self) -> tuple[str, ...]:
        """Warnings and remarks, one sentence each; warnings first."""
        return tuple(words.remarks(self.laws, self.plan, self.data, self.left_out, self.drive))

    @property
    def verdict(self) -> str:
        """One-line verdict: identifiable parameters and sums with their intervals."""
        return words.verdict(self.fit)

    @derived()
    def _runs(self) -> int:
        return len(self.data)

    @derived()
    def _efficiency(self) -> list[dict[str, Any]]:
        found = self.efficiencies
        names = ("line", "ratio", "load", "value", "standard_deviation")
        rows = zip(self.data.lines, found.ratio, found.load, found.value, found.deviation, strict=True)
        return [dict(zip(names, row, strict=True)) for row in rows]

    @derived()
    def _creep_stiffness_by_eq9(self) -> list[dict[str, Any]]:
        rows = zip(self.data.lines, *self.eq9, strict=True)
        names = ("line", "value", "standard_deviation")
        return [dict(zip(names, row, strict=True)) for row in rows if np.isfinite(row[1])]


@result
class GearedCalibration(Result):
    """Motor and gearhead of a conventional drive, calibrated on a dynamometer or by a pendulum.

    Attributes
    ----------
    study, name   The study and the drive in it.
    data          Rows of the file.
    fit           Estimates, covariance, and directions that the data do not determine.
    left_out      Excluded rows (impossible readings or outliers) with reasons.
    """

    study: Study
    name: str = reported(key="drive")
    data: GearedBench
    fit: Fit = reported(key="*")
    left_out: tuple[LeftOut, ...] = reported(key="left_out_lines")

    _also = (at("data.name", key="data"), at("data.kind"), at("fit.freedom", key="degrees_of_freedom"))

    @property
    def drive(self) -> ConventionalDrive:
        """The drive of the study."""
        return conventional(self.study, self.name)

    @property
    def values(self) -> dict[str, float]:
        """Every parameter, fitted or from the study. [SI]"""
        return {**self.known, **self.fit.values}

    @property
    def known(self) -> dict[str, float]:
        """Parameters of the study. [SI]"""
        return dict(self.fit.problem.known)

    @property
    def calibrated(self) -> ConventionalDrive:
        """The drive with the fitted values; the gearhead has measured friction if it was on the bench."""
        motor = geared.motor_with(self.drive.motor, self.values)
        if not any(name in geared.OF_GEAR for name in self.fit.names):
            return replace(self.drive, motor=motor)
        return replace(self.drive, motor=motor, gearhead=geared.gearhead_with(self.drive.gearhead, self.values))

    @property
    def summary(self) -> str:
        """Kind and number of the data."""
        return f"{self.data.kind}, {len(self.data) - len(self.left_out)} rows"

    @property
    def rows(self) -> tuple[Fitted, ...]:
        """Values in which the calibrated drive differs from the study's."""
        source = f"{Path(self.data.name).name}, {self.summary}"
        return tuple(fitted.of_gear(self.drive, self.calibrated, self.fit, source))

    @property
    def warnings(self) -> tuple[str, ...]:
        """None: there is one law."""
        return ()

    @derived()
    def remarks(self) -> tuple[str, ...]:
        """Remarks, one sentence each."""
        return tuple(words.remarks_on_gear(self.fit, self.left_out))

    @property
    def verdict(self) -> str:
        """One-line verdict: identifiable parameters and combinations with their intervals."""
        return words.verdict(self.fit)

    @property
    def residuals(self) -> np.ndarray:
        """Read less expected, of the rows used. (n, m), in the units of the signals"""
        problem = self.fit.problem
        return problem.data.read - problem.expected(self.fit.unknowns)

    @property
    def rms(self) -> np.ndarray:
        """Root mean square of the residuals of each signal. (m,)"""
        return np.sqrt(np.mean(self.residuals**2, axis=0))

    @derived(key="rows")
    def _row_count(self) -> int:
        return len(self.data)

    @derived()
    def _noise(self) -> dict[str, float]:
        return dict(zip(self.data.signals, self.fit.problem.noise.tolist(), strict=True))

    @derived()
    def _residual_rms(self) -> dict[str, float]:
        return dict(zip(self.data.signals, self.rms.tolist(), strict=True))


def conventional(study: Study, name: str) -> ConventionalDrive:
    """Return a conventional drive of a study.

    Raises
    ------
    InputError
        If the drive does not exist or is of another type.
    """
    drive = study.drive(name)
    if not isinstance(drive, ConventionalDrive):
        raise InputError(f"{study.path or study.name}: drives.{name} must be a conventional drive")
    return drive


def cobotic(study: Study, name: str) -> CoboticDrive:
    """Return a cobotic drive of a study.

    Raises
    ------
    InputError
        If the drive does not exist or is of another type.
    """
    drive = study.drive(name)
    if not isinstance(drive, CoboticDrive):
        raise InputError(
            f"{study.path or study.name}: drives.{name} must be a cobotic drive; this drive has no wheel to measure"
        )
    return drive
