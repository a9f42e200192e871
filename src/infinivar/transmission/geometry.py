"""Losses of a rolling contact from its geometry, materials and bearings."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from annotated_types import Gt, Interval

from infinivar._core.array_namespace import Array, as_floats, namespace, plain
from infinivar._core.fields import check, component, given, quantity
from infinivar.contact import friction as friction_law
from infinivar.contact import hertz, hysteresis, kalker, turned
from infinivar.contact.bodies import Cylinder, Material, Plane, Sphere, Surface, Wheel
from infinivar.contact.creep import CreepLaw, Formulas
from infinivar.contact.exact_law import STEEL_CIRCLE
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.bearing import Bearing, BearingPair
from infinivar.parts.structure.beams import Section, stress
from infinivar.parts.structure.bodies import close_span, crown_height
from infinivar.transmission import creepage

SurfaceShape = Literal["cylinder", "sphere", "plane"]


class LossGroups(NamedTuple):
    """Parameters that determine the losses of a wheel on a cylinder, at one cylinder speed."""

    slip_force: Array
    """mu P. [N]"""
    creep_stiffness: Array
    """C = C22 G a b, lateral force over creepage. [N]"""
    rolling_torque: Array
    """Hysteresis torque about the wheel axle. [N m]"""
    bearing_torque: Array
    """Friction torque of the axle bearings. [N m]"""
    wheel_radius: Array
    """r. [m]"""
    full_slip: Array
    """Scaled creepage C u/(mu P |v|) at which the whole patch slips by exact theory. [-]"""
    axis_ratio: Array = STEEL_CIRCLE[0]
    """a/b, rolling over lateral semi-axis of the patch; assumed if only measured values are known. [-]"""
    poisson: Array = STEEL_CIRCLE[1]
    """Combined nu; assumed if only measured values are known. [-]"""
    yielding: tuple[Array, Array] | None = None
    """How the creep compliance changes with the steering angle; None: `creep_stiffness` holds at all angles. [-]"""

    def formulas(self, law: CreepLaw) -> Formulas:
        """The law's formulas on this patch."""
        return law.on(self.axis_ratio, self.poisson)

    def compliance(self, share: Array) -> tuple[Array, Array, Array]:
        """Creep compliance relative to that of the wheel at steering angle 0, and its derivatives by `share`.

        Parameters
        ----------
        share : (...,) float   Square of the sine of the steering angle. [-]

        Returns
        -------
        compliance, slope, curvature : (...,) float   [-]
        """
        return (1.0, 0.0, 0.0) if self.yielding is None else creepage.compliance(share, *self.yielding)

    def steered(self, share: Array) -> LossGroups:
        """The same with the creep stiffness at a steering angle; see `compliance`."""
        if self.yielding is None:
            return self
        return self._replace(creep_stiffness=self.creep_stiffness / self.compliance(share)[0])

    def shared(self, wheels: int) -> LossGroups:
        """Of several equal wheels that share a force: sums of forces, stiffnesses and torques; H and K do not change."""
        if wheels == 1:
            return self
        sums = ("slip_force", "creep_stiffness", "rolling_torque", "bearing_torque")
        return self._replace(**{name: wheels * getattr(self, name) for name in sums})

    def slip_creepage(self, law: CreepLaw) -> Array:
        """Scaled creepage at the slip limit: where the creep law saturates, or full slip by exact theory if lower. [-]"""
        full, saturated = self.full_slip, self.formulas(law).slip_creepage
        if isinstance(full, (int, float)) and isinstance(saturated, (int, float)):
            return min(full, saturated)
        return namespace(full, saturated).where(full < saturated, full, saturated)

    @property
    def rolling_force(self) -> Array:
        """Rolling resistance, (tau_in + tau_wa)/r. [N]"""
        return (self.rolling_torque + self.bearing_torque) / self.wheel_radius

    @property
    def rolling_group(self) -> Array:
        """H = (tau_in + tau_wa)/(r mu P), rolling resistance over slip force. [-]"""
        return self.rolling_force / self.slip_force

    @property
    def creep_group(self) -> Array:
        """K = C/(mu P); the slip limit of the linear law is the creepage 1/K. [-]"""
        return self.creep_stiffness / self.slip_force


PRELOAD_POWERS = {"creep_stiffness": 2.0 / 3.0, "rolling_torque": 4.0 / 3.0, "bearing_torque": 1.0}
"""Exponent of the preload with which each measured value scales; semi-axes scale with the cube root of preload.

Source: johnson1985, section 4.2; faulring2006, sections III-A and III-B; bearings with a constant coefficient of friction.
"""


