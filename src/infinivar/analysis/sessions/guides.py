"""Shapes of what guides a handle, for drawings and scenes: planes, balls, tubes, meshes, curves and lines."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from infinivar.analysis.sessions.session_result import Session
from infinivar.motion.virtual.fixtures import AboutAxis, AboutPoint, AlongLine, InPlane, OnCurve, OnSurface
from infinivar.motion.virtual.meshes import MeshFile, TriangleMesh
from infinivar.motion.virtual.rows import unit
from infinivar.motion.virtual.surfaces import Ball, FlatWalls, HalfSpace, Surfaces, Tube
from infinivar.motion.virtual.tasks import Fixture

_POINTS = 121
"""Of a curve."""


class Plane(NamedTuple):
    """A plane."""

    point: np.ndarray
    """(3,) [m]"""
    normal: np.ndarray
    """Unit vector, towards the free side. (3,)"""
    solid: bool
    """Whether one side is solid."""
    upright: bool
    """Whether it is a line or point of a handle on two axes or one."""


class Round(NamedTuple):
    """A ball, in the plane a disc."""

    centre: np.ndarray
    """(3,) [m]"""
    radius: float
    flat: bool
    """Whether it is a disc, which stands upright as a cylinder."""


class Rod(NamedTuple):
    """An endless cylinder."""

    point: np.ndarray
    axis: np.ndarray
    radius: float


class Solid(NamedTuple):
    """A triangle mesh."""

    vertices: np.ndarray
    faces: np.ndarray


class Track(NamedTuple):
    """A curve by points (n, 3), n >= 2. [m]"""

    points: np.ndarray


class Line(NamedTuple):
    """An endless line."""

    point: np.ndarray
    direction: np.ndarray


Shape = Plane | Round | Rod | Solid | Track | Line


def guides_of(run: Any) -> tuple[Shape, ...]:
    """Shapes of the wall, path and fixture of a session; none of a run without a user.

    Fixtures that slide without a surface or curve of their own pass through the handle at the start. Surfaces and curves of other
    types, and fixtures by rows, have no shape.
    """
    if not isinstance(run, Session):
        return ()
    found: list[Shape] = []
    if run.wall is not None:
        found += _surface(run.wall)
    if run.path is not None:
        found += _curve(run.path)
    if isinstance(run.task, Fixture):
        found += _fixture(run.task.allowed, _lifted(run.position[0]), len(run.axes) < 3)
    return tuple(found)


def _lifted(values: Any) -> np.ndarray:
    """A point or direction in space; coordinates that it lacks are 0."""
    given = np.asarray(values, dtype=float)
    return np.concatenate([given[:3], np.zeros(max(3 - len(given), 0))])


def _surface(surface: Any) -> list[Shape]:
    if isinstance(surface, HalfSpace):
        return [Plane(_lifted(surface.point), _lifted(surface.normal(surface.point)), True, surface.dimension < 3)]
    if isinstance(surface, Ball):
        return [Round(_lifted(surface.centre), float(surface.radius), surface.dimension == 2)]
    if isinstance(surface, Tube):
        return [Rod(_lifted(surface.point), unit("axis", surface.axis, 3), float(surface.radius))]
    if isinstance(surface, (MeshFile, TriangleMesh)):
        mesh = surface.mesh if isinstance(surface, MeshFile) else surface
        return [Solid(np.asarray(mesh.vertices), np.asarray(mesh.faces))]
    if isinstance(surface, FlatWalls):
        surface = surface.together
    if isinstance(surface, Surfaces):
        return [shape for one in surface.surfaces for shape in _surface(one)]
    return []


def _curve(curve: Any) -> list[Shape]:
    if not hasattr(curve, "length") or not hasattr(curve, "at"):
        return []
    points = np.asarray(curve.at(np.linspace(0.0, curve.length, _POINTS))[0])
    return [Track(np.concatenate([points, np.zeros((len(points), 3 - points.shape[1]))], axis=1))]


def _fixture(allowed: Any, start: np.ndarray, flat: bool) -> list[Shape]:
    if isinstance(allowed, InPlane):
        return [Plane(start, unit("normal", allowed.normal, 3), False, False)]
    if isinstance(allowed, AlongLine):
        way = _lifted(allowed.direction)
        return [Line(start, way / np.linalg.norm(way))]
    if isinstance(allowed, AboutAxis):
        return [Line(_lifted(allowed.point), unit("axis", allowed.axis, 3))]
    if isinstance(allowed, AboutPoint):
        centre = _lifted(allowed.point)
        radius = float(np.linalg.norm(start - centre))
        if flat and radius > 0.0:
            around = np.linspace(0.0, 2.0 * np.pi, _POINTS)
            return [Track(centre + radius * np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=-1))]
        return [Round(centre, radius, False)] if radius > 0.0 else []
    if isinstance(allowed, OnSurface):
        return _surface(allowed.surface)
    if isinstance(allowed, OnCurve):
        return _curve(allowed.curve)
    return []
