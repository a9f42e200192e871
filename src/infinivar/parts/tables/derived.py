"""Figures that follow from the columns of a table: the laws of the part, over all its rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar.parts.motor import Motor
from infinivar.parts.tables.columns import Column, number_columns
from infinivar.parts.tables.table import PartTable

_MOTORS = {
    "no_load_speed": ("rad/s", "Speed at the supply voltage without load"),
    "no_load_torque": ("N m", "Friction torque at the no-load speed"),
    "friction_torque": ("N m", "Friction torque independent of speed"),
    "continuous_current": ("A", "Current at the continuous torque"),
    "stall_current": ("A", "Current at the supply voltage at rest"),
    "stall_torque": ("N m", "Torque at the supply voltage at rest, less friction"),
    "peak_efficiency": ("1", "Peak efficiency at the supply voltage"),
}
_OF: Mapping[str, Mapping[str, tuple[str, str]]] = {"motors": _MOTORS, "gearheads": {}, "bearings": {}, "materials": {}}


class Rows:
    """The columns of a table under the names of the part's fields, so that the laws of the part apply to all rows at once."""

    def __init__(self, table: PartTable) -> None:
        """Take the table."""
        self._table = table

    def __getattr__(self, name: str) -> Any:
        """A column, or a figure that follows from the columns by a law of the motor.

        Viscous friction that is not stated is none.
        """
        columns: Mapping[str, np.ndarray] = self._table.columns
        if name == "viscous_friction" and name in columns:
            return np.nan_to_num(columns[name])
        if name in columns:
            return columns[name]
        if name in self._table.texts:
            return self._table.texts[name]
        law = getattr(Motor, name, None) if self._table.kind == "motors" else None
        if not isinstance(law, property) or law.fget is None:
            raise AttributeError(name)
        with np.errstate(all="ignore"):
            return law.fget(self)

    @property
    def stall_current(self) -> np.ndarray:
        """Current at the supply voltage at rest. [A]

        Source: data sheets, maxon2020.
        """
        return self.voltage / self.resistance

    @property
    def stall_torque(self) -> np.ndarray:
        """Torque at the supply voltage at rest, less friction. [N m]

        Source: data sheets, maxon2020.
        """
        return self.torque_constant * self.stall_current - self.friction_torque


def derived_columns(kind: str) -> dict[str, Column]:
    """Figures that can be derived for a kind of table; nan where a row lacks a value that they need."""
    voltage = number_columns("motors")["voltage"].bound
    return {
        name: Column(name=name, unit=unit, bound=voltage, meaning=f"{meaning}; derived")
        for name, (unit, meaning) in _OF[kind].items()
    }


def derived(table: PartTable, name: str) -> np.ndarray:
    """One of `derived_columns` for all rows, in SI."""
    return np.asarray(getattr(Rows(table), name), dtype=float)
