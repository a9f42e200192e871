from . import bondgraph, contact, parts, power
from ._core.array_namespace import array_namespace
from ._core.fields import check_fields, component, quantities, quantity
from ._core.result import Result
from .analysis import design_trends
from .analysis.common_speed import CommonSpeed, best_cylinder_speed
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
from .analysis.hanging import Hanging
from .analysis.least_loss import LeastLoss, least_loss
from .analysis.machine_motion import simulate_machine
from .analysis.machine_run import MachineRun
from .analysis.machine_tasks import follow_path, perform_task
from .analysis.machines import MachineComparison
from .analysis.motion_summary import MotionSummary, inspect_motion
from .analysis.robustness.sensitivity import Sensitivity, sensitivity
from .analysis.robustness.verdicts import Builds
from .analysis.sessions.comparison import DisplayComparison, compare_displays, display_break_even
from .analysis.sessions.display_pair import DisplayPair, assumed_variants
from .analysis.sessions.displays import AdmittanceDisplay, ImpedanceDisplay
from .analysis.sessions.handle_session import HandleSession
from .analysis.sessions.limits import GuidanceLimits, guidance_limits
from .analysis.sessions.of_study import study_session
from .analysis.sessions.passivity import Passivity, passivity
from .analysis.sessions.session import session
from .analysis.sessions.session_result import Overrun, Session, Touch
from .analysis.sessions.stability import (
    StabilityMap,
    largest_force_gain,
    least_stable_mass,
    stability_map,
    stiffest_wall,
)
from .analysis.sessions.z_width import ZWidth, swept_impedance, z_width
from .analysis.shared_motor import SharedMotor, share_motor
from .analysis.simulate import Simulation, simulate
from .analysis.sphere_map import SphereMap, sphere_map
from .analysis.steady_map import SteadyMap, steady_map
from .analysis.steering_step import SteeringStep, steering_steps
from .analysis.workspace import StaticPoints, WorkspaceMap, static_points, workspace_map
from .bondgraph.audit import Trajectory
from .calibration.calibrate import calibrate, calibrate_cobotic, calibrate_geared
from .calibration.result import Calibration, GearedCalibration
from .contact.bodies import Material
from .contact.creep import CreepLaw
from .contact.exact.many import RollingForces, rolling_forces
from .contact.exact.patch import RollingPatch, SteadyRolling
from .contact.exact.spin_map import SpinMap, spin_map
from .contact.exact.transient import TransientRolling
from .drivetrain.cobotic import CoboticDrive
from .drivetrain.conventional import ConventionalDrive
from .drivetrain.drive import Drive, DrivePoint, MovingPoint
from .drivetrain.graphs.plants import plant_graph
from .drivetrain.output import Output
from .drivetrain.steering import SteeringPlant
from .errors import AuditError, InfinivarError, InputError, ParameterError
from .limits import Limit
from .machines.control.controller import Commands, Measured
from .machines.control.impedance import ImpedanceGuide
from .machines.control.legs import AdmittanceGuide, HoldGuide
from .machines.control.planar import CasterGuide, PathGuide, WallGuide
from .machines.control.sensing import Sensing
from .machines.control.tasks import CoastGuide
from .machines.graph import machine_graph
from .machines.kinds.arm import ArmDrive, ArmMachine, SerialArmMachine
from .machines.kinds.omniwheels import OmniwheelDrive, OmniwheelMachine
from .machines.kinds.planar import PlanarDrive, PlanarMachine
from .machines.kinds.platform import PlatformDrive, PlatformGeometry, PlatformMachine
from .machines.kinds.slide import GearedSlideMachine, SlideMachine
from .machines.kinds.sphere import SphereDrive, SphereMachine
from .machines.machine import TaskPoint
from .machines.many_legs import LeggedDrive, MachinePoint
from .machines.wheel import Wheel
from .motion.course import Course
from .motion.duty_cycles import DutyCycle
from .motion.files.reading import read_table
from .motion.files.table import RecordedTable
from .motion.forces import ConstantForce, SinusoidalForce, StepForce
from .motion.gait import Running, Walking
from .motion.histories import VectorHistory
from .motion.machine_scenario import MachineScenario
from .motion.machine_tasks import MachinePath, MachineTask
from .motion.motion import Force, Motion, PeriodicMotion
from .motion.motions import Cruise, Hold, Reach, Reaches, Rest, Sinusoid, Step, Tremor
from .motion.recordings import Recording
from .motion.scenario import Scenario
from .motion.strides import Strides
from .motion.users import ArmModel, PushingUser, ReachingUser
from .motion.vectors import Point, Pose, Twist, Wrench
from .motion.virtual.curves import ArcCurve, LineCurve, PointCurve
from .motion.virtual.fixtures import AboutAxis, AboutPoint, AlongLine, InPlane, OnCurve, OnSurface
from .motion.virtual.meshes import TriangleMesh
from .motion.virtual.surfaces import Ball, HalfSpace, Surfaces, Tube
from .motion.virtual.tasks import Caster, Coasting, Fixture, HoldingTask, VirtualPath, VirtualWall
from .motion.waypoints import RecordedForce, Waypoints
from .paper.displays import DisplayClaims, display_claims
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
from .parts.shaft_bearings import CylinderBearings, PulleyBearings
from .parts.spring import Spring, TorsionSpring
from .parts.stage import Shaft
from .parts.strain_wave import StrainWave
from .parts.tables.consistency import CatalogueCheck, check_parts
from .parts.tables.importing import PartImport, import_parts
from .parts.tables.search import PartSearch, search_parts
from .parts.tables.stores import load_parts
from .parts.tables.table import PartSet, PartTable
from .report.stored import load_result, save
from .sizing.builds.result import Doubt
from .sizing.result import Sizing
from .sizing.robustness import doubt
from .sizing.size import size
from .study.catalogue import bearings, gearheads, materials, motors
from .study.load import load_study
from .study.provenance import Provenance
from .study.requirement import JointRequirement, Requirement
from .study.rig import Rig
from .study.save import save_study
from .study.sessions import ControllerSettings, SessionTask
from .study.spreads import Uncertainty
from .study.study import Study
from .sweeps.builds import BuildsSweep, builds_sweep
from .sweeps.cobotic import CoboticStudySweep, cobotic_study_sweep
from .sweeps.geared import GearedSweep, geared_sweep
from .sweeps.sensitivity import SensitivitySweep, sensitivity_sweep
from .sweeps.sessions import Sessions, SessionsSweep, sessions_sweep
from .sweeps.sweep import Sweep, load_sweep, sweep
from .transmission.arm import PlanarArm
from .transmission.configuration import Configuration
from .transmission.geometry import ContactGeometry
from .transmission.legs import Legs, LegsPoint
from .transmission.mechanism import Mechanism, MechanismPoint
from .transmission.operating_point import OperatingPoint
from .transmission.planar import PlanarCarriage, PlanarCobot
from .transmission.platform import Platform
from .transmission.rolling_contact import RollingContact
from .transmission.rotary_linear import RotaryLinearIVT
from .transmission.sphere_layout import Roller
from .transmission.spherical import SphericalIVT, SphericalPoint
from .transmission.urdf import UrdfRobot, load_urdf
from .transmission.wrench_set import WrenchSet

