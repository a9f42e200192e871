"""Steps of a motion in compiled C: equations, exact derivatives and collocation in one library, called once a segment.

Source: hairer1996, section IV.8.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from typing import Any

import numpy as np

from infinivar._core.c_library import compiler, library
from infinivar.bondgraph.c_code import Code, c_code
from infinivar.bondgraph.inputs import Constant, Input, over
from infinivar.bondgraph.model import Model

_BESIDE = 1e-6
"""Distance from the ends of a segment, over its width, at which inputs are looked at: they may jump at an end."""

_FIRST = 0.1
"""First step tried, over the width of the first segment."""


def compilable(made: Model, parameters: Mapping[str, float]) -> bool:
    """Whether the system has a compiler, and every law of the model C."""
    return _compiled(made, parameters) is not None


def compiled_stepper(
    made: Model, parameters: Mapping[str, float], rtol: float, absolute: np.ndarray
) -> Callable[..., tuple[np.ndarray, str]] | None:
    """What integrates states and energies over one segment as `solver.stepper` has it; None where nothing can be compiled."""
    compiled = _compiled(made, parameters)
    return None if compiled is None else _Steps(*compiled, parameters, rtol, absolute)


def _compiled(made: Model, parameters: Mapping[str, float]) -> tuple[ctypes.CDLL, Code] | None:
    code = _code(made, parameters) if compiler() is not None else None
    compiled = None if code is None else library(code.text + _collocation())
    return None if code is None or compiled is None else (compiled, code)


class _Steps:
    """One motion in progress, with the arrays that the library finds by their addresses."""

    def __init__(
        self, compiled: ctypes.CDLL, code: Code, parameters: Mapping[str, float], rtol: float, absolute: np.ndarray
    ) -> None:
        self._step, self._rooms = np.zeros(1), {}
        self._held = code.given(parameters), np.empty(code.constants), np.array(absolute, dtype=float)
        given, constants, tolerances = map(_at, self._held)
        self._known, self._limits = (given, constants), (rtol, tolerances, _at(self._step))
        compiled.constants.argtypes = [ctypes.c_void_p] * 2
        compiled.constants(*self._known)
        self._advance, pointer = compiled.advance, ctypes.c_void_p
        self._advance.argtypes = [*[pointer] * 2, ctypes.c_int, *[pointer] * 4, ctypes.c_double, *[pointer] * 3]

    def __call__(
        self, now: list[float], begin: float, required: Any, functions: Sequence[Input]
    ) -> tuple[np.ndarray, str]:
        """Rows at the required times, and the reason of a failure, or ""."""
        size = len(required)
        if size not in self._rooms:
            self._rooms[size] = _Room(size, len(functions), len(now))
        room = self._rooms[size]
        room.times[0], room.times[1:], room.state[:] = begin, required, now
        _fill(room, functions)
        self._step[0] = self._step[0] or _FIRST * (room.times[-1] - begin)
        times, inputs, rates, state, rows = room.places
        status = self._advance(*self._known, size, times, inputs, rates, state, *self._limits, rows)
        return room.rows.copy(), "" if status == 0 else "no step is short enough"


def _at(array: np.ndarray) -> int:
    return array.ctypes.data


class _Room:
    """What a segment of that many instants needs, where the library finds it."""

    def __init__(self, size: int, inputs: int, states: int) -> None:
        self.times, self.state, self.rows = np.empty(size + 1), np.empty(states), np.empty((size, states))
        self.inputs, self.rates = np.zeros((2, size + 1, inputs))
        self.places = [_at(one) for one in (self.times, self.inputs, self.rates, self.state, self.rows)]


_CODES: dict[Model, Code | None] = {}
"""C of the models of this process: the same for all values of the parameters."""


def _code(made: Model, parameters: Mapping[str, float]) -> Code | None:
    """C of a model; None if a law has none."""
    if made not in _CODES:
        try:
            _CODES[made] = c_code(made, parameters)
        except (TypeError, AttributeError):
            _CODES[made] = None
    return _CODES[made]


def _collocation() -> str:
    return source("collocation.c")


@functools.cache
def source(name: str) -> str:
    """Content of a C file of the package."""
    return (resources.files("infinivar.bondgraph") / "data" / name).read_text("utf-8")


def _fill(room: _Room, functions: Sequence[Input]) -> None:
    """Put inputs and their rates in, at the ends of the segment as they are within it."""
    if all(isinstance(function, Constant) for function in functions):  # between samples mostly so
        room.inputs[:], room.rates[:] = [function.value(0.0) for function in functions], 0.0
        return
    times, ends = room.times, [0, -1]
    near = _BESIDE * (times[-1] - times[0])
    beside = times.copy()
    beside[ends] += near, -near
    room.inputs[:], room.rates[:] = over(functions, beside), over(functions, beside, rate=True)
    room.inputs[ends] += room.rates[ends] * (times - beside)[ends, None]
