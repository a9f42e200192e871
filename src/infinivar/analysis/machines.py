"""Compare machines in the tasks and on the paths of a study: one walk for all, over `Machine.perform`."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from typing import Any

import numpy as np

from infinivar import power
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.drivetrain.machines.legged import motor_mass
from infinivar.drivetrain.machines.machine import Machine, TaskPoint, as_machine, unit_of
from infinivar.errors import ParameterError, require
from infinivar.limits import LEADING, ROOT_MEAN_SQUARE, Demand, Limit, words_of
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.study.check import check_machines
from infinivar.study.study import Study
from infinivar.units import margin_words, plain

_BETWEEN = 15
"""Points between the ends of a range of wrenches of one coordinate at which limits are judged."""

_LOADED = 1e-6
"""Demand over allowance below which a limit counts as not loaded. [-]"""

_NO_DEMAND: Demand = (Limit.OK, "load")


@result
class TaskResult(Result):
    """One machine in one task.

    Attributes
    ----------
    title : str
    pose, twist, wrench : (d,) float   In the coordinates of the machine; the wrench on the load.
    corners : (m, d) float             Wrenches at which limits are judged: the task's own, corners of its polytope, and points
        between them if the machine has one coordinate.
    point : TaskPoint                  At the task's own wrench.
    demand : (Limit, part)             The tightest limit over all of them.
    margin : float                     Allowance over demand there; below 1 if infeasible. [-]
    corner : int                       The corner at which it is the tightest.
    audit_residual : float             Largest relative residual of the power balance. [-]
    """

    title: str
    coordinates: tuple[str, ...]
    pose: np.ndarray
    twist: np.ndarray
    wrench: np.ndarray
    corners: np.ndarray
    point: TaskPoint
    demand: Demand
    margin: float
    corner: int
    audit_residual: float

    @property
    def feasible(self) -> bool:
        """Whether every wrench of the polytope is within all limits."""
        return self.margin >= 1.0

    @property
    def mean_power(self) -> float:
        """Power from the source under the task's own wrench. [W]"""
        return float(self.point.power_in)

    @property
    def losses(self) -> dict[str, float]:
        """By name. [W]"""
        return {name: float(loss) for name, loss in self.point.losses.items()}

    @property
    def tightest_words(self) -> str:
        """The tightest limit, with its margin, and where if other wrenches are asked for."""
        where = "" if self.corner == 0 else f" at {_vector(self.coordinates, self.corners[self.corner], 'wrench')}"
        return tight_words(self.demand, self.margin) + where

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        return {
            "title": self.title,
            "feasible": self.feasible,
            "power_in_W": self.mean_power,
            "power_out_W": float(self.point.power_out),
            "losses_W": self.losses,
            "efficiency": float(self.point.efficiency),
            "tightest_limit": self.demand[0].name,
            "part": self.demand[1],
            "margin": self.margin,
            "parts": {
                part: {
                    "force": float(self.point.part_forces[place]),
                    "speed": float(self.point.part_speeds[place]),
                    "steering_rad": float(self.point.steering[place]),
                    "loss_W": float(self.point.part_losses[place]),
                }
                for place, part in enumerate(self.point.parts)
            },
            "audit_residual": self.audit_residual,
        }