__all__ = [
    "AboutAxis",
    "AboutPoint",
    "AdmittanceDisplay",
    "AdmittanceGuide",
    "AlongLine",
    "Amplifier",
    "ArcCurve",
    "ArmDrive",
    "ArmMachine",
    "ArmModel",
    "AuditError",
    "Ball",
    "Bearing",
    "Belt",
    "Builds",
    "BuildsSweep",
    "Calibration",
    "Caster",
    "CasterGuide",
    "CatalogueCheck",
    "CoastGuide",
    "Coasting",
    "CoboticDrive",
    "CoboticStudySweep",
    "Commands",
    "CommonSpeed",
    "Comparison",
    "Configuration",
    "ConstantForce",
    "ContactGeometry",
    "ContactSheet",
    "ControllerSettings",
    "ConventionalDrive",
    "Course",
    "CreepLaw",
    "Cruise",
    "CylinderBearings",
    "Definition",
    "DisplayClaims",
    "DisplayComparison",
    "DisplayPair",
    "Doubt",
    "Drive",
    "DrivePoint",
    "DriveResult",
    "DutyComparison",
    "DutyCycle",
    "DutyResult",
    "DynamicMap",
    "Fixture",
    "Force",
    "GearFriction",
    "GearedCalibration",
    "GearedSlideMachine",
    "GearedSweep",
    "Gearhead",
    "GuidanceLimits",
    "Guideway",
    "HalfSpace",
    "HandleSession",
    "Hanging",
    "Hold",
    "HoldGuide",
    "Holding",
    "HoldingTask",
    "ImpedanceDisplay",
    "ImpedanceGuide",
    "InPlane",
    "InfinivarError",
    "InputError",
    "JointRequirement",
    "LeastLoss",
    "LeggedDrive",
    "Legs",
    "LegsPoint",
    "Limit",
    "LineCurve",
    "Linkage",
    "MachineComparison",
    "MachinePath",
    "MachinePoint",
    "MachineRun",
    "MachineScenario",
    "MachineTask",
    "Material",
    "Measured",
    "Mechanism",
    "MechanismPoint",
    "MixedUse",
    "Motion",
    "MotionSummary",
    "Motor",
    "MovingPoint",
    "OmniwheelDrive",
    "OmniwheelMachine",
    "OnCurve",
    "OnSurface",
    "OperatingPoint",
    "Output",
    "Overrun",
    "ParameterError",
    "PartImport",
    "PartSearch",
    "PartSet",
    "PartTable",
    "Passivity",
    "PathGuide",
    "PeriodicMotion",
    "PlanarArm",
    "PlanarCarriage",
    "PlanarCobot",
    "PlanarDrive",
    "PlanarMachine",
    "Platform",
    "PlatformDrive",
    "PlatformGeometry",
    "PlatformMachine",
    "Point",
    "PointCurve",
    "Policy",
    "Pose",
    "Provenance",
    "Pulley",
    "PulleyBearings",
    "PushingUser",
    "Rack",
    "Reach",
    "Reaches",
    "ReachingUser",
    "RecordedForce",
    "RecordedTable",
    "Recording",
    "Reproduction",
    "Requirement",
    "Rest",
    "Result",
    "Rig",
    "Roller",
    "RollingContact",
    "RollingForces",
    "RollingPatch",
    "RotaryLinearIVT",
    "Running",
    "Scenario",
    "Screw",
    "Sensing",
    "Sensitivity",
    "SensitivitySweep",
    "SerialArmMachine",
    "Session",
    "SessionTask",
    "Sessions",
    "SessionsSweep",
    "Shaft",
    "SharedMotor",
    "Simulation",
    "Sinusoid",
    "SinusoidalForce",
    "Sizing",
    "SlideMachine",
    "SphereDrive",
    "SphereMachine",
    "SphereMap",
    "SphericalIVT",
    "SphericalPoint",
    "SpinMap",
    "Spring",
    "StabilityMap",
    "StaticPoints",
    "SteadyMap",
    "SteadyRolling",
    "SteeringPlant",
    "SteeringStep",
    "Step",
    "StepForce",
    "StrainWave",
    "StrideEnergies",
    "Strides",
    "Study",
    "Surfaces",
    "Sweep",
    "TaskPoint",
    "TorsionSpring",
    "Touch",
    "Trajectory",
    "TransientRolling",
    "Tremor",
    "TriangleMesh",
    "Tube",
    "Twist",
    "TwoWays",
    "Uncertainty",
    "UrdfRobot",
    "VectorHistory",
    "VirtualPath",
    "VirtualWall",
    "Walking",
    "WallGuide",
    "Waypoints",
    "Wheel",
    "WorkspaceMap",
    "Wrench",
    "WrenchSet",
    "ZWidth",
    "__version__",
    "array_namespace",
    "assumed_variants",
    "bearings",
    "best_cylinder_speed",
    "bondgraph",
    "builds_sweep",
    "calibrate",
    "calibrate_cobotic",
    "calibrate_geared",
    "check_fields",
    "check_parts",
    "cobotic_study_sweep",
    "compare",
    "compare_displays",
    "component",
    "contact",
    "contact_sheets",
    "design_trends",
    "display_break_even",
    "display_claims",
    "doubt",
    "duty_cycle",
    "dynamic_map",
    "follow_path",
    "geared_sweep",
    "gearheads",
    "guidance_limits",
    "holding",
    "import_parts",
    "inspect_motion",
    "largest_force_gain",
    "least_loss",
    "least_stable_mass",
    "load_parts",
    "load_result",
    "load_study",
    "load_sweep",
    "load_urdf",
    "machine_graph",
    "materials",
    "motors",
    "parts",
    "passivity",
    "perform_task",
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
    "sensitivity_sweep",
    "session",
    "sessions_sweep",
    "shaking",
    "share_motor",
    "simulate",
    "simulate_machine",
    "size",
    "sphere_map",
    "spin_map",
    "stability_map",
    "static_points",
    "steady_map",
    "steering_steps",
    "stiffest_wall",
    "stride_energies",
    "study_session",
    "sweep",
    "swept_impedance",
    "two_ways",
    "workspace_map",
    "z_width",
]

__version__: str
