"""Coulomb friction that falls with speed."""

from __future__ import annotations

from infinivar._xp import Array, as_floats, namespace


def falling(speed: Array, friction: Array, fast_friction_ratio: Array, decay_speed: Array) -> Array:
    r"""Friction limit at a speed.

    .. math:: \mu(V) = \mu_0 \left(A + (1 - A)\, e^{-|V|/V_0}\right)

    Parameters
    ----------
    speed : (...,) float                 V; its sign does not matter. [m s^-1]
    friction : (...,) float              mu_0, at rest. [-]
    fast_friction_ratio : (...,) float   A, friction far above V_0 over that at rest, 0 to 1; 1 is constant friction. [-]
    decay_speed : (...,) float           V_0, > 0. [m s^-1]

    Returns
    -------
    (...,) float   mu(V). [-]

    Source: polach2005, Eq 4 (there with a decay per speed B = 1/V_0).
    """
    xp = namespace(speed, friction, fast_friction_ratio, decay_speed)
    speed, friction, ratio, decay = as_floats(xp, speed, friction, fast_friction_ratio, decay_speed)
    return friction * (ratio + (1.0 - ratio) * xp.exp(-xp.abs(speed) / decay))
