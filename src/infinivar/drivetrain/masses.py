"""What a drive weighs, and which of its values follow from its bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from infinivar._core.array_namespace import Array
from infinivar.drivetrain.body import Body, open_bodies, total
from infinivar.drivetrain.building.cobotic import CoboticBuilding
from infinivar.drivetrain.building.geared import GearedBuilding
from infinivar.drivetrain.service import NO_SERVICE, Service
from infinivar.errors import ParameterError
from infinivar.limits import Demand


def cobotic_bodies(drive: Any, service: Service) -> tuple[Body, ...]:
    """Bodies of a cobotic drive.

    Parameters
    ----------
    drive : CoboticDrive    Its values may be arrays of many designs.
    service : Service

    Source: `infinivar.parts.structure`, and the rows of the catalogue.
    """
    return tuple(CoboticBuilding(drive, service))


def geared_bodies(drive: Any, service: Service) -> tuple[Body, ...]:
    """Bodies of a conventional drive; see `cobotic_bodies`."""
    return tuple(GearedBuilding(drive, service))


def bodies_of(drive: Any, service: Service) -> tuple[Body, ...]:
    """Bodies of a drive, or of what moves the links of a machine; of a machine whose structure is not known one without mass."""
    if hasattr(drive, "drivetrain"):
        return drive.drivetrain(service)
    return (UNWEIGHED,) if hasattr(drive, "perform") else drive.bodies(service)


UNWEIGHED = Body("machine", None, "derived", "what a machine without links weighs is not known", chosen=True)


def shaft_demand(drive: Any, service: Service) -> Mapping[Demand, Array]:
    """Demand over allowance of the room for the shaft of a pulley or pinion; empty of other drives. [-]"""
    return GearedBuilding(drive, service).shaft if hasattr(drive, "stage") else {}


def link_mass(drive: Any) -> Array | None:
    """Mass of what moves with the link of a cobotic drive; None if it is not known. [kg]"""
    made = CoboticBuilding(drive, NO_SERVICE)
    moving = [*(body for body in made.motors() if body.moving), *made.moving()]
    return None if open_bodies(moving) else total(moving)


def bell_inertia(drive: Any) -> Array | None:
    """Inertia of bell, wheel, axle and its bearings about the steering axis; None if it is not known. [kg m^2]"""
    return CoboticBuilding(drive, NO_SERVICE).inertia


def with_tube(drive: Any, service: Service) -> Any:
    """The drive with a cylinder that is known: as stated, else derived; unchanged where that is not possible."""
    made = CoboticBuilding(drive, service)
    tube = None if drive.transmission.geometry is None else made.tube
    if tube is None or drive.transmission.tube is not None or not math.isfinite(tube.wall):
        return drive
    sizes = {"cylinder_wall": tube.wall, "cylinder_length": tube.length, "cylinder_end_plate": tube.end_plate}
    return replace(drive, transmission=replace(drive.transmission, **sizes), cylinder_inertia=None)


def tube_as_of(drive: Any, template: Any) -> Any:
    """A design with its cylinder derived anew, where that of its template is derived; else the design itself."""
    if getattr(template, "transmission", None) is None or template.transmission.tube is not None:
        return drive
    bare = {"cylinder_wall": None, "cylinder_length": None, "cylinder_end_plate": 0.0}
    return replace(drive, transmission=replace(drive.transmission, **bare))


def open_structure(drive: Any, service: Service) -> list[str]:
    """Reasons why the mass of all but motors and gearheads is not known; empty if it is."""
    return list(dict.fromkeys(one.basis for one in drive.bodies(service) if one.mass is None and not one.chosen))


def check_known(drive: Any, service: Service) -> None:
    """Raise ParameterError unless the mass of all but motors and gearheads is known; the message says what is missing."""
    reasons = open_structure(drive, service)
    if reasons:
        raise ParameterError(f"whole masses are not known: {'; '.join(reasons)}")
