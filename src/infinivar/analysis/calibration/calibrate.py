"""From a rig's data to a calibrated drive: efficiencies, fitted parameters, what they cannot tell, what to measure next."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from infinivar.analysis.calibration import data as rig_data
from infinivar.analysis.calibration import model, plan, reduce
from infinivar.analysis.calibration.data import RigData
from infinivar.analysis.calibration.fit import Fit, fit
from infinivar.analysis.calibration.plan import Plan
from infinivar.analysis.calibration.problem import Problem
from infinivar.analysis.calibration.reduce import Efficiencies
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError, nearest
from infinivar.parts.gearhead import coulomb_torque
from infinivar.quantities import given, with_values
from infinivar.study.study import Study
from infinivar.study.uncertainty import NORMAL_95
from infinivar.transmission.rotary_linear import MEASURED


class Fitted(NamedTuple):
    """One value of the calibrated drive."""

    path: str
    """Of the field in the drive, dotted."""
    value: float
    unit: str
    kind: str
    """fitted, assumed where the data tell only a sum, or derived where it follows from the study."""
    where: str
    deviation: float | None
    """Standard deviation; None where the value is none of the data's."""
    parameter: str
    """Of the fit from which it comes, "" for none."""
    slope: float = 1.0
    """Change of the value by that of the parameter. [SI]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """A drive calibrated by a rig's data.

    Attributes
    ----------
    study, name          The study and the drive in it.
    data                 Runs as given, without those left out on request.
    fit                  Estimates and intervals.
    efficiencies         Of all runs, by Eq 18.
    eq9                  Creep stiffness of all runs by Eq 9 and its standard deviation; nan where the wheel is not locked. [N]
    plan                 What to measure next.
    """

    study: Study
    name: str
    data: RigData
    fit: Fit
    efficiencies: Efficiencies
    eq9: tuple[np.ndarray, np.ndarray]
    plan: Plan

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
        return tuple(_rows(self))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader of the result has to know, in sentences."""
        return tuple(_remarks(self))

    @property
    def verdict(self) -> str:
        """One line: what is told and what is not."""
        told = [_shown(self, name) for name in self.fit.told]
        told += [combined(combination) for combination in self.fit.combinations]
        return "; ".join(told)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        fit, found = self.fit, self.efficiencies
        return {
            "drive": self.name,
            "data": self.data.name,
            "runs": len(self.data),
            "left_out_lines": [self.data.lines[row] for row in fit.outliers],
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
            "next_runs": [setting._asdict() for setting in self.plan.settings],
            "expected_standard_deviations": dict(self.plan.deviations),
            "remarks": list(self.remarks),
        }

    def save(self, directory: str | Path) -> list[Path]:
        """Write ``calibration.html``, its JSON and figures, and ``calibrated.toml``; returns their paths.

        Raises
        ------
        InputError
            If the directory cannot be written to; nothing is changed then.
        """
        from infinivar.report import calibration

        return calibration.save(self, Path(directory))


def cobotic(study: Study, name: str) -> CoboticDrive:
    """A cobotic drive of a study.

    Raises
    ------
    InputError
        If there is no drive of that name, or it is of another type.
    """
    drive = study.drive(name)
    if not isinstance(drive, CoboticDrive):
        raise InputError(f"drives.{name}: a drive of type {type(drive).__name__} has no wheel to measure")
    return drive


def calibrate(
    study: Study,
    name: str,
    data: RigData | str | Path,
    *,
    parameters: Sequence[str] = model.USUAL,
    leave_out: Sequence[int] = (),
) -> Calibration:
    """Fit a cobotic drive of a study to a rig's data.

    Parameters
    ----------
    study : Study           Gives the drive as a start, and the rig.
    name : str              Of the drive in the study.
    data : RigData or path  Runs, or a CSV file of them.
    parameters : sequence   What to fit, of `model.PARAMETERS`; the others stay as the study has them.
    leave_out : sequence    Lines of the file that are not used.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If the data cannot be read, are none that this rig can give, or do not serve for what is to be fitted.

    Source: faulring2006, Eqs 9 and 18, sections III and IV-B; weighted nonlinear least squares.
    """
    drive = cobotic(study, name)
    if not isinstance(data, RigData):
        data = rig_data.read(data)
    for line in leave_out:
        if line not in data.lines:
            first, last = data.lines[0], data.lines[-1]
            raise InputError(f"{data.name}: line {line} is not one of its runs, which stand in lines {first} to {last}")
    data = data.chosen(~np.isin(data.lines, list(leave_out)))
    _check_wish(drive, data, tuple(parameters))
    rig_data.check(data, drive, study.rig)
    known = model.known_values(drive)
    before = _efficiencies(drive, study, data, known["guideway_friction"], known["guideway_friction"], known)
    reduce.check(data, before)
    found = fit(Problem.of(drive, study.rig, data, tuple(parameters)))
    friction = found.values.get("guideway_friction", known["guideway_friction"])
    spread = found.deviations.get("guideway_friction", 0.0)
    spread = spread if math.isfinite(spread) else friction
    return Calibration(
        study=study,
        name=name,
        data=data,
        fit=found,
        efficiencies=_efficiencies(drive, study, data, friction, spread, {**known, **found.values}),
        eq9=reduce.creep_stiffness(drive, study.rig, data, friction),
        plan=plan.propose(found),
    )


