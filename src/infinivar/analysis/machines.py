"""Compare machines in the tasks and on the paths of a study: one walk for all, over `perform_task` and `follow_path`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from typing import Any

from infinivar._core.described import at, derived, named, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.hanging import Hanging, Judged, winner
from infinivar.analysis.machine_tasks import PathResult, TaskResult
from infinivar.analysis.options import CompareOptions
from infinivar.analysis.performing import Prepared, evaluated, power_and_margin
from infinivar.drivetrain.uncounted import uncounted
from infinivar.machines.kinds.linked import motor_mass
from infinivar.machines.machine import Machine, as_machine
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.study.check import check_machines
from infinivar.study.study import Study
from infinivar.units import plain


@result
class MachineResult(Result):
    """One machine in all tasks and on all paths, by "tasks.NAME" and "paths.NAME"."""

    name: str
    title: str = reported()
    machine: Machine
    found: Mapping[str, TaskResult | PathResult]
    shares: Mapping[str, float] = field(default_factory=dict)
    motor_mass: float = reported("kg", default=float("nan"))
    """Of all motors that are stated, also of those that steer the wheels of legs. [kg]"""

    @derived()
    def tasks(self) -> dict[str, TaskResult]:
        """Results of tasks, by name."""
        return {_name(key): one for key, one in self.found.items() if isinstance(one, TaskResult)}

    @derived()
    def paths(self) -> dict[str, PathResult]:
        """Results of paths, by name."""
        return {_name(key): one for key, one in self.found.items() if isinstance(one, PathResult)}

    @derived()
    def feasible(self) -> bool:
        """Whether all tasks and paths are within all limits."""
        return all(one.feasible for one in self.found.values())

    @derived("W")
    def mean_power(self) -> float:
        """Weighed by the shares of time; nan without shares. [W]"""
        return self._weighed("mean_power")

    @derived("W")
    def steady_power(self) -> float:
        """The same of steady points. [W]"""
        return self._weighed("steady_power")

    @property
    def controlled_power(self) -> float:
        """The same with the friction of simulations. [W]"""
        return self._weighed("controlled_power")

    def _weighed(self, name: str) -> float:
        if not self.shares:
            return float("nan")
        return sum(share * getattr(self.found[key], name) for key, share in self.shares.items())

    @derived(key="not_counted")
    def lacking(self) -> Mapping[str, str]:
        """What does not count, "steering", "rotors", "moving masses" or bearings that carry forces, with the reason."""
        return {**lacking_of(self.machine), **dict.fromkeys(uncounted(self.machine), "none are stated")}

    @property
    def audit_residual(self) -> float:
        """Largest relative residual of the power balance. [-]"""
        return max(one.audit_residual for one in self.found.values())

    @derived()
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
        used = f"; {power_words(self)} in mixed use" if self.shares and self.feasible else ""
        return f"{able}; {tight.tightest_words}{where}{used}"


@result
class MachineComparison(Result):
    """Machines of a study in its tasks and on its paths, as returned by `compare`."""

    study: Study = reported(convert=named)
    results: Mapping[str, MachineResult] = reported(key="drives")
    hangs_on: Hanging | None = reported(optional=True, default=None)
    """Choices that no source settles, each with the winner it gives."""
    changes: Mapping[str, tuple[str, ...]] = reported(default_factory=FrozenDict)
    """What would make each infeasible machine feasible, if that was sought: the smallest change first."""
    options: CompareOptions = field(default=CompareOptions(), compare=False, repr=False)
    """With which it was computed."""

    _also = (at("study.warnings"),)

    @derived()
    def feasible(self) -> bool:
        """Whether at least one machine is within all limits in every task and path."""
        return any(one.feasible for one in self.results.values())

    @property
    def all_feasible(self) -> bool:
        """Whether every machine is within all limits."""
        return all(one.feasible for one in self.results.values())

    @derived(convert=named)
    def best(self) -> MachineResult | None:
        """The feasible machine with the lowest mean power: in mixed use if shares are stated, else in every task and path."""
        best = winner({name: judged_machine(one) for name, one in self.results.items()})
        return None if best is None else self.results[best]

    @derived()
    def verdict(self) -> str:
        """The answer in one or two sentences, and what does not count; undecidable if an open choice changes the winner."""
        prefix = "" if self.hangs_on is None else self.hangs_on.prefix
        return prefix + " ".join(one for one in (self._answer, self.not_counted) if one)

    @property
    def not_counted(self) -> str:
        """A sentence on what the powers leave out; empty if nothing."""
        titles: dict[tuple[str, str], list[str]] = {}
        for one in self.results.values():
            for what, why in one.lacking.items():
                titles.setdefault((what, why), []).append(one.title)
        every = len(self.results)
        said = [
            f"{what} ({why})" if len(names) == every else f"{what} of {' and '.join(names)} ({why})"
            for (what, why), names in titles.items()
        ]
        return f"Not counted: {', '.join(said)}." if said else ""

    @property
    def _answer(self) -> str:
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
            against = f", against {_listed(rest)}" if rest else ""
            return f"{head}; lowest mean power: {best.title} with {power_words(best)}{against}."
        if not rest:
            return f"{head}: {best.title}; {best.verdict}."
        if len(best.found) > 1:
            return f"{head}; lowest power in each: {best.title}."
        (key,) = best.found
        return f"{head}; lowest power: {best.title} with {power_words(best.found[key])}, against {_listed(rest, key)}."


def change_lines(comparison: MachineComparison) -> Iterator[str]:
    """Yield what would make each infeasible machine feasible, if that was sought."""
    for name, found in comparison.changes.items():
        title = comparison.results[name].title
        yield (
            f"{title} would be feasible with {', or with '.join(found)}."
            if found
            else f"{title}: no change of one or two values of wheel, cylinder, gear or motor, from a fifth to five times "
            "the present ones, makes it feasible."
        )


def judged_machine(found: MachineResult, power: str = "mean_power") -> Judged:
    """What decides on a machine: its mean power in mixed use, or in each task and path without shares."""
    judged = (found,) if found.shares else found.found.values()
    return Judged(found.feasible, tuple(getattr(one, power) for one in judged))


def decided_machine(drive: Any, prepared: Prepared, shares: Mapping[str, float]) -> Judged:
    """The same of a machine in tasks and on paths, without anything else."""
    found = power_and_margin(drive, prepared)
    powers = {key: power for key, (power, _) in found.items()}
    values = (sum(share * powers[key] for key, share in shares.items()),) if shares else tuple(powers.values())
    return Judged(all(margin >= 1.0 for _, margin in found.values()), values)


def tasks_and_paths(study: Study) -> dict[str, MachineTask | MachinePath]:
    """Of a study, by "tasks.NAME" and "paths.NAME"."""
    return {f"tasks.{key}": one for key, one in study.tasks.items()} | {
        f"paths.{key}": one for key, one in study.paths.items()
    }


def _listed(rest: list[MachineResult], key: str | None = None) -> str:
    return ", ".join(f"{power_words(one if key is None else one.found[key])} of {one.title}" for one in rest)


def lacking_of(machine: Any) -> Mapping[str, str]:
    """What of the motion of a machine does not count, with the reason; all of it where it has only steady points."""
    known = getattr(machine, "lacking", None)
    return {"moving masses": f"{type(machine).__name__} has steady points only"} if known is None else known


def _name(key: str) -> str:
    return key.partition(".")[2]


def power_words(found: TaskResult | PathResult | MachineResult) -> str:
    """A mean power, with that of steady points beside it where they differ."""
    power, steady = plain(found.mean_power, 3), plain(found.steady_power, 3)
    return f"{power} W" if power == steady else f"{power} W (steady {steady} W)"


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
    for index, (name, drive) in enumerate(study.drives.items()):
        if progress is not None:
            progress(study.titles[name], index / len(study.drives))
        results[name] = evaluate_machine(study, name, drive)
    return MachineComparison(study=study, results=FrozenDict(results))


def evaluate_machine(study: Study, name: str, drive: Any = None) -> MachineResult:
    """One machine of a study in all its tasks and on all its paths; what decides is `mean_power`, or that of each of `found`.

    Parameters
    ----------
    study : Study
    name : str         Of one of its drives.
    drive : Machine    A variant to evaluate in its place; by default that of the study.
    """
    drive = study.drives[name] if drive is None else drive
    machine = as_machine(drive)
    return MachineResult(
        name=name,
        title=study.titles[name],
        machine=machine,
        found=FrozenDict(evaluated(machine, tasks_and_paths(study))),
        shares=FrozenDict(study.machine_shares),
        motor_mass=motor_mass(drive),
    )
