"""Shipped catalogue: tables of motors, gearheads, bearings, rails, belts, springs, tubes and gear efficiencies, with sources."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal

from infinivar._core import files
from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar.contact.bodies import Material
from infinivar.errors import InputError, nearest
from infinivar.parts.bearing import Bearing
from infinivar.parts.belt import TimingBelt
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.parts.rail import Rail
from infinivar.parts.structure.stock import StockSpring, StockTube
from infinivar.units import parse

PARTS: Mapping[str, type] = {
    "motors": Motor,
    "gearheads": Gearhead,
    "bearings": Bearing,
    "rails": Rail,
    "belts": TimingBelt,
    "springs": StockSpring,
    "tubes": StockTube,
    "materials": Material,
}
"""Part described by a row of each kind of table."""

Sized = Literal["bearings", "rails", "belts", "springs"]
"""Kinds of which the lightest that carries a load can be chosen."""

Fits = Callable[[Any], Array]

_RATINGS = {
    "bearings": "static_rating",
    "rails": "static_rating",
    "belts": "permissible_force",
    "springs": "permissible_force",
}
_SAME = 1e-6
"""Relative difference of sizes that are equal, as some are converted from other units."""

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
    return files.shipped("parts", name)


def rows(name: str) -> dict[str, dict[str, Any]]:
    """All that a catalogue ("motors", "gearheads", "bearings" and so on) states of its parts, by key."""
    raw = data(name)
    shared = {key: value for key, value in raw.items() if not isinstance(value, dict)}
    found = {key: {**shared, **value} for key, value in raw.items() if isinstance(value, dict)}
    return {**found, **_identified()} if name == "gearheads" else found


def entries(name: str) -> dict[str, dict[str, Any]]:
    """Parts of a catalogue by key: the values that a study can state, with their kind and source."""
    kept = {"kind", "where", *(field.name for field in dataclasses.fields(PARTS[name]))}
    return {key: {word: value for word, value in row.items() if word in kept} for key, row in rows(name).items()}


@functools.cache
def parts(kind: Literal["bearings", "rails", "belts", "springs", "tubes", "materials"]) -> Mapping[str, Any]:
    """Every part of a catalogue of plain parts, by key: without the provenance that studies record."""
    fields = {field.name: field.metadata.get("unit") for field in dataclasses.fields(PARTS[kind])}
    found = {}
    for key, row in entries(kind).items():
        stated = {name: row[name] for name in fields if name in row}
        found[key] = PARTS[kind](
            **{name: one if (unit := fields[name]) is None else _read(one, unit) for name, one in stated.items()}
        )
    return found


@functools.cache
def _by_weight(kind: Sized) -> tuple[Any, ...]:
    """The parts of a catalogue, the heaviest first."""
    return tuple(sorted(parts(kind).values(), key=lambda part: -part.weight))


def _read(value: Any, unit: str) -> float:
    stated = value["value"] if isinstance(value, dict) else value
    return parse(stated, unit) if isinstance(stated, str) else float(stated)


def _carries(kind: Sized, part: Any, load: Array, same: Mapping[str, Array], fits: Fits | None) -> Array:
    found = getattr(part, _RATINGS[kind]) >= load
    if fits is not None:
        found = found & fits(part)
    for name, value in same.items():
        found = found & (abs(getattr(part, name) - value) <= _SAME * value)
    return found


def lightest_part(kind: Sized, load: float, fits: Fits | None = None, **same: float) -> Any:
    """The lightest part of the catalogue that carries a load, see `lightest`; None if there is none."""
    return next((part for part in reversed(_by_weight(kind)) if _carries(kind, part, load, same, fits)), None)


def lightest(
    kind: Sized, load: Array, sizes: tuple[str, ...], fits: Fits | None = None, **same: Array
) -> dict[str, Any]:
    """What the lightest part of the catalogue measures whose static rating, or permissible force, reaches a load.

    Parameters
    ----------
    load : (...,) float   [N]
    sizes : names         Fields or properties of the part.
    fits : function       Of a part: whether it has what else is required of it, (...,) bool.
    same : (...,) float   Sizes in SI that it must have, such as the pitch of a belt.

    Returns
    -------
    dict   By name, arrays of the shape of `load`, in SI; nan where no part carries it. For a single load also "name", that of
        the part, or None.
    """
    if all(isinstance(one, (int, float)) for one in (load, *same.values())):
        part = lightest_part(kind, load, fits, **same)
        found = {name: math.nan if part is None else float(getattr(part, name)) for name in sizes}
        return {**found, "name": None if part is None else part.name}
    xp = namespace(load, *same.values())
    load, *values = as_floats(xp, load, *same.values())
    same = dict(zip(same, values, strict=True))
    found = dict.fromkeys(sizes, xp.nan + sum(values, 0.0 * load))
    for part in _by_weight(kind):
        carries = _carries(kind, part, load, same, fits)
        found = {name: xp.where(carries, getattr(part, name), value) for name, value in found.items()}
    return found


def _identified() -> dict[str, dict[str, Any]]:
    """Gearheads with the friction of geared actuators, each in the most complete form identified."""
    raw, found = data("actuator_friction"), {}
    for key, actuator in raw.items():
        if isinstance(actuator, dict):
            form = max(name for name in actuator if name in FORMS)
            found[key.replace("_", "-")] = {
                **{name: raw[name] for name in ("kind", "where", "date")},
                **{name: actuator[name] for name in ("manufacturer", "order_number")},
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
