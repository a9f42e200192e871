"""Design changes that the paper recommends, and whether they help a drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from infinivar._core.fields import quantities_of
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness.outcomes import Outcome
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.parts.bearing import SIZE_POWERS


class Direction(NamedTuple):
    """A design change that the paper recommends: fields, and the power of the change by which each scales."""

    words: str
    powers: Mapping[str, float]


def _bearing(at: str) -> dict[str, float]:
    """Powers for a smaller bearing."""
    return {f"{at}.{name}": -power for name, power in SIZE_POWERS.items()}


_GEOMETRY = "transmission.geometry"
DIRECTIONS = (
    Direction("higher friction, less preload", {"transmission.friction": 1.0, "transmission.preload": -1.0}),
    Direction(
        "stiffer wheel and cylinder, which creep less",
        {
            f"{_GEOMETRY}.wheel_material.youngs_modulus": 1.0,
            f"{_GEOMETRY}.cylinder_material.youngs_modulus": 1.0,
            "transmission.creep_stiffness": 1.0,
        },
    ),
    Direction(
        "less hysteresis",
        {
            f"{_GEOMETRY}.wheel_material.hysteresis_factor": -1.0,
            f"{_GEOMETRY}.cylinder_material.hysteresis_factor": -1.0,
            "transmission.rolling_torque": -1.0,
        },
    ),
    Direction("smaller axle bearings", {**_bearing(f"{_GEOMETRY}.axle_bearing"), "transmission.bearing_torque": -1.0}),
    Direction("smaller bell bearing", {**_bearing("steering.bell_bearing"), "steering.bell_friction": -1.0}),
    Direction("less steering inertia", {"steering.bell_inertia": -1.0, "steering.motor.rotor_inertia": -1.0}),
    Direction("lighter link", {"link_mass": -1.0}),
)
"""Recommendations of section VII of the paper; fields that a drive lacks are skipped."""


class Conclusion(NamedTuple):
    """Effect of a recommendation of the paper on an outcome."""

    words: str
    elasticity: float
    """Relative change of the outcome per relative change in the recommended direction. [-]"""
    verdict: str
    """helps, hurts, or "no effect"."""


def conclusions(asked: Outcome, elasticities: Mapping[str, float], drive: AnyDrive) -> tuple[Conclusion, ...]:
    """Evaluate the paper's recommendations for an outcome of a cobotic drive; empty for other drives.

    Source: faulring2006, section VII.
    """
    if not isinstance(drive, CoboticDrive):
        return ()
    known, found = quantities_of(drive), []
    for direction in DIRECTIONS:
        if not any(path in known for path in direction.powers):
            continue
        slope = sum(power * elasticities.get(path, 0.0) for path, power in direction.powers.items())
        verdict = "no effect" if abs(slope) < 1e-6 else "helps" if slope * asked.better > 0 else "hurts"
        found.append(Conclusion(direction.words, float(slope), verdict))
    return tuple(found)
