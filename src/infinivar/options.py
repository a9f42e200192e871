"""Options that several commands share, and functions that parse their text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from infinivar.errors import InputError


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


def quantity(option: str, text: str | None, unit: str) -> float | None:
    """SI value of an option such as "20 N"; None if the option is absent."""
    from infinivar import units

    try:
        return None if text is None else units.parse(text, unit)
    except InputError as problem:
        raise InputError(f"{option} {text!r} {problem}") from None


def numbers(option: str, text: str) -> tuple[float, ...]:
    """Values of an option such as "100,8,1"."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--{option} {text!r} must be numbers separated by commas, such as 100,8,1") from None


def headings(option: str, text: str | None) -> dict[str, str] | None:
    """Headings of columns by name, from "name=heading, name=heading"; None if the option is not given.

    Raises
    ------
    InputError
        If the text is anything else.
    """
    if text is None:
        return None
    found = {}
    for part in text.split(","):
        name, mark, heading = part.partition("=")
        if not mark or not name.strip() or not heading.strip():
            raise InputError(f'{option} {text!r} must be roles and headings, such as "time=t, angle=Knee angle [deg]"')
        found[name.strip()] = heading.strip()
    return found
