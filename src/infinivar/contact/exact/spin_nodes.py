"""Nodes of the map of lateral creep with spin: how its table is laid out, and what the solver finds there.

With the lateral creepage upsilon and the spin phi, scaled as for `RollingPatch`, and the lever h of the patch, the table is
polar in

    x = C22 upsilon,    y = C22 h phi,    rho = hypot(x, y),    u = rho/(rho + 2),    alpha = atan2(y, x).

It holds ``[f/u - (1 - u) f_linear(alpha)]`` for the lateral force and for the moment over h, which vanishes with u and ends at
the forces of full slip. C22, C23 and C33 in it are those of `infinivar.contact.kalker`, so that the linear theory is exact in
them. Half a turn of alpha changes the sign of both forces.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.contact import kalker, spin
from infinivar.contact.exact.grid import Floats
from infinivar.contact.exact.patch import RollingPatch

A_OVER_B = tuple(float(np.round(0.05 * 400.0 ** (i / 12), 12)) for i in range(13))
"""Semi-axis along the rolling direction over the lateral one, equally spaced in its logarithm. [-]"""

POISSON = (0.0, 0.25, 0.5)

SIZES = 28
"""Intervals of u from 0 to 1. The table has no row for u = 0, where it vanishes."""

ANGLES = 32
"""Intervals of alpha in half a turn."""

HALF = 2.0
"""rho at which u is one half."""

COARSE = 10
FINE = (20, 18)
"""Cells along each side of the two grids from which forces are extrapolated. The second fine one is for states that the
first does not find: some of nearly incompressible material at a/b = 20."""

ORDER = 1.5
"""Order of convergence of the forces with the size of the cells."""

SLENDER = 8.0
"""a/b beyond which spin may take so little power that errors between the nodes would make it negative."""

_RESISTANCE = 0.14
"""What is added there against spin, at a/b = 20, times nu^2 u (1 - u); it changes the moment by 0.005 mu N h at most."""

_SPOT = 3.0 * math.pi / 16.0
"""Moment that turns a patch on the spot, over mu N h."""

_RINGS, _RAYS = 400, 800
"""Steps of the integral of full slip, whose integrand turns about a point."""


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


def solved(a_over_b: float, poisson: float, lateral: float, spin: float) -> Floats:
    """Lateral force over mu N and moment over mu N c by the solver, extrapolated from two grids: (2,).

    nan if an iteration has not converged.
    """
    coarse = _found(a_over_b, poisson, lateral, spin, COARSE)
    cells = FINE[0]
    fine = _found(a_over_b, poisson, lateral, spin, cells)
    if not np.isfinite(fine).all():
        cells = FINE[1]
        fine = _found(a_over_b, poisson, lateral, spin, cells)
    return fine + (fine - coarse) / ((cells / COARSE) ** ORDER - 1.0)


def _found(a_over_b: float, poisson: float, lateral: float, spin: float, cells: int) -> Floats:
    """Lateral force and moment on one grid."""
    patch = RollingPatch(a_over_b=a_over_b, poisson=poisson, cells=cells)
    return patch.steady(0.0, lateral, spin).forces[1:]


@functools.lru_cache(maxsize=2)
def _patch(a_over_b: float) -> tuple[Floats, Floats, Floats]:
    """Places x, y of a patch and their parts of the load."""
    ring = (np.arange(_RINGS) + 0.5) / _RINGS
    ray = (np.arange(_RAYS) + 0.5) * (2.0 * math.pi / _RAYS)
    part = np.sqrt(1.0 - ring**2) * ring
    part = np.repeat(part / part.sum() / _RAYS, _RAYS)
    root = math.sqrt(a_over_b)
    return root * np.outer(ring, np.cos(ray)).ravel(), np.outer(ring, np.sin(ray)).ravel() / root, part


def full_slip(a_over_b: float, lever: float, alpha: float) -> Floats:
    r"""Lateral force over mu N and moment over mu N h of a patch that slips as a rigid body: (2,).

    .. math:: f_y = \int p\,\frac{s_y}{|s|}\,dA, \qquad m = \int p\,\frac{x s_y - y s_x}{|s|}\,dA, \qquad
        s = (-\phi y,\ \upsilon + \phi x)

    Source: Coulomb's law under the Hertz pressure p.
    """
    x, y, part = _patch(a_over_b)
    turn = math.sin(alpha) / lever
    slip_x, slip_y = -turn * y, math.cos(alpha) + turn * x
    part = part / np.hypot(slip_x, slip_y)
    return np.array([np.sum(part * slip_y), np.sum(part * (x * slip_y - y * slip_x)) / lever])


def table(a_over_b: float, poisson: float) -> Floats:
    """The map's table for one patch: (SIZES, ANGLES, 2)."""
    scale = Scales(*map(float, scales(a_over_b, poisson)))
    values = np.empty((SIZES, ANGLES, 2))
    for i, j in np.ndindex(SIZES, ANGLES):
        u, alpha = (i + 1) / SIZES, j * math.pi / ANGLES
        cosine, sine = math.cos(alpha), math.sin(alpha)
        if i == SIZES - 1:
            values[i, j] = full_slip(a_over_b, scale.lever, alpha)
            continue
        rho = HALF * u / (1.0 - u)
        force, moment = solved(a_over_b, poisson, rho * cosine / scale.c22, rho * sine / (scale.c22 * scale.lever))
        linear = HALF * (1.0 - u) * np.array(linear_part(scale, cosine, sine))
        extra = resistance(a_over_b, poisson) * u * (1.0 - u) * sine
        values[i, j] = np.array([force, moment / scale.lever + u * extra]) / u - linear
    return values


def resistance(a_over_b: float, poisson: float) -> float:
    """Addition to the moment that keeps the interpolated friction of slender patches dissipative. [-]"""
    slender = max(math.log(a_over_b / SLENDER) / math.log(A_OVER_B[-1] / SLENDER), 0.0)
    return _RESISTANCE * poisson**2 * slender
