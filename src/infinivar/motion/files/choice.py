"""Which column of a file is what: by the names and units of its headings, or as a study says."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Container, Mapping, Sequence
from typing import NamedTuple, NoReturn

from infinivar import units
from infinivar.errors import InputError, printable
from infinivar.motion.files.table import ABOUT_A_JOINT, ROLES, SIGNED
from infinivar.tables.headings import Heading, folded, name_of, named_per_kg, unit_and_per_kg
from infinivar.tables.named import place_of
from infinivar.tables.sheet import Source, fault, refuse, shown

_ALONG_A_LINE = tuple(ABOUT_A_JOINT.values())
SCALED = ("force", "moment")
"""Roles that may be stated per kilogram of body mass."""

_EXAMPLES = {"time": "s", "phase": "%", "position": "mm", "speed": "mm/s", "force": "N"} | {
    "angle": "deg",
    "angular_speed": "deg/s",
    "moment": "N m",
}

_INSTEAD = {"phase": "time", "speed": "position"}
"""Families that are not needed where another is found, so that a fault in them does not matter."""

_LOCOHUB = {"phase_ipsi": "%", "phase_contra": "%"}
"""Headings of the LocoHub standard without a unit, and the unit that the standard gives them."""


_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")

FAMILIES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "phase": ("phase",),
    "position": ("position", "angle"),
    "speed": ("speed", "angular_speed"),
    "force": ("moment", "force"),
    "heel_strike": ("heel_strike",),
}
"""Families of quantities that names speak of, with the roles that the unit chooses from."""

_NAMED = {
    "time": {"time", "t", "timestamp"},
    "speed": {"speed", "velocity", "vel"},
    "force": {"force", "f", "fx", "fy", "fz", "moment", "torque"},
    "position": {"position", "pos", "displacement", "disp", "stroke", "travel", "angle", "theta", "rotation"},
}
"""Words of each family; the first family with a word in the heading counts, as in "angle velocity"."""

_OF_A_ROLE = {
    "angle": {"angle", "theta", "rotation"},
    "angular_speed": {"angular", "angle", "theta", "rotation"},
    "moment": {"moment", "torque"},
    "force": {"force", "f", "fx", "fy", "fz"},
}
"""Words that leave no choice between the roles of a family."""

_JOINTS = {"hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist"}
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right", "ipsi": "ipsi", "contra": "contra"}
"""Words of the joints and sides of a body, by which columns belong together."""

_OF_A_CYCLE = {"phase", "gait", "stride", "cycle", "gc"}
_NOT_THE_MOTION = {
    "acceleration", "acc", "power", "work", "energy", "jerk", "error", "setpoint", "target", "reference", "desired",
    "command", "cmd", "std", "sd", "deviation", "arm",
}  # fmt: skip
"""Words of headings that are not the recorded motion itself; such a column is read only if a study names it."""


class Chosen(NamedTuple):
    """A column to read: its place in the file, its unit as written and in SI, and whether it is per kilogram."""

    place: int
    unit: str
    factor: float
    per_kg: bool


def role_words(role: str) -> str:
    """Return a role in words."""
    return role.replace("_", " ")


@functools.lru_cache(maxsize=4096)
def family_of(name: str, unit: str | None) -> str | None:
    """Return the family of quantities that a name speaks of, if any."""
    words = {word.lower() for word in _WORDS.findall(name)}
    if {"heel", "strike"} <= words or "heelstrike" in words:
        return "heel_strike"
    if words & _NOT_THE_MOTION:
        return None
    if "phase" in words or (words & _OF_A_CYCLE and unit is not None and unit_and_per_kg(unit)[0] == "%"):
        return "phase"
    return next((family for family, named in _NAMED.items() if words & named), None)


def role_by_name(name: str, family: str) -> str | None:
    """Return the role among those of a family that a name leaves no choice of; None if the unit decides."""
    words = {word.lower() for word in _WORDS.findall(name)}
    return next((role for role in FAMILIES[family] if words & _OF_A_ROLE.get(role, set())), None)


def apart(one: str, other: str) -> bool:
    """Whether two headings name different joints, or different sides, of a body."""
    pairs = zip(_body_of(one), _body_of(other), strict=True)
    return any(first and second and not first & second for first, second in pairs)


def _body_of(name: str) -> tuple[set[str], set[str]]:
    """Return the joint and the side that a name speaks of, each empty where it names none."""
    words = {word.lower() for word in _WORDS.findall(name)}
    return words & _JOINTS, {_SIDES[word] for word in words & set(_SIDES)}


def by_map(source: Source, columns: Mapping[str, str], usual: Mapping[str, str]) -> dict[str, Chosen]:
    """Choose the columns that a study names, and no others.

    Raises
    ------
    InputError
        If a column is not in the file or there twice, or its unit is missing, unknown or of another quantity.
    """
    found: dict[str, Chosen] = {}
    for role, entry in columns.items():
        place, unit = place_of(source, entry)
        twin = next((other for other, one in found.items() if one.place == place), None)
        if twin is not None:
            refuse(
                source, [place], f"cannot be both {role_words(twin)} and {role_words(role)}; see columns in the study"
            )
        found[role] = _measured(source, role, place, unit, usual)
    about, along = ([one for role, one in found.items() if role in kind] for kind in (ABOUT_A_JOINT, _ALONG_A_LINE))
    if about and along:
        refuse(source, [along[0].place, about[0].place], "are along a line and about a joint; name columns of one axis")
    return found


def _measured(source: Source, role: str, place: int, unit: str | None, usual: Mapping[str, str]) -> Chosen:
    """Return a column with the factor of its unit."""
    heading = source.headings[place]
    if role == "heel_strike":
        return Chosen(place, "", 1.0, False)
    stated = unit or heading.unit or source.usual_unit(role, heading)
    written = stated or _LOCOHUB.get(heading.text) or usual.get(folded(heading.text))
    if not written:
        per = "/kg" if role in SCALED and named_per_kg(heading.name) else ""
        example = f"{heading.name} [{_EXAMPLES.get(role, ROLES.get(role))}{per}]"
        refuse(
            source, [place],
            f"must state its unit, such as {shown(example)}, in the file or under columns in the study",
        )  # fmt: skip
    base, per_kg = unit_and_per_kg(written)
    if per_kg and role not in SCALED:
        base, per_kg = written, False
    if role in SCALED and named_per_kg(heading.name) and not per_kg:
        refuse(
            source, [place],
            f"is per kilogram by its name, but the unit {written!r} is not; state {shown(written + '/kg')}, or name the column "
            "without it",
        )  # fmt: skip
    try:
        return Chosen(place, written, units.parse(f"1 {base}", ROLES[role]), per_kg)
    except InputError as problem:
        if heading.below and not unit:
            fault(source, heading.below, place, str(problem))
        refuse(source, [place], str(problem))


def by_heading(source: Source, usual: Mapping[str, str], roles: Container[str]) -> dict[str, Chosen]:
    """Choose the columns whose headings name a quantity of a motion, with a unit that fits.

    Only columns of the given roles count. A heading that is just the name of a role comes before one that contains it. Where
    position or speed name an axis, the force is the one of that axis.

    Raises
    ------
    InputError
        If several columns could be the same quantity, or the only one has no unit or a wrong one.
    """
    found: dict[str, Chosen] = {}
    for family, of in FAMILIES.items():
        if not any(role in roles for role in of):
            continue
        fitting, fault = _candidates(source, family, usual)
        rotary = next(
            (role in ABOUT_A_JOINT for role in ("angle", "angular_speed", "position", "speed") if role in found), None
        )
        if family in ("speed", "force") and rotary is not None:
            fitting = _about(source, fitting, rotary, found)
        if len(fitting) > 1:
            _ask(source, fitting, found, _rest(source, family, usual, roles))
        elif fitting:
            role, chosen = fitting[0]
            found[role] = chosen
        elif fault is not None and _INSTEAD.get(family) not in {_family(role) for role in found}:
            raise fault
    _check_places(source, found)
    return found


def _rest(source: Source, family: str, usual: Mapping[str, str], roles: Container[str]) -> list[tuple[str, Chosen]]:
    """Return the columns that could be of the families after one, with their roles."""
    families = list(FAMILIES)
    later = [
        other for other in families[families.index(family) + 1 :] if any(role in roles for role in FAMILIES[other])
    ]
    return [one for other in later for one in _candidates(source, other, usual)[0]]


def _apart(source: Source, one: Chosen, other: Chosen) -> bool:
    """Whether the headings of two columns name different joints or sides."""
    return apart(source.headings[one.place].text, source.headings[other.place].text)


def _check_places(source: Source, found: Mapping[str, Chosen]) -> None:
    """Refuse columns of different joints or sides, unless a study names them."""
    moving = [one for role, one in found.items() if role in SIGNED]
    for other in moving[1:]:
        if _apart(source, moving[0], other):
            alone = {role: one for role, one in found.items() if not _apart(source, moving[0], one)}
            refuse(
                source, [moving[0].place, other.place],
                "are of different joints or sides; choose in the study what belongs together: "
                f"{_suggested(source, alone)} for the first alone, or {_suggested(source, found)} to read both",
            )  # fmt: skip


def _family(role: str) -> str:
    return next(family for family, roles in FAMILIES.items() if role in roles)


def _candidates(
    source: Source, family: str, usual: Mapping[str, str]
) -> tuple[list[tuple[str, Chosen]], InputError | None]:
    """Return the columns that could be of a family, with their roles; and what is wrong with one that nearly is."""
    exact: list[tuple[str, Chosen]] = []
    loose: list[tuple[str, Chosen]] = []
    faults: list[InputError] = []
    for place, heading in enumerate(source.headings):
        if family_of(heading.name, heading.unit) != family:
            continue
        named = name_of(heading) in ROLES
        role = _role(source, family, heading)
        try:
            (exact if named else loose).append((role, _measured(source, role, place, None, usual)))
        except InputError as problem:
            # A name that ends with the quantity says what the column is; "moment cell supply (V)" may be anything.
            if heading.unit is None or named_per_kg(heading.name) or _ends_with(heading.name, family):
                faults.append(problem)
    return exact or loose, next(iter(faults), None)


def _ends_with(name: str, family: str) -> bool:
    """Whether the last word of a name speaks of a family of quantities."""
    return family_of(name.split()[-1], None) == family


def _role(source: Source, family: str, heading: Heading) -> str:
    """Return the role of a column among those of its family: the one whose quantity its unit measures, else the first."""
    roles, named = FAMILIES[family], role_by_name(heading.name, family)
    if named is not None:
        return named
    written = heading.unit or next(filter(None, (source.usual_unit(role, heading) for role in roles)), None)
    if written is None or len(roles) == 1:
        return roles[0]
    return next((role for role in roles if units.measures(unit_and_per_kg(written)[0], ROLES[role])), roles[0])


def _about(
    source: Source, fitting: list[tuple[str, Chosen]], rotary: bool, found: Mapping[str, Chosen]
) -> list[tuple[str, Chosen]]:
    """Keep the columns of an axis; refuse a force where the motion is about a joint, and a moment where it is not."""
    kept = [one for one in fitting if (one[0] in ABOUT_A_JOINT) == rotary]
    if fitting and not kept and fitting[0][0] in SCALED:
        role, chosen = fitting[0]
        motion = next(one for other, one in found.items() if other not in ("time", "phase"))
        kind = "about a joint" if rotary else "along a line"
        suggestion = _suggested(source, {**found})
        refuse(
            source, [chosen.place],
            f"is a {role}, but {shown(source.headings[motion.place].text)} is {kind}; to read the motion alone, write in the "
            f"study: {suggestion}",
        )  # fmt: skip
    return kept


def _ask(
    source: Source,
    fitting: list[tuple[str, Chosen]],
    found: Mapping[str, Chosen],
    rest: Sequence[tuple[str, Chosen]],
) -> NoReturn:
    """Raise InputError about columns of which a study must choose one; the line it suggests loses none of the rest."""
    role, first = fitting[0]
    roles = " or the ".join(dict.fromkeys(role_words(one) for one, _ in fitting))
    line = {**found, role: first}
    for other, chosen in rest:
        families = {_family(one) for one in line}
        if _family(other) not in families and _INSTEAD.get(_family(other)) not in families:
            moving = {one: column for one, column in line.items() if one in SIGNED and other in SIGNED}
            axes = {one in ABOUT_A_JOINT for one in moving} | {other in ABOUT_A_JOINT}
            if not moving or (len(axes) == 1 and not any(_apart(source, one, chosen) for one in moving.values())):
                line[other] = chosen
    suggestion = _suggested(source, line)
    refuse(
        source, [chosen.place for _, chosen in fitting],
        f"could each be the {roles}; choose in the study with one line for all columns, such as {suggestion}",
    )  # fmt: skip


def _suggested(source: Source, found: Mapping[str, Chosen]) -> str:
    """Return the line of a study that names these columns."""
    entries = [
        f"{role} = {json.dumps(source.headings[one.place].text, ensure_ascii=False)}" for role, one in found.items()
    ]
    return f"columns = {{ {printable(', '.join(entries))} }}"
