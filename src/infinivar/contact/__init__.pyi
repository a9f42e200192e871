from . import bodies, creep, exact, exact_law, exact_tables, fastsim, friction, hertz, hysteresis, kalker, spin, wear

__all__ = [
    "bodies",
    "creep",
    "exact",
    "exact_law",
    "exact_tables",
    "fastsim",
    "friction",
    "hertz",
    "hysteresis",
    "kalker",
    "spin",
    "wear",
]
