"""Frames of a machine in motion, drawn by MuJoCo without a display."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from infinivar._core import extras
from infinivar.errors import InputError
from infinivar.report.scene.elements import COLOURS
from infinivar.report.scene.export import VIEW, in_space, recorded

_WIDTH, _HEIGHT = 640, 480
"""Of a frame. [pixel]"""

_TRACE = 200
"""Most pieces of the handle's trace."""

_LONGEST = 0.3
"""Longest arrow of force, over the radius of the scene."""


def frames(run: Any, time: np.ndarray) -> Iterator[np.ndarray]:
    """Images (h, w, 3) of a session or run at times (t,), with the trace of the handle and the user's force.

    Raises
    ------
    InputError
        If MuJoCo is not installed, or cannot draw without a display.
    """
    mujoco = _mujoco()
    found = recorded(run, time)
    model = mujoco.MjModel.from_xml_string(found.scene)
    data = mujoco.MjData(model)
    renderer = _renderer(mujoco, model)
    handle = in_space(found.parts.handle)
    force = None if found.parts.force is None else in_space(found.parts.force)
    most = 0.0 if force is None else float(np.max(np.linalg.norm(force, axis=1)))
    thin = 0.004 * found.extent.radius
    try:
        for place in range(len(time)):
            data.qpos[:] = found.qpos[place]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera=VIEW)
            steps = handle[: place + 1 : max(len(time) // _TRACE, 1)]
            for one, other in itertools.pairwise(steps):
                _connect(mujoco, renderer.scene, mujoco.mjtGeom.mjGEOM_CAPSULE, one, other, thin, "handle")
            if force is not None and most > 0.0:
                tail = handle[place] - _LONGEST * found.extent.radius / most * force[place]
                _connect(mujoco, renderer.scene, mujoco.mjtGeom.mjGEOM_ARROW, tail, handle[place], 3.0 * thin, "force")
            yield renderer.render().copy()
    finally:
        renderer.close()


def _mujoco() -> Any:
    """MuJoCo; without a display it draws through EGL, unless the environment states another way."""
    headless = sys.platform == "linux" and not os.environ.get("DISPLAY") and not os.environ.get("WAYLAND_DISPLAY")
    if headless and "mujoco" not in sys.modules:
        os.environ.setdefault("MUJOCO_GL", "egl")
    return extras.load("mujoco", "robots", "a video by MuJoCo")


def _renderer(mujoco: Any, model: Any) -> Any:
    try:
        return mujoco.Renderer(model, _HEIGHT, _WIDTH)
    except Exception as problem:  # of EGL, OSMesa, GLFW or MuJoCo itself, each with types of its own
        way = os.environ.get("MUJOCO_GL") or "not set"
        raise InputError(
            f"MuJoCo cannot draw without a display here (MUJOCO_GL is {way}): set MUJOCO_GL to egl or osmesa before Python "
            "starts, and install that library; or write the video with renderer = 'drawing'"
        ) from problem


def _connect(mujoco: Any, scene: Any, kind: Any, start: np.ndarray, end: np.ndarray, width: float, colour: str) -> None:
    """Add a shape between two points to what is drawn."""
    if scene.ngeom >= scene.maxgeom or np.linalg.norm(end - start) <= 0.0:
        return
    geom = scene.geoms[scene.ngeom]
    rgba = np.array(COLOURS[colour], dtype=np.float32)
    mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), np.eye(3).ravel(), rgba)
    # Arrows are drawn half as long as requested.
    reached = start + 2.0 * (end - start) if kind == mujoco.mjtGeom.mjGEOM_ARROW else end
    mujoco.mjv_connector(geom, kind, width, start, reached)
    scene.ngeom += 1
