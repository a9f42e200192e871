"""Layers of tables: a study over the shipped set it starts from, values over a catalogue part."""

from __future__ import annotations

import copy
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from infinivar._core.fields import hints, part_of
from infinivar.drivetrain.conventional import STAGES
from infinivar.errors import InputError, nearest
from infinivar.motion.duty_cycles import CYCLES
from infinivar.motion.scenario import FORCES, MOTIONS
from infinivar.parts import catalogue
from infinivar.parts.gearhead import foreign_fields
from infinivar.study import extensions
from infinivar.study.messages import StudyError, quoted
from infinivar.study.schema import CATALOGUES, HEAD, KINDS, ORIGIN, SHAPE, kind_keys, stocked
from infinivar.study.shipped import shared_set
from infinivar.transmission.rolling_contact import MEASURED

LONGEST_TITLE = 120

# Keys that control how a table is read; all other keys are fields of the part it describes. Inside a drive or the
# requirement only `part` is such a key: a bearing's type is an ordinary value.
_AT_HEAD, _INSIDE = (*HEAD, "part"), ("part",)

_ONE = {"drives": "drive", "scenarios": "scenario", "duty": "duty cycle", "tasks": "task", "paths": "path"}

Raw = dict[str, Any]
"""A table as written, or with kind and where spelled out at each value."""


def annotated(tree: Any, path: str, where: str, kind: str = "assumed", directives: tuple[str, ...] = _AT_HEAD) -> Raw:
    """Spell out kind and where at every value, so that tables from different sources can be merged."""
    kind, where = tree.get("kind", kind), tree.get("where", where)
    if kind not in KINDS:
        raise StudyError(f"{path}.kind = {quoted(kind)} must be one of {', '.join(KINDS)}{nearest(str(kind), KINDS)}")
    if not isinstance(where, str):
        raise StudyError(f"{path}.where = {quoted(where)} must be text that names the source")
    result: Raw = {}
    for key, value in tree.items():
        if key in ORIGIN:
            continue
        if key in directives:
            if not isinstance(value, str) or len(value) > LONGEST_TITLE:
                raise StudyError(f"{path}.{key} = {quoted(value)} must be text of at most {LONGEST_TITLE} characters")
            if not value.isprintable():
                raise StudyError(f"{path}.{key} = {quoted(value)} must be text without control characters")
            result[key] = value
        elif not isinstance(value, dict):
            result[key] = {"value": value, "kind": kind, "where": where}
        elif "value" in value:
            result[key] = {"kind": kind, "where": where, **value}
        else:
            result[key] = annotated(value, f"{path}.{key}", where, kind, _INSIDE)
    return result


def merged(under: Raw, over: Raw) -> Raw:
    """Override the values of `under` with those of `over`.

    A table that names a part replaces `under` entirely; what is stated in one way replaces what `under` states in another, and
    measured friction of a gearhead its efficiencies.
    """
    if "part" in over:
        return over
    result = loss_over(alternatives_over(under, over), over)
    for key, value in over.items():
        below = result.get(key)
        tables = isinstance(value, dict) and "value" not in value and isinstance(below, dict) and "value" not in below
        result[key] = merged(typing.cast(Raw, below), value) if tables else value
    return result


@dataclass(frozen=True, slots=True)
class Remarks:
    """Notes on a study collected while loading it."""

    reconstruction: dict[str, str] = field(default_factory=dict)
    """Statement of each parameter set used on what it reconstructs."""


def over_base(tree: Raw, path: str, remarks: Remarks, inside: bool = False) -> Raw:
    """Lay the table over the shipped one that its `base` names, if any; note what that set reconstructs.

    The type of a drive `inside` a machine follows from its key.
    """
    base = tree.pop("base", None)
    if base is None:
        return tree
    name, _, member = base.partition(".")
    try:
        shipped = shared_set(name)
        group, _, _ = path.partition(".")
        if group == "requirement":
            if member or "requirement" not in shipped:
                raise InputError(f"{base!r} must be the name of a parameter set, such as 'faulring2006'")
            under = shipped["requirement"]
        else:
            choices = [f"{name}.{known}" for known in shipped.get(group, {})]
            if base not in choices:
                raise InputError(
                    f"{base!r} is not a shipped {_ONE[group]}{nearest(base, choices)}; {name} has {', '.join(choices)}"
                )
            under = shipped[group][member]
    except InputError as problem:
        raise StudyError(f"{path}.base = {quoted(base)}: {problem}") from None
    if "reconstruction" in shipped and group not in ("scenarios", "duty"):
        remarks.reconstruction[name] = shipped["reconstruction"]
    under = annotated(copy.deepcopy(under), path, shipped["source"])
    if "type" in tree and tree["type"] != under.get("type", tree["type"]):
        if inside:
            of_type = [f"{name}.{one}" for one, drive in shipped[group].items() if drive["type"] == tree["type"]]
            raise StudyError(
                f"{path}.base = {quoted(base)} is a {under['type']} drive, but a {tree['type']} one is needed here; {name} has "
                f"{', '.join(of_type)}"
            )
        raise StudyError(
            f"{path}.type = {tree['type']!r} must be {under['type']!r} like base {base!r}; correct or remove it"
        )
    return layered(under, tree)


