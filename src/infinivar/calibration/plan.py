"""What to measure next: the runs that narrow the intervals most (D-optimal design)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.calibration.data import RigData
from infinivar.calibration.fit import Fit, information
from infinivar.calibration.laws import LawChoice
from infinivar.calibration.model import predict
from infinivar.calibration.problem import Problem
from infinivar.calibration.virtual_rig import LOADS, RATIOS, Setting, protocol, window

PRELOADS = (0.4, 0.7, 1.0)
"""Of the study's, among which runs are chosen: more would stress the contact beyond what it was made for."""

RUNS = 4
"""Proposed at once."""

_GUESS = 1.0
"""Relative standard deviation that stands for what is not known before any run."""


class Telling(NamedTuple):
    """A run that tells two creep laws apart."""

    between: tuple[str, str]
    setting: Setting
    apart: float
    """Standard deviations between its readings under the two, with what the parameters are known to be off by."""


@result
class Plan(Frozen):
    """Runs to make next.

    Attributes
    ----------
    settings : in the order in which they help most.
    deviations : standard deviations expected after them, by parameter; inf where they still do not tell. [SI]
    telling : of each law that is left open beside the one used, the run that tells the two apart best.
    """

    settings: tuple[Setting, ...]
    deviations: Mapping[str, float]
    telling: tuple[Telling, ...] = ()


def propose(found: Fit, *, preloads: Sequence[float] = PRELOADS, count: int = RUNS) -> Plan:
    """The runs that add most to what is known of the fitted parameters, one after another.

    Each is the one that makes the determinant of the information largest, with what the session's errors take off taken
    off; what nothing tells yet counts as known to 100 %.

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
    untold = directions[:, after < 1.0 / _GUESS**2]
    spread = np.sqrt(np.diag(np.linalg.inv(information(whole, size) + 1e-12 * prior)))
    spread = np.where(np.any(np.abs(untold) > 0.1, axis=1), np.inf, found.widened * spread * problem.scales)
    return Plan(
        settings=tuple(_setting(candidates, place) for place in chosen),
        deviations=FrozenDict(zip(problem.names, spread.tolist(), strict=True)),
    )


def telling(choice: LawChoice, *, preloads: Sequence[float] = PRELOADS) -> Iterator[Telling]:
    """For each law left open: the run at which it and the law used expect readings that differ most.

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
    """Readings less what a fit expects of each candidate, in standard deviations. (n, m)"""
    other = found.problem.about(candidates)
    return other.of_runs(other.residuals(_unknowns_of(found, other)))


def _candidates(found: Fit, preloads: Sequence[float]) -> RigData:
    """Runs that the drive can do, with the readings that the fit expects."""
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
        # Before anything is known of a run the link goes where the wheel points; locked, where the load pulls.
        link_travel=np.where(angle == 0, -1.0, -np.tan(angle) * speed),
        motor_current=0.0 * one,
        motor_voltage=None if problem.data.motor_voltage is None else 0.0 * one,
        lines=tuple(range(len(settings))),
    )
    told = predict(drive, rig, data, problem.values(found.unknowns))
    possible = np.isfinite(told.link_travel) & (np.abs(told.motor_voltage) <= drive.motor.voltage)
    possible &= (told.link_travel * data.link_travel > 0) | ~data.pressed
    length = np.asarray(
        [window(rig, travel) if ok else 1.0 for travel, ok in zip(told.link_travel, possible, strict=True)]
    )
    possible &= length * rig.sample_rate >= 20
    done = replace(
        data,
        duration=length,
        cylinder_angle=speed * length,
        link_travel=told.link_travel * length,
        motor_current=told.motor_current,
        motor_voltage=None if data.motor_voltage is None else told.motor_voltage,
    )
    return done.chosen(possible)


def _rows(found: Fit, candidates: RigData) -> list[np.ndarray]:
    """Derivatives of the readings of each candidate by the unknowns of the problem; its mass counts as known."""
    problem = found.problem
    other = problem.about(candidates)
    own = [place for place, name in enumerate(other.errors) if not name.startswith("mass")]
    unknowns = _unknowns_of(found, other)
    jacobian = other.jacobian(unknowns)
    width = other.whitening.shape[-1]
    kept = np.zeros((len(candidates) * width, found.unknowns.size))
    columns = [*range(len(problem.names)), *(len(problem.names) + place for place in own)]
    into = [
        *range(len(problem.names)),
        *(len(problem.names) + problem.errors.index(other.errors[place]) for place in own),
    ]
    kept[:, into] = jacobian[: len(kept)][:, columns]
    return [kept[place * width : (place + 1) * width] for place in range(len(candidates))]


def _unknowns_of(found: Fit, other: Problem) -> np.ndarray:
    """Unknowns of a problem about other runs as a fit has them; masses that it has not weighed count as right."""
    problem = found.problem
    size = len(problem.names)
    fitted = dict(zip(problem.errors, found.unknowns[size:].tolist(), strict=True))
    errors = [0.0 if name.startswith("mass") else fitted[name] for name in other.errors]
    return np.concatenate([found.unknowns[:size] * problem.scales / other.scales, errors])


def _setting(candidates: RigData, place: int) -> Setting:
    return Setting(*(float(getattr(candidates, name)[place]) for name in Setting._fields))
