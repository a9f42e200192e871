"""Effect of design changes of the wheel on the losses of the transmission, all else equal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.described import reported
from infinivar._core.result import Result, result
from infinivar.analysis.robustness.derivatives import gradient, values_of
from infinivar.errors import ParameterError
from infinivar.limits import Limit, binding, codes
from infinivar.parts.bearing import SIZE_POWERS
from infinivar.study.catalogue import materials
from infinivar.transmission.geometry import ContactGeometry
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT


@dataclass(frozen=True, slots=True, kw_only=True)
class Duty:
    """A steady operating point common to all variants of a design."""

    cylinder_speed: float
    """[rad/s]"""
    link_force: float
    """[N]"""
    ratio: float
    """Cylinder surface speed over link speed."""

    def at(self, element: RotaryLinearIVT) -> OperatingPoint:
        """The transmission at this operating point; nan if it would slip."""
        surface = element.cylinder_radius * abs(self.cylinder_speed)
        return element.deliver(
            cylinder_speed=abs(self.cylinder_speed), link_speed=surface / self.ratio, link_force=self.link_force
        )


def with_friction(element: RotaryLinearIVT, friction: float) -> RotaryLinearIVT:
    """The design with another friction coefficient and the preload that keeps the slip force."""
    return replace(element.pressed(element.wheel.slip_force / friction), friction=friction)


def with_wheel_radius(element: RotaryLinearIVT, wheel_radius: float) -> RotaryLinearIVT:
    """The design with another rolling radius."""
    return replace(element, wheel_radius=wheel_radius)


def with_crown_radius(element: RotaryLinearIVT, crown_radius: float) -> RotaryLinearIVT:
    """The design with another crown radius."""
    return replace(element, geometry=replace(_geometry(element), crown_radius=crown_radius))


def with_hysteresis(element: RotaryLinearIVT, factor: float) -> RotaryLinearIVT:
    """The design with another hysteresis loss factor of both bodies."""
    return _with_bodies(element, hysteresis_factor=factor)


def with_youngs_modulus(element: RotaryLinearIVT, modulus: float) -> RotaryLinearIVT:
    """The design with another Young's modulus, and hence shear modulus, of both bodies."""
    return _with_bodies(element, youngs_modulus=modulus)


def with_axle(element: RotaryLinearIVT, bore: float) -> RotaryLinearIVT:
    """The design with axle bearings of another bore; sizes scale with the bore, ratings by their powers."""
    geometry = _geometry(element)
    bearing = geometry.axle_bearing
    scale = bore / bearing.bore
    scaled = replace(bearing, **{name: getattr(bearing, name) * scale**power for name, power in SIZE_POWERS.items()})
    return replace(element, geometry=replace(geometry, axle_bearing=scaled))


def with_material(element: RotaryLinearIVT, name: str) -> RotaryLinearIVT:
    """The design with wheel and cylinder of one catalogue material."""
    material = materials()[name]
    geometry = replace(_geometry(element), wheel_material=material, cylinder_material=material)
    return replace(element, geometry=geometry)


SWEPT: dict[str, tuple[Callable[..., RotaryLinearIVT], Callable[[RotaryLinearIVT], Any]]] = {
    "preload": (RotaryLinearIVT.pressed, lambda element: element.preload),
    "friction": (with_friction, lambda element: element.friction),
    "wheel_radius": (with_wheel_radius, lambda element: element.wheel_radius),
    "crown_radius": (with_crown_radius, lambda element: _geometry(element).crown_radius),
    "youngs_modulus": (with_youngs_modulus, lambda element: _geometry(element).wheel_material.youngs_modulus),
    "hysteresis_factor": (with_hysteresis, lambda element: _geometry(element).hysteresis_factor),
    "axle_bore": (with_axle, lambda element: _geometry(element).axle_bearing.bore),
}
"""Design parameters: function that makes a variant, and function that returns the present value."""


_AT = ("value",)


@result
class Trend(Result):
    """Efficiency and losses of variants of a design."""

    parameter: str = reported(attribute="parameter")
    """One of `SWEPT`, or "material"."""
    values: np.ndarray = reported(dims=_AT, variable="value")
    efficiency: np.ndarray = reported("1", dims=_AT)
    """nan where the wheel slips. [-]"""
    losses: Mapping[str, np.ndarray] = reported("W", "power lost in {}", _AT, variable="loss_{}")
    """[W]"""
    limit: tuple[Limit, ...] = reported("1", dims=_AT, convert=np.int8, notes=codes)
    """Binding limit of each variant, stress included."""


