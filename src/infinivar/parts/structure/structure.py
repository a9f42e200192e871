"""What holds a drive together: assumed factors that size the bodies without a data sheet, and masses that are known."""

from __future__ import annotations

from dataclasses import dataclass

from annotated_types import Gt, Interval

from infinivar._core.fields import check, component, quantity
from infinivar.contact.bodies import Material
from infinivar.errors import ParameterError
from infinivar.parts.structure.stock import StockSpring

_FACTOR = Interval(gt=0, le=100)
_WEIGHED = "Mass, from a scale or CAD; by default derived"


@dataclass(frozen=True, slots=True, kw_only=True)
class Structure:
    """How a drive is built around its bought parts.

    The factors are assumed: usual in machine design, and open to choice. A mass that is stated replaces what is derived.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    material: Material | None = component(
        "Material of frame, bell, pulleys and linkage; default: aluminium 7075-T6", default=None
    )
    travel: float | None = quantity(
        "m",
        Gt(0),
        "Travel of the drive's own output from end to end, where neither motions nor requirement of the study state one",
        default=None,
    )
    strength_margin: float = quantity(
        "1", _FACTOR, "Yield strength over stress of cylinder, frame and linkage, under loads that pulsate", default=3.0
    )
    frame_deflection: float = quantity(
        "1", Interval(gt=0, le=0.1), "Deflection of the frame under the largest load, over its span", default=1e-3
    )
    least_wall: float = quantity(
        "m", Interval(gt=0, le=0.1), "Thinnest wall that can be made, and that of the bell", default=2e-3
    )
    room: float = quantity("m", Interval(ge=0, le=1), "Free length at each end of the travel", default=5e-3)
    rail_margin: float = quantity("1", _FACTOR, "Static rating of the rail over its load", default=2.0)
    pull_ratio: float = quantity(
        "1",
        _FACTOR,
        "Sum of the tensions of belt or cable over its largest force, where its pull is not stated",
        default=2.5,
    )
    pulley_width: float = quantity(
        "m", Interval(gt=0, le=1), "Width of pinions, racks and pulleys whose belt is not known", default=10e-3
    )
    belt_density: float = quantity(
        "kg/m", Gt(0), "Mass over length of a cable, or a belt that is not known", default=0.03
    )
    nut_ratio: float = quantity("1", _FACTOR, "Length of a nut over the diameter of its screw", default=3.0)
    spring_deflection: float = quantity("m", Gt(0), "Deflection of the preload spring under the preload", default=1e-3)
    preload_spring: StockSpring | None = component(
        "Preload spring of each wheel, from stock; by default wire that stores its energy", default=None
    )
    stock_springs: bool = component(
        "Whether the preload spring is the lightest of the catalogue that carries the preload", default=False
    )
    spring_strength: float = quantity("Pa", Gt(0), "Permissible stress in the wire of springs", default=700e6)
    motor_density: float = quantity(
        "kg/m^3", Gt(0), "Mass over volume of motors and gearheads whose length is not stated", default=5000.0
    )
    motor_slenderness: float = quantity(
        "1", _FACTOR, "Length over diameter of motors and gearheads of which neither is stated", default=1.7
    )
    cylinder_mass: float | None = quantity("kg", Gt(0), f"Cylinder. {_WEIGHED}", default=None)
    wheel_mass: float | None = quantity("kg", Gt(0), f"All wheels and axles. {_WEIGHED}", default=None)
    bell_mass: float | None = quantity("kg", Gt(0), f"All bells. {_WEIGHED}", default=None)
    stage_mass: float | None = quantity(
        "kg", Gt(0), f"Pulleys and cable, belt, screw or rack. {_WEIGHED}", default=None
    )
    bearings_mass: float | None = quantity(
        "kg", Gt(0), f"Bearings of cylinder or output stage. {_WEIGHED}", default=None
    )
    carriage_mass: float | None = quantity("kg", Gt(0), f"Carriage of the guideway. {_WEIGHED}", default=None)
    ring_mass: float | None = quantity(
        "kg", Gt(0), f"Ring of the carriage that holds several wheels. {_WEIGHED}", default=None
    )
    rail_mass: float | None = quantity("kg", Gt(0), f"Rail of the guideway. {_WEIGHED}", default=None)
    springs_mass: float | None = quantity("kg", Gt(0), f"Springs. {_WEIGHED}", default=None)
    linkage_mass: float | None = quantity("kg", Gt(0), f"Linkage. {_WEIGHED}", default=None)
    frame_mass: float | None = quantity("kg", Gt(0), f"Frame. {_WEIGHED}", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if self.preload_spring is not None and self.stock_springs:
            raise ParameterError("stock_springs must be false with a preload_spring, which is stated already, got true")
