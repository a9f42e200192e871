from .arm import PlanarArm
from .configuration import Configuration
from .geometry import ContactGeometry
from .legs import Legs, LegsPoint
from .mechanism import Mechanism, MechanismPoint
from .planar import PlanarCarriage, PlanarCobot
from .platform import Platform
from .rolling_contact import RollingContact
from .sphere_layout import Roller
from .spherical import SphericalPoint
from .urdf import UrdfRobot, load_urdf
from .wrench_set import WrenchSet

__all__ = [
    "Configuration",
    "ContactGeometry",
    "Legs",
    "LegsPoint",
    "Mechanism",
    "MechanismPoint",
    "PlanarArm",
    "PlanarCarriage",
    "PlanarCobot",
    "Platform",
    "Roller",
    "RollingContact",
    "SphericalPoint",
    "UrdfRobot",
    "WrenchSet",
    "load_urdf",
]
