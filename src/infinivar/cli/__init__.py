"""The command line: each command parses its arguments, calls one function and prints the result.

Commands import their dependencies when they run, so the command line starts as fast as Python and Typer allow.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Annotated, Any

import typer

from infinivar import __version__
from infinivar.cli import catalogue, files, measured, motions, rigs, runs, sessions, studies, sweeps
from infinivar.console import run, say

app = typer.Typer(
    help="Model, size and compare drive-trains with an infinitely variable (cobotic) transmission or a fixed ratio.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for command in (
    *(files.init, studies.check, studies.compare, studies.size, studies.contact, motions.motion),
    *(runs.simulate, sessions.session, runs.sensitivity, runs.graph, runs.export, rigs.rig, rigs.calibrate),
    *(files.reproduce, files.schema, files.serve),
):
    app.command()(command)
app.add_typer(catalogue.app, name="catalogue")
app.add_typer(measured.app, name="measured")
app.add_typer(sweeps.app, name="sweep")


def main() -> None:
    """Entry point; see `infinivar.console.run` for the exit codes."""
    run(_parser())


@functools.cache
def _parser() -> Callable[[], Any]:
    """What parses arguments and calls commands; made once, however often a process calls `main`."""
    return typer.main.get_command(app)


def _print_version(required: bool) -> None:
    if required:
        say(f"infinivar {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass
