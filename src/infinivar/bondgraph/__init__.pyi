from .audit import Trajectory
from .causality import Causality, assign
from .describe import latex, text
from .equations import derive
from .graph import (
    Bond,
    BondGraph,
    BondGraphError,
    Element,
    Parameter,
    Signal,
    compliance,
    conductance,
    effort_source,
    flow_source,
    gyrator,
    inertia,
    join,
    one,
    resistance,
    transformer,
    zero,
)
from .inputs import Controller, Input
from .solver import solve
from .state_space import Equations

__all__ = [
    "Bond",
    "BondGraph",
    "BondGraphError",
    "Causality",
    "Controller",
    "Element",
    "Equations",
    "Input",
    "Parameter",
    "Signal",
    "Trajectory",
    "assign",
    "compliance",
    "conductance",
    "derive",
    "effort_source",
    "flow_source",
    "gyrator",
    "inertia",
    "join",
    "latex",
    "one",
    "resistance",
    "solve",
    "text",
    "transformer",
    "zero",
]
