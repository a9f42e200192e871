"""Commands on large studies in chunks: sweep size, cobotic, builds, sensitivity, sessions and show."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from infinivar._core.text import capitalise
from infinivar.analysis.options import SensitivityOptions
from infinivar.calibration.options import RigOptions
from infinivar.cli.arguments import (
    Json,
    OptionalOut,
    StudyFile,
    drives_of_study,
    named_path,
    scenarios_of_study,
    with_figures,
    with_options,
)
from infinivar.cli.shared import chosen, chosen_cobotic, end, loaded_study, naming, of_one_axis, print_json
from infinivar.console import NOT_FEASIBLE, complain, progress_bar, say
from infinivar.errors import InputError
from infinivar.sizing.options import GENERATIONS, SizeOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from infinivar.study.study import Study
    from infinivar.sweeps.problem import Problem
    from infinivar.sweeps.sweep import Sweep

app = typer.Typer(help="Run large searches and studies in chunks.", no_args_is_help=True)

Folder = Annotated[
    Path, typer.Option("--folder", parser=named_path, metavar="PATH", help="Folder of the sweep; created if missing.")
]
Workers = Annotated[
    int | None, typer.Option("--workers", help="Processes on this machine. [default: compute in this process]", min=1)
]
Dask = Annotated[
    str | None,
    typer.Option("--dask", metavar="ADDRESS", help="Scheduler of a Dask cluster, such as tcp://10.0.0.1:8786."),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Continue what the folder holds; the other options must be the same.")
]

Kept = Annotated[int, typer.Option("--top", help="Number of designs to keep, besides those of the front.", min=1)]

_SHOWN = 10


@app.command()
@with_figures("infinivar.report.sizing")
@with_options
def size(
    study: StudyFile,
    folder: Folder,
    options: Annotated[SizeOptions, "objective", "sets", "radius"],
    top: Kept = 50,
    drive: Annotated[
        str | None,
        typer.Option("--drive", help="Template. [default: the first geared drive]", autocompletion=drives_of_study),
    ] = None,
    radii: Annotated[
        int | None,
        typer.Option(
            "--radii", help="Try this many radii of the range, in equal ratios, instead of the best one.", min=2
        ),
    ] = None,
    pairs: Annotated[
        int | None,
        typer.Option(
            "--pairs", help="Pairs of motor and gearhead in a chunk. [default: 20000; 200000 with --radii]", min=1
        ),
    ] = None,
    workers: Workers = None,
    dask: Dask = None,
    resume: Resume = False,
    out: OptionalOut = None,
    as_json: Json = False,
) -> None:
    """Search as the command size does, in chunks.

    Each chunk is kept in the folder when it is done. However the command ends, --resume continues with the chunks that are
    left, and the result is the same. With --out, write the report and the study files of the command size. Exit with code 1
    if no pair is feasible.
    """
    from infinivar.report.saving import save
    from infinivar.sweeps.geared import geared_sweep

    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "sweep")
    _keep_apart(loaded, folder, out, options.sets)
    with naming(study):
        stated = options.arguments("objective", "sets", "radius")
        problem = geared_sweep(loaded, **stated, top=top, drive=drive, radii=radii, size=pairs)
    for one in problem.parts.sets:
        for fault in one.refused:
            complain(fault)
    found = _run(problem, folder, workers, dask, resume)
    made = problem.result(found)
    files = [] if out is None else save(made, out)
    end(
        lambda: {**made.to_dict(), "sweep": found.to_dict(0)},
        (capitalise(made.verdict), found.verdict),
        files,
        as_json=as_json,
        feasible=made.feasible,
    )


@app.command()
@with_figures("infinivar.report.sizing")
@with_options
def cobotic(
    study: StudyFile,
    folder: Folder,
    options: Annotated[SizeOptions, "objective", "sets", *SizeOptions.COBOTIC],
    starts: Annotated[int, typer.Option("--starts", help="Number of searches, each from a start of its own.", min=1)],
    top: Kept = 50,
    drive: Annotated[
        str | None,
        typer.Option("--drive", help="Template. [default: the first cobotic drive]", autocompletion=drives_of_study),
    ] = None,
    generations: Annotated[int, typer.Option("--generations", help="Length of each search.", min=1)] = GENERATIONS,
    workers: Workers = None,
    dask: Dask = None,
    resume: Resume = False,
    out: OptionalOut = None,
    as_json: Json = False,
) -> None:
    """Search over cobotic drives from many starts, one in each chunk.

    With --out, write the report and the study files of the command size. Exit with code 1 if no design is feasible.
    """
    from infinivar.report.saving import save
    from infinivar.sweeps.cobotic import cobotic_study_sweep
    from infinivar.sweeps.problem import LIST, TOP

    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "sweep")
    _keep_apart(loaded, folder, out, options.sets)
    with naming(study):
        stated = options.arguments("objective", "sets", *SizeOptions.COBOTIC)
        problem = cobotic_study_sweep(loaded, starts=starts, **stated, top=top, drive=drive, generations=generations)
    found = _run(problem, folder, workers, dask, resume)
    files = [] if out is None else save(problem.sizing(found), out)
    verdict = problem.verdict(found)
    end(
        lambda: {"verdict": verdict, **found.to_dict()},
        (capitalise(verdict), *found.lines()),
        files,
        as_json=as_json,
        feasible=len(found.list(TOP).get(LIST, ())) > 0,
    )


@app.command()
def builds(
    study: StudyFile,
    folder: Folder,
    drive: Annotated[
        str | None,
        typer.Option("--drive", help="[default: the first drive with spreads]", autocompletion=drives_of_study),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            "--scenario",
            help="Simulate each sample in this scenario, instead of the requirement and the duty cycles.",
            autocompletion=scenarios_of_study,
        ),
    ] = None,
    draws: Annotated[
        int | None,
        typer.Option("--draws", help="Number of samples, a power of two. [default: 65536, in a scenario 1024]"),
    ] = None,
    size: Annotated[
        int | None,
        typer.Option("--size", help="Samples in a chunk, a power of two. [default: 4096, in a scenario 32]"),
    ] = None,
    workers: Workers = None,
    dask: Dask = None,
    resume: Resume = False,
    as_json: Json = False,
) -> None:
    """Sample a drive within its tolerances, as compare does, in chunks."""
    from infinivar.sweeps.builds import builds_sweep
    from infinivar.sweeps.runs import runs_sweep

    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "sweep")
    numbers = {name: number for name, number in (("draws", draws), ("size", size)) if number is not None}
    with naming(study):
        problem = (
            builds_sweep(loaded, drive, **numbers)
            if scenario is None
            else runs_sweep(loaded, drive, scenario, **numbers)
        )
    found = _run(problem, folder, workers, dask, resume)
    made = problem.result(found)
    if as_json:
        print_json({**made.to_dict(), "sweep": found.to_dict(0)})
        return
    say(made.verdict)
    for task, judged in getattr(made, "duty", {}).items():
        say(f"{task}: {judged.verdict}")
    say(found.verdict)


@app.command()
@with_options
def sensitivity(
    study: StudyFile,
    folder: Folder,
    options: Annotated[SensitivityOptions, "duty"],
    of: Annotated[str, typer.Option("--of", help="Result, as for the command sensitivity.")],
    drive: Annotated[
        str | None, typer.Option("--drive", help="[default: the first drive]", autocompletion=drives_of_study)
    ] = None,
    samples: Annotated[int, typer.Option("--samples", help="Number of base samples, a power of two.")] = 2**16,
    size: Annotated[int, typer.Option("--size", help="Base samples in a chunk, a power of two.")] = 2**11,
    workers: Workers = None,
    dask: Dask = None,
    resume: Resume = False,
    as_json: Json = False,
) -> None:
    """Compute Sobol's indices of a drive's parameters, in chunks.

    The operating point of an efficiency or a loss is the requirement's corner of maximum force.
    """
    from infinivar.sweeps.sensitivity import sensitivity_sweep

    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "sweep")
    name = chosen(study, "drive", drive, loaded.drives)
    with naming(study):
        problem = sensitivity_sweep(loaded, name, of, duty=options.duty, samples=samples, size=size)
    found = _run(problem, folder, workers, dask, resume)
    made = problem.result(found)
    if as_json:
        print_json({**made.to_dict(), "sweep": found.to_dict(0)})
        return
    for sentence in made.ranking:
        say(sentence)
    say(found.verdict)


@app.command()
@with_options
def sessions(
    study: StudyFile,
    folder: Folder,
    options: RigOptions,
    drive: Annotated[
        str | None,
        typer.Option("--drive", help="[default: the first cobotic drive]", autocompletion=drives_of_study),
    ] = None,
    number: Annotated[int, typer.Option("--sessions", help="Number of sessions.", min=1)] = 1000,
    size: Annotated[int, typer.Option("--size", help="Sessions in a chunk.", min=1)] = 20,
    workers: Workers = None,
    dask: Dask = None,
    resume: Resume = False,
    as_json: Json = False,
) -> None:
    """Calibrate a drive with many sessions on the study's rig, which is simulated: how well would it be known?"""
    from infinivar.sweeps.sessions import sessions_sweep

    loaded = loaded_study(study)
    of_one_axis(study, loaded.drives, "sweep")
    name = chosen_cobotic(study, drive, loaded.drives)
    with naming(study):
        problem = sessions_sweep(loaded, name, sessions=number, size=size, **options.arguments())
    found = _run(problem, folder, workers, dask, resume)
    made = problem.result(found)
    if as_json:
        print_json({**made.to_dict(), "sweep": found.to_dict(0)})
        return
    say(made.verdict)
    for parameter, one in made.parameters.items():
        say(f"  {parameter}: {one.verdict}")
    say(found.verdict)


