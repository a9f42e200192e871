"""A recording: motion and force as recorded and smoothed, power, spectrum, force over position, and strides."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.motion_summary import MotionSummary
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BUCKETS = 700
"""Stretches of a long curve, each drawn by its lowest and highest value."""
_MOST_LOOP = 4000
_WIDTH = 10.6
"""Width of the figure. [inch]"""
_DECADES = 7.0
"""Decades of the amplitude shown below its peak."""
_BANDS_PER_DECADE = 60
_MOST_STRIDES = 60
"""Strides drawn one by one."""
_RAW, _SMOOTH = "#b8c0cc", style.COLOURS[0]


def data(found: MotionSummary) -> dict[str, Any]:
    """Curves of a recording in the units of the figure.

    Returns
    -------
    dict
        panels: title of axis to {"raw": (time, values), "smooth": (time, values)}; spectrum: (frequency [Hz], amplitude density),
        its cutoff [Hz], noise floor and unit; loop: position and force; strides: title of axis to (share [%], rows (k, n), mean,
        standard deviation).
    """
    axis = found.axis
    factor, unit = (180.0 / np.pi, "°") if axis.rotary else (1e3, "mm")
    values, start = found.table.values, float(found.table.values["time"][0])
    time = values["time"] - start
    panels: dict[str, dict[str, Any]] = {}
    shown = (
        ("position", axis.position, unit, factor, found.position),
        ("speed", axis.speed, axis.speed_unit, 1.0, found.speed),
        ("force", axis.force, axis.force_unit, 1.0, found.force),
    )
    for field, word, written, scale, smooth in shown:
        if smooth is not None:
            panels[f"{word}\n[{written}]"] = {
                **({"raw": _thinned(time, scale * values[field])} if field in values else {}),
                "smooth": _thinned(found.time, scale * smooth),
            }
    power = found.power
    if power is not None:
        panels["power to the\nload [W]"] = {"smooth": _thinned(found.time, power)}
    curves = {} if found.strides is None else found.strides.curves
    scales = {"position": (axis.position, unit, factor), "force": (axis.force, axis.force_unit, 1.0)}
    scales |= {} if "position" in curves else {"speed": (axis.speed, axis.speed_unit, 1.0)}
    loop = slice(None, None, max(1, len(found.time) // _MOST_LOOP))
    return {
        "one_cycle": found.one_cycle,
        "panels": panels,
        "spectrum": _spectrum(found, factor),
        "spectrum_unit": f"{unit}/√Hz",
        "cutoff": found.motion.cutoff,
        "floor": factor * np.sqrt(found.spectrum.floor),
        "loop": None if found.force is None else (factor * found.position[loop], found.force[loop]),
        "loop_words": (f"{axis.position} [{unit}]", f"{axis.force} on the load [{axis.force_unit}]"),
        "strides": {
            f"{word} [{written}]": (
                100.0 * found.strides.share,
                scale * curves[field],
                scale * found.strides.mean[field],
                scale * found.strides.spread[field],
            )
            for field, (word, written, scale) in scales.items()
            if found.strides is not None and field in curves
        },
    }


def _thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve reduced to the lowest and highest value of equal stretches, in order of time."""
    each = len(time) // _BUCKETS
    if each < 4:
        return time, values
    whole = values[: each * _BUCKETS].reshape(_BUCKETS, each)
    low, high = np.argmin(whole, axis=1), np.argmax(whole, axis=1)
    places = np.sort(np.stack([low, high], axis=1), axis=1) + each * np.arange(_BUCKETS)[:, None]
    rest = np.arange(each * _BUCKETS, len(time))
    kept = np.unique(np.concatenate([[0], places.ravel(), rest, [len(time) - 1]]))
    return time[kept], values[kept]


