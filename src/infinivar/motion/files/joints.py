"""The motion of one joint of a simulated robot, from the arrays that its user recorded in MuJoCo, as a recording."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core import extras, files
from infinivar.errors import InputError, ParameterError, nearest, path_of, printable

_MOST_BYTES = 2_000_000_000
_ARRAYS = {"time": "time", "position": "qpos", "speed": "qvel", "acceleration": "qacc", "force": "qfrc_actuator"}
"""Names of the arrays by role, as in MuJoCo's own data."""
_STATE = "state"
"""Name of an array of whole states (mjSTATE_FULLPHYSICS), as `mujoco.rollout` returns them: time, positions, velocities ..."""
_HEADINGS = {
    False: {"time": "time [s]", "position": "position [m]", "speed": "speed [m/s]", "force": "force [N]"},
    True: {"time": "time [s]", "position": "angle [rad]", "speed": "speed [rad/s]", "force": "moment [N m]"},
}
"""Headings of the columns by role, of a slide and of a hinge."""


def joint_recording(
    trajectory: str | Path | Mapping[str, Any],
    model: Any,
    joint: str,
    out: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
) -> Path:
    """Write the motion of one joint of a trajectory in MuJoCo as a recording.

    The force that acts on the joint from outside is the reverse of what its actuators apply. It includes what accelerates the
    robot, so the duty cycle has no load mass of its own; what accelerates the armature of the joint is left out, as a drive adds
    its own inertia.

    Parameters
    ----------
    trajectory : str, Path or mapping   NPZ file or arrays: "time" (n,) [s], "qpos" (n, nq), and, if recorded, "qvel" (n, nv)
        and "qfrc_actuator" (n, nv); or "state" (n, ...), whole states in place of the first three. "qacc" (n, nv) is used for
        a joint with an armature; without it the slope of the speed is.
    model : str, Path or MjModel        MJCF, MJB, or a model: it states which numbers belong to the joint. One whose plugins
        are not loaded cannot be read from a file.
    joint : str                         Name of a slide or hinge.
    out : str or Path                   CSV file to write.
    columns : mapping                   Names of the arrays by role where they differ, such as ``{"force": "qfrc_inverse"}``;
        roles: "time", "position", "speed", "acceleration", "force".

    Returns
    -------
    Path   The file, in SI: ``Recording.read`` and a study read it.

    Raises
    ------
    InputError
        If MuJoCo is missing, a file cannot be read or written, or an array is missing or has the wrong shape.
    ParameterError
        If `columns` has an unknown role.

    Source: todorov2012.
    """
    names = {**_ARRAYS, **(columns or {})}
    unknown = next((role for role in names if role not in _ARRAYS), None)
    if unknown is not None:
        raise ParameterError(
            f"columns of a trajectory in MuJoCo are {', '.join(_ARRAYS)}, got {unknown!r}{nearest(unknown, _ARRAYS)}"
        )
    where = "trajectory" if isinstance(trajectory, Mapping) else printable(Path(trajectory))
    arrays = trajectory if isinstance(trajectory, Mapping) else _read(Path(trajectory))
    robot, rotary, places, armature = _joint(model, joint)
    given = _whole(arrays, robot, where) if _STATE in arrays and names["position"] not in arrays else dict(arrays)
    for role in ("time", "position", *(columns or {})):
        if names[role] not in given:
            raise InputError(
                f"{where}: has no array {names[role]!r}{nearest(names[role], list(given))}; arrays: "
                f"{', '.join(map(printable, arrays)) or 'none'}; state the {role}, such as columns {role}=NAME"
            )
    rows = len(np.atleast_1d(given[names["time"]]))
    if rows < 2:
        raise InputError(f"{where}: must have at least two rows, got {rows}")
    made = {
        role: _column(given[name], places.get(role), f"{where}: {name}", rows)
        for role, name in names.items()
        if name in given
    }
    acceleration = made.pop("acceleration", None)
    if "force" in made:
        if armature and acceleration is None:
            with np.errstate(all="ignore"):
                speed = made["speed"] if "speed" in made else np.gradient(made["position"], made["time"])
                acceleration = np.gradient(speed, made["time"])
        made["force"] = -made["force"] + (0.0 if acceleration is None else armature * acceleration)
    text, heads = io.StringIO(), ",".join(_HEADINGS[rotary][role] for role in made)
    np.savetxt(text, np.stack([*made.values()], axis=-1), fmt="%.12g", delimiter=",", header=heads, comments="")
    path = path_of(out, "out")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.getvalue(), "utf-8")
    except OSError as problem:
        raise InputError(f"{printable(path)}: cannot be written: {problem.strerror}") from problem
    return path


