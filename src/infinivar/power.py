"""Power accounting for the element, the drives and the analyses: efficiency, audit, operating points."""

from __future__ import annotations

from collections.abc import Mapping

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.described import at
from infinivar.errors import AuditError
from infinivar.limits import Limit, binding, codes

AUDIT_TOLERANCE = 1e-9
"""Largest accepted residual of a power balance, relative to the largest power in it. Rounding in float64 leaves about
1e-15; the tolerance allows for cancellation in creep speeds, which are a thousandth of the rolling speed."""


def efficiency(power_in: Array, power_out: Array) -> Array:
    """Useful power over power supplied, in the direction in which power flows.

    Parameters
    ----------
    power_in : (...,) float    Power from the source, negative where it returns to the source. [W]
    power_out : (...,) float   Power to the load, negative where the load drives. [W]

    Returns
    -------
    (...,) float   power_out / power_in where the source drives, power_in / power_out where the load drives the source;
        0 where all power supplied is lost; nan where both sides feed the losses, where no power flows, and where an
        input is nan. [-]

    Source: faulring2006, Eq 15, extended to all four quadrants.
    """
    xp = namespace(power_in, power_out)
    forward = (power_in > 0) & (power_out >= 0)
    backward = (power_out < 0) & (power_in <= 0)
    spent = xp.where(forward, power_in, xp.where(backward, power_out, 1.0))
    return xp.where(forward, power_out, xp.where(backward, power_in, xp.nan)) / spent + 0.0  # no -0


def efficiency_within(limit: Array, power_in: Array, power_out: Array) -> Array:
    """As `efficiency`, but nan where a limit is exceeded. [-]"""
    xp = namespace(power_in, power_out)
    return xp.where(limit == int(Limit.OK), efficiency(power_in, power_out), xp.nan)


def residual(power_in: Array, power_out: Array, losses: Mapping[str, Array]) -> Array:
    """Residual of the power balance, relative to the largest power; 0 where no power flows, nan where undefined.

    Parameters
    ----------
    power_in, power_out : (...,) float            [W]
    losses : mapping of name to (...,) float      [W]

    Returns
    -------
    (...,) float   |power_in - power_out - sum(losses)| / max(|power_in|, |power_out|). [-]
    """
    xp = namespace(power_in, power_out)
    missing = power_in - power_out
    for loss in losses.values():
        missing = missing - loss
    return xp.abs(missing) / (xp.maximum(xp.abs(power_in), xp.abs(power_out)) + 1e-300)


def _rounding(power_in: Array, power_out: Array) -> Array:
    """Power that counts as zero beside those of a point. [W]"""
    xp = namespace(power_in, power_out)
    return AUDIT_TOLERANCE * (xp.abs(power_in) + xp.abs(power_out))


def judged(power_in: Array, power_out: Array, losses: Mapping[str, Array]) -> tuple[Array, Array]:
    """Largest residual over all points, and whether `audit` accepts them; over any array namespace."""
    xp = namespace(power_in, power_out)
    off, slack = residual(power_in, power_out, losses), _rounding(power_in, power_out)
    negative = off < 0.0  # nowhere; gives the shape
    for loss in losses.values():
        negative = negative | (loss < -slack)
    worst = xp.max(xp.where(xp.isnan(off), 0.0, off))
    return worst, (worst <= AUDIT_TOLERANCE) & ~xp.any(negative)


def audit(power_in: Array, power_out: Array, losses: Mapping[str, Array], where: str) -> float:
    """Largest residual over all points.

    Raises
    ------
    AuditError
        If the residual at any point exceeds `AUDIT_TOLERANCE`, or a loss is negative by more than that.
    """
    import numpy as np

    scale = _rounding(power_in, power_out)
    for name, loss in losses.items():
        if np.any(loss < -scale):
            raise AuditError(f"{where}: the {name} loss is negative, down to {np.nanmin(loss):.3g} W")
    worst = float(np.fmax.reduce(residual(power_in, power_out, losses), axis=None, initial=0.0))
    if not worst <= AUDIT_TOLERANCE:
        raise AuditError(
            f"{where}: the power balance has a relative residual of {worst:.3g}, above the tolerance of {AUDIT_TOLERANCE:g}"
        )
    return worst


AT_POINT = (
    at("power_in", "W", "power from the supply", (...,)),
    at("power_out", "W", "power to the load", (...,)),
    at("efficiency", "1", "useful power over power spent", (...,)),
    at("limit", "1", "limit exceeded", (...,), notes=codes),
    at("margin", "1", "allowance over demand of the tightest limit", (...,)),
    at("losses", "W", "power lost in {}", (...,), variable="loss_{}"),
    at("utilisation", "1", "{}: demand over allowance", (...,), variable="demand_{}"),
)
"""What operating points that are results state for their data set."""


class PowerPoint:
    """Base of the operating points of elements and drives.

    Subclasses provide `power_in`, `power_out` [W] and `utilisation`, demand over allowance by limit.
    """

    __slots__ = ()

    power_in: Array
    power_out: Array
    utilisation: Mapping[Limit, Array]

    @property
    def limit(self) -> Array:
        """Tightest limit where it is exceeded, else `Limit.OK`, as an integer."""
        return binding(self.utilisation)[0]

    @property
    def margin(self) -> Array:
        """Allowance over demand for the tightest limit. [-]"""
        return binding(self.utilisation)[1]

    @property
    def efficiency(self) -> Array:
        """Useful power over power supplied where feasible, else nan; see `infinivar.power.efficiency`. [-]"""
        return efficiency_within(self.limit, self.power_in, self.power_out)
