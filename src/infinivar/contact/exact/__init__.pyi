from . import equations, fit, grid, influence, newton, patch

__all__ = ["equations", "fit", "grid", "influence", "newton", "patch"]
