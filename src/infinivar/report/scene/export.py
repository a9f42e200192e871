"""Write the scene of a machine in motion for MuJoCo, with what guides its handle, and its recorded motion beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import SubElement

import numpy as np

from infinivar.analysis.moving_parts import Parts, parts_of
from infinivar.analysis.sessions.guides import Line, Plane, Rod, Round, Shape, Solid, Track, guides_of
from infinivar.errors import InputError, printable
from infinivar.report.output import all_files_or_none
from infinivar.report.scene.elements import Scene, text
from infinivar.report.scene.machines import Extent, add_machine

VIEW = "view"
"""Name of the camera."""

_FROM = np.array([0.35, -1.0, 0.75]) / np.linalg.norm([0.35, -1.0, 0.75])
"""Direction from the machine to the camera."""

_ANGLE = 40.0
"""Vertical field of view. [degrees]"""

_THIN, _HIGH = 0.004, 0.12
"""Radius of a line, and half the height of a wall of a handle in the plane, over the radius of the scene."""


class Recorded(NamedTuple):
    """A scene and its motion."""

    scene: str
    """MJCF."""
    qpos: np.ndarray
    """Positions of all joints. (t, q)"""
    parts: Parts
    extent: Extent


def recorded(run: Any, time: np.ndarray | None = None) -> Recorded:
    """Scene of a session or run, and its motion at times (t,), by default those of the results.

    Raises
    ------
    InputError
        If the machine has no handle.
    """
    parts = parts_of(run, time)
    scene = Scene.empty("".join(one if one.isalnum() else "_" for one in run.title) or "machine", len(parts.time))
    extent = add_machine(scene, run.machine, parts)
    handle = in_space(parts.handle)
    moved = float(np.linalg.norm(np.ptp(handle, axis=0)))
    _add_guides(scene, guides_of(run), handle[0], moved, extent)
    _add_camera(scene, extent)
    qpos = np.concatenate(scene.qpos, axis=1)
    frames = SubElement(scene.root, "keyframe")
    for name, place in (("start", 0), ("end", -1)):
        SubElement(frames, "key", name=name, time=text(parts.time[place]), qpos=text(qpos[place]))
    return Recorded(scene.written(), qpos, parts, extent)


def in_space(handle: np.ndarray) -> np.ndarray:
    """Positions or forces (t, d) in space; what a handle on fewer axes lacks is 0. (t, 3)"""
    return np.pad(handle[:, :3], ((0, 0), (0, max(3 - handle.shape[1], 0))))


def _add_camera(scene: Scene, extent: Extent) -> None:
    distance = 0.95 * extent.radius / np.sin(np.radians(0.5 * _ANGLE))
    right = np.cross([0.0, 0.0, 1.0], _FROM)
    right = right / np.linalg.norm(right)
    axes = [*right, *np.cross(_FROM, right)]
    at = extent.centre + distance * _FROM
    SubElement(scene.world, "camera", name=VIEW, pos=text(at), xyaxes=text(axes), fovy=text(_ANGLE))
    SubElement(scene.root, "statistic", center=text(extent.centre), extent=text(extent.radius))


def save(run: Any, path: Path) -> list[Path]:
    """Write scene and motion; see `infinivar.analysis.animated.Animated.to_mujoco`."""
    check_scene(path)
    found = recorded(run)
    motion = path.with_suffix(".npz")
    parts = found.parts
    force = np.zeros_like(parts.handle) if parts.force is None else parts.force
    with all_files_or_none(path, motion) as (scene, beside):
        scene.write_text(found.scene, "utf-8")
        np.savez_compressed(beside, time=parts.time, qpos=found.qpos, handle=parts.handle, force=force)
    return [path, motion]


def check_scene(path: Path) -> None:
    """Raise an error early if the file has another ending than that of a scene.

    Raises
    ------
    InputError
        With the required ending.
    """
    if path.suffix.lower() != ".xml":
        raise InputError(f"{printable(path)}: a scene must end in .xml")


def _add_guides(scene: Scene, shapes: Sequence[Shape], start: np.ndarray, moved: float, extent: Extent) -> None:
    """Add what guides a handle, as translucent shapes near it: walls, paths, fixtures.

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
