"""Runs in compiled C: equations, exact derivatives, collocation and the loop over samples in one library.

A controller whose formula is recorded runs in the library as well; any other is asked by the caller, segment by segment.

Source: hairer1996, section IV.8.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.c_library import compiler, library
from infinivar.bondgraph.c_code import Code, c_code, data_of, statements
from infinivar.bondgraph.inputs import Controller, Segments
from infinivar.bondgraph.model import Model
from infinivar.bondgraph.tape import Tape

_FIRST = 0.1
"""First step tried, over the width of the first segment."""


class Recorded(NamedTuple):
    """A controller as C: without its numbers, the same text for all controllers that decide alike."""

    text: str
    numbers: np.ndarray
    """Its array `c`; empty if they are in the text."""
    data: np.ndarray
    """Its array `p`: tables."""


def recorded(made: Model, controller: Any, *, numbers_apart: bool = True) -> Recorded:
    """C of a controller of a model; its own function reads goal, signals and memory, and writes commands and memory.

    Parameters
    ----------
    made : Model
    controller : Any       With a formula `control(goal, measured, memory)`, the kind of its `goal`, and names of its `outputs`.
    numbers_apart : bool   Whether its numbers are left out of the text.

    Raises
    ------
    TypeError, AttributeError
        If the controller has no formula, or it decides by values.
    """
    goals, memory = len(controller.goal._fields), len(controller.start({}))
    places = [made.inputs.index(name) for name in controller.outputs]
    tape, numbers = Tape({}), []
    given = [tape.input("inputs", place) for place in range(goals + len(made.signals) + memory)]
    measured = dict(zip(made.signals, given[goals:], strict=False))
    commands, kept = controller.control(controller.goal(*given[:goals]), measured, given[goals + len(made.signals) :])
    body = statements(tape, [*commands, *kept], "y", numbers if numbers_apart else None)
    return Recorded(
        controller_text(goals, memory, places, body), np.array([*numbers, 0.0]), np.append(data_of(tape), 0.0)
    )


def controller_text(goals: int, memory: int, places: Sequence[int], body: Sequence[str]) -> str:
    """C of one sample of a controller, from the statements of its body: places are those of the inputs that it commands."""
    return "\n".join(
        [
            f"enum {{ GOALS = {goals}, MEMORY = {memory}, COMMANDS = {len(places)} }};",
            f"static const int commanded[] = {{{', '.join(map(str, places)) or '0'}}};",
            "static const double settled[] = {1e-12};",
            "static void controlled(const double *c, const double *p, const double *u, double *y)",
            "{",
            "    (void)c; (void)p; (void)u; (void)y; (void)settled; (void)commanded;",
            *body,
            "}",
        ]
    )


NO_CONTROLLER = Recorded(controller_text(0, 0, (), ()), np.zeros(1), np.zeros(1))


def compiled_loop(
    made: Model, parameters: Mapping[str, float], controller: Controller | None, rtol: float, absolute: np.ndarray
) -> Loop | None:
    """What integrates states and energies over segments; None without a compiler, or where a law has no C."""
    code = _code(made, parameters) if compiler() is not None else None
    if code is None:
        return None
    own = None if controller is None else _recorded(made, controller)
    found = library(run_text(code, own))
    if found is None:
        return None
    return Loop(found, code, made, parameters, controller, own, rtol, absolute)


def run_text(code: Code, own: Recorded | None) -> str:
    """C of a run: a model, a controller or none, and the loop."""
    return "\n".join([code.text, data("collocation.c"), (own or NO_CONTROLLER).text, data("sampled.c")])


def _recorded(made: Model, controller: Any) -> Recorded | None:
    """C of a controller; None if it has none."""
    try:
        return recorded(made, controller)
    except (TypeError, AttributeError, KeyError, ValueError):
        return None


class Loop:
    """One motion in progress: integrates segments, with a controller that has C or without one."""

    def __init__(
        self,
        compiled: ctypes.CDLL,
        code: Code,
        made: Model,
        parameters: Mapping[str, float],
        controller: Any,
        own: Recorded | None,
        rtol: float,
        absolute: np.ndarray,
    ) -> None:
        """With a library of `run_text`, and tolerances of states and energies."""
        self.samples = controller is None or own is not None
        """Whether it needs nobody else to sample."""
        self.controller: Any = controller if own is not None else None
        self.commands: tuple[str, ...] = () if self.controller is None else self.controller.outputs
        """Names of the inputs that it commands."""
        self.places = [made.inputs.index(name) for name in self.commands]
        """Their places."""
        own = own or NO_CONTROLLER
        self._width = np.zeros(1)
        self._held = code.given(parameters), np.empty(code.constants + 1), own.numbers, own.data
        self._absolute = np.array(absolute, dtype=float)
        compiled.constants.argtypes = [ctypes.c_void_p] * 2
        self._known = [_at(one) for one in self._held]
        self._limits = rtol, _at(self._absolute), _at(self._width)
        compiled.constants(*self._known[:2])
        pointer = ctypes.c_void_p
        self._march = compiled.march
        self._march.argtypes = [*[pointer] * 4, ctypes.c_int, *[pointer] * 12, ctypes.c_double, *[pointer] * 3]

    def __call__(
        self, segments: Segments, now: Sequence[float], memory: Sequence[float], commands: Sequence[float]
    ) -> tuple[int, np.ndarray, np.ndarray, list[float], list[float]]:
        """Number of segments completed, then rows at the ends of pieces, commands of each segment, memory and commands held."""
        self._width[0] = self._width[0] or _FIRST * (segments.times[segments.pieces[0]] - segments.times[0])
        state, kept = np.array(now, dtype=float), np.array([*memory, 0.0], dtype=float)
        last = np.array([*commands, 0.0], dtype=float)
        goals = np.zeros(1)
        if self.controller is not None:
            goals = np.ascontiguousarray(self.controller.goals(segments.begins))
        rows, held = np.empty((segments.pieces.sum(), len(state))), np.empty((len(segments.pieces), len(self.places)))
        arrays = [
            *(segments.pieces, segments.sampled, goals, segments.seen, segments.seen_rates),
            *(segments.times, segments.inputs, segments.rates, state, kept, last, held),
        ]
        done = self._march(*self._known, len(segments.pieces), *map(_at, arrays), *self._limits, _at(rows))
        return done, rows, held, kept[:-1].tolist(), last[:-1].tolist()


def _at(array: np.ndarray) -> int:
    return array.ctypes.data


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
def data(name: str) -> str:
    """C of this package, by the name of its file."""
    return (resources.files("infinivar.bondgraph") / "data" / name).read_text("utf-8")
