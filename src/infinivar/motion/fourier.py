"""Periodic quantities as Fourier series: exact derivatives, and smoothing with a stated cutoff."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

_WAVES_AT_ONCE = 2**20
"""Harmonics times instants evaluated at once: 16 MB."""


_MANY = 2**20
"""Harmonics times instants above which equal steps are evaluated by fast convolution."""


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
        share = np.clip(2.0 * np.arange(most + 1) / (period * cutoff) - 1.0, 0.0, 1.0)
        spectrum *= 0.5 * (1.0 + np.cos(np.pi * share))
        return cls(period, spectrum.real, -spectrum.imag)

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the quantity and its time derivatives up to an order, at times [s]."""
        time = np.asarray(time, dtype=float)
        turns = 2.0 * np.pi * np.arange(len(self.cosine)) / self.period
        amplitudes = np.asarray(self.cosine) - 1j * np.asarray(self.sine)
        count, first = time.size, float(time.flat[0]) if time.size else 0.0
        if (
            time.ndim == 1
            and count > 2 * len(turns)
            and np.allclose(
                time, first + np.arange(count) * (self.period / count), rtol=1e-12, atol=1e-12 * self.period
            )
        ):
            # Equal steps over a whole cycle: a fast Fourier transform avoids the product of harmonics and instants.
            shifted = 0.5 * count * amplitudes * np.exp(1j * turns * first)
            shifted[0] *= 2.0
            return [np.fft.irfft(shifted * (1j * turns) ** order, count) for order in range(orders + 1)]
        if count * len(turns) > _MANY and time.ndim == 1 and _equal(time):
            step = (float(time[-1]) - first) / (count - 1)
            begun = amplitudes * np.exp(1j * turns * first)
            return [_on_grid(begun * (1j * turns) ** order, turns[1] * step, count) for order in range(orders + 1)]
        found = np.empty((orders + 1, count))
        at_once = max(1, _WAVES_AT_ONCE // len(turns))
        for begin in range(0, count, at_once):
            part = slice(begin, begin + at_once)
            waves = np.exp(1j * np.multiply.outer(time.ravel()[part], turns))
            for order in range(orders + 1):
                found[order, part] = np.real(waves @ (amplitudes * (1j * turns) ** order))
        return [row.reshape(time.shape) for row in found]

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


def _equal(time: np.ndarray) -> bool:
    """Whether times have equal steps, to rounding."""
    steps = np.diff(time)
    return bool(np.ptp(steps) <= 1e-9 * abs(steps[0]))


def _on_grid(amplitudes: np.ndarray, turn: float, count: int) -> np.ndarray:
    """Real part of ``sum over k of amplitudes[k] exp(i turn k j)`` for j from 0 to count - 1.

    With ``2 k j = k^2 + j^2 - (j - k)^2`` the sum is a convolution, evaluated by fast Fourier transforms.

    Source: bluestein1970.
    """
    waves = len(amplitudes)
    places = np.arange(max(count, waves), dtype=float)
    chirp = np.exp(0.5j * turn * places**2)
    size = 1 << (count + waves - 2).bit_length()
    kernel = np.zeros(size, dtype=complex)
    kernel[:count] = chirp[:count].conj()
    kernel[size - waves + 1 :] = chirp[waves - 1 : 0 : -1].conj()
    product = np.fft.ifft(np.fft.fft(amplitudes * chirp[:waves], size) * np.fft.fft(kernel))
    return np.real(product[:count] * chirp[:count])
