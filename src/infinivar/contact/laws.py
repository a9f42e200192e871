r"""Formulas of the creep laws, grouped by law: force ratio ``x`` in [-1, 1] and scaled creepage ``xi``.

In the linear law the two are equal. Each law is odd, passive (``x xi >= 0``) and has slope 1 at the origin. The nonlinear
laws return a creepage for every ratio: exact up to gross slip and constant beyond it, so that an iteration that overshoots
recovers. Their slopes diverge towards gross slip; they are capped where ``1 - |x|`` is below float64 resolution (at 1e10
or more), and zero beyond.
"""

from __future__ import annotations

import math

from infinivar._core.array_namespace import Array, namespace

FAULRING_ONSET = 0.7
"""Force ratio above which Eq 17 departs from the linear law."""

VERMEULEN_JOHNSON_SLIP = 3.0
FASTSIM_SLIP = 32.0 / (3.0 * math.pi)
"""Scaled creepage at which the whole patch slips."""

_POLACH_SERIES = (1 / 60, 1 / 1400, 1 / 25200, 43 / 17248000, 1213 / 7207200000)
"""Series of psi in s = (6 M)^(1/3), where psi - sin psi = M, after the first term psi = s."""

RESOLUTION = 2.0**-53
"""Distance of the largest float64 below 1 from 1."""


def linear_creepage(force_ratio: Array) -> Array:
    """Scaled creepage of the linear law, which is the force ratio itself.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P. The law continues beyond +-1; the caller detects slip. [-]

    Returns
    -------
    (...,) float   Scaled creepage. [-]

    Source: faulring2006, Eq 7, in passive form.
    """
    return force_ratio


def linear_slope(force_ratio: Array) -> float:
    """Derivative of `linear_creepage`: 1 everywhere.

    Source: faulring2006, Eq 7.
    """
    return 1.0


def linear_force(creepage: Array) -> Array:
    """Force ratio of the linear law: proportional to the creepage up to gross slip, then constant.

    Parameters
    ----------
    creepage : (...,) float   Scaled creepage; infinite for a wheel that slides without rolling. [-]

    Returns
    -------
    (...,) float   Force ratio in [-1, 1]. [-]

    Source: faulring2006, Eq 7 and Fig 5.
    """
    xp = namespace(creepage)
    return xp.clip(creepage, -1.0, 1.0)


def faulring_flow_factor(force_ratio: Array) -> tuple[Array, Array]:
    r"""Factor on the link speed above 70 % of the slip force, and its derivative.

    .. math:: \eta_t'/\eta_t = 1 - \left(\frac{|x| - 0.7}{0.3}\right)^2 \quad (|x| > 0.7)

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P. Invalid beyond +-1, where the factor is negative. [-]

    Returns
    -------
    factor, slope : (...,) float   Factor, and its derivative by the force ratio. [-]

    Source: faulring2006, Eq 17.
    """
    xp = namespace(force_ratio)
    size = xp.abs(force_ratio)
    over = xp.where(size > FAULRING_ONSET, size - FAULRING_ONSET, 0.0) / (1.0 - FAULRING_ONSET)
    slope = -2.0 * over / (1.0 - FAULRING_ONSET)
    return 1.0 - over * over, xp.where(force_ratio < 0, -slope, slope)


def vermeulen_johnson_force(creepage: Array) -> Array:
    r"""Force ratio of Vermeulen and Johnson: an elliptical stick region that touches the leading edge of the patch.

    .. math:: x = 1 - (1 - \xi/3)^3 \quad (0 \le \xi \le 3)

    Parameters
    ----------
    creepage : (...,) float   Scaled creepage, may be infinite; gross slip begins at 3. [-]

    Returns
    -------
    (...,) float   Force ratio in [-1, 1]. [-]

    Source: vermeulen1964, with the initial slope from kalker1990 as in shen1983.
    """
    xp = namespace(creepage)
    k = size_of(xp, creepage) / VERMEULEN_JOHNSON_SLIP
    k = xp.where(k >= 1.0, 1.0, k)
    return signed(xp, creepage, k * (3.0 - k * (3.0 - k)))


def vermeulen_johnson_creepage(force_ratio: Array) -> Array:
    r"""Scaled creepage of Vermeulen and Johnson, :math:`\xi = 3 (1 - (1 - x)^{1/3})`.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; beyond +-1 the creepage stays at 3. [-]

    Returns
    -------
    (...,) float   Scaled creepage. [-]

    Source: vermeulen1964, solved for the creepage.
    """
    xp = namespace(force_ratio)
    size = size_of(xp, force_ratio)
    slips = size >= 1.0
    creepage = -VERMEULEN_JOHNSON_SLIP * xp.expm1(xp.log1p(-xp.where(slips, 0.0, size)) / 3.0)
    return signed(xp, force_ratio, xp.where(slips, VERMEULEN_JOHNSON_SLIP, creepage))


