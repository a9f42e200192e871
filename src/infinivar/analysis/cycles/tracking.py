r"""Compare a motion prescribed (inverse dynamics) with the same motion simulated under control, and explain the difference.

Where the controllers follow the motion, three laws explain the difference of the energies:

1. The cylinder's speed, prescribed as constant, varies as its inertia stores and returns energy.
2. Inverse dynamics counts Coulomb friction in full at any speed. Sampled controllers leave the load at rest where it is to
   move more slowly than they resolve, and friction holds it. With the power P of the motion and the power P_h that holds its
   force,

   .. math:: \Delta E = -\int_T (P - P_h)\,dt, \qquad T = \{t : |v| \le v_s,\ |a| \le v_s f_s\}

   where v and a are speed and acceleration of the motion, v_s is the stick speed of the controllers and f_s their sample rate.
   Friction of steering falls below its stick speed as `infinivar.contact.friction.coulomb` has it.
3. While the load comes to rest, and is held by friction on which the controllers rely only in part, they take more than P_h.

The first two are computed by inverse dynamics of the motion as the controllers carry it out, the third from the simulation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from infinivar._core.described import derived, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.simulate import Simulation, simulate
from infinivar.axis import LINEAR, Axis
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.graphs.closed_loop import closed_loop
from infinivar.errors import ParameterError
from infinivar.motion.course import Course
from infinivar.motion.duty_cycles import DutyCycle, check_duty_cycle
from infinivar.motion.motion import MotionState
from infinivar.motion.scenario import Scenario
from infinivar.transmission.rates import Varying
from infinivar.units import percent, plain, signed

LONGEST = 5.0
"""Longest cycle that a report simulates. [s]"""

_NODES = 2000
"""Spline nodes of motion and force over a cycle."""
_LEAD = 1.0
"""Least time in which the controllers settle before the cycle that is evaluated, in whole cycles. [s]"""
_STEPS = 400
"""Output steps over a cycle."""

_SMALL = 1e-3
"""Relative energy difference below which no digits are shown."""
_CHANGES = (
    *("speed", "acceleration", "jerk", "snap", "fifth", "sixth"),
    *("force_rate", "force_curvature", "force_third", "force_fourth"),
)
"""Derivatives of a course that are zero at rest."""

_NAMED = 4
"""Number of parts of the difference that are named."""


def _places(size: float) -> int:
    """Number of decimals that shows two significant digits."""
    return max(0, 1 - math.floor(math.log10(size))) if 0.0 < size < math.inf else 0


@result
class TwoWays(Result):
    """Energy of one cycle by inverse dynamics and by simulation, windings at 25 °C.

    Attributes
    ----------
    prescribed, followed : float             Energy from the supply, prescribed and simulated. [J]
    as_turning : float                       Prescribed energy at the simulated cylinder speed; nan if the cylinder stops. [J]
    as_resting : float                       The same, with the load at rest where the controllers leave it at rest. [J]
    stopping : float                         Energy that they take there beyond that of holding by friction. [J]
    left_at_rest : float                     Time per cycle in which they leave it at rest though it is to move slowly. [s]
    slowest : float                          Speed up to which they may leave it at rest. [m/s], [rad/s]
    lost_prescribed, lost_followed           Losses by name. [J]
    rms_error : float                        RMS position error of the load. [m], [rad]
    rotary : bool                            Whether the load moves about a joint.
    speed_ripple : float                     Largest relative deviation of the cylinder speed; 0 without a cylinder. [-]
    stored : float                           Increase over the simulated cycle of the energy in inertias of drive and load. [J]
    """

    prescribed: float = reported("J")
    as_turning: float
    as_resting: float
    stopping: float
    left_at_rest: float
    slowest: float
    followed: float = reported("J")
    lost_prescribed: Mapping[str, float]
    lost_followed: Mapping[str, float]
    rms_error: float
    speed_ripple: float
    stored: float
    simulation: Simulation
    rotary: bool = False

    @property
    def as_controlled(self) -> float:
        """Prescribed energy with what the controllers do: cylinder speed, rest, and what coming to rest and holding take. [J]"""
        return self.as_resting + self.stopping

    @derived()
    def explanation(self) -> str:
        """Explanation of the difference between both energies."""
        total = self.followed - self.prescribed
        why = [*self.simulation.warnings, _error(self.rms_error, self.rotary)]
        places = _places(max(abs(total), _SMALL * abs(self.followed)))
        digit = 0.5 * 10.0**-places
        if self.speed_ripple and not abs(self.as_turning - self.prescribed) < digit:
            why.append(
                f"the cylinder speed, prescribed as constant, varies by {percent(self.speed_ripple, 1)} as the cylinder's "
                "inertia stores and returns energy; with the simulated speed prescribed, the difference is "
                f"{signed(self.followed - self.as_turning, 2)} J"
            )
        if max(abs(self.as_resting - self.as_turning), abs(self.stopping)) >= digit:
            slow = f"{plain(self.slowest, 2)} rad/s" if self.rotary else f"{plain(1e3 * self.slowest, 2)} mm/s"
            meets = " and steering as slow meets less friction" if self.speed_ripple else ""
            why.append(
                f"inverse dynamics counts friction in full at any speed; below {slow} ({plain(self.left_at_rest, 2)} s of the "
                f"cycle) the controllers leave the load at rest, held by friction{meets}: "
                f"{self.as_resting - self.as_turning:+.{places}f} J; bringing it to rest and holding it takes "
                f"{self.stopping:+.{places}f} J; {self.followed - self.as_controlled:+.{places}f} J remain"
            )
        share = f" ({percent(total / self.prescribed, 1, '+')})" if self.prescribed else ""
        parts = self._parts(digit)
        where = ": " + ", ".join(f"{name} {change:+.{places}f} J" for name, change in parts.items()) if parts else ""
        return f"{total:+.{places}f} J{share}{where}; {'; '.join(why)}"

    def _parts(self, least: float) -> dict[str, float]:
        """Parts of the difference by decreasing size: losses, work on the load, stored energy; `least` is the smallest named. [J]

        The parts add up to the difference because both energy balances close.
        """
        names = dict.fromkeys([*self.lost_prescribed, *self.lost_followed])
        moved = {name: self.lost_followed.get(name, 0.0) - self.lost_prescribed.get(name, 0.0) for name in names}
        moved["stored in inertias"] = self.stored
        moved["work on the load"] = self.followed - self.prescribed - sum(moved.values())
        named = [name for name in sorted(moved, key=lambda name: -abs(moved[name])) if abs(moved[name]) >= least][
            :_NAMED
        ]
        rest = sum(change for name, change in moved.items() if name not in named)
        found = {name: moved[name] for name in named}
        return found if abs(rest) < least else {**found, "other": rest}


def two_ways(drive: AnyDrive, duty: DutyCycle) -> TwoWays:
    """Compute the energy of one cycle by inverse dynamics and by simulation.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive   Must have all values that simulation requires.
    duty : DutyCycle

    Returns
    -------
    TwoWays   The simulated cycle follows one cycle in which the controllers settle, or several that last a second.

    Raises
    ------
    ParameterError
        If the drive lacks a value that simulation requires, or the motion is a run.
    """
    check_duty_cycle(duty)
    if not duty.closed:
        raise ParameterError("duty must repeat to be simulated beside inverse dynamics; a run starts in motion")
    period, mass = duty.period, duty.moved_mass
    nodes = np.arange(_NODES) * (period / _NODES)
    position, course = duty.at(nodes)
    push = np.broadcast_to(np.asarray(course.force, dtype=float), nodes.shape)
    step = period / _STEPS
    lead = _STEPS * math.ceil(_LEAD / period)
    scenario = Scenario(
        title=duty.title,
        duration=(lead + _STEPS) * step,
        output_step=step,
        motion=_Repeated(period, position, duty.axis),
        force=_Repeated(period, push, duty.axis) if np.any(push) else None,
        load_mass=None if duty.axis.rotary else mass or None,
        load_inertia=mass or None if duty.axis.rotary else None,
    )
    run = simulate(drive, scenario)
    instants = duty.instants(orders=drive.orders)
    controller = closed_loop(drive, scenario).controller
    rests = _left_at_rest(controller, lead * step + instants.time)
    point = drive.follow(instants.course, load_mass=mass)
    first = min(lead, len(run.trajectory.time) - 1)

    def over(values: Any) -> float:
        return float(values[-1] - values[first])

    trajectory = run.trajectory
    position_error = run.position_error[first:]
    resting = _resting(instants.course, mass, rests)
    ripple = 0.0
    if isinstance(drive, CoboticDrive):
        turning = run.columns["cylinder_speed_rad_s"][first:]
        ripple = float(np.max(np.abs(turning / drive.cylinder_speed - 1.0)))
        turned = _turned(drive, duty, instants.time, turning)
        by_turning = by_resting = np.full(rests.shape, math.nan)
        if turned is not None:
            by_turning = _power(drive, duty, instants.course, cylinder_speed=turned)
            by_resting = _power(drive, duty, resting, cylinder_speed=turned)
            by_resting = by_resting + drive.slow_friction(drive.roll(resting, load_mass=mass, cylinder_speed=turned))
    else:
        by_turning, by_resting = point.power_in, _power(drive, duty, resting)
    supplied = sum(values for title, values in trajectory.supplied.items() if "supply" in title)
    each = np.diff(np.interp(np.linspace(lead, lead + _STEPS, len(rests) + 1) * step, trajectory.time, supplied))
    return TwoWays(
        prescribed=float(np.mean(point.power_in)) * period,
        as_turning=float(np.mean(by_turning)) * period,
        as_resting=float(np.mean(by_resting)) * period,
        stopping=float(np.sum((each - by_resting * (period / len(each)))[rests])),
        left_at_rest=float(np.mean(rests & ~np.asarray(instants.course.at_rest))) * period,
        slowest=controller.standstill.sliding,
        followed=over(supplied),
        lost_prescribed=FrozenDict({name: float(np.mean(loss)) * period for name, loss in point.losses.items()}),
        lost_followed=FrozenDict({name: over(values) for name, values in trajectory.lost.items()}),
        rms_error=float(np.sqrt(np.mean(position_error**2))),
        speed_ripple=ripple,
        stored=sum(over(values) for values in trajectory.stored.values()),
        simulation=run,
        rotary=duty.axis.rotary,
    )


def _error(size: float, rotary: bool) -> str:
    return f"RMS angle error {plain(size, 2)} rad" if rotary else f"RMS position error {plain(1e3 * size, 2)} mm"


def _power(drive: AnyDrive, duty: DutyCycle, course: Course, **options: Any) -> np.ndarray:
    """Power from the supply by inverse dynamics, at each instant. (n,) [W]"""
    point = drive.follow(course, load_mass=duty.moved_mass, **options)
    return np.broadcast_to(np.asarray(point.power_in), np.shape(course.speed))


def _turned(drive: CoboticDrive, duty: DutyCycle, time: np.ndarray, turning: np.ndarray) -> Varying | None:
    """Cylinder speed given in equal time steps of a cycle, at instants; None if it stops."""
    if len(turning) <= _STEPS or np.min(turning / drive.cylinder_speed) <= 0.0:
        return None
    speed, rate, _ = _Repeated(duty.period, turning[:-1]).over(time)
    return Varying(speed, rate)


def _left_at_rest(controller: Any, time: np.ndarray) -> np.ndarray:
    """Whether controllers leave a load that follows its motion at rest, at times of the scenario. (n,)"""
    goals = [controller.path.at(instant) for instant in time.tolist()]
    return np.array([controller.standstill.near(False, goal, goal.position) for goal in goals])


def _resting(course: Course, mass: float, rests: np.ndarray) -> Course:
    """A course with the load at rest at some instants, under the force that the drive exerts there."""

    def held(values: Any) -> Any:
        return None if values is None else np.where(rests, 0.0, values)

    return replace(
        course,
        **{field: held(getattr(course, field)) for field in _CHANGES},
        force=np.where(rests, np.asarray(course.force) - mass * np.asarray(course.acceleration), course.force),
    )


class _Repeated:
    """A motion or force of a duty cycle for a scenario: a periodic cubic spline, quick at single instants."""

    shape: ClassVar[str] = "duty cycle"
    breaks: Sequence[float] = ()

    def __init__(self, period: float, values: np.ndarray, axis: Axis = LINEAR) -> None:
        """From values at equal steps over a cycle.

        Source: deboor2001, chapter IV (continuity of the slopes), solved wave by wave.
        """
        self.axis: Axis = axis
        self.period: float = period
        self.step: float = period / len(values)
        after = np.roll(values, -1)
        wave = np.cos(2.0 * np.pi * np.fft.rfftfreq(len(values)))
        curved = np.fft.rfft((after - 2.0 * values + np.roll(values, 1)) / self.step**2)
        bend = np.fft.irfft(3.0 * curved / (2.0 + wave), len(values))  # second derivative at the nodes
        rise = np.roll(bend, -1) - bend
        slope = (after - values) / self.step - self.step * (0.5 * bend + rise / 6.0)
        self.pieces: list[list[float]] = np.stack(
            [rise / (6.0 * self.step), 0.5 * bend, slope, values], axis=-1
        ).tolist()

    def __eq__(self, other: object) -> bool:
        """Whether the other repeats the same spline."""
        return isinstance(other, _Repeated) and vars(self) == vars(other)

    def at(self, time: float) -> MotionState:
        """Value and its first two derivatives at a time [s]."""
        return MotionState(*_cubic(*self._piece(time)))

    def over(self, times: np.ndarray) -> tuple[np.ndarray, ...]:
        """As `at`, at many times. (n,) each"""
        since = times % self.period
        places = np.minimum((since / self.step).astype(int), len(self.pieces) - 1)
        return _cubic(since - places * self.step, np.array(self.pieces)[places].T)

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        return self.at(time)[0]

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        return self.at(time)[1]

    def _piece(self, time: float) -> tuple[float, list[float]]:
        """Time since the last node [s], and the polynomial from there on."""
        since = time % self.period
        place = min(int(since / self.step), len(self.pieces) - 1)
        return since - place * self.step, self.pieces[place]


def _cubic(s: Any, piece: Any) -> tuple[Any, Any, Any]:
    """Value and first two derivatives of a polynomial, highest power first, at a time since its begin."""
    cubic, square, linear, constant = piece
    return (
        constant + s * (linear + s * (square + s * cubic)),
        linear + s * (2.0 * square + 3.0 * s * cubic),
        2.0 * square + 6.0 * s * cubic,
    )
