"""Helpers shared by commands: load the study, choose the drive, and add the location to input errors."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer

from infinivar.console import NOT_FEASIBLE, complain, say, write
from infinivar.errors import InputError, ParameterError, nearest, printable

if TYPE_CHECKING:
    from infinivar.study.study import Study


def print_json(value: Any) -> None:
    """Print a result as JSON."""
    from infinivar.report.page import to_json

    write(to_json(value))


def end(
    found: Callable[[], Mapping[str, Any]],
    lines: Iterable[str],
    files: Sequence[Path] = (),
    *,
    as_json: bool,
    feasible: bool = True,
    beside: Iterable[str] = (),
) -> NoReturn:
    """Print the answer as JSON with the files written, or in lines, the report, and what lies beside it; exit with 0 or 1."""
    if as_json:
        print_json({**found(), "files": [str(file) for file in files]})
    else:
        for line in itertools.chain(lines, (f"Report: {file}" for file in files[:1]), beside):
            say(line)
    raise typer.Exit(0 if feasible else NOT_FEASIBLE)


def chosen(study: Path, what: str, name: str | None, known: Mapping[str, Any], said: str = "") -> str:
    """Return the given name, or the first one by default; if there are several, report the choice on stderr.

    Messages call the name as it is `said` on the command line, by default as the option of what it is.
    """
    said = said or f"--{what}"
    if name is None and known:
        first = next(iter(known))
        if len(known) > 1:
            complain(f"no {said} given: using {printable(first)}, the first of {', '.join(map(printable, known))}")
        return first
    if name is not None and name in known:
        return name
    if not known:
        example = f'add a table [{what}s.reach] with base = "faulring2006.reach"'
        raise InputError(f"{printable(study)}: the study has no {what}s; {example}")
    hint = nearest(name or "", known)
    raise InputError(f"{printable(study)}: {said} {name!r} is not in the study{hint}; it has {', '.join(known)}")


def chosen_cobotic(study: Path, name: str | None, drives: Mapping[str, Any]) -> str:
    """Return the given drive, or the first cobotic one by default."""
    from infinivar.drivetrain.cobotic import CoboticDrive

    wheeled = {known: drive for known, drive in drives.items() if isinstance(drive, CoboticDrive)}
    return chosen(study, "drive", name, wheeled if name is None and wheeled else drives)


def of_one_axis(study: Path, drives: Mapping[str, Any], command: str, name: str | None = None) -> None:
    """Refuse machines, which have no single axis: the drive of a name, or the first machine of all drives.

    Raises
    ------
    InputError
        One message with the commands that work with the machine.
    """
    from infinivar.drivetrain.drive import refuse_machine

    with naming(study):
        for known, drive in drives.items():
            if name is None or known == name:
                refuse_machine(drive, command, f"drives.{known}")


def loaded_study(path: Path) -> Study:
    """Load a study and print its warnings on stderr."""
    from infinivar.study.load import load_study

    loaded = load_study(path)
    for warning in loaded.warnings:
        complain(f"{printable(path)}: warning: {warning}")
    return loaded


@contextlib.contextmanager
def naming(study: Path) -> Iterator[None]:
    """Add the study's file name to input errors raised within."""
    try:
        yield
    except InputError as problem:
        raise InputError("\n".join(f"{printable(study)}: {line}" for line in str(problem).split("\n"))) from None


@contextlib.contextmanager
def naming_place(study: Path, where: str) -> Iterator[None]:
    """Report parameter errors raised within as input errors, with the file and the place."""
    try:
        yield
    except ParameterError as problem:
        raise InputError(f"{printable(study)}: {where}: {problem}") from problem
