"""Runs of machines with their controllers in compiled C: what a controller does at a sample is recorded from its Python source.

The first samples are Python's: then the controller has a memory, and what it computes from there on is a formula. Where the
formula gives no number, such as at limits that bind, Python samples, too.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from infinivar._core.c_library import library
from infinivar._core.collocation import Step
from infinivar.bondgraph.c_code import data_of, statements
from infinivar.bondgraph.recorded import Recorded
from infinivar.bondgraph.tape import Tape
from infinivar.machines.compiled import CompiledSteps, KeptSteps
from infinivar.machines.system import Inputs, Outside

_FEWEST, _MOST = 4, 128
"""Samples that are computed at once, at first and at most."""

_LONGEST_WAIT = 64
"""Samples after which the formula is tried again, at most."""

_STEPS, _ROOM = 8, 512
"""Steps a sample for which there is room, and for how many at least: after a start they are short."""


class Known(NamedTuple):
    """What is known of samples before the machine gets there; at one sample, and while it is recorded, a single row."""

    time: Any
    """[s]"""
    outside: Outside
    """What acts from outside."""
    more: np.ndarray
    """Numbers of the controller's own, such as noise or goals. (m, k)"""

    def row(self, place: int) -> Known:
        """What is known of one of the samples."""
        return Known(float(self.time[place]), self.outside.row(place), self.more[place : place + 1])


@runtime_checkable
class Recordable(Protocol):
    """A controller whose samples are a formula of numbers."""

    acting: Inputs | None
    """Inputs since the last sample."""
    saturated: Mapping[str, Any]
    """Commanded over largest current of the last sample, by motor."""

    @property
    def memory(self) -> list[np.ndarray] | None:
        """Arrays that a sample changes; can be set. None: there is no formula, or not yet."""
        ...

    def ahead(self, times: np.ndarray) -> Known:
        """What is known of the next samples."""
        ...

    def past(self, samples: int) -> None:
        """Go on behind some of them."""
        ...

    def act(self, known: Known, state: np.ndarray, acceleration: np.ndarray) -> Inputs:
        """Inputs until the next sample, from a row of what is known, and the state with the acceleration of its rates."""
        ...


class Segment(NamedTuple):
    """What happened from a sample to the next one."""

    inputs: Inputs
    saturated: dict[str, float]
    steps: Iterator[Step]
    """As they are asked for."""
    state: np.ndarray
    """At the end."""


class _Law(NamedTuple):
    """A controller in C."""

    text: str
    numbers: np.ndarray
    tables: np.ndarray
    known: int
    said: tuple[str, ...]


class _Controller(ctypes.Structure):
    _fields_ = [
        ("law", ctypes.c_void_p),
        ("c", ctypes.c_void_p),
        ("tables", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in ("known", "own", "memory", "said", "feels")),
    ]


def flat(known: Known) -> np.ndarray:
    """Rows of what is known: the time, what acts from outside, and more. (m, k)"""
    outside = (one.reshape(len(known.time), -1) for one in known.outside if one is not None)
    return np.concatenate([known.time[:, None], *outside, known.more], axis=1)


class Formula(NamedTuple):
    """What a controller does at a sample, on a tape whose inputs are what is known, derivatives of the states, the states, and
    the controller's memory."""

    tape: Tape
    known: int
    """How many numbers are known ahead of a sample."""
    inputs: Inputs
    memory: list[np.ndarray]
    said: dict[str, Any]


NO_FORMULA = (TypeError, AttributeError, ValueError, KeyError, IndexError, np.linalg.LinAlgError)
"""What is raised where a law decides by a value, or calls what the tape has not."""


def formula(controller: Any, states: int, rates: slice, time: float, *, feels: bool = True) -> Formula:
    """The formula of what a controller does at a sample.

    Parameters
    ----------
    controller : Recordable   With a memory.
    states : int              Number of states.
    rates : slice             Those whose derivatives are accelerations.
    time : float              Of the next sample. [s]
    feels : bool              Whether derivatives are among the inputs; else they are 0.

    Raises
    ------
    NO_FORMULA
        If it has none.
    """
    memory = controller.memory
    known = controller.ahead(np.array([time]))
    count = flat(known).shape[1]
    tape = Tape({})
    read = count + (1 + feels) * states + sum(map(np.size, memory))
    given = iter([tape.input("inputs", place) for place in range(read)])

    def like(array: Any) -> Recorded:
        return Recorded(
            tape, np.reshape(np.array([next(given) for _ in range(np.size(array))], object), np.shape(array))
        )

    before = controller.acting, dict(controller.saturated)
    try:
        now = Known(
            next(given), Outside(*(None if one is None else like(one) for one in known.outside)), like(known.more)
        )
        slopes = like(np.zeros(states)) if feels else Recorded(tape, np.zeros(states))
        state = like(np.zeros(states))
        controller.memory = [like(one) for one in memory]
        inputs = controller.act(now, state, slopes[rates])
        return Formula(tape, count, inputs, list(controller.memory), dict(controller.saturated))
    finally:
        controller.acting, controller.memory = before[0], memory
        controller.saturated.clear()
        controller.saturated.update(before[1])


def numbers_of(arrays: Iterable[Any]) -> list[Any]:
    """Numbers and values of arrays, in order."""
    return [one for each in arrays for one in np.ravel(np.asarray(each, dtype=object)).tolist()]


