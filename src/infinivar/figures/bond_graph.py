"""Drawing of a bond graph: half arrows, causal strokes, modulating signals, framed sub-graphs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from infinivar.bondgraph.causality import assign
from infinivar.bondgraph.graph import JUNCTIONS, TWO_PORTS, BondGraph, BondGraphError, Element
from infinivar.bondgraph.layout import layout
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BARB, _STROKE, _SIZE = 0.12, 0.16, 10.0
_SIGNAL = "#0072B2"
_FRAME = "#8a8a8a"

_FEW = 2
"""Most elements that one signal reaches by arrows of their own; more fan out from one point."""


def data(graph: BondGraph) -> dict[str, Any]:
    """Positions, labels and causality.

    Returns
    -------
    dict
        elements: name to place [inch], text and its half width [inch], symbol beside it; bonds: tail, head and the end with the
        causal stroke ("" where the graph is open and has none); signals: symbol, from ("" from outside), to; frames: box
        and title by prefix.
    """
    places = layout(graph)
    try:
        stroke = {(bond.tail, bond.head): end for bond, end in assign(graph).stroke.items()}
    except BondGraphError:  # the causality of a single plant may depend on its neighbours
        stroke = {}
    measured = {signal.name: signal for signal in graph.signals}
    return {
        "elements": {
            element.name: {
                "at": places.positions[element.name],
                "junction": element.kind in JUNCTIONS,
                "text": _text(element),
                "symbol": f"${element.symbol}$" if element.symbol and not _beside(element) else "",
                "half": 0.5 * _width(_text(element), _SIZE),
            }
            for element in graph.elements
        },
        "bonds": [(bond.tail, bond.head, stroke.get((bond.tail, bond.head), "")) for bond in graph.bonds],
        "signals": [
            (measured[name].symbol, measured[name].of, element.name)
            for element in graph.elements
            for name in element.signals
        ],
        "frames": {prefix: (box, graph.titles.get(prefix, prefix)) for prefix, box in places.frames.items()},
    }


def _beside(element: Element) -> bool:
    """Whether the symbol stands on the text line, as for one-ports."""
    return element.kind not in (*JUNCTIONS, *TWO_PORTS)


def _text(element: Element) -> str:
    kind = rf"\mathbf{{{element.label}}}"
    return f"${kind}:\\,{element.symbol}$" if _beside(element) and element.symbol else f"${kind}$"


def _width(text: str, size: float) -> float:
    """Printed width of a text. [inch]"""
    from matplotlib.textpath import TextPath

    with style.styled():
        return float(TextPath((0, 0), text, size=size).get_extents().width) / 72.0


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw into axes scaled in inches."""
    from matplotlib.patches import FancyBboxPatch

    elements = numbers["elements"]
    for (left, bottom, right, top), title in numbers["frames"].values():
        box = FancyBboxPatch(
            (left, bottom),
            right - left,
            top - bottom,
            boxstyle="round,pad=0,rounding_size=0.12",
            fill=False,
            edgecolor=_FRAME,
            linewidth=0.7,
        )
        ax.add_patch(box)
        ax.text(left + 0.1, top - 0.07, title, fontsize=7.5, color=_FRAME, va="top", style="italic")
    for tail, head, stroke in numbers["bonds"]:
        _bond(ax, elements, tail, head, stroke)
    _signals(ax, numbers)
    spread = Counter((symbol, source) for symbol, source, _ in numbers["signals"])
    from_above = {to for symbol, source, to in numbers["signals"] if source and spread[symbol, source] <= _FEW}
    for name, element in elements.items():
        x, y = element["at"]
        ax.text(x, y, element["text"], fontsize=_SIZE, ha="center", va="center_baseline")
        if element["symbol"] and element["junction"]:
            angle = _free_angle(name, numbers)
            across = math.cos(angle)
            side = "center" if abs(across) < 0.3 else "left" if across > 0 else "right"
            at = x + 0.19 * across, y + 0.2 * math.sin(angle)
            ax.text(*at, element["symbol"], fontsize=7.5, color="#444444", ha=side, va="center")
        elif element["symbol"]:
            side = -1 if y < 0 or name in from_above else 1  # outwards, off the signals between two rows
            ax.text(x, y + side * 0.21, element["symbol"], fontsize=8, ha="center", va="center")


