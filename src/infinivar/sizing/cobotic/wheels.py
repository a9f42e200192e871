"""What cylinder, wheel and link ask of the motors: the part of a cobotic drive that no motor or gearhead changes.

See `infinivar.sizing.cobotic.space` for wheel designs.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core import engine, extras
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.threads import in_order
from infinivar.contact.creep import EXACT
from infinivar.contact.exact_law import NARROWEST, WIDEST
from infinivar.drivetrain.cobotic import CoboticDrive, part_of
from infinivar.drivetrain.drive import GEAR_LIMITS, MOTOR_LIMITS, MotorSide
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import InputError, ParameterError
from infinivar.limits import Demand, Limit
from infinivar.sizing.cobotic.space import FREE, Points, Space
from infinivar.sizing.geared.tasks import MotionTask, RegionTask, Task
from infinivar.sizing.margins import TaskDemand

CONTACT = "contact"
"""Name under which limits appear that the preload alone can exceed."""

AXLE, SUPPORT = "axle bearing", "cylinder bearing"


_DIRECTIONS = 12
"""In the plane of force and speed, in each of which the farthest point is looked at first for slip."""


class Shaft(NamedTuple):
    """What a task asks of both motors, by design and instant. (k, n)"""

    turning: np.ndarray
    """Cylinder speed. (k, 1) [rad s^-1]"""
    torque: np.ndarray
    """Applied by the cylinder to the wheel. [N m]"""
    rate: np.ndarray
    """Of the steering angle; empty for a required region, in which steering rests. [rad s^-1]"""
    acceleration: np.ndarray
    """[rad s^-2]"""
    patch: np.ndarray
    """Friction torque of a patch that turns on the spot. (k, 1) [N m]"""
    bell: np.ndarray
    """Friction torque of the bell's bearing. (k, 1) [N m]"""
    moment: np.ndarray | None
    """Of the patch against steering; None for one that turns on the spot. [N m]"""
    bell_inertia: np.ndarray
    """Of bell and wheel about the steering axis. (k, 1) [kg m^2]"""

    def of(self, places: np.ndarray) -> Shaft:
        """Of some designs."""
        return Shaft(*(None if part is None else part[places] for part in self))  # type: ignore[arg-type]

    def steer(self, plant: SteeringPlant) -> MotorSide:
        """Operation of a steering plant."""
        plant = replace(plant, bell_inertia=None, derived_inertia=self.bell_inertia, bells=1)  # of all bells
        return plant.turn(
            {"patch": self.patch, "bell": self.bell},
            rate=self.rate,
            acceleration=self.acceleration,
            patch_moment=self.moment,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wheels:
    """Many wheel designs, evaluated."""

    demands: Mapping[TaskDemand, np.ndarray]
    """Demand over allowance of every limit that no motor changes; inf where the wheel slips. (k,) [-]"""
    slipping: np.ndarray
    """Share of all instants without steady rolling. (k,) [-]"""
    shafts: Mapping[str, Shaft]
    """By task; values of slipping designs are nan."""


def joined(parts: Sequence[Wheels]) -> Wheels:
    """Wheel designs evaluated apart, as if together."""
    first = parts[0]
    return Wheels(
        demands={key: np.concatenate([one.demands[key] for one in parts]) for key in first.demands},
        slipping=np.concatenate([one.slipping for one in parts]),
        shafts={
            name: Shaft(
                *(
                    None if some[0] is None else np.concatenate(some)
                    for some in zip(*(one.shafts[name] for one in parts), strict=True)
                )  # type: ignore[arg-type]
            )
            for name in first.shafts
        },
    )


def check_template(template: CoboticDrive, moving: bool) -> None:
    """Raise ParameterError unless wheel designs can be made from a drive."""
    if template.transmission.geometry is None:
        raise ParameterError(
            "transmission.geometry is missing: measured values of a contact hold for one wheel, cylinder and preload only"
        )
    if template.steering is None and moving:
        raise ParameterError("steering is missing: motions need the steering plant")
    if moving:
        template.check_motion()


def shape_excess(drive: CoboticDrive) -> Array:
    """Largest ratio of the patch's axes over the widest that the law's tables cover; 0 for a law without tables. [-]"""
    element = drive.transmission
    assert element.contact is not None
    ratio = element.contact.axis_ratio
    xp = namespace(ratio)
    if element.creep_law != EXACT and not element.turns_with_spin:
        return 0.0 * ratio
    return xp.maximum(ratio / WIDEST, NARROWEST / ratio)


def static_demands(drive: CoboticDrive, count: int | None = None) -> dict[TaskDemand, np.ndarray]:
    """Demand over allowance of the limits that the preload alone can exceed: yield, hardness, load of bearings at rest. (k,)"""
    count = len(np.asarray(drive.cylinder_speed)) if count is None else count
    return named_static(drive.transmission.utilisation, count)


def named_static(demands: Mapping[Limit, Array], count: int) -> dict[TaskDemand, np.ndarray]:
    """Demands of the preload alone by limit as demands of a task, one of each design. (k,)"""
    parts = {Limit.BEARING: AXLE, Limit.AXLE: "axle", Limit.CLEARANCE: AXLE, Limit.WALL: "cylinder"}
    return {
        (CONTACT, limit, parts.get(limit, "wheel")): np.broadcast_to(np.ravel(demand), (count,))
        for limit, demand in demands.items()
    }


def critical(template: CoboticDrive, tasks: Sequence[Task]) -> tuple[Task, ...]:
    """The tasks at the few instants, or points, at which a wheel is most likely to slip.

    Largest are force, speed or power, or force with some speed: the steeper the wheel is steered, the less of the slip force is
    left along the link. A wheel that slips in one of them slips. None of a task with springs or linkages, where instants depend
    on others.
    """
    found: list[Task] = []
    for task in tasks:
        if isinstance(task, RegionTask):
            places = _extreme(task.force, task.speed)
            found.append(replace(task, speed=task.speed[places], force=task.force[places]))
            continue
        if template.output.chain:
            continue
        course = task.instants.course
        force = np.asarray(course.driving_force(task.duty.moved_mass + (template.mass_of_link or 0.0)).value)
        shape = task.instants.time.shape
        places = _extreme(np.broadcast_to(force, shape), np.broadcast_to(course.speed, shape))
        some = {
            one.name: np.broadcast_to(value, shape)[places]
            for one in dataclasses.fields(course)
            if isinstance(value := getattr(course, one.name), np.ndarray)
        }
        instants = task.instants._replace(
            time=task.instants.time[places],
            position=np.broadcast_to(task.instants.position, shape)[places],
            course=replace(course, **some),
        )
        found.append(replace(task, instants=instants, travel=None))
    return tuple(found)


def _extreme(force: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Places of largest force, speed, power and weighed sums of force and speed, of both signs. (n,)"""
    force, speed = (values / max(float(np.abs(values).max()), 1e-300) for values in (force, speed))
    sizes = [np.abs(force * speed)]
    angles = np.linspace(0.0, 2.0 * math.pi, _DIRECTIONS, endpoint=False)
    sizes += [math.cos(angle) * force + math.sin(angle) * speed for angle in angles]
    sizes += [np.where(part * speed >= part**2, np.abs(force), -1.0) for part in (-0.75, -0.5, -0.25, 0.25, 0.5, 0.75)]
    return np.unique(np.argmax(sizes, axis=-1))


def evaluate(
    space: Space,
    points: Points,
    tasks: Sequence[Task],
    *,
    life: float | None,
    compiled: bool = True,
    demanded: Sequence[Demanded] | None = None,
) -> Wheels:
    """Evaluate wheel designs, whose heads must be of one kind.

    Parameters
    ----------
    life : float      Wanted life of axle and cylinder bearings in each motion; None: any. [s]
    compiled : bool   Whether to use what the space has compiled.
    demanded          What each task asks of them, where it is known.
    """
    count, drive = len(points.head), space.columns(points)
    demands: dict[TaskDemand, np.ndarray] = {}
    shafts, slipping = {}, np.zeros(count)
    for place, task in enumerate(tasks):
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            if demanded is not None:
                one = demanded[place]
            elif compiled and space.compiled is not None:
                one = space.compiled.ask(points, task)
            else:
                one = ask(drive, task)
            found = _demands(drive, task, one, life)
        shaft = _shaft(drive, task, one)
        shafts[task.name] = shaft
        lost = np.isnan(np.asarray(one.torque))
        slipping += np.mean(np.broadcast_to(lost, (count, lost.shape[-1])), axis=-1) / len(tasks)
        demands |= {
            (task.name, *key): np.broadcast_to(np.where(np.isnan(demand), np.inf, demand), (count,))
            for key, demand in found.items()
        }
    return Wheels(demands=demands, slipping=slipping, shafts=shafts)


class Demanded(NamedTuple):
    """What a task asks of wheel designs, by the laws of the drive; arrays of any library."""

    torque: Array
    """Of the cylinder. [N m]"""
    utilisation: Mapping[Limit, Array]
    """Of the wheel, in a required region also of springs and linkages. [-]"""
    rate: Array = 0.0
    """Of the steering angle. [rad s^-1]"""
    acceleration: Array = 0.0
    """[rad s^-2]"""
    moment: Array | None = None
    """Of the rolling patch against steering. [N m]"""
    patch: Array = 0.0
    """Friction torque of a patch that turns on the spot. [N m]"""
    bell: Array = 0.0
    """Friction torque of the bell's bearing. [N m]"""
    rolling: Array = 0.0
    """Mean loss by hysteresis. [W]"""
    inertia: Array = 0.0
    """Of bell and wheel about the steering axis. [kg m^2]"""
    held: Array = math.inf
    """Revolutions that the cylinder's bearings reach under the loads of the motion."""

    def of(self, places: np.ndarray) -> Demanded:
        """Of some of many designs."""

        def some(part: Any) -> Any:
            return part[places] if np.ndim(part) else part

        utilisation = {limit: some(demand) for limit, demand in self.utilisation.items()}
        return self._replace(
            **{name: some(part) for name, part in self._asdict().items() if name != "utilisation" and part is not None},
            utilisation=utilisation,
        )


class Look(NamedTuple):
    """What tells whether it is worth while to roll wheel designs; arrays of any library."""

    static: Mapping[Limit, Array]
    """Demand over allowance of the limits that the preload alone can exceed. [-]"""
    shape: Array
    """See `shape_excess`. [-]"""
    demanded: tuple[Demanded, ...]
    """By the critical instants of each task."""


def look(drive: CoboticDrive, tasks: Sequence[Task]) -> Look:
    """The first look at wheel designs, one or many, by the critical instants of tasks."""
    return Look(dict(drive.transmission.utilisation), shape_excess(drive), tuple(ask(drive, task) for task in tasks))


def ask(drive: CoboticDrive, task: Task) -> Demanded:
    """What a task asks of wheel designs, one or many."""
    if isinstance(task, RegionTask):
        point = drive.operate(speed=task.speed, force=task.force)
        own = {key: demand for key, demand in point.utilisation.items() if key not in (*MOTOR_LIMITS, *GEAR_LIMITS)}
        return Demanded(point.states["cylinder_torque_Nm"], own)
    rolled = drive.roll(task.instants.course, load_mass=task.duty.moved_mass)
    assert drive.steering is not None
    resisting = drive.steering.friction_torques(drive.transmission)
    xp = namespace(rolled.torque)
    return Demanded(
        rolled.torque,
        dict(rolled.utilisation),
        rolled.steering.rate,
        rolled.steering.curvature,
        rolled.patch_moment,
        resisting["patch"],
        resisting["bell"],
        xp.mean(rolled.losses["rolling"], axis=-1),
        drive.steering.inertia_of_bell,
        math.inf if rolled.held is None else drive.cylinder_bearings.life(rolled.held),  # type: ignore[union-attr]
    )


_TOGETHER = 32
"""Wheel designs of one call, the last padded: arrays of one shape are compiled once."""


class CompiledWheels:
    """The functions `ask` and `look` compiled for each task and kind of head, at the first call."""

    def __init__(self, space: Space) -> None:
        """Raises InputError if JAX is not installed."""
        self._space, self._jax = space, extras.load("jax", "jax", "method jax")
        self._known: dict[tuple[int, ...], Callable[..., Any]] = {}
        self._tasks: list[Task] = []

    def ask(self, points: Points, task: Task) -> Demanded:
        """As `ask` for designs whose heads are of one kind, in NumPy arrays (k, n)."""
        return self._all(points, (-1, self._place(task)), lambda drive: ask(drive, task))

    def look(self, points: Points, tasks: Sequence[Task]) -> Look:
        """As `look` for designs whose heads are of one kind, in NumPy arrays (k, n) and (k, 1)."""
        return self._all(points, tuple(map(self._place, tasks)), lambda drive: look(drive, tasks))

    def _place(self, task: Task) -> int:
        """Number of a task, by identity."""
        if not any(task is one for one in self._tasks):
            self._tasks.append(task)
        return next(place for place, one in enumerate(self._tasks) if one is task)

    def _all(self, points: Points, key: tuple[int, ...], law: Callable[[CoboticDrive], Any]) -> Any:
        """A law of every design, some of them at a time."""
        run, numbers = self._law(int(points.head[0]), key, law), self._space.numbers(int(points.head[0]))
        count = len(points.head)

        def some(start: int) -> Any:
            # What pads the last call is computed and left out.
            places = np.minimum(np.arange(start, start + _TOGETHER), count - 1)
            return run(points.values[places], *(column[points.head[places]] for column in numbers.values()))

        parts = list(in_order(some, range(0, count, _TOGETHER)))
        return self._jax.tree.map(lambda *some: _of_all_calls(some, count), *parts)

    def _law(self, head: int, key: tuple[int, ...], law: Callable[[CoboticDrive], Any]) -> Callable[..., Any]:
        """A law compiled for the kind of a head."""
        kind = int(self._space.kinds[head])
        if (kind, *key) not in self._known:
            names = tuple(self._space.numbers(head))

            def one(values: Any, *numbers: Any) -> Any:
                given = {name: values[place] for place, name in enumerate(FREE)}
                return law(self._space.drive(given, kind, dict(zip(names, numbers, strict=True))))

            shapes = [(_TOGETHER, len(FREE)), *((_TOGETHER,) for _ in names)]
            try:
                self._known[kind, *key] = engine.compiled(self._jax.vmap(one), shapes)
            except engine.NotCompiledError as problem:
                raise InputError(f"method jax cannot be used here: {problem}; use numpy") from None
        return self._known[kind, *key]


def _of_all_calls(parts: tuple[Any, ...], count: int) -> np.ndarray:
    """Results of all calls, (k, n), or (k, 1) for what is one number a design."""
    whole = np.concatenate(parts)[:count]
    return whole[:, None] if whole.ndim == 1 else whole


def _demands(drive: CoboticDrive, task: Task, demanded: Demanded, life: float | None) -> dict[Demand, np.ndarray]:
    """Largest demands on the wheel, and on what lies between it and the load."""
    limits: dict[Demand, Any] = {(limit, part_of(limit)): demand for limit, demand in demanded.utilisation.items()}
    if isinstance(task, MotionTask):
        limits |= drive.inward(task.instants.course, task.duty.moved_mass).utilisation
    # All of these limits apply to the peak, in motion as well.
    found = {key: np.max(demand, axis=-1) if np.ndim(demand) else np.asarray(demand) for key, demand in limits.items()}
    if isinstance(task, MotionTask):
        if task.travel is not None:
            found[Limit.TRAVEL, "load"] = np.asarray(np.ptp(task.instants.position) / task.travel)
        if life is not None:
            found[Limit.LIFE, AXLE] = _life(drive, np.asarray(demanded.rolling), life)
            turns = np.ravel(np.abs(drive.cylinder_speed)) * life / (2.0 * math.pi)
            found[Limit.LIFE, SUPPORT] = (turns / np.ravel(demanded.held)) ** (1.0 / 3.0)
    return found


def _shaft(drive: CoboticDrive, task: Task, demanded: Demanded) -> Shaft:
    """What the motors have to give, as arrays by design and instant."""
    turning = np.asarray(drive.cylinder_speed)
    count = len(turning)
    if isinstance(task, RegionTask):
        nothing, still = np.empty((count, 0)), np.zeros((count, 1))
        torque = np.broadcast_to(demanded.torque, (count, len(task.speed)))
        if drive.amplifier.regeneration != "none":
            # At one speed, current and voltage rise with the torque: a nan, or the ends, are all that any motor can notice.
            torque = np.stack([torque.min(axis=-1), torque.max(axis=-1)], axis=-1)
        return Shaft(turning, torque, nothing, nothing, still, still, None, still)
    shape = count, len(task.instants.time)
    torque, rate, acceleration = (
        np.broadcast_to(part, shape) for part in (demanded.torque, demanded.rate, demanded.acceleration)
    )
    patch, bell, inertia = (
        np.broadcast_to(part, (count, 1)) for part in (demanded.patch, demanded.bell, demanded.inertia)
    )
    moment = None if demanded.moment is None else np.broadcast_to(demanded.moment, shape)
    return Shaft(turning, torque, rate, acceleration, patch, bell, moment, inertia)


def _life(drive: CoboticDrive, rolling_loss: np.ndarray, life: float) -> np.ndarray:
    """Cube root of the revolutions wanted over those that 90 % of axles reach, under the loads of their friction. (k,)

    Source: iso2007.
    """
    element = drive.transmission
    assert element.geometry is not None
    groups, share = element.groups(drive.cylinder_speed), element.geometry.lateral_share
    turning = np.ravel(rolling_loss) / np.ravel(groups.rolling_torque)
    reached = element.geometry.axle.life(
        element.preload, share * groups.slip_force / element.wheels, element.wheel_radius
    )
    return (turning * life / (2.0 * math.pi) / np.ravel(reached)) ** (1.0 / 3.0)
