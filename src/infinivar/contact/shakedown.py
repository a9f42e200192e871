r"""Shakedown of rolling bodies: the load below which yielding stops after a few passes.

Residual stress from the first passes can balance every stress but the shear between the rolling direction and the depth,
which changes its sign during each pass. Repeated rolling remains elastic while this shear is below the yield stress k in
shear; above, the bodies deform plastically with each pass.
"""

from __future__ import annotations

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, as_floats, bisect, namespace
from infinivar._core.fields import check_value

LONGEST = 2.0
"""Largest a/b for which the shear along the rolling direction decides.

Rolled over, a point is free of stress once in a pass, so residual stress at most doubles the load of first yield: by Tresca,
the circle's 4.7 k is far below that, but from a/b = 2.5 on it is the lower limit.
"""


def orthogonal_shear(a: Array, b: Array) -> tuple[Array, Array]:
    r"""Largest shear stress between rolling direction and depth below an elliptical contact.

    .. math:: \frac{2\tau_0}{p_0} = \frac{\sqrt{2t - 1}}{t(t + 1)}, \qquad \frac{z_0}{a} = \frac{1}{(t + 1)\sqrt{2t - 1}},
        \qquad (t^2 - 1)(2t - 1) = \left(\frac{a}{b}\right)^2

    Parameters
    ----------
    a, b : (...,) float   Semi-axes along and across the rolling direction, a/b up to 100. [m]

    Returns
    -------
    shear, depth : (...,) float   tau_0 over the peak pressure, [-]; z_0, [m]. It occurs ahead of and behind the centre with
        opposite signs, for any Poisson's ratio.

    Raises
    ------
    ParameterError
        If an argument is not above zero.

    Notes
    -----
    A line contact across the rolling direction has 1/4 at half its half-width, a circle 0.214. Friction is neglected.

    Source: lundberg1947 (there with the axes named the other way round).
    """
    check_value("a", a, "m", Gt(0))
    check_value("b", b, "m", Gt(0))
    xp = namespace(a, b)
    a, b = xp.broadcast_arrays(*as_floats(xp, a, b))
    square = (a / b) ** 2
    one = xp.ones_like(square)
    t = bisect(xp, lambda t: (t * t - 1.0) * (2.0 * t - 1.0) - square, one, 30.0 * one, steps=60)
    root = xp.sqrt(2.0 * t - 1.0)
    return 0.5 * root / (t * (t + 1.0)), a / ((t + 1.0) * root)


def shakedown_pressure(a: Array, b: Array, shear_yield: Array, friction: Array = 0.0) -> Array:
    r"""Largest peak pressure under which repeated rolling remains elastic.

    .. math:: p_0 = \min\left(\frac{k}{\tau_0/p_0}, \frac{k}{\mu}\right)

    Parameters
    ----------
    a, b : (...,) float          Semi-axes along and across the rolling direction. [m]
    shear_yield : (...,) float   k, yield stress in shear: half the yield strength by Tresca. [Pa]
    friction : (...,) float      mu, largest traction over pressure, >= 0: in full slip the surface itself yields at k. [-]

    Returns
    -------
    (...,) float   4.00 k for a line contact without friction, 4.7 k for a circle; nan for a patch more than twice as long as
        wide, in which other stresses may have the lower limit. [Pa]

    Raises
    ------
    ParameterError
        If a semi-axis or the yield stress is not above zero, or the friction below zero.

    Notes
    -----
    Traction also lowers the first of the two limits; this is neglected. Hardening raises both.

    Source: johnson1985, section 9.2 (line contact, surface limit); ponter1985 (4.7 k for a circle).
    """
    check_value("shear_yield", shear_yield, "Pa", Gt(0))
    check_value("friction", friction, "1", Ge(0))
    shear, _ = orthogonal_shear(a, b)
    xp = namespace(shear, shear_yield, friction)
    a, b, friction = as_floats(xp, a, b, friction)
    limit = shear_yield / xp.where(friction > shear, friction, shear)
    return xp.where(a <= LONGEST * b, limit, xp.nan)
