"""Tables of study files, derived from the dataclasses of parts and drives.

A field's unit, range and meaning are written once, in the dataclass (`infinivar._core.fields`); table keys, parsers, JSON
Schema (`infinivar.study.json_schema`) and error messages derive from them.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import re
import typing
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from annotated_types import Gt

from infinivar import units
from infinivar._core import plugins
from infinivar._core.bounds import Bound, fits, permitted, words
from infinivar._core.fields import check_field, check_value, described, hints, in_kinds, part_of, quantity
from infinivar._core.imported import Imported
from infinivar.contact import creep
from infinivar.errors import InputError, ParameterError, nearest, printable
from infinivar.machines.registry import DRIVES as MACHINES
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.parts import catalogue
from infinivar.parts.motor import Motor
from infinivar.study import extensions
from infinivar.study.requirement import JointRequirement, Requirement

KINDS = ("stated", "catalogue", "derived", "fitted", "assumed")
"""Origin of a number: stated in a paper, taken from a data sheet, derived from others, fitted to data, or assumed."""

DRIVES = Imported(
    {
        "cobotic": "infinivar.drivetrain.cobotic:CoboticDrive",
        "conventional": "infinivar.drivetrain.conventional:ConventionalDrive",
        **MACHINES,
    }
)
"""Drive types by their name in a study file."""

CHOICES: dict[str, Mapping[str, Any]] = {"creep_law": creep.LAWS}
"""Values that a field accepts, by their name in a study file."""

CATALOGUES: Mapping[type, str] = {part: name for name, part in catalogue.PARTS.items()}
"""Catalogue of each kind of part."""


def stocked(part: type) -> type | None:
    """The kind of part of the catalogue that a class is or extends, as a stage extends its belt; None if there is none."""
    return next((one for one in part.__mro__ if one in CATALOGUES), None)


HEAD = ("base", "like", "title", "type")
"""Keys of a drive's table that control how it is read."""

SPREAD = {
    "tolerance": "Half-width of a uniform distribution about the value; a percentage refers to the value",
    "deviation": "Standard deviation of a normal distribution about the value; a percentage refers to the value",
    "low": "Lower end of a uniform distribution",
    "high": "Upper end of a uniform distribution",
}
"""Keys of a table that states a spread."""

SHAPE = "shape"
"""Key that selects the kind of a motion or force."""

ORIGIN = ("kind", "where")
"""Keys of any table that state the origin of its values."""


SCALE: Any = quantity(
    "1",
    Gt(0),
    "Number of identical motors on one shaft (may be fractional); scales torque, currents, inertia, mass and length",
    default=None,
)
"""Key of a motor that is no field of its own."""
SCALE.name = "scale"

_FEW = 3
"""Most tables suggested for a key that stands in none of them."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One value of a study file: in SI, as written, and its origin."""

    value: Any
    written: Any
    kind: str | None = None
    where: str | None = None


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a table: either a value, with its parser and JSON Schema, or the table of a part."""

    read: Callable[[Any], Entry] | None = None
    schema: dict[str, Any] | None = None
    part: type | None = None
    required: bool = False
    meaning: str = ""
    several: type | None = None
    """Class of the tables of a list."""


def _entry(raw: Any, read: Callable[[Any, str | None], Any]) -> Entry:
    """Parse a bare value or a table with value, unit, kind and where; `read` converts the raw value."""
    if not isinstance(raw, dict):
        return Entry(_read(read, raw, None), _written(raw, None))
    if "value" not in raw:
        raise ValueError("must be a value, or a table with value, unit, kind and where")
    for key in raw:
        if key not in ("value", "unit", "kind", "where"):
            raise ValueError(f"has an unknown key {key!r}{nearest(key, ['value', 'unit', 'kind', 'where'])}")
    kind, where, unit = raw.get("kind"), raw.get("where"), raw.get("unit")
    if kind is not None and kind not in KINDS:
        raise ValueError(f"must have one of {', '.join(KINDS)} as kind, got {kind!r}")
    if where is not None and not isinstance(where, str):
        raise ValueError(f"must have text as where, naming the source, got {where!r}")
    return Entry(_read(read, raw["value"], unit), _written(raw["value"], unit), kind, where)


def _written(raw: Any, unit: str | None) -> Any:
    """A value as written, with its unit; a row as one text."""
    if isinstance(raw, list) and raw and all(isinstance(one, dict) and "value" not in one for one in raw):
        return "; ".join(", ".join(f"{key} = {_written(one, None)}" for key, one in row.items()) for row in raw)
    if isinstance(raw, list):
        return ", ".join(str(_written(one, unit)) for one in raw)
    if isinstance(raw, dict) and "value" in raw:
        return _written(raw["value"], raw.get("unit", unit))
    return raw if unit is None else f"{raw} {unit}"


def _read(read: Callable[[Any, str | None], Any], raw: Any, unit: str | None) -> Any:
    try:
        return read(raw, unit)
    except InputError as problem:
        raise ValueError(str(problem)) from problem


def value_schema(schema: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON Schema of a key whose value has a schema: a bare value, or a table with its provenance."""
    table = {
        "type": "object",
        "required": ["value"],
        "additionalProperties": False,
        "properties": {
            "value": {"anyOf": [schema, {"type": "number"}]} if schema.get("type") == "string" else schema,
            "unit": {"type": "string"},
            "kind": {"enum": list(KINDS)},
            "where": {"type": "string"},
        },
    }
    return {"anyOf": [schema, table]}


