"""Catalogue parts, ready to use."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

from infinivar._core.frozen import FrozenDict
from infinivar.contact.bodies import Material
from infinivar.parts import catalogue
from infinivar.parts.bearing import Bearing
from infinivar.parts.belt import TimingBelt
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.parts.rail import Rail
from infinivar.parts.structure.stock import StockSpring, StockTube
from infinivar.study.build import built_part
from infinivar.study.schema import CATALOGUES


@functools.cache
def _all(part: type) -> Mapping[str, Any]:
    return FrozenDict({key: built_part(part, key) for key in catalogue.entries(CATALOGUES[part])})


def motors() -> Mapping[str, Motor]:
    """Every motor of the catalogue, by key."""
    return _all(Motor)


def gearheads() -> Mapping[str, Gearhead]:
    """Every gearhead of the catalogue, by key."""
    return _all(Gearhead)


def bearings() -> Mapping[str, Bearing]:
    """Every bearing of the catalogue, by key."""
    return _all(Bearing)


def rails() -> Mapping[str, Rail]:
    """Every rail with its carriage of the catalogue, by key."""
    return _all(Rail)


def belts() -> Mapping[str, TimingBelt]:
    """Every timing belt of the catalogue, by key."""
    return _all(TimingBelt)


def springs() -> Mapping[str, StockSpring]:
    """Every spring of the catalogue, by key."""
    return _all(StockSpring)


def tubes() -> Mapping[str, StockTube]:
    """Every tube of the catalogue, by key."""
    return _all(StockTube)


def materials() -> Mapping[str, Material]:
    """Every material of the catalogue, by key."""
    return _all(Material)
