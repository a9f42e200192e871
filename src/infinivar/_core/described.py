"""What fields and properties of a result state about themselves, and the dictionary and labelled arrays that follow.

A field of a result is `reported(unit, meaning)`, a property `@derived(unit)`, and a value of a part of the result
`at(path, unit)` in the class attribute ``_also``. All are in the dictionary, under the name with its unit: ``mean_loss`` in W
is ``mean_loss_W``. Those with dimensions are instead variables of the data set, or a coordinate if they have the name of their
only dimension.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from types import EllipsisType
from typing import Any

import numpy as np

from infinivar._core.netcdf import Arrays

Dims = tuple[str | EllipsisType, ...]
"""Names of the axes of a variable; ``(...,)`` where variables broadcast to one shape, with the axes of the result's labels."""

_OR = " or "
"""Between the unit, or words, along a line and about a joint."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """What one value of a result states about itself; see `reported`."""

    unit: str = ""
    meaning: str = ""
    dims: Dims | None = None
    key: str | None = None
    variable: str = ""
    attribute: str = ""
    convert: Callable[[Any], Any] | None = None
    optional: bool = False
    notes: Callable[[Any], Mapping[str, Any]] | None = None
    table: str | None = None
    path: str = ""


def reported(
    unit: str = "",
    meaning: str = "",
    dims: Dims | None = None,
    *,
    key: str | None = None,
    variable: str = "",
    attribute: str = "",
    convert: Callable[[Any], Any] | None = None,
    optional: bool = False,
    notes: Callable[[Any], Mapping[str, Any]] | None = None,
    table: str | None = None,
    default: Any = dataclasses.MISSING,
    **options: Any,
) -> Any:
    """Dataclass field that takes part in the dictionary, the data set and the table of its result.

    Parameters
    ----------
    unit : str       SI unit, "1" for a pure number, "" for what is no number; "N or N m" along a line or about a joint, by the
        `axis` of the result. A mapping without unit has it at the end of its names.
    meaning : str    One line; in a data set the long name of the variable. In a mapping, {} is the name.
    dims             Of the data set: names of the axes, () for a single number, (...,) for arrays that broadcast.
    key : str        In the dictionary, "" for none; by default the name with the unit, and none with `dims`, where "+" is the
        name with the unit. With "*", the value is a dictionary whose items stand beside the others.
    variable : str   In the data set; by default the name, with "+" the name with the unit. Of a mapping, {} is the name, as in
        "loss_{}". With "*", the value is a result whose data set is part of this one.
    attribute : str  Of the data set; of a mapping, every item.
    convert          Applied to the value first.
    optional : bool  Whether it is left out where it is None or empty.
    notes            Further attributes of the variable, from the result.
    table : str      Of a row of values that have dictionaries: these are the rows of the table, with this column as its index, ""
        for numbers.
    default, options Of `dataclasses.field`.
    """
    entry = Entry(
        unit=unit,
        meaning=meaning,
        dims=dims,
        key=key,
        variable=variable,
        attribute=attribute,
        convert=convert,
        optional=optional,
        notes=notes,
        table=table,
    )
    described = {"meaning": meaning.replace("{}", "each"), "unit": unit} if meaning else {}
    return dataclasses.field(default=default, metadata={"entry": entry, **described}, **options)


class _Derived(property):
    """Property that takes part as a field of `reported` does."""

    entry: Entry


def derived(unit: str = "", meaning: str = "", dims: Dims | None = None, **options: Any) -> type[property]:
    """Decorator of a property that takes part in the dictionary and the data set; arguments as in `reported`."""
    entry = Entry(unit=unit, meaning=meaning, dims=dims, **options)

    def make(function: Callable[[Any], Any]) -> property:
        made = _Derived(function)
        made.entry = entry
        return made

    return make  # type: ignore[return-value]  # so that checkers see a property


def at(path: str, unit: str = "", meaning: str = "", dims: Dims | None = None, **options: Any) -> Entry:
    """Entry of ``_also``: the value at a dotted path, whose name is the last step of it; arguments as in `reported`."""
    return Entry(unit=unit, meaning=meaning, dims=dims, path=path, **options)


@functools.cache
def entries(kind: type) -> tuple[tuple[str, Entry, Callable[[Any], Any]], ...]:
    """Name and entry of each value of a class, with what takes it from a result: paths first, then fields and properties."""
    found = {field.name: field.metadata["entry"] for field in dataclasses.fields(kind) if "entry" in field.metadata}
    for base in reversed(kind.__mro__):
        found |= {name: member.entry for name, member in vars(base).items() if isinstance(member, _Derived)}
    also = [(entry.path, entry) for entry in getattr(kind, "_also", ())]
    return tuple(
        (path.rpartition(".")[2].lstrip("_"), entry, operator.attrgetter(path))
        for path, entry in (*also, *found.items())
    )


def suffix(unit: str) -> str:
    """The end of a name that states a unit: "_rad_s" of "rad/s" and "rad s-1", "_Nm" of "N m"; "" of "1" and of none."""
    if unit in ("", "1"):
        return ""
    return "_" + re.sub(r"\s*/\s*| (?=[A-Za-z]+-\d)", "_", unit).replace("-1", "").translate(
        str.maketrans("", "", " ^-")
    )


_UNITS = ("m/s", "rad/s", "rad", "N m", "m", "N", "A", "V", "W")
_ENDINGS = {suffix(unit): unit for unit in _UNITS}


def unit_of(name: str) -> str:
    """Unit at the end of a column name; "1" for a pure number."""
    return next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), "1")


def finite(value: Any) -> Any:
    """A value as `plain`, with None in place of numbers that are not finite."""
    made = plain(value)
    if isinstance(made, dict):
        return {name: finite(item) for name, item in made.items()}
    if isinstance(made, list):
        return [finite(item) for item in made]
    return made if made is None or math.isfinite(made) else None


def named(value: Any) -> str | None:
    """The name of a study, a drive or a result of one; None of None."""
    return None if value is None else value.name


def rows(*names: str) -> Callable[[Mapping[Any, Any]], list[dict[str, Any]]]:
    """What turns a mapping into rows of these columns: the parts of a key, and the value, alone or a row of values."""

    def made(values: Mapping[Any, Any]) -> list[dict[str, Any]]:
        keys = [key if isinstance(key, tuple) else (key,) for key in values]
        return [dict(zip(names, (*key, value), strict=True)) for key, value in zip(keys, values.values(), strict=True)]

    return made


def plain(value: Any) -> Any:
    """A value as JSON has it, but for numbers that are not finite: results as their dictionaries, arrays as nested lists."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Enum):
        return value.name
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if isinstance(value, Mapping):
        return {_name(key): plain(item) for key, item in value.items()}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if dataclasses.is_dataclass(value):
        return dictionary(value)
    return [plain(item) for item in value] if isinstance(value, tuple | list | frozenset) else value


