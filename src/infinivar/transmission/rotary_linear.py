r"""The rotational-to-linear cobotic transmission: a steered wheel pressed on a turning cylinder, carried by a link.

Signs (all four quadrants): ``phi`` steers, ``omega`` is the cylinder speed, ``ldot`` the link speed, ``fl`` the force
applied by the transmission to the link, ``tau`` the torque applied by the cylinder plant to the transmission.

.. math::
    u &= \dot l \cos\phi + R\omega\sin\phi, & v &= \dot l \sin\phi - R\omega\cos\phi \\
    \tau &= R (f_u \sin\phi - f_r \cos\phi), & f_l &= -f_u \cos\phi - f_r \sin\phi \\
    f_u &= C\,u/|v|, & f_r &= \mathrm{sgn}(v)\,(\tau_{in} + \tau_{wa})/r

so that ``tau omega - fl ldot = fu u + fr v >= 0`` always. With the creepage ``e = u/|v|`` and ``s = sgn(omega)``, a
wheel that rolls the way the cylinder drives it (``s v < 0``) moves the link at
``ldot = R |omega| (e - s t)/(1 + s e t)``, ``t = tan(phi)``: forward operation is explicit, and its inverse is one
Newton iteration in ``t``.

Source: faulring2006, Eqs 3-8 and 12-14, in passive form (see the errata in the documentation).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from infinivar._xp import Array, as_floats, bisect, namespace, newton, safe_divide, signed_infinity
from infinivar.contact import creep
from infinivar.errors import AuditError
from infinivar.limits import Limit
from infinivar.quantities import check, component, quantity
from infinivar.transmission.operating_point import OperatingPoint

_RIGHT_ANGLE = 1e-15
"""Cosines below this are those of a right angle: cos(pi/2) is 6e-17 in float64."""

_SPEED_TOLERANCE = 1e-6
"""Of surface and link speed together. Rounding leaves 1e-15, and more only within a millionth of slip with Eq 17."""

_BEYOND_ANY = 1e200
"""Stands for the secant of a right angle: finite, so that no force times it is still no force."""


def relative_velocities(link_speed: Array, surface_speed: Array, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Creep velocity u and rolling velocity v of the wheel at the contact.

    Parameters
    ----------
    link_speed, surface_speed : (...,) float   ldot and R omega. [m s^-1]
    cosine, sine : (...,) float                Of the steering angle. [-]

    Returns
    -------
    u, v : (...,) float   [m s^-1]; inputs broadcast.

    Source: faulring2006, Eqs 3 and 4.
    """
    return link_speed * cosine + surface_speed * sine, link_speed * sine - surface_speed * cosine


def contact_balance(
    lateral_force: Array, rolling_force: Array, cosine: Array, sine: Array, cylinder_radius: Array
) -> tuple[Array, Array]:
    """Cylinder torque and link force that balance the contact forces.

    Parameters
    ----------
    lateral_force, rolling_force : (...,) float   fu and fr. [N]
    cosine, sine : (...,) float                   Of the steering angle. [-]
    cylinder_radius : (...,) float                R. [m]

    Returns
    -------
    tau, fl : (...,) float   [N m], [N]; inputs broadcast.

    Source: faulring2006, Eqs 5 and 6.
    """
    tau = cylinder_radius * (lateral_force * sine - rolling_force * cosine)
    return tau, -lateral_force * cosine - rolling_force * sine


@dataclass(frozen=True, slots=True)
class _Steering:
    """Steering angle by its functions, so that formulas call no trigonometry."""

    cosine: Array
    sine: Array
    tangent: Array
    secant: Array

    @classmethod
    def at_angle(cls, xp, angle: Array) -> _Steering:
        """From an angle, right angles included."""
        cosine, sine = xp.cos(angle), xp.sin(angle)
        right = xp.abs(cosine) < _RIGHT_ANGLE
        safe = xp.where(right, 1.0, cosine)
        tangent = xp.where(right, signed_infinity(xp, sine), sine / safe)
        return cls(xp.where(right, 0.0, cosine), sine, tangent, xp.where(right, _BEYOND_ANY, 1.0 / safe))

    @classmethod
    def at_tangent(cls, xp, tangent: Array) -> _Steering:
        """From a finite tangent, or nan."""
        secant = xp.sqrt(1.0 + tangent * tangent)
        cosine = 1.0 / secant
        return cls(cosine, tangent * cosine, tangent, secant)


