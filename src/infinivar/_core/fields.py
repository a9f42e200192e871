"""Physical fields of dataclasses: unit, permitted range and meaning in one place.

They validate the dataclass, and generate the schema of the study file, its reference page and its error messages.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import numbers
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from infinivar._core.arrays import shown
from infinivar._core.bounds import FINITE, Bound, NonZero, fits, within, words
from infinivar.errors import ParameterError, nearest, require


def quantity(
    unit: str, bound: Bound, meaning: str, *, default: Any = dataclasses.MISSING, per: str = "", **options: Any
) -> Any:
    """Dataclass field for a physical quantity in SI.

    Parameters
    ----------
    unit : str      SI unit of the float, "1" for none.
    bound           Of `annotated_types`, such as ``Gt(0)``, or of `infinivar._core.bounds`.
    meaning : str   One-line description for schemas and reference pages.
    default         Default value; without one the field is required. None means "not given".
    per : str       What a study may name in the denominator although the unit here does not: "rev" of a lead in mm/rev.
    options         Of `dataclasses.field`.
    """
    metadata = {"unit": unit, "bound": bound, "meaning": meaning, **({"per": per} if per else {})}
    return dataclasses.field(default=default, metadata=metadata, **options)


def quantities(unit: str, bound: Bound, meaning: str, *, default: Any = dataclasses.MISSING, **options: Any) -> Any:
    """Dataclass field for a row of values of one unit, stored as a tuple of floats; arguments as in `quantity`."""
    return dataclasses.field(default=default, metadata={"row of": unit, "bound": bound, "meaning": meaning}, **options)


def named_texts(meaning: str, names: Sequence[str], *, default: Any = dataclasses.MISSING, **options: Any) -> Any:
    """Dataclass field for a table of texts, each under one of some names, stored as a frozen dictionary."""
    return dataclasses.field(default=default, metadata={"meaning": meaning, "texts of": tuple(names)}, **options)


def chosen_words(meaning: str, words: Sequence[str], *, default: Any = dataclasses.MISSING, **options: Any) -> Any:
    """Dataclass field for a row of words, each one of some words or, without these, any; stored as a tuple."""
    return dataclasses.field(default=default, metadata={"meaning": meaning, "words of": tuple(words)}, **options)


def several(
    meaning: str, kind: type, *, only: Sequence[str] = (), default: Any = dataclasses.MISSING, **options: Any
) -> Any:
    """Dataclass field for a row of values of a class whose own fields are quantities, stored as a tuple.

    `only` names those of its fields that a study may state; by default all.
    """
    return dataclasses.field(default=default, metadata={"meaning": meaning, "several": kind, "only": only}, **options)


def given(value: Any, otherwise: Any) -> Any:
    """The value, or `otherwise` if it is None. Unlike `or`, this keeps arrays and zero."""
    return otherwise if value is None else value


def component(meaning: str, **default: Any) -> Any:
    """Dataclass field for a part, a choice or a flag, with a one-line description."""
    return dataclasses.field(**default, metadata={"meaning": meaning})


def tagged(meaning: str, kinds: Mapping[str, type], *, flat: bool = False, key: str = "shape", **default: Any) -> Any:
    """Dataclass field for one of several kinds of value, each a class with its own fields.

    Parameters
    ----------
    meaning : str     One line for schemas and reference pages.
    kinds : mapping   Classes by the word with which a study asks for them in `key`; the first if it does not say.
    flat : bool       Whether the kind's keys stand in the table of the owner, or in a table of their own.
    key : str         Key of that word.
    default           As for `dataclasses.field`.
    """
    return dataclasses.field(**default, metadata={"meaning": meaning, "kinds": kinds, "flat": flat, "key": key})


def _condition(bound: Bound, value: float | None = None) -> str:
    """What a number must be, in words; for nan, which is not 0 either, in other words."""
    if value is None:
        return "a finite number" if bound == FINITE else f"a number {words(bound)}"
    return "finite and not 0" if isinstance(bound, NonZero) and not math.isfinite(value) else words(bound)


def check_value(field: str, value: Any, unit: str, bound: Bound) -> None:
    """Raise ParameterError with field, value and unit unless every element is finite and within the bound.

    Values that are neither numbers nor NumPy arrays (tracers of an array library) are not checked.
    """
    if type(value) is float and fits(bound, value):
        return
    shown = "" if unit == "1" else unit
    if isinstance(value, (bool, str, bytes, list, tuple, dict, set)) or value is None:
        require(False, field, repr(value), _condition(bound), f"in {shown}" if shown and bound == FINITE else shown)
    if isinstance(value, (int, float)):
        if not fits(bound, value):
            require(False, field, value, _condition(bound, value), shown)
    elif type(value).__module__ == "numpy":
        import numpy as np

        value = np.asarray(value)
        wrong = ~(np.isfinite(value) & within(bound, value))
        if wrong.any():
            require(False, field, value[wrong][:1], words(bound), shown)


def check_number(field: str, value: Any, unit: str, bound: Bound) -> None:
    """Raise ParameterError with field, value and unit unless a value is one real number, finite and within the bound."""
    real = isinstance(value, numbers.Real) or (getattr(value, "shape", None) == () and value.dtype.kind in "iuf")
    require(
        real and not isinstance(value, bool), field, shown(value), "one number", "" if unit == "1" else f"in {unit}"
    )
    check_value(field, value, unit, bound)


def check_instance(field: str, value: Any, kind: type) -> None:
    """Raise ParameterError unless a value is of a class."""
    if not isinstance(value, kind):
        raise ParameterError(f"{field} must be a {kind.__name__}, got {shown(value)}")


def check_single(instance: Any, prefix: str = "") -> None:
    """Raise ParameterError if a physical field of a dataclass, or of its parts, holds an array instead of one number."""
    for path in quantities_of(instance):
        value = value_at(instance, path)
        require(getattr(value, "shape", ()) == (), prefix + path, shown(value), "one number")


@functools.cache
def hints(part: type) -> Mapping[str, Any]:
    """Type hints of a dataclass by field; looking them up takes long."""
    return typing.get_type_hints(part)


@functools.cache
def _choices(part: type) -> Mapping[str, tuple[Any, ...]]:
    """Options of each choice field: the literals of its type hint, and None if the field is optional."""
    found: dict[str, tuple[Any, ...]] = {}
    for field in dataclasses.fields(part):
        hint = hints(part)[field.name]
        kinds = typing.get_args(hint) if typing.get_origin(hint) in (types.UnionType, typing.Union) else (hint,)
        words = [word for kind in kinds if typing.get_origin(kind) is Literal for word in typing.get_args(kind)]
        if words:
            found[field.name] = (*words, *([None] if type(None) in kinds else []))
    return found


_CHECKED = {"unit", "row of", "texts of", "words of", "several"}
"""Metadata of the fields whose values `check_field` checks."""


@functools.cache
def _checked(part: type) -> tuple[dataclasses.Field, ...]:
    """Fields whose values `check_field` checks."""
    return tuple(field for field in dataclasses.fields(part) if _CHECKED & field.metadata.keys())


@functools.cache
def described(part: type) -> tuple[dataclasses.Field, ...]:
    """Fields of a part that a table states directly: neither derived from others nor coming in kinds."""
    found = (field for field in dataclasses.fields(part) if field.init)
    return tuple(field for field in found if "meaning" in field.metadata and "kinds" not in field.metadata)


@functools.cache
def in_kinds(part: type) -> tuple[dataclasses.Field, ...]:
    """Fields of a part whose value comes in several kinds, selected by a key such as `shape`."""
    return tuple(field for field in dataclasses.fields(part) if "kinds" in field.metadata)


@functools.cache
def is_part(kind: Any) -> bool:
    """Whether it is a class of parts: a dataclass with fields made here."""
    return dataclasses.is_dataclass(kind) and any("meaning" in field.metadata for field in dataclasses.fields(kind))


@functools.cache
def part_of(hint: Any) -> type | None:
    """The class of parts in a type hint, whose values have a table of their own, if any."""
    return next((kind for kind in _options(hint) if is_part(kind)), None)


def _options(hint: Any) -> tuple[Any, ...]:
    return typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)


@functools.cache
def _parts(part: type) -> Mapping[str, tuple[tuple[type, ...], bool]]:
    """Fields of a part that hold parts: the classes they may have, and whether they may be None."""
    found: dict[str, tuple[tuple[type, ...], bool]] = {}
    for field in (*described(part), *in_kinds(part)):
        options = _options(hints(part)[field.name])
        kinds = tuple(one for one in options if is_part(one))
        if kinds and len(kinds) + (_NONE in options) == len(options):
            found[field.name] = kinds, _NONE in options
    return found


_NONE = type(None)


def _check_part(name: str, value: Any, kinds: tuple[type, ...]) -> None:
    """Raise ParameterError unless a value has what its owner uses of a part; the message names what is missing."""
    words = " or ".join(kind.__name__ for kind in kinds)
    uses = next((kind.USES for kind in kinds if hasattr(kind, "USES")), ())  # type: ignore[attr-defined]
    missing = missing_members(value, uses)
    if not uses or isinstance(value, type) or len(missing) == len(uses):
        from infinivar._core.arrays import shown

        raise ParameterError(f"{name} must be a {words}, got {shown(value)}")
    if missing:
        raise ParameterError(
            f"{name} must be a {words} or have {', '.join(uses)}, but a {type(value).__name__} has no {missing[0]}"
        )


def check(instance: Any) -> None:
    """Validate every physical field and every choice of a dataclass instance; for use in `__post_init__`."""
    for name, options in _choices(type(instance)).items():
        said = getattr(instance, name)
        if said not in options:
            named = [word for word in options if isinstance(word, str)]
            hint = nearest(said, named) if isinstance(said, str) else ""
            words = ", ".join(str(option) for option in options if option is not None)
            raise ParameterError(f"{name} must be one of {words}, got {said!r}{hint}")
    for name, (kinds, optional) in _parts(type(instance)).items():
        value = getattr(instance, name)
        if not isinstance(value, kinds) and not (optional and value is None):
            _check_part(name, value, kinds)
    for field in _checked(type(instance)):
        value = getattr(instance, field.name)
        if value is None and field.default is None:
            continue
        kept = check_field(field, value)
        if kept is not value:
            object.__setattr__(instance, field.name, kept)


def check_field(field: dataclasses.Field, value: Any) -> Any:
    """Return a value as its field stores it; raises ParameterError if it is not permitted."""
    if "unit" in field.metadata:
        check_value(field.name, value, field.metadata["unit"], field.metadata["bound"])
    elif "row of" in field.metadata:
        return _row(field, value)
    elif "texts of" in field.metadata:
        return _texts(field, value)
    elif "words of" in field.metadata:
        return _words(field, value)
    elif "several" in field.metadata:
        return _several(field, value)
    return value


def _several(field: dataclasses.Field, value: Any) -> tuple[Any, ...]:
    """The values of a row; raises ParameterError if it is empty or one is of another class."""
    kind = field.metadata["several"]
    if isinstance(value, (str, bytes, Mapping)) or not hasattr(value, "__iter__"):
        raise ParameterError(f"{field.name} must be a row of {kind.__name__}, got {shown(value)}")
    row = tuple(value)
    require(len(row) > 0, field.name, "none", f"one {kind.__name__} or more")
    for place, one in enumerate(row, 1):
        require(isinstance(one, kind), f"{field.name} {place}", shown(one), f"a {kind.__name__}")
    return row


def _texts(field: dataclasses.Field, value: Any) -> Mapping[str, str]:
    """The texts of a table; raises ParameterError if one has an unknown name or is no text."""
    from infinivar._core.frozen import FrozenDict

    names = field.metadata["texts of"]
    if not isinstance(value, Mapping) or not value:
        raise ParameterError(f"{field.name} must be a table of texts by {', '.join(names)}, got {value!r}")
    for name, text in value.items():
        if name not in names:
            raise ParameterError(
                f"{field.name} has an unknown entry {name!r}{nearest(str(name), names)}; known entries: {', '.join(names)}"
            )
        require(isinstance(text, str) and bool(text.strip()), f"{field.name}.{name}", repr(text), "text")
    return FrozenDict(value)


def _words(field: dataclasses.Field, value: Any) -> tuple[str, ...]:
    """The words of a row; raises ParameterError if one is unknown or stands there twice."""
    words = field.metadata["words of"]
    if isinstance(value, (str, bytes, Mapping)) or not hasattr(value, "__iter__"):
        raise ParameterError(f"{field.name} must be a row of words, got {value!r}")
    row = tuple(value)
    for place, word in enumerate(row):
        if word not in words if words else not (isinstance(word, str) and word.strip() and word.isprintable()):
            if not words:
                raise ParameterError(f"{field.name} must hold names, got {word!r}")
            hint = nearest(word, words) if isinstance(word, str) else ""
            raise ParameterError(f"{field.name} must hold words of {', '.join(words)}, got {word!r}{hint}")
        require(word not in row[:place], field.name, f"{word!r} twice", "different words")
    return row


check_fields = check
"""The public name of `check`, for parts, drives and motions of other packages."""


def _row(field: dataclasses.Field, value: Any) -> tuple[float, ...]:
    """The values of a row as floats; raises ParameterError if one is outside its range."""
    if isinstance(value, (str, bytes, Mapping)) or not hasattr(value, "__len__"):
        raise ParameterError(f"{field.name} must be a row of numbers, got {value!r}")
    row = tuple(_real(f"{field.name}[{place}]", one) for place, one in enumerate(value))
    for place, one in enumerate(row):
        check_value(f"{field.name}[{place}]", one, field.metadata["row of"], field.metadata["bound"])
    return row


def check_real(instance: Any) -> None:
    """As `check`, for a dataclass whose physical fields are single real numbers; those of NumPy are stored as float.

    Raises
    ------
    ParameterError
        If a physical field is an array, a complex number or no number at all, or for the reasons of `check`.
    """
    for field in dataclasses.fields(instance):
        if "unit" not in field.metadata:
            continue
        value = getattr(instance, field.name)
        if value is None and field.default is None:
            continue
        if type(value) not in (int, float):
            object.__setattr__(instance, field.name, _real(field.name, value))
    check(instance)


def _real(field: str, value: Any) -> float:
    """The value as a plain number."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if type(value).__module__ == "numpy":
        import numpy as np

        if np.ndim(value) == 0 and np.asarray(value).dtype.kind in "iuf":
            return float(value)
    from infinivar._core.arrays import shown

    raise ParameterError(f"{field} must be a real number, got {shown(value)}")


