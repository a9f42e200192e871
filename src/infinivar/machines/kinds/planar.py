r"""A cart on steered wheels as a drive: pushed along the motion by a user or a slide, or driven by motors on its axles.

With the twist :math:`\xi` of the cart and the wrench W that it exerts on its load, the source supplies a wrench S. The wheels
hold what acts across it,

.. math:: Q = W - S, \qquad S \cdot \xi = W \cdot \xi + \sum \mathrm{loss}

and are steered so. A user or a slide pushes so that S does no work on any motion at a right angle to :math:`\xi`,
:math:`B_\perp^T S = 0`, with right angles in the metric in which a turn counts as the rms velocity that it gives the wheels.
Where no steering balances the forces so, as on two wheels that turn about a point on their line, :math:`B_\perp^T S` is that
which overcomes the rolling resistance of the wheels: it does no work, either.

Motors make S of tractions along the headings, :math:`S = \sum_k A_k^T e_k \tau_k/r`, with the same torque :math:`\tau` on each
driven axle. Headings and torque follow from W; see `infinivar.transmission.driven_body.hauling`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array
from infinivar._core.bounds import FINITE
from infinivar._core.fields import brief, check, component, given, quantities, quantity, several
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.machines.axles import Axles, Rolled, at_instant, steered, turned, turned_along
from infinivar.machines.course import CREEPING, MachineCourse
from infinivar.machines.kind import MachineDrive
from infinivar.machines.kinds.driven_motion import DrivenMachine, scenario_along
from infinivar.machines.kinds.planar_motion import PlanarMachine, PlanarMechanics
from infinivar.machines.machine import TaskPoint, lacking_of_drive, rows, worst
from infinivar.machines.pictures import wheeled
from infinivar.machines.pictures.strokes import Picture
from infinivar.machines.rolling import RollingState, creep_ratio
from infinivar.machines.supply import fed, source_of
from infinivar.machines.wheel import Wheel
from infinivar.motion.vectors import Point
from infinivar.parts.battery import Battery
from infinivar.transmission.driven_body import hauling
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.mechanism import Mechanism, MechanismPoint
from infinivar.transmission.planar import PlanarCarriage, PlanarCobot, pushed

_STANDING = 1e-9
"""Speed of a wheel over that of the fastest one, below which it stands."""

_BEGINS = 1e-12
"""Time for which a driven cart at rest has accelerated where it begins to move. [s]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanarDrive(MachineDrive):
    """A cart on steered wheels, or a carriage that slides along x and y on one, pushed along its motion or driven by motors."""

    WORD: ClassVar[str] = "planar"
    held_time: ClassVar[float] = 1.0
    wheel: Wheel = component("The wheels, all alike")
    positions: tuple[Point, ...] | None = several(
        "Points of two wheels or more, in axes of the cart; without them, a carriage that does not turn, on one wheel",
        Point,
        only=("x", "y"),
        default=None,
    )
    drive: ConventionalDrive | None = component(
        "Drive of each driven axle, with a motor of its own; without it a user or a slide pushes the cart", default=None
    )
    driven_wheels: tuple[float, ...] | None = quantities(
        "1", FINITE, "Numbers of the wheels that drives turn, counted from 1; by default all", default=None
    )
    pulley_radius: float | None = quantity(
        "m",
        Gt(0),
        "Radius of the pulley by which a linear drive turns an axle; by default that of the wheel",
        default=None,
    )
    battery: Battery | None = component("Battery that feeds drives and servos", default=None)
    largest_push: float | None = quantity(
        "N", Gt(0), "Largest force along the motion of a user or slide that pushes the cart", default=None
    )
    largest_speed: float | None = quantity(
        "m/s", Gt(0), "Largest permissible speed of any wheel's centre", default=None
    )
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
        self._check_drive()
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

    def _check_drive(self) -> None:
        """Raise ParameterError for a field that does not fit the source."""
        if self.drive is not None:
            require(
                self.largest_push is None,
                "largest_push",
                f"{self.largest_push} N",
                "left out: drive, not a user, moves the cart",
            )
        for name in ("driven_wheels", "pulley_radius", "battery"):
            if self.drive is None and getattr(self, name) is not None:
                raise ParameterError(f"{name} does not apply without drive: a user or a slide pushes the cart")
        count, places = 1 if self.positions is None else len(self.positions), self.driven_wheels
        if places is not None:
            fits = bool(places) and set(places) <= set(range(1, count + 1)) and len(set(places)) == len(places)
            said = ", ".join(f"{one:g}" for one in places) or "none"
            require(fits, "driven_wheels", said, f"different numbers of wheels, from 1 to {count}")

    @property
    def source(self) -> str:  # type: ignore[override]
        """What feeds it."""
        return "push" if self.drive is None else source_of(self.battery)

    @property
    def session(self) -> tuple[str, ...]:  # type: ignore[override]
        """Keys of a session, which a cart has that a user pushes."""
        return ("handle",) if self.drive is None else ()

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work besides those of all machines."""
        simulated, sized = self.drive is not None, self.wheel.geometry is not None
        return ("simulate",) * simulated + ("size",) * sized

    @property
    def unmoved(self) -> str:  # type: ignore[override]
        """How it does not move in `infinivar simulate`."""
        return "a user pushes it: state a task with a type, and run it with infinivar session"

    @property
    def shown(self) -> str:  # type: ignore[override]
        """What its picture shows."""
        moved = "of the user or slide that pushes it" if self.drive is None else "the tractions of its motors"
        return f": wheels along their headings, and the forces on the machine: those of the ground, {moved}, and of its load."

    @property
    def driven(self) -> np.ndarray:
        """Places of the driven wheels, from 0."""
        count = self.mechanism.wheels
        places = range(1, count + 1) if self.driven_wheels is None else self.driven_wheels
        return np.array([int(one) - 1 for one in sorted(places)] if self.drive is not None else [], dtype=int)

    @property
    def lever(self) -> float:
        """Radius over which a linear drive turns an axle. [m]"""
        return given(self.pulley_radius, self.wheel.wheel_radius)

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

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> PlanarMachine | DrivenMachine:
        """The cart with its inertia and the servos of its wheels, for `infinivar.session` and `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Moved with the reference point. [kg], [kg m^2]

        Raises
        ------
        ParameterError
            If it is a carriage, or lacks a value that motion needs.
        """
        if not isinstance(self.machine, PlanarCobot):
            raise ParameterError(
                "positions is missing: a carriage on one wheel does not move in time; state two wheels or more"
            )
        mass, inertia = needed(self.mass, "mass") + load_mass, needed(self.inertia, "inertia") + load_inertia
        body = replace(self.machine, mass=mass, inertia=inertia)
        control = CoboticControl() if self.control is None else self.control
        cart = PlanarMachine(cobot=body, steering=needed(self.steering, "steering"), control=control)
        if self.drive is None:
            return cart
        return DrivenMachine(cart=cart, drive=self.drive, axles=tuple(map(int, self.driven)), lever=self.lever)

    @property
    def scenario(self) -> Any:
        """See `scenario_along`; a cart that a user pushes has none."""
        if self.drive is None:
            raise AttributeError(self.unmoved)
        return scenario_along

    def metric(self) -> np.ndarray:
        """Lengths by which the rates are multiplied to compare them, (d,): 1 for velocities, a radius for turning. [m]"""
        if not isinstance(self.machine, PlanarCobot):
            return np.ones(2)
        points = np.array(self.machine.positions)
        return np.array([1.0, 1.0, float(np.sqrt(np.mean(np.sum(points * points, axis=1)))) or 1.0])

    def operated(self, twist: Array, wrench: Array, steering_rate: Array = 0.0) -> MechanismPoint:
        """The wheels under a twist and a wrench on the load, steered for what the source does; see the module.

        Parameters
        ----------
        twist, wrench : (..., d) float
        steering_rate : (..., k) float   Of the headings, if drives turn the axles. [rad s^-1]

        Returns
        -------
        MechanismPoint   In the coordinates of the cart and, if drives turn them, of its axles; nan where the cart rests, a wheel
            would slip, or wheels do not hold what acts across the motion.
        """
        xi, load = np.broadcast_arrays(np.asarray(twist, dtype=float), np.asarray(wrench, dtype=float))
        xi = self._off_wheels(xi)
        if self.drive is not None:
            motors = np.isin(np.arange(self.mechanism.wheels), self.driven)
            return hauling(self.mechanism, xi, load, motors, steering_rate)
        return pushed(self.mechanism, self.metric(), xi, load)

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
            rolled, force = float(found.rolling_speed[index]), float(found.lateral_force[index])
            creepage = creep_ratio(found.creep_speed[index], rolled)
            if self.drive is not None:  # both directions together, as across the wheel
                creepage = float(DrivenContact.of(wheel).creepage(force))
            yield RollingState(
                name=f"wheel {index + 1}",
                law=wheel.creep_law,
                groups=wheel.groups(0.0 if math.isnan(rolled) else abs(rolled)),
                lateral_force=force,
                creepage=creepage,
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
        """As `infinivar.machines.machine.Machine.perform`; power in is that of the push, or of the supply of the motors.

        At rest locked wheels hold by static friction, which is judged for wheels across the load.
        """
        _, xi, load = rows(self, pose, twist, wrench)
        point = self.operated(xi, load)
        axles = None if self.drive is None else turned(self.drive, self.lever, *self._turning(point, xi))
        return fed(self._point(xi, load, point, axles), self.battery)

    @property
    def lacking(self) -> Mapping[str, str]:
        """What of its motion `follow` does not count, with the reason."""
        found = {} if self._carries else {"moving masses": f"{'mass' if self.mass is None else 'inertia'} is missing"}
        found |= {} if self.drive is None else lacking_of_drive(self.drive)
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
        """Whether `follow` counts more than `perform`: steering, rotors or mass of a cart that moves."""
        return course.moves and (self._carries or "steering" not in self.lacking or self._rotors)

    @property
    def _rolls(self) -> tuple[Any, ...]:
        """What decides how the wheels roll along a course."""
        return self.wheel, self.positions, self.driven_wheels, self.drive is None, self.mass, self.inertia, self.lacking

    @property
    def _rotors(self) -> bool:
        """Whether the rotors of drives count."""
        return self.drive is not None and "rotors" not in self.lacking

    def carried(self, course: MachineCourse) -> Rolled:
        """What carts along a course may have in common: wheels that roll alike under the same forces."""
        return Rolled(course, [])

    def follow(self, course: MachineCourse) -> TaskPoint:
        """See `along`."""
        return self.along(self.carried(course))

    def along(self, carried: Rolled) -> TaskPoint:
        """Operation along a course with the inertia of the cart, which the source accelerates, of rotors on driven axles, and
        with the servos of its wheels.

        The headings are those of steady operation under the forces of the motion; where wheels
        turn on the spot between two motions, that is not counted. Power in is that of the push, or of the supply of the motors,
        and of the servos.

        Source: Newton and Euler in turning axes; faulring2006, Fig 11, for the servos.
        """
        course = carried.course
        xi, acceleration, wrench = np.broadcast_arrays(course.twist, course.acceleration, course.wrench)
        if self.drive is not None:  # a cart that begins to move rolls the way it accelerates
            xi = np.where(np.any(xi != 0.0, axis=-1, keepdims=True), xi, _BEGINS * acceleration)
        load = wrench + self._carried(xi, acceleration)
        steers = "steering" not in self.lacking
        # Rates of axles need all five instants, those of steering three.
        around = slice(5) if self.drive is not None else slice(1, 4) if steers else slice(2, 3)
        points = carried.points(self._rolls, lambda: self.operated(xi[around], load[around]))
        headings = np.unwrap(np.asarray(points.heading), axis=0, period=np.pi)
        rate, rise = self._steering_rates(course, headings) if steers else (np.zeros(()), np.zeros(()))
        spun = rate if self.mechanism.kinds[0][0].turns_with_spin else 0.0
        if self.drive is not None:
            point = self.operated(xi[2], load[2], spun) if np.any(spun) else at_instant(points, 2)
            axles = self._along(course, points, headings, xi, point)
        else:
            place, axles = len(headings) // 2, None
            at = np.asarray(points.cosine)[place], np.asarray(points.sine)[place]
            point = self.mechanism.operate(rates=self._off_wheels(xi[2]), heading=at, steering_rate=spun)
        found = self._point(xi[2], load[2], point, axles)
        stored = {"machine": np.sum((load[2] - wrench[2]) * xi[2], axis=-1), **found.stored}
        found = replace(found, power_out=np.sum(wrench[2] * xi[2], axis=-1), stored=stored)
        if self.steering is not None and steers:
            contact = self.mechanism.kinds[0][0]
            moment = np.where(np.any(xi[2] != 0.0, axis=-1)[..., None], np.asarray(point.moment), 0.0)
            rolls = contact.turns_with_spin  # then the spin of the wheels has the friction of the patch
            found = steered(found, self.steering, contact, rate, rise, moment if rolls else None)
        return fed(found, self.battery)

    @staticmethod
    def _steering_rates(course: MachineCourse, headings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rate and acceleration of headings (5, ..., k) that do not creep by rounding."""
        angle = course.varying(headings)
        rate, rise = np.nan_to_num(angle.rate), np.nan_to_num(angle.curvature)
        turns = np.abs(rate) > CREEPING
        return np.where(turns, rate, 0.0), np.where(turns, rise, 0.0)

    def _turning(self, point: MechanismPoint, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Torques of the motors on the driven axles, and their speeds, (..., n) each; 0 at rest. [N m], [rad s^-1]"""
        places = len(self.coordinates) + self.driven
        still = ~np.any(xi != 0.0, axis=-1)[..., None]
        torque, speed = -np.asarray(point.applied)[..., places], np.asarray(point.rates)[..., places]
        return np.where(still, 0.0, torque), np.where(still, 0.0, speed)

    def _along(
        self, course: MachineCourse, points: MechanismPoint, headings: np.ndarray, xi: np.ndarray, point: MechanismPoint
    ) -> Axles:
        """Driven axles along a course from points at five instants, and from that with the rate of steering in their middle."""
        assert self.drive is not None
        # A heading that has turned by half a turn is the same wheel, which turns back.
        way = np.nan_to_num(np.cos(headings - np.asarray(points.heading)), nan=1.0)[..., self.driven]
        here = self._turning(point, xi[2])
        if not self._rotors:
            return turned(self.drive, self.lever, *here)
        torque, speed = (
            way * (five + middle - five[2]) for five, middle in zip(self._turning(points, xi), here, strict=True)
        )
        return turned_along(self.drive, self.lever, course, torque, speed)

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

    def _point(self, xi: np.ndarray, load: np.ndarray, point: MechanismPoint, axles: Axles | None) -> TaskPoint:
        """The cart under twists and wrenches (..., d), with its wheels and driven axles there."""
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
        lost: Any = sum(losses.values())
        demands: dict[Demand, np.ndarray] = worst({Limit.SLIP: slip}, parts)
        stored: dict[str, Any] = {}
        if axles is not None:
            power_in, states = (
                np.sum(axles.power_in, axis=-1),
                {"traction_N": np.sum(axles.torque, -1) / self.wheel.wheel_radius},
            )
            total |= {name: total.get(name, 0.0) + np.sum(loss, axis=-1) for name, loss in axles.losses.items()}
            demands |= worst(axles.demands, [f"motor {place + 1}" for place in self.driven])
            stored = {name: np.sum(one, axis=-1) for name, one in axles.stored.items()}
            lost[..., self.driven] += sum(axles.losses.values())
        else:
            speed = np.sqrt(np.sum((xi * self.metric()) ** 2, axis=-1))
            power_in = power_out - np.sum(np.where(zero, 0.0, np.asarray(point.power)), axis=-1)
            push = np.where(speed > 0, power_in / np.where(speed > 0, speed, 1.0), 0.0)
            states = {"push_N": push}
            if self.largest_push is not None:
                demands[Limit.OUTPUT_FORCE, "source, largest_push"] = np.abs(push) / self.largest_push
        if self.largest_speed is not None:
            fastest = np.max(self.part_speeds(xi, xi), axis=-1)
            demands[Limit.OUTPUT_SPEED, "cart, largest_speed"] = fastest / self.largest_speed
        for limit, demand in point.pressed.items():
            demands[limit, "wheel"] = np.broadcast_to(demand, power_in.shape)
        return TaskPoint(
            power_in=power_in,
            power_out=power_out,
            losses=total,
            demands=demands,
            parts=parts,
            part_losses=lost,
            part_forces=np.where(zero, shares * 0.0, np.asarray(point.lateral_force)),
            part_speeds=np.where(zero, 0.0, np.asarray(point.rolling_speed)),
            steering=np.asarray(point.heading),
            states=states,
            stored=stored,
        )

    def _shared(self, load: np.ndarray) -> np.ndarray:
        """Forces of the wheels that hold a load at rest, of the smallest sum of squares: (..., k, 2)."""
        carriers = np.asarray(self.mechanism.jacobian).reshape(-1, load.shape[-1])
        found = np.matmul(np.linalg.pinv(carriers.T), load[..., None])[..., 0]
        return found.reshape(*load.shape[:-1], self.mechanism.wheels, 2)
