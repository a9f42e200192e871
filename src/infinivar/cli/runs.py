"""Commands that work on one drive of a study: simulate, sensitivity, graph, export."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from infinivar.analysis.options import SensitivityOptions
from infinivar.cli.arguments import (
    Json,
    Out,
    StudyFile,
    drives_of_study,
    named_path,
    scenarios_of_study,
    with_figures,
    with_options,
)
from infinivar.cli.shared import chosen, end, naming, naming_place, of_one_axis, print_json
from infinivar.console import NOT_FEASIBLE, complain, progress_bar, say
from infinivar.errors import InputError, nearest, printable
from infinivar.options import quantity

if TYPE_CHECKING:
    from infinivar.analysis.machine_run import MachineRun
    from infinivar.analysis.robustness.sensitivity import Sensitivity
    from infinivar.analysis.simulate import Simulation
    from infinivar.axis import Axis
    from infinivar.study.study import Study

DRIVE = "Name of the drive in the study; defaults to the first."
DriveName = Annotated[str | None, typer.Argument(help=DRIVE, show_default=False, autocompletion=drives_of_study)]
SCENARIO = "Name of the scenario in the study; defaults to the first."


@with_figures("infinivar.report.run")
def simulate(
    study: StudyFile,
    drive: Annotated[str | None, typer.Option("--drive", help=DRIVE, autocompletion=drives_of_study)] = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", help=SCENARIO, autocompletion=scenarios_of_study)
    ] = None,
    task: Annotated[
        str | None,
        typer.Option("--task", help="Machines: path or task of the study; defaults to the first path, or task."),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Simulate a drive in a scenario, or a machine in motion.

    A machine follows a path for two periods, of which the first settles; in a task it holds, or moves steadily.
    Write a report, figures and results, including the energy audit.
    Exit with code 1 if the run is infeasible: incomplete, a limit exceeded, or a motor overheated.
    """
    from infinivar._core.c_library import no_compiler
    from infinivar.analysis.simulate import simulate as run
    from infinivar.drivetrain.drive import is_machine
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.load import load_study

    loaded = load_study(study)
    of_machines = bool(loaded.tasks or loaded.paths)
    driven = chosen(study, "drive", drive, _movable(loaded, drive) if of_machines else loaded.drives)
    if is_machine(loaded.drives[driven]) or task is not None:
        _simulate_machine(study, loaded, driven, task, scenario, out, as_json)
    requested = chosen(study, "scenario", scenario, loaded.scenarios)
    with claimed(out), progress_bar() as progress:
        with naming_place(study, f"drives.{driven}, scenarios.{requested}"):
            result = run(
                loaded.drives[driven],
                loaded.scenarios[requested],
                title=loaded.titles[driven],
                progress=lambda share: progress(loaded.scenarios[requested].title, share),
            )
        progress("writing the report", 1.0)
        files = save(result, out, name=f"{driven}-{requested}", reconstruction=loaded.reconstruction)
    slow = no_compiler() if result.scenario.method == "auto" else None
    _end(result, f"{result.title}, {result.scenario.title}", files, as_json, *([slow] if slow else []))


