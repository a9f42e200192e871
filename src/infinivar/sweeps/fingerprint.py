"""Digest of the content of a value: equal contents have equal digests in every process and on every machine."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import inspect
import struct
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from pathlib import PurePath
from typing import Any

import numpy as np

_LENGTH = 32


def fingerprint(*values: Any) -> str:
    """Digest of values made of numbers, texts, arrays, containers, data classes and functions.

    Fields that do not take part in comparisons, such as the path of a study's file, do not count.

    Raises
    ------
    TypeError
        If a value has content that cannot be seen, such as an open file.
    """
    digest = hashlib.sha256()
    _feed(digest.update, values)
    return digest.hexdigest()[:_LENGTH]


def _feed(add: Callable[[bytes], None], value: Any) -> None:
    """Add a value, with its type and length, so that different values never read the same."""
    if value is None or (isinstance(value, bool | int | str | bytes) and not isinstance(value, Enum)):
        _text(add, f"{type(value).__name__} {value!r}")
    elif isinstance(value, float):
        add(b"float")
        add(struct.pack("<d", value))
    elif isinstance(value, np.ndarray | np.generic):
        _array(add, np.asarray(value))
    elif isinstance(value, Enum):
        _text(add, f"{type(value).__qualname__}.{value.name}")
    elif isinstance(value, PurePath):
        _text(add, f"path {value.as_posix()}")
    elif isinstance(value, Mapping):
        _items(add, "mapping", (item for pair in value.items() for item in pair))
    elif isinstance(value, tuple | list):
        _items(add, "sequence", value)
    elif isinstance(value, set | frozenset):
        _items(add, "set", sorted(fingerprint(item) for item in value))
    elif isinstance(value, type):
        _text(add, _named(value))
    else:
        _parts(add, value)


def _parts(add: Callable[[bytes], None], value: Any) -> None:
    """Add what a value consists of."""
    if isinstance(value, functools.partial):
        _items(add, "partial", (value.func, value.args, value.keywords))
    elif inspect.ismethod(value):
        _items(add, "method", (value.__self__, value.__name__))
    elif inspect.isfunction(value):
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        _items(add, f"function {_named(value)}", (value.__code__.co_code, value.__defaults__, cells))
    elif inspect.isbuiltin(value) or isinstance(value, np.ufunc):
        _text(add, f"function {value.__name__}")
    elif dataclasses.is_dataclass(value):
        fields = [field.name for field in dataclasses.fields(value) if field.compare]
        _items(add, _named(type(value)), (item for name in fields for item in (name, getattr(value, name))))
    elif hasattr(value, "__dict__"):
        _items(add, _named(type(value)), (item for pair in sorted(vars(value).items()) for item in pair))
    else:
        raise TypeError(f"the content of a {_named(type(value))} cannot be compared with that of an earlier run")


def _array(add: Callable[[bytes], None], value: np.ndarray) -> None:
    if value.dtype.kind in "OUST":
        _items(add, f"array {value.shape}", value.ravel().tolist())
    else:
        _text(add, f"array {value.dtype.newbyteorder('<').str} {value.shape}")
        add(np.ascontiguousarray(value, dtype=value.dtype.newbyteorder("<")).tobytes())


def _items(add: Callable[[bytes], None], title: str, items: Iterable[Any]) -> None:
    _text(add, f"{title} (")
    for item in items:
        _feed(add, item)
    _text(add, ")")


def _text(add: Callable[[bytes], None], text: str) -> None:
    content = text.encode()
    add(struct.pack("<q", len(content)))
    add(content)


def _named(value: Any) -> str:
    return f"{value.__module__}.{value.__qualname__}"
