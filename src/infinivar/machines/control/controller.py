"""What a controller of a machine in a session is: measurements in, commands out.

A controller is a function of `Measured` that returns `Commands`, or an object whose ``begin(plant)`` returns such a function.
The second form is for controllers with a memory: every session begins anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np

from infinivar.errors import ParameterError
from infinivar.machines.control.loops import Commands
from infinivar.machines.hand import Grip
from infinivar.machines.kind import MovingMachine
from infinivar.machines.system import Mechanics, System

__all__ = ["Commands", "Controller", "Law", "Measured", "Plant", "begun"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measured:
    """What a controller knows at a sample: readings of sensors, not the truth."""

    time: float
    """[s]"""
    configuration: np.ndarray
    """As in the machine's columns. (c,)"""
    rates: np.ndarray
    """Of the machine's coordinates. (N,)"""
    position: np.ndarray
    """Of the handle. (d,) [m]"""
    velocity: np.ndarray
    """Of the handle. (d,) [m s^-1]"""
    force: np.ndarray
    """Of the user on the handle. (d,) [N]"""
    steering: np.ndarray
    """Steering angles. (s,) [rad]"""
    steering_rate: np.ndarray
    """(s,) [rad s^-1]"""
    moment: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Of a user who turns the handle, about fixed axes or in the plane; of others empty. (k,) [N m]"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plant:
    """What a controller may know of its machine before a session."""

    machine: MovingMachine
    system: System
    grip: Grip
    period: float
    """Of the samples. [s]"""

    @property
    def mechanics(self) -> Mechanics:
        """Contacts and inertia."""
        return self.system.mechanics


class Unremembering:
    """A function whose results follow from its arguments alone: it can be recorded once for all samples."""

    __slots__ = ("function", "memory")

    def __init__(self, function: Callable[..., Any]) -> None:
        """Of a function."""
        self.function, self.memory = function, list[np.ndarray]()

    def __call__(self, *given: Any) -> Any:
        """What the function gives."""
        return self.function(*given)


Law = Callable[[Measured], Commands]
"""Called at each sample, in order; the first one is at the start."""


@runtime_checkable
class Controller(Protocol):
    """A controller with a memory."""

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        ...


def checked(commands: Any, angles: int, motors: int) -> Commands:
    """The commands of a controller.

    Raises
    ------
    ParameterError
        If they are none, or a number is missing or not finite.
    """
    if not isinstance(commands, Commands):
        raise ParameterError(f"controller must return Commands, got {commands!r}")
    for name, count in (("steering", angles), ("steering_rate", angles), ("currents", motors)):
        value = getattr(commands, name)
        if value is not None and not (np.shape(value) == (count,) and np.isfinite(value).all()):
            raise ParameterError(f"controller must command {name} by {count} finite numbers, got {value}")
    if commands.speed is not None and not math.isfinite(commands.speed):
        raise ParameterError(f"controller must command a finite speed, got {commands.speed}")
    return commands


def begun(controller: Any, plant: Plant) -> Law:
    """The law of a controller of either form; None commands nothing.

    Raises
    ------
    ParameterError
        If it is of neither.
    """
    if controller is None:
        return Unremembering(lambda measured: Commands())
    if isinstance(controller, Controller):
        return controller.begin(plant)
    if callable(controller):
        law: Any = controller
        return law
    raise ParameterError(
        f"controller must be a function of what is measured, or have begin(plant) that returns one, got {controller!r}"
    )
