"""Text of the calibration of a geared drive."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from infinivar._core.text import few
from infinivar.calibration.data import LeftOut
from infinivar.calibration.fit import Combination, Fit, information
from infinivar.calibration.geared import model
from infinivar.calibration.geared.data import Dynamometer
from infinivar.calibration.geared.problem import Problem
from infinivar.calibration.words import combined
from infinivar.study.spreads import NORMAL_95
from infinivar.units import plain

_CORRELATED = 0.9
"""Correlation above which two estimates are named as hard to separate."""

_OF_POWER = {"resistance", "torque_constant"}


class Remedy(NamedTuple):
    """Data that would make a parameter identifiable, and the number of directions that would still not be."""

    words: str
    left: int


def sum_in_words(combination: Combination, fit: Fit) -> str:
    """Format what the data determine of parameters that are not identifiable separately."""
    if set(combination.weights) == _OF_POWER:
        return f"resistance / torque_constant^2 = {_of_power(fit)}"
    said = combined(combination, model.PARAMETERS)
    return said if len(combination.weights) == 1 else f"{said}, near these values"


def _of_power(fit: Fit) -> str:
    """Resistance over the squared torque constant, which sets the winding loss of a torque, with its 95 % interval."""
    resistance, constant = fit.values["resistance"], fit.values["torque_constant"]
    slope = np.zeros(len(fit.names))
    slope[fit.names.index("resistance")] = 1.0 / resistance
    slope[fit.names.index("torque_constant")] = -2.0 / constant
    relative = math.sqrt(max(float(slope @ fit.covariance @ slope), 0.0))
    value = resistance / constant**2
    return f"{plain(value, 4)} ± {plain(NORMAL_95 * relative * value, 2)} W/(N m)^2"


def remarks(fit: Fit, left_out: Sequence[LeftOut]) -> Iterator[str]:
    """Remarks on the result, one sentence each."""
    problem: Problem = fit.problem
    yield from _on_parameters(fit)
    if problem.data.kind == "pendulum" or problem.data.geared:
        yield (
            "Friction of motor and gear add up in these data: the motor keeps that of the study, "
            f"{plain(1e3 * problem.known['motor_friction'], 3)} mN m, and the gear has the rest."
        )
    yield from _on_correlations(fit)
    low = problem.bounds[0]
    for place, name in enumerate(fit.names):
        if fit.unknowns[place] < low[place] + 1e-4:
            yield f"The fit of {name} ended at its lower bound, so its interval is not meaningful."
    if left_out:
        lines = few([str(one.line) for one in left_out], 20)
        yield f"Excluded: line{'s' if len(left_out) > 1 else ''} {lines}."
    yield (
        "The noise is taken from the residuals: "
        + ", ".join(
            f"{name} {plain(float(size), 3)} {_UNITS[name]}".rstrip()
            for name, size in zip(problem.data.signals, problem.noise, strict=True)
        )
        + ". If the model is wrong, this hides it in part: see the residuals."
    )


_UNITS = {"current": "A", "voltage": "V", "power": "W", "efficiency": ""}


def _on_parameters(fit: Fit) -> Iterator[str]:
    apart = [name for name in fit.names if name not in fit.told]
    combinations = [one for one in fit.combinations if len(one.weights) > 1]
    if apart:
        each = len(apart) == 1
        determined = "; ".join(sum_in_words(one, fit) for one in combinations)
        yield (
            f"Not identifiable{'' if each else ' separately'}: {' and '.join(apart)}. "
            + (f"The data determine only {determined}; the" if determined else "The")
            + " calibrated drive stays as close to the study as the data allow."
        )
        helps = remedies(fit)
        if helps:
            still = "" if helps[0].left == 0 else ", in part"
            yield f"Would identify {'it' if each else 'them'}{still}: {', or '.join(one.words for one in helps)}."


def _on_correlations(fit: Fit) -> Iterator[str]:
    matrix = fit.correlations
    for place, one in enumerate(fit.names):
        for other in range(place + 1, len(fit.names)):
            value = float(matrix[place, other])
            if abs(value) > _CORRELATED:
                yield (
                    f"{one} and {fit.names[other]} are correlated by {value:+.2f}: their errors "
                    f"{'compensate' if value < 0 else 'grow together'}, so use them together."
                )


def remedies(fit: Fit) -> list[Remedy]:
    """Further data that would make most parameters identifiable.

    Each is tried: the information of the readings that the fitted drive would then give is computed.
    """
    problem: Problem = fit.problem
    data = problem.data
    if not fit.untold.size or not isinstance(data, Dynamometer):
        return []
    found = []
    for words, requested in _further(problem, fit):
        informed = information(requested.jacobian(fit.unknowns), len(fit.names))
        left = int(np.count_nonzero(np.linalg.eigvalsh(informed) < 1.0))
        if left < fit.untold.shape[1]:
            found.append(Remedy(words, left))
    least = min((one.left for one in found), default=0)
    return [one for one in found if one.left == least]


def _further(problem: Problem, fit: Fit) -> Iterator[tuple[str, Problem]]:
    """Yield further data in words, and the problem with them."""
    data = problem.data

    def again(**changed: np.ndarray) -> Problem:
        more = replace(data, **changed)
        joined = {
            name: np.concatenate([getattr(data, name), getattr(more, name)]) for name in ("speed", "torque", "read")
        }
        return problem.about(replace(data, **joined, lines=data.lines + more.lines))

    yield "the same points while the load drives", again(torque=-data.torque)
    yield "the same points at half the load", again(torque=0.5 * data.torque)
    yield "the same points at half the speed", again(speed=0.5 * data.speed)
    for name in ("voltage", "current"):
        if name not in data.signals:
            wider = replace(data, signals=(*data.signals, name), read=_wider(data.read))
            yield f"a column of {name}", _with_signal(problem, wider, fit)


def _wider(read: np.ndarray) -> np.ndarray:
    return np.concatenate([read, np.zeros((len(read), 1))], axis=1)


def _with_signal(problem: Problem, data: Dynamometer, fit: Fit) -> Problem:
    """The problem with one more signal, whose noise is the largest relative noise of the others."""
    relative = float(np.max(problem.noise / np.sqrt(np.mean(np.square(problem.data.read), axis=0))))
    wider = replace(problem, data=data, noise=np.append(problem.noise, 1.0))
    size = float(np.sqrt(np.mean(wider.expected(fit.unknowns)[..., -1] ** 2)))
    return replace(wider, noise=np.append(problem.noise, max(relative * size, 1e-12)))
