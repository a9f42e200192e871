"""What a search is asked for, whichever architecture it is over."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from infinivar.parts.gearhead import LossModel
from infinivar.sizing.design import SizedDrive
from infinivar.sizing.pool import PartPool
from infinivar.sizing.records import SearchRecord, WheelRecord
from infinivar.study.study import Study


class Request(NamedTuple):
    """What a search is asked for."""

    study: Study
    parts: PartPool
    aims: tuple[str, ...]
    """Objectives; designs are ordered by the first, and two ask for a front."""
    top: int
    radius: tuple[float, float] | None
    """Of the pulley of geared drives. [m]"""
    leads: tuple[float, ...]
    """Of the screw of geared drives, to try with every pair; empty: that of the template. [m]"""
    ranges: Mapping[str, tuple[float, float]]
    """Of the free values of cobotic drives, by name."""
    steering_ratios: tuple[float, ...] | None
    slip_margin: float
    life: float | None
    """Of the axle bearings of cobotic drives. [s]"""
    loss_model: LossModel | None
    generations: int
    seed: int


class Found(NamedTuple):
    """What a search over drives like one template found."""

    designs: list[SizedDrive]
    front: list[SizedDrive]
    record: SearchRecord | WheelRecord
