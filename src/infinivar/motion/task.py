"""What every task of a drive has: a title, and the load that is moved."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

from annotated_types import Ge

from infinivar._core.fields import component, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Base of `DutyCycle` and `Scenario`."""

    title: str = component("Name for reports", default="")
    load_mass: float | None = quantity(
        "kg",
        Ge(0),
        "Mass of the load; the requirement's if left out, none where walking, whose torque has it",
        default=None,
    )

    @property
    def moved_mass(self) -> float:
        """Mass of the load, 0 where there is none. [kg]"""
        return self.load_mass or 0.0

    def loaded(self, mass: float | None) -> Self:
        """The task with a load, unless it has one. [kg]"""
        return self if self.load_mass is not None or mass is None else dataclasses.replace(self, load_mass=mass)
