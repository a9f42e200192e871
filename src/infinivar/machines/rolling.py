"""Wheels of a machine: losses and demands in motion, and where one stands on its creep law at a place."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.contact.creep import CreepLaw
from infinivar.limits import Limit
from infinivar.transmission.geometry import LossGroups, PressedContact


def slip_demands(count: int, what: str) -> tuple[tuple[Limit, str], ...]:
    """Slip of as many wheels."""
    return tuple((Limit.SLIP, f"{what} {place + 1}") for place in range(count))


ROLLING_LOSSES = ("creep", "slip", "spin", "rolling", "bearing")
"""Losses of wheels, as `judged` names them."""


def judged(
    by_wheel: dict[str, np.ndarray], slip_demand: np.ndarray
) -> tuple[Callable[[], dict[str, np.ndarray]], Callable[[], np.ndarray]]:
    """Functions for the losses of all wheels, and for their demands, as in `Forces`."""
    return functools.partial(contact_losses, by_wheel, slip_demand), lambda: slip_demand


def contact_losses(by_wheel: dict[str, np.ndarray], slip_demand: np.ndarray) -> dict[str, np.ndarray]:
    """Losses of all wheels, with the creep of those that slide as "slip". (m,) each [W]"""
    found = {name: loss.sum(axis=-1) for name, loss in by_wheel.items()}
    slides = slip_demand > 1.0
    found["slip"] = np.sum(np.where(slides, by_wheel["creep"], 0.0), axis=-1)
    found["creep"] = found["creep"] - found["slip"]
    return found


@dataclass(frozen=True)
class RollingState:
    """One wheel at one place: its law, and where it stands on it; nan where it slips."""

    name: str
    law: CreepLaw
    groups: LossGroups
    lateral_force: float
    creepage: float
    slip_demand: float
    contact: PressedContact | None
    preload: float
    notes: tuple[tuple[str, float | str], ...] = ()
    """What else is to be said, by name: texts, or angles. [rad]"""
    along: bool = False
    """Whether it creeps along its rolling direction, as a driven roller does, instead of across it."""

    @property
    def force_name(self) -> str:
        """What the force of the creep is called."""
        return "traction along rolling" if self.along else "lateral force"

    @property
    def slips(self) -> bool:
        """Whether no steady rolling is possible."""
        return not self.slip_demand <= 1.0


def creep_ratio(creep_speed: Any, rolling_speed: Any) -> float:
    """Creep speed over rolling speed; nan if the wheel does not roll."""
    rolled = abs(float(rolling_speed))
    return float(creep_speed) / rolled if rolled > 0.0 else math.nan
