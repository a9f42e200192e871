"""Rolling resistance from hysteresis: the fraction of the strain energy that rolling bodies dissipate."""

from __future__ import annotations

import math

from infinivar._core.array_namespace import Array
from infinivar.contact.bodies import Material


def line_torque(load: Array, half_width: Array, hysteresis_factor: Array) -> Array:
    r"""Hysteresis torque of a rolling line contact.

    .. math:: \tau_{in} = \alpha_{fr} \frac{2 P a}{3\pi}

    Parameters
    ----------
    load : (...,) float                Normal load P, >= 0. [N]
    half_width : (...,) float          a, along the rolling direction. [m]
    hysteresis_factor : (...,) float   alpha_fr, fraction of the strain energy lost, 0 to 1. [-]

    Returns
    -------
    (...,) float   Torque about the axle of either body, >= 0; it opposes rolling and is independent of speed. [N m]

    Source: faulring2006, Eq 10, Eq 11, Eq 12 and Eq 13 (there the half-width is b); johnson1985, section 9.4.
    """
    return hysteresis_factor * 2.0 / (3.0 * math.pi) * load * half_width


def ellipse_torque(load: Array, a: Array, hysteresis_factor: Array) -> Array:
    r"""Hysteresis torque of a rolling elliptical contact.

    .. math:: \tau_{in} = \alpha_{fr} \frac{3 P a}{16}

    Parameters
    ----------
    load : (...,) float                Normal load P, >= 0. [N]
    a : (...,) float                   Semi-axis along the rolling direction. [m]
    hysteresis_factor : (...,) float   alpha_fr, fraction of the strain energy lost, 0 to 1. [-]

    Returns
    -------
    (...,) float   Torque about the axle of either body, >= 0; it opposes rolling and is independent of speed. [N m]

    Source: johnson1985, section 9.4 (the work of the Hertz pressure on the front half of the patch).
    """
    return hysteresis_factor * (3.0 / 16.0) * load * a


def combined_hysteresis(first: Material, second: Material) -> float:
    """Combined loss factor of two bodies, weighted by their share of the strain energy, which is that of compliance. [-]

    Source: johnson1985, section 9.4 (strain energy is load times approach, to which each body adds (1 - nu^2)/E).
    """
    soft, hard = first.plane_strain_compliance, second.plane_strain_compliance
    return (first.hysteresis_factor * soft + second.hysteresis_factor * hard) / (soft + hard)