def _free_angle(name: str, numbers: Mapping[str, Any]) -> float:
    """Direction with the most room for the symbol of a junction. [rad]"""
    elements = numbers["elements"]
    x, y = elements[name]["at"]
    others = [head if tail == name else tail for tail, head, _ in numbers["bonds"] if name in (tail, head)]
    taken = [math.atan2(elements[o]["at"][1] - y, elements[o]["at"][0] - x) for o in others]

    def room(angle: float) -> float:
        return min(abs(math.remainder(angle - other, 2.0 * math.pi)) for other in taken)

    # Upper right before the other diagonals where several are free.
    return max(
        (math.radians(degrees) for degrees in (50, -50, 130, -130, 0, 180, 90, -90)), key=lambda a: round(room(a), 2)
    )


def _bond(ax: Axes, elements: Mapping[str, Any], tail: str, head: str, stroke: str) -> None:
    """Line with a half arrow at its head and a causal stroke at the end that receives the effort."""
    (x0, y0), (x1, y1) = _ends(elements[tail], elements[head])
    ax.plot([x0, x1], [y0, y1], color="black", linewidth=1.0, solid_capstyle="butt")
    length = math.hypot(x1 - x0, y1 - y0)
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    # The barb is on the right of the power direction, turned back by 30 degrees.
    bx, by = -ux * 0.866 + uy * 0.5, -uy * 0.866 - ux * 0.5
    ax.plot([x1, x1 + _BARB * bx], [y1, y1 + _BARB * by], color="black", linewidth=1.0, solid_capstyle="round")
    if stroke:
        x, y = (x1, y1) if stroke == head else (x0, y0)
        half = 0.5 * _STROKE
        ax.plot([x - half * uy, x + half * uy], [y + half * ux, y - half * ux], color="black", linewidth=1.3)


