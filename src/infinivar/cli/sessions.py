"""The command on sessions of a user at the handle of a machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from infinivar.cli.shared import loaded_study, naming, print_json
from infinivar.console import NOT_FEASIBLE, complain, progress_bar, say
from infinivar.errors import printable
from infinivar.options import Json, Out, StudyFile, drives_of_study, sessions_of_study


def session(
    study: StudyFile,
    task: Annotated[
        str | None,
        typer.Option(
            "--task",
            help="Name of a task with a type in the study; defaults to the first.",
            autocompletion=sessions_of_study,
        ),
    ] = None,
    drive: Annotated[
        str | None,
        typer.Option(
            "--drive",
            help="Drive whose handle the user holds; defaults to that of the task, or the first.",
            autocompletion=drives_of_study,
        ),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Simulate a user at the handle of a machine.

    A controller guides the machine by a task of the study: a path, wall, fixture, free motion, coasting or holding.
    Print what the user got for it and what it cost; write a report, figures and results, including the energy audit.
    Exit with code 1 if the session is infeasible: incomplete, a limit exceeded, or a motor overheated.
    """
    from infinivar.analysis.sessions.measures import measures
    from infinivar.analysis.sessions.of_study import check_session, named_session, study_session
    from infinivar.report.output import check_inputs, claimed
    from infinivar.report.saving import save
    from infinivar.study.inputs import input_files

    loaded = loaded_study(study)
    with naming(study):
        name, chosen = named_session(loaded, task, drive)
        check_session(loaded, name, chosen)
    if task is None and len(loaded.sessions) > 1:
        complain(f"no --task given: using {printable(name)}, the first of {', '.join(map(printable, loaded.sessions))}")
    title = loaded.sessions[name].title
    stem = f"{chosen}-{name}"
    kind = f"session {stem}"
    check_inputs(out, kind, input_files(loaded), lambda file: file.startswith((f"{stem}.", f"{stem}-")))
    with claimed(out), progress_bar() as progress:
        with naming(study):
            found = study_session(loaded, name, chosen, progress=lambda share: progress(title, share))
        progress("writing the report", 1.0)
        files = save(found, out, name=stem, reconstruction=loaded.reconstruction)
    if as_json:
        from infinivar.report.session import to_dict

        print_json({**to_dict(found), "files": [str(file) for file in files]})
    else:
        say(f"{found.title}: {found.verdict}")
        for measure in measures(found):
            say(f"  {measure}")
        for line in found.event_lines:
            say(f"  {line}")
        say(f"Report: {files[0]}")
    raise typer.Exit(0 if found.feasible else NOT_FEASIBLE)