@app.command()
def show(
    folder: Annotated[
        Path, typer.Argument(parser=named_path, metavar="FOLDER", help="Folder of a sweep.", show_default=False)
    ],
    top: Annotated[int, typer.Option("--top", help="Number of designs of each list to print.", min=1)] = _SHOWN,
    as_json: Json = False,
) -> None:
    """Print what a sweep has found so far, without computing anything.

    Exit with code 1 if it is not finished.
    """
    from infinivar.sweeps.sweep import load_sweep

    found = load_sweep(folder)
    if as_json:
        print_json(found.to_dict(top))
    else:
        for line in found.lines(top):
            say(line)
    raise typer.Exit(0 if found.finished else NOT_FEASIBLE)


def _keep_apart(study: Study, folder: Path, out: Path | None, sets: Sequence[str | Path] | None) -> None:
    """Refuse a folder of results that is that of the sweep, or whose new files would replace one that the search reads."""
    from infinivar.report.sizing import keep_inputs

    if out is None:
        return
    if out.resolve() == folder.resolve():
        raise InputError(f"--out {out}: this is the folder of the sweep; state another one for the report")
    keep_inputs(study, out, sets)


def _run(problem: Problem, folder: Path, workers: int | None, dask: str | None, resume: bool) -> Sweep:
    """Run a sweep with a progress bar; say how to continue if it is interrupted."""
    from infinivar.sweeps.sweep import sweep

    try:
        with progress_bar() as progress:
            return sweep(problem, folder, workers=workers, dask=dask, resume=resume, progress=progress)
    except KeyboardInterrupt:
        complain(f"{folder}: stopped; the chunks that are done are kept: continue with --resume")
        raise
