from .control.controller import Commands, Measured
from .control.impedance import ImpedanceGuide
from .control.legs import AdmittanceGuide, HoldGuide
from .control.planar import CasterGuide, PathGuide, WallGuide
from .control.sampling import Sensing
from .control.tasks import CoastGuide
from .kinds.arm import ArmDrive, ArmMachine
from .kinds.driven_motion import DrivenMachine
from .kinds.omniwheels import OmniwheelDrive, OmniwheelMachine
from .kinds.planar import PlanarDrive
from .kinds.planar_motion import PlanarMachine
from .kinds.platform import PlatformDrive, PlatformGeometry, PlatformMachine
from .kinds.robot import RobotDrive, RobotMachine
from .kinds.serial_arm import SerialArmMachine
from .kinds.slide import GearedSlideMachine, SlideMachine
from .kinds.sphere import SphereDrive, SphereMachine
from .machine import TaskPoint
from .many_legs import LeggedDrive, MachinePoint
from .wheel import Wheel

__all__ = [
    "AdmittanceGuide",
    "ArmDrive",
    "ArmMachine",
    "CasterGuide",
    "CoastGuide",
    "Commands",
    "DrivenMachine",
    "GearedSlideMachine",
    "HoldGuide",
    "ImpedanceGuide",
    "LeggedDrive",
    "MachinePoint",
    "Measured",
    "OmniwheelDrive",
    "OmniwheelMachine",
    "PathGuide",
    "PlanarDrive",
    "PlanarMachine",
    "PlatformDrive",
    "PlatformGeometry",
    "PlatformMachine",
    "RobotDrive",
    "RobotMachine",
    "Sensing",
    "SerialArmMachine",
    "SlideMachine",
    "SphereDrive",
    "SphereMachine",
    "TaskPoint",
    "WallGuide",
    "Wheel",
]
