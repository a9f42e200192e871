"""Choices that a study leaves open: models, and ways to run a drive, that no source states, each with what could be instead.

A choice is settled if the provenance of its value is anything but `assumed`: stated, catalogue, derived or fitted.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from infinivar._core.fields import walk, with_values
from infinivar.contact import creep
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import ParameterError
from infinivar.machines.wheel import Wheel
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.bearing import Bearing
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.linear import Guideway
from infinivar.parts.shaft_bearings import CylinderBearings
from infinivar.study.catalogue import bearings, rails
from infinivar.study.provenance import Rows, by_field
from infinivar.study.study import Study
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.units import plain, show

LAWS = ("linear", "vermeulen-johnson", "exact")
"""Creep laws that are compared: the paper's, the usual closed form, and rolling contact theory."""

STANDBY = 1.0
"""Power of an idle amplifier that is compared with none: small servo amplifiers draw 0.5 to 3 W. [W]"""

STANDBY_PER_AMPLIFIER = "standby per amplifier"
"""Of each motor, also of each that steers a wheel."""

USUAL_BEARING = "6004"
"""Each of the two bearings of a cylinder that are compared with none: deep groove, 20 mm, static rating 5 kN."""

_MODELS = {"coefficient": "coefficient", "skf": "maker's (skf)"}
_RETURNED = {"burn": "burnt", "store": "stored"}


Scope = Literal["all", "motion", "supply", "run"]
"""What an answer can change: all that a drive does; its motion only, not steady points; the power that it draws, not its
limits; or how it runs in a task."""


class Variant(NamedTuple):
    """A study's drives with another answer to one open choice."""

    choice: str
    used: str
    instead: str
    drives: Mapping[str, Any]
    """Those that it changes, by name."""
    scope: Scope