def _read(path: Path) -> dict[str, np.ndarray]:
    content = files.read(path, _MOST_BYTES)
    try:
        found = np.load(io.BytesIO(content), allow_pickle=False)
        return {name: found[name] for name in found.files}
    except (ValueError, OSError, EOFError, AttributeError, zipfile.BadZipFile) as problem:
        raise InputError(f"{printable(path)}: must be an NPZ file of numbers, as numpy.savez writes it") from problem


def _joint(model: Any, joint: str) -> tuple[Any, bool, dict[str, tuple[int, int]], float]:
    """Model, whether the joint turns, by role the place of its number and how many there are, and its armature."""
    mujoco = extras.load("mujoco", "robots", "a trajectory in MuJoCo")
    robot = model if isinstance(model, mujoco.MjModel) else _robot(mujoco, path_of(model, "model"))
    names = [robot.joint(place).name for place in range(robot.njnt)]
    if joint not in names:
        listed = ", ".join(printable(one) for one in names if one) or "none with a name"
        raise InputError(f"joint {joint!r} is not in the model{nearest(joint, names)}; joints: {listed}")
    place = names.index(joint)
    kind = mujoco.mjtJoint(int(robot.jnt_type[place]))
    if kind not in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE):
        word = kind.name.removeprefix("mjJNT_").lower()
        raise InputError(f"joint {joint!r} is a {word} joint of several coordinates; it must be a slide or a hinge")
    position, rate = int(robot.jnt_qposadr[place]), int(robot.jnt_dofadr[place])
    places = {
        "position": (position, int(robot.nq)),
        **dict.fromkeys(("speed", "acceleration", "force"), (rate, int(robot.nv))),
    }
    return robot, kind == mujoco.mjtJoint.mjJNT_HINGE, places, float(robot.dof_armature[rate])


def _robot(mujoco: Any, path: Path) -> Any:
    if not path.is_file():
        raise InputError(f"{printable(path)}: no such file; the model must be MJCF (.xml) or MJB (.mjb)")
    try:
        if path.suffix.lower() == ".mjb":
            return mujoco.MjModel.from_binary_path(str(path))
        return mujoco.MjModel.from_xml_path(str(path))
    except Exception as problem:  # of MuJoCo, with types of its own
        raise InputError(
            f"{printable(path)}: MuJoCo cannot read the model: {printable(str(problem).strip())}"
        ) from problem


def _whole(arrays: Mapping[str, Any], robot: Any, where: str) -> dict[str, Any]:
    """Arrays, with those within whole states."""
    states = np.asarray(arrays[_STATE])
    states = states[0] if states.ndim == 3 and len(states) == 1 else states
    ends = np.cumsum([1, robot.nq, robot.nv])
    if states.ndim != 2 or states.shape[1] < ends[-1]:
        raise InputError(
            f"{where}: {_STATE} must have rows of time, {robot.nq} positions and {robot.nv} velocities, as mjSTATE_FULLPHYSICS, "
            f"of one rollout; got the shape {states.shape}"
        )
    time, position, speed = np.split(states[:, : ends[-1]], ends[:-1], axis=1)
    return {**arrays, "time": time[:, 0], "qpos": position, "qvel": speed}


def _column(array: Any, place: tuple[int, int] | None, where: str, rows: int) -> np.ndarray:
    found = np.asarray(array)
    if place is not None and found.shape == (rows,) and place[1] == 1:
        found = found[:, None]
    shape = (rows,) if place is None else (rows, place[1])
    if found.dtype.kind not in "fiu" or found.shape != shape:
        raise InputError(f"{where} must be numbers of the shape {shape}, got {found.dtype} of the shape {found.shape}")
    column = found.astype(float) if place is None else found[:, place[0]].astype(float)
    bad = ~np.isfinite(column)
    if bad.any():
        raise InputError(f"{where} must be finite, got {column[bad][0]} in row {int(np.argmax(bad))}")
    return column
