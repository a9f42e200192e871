"""The command line: reads arguments, calls one function, prints what comes back."""

from __future__ import annotations

import contextlib
import json
import re
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from infinivar import __version__
from infinivar.console import NOT_FEASIBLE, complain, progress_bar, say, write
from infinivar.console import run as run_command
from infinivar.errors import InputError, ParameterError, printable
from infinivar.options import Json, Out, StudyFile, named_path, numbers, quantity

if TYPE_CHECKING:
    from infinivar.study.study import Study

app = typer.Typer(
    help="Models, sizes and compares drive-trains with an infinitely variable (cobotic) transmission and a fixed ratio.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def main() -> None:
    """Entry point; see `infinivar.console.run` for the exit codes."""
    run_command(app)


def _print_json(value: Any) -> None:
    from infinivar.report.page import to_json

    write(to_json(value))


@app.command()
def check(study: StudyFile) -> None:
    """Check a study without computing anything: values, files, and what its motions need of its drives."""
    from infinivar.study.check import check as run

    loaded = _loaded(study)
    with _of(study):
        run(loaded)
    counts = {
        "drive": len(loaded.drives),
        "duty cycle": len(loaded.duty),
        "scenario": len(loaded.scenarios),
        "stated spread": sum(len(spreads) for spreads in loaded.uncertainty.spreads.values()),
    }
    said = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items() if count)
    say(f"{study}: {said}; nothing wrong")


@app.command()
def compare(study: StudyFile, out: Out = Path("out"), as_json: Json = False) -> None:
    """Hold every drive of a study against its requirement and duty cycles; write report, results and maps.

    Exit code 1 if no drive covers the requirement and does every duty cycle.
    """
    from infinivar.analysis.compare import compare as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.check import check_duty

    loaded = _loaded(study)
    with _of(study):
        check_duty(loaded)
    with claimed(out), progress_bar() as progress:
        with _of(study):
            comparison = run(loaded, progress=progress)
        progress("writing the report", 1.0)
        files = save(comparison, out)
    if as_json:
        _print_json({**comparison.to_dict(), "files": [str(file) for file in files]})
    else:
        width = max(len(result.title) for result in comparison.results.values())
        for name, result in comparison.results.items():
            say(f"{result.title:<{width}}  {result.verdict}")
            if name in comparison.builds:
                say(f"{'':<{width}}  {comparison.builds[name].verdict}")
        for task, found in comparison.duty.items():
            say(f"{found.duty.title}:")
            for name, done in found.results.items():
                say(f"  {done.title:<{width}}  {done.verdict}")
                if name in comparison.builds:
                    say(f"  {'':<{width}}  {comparison.builds[name].duty[task].verdict}")
        say(f"Report: {files[0]}")
    raise typer.Exit(0 if comparison.feasible else NOT_FEASIBLE)


