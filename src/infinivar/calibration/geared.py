"""What benches of a geared drive have in common: its motor and gearhead, with fitted values in place of the study's."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from infinivar._core.fields import given
from infinivar.calibration.bench import Bench, Parameter
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.parts.gear_friction import GearFriction
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor

PARAMETERS = {
    "resistance": Parameter("ohm", "ohm", "terminal resistance of the motor", divides=True),
    "torque_constant": Parameter("N m/A", "mN m/A", "torque constant of the motor", divides=True),
    "motor_friction": Parameter("N m", "mN m", "friction torque of the motor that is independent of speed"),
    "motor_viscous": Parameter("N m s", "uN m s", "friction torque of the motor per speed"),
    "friction": Parameter("N m", "mN m", "friction torque of the gear at its output, F"),
    "viscous": Parameter("N m s", "mN m s", "friction torque of the gear per output speed, c"),
    "load_share": Parameter("1", "%", "friction per torque, of the load and of the motor alike, K_i = K_o", most=0.9),
    "friction_stribeck": Parameter("N m", "mN m", "additional friction torque of the gear at rest, F_s"),
    "stribeck_speed": Parameter(
        "rad/s", "rad/s", "output speed at which the additional friction falls to 1/e", divides=True
    ),
}
"""Parameters by name."""

SIGNALS = {"current": "A", "voltage": "V", "power": "W", "efficiency": "1"}
"""Electrical readings at the motor, with their SI units."""

OF_GEAR = ("friction", "viscous", "load_share", "friction_stribeck", "stribeck_speed")
"""Parameters of the gearhead, fitted only where it is on the bench."""


class GearedBench(Bench):
    """Readings of the motor of a conventional drive, alone or with its gearhead."""

    __slots__ = ()

    many = (
        "{name}: {count} of {whole} rows are impossible: check units and signs; the torque is that on the load, positive "
        "with the speed while the motor drives"
    )
    parameters: ClassVar[Mapping[str, Parameter]] = PARAMETERS
    units: ClassVar[Mapping[str, str]] = SIGNALS
    geared: bool
    """Whether the gearhead is on the bench."""

    def known(self, drive: ConventionalDrive) -> dict[str, float]:
        """The parameters as the study has them. [SI]"""
        return known_values(drive)

    def scales(self, drive: ConventionalDrive) -> dict[str, float]:
        """Values of the study, or a size that matters where they are smaller. [SI]"""
        natural = natural_scales(drive)
        return {name: max(value, natural[name]) for name, value in known_values(drive).items()}

    @abstractmethod
    def faults(self) -> dict[int, str]:
        """Reasons why rows cannot be used, by row."""


def known_values(drive: ConventionalDrive) -> dict[str, float]:
    """The parameters as the study has them, the gear's loss expressed by load-dependent friction."""
    motor = drive.motor
    friction = drive.gearhead.measured_friction(motor.continuous_torque)
    return {
        "resistance": motor.resistance,
        "torque_constant": motor.torque_constant,
        "motor_friction": motor.friction_torque,
        "motor_viscous": given(motor.viscous_friction, 0.0),
        "friction": friction.friction,
        "viscous": friction.viscous,
        "load_share": 0.5 * (friction.load_motor + friction.load_output),
        "friction_stribeck": friction.friction_stribeck,
        "stribeck_speed": friction.stribeck_speed,
    }


def natural_scales(drive: ConventionalDrive) -> dict[str, float]:
    """Sizes of the parameters that matter for a drive: friction of a tenth of its rated torque. [SI]"""
    motor, ratio = drive.motor, drive.gearhead.ratio
    torque, speed = 0.1 * motor.continuous_torque, motor.no_load_speed
    return {
        "resistance": motor.resistance,
        "torque_constant": motor.torque_constant,
        "motor_friction": torque,
        "motor_viscous": torque / speed,
        "friction": torque * ratio,
        "viscous": torque * ratio**2 / speed,
        "load_share": 0.1,
        "friction_stribeck": torque * ratio,
        "stribeck_speed": 1.0,
    }


def motor_with(motor: Motor, values: Mapping[str, Any]) -> Motor:
    """The motor with values from `PARAMETERS`; its no-load current follows from its friction."""
    constant, resistance = values["torque_constant"], values["resistance"]
    viscous = values["motor_viscous"]
    # K I0 = T + c w0 at the no-load speed w0 = (V - R I0)/K.
    idle = (values["motor_friction"] + viscous * motor.voltage / constant) / (
        constant + viscous * resistance / constant
    )
    return replace(
        motor,
        resistance=resistance,
        torque_constant=constant,
        no_load_current=idle,
        viscous_friction=viscous if np.all(np.asarray(viscous) > 0) else None,
    )


def gearhead_with(gear: Gearhead, values: Mapping[str, Any]) -> Gearhead:
    """The gearhead with measured friction from `PARAMETERS`."""
    share = values["load_share"]
    friction = replace(
        gear.friction or GearFriction(),
        friction=values["friction"],
        viscous=values["viscous"],
        load_motor=share,
        load_output=share,
        friction_stribeck=values["friction_stribeck"],
        stribeck_speed=values["stribeck_speed"],
    )
    return gear.with_measured(friction)
