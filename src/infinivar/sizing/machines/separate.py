"""Search over machines with a geared motor for each link: every pair of motor and gearhead, at radii of the pulley."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.pareto import spread_front
from infinivar.drivetrain.drive import axis_of
from infinivar.limits import ROOT_MEAN_SQUARE
from infinivar.machines.machine import moving
from infinivar.parts.stage import OutputStage
from infinivar.sizing.design import FreeValue, SizedDrive
from infinivar.sizing.found import LimitCount
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, Candidates, candidates
from infinivar.sizing.machines.work import LINKS, MachineWork
from infinivar.sizing.margins import TaskDemand, nearest_of
from infinivar.sizing.of_geared import RANGE
from infinivar.sizing.progress import Progress
from infinivar.sizing.records import OF_FRONT, SearchRecord
from infinivar.sizing.request import Found, StudyRequest
from infinivar.sizing.tables import Objective

_RADII = 17
"""Of the whole range, in equal ratios, at which every pair is judged."""

_ROUNDS = 5
"""In which radii between the best one of a pair and its neighbours are judged."""

_BEYOND = 1e9
"""Value of a pair that exceeds a limit, times its demand over allowance."""

_NARROW = 1.3
"""Demand over allowance of pairs for which a radius between those judged is looked for."""

_CONTENDERS = 3
"""Pairs that are looked at further, over the number of designs asked for, of each objective."""

_HALVINGS = 24
_POINTS = 40_000
"""Instants of all candidates computed at once, so that intermediate arrays fit the processor's caches."""


