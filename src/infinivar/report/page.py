"""Rendering a template, and putting finished files in place all at once."""

from __future__ import annotations

import contextlib
import csv
import functools
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from infinivar import __version__, references
from infinivar.errors import InputError


@functools.cache
def _environment() -> Any:
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("infinivar.report"), autoescape=True, undefined=jinja2.StrictUndefined
    )
    environment.filters["si"] = lambda value, digits=3: (
        "–" if value is None or value != value else f"{value:.{digits}g}"
    )
    environment.filters["watts"] = lambda value: "–" if value != value else f"{value:.2f} W"
    environment.filters["percent"] = lambda value: "–" if value != value else f"{100 * value:.1f} %"
    environment.globals.update(version=__version__, cite=references.cite)
    return environment


def render(template: str, **values: Any) -> str:
    """The page that a template makes of the values."""
    return _environment().get_template(template).render(**values)


def write_csv(columns: Mapping[str, Any], path: Path) -> None:
    """Columns of numbers under their names."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows([f"{value:.9g}" for value in row] for row in zip(*columns.values(), strict=True))


@contextlib.contextmanager
def all_or_nothing(directory: Path) -> Iterator[Path]:
    """Scratch folder whose files replace those of `directory` once the block has ended without an error.

    Raises
    ------
    InputError
        If the directory cannot be made or written to.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=directory, prefix=".infinivar-") as scratch:
            yield Path(scratch)
            taken = [made.name for made in Path(scratch).iterdir() if (directory / made.name).is_dir()]
            if taken:
                raise InputError(f"{directory / taken[0]}: cannot be replaced: is a folder")
            for made in sorted(Path(scratch).iterdir()):
                made.replace(directory / made.name)
    except OSError as problem:
        raise InputError(f"{directory}: cannot be written to: {problem.strerror}") from problem
