"""What was computed last, by key: as many values as are worth their memory."""

from __future__ import annotations

import collections
from typing import TypeVar

K = TypeVar("K")
V = TypeVar("V")


class Recent(collections.OrderedDict[K, V]):
    """A mapping that forgets what was used the longest time ago."""

    def __init__(self, most: int) -> None:
        """Keep so many values."""
        super().__init__()
        self._most = most

    def __getitem__(self, key: K) -> V:
        """The value, which is then the last used."""
        self.move_to_end(key)
        return super().__getitem__(key)

    def __setitem__(self, key: K, value: V) -> None:
        """Keep a value in place of the one used the longest time ago."""
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._most:
            del self[next(iter(self))]
