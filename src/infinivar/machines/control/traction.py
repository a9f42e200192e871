"""Control of a cart with motors on its axles: planned headings, and one traction for all motors along the motion.

The motors exert equal torques. Their sum follows the speed along the motion with the pole of the speed loop, and an outer loop
the pose; inertia, rolling resistance and friction are fed forward, and the integral finds the force of the load.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.machines.motors import PowerMotor
from infinivar.motion.histories import VectorHistory

_STANDS = 1e-3
"""Speed over the largest of a motion below which the headings are those of its next part that moves."""


_LATE = 1.0 / 6.0
"""Pole of the speed times the period of the samples, over the share of the axles in the inertia, at most: axles whose wheels slip
move alone, and a command acts one and a half periods after its measurement. [-]"""

_OUTER = 0.25
"""Gain of the pose error over the pole of the speed, at most. [-]"""


def wrapped(found: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Headings within a right angle of the present ones; a wheel that points the other way is the same wheel. [rad]"""
    return angles + np.remainder(found - angles + 0.5 * np.pi, np.pi) - 0.5 * np.pi


def planned_headings(body: Any, motion: VectorHistory) -> VectorHistory:
    """Headings of pure rolling along a motion, without jumps; while it rests, on the way to those of its next part."""
    time = np.asarray(motion.time)
    rates = np.array([np.asarray(body.rates_of(motion(one), motion.rate(one)), dtype=float) for one in time])
    points = np.matmul(np.asarray(body.cobot.mechanism.jacobian), rates[:, None, :, None])[..., 0]
    speed = np.linalg.norm(points, axis=-1)
    moves = np.all(speed > _STANDS * np.max(speed), axis=-1)
    if not np.any(moves):
        return VectorHistory(time=time[[0, -1]], values=np.zeros((2, speed.shape[-1])), smooth=False)
    angles = np.arctan2(points[moves, :, 1], points[moves, :, 0])
    angles = np.unwrap(angles, axis=0, period=np.pi)
    angles = wrapped(angles[0], 0.0 * angles[0]) + angles - angles[0]
    filled = np.stack([np.interp(time, time[moves], angles[:, place]) for place in range(angles.shape[-1])], axis=-1)
    return VectorHistory(time=time, values=filled)


@dataclass(slots=True)
class TractionController:
    """See the module."""

    body: Any
    """`PlanarMechanics` of the cart."""
    driven: tuple[int, ...]
    motor: PowerMotor
    motion: VectorHistory
    pole: float
    """Of the speed, at most. [rad s^-1]"""
    gain: float
    """Of the pose error, at most. [s^-1]"""
    limit: float
    """Of the current of each motor. [A]"""
    integral: np.ndarray
    """Wrench that the cart has found to exert, in its axes. (3,)"""

    def act(self, time: float, pose: np.ndarray, rates: np.ndarray, angles: np.ndarray, period: float) -> np.ndarray:
        """Currents of the motors from the measurements of a time; they act for a period from the next sample on. (n,) [A]"""
        body, driven = self.body, list(self.driven)
        contact, jacobian = body.cobot.contacts[0], np.asarray(body.cobot.mechanism.jacobian)
        ahead, lateral = np.cos(angles), np.sin(angles)
        along = ahead[:, None] * jacobian[:, 0] + lateral[:, None] * jacobian[:, 1]
        across = ahead[:, None] * jacobian[:, 1] - lateral[:, None] * jacobian[:, 0]
        way = np.linalg.svd(across)[2][-1]  # the motion that the wheels permit
        speeds = along @ way
        share = float(np.sum(np.abs(speeds[driven])))
        radius = float(contact.wheel_radius)
        axles = self.motor.inertia * np.sum((speeds[driven] / radius) ** 2)
        moved = way @ body.inertia + axles * way
        pole = min(self.pole, _LATE * axles / (moved @ way) / period)
        gain = min(self.gain, _OUTER * pole)
        # Planned in the middle of the sample in which the currents act.
        later = min(time + 1.5 * period, float(self.motion.time[-1]))
        twist, rise = (body.rates_of(pose, of(later)) for of in (self.motion.rate, self.motion.acceleration))
        rise = rise + twist[2] * np.array([twist[1], -twist[0], 0.0])  # in axes that turn
        off = self.motion.rate(time) + gain * (self.motion(time) - pose)
        # The speed of the axles, not of the cart: near slip the cart hardly follows them.
        rolled = np.sign(speeds[driven]) @ rates[3:] * radius / share if share else 0.0
        missing = moved @ (body.rates_of(pose, off) - rolled * way)
        grown = self.integral + pole**2 * period * missing * way
        bias = body.at(pose[None], rates[None, :3]).bias[0]
        turning = np.clip(along @ twist / body.stick_speed, -1.0, 1.0)
        resisted = float(contact.groups(0.0).rolling_force) * (turning @ speeds)
        force = moved @ rise + 2.0 * pole * missing + way @ (bias + grown) + resisted
        torque = force / share * radius * np.sign(speeds[driven]) if share else np.zeros(len(driven))
        friction = self.motor.reduction * (self.motor.motor.friction_torque + self.motor.gear_friction)
        currents = (torque + friction * turning[driven]) / self.motor.gain
        if np.all(np.abs(currents) <= self.limit):
            self.integral = grown
        return np.clip(currents, -self.limit, self.limit)
