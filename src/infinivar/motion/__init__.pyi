from .course import Course
from .files.joints import joint_recording
from .files.table import RecordedTable
from .forces import ConstantForce, SinusoidalForce, StepForce
from .gait import Running, Walking
from .histories import VectorHistory
from .machine_scenario import MachineScenario
from .machine_tasks import MachinePath, MachineTask
from .motion import Force, Motion, PeriodicMotion
from .motions import Cruise, Hold, Reach, Reaches, Rest, Sinusoid, Step, Tremor
from .recordings import Recording
from .strides import Strides
from .users import ArmModel, PushingUser, ReachingUser
from .vectors import Point, Pose, Twist, Wrench
from .virtual.curves import ArcCurve, LineCurve, PointCurve
from .virtual.fixtures import AboutAxis, AboutPoint, AlongLine, InPlane, OnCurve, OnSurface
from .virtual.meshes import TriangleMesh
from .virtual.surfaces import Ball, HalfSpace, Surfaces, Tube
from .virtual.tasks import Caster, Coasting, Fixture, HoldingTask, VirtualPath, VirtualWall
from .waypoints import RecordedForce, Waypoints

__all__ = [
    "AboutAxis",
    "AboutPoint",
    "AlongLine",
    "ArcCurve",
    "ArmModel",
    "Ball",
    "Caster",
    "Coasting",
    "ConstantForce",
    "Course",
    "Cruise",
    "Fixture",
    "Force",
    "HalfSpace",
    "Hold",
    "HoldingTask",
    "InPlane",
    "LineCurve",
    "MachinePath",
    "MachineScenario",
    "MachineTask",
    "Motion",
    "OnCurve",
    "OnSurface",
    "PeriodicMotion",
    "Point",
    "PointCurve",
    "Pose",
    "PushingUser",
    "Reach",
    "Reaches",
    "ReachingUser",
    "RecordedForce",
    "RecordedTable",
    "Recording",
    "Rest",
    "Running",
    "Sinusoid",
    "SinusoidalForce",
    "Step",
    "StepForce",
    "Strides",
    "Surfaces",
    "Tremor",
    "TriangleMesh",
    "Tube",
    "Twist",
    "VectorHistory",
    "VirtualPath",
    "VirtualWall",
    "Walking",
    "Waypoints",
    "Wrench",
    "joint_recording",
]
