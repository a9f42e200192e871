r"""The contact while the wheel is steered: its patch has spin, and resists with a moment.

The bell turns the wheel about the normal of the contact. Neither the cylinder, whose axis is parallel to the tangent plane, nor
the wheel on its axle, which is as well, turns about that normal: steering is all the spin there is. Per distance rolled it is
the steering rate over the rolling speed. With the lateral direction at a right angle to the rolling one, in the sense of phi,

.. math:: f_u = \mu P\, f_y\!\left(\frac{u}{|v|}, \frac{\dot\phi}{v}\right), \qquad
    M = \mathrm{sgn}(v)\, \mu P c\, m_z\!\left(\frac{u}{|v|}, \frac{\dot\phi}{v}\right), \qquad f_u u + M\dot\phi \ge 0

with the forces of `infinivar.contact.exact.spin_map`. A wheel that rolls backwards has leading and trailing edge exchanged,
hence the signs of v.

Source: kalker1990, steady rolling; kinematics of faulring2006, Eq 3 and Eq 4.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, as_floats, namespace, rising_root
from infinivar.contact.exact.spin_calls import force_ratio, moment_ratio
from infinivar.contact.exact.spin_map import spin_map
from infinivar.contact.exact.spin_nodes import scales
from infinivar.errors import ParameterError, require
from infinivar.transmission.geometry import LossGroups, PressedContact
from infinivar.transmission.kinematics import Steering, contact_balance
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_BEYOND = 2.0
"""Reach of the search over the creepage of full slip, as the creep stiffness falls with the steering angle."""

_SHORT = 0.9
"""Largest creepage looked for, over that at which the wheel would be at a right angle. [-]"""

_STEPS = 40

_INWARD = 4
"""Times that the search is narrowed where the excess does not rise at its ends, as it may not with a large spin."""

_CLOSE = 1e-9
"""Largest error of the force ratio at a creepage found. [-]"""


def _contact(element: RotaryLinearIVT) -> PressedContact:
    if element.contact is None:
        raise ParameterError("geometry is missing: measured values of a contact do not tell its forces with spin")
    return element.contact


class TurningPatch(NamedTuple):
    """What determines the forces of one loaded patch that turns while it rolls."""

    slip_force: Array
    """mu P. [N]"""
    creep_stiffness: Array
    """C = C22 G a b. [N]"""
    lever: Array
    """h, the mean radius of the patch's edge. [m]"""
    a_over_b: Array
    """Rolling over lateral semi-axis. [-]"""
    poisson: Array
    """Combined nu. [-]"""

    @classmethod
    def of(cls, element: RotaryLinearIVT, groups: LossGroups) -> TurningPatch:
        """The patch of an element with geometry, at the friction limit of the groups."""
        contact = _contact(element)
        lever = scales(contact.axis_ratio, contact.poisson).lever * (contact.patch.a * contact.patch.b) ** 0.5
        return cls(groups.slip_force, groups.creep_stiffness, lever, contact.axis_ratio, contact.poisson)


def law(
    creep_speed: Array,
    steering_rate: Array,
    rolling_speed: Array,
    *,
    slip_force: Array,
    creep_stiffness: Array,
    lever: Array,
    a_over_b: Array,
    poisson: Array,
    stick_speed: Array = 0.0,
) -> tuple[Array, Array]:
    """Lateral force, and moment that resists steering.

    Parameters
    ----------
    creep_speed : (...,) float     u. [m s^-1]
    steering_rate : (...,) float   [rad s^-1]
    rolling_speed : (...,) float   v, not 0 without a stick speed. [m s^-1]
    slip_force, creep_stiffness, lever, a_over_b, poisson : (...,) float   As in `TurningPatch`.
    stick_speed : (...,) float     v_eps >= 0: the wheel creeps and turns as at a rolling speed of hypot(v, v_eps). [m s^-1]

    Returns
    -------
    f_u, M : (...,) float   [N], [N m]; ``f_u u + M rate >= 0``.
    """
    xp = namespace(creep_speed, steering_rate, rolling_speed, slip_force)
    rolling = xp.sqrt(rolling_speed * rolling_speed + stick_speed * stick_speed)
    way = xp.where(rolling_speed < 0.0, -1.0, 1.0)
    scale = creep_stiffness / (slip_force * rolling)
    creep, spin = scale * creep_speed, scale * lever * way * steering_rate
    force = slip_force * force_ratio(creep, spin, a_over_b, poisson)
    return force, slip_force * lever * way * moment_ratio(creep, spin, a_over_b, poisson)


