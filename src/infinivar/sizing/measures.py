"""What designs are compared by: power, mass, space or price."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from infinivar._core.fields import given
from infinivar.drivetrain.body import total
from infinivar.drivetrain.masses import bodies_of
from infinivar.drivetrain.service import Service
from infinivar.units import show


def mass_of(drive: Any, service: Service) -> float:
    """Mass of a whole drive; nan if that of a body is not known. [kg]"""
    return float(total(bodies_of(drive, service)))


def volume_of(drive: Any, service: Service) -> float:
    """Volume of the box around a drive; nan where no body is placed. [m^3]"""
    return float(drive.layout(service).space.volume)


def price_of(drive: Any, service: Service | None = None) -> float:
    """Sum of the prices of motors and gearhead, in the currency in which they are stated; nan if one is not stated."""
    return sum(given(getattr(one, "price", None), math.nan) for one in (*drive.motors.values(), drive.gearhead))


class Measure(NamedTuple):
    """A figure of a design, of which an objective asks for the least."""

    name: str
    """Of the figure, as designs have it."""
    unit: str
    """In which it is shown."""
    words: str
    built: Callable[[Any, Service], float] | None = None
    """The figure of a drive that has to do a service; None where only its motions tell."""
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
    "mass": Measure("mass", "kg", "whole mass", mass_of),
    "space": Measure("volume", "l", "box around the drive", volume_of, 1e3),
    "price": Measure("price", "1", "price of motors and gearheads", price_of),
}
"""By objective."""
