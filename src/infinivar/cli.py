"""The command line: reads arguments, calls one function, prints what comes back."""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from infinivar import __version__
from infinivar.errors import AuditError, InputError

NOT_FEASIBLE, BAD_INPUT, OWN_FAULT = 1, 2, 3

app = typer.Typer(
    help="Models, sizes and compares drive-trains with an infinitely variable (cobotic) transmission and a fixed ratio.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

StudyFile = Annotated[Path, typer.Argument(help="Study file (TOML).", show_default=False)]
Out = Annotated[Path, typer.Option("--out", help="Folder for the results; made if it is not there.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON on standard output.")]


def main() -> None:
    """Entry point: bad input is one message on stderr and exit code 2."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a title the terminal cannot show is no reason to fail
    try:
        app()
    except InputError as problem:
        print(f"infinivar: {problem}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except AuditError as problem:
        print(f"infinivar: fault of the program, please report it with your study: {problem}", file=sys.stderr)
        sys.exit(OWN_FAULT)
    except BrokenPipeError:  # the reader of our output, such as head, has gone
        sys.stderr.close()
    except OSError as problem:
        print(f"infinivar: {problem.filename or 'standard output'}: {problem.strerror}", file=sys.stderr)
        sys.stdout = None  # there is nothing left to flush it to
        sys.exit(BAD_INPUT)


@contextlib.contextmanager
def _progress() -> Iterator[Callable[[str, float], None]]:
    """Progress bar on stderr, on terminals only."""
    if not sys.stderr.isatty():
        yield lambda title, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description:<40.40}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=1.0)
        yield lambda title, share: bar.update(task, description=title, completed=share)


def _print_json(value: Any) -> None:
    from infinivar.report.comparison import to_json

    sys.stdout.write(to_json(value))


@app.command()
def compare(study: StudyFile, out: Out = Path("out"), as_json: Json = False) -> None:
    """Hold every drive of a study against its requirement; write report, results and maps.

    Exit code 1 if no drive covers the requirement.
    """
    from infinivar.analysis.compare import compare as run
    from infinivar.study.load import load_study

    loaded = load_study(study)
    for warning in loaded.warnings:
        print(f"infinivar: {study}: check {warning}", file=sys.stderr)
    with _progress() as progress:
        comparison = run(loaded, progress=progress)
        progress("writing the report", 1.0)
        files = comparison.save(out)
    if as_json:
        _print_json({**comparison.to_dict(), "files": [str(file) for file in files]})
    else:
        width = max(len(result.title) for result in comparison.results.values())
        for result in comparison.results.values():
            print(f"{result.title:<{width}}  {result.verdict}")
        print(f"Report: {files[0]}")
    raise typer.Exit(0 if comparison.feasible else NOT_FEASIBLE)


@app.command()
def reproduce(
    figure: Annotated[int | None, typer.Option("--figure", help="Only this figure and its claims.")] = None,
    out: Out = Path("out"),
    as_json: Json = False,
) -> None:
    """Draw the paper's figures and check its claims."""
    from infinivar.analysis.reproduce import reproduce as run
    from infinivar.report import reproduction

    reproduction.check_figure(figure)
    with _progress() as progress:
        result = run(figure, progress=progress)
        progress("drawing", 1.0)
        files = reproduction.save(result, out, figure)
    if as_json:
        _print_json(result.to_list())
    else:
        for claim in result.claims:
            print(f"{claim.id:<4} {claim.verdict:<14} {claim.claim}")
        print(f"Report: {files[0]}")


@app.command()
def schema() -> None:
    """Print the JSON Schema of study files, for editors."""
    from infinivar.study.schema import json_schema

    print(json.dumps(json_schema(), indent=2))


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
        raise InputError(f"{path}: is there already; choose another name or remove it") from problem
    except OSError as problem:
        raise InputError(f"{path}: cannot be written: {problem.strerror}") from problem
    print(f"{path} written. Next: infinivar compare {shlex.quote(str(path))} --out out")


@app.command()
def catalogue(as_json: Json = False) -> None:
    """List the motors and gearheads that a study can take by `part`."""
    from infinivar.study.parts import gearheads, motors

    if as_json:
        import dataclasses

        parts = {"motors": motors(), "gearheads": gearheads()}
        _print_json(
            {kind: {key: dataclasses.asdict(part) for key, part in group.items()} for kind, group in parts.items()}
        )
        return
    print(f"{'motor':<30} {'voltage':>8} {'cont. torque':>13} {'no-load speed':>14} {'peak eff.':>10} {'mass':>8}")
    for key, motor in motors().items():
        rpm = (
            (motor.voltage - motor.resistance * motor.no_load_current) / motor.torque_constant * 60 / 6.283185307179586
        )
        mass = "" if motor.mass is None else f"{motor.mass * 1e3:.0f} g"
        print(
            f"{key:<30} {motor.voltage:>6.3g} V {motor.continuous_torque * 1e3:>8.4g} mN m {rpm:>10.0f} rpm"
            f" {motor.peak_efficiency:>9.0%} {mass:>9}"
        )
    print(f"\n{'gearhead':<30} {'ratio':>8} {'efficiency':>13} {'cont. torque':>14} {'mass':>10}")
    for key, gear in gearheads().items():
        torque = "" if gear.continuous_torque is None else f"{gear.continuous_torque:.3g} N m"
        mass = "" if gear.mass is None else f"{gear.mass * 1e3:.0f} g"
        print(f"{key:<30} {gear.ratio:>8.4g} {gear.efficiency:>13.0%} {torque:>14} {mass:>10}")


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"infinivar {__version__}")
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
