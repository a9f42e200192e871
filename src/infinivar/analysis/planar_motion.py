r"""Motion in time of a planar cobot that coasts or is pushed by a user.

In axes of the body, with the mass m and the moment of inertia I about its reference point,

.. math:: m(\dot v_x - \omega v_y) = W_x + Q_x, \quad m(\dot v_y + \omega v_x) = W_y + Q_y, \quad
    I\dot\omega = W_\theta + Q_\theta

with the wrench W of the user and the forces Q of the contacts. Creep is fast beside the motion, so that the equations are stiff;
below the stick speed the contacts become viscous. Work and losses are integrated with the motion, for the audit.

Source: Newton and Euler; contacts as in `infinivar.transmission.creepage`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array, shown
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.errors import InputError, ParameterError, require
from infinivar.transmission.planar import PlanarCobot
from infinivar.transmission.rolling_contact import ContactForces

Steering = Callable[[float, np.ndarray], Array]
"""Angles of the wheels in the body, (k,), at a time [s] and a pose (x, y, angle) in the plane."""

Wrench = Callable[[float, np.ndarray, np.ndarray], Array]
"""Forces along x and y of the body and moment, at a time, a pose and a twist."""

_STEP = 1e-6
"""Half the time over which the steering rate is differenced. [s]"""

_DIFFERENCE = 1e-6
"""Half the difference of a velocity, over the speed, or of a pose in metres or radians, for slopes."""

_REST = 10.0
"""Largest speed of a wheel's carrier at rest, over the stick speed. [-]"""

_RELATIVE = 1e-9
"""Tolerance of the integration."""


@result
class PlanarMotion(Result):
    """Motion of a planar cobot, as returned by `planar_motion`; t instants, k wheels.

    Attributes
    ----------
    time : (t,)            [s]
    pose : (t, 3)          x, y and angle in the plane. [m], [m], [rad]
    twist : (t, 3)         v_x, v_y and omega in axes of the body. [m s^-1], [m s^-1], [rad s^-1]
    heading : (t, k)       Angles of the wheels in the body. [rad]
    slip_demand : (t, k)   Above 1 a wheel slips. [-]
    energy : (t,)          Kinetic energy. [J]
    work : (t,)            By the user. [J]
    steering_work : (t,)   By the steering. [J]
    losses : by name       Since the start. (t,) [J]
    slips : tuple          Times at which a wheel begins to slip. [s]
    ended : str            "time", or "rest" if the body came to rest before: slower than ten times the stick speed.
    """

    time: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    heading: np.ndarray
    slip_demand: np.ndarray
    energy: np.ndarray
    work: np.ndarray
    steering_work: np.ndarray
    losses: Mapping[str, np.ndarray]
    slips: tuple[float, ...]
    ended: str

    @property
    def residual(self) -> float:
        """Largest residual of the balance of energies, over the largest energy or work. [-]"""
        missing = self.energy - self.energy[0] + sum(self.losses.values()) - self.work - self.steering_work
        scale = max(np.abs(self.energy).max(), np.abs(self.work).max(), 1e-300)
        return float(np.abs(missing).max() / scale)


