"""Search over cobotic drives like a template."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.parts.bearing import Bearing
from infinivar.sizing.cobotic.result import CoboticDesign, CoboticSizing
from infinivar.sizing.cobotic.search import RANGE, size_cobotic
from infinivar.sizing.cobotic.wheels import FREE, values_of
from infinivar.sizing.design import (
    AXLE_BEARING,
    COBOTIC_PATHS,
    STEERING_MOTOR,
    STEERING_RATIO,
    UNITS,
    FreeValue,
    SizedDrive,
)
from infinivar.sizing.pool import ChosenPart
from infinivar.sizing.progress import Progress
from infinivar.sizing.records import WheelRecord
from infinivar.sizing.request import Found, Request

POPULATION = 40
"""Wheel designs of each generation."""

PAYS = 40_000
"""Wheel designs from which on JAX saves more time than it needs to compile."""

RATIOS = (0.5, math.sqrt(0.5), 1.0, math.sqrt(2.0), 2.0)
"""Ratios between steering motor and bell that are tried, over that of the template, unless some are given. [-]"""

Axles = Sequence[tuple[ChosenPart | None, Bearing]]


def cobotic(asked: Request, name: str, template: CoboticDrive, progress: Progress | None) -> Found:
    """Search over cobotic drives: the best designs, the front and the record."""
    found = size_cobotic(
        template,
        **arguments_of(asked, template),
        objective=objective_of(asked),
        generations=asked.generations,
        seed=asked.seed,
        top=asked.top,
        progress=progress,
    )
    return found_of(asked, name, template, found)


def objective_of(asked: Request) -> Any:
    """Objective of `size_cobotic`."""
    first, *others = asked.aims
    return "front" if others else first


def found_of(asked: Request, name: str, template: CoboticDrive, found: CoboticSizing) -> Found:
    """What `size_cobotic` found, with the parts and where they are from."""
    axles, designs = _axles(asked, template), _merged(found, asked)
    nearest = None if designs else found.nearest
    missed = None if nearest is None else _design(asked, name, axles, nearest)
    return Found(
        [_design(asked, name, axles, one) for one in designs],
        [_design(asked, name, axles, one) for one in (found.front if len(asked.aims) > 1 else ())],
        _record(template, asked, found, axles, missed),
    )


def arguments_of(asked: Request, template: CoboticDrive) -> dict[str, Any]:
    """Arguments of `size_cobotic` but objective, generations, seed, top and progress."""
    parts, study = asked.parts, asked.study
    return {
        "motors": parts.motors_as("motor"),
        "gearheads": parts.gearheads,
        "pairs": parts.pairs,
        "steering_motors": parts.motors_as(STEERING_MOTOR),
        "steering_ratios": _ratios(asked, template) or (1.0,),
        "bearings": [bearing for _, bearing in _axles(asked, template)],
        "duty": study.duty,
        "requirement": study.requirement,
        "ranges": asked.ranges,
        "travel": study.travel,
        "slip_margin": asked.slip_margin,
        "life": asked.life,
        "loss_model": asked.loss_model,
        "population": POPULATION,
        "method": _method(asked.generations),
    }


def _axles(requested: Request, template: CoboticDrive) -> Axles:
    """Axle bearings to try."""
    geometry = template.transmission.geometry
    assert geometry is not None  # of a template that was checked
    return requested.parts.axle_bearings(geometry.axle_bearing)


def _ratios(requested: Request, template: CoboticDrive) -> tuple[float, ...]:
    """Ratios to try between steering motor and bell; none where nothing steers."""
    if template.steering is None or not requested.study.duty:
        return ()
    own = template.steering.ratio
    return requested.steering_ratios or tuple(own * factor for factor in RATIOS)


def _method(generations: int) -> str:
    """Compiled laws where they are sooner done."""
    if POPULATION * generations < PAYS or importlib.util.find_spec("jax") is None:
        return "numpy"
    return "jax"


def _merged(found: CoboticSizing, requested: Request) -> list[CoboticDesign]:
    """The best by the first objective, each combination of parts once."""
    name = "power" if requested.aims[0] == "energy" else "mass"
    ordered = sorted(found.designs, key=lambda one: getattr(one, name))
    kept: dict[tuple[int, int, int, float], CoboticDesign] = {}
    for one in ordered:
        kept.setdefault((one.pair, one.bearing, one.steering, one.ratio), one)
    return list(kept.values())[: requested.top]


def _record(
    template: CoboticDrive,
    requested: Request,
    found: CoboticSizing,
    axles: Axles,
    nearest: SizedDrive | None,
) -> WheelRecord:
    own = dict(zip(FREE, values_of(template), strict=True))
    ranges = {name: requested.ranges.get(name, (own[name] / RANGE, own[name] * RANGE)) for name in FREE}
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
        steering_ratios=_ratios(requested, template),
        bearings=tuple(bearing.name for _, bearing in axles),
        cloud=found.cloud,
        history=found.history,
        compiled=_method(requested.generations) == "jax",
        nearest=nearest,
    )


def _held(drive: CoboticDrive) -> CoboticDrive:
    """The drive with a speed loop that holds the cylinder at the constant speed that the search assumes."""
    control = drive.control
    return replace(
        drive,
        control=replace(control, cylinder_bandwidth=max(control.cylinder_bandwidth, control.steering_bandwidth)),
    )


def _design(requested: Request, name: str, axles: Axles, found: CoboticDesign) -> SizedDrive:
    pool = requested.parts
    chosen: dict[str, ChosenPart] = {}
    free = {COBOTIC_PATHS[key]: value for key, value in found.values.items()}
    if found.motor >= 0:
        chosen = {"motor": pool.motor("motor", found.motor), "gearhead": pool.part("gearheads", found.gearhead)}
    if found.steering >= 0:
        chosen[STEERING_MOTOR] = pool.motor(STEERING_MOTOR, found.steering)
        free[STEERING_RATIO] = found.ratio
    axle, _ = axles[found.bearing]
    if axle is not None:
        chosen[AXLE_BEARING] = axle
    return SizedDrive(
        template=name,
        parts=chosen,
        free={
            path: FreeValue(value=value, low=math.nan, high=math.nan, unit=UNITS[path]) for path, value in free.items()
        },
        drive=_held(found.drive),
        mass=found.mass,
        power=found.power,
        demands=found.demands,
        unchecked=found.unchecked,
    )
