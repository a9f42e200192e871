"""What controllers know of a planned motion behind springs and a linkage: the drive's own motion, and the force on it.

The controllers measure and move the drive's side of an output. The motion planned for the load, and the force that it needs,
determine through the chain of springs and linkage where the drive has to be, and what force it must exert there. Both are
computed at the controllers' samples, and interpolated by splines between the instants at which the motion or the external
force may jump.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from infinivar.drivetrain.output import Output
from infinivar.motion.motion import Force, Motion, MotionState
from infinivar.parts import history
from infinivar.parts.linkage import Linkage

_FEWEST = 8
"""Fewest intervals of a spline."""

_EARLY = 1e-9
"""How long before a jump the last value before it is read, relative to the duration."""


class Side(NamedTuple):
    """Positions at one point of the chain over time, and the force that what lies before it exerts there. [m], [N]"""

    position: np.ndarray
    force: np.ndarray


class Stretch(NamedTuple):
    """Stretch between a drive and its output, under the output's force and the friction of a guideway there."""

    stiffness: float
    """[N/m]"""
    friction: float
    """[N]"""
    reversal: float
    """Time in which the friction is planned to reverse: a drive cannot jump by the change of the stretch. [s]"""

    def at(self, time: Sequence[np.ndarray], side: Side) -> np.ndarray:
        """Stretch over time, in pieces between jumps. [m]

        Source: Hooke's law; Coulomb's law, with a smooth reversal.
        """
        ends = np.cumsum([len(piece) for piece in time])[:-1]
        speeds = [np.gradient(x, t) for x, t in zip(np.split(side.position, ends), time, strict=True)]
        largest = max(float(np.max(np.abs(np.gradient(v, t)))) for v, t in zip(speeds, time, strict=True))
        speed, slow = np.concatenate(speeds), 0.5 * self.reversal * largest
        way = np.tanh(speed / slow) if slow > 0.0 else np.sign(speed)
        return (side.force + self.friction * way) / self.stiffness


class Planned:
    """Motion of the drive's side of an output, for controllers to follow, and the force that the drive exerts there."""

    shape: ClassVar[str] = "planned"

    def __init__(
        self, starts: Sequence[float], splines: Sequence[_Spline], load_force: float, stretch: float = 0.0
    ) -> None:
        """From splines of position and force, each from its start to the next; force on the load and stretch at the start."""
        self.load_force: float = load_force
        self.stretch: float = stretch
        self._starts = list(starts)
        self._splines = list(splines)

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which speed or acceleration may jump. [s]"""
        return self._starts[1:]

    def at(self, time: float) -> MotionState:
        """Position [m], speed [m s^-1] and acceleration [m s^-2] of the drive at a time [s]."""
        return MotionState(*self._spline(time).position(time))

    def force(self, time: float) -> float:
        """Force that the drive exerts on the output at a time. [N]"""
        return self._spline(time).force(time)[0]

    def _spline(self, time: float) -> _Spline:
        return self._splines[max(bisect.bisect_right(self._starts, time) - 1, 0)]


class _Spline(NamedTuple):
    """Cubic pieces of equal width for position and force."""

    start: float
    step: float
    positions: list[list[float]]
    forces: list[list[float]]

    def position(self, time: float) -> tuple[float, float, float]:
        """Value and two derivatives."""
        return self._cubic(self.positions, time)

    def force(self, time: float) -> tuple[float, float, float]:
        """Value and two derivatives."""
        return self._cubic(self.forces, time)

    def _cubic(self, pieces: list[list[float]], time: float) -> tuple[float, float, float]:
        place = min(max(int((time - self.start) / self.step), 0), len(pieces) - 1)
        s = time - self.start - place * self.step
        cubic, square, linear, constant = pieces[place]
        return (
            constant + s * (linear + s * (square + s * cubic)),
            linear + s * (2.0 * square + 3.0 * s * cubic),
            2.0 * square + 6.0 * s * cubic,
        )


def planned(
    output: Output,
    path: Motion,
    force: Force | None,
    *,
    duration: float,
    sample_time: float,
    mass: float,
    follows: bool,
    stretch: Stretch | None = None,
) -> Planned:
    """Motion and force on the drive's side of an output.

    Parameters
    ----------
    output : Output
    path : Motion                  Of the load. [m] or [rad]
    force : Force                  External force on the load, as planned. [N] or [N m]
    duration, sample_time : float  Of the run, and of the controllers. [s]
    mass : float                   Of the load; 0 for none. [kg] or [kg m^2]
    follows : bool                 Whether the drive moves the load; else springs start without force.
    stretch : Stretch              Of a stage between the drive and the output, which the drive makes up for; None if rigid.

    Returns
    -------
    Planned
    """
    from scipy.interpolate import CubicSpline

    jumps = {float(at) for at in (*path.breaks, *(() if force is None else force.breaks)) if 0.0 < at < duration}
    bounds = [0.0, *sorted(jumps), duration]
    early = _EARLY * duration
    starts, grids = [], []
    for begin, end in itertools.pairwise(bounds):
        count = max(_FEWEST, math.ceil((end - begin) / sample_time))
        starts.append(begin)
        grids.append(np.linspace(begin, end, count + 1))
    times = [np.append(grid[:-1], grid[-1] - early) for grid in grids]
    load = _load(path, force, np.concatenate(times), mass, follows)
    side = at_drive(output, *load)
    given = np.zeros(len(load.force)) if stretch is None else stretch.at(times, side)
    side = Side(side.position + given, side.force)
    splines, first = [], 0
    for begin, grid in zip(starts, grids, strict=True):
        part = slice(first, first + len(grid))
        first += len(grid)
        tables = [CubicSpline(grid, values[part]).c.T.tolist() for values in side]
        splines.append(_Spline(begin, float(grid[1] - grid[0]), *tables))
    return Planned(starts, splines, float(load.force[0]), float(given[0]))


def _load(path: Motion, force: Force | None, times: np.ndarray, mass: float, follows: bool) -> Side:
    """Planned positions of the load, and the force that moves it."""
    states = np.array([path.at(time) for time in times.tolist()])
    if not follows:
        return Side(states[:, 0], np.zeros(len(times)))
    pushed = np.zeros(len(times)) if force is None else np.array([force.value(time) for time in times.tolist()])
    return Side(states[:, 0], mass * states[:, 2] - pushed)


def at_drive(output: Output, position: np.ndarray, force: np.ndarray) -> Side:
    """From the load through the chain to the drive: positions in order of time, and forces there.

    Hysteresis starts without force. Source: that of the parts' laws; balances of forces and of power.
    """
    side = Side(position, force)
    for place in output.chain:
        side = _HOPS[place.kind](place.part, side)
    return side


def _over_parallel(spring: Any, side: Side) -> Side:
    force = side.force + spring.force(side.position)
    if spring.hysteretic:
        force = force + history.along_positions(spring, side.position, closes=False)
    return Side(side.position, force)


def _over_series(spring: Any, side: Side) -> Side:
    if not spring.hysteretic:
        return Side(side.position + spring.deflection(side.force), side.force)
    return Side(side.position + history.under_forces(spring, side.force, closes=False)[0], side.force)


def _over_linkage(linkage: Linkage, side: Side) -> Side:
    position, arm = linkage.derivatives(side.position, 1)
    return Side(position, side.force / arm)


_HOPS: dict[str, Callable[[Any, Side], Side]] = {
    "parallel": _over_parallel,
    "series": _over_series,
    "linkage": _over_linkage,
}
