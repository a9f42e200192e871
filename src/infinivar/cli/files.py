"""Commands that need no study: init, schema, reproduce, serve."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Annotated

import typer

from infinivar.cli.arguments import Json, Out, with_figures
from infinivar.cli.shared import print_json
from infinivar.console import complain, flush, progress_bar, say, write
from infinivar.errors import InputError, nearest, printable

_SCHEMA_FILE = "infinivar.schema.json"
"""Name of the schema beside a study."""

_SCHEMA_LINE = f"#:schema ./{_SCHEMA_FILE}"
"""First line of a study; tells editors (Taplo, Even Better TOML) where to find the schema."""


def init(
    name: Annotated[str, typer.Argument(help="Name of the study; writes NAME.toml.", show_default=False)],
    like: Annotated[
        str | None, typer.Option("--like", help="Start from a copy of this shipped study, such as hand_controller.")
    ] = None,
) -> None:
    """Write a commented study file to start from.

    Also write the JSON Schema that lets an editor check the file and complete its keys.
    """
    from infinivar.study.shipped import shipped_studies, template

    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not re.fullmatch(r"\w[\w .-]*", path.stem) or name.endswith("/"):
        raise InputError(f"{name!r} is not a valid file name: use letters, digits, spaces, dots, - and _ only")
    known = shipped_studies()
    if like is not None and like not in known:
        raise InputError(
            f"--like {like!r} is not a shipped study{nearest(like, known)}; shipped studies: {', '.join(known)}"
        )
    if like is None:
        title = path.stem.replace("_", " ").replace("-", " ").capitalize()
        text = template(path.stem, title)
    else:
        text = known[like].read_text("utf-8")
    _write_new(path, f"{_SCHEMA_LINE}\n{text}")
    beside = path.with_name(_SCHEMA_FILE)
    if not beside.exists():
        _write_new(beside, _schema())
    from infinivar.study.check import check_demands
    from infinivar.study.load import load_study

    command = "compare"
    try:
        check_demands(load_study(path), command)
    except InputError:  # sessions only, of a user at the handle
        command = "session"
    say(f"{path} written. Next: infinivar {command} {shlex.quote(str(path))} --out out")


def _write_new(path: Path, text: str) -> None:
    """Write a new file; refuse to overwrite an existing one."""
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as problem:
        raise InputError(f"{printable(path)}: already exists; choose another name or remove the file") from problem
    except OSError as problem:
        raise InputError(f"{printable(path)}: cannot be written: {problem.strerror}") from problem


def _schema() -> str:
    from infinivar.study.json_schema import extended_schema

    return json.dumps(extended_schema(lambda fault: complain(f"left out: {fault}")), indent=2) + "\n"


def schema() -> None:
    """Print the JSON Schema of study files, for editors."""
    write(_schema())


@with_figures("infinivar.paper.report")
def reproduce(
    figure: Annotated[
        int | None, typer.Option("--figure", help="Draw only this figure and check only its claims.")
    ] = None,
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
        print_json(result.to_list())
    else:
        if result.claims:
            say(result.verdict)
        for claim in result.claims:
            say(f"{claim.id:<4} {claim.verdict:<15} {claim.claim}")
        say(result.with_exact_law)
        for beside in filter(None, (result.with_spin, result.with_bearings)):
            say(beside)
        if figure is None and (missing := left_out()):
            say(missing)
        say(f"Report: {files[0]}")


def serve(
    study: Annotated[
        str | None,
        typer.Argument(metavar="STUDY", help="Study file, or the name of a shipped study; by default hand_controller."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            "--port", min=1, max=65535, help="Port; by default 8642, or a free one if it is taken.", show_default=False
        ),
    ] = None,
    host: Annotated[
        str,
        typer.Option("--host", help="Address to listen on; wider than this machine, the printed address has a token."),
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
) -> None:
    """Explore a study in the browser.

    Move a slider, and maps, powers and motions follow.
    Needs the extra web: pip install 'infinivar[web]'. Prints the address of the page; Ctrl-C stops.
    """
    from infinivar.web.server.start import serve as run

    def show(line: str) -> None:
        say(line)
        flush()

    run(study, host=host, port=port, say=show, opened=_open if browser else None)


def _open(address: str) -> None:
    """Open a browser, if there is one; the address is on the terminal in any case."""
    import webbrowser

    webbrowser.open(address)
