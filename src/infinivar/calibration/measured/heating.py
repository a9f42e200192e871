"""Bench of a motor heated by a known power: winding and body, with sensors that lag, and loggers that start apart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.calibration.bench import Parameter
from infinivar.calibration.measured.law import At, Form, Law, Term
from infinivar.parts.heat_steps import over

_FIRST = 4
"""Rows whose mean is the temperature at the start."""


def _heated(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    """Temperatures of winding and body over each run.

    Source: maxon2020 (two thermal masses); the steps are exact, as in `infinivar.parts.heat_steps`. A sensor that lags is a
    first-order filter.
    """
    shape = np.broadcast_shapes(*(np.shape(one) for one in (*values.values(), *common.values())), at.run.shape)
    every = int(np.prod(shape[:-1]))

    def flat(value: Any) -> np.ndarray:
        return np.broadcast_to(value, (*shape[:-1], np.shape(value)[-1] if np.ndim(value) else 1)).reshape(every, -1)

    names = ("winding_capacity", "body_capacity", "inner", "outer", "winding_lag", "body_lag", "body_power")
    each = {name: flat(values[name])[:, 0] for name in names}
    offset = flat(common["offset"])
    found = {name: np.empty((every, len(at.run))) for name in ("winding", "body")}
    for run in np.unique(at.run).tolist():
        members = at.run == run
        history = at.history[run]
        for place in range(every):
            one = {name: float(value[place]) for name, value in each.items()}
            off = float(offset[place, np.argmax(members)])
            for name, along in temperatures(history, **one, offset=off).items():
                found[name][place, members] = np.interp(at.known["time"][members], history["time"], along)
    return {name: value.reshape(shape) for name, value in found.items()}


def temperatures(
    history: Mapping[str, np.ndarray],
    *,
    winding_capacity: float,
    body_capacity: float,
    inner: float,
    outer: float,
    winding_lag: float = 0.0,
    body_lag: float = 0.0,
    body_power: float = 0.0,
    offset: float = 0.0,
) -> dict[str, np.ndarray]:
    """Temperatures that sensors on winding and body read over a run.

    Parameters
    ----------
    history : mapping   time [s], evenly spaced, power [W] and ambient, winding, body [K], of which the first rows count; (n,).
    winding_capacity, body_capacity : float   [J K^-1]
    inner, outer : float                      Resistances winding to body and body to ambient. [K W^-1]
    winding_lag, body_lag : float             Time constants of the sensors; 0 for none. [s]
    body_power : float                        Part of the power, while there is as much, that heats the body. [W]
    offset : float                            Time by which the logger of power is early. [s]

    Returns
    -------
    dict of (n,) float   winding, body. [K]

    Source: maxon2020.
    """
    from scipy.signal import lfilter

    time = history["time"]
    step = (time[-1] - time[0]) / (len(time) - 1)
    power = np.interp(time - offset, time, history["power"])
    matrix = np.array(
        [
            [-1.0 / (inner * winding_capacity), 1.0 / (inner * winding_capacity)],
            [1.0 / (inner * body_capacity), -(1.0 / inner + 1.0 / outer) / body_capacity],
        ]
    )
    inputs = np.array([[1.0 / winding_capacity, 0.0, 0.0], [0.0, 1.0 / body_capacity, 1.0 / (outer * body_capacity)]])
    generators = np.zeros((3, 3, 3))
    generators[:, :2, :2], generators[:, :2, 2] = matrix, inputs.T
    maps = over(generators, step)
    # Heat that only spreads does not swing: the rates are real.
    rates, modes = (np.real(one) for one in np.linalg.eig(maps[0, :2, :2]))
    body = np.minimum(power, body_power)
    means = np.stack([0.5 * (one[1:] + one[:-1]) for one in (power - body, body, history["ambient"])])
    driven = np.linalg.solve(modes, maps[:, :2, 2].T @ means)
    begin = np.array([history[name][:_FIRST].mean() for name in ("winding", "body")])
    states = np.empty((2, len(time)))
    for mode, first in enumerate(np.linalg.solve(modes, begin)):
        states[mode] = lfilter([1.0], [1.0, -rates[mode]], np.concatenate([[first], driven[mode]]))
    found: dict[str, np.ndarray] = dict(zip(("winding", "body"), modes @ states, strict=True))
    for name, lag in (("winding", winding_lag), ("body", body_lag)):
        if lag > 0.0:
            # Exact for a temperature that is linear within a step.
            kept, true = math.exp(-step / lag), found[name]
            driven_by = true[1:] - kept * true[:-1] - np.diff(true) * lag / step * (1.0 - kept)
            found[name] = np.asarray(lfilter([1.0], [1.0, -kept], np.concatenate([true[:1], driven_by])))
    return found


_NODES = ("winding_capacity", "body_capacity", "inner", "outer")

HEATING = Law(
    name="heating",
    title="temperatures of a motor heated by a known power",
    known={"time": "s", "power": "W", "ambient": "K"},
    read={"winding": "K", "body": "K"},
    settings={},
    terms={
        "winding_capacity": Term(Parameter("J/K", "J/K", "heat capacity of the winding", divides=True), 100.0),
        "body_capacity": Term(Parameter("J/K", "J/K", "heat capacity of the body", divides=True), 500.0),
        "inner": Term(Parameter("K/W", "K/W", "thermal resistance winding to body", divides=True), 0.2),
        "outer": Term(Parameter("K/W", "K/W", "thermal resistance body to ambient", divides=True), 2.0),
        "winding_lag": Term(Parameter("s", "s", "time constant of the sensor on the winding"), 10.0),
        "body_lag": Term(Parameter("s", "s", "time constant of the sensor on the body"), 10.0),
        "body_power": Term(Parameter("W", "W", "part of the power that heats the body, whatever the power"), 50.0),
    },
    forms={
        "two nodes": Form(_NODES),
        "two nodes, lag": Form((*_NODES, "body_lag")),
        "two nodes, power in the body": Form((*_NODES, "body_power")),
        "two nodes, power in the body, lag": Form((*_NODES, "body_power", "body_lag")),
        "two nodes, power in the body, lags": Form((*_NODES, "body_power", "winding_lag", "body_lag")),
    },
    expected=_heated,
    over="time",
    common={"offset": 4.0},
    evolves=True,
    alike=True,
    ranges={"ambient": (220.0, 350.0)},
)
