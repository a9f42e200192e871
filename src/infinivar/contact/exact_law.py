r"""Creep law "exact": lateral creep of any elliptical patch, fitted to the exact solutions of `infinivar.contact.exact`.

With the force ratio x, the scaled creepage :math:`\xi` and the creepage :math:`\xi_c` of full slip,

.. math:: \frac{\xi}{\xi_c} = s \left[1 + (1-s) \left(q - c_0 s - c_1 s^2 - c_2 s^3\right)\right], \qquad
    s = 1 - (1-x)^{2/5}, \qquad q = \frac{5}{2 \xi_c} - 1.

The value of q makes the law start with the linear one. Near full slip 1 - x falls as :math:`(\xi_c - \xi)^{5/2}`, because the
area that still sticks shrinks to a point of the leading edge. The creepage of full slip is an integral
(`kalker.full_slip_creepage`), and the three c are polynomials in Poisson's ratio and the logarithm of a/b.
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

from annotated_types import Gt

from infinivar._core import files
from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.arrays import remembered
from infinivar._core.fields import check_value
from infinivar.contact import kalker
from infinivar.contact.laws import RESOLUTION, rest_of, signed, size_of

NARROWEST, WIDEST = 0.05, 20.0
"""Range of a/b that the coefficients are fitted to; beyond it the law is that of the nearest."""

STEEL_CIRCLE = (1.0, 0.3)
"""a/b and Poisson's ratio assumed for a patch of unknown geometry."""

STEEL_CIRCLE_SLIP = 2.586380751183667
"""`Curve.full_slip` of that patch: 9/4 C22 (1 - nu/4)."""

_FLAT = 2.0**-32
"""Derivative of the force from full slip on, so that an iteration that overshoots comes back."""

_TERMS = 8
"""Terms of the polynomial from which the inverse starts: it errs by 3e-4 at most, 4e-7 on a circle. One step follows."""


class Curve(NamedTuple):
    """The law on one patch; arrays of one shape."""

    full_slip: Array
    """Scaled creepage at which the whole patch slips. [-]"""
    growth: tuple[Array, ...]
    """Creepage over that of full slip: coefficients of s, s^2, ... [-]"""
    start: tuple[Array, ...]
    """Approximate inverse: coefficients of the first, second, ... power of that creepage, for s. [-]"""


def exact_creepage(force_ratio: Array, curve: Curve | None = None) -> Array:
    """Scaled creepage under a lateral force.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; beyond +-1 the creepage stays at that of full slip. [-]
    curve : Curve                From `curve`; by default of a circular patch with Poisson's ratio 0.3.

    Returns
    -------
    (...,) float   Scaled creepage. [-]

    Source: kalker1990, the theory; the formula is this program's own, fitted by `tools/fit_lateral_law.py`.
    """
    curve = curve or steel_circle()
    xp = namespace(force_ratio, curve.full_slip)
    size = size_of(xp, force_ratio)
    slips = size >= 1.0
    s = -xp.expm1(0.4 * xp.log1p(-xp.where(slips, 0.0, size)))
    share = xp.where(slips, 1.0, s * _polynomial(curve.growth, s))
    return signed(xp, force_ratio, curve.full_slip * share)


def exact_slope(force_ratio: Array, curve: Curve | None = None) -> Array:
    """Derivative of `exact_creepage`.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; at +-1 the slope is capped at about 4e9, beyond it is 0. [-]
    curve : Curve                As in `exact_creepage`.

    Returns
    -------
    (...,) float   [-]

    Source: derivative of `exact_creepage`.
    """
    curve = curve or steel_circle()
    xp = namespace(force_ratio, curve.full_slip)
    size = size_of(xp, force_ratio)
    rest = rest_of(xp, size)
    steep = rest**-0.6
    rise = _polynomial(_differentiated(curve.growth), 1.0 - rest * steep)
    return xp.where(size > 1.0, 0.0, 0.4 * curve.full_slip * steep * rise)


def exact_force(creepage: Array, curve: Curve | None = None) -> Array:
    """Force ratio under a lateral creepage: the inverse of `exact_creepage`, to 1e-12.

    Parameters
    ----------
    creepage : (...,) float   Scaled creepage, may be infinite. [-]
    curve : Curve             As in `exact_creepage`.

    Returns
    -------
    (...,) float   Force ratio in [-1, 1]. [-]

    Notes
    -----
    Saturates at full slip. For a Poisson's ratio above 0 the last of the patch slips at a larger creepage: the exact force
    is then below mu N by up to 0.1 % (ratio 0.3) and 0.3 % (ratio 0.5).

    Source: as `exact_creepage`.
    """
    curve = curve or steel_circle()
    xp, slips, s, _ = _under(creepage, curve)
    force = -xp.expm1(2.5 * xp.log1p(-xp.clip(s, -1.0, 1.0 - 8.0 * RESOLUTION)))
    return signed(xp, creepage, xp.where(slips, 1.0, force))


def exact_response(creepage: Array, curve: Curve | None = None) -> tuple[Array, Array]:
    """Force ratio under a lateral creepage and its derivative, both from one place on the curve.

    Parameters
    ----------
    creepage, curve : as in `exact_force`.

    Returns
    -------
    force_ratio, derivative : (...,) float   The ratio to rounding of 1, so that small ones have fewer digits than those of
        `exact_force`; the derivative to 1e-6 of itself, capped below as `exact_slope` is above. [-]

    Source: as `exact_creepage`.
    """
    curve = curve or steel_circle()
    xp, slips, s, rise = _under(creepage, curve)
    rest = 1.0 - xp.clip(s, -1.0, 1.0 - 8.0 * RESOLUTION)
    steep = rest * xp.sqrt(rest)
    force = xp.where(slips, 1.0, 1.0 - rest * steep)
    return signed(xp, creepage, force), xp.where(slips, _FLAT, 2.5 / curve.full_slip * steep / rise)


