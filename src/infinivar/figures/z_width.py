"""Z-width: magnitudes of the softest and the stiffest impedance over frequency."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.displays.impedance_range import ZWidth
from infinivar.displays.kinds import TITLES
from infinivar.figures import style
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def data(found: ZWidth) -> dict[str, Any]:
    """Frequency [Hz], magnitudes of both impedances [N s/m], and the ideal mass and spring that they approach."""
    omega = 2.0 * np.pi * found.frequency
    mass = float(found.mass_felt[0])
    return {
        "frequency": found.frequency,
        "softest": np.abs(found.softest),
        "stiffest": np.abs(found.stiffest),
        "mass": omega * mass,
        "spring": found.wall / omega,
        "labels": (f"free motion, {plain(mass, 3)} kg", f"stiffest wall, {plain(found.wall / 1e3, 3)} N/mm"),
        "title": f"{TITLES[found.display]}, {found.held}",
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw both envelopes, with the mass and the spring that they would ideally be."""
    frequency, low, high = (numbers[name] for name in ("frequency", "softest", "stiffest"))
    ax.fill_between(frequency, low, high, where=high >= low, color="#dbeaf5", lw=0.0)
    ideal = {"color": "grey", "lw": 0.8, "ls": "--", "zorder": 1}
    ax.loglog(frequency, numbers["spring"], **ideal)
    ax.loglog(frequency, numbers["mass"], **ideal, label="ideal spring and mass")
    for values, label, colour in zip((high, low), numbers["labels"][::-1], style.COLOURS, strict=False):
        ax.loglog(frequency, values, color=colour, label=label)
    shown = np.concatenate([low, high])
    ax.set_xlim(frequency[0], frequency[-1])
    ax.set_ylim(0.5 * float(np.min(shown)), 2.0 * float(np.max(shown)))
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("impedance, magnitude [N s/m]")
    ax.legend(loc="upper center")


def draw_all(found: ZWidth) -> Figure:
    """Draw the figure."""
    with style.styled():
        made, ax = style.figure(5.0, 3.6)
        numbers = data(found)
        draw(ax, numbers)
        ax.set_title(numbers["title"])
    return made
