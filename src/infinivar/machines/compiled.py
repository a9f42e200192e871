"""Motions of machines in compiled C: the equations of a `System`, recorded from their Python source, and steps by collocation.

Numbers of the machine are data of the C text, so that machines that differ in numbers alone share one library.

Source: hairer1996, section IV.8, for the steps.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import inspect
import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core import collocation, kept
from infinivar._core.c_library import FLAGS, compiler, library
from infinivar._core.collocation import MOVED, Rates, Step, StuckError
from infinivar.bondgraph import c_code, tape
from infinivar.bondgraph.c_code import c_motion, flat
from infinivar.bondgraph.compiled_step import data
from infinivar.bondgraph.recorded import Recorded
from infinivar.bondgraph.tape import Number, Tape, Value
from infinivar.machines.system import Inputs, Outside, System

_FINER = 1e-2
"""Tolerance of the states over that of a run: what a step misses of the energies is no more than what the run allows."""

_ENERGY = 1e-9
"""Error of an energy in a step that is always allowed. [J]"""

_FASTER = "-O3"
"""Matrices of machines are large."""

_FIRST = 0.1
"""First step tried, over the width of the first segment."""

_MOST_STEPS = 512
"""Steps of a segment at whose ends demands are looked at."""

_PLAIN = (0.0, 1.0, -1.0)
"""Numbers that are no data: formulas are simpler for them."""

_SHARES = np.array([1e-6, 1.0 / 3.0, 2.0 / 3.0, 1.0 - 1e-6, 0.5])
"""Instants of a piece between which inputs are cubic, and the one at which this is checked: beside its ends they may jump."""

_CUBIC = np.linalg.inv(np.vander(_SHARES[:4], 4, increasing=True))
_CHECK = _SHARES[4] ** np.arange(4) @ _CUBIC
_ENDS = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0]]) @ _CUBIC
_SLOPES = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 2.0, 3.0]]) @ _CUBIC

_SMOOTH, _HALVINGS = 1e-8, 20
"""Error of the cubic over an input, above which a piece is halved, and how often at most."""

_SMALL = 0.1
"""Inputs below this count as large as this: rates of prescribed angles are differences with a noise of some 1e-10 rad/s. [SI]"""


class Motion(NamedTuple):
    """The compiled motion of a system."""

    library: ctypes.CDLL
    given: np.ndarray
    """Numbers of the machine: `p` of the C functions."""
    constants: np.ndarray
    """What depends on them alone: `k`."""
    states: int
    inputs: int
    powers: int
    watched: int
    """Demands, then coordinates of the handle."""

    def called(self, name: str, size: int, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """What a C function of states and inputs writes into an array of a size."""
        out = np.empty(size)
        getattr(self.library, name)(
            *map(_at, (self.given, self.constants, np.ascontiguousarray(state), inputs, _NOTHING, out))
        )
        return out


class MachineCode(NamedTuple):
    """C of the motion of a system."""

    text: str
    given: np.ndarray
    """Numbers of the machine: `p` of the C functions."""
    constants: int
    """Length of the array `k` of what depends on them alone."""
    states: int
    inputs: int
    powers: int
    watched: int


def machine_code(system: System) -> MachineCode:
    """C of the motion of a system: the equations, their exact derivatives, and their integration.

    Raises
    ------
    TypeError, AttributeError
        If a law has no C: it decides by a value, or calls what the tape has not.
    """
    recorded, inputs, functions = record(system, functools.partial(_of_run, system), _watching)
    identified = [[one.place if isinstance(one, Value) else repr(one) for one in row] for row in functions.values()]
    held = [*map(flat, recorded.data(recorded.parameters))]
    shape = recorded.nodes, identified, [len(one) for one in held]
    key = hashlib.sha256((_program() + repr(shape)).encode()).hexdigest()[:32]
    if key not in _TEXTS:
        _TEXTS[key] = _kept(key) or _written(key, recorded, inputs, functions)
    text, constants = _TEXTS[key]
    own = np.array(list(recorded.parameters.values()), dtype=float)
    given = np.concatenate([own, *held])
    states, powers, watched = (len(functions[name]) for name in ("motion", "powers", "watched"))
    return MachineCode(text, given, constants, states, inputs, powers, watched)


def compiled_motion(system: System) -> Motion | None:
    """The compiled motion of a system; None without a compiler, or where a law has no C."""
    if compiler() is None:
        return None
    try:
        code = machine_code(system)
    except (TypeError, AttributeError, ValueError):  # a law of another package may check its arguments
        return None
    made = library(code.text, (*FLAGS, _FASTER))
    if made is None:
        return None
    pointer = ctypes.c_void_p
    made.constants.argtypes = [pointer] * 2
    for name in ("rates_at", "powers_at", "slopes_at", "watched_at"):
        getattr(made, name).argtypes = [pointer] * 6
    made.march_watched.argtypes = [
        *[pointer] * 3, ctypes.c_int, *[pointer] * 5, ctypes.c_double, *[pointer] * 11
    ]  # fmt: skip
    made.advance_watched.argtypes = [*[pointer] * 2, ctypes.c_int, *[pointer] * 4, ctypes.c_double, *[pointer] * 5]
    constants = np.zeros(code.constants + 1)
    made.constants(_at(code.given), _at(constants))
    return Motion(made, code.given, constants, code.states, code.inputs, code.powers, code.watched)


def inputs_of(inputs: Inputs, outside: Outside) -> np.ndarray:
    """The inputs of the C functions, at one row of what acts from outside."""
    return np.concatenate([*map(np.ravel, inputs), *(np.ravel(one) for one in outside if one is not None), np.zeros(1)])


def derivative_of(system: System, motion: Motion | None) -> Callable[[Inputs, Outside, np.ndarray], np.ndarray]:
    """Derivative of a state by inputs, a row of what acts from outside, and state, as compiled or in Python."""
    if motion is None:
        return lambda inputs, outside, state: system.moved(inputs, outside, state[None]).derivative[0]
    return lambda inputs, outside, state: motion.called("rates_at", motion.states, state, inputs_of(inputs, outside))


class RecordedSystem(NamedTuple):
    """Functions of states and inputs on a tape whose parameters are the numbers of the machine."""

    tape: Tape
    inputs: int
    functions: dict[str, list[Number]]


OpenInputs = Callable[[tuple[int, ...]], Recorded]
"""Makes an array of inputs that are known when the code runs, of a shape."""

Acted = tuple[Inputs, Outside]


def record(
    system: System,
    acting: Callable[[OpenInputs], Acted],
    read: Callable[[Rates, Acted, Recorded], Mapping[str, Any]],
) -> RecordedSystem:
    """Record the motion of a system, and what else is read of it.

    Parameters
    ----------
    system : System
    acting : callable   Gives what acts on the system, from a function that makes inputs.
    read : callable     Rows, (1, n) each, by the names of their functions, from rates and balance, what acts, and states (1, n).

    Raises
    ------
    TypeError, AttributeError, ValueError
        If a law decides by a value, or calls what the tape has not.
    """
    tape = Tape({})
    steered = len(system.mechanics.steered) if system.servo is not None else 0
    states = Recorded(tape, [[tape.input("states", place) for place in range(system.places[2] + steered)]])
    made: list[Value] = []

    def input_of(shape: tuple[int, ...]) -> Recorded:
        own = [tape.input("inputs", len(made) + place) for place in range(math.prod(shape))]
        made.extend(own)
        return Recorded(tape, np.reshape(np.array(own, dtype=object), shape))

    inputs, outside = acting(input_of)
    if system.watch is not None:
        system = replace(system, watch=lambda position: position)
    found = system.moved(inputs, outside, states)
    balance = found.balance()
    read_of = read(Rates(found.derivative, lambda: balance), (inputs, outside), states)
    rows = {"motion": found.derivative, "powers": balance.power, **read_of}
    tape, functions = _of_data(tape, {name: _row(one) for name, one in rows.items()})
    return RecordedSystem(tape, len(made), functions)


def _of_run(system: System, input_of: OpenInputs) -> Acted:
    """All that may act on a system."""
    idle, outside = system.idle(), system.outside(np.zeros(1))
    return Inputs(*(input_of(np.shape(one)) for one in idle)), Outside(
        *(None if one is None else input_of(np.shape(one)) for one in outside)
    )


def _watching(found: Rates, acted: Acted, state: Recorded) -> Mapping[str, Any]:
    """Demands that a run watches."""
    return {"watched": found.balance().demand}


def _row(array: Any) -> list[Number]:
    return [one if isinstance(one, Value) else float(one) for one in np.asarray(array, dtype=object)[0].tolist()]


def _of_data(tape: Tape, functions: dict[str, list[Number]]) -> tuple[Tape, dict[str, list[Number]]]:
    """The same with numbers as parameters, one for each value."""
    numbers: dict[float, str] = {}
    fixed = {"pow": (1,), "loop": (-1,)}
    for operation, arguments in tape.nodes:
        if operation not in _GIVEN and not operation.startswith(("take", "held")):
            stays = [at % len(arguments) for at in fixed.get(operation, ())]
            for place, one in enumerate(arguments):
                if isinstance(one, float) and math.isfinite(one) and one not in _PLAIN and place not in stays:
                    numbers.setdefault(one, f"n{len(numbers)}")
    new = Tape({name: value for value, name in numbers.items()})
    new.held, new._looped = tape.held, tape._looped
    values = {value: new.input("parameters", place) for place, value in enumerate(numbers)}
    known: list[Number] = []
    for operation, arguments in tape.nodes:
        if operation in _GIVEN or operation.startswith("held"):
            known.append(new.input(operation, int(arguments[0])))
            continue
        stays = [at % len(arguments) for at in fixed.get(operation, ())]
        given = [
            known[one] if isinstance(one, int) else one if place in stays else values.get(one, one)
            for place, one in enumerate(arguments)
        ]
        known.append(new.copied(operation, given))
    return new, {
        name: [known[one.place] if isinstance(one, Value) else one for one in row] for name, row in functions.items()
    }


_GIVEN = ("states", "inputs", "rates", "looped", "settled")
_NOTHING = np.zeros(1)
_TEXTS: dict[str, tuple[str, int]] = {}


def _kept(key: str) -> tuple[str, int] | None:
    """C of a recorded system, and how many constants it has, if it was written before."""
    path = kept.find(key, ".json")
    try:
        text, constants = json.loads(path.read_text("utf-8")) if path is not None else ("", 0)
    except (OSError, ValueError):
        return None  # gone since, or not readable: write it again
    return (text, constants) if text else None


def _written(key: str, recorded: Tape, inputs: int, functions: dict[str, list[Number]]) -> tuple[str, int]:
    """The same, written."""
    states = [f"state {place}" for place in range(len(functions["motion"]))]
    made = c_motion(recorded, states, [f"input {place}" for place in range(inputs)], functions)
    count = f"enum {{ WATCHED = {len(functions['watched'])} }};\n"
    text = made.text + count + data("collocation.c") + data("watched.c")
    kept.keep(key, ".json", json.dumps([text, made.constants]).encode())
    return text, made.constants


@functools.cache
def _program() -> str:
    """What else the text depends on."""
    return "".join([*map(inspect.getsource, (tape, c_code)), data("collocation.c"), data("watched.c")])


def _at(array: np.ndarray) -> int:
    return array.ctypes.data


class KeptSteps(ctypes.Structure):
    """Where C keeps the steps it takes: how many there were, for how many there is room, and their rows."""

    _fields_ = [("count", ctypes.c_int), ("most", ctypes.c_int), ("rows", ctypes.c_void_p)]


class CompiledSteps:
    """A motion in progress, from segment to segment, as `Collocation`."""

    def __init__(
        self, motion: Motion, system: System, inputs: Callable[[], Inputs], scale: np.ndarray, tolerance: float
    ) -> None:
        """Nothing has moved yet; `inputs` gives those of the segment."""
        self.motion, self.system, self.inputs = motion, system, inputs
        placed = system.places[0]
        size = scale.copy()
        size[:placed] = MOVED
        self.relative = tolerance * _FINER
        self.absolute = np.concatenate([self.relative * size, np.full(motion.powers, _ENERGY)])
        self.energies = np.zeros(motion.powers)
        self.width = np.zeros(1)
        self.steps = np.empty((_MOST_STEPS, 2 + motion.powers + 4 * motion.states))
        self.found = np.empty((_MOST_STEPS, motion.watched))
        self.record = KeptSteps(0, _MOST_STEPS, _at(self.steps))
        self.last: Step | None = None
        self.taken = self.done = 0
        self.demand: np.ndarray | None = None
        self.fixed: bool = not any(map(callable, _functions(system)))
        self.outside = motion.inputs - len(inputs_of(system.idle(), Outside())) + 1
        """Number of inputs that act from outside."""

    def over(self, begin: float, end: float, state: np.ndarray, accept: Callable[[Step], None]) -> np.ndarray:
        """As `Collocation.over`."""
        motion = self.motion
        times, inputs, rates = self.given(np.array([begin, end]))[1:]
        inputs[:, : motion.inputs - self.outside] = inputs_of(self.inputs(), Outside())[:-1]
        if self.demand is None:
            self.demand = self._demand(motion.called("watched_at", motion.watched, state, inputs[0]))
        self.width[0] = self.width[0] or _FIRST * (end - begin)
        start = np.concatenate([state, self.energies])
        rows = np.empty((len(times) - 1, len(start)))
        addresses = map(
            _at, (motion.given, motion.constants, times, inputs, rates, start, self.absolute, self.width, rows)
        )
        given, constants, at, u, du, x, absolute, width, out = addresses
        status = motion.library.advance_watched(
            given, constants, len(times) - 1, at, u, du, x, self.relative, absolute, width, out,
            ctypes.addressof(self.record), _at(self.found),
        )  # fmt: skip
        kept = min(self.record.count, _MOST_STEPS)
        for one in self.steps_of(self.steps[:kept].copy(), self.found[:kept], begin, self.record.count, status):
            accept(one)
        return rows[-1, : motion.states]

    def steps_of(
        self, rows: np.ndarray, found: np.ndarray, begin: float, count: int, status: int = 0
    ) -> Iterator[Step]:
        """Yield the steps of a segment from their rows, and what is watched at their ends; `count` of them were taken.

        Raises
        ------
        StuckError
            After the last one, if the status is not 0, or all segments together have taken too many.
        """
        n, passed = self.motion.states, self.energies
        for row, watched in zip(rows, found, strict=True):
            points, energies = row[2 + n : 2 + 4 * n].reshape(3, n), row[2 + 4 * n :]
            demand = self._demand(watched)
            assert self.demand is not None
            self.last = Step(row[0], row[1], row[2 : 2 + n], points, energies - passed, self.demand, demand)
            self.demand, passed = demand, energies
            yield self.last
        self.energies = passed
        self.taken, self.done = self.taken + count, self.done + 1
        many = status == 2 or self.taken > collocation.CALLS + collocation.CALLS_EACH * self.done
        if status or many:
            raise StuckError(begin if self.last is None else self.last.end, many)

    def _demand(self, watched: np.ndarray) -> np.ndarray:
        """Demands, with those that the system watches at the handle."""
        count = len(self.system.mechanics.demands)
        if self.system.watch is None:
            return watched[:count].copy()
        return np.concatenate([watched[:count], self.system.watch(watched[None, count:])[0]])

    def given(self, bounds: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Numbers of pieces of segments between bounds, in which what acts from outside is cubic; then the ends of the pieces,
        the inputs there, of which those that are commanded are left open, and their rates."""
        begins, widths, inner = bounds[:-1], np.diff(bounds), slice(self.motion.inputs - self.outside, None)
        count = len(widths)
        pieces, times = np.ones(count, dtype=np.int32), np.stack([begins, bounds[1:]], axis=1).ravel()
        inputs, rates = np.empty((2 * count, self.motion.inputs)), np.zeros((2 * count, self.motion.inputs))
        if self.fixed:
            inputs[:, inner] = self._outside(bounds[:1])
            return pieces, times, inputs, rates
        rows = self._outside((begins[:, None] + widths[:, None] * _SHARES).ravel()).reshape(count, len(_SHARES), -1)
        smooth = ~_jumps(rows)
        inputs[:, inner] = (_ENDS @ rows[:, :4]).reshape(2 * count, -1)
        rates[:, inner] = (_SLOPES @ rows[:, :4] / widths[:, None, None]).reshape(2 * count, -1)
        if smooth.all():
            return pieces, times, inputs, rates
        parts = []
        for place in range(count):
            own = slice(2 * place, 2 * place + 2)
            parts.append((times[own], inputs[own], rates[own]))
            if not smooth[place]:
                halves, values, slopes = self._halved(bounds[place], bounds[place + 1])
                pieces[place] = len(halves) - 1
                wide = np.empty((len(halves), self.motion.inputs)), np.zeros((len(halves), self.motion.inputs))
                wide[0][:, inner], wide[1][:, inner] = values, slopes
                parts[-1] = halves, *wide
        times, inputs, rates = (np.concatenate(some) for some in zip(*parts, strict=True))
        return pieces, times, inputs, rates

    def _halved(self, begin: float, end: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ends of the pieces of one segment, and what acts from outside there with its rates."""
        bounds, values, slopes = [begin], [], []
        waiting = [(begin, end, 0)]
        while waiting:
            first, last, halved = waiting.pop()
            width = last - first
            rows = self._outside(first + width * _SHARES)
            jumps = _jumps(rows)
            if jumps and halved < _HALVINGS:
                middle = 0.5 * (first + last)
                waiting += [(middle, last, halved + 1), (first, middle, halved + 1)]
                continue
            bounds.append(last)
            values.append(rows[[0, 3]] if jumps else _ENDS @ rows[:4])
            slopes.append(None if jumps else _SLOPES @ rows[:4] / width)
        return (
            np.array(bounds),
            np.array([values[0][0], *(one[1] for one in values)]),
            _at_bounds(slopes, values[0][0]),
        )

    def _outside(self, time: np.ndarray) -> np.ndarray:
        """What acts from outside at rows of time, side by side."""
        found = [one.reshape(len(time), -1) for one in self.system.outside(time) if one is not None]
        return np.concatenate(found, axis=1) if found else np.zeros((len(time), 0))


def _functions(system: System) -> list[Any]:
    """What may change over time."""
    arm = None if system.hand is None else system.hand.arm
    return [system.wrench, system.angles, None if system.hand is None else system.hand.force, arm and arm.intention]


def _jumps(rows: np.ndarray) -> np.ndarray:
    """Whether what acts from outside, at the instants of pieces (..., 5, d), is no cubic. (...,)"""
    missed = np.abs(_CHECK @ rows[..., :4, :] - rows[..., 4, :])
    return (missed > _SMOOTH * (_SMALL + np.abs(rows[..., 4, :]))).any(axis=-1)


def _at_bounds(slopes: list[np.ndarray | None], like: np.ndarray) -> np.ndarray:
    """Slopes at the bounds of pieces: those of the piece before, or of the one after where inputs jump."""
    found = [np.zeros_like(like)] * (len(slopes) + 1)
    for place, one in reversed(list(enumerate(slopes))):
        if one is not None:
            found[place] = one[0]
    for place, one in enumerate(slopes):
        if one is not None:
            found[place + 1] = one[1]
    return np.array(found)
