"""Result of a calibration: fit, identifiability, and proposed runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.fields import with_values
from infinivar._core.result import Result, result
from infinivar.calibration import fitted, model, words
from infinivar.calibration.data import LeftOut, RigData
from infinivar.calibration.fit import Fit
from infinivar.calibration.fitted import Fitted
from infinivar.calibration.laws import LawChoice
from infinivar.calibration.plan import Plan
from infinivar.calibration.reduce import Efficiencies
from infinivar.drivetrain.cobotic import CoboticDrive
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
        return model.known_values(self.drive)

    @property
    def _source(self) -> str:
        """Description of the data."""
        return f"{Path(self.data.name).name}, {len(self.data) - len(self.left_out)} runs"

    @property
    def rows(self) -> tuple[Fitted, ...]:
        """Values in which the calibrated drive differs from the study's."""
        return tuple(fitted.rows(self.drive, self.fit, self.known, self._source))

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
        fit = self.fit
        told = [
            f"{name} = {words.with_interval(fit.values[name], fit.deviations[name], model.PARAMETERS[name])}"
            for name in fit.told
        ]
        told += [words.combined(combination) for combination in fit.combinations]
        return "; ".join(told)

    @derived()
    def _runs(self) -> int:
        return len(self.data)

    @derived()
    def _parameters(self) -> dict[str, Any]:
        return self.fit.estimates(model.PARAMETERS, self.known)

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