def recorded(controller: Any, states: int, rates: slice, time: float) -> _Law | None:
    """C of what a controller does at a sample; None if it has no formula. Arguments as of `formula`."""
    numbers: list[float] = []
    try:
        found = formula(controller, states, rates, time)
        results = numbers_of([*found.inputs, *found.memory, *found.said.values()])
        body = statements(found.tape, results, "y", numbers)
    except NO_FORMULA:
        return None
    text = "\n".join(
        [
            "#include <math.h>",
            "",
            "static const double settled[] = {1e-12};",
            "",
            "void controlled(const double *c, const double *p, const double *u, double *y)",
            "{",
            "    (void)c; (void)p; (void)u; (void)y; (void)settled;",
            *body,
            "}",
            "",
        ]
    )
    tables = np.append(data_of(found.tape), 0.0)
    return _Law(text, np.array([*numbers, 0.0]), tables, found.known, tuple(found.said))


@dataclass(slots=True)
class SampledSteps:
    """A motion with its controller, many samples at a time."""

    steps: CompiledSteps
    controller: Any
    size: int = _FEWEST
    """Samples to compute at once."""
    wait: int = 0
    """Samples to leave to Python."""
    waited: int = 1
    law: _Law | None = field(init=False, default=None)
    tried: bool = field(init=False, default=False)
    by: _Controller = field(init=False)

    def over(self, bounds: np.ndarray, state: np.ndarray) -> Iterator[Segment]:
        """Yield the first segments between bounds: as many as the formula is good for, at least none."""
        if self.wait > 0:
            self.wait -= 1
            return
        if not self.tried and self.controller.memory is not None:
            self._begin(float(bounds[0]))
        if self.law is None:
            return
        bounds = bounds[: self.size + 1]
        done, found = self._marched(bounds, state)
        whole = done == len(bounds) - 1
        self.size = min(2 * self.size, _MOST) if whole else _FEWEST
        self.waited = 1 if whole else min(2 * self.waited, _LONGEST_WAIT)
        self.wait = 0 if whole else self.waited
        yield from found

    def _begin(self, time: float) -> None:
        self.tried = True
        first, second, _ = self.steps.system.places
        law = recorded(self.controller, self.steps.motion.states, slice(first, second), time)
        made = None if law is None else library(law.text)
        if law is None or made is None:
            return
        self.law, memory = law, self.controller.memory
        hand = self.steps.system.hand
        self.by = _Controller(
            ctypes.cast(made.controlled, ctypes.c_void_p).value,
            law.numbers.ctypes.data,
            law.tables.ctypes.data,
            law.known,
            self.steps.motion.inputs - self.steps.outside,
            sum(map(np.size, memory)),
            len(law.said),
            int(hand is not None and hand.arm is not None),
        )

    def _marched(self, bounds: np.ndarray, state: np.ndarray) -> tuple[int, Iterator[Segment]]:
        """Number of segments that are complete, and these."""
        assert self.law is not None
        steps, controller, by, motion = self.steps, self.controller, self.by, self.steps.motion
        count, wide = len(bounds) - 1, self.by.own + self.by.memory + self.by.said
        known = np.ascontiguousarray(flat(controller.ahead(bounds[:-1])))
        pieces, times, inputs, rates = steps.given(bounds)
        x = np.concatenate([state, steps.energies])
        kept = np.concatenate([*map(np.ravel, (*controller.acting, *controller.memory)), np.zeros(by.said + 1)])
        held, ends = np.empty((count, wide)), np.empty((count, len(x)))
        taken = np.zeros(count, dtype=np.int32)
        room = max(_STEPS * count, _ROOM)
        rows, found = np.empty((room, steps.steps.shape[1])), np.empty((room, motion.watched))
        reached = np.empty((int(pieces.max()), len(x)))
        work = np.empty(by.known + 2 * motion.states + by.memory + 1)
        record = KeptSteps(0, len(rows), rows.ctypes.data)
        at = [one.ctypes.data for one in (pieces, known, times, inputs, rates)]
        after = [one.ctypes.data for one in (steps.absolute, steps.width, x, kept, held, ends, taken)]
        last = [one.ctypes.data for one in (found, reached, work)]
        done = motion.library.march_watched(
            motion.given.ctypes.data, motion.constants.ctypes.data, ctypes.addressof(by), count, *at, steps.relative,
            *after, ctypes.addressof(record), *last,
        )  # fmt: skip
        if done:
            row = held[done - 1 : done]
            inputs, memory = _split(row, controller.acting), _split(row[:, by.own :], controller.memory)
            controller.acting, controller.memory = Inputs(*(one[0] for one in inputs)), [one[0] for one in memory]
            controller.saturated.update(zip(self.law.said, held[done - 1, wide - by.said :].tolist(), strict=True))
            controller.past(done)
        return done, self._segments(bounds[:-1], held[:done], ends, taken, rows, found)

    def _segments(
        self,
        begins: np.ndarray,
        held: np.ndarray,
        ends: np.ndarray,
        taken: np.ndarray,
        rows: np.ndarray,
        found: np.ndarray,
    ) -> Iterator[Segment]:
        """Yield the segments that are complete, from rows of what was held in each."""
        assert self.law is not None
        inputs = _split(held[:, : self.by.own], self.controller.acting)
        said, first = held[:, held.shape[1] - self.by.said :].tolist(), 0
        for place, one in enumerate(zip(*inputs, strict=True)):
            own = slice(first, first + int(taken[place]))
            first = own.stop
            steps = self.steps.steps_of(rows[own], found[own], float(begins[place]), int(taken[place]))
            yield Segment(
                Inputs(*one),
                dict(zip(self.law.said, said[place], strict=True)),
                steps,
                ends[place, : self.steps.motion.states],
            )


def _split(rows: np.ndarray, like: Iterable[np.ndarray]) -> list[np.ndarray]:
    """Arrays side by side in rows (m, ...): each with the rows first, then its shape."""
    found, place = [], 0
    for one in like:
        found.append(rows[:, place : place + np.size(one)].reshape(len(rows), *np.shape(one)))
        place += np.size(one)
    return found
