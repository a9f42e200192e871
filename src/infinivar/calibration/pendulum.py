r"""The bench of a pendulum that a geared drive swings: windows of a recording in the weak form of the equation of motion.

The pendulum hangs at angle 0 and needs the torque :math:`\tau_o = J \ddot\varphi + m g l \sin\varphi` at the gearhead's
output. Multiplied by a smooth function :math:`\psi` that vanishes with its slope at both ends of a window, and integrated,

.. math:: \int \psi \ddot\varphi\,dt = \int \ddot\psi \varphi\,dt, \qquad \int \psi \dot\varphi\,dt = -\int \dot\psi \varphi\,dt,

so the terms of inertia, gravity and back-emf follow from the recorded angle itself, which is never differentiated. Friction
depends on the direction and the load at each instant; these are taken from the smoothed recording, where a small error of a
derivative has a small effect. With the method "inverse", all terms are taken from the smoothed recording instead.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.fields import given
from infinivar._core.result import result
from infinivar.calibration.bench import Error
from infinivar.calibration.geared import GearedBench, gearhead_with, motor_with
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import shaft_inertia
from infinivar.errors import InputError
from infinivar.motion.runs import RunSeries
from infinivar.study.rig import Rig
from infinivar.tables.named import Named, read_named
from infinivar.units import plain

Method = Literal["weak", "inverse"]

COLUMNS = {"time": "s", "angle": "rad", "current": "A", "voltage": "V"}
"""Columns of a pendulum's recording with their SI units; the voltage is optional."""

_WINDOWS = 8
"""Windows per period of the dominant frequency."""

_CUTOFF = 10.0
"""Cutoff of the smoothing over the dominant frequency."""

_LEAST = 8
"""Fewest rows in a window."""

_SLOW = 0.01
_STILL = 0.25
"""A window whose speed is below `_SLOW` of the largest for more than this share of its rows is at rest."""


