"""Numbers as a page shows them: rounded, with their units, and never nan in a header."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from infinivar.machines.pictures.words import quantity
from infinivar.units import plain

_UNITS = {
    "rad_s": ("rad/s", 1.0),
    "m_s": ("m/s", 1.0),
    "Nm": ("N m", 1.0),
    "rad": ("°", 180.0 / math.pi),
    "A": ("A", 1.0),
    "V": ("V", 1.0),
    "N": ("N", 1.0),
    "m": ("mm", 1e3),
}
"""Ends of the names of states: the unit shown, and the factor to it."""

_RPM = 30.0 / math.pi


def number(value: Any) -> float | None:
    """A finite number, or None, which JSON has a word for."""
    found = float(value)
    return found if math.isfinite(found) else None


def states(values: Mapping[str, Any]) -> Iterator[dict[str, str]]:
    """Yield each state of a point as a label and a text, from its name, which ends in its unit."""
    for name, value in values.items():
        if name == "steering_tangent":
            yield from steering(float(value))
            continue
        for end, (unit, factor) in _UNITS.items():
            if name.endswith(f"_{end}"):
                label = name.removesuffix(f"_{end}").replace("_", " ")
                if label == "motor speed":
                    yield row(label, quantity(_RPM * float(value), "rpm"))
                else:
                    yield row(label, quantity(factor * float(value), unit))
                break
        else:
            yield row(name.replace("_", " "), quantity(value, ""))


def steering(tangent: float) -> Iterator[dict[str, str]]:
    """Yield the steering angle, and the reduction ratio that it stands for."""
    yield row("steering angle", quantity(math.degrees(math.atan(tangent)), "°"))
    size = abs(tangent)
    ratio = "–" if math.isnan(size) else "locked" if size == 0.0 else f"{plain(1.0 / size, 3)}:1"
    yield row("reduction ratio", ratio)


def row(label: str, text: str) -> dict[str, str]:
    """One line of a table."""
    return {"label": label, "text": text}


def thin(values: Any, most: int) -> Any:
    """At most about `most` of the values, at equal steps, the first and the last among them."""
    values = np.asarray(values)
    if len(values) <= most:
        return values
    return values[np.unique(np.linspace(0, len(values) - 1, most).round().astype(int))]


def single(arrays: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The arrays as they are sent: whole numbers of one byte as they are, all others in single precision."""
    return {name: one if one.dtype == np.uint8 else np.asarray(one, dtype=np.float32) for name, one in arrays.items()}
