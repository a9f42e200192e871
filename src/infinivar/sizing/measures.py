"""What designs are compared by: power, mass, space or price."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from infinivar._core.fields import given
from infinivar.units import show, show_in


class Measure(NamedTuple):
    """A figure of a design, of which an objective asks for the least."""

    name: str
    """Of the figure, as designs have it."""
    unit: str
    """In SI."""
    words: str

    def of(self, design: Any) -> float:
        """The figure of a design; nan if it is not known."""
        return given(getattr(design, self.name), math.nan)

    def said(self, design: Any) -> str:
        """The figure of a design with its name."""
        return f"{self.words} {self.shown(self.of(design))}"

    def shown(self, value: float) -> str:
        """A value with its unit."""
        if self.name == "volume":
            return show_in(value, "m^3", "l", 3)
        return f"{value:.4g}" if self.name == "price" else show(value, self.unit, 3)


MEASURES: Mapping[str, Measure] = {
    "energy": Measure("power", "W", "mean power"),
    "mass": Measure("mass", "kg", "whole mass"),
    "space": Measure("volume", "m^3", "box around the drive"),
    "price": Measure("price", "1", "price of motors and gearheads"),
}
"""By objective."""


def price_of(drive: Any) -> float:
    """Sum of the prices of motors and gearhead, in the currency in which they are stated; nan if one is not stated."""
    return sum(given(getattr(one, "price", None), math.nan) for one in (*drive.motors.values(), drive.gearhead))
