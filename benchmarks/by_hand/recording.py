"""A recorded run through both drives behind a series spring as bare NumPy: energies, winding temperatures and limits.

The equations are those of the package, at the same instants; reading and smoothing a file is a function of its own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from benchmarks.by_hand import duty_cycle
from numpy.polynomial import polynomial

COPPER, WARM = 0.0039, 298.15
"""[1/K], [K]"""
_STEPS_PER_TIME_CONSTANT = 50


class Run(NamedTuple):
    """A smoothed quantity: sines over a continued run that starts `lead` before it, and a straight line."""

    lead: float
    length: float
    cosine: np.ndarray
    sine: np.ndarray
    line: np.ndarray


def read(file: str, cutoff: float) -> tuple[float, Run, Run]:
    """Duration [s], position [m] and force [N] of a file with the columns s, mm and N.

    The ends are continued about a parabola from a cubic through the first period of the cutoff, as the package does where
    the fourth order does not show and noise does not dominate.
    """
    time, position, force = np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)
    return float(time[-1] - time[0]), smooth(time, 1e-3 * position, cutoff), smooth(time, force, cutoff)


def smooth(time: np.ndarray, values: np.ndarray, cutoff: float) -> Run:
    """Smooth one column of a run."""
    time = time - time[0]
    steps = 2 * len(time)
    step = time[-1] / steps
    even = np.interp(np.arange(steps + 1) * step, time, values)
    count = int(np.ceil(3.0 / (cutoff * step)))
    ahead = np.arange(1, count + 1) * step
    first = time <= 1.0 / cutoff
    begin = polynomial.polyfit(time[first], values[first], 3)
    end = polynomial.polyfit(time[first], values[::-1][first], 3)
    before = 2.0 * (begin[0] + begin[2] * ahead**2) - even[1 : count + 1]
    after = 2.0 * (end[0] + end[2] * ahead**2) - even[-2 : -count - 2 : -1]
    whole = np.concatenate([before[::-1], even, after])
    slope = (whole[-1] - whole[0]) / (len(whole) - 1)
    rest = whole - whole[0] - slope * np.arange(len(whole))
    spectrum = np.fft.rfft(np.concatenate([rest[:-1], -rest[:0:-1]])) / (2 * (len(rest) - 1))
    length = 2 * (len(rest) - 1) * step
    most = int(cutoff * length)
    harmonics = 2.0 * spectrum[: most + 1]
    harmonics[0] *= 0.5
    share = np.clip(2.0 * np.arange(most + 1) / (length * cutoff) - 1.0, 0.0, 1.0)
    harmonics *= 0.5 * (1.0 + np.cos(np.pi * share))
    line = np.array([whole[0] + slope / step * count * step, slope / step])
    return Run(count * step, length, harmonics.real, -harmonics.imag, line)


def derivatives(run: Run, time: np.ndarray, orders: int) -> np.ndarray:
    """A quantity and its derivatives at equal steps, as a chirp transform: one kernel for all orders."""
    turns = 2.0 * np.pi * np.arange(len(run.cosine)) / run.length
    count, waves, step = len(time), len(turns), time[1] - time[0]
    places = np.arange(max(count, waves))
    chirp = np.exp(0.5j * turns[1] * step * places**2)
    size = 1 << (count + waves - 2).bit_length()
    kernel = np.zeros(size, dtype=complex)
    kernel[:count] = chirp[:count].conj()
    kernel[size - waves + 1 :] = chirp[waves - 1 : 0 : -1].conj()
    kernel = np.fft.fft(kernel)
    begun = (run.cosine - 1j * run.sine) * np.exp(1j * turns * (time[0] + run.lead)) * chirp[:waves]
    found = np.empty((orders + 1, count))
    for order in range(orders + 1):
        product = np.fft.ifft(np.fft.fft(begun * (1j * turns) ** order, size) * kernel)
        found[order] = np.real(product[:count] * chirp[:count])
    found[0] += run.line[0] + run.line[1] * time
    found[1] += run.line[1]
    return found


def through_drives(p: dict[str, Any], duration: float, position: Run, force: Run) -> dict[str, Any]:
    """Energies [J], highest winding temperatures [K] and highest demands of both drives over the run."""
    time = (np.arange(p["instants"]) + 0.5) * (duration / p["instants"])
    x, f = derivatives(position, time, 6), derivatives(force, time, 4)
    pull = p["load_mass"] * x[2:] - f
    moved = x[:5] + pull / p["spring"]
    return {"cobotic": _cobotic(p, time, duration, moved, pull), "geared": _geared(p, time, duration, moved, pull)}


def _cobotic(p: dict[str, Any], time: np.ndarray, duration: float, x: np.ndarray, pull: np.ndarray) -> dict[str, Any]:
    course = {
        **dict(zip(("speed", "acceleration", "jerk", "snap"), x[1:], strict=True)),
        **dict(zip(("force", "force_rate", "force_curvature"), -pull[:3], strict=True)),
    }
    current, steered, rate, force = duty_cycle.states({**p, "load_mass": 0.0}, course)
    turning = p["gear_ratio"] * p["cylinder_speed"]
    constant = p["torque_constant"] * p["no_load_current"]
    hot = temperatures(p["heat"]["motor"], current, np.full(len(time), constant * turning), duration)
    rubbed = p["steering_constant"] * p["steering_no_load"] * p["steering_ratio"] * np.abs(rate)
    steering_hot = temperatures(p["heat"]["steering"], steered, rubbed, duration)
    resistance = warm(p["resistance"], p["heat"]["motor"], hot, time)
    steering_resistance = warm(p["steering_resistance"], p["heat"]["steering"], steering_hot, time)
    power = duty_cycle.cylinder_power(p, current, resistance)
    power = power + duty_cycle.steering_power(p, steered, rate, steering_resistance)
    voltage = duty_cycle.voltage(p, current, resistance)
    across = duty_cycle.steering_voltage(p, steered, rate, steering_resistance)
    return {
        "energy": np.mean(power) * duration,
        "winding": hot[1].max(),
        "steering winding": steering_hot[1].max(),
        "voltage": np.max(np.abs(voltage)) / p["voltage"],
        "steering voltage": np.max(np.abs(across)) / p["steering_voltage"],
        "speed": turning / p["max_speed"],
        "steering speed": np.max(np.abs(rate)) * p["steering_ratio"] / p["steering_max_speed"],
        "slip": np.max(np.abs(force)),
    }


def _geared(p: dict[str, Any], time: np.ndarray, duration: float, x: np.ndarray, pull: np.ndarray) -> dict[str, Any]:
    radius, ratio, constant = p["pulley_radius"], p["large_ratio"], p["large_constant"]
    torque = (pull[0] + p["drag"] * np.sign(x[1])) * radius + p["output_inertia"] * x[2] / radius
    speed, way = ratio * x[1] / radius, np.sign(x[1])
    friction = (1.0 - p["large_efficiency"]) * p["large_torque"] * way
    driven = torque / ratio + friction + p["large_rotor"] * ratio * x[2] / radius
    current = driven / constant + p["large_no_load"] * way
    hot = temperatures(p["heat"]["large"], current, constant * p["large_no_load"] * np.abs(speed), duration)
    voltage = current * warm(p["large_resistance"], p["heat"]["large"], hot, time) + constant * speed
    return {
        "energy": np.mean(np.maximum(voltage * current, 0.0)) * duration,
        "winding": hot[1].max(),
        "voltage": np.max(np.abs(voltage)) / p["voltage"],
        "speed": np.max(np.abs(speed)) / p["large_max_speed"],
    }


def temperatures(
    motor: dict[str, float], current: np.ndarray, friction: np.ndarray, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times and winding temperatures of two thermal masses, exact over steps of constant power."""
    count = min(int(max(np.ceil(_STEPS_PER_TIME_CONSTANT * duration / motor["winding_lag"]), 8)), 4000)
    edges = np.linspace(0, len(current), count + 1).astype(int)
    widths = np.diff(edges)
    joule = motor["resistance"] * np.add.reduceat(current**2, edges[:-1]) / widths
    rubbed = np.add.reduceat(friction, edges[:-1]) / widths
    inner, outer = motor["inner"], motor["outer"]
    winding, housing = motor["winding_lag"] / inner, motor["housing_lag"] / outer
    a = (joule * COPPER - 1.0 / inner) / winding
    b, c, d = 1.0 / (inner * winding), 1.0 / (inner * housing), -(1.0 / inner + 1.0 / outer) / housing
    first, second = joule * (1.0 - COPPER * WARM) / winding, (rubbed + WARM / outer) / housing
    time = widths * (duration / len(current))
    mean, spread = 0.5 * (a + d), np.sqrt((0.5 * (a - d)) ** 2 + b * c)
    even = np.exp(mean * time) * np.cosh(spread * time)
    odd = np.exp(mean * time) * np.sinh(spread * time) / spread
    determinant = a * d - b * c
    still = (-(d * first - b * second) / determinant, -(a * second - c * first) / determinant)
    found = np.empty(count + 1)
    found[0] = w = h = WARM
    for place in range(count):
        away, off = w - still[0][place], h - still[1][place]
        half = 0.5 * (a[place] - d)
        w = still[0][place] + (even[place] + half * odd[place]) * away + b * odd[place] * off
        h = still[1][place] + c * odd[place] * away + (even[place] - half * odd[place]) * off
        found[place + 1] = w
    return edges * (duration / len(current)), found


def warm(
    resistance: float, motor: dict[str, float], hot: tuple[np.ndarray, np.ndarray], time: np.ndarray
) -> np.ndarray:
    """Resistance of a winding at each instant. [ohm]"""
    return resistance * (1.0 + COPPER * (np.minimum(np.interp(time, *hot), motor["permissible"]) - WARM))
