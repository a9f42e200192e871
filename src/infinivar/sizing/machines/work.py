"""What a machine of a study has to do, and what a design of it needs for that: the measure of every search over machines."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar._core.fields import given
from infinivar.analysis.machines import tasks_and_paths
from infinivar.analysis.performing import Prepared, power_and_demands
from infinivar.drivetrain.service import NO_SERVICE, Service
from infinivar.limits import LEADING, Limit
from infinivar.machines.links import Carried
from infinivar.sizing.design import FreeValue, SizedDrive
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.measures import mass_of
from infinivar.sizing.pool import ChosenPart
from infinivar.study.study import Study

LINKS = ("leg", "joint", "wheel")
"""What kinds of machines call a link."""

_NUMBERED = re.compile(r" \d+\b")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MachineWork:
    """Tasks and paths of a study, placed for one of its machines whose links are moved side by side.

    Attributes
    ----------
    machine    The template.
    prepared   What all machines of its geometry have in common.
    shares     Of the time, by "tasks.NAME" and "paths.NAME"; equal if the study states none. [-]
    service    Travel and largest force of one link, by which structures are sized.
    slip_margin   Slip force over lateral force of a leg's wheel that is wanted. [-]
    """

    machine: Any
    prepared: Prepared
    shares: Mapping[str, float]
    service: Service
    slip_margin: float = 1.0

    @classmethod
    def of(cls, study: Study, name: str, slip_margin: float = 1.0) -> MachineWork:
        """That of a machine of a study."""
        machine, wanted = study.drives[name], tasks_and_paths(study)
        prepared = Prepared(machine, wanted)
        shares = study.machine_shares or dict.fromkeys(wanted, 1.0 / len(wanted))
        service = _service(machine, prepared) if hasattr(machine, "link_positions") else NO_SERVICE
        return cls(
            machine=machine,
            prepared=prepared,
            shares=shares,
            service=service,
            slip_margin=slip_margin,
        )

    @property
    def carried(self) -> Carried:
        """What the links carry, all tasks and paths side by side."""
        return self.prepared.carried[0]

    @property
    def places(self) -> dict[str, slice]:
        """Instants of each task and path in it."""
        return self.prepared.carried[1]

    @property
    def sizes(self) -> dict[str, int]:
        """Instants of each path, and corners of each task."""
        return {key: one.size for key, one in self.prepared.placed.items()}

    def lasts(self, key: str) -> bool:
        """Whether it is a path, over which heating and fatigue count by their root mean square."""
        return self.prepared.placed[key].time is not None

    def name_of(self, key: str) -> str:
        """Of a task or path without its group, unless both groups have it."""
        short = key.partition(".")[2]
        return short if sum(other.partition(".")[2] == short for other in self.shares) == 1 else key

    def judged(self, machine: Any) -> tuple[float, dict[TaskDemand, float]]:
        """Mean power of a design [W], and demands over allowances, of links that are alike the worst."""
        power, demands = 0.0, dict[TaskDemand, float]()
        for key, (drawn, found) in power_and_demands(machine, self.prepared).items():
            power += self.shares[key] * drawn
            # Where a wheel slips or a pose is out of reach, other demands are undefined.
            lost = any(not found[of] <= 1.0 for of in found if of[0] in LEADING)
            for (limit, part), demand in found.items():
                if lost and np.isnan(demand) and limit not in LEADING:
                    continue
                of = self.name_of(key), limit, _NUMBERED.sub("", part)
                demand *= self.slip_margin if limit is Limit.SLIP and of[2] in LINKS else 1.0
                demands[of] = max(demands.get(of, 0.0), float("inf") if np.isnan(demand) else demand)
        return power, demands

    def design(
        self,
        template: str,
        machine: Any,
        parts: Mapping[str, ChosenPart],
        free: Mapping[str, FreeValue],
        unchecked: Any,
    ) -> SizedDrive:
        """A machine as a design: what it draws, weighs and demands."""
        power, demands = self.judged(machine)
        missing = set(unchecked)
        return SizedDrive(
            template=template,
            parts=parts,
            free=free,
            drive=machine,
            mass=mass_of(machine, self.service),
            power=power,
            volume=float("nan"),
            price=price_of(machine),
            demands={key: demand for key, demand in demands.items() if key[1:] not in missing},
            unchecked=tuple(unchecked),
        )


def price_of(machine: Any) -> float | None:
    """Price of all motors and gearheads of a machine, in the currency in which they state it; None if one does not."""
    leg, separate = getattr(machine, "leg", None), getattr(machine, "separate", None)
    own, count = leg or separate or machine, 1 if separate is None else machine.links
    each = [(part, count) for name in ("motor", "gearhead") if (part := getattr(own, name, None)) is not None]
    each += [(leg.steering.motor, machine.links)] if leg is not None and leg.steering is not None else []
    if not each or any(part.price is None for part, _ in each):
        return None
    return float(sum(count * part.price for part, count in each))


def _service(machine: Any, prepared: Prepared) -> Service:
    """What tasks and paths ask of one link; of links that turn without end, the travel of a path."""
    carried, places = prepared.carried
    force = np.abs(carried.force[1])
    pose = np.broadcast_to(carried.course.pose[2], carried.course.pose.shape[1:])
    positions = machine.link_positions(pose)
    if positions is None:
        travels = []
        for key, place in places.items():
            time = prepared.placed[key].time
            if time is not None:
                speed = np.broadcast_to(carried.speed[2], force.shape)[place]
                travels.append(np.ptp(np.cumsum(speed, axis=0), axis=0) * (time[1] - time[0]))
        positions = np.array([0.0 * travels[0], np.max(travels, axis=0)]) if travels else np.zeros((1, machine.links))
    travel = max(machine.link_travel or 0.0, float(np.nanmax(np.ptp(positions, axis=0), initial=0.0)))
    own = machine.leg or machine.separate
    known = force[np.isfinite(force)]
    return Service(given(travel or None, own.structure.travel), float(np.max(known, initial=0.0)) or None)