def _leaf(read: Callable[[Any, str | None], Any], schema: dict[str, Any]) -> Key:
    """Return the key of one value."""
    return Key(lambda raw: _entry(raw, read), value_schema(schema))


@functools.cache
def example(unit: str, bound: Bound) -> str:
    """Return a valid example value of a field."""
    usual = units.EXAMPLES.get(unit, f"1 {unit}")
    if fits(bound, units.parse(usual, unit)):
        return usual
    low, high = permitted(bound, 1.0)
    return units.show(0.1 * high if high < math.inf else 2.0 * low, unit)


def _quantity(unit: str, bound: Bound, per: str = "") -> Key:
    well = example(unit, bound)
    behind = re.compile(rf"\s*/\s*{per}\s*$")

    def read(raw: Any, written_unit: str | None) -> float:
        if written_unit is not None:
            if isinstance(raw, bool) or not isinstance(raw, (int, float)):
                raise InputError("must have a plain number as value when unit is given")
            raw = f"{raw!r} {written_unit}"
        value = units.parse(behind.sub("", raw) if per and isinstance(raw, str) else raw, unit, well)
        try:
            check_value("", value, unit, bound)
        except ParameterError as problem:
            required = f"{words(bound)} {unit}" if unit != "1" else words(bound)
            raise InputError(f"must be {required}, such as {well}") from problem
        return value

    if unit == "1":
        return _leaf(read, {"anyOf": [{"type": "number"}, {"type": "string"}], "examples": [well]})
    return _leaf(read, {"type": "string", "pattern": r"^\s*[+-]?[\d.]", "examples": [well]})


def _row(unit: str, bound: Bound) -> Key:
    """Return the key of a row of values: a list of quantities, or a list of numbers with one unit."""
    one = _quantity(unit, bound)
    assert one.read is not None
    read_one = one.read

    def read(raw: Any, written_unit: str | None) -> tuple[float, ...]:
        if not isinstance(raw, list) or not raw:
            raise InputError(f"must be a list of values, such as [{example(unit, bound)!r}, ...]")
        made = []
        for place, value in enumerate(raw, 1):
            try:
                entry = value if written_unit is None else {"value": value, "unit": written_unit}
                made.append(read_one(entry).value)
            except ValueError as problem:
                raise InputError(f"entry {place} {problem}") from problem
        return tuple(made)

    return _leaf(read, {"type": "array", "items": {"type": ["string", "number"]}, "minItems": 1})


def _choice(
    options: tuple[Any, ...],
    values: Mapping[str, Any] | None = None,
    more: Callable[[str, Collection[str]], Any] | None = None,
    others: Callable[[], Collection[str]] = tuple,
) -> Key:
    """Return the key of a choice between words.

    `values` maps the words to what they stand for, if given; `more` finds what installed packages add to them, under the
    words `others`.
    """

    def read(raw: Any, unit: str | None) -> Any:
        known = options
        if more is not None and unit is None and isinstance(raw, str) and raw not in options:
            own = more(raw, options)
            if own is not None:
                return own
            known = (*known, *others())
        if unit is not None or raw not in options or isinstance(raw, bool):
            hint = nearest(raw, [word for word in known if isinstance(word, str)]) if isinstance(raw, str) else ""
            raise InputError(f"must be one of {', '.join(map(str, known))}{hint}")
        return raw if values is None else values[raw]

    return _leaf(read, {"enum": list(options)})


