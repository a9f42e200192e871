"""Shafts and tubes between two supports: their sections, what a force stresses them, and their first bending mode."""

from __future__ import annotations

import math
from typing import NamedTuple

from infinivar._core.array_namespace import Array, as_floats, namespace

STEEL_MODULUS, STEEL_DENSITY = 206e9, 7850.0
"""[Pa], [kg m^-3]"""

BENDING: dict[str, float] = {
    "fixed-free": 1.87510407,
    "supported-supported": math.pi,
    "fixed-supported": 3.92660231,
    "fixed-fixed": 4.73004074,
}
"""First root of the frequency equation of a uniform beam. Source: blevins1979, Table 8-1."""


class Section(NamedTuple):
    """Round cross section; arrays that broadcast."""

    outer: Array
    """Outer radius. [m]"""
    inner: Array = 0.0
    """Inner radius. [m]"""

    @property
    def area(self) -> Array:
        """[m^2]"""
        return math.pi * (self.outer**2 - self.inner**2)

    @property
    def second_moment(self) -> Array:
        """About a diameter. [m^4]

        Source: young2002, Table A.1.
        """
        return 0.25 * math.pi * (self.outer**4 - self.inner**4)

    @property
    def gyration(self) -> Array:
        """Radius of gyration about a diameter. [m]"""
        xp = namespace(self.outer, self.inner)
        outer, inner = as_floats(xp, self.outer, self.inner)
        return 0.5 * xp.sqrt(outer**2 + inner**2)


def stress(section: Section, span: Array, place: Array) -> Array:
    """Largest bending stress of a beam under a force between two supports that let its ends turn, over the force. [Pa/N]

    Source: young2002, Table 8.1, case 1e: the moment ``x (L - x)/L``.
    """
    return place * (span - place) / span * section.outer / section.second_moment


def critical_speed(section: Section, length: Array, ends: str, modulus: Array, density: Array) -> Array:
    r"""First bending mode, also the first critical speed of a shaft, :math:`(\beta/L)^2 k\sqrt{E/\varrho}`.

    Parameters
    ----------
    section : Section         Its radius of gyration is k.
    length : (...,) float     Distance between the supports. [m]
    ends : str                A key of `BENDING`, which gives beta.
    modulus, density          [Pa], [kg m^-3]

    Returns
    -------
    (...,) float   [rad s^-1]

    Source: blevins1979, Table 8-1.
    """
    xp = namespace(section.outer, section.inner, length, modulus, density)
    length, modulus, density = as_floats(xp, length, modulus, density)
    return (BENDING[ends] / length) ** 2 * section.gyration * xp.sqrt(modulus / density)
