"""Arms of turning joints from an MJCF file, the format of MuJoCo, with their masses.

Source: todorov2012; the XML reference of MuJoCo.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core import extras
from infinivar._core.text import joined
from infinivar.errors import InputError, nearest
from infinivar.transmission.robot_model import RobotModel, moving_joints
from infinivar.transmission.turning_chain import TurningChain
from infinivar.transmission.urdf import Joint, text_of

SUFFIXES = (".xml", ".mjcf")
"""Endings of the names of such files."""

_KINDS = ("free", "ball", "prismatic", "revolute")
"""Of joints, by MuJoCo's number."""


def read_mjcf_arm(path: str | Path, tool: str = "", joints: Sequence[str] | None = None) -> RobotModel:
    """Read the joints between world and tool of an MJCF file, with masses; all other joints, also of other branches, stay at 0.

    Parameters
    ----------
    path : str or Path       The file, with what it includes: MuJoCo compiles it, so meshes that it names must be there.
    tool : str               Body whose frame is the end point, or site; by default the body at the end of the tree.
    joints : names or None   Joints that move; None: all that can between world and tool.

    Raises
    ------
    InputError
        If mujoco is not installed, the file is missing or no MJCF, or a joint that moves does not turn, follows another, or has
        a reference angle.

    Notes
    -----
    Armature, damping, friction loss and actuators of joints are not read: those of the study count.

    Source: todorov2012, for the reading; the XML reference of MuJoCo.
    """
    text_of(path)  # a message of ours for what is no file, or no text
    mujoco: Any = extras.load("mujoco", "robots", "a robot from MJCF")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as problem:
        raise InputError(f"MJCF is not valid: {' '.join(str(problem).split())}") from None
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = [_name(model.body(place), "body") for place in range(model.nbody)]
    body, turn, place, tool = _end(model, data, names, tool)
    every = [_joint(model, one, names) for one in range(model.njnt)]
    along = [one for one in _above(model, body) if model.body_jntnum[one]]
    numbers = [model.body_jntadr[one] + count for one in along for count in range(model.body_jntnum[one])]
    moving = moving_joints([every[one] for one in numbers], every, tool, joints)
    chosen = [one for one in numbers if every[one] in moving]
    for one in chosen:
        if model.qpos0[model.jnt_qposadr[one]] != 0.0:
            raise InputError(f"ref of joint {every[one].name!r} must be 0, got {model.qpos0[model.jnt_qposadr[one]]:g}")
    carriers = [int(model.jnt_bodyid[one]) for one in chosen]
    turns = [data.xmat[one].reshape(3, 3) for one in carriers]
    anchors = [data.xanchor[one] for one in chosen]
    before = [np.eye(3), *turns[:-1]], [np.zeros(3), *anchors[:-1]]
    chain = TurningChain(
        names=tuple(every[one].name for one in chosen),
        turns=np.array([first.T @ own for first, own in zip(before[0], turns, strict=True)]),
        places=np.array([first.T @ (own - at) for first, own, at in zip(before[0], anchors, before[1], strict=True)]),
        axes=np.array([own.T @ data.xaxis[one] for own, one in zip(turns, chosen, strict=True)]),
        tool_turn=turns[-1].T @ turn,
        tool_place=turns[-1].T @ (place - anchors[-1]),
        ranges=tuple(every[one].range for one in chosen),
    )
    carried = [[one for one in range(1, model.nbody) if _carrier(model, one, carriers) == last] for last in carriers]
    last = {
        carrier: count for count, carrier in enumerate(carriers)
    }  # of several joints of one body the last one carries it
    bodies = [
        _lumped(model, data, carried[count] if last[carrier] == count else [], turns[count], anchors[count])
        for count, carrier in enumerate(carriers)
    ]
    massless = tuple(names[one] for one in along if one in carriers and not model.body_mass[one])
    return RobotModel(chain, bodies, massless)


def _name(of: Any, what: str) -> str:
    return of.name or f"{what} {of.id}"


def _end(model: Any, data: Any, names: Sequence[str], tool: str) -> tuple[int, np.ndarray, np.ndarray, str]:
    """Body, axes, place and name of the tool."""
    if not tool:
        parents = set(model.body_parentid.tolist())
        ends = [place for place in range(1, model.nbody) if place not in parents]
        if len(ends) != 1:
            said = joined([names[one] for one in ends[:6]], "or")
            raise InputError(f"tool is missing: must be one of the bodies or sites, such as {said}")
        tool = names[ends[0]]
    if tool in names:
        body = names.index(tool)
        return body, data.xmat[body].reshape(3, 3).copy(), data.xpos[body].copy(), tool
    sites = [_name(model.site(place), "site") for place in range(model.nsite)]
    if tool not in sites:
        known = [*names[1:], *sites]
        raise InputError(
            f"tool has an unknown body or site {tool!r}{nearest(tool, known)}; there are {', '.join(known)}"
        )
    site = sites.index(tool)
    return int(model.site_bodyid[site]), data.site_xmat[site].reshape(3, 3).copy(), data.site_xpos[site].copy(), tool


def _above(model: Any, body: int) -> list[int]:
    """Bodies from the world to one, which is included."""
    found: list[int] = []
    while body:
        found.append(body)
        body = int(model.body_parentid[body])
    return found[::-1]


def _joint(model: Any, one: int, names: Sequence[str]) -> Joint:
    body, limited = int(model.jnt_bodyid[one]), bool(model.jnt_limited[one])
    kind = _KINDS[model.jnt_type[one]]
    follows = next(
        (
            _name(model.joint(int(model.eq_obj2id[row])), "joint") if model.eq_obj2id[row] >= 0 else "a constant"
            for row in range(model.neq)
            if model.eq_type[row] == _EQUAL_JOINTS and model.eq_obj1id[row] == one
        ),
        None,
    )
    return Joint(
        name=_name(model.joint(one), "joint"),
        kind="continuous" if kind == "revolute" and not limited else kind,
        parent=names[int(model.body_parentid[body])],
        child=names[body],
        range=tuple(map(float, model.jnt_range[one])) if limited else None,  # type: ignore[arg-type]
        follows=follows,
    )


_EQUAL_JOINTS = 2
"""MuJoCo's number of an equality of joints."""


def _carrier(model: Any, body: int, carriers: Sequence[int]) -> int:
    """The body with a moving joint that carries another, or is it; 0: none."""
    while body and body not in carriers:
        body = int(model.body_parentid[body])
    return body


def _lumped(
    model: Any, data: Any, bodies: Sequence[int], turn: np.ndarray, place: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of mass and inertia about it of several bodies, in axes at a place."""
    mass = float(sum(model.body_mass[one] for one in bodies))
    if not mass:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    centre = sum(model.body_mass[one] * data.xipos[one] for one in bodies) / mass
    inertia = np.zeros((3, 3))
    for one in bodies:
        own, lever = data.ximat[one].reshape(3, 3), data.xipos[one] - centre
        inertia += own @ np.diag(model.body_inertia[one]) @ own.T
        inertia += model.body_mass[one] * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    return mass, turn.T @ (centre - place), turn.T @ inertia @ turn
