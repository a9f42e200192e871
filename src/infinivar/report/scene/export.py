"""Write the scene of a machine in motion for MuJoCo, and its recorded motion beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import SubElement

import numpy as np

from infinivar.analysis.moving_parts import Parts, parts_of
from infinivar.analysis.sessions.guides import guides_of
from infinivar.errors import InputError, printable
from infinivar.report.output import all_files_or_none
from infinivar.report.scene.elements import Scene, text
from infinivar.report.scene.machines import Extent, add_machine
from infinivar.report.scene.walls import add_guides

VIEW = "view"
"""Name of the camera."""

_FROM = np.array([0.35, -1.0, 0.75]) / np.linalg.norm([0.35, -1.0, 0.75])
"""Direction from the machine to the camera."""

_ANGLE = 40.0
"""Vertical field of view. [degrees]"""


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
    add_guides(scene, guides_of(run), handle[0], moved, extent)
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
        With the ending wanted.
    """
    if path.suffix.lower() != ".xml":
        raise InputError(f"{printable(path)}: a scene must end in .xml")