def _spectrum(found: MotionSummary, factor: float) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude density, averaged in bands of equal width on the logarithmic axis."""
    frequency, power = found.spectrum.frequency, found.spectrum.power
    decades = max(np.log10(frequency[-1] / frequency[0]), 0.1)
    edges = np.geomspace(frequency[0], frequency[-1] * (1.0 + 1e-12), int(_BANDS_PER_DECADE * decades) + 2)
    band = np.clip(np.searchsorted(edges, frequency, side="right") - 1, 0, len(edges) - 2)
    count = np.bincount(band, minlength=len(edges) - 1)
    full = count > 0
    mean = np.bincount(band, power, minlength=len(edges) - 1)[full] / count[full]
    middle = np.bincount(band, frequency, minlength=len(edges) - 1)[full] / count[full]
    return middle, factor * np.sqrt(mean)


def draw(ax: Axes, numbers: Mapping[str, Any], panel: str) -> None:
    """Draw one quantity over time."""
    curves = numbers["panels"][panel]
    if "raw" in curves:
        ax.plot(*curves["raw"], color=_RAW, lw=2.4, label="as recorded")
    ax.plot(*curves["smooth"], color=_SMOOTH, lw=0.9, label="smoothed")
    if panel.startswith("power"):
        ax.axhline(0.0, color="#777777", lw=0.7)
    ax.set_ylabel(panel)
    ax.margins(x=0.0, y=0.08)


def draw_spectrum(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the amplitude density of the position, with the cutoff."""
    from matplotlib.ticker import NullLocator

    frequency, amplitude = numbers["spectrum"]
    ax.set_title("spectrum as recorded")
    if not np.any(amplitude > 0.0):
        ax.text(0.5, 0.5, "no motion", transform=ax.transAxes, ha="center", va="center")
        ax.set(xticks=(), yticks=())
        return
    ax.loglog(frequency, amplitude, color=_SMOOTH, lw=1.0)
    if numbers["floor"] > 0.0:
        ax.axhline(numbers["floor"], color="#777777", lw=0.8, ls="dotted", label="noise floor")
    ax.axvline(numbers["cutoff"], color=style.COLOURS[1], lw=1.2, label=f"cutoff {numbers['cutoff']:g} Hz")
    ax.axvspan(0.5 * numbers["cutoff"], numbers["cutoff"], color=style.COLOURS[1], alpha=0.12, lw=0)
    ax.xaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_minor_locator(NullLocator())
    top = float(np.max(amplitude, initial=1e-300))
    ax.set_ylim(max(float(np.min(amplitude, initial=top)), top * 10.0**-_DECADES), 3.0 * top)
    ax.set(xlabel="frequency [Hz]", ylabel=f"amplitude density [{numbers['spectrum_unit']}]")
    ax.legend(loc="best", fontsize=7)


def draw_loop(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the force over the position; the enclosed area is the work."""
    ax.plot(*numbers["loop"], color=_SMOOTH, lw=0.8)
    ax.axhline(0.0, color="#777777", lw=0.7)
    ax.set(xlabel=numbers["loop_words"][0], ylabel=numbers["loop_words"][1])
    ax.set_title("force over position" if "position" in numbers["loop_words"][0] else "moment over angle")


def draw_strides(ax: Axes, numbers: Mapping[str, Any], panel: str) -> None:
    """Draw single strides over the share of the cycle, their mean and one standard deviation to either side."""
    share, rows, mean, spread = numbers["strides"][panel]
    every = max(1, -(-len(rows) // _MOST_STRIDES))
    thin = slice(None, None, max(1, len(share) // 400))
    for row in rows[::every]:
        ax.plot(share[thin], row[thin], color=_RAW, lw=0.6)
    ax.fill_between(share[thin], (mean - spread)[thin], (mean + spread)[thin], color=_SMOOTH, alpha=0.25, lw=0)
    ax.plot(share[thin], mean[thin], color=_SMOOTH, lw=1.5)
    ax.set(xlabel="share of the cycle [%]", ylabel=panel, xlim=(0.0, 100.0))


def draw_all(found: MotionSummary) -> Figure:
    """Draw the course over time on top; spectrum, loop and strides below."""
    numbers = data(found)
    panels, strides = list(numbers["panels"]), list(numbers["strides"])
    below = ["spectrum", *(["loop"] if numbers["loop"] is not None else []), *strides]
    columns = min(len(below), 4)
    with style.styled():
        above, height = 1.15 * len(panels), 1.15 * len(panels) + 3.75
        made, _ = style.figure(_WIDTH, height, 1, 1)
        made.clear()
        made.set_layout_engine("none")  # to fit axes to their labels takes as long as to draw them
        left, right = 0.75 / _WIDTH, 1.0 - 0.15 / _WIDTH
        upper = made.add_gridspec(
            len(panels),
            1,
            left=left,
            right=right,
            top=1.0 - 0.35 / height,
            bottom=1.0 - (0.35 + above) / height,
            hspace=0.16,
        )
        axes = [made.add_subplot(upper[0])]
        axes += [made.add_subplot(upper[row], sharex=axes[0]) for row in range(1, len(panels))]
        for ax, panel in zip(axes, panels, strict=True):
            draw(ax, numbers, panel)
            ax.tick_params(labelbottom=ax is axes[-1])
        axes[-1].set_xlabel("time in the cycle [s]" if numbers["one_cycle"] else "time in the recording [s]")
        for ax in axes:
            ax.yaxis.set_label_coords(-0.045, 0.5)
        lower = made.add_gridspec(
            1, columns, left=left, right=right, top=2.6 / height, bottom=0.5 / height, wspace=0.42
        )
        for place, name in enumerate(below):
            ax = made.add_subplot(lower[place])
            if name == "spectrum":
                draw_spectrum(ax, numbers)
            elif name == "loop":
                draw_loop(ax, numbers)
            else:
                draw_strides(ax, numbers, name)
                ax.set_title("strides, mean ± deviation")
        handles, names = axes[0].get_legend_handles_labels()
        made.legend(handles, names, loc="upper left", bbox_to_anchor=(left, 1.0), borderaxespad=0.0, ncols=2)
    return made
