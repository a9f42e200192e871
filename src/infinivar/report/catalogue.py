"""The catalogue as text: one line per part, columns with units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from infinivar.study.catalogue import bearings, gearheads, materials, motors


def text() -> str:
    """All parts that a study can name with `part`, for a terminal."""
    tables = (
        _table(
            "motor",
            {"voltage": "V", "cont. torque": "mN m", "no-load speed": "rpm", "peak efficiency": "%", "mass": "g"},
            motors(),
            lambda motor: (
                motor.voltage,
                motor.continuous_torque * 1e3,
                motor.no_load_speed * 30 / math.pi,
                motor.peak_efficiency * 1e2,
                motor.mass and motor.mass * 1e3,
            ),
        ),
        _table(
            "gearhead",
            {"ratio": "", "efficiency": "%", "cont. torque": "N m", "mass": "g"},
            gearheads(),
            lambda gear: (
                gear.ratio,
                gear.efficiency and gear.efficiency * 1e2,
                gear.continuous_torque,
                gear.mass and gear.mass * 1e3,
            ),
        ),
        _table(
            "bearing",
            {"bore": "mm", "outside": "mm", "dynamic rating": "kN", "static rating": "kN"},
            bearings(),
            lambda bearing: (
                bearing.bore * 1e3,
                bearing.outside_diameter * 1e3,
                bearing.dynamic_rating * 1e-3,
                bearing.static_rating * 1e-3,
            ),
        ),
        _table(
            "material",
            {"Young's modulus": "GPa", "Poisson": "", "yield strength": "MPa", "hardness": "GPa"},
            materials(),
            lambda body: (
                body.youngs_modulus * 1e-9,
                body.poisson,
                body.yield_strength and body.yield_strength * 1e-6,
                body.hardness and body.hardness * 1e-9,
            ),
        ),
    )
    return "".join(f"{line}\n" for table in tables for line in table)


def _table(
    kind: str, columns: dict[str, str], parts: Mapping[str, Any], values: Callable[[Any], tuple[float | None, ...]]
) -> Iterator[str]:
    """Table of one kind of part, blank where a value is unknown."""
    yield f"{kind:<30}" + "".join(f"{name:>18}" for name in columns)
    for key, part in parts.items():
        cells = (
            "" if value is None else f"{value:{'.0f' if value >= 1e3 else '.4g'}} {unit}".rstrip()
            for value, unit in zip(values(part), columns.values(), strict=True)
        )
        yield f"{key:<30}" + "".join(f"{cell:>18}" for cell in cells)
    yield ""
