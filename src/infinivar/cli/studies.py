"""Commands on a whole study: check, compare, contact."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from infinivar.cli.shared import loaded_study, naming, print_json
from infinivar.console import NOT_FEASIBLE, flush, progress_bar, say
from infinivar.options import Json, Out, StudyFile, drives_of_study

if TYPE_CHECKING:
    from infinivar.analysis.compare import Comparison

QUICK = (
    "Quick run: verdicts only, the same as those of a full run. Left out: report and data files, sampled builds, "
    "cylinder speed policies, and the check of duty cycles by simulation."
)


def check(study: StudyFile) -> None:
    """Check a study file without computing anything.

    Values, the files that it names, and what its motions need of its drives.
    """
    from infinivar.study.check import check as run

    loaded = loaded_study(study)
    with naming(study):
        run(loaded)
    counts = {
        "drive": len(loaded.drives),
        "duty cycle": len(loaded.duty),
        "scenario": len(loaded.scenarios),
        "stated spread": sum(len(spreads) for spreads in loaded.uncertainty.spreads.values()),
    }
    said = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items() if count)
    say(f"{study}: {said}; nothing wrong")


def compare(
    study: StudyFile,
    drive: Annotated[
        list[str] | None,
        typer.Option("--drive", help="Only this drive; may be given several times.", autocompletion=drives_of_study),
    ] = None,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="Print verdicts only: no report or files, no sampled builds, no cylinder speeds, no check by simulation.",
        ),
    ] = False,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Compare the drives of a study and write a report.

    Holds each drive against the requirement and the duty cycles, prints the verdicts, then writes report, results and maps.
    Exit code 1 if no drive covers the requirement and does every duty cycle.
    """
    from infinivar.analysis.compare import compare as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.check import check_duty

    loaded = loaded_study(study)
    with naming(study):
        loaded = loaded.with_drives(drive) if drive else loaded
        check_duty(loaded)
    with contextlib.nullcontext() if quick else claimed(out):
        with progress_bar() as progress, naming(study):
            comparison = run(loaded, quick=quick, progress=progress)
        if not as_json:
            # Drawing takes longer than computing: the verdicts need not wait for it.
            for line in _verdicts(comparison):
                say(line)
            flush()
        files = []
        if not quick:
            with progress_bar() as progress:
                progress("writing the report", 1.0)
                files = save(comparison, out)
    if as_json:
        print_json({**comparison.to_dict(), "files": [str(file) for file in files]})
    else:
        say(f"Report: {files[0]}" if files else QUICK)
    raise typer.Exit(0 if comparison.feasible else NOT_FEASIBLE)


def _verdicts(comparison: Comparison) -> Iterator[str]:
    """A line a drive, and one a drive in each duty cycle; below it that of its sampled builds, if any."""
    width = max(len(result.title) for result in comparison.results.values())
    for name, result in comparison.results.items():
        yield f"{result.title:<{width}}  {result.verdict}"
        if name in comparison.builds:
            yield f"{'':<{width}}  {comparison.builds[name].verdict}"
    for task, found in comparison.duty.items():
        yield f"{found.duty.title}:"
        for name, done in found.results.items():
            yield f"  {done.title:<{width}}  {done.verdict}"
            if name in comparison.builds:
                yield f"  {'':<{width}}  {comparison.builds[name].duty[task].verdict}"


def contact(
    study: StudyFile,
    drive: Annotated[
        str | None, typer.Option("--drive", help="Only this drive.", autocompletion=drives_of_study)
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Print the calculation sheet of each wheel contact.

    Writes the sheets of the cobotic drives, too, with their figures.
    Exit code 1 if a contact is over-stressed.
    """
    from infinivar.analysis.contact_sheet import contact_sheets
    from infinivar.report import contact as report
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    with naming(study):
        sheets = contact_sheets(loaded, drive)
    files = save(sheets, out)
    if as_json:
        print_json({"sheets": [sheet.to_dict() for sheet in sheets], "files": [str(file) for file in files]})
    else:
        for sheet in sheets:
            for line in report.text(sheet).split("\n"):
                say(line)
        say(f"Written to {out}: {', '.join(file.name for file in files)}")
    raise typer.Exit(NOT_FEASIBLE if any(sheet.exceeded for sheet in sheets) else 0)
