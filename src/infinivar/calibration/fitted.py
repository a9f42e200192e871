"""Values in which a calibrated drive differs from the study's, with their sources."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from infinivar._core.fields import value_at
from infinivar.calibration import geared, transmission
from infinivar.calibration.fit import Fit
from infinivar.calibration.words import combined
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.parts.linear import Guideway
from infinivar.transmission.rolling_contact import MEASURED


class Fitted(NamedTuple):
    """One value of the calibrated drive."""

    path: str
    """Dotted path of the field in the drive."""
    value: float | str
    unit: str
    """Unit; "" if not a quantity."""
    kind: str
    """fitted; assumed if only a sum is identifiable; or derived from the study."""
    where: str
    deviation: float | None
    """Standard deviation; None if the value is not from the data."""
    parameter: str
    """Parameter of the fit that gives the value; "" if none."""
    slope: float = 1.0
    """Derivative of the value with respect to the parameter. [SI]"""


def of_transmission(drive: CoboticDrive, fit: Fit, source: str) -> list[Fitted]:
    """List every value in which the calibrated drive differs from the study's.

    Parameters
    ----------
    drive    Drive of the study.
    fit      Fit to the data.
    source   Description of the data.
    """
    rows: list[Fitted] = []
    known = fit.problem.known
    if fit.law != drive.transmission.creep_law.name:
        rows.append(Fitted("transmission.creep_law", fit.law, "", "fitted", source, None, ""))

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
            add(f"transmission.{parameter}", value, fit.parameters[parameter].unit, parameter)
    contact = drive.transmission.contact
    if grouped and drive.steering is not None and contact is not None:
        add("steering.patch_half_length", float(contact.patch.b), "m", "")
    if "guideway_friction" in fit.names:
        for path, unit, share in _guideway(drive.guideway, drive.transmission.preload):
            add(path, fit.values["guideway_friction"] * share, unit, "guideway_friction", share)
    if "torque_constant" in fit.names:
        add("motor.torque_constant", fit.values["torque_constant"], "N m/A", "torque_constant")
    if "resistance" in fit.names:
        add("motor.resistance", fit.values["resistance"], "ohm", "resistance")
    if "nominal_torque" in fit.names:
        rows += _nominal(drive, fit, source)
    return rows


def _guideway(guide: Guideway, preload: float) -> Iterator[tuple[str, str, float]]:
    """Fields that make up the guideway friction, their units, and their value per unit of friction."""
    share, (constant, coefficient) = guide.follows(preload), guide.fields
    if share > 0:
        yield f"guideway.{coefficient}", "1", share / preload
    if share < 1:
        yield f"guideway.{constant}", "N", 1.0 - share


def _in_a_sum(fit: Fit, parameter: str, source: str) -> tuple[str, float | None]:
    """Source and deviation of a parameter identifiable only in a sum; the largest term carries the deviation of the sum."""
    found = next((combination for combination in fit.combinations if parameter in combination.weights), None)
    if found is None:
        return f"{source}: not identifiable", None
    where = f"{source}: only {combined(found, fit)} is identifiable"
    parts = {name: abs(weight * fit.values[name]) for name, weight in found.weights.items()}
    if parameter != max(parts, key=lambda name: parts[name]):
        return where, None
    return f"{where}; the largest term carries the interval of the sum", found.deviation / abs(found.weights[parameter])


def _nominal(drive: CoboticDrive, fit: Fit, source: str) -> list[Fitted]:
    """Assign the nominal torque to fields of motor and gearhead, to the gearhead as far as possible."""
    motor, gear = drive.motor, drive.gearhead
    value, deviation = fit.values["nominal_torque"], fit.deviations["nominal_torque"]
    constant = fit.values.get("torque_constant", motor.torque_constant)
    bearings = transmission.unloaded_bearings(drive)
    rest = value - bearings - constant * motor.no_load_current
    whole = gear.law(motor.continuous_torque).stated_at()
    if whole is not None and 0.0 <= rest < whole:
        path, unit, slope = "gearhead.efficiency", "1", -1.0 / whole
        share, made = 1.0 - rest / whole, "nominal torque less that of the motor and of the cylinder's bearings"
    else:
        path, unit, slope = "motor.no_load_current", "A", 1.0 / constant
        beside = fit.problem.known["nominal_torque"] - motor.friction_torque
        share, made = max(value - beside, 0.0) / constant, "nominal torque, attributed entirely to the motor"
    if not math.isfinite(deviation):
        return [
            Fitted(path, share, unit, "assumed", _in_a_sum(fit, "nominal_torque", source)[0], None, "nominal_torque")
        ]
    where = f"{source}: {made}"
    return [Fitted(path, share, unit, "fitted", where, deviation * abs(slope), "nominal_torque", slope)]


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


def of_gear(drive: ConventionalDrive, made: ConventionalDrive, fit: Fit, source: str) -> Iterator[Fitted]:
    """Yield every value in which the calibrated drive `made` differs from the study's; `source` describes the data."""
    with_gear = any(name in geared.OF_GEAR for name in fit.names)
    if with_gear:
        yield Fitted("gearhead.loss_model", "stribeck", "", "derived", source, None, "")
    for name in fit.parameters:
        of_gear = name in geared.OF_GEAR
        if name not in fit.names and not (of_gear and with_gear) and name != "motor_friction":
            continue
        for place, path in enumerate(_FIELDS[name]):
            value = value_at(made, path)
            if value is None:
                continue
            unit = "A" if path == "motor.no_load_current" else fit.parameters[name].unit
            if name not in fit.names:
                if of_gear or value != value_at(drive, path):
                    yield Fitted(path, value, unit, "derived", "the friction of the study", None, "")
                continue
            deviation, kind, where = fit.deviations[name], "fitted", source
            if not math.isfinite(deviation):
                kind, where = "assumed", f"{source}: not identifiable separately"
            elif name == "load_share":
                where = f"{source}: load_output carries the interval of both load terms"
            slope = _slope(fit, path)
            spread = abs(slope) * deviation if math.isfinite(deviation) and place == 0 else None
            yield Fitted(path, value, unit, kind, where, spread, name, slope)


def _slope(fit: Fit, path: str) -> float:
    """Derivative of a field with respect to its parameter.

    Both load terms follow one share, and friction depends on their sum: the first carries the interval of both.
    """
    if path == "gearhead.friction.load_output":
        return 2.0
    if path != "motor.no_load_current":
        return 1.0
    values = {**fit.problem.known, **fit.values}
    constant = values["torque_constant"]
    return 1.0 / (constant + values["motor_viscous"] * values["resistance"] / constant)
