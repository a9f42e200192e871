"""Arms of turning joints from a URDF file, with their masses.

Source: carpentier2019; the URDF specification of ROS, "inertial" element.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from infinivar._core import extras
from infinivar._core.text import joined
from infinivar.errors import InputError
from infinivar.transmission.robot_model import RobotModel, moving_joints
from infinivar.transmission.turning_chain import TurningChain
from infinivar.transmission.urdf import check_single, joints_above, number_of, text_of, tree_of

_JOINT = " (joint)"
_ROUNDED = 1e-6
"""Negative moment of inertia over the largest one, which is rounding in a file."""

_FLAT = 0.01
"""Part of the largest moment of inertia by which the other two may fall short of it, as rounding to three digits in a file: it
changes each moment by 0.5 % at most, and the three of a flat body together by twice 0.5 % of the largest."""


def read_urdf_arm(path: str | Path, tool: str = "", joints: Sequence[str] | None = None) -> RobotModel:
    """Read the joints between base and tool of a URDF file, with masses; all other joints, also of other branches, stay at 0.

    Parameters
    ----------
    path : str or Path       The file. Meshes are not read.
    tool : str               Link whose origin is the end point; by default the one at the end of the tree.
    joints : names or None   Joints that move; None: all that can between base and tool.

    Raises
    ------
    InputError
        If pin is not installed, the file is missing or no URDF, a joint that moves does not turn or mimics another, or a link
        has an impossible mass or inertia.

    Source: carpentier2019, for the reading of masses and placements; the URDF specification of ROS.
    """
    text = text_of(path)
    links, every = tree_of(text)
    if not tool:
        ends = [name for name in links if name not in {joint.parent for joint in every}]
        if len(ends) != 1:
            raise InputError(f"tool is missing: must be one of the links, such as {joined(ends[:6], 'or')}")
        tool = ends[0]
    chain = joints_above(links, every, tool, "tool")[::-1]
    moving = moving_joints(chain, every, tool, joints)
    names = [one.name for one in moving]
    massless = _massless(text, {one.child: one.kind for one in every})
    pin = extras.load("pinocchio", "robots", "a robot from URDF")
    try:
        whole = pin.buildModelFromXML(_distinct(text))
    except ValueError as problem:
        raise InputError(f"urdf is not valid: {str(problem).splitlines()[0]}") from None
    locked = [place for place, name in enumerate(whole.names) if place and name.removesuffix(_JOINT) not in names]
    model = pin.buildReducedModel(whole, locked, pin.neutral(whole)) if locked else whole
    data, still = model.createData(), pin.neutral(model)
    axes = [
        np.reshape(pin.computeJointJacobian(model, data, still, place), (6, -1))[3:, model.joints[place].idx_v]
        for place in range(1, model.njoints)
    ]
    end = model.frames[model.getFrameId(tool, pin.FrameType.BODY)].placement
    placements, inertias = list(model.jointPlacements)[1:], list(model.inertias)[1:]
    return RobotModel(
        TurningChain(
            names=tuple(one.name for one in moving),
            turns=np.array([one.rotation for one in placements]),
            places=np.array([one.translation for one in placements]),
            axes=np.array(axes),
            tool_turn=np.array(end.rotation),
            tool_place=np.array(end.translation),
            ranges=tuple(one.range for one in moving),
        ),
        [(float(one.mass), np.array(one.lever), np.array(one.inertia)) for one in inertias],
        massless,
    )


def _distinct(text: str) -> str:
    """The same with a suffix on names of joints: links may have the same ones, which pin takes for one."""
    from xml.etree import ElementTree

    root = ElementTree.fromstring(text)
    for one in root.findall("joint"):
        one.set("name", one.get("name", "") + _JOINT)
        for mimic in one.findall("mimic"):
            mimic.set("joint", mimic.get("joint", "") + _JOINT)
    return ElementTree.tostring(root, encoding="unicode")


def _massless(text: str, joint_kinds: Mapping[str, str]) -> tuple[str, ...]:
    """Links without a mass, by the kinds of the joints that carry them; the base does not move, and a fixed frame has none.

    Raises
    ------
    InputError
        If a link has a mass below 0, a mass without moments of inertia, or moments that no body has.
    """
    from xml.etree import ElementTree

    found = []
    for link in ElementTree.fromstring(text).findall("link"):
        name, inertial = link.get("name"), link.find("inertial")
        check_single(link, ("inertial",), f"link {name!r}")
        if inertial is not None:
            check_single(inertial, ("origin", "mass", "inertia"), f"inertial of link {name!r}")
        stated = None if inertial is None else inertial.find("mass")
        mass = 0.0 if inertial is None else number_of(stated, "value", f"mass of link {name!r}")
        if mass < 0.0:
            raise InputError(f"mass of link {name!r} must be >= 0 kg, got {mass:g}")
        if not mass and name in joint_kinds:
            fixed = joint_kinds.get(str(name)) == "fixed"
            if not (fixed and inertial is None and link.find("visual") is None and link.find("collision") is None):
                found.append(str(name))
        tensor = None if inertial is None else inertial.find("inertia")
        if not mass and tensor is None:
            continue
        if tensor is None:
            raise InputError(f"inertia of link {name!r} is missing: it has a mass of {mass:g} kg")
        xx, xy, xz, yy, yz, zz = (
            number_of(tensor, key, f"{key} of link {name!r}") for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        values = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if values[0] < -_ROUNDED * values[-1]:
            raise InputError(
                f"inertia of link {name!r} must have moments >= 0 kg m^2 about all axes, got {values[0]:.3g} about one"
            )
        if values[0] + values[1] < (1.0 - _FLAT) * values[2]:
            small, middle, large = (f"{one:.3g}" for one in values)
            raise InputError(
                f"inertia of link {name!r} must have two principal moments that add up to no less than the third, as all bodies "
                f"have, got {small} and {middle} with {large} kg m^2"
            )
    return tuple(found)
