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
from infinivar.bondgraph.inputs import Constant, Input
from infinivar.bondgraph.model import Model

_BESIDE = 1e-6
"""Distance from the ends of a segment, over its width, at which inputs are looked at: they may jump at an end."""

_FIRST = 0.1
"""First step tried, over the width of the first segment."""


def compiled_stepper(
    made: Model, parameters: Mapping[str, float], rtol: float, absolute: np.ndarray
) -> Callable[..., tuple[np.ndarray, str]] | None:
    """Function that integrates one segment as `solver.stepper` has it; None where the model cannot be compiled here."""
    found = _code(made, parameters) if compiler() is not None else None
    made_of = None if found is None else library(found.text + _collocation())
    if found is None or made_of is None:
        return None
    given, constants, tolerances = found.given(parameters), np.empty(found.constants), np.array(absolute, dtype=float)
    made_of.constants.argtypes = [ctypes.c_void_p] * 2
    made_of.constants(_at(given), _at(constants))
    step, advance, count = np.zeros(1), made_of.advance, len(made.states)
    advance.argtypes = [
        *[ctypes.c_void_p] * 2,
        ctypes.c_int,
        *[ctypes.c_void_p] * 4,
        ctypes.c_double,
        *[ctypes.c_void_p] * 3,
    ]
    rooms: dict[int, _Room] = {}

    def piece(now: list[float], begin: float, required: Any, functions: Sequence[Input]) -> tuple[np.ndarray, str]:
        size = len(required)
        room = rooms.get(size) or rooms.setdefault(size, _Room(size, len(functions), count))
        room.times[0], room.times[1:], room.state[:] = begin, required, now
        _fill(room, functions)
        step[0] = step[0] or _FIRST * (room.times[-1] - begin)
        times, inputs, rates, state, rows = room.places
        known, limits = (_at(given), _at(constants)), (rtol, _at(tolerances), _at(step))
        status = advance(*known, size, times, inputs, rates, state, *limits, rows)
        return room.rows.copy(), "" if status == 0 else "no step is short enough"

    return piece


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


@functools.cache
def _collocation() -> str:
    return (resources.files("infinivar.bondgraph") / "data" / "collocation.c").read_text("utf-8")


def _fill(room: _Room, functions: Sequence[Input]) -> None:
    """Put inputs and their rates in, at the ends of the segment as they are within it."""
    times = room.times
    near = _BESIDE * (times[-1] - times[0])
    beside = np.array([times[0] + near, *times[1:-1], times[-1] - near])
    looked = beside.tolist()
    for column, function in enumerate(functions):
        if isinstance(function, Constant):
            room.inputs[:, column], room.rates[:, column] = function.size, 0.0
            continue
        room.rates[:, column] = [function.rate(time) for time in looked]
        room.inputs[:, column] = [function.value(time) for time in looked]
        for end in (0, -1):
            room.inputs[end, column] += room.rates[end, column] * (times[end] - beside[end])
