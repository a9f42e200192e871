"""Experiments on a virtual bench: the readings of a geared drive, with the errors of sensors and gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from infinivar._core.fields import given
from infinivar.calibration.geared import model
from infinivar.calibration.geared.data import Dynamometer
from infinivar.calibration.geared.model import Gains
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import motor_side, needed
from infinivar.study.rig import Rig


def dynamometer(
    drive: ConventionalDrive,
    rig: Rig,
    *,
    speed: np.ndarray,
    torque: np.ndarray,
    noise: Mapping[str, float],
    values: Mapping[str, float] | None = None,
    geared: bool = True,
    seed: int | None = 0,
) -> Dynamometer:
    """Measure a drive at steady points.

    Parameters
    ----------
    drive : ConventionalDrive       Drive to measure.
    rig : Rig                       Deviations of the gains.
    speed, torque : (n,) float      At the gearhead's output, or at the motor if not `geared`. [rad s^-1], [N m]
    noise : mapping                 Standard deviation of each signal that is recorded. [SI]
    values : mapping                True values of parameters in place of the drive's.
    seed : int                      Seed of the random errors; None for a bench without errors.

    Returns
    -------
    Dynamometer
    """
    signals = tuple(noise)
    exact = Dynamometer(
        speed=speed,
        torque=torque,
        geared=geared,
        read=np.zeros((len(speed), len(signals))),
        signals=signals,
        lines=tuple(range(2, len(speed) + 2)),
        name="virtual bench",
    )
    true = {**model.known_values(drive), **(values or {})}
    if seed is None:
        return replace(exact, read=exact.expected(drive, true, Gains()))
    random = np.random.default_rng(seed)
    gains = Gains(
        current=rig.current_gain_deviation * random.standard_normal(),
        torque=rig.torque_gain_deviation * random.standard_normal(),
    )
    # The drive moves the true torque; what stands in the file is the torque read.
    read = replace(exact, torque=torque * (1.0 + gains.torque))
    told = read.expected(drive, true, gains)
    return replace(read, read=told + np.asarray(list(noise.values())) * random.standard_normal(told.shape))


def swing(
    drive: ConventionalDrive,
    rig: Rig,
    *,
    duration: float,
    rate: float,
    amplitudes: Mapping[float, float],
    noise: Mapping[str, float],
    values: Mapping[str, float] | None = None,
    seed: int = 0,
) -> dict[str, np.ndarray]:
    """Record a pendulum that a drive swings along a sum of sines.

    Parameters
    ----------
    drive : ConventionalDrive   Drive to measure.
    rig : Rig                   Pendulum, and deviations of current gain and mass.
    duration, rate : float      [s], [Hz]
    amplitudes : mapping        Amplitude by frequency. [rad], [Hz]
    noise : mapping             Standard deviations of "angle" [rad], "current" [A] and, if recorded, "voltage" [V].
    values : mapping            True values of parameters in place of the drive's.
    seed : int                  Seed of the random errors.

    Returns
    -------
    dict   Columns under headings with units.

    Source: `infinivar.drivetrain.drive.motor_side`.
    """
    random = np.random.default_rng(seed)
    mass, length = needed(rig.pendulum_mass, "pendulum_mass"), needed(rig.pendulum_length, "pendulum_length")
    inertia = given(rig.pendulum_inertia, mass * length**2)
    heavier = 1.0 + rig.mass_deviation / mass * random.standard_normal()
    time = np.arange(round(duration * rate) + 1) / rate
    angle, speed, acceleration = (np.zeros_like(time) for _ in range(3))
    for frequency, amplitude in amplitudes.items():
        turn = 2.0 * np.pi * frequency
        angle = angle + amplitude * np.sin(turn * time)
        speed = speed + amplitude * turn * np.cos(turn * time)
        acceleration = acceleration - amplitude * turn**2 * np.sin(turn * time)
    torque = heavier * (inertia * acceleration + mass * rig.gravity * length * np.sin(angle))
    torque = torque + given(drive.output_inertia, 0.0) * acceleration
    true = {**model.known_values(drive), **(values or {})}
    side = motor_side(
        model.motor_with(drive.motor, true),
        model.gearhead_with(drive.gearhead, true),
        output_torque=torque,
        output_speed=speed,
        output_acceleration=acceleration,
    )
    gain = 1.0 + rig.current_gain_deviation * random.standard_normal()
    found = {
        "angle": ("rad", angle),
        "current": ("A", gain * np.asarray(side.states["motor_current_A"])),
        "voltage": ("V", np.asarray(side.states["motor_voltage_V"])),
    }
    read = {
        f"{name} [{unit}]": course + noise[name] * random.standard_normal(len(time))
        for name, (unit, course) in found.items()
        if name in noise
    }
    return {"time [s]": time, **read}
