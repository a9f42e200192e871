"""What ships with the package: parameter sets, one TOML a source, and the example studies."""

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
"""The studies lie at the root of the repository, from where they are built into the wheel."""

_LONGEST = 64
"""Letters of what may be meant as the name of a shipped study."""


def parameter_sets() -> tuple[str, ...]:
    """Names of the shipped parameter sets."""
    files = resources.files("infinivar.study") / "sets"
    return tuple(sorted(file.name.removesuffix(".toml") for file in files.iterdir() if file.name.endswith(".toml")))


def parameter_set(name: str) -> dict[str, Any]:
    """Nested tables of a shipped parameter set, as written.

    Raises
    ------
    InputError
        If there is no such set; the message lists those there are.
    """
    if name not in parameter_sets():
        raise InputError(
            f"{name!r} is not a shipped parameter set{nearest(name, parameter_sets())}; "
            f"there is {', '.join(parameter_sets())}"
        )
    return copy.deepcopy(_parsed(name))


@functools.cache
def _parsed(name: str) -> dict[str, Any]:
    return tomllib.loads((resources.files("infinivar.study") / "sets" / f"{name}.toml").read_text("utf-8"))


def shipped_studies() -> dict[str, Path]:
    """Files of the shipped studies by name."""
    folder = _INSTALLED if _INSTALLED.is_dir() else _CHECKOUT
    return {file.stem: file for file in sorted(folder.glob("*.toml"))}


def study_file(path: Path) -> Path:
    """The file at a path, or else the shipped study of that name.

    Raises
    ------
    InputError
        If the path is a bare name of neither; the message lists the shipped studies. Any other path is returned as it is.
    """
    name = str(path)
    known = shipped_studies()
    if name in known and not path.is_file():
        return known[name]
    if path.suffix or path.name != name or len(name) > _LONGEST or os.path.exists(path):  # noqa: PTH110 (Path.exists raises on odd names)
        return path
    raise InputError(
        f"{printable(name)}: is neither a file nor a shipped study{nearest(name, known)}; shipped studies: {', '.join(known)}"
    )
