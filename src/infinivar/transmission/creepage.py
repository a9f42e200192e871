"""The wheel's contact while its motion changes: forces from velocities, at rest and in gross slip, too.

What `RotaryLinearIVT.operate` gives for steady motion, as constitutive laws of the creep velocity u and the rolling
velocity v. Creepage is creep over rolling speed, which means nothing where nothing rolls: below a rolling speed of
``stick_speed`` the contact is a viscous one that yields at ``stick_speed/K`` at most.

Source: faulring2006, sections II and III, in passive form.
"""

from __future__ import annotations

from infinivar._core.array_namespace import Array, namespace
from infinivar.contact.creep import CreepLaw


def lateral_force(
    law: CreepLaw,
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
    law : CreepLaw                   Without a flow loss.
    creep_speed : (...,) float       u. [m s^-1]
    rolling_speed : (...,) float     v. [m s^-1]
    slip_force : (...,) float        mu P. [N]
    creep_stiffness : (...,) float   C. [N]
    stick_speed : (...,) float       v_eps > 0; at ten times this rolling speed the creep is half a percent too large. [m s^-1]

    Returns
    -------
    (...,) float   f_u, with the sign of u; its size is the slip force in gross slip. [N]

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
    """Whether the whole patch slides: from the scaled creepage `slip_creepage` on. Other arguments as in `lateral_force`."""
    xp = namespace(creep_speed, rolling_speed)
    return xp.abs(scaled_creepage(creep_speed, rolling_speed, slip_force, creep_stiffness, stick_speed)) > slip_creepage


def scaled_creepage(
    creep_speed: Array, rolling_speed: Array, slip_force: Array, creep_stiffness: Array, stick_speed: Array
) -> Array:
    """Creepage over that at which the linear law slips; arguments as in `lateral_force`. [-]"""
    xp = namespace(creep_speed, rolling_speed)
    rolling = xp.sqrt(rolling_speed * rolling_speed + stick_speed * stick_speed)
    return creep_stiffness / slip_force * (creep_speed / rolling)
