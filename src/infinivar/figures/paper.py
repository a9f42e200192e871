"""The figures of the paper that can be drawn, by number."""

from infinivar.figures import (
    cobotic_range,
    conventional_ranges,
    creep_curve,
    dynamic_performance,
    element_efficiency,
    gear_comparison,
)

FIGURES = {
    5: creep_curve,
    7: element_efficiency,
    8: gear_comparison,
    15: conventional_ranges,
    16: cobotic_range,
    17: dynamic_performance,
}
"""Modules with ``data(machine)``, ``draw(ax, ...)``, ``draw_all(machine)`` and ``CAPTION``."""
