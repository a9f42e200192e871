"""What candidates are judged by: motions and the required region, and what each asks of the gear's output at a stage.

With the sign s of the speed, the torque, the angular acceleration and the speed at the gear's output count positive with the
motion: ``x = (torque s, acceleration s, |speed|)``. All candidates with one stage share them. Cobotic drives are searched and
judged at other points of a required region.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from infinivar.analysis.cycles import performance
from infinivar.drivetrain import chain
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import MOTOR_LIMITS, Drive, axis_fault, operated, orders_of, placed, smoothness_fault
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.motion.duty_cycles import DutyCycle, Instants
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.candidates import with_stage
from infinivar.sizing.geared.extremes import braking_places, extreme_places, least_places
from infinivar.study.requirement import Requirement

_EDGE = 60
"""Most points of the edge of a quadrant of the required region at which wheel designs are searched."""
_INSIDE = 10_000
"""Points inside the required region, about, at which the designs found are judged."""


REQUIREMENT = "requirement"
"""Name of the required region among the tasks."""

PROBE = Motor(
    voltage=1.0, resistance=1.0, torque_constant=1.0, no_load_current=0.0, continuous_torque=1.0, rotor_inertia=1.0
)
DIRECT = Gearhead(ratio=1.0, efficiency=1.0)
_OF_CANDIDATES = ("motor", "gearhead")


class StageSignals(NamedTuple):
    """What a task asks of the gear's output at a stage."""

    moving: np.ndarray
    """Torque, angular acceleration and speed with the motion, at each instant in motion. (n, 3) [N m], [rad s^-2], [rad s^-1]"""
    resting: np.ndarray
    """Size of the torque at each instant at rest, in rising order. (m,) [N m]"""
    others: Mapping[Demand, float]
    """Demand over allowance of limits that no candidate changes: of stage, springs, linkage and travel. [-]"""

    @property
    def total(self) -> int:
        """Number of instants."""
        return len(self.moving) + len(self.resting)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MotionTask:
    """A motion, at its instants."""

    name: str
    duty: DutyCycle
    instants: Instants
    travel: float | None

    @property
    def root_mean_square(self) -> bool:
        """Whether continuous torques bound the root mean square."""
        return True

    @property
    def exceeds_travel(self) -> bool:
        """Whether the motion is longer than the travel, which no candidate changes."""
        return self.travel is not None and float(np.ptp(self.instants.position)) > self.travel

    @property
    def period(self) -> float:
        """Of one cycle or the run. [s]"""
        return self.duty.period

    @property
    def coldest(self) -> float:
        """Lowest temperature that a winding can have. [K]"""
        return self.duty.ambient if self.duty.closed else min(self.duty.ambient, self.duty.start)

    def signals(self, template: ConventionalDrive, stage: OutputStage) -> StageSignals:
        """What the motion asks of the gear's output at a stage."""
        drive = with_stage(replace(template, motor=PROBE, gearhead=DIRECT), stage)
        course, mass = self.instants.course, self.duty.moved_mass
        point = drive.follow(course, load_mass=mass)
        inner = chain.inward(drive.chain, course, mass, drive.axis, (2, 0)).course
        shape = self.instants.time.shape
        torque, speed, acceleration = (
            np.broadcast_to(np.asarray(values, dtype=float), shape)
            for values in (
                point.states["gear_output_torque_Nm"],
                point.states["motor_speed_rad_s"],
                inner.acceleration / stage.travel_per_radian,
            )
        )
        others = {
            key: float(demand) for key, demand in performance.demands(point).items() if key[1] not in _OF_CANDIDATES
        }
        if self.travel is not None:
            others[Limit.TRAVEL, "load"] = float(np.ptp(self.instants.position)) / self.travel
        return _with_the_motion(torque, acceleration, speed, others)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RegionTask:
    """The required region of the force-speed plane, at the points where `compare` judges it."""

    speed: np.ndarray
    force: np.ndarray
    name: str = REQUIREMENT

    @property
    def root_mean_square(self) -> bool:
        """Continuous torques bound every point."""
        return False

    @property
    def coldest(self) -> float:
        """Windings count as at 25 °C."""
        return float("nan")

    def signals(self, template: ConventionalDrive, stage: OutputStage) -> StageSignals:
        """What the region asks of the gear's output at a stage."""
        drive = with_stage(replace(template, motor=PROBE, gearhead=DIRECT), stage)
        point = operated(drive, speed=self.speed, force=self.force)
        torque, speed = (
            np.broadcast_to(point.states[name], self.speed.shape) for name in ("motor_torque_Nm", "motor_speed_rad_s")
        )
        demands = {key: float(np.max(demand)) for key, demand in placed(point.utilisation, stage.title).items()}
        others = {key: demand for key, demand in demands.items() if key[0] not in MOTOR_LIMITS}
        return _with_the_motion(torque, np.zeros_like(torque), speed, others)

    def critical(self, template: ConventionalDrive, stage: OutputStage) -> RegionTask:
        """The points at which some candidate can have its largest demand, and those that decide whether it returns power.

        Current and voltage with the motion are convex in torque and speed, as a gear loses less of what it returns than of what
        it passes on, and rise with both: their largest values are at corners of the convex hull, their smallest at points that
        no other undercuts in both.
        """
        points = self.signals(template, stage).moving[:, [0, 2]]
        if not np.isfinite(points).all():  # out of reach
            return self
        drives = points[:, 0] > 0.0
        keep = [least_places(points)]
        keep += [np.flatnonzero(part)[extreme_places(points[part])] for part in (drives, ~drives)]
        if template.amplifier.regeneration == "none":
            keep.append(braking_places(points))
        places = np.unique(np.concatenate(keep))
        return replace(self, speed=self.speed[places], force=self.force[places])


