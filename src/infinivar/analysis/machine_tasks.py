"""One machine in a task or on a path: powers, losses and limits by inverse dynamics, and at steady points.

Powers and limits count steering, rotors and moving masses; in a task as the machine passes through it at its twist. The same
without these, of steady points, is beside them.
"""

from __future__ import annotations

from collections.abc import Mapping
from operator import itemgetter

import numpy as np

from infinivar._core.described import at, derived, reported
from infinivar._core.result import Result, result
from infinivar.analysis.endurance import Endurance, endurance
from infinivar.analysis.tightest import corner_words, tight_words, vector_words
from infinivar.limits import Demand
from infinivar.machines.machine import SLOW_FRICTION, TaskPoint, unit_of
from infinivar.parts.battery import Battery
from infinivar.units import plain

_UNSPENT = 1e-6
"""Power of servos that counts as none. [W]"""


_TIGHTEST = (at("demand", key="tightest_limit", convert=itemgetter(0)), at("demand", key="part", convert=itemgetter(1)))


@result
class TaskResult(Result):
    """One machine in one task.

    Attributes
    ----------
    title : str
    pose, twist, wrench : (d,) float   In the coordinates of the machine; the wrench on the load.
    corners : (m, d) float             Wrenches at which limits are judged: the task's own, corners of its polytope, and points
        between them if the machine has one coordinate.
    point : TaskPoint                  At the task's own wrench, in motion.
    steady : TaskPoint                 The same as a steady point, without steering, rotors and moving masses.
    load_turns : float                 Largest angle by which the wrench turns a wheel of the machine at rest; nan without
        steering or at a twist. [rad]
    load_work : float                  Work of the servos against friction as it does. [J]
    bears : float                      Share of the wrenches with which all limits hold, 0 where they do not even without; nan
                                       where all of them are borne, or without any. [-]
    demand : (Limit, part)             The tightest limit over all of them.
    margin : float                     Allowance over demand there; below 1 if infeasible. [-]
    corner : int                       The corner at which it is the tightest.
    battery : Battery or None          Of the machine.
    audit_residual : float             Largest relative residual of the power balance. [-]
    """

    title: str = reported()
    coordinates: tuple[str, ...]
    pose: np.ndarray
    twist: np.ndarray
    wrench: np.ndarray
    corners: np.ndarray
    point: TaskPoint
    steady: TaskPoint
    demand: Demand
    margin: float = reported("1")
    corner: int
    audit_residual: float = reported("1")
    load_turns: float = reported("rad", default=float("nan"))
    load_work: float = reported("J", default=float("nan"))
    battery: Battery | None = None
    bears: float = reported("1", default=float("nan"))

    _also = (*_TIGHTEST, at("point.power_out", "W"), at("point.efficiency", "1"), at("point.stored", "W"))

    @derived()
    def feasible(self) -> bool:
        """Whether every wrench of the polytope is within all limits."""
        return self.margin >= 1.0

    @derived("W", key="power_in_W")
    def mean_power(self) -> float:
        """Power from all sources under the task's own wrench. [W]"""
        return float(self.point.power_in)

    @derived("W")
    def steady_power(self) -> float:
        """The same of the steady point. [W]"""
        return float(self.steady.power_in)

    @property
    def controlled_power(self) -> float:
        """The same as the mean power: a machine that passes at its twist, or holds, has no slow part of its motion. [W]"""
        return self.mean_power

    @derived("W")
    def steering_power(self) -> float:
        """What steering loses; 0 where it does not count. [W]"""
        return _steering(self.losses)

    @property
    def servo_words(self) -> str:
        """What the servos do while the machine holds; empty at a twist, and where steering does not count."""
        if np.any(self.twist) or "steering winding" not in self.losses:
            return ""
        spent = self.steering_power
        said = f"servos {plain(spent, 3)} W" if spent > _UNSPENT else "servos 0 W, as friction holds the wheels"
        if not self.load_work > 0.0:
            return said
        turned = plain(float(np.degrees(self.load_turns)), 2)
        return f"{said}; taking up the load turns them by {turned}°, {plain(1e3 * self.load_work, 2)} mJ"

    @derived(optional=True)
    def endurance(self) -> Endurance | None:
        """What the battery is enough for, of a machine that has one."""
        return endurance(self.battery, self.mean_power, self.coordinates, self.twist)

    @property
    def battery_words(self) -> str:
        """How long the battery lasts; empty without one."""
        return "" if self.endurance is None else self.endurance.words

    @derived("W")
    def losses(self) -> dict[str, float]:
        """By name. [W]"""
        return {name: float(loss) for name, loss in self.point.losses.items()}

    @property
    def tightest_words(self) -> str:
        """The tightest limit, with its margin, and where if other wrenches are required."""
        where = "" if self.corner == 0 else f" at {corner_words(self.coordinates, self.corners[self.corner], 'wrench')}"
        return tight_words(self.demand, self.margin) + where + _bears_words(self.bears)

    @derived()
    def _parts(self) -> dict[str, dict[str, float]]:
        """Force, speed, steering angle and loss of each part."""
        found = self.point
        values = zip(found.part_forces, found.part_speeds, found.steering, found.part_losses, strict=True)
        names = ("force", "speed", "steering_rad", "loss_W")
        return {
            part: dict(zip(names, map(float, row), strict=True)) for part, row in zip(found.parts, values, strict=True)
        }


