"""Calibrate motor and gearhead of a conventional drive from a dynamometer's or a pendulum's data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar.calibration.data import LeftOut
from infinivar.calibration.fit import OUTLIER
from infinivar.calibration.geared import model, pendulum
from infinivar.calibration.geared.data import COLUMNS, dynamometer_of, refuse_unless_few
from infinivar.calibration.geared.problem import BenchData, Problem, fit
from infinivar.calibration.geared.result import GearedCalibration, geared
from infinivar.errors import InputError, nearest
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.tables.named import read_named
from infinivar.units import plain

_UNITS = {"current": "A", "voltage": "V", "power": "W", "efficiency": ""}


def calibrate_geared(
    study: Study,
    name: str,
    data: BenchData | str | Path,
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
    data : BenchData or path  Points of a dynamometer, or the windows of a pendulum's recording; or a CSV file of either.
    parameters : sequence   Parameters to fit, from `infinivar.calibration.geared.model.PARAMETERS`; the others keep the values
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
    drive = geared(study, name)
    rows: BenchData = _read(data, study, name, columns) if isinstance(data, (str, Path)) else data
    for line in leave_out:
        if line not in rows.lines:
            raise InputError(
                f"{rows.name}: line {line} is not a row; rows are in lines {rows.lines[0]} to {rows.lines[-1]}"
            )
    rows = rows.chosen(~np.isin(rows.lines, list(leave_out)))
    names = tuple(rows.usual if parameters is None else parameters)
    _check_wish(rows, names)
    faults = rows.faults()
    refuse_unless_few(rows, faults)
    sound = np.asarray([row for row in range(len(rows)) if row not in faults], dtype=int)
    used = rows.chosen(sound)
    if len(used) * len(used.signals) < 2 * len(names):
        raise InputError(f"{rows.name}: {len(used)} rows are too few to fit {len(names)} parameters")
    found = fit(Problem.of(drive, study.rig, used, names))
    faults |= _outliers(found, used, sound)
    left_out = tuple(LeftOut(row, rows.lines[row], faults[row]) for row in sorted(faults))
    return GearedCalibration(study=study, name=name, data=rows, fit=found, left_out=left_out)


def _read(file: str | Path, study: Study, name: str, headings: Mapping[str, str] | None) -> BenchData:
    """Read data of the kind that their columns reveal."""
    drive = geared(study, name)
    columns, lines, empty = read_named(file, {**pendulum.COLUMNS, **COLUMNS}, (), headings)
    if "torque" in columns or "motor_torque" in columns:
        return replace(dynamometer_of(str(file), columns, lines, drive.gearhead.ratio), empty=empty)
    if {"time", "angle", "current"} <= set(columns):
        if drive.motor.rotor_inertia is None:
            raise InputError(f"{file}: data of a pendulum need rotor_inertia in [drives.{name}.motor]")
        return replace(pendulum.pendulum_of(str(file), columns, lines, study.rig, drive), empty=empty)
    raise InputError(
        f"{file}: drives.{name} has no wheel to measure; data of a geared drive have columns speed and torque of a dynamometer, "
        "or time, angle and current of a pendulum"
    )


def _check_wish(data: BenchData, names: tuple[str, ...]) -> None:
    if not names:
        raise InputError(f"no parameter to fit: choose from {', '.join(model.PARAMETERS)}")
    for name in names:
        if name not in model.PARAMETERS:
            known = ", ".join(model.PARAMETERS)
            raise InputError(f"{name!r} cannot be fitted{nearest(name, model.PARAMETERS)}; choose from {known}")
        refusal = data.refusal(name)
        if refusal is not None:
            raise InputError(f"{data.name}: {refusal}")


def _outliers(found: Any, used: BenchData, rows: np.ndarray) -> dict[int, str]:
    """Reasons why plausible rows do not fit, by row of the data."""
    said = {}
    whole = found.problem.about(used)
    off = whole.off(found.unknowns)
    told = whole.expected(found.unknowns)
    for place in found.outliers:
        worst = int(np.argmax(np.abs(off[place]) > OUTLIER)) if np.any(np.abs(off[place]) > OUTLIER) else 0
        name = used.signals[worst]
        said[int(rows[place])] = (
            f"{name} is {plain(float(used.read[place, worst]))} {_UNITS[name]}".rstrip()
            + f", but the fit expects {plain(float(told[place, worst]))} {_UNITS[name]}".rstrip()
            + f" ({plain(abs(float(off[place, worst])), 3)} standard deviations off)"
        )
    return said
