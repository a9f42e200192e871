"""What drives a graph from outside: inputs over time, and controllers that set inputs at their samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol


class Input(Protocol):
    """An outside input as a function of time."""

    @property
    def breaks(self) -> Sequence[float]:
        """Instants at which the value or its slope jumps. [s]"""
        ...

    def value(self, time: float) -> float:
        """Value at a time."""
        ...

    def rate(self, time: float) -> float:
        """Time derivative of the value."""
        ...


class Controller(Protocol):
    """A sampled controller: its outputs are held from one sample to the next."""

    @property
    def sample_time(self) -> float:
        """Time between samples, > 0. [s]"""
        ...

    def start(self, measured: Mapping[str, float]) -> Any:
        """What the controller remembers before its first sample."""
        ...

    def sample(self, time: float, measured: Mapping[str, float], memory: Any) -> tuple[Mapping[str, float], Any]:
        """Values of inputs by name, and what to remember, from the graph's signals at a time."""
        ...


@dataclass(frozen=True, slots=True)
class Constant:
    """An input that never changes."""

    size: float
    breaks: tuple[float, ...] = ()

    def value(self, time: float) -> float:
        """The constant."""
        return self.size

    def rate(self, time: float) -> float:
        """Zero."""
        return 0.0
