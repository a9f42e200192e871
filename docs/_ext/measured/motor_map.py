"""What explains a measured motor map: resistance, friction, and further losses one at a time and together."""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result

_MAP = Path(__file__).with_name("motor_map_d5065.toml")

LIGHT = 0.1
"""Shaft torque below which a point counts as unloaded: its efficiency mostly shows the zero of the torque sensor. [N m]"""

_SPEED = 300.0
"""Speed that makes the coefficients comparable. [rad s^-1]"""


@result
class MotorMap(Frozen):
    """Steady points of a motor on a dynamometer; arrays of equal length, SI.

    Attributes
    ----------
    speed, torque : at the shaft. [rad s^-1], [N m]
    efficiency : shaft power over input power. [-]
    row : number of the load at each speed, from 0 for the lightest.
    """

    speed: np.ndarray
    torque: np.ndarray
    efficiency: np.ndarray
    row: np.ndarray

    @property
    def power_in(self) -> np.ndarray:
        """Input power. [W]"""
        return self.torque * self.speed / self.efficiency

    @property
    def loaded(self) -> np.ndarray:
        """Mask of the points with load."""
        return self.torque > LIGHT


def published() -> MotorMap:
    """A published map of a brushless motor with its controller: 341 points.

    Source: parsons2019.
    """
    raw = tomllib.loads(_MAP.read_text("utf-8"))
    speed: np.ndarray = np.asarray(raw["speed_rpm"], dtype=float) * (math.pi / 30.0)
    torque: np.ndarray = np.asarray(raw["torque_Nm"], dtype=float)
    nominal: np.ndarray = np.asarray(speed * (0.3 / math.pi)).round()
    row = np.asarray([np.sum((nominal == nominal[i]) & (torque < torque[i])) for i in range(len(speed))])
    return MotorMap(speed=speed, torque=torque, efficiency=np.asarray(raw["efficiency_percent"]) / 100.0, row=row)


CANDIDATES: Mapping[str, tuple[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]] = FrozenDict(
    {
        "constant": (
            "a constant power: standby of the controller, or the zero of a sensor",
            lambda w, t: np.ones_like(w),
        ),
        "current": ("proportional to current: switching, dead time", lambda w, t: t),
        "eddy": ("proportional to speed squared: eddy currents, viscous friction", lambda w, t: (w / _SPEED) ** 2),
        "windage": ("proportional to speed cubed: windage", lambda w, t: (w / _SPEED) ** 3),
        "heating": ("proportional to torque to the fourth: a warmer winding, or saturation", lambda w, t: t**4),
        "alternating": (
            "torque squared times speed squared: resistance to alternating current",
            lambda w, t: (t * w / _SPEED) ** 2,
        ),
        "torque share": ("a share of the torque: gain of a sensor, load-dependent friction", lambda w, t: t * w),
        "slow friction": (
            "friction that falls with speed, as of a Stribeck bearing or a position-dependent torque",
            lambda w, t: w * math.e ** (-w / 100.0),
        ),
    }
)
"""Losses beside resistance and constant friction: what they may be, and their form in speed [rad s^-1] and torque [N m]."""


@result
class MapFit(Frozen):
    """A fit of losses to a motor map.

    Attributes
    ----------
    extra : names of the losses beside resistance and friction.
    values : ``R/K^2`` [W/(N m)^2], friction torque [N m], and the coefficient of each extra loss [W, in units of its form].
    deviations : standard deviations of the same, from the noise of the map.
    residual : fitted less measured efficiency, of all points. [-]
    chi_square : sum of squared deviations of the input power from the fit in units of noise, of the loaded points.
    """

    extra: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    residual: np.ndarray
    chi_square: float