def _ends(one: Mapping[str, Any], two: Mapping[str, Any]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ends of a line between two texts, clear of both."""
    (x0, y0), (x1, y1) = one["at"], two["at"]
    return _edge(one, x1 - x0, y1 - y0), _edge(two, x0 - x1, y0 - y1)


def _edge(element: Mapping[str, Any], dx: float, dy: float) -> tuple[float, float]:
    """Point at which a line in the given direction leaves the text of an element."""
    x, y = element["at"]
    if element.get("junction"):
        share = 0.19 / math.hypot(dx, dy)
        return x + share * dx, y + share * dy
    wide, high = element["half"] + 0.06, 0.14
    share = min(wide / abs(dx) if dx else math.inf, high / abs(dy) if dy else math.inf)
    return x + share * dx, y + share * dy


def _signals(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Dashed arrows from each measured variable to the elements that it modulates; arrows to several elements fan out."""
    elements = numbers["elements"]
    targets: dict[tuple[str, str], list[str]] = {}
    for symbol, source, target in numbers["signals"]:
        targets.setdefault((symbol, source), []).append(target)
    taken = dict.fromkeys(elements, 0)
    for (symbol, source), names in targets.items():
        if len(names) > _FEW:
            _spread(ax, elements, symbol, source, names)
            continue
        for name in names:
            _signal(ax, elements, symbol, source, name, taken[name])
            taken[name] += bool(source)


def _arrow(ax: Axes, points: list[tuple[float, float]], head: bool = True) -> None:
    across, up = zip(*points, strict=True)
    ax.plot(across, up, color=_SIGNAL, linewidth=0.8, linestyle=(0, (4, 2)))
    if head:
        (x0, y0), (x1, y1) = points[-2:]
        length = math.hypot(x1 - x0, y1 - y0) or 1.0
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        for side in (0.4, -0.4):
            ax.plot(
                [x1, x1 - 0.08 * (ux - side * uy)], [y1, y1 - 0.08 * (uy + side * ux)], color=_SIGNAL, linewidth=0.8
            )


def _spread(ax: Axes, elements: Mapping[str, Any], symbol: str, source: str, names: list[str]) -> None:
    places = [elements[name]["at"] for name in names]
    middle = sum(x for x, _ in places) / len(places), sum(y for _, y in places) / len(places)
    hub = {"at": middle, "half": 0.07}
    for name in names:
        _arrow(ax, list(_ends(hub, elements[name])))
    ax.text(*middle, f"${symbol}$", fontsize=8.5, color=_SIGNAL, ha="center", va="center")
    if source:
        x, y = elements[source]["at"]
        # Past the element above the hub, on its right.
        side = middle[0] + 0.5 * 0.9
        _arrow(
            ax, [(x + 0.1, y - 0.13), (side, y - 0.45), (side, middle[1]), (middle[0] + 0.12, middle[1])], head=False
        )


def _signal(ax: Axes, elements: Mapping[str, Any], symbol: str, source: str, name: str, before: int) -> None:
    """One signal; `before` others already enter the element from the same side."""
    target = elements[name]
    x1, y1 = target["at"]
    if not source:
        _arrow(ax, [(x1 - 0.05, y1 - 0.52), (x1 - 0.05, y1 - 0.15)])
        ax.text(x1 - 0.05, y1 - 0.54, f"${symbol}$", fontsize=8, color=_SIGNAL, ha="center", va="top")
        return
    x0, y0 = elements[source]["at"]
    if abs(x0 - x1) < 0.6 and abs(y0 - y1) > 0.9:  # one above the other: round what stands between
        side = min(x0, x1) - 0.52
        points = [(x0 - 0.12, y0), (side, y0), (side, y1), (x1 - target["half"] - 0.04, y1)]
        _arrow(ax, points)
        ax.text(side - 0.05, 0.5 * (y0 + y1), f"${symbol}$", fontsize=8, color=_SIGNAL, ha="right", va="center")
        return
    over = max(y0, y1) + 0.34 + 0.2 * before
    start, end = x0 - 0.1, x1 + 0.08 - 0.16 * before
    _arrow(ax, [(start, y0 + 0.13), (start, over), (end, over), (end, y1 + 0.15)])
    ax.text(0.5 * (start + end), over + 0.02, f"${symbol}$", fontsize=8, color=_SIGNAL, ha="center", va="bottom")


def draw_all(graph: BondGraph, title: str = "") -> Figure:
    """Draw the whole graph at its natural size."""
    numbers = data(graph)
    points = [element["at"] for element in numbers["elements"].values()]
    boxes = [box for box, _ in numbers["frames"].values()]
    left = min([x - 0.75 for x, _ in points] + [box[0] - 0.1 for box in boxes])
    right = max([x + 0.75 for x, _ in points] + [box[2] + 0.1 for box in boxes])
    outside = [numbers["elements"][target]["at"][1] - 0.75 for _, source, target in numbers["signals"] if not source]
    bottom = min([y - 0.4 for _, y in points] + [box[1] - 0.1 for box in boxes] + outside)
    top = max([y + 0.4 for _, y in points] + [box[3] + 0.1 for box in boxes]) + (0.3 if title else 0.0)
    with style.styled():
        from matplotlib.figure import Figure

        made = Figure(figsize=(right - left, top - bottom))
        ax = made.add_axes((0, 0, 1, 1))
        ax.set_axis_off()
        ax.set_xlim(left, right)
        ax.set_ylim(bottom, top)
        draw(ax, numbers)
        if title:
            ax.text(left + 0.1, top - 0.1, title, fontsize=10, va="top")
    return made
