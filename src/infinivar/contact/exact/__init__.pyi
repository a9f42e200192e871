from . import equations, grid, many, newton, patch, spin_map, transient

__all__ = [
    "equations",
    "grid",
    "many",
    "newton",
    "patch",
    "spin_map",
    "transient",
]
