from .provenance import Provenance
from .requirement import JointRequirement
from .rig import Rig
from .sessions import ControllerSettings, SessionTask

__all__ = [
    "ControllerSettings",
    "JointRequirement",
    "Provenance",
    "Rig",
    "SessionTask",
]
