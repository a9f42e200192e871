"""Catalogue gears as points of efficiency over ratio."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from infinivar.figures import style
from infinivar.parts import catalogue

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKERS = {"planetary": "o", "spur": "s", "koaxdrive": "D", "harmonic": "^", "worm": "v"}
_FACES = {"high": (1.0, 26), "medium": (0.55, 22), "low": (0.0, 18)}  # opacity of the face, size

Gears = Mapping[str, list[tuple[float, float, str]]]


def gears() -> Gears:
    """Gears of known ratio by type, as (ratio, efficiency, confidence)."""
    found: dict[str, list[tuple[float, float, str]]] = {kind: [] for kind in _MARKERS}
    for gear in catalogue.data("gear_efficiencies")["gear"]:
        if "ratio" in gear:
            found[gear["type"]].append((gear["ratio"], gear["efficiency"], gear["confidence"]))
    return found


def draw(ax: Axes, known: Gears) -> None:
    """Draw the gears with their legend entries; the lower the confidence, the paler and smaller the marker."""
    from matplotlib.colors import to_rgba

    for colour, (kind, marker) in zip(style.COLOURS, _MARKERS.items(), strict=False):
        for ratio, efficiency, confidence in known[kind]:
            opacity, size = _FACES[confidence]
            ax.scatter(
                ratio, efficiency, s=size, marker=marker, facecolor=to_rgba(colour, opacity), edgecolor=colour, lw=0.9
            )
        ax.scatter([], [], s=26, marker=marker, color=colour, label=kind)
    for confidence, (opacity, size) in _FACES.items():
        face = to_rgba("#666666", opacity)
        ax.scatter([], [], s=size, marker="o", facecolor=face, edgecolor="#666666", label=f"{confidence} confidence")
