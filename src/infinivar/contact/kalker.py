r"""Kalker's coefficients: forces and moment of an elliptical rolling contact at small creepage.

For creepages with negligible slip, and semi-axes a along the rolling direction x and b along y::

    Fx = -C11 G a b upsilon_x
    Fy = -C22 G a b upsilon_y - C23 G (a b)^(3/2) spin
    Mz =  C23 G (a b)^(3/2) upsilon_y - C33 G (a b)^2 spin
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

from annotated_types import Gt, Interval

from infinivar._core import files
from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.arrays import remembered
from infinivar._core.fields import check_value

_END = math.log(10.0)
"""|ln(a/b)| where the table ends."""

_STIFFNESS = 1e3
"""Stiffness of the splines relative to the table's rounding of half a digit: every node still rounds to its printed value."""

_AROUND = 256
"""Number of directions in the mean of a periodic function."""


class KalkerCoefficients(NamedTuple):
    """Coefficients of the linear theory; arrays of one shape. [-]"""

    c11: Array
    """Longitudinal force by longitudinal creepage."""
    c22: Array
    """Lateral force by lateral creepage."""
    c23: Array
    """Lateral force by spin, and moment by lateral creepage."""
    c33: Array
    """Moment by spin."""


@remembered
def coefficients(a_over_b: Array, poisson: Array) -> KalkerCoefficients:
    r"""Coefficients of the linear theory for any ellipse and any isotropic material.

    In ``s = ln(a/b)`` the interpolation is a natural cubic spline of the tabulated logarithms, the smoothest within their
    rounding. In Poisson's ratio it is a parabola through the three tabulated values of 1/C11, 1/C22, 1/C23 and
    (1 - nu)^q C33, where q goes from 1 for a << b to 0 for a >> b. Outside a/b = 0.1 to 10 the logarithms are

    .. math:: \ln C = \ln A(s) + e^{-t^2} \left[\ln T(s') - \ln A(s')\right], \quad t = |s| - \ln 10, \quad
        |s'| = \ln 10 + \tfrac12\left(1 - e^{-2t}\right)

    with the table T, extrapolated with its slope at the end, and the asymptote A. Values and first derivatives are
    continuous everywhere.

    Parameters
    ----------
    a_over_b : (...,) float   Semi-axis along the rolling direction over the lateral one, > 0. [-]
    poisson : (...,) float    Poisson's ratio of both bodies, or `combined`, 0 to 0.5. [-]

    Returns
    -------
    KalkerCoefficients   of (...,) float, all positive; inputs broadcast. [-]

    Raises
    ------
    ParameterError
        If an argument is out of range. For traced arrays the result is nan there instead.

    Notes
    -----
    C11, C22 and C23 round to the printed digits at the nodes of the table; C33, which the table lacks, is computed. An
    element solution, accurate to 0.1 %, differs at and between the nodes by up to 0.6 % for a/b from 0.1 to 3 (C23 by 1 %
    at 0.1 and Poisson's ratio 0.5) and by up to 1.3 % from 3 to 10; C33 differs by up to 0.4 % below a/b = 4 and 1.2 % from
    4 to 10. Outside the table, the asymptotes neglect terms of order a/b for ellipses across the rolling direction, but of
    order 1/ln(a/b) along it: at a/b = 30, C11 and C22 are 3 % low, and C33 is up to 18 % high.

    Source: kalker1990, Table E.3 and its asymptotes; C33 as described in `data/kalker.toml`.
    """
    check_value("a_over_b", a_over_b, "1", Gt(0))
    check_value("poisson", poisson, "1", Interval(ge=0, le=0.5))
    xp = namespace(a_over_b, poisson)
    ratio, nu = xp.broadcast_arrays(*as_floats(xp, a_over_b, poisson))
    valid = (ratio > 0) & (nu >= 0) & (nu <= 0.5)
    s, nu = xp.log(xp.where(valid, ratio, 1.0)), xp.where(valid, nu, 0.25)

    inside = xp.clip(s, -_END, _END)
    beyond = xp.abs(s) - xp.abs(inside)
    # The table's excess over the asymptote falls about as fast as g: half an e-fold on, its last slope halves it.
    near = inside + xp.sign(s) * 0.5 * (1.0 - xp.exp(-2.0 * beyond))
    fade = xp.exp(-beyond * beyond)
    values = (
        xp.where(valid, xp.exp(far + fade * (tabulated - at_near)), xp.nan)
        for far, tabulated, at_near in zip(
            _log_asymptotes(xp, s, nu), _log_table(xp, near, nu), _log_asymptotes(xp, near, nu), strict=True
        )
    )
    return KalkerCoefficients(*values)


