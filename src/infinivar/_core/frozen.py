"""Frozen values: dictionaries that cannot be changed, and arrays that are copied and locked."""

from __future__ import annotations

import contextlib
import ctypes
import io
import math
import mmap
import operator
from collections.abc import Mapping
from typing import Any, NoReturn, TypeVar

import numpy as np

from infinivar._core.text import few
from infinivar.errors import nearest

K = TypeVar("K")
V = TypeVar("V")

_PLAIN = frozenset({float, int, bool, str, complex, type(None), np.float64, np.int8, np.int64, np.bool_})
"""Types that cannot be changed, met so often that they are looked up first."""

_LARGE = 1 << 22
"""Size from which large pages pay off. [bytes]"""

_REFERENCES = "OT"
"""Kinds of arrays that hold references to their items: bytes cannot keep those alive, so that they are locked as views."""


_LISTED = 12
"""Most keys named in a message."""


class UnknownKeyError(KeyError):
    """A key that a frozen dictionary does not have; its text suggests the nearest one."""

    def __init__(self, key: object, known: tuple[str, ...]) -> None:
        super().__init__(key)
        self.known = known

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.args[0], self.known)

    def __str__(self) -> str:
        hint = nearest(self.args[0], self.known) if isinstance(self.args[0], str) else ""
        return f"{self.args[0]!r}{hint}; keys: {few(self.known, _LISTED) or 'none'}"


class FrozenDict(dict[K, V]):
    """Immutable dictionary. Unlike `types.MappingProxyType` it can be pickled."""

    def _refuse(self, *args: Any, **kwargs: Any) -> NoReturn:
        raise TypeError("this mapping is part of a frozen value; use dataclasses.replace to make another")

    def __missing__(self, key: object) -> NoReturn:
        raise UnknownKeyError(key, tuple(one for one in self if isinstance(one, str)))

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type, tuple[dict[K, V]]]:
        """Rebuild from a plain dictionary, not by setting items."""
        return type(self), (dict(self),)


def frozen(value: Any) -> Any:
    """A value that nobody can change: NumPy arrays read-only, dictionaries frozen, inside tuples as well.

    An array is copied unless no one can write to its memory, and the lock of the copy cannot be opened. Arrays of other
    libraries, which nobody can write to, stay as they are, and so do dictionaries of them: the transformations of such a
    library know plain dictionaries only.
    """
    kind = type(value)
    if kind in _PLAIN:
        return value
    if kind is np.ndarray:
        return value if _locked(value) else _copied(value)
    if isinstance(value, dict | Mapping):
        return _frozen_mapping(value)
    if isinstance(value, tuple):
        items = [frozen(item) for item in value]
        if all(map(operator.is_, items, value)):
            return value
        return kind(*items) if hasattr(kind, "_fields") else tuple(items)
    return frozen(value.view(np.ndarray)) if isinstance(value, np.ndarray) else value


def _frozen_mapping(value: Mapping[Any, Any]) -> Mapping[Any, Any]:
    items, foreign = {}, False
    for key, item in value.items():
        kind = type(item)
        items[key] = item if kind in _PLAIN else frozen(item)
        foreign = foreign or (kind not in _PLAIN and kind is not np.ndarray and hasattr(kind, "__array_namespace__"))
    if foreign or (type(value) is FrozenDict and all(map(operator.is_, items.values(), value.values()))):
        return value
    return FrozenDict(items)


def _locked(array: np.ndarray) -> bool:
    """Whether no one can ever write to the memory: it is that of a bytes object. A lock on other memory can be opened."""
    if type(array.base) is bytes:
        return not array.flags.writeable
    views = [array]
    while isinstance(views[-1].base, np.ndarray):
        views.append(views[-1].base)
    if type(views[-1].base) is not bytes:
        return False
    # From the owner of the memory on: a view made by `broadcast_arrays` warns if it is queried first.
    return not any(view.flags.writeable for view in reversed(views))


def _copied(array: np.ndarray) -> np.ndarray:
    """A copy locked for good; an axis along which an array was broadcast stays one number wide in memory."""
    if 0 not in array.strides or not array.size:
        return _sealed(array)
    compact = array[tuple(np.s_[:1] if step == 0 else np.s_[:] for step in array.strides)]
    return np.broadcast_to(_sealed(compact), array.shape)


def _sealed(array: np.ndarray) -> np.ndarray:
    """A copy in a bytes object, whose memory NumPy refuses to make writeable, in the same order in memory."""
    if array.dtype.kind in _REFERENCES or array.dtype.hasobject:
        made = array.copy()
        made.flags.writeable = False
        return made[...]
    order = "F" if array.flags.fnc else "C"
    return np.ndarray(array.shape, array.dtype, array.tobytes(order), order=order)


def rebuilt(cls: type, fields: dict[str, Any]) -> Any:
    """A copy of a value from its fields, locked again, as NumPy forgets locks; nothing is computed anew."""
    made = object.__new__(cls)
    for name, value in fields.items():
        object.__setattr__(made, name, frozen(value))
    return made


class Room:
    """An array to be filled once, and then locked for good without a copy.

    `array` must have no other references when it is locked.
    """

    __slots__ = ("_memory", "array")

    def __init__(self, shape: tuple[int, ...], dtype: Any) -> None:
        """Reserve the memory, which the system provides where it is written to."""
        self._memory = io.BytesIO(bytes(math.prod(shape) * np.dtype(dtype).itemsize))
        self.array = np.frombuffer(self._memory.getbuffer(), dtype).reshape(shape)
        if self.array.nbytes >= _LARGE and hasattr(mmap, "MADV_HUGEPAGE"):
            _on_large_pages(self.array)

    def locked(self) -> np.ndarray:
        """The array, which no one can change from now on."""
        shape, dtype = self.array.shape, self.array.dtype
        del self.array
        return np.ndarray(shape, dtype, self._memory.getvalue())


def _on_large_pages(array: np.ndarray) -> None:
    """Ask the system for large pages, as NumPy does for its own arrays: thousands of small ones cost more than the numbers."""
    first = -(-array.__array_interface__["data"][0] // mmap.PAGESIZE) * mmap.PAGESIZE
    size = (array.__array_interface__["data"][0] + array.nbytes - first) // mmap.PAGESIZE * mmap.PAGESIZE
    with contextlib.suppress(OSError, AttributeError):  # without them it takes longer
        ctypes.CDLL(None).madvise(ctypes.c_void_p(first), ctypes.c_size_t(size), mmap.MADV_HUGEPAGE)