class _Judged(NamedTuple):
    """Pairs, each at one radius. (k,) each"""

    power: np.ndarray
    """[W]"""
    mass: np.ndarray
    """[kg]"""
    demands: Mapping[TaskDemand, np.ndarray]

    @property
    def worst(self) -> np.ndarray:
        """Largest demand over allowance; inf where one has no number. [-]"""
        worst = np.max([np.zeros(len(self.power)), *self.demands.values()], axis=0)
        return np.where(np.isnan(worst), np.inf, worst)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Search:
    """Judges pairs on the links of a machine."""

    work: MachineWork
    found: Candidates
    objective: Objective
    """Of what a mass stands for: mass, or the price."""
    others: Mapping[TaskDemand, float]
    """Demands of the machine that no motor changes."""

    def judged(self, rows: np.ndarray, radii: np.ndarray) -> _Judged:
        """Pairs (k,) at radii (k,) of the pulley; nan: the template's stage."""
        carried = self.work.carried
        instants, links = carried.force.shape[1:]
        size = max(1, _POINTS // (instants * links))
        parts = [
            self._some(rows[start : start + size], radii[start : start + size]) for start in range(0, len(rows), size)
        ]
        power, mass = (np.concatenate([getattr(one, name) for one in parts]) for name in ("power", "mass"))
        keys = dict.fromkeys(key for one in parts for key in one.demands)
        return _Judged(power, mass, {key: np.concatenate([one.demands[key] for one in parts]) for key in keys})

    def _some(self, rows: np.ndarray, radii: np.ndarray) -> _Judged:
        work, carried = self.work, self.work.carried
        stage = self.stage(None if np.isnan(radii[0]) else radii[:, None])
        drives = self.found.drives(rows, stage)
        shape = len(rows), *carried.force.shape[1:]
        rim = work.machine.link_lever if axis_of(work.machine.separate).rotary else 1.0
        course = carried.motion(rim)
        flat = {
            name: np.broadcast_to(value, shape[1:]).reshape(1, -1)
            for name in ("speed", "acceleration", "jerk", "snap", "force", "force_rate", "force_curvature")
            if np.ndim(value := getattr(course, name))
        }
        with np.errstate(invalid="ignore", over="ignore"):
            point = moving(drives, replace(course, **flat))
        demands = {(task, limit, part): np.full(len(rows), one) for (task, limit, part), one in self.others.items()}
        drawn = np.sum(np.broadcast_to(point.power_in, (shape[0], shape[1] * shape[2])).reshape(shape), axis=-1)
        power = np.zeros(len(rows))
        for key, place in work.places.items():
            here = drawn[:, place]
            power = power + work.shares[key] * (np.mean(here, axis=-1) if work.lasts(key) else here[:, 0])
            for (limit, part), demand in point.utilisation.items():
                row = np.broadcast_to(demand, (shape[0], shape[1] * shape[2])).reshape(shape)[:, place]
                root = work.lasts(key) and limit in ROOT_MEAN_SQUARE
                most = np.sqrt(np.mean(row * row, axis=1)) if root else np.max(row, axis=1)
                of = work.name_of(key), limit, part
                demands[of] = np.maximum(demands.get(of, 0.0), np.max(most, axis=-1))
        demands |= self.found.sized(rows, stage)
        each = self.found.measure("price" if self.objective == "price" else "mass", rows, stage)
        return _Judged(power, work.machine.links * each, demands)

    def stage(self, radius: Any) -> OutputStage:
        """That of the template, or with another radius."""
        stage: Any = self.found.template.stage
        return stage if radius is None else replace(stage, radius=radius)


def separate(request: StudyRequest, progress: Progress | None) -> Found:
    """Search over machines like one with a geared motor for each link: the best designs, the front and the record."""
    work = MachineWork.of(request.study, request.name)
    drive, parts = work.machine.separate, request.parts
    found = candidates(
        drive,
        parts.motors_as("motor"),
        parts.gearheads,
        parts.pairs,
        loss_model=request.loss_model or drive.gearhead.loss_model,
        moving=True,
        stated=[aim for aim in request.aims[:1] if aim != "energy"],
        service=work.service,
    )
    others = {key: one for key, one in work.judged(work.machine)[1].items() if key[2] not in LINKS}
    search = _Search(work=work, found=found, objective=request.aims[0], others=others)  # type: ignore[arg-type]
    radii, rows = _radii(request), found.usable
    grid: list[_Judged] = []
    for place, radius in enumerate(radii if len(rows) else ()):
        grid.append(search.judged(rows, np.full(len(rows), radius)))
        if progress is not None:
            progress("every pair", 0.7 * (place + 1) / len(radii))
    record = SearchRecord(
        candidates=len(found.pairs),
        left=len(rows),
        evaluated=len(rows),
        excluded={**found.excluded, **_unweighed(request, found)},
        counts=tuple(_counts(grid)),
        unchecked={of: number for of in LIMIT_FIELDS if (number := int(np.sum(~found.stated(of, rows))))},
        ranges={RADIUS: (float(radii[0]), float(radii[-1]))} if len(radii) > 1 else {},
        cloud=np.empty((0, 2)),
        closed=False,
    )
    if not grid:
        return Found([], [], record)
    tried = _Tried(np.tile(rows, len(grid)), np.repeat(radii, len(rows)), *_joined(grid))
    for aim in request.aims:
        tried = _refined(search, tried, aim, _CONTENDERS * request.top)
    if progress is not None:
        progress("best pairs", 0.9)
    able = tried.of(np.flatnonzero(tried.worst <= 1.0))
    if not len(able.row):
        nearest = nearest_of(tried.worst[None], tried.mass)
        return Found([], [], replace(record, nearest=_design(request, search, tried, nearest)))
    order = np.lexsort((able.mass, able.value(request.aims[0])))
    _, first = np.unique(able.row[order], return_index=True)
    best = order[np.sort(first)][: request.top]
    known = np.flatnonzero(np.isfinite(able.mass))
    along = known[spread_front(able.mass[known], able.power[known])] if len(request.aims) > 1 and len(known) else []
    designs, front = ([_design(request, search, able, int(place)) for place in some] for some in (best, along))
    return Found(designs, front, replace(record, cloud=np.stack([able.mass, able.power], axis=-1)))


RADIUS = "separate.pulley.radius"


class _Tried(NamedTuple):
    """Pairs at radii that were judged. (k,) each"""

    row: np.ndarray
    radius: np.ndarray
    """nan for the template's stage. [m]"""
    power: np.ndarray
    mass: np.ndarray
    """[kg], or the price"""
    worst: np.ndarray

    def of(self, places: np.ndarray) -> _Tried:
        """Some of them."""
        return _Tried(*(one[places] for one in self))

    def value(self, aim: str) -> np.ndarray:
        """What an objective makes small; inf where it is not known."""
        return self.power if aim == "energy" else np.where(np.isnan(self.mass), np.inf, self.mass)


def _joined(some: Sequence[_Judged]) -> Iterator[np.ndarray]:
    for name in ("power", "mass", "worst"):
        yield np.concatenate([getattr(one, name) for one in some])


def _radii(request: StudyRequest) -> np.ndarray:
    """Radii to judge every pair at; nan where the stage stays as it is. [m]"""
    pulley = request.template.separate.pulley
    if pulley is None:
        return np.array([np.nan])
    low, high = request.radius or (pulley.radius / RANGE, pulley.radius * RANGE)
    return np.geomspace(low, high, _RADII) if low < high else np.array([low])


def _refined(search: _Search, tried: _Tried, aim: str, most: int) -> _Tried:
    """What was tried, with more radii about the best one of each of the best pairs."""
    if np.all(tried.radius == tried.radius[0]) or np.any(np.isnan(tried.radius)):
        return tried
    low, high = tried.radius.min(), tried.radius.max()
    for _ in range(_ROUNDS):
        value = np.where(tried.worst <= 1.0, tried.value(aim), _BEYOND * np.maximum(tried.worst, 1.0))
        order = np.lexsort((value, tried.row))
        kept, first = np.unique(tried.row[order], return_index=True)
        best = order[first]
        near = np.argsort(value[best], kind="stable")[:most]
        some = np.union1d(near, np.flatnonzero((tried.worst[best] > 1.0) & (tried.worst[best] <= _NARROW)))
        rows, radii = [], []
        for row, place in zip(kept[some], best[some], strict=True):
            own, at = np.sort(tried.radius[tried.row == row]), tried.radius[place]
            below, above = np.max(own[own < at], initial=low), np.min(own[own > at], initial=high)
            between = np.concatenate([np.geomspace(below, at, 4)[1:-1], np.geomspace(at, above, 4)[1:-1]])
            rows += [row] * len(between)
            radii += between.tolist()
        more = np.array(rows), np.array(radii)
        judged = _Tried(*more, *_joined([search.judged(*more)]))
        tried = _Tried(*(np.concatenate(both) for both in zip(tried, judged, strict=True)))
    return tried


def _feasible_range(search: _Search, row: int, radius: float, ends: tuple[float, float]) -> tuple[float, float]:
    """Least and largest radius around one at which a pair keeps all limits. [m]"""
    found = []
    for end in ends:
        inside, outside = math.log(radius), math.log(end)
        if search.judged(np.array([row]), np.array([end])).worst[0] <= 1.0:
            inside = outside
        for _ in range(_HALVINGS if inside != outside else 0):
            middle = 0.5 * (inside + outside)
            if search.judged(np.array([row]), np.array([math.exp(middle)])).worst[0] <= 1.0:
                inside = middle
            else:
                outside = middle
        found.append(end if inside == math.log(end) else math.exp(inside))
    return found[0], found[1]


def _design(request: StudyRequest, search: _Search, tried: _Tried, place: int) -> SizedDrive:
    """One of what was tried, judged by the machine itself."""
    row, radius = int(tried.row[place]), float(tried.radius[place])
    work, found, parts = search.work, search.found, request.parts
    ends, free = _radii(request)[[0, -1]], {}
    if not math.isnan(radius):
        known = tried.worst[place] <= 1.0 and ends[0] < ends[1]
        low, high = _feasible_range(search, row, radius, tuple(ends)) if known else (math.nan, math.nan)
        free[RADIUS] = FreeValue(value=radius, low=low, high=high, unit="m")
    motor, gearhead = map(int, found.pairs[row])
    return work.design(
        request.name,
        replace(work.machine, separate=found.drive(row, search.stage(None if math.isnan(radius) else radius))),
        {"separate.motor": parts.motor("motor", motor), "separate.gearhead": parts.part("gearheads", gearhead)},
        free,
        [of for of in LIMIT_FIELDS if not found.stated(of, np.array([row]))[0]],
    )


def _unweighed(request: StudyRequest, found: Candidates) -> dict[str, int]:
    """Pairs that the front leaves out, as their mass is not stated."""
    number = (
        int(np.sum(np.isnan(found.mass(found.usable)))) if len(request.aims) > 1 and request.aims[0] == "energy" else 0
    )
    return {f"mass not stated{OF_FRONT}": number} if number else {}


def _counts(grid: Sequence[_Judged]) -> Iterator[LimitCount]:
    """Yield how many pairs each limit excludes at every radius of a grid."""
    if not grid:
        return
    left = np.ones((len(grid), len(grid[0].power)), dtype=bool)
    for key in grid[0].demands:
        kept = np.array([one.demands[key] for one in grid]) <= 1.0
        before, left = left.any(axis=0), left & kept
        yield LimitCount(
            *key,
            checked=kept.shape[1],
            exceeded=int(np.sum(~kept.any(axis=0))),
            first=int(np.sum(before & ~left.any(axis=0))),
        )
