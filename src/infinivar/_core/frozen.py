"""Immutable dictionary for frozen values; it can be copied, pickled and sent to other processes."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """Immutable dictionary. Unlike `types.MappingProxyType` it can be pickled."""

    def _refuse(self, *args: Any, **kwargs: Any) -> NoReturn:
        raise TypeError("this mapping is part of a frozen value; use dataclasses.replace to make another")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type, tuple[dict[K, V]]]:
        """Rebuild from a plain dictionary, not by setting items."""
        return type(self), (dict(self),)
