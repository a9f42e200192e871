from . import equations, grid, influence, newton, patch, spin_map, spin_nodes

__all__ = ["equations", "grid", "influence", "newton", "patch", "spin_map", "spin_nodes"]
