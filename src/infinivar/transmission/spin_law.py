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

from typing import NamedTuple, Protocol

from infinivar._core.array_namespace import Array, namespace, plain
from infinivar.contact.exact.spin_calls import force_ratio, moment_ratio
from infinivar.contact.exact.spin_map import SpinMap, scales, spin_map
from infinivar.errors import ParameterError
from infinivar.transmission.geometry import LossGroups, PressedContact


class Pressed(Protocol):
    """A rolling contact or a machine with one: what the forces of a turning patch depend on."""

    @property
    def contact(self) -> PressedContact | None:
        """The contact under its preload, if its geometry is known."""
        ...

    @property
    def slip_force(self) -> Array:
        """mu P. [N]"""
        ...


def _contact(element: Pressed) -> PressedContact:
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
    def of(cls, element: Pressed, groups: LossGroups) -> TurningPatch:
        """The patch of an element with geometry, at the friction limit of the groups."""
        contact = _contact(element)
        lever = plain(scales(contact.axis_ratio, contact.poisson).lever) * (contact.patch.a * contact.patch.b) ** 0.5
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
    creep, spin, way = _scaled(
        creep_speed, steering_rate, rolling_speed, slip_force, creep_stiffness, lever, stick_speed=stick_speed
    )
    force = slip_force * force_ratio(creep, spin, a_over_b, poisson)
    return force, slip_force * lever * way * moment_ratio(creep, spin, a_over_b, poisson)


def moment(
    known: SpinMap, patch: TurningPatch, *, creep_speed: Array, steering_rate: Array, rolling_speed: Array
) -> Array:
    """The moment of `law` alone, by the map of the patch; other arguments as there. [N m]"""
    creep, spin, way = _scaled(
        creep_speed, steering_rate, rolling_speed, patch.slip_force, patch.creep_stiffness, patch.lever
    )
    return patch.slip_force * patch.lever * way * known.moment_ratio(creep, spin)


def _scaled(
    creep_speed: Array,
    steering_rate: Array,
    rolling_speed: Array,
    slip_force: Array,
    creep_stiffness: Array,
    lever: Array,
    stick_speed: Array = 0.0,
) -> tuple[Array, Array, Array]:
    """Scaled creepages of the map, and the sign of v."""
    xp = namespace(creep_speed, steering_rate, rolling_speed, slip_force)
    rolling = xp.sqrt(rolling_speed * rolling_speed + stick_speed * stick_speed)
    way = xp.where(rolling_speed < 0.0, -1.0, 1.0)
    scale = creep_stiffness / (slip_force * rolling)
    return scale * creep_speed, scale * lever * way * steering_rate, way


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


def on_the_spot(element: Pressed, lateral_force: Array) -> tuple[Array, Array]:
    """Creep of a loaded link per angle steered while the cylinder rests, and the moment that resists.

    The patch turns as a rigid body slips, whichever way and however fast it is steered, about a point off its middle that
    gives the lateral force. A locked link that is steered to and fro therefore creeps under its load.

    Parameters
    ----------
    element : RotaryLinearIVT or RollingContact   With `geometry`.
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
