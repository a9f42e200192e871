r"""The rotational-to-linear cobotic transmission: a steered wheel pressed on a turning cylinder, carried by a link.

Signs (all four quadrants): ``phi`` steers, ``omega`` is the cylinder speed, ``ldot`` the link speed, ``fl`` the force
applied by the transmission to the link, ``tau`` the torque applied by the cylinder plant to the transmission.

.. math::
    u &= \dot l \cos\phi + R\omega\sin\phi, & v &= \dot l \sin\phi - R\omega\cos\phi \\
    \tau &= R (f_u \sin\phi - f_r \cos\phi), & f_l &= -f_u \cos\phi - f_r \sin\phi \\
    f_u &= C\,u/|v|, & f_r &= \mathrm{sgn}(v)\,(\tau_{in} + \tau_{wa})/r

so that ``tau omega - fl ldot = fu u + fr v >= 0`` always. With the creepage ``e = u/|v|`` and ``s = sgn(omega)``, a
wheel that rolls in the direction in which the cylinder drives it (``s v < 0``) moves the link at
``ldot = R |omega| (e - s t)/(1 + s e t)``, ``t = tan(phi)``. Forward operation is therefore explicit, and its inverse is one
Newton iteration in ``t``.

Source: faulring2006, sections II and III, in passive form (see the errata and the equation index in the documentation).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, as_floats, bisect, namespace, plain, safe_divide, signed_infinity
from infinivar._core.bounds import QUARTER_TURN
from infinivar._core.fields import check, component, quantity
from infinivar._core.labels import labelled
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw
from infinivar.errors import AuditError, ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.structure.stock import StockTube
from infinivar.parts.structure.tube import Tube, tube_of_cylinder
from infinivar.transmission.geometry import ContactGeometry, LossGroups, PressedContact
from infinivar.transmission.inverse import steering_tangent
from infinivar.transmission.kinematics import RIGHT_ANGLE, Steering, contact_balance, driven, relative_velocities
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rolling_contact import (
    CREEP_LAW,
    STEERING_MODEL,
    RollingContact,
    SteeringModel,
    scaled_by_preload,
    sliding_ratio,
)

if TYPE_CHECKING:
    from infinivar.transmission.mechanism import Mechanism

_OF_CONTACT = tuple(one.name for one in fields(RollingContact) if one.init and "surface" not in one.name)
"""Fields that a wheel on a cylinder shares with any other rolling contact."""

_SPEED_TOLERANCE = 1e-6
"""Relative to the sum of surface and link speed. Rounding leaves 1e-15, and more only within 1e-6 of slip with Eq 17."""

_ROUNDING = 2e-15
"""Rounding error of a force ratio computed from an angle: a few units in the last place."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RotaryLinearIVT:
    """Steered wheel on a cylinder: the paper's infinitely variable transmission.

    With several `wheels`, preload, friction, geometry and measured values are of one. Forces, torques and losses are of all,
    and so are `groups` and `slip_force`; `wheel`, `contact` and `utilisation` are of one.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    cylinder_radius: float = quantity("m", Gt(0), "Cylinder radius R")
    wheel_radius: float = quantity("m", Gt(0), "Rolling radius r of the wheel")
    preload: float = quantity("N", Gt(0), "Normal force P between wheel and cylinder")
    friction: float = quantity("1", Gt(0), "Rolling friction limit mu: the contact slips at mu P")
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
    steering_range: float = quantity(
        "rad", Interval(gt=0, le=QUARTER_TURN), "Largest steering angle in either direction", default=math.pi / 2
    )
    cylinder_wall: float | None = quantity(
        "m",
        Gt(0),
        "Wall of the cylinder, a tube; without it neither its strength nor its inertia is known",
        default=None,
    )
    cylinder_tube: StockTube | None = component(
        "Tube from stock that is turned down to the cylinder; it determines the wall", default=None
    )
    cylinder_length: float | None = quantity("m", Gt(0), "Length of the tube between its end plates", default=None)
    cylinder_end_plate: float = quantity("m", Ge(0), "Thickness of each end plate of the tube", default=0.0)
    wheels: int = component(
        "Equal wheels evenly around the cylinder, steered alike, that share the link's force: 1, 2 or 3", default=1
    )
    creep_law: CreepLaw = component(CREEP_LAW, default=None)
    steering_model: SteeringModel | None = component(STEERING_MODEL, default=None)
    tube: Tube | None = field(init=False, repr=False, compare=False, default=None)
    wheel: RollingContact = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]
    _of_wall: Mapping[Limit, Array] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Validate the fields and compute the static contact."""
        check(self)
        whole = isinstance(self.wheels, int) and not isinstance(self.wheels, bool) and 1 <= self.wheels <= 3
        require(whole, "wheels", repr(self.wheels), "1, 2 (at 180 degrees) or 3 (at 120 degrees)")
        shared = {name: getattr(self, name) for name in _OF_CONTACT}
        wheel = RollingContact(surface="cylinder", surface_radius=self.cylinder_radius, **shared)
        object.__setattr__(self, "wheel", wheel)
        object.__setattr__(self, "creep_law", wheel.creep_law)
        tube = tube_of_cylinder(
            radius=self.cylinder_radius,
            wall=self.cylinder_wall,
            stock=self.cylinder_tube,
            length=self.cylinder_length,
            end_plate=self.cylinder_end_plate,
            material=None if self.geometry is None else self.geometry.cylinder_material,
        )
        object.__setattr__(self, "tube", tube)
        if tube is not None and wheel.contact is not None and tube.material.yield_strength is not None:
            patch = wheel.contact.patch
            demand = tube.demand(self.preload, (patch.a * patch.b) ** 0.5, self.wheels)
            object.__setattr__(self, "_of_wall", {Limit.WALL: plain(demand)})

    @property
    def contact(self) -> PressedContact | None:
        """The contact under its preload, if its geometry is known."""
        return self.wheel.contact

    @property
    def turns_with_spin(self) -> bool:
        """Whether steering is spin of the contact."""
        return self.wheel.turns_with_spin

    @property
    def slip_force(self) -> float:
        """Slip limit of the lateral force of all wheels, n mu P, with the friction limit at rest. [N]"""
        return self.wheels * self.wheel.slip_force

    @property
    def unbalanced_preload(self) -> Array:
        """Sum of the preloads as vectors, which guideway and frame carry: 0 with several wheels. [N]"""
        return self.preload if self.wheels == 1 else 0.0 * self.preload

    def friction_limit(self, cylinder_speed: Array) -> Array:
        """mu at a cylinder speed [rad/s], where the geometry has a limit that falls with speed; otherwise that at rest. [-]"""
        return self.wheel.friction_limit(self.cylinder_radius * cylinder_speed)

    @property
    def utilisation(self) -> Mapping[Limit, Array]:
        """Demand over allowance for the limits that the preload alone can exceed; empty for measured values. [-]"""
        return {**self.wheel.utilisation, **self._of_wall}

    def pressed(self, preload: Array) -> RotaryLinearIVT:
        """The same wheel under another preload [N]; measured values scale by `PRELOAD_POWERS`."""
        return replace(self, preload=preload, **scaled_by_preload(self, preload))

    def groups(self, cylinder_speed: Array) -> LossGroups:
        """Parameters that determine the losses, at a cylinder speed: measured values, or derived from geometry.

        Parameters
        ----------
        cylinder_speed : (...,) float   omega; measured values do not depend on it. [rad s^-1]

        Returns
        -------
        LossGroups   Slip force, creep stiffness and torques of all wheels, and the groups H and K derived from them.
        """
        if self.geometry is None:
            return self.wheel.groups(0.0).shared(self.wheels)
        if not isinstance(cylinder_speed, (int, float)):
            cylinder_speed = as_floats(namespace(self.wheel, self.steering_range, cylinder_speed), cylinder_speed)[0]
        return self.wheel.groups(self.cylinder_radius * cylinder_speed).shared(self.wheels)

    @property
    def mechanism(self) -> Mechanism:
        """The same machine as a kinematic map over its contacts, with coordinates "link" and "cylinder".

        The carrier moves at ``V = (ldot, -R omega)`` and the wheel heads along ``(sin(phi), cos(phi))``, so that it
        applies ``fl`` on the link and ``-tau`` on the cylinder coordinate: on the plant, which turns it.

        Raises
        ------
        ParameterError
            If the creep law has a flow loss.
        """
        from infinivar.transmission.mechanism import Mechanism  # loading a study does without

        radius, xp = self.cylinder_radius, namespace(self.wheel)
        nothing = 0.0 * radius
        return Mechanism(
            contacts=self.wheel,
            jacobian=xp.asarray([[[1.0, nothing], [nothing, -radius]]] * self.wheels, dtype=xp.float64),
            surface=xp.asarray([[nothing, radius]] * self.wheels, dtype=xp.float64),
            coordinates=("link", "cylinder"),
        )

    @labelled
    def operate(
        self,
        *,
        cylinder_speed: Array,
        steering_angle: Array,
        link_force: Array | None = None,
        link_speed: Array | None = None,
    ) -> OperatingPoint:
        """Steady operation at a given steering angle, in all four quadrants.

        Parameters
        ----------
        cylinder_speed : (...,) float   omega; may be negative or zero. [rad s^-1]
        steering_angle : (...,) float   phi in [-pi/2, pi/2]; 0 locks the link, +-pi/2 decouples it. [rad]
        link_force : (...,) float       Force applied by the transmission to the link. [N]
        link_speed : (...,) float       Speed of the link. Give this or `link_force`. [m s^-1]

        Returns
        -------
        OperatingPoint
            Inputs broadcast. With a prescribed force beyond slip, motion is nan and `limit` is SLIP. With a prescribed
            speed beyond slip, the forces are those of gross sliding and `limit` is SLIP. A creepage beyond full slip is
            SLIP as well, even if the law gives it a smaller force. At rest (cylinder and link speed zero) the contact
            holds any force below slip: with a prescribed force, static friction carries what it can and `torque` is the
            smallest that holds the link; with a prescribed speed of zero the forces are indeterminate and nan.

        Raises
        ------
        ParameterError
            If both or neither of `link_force` and `link_speed` are given, or a steering angle exceeds a right angle.

        Source: faulring2006, Eq 16, which is this solution for a linear creep law in the driving quadrant.
        """
        if (link_force is None) == (link_speed is None):
            raise ParameterError("give either link_force or link_speed")
        given = link_speed if link_force is None else link_force
        xp = namespace(self.wheel, self.steering_range, cylinder_speed, steering_angle, given)
        omega, phi, given = as_floats(xp, cylinder_speed, steering_angle, given)
        if xp.__name__ == "numpy" and xp.any(xp.abs(phi) > math.pi / 2 + RIGHT_ANGLE):
            raise ParameterError(
                "steering_angle must be between -pi/2 and pi/2 rad; a wheel steered by pi rad further is the same wheel"
            )
        groups = self.groups(cylinder_speed)
        omega, phi, given = xp.broadcast_arrays(omega, phi, given)
        steering = Steering.at_angle(xp, phi)
        groups = groups.steered(steering.sine * steering.sine)
        if link_force is None:
            return self._at_speed(xp, groups, omega, steering, given)
        return self._at_force(xp, groups, omega, steering, given)

    @labelled
    def steer(self, *, cylinder_speed: Array, link_speed: Array, link_force: Array) -> Array:
        """Steering angle at which the link moves at a given speed under a given force.

        Parameters
        ----------
        cylinder_speed : (...,) float   omega. At zero the link can only stand still (angle 0) or be decoupled (+-pi/2),
            where only the rolling resistance acts on it, regardless of `link_force`. [rad s^-1]
        link_speed, link_force : (...,) float   Of the link, force as applied by the transmission. [m s^-1], [N]

        Returns
        -------
        (...,) float   phi; nan where the contact would slip. If two angles give the same motion (possible only beyond
            |tan phi| = K, or near slip with Eq 17 or a nonlinear law), the one nearer to the locked state. [rad]

        Source: inverse of `operate`; derivation in the theory page.
        """
        xp = namespace(self.wheel, self.steering_range, cylinder_speed, link_speed, link_force)
        omega, speed, force = as_floats(xp, cylinder_speed, link_speed, link_force)
        groups = self.groups(cylinder_speed)
        tangent, possible = self._tangent(xp, groups, omega, speed, force)
        decoupled = (omega == 0) & (speed != 0)
        load, rolled = force / groups.slip_force, groups.rolling_group * xp.sign(omega) * tangent
        root = xp.sqrt(1.0 + tangent * tangent)
        creep_speed, rolling_speed = relative_velocities(
            speed, self.cylinder_radius * omega, 1.0 / root, tangent / root
        )
        groups = groups.steered(1.0 - 1.0 / (root * root))
        demand = self.wheel.slip_demand(groups, rolled - load * root, creep_speed, rolling_speed)
        angle = xp.where(possible & (demand <= 1.0), xp.atan(tangent), xp.nan)  # false for a nan demand
        return xp.where(decoupled, -0.5 * math.pi * xp.sign(speed), angle)

    @labelled
    def deliver(self, *, cylinder_speed: Array, link_speed: Array, link_force: Array) -> OperatingPoint:
        """Operating point that gives the link a prescribed speed and force: `steer`, then `operate`, in one pass.

        Parameters
        ----------
        cylinder_speed, link_speed, link_force : (...,) float   As in `steer`. [rad s^-1], [m s^-1], [N]

        Returns
        -------
        OperatingPoint
            Inputs broadcast. Where no steering angle gives the motion, link speed and powers are nan and the limit is
            SLIP.

        Raises
        ------
        AuditError
            If the computed angle does not give the requested speed, which is a bug.

        Source: inverse of `operate`; derivation in the theory page.
        """
        xp = namespace(self.wheel, self.steering_range, cylinder_speed, link_speed, link_force)
        omega, speed, force = as_floats(xp, cylinder_speed, link_speed, link_force)
        groups = self.groups(cylinder_speed)
        tangent, possible = self._tangent(xp, groups, omega, speed, force)
        steering = Steering.at_tangent(xp, tangent)
        groups = groups.steered(steering.sine * steering.sine)
        return self._at_force(xp, groups, omega, steering, force, possible, speed)

    def _tangent(
        self, xp: Any, groups: LossGroups, omega: Array, link_speed: Array, link_force: Array
    ) -> tuple[Array, Array]:
        """Tangent of the steering angle for a motion (nan if none gives it), and whether the wheel can follow it."""
        spin = xp.sign(omega)
        slope = safe_divide(xp, link_speed, self.cylinder_radius * xp.abs(omega), 0.0)
        tangent = steering_tangent(xp, self.creep_law, groups, slope, link_force / groups.slip_force)
        return spin * tangent, (spin != 0) | (link_speed == 0)

    def _at_force(
        self,
        xp: Any,
        groups: LossGroups,
        omega: Array,
        steering: Steering,
        link_force: Array,
        possible: Array = True,
        exact_speed: Array | None = None,
    ) -> OperatingPoint:
        """Operating point for a prescribed link force; `exact_speed` is the link speed if it is known."""
        rolling_force, slip_force = groups.rolling_force, groups.slip_force
        cosine, sine = steering.cosine, steering.sine
        spin = xp.sign(omega)
        standing = spin == 0
        # Static friction along the rolling direction carries as much of the force as it can.
        held = xp.clip(-link_force * sine, -rolling_force, rolling_force)
        against_rolling = xp.where(standing, held, -spin * rolling_force)
        lateral = -(link_force + against_rolling * sine) * steering.secant
        ratio = lateral / slip_force

        law = groups.formulas(self.creep_law)
        rolls = possible & (xp.abs(ratio) <= 1.0)
        safe = xp.where(rolls, ratio, 0.0)
        creepage = law.creepage(safe) / groups.creep_group
        along = cosine + spin * creepage * sine
        rolls = rolls & (standing | (along > 0))
        surface_speed = self.cylinder_radius * xp.abs(omega)
        rolling, link_speed = driven(xp, surface_speed, spin, creepage, steering, along)
        creep_speed, rolling_speed = creepage * rolling, -spin * rolling
        if law.flow_factor is not None:
            factor = creep.directed_flow_factor(law, safe, link_speed)
            rolls = rolls & (factor > 0)
            lost = link_speed * (xp.where(factor > 0, factor, 1.0) - 1.0)
            link_speed, creep_speed, rolling_speed = (
                link_speed + lost,
                creep_speed + lost * cosine,
                rolling_speed + lost * sine,
            )
            rolls = rolls & (standing | (rolling_speed * spin < 0))
        if exact_speed is not None:
            # The steering angle is exact to rounding, which Eq 17 amplifies near slip: close the balance exactly.
            rest = exact_speed - link_speed
            _check_angle(
                xp,
                rest,
                surface_speed + xp.abs(exact_speed),
                rolls,
                lambda: surface_speed * law.slope(safe) / (groups.creep_group * along * along),
            )
            link_speed, creep_speed = exact_speed, creep_speed + rest * cosine
            rolling_speed = rolling_speed + rest * sine

        torque, _ = contact_balance(lateral, against_rolling, cosine, sine, self.cylinder_radius)
        nothing = xp.where(rolls, 0.0 * link_force, xp.nan)
        still = xp.abs(spin) + nothing
        return self._point(
            xp,
            groups,
            omega,
            steering,
            torque=torque + nothing,
            link_speed=link_speed * still + 0.0,  # no negative zero
            link_force=link_force,
            rolling_speed=rolling_speed * still,
            creep_speed=creep_speed * still,
            lateral_force=lateral,
            slip_demand=xp.where(
                rolls,
                self.wheel.slip_demand(groups, ratio, creep_speed * still, rolling_speed * still),
                xp.where(xp.abs(ratio) > 1.0, xp.abs(ratio), xp.inf),
            ),
        )

    def _at_speed(
        self, xp: Any, groups: LossGroups, omega: Array, steering: Steering, link_speed: Array
    ) -> OperatingPoint:
        """Operating point for a prescribed link speed."""
        cosine, sine = steering.cosine, steering.sine
        surface_speed = self.cylinder_radius * omega
        creep_speed, rolling_speed = relative_velocities(link_speed, surface_speed, cosine, sine)
        law = groups.formulas(self.creep_law)
        ratio = sliding_ratio(xp, law, groups, creep_speed, rolling_speed)
        slip_demand = self.wheel.slip_demand(groups, ratio, creep_speed, rolling_speed)
        if law.flow_factor is not None:
            ratio, beyond = self._ratio_with_flow_loss(xp, groups, omega, steering, link_speed, ratio)
            slip_demand = xp.where(beyond, xp.inf, slip_demand)
        lateral = ratio * groups.slip_force
        against_rolling = xp.sign(rolling_speed) * groups.rolling_force
        torque, link_force = contact_balance(lateral, against_rolling, cosine, sine, self.cylinder_radius)
        at_rest = (rolling_speed == 0) & (creep_speed == 0)
        unknown = xp.where(at_rest, xp.nan, 0.0 * link_speed)
        return self._point(
            xp,
            groups,
            omega,
            steering,
            torque=torque + unknown,
            link_speed=link_speed,
            link_force=link_force + unknown,
            rolling_speed=rolling_speed,
            creep_speed=creep_speed,
            lateral_force=lateral + unknown,
            slip_demand=slip_demand,
        )

    def _ratio_with_flow_loss(
        self, xp: Any, groups: LossGroups, omega: Array, steering: Steering, link_speed: Array, sliding: Array
    ) -> tuple[Array, Array]:
        """Force ratio for a prescribed link speed under a law with a flow loss; `sliding` beyond slip."""
        cosine, sine = steering.cosine, steering.sine
        spin = xp.sign(omega)
        surface_speed = self.cylinder_radius * xp.abs(omega)
        law = groups.formulas(self.creep_law)

        def excess(ratio: Array) -> Array:
            creepage = law.creepage(ratio) / groups.creep_group
            along = cosine + spin * creepage * sine
            _, speed = driven(xp, surface_speed, spin, creepage, steering, along)
            factor = creep.directed_flow_factor(law, ratio, speed)
            return xp.where(along > 0, speed * factor - link_speed, signed_infinity(xp, ratio))

        top = xp.ones_like(link_speed) * (1.0 - 1e-15)
        rolls = (excess(-top) < 0) & (excess(top) > 0) & (spin != 0)
        found = bisect(xp, excess, -top, top)
        return xp.where(rolls, found, sliding), ~rolls & ((xp.abs(sliding) >= 1.0) | (spin != 0))

    def _point(
        self, xp: Any, groups: LossGroups, omega: Array, steering: Steering, *, slip_demand: Array, **state: Array
    ) -> OperatingPoint:
        """Operating point with its losses in the contact and the axle bearings.

        Source: faulring2006, Eq 8 (creep), Eq 13 (rolling), Eq 14 (bearing).
        """
        utilisation = {Limit.SLIP: slip_demand}
        if not isinstance(self.steering_range, float) or self.steering_range < math.pi / 2:
            utilisation[Limit.STEERING] = xp.abs(xp.atan(steering.tangent)) / self.steering_range
        rolled = xp.abs(state["rolling_speed"])
        losses = self.wheel.losses(groups, state["lateral_force"], state["creep_speed"], rolled)
        return OperatingPoint(
            cylinder_speed=omega, steering_tangent=steering.tangent, losses=losses, utilisation=utilisation, **state
        )


def turning_as(element: RotaryLinearIVT, known: RotaryLinearIVT) -> RotaryLinearIVT:
    """A wheel with measured values, whose creep stiffness changes with the steering angle as that of a known one."""
    found = replace(element)
    object.__setattr__(found.wheel, "_yielding", known.wheel._yielding)
    return found


def _check_angle(xp: Any, rest: Array, scale: Array, rolls: Array, give: Callable[[], Array]) -> None:
    """The steering angle found must give the required speed; without this a wrong one would hide in the creep loss.

    `give` is the derivative of link speed by force ratio: near slip, an asymptotic law amplifies the rounding of the ratio.
    """
    if xp.__name__ != "numpy" or not xp.any(rolls & (xp.abs(rest) > _SPEED_TOLERANCE * scale)):
        return
    if xp.any(rolls & (xp.abs(rest) > _SPEED_TOLERANCE * scale + _ROUNDING * give())):
        raise AuditError("the computed steering angle does not give the requested link speed")
