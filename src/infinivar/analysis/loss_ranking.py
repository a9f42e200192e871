"""Which drive loses least at each operating point of the force-speed plane, and by how many watts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.arrays import real_array
from infinivar._core.described import derived, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis.plane import of_study, path
from infinivar.analysis.steady_map import SteadyMap, steady_map
from infinivar.axis import LINEAR, PLANE, Axis, force_axis, speed_axis
from infinivar.drivetrain.drive import Drive, DrivePoint, operated
from infinivar.errors import InputError
from infinivar.limits import Limit, binding, codes
from infinivar.study.check import check_study
from infinivar.study.requirement import Requirement
from infinivar.study.study import Study
from infinivar.units import plain

NONE, EQUAL = -1, -2
"""Indices that stand for no drive, and for two or more drives with the same loss."""

_SAME = 1e-6
"""Losses that differ by a smaller share count as the same. Drives that burn all the power of a load lose the same."""

_MOST_INSTANTS = 500
"""Instants of a motion on the plane, at equal steps of time."""


@result
class Crossing(Frozen):
    """A duty cycle on the plane, at equal steps of time.

    Attributes
    ----------
    speed, force : (k,) float   Of the load; the force includes the load's inertia. [m/s], [N], or [rad/s], [N m]
    best : (k,) int             Index of the drive that loses least; -1 where none is feasible, -2 where several lose the same.
    share                       Share of the time in which each drive alone loses least, by drive. [-]
    """

    title: str
    speed: np.ndarray
    force: np.ndarray
    best: np.ndarray
    share: Mapping[str, float]


def _drives(found: LeastLoss) -> dict[str, Any]:
    """CF attributes that explain the indices of drives."""
    return {"flag_values": np.arange(len(found.titles), dtype=np.int8), "flag_meanings": " ".join(found.titles)}


@result
class LeastLoss(Result):
    """The drive with the least loss at each point of a grid, in steady operation within every limit.

    Attributes
    ----------
    titles                    Titles of the drives by name; arrays count drives in this order, from 0.
    speed, force : (n,), (m,) float   Axes. [m/s], [N], or [rad/s], [N m] about a joint
    best : (n, m) int         Drive with the least loss; -1 where none is feasible, -2 where several lose the same.
    runner_up : (n, m) int    Drive with the second least loss; -1 where fewer than two drives are feasible.
    loss : (n, m) float       Loss of the best drive, from supply to load; nan where no drive is feasible. [W]
    saved : (n, m) float      Loss of the runner-up minus that of the best; nan where fewer than two drives are feasible. [W]
    limit : (n, m) int        Where no drive is feasible, the tightest limit of the drive that comes closest; else `Limit.OK`.
    requirement               The study's requirement, if any.
    motions                   The study's duty cycles on the plane, by name.
    axis : Axis               Whether the load moves along a line or about a joint.
    """

    titles: Mapping[str, str]
    speed: np.ndarray = speed_axis()
    force: np.ndarray = force_axis()
    best: np.ndarray = reported("1", "drive with the least loss; -1 if none is feasible", PLANE, notes=_drives)
    runner_up: np.ndarray = reported("1", "drive with the next least loss; -1 if none", PLANE, notes=_drives)
    loss: np.ndarray = reported("W", "loss of the best drive", PLANE)
    saved: np.ndarray = reported("W", "loss of the runner-up minus that of the best drive", PLANE)
    limit: np.ndarray = reported("1", "limit where no drive is feasible", PLANE, notes=codes)
    motions: Mapping[str, Crossing]
    requirement: Requirement | None = None
    axis: Axis = LINEAR

    @derived("1", "1 in the required region", PLANE, convert=np.int8)
    def required(self) -> np.ndarray:
        """Whether a point is in the required region, (n, m) bool; false everywhere without a requirement."""
        if self.requirement is None:
            return np.zeros(self.best.shape, dtype=bool)
        return self.requirement.contains(self.speed[:, None], self.force[None, :])

    @derived()
    def shares(self) -> dict[str, float]:
        """Share of the required region, or without one of the grid, in which each drive alone loses least, by drive. [-]"""
        return _shares(self._counted, self.titles)

    @derived("W")
    def _largest_saving(self) -> float | None:
        known = np.isfinite(self.saved)
        return float(self.saved[known].max()) if known.any() else None

    @derived()
    def _duty(self) -> dict[str, Mapping[str, float]]:
        """The share of each motion, by task."""
        return {task: motion.share for task, motion in self.motions.items()}

    @property
    def _counted(self) -> np.ndarray:
        """`best` in the required region, or without one on the grid."""
        return self.best[self.required] if self.required.any() else self.best

    @derived()
    def verdict(self) -> str:
        """One sentence: where each drive loses least, by share."""
        clauses = []
        if self.required.any() or not self.motions:
            where = "by share of the required region" if self.required.any() else "by share of the map"
            clauses.append(_words(self._counted, self.titles, where))
        clauses += [
            _words(motion.best, self.titles, f"by share of the time in {motion.title}")
            for motion in self.motions.values()
        ]
        return f"least loss {'; '.join(clauses)}"


def least_loss(
    study: Study, *, speed: Any = None, force: Any = None, maps: Mapping[str, SteadyMap] | None = None
) -> LeastLoss:
    """Find the drive with the least loss over the force-speed plane.

    Parameters
    ----------
    study : Study          Two or more drives; its requirement and duty cycles span the plane and are shown on it.
    speed, force : (n,), (m,) float   Axes; by default cells that reach 1.4 times as far as the requirement and the motions.
        [m/s], [N], or [rad/s], [N m] about a joint
    maps                   Maps of all drives by name; used instead of new ones if their axes are the same.

    Returns
    -------
    LeastLoss   Losses of steady operation, so without the energy that accelerates the drive's own inertias; limits are those of
        continuous operation, which a motion may exceed for a moment. On the grid, springs and linkages are at position 0.

    Raises
    ------
    InputError
        If the study has a single drive, or only one of `speed` and `force` is given.
    """
    check_study(study)
    if len(study.drives) < 2:
        raise InputError("least_loss: the study has one drive; it takes two to find the one that loses less")
    if (speed is None) != (force is None):
        raise InputError("least_loss: state both speed and force, or neither")
    if speed is None:
        speed, force = of_study(study).axes()
    speed, force = (np.array(real_array(name, axis), ndmin=1) for name, axis in (("speed", speed), ("force", force)))
    found = [_map_of(drive, speed, force, (maps or {}).get(name)) for name, drive in study.drives.items()]
    best, runner_up, loss, saved = ranked(
        np.stack([one.power_in - one.power_out for one in found]), np.stack([one.limit == Limit.OK for one in found])
    )
    closest = np.argmax(np.stack([one.margin for one in found]), axis=0)
    limit = np.take_along_axis(np.stack([one.limit for one in found]), closest[None], axis=0)[0]
    return LeastLoss(
        titles=FrozenDict(study.titles),
        speed=speed,
        force=force,
        best=best,
        runner_up=runner_up,
        loss=loss,
        saved=saved,
        limit=np.where(best == NONE, limit, int(Limit.OK)).astype(np.int8),
        requirement=study.requirement,
        motions=FrozenDict({task: _crossing(study, task) for task in study.duty}),
        axis=study.axis,
    )


def ranked(losses: np.ndarray, feasible: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rank drives by loss at each point.

    Parameters
    ----------
    losses, feasible : (drives, ...)   Loss of each drive [W], and whether it is within every limit.

    Returns
    -------
    best, runner_up : (...) int   Indices; -1 where no drive is feasible, and where fewer than two are; `best` is -2 where it
        loses the same as the runner-up.
    loss, saved : (...) float     Loss of the best, and how much less that is than the runner-up's; nan likewise. [W]
    """
    counted = np.where(feasible, losses, np.inf)
    order = np.argsort(counted, axis=0, kind="stable")
    sizes = np.take_along_axis(counted, order, axis=0)
    count = feasible.sum(axis=0)
    first = np.where(count > 0, sizes[0], np.nan)
    second = np.where(count > 1, sizes[1], np.nan)
    same = second - first <= _SAME * np.abs(first)
    return (
        np.where(same, EQUAL, np.where(count > 0, order[0], NONE)).astype(np.int8),
        np.where(count > 1, order[1], NONE).astype(np.int8),
        first,
        second - first,
    )


