from .analysis.compare import Comparison, DriveResult, compare
from .analysis.contact_sheet import ContactSheet, contact_sheets
from .analysis.cycles.duty_cycle import DutyResult, duty_cycle
from .analysis.cycles.performance import Definition
from .analysis.cycles.shaking import DynamicMap, dynamic_map
from .analysis.robustness.sensitivity import Sensitivity, sensitivity
from .analysis.simulate import Simulation, simulate
from .analysis.steady_map import SteadyMap, steady_map
from .calibration.calibrate import Calibration, calibrate
from .contact.bodies import Material
from .contact.creep import CreepLaw
from .drivetrain.cobotic import CoboticDrive, SteeringPlant
from .drivetrain.conventional import ConventionalDrive
from .drivetrain.drive import DrivePoint, MovingPoint
from .errors import AuditError, InfinivarError, InputError, ParameterError
from .limits import Limit
from .motion.course import Course
from .motion.duty_cycles import DutyCycle
from .motion.forces import ConstantForce, SinusoidalForce, StepForce
from .motion.motion import Force, Motion, PeriodicMotion
from .motion.motions import Cruise, Hold, Reach, Reaches, Rest, Sinusoid, Step, Tremor, Walking
from .motion.recordings import RecordedForce, Recording, Waypoints
from .motion.scenario import Scenario
from .paper.reproduce import reproduce
from .parts.amplifier import Amplifier
from .parts.bearing import Bearing
from .parts.gearhead import Gearhead
from .parts.linear import Guideway, Pulley
from .parts.motor import Motor
from .report.saving import save
from .study.load import load_study
from .study.requirement import Requirement
from .study.rig import Rig
from .study.spreads import Uncertainty
from .study.study import Study
from .transmission.geometry import ContactGeometry
from .transmission.operating_point import OperatingPoint
from .transmission.rotary_linear import RotaryLinearIVT

__all__ = [
    "Amplifier",
    "AuditError",
    "Bearing",
    "Calibration",
    "CoboticDrive",
    "Comparison",
    "ConstantForce",
    "ContactGeometry",
    "ContactSheet",
    "ConventionalDrive",
    "Course",
    "CreepLaw",
    "Cruise",
    "Definition",
    "DrivePoint",
    "DriveResult",
    "DutyCycle",
    "DutyResult",
    "DynamicMap",
    "Force",
    "Gearhead",
    "Guideway",
    "Hold",
    "InfinivarError",
    "InputError",
    "Limit",
    "Material",
    "Motion",
    "Motor",
    "MovingPoint",
    "OperatingPoint",
    "ParameterError",
    "PeriodicMotion",
    "Pulley",
    "Reach",
    "Reaches",
    "RecordedForce",
    "Recording",
    "Requirement",
    "Rest",
    "Rig",
    "RotaryLinearIVT",
    "Scenario",
    "Sensitivity",
    "Simulation",
    "Sinusoid",
    "SinusoidalForce",
    "SteadyMap",
    "SteeringPlant",
    "Step",
    "StepForce",
    "Study",
    "Tremor",
    "Uncertainty",
    "Walking",
    "Waypoints",
    "__version__",
    "calibrate",
    "compare",
    "contact_sheets",
    "duty_cycle",
    "dynamic_map",
    "load_study",
    "reproduce",
    "save",
    "sensitivity",
    "simulate",
    "steady_map",
]

__version__: str
