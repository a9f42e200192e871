r"""Lateral creep laws: how fast a wheel drifts sideways under a lateral force.

A law relates two numbers: the force ratio ``x = fu/(mu P)`` and the scaled creepage ``xi = (C/(mu P)) u/|v|``, which
the linear law makes equal. All laws are odd, passive (``x xi >= 0``) and saturate at ``|x| = 1``, gross slip.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from infinivar._xp import Array, namespace
from infinivar.errors import nearest

FAULRING_ONSET = 0.7
"""Force ratio above which Eq 17 departs from the linear law."""


def linear_creepage(force_ratio: Array) -> Array:
    """Scaled creepage of the linear law, which is the force ratio itself.

    Parameters
    ----------
    force_ratio : (...,) float   Lateral force over mu P. Beyond +-1 the law continues; the caller names the slip. [-]

    Returns
    -------
    (...,) float   Scaled creepage. [-]

    Source: faulring2006, Eq 7, with the sign of Eq 8.
    """
    return force_ratio


def linear_force(creepage: Array) -> Array:
    """Force ratio of the linear law: proportional to the creepage, then constant at gross slip.

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
    force_ratio : (...,) float   Lateral force over mu P. Meaningless beyond +-1, where the factor turns negative. [-]

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


@dataclass(frozen=True, slots=True, kw_only=True)
class CreepLaw:
    """One law, by its parts.

    Attributes
    ----------
    creepage : force ratio -> scaled creepage
    slope : force ratio -> derivative of the scaled creepage
    force : scaled creepage -> force ratio
    flow_factor : force ratio -> factor on the link speed and its derivative, or None where the law is a creep law alone
    """

    creepage: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    force: Callable[[Array], Array]
    flow_factor: Callable[[Array], tuple[Array, Array]] | None = None


def _unit_slope(force_ratio: Array) -> Any:
    return 1.0


LAWS = {
    "linear": CreepLaw(creepage=linear_creepage, slope=_unit_slope, force=linear_force),
    "faulring": CreepLaw(
        creepage=linear_creepage,
        slope=_unit_slope,
        force=linear_force,
        flow_factor=faulring_flow_factor,
    ),
}


def law(name: str) -> CreepLaw:
    """The creep law of that name.

    Raises
    ------
    ValueError
        If there is none; the message names those there are.
    """
    if name not in LAWS:
        raise ValueError(f"creep_law must be one of {', '.join(LAWS)}, got {name!r}{nearest(name, LAWS)}")
    return LAWS[name]


def directed_flow_factor(law: CreepLaw, ratio: Array, link_speed: Array) -> Array:
    """Factor on the link speed that always takes power away; 0 at and beyond slip.

    Where the lateral force drives the link (``-fu ldot > 0``) the paper's factor slows it. Where the load drives, the
    same factor would create power; its reciprocal lets the link run away faster instead, with the same torque.

    Parameters
    ----------
    law : CreepLaw              One with a flow factor.
    ratio : (...,) float        Lateral force over mu P. [-]
    link_speed : (...,) float   Link speed before the loss, or anything with its sign. [m s^-1]

    Returns
    -------
    (...,) float   [-]

    Source: faulring2006, Eq 17, made passive in all quadrants.
    """
    assert law.flow_factor is not None
    xp = namespace(ratio, link_speed)
    factor, _ = law.flow_factor(ratio)
    rolls = factor > 0
    drives = ratio * link_speed <= 0
    return xp.where(rolls, xp.where(drives, factor, 1.0 / xp.where(rolls, factor, 1.0)), 0.0)


def before_flow_loss(law: CreepLaw, ratio: Array, slope: Array) -> tuple[Array, Array]:
    """Speed ratio that `directed_flow_factor` turns into `slope`, and its derivative by the force ratio; nan beyond slip.

    Parameters
    ----------
    law : CreepLaw         One with a flow factor.
    ratio : (...,) float   Lateral force over mu P. [-]
    slope : (...,) float   Link speed over surface speed with the loss. [-]

    Returns
    -------
    before, derivative : (...,) float   [-]

    Source: faulring2006, Eq 17, solved for the speed before the loss.
    """
    assert law.flow_factor is not None
    xp = namespace(ratio, slope)
    factor, d_factor = law.flow_factor(ratio)
    rolls = factor > 0
    inverse = xp.where(rolls, 1.0 / xp.where(rolls, factor, 1.0), xp.nan)
    drives = ratio * slope <= 0
    before = slope * xp.where(drives, inverse, factor)
    return before, slope * d_factor * xp.where(drives, -inverse * inverse, 1.0)
