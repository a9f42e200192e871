"""Contact forces from velocities for time-varying motion, including rest and gross slip.

These are the laws behind `RotaryLinearIVT.operate` as functions of the creep velocity u and the rolling velocity v. Creepage
is creep speed over rolling speed, which is undefined at rest: below a rolling speed of ``stick_speed`` the contact becomes
viscous, and creeps at ``stick_speed/K`` at most before it slips.

Source: faulring2006, sections II and III, in passive form.
"""

from __future__ import annotations

from infinivar._core.array_namespace import Array, namespace
from infinivar.contact.creep import CreepLaw, Formulas


def lateral_force(
    law: CreepLaw | Formulas,
    creep_speed: Array,
    rolling_speed: Array,
    slip_force: Array,
    creep_stiffness: Array,
    stick_speed: Array,
) -> Array:
    r"""Lateral force of the contact from its velocities.

    .. math:: f_u = \mu P\, x\!\left(\frac{C}{\mu P} \frac{u}{\sqrt{v^2 + v_\varepsilon^2}}\right)

    Parameters
    ----------
    law : CreepLaw or Formulas       A law without a flow loss.
    creep_speed : (...,) float       u. [m s^-1]
    rolling_speed : (...,) float     v. [m s^-1]
    slip_force : (...,) float        mu P. [N]
    creep_stiffness : (...,) float   C. [N]
    stick_speed : (...,) float       v_eps > 0; at a rolling speed of 10 v_eps the creep is 0.5 % too large. [m s^-1]

    Returns
    -------
    (...,) float   f_u, with the sign of u; in gross slip its magnitude is the slip force. [N]

    Source: faulring2006, Eq 7, in passive form; other laws as in `infinivar.contact.creep`.
    """
    return slip_force * law.force(scaled_creepage(creep_speed, rolling_speed, slip_force, creep_stiffness, stick_speed))


def slips(
    creep_speed: Array,
    rolling_speed: Array,
    slip_force: Array,
    creep_stiffness: Array,
    stick_speed: Array,
    slip_creepage: Array,
) -> Array:
    """Whether the whole patch slides, that is, the scaled creepage exceeds `slip_creepage`; see also `lateral_force`."""
    xp = namespace(creep_speed, rolling_speed)
    return xp.abs(scaled_creepage(creep_speed, rolling_speed, slip_force, creep_stiffness, stick_speed)) > slip_creepage


def scaled_creepage(
    creep_speed: Array, rolling_speed: Array, slip_force: Array, creep_stiffness: Array, stick_speed: Array
) -> Array:
    """Creepage relative to the slip limit of the linear law; arguments as in `lateral_force`. [-]"""
    xp = namespace(creep_speed, rolling_speed)
    rolling = xp.sqrt(rolling_speed * rolling_speed + stick_speed * stick_speed)
    return creep_stiffness / slip_force * (creep_speed / rolling)


def compliance(share: Array, first: Array, second: Array) -> tuple[Array, Array, Array]:
    r"""Creep compliance of a steered wheel relative to that at steering angle 0.

    .. math:: \frac{C(0)}{C(\phi)} = 1 + \sin^2\phi\,(k_1 + k_2\cos^2\phi)

    Parameters
    ----------
    share : (...,) float           Square of the sine of the steering angle. [-]
    first, second : (...,) float   k_1, k_2, from `ContactGeometry.yielding`. [-]

    Returns
    -------
    compliance, slope, curvature : (...,) float   Value, and derivatives by `share`. [-]

    Source: `infinivar.contact.turned`.
    """
    rest = 1.0 - share
    return 1.0 + share * (first + second * rest), first + second * (rest - share), -2.0 * second
