"""Cylinder speed policies: nominal, optimal constant, scheduled in time, or free-running on its inertia.

The cylinder speed is a free choice, as the wheel converts it to any link speed. A slower cylinder has lower idle losses, but
requires larger steering angles, more steering power and a larger wheel force; a varying speed exchanges kinetic energy.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.described import derived, reported
from infinivar._core.result import Result, result
from infinivar._core.threads import products_on_one_thread
from infinivar.analysis.cycles import performance
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import MovingPoint
from infinivar.errors import ParameterError
from infinivar.motion.duty_cycles import DutyCycle, Instants, check_duty_cycle
from infinivar.transmission.rates import Varying

_LEAST, _PER_WAVE = 200, 10
"""Instants per cycle, and per shortest wave, during the search; the result is evaluated with all instants."""

RANGE = (0.1, 4.0)
"""Lowest and highest speed of the search, constant or scheduled, over the nominal speed."""
_FACTORS = np.geomspace(*RANGE, 30)
"""Constant speeds of the search, over the nominal speed."""
_BETWEEN_SPEEDS = (11, 11, 11)
"""Speeds between the neighbours of the best one, in each further step of the search."""
_DENSE, _BETWEEN = 500, 1e-4
"""Instants at which a schedule is compared with the range, and the most that it exceeds their values in between."""
_CONSTANT = 1e-3
"""Relative variation of a schedule below which it counts as a constant speed."""
HARMONICS = 3
LARGEST_SWING = 1.5
"""Largest harmonic amplitude of the logarithm of the speed."""
_STEP = 1e-6
"""Step of the parameters for differences."""
_NOTHING = 10.0
"""Power over that of the start, and excess over a limit, where a schedule has no value."""
_WAVES = ((), (0.0, 0.0, -0.2), (0.0, 0.0, 0.2))
"""Harmonics from which searches start: none, where symmetry may leave no slope, and two waves of half the period."""
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

    name: str = reported(attribute="name", key="policy")
    power_in: float = reported("W", attribute="power_in", key="power_W")
    slowest: float = reported("rad/s")
    fastest: float = reported("rad/s")
    cylinder_speed: Varying | None
    feasible: bool = reported()
    steering: float

    @derived("rad s-1", dims=("share",), variable="cylinder_speed")
    def _speeds(self) -> np.ndarray:
        """The speed over the cycle; two equal ones if it is constant."""
        speed = np.asarray(self.slowest if self.cylinder_speed is None else self.cylinder_speed.value)
        return np.broadcast_to(speed, (2,)) if speed.ndim == 0 else speed

    @derived("1", "share of the cycle", ("share",))
    def _share(self) -> np.ndarray:
        count = self._speeds.size
        return (np.arange(count) + 0.5) / count


@products_on_one_thread()
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
    check_duty_cycle(duty)
    if not isinstance(drive, CoboticDrive):
        raise ParameterError(f"a drive of type {type(drive).__name__} has no cylinder whose speed could be chosen")
    fine = duty.instants(orders=drive.orders)
    own = _evaluated("as given", drive, duty, fine, None)
    speed = best_speed(drive, duty)
    chosen = _evaluated("chosen for the cycle", replace(drive, cylinder_speed=speed), duty, fine, None)
    if drive.inertia_of_cylinder is None or not duty.closed:
        return own, chosen
    scheduled = _evaluated("scheduled in time", drive, duty, fine, best_schedule(drive, duty, start=speed)(fine.time))
    coasting = drive.coast(fine.course, period=np.asarray(duty.period), load_mass=duty.moved_mass)
    return own, chosen, scheduled, _evaluated("inertia as a flywheel", drive, duty, fine, coasting)


def best_speed(drive: CoboticDrive, duty: DutyCycle) -> float:
    """Constant cylinder speed of lowest mean power within limits, or of smallest excess if infeasible. [rad s^-1]"""
    return best_common_speed(drive, {duty.title: duty}, {duty.title: 1.0})


def best_common_speed(drive: CoboticDrive, cycles: Mapping[str, DutyCycle], weights: Mapping[str, float]) -> float:
    """As `best_speed`, one speed for several duty cycles, whose mean powers have weights."""
    moved = []
    for name, duty in cycles.items():
        instants = duty.instants(duty.samples(_LEAST, _PER_WAVE), drive.orders)
        moved.append((weights[name], duty, instants, drive.inward(instants.course, duty.moved_mass)))

    def cost(speeds: np.ndarray) -> np.ndarray:
        driven = replace(drive, cylinder_speed=speeds[:, None])
        each = [
            weight * _penalised(driven.follow(instants.course, load_mass=duty.moved_mass, behind=load))
            for weight, duty, instants, load in moved
        ]
        return np.sum(each, axis=0)

    speeds = drive.cylinder_speed * _FACTORS
    place = int(np.argmin(cost(speeds)))
    for between in _BETWEEN_SPEEDS:
        ends = speeds[max(place - 1, 0)], speeds[min(place + 1, len(speeds) - 1)]
        # The best so far stays among them.
        speeds = np.unique(np.append(np.linspace(*ends, between), speeds[place]))
        place = int(np.argmin(cost(speeds)))
    return float(speeds[place])


def best_schedule(drive: CoboticDrive, duty: DutyCycle, *, start: float) -> Callable[[np.ndarray], Varying]:
    """Periodic cylinder speed of lowest mean power within limits and `RANGE`, as a function of time [s].

    The search starts from the constant speed `start`; its result is never worse, and `start` itself if it does not vary.
    """
    instants = duty.instants(duty.samples(_LEAST, _PER_WAVE), drive.orders)
    load = drive.inward(instants.course, duty.moved_mass)
    dense = np.linspace(0.0, duty.period, _DENSE)
    low, high = np.log(RANGE)

    def swing(parameters: np.ndarray) -> np.ndarray:
        """Logarithm of the speed over the nominal one."""
        return np.log(schedule(1.0, duty.period, parameters, dense).value)

    def run(parameters: np.ndarray) -> MovingPoint:
        speed = schedule(drive.cylinder_speed, duty.period, parameters, instants.time)
        return drive.follow(instants.course, load_mass=duty.moved_mass, cylinder_speed=speed, behind=load)

    def judged(parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean power [W]; margins of all limits and of both ends of the range, on the last axis."""
        point, course = run(parameters), swing(parameters)
        power = np.mean(point.power_in, axis=-1)
        demands = [np.broadcast_to(demand, power.shape) for demand in performance.demands(point).values()]
        ends = [high - _BETWEEN - np.max(course, axis=-1), np.min(course, axis=-1) - low - _BETWEEN]
        return power, np.stack([*(_INSIDE - demand for demand in demands), *ends], axis=-1)

    first = np.zeros(2 * HARMONICS + 1)
    first[0] = np.clip(np.log(start / drive.cylinder_speed), low, high)
    best, least = first, _penalised(run(first))
    for found in schedules_within(judged, first, (first[0] - 2.0, first[0] + 2.0)):
        course, cost = swing(found), _penalised(run(found))
        if cost < least and low <= np.min(course) and np.max(course) <= high and np.ptp(course) >= _CONSTANT:
            best, least = found, cost
    return functools.partial(schedule, drive.cylinder_speed, duty.period, best)


