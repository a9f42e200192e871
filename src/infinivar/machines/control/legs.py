r"""Admittance control of legs on a common cylinder: the handle moves as a virtual mass under the user's force.

.. math:: M_v \dot\xi = W - B\,\xi + A^T \lambda, \qquad A\,\xi = 0, \qquad \dot l = J\,(\xi + k\,(x_{ref} - x)), \qquad
    \phi_i = \mathrm{sgn}(\omega)\,\beta(f_i) - \arctan\frac{\dot l_i}{R\,\omega}

Constraints are rows A. The wheels' slip angles beta under the forces that they carry are fed forward. Where limits of the legs or
one-sided walls bind, the motion nearest to that in the metric of the virtual mass replaces it: a quadratic program in the free
directions.

Source: featherstone2008, chapter 3, for motion under constraints; `infinivar.transmission.legs`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check, component, given, quantity
from infinivar.bondgraph.recorded import Recorded, vector
from infinivar.bondgraph.scalars import signed
from infinivar.bondgraph.tape import Number
from infinivar.drivetrain.control.loops import turning_speed
from infinivar.errors import ParameterError
from infinivar.machines.control.controller import Law, Measured, Plant, Unremembering
from infinivar.machines.control.loops import Commands, largest
from infinivar.machines.control.planar import Surface
from infinivar.machines.hand import Held, PointGrip
from infinivar.machines.linkage import LeggedMechanics
from infinivar.motion.virtual.constrained import free_basis
from infinivar.motion.virtual.curves import Curve
from infinivar.motion.virtual.fixtures import Allowed
from infinivar.transmission.legs import least_creep_speed, least_surface_speed

_NEVER_SLIPS = 0.95
"""Most of the slip force for which a slip angle is fed forward, and of the steering range that is commanded."""

_ELSEWHERE = np.array([0.01, 0.02, 0.03])
"""From a position to another one, at which a fixture of fixed directions has the same rows. [m]"""

_STRICT = 1e-10
"""Tolerance of the limits in the quadratic program, in units of the free twist."""


class Rows(Protocol):
    """Constraints at a pose."""

    @property
    def rows(self) -> np.ndarray:
        """A. (k, d)"""
        ...


class Constraint(Protocol):
    """What a fixture allows, as rows on the twist of a machine."""

    def rows(self, coordinates: tuple[str, ...], position: Any = ..., twist: Any = None) -> Rows:
        """Rows at a position of the end point."""
        ...


def nearest_within(demanded: np.ndarray, limits: np.ndarray, least: np.ndarray, first: int = 0) -> np.ndarray:
    """The point nearest to the demanded one with ``limits @ point >= least``; where there is none, zero.

    Parameters
    ----------
    demanded : (d,) float       Coordinates in which distance is Euclidean.
    limits : (k, d) float
    least : (k,) float
    first : int         The first of the limits that are tried alone.

    Where one limit alone binds, the point is nearest on it. Recorded, it is nan where several bind.

    Source: a quadratic program, solved by the dual active-set method of daqp.
    """
    short = least - limits @ demanded
    alone = []
    for place in range(first, len(least)):
        row, others = limits[place], np.arange(len(least)) != place
        there = demanded + short[place] / (row @ row) * row
        alone.append((there, short[place] > 0.0, limits[others] @ there >= least[others]))
    if isinstance(short, Recorded):
        xp, found = short.__array_namespace__(), math.nan
        for there, binds, kept in alone:
            found = np.where(xp.all(np.append(kept, binds)), there, found)
        return np.where(xp.all(short <= 0.0), demanded, found)
    if np.all(short <= 0.0):
        return demanded
    for there, binds, kept in alone:
        if binds and np.all(kept):
            return there
    import daqp  # imported where limits bind

    found, _, flag, _ = daqp.solve(
        np.eye(len(demanded)),
        -np.ascontiguousarray(demanded),
        np.ascontiguousarray(limits),
        np.full(len(least), 1e30),
        np.ascontiguousarray(least),
        np.zeros(len(least), dtype=np.int32),
        primal_tol=_STRICT,
    )
    return np.asarray(found) if flag > 0 else np.zeros_like(demanded)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AdmittanceGuide:
    """The handle of a machine with legs on a common cylinder moves as a virtual mass, within a fixture and beside a wall.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    mass: float = quantity("kg", Gt(0), "Virtual mass at the handle, the same in all directions", default=2.0)
    damping: float = quantity("N s/m", Ge(0), "Virtual damping at the handle", default=0.0)
    inertia: float = quantity("kg m^2", Gt(0), "Virtual moment of inertia of a handle that turns", default=0.01)
    turning_damping: float = quantity("N m s/rad", Ge(0), "Virtual damping of its turning", default=0.0)
    constraint: Constraint | None = component("Fixture: with rows(coordinates, position, twist)", default=None)
    wall: Surface | None = component("One-sided wall: with distance(point) and normal(point)", default=None)
    ends: Curve | None = component("Open curve at whose ends the handle stops; None: it moves on", default=None)
    wall_time: float = quantity(
        "s", Gt(0), "Time constant with which the handle is slowed down to a wall or an end", default=0.02
    )
    gain: float | None = quantity(
        "1/s", Ge(0), "Gain of the pose error; by default 2 pi times control.link_bandwidth", default=None
    )
    slip_feedforward: bool = component("Whether slip angles of the wheels are fed forward", default=True)
    cylinder: Literal["set", "least loss"] = component(
        "Speed of the cylinder: as set, or that of the least creep loss at which no wheel slips", default="set"
    )
    slowest: float = quantity(
        "1", Interval(gt=0, le=1), "Lowest speed of the cylinder over that set, if it is chosen", default=0.1
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if self.constraint is not None and not hasattr(self.constraint, "rows"):
            raise ParameterError(f"constraint must have rows(coordinates, position, twist), got {self.constraint!r}")
        if self.ends is not None and not isinstance(self.ends, Curve):
            raise ParameterError(f"ends must be a curve, such as a PointCurve, got {self.ends!r}")
        for name in ("distance", "normal"):
            if self.wall is not None and not hasattr(self.wall, name):
                raise ParameterError(
                    f"wall must have distance and normal, but a {type(self.wall).__name__} has no {name}"
                )

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        mechanics = plant.mechanics
        if not isinstance(mechanics, LeggedMechanics):
            raise ParameterError(
                f"AdmittanceGuide moves legs on a common cylinder, not a {type(plant.machine).__name__}"
            )
        control: Any = plant.machine.control
        gain = given(self.gain, 2.0 * math.pi * control.link_bandwidth)
        return _Admittance(self, mechanics, plant, gain)


@dataclass(slots=True)
class _Admittance:
    """A virtual mass in a session."""

    settings: AdmittanceGuide
    mechanics: LeggedMechanics
    plant: Plant
    gain: float
    twist: np.ndarray | None = None
    """Of the virtual mass."""
    pose: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Where it is when the next command acts."""
    fixed: np.ndarray | None = None
    """Basis of the free twists, where it does not depend on the position."""

    @property
    def memory(self) -> list[np.ndarray]:
        """Twist and pose of the virtual mass."""
        assert self.twist is not None
        return [self.twist, self.pose]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        self.twist, self.pose = kept

    def __call__(self, measured: Measured) -> Commands:
        """Steering angles and rates, and the speed of the cylinder."""
        mechanics, period = self.mechanics, self.plant.period
        c, nu = measured.configuration, measured.rates[:-1]
        begins = self.twist is None
        if begins:
            self.twist, self.pose = nu.copy(), c.copy()
        assert self.twist is not None
        held = self.plant.grip.at(c[None], measured.rates[None])
        grip = held.jacobian[0][:, :-1]
        about = self._about(held, measured)
        push = grip.T @ measured.force
        if measured.moment.size:
            push = push + about.T @ measured.moment
        mass, damping = self._virtual(grip, about)
        demanded = self.twist + period * np.linalg.solve(mass, push - damping @ self.twist)
        free = self._free(measured, np.concatenate([grip, about]) if self.turns else grip, mass)
        place = mechanics.load.at(c[None], nu[None])
        jacobian = place.jacobian[0]
        back = self.gain * self._apart(c + (0.0 if begins else period) * self._changes(c, nu))
        radius, set_speed = mechanics.transmission.cylinder_radius, self.plant.machine.set_speed
        surface = radius * turning_speed(measured.rates[-1], set_speed)
        limits, least = self._limits(measured, grip, jacobian, free, back, surface)
        # Speeds of links bind rarely: they are not tried one by one.
        share = nearest_within(free.T @ mass @ demanded, limits, least, 2 * len(jacobian))
        acceleration = (free @ share - self.twist) / period
        self.twist = free @ share
        self.pose = self._moved(self.pose, (2.0 if begins else 1.0) * period * self.twist)
        # The pose error decays beside the virtual motion.
        speed = jacobian @ ((nu if begins else self.twist) + back)
        forces = self._forces(place, jacobian, push, acceleration)
        angles = -np.arctan(speed / surface) + self._slip_angles(forces, surface)
        changes = -(jacobian @ acceleration + place.bias[0]) / (surface * (1.0 + (speed / surface) ** 2))
        largest = _NEVER_SLIPS * mechanics.transmission.steering_range
        goal = np.clip(angles, -largest, largest)
        return Commands(
            steering=goal,
            steering_rate=np.where(np.abs(goal) < largest, changes, 0.0),
            speed=self._cylinder_speed(speed, forces),
        )

    @property
    def turns(self) -> bool:
        """Whether the machine has more coordinates than its handle directions, so that turning it is one."""
        return len(self.mechanics.load.coordinates) > len(self.plant.grip.axes)

    def _about(self, held: Held, measured: Measured) -> np.ndarray:
        """Jacobian of the handle's angular velocity; none where it neither is a coordinate nor turned by the user. (k, d)"""
        if not self.turns and not measured.moment.size:
            return np.zeros((0, len(self.mechanics.load.coordinates)))
        assert held.about is not None
        return held.about().jacobian[0][:, :-1]

    def _virtual(self, grip: np.ndarray, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Virtual mass and damping about the twist."""
        across = grip.T @ grip
        mass, damping = self.settings.mass * across, self.settings.damping * across
        if self.turns:
            turns = about.T @ about
            mass = mass + self.settings.inertia * turns
            damping = damping + self.settings.turning_damping * turns
        return mass, damping

    def _free(self, measured: Measured, ways: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """Basis of the free twists, orthonormal in the metric of the virtual mass; `ways` is the Jacobian of the handle."""
        constraint = self.settings.constraint
        if self.fixed is not None:
            return self.fixed
        if constraint is None:
            return np.linalg.solve(mass, np.linalg.cholesky(mass))  # the inverse of the factor, transposed
        position = np.append(measured.position[:3], np.zeros(3 - len(measured.position[:3])))
        rows = self._rows(position)
        found = free_basis(rows @ ways, mass)
        if isinstance(self.plant.grip, PointGrip) and isinstance(constraint, Allowed):
            elsewhere = self._rows(position + _ELSEWHERE)
            if elsewhere.shape == rows.shape and np.allclose(rows, elsewhere, rtol=0.0, atol=1e-12):
                self.fixed = found
        return found

    def _rows(self, position: np.ndarray) -> np.ndarray:
        """Of the constraint, at a position. (k, d)"""
        assert self.settings.constraint is not None
        grip = self.plant.grip
        axes = (*grip.axes, *grip.turns) if self.turns else grip.axes
        return np.asarray(self.settings.constraint.rows(axes, position, None).rows)

    def _limits(
        self,
        measured: Measured,
        grip: np.ndarray,
        jacobian: np.ndarray,
        free: np.ndarray,
        back: np.ndarray,
        surface: Number,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rows and least values for the free twist: speeds of the links, a wall, and ends of a path."""
        fastest = abs(surface) * math.tan(_NEVER_SLIPS * self.mechanics.transmission.steering_range)
        links = jacobian @ free
        drawn = jacobian @ back
        rows, least = [links, -links], [-fastest - drawn, drawn - fastest]
        wall = self.settings.wall
        if wall is not None:
            dimension = getattr(wall, "dimension", len(measured.position))
            ahead = measured.position + self.plant.period * measured.velocity
            at = ahead[:dimension]
            into = wall.normal(at) @ grip[:dimension]
            rows.append((into @ free)[None])
            least.append(vector(-wall.distance(at) / self.settings.wall_time - into @ back))
        ends = self.settings.ends
        if ends is not None and not ends.is_closed:
            dimension = ends.dimension
            here = ends.nearest((measured.position + self.plant.period * measured.velocity)[:dimension])
            along = here.tangent @ grip[:dimension]
            # What is past an end stays there, but moves no further.
            before = max(float(here.arc_length + here.beyond), 0.0)
            after = max(float(ends.length - here.arc_length - here.beyond), 0.0)
            rows.append(np.stack([along @ free, -along @ free]))
            there = float(along @ back)
            least.append(np.array([-before / self.settings.wall_time - there, there - after / self.settings.wall_time]))
        return np.concatenate(rows), np.concatenate(least)

    def _apart(self, pose: np.ndarray) -> np.ndarray:
        """Twist in unit time from a pose to that of the virtual mass."""
        return self.mechanics.load.apart(pose, self.pose)

    def _changes(self, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        return self.mechanics.load.changes(pose[None], twist[None])[0]

    def _moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """A pose after a small twist in unit time."""
        if not self.mechanics.load.turns:
            return pose + step
        half = pose + 0.5 * self._changes(pose, step)
        return pose + self._changes(half, step)

    def _forces(self, place: Any, jacobian: np.ndarray, push: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        """Forces of the wheels on the links, those of the smallest squares. (n,)"""
        mechanics = self.mechanics
        links = jacobian @ acceleration + place.bias[0]
        load = place.moved.inertia[0] @ acceleration + place.moved.bias[0] - push
        rubbing = mechanics.guideway_friction * np.clip(place.speed[0] / mechanics.stick_speed, -1.0, 1.0)
        return np.linalg.lstsq(jacobian.T, load, rcond=None)[0] + mechanics.link_mass * links + rubbing

    def _slip_angles(self, forces: np.ndarray, surface: Number) -> np.ndarray:
        if not self.settings.slip_feedforward:
            return np.zeros(len(forces))
        wheel = self.mechanics.transmission.wheel
        most = _NEVER_SLIPS * wheel.slip_force
        creepage = wheel.creepage(np.clip(-forces, -most, most), groups=wheel.groups(self.mechanics.surface_speed))
        return signed(1.0, surface) * np.arctan(creepage)

    def _cylinder_speed(self, speed: np.ndarray, forces: np.ndarray) -> Number:
        machine, transmission = self.plant.machine, self.mechanics.transmission
        if self.settings.cylinder == "set":
            return machine.set_speed
        held = np.minimum(np.abs(forces), _NEVER_SLIPS * transmission.slip_force)
        needed = np.maximum(least_creep_speed(speed), least_surface_speed(speed, held, transmission.slip_force))
        fastest = abs(machine.set_speed)
        chosen = largest(np.clip(needed / transmission.cylinder_radius, self.settings.slowest * fastest, fastest))
        return signed(chosen, machine.set_speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HoldGuide:
    """Holds the handle by wheels at the angle that locks them.

    With `stop_cylinder` nothing is commanded: the power motor is without current, and friction keeps the wheels. While the
    cylinder turns, the handle creeps under a force.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    stop_cylinder: bool = component("Whether the cylinder stands still", default=True)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    def begin(self, plant: Plant) -> Law:
        """The law of one session."""
        if not isinstance(plant.mechanics, LeggedMechanics):
            raise ParameterError(f"HoldGuide holds legs on a common cylinder, not a {type(plant.machine).__name__}")
        locked = np.zeros(len(plant.mechanics.steered))
        if self.stop_cylinder:
            return Unremembering(lambda measured: Commands())
        held = Commands(steering=locked, steering_rate=0.0 * locked, speed=plant.machine.set_speed)
        return Unremembering(lambda measured: held)