@result
class PathResult(Result):
    """One machine on one path.

    Attributes
    ----------
    title, per : str                   Name, and what energies refer to.
    period : float                     [s]
    time : (t,) float                  [s]
    pose, twist, wrench : (t, d) float In the coordinates of the machine.
    point : TaskPoint                  At each instant.
    steady : TaskPoint                 The same as steady points, without steering, rotors and moving masses.
    demands : (Limit, part) to float   Over the path: root mean squares of heating, peaks of all else. [-]
    demand, margin                     The tightest of them.
    instant : int                      Where on the path it is the tightest; -1 for one that counts over the whole path.
    battery : Battery or None          Of the machine.
    bears : float                      As that of a task.
    audit_residual : float             [-]
    """

    title: str = reported()
    per: str
    coordinates: tuple[str, ...]
    period: float = reported("s")
    time: np.ndarray
    pose: np.ndarray
    twist: np.ndarray
    wrench: np.ndarray
    point: TaskPoint
    steady: TaskPoint
    demands: Mapping[Demand, float]
    demand: Demand
    margin: float = reported("1")
    instant: int = -1
    battery: Battery | None = None
    audit_residual: float = reported("1")
    bears: float = reported("1", default=float("nan"))

    _also = _TIGHTEST

    @derived()
    def feasible(self) -> bool:
        """Whether all limits hold over the path."""
        return self.margin >= 1.0

    @derived("W")
    def mean_power(self) -> float:
        """Mean power from all sources; nan where a wheel slips or the machine does not reach. [W]"""
        return float(np.mean(self.point.power_in))

    @derived("W")
    def steady_power(self) -> float:
        """The same of steady points. [W]"""
        return float(np.mean(self.steady.power_in))

    @derived("W")
    def controlled_power(self) -> float:
        """Mean power with the friction of simulations, which falls below their stick speed. [W]

        The other powers count friction in full at any speed.
        """
        return self.mean_power + float(np.mean(self.point.states.get(SLOW_FRICTION, 0.0)))

    @derived("W")
    def steering_power(self) -> float:
        """Mean of what steering loses; 0 where it does not count. [W]"""
        return _steering(self.losses)

    @property
    def servo_words(self) -> str:
        """Empty: a path is no held task."""
        return ""

    @derived(optional=True)
    def endurance(self) -> Endurance | None:
        """As that of a task, with the share that the path draws."""
        return endurance(self.battery, self.mean_power, self.coordinates, self.twist, self.period)

    @property
    def battery_words(self) -> str:
        """How long the battery lasts; empty without one."""
        return "" if self.endurance is None else self.endurance.words

    @derived("J")
    def energy(self) -> float:
        """Energy from the source over the period. [J]"""
        return self.mean_power * self.period

    @derived("W")
    def _peak_power(self) -> float:
        return float(np.max(self.point.power_in))

    @derived("W", key="mean_losses_W")
    def losses(self) -> dict[str, float]:
        """Means, by name. [W]"""
        return {name: float(np.mean(loss)) for name, loss in self.point.losses.items()}

    @property
    def tightest_words(self) -> str:
        """The tightest limit, with its margin; if it is exceeded, where on the path, and what the machine bears."""
        where = ""
        if not self.feasible and self.instant >= 0:
            pose = ", ".join(vector_words(self.coordinates, self.pose[self.instant], "pose"))
            where = f" at {plain(float(self.time[self.instant]), 3)} s{f' ({pose})' if pose else ''}"
        return tight_words(self.demand, self.margin) + where + _bears_words(self.bears)

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Histories for a data file, by name with unit."""
        found = {"time_s": self.time}
        for what in ("pose", "twist", "wrench"):
            for place, name in enumerate(self.coordinates):
                unit = unit_of(name, what).replace("/", "_").replace(" ", "")
                found[f"{what}_{name}_{unit}"] = getattr(self, what)[:, place]
        return {
            **found,
            "power_in_W": np.asarray(self.point.power_in),
            "power_out_W": np.asarray(self.point.power_out),
            "steady_power_in_W": np.asarray(self.steady.power_in),
            **{f"loss_{name.replace(' ', '_')}_W": np.asarray(loss) for name, loss in self.point.losses.items()},
        }


def _bears_words(bears: float) -> str:
    """What of its load a machine bears, if not all."""
    return f"; bears {100 * bears:.0f} % of its load" if bears > 0.0 else ""


def _steering(losses: Mapping[str, float]) -> float:
    return sum(loss for name, loss in losses.items() if name.startswith("steering "))
