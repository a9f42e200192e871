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

from infinivar._core.array_namespace import Array, accumulated, namespace
from infinivar._core.described import derived, reported
from infinivar._core.result import Result, result
from infinivar.errors import ParameterError
from infinivar.parts.heat_steps import BOUND, COPPER, MARGIN, REFERENCE, Steps, over, warmth
from infinivar.parts.heat_steps import rates as rates
from infinivar.parts.heat_steps import steps as steps_of
from infinivar.parts.motor import Motor
from infinivar.units import ZERO_CELSIUS, celsius, plain

NEEDED = (
    "winding_to_housing",
    "housing_to_ambient",
    "winding_time_constant",
    "housing_time_constant",
    "max_winding_temperature",
)
"""Motor fields that the model requires."""

_RUN_STEPS = 2000
"""Most steps of a run or cycle in `through_run` and `settled`."""
_FARTHEST = 25.0
"""Largest logarithm of a growth within a step there; beyond, the winding has run away."""
_NEVER = 60
"""Doublings of a cycle, 1e18 cycles in all, after which the limit counts as never reached."""
_HALVINGS = 40


def _in_celsius(temperature: float) -> float:
    return temperature - ZERO_CELSIUS


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

    winding: float = reported("K", key="winding_C", convert=_in_celsius)
    housing: float = reported("K", key="housing_C", convert=_in_celsius)
    mean_winding: float
    permissible: float = reported("K", attribute="permissible", key="permissible_C", convert=_in_celsius)
    time_to_limit: float = reported("s")
    ambient: float
    time: np.ndarray = reported("s", dims=("time",))
    winding_history: np.ndarray = reported("K", dims=("time",), variable="winding")
    housing_history: np.ndarray = reported("K", dims=("time",), variable="housing")
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

    @derived()
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
    return motor.with_resistance(motor.resistance * warmth(temperature))


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
    highest = housing = mean = math.inf
    if settled is not None:
        along = _along(steps.maps, settled)
        highest, housing, mean = float(steps.highest(along)), float(along[1:, 1].max()), float(steps.mean(along))
    # After a cold start each cycle begins warmer than the last: if the settled motor is within the limit, so is every cycle.
    bears = ambient <= limit and highest <= limit * (1.0 + MARGIN)
    passing, reached = (math.inf, start) if bears else _passes(steps, cycle, start, limit)
    if settled is None and passing < math.inf:
        time, history = _history(cycle, start, period, passing, 0)
        time, history = np.append(time, passing), np.append(history, reached[None], axis=0)
    else:
        span = 6.0 * max(motor.housing_time_constant or 0.0, motor.winding_time_constant or 0.0)
        time, history = _history(cycle, start, period, span, 10)
    return Heat(
        winding=highest,
        housing=housing,
        mean_winding=mean,
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
    highest = max(begin, float(steps.highest(along)))
    beyond = highest > limit * (1.0 + MARGIN)
    return Heat(
        winding=highest,
        housing=float(along[:, 1].max()),
        mean_winding=float(steps.mean(along)),
        permissible=limit,
        time_to_limit=_crossing(steps, state, limit * (1.0 + MARGIN))[0] if beyond else math.inf,
        ambient=ambient,
        time=steps.ends,
        winding_history=along[:, 0],
        housing_history=along[:, 1],
        repeated=False,
    )


def highest_until(
    motor: Motor,
    current: Any,
    friction_power: Any,
    period: float,
    time: float,
    *,
    ambient: float = REFERENCE,
    start: float | None = None,
) -> float:
    """Highest winding temperature of a motor that repeats a cycle from a cold start, up to a time.

    Parameters
    ----------
    motor : Motor                            With all of `NEEDED`.
    current, friction_power : (n,) float     At the midpoints of equal steps of the cycle; one value if constant. [A], [W]
    period : float                           Period of the cycle, or at least the time for a run. [s]
    time : float                             Since the start, >= 0. [s]
    ambient : float                          Ambient temperature. [K]
    start : float                            Temperature of winding and housing at the start; defaults to ambient. [K]

    Returns
    -------
    highest : float   [K]; at the ends of instants of the cycle in which the time lies; inf where the winding runs away.

    Raises
    ------
    ParameterError
        If the motor lacks a value that the model requires.

    Source: maxon2020; see the module.
    """
    _check(motor)
    steps = steps_of(motor, current, friction_power, period, ambient)
    begin = ambient if start is None else start
    whole, since = divmod(time, period)
    cycle = _cycle(steps.maps)
    if whole and cycle is None:
        return math.inf
    found, state = begin, np.array([begin, begin, 1.0])
    with np.errstate(over="ignore", invalid="ignore"):
        if whole and cycle is not None:  # after a cold start each cycle is warmer than those before
            along = _along(steps.maps, np.linalg.matrix_power(cycle, int(whole) - 1) @ state)
            found, state = float(steps.highest(along)), along[-1]
        here = steps.within(_along(steps.maps, state))
        found = max(found, float(np.max(here[: int(since / period * len(here))], initial=begin)))
    return found if math.isfinite(found) else math.inf


def settled(
    motor: Motor, current: Array, friction_power: Array, period: float, ambient: float = REFERENCE
) -> tuple[Array, Array]:
    """Highest and mean winding temperature of a motor in the settled state of a cycle.

    Unlike `heat`, it accepts any array namespace and several cycles at once.

    Parameters
    ----------
    motor : Motor                              With all of `NEEDED`.
    current, friction_power : (..., n) float   At the midpoints of equal steps of the cycle. [A], [W]
    period : float                             Period of the cycle. [s]
    ambient : float                            Ambient temperature. [K]

    Returns
    -------
    highest, mean : (..., 1) float   At the ends of at most 2000 steps; inf where the motor never settles. [K]

    Source: maxon2020; periodic solution of both equations, by the map of the cycle.
    """
    xp = namespace(motor, current, friction_power)
    along = accumulated(xp, _after, _step_maps(xp, motor, current, friction_power, period, ambient))
    w_w, w_h, w_c, c_w, c_h, c_c = (change[..., -1:] for change in along)
    determinant = w_w * c_h - w_h * c_w
    # Of a matrix without negative elements, the largest eigenvalue is then below 1.
    settles = (w_w < 0) & (c_h < 0) & (determinant > 0)
    safe = xp.where(settles, determinant, 1.0)
    winding = (w_h * c_c - c_h * w_c) / safe
    housing = (c_w * w_c - w_w * c_c) / safe
    begin = tuple(xp.where(settles, value, ambient) for value in (winding, housing))
    return tuple(xp.where(settles, found, xp.inf) for found in _through(xp, along, begin))  # type: ignore[return-value]


def through_run(
    motor: Motor, current: Array, friction_power: Array, duration: float, *, ambient: float, start: float
) -> tuple[Array, Array]:
    """Highest and mean winding temperature of a motor over a run.

    Unlike `heat_over_run`, it accepts any array namespace and several runs at once.

    Parameters
    ----------
    motor : Motor                              With all of `NEEDED`.
    current, friction_power : (..., n) float   At the midpoints of equal steps of the run. [A], [W]
    duration : float                           [s]
    ambient, start : float                     Ambient temperature, and that of winding and housing at the start. [K]

    Returns
    -------
    highest, mean : (..., 1) float   At the ends of at most 2000 steps. [K]

    Source: maxon2020; see the module.
    """
    xp = namespace(motor, current, friction_power)
    along = accumulated(xp, _after, _step_maps(xp, motor, current, friction_power, duration, ambient))
    begin = start + 0.0 * along[0][..., :1]
    highest, mean = _through(xp, along, (begin, begin))
    return xp.maximum(highest, begin), mean


def _through(xp: Any, along: tuple[Array, ...], begin: tuple[Array, ...]) -> tuple[Array, Array]:
    """Highest winding temperature at the ends of steps, and mean by the trapezoidal rule. (..., 1) each

    `along` are the changes from the start to each end.
    """
    (w_w, w_h, w_c, *_), (winding, housing) = along, begin
    after = _bounded(xp, winding + (w_w * winding + w_h * housing + w_c))
    total = xp.sum(after, axis=-1, keepdims=True) + 0.5 * (winding - after[..., -1:])
    return xp.max(after, axis=-1, keepdims=True), total / after.shape[-1]


def _after(xp: Any, first: tuple[Array, ...], second: tuple[Array, ...]) -> tuple[Array, ...]:
    """Changes over two steps. They are not maps, since cycles are short, and 1 minus a map would lose digits."""
    found = []
    for row in (0, 3):
        warms, cools = second[row], second[row + 1]
        for column in (0, 1, 2):
            change = warms * first[column] + cools * first[3 + column]
            found.append(_bounded(xp, first[row + column] + second[row + column] + change))
    return tuple(found)


def _bounded(xp: Any, value: Array) -> Array:
    """A motor that runs away stops growing, so that no number exceeds all others."""
    return xp.where(xp.abs(value) < BOUND, value, BOUND)


def _step_maps(
    xp: Any, motor: Motor, current: Array, friction_power: Array, duration: float, ambient: float
) -> tuple[Array, ...]:
    """Exact changes over at most 2000 equal steps of mean power: rows of the winding, then of the housing. Six of (..., k)

    A row is what winding, housing and 1 contribute to the change. See `heat_steps.over`.
    """
    inner, outer = motor.winding_to_housing, motor.housing_to_ambient
    lag, slow = motor.winding_time_constant, motor.housing_time_constant
    assert inner is not None
    assert outer is not None
    assert lag is not None
    assert slow is not None
    square, friction = xp.broadcast_arrays(current * current, friction_power + 0.0 * current)
    # The number of steps depends on no value, which may be that of an array library.
    edges = np.linspace(0, square.shape[-1], min(_RUN_STEPS, square.shape[-1]) + 1).astype(int)
    joule, rubbed = motor.resistance * step_means(xp, square, edges), step_means(xp, friction, edges)
    time = duration / square.shape[-1] * np.diff(edges)
    a, b = (inner * COPPER * joule - 1.0) / lag, 1.0 / lag
    c, d = outer / (inner * slow), -(outer / inner + 1.0) / slow
    p, q = inner / lag * joule * (1.0 - COPPER * REFERENCE), (outer * rubbed + ambient) / slow
    half = 0.5 * (a - d)
    spread = xp.sqrt(half * half + b * c)
    middle = 0.5 * (a + d)
    rows = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    for rate, sign in ((middle + spread, 1.0), (middle - spread, -1.0)):
        grown = rate * time
        grown = xp.where(grown > _FARTHEST, _FARTHEST, grown)
        safe = xp.where(xp.abs(grown) < 1e-12, 1.0, grown)
        power, lasting = xp.expm1(grown), time * xp.where(xp.abs(grown) < 1e-12, 1.0, xp.expm1(safe) / safe)
        # The projection on this rate.
        first, second = 0.5 * (1.0 + sign * half / spread), 0.5 * (1.0 - sign * half / spread)
        above, below = sign * 0.5 * b / spread, sign * 0.5 * c / spread
        of_rate = (
            (power * first, power * above, lasting * (first * p + above * q)),
            (power * below, power * second, lasting * (below * p + second * q)),
        )
        rows = [whole + part for whole, part in zip(rows, (*of_rate[0], *of_rate[1]), strict=True)]
    return tuple(xp.broadcast_arrays(*rows))


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
        along = _along(steps.maps, state, limit)
        return bool(along[-1, 0] > limit or steps.within(along).max(initial=0.0) > limit)

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
    beyond = steps.within(along) > limit
    instant = int(np.argmax(beyond)) if beyond.any() else int(steps.edges[len(along) - 1]) - 1
    place = int(np.searchsorted(steps.edges, instant, side="right")) - 1
    first, last = int(steps.edges[place]), int(steps.edges[place + 1])
    ripple = np.concatenate([[0.0], steps.ripple[first:last]])
    times = float(steps.active[place]) / (last - first) * np.arange(last - first + 1)

    def at(time: float) -> np.ndarray:
        found = over(steps.generators[place], time) @ along[place]
        found[0] += np.interp(time, times, ripple) * (1.0 + COPPER * (found[0] - REFERENCE))
        return found

    # Between the ends of a step `within` is linear: where a motor runs away, too early.
    early = instant - first
    while early + 1 < last - first and at(times[early + 1])[0] <= limit:
        early += 1
    low, high = times[early], times[early + 1]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if at(middle)[0] > limit else (middle, high)
    return float(steps.ends[place] + high), at(float(high))


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
