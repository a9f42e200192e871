"""Values of fields as JSON and arrays, and back: one mechanism for every result, whatever its class.

A value is taken apart by its fields into a flat list of objects, each stored once however often it is referred to. What is
restored has the same fields; only what no file can hold, such as the spline of a motion, is computed again from the others.
A file of unknown origin can name classes and functions of trusted packages, but not run any other code.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import json
import math
import sys
from collections.abc import Collection, Iterable, Mapping
from enum import Enum
from pathlib import Path, PurePath
from types import FunctionType, MethodType
from typing import Any

import numpy as np

from infinivar._core import plugins
from infinivar._core.frozen import FrozenDict, frozen
from infinivar.errors import InputError, printable

FORMAT = 1
_PROGRAM = __name__.partition(".")[0]
_TREE, _FORMAT, _VERSION = "tree", "format", "version"
_PLAIN = (type(None), bool, int, float, str)
"""Types that JSON keeps; their subclasses are stored in other ways."""

_ROWS = {kind.__name__: kind for kind in (tuple, list, set, frozenset)}


def to_arrays(value: Any, what: str) -> dict[str, np.ndarray]:
    """Take a value apart into arrays, one of which is the text that says how they belong together.

    Parameters
    ----------
    value     Built of dataclasses, named tuples, mappings, tuples, lists, sets, arrays, numbers, texts, members of enumerations,
              paths, and functions and classes that a module names.
    what      Name of the value in messages.

    Raises
    ------
    InputError
        If something in it cannot be stored; the message names its place.
    """
    from infinivar import __version__

    packing = _Packing()
    root = packing.node(value, what)
    tree = json.dumps({"objects": packing.objects, "root": root}, separators=(",", ":"))
    return {
        _FORMAT: np.array(FORMAT),
        _VERSION: np.array(__version__),
        _TREE: np.frombuffer(tree.encode(), np.uint8),
        **{str(place): np.concatenate(parts) for place, parts in enumerate(packing.parts.values())},
    }


def from_arrays(arrays: Mapping[str, np.ndarray], packages: Collection[str] = ()) -> Any:
    """Put a value together from the arrays of `to_arrays`.

    Parameters
    ----------
    arrays : mapping
    packages : collection   Other packages whose classes and functions the value may hold, besides this one and those of
        installed extensions.

    Raises
    ------
    InputError
        If the arrays are no such value, are of another version, or name a class of a package that is not trusted.
    """
    if not {_TREE, _FORMAT, _VERSION} <= arrays.keys():
        raise InputError("is no saved result, but a NumPy archive of something else")
    version = str(arrays[_VERSION])[:40]
    if int(arrays[_FORMAT]) != FORMAT:
        raise InputError(f"was saved by version {printable(version)}, in another format; compute and save it again")
    trusted = {_PROGRAM, "__main__", *plugins.packages(), *packages}
    try:
        tree = json.loads(arrays[_TREE].tobytes())
        return _Unpacking(arrays, trusted, version).value(tree["objects"], tree["root"])
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError) as problem:
        if isinstance(problem, InputError):
            raise
        raise InputError(f"is no saved result, or a damaged one: {type(problem).__name__}: {problem}") from problem


class _Packing:
    """Objects of a value that is taken apart, and the numbers of all arrays of one type end to end."""

    def __init__(self) -> None:
        self.objects: list[list[Any]] = []
        self.parts: dict[np.dtype, list[np.ndarray]] = {}
        self._sizes: dict[np.dtype, int] = {}
        self._places: dict[int, int] = {}
        self._kept: list[Any] = []
        """What was stored, so that no other object gets its address."""

    def node(self, value: Any, where: str) -> Any:
        """A plain value, or the place of an object as a list of one number."""
        if type(value) in _PLAIN:
            return value
        if id(value) not in self._places:
            said = self._said(value, where)
            self._places[id(value)] = len(self.objects)
            self._kept.append(value)
            self.objects.append(said)
        return [self._places[id(value)]]

    def _nodes(self, values: Iterable[Any], where: str) -> list[Any]:
        return [self.node(one, f"{where}[{place}]") for place, one in enumerate(values)]

    def _said(self, value: Any, where: str) -> list[Any]:
        """A word for the kind of an object, and what it is put together from."""
        kind = type(value)
        if isinstance(value, np.generic) and value.dtype.kind in "biuf":
            return ["number", value.dtype.str, value.item()]
        if isinstance(value, np.ndarray | np.generic) or hasattr(kind, "__array_namespace__"):
            return self._array(np.asarray(value), where)
        if isinstance(value, Enum):
            return ["member", _named(kind, where), value.value]
        if isinstance(value, tuple) and hasattr(kind, "_fields"):
            return ["named tuple", _named(kind, where), self._fields(zip(kind._fields, value, strict=True), where)]
        if kind.__name__ in _ROWS:
            return [kind.__name__, self._nodes(value, where)]
        if isinstance(value, Mapping):
            items = [[self.node(key, where), self.node(one, f"{where}[{key!r}]")] for key, one in value.items()]
            return ["frozen dict" if kind is FrozenDict else "dict", items]
        if isinstance(value, type | FunctionType):
            return ["name", _named(value, where)]
        if dataclasses.is_dataclass(value):
            reduced: Any = getattr(kind, "__reduce__", object.__reduce__)
            constant = reduced(value) if reduced is not object.__reduce__ else None
            if isinstance(constant, str):
                return ["constant", _named(kind, where), constant]
            return self._dataclass(value, where)
        return self._said_of_others(value, where)

    def _dataclass(self, value: Any, where: str) -> list[Any]:
        """The fields of a dataclass; without those computed from the others if one of these cannot be stored, as a function."""
        kind = type(value)
        names = _field_names(kind)
        given = [one.name for one in dataclasses.fields(kind) if one.init]
        requested = {name: getattr(value, name) for name in given}
        stored = self._fields(requested.items(), where)
        try:
            computed = {name: getattr(value, name) for name in names if name not in requested}
            return ["value", _named(kind, where), {**stored, **self._fields(computed.items(), where)}]
        except InputError:
            if len(given) == len(names):
                raise
            return ["made", _named(kind, where), stored]

    def _said_of_others(self, value: Any, where: str) -> list[Any]:
        if isinstance(value, functools.partial):
            return ["partial", *self._nodes((value.func, value.args, value.keywords), where)]
        if isinstance(value, MethodType):
            return ["method", *self._nodes((value.__func__, value.__self__), where)]
        if isinstance(value, PurePath):
            return ["path", str(value)]
        if isinstance(value, complex):
            return ["complex", value.real, value.imag]
        if type(value).__module__.partition(".")[0] == _PROGRAM and hasattr(value, "__dict__"):
            # What it has computed for itself, it can compute again.
            kept = ((name, one) for name, one in vars(value).items() if not _is_computed(type(value), name))
            return ["object", _named(type(value), where), self._fields(kept, where)]
        raise InputError(f"{where}: a {type(value).__name__} cannot be saved")

    def _fields(self, fields: Iterable[tuple[str, Any]], where: str) -> dict[str, Any]:
        return {name: self.node(one, f"{where}.{name}") for name, one in fields}

    def _array(self, array: np.ndarray, where: str) -> list[Any]:
        shape = list(array.shape)
        if array.dtype.hasobject:
            return ["objects", shape, self._nodes(array.ravel(), where)]
        if array.size and 0 in array.strides:  # what is broadcast is stored once
            array = array[tuple(np.s_[:1] if step == 0 else np.s_[:] for step in array.strides)]
        parts = self.parts.setdefault(array.dtype, [])
        start = self._sizes.get(array.dtype, 0)
        self._sizes[array.dtype] = start + array.size
        parts.append(array.ravel())
        return ["array", list(self.parts).index(array.dtype), start, list(array.shape), shape]


def _field_names(kind: Any) -> list[str]:
    return [one.name for one in dataclasses.fields(kind)]


def _is_computed(kind: type, name: str) -> bool:
    return isinstance(getattr(kind, name, None), functools.cached_property)


def _named(thing: Any, where: str) -> str:
    """Name by which a class or function is found again.

    Raises
    ------
    InputError
        If its module does not know it by that name.
    """
    module, name = thing.__module__, thing.__qualname__
    if _attribute(sys.modules.get(module), name) is not thing:
        raise InputError(
            f"{where}: {name} cannot be saved, as its module {module} does not name it; define it at the top of a module"
        )
    return f"{module}:{name}"


def _attribute(module: Any, name: str) -> Any:
    return functools.reduce(lambda at, part: getattr(at, part, None), name.split("."), module)


class _Unpacking:
    """Objects of a value that is put together, in the order in which they were stored: what one refers to stands before it."""

    def __init__(self, arrays: Mapping[str, np.ndarray], trusted: Collection[str], version: str) -> None:
        self._arrays, self._trusted, self._version = arrays, trusted, version
        self._made: list[Any] = []

    def value(self, objects: Iterable[list[Any]], root: Any) -> Any:
        for said in objects:
            self._made.append(self._object(said))
        return self._node(root)

    def _node(self, node: Any) -> Any:
        return self._made[node[0]] if isinstance(node, list) else node

    def _nodes(self, nodes: Iterable[Any]) -> list[Any]:
        return [self._node(one) for one in nodes]

    def _object(self, said: list[Any]) -> Any:
        match said:
            case ["array", place, start, stored, shape]:
                stop = start + math.prod(stored)
                return frozen(np.broadcast_to(self._arrays[str(place)][start:stop].reshape(stored), shape))
            case ["objects", shape, items]:
                made = np.empty(len(items), dtype=object)
                made[:] = self._nodes(items)
                return frozen(made.reshape(shape))
            case ["number", kind, value]:
                return np.dtype(kind).type(value)
            case ["dict" | "frozen dict" as word, items]:
                table = {self._node(key): self._node(one) for key, one in items}
                return table if word == "dict" else FrozenDict(table)
            case ["member", kind, value]:
                return self._named(kind, Enum)(value)
            case ["named tuple", kind, fields]:
                found: Any = self._named(kind, tuple)
                self._check(kind, found._fields, fields)
                return found._make(self._node(fields[name]) for name in found._fields)
            case ["value", kind, fields]:
                self._check(kind, _field_names(self._named(kind, object)), fields)
                return self._with(kind, fields)
            case [word, items] if word in _ROWS:
                return _ROWS[word](self._nodes(items))
            case _:
                return self._other(said)

    def _other(self, said: list[Any]) -> Any:
        match said:
            case ["name", kind]:
                return self._named(kind, object)
            case ["constant", kind, name]:
                found = self._named(kind, object)
                made = getattr(sys.modules[found.__module__], name)
                if type(made) is not found:
                    raise ValueError(f"{name} is no {kind}")
                return made
            case ["partial", function, args, keywords]:
                return functools.partial(self._node(function), *self._node(args), **self._node(keywords))
            case ["method", function, of]:
                return MethodType(self._node(function), self._node(of))
            case ["path", text]:
                return Path(text)
            case ["complex", real, imaginary]:
                return complex(real, imaginary)
            case ["made", kind, fields]:
                return self._named(kind, object)(**{name: self._node(one) for name, one in fields.items()})
            case ["object", kind, fields]:
                return self._with(kind, fields)
        raise ValueError(f"{said[0]!r} is no kind of object")

    def _with(self, kind: str, fields: Mapping[str, Any]) -> Any:
        """An object with its fields, which were checked when it was first made."""
        made: Any = object.__new__(self._named(kind, object))
        for name, node in fields.items():
            object.__setattr__(made, name, self._node(node))
        return made

    def _check(self, kind: str, names: Iterable[str], fields: Mapping[str, Any]) -> None:
        if {*names} != fields.keys():
            raise InputError(f"was saved by version {self._version}, whose {printable(kind)} had other fields")

    def _named(self, kind: str, base: type) -> Any:
        """A class or function of a trusted package, by the name that its own module gives it."""
        module, _, name = kind.partition(":")
        package = module.partition(".")[0]
        if package not in self._trusted:
            raise InputError(
                f"holds {printable(kind)} of another package; if you trust the file, name the package: "
                f"iv.load_result(..., packages=[{printable(package)!r}])"
            )
        try:
            found = _attribute(importlib.import_module(module), name)
        except ImportError as problem:
            raise InputError(f"holds {printable(kind)}, which cannot be imported: {problem}") from problem
        if found is None or (found.__module__, found.__qualname__) != (module, name):
            raise InputError(
                f"was saved by version {self._version}, whose {printable(kind)} this version does not have"
            )
        if base is not object and not (isinstance(found, type) and issubclass(found, base)):
            raise ValueError(f"{kind} is no {base.__name__}")
        return found
