"""Axis of a load: a line, along which forces act, or a joint, about which moments act."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from infinivar._core.described import reported


@dataclass(frozen=True, slots=True)
class Axis:
    """Terms and SI units of the quantities along a line or about a joint.

    All laws are the same for both: "position" means angle, "force" means moment and "mass" means moment of inertia about a
    joint. Only the words and units shown to users differ.
    """

    rotary: bool
    position: str
    position_unit: str
    speed: str
    speed_unit: str
    force: str
    force_unit: str
    mass: str
    mass_unit: str

    def __reduce__(self) -> str:
        """Copies, pickles and saved results hold the same axis: there are two."""
        return "ROTARY" if self.rotary else "LINEAR"

    @property
    def name(self) -> str:
        """Line or joint."""
        return "joint" if self.rotary else "line"

    @property
    def columns(self) -> tuple[str, str, str]:
        """Names of the columns of position, speed and force in data files."""
        return ("angle_rad", "speed_rad_s", "moment_Nm") if self.rotary else ("position_m", "speed_m_s", "force_N")


LINEAR = Axis(False, "position", "m", "speed", "m/s", "force", "N", "mass", "kg")
ROTARY = Axis(True, "angle", "rad", "angular speed", "rad/s", "moment", "N m", "moment of inertia", "kg m^2")

PLANE = ("speed", "force")
"""Dimensions of a map over the force-speed plane."""


def speed_axis() -> Any:
    """Field of a result with an `axis`: the speeds of its map. (n,)"""
    return reported("m s-1 or rad s-1", "speed of the load or angular speed of the load", PLANE[:1])


def force_axis() -> Any:
    """Field of a result with an `axis`: the forces of its map. (m,)"""
    return reported("N or N m", "force on the load or moment on the load", PLANE[1:])
