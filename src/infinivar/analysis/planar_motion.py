r"""Motion in time of a planar cobot that coasts or is pushed by a user.

In axes of the body, with the mass m and the moment of inertia I about its reference point,

.. math:: m(\dot v_x - \omega v_y) = Q_x - W_x, \quad m(\dot v_y + \omega v_x) = Q_y - W_y, \quad
    I\dot\omega = Q_\theta - W_\theta

with the wrench W of the body on the user or load, and the forces Q of the contacts. Creep is fast beside the motion, so that the
equations are stiff; below the stick speed the contacts become viscous. The march is that of all machines, with a tight tolerance;
unlike those of a scenario, headings may depend on the pose, and the wrench on pose and twist.

Source: Newton and Euler; contacts as in `infinivar.transmission.creepage`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from annotated_types import Gt

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array, shown
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.analysis.marching import March
from infinivar.errors import InputError, ParameterError, require
from infinivar.machines.kinds.planar import PlanarMechanics
from infinivar.machines.system import System
from infinivar.transmission.planar import PlanarCobot

Steering = Callable[[float, np.ndarray], Array]
"""Angles of the wheels in the body, (k,), at a time [s] and a pose (x, y, angle) in the plane."""

Wrench = Callable[[float, np.ndarray, np.ndarray], Array]
"""Forces along x and y of the body and moment, at a time, a pose and a twist."""

_STEP = 1e-6
"""Half the time over which the steering rate is differenced. [s]"""

_REST = 10.0
"""Largest speed of a wheel's carrier at rest, over the stick speed. [-]"""

_TOLERANCE = 1e-7
"""Of the integration: its results then have nine digits."""


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
    wrench : callable       Of the body on the user or load, by time, pose and twist; None: the body coasts.
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
    mechanics = PlanarMechanics(cobot=cobot, stick_speed=float(stick_speed))
    wheels = cobot.mechanism.wheels

    def above_rest(states: np.ndarray) -> np.ndarray:
        motion = cobot.mechanism.velocities(states[:, 3:6])
        return np.hypot(motion[..., :wheels], motion[..., wheels : 2 * wheels]).max(axis=-1) - _REST * stick_speed

    found = March(
        system=_Prescribed(mechanics=mechanics, headings=steering, exerted=wrench),
        state=start,
        controller=None,
        period=duration,
        duration=float(duration),
        output_step=duration / (points - 1),
        tolerance=_TOLERANCE,
        halt=above_rest,
    ).over(lambda share: None)
    if found.outcome:
        raise InputError(f"the integration fails after {found.time[-1]:.6g} s: {found.outcome}")
    columns, nothing = found.columns, np.zeros(len(found.time))
    spins = any(contact.turns_with_spin for contact in cobot.contacts)  # type: ignore[union-attr]
    kept = ("creep", *(["spin"] if spins else []), "rolling", "bearing")
    losses = {name: found.lost.get(name, nothing) for name in kept}
    losses["creep"] = losses["creep"] + found.lost.get("slip", nothing)
    return PlanarMotion(
        time=found.time,
        pose=found.states[:, :3],
        twist=found.states[:, 3:6],
        heading=np.stack([columns[name] for name in mechanics.steered], axis=-1),
        slip_demand=np.stack([columns[f"slip_demand_wheel_{place + 1}"] for place in range(wheels)], axis=-1),
        energy=found.stored["machine"],
        work=found.supplied["user"],
        steering_work=found.supplied["steering"],
        losses=losses,
        slips=tuple(sorted({event.start for event in found.events if event.start > 0.0})),
        ended="rest" if found.halted else "time",
    )


def _three(name: str, values: Any) -> np.ndarray:
    found = real_array(name, values)
    require(found.shape == (3,) and bool(np.all(np.isfinite(found))), name, values, "three finite numbers")
    return found


def _returned(name: str, values: Any, time: float, count: int, what: str) -> np.ndarray:
    """What a function of the user returns."""
    found = real_array(name, values)
    require(found.shape == (count,), name, f"shape {found.shape}", f"of shape ({count},), {what}")
    require(bool(np.all(np.isfinite(found))), name, f"{found} at {time:.6g} s", "finite")
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _Prescribed(System):
    """A cobot whose headings depend on time and pose, and whose wrench on the load on time, pose and twist."""

    headings: Steering
    exerted: Wrench | None

    def steering(
        self, time: np.ndarray, state: np.ndarray, turning: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Headings and their rates at rows. (m, k) each"""
        pose, wheels = state[:, :3], len(self.mechanics.steered)
        change = _STEP * self.mechanics.at(pose, state[:, 3:6]).changes

        def prescribed(off: float) -> np.ndarray:
            rows = zip((time + off * _STEP).tolist(), pose + off * change, strict=True)
            what = "one angle for each wheel"
            return np.array([_returned("steering", self.headings(*row), row[0], wheels, what) for row in rows])

        return prescribed(0.0), (prescribed(1.0) - prescribed(-1.0)) / (2.0 * _STEP)

    def pushed(self, time: np.ndarray, state: np.ndarray) -> np.ndarray | None:
        """What the user or load exerts at rows: the opposite of the wrench. (m, 3)"""
        if self.exerted is None:
            return None
        rows = zip(time.tolist(), state[:, :3], state[:, 3:6], strict=True)
        return -np.array(
            [_returned("wrench", self.exerted(*row), row[0], 3, "two forces and a moment") for row in rows]
        )