def _check_wish(drive: CoboticDrive, data: RigData, parameters: tuple[str, ...]) -> None:
    for name in parameters:
        if name not in model.PARAMETERS:
            known = ", ".join(model.PARAMETERS)
            raise InputError(f"{name!r} cannot be fitted{nearest(name, model.PARAMETERS)}; there are {known}")
    if not parameters:
        raise InputError(f"nothing to fit: name some of {', '.join(model.PARAMETERS)}")
    if "resistance" in parameters and data.motor_voltage is None:
        raise InputError(f"{data.name}: has no column motor_voltage, without which the resistance cannot be fitted")
    used = int(np.count_nonzero(data.pressed))
    if 2 * used < len(parameters) or used < 2:
        raise InputError(
            f"{data.name}: {used} runs with the wheel pressed on are too few to fit {len(parameters)} parameters"
        )


def _efficiencies(
    drive: CoboticDrive, study: Study, data: RigData, friction: float, spread: float, values: Mapping[str, float]
) -> Efficiencies:
    return reduce.efficiencies(
        drive, study.rig, data, guideway_friction=friction, guideway_deviation=spread, nominal=values["nominal_torque"]
    )


def _rows(found: Calibration) -> list[Fitted]:
    drive, fit, known = found.drive, found.fit, found.known
    source = f"{Path(found.data.name).name}, {len(found.data) - len(fit.outliers)} runs"
    rows = []

    def add(path: str, value: float, unit: str, parameter: str, scale: float = 1.0) -> None:
        deviation = fit.deviations.get(parameter)
        if deviation is not None and math.isfinite(deviation):
            rows.append(Fitted(path, value, unit, "fitted", source, deviation * scale, parameter, scale))
        elif deviation is not None:
            rows.append(Fitted(path, value, unit, "assumed", *_in_a_sum(fit, parameter, source), parameter))
        else:
            rows.append(Fitted(path, value, unit, "derived", "from the geometry of the study", None, ""))

    grouped = any(parameter in fit.names for parameter in MEASURED)
    for parameter in MEASURED:
        if parameter in fit.names or (grouped and drive.transmission.geometry is not None):
            value = fit.values.get(parameter, known[parameter])
            add(f"transmission.{parameter}", value, model.PARAMETERS[parameter].unit, parameter)
    contact = drive.transmission.contact
    if grouped and drive.steering is not None and contact is not None:
        add("steering.patch_half_length", float(contact.patch.b), "m", "")
    if "guideway_friction" in fit.names:
        value, guide, preload = fit.values["guideway_friction"], drive.guideway, drive.transmission.preload
        whole = guide.friction_force(preload)
        share = guide.coefficient * preload / whole if whole > 0 else 0.0
        if share > 0:
            add("guideway.coefficient", value * share / preload, "1", "guideway_friction", share / preload)
        if share < 1:
            add("guideway.friction", value * (1.0 - share), "N", "guideway_friction", 1.0 - share)
    if "torque_constant" in fit.names:
        add("motor.torque_constant", fit.values["torque_constant"], "N m/A", "torque_constant")
    if "resistance" in fit.names:
        add("motor.resistance", fit.values["resistance"], "ohm", "resistance")
    if "nominal_torque" in fit.names:
        rows += _nominal(found, source)
    return rows


def _in_a_sum(fit: Fit, parameter: str, source: str) -> tuple[str, float | None]:
    """Source and deviation of a parameter that is not told by itself: the largest part stands for the whole sum's."""
    told = next((combination for combination in fit.combinations if parameter in combination.weights), None)
    if told is None:
        return f"{source} say nothing about it", None
    where = f"{source}: only {combined(told)} is told"
    parts = {name: abs(weight * fit.values[name]) for name, weight in told.weights.items()}
    if parameter != max(parts, key=lambda name: parts[name]):
        return where, None
    return f"{where}; its largest part carries the interval of the sum", told.deviation / abs(told.weights[parameter])


