"""infinivar: drive-trains with an infinitely variable (cobotic) transmission and with a fixed ratio.

The public names below load on first use, so that importing the package costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    "Amplifier": "parts.amplifier",
    "AuditError": "errors",
    "Bearing": "parts.bearing",
    "Calibration": "analysis.calibration.calibrate",
    "CoboticDrive": "drivetrain.cobotic",
    "Comparison": "analysis.compare",
    "ContactGeometry": "transmission.geometry",
    "ContactSheet": "analysis.contact_sheet",
    "ConventionalDrive": "drivetrain.conventional",
    "Course": "drivetrain.course",
    "Definition": "analysis.cycle",
    "DrivePoint": "drivetrain.drive",
    "DriveResult": "analysis.compare",
    "DutyCycle": "drivetrain.duty",
    "DutyResult": "analysis.duty_cycle",
    "DynamicMap": "analysis.dynamic",
    "Gearhead": "parts.gearhead",
    "Guideway": "parts.linear",
    "InfinivarError": "errors",
    "InputError": "errors",
    "Limit": "limits",
    "Material": "contact.bodies",
    "Motor": "parts.motor",
    "MovingPoint": "drivetrain.drive",
    "OperatingPoint": "transmission.operating_point",
    "ParameterError": "errors",
    "Pulley": "parts.linear",
    "Requirement": "drivetrain.requirement",
    "Rig": "drivetrain.rig",
    "RotaryLinearIVT": "transmission.rotary_linear",
    "Scenario": "drivetrain.scenario",
    "Sensitivity": "analysis.sensitivity",
    "Simulation": "analysis.simulate",
    "SteadyMap": "analysis.steady_map",
    "SteeringPlant": "drivetrain.cobotic",
    "Study": "study.study",
    "Uncertainty": "study.uncertainty",
    "calibrate": "analysis.calibration.calibrate",
    "compare": "analysis.compare",
    "contact_sheets": "analysis.contact_sheet",
    "duty_cycle": "analysis.duty_cycle",
    "dynamic_map": "analysis.dynamic",
    "load_study": "study.load",
    "reproduce": "analysis.reproduce",
    "sensitivity": "analysis.sensitivity",
    "simulate": "analysis.simulate",
    "steady_map": "analysis.steady_map",
}

__all__ = [*sorted(_HOME), "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from infinivar.analysis.calibration.calibrate import Calibration, calibrate
    from infinivar.analysis.compare import Comparison, DriveResult, compare
    from infinivar.analysis.contact_sheet import ContactSheet, contact_sheets
    from infinivar.analysis.cycle import Definition
    from infinivar.analysis.duty_cycle import DutyResult, duty_cycle
    from infinivar.analysis.dynamic import DynamicMap, dynamic_map
    from infinivar.analysis.reproduce import reproduce
    from infinivar.analysis.sensitivity import Sensitivity, sensitivity
    from infinivar.analysis.simulate import Simulation, simulate
    from infinivar.analysis.steady_map import SteadyMap, steady_map
    from infinivar.contact.bodies import Material
    from infinivar.drivetrain.cobotic import CoboticDrive, SteeringPlant
    from infinivar.drivetrain.conventional import ConventionalDrive
    from infinivar.drivetrain.course import Course
    from infinivar.drivetrain.drive import DrivePoint, MovingPoint
    from infinivar.drivetrain.duty import DutyCycle
    from infinivar.drivetrain.requirement import Requirement
    from infinivar.drivetrain.rig import Rig
    from infinivar.drivetrain.scenario import Scenario
    from infinivar.errors import AuditError, InfinivarError, InputError, ParameterError
    from infinivar.limits import Limit
    from infinivar.parts.amplifier import Amplifier
    from infinivar.parts.bearing import Bearing
    from infinivar.parts.gearhead import Gearhead
    from infinivar.parts.linear import Guideway, Pulley
    from infinivar.parts.motor import Motor
    from infinivar.study.load import load_study
    from infinivar.study.study import Study
    from infinivar.study.uncertainty import Uncertainty
    from infinivar.transmission.geometry import ContactGeometry
    from infinivar.transmission.operating_point import OperatingPoint
    from infinivar.transmission.rotary_linear import RotaryLinearIVT


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'infinivar' has no attribute {name!r}")
    value = getattr(import_module(f"infinivar.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
