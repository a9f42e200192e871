"""Linkage of slides: a handle on translational axes, each moved by a leg on a common cylinder or by a geared drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from annotated_types import Gt

from infinivar._core.fields import check, component, quantities
from infinivar._core.text import joined
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control import ConventionalControl
from infinivar.drivetrain.conventional import ALONG_A_LINE, ConventionalDrive
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.machines.bodies import Moved
from infinivar.machines.hand import Grip, PointGrip
from infinivar.machines.kind import MovingMachine
from infinivar.machines.kinds.linked import OnCylinder, OwnMotors, check_leg
from infinivar.machines.linkage import LeggedMechanics, LinkMotion, Load, SeparateMechanics
from infinivar.machines.motors import LinkMotors
from infinivar.machines.pictures.slides import Drum, Slides
from infinivar.motion.users import AXES


def axes_of(count: int) -> tuple[str, ...]:
    """Names of as many axes: x, y and z, or numbers if they are more."""
    return ("x", "y", "z")[:count] if count <= 3 else tuple(str(place + 1) for place in range(count))


@dataclass(frozen=True, slots=True, kw_only=True)
class SlideLoad(Load):
    """Masses on legs, one axis each: the linkage of a slide."""

    masses: np.ndarray
    """Moved along each axis, without its link. (n,) [kg]"""
    demands: tuple[tuple[Limit, str], ...] = ()

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes."""
        return axes_of(len(self.masses))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Speeds of the axes."""
        return tuple(f"slide_{axis}_m_s" for axis in self.axes)

    @property
    def configuration(self) -> tuple[str, ...]:
        """Positions on the axes."""
        return tuple(f"slide_{axis}_m" for axis in self.axes)

    def at(self, pose: np.ndarray, twist: np.ndarray) -> LinkMotion:
        """Kinematics and inertia."""
        count, rows = len(self.masses), len(pose)
        inertia = np.broadcast_to(np.diag(self.masses), (rows, count, count))
        jacobian = np.broadcast_to(np.eye(count), (rows, count, count))
        nothing = np.zeros((rows, 0))
        return LinkMotion(jacobian, twist, 0.0 * twist, twist, Moved(inertia, 0.0 * twist), nothing, pose)

    @property
    def links(self) -> int:
        """Number of links."""
        return len(self.masses)

    def grip(self, coordinates: int) -> Grip:
        """The axes."""
        return PointGrip(axes=self.axes, coordinates=coordinates)

    def outline(self, link_mass: float, drum: Drum | None) -> Slides:
        """The axes."""
        return Slides(masses=np.asarray(self.masses), link_mass=link_mass, drum=drum)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SlideMachine(OnCylinder):
    """A handle on translational axes, each moved by a leg on a common cylinder: a display of one to six axes.

    Raises
    ------
    ParameterError
        If a field is out of range, or the leg has springs or a linkage of its own.
    """

    leg: CoboticDrive = component("One of the legs, with its motor, cylinder, steering and control")
    masses: Sequence[float] = quantities("kg", Gt(0), "Mass moved along each axis, with the handle, without its link")

    ungraphed: ClassVar[str] = "machine must not be a SlideMachine; plant_graph has one of its axes"

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_leg(self.leg)
        require(len(self.masses) >= 1, "masses", "none", "one value for each axis", "kg")

    @property
    def home(self) -> np.ndarray:
        """Positions at the start."""
        return np.zeros(len(self.masses))

    def mechanics(self, stick_speed: float) -> LeggedMechanics:
        """Contacts and inertia."""
        return self.on_cylinder(SlideLoad(masses=np.array(self.masses)), len(self.masses), stick_speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GearedSlideMachine(OwnMotors):
    """A handle on translational axes, each moved by a conventional geared drive: a display of one to six axes.

    Raises
    ------
    ParameterError
        If a field is out of range, or the drive turns a shaft, is elastic, or has friction that depends on its load.
    """

    drive: ConventionalDrive = component("Drive of each axis, with its control")
    masses: Sequence[float] = quantities("kg", Gt(0), "Mass moved along each axis, with the handle")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if not isinstance(self.drive, ConventionalDrive):
            raise ParameterError(f"drive must be a ConventionalDrive, got a {type(self.drive).__name__}")
        if self.drive.own_axis.rotary:
            raise ParameterError(
                f"drive must have a {joined(ALONG_A_LINE, 'or')}: a shaft does not move the axis of a slide"
            )
        require(len(self.masses) >= 1, "masses", "none", "one value for each axis", "kg")
        _ = self.link_motors(1e-4)

    @property
    def control(self) -> ConventionalControl:
        """Settings of the controllers."""
        return self.drive.control

    @property
    def home(self) -> np.ndarray:
        """Positions at the start."""
        return np.zeros(len(self.masses))

    @property
    def links(self) -> int:
        """Number of axes."""
        return len(self.masses)

    def link_motors(self, stick_speed: float) -> LinkMotors:
        """Motors of the axes."""
        try:
            return LinkMotors(drive=self.drive, stick_speed=stick_speed)
        except ParameterError as problem:
            raise ParameterError(f"drive.{problem}") from None

    def mechanics(self, stick_speed: float) -> SeparateMechanics:
        """Inertia."""
        load, moved = SlideLoad(masses=np.array(self.masses)), self.link_motors(stick_speed).moved_mass
        return SeparateMechanics(load=load, count=self.links, link_mass=moved, stick_speed=stick_speed)

    @property
    def twisted(self) -> tuple[str, ...]:
        """All axes."""
        return AXES[: len(self.masses)]


def slide_of(drive: Any, masses: Sequence[float]) -> MovingMachine | None:
    """A handle of some masses on axes, each moved by a drive of one axis like this; None if it is of no such kind."""
    if isinstance(drive, CoboticDrive):
        return SlideMachine(leg=drive, masses=masses)
    return GearedSlideMachine(drive=drive, masses=masses) if isinstance(drive, ConventionalDrive) else None