def legs_over_base(tree: Raw, path: str, remarks: Remarks) -> Raw:
    """Lay the drives within a machine, its leg or the drive of each joint, over the shipped ones that they name as base."""
    result = dict(tree)
    for key, word in INNER.items():
        inner = result.get(key)
        if not isinstance(inner, dict) or "value" in inner:
            continue
        inner, here = dict(inner), f"{path}.{key}"
        for name in HEAD:
            said = inner.pop(name, None)
            if name not in ("base", "type") or said is None:
                continue
            inner[name] = said["value"] if isinstance(said, dict) and "value" in said else said
            if not isinstance(inner[name], str):
                raise StudyError(f"{here}.{name} = {quoted(inner[name])} must be text")
        inner.setdefault("type", word)
        if inner["type"] != word:
            raise StudyError(f"{here}.type = {quoted(inner['type'])} must be {word!r}; correct or remove it")
        inner = over_base(inner, here, remarks, inside=True)
        result[key] = {name: value for name, value in inner.items() if name not in ("type", "title")}
    return result


INNER = {"leg": "cobotic", "separate": "conventional", "drive": "conventional"}
"""Drives within a machine by their key, of which it has one, and their types."""


_ALTERNATIVES = (
    tuple((key,) for key in INNER),
    tuple((key,) for key in STAGES),
    (("geometry",), MEASURED),
)
"""Ways to state one thing, each by its keys: drives within a machine, the output stage of a drive, the contact of a wheel."""


def alternatives_over(under: Raw, over: Raw) -> Raw:
    """Drop from a base what the study states in another way."""
    dropped: set[str] = set()
    for ways in _ALTERNATIVES:
        others = [way for way in ways if not over.keys() & set(way)]
        if len(others) < len(ways):
            dropped.update(*others)
    return {key: value for key, value in under.items() if key not in dropped}


def layered(under: Raw, over: Raw) -> Raw:
    """A table over another's, which may state a motion or force of another shape."""
    return merged(shape_over(under, over), over)


def shape_over(under: Raw, over: Any, key: str = "motion") -> Raw:
    """Drop from the base's motion or force what does not apply to another shape that the study states; so in tables within."""
    if not isinstance(over, dict):
        return under
    requested = over.get(SHAPE)
    shape = requested.get("value") if isinstance(requested, dict) else requested
    if isinstance(shape, str):
        groups = (FORCES,) if key == "force" else (CYCLES, MOTIONS)
        kinds = [kind for group in groups for kind in group.items()]
        own = {name for word, kind in kinds if word == shape for name in kind_keys({word: kind})}
        other = {name for word, kind in kinds for name in kind_keys({word: kind})} - own
        under = {name: value for name, value in under.items() if name not in other or name in over}
    tables = {name: value for name, value in under.items() if isinstance(value, dict) and "value" not in value}
    return {**under, **{name: shape_over(value, over.get(name), name) for name, value in tables.items()}}


def loss_over(under: Raw, over: Any) -> Raw:
    """Drop from the base's gearhead what the loss that the study states does not have."""
    said = over.get("loss_model")
    said = said.get("value") if isinstance(said, dict) else said
    dropped = foreign_fields(str(said), needed=True)
    return {key: value for key, value in under.items() if key not in dropped}


def _entry(kind: str, name: str, beside: Sequence[Path]) -> Mapping[str, Any]:
    """Values of a catalogue part; `SET:KEY` is one of another set than the shipped one."""
    if ":" not in name:
        return catalogue.entry(kind, name)
    from infinivar.parts.tables import stores

    return stores.entry(kind, name, beside)


def _applicable(entry: Mapping[str, Any], over: Raw) -> Mapping[str, Any]:
    """Values of a catalogue part without those that the loss model of a gearhead does not have."""
    model = {**entry, **over}.get("loss_model", "coulomb")
    model = model.get("value") if isinstance(model, Mapping) else model
    dropped = foreign_fields(str(model))
    return {key: value for key, value in entry.items() if key not in dropped}


def over_part(part: type, tree: Raw, path: str, beside: Sequence[Path] = ()) -> tuple[type, Raw]:
    """Lay a table over the values of the catalogue part that its key `part` names, if any.

    `beside` are the folders and files, other than the user's, in which sets of parts are looked up.

    Returns
    -------
    part, tree   The part of another package if the table has a variant, and the table without these two keys.

    Raises
    ------
    StudyError
        If there is no such part, or a part within is no table.
    """
    result = dict(tree)
    name = result.pop("part", None)
    stock = stocked(part)
    try:
        part = extensions.variant_of(part, result, path)
    except InputError as problem:
        raise StudyError(str(problem)) from None
    if name is not None:
        if stock is None:
            known = ", ".join(CATALOGUES.values())
            raise StudyError(f"{path}.part = {quoted(name)} must be removed: the catalogue has {known} only")
        try:
            entry = _entry(CATALOGUES[stock], name, beside)
        except InputError as problem:
            raise StudyError(f"{path}.part = {problem}") from None
        entry = _applicable(entry, result)
        result = merged(annotated(entry, path, "catalogue", directives=_INSIDE), result)
    result.pop(extensions.VARIANT, None)
    for key, value in result.items():
        inner = part_of(hints(part).get(key))
        if inner is not None and "value" in value:
            hint = ' with part = "..."' if stocked(inner) else ""
            raise StudyError(f"{path}.{key} = {quoted(value['value'])} must be a table [{path}.{key}]{hint}")
    return part, result
