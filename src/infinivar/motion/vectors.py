"""Poses, twists and wrenches by coordinate, as study files state them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check_real, quantity

COORDINATES = ("x", "y", "z", "rx", "ry", "rz", "angle")
"""Coordinates of an end point: along and about fixed axes, and the angle of a body in the plane, of a joint or of a shaft."""

TRANSLATIONS = COORDINATES[:3]

ROTATIONS = COORDINATES[3:6]

ROTATING = COORDINATES[3:]


def _row(unit: str, turning: str, what: str) -> tuple[Any, ...]:
    along = [quantity(unit, FINITE, f"{what} along {axis}", default=None) for axis in "xyz"]
    about = [quantity(turning, FINITE, f"{what} about {axis}", default=None) for axis in "xyz"]
    return (*along, *about, quantity(turning, FINITE, f"{what} about the joint, or in the plane", default=None))


class Vector:
    """Base of values by coordinate; a coordinate that is not stated is None."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def stated(self) -> Mapping[str, float]:
        """The values that are stated, by coordinate; in SI."""
        found = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]
        return {name: value for name, value in found.items() if value is not None}

    def row(self, coordinates: Sequence[str], otherwise: Sequence[float] | None = None) -> np.ndarray:
        """Values at these coordinates, (d,); those not stated are 0, or as in another row."""
        usual = [0.0] * len(coordinates) if otherwise is None else otherwise
        return np.array([self.stated.get(name, usual[place]) for place, name in enumerate(coordinates)], dtype=float)

    def beyond(self, coordinates: Sequence[str]) -> Iterator[str]:
        """Yield the coordinates that are stated and are none of these."""
        return (name for name in self.stated if name not in coordinates)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose(Vector):
    """Position of an end point and its rotation vector (axis times angle); what is not stated is that of the machine at home."""

    x: float | None = _row("m", "rad", "Position")[0]
    y: float | None = _row("m", "rad", "Position")[1]
    z: float | None = _row("m", "rad", "Position")[2]
    rx: float | None = _row("m", "rad", "Rotation vector")[3]
    ry: float | None = _row("m", "rad", "Rotation vector")[4]
    rz: float | None = _row("m", "rad", "Rotation vector")[5]
    angle: float | None = _row("m", "rad", "Angle")[6]


@dataclass(frozen=True, slots=True, kw_only=True)
class Twist(Vector):
    """Velocity and angular velocity of an end point; what is not stated is 0."""

    x: float | None = _row("m/s", "rad/s", "Velocity")[0]
    y: float | None = _row("m/s", "rad/s", "Velocity")[1]
    z: float | None = _row("m/s", "rad/s", "Velocity")[2]
    rx: float | None = _row("m/s", "rad/s", "Angular velocity")[3]
    ry: float | None = _row("m/s", "rad/s", "Angular velocity")[4]
    rz: float | None = _row("m/s", "rad/s", "Angular velocity")[5]
    angle: float | None = _row("m/s", "rad/s", "Angular velocity")[6]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wrench(Vector):
    """Force and moment that a machine exerts on its load; what is not stated is 0."""

    x: float | None = _row("N", "N m", "Force")[0]
    y: float | None = _row("N", "N m", "Force")[1]
    z: float | None = _row("N", "N m", "Force")[2]
    rx: float | None = _row("N", "N m", "Moment")[3]
    ry: float | None = _row("N", "N m", "Moment")[4]
    rz: float | None = _row("N", "N m", "Moment")[5]
    angle: float | None = _row("N", "N m", "Moment")[6]


@dataclass(frozen=True, slots=True, kw_only=True)
class Point(Vector):
    """A point of a body, in its own axes; what is not stated is 0."""

    x: float | None = quantity("m", FINITE, "Position along x", default=None)
    y: float | None = quantity("m", FINITE, "Position along y", default=None)
    z: float | None = quantity("m", FINITE, "Position along z", default=None)