def slip_demand(
    creep_speed: Array,
    steering_rate: Array,
    rolling_speed: Array,
    *,
    slip_force: Array,
    creep_stiffness: Array,
    lever: Array,
    slip_creepage: Array,
    stick_speed: Array = 0.0,
) -> Array:
    """Lateral creep over that with which no point of the patch can stick; above 1 the whole patch slides sideways.

    The wheel turns about its middle with the spin, so that its edge moves at the lever times the steering rate: the creep is
    that of full slip without spin and this speed. `slip_creepage` is `LossGroups.full_slip`; other arguments as in `law`. [-]
    """
    xp = namespace(creep_speed, steering_rate, rolling_speed, slip_force)
    rolling = xp.sqrt(rolling_speed * rolling_speed + stick_speed * stick_speed)
    sticks = slip_creepage * slip_force / creep_stiffness * rolling + lever * xp.abs(steering_rate)
    return xp.abs(creep_speed) / sticks


def shares(creep: Array, turning: Array) -> tuple[Array, Array]:
    """What the patch dissipates, as a loss by creep and one by turning, from the powers f_u u and M times the steering rate.

    Only their sum is friction. Where one is negative, the patch passes power from steering to rolling or back, and the other
    is larger than the loss.
    """
    xp = namespace(creep, turning)
    total = creep + turning
    by_creep = xp.where(turning < 0.0, total, xp.where(creep < 0.0, 0.0 * creep, creep))
    return by_creep, total - by_creep


def on_the_spot(element: RotaryLinearIVT, lateral_force: Array) -> tuple[Array, Array]:
    """Creep of a loaded link per angle steered while the cylinder rests, and the moment that resists.

    The patch turns as a rigid body slips, whichever way and however fast it is steered, about a point off its middle that
    gives the lateral force. A locked link that is steered to and fro therefore creeps under its load.

    Parameters
    ----------
    element : RotaryLinearIVT     With `geometry`.
    lateral_force : (...,) float  f_u. [N]

    Returns
    -------
    creep, moment : (...,) float   With the sign of the force: [m rad^-1]; [N m]. nan at and beyond the slip force.

    Source: `SpinMap.on_the_spot`.
    """
    contact = _contact(element)
    length = (contact.patch.a * contact.patch.b) ** 0.5
    creep, moment = spin_map(contact.axis_ratio, contact.poisson).on_the_spot(lateral_force / element.slip_force)
    return length * creep, element.slip_force * length * moment


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
    creep, tangent, rolls = _solved(xp, patch, groups, speed / surface, force / groups.slip_force, way * rate / surface)
    secant = xp.sqrt(1.0 + tangent * tangent)
    rolling = surface * secant / (1.0 + creep * tangent)
    steering = Steering.at_tangent(xp, way * tangent)
    nothing = xp.where(rolls, 0.0, xp.nan)
    creep_speed, rolling_speed = creep * rolling + nothing, nothing - way * rolling
    here = patch._replace(creep_stiffness=groups.steered(steering.sine * steering.sine).creep_stiffness)
    _, moment = law(creep_speed, rate, rolling_speed, **here._asdict())
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
        moment,
    )


def _solved(
    xp: Any, patch: TurningPatch, groups: LossGroups, slope: Array, load: Array, turn: Array
) -> tuple[Array, Array, Array]:
    """Creepage e, tangent T, and whether they give the motion: ``f_y(e, spin) = x(T(e))`` of `infinivar.transmission.inverse`.

    `turn` is the steering rate over the surface speed, times the sign of the cylinder speed. [m^-1]
    """
    stiffness, group = groups.creep_group, groups.rolling_group
    known = spin_map(patch.a_over_b, patch.poisson)
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
    rolls = (xp.abs(excess(creep)[0]) <= _CLOSE) & (1.0 + e * tangent > 0.0)
    return e, tangent, rolls
