"""The user at the handle of a machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from annotated_types import Interval

from infinivar._core.arrays import Whole
from infinivar._core.fields import check_real, component, given, quantity, tagged
from infinivar.errors import ParameterError, nearest
from infinivar.motion.motion import Force, Motion
from infinivar.motion.scenario import FORCES, MOTIONS
from infinivar.motion.vectors import COORDINATES, TRANSLATIONS

AXES = TRANSLATIONS
"""Directions of a handle for which a study states what a user does; about others of `COORDINATES` it turns."""

# Far beyond any arm, so that a slip of the unit is found.
_MASS, _DAMPING, _STIFFNESS = Interval(gt=0, le=1e3), Interval(ge=0, le=1e5), Interval(ge=0, le=1e6)
_INERTIA, _TURNING_DAMPING, _TURNING_STIFFNESS = Interval(gt=0, le=1e2), Interval(ge=0, le=1e4), Interval(ge=0, le=1e5)
_OWN, _TURNING = ("mass", "damping", "stiffness"), ("inertia", "turning_damping", "turning_stiffness")


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmModel:
    """Passive arm of a user along one axis: a mass at the handle, a damper and a spring to where the hand wants to be.

    With a moment of inertia it also turns the handle, against a damper and a spring that are the same about all axes; without one
    it grips a point.

    A user can stiffen the arm at will. What is found with one arm, such as a limit of stability, is therefore true for that arm
    only; name it and its source.

    Raises
    ------
    ParameterError
        If a field is outside its range, or a part of what turns is missing; the message names field, value and unit.
    """

    name: str = component("Whose arm, in which posture")
    mass: float = quantity("kg", _MASS, "Effective mass at the handle")
    damping: float = quantity("N s/m", _DAMPING, "Damping of arm and grip")
    stiffness: float = quantity("N/m", _STIFFNESS, "Stiffness of arm and grip")
    source: str = component("Where the values come from", default="assumed")
    inertia: float | None = quantity("kg m^2", _INERTIA, "Moment of inertia that turns with the handle", default=None)
    turning_damping: float | None = quantity(
        "N m s/rad", _TURNING_DAMPING, "Damping of turning of arm and grip", default=None
    )
    turning_stiffness: float | None = quantity(
        "N m/rad", _TURNING_STIFFNESS, "Stiffness of turning of arm and grip", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        for field in ("name", "source"):
            text = getattr(self, field)
            if not isinstance(text, str) or not text.strip():
                raise ParameterError(f"{field} must be a text that says what the arm is, got {text!r}")
        missing = [name for name in _TURNING if getattr(self, name) is None]
        if missing and len(missing) < len(_TURNING):
            raise ParameterError(f"{missing[0]} is missing: an arm that turns has {', '.join(_TURNING)}")

    @classmethod
    def named(cls, name: str) -> ArmModel:
        """An arm from the literature, by the key of its source; "vanbeek2015" so far.

        Raises
        ------
        ParameterError
            If there is none of this name; the message lists those known.
        """
        if not isinstance(name, str) or name not in ARMS:
            hint = nearest(name, ARMS) if isinstance(name, str) else ""
            raise ParameterError(f"arm must be one of {', '.join(ARMS)}, got {name!r}{hint}")
        return ARMS[name]


ARMS: Mapping[str, ArmModel] = {
    "vanbeek2015": ArmModel(
        name="one subject of vanbeek2015",
        mass=0.554,
        damping=6.45,
        stiffness=135.0,
        source="vanbeek2015, Fig 3: fit to one trial with a handle held by hand",
    ),
}
"""Arms with published values, by the key of their source."""


class AtHandle(Whole):
    """Base of users as studies state them: something along each of some axes, and about some."""

    __slots__ = ()

    def along(self) -> Mapping[str, Any]:
        """What is stated, by axis or rotation."""
        found = {axis: getattr(self, axis) for axis in COORDINATES}
        return {axis: one for axis, one in found.items() if one is not None}

    def beyond(self, axes: Sequence[str]) -> Iterator[str]:
        """Yield the axes and rotations that are stated and are none of these."""
        return (axis for axis in self.along() if axis not in axes)

    def turns(self) -> bool:
        """Whether it does something about an axis."""
        return any(axis not in AXES for axis in self.along())

    def _check(self, what: tuple[str, str], keys: tuple[str, str]) -> None:
        """`what` is along a line and about a joint, with the keys that state its size."""
        check_real(self)
        for axis, one in self.along().items():
            rotary = getattr(getattr(one, "axis", None), "rotary", None)  # of what is at rest None
            if rotary and axis in AXES:
                raise ParameterError(f"{axis} must be a {what[0]} along a line: state {keys[0]}, not about a joint")
            if rotary is False and axis not in AXES:
                raise ParameterError(f"{axis} must be a {what[1]} about an axis: state {keys[1]}, not along a line")


@dataclass(frozen=True, slots=True, kw_only=True)
class PushingUser(AtHandle):
    """Force and moment over time on the handle, whatever the handle does; a shape "file" is a recorded one.

    Raises
    ------
    ParameterError
        If a force is a moment or the reverse, or there is none.
    """

    word: ClassVar[str] = "force"
    x: Force | None = tagged("Force along x; default: none", FORCES, default=None)
    y: Force | None = tagged("Force along y; default: none", FORCES, default=None)
    z: Force | None = tagged("Force along z; default: none", FORCES, default=None)
    rx: Force | None = tagged("Moment about x; default: none", FORCES, default=None)
    ry: Force | None = tagged("Moment about y; default: none", FORCES, default=None)
    rz: Force | None = tagged("Moment about z; default: none", FORCES, default=None)
    angle: Force | None = tagged("Moment in the plane; default: none", FORCES, default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._check(("force", "moment"), ("size", "moment"))
        if not self.along():
            raise ParameterError(
                'x, y or z is missing: state a force, such as x = { shape = "constant", size = "5 N" }, or a moment as rx, '
                "ry, rz or angle"
            )

    def over_time(self, axes: Sequence[str]) -> Callable[[float], np.ndarray]:
        """Force at a time in the directions of a handle, or moment about its rotations. (d,) [N] or [N m]"""
        return _Push(tuple(self.along().get(axis) for axis in axes))


@dataclass(frozen=True, slots=True)
class _Push:
    """Forces at a time: equal if they are."""

    forces: tuple[Force | None, ...]

    def __call__(self, time: float) -> np.ndarray:
        return np.array([0.0 if one is None else one.value(time) for one in self.forces])


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachingUser(AtHandle):
    """Arm with a mass, a damper and a spring that pulls the handle along an intention; named, or by own values.

    With a moment of inertia and what resists turning it turns the handle as well, by angles from the start.

    Raises
    ------
    ParameterError
        If a value is outside its range or missing, or an arm is both named and given by values.
    """

    word: ClassVar[str] = "arm"
    arm: str | None = component("Arm from the literature by the key of its source: vanbeek2015", default=None)
    mass: float | None = quantity("kg", _MASS, "Effective mass at the handle, of an own arm", default=None)
    damping: float | None = quantity("N s/m", _DAMPING, "Damping of an own arm and grip", default=None)
    stiffness: float | None = quantity("N/m", _STIFFNESS, "Stiffness of an own arm and grip", default=None)
    inertia: float | None = quantity(
        "kg m^2", _INERTIA, "Moment of inertia of arm and hand, the same about all axes", default=None
    )
    turning_damping: float | None = quantity("N m s/rad", _TURNING_DAMPING, "Damping of its turning", default=None)
    turning_stiffness: float | None = quantity("N m/rad", _TURNING_STIFFNESS, "Stiffness of its turning", default=None)
    x: Motion | None = tagged("Where the hand wants to be along x, from the start", MOTIONS, default=None)
    y: Motion | None = tagged("Where the hand wants to be along y, from the start", MOTIONS, default=None)
    z: Motion | None = tagged("Where the hand wants to be along z, from the start", MOTIONS, default=None)
    rx: Motion | None = tagged("How the hand wants to be turned: x of a rotation vector", MOTIONS, default=None)
    ry: Motion | None = tagged("How the hand wants to be turned: y of that vector", MOTIONS, default=None)
    rz: Motion | None = tagged("How the hand wants to be turned: z of that vector", MOTIONS, default=None)
    angle: Motion | None = tagged("How the hand wants to be turned in the plane, from the start", MOTIONS, default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._check(("motion", "motion"), ("distance", "angle"))
        own = [name for name in _OWN if getattr(self, name) is not None]
        if self.arm is not None and own:
            raise ParameterError(f"{own[0]} does not apply beside arm, which names one with all its values; remove one")
        missing = [name for name in _OWN if name not in own]
        if self.arm is None and missing:
            raise ParameterError(
                f"{missing[0]} is missing: state mass, damping and stiffness, or an arm: {', '.join(ARMS)}"
            )
        turned, model = next((axis for axis in self.along() if axis not in AXES), None), self.model
        if turned and model.inertia is None:
            raise ParameterError(f"inertia is missing: an arm that turns by {turned} has {', '.join(_TURNING)}")

    @property
    def model(self) -> ArmModel:
        """The arm."""
        turning = {name: getattr(self, name) for name in _TURNING if getattr(self, name) is not None}
        if self.arm is not None:
            named = ArmModel.named(self.arm)
            return replace(named, source=f"{named.source}; turning: the study", **turning) if turning else named
        values = {name: float(given(getattr(self, name), 0.0)) for name in _OWN}
        return ArmModel(name="own values", source="the study", **values, **turning)

    def intention(self, axes: Sequence[str], home: np.ndarray) -> Callable[[float], np.ndarray]:
        """Where the hand wants to be at a time, (d,) [m], with the handle at `home` at the start."""
        wanted = self.turned(axes)
        return lambda time: home + wanted(time)

    def turned(self, axes: Sequence[str]) -> Callable[[float], np.ndarray]:
        """How far from the start it wants to be at a time in these directions or rotations. (d,) [m] or [rad]"""
        motions = [self.along().get(axis) for axis in axes]
        return lambda time: np.array([0.0 if one is None else one.at(time).position for one in motions])


USERS: dict[str, type] = {kind.word: kind for kind in (PushingUser, ReachingUser)}
"""Kinds of users by their name in `type`."""
