"""Options that several commands share, and functions that parse their text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from infinivar.errors import InputError

StudyFile = Annotated[Path, typer.Argument(help="Study file (TOML).", show_default=False)]


def named_path(text: str | Path) -> Path:
    """Path from the command line; empty text is an error, not the current folder."""
    if not str(text).strip():
        raise typer.BadParameter("must name a folder or file, such as out; use . for the current folder")
    return Path(text)


Out = Annotated[
    Path,
    typer.Option("--out", parser=named_path, metavar="PATH", help="Folder for the results; created if missing."),
]
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
