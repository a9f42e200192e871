"""Result of the calibration of a geared drive."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.fields import value_at
from infinivar._core.result import Result, result
from infinivar.calibration.data import LeftOut
from infinivar.calibration.fit import Fit
from infinivar.calibration.fitted import Fitted
from infinivar.calibration.geared import model, words
from infinivar.calibration.words import with_interval
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError
from infinivar.study.study import Study

_FIELDS = {
    "resistance": ("motor.resistance",),
    "torque_constant": ("motor.torque_constant",),
    "motor_friction": ("motor.no_load_current",),
    "motor_viscous": ("motor.viscous_friction",),
    "friction": ("gearhead.friction.friction",),
    "viscous": ("gearhead.friction.viscous",),
    "load_share": ("gearhead.friction.load_output", "gearhead.friction.load_motor"),
    "friction_stribeck": ("gearhead.friction.friction_stribeck",),
    "stribeck_speed": ("gearhead.friction.stribeck_speed",),
}
"""Fields of the drive that a parameter sets."""


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
    data: Any
    fit: Fit = reported(key="*")
    left_out: tuple[LeftOut, ...] = reported(key="left_out_lines")

    _also = (at("data.name", key="data"), at("data.kind"), at("fit.freedom", key="degrees_of_freedom"))

    @property
    def drive(self) -> ConventionalDrive:
        """The drive of the study."""
        return geared(self.study, self.name)

    @property
    def values(self) -> dict[str, float]:
        """Every parameter, fitted or from the study. [SI]"""
        return {**self.known, **self.fit.values}

    @property
    def known(self) -> dict[str, float]:
        """Parameters of the study. [SI]"""
        return model.known_values(self.drive)

    @property
    def calibrated(self) -> ConventionalDrive:
        """The drive with the fitted values; the gearhead has measured friction if it was on the bench."""
        motor = model.motor_with(self.drive.motor, self.values)
        if not self._with_gear:
            return replace(self.drive, motor=motor)
        return replace(self.drive, motor=motor, gearhead=model.gearhead_with(self.drive.gearhead, self.values))

    @property
    def _with_gear(self) -> bool:
        return any(name in model.OF_GEAR for name in self.fit.names)

    @property
    def summary(self) -> str:
        """Kind and number of the data."""
        return f"{self.data.kind}, {len(self.data) - len(self.left_out)} rows"

    @property
    def rows(self) -> tuple[Fitted, ...]:
        """Values in which the calibrated drive differs from the study's."""
        return tuple(self._rows_of())

    def _rows_of(self) -> Iterator[Fitted]:
        made, fit = self.calibrated, self.fit
        source = f"{Path(self.data.name).name}, {self.summary}"
        if self._with_gear:
            yield Fitted("gearhead.loss_model", "stribeck", "", "derived", source, None, "")
        for name in model.PARAMETERS:
            of_gear = name in model.OF_GEAR
            if name not in fit.names and not (of_gear and self._with_gear) and name != "motor_friction":
                continue
            for place, path in enumerate(_FIELDS[name]):
                value = value_at(made, path)
                if value is None:
                    continue
                unit = "A" if path == "motor.no_load_current" else model.PARAMETERS[name].unit
                if name not in fit.names:
                    if of_gear or value != value_at(self.drive, path):
                        yield Fitted(path, value, unit, "derived", "the friction of the study", None, "")
                    continue
                deviation, kind, where = fit.deviations[name], "fitted", source
                if not math.isfinite(deviation):
                    kind, where = "assumed", f"{source}: not identifiable separately"
                elif name == "load_share":
                    where = f"{source}: load_output carries the interval of both load terms"
                slope = self._slope(path)
                spread = abs(slope) * deviation if math.isfinite(deviation) and place == 0 else None
                yield Fitted(path, value, unit, kind, where, spread, name, slope)

    def _slope(self, path: str) -> float:
        """Derivative of a field with respect to its parameter.

        Both load terms follow one share, and friction depends on their sum: the first carries the interval of both.
        """
        if path == "gearhead.friction.load_output":
            return 2.0
        if path != "motor.no_load_current":
            return 1.0
        values = self.values
        constant = values["torque_constant"]
        return 1.0 / (constant + values["motor_viscous"] * values["resistance"] / constant)

    @property
    def warnings(self) -> tuple[str, ...]:
        """None: there is one law."""
        return ()

    @derived()
    def remarks(self) -> tuple[str, ...]:
        """Remarks, one sentence each."""
        return tuple(words.remarks(self.fit, self.left_out))

    @property
    def verdict(self) -> str:
        """One-line verdict: identifiable parameters and combinations with their intervals."""
        fit = self.fit
        told = [
            f"{name} = {with_interval(fit.values[name], fit.deviations[name], model.PARAMETERS[name])}"
            for name in fit.told
        ]
        told += [words.sum_in_words(one, fit) for one in fit.combinations]
        return "; ".join(told)

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
    def _parameters(self) -> dict[str, Any]:
        return self.fit.estimates(model.PARAMETERS, self.known)

    @derived()
    def _noise(self) -> dict[str, float]:
        return dict(zip(self.data.signals, self.fit.problem.noise.tolist(), strict=True))

    @derived()
    def _residual_rms(self) -> dict[str, float]:
        return dict(zip(self.data.signals, self.rms.tolist(), strict=True))


def geared(study: Study, name: str) -> ConventionalDrive:
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
