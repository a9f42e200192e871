from . import bodies, creep, exact_tables, fastsim, friction, hertz, hysteresis, kalker, spin, wear

__all__ = [
    "bodies",
    "creep",
    "exact_tables",
    "fastsim",
    "friction",
    "hertz",
    "hysteresis",
    "kalker",
    "spin",
    "wear",
]
