"""Steering moment: friction moment of a loaded contact patch that turns on the spot."""

from __future__ import annotations

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar.contact.elliptic import ellipse_integrals


def line_moment(load: Array, half_length: Array, friction: Array) -> Array:
    r"""Moment to turn a thin line of uniform pressure about its centre, fully sliding.

    .. math:: M = \tfrac{1}{2} \mu_s P b

    Parameters
    ----------
    load : (...,) float          Normal load P. [N]
    half_length : (...,) float   b, lateral. [m]
    friction : (...,) float      Sliding friction mu_s. [-]

    Returns
    -------
    (...,) float   Magnitude of the moment; it opposes the rotation. [N m]

    Source: faulring2006, section V (steering plant).
    """
    return 0.5 * friction * load * half_length


def ellipse_moment(load: Array, a: Array, b: Array, friction: Array) -> Array:
    r"""Moment to turn a Hertzian patch about its centre, fully sliding.

    .. math:: M = \tfrac{3}{8} \mu_s P L E(e)

    with the larger semi-axis L and the complete elliptic integral E of the second kind; L E is a quarter of the
    circumference. A circle gives (3 pi/16) mu P a, a thin ellipse (3/8) mu P b.

    Parameters
    ----------
    load : (...,) float       Normal load P. [N]
    a, b : (...,) float       Semi-axes, > 0. [m]
    friction : (...,) float   Sliding friction mu_s. [-]

    Returns
    -------
    (...,) float   Magnitude of the moment; it opposes the rotation. [N m]

    Source: integral of mu p r over the patch; johnson1985, Eq 4.24 for the pressure.
    """
    xp = namespace(load, a, b, friction)
    load, a, b, friction = as_floats(xp, load, a, b, friction)
    ratio = a / b
    integrals = ellipse_integrals(ratio)
    # E = K - (1 - g^2) D, with K = plain/2 and D = along_b/2.
    quarter_rim = 0.5 * b * (integrals.plain - (1.0 - ratio * ratio) * integrals.along_b)
    return 0.375 * friction * load * quarter_rim
