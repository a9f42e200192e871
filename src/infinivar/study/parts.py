"""Catalogue parts as ready objects."""

from __future__ import annotations

from typing import Any

from infinivar.parts import catalogue
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.study.build import built_part
from infinivar.study.schema import CATALOGUES


def _all(part: type) -> dict[str, Any]:
    return {key: built_part(part, key) for key in catalogue.entries(CATALOGUES[part])}


def motors() -> dict[str, Motor]:
    """Every motor of the catalogue, by key."""
    return _all(Motor)


def gearheads() -> dict[str, Gearhead]:
    """Every gearhead of the catalogue, by key."""
    return _all(Gearhead)
