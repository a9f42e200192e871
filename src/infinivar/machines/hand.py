r"""The user at a handle: forces, and an arm that grips it.

The handle is a point x(c) of the machine with velocity :math:`\dot x = G \nu`. An arm with mass m, damping b and stiffness k
grips it rigidly and pulls it towards an intention p(t):

.. math:: F = F_u(t) + k\,(p - x) + b\,(\dot p - \dot x) - m\,\ddot x, \qquad
    P_{user} = F_u \cdot \dot x + \left(k (p - x) + b (\dot p - \dot x)\right) \cdot \dot p ,

so that the mass moves with the machine, the spring stores :math:`\tfrac12 k |p - x|^2`, and the damper loses
:math:`b\,|\dot p - \dot x|^2`.

A hand may turn the handle as well: with a moment :math:`M_u(t)`, and an arm with a moment of inertia J, damping c and stiffness
:math:`\kappa`, the same about all axes, that wants the handle turned by the rotation P(t) from the start. With the rotation
vector :math:`\varphi` of the turn from the handle to there, :math:`\Omega` the angular velocity of P, and :math:`\omega` that of
the handle,

.. math:: M = M_u(t) + \kappa\,\varphi + c\,(\Omega - \omega) - J\,\dot\omega .

The spring stores :math:`\tfrac12\kappa |\varphi|^2`, whose rate is :math:`\kappa\,\varphi\cdot(\Omega - \omega)`, as
:math:`\varphi` is an eigenvector of the Jacobian of the rotation group. A moment acts on the body alone, wherever it is held.

Source: Newton and Euler; springs and dampers between two moving points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar.errors import ParameterError, require
from infinivar.machines.bodies import angular_velocity, turn_vector
from infinivar.motion.histories import VectorHistory
from infinivar.transmission.arm import PlanarArm
from infinivar.transmission.platform import rotation_matrix

_STEP = 1e-5
"""Half the time over which an intention without derivative is differenced. [s]"""


class Turned(NamedTuple):
    """How the handle is turned at m rows; k rotations, about one axis of the plane or three of space."""

    at: np.ndarray
    """Its angle (m, 1) [rad], or its axes as columns (m, 3, 3)."""
    jacobian: np.ndarray
    """Of its angular velocity. (m, k, N)"""
    bias: np.ndarray
    """Its angular acceleration without one of the rates. (m, k) [rad s^-2]"""

    def apart(self, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Turn from here to where a turn (m, k) from the start leads, in fixed axes and shorter than pi. (m, k) [rad]"""
        if goal.shape[-1] == 1:
            return start + goal - self.at
        return turn_vector(np.matmul(np.matmul(rotation_matrix(goal), start), np.swapaxes(self.at, -1, -2)))


class Held(NamedTuple):
    """The handle at m rows; d directions, N coordinates of the machine."""

    position: np.ndarray
    """x. (m, d) [m]"""
    jacobian: np.ndarray
    """G. (m, d, N)"""
    bias: Callable[[], np.ndarray]
    """Computes the acceleration of the handle without one of the rates. (m, d) [m s^-2]"""
    about: Callable[[], Turned] | None = None
    """Computes how it is turned, of a handle that turns."""


class Grip(Protocol):
    """Where the hand holds a machine."""

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the directions, fixed in space."""
        ...

    @property
    def turns(self) -> tuple[str, ...]:
        """Names of the rotations about fixed axes: rx, ry and rz, or angle; none of a handle that only slides."""
        ...

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle."""
        ...