@result
class PathResult(Result):
    """One machine on one path.

    Attributes
    ----------
    title, per : str                   Name, and what energies refer to.
    period : float                     [s]
    time : (t,) float                  [s]
    pose, twist, wrench : (t, d) float In the coordinates of the machine.
    point : TaskPoint                  At each instant.
    demands : (Limit, part) to float   Over the path: root mean squares of heating, peaks of all else. [-]
    demand, margin                     The tightest of them.
    audit_residual : float             [-]
    """

    title: str
    per: str
    coordinates: tuple[str, ...]
    period: float
    time: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    wrench: np.ndarray
    point: TaskPoint
    demands: Mapping[Demand, float]
    demand: Demand
    margin: float
    audit_residual: float

    @property
    def feasible(self) -> bool:
        """Whether all limits hold over the path."""
        return self.margin >= 1.0

    @property
    def mean_power(self) -> float:
        """Mean power from the source; nan where a wheel slips or the machine does not reach. [W]"""
        return float(np.mean(self.point.power_in))

    @property
    def energy(self) -> float:
        """Energy from the source over the period. [J]"""
        return self.mean_power * self.period

    @property
    def losses(self) -> dict[str, float]:
        """Means, by name. [W]"""
        return {name: float(np.mean(loss)) for name, loss in self.point.losses.items()}

    @property
    def tightest_words(self) -> str:
        """The tightest limit, with its margin."""
        return tight_words(self.demand, self.margin)

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Histories for a data file, by name with unit."""
        found = {"time_s": self.time}
        for what in ("pose", "twist", "wrench"):
            for place, name in enumerate(self.coordinates):
                unit = unit_of(name, what).replace("/", "_").replace(" ", "")
                found[f"{what}_{name}_{unit}"] = getattr(self, what)[:, place]
        return {
            **found,
            "power_in_W": np.asarray(self.point.power_in),
            "power_out_W": np.asarray(self.point.power_out),
            **{f"loss_{name.replace(' ', '_')}_W": np.asarray(loss) for name, loss in self.point.losses.items()},
        }

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        return {
            "title": self.title,
            "feasible": self.feasible,
            "period_s": self.period,
            "energy_J": self.energy,
            "mean_power_W": self.mean_power,
            "peak_power_W": float(np.max(self.point.power_in)),
            "mean_losses_W": self.losses,
            "tightest_limit": self.demand[0].name,
            "part": self.demand[1],
            "margin": self.margin,
            "audit_residual": self.audit_residual,
        }


@result
class MachineResult(Result):
    """One machine in all tasks and on all paths, by "tasks.NAME" and "paths.NAME"."""

    name: str
    title: str
    machine: Machine
    found: Mapping[str, TaskResult | PathResult]
    shares: Mapping[str, float] = field(default_factory=dict)
    motor_mass: float = float("nan")
    """Of all motors, of the steering as well. [kg]"""

    @property
    def tasks(self) -> dict[str, TaskResult]:
        """Results of tasks, by name."""
        return {_name(key): one for key, one in self.found.items() if isinstance(one, TaskResult)}

    @property
    def paths(self) -> dict[str, PathResult]:
        """Results of paths, by name."""
        return {_name(key): one for key, one in self.found.items() if isinstance(one, PathResult)}

    @property
    def feasible(self) -> bool:
        """Whether all tasks and paths are within all limits."""
        return all(one.feasible for one in self.found.values())

    @property
    def mean_power(self) -> float:
        """Weighed by the shares of time; nan without shares. [W]"""
        if not self.shares:
            return float("nan")
        return sum(share * self.found[key].mean_power for key, share in self.shares.items())

    @property
    def audit_residual(self) -> float:
        """Largest relative residual of the power balance. [-]"""
        return max(one.audit_residual for one in self.found.values())

    @property
    def verdict(self) -> str:
        """One clause: whether it is feasible, the tightest limit and where."""
        tight = min(self.found.values(), key=lambda one: one.margin)
        where = "" if len(self.found) == 1 else f" in {tight.title}"
        misses = sum(not one.feasible for one in self.found.values())
        able = (
            "feasible"
            if not misses
            else "infeasible"
            if len(self.found) == 1
            else f"infeasible in {misses} of {len(self.found)}"
        )
        used = f"; {plain(self.mean_power, 3)} W in mixed use" if self.shares and self.feasible else ""
        return f"{able}; {tight.tightest_words}{where}{used}"

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        return {
            "title": self.title,
            "feasible": self.feasible,
            "verdict": self.verdict,
            "mean_power_W": self.mean_power,
            "motor_mass_kg": self.motor_mass,
            "tasks": {name: one.to_dict() for name, one in self.tasks.items()},
            "paths": {name: one.to_dict() for name, one in self.paths.items()},
        }


@result
class MachineComparison(Result):
    """Machines of a study in its tasks and on its paths, as returned by `compare`."""

    study: Study
    results: Mapping[str, MachineResult]

    @property
    def feasible(self) -> bool:
        """Whether at least one machine is within all limits in every task and path."""
        return any(one.feasible for one in self.results.values())

    @property
    def best(self) -> MachineResult | None:
        """The feasible machine with the lowest mean power: in mixed use if shares are stated, else in every task and path."""
        able = [one for one in self.results.values() if one.feasible]
        if not able:
            return None
        if able[0].shares:
            return min(able, key=lambda one: one.mean_power)
        least = {min(able, key=lambda one: one.found[key].mean_power).name for key in able[0].found}
        return self.results[least.pop()] if len(least) == 1 else None

    @property
    def verdict(self) -> str:
        """The answer in one or two sentences."""
        count = len(self.results)
        able = [one for one in self.results.values() if one.feasible]
        best = self.best
        if count == 1:
            (one,) = self.results.values()
            return f"{one.title} is {one.verdict}."
        if not able:
            closest = max(self.results.values(), key=lambda one: min(found.margin for found in one.found.values()))
            return f"None of the {count} machines is feasible; closest: {closest.title}, {closest.verdict}."
        head = f"{len(able)} of {count} machines {'is' if len(able) == 1 else 'are'} feasible"
        if best is None:
            return f"{head}; none has the lowest power in each task."
        rest = [one for one in able if one is not best]
        if best.shares:
            against = f", against {_listed(rest, lambda one: one.mean_power)}" if rest else ""
            return f"{head}; lowest mean power: {best.title} with {plain(best.mean_power, 3)} W{against}."
        if not rest:
            return f"{head}: {best.title}; {best.verdict}."
        if len(best.found) > 1:
            return f"{head}; lowest power in each: {best.title}."
        (key,) = best.found
        against = _listed(rest, lambda one: one.found[key].mean_power)
        return f"{head}; lowest power: {best.title} with {plain(best.found[key].mean_power, 3)} W, against {against}."

    def to_dict(self) -> dict[str, Any]:
        """Verdicts as plain numbers, for scripts."""
        best = self.best
        return {
            "study": self.study.name,
            "drives": {name: one.to_dict() for name, one in self.results.items()},
            "verdict": self.verdict,
            "warnings": list(self.study.warnings),
            "feasible": self.feasible,
            "best": None if best is None else best.name,
        }


def _listed(rest: list[MachineResult], value: Callable[[MachineResult], float]) -> str:
    return ", ".join(f"{plain(value(one), 3)} W of {one.title}" for one in rest)


def _name(key: str) -> str:
    return key.partition(".")[2]


def compare_machines(study: Study, progress: Callable[[str, float], None] | None = None) -> MachineComparison:
    """Evaluate every drive of a study in its tasks and on its paths.

    Parameters
    ----------
    study : Study   With tasks or paths. Drives of one axis have the one coordinate x, or angle about a joint.
    progress        Called with the title of the current drive and the share of work done, 0 to 1.

    Returns
    -------
    MachineComparison

    Raises
    ------
    InputError
        If a drive lacks a coordinate that a task or path states.
    AuditError
        If a power balance does not close.
    """
    check_machines(study)
    results: dict[str, MachineResult] = {}
    count = len(study.tasks) + len(study.paths)
    for index, (name, drive) in enumerate(study.drives.items()):
        machine, found = as_machine(drive), {}

        def report(done: int, title: str = study.titles[name], index: int = index) -> None:
            if progress is not None:
                progress(title, (index + done / count) / len(study.drives))

        for task, one in study.tasks.items():
            report(len(found))
            found[f"tasks.{task}"] = perform_task(machine, one)
        for path, one in study.paths.items():
            report(len(found))
            found[f"paths.{path}"] = follow_path(machine, one)
        results[name] = MachineResult(
            name=name,
            title=study.titles[name],
            machine=machine,
            found=FrozenDict(found),
            shares=FrozenDict(study.machine_shares),
            motor_mass=motor_mass(drive),
        )
    return MachineComparison(study=study, results=FrozenDict(results))


def perform_task(drive: Any, task: MachineTask) -> TaskResult:
    """One machine, or drive of one axis, in a task: all losses, and limits at every corner of its polytope of wrenches.

    Raises
    ------
    ParameterError
        If the task states a coordinate that the machine does not have.

    Notes
    -----
    Between the corners the demands of most machines are smaller: at one twist and pose they are convex in the wrench, as forces
    of links are linear in it. Where creep by spin changes with the load, as on a sphere, they need not be: a machine of one
    coordinate is judged at points between them, too.
    """
    machine = as_machine(drive)
    names = machine.coordinates
    require(isinstance(task, MachineTask), "task", f"a {type(task).__name__}", "a MachineTask")
    for key, vector in task.vectors.items():
        for name in vector.beyond(names):
            raise ParameterError(f"{key}.{name} does not apply: the machine has {', '.join(names)} only")
    pose, twist, corners = task.pose.row(names, machine.home), task.twist.row(names), _judged(task.corners(names))
    every = machine.perform(pose=pose, twist=twist, wrench=corners)
    residual = power.audit(every.power_in, every.power_out, every.losses, f"task {task.title!r}")
    margins = np.empty(len(corners))
    tightest = []
    for place in range(len(corners)):
        demand, margins[place] = tightest_of({key: float(values[place]) for key, values in every.demands.items()})
        tightest.append(demand)
    corner = int(np.argmin(margins))
    return TaskResult(
        title=task.title,
        coordinates=names,
        pose=pose,
        twist=twist,
        wrench=corners[0],
        corners=corners,
        point=every.first(),
        demand=tightest[corner],
        margin=float(margins[corner]),
        corner=corner,
        audit_residual=residual,
    )


def _judged(corners: np.ndarray) -> np.ndarray:
    """The wrenches at which a task is judged: the corners, and of one coordinate as many between them as show a maximum."""
    if corners.shape[-1] > 1 or len(corners) == 1:
        return corners
    between = np.linspace(np.min(corners), np.max(corners), _BETWEEN + 2)[1:-1]
    return np.concatenate([corners, between[~np.isin(between, corners[:, 0])][:, None]])


def follow_path(drive: Any, path: MachinePath) -> PathResult:
    """One machine, or drive of one axis, on a path: operation at every instant, as if it were steady.

    The wrench accelerates the load; inertias within the machine, the steering and the warming of windings are left out.
    """
    machine = as_machine(drive)
    at = path.instants(machine.coordinates, machine.home)
    point = machine.perform(pose=at.pose, twist=at.twist, wrench=at.wrench)
    residual = power.audit(point.power_in, point.power_out, point.losses, f"path {path.title!r}")
    demands = {key: _over_time(key, np.asarray(values)) for key, values in point.demands.items()}
    demand, margin = tightest_of(demands)
    return PathResult(
        title=path.title,
        per=path.per,
        coordinates=machine.coordinates,
        period=path.period,
        time=at.time,
        pose=at.pose,
        twist=at.twist,
        wrench=at.wrench,
        point=point,
        demands=FrozenDict(demands),
        demand=demand,
        margin=margin,
        audit_residual=residual,
    )


def _over_time(key: Demand, values: np.ndarray) -> float:
    """Demand over a path at equal steps; inf where it is undefined at an instant at which a wheel slips."""
    if key[0] in LEADING:
        return float(np.max(np.where(np.isnan(values), np.inf, values)))
    return float(np.sqrt(np.mean(values * values))) if key[0] in ROOT_MEAN_SQUARE else float(np.max(values))


def tightest_of(demands: Mapping[Demand, float]) -> tuple[Demand, float]:
    """The largest demand, with its margin; a linkage out of reach and slip take precedence, as in `infinivar.limits.binding`."""
    exceeded = [
        (limit.value, key)
        for limit in reversed(LEADING)
        for key in demands
        if key[0] is limit and not demands[key] <= 1.0
    ]
    if exceeded:
        first = exceeded[0][1][0]
        worst = functools.reduce(
            lambda one, other: other if _size(demands[other]) > _size(demands[one]) else one,
            [key for key in demands if key[0] is first],
        )
        return worst, 1.0 / _size(demands[worst])
    known = {key: value for key, value in demands.items() if np.isfinite(value) and value > _LOADED}
    if not known:
        return _NO_DEMAND, float("inf")
    worst = max(known, key=lambda key: known[key])
    return worst, 1.0 / known[worst]


def _size(demand: float) -> float:
    return float("inf") if np.isnan(demand) else demand


def tight_words(demand: Demand, margin: float) -> str:
    """A tightest limit in words, with its margin."""
    if demand == _NO_DEMAND:
        return "no limit is loaded"
    if margin >= 1.0:
        return f"tightest limit: {words_of(demand)} (margin {margin_words(margin)})"
    if margin == 0.0 and demand[0] is Limit.LINKAGE:
        return "singular pose: the links leave a motion of the machine free"
    if margin == 0.0:
        return f"no steady motion: {words_of(demand)}"
    share = "just under 100" if margin >= 0.995 else f"{100 * margin:.0f}" if margin >= 0.005 else "less than 1"
    return f"tightest limit: {words_of(demand)}, {share} % of the demand"


def _vector(coordinates: tuple[str, ...], values: np.ndarray, what: str) -> str:
    """A vector as "x 20 N, rz 0.1 N m", without zeros."""
    return ", ".join(vector_words(coordinates, values, what)) or "no load"


def vector_words(coordinates: tuple[str, ...], values: np.ndarray, what: str) -> Iterator[str]:
    """Yield each component that is not zero, with its unit."""
    for name, value in zip(coordinates, values, strict=True):
        if value != 0.0:
            yield f"{name} {plain(float(value), 3)} {unit_of(name, what)}"
