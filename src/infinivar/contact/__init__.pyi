from . import (
    bodies,
    creep,
    exact,
    exact_law,
    exact_tables,
    flash,
    friction,
    hertz,
    hysteresis,
    kalker,
    shakedown,
    spin,
    traction_fluid,
    turned,
    wear,
)
from .bodies import Material
from .creep import CreepLaw
from .exact.many import RollingForces, rolling_forces
from .exact.patch import RollingPatch, SteadyRolling
from .exact.spin_map import SpinMap, spin_map
from .exact.transient import TransientRolling

__all__ = [
    "CreepLaw",
    "Material",
    "RollingForces",
    "RollingPatch",
    "SpinMap",
    "SteadyRolling",
    "TransientRolling",
    "bodies",
    "creep",
    "exact",
    "exact_law",
    "exact_tables",
    "flash",
    "friction",
    "hertz",
    "hysteresis",
    "kalker",
    "rolling_forces",
    "shakedown",
    "spin",
    "spin_map",
    "traction_fluid",
    "turned",
    "wear",
]
