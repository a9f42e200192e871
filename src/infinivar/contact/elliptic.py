r"""Elliptic integrals of a point contact, over any array namespace.

With ``Delta(w) = sqrt(w (g^2 + w)(1 + w))`` and the semi-axes ``a = g b``, ``b = 1``, all properties of a Hertzian ellipse
follow from four integrals from 0 to infinity: of ``1/Delta``, ``1/((g^2 + w) Delta)``, ``1/((1 + w) Delta)`` and
``1/((g^2 + w)(1 + w) Delta)``. They are analytic in g, including the circle ``g = 1``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from infinivar._core.array_namespace import Array, namespace

_MEANS = 9
"""Steps of the arithmetic-geometric mean. Each doubles the digits; 9 suffice for axis ratios from 1e-12 to 1e12."""

_DUPLICATIONS = 8
"""Duplication steps. Each reduces the spread of the arguments by 4, a large one to its root; 8 leave 1e-15 up to 1e18."""

_NEAR_CIRCLE = 2e-4
"""Bound on |1 - g^2|; nearer to the circle a difference quotient loses more digits than its Taylor series."""


class EllipseIntegrals(NamedTuple):
    """The four integrals over w from 0 to infinity."""

    plain: Array
    """Of 1/Delta."""
    along_a: Array
    """Of 1/((g^2 + w) Delta)."""
    along_b: Array
    """Of 1/((1 + w) Delta)."""
    mixed: Array
    """Of 1/((g^2 + w)(1 + w) Delta)."""


def ellipse_integrals(axis_ratio: Array) -> EllipseIntegrals:
    """The four integrals of an ellipse with semi-axes g and 1.

    Parameters
    ----------
    axis_ratio : (...,) float   g, > 0; relative error 1e-13 from 1e-12 to 1e12, 1e-11 for `mixed`. [-]

    Returns
    -------
    EllipseIntegrals   of (...,) float. [-]

    Source: johnson1985, section 4.2(b); the arithmetic-geometric mean is Gauss's.
    """
    xp = namespace(axis_ratio)
    g = axis_ratio
    # K and D = (K - E)/k^2 with k^2 = 1 - g^2, from sums with terms of one sign, so nothing cancels at the circle.
    mean, other = 0.5 * (1.0 + g), xp.sqrt(g)
    share = 0.25 * (1.0 - g) / (1.0 + g)
    square = 0.25 * (1.0 - g) ** 2
    total, weight = share, 1.0
    for _ in range(_MEANS):
        following = 0.5 * (mean + other)
        factor = square / (16.0 * following * following)
        mean, other = following, xp.sqrt(mean * other)
        share, square, weight = share * factor, square * factor, 2.0 * weight
        total = total + weight * share
    k = 0.5 * math.pi / mean
    along_b = 2.0 * k * (0.5 + total)
    along_a = 2.0 * k * (0.5 - total) / (g * g)
    distance = 1.0 - g * g
    near = xp.abs(distance) < _NEAR_CIRCLE
    series = math.pi * (3 / 8 + distance * (15 / 32 + distance * (525 / 1024)))
    mixed = xp.where(near, series, (along_a - along_b) / xp.where(near, 1.0, distance))
    return EllipseIntegrals(2.0 * k, along_a, along_b, mixed)


def carlson_rd(x: Array, y: Array, z: Array) -> Array:
    r"""Carlson's symmetric integral of the second kind, by duplication.

    .. math:: R_D(x, y, z) = \tfrac{3}{2} \int_0^\infty \frac{dw}{(z+w)\sqrt{(x+w)(y+w)(z+w)}}

    Parameters
    ----------
    x, y : (...,) float   >= 0, at most one of them 0.
    z : (...,) float      > 0.

    Returns
    -------
    (...,) float   Relative error below 1e-12.

    Source: carlson1995, section 2.
    """
    xp = namespace(x, y, z)
    total, weight = 0.0, 1.0
    for _ in range(_DUPLICATIONS):
        root_x, root_y, root_z = xp.sqrt(x), xp.sqrt(y), xp.sqrt(z)
        shift = root_x * root_y + root_y * root_z + root_z * root_x
        total = total + weight / (root_z * (z + shift))
        x, y, z, weight = 0.25 * (x + shift), 0.25 * (y + shift), 0.25 * (z + shift), 0.25 * weight
    # The three arguments are now nearly equal: expand about their mean to fifth order.
    mean = 0.2 * (x + y + 3.0 * z)
    dx, dy = 1.0 - x / mean, 1.0 - y / mean
    dz = -(dx + dy) / 3.0
    both, square = dx * dy, dz * dz
    second, third = both - 6.0 * square, (3.0 * both - 8.0 * square) * dz
    fourth, fifth = 3.0 * (both - square) * square, both * square * dz
    series = 1.0 + second * (9.0 / 88.0 * second - 9.0 / 52.0 * third - 3.0 / 14.0) + third / 6.0
    series = series - 3.0 / 22.0 * fourth + 3.0 / 26.0 * fifth
    return 3.0 * total + weight * series / (mean * xp.sqrt(mean))