def full_slip_creepage(a_over_b: Array, poisson: Array, c22: Array) -> Array:
    r"""Lateral creepage of full slip, relative to the creepage at which the linear law slips.

    Under the traction of gross slip, a semi-ellipsoid over the patch, the elastic displacement changes fastest along the
    rolling direction at the leading edge, by ``eta = D a``. At a larger creepage no point can stick:

    .. math:: \xi = \frac{3 C_{22}}{2\pi} \int_0^\pi \left[(1-\nu)\frac{\sin^2\psi}{q} + \nu\frac{\sin^4\psi}{q^3}\right] d\psi,
        \qquad q = \sqrt{(a/b)^2 \cos^2\psi + \sin^2\psi}

    Parameters
    ----------
    a_over_b : (...,) float   Rolling over lateral semi-axis, 0.02 to 50; there the sum is accurate to 1e-5. [-]
    poisson : (...,) float    Combined Poisson's ratio. [-]
    c22 : (...,) float        Kalker's coefficient for both. [-]

    Returns
    -------
    (...,) float   C22 G a b upsilon/(mu N), 2.3 to 2.8; 3 in the theory of Vermeulen and Johnson. [-]

    Notes
    -----
    Exact for a Poisson's ratio of 0. For larger ratios, tractions across the creep direction delay full slip: at this
    creepage the force is below mu N by up to 0.1 % (ratio 0.3) and 0.3 % (ratio 0.5).

    Source: johnson1985, section 3.2 (displacement under an ellipsoidal traction); kalker1990, condition of gross slip.
    """
    xp = namespace(a_over_b, poisson, c22)
    ratio, nu, c22 = as_floats(xp, a_over_b, poisson, c22)
    angle = (xp.arange(_AROUND, dtype=xp.float64) + 0.5) * (math.pi / _AROUND)
    square = xp.sin(angle) ** 2
    q = xp.sqrt(ratio[..., None] ** 2 * (1.0 - square) + square)
    first, second = xp.mean(square / q, axis=-1), xp.mean((square / q) ** 2 / q, axis=-1)
    return 1.5 * c22 * ((1.0 - nu) * first + nu * second)


def combined(shear_modulus_1: Array, poisson_1: Array, shear_modulus_2: Array, poisson_2: Array) -> tuple[Array, Array]:
    r"""Combined shear modulus and Poisson's ratio of two bodies of different materials.

    .. math:: \frac{1}{G} = \frac{1}{2}\left(\frac{1}{G_1} + \frac{1}{G_2}\right), \qquad
        \frac{\nu}{G} = \frac{1}{2}\left(\frac{\nu_1}{G_1} + \frac{\nu_2}{G_2}\right)

    Parameters
    ----------
    shear_modulus_1, shear_modulus_2 : (...,) float   > 0. [Pa]
    poisson_1, poisson_2 : (...,) float               0 to 0.5. [-]

    Returns
    -------
    shear_modulus, poisson : (...,) float   [Pa], [-]; inputs broadcast.

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Notes
    -----
    Under tangential traction the two bodies displace like two bodies of this one material. This neglects the coupling of
    bodies that differ in ``(1 - 2 nu)/G``: there, pressure alone displaces the surfaces tangentially, and tractions change
    the pressure. faulring2006 prints a quarter of this shear modulus.

    Source: kalker1990, the combined elastic constants.
    """
    check_value("shear_modulus_1", shear_modulus_1, "Pa", Gt(0))
    check_value("shear_modulus_2", shear_modulus_2, "Pa", Gt(0))
    check_value("poisson_1", poisson_1, "1", Interval(ge=0, le=0.5))
    check_value("poisson_2", poisson_2, "1", Interval(ge=0, le=0.5))
    xp = namespace(shear_modulus_1, poisson_1, shear_modulus_2, poisson_2)
    g1, nu1, g2, nu2 = xp.broadcast_arrays(*as_floats(xp, shear_modulus_1, poisson_1, shear_modulus_2, poisson_2))
    # The softer body has the larger weight. Written as a step from nu2, so that rounding keeps equal ratios equal.
    share = 1.0 / (1.0 + g1 / g2)
    return 2.0 * g1 * share, nu2 + (nu1 - nu2) * share


def poisson_weights(poisson: Array) -> tuple[Array, Array, Array]:
    """Weights of values tabulated at Poisson's ratios 0, 1/4 and 1/2 in the parabola through them.

    Parameters
    ----------
    poisson : (...,) float   Poisson's ratio; outside the table the parabola goes on. [-]

    Returns
    -------
    tuple of three (...,) float   Their sum is 1. [-]

    Source: Lagrange's interpolation.
    """
    nu = poisson
    return (4.0 * nu - 1.0) * (2.0 * nu - 1.0), 8.0 * nu * (1.0 - 2.0 * nu), 2.0 * nu * (4.0 * nu - 1.0)


