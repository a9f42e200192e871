"""Designs of a search by mass and power: names and legend stand clear of each other and of the markers."""

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from internals import sizing_figure as sizing
from internals import style


def drawn(front, cloud=((0.3, 30.0),)):
    """Axes with their figure drawn, of designs that are of two templates in turn."""
    front, cloud = np.asarray(front, dtype=float), np.asarray(cloud, dtype=float)
    none = np.empty((0, 2))
    groups = {
        "geared": {"designs": front[:1], "front": front[::2], "cloud": cloud},
        "cobotic": {"designs": front[-1:], "front": front[1::2], "cloud": none},
    }
    with style.styled():
        made, axes = style.figure(7.2, 4.9, squeeze=False)
        sizing.draw(axes[0, 0], {"front": front, "groups": groups, "label": "mean power from the supply [W]"})
        canvas = FigureCanvasAgg(made)
        canvas.draw()
    return axes[0, 0], canvas.get_renderer()


CLOSE = [(0.575 - 0.002 * k, 2.7 * 1.002**k) for k in range(6)] + [
    (0.085 - 0.001 * k, 20.0 + 0.2 * k) for k in range(8)
]
APART = [(0.08 * 1.4**k, 40.0 / 1.5**k) for k in range(7)][::-1]


@pytest.mark.parametrize(("front", "least"), [(CLOSE, 2), (APART, 6), (APART[:1], 1), (CLOSE[:1] * 5, 1)])
def test_names_do_not_overlap(front, least):
    ax, renderer = drawn(front)
    boxes = [text.get_window_extent(renderer) for text in ax.texts]
    assert least <= len(boxes) <= 8
    for one, two in itertools.combinations(boxes, 2):
        assert not one.overlaps(two)
    inside = ax.get_window_extent(renderer)
    markers = ax.transData.transform(np.unique(front, axis=0) * (1e3, 1.0))
    for box in boxes:
        assert inside.x0 <= box.x0 < box.x1 <= inside.x1
        assert not any(box.contains(*marker) for marker in markers)
    legend = ax.get_legend().get_window_extent(renderer)
    assert legend.y1 < inside.y0
    assert legend.y0 >= 0.0
    assert 0.0 <= legend.x0 < legend.x1 <= ax.figure.bbox.x1
