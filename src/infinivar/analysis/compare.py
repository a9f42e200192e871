"""Compare drive-trains: their motions, their coverage of the requirement, efficiency, and tightest limit of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar._core.described import at, derived, named, reported
from infinivar._core.engine import Engine
from infinivar._core.frozen import FrozenDict
from infinivar._core.processes import ahead
from infinivar._core.result import Result, result
from infinivar._core.text import joined
from infinivar.analysis import sampled_springs
from infinivar.analysis.cycles.cylinder_policy import policies
from infinivar.analysis.cycles.duty_comparison import FEW, DutyComparison, over_all
from infinivar.analysis.cycles.duty_cycle import duty_cycle
from infinivar.analysis.cycles.duty_result import DutyResult
from infinivar.analysis.cycles.mixed_use import MixedUse, mixed_use
from infinivar.analysis.deciding import hanging_drives, hanging_machines
from infinivar.analysis.hanging import Hanging, Judged, winner
from infinivar.analysis.loss_ranking import LeastLoss, least_loss
from infinivar.analysis.machines import MachineComparison, compare_machines
from infinivar.analysis.options import CompareOptions
from infinivar.analysis.plane import Plane, of_drives, place
from infinivar.analysis.region import Corner, Margin, against, best_efficiency, peak
from infinivar.analysis.robustness.verdicts import Builds, builds
from infinivar.analysis.steady_map import SteadyMap, steady_map
from infinivar.analysis.whole_mass import WholeMass, whole_mass
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive, MovingDrive
from infinivar.drivetrain.uncounted import not_counted
from infinivar.errors import InputError
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.study.check import check_demands, check_duty, check_spreads, check_study
from infinivar.study.default_spreads import with_default_spreads
from infinivar.study.requirement import Requirement
from infinivar.study.study import Study
from infinivar.units import margin_words, plain

if TYPE_CHECKING:
    from infinivar.analysis.cycles.tracking import TwoWays


@result
class DriveResult(Result):
    """Performance of one drive in steady operation, and against the requirement if the study states one.

    Attributes
    ----------
    coverage                  Share of the required region, by area, within every limit; nan without a requirement. [-]
    peak_efficiency           Best within limits anywhere (up to 10 times the requirement or the motions). [-]
    peak_efficiency_in_region Best within limits in the required region; nan without one. [-]
    mean_loss                 Mean loss over the covered part of the region; nan without one. [W]
    tightest                  The limit with the least margin in the region, and where; None without one.
    corners                   Operating point at each named corner of the region.
    map                       Steady map beyond the region, or beyond the motions.
    audit_residual            Largest relative residual of the power balance over all computed points. [-]
    """

    name: str
    title: str = reported(attribute="title")
    drive: Drive
    coverage: float = reported("1")
    peak_efficiency: float = reported("1")
    peak_efficiency_in_region: float = reported("1")
    mean_loss: float = reported("W", key="mean_loss_in_region")
    tightest: Margin | None = reported(key="tightest_margin")
    corners: Mapping[str, Corner]
    map: SteadyMap
    audit_residual: float = reported("1")

    _also = (at("map.engine"), at("map", dims=(), variable="*"))

    @property
    def covers(self) -> bool:
        """Whether every required point is within every limit; true if no region is required."""
        return self.tightest is None or self.tightest.value >= 1.0

    @derived(attribute="verdict")
    def verdict(self) -> str:
        """One-sentence verdict: coverage and tightest limit."""
        tight = self.tightest
        if tight is None:
            return f"no region is required; peak efficiency {plain(100 * self.peak_efficiency, 3)} %"
        share = "100" if self.covers else plain(min(100 * self.coverage, 99.9), 3)
        where = place(self.map.axis, tight.force, tight.speed)
        covered = f"covers {share} % of the required region"
        if math.isinf(tight.value):
            return f"{covered}; no limit is loaded"
        if self.covers:
            return f"{covered}; tightest limit: {tight.limit.words} (margin {margin_words(tight.value)} at {where})"
        if tight.value < 0.005:
            return f"{covered}; infeasible at {where}: {tight.limit.words}"
        demand = f"{100 * tight.value:.0f}" if tight.value < 0.995 else "just under 100"
        return f"{covered}; tightest limit: {tight.limit.words}, {demand} % of the demand at {where}"


@result
class Comparison(Result):
    """Results of all drives of a study, for its duty cycles and its requirement.

    Duty cycles lead where the study has any: `verdict`, `best` and reports begin with them. A requirement counts as well, if
    stated: a drive is able if it is feasible in every duty cycle, covers the whole required region, and fits the
    envelope, if one is stated.
    """

    study: Study = reported(convert=named)
    results: Mapping[str, DriveResult] = reported(key="drives")
    duty: Mapping[str, DutyComparison] = reported(optional=True, default_factory=dict)
    masses: Mapping[str, WholeMass] = reported(optional=True, default_factory=dict)
    """What each drive weighs, by name; without machines."""
    builds: Mapping[str, Builds] = reported(optional=True, default_factory=dict)
    """Sampled builds of the drives that have spreads."""
    hangs_on: Hanging | None = reported(optional=True, default=None)
    """Choices that no source settles, each with the winner it gives."""
    least_loss: LeastLoss | None = reported(optional=True, default=None)
    """Drive with the least loss over the force-speed plane; None with a single drive."""
    options: CompareOptions = field(default=CompareOptions(), compare=False, repr=False)
    """With which it was computed."""

    _also = (at("study.warnings"),)

    def able(self, name: str) -> bool:
        """Whether a drive covers the whole requirement, if one is stated, every duty cycle is feasible, and the drive fits."""
        return self.results[name].covers and self._follows(name) and self.fits(name)

    def fits(self, name: str) -> bool:
        """Whether what is known of a drive is within the envelope, if the study states one."""
        mass = self.masses.get(name)
        return mass is None or mass.within(self.study.envelope)

    def _follows(self, name: str) -> bool:
        """Whether every duty cycle is feasible."""
        return all(found.results[name].feasible for found in self.duty.values())

    @derived()
    def feasible(self) -> bool:
        """Whether at least one drive meets the requirement and all duty cycles."""
        return any(self.able(name) for name in self.results)

    @derived(key="mixed_use", optional=True)
    def mixed(self) -> MixedUse | None:
        """All duty cycles weighed by the shares of time that the study states; None if it states none."""
        shares = self.study.shares
        return mixed_use({task: found.results for task, found in self.duty.items()}, shares) if shares else None

    @derived(convert=named)
    def best(self) -> DriveResult | None:
        """The best of the able drives; None if no drive is able.

        With duty cycles, the drive with the lowest mean power in mixed use, if the study states shares; else the one with the
        lowest energy in every duty cycle, or None if no drive has that. Without, the drive with the lowest mean loss over the
        required region.
        """
        best = winner(self._judged)
        return None if best is None else self.results[best]

    @property
    def _judged(self) -> dict[str, Judged]:
        """What decides between the drives: energy of each cycle or of mixed use, else mean loss over the region."""
        mixed, found = self.mixed, {}
        for name, one in self.results.items():
            if mixed is not None:
                values: tuple[float, ...] = (mixed.power[name],)
            elif self.duty:
                values = tuple(cycle.results[name].energy for cycle in self.duty.values())
            else:
                values = (one.mean_loss,)
            found[name] = Judged(self.able(name), values)
        return found

    @derived()
    def verdict(self) -> str:
        """The answer in one or two sentences, about the duty cycles first; undecidable if an open choice changes the winner."""
        prefix = "" if self.hangs_on is None else self.hangs_on.prefix
        return prefix + " ".join((*verdicts(self), *filter(None, [self.not_counted])))

    @property
    def not_counted(self) -> str:
        """Sentence on the bearings whose friction drives do not state; "" if all do."""
        drives = {name: one.drive for name, one in self.results.items()}
        return not_counted(drives, {name: one.title for name, one in self.results.items()})


def verdicts(comparison: Comparison) -> Iterator[str]:
    """Yield the answer sentence by sentence: on mixed use or all duty cycles, each of a few, then on the requirement."""
    count = len(comparison.results)
    if comparison.mixed is not None:
        yield f"{comparison.mixed.verdict}."
    else:
        if len(comparison.duty) > 1:
            yield f"{over_all(comparison.duty, {name: result.title for name, result in comparison.results.items()})}."
        if len(comparison.duty) <= FEW:
            for found in comparison.duty.values():
                yield f"{found.duty.title}: {found.verdict}."
    if comparison.study.envelope is not None:
        yield _envelope_words(comparison)
    if comparison.study.requirement is None:
        return
    covering = [result for result in comparison.results.values() if result.covers]
    able = f"None of the {count} drives covers" if count > 1 else "The drive does not cover"
    if covering and count > 1:
        able = f"{len(covering)} of {count} drives {'covers' if len(covering) == 1 else 'cover'}"
    elif covering:
        able = "The drive covers"
    if not covering or comparison.duty:
        yield f"{able} the requirement{_in_motion_too(comparison) if covering else ''}."
        return
    best = min(covering, key=lambda result: result.mean_loss)
    lowest = f"lowest mean loss over the required region: {best.title} with {plain(best.mean_loss, 3)} W"
    yield f"{able} the requirement; {lowest}."


def _envelope_words(comparison: Comparison) -> str:
    """Which drives fit, and the best of those that do all that is required."""
    envelope = comparison.study.envelope
    fitting = [one.title for name, one in comparison.results.items() if comparison.fits(name)]
    unknown = [
        one.title
        for name, one in comparison.results.items()
        if envelope is not None
        and name in comparison.masses
        and comparison.fits(name)
        and not comparison.masses[name].known_within(envelope)
    ]
    known = f", as far as the bodies of {joined(unknown)} are known" if unknown else ""
    if len(fitting) == len(comparison.results):
        return f"{'All drives are' if len(fitting) > 1 else 'The drive is'} within the envelope{known}."
    if not fitting:
        return "No drive is known to be within the envelope."
    best = comparison.best
    also = "" if best is None else f"; best of those that meet all requirements: {best.title}"
    return f"Within the envelope{known}: {joined(fitting)}{also}."


def _in_motion_too(comparison: Comparison) -> str:
    """Which drive is best in all that is required, where one that leads in motion may not cover the requirement; else ""."""
    moving = [name for name in comparison.results if comparison._follows(name)]
    able = [name for name in moving if comparison.able(name)]
    if able == moving or len(comparison.results) == 1:
        return ""
    if not able:
        return "; none of these is feasible in motion"
    if len(able) == 1:
        return f"; only {comparison.results[able[0]].title} is feasible in motion and covers it"
    best = "none leads" if comparison.best is None else f"{comparison.best.title} has the lowest energy"
    return f"; of the {len(able)} drives that are feasible in motion and cover it, {best}"


def evaluate(
    name: str,
    title: str,
    drive: Drive,
    requirement: Requirement | None,
    plane: Plane,
    *,
    engine: Engine = "auto",
    **options: Any,
) -> DriveResult:
    """Evaluate one drive on a plane, and on a requirement if there is one; `options` are passed to `steady_map`."""
    signs = (1.0,) if plane.one_quadrant else (-1.0, 1.0)
    highest, worst = best_efficiency(drive, plane.speed, plane.force, signs, name)
    steady = steady_map(drive, *plane.axes(), engine=engine, **options)
    residuals, efficiencies = [worst, steady.audit_residual], [np.array(highest), steady.efficiency]
    judged: dict[str, Any] = {
        "coverage": np.nan,
        "peak_efficiency_in_region": np.nan,
        "mean_loss": np.nan,
        "tightest": None,
        "corners": FrozenDict(),
    }
    if requirement is not None:
        judged, efficiency, residual = against(name, drive, requirement)
        efficiencies.append(efficiency)
        residuals.append(residual)
    return DriveResult(
        name=name,
        title=title,
        drive=drive,
        peak_efficiency=peak(np.concatenate([found.ravel() for found in efficiencies])),
        map=steady,
        audit_residual=max(residuals),
        **judged,
    )


def compare(
    study: Study,
    *,
    quick: bool = False,
    engine: Engine = "auto",
    default_spreads: bool = False,
    progress: Callable[[str, float], None] | None = None,
) -> Comparison | MachineComparison:
    """Evaluate every drive of a study on its duty cycles and its requirement, or every machine in its tasks and on its paths.

    Parameters
    ----------
    study : Study   From `load_study`.
    quick : bool    Skip sampled builds, cylinder speed policies and the simulation of duty cycles, which the verdicts on the
        nominal drives do not need. All other numbers are the same.
    engine : str    numpy; jax, compiled, with the same numbers to rounding; or auto: jax for large maps and numbers of samples
        where it is installed and can compile the drive. Duty cycles of the drives themselves are computed by NumPy.
    default_spreads : bool   Sample builds of drives of one axis also within default spreads, where the study states none.
    progress        Called with the title of the current drive and the share of work done, 0 to 1.

    Returns
    -------
    Comparison, or MachineComparison for a study with tasks or paths

    Raises
    ------
    InputError
        If a drive lacks a value that a duty cycle requires, or JAX is requested and is not installed or cannot compile a drive.
    AuditError
        If a power balance does not close.
    """
    _, complete = begun(study, CompareOptions(quick=quick, engine=engine, default_spreads=default_spreads), progress)
    return complete(progress)


Found = Comparison | MachineComparison
Report = Callable[[str, float], None] | None


def begun(study: Study, options: CompareOptions, progress: Report = None) -> tuple[Found, Callable[[Report], Found]]:
    """As `compare`, in two: what has the verdict already, and a function that completes it."""
    check_study(study)
    check_spreads(study)
    check_demands(study, "compare")
    if study.tasks or study.paths:
        machines = compare_machines(study, progress)
        machines = replace(machines, hangs_on=hanging_machines(machines), options=options)
        return machines, lambda progress: machines
    check_duty(study)
    if options.default_spreads:
        study = with_default_spreads(study)
    turning = {
        (task, name): ahead(policies, drive, duty)
        for task, duty in study.duty.items()
        for name, drive in study.drives.items()
        if isinstance(drive, CoboticDrive) and not options.quick
    }
    made = compare_drives(study, options, progress)
    covers = {name: one.covers for name, one in made.results.items()}
    fits = {name: made.fits(name) for name in made.results}
    free = replace(made, study=replace(study, envelope=None))._judged
    made = replace(made, hangs_on=hanging_drives(study, free, covers, fits, made.duty))

    def complete(progress: Report) -> Comparison:
        duty = {
            task: replace(
                found, policies=FrozenDict({name: one() for (of, name), one in turning.items() if of == task})
            )
            for task, found in made.duty.items()
        }
        return replace(made, duty=FrozenDict(duty), builds=_sampled(made, progress))

    return made, complete


def compare_drives(
    study: Study,
    options: CompareOptions = CompareOptions(),  # noqa: B008 (it is frozen)
    progress: Callable[[str, float], None] | None = None,
) -> Comparison:
    """As `compare`, for a checked study of drives of one axis, up to the verdict and without what that hangs on."""
    plane = of_drives(study)
    results: dict[str, DriveResult] = {}
    count = len(study.drives) * (1 + len(study.duty))
    for index, (name, drive) in enumerate(study.drives.items()):
        title = study.titles[name]

        def report(share: float, title: str = title, index: int = index) -> None:
            if progress is not None:
                progress(title, (index + share) / count)

        report(0.0)
        results[name] = evaluate(name, title, drive, study.requirement, plane, engine=options.engine, progress=report)
    duty: dict[str, DutyComparison] = {}
    for task, cycle in study.duty.items():
        done = len(study.drives) * (1 + len(duty))

        def step(title: str, index: int, done: int = done) -> None:
            if progress is not None:
                progress(title, (done + index) / count)

        duty[task] = work_through(study, task, cycle, step, quick=options.quick)
    return Comparison(
        study=study,
        results=FrozenDict(results),
        duty=FrozenDict(duty),
        masses=FrozenDict({name: mass for name in study.drives if (mass := whole_mass(study, name)) is not None}),
        least_loss=least_loss(study, maps={name: found.map for name, found in results.items()})
        if len(results) > 1
        else None,
        options=options,
    )


def _sampled(made: Comparison, progress: Report) -> Mapping[str, Builds]:
    """Sampled builds of the drives that have spreads."""
    study, drawn = made.study, {}
    uncertain = [name for name in study.drives if study.uncertainty.spreads.get(name) and not made.options.quick]
    for start, name in enumerate(uncertain):

        def grow(share: float, title: str = f"{study.titles[name]}: builds", start: int = start) -> None:
            if progress is not None:
                progress(title, (start + share) / len(uncertain))

        drive, steady = study.drives[name], made.results[name].map
        assert isinstance(drive, (CoboticDrive, ConventionalDrive))
        drawn[name] = builds(
            drive,
            name,
            study.uncertainty,
            study.requirement,
            study.duty,
            (steady.speed, steady.force),
            grow,
            made.options.engine,
        )
    return FrozenDict(drawn)


def work_through(
    study: Study,
    task: str,
    duty: DutyCycle,
    progress: Callable[[str, int], None] = lambda title, index: None,
    *,
    quick: bool = False,
) -> DutyComparison:
    """Evaluate every drive of a study in a duty cycle, without policies of its cylinder; `quick` as in `compare`.

    Raises
    ------
    InputError
        If a drive lacks a value that the motion requires.
    """
    results: dict[str, DutyResult] = {}
    ways: dict[str, TwoWays | str] = {}
    for index, (name, drive) in enumerate(study.drives.items()):
        progress(f"{study.titles[name]}: {duty.title}", index)
        assert isinstance(drive, MovingDrive)  # `check_duty` refuses others
        results[name] = duty_cycle(drive, duty, name=name, title=study.titles[name], travel=study.travel)
        ways[name] = "omitted from a quick comparison" if quick else _both_ways(drive, duty, results[name])
    cautions = {name: sampled_springs.caution(drive, duty) for name, drive in study.drives.items()}
    return DutyComparison(
        duty=duty,
        results=FrozenDict(results),
        policies=FrozenDict(),
        two_ways=FrozenDict(ways),
        cautions=FrozenDict({name: caution for name, caution in cautions.items() if caution}),
    )


def _both_ways(drive: Any, duty: DutyCycle, result: DutyResult) -> TwoWays | str:
    """Simulate the cycle as well, or say why not."""
    from infinivar.analysis.cycles.tracking import LONGEST, two_ways

    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        return f"a {type(drive).__name__} has no bond graph to simulate"
    if not duty.closed:
        return "a run is not simulated, as it may start in motion"
    if duty.period > LONGEST:
        return (
            f"the cycle of {plain(duty.period, 3)} s is longer than {LONGEST:g} s, the longest that a report simulates"
        )
    if result.exceeded:
        return "the cycle exceeds the limits of the drive"
    try:
        return two_ways(drive, duty)
    except InputError as problem:  # what this drive cannot simulate says nothing about the others
        return str(problem)
