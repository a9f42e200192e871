"""Cobotic drives: motor, gearhead, axle bearing and steering motor of tables, radii, cylinder speed and preload of ranges."""

from infinivar.sizing.cobotic.result import CoboticDesign, CoboticSizing
from infinivar.sizing.cobotic.search import size_cobotic

__all__ = ["CoboticDesign", "CoboticSizing", "size_cobotic"]
