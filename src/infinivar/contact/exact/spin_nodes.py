"""Nodes of the map of lateral creep with spin: how its table is laid out.

With the lateral creepage upsilon and the spin phi, scaled as for `RollingPatch`, and the lever h of the patch, the table is
polar in

    x = C22 upsilon,    y = C22 h phi,    rho = hypot(x, y),    u = rho/(rho + 2),    alpha = atan2(y, x).

It holds ``[f/u - (1 - u) f_linear(alpha)]`` for the lateral force and for the moment over h, which vanishes with u and ends at
the forces of full slip. C22, C23 and C33 in it are those of `infinivar.contact.kalker`, so that the linear theory is exact in
them. Half a turn of alpha changes the sign of both forces.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.contact import kalker, spin

A_OVER_B = tuple(float(np.round(0.05 * 400.0 ** (i / 12), 12)) for i in range(13))
"""Semi-axis along the rolling direction over the lateral one, equally spaced in its logarithm. [-]"""

POISSON = (0.0, 0.25, 0.5)

SIZES = 28
"""Intervals of u from 0 to 1. The table has no row for u = 0, where it vanishes."""

ANGLES = 32
"""Intervals of alpha in half a turn."""

HALF = 2.0
"""rho at which u is one half."""

_SPOT = 3.0 * math.pi / 16.0
"""Moment that turns a patch on the spot, over mu N h."""


class Scales(NamedTuple):
    """What makes the creepages of a patch of given shape and material comparable."""

    lever: Array
    """h, the mean radius of the patch's edge over c: moment of turning on the spot over (3 pi/16) mu N c. [-]"""
    c22: Array
    by_spin: Array
    """C23/(C22 h): lateral force by y, and minus the moment over h by x, in the linear theory. [-]"""
    turning: Array
    """C33/(C22 h^2): moment over h by y in the linear theory. [-]"""


def scales(a_over_b: Array, poisson: Array) -> Scales:
    """Scales of a patch with semi-axes whose product is 1; arguments as in `infinivar.contact.kalker.coefficients`."""
    linear = kalker.coefficients(a_over_b, poisson)
    root = a_over_b**0.5
    lever = spin.ellipse_moment(1.0, root, 1.0 / root, 1.0) / _SPOT
    by_spin = linear.c23 / (linear.c22 * lever)
    return Scales(lever, linear.c22, by_spin, linear.c33 / (linear.c22 * lever * lever))


def linear_part(scale: Scales, x: Array, y: Array) -> tuple[Array, Array]:
    """Lateral force and moment over h in the linear theory, over mu N."""
    return x + scale.by_spin * y, scale.turning * y - scale.by_spin * x
