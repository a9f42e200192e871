r"""The user at a handle: forces, and an arm that grips it.

The handle is a point x(c) of the machine with velocity :math:`\dot x = G \nu`. An arm with mass m, damping b and stiffness k
grips it rigidly and pulls it towards an intention p(t):

.. math:: F = F_u(t) + k\,(p - x) + b\,(\dot p - \dot x) - m\,\ddot x, \qquad
    P_{user} = F_u \cdot \dot x + \left(k (p - x) + b (\dot p - \dot x)\right) \cdot \dot p ,

so that the mass moves with the machine, the spring stores :math:`\tfrac12 k |p - x|^2`, and the damper loses
:math:`b\,|\dot p - \dot x|^2`.

Source: Newton; springs and dampers between two moving points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from infinivar.motion.histories import VectorHistory
from infinivar.transmission.arm import PlanarArm

_STEP = 1e-5
"""Half the time over which an intention without derivative is differenced. [s]"""


class Held(NamedTuple):
    """The handle at m rows; d directions, N coordinates of the machine."""

    position: np.ndarray
    """x. (m, d) [m]"""
    jacobian: np.ndarray
    """G. (m, d, N)"""
    bias: np.ndarray
    """Acceleration of the handle without one of the rates. (m, d) [m s^-2]"""


class Grip(Protocol):
    """Where the hand holds a machine."""

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the directions, fixed in space."""
        ...

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyGrip:
    """A point of a body in the plane whose rates are in its own axes."""

    point: tuple[float, float] = (0.0, 0.0)
    """In axes of the body. [m]"""
    axes: tuple[str, ...] = ("x", "y")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        cosine, sine = np.cos(configuration[:, 2]), np.sin(configuration[:, 2])
        x = cosine * self.point[0] - sine * self.point[1]
        y = sine * self.point[0] + cosine * self.point[1]
        jacobian = np.empty((len(rates), 2, 3))
        jacobian[:, 0, 0], jacobian[:, 0, 1], jacobian[:, 0, 2] = cosine, -sine, -y
        jacobian[:, 1, 0], jacobian[:, 1, 1], jacobian[:, 1, 2] = sine, cosine, x
        turning = rates[:, 2]
        along = cosine * rates[:, 0] - sine * rates[:, 1]
        across = sine * rates[:, 0] + cosine * rates[:, 1]
        bias = np.stack([-turning * across - turning**2 * x, turning * along - turning**2 * y], axis=-1)
        return Held(configuration[:, :2] + np.stack([x, y], axis=-1), jacobian, bias)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointGrip:
    """The origin of a platform, or the axes of a slide: the first coordinates are the velocities of the handle."""

    axes: tuple[str, ...]
    coordinates: int
    """Of the machine."""

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        count = len(self.axes)
        jacobian = np.broadcast_to(np.eye(count, self.coordinates), (len(rates), count, self.coordinates))
        return Held(configuration[:, :count], jacobian, np.zeros((len(rates), count)))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmGrip:
    """The end point of a planar arm, whose joint rates are the first coordinates."""

    arm: PlanarArm
    coordinates: int
    """Of the machine."""
    axes: tuple[str, ...] = ("x", "y")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Held:
        """The handle in fixed axes."""
        joints = self.arm.joints
        jacobian = np.zeros((len(rates), 2, self.coordinates))
        jacobian[:, :, :joints] = self.arm.jacobian(configuration)[:, :2]
        absolute, turning = np.cumsum(configuration, axis=-1), np.cumsum(rates[:, :joints], axis=-1)
        pulled = np.asarray(self.arm.lengths) * turning * turning
        bias = -np.stack([np.sum(pulled * np.cos(absolute), -1), np.sum(pulled * np.sin(absolute), -1)], axis=-1)
        return Held(np.asarray(self.arm.end_point(configuration))[:, :2], jacobian, bias)


