"""The bench of a dynamometer: steady points of a motor, with or without its gearhead."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.result import result
from infinivar.calibration.bench import Error
from infinivar.calibration.geared import OF_GEAR, SIGNALS, GearedBench, gearhead_with, motor_with
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError
from infinivar.study.rig import Rig
from infinivar.tables.named import Named, read_named
from infinivar.units import plain

PLACED = {"speed": "rad/s", "torque": "N m", "motor_speed": "rad/s", "motor_torque": "N m"}
"""Speed and torque, at the gearhead's output or at the motor's shaft, with their SI units."""

COLUMNS = {**PLACED, **SIGNALS}

_GAIN = 0.05
"""Share of the largest input power by which the output power may exceed the input, for sensor errors."""


@result
class Dynamometer(GearedBench):
    """Steady points of a motor with or without its gearhead: arrays of equal length, SI.

    Attributes
    ----------
    speed, torque : at the gearhead's output, or at the motor's shaft; the torque is that on the load, so that the power is
        positive while the motor drives. [rad s^-1], [N m]
    geared : whether the gearhead is on the bench.
    read : (n, m) readings, by column in the order of `signals`.
    signals : names from `SIGNALS`.
    lines, name, empty : see `Bench`.
    """

    speed: np.ndarray
    torque: np.ndarray
    geared: bool
    read: np.ndarray
    signals: tuple[str, ...]
    lines: tuple[int, ...]
    name: str = "dynamometer data"
    empty: Mapping[int, str] = dataclasses.field(default_factory=dict)

    kind = "dynamometer"

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Columns under headings with units, in the format that `read` accepts."""
        head = "" if self.geared else "motor_"
        found = {f"{head}speed [rad/s]": self.speed, f"{head}torque [N m]": self.torque}
        for place, name in enumerate(self.signals):
            percent = name == "efficiency"
            unit, scale = ("%", 100.0) if percent else (SIGNALS[name], 1.0)
            found[f"{name} [{unit}]"] = scale * self.read[:, place]
        return found

    @property
    def abscissa(self) -> tuple[np.ndarray, str]:
        """What a figure shows the rows over, (n,), and its label."""
        return self.torque, "torque on the load [N m]"

    @property
    def usual(self) -> tuple[str, ...]:
        """Parameters fitted by default."""
        motor = (*(("resistance",) if self.signals != ("current",) else ()), "torque_constant")
        return (
            (*motor, "friction", "viscous", "load_share")
            if self.geared
            else (*motor, "motor_friction", "motor_viscous")
        )

    def refusal(self, name: str) -> str | None:
        """Why a parameter cannot be fitted to these columns, or None."""
        if name == "resistance" and self.signals == ("current",):
            return "fitting the resistance requires a column voltage, power or efficiency"
        if name in OF_GEAR and not self.geared:
            return f"{name} belongs to the gearhead, but the torque was measured at the motor"
        return None

    def errors(self, rig: Rig) -> dict[str, Error]:
        """Errors of the gains: reading over true value, less 1. Other errors of speed and torque count with the readings."""
        current = rig.current_gain_deviation if "current" in self.signals else 0.0
        return {"current": Error(current), "torque": Error(rig.torque_gain_deviation)}

    def expected(
        self, drive: ConventionalDrive, rig: Rig, values: Mapping[str, Any], errors: Mapping[str, Array]
    ) -> np.ndarray:
        """Expected readings. (..., n, m)

        Source: `Gearhead.operate` and `Motor.operate`.
        """
        torque, speed = self.torque / (1.0 + errors.get("torque", 0.0)), self.speed
        motor = motor_with(drive.motor, values)
        if self.geared:
            gear = gearhead_with(drive.gearhead, values)
            point = gear.operate(
                output_torque=torque, output_speed=speed, motor_rated_torque=drive.motor.continuous_torque
            )
            shaft, turning = point.motor_torque, point.motor_speed
        else:
            shaft, turning = torque, speed
        electric = motor.operate(torque=shaft, speed=turning)
        delivered = np.asarray(self.torque * self.speed)
        found = {
            "current": (1.0 + errors.get("current", 0.0)) * electric.current,
            "voltage": electric.voltage,
            "power": electric.power,
            "efficiency": delivered / np.where(electric.power == 0, np.nan, electric.power),
        }
        return np.stack(np.broadcast_arrays(*(found[name] for name in self.signals)), axis=-1)

    def faults(self) -> dict[int, str]:
        """Rows that no drive can produce, or that say nothing, with reasons."""
        return {row: said for row in range(len(self)) if (said := self._fault(row)) is not None}

    def _fault(self, row: int) -> str | None:
        power = float(self.speed[row] * self.torque[row])
        values = dict(zip(self.signals, self.read[row].tolist(), strict=True))
        if self.speed[row] == 0:
            return "speed is 0: friction holds in either direction, so a point at rest gives no friction torque"
        if "efficiency" in values:
            efficiency = values["efficiency"]
            if power < 0:
                return "torque opposes the speed, where an efficiency has two meanings: state the power instead"
            if not 0 <= efficiency <= 1:
                return f"efficiency must be within 0 and 1, got {plain(efficiency)}"
        supplied = values.get("power")
        if supplied is None and {"current", "voltage"} <= set(values):
            supplied = values["current"] * values["voltage"]
        if supplied is not None and power - supplied > _GAIN * max(abs(power), abs(supplied)) + self._idle:
            return f"the load receives {plain(power, 3)} W from {plain(supplied, 3)} W"
        return None

    @property
    def _idle(self) -> float:
        """Power below which a gain of power may be noise. [W]"""
        return 0.01 * float(np.max(np.abs(self.speed * self.torque), initial=0.0))