def _under(creepage: Array, curve: Curve) -> tuple[Any, Array, Array, Array]:
    """Array namespace of a creepage, whether the whole patch slips under it, s, and the derivative of `_place`."""
    xp = namespace(creepage, curve.full_slip)
    size = size_of(xp, creepage)
    slips = size >= curve.full_slip
    return xp, slips, *_place(curve, xp.where(slips, 0.0, size) / curve.full_slip)


def _place(curve: Curve, share: Array) -> tuple[Array, Array]:
    """s at a creepage relative to that of full slip, and that creepage's derivative by s.

    One step of third order from the approximate inverse. The derivative, from that at the step's start, errs by 1e-6 at most.
    """
    s = share * _polynomial(curve.start, share)
    first = _differentiated(curve.growth)
    rise, bend = _polynomial(first, s), _polynomial(_differentiated(first[1:]), s)
    excess = s * _polynomial(curve.growth, s) - share
    change = excess * rise / (rise * rise - 0.5 * excess * bend)
    return s - change, rise - bend * change


def curve(a_over_b: Array, poisson: Array) -> Curve:
    """The law's coefficients on a patch.

    Parameters
    ----------
    a_over_b : (...,) float   Rolling over lateral semi-axis, > 0; below 0.05 and above 20 that of the end. [-]
    poisson : (...,) float    Combined Poisson's ratio, 0 to 0.5. [-]

    Returns
    -------
    Curve   of (...,) float; inputs broadcast.

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: `tools/fit_lateral_law.py`, `data/lateral_law.toml`.
    """
    if type(a_over_b) is float and type(poisson) is float:
        return _curve_of_numbers(a_over_b, poisson)
    if isinstance(a_over_b, (list, tuple)):
        (a_over_b,) = as_floats(namespace(), a_over_b)
    return _curve(a_over_b, poisson)


@functools.lru_cache(maxsize=64)
def _curve_of_numbers(a_over_b: float, poisson: float) -> Curve:
    found = _curve(a_over_b, poisson)
    return Curve(float(found.full_slip), *(tuple(map(float, part)) for part in found[1:]))


def steel_circle() -> Curve:
    """The law on a circular patch with Poisson's ratio 0.3."""
    return _curve_of_numbers(*STEEL_CIRCLE)


@remembered
def _curve(a_over_b: Array, poisson: Array) -> Curve:
    xp = namespace(a_over_b, poisson)
    check_value("a_over_b", a_over_b, "1", Gt(0))
    ratio, nu = xp.broadcast_arrays(*as_floats(xp, a_over_b, poisson))
    ratio = xp.clip(ratio, NARROWEST, WIDEST)
    full_slip = kalker.full_slip_creepage(ratio, nu, kalker.coefficients(ratio, nu).c22)
    place = xp.log(ratio) / math.log(WIDEST)
    bends = [_polynomial([_polynomial(row, place) for row in rows], nu) for rows in coefficients()]
    growth = growth_of(full_slip, bends)
    # s at the nodes of Chebyshev, and from it the polynomial through them.
    nodes, inverse = _nodes()
    shares = xp.asarray(nodes, dtype=xp.float64)
    at_nodes = tuple(part[..., None] for part in growth)
    s = xp.broadcast_to(shares, (*ratio.shape, _TERMS))
    for _ in range(8):
        s = s - (s * _polynomial(at_nodes, s) - shares) / _polynomial(_differentiated(at_nodes), s)
    start = xp.matmul(s / shares, xp.asarray(inverse, dtype=xp.float64))
    return Curve(full_slip, growth, tuple(start[..., i] for i in range(_TERMS)))


def growth_of(full_slip: Array, bends: Any) -> tuple[Array, ...]:
    """`Curve.growth` from the creepage of full slip and c0, c1, c2."""
    q = 2.5 / full_slip - 1.0
    c0, c1, c2 = bends
    return (1.0 + q, -c0 - q, c0 - c1, c1 - c2, c2)


@functools.cache
def coefficients() -> tuple[tuple[tuple[float, ...], ...], ...]:
    """c0, c1, c2: rows for powers of Poisson's ratio, columns for powers of ln(a/b)/ln 20."""
    found = data()["coefficients"]
    return tuple(tuple(map(tuple, found[name])) for name in ("c0", "c1", "c2"))


@functools.cache
def data() -> dict[str, Any]:
    """The fitted coefficients, their errors and the settings they were computed with."""
    return files.shipped("contact", "lateral_law")


@functools.cache
def _nodes() -> tuple[Any, Any]:
    """Nodes of Chebyshev in (0, 1), and the matrix from values there to coefficients of a polynomial."""
    import numpy as np

    nodes = 0.5 - 0.5 * np.cos((np.arange(_TERMS) + 0.5) * np.pi / _TERMS)
    return nodes, np.linalg.inv(np.vander(nodes, increasing=True)).T


def _polynomial(coefficients: Any, at: Array) -> Array:
    """Sum of coefficients times powers of `at`, from power 0."""
    *rest, total = coefficients
    for coefficient in reversed(rest):
        total = coefficient + at * total
    return total


def _differentiated(coefficients: Any) -> tuple[Array, ...]:
    """Derivative of a sum of coefficients times powers, from power 1; as coefficients from power 0."""
    return tuple(i * coefficient for i, coefficient in enumerate(coefficients, 1))
