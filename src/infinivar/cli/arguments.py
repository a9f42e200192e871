"""Arguments that several commands share, and the options of one command from their description."""

from __future__ import annotations

import contextlib
import functools
import inspect
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from infinivar.errors import InputError
from infinivar.options import Options


def _studies(incomplete: str) -> list[str]:
    """Completions of a study: names of shipped ones, study files and folders."""
    from infinivar.study.shipped import shipped_studies

    folder, _, begun = incomplete.rpartition("/")
    lead = incomplete[: len(incomplete) - len(begun)]
    try:
        there = sorted(Path(folder or (lead or ".")).iterdir())
    except OSError:
        there = []
    files = [f"{lead}{path.name}{'/' if path.is_dir() else ''}" for path in there]
    return [
        name
        for name in [*shipped_studies(), *files]
        if name.startswith(incomplete)
        and name.endswith(("/", ".toml") if "." in name or "/" in name else name)
        and not name.rpartition("/")[2].startswith(".")
    ]


def _names(context: typer.Context, group: str, incomplete: str) -> list[str]:
    """Names in a group of the study on the line; none where it cannot be read, as completion has nowhere to say why."""
    from infinivar.study.load import load_study

    # While an option still waits for its value, Click leaves the arguments before it aside.
    words = [word for word in context.args if not word.startswith("-")]
    try:
        study = load_study(context.params.get("study") or "".join(words[:1]))
    except InputError:
        return []
    return [name for name in getattr(study, group) if name.startswith(incomplete)]


def drives_of_study(context: typer.Context, incomplete: str) -> list[str]:
    """Completions of a drive."""
    return _names(context, "drives", incomplete)


def scenarios_of_study(context: typer.Context, incomplete: str) -> list[str]:
    """Completions of a scenario."""
    return _names(context, "scenarios", incomplete)


def sessions_of_study(context: typer.Context, incomplete: str) -> list[str]:
    """Completions of a task of a session."""
    return _names(context, "sessions", incomplete)


StudyFile = Annotated[
    Path,
    typer.Argument(
        help="Study file (TOML), or the name of a shipped study, such as hand_controller.",
        show_default=False,
        autocompletion=_studies,
    ),
]


def named_path(text: str | Path) -> Path:
    """Path from the command line; empty text is an error, not the current folder."""
    if not str(text).strip():
        raise typer.BadParameter("must name a folder or file, such as out; use . for the current folder")
    return Path(text)


_OUT = typer.Option("--out", parser=named_path, metavar="PATH", help="Folder for the results; created if missing.")
Out = Annotated[Path, _OUT]
OptionalOut = Annotated[Path | None, _OUT]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON on standard output.")]

_PDF = Annotated[bool, typer.Option("--pdf", help="Write the figures as PDF, too, beside PNG and SVG.")]
_DRAWING = tuple(f"matplotlib.{name}" for name in ("figure", "backends.backend_agg", "backends.backend_svg"))
"""What is imported to draw."""

_BY_NAME = inspect.Parameter.KEYWORD_ONLY
_LAST = ("workers", "out", "as_json")
"""Where and how results are made: listed after what they are made from."""

_PLAIN = (bool, int, float, str)
"""Types of defaults that a command line shows itself."""


def with_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command whose parameter of a class of `Options` is an option for each field of the class.

    The parameter may be annotated with the class alone, or with ``Annotated[kind, *names]`` for some of its fields.
    """
    signature = inspect.signature(command, eval_str=True)
    where, kind, names = next(_described(signature))
    own = [one.replace(kind=_BY_NAME) for one in signature.parameters.values() if one.name != where]
    at = next((place for place, one in enumerate(own) if one.name in _LAST), len(own))
    parameters = [*own[:at], *(_parameter(kind, name) for name in names), *own[at:]]

    @functools.wraps(command)
    def run(**given: Any) -> Any:
        said = {name: given.pop(name) for name in names}
        return command(**given, **{where: kind.read(said, lambda name: option_name(kind, name))})

    run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run


def _described(signature: inspect.Signature) -> Iterator[tuple[str, type[Options], tuple[str, ...]]]:
    """Yield each parameter with a description: its name, the class, and the names of its fields."""
    for one in signature.parameters.values():
        kind, *names = typing.get_args(one.annotation) or (one.annotation,)
        if isinstance(kind, type) and issubclass(kind, Options):
            yield one.name, kind, tuple(names or kind.described())


def with_figures(report: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorate a command whose report has figures: it gets the option --pdf behind --out, and processes that draw.

    These import `report`, the module that writes it, while the command computes.
    """

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(command, eval_str=True)
        parameters = list(signature.parameters.values())
        place = 1 + next(place for place, one in enumerate(parameters) if one.name == "out")
        pdf = inspect.Parameter("pdf", parameters[place].kind, default=False, annotation=_PDF)

        @functools.wraps(command)
        def run(*, pdf: bool, **given: Any) -> Any:
            from infinivar._core.processes import opened

            with contextlib.ExitStack() as held:
                if not given.get("quick"):
                    held.enter_context(opened(report, *_DRAWING))
                if pdf:
                    from infinivar.figures.style import FORMATS, written_as

                    held.enter_context(written_as(*FORMATS))
                return command(**given)

        run.__signature__ = signature.replace(parameters=[*parameters[:place], pdf, *parameters[place:]])  # type: ignore[attr-defined]
        run.__annotations__ = {**command.__annotations__, "pdf": pdf.annotation}
        return run

    return decorated


def option_name(kind: type[Options], name: str) -> str:
    """An option as it is typed, such as --slip-margin."""
    return f"--{(kind.described()[name].name or name).replace('_', '-')}"


def _parameter(kind: type[Options], name: str) -> inspect.Parameter:
    """An option as a parameter of a command, which Typer understands."""
    known, default, usual = kind.described()[name], kind.default(name), kind.usual(name)
    shown = isinstance(default, _PLAIN)
    option = typer.Option(
        option_name(kind, name),
        help=known.help if shown or not usual else f"{known.help} [default: {usual}]",
        min=known.least,
        metavar=known.metavar,
    )
    stated = known.stated if shown else known.stated | None
    return inspect.Parameter(name, _BY_NAME, default=default if shown else None, annotation=Annotated[stated, option])