def read_dynamometer(file: str | Path, ratio: float) -> Dynamometer:
    """Read steady points of a dynamometer.

    Parameters
    ----------
    file : str or Path   Columns ``speed`` and ``torque`` at the gearhead's output (or ``motor_speed`` with ``torque``), or
        ``motor_speed`` and ``motor_torque`` at the motor's shaft; then one or more of ``current``, ``voltage``, ``power`` and
        ``efficiency``, of the motor. Each heading states its unit.
    ratio : float        Motor speed over output speed. [-]

    Returns
    -------
    Dynamometer

    Raises
    ------
    InputError
        If the file cannot be read, a column or unit is missing or wrong, or a cell is not a number.
    """
    return dynamometer_of(str(file), read_named(file, COLUMNS, ()), ratio)


def dynamometer_of(name: str, found: Named, ratio: float) -> Dynamometer:
    """Points of a dynamometer from the columns of a file; see `read_dynamometer`."""
    columns = found.columns
    torque = [name for name in ("torque", "motor_torque") if name in columns]
    speed = [name for name in ("speed", "motor_speed") if name in columns]
    signals = tuple(name for name in SIGNALS if name in columns)
    for there, required in ((torque, "torque or motor_torque"), (speed, "speed or motor_speed")):
        if len(there) != 1:
            had = "both are there" if there else f"neither is among those read: {', '.join(columns) or 'none'}"
            raise InputError(f"{name}: must have one of the columns {required}; {had}")
    if (torque[0], speed[0]) == ("motor_torque", "speed"):
        raise InputError(f"{name}: motor_torque needs the speed of the motor, motor_speed")
    if not signals:
        raise InputError(f"{name}: must have a column current, voltage, power or efficiency of the motor")
    turning = columns[speed[0]]
    return Dynamometer(
        speed=turning / ratio if (torque[0], speed[0]) == ("torque", "motor_speed") else turning,
        torque=columns[torque[0]],
        geared=torque[0] == "torque",
        read=np.stack([columns[name] for name in signals], axis=-1),
        signals=signals,
        lines=tuple(found.lines.tolist()),
        name=name,
        empty=found.empty,
    )