def _name(key: Any) -> str:
    """A key as a text: "THERMAL (motor)" of a limit and a part."""
    if isinstance(key, tuple):
        first, *rest = map(_name, key)
        return f"{first} ({', '.join(rest)})"
    return key.name if isinstance(key, Enum) else str(key)


def dictionary(found: Any) -> dict[str, Any]:
    """The entries of a result as plain values, by key; all fields of a dataclass that states none."""
    stated = entries(type(found))
    if not stated:
        return {field.name: plain(getattr(found, field.name)) for field in dataclasses.fields(found)}
    made: dict[str, Any] = {}
    for name, entry, get in stated:
        if entry.key == "" or (entry.key is None and entry.dims is not None):
            continue
        value = get(found)
        if entry.optional and (value is None or value == () or value == {}):
            continue
        content = plain(value if entry.convert is None else entry.convert(value))
        if entry.key == "*":
            made |= content
        else:
            made[name + suffix(entry.unit) if entry.key in (None, "+") else entry.key] = content
    # Verdicts and single numbers first, what is long last.
    return {key: made[key] for key in sorted(made, key=lambda key: isinstance(made[key], dict | list))}


def table(found: Any) -> tuple[list[dict[str, Any]], str] | None:
    """Rows of the table that an entry states, and the name of its index; None if none does."""
    for _, entry, get in entries(type(found)):
        if entry.table is not None:
            return [plain(row) for row in get(found)], entry.table
    return None