def schedules_within(
    judged: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], first: np.ndarray, levels: tuple[float, float]
) -> Iterator[np.ndarray]:
    """Yield schedules of low mean power within limits, each found from another start.

    Parameters
    ----------
    judged : callable       Mean power (...) [W] and margins (..., k) >= 0 [-] of parameters (..., m) of `schedule`.
    first : (m,) float      Parameters of a constant speed.
    levels : tuple          Bounds of the level.

    Yields
    ------
    (m,) float   Not checked: a search may end outside the limits or at a higher power.

    Source: sequential quadratic programming (`scipy.optimize`). Limits are constraints and no penalty, because at a kink a
    search by slopes stops early, at another place on each machine.
    """
    from scipy.optimize import minimize

    scale = 1.0 + abs(float(np.nan_to_num(judged(first)[0])))
    steps = _STEP * np.eye(len(first))

    @functools.lru_cache(maxsize=4)
    def sloped(parameters: bytes) -> tuple[np.ndarray, np.ndarray]:
        """Power over that of the start, then margins, with their central differences: all from one call."""
        at = np.frombuffer(parameters)
        power, margins = judged(at + np.vstack([np.zeros_like(at), steps, -steps]))
        power = np.nan_to_num(power / scale, nan=_NOTHING, posinf=_NOTHING)
        values = np.concatenate([power[:, None], np.nan_to_num(margins, nan=-_NOTHING, neginf=-_NOTHING)], axis=-1)
        ahead, behind = np.split(values[1:], 2)
        # SciPy 1.17 misreads slopes that are not contiguous.
        return values[0], np.ascontiguousarray((ahead - behind).T / (2.0 * _STEP))

    limits = {
        "type": "ineq",
        "fun": lambda at: sloped(at.tobytes())[0][1:],
        "jac": lambda at: sloped(at.tobytes())[1][1:],
    }
    bounds = [levels] + [(-LARGEST_SWING, LARGEST_SWING)] * (len(first) - 1)
    for wave in _WAVES:
        guess = first.copy()
        guess[1 : 1 + len(wave)] = wave
        found: Any = minimize(
            lambda at: sloped(at.tobytes())[0][0],
            guess,
            jac=lambda at: sloped(at.tobytes())[1][0],
            constraints=limits,
            bounds=bounds,
            method="SLSQP",
            options={"maxiter": 60, "ftol": 1e-5},
        )
        yield found.x


def schedule(own: float, period: float, parameters: np.ndarray, time: np.ndarray) -> Varying:
    """``own exp(g(t))`` and its derivatives, from the level and harmonics of g: parameters (..., m) give (..., n)."""
    turn = 2.0 * np.pi * np.arange(1, HARMONICS + 1) / period
    cosine, sine = np.cos(np.multiply.outer(turn, time)), np.sin(np.multiply.outer(turn, time))
    a, b = parameters[..., 1::2], parameters[..., 2::2]

    def series(weights: np.ndarray, waves: np.ndarray) -> Any:
        # Term by term: a product of matrices rounds by its library's threads, and a search carries that to the sixth digit.
        return sum(weights[..., place, None] * waves[place] for place in range(HARMONICS))

    swing = parameters[..., :1] + series(a, cosine) + series(b, sine)
    rate = series(b * turn, cosine) - series(a * turn, sine)
    curvature = -(series(a * turn**2, cosine) + series(b * turn**2, sine))
    value = own * np.exp(swing)
    return Varying(value, value * rate, value * (curvature + rate * rate))


def _penalised(point: MovingPoint) -> np.ndarray:
    """Mean power with a penalty on exceeded limits and on slip, over the last axis. [W]"""
    demands = performance.demands(point).values()
    excess = sum(np.maximum(0.0, np.nan_to_num(demand, nan=10.0, posinf=10.0) - _INSIDE) for demand in demands)
    drawn = np.mean(point.power_in, axis=-1)
    nothing = 1e3 * (1.0 + float(np.nanmax(np.abs(point.power_out))))
    cost = np.where(np.isfinite(drawn), drawn, nothing)
    return cost + _STEEPNESS * excess * np.abs(cost)  # a cycle that returns power has a negative cost


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
