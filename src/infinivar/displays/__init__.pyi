from .comparison import DisplayComparison, compare_displays, display_break_even
from .directions import DirectionLimits, worst_direction
from .guidance import GuidanceLimits, guidance_limits
from .handle_session import HandleSession
from .impedance_range import ZWidth, swept_impedance, z_width
from .kinds import AdmittanceDisplay, ImpedanceDisplay
from .pair import DisplayPair, Rival, assumed_variants, usual_rivals
from .passivity_check import Passivity, passivity
from .stability import StabilityMap, largest_force_gain, least_stable_mass, stability_map, stiffest_wall

__all__ = [
    "AdmittanceDisplay",
    "DirectionLimits",
    "DisplayComparison",
    "DisplayPair",
    "GuidanceLimits",
    "HandleSession",
    "ImpedanceDisplay",
    "Passivity",
    "Rival",
    "StabilityMap",
    "ZWidth",
    "assumed_variants",
    "compare_displays",
    "display_break_even",
    "guidance_limits",
    "largest_force_gain",
    "least_stable_mass",
    "passivity",
    "stability_map",
    "stiffest_wall",
    "swept_impedance",
    "usual_rivals",
    "worst_direction",
    "z_width",
]
