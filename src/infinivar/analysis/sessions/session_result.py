"""What a session returns, and what is measured of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from infinivar._core.arrays import real_array
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis import run_limits
from infinivar.analysis.animated import Animated
from infinivar.analysis.run import Run
from infinivar.analysis.run_limits import Event
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand
from infinivar.machines.control.sampling import Sensing
from infinivar.machines.kind import MovingMachine
from infinivar.units import plain

_ROUNDED = 1e-9
"""Depth beyond a wall at the start, or distance past the end of a path, that counts as rounding. [m]"""

_LATEST = 13
"""Times, half a sample apart, by which the force of a wall may be late."""

_HIDDEN = 0.05
"""Largest error of a stiffness, relative, that residuals may hide."""

_ROUNDS = 8
"""Of the search for the instants at which a wall pushes; three are usual."""

_STICK = 1e-4
"""Speed from which friction acts in full. [m/s]"""


@result
class Touch(Frozen):
    """Time interval in which the handle was beyond a wall."""

    start: float
    end: float
    """Start and end. [s]"""
    depth: float
    """Largest penetration. [m]"""

    def __str__(self) -> str:
        """One-line description."""
        return f"wall penetrated from {plain(self.start)} s to {plain(self.end)} s, up to {plain(1e3 * self.depth)} mm"


@result
class Overrun(Frozen):
    """Time interval in which the handle was past an end of an open path."""

    start: float
    end: float
    """First and last result past the end. [s]"""
    distance: float
    """Farthest along the tangent at the end. [m]"""

    def __str__(self) -> str:
        """One-line description."""
        until = f"{plain(self.start)} s to {plain(self.end)} s"
        return f"past the end of the path from {until}, up to {plain(1e3 * self.distance)} mm"


@result
class Session(Run, Animated, Result):
    """A session of a user at the handle of a machine, as returned by `session`; t instants.

    Attributes
    ----------
    machine, task, controller, user, sensing : arguments of the call.
    title : str
    axes : tuple of str          Directions of the handle, fixed in space.
    turns : tuple of str         Rotations about which the user acts, if any: rx, ry and rz, or angle.
    wall, path                   Surface and curve of the measures, or None.
    time : (t,) float            [s]
    columns : name to (t,)       Configuration, rates, steering angles and rates, currents and voltages of motors, slip demands;
        of the handle, position ("handle_x_m"), velocity ("handle_v_x_m_s") and the force of the user on it ("force_x_N"); and
        where the user acts about axes, its rotation vector or angle ("handle_rx_rad"), angular velocity ("handle_rx_rate_rad_s")
        and the moment of the user ("moment_rx_Nm").
    supplied : name to (t,)      Energy from "supply", "steering supply" and "user" since the start; of ideal servos
        "steering". [J]
    lost : name to (t,)          Energy lost by part since the start; "arm" is the user's. [J]
    stored : name to (t,)        Energy of machine, motor and steering, and of mass and spring of an arm. [J]
    residual : (t,)              Energy that is unaccounted for, over the energy moved. [-]
    events : tuple of Event      Intervals in which a demand exceeds its allowance, or a current is at its limit.
    touches : tuple of Touch     Intervals in which the handle is beyond the wall.
    root_mean_squares            Of each demand that it limits.
    outcome : str                Empty, or why the session ended early.
    """

    machine: MovingMachine
    task: Any
    controller: Any
    user: Any
    sensing: Sensing
    title: str
    axes: tuple[str, ...]
    wall: Any
    path: Any
    time: np.ndarray
    columns: Mapping[str, np.ndarray]
    supplied: Mapping[str, np.ndarray]
    lost: Mapping[str, np.ndarray]
    stored: Mapping[str, np.ndarray]
    residual: np.ndarray
    events: tuple[Event, ...]
    touches: tuple[Touch, ...]
    root_mean_squares: Mapping[Demand, float]
    outcome: str = ""
    turns: tuple[str, ...] = ()

    @property
    def event_lines(self) -> tuple[str, ...]:
        """Demands beyond their allowance, then penetrations of the wall and ends of the path that were passed."""
        return (*run_limits.lines(self.events, self.root_mean_squares), *map(str, (*self.touches, *self.overruns)))

    @property
    def position(self) -> np.ndarray:
        """Of the handle. (t, d) [m]"""
        return np.stack([self.columns[f"handle_{axis}_m"] for axis in self.axes], axis=-1)

    @property
    def velocity(self) -> np.ndarray:
        """Of the handle. (t, d) [m s^-1]"""
        return np.stack([self.columns[f"handle_v_{axis}_m_s"] for axis in self.axes], axis=-1)

    @property
    def force(self) -> np.ndarray:
        """Of the user on the handle. (t, d) [N]"""
        return np.stack([self.columns[f"force_{axis}_N"] for axis in self.axes], axis=-1)

    @property
    def angular_velocity(self) -> np.ndarray:
        """Of the handle, about `turns`. (t, k) [rad s^-1]"""
        return self._about("handle_{}_rate_rad_s")

    @property
    def moment(self) -> np.ndarray:
        """Of the user on the handle, about `turns`. (t, k) [N m]"""
        return self._about("moment_{}_Nm")

    def _about(self, column: str) -> np.ndarray:
        rows = [self.columns[column.format(turn)] for turn in self.turns]
        return np.stack(rows, axis=-1) if rows else np.zeros((len(self.time), 0))

    @property
    def joules(self) -> Mapping[str, float]:
        """Who put energy in, and where it went, by part; what is supplied is the sum of the rest. [J]"""
        return {
            **{f"from {name}": float(energy[-1]) for name, energy in self.supplied.items()},
            **{f"lost in {name}": float(energy[-1]) for name, energy in self.lost.items()},
            **{f"stored in {name}": float(energy[-1] - energy[0]) for name, energy in self.stored.items()},
        }

    @property
    def electrical_energy(self) -> float:
        """From all supplies, of power and steering motors. [J]"""
        return self._from_supply()

    @property
    def path_offset(self) -> np.ndarray:
        """Offset of the handle from the path, positive to the left; in space >= 0. (t,) [m]

        Raises
        ------
        ParameterError
            If the session has no path.
        """
        return self._beside_path[:, 0]

    @property
    def overruns(self) -> tuple[Overrun, ...]:
        """Intervals in which the handle is past an end of an open path; none without a path."""
        if self.path is None:
            return ()
        past = np.abs(self._beside_path[:, 1])
        return tuple(
            Overrun(
                start=float(self.time[first]), end=float(self.time[last - 1]), distance=float(np.max(past[first:last]))
            )
            for first, last in run_limits.intervals(past > _ROUNDED)
        )

    @cached_property
    def _beside_path(self) -> np.ndarray:
        """Offset from the path, and distance past an end of it. (t, 2) [m]"""
        if self.path is None:
            raise ParameterError("path is missing: the session has none to measure offsets from")
        near, found = None, np.empty((len(self.time), 2))
        for row, point in enumerate(self.position[:, : getattr(self.path, "dimension", None)]):
            there = self.path.nearest(point, near)
            near = float(there.arc_length)
            found[row] = float(there.offset), float(getattr(there, "beyond", 0.0))
        return found

    @property
    def penetration(self) -> np.ndarray:
        """Depth of the handle beyond the wall, negative on the free side. (t,) [m]

        Raises
        ------
        ParameterError
            If the session has no wall.
        """
        return -np.asarray(self._wall.distance(self._at_wall))

    @property
    def wall_force(self) -> np.ndarray:
        """Force of the user into the wall. (t,) [N]"""
        normal = np.asarray(self._wall.normal(self._at_wall))
        return -np.sum(normal * self.force[:, : normal.shape[-1]], axis=-1)

    @property
    def rendered_stiffness(self) -> float:
        """Of the wall: what the force of the motors at the handle rises by with the penetration; least squares beside the speed
        and the friction that is fed forward, over the instants at which the wall pushes. Penetration and speed are those that
        the controller knew, as late as leaves the least residual; inertia and friction of the machine are not in the force of its
        motors. nan where the motion does not separate the spring from the damper: where residuals of the size found could hide
        5 % of the stiffness; and for a machine that stops the handle by steering, which creeps and has no stiffness. [N m^-1]"""
        motors = self.machine.link_motors(_STICK)
        if motors is None or len(self.time) < 3:
            return float("nan")
        force, shared, inward = self._rendered(motors.gain)
        best = (float("inf"), float("nan"))
        for late in 0.5 * self.sensing.period * np.arange(_LATEST):
            terms = [np.interp(self.time - late, self.time, one) for one in (self.penetration, inward, shared)]
            best = min(best, _spring(force, np.stack(terms, axis=-1)))
        return best[1]

    def _rendered(self, gain: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Along the normal of the wall: force of the motors on the handle, such a force of constant friction, inward speed."""
        mechanics: Any = self.machine.mechanics(_STICK)
        configuration, rates = (
            np.stack([self.columns[name] for name in names], axis=-1)
            for names in (mechanics.configuration, mechanics.coordinates)
        )
        link = mechanics.load.at(configuration, rates)
        onto = np.linalg.pinv(np.swapaxes(mechanics.grip().at(configuration, rates).jacobian, -1, -2))
        normal = np.asarray(self._wall.normal(self._at_wall))
        count = normal.shape[-1]

        def along(on_links: np.ndarray) -> np.ndarray:
            felt = (onto @ (np.swapaxes(link.jacobian, -1, -2) @ on_links[..., None]))[..., 0]
            return np.sum(normal * felt[:, :count], axis=-1)

        currents = [self.columns[f"motor_{place + 1}_current_A"] for place in range(link.speed.shape[-1])]
        ways = np.clip(link.speed / getattr(self.controller, "compensation_speed", _STICK), -1.0, 1.0)
        inward = -np.sum(normal * self.velocity[:, :count], axis=-1)
        return along(gain * np.stack(currents, axis=-1)), along(ways), inward

    @property
    def _wall(self) -> Any:
        if self.wall is None:
            raise ParameterError("wall is missing: the session has none to measure penetration of")
        return self.wall

    @property
    def _at_wall(self) -> np.ndarray:
        return self.position[:, : getattr(self.wall, "dimension", len(self.axes))]

    def felt_mass(self, start: float = 0.0, end: float | None = None) -> np.ndarray:
        """Mass felt in each direction: impulse of the user's force over the change of speed, in an interval. (d,) [kg]

        Parameters
        ----------
        start, end : float   Of the interval; by default the whole session. [s]

        Returns
        -------
        (d,) float   nan where the speed does not change.
        """
        end = float(self.time[-1]) if end is None else end
        inside = (self.time >= start - 1e-12) & (self.time <= end + 1e-12)
        if np.count_nonzero(inside) < 2:
            raise ParameterError(f"start and end must enclose two results or more, got {start} and {end}")
        pushed = np.trapezoid(self.force[inside], self.time[inside], axis=0)
        changed = self.velocity[inside][-1] - self.velocity[inside][0]
        safe = np.where(changed == 0.0, 1.0, changed)
        return np.where(changed == 0.0, np.nan, pushed / safe)

    def leak(self, direction: Any, start: float = 0.0) -> float:
        """Speed of the handle across a constraint over the user's force across it, both as means from an instant on.

        Parameters
        ----------
        direction : (d,) float   Across the constraint, of any length.
        start : float            [s]

        Returns
        -------
        float   [m s^-1 N^-1]; 1 is 1000 mm/s per N. nan without a force across.

        Raises
        ------
        ParameterError
            If the direction is none.
        """
        across = real_array("direction", direction)
        fits = across.shape == (len(self.axes),) and bool(np.all(np.isfinite(across)) and np.any(across))
        require(fits, "direction", f"{direction}", f"{len(self.axes)} finite numbers, not all zero")
        across = across / np.linalg.norm(across)
        later = self.time >= start
        time = self.time[later]
        moved = float((self.position[later][-1] - self.position[later][0]) @ across)
        pushed = float(np.trapezoid(self.force[later] @ across, time))
        return moved / pushed if pushed else float("nan")

    @property
    def handle_work(self) -> float:
        """Work of the user's force and moment at the handle, between the results. [J]

        An arm's own mass, spring and damper take the rest of what its muscles give, "from user" in `joules`.
        """
        power = np.sum(self.force * self.velocity, axis=-1) + np.sum(self.moment * self.angular_velocity, axis=-1)
        return float(np.trapezoid(power, self.time))

    def _achieved(self) -> Iterator[str]:
        if self.path is not None:
            yield f"offset from the path {plain(1e3 * float(np.max(np.abs(self.path_offset))), 2)} mm at most"
            farthest = max((one.distance for one in self.overruns), default=0.0)
            if farthest:
                yield f"{plain(1e3 * farthest, 2)} mm past the end of the path"
        if self.wall is not None:
            deepest = max((touch.depth for touch in self.touches), default=0.0)
            first = float(np.ravel(self.penetration)[0])
            if first > _ROUNDED:
                yield f"the handle begins {plain(1e3 * first, 2)} mm beyond the wall"
            yield f"wall penetrated by {plain(1e3 * deepest, 2)} mm at most" if self.touches else "wall not penetrated"

    def _spent(self) -> Iterator[str]:
        yield from (f"{plain(float(energy[-1]))} J from the {name}" for name, energy in self.supplied.items())

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON: final energies, events, verdict."""
        return {
            "machine": self.title or type(self.machine).__name__,
            **self._judgement(),
            "duration_s": float(self.time[-1]),
            **self._balance(),
            "electrical_energy_J": self.electrical_energy,
            "events": self._log(settles=False),
            "touches": [{"start_s": one.start, "end_s": one.end, "depth_m": one.depth} for one in self.touches],
            "overruns": [{"start_s": one.start, "end_s": one.end, "distance_m": one.distance} for one in self.overruns],
        }


def touches(instants: np.ndarray, depth: np.ndarray) -> tuple[Touch, ...]:
    """Intervals of positive depth, (i,) at increasing instants; their ends are at instants at which the depth is 0."""
    return tuple(
        Touch(
            start=float(instants[max(first - 1, 0)]),
            end=float(instants[min(last, len(instants) - 1)]),
            depth=float(np.max(depth[first:last])),
        )
        for first, last in run_limits.intervals(depth > 0.0)
    )


def _spring(force: np.ndarray, terms: np.ndarray) -> tuple[float, float]:
    """Mean square residual and stiffness of a wall, from its force (t,) and penetration, inward speed and more (t, 3)."""
    within = terms[:, 0] > 0.0
    pushes, found, residual, hidden = within, np.zeros(3), np.inf, np.inf
    for _ in range(_ROUNDS):
        scale = np.maximum(np.max(np.abs(terms[pushes]), axis=0, initial=0.0), _ROUNDED)
        if np.count_nonzero(pushes) <= len(scale):
            return float("inf"), float("nan")
        table = terms[pushes] / scale
        inverse = np.linalg.pinv(table)
        found = inverse @ force[pushes] / scale
        off = force[pushes] - terms[pushes] @ found
        residual = float(np.mean(off**2))
        # A residual is at right angles to what is fitted; one of its size that is not could be in the stiffness.
        hidden = float(np.linalg.norm(off) * np.linalg.norm(inverse[0]) / scale[0])
        again = within & (terms[:, :2] @ found[:2] > 0.0)  # a wall does not pull
        if np.array_equal(again, pushes):
            break
        pushes = again
    return residual, float(found[0]) if hidden < _HIDDEN * found[0] else float("nan")