@result
class Pendulum(GearedBench):
    """Windows of a recorded pendulum; SI. Rows are windows, `sample_*` the recorded instants in them.

    Attributes
    ----------
    time : middle of each window. [s]
    read : (n, m) weighted means of the signals in the windows.
    signals : "current" and, if recorded, "voltage".
    start : (n,) index of the first sample of each window.
    weight : weight of each sample in its window; they add up to 1 in each.
    speed, acceleration, torque : smoothed output speed, acceleration, and torque on the pendulum, by sample.
    more_torque, more_acceleration, more_speed : (n,) weak forms less the means of the smoothed quantities.
    mass : mass of the pendulum, for its relative error. [kg]
    """

    time: np.ndarray
    read: np.ndarray
    signals: tuple[str, ...]
    start: np.ndarray
    weight: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray
    more_torque: np.ndarray
    more_acceleration: np.ndarray
    more_speed: np.ndarray
    mass: float
    lines: tuple[int, ...]
    name: str = "pendulum data"
    empty: Mapping[int, str] = dataclasses.field(default_factory=dict)

    kind = "pendulum"
    geared = True
    shared_errors = True  # noise of the angle is in the expected current, and thus in the expected voltage

    @property
    def abscissa(self) -> tuple[np.ndarray, str]:
        """What a figure shows the rows over, (n,), and its label."""
        return self.time, "time [s]"

    @property
    def usual(self) -> tuple[str, ...]:
        """Parameters fitted by default."""
        first = ("resistance",) if "voltage" in self.signals else ()
        return (*first, "torque_constant", "friction", "viscous", "load_share")

    def refusal(self, name: str) -> str | None:
        """Why a parameter cannot be fitted to these columns, or None."""
        if name == "resistance" and "voltage" not in self.signals:
            return "fitting the resistance requires a column voltage"
        return None

    def errors(self, rig: Rig) -> dict[str, Error]:
        """Errors of the gains: reading over true value, less 1. That of the torque is the balance's error of the mass."""
        return {"current": Error(rig.current_gain_deviation), "torque": Error(rig.mass_deviation / self.mass)}

    def chosen(self, rows: Any) -> Pendulum:
        """Select windows by index or mask."""
        places = np.arange(len(self))[rows]
        ends = [*self.start.tolist(), len(self.weight)]
        samples = [np.arange(ends[place], ends[place + 1]) for place in places.tolist()]
        kept = np.concatenate([np.zeros(0, dtype=int), *samples])
        lengths = np.asarray([len(one) for one in samples], dtype=int)
        by_window: dict[str, Any] = {
            name: getattr(self, name)[places]
            for name in ("time", "read", "more_torque", "more_acceleration", "more_speed")
        }
        by_sample: dict[str, Any] = {
            name: getattr(self, name)[kept] for name in ("weight", "speed", "acceleration", "torque")
        }
        return dataclasses.replace(
            self,
            **by_window,
            **by_sample,
            start=np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(int) if len(lengths) else lengths,
            lines=tuple(np.asarray(self.lines)[places].tolist()),
        )

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Weighted means of sampled values (..., samples) in the windows. (..., n)"""
        return np.add.reduceat(values * self.weight, self.start, axis=-1)

    def expected(
        self, drive: ConventionalDrive, rig: Rig, values: Mapping[str, Any], errors: Mapping[str, Array]
    ) -> np.ndarray:
        """Expected readings. (..., n, m)

        Source: `Gearhead.operate` and `Motor.operate`; weak form: integration by parts.
        """
        scale = 1.0 / (1.0 + errors.get("torque", 0.0))
        motor = motor_with(drive.motor, values)
        gear = gearhead_with(drive.gearhead, values)
        ratio = gear.ratio
        inertia = shaft_inertia(motor, gear)
        point = gear.operate(
            output_torque=scale * self.torque,
            output_speed=self.speed,
            motor_rated_torque=drive.motor.continuous_torque,
        )
        shaft = point.motor_torque + inertia * ratio * self.acceleration
        electric = motor.operate(torque=shaft, speed=point.motor_speed)
        more = (scale * self.more_torque / ratio + inertia * ratio * self.more_acceleration) / motor.torque_constant
        current = self._mean(np.asarray(electric.current)) + more
        turning = ratio * (self._mean(self.speed) + self.more_speed)
        found = {
            "current": (1.0 + errors.get("current", 0.0)) * current,
            "voltage": motor.resistance * current + motor.torque_constant * turning,
        }
        return np.stack(np.broadcast_arrays(*(found[name] for name in self.signals)), axis=-1)

    def faults(self) -> dict[int, str]:
        """Windows at rest, in which friction is unknown."""
        slow = np.abs(self.speed) < _SLOW * np.abs(self.speed).max(initial=0.0)
        share = np.add.reduceat(slow.astype(float), self.start) / np.diff(np.append(self.start, len(self.weight)))
        return {
            int(
                row
            ): f"from {plain(float(self.time[row]), 4)} s the pendulum rests, and friction holds in either direction"
            for row in np.flatnonzero(share > _STILL)
        }


def read_pendulum(
    file: str | Path,
    rig: Rig,
    drive: ConventionalDrive,
    *,
    method: Method = "weak",
    cutoff: float | None = None,
) -> Pendulum:
    """Read the recording of a pendulum on a drive.

    Parameters
    ----------
    file : str or Path    Columns ``time``, ``angle`` (0 hanging, positive as the torque), ``current`` and, if there,
        ``voltage`` of the motor, each with its unit.
    rig : Rig             With `pendulum_mass`, `pendulum_length` and, if known, `pendulum_inertia`.
    drive : ConventionalDrive
    method : "weak" or "inverse"   See the module.
    cutoff : float        Cutoff of the smoothing; ten times the dominant frequency by default. [Hz]

    Raises
    ------
    InputError
        If the file cannot be read or is too short, times do not increase, or the rig does not state the pendulum.
    """
    found = read_named(file, COLUMNS, ("time", "angle", "current"))
    return pendulum_of(str(file), found, rig, drive, method=method, cutoff=cutoff)


def pendulum_of(
    name: str,
    found: Named,
    rig: Rig,
    drive: ConventionalDrive,
    *,
    method: Method = "weak",
    cutoff: float | None = None,
) -> Pendulum:
    """Windows of a pendulum from the columns of a file; see `read_pendulum`."""
    columns, lines = found.columns, found.lines
    mass, length = rig.pendulum_mass, rig.pendulum_length
    if mass is None or length is None:
        raise InputError(f"{name}: data of a pendulum need pendulum_mass and pendulum_length in [rig]")
    time, angle = columns["time"] - columns["time"][0], columns["angle"]
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        raise InputError(f"{name}: line {lines[back[0] + 1]}, column 'time': must be later than in the row above")
    inertia = given(rig.pendulum_inertia, mass * length**2) + given(drive.output_inertia, 0.0)
    gravity = mass * rig.gravity * length
    dominant = _dominant(name, time, angle)
    even = np.linspace(0.0, time[-1], len(time))
    series = RunSeries.through(time, angle, np.interp(even, time, angle), cutoff or _CUTOFF * dominant)
    smooth, speed, acceleration = series.derivatives(time, 2)
    torque = inertia * acceleration + gravity * np.sin(smooth)
    edges = np.arange(0.0, time[-1], 1.0 / (_WINDOWS * dominant))
    borders = np.searchsorted(time, edges)
    first, last = borders[:-1], borders[1:]
    if len(first) < _WINDOWS or np.min(last - first) < _LEAST:
        raise InputError(
            f"{name}: must have at least {_LEAST} rows in each of {_WINDOWS} windows a period of "
            f"{plain(1.0 / dominant, 3)} s, for one period or more"
        )
    weights, slopes, bends = (np.zeros(borders[-1]) for _ in range(3))
    for begin, end, left, right in zip(first, last, edges[:-1], edges[1:], strict=True):
        weights[begin:end], slopes[begin:end], bends[begin:end] = _window(time[begin:end], left, right)
    inside = slice(0, int(borders[-1]))

    def mean(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
        return np.add.reduceat(values[inside] * weight, first)

    signals = tuple(one for one in ("current", "voltage") if one in columns)
    more_speed = -mean(angle, slopes) - mean(speed, weights)
    more_acceleration = mean(angle, bends) - mean(acceleration, weights)
    more_torque = inertia * more_acceleration + gravity * mean(np.sin(angle) - np.sin(smooth), weights)
    weak = 1.0 if method == "weak" else 0.0
    return Pendulum(
        time=0.5 * (edges[:-1] + edges[1:]) + columns["time"][0],
        read=np.stack([mean(columns[one], weights) for one in signals], axis=-1),
        signals=signals,
        start=first,
        weight=weights,
        speed=speed[inside],
        acceleration=acceleration[inside],
        torque=torque[inside],
        more_torque=weak * more_torque,
        more_acceleration=weak * more_acceleration,
        more_speed=weak * more_speed,
        mass=mass,
        lines=tuple(lines[first].tolist()),
        name=name,
        empty=found.empty,
    )


def _dominant(name: str, time: np.ndarray, angle: np.ndarray) -> float:
    """Frequency of the strongest harmonic of the angle. [Hz]"""
    even = np.linspace(0.0, time[-1], len(time))
    course = np.interp(even, time, angle)
    spectrum = np.abs(np.fft.rfft((course - course.mean()) * np.hanning(len(course))))
    if len(spectrum) < 3 or not spectrum.max() > 0:
        raise InputError(f"{name}: the angle does not change, so the pendulum shows nothing of the drive")
    return max(int(np.argmax(spectrum[1:])) + 1, 1) / float(time[-1])


def _window(time: np.ndarray, left: float, right: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights of samples in a window, for a mean, and for the weak first and second derivatives.

    The function is ``(1 - x^2)^4``. Weights of the derivatives are corrected so that sums of samples integrate straight lines
    and parabolas exactly: the second derivative of a constant, of t and of t^2 is exactly 0, 0 and 2.
    """
    half = 0.5 * (right - left)
    x = (time - 0.5 * (left + right)) / half
    step = np.gradient(time)
    inner = np.clip(1.0 - x**2, 0.0, None)
    weight = inner**4 * step
    total = math.fsum(weight)
    weight = weight / total
    slope = -8.0 * x * inner**3 / half * step / total
    bend = (-8.0 * inner**3 + 48.0 * x**2 * inner**2) / half**2 * step / total
    slope = _corrected(slope, x, (0.0, -1.0 / half, -2.0 * float(weight @ x) / half))
    bend = _corrected(bend, x, (0.0, 0.0, 2.0 / half**2))
    return weight, slope, bend


def _corrected(weights: np.ndarray, x: np.ndarray, moments: tuple[float, float, float]) -> np.ndarray:
    """Weights with exact moments 0 to 2 about the middle of the window, by the smallest change."""
    powers = np.stack([np.ones_like(x), x, x**2])
    lacking = np.asarray(moments) - powers @ weights
    return weights + powers.T @ np.linalg.solve(powers @ powers.T, lacking)