class PressedContact(NamedTuple):
    """Static contact of a wheel pressed on its cylinder."""

    patch: hertz.Ellipse
    rotation: Array
    """Rotation of the patch from the rolling direction. [rad]"""
    shear_modulus: Array
    """Combined G. [Pa]"""
    poisson: Array
    """Combined nu. [-]"""
    coefficients: kalker.KalkerCoefficients
    """Of the patch as if it were not rotated. [-]"""

    @property
    def axis_ratio(self) -> Array:
        """a/b, rolling over lateral semi-axis. [-]"""
        return self.patch.a / self.patch.b

    @property
    def full_slip(self) -> Array:
        """Scaled creepage at which the whole patch slips; see `infinivar.contact.kalker.full_slip_creepage`. [-]"""
        return plain(kalker.full_slip_creepage(self.axis_ratio, self.poisson, self.coefficients.c22))

    @property
    def creep_stiffness(self) -> Array:
        """C = C22 G a b with the coefficient of the patch as it is turned: `lateral_coefficient`. [N]

        Source: kalker1990, linear theory; faulring2006, Eq 7.
        """
        return self.lateral_coefficient * self.shear_modulus * self.patch.a * self.patch.b

    @property
    def lateral_coefficient(self) -> Array:
        """C22 of the patch as it is turned from the rolling direction; see `infinivar.contact.turned`. [-]"""
        if isinstance(self.rotation, float) and self.rotation == 0.0:
            return self.coefficients.c22
        return plain(turned.lateral_coefficient(self.axis_ratio, self.poisson, self.rotation))


MEASURED_FULL_SLIP = 2.586
"""Value of `LossGroups.full_slip` for contacts without known geometry: that of a circular patch of steel.

Source: `infinivar.contact.kalker.full_slip_creepage` at a/b = 1 and Poisson's ratio 0.3.
"""


