"""External inputs of a graph: functions of time, and sampled controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np


class Input(Protocol):
    """An external input as a function of time."""

    @property
    def breaks(self) -> Sequence[float]:
        """Times at which the value or its slope jumps. [s]"""
        ...

    def value(self, time: float) -> float:
        """Value at a time."""
        ...

    def rate(self, time: float) -> float:
        """Time derivative of the value."""
        ...


class Controller(Protocol):
    """A sampled controller; its outputs are held between samples."""

    @property
    def sample_time(self) -> float:
        """Time between samples, > 0. [s]"""
        ...

    def start(self, measured: Mapping[str, float]) -> Any:
        """Memory of the controller before its first sample."""
        ...

    def sample(self, time: float, measured: Mapping[str, float], memory: Any) -> tuple[Mapping[str, float], Any]:
        """Values of inputs by name, and the new memory, from the graph's signals at a time."""
        ...


class Segments(NamedTuple):
    """Times and inputs of segments in order, each at its begin and at the ends of its pieces; n of all of them together."""

    pieces: np.ndarray
    """Number of pieces of each segment. (s,)"""
    sampled: np.ndarray
    """Whether a segment begins with a sample of the controller, 0 or 1. (s,)"""
    begins: np.ndarray
    """(s,) [s]"""
    seen: np.ndarray
    """Inputs as the controller sees them at the begin. (s, inputs)"""
    seen_rates: np.ndarray
    """(s, rates)"""
    starts: np.ndarray
    """Places of the begins, and n. (s + 1,)"""
    times: np.ndarray
    """(n,) [s]"""
    inputs: np.ndarray
    """As they are within the segment, if they jump at its ends. (n, inputs)"""
    rates: np.ndarray
    """(n, inputs)"""

    def part(self, first: int, last: int) -> Segments:
        """Some of the segments; the arrays are the same."""
        inner = slice(*(int(self.starts[place]) for place in (first, last)))
        own = slice(first, last)
        return Segments(
            *(self.pieces[own], self.sampled[own], self.begins[own], self.seen[own], self.seen_rates[own]),
            *(self.starts[first : last + 1] - self.starts[first], self.times[inner]),
            *(self.inputs[inner], self.rates[inner]),
        )


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant input."""

    size: float
    breaks: tuple[float, ...] = ()

    def value(self, time: float) -> float:
        """The constant."""
        return self.size

    def rate(self, time: float) -> float:
        """Zero."""
        return 0.0


def over(functions: Sequence[Input], times: np.ndarray, rate: bool = False) -> np.ndarray:
    """Values or rates of the functions at given times, at once if one has a method `over` for both. (n, functions)"""
    found = np.empty((len(times), len(functions)))
    if all(isinstance(function, Constant) for function in functions):
        found[:] = 0.0 if rate else [function.value(0.0) for function in functions]
        return found
    instants = times.tolist()
    for column, function in enumerate(functions):
        if isinstance(function, Constant):
            found[:, column] = 0.0 if rate else function.size
        elif (together := getattr(function, "over", None)) is not None:
            found[:, column] = together(times)[int(rate)]
        else:
            found[:, column] = [function.rate(time) if rate else function.value(time) for time in instants]
    return found
