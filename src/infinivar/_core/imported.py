"""Names of functions and classes, "module:name", whose modules load when they are used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any


def imported(where: str) -> Any:
    """The function or class of a name such as "infinivar.machines.kinds.arm:ArmDrive"."""
    module, _, name = where.partition(":")
    return getattr(import_module(module), name)


class Imported(Mapping[str, type]):
    """Classes by word; the words are known before any class is imported."""

    def __init__(self, where: Mapping[str, str]) -> None:
        """Keep the names of the classes, "module:class", by word."""
        self.where = where

    def __getitem__(self, word: str) -> type:
        """Import the class of a word."""
        return imported(self.where[word])

    def word_of(self, kind: type) -> str | None:
        """The word of a class, None if it has none; compared by name, so that no other class is imported."""
        name = f"{kind.__module__}:{kind.__qualname__}"
        return next((word for word, where in self.where.items() if where == name), None)

    def __contains__(self, word: object) -> bool:
        """Whether there is a class of that word."""
        return word in self.where

    def __iter__(self) -> Iterator[str]:
        """Iterate over the words."""
        return iter(self.where)

    def __len__(self) -> int:
        """Count the classes."""
        return len(self.where)
