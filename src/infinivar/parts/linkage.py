"""Linkages between a joint and a drive: lever, lever arm by angle, linear actuator across the joint, four-bar.

A linkage maps the joint angle to the position of the drive: a length for a drive along a line, an angle for a four-bar
driven by a shaft. Its derivative with respect to the joint angle is the lever arm (of a four-bar, the ratio), which also
maps the drive's force to the joint's moment, so an ideal linkage conserves power.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from annotated_types import Gt

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, component, quantities, quantity

LinkageShape = Literal["lever", "table", "crank", "four-bar"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """Linkage between a joint and a drive.

    - ``lever``: constant lever `arm`, as of a cable on a pulley about the joint;
    - ``table``: lever arm by joint angle, `arms` at `angles`;
    - ``crank``: linear actuator between a pivot on the fixed link at distance `base` from the joint and one on the moving
      link at distance `arm`; `offset` is the angle between both at joint angle 0;
    - ``four-bar``: the drive's shaft turns a crank of length `crank`, which moves the joint's rocker of length `arm` by a
      `coupler`; `base` is the distance of the shafts.
    """

    shape: LinkageShape = component("lever, table, crank or four-bar", default="lever")
    arm: float | None = quantity("m", Gt(0), "Lever arm, or length of the arm on the joint", default=None)
    angles: tuple[float, ...] | None = quantities("rad", FINITE, "Joint angles of the table, increasing", default=None)
    arms: tuple[float, ...] | None = quantities("m", Gt(0), "Lever arms at these angles", default=None)
    base: float | None = quantity("m", Gt(0), "Distance of the fixed pivot, or of the drive's shaft", default=None)
    offset: float | None = quantity("rad", FINITE, "Angle between arm and base at joint angle 0", default=None)
    crank: float | None = quantity("m", Gt(0), "Length of the crank on the drive's shaft", default=None)
    coupler: float | None = quantity("m", Gt(0), "Length of the coupler", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def rotary_drive(self) -> bool:
        """Whether the drive's side turns; else it moves along a line."""
        return self.shape == "four-bar"
