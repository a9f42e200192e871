"""Propose the next runs: those that narrow the intervals most (D-optimal design)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.described import reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.calibration.dynamometer import Dynamometer
from infinivar.calibration.fit import Fit, information
from infinivar.calibration.laws import LawChoice
from infinivar.calibration.options import LOADS, RATIOS
from infinivar.calibration.problem import Problem
from infinivar.calibration.transmission import OF_MASS, RigData, predict
from infinivar.calibration.virtual_rig import Setting, protocol, window

PRELOADS = (0.4, 0.7, 1.0)
"""Candidate preloads over the study's; a higher preload would over-stress the contact."""

RUNS = 4
"""Number of runs proposed."""

_GUESS = 1.0
"""Relative standard deviation of the parameters before any run."""


class Telling(NamedTuple):
    """A run that discriminates between two creep laws."""

    between: tuple[str, str]
    setting: Setting
    apart: float
    """Difference of its readings under the two laws, in standard deviations that include the parameter uncertainty."""

    def to_dict(self) -> dict[str, Any]:
        """The run and what it tells, for scripts."""
        return {"between": list(self.between), **self.setting._asdict(), "standard_deviations": self.apart}


@result
class Plan(Frozen):
    """Proposed runs.

    Attributes
    ----------
    settings : runs by decreasing benefit.
    deviations : expected standard deviations after these runs, by parameter; inf if still not identifiable. [SI]
    telling : for each other law not excluded, the run that best discriminates it from the law used.
    """

    settings: tuple[Setting, ...] = reported(key="next_runs")
    deviations: Mapping[str, float] = reported(key="expected_standard_deviations")
    telling: tuple[Telling, ...] = reported(key="runs_to_tell_laws_apart", default=())


def propose(found: Fit, *, preloads: Sequence[float] = PRELOADS, count: int = RUNS) -> Plan:
    """Choose, one after another, the runs that add most information on the fitted parameters.

    Each run maximises the determinant of the information, with the session errors marginalised; directions without
    information count as known to 100 %.

    Source: D-optimal sequential design (Fedorov's exchange, one run at a time); linear in the unknowns at the fit.
    """
    problem = found.problem
    size = len(problem.names)
    prior = np.eye(size) / _GUESS**2
    candidates = _candidates(found, preloads)
    rows = _rows(found, candidates)
    whole = problem.jacobian(found.unknowns)
    chosen: list[int] = []
    for _ in range(count if len(candidates) else 0):
        scores = [np.linalg.slogdet(information(np.concatenate([whole, row]), size) + prior)[1] for row in rows]
        best = int(np.argmax(scores))
        chosen.append(best)
        whole = np.concatenate([whole, rows[best]])
    after, directions = np.linalg.eigh(information(whole, size))
    unidentifiable = directions[:, after < 1.0 / _GUESS**2]
    spread = np.sqrt(np.diag(np.linalg.inv(information(whole, size) + 1e-12 * prior)))
    spread = np.where(np.any(np.abs(unidentifiable) > 0.1, axis=1), np.inf, found.widened * spread * problem.scales)
    return Plan(
        settings=tuple(_setting(candidates, place) for place in chosen),
        deviations=FrozenDict(zip(problem.names, spread.tolist(), strict=True)),
    )


def telling(choice: LawChoice, *, preloads: Sequence[float] = PRELOADS) -> Iterator[Telling]:
    """For each law not excluded, yield the run whose readings differ most from those under the law used.

    Source: atkinson1975 (a design to tell two models apart), one run, linear in the unknowns at the fits.
    """
    used, others = choice.alone, [one.fit for one in choice.candidates if one.law in choice.undecided]
    candidates = _candidates(used, preloads)
    if not len(candidates):
        return
    rows = _rows(used, candidates)
    jacobian = used.problem.jacobian(used.unknowns)
    known = np.linalg.inv(jacobian.T @ jacobian + 1e-12 * np.eye(used.unknowns.size))
    for other in others:
        if other.law == used.law:
            continue
        expected = [_expected(fit, candidates) for fit in (used, other)]
        apart = []
        for row, off in zip(rows, expected[1] - expected[0], strict=True):
            spread = used.widened**2 * (np.eye(len(off)) + row @ known @ row.T)
            apart.append(float(np.sqrt(off @ np.linalg.solve(spread, off))))
        best = int(np.argmax(apart))
        yield Telling((used.law, other.law), _setting(candidates, best), apart[best])


