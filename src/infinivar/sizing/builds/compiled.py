"""Builds of designs compiled by JAX: the same laws with the same numbers, to rounding; designs of one structure compile once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from infinivar._core import engine, extras
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import is_part, quantities_of, value_at, walk, with_values
from infinivar.limits import Demand
from infinivar.parts.motor import Motor
from infinivar.sizing.builds.evaluation import built, points
from infinivar.sizing.geared.sampled import Laws
from infinivar.sizing.geared.tasks import MotionTask

TOGETHER = 64
"""Builds of one call, the last padded: arrays of one shape are compiled once."""


def available() -> bool:
    """Whether JAX is installed."""
    return extras.there("jax")


def structure(drive: Any) -> tuple[Any, ...]:
    """What two drives must have in common to be computed by one compiled function: all but numbers and names."""
    found: list[Any] = [type(drive).__qualname__]
    for place in walk(drive):
        if "unit" in place.field.metadata:
            found.append(place.path)
        elif place.field.name != "name":
            kind = type(place.value)
            found.append((place.path, kind.__qualname__ if is_part(kind) else repr(place.value)))
    return tuple(found)


class CompiledBuilds:
    """Laws of designs of one structure, compiled for each task at the first call.

    Parameters
    ----------
    drives : sequence         Of one structure, of which numbers differ.
    paths : sequence of str   Of values that differ from build to build.
    """

    def __init__(self, drives: Sequence[Any], paths: Sequence[str]) -> None:
        """Find what differs; compile nothing yet."""
        self._base, self._jax = drives[0], extras.load("jax", "jax", "compiled builds")
        self._known: dict[tuple[str, str], Callable[..., Any]] = {}
        # A motor is checked as a whole where its values are numbers, so that all of them count as unknown or none.
        self.paths = [
            path
            for path in quantities_of(self._base)
            if isinstance(value_at(self._base, path.rpartition(".")[0]) if "." in path else None, Motor)
            or len({value_at(drive, path) for drive in drives}) > 1
        ]
        self.varied = tuple(paths)

    def laws(self, drive: Any, columns: Mapping[str, np.ndarray]) -> Laws:
        """Laws of some builds of a design: arrays of shape (count, 1) by path."""
        return _CompiledLaws(self, drive, columns)

    def call(self, name: str, task: MotionTask, drive: Any, columns: Mapping[str, np.ndarray], *more: Any) -> Any:
        """Call a method of `Laws` for a task, for `TOGETHER` builds."""
        if (name, task.name) not in self._known:

            def law(own: Mapping[str, Array], values: Mapping[str, Array], *more: Any) -> Any:
                made = built(with_values(self._base, own), values)
                found = getattr(Laws(made, TOGETHER), name)(task, *more)
                lengths = {"heat_sources": (TOGETHER, points(task))}.get(name, (TOGETHER,))
                return self._jax.tree.map(lambda part: namespace(part).broadcast_to(part, lengths), found)

            self._known[name, task.name] = self._jax.jit(law)
        own = {path: float(value_at(drive, path)) for path in self.paths}
        with engine.local(self._jax):
            return self._jax.tree.map(np.asarray, self._known[name, task.name](own, dict(columns), *more))


class _CompiledLaws(Laws):
    """Laws of some builds of one design, padded to the number for which functions are compiled; a region has few points."""

    def __init__(self, compiled: CompiledBuilds, drive: Any, columns: Mapping[str, np.ndarray]) -> None:
        count = len(next(iter(columns.values())))
        super().__init__(built(drive, columns), count)
        self._compiled, self._design = compiled, drive
        self._padded = {path: _padded(column) for path, column in columns.items()}

    def heat_sources(self, task: MotionTask) -> dict[str, tuple[Array, Array]]:
        """As `Laws.heat_sources`."""
        return self._rows(self._compiled.call("heat_sources", task, self._design, self._padded))

    def over(self, task: MotionTask, warm: Mapping[str, Array]) -> tuple[dict[Demand, Array], Array]:
        """As `Laws.over`."""
        padded = {what: _padded(np.asarray(one)) for what, one in warm.items()}
        demands, power = self._compiled.call("over", task, self._design, self._padded, padded)
        return self._rows(demands), power[: self.count]

    def _rows(self, found: Any) -> Any:
        return {
            key: tuple(one[: self.count] for one in part) if isinstance(part, tuple) else part[: self.count]
            for key, part in found.items()
        }


def _padded(column: np.ndarray) -> np.ndarray:
    """A column with its last row repeated; what pads it is computed and left out."""
    return column[np.minimum(np.arange(TOGETHER), len(column) - 1)]