def _nominal(found: Calibration, source: str) -> list[Fitted]:
    """The nominal torque as the fields of motor and gearhead that make it up: the gearhead's, as far as it goes."""
    drive, fit = found.drive, found.fit
    motor, gear = drive.motor, drive.gearhead
    value, deviation = fit.values["nominal_torque"], fit.deviations["nominal_torque"]
    constant = fit.values.get("torque_constant", motor.torque_constant)
    rest = value - constant * motor.no_load_current
    whole = coulomb_torque(0.0, given(gear.rated_torque, motor.continuous_torque))
    path, unit, slope = "gearhead.efficiency", "1", -1.0 / whole
    share, made = 1.0 - rest / whole, "what the nominal torque leaves beside the motor's no-load current"
    if gear.loss_model != "coulomb" or not 0.0 <= rest < whole:
        path, unit, slope = "motor.no_load_current", "A", 1.0 / constant
        beside = found.known["nominal_torque"] - motor.friction_torque
        share, made = max(value - beside, 0.0) / constant, "the nominal torque, all of it put down to the motor"
    if not math.isfinite(deviation):
        return [
            Fitted(path, share, unit, "assumed", _in_a_sum(fit, "nominal_torque", source)[0], None, "nominal_torque")
        ]
    where = f"{source}: {made}"
    return [Fitted(path, share, unit, "fitted", where, deviation * abs(slope), "nominal_torque", slope)]


def _remarks(found: Calibration) -> list[str]:
    fit, remarks = found.fit, []
    for combination in fit.combinations:
        names = " and ".join(combination.weights)
        if len(combination.weights) > 1:
            remarks.append(
                f"The data cannot tell {names} apart, only {combined(combination)}. In the calibrated drive they keep the "
                "proportions of the study."
            )
    alone = [
        name for name in fit.names if name not in fit.told and not any(name in c.weights for c in fit.combinations)
    ]
    remarks += [f"The data say nothing about {name}: it stays as the study has it." for name in alone]
    apart = [name for name in fit.names if not math.isfinite(found.plan.deviations[name])]
    if apart:
        remarks.append(
            f"The runs proposed do not tell {' and '.join(apart)} apart either: with this rig's sensors no preload between "
            f"{min(plan.PRELOADS):g} and {max(plan.PRELOADS):g} of the study's does."
        )
    if fit.outliers:
        lines = ", ".join(str(found.data.lines[row]) for row in fit.outliers)
        remarks.append(f"Left out as outliers, more than five standard deviations from a robust fit: lines {lines}.")
    if fit.widened > 1.0:
        remarks.append(
            f"The residuals are {fit.widened:.2g} times what the rig's sensors explain, and all intervals are widened by that: "
            "look for a pattern in them, or for a sensor that is worse than [rig] says."
        )
    low = fit.problem.bounds[0]
    for place, name in enumerate(fit.names):
        if fit.unknowns[place] < low[place] + 1e-3:
            remarks.append(f"The fit of {name} ended at its lower bound, zero: its interval means little.")
    if found.drive.gearhead.loss_model == "proportional":
        remarks.append(
            "The gearhead loses in proportion to its load, which Eq 18 counts as the element's: those efficiencies are too low. "
            "The fit takes the gearhead's loss into account."
        )
    if not np.any(~found.data.pressed):
        remarks.append(
            "No run has the wheel lifted off: the nominal torque follows from the others by the model alone."
        )
    return remarks


def combined(combination: Any) -> str:
    """A sum of parameters in words: "rolling_torque + 1.2 bearing_torque = 2.84 ± 0.21 mN m" (95 %)."""
    terms = []
    for name, weight in combination.weights.items():
        size = "" if abs(abs(weight) - 1.0) < 5e-4 else f"{abs(weight):.3g} "
        sign = "-" if weight < 0 else "+"
        terms.append(f"{sign} {size}{name}" if terms else f"{'-' if weight < 0 else ''}{size}{name}")
    first = model.PARAMETERS[next(iter(combination.weights))]
    return f"{' '.join(terms)} = {with_interval(combination.value, combination.deviation, first)}"


def with_interval(value: float | None, deviation: float, parameter: model.Parameter) -> str:
    """A value, if there is one, with half its 95 % interval in the unit in which people read it."""
    from infinivar import units

    scale = units.parse(f"1 {parameter.shown_in}", parameter.unit) if parameter.shown_in != "1" else 1.0
    half = NORMAL_95 * deviation / scale
    digits = max(0, 1 - math.floor(math.log10(half))) if 0 < half < math.inf else 3
    shown = "inf" if math.isinf(half) else f"{half:.{digits}f}"
    return f"{'' if value is None else f'{value / scale:.{digits}f} '}± {shown} {parameter.shown_in}"


def _shown(found: Calibration, name: str) -> str:
    return f"{name} = {with_interval(found.fit.values[name], found.fit.deviations[name], model.PARAMETERS[name])}"
