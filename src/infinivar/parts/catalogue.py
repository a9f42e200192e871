"""Shipped catalogue: tables of motors, gearheads, bearings and gear efficiencies, with sources."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any

from infinivar.errors import InputError, nearest

FORMS = ("m1", "m2", "m3", "m4", "m5", "m6")
"""Forms of identified friction, from Coulomb and viscous to Stribeck with squared load."""

_UNITS = {
    "friction": "N m",
    "viscous": "N m s",
    "friction_stribeck": "N m",
    "stribeck_speed": "rad/s",
    "stribeck_exponent": "",
    "load_motor": "",
    "load_output": "",
    "load_motor_stribeck": "",
    "load_output_stribeck": "",
    "load_motor_squared": "1/(N m)",
    "load_output_squared": "1/(N m)",
}
"""Units of the fields of `GearFriction`."""


@functools.cache
def data(name: str) -> dict[str, Any]:
    """Raw content of a data file: "motors", "gearheads", "bearings", "gear_efficiencies" and so on."""
    return tomllib.loads((resources.files("infinivar.parts") / "data" / f"{name}.toml").read_text("utf-8"))


def entries(name: str) -> dict[str, dict[str, Any]]:
    """Parts of a catalogue ("motors", "gearheads" or "bearings") by key, each with the kind and source of its values."""
    raw = data(name)
    origin = {key: raw[key] for key in ("kind", "where")}
    found = {key: {**origin, **value} for key, value in raw.items() if isinstance(value, dict)}
    return {**found, **_identified()} if name == "gearheads" else found


def _identified() -> dict[str, dict[str, Any]]:
    """Gearheads with the friction of geared actuators, each in the most complete form identified."""
    raw, found = data("actuator_friction"), {}
    for key, actuator in raw.items():
        if isinstance(actuator, dict):
            form = max(name for name in actuator if name in FORMS)
            found[key.replace("_", "-")] = {
                **{name: raw[name] for name in ("kind", "where")},
                "name": f"{actuator['name']}, friction of gear and motor",
                "ratio": actuator["ratio"],
                "loss_model": "stribeck",
                "friction": {name: f"{value!r} {unit}".strip() for name, value, unit in friction_terms(actuator[form])},
            }
    return found


def friction_terms(identified: Mapping[str, float]) -> Iterator[tuple[str, float, str]]:
    """Yield the fields of `GearFriction` that an identified form states: name, value in SI, unit or ""."""
    for name, value in identified.items():
        kind = name.removeprefix("load")
        if name.startswith("load") and kind in ("", "_stribeck"):
            # One coefficient for the torques of both sides.
            yield f"load_motor{kind}", value, ""
            yield f"load_output{kind}", value, ""
        elif name in _UNITS:
            yield name, value, _UNITS[name]


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
