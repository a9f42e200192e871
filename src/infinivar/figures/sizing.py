"""Designs of a search in the plane of mass and power, or of mass and what was made small, with the front."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.sizing.design import SizedDrive
from infinivar.sizing.result import Sizing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import XAxis, YAxis
    from matplotlib.figure import Figure

_FAR = 8.0
"""Ratio of the largest to the least value above which an axis is logarithmic."""
_NAMED = 8
"""Most designs of the front that are named."""
_LETTER, _LINE = 5.0, 9.5
"""Most that a letter of a name needs in width, and a line in height. [pt]"""
_MARKER, _DOT = 4.0, 1.5
"""Half of a marker of a design, and of a dot of the cloud. [pt]"""
_BESIDE = ((-4.0, -4.0), (5.0, 4.0), (5.0, -4.0), (-4.0, 4.0))
"""Where a name may stand, by its corner at the marker: below to the left first, where no candidate is. [pt]"""
_COLOURS = (style.COLOURS[0], style.COLOURS[2], style.COLOURS[3])
_SHAPES = "osD"
"""Of each template."""


def data(sizing: Sizing) -> dict[str, Any]:
    """Mass of the designs, and their mean power, or space or price if that is the objective; without motion their margin.

    Returns
    -------
    dict
        ``designs`` and ``front`` (n, 2), ``cloud`` (m, 2) of the feasible candidates evaluated, ``label`` of the second column;
        ``groups`` by template: the same without the label.
    """
    measure = sizing.measure
    by_power = measure is None and sizing.study.moves

    def places(found: tuple[SizedDrive, ...]) -> np.ndarray:
        if measure is not None:
            second = [measure.scale * measure.of(one) for one in found]
        else:
            second = [one.power if by_power else one.margin for one in found]
        return np.array([(one.mass, value) for one, value in zip(found, second, strict=True)]).reshape(-1, 2)

    def of(name: str) -> dict[str, np.ndarray]:
        own = {
            kind: places(tuple(one for one in found if one.template == name))
            for kind, found in (("designs", (*sizing.designs, *best.get(name, ()))), ("front", sizing.front))
        }
        return {**own, "cloud": sizing.searches[name].cloud if by_power else np.empty((0, 2))}

    listed = {id(one) for one in sizing.designs}
    best = {name: (one,) for name, one in sizing.best_of.items() if id(one) not in listed}
    groups = {name: of(name) for name in sizing.searches}
    return {
        "designs": places(sizing.designs),
        "front": places(sizing.front),
        "cloud": np.concatenate([np.empty((0, 2)), *(group["cloud"] for group in groups.values())]),
        "groups": groups,
        "label": plane(sizing),
    }


def plane(sizing: Sizing) -> str:
    """What the figure shows beside mass, in words with the unit if it has one."""
    measure = sizing.measure
    if measure is not None:
        return measure.words if measure.unit == "1" else f"{measure.words} [{measure.unit}]"
    return "mean power from the supply [W]" if sizing.study.moves else "margin of the tightest limit"


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the designs by template, and the front as a stair: no candidate is below and to the left of it."""
    front, groups, grams = numbers["front"], numbers["groups"], 1e3
    for place, (name, group) in enumerate(groups.items()):
        of = f", {name}" if len(groups) > 1 else ""
        colour, shape = _COLOURS[place % len(_COLOURS)], _SHAPES[place % len(_SHAPES)]
        for kind, looks, label in (
            (
                "cloud",
                {"ls": "", "marker": ".", "color": colour, "alpha": 0.3, "ms": 4},
                "feasible candidates evaluated",
            ),
            ("designs", {"ls": "", "marker": shape, "mfc": "white", "color": colour, "ms": 5}, "best designs"),
            ("front", {"ls": "", "marker": shape, "color": colour, "ms": 6}, "front"),
        ):
            values = group[kind]
            if len(values):
                ax.plot(grams * values[:, 0], values[:, 1], label=f"{label}{of}", **looks)
    if len(front):
        order = np.argsort(front[:, 0])
        ax.step(grams * front[order, 0], front[order, 1], where="post", color=style.COLOURS[1], lw=1.3, zorder=1)
    ax.set(xlabel="mass of the whole drive [g]", ylabel=numbers["label"])
    points = np.concatenate([np.empty((0, 2)), *(values for group in groups.values() for values in group.values())])
    for axis, column in ((ax.xaxis, 0), (ax.yaxis, 1)):
        _wide(axis, points[:, column] * (grams if column == 0 else 1.0))
    ax.autoscale_view()
    for number, (right, up) in names(ax, front, _obstacles(groups)).items():
        mass, power = front[number]
        ax.annotate(
            f"front {number + 1}",
            (grams * mass, power),
            (right, up),
            textcoords="offset points",
            fontsize=8,
            ha="left" if right > 0.0 else "right",
            va="bottom" if up > 0.0 else "top",
        )
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=len(groups))