Task = MotionTask | RegionTask


def tasks_of(
    template: Drive,
    duty: Mapping[str, DutyCycle],
    requirement: Requirement | None,
    travel: float | None = None,
    samples: int | None = None,
) -> tuple[Task, ...]:
    """The required region, if there is one, and every motion.

    Raises
    ------
    ParameterError
        If there is neither, or a motion does not fit the drive.
    """
    if not duty and requirement is None:
        raise ParameterError("duty and requirement are both missing: state at least one motion or a required region")
    found: list[Task] = []
    if requirement is not None:
        speed, force, _ = requirement.sample()
        found.append(RegionTask(speed=speed, force=force))
    for name, motion in duty.items():
        where = f"duty.{name}"
        if name == REQUIREMENT:
            raise ParameterError(f"{where}: {REQUIREMENT!r} names the required region; choose another name")
        fault = axis_fault(template, motion.axis, "the drive", where) or smoothness_fault(
            template, motion, "the drive", where
        )
        if fault is not None:
            raise ParameterError(fault)
        instants = motion.instants(samples, orders_of(template))
        found.append(MotionTask(name=name, duty=motion, instants=instants, travel=travel))
    return tuple(found)


def without_travel(tasks: Sequence[Task]) -> tuple[Task, ...]:
    """The tasks without the travel, which is the same for all candidates."""
    return tuple(replace(task, travel=None) if isinstance(task, MotionTask) else task for task in tasks)


def heat_counts(task: object) -> bool:
    """Whether a winding temperature replaces the continuous torque where the motor's thermal data are known: in a run."""
    return isinstance(task, MotionTask) and not task.duty.closed


def _with_the_motion(
    torque: np.ndarray, acceleration: np.ndarray, speed: np.ndarray, others: Mapping[Demand, float]
) -> StageSignals:
    sign = np.sign(speed)
    moves = sign != 0.0
    moving = np.stack([torque * sign, acceleration * sign, np.abs(speed)], axis=-1)[moves]
    return StageSignals(moving, np.sort(np.abs(torque[~moves])), others)


def outer(task: RegionTask) -> RegionTask:
    """Some points of the edge of a required region: where it lets speed and force be largest.

    With the force in one direction the wheel needs the more lateral force and the larger angle, and the cylinder the more
    torque, the larger speed and force are; the designs found are judged inside as well.
    """
    some = [edge[np.unique(np.linspace(0, len(edge) - 1, _EDGE).astype(int))] for edge in _edges(task)]
    return _at(task, np.concatenate(some))


def judging_points(task: RegionTask) -> RegionTask:
    """The whole edge of a required region, and a grid inside."""
    inside = np.arange(0, len(task.speed), 1 + len(task.speed) // _INSIDE)
    return _at(task, np.unique(np.concatenate([inside, *_edges(task)])))


def _at(task: RegionTask, places: np.ndarray) -> RegionTask:
    return replace(task, speed=task.speed[places], force=task.force[places])


def _edges(task: RegionTask) -> list[np.ndarray]:
    """Points of each quadrant of which no other is beyond them in both speed and force, by falling force."""
    quadrant = np.signbit(task.speed) * 2 + np.signbit(task.force)
    found = []
    for one in np.unique(quadrant):
        here = np.flatnonzero(quadrant == one)
        speed, force = np.abs(task.speed[here]), np.abs(task.force[here])
        order = np.lexsort((-speed, -force))
        before = np.concatenate([[-np.inf], np.maximum.accumulate(speed[order])[:-1]])
        found.append(here[order[speed[order] > before]])
    return found
