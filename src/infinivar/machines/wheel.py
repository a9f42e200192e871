"""A wheel or roller of a machine as a study states it: the machine knows the surface on which it rolls."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from annotated_types import Ge, Gt

from infinivar._core.fields import check, component, quantity
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw
from infinivar.errors import ParameterError
from infinivar.transmission.geometry import ContactGeometry, SurfaceShape
from infinivar.transmission.rolling_contact import CREEP_LAW, MEASURED, RollingContact, scaled_by_preload


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """A preloaded wheel or roller, by measured values or by its geometry."""

    wheel_radius: float = quantity("m", Gt(0), "Rolling radius of the wheel")
    preload: float = quantity("N", Gt(0), "Normal force between wheel and surface")
    friction: float = quantity("1", Gt(0), "Rolling friction limit mu: the contact slips at mu times the preload")
    geometry: ContactGeometry | None = component(
        "Geometry, materials and bearings, which determine creep stiffness and torques", default=None
    )
    creep_stiffness: float | None = quantity(
        "N", Gt(0), "Measured creep stiffness, lateral force over creepage", default=None
    )
    rolling_torque: float | None = quantity(
        "N m", Ge(0), "Measured hysteresis torque of the rolling contact, about the wheel axle", default=None
    )
    bearing_torque: float | None = quantity(
        "N m", Ge(0), "Measured friction torque of the wheel's axle bearings", default=None
    )
    creep_law: CreepLaw = component(CREEP_LAW, default=None)

    def __post_init__(self) -> None:
        """Validate the fields; without a creep law, choose as `RollingContact` does."""
        check(self)
        usual = creep.LINEAR if self.geometry is None else creep.EXACT
        law = usual if self.creep_law is None else creep.law(self.creep_law)
        if law.flow_factor is not None:
            raise ParameterError(
                f"creep_law must be one without a flow loss, got {law.name!r}: Eq 17 is a loss of the link speed of a wheel on "
                "a cylinder"
            )
        object.__setattr__(self, "creep_law", law)
        given = [name for name in MEASURED if getattr(self, name) is not None]
        if self.geometry is not None and given:
            raise ParameterError(f"{given[0]} and geometry exclude each other: geometry determines {given[0]}")
        if self.geometry is None and len(given) < len(MEASURED):
            missing = next(name for name in MEASURED if name not in given)
            raise ParameterError(
                f"{missing} is missing: give {', '.join(MEASURED)}, or geometry, which determines all three"
            )

    def pressed(self, preload: float) -> Wheel:
        """The same wheel under another preload [N]; measured values scale as those of `RollingContact`."""
        return replace(self, preload=preload, **scaled_by_preload(self, preload))

    def on(self, surface: SurfaceShape, radius: float | None = None) -> RollingContact:
        """The contact of the wheel with a surface of a radius [m]."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return RollingContact(**values, surface=surface, surface_radius=radius)
