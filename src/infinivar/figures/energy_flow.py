"""Energy balance of a run: at its end and over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.run import Run
from infinivar.figures import style
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SMALL = 0.01
"""Entries below this share of all energy are grouped."""

_NOTHING = 1e-6
"""Entries below this share are within the residual of the balance."""

SOURCES = {"supply": "motor supply", "load": "external work", "user": "work of the user"}
"""Longer names for sources whose titles in a graph are short."""

# What sources took back, in the colour of what they gave.
_BACK = {"work on the load": "external work", "work on the user": "work of the user"}


def line_colour(name: str, place: int) -> str:
    """Colour of the line of a loss or source, the same as its area in the balance; of others by their place."""
    known = style.LOSS_COLOURS | style.SOURCE_COLOURS
    return known.get(SOURCES.get(name, name)) or style.colour(place)


def largest(energies: Mapping[str, Any], most: int = 7) -> dict[str, np.ndarray]:
    """Energies (t,) by name, those with the largest at the end first; what is beyond the most as one."""
    order = sorted(energies, key=lambda name: -float(energies[name][-1]))
    found = {name: np.asarray(energies[name]) for name in order[:most]}
    if len(order) > most:
        found["other"] = np.sum([energies[name] for name in order[most:]], axis=0)
    return found


def balance(simulation: Run) -> tuple[dict[str, Any], dict[str, Any]]:
    """Cumulative energy supplied and removed, by name, over time.

    Returns
    -------
    came, went : dict of (n,) float   None negative; their sums agree to the residual. [J]
        What sources took back, and what storages gave, counts on the other side.
    """
    run = simulation.history
    came, went = {}, dict(run.lost)
    stored = np.sum([energy - energy[0] for energy in run.stored.values()], axis=0)
    went["stored"], came["released from storage"] = np.maximum(stored, 0.0), np.maximum(-stored, 0.0)
    for title, energy in run.supplied.items():
        name = SOURCES.get(title, title)
        came[name] = np.maximum(energy, 0.0)
        went[f"work on the {title}" if title in ("load", "user") else f"back to {name}"] = np.maximum(-energy, 0.0)
    return came, went


def data(simulation: Run) -> dict[str, Any]:
    """Energy supplied and removed, at the end and over time.

    Returns
    -------
    dict
        came, went: final energies by name [J], all positive, with equal sums to the residual; time [s]; grown: what went
        out so far, by name, over time [J]; supplied: what came from sources so far, over time [J]; closure [-].
        Energy returned to a source or released from storage counts on the opposite side. The smallest entries are
        grouped as "n others".
    """
    came, went = balance(simulation)
    final = [{name: energy[-1:] for name, energy in side.items()} for side in (came, went)]
    return {
        "came": {name: float(energy[0]) for name, energy in _gathered(final[0]).items()},
        "went": {name: float(energy[0]) for name, energy in _gathered(final[1]).items()},
        "time": simulation.history.time,
        "grown": _gathered(went),
        "supplied": sum(energy for name, energy in came.items() if name != "released from storage"),
        "closure": simulation.closure,
    }


def _gathered(energies: Mapping[str, Any]) -> dict[str, Any]:
    """Stacking order: losses by size, grouped small entries, then energy that is not lost."""
    sizes = {name: float(np.max(energy)) for name, energy in energies.items()}
    total = float(np.max(sum(energies.values())))
    names = sorted((name for name in energies if sizes[name] > _NOTHING * total), key=lambda name: -sizes[name])
    small = [name for name in names if sizes[name] < _SMALL * total]
    large = [name for name in names if name not in small or len(small) == 1]
    lost = {name: energies[name] for name in large if name in style.LOSS_COLOURS}
    others = {f"{len(small)} others": sum(energies[name] for name in small)} if len(small) > 1 else {}
    return lost | others | {name: energies[name] for name in large if name not in lost}


def _look(name: str) -> dict[str, Any]:
    """Fill of an area or a bar; stored energy is hatched, as it is not a loss."""
    if name in ("stored", "released from storage"):
        return {"facecolor": "white", "edgecolor": "#8A8A8A", "hatch": "/////", "linewidth": 0.5}
    source = _BACK.get(name, name.removeprefix("back to "))
    colour = style.LOSS_COLOURS.get(name) or style.SOURCE_COLOURS.get(source, "#DDDDDD")
    return {"facecolor": colour, "edgecolor": "white", "linewidth": 0.4}


def draw_balance(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw two stacked columns of equal height: energy supplied and energy removed."""
    for place, side in enumerate(("came", "went")):
        energies = numbers[side]
        tops = np.cumsum([0.0, *energies.values()])
        middles = 0.5 * (tops[:-1] + tops[1:])
        direction = 1.0 if side == "went" else -1.0
        for (name, value), bottom, middle, height in zip(
            energies.items(), tops[:-1], middles, _apart(middles, 0.058 * tops[-1], tops[-1]), strict=True
        ):
            ax.bar(place, value, bottom=bottom, width=0.5, **_look(name))
            ax.annotate(
                f"{name}  {plain(value, 3)} J",
                (place + 0.26 * direction, middle),
                (place + 0.4 * direction, height),
                fontsize=8,
                va="center",
                ha="left" if direction > 0 else "right",
                arrowprops={
                    "arrowstyle": "-",
                    "linewidth": 0.5,
                    "color": "#777777",
                    "shrinkA": 1,
                    "shrinkB": 0,
                    "relpos": (0.0 if direction > 0 else 1.0, 0.5),
                },
            )
    ax.set_xlim(-1.9, 2.9)
    ax.set_xticks([0, 1], ["supplied", "lost, stored or returned"])
    ax.tick_params(bottom=False)
    ax.spines[["left", "bottom"]].set_visible(False)
    ax.set_yticks([])
    ax.set_title(f"Energy balance, residual {plain(numbers['closure'], 1)}", pad=14)


def _apart(places: Any, least: float, total: float) -> list[float]:
    """Rising label heights, shifted just enough that labels neither touch nor extend above the columns."""
    moved = list(places)
    for index in range(1, len(moved)):
        moved[index] = max(moved[index], moved[index - 1] + least)
    ceiling = total
    for index in reversed(range(len(moved))):
        moved[index] = min(moved[index], ceiling)
        ceiling = moved[index] - least
    return moved


def draw_growth(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw cumulative energy removed, stacked, and energy supplied, which lies lower while storage releases energy."""
    time, bottom = numbers["time"], np.zeros_like(numbers["time"])
    for name, energy in numbers["grown"].items():
        look = _look(name)
        if "hatch" not in look:
            look["edgecolor"] = "none"  # an edge would hide thin areas
        ax.fill_between(time, bottom, bottom + energy, label=name, **look)
        bottom = bottom + energy
    ax.plot(time, numbers["supplied"], color="black", linewidth=1.2, label="supplied")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("cumulative energy [J]")
    ax.margins(x=0.0)
    handles, labels = ax.get_legend_handles_labels()
    # From top to bottom, as the areas lie.
    ax.legend(handles[::-1], labels[::-1], loc="upper left", bbox_to_anchor=(1.0, 1.0))


def draw_all(simulation: Run) -> Figure:
    """Draw the balance at the end and over time."""
    numbers = data(simulation)
    with style.styled():
        made, axes = style.figure(11.5, 4.4, 1, 2, width_ratios=(1.25, 1))
        draw_balance(axes[0], numbers)
        draw_growth(axes[1], numbers)
    return made
