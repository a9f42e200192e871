"""Coulomb friction, including at rest, and a friction limit that falls with speed."""

from __future__ import annotations

from infinivar._core.array_namespace import Array, as_floats, namespace

STICK_SPEED = 1e-4
"""Default speed of a link below which friction sticks in simulations. [m s^-1]"""


def coulomb(speed: Array, size: Array, stick_speed: Array | None = None, *, held: Array | None = None) -> Array:
    r"""Coulomb friction: opposes motion, and at rest is a static constraint that carries what it can.

    .. math:: F = F_c\,\mathrm{sgn}\,v \;(v \ne 0), \qquad F = -\mathrm{clip}(f, -F_c, F_c) \;(v = 0), \qquad\text{or}\quad
        F = \tfrac12 F_c\,s\,(3 - s^2), \quad s = \mathrm{clip}(v/v_\varepsilon, -1, 1)

    Parameters
    ----------
    speed : (...,) float         v, of any unit.
    size : (...,) float          F_c, >= 0, of any unit.
    stick_speed : (...,) float   v_eps > 0, below which friction falls smoothly to zero, for time-domain simulation: a body
        that should stick creeps more slowly than this. From v_eps on friction is exactly Coulomb's. None: a step.
    held : (...,) float          f, force to be exerted; at rest, friction exerts as much of it as it can, and ``f + F``
        remains. None: at rest friction is zero.

    Returns
    -------
    (...,) float   With the sign of the speed; at rest with that of ``-held``.

    Source: faulring2006, section V (Coulombic losses); the smooth step is the cubic without a kink at v_eps; at rest:
    Coulomb's law as an inequality.
    """
    xp = namespace(speed, size, stick_speed, held)
    if stick_speed is not None:
        slow = xp.clip(speed / stick_speed, -1.0, 1.0)
        return size * (0.5 * slow * (3.0 - slow * slow))
    sliding = size * xp.sign(speed)
    if held is None:
        return sliding
    return xp.where(speed == 0, -xp.clip(held + 0.0 * size, -size, size), sliding)


def falling(speed: Array, friction: Array, fast_friction_ratio: Array, decay_speed: Array) -> Array:
    r"""Friction limit at a speed.

    .. math:: \mu(V) = \mu_0 \left(A + (1 - A)\, e^{-|V|/V_0}\right)

    Parameters
    ----------
    speed : (...,) float                 V; its sign does not matter. [m s^-1]
    friction : (...,) float              mu_0, friction limit at rest. [-]
    fast_friction_ratio : (...,) float   A, friction limit far above V_0 over that at rest, 0 to 1; 1: constant. [-]
    decay_speed : (...,) float           V_0, > 0. [m s^-1]

    Returns
    -------
    (...,) float   mu(V). [-]

    Source: polach2005, Eq 4 (there with a decay per speed B = 1/V_0).
    """
    xp = namespace(speed, friction, fast_friction_ratio, decay_speed)
    speed, friction, ratio, decay = as_floats(xp, speed, friction, fast_friction_ratio, decay_speed)
    return friction * (ratio + (1.0 - ratio) * xp.exp(-xp.abs(speed) / decay))
