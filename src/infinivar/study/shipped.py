"""The shipped parameter sets, one TOML a source."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any

from infinivar.errors import InputError, nearest


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
    return tomllib.loads((resources.files("infinivar.study") / "sets" / f"{name}.toml").read_text("utf-8"))
