"""Power of a recorded motion over frequency, as its smoothing finds it, and the share that a cutoff removes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar.motion.fourier import equal_steps, passed
from infinivar.motion.runs import STRAIGHT, between

_ABOVE_NOISE = 4.0
"""Power of a frequency over the noise floor from which it counts as motion."""
_BAND = 9
"""Frequencies averaged to tell motion from noise."""


class Density(NamedTuple):
    """Power spectral density of a position.

    frequency, power : (n,) float   From the lowest frequency up. [Hz], [m^2/Hz, rad^2/Hz]
    floor : float                   Noise floor: median of the upper half of the frequencies. [m^2/Hz, rad^2/Hz]
    noise : float                   Standard deviation of the rows, if all frequencies had the median power of the upper half.
                                    [m, rad] or [m/s, rad/s]
    """

    frequency: np.ndarray
    power: np.ndarray
    floor: float
    noise: float

    @property
    def turn(self) -> np.ndarray:
        """Angular frequency. [rad/s]"""
        return 2.0 * np.pi * self.frequency

    @property
    def motion(self) -> np.ndarray:
        """Power of the speed above the noise floor. (n,) [m^2/s^2/Hz, rad^2/s^2/Hz]"""
        band = min(_BAND, len(self.power))
        smooth = np.convolve(self.power, np.ones(band) / band, mode="same")
        return np.where(
            smooth > _ABOVE_NOISE * self.floor, np.maximum(self.power - self.floor, 0.0) * self.turn**2, 0.0
        )

    def removed(self, cutoff: float, order: int = 1) -> float:
        """Share of the power above the noise floor of the speed, or a higher derivative, that a cutoff [Hz] removes. [-]"""
        motion = self.motion * self.turn ** (2 * (order - 1))
        return float(np.sum(motion * (1.0 - passed(self.frequency, cutoff) ** 2)) / (np.sum(motion) or 1.0))

    def below(self, share: float) -> float:
        """Frequency up to which a share of the speed's power above the noise floor lies. [Hz]"""
        sums = np.cumsum(self.motion)
        return float(self.frequency[min(int(np.searchsorted(sums, share * sums[-1])), len(sums) - 1)])


def density(time: np.ndarray, values: np.ndarray, field: str, order: int = STRAIGHT, *, closed: bool) -> Density:
    """Power spectral density of a recorded position, or of the position of a recorded speed, from equal steps.

    A cycle is a whole period, so its harmonics are exact without a window. Anything else is taken without the straight line
    through its ends, under a Hann window, which spreads a frequency to its two neighbours.

    Parameters
    ----------
    time, values : (n,) float   Recorded rows. [s], [m, rad] or [m/s, rad/s]
    field : str                 "position" or "speed".
    order : int                 Of the polynomials by which rows at unequal steps are resampled.
    closed : bool               Whether the rows are one cycle, both ends included.

    Source: welch1967, for one segment.
    """
    count = len(time) - 1
    lasts = float(time[-1] - time[0])
    even = values
    if not equal_steps(time):
        even = between(time - time[0], values, np.arange(count + 1) * (lasts / count), order, closed=closed)
    if field == "position":
        even = even - np.linspace(even[0], even[-1], count + 1)
    rows = even[:-1] - np.mean(even[:-1])
    window = np.ones(count) if closed else 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    power = 2.0 * lasts / count * np.abs(np.fft.rfft(rows * window)) ** 2 / np.sum(window**2)
    frequency = np.arange(1, len(power)) / lasts
    # Powers of noise are distributed exponentially: their median is ln 2 of their mean.
    noise = np.sqrt(np.median(power[1:][(len(power) - 1) // 2 :]) * count / (2.0 * np.log(2.0) * lasts))
    power = power[1:] / ((2.0 * np.pi * frequency) ** 2 if field == "speed" else 1.0)
    return Density(frequency, power, float(np.median(power[len(power) // 2 :])), float(noise))