def planar_motion(
    cobot: PlanarCobot,
    *,
    twist: Sequence[float],
    steering: Steering,
    duration: float,
    wrench: Wrench | None = None,
    pose: Sequence[float] = (0.0, 0.0, 0.0),
    stick_speed: float = 1e-5,
    points: int = 201,
) -> PlanarMotion:
    """Simulate a planar cobot that coasts or is pushed.

    Parameters
    ----------
    cobot : PlanarCobot     With mass and inertia.
    twist : 3 floats        At the start, in axes of the body. [m s^-1], [m s^-1], [rad s^-1]
    steering : callable     Angles of the wheels by time and pose, smooth. [rad]
    duration : float        > 0. [s]
    wrench : callable       Of the user, by time, pose and twist; None: the body coasts.
    pose : 3 floats         At the start. [m], [m], [rad]
    stick_speed : float     v_eps > 0; see `infinivar.transmission.creepage`. [m s^-1]
    points : int            Instants of the result, at least 2.

    Returns
    -------
    PlanarMotion   It ends where the body comes to rest.

    Raises
    ------
    ParameterError
        If an argument is out of range, the mass or the inertia is missing, or a function returns anything but finite numbers.
    InputError
        If the integration fails, which says where.
    """
    if not isinstance(cobot, PlanarCobot):
        raise ParameterError(f"cobot must be a PlanarCobot, got {cobot!r}")
    for name in ("mass", "inertia"):
        if getattr(cobot, name) is None:
            raise ParameterError(f"{name} is missing: motion in time needs it")
    for name, function in (("steering", steering), ("wrench", wrench)):
        optional = function is None and name == "wrench"
        require(callable(function) or optional, name, shown(function), "a function of time and pose")
    check_number("duration", duration, "s", Gt(0))
    check_number("stick_speed", stick_speed, "m/s", Gt(0))
    require(isinstance(points, int) and points >= 2, "points", points, "an integer >= 2")
    start = np.concatenate([_three("pose", pose), _three("twist", twist)])
    return _Run(cobot, steering, wrench, float(stick_speed), start).over(float(duration), points)


def _three(name: str, values: Any) -> np.ndarray:
    found = real_array(name, values)
    require(found.shape == (3,) and bool(np.all(np.isfinite(found))), name, values, "three finite numbers")
    return found


def _told(name: str, values: Any, time: float, count: int, what: str) -> np.ndarray:
    """What a function of the user returns."""
    found = real_array(name, values)
    require(found.shape == (count,), name, f"shape {found.shape}", f"of shape ({count},), {what}")
    require(bool(np.all(np.isfinite(found))), name, f"{found} at {time:.6g} s", "finite")
    return found