class ContactStress(NamedTuple):
    """Stresses in the pressed bodies."""

    shear: Mapping[str, Array]
    """Largest shear stress below the surface, by body. [Pa]"""
    depth: Mapping[str, Array]
    """Depth of that stress. [m]"""
    utilisation: Mapping[Limit, Array]
    """Shear over half the yield strength (Tresca), mean pressure over hardness, for the weaker body, if known. [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactGeometry:
    """Geometry, materials and axle bearings of the wheel, which determine creep stiffness and friction torques.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    crown_radius: float = quantity("m", Gt(0), "Crown radius of the wheel, across its rolling direction")
    wheel_material: Material = component("Material of the wheel")
    cylinder_material: Material = component("Material of the cylinder")
    axle_bearing: Bearing = component("One of the two equal bearings of the wheel's axle")
    bearing_span: float | None = quantity("m", Gt(0), "Distance between the axle bearings", default=None)
    wheel_width: float = quantity("m", Gt(0), "Width of the wheel along its axle", default=10e-3)
    axle_strength: float = quantity(
        "Pa",
        Gt(0),
        "Permissible bending stress of axle and cylinder journals, which turn under their load",
        default=300e6,
    )
    lateral_share: float = quantity(
        "1", Interval(ge=0, le=1), "Lateral force over slip force at which bearing friction is evaluated", default=0.5
    )
    fast_friction_ratio: float = quantity(
        "1",
        Interval(gt=0, le=1),
        "Friction limit at high speed over that at rest; 1: independent of speed",
        default=1.0,
    )
    friction_decay_speed: float | None = quantity(
        "m/s", Gt(0), "Surface speed scale over which the friction limit falls", default=None
    )
    wear_coefficient: float | None = quantity(
        "1", Gt(0), "Archard's wear coefficient k of the dry contact", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        bearing = self.axle_bearing.type
        required = "deep_groove or angular_contact, which carry preload and lateral force"
        require(bearing in ("deep_groove", "angular_contact"), "axle_bearing.type", bearing, required)
        if (
            isinstance(self.fast_friction_ratio, float)
            and self.fast_friction_ratio < 1.0
            and self.friction_decay_speed is None
        ):
            raise ParameterError("friction_decay_speed is missing: fast_friction_ratio below 1 needs it")

    @property
    def hysteresis_factor(self) -> float:
        """Combined hysteresis loss factor of both bodies. [-]"""
        return hysteresis.combined_hysteresis(self.wheel_material, self.cylinder_material)

    def press(
        self, *, wheel_radius: Array, cylinder_radius: Array, preload: Array, steering_angle: Array = 0.0
    ) -> PressedContact:
        """The contact under its preload, on a cylinder.

        Parameters
        ----------
        wheel_radius, cylinder_radius : (...,) float   r and R. [m]
        preload : (...,) float                         P, > 0. [N]
        steering_angle : (...,) float                  phi; except at 0 and +-pi/2 the patch is rotated from the rolling
            direction. [rad]

        Returns
        -------
        PressedContact   Plain floats if all arguments are.

        Raises
        ------
        ParameterError
            If an argument is out of range.

        Source: johnson1985, chapter 4; kalker1990, appendix E.
        """
        cylinder = Cylinder(radius=cylinder_radius, material=self.cylinder_material)
        return self.press_on(cylinder, wheel_radius=wheel_radius, preload=preload, steering_angle=steering_angle)

    def surface(self, shape: SurfaceShape, radius: Array | None) -> Surface:
        """What the wheel rolls on, of the material `cylinder_material`; a plane has no radius."""
        if shape == "plane":
            return Plane(material=self.cylinder_material)
        return (Cylinder if shape == "cylinder" else Sphere)(radius=radius, material=self.cylinder_material)

    def press_on(
        self, surface: Surface, *, wheel_radius: Array, preload: Array, steering_angle: Array = 0.0
    ) -> PressedContact:
        """The contact under its preload on any surface; arguments and result as in `press`.

        Source: johnson1985, chapter 4; kalker1990, appendix E.
        """
        wheel = Wheel(rolling_radius=wheel_radius, crown_radius=self.crown_radius, material=self.wheel_material)
        patch, rotation = hertz.crossed(preload, wheel, surface, steering_angle)
        shear_modulus, poisson = kalker.combined(
            wheel.material.shear_modulus,
            wheel.material.poisson,
            surface.material.shear_modulus,
            surface.material.poisson,
        )
        coefficients = kalker.coefficients(patch.a / patch.b, poisson)
        return PressedContact(
            hertz.Ellipse(*map(plain, patch)),
            plain(rotation),
            plain(shear_modulus),
            plain(poisson),
            kalker.KalkerCoefficients(*map(plain, coefficients)),
        )

    def yielding(
        self, contact: PressedContact, *, wheel_radius: Array, cylinder_radius: Array, preload: Array
    ) -> tuple[Array, Array]:
        """How the creep compliance changes with the steering angle.

        See `creepage.compliance`. To first order in the departure of the patch from a circle, k_2 is 0 and the compliance
        goes from its value at 0 degrees to that at 90 degrees with the square of the sine. k_2 is chosen so that it is exact
        at 45 degrees as well.

        Parameters
        ----------
        contact : PressedContact   Result of `press` at angle 0.
        wheel_radius, cylinder_radius, preload : (...,) float   As for `press`. [m], [m], [N]

        Returns
        -------
        k_1, k_2 : (...,) float   [-]

        Source: `infinivar.contact.turned`.
        """
        given = {"wheel_radius": wheel_radius, "cylinder_radius": cylinder_radius, "preload": preload}
        half, right = (
            contact.creep_stiffness / self.press(**given, steering_angle=angle).creep_stiffness
            for angle in (0.25 * math.pi, 0.5 * math.pi)
        )
        return right - 1.0, 4.0 * half - 2.0 * (1.0 + right)

    def loss_groups(
        self, contact: PressedContact, *, wheel_radius: Array, preload: Array, friction: Array, surface_speed: Array
    ) -> LossGroups:
        """Parameters that determine the losses, at a surface speed of the cylinder.

        Parameters
        ----------
        contact : PressedContact         Result of `press`.
        wheel_radius : (...,) float      r. [m]
        preload : (...,) float           P. [N]
        friction : (...,) float          mu at rest. [-]
        surface_speed : (...,) float     R omega, for bearing friction and friction limit; a steered wheel rolls faster by
            1/cos(phi). [m s^-1]

        Returns
        -------
        LossGroups   The bearings carry `lateral_share` of the slip force sideways.
        """
        slip_force = self.friction_limit(friction, surface_speed) * preload
        return LossGroups(
            slip_force=slip_force,
            creep_stiffness=contact.creep_stiffness,
            rolling_torque=hysteresis.ellipse_torque(preload, contact.patch.a, self.hysteresis_factor),
            bearing_torque=self.axle_friction(
                wheel_radius=wheel_radius, preload=preload, slip_force=slip_force, surface_speed=surface_speed
            ),
            wheel_radius=wheel_radius,
            full_slip=contact.full_slip,
            axis_ratio=contact.axis_ratio,
            poisson=contact.poisson,
        )

    def friction_limit(self, friction: Array, surface_speed: Array) -> Array:
        """The friction limit at a surface speed, from that at rest; arguments as in `loss_groups`. [-]"""
        if self.friction_decay_speed is None:
            return friction
        return friction_law.falling(surface_speed, friction, self.fast_friction_ratio, self.friction_decay_speed)

    def axle_friction(self, *, wheel_radius: Array, preload: Array, slip_force: Array, surface_speed: Array) -> Array:
        """Friction torque of the wheel's bearings; arguments as in `loss_groups`. [N m]"""
        return self.axle.moment(
            preload, self.lateral_share * slip_force, wheel_radius, surface_speed / wheel_radius
        ).total

    def utilisation(
        self, contact: PressedContact, *, wheel_radius: Array, preload: Array, slip_force: Array
    ) -> Mapping[Limit, Array]:
        """Demand over allowance for every limit that the preload alone can exceed.

        Parameters
        ----------
        contact : PressedContact           Result of `press`.
        wheel_radius, preload : (...,) float   r, P. [m], [N]
        slip_force : (...,) float          mu P; the bearings carry `lateral_share` of it sideways. [N]

        Returns
        -------
        mapping of Limit to (...,) float   Known limits only; above 1 where exceeded. [-]

        Source: as `stress`; iso2006 for the bearings.
        """
        safety = self.axle.static_safety(preload, self.lateral_share * slip_force, wheel_radius)
        bent = self.axle_stress(preload, self.lateral_share * slip_force * wheel_radius)
        return {
            **self.stress(contact).utilisation,
            Limit.BEARING: plain(1.0 / safety),
            Limit.AXLE: plain(bent / self.axle_strength),
            Limit.CLEARANCE: plain(self.least_wheel / wheel_radius),
        }

    @property
    def axle_span(self) -> Array:
        """Between the middles of the axle's bearings: as stated, else that of bearings close to the wheel. [m]"""
        return given(self.bearing_span, close_span(self.wheel_width, self.axle_bearing.breadth))

    @property
    def least_wheel(self) -> Array:
        """Radius of the smallest wheel beside its bearings, whose rim is not below the axle. [m]"""
        bearing = self.axle_bearing
        fall = crown_height(self.crown_radius, self.wheel_width)
        xp = namespace(fall, bearing.bore, bearing.outside_diameter)
        fall, bore, outside = as_floats(xp, fall, bearing.bore, bearing.outside_diameter)
        return xp.maximum(0.5 * outside, 0.5 * bore + fall)

    def axle_stress(self, preload: Array, moment: Array) -> Array:
        """Bending stress of the axle beside the wheel, with shear, for the bore of its bearings.

        Parameters
        ----------
        preload : (...,) float   Force across the axle, midway between its bearings. [N]
        moment : (...,) float    Of the lateral force about the axle, of which the bearings take half on each side. [N m]

        Returns
        -------
        (...,) float   Equivalent stress by von Mises. [Pa]

        Source: young2002, Table 8.1, case 1e; budynas2011, section 7-4.
        """
        section, span = Section(0.5 * self.axle_bearing.bore), self.axle_span
        bending = preload * stress(section, span, 0.5 * span) + 0.5 * moment * section.outer / section.second_moment
        shear = 0.5 * preload / section.area
        return (bending**2 + 3.0 * shear**2) ** 0.5

    def stress(self, contact: PressedContact) -> ContactStress:
        """Stress below the surface of both bodies, relative to their strength.

        Parameters
        ----------
        contact : PressedContact   Result of `press`.

        Returns
        -------
        ContactStress   Bodies "wheel" and "cylinder".

        Source: johnson1985, sections 4.5 and 6.1 (first yield by the largest shear; full plasticity at the hardness).
        """
        shear, depth = {}, {}
        demand: dict[Limit, list[Array]] = {Limit.YIELD: [], Limit.HARDNESS: []}
        patch, known = contact.patch, {}
        for body, material in self.bodies.items():
            if material.poisson not in known:
                known[material.poisson] = _largest_shear(patch.a, patch.b, patch.peak_pressure, material.poisson)
            shear[body], depth[body] = known[material.poisson]
            if material.yield_strength is not None:
                demand[Limit.YIELD].append(shear[body] / (0.5 * material.yield_strength))
            if material.hardness is not None:
                demand[Limit.HARDNESS].append(patch.mean_pressure / material.hardness)
        return ContactStress(shear, depth, {limit: _largest(of) for limit, of in demand.items() if of})

    @property
    def bodies(self) -> Mapping[str, Material]:
        """Materials by body."""
        return {"wheel": self.wheel_material, "cylinder": self.cylinder_material}

    @property
    def axle(self) -> BearingPair:
        """The wheel's axle on its two bearings."""
        return BearingPair(bearing=self.axle_bearing, span=self.bearing_span)


def _largest_shear(*patch: Array) -> tuple[Any, ...]:
    """`hertz.largest_shear`; that of single contacts is kept, as many drives that are compared have the same."""
    return _kept_shear(*patch) if all(isinstance(one, float) for one in patch) else _shear(*patch)


def _shear(*patch: Array) -> tuple[Any, ...]:
    return tuple(map(plain, hertz.largest_shear(*patch)))


_kept_shear = functools.lru_cache(maxsize=64)(_shear)


def _largest(values: list[Array]) -> Array:
    xp = namespace(*values)
    return functools.reduce(lambda one, other: plain(xp.maximum(xp.asarray(one), xp.asarray(other))), values)
