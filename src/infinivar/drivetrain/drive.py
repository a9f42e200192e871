"""What every drive-train has in common: the point it returns, and the electrical end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from infinivar._xp import Array
from infinivar.limits import Limit
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.power import PowerPoint


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivePoint(PowerPoint):
    """Steady operating point of a drive-train; arrays that broadcast to one shape, SI.

    `losses` names every loss from supply to load [W]; `states` holds currents, voltages, angles and the like, each
    under a name that ends in its unit. Where a limit leaves no steady motion the powers are nan and `limit` says why.
    """

    power_in: Array
    power_out: Array
    losses: Mapping[str, Array]
    utilisation: Mapping[Limit, Array]
    states: Mapping[str, Array] = field(default_factory=dict)


@runtime_checkable
class Drive(Protocol):
    """A drive-train that moves a load along a line."""

    @property
    def motors(self) -> Mapping[str, Motor]:
        """Motors by role."""
        ...

    @property
    def gearhead(self) -> Gearhead:
        """Gearhead of the motor that moves the load."""
        ...

    def operate(self, *, speed: Array, force: Array) -> DrivePoint:
        """Steady point at a load speed [m s^-1] and force on the load [N], in all four quadrants.

        Must not depend on calls made at the same time: maps are computed on several threads.
        """
        ...


def electrical_side(
    amplifier: Amplifier, motor: Motor, gearhead: Gearhead, *, output_torque: Array, output_speed: Array
) -> tuple[Array, dict[str, Array], dict[Limit, Array], dict[str, Array]]:
    """Supply, amplifier, motor and gearhead behind an output torque and speed.

    Returns
    -------
    power_in : (...,) float          From the supply. [W]
    losses, utilisation, states      Of the three parts, by name.
    """
    gear = gearhead.operate(
        output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor.continuous_torque
    )
    electric = motor.operate(torque=gear.motor_torque, speed=gear.motor_speed)
    power_in, burnt, limits = amplifier.supply(electric.power)
    losses = {**electric.losses, "gearhead": gear.loss, "amplifier": burnt}
    utilisation = {**electric.utilisation, **gear.utilisation, **limits}
    states = {
        "motor_current_A": electric.current,
        "motor_voltage_V": electric.voltage,
        "motor_torque_Nm": gear.motor_torque,
        "motor_speed_rad_s": gear.motor_speed,
    }
    return power_in, losses, utilisation, states
