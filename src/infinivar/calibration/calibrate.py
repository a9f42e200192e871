"""Calibrate a drive from rig data: efficiencies, fitted parameters, identifiability, and runs to measure next."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from infinivar._core.fields import with_values
from infinivar.calibration import data as rig_data
from infinivar.calibration import laws, misread, model, plan, reduce
from infinivar.calibration.data import LeftOut, RigData
from infinivar.calibration.fit import FEW, OUTLIER, Fit, refuse_many
from infinivar.calibration.geared.calibrate import calibrate_geared
from infinivar.calibration.geared.problem import BenchData
from infinivar.calibration.geared.result import GearedCalibration
from infinivar.calibration.laws import LawChoice
from infinivar.calibration.problem import Problem
from infinivar.calibration.reduce import Efficiencies
from infinivar.calibration.result import Calibration, cobotic
from infinivar.contact import creep
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError, nearest
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.units import plain


def calibrate(
    study: Study,
    name: str,
    data: RigData | BenchData | str | Path,
    *,
    parameters: Sequence[str] | None = None,
    leave_out: Sequence[int] = (),
    creep_laws: Sequence[str] | None = None,
    columns: Mapping[str, str] | None = None,
) -> Calibration | GearedCalibration:
    """Fit a drive of a study to measured data.

    A cobotic drive is fitted to runs of its transmission on a rig, a conventional drive to points of its motor and gearhead
    on a dynamometer; see `calibrate_cobotic` and `calibrate_geared`.

    Parameters
    ----------
    study : Study           Study with the drive, as starting point, and the rig.
    name : str              Name of the drive in the study.
    data : RigData, BenchData or path  Measured data, or a CSV file of them.
    parameters : sequence   Parameters to fit; None for those that such data usually determine.
    leave_out : sequence    Lines of the file to exclude.
    creep_laws : sequence   Candidate creep laws of a cobotic drive.
    columns : mapping       Headings of the file by name of a column, where they differ: ``{"mass": "m [kg]"}``.

    Raises
    ------
    InputError
        If the data cannot be read, are impossible, or are insufficient for the parameters.
    """
    check_study(study)
    if isinstance(study.drive(name), ConventionalDrive):
        if creep_laws is not None:
            raise InputError(f"{study.path or study.name}: drives.{name} has no wheel: creep laws do not apply")
        if isinstance(data, RigData):
            raise InputError(f"{data.name}: runs of a transmission do not fit drives.{name}, a conventional drive")
        return calibrate_geared(study, name, data, parameters=parameters, leave_out=leave_out, columns=columns)
    if not isinstance(data, (RigData, str, Path)):
        raise InputError(f"{data.name}: data of a geared drive do not fit drives.{name}, a cobotic drive")
    requested = model.USUAL if parameters is None else parameters
    return calibrate_cobotic(
        study, name, data, parameters=requested, leave_out=leave_out, creep_laws=creep_laws, columns=columns
    )


def calibrate_cobotic(
    study: Study,
    name: str,
    data: RigData | str | Path,
    *,
    parameters: Sequence[str] = model.USUAL,
    leave_out: Sequence[int] = (),
    creep_laws: Sequence[str] | None = None,
    columns: Mapping[str, str] | None = None,
) -> Calibration:
    """Fit a cobotic drive of a study to rig data.

    Parameters
    ----------
    study : Study           Study with the drive, as starting point, and the rig.
    name : str              Name of the drive in the study.
    data : RigData or path  Runs, or a CSV file of runs.
    parameters : sequence   Parameters to fit, from `model.PARAMETERS`; the others keep the values of the study.
    leave_out : sequence    Lines of the file to exclude.
    creep_laws : sequence   Candidate creep laws. None for all, without "exact" if the study has measured values in place of the
        patch's geometry and another law; for the study's law alone if the creep stiffness is not fitted, as an error in the
        stiffness would be mistaken for another law.
    columns : mapping       Headings of the file by name of a column, where they differ.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If the data cannot be read, are impossible for this rig, or are insufficient for the parameters.

    Notes
    -----
    Impossible runs and outliers are excluded and reported. If they make up more than a third of all runs, or most of the
    runs with a common setting, the data are refused.

    Source: faulring2006, sections III and IV-B; weighted nonlinear least squares.
    """
    check_study(study)
    drive = cobotic(study, name)
    if not isinstance(data, RigData):
        data = rig_data.read(data, columns)
    for line in leave_out:
        if line not in data.lines:
            first, last = data.lines[0], data.lines[-1]
            raise InputError(f"{data.name}: line {line} is not a run; runs are in lines {first} to {last}")
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
    # A failed fit does not show which no-load torque is misread.
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
    refuse_many(data, len(faults) + int(np.count_nonzero(beyond)), _untried(fits, name))
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
        raise InputError(f"no creep law to fit: choose from {', '.join(creep.LAWS)}")
    for name in parameters:
        if name not in model.PARAMETERS:
            known = ", ".join(model.PARAMETERS)
            raise InputError(f"{name!r} cannot be fitted{nearest(name, model.PARAMETERS)}; choose from {known}")
    if not parameters:
        raise InputError(f"no parameter to fit: choose from {', '.join(model.PARAMETERS)}")
    if "resistance" in parameters and data.motor_voltage is None:
        raise InputError(f"{data.name}: fitting the resistance requires a column motor_voltage")


def _check_enough(data: RigData, parameters: tuple[str, ...]) -> None:
    used = int(np.count_nonzero(data.pressed))
    if 2 * used < len(parameters) or used < 2:
        raise InputError(
            f"{data.name}: {used} runs with the wheel pressed on are too few to fit {len(parameters)} parameters"
        )


def _untried(fits: Mapping[str, Fit], name: str) -> str:
    """Creep laws that were no candidates, and what makes them candidates, as a clause."""
    left = [law for law in creep.LAWS if law not in fits]
    if not left:
        return ""
    geometry = all(creep.LAWS[law].on_patch is not None for law in left)
    how = f"give drives.{name}.transmission its geometry" if geometry else "name them in --creep-laws"
    return f". Not tried: creep law {', '.join(left)} ({how})"


def _outliers(problem: Problem, choice: LawChoice, rows: np.ndarray, beyond: np.ndarray) -> dict[int, str]:
    """Reasons why plausible runs do not fit, by row of the data."""
    expecting = problem.under(choice.fit.law)
    said = {}
    for place in np.flatnonzero(beyond).tolist():
        name, unit, read, told, far = expecting.first_off(choice.fit.unknowns, place, OUTLIER)
        expected = f"the fit expects {plain(told)} {unit} ({plain(far, 3)} standard deviations off)"
        said[int(rows[place])] = (
            f"{name} is {plain(read)} {unit}, but {expected if math.isfinite(told) else 'by the fit the wheel would slip'}"
        )
    return said


def _efficiencies(
    drive: CoboticDrive, study: Study, data: RigData, fit: Fit, misread_runs: np.ndarray, doubt: float = 0.0
) -> Efficiencies:
    """Efficiencies by Eq 18, with fitted values in place of the study's.

    `doubt` is the relative standard deviation of the guideway friction if it was not fitted.
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
