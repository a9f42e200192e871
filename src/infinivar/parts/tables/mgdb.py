"""The MGDB format: motors, gearboxes and compatibility as CSV files in SI.

A file has one of three contents, known by its first line: motors, gearboxes, or compatibility, which has no headings: each line
names a motor and the gearboxes that fit it. A key that ends in * stands for all keys that begin so. What a data sheet does not
state is empty or NaN, and a limit that it does not state infinite.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from infinivar._core.array_namespace import Array
from infinivar.parts.tables.checked_rows import Collector
from infinivar.parts.tables.columns import UNLIMITED, number_columns
from infinivar.tables.named import NamedColumn

_MOTORS = {
    "V": "voltage",
    "k_t": "torque_constant",
    "R": "resistance",
    "L": "inductance",
    "mass": "mass",
    "inertia": "rotor_inertia",
    "omega_nl": "stated_no_load_speed",
    "I_nl": "no_load_current",
    "I_nom": "stated_continuous_current",
    "max_int_torque": "peak_torque",
    "max_int_speed": "max_speed",
    "max_cont_speed": "continuous_speed",
    "max_cont_power": "continuous_power",
    "coulomb_friction": "stated_friction_torque",
    "viscous_friction": "viscous_friction",
    "Rth1": "winding_to_housing",
    "Rth2": "housing_to_ambient",
}
_GEARBOXES = {
    "stages": "stages",
    "ratio": "ratio",
    "mass": "mass",
    "inertia": "inertia",
    "efficiency": "efficiency",
    "direction": "direction",
    "max_int_torque": "intermittent_torque",
    "max_cont_torque": "continuous_torque",
}
_TEXTS = {"key": "key", "manufacturer": "manufacturer", "ID": "order_number", "type": "type"}
_COLUMNS: Mapping[str, Mapping[str, str]] = {"motors": _MOTORS, "gearheads": _GEARBOXES}

_ZERO_IS_UNKNOWN = ("inertia", "rotor_inertia", "mass")
"""Columns that no part has at zero: the data sheet states none, or the value was rounded away."""


def shaft_torque(torque_constant: Array, current: Array, no_load_current: Array) -> Array:
    """Torque at the shaft at a current: that of the current less friction.

    Parameters
    ----------
    torque_constant : (...,) float   [N m A^-1]
    current : (...,) float           At the terminals. [A]
    no_load_current : (...,) float   Current that overcomes friction. [A]

    Returns
    -------
    (...,) float   [N m]

    Source: maxon2020.
    """
    return torque_constant * (current - no_load_current)


def kind_of(headings: Sequence[str]) -> str | None:
    """Kind of the parts of a file by its headings; None if the file is not in this format."""
    return next((kind for kind, known in _COLUMNS.items() if {*_TEXTS, *known} <= {*headings}), None)


def columns_of(kind: str, headings: Sequence[str]) -> dict[str, NamedColumn]:
    """Places of our columns in a file of a kind; all numbers are in SI."""
    measured = number_columns(kind)
    texts = {ours: NamedColumn(headings.index(theirs), "", 1.0) for theirs, ours in _TEXTS.items()}
    numbers = {
        ours: NamedColumn(headings.index(theirs), measured[ours].unit, 1.0) for theirs, ours in _COLUMNS[kind].items()
    }
    return texts | numbers


def completed(kind: str, row: dict[str, Any]) -> list[str]:
    """Complete a row of our columns by what the format means, and return remarks on what was read differently."""
    row["manufacturer"] = row.get("manufacturer", "").replace("_", " ")
    row["name"] = f"{row['manufacturer']} {row.get('order_number', '')}".strip()
    remarks = []
    for theirs, ours in _COLUMNS[kind].items():
        if row[ours] == 0.0 and ours in _ZERO_IS_UNKNOWN:
            row[ours] = math.nan
            remarks.append(f"{theirs} is 0, read as not stated")
        if row[ours] == math.inf and ours in UNLIMITED:
            remarks.append(f"{theirs} is infinite, read as not stated")
    if kind == "motors":
        row["continuous_torque"] = shaft_torque(
            row["torque_constant"], row["stated_continuous_current"], row["no_load_current"]
        )
        if not math.isnan(row["continuous_torque"]):
            row["derived"] = "continuous_torque"
            remarks.append("the continuous torque is derived: k_t (I_nom - I_nl)")
        if not math.isnan(row["winding_to_housing"]) and math.isnan(row["housing_to_ambient"]):
            row["winding_to_housing"] = math.nan
            remarks.append("Rth1 without Rth2 is a resistance from winding to ambient and was left out")
    return remarks


def read_compatibility(collector: Collector, lines: Sequence[tuple[int, list[str]]], file: str) -> None:
    """Take the lines of a file of compatibility, which has no headings."""
    for line, (motor, *others) in lines:
        gearheads = [key for key in others if key]
        if not motor:
            collector.refuse(file, line, "", "must begin with the key of a motor")
            continue
        collector.fit(file, line, motor, gearheads)
        if not gearheads:
            collector.remark(file, line, "no gearhead fits the motor")
