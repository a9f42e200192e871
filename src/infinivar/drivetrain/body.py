"""A body of a drive: what it is, and what it weighs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from infinivar._core.array_namespace import Array


class Body(NamedTuple):
    """A body of a drive."""

    name: str
    mass: Array | None
    """None: not known. [kg]"""
    kind: str
    """catalogue, stated or derived."""
    basis: str
    """What it is, or what is missing."""
    moving: bool = False
    """Whether it moves with the link or load."""
    chosen: bool = False
    """Whether it is a motor or gearhead, which searches choose."""


def total(found: Iterable[Body]) -> Array:
    """Mass of all bodies; nan if one is not known. [kg]"""
    return sum((math.nan if body.mass is None else body.mass for body in found), start=0.0)


def own_mass(found: Iterable[Body]) -> Array:
    """Mass of all bodies but motors and gearheads; nan if one is not known. [kg]"""
    return total(body for body in found if not body.chosen)


def open_bodies(found: Iterable[Body]) -> list[str]:
    """Bodies whose mass is not known, and why."""
    return [f"{body.name} ({body.basis})" for body in found if body.mass is None]