def vermeulen_johnson_slope(force_ratio: Array) -> Array:
    r"""Derivative of `vermeulen_johnson_creepage`, :math:`(1 - x)^{-2/3}`.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; at +-1 the slope is capped at about 4e10, beyond it is 0. [-]

    Returns
    -------
    (...,) float   [-]

    Source: vermeulen1964, derivative.
    """
    xp = namespace(force_ratio)
    size = size_of(xp, force_ratio)
    return xp.where(size > 1.0, 0.0, rest_of(xp, size) ** (-2.0 / 3.0))


def polach_force(creepage: Array) -> Array:
    r"""Force ratio of Polach, without spin and with a friction limit independent of the sliding speed.

    .. math:: x = \frac{2}{\pi} \left(\frac{\epsilon}{1 + \epsilon^2} + \arctan \epsilon\right),
        \qquad \epsilon = \frac{\pi}{4} \xi

    Parameters
    ----------
    creepage : (...,) float   Scaled creepage, may be infinite; no finite creepage reaches gross slip. [-]

    Returns
    -------
    (...,) float   Force ratio in [-1, 1]. [-]

    Source: polach2005, with equal reduction factors of 1.
    """
    xp = namespace(creepage)
    angle = 2.0 * xp.atan(0.25 * math.pi * creepage)
    return (angle + xp.sin(angle)) / math.pi


def polach_creepage(force_ratio: Array) -> Array:
    """Scaled creepage of Polach's law, accurate to rounding of the force ratio.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; from +-1 on the creepage stays at 2e5, the value for a ratio that
        float64 cannot distinguish from 1. [-]

    Returns
    -------
    (...,) float   Scaled creepage. [-]

    Source: polach2005, solved for the creepage (derivation in the code).
    """
    xp = namespace(force_ratio)
    return signed(xp, force_ratio, 4.0 / math.pi * _polach_epsilon(xp, size_of(xp, force_ratio)))


def polach_slope(force_ratio: Array) -> Array:
    r"""Derivative of `polach_creepage`, :math:`(1 + \epsilon^2)^2`.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; at +-1 the slope is capped at about 5e20, beyond it is 0. [-]

    Returns
    -------
    (...,) float   [-]

    Source: polach2005, derivative.
    """
    xp = namespace(force_ratio)
    size = size_of(xp, force_ratio)
    root = 1.0 + _polach_epsilon(xp, size) ** 2
    return xp.where(size > 1.0, 0.0, root * root)


def _polach_epsilon(xp, size: Array) -> Array:
    """eps of a force ratio >= 0. With phi = 2 atan(eps), phi + sin phi = pi x; near slip, (pi - phi) - sin phi is better.

    The series of the second form is accurate to 5e-4 over the whole range. One step of fourth order, which needs no more
    sines than a step of second order, leaves only rounding. The step is so small that a short series gives its tangent.
    """
    rest = rest_of(xp, size)
    root = (6.0 * math.pi * rest) ** (1.0 / 3.0)
    angle = math.pi - _start(root, _POLACH_SERIES, (6.0 * math.pi) ** (1.0 / 3.0), math.pi)
    half_sine, half_cosine = xp.sin(0.5 * angle), xp.cos(0.5 * angle)
    sine, slope = 2.0 * half_sine * half_cosine, 2.0 * half_cosine * half_cosine
    excess = xp.where(size < 0.5, angle + sine - math.pi * size, math.pi * rest - (math.pi - angle - sine))
    step, bend, twist = excess / slope, -0.5 * sine / slope, (1.0 / 6.0) * (1.0 / slope - 1.0)
    half = -0.5 * step * (1.0 - bend * step) / (1.0 - step * (2.0 * bend - twist * step))
    tangent, epsilon = half * (1.0 + half * half / 3.0), half_sine / half_cosine
    return (epsilon + tangent) / (1.0 - epsilon * tangent)


def fastsim_force(creepage: Array) -> Array:
    r"""Force ratio of Kalker's simplified theory without spin: the limit of FASTSIM for infinitely many cells.

    .. math:: x = \frac{6 \alpha (1 + 4 w^2) - 12 \pi w^2 + 2 w \sqrt{1 - w^2} (13 + 2 w^2)}{3 \pi}, \qquad
        w = \sin \alpha = \frac{3 \pi}{32} \xi

    In a strip of half-length c (relative to a) the traction grows from the leading edge until it reaches the parabolic
    bound at ``2 w - c``; strips shorter than w slip completely. The formula is the integral over the strips.

    Parameters
    ----------
    creepage : (...,) float   Scaled creepage, may be infinite; gross slip begins at 32/(3 pi) = 3.395. [-]

    Returns
    -------
    (...,) float   Force ratio in [-1, 1]. [-]

    Source: kalker1982, integrated over an elliptic patch with a parabolic bound.
    """
    xp = namespace(creepage)
    w = size_of(xp, creepage) / FASTSIM_SLIP
    slips = w >= 1.0
    angle = xp.asin(xp.where(slips, 0.0, w))
    force, rest, _, _ = _fastsim(xp, angle)
    # The condition must not use `rest`: SymPy would move the choice above out of it and evaluate asin beyond 1.
    force = xp.where(w < 0.5, force, 1.0 - xp.clip(rest, 0.0, 1.0))
    return signed(xp, creepage, xp.where(slips, 1.0, force))


