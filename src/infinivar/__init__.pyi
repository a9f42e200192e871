from . import bondgraph, contact, parts, power
from ._core.array_namespace import array_namespace
from ._core.fields import check_fields, component, quantities, quantity
from ._core.result import Result
from .analysis import design_trends
from .analysis.compare import Comparison, DriveResult, compare
from .analysis.contact_sheet import ContactSheet, contact_sheets
from .analysis.cycles.cylinder_policy import Policy, policies
from .analysis.cycles.duty_comparison import DutyComparison
from .analysis.cycles.duty_cycle import duty_cycle, holding
from .analysis.cycles.duty_result import DutyResult, Holding
from .analysis.cycles.mixed_use import MixedUse
from .analysis.cycles.performance import Definition
from .analysis.cycles.shaking import DynamicMap, dynamic_map, shaking
from .analysis.cycles.single_strides import StrideEnergies, stride_energies
from .analysis.cycles.tracking import TwoWays, two_ways
from .analysis.least_loss import LeastLoss, least_loss
from .analysis.motion_summary import MotionSummary, inspect_motion
from .analysis.robustness.sensitivity import Sensitivity, sensitivity
from .analysis.robustness.verdicts import Builds
from .analysis.simulate import Simulation, simulate
from .analysis.steady_map import SteadyMap, steady_map
from .analysis.steering_step import SteeringStep, steering_steps
from .bondgraph.audit import Trajectory
from .calibration.calibrate import calibrate, calibrate_cobotic
from .calibration.geared.calibrate import calibrate_geared
from .calibration.geared.result import GearedCalibration
from .calibration.result import Calibration
from .contact.bodies import Material
from .contact.creep import CreepLaw
from .contact.exact.many import RollingForces, rolling_forces
from .contact.exact.patch import RollingPatch, SteadyRolling
from .contact.exact.spin_map import SpinMap, spin_map
from .contact.exact.transient import TransientRolling
from .drivetrain.cobotic import CoboticDrive, SteeringPlant
from .drivetrain.conventional import ConventionalDrive
from .drivetrain.drive import DrivePoint, MovingPoint
from .drivetrain.graphs.plants import plant_graph
from .drivetrain.output import Output
from .errors import AuditError, InfinivarError, InputError, ParameterError
from .limits import Limit
from .motion.course import Course
from .motion.duty_cycles import DutyCycle
from .motion.files.reading import read_table
from .motion.files.table import RecordedTable
from .motion.forces import ConstantForce, SinusoidalForce, StepForce
from .motion.gait import Running, Walking
from .motion.motion import Force, Motion, PeriodicMotion
from .motion.motions import Cruise, Hold, Reach, Reaches, Rest, Sinusoid, Step, Tremor
from .motion.recordings import Recording
from .motion.scenario import Scenario
from .motion.strides import Strides
from .motion.waypoints import RecordedForce, Waypoints
from .paper.reproduce import Reproduction, reproduce
from .parts.amplifier import Amplifier
from .parts.bearing import Bearing
from .parts.belt import Belt, Rack
from .parts.gear_friction import GearFriction
from .parts.gearhead import Gearhead
from .parts.linear import Guideway, Pulley
from .parts.linkage import Linkage
from .parts.motor import Motor
from .parts.screw import Screw
from .parts.spring import Spring, TorsionSpring
from .parts.stage import Shaft
from .parts.tables.consistency import CatalogueCheck, check_parts
from .parts.tables.importing import PartImport, import_parts
from .parts.tables.search import PartSearch, search_parts
from .parts.tables.stores import load_parts
from .parts.tables.table import PartSet, PartTable
from .report.saving import save
from .sizing.result import Sizing
from .sizing.size import size
from .study.catalogue import bearings, gearheads, materials, motors
from .study.load import load_study
from .study.provenance import Provenance
from .study.requirement import JointRequirement, Requirement
from .study.rig import Rig
from .study.save import save_study
from .study.spreads import Uncertainty
from .study.study import Study
from .transmission.geometry import ContactGeometry
from .transmission.operating_point import OperatingPoint
from .transmission.rotary_linear import RotaryLinearIVT

__all__ = [
    "Amplifier",
    "AuditError",
    "Bearing",
    "Belt",
    "Builds",
    "Calibration",
    "CatalogueCheck",
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
    "DutyComparison",
    "DutyCycle",
    "DutyResult",
    "DynamicMap",
    "Force",
    "GearFriction",
    "GearedCalibration",
    "Gearhead",
    "Guideway",
    "Hold",
    "Holding",
    "InfinivarError",
    "InputError",
    "JointRequirement",
    "LeastLoss",
    "Limit",
    "Linkage",
    "Material",
    "MixedUse",
    "Motion",
    "MotionSummary",
    "Motor",
    "MovingPoint",
    "OperatingPoint",
    "Output",
    "ParameterError",
    "PartImport",
    "PartSearch",
    "PartSet",
    "PartTable",
    "PeriodicMotion",
    "Policy",
    "Provenance",
    "Pulley",
    "Rack",
    "Reach",
    "Reaches",
    "RecordedForce",
    "RecordedTable",
    "Recording",
    "Reproduction",
    "Requirement",
    "Rest",
    "Result",
    "Rig",
    "RollingForces",
    "RollingPatch",
    "RotaryLinearIVT",
    "Running",
    "Scenario",
    "Screw",
    "Sensitivity",
    "Shaft",
    "Simulation",
    "Sinusoid",
    "SinusoidalForce",
    "Sizing",
    "SpinMap",
    "Spring",
    "SteadyMap",
    "SteadyRolling",
    "SteeringPlant",
    "SteeringStep",
    "Step",
    "StepForce",
    "StrideEnergies",
    "Strides",
    "Study",
    "TorsionSpring",
    "Trajectory",
    "TransientRolling",
    "Tremor",
    "TwoWays",
    "Uncertainty",
    "Walking",
    "Waypoints",
    "__version__",
    "array_namespace",
    "bearings",
    "bondgraph",
    "calibrate",
    "calibrate_cobotic",
    "calibrate_geared",
    "check_fields",
    "check_parts",
    "compare",
    "component",
    "contact",
    "contact_sheets",
    "design_trends",
    "duty_cycle",
    "dynamic_map",
    "gearheads",
    "holding",
    "import_parts",
    "inspect_motion",
    "least_loss",
    "load_parts",
    "load_study",
    "materials",
    "motors",
    "parts",
    "plant_graph",
    "policies",
    "power",
    "quantities",
    "quantity",
    "read_table",
    "reproduce",
    "rolling_forces",
    "save",
    "save_study",
    "search_parts",
    "sensitivity",
    "shaking",
    "simulate",
    "size",
    "spin_map",
    "steady_map",
    "steering_steps",
    "stride_energies",
    "two_ways",
]

__version__: str
