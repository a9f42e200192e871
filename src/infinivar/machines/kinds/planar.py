r"""A cart on steered wheels as a drive: the source pushes along the motion, and the wheels hold what acts across it.

With the twist :math:`\xi` of the cart and the wrench W that it exerts on its load, the source supplies a wrench S that does no
work on any motion at a right angle to :math:`\xi`. The wheels exert Q, and are steered so that the forces on those motions
balance:

.. math:: Q = W - S, \qquad B_\perp^T S = 0, \qquad S \cdot \xi = W \cdot \xi + \sum \mathrm{loss}

with right angles in the metric in which a turn counts as the rms velocity that it gives the wheels. A cart that a user pushes and
one with a motor differ only in what the source is. Where no steering balances the forces so, as on two wheels that turn about a
point on their line, :math:`B_\perp^T S` is that which overcomes the rolling resistance of the wheels: it does no work, either.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar._core.fields import brief, check, component, given, quantity, several
from infinivar.bondgraph.graph import Parameter, Signal
from infinivar.bondgraph.recorded import vector
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.machines import bonds
from infinivar.machines.control.loops import following_path
from infinivar.machines.control.tasks import guide_of_wheels
from infinivar.machines.course import CREEPING, MachineCourse
from infinivar.machines.hand import BodyGrip, Grip
from infinivar.machines.kind import MachineDrive, MovingMachine, servo_of
from infinivar.machines.machine import TaskPoint, rows, worst
from infinivar.machines.motors import SteeringServo
from infinivar.machines.pictures import wheeled
from infinivar.machines.pictures.strokes import Picture
from infinivar.machines.pictures.wheeled import Wheeled
from infinivar.machines.rolling import ROLLING_LOSSES, RollingState, creep_ratio, judged, slip_demands
from infinivar.machines.system import Defaults, Forces, Place, SteeringLaw
from infinivar.machines.wheel import Wheel
from infinivar.motion.histories import VectorHistory
from infinivar.motion.vectors import Point
from infinivar.parts.amplifier import Amplifier
from infinivar.transmission.mechanism import Mechanism, MechanismPoint
from infinivar.transmission.planar import PlanarCarriage, PlanarCobot
from infinivar.transmission.rolling_contact import RollingContact

_STANDING = 1e-9
"""Speed of a wheel over that of the fastest one, below which it stands."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarMechanics(Defaults):
    """A body on steered wheels, in its own axes; the configuration is its pose in the plane."""

    cobot: PlanarCobot
    stick_speed: float
    coordinates: tuple[str, ...] = ("v_x_m_s", "v_y_m_s", "w_rad_s")
    configuration: tuple[str, ...] = ("x_m", "y_m", "angle_rad")
    losses: tuple[str, ...] = ROLLING_LOSSES
    _inertia: np.ndarray = field(init=False, repr=False, compare=False, default_factory=lambda: np.zeros((1, 3, 3)))

    def __post_init__(self) -> None:
        """Compute what does not change."""
        mass, moment = float(self.cobot.mass), float(self.cobot.inertia)  # type: ignore[arg-type]
        object.__setattr__(self, "_inertia", np.diag([mass, mass, moment])[None])

    @property
    def inertia(self) -> np.ndarray:
        """Mass matrix in axes of the body. (3, 3)"""
        return self._inertia[0]

    @property
    def steered(self) -> tuple[str, ...]:
        """Headings of the wheels."""
        return tuple(f"h_{place + 1}_rad" for place in range(self.cobot.mechanism.wheels))

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each wheel."""
        return slip_demands(self.cobot.mechanism.wheels, "wheel")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Inertia, and the force that turns a velocity in turning axes."""
        cosine, sine = np.cos(configuration[:, 2]), np.sin(configuration[:, 2])
        x, y, turning = rates[:, 0], rates[:, 1], rates[:, 2]
        changes, bias = np.empty_like(rates), np.zeros_like(rates)
        changes[:, 0], changes[:, 1], changes[:, 2] = cosine * x - sine * y, sine * x + cosine * y, turning
        whirled = self._inertia[0, 0, 0] * turning
        bias[:, 0], bias[:, 1] = -whirled * y, whirled * x
        return Place(changes, self._inertia, bias, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the wheels."""
        heading = np.cos(angles), np.sin(angles)
        found, exerted = self.cobot.mechanism.forces(rates, heading, turning, self.stick_speed)
        resisting = found.moment + 0.0 * angles
        return Forces(exerted, resisting, *judged(found.losses, found.slip_demand))

    def rates_of(self, configuration: np.ndarray, change: np.ndarray) -> np.ndarray:
        """In axes of the body."""
        (c,), (s,) = np.cos(configuration[2:]), np.sin(configuration[2:])
        x, y, turning = change
        return vector(c * x + s * y, c * y - s * x, turning)

    def grip(self, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
        """A point of the body."""
        point = real_array("handle", handle)
        fits = point.shape == (2,) and bool(np.all(np.isfinite(point)))
        require(fits, "handle", f"{handle}", "x and y, two finite numbers", "m")
        return BodyGrip(point=(float(point[0]), float(point[1])))

    def held_at(self, configuration: np.ndarray, position: np.ndarray) -> np.ndarray:
        """In axes of the body."""
        away, angle = position - configuration[:2], configuration[2]
        cosine, sine = np.cos(angle), np.sin(angle)
        return np.array([cosine * away[0] + sine * away[1], cosine * away[1] - sine * away[0]])

    def outline(self) -> Wheeled:
        """Body and wheels."""
        return Wheeled(
            spots=np.array(self.cobot.positions),
            radii=np.array([float(one.wheel_radius) for one in self.cobot.contacts]),  # type: ignore[union-attr]
            mass=float(given(self.cobot.mass, 0.0)),
            inertia=float(given(self.cobot.inertia, 0.0)),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanarMachine(MovingMachine):
    """A planar cobot with servos on its wheels, moved by a user.

    Raises
    ------
    ParameterError
        If the cobot has no mass or inertia.
    """

    cobot: PlanarCobot = component("Body and wheels")
    steering: SteeringPlant | None = component("Servo of each wheel", default=None)
    amplifier: Amplifier = component("Amplifier of the servos", default_factory=Amplifier)
    control: CoboticControl = component("Controllers", default_factory=CoboticControl)

    pushed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for name in ("mass", "inertia"):
            needed(getattr(self.cobot, name), f"cobot.{name}")

    @property
    def home(self) -> np.ndarray:
        """Pose in the plane at the start."""
        return np.zeros(3)

    def mechanics(self, stick_speed: float) -> PlanarMechanics:
        """Contacts and inertia."""
        return PlanarMechanics(cobot=self.cobot, stick_speed=stick_speed)

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of each wheel."""
        wheel = self.cobot.contacts[0]  # type: ignore[index]
        return servo_of(self.steering, wheel, self.amplifier, stick_speed)

    @property
    def twisted(self) -> tuple[str, ...]:
        """All."""
        return "x", "y", "angle"

    @property
    def contacts(self) -> Sequence[RollingContact]:
        """The wheels."""
        return self.cobot.contacts  # type: ignore[return-value]

    def bonds(self, stick_speed: float) -> bonds.Bonds:
        """Body in its own axes, and wheels."""
        ports = ("v_x", "v_y", "w")
        inertia = self.mechanics(stick_speed).inertia
        body = bonds.inertias(
            [
                bonds.Coordinate("v_x", "v_x", "m_x", "m", "kg", "body"),
                bonds.Coordinate("v_y", "v_y", "m_y", "m", "kg", "body"),
                bonds.Coordinate("w", r"\omega", "I", "I", "kg m^2", "body"),
            ],
            inertia,
        )
        body.signals.append(Signal(name="turn", symbol=r"\omega", of="w"))
        mass = Parameter("m", float(inertia[0, 0]), "kg")
        turning = bonds.axes_that_turn("turning", r"-m\omega", ("v_x", "v_y"), "turn", mass, -1.0)
        wheels = bonds.wheels(self.cobot.mechanism, ports, stick_speed)
        return bonds.Bonds.of(body, turning, wheels, bonds.user(ports))

    def coast(self, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Headings of a body that moves."""
        if not np.any(rates):
            return angles
        found = np.asarray(self.cobot.headings(rates))
        return np.where(np.isfinite(found), found, angles)

    def follow(self, mechanics: Any, motion: VectorHistory | None, pose: np.ndarray, duration: float) -> SteeringLaw:
        """Headings along a motion."""
        if motion is None:
            raise ParameterError("motion is missing: steering = 'controlled' follows it")
        return following_path(self.cobot, motion, gain=2.0 * math.pi * self.control.link_bandwidth)

    def guide(self, task: Any) -> Any:
        """Guides of wheels that steer."""
        return guide_of_wheels(task)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarDrive(MachineDrive):
    """A cart on steered wheels, or a carriage that slides along x and y on one, pushed along its motion."""

    WORD: ClassVar[str] = "planar"
    session: ClassVar[tuple[str, ...]] = ("handle",)
    source: ClassVar[str] = "push"
    shown: ClassVar[str] = (
        ": wheels along their headings, and the forces on the machine: those of the ground, of the source that pushes it, and "
        "of its load."
    )
    unmoved: ClassVar[str] = "a user pushes it: state a task with a type, and run it with infinivar session"

    wheel: Wheel = component("The wheels, all alike")
    positions: tuple[Point, ...] | None = several(
        "Points of two wheels or more, in axes of the cart; without them, a carriage that does not turn, on one wheel",
        Point,
        only=("x", "y"),
        default=None,
    )
    largest_push: float | None = quantity("N", Gt(0), "Largest force of the source along the motion", default=None)
    mass: float | None = quantity(
        "kg", Gt(0), "Mass of the cart with its load; needed for motion in time", default=None
    )
    inertia: float | None = quantity(
        "kg m^2", Gt(0), "Moment of inertia of the cart about its origin; needed for motion in time", default=None
    )
    steering: SteeringPlant | None = component("Servo of each wheel; needed for motion in time", default=None)
    control: CoboticControl | None = component("Controllers of the servos; default: its defaults", default=None)
    machine: PlanarCobot | PlanarCarriage = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields and make the kinematic map."""
        check(self)
        try:
            contact = self.wheel.on("plane")
        except ParameterError as problem:
            raise ParameterError(f"wheel.{problem}") from None
        if self.positions is None:
            object.__setattr__(self, "machine", PlanarCarriage(contact=contact))
            return
        require(
            len(self.positions) >= 2, "positions", "one point", "of two wheels or more; leave it out for a carriage"
        )
        for place, point in enumerate(self.positions, 1):
            for name in point.beyond(("x", "y")):
                raise ParameterError(f"positions {place}: {name} does not apply to a point of a plane; remove it")
        points = [tuple(one.row(("x", "y"))) for one in self.positions]
        for place, point in enumerate(points):
            require(point not in points[:place], f"positions {place + 1}", "the same point twice", "different points")
        object.__setattr__(self, "machine", PlanarCobot(contacts=contact, positions=points))

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work besides those of all machines."""
        return () if self.wheel.geometry is None else ("size",)

    @property
    def mechanism(self) -> Mechanism:
        """The kinematic map over x, y and, with several wheels, the angle."""
        return self.machine.mechanism

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Of the cart's reference point, in its own axes."""
        return ("x", "y") if self.positions is None else ("x", "y", "angle")

    @property
    def home(self) -> tuple[float, ...]:
        """The origin; nothing depends on it."""
        return (0.0,) * len(self.coordinates)

    def moving(self) -> PlanarMachine:
        """The cart with its inertia and the servos of its wheels, for `infinivar.session` and `infinivar.simulate_machine`.

        Raises
        ------
        ParameterError
            If it is a carriage, or lacks a value that motion needs.
        """
        if not isinstance(self.machine, PlanarCobot):
            raise ParameterError(
                "positions is missing: a carriage on one wheel does not move in time; state two wheels or more"
            )
        body = replace(self.machine, mass=needed(self.mass, "mass"), inertia=needed(self.inertia, "inertia"))
        control = CoboticControl() if self.control is None else self.control
        return PlanarMachine(cobot=body, steering=needed(self.steering, "steering"), control=control)

    def metric(self) -> np.ndarray:
        """Lengths by which the rates are multiplied to compare them, (d,): 1 for velocities, a radius for turning. [m]"""
        if not isinstance(self.machine, PlanarCobot):
            return np.ones(2)
        points = np.array(self.machine.positions)
        return np.array([1.0, 1.0, float(np.sqrt(np.mean(np.sum(points * points, axis=1)))) or 1.0])

    def operated(self, twist: Array, wrench: Array) -> MechanismPoint:
        """The wheels under a twist and a wrench on the load, steered so that the source pushes along the motion only.

        Parameters
        ----------
        twist, wrench : (..., d) float

        Returns
        -------
        MechanismPoint   In the coordinates of the cart; nan where the cart rests, a wheel would slip, or wheels do not hold what
            acts across the motion.
        """
        xi, load = np.broadcast_arrays(np.asarray(twist, dtype=float), np.asarray(wrench, dtype=float))
        xi = self._off_wheels(xi)
        scale, d = self.metric(), xi.shape[-1]
        scaled = xi * scale
        size = np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
        moves = size > 0
        along = np.where(moves, scaled / np.where(moves, size, 1.0), np.eye(d)[0])
        # The reflection of the first axis onto the motion is orthogonal; its other columns are the motions across.
        mirror = along - np.eye(d)[0]
        square = np.sum(mirror * mirror, axis=-1)[..., None, None]
        turns = square > 1e-30
        basis = np.eye(d) - np.where(
            turns, 2.0 * mirror[..., :, None] * mirror[..., None, :] / np.where(turns, square, 1.0), 0.0
        )
        basis = basis / scale[:, None]
        own = self.mechanism
        jacobian = np.matmul(np.asarray(own.jacobian), basis[..., None, :, :])
        names = tuple(f"across {place}" for place in range(1, d))
        shared: dict[str, Any] = {"contacts": own.contacts, "coordinates": ("along", *names)}
        if own.spin is not None:
            shared["spin"] = np.matmul(np.asarray(own.spin), basis)
        turned = Mechanism(jacobian=jacobian, **shared)
        held = np.matmul(np.swapaxes(basis, -1, -2), load[..., None])[..., 0]
        rates = np.concatenate([np.where(moves, size, np.nan), np.zeros((*xi.shape[:-1], d - 1))], axis=-1)
        safe = np.where(moves, np.nan_to_num(rates), np.eye(d)[0])

        def steered(across: np.ndarray) -> MechanismPoint:
            heading = turned.steer(
                rates=safe, applied={name: across[..., place] for place, name in enumerate(names, 1)}
            )
            lost = np.where(moves, 1.0, np.nan)
            return own.operate(rates=xi, heading=(heading[0] * lost, heading[1] * lost))

        point = steered(held)
        fails = ~np.all(np.isfinite(np.asarray(point.slip_demand)), axis=-1, keepdims=True) & moves
        if not np.any(fails):
            return point
        # The push against the rolling resistance of each wheel, which has components across the motion.
        velocity = np.matmul(np.asarray(own.jacobian), np.where(moves, xi, 1.0)[..., None, :, None])[..., 0]
        ahead = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
        free = np.asarray(own.operate(rates=xi, heading=(ahead[..., 0], ahead[..., 1])).applied)
        across = held + np.matmul(np.swapaxes(basis, -1, -2), free[..., None])[..., 0]
        return steered(np.where(fails, across, held))

    def picture(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture:
        """Its wheels along their headings, which are free at rest."""
        if not np.any(twist):
            return wheeled.at_rest(self.machine, self.wheel.wheel_radius, wrench)
        return wheeled.picture(wheeled.steered(self.machine, self.operated(twist, wrench), wrench))

    def rolling(self, point: TaskPoint, twist: np.ndarray, wrench: np.ndarray) -> Iterator[RollingState]:
        """Yield the state of each wheel at an operating point; of a cart at rest, which does not roll, none."""
        if not np.any(twist):
            return
        found = self.operated(twist, wrench)
        for index, wheel in enumerate(self.mechanism.contacts):  # type: ignore[arg-type]
            rolled = float(found.rolling_speed[index])
            yield RollingState(
                name=f"wheel {index + 1}",
                law=wheel.creep_law,
                groups=wheel.groups(0.0 if math.isnan(rolled) else abs(rolled)),
                lateral_force=float(found.lateral_force[index]),
                creepage=creep_ratio(found.creep_speed[index], rolled),
                slip_demand=float(np.nan_to_num(found.slip_demand[index], nan=math.inf)),
                contact=wheel.contact,
                preload=wheel.preload,
                notes=(("heading from x", float(found.heading[index])),),
            )

    def _off_wheels(self, xi: np.ndarray) -> np.ndarray:
        """The twist, or one next to it if the cart turns about a wheel, which has a heading only in the limit."""
        speed = np.linalg.norm(np.matmul(np.asarray(self.mechanism.jacobian), xi[..., None, :, None])[..., 0], axis=-1)
        most = np.max(speed, axis=-1, keepdims=True)
        stands = np.any(speed < _STANDING * most, axis=-1, keepdims=True)
        return xi + np.where(stands, 2.0 * _STANDING * most, 0.0) * np.eye(xi.shape[-1])[0]

    def part_speeds(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Of the centres of the wheels. (..., k) [m s^-1]"""
        return np.linalg.norm(
            np.matmul(np.asarray(self.mechanism.jacobian), twist[..., None, :, None])[..., 0], axis=-1
        )

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`; power in is that of the push.

        At rest locked wheels hold by static friction, which is judged for wheels across the load.
        """
        _, xi, load = rows(self, pose, twist, wrench)
        return self._point(xi, load, self.operated(xi, load))

    @property
    def lacking(self) -> Mapping[str, str]:
        """What of its motion `follow` does not count, with the reason."""
        found = {} if self._carries else {"moving masses": f"{'mass' if self.mass is None else 'inertia'} is missing"}
        plant = self.steering
        if plant is None:
            return {"steering": "no steering plant is stated", **found}
        if plant.motor.rotor_inertia is None:
            return {"steering": "steering.motor.rotor_inertia is missing", **found}
        if self.wheel.geometry is None and plant.patch_half_length is None:
            return {"steering": "steering.patch_half_length is missing", **found}
        return found

    @property
    def _carries(self) -> bool:
        """Whether the mass of the cart is stated, and its moment of inertia if it turns."""
        return self.mass is not None and (self.inertia is not None or self.positions is None)

    def counts(self, course: MachineCourse) -> bool:
        """Whether `follow` counts more than `perform`: steering or mass of a cart that moves."""
        return course.moves and (self._carries or "steering" not in self.lacking)

    def follow(self, course: MachineCourse) -> TaskPoint:
        """Operation along a course with the inertia of the cart, which the source accelerates, and with the servos of its wheels.

        The headings are those of steady operation under the forces of the motion; where wheels
        turn on the spot between two motions, that is not counted. Power in is that of the push and of the servos.

        Source: Newton and Euler in turning axes; faulring2006, Fig 11, for the servos.
        """
        steers = "steering" not in self.lacking
        xi, acceleration, wrench = np.broadcast_arrays(course.twist[1:4], course.acceleration[1:4], course.wrench[1:4])
        load = wrench + self._carried(xi, acceleration)
        if not steers:
            found = self._point(xi[1], load[1], self.operated(xi[1], load[1]))
            return self._moved(found, xi[1], load[1], wrench[1])
        points = self.operated(xi, load)
        headings = np.unwrap(np.asarray(points.heading), axis=0, period=np.pi)
        angle = course.varying(headings)
        rate, rise = np.nan_to_num(angle.rate), np.nan_to_num(angle.curvature)
        turns = np.abs(rate) > CREEPING
        rate, rise = np.where(turns, rate, 0.0), np.where(turns, rise, 0.0)
        contact, plant = self.mechanism.kinds[0][0], self.steering
        assert plant is not None
        heading = np.asarray(points.cosine)[1], np.asarray(points.sine)[1]
        spun = rate if contact.turns_with_spin else 0.0
        point = self.mechanism.operate(rates=self._off_wheels(xi[1]), heading=heading, steering_rate=spun)
        still = ~np.any(xi[1] != 0.0, axis=-1)[..., None]
        moment = np.where(still, 0.0, np.asarray(point.moment)) if contact.turns_with_spin else None
        servo = plant.follow(contact, rate=rate, acceleration=rise, patch_moment=moment)  # type: ignore[arg-type]
        drawn, burnt, returned = Amplifier().supply(servo.power)
        lost = {**servo.losses, "steering amplifier": burnt}
        if moment is not None:
            del lost["steering patch"]  # the spin of the wheels has it
        shape = heading[0].shape
        lost = {name: np.broadcast_to(loss, shape) for name, loss in lost.items()}
        demands = {
            (limit, f"steering motor {place + 1}"): np.broadcast_to(demand, shape)[..., place]
            for limit, demand in {**servo.utilisation, **returned}.items()
            for place in range(shape[-1])
        }
        drawn = np.sum(np.broadcast_to(drawn, shape), axis=-1)
        found = self._moved(self._point(xi[1], load[1], point), xi[1], load[1], wrench[1])
        return replace(
            found,
            power_in=found.power_in + drawn,
            losses={**found.losses, **{name: np.sum(loss, axis=-1) for name, loss in lost.items()}},
            demands={**found.demands, **demands},
            part_losses=found.part_losses + sum(lost.values()),
            stored={**found.stored, "steering": np.sum(np.broadcast_to(servo.stored, shape), axis=-1)},
        )

    @property
    def steering_friction(self) -> float:
        """Torque at the bell of a wheel that stands; nan without a steering plant. [N m]"""
        if "steering" in self.lacking:
            return float("nan")
        return float(self.steering.coulomb_torque(self.mechanism.kinds[0][0]))  # type: ignore[union-attr, arg-type]

    def _carried(self, xi: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        """Wrench that accelerates the cart in its own axes, (..., d); 0 if its mass is not stated."""
        if not self._carries:
            return np.zeros(xi.shape)
        if self.positions is None:
            return self.mass * acceleration  # type: ignore[operator]
        body: Any = replace(self.machine, mass=self.mass, inertia=self.inertia)  # type: ignore[arg-type]
        rates = xi.reshape(-1, 3)
        place = PlanarMechanics(cobot=body, stick_speed=1.0).at(np.zeros(rates.shape), rates)
        return np.matmul(place.inertia[0], acceleration[..., None])[..., 0] + place.bias.reshape(xi.shape)

    @staticmethod
    def _moved(found: TaskPoint, xi: np.ndarray, load: np.ndarray, wrench: np.ndarray) -> TaskPoint:
        """The point, of whose power only that of the wrench goes to the load."""
        return replace(
            found, power_out=np.sum(wrench * xi, axis=-1), stored={"machine": np.sum((load - wrench) * xi, axis=-1)}
        )

    def _point(self, xi: np.ndarray, load: np.ndarray, point: MechanismPoint) -> TaskPoint:
        """The cart under twists and wrenches (..., d), with its wheels there."""
        k = self.mechanism.wheels
        parts = tuple(f"wheel {place + 1}" for place in range(k))
        still = ~np.any(xi != 0.0, axis=-1)
        slip = np.asarray(point.slip_demand)
        slip = np.where(np.isfinite(slip), slip, np.inf)
        # A wheel at rest carries its share of the load across its heading: the best that steering can do.
        shares = np.sqrt(np.sum(self._shared(load) ** 2, axis=-1)) / np.array(
            [float(one.slip_force) for one in self.mechanism.contacts]  # type: ignore[union-attr]
        )
        slip = np.where(still[..., None], shares, slip)
        zero = still[..., None]
        losses = {name: np.where(zero, 0.0, np.asarray(loss)) for name, loss in point.wheel_losses.items()}
        total = {name: np.sum(loss, axis=-1) for name, loss in losses.items()}
        power_out = np.sum(load * xi, axis=-1)
        speed = np.sqrt(np.sum((xi * self.metric()) ** 2, axis=-1))
        power_in = power_out - np.sum(np.where(zero, 0.0, np.asarray(point.power)), axis=-1)
        push = np.where(speed > 0, power_in / np.where(speed > 0, speed, 1.0), 0.0)
        demands: dict[Demand, np.ndarray] = worst({Limit.SLIP: slip}, parts)
        if self.largest_push is not None:
            demands[Limit.OUTPUT_FORCE, "source, largest_push"] = np.abs(push) / self.largest_push
        for limit, demand in point.pressed.items():
            demands[limit, "wheel"] = np.broadcast_to(demand, power_in.shape)
        return TaskPoint(
            power_in=power_in,
            power_out=power_out,
            losses=total,
            demands=demands,
            parts=parts,
            part_losses=sum(losses.values()),
            part_forces=np.where(zero, shares * 0.0, np.asarray(point.lateral_force)),
            part_speeds=np.where(zero, 0.0, np.asarray(point.rolling_speed)),
            steering=np.asarray(point.heading),
            states={"push_N": push},
        )

    def _shared(self, load: np.ndarray) -> np.ndarray:
        """Forces of the wheels that hold a load at rest, of the smallest sum of squares: (..., k, 2)."""
        carriers = np.asarray(self.mechanism.jacobian).reshape(-1, load.shape[-1])
        found = np.matmul(np.linalg.pinv(carriers.T), load[..., None])[..., 0]
        return found.reshape(*load.shape[:-1], self.mechanism.wheels, 2)
