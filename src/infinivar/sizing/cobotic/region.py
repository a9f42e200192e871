"""The points of a required region at which cobotic drives are searched and judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infinivar.sizing.geared.tasks import RegionTask

_EDGE = 60
"""Most points of the edge of a quadrant of the required region at which wheel designs are searched."""
_INSIDE = 10_000
"""Points inside the required region, about, at which the designs found are judged."""


def outer(task: RegionTask) -> RegionTask:
    """Some points of the edge of a required region: where it lets speed and force be largest.

    With the force in one direction the wheel needs the more lateral force and the larger angle, and the cylinder the more
    torque, the larger speed and force are; the designs found are judged inside as well.
    """
    some = [edge[np.unique(np.linspace(0, len(edge) - 1, _EDGE).astype(int))] for edge in _edges(task)]
    return _at(task, np.concatenate(some))


def judged(task: RegionTask) -> RegionTask:
    """The whole edge of a required region, and a grid inside."""
    inside = np.arange(0, len(task.speed), 1 + len(task.speed) // _INSIDE)
    return _at(task, np.unique(np.concatenate([inside, *_edges(task)])))


def _at(task: RegionTask, places: np.ndarray) -> RegionTask:
    return replace(task, speed=task.speed[places], force=task.force[places])


def _edges(task: RegionTask) -> list[np.ndarray]:
    """Points of each quadrant of which no other is beyond them in both speed and force, by falling force."""
    quadrant = np.signbit(task.speed) * 2 + np.signbit(task.force)
    found = []
    for one in np.unique(quadrant):
        here = np.flatnonzero(quadrant == one)
        speed, force = np.abs(task.speed[here]), np.abs(task.force[here])
        order = np.lexsort((-speed, -force))
        before = np.concatenate([[-np.inf], np.maximum.accumulate(speed[order])[:-1]])
        found.append(here[order[speed[order] > before]])
    return found