def _flag() -> Key:
    def read(raw: Any, unit: str | None) -> bool:
        if unit is not None or not isinstance(raw, bool):
            raise InputError("must be true or false")
        return raw

    return _leaf(read, {"type": "boolean"})


def _whole() -> Key:
    def read(raw: Any, unit: str | None) -> int:
        if unit is not None or not isinstance(raw, int) or isinstance(raw, bool):
            raise InputError("must be a whole number")
        return raw

    return _leaf(read, {"type": "integer"})


def _checked(field: dataclasses.Field[Any], value: Any) -> Any:
    """Check a value as the dataclass of its field does; the message does not repeat the name of the field."""
    try:
        return check_field(field, value)
    except ParameterError as problem:
        raise InputError(str(problem).removeprefix(field.name).lstrip()) from problem


def _texts(field: dataclasses.Field[Any]) -> Key:
    """Return the key of a table of texts, each under one of some names."""
    names, one = field.metadata["texts of"], _text()
    assert one.read is not None
    read_one = one.read

    def read(raw: Any) -> Entry:
        if not isinstance(raw, dict) or "value" in raw:
            raise ValueError(
                f'must be a table of texts, such as {{ {names[0]} = "..." }}; known entries: {", ".join(names)}'
            )
        texts = {}
        for name, entry in raw.items():
            try:
                if isinstance(entry, dict) and "value" not in entry:
                    raise ValueError("must be text")
                texts[name] = read_one(entry).value
            except ValueError as problem:
                raise ValueError(f"entry {printable(name)} {problem}") from problem
        try:
            return Entry(_checked(field, texts), texts)
        except InputError as problem:
            raise ValueError(str(problem)) from problem

    entries = dict.fromkeys(names, one.schema)
    return Key(read, {"type": "object", "properties": entries, "additionalProperties": False, "minProperties": 1})


def _words(field: dataclasses.Field[Any]) -> Key:
    """Return the key of a row of words."""
    words = field.metadata["words of"]

    def read(raw: Any, unit: str | None) -> tuple[str, ...]:
        if unit is not None or not isinstance(raw, list):
            raise InputError(f"must be a list of words, such as [{(words or ('name',))[0]!r}]")
        return _checked(field, raw)

    one = {"enum": list(words)} if words else {"type": "string"}
    return _leaf(read, {"type": "array", "items": one, "uniqueItems": True})


def _several(field: dataclasses.Field[Any]) -> Key:
    """Return the key of a list of tables of quantities, such as points."""
    kind = field.metadata["several"]
    only = field.metadata.get("only", ())
    known = {name: key for name, key in table_keys(kind).items() if not only or name in only}

    def read(raw: Any, unit: str | None) -> tuple[Any, ...]:
        first = next(iter(known))
        if unit is not None or not isinstance(raw, list) or not raw or not all(isinstance(one, dict) for one in raw):
            raise InputError(f"must be a list of tables, such as [{{ {first} = ... }}, ...]; keys: {', '.join(known)}")
        return _checked(field, [_table_of(kind, known, one, place) for place, one in enumerate(raw, 1)])

    inner = {name: key.schema or {} for name, key in known.items()}
    table = {"type": "object", "properties": inner, "additionalProperties": False}
    leaf = _leaf(read, {"type": "array", "items": table, "minItems": 1})

    def read_list(raw: Any) -> Entry:
        return _entry([] if isinstance(raw, dict) and "value" not in raw else raw, read)

    return replace(leaf, read=read_list, several=kind)


def _table_of(kind: type, known: Mapping[str, Key], raw: Mapping[str, Any], place: int) -> Any:
    values = {}
    for name, one in raw.items():
        if name not in known:
            hint = f"{nearest(name, known)}; known keys: {', '.join(known)}"
            raise InputError(f"entry {place} has an unknown key {printable(name)!r}{hint}")
        try:
            values[name] = known[name].read(one).value  # type: ignore[misc]
        except ValueError as problem:
            raise InputError(f"entry {place}, {name} = {printable(one)} {problem}") from problem
    try:
        return kind(**values)
    except ParameterError as problem:
        raise InputError(f"entry {place}: {problem}") from problem


def _text() -> Key:
    def read(raw: Any, unit: str | None) -> str:
        if unit is not None or not isinstance(raw, str) or not raw.strip():
            raise InputError("must be text")
        if not raw.isprintable():
            raise InputError("must be text without control characters")
        return raw

    return _leaf(read, {"type": "string"})


