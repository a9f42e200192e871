"""Commands that work on a whole study: check, compare, size, contact."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from infinivar.analysis.options import CompareOptions, StepOptions
from infinivar.cli.arguments import Json, OptionalOut, Out, StudyFile, drives_of_study, with_figures, with_options
from infinivar.cli.shared import end, loaded_study, naming
from infinivar.console import complain, flush, progress_bar, say
from infinivar.errors import InputError
from infinivar.sizing.options import SizeOptions

if TYPE_CHECKING:
    from infinivar.analysis.compare import Comparison
    from infinivar.analysis.machines import MachineComparison

QUICK = (
    "Quick run: the verdicts equal those of a full run. Skipped: report and data files, sampled builds, "
    "cylinder speed policies, and the check of duty cycles by simulation."
)

QUICK_MACHINES = "Quick run: report and data files are skipped; the verdicts equal those of a full run."


def check(study: StudyFile) -> None:
    """Check a study file without computing anything.

    Check its values, the files it refers to, and that its drives have the values its motions need.
    """
    from infinivar.study.check import check as run

    loaded = loaded_study(study)
    with naming(study):
        run(loaded)
        if loaded.sessions:
            from infinivar.analysis.sessions.of_study import check_sessions

            check_sessions(loaded)
    counts = {
        "drive": len(loaded.drives),
        "duty cycle": len(loaded.duty),
        "scenario": len(loaded.scenarios),
        "session": len(loaded.sessions),
        "stated spread": sum(len(spreads) for spreads in loaded.uncertainty.spreads.values()),
    }
    contents = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items() if count)
    say(f"{study}: {contents}; no faults found")


@with_figures("infinivar.report.comparison")
@with_options
def compare(
    study: StudyFile,
    options: CompareOptions,
    drive: Annotated[
        list[str] | None,
        typer.Option(
            "--drive", help="Compare only this drive; repeat for more drives.", autocompletion=drives_of_study
        ),
    ] = None,
    out: OptionalOut = None,
    as_json: Json = False,
) -> None:
    """Compare the drives of a study and write a report.

    Evaluate each drive in the duty cycles and on the requirement, or each machine in the tasks and on the paths; print the
    verdicts, then write report, results and maps. Exit with code 1 unless at least one drive is feasible in every duty cycle,
    task and path, and covers the requirement, if one is stated.
    """
    from infinivar.analysis.compare import begun
    from infinivar.analysis.hanging import printed_lines
    from infinivar.analysis.machines import MachineComparison
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.check import check_demands, check_duty

    quick = options.quick
    if quick and out is not None:
        raise InputError("--quick writes no files: remove --out or --quick")
    out = out or Path("out")
    loaded = loaded_study(study)
    with naming(study):
        loaded = loaded.with_drives(drive) if drive else loaded
        check_demands(loaded, "compare")
        check_duty(loaded)
    with contextlib.nullcontext() if quick else claimed(out):
        with progress_bar() as progress, naming(study):
            comparison, complete = begun(loaded, options, progress)
        first = _answer(comparison)
        if first and not as_json:
            # What completes it takes longer than the verdict.
            say(first)
            flush()
        with progress_bar() as progress, naming(study):
            comparison = complete(progress)
            if not quick and isinstance(comparison, MachineComparison) and not comparison.all_feasible:
                from infinivar.sizing.machine_changes import with_changes

                comparison = with_changes(comparison, progress)
        if not as_json:
            for line in (*_verdicts(comparison), *printed_lines(comparison.hangs_on)):
                say(line)
            flush()
        files = []
        if not quick:
            with progress_bar() as progress:
                progress("writing the report", 1.0)
                files = save(comparison, out)
    left_out = [] if files else [QUICK_MACHINES if loaded.tasks or loaded.paths else QUICK]
    end(comparison.to_dict, left_out, files, as_json=as_json, feasible=comparison.feasible)


def _answer(comparison: Comparison | MachineComparison) -> str:
    """The first line: the verdict, unless there is only one drive to say something of."""
    from infinivar.analysis.machines import MachineComparison

    hanging = comparison.hangs_on
    several = isinstance(comparison, MachineComparison) or comparison.duty or len(comparison.results) > 1
    return comparison.verdict if several or (hanging is not None and not hanging.decided) else ""


def _verdicts(comparison: Comparison | MachineComparison) -> Iterator[str]:
    """Yield the lines below the verdict: of drives against duty cycles and requirement, or of machines in tasks and on paths."""
    from infinivar.analysis.machines import MachineComparison

    return _of_machines(comparison) if isinstance(comparison, MachineComparison) else _of_drives(comparison)


def _of_machines(comparison: MachineComparison) -> Iterator[str]:
    """Yield each machine in each task and path, with its power and tightest limit."""
    from infinivar.analysis.machines import change_lines, power_words

    width = max(len(one.title) for one in comparison.results.values())
    first = next(iter(comparison.results.values()))
    for key, requested in first.found.items():
        yield f"{requested.title}:"
        for one in comparison.results.values():
            found = one.found[key]
            able = "feasible" if found.feasible else "infeasible"
            said = "".join(f"; {words}" for words in (found.servo_words, found.battery_words) if words)
            yield f"  {one.title:<{width}}  {able}, {power_words(found)}; {found.tightest_words}{said}"
    yield from change_lines(comparison)


def _of_drives(comparison: Comparison) -> Iterator[str]:
    """Yield the lines to print: with duty cycles mixed use and each cycle, then the requirement, if stated.

    A line on a drive is followed by one on its samples, if any.
    """
    width = max(len(result.title) for result in comparison.results.values())
    indent = "  " if comparison.duty else ""
    if comparison.mixed is not None:
        yield f"Mixed use, {comparison.mixed.words}:"
        for name, title in comparison.mixed.titles.items():
            yield f"  {title:<{width}}  {comparison.mixed.verdict_on(name)}"
    for task, found in comparison.duty.items():
        yield f"{found.duty.title}:"
        for name, done in found.results.items():
            yield f"  {done.title:<{width}}  {done.verdict}"
            if name in comparison.builds:
                yield f"  {'':<{width}}  {comparison.builds[name].duty[task].verdict}"
    yield from _on_envelope(comparison, width)
    if comparison.study.requirement is None:
        return
    if comparison.duty:
        yield "Requirement:"
    for name, result in comparison.results.items():
        yield f"{indent}{result.title:<{width}}  {result.verdict}"
        if name in comparison.builds:
            yield f"{indent}{'':<{width}}  {comparison.builds[name].verdict}"
    if not _answer(comparison) and comparison.not_counted:
        yield comparison.not_counted


def _on_envelope(comparison: Comparison, width: int) -> Iterator[str]:
    """Yield the size and mass of each drive, and what exceeds the envelope, if the study states one."""
    envelope = comparison.study.envelope
    if envelope is not None:
        yield "Envelope:"
        for name, mass in comparison.masses.items():
            yield f"  {comparison.results[name].title:<{width}}  {mass.words_on(envelope)}"


@with_figures("infinivar.report.sizing")
@with_options
def size(
    study: StudyFile,
    options: SizeOptions,
    drive: Annotated[
        list[str] | None,
        typer.Option(
            "--drive",
            help="Drive of the study that is a template: its other parts stay; repeat for more. "
            "[default: the first geared and the first cobotic drive, or the first machines with a leg and with separate drives]",
            autocompletion=drives_of_study,
        ),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Find the best drives or machines for a study, part by part.

    Judge motors, gearheads and pulley radii, or motors, gearhead, bearing and values of the wheel, by the requirement and the
    duty cycles of the study; of machines by its tasks and paths. Write a report, and each design as a study file that the other
    commands read. Exit with code 1 if no design is feasible; the result then names what excluded how many, and nearest misses.
    """
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.report.sizing import keep_inputs, text
    from infinivar.sizing.size import size as run

    loaded = loaded_study(study)
    keep_inputs(loaded, out, options.sets)
    with claimed(out):
        with progress_bar() as progress, naming(study):
            found = run(loaded, drive=drive, **options.arguments(), progress=progress)
        for one in found.sets:
            for fault in one.refused:
                complain(fault)
        if not as_json:
            for line in text(found):
                say(line)
            flush()
        with progress_bar() as progress:
            progress("writing the report", 1.0)
            files = save(found, out)
    end(found.to_dict, (), files, as_json=as_json, feasible=found.feasible)


