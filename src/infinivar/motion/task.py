"""Fields shared by all tasks of a drive: a title and the mass of the load, or its inertia about a joint."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

from annotated_types import Ge

from infinivar._core.arrays import Whole
from infinivar._core.fields import component, given, quantity
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class Task(Whole):
    """Base of `DutyCycle` and `Scenario`."""

    title: str = component("Name for reports", default="")
    load_mass: float | None = quantity(
        "kg",
        Ge(0),
        "Mass of the load; defaults to the requirement's, but to none for walking and running, where the torque includes it",
        default=None,
    )

    load_inertia: float | None = quantity(
        "kg m^2",
        Ge(0),
        "Moment of inertia of the load about the joint; defaults as load_mass does along a line",
        default=None,
    )

    @property
    def axis(self) -> Axis:
        """Whether the load moves along a line or about a joint."""
        raise NotImplementedError

    @property
    def moved_mass(self) -> float:
        """Mass of the load, or its moment of inertia about the joint; 0 if none is set. [kg], [kg m^2]"""
        return given(self.load_mass, given(self.load_inertia, 0.0))

    def loaded(self, mass: float | None) -> Self:
        """Return the task with this load mass, or inertia about its joint, unless it has its own. [kg], [kg m^2]"""
        if mass is None or self.load_mass is not None or self.load_inertia is not None:
            return self
        return dataclasses.replace(self, **{"load_inertia" if self.axis.rotary else "load_mass": mass})

    def _common_axis(self, motion: Axis | None, *others: tuple[str, Axis]) -> Axis:
        """Axis of the task's motion, mass and other parts; None for a motion that is at rest about any.

        Raises
        ------
        ParameterError
            If they differ.
        """
        stated = [(name, axis) for name, axis in _MASSES if getattr(self, name) is not None] + list(others)
        first, axis = ("the motion", motion) if motion is not None else stated[0] if stated else ("", LINEAR)
        for name, other in stated:
            if other is not axis:
                way = {True: "about a joint", False: "along a line"}
                hint = f"; write {_COUNTERPARTS[name]}" if name in _COUNTERPARTS else ""
                raise ParameterError(f"{name} is {way[other.rotary]}, but {first} is {way[axis.rotary]}{hint}")
        return axis


def check_task(field: str, value: object, kind: type[Task], group: str, more: str = "") -> None:
    """Raise ParameterError unless a value is a task of this kind; the message says what to write in its place.

    Parameters
    ----------
    field : str   Name of the argument.
    value : object
    kind : type   `DutyCycle` or `Scenario`.
    group : str   Tasks of the kind in a study: "duty".
    more : str    What the kind needs besides a motion, as written: ", duration=...".
    """
    if isinstance(value, kind):
        return
    how, what = "", f"a {type(value).__name__}"
    if isinstance(value, str):
        how, what = f"; write study.{group}[{value!r}]", repr(value)
    elif hasattr(value, "motion") or callable(getattr(value, "at", None)):
        motion = f"{field}.motion" if hasattr(value, "motion") else f"{field}"
        how = f"; write iv.{kind.__name__}(motion={motion}{more})"
    raise ParameterError(f"{field} must be a {kind.__name__}, got {what}{how}")


_MASSES = (("load_mass", LINEAR), ("load_inertia", ROTARY))

_COUNTERPARTS = {"load_mass": "load_inertia", "load_inertia": "load_mass", "force": "moment", "moment": "force"}
"""The key to write instead for the other axis."""