def loss(values: np.ndarray, extra: Sequence[str], speed: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Loss of a motor: ``(R/K^2)(T + T_f)^2 + T_f w`` and the extra losses. [W]

    Parameters
    ----------
    values : (2 + k,) float        As in `MapFit`.
    extra : sequence               k names from `CANDIDATES`.
    speed, torque : (n,) float     [rad s^-1], [N m]

    Source: definition of the parts of `infinivar.parts.Motor`.
    """
    found = values[0] * (torque + values[1]) ** 2 + values[1] * speed
    for value, name in zip(values[2:], extra, strict=True):
        found = found + value * CANDIDATES[name][1](speed, torque)
    return found


def noise(measured: MotorMap) -> np.ndarray:
    """Standard deviation of the input power at each point, from second differences along each load. (n,) [W]

    A second difference of three neighbouring speeds removes whatever is straight, and leaves sqrt(6) times the noise. The map
    is first reduced by a fit, so that little else is left. Variance: ``a^2 + (b w)^2 + (c w T)^2``, by maximum likelihood.
    """
    from scipy.optimize import minimize

    usual = 0.5 + 0.012 * measured.speed
    rest = measured.power_in * _fitted(measured, (), usual, measured.loaded).residual
    found, speed, torque = [], [], []
    for row in range(1, int(measured.row.max()) + 1):
        places = np.flatnonzero((measured.row == row) & measured.loaded)
        places = places[np.argsort(measured.speed[places])]
        line = (rest * 1.0)[places] / measured.efficiency[places]
        found.append((line[:-2] - 2 * line[1:-1] + line[2:]) / math.sqrt(6.0))
        speed.append(measured.speed[places][1:-1])
        torque.append(measured.torque[places][1:-1])
    difference, w, t = map(np.concatenate, (found, speed, torque))

    def variance(q: np.ndarray, w: np.ndarray, t: np.ndarray) -> np.ndarray:
        a, b, c = np.exp(q)
        return a + b * w**2 + c * (w * t) ** 2

    def unlikely(q: np.ndarray) -> float:
        expected = variance(q, w, t)
        return float(np.sum(np.log(expected) + difference**2 / expected))

    best = minimize(unlikely, [-2.0, -9.0, -9.0], method="Nelder-Mead", options={"maxiter": 4000}).x
    return np.sqrt(variance(best, measured.speed, measured.torque))


def fit(measured: MotorMap, extra: Sequence[str] = (), sigma: np.ndarray | None = None) -> MapFit:
    """Fit losses to the loaded points of a map.

    Parameters
    ----------
    measured : MotorMap
    extra : sequence               Names from `CANDIDATES`.
    sigma : (n,) float             Noise of the input power, as from `noise`. [W]. None: equal weight of the efficiencies.

    Source: weighted nonlinear least squares.
    """
    return _fitted(measured, tuple(extra), sigma, measured.loaded)


def _fitted(measured: MotorMap, extra: tuple[str, ...], sigma: np.ndarray | None, used: np.ndarray) -> MapFit:
    from scipy.optimize import least_squares

    w, t, power = measured.speed, measured.torque, measured.torque * measured.speed

    def efficiency(values: np.ndarray) -> np.ndarray:
        return power / (power + loss(values, extra, w, t))

    def off(values: np.ndarray) -> np.ndarray:
        if sigma is None:
            return 100.0 * (efficiency(values) - measured.efficiency)[used]
        return ((power + loss(values, extra, w, t) - measured.power_in) / sigma)[used]

    start = np.concatenate([[50.0, 0.05], np.zeros(len(extra))])
    scale = np.concatenate([[50.0, 0.05], np.full(len(extra), 0.1)])
    found = least_squares(off, start, x_scale=scale)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    if sigma is None:
        covariance = covariance * 2.0 * found.cost / (used.sum() - start.size)
    return MapFit(
        extra=extra,
        values=found.x,
        deviations=np.sqrt(np.diag(covariance)),
        residual=efficiency(found.x) - measured.efficiency,
        chi_square=2.0 * found.cost,
    )


def across_speeds(measured: MotorMap, extra: Sequence[str], sigma: np.ndarray | None = None) -> float:
    """RMS error of the efficiency of each speed, predicted by a fit to all other speeds. [-]"""
    nominal = np.round(measured.speed * 30.0 / math.pi / 100.0)
    errors = []
    for speed in np.unique(nominal):
        out = (nominal == speed) & measured.loaded
        errors.append(_fitted(measured, tuple(extra), sigma, measured.loaded & ~out).residual[out])
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def ranked(measured: MotorMap, count: int, sigma: np.ndarray) -> list[MapFit]:
    """Fits with every combination of `count` candidates, the best first."""
    fits = [fit(measured, names, sigma) for names in itertools.combinations(CANDIDATES, count)]
    return sorted(fits, key=lambda one: one.chi_square)


def lack_of_fit(found: MapFit, points: int) -> float:
    """Factor by which the deviations exceed the noise, 1 for a complete model. [-]"""
    return math.sqrt(found.chi_square / (points - found.values.size))


def noise_floor(measured: MotorMap, sigma: np.ndarray) -> float:
    """RMS noise of the efficiencies of the loaded points. [-]"""
    of_efficiency = sigma * measured.efficiency / measured.power_in
    return float(np.sqrt(np.mean(of_efficiency[measured.loaded] ** 2)))