def _key(hint: Any, field: dataclasses.Field[Any]) -> Key:
    """Return the table key of a dataclass field."""
    if "unit" in field.metadata:
        return _quantity(field.metadata["unit"], field.metadata["bound"], field.metadata.get("per", ""))
    if "row of" in field.metadata:
        return _row(field.metadata["row of"], field.metadata["bound"])
    if "texts of" in field.metadata:
        return _texts(field)
    if "words of" in field.metadata:
        return _words(field)
    if "several" in field.metadata:
        return _several(field)
    part = part_of(hint)
    if part is not None:
        return Key(part=part)
    literals = [kind for kind in (hint, *typing.get_args(hint)) if typing.get_origin(kind) is Literal]
    if literals:
        return _choice(typing.get_args(literals[0]))
    if hint is bool:
        return _flag()
    if hint is int:
        return _whole()
    if field.name in CHOICES:
        words = functools.partial(plugins.registered, "infinivar.creep_laws")
        return _choice(tuple(CHOICES[field.name]), CHOICES[field.name], extensions.creep_law, words)
    return _text()


def kind_keys(kinds: Mapping[str, type], key: str = SHAPE) -> list[str]:
    """Return `shape`, or another key that selects the kind, and every key of some kinds of a value."""
    inside = (name for kind in kinds.values() for name in (*table_keys(kind), *(one.name for one in in_kinds(kind))))
    return [key, *dict.fromkeys(inside)]


def kinds_for(field: dataclasses.Field[Any], word: Any) -> Mapping[str, type]:
    """Return the kinds of a field by shape, with that of an installed package if `word` asks for it.

    Raises
    ------
    InputError
        If the package's kind cannot be used.
    """
    known = field.metadata["kinds"]
    if not isinstance(word, str) or word in known:
        return known
    own = extensions.kind(field.name, word, known)
    if own is not None and not extensions.usable(field, own):
        raise InputError(f"{word!r} is a {own.__name__}, which does not repeat: it has no period, derivatives or push")
    return known if own is None else {**known, word: own}


def drive_type(word: Any) -> type | None:
    """Return the type of drive for a word; None if there is none."""
    if not isinstance(word, str) or word in DRIVES:
        return DRIVES.get(word)
    return extensions.drive_type(word, DRIVES)


@functools.cache
def shape_key(words: tuple[str, ...], group: str = "") -> Key:
    """Return the key that selects the kind; a misspelt word may be meant for one of a group of entry points."""
    others = functools.partial(plugins.registered, group) if group else tuple
    return replace(
        _choice(words, more=lambda word, known: None, others=others), meaning="Kind; determines which other keys apply"
    )


def keys(part: type) -> list[str]:
    """Return every key that the table of a part may have."""
    kinds = [
        key
        for field in in_kinds(part)
        for key in (
            kind_keys(field.metadata["kinds"], field.metadata["key"]) if field.metadata["flat"] else [field.name]
        )
    ]
    known = [*table_keys(part), *kinds, *(["part"] if stocked(part) else []), *ORIGIN]
    if DRIVES.word_of(part) is not None:
        return [*known, *HEAD]
    return [*known, "base"] if part in (Requirement, JointRequirement, Scenario, DutyCycle) else known


@functools.cache
def table_keys(part: type) -> dict[str, Key]:
    """Return the keys of the table of a part, a drive or the requirement."""
    found: dict[str, Key] = {}
    for one in described(part):
        required = one.default is dataclasses.MISSING and one.default_factory is dataclasses.MISSING
        key = _key(hints(part)[one.name], one)
        found[one.name] = replace(key, required=required, meaning=one.metadata["meaning"])
    if issubclass(part, Motor):
        found[SCALE.name] = replace(_key(float, SCALE), meaning=SCALE.metadata["meaning"])
    return found


def suggestion(name: str, parts: Collection[type]) -> str:
    """Hint for an unknown key in the table of one of several parts: the tables within that have it, or the key most like it."""
    within = dict.fromkeys(
        f"{outer}.{name}"
        for part in parts
        for outer, key in table_keys(part).items()
        if key.part is not None and name in table_keys(key.part)
    )
    if 0 < len(within) <= _FEW:
        return f" (did you mean {' or '.join(map(repr, within))}?)"
    return nearest(name, dict.fromkeys(key for part in parts for key in keys(part)))
