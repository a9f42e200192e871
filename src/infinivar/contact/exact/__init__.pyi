from . import equations, fit, grid, influence, many, newton, patch, spin_map, spin_nodes, spin_table, transient

__all__ = [
    "equations",
    "fit",
    "grid",
    "influence",
    "many",
    "newton",
    "patch",
    "spin_map",
    "spin_nodes",
    "spin_table",
    "transient",
]
