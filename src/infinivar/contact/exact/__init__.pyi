from . import equations, fit, grid, many, newton, patch, spin_map, tabulate, transient

__all__ = [
    "equations",
    "fit",
    "grid",
    "many",
    "newton",
    "patch",
    "spin_map",
    "tabulate",
    "transient",
]
