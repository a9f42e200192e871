"""Command that searches for the best drives: size."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from infinivar.cli.arguments import Json, Out, StudyFile, drives_of_study, with_options
from infinivar.cli.shared import loaded_study, naming, of_one_axis, print_json
from infinivar.console import NOT_FEASIBLE, complain, flush, progress_bar, say
from infinivar.sizing.options import SizeOptions


@with_options
def size(
    study: StudyFile,
    options: SizeOptions,
    drive: Annotated[
        list[str] | None,
        typer.Option(
            "--drive",
            help="Drive of the study that is a template: its other parts stay; repeat for more. "
            "[default: the first geared and the first cobotic drive]",
            autocompletion=drives_of_study,
        ),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Find the best geared and cobotic drives for a study.

    Judge motors, gearheads and pulley radii, or motors, gearhead, bearing and values of the wheel, by the requirement and the
    duty cycles of the study. Write a report, and each design as a study file that the other commands read. Exit with code 1 if
    no design is feasible; the result then names what excluded how many, and the nearest misses.
    """
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.report.sizing import keep_inputs, text
    from infinivar.sizing.size import size as run

    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "size")
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
    if as_json:
        print_json({**found.to_dict(), "files": [str(file) for file in files]})
    else:
        say(f"Report: {files[0]}")
    raise typer.Exit(0 if found.feasible else NOT_FEASIBLE)
