"""Command that searches for the best drives: size."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from infinivar.cli.shared import loaded_study, naming, print_json
from infinivar.console import NOT_FEASIBLE, complain, flush, progress_bar, say
from infinivar.errors import InputError
from infinivar.options import Json, Out, StudyFile, drives_of_study, quantity


def size(
    study: StudyFile,
    objective: Annotated[
        str | None,
        typer.Option(
            "--objective",
            help="energy, mass, or both separated by a comma: designs are ordered by the first, and two give their front as "
            "well. [default: energy,mass; mass for a study without motions]",
        ),
    ] = None,
    top: Annotated[
        int, typer.Option("--top", help="Number of designs to list, besides those of the front.", min=1)
    ] = 20,
    sets: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="Search only this set, by name or as a file; repeat for more sets. [default: all sets]"
        ),
    ] = None,
    drive: Annotated[
        str | None,
        typer.Option(
            "--drive",
            help="Drive of the study that is the template for all but motor and gearhead. [default: the first geared drive]",
            autocompletion=drives_of_study,
        ),
    ] = None,
    radius: Annotated[
        tuple[str, str] | None,
        typer.Option(
            "--radius",
            metavar="LOW HIGH",
            help='Least and largest radius of the pulley, such as "3 mm" "50 mm". '
            "[default: a fifth to five times the template's]",
        ),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Find the best motor, gearhead and pulley for a study.

    Judge every pair in some sets of parts by the requirement and the duty cycles of the study. Write a report, and each design
    as a study file that the other commands read. Exit with code 1 if no pair is feasible; the result then names what excluded
    how many, and the nearest miss.
    """
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.report.sizing import text
    from infinivar.sizing.size import size as run

    ends = None if radius is None else _range(*radius)
    aims: Any = None if objective is None else tuple(part.strip() for part in objective.split(","))
    if aims is not None and (len({*aims}) < len(aims) or not {*aims} <= {"energy", "mass"}):
        raise InputError(f"--objective {objective!r} must be energy, mass, or both, such as energy,mass")
    loaded = loaded_study(study)
    with claimed(out):
        with progress_bar() as progress, naming(study):
            found = run(loaded, objective=aims, top=top, sets=sets, drive=drive, radius=ends, progress=progress)
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


def _range(least: str, largest: str) -> tuple[float, float]:
    """Radii of the option. [m]"""
    low, high = quantity("--radius", least, "m"), quantity("--radius", largest, "m")
    if low is None or high is None or not 0.0 < low <= high:
        raise InputError(f"--radius {least!r} {largest!r} must be a range above 0, the least first")
    return low, high