def without_point(handle: Sequence[float]) -> None:
    """Raise ParameterError if a machine that is not held at any point is to be held at one."""
    require(not np.any(handle), "handle", f"{handle}", "left out: only a body in the plane is held at a point")


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyGrip:
    """A point of a body in the plane whose rates are in its own axes."""

    point: tuple[float, float] = (0.0, 0.0)
    """In axes of the body. [m]"""
    axes: tuple[str, ...] = ("x", "y")
    turns: tuple[str, ...] = ("angle",)

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        cosine, sine = np.cos(configuration[:, 2]), np.sin(configuration[:, 2])
        arm = np.zeros_like(rates, shape=(len(rates), 2))
        arm[:, 0] = cosine * self.point[0] - sine * self.point[1]
        arm[:, 1] = sine * self.point[0] + cosine * self.point[1]
        jacobian = np.zeros_like(rates, shape=(len(rates), 2, 3))
        jacobian[:, 0, 0] = jacobian[:, 1, 1] = cosine
        jacobian[:, 1, 0] = sine
        jacobian[:, 0, 1] = -sine
        jacobian[:, 0, 2], jacobian[:, 1, 2] = -arm[:, 1], arm[:, 0]

        def bias() -> np.ndarray:
            turning = rates[:, 2]
            along = cosine * rates[:, 0] - sine * rates[:, 1]
            across = sine * rates[:, 0] + cosine * rates[:, 1]
            return np.stack([-turning * across, turning * along], axis=-1) - (turning * turning)[:, None] * arm

        return Held(configuration[:, :2] + arm, jacobian, bias, lambda: _in_plane(configuration[:, 2:3], rates, [2]))


def _in_plane(angle: np.ndarray, rates: np.ndarray, columns: Sequence[int]) -> Turned:
    """Turn of a body in the plane by an angle (m, 1) whose rate is the sum of some of the machine's."""
    jacobian = np.zeros((len(rates), 1, rates.shape[-1]))
    jacobian[:, 0, list(columns)] = 1.0
    return Turned(angle, jacobian, np.zeros((len(rates), 1)))


@dataclass(frozen=True, slots=True, kw_only=True)
class PointGrip:
    """The origin of a platform, or the axes of a slide: the first coordinates are the velocities of the handle, then those of its
    turning."""

    axes: tuple[str, ...]
    coordinates: int
    """Of the machine."""
    turns: tuple[str, ...] = ()

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        count = len(self.axes)
        jacobian = np.broadcast_to(np.eye(count, self.coordinates), (len(rates), count, self.coordinates))
        return Held(
            configuration[:, :count],
            jacobian,
            lambda: np.zeros((len(rates), count)),
            lambda: self._turned(configuration),
        )

    def _turned(self, configuration: np.ndarray) -> Turned:
        rows, count, first = len(configuration), len(self.turns), len(self.axes)
        turning = configuration[:, first : first + count]
        jacobian = np.broadcast_to(np.eye(count, self.coordinates, first), (rows, count, self.coordinates))
        return Turned(turning if count == 1 else rotation_matrix(turning), jacobian, np.zeros((rows, count)))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmGrip:
    """The end point of a planar arm, whose joint rates are the first coordinates."""

    arm: PlanarArm
    coordinates: int
    """Of the machine."""
    axes: tuple[str, ...] = ("x", "y")
    turns: tuple[str, ...] = ("angle",)

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        joints = self.arm.joints
        jacobian = np.zeros_like(rates, shape=(len(rates), 2, self.coordinates))
        jacobian[:, :, :joints] = self.arm.jacobian(configuration)[:, :2]

        def bias() -> np.ndarray:
            absolute, turning = np.cumsum(configuration, axis=-1), np.cumsum(rates[:, :joints], axis=-1)
            pulled = np.asarray(self.arm.lengths) * turning * turning
            return -np.stack([np.sum(pulled * np.cos(absolute), -1), np.sum(pulled * np.sin(absolute), -1)], axis=-1)

        end = np.asarray(self.arm.end_point(configuration))
        return Held(end[:, :2], jacobian, bias, lambda: _in_plane(end[:, 2:], rates, range(joints)))


