from . import design_trends
from .common_speed import CommonSpeed, best_cylinder_speed
from .compare import DriveResult
from .cycles.cylinder_policy import Policy, policies
from .cycles.duty_comparison import DutyComparison
from .cycles.duty_cycle import holding
from .cycles.duty_result import Holding
from .cycles.mixed_use import MixedUse
from .cycles.performance import Definition
from .cycles.shaking import DynamicMap, dynamic_map, shaking
from .cycles.single_strides import StrideEnergies, stride_energies
from .cycles.tracking import TwoWays, two_ways
from .hanging import Hanging
from .loss_ranking import LeastLoss, least_loss
from .robustness.verdicts import Builds
from .sessions.session_result import Overrun, Touch
from .shared_motor import SharedMotor, share_motor
from .sphere_efficiency import SphereMap, sphere_map
from .steering_step import SteeringStep, steering_steps
from .whole_mass import WholeMass, whole_mass
from .workspace import StaticPoints, WorkspaceMap, static_points, workspace_map

__all__ = [
    "Builds",
    "CommonSpeed",
    "Definition",
    "DriveResult",
    "DutyComparison",
    "DynamicMap",
    "Hanging",
    "Holding",
    "LeastLoss",
    "MixedUse",
    "Overrun",
    "Policy",
    "SharedMotor",
    "SphereMap",
    "StaticPoints",
    "SteeringStep",
    "StrideEnergies",
    "Touch",
    "TwoWays",
    "WholeMass",
    "WorkspaceMap",
    "best_cylinder_speed",
    "design_trends",
    "dynamic_map",
    "holding",
    "least_loss",
    "policies",
    "shaking",
    "share_motor",
    "sphere_map",
    "static_points",
    "steering_steps",
    "stride_energies",
    "two_ways",
    "whole_mass",
    "workspace_map",
]
