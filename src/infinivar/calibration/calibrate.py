"""From a rig's data to a calibrated drive: efficiencies, fitted parameters, what they cannot tell, what to measure next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.fields import with_values
from infinivar.calibration import data as rig_data
from infinivar.calibration import fitted, laws, misread, model, plan, reduce, words
from infinivar.calibration.data import RigData
from infinivar.calibration.fit import FEW, OUTLIER, Fit, refuse_many
from infinivar.calibration.fitted import Fitted
from infinivar.calibration.laws import LawChoice
from infinivar.calibration.plan import Plan
from infinivar.calibration.problem import Problem
from infinivar.calibration.reduce import Efficiencies
from infinivar.contact import creep
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError, nearest
from infinivar.study.study import Study
from infinivar.units import plain


class LeftOut(NamedTuple):
    """A run that was not fitted."""

    row: int
    """Of the data."""
    line: int
    """Of the file."""
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """A drive calibrated by a rig's data.

    Attributes
    ----------
    study, name          The study and the drive in it.
    data                 Runs as given, without those left out on request.
    laws                 What the data say of the creep law, and the fit with the one that is used.
    left_out             Runs that were not fitted, as no rig can give them or they are outliers, each with why.
    efficiencies         Of all runs, by Eq 18.
    eq9                  Creep stiffness of all runs by Eq 9 and its standard deviation; nan where the wheel is not locked. [N]
    plan                 What to measure next.
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
        """Estimates and intervals, with what the creep law leaves open."""
        return self.laws.fit

    @property
    def drive(self) -> CoboticDrive:
        """The drive as the study has it."""
        return cobotic(self.study, self.name)

    @property
    def calibrated(self) -> CoboticDrive:
        """The drive with what was fitted."""
        drive, values = self.drive, {row.path: row.value for row in self.rows}
        if drive.transmission.geometry is None or "transmission.creep_stiffness" not in values:
            return with_values(drive, values)
        # Measured groups take the place of the geometry, all at once: either excludes the other.
        groups = {
            path.removeprefix("transmission."): value
            for path, value in values.items()
            if path.startswith("transmission.")
        }
        element = replace(drive.transmission, geometry=None, **groups)
        steering = drive.steering and replace(
            drive.steering, patch_half_length=values.get("steering.patch_half_length")
        )
        others = {path: value for path, value in values.items() if not path.startswith(("transmission.", "steering."))}
        return with_values(replace(drive, transmission=element, steering=steering), others)

    @property
    def known(self) -> dict[str, float]:
        """The parameters as the study has them. [SI]"""
        return model.known_values(self.drive)

    @property
    def rows(self) -> tuple[Fitted, ...]:
        """What the calibrated drive has otherwise than the study's."""
        return tuple(fitted.rows(self))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader has to know first: that the data contradict the study's creep law, or that no law fits."""
        return tuple(words.warnings(self.laws))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader of the result has to know, in sentences; the warnings come first."""
        return tuple(words.remarks(self))

    @property
    def verdict(self) -> str:
        """One line: what is told and what is not."""
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
            "parameters": {
                name: {
                    "unit": model.PARAMETERS[name].unit,
                    "value": fit.values[name],
                    "told": name in fit.told,
                    "standard_deviation": fit.deviations[name],
                    "interval_95": list(fit.interval(name)),
                    "study": self.known[name],
                }
                for name in fit.names
            },
            "correlations": {
                name: dict(zip(fit.names, row, strict=True))
                for name, row in zip(fit.names, fit.correlations.tolist(), strict=True)
            },
            "not_told_apart": [
                {
                    "weights": dict(combination.weights),
                    "value": combination.value,
                    "standard_deviation": combination.deviation,
                }
                for combination in fit.combinations
            ],
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
    """A cobotic drive of a study.

    Raises
    ------
    InputError
        If there is no drive of that name, or it is of another type.
    """
    drive = study.drive(name)
    if not isinstance(drive, CoboticDrive):
        raise InputError(
            f"{study.path or study.name}: drives.{name} must be a cobotic drive; this one has no wheel to measure"
        )
    return drive


def calibrate(
    study: Study,
    name: str,
    data: RigData | str | Path,
    *,
    parameters: Sequence[str] = model.USUAL,
    leave_out: Sequence[int] = (),
    creep_laws: Sequence[str] | None = None,
) -> Calibration:
    """Fit a cobotic drive of a study to a rig's data.

    Parameters
    ----------
    study : Study           Gives the drive as a start, and the rig.
    name : str              Of the drive in the study.
    data : RigData or path  Runs, or a CSV file of them.
    parameters : sequence   What to fit, of `model.PARAMETERS`; the others stay as the study has them.
    leave_out : sequence    Lines of the file that are not used.
    creep_laws : sequence   Creep laws to hold against the data. None for all there are, or for the study's alone where the
        creep stiffness is not fitted: its error would pass for another law.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If the data cannot be read, are none that this rig can give, or do not serve for what is to be fitted.

    Notes
    -----
    Runs that no rig can give, and outliers, are left out and named, unless they are more than a third of all or most of
    the runs with a setting in common.

    Source: faulring2006, sections III and IV-B; weighted nonlinear least squares.
    """
    drive = cobotic(study, name)
    if not isinstance(data, RigData):
        data = rig_data.read(data)
    for line in leave_out:
        if line not in data.lines:
            first, last = data.lines[0], data.lines[-1]
            raise InputError(f"{data.name}: line {line} is not one of its runs, which stand in lines {first} to {last}")
    data = data.chosen(~np.isin(data.lines, list(leave_out)))
    names = tuple(parameters)
    _check_wish(data, names, creep_laws)
    rig_data.check(data)
    faults = misread.find(data, drive, study.rig)
    misread.refuse_unless_few(data, faults)
    sound = np.asarray([row for row in range(len(data)) if row not in faults], dtype=int)
    used = data.chosen(sound)
    _check_enough(used, names)
    problem = Problem.of(drive, study.rig, used, names)
    robust, fits = laws.screen(problem, creep_laws)
    # Runs of a fit that failed say nothing about which torque without load is misread.
    few = np.count_nonzero(robust.beyond) <= FEW * len(data)
    found = fits[robust.problem.law]
    faults |= {
        int(sound[row]): said
        for row, said in reduce.impossible(
            _efficiencies(drive, study, used, found, robust.beyond & few, doubt=1.0)
        ).items()
    }
    misread.refuse_unless_few(data, faults)
    beyond = robust.beyond & ~np.isin(sound, list(faults))
    refuse_many(data, len(faults) + int(np.count_nonzero(beyond)))
    choice = laws.choose(problem, fits, robust.beyond | np.isin(sound, list(faults)))
    faults |= _outliers(problem, choice, sound, beyond)
    left_out = tuple(LeftOut(row, data.lines[row], faults[row]) for row in sorted(faults))
    friction = choice.fit.values.get("guideway_friction", model.known_values(drive)["guideway_friction"])
    return Calibration(
        study=study,
        name=name,
        data=data,
        laws=choice,
        left_out=left_out,
        efficiencies=_efficiencies(drive, study, data, choice.fit, np.isin(np.arange(len(data)), list(faults))),
        eq9=reduce.creep_stiffness(drive, study.rig, data, friction),
        plan=replace(plan.propose(choice.design), telling=tuple(plan.telling(choice))),
    )


def _check_wish(data: RigData, parameters: tuple[str, ...], creep_laws: Sequence[str] | None) -> None:
    for law in creep_laws or ():
        creep.law(law)
    if creep_laws is not None and not creep_laws:
        raise InputError(f"no creep law to hold against the data: name some of {', '.join(creep.LAWS)}")
    for name in parameters:
        if name not in model.PARAMETERS:
            known = ", ".join(model.PARAMETERS)
            raise InputError(f"{name!r} cannot be fitted{nearest(name, model.PARAMETERS)}; there are {known}")
    if not parameters:
        raise InputError(f"nothing to fit: name some of {', '.join(model.PARAMETERS)}")
    if "resistance" in parameters and data.motor_voltage is None:
        raise InputError(f"{data.name}: has no column motor_voltage, without which the resistance cannot be fitted")


def _check_enough(data: RigData, parameters: tuple[str, ...]) -> None:
    used = int(np.count_nonzero(data.pressed))
    if 2 * used < len(parameters) or used < 2:
        raise InputError(
            f"{data.name}: {used} runs with the wheel pressed on are too few to fit {len(parameters)} parameters"
        )


def _outliers(problem: Problem, choice: LawChoice, rows: np.ndarray, beyond: np.ndarray) -> dict[int, str]:
    """Why runs that the sensors can give do not fit, by row of the data."""
    expecting = problem.under(choice.fit.law)
    said = {}
    for place in np.flatnonzero(beyond).tolist():
        name, unit, read, told, far = expecting.first_off(choice.fit.unknowns, place, OUTLIER)
        wrong = f"where the fit expects {plain(told)} {unit}, {plain(far, 3)} standard deviations off"
        said[int(rows[place])] = (
            f"{name} is {plain(read)} {unit} {wrong if math.isfinite(told) else 'where by the fit the wheel would slip'}"
        )
    return said


def _efficiencies(
    drive: CoboticDrive, study: Study, data: RigData, fit: Fit, misread_runs: np.ndarray, doubt: float = 0.0
) -> Efficiencies:
    """Efficiencies by Eq 18, with what was fitted in place of what the study says.

    `doubt` is the relative deviation of a guideway's friction that was not fitted.
    """
    values = {**model.known_values(drive), **fit.values}
    friction = values["guideway_friction"]
    deviation = fit.deviations.get("guideway_friction", doubt * friction)
    nominal = fit.deviations.get("nominal_torque", 0.0)
    return reduce.efficiencies(
        with_values(drive, {"motor.torque_constant": values["torque_constant"]}),
        study.rig,
        data,
        guideway_friction=friction,
        guideway_deviation=deviation if math.isfinite(deviation) else friction,
        nominal=values["nominal_torque"],
        nominal_deviation=nominal if math.isfinite(nominal) else values["nominal_torque"],
        misread=misread_runs,
    )