@dataclass(frozen=True, slots=True, kw_only=True)
class GrippingArm:
    """Mass, damping and stiffness of an arm in each direction of the handle, and where it wants to be.

    Of an arm that turns the handle, its moment of inertia and what resists turning follow, the same about all axes.
    """

    mass: np.ndarray
    """(d,) [kg], (k,) [kg m^2]"""
    damping: np.ndarray
    """(d,) [N s m^-1], (k,) [N m s rad^-1]"""
    stiffness: np.ndarray
    """(d,) [N m^-1], (k,) [N m rad^-1]"""
    intention: Callable[[float], Any]
    """Position by time (d,) [m], and the rotation vector or angle of the turn from the start (k,) [rad]."""
    start: np.ndarray | None = None
    """How the handle is turned at the start: its angle (1,), or its axes as columns (3, 3)."""

    def intended(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Intention and its rate at rows of time. (m, d + k) each"""
        if isinstance(self.intention, VectorHistory):
            return at_times(self.intention, time), at_times(self.intention.rate, time)
        rate = at_times(lambda one: np.asarray(self.intention(one + _STEP)) - self.intention(one - _STEP), time)
        return at_times(self.intention, time), rate / (2.0 * _STEP)


class HandPowers(NamedTuple):
    """Powers of a hand and its energy at m rows."""

    user: np.ndarray
    """(m,) [W]"""
    arm: np.ndarray
    """Lost in the arm. (m,) [W]"""
    wound: np.ndarray
    """Energy in the arm's spring. (m,) [J]"""


class Grasp(NamedTuple):
    """What a hand does to a machine at m rows."""

    generalised: np.ndarray
    """Force on the coordinates, but that of the arm's mass with an acceleration of the rates. (m, N)"""
    inertia: np.ndarray | None
    """Of the arm, about the coordinates. (m, N, N)"""
    powers: Callable[[], HandPowers]
    """Computes powers and energy."""
    position: np.ndarray
    """Of the handle. (m, d) [m]"""
    force: np.ndarray
    """On the handle, and moment, without the arm's mass. (m, d + k) [N], [N m]"""

    def energy(self, rates: np.ndarray) -> np.ndarray:
        """Energy of the arm's mass and spring. (m,) [J]"""
        wound = self.powers().wound
        if self.inertia is None:
            return wound
        return wound + 0.5 * (rates * np.matmul(self.inertia, rates[..., None])[..., 0]).sum(axis=-1)


class _Ways(NamedTuple):
    """A handle in all directions and rotations in which a hand acts, as `Held`."""

    position: np.ndarray
    jacobian: np.ndarray
    """(m, d + k, N)"""
    bias: Callable[[], np.ndarray]
    about: Turned | None
    """None where the hand does not turn it."""

    def apart(self, start: np.ndarray | None, intended: Any, intending: Any) -> tuple[np.ndarray, np.ndarray]:
        """From the handle to an arm's intention, and the velocity of the intention. (m, d + k) each"""
        if self.about is None:
            return intended - self.position, intending
        assert start is not None
        count = self.position.shape[-1]
        turn, turning = intended[:, count:], intending[:, count:]
        if turn.shape[-1] > 1:
            turning = angular_velocity(turn, turning)
        apart = [intended[:, :count] - self.position, self.about.apart(start, turn)]
        return np.concatenate(apart, axis=-1), np.concatenate([intending[:, :count], turning], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hand:
    """A user at the handle of a machine: a force over time, an arm, or both; and where it turns the handle, moments."""

    grip: Grip
    force: Callable[[float], Any] | None = None
    """In the directions of the handle, and moment, by time. (d + k,) [N], [N m]"""
    arm: GrippingArm | None = None
    turns: bool = False
    """Whether it turns the handle; else k is 0."""

    @property
    def ways(self) -> tuple[str, ...]:
        """Names of the directions and rotations in which it acts. d + k"""
        return (*self.grip.axes, *self.grip.turns) if self.turns else self.grip.axes

    def pushed(self, time: np.ndarray) -> np.ndarray:
        """Force and moment over time alone. (m, d + k)"""
        return np.zeros((len(time), len(self.ways))) if self.force is None else at_times(self.force, time)

    def _held(self, configuration: np.ndarray, rates: np.ndarray) -> _Ways:
        held = self.grip.at(configuration, rates)
        if not self.turns:
            return _Ways(held.position, held.jacobian, held.bias, None)
        assert held.about is not None
        about = held.about()
        jacobian = np.concatenate([held.jacobian, about.jacobian], axis=-2)
        return _Ways(held.position, jacobian, lambda: np.concatenate([held.bias(), about.bias], axis=-1), about)

    def apart(self, intended: Any, intending: Any, configuration: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """From the handle to where its arm wants it. (m, d + k) [m], [rad]"""
        assert self.arm is not None
        return self._held(configuration, rates).apart(self.arm.start, intended, intending)[0]

    def act(self, pushed: Any, intended: Any, intending: Any, configuration: np.ndarray, rates: np.ndarray) -> Grasp:
        """Forces, inertia and powers at rows, by the force over time and the arm's intention with its rate, (m, d + k) each."""
        held, arm = self._held(configuration, rates), self.arm
        jacobian = held.jacobian
        if arm is None:
            generalised = np.matmul(pushed[:, None, :], jacobian)[:, 0]

            def of_force() -> HandPowers:
                velocity = np.matmul(jacobian, rates[..., None])[..., 0]
                power = (pushed * velocity).sum(axis=-1)
                return HandPowers(power, 0.0 * power, 0.0 * power)

            return Grasp(generalised, None, of_force, held.position, pushed)
        velocity = np.matmul(jacobian, rates[..., None])[..., 0]
        apart, wanted = held.apart(arm.start, intended, intending)
        slower = wanted - velocity
        drawn = arm.stiffness * apart + arm.damping * slower
        force = pushed + drawn
        across = np.swapaxes(jacobian, -1, -2)
        generalised = np.matmul(across, (force - arm.mass * held.bias())[..., None])[..., 0]

        def powers() -> HandPowers:
            return HandPowers(
                (pushed * velocity + drawn * wanted).sum(axis=-1),
                (arm.damping * slower * slower).sum(axis=-1),
                0.5 * (arm.stiffness * apart * apart).sum(axis=-1),
            )

        return Grasp(generalised, np.matmul(across * arm.mass, jacobian), powers, held.position, force)

    def acting(self, time: np.ndarray, configuration: np.ndarray, rates: np.ndarray) -> Grasp:
        """The same at rows of time."""
        intended = (None, None) if self.arm is None else self.arm.intended(time)
        return self.act(self.pushed(time), *intended, configuration, rates)

    def energy(self, time: np.ndarray, configuration: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Energy of the arm's mass and spring. (m,) [J]"""
        return self.acting(time, configuration, rates).energy(rates)

    def felt(
        self,
        pushed: Any,
        intended: Any,
        intending: Any,
        configuration: np.ndarray,
        rates: np.ndarray,
        accelerations: np.ndarray,
    ) -> np.ndarray:
        """Force and moment between hand and handle, on the handle, as a sensor there measures them; arguments as of `act`.
        (m, d + k) [N], [N m]"""
        if self.arm is None:
            return pushed
        force = self.act(pushed, intended, intending, configuration, rates).force
        held = self._held(configuration, rates)
        return force - self.arm.mass * (np.matmul(held.jacobian, accelerations[..., None])[..., 0] + held.bias())


def at_times(function: Callable[[float], Any], time: np.ndarray) -> np.ndarray:
    """Values of a function at rows of time, many of which are alike. (m, d)

    Raises
    ------
    ParameterError
        If a value is not finite, or has another shape than the others.
    """
    instants = time.tolist()
    known = {one: np.asarray(function(one), dtype=float) for one in dict.fromkeys(instants)}
    rows = [known[one] for one in instants]
    if len({row.shape for row in known.values()}) > 1:
        raise ParameterError(f"user must be as many numbers at each instant, got {rows[0]} and {rows[-1]}")
    found = np.array(rows)
    if not np.isfinite(found).all():
        one, value = next((one, value) for one, value in known.items() if not np.isfinite(value).all())
        raise ParameterError(f"user must be finite numbers at each instant, got {value} at {one:.6g} s")
    return found
