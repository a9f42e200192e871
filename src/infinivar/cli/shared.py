"""What several commands share: the study that is meant, the drive that is chosen, and where bad input was found."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from infinivar.console import complain, write
from infinivar.errors import InputError, ParameterError, nearest, printable

if TYPE_CHECKING:
    from infinivar.study.study import Study


def print_json(value: Any) -> None:
    """Print a result as JSON."""
    from infinivar.report.page import to_json

    write(to_json(value))


def chosen(study: Path, what: str, name: str | None, known: Mapping[str, Any]) -> str:
    """The name asked for, or else the first there is; where there are several, a line on stderr says which is taken."""
    if name is None and known:
        first = next(iter(known))
        if len(known) > 1:
            complain(f"--{what} not given: using {printable(first)}, the first of {', '.join(map(printable, known))}")
        return first
    if name is not None and name in known:
        return name
    if not known:
        example = f'add a table [{what}s.reach] with base = "faulring2006.reach"'
        raise InputError(f"{printable(study)}: has no {what}s; {example}")
    hint = nearest(name or "", known)
    raise InputError(f"{printable(study)}: --{what} {name!r} is not in the study{hint}; it has {', '.join(known)}")


def chosen_cobotic(study: Path, name: str | None, drives: Mapping[str, Any]) -> str:
    """The drive asked for, or else the first that has a wheel."""
    from infinivar.drivetrain.cobotic import CoboticDrive

    wheeled = {known: drive for known, drive in drives.items() if isinstance(drive, CoboticDrive)}
    return chosen(study, "drive", name, wheeled if name is None and wheeled else drives)


def loaded_study(path: Path) -> Study:
    """The study, with its warnings on stderr."""
    from infinivar.study.load import load_study

    loaded = load_study(path)
    for warning in loaded.warnings:
        complain(f"{printable(path)}: check {warning}")
    return loaded


@contextlib.contextmanager
def naming(study: Path) -> Iterator[None]:
    """Bad input found in a study is named with its file."""
    try:
        yield
    except InputError as problem:
        raise InputError("\n".join(f"{printable(study)}: {line}" for line in str(problem).split("\n"))) from None


@contextlib.contextmanager
def naming_place(study: Path, where: str) -> Iterator[None]:
    """A value that does not do for what is asked is bad input, named with its place."""
    try:
        yield
    except ParameterError as problem:
        raise InputError(f"{printable(study)}: {where}: {problem}") from problem
