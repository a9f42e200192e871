"""Calibrate a drive from readings on a bench: fitted parameters, identifiability, and the runs to measure next."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from infinivar._core.fields import with_values
from infinivar.calibration import dynamometer, laws, misread, pendulum, plan, reduce, transmission, words
from infinivar.calibration.bench import FEW, Bench, LeftOut, refuse_unless_few
from infinivar.calibration.fit import Fit, fit, refuse_many
from infinivar.calibration.geared import GearedBench
from infinivar.calibration.problem import Problem
from infinivar.calibration.reduce import Efficiencies
from infinivar.calibration.result import Calibration, GearedCalibration, cobotic, conventional
from infinivar.calibration.transmission import RigData
from infinivar.contact import creep
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError, nearest
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.tables.named import read_named

B = TypeVar("B", bound=Bench)


def calibrate(
    study: Study,
    name: str,
    data: RigData | GearedBench | str | Path,
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
    data : RigData, GearedBench or path  Measured data, or a CSV file of them.
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
    requested = transmission.USUAL if parameters is None else parameters
    return calibrate_cobotic(
        study, name, data, parameters=requested, leave_out=leave_out, creep_laws=creep_laws, columns=columns
    )


def calibrate_cobotic(
    study: Study,
    name: str,
    data: RigData | str | Path,
    *,
    parameters: Sequence[str] = transmission.USUAL,
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
    parameters : sequence   Parameters to fit, from `transmission.PARAMETERS`; the others keep the values of the study.
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
    for law in creep_laws or ():
        creep.law(law)
    if creep_laws is not None and not creep_laws:
        raise InputError(f"no creep law to fit: choose from {', '.join(creep.LAWS)}")
    data, names = _requested(
        data if isinstance(data, RigData) else transmission.read(data, columns), leave_out, parameters
    )
    data.check()
    faults = misread.find(data, drive, study.rig)
    misread.refuse_unless_few(data, faults)
    sound, used = _sound(data, faults)
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
    used_law = laws.under(problem, choice.fit.law)
    faults |= _outliers(used_law, choice.fit, np.flatnonzero(beyond), sound)
    friction = choice.fit.values.get("guideway_friction", problem.known["guideway_friction"])
    return Calibration(
        study=study,
        name=name,
        data=data,
        laws=choice,
        left_out=_left_out(data, faults),
        efficiencies=_efficiencies(drive, study, data, choice.fit, np.isin(np.arange(len(data)), list(faults))),
        eq9=reduce.creep_stiffness(drive, study.rig, data, friction),
        plan=replace(plan.propose(choice.design), telling=tuple(plan.telling(choice))),
    )


def calibrate_geared(
    study: Study,
    name: str,
    data: GearedBench | str | Path,
    *,
    parameters: Sequence[str] | None = None,
    leave_out: Sequence[int] = (),
    columns: Mapping[str, str] | None = None,
) -> GearedCalibration:
    """Fit motor and gearhead of a conventional drive to measured data.

    Parameters
    ----------
    study : Study           Study with the drive, as starting point, and the rig.
    name : str              Name of the drive in the study.
    data : GearedBench or path  Points of a dynamometer, or the windows of a pendulum's recording; or a CSV file of either.
    parameters : sequence   Parameters to fit, from `infinivar.calibration.geared.PARAMETERS`; the others keep the values
        of the study. None for all that data of this kind usually determine.
    leave_out : sequence    Lines of the file to exclude.
    columns : mapping       Headings of the file by name of a column, where they differ: ``{"torque": "T [Nm]"}``.

    Returns
    -------
    GearedCalibration

    Raises
    ------
    InputError
        If the data cannot be read, are impossible, or are insufficient for the parameters.

    Notes
    -----
    Stage, guideway, springs and amplifier of the drive are not on the bench: the torque is that at the gearhead's output, and
    currents, voltages and powers are those of the motor.

    Source: weighted nonlinear least squares.
    """
    check_study(study)
    drive = conventional(study, name)
    measured = _read(data, study, name, drive, columns) if isinstance(data, (str, Path)) else data
    rows, names = _requested(measured, leave_out, parameters)
    faults = rows.faults()
    refuse_unless_few(rows, faults)
    sound, used = _sound(rows, faults)
    if len(used) * len(used.signals) < 2 * len(names):
        raise InputError(f"{rows.name}: {len(used)} rows are too few to fit {len(names)} parameters")
    found = fit(Problem.of(drive, study.rig, used, names))
    faults |= _outliers(found.problem.about(used).separate, found, found.outliers, sound)
    return GearedCalibration(study=study, name=name, data=rows, fit=found, left_out=_left_out(rows, faults))


def _requested(data: B, leave_out: Sequence[int], parameters: Sequence[str] | None) -> tuple[B, tuple[str, ...]]:
    """The rows that are not excluded on request, and the parameters to fit; refused if there are no such rows or parameters."""
    for line in leave_out:
        if line not in data.lines:
            raise InputError(
                f"{data.name}: line {line} is not a {data.row}; {data.row}s are in lines {data.lines[0]} to {data.lines[-1]}"
            )
    data = data.chosen(~np.isin(data.lines, list(leave_out)))
    names = tuple(data.usual if parameters is None else parameters)
    known = ", ".join(data.parameters)
    if not names:
        raise InputError(f"no parameter to fit: choose from {known}")
    for name in names:
        if name not in data.parameters:
            raise InputError(f"{name!r} cannot be fitted{nearest(name, data.parameters)}; choose from {known}")
        if (refusal := data.refusal(name)) is not None:
            raise InputError(f"{data.name}: {refusal}")
    return data, names


def _sound(data: B, faults: Mapping[int, str]) -> tuple[np.ndarray, B]:
    """Index of the rows without faults, and these rows."""
    sound = np.asarray([row for row in range(len(data)) if row not in faults], dtype=int)
    return sound, data.chosen(sound)


def _outliers(problem: Problem, found: Fit, outliers: Iterable[int], sound: np.ndarray) -> dict[int, str]:
    """Reasons why plausible rows do not fit, by row of the data, of which `sound` are in the problem."""
    return {int(sound[row]): words.why_outlier(problem, found.unknowns, int(row)) for row in outliers}


def _left_out(data: Bench, faults: Mapping[int, str]) -> tuple[LeftOut, ...]:
    return tuple(LeftOut(row, data.lines[row], faults[row]) for row in sorted(faults))


def _read(
    file: str | Path, study: Study, name: str, drive: ConventionalDrive, headings: Mapping[str, str] | None
) -> GearedBench:
    """Read data of the kind that their columns reveal."""
    found = read_named(file, {**pendulum.COLUMNS, **dynamometer.COLUMNS}, (), headings)
    if "torque" in found.columns or "motor_torque" in found.columns:
        return dynamometer.dynamometer_of(str(file), found, drive.gearhead.ratio)
    if {"time", "angle", "current"} <= set(found.columns):
        if drive.motor.rotor_inertia is None:
            raise InputError(f"{file}: data of a pendulum need rotor_inertia in [drives.{name}.motor]")
        return pendulum.pendulum_of(str(file), found, study.rig, drive)
    raise InputError(
        f"{file}: drives.{name} has no wheel to measure; data of a geared drive have columns speed and torque of a dynamometer, "
        "or time, angle and current of a pendulum"
    )


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


def _efficiencies(
    drive: CoboticDrive, study: Study, data: RigData, fit: Fit, misread_runs: np.ndarray, doubt: float = 0.0
) -> Efficiencies:
    """Efficiencies by Eq 18, with fitted values in place of the study's.

    `doubt` is the relative standard deviation of the guideway friction if it was not fitted.
    """
    values = {**transmission.known_values(drive), **fit.values}
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