@app.command()
def contact(
    study: StudyFile,
    drive: Annotated[str | None, typer.Option("--drive", help="Only this drive.")] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Print the calculation sheet of the wheel contact of each cobotic drive; write it with its figure.

    Exit code 1 if a contact is over-stressed.
    """
    from infinivar.analysis.contact_sheet import contact_sheets
    from infinivar.report import contact as report
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    with _of(study):
        sheets = contact_sheets(loaded, drive)
    files = save(sheets, out)
    if as_json:
        _print_json({"sheets": [sheet.to_dict() for sheet in sheets], "files": [str(file) for file in files]})
    else:
        for sheet in sheets:
            for line in report.text(sheet).split("\n"):
                say(line)
        say(f"Written to {out}: {', '.join(file.name for file in files)}")
    raise typer.Exit(NOT_FEASIBLE if any(sheet.exceeded for sheet in sheets) else 0)


@app.command()
def reproduce(
    figure: Annotated[int | None, typer.Option("--figure", help="Only this figure and its claims.")] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Draw the paper's figures and check its claims."""
    from infinivar.paper.report import check_figure, left_out
    from infinivar.paper.reproduce import reproduce as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save

    check_figure(figure)
    with claimed(out), progress_bar() as progress:
        result = run(figure, progress=progress)
        progress("drawing", 1.0)
        files = save(result, out, figure=figure)
    if as_json:
        _print_json(result.to_list())
    else:
        for claim in result.claims:
            say(f"{claim.id:<4} {claim.verdict:<14} {claim.claim}")
        if figure is None and (missing := left_out()):
            say(missing)
        say(f"Report: {files[0]}")


@app.command()
def simulate(
    study: StudyFile,
    drive: Annotated[str | None, typer.Option("--drive", help="Name of the drive in the study.")] = None,
    scenario: Annotated[str | None, typer.Option("--scenario", help="Name of the scenario in the study.")] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Run a drive through a scenario in time; write report, figures and results, with the energy audit.

    Exit code 1 if the drive could not do it: the run is incomplete, a limit was exceeded, or a motor overheats.
    """
    from infinivar.analysis.simulate import simulate as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    driven = _chosen(study, "drive", drive, loaded.drives)
    asked = _chosen(study, "scenario", scenario, loaded.scenarios)
    with claimed(out), progress_bar() as progress:
        with _named(study, f"drives.{driven}, scenarios.{asked}"):
            result = run(
                loaded.drives[driven],
                loaded.scenarios[asked],
                title=loaded.titles[driven],
                progress=lambda share: progress(loaded.scenarios[asked].title, share),
            )
        progress("writing the report", 1.0)
        files = save(result, out, name=f"{driven}-{asked}", reconstruction=loaded.reconstruction)
    if as_json:
        _print_json({**result.to_dict(), "files": [str(file) for file in files]})
    else:
        say(f"{result.title}, {result.scenario.title}: {result.verdict}")
        for event in result.events:
            say(f"  {event}")
        say(f"Report: {files[0]}")
    raise typer.Exit(0 if result.feasible else NOT_FEASIBLE)


@app.command()
def rig(
    study: StudyFile,
    drive: Annotated[
        str | None, typer.Option("--drive", help="Name of a cobotic drive; the only one if left out.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", parser=named_path, metavar="PATH", help="CSV file to write.")] = Path(
        "rig.csv"
    ),
    ratios: Annotated[str, typer.Option(help="Reduction ratios.")] = "100,50,20,8,4,2,1",
    loads: Annotated[str, typer.Option(help="Loads over the slip force.")] = "0.15,0.5",
    preloads: Annotated[str, typer.Option(help="Preloads over the study's.")] = "1",
    seed: Annotated[int, typer.Option(min=0, help="Of the sensors' noise and of how far the rig is off.")] = 0,
) -> None:
    """Simulate the experiment that measures a transmission; write the data that the rig of the study would record."""
    from infinivar.calibration import virtual_rig
    from infinivar.calibration.result import cobotic
    from infinivar.report.calibration import save_data
    from infinivar.report.output import check_file
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = _measurable(study, drive, loaded.drives)
    wanted = {
        "ratios": numbers("ratios", ratios),
        "loads": numbers("loads", loads),
        "preloads": numbers("preloads", preloads),
    }
    with _named(study, f"drives.{name}"):
        measured = cobotic(loaded, name)
    check_file(out)
    with progress_bar() as progress, _named(study, f"drives.{name}"):
        settings = virtual_rig.protocol(measured, loaded.rig, **wanted)
        done = virtual_rig.experiment(
            measured, loaded.rig, settings, seed=seed, progress=lambda share: progress("measuring", share)
        )
    if not len(done.data):
        raise InputError(f"{study}: drives.{name}: no run of the protocol is possible: {done.left_out[0]}")
    save_data(done.data, out)
    for said in done.left_out:
        complain(f"left out: {said}")
    say(f"{len(done.data)} runs written to {out}. Next: {_call('calibrate', out, '--study', study, '--drive', name)}")


@app.command()
def calibrate(
    data: Annotated[Path, typer.Argument(help="Runs of a rig (CSV with units in its header).", show_default=False)],
    study: Annotated[
        Path, typer.Option("--study", help="Study file that has the drive and the rig.", show_default=False)
    ],
    drive: Annotated[
        str | None, typer.Option("--drive", help="Name of the cobotic drive; the only one if left out.")
    ] = None,
    fit: Annotated[
        str, typer.Option("--fit", help="What to fit; torque_constant and resistance, too, on request.")
    ] = "creep_stiffness,rolling_torque,bearing_torque,guideway_friction,nominal_torque",
    leave_out: Annotated[
        list[int] | None, typer.Option("--leave-out", help="Line of the data that is not used.")
    ] = None,
    creep_laws: Annotated[
        str | None,
        typer.Option("--creep-laws", help="Creep laws to hold against the data, all if left out: linear,polach"),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Fit a drive's losses to a rig's data; write report, results and the calibrated study.

    Exit code 1 if the data do not tell all that was to be fitted.
    """
    from infinivar.calibration.calibrate import calibrate as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = _measurable(study, drive, loaded.drives)
    names = [word.strip() for word in fit.split(",") if word.strip()]
    candidates = None if creep_laws is None else [word.strip() for word in creep_laws.split(",") if word.strip()]
    with claimed(out):
        found = run(loaded, name, data, parameters=names, leave_out=leave_out or (), creep_laws=candidates)
        files = save(found, out)
    for one in found.left_out:
        complain(f"left out: line {one.line}: {one.reason}")
    if as_json:
        _print_json({**found.to_dict(), "files": [str(file) for file in files]})
    else:
        for warning in found.warnings:
            say(warning)
        for clause in found.verdict.split("; "):
            say(clause)
        for remark in found.remarks[len(found.warnings) :]:
            say(f"  {remark}")
        say(f"Report: {files[0]}")
        say(f"Calibrated study: {files[1]}")
    raise typer.Exit(0 if found.fit.told == found.fit.names else NOT_FEASIBLE)


@app.command()
def sensitivity(
    study: StudyFile,
    of: Annotated[
        str,
        typer.Option(
            "--of",
            help="efficiency or loss at a point; margin or coverage in the region; energy or temperature of a duty cycle.",
        ),
    ],
    drive: Annotated[str | None, typer.Option("--drive", help="Name of the drive in the study.")] = None,
    force: Annotated[str | None, typer.Option("--force", help='Of the operating point, such as "20 N".')] = None,
    speed: Annotated[str | None, typer.Option("--speed", help='Of the operating point, such as "0.3 m/s".')] = None,
    duty: Annotated[str | None, typer.Option("--duty", help="Name of the duty cycle in the study.")] = None,
    method: Annotated[str, typer.Option(help="Of the derivatives: complex, jax or difference.")] = "complex",
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Rank the parameters of a drive by what they do to a result; write report and figures.

    Exit code 1 if the drive cannot do what is asked about within its limits.
    """
    from infinivar.analysis.robustness.derivatives import METHODS
    from infinivar.analysis.robustness.sensitivity import sensitivity as run
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = _chosen(study, "drive", drive, loaded.drives)
    derived: Any = next((known for known in METHODS if known == method), None)
    if derived is None:
        raise InputError(f"--method {method!r} must be one of {', '.join(METHODS)}")
    push, pace = quantity("--force", force, "N"), quantity("--speed", speed, "m/s")
    with claimed(out), progress_bar() as progress:
        with _of(study):
            found = run(loaded, name, of, speed=pace, force=push, duty=duty, method=derived, progress=progress)
        progress("writing the report", 1.0)
        files = save(found, out)
    if as_json:
        _print_json({**found.to_dict(), "files": [str(file) for file in files]})
        raise typer.Exit(NOT_FEASIBLE if found.beyond else 0)
    from infinivar import units

    beyond = ", beyond limits" if found.beyond else ""
    say(f"{found.outcome.words}: {units.show(found.value, found.outcome.unit)}{beyond}")
    for sentence in found.ranking:
        say(f"  {sentence}")
    if found.conclusions:
        say("What the paper recommends, per 1 %:")
        for row in found.conclusions:
            say(f"  {row.words:<48} {units.signed(row.elasticity):>9} %  {row.verdict}")
    for remark in found.remarks:
        say(remark)
    say(f"Report: {files[0]}")
    raise typer.Exit(NOT_FEASIBLE if found.beyond else 0)


def _call(*words: object) -> str:
    return shlex.join(["infinivar", *map(str, words)])


@app.command()
def graph(
    study: StudyFile,
    drive: Annotated[str, typer.Argument(help="Name of the drive in the study.", show_default=False)],
    out: Annotated[
        Path,
        typer.Option("--out", parser=named_path, metavar="PATH", help="Picture to write: .svg, .pdf or .png."),
    ] = Path("graph.svg"),
    plant: Annotated[
        str,
        typer.Option(
            "--plant", help="system, or of a cobotic drive: lossless, transmission, steering, cylinder, link."
        ),
    ] = "system",
    electrical: Annotated[str, typer.Option("--electrical", help="current or voltage drive.")] = "current",
    equations: Annotated[
        Path | None, typer.Option("--equations", help="Write the equations, too: .tex for LaTeX, .txt for text.")
    ] = None,
) -> None:
    """Draw the bond graph of a drive, and write its equations."""
    from infinivar.drivetrain.graphs.plants import plant_graph
    from infinivar.report import graph as report
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = _chosen(study, "drive", drive, loaded.drives)
    with _named(study, f"drives.{name}"):
        made = plant_graph(loaded.drives[name], plant, electrical=electrical, load_mass=loaded.requirement.load_mass)
        report.save(made, out, equations)
    say(f"Written: {', '.join(str(file) for file in (out, equations) if file is not None)}")


def _chosen(study: Path, what: str, name: str | None, known: Mapping[str, Any]) -> str:
    """The name asked for, or the only one there is."""
    from infinivar.errors import nearest

    if name is None and len(known) == 1:
        return next(iter(known))
    if name is not None and name in known:
        return name
    if not known:
        example = f'add a table [{what}s.reach] with base = "faulring2006.reach"'
        raise InputError(f"{printable(study)}: has no {what}s; {example}")
    said = f"--{what} is missing" if name is None else f"--{what} {name!r} is not in the study{nearest(name, known)}"
    raise InputError(f"{printable(study)}: {said}; it has {', '.join(known)}")


def _measurable(study: Path, name: str | None, drives: Mapping[str, Any]) -> str:
    """The drive asked for, or the only one there is that has a wheel."""
    from infinivar.drivetrain.cobotic import CoboticDrive

    wheeled = {known: drive for known, drive in drives.items() if isinstance(drive, CoboticDrive)}
    return _chosen(study, "drive", name, wheeled if name is None and wheeled else drives)


def _loaded(path: Path) -> Study:
    """The study, with its warnings on stderr."""
    from infinivar.study.load import load_study

    loaded = load_study(path)
    for warning in loaded.warnings:
        complain(f"{printable(path)}: check {warning}")
    return loaded


@contextlib.contextmanager
def _of(study: Path) -> Iterator[None]:
    """Bad input found in a study is named with its file."""
    try:
        yield
    except InputError as problem:
        raise InputError("\n".join(f"{printable(study)}: {line}" for line in str(problem).split("\n"))) from None


@contextlib.contextmanager
def _named(study: Path, where: str) -> Iterator[None]:
    """A value that does not do for what is asked is bad input, named with its place."""
    try:
        yield
    except ParameterError as problem:
        raise InputError(f"{printable(study)}: {where}: {problem}") from problem


@app.command()
def schema() -> None:
    """Print the JSON Schema of study files, for editors."""
    from infinivar.study.schema import json_schema

    write(json.dumps(json_schema(), indent=2) + "\n")


@app.command()
def init(
    name: Annotated[str, typer.Argument(help="Name of the study; NAME.toml is written.", show_default=False)],
) -> None:
    """Write a commented study file to start from."""
    from infinivar.study.template import TEMPLATE

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not re.fullmatch(r"\w[\w .-]*", path.stem) or name.endswith("/"):
        raise InputError(f"{name!r} must end in letters, digits, spaces, points, - and _ only")
    text = TEMPLATE.format(name=path.stem, title=path.stem.replace("_", " ").replace("-", " ").capitalize())
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as problem:
        raise InputError(f"{printable(path)}: is there already; choose another name or remove it") from problem
    except OSError as problem:
        raise InputError(f"{printable(path)}: cannot be written: {problem.strerror}") from problem
    say(f"{path} written. Next: infinivar compare {shlex.quote(str(path))} --out out")


@app.command()
def catalogue(as_json: Json = False) -> None:
    """List the motors, gearheads, bearings and materials that a study can take by `part`."""
    from infinivar.study.catalogue import bearings, gearheads, materials, motors

    if as_json:
        import dataclasses

        parts = {"motors": motors(), "gearheads": gearheads(), "bearings": bearings(), "materials": materials()}
        _print_json(
            {kind: {key: dataclasses.asdict(part) for key, part in group.items()} for kind, group in parts.items()}
        )
        return
    from infinivar.report.catalogue import text

    for line in text().rstrip("\n").split("\n"):
        say(line)


def _print_version(wanted: bool) -> None:
    if wanted:
        say(f"infinivar {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


if __name__ == "__main__":
    main()
