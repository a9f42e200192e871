"""The search over drives like a template for each combination of values to try, as one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from infinivar._core.fields import with_values
from infinivar._core.frozen import FrozenDict
from infinivar.errors import ParameterError
from infinivar.sizing.design import SCALES, STANDBY, STEERING_MOTOR, FreeValue, SizedDrive, path_words
from infinivar.sizing.margins import nearest_among
from infinivar.sizing.progress import Progress, best_so_far, part_of
from infinivar.sizing.records import TriedValue, merged
from infinivar.sizing.request import Found, StudyRequest
from infinivar.sizing.tries import Point, Try, drive_at, points, points_around

Search = Callable[[StudyRequest, Progress | None], Found]
"""Over geared or cobotic drives like one template."""


def search_tries(request: StudyRequest, search: Search, progress: Progress | None) -> Found:
    """What a search finds with each combination of the values to try, and with those around the best."""
    tries = request.tries.get(request.name, ())
    if not tries:
        return search(request, progress)
    first, found = points(tries), {}
    share = 0.5 if any(one.ranged for one in tries) else 1.0
    _search_all(request, search, first, found, part_of(progress, 0.0, share))
    if any(one.ranged for one in tries):
        more = [point for point in points_around(tries, _best(found, request)) if point not in found]
        _search_all(request, search, more, found, part_of(progress, share, 1.0))
    return _merged(request, tries, found)


def _search_all(
    request: StudyRequest, search: Search, some: Sequence[Point], found: dict[Point, Found], progress: Progress | None
) -> None:
    """Search with each of some combinations; one that the template refuses, between others that it has, is left out."""
    lead = ""
    for place, point in enumerate(some):
        try:
            at = _request_at(request, point)
        except ParameterError:
            continue
        found[point] = search(at, part_of(progress, place / len(some), (place + 1) / len(some), lead))
        designs = found[_best(found, request)].designs
        lead = f"{best_so_far(designs[0].power, designs[0].mass)}; " if designs else ""


def _request_at(request: StudyRequest, point: Point) -> StudyRequest:
    """The search over drives like the template with a combination of values."""
    tries, study = request.tries[request.name], request.study
    drive = drive_at(study.drives[request.name], tries, point)
    numbers = {
        **request.parts.numbers,
        **{
            one.path.removesuffix(".scale"): value
            for one, value in zip(tries, point, strict=True)
            if one.path in SCALES
        },
    }
    if STANDBY not in [one.path for one in tries] and any(one.path in SCALES for one in tries):
        drive = _with_amplifiers(drive, *(_motors(drive, one) for one in (request.parts.numbers, numbers)))
    return replace(
        request,
        study=replace(study, drives={**study.drives, request.name: drive}),
        parts=replace(request.parts, numbers=FrozenDict(numbers)),
    )


def _motors(drive: Any, numbers: Mapping[str, float]) -> float:
    """Number of motors of a drive, from those on one shaft by role."""
    roles = ["motor", *([STEERING_MOTOR] if getattr(drive, "steering", None) is not None else [])]
    return sum(numbers.get(role, 1.0) for role in roles)


def _with_amplifiers(drive: Any, before: float, after: float) -> Any:
    """The drive with an amplifier for each motor, as before: only their standby power depends on the number."""
    standby = drive.amplifier.standby_power
    return drive if after == before or not standby else with_values(drive, {STANDBY: standby * after / before})


def _value(request: StudyRequest, design: SizedDrive) -> tuple[float, float]:
    """What the first objective makes small; of equals, the design with the largest margin comes first."""
    return request.value(design), -design.margin


def _best(found: dict[Point, Found], request: StudyRequest) -> Point:
    """The combination with the best design, or if none has one, with the nearest miss."""
    able = {point: one.designs[0] for point, one in found.items() if one.designs}
    if able:
        return min(able, key=lambda point: _value(request, able[point]))
    missed = [point for point, one in found.items() if one.record.nearest is not None]
    place = nearest_among([_near(found[point]) for point in missed])
    return next(iter(found)) if place is None else missed[place]


def _near(found: Found) -> SizedDrive:
    assert found.record.nearest is not None
    return found.record.nearest


def _merged(request: StudyRequest, tries: Sequence[Try], found: dict[Point, Found]) -> Found:
    """Designs of all combinations, of each combination of parts the best, and one record."""
    tried = tuple(
        replace(one, values=tuple(sorted({point[place] for point in found}))) for place, one in enumerate(tries)
    )
    marked = {
        point: Found(
            [_marked(one, tried, point) for one in each.designs],
            [_marked(one, tried, point) for one in each.front],
            each.record,
        )
        for point, each in found.items()
    }
    kept: dict[tuple[tuple[str, str, float], ...], SizedDrive] = {}
    every = [one for each in marked.values() for one in each.designs]
    for one in sorted(every, key=lambda one: _value(request, one)):
        kept.setdefault(tuple((role, part.part, part.number) for role, part in one.parts.items()), one)
    missed = [] if every else [point for point, one in found.items() if one.record.nearest is not None]
    place = nearest_among([_near(found[point]) for point in missed])
    best = _best(found, request)
    record = replace(
        merged([one.record for one in found.values()], found[best].record),
        nearest=None if place is None else _marked(_near(found[missed[place]]), tried, missed[place]),
        stages=len(found),
        stage_words=f"values of {path_words(tries[0].path)}" if len(tries) == 1 else "combinations of values",
        tried=tuple(_rows(request, tried, marked)),
    )
    return Found([*kept.values()][: request.top], [one for each in marked.values() for one in each.front], record)


def _marked(design: SizedDrive, tries: Sequence[Try], point: Point) -> SizedDrive:
    """A design with the values that were tried among its free ones."""
    chosen = {
        one.path: FreeValue(value=value, low=math.nan, high=math.nan, unit=one.unit, tried=one.values)
        for one, value in zip(tries, point, strict=True)
    }
    return replace(design, free={**design.free, **chosen})


def _rows(request: StudyRequest, tries: Sequence[Try], found: dict[Point, Found]) -> Iterator[TriedValue]:
    """Yield the best design with each value, whatever the others are."""
    for place, one in enumerate(tries):
        for value in one.values:
            here = {point: each for point, each in found.items() if point[place] == value}
            best = here[_best(here, request)]
            yield TriedValue(
                path=one.path,
                value=value,
                unit=one.unit,
                candidates=sum(each.record.candidates for each in here.values()),
                design=best.designs[0] if best.designs else best.record.nearest,
                feasible=bool(best.designs),
            )