def _expected(found: Fit, candidates: RigData) -> np.ndarray:
    """Residuals of each candidate run under a fit, in standard deviations. (n, m)"""
    other = found.problem.about(candidates)
    return other.of_rows(other.residuals(_unknowns_of(found, other)))


def _candidates(found: Fit, preloads: Sequence[float]) -> RigData:
    """Feasible runs, with the readings that the fit predicts."""
    problem = found.problem
    drive, rig = problem.drive, problem.rig
    settings = np.asarray(protocol(drive, rig, ratios=RATIOS, loads=(*LOADS, 0.8), preloads=preloads))
    angle, mass, preload = settings.T
    speed, one = drive.cylinder_speed, np.ones(len(settings))
    data = RigData(
        steering_angle=angle,
        mass=mass,
        preload=preload,
        duration=one,
        cylinder_angle=speed * one,
        # First guess: the link follows the steering angle; if locked, the load.
        link_travel=np.where(angle == 0, -1.0, -np.tan(angle) * speed),
        motor_current=0.0 * one,
        motor_voltage=0.0 * one if "motor_voltage" in problem.data.signals else None,
        lines=tuple(range(len(settings))),
    )
    predicted = predict(drive, rig, data, problem.values(found.unknowns))
    possible = np.isfinite(predicted.link_travel) & (np.abs(predicted.motor_voltage) <= drive.motor.voltage)
    possible &= (predicted.link_travel * data.link_travel > 0) | ~data.pressed
    length = np.asarray(
        [window(rig, travel) if ok else 1.0 for travel, ok in zip(predicted.link_travel, possible, strict=True)]
    )
    possible &= length * rig.sample_rate >= 20
    done = replace(
        data,
        duration=length,
        cylinder_angle=speed * length,
        link_travel=predicted.link_travel * length,
        motor_current=predicted.motor_current,
        motor_voltage=None if data.motor_voltage is None else predicted.motor_voltage,
    )
    return done.chosen(possible)


def _rows(found: Fit, candidates: RigData) -> list[np.ndarray]:
    """Derivatives of the readings of each candidate with respect to the unknowns, its mass taken as known."""
    problem = found.problem
    other = problem.about(candidates)
    own = [place for place, name in enumerate(other.errors) if not name.startswith(OF_MASS)]
    unknowns = _unknowns_of(found, other)
    jacobian = other.jacobian(unknowns)
    width = len(other.noise)
    kept = np.zeros((len(candidates) * width, found.unknowns.size))
    columns = [*range(len(problem.names)), *(len(problem.names) + place for place in own)]
    into = [
        *range(len(problem.names)),
        *(len(problem.names) + problem.errors.index(other.errors[place]) for place in own),
    ]
    kept[:, into] = jacobian[: len(kept)][:, columns]
    return [kept[place * width : (place + 1) * width] for place in range(len(candidates))]


def _unknowns_of(found: Fit, other: Problem) -> np.ndarray:
    """Fitted unknowns for a problem with other runs; new masses count as exact."""
    problem = found.problem
    size = len(problem.names)
    fitted = dict(zip(problem.errors, found.unknowns[size:].tolist(), strict=True))
    errors = [0.0 if name.startswith(OF_MASS) else fitted[name] for name in other.errors]
    return np.concatenate([found.unknowns[:size] * problem.scales / other.scales, errors])


def _setting(candidates: RigData, place: int) -> Setting:
    return Setting(*(float(getattr(candidates, name)[place]) for name in Setting._fields))


class Remedy(NamedTuple):
    """Data that would make a parameter identifiable, and the number of directions that would still not be."""

    words: str
    left: int


def remedies(fit: Fit) -> list[Remedy]:
    """Further data that would make most parameters identifiable.

    Each is tried: the information of the readings that the fitted drive would then give is computed.
    """
    data = fit.problem.data
    if not fit.unidentifiable.size or not isinstance(data, Dynamometer):
        return []
    found = []
    for words, requested in _further(data, fit):
        informed = information(requested.jacobian(fit.unknowns), len(fit.names))
        left = int(np.count_nonzero(np.linalg.eigvalsh(informed) < 1.0))
        if left < fit.unidentifiable.shape[1]:
            found.append(Remedy(words, left))
    least = min((one.left for one in found), default=0)
    return [one for one in found if one.left == least]


def _further(data: Dynamometer, fit: Fit) -> Iterator[tuple[str, Problem]]:
    """Yield further data in words, and the problem with them."""
    problem = fit.problem

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
