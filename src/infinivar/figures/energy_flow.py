"""Where the energy of a run came from and where it went: at its end, and as it grew."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.simulate import Simulation
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SMALL = 0.01
"""Entries below this share of all energy are gathered."""

_NOTHING = 1e-6
"""Entries below this share are what the balance cannot tell from nothing."""

_STORED, _OUT = "#BBBBBB", "#333333"


def data(simulation: Simulation) -> dict[str, Any]:
    """Energy that came in and that went out.

    Returns
    -------
    dict
        came, went: final energies by name [J], all positive, with equal sums to the residual; time [s]; grown: cumulative
        energies that went out by name, over time [J]; supplied: what came in, over time [J]; closure [-].
        What sources took back and what storages gave count on the other side.
    """
    run = simulation.trajectory
    came: dict[str, float] = {}
    went: dict[str, float] = {}
    for title, energy in run.supplied.items():
        last = float(energy[-1])
        name = {"supply": "motor supply", "load": "work of the surroundings"}.get(title, title)
        if last >= 0.0:
            came[name] = last
        else:
            went["work on the surroundings" if title == "load" else f"back to {name}"] = -last
    for title, energy in run.lost.items():
        went[title] = went.get(title, 0.0) + float(energy[-1])
    change = sum(float(energy[-1] - energy[0]) for energy in run.stored.values())
    if change >= 0.0:
        went["stored"] = change
    else:
        came["taken from storage"] = -change
    stored = np.sum([energy - energy[0] for energy in run.stored.values()], axis=0)
    return {
        "came": _gathered(came),
        "went": _gathered(went),
        "time": run.time,
        "grown": {
            name: run.lost[name]
            for name in _gathered({k: float(v[-1]) for k, v in run.lost.items()})
            if name in run.lost
        },
        "all_lost": np.sum(list(run.lost.values()), axis=0),
        "stored": stored,
        "supplied": np.sum(list(run.supplied.values()), axis=0),
        "closure": run.closure,
    }


def _gathered(energies: Mapping[str, float]) -> dict[str, float]:
    """The larger entries, and the rest as one."""
    total = sum(energies.values())
    energies = {name: value for name, value in energies.items() if value > _NOTHING * total}
    large = {name: value for name, value in energies.items() if value >= _SMALL * total}
    small = {name: value for name, value in energies.items() if value < _SMALL * total}
    rest = sum(small.values())
    ordered = dict(sorted(large.items(), key=lambda item: -item[1]))
    if len(small) == 1:
        return ordered | small
    return ordered | ({f"{len(small)} others": rest} if rest > 0.0 else {})


def _colour(name: str) -> str:
    return style.LOSS_COLOURS.get(name) or {"stored": _STORED, "taken from storage": _STORED}.get(name, "#4477AA")


def draw_balance(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Two stacked columns of one height: what came in, where it went."""
    for place, side in enumerate(("came", "went")):
        bottom, energies = 0.0, numbers[side]
        total = sum(energies.values()) or 1.0
        texts = []
        for name, value in energies.items():
            ax.bar(place, value, bottom=bottom, width=0.5, color=_colour(name), edgecolor="white", linewidth=0.5)
            texts.append((bottom + 0.5 * value, f"{name}  {value:.3g} J"))
            bottom += value
        for height, (middle, text) in zip(_apart([at for at, _ in texts], 0.055 * total, total), texts, strict=True):
            left = place == 0
            ax.annotate(
                text,
                (place - 0.26 if left else place + 0.26, middle),
                (place - 0.36 if left else place + 0.36, height),
                fontsize=8,
                va="center",
                ha="right" if left else "left",
                arrowprops={"arrowstyle": "-", "linewidth": 0.5, "color": "#777777", "shrinkA": 0, "shrinkB": 0},
            )
    ax.set_xlim(-1.7, 2.7)
    ax.set_xticks([0, 1], ["came in", "went out"])
    ax.tick_params(bottom=False)
    ax.spines[["left", "bottom"]].set_visible(False)
    ax.set_yticks([])
    ax.set_title(f"Energy of the run; balance closed to {numbers['closure']:.1g}", pad=14)


def _apart(places: list[float], least: float, total: float) -> list[float]:
    """The same heights, moved so that texts do not touch."""
    moved: list[float] = []
    for place in places:
        moved.append(max(place, moved[-1] + least) if moved else place)
    over = moved[-1] - total if moved else 0.0
    if over > 0.0:
        moved = [place - over for place in moved]
        for index in range(len(moved) - 2, -1, -1):
            moved[index] = min(moved[index], moved[index + 1] - least)
    return moved


def draw_growth(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Losses stacked over time, with the energy supplied and what is stored on top of the losses."""
    time, bottom = numbers["time"], np.zeros_like(numbers["time"])
    for name, energy in numbers["grown"].items():
        ax.fill_between(time, bottom, bottom + energy, color=_colour(name), label=name, linewidth=0)
        bottom = bottom + energy
    others = numbers["all_lost"] - bottom
    if np.max(others) > 1e-9 * max(np.max(bottom), 1e-300):
        ax.fill_between(time, bottom, numbers["all_lost"], color="#dddddd", label="other losses", linewidth=0)
    ax.plot(time, numbers["all_lost"] + numbers["stored"], color=_OUT, linewidth=1.0, label="lost and stored")
    ax.plot(time, numbers["supplied"], color="#EE7733", linewidth=1.6, linestyle=(0, (1, 1.5)), label="supplied")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("energy so far [J]")
    ax.margins(x=0.0)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def draw_all(simulation: Simulation) -> Figure:
    """The balance at the end, and how it came about."""
    numbers = data(simulation)
    with style.styled():
        made, axes = style.figure(11.5, 4.4, 1, 2, width_ratios=(1.25, 1))
        draw_balance(axes[0], numbers)
        draw_growth(axes[1], numbers)
    return made
