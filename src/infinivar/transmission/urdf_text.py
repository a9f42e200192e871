"""What a URDF says about its joints, read before pin does: whose messages name neither joint nor reason.

Source: the URDF specification of ROS, "joint" element.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from infinivar.errors import InputError, nearest, printable

TURNING = ("revolute", "continuous")
MOVING = (*TURNING, "prismatic")
"""Kinds of joints that a leg can move."""


class Joint(NamedTuple):
    """One joint of a URDF."""

    name: str
    kind: str
    parent: str
    child: str
    range: tuple[float, float] | None
    """Lowest and highest position; None: unlimited. [rad], [m]"""
    follows: str | None
    """The joint that it mimics."""


def joints_to(text: str, frame: str, legs: Sequence[str]) -> tuple[Joint, ...]:
    """The joints that legs move, in the order of the legs.

    Raises
    ------
    InputError
        If the text is no URDF, the frame is unknown, or the legs are not all joints that move between base and frame.
    """
    links, joints = _read(text)
    if frame not in links:
        raise InputError(f"frame has an unknown link {frame!r}{nearest(frame, links)}; links: {', '.join(links)}")
    by_name = {joint.name: joint for joint in joints}
    above = {joint.child: joint for joint in joints}
    chain: list[Joint] = []
    at = frame
    while at in above:
        if len(chain) > len(joints):
            raise InputError(f"urdf must be a tree, but link {at!r} is below itself")
        chain.append(above[at])
        at = above[at].parent
    for name in legs:
        if name not in by_name:
            known = [joint.name for joint in joints if joint.kind in MOVING]
            raise InputError(f"legs has an unknown joint {name!r}{nearest(name, known)}; joints: {', '.join(known)}")
        _check_leg(by_name[name], chain, frame)
    for joint in reversed(chain):
        if joint.kind != "fixed" and joint.name not in legs:
            kept = joint.kind in MOVING and joint.follows is None
            what = "it needs a leg" if kept else "a leg cannot move it"
            raise InputError(f"legs must name all joints that move {frame!r}: {_words(joint)} is missing, and {what}")
    return tuple(by_name[name] for name in legs)


def _check_leg(joint: Joint, chain: Sequence[Joint], frame: str) -> None:
    if joint.kind not in MOVING:
        raise InputError(f"legs must be joints of type {', '.join(MOVING)}, got {_words(joint)}")
    if joint.follows is not None:
        raise InputError(
            f"legs must be joints that move on their own, got {joint.name!r}, which mimics {joint.follows!r}"
        )
    if joint not in chain:
        raise InputError(f"legs must be joints between the base and {frame!r}, got {joint.name!r} of another branch")


def _words(joint: Joint) -> str:
    return f"{joint.name!r}, a {joint.kind} joint"


def _read(text: str) -> tuple[list[str], list[Joint]]:
    """Names of the links, and the joints."""
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as problem:
        raise InputError(f"urdf is not XML: {problem}") from None
    if root.tag != "robot":
        raise InputError(f"urdf must have the root element robot, got {printable(root.tag)}")
    links = [_name(one) for one in root.findall("link")]
    # Transmissions and simulators list joints again, below elements of their own.
    joints = [_joint(one, links) for one in root.findall("joint")]
    for what, names in (("link", links), ("joint", [joint.name for joint in joints])):
        twice = next((name for place, name in enumerate(names) if name in names[:place]), None)
        if twice is not None:
            raise InputError(f"urdf must give each {what} a name of its own, got {twice!r} twice")
    bases = [name for name in links if name not in {joint.child for joint in joints}]
    if len(bases) != 1:
        raise InputError(f"urdf must have one link that is no child of a joint, got {', '.join(bases) or 'none'}")
    return links, joints


def _name(element: Any) -> str:
    name = element.get("name")
    if not name:
        raise InputError(f"urdf has a {element.tag} without a name")
    return name


def _joint(element: Any, links: Sequence[str]) -> Joint:
    name, kind = _name(element), element.get("type")
    if kind not in (*MOVING, "fixed", "floating", "planar"):
        raise InputError(
            f"type of joint {name!r} must be one of {', '.join(MOVING)}, fixed, floating, planar, got {kind!r}"
        )
    ends = {place: element.find(place) for place in ("parent", "child")}
    above, below = (str(None if link is None else link.get("link")) for link in ends.values())
    for place, said in (("parent", above), ("child", below)):
        if said not in links:
            raise InputError(f"{place} of joint {name!r} must be a link of the URDF, got {said}")
    for place, keys in (("origin", ("xyz", "rpy")), ("axis", ("xyz",))):
        for key in keys:
            turns = place == "axis" and kind != "fixed"  # exporters give a fixed joint an axis of zeros
            _check_vector(element.find(place), f"{key} of the {place} of joint {name!r}", key, turns=turns)
    mimic = element.find("mimic")
    follows = None if mimic is None else str(mimic.get("joint"))
    return Joint(name, kind, above, below, _range(element, name, kind), follows)


def _check_vector(element: Any, what: str, key: str, *, turns: bool) -> None:
    said = None if element is None else element.get(key)
    if said is None:
        return
    try:
        parts = [float(part) for part in said.split()]
    except ValueError:
        parts = []
    if len(parts) != 3 or not all(map(math.isfinite, parts)):
        raise InputError(f"{what} must be three numbers, such as '0 0 1', got {said!r}")
    if turns and not any(parts):
        raise InputError(f"{what} must not be 0, such as '0 0 1', got {said!r}")


def _range(element: Any, name: str, kind: str) -> tuple[float, float] | None:
    if kind not in ("revolute", "prismatic"):
        return None
    limit = element.find("limit")
    if limit is None or "effort" not in limit.attrib or "velocity" not in limit.attrib:
        raise InputError(f"limit of joint {name!r} is missing: a {kind} joint needs lower, upper, effort and velocity")
    try:
        low, high = (float(limit.get(end, "0")) for end in ("lower", "upper"))
    except ValueError:
        low = high = math.nan
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        said = f"{limit.get('lower', '0')} to {limit.get('upper', '0')}"
        raise InputError(f"limit of joint {name!r} must be a range from lower to upper, got {said}")
    return low, high
