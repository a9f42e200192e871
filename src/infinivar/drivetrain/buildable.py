"""What cannot be built: masses of bodies that a drive does not have, and parts that do not fit each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from infinivar._core.fields import given
from infinivar.drivetrain.service import Service
from infinivar.errors import ParameterError
from infinivar.parts.structure.bodies import crown_height
from infinivar.parts.structure.tube import THICKEST
from infinivar.units import show, show_in


def check_stated(drive: Any) -> None:
    """Raise ParameterError if a mass is stated of a body that a drive does not have."""
    stage, output = getattr(drive, "stage", None), drive.output
    has = {"stage": False, "cylinder": True, "wheel": True, "bell": True, "linkage": output.linkage is not None}
    has["springs"] = any(place.kind in ("series", "parallel") for place in output.chain)
    if stage is not None:
        has |= {"cylinder": False, "wheel": False, "bell": False, "stage": stage.title != "shaft"}
        has |= dict.fromkeys(("bearings", "carriage", "rail", "frame"), stage.title != "shaft")
    for name, known in has.items():
        if not known and getattr(drive.structure, f"{name}_mass") is not None:
            raise ParameterError(f"structure.{name}_mass does not apply: the drive has no {name}; remove it")


def impossible(drive: Any, service: Callable[[], Service]) -> str | None:
    """Why a drive of plain numbers cannot be built, with the field and what would be right; None if nothing speaks against it.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    service : callable   Called where travel or force matter.
    """
    rail = getattr(drive.guideway, "rail", None)
    if hasattr(drive, "stage"):
        force = service().force if rail is not None else None
        if rail is not None and force is not None and rail.static_rating < force:
            found = f"guideway.rail.static_rating must be >= {show(force, 'N')}, the largest force"
            return f"{found}, got {show(rail.static_rating, 'N')}"
        return _thin_pulley(drive)
    element = drive.transmission
    geometry = element.geometry
    if geometry is None:
        return None
    bore, radius, span = geometry.axle_bearing.bore, element.wheel_radius, geometry.bearing_span
    rim = radius - float(crown_height(geometry.crown_radius, geometry.wheel_width))
    travel = service().travel if element.cylinder_length is not None else None
    path = "transmission.geometry"
    faults = (
        (bore < 2.0 * radius, f"{path}.axle_bearing.bore must be < {_mm(2.0 * radius)}, the wheel's diameter", bore),
        (
            rim > 0.5 * bore,
            f"{path}.wheel_width must be less: the rim falls below the axle",
            geometry.wheel_width,
        ),
        (
            span is None or span > geometry.wheel_width,
            f"{path}.bearing_span must be > {_mm(geometry.wheel_width)}, the wheel's width",
            given(span, 0.0),
        ),
        (
            drive.structure.least_wall <= THICKEST * element.cylinder_radius,
            f"structure.least_wall must be <= {_mm(THICKEST * element.cylinder_radius)}, {THICKEST:g} cylinder_radius",
            drive.structure.least_wall,
        ),
        (
            travel is None or element.cylinder_length is None or element.cylinder_length > travel,
            f"transmission.cylinder_length must be > {_mm(given(travel, 0.0))}, the travel",
            given(element.cylinder_length, 0.0),
        ),
    )
    return next((f"{said}, got {_mm(value)}" for fine, said, value in faults if not fine), None)


def _thin_pulley(drive: Any) -> str | None:
    """Why the shaft in the bearings that a geared drive states does not go with its pulley or pinion; None if it does."""
    stage, held = drive.stage, getattr(drive.stage, "bearings", None)
    if held is None:
        return None
    bore = given(held.bore, getattr(held.bearing, "bore", None))
    if bore is None or bore <= 2.0 * stage.travel_per_radian:
        return None
    path = "bore" if held.bearing is None else "bearing.bore"
    most, wheel = (
        _mm(2.0 * stage.travel_per_radian),
        {"belt": "belt wheel", "rack": "pinion"}.get(stage.title, stage.title),
    )
    return f"{stage.title}.bearings.{path} must be <= {most}, the diameter of the {wheel}, got {_mm(bore)}"


def _mm(value: float) -> str:
    return show_in(value, "m", "mm", 3)
