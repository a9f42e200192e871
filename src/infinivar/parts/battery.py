"""A battery that feeds a machine: current and loss for the power that its amplifiers draw, and what is in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, given, quantity
from infinivar.errors import require
from infinivar.limits import Limit


class Fed(NamedTuple):
    """What a battery supplies, arrays (...,); nan where it cannot."""

    current: Array
    """Negative where it is charged. [A]"""
    power: Array
    """Of the cells: what the charge loses. [W]"""
    loss: Array
    """In the resistance. [W]"""
    utilisation: Mapping[Limit, Array]
    """Of the current. [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Battery:
    r"""A battery with a constant open-circuit voltage U behind a resistance R.

    It gives :math:`P = U I - R I^2` at its terminals, at most :math:`U^2/4R`. The voltage of motors is that of their supply,
    whatever the battery's.
    """

    voltage: float = quantity("V", Gt(0), "Open-circuit voltage")
    energy: float = quantity("J", Gt(0), "Energy of a full battery at that voltage: its charge times the voltage")
    resistance: float = quantity("ohm", Ge(0), "Internal resistance, with cables and fuse", default=0.0)
    largest_current: float | None = quantity(
        "A", Gt(0), "Largest continuous current that it gives; by default that of its largest power", default=None
    )
    largest_charging_current: float | None = quantity(
        "A", Gt(0), "Largest continuous current that charges it; by default not judged", default=None
    )
    usable: float = quantity(
        "1", Interval(gt=0, le=1), "Share of the energy that is used before it is charged", default=1.0
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        most = self.voltage / (2.0 * self.resistance) if self.resistance > 0.0 else float("inf")
        if self.largest_current is not None:
            fits, said = self.largest_current <= most, f"<= {most:g} A, beyond which the power at the terminals falls"
            require(fits, "largest_current", f"{self.largest_current:g}", said)

    @property
    def usable_energy(self) -> float:
        """Between charges. [J]"""
        return self.usable * self.energy

    def supply(self, power: Array) -> Fed:
        """Current and loss at a power of the terminals.

        Parameters
        ----------
        power : (...,) float   Drawn from the battery, negative where it is charged. [W]

        Returns
        -------
        Fed   Beyond the largest power all is nan, and the demand infinite.

        Source: Ohm's and Kirchhoff's laws.
        """
        xp = namespace(power, self.voltage, self.resistance)
        u, r = self.voltage, self.resistance
        square = 1.0 - 4.0 * r * power / u**2
        gives = square >= 0.0
        current = 2.0 * power / u / (1.0 + xp.sqrt(xp.where(gives, square, xp.nan)))
        peak = u / (2.0 * r) if r > 0.0 else xp.inf
        most = given(self.largest_current, peak)
        demand = xp.where(power > 0.0, xp.where(gives, current / most, xp.inf), 0.0)
        if self.largest_charging_current is not None:
            demand = xp.where(power < 0.0, -current / self.largest_charging_current, demand)
        return Fed(current, u * current, r * current * current, {Limit.BATTERY: demand})