@dataclass(frozen=True, slots=True, kw_only=True)
class RotaryLinearIVT:
    """Steered wheel on a cylinder: the paper's infinitely variable transmission.

    Raises
    ------
    ValueError
        If a field is outside its range; the message names field, value and unit.
    """

    cylinder_radius: float = quantity("m", "> 0", "Cylinder radius R")
    wheel_radius: float = quantity("m", "> 0", "Rolling radius r of the wheel")
    preload: float = quantity("N", "> 0", "Normal force P that presses the wheel on the cylinder")
    friction: float = quantity("1", "> 0", "Rolling friction limit mu: the contact slips at mu P")
    creep_stiffness: float = quantity("N", "> 0", "Creep stiffness C = C22 G a b, lateral force over creepage")
    rolling_torque: float = quantity("N m", ">= 0", "Hysteresis torque of the rolling contact, about the wheel axle")
    bearing_torque: float = quantity("N m", ">= 0", "Friction torque of the wheel's axle bearings")
    steering_range: float = quantity(
        "rad", "> 0 and <= pi/2", "Largest steering angle to either side", default=math.pi / 2
    )
    creep_law: str = component("Creep law: linear, or faulring (linear with the flow loss of Eq 17)", default="linear")

    def __post_init__(self) -> None:
        """Refuse what is not physical."""
        check(self)
        creep.law(self.creep_law)

    @property
    def slip_force(self) -> float:
        """Lateral force at which the wheel slides, mu P. [N]"""
        return self.friction * self.preload

    @property
    def rolling_force(self) -> float:
        """Force against rolling, (tau_in + tau_wa)/r. [N]"""
        return (self.rolling_torque + self.bearing_torque) / self.wheel_radius

    @property
    def rolling_group(self) -> float:
        """H = (tau_in + tau_wa)/(r mu P), rolling resistance over slip force. [-]"""
        return self.rolling_force / self.slip_force

    @property
    def creep_group(self) -> float:
        """K = C/(mu P): the linear law slips at the creepage 1/K. [-]"""
        return self.creep_stiffness / self.slip_force

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
            Inputs broadcast. Prescribed force beyond slip: motion is nan, `limit` is SLIP. Prescribed speed beyond
            slip: forces of gross sliding, `limit` is SLIP. At rest (no cylinder nor link speed) the contact holds any
            force below slip: with a prescribed force, static friction takes what it can and `torque` is the smallest
            that holds; with a prescribed speed of zero the forces are not determined and nan.

        Raises
        ------
        ValueError
            If both or neither of `link_force` and `link_speed` are given, or a steering angle is beyond a right angle.

        Source: faulring2006, Eqs 3-8 and 12-14, in passive form.
        """
        if (link_force is None) == (link_speed is None):
            raise ValueError("give either link_force or link_speed")
        given = link_speed if link_force is None else link_force
        xp = namespace(self, cylinder_speed, steering_angle, given)
        omega, phi, given = as_floats(xp, cylinder_speed, steering_angle, given)
        if xp.__name__ == "numpy" and xp.any(xp.abs(phi) > math.pi / 2 + _RIGHT_ANGLE):
            raise ValueError("steering_angle must be within -pi/2 and pi/2 rad; the wheel has no direction of its own")
        omega, phi, given = xp.broadcast_arrays(omega, phi, given)
        steering = _Steering.at_angle(xp, phi)
        if link_force is None:
            return self._at_speed(xp, omega, steering, given)
        return self._at_force(xp, omega, steering, given)

    def steer(self, *, cylinder_speed: Array, link_speed: Array, link_force: Array) -> Array:
        """Steering angle at which the link moves at a given speed under a given force.

        Parameters
        ----------
        cylinder_speed : (...,) float   omega. At zero the link can only stand (angle 0) or be decoupled (+-pi/2), where
            it feels the rolling resistance, whatever force is asked for. [rad s^-1]
        link_speed, link_force : (...,) float   Of the link, force as applied by the transmission. [m s^-1], [N]

        Returns
        -------
        (...,) float   phi; nan where the contact would slip. Where two angles give the same motion (possible only
            beyond |tan phi| = K, or near slip with Eq 17) the one nearer to the locked state. [rad]

        Source: inverse of `operate`; derivation in the theory page.
        """
        xp = namespace(self, cylinder_speed, link_speed, link_force)
        omega, speed, force = as_floats(xp, cylinder_speed, link_speed, link_force)
        tangent, possible = self._tangent(xp, omega, speed, force)
        decoupled = (omega == 0) & (speed != 0)
        load, rolled = force / self.slip_force, self.rolling_group * xp.sign(omega) * tangent
        ratio = rolled - load * xp.sqrt(1.0 + tangent * tangent)
        angle = xp.where(possible & (xp.abs(ratio) <= 1.0), xp.atan(tangent), xp.nan)  # a nan ratio is not
        return xp.where(decoupled, -0.5 * math.pi * xp.sign(speed), angle)

    def deliver(self, *, cylinder_speed: Array, link_speed: Array, link_force: Array) -> OperatingPoint:
        """Operating point that gives the link a prescribed speed and force: `steer`, then `operate`, in one pass.

        Parameters
        ----------
        cylinder_speed, link_speed, link_force : (...,) float   As in `steer`. [rad s^-1], [m s^-1], [N]

        Returns
        -------
        OperatingPoint
            Its arrays broadcast to one shape. Where no steering angle does it, link speed and powers are nan and the
            limit is SLIP.

        Raises
        ------
        AuditError
            If an angle found does not give the speed asked for: a fault of the program.

        Source: inverse of `operate`; derivation in the theory page.
        """
        xp = namespace(self, cylinder_speed, link_speed, link_force)
        omega, speed, force = as_floats(xp, cylinder_speed, link_speed, link_force)
        tangent, possible = self._tangent(xp, omega, speed, force)
        return self._at_force(xp, omega, _Steering.at_tangent(xp, tangent), force, possible, speed)

    def _tangent(self, xp, omega: Array, link_speed: Array, link_force: Array) -> tuple[Array, Array]:
        """Tangent of the steering angle for a motion, nan where none gives it, and whether the wheel can follow at all."""
        spin = xp.sign(omega)
        surface_speed = self.cylinder_radius * xp.abs(omega)
        slope = safe_divide(xp, link_speed, surface_speed, 0.0)
        load = link_force / self.slip_force
        law, stiffness, rolling = creep.law(self.creep_law), self.creep_group, self.rolling_group

        def step(tangent: Array) -> Array:
            """One Newton step for T = s tan(phi) in T (1 + e q) - e + q = 0, q the link over the surface speed."""
            root = xp.sqrt(1.0 + tangent * tangent)
            ratio = rolling * tangent - load * root
            d_ratio = rolling - load * (tangent / root)
            creepage = law.creepage(ratio) / stiffness
            d_creepage = law.slope(ratio) / stiffness * d_ratio
            q, d_q = slope, 0.0
            if law.flow_factor is not None:
                q, d_q = creep.before_flow_loss(law, ratio, slope)
            value = tangent * (1.0 + creepage * q) - creepage + q
            d_value = 1.0 + creepage * q + (tangent * q - 1.0) * d_creepage
            if law.flow_factor is not None:
                d_value = d_value + (tangent * creepage + 1.0) * d_q * d_ratio
            # A slope that is not positive lies beyond the fastest motion this load allows: no steady angle.
            rising = d_value > 0
            return xp.where(rising, tangent - value / xp.where(rising, d_value, 1.0), xp.nan)

        start = -slope + 0.0 * load
        if law.flow_factor is not None:
            # Beyond slip Eq 17 is a polynomial without meaning that would throw the iteration off: start at slip.
            reach = xp.sqrt(xp.clip(1.0 / xp.where(load == 0, 1e-9, load) ** 2 - 1.0, 0.0, 1e18))
            start = xp.clip(start, -reach, reach)
        # Most points settle in 2 or 3 steps. Near the fastest motion two solutions meet and a step gains one bit only.
        tangent = newton(xp, step, start, steps=24)
        return spin * tangent, (spin != 0) | (link_speed == 0)

    def _at_force(
        self,
        xp,
        omega: Array,
        steering: _Steering,
        link_force: Array,
        possible: Array = True,
        exact_speed: Array | None = None,
    ) -> OperatingPoint:
        """Operating point for a prescribed link force; `exact_speed` is the link speed if known from elsewhere."""
        rolling_force, slip_force = self.rolling_force, self.slip_force
        cosine, sine = steering.cosine, steering.sine
        spin = xp.sign(omega)
        standing = spin == 0
        # Static friction along the rolling direction takes as much of the force as it can.
        held = xp.clip(-link_force * sine, -rolling_force, rolling_force)
        against_rolling = xp.where(standing, held, -spin * rolling_force)
        lateral = -(link_force + against_rolling * sine) * steering.secant
        ratio = lateral / slip_force

        law = creep.law(self.creep_law)
        rolls = possible & (xp.abs(ratio) <= 1.0)
        safe = xp.where(rolls, ratio, 0.0)
        creepage = law.creepage(safe) / self.creep_group
        along = cosine + spin * creepage * sine
        rolls = rolls & (standing | (along > 0))
        surface_speed = self.cylinder_radius * xp.abs(omega)
        rolling, link_speed = _driven(xp, surface_speed, spin, creepage, steering, along)
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
            # The steering angle was found to rounding, which Eq 17 blows up near slip: close the balance exactly.
            rest = exact_speed - link_speed
            _check_angle(xp, rest, surface_speed + xp.abs(exact_speed), rolls)
            link_speed, creep_speed = exact_speed, creep_speed + rest * cosine
            rolling_speed = rolling_speed + rest * sine

        torque, _ = contact_balance(lateral, against_rolling, cosine, sine, self.cylinder_radius)
        nothing = xp.where(rolls, 0.0 * link_force, xp.nan)
        still = xp.abs(spin) + nothing
        return self._point(
            xp,
            omega,
            steering,
            torque=torque + nothing,
            link_speed=link_speed * still + 0.0,  # no negative zero
            link_force=link_force,
            rolling_speed=rolling_speed * still,
            creep_speed=creep_speed * still,
            lateral_force=lateral,
            slip_demand=xp.where(rolls | (xp.abs(ratio) > 1.0), xp.abs(ratio), xp.inf),
        )

    def _at_speed(self, xp, omega: Array, steering: _Steering, link_speed: Array) -> OperatingPoint:
        """Operating point for a prescribed link speed."""
        cosine, sine = steering.cosine, steering.sine
        surface_speed = self.cylinder_radius * omega
        creep_speed, rolling_speed = relative_velocities(link_speed, surface_speed, cosine, sine)
        # cos(pi/2) is set to zero, but a wheel may still have nothing to roll on; inf is what a saturating law expects.
        creepage = safe_divide(xp, creep_speed, xp.abs(rolling_speed), 0.0)
        slides = (rolling_speed == 0) & (creep_speed != 0)
        creepage = xp.where(slides, signed_infinity(xp, creep_speed), creepage)
        law = creep.law(self.creep_law)
        ratio = law.force(creepage * self.creep_group)
        beyond = xp.abs(creepage * self.creep_group) > 1.0
        if law.flow_factor is not None:
            ratio, beyond = self._ratio_with_flow_loss(xp, omega, steering, link_speed, ratio)
        lateral = ratio * self.slip_force
        against_rolling = xp.sign(rolling_speed) * self.rolling_force
        torque, link_force = contact_balance(lateral, against_rolling, cosine, sine, self.cylinder_radius)
        at_rest = (rolling_speed == 0) & (creep_speed == 0)
        unknown = xp.where(at_rest, xp.nan, 0.0 * link_speed)
        return self._point(
            xp,
            omega,
            steering,
            torque=torque + unknown,
            link_speed=link_speed,
            link_force=link_force + unknown,
            rolling_speed=rolling_speed,
            creep_speed=creep_speed,
            lateral_force=lateral + unknown,
            slip_demand=xp.where(beyond, xp.inf, xp.abs(ratio)),
        )

    def _ratio_with_flow_loss(
        self, xp, omega: Array, steering: _Steering, link_speed: Array, sliding: Array
    ) -> tuple[Array, Array]:
        """Force ratio at which the link has a prescribed speed under a law with a flow loss; `sliding` beyond slip."""
        cosine, sine = steering.cosine, steering.sine
        spin = xp.sign(omega)
        surface_speed = self.cylinder_radius * xp.abs(omega)
        law = creep.law(self.creep_law)

        def excess(ratio: Array) -> Array:
            creepage = law.creepage(ratio) / self.creep_group
            along = cosine + spin * creepage * sine
            _, speed = _driven(xp, surface_speed, spin, creepage, steering, along)
            factor = creep.directed_flow_factor(law, ratio, speed)
            return xp.where(along > 0, speed * factor - link_speed, signed_infinity(xp, ratio))

        top = xp.ones_like(link_speed) * (1.0 - 1e-15)
        rolls = (excess(-top) < 0) & (excess(top) > 0) & (spin != 0)
        found = bisect(xp, excess, -top, top)
        return xp.where(rolls, found, sliding), ~rolls & ((xp.abs(sliding) >= 1.0) | (spin != 0))

    def _point(self, xp, omega: Array, steering: _Steering, *, slip_demand: Array, **state: Array) -> OperatingPoint:
        rolled = xp.abs(state["rolling_speed"])
        utilisation = {Limit.SLIP: slip_demand}
        if self.steering_range < math.pi / 2:
            utilisation[Limit.STEERING] = xp.abs(xp.atan(steering.tangent)) / self.steering_range
        return OperatingPoint(
            cylinder_speed=omega,
            steering_tangent=steering.tangent,
            losses={
                "creep": state["lateral_force"] * state["creep_speed"],
                "rolling": self.rolling_torque / self.wheel_radius * rolled,
                "bearing": self.bearing_torque / self.wheel_radius * rolled,
            },
            utilisation=utilisation,
            **state,
        )


def _driven(
    xp, surface_speed: Array, spin: Array, creepage: Array, steering: _Steering, along: Array
) -> tuple[Array, Array]:
    """Rolling speed |v| and link speed of a wheel that rolls the way the cylinder drives it.

    `along` is ``cos(phi) + s e sin(phi)``, positive for such a wheel; elsewhere the result means nothing.
    """
    rolling = surface_speed / xp.where(along > 0, along, 1.0)
    return rolling, rolling * (creepage * steering.cosine - spin * steering.sine)


def _check_angle(xp, rest: Array, scale: Array, rolls: Array) -> None:
    """The steering angle found must give the speed asked for; without this a wrong one would hide in the creep loss."""
    if xp.__name__ == "numpy" and xp.any(rolls & (xp.abs(rest) > _SPEED_TOLERANCE * scale)):
        raise AuditError("the steering angle found does not give the link speed asked for")
