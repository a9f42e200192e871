r"""Steering rate and acceleration that a time-varying motion requires.

The three equations of `infinivar.transmission.inverse`, written as ``G(T, e, q) = T (1 + e q) - e + q = 0`` with
``e = xi(x)/K`` and ``x = H T - f sqrt(1 + T^2)``, are differentiated twice along a motion. Friction makes the angle jump
where the link reverses; between reversals it is smooth, and so are these rates. Finite differences of the angle would
include the jumps.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, namespace
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw
from infinivar.transmission.geometry import LossGroups
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_PROBE = 1e-6
"""Half the step in force ratio for differencing the slope of a nonlinear law; relative error of the curvature 1e-9."""


class Varying(NamedTuple):
    """A quantity at each instant, with its first and second time derivatives."""

    value: Array
    rate: Array = 0.0
    curvature: Array = 0.0


def steering_rates(
    element: RotaryLinearIVT, *, tangent: Array, cylinder_speed: Varying, link_speed: Varying, link_force: Varying
) -> tuple[Array, Array]:
    """Steering rate and acceleration while the link follows a motion.

    Parameters
    ----------
    element : RotaryLinearIVT   Its creep law must have no flow loss.
    tangent : (...,) float      Tangent of the steering angle, from `RotaryLinearIVT.deliver` for the motion. [-]
    cylinder_speed : Varying    omega, nonzero. The groups H and K count as constant in time. [rad s^-1] ...
    link_speed : Varying        Speed, acceleration and jerk. [m s^-1] ...
    link_force : Varying        Applied by the transmission to the link. [N] ...

    Returns
    -------
    rate, acceleration : (...,) float   Rates of phi between reversals of the link; the jump of the angle at a reversal is
        not included. [rad s^-1], [rad s^-2]

    Raises
    ------
    ParameterError
        If the creep law has a flow loss.

    Source: time derivatives of `inverse.steering_tangent`; derivation in the theory page.
    """
    xp = namespace(element, tangent, *cylinder_speed, *link_speed, *link_force)
    groups = element.groups(cylinder_speed.value)
    omega = xp.asarray(cylinder_speed.value, dtype=xp.float64)
    spin, surface = xp.sign(omega), element.cylinder_radius * xp.abs(omega)
    swell, quicken = cylinder_speed.rate / omega, cylinder_speed.curvature / omega
    slope = link_speed.value / surface
    slope_rate = link_speed.rate / surface - slope * swell
    rate, curvature = tangent_rates(
        xp,
        creep.law_in_motion(element.creep_law),
        groups,
        spin * tangent,
        Varying(slope, slope_rate, link_speed.curvature / surface - 2.0 * slope_rate * swell - slope * quicken),
        Varying(*(part / groups.slip_force for part in link_force)),
    )
    along = 1.0 / (1.0 + tangent * tangent)
    turning = spin * rate * along
    return turning, spin * curvature * along - 2.0 * tangent * turning * turning


def tangent_rates(
    xp: Any, law: CreepLaw, groups: LossGroups, tangent: Array, slope: Varying, load: Varying
) -> tuple[Array, Array]:
    r"""First and second time derivative of the steering tangent of a motion.

    Parameters
    ----------
    law : CreepLaw         A law without a flow loss.
    groups : LossGroups    Provides H and K, which count as constant in time.
    tangent : (...,) float T of `inverse.steering_tangent` for the motion. [-]
    slope : Varying        Link speed over surface speed, q. [-], [s^-1], [s^-2]
    load : Varying         Link force over slip force, f; friction between reversals is constant. [-], [s^-1], [s^-2]

    Returns
    -------
    rate, curvature : (...,) float   [s^-1], [s^-2]; nan where `tangent` is.

    Source: time derivatives of `inverse.steering_tangent`; derivation in the theory page.
    """
    stiffness, group = groups.creep_group, groups.rolling_group
    formulas = groups.formulas(law)
    q, f = slope, load
    root = xp.sqrt(1.0 + tangent * tangent)
    ratio = group * tangent - f.value * root
    # The creepage is that of the wheel at angle 0, times its compliance g at this angle, a function of T.
    straight, ease = formulas.creepage(ratio) / stiffness, formulas.slope(ratio) / stiffness
    g, d_g, dd_g = _compliance(groups, tangent)
    creepage, give = straight * g, ease * g
    by_tangent = group - f.value * tangent / root  # dx/dT
    with_e, with_q = tangent * q.value - 1.0, 1.0 + tangent * creepage  # dG/de, dG/dq
    stretch = 1.0 + creepage * q.value + with_e * (give * by_tangent + straight * d_g)  # dG/dT in all

    pull = -root * f.rate
    rate = -(with_q * q.rate + with_e * give * pull) / stretch
    ratio_rate = by_tangent * rate + pull
    creepage_rate = give * ratio_rate + straight * d_g * rate

    bend = (
        -(f.value / (root * root) * rate * rate + 2.0 * tangent * rate * f.rate) / root - root * f.curvature
    )  # second derivative of x, without the term in the second derivative of T
    swell = give * bend + (2.0 * ease * ratio_rate * d_g + straight * dd_g * rate) * rate
    if not formulas.straight:
        curve = (formulas.slope(ratio + _PROBE) - formulas.slope(ratio - _PROBE)) / (2.0 * _PROBE * stiffness)
        swell = swell + curve * g * ratio_rate * ratio_rate
    curvature = (
        -(
            with_e * swell
            + with_q * q.curvature
            + 2.0 * rate * (creepage_rate * q.value + creepage * q.rate)
            + 2.0 * tangent * creepage_rate * q.rate
        )
        / stretch
    )
    return rate, curvature


def _compliance(groups: LossGroups, tangent: Array) -> tuple[Array, Array, Array]:
    """Creep compliance relative to angle 0, and its first and second derivative by T."""
    square = 1.0 + tangent * tangent
    value, by_share, by_share_twice = groups.compliance(1.0 - 1.0 / square)
    d_share, dd_share = 2.0 * tangent / square**2, (2.0 - 6.0 * tangent * tangent) / square**3
    return value, by_share * d_share, by_share_twice * d_share * d_share + by_share * dd_share
