"""Cobotic drives: motor, gearhead, axle bearing and steering motor of tables, radii, cylinder speed and preload of ranges."""

from infinivar.sizing.cobotic.search import size_cobotic
from infinivar.sizing.found import CoboticDesign, CoboticSizing

__all__ = ["CoboticDesign", "CoboticSizing", "size_cobotic"]
