"""The command on sessions of a user at the handle of a machine."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Annotated

import typer

from infinivar.cli.arguments import Json, Out, StudyFile, drives_of_study, named_path, sessions_of_study, with_figures
from infinivar.cli.shared import end, loaded_study, naming
from infinivar.console import complain, progress_bar
from infinivar.errors import InputError, printable


@with_figures("infinivar.report.run")
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
    video: Annotated[
        Path | None,
        typer.Option(
            "--video",
            parser=named_path,
            metavar="FILE",
            help="Also write a video of the machine in motion: a .gif file, or an .mp4 file where ffmpeg is found.",
        ),
    ] = None,
    video_speed: Annotated[
        float,
        typer.Option("--video-speed", help="Speed of the video over that of the machine; 0.1 is ten times slower."),
    ] = 1.0,
    scene: Annotated[
        Path | None,
        typer.Option(
            "--scene",
            parser=named_path,
            metavar="FILE",
            help="Also write the machine as a scene for MuJoCo, an .xml file, with its motion beside it, in an .npz file.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Simulate a user at the handle of a machine.

    A controller guides the machine by a task of the study: a path, wall, fixture, free motion, coasting or holding.
    Print what the user got for it and what it cost; write a report, figures and results, including the energy audit.
    Exit with code 1 if the session is infeasible: incomplete, a limit exceeded, or a motor overheated.
    """
    from infinivar._core.c_library import no_compiler
    from infinivar.analysis.sessions.measures import measures
    from infinivar.analysis.sessions.of_study import checked_session, named_session
    from infinivar.figures.moving_machine import check_frames
    from infinivar.report.output import check_file, check_inputs, claimed
    from infinivar.report.saving import save
    from infinivar.report.scene.export import check_scene
    from infinivar.report.video import check_video
    from infinivar.study.inputs import input_files

    if video is not None:
        check_video(video)
    if scene is not None:
        check_scene(scene)
    loaded = loaded_study(study)
    with naming(study):
        name, chosen = named_session(loaded, task, drive)
        ready = checked_session(loaded, name, chosen)
    if task is None and len(loaded.sessions) > 1:
        complain(f"no --task given: using {printable(name)}, the first of {', '.join(map(printable, loaded.sessions))}")
    if video is not None:
        try:
            check_frames(loaded.sessions[name].duration, video_speed, 25.0)
        except InputError as problem:
            raise InputError(f"--video-speed: {problem}") from None
    title = loaded.sessions[name].title
    stem = f"{chosen}-{name}"
    kind = f"session {stem}"
    check_inputs(out, kind, input_files(loaded), lambda file: file.startswith((f"{stem}.", f"{stem}-")))
    beside = [*([video] if video else []), *([scene, scene.with_suffix(".npz")] if scene else [])]
    for file in beside:
        check_inputs(file.parent, "file", input_files(loaded), lambda name, file=file: name == file.name)
        check_file(file)
    with claimed(out), progress_bar() as progress:
        with naming(study):
            found = ready.over(lambda share: progress(title, share))
        if video is not None:
            found.save_video(video, speed=video_speed, progress=lambda share: progress("drawing the video", share))
        if scene is not None:
            found.to_mujoco(scene)
        progress("writing the report", 1.0)
        files = [*save(found, out, name=stem, reconstruction=loaded.reconstruction), *beside]
    from infinivar.report.run import session_to_dict  # loaded by now

    slow = no_compiler()
    lines = (*measures(found), *found.event_lines, *([slow] if slow else []))
    end(
        functools.partial(session_to_dict, found),
        (f"{found.title}: {found.verdict}", *(f"  {line}" for line in lines)),
        files,
        as_json=as_json,
        feasible=found.feasible,
        beside=[f"Also written: {file}" for file in beside],
    )
