"""A session: where the handle went, the user's force, what the guidance left, and who gave energy and where it went."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.sessions.session_result import Session
from infinivar.figures import style
from infinivar.figures.energy_flow import largest, line_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAMED = 4
"""Most events with their name in the figure."""


def data(run: Session) -> dict[str, Any]:
    """Numbers of a session.

    Returns
    -------
    dict
        title; time (t,) [s]; position: by axis, from the start [mm]; force: by axis [N]; moment: by rotation, if the user acts
        about any [N m]; left: by name, offset from the path or distance beyond the wall [mm]; touches: start and end of each
        [s]; events: start, end [s] and limit; supplied and lost: by part [J], largest first.
    """
    left = {}
    if run.path is not None:
        left["offset from the path"] = 1e3 * run.path_offset
    if run.wall is not None:
        left["beyond the wall"] = 1e3 * run.penetration
    position = 1e3 * (run.position - run.position[0])
    return {
        "title": run.title,
        "time": run.time,
        "position": dict(zip(run.axes, position.T, strict=True)),
        "force": dict(zip(run.axes, run.force.T, strict=True)),
        "moment": dict(zip(run.turns, run.moment.T, strict=True)),
        "left": left,
        "touches": [(touch.start, touch.end) for touch in run.touches],
        "events": [(event.start, event.end, event.limit.words) for event in run.events],
        "supplied": {name: np.asarray(energy) for name, energy in run.supplied.items() if np.any(energy)},
        "lost": largest(run.lost),
    }


def draw(axes: Mapping[str, Axes], numbers: Mapping[str, Any]) -> None:
    """Draw into axes "position", "force", "supplied" and "lost"; "moment" of a user who turns; "left" of a path or wall."""
    labels = {
        "position": "handle [mm]",
        "force": "user's force [N]",
        "moment": "user's moment [N m]",
        "left": "error [mm]",
        "supplied": "energy\nsupplied [J]",
        "lost": "energy\nlost [J]",
    }
    for panel, ax in axes.items():
        style.curves(ax, numbers["time"], numbers[panel], labels[panel], line_colour)
    if "left" in axes:
        axes["left"].axhline(0.0, color="0.5", linestyle=":")
        for begin, end in numbers["touches"]:
            axes["left"].axvspan(begin, end, color="0.9")
    _name_events(axes["position"], numbers["events"])
    axes["lost"].set_xlabel("time [s]")
    axes["position"].set_title(numbers["title"])


def _name_events(ax: Axes, events: Any) -> None:
    """Shade the events, with the limit that is exceeded where it first begins."""
    low, high = ax.get_ylim()
    lines = min(len({name for *_, name in events}), _NAMED)
    ax.set_ylim(low, high + 0.16 * lines * (high - low))  # room above the curves
    named: set[str] = set()
    for begin, end, name in events:
        ax.axvspan(begin, max(end, begin), color="#F3D9CC", zorder=0)
        if name not in named and len(named) < _NAMED:
            ax.text(
                begin,
                0.99 - 0.12 * len(named),
                f" {name}",
                transform=ax.get_xaxis_transform(),
                fontsize=7,
                va="top",
                color="#B3400A",
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
            )
        named.add(name)


def draw_all(run: Session) -> Figure:
    """Draw the figure of a session."""
    numbers = data(run)
    panels = ["position", "force", *(one for one in ("moment", "left") if numbers[one]), "supplied", "lost"]
    with style.styled():
        made, axes = style.stack(panels, 7.4, 1.7 * len(panels))
        draw(axes, numbers)
    return made