def names(ax: Axes, front: np.ndarray, obstacles: np.ndarray) -> dict[int, tuple[float, float]]:
    """Designs of the front that are named, and where each name begins beside its marker, so that no two overlap. [pt]

    They keep off the markers as well, and fewer are named where there is no space.

    Parameters
    ----------
    ax : Axes                 With its scales and ranges.
    front : (n, 2)            Mass and power. [kg], [W]
    obstacles : (m, 3)        Mass and power of all that is marked, and half the size of its marker. [kg], [W], [pt]
    """

    def placed(values: np.ndarray) -> np.ndarray:
        return ax.transData.transform(values * (1e3, 1.0)) * (72.0 / ax.figure.dpi)

    low, high = ax.transAxes.transform([(0.0, 0.0), (1.0, 1.0)]) * (72.0 / ax.figure.dpi)
    markers, half = placed(obstacles[:, :2]), obstacles[:, 2:]
    taken = np.concatenate([markers - half, markers + half], axis=1)
    found: dict[int, tuple[float, float]] = {}
    for number in _spread_out(np.unique(front, axis=0, return_index=True)[1].tolist()):  # equal designs have one name
        if len(found) == _NAMED:
            break
        size = np.array([_LETTER * len(f"front {number + 1}"), _LINE])
        for beside in _BESIDE:
            corner = placed(front[number : number + 1])[0] + beside
            ends = np.sort([corner, corner + np.sign(beside) * size], axis=0)
            inside = (ends[0] >= low).all() and (ends[1] <= high).all()
            free = (ends[0] >= taken[:, 2:]) | (ends[1] <= taken[:, :2])
            if inside and free.any(axis=1).all():
                found[number] = beside
                taken = np.concatenate([taken, ends.reshape(1, 4)])
                break
    return found


def _obstacles(groups: Mapping[str, Mapping[str, np.ndarray]]) -> np.ndarray:
    """Mass, power and half the marker of all that is drawn, each once. (n, 3)"""
    marked = [
        np.insert(values, 2, _DOT if kind == "cloud" else _MARKER, axis=1)
        for group in groups.values()
        for kind, values in group.items()
    ]
    every = np.concatenate([np.empty((0, 3)), *marked])
    return np.unique(every[np.isfinite(every).all(axis=1)], axis=0)


def _spread_out(values: list[int]) -> list[int]:
    """The same values: both ends first, then the middle, the quarters, and so on."""
    last, parts = len(values) - 1, 1
    order: list[int] = []
    while len({*order}) < len(values):
        order += [round(last * step / parts) for step in range(parts + 1)]
        parts *= 2
    return [values[place] for place in dict.fromkeys(order)]


def _wide(axis: XAxis | YAxis, values: np.ndarray) -> None:
    """Make an axis logarithmic where its values differ by much, with plain numbers."""
    known = values[np.isfinite(values) & (values > 0.0)]
    if known.size and known.max() > _FAR * known.min():
        from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

        {"x": axis.axes.set_xscale, "y": axis.axes.set_yscale}[axis.axis_name]("log")
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw_all(sizing: Sizing) -> Figure:
    """Draw the figure.

    Raises
    ------
    InputError
        If there is no feasible design.
    """
    if not sizing.designs:
        raise InputError("there is no feasible design to draw")
    with style.styled():
        made, axes = style.figure(7.2, 4.9, squeeze=False)
        draw(axes[0, 0], data(sizing))
    return made
