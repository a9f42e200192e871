"""Cylinder speed policies: nominal, optimal constant, scheduled in time, or free-running on its inertia.

The cylinder speed is a free choice, as the wheel converts it to any link speed. A slower cylinder has lower idle losses, but
requires larger steering angles, more steering power and a larger wheel force; a varying speed exchanges kinetic energy.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.result import Result, result
from infinivar.analysis.cycles import performance
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import MovingPoint
from infinivar.errors import ParameterError
from infinivar.motion.duty_cycles import DutyCycle, Instants
from infinivar.transmission.rates import Varying

_LEAST, _PER_WAVE = 200, 10
"""Instants per cycle, and per shortest wave, during the search; the result is evaluated with all instants."""

RANGE = (0.1, 4.0)
"""Lowest and highest speed of the search, constant or scheduled, over the nominal speed."""
_FACTORS = np.geomspace(*RANGE, 60)
"""Constant speeds of the search, over the nominal speed."""
_DENSE, _BETWEEN = 500, 1e-4
"""Instants at which a schedule is held against the range, and the most that it exceeds their values in between."""
_CONSTANT = 1e-3
"""Relative variation of a schedule below which it counts as a constant speed."""
HARMONICS = 3
LARGEST_SWING = 1.5
"""Largest harmonic amplitude of the logarithm of the speed."""
_STEP = 1e-6
"""Step of the parameters for differences."""
_STEEPNESS = 50.0
"""Penalty on the power per unit of excess demand."""
_INSIDE = 0.99
"""Demand from which the penalty applies, as a result with few instants must hold with all."""


@result
class Policy(Result):
    """One way to run the cylinder through a duty cycle.

    Attributes
    ----------
    name                    Display name.
    power_in : float        Mean power from the supply, windings at 25 °C; nan if infeasible. [W]
    slowest, fastest        Lowest and highest speed of the cylinder. [rad s^-1]
    cylinder_speed          Speed at the instants of the cycle; None if constant. [rad s^-1] ...
    feasible : bool         Whether every limit is kept.
    steering : float        Share of the steering motor in the power. [-]
    """

    name: str
    power_in: float
    slowest: float
    fastest: float
    cylinder_speed: Varying | None
    feasible: bool
    steering: float


def policies(drive: CoboticDrive, duty: DutyCycle) -> tuple[Policy, ...]:
    """Compare cylinder speed policies of a drive in a duty cycle.

    Parameters
    ----------
    drive : CoboticDrive   Drive with inertias. Without the cylinder's inertia, and over a run, after which the cylinder need
                           not turn as at the start, only constant speeds are compared.
    duty : DutyCycle

    Returns
    -------
    tuple of Policy   The nominal speed; the constant speed of lowest power within limits; the periodic speed of lowest
        power, its logarithm a series of three harmonics; and the inertia as a flywheel at the nominal mean speed. The search
        for the second and third is confined to `RANGE` times the nominal speed.

    Raises
    ------
    ParameterError
        If the drive has no cylinder, or lacks a value that motion requires.

    Source: lowest mean power by search (`scipy.optimize`); inverse dynamics as in faulring2006, section VI-C.
    """
    if not isinstance(drive, CoboticDrive):
        raise ParameterError(f"a drive of type {type(drive).__name__} has no cylinder whose speed could be chosen")
    fine = duty.instants(orders=drive.orders)
    own = _evaluated("as given", drive, duty, fine, None)
    speed = best_speed(drive, duty)
    chosen = _evaluated("chosen for the cycle", replace(drive, cylinder_speed=speed), duty, fine, None)
    if drive.cylinder_inertia is None or not duty.closed:
        return own, chosen
    scheduled = _evaluated("scheduled in time", drive, duty, fine, best_schedule(drive, duty, start=speed)(fine.time))
    coasting = drive.coast(fine.course, period=np.asarray(duty.period), load_mass=duty.moved_mass)
    return own, chosen, scheduled, _evaluated("inertia as a flywheel", drive, duty, fine, coasting)


def best_speed(drive: CoboticDrive, duty: DutyCycle) -> float:
    """Constant cylinder speed of lowest mean power within limits, or of smallest excess if infeasible. [rad s^-1]"""
    from scipy.optimize import minimize_scalar

    instants = duty.instants(duty.samples(_LEAST, _PER_WAVE), drive.orders)

    load = drive.inward(instants.course, duty.moved_mass)

    def cost(factor: float) -> float:
        driven = replace(drive, cylinder_speed=drive.cylinder_speed * factor)
        return float(_penalised(driven.follow(instants.course, load_mass=duty.moved_mass, behind=load)))

    costs = [cost(float(factor)) for factor in _FACTORS]
    place = int(np.argmin(costs))
    low, high = _FACTORS[max(place - 1, 0)], _FACTORS[min(place + 1, len(_FACTORS) - 1)]
    refined: Any = minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 1e-4})
    factor = refined.x if refined.fun < costs[place] else _FACTORS[place]
    return drive.cylinder_speed * float(factor)


def best_schedule(drive: CoboticDrive, duty: DutyCycle, *, start: float) -> Callable[[np.ndarray], Varying]:
    """Periodic cylinder speed of lowest mean power within limits and `RANGE`, as a function of time [s].

    The search starts from the constant speed `start`; its result is never worse, and `start` itself if it does not vary.
    """
    from scipy.optimize import minimize

    instants = duty.instants(duty.samples(_LEAST, _PER_WAVE), drive.orders)
    load = drive.inward(instants.course, duty.moved_mass)
    low, high = np.log(RANGE)
    level = np.clip(np.log(start / drive.cylinder_speed), low, high)

    def swing(parameters: np.ndarray) -> np.ndarray:
        """Logarithm of the speed over the nominal one."""
        return np.log(schedule(1.0, duty.period, parameters, np.linspace(0.0, duty.period, _DENSE)).value)

    def cost(parameters: np.ndarray) -> np.ndarray:
        """For parameters (..., m)."""
        speed = schedule(drive.cylinder_speed, duty.period, parameters, instants.time)
        return _penalised(drive.follow(instants.course, load_mass=duty.moved_mass, cylinder_speed=speed, behind=load))

    def confined(parameters: np.ndarray) -> np.ndarray:
        drawn, course = cost(parameters), swing(parameters)
        outside = np.maximum(np.max(course, axis=-1) - high, low - np.min(course, axis=-1))
        return drawn + _STEEPNESS * np.abs(drawn) * np.maximum(0.0, outside)

    def within(parameters: np.ndarray) -> np.ndarray:
        """The schedule drawn towards the middle of the range until it is inside; the same if it is."""
        middle = np.zeros_like(parameters)
        middle[0] = (low + high) / 2.0
        share = ((high - low) / 2.0 - _BETWEEN) / float(np.max(np.abs(swing(parameters) - middle[0])))
        return parameters if share >= 1.0 else middle + share * (parameters - middle)

    first = np.zeros(2 * HARMONICS + 1)
    first[0] = level

    def search(function: Callable[[np.ndarray], np.ndarray], bounds: tuple[float, float]) -> np.ndarray:
        best = first
        every = [bounds] + [(-LARGEST_SWING, LARGEST_SWING)] * (2 * HARMONICS)
        sloped = functools.partial(with_gradient, function)
        # At the kink of a limit the gradient may vanish, so also start from small waves at several phases.
        for wave in range(3):
            guess = first.copy()
            if wave:
                guess[[3, 4]] = 0.2 * np.cos(np.pi * wave), 0.2 * np.sin(np.pi * wave)
            found: Any = minimize(sloped, guess, jac=True, method="L-BFGS-B", bounds=every, options={"maxiter": 40})
            if found.fun < function(best):
                best = found.x
        return best

    best = search(cost, (level - 2.0, level + 2.0))
    if within(best) is not best:  # few leave the range, so most need not be told to stay
        best = within(search(confined, (max(level - 2.0, low), min(level + 2.0, high))))
    if np.ptp(swing(best)) < _CONSTANT or cost(best) > cost(first):
        best = first
    return functools.partial(schedule, drive.cylinder_speed, duty.period, best)


def with_gradient(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> tuple[float, np.ndarray]:
    """Value and central differences, all from one call of a function of (..., m)."""
    steps = _STEP * np.eye(len(at))
    values = function(at + np.vstack([np.zeros_like(at), steps, -steps]))
    ahead, behind = np.split(values[1:], 2)
    return float(values[0]), (ahead - behind) / (2.0 * _STEP)


def schedule(own: float, period: float, parameters: np.ndarray, time: np.ndarray) -> Varying:
    """``own exp(g(t))`` and its derivatives, from the level and harmonics of g: parameters (..., m) give (..., n)."""
    turn = 2.0 * np.pi * np.arange(1, HARMONICS + 1) / period
    cosine, sine = np.cos(np.multiply.outer(turn, time)), np.sin(np.multiply.outer(turn, time))
    a, b = parameters[..., 1::2], parameters[..., 2::2]
    swing = parameters[..., :1] + a @ cosine + b @ sine
    rate = (b * turn) @ cosine - (a * turn) @ sine
    curvature = -((a * turn**2) @ cosine + (b * turn**2) @ sine)
    value = own * np.exp(swing)
    return Varying(value, value * rate, value * (curvature + rate * rate))


def _penalised(point: MovingPoint) -> np.ndarray:
    """Mean power with a penalty on exceeded limits and on slip, over the last axis. [W]"""
    demands = performance.demands(point).values()
    excess = sum(np.maximum(0.0, np.nan_to_num(demand, nan=10.0, posinf=10.0) - _INSIDE) for demand in demands)
    drawn = np.mean(point.power_in, axis=-1)
    nothing = 1e3 * (1.0 + float(np.nanmax(np.abs(point.power_out))))
    return np.where(np.isfinite(drawn), drawn, nothing) * (1.0 + _STEEPNESS * excess)


def _evaluated(name: str, drive: CoboticDrive, duty: DutyCycle, instants: Instants, speed: Varying | None) -> Policy:
    point = drive.follow(instants.course, load_mass=duty.moved_mass, cylinder_speed=speed)
    turning = np.abs(drive.cylinder_speed if speed is None else speed.value)
    steering = np.asarray(point.states["steering_current_A"] * point.states["steering_voltage_V"])
    drawn = float(np.mean(point.power_in))
    taken = float(np.mean(drive.steering_amplifier.supply(steering)[0]))
    demands = performance.demands(point).values()
    return Policy(
        name=name,
        power_in=drawn,
        slowest=float(np.min(turning)),
        fastest=float(np.max(turning)),
        cylinder_speed=speed,
        feasible=all(bool(demand <= 1.0) for demand in demands),
        steering=taken / drawn if drawn > 0 else float("nan"),
    )
