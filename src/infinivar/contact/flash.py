r"""Flash temperature: how much hotter the sliding patch is than the bodies, whose surfaces pass through it.

Heat is taken as distributed like the Hertz pressure, as in gross slip. Both surfaces of a rolling contact pass through the
patch at the rolling speed V, so that for each body the patch is a heat source that moves at V over a half-space.
"""

from __future__ import annotations

import math

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.fields import check_value
from infinivar.contact.elliptic import ellipse_integrals

FAST = 2.1883066737913
r"""Largest value of :math:`\int_{-1}^{\xi} \sqrt{1-t^2}/\sqrt{\xi-t}\,dt`, at 0.652 semi-axes behind the centre."""


def resistance(a: Array, b: Array, speed: Array, conductivity: Array, heat_capacity: Array) -> Array:
    r"""Largest temperature rise of one body's surface over the heat that flows into this body.

    .. math:: R_0 = \frac{3F}{8\pi k b}, \qquad R_\infty = \frac{3 J}{2\pi b\sqrt{\pi k c V a}}, \qquad
        \frac{1}{R^2} = \frac{1}{R_0^2} + \frac{1}{R_\infty^2}

    with the integral F of the ellipse (pi for a circle of b = 1) and J = 2.188. The first is the resistance of a source at
    rest, the second that of a fast one, from which heat flows straight into the depth.

    Parameters
    ----------
    a, b : (...,) float            Semi-axes along and across the motion, > 0. [m]
    speed : (...,) float           V, at which the surface passes through the patch; its sign does not matter. [m s^-1]
    conductivity : (...,) float    k, > 0. [W m^-1 K^-1]
    heat_capacity : (...,) float   c, heat capacity per volume, > 0. [J m^-3 K^-1]

    Returns
    -------
    (...,) float   Inputs broadcast. [K W^-1]

    Raises
    ------
    ParameterError
        If an argument is not above zero.

    Notes
    -----
    Both limits are exact. Between them the root of squares differs from the integral of moving point sources by up to 6 %
    for a/b from 0.25 to 1, 8 % up to 2 and 19 % up to 4.

    Source: jaeger1942 (moving sources); tian1994 (the root of squares between the limits).
    """
    for name, value, unit in (
        ("a", a, "m"),
        ("b", b, "m"),
        ("conductivity", conductivity, "W/m/K"),
        ("heat_capacity", heat_capacity, "J/m^3/K"),
    ):
        check_value(name, value, unit, Gt(0))
    xp = namespace(a, b, speed, conductivity, heat_capacity)
    a, b, speed, k, c = as_floats(xp, a, b, speed, conductivity, heat_capacity)
    at_rest = 0.375 / math.pi * ellipse_integrals(a / b).plain / (k * b)
    fast_square = math.pi * k * c * xp.abs(speed) * a * (2.0 * math.pi / 3.0 * b / FAST) ** 2
    return 1.0 / xp.sqrt(1.0 / (at_rest * at_rest) + fast_square)


def temperature_rise(power: Array, first: Array, second: Array) -> Array:
    r"""Largest temperature rise of the patch above both bodies, which are equally warm outside it.

    .. math:: \Delta T = \frac{Q}{1/R_1 + 1/R_2}

    Parameters
    ----------
    power : (...,) float           Frictional power Q in the patch, >= 0. [W]
    first, second : (...,) float   `resistance` of each body, > 0. The share 1/R of the heat flows into each. [K W^-1]

    Returns
    -------
    (...,) float   [K]

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: blok1937 (equal largest temperatures of both surfaces).
    """
    check_value("power", power, "W", Ge(0))
    check_value("first", first, "K/W", Gt(0))
    check_value("second", second, "K/W", Gt(0))
    return power / (1.0 / first + 1.0 / second)
