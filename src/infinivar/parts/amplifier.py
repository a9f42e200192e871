"""Motor amplifier: supply power for a motor power, and the handling of regenerated power."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from annotated_types import Ge, Interval

from infinivar._core.array_namespace import Array, namespace, signed_infinity
from infinivar._core.fields import check, component, given, quantity
from infinivar.errors import require
from infinivar.limits import Limit

Regeneration = Literal["burn", "store", "none"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Amplifier:
    """Amplifier between supply and motor.

    Negative motor power is dissipated in a brake resistor (``burn``, as in the paper), returned to the supply with
    `storage_efficiency` (``store``), or not accepted (``none``: the point exceeds the REGENERATION limit, and the power
    counts as dissipated).

    Raises
    ------
    ParameterError
        If a field is out of range, or if `storage_efficiency` is missing with ``store``.
    """

    regeneration: Regeneration = component("What happens to negative electrical power", default="burn")
    storage_efficiency: float | None = quantity(
        "1",
        Interval(ge=0, le=1),
        "Fraction of negative power returned to the supply; required with store",
        default=None,
    )
    efficiency: float = quantity("1", Interval(gt=0, le=1), "Power out over power in, in either direction", default=1.0)
    standby_power: float = quantity("W", Ge(0), "Power drawn at all times, with the motor running or not", default=0.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        if self.regeneration == "store":
            require(self.storage_efficiency is not None, "storage_efficiency", None, "set with regeneration = store")

    def supply(self, motor_power: Array) -> tuple[Array, Array, Mapping[Limit, Array]]:
        """Power drawn from the supply for a motor power.

        Parameters
        ----------
        motor_power : (...,) float   Electrical power at the motor, negative where it generates. [W]

        Returns
        -------
        power_in, loss : (...,) float   Power from the supply (negative only with ``store``) and loss, including brake
            resistor and standby. [W]
        utilisation : mapping           Of the regeneration limit, with ``none`` only.

        Source: faulring2006, section VI-C (regenerative resistor); store and none: energy balance.
        """
        xp = namespace(motor_power, self.efficiency, self.storage_efficiency, self.standby_power)
        drawn, returned = xp.clip(motor_power, 0.0, xp.inf), xp.clip(-motor_power, 0.0, xp.inf)
        kept = self.efficiency * given(self.storage_efficiency, 0.0) if self.regeneration == "store" else 0.0
        power_in = drawn / self.efficiency - kept * returned + self.standby_power
        loss = (1.0 / self.efficiency - 1.0) * drawn + (1.0 - kept) * returned + self.standby_power
        limits = {}
        if self.regeneration == "none":
            limits[Limit.REGENERATION] = signed_infinity(xp, returned)
        return power_in, loss, limits
