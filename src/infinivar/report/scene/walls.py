"""What guides a handle, as translucent shapes of a scene: walls, paths, fixtures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infinivar.analysis.sessions.guides import Line, Plane, Rod, Round, Shape, Solid, Track
from infinivar.report.scene.elements import Scene
from infinivar.report.scene.machines import Extent

_THIN, _HIGH = 0.004, 0.12
"""Radius of a line, and half the height of a wall of a handle in the plane, over the radius of the scene."""


def add_guides(scene: Scene, shapes: Sequence[Shape], start: np.ndarray, moved: float, extent: Extent) -> None:
    """Add shapes near the handle.

    Parameters
    ----------
    scene : Scene
    shapes : sequence of Shape
    start : (3,) float    The handle at the start. [m]
    moved : float         How far it moves. [m]
    extent : Extent       Of the machine.
    """
    half, thin = max(0.3 * extent.radius, 1.2 * moved), _THIN * extent.radius
    for place, shape in enumerate(shapes):
        if isinstance(shape, Plane):
            foot = start - float((start - shape.point) @ shape.normal) * shape.normal
            thick = 0.1 * half if shape.solid else 0.2 * thin
            at = foot - (thick if shape.solid else 0.0) * shape.normal
            up = np.array([0.0, 0.0, 1.0])
            turned = {"xyaxes": [*np.cross(up, shape.normal), *up]} if shape.upright else {"zaxis": shape.normal}
            tall = _HIGH * extent.radius if shape.upright else half
            scene.geom(scene.world, "box", "guide", pos=at, size=[half, tall, thick], **turned)
        elif isinstance(shape, Round) and shape.flat:
            size = [shape.radius, _HIGH * extent.radius]
            scene.geom(scene.world, "cylinder", "guide", pos=shape.centre, size=size)
        elif isinstance(shape, Round):
            scene.geom(scene.world, "sphere", "guide", pos=shape.centre, size=[shape.radius])
        elif isinstance(shape, Rod):
            foot = shape.point + float((start - shape.point) @ shape.axis) * shape.axis
            scene.geom(scene.world, "cylinder", "guide", pos=foot, size=[shape.radius, half], zaxis=shape.axis)
        elif isinstance(shape, Solid):
            scene.mesh(f"wall_{place + 1}", shape.vertices, shape.faces)
            scene.geom(scene.world, "mesh", "guide", mesh=f"wall_{place + 1}")
        elif isinstance(shape, Line):
            ends = [*(shape.point - half * shape.direction), *(shape.point + half * shape.direction)]
            scene.geom(scene.world, "capsule", "path", fromto=ends, size=[thin])
        else:
            assert isinstance(shape, Track)
            for one, other in zip(shape.points[:-1], shape.points[1:], strict=True):
                scene.geom(scene.world, "capsule", "path", fromto=[*one, *other], size=[thin])
