from . import equations, grid, influence, newton, patch

__all__ = ["equations", "grid", "influence", "newton", "patch"]
