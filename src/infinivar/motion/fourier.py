"""Periodic quantities as Fourier series: exact derivatives, and smoothing with a stated cutoff."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

_WAVES_AT_ONCE = 2**20
"""Harmonics times instants evaluated at once: 16 MB."""


_MANY = 2**20
"""Harmonics times instants above which equal steps are evaluated by fast convolution."""

_WIDEST = 8
"""Largest number of steps in a period, relative to the requested instants, that are evaluated to use a part of them."""
_FEWEST = 2
"""Fewest instants that have a step."""


@dataclass(frozen=True, slots=True)
class Series:
    """``sum over k of cosine[k] cos(2 pi k t/period) + sine[k] sin(2 pi k t/period)``, k from 0. Any unit, [s]."""

    period: float
    cosine: np.ndarray
    sine: np.ndarray

    @classmethod
    def through(cls, period: float, values: np.ndarray, cutoff: float) -> Series:
        """Fit a series to values at equal steps from time 0, with a low-pass filter.

        Harmonics up to half of `cutoff` [Hz] pass unchanged, those from `cutoff` up are removed, and a raised cosine
        attenuates those in between, which rings less than a sharp edge.
        """
        count = len(values)
        spectrum = np.fft.rfft(values) / count
        most = min(int(cutoff * period), (count - 1) // 2)
        spectrum = spectrum[: most + 1].copy()
        spectrum[1:] *= 2.0
        spectrum *= passed(np.arange(most + 1) / period, cutoff)
        return cls(period, spectrum.real, -spectrum.imag)

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the quantity and its time derivatives up to an order, at times [s]."""
        time = np.asarray(time, dtype=float)
        turns = 2.0 * np.pi * np.arange(len(self.cosine)) / self.period
        amplitudes = np.asarray(self.cosine) - 1j * np.asarray(self.sine)
        count, first = time.size, float(time.flat[0]) if time.size else 0.0
        powers = (1j * turns) ** np.arange(orders + 1)[:, None]
        whole = self._steps_per_period(time)
        if count <= whole <= _WIDEST * count and whole > 2 * len(turns):
            # Equal steps that fill a cycle: a fast Fourier transform avoids the product of harmonics and instants.
            shifted = 0.5 * whole * amplitudes * np.exp(1j * turns * first)
            shifted[0] *= 2.0
            return [np.fft.irfft(row, whole)[:count] for row in shifted * powers]
        if count * len(turns) > _MANY and time.ndim == 1 and equal_steps(time):
            step = (float(time[-1]) - first) / (count - 1)
            begun = amplitudes * np.exp(1j * turns * first)
            return _on_grid(begun * powers, turns[1] * step, count)
        found = np.empty((orders + 1, count))
        at_once = max(1, _WAVES_AT_ONCE // len(turns))
        for begin in range(0, count, at_once):
            part = slice(begin, begin + at_once)
            waves = np.exp(1j * np.multiply.outer(time.ravel()[part], turns))
            for order in range(orders + 1):
                found[order, part] = np.real(waves @ (amplitudes * powers[order]))
        return [row.reshape(time.shape) for row in found]

    def _steps_per_period(self, time: np.ndarray) -> int:
        """Whole number of equal steps of times that make up a period; 0 if there is none."""
        if time.ndim != 1 or time.size < _FEWEST:
            return 0
        first, step = float(time[0]), float(time[-1] - time[0]) / (time.size - 1)
        whole = round(self.period / step) if step > 0 else 0
        if whole < time.size:
            return 0
        even = first + np.arange(time.size) * (self.period / whole)
        return whole if np.allclose(time, even, rtol=1e-12, atol=1e-12 * self.period) else 0

    def integral(self) -> Series:
        """Integrate the series without its mean, starting at 0."""
        turns = 2.0 * np.pi * np.arange(len(self.cosine)) / self.period
        turns[0] = np.inf
        cosine, sine = -np.asarray(self.sine) / turns, np.asarray(self.cosine) / turns
        cosine[0] = -np.sum(cosine[1:])
        return Series(self.period, cosine, sine)

    def scaled(self, factor: float) -> Series:
        """Multiply the series by a factor."""
        return Series(self.period, factor * np.asarray(self.cosine), factor * np.asarray(self.sine))


def passed(frequency: np.ndarray, cutoff: float) -> np.ndarray:
    """Share of an amplitude that a low-pass filter with a cutoff passes, at frequencies. [-], [Hz]"""
    share = np.clip(2.0 * frequency / cutoff - 1.0, 0.0, 1.0)
    return 0.5 * (1.0 + np.cos(np.pi * share))


def equal_steps(time: np.ndarray) -> bool:
    """Whether times have equal steps, to rounding."""
    steps = np.diff(time)
    return bool(np.ptp(steps) <= 1e-9 * abs(steps[0]))


def _on_grid(amplitudes: np.ndarray, turn: float, count: int) -> list[np.ndarray]:
    """Real part of ``sum over k of amplitudes[k] exp(i turn k j)`` for j from 0 to count - 1, for each row of amplitudes.

    With ``2 k j = k^2 + j^2 - (j - k)^2`` the sum is a convolution, evaluated by fast Fourier transforms.

    Source: bluestein1970.
    """
    waves = amplitudes.shape[-1]
    places = np.arange(max(count, waves), dtype=float)
    chirp = np.exp(0.5j * turn * places**2)
    size = 1 << (count + waves - 2).bit_length()
    kernel = np.zeros(size, dtype=complex)
    kernel[:count] = chirp[:count].conj()
    kernel[size - waves + 1 :] = chirp[waves - 1 : 0 : -1].conj()
    kernel = np.fft.fft(kernel)
    products = (np.fft.ifft(np.fft.fft(row * chirp[:waves], size) * kernel) for row in amplitudes)
    return [np.real(product[:count] * chirp[:count]) for product in products]
