"""Fields shared by all tasks of a drive: a title and the mass of the load."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

from annotated_types import Ge

from infinivar._core.arrays import Whole
from infinivar._core.fields import component, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Task(Whole):
    """Base of `DutyCycle` and `Scenario`."""

    title: str = component("Name for reports", default="")
    load_mass: float | None = quantity(
        "kg",
        Ge(0),
        "Mass of the load; defaults to the requirement's, but to none for walking, where the torque includes it",
        default=None,
    )

    @property
    def moved_mass(self) -> float:
        """Mass of the load; 0 if none is set. [kg]"""
        return self.load_mass or 0.0

    def loaded(self, mass: float | None) -> Self:
        """Return the task with this load mass, unless it has its own. [kg]"""
        return self if self.load_mass is not None or mass is None else dataclasses.replace(self, load_mass=mass)
