"""Experiment on a virtual bench: the readings of a geared drive, with the errors of sensors and gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from infinivar.calibration.geared import model
from infinivar.calibration.geared.data import Dynamometer
from infinivar.calibration.geared.model import Gains
from infinivar.drivetrain.conventional import ConventionalDrive
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
