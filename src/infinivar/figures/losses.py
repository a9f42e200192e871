"""Losses at the corners of the required region: stacked bars, one per drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from infinivar.analysis.compare import Comparison
from infinivar.axis import Axis
from infinivar.figures import style
from infinivar.limits import Limit
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def data(comparison: Comparison, corner: str) -> dict[str, Any]:
    """Losses and supply power [W] by drive at a corner, with the limit exceeded, if any, the title and the unit."""
    corners = {result.title: result.corners[corner] for result in comparison.results.values()}
    first, axis = next(iter(corners.values())), comparison.study.axis
    where = f"{plain(first.force, 3)} {axis.force_unit} at {plain(first.speed, 3)} {axis.speed_unit}"
    return {
        "title": f"{corner_words(corner, axis)}: {where}",
        "unit": "W",
        "losses": {title: dict(point.losses) for title, point in corners.items()},
        "power_in": {title: point.power_in for title, point in corners.items()},
        "limit": {title: point.limit for title, point in corners.items()},
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw horizontal stacked bars; drives beyond a limit are pale and name it, drives with an unknown loss have no bar."""
    titles, unit = list(numbers["losses"]), numbers["unit"]
    # A sum with an unknown part, as where the wheel slips, would be too small.
    known = {
        title: losses if all(loss == loss for loss in losses.values()) else {}
        for title, losses in numbers["losses"].items()
    }
    every = dict.fromkeys([*style.LOSS_COLOURS, *(name for losses in known.values() for name in losses)])
    names = [name for name in every if any(losses.get(name, 0.0) > 0.0 for losses in known.values())]
    left = [0.0] * len(titles)
    for name in names:
        values = [known[title].get(name, 0.0) for title in titles]
        alphas = [1.0 if numbers["limit"][title] == Limit.OK else 0.35 for title in titles]
        bars = ax.barh(range(len(titles)), values, left=left, color=style.loss_colour(name), label=name, height=0.65)
        for bar, alpha in zip(bars, alphas, strict=True):
            bar.set_alpha(alpha)
        left = [start + value for start, value in zip(left, values, strict=True)]
    for row, title in enumerate(titles):
        note = _note(left[row], numbers["power_in"][title], numbers["limit"][title], unit)
        ax.text(left[row], row, f" {note}", va="center", fontsize=7.5)
    ax.set_xlim(0.0, max(left) * 1.45 or 1.0)
    ax.set_yticks(range(len(titles)), titles, parse_math=False)
    ax.set_ylim(len(titles) - 0.5, -0.5)
    ax.set_xlabel(f"loss [{unit}]")
    ax.set_title(numbers["title"])


def _note(loss: float, power_in: float, limit: Limit, unit: str) -> str:
    """Text beside a bar: the loss, power returned, and the limit exceeded."""
    note = f"{plain(loss, 3)} {unit}" if loss > 0 else ""
    if power_in < 0:
        note = f"{note}, {plain(-power_in, 3)} {unit} go back"
    return note if limit == Limit.OK else f"{note}  beyond {limit.words}".strip()


def corner_words(corner: str, axis: Axis) -> str:
    """Name of a corner of the required region in the words of the axis, such as "maximum moment"."""
    return corner.replace("force", axis.force).replace("speed", axis.speed)


def draw_all(comparison: Comparison) -> Figure:
    """Loss bars at every corner of the requirement, with one legend.

    Raises
    ------
    InputError
        If the study has no requirement.
    """
    corners = list(comparison.study.required("losses at the corners of the required region").corners())
    columns = min(2, len(corners))
    rows = -(-len(corners) // columns)
    height = (0.9 + 0.34 * len(comparison.results)) * rows + 0.5
    with style.styled():
        made, axes = style.figure(5.2 * columns + 0.8, height, rows, columns, squeeze=False, sharey=True)
        for ax, corner in zip(axes.flat, corners, strict=True):
            draw(ax, data(comparison, corner))
        handles, labels = legend(axes.flat)
        made.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return made


def legend(axes: Any) -> tuple[list[Any], list[str]]:
    """Legend entries of all axes, each loss once, in full colour."""
    from matplotlib.patches import Patch

    names = dict.fromkeys(label for ax in axes for label in ax.get_legend_handles_labels()[1])
    return [Patch(color=style.loss_colour(name)) for name in names], list(names)
