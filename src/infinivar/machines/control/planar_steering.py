"""Steering of planar cobots in a session: the directions in which the handle may move, and the wheels that permit them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from infinivar.bondgraph.recorded import vector
from infinivar.bondgraph.scalars import cosine, signed, sine, within
from infinivar.bondgraph.tape import Number
from infinivar.machines.control.controller import Measured
from infinivar.machines.control.loops import Commands
from infinivar.machines.hand import BodyGrip
from infinivar.transmission.planar import PlanarCobot, drift

_NEVER_SLIPS = 0.95
"""Most of the slip force for which a slip angle is fed forward."""

_RETURN = 5.0
"""With which a body on several wheels returns to its orientation as it moves. [m^-1]"""

_AHEAD = 1.5
"""Samples from a measurement to the middle of the time in which what follows from it acts."""


class Going(NamedTuple):
    """How the handle moves when a command acts."""

    position: np.ndarray
    """(2,) [m]"""
    direction: Number
    """psi, in which it may move. [rad]"""
    speed: Number
    """u along psi; negative backwards. [m s^-1]"""
    force: np.ndarray
    """Of the user. (2,) [N]"""
    moment: Number
    """Of the user. [N m]"""

    @property
    def left(self) -> np.ndarray:
        """Unit vector to the left of psi."""
        return vector(-sine(self.direction), cosine(self.direction))


Turning = Callable[[Going], Number]
"""W of a direction of motion. [rad s^-1]"""

Attitude = Callable[[Going], tuple[Number, Number]]
"""Turn of the body by metre of the handle along psi [rad m^-1], and its orientation less that at the start [rad]."""


@dataclass(slots=True)
class Steering:
    """Directions of motion in a session, and the wheels that permit them."""

    settings: Any
    """Of the guide: direction of motion at the start, slip_feedforward, largest_rate and rest_speed."""
    cobot: PlanarCobot
    grip: BodyGrip
    period: float
    turning: Turning
    usual: Callable[[Measured], float]
    attitude: Attitude
    direction: Number = math.nan
    orientation: float = 0.0
    begun: bool = False
    mass: float = field(init=False)
    inertia: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        """Inertia of the body."""
        self.mass = float(self.cobot.mass)  # type: ignore[arg-type]
        self.inertia = np.diag([self.mass, self.mass, float(self.cobot.inertia)])  # type: ignore[arg-type]

    @property
    def memory(self) -> list[np.ndarray] | None:
        """The direction of motion, and what its law and the attitude remember; None if one does not tell it."""
        own: list[Any] = [getattr(one, "memory", None) for one in (self.turning, self.attitude)]
        if any(one is None for one in own):
            return None
        return [np.array([self.direction]), *(one for some in own for one in some)]

    @memory.setter
    def memory(self, kept: Sequence[np.ndarray]) -> None:
        (self.direction,), *rest = kept
        for one in (self.turning, self.attitude):
            count = len(one.memory)  # type: ignore[attr-defined]
            one.memory, rest = rest[:count], rest[count:]  # type: ignore[attr-defined]

    def __call__(self, measured: Measured) -> Commands:
        """Angles and rates of the wheels."""
        period, begins = self.period, not self.begun
        if begins:
            self.direction, self.orientation = self._first(measured), float(measured.configuration[2])
            self.begun = True
        # The first command acts at once, and for two samples. All laws look at the middle of the time in which they act.
        lead, half = (period, period) if begins else (_AHEAD * period, 0.5 * period)
        going = self._going(measured, self.direction, lead)
        rate = self._limited(going)
        going = self._going(measured, self.direction + half * rate, lead)
        rate = self._limited(going)
        spin = self._turning_of_body(measured, going)
        slips = self._slip_angles(measured, going, rate, spin)
        first = self._headings(self.direction, spin, measured, 0.0 if begins else period)
        then = self._headings(self.direction + period * rate, spin, measured, period if begins else 2.0 * period)
        first = _nearest(first + slips, measured.steering)
        steering_rate = (_nearest(then + slips, first) - first) / period
        self.direction += (2.0 if begins else 1.0) * period * rate
        return Commands(steering=first, steering_rate=steering_rate)

    def _going(self, measured: Measured, direction: Number, lead: float) -> Going:
        """How the handle moves some time after a measurement."""
        x, y = cosine(direction), sine(direction)
        force, velocity = measured.force, measured.velocity
        pushed = force[0] * x + force[1] * y
        speed = velocity[0] * x + velocity[1] * y
        moment = measured.moment[0] if measured.moment.size else 0.0
        return Going(measured.position + lead * velocity, direction, speed + lead * pushed / self.mass, force, moment)

    def _limited(self, going: Going) -> Number:
        return within(self.turning(going), self.settings.largest_rate)

    def _first(self, measured: Measured) -> float:
        if self.settings.direction is not None:
            return self.settings.direction
        if np.hypot(*measured.velocity) > self.settings.rest_speed:
            return math.atan2(measured.velocity[1], measured.velocity[0])
        return self.usual(measured)

    def _turning_of_body(self, measured: Measured, going: Going) -> Number:
        """omega of the body over the speed of the handle. [rad m^-1]"""
        if self.cobot.mechanism.wheels == 1:
            return 0.0
        spin, turned = self.attitude(going)
        off = measured.configuration[2] - self.orientation - turned
        return spin - signed(_RETURN * off, going.speed * off)

    def _twist(self, direction: Number, spin: Number, angle: Number) -> np.ndarray:
        """Twist of the body, in its axes, for a unit speed of the handle along a direction."""
        along = direction - angle
        x, y = self.grip.point
        return vector(cosine(along) + spin * y, sine(along) - spin * x, spin)

    def _headings(self, direction: Number, spin: Number, measured: Measured, after: float) -> np.ndarray:
        """Directions of the wheels' carriers in the body, some time after the measurement. (k,)"""
        angle = measured.configuration[2] + after * measured.rates[2]
        moves = self.cobot.mechanism.jacobian @ self._twist(direction, spin, angle)
        return np.arctan2(moves[:, 1], moves[:, 0])

    def _slip_angles(self, measured: Measured, going: Going, rate: Number, spin: Number) -> np.ndarray:
        """What the wheels' headings have beyond the directions of their carriers. (k,)"""
        cobot = self.cobot
        count = cobot.mechanism.wheels
        if not self.settings.slip_feedforward:
            return np.zeros(count)
        if count == 1:
            load = going.force @ going.left - self.mass * going.speed * rate
            carried, ways = vector(load), vector(going.speed)
        else:
            carried, ways = self._carried(going, rate, spin, measured.configuration[2])
        found = np.zeros_like(carried)
        for contact, wheels in cobot.mechanism.kinds:
            places, most = list(wheels), _NEVER_SLIPS * contact.slip_force
            found[places] = drift(contact, np.clip(carried[places], -most, most))
        return -np.copysign(1.0, ways) * found

    def _carried(self, going: Going, rate: Number, spin: Number, angle: Number) -> tuple[np.ndarray, np.ndarray]:
        """Load of the body on each wheel across its heading, the least that balances the motion, and how fast it rolls. (k,)"""
        inertia = self.inertia
        unit = self._twist(going.direction, spin, angle)
        turned = self._twist(going.direction + 0.5 * math.pi, 0.0, angle)
        changing = going.speed * (rate - going.speed * spin) * turned
        twist = going.speed * unit
        bias = self.mass * twist[2] * vector(-twist[1], twist[0], 0.0)
        c, s = cosine(angle), sine(angle)
        x, y = c * going.force[0] + s * going.force[1], c * going.force[1] - s * going.force[0]
        push = vector(x, y, self.grip.point[0] * y - self.grip.point[1] * x + going.moment)
        gained = (unit @ (push - bias - inertia @ changing)) / (unit @ inertia @ unit)
        needed = inertia @ (gained * unit + changing) + bias - push
        rows = self.cobot.mechanism.jacobian
        moves = rows @ unit
        size = np.maximum(np.sqrt(moves[:, 0] ** 2 + moves[:, 1] ** 2), 1e-9)
        across = (moves[:, :1] * rows[:, 1] - moves[:, 1:] * rows[:, 0]) / size[:, None]
        # Nothing is needed along the motion, which would be the share of the last row: with it the rows are independent.
        shares = np.linalg.lstsq(np.concatenate([across, unit[None]]).T, needed, rcond=1e-9)[0][:-1]
        return -shares, going.speed * size


def _nearest(angles: np.ndarray, to: np.ndarray) -> np.ndarray:
    """The same lines of wheels, as angles within a quarter turn of others."""
    return angles - math.pi * np.floor((angles - to) / math.pi + 0.5)
