"""What tasks ask of wheel designs, compiled by JAX: the same laws with the same numbers, to rounding."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from infinivar._core import engine, extras
from infinivar._core.threads import in_order
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import InputError
from infinivar.sizing.cobotic.wheels import FREE, Demanded, Look, Points, Space, ask, look
from infinivar.sizing.geared.tasks import Task

_TOGETHER = 32
"""Wheel designs of one call, the last padded: arrays of one shape are compiled once."""


class CompiledWheels:
    """The functions `ask` and `look` compiled for each task and kind of bearing, at the first call."""

    def __init__(self, space: Space) -> None:
        """Raises InputError if JAX is not installed."""
        self._space, self._jax = space, extras.load("jax", "jax", "method jax")
        self._known: dict[tuple[int, ...], Callable[..., Any]] = {}
        self._tasks: list[Task] = []

    def ask(self, points: Points, task: Task) -> Demanded:
        """As `ask` for designs whose bearings are of one kind, in NumPy arrays (k, n)."""
        return self._all(points, (-1, self._place(task)), lambda drive: ask(drive, task))

    def look(self, points: Points, tasks: Sequence[Task]) -> Look:
        """As `look` for designs whose bearings are of one kind, in NumPy arrays (k, n) and (k, 1)."""
        return self._all(points, tuple(map(self._place, tasks)), lambda drive: look(drive, tasks))

    def _place(self, task: Task) -> int:
        """Number of a task, by identity."""
        if not any(task is one for one in self._tasks):
            self._tasks.append(task)
        return next(place for place, one in enumerate(self._tasks) if one is task)

    def _all(self, points: Points, key: tuple[int, ...], law: Callable[[CoboticDrive], Any]) -> Any:
        """A law of every design, some of them at a time."""
        run, numbers = self._law(int(points.bearing[0]), key, law), self._space.numbers(int(points.bearing[0]))
        count = len(points.bearing)

        def some(start: int) -> Any:
            # What pads the last call is computed and left out.
            places = np.minimum(np.arange(start, start + _TOGETHER), count - 1)
            return run(points.values[places], *(column[points.bearing[places]] for column in numbers.values()))

        parts = list(in_order(some, range(0, count, _TOGETHER)))
        return self._jax.tree.map(lambda *some: _rows(some, count), *parts)

    def _law(self, bearing: int, key: tuple[int, ...], law: Callable[[CoboticDrive], Any]) -> Callable[..., Any]:
        """A law compiled for the kind of a bearing."""
        kind = int(self._space.kinds[bearing])
        if (kind, *key) not in self._known:
            names = tuple(self._space.numbers(bearing))

            def one(values: Any, *numbers: Any) -> Any:
                given = {name: values[place] for place, name in enumerate(FREE)}
                return law(self._space.drive(given, kind, dict(zip(names, numbers, strict=True))))

            shapes = [(_TOGETHER, len(FREE)), *((_TOGETHER,) for _ in names)]
            try:
                self._known[kind, *key] = engine.compiled(self._jax.vmap(one), shapes)
            except engine.NotCompiledError as problem:
                raise InputError(f"method jax cannot be used here: {problem}; use numpy") from None
        return self._known[kind, *key]


def _rows(parts: tuple[Any, ...], count: int) -> np.ndarray:
    """Results of all calls, (k, n), or (k, 1) for what is one number a design."""
    whole = np.concatenate(parts)[:count]
    return whole[:, None] if whole.ndim == 1 else whole