@with_figures("infinivar.report.sensitivity")
@with_options
def sensitivity(
    context: typer.Context,
    study: StudyFile,
    options: SensitivityOptions,
    of: Annotated[
        str | None,
        typer.Option(
            "--of",
            help="Result: efficiency or loss at a point, margin or coverage of the requirement, "
            "or energy or temperature of a duty cycle; of machines power, loss or margin in a task. By default power of a "
            "machine, energy if there is a duty cycle, else margin.",
        ),
    ] = None,
    drive: Annotated[str | None, typer.Option("--drive", help=DRIVE, autocompletion=drives_of_study)] = None,
    force: Annotated[str | None, typer.Option("--force", help='Force at the operating point, such as "20 N".')] = None,
    speed: Annotated[
        str | None, typer.Option("--speed", help='Speed at the operating point, such as "0.3 m/s".')
    ] = None,
    moment: Annotated[
        str | None, typer.Option("--moment", help='Moment at the operating point of a joint, such as "12 N m".')
    ] = None,
    angular_speed: Annotated[
        str | None,
        typer.Option("--angular-speed", help='Angular speed at the operating point of a joint, such as "40 rpm".'),
    ] = None,
    task: Annotated[
        str | None,
        typer.Option(
            "--task", help="Machines: task or path of the study, for power, loss or margin; defaults to the first."
        ),
    ] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Rank a drive's parameters by their effect on a result.

    Write a report and figures; of machines, print the effects only.
    Exit with code 1 if the point, requirement, duty cycle or task is infeasible for the drive.
    """
    from infinivar.analysis.robustness.sensitivity import sensitivity as run
    from infinivar.drivetrain.drive import axis_of
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.check import check_demands
    from infinivar.study.load import load_study

    loaded = load_study(study)
    if force is moment is None:
        with naming(study):
            check_demands(loaded, "sensitivity")
    name = chosen(study, "drive", drive, loaded.drives)
    of = of or ("power" if loaded.tasks or loaded.paths else "energy" if loaded.duty else "margin")
    if loaded.tasks or loaded.paths:
        _of_one_axis_only(context, "force", "speed", "moment", "angular_speed", "duty", "method", "out")
        _of_machine(study, loaded, name, of, task, as_json)
    if task is not None:
        raise InputError(f"--task {task!r} is of machines; the study has no tasks or paths")
    if of == "power":
        raise InputError("--of power is of machines; the study has no tasks or paths: use energy, or loss at a point")
    push, pace = _operating_point(axis_of(loaded.drives[name]), force, speed, moment, angular_speed)
    with claimed(out), progress_bar() as progress:
        with naming(study):
            found = run(loaded, name, of, speed=pace, force=push, **options.arguments(), progress=progress)
        progress("writing the report", 1.0)
        files = save(found, out)
    end(found.to_dict, _ranked(found), files, as_json=as_json, feasible=not found.beyond)


def _ranked(found: Sensitivity) -> Iterator[str]:
    """Yield the result, its strongest parameters, and the paper's recommendations."""
    from infinivar import units

    beyond = ", limit exceeded" if found.beyond else ""
    yield f"{found.outcome.words}: {units.show(found.value, found.outcome.unit)}{beyond}"
    yield from (f"  {sentence}" for sentence in found.ranking)
    if found.conclusions:
        yield "The paper's recommendations, effect per +1 %:"
        for row in found.conclusions:
            yield f"  {row.words:<48} {units.signed(row.elasticity):>9} %  {row.verdict}"
    yield from found.remarks


def _movable(loaded: Study, drive: str | None) -> Mapping[str, Any]:
    """Drives to choose from: without a name, the machines that can be simulated, if there are any."""
    movable = {name: one for name, one in loaded.drives.items() if "simulate" in getattr(one, "commands", ())}
    return movable if drive is None and movable else loaded.drives


def _simulate_machine(
    study: Path, loaded: Study, name: str, task: str | None, scenario: str | None, out: Path, as_json: bool
) -> NoReturn:
    """Simulate a machine on a path or in a task, and exit."""
    from infinivar._core.c_library import no_compiler
    from infinivar.analysis.machine_sensitivity import task_of
    from infinivar.analysis.machine_study import check_moves, simulated
    from infinivar.report.output import claimed
    from infinivar.report.saving import save
    from infinivar.study.check import check_machines

    with naming(study):
        if scenario is not None:
            raise InputError(f"--scenario {scenario!r} is of drives of one axis; simulate drives.{name} with --task")
        if not (loaded.tasks or loaded.paths):
            if loaded.sessions:
                raise InputError("the study has sessions of a user only; run them with infinivar session")
            raise InputError("the study has no tasks or paths; of machines, simulate needs one, such as [paths.circle]")
        check_moves(loaded.drives[name], f"drives.{name}")
        check_machines(loaded)
        every = [f"paths.{one}" for one in loaded.paths] + [f"tasks.{one}" for one in loaded.tasks]
        place, requested = task_of(loaded, every[0] if task is None else task)
    if task is None and len(every) > 1:
        complain(f"no --task given: using {printable(place)}, the first of {', '.join(map(printable, every))}")
    title = f"{loaded.titles[name]}, {requested.title}"
    with claimed(out), progress_bar() as progress:
        with naming_place(study, f"drives.{name}, {place}"):
            result = simulated(
                loaded.drives[name], requested, title=title, progress=lambda share: progress(requested.title, share)
            )
        progress("writing the report", 1.0)
        file_name = f"{name}-{place.partition('.')[2]}"
        files = save(result, out, name=file_name, reconstruction=loaded.reconstruction)
    slow = no_compiler()
    _end(result, title, files, as_json, *([slow] if slow else []))


def _end(result: Simulation | MachineRun, title: str, files: list[Path], as_json: bool, *notes: str) -> NoReturn:
    """Print a simulated run, and exit."""
    lines = (f"{title}: {result.verdict}", *(f"  {line}" for line in (*result.event_lines, *notes)))
    end(result.to_dict, lines, files, as_json=as_json, feasible=result.feasible)


def _of_one_axis_only(context: typer.Context, *names: str) -> None:
    """Refuse options that do not apply to the effects of a machine's values."""
    for name in names:
        source = context.get_parameter_source(name)
        if source is not None and source.name != "DEFAULT":
            option = f"--{name.replace('_', '-')}"
            raise InputError(
                f"{option} is of drives of one axis; of a machine, sensitivity takes --of, --drive, --task and --json"
            )


def _of_machine(study: Path, loaded: Study, name: str, of: str, task: str | None, as_json: bool) -> NoReturn:
    """Print the effects of a machine's values on a result, and exit."""
    from infinivar.analysis.machine_sensitivity import machine_sensitivity

    with progress_bar() as progress, naming(study):
        found = machine_sensitivity(
            loaded, name, of, task=task, progress=lambda share: progress(loaded.titles[name], share)
        )
    if as_json:
        print_json(found.to_dict())
    else:
        for line in found.lines:
            say(line)
    raise typer.Exit(0 if found.feasible else NOT_FEASIBLE)


def _operating_point(
    axis: Axis, force: str | None, speed: str | None, moment: str | None, angular_speed: str | None
) -> tuple[float | None, float | None]:
    """Force and speed in SI, from the options of a drive along a line, or from those of a drive about a joint."""
    line, joint = {"--force": force, "--speed": speed}, {"--moment": moment, "--angular-speed": angular_speed}
    wrong, right = (line, joint) if axis.rotary else (joint, line)
    moves = "about a joint" if axis.rotary else "along a line"
    for (option, said), instead in zip(wrong.items(), right, strict=True):
        if said is not None:
            raise InputError(f"{option} {said!r} does not apply to a drive {moves}; use {instead}")
    push, pace = (
        None if said is None else quantity(option, said, unit)
        for (option, said), unit in zip(right.items(), (axis.force_unit, axis.speed_unit), strict=True)
    )
    return push, pace


def graph(
    study: StudyFile,
    drive: DriveName = None,
    out: Annotated[
        Path,
        typer.Option("--out", parser=named_path, metavar="PATH", help="Image file to write: .svg, .pdf or .png."),
    ] = Path("graph.svg"),
    plant: Annotated[
        str,
        typer.Option(
            "--plant",
            help="Model to draw: system, or for a cobotic drive lossless, transmission, steering, cylinder or link.",
        ),
    ] = "system",
    electrical: Annotated[
        str, typer.Option("--electrical", help="What the amplifier imposes: current or voltage.")
    ] = "current",
    equations: Annotated[
        Path | None, typer.Option("--equations", help="Also write the equations: .tex for LaTeX, .txt for plain text.")
    ] = None,
) -> None:
    """Draw the bond graph of a drive.

    With --equations, also write its state equations.
    """
    from infinivar.drivetrain.graphs.plants import plant_graph
    from infinivar.report import graph as report
    from infinivar.study.load import load_study

    loaded = load_study(study)
    name = chosen(study, "drive", drive, loaded.drives, "drive")
    of_one_axis(study, loaded.drives, "graph", name)
    with naming_place(study, f"drives.{name}"):
        made = plant_graph(loaded.drives[name], plant, electrical=electrical, load_mass=loaded.load_mass)
        report.save(made, out, equations)
    say(f"Wrote {', '.join(str(file) for file in (out, equations) if file is not None)}")


def export(
    study: StudyFile,
    kind: Annotated[
        str,
        typer.Option(
            "--as",
            metavar="FORMAT",
            help="fmu2 or fmu3: an FMU of FMI 2.0 or 3.0, for Model Exchange and Co-Simulation; c: C99 sources, of the plant and "
            "of what a controller needs; mujoco: an actuator as a plugin of MuJoCo, with models.",
            show_default=False,
        ),
    ],
    drive: DriveName = None,
    scenario: Annotated[
        str | None,
        typer.Option(
            "--scenario",
            help="Scenario that states load, amplifier and start of the plant, by default a force on the load, and currents; "
            "or the task of a session that states the start of a machine and its user.",
            autocompletion=scenarios_of_study,
        ),
    ] = None,
    loop: Annotated[
        str | None,
        typer.Option(
            "--loop",
            help="Scenario whose controllers are exported with the plant: they follow a goal, which is an input; or the task of "
            "a session, whose controller guides the user.",
            autocompletion=scenarios_of_study,
        ),
    ] = None,
    out: Out = Path("out"),
) -> None:
    """Write a drive or machine as FMU, C or for MuJoCo.

    The plant alone, or with --loop also its controllers; for MuJoCo an actuator.
    An FMU needs no Python; it holds a binary for this platform if a C compiler is found, and sources.
    Inputs are the force on the load and the motors' currents, or with --loop the goal of their controllers or what the user does.
    """
    from infinivar.drivetrain.drive import is_machine
    from infinivar.exports.export import FORMATS, identifier_of
    from infinivar.exports.export import export as run
    from infinivar.study.load import load_study

    if kind not in FORMATS:
        raise InputError(f"--as {kind!r} is not a format{nearest(kind, FORMATS)}; formats: {', '.join(FORMATS)}")
    loaded = load_study(study)
    name = chosen(study, "drive", drive, loaded.drives, "drive")
    if same := [one for one in loaded.drives if one != name and identifier_of(one) == identifier_of(name)]:
        raise InputError(
            f"{printable(study)}: drives {name!r} and {same[0]!r} would both be written as {identifier_of(name)}; rename one"
        )
    if kind == "mujoco":
        of_one_axis(study, loaded.drives, "export --as mujoco", name)
        if scenario is not None or loop is not None:
            raise InputError(
                f"{'--scenario' if loop is None else '--loop'} does not apply to --as mujoco: MuJoCo has the load and the motion"
            )
    if scenario is not None and loop is not None:
        raise InputError(
            "--scenario and --loop exclude each other: the plant alone, or with the controllers of a scenario"
        )
    option, scenario = ("--scenario", scenario) if loop is None else ("--loop", loop)
    machine, requested = is_machine(loaded.drives[name]), None
    if scenario is not None:
        known: Mapping[str, Any] = loaded.sessions if machine else {**loaded.sessions, **loaded.scenarios}
        if machine and not known:
            raise InputError(
                f"{printable(study)}: {option} does not apply to {name!r}: the study has no sessions, which are tasks with a type"
            )
        requested = known[chosen(study, "scenario", scenario, known, option)]
    with naming_place(study, f"drives.{name}"):
        found = run(
            loaded.drives[name],
            kind,
            out,
            name=name,
            title=loaded.titles[name],
            scenario=requested,
            load_mass=None if machine or scenario in loaded.sessions else loaded.load_mass,
            closed=loop is not None,
            sources=loaded.provenance,
        )
    say(f"Wrote {', '.join(map(str, found.files))}")
    for note in found.notes:
        say(f"  {note}")
