r"""The steering angle for a motion: the inverse of the wheel's steady operation.

With ``T = s tan(phi)``, the ratio q of link speed to surface speed, the ratio f of link force to slip force and the groups H
and K, a motion satisfies

.. math:: x = H T - f \sqrt{1 + T^2}, \qquad e = \xi(x)/K, \qquad q = \frac{e - T}{1 + e T},

three equations for the force ratio x, the creepage e and T. If several T give the motion, the solution is the one nearest
to the locked wheel.
"""

from __future__ import annotations

import functools
from typing import Any

from infinivar._core.array_namespace import Array, newton
from infinivar.contact import creep
from infinivar.contact.creep import CreepLaw, Formulas
from infinivar.transmission.geometry import LossGroups

_STEPS = 24
"""Most points converge in 2 or 3 steps. Near the fastest motion two solutions merge and each step gains only one bit."""

_SHORT_OF_SLIP = 1.0 - 1e-6
"""Largest force ratio at which a search starts: at the slip limit the slope of a nonlinear law diverges."""


def steering_tangent(xp: Any, law: CreepLaw, groups: LossGroups, slope: Array, load: Array) -> Array:
    """Tangent of the steering angle, times the sign of the cylinder speed, for a motion of the link.

    Parameters
    ----------
    law : CreepLaw           Any law.
    groups : LossGroups      Provides H and K.
    slope : (...,) float     Link speed over magnitude of the surface speed, q. [-]
    load : (...,) float      Link force over slip force, f. [-]

    Returns
    -------
    (...,) float   T; nan where no angle gives the motion. [-]

    Source: inverse of `RotaryLinearIVT.operate`; derivation in the theory page.
    """
    formulas = groups.formulas(law)
    return (_by_angle if formulas.straight else _by_creepage)(xp, formulas, groups, slope, load)


def _ratio(xp: Any, groups: LossGroups, load: Array, tangent: Array) -> tuple[Array, Array]:
    """Force ratio x of a steered wheel, and its derivative by T."""
    root = xp.sqrt(1.0 + tangent * tangent)
    return groups.rolling_group * tangent - load * root, groups.rolling_group - load * (tangent / root)


def _by_angle(xp: Any, law: Formulas, groups: LossGroups, slope: Array, load: Array) -> Array:
    """For linear laws: Newton's method for T (1 + e q) - e + q = 0 in T, nearly linear since e is at most 1/K."""
    stiffness = groups.creep_group

    def step(tangent: Array) -> Array:
        ratio, d_ratio = _ratio(xp, groups, load, tangent)
        creepage, d_creepage = law.creepage(ratio) / stiffness, law.slope(ratio) / stiffness * d_ratio
        q, d_q = slope, 0.0
        if law.flow_factor is not None:
            q, d_q = creep.before_flow_loss(law, ratio, slope)
        value = tangent * (1.0 + creepage * q) - creepage + q
        d_value = 1.0 + creepage * q + (tangent * q - 1.0) * d_creepage
        if law.flow_factor is not None:
            d_value = d_value + (tangent * creepage + 1.0) * d_q * d_ratio
        return _newton_step(xp, tangent, value, d_value)

    start = -slope + 0.0 * load
    if law.flow_factor is not None:
        # Beyond slip Eq 17 is invalid and would make the iteration diverge: start at slip.
        reach = xp.sqrt(xp.clip(1.0 / xp.where(load == 0, 1e-9, load) ** 2 - 1.0, 0.0, 1e18))
        start = xp.clip(start, -reach, reach)
    return newton(xp, step, start, _STEPS)


def _by_creepage(xp: Any, law: Formulas, groups: LossGroups, slope: Array, load: Array) -> Array:
    """For nonlinear laws: Newton's method for force(K e) = x(T(e)) in e, with T = (e - q)/(1 + e q).

    The force is a concave function of creepage and flat at slip, whereas the inverse function is steep there. Started to the
    left of the first root, the iteration climbs a concave curve and converges to that root.
    """
    stiffness = groups.creep_group

    def tangent_at(creepage: Array) -> Array:
        return (creepage - slope) / (1.0 + creepage * slope)

    def scaled(creepage: Array, tangent: Array) -> tuple[Array, Array, Array]:
        """Scaled creepage of a steered wheel, and its derivatives by the creepage and by T."""
        square = 1.0 + tangent * tangent
        give, by_share, _ = groups.compliance(1.0 - 1.0 / square)
        local = stiffness / give
        return creepage * local, local, -creepage * local * by_share / give * (2.0 * tangent / (square * square))

    def step(creepage: Array) -> Array:
        tangent = tangent_at(creepage)
        at, by_creepage, by_tangent = scaled(creepage, tangent)
        force, rise = law.responding(at)
        ratio, d_ratio = _ratio(xp, groups, load, tangent)
        d_tangent = (1.0 + slope * slope) / (1.0 + creepage * slope) ** 2
        d_force = (by_creepage + by_tangent * d_tangent) * rise
        return _newton_step(xp, creepage, force - ratio, d_force - d_ratio * d_tangent)

    ideal, _ = _ratio(xp, groups, load, -slope)
    ideal = xp.clip(ideal, -_SHORT_OF_SLIP, _SHORT_OF_SLIP)
    # Where the wheel drives, creepage raises the force, so the force of the ideal wheel is left of the root. Where the load
    # drives, creepage lowers it, and the force at the ideal wheel's creepage is left of the root; if the angle changes sign
    # in between, the force at zero angle is.
    turned = tangent_at(law.creepage(ideal) / stiffness)
    after, _ = _ratio(xp, groups, load, xp.where(turned * slope > 0, 0.0, turned))
    start = law.creepage(xp.where(xp.abs(after) < xp.abs(ideal), after, ideal)) / stiffness
    if groups.yielding is not None:  # a stiffer patch at some angle moves the root to the left
        least = [groups.compliance(share)[0] for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
        start = start * functools.reduce(lambda one, other: xp.where(one < other, one, other), least)
    creepage = newton(xp, step, start, _STEPS)
    at, _, _ = scaled(creepage, tangent_at(creepage))
    rolls = xp.abs(at) <= law.slip_creepage * (1.0 + 1e-9)
    return xp.where(rolls, tangent_at(xp.where(rolls, creepage, 0.0)), xp.nan)


def _newton_step(xp: Any, at: Array, value: Array, slope: Array) -> Array:
    """Next iterate; nan where the slope is not positive, that is, beyond the fastest motion under this load."""
    rises = slope > 0
    return xp.where(rises, at - value / xp.where(rises, slope, 1.0), xp.nan)