@with_figures("infinivar.report.contact")
@with_options
def contact(
    study: StudyFile,
    options: StepOptions,
    drive: Annotated[
        str | None, typer.Option("--drive", help="Write the sheet of this drive only.", autocompletion=drives_of_study)
    ] = None,
    transient: Annotated[
        bool,
        typer.Option(
            "--transient", help="Show a step of the steering angle and the relaxation length instead of the sheet."
        ),
    ] = False,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Print the calculation sheet of each wheel contact.

    Also write the sheets and their figures to files.
    Exit with code 1 if a contact exceeds a stress limit. With --transient, show how the lateral force follows a step of the
    steering angle while the wheel rolls on.
    """
    if transient:
        _transient(study, drive, options, out, as_json)
    for name, value in options.arguments().items():
        if value is not None:
            raise InputError(f"--{name} is of the step that --transient shows: add --transient")
    from infinivar.analysis.contact_sheet import contact_sheets
    from infinivar.report import contact as report
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    with naming(study):
        sheets = contact_sheets(loaded, drive)
    files = save(sheets, out)
    end(
        lambda: {"sheets": [sheet.to_dict() for sheet in sheets]},
        (line for sheet in sheets for line in report.text(sheet).split("\n")),
        files,
        as_json=as_json,
        feasible=not any(sheet.exceeded for sheet in sheets),
    )


def _transient(study: Path, drive: str | None, options: StepOptions, out: Path, as_json: bool) -> NoReturn:
    """Print and write a step of the steering angle of each wheel."""
    from infinivar.analysis.steering_step import steering_steps
    from infinivar.report import contact as report
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    with progress_bar() as progress, naming(study):
        steps = steering_steps(loaded, drive, **options.arguments(), progress=progress)
    files = save(steps, out)
    lines = (line for step in steps for line in report.step_text(step).split("\n"))
    end(lambda: {"steps": [step.to_dict() for step in steps]}, lines, files, as_json=as_json)