@dataclass(frozen=True, slots=True, kw_only=True)
class GrippingArm:
    """Mass, damping and stiffness of an arm in each direction of the handle, and where it wants to be."""

    mass: np.ndarray
    """(d,) [kg]"""
    damping: np.ndarray
    """(d,) [N s m^-1]"""
    stiffness: np.ndarray
    """(d,) [N m^-1]"""
    intention: Callable[[float], Any]
    """Position by time. (d,) [m]"""

    def wanted(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Intention and its rate at rows of time. (m, d) [m], [m s^-1]"""
        if isinstance(self.intention, VectorHistory):
            return at_times(self.intention, time), at_times(self.intention.rate, time)
        rate = at_times(lambda one: np.asarray(self.intention(one + _STEP)) - self.intention(one - _STEP), time)
        return at_times(self.intention, time), rate / (2.0 * _STEP)


class Grasp(NamedTuple):
    """What a hand does to a machine at m rows."""

    generalised: np.ndarray
    """Force on the coordinates, but that of the arm's mass with an acceleration of the rates. (m, N)"""
    inertia: np.ndarray
    """Of the arm, about the coordinates. (m, N, N)"""
    power: np.ndarray
    """Of the user. (m,) [W]"""
    loss: np.ndarray
    """In the arm. (m,) [W]"""
    wound: np.ndarray
    """Energy in the arm's spring. (m,) [J]"""
    position: np.ndarray
    """Of the handle. (m, d) [m]"""
    force: np.ndarray
    """On the handle, without the arm's mass. (m, d) [N]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hand:
    """A user at the handle of a machine: a force over time, an arm, or both."""

    grip: Grip
    force: Callable[[float], Any] | None = None
    """In the directions of the handle, by time. (d,) [N]"""
    arm: GrippingArm | None = None

    def act(self, time: np.ndarray, configuration: np.ndarray, rates: np.ndarray) -> Grasp:
        """Forces, inertia and powers at rows."""
        held = self.grip.at(configuration, rates)
        velocity = np.matmul(held.jacobian, rates[..., None])[..., 0]
        force = np.zeros_like(velocity) if self.force is None else at_times(self.force, time)
        power = np.sum(force * velocity, axis=-1)
        across = np.swapaxes(held.jacobian, -1, -2)
        if self.arm is None:
            generalised = np.matmul(across, force[..., None])[..., 0]
            nothing = 0.0 * power
            inertia = np.zeros((1, rates.shape[-1], rates.shape[-1]))
            return Grasp(generalised, inertia, power, nothing, nothing, held.position, force)
        arm = self.arm
        wanted, moving = arm.wanted(time)
        apart, slower = wanted - held.position, moving - velocity
        drawn = arm.stiffness * apart + arm.damping * slower
        force = force + drawn
        generalised = np.matmul(across, (force - arm.mass * held.bias)[..., None])[..., 0]
        return Grasp(
            generalised,
            np.matmul(across * arm.mass, held.jacobian),
            power + np.sum(drawn * moving, axis=-1),
            np.sum(arm.damping * slower * slower, axis=-1),
            0.5 * np.sum(arm.stiffness * apart * apart, axis=-1),
            held.position,
            force,
        )

    def energy(self, time: np.ndarray, configuration: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Energy of the arm's mass and spring. (m,) [J]"""
        grasp = self.act(time, configuration, rates)
        return grasp.wound + 0.5 * np.sum(rates * np.matmul(grasp.inertia, rates[..., None])[..., 0], axis=-1)

    def felt(
        self, time: np.ndarray, configuration: np.ndarray, rates: np.ndarray, accelerations: np.ndarray
    ) -> np.ndarray:
        """Force between hand and handle, on the handle, as a sensor there measures it. (m, d) [N]"""
        force = self.act(time, configuration, rates).force
        if self.arm is None:
            return force
        held = self.grip.at(configuration, rates)
        return force - self.arm.mass * (np.matmul(held.jacobian, accelerations[..., None])[..., 0] + held.bias)


def at_times(function: Callable[[float], Any], time: np.ndarray) -> np.ndarray:
    """Values of a function at rows of time, many of which are alike. (m, d)"""
    known: dict[float, Any] = {}
    rows = []
    for one in time.tolist():
        if one not in known:
            known[one] = function(one)
        rows.append(known[one])
    return np.array(rows, dtype=float)
