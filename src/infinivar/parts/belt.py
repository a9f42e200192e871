"""Timing belts and racks: they convert rotation to linear motion by teeth."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check, component, given, quantity
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.shaft_bearings import PulleyBearings
from infinivar.parts.stage import OutputStage, force_limit


def _check_teeth(teeth: Array) -> None:
    """Raise ParameterError unless a number of teeth is whole; arrays, such as those of derivatives, are left alone."""
    require(not isinstance(teeth, float) or teeth.is_integer(), "teeth", teeth, "a whole number")


def pitch_radius(pitch: Array, teeth: Array) -> Array:
    """Pitch radius of a wheel with teeth at a pitch, ``pitch teeth/(2 pi)``. [m]

    Source: definition of the pitch circle.
    """
    return pitch * teeth / (2.0 * math.pi)


def belt_stiffness(specific_stiffness: Array, span: Array, other_span: Array | None = None) -> Array:
    """Stiffness of a belt between the drive wheel, held at rest, and the load.

    Parameters
    ----------
    specific_stiffness : (...,) float   Tension per strain of the belt. [N]
    span : (...,) float                 Length of the span between drive wheel and load. [m]
    other_span : (...,) float           Length of the span on the other way round, if pretension keeps it taut: both spans act
        in parallel. None: it is slack. [m]

    Returns
    -------
    (...,) float   [N m^-1]

    Source: Hooke's law for springs in parallel.
    """
    stiffness = specific_stiffness / span
    return stiffness if other_span is None else stiffness + specific_stiffness / other_span


@dataclass(frozen=True, slots=True, kw_only=True)
class TimingBelt:
    """Timing belt, as data sheets state it.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    name: str = component("Name for reports", default="belt")
    pitch: float = quantity("m", Gt(0), "Pitch of the belt's teeth")
    width: float | None = quantity("m", Gt(0), "Width of the belt, for masses", default=None)
    belt_density: float | None = quantity("kg/m", Gt(0), "Mass of the belt over its length", default=None)
    permissible_force: float | None = quantity(
        "N", Gt(0), "Permissible force of the teeth in mesh or tension", default=None
    )
    specific_stiffness: float | None = quantity(
        "N", Gt(0), "Tension per strain: with `span` the belt stretches", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def weight(self) -> float:
        """Mass over the length, by which belts are ordered. [kg/m]"""
        return given(self.belt_density, math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class Belt(OutputStage, TimingBelt):
    """Timing belt from the gearhead's shaft to a load that moves along the belt."""

    title: ClassVar[str] = "belt"
    letter: ClassVar[str] = "b"

    teeth: float = quantity("1", Gt(0), "Number of teeth of the drive wheel")
    efficiency: float = quantity("1", Interval(gt=0, le=1), "Efficiency while the motor drives", default=1.0)
    backdriving_efficiency: float | None = quantity(
        "1", Interval(ge=0, le=1), "Efficiency while the load drives; default: `efficiency`", default=None
    )
    friction_torque: float = quantity("N m", Ge(0), "Coulomb friction torque of wheels and bearings", default=0.0)
    bearings: PulleyBearings | None = component(
        "Bearings of the drive wheel's shaft under the pull of the belt, which add to friction_torque", default=None
    )
    span: float | None = quantity("m", Gt(0), "Length of the span between drive wheel and load", default=None)
    other_span: float | None = quantity(
        "m", Gt(0), "Length of the span on the other way round, if pretension keeps it taut", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_teeth(self.teeth)
        if self.specific_stiffness is None and (self.span is not None or self.other_span is not None):
            raise ParameterError("specific_stiffness is missing: span needs it")

    @property
    def travel_per_radian(self) -> float:
        """Pitch radius of the drive wheel. [m/rad]"""
        return pitch_radius(self.pitch, self.teeth)

    @property
    def efficiencies(self) -> tuple[float, float]:
        """Efficiencies while the shaft drives and while the load drives. [-]"""
        return self.efficiency, given(self.backdriving_efficiency, self.efficiency)

    @property
    def stiffness(self) -> float | None:
        """Stiffness of the belt at the load; None if rigid. [N/m]"""
        if self.specific_stiffness is None or self.span is None:
            return None
        return belt_stiffness(self.specific_stiffness, self.span, self.other_span)

    def without_friction(self) -> Belt:
        """The belt without losses."""
        return replace(self, efficiency=1.0, backdriving_efficiency=None, friction_torque=0.0, bearings=None)

    def utilisation(self, *, force: Array, speed: Array) -> dict[Limit, Array]:
        """Demand over allowance of the permissible force; see `OutputStage.utilisation`. [-]"""
        return force_limit(force, self.permissible_force)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rack(OutputStage):
    """Rack and pinion: the gearhead's shaft turns the pinion, the rack moves the load."""

    title: ClassVar[str] = "rack"
    letter: ClassVar[str] = "r"

    module: float = quantity("m", Gt(0), "Transverse module: pitch diameter of the pinion over its number of teeth")
    teeth: float = quantity("1", Gt(0), "Number of teeth of the pinion")
    efficiency: float = quantity("1", Interval(gt=0, le=1), "Efficiency while the motor drives", default=1.0)
    backdriving_efficiency: float | None = quantity(
        "1", Interval(ge=0, le=1), "Efficiency while the load drives; default: `efficiency`", default=None
    )
    friction_torque: float = quantity("N m", Ge(0), "Coulomb friction torque of the pinion's bearings", default=0.0)
    permissible_force: float | None = quantity("N", Gt(0), "Permissible force of the teeth", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _check_teeth(self.teeth)

    @property
    def travel_per_radian(self) -> float:
        """Pitch radius of the pinion. [m/rad]"""
        return pitch_radius(math.pi * self.module, self.teeth)

    @property
    def efficiencies(self) -> tuple[float, float]:
        """Efficiencies while the shaft drives and while the load drives. [-]"""
        return self.efficiency, given(self.backdriving_efficiency, self.efficiency)

    def without_friction(self) -> Rack:
        """The rack without losses."""
        return replace(self, efficiency=1.0, backdriving_efficiency=None, friction_torque=0.0)

    def utilisation(self, *, force: Array, speed: Array) -> dict[Limit, Array]:
        """Demand over allowance of the permissible force; see `OutputStage.utilisation`. [-]"""
        return force_limit(force, self.permissible_force)
