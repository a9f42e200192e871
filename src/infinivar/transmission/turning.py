"""A wheel that is steered while it drives the link: operating points with the forces of `infinivar.transmission.spin_law`."""

from __future__ import annotations

from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, as_floats, namespace, reached, rising_root
from infinivar.contact.exact.spin_map import SpinMap, spin_map
from infinivar.errors import require
from infinivar.transmission.geometry import LossGroups
from infinivar.transmission.kinematics import Steering, contact_balance
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.transmission.spin_law import TurningPatch, law, moment, on_the_spot, shares, slip_demand

__all__ = ["Turned", "TurningPatch", "deliver", "law", "on_the_spot", "shares", "slip_demand"]

_BEYOND = 2.0
"""Reach of the search over the creepage of full slip, as the creep stiffness falls with the steering angle."""

_SHORT = 0.9
"""Largest creepage looked for, over that at which the wheel would be at a right angle. [-]"""

_STEPS = 40

_INWARD = 4
"""Times that the search is narrowed where the excess does not rise at its ends, as it may not with a large spin."""

_CLOSE = 1e-9
"""Largest error of the force ratio at a creepage found. [-]"""


class Turned(NamedTuple):
    """A wheel that is steered while it drives the link."""

    point: OperatingPoint
    """Its "creep" loss is the power f_u u, which may be negative: see `shares`."""
    moment: Array
    """Moment that resists steering. [N m]"""


def deliver(
    element: RotaryLinearIVT, *, cylinder_speed: Array, link_speed: Array, link_force: Array, steering_rate: Array
) -> Turned:
    """Operating point of an element with geometry that gives the link a speed and a force while it is steered.

    Parameters
    ----------
    element : RotaryLinearIVT     With `geometry`.
    cylinder_speed : (...,) float   Nonzero. [rad s^-1]
    link_speed, link_force : (...,) float   As in `RotaryLinearIVT.deliver`. [m s^-1], [N]
    steering_rate : (...,) float  [rad s^-1]

    Returns
    -------
    Turned   Where no steering angle gives the motion, all is nan and the limit is SLIP. So it is for some motions with a lateral
        force above 0.8 mu P while the patch's edge turns, h times the steering rate, at more than 0.08 of the rolling speed, and
        for some within 1 % of slip.

    Raises
    ------
    ParameterError
        If the element has no geometry, or a cylinder speed is 0.

    Source: `RotaryLinearIVT.deliver` with the forces of `TurningPatch`.
    """
    xp = namespace(element, cylinder_speed, link_speed, link_force, steering_rate)
    groups = element.groups(cylinder_speed)
    omega, speed, force, rate = xp.broadcast_arrays(
        *as_floats(xp, cylinder_speed, link_speed, link_force, steering_rate)
    )
    patch = TurningPatch.of(element, groups)
    if xp.__name__ == "numpy":
        require(bool(xp.all(omega != 0.0)), "cylinder_speed", 0.0, "nonzero", "rad/s")
    way, surface = xp.sign(omega), element.cylinder_radius * xp.abs(omega)
    known = spin_map(patch.a_over_b, patch.poisson)
    creep, tangent, rolls = _solved(
        xp, patch, known, groups, speed / surface, force / groups.slip_force, way * rate / surface
    )
    secant = xp.sqrt(1.0 + tangent * tangent)
    rolling = surface * secant / (1.0 + creep * tangent)
    steering = Steering.at_tangent(xp, way * tangent)
    nothing = xp.where(rolls, 0.0, xp.nan)
    creep_speed, rolling_speed = creep * rolling + nothing, nothing - way * rolling
    here = patch._replace(creep_stiffness=groups.steered(steering.sine * steering.sine).creep_stiffness)
    resisting = moment(known, here, creep_speed=creep_speed, steering_rate=rate, rolling_speed=rolling_speed)
    lateral = groups.slip_force * (groups.rolling_group * tangent) - force * secant + nothing
    sliding = slip_demand(
        creep_speed,
        rate,
        rolling_speed,
        slip_force=groups.slip_force,
        creep_stiffness=here.creep_stiffness,
        lever=patch.lever,
        slip_creepage=groups.full_slip,
    )
    against_rolling = -way * groups.rolling_force
    torque, _ = contact_balance(lateral, against_rolling, steering.cosine, steering.sine, element.cylinder_radius)
    return Turned(
        element._point(
            xp,
            groups,
            omega,
            steering,
            torque=torque,
            link_speed=speed + nothing,
            link_force=force,
            rolling_speed=rolling_speed,
            creep_speed=creep_speed,
            lateral_force=lateral,
            slip_demand=xp.where(rolls, xp.maximum(xp.abs(lateral) / groups.slip_force, sliding), xp.inf),
        ),
        resisting,
    )


def _solved(
    xp: Any, patch: TurningPatch, known: SpinMap, groups: LossGroups, slope: Array, load: Array, turn: Array
) -> tuple[Array, Array, Array]:
    """Creepage e, tangent T, and whether they give the motion: ``f_y(e, spin) = x(T(e))`` of `infinivar.transmission.inverse`.

    `turn` is the steering rate over the surface speed, times the sign of the cylinder speed. [m^-1]
    """
    stiffness, group = groups.creep_group, groups.rolling_group
    c22, turned = known.scale.c22, known.scale.c22 * known.scale.lever

    def excess(creep: Array) -> tuple[Array, Array]:
        """For the creepage e scaled by the stiffness at angle 0, which the compliance g at the wheel's angle reduces."""
        e = creep / stiffness
        after = 1.0 + e * slope
        tangent, d_tangent = (e - slope) / after, (1.0 + slope * slope) / (after * after)
        root = xp.sqrt(1.0 + tangent * tangent)
        along = 1.0 + e * tangent
        spin = -stiffness * patch.lever * turn * along / root
        d_spin = -patch.lever * turn * ((tangent + e * d_tangent) / root - along * tangent * d_tangent / root**3)
        g, by_share, _ = groups.compliance(1.0 - 1.0 / (root * root))
        d_ease = -by_share * 2.0 * tangent / root**4 / g * d_tangent / stiffness
        force, by_lateral, by_spin = known.lateral_force(creep / (c22 * g), spin / (turned * g))
        d_ratio = (group - load * tangent / root) * d_tangent / stiffness
        d_force = by_lateral / c22 * (1.0 + creep * d_ease)
        d_force = (d_force + by_spin / turned * (d_spin + spin * d_ease)) / g
        return force - group * tangent + load * root, d_force - d_ratio

    # Beyond, the wheel slides or stands at a right angle.
    edge = _BEYOND * groups.full_slip + stiffness * patch.lever * xp.abs(turn)
    edge = xp.minimum(edge, _SHORT * stiffness / xp.maximum(xp.abs(slope), 1e-9))
    # The linear theory, with the force and spin of the wheel that does not creep.
    root = xp.sqrt(1.0 + slope * slope)
    start = known.scale.by_spin * stiffness * patch.lever * turn / root - group * slope - load * root
    creep = rising_root(xp, excess, -edge, edge, _STEPS, start, _INWARD)
    e = creep / stiffness
    tangent = (e - slope) / (1.0 + e * slope)
    rolls = (xp.abs(excess(creep)[0]) <= reached(xp, _CLOSE)) & (1.0 + e * tangent > 0.0)
    return e, tangent, rolls
