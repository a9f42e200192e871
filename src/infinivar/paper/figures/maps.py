"""Figures 15 to 17: operating ranges of the drives with their efficiencies, and their performance when shaking a mass."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.figures import operating_map, style
from infinivar.limits import words_of
from infinivar.paper.claims.claim import PaperMachine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COBOTIC, _CONVENTIONAL = style.COLOURS[0], style.COLOURS[1]
_LEVELS = {"cobotic": (0.1, 0.2, 0.4, 0.6, 0.7, 0.8, 0.85), "conventional": (0.05, 0.1, 0.15, 0.2, 0.25)}
_STROKES = (0.01, 0.1, 1.0, 10.0)
_STROKE_ROW = 0.88
"""Position along the power axis of the stroke labels."""
_REGIONS = {0: "neither works", 1: "only the\nconventional drive", 2: "only the\ncobotic drive", 3: "both work"}
_SIZE, _LETTER = 7, 0.56
"""Labels of limits: font size [pt], and mean letter width over font size."""
_WIDTH, _WIDE = 11.0, 0.9
"""Width of the figure [inch], and of a plot over its share of the figure."""
_ABOVE_BAR, _BETWEEN = 0.008, 0.015
"""Distances of labels from their bars, over plot height, and from each other, over plot width."""
_SHORTEST = 3
"""Fewest cells of a stretch that gets a label."""
_SHADES = ("#C9CDD3", "#F7E3D7", "#E6EEF6", "#FFFFFF")


def conventional(machine: PaperMachine) -> dict[str, Any]:
    """Map of the drive with the largest motor, and the margins of the others on the same axes.

    Source: faulring2006, Fig 15.
    """
    results = [result for result in machine.comparison.results.values() if isinstance(result.drive, ConventionalDrive)]
    torque = {
        result.name: result.drive.motor.continuous_torque
        for result in results
        if isinstance(result.drive, ConventionalDrive)
    }
    largest = max(results, key=lambda result: torque[result.name])
    return {
        "largest": operating_map.data(largest.map, machine.requirement),
        "title": largest.title,
        "others": {result.title: result.map.margin for result in results if result is not largest},
    }


def _draw_conventional(ax: Axes, numbers: Mapping[str, Any]) -> operating_map.Drawn:
    """Draw the map and the outlines; return what the colour bar needs."""
    largest = numbers["largest"]
    filled = operating_map.draw(ax, largest)
    colours = ("#CC79A7", "#E69F00", "#56B4E9")
    for colour, (title, margin) in zip(colours, numbers["others"].items(), strict=False):
        clipped = np.clip(margin, 0.0, 2.0)
        ax.contour(largest["force"], largest["speed"], clipped, levels=[1.0], colors=colour, linewidths=2.0)
        ax.plot([], [], color=colour, lw=2.0, label=title)
    ax.plot([], [], color="black", lw=1.4, label=numbers["title"] + " (with efficiency)")
    ax.plot([], [], **operating_map.REQUIRED, label="required region")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3)
    return filled


def draw_conventional(machine: PaperMachine) -> Figure:
    """Draw Figure 15."""
    with style.styled():
        made, ax = style.figure(7.2, 4.8)
        filled = _draw_conventional(ax, conventional(machine))
        operating_map.colour_bar(made, filled, ax)
    return made


def cobotic(machine: PaperMachine) -> dict[str, Any]:
    """Map of each cobotic drive, by title.

    Source: faulring2006, Fig 16.
    """
    requirement = machine.requirement
    return {
        result.title: operating_map.data(result.map, requirement)
        for result in machine.comparison.results.values()
        if isinstance(result.drive, CoboticDrive)
    }


def draw_cobotic(machine: PaperMachine) -> Figure:
    """Draw Figure 16."""
    numbers = cobotic(machine)
    with style.styled():
        made, axes = style.figure(4.4 * len(numbers) + 0.6, 3.8, 1, len(numbers), sharey=True, squeeze=False)
        filled: Any = None
        for ax, title in zip(axes.flat, numbers, strict=True):
            filled = operating_map.draw(ax, numbers[title], title)
            ax.label_outer()
        operating_map.colour_bar(made, filled, axes)
    return made


def dynamic_maps(machine: PaperMachine) -> dict[str, Any]:
    """Dynamic maps of the cobotic and the conventional drive, by reconstruction.

    Source: faulring2006, Fig 17.
    """
    rival = machine.shaken["motor2-gear4"]
    return {
        f"Reconstruction {letter}": {"cobotic": machine.shaken[name], "conventional": rival}
        for letter, name in (("A", "cobotic"), ("B", "cobotic-b"))
    }


def draw_dynamic(ax: Axes, numbers: Mapping[str, DynamicMap], title: str, width: float = _WIDTH / 2) -> None:
    """Draw the contours of both drives and the regions in which they work; `width` is the width in the figure [inch]."""
    ours, theirs = numbers["cobotic"], numbers["conventional"]
    frequency, percent = ours.frequency, 100.0 * ours.fraction
    ax.set_xscale("log")
    region = 2 * ours.works.T.astype(int) + theirs.works.T.astype(int)
    from matplotlib.colors import ListedColormap

    # Cell by cell: filled contours would also draw the regions between two numbers.
    ax.pcolormesh(
        frequency,
        percent,
        region,
        cmap=ListedColormap(_SHADES),
        vmin=-0.5,
        vmax=3.5,
        shading="nearest",
        rasterized=True,
    )
    _strokes(ax, ours)
    for steady, name, colour, dashes in (
        (ours, "cobotic", _COBOTIC, "solid"),
        (theirs, "conventional", _CONVENTIONAL, "dashed"),
    ):
        within = np.where(steady.works, steady.performance, np.nan).T
        lines = ax.contour(
            frequency, percent, within, levels=_LEVELS[name], colors=colour, linestyles=dashes, linewidths=1.1
        )
        ax.clabel(lines, fmt="%.2g", fontsize=7)
        ax.contour(frequency, percent, np.clip(steady.margin, 0, 2).T, levels=[1.0], colors=colour, linewidths=2.0)
    for number, words in _REGIONS.items():
        free = (region == number) & (np.abs(percent - 100.0 * _STROKE_ROW) > 9.0)[:, None]  # clear of the stroke labels
        _write(ax, free, frequency, percent, words, "#333333", weight="bold")
    # Limits are named apart from the regions, in a band above the upper edge with one row per drive.
    for steady, colour, height in ((ours, _COBOTIC, 1.085), (theirs, _CONVENTIONAL, 1.02)):
        _name_limits(ax, steady, colour, height, width)
    ax.set_xlim(frequency[0], frequency[-1])
    ax.set_ylim(0.0, 100.0)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("RMS power of the load, percent of maximum")
    ax.set_title(title, pad=38)
    from matplotlib.ticker import StrMethodFormatter

    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))


def _strokes(ax: Axes, steady: DynamicMap) -> None:
    """Draw lines of equal stroke, labelled where there are few contours."""
    stroke = 2.0 * steady.amplitude.T
    lines = ax.contour(
        steady.frequency,
        100.0 * steady.fraction,
        stroke,
        levels=_STROKES,
        colors="#777777",
        linestyles="dotted",
        linewidths=0.8,
    )
    row = int(_STROKE_ROW * steady.fraction.size)
    places = []
    for level in _STROKES:
        ratio = (stroke[row] / level) ** (2.0 / 3.0)  # the stroke varies as frequency to the power of -3/2
        where = steady.frequency * ratio
        inside = (where > steady.frequency[0] * 1.2) & (where < steady.frequency[-1] / 1.2)
        if inside.any():
            places.append((float(np.median(where)), float(100.0 * steady.fraction[row])))
    ax.clabel(lines, fmt=lambda value: f"{value:g} m", fontsize=7, manual=places)


def _write(
    ax: Axes, inside: np.ndarray, frequency: np.ndarray, percent: np.ndarray, words: str, colour: str, **font: Any
) -> None:
    """Write a label where a region is widest, if it fits."""
    from scipy.ndimage import distance_transform_edt

    cell = tuple(1.0 / (size * count) for size, count in zip((0.05, 0.10), inside.shape, strict=True))
    depth: Any = distance_transform_edt(np.pad(inside, 1), sampling=cell)
    depth = depth[1:-1, 1:-1]
    row, column = np.unravel_index(np.argmax(depth), depth.shape)
    if depth[row, column] >= 1.0:
        background = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
        ax.text(
            frequency[column],
            percent[row],
            words,
            ha="center",
            va="center",
            fontsize=8,
            color=colour,
            bbox=background,
            **font,
        )


def _stretches(steady: DynamicMap) -> list[tuple[float, float, str]]:
    """Frequency ranges [Hz] in which one limit is the tightest at full power, each with the name of the limit."""
    top = [steady.limit_at(row, -1) for row in range(steady.frequency.size)]
    found, start = [], 0
    for index in range(1, len(top) + 1):
        if index < len(top) and top[index] == top[start]:
            continue
        met = top[start]
        if met is not None and index - start >= _SHORTEST:
            found.append((float(steady.frequency[start]), float(steady.frequency[index - 1]), words_of(met)))
        start = index
    return found


def _name_limits(ax: Axes, steady: DynamicMap, colour: str, height: float, width: float) -> None:
    """Name the tightest limit at full power above the plot: a bar per frequency range, with a label above it."""
    low, high = np.log(steady.frequency[[0, -1]])
    points = _WIDE * 72.0 * width
    free = 1.0
    for left, right, words in reversed(_stretches(steady)):
        begin, end = ((np.log(edge) - low) / (high - low) for edge in (left, right))
        half = 0.5 * _LETTER * _SIZE * len(words) / points
        # Centred on its bar, if the label on its right and the edges of the plot leave room.
        middle = max(min(0.5 * (begin + end), free - half), half)
        if middle + half <= free + 1e-9:
            ax.text(
                middle,
                height + _ABOVE_BAR,
                words,
                transform=ax.transAxes,
                ha="center",
                va="bottom",
                fontsize=_SIZE,
                color=colour,
                gid="limit",
            )
            free = middle - half - _BETWEEN
        ax.plot(
            [begin, end], [height, height], transform=ax.transAxes, color=colour, lw=1.8, clip_on=False, gid="limit"
        )


def draw_all_dynamic(machine: PaperMachine) -> Figure:
    """Draw the figure."""
    numbers = dynamic_maps(machine)
    with style.styled():
        made, axes = style.figure(_WIDTH, 5.2, 1, len(numbers), sharey=True)
        for ax, (title, maps) in zip(axes, numbers.items(), strict=True):
            draw_dynamic(ax, maps, title, _WIDTH / len(numbers))
            ax.label_outer()
        from matplotlib.lines import Line2D

        handles = [
            Line2D([], [], color=_COBOTIC, label="performance of the cobotic drive (Motor 1)"),
            Line2D([], [], color=_CONVENTIONAL, ls="dashed", label="performance of the conventional drive (Motor 2)"),
            Line2D([], [], color="#555555", lw=2.0, label="limit of a drive (named above for full power)"),
            Line2D([], [], color="#777777", ls="dotted", lw=0.8, label="stroke"),
        ]
        made.legend(handles=handles, loc="outside lower center", ncols=4)
        first = next(iter(numbers.values()))["cobotic"]
        made.suptitle(f"Performance: {first.definition.words}", fontsize=8)
    return made