def check_kind(field: str, value: Any, kinds: Mapping[str, type], method: str) -> None:
    """Raise ParameterError unless a value has the method by which values of these kinds are used."""
    names = ", ".join(kind.__name__ for kind in kinds.values())
    usable = callable(getattr(value, method, None)) and not isinstance(value, type)
    if callable(getattr(getattr(value, field, None), method, None)):  # a task in place of its motion
        raise ParameterError(f"{field} must be one of {names}, got a {type(value).__name__}; write its .{field}")
    require(usable, field, repr(value), f"one of {names}")


def missing_members(thing: Any, needs: Sequence[str]) -> list[str]:
    """The names that a class or an instance lacks; fields of a dataclass count although its class may not have them."""
    kind = thing if isinstance(thing, type) else type(thing)
    fields = {field.name for field in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else set()
    return [name for name in needs if name not in fields and not hasattr(thing, name)]


def check_choice(
    instance: Any, choice: str, needs: Mapping[str, Sequence[str]], may: Mapping[str, Sequence[str]] | None = None
) -> None:
    """Raise ParameterError unless a part has exactly the fields that the value of its choice field requires or allows.

    Parameters
    ----------
    instance   The part.
    choice     Name of the choice field.
    needs      Required fields for each value of the choice field.
    may        Optional fields for each value of the choice field. Fields listed in neither are not checked.
    """
    said, may = getattr(instance, choice), may or {}
    require(said in needs, choice, repr(said), f"one of {', '.join(needs)}")
    for name in needs[said]:
        if getattr(instance, name) is None:
            fits = [
                one
                for one, names in needs.items()
                if names and all(getattr(instance, each) is not None for each in names)
            ]
            hint = "".join(f", or choose {choice} = {one!r}, which needs {' and '.join(needs[one])}" for one in fits)
            raise ParameterError(f"{name} is missing: {choice} = {said!r} needs it{hint}")
    special = {name for table in (needs, may) for names in table.values() for name in names}
    for name in sorted(special - {*needs[said], *may.get(said, ())}):
        if getattr(instance, name) is not None:
            raise ParameterError(f"{name} does not apply with {choice} = {said!r}; remove it")


def check_one_of(instance: Any, line: str, joint: str) -> None:
    """Raise ParameterError unless exactly one of two fields is given: one along a line, or one about a joint."""
    given = [name for name in (line, joint) if getattr(instance, name) is not None]
    if not given:
        raise ParameterError(f"{line} is missing: give {line}, or {joint} about a joint")
    if len(given) == 2:
        raise ParameterError(f"{line} and {joint} exclude each other: {line} is along a line, {joint} about a joint")


def brief(self: Any) -> str:
    """Class and main contents of a drive in one line, for `repr`: its parts by name, and single values that are no defaults."""
    said = []
    for field in dataclasses.fields(self):
        value = getattr(self, field.name)
        factory = field.default_factory
        usual = field.default if factory is dataclasses.MISSING else factory()
        if not field.repr or value is None or (type(value) is type(usual) and value == usual):
            continue
        if dataclasses.is_dataclass(value):
            name = getattr(value, "name", "")
            said.append(f"{field.name}={name!r}" if name else f"{field.name}={type(value).__name__}(...)")
        elif isinstance(value, float | int | str):
            unit = field.metadata.get("unit", "1")
            number = f"{value:.6g}" if isinstance(value, float) else repr(value)
            said.append(f"{field.name}={number}{'' if unit == '1' else f' {unit}'}")
    return f"{type(self).__name__}({', '.join(said)})"


class Place(NamedTuple):
    """A field with its value, somewhere in a drive, a motion or the like."""

    path: str
    """From the whole, with dots; of a field that comes in kinds, that of the key which selects the kind."""
    owner: Any
    """The part that has the field."""
    field: dataclasses.Field
    value: Any
    """Of a field that comes in kinds, the word that selects the kind."""


def walk(
    instance: Any, prefix: str = "", within: Callable[[Any, str], Sequence[Place]] | None = None
) -> Sequence[Place]:
    """Every field with a value of a dataclass and of the parts within it, in order of definition, kinds last.

    Parameters
    ----------
    instance            Anything but a dataclass has no fields.
    prefix : str        What the paths begin with.
    within : callable   Walks a part, whose paths begin with the second argument; by default as this function does.
    """
    found: list[Place] = []
    if not dataclasses.is_dataclass(instance):
        return found
    for field in (*described(type(instance)), *in_kinds(type(instance))):
        value = getattr(instance, field.name)
        if value is None:
            continue
        kind, metadata = type(value), field.metadata
        inside = prefix if metadata.get("flat") else f"{prefix}{field.name}."
        if key := metadata.get("key"):
            word = getattr(kind, "shape" if key == "shape" else "word", kind.__name__)
            found.append(Place(inside + key, instance, field, word))
        else:
            found.append(Place(prefix + field.name, instance, field, value))
        if is_part(kind):
            found += (within or walk)(value, inside)
    return found


def quantities_of(instance: Any) -> dict[str, dataclasses.Field]:
    """Physical fields with a value, of a dataclass and its parts, by dotted path in order of definition."""
    return {place.path: place.field for place in walk(instance) if "unit" in place.field.metadata}


def value_at(instance: Any, path: str) -> Any:
    """Value of the field at a dotted path."""
    for step in path.split("."):
        instance = getattr(instance, step)
    return instance


def with_values(instance: Any, values: Mapping[str, Any]) -> Any:
    """Copy of a dataclass with new values at dotted paths; its parts are rebuilt and validated.

    Raises
    ------
    ParameterError
        If a value is not permitted.
    """
    own = {path: value for path, value in values.items() if "." not in path}
    inner: dict[str, dict[str, Any]] = {}
    for path, value in values.items():
        head, _, rest = path.partition(".")
        if rest:
            inner.setdefault(head, {})[rest] = value
    own |= {name: with_values(getattr(instance, name), below) for name, below in inner.items()}
    return dataclasses.replace(instance, **own)
