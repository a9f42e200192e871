"""Tasks of a machine at a user's handle: what the handle is to be felt as.

A study states them as tables ``[tasks.NAME]`` with a key `type`, one of `TASKS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from annotated_types import Ge, Gt

from infinivar._core.arrays import Whole, shown
from infinivar._core.fields import check_real, component, quantity, tagged
from infinivar.errors import require
from infinivar.motion.virtual.curves import CURVES, Curve
from infinivar.motion.virtual.fixtures import FIXTURES, Allowed
from infinivar.motion.virtual.meshes import MeshFile
from infinivar.motion.virtual.surfaces import Ball, FlatWalls, HalfSpace, Surface, Tube, check_surface

SURFACES: dict[str, type] = {kind.shape: kind for kind in (HalfSpace, Ball, Tube, FlatWalls, MeshFile)}
"""Kinds of surfaces by their name in `shape`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HandleTask(Whole):
    """Base of the tasks at a handle."""

    title: str = component("Name for reports", default="")

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()

    def _validate(self) -> None:
        check_real(self)
        require(isinstance(self.title, str), "title", shown(self.title), "text")


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualPath(HandleTask):
    """The handle's end point is guided along a curve; along it, it moves freely.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    word: ClassVar[str] = "path"
    curve: Curve = tagged("Curve along which the handle is guided", CURVES)
    settling_length: float | None = quantity(
        "m", Gt(0), "Distance along the path over which an offset decays; None: the controller's choice", default=None
    )
    ends: Literal["stop", "free"] = component(
        "Whether a machine whose motors move the handle stops it at the ends of an open path", default="stop"
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()
        require(
            isinstance(self.curve, Curve), "curve", shown(self.curve), "a curve, such as a PointCurve or an ArcCurve"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualWall(HandleTask):
    """The handle's end point meets a wall: kept on its free side, or with two sides on the surface itself.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    word: ClassVar[str] = "wall"
    surface: Surface = tagged("Surface of the wall", SURFACES)
    sides: Literal["one", "two"] = component(
        "Whether the surface stops the handle on one side only, or holds it from both", default="one"
    )
    stiffness: float | None = quantity(
        "N/m", Gt(0), "Required stiffness; None: as stiff as the display can be", default=None
    )
    damping: float | None = quantity("N s/m", Ge(0), "Required damping; None: the controller's choice", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()
        check_surface("surface", self.surface)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fixture(HandleTask):
    """The handle keeps 1 to 5 free dimensions.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    word: ClassVar[str] = "fixture"
    allowed: Allowed = tagged("What is allowed to move", FIXTURES)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()
        words = "what is allowed to move, such as AlongLine, InPlane, AboutAxis or AboutPoint"
        require(
            hasattr(self.allowed, "rows"),
            "allowed",
            shown(self.allowed),
            f"{words}, or an own kind with rows(coordinates, position, twist)",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Caster(HandleTask):
    """The handle is free: it moves as a mass that the user wants to feel.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    word: ClassVar[str] = "caster"
    mass: float | None = quantity("kg", Gt(0), "Mass to be felt; None: that of the machine", default=None)
    inertia: float | None = quantity(
        "kg m^2",
        Gt(0),
        "Moment of inertia to be felt, the same about all axes; None: that of the machine",
        default=None,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Coasting(HandleTask):
    """The machine coasts: its power motors exert no torque, and the motion it has goes on.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    word: ClassVar[str] = "coast"


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldingTask(HandleTask):
    """The handle is held where it is.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    word: ClassVar[str] = "hold"
    stop_cylinder: bool = component("Whether a common cylinder stops while the handle is held", default=False)

    def __post_init__(self) -> None:
        """Validate the fields."""
        self._validate()
        require(isinstance(self.stop_cylinder, bool), "stop_cylinder", shown(self.stop_cylinder), "true or false")


TASKS: dict[str, type] = {
    kind.word: kind for kind in (VirtualPath, VirtualWall, Fixture, Caster, Coasting, HoldingTask)
}
"""Kinds of tasks by their name in `type`."""