def _map_of(drive: Drive, speed: np.ndarray, force: np.ndarray, known: SteadyMap | None) -> SteadyMap:
    """A drive's map on these axes: the known one, if it has them."""
    if known is not None and np.array_equal(known.speed, speed) and np.array_equal(known.force, force):
        return known
    return steady_map(drive, speed, force)


def _crossing(study: Study, task: str) -> Crossing:
    """A duty cycle on the plane, with the drive that loses least at each instant in steady operation."""
    duty = study.duty[task]
    position, speed, force = path(duty, _MOST_INSTANTS)
    points = [_operated(drive, position, speed, force) for drive in study.drives.values()]
    losses = [np.broadcast_to(point.power_in - point.power_out, speed.shape) for point in points]
    feasible = [np.broadcast_to(binding(point.utilisation)[0] == Limit.OK, speed.shape) for point in points]
    best = ranked(np.stack(losses), np.stack(feasible))[0]
    share = FrozenDict(_shares(best, study.titles))
    return Crossing(title=duty.title or task, speed=speed, force=force, best=best, share=share)


def _operated(drive: Drive, position: np.ndarray, speed: np.ndarray, force: np.ndarray) -> DrivePoint:
    """Operating points of a drive; the position of the load matters only with springs or a linkage."""
    if getattr(getattr(drive, "output", None), "chain", ()):
        return operated(drive, speed=speed, force=force, position=position)
    return operated(drive, speed=speed, force=force)


def _shares(best: np.ndarray, names: Mapping[str, str]) -> dict[str, float]:
    return {name: float(np.mean(best == place)) for place, name in enumerate(names)}


def _words(best: np.ndarray, titles: Mapping[str, str], of: str) -> str:
    """Shares in words, the largest first, then where several drives lose the same and where no drive is feasible."""
    shares = sorted(_shares(best, titles).items(), key=lambda one: -one[1])
    named = [(titles[name], share) for name, share in shares]
    named += [("equal", float(np.mean(best == EQUAL))), ("no drive feasible", float(np.mean(best == NONE)))]
    return f"{of}: {', '.join(f'{title} ({plain(100 * share, 2)} %)' for title, share in named if share >= 0.005)}"
