"""What is read of a robot's file: turning joints up to a tool, with the masses that they move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from infinivar._core.text import joined
from infinivar.errors import InputError, nearest
from infinivar.transmission.turning_chain import TurningChain
from infinivar.transmission.urdf import TURNING, Joint


class RobotModel(NamedTuple):
    """Turning joints of a robot up to a tool, with what they move."""

    chain: TurningChain
    bodies: list[tuple[float, np.ndarray, np.ndarray]]
    """Mass, centre of mass, and inertia about it, (3, 3), of what is behind each joint, in its axes. [kg], [m], [kg m^2]"""
    massless: tuple[str, ...]
    """Links of which the file states no mass, or 0; without those that are frames on others."""


def moving_joints(
    chain: Sequence[Joint], every: Sequence[Joint], tool: str, joints: Sequence[str] | None
) -> list[Joint]:
    """The joints that move between base and tool.

    Parameters
    ----------
    chain : sequence of Joint   Between base and tool.
    every : sequence of Joint   Of the whole model.
    tool : str                  Link.
    joints : names or None      Of those that move; None: all that can.

    Raises
    ------
    InputError
        If none moves, or one of them does not turn, or mimics another.
    """
    if all(one.kind == "fixed" for one in chain):
        moved = [one.child for one in every if one.kind in TURNING]
        known = f", such as {joined(moved[:6], 'or')}" if moved else ": the model has no joint that turns"
        raise InputError(f"tool must be a link that a joint moves, got {tool!r}{known}")
    names = [one.name for one in chain if one.kind != "fixed"] if joints is None else list(joints)
    for name in names:
        one = next((joint for joint in chain if joint.name == name), None)
        if one is None:
            known = [joint.name for joint in chain if joint.kind in TURNING]
            raise InputError(
                f"joints has {name!r}, which is no joint between base and {tool!r}{nearest(name, known)}; joints: "
                f"{', '.join(known)}"
            )
        why = f"is {one.kind}" if one.kind not in TURNING else ""
        why = why if one.follows is None else f"mimics {one.follows!r}"
        if why:
            raise InputError(
                f"joint {name!r} between base and {tool!r} {why}: an arm has joints that turn ({', '.join(TURNING)}) on their "
                "own; leave it out of joints, and it stays at 0"
            )
    moving = [one for one in chain if one.name in names]
    if not moving:
        raise InputError(f"joints must be one or more that move {tool!r}, got none")
    return moving
