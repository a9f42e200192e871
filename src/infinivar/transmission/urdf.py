r"""Robots from a URDF file, whose joints are moved by legs on a common cylinder.

A leg drives a turning joint by a pulley of radius rho and a sliding one directly, ``ldot_i = rho_i qdot_i``. The twist of the end
frame is ``xi = J_e qdot``, so that the link speeds of a robot with as many joints as components of the twist are

.. math:: \dot l = \mathrm{diag}(\rho)\, J_e^{-1} \xi

Kinematics by pin (Pinocchio), an extra: ``pip install 'infinivar[robots]'``. What the file says about its joints is read before
pin does, whose messages name neither joint nor reason.

Source: carpentier2019; the URDF specification of ROS, "joint" element.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core import extras, files
from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array, shown
from infinivar._core.fields import check_value, component
from infinivar.errors import InputError, ParameterError, nearest, printable, require
from infinivar.limits import Limit
from infinivar.transmission.configuration import Configuration

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
"""Of a twist: velocities of the end frame's origin and angular velocities, along the axes of the base."""

_MOST_BYTES = 100_000_000
"""Largest URDF file."""

_SINGULAR = 1e-12
"""Smallest singular value of a Jacobian over the largest, below which the pose is singular."""

TURNING = ("revolute", "continuous")

MOVING = (*TURNING, "prismatic")
"""Kinds of joints that a leg can move."""


def load_urdf(path: str | Path, *, legs: Sequence[str], frame: str, pulley_radius: Array | None = None) -> UrdfRobot:
    """Read a robot from a URDF file.

    Parameters
    ----------
    path : str or Path             The file.
    legs : n names                 Joints that legs move: all that move between the base and the end frame, in any order.
    frame : str                    Link at whose origin the user pushes.
    pulley_radius : float or row   rho, > 0, one for all turning joints or one for each, in the order of `legs`; not for
        sliding ones. [m]

    Returns
    -------
    UrdfRobot

    Raises
    ------
    InputError
        If pin is not installed, the file is missing or no URDF, or a joint or frame is not one that a leg can move.
    """
    text = text_of(path)
    try:
        return UrdfRobot(urdf=text, legs=legs, frame=frame, pulley_radius=pulley_radius)
    except InputError as problem:
        raise type(problem)(f"{path}: {problem}") from None


