"""Result of a calibration: fit, identifiability, and proposed runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

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
    name: str
    data: RigData
    laws: LawChoice
    left_out: tuple[LeftOut, ...]
    efficiencies: Efficiencies
    eq9: tuple[np.ndarray, np.ndarray]
    plan: Plan

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

    @property
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

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        fit, found = self.fit, self.efficiencies
        return {
            "drive": self.name,
            "data": self.data.name,
            "runs": len(self.data),
            "left_out_lines": [{"line": one.line, "reason": one.reason} for one in self.left_out],
            "creep_law": {
                "study": self.laws.asked,
                "fitted": fit.law,
                "undecided": list(self.laws.undecided),
                "agreeing": list(self.laws.agreeing),
                "contradicted": self.laws.contradicted,
                "fits": not self.laws.misfit,
                "gain_of_free_bend": self.laws.gain,
                "laws": [
                    {
                        "law": one.law,
                        "chi_square": one.fit.chi_square,
                        "worse_by": one.behind,
                        "values": dict(one.fit.values),
                    }
                    for one in self.laws.candidates
                ],
            },
            **fit.to_dict(model.PARAMETERS, self.known),
            "chi_square": fit.chi_square,
            "degrees_of_freedom": fit.freedom,
            "intervals_widened_by": fit.widened,
            "efficiency": [
                {"line": line, "ratio": ratio, "load": load, "value": value, "standard_deviation": deviation}
                for line, ratio, load, value, deviation in zip(
                    self.data.lines,
                    found.ratio.tolist(),
                    found.load.tolist(),
                    found.value.tolist(),
                    found.deviation.tolist(),
                    strict=True,
                )
            ],
            "creep_stiffness_by_eq9": [
                {
                    "line": self.data.lines[row],
                    "value": float(self.eq9[0][row]),
                    "standard_deviation": float(self.eq9[1][row]),
                }
                for row in np.flatnonzero(np.isfinite(self.eq9[0]))
            ],
            "runs_to_tell_laws_apart": [
                {"between": list(one.between), **one.setting._asdict(), "standard_deviations": one.apart}
                for one in self.plan.telling
            ],
            "next_runs": [setting._asdict() for setting in self.plan.settings],
            "expected_standard_deviations": dict(self.plan.deviations),
            "remarks": list(self.remarks),
        }


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