class _Options(NamedTuple):
    """What a part has, and what it could have instead: values by dotted path from the part, by words."""

    used: str
    instead: Mapping[str, Mapping[str, Any]]
    parts: tuple[Any, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Choice:
    """One kind of choice."""

    name: str
    field: str
    """Field of the part whose provenance settles it."""
    options: Callable[[Any, str, Any], _Options | None]
    """Of a part, its path in the drive, and the drive; None if the part leaves no such choice."""
    scope: Scope = "all"
    shared: bool = True
    """Whether all drives answer it alike, as a law of nature; else only drives with the same parts do."""


def variants(study: Study) -> Iterator[Variant]:
    """Yield a study's drives with another answer to each choice that the study leaves open, one at a time.

    Parameters
    ----------
    study : Study

    Yields
    ------
    Variant   With the changed drives only. Values that a part does not permit are left out.
    """
    rows = by_field(study.provenance)
    for choice in _CHOICES:
        found = {name: _open(choice, name, drive, rows) for name, drive in study.drives.items()}
        known = {name: one for name, one in found.items() if one is not None}
        groups = [known] if choice.shared else _alike(known)
        for group in groups:
            whose = "" if len(group) == len(found) else f" of {', '.join(group)}"
            title = choice.name if choice.shared else f"{choice.name}{whose}"
            for words in dict.fromkeys(words for one in group.values() for words in one.instead):
                changed = {name: one for name, one in group.items() if words in one.instead}
                used = dict.fromkeys(one.used for one in changed.values())
                drives = {name: _made(study.drives[name], one.instead[words]) for name, one in changed.items()}
                if all(drive is not None for drive in drives.values()):
                    yield Variant(title, " or ".join(used), words, drives, choice.scope)


def answers(drive: Any) -> Iterator[tuple[str, str, str, Any]]:
    """Yield each other answer for a drive whose sources are not known: choice, what is used, what instead, and that drive."""
    for choice in _CHOICES:
        found = _open(choice, "", drive, {})
        for words, values in ({} if found is None else found.instead).items():
            made = _made(drive, values)
            if found is not None and made is not None:
                yield choice.name, found.used, words, made


def variants_of(name: str, study: Study) -> Iterator[tuple[str, Any]]:
    """Yield words, such as "steering model: shear", and a drive of the study with that answer to an open choice."""
    for one in variants(study.with_drives(name)):
        yield f"{one.choice}: {one.instead}", one.drives[name]


def _alike(found: Mapping[str, _Options]) -> list[dict[str, _Options]]:
    """Drives by parts that leave a choice open: those with the same parts answer it alike."""
    groups: list[dict[str, _Options]] = []
    for name, one in found.items():
        group = next((group for group in groups if next(iter(group.values())).parts == one.parts), None)
        if group is None:
            groups.append({name: one})
        else:
            group[name] = one
    return groups


def _made(drive: Any, values: Mapping[str, Any]) -> Any:
    """The drive with other values; None if a part does not permit them."""
    try:
        return with_values(drive, values)
    except ParameterError:
        return None


def _open(choice: _Choice, owner: str, drive: Any, rows: Rows) -> _Options | None:
    """What a drive leaves open of a choice: of all its parts that have it; values by path from the drive."""
    used: list[str] = []
    parts: list[Any] = []
    instead: dict[str, dict[str, Any]] = {}
    places = ((place.path, place.value) for place in walk(drive))
    for path, part in [("", drive), *places] if dataclasses.is_dataclass(drive) else ():
        found = choice.options(part, path, drive)
        if found is None:
            continue
        prefix = f"{path}." if path else ""
        row = rows.get((owner, f"{prefix}{choice.field}"))
        if row is not None and row.kind != "assumed":
            continue
        used.append(found.used)
        parts.append(part)
        for words, values in found.instead.items():
            instead.setdefault(words, {}).update({f"{prefix}{inner}": value for inner, value in values.items()})
    return _Options(" or ".join(dict.fromkeys(used)), instead, tuple(parts)) if instead else None


def _steering_model(part: Any, path: str, drive: Any) -> _Options | None:
    if not isinstance(part, RotaryLinearIVT) or part.geometry is None:
        return None
    used, other = ("spin", "shear") if part.turns_with_spin else ("shear", "spin")
    return _Options(used, {other: {"steering_model": other}})


def _creep_law(part: Any, path: str, drive: Any) -> _Options | None:
    if not isinstance(part, RotaryLinearIVT | Wheel):
        return None
    pinned: dict[str, Any] = {}
    if isinstance(part, RotaryLinearIVT) and part.geometry is not None:
        # The default of the steering model follows the law; here one choice is changed at a time.
        pinned = {"steering_model": "spin" if part.turns_with_spin else "shear"}
    laws = [law for law in LAWS if law != part.creep_law.name]
    return _Options(part.creep_law.name, {law: {"creep_law": creep.law(law), **pinned} for law in laws})


def _bearing_model(place: str) -> Callable[[Any, str, Any], _Options | None]:
    def options(part: Any, path: str, drive: Any) -> _Options | None:
        if not isinstance(part, Bearing) or not f".{path}".endswith(f".{place}"):
            return None
        other = next(model for model in _MODELS if model != part.friction_model)
        return _Options(_MODELS[part.friction_model], {_MODELS[other]: {"friction_model": other}})

    return options


def _guideway(part: Any, path: str, drive: Any) -> _Options | None:
    """Makers of rails state their own coefficient; and where several wheels hold each other, some load may stay."""
    if not isinstance(part, Guideway) or part.friction_model != "stated" or not float(part.coefficient) > 0.0:
        return None
    own, element = float(part.coefficient), getattr(drive, "transmission", None)
    stated = {rail.friction_coefficient for rail in rails().values() if rail.friction_coefficient is not None}
    makers = {f"maker's ({plain(one)})": one for one in sorted(stated - {own})}
    if not isinstance(element, RotaryLinearIVT) or element.wheels == 1:
        return _Options(plain(own), {words: {"coefficient": one} for words, one in makers.items()}) if makers else None
    left = {f"that of one wheel stays, {words}": one for words, one in {plain(own): own, **makers}.items()}
    return _Options(
        "preloads cancel",
        {words: {"friction": float(part.friction + one * element.preload)} for words, one in left.items()},
    )


def _cylinder_bearings(part: Any, path: str, drive: Any) -> _Options | None:
    if not isinstance(part, CoboticDrive) or part.cylinder_bearings is not None:
        return None
    return _Options(
        "not counted",
        {
            f"two {USUAL_BEARING}, {words}": {
                "cylinder_bearings": CylinderBearings(bearing=replace(bearings()[USUAL_BEARING], friction_model=model))
            }
            for model, words in _MODELS.items()
        },
    )


def _standby(part: Any, path: str, drive: Any) -> _Options | None:
    if not isinstance(getattr(part, "amplifier", None), Amplifier):
        return None
    count = amplifiers(part, drive)
    used = float(part.amplifier.standby_power) / count
    words = {0.0: "0 W", STANDBY: f"{STANDBY:g} W each"}
    instead = {said: {"amplifier.standby_power": each * count} for each, said in words.items() if each != used}
    return _Options(words.get(used, f"{show(used, 'W')} each"), instead)


def amplifiers(part: Any, drive: Any) -> int:
    """Number of amplifiers whose standby power `part.amplifier` states: a cobotic drive's are also those of its steering."""
    if not isinstance(part, CoboticDrive) or part.steering is None:
        return 1
    return 1 + (1 if part is drive else getattr(drive, "links", 1))


def _returned(part: Any, path: str, drive: Any) -> _Options | None:
    if not isinstance(part, Amplifier) or part.regeneration not in _RETURNED:
        return None
    if part.regeneration == "burn":
        return _Options("burnt", {"stored without loss": {"regeneration": "store", "storage_efficiency": 1.0}})
    return _Options("stored", {"burnt": {"regeneration": "burn", "storage_efficiency": None}})


def _gear_friction(part: Any, path: str, drive: Any) -> _Options | None:
    others = part.alternatives() if isinstance(part, Gearhead) else {}
    return _Options(part.law().CHOICE, others) if others else None


_CHOICES = (
    _Choice(name="steering model", field="steering_model", options=_steering_model, scope="motion"),
    _Choice(name="creep law", field="creep_law", options=_creep_law),
    _Choice(name="axle bearings", field="friction_model", options=_bearing_model("axle_bearing")),
    _Choice(name="cylinder bearings", field="cylinder_bearings", options=_cylinder_bearings),
    _Choice(name="cylinder bearings", field="friction_model", options=_bearing_model("cylinder_bearings.bearing")),
    _Choice(name="guideway under preload", field="coefficient", options=_guideway),
    _Choice(name="pulley bearings", field="friction_model", options=_bearing_model("pulley.bearings.bearing")),
    _Choice(name="bell bearing", field="friction_model", options=_bearing_model("bell_bearing"), scope="motion"),
    _Choice(name=STANDBY_PER_AMPLIFIER, field="amplifier.standby_power", options=_standby, scope="supply"),
    _Choice(name="returned power", field="regeneration", options=_returned, scope="supply"),
    _Choice(name="gear friction", field="loss_model", options=_gear_friction, shared=False),
)
