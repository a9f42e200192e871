"""Data shipped with the package: parameter sets, one TOML file per source, the example studies and the template of a new one."""

from __future__ import annotations

import copy
import functools
import os
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

from infinivar.errors import InputError, nearest, printable

_INSTALLED = Path(__file__).parent / "shipped_studies"
_CHECKOUT = Path(__file__).parents[3] / "studies"
"""The studies are in the root of the repository; the build copies them into the wheel."""

_LONGEST = 64
"""Longest text, in characters, that may be meant as the name of a shipped study."""


def parameter_sets() -> tuple[str, ...]:
    """Return the names of the shipped parameter sets."""
    files = resources.files("infinivar.study") / "sets"
    return tuple(sorted(file.name.removesuffix(".toml") for file in files.iterdir() if file.name.endswith(".toml")))


def parameter_set(name: str) -> dict[str, Any]:
    """Return the nested tables of a shipped parameter set, as written.

    Raises
    ------
    InputError
        If no set has that name; the message lists the shipped sets.
    """
    return copy.deepcopy(shared_set(name))


def shared_set(name: str) -> dict[str, Any]:
    """As `parameter_set`, for a caller that changes nothing in it: a copy of a whole set takes longer than reading a study."""
    if name not in parameter_sets():
        raise InputError(
            f"{name!r} is not a shipped parameter set{nearest(name, parameter_sets())}; "
            f"shipped sets: {', '.join(parameter_sets())}"
        )
    return _parsed(name)


@functools.cache
def _parsed(name: str) -> dict[str, Any]:
    return tomllib.loads((resources.files("infinivar.study") / "sets" / f"{name}.toml").read_text("utf-8"))


def template(name: str, title: str) -> str:
    """Return the commented study file that `infinivar init` writes, for a name and title."""
    text = (resources.files("infinivar.study") / "template.toml").read_text("utf-8")
    return text.replace("{name}", name).replace("{title}", title)


def shipped_studies() -> dict[str, Path]:
    """Return the files of the shipped studies, by name."""
    folder = _INSTALLED if _INSTALLED.is_dir() else _CHECKOUT
    return {file.stem: file for file in sorted(folder.glob("*.toml"))}


def study_file(path: Path) -> Path:
    """Return the file at a path, or else the shipped study of that name.

    Any other path is returned unchanged.

    Raises
    ------
    InputError
        If a bare name matches neither; the message lists the shipped studies.
    """
    name = str(path)
    known = shipped_studies()
    if name in known and not path.is_file():
        return known[name]
    if path.suffix or path.name != name or len(name) > _LONGEST or os.path.exists(path):  # noqa: PTH110 (Path.exists raises on odd names)
        return path
    raise InputError(
        f"{printable(name)}: neither a file nor a shipped study{nearest(name, known)}; shipped studies: {', '.join(known)}"
    )
