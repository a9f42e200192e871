"""Fields of motions and forces from files: how the file was read, and its columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.arrays import locked, real_array, shown
from infinivar.errors import ParameterError

FILE = "File of columns (CSV, text, OpenSim or Parquet) beside the study"
FORCE_FILE = "Second file, with the force or moment, where `file` has only the motion"
FORCE_COLUMNS = "As columns, of the second file"
FILE_KEYS = ("file", "force_file")
"""Keys of motions and forces that name a file."""

COLUMNS = "Heading of each column to read, by role; without it the headings decide"
FLIP = "Columns whose sign is reversed"
BODY_MASS = "Multiplies a force or a moment that the file states per kilogram"
CYCLE_TIME = "Time of one cycle, where the file has no times: only a phase, or equal steps from 0 to 100 %"
WINDOW = "Start and end of the part that is used, in the time of the file"


def how_read(meaning: Any) -> dict[str, Any]:
    """Options of a field that says how a file was read: it does not matter to what was read."""
    return {"meaning": meaning, "default": None, "compare": False, "repr": False}


def columns_of(instance: Any, *names: str) -> Mapping[str, np.ndarray]:
    """Return locked copies of the given columns.

    Raises
    ------
    ParameterError
        If values are not finite numbers, lengths differ, or times do not increase.
    """
    columns = {name: locked(real_array(name, getattr(instance, name))) for name in names}
    time = columns["time"]
    if time.ndim != 1 or len(time) < 2:
        raise ParameterError(f"time must be at least two numbers in a row, got {shown(instance.time)}")
    for name, values in columns.items():
        if values.shape != time.shape:
            raise ParameterError(f"{name} must have as many numbers as time, {len(time)}, got shape {values.shape}")
        if not np.all(np.isfinite(values)):
            raise ParameterError(f"{name} must be finite, got {values[~np.isfinite(values)][0]}")
    if not np.all(np.diff(time) > 0.0):
        row = int(np.flatnonzero(np.diff(time) <= 0.0)[0])
        raise ParameterError(f"time must increase from row to row, got {time[row]:g}, then {time[row + 1]:g}")
    return columns
