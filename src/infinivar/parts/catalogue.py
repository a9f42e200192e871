"""Shipped catalogue: tables of motors, gearheads, bearings and gear efficiencies, with sources."""

from __future__ import annotations

import functools
import tomllib
from importlib import resources
from typing import Any

from infinivar.errors import InputError, nearest


@functools.cache
def data(name: str) -> dict[str, Any]:
    """Raw content of a data file: "motors", "gearheads", "bearings" or "gear_efficiencies"."""
    return tomllib.loads((resources.files("infinivar.parts") / "data" / f"{name}.toml").read_text("utf-8"))


def entries(name: str) -> dict[str, dict[str, Any]]:
    """Parts of a catalogue ("motors", "gearheads" or "bearings") by key, each with the kind and source of its values."""
    raw = data(name)
    origin = {key: raw[key] for key in ("kind", "where")}
    return {key: {**origin, **value} for key, value in raw.items() if isinstance(value, dict)}


def entry(name: str, key: str) -> dict[str, Any]:
    """One part of a catalogue.

    Raises
    ------
    InputError
        If the catalogue has no such part; the message suggests the closest name.
    """
    parts = entries(name)
    if key not in parts:
        raise InputError(f"{key!r} is not in the catalogue of {name}{nearest(key, parts)}; see: infinivar catalogue")
    return parts[key]
