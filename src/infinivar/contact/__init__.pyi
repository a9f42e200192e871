from . import bodies, creep, exact, exact_tables, fastsim, friction, hertz, hysteresis, kalker, spin, wear

__all__ = [
    "bodies",
    "creep",
    "exact",
    "exact_tables",
    "fastsim",
    "friction",
    "hertz",
    "hysteresis",
    "kalker",
    "spin",
    "wear",
]
