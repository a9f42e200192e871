"""The page on a recording, with its figure and numbers as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from infinivar.analysis.motion_summary import MotionSummary, advice
from infinivar.figures import motion_summary as figure
from infinivar.figures import style
from infinivar.motion.files.table import ROLES
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json, write_csv
from infinivar.units import plain

_FIRST = 3
"""First values shown of each column."""

_ROUNDING = 1e-9
"""Share of the largest of values below which another is rounding; no recording resolves it."""


def save(found: MotionSummary, directory: Path) -> list[Path]:
    """Write the page, the figure, the numbers, and the mean cycle if there are strides; `motion.html` comes first."""
    with all_or_nothing(directory, "motion") as scratch:
        figures = style.write(figure.draw_all(found), scratch / "motion-figure", ("svg",))
        (scratch / "motion.html").write_text(html(found, style.inline_svg(figures)), "utf-8")
        (scratch / "motion.json").write_text(to_json(found.to_dict()), "utf-8")
        cycle = _mean_cycle(found)
        if cycle:
            write_csv(cycle, scratch / "mean-cycle.csv")
    names = ["motion.html", "motion.json", *(["mean-cycle.csv"] if cycle else []), *(file.name for file in figures)]
    return [directory / name for name in names]


def html(found: MotionSummary, image: str) -> str:
    """The page as one self-contained file."""
    return render(
        "motion.html",
        found=found,
        image=image,
        columns=rows(found),
        advice=advice(found),
        axis=found.axis,
        name=Path(found.table.file).name,
        drift=drift(found),
        extremes=_extremes(found),
        power=powers(found),
        work=shown(*found.work),
        work_per_stride=None if found.work_per_stride is None else shown(*found.work_per_stride),
    )


def shown(*values: float) -> tuple[float, ...]:
    """Values as they are shown: those that are rounding beside the largest as 0."""
    largest = max(map(abs, values))
    return tuple(0.0 if abs(value) < _ROUNDING * largest else value for value in values)


def powers(found: MotionSummary) -> tuple[float, ...] | None:
    """Lowest, mean and highest power of a drive to the load; None if it is unknown. [W]"""
    power = found.power
    return None if power is None else shown(float(np.min(power)), float(np.mean(power)), float(np.max(power)))


def drift(found: MotionSummary) -> float:
    """Position of the end relative to the start, 0 if it is rounding beside the range. [m, rad]"""
    return shown(found.drift, float(np.ptp(found.position)))[0]


def rows(found: MotionSummary) -> list[dict[str, Any]]:
    """What each column was understood as, with its first values: in SI units, a phase in percent."""
    listed = []
    for role, column in found.table.columns.items():
        unit, scale = ("%", 100.0) if role == "phase" else (ROLES[role], 1.0)
        first = ", ".join(plain(scale * float(value), 4) for value in column.values[:_FIRST])
        first += f", ... {unit}".rstrip()
        listed.append({"role": role.replace("_", " "), "heading": column.heading, "unit": column.unit, "first": first})
    return listed


def extremes(found: MotionSummary) -> dict[str, tuple[float, ...]]:
    """Lowest, highest and RMS of position (about its mean), speed, acceleration and force, by field."""
    return {name: (*shown(low, high), rms) for name, (low, high, rms) in found.extremes.items()}


def _extremes(found: MotionSummary) -> list[tuple[Any, ...]]:
    """Name, unit, lowest, highest and RMS of each smoothed quantity."""
    axis = found.axis
    words = {
        "position": (axis.position, axis.position_unit),
        "speed": (axis.speed, axis.speed_unit),
        "acceleration": ("angular acceleration" if axis.rotary else "acceleration", f"{axis.speed_unit}²"),
        "force": (f"{axis.force} on the load", axis.force_unit),
    }
    return [(*words[name], *values) for name, values in extremes(found).items()]


def _mean_cycle(found: MotionSummary) -> dict[str, np.ndarray]:
    """The mean of the strides as columns that a study can read."""
    if found.strides is None:
        return {}
    axis = found.axis
    units = {
        "time": ("time", "s"),
        "position": (axis.position, axis.position_unit),
        "speed": (axis.speed, axis.speed_unit),
        "force": (axis.force, axis.force_unit),
    }
    cycle, spread = found.strides.mean_cycle, found.strides.spread
    made = {f"{word} [{unit}]": cycle[name] for name, (word, unit) in units.items() if name in cycle}
    made |= {f"deviation of {units[name][0]} [{units[name][1]}]": values for name, values in spread.items()}
    return made
