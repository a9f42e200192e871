"""Search over cobotic drives for walking, among the shipped parts: designs a second, and how near the best it comes in time.

A wheel design is a bearing and five values. Each is evaluated with the best of all motors, gearheads, steering motors and ratios
behind it; their product is the number of drives that it covers. There is no known best: distances are from the best of all seeds
after 100 and 200 generations. Longer searches, of 600 and 3000, once came no nearer.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import infinivar as iv
from benchmarks._measure import ROOT, Line
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.sizing.cobotic.search import best_cobotic, prepared
from infinivar.sizing.cobotic.space import Points
from infinivar.sizing.cobotic.wheels import CompiledWheels
from infinivar.sizing.pool import pool
from infinivar.sizing.tables import CoboticRequest
from infinivar.study.catalogue import bearings

INSTANTS = 400
FEW = 100
"""Instants of most generations of a search that has few."""
RATIOS = (6.0, 9.0, 12.0, 16.0, 22.0, 30.0)
"""Of the gear between steering motor and bell."""
SEEDS = (0, 1)
GENERATIONS = (100, 200)
"""Of searches that take some 15 and 30 seconds."""
DESIGNS = 512
"""Wheel designs of which the rate is measured."""


def run() -> Iterator[Line]:
    """Measure rates with NumPy and, if installed, JAX, and distances from the best."""
    study = iv.load_study(ROOT / "studies" / "knee_walking.toml")
    template = study.drives["cobotic"]
    assert isinstance(template, CoboticDrive)
    parts = pool(["shipped"])
    request = CoboticRequest(
        template=template,
        motors=parts.motors,
        gearheads=parts.gearheads,
        pairs=parts.pairs,
        steering_motors=parts.motors,
        steering_ratios=RATIOS,
        bearings=_bearings(template),
        ranges={},
        duty=study.duty,
        travel=study.travel,
        samples=INSTANTS,
    )
    for instants in (FEW, INSTANTS):
        at = replace(request, samples=instants)
        yield _rate("NumPy", at, compiled=False)
        if importlib.util.find_spec("jax") is not None:
            yield _rate("JAX, warm", at, compiled=True)
    # What is the least is known after the last search.
    found = [[_search(request, seed, one) for seed in SEEDS] for one in GENERATIONS]
    least = min(power for one in found for power, _ in one)
    for generations, searches in zip(GENERATIONS, found, strict=True):
        gaps = ", ".join(f"{100.0 * (power / least - 1.0):.2g} %" for power, _ in searches)
        seconds = np.mean([taken for _, taken in searches])
        yield Line(
            what=f"cobotic: power over the least known, {generations} generations, {len(SEEDS)} seeds",
            ours=f"{gaps} after {seconds:.0f} s of processor time",
            theirs="",
            ratio="",
        )


def _bearings(template: CoboticDrive) -> tuple[Any, ...]:
    """Shipped bearings that an axle can have, with the friction model of the template's."""
    geometry = template.transmission.geometry
    assert geometry is not None
    model = geometry.axle_bearing.friction_model
    return tuple(replace(one, friction_model=model) for one in bearings().values() if one.type == "deep_groove")


def _rate(name: str, request: CoboticRequest, *, compiled: bool) -> Line:
    """Wheel designs a second, and drives that they cover, around the template."""
    evaluation, box = prepared(request)
    random = np.random.default_rng(0)
    values = box.own.values * np.exp(random.uniform(-0.1, 0.1, (DESIGNS, box.own.values.shape[-1])))
    axle = next(place for place, one in enumerate(box.heads.axles) if one.name == "6000")
    points = Points(values, np.full(DESIGNS, box.heads.at((axle, 0, 0))))
    if compiled:
        evaluation.space.compiled = CompiledWheels(evaluation.space)
    found, seconds = evaluation.values(points), []
    for _ in range(5):
        start = time.perf_counter()
        evaluation.values(points)
        seconds.append(time.perf_counter() - start)
    behind = np.prod([len(side.rows) for side in evaluation.sides])
    rate = DESIGNS / min(seconds)
    rolling = np.mean(found.feasible)
    return Line(
        what=f"cobotic, {name}: wheel designs a second, {request.samples} instants, {100.0 * rolling:.0f} % feasible",
        ours=f"{rate:.0f}, {rate * behind:.2g} drives",
        theirs="",
        ratio="",
        target=">= 2500" if compiled else "",
        passed=bool(rate >= 2500.0) if compiled else None,
    )


def _search(request: CoboticRequest, seed: int, generations: int) -> tuple[float, float]:
    """Least power found, and processor time. [W], [s]"""
    start = time.process_time()
    found = best_cobotic(replace(request, generations=generations, seed=seed, top=1))
    assert found.best is not None
    return found.best.power, time.process_time() - start
