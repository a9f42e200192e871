r"""Thermal model of a motor: winding and housing as two thermal masses, from the data sheet.

.. math::
    C_w \dot T_w &= I^2 R (1 + \alpha (T_w - T_0)) - (T_w - T_h)/R_{wh} \\
    C_h \dot T_h &= P_f + (T_w - T_h)/R_{wh} - (T_h - T_a)/R_{ha}

with ``C_w = tau_w/R_wh`` and ``C_h = tau_h/R_ha``. The resistance of copper rises with temperature; the motor's friction and iron
loss ``P_f``, known from the no-load current, heat the housing, which carries bearings and stator. For given mean squares of
current the equations are linear, so time steps are exact and whole cycles follow from powers of one matrix.

Source: maxon2020 (thermal resistances, time constants, coefficient of copper).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array, along_last, namespace
from infinivar._core.result import Result, result
from infinivar.errors import ParameterError
from infinivar.parts.heat_steps import BOUND, COPPER, MARGIN, REFERENCE, Steps, over
from infinivar.parts.heat_steps import rates as rates
from infinivar.parts.heat_steps import steps as steps_of
from infinivar.parts.motor import Motor
from infinivar.units import celsius, plain

NEEDED = (
    "winding_to_housing",
    "housing_to_ambient",
    "winding_time_constant",
    "housing_time_constant",
    "max_winding_temperature",
)
"""Motor fields that the model requires."""

_RUN_STEPS = 1000
"""Most steps of a run in `through_run`."""
_NEVER = 60
"""Doublings of a cycle, 1e18 cycles in all, after which the limit counts as never reached."""
_HALVINGS = 40


@result
class Heat(Result):
    """What a motor's temperatures come to when a cycle is repeated, or over a run.

    Attributes
    ----------
    winding, housing : float      Highest temperatures in the settled state, inf if the motor never settles, or over the run. [K]
    mean_winding : float          Mean winding temperature in the settled state or over the run. [K]
    permissible : float           Permissible winding temperature. [K]
    time_to_limit : float         Time from the start (a cycle starts at ambient) until the winding exceeds it; inf if it
                                  never does. [s]
    ambient : float               Ambient temperature. [K]
    time, winding_history, housing_history : (n,) float   Temperatures at the ends of cycles after a cold start; if the
                                  winding never settles, up to the limit; for a run, through the run. [s], [K]
    repeated : bool               Whether a cycle is repeated; if not, all values are of one run.
    """

    winding: float
    housing: float
    mean_winding: float
    permissible: float
    time_to_limit: float
    ambient: float
    time: np.ndarray
    winding_history: np.ndarray
    housing_history: np.ndarray
    repeated: bool = True

    @property
    def within_limit(self) -> bool:
        """Whether the winding stays within its permissible temperature."""
        return self.time_to_limit == math.inf

    @property
    def demand(self) -> float:
        """Highest rise of the winding above ambient over the permissible rise; inf if ambient leaves none. [-]"""
        allowed = self.permissible - self.ambient
        return (self.winding - self.ambient) / allowed if allowed > 0 else math.inf

    @property
    def verdict(self) -> str:
        """Verdict in one clause."""
        limit = celsius(self.permissible)
        if not self.repeated:
            reached = f"winding reaches {celsius(self.winding)} in the run"
            if self.within_limit:
                return f"{reached} (limit {limit})"
            return f"{reached}; limit {limit} exceeded after {_duration(self.time_to_limit)}"
        if self.within_limit:
            return f"winding settles at {celsius(self.winding)} (limit {limit})"
        after = f"after {_duration(self.time_to_limit)}"
        if self.winding == math.inf:
            return f"winding temperature grows without bound; limit {limit} exceeded {after}"
        return f"winding reaches {celsius(self.winding)}; limit {limit} exceeded {after}"


def missing(motor: Motor) -> list[str]:
    """Required fields that the motor lacks."""
    return [name for name in NEEDED if getattr(motor, name) is None]


def _check(motor: Motor) -> None:
    """Raise ParameterError if the motor lacks a value that the model requires."""
    for name in missing(motor):
        raise ParameterError(f"{name} is missing: the thermal model needs it")


def warm(motor: Motor, temperature: float) -> Motor:
    """The motor with its winding at a given temperature [K]; only the resistance changes.

    Source: maxon2020.
    """
    return motor.with_resistance(motor.resistance * (1.0 + COPPER * (temperature - REFERENCE)))


def heat(motor: Motor, current: Any, friction_power: Any, period: float, ambient: float = REFERENCE) -> Heat:
    """Temperatures of a motor that repeats a cycle.

    Parameters
    ----------
    motor : Motor                            With all of `NEEDED`.
    current, friction_power : (n,) float     At the midpoints of equal steps of the cycle; one value if constant. [A], [W]
    period : float                           Period of the cycle. [s]
    ambient : float                          Ambient temperature. [K]

    Returns
    -------
    Heat   With an ambient above the permissible temperature the limit is exceeded at once.

    Raises
    ------
    ParameterError
        If the motor lacks a value that the model requires.

    Source: maxon2020; see the module.
    """
    _check(motor)
    steps = steps_of(motor, current, friction_power, period, ambient)
    cycle = _cycle(steps.maps)
    limit = float(motor.max_winding_temperature or math.nan)
    start = np.array([ambient, ambient, 1.0])
    settled = None if cycle is None else _settled(cycle)
    along = np.full((1, 3), math.inf) if settled is None else _along(steps.maps, settled)[1:]
    # After a cold start each cycle begins warmer than the last: if the settled motor is within the limit, so is every cycle.
    bears = ambient <= limit and along[:, 0].max() <= limit * (1.0 + MARGIN)
    passing, reached = (math.inf, start) if bears else _passes(steps, cycle, start, limit)
    if settled is None and passing < math.inf:
        time, history = _history(cycle, start, period, passing, 0)
        time, history = np.append(time, passing), np.append(history, reached[None], axis=0)
    else:
        span = 6.0 * max(motor.housing_time_constant or 0.0, motor.winding_time_constant or 0.0)
        time, history = _history(cycle, start, period, span, 10)
    return Heat(
        winding=float(along[:, 0].max()),
        housing=float(along[:, 1].max()),
        mean_winding=float(along[:, 0].mean()),
        permissible=limit,
        time_to_limit=passing,
        ambient=ambient,
        time=time,
        winding_history=history[:, 0],
        housing_history=history[:, 1],
    )


def heat_over_run(
    motor: Motor,
    current: Any,
    friction_power: Any,
    duration: float,
    *,
    ambient: float = REFERENCE,
    start: float | None = None,
) -> Heat:
    """Temperatures of a motor through a run.

    Parameters
    ----------
    motor : Motor                            With all of `NEEDED`.
    current, friction_power : (n,) float     At the midpoints of equal steps of the run; one value if constant. [A], [W]
    duration : float                         [s]
    ambient : float                          Ambient temperature. [K]
    start : float                            Temperature of winding and housing at the start; defaults to ambient. [K]

    Returns
    -------
    Heat   With a start above the permissible temperature the limit is exceeded at once.

    Raises
    ------
    ParameterError
        If the motor lacks a value that the model requires.

    Source: maxon2020; see the module.
    """
    _check(motor)
    steps = steps_of(motor, current, friction_power, duration, ambient)
    limit = float(motor.max_winding_temperature or math.nan)
    begin = ambient if start is None else start
    state = np.array([begin, begin, 1.0])
    along = _along(steps.maps, state)
    beyond = bool(along[:, 0].max() > limit * (1.0 + MARGIN))
    weight = np.diff(steps.ends)
    return Heat(
        winding=float(along[:, 0].max()),
        housing=float(along[:, 1].max()),
        mean_winding=float(np.sum(0.5 * (along[1:, 0] + along[:-1, 0]) * weight) / np.sum(weight)),
        permissible=limit,
        time_to_limit=_crossing(steps, state, limit * (1.0 + MARGIN))[0] if beyond else math.inf,
        ambient=ambient,
        time=steps.ends,
        winding_history=along[:, 0],
        housing_history=along[:, 1],
        repeated=False,
    )


def settled(
    motor: Motor, current: Array, friction_power: Array, period: float, ambient: float = REFERENCE
) -> tuple[Array, Array]:
    """Highest and mean winding temperature of a motor in the settled state of a cycle, in closed form.

    Assumes a constant housing temperature and the winding resistance at its mean temperature, which holds for cycles much
    shorter than the housing's time constant. Unlike `heat`, it accepts any array namespace and several cycles at once.

    Parameters
    ----------
    motor : Motor                              With all of `NEEDED`.
    current, friction_power : (..., n) float   At the midpoints of equal steps of the cycle. [A], [W]
    period : float                             Period of the cycle. [s]
    ambient : float                            Ambient temperature. [K]

    Returns
    -------
    highest, mean : (..., 1) float   inf where the motor never settles. [K]

    Source: maxon2020; periodic solution of the winding's equation.
    """
    xp = namespace(motor, current, friction_power)
    inner, outer, lag = motor.winding_to_housing, motor.housing_to_ambient, motor.winding_time_constant
    assert inner is not None
    assert outer is not None
    assert lag is not None
    square, friction = xp.broadcast_arrays(current * current, friction_power + 0.0 * current)
    joule = motor.resistance * xp.mean(square, axis=-1, keepdims=True)
    rubbed = xp.mean(friction, axis=-1, keepdims=True)
    rest = 1.0 - COPPER * joule * (inner + outer)
    settles = rest > 0
    cold = ambient + outer * rubbed + (inner + outer) * joule * (1.0 - COPPER * REFERENCE)
    mean = xp.where(settles, cold / xp.where(settles, rest, 1.0), xp.inf)
    warmth = xp.where(settles, 1.0 + COPPER * (mean - REFERENCE), 1.0)
    # Around its mean the winding follows its own losses: each step adds heat, of which a fraction remains in later steps.
    count = square.shape[-1]
    step = period / count
    gained = (inner * -xp.expm1(-step / lag)) * (motor.resistance * warmth * square - joule * warmth)
    shift = 1
    while shift < count:  # sums over 2, 4, 8 ... steps
        kept = xp.exp(-shift * step / lag) * gained[..., :-shift]
        gained = gained + xp.concat([0.0 * gained[..., :shift], kept], axis=-1)
        shift *= 2
    time = step * (xp.arange(count, dtype=xp.float64) + 1.0)
    begin = gained[..., -1:] / -xp.expm1(-period / lag)
    highest = mean + xp.max(begin * xp.exp(-time / lag) + gained, axis=-1, keepdims=True)
    return xp.where(settles, highest, xp.inf), mean


def through_run(
    motor: Motor, current: Array, friction_power: Array, duration: float, *, ambient: float, start: float
) -> tuple[Array, Array]:
    """Highest and mean winding temperature of a motor over a run, by the trapezoidal rule.

    Unlike `heat_over_run`, it accepts any array namespace and several runs at once.

    Parameters
    ----------
    motor : Motor                              With all of `NEEDED`.
    current, friction_power : (..., n) float   At the midpoints of equal steps of the run. [A], [W]
    duration : float                           [s]
    ambient, start : float                     Ambient temperature, and that of winding and housing at the start. [K]

    Returns
    -------
    highest, mean : (..., 1) float   At the ends of at most 1000 steps. [K]

    Source: maxon2020; see the module.
    """
    xp = namespace(motor, current, friction_power)
    inner, outer = motor.winding_to_housing, motor.housing_to_ambient
    assert inner is not None
    assert outer is not None
    assert motor.winding_time_constant is not None
    assert motor.housing_time_constant is not None
    square, friction = xp.broadcast_arrays(current * current, friction_power + 0.0 * current)
    # The number of steps depends on no value, which may be that of an array library.
    edges = np.linspace(0, square.shape[-1], min(_RUN_STEPS, square.shape[-1]) + 1).astype(int)
    joule, rubbed = motor.resistance * step_means(xp, square, edges), step_means(xp, friction, edges)
    half = 0.5 * duration / square.shape[-1] * np.diff(edges)
    lag, slow = motor.winding_time_constant, motor.housing_time_constant

    def over_step(state: tuple[Array, ...], along: tuple[Array, ...]) -> tuple[Array, ...]:
        winding, housing, highest, total = state
        joule, rubbed, half = along
        a, c = half * inner / lag, half * outer / slow
        # Slopes: winding a (p T_w + T_h/inner + q), housing c (T_w/inner + s T_h + r), over half a step.
        p, q = COPPER * joule - 1.0 / inner, joule * (1.0 - COPPER * REFERENCE)
        s, r = -(1.0 / inner + 1.0 / outer), rubbed + ambient / outer
        first_row = winding + a * (p * winding + housing / inner + 2.0 * q)
        second_row = housing + c * (winding / inner + s * housing + 2.0 * r)
        determinant = (1.0 - a * p) * (1.0 - c * s) - a * c / inner**2
        after = ((1.0 - c * s) * first_row + a / inner * second_row) / determinant
        housing = ((1.0 - a * p) * second_row + c / inner * first_row) / determinant
        return after, housing, xp.maximum(highest, after), total + half * (winding + after)

    # Of the shape that the temperatures come to have.
    begin = start + 0.0 * (joule[..., :1] + inner + outer + lag + slow)
    _, _, highest, total = along_last(xp, over_step, (begin, begin, begin, 0.0 * begin), (joule, rubbed, half))
    return highest, total / duration


def step_means(xp: Any, values: Array, edges: np.ndarray) -> Array:
    """Means of values on a last axis over steps between edges: places on that axis, from 0 to its length. (..., steps)"""
    width = np.diff(edges)
    if np.all(width == width[0]):
        return xp.mean(xp.reshape(values, (*values.shape[:-1], len(width), int(width[0]))), axis=-1)
    sums = xp.cumulative_sum(values, axis=-1)
    sums = xp.concat([0.0 * sums[..., :1], sums], axis=-1)
    return (xp.take(sums, xp.asarray(edges[1:]), axis=-1) - xp.take(sums, xp.asarray(edges[:-1]), axis=-1)) / width


def _cycle(steps: np.ndarray) -> np.ndarray | None:
    """Map over a whole cycle; None if temperatures run away within it."""
    cycle = np.eye(3)
    for step in steps:
        cycle = step @ cycle
        if cycle[:2, :2].max() > BOUND:
            return None
    return cycle


def _settled(cycle: np.ndarray) -> np.ndarray | None:
    """Periodic state of a cycle; None if every cycle makes the motor warmer."""
    if np.max(np.abs(np.linalg.eigvals(cycle[:2, :2]))) >= 1.0:
        return None
    rest = np.linalg.solve(np.eye(2) - cycle[:2, :2], cycle[:2, 2])
    return np.append(rest, 1.0)


def _along(steps: np.ndarray, state: np.ndarray, limit: float = math.inf) -> np.ndarray:
    """States from the start of a cycle to its end, or to the first winding temperature above a limit. (k, 3)"""
    found = [state]
    for step in steps:
        if found[-1][0] > limit:
            break
        found.append(step @ found[-1])
    return np.array(found)


def _passes(steps: Steps, cycle: np.ndarray | None, state: np.ndarray, limit: float) -> tuple[float, np.ndarray]:
    """Time until the winding exceeds the limit (inf if it never does), and the state at that time.

    Finds the first such cycle by bisection over powers of two of the cycle map.
    """
    limit = limit * (1.0 + MARGIN)

    def passes(state: np.ndarray) -> bool:
        return bool(_along(steps.maps, state, limit)[-1, 0] > limit)

    first = 0
    if cycle is not None and not passes(state):
        doubled = [cycle]
        while not passes(doubled[-1] @ state):
            if len(doubled) == _NEVER or np.allclose(doubled[-1], doubled[-1] @ doubled[-1], rtol=1e-12, atol=0.0):
                return math.inf, state
            doubled.append(doubled[-1] @ doubled[-1])
        for power in range(len(doubled) - 2, -1, -1):
            further = doubled[power] @ state
            if not passes(further):
                state, first = further, first + 2**power
        state, first = cycle @ state, first + 1
    begin = first * float(steps.ends[-1])
    since, state = _crossing(steps, state, limit)
    return begin + since, state


def _crossing(steps: Steps, state: np.ndarray, limit: float) -> tuple[float, np.ndarray]:
    """Time in a cycle or run at which the winding exceeds the limit, which it must do, and the state at that time."""
    along = _along(steps.maps, state, limit)
    if len(along) == 1:
        return 0.0, state
    place, state = len(along) - 2, along[-2]
    low, high = 0.0, float(steps.active[place])
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = (over(steps.generators[place], middle) @ state)[0] > limit
        low, high = (low, middle) if beyond else (middle, high)
    return float(steps.ends[place]) + high, over(steps.generators[place], high) @ state


def _history(
    cycle: np.ndarray | None, state: np.ndarray, period: float, span: float, least: int
) -> tuple[np.ndarray, np.ndarray]:
    """Times and states at the ends of cycles after a cold start, over a time span, with at least `least` points."""
    cycles = max(1, round(span / period / 200))
    count = max(least, int(span / (cycles * period)))
    stride = np.eye(3) if cycle is None else np.linalg.matrix_power(cycle, cycles)
    found = [state]
    for _ in range(count):
        found.append(stride @ found[-1])
    return np.arange(count + 1) * (cycles * period), np.array(found)


def _duration(seconds: float) -> str:
    if seconds < 120.0:
        return f"{plain(seconds, 2)} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
