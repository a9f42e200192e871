"""Tasks at a user's handle as study files state them, and what a session of one needs: machine, controller and user."""

from __future__ import annotations

import dataclasses
import functools
import os.path
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.arrays import Whole
from infinivar._core.fields import check_real, component, given, quantities, quantity, tagged
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import type_words
from infinivar.errors import InputError, ParameterError, require
from infinivar.machines.control.sampling import Sensing, check_rate
from infinivar.motion.files.fields import FILE_KEYS
from infinivar.motion.users import AXES, USERS, PushingUser, ReachingUser
from infinivar.motion.vectors import Point, Pose, Twist
from infinivar.motion.virtual.meshes import MeshFile
from infinivar.motion.virtual.tasks import TASKS, Fixture, HandleTask, VirtualPath, VirtualWall
from infinivar.motion.waypoints import RecordedForce
from infinivar.study.layers import Raw
from infinivar.units import plain

if TYPE_CHECKING:
    from infinivar.machines.kind import MovingMachine
    from infinivar.machines.system import Mechanics

_STICK_SPEED = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerSettings(Whole):
    """Settings of the controller of a task; those left out are its own.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    virtual_mass: float | None = quantity("kg", Gt(0), "Legs: virtual mass at the handle", default=None)
    virtual_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Legs: virtual inertia of a handle that turns", default=None
    )
    virtual_damping: float | None = quantity("N s/m", Ge(0), "Legs: virtual damping at the handle", default=None)
    turning_damping: float | None = quantity(
        "N m s/rad", Ge(0), "Legs: virtual damping of the turning of the handle", default=None
    )
    wall_time: float | None = quantity(
        "s", Gt(0), "Legs: time constant with which the handle is slowed down to a wall", default=None
    )
    cylinder: Literal["set", "least loss"] | None = component(
        "Legs: speed of the cylinder as set, or that of the least creep loss", default=None
    )
    margin: float | None = quantity(
        "m", Ge(0), "Wheels of a cart: distance at which a wall begins to lead", default=None
    )
    largest_rate: float | None = quantity(
        "rad/s", Gt(0), "Wheels of a cart: fastest turn of the direction of motion", default=None
    )
    rest_speed: float | None = quantity(
        "m/s", Gt(0), "Wheels of a cart: speed below which it counts as at rest", default=None
    )
    no_slip_feedforward: bool = component("Legs and carts: do not feed slip angles forward", default=False)
    stiffness: float | None = quantity("N/m", Ge(0), "Geared drives: stiffness of wall or hold", default=None)
    damping: float | None = quantity("N s/m", Ge(0), "Geared drives: damping of wall or hold", default=None)
    compensation: float | None = quantity(
        "1", Interval(ge=0, le=1), "Geared drives: share of the constant friction that is fed forward", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    def stated(self) -> Mapping[str, Any]:
        """Those that are stated, by name."""
        found = {one.name: getattr(self, one.name) for one in dataclasses.fields(self)}
        return {name: value for name, value in found.items() if value is not None and value is not False}

    def of(self, controller: Any) -> Mapping[str, Any]:
        """Those that a controller has, by the names of its own fields."""
        found = {}
        for name, value in self.stated.items():
            kinds, field, made = _settings()[name]
            if _takes(controller, kinds, field):
                found[field] = value if made is None else made
        return found


@functools.cache
def _settings() -> Mapping[str, tuple[tuple[type, ...], str, Any]]:
    """Controllers that have a setting, its field there, and the value if it is another."""
    from infinivar.machines.control.impedance import ImpedanceGuide
    from infinivar.machines.control.legs import AdmittanceGuide
    from infinivar.machines.control.planar import CasterGuide, PathGuide, WallGuide

    carts = (PathGuide, WallGuide, CasterGuide)
    return {
        **{
            name: ((AdmittanceGuide,), field, None)
            for name, field in {
                "virtual_mass": "mass",
                "virtual_inertia": "inertia",
                "virtual_damping": "damping",
                "turning_damping": "turning_damping",
                "wall_time": "wall_time",
                "cylinder": "cylinder",
            }.items()
        },
        **{name: (carts, name, None) for name in ("margin", "largest_rate", "rest_speed")},
        "no_slip_feedforward": ((AdmittanceGuide, *carts), "slip_feedforward", False),
        **{name: ((ImpedanceGuide,), name, None) for name in ("stiffness", "damping", "compensation")},
    }


def _takes(controller: Any, kinds: tuple[type, ...], field: str) -> bool:
    """Whether a controller is of one of these classes and has a field."""
    return isinstance(controller, kinds) and any(one.name == field for one in dataclasses.fields(controller))


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionTask(Whole):
    """A session of a user at the handle of a machine that a controller guides.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    task: HandleTask = tagged("What the handle is to be felt as", TASKS, flat=True, key="type")
    duration: float = quantity("s", Interval(gt=0, le=600), "Duration of the session")
    drive: str | None = component("Drive of the study whose handle is held; default: the first", default=None)
    user: PushingUser | ReachingUser | None = tagged(
        "User at the handle; default: nobody", USERS, key="type", default=None
    )
    sensing: Sensing = component("Sensors, sample rate and delay of the controller", default_factory=Sensing)
    controller: ControllerSettings | None = component("Settings of the controller; default: its own", default=None)
    pose: Pose = component("Pose at the start; at home where not stated", default_factory=Pose)
    twist: Twist = component(
        "Velocity at the start, of a cart or a geared display; at rest where not stated", default_factory=Twist
    )
    handle: Point = component("Where a cart is held, in its own axes", default_factory=Point)
    handle_masses: tuple[float, ...] | None = quantities(
        "kg",
        Gt(0),
        "Mass moved along each axis, with a drive of one axis: one to three, for as many drives",
        default=None,
    )
    load_mass: float | None = quantity("kg", Ge(0), "Mass of a tool moved with a platform or an arm", default=None)
    load_inertia: float | None = quantity(
        "kg m^2", Ge(0), "Moment of inertia of that tool, about all axes", default=None
    )
    servos: Literal["real", "ideal"] = component(
        "Steering with motors, inertia and friction, or wheels that turn as commanded", default="real"
    )
    output_step: float | None = quantity(
        "s", Gt(0), "Time between results; default: a thousandth of the session, or a sample", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        words = ", ".join(kind.__name__ for kind in TASKS.values())
        require(isinstance(self.task, HandleTask), "task", repr(self.task), f"one of {words}")
        kinds = tuple(USERS.values())
        names = ", ".join(kind.__name__ for kind in kinds)
        require(self.user is None or isinstance(self.user, kinds), "user", repr(self.user), f"one of {names}")
        if self.drive is not None:
            require(isinstance(self.drive, str), "drive", repr(self.drive), "the name of a drive")
        if self.handle_masses is not None:
            count = len(self.handle_masses)
            require(1 <= count <= len(AXES), "handle_masses", f"{count} values", f"one to {len(AXES)} values")
        most = 1e6 / self.sensing.sample_rate
        require(self.duration <= most, "duration", f"{self.duration:g} s", f"at most a million samples, {most:g} s")
        if self.output_step is not None and self.duration / self.output_step > 1e6:
            raise ParameterError(f"output_step must be >= {1e-6 * self.duration:g} s, got {self.output_step:g} s")

    @property
    def title(self) -> str:
        """Name for reports."""
        return self.task.title

    def titled(self, name: str) -> SessionTask:
        """The same with a title, its own if it has one."""
        return self if self.task.title else replace(self, task=replace(self.task, title=name))

    @property
    def files(self) -> Mapping[Path, str]:
        """Files that it was read from, and what each is."""
        from infinivar.machines.control.tasks import surface_of

        found = {}
        surface = surface_of(self.task)
        if isinstance(surface, MeshFile):
            found[Path(surface.file)] = "a mesh"
        for one in self.user.along().values() if self.user is not None else ():
            if getattr(one, "file", None):
                found[Path(one.file)] = "a recording"
        return found


def session_arguments(one: SessionTask, drive: Any, where: str, drive_where: str) -> dict[str, Any]:
    """Arguments of `infinivar.session` for a session of a task with a drive.

    Parameters
    ----------
    one : SessionTask
    drive : object                 Drive or machine of a study.
    where, drive_where : str       Their places, such as "tasks.wall" and "drives.cart", for messages.

    Raises
    ------
    ParameterError
        If the drive cannot do the task or lacks a value that motion needs, or what is stated does not fit its handle; the
        message begins with the place.
    """
    from infinivar.machines.control.tasks import controller_of

    machine = _machine(one, drive, where, drive_where)
    mechanics = machine.mechanics(_STICK_SPEED)
    _fits(one, drive, where)
    handle = one.handle.row(("x", "y"))
    grip = mechanics.grip(handle.tolist())
    _in_dimensions(one.task, len(grip.axes), where)
    turns = tuple(axis for axis in getattr(drive, "coordinates", ()) if axis in grip.turns)
    if one.user is not None:
        moves = f"the handle of {drive_where} moves along {', '.join(grip.axes)}"
        moves += f" and turns by {', '.join(turns)}" if turns else ""
        for axis in one.user.beyond((*grip.axes, *turns)):
            raise ParameterError(f"{where}.user.{axis} does not apply: {moves} only")
        if not turns and getattr(one.user, "inertia", None) is not None:
            raise ParameterError(f"{where}.user.inertia does not apply: {moves} and does not turn")
    _lasting(one, where)
    try:
        controller = controller_of(one.task, machine)
    except ParameterError as problem:
        raise ParameterError(f"{where}: {problem}") from None
    controller = _with_settings(controller, one, where)
    if isinstance(one.task, Fixture):
        try:
            _ = one.task.allowed.rows(tuple(getattr(drive, "coordinates", grip.axes)))
        except InputError as problem:
            raise ParameterError(f"{where}.allowed: {problem}") from None
    try:
        check_rate(machine, one.sensing)
    except ParameterError as problem:
        raise ParameterError(f"{where}.{problem}") from None
    pose = _pose(one, drive, machine, where, drive_where)
    found: dict[str, Any] = {
        "machine": machine,
        "task": one.task,
        "controller": controller,
        "duration": one.duration,
        "sensing": one.sensing,
        "servos": one.servos,
        "handle": handle.tolist(),
        "pose": pose,
        "rates": _rates(one, machine, mechanics, pose, where),
        "output_step": one.output_step,
    }
    if isinstance(one.user, PushingUser):
        found["user"] = one.user.over_time(grip.axes)
        if one.user.turns():
            found["moment"] = one.user.over_time(grip.turns)
    elif isinstance(one.user, ReachingUser):
        start = np.array(machine.home if pose is None else pose, dtype=float)
        home = grip.at(start[None], np.zeros((1, len(mechanics.coordinates)))).position[0]
        found["user"], found["intention"] = one.user.model, one.user.intention(grip.axes, home)
        if one.user.turns():
            found["turned"] = one.user.turned(grip.turns)
    return found


def _lasting(one: SessionTask, where: str) -> None:
    """Refuse a recorded force that stops during the session."""
    for axis, force in one.user.along().items() if isinstance(one.user, PushingUser) else ():
        if isinstance(force, RecordedForce):
            end, last = force.start + float(force.time[-1]), float(force.force[-1])
            if end < one.duration and last != 0.0:
                unit = force.axis.force_unit
                raise ParameterError(
                    f"{where}.user.{axis}: the recording ends at {plain(end)} s with {plain(last)} {unit}, before the session of "
                    f"{plain(one.duration)} s; shorten the duration, or end the recording with 0"
                )


def _machine(one: SessionTask, drive: Any, where: str, drive_where: str) -> Any:
    try:
        if _applies(drive) != _OF_ONE_AXIS:
            return drive.moving(**{name: given(getattr(one, name), 0.0) for name in _applies(drive) if name in _LOADS})
        if isinstance(drive, (CoboticDrive, ConventionalDrive)):
            if one.handle_masses is None:
                raise ParameterError(
                    f"{where}.handle_masses is missing: {drive_where} moves one axis, and as many drives as there are masses "
                    'move the handle, such as ["0.5 kg"]'
                )
            from infinivar.machines.kinds.slide import slide_of

            return slide_of(drive, one.handle_masses)
    except ParameterError as problem:
        said = str(problem)
        raise ParameterError(said if said.startswith(where) else f"{drive_where}.{_inside(drive, said)}") from None
    if getattr(drive, "drive", None) is not None:
        raise ParameterError(
            f"{drive_where}.drive: motors drive the cart, but sessions are of carts that a user pushes; leave it out, or run "
            "infinivar simulate"
        )
    raise ParameterError(
        f"{drive_where} is a machine of type {type_words(drive)}, which has no handle; sessions need a planar, platform or arm "
        "machine, or a drive of one axis"
    )


_LOADS = ("load_mass", "load_inertia")
_OF_ONE_AXIS = ("handle_masses",)


def _applies(drive: Any) -> tuple[str, ...]:
    """Keys of a session that apply to some drives only, of those to this one."""
    return getattr(drive, "session", ()) or _OF_ONE_AXIS


def _inside(drive: Any, said: str) -> str:
    """The place of a fault within a drive of one axis, which a slide calls its leg or drive."""
    head = {CoboticDrive: "leg.", ConventionalDrive: "drive."}.get(type(drive), "")
    return said.removeprefix(head)


def _fits(one: SessionTask, drive: Any, where: str) -> None:
    """Refuse what is stated for another kind of machine."""
    stated = {
        "handle_masses": (one.handle_masses is not None, "a drive of one axis"),
        "handle": (bool(one.handle.stated), "a planar machine"),
        "load_mass": (one.load_mass is not None, "a platform or an arm"),
        "load_inertia": (one.load_inertia is not None, "a platform or an arm"),
    }
    for name, (said, words) in stated.items():
        if said and name not in _applies(drive):
            raise ParameterError(f"{where}.{name} does not apply: it is of {words}; remove it")
    for name in one.handle.beyond(("x", "y")):
        raise ParameterError(f"{where}.handle.{name} does not apply to a point of a plane; remove it")


def _in_dimensions(task: HandleTask, count: int, where: str) -> None:
    """Refuse a curve or surface in other dimensions than the handle moves in."""
    if isinstance(task, VirtualPath) and task.curve.dimension != count:
        raise ParameterError(
            f"{where}.curve must be in {count} dimensions, those in which the handle moves, got one in {task.curve.dimension}"
        )
    if isinstance(task, VirtualWall):
        dimension = getattr(task.surface, "dimension", count)
        if dimension != count:
            raise ParameterError(
                f"{where}.surface must be in {count} dimensions, those in which the handle moves, got one in {dimension}"
            )


def _with_settings(controller: Any, one: SessionTask, where: str) -> Any:
    """The controller with the settings that it has; `check_settings` finds those that none has."""
    if one.controller is None:
        return controller
    try:
        return replace(controller, **one.controller.of(controller))
    except ParameterError as problem:
        raise ParameterError(f"{where}.controller.{problem}") from None


def check_settings(one: SessionTask, drives: Mapping[str, Any], where: str) -> None:
    """Raise ParameterError if a setting applies to the controller of no drive.

    A task may be done by several drives, each of which takes those that its controller has.
    """
    from infinivar.machines.control.tasks import controller_of

    if one.controller is None:
        return
    known: dict[str, Any] = {}
    for name, drive in drives.items():
        try:
            known[name] = controller_of(one.task, _machine(one, drive, where, f"drives.{name}"))
        except ParameterError:
            continue
    for name in one.controller.stated:
        kinds, field, _ = _settings()[name]
        if known and not any(_takes(guide, kinds, field) for guide in known.values()):
            raise ParameterError(
                f"{where}.controller.{name} does not apply: no controller of this task with {', '.join(known)} has it; remove it"
            )


def _pose(one: SessionTask, drive: Any, machine: MovingMachine, where: str, drive_where: str) -> list[float] | None:
    known = tuple(drive.coordinates) if hasattr(drive, "coordinates") else AXES[: len(machine.home)]
    for name in one.pose.beyond(known):
        raise ParameterError(f"{where}.pose.{name} does not apply: {drive_where} has {', '.join(known)} only")
    row = one.pose.row(known, list(getattr(drive, "home", machine.home)))
    if hasattr(drive, "followed"):
        row = drive.followed(row, np.zeros(len(row)))[0]
    if not one.pose.stated and np.array_equal(row, machine.home):
        return None
    if not np.all(np.isfinite(row)):
        raise ParameterError(f"{where}.pose must be within the reach of {drive_where}, got {dict(one.pose.stated)}")
    return [float(value) for value in row]


def _rates(
    one: SessionTask, machine: MovingMachine, mechanics: Mechanics, pose: list[float] | None, where: str
) -> list[float] | None:
    if not one.twist.stated:
        return None
    known = machine.twisted
    if not known:
        raise ParameterError(
            f"{where}.twist does not apply: a machine with a common cylinder starts at rest; remove it"
        )
    for name in one.twist.beyond(known):
        raise ParameterError(f"{where}.twist.{name} does not apply: the machine has {', '.join(known)} only")
    begins = np.array(machine.home if pose is None else pose, dtype=float)
    return [float(value) for value in mechanics.rates_of(begins, one.twist.row(known))]


def beside_study(tree: Raw, folder: Path | None) -> None:
    """Find the files in the table of a task from the study's folder; absolute paths are the same from any other."""
    if folder is None:
        return
    for table in _tables(tree):
        for file in (table.get(key) for key in FILE_KEYS):
            if isinstance(file, dict) and isinstance(file.get("value"), str):
                file["value"] = os.path.normpath((folder / file["value"]).absolute())


def _tables(tree: Raw) -> Iterator[Raw]:
    yield tree
    for value in tree.values():
        if isinstance(value, dict) and "value" not in value:
            yield from _tables(value)