class _Run:
    """The equations of one motion. Its state: pose, twist, work of the user and of the steering, losses by name."""

    def __init__(
        self, cobot: PlanarCobot, steering: Steering, wrench: Wrench | None, stick_speed: float, start: np.ndarray
    ) -> None:
        self.cobot, self.steering, self.wrench, self.stick = cobot, steering, wrench, stick_speed
        self.mass, self.inertia = float(cobot.mass or 0.0), float(cobot.inertia or 0.0)
        self.turns = any(contact.turns_with_spin for contact in cobot.contacts)  # type: ignore[union-attr]
        self.names = tuple(self.contacts(0.0, start)[0].losses)
        self.start = np.concatenate([start, np.zeros(2 + len(self.names))])

    def angles(self, time: float, pose: np.ndarray) -> np.ndarray:
        """Headings in the body."""
        k = self.cobot.mechanism.wheels
        return _told("steering", self.steering(time, pose), time, k, "one angle for each wheel")

    def pushed(self, time: float, pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Wrench of the user."""
        if self.wrench is None:
            return np.zeros(3)
        return _told("wrench", self.wrench(time, pose, twist), time, 3, "two forces and a moment")

    def contacts(self, time: float, state: np.ndarray) -> tuple[ContactForces, np.ndarray, np.ndarray]:
        """Forces of the contacts, the wrench that would balance them, and the steering rates."""
        pose, twist = state[:3], state[3:6]
        angles = self.angles(time, pose)
        rate = np.zeros_like(angles)
        if self.turns:
            ahead = _STEP * self.moving(pose, twist)
            rate = (self.angles(time + _STEP, pose + ahead) - self.angles(time - _STEP, pose - ahead)) / (2.0 * _STEP)
        forces, against = self.cobot.mechanism.forces(twist, (np.cos(angles), np.sin(angles)), rate, self.stick)
        return forces, against, rate

    @staticmethod
    def moving(pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Rate of the pose."""
        cosine, sine = np.cos(pose[2]), np.sin(pose[2])
        return np.array([cosine * twist[0] - sine * twist[1], sine * twist[0] + cosine * twist[1], twist[2]])

    def rates(self, time: float, state: np.ndarray) -> np.ndarray:
        """Rate of the state."""
        pose, twist = state[:3], state[3:6]
        forces, against, rate = self.contacts(time, state)
        wrench = self.pushed(time, pose, twist)
        force = wrench - against
        turning = twist[2]
        change = np.array(
            [
                force[0] / self.mass + turning * twist[1],
                force[1] / self.mass - turning * twist[0],
                force[2] / self.inertia,
            ]
        )
        powers = [wrench @ twist, np.sum(forces.moment * rate), *(np.sum(forces.losses[name]) for name in self.names)]
        return np.concatenate([self.moving(pose, twist), change, powers])

    def slopes(self, time: float, state: np.ndarray) -> np.ndarray:
        """Derivatives of `rates` by the state; work and losses have none."""
        found, size = np.zeros((len(state), len(state))), max(self.speed(state), self.stick)
        for place in range(6):
            step = _DIFFERENCE * (1.0 if place < 3 else size)
            low, high = state.copy(), state.copy()
            low[place], high[place] = low[place] - step, high[place] + step
            found[:, place] = (self.rates(time, high) - self.rates(time, low)) / (2.0 * step)
        return found

    def demand(self, time: float, state: np.ndarray) -> np.ndarray:
        """Slip demand of each wheel."""
        return np.asarray(self.contacts(time, state)[0].slip_demand)

    def speed(self, state: np.ndarray) -> float:
        """Largest speed of a wheel's carrier."""
        k = self.cobot.mechanism.wheels
        motion = self.cobot.mechanism.velocities(state[3:6])
        return float(np.hypot(motion[:k], motion[k : 2 * k]).max())

    def over(self, duration: float, points: int) -> PlanarMotion:
        """The motion, solved."""
        from scipy.integrate import solve_ivp

        def slips(time: float, state: np.ndarray) -> float:
            return float(self.demand(time, state).max()) - 1.0

        def rests(time: float, state: np.ndarray) -> float:
            return self.speed(state) - _REST * self.stick

        slips.direction, rests.direction, rests.terminal = 1.0, -1.0, True  # type: ignore[attr-defined]
        reach = max(self.speed(self.start), 1e-3)
        energy = self.mass * reach * reach
        size = [reach] * 2 + [1.0] + [reach] * 2 + [reach] + [energy] * (len(self.start) - 6)
        found = solve_ivp(
            self.rates,
            (0.0, duration),
            self.start,
            method="Radau",
            jac=self.slopes,
            rtol=_RELATIVE,
            atol=_RELATIVE * np.array(size),
            events=[slips, rests],
            t_eval=np.linspace(0.0, duration, points),
        )
        if not found.success:
            reached = found.t[-1] if found.t.size else 0.0
            raise InputError(f"the integration fails after {reached:.6g} s: {found.message}; raise stick_speed")
        time, states = found.t, found.y.T
        if found.t_events[1].size:
            time, states = np.append(time, found.t_events[1][-1]), np.vstack([states, found.y_events[1][-1:]])
        twist = states[:, 3:6]
        return PlanarMotion(
            time=time,
            pose=states[:, :3],
            twist=twist,
            heading=np.array([self.angles(*row) for row in zip(time, states[:, :3], strict=True)]),
            slip_demand=np.array([self.demand(*row) for row in zip(time, states, strict=True)]),
            energy=0.5 * self.mass * (twist[:, 0] ** 2 + twist[:, 1] ** 2) + 0.5 * self.inertia * twist[:, 2] ** 2,
            work=states[:, 6],
            steering_work=states[:, 7],
            losses={name: states[:, 8 + place] for place, name in enumerate(self.names)},
            slips=tuple(map(float, found.t_events[0])),
            ended="rest" if found.t_events[1].size else "time",
        )