def is_labelled(kind: type) -> bool:
    """Whether results of a class state dimensions, and hence are labelled arrays."""
    return any(entry.dims is not None for _, entry, _ in entries(kind))


def arrays(found: Any) -> Arrays:
    """The entries of a result with dimensions as labelled arrays, and those with an attribute."""
    data: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    attributes: dict[str, Any] = {}
    for name, entry, get in entries(type(found)):
        value = get(found)
        if entry.attribute:
            attributes |= value if isinstance(value, Mapping) else {entry.attribute: value}
        if entry.dims is None or value is None:
            continue
        if entry.variable == "*":
            inner = arrays(value)
            data |= inner.data
            coordinates |= inner.coordinates
            attributes |= inner.attributes
            continue
        notes = {} if entry.notes is None else entry.notes(found)
        for variable, part, attrs in _variables(found, name, entry, value):
            is_time = isinstance(value, Mapping) and variable == "time_s"
            label = "time" if is_time else variable
            target = coordinates if entry.dims == (label,) else data
            attrs = {"units": "s"} if is_time else attrs
            target[label] = part if isinstance(part, list) else (entry.dims, part, {**attrs, **notes})
    return _with_labels(Arrays(data, coordinates, attributes), getattr(found, "labels", None))


def _variables(found: Any, name: str, entry: Entry, value: Any) -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """Name, values and attributes of a variable, or of each item of a mapping."""
    convert = np.asarray if entry.convert is None else entry.convert
    unit, meaning = entry.unit, entry.meaning
    if _OR in unit:
        unit, meaning = (text.split(_OR)[found.axis.rotary] if _OR in text else text for text in (unit, meaning))
    if not isinstance(value, Mapping):
        yield (
            name + suffix(unit) if entry.variable == "+" else entry.variable or name,
            convert(value),
            _attributes(unit, meaning),
        )
        return
    for key, item in value.items():
        word, words = _words(key)
        variable = (entry.variable or "{}").format(word)
        yield variable, convert(item), _attributes(unit or unit_of(variable), meaning.format(words))


def _attributes(unit: str, meaning: str) -> dict[str, Any]:
    return {name: text for name, text in (("units", unit), ("long_name", meaning)) if text}


def _words(key: Any) -> tuple[str, str]:
    """A key as part of a name and in words: "thermal_motor", "motor continuous torque of motor"."""
    parts = key if isinstance(key, tuple) else (key,)
    name = "_".join(part.name.lower() if isinstance(part, Enum) else part.replace(" ", "_") for part in parts)
    return name, " of ".join(getattr(part, "words", part) for part in parts)


def _with_labels(made: Arrays, labels: Any) -> Arrays:
    """Arrays with the dimensions of the labels of inputs, and their coordinates in place of those of the same axis."""
    axes: tuple[str, ...] = tuple(made.coordinates)
    loose = [name for name, (dims, *_) in made.data.items() if dims[0:1] == (...,)]
    if loose:
        values = np.broadcast_arrays(*(made.data[name][1] for name in loose))
        (_, *last), count = made.data[loose[0]][0], values[0].ndim
        axes = tuple(f"axis_{place}" for place in range(count - len(last))) + tuple(last[:count])
        placed = {name: (axes, part, made.data[name][2]) for name, part in zip(loose, values, strict=True)}
        made = made._replace(data={**made.data, **placed})
    if labels is None:
        return made
    new = dict(zip(axes, labels.dims, strict=False))  # further coordinates are of the result alone
    data = {name: _renamed(variable, new) for name, variable in made.data.items()}
    usual = {name: _renamed(variable, new) for name, variable in made.coordinates.items()}
    own = {name: variable for name, variable in labels.coords.items() if name not in data}
    return made._replace(data=data, coordinates={**_others(usual, own), **own})


def _renamed(variable: Any, new: Mapping[str, str]) -> Any:
    return variable if isinstance(variable, list) else (tuple(new.get(dim, dim) for dim in variable[0]), *variable[1:])


def _others(usual: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Coordinates of axes that have no coordinate of their own name: these are not repeated under the default name."""
    return {
        name: axis
        for name, axis in usual.items()
        if not any(tuple(dims) == axis[0] and np.array_equal(values, axis[1]) for dims, values, _ in own.values())
    }
