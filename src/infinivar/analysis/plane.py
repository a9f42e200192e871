"""The part of the force-speed plane that maps of a study show: around its requirement, its motions, or both."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar.axis import Axis
from infinivar.drivetrain.drive import Drive, operated
from infinivar.limits import binding
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.study.requirement import Requirement
from infinivar.study.study import Study
from infinivar.units import plain

MAP_REACH = 1.4
"""Extent of the maps relative to the requirement or the motions, so that they show limits just outside."""

MAP_CELLS = 224
"""Cells along each axis of a map. Points are cell centres: at exactly zero speed friction has no direction."""

_NOTHING = 1e-9
"""Speeds and forces below this share of the largest ones to the other side are rounding errors."""

_SEARCHED = np.geomspace(1e-4, 1e5, 541)
"""Speeds and forces tried for an axis on which neither requirement nor motion has an extent. [m/s], [N]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plane:
    """Largest speed and force of interest, and in which directions.

    Attributes
    ----------
    speed, force : float     Largest magnitudes, > 0. [m/s], [N], or [rad/s], [N m]
    low, high : (int, int)   Ends of speed and force in units of these: -1, 0 or 1.
    """

    speed: float
    force: float
    low: tuple[int, int]
    high: tuple[int, int] = (1, 1)

    @property
    def one_quadrant(self) -> bool:
        """Whether speeds and forces are positive only."""
        return self.low == (0, 0)

    def axes(self, cells: int = MAP_CELLS) -> tuple[np.ndarray, np.ndarray]:
        """Speeds and forces of a map: centres of equal cells that reach `MAP_REACH` times as far. [m/s], [N]"""
        centres = (np.arange(cells) + 0.5) / cells
        shares = [(low + (high - low) * centres) * MAP_REACH for low, high in zip(self.low, self.high, strict=True)]
        return shares[0] * self.speed, shares[1] * self.force

    def joined(self, other: Plane) -> Plane:
        """The smallest plane that contains both."""
        return Plane(
            speed=max(self.speed, other.speed),
            force=max(self.force, other.force),
            low=(min(self.low[0], other.low[0]), min(self.low[1], other.low[1])),
            high=(max(self.high[0], other.high[0]), max(self.high[1], other.high[1])),
        )


def of_requirement(requirement: Requirement) -> Plane:
    """Plane of the quadrants required."""
    low = {1: (0, 0), 2: (0, -1), 4: (-1, -1)}[requirement.quadrants]
    return Plane(speed=requirement.speed, force=requirement.force, low=low)


def of_motions(duty: Iterable[DutyCycle], drives: Iterable[Drive]) -> Plane:
    """Plane that the motions cross.

    If no motion moves the load, speeds reach the highest at which one of the drives runs without force; if no motion has a
    force, forces reach the largest that one of the drives can hold at creeping speed.
    """
    paths = [path(cycle) for cycle in duty]
    speed, force = (np.concatenate([one[place] for one in paths]) for place in (1, 2))
    drives = list(drives)
    ends = (
        _ends(speed, lambda: _reach(drives, lambda drive, tried: operated(drive, speed=tried, force=0.0))),
        _ends(force, lambda: _reach(drives, lambda drive, tried: operated(drive, speed=_SEARCHED[0], force=tried))),
    )
    return Plane(speed=ends[0][0], force=ends[1][0], low=(ends[0][1], ends[1][1]), high=(ends[0][2], ends[1][2]))


def path(duty: DutyCycle, most: int | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position and speed of the load and force on it, including its inertia, over one cycle at about `most` instants.

    In [m], [m/s], [N], or about a joint in [rad], [rad/s], [N m].
    """
    instants = duty.instants()
    thin = slice(None, None, 1 if most is None else max(1, -(-len(instants.time) // most)))
    values = instants.position, instants.course.speed, instants.course.driving_force(duty.moved_mass).value
    return tuple(np.broadcast_to(value, instants.time.shape)[thin] for value in values)  # type: ignore[return-value]


def _ends(values: np.ndarray, otherwise: Callable[[], float]) -> tuple[float, int, int]:
    """Largest magnitude of the values, and the ends of their range in units of it."""
    largest = float(np.max(np.abs(values)))
    if not largest > 0.0:
        return otherwise(), 0, 1
    low, high = float(values.min()) < -_NOTHING * largest, float(values.max()) > _NOTHING * largest
    return largest, -int(low), int(high)


def _reach(drives: list[Drive], operate: Callable[[Drive, np.ndarray], Any]) -> float:
    """Largest of the searched values at which a drive is within its limits; 1 if no drive is at any."""
    found = [_SEARCHED[binding(operate(drive, _SEARCHED).utilisation)[1] >= 1.0] for drive in drives]
    return max((float(one[-1]) for one in found if one.size), default=1.0)


def of_drives(study: Study) -> Plane:
    """Plane of the drives' maps: that of the requirement if the study states one, else that of its motions."""
    if study.requirement is not None:
        return of_requirement(study.requirement)
    return of_motions(study.duty.values(), study.drives.values())


def of_study(study: Study) -> Plane:
    """Plane that contains the requirement, if any, and the motions, if any."""
    planes = [] if study.requirement is None else [of_requirement(study.requirement)]
    if study.duty:
        planes.append(of_motions(study.duty.values(), study.drives.values()))
    first, *others = planes
    return first.joined(others[0]) if others else first


def place(axis: Axis, force: float, speed: float) -> str:
    """An operating point in words, such as "75 N, 0.4 m/s"."""
    return f"{plain(force, 3)} {axis.force_unit}, {plain(speed, 3)} {axis.speed_unit}"
