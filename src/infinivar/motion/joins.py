"""Where a closed recording joins its own start: steps of its force and speed, which smoothing blurs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.polynomial import polynomial

from infinivar.axis import Axis
from infinivar.units import percent, plain

_JUMP = 0.05
"""Step of a force or a recorded speed that is reported, as a share of its range."""
_OF_ROWS = 3.0
"""Least ratio of a reported step to the largest one between neighbouring rows."""

_KINK = 0.1
"""Step of the speed of a recorded position that is reported, as a share of the range of the speed."""
_SURE = 5.0
"""Least ratio of a reported step of the speed to its standard error."""
_WAVES = 0.5
"""Length of the fits that give the speed at the ends, in periods of the cutoff."""
_FEWEST = 8
_NEAREST = 4


def joins(
    file: str, time: np.ndarray, columns: Mapping[str, np.ndarray], speeds: float, cutoff: float, axis: Axis
) -> list[str]:
    """Warn of steps of force and speed from the end of a closed recording to its start.

    Parameters
    ----------
    file : str                  Name of the recording in messages.
    time : (n,) float           From 0. [s]
    columns : mapping           Position or speed, and force if recorded. (n,)
    speeds : float              Range of the smoothed speed. [m/s, rad/s]
    cutoff : float              [Hz]
    axis : Axis
    """
    found = []
    if "speed" in columns:
        found.append((axis.speed, axis.speed_unit, *_step(columns["speed"])))
    else:
        found.append((axis.speed, axis.speed_unit, *_kink(time, columns["position"], speeds, cutoff)))
    if "force" in columns:
        found.append((axis.force, axis.force_unit, *_step(columns["force"])))
    said = [
        f"the {word} jumps by {plain(abs(step), 3)} {unit}, {percent(share)} of its range"
        for word, unit, step, share in found
        if share
    ]
    if not said:
        return []
    return [
        f"{file}: from the end back to the start, {' and '.join(said)}: the end does not lead into the start, and smoothing "
        "blurs it; if the recording is not one whole cycle, cut it with window, average its strides, or set closed = false"
    ]


def _step(values: np.ndarray) -> tuple[float, float]:
    """Step from the last row to the first, and its share of the range; 0 if it is not to be reported."""
    step, span = float(values[0] - values[-1]), float(np.ptp(values))
    usual = float(np.max(np.abs(np.diff(values))))
    share = abs(step) / span if span else 0.0
    return step, share if share > _JUMP and abs(step) > _OF_ROWS * usual else 0.0


def _kink(time: np.ndarray, values: np.ndarray, speeds: float, cutoff: float) -> tuple[float, float]:
    """Step of the speed from the end to the start, and its share of the range; 0 if it is not to be reported."""
    last, last_error = _slope(float(time[-1]) - time[::-1], values[::-1], _WAVES / cutoff)
    first, first_error = _slope(time, values, _WAVES / cutoff)
    step = first + last  # the last is of the reversed time
    share = abs(step) / speeds if speeds else 0.0
    return step, share if share > _KINK and abs(step) > _SURE * np.hypot(first_error, last_error) else 0.0


def _slope(time: np.ndarray, values: np.ndarray, width: float) -> tuple[float, float]:
    """Slope at time 0 of a cubic through the rows within a width [s], and its standard error."""
    count = min(max(int(np.searchsorted(time, width, side="right")), _FEWEST), len(time))
    scale = float(time[count - 1])
    design = polynomial.polyvander(time[:count] / scale, 3)
    best, *_ = np.linalg.lstsq(design, values[:count], rcond=None)
    spread = float(np.sum((values[:count] - design @ best) ** 2)) / max(count - 4, 1)
    error = np.sqrt(spread * np.linalg.inv(design.T @ design)[1, 1])
    # Where rows are coarse, a cubic through several does not follow the motion: one through the nearest rows shows by how much.
    near, *_ = np.linalg.lstsq(design[:_NEAREST], values[:_NEAREST], rcond=None)
    error = np.hypot(error, (best[1] - near[1]) / _SURE)
    return float(best[1]) / scale, float(error) / scale
