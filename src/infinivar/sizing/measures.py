"""What designs are compared by: power, mass, space or price."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from infinivar._core.fields import given
from infinivar.units import show


class Measure(NamedTuple):
    """A figure of a design, of which an objective asks for the least."""

    name: str
    """Of the figure, as designs have it."""
    unit: str
    """In which it is shown."""
    words: str
    scale: float = 1.0
    """Of these units in one of SI."""

    def of(self, design: Any) -> float:
        """The figure of a design; nan if it is not known."""
        return given(getattr(design, self.name), math.nan)

    def said(self, design: Any) -> str:
        """The figure of a design with its name."""
        return f"{self.words} {self.shown(self.of(design))}"

    def shown(self, value: float) -> str:
        """A value with its unit."""
        return show(self.scale * value, self.unit, 4 if self.name == "price" else 3)


MEASURES: Mapping[str, Measure] = {
    "energy": Measure("power", "W", "mean power"),
    "mass": Measure("mass", "kg", "whole mass"),
    "space": Measure("volume", "l", "box around the drive", 1e3),
    "price": Measure("price", "1", "price of motors and gearheads"),
}
"""By objective."""


def price_of(drive: Any) -> float:
    """Sum of the prices of motors and gearhead, in the currency in which they are stated; nan if one is not stated."""
    return sum(given(getattr(one, "price", None), math.nan) for one in (*drive.motors.values(), drive.gearhead))