def _log_asymptotes(xp: Any, s: Array, nu: Array) -> tuple[Array, ...]:
    """ln of C11, C22, C23, C33 for slender ellipses: across the rolling direction for s < 0, along it for s > 0.

    Within the table's range, the values at its ends.
    """
    size = xp.maximum(xp.abs(s), xp.asarray(_END, dtype=xp.float64))  # -ln g
    log = math.log(16.0) + 2.0 * size  # Lambda = ln(16/g^2)
    rest, edge = 1.0 - nu, 3.0 - math.log(4.0)

    across = (
        math.log(math.pi**2 / 4.0) - xp.log(rest),
        math.log(math.pi**2 / 4.0) + 0.0 * size,
        math.log(math.pi / 3.0) - 0.5 * size - xp.log(rest) + xp.log(1.0 + nu * (0.5 * log + math.log(4.0) - 5.0)),
        math.log(math.pi**2 / 16.0) + size - xp.log(rest),
    )
    longitudinal, lateral, turning = log - 2.0 * nu, rest * log + 2.0 * nu, rest * log - 2.0 + 4.0 * nu
    along = (
        math.log(2.0 * math.pi) + size + xp.log((1.0 + edge / longitudinal) / longitudinal),
        math.log(2.0 * math.pi) + size + xp.log((1.0 + rest * edge / lateral) / lateral),
        math.log(2.0 * math.pi / 3.0) + 1.5 * size - xp.log(turning),
        math.log(math.pi / 4.0) + xp.log(1.0 - nu * (log - 2.0) / turning),
    )
    return tuple(xp.where(s < 0, *pair) for pair in zip(across, along, strict=True))


def _log_table(xp: Any, s: Array, nu: Array) -> tuple[Array, ...]:
    """ln of C11, C22, C23, C33 from the table, extrapolated linearly beyond its ends."""
    knots, straight, bends = (xp.asarray(part, dtype=xp.float64) for part in _spline())
    # A natural spline as a sum over all knots needs no interval search and is linear beyond the ends.
    column = s[..., None]
    logs = straight[0, :] + straight[1, :] * column + xp.matmul(xp.abs(column - knots) ** 3, bends)
    weights = poisson_weights(nu)

    def mean(values: Array, first: int) -> Array:
        return xp.log(sum(weights[j] * values[..., first + j] for j in range(3)))

    c11, c22, c23 = (-mean(xp.exp(-logs), first) for first in (0, 3, 6))
    share = 1.0 / (1.0 + xp.exp(2.0 * s))
    factors = share[..., None] * xp.log(xp.asarray([1.0, 0.75, 0.5], dtype=xp.float64))
    return c11, c22, c23, mean(xp.exp(logs[..., 9:] + factors), 0) - share * xp.log(1.0 - nu)


@functools.cache
def _spline() -> tuple[Any, Any, Any]:
    """Natural cubic splines in ln(a/b) of the logarithms of the tabulated columns.

    Returns
    -------
    knots (n,), straight (2, 12), bends (n, 12)
        Spline k is ``straight[0, k] + straight[1, k] s + sum_i bends[i, k] |s - knots[i]|^3``. Each coefficient has three
        consecutive splines, one for each Poisson's ratio.
    """
    import numpy as np

    data = files.shipped("contact", "kalker")
    knots = np.concatenate([np.log(data["a_over_b"]), -np.log(data["b_over_a"])])
    columns = [data[name] for name in KalkerCoefficients._fields]
    table = np.concatenate([np.asarray(column["values"]) for column in columns], axis=1)
    digits = np.repeat([column["digits"] for column in columns], 3)
    rounding = 0.5 * 10.0 ** (np.floor(np.log10(table)) + 1 - digits) / table
    # The last two conditions make the spline natural, that is linear beyond the ends.
    n = len(knots)
    line = np.stack([np.ones(n), knots])
    system = np.block([[line.T, np.abs(knots[:, None] - knots) ** 3], [np.zeros((2, 2)), line]])
    solutions = []
    for values, error in zip(table.T, rounding.T, strict=True):
        give = np.zeros_like(system)
        give[:n, 2:] = np.diag(_STIFFNESS * error**2)
        solutions.append(np.linalg.solve(system + give, np.concatenate([np.log(values), [0.0, 0.0]])))
    solution = np.stack(solutions, axis=1)
    return knots, solution[:2], solution[2:]
