"""Dynamic maps over the planes of frequency and power on which claims are judged, each computed once."""

from __future__ import annotations

import functools
from typing import Literal, NamedTuple

import numpy as np

from infinivar.analysis.cycles.performance import Definition
from infinivar.analysis.cycles.shaking import SAMPLES, DynamicMap, dynamic_map
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive

Scale = Literal["linear", "logarithmic"]
Cells = Literal["fine", "coarse"]

LEAST_FRACTION = 0.01
"""Lower end of a logarithmic power axis, two decades below the maximum. [-]"""

_FEWER_SAMPLES = 80


class Plane(NamedTuple):
    """Axes of a plane, frequency [Hz] and fraction of the maximum power [-], and the number of samples per cycle."""

    frequency: np.ndarray
    fraction: np.ndarray
    samples: int


def _middles(count: int) -> np.ndarray:
    return (np.arange(count) + 0.5) / count


PLANES: dict[tuple[Cells, Scale], Plane] = {
    ("fine", "linear"): Plane(np.geomspace(0.1, 30.0, 60), _middles(60), SAMPLES),
    ("fine", "logarithmic"): Plane(np.geomspace(0.1, 30.0, 60), LEAST_FRACTION ** (1.0 - _middles(60)), _FEWER_SAMPLES),
    ("coarse", "linear"): Plane(np.geomspace(0.1, 30.0, 24), _middles(16), _FEWER_SAMPLES),
}
"""The plane of Fig 17, the same with a logarithmic power axis, and a coarser one for machines other than the shipped one."""


@functools.lru_cache(maxsize=512)
def plane_map(
    drive: CoboticDrive | ConventionalDrive,
    power: float,
    load_mass: float,
    definition: Definition,
    cells: Cells,
    power_axis: Scale,
) -> DynamicMap:
    """Dynamic map of a drive over one of the planes; see `dynamic_map`."""
    plane = PLANES[cells, power_axis]
    return dynamic_map(
        drive,
        plane.frequency,
        plane.fraction,
        power=power,
        load_mass=load_mass,
        definition=definition,
        samples=plane.samples,
    )