def text_of(path: str | Path) -> str:
    """Text of a URDF file."""
    try:
        return files.read(Path(path), _MOST_BYTES).decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{printable(path)}: is not a text file in UTF-8") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class UrdfRobot:
    """A chain of joints from a URDF, each moved by a leg; see `load_urdf`.

    Raises
    ------
    InputError
        As for `load_urdf`.
    """

    urdf: str = component("Text of the URDF")
    legs: Sequence[str] = component("Names of the joints that legs move")
    frame: str = component("Name of the link at whose origin the user pushes")
    pulley_radius: Array | None = component("Radii of the pulleys of turning joints, in m", default=None)
    joints: tuple[Joint, ...] = field(init=False, repr=False, compare=False, default=())
    """The joints that legs move, in their order."""
    _model: Any = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        """Read the text, and build the model."""
        require(isinstance(self.urdf, str), "urdf", shown(self.urdf), "the text of a URDF")
        require(isinstance(self.frame, str), "frame", shown(self.frame), "the name of a link")
        named = isinstance(self.legs, Sequence) and not isinstance(self.legs, str)
        named = named and len(self.legs) > 0 and all(isinstance(name, str) for name in self.legs)
        require(named and len(set(self.legs)) == len(self.legs), "legs", shown(self.legs), "a row of different names")
        object.__setattr__(self, "legs", tuple(self.legs))
        object.__setattr__(self, "joints", joints_to(self.urdf, self.frame, self.legs))
        object.__setattr__(self, "pulley_radius", self._radii())
        pin = extras.load("pinocchio", "robots", "a robot from URDF")
        try:
            model = pin.buildModelFromXML(self.urdf)
        except ValueError as problem:
            raise InputError(f"urdf is not valid: {str(problem).splitlines()[0]}") from None
        object.__setattr__(self, "_model", model)

    def _radii(self) -> tuple[float, ...] | None:
        count = sum(joint.kind in TURNING for joint in self.joints)
        if self.pulley_radius is None:
            require(count == 0, "pulley_radius", None, f"given: {count} of the joints turn")
            return None
        require(count > 0, "pulley_radius", shown(self.pulley_radius), "left out: no joint turns")
        given = real_array("pulley_radius", self.pulley_radius)
        require(
            given.shape in ((), (count,)), "pulley_radius", f"shape {given.shape}", f"one number, or {count} of them"
        )
        check_value("pulley_radius", given, "m", Gt(0))
        return tuple(float(one) for one in np.broadcast_to(given, (count,)))

    @property
    def levers(self) -> np.ndarray:
        """Speed of each link over that of its joint: a pulley's radius, or 1 of a sliding joint. (n,) [m], [-]"""
        radii = iter(self.pulley_radius or ())
        return np.array([next(radii) if joint.kind in TURNING else 1.0 for joint in self.joints])

    def pose(self, positions: Array) -> tuple[np.ndarray, np.ndarray]:
        """Where the end frame is.

        Parameters
        ----------
        positions : (..., n) float   q, of the joints in the order of the legs. [rad], [m]

        Returns
        -------
        (..., 3) float      Its origin in axes of the base. [m]
        (..., 3, 3) float   Its axes, as columns. [-]
        """
        given, found = self._positions(positions), []
        model, data, frame = self._model, self._model.createData(), self._model.getFrameId(self.frame)
        pin = extras.load("pinocchio", "robots", "a robot from URDF")
        for q in self._expanded(given):
            pin.framesForwardKinematics(model, data, q)
            placed = data.oMf[frame]
            found.append(np.concatenate([placed.translation[:, None], placed.rotation], axis=1))
        whole = np.array(found).reshape(*given.shape[:-1], 3, 4)
        return whole[..., 0], whole[..., 1:]

    def jacobian(self, positions: Array) -> np.ndarray:
        """Derivatives of the end frame's twist by the joint rates.

        Parameters
        ----------
        positions : (..., n) float   q. [rad], [m]

        Returns
        -------
        (..., 6, n) float   J_e, with rows as in `COMPONENTS`. Its transpose turns wrenches at the frame into joint torques.
        """
        given = self._positions(positions)
        model, data, frame = self._model, self._model.createData(), self._model.getFrameId(self.frame)
        pin = extras.load("pinocchio", "robots", "a robot from URDF")
        columns = [model.joints[model.getJointId(name)].idx_v for name in self.legs]
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        found = [pin.computeFrameJacobian(model, data, q, frame, axes) for q in self._expanded(given)]
        # The Jacobian of a model with a single joint is a row.
        return np.reshape(found, (-1, 6, model.nv))[..., columns].reshape(*given.shape[:-1], 6, len(self.legs))

    def joint_torques(self, positions: Array, wrench: Array) -> np.ndarray:
        """Torques, and forces on sliding joints, ``J_e^T W`` by a wrench at the end frame.

        Parameters
        ----------
        positions : (..., n) float   q. [rad], [m]
        wrench : (..., 6) float      Force and moment, along the axes of the base. [N], [N m]

        Returns
        -------
        (..., n) float   [N m], [N]
        """
        given = real_array("wrench", wrench)
        require(given.shape[-1:] == (6,), "wrench", f"shape {given.shape}", "of shape (..., 6)")
        return np.matmul(np.swapaxes(self.jacobian(positions), -1, -2), given[..., None])[..., 0]

    def at(self, positions: Array, components: Sequence[str] | None = None) -> Configuration:
        """The machine of legs at joint positions.

        Parameters
        ----------
        positions : (..., n) float   q. [rad], [m]
        components : n names         Of the end frame's twist, as many of `COMPONENTS` as there are legs. None: twists are the
            joint rates and wrenches the joint torques, which needs no regular pose.

        Returns
        -------
        Configuration   With the demand on the range of the joints, `Limit.TRAVEL`. With components, the jacobian is nan and the
            demand of `Limit.LINKAGE` infinite at singular poses.
        """
        given, levers = self._positions(positions), self.levers
        utilisation: dict[Limit, np.ndarray] = {}
        ranges = [joint.range for joint in self.joints]
        off = [
            np.abs(given[..., place] - 0.5 * (low + high)) / (0.5 * (high - low))
            for place, (low, high) in ((place, ends) for place, ends in enumerate(ranges) if ends is not None)
        ]
        if off:
            utilisation[Limit.TRAVEL] = np.max(np.stack(off), axis=0)
        if components is None:
            jacobian = np.broadcast_to(np.diag(levers), (*given.shape, len(levers)))
        else:
            jacobian, singular = self._inverse(self.jacobian(given)[..., self._rows(components), :])
            jacobian = levers[:, None] * jacobian
            utilisation[Limit.LINKAGE] = np.where(singular, np.inf, 0.0)
        return Configuration(jacobian=jacobian, link_position=levers * given, utilisation=utilisation)

    def _rows(self, components: Sequence[str]) -> list[int]:
        n, named = len(self.legs), isinstance(components, Sequence) and not isinstance(components, str)
        known = named and len(set(components)) == len(components) == n
        require(known, "components", shown(components), f"{n} different ones, as many as there are legs")
        for name in components:
            if name not in COMPONENTS:
                raise ParameterError(
                    f"components must be of {', '.join(COMPONENTS)}, got {name!r}{nearest(str(name), COMPONENTS)}"
                )
        return [COMPONENTS.index(name) for name in components]

    @staticmethod
    def _inverse(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inverse matrices, nan where singular, and where they are."""
        values = np.linalg.svd(matrix, compute_uv=False)
        singular = values[..., -1] <= _SINGULAR * values[..., 0]
        wide = singular[..., None, None]
        return np.where(wide, np.nan, np.linalg.inv(np.where(wide, np.eye(matrix.shape[-1]), matrix))), singular

    def _positions(self, positions: Array) -> np.ndarray:
        given, n = real_array("positions", positions), len(self.legs)
        require(given.shape[-1:] == (n,), "positions", f"shape {given.shape}", f"of shape (..., {n}), one for each leg")
        require(bool(np.all(np.isfinite(given))), "positions", "nan or inf", "finite")
        return given

    def _expanded(self, given: np.ndarray) -> np.ndarray:
        """Coordinates of pin for each row of positions; joints of other branches stay at 0."""
        pin = extras.load("pinocchio", "robots", "a robot from URDF")
        model, rows = self._model, given.reshape(-1, given.shape[-1])
        found = np.tile(pin.neutral(model), (len(rows), 1))
        for place, name in enumerate(self.legs):
            joint = model.joints[model.getJointId(name)]
            if joint.nq == 1:
                found[:, joint.idx_q] = rows[:, place]
            else:  # a joint without limits: cosine and sine
                found[:, joint.idx_q], found[:, joint.idx_q + 1] = np.cos(rows[:, place]), np.sin(rows[:, place])
        return found


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
    links, joints = tree_of(text)
    by_name = {joint.name: joint for joint in joints}
    chain = joints_above(links, joints, frame)
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


def joints_above(links: Sequence[str], joints: Sequence[Joint], frame: str, key: str = "frame") -> list[Joint]:
    """Joints between a link, the value of a field, and the base, from the link."""
    if frame not in links:
        raise InputError(f"{key} has an unknown link {frame!r}{nearest(frame, links)}; links: {', '.join(links)}")
    above = {joint.child: joint for joint in joints}
    chain: list[Joint] = []
    at = frame
    while at in above:
        if len(chain) > len(joints):
            raise InputError(f"urdf must be a tree, but link {at!r} is below itself")
        chain.append(above[at])
        at = above[at].parent
    return chain


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


def tree_of(text: str) -> tuple[list[str], list[Joint]]:
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
    above: dict[str, str] = {}
    for joint in joints:
        if joint.child in above:
            both = f"{above[joint.child]!r} and {joint.name!r}"
            raise InputError(f"urdf must be a tree, but link {joint.child!r} is the child of two joints, {both}")
        above[joint.child] = joint.name
    bases = [name for name in links if name not in above]
    if len(bases) != 1:
        raise InputError(f"urdf must have one link that is no child of a joint, got {', '.join(bases) or 'none'}")
    return links, joints


def _name(element: Any) -> str:
    name = element.get("name")
    if not name:
        raise InputError(f"urdf has a {element.tag} without a name")
    return name


def check_single(element: Any, tags: Sequence[str], what: str) -> None:
    """Raise InputError if an element has one of some elements more than once: readers of URDF differ in which one they take."""
    for tag in tags:
        count = len(element.findall(tag))
        if count > 1:
            raise InputError(f"{what} must have one {tag}, got {count}")


def number_of(element: Any, key: str, what: str) -> float:
    """A finite number that an element states."""
    said = None if element is None else element.get(key)
    if said is None:
        raise InputError(f"{what} is missing")
    try:
        value = float(said)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{what} must be a number, got {said!r}")
    return value


def _joint(element: Any, links: Sequence[str]) -> Joint:
    name, kind = _name(element), element.get("type")
    check_single(element, ("origin", "parent", "child", "axis", "limit", "mimic"), f"joint {name!r}")
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
    limit = element.find("limit")
    for key in () if limit is None else [one for one in ("effort", "velocity") if one in limit.attrib]:
        value = number_of(limit, key, f"{key} of the limit of joint {name!r}")
        if value < 0.0:
            raise InputError(f"{key} of the limit of joint {name!r} must be >= 0, got {value:g}")
    if kind not in ("revolute", "prismatic"):
        return None
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