def fastsim_creepage(force_ratio: Array) -> Array:
    """Scaled creepage of Kalker's simplified theory without spin, accurate to about two roundings of the force ratio.

    Near gross slip that means few digits: an error in the ratio is multiplied by `fastsim_slope`.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; beyond +-1 the creepage stays at 32/(3 pi). [-]

    Returns
    -------
    (...,) float   Scaled creepage. [-]

    Source: kalker1982, `fastsim_force` solved for the creepage.
    """
    xp = namespace(force_ratio)
    size = size_of(xp, force_ratio)
    creepage = FASTSIM_SLIP * xp.sin(_fastsim_angle(xp, size))
    return signed(xp, force_ratio, xp.where(size >= 1.0, FASTSIM_SLIP, creepage))


def fastsim_slope(force_ratio: Array) -> Array:
    """Derivative of `fastsim_creepage`.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P; at +-1 the slope is capped at about 1e11, beyond it is 0. [-]

    Returns
    -------
    (...,) float   [-]

    Source: kalker1982, derivative.
    """
    xp = namespace(force_ratio)
    size = size_of(xp, force_ratio)
    angle = _fastsim_angle(xp, size)
    _, _, slope, _ = _fastsim(xp, angle)
    return xp.where(size > 1.0, 0.0, FASTSIM_SLIP * xp.cos(angle) / slope)


def _fastsim_angle(xp, size: Array) -> Array:
    """Angle asin(w) of a force ratio >= 0."""
    rest = rest_of(xp, size)
    # With A = pi/2 - asin(w), 1 - x is 32 A^7/(105 pi) near slip.
    scale = 105.0 * math.pi / 32.0
    angle = 0.5 * math.pi - _start((scale * rest) ** (1.0 / 7.0), (1.0 / 21.0,), scale ** (1.0 / 7.0), 0.5 * math.pi)
    for _ in range(2):
        force, missing, slope, curvature = _fastsim(xp, angle)
        excess = xp.where(size < 0.5, force - size, rest - missing)
        angle = _halley(angle, excess, slope, curvature)
    return angle


def _fastsim(xp, angle: Array) -> tuple[Array, Array, Array, Array]:
    """Force ratio x at asin(w), 1 - x, and the first and second derivative of x by that angle.

    x is exact to rounding for small angles and 1 - x near a right angle; each suffers cancellation at the other end.
    """
    w, cosine = xp.sin(angle), xp.cos(angle)
    left = 0.5 * math.pi - angle
    weight, product = 6.0 * (1.0 + 4.0 * w * w), 2.0 * w * cosine * (13.0 + 2.0 * w * w)
    force = (weight * angle - 12.0 * math.pi * w * w + product) / (3.0 * math.pi)
    missing = (weight * left - product) / (3.0 * math.pi)
    bracket = cosine * (2.0 + w * w) - 3.0 * left * w
    scale = 16.0 / (3.0 * math.pi)
    curvature = -scale * (w * bracket + 3.0 * cosine * cosine * (left - cosine * w))
    return force, missing, scale * cosine * bracket, curvature


def _start(root: Array, series: tuple[float, ...], last_root: float, last: float) -> Array:
    """Series root + series[0] root^3 + ... of an odd function, with one more term so that it is `last` at `last_root`."""
    sum_of_series = sum(factor * last_root ** (3 + 2 * i) for i, factor in enumerate(series))
    extra = (last - last_root - sum_of_series) / last_root ** (3 + 2 * len(series))
    square, tail = root * root, extra
    for factor in reversed(series):
        tail = factor + square * tail
    return root * (1.0 + square * tail)


def _halley(value: Array, excess: Array, slope: Array, curvature: Array) -> Array:
    step = excess / slope
    return value - step / (1.0 - 0.5 * step * curvature / slope)


def size_of(xp, value: Array) -> Array:
    """Absolute value with derivative 1 at 0, as an odd law requires."""
    return xp.where(value < 0, -value, value)


def signed(xp, value: Array, size: Array) -> Array:
    """`size` with the sign of `value`."""
    return xp.where(value < 0, -size, size)


def rest_of(xp, size: Array) -> Array:
    """1 - |x|, but at least the resolution of float64."""
    return xp.where(size >= 1.0, RESOLUTION, 1.0 - size)
