"""Geometry of a platform on rods, as a study states it: in pairs, or joint by joint."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from annotated_types import Gt, Interval

from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, quantity, several
from infinivar.errors import ParameterError, require
from infinivar.motion.vectors import Point
from infinivar.transmission.platform import Platform


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformGeometry:
    """Six rods in three pairs, or rods anywhere: the positions of the guideways and of the platform's joints."""

    rod_length: float = quantity("m", Gt(0), "Length of the rods between their joints")
    base_radius: float | None = quantity(
        "m", Gt(0), "Radius of the circle of guideways, for rods in pairs", default=None
    )
    joint_radius: float | None = quantity(
        "m", Gt(0), "Radius of the circle of platform joints, for rods in pairs", default=None
    )
    base_spread: float | None = quantity(
        "rad", Interval(gt=0, lt=1.6), "Half the angle between the guideways of a pair", default=None
    )
    joint_spread: float | None = quantity(
        "rad", Interval(gt=0, lt=1.6), "Half the angle between the joints of two rods that meet", default=None
    )
    guideways: tuple[Point, ...] | None = several("Positions of the guideways, instead of pairs", Point, default=None)
    joints: tuple[Point, ...] | None = several("Joints in axes of the platform, instead of pairs", Point, default=None)
    lowest: float | None = quantity("m", FINITE, "Lowest position of the links; unlimited if not given", default=None)
    highest: float | None = quantity("m", FINITE, "Highest position of the links; unlimited if not given", default=None)
    platform: Platform = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Validate the fields and make the platform."""
        check(self)
        pairs = [name for name in _PAIRS if getattr(self, name) is not None]
        points = [name for name in _POINTS if getattr(self, name) is not None]
        if pairs and points:
            raise ParameterError(
                f"{points[0]} and {pairs[0]} exclude each other: state rods in pairs by {', '.join(_PAIRS)}, or "
                f"{' and '.join(_POINTS)}"
            )
        missing = [name for name in (_POINTS if points else _PAIRS) if getattr(self, name) is None]
        if missing:
            raise ParameterError(f"{missing[0]} is missing: rods need {', '.join(_PAIRS)}, or {' and '.join(_POINTS)}")
        if (self.lowest is None) is not (self.highest is None):
            lacking = "lowest" if self.lowest is None else "highest"
            raise ParameterError(f"{lacking} is missing: a stroke has both ends, lowest and highest")
        stroke = None if self.lowest is None or self.highest is None else (self.lowest, self.highest)
        if stroke is not None:
            require(stroke[0] < stroke[1], "highest", f"{stroke[1]:g} m", f"> lowest, {stroke[0]:g} m")
        if points:
            rows = [[one.row(("x", "y", "z")) for one in getattr(self, name)] for name in _POINTS]
            for name, row in zip(_POINTS, rows, strict=True):
                require(len(row) >= 6, name, f"{len(row)} points", "6 or more, one for each rod")
            require(len(rows[0]) == len(rows[1]), "joints", f"{len(rows[1])}", f"as many as guideways, {len(rows[0])}")
            made = Platform(base=rows[0], joints=rows[1], rod_length=self.rod_length, stroke=stroke)
        else:
            pairs = {name: getattr(self, name) for name in _PAIRS}
            made = replace(Platform.hexapod(**pairs, rod_length=self.rod_length, stroke=stroke), provenance="given")
        _ = made.home  # refuses rods that do not reach the platform
        object.__setattr__(self, "platform", made)


_PAIRS = ("base_radius", "joint_radius", "base_spread", "joint_spread")
_POINTS = ("guideways", "joints")
