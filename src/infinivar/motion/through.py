"""Motions through waypoints: straight moves from rest to rest, as fast as limits of speed and acceleration permit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from infinivar._core.fields import component
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.errors import ParameterError, require
from infinivar.motion.motion import PeriodicMotion
from infinivar.motion.motions import reach
from infinivar.motion.vectors import COORDINATES, TRANSLATIONS, Pose

MoveProfile = Literal["minimum-jerk", "smooth", "trapezoid"]

_CONTINUOUS = {"minimum-jerk": 2, "smooth": 4, "trapezoid": 1}
"""Highest time derivative of the position that has no jumps."""


class Most(NamedTuple):
    """Largest speed and acceleration of a move; no acceleration permits any."""

    speed: float
    acceleration: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Through(PeriodicMotion):
    """One coordinate of moves from waypoint to waypoint, each with a pause after it.

    Attributes
    ----------
    positions : n + 1 floats   Of n moves. [m] or [rad]
    times, ramps : n floats    Time of each move, and of its acceleration in a trapezoid of speed. [s]
    """

    shape: ClassVar[str] = "waypoints"
    positions: tuple[float, ...] = component("Positions")
    times: tuple[float, ...] = component("Times of the moves")
    ramps: tuple[float, ...] = component("Times of acceleration")
    pause: float = component("Pause after each move")
    profile: MoveProfile = component("Profile of the moves")
    rotary: bool = component("Whether they turn")
    back: bool = component("Whether they return to the first position")

    @property
    def axis(self) -> Axis:
        """Along a line, or about an axis."""
        return ROTARY if self.rotary else LINEAR

    @property
    def period(self) -> float:
        """Time of all moves and pauses. [s]"""
        return math.fsum(self.times) + len(self.times) * self.pause

    @property
    def repeats(self) -> bool:
        """Whether it returns."""
        return self.back

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion. [Hz]"""
        return 1.0 / min(self.times)

    @property
    def continuous(self) -> int:
        """Highest time derivative of the position that has no jumps."""
        return _CONTINUOUS[self.profile]

    def over(self, times: np.ndarray) -> list[np.ndarray]:
        """As of any motion; a run stays at its end."""
        return self.derivatives(times % self.period if self.back else np.minimum(times, self.period), 2)

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position and its time derivatives up to an order, at times in 0 to `period` [s]."""
        time = np.asarray(time, dtype=float)
        positions, durations, ramps = (np.array(one) for one in (self.positions, self.times, self.ramps))
        starts = np.concatenate([[0.0], np.cumsum(durations + self.pause)[:-1]])
        place = np.clip(np.searchsorted(starts, time, "right") - 1, 0, len(starts) - 1)
        duration, way = durations[place], np.diff(positions)[place]
        moving = time - starts[place] < duration
        since = np.where(moving, time - starts[place], duration)
        if self.profile == "trapezoid":
            along = trapezoid(way, duration, ramps[place], since, orders)
        else:
            along = reach(self.profile, way, duration, since, orders)
        return [positions[place] + along[0], *(np.where(moving, part, 0.0) for part in along[1:])]


def trapezoid(distance: Any, duration: Any, ramp: Any, since: Any, orders: int) -> list[Any]:
    """Position of a move with constant acceleration, constant speed and constant deceleration, and its time derivatives.

    Parameters
    ----------
    distance, duration, ramp, since : (...,) float   The ramp is the time of each acceleration, above 0 and at most half of the
        duration. [m], [s]

    Returns
    -------
    list of (...,) float   [m], [m s^-1], ...; 0 from the third derivative on.
    """
    peak = distance / (duration - ramp)
    left = duration - since
    end = np.minimum(since, left)
    near = np.where(end < ramp, 0.5 * peak * end * end / ramp, peak * (end - 0.5 * ramp))
    rising = np.where(end < ramp, np.where(since < left, 1.0, -1.0), 0.0)
    found = [
        np.where(since < left, near, distance - near),
        peak * np.minimum(end / ramp, 1.0),
        rising * peak / ramp,
    ]
    return [*found, *([0.0 * since] * orders)][: orders + 1]


def through(
    waypoints: Sequence[Pose], profile: MoveProfile, pause: float, back: bool, along: Most | None, turning: Most | None
) -> Mapping[str, Through]:
    """Motions by coordinate through waypoints, all in step.

    Parameters
    ----------
    waypoints : two poses or more   Displacements; what one does not state stays as it was, at first 0.
    profile : str                   Of the speed along each move.
    pause : float                   After each move. [s]
    back : bool                     Whether the last move returns to the first waypoint.
    along, turning : Most           Of displacements and of rotation vectors; needed for what moves. [m s^-1], [rad s^-1]

    Raises
    ------
    ParameterError
        If there are fewer than two, two in a row are alike, or a limit is missing.
    """
    require(len(waypoints) >= 2, "waypoints", f"{len(waypoints)}", "two or more")
    rows = np.zeros((len(waypoints), len(COORDINATES)))
    for place, one in enumerate(waypoints):
        rows[place] = one.row(COORDINATES, rows[place - 1] if place else None)
    if back and np.any(rows[-1] != rows[0]):
        rows = np.concatenate([rows, rows[:1]])
    moves = np.diff(rows, axis=0)
    for place in np.flatnonzero(~np.any(moves, axis=1)):
        raise ParameterError(f"waypoints {place + 2} is that before it: leave one out, or state a pause")
    lines = np.array([name in TRANSLATIONS for name in COORDINATES])
    ways = [
        (np.linalg.norm(moves[:, which], axis=1), most, name)
        for which, most, name in ((lines, along, "speed"), (~lines, turning, "turning_speed"))
    ]
    for way, most, name in ways:
        if most is None and np.any(way):
            raise ParameterError(f"{name} is missing: waypoints are reached at a limited speed")
    times, ramps = zip(
        *(_time(profile, [(way[place], most) for way, most, _ in ways if way[place]]) for place in range(len(moves))),
        strict=True,
    )
    return {
        name: Through(
            positions=tuple(rows[:, place]),
            times=times,
            ramps=ramps,
            pause=pause,
            profile=profile,
            rotary=name not in TRANSLATIONS,
            back=back,
        )
        for place, name in enumerate(COORDINATES)
        if np.any(moves[:, place])
    }


def _time(profile: MoveProfile, ways: Sequence[tuple[float, Any]]) -> tuple[float, float]:
    """Least time of a move with all limits, and of its acceleration. [s]"""
    if profile != "trapezoid":
        unit = reach(profile, 1.0, 1.0, np.linspace(0.0, 1.0, 2001), 2)
        fastest, hardest = (float(np.max(np.abs(one))) for one in unit[1:])
        needed = [fastest * way / most.speed for way, most in ways]
        needed += [math.sqrt(hardest * way / most.acceleration) for way, most in ways if most.acceleration is not None]
        return max(needed), 0.0
    for _, most in ways:
        if most.acceleration is None:
            raise ParameterError(
                "acceleration is missing: a trapezoid of speed needs it, or turning_acceleration for what turns"
            )
    ramp = max(min(most.speed / most.acceleration, math.sqrt(way / most.acceleration)) for way, most in ways)
    return max(2.0 * ramp, *(way / most.speed + ramp for way, most in ways)), ramp
