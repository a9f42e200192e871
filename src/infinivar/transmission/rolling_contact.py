r"""One rolling contact: a preloaded wheel on a cylinder, a sphere or a plane, with the force of any motion of its carrier.

In the tangent plane, V is the velocity of the wheel's carrier relative to the surface, e the heading of the wheel (its rolling
direction) and l the lateral direction, a quarter turn from e in the positive sense about the normal:

.. math::
    e &= (\cos h, \sin h), & l &= (-\sin h, \cos h), & u &= V \cdot l, & v &= V \cdot e \\
    f_u &= \mu P\, x\!\left(\frac{C}{\mu P}\frac{u}{|v|}\right), & f_r &= F_0\,\mathrm{sgn}(v), &
    f &= -f_u\, l - f_r\, e, & f \cdot V &= -(f_u u + f_r v) \le 0

A wheel that turns about the normal at the rate psi relative to the surface, positive from x to y, feels the moment -M with
``fu u + M psi >= 0``: see `infinivar.transmission.spin_law`. Forces depend on the direction of (V, psi) only, not on its size: at
rest they are indeterminate.

Source: faulring2006, Eq 3 to Eq 8, Eq 12 to Eq 14, in passive form and in any direction of the plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, as_floats, namespace, safe_divide, signed_infinity
from infinivar._core.fields import check, check_choice, check_value, component, quantity
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw, Formulas
from infinivar.contact.exact.spin_map import spin_map
from infinivar.contact.exact_law import NARROWEST, WIDEST
from infinivar.contact.friction import coulomb
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.transmission import creepage, spin_law
from infinivar.transmission.geometry import (
    MEASURED_FULL_SLIP,
    PRELOAD_POWERS,
    ContactGeometry,
    LossGroups,
    PressedContact,
    SurfaceShape,
)
from infinivar.transmission.kinematics import BEYOND_ANY

SteeringModel = Literal["shear", "spin"]

MEASURED = ("creep_stiffness", "rolling_torque", "bearing_torque")
"""Fields that describe a contact by measured values, instead of `geometry`."""

CREEP_LAW = (
    "Creep law: linear, faulring (linear with the flow loss of Eq 17), vermeulen-johnson, polach, fastsim or exact; "
    "exact by default with geometry, linear without"
)
STEERING_MODEL = (
    "Resistance to steering: shear (constant torque of a patch that turns on the spot) or spin (of one that rolls as it "
    "turns, by exact theory; in motion, creep then follows that theory as well; needs geometry with a patch of a/b from "
    "0.05 to 20); spin by default with such geometry and the law exact, otherwise shear"
)

_ROUNDED = 1e-9
"""Rounding error by which a creepage, as a difference of speeds, may exceed the slip limit."""

_SPOT = 1e-12
"""Rolling speed, over the speed at which the patch slides or turns, below which it turns on the spot. [-]"""


class ContactForces(NamedTuple):
    """What a contact does at a velocity of its carrier; arrays of one shape."""

    x: Array
    """Force on the carrier along x. [N]"""
    y: Array
    """Force on the carrier along y. [N]"""
    moment: Array
    """M, which resists spin; the carrier feels -M about the normal. [N m]"""
    creep_speed: Array
    """u. [m s^-1]"""
    rolling_speed: Array
    """v. [m s^-1]"""
    lateral_force: Array
    """f_u. [N]"""
    losses: dict[str, Array]
    """"creep", "rolling", "bearing", and "spin" where the contact turns. [W]"""
    slip_demand: Array
    """Demand over allowance for slip: 1 is the slip limit. [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class RollingContact:
    """A preloaded wheel on a surface.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    wheel_radius: float = quantity("m", Gt(0), "Rolling radius r of the wheel")
    preload: float = quantity("N", Gt(0), "Normal force P between wheel and surface")
    friction: float = quantity("1", Gt(0), "Rolling friction limit mu: the contact slips at mu P")
    surface: SurfaceShape = component(
        "What the wheel rolls on: a cylinder whose axis is along x, a sphere or a plane", default="plane"
    )
    surface_radius: float | None = quantity("m", Gt(0), "Radius of the cylinder or sphere", default=None)
    geometry: ContactGeometry | None = component(
        "Geometry, materials and bearings, which determine creep stiffness and torques", default=None
    )
    creep_stiffness: float | None = quantity(
        "N", Gt(0), "Measured creep stiffness C = C22 G a b, lateral force over creepage", default=None
    )
    rolling_torque: float | None = quantity(
        "N m", Ge(0), "Measured hysteresis torque of the rolling contact, about the wheel axle", default=None
    )
    bearing_torque: float | None = quantity(
        "N m", Ge(0), "Measured friction torque of the wheel's axle bearings", default=None
    )
    creep_law: CreepLaw = component(CREEP_LAW, default=None)
    steering_model: SteeringModel | None = component(STEERING_MODEL, default=None)
    contact: PressedContact | None = field(init=False, repr=False, compare=False, default=None)
    _yielding: tuple[Array, Array] | None = field(init=False, repr=False, compare=False, default=None)
    _memo: dict[float | None, LossGroups] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Validate the fields and compute the static contact."""
        check(self)
        usual = creep.LINEAR if self.geometry is None else creep.EXACT
        required = usual if self.creep_law is None else creep.law(self.creep_law)  # which may be given by its name
        object.__setattr__(self, "creep_law", required)
        if self.steering_model is not None:
            check_choice(self, "steering_model", {"shear": (), "spin": ("geometry",)}, {"shear": ("geometry",)})
        given = [name for name in MEASURED if getattr(self, name) is not None]
        if self.geometry is not None:
            if given:
                raise ParameterError(f"{given[0]} and geometry exclude each other: geometry determines {given[0]}")
            self._press(self.geometry)
        elif len(given) < len(MEASURED):
            missing = next(name for name in MEASURED if name not in given)
            raise ParameterError(
                f"{missing} is missing: give {', '.join(MEASURED)}, or geometry, which determines all three"
            )

    def _press(self, geometry: ContactGeometry) -> None:
        """Compute the static contact."""
        if self.surface != "plane" and self.surface_radius is None:
            raise ParameterError(f"surface_radius is missing: surface = {self.surface!r} needs it")
        if self.surface == "plane" and self.surface_radius is not None:
            raise ParameterError("surface_radius is of a cylinder or sphere, but surface is 'plane'")
        pressing = {"wheel_radius": self.wheel_radius, "preload": self.preload}
        contact = geometry.press_on(geometry.surface(self.surface, self.surface_radius), **pressing)
        object.__setattr__(self, "contact", contact)
        if self.steering_model == "spin" and not _spin_known(contact):
            raise ParameterError(
                f"steering_model must be shear, got 'spin': the patch has a/b = {contact.axis_ratio:.3g}, and forces with "
                f"spin are known for {NARROWEST:g} to {WIDEST:g} (change crown_radius, wheel_radius or the radius of the "
                f"{self.surface})"
            )
        # The linear laws are the paper's, with one creep stiffness; only on a cylinder does the patch depend on the heading.
        if self.surface == "cylinder" and not self.creep_law.straight:
            found = geometry.yielding(contact, cylinder_radius=self.surface_radius, **pressing)
            object.__setattr__(self, "_yielding", found)

    @property
    def turns_with_spin(self) -> bool:
        """Whether turning about the normal is spin of the contact, which changes its forces."""
        if self.steering_model is None:
            return self.contact is not None and self.creep_law == creep.EXACT and _spin_known(self.contact)
        return self.steering_model == "spin"

    @property
    def slip_force(self) -> float:
        """Slip limit of the lateral force, mu P, with the friction limit at rest. [N]"""
        return self.friction * self.preload

    def friction_limit(self, surface_speed: Array) -> Array:
        """mu at a surface speed [m/s], where the geometry has a limit that falls with speed; otherwise that at rest. [-]"""
        if self.geometry is None:
            return self.friction
        return self.geometry.friction_limit(self.friction, surface_speed)

    @property
    def utilisation(self) -> Mapping[Limit, Array]:
        """Demand over allowance for the limits that the preload alone can exceed; empty for measured values. [-]"""
        if self.geometry is None or self.contact is None:
            return {}
        return self.geometry.utilisation(
            self.contact, wheel_radius=self.wheel_radius, preload=self.preload, slip_force=self.slip_force
        )

    def pressed(self, preload: Array) -> RollingContact:
        """The same wheel under another preload [N]; measured values scale by `PRELOAD_POWERS`."""
        check_value("preload", preload, "N", Gt(0))
        return replace(self, preload=preload, **scaled_by_preload(self, preload))

    def groups(self, surface_speed: Array) -> LossGroups:
        """Parameters that determine the losses, at a surface speed: measured values, or derived from geometry.

        Parameters
        ----------
        surface_speed : (...,) float   Of the surface under the wheel; measured values do not depend on it. [m s^-1]

        Returns
        -------
        LossGroups   Slip force, creep stiffness at heading y on a cylinder along x, torques, and the groups H and K.
        """
        if self.geometry is not None and self.contact is not None:
            # Most callers repeat the same speed, from several threads.
            if type(surface_speed).__module__ == "numpy" and surface_speed.ndim == 0:
                surface_speed = float(surface_speed)
            number = isinstance(surface_speed, (int, float))
            known = self._memo.get(surface_speed) if number else None
            if known is not None:
                return known
            groups = self.geometry.loss_groups(
                self.contact,
                wheel_radius=self.wheel_radius,
                preload=self.preload,
                friction=self.friction,
                surface_speed=as_floats(namespace(self, surface_speed), surface_speed)[0],
            )._replace(yielding=self._yielding)
            if number:
                self._memo.clear()
                self._memo[surface_speed] = groups
            return groups
        measured = self._memo.get(None)
        if measured is None:
            measured = LossGroups(
                slip_force=self.slip_force,
                creep_stiffness=self.creep_stiffness,
                rolling_torque=self.rolling_torque,
                bearing_torque=self.bearing_torque,
                wheel_radius=self.wheel_radius,
                full_slip=MEASURED_FULL_SLIP,
                yielding=self._yielding,
            )
            self._memo[None] = measured
        return measured

    def slip_demand(self, groups: LossGroups, ratio: Array, creep_speed: Array, rolling_speed: Array) -> Array:
        """Demand over allowance for slip: the larger of lateral force and creepage relative to slip; 1 is the slip limit.

        Parameters
        ----------
        groups : LossGroups                        At the wheel's heading.
        ratio : (...,) float                       Lateral force over mu P. [-]
        creep_speed, rolling_speed : (...,) float  u and v. [m s^-1]

        Returns
        -------
        (...,) float   [-]
        """
        xp = namespace(ratio, creep_speed, rolling_speed)
        most = groups.slip_creepage(self.creep_law) * (1.0 + _ROUNDED)
        rolling = xp.abs(rolling_speed)
        rolling = xp.where(rolling > 0, rolling, 1.0 / BEYOND_ANY)  # a wheel may slide without rolling
        by_creepage = groups.creep_group * xp.abs(creep_speed) / (rolling * most)
        by_force = xp.abs(ratio)
        return xp.where(by_creepage > by_force, by_creepage, by_force)

    def losses(self, groups: LossGroups, lateral_force: Array, creep_speed: Array, rolled: Array) -> dict[str, Array]:
        """Losses of the contact and its axle bearings, with f_u, u and |v|. [W]

        Source: faulring2006, Eq 8 (creep), Eq 13 (rolling), Eq 14 (bearing).
        """
        turned = rolled / self.wheel_radius
        return {
            "creep": lateral_force * creep_speed,
            "rolling": groups.rolling_torque * turned,
            "bearing": groups.bearing_torque * turned,
        }

    def act(
        self,
        velocity: tuple[Array, Array],
        heading: tuple[Array, Array],
        *,
        spin: Array | None = None,
        surface_speed: Array | None = None,
        stick_speed: float | None = None,
    ) -> ContactForces:
        """Forces of the contact at a velocity of its carrier.

        Parameters
        ----------
        velocity : two of (...,) float   V, relative to the surface, along x and y. [m s^-1]
        heading : two of (...,) float    e: cosine and sine of the angle from x to the rolling direction. [-]
        spin : (...,) float              psi, from x to y; ignored unless `turns_with_spin`. [rad s^-1]
        surface_speed : (...,) float     For bearing friction and friction limit; |V| by default. [m s^-1]
        stick_speed : float              v_eps > 0, below which the contact becomes viscous, for motion in time; see
            `infinivar.transmission.creepage`. None: exact, and nan at rest. [m s^-1]

        Returns
        -------
        ContactForces   Inputs broadcast. A wheel that slides has the forces of gross sliding and a slip demand above 1. Without
            a stick speed, the rolling resistance of a wheel that slides or turns without rolling at all counts as zero.
        """
        u, v, groups = self.at(velocity, heading, surface_speed)
        xp = namespace(u, v, spin, *groups[:-1])  # the groups are of what the fields of the contact are
        law = groups.formulas(self.creep_law)
        turns = spin is not None and self.turns_with_spin
        moment = 0.0 * u
        if turns:
            ratio, moment, demand = self._with_spin(xp, groups, u, v, spin, stick_speed)
        elif stick_speed is None:
            ratio = sliding_ratio(xp, law, groups, u, v)
            demand = self.slip_demand(groups, ratio, u, v)
        else:
            ratio = (
                creepage.lateral_force(law, u, v, groups.slip_force, groups.creep_stiffness, stick_speed)
                / groups.slip_force
            )
            demand = self.slip_demand(groups, ratio, u, xp.sqrt(v * v + stick_speed * stick_speed))
        way = coulomb(v, 1.0, stick_speed)
        lateral, rolling = ratio * groups.slip_force, groups.rolling_force * way
        if stick_speed is None:
            rests = (u == 0) & (v == 0)
            rests = rests & (spin == 0) if turns else rests
            lateral = xp.where(rests, xp.nan, lateral)
        losses = self.losses(groups, lateral, u, way * v)
        if turns:
            losses["creep"], losses["spin"] = spin_law.shares(losses["creep"], moment * spin)
        cosine, sine = heading
        return ContactForces(
            x=lateral * sine - rolling * cosine,
            y=-lateral * cosine - rolling * sine,
            moment=moment,
            creep_speed=u,
            rolling_speed=v,
            lateral_force=lateral,
            losses=losses,
            slip_demand=demand,
        )

    def at(
        self, velocity: tuple[Array, Array], heading: tuple[Array, Array], surface_speed: Array | None = None
    ) -> tuple[Array, Array, LossGroups]:
        """Creep velocity u, rolling velocity v and groups at a heading; arguments as in `act`."""
        (vx, vy), (cosine, sine) = velocity, heading
        if surface_speed is None and self.geometry is not None:
            surface_speed = namespace(vx, vy).sqrt(vx * vx + vy * vy)
        groups = self.groups(surface_speed)
        return vy * cosine - vx * sine, vx * cosine + vy * sine, groups.steered(cosine * cosine)

    def _with_spin(
        self, xp: Any, groups: LossGroups, u: Array, v: Array, spin: Array, stick_speed: float | None
    ) -> tuple[Array, Array, Array]:
        """Force ratio, moment and slip demand of a wheel that turns about the normal."""
        patch = spin_law.TurningPatch.of(self, groups)
        if stick_speed is None:
            least = _SPOT * (xp.abs(u) + xp.abs(v) + patch.lever * xp.abs(spin))
            stick = xp.where(least > 0, least, 1.0)
        else:
            stick = stick_speed
        u, v, spin, stick = xp.broadcast_arrays(u, v, spin, xp.asarray(stick, dtype=xp.float64))
        force, moment = spin_law.law(u, spin, v, **patch._asdict(), stick_speed=stick)
        ratio = force / groups.slip_force
        given = {"slip_force": groups.slip_force, "creep_stiffness": groups.creep_stiffness, "lever": patch.lever}
        slides = spin_law.slip_demand(u, spin, v, slip_creepage=groups.full_slip, stick_speed=stick, **given)
        return ratio, moment, xp.maximum(xp.abs(ratio), slides)

    def creepage(
        self,
        lateral_force: Array,
        *,
        groups: LossGroups | None = None,
        spin: Array | None = None,
        rolling_speed: Array | None = None,
    ) -> Array:
        """Creepage u/|v| under a prescribed lateral force: the inverse of `act`.

        Parameters
        ----------
        lateral_force : (...,) float   f_u. [N]
        groups : LossGroups            At the wheel's heading, of `at`; by default those of a standing surface at heading y.
        spin : (...,) float            psi; needs `rolling_speed` and counts only if `turns_with_spin`. [rad s^-1]
        rolling_speed : (...,) float   v, nonzero. [m s^-1]

        Returns
        -------
        (...,) float   nan beyond the slip limit. [-]
        """
        groups = self.groups(0.0) if groups is None else groups
        ratio = lateral_force / groups.slip_force
        if spin is not None and self.turns_with_spin:
            patch = spin_law.TurningPatch.of(self, groups)
            known = spin_map(patch.a_over_b, patch.poisson)
            turned = groups.creep_group * patch.lever * spin / rolling_speed
            found = known.lateral_creepage(ratio, turned / (known.scale.c22 * known.scale.lever))
            return known.scale.c22 * found / groups.creep_group
        xp = namespace(ratio, *groups[:-1])
        rolls = xp.abs(ratio) <= 1.0
        found = groups.formulas(self.creep_law).creepage(xp.where(rolls, ratio, 0.0)) / groups.creep_group
        return xp.where(rolls, found, xp.nan)


def sliding_ratio(xp: Any, law: Formulas, groups: LossGroups, creep_speed: Array, rolling_speed: Array) -> Array:
    """Force ratio at a creep and a rolling velocity, gross sliding included; 0 at rest. [-]

    Source: faulring2006, Eq 7, in passive form; other laws as in `infinivar.contact.creep`.
    """
    # The rolling speed may be exactly zero while the wheel slides; a saturating law expects an infinite creepage then.
    at = safe_divide(xp, creep_speed, xp.abs(rolling_speed), 0.0)
    slides = (rolling_speed == 0) & (creep_speed != 0)
    at = xp.where(slides, signed_infinity(xp, creep_speed), at)
    return law.force(at * groups.creep_group)


def scaled_by_preload(contact: Any, preload: Array) -> dict[str, Array]:
    """Measured values of a contact, or of a machine with one, under another preload [N]; empty with geometry."""
    if contact.geometry is not None:
        return {}
    share = preload / contact.preload
    return {name: getattr(contact, name) * share**power for name, power in PRELOAD_POWERS.items()}


def _spin_known(contact: PressedContact) -> bool:
    """Whether the map of forces with spin covers the patch; it looks at arrays of patches itself."""
    return not isinstance(contact.axis_ratio, float) or NARROWEST <= contact.axis_ratio <= WIDEST
