"""The paper's figures that are drawn from models, by number.

Each module has ``data(machine)``, ``draw(ax, ...)``, ``draw_all(machine)`` and ``CAPTION``.
"""

from infinivar.paper.figures import (
    fig05_creep,
    fig07_element_efficiency,
    fig08_gear_comparison,
    fig15_conventional_ranges,
    fig16_cobotic_range,
    fig17_dynamic_performance,
)

FIGURES = {
    5: fig05_creep,
    7: fig07_element_efficiency,
    8: fig08_gear_comparison,
    15: fig15_conventional_ranges,
    16: fig16_cobotic_range,
    17: fig17_dynamic_performance,
}
