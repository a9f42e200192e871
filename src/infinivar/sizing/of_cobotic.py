"""Search over cobotic drives like a template."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from infinivar._core import extras
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.parts.bearing import Bearing
from infinivar.sizing.cobotic.search import best_cobotic, ranges_of
from infinivar.sizing.design import (
    AXLE_BEARING,
    COBOTIC_PATHS,
    CYLINDER_BEARING,
    STEERING_MOTOR,
    STEERING_RATIO,
    UNITS,
    WHEELS,
    FreeValue,
    SizedDrive,
)
from infinivar.sizing.found import CoboticDesign, CoboticSizing
from infinivar.sizing.pool import ChosenPart, PartPool
from infinivar.sizing.progress import Progress
from infinivar.sizing.records import WheelRecord
from infinivar.sizing.request import Found, StudyRequest
from infinivar.sizing.tables import CoboticRequest

POPULATION = 40
"""Wheel designs of each generation."""

PAYS = 40_000
"""Wheel designs from which on JAX saves more time than it needs to compile."""

RATIOS = (0.5, math.sqrt(0.5), 1.0, math.sqrt(2.0), 2.0)
"""Ratios between steering motor and bell that are tried, over that of the template, unless some are given. [-]"""

NUMBERS = (1, 2, 3)
"""Of wheels around the cylinder that are tried unless some are given."""

Bearings = Sequence[tuple[ChosenPart | None, Bearing]]


def cobotic(request: StudyRequest, progress: Progress | None) -> Found:
    """Search over cobotic drives: the best designs, the front and the record."""
    return found_of(request, best_cobotic(request_on_tables(request), progress))


def request_on_tables(request: StudyRequest) -> CoboticRequest:
    """The search over tables for a template."""
    lists = {path: tuple(bearing for _, bearing in some) for path, some in _lists(request).items()}
    return request.on_tables(
        CoboticRequest,
        steering_motors=request.parts.motors_as(STEERING_MOTOR),
        steering_ratios=_ratios(request) or (1.0,),
        bearings=lists[AXLE_BEARING],
        wheels=_wheels(request),
        cylinder_bearings=lists.get(CYLINDER_BEARING, ()),
        ranges=request.ranges,
        objective=request.objectives[-1],
        slip_margin=request.slip_margin,
        life=request.life,
        population=POPULATION,
        generations=request.generations,
        seed=request.seed,
        method=_method(request.generations),
    )


def found_of(request: StudyRequest, found: CoboticSizing) -> Found:
    """What a search over tables found, with the parts and where they are from."""
    lists = _lists(request)
    record = _record(request, lists, found)
    both = _merged(found, request), found.front if len(request.aims) > 1 else ()
    designs, front = ([_design(request, lists, one) for one in some] for some in both)
    if not designs and found.nearest is not None:
        record = replace(record, nearest=_design(request, lists, found.nearest))
    return Found(designs, front, record)


def _lists(request: StudyRequest) -> dict[str, Bearings]:
    return bearings_of(request.template, request.parts)


def bearings_of(template: CoboticDrive, parts: PartPool) -> dict[str, Bearings]:
    """Bearings to try, by their place in the drive; those of the cylinder where the template states a part for them."""
    geometry, held = template.transmission.geometry, template.cylinder_bearings
    assert geometry is not None
    found: dict[str, Bearings] = {AXLE_BEARING: parts.bearings_like(geometry.axle_bearing)}
    if held is not None and held.bearing is not None:
        found[CYLINDER_BEARING] = parts.bearings_like(held.bearing)
    return found


def _wheels(request: StudyRequest) -> tuple[int, ...]:
    """Numbers of wheels to try; backing rollers go with one wheel only."""
    held = request.template.cylinder_bearings
    alone = held is not None and held.backing_rollers > 0
    return request.wheels or ((1,) if alone else NUMBERS)


def _ratios(request: StudyRequest) -> tuple[float, ...]:
    """Ratios to try between steering motor and bell; none where nothing steers."""
    steering = request.template.steering
    if steering is None or not request.study.duty:
        return ()
    return ratios_of(steering.ratio, request)


def ratios_of(own: float, request: StudyRequest) -> tuple[float, ...]:
    """Ratios to try between steering motor and bell: those stated, or around that of the template."""
    return request.steering_ratios or tuple(own * factor for factor in RATIOS)


def _method(generations: int) -> Literal["numpy", "jax"]:
    """Compiled laws where they are sooner done."""
    if POPULATION * generations < PAYS or not extras.there("jax"):
        return "numpy"
    return "jax"


def _merged(found: CoboticSizing, request: StudyRequest) -> list[CoboticDesign]:
    """The best by the first objective, each combination of parts once."""
    ordered = sorted(found.designs, key=request.order)
    kept: dict[tuple[int, int, int, int, float], CoboticDesign] = {}
    for one in ordered:
        kept.setdefault((one.pair, one.bearing, one.wheels, one.steering, one.ratio), one)
    return list(kept.values())[: request.top]


def _record(request: StudyRequest, lists: Mapping[str, Bearings], found: CoboticSizing) -> WheelRecord:
    ranges = ranges_of(request.template, request.ranges, _wheels(request))
    names = {path: tuple(bearing.name for _, bearing in some) for path, some in lists.items()}
    return WheelRecord(
        candidates=found.candidates,
        wheels=found.wheels,
        rolled=found.rolled,
        drives=found.drives,
        evaluated=found.sampled,
        excluded=found.excluded,
        blocked=dict(sorted(found.blocked.items(), key=lambda item: -item[1])),
        unchecked=found.unchecked,
        ranges={COBOTIC_PATHS[name]: (float(low), float(high)) for name, (low, high) in ranges.items()},
        steering_ratios=_ratios(request),
        bearings=names[AXLE_BEARING],
        cylinder_bearings=names.get(CYLINDER_BEARING, ()),
        numbers_of_wheels=_wheels(request),
        cloud=found.cloud,
        history=found.history,
        compiled=_method(request.generations) == "jax",
    )


def _held(drive: CoboticDrive) -> CoboticDrive:
    """The drive with a speed loop that holds the cylinder at the constant speed that the search assumes."""
    control = drive.control
    return replace(
        drive,
        control=replace(control, cylinder_bandwidth=max(control.cylinder_bandwidth, control.steering_bandwidth)),
    )


def _design(request: StudyRequest, lists: Mapping[str, Bearings], found: CoboticDesign) -> SizedDrive:
    pool = request.parts
    chosen: dict[str, ChosenPart] = {}
    free = {COBOTIC_PATHS[key]: value for key, value in found.values.items()}
    if found.motor >= 0:
        chosen = {"motor": pool.motor("motor", found.motor), "gearhead": pool.part("gearheads", found.gearhead)}
    if found.steering >= 0:
        chosen[STEERING_MOTOR] = pool.motor(STEERING_MOTOR, found.steering)
        free[STEERING_RATIO] = found.ratio
    if len(_wheels(request)) > 1 or found.wheels > 1:
        free[WHEELS] = found.wheels
    places = {AXLE_BEARING: found.bearing, CYLINDER_BEARING: found.support}
    chosen |= {role: part for role, some in lists.items() if (part := some[places[role]][0]) is not None}
    return SizedDrive(
        template=request.name,
        parts=chosen,
        free={
            path: FreeValue(value=value, low=math.nan, high=math.nan, unit=UNITS[path]) for path, value in free.items()
        },
        drive=_held(found.drive),
        mass=found.mass,
        power=found.power,
        volume=found.volume,
        price=None if math.isnan(found.price) else found.price,
        demands=found.checked,
        unchecked=found.unchecked,
    )
