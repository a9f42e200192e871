from . import (
    analysis,
    bondgraph,
    calibration,
    contact,
    displays,
    drivetrain,
    machines,
    motion,
    paper,
    parts,
    power,
    study,
    sweeps,
    transmission,
)
from ._core.array_namespace import array_namespace
from ._core.fields import check_fields, component, quantities, quantity
from ._core.result import Result
from .analysis.compare import Comparison, compare
from .analysis.contact_sheet import ContactSheet, contact_sheets
from .analysis.cycles.duty_cycle import duty_cycle
from .analysis.cycles.duty_result import DutyResult
from .analysis.machine_motion import simulate_machine
from .analysis.machine_run import MachineRun
from .analysis.machines import MachineComparison
from .analysis.motion_summary import MotionSummary, inspect_motion
from .analysis.performing import follow_path, perform_task
from .analysis.robustness.sensitivity import Sensitivity, sensitivity
from .analysis.sessions.of_study import study_session
from .analysis.sessions.session import session
from .analysis.sessions.session_result import Session
from .analysis.simulate import Simulation, simulate
from .analysis.steady_map import SteadyMap, steady_map
from .calibration.calibrate import calibrate
from .calibration.result import Calibration
from .drivetrain.cobotic import CoboticDrive
from .drivetrain.conventional import ConventionalDrive
from .drivetrain.graphs.plants import plant_graph
from .drivetrain.output import Output
from .errors import AuditError, InfinivarError, InputError, ParameterError
from .exports.export import export
from .limits import Limit
from .machines.graph import machine_graph
from .motion.duty_cycles import DutyCycle
from .motion.files.reading import read_table
from .motion.scenario import Scenario
from .paper.reproduce import Reproduction, reproduce
from .parts.tables.consistency import check_parts
from .parts.tables.importing import import_parts
from .parts.tables.search import search_parts
from .parts.tables.stores import load_parts
from .report.stored import load_result, save
from .sizing.builds.result import Doubt
from .sizing.result import Sizing
from .sizing.robustness import doubt
from .sizing.size import size
from .study.catalogue import bearings, belts, gearheads, materials, motors, rails, springs, tubes
from .study.load import load_study
from .study.requirement import Requirement
from .study.save import save_study
from .study.spreads import Uncertainty
from .study.study import Study
from .sweeps.sweep import Sweep, load_sweep, sweep
from .transmission.operating_point import OperatingPoint
from .transmission.rotary_linear import RotaryLinearIVT
from .transmission.spherical import SphericalIVT

__all__ = [
    "AuditError",
    "Calibration",
    "CoboticDrive",
    "Comparison",
    "ContactSheet",
    "ConventionalDrive",
    "Doubt",
    "DutyCycle",
    "DutyResult",
    "InfinivarError",
    "InputError",
    "Limit",
    "MachineComparison",
    "MachineRun",
    "MotionSummary",
    "OperatingPoint",
    "Output",
    "ParameterError",
    "Reproduction",
    "Requirement",
    "Result",
    "RotaryLinearIVT",
    "Scenario",
    "Sensitivity",
    "Session",
    "Simulation",
    "Sizing",
    "SphericalIVT",
    "SteadyMap",
    "Study",
    "Sweep",
    "Uncertainty",
    "__version__",
    "analysis",
    "array_namespace",
    "bearings",
    "belts",
    "bondgraph",
    "calibrate",
    "calibration",
    "check_fields",
    "check_parts",
    "compare",
    "component",
    "contact",
    "contact_sheets",
    "displays",
    "doubt",
    "drivetrain",
    "duty_cycle",
    "export",
    "follow_path",
    "gearheads",
    "import_parts",
    "inspect_motion",
    "load_parts",
    "load_result",
    "load_study",
    "load_sweep",
    "machine_graph",
    "machines",
    "materials",
    "motion",
    "motors",
    "paper",
    "parts",
    "perform_task",
    "plant_graph",
    "power",
    "quantities",
    "quantity",
    "rails",
    "read_table",
    "reproduce",
    "save",
    "save_study",
    "search_parts",
    "sensitivity",
    "session",
    "simulate",
    "simulate_machine",
    "size",
    "springs",
    "steady_map",
    "study",
    "study_session",
    "sweep",
    "sweeps",
    "transmission",
    "tubes",
]

__version__: str
