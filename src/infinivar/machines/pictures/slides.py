"""Links on a common cylinder, and a handle on axes that each moves along.

A kind of machine in motion has an *outline*: its bodies as plain data, for frames, videos and scenes alike. Each names its shape,
by which drawings choose how to show it, and has a method that places its links at configurations; all but slides have one that
gives the strokes of a frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple

import numpy as np


class Drum(NamedTuple):
    """A common cylinder with a steered wheel for each link."""

    radius: float
    """[m]"""
    wheel_radius: float
    """Of the largest wheel. [m]"""
    inertia: float
    """[kg m^2]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Slides:
    """A handle on axes, each moved by a link."""

    shape: ClassVar[Literal["slide"]] = "slide"
    seen: ClassVar[Literal["slide"]] = "slide"

    masses: np.ndarray
    """Moved along each axis. (n,) [kg]"""
    link_mass: float
    """[kg]"""
    drum: Drum | None

    def link_positions(self, configuration: np.ndarray) -> np.ndarray:
        """Those of the axes. (t, n) [m]"""
        return configuration