def sweep(element: RotaryLinearIVT, parameter: str, values: Any, duties: Sequence[Duty]) -> tuple[Trend, ...]:
    """Compute efficiency and losses at operating points over values of one design parameter.

    Parameters
    ----------
    element : RotaryLinearIVT   Transmission with geometry.
    parameter : str             One of `SWEPT`, or "material" with catalogue names as values.
    values : (n,) sequence      Values in SI.
    duties : sequence of Duty   Operating points common to all variants.

    Returns
    -------
    tuple of Trend   One per operating point.

    Raises
    ------
    ParameterError
        If the element has measured groups: they do not follow from a design.
    """
    if parameter == "material":
        variants = [with_material(element, name) for name in values]
    else:  # all in one
        variants = [SWEPT[parameter][0](element, np.array(values, dtype=float))]
    each = (len(values) // len(variants),)
    stressed = [_exceeded(variant) for variant in variants]

    def joined(parts: Iterable[Any]) -> np.ndarray:
        return np.concatenate([np.broadcast_to(one, each) for one in parts])

    def trend(duty: Duty) -> Trend:
        points = [duty.at(variant) for variant in variants]
        limit, stress = joined(point.limit for point in points), joined(stressed)
        return Trend(
            parameter=parameter,
            values=np.array(values),
            efficiency=joined(point.efficiency for point in points),
            losses={name: joined(point.losses[name] for point in points) for name in points[0].losses},
            limit=tuple(Limit(int(code)) for code in np.where(limit == Limit.OK, stress, limit)),
        )

    return tuple(map(trend, duties))


def _exceeded(element: RotaryLinearIVT) -> Array:
    """Code of the most exceeded stress limit of a design, or of several in arrays, if any."""
    assert element.contact is not None
    return binding(_geometry(element).stress(element.contact).utilisation)[0]


def _of_both(field: str) -> dict[str, float]:
    return {f"geometry.{body}_material.{field}": 1.0 for body in ("wheel", "cylinder")}


_POWERS: dict[str, dict[str, float]] = {
    "preload": {"preload": 1.0},
    "friction": {"friction": 1.0, "preload": -1.0},
    "wheel_radius": {"wheel_radius": 1.0},
    "crown_radius": {"geometry.crown_radius": 1.0},
    "youngs_modulus": _of_both("youngs_modulus"),
    "hysteresis_factor": _of_both("hysteresis_factor"),
    "axle_bore": {f"geometry.axle_bearing.{name}": power for name, power in SIZE_POWERS.items()},
}
"""Fields that vary with each of `SWEPT`, and the power by which they scale."""


def elasticities(element: RotaryLinearIVT, parameter: str, duty: Duty) -> dict[str, float]:
    """Relative change of each loss, and of their sum ("total"), per relative change of a design parameter. [-]

    Exact derivatives by complex step; 0 for a loss that is zero.

    Parameters
    ----------
    element : RotaryLinearIVT   Transmission with geometry.
    parameter : str             One of `SWEPT`.
    duty : Duty                 Operating point of the losses.

    Raises
    ------
    ParameterError
        If the element has measured groups: they do not follow from a design.

    Source: squire1998 for the derivatives.
    """
    _geometry(element)
    paths = list(_POWERS[parameter])
    weights = values_of(element, paths) * np.asarray(list(_POWERS[parameter].values()))
    found, change, whole = {}, 0.0, 0.0
    for name in ("creep", "rolling", "bearing"):

        def loss(variant: RotaryLinearIVT, name: str = name) -> Array:
            return duty.at(variant).losses[name][..., 0]

        value, slopes = gradient(loss, element, paths)
        moved = float(slopes @ weights)
        found[name] = moved / float(value) if value else 0.0
        change, whole = change + moved, whole + float(value)
    return {**found, "total": change / whole}


def _geometry(element: RotaryLinearIVT) -> ContactGeometry:
    if element.geometry is None:
        raise ParameterError(
            "the transmission is given by measured groups, which do not depend on a design; define its geometry"
        )
    return element.geometry


def _with_bodies(element: RotaryLinearIVT, **change: float) -> RotaryLinearIVT:
    geometry = _geometry(element)
    changed = replace(
        geometry,
        wheel_material=replace(geometry.wheel_material, **change),
        cylinder_material=replace(geometry.cylinder_material, **change),
    )
    return replace(element, geometry=changed)
