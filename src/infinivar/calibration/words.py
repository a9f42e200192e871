"""A calibration in words: values with their intervals, what the data say of the creep law, what a reader has to know."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from infinivar import units
from infinivar.calibration import misread, model, plan
from infinivar.calibration.data import LeftOut, RigData
from infinivar.calibration.fit import Fit
from infinivar.calibration.laws import DECIDED, LAW_ERROR, LawChoice
from infinivar.calibration.virtual_rig import Setting
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.spreads import NORMAL_95
from infinivar.units import plain

_ALIKE = 0.01
"""Chi-square by which two laws differ that the runs do not tell apart at all: rounding is far less."""

_PLENTY = 100.0
"""Standard deviations beyond which their number says nothing more."""

_WIDER = 1.1
"""Factor on an interval from which on its cause is named."""


def combined(combination: Any) -> str:
    """A sum of parameters in words: "rolling_torque + 1.2 bearing_torque = 2.84 ± 0.21 mN m" (95 %)."""
    terms = []
    for name, weight in combination.weights.items():
        size = "" if abs(abs(weight) - 1.0) < 5e-4 else f"{plain(abs(weight), 3)} "
        sign = "-" if weight < 0 else "+"
        terms.append(f"{sign} {size}{name}" if terms else f"{'-' if weight < 0 else ''}{size}{name}")
    first = model.PARAMETERS[next(iter(combination.weights))]
    return f"{' '.join(terms)} = {with_interval(combination.value, combination.deviation, first)}"


def with_interval(value: float | None, deviation: float, parameter: model.Parameter) -> str:
    """A value, if there is one, with half its 95 % interval in the unit in which people read it."""
    scale = units.parse(f"1 {parameter.shown_in}", parameter.unit) if parameter.shown_in != "1" else 1.0
    half = NORMAL_95 * deviation / scale
    digits = max(0, 1 - math.floor(math.log10(half))) if 0 < half < math.inf else 3
    shown = "inf" if math.isinf(half) else f"{half:.{digits}f}"
    return f"{'' if value is None else f'{value / scale:.{digits}f} '}± {shown} {parameter.shown_in}"


def described(setting: Setting) -> str:
    """A run in words."""
    if setting.preload == 0:
        return "wheel lifted off, cylinder at speed"
    weight = f"{setting.mass:.3f} kg, preload {plain(setting.preload)} N"
    if setting.steering_angle == 0:
        return f"locked, {weight}"
    degrees = math.degrees(setting.steering_angle)
    return f"{plain(1.0 / abs(math.tan(setting.steering_angle)), 3)}:1 ({degrees:+.3f} deg), {weight}"


def on_law(laws: LawChoice) -> str:
    """What the data say of the creep law, by how much, and which is used."""
    best, used, left = laws.best, laws.fit.law, laws.undecided
    if laws.contradicted:
        behind = next((one.behind for one in laws.candidates if one.law == laws.asked), None)
        said = (
            f"The study's creep law, {laws.asked}, was not held against the data; {best.law} fits best."
            if behind is None
            else f"The data contradict the study's creep law: {best.law} fits better than {laws.asked} by {_by(behind)}."
        )
        between = f" They do not decide between {_apart(laws)}." if len(left) > 1 else ""
        return f"{said}{between} The fit and the calibrated study use {used}."
    if len(left) == 1:
        second = laws.candidates[1]
        return f"The data prefer the study's creep law, {used}: the next best, {second.law}, is worse by {_by(second.behind)}."
    return f"The data do not decide between the creep laws {_apart(laws)}. The fit uses the study's, {used}."


def _by(behind: float) -> str:
    odds = f"{math.exp(0.5 * behind):.1g} to 1" if behind < 60.0 else "more than 1e13 to 1"
    return f"{plain(behind, 3)} in chi-square (odds of {odds})"


def _apart(laws: LawChoice) -> str:
    """The laws left open, each with how far it is behind the best."""
    best, *others = (one for one in laws.candidates if one.law in laws.undecided)
    said = [f"{one.law} (no run tells it from {best.law})" if one.behind < _ALIKE else f"{one.law} ({plain(one.behind, 2)} worse)"
            for one in others]  # fmt: skip
    return _listed([best.law, *said])


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def warnings(laws: LawChoice) -> Iterator[str]:
    """What a reader of the result has to know before any number of it."""
    if laws.gain >= DECIDED:
        yield (
            f"No creep law fits as it stands: {laws.best.law} fits better by {_by(laws.gain)} once it may bend more or less. "
            "The intervals are those of a law whose bend is not known."
        )
    if laws.contradicted:
        yield on_law(laws)


def remarks(
    laws: LawChoice, proposed: plan.Plan, data: RigData, left_out: Sequence[LeftOut], drive: CoboticDrive
) -> Iterator[str]:
    """What a reader of the result has to know, in sentences."""
    yield from warnings(laws)
    yield from _on_fit_of_laws(laws, proposed)
    yield from _on_parameters(laws.fit, proposed)
    yield from _on_runs(laws, data, left_out)
    if drive.gearhead.loss_model == "proportional":
        yield (
            "The gearhead loses in proportion to its load, which Eq 18 counts as the element's: those efficiencies are too low. "
            "The fit takes the gearhead's loss into account."
        )


def _on_fit_of_laws(laws: LawChoice, proposed: plan.Plan) -> Iterator[str]:
    if len(laws.candidates) > 1 and not laws.contradicted:
        yield on_law(laws)
    wider = [
        f"{name} {plain(laws.fit.deviations[name] / laws.alone.deviations[name], 2)} times"
        for name in laws.fit.told
        if laws.fit.deviations[name] > _WIDER * laws.alone.deviations[name]
    ]
    if wider:
        bend = (
            f"an error of {100 * LAW_ERROR:.0f} % in how far a law bends"
            if laws.gain < DECIDED
            else "a bend that is free"
        )
        counted = f"the spread between the laws left open, and {bend}" if len(laws.undecided) > 1 else bend
        yield f"The uncertainty of the creep law widens intervals: {_listed(wider)}. It counts {counted}."
    for one in proposed.telling:
        yield _on_telling(one)


def _on_telling(one: plan.Telling) -> str:
    names, run = " and ".join(one.between), described(one.setting)
    if one.apart**2 < DECIDED:
        return (
            f"No single run tells {names} apart: the readings differ most, by {plain(one.apart, 2)} standard deviations, "
            f"at {run}."
        )
    size = plain(one.apart, 2) if one.apart < _PLENTY else f"more than {_PLENTY:.0f}"
    return f"To tell {names} apart, make this run: {run}. Its readings differ by {size} standard deviations."


def _on_parameters(fit: Fit, proposed: plan.Plan) -> Iterator[str]:
    for combination in fit.combinations:
        names = " and ".join(combination.weights)
        if len(combination.weights) > 1:
            yield (
                f"The data cannot tell {names} apart, only {combined(combination)}. In the calibrated drive they keep the "
                "proportions of the study."
            )
    for name in fit.names:
        if name not in fit.told and not any(name in combination.weights for combination in fit.combinations):
            yield f"The data say nothing about {name}: it stays as the study has it."
    apart = [name for name in fit.names if not math.isfinite(proposed.deviations[name])]
    if apart:
        yield (
            f"The runs proposed do not tell {' and '.join(apart)} apart either: with this rig's sensors no preload between "
            f"{min(plan.PRELOADS):g} and {max(plan.PRELOADS):g} of the study's does."
        )
    low = fit.problem.bounds[0]
    for place, name in enumerate(fit.names):
        if fit.unknowns[place] < low[place] + 1e-3:
            yield f"The fit of {name} ended at its lower bound, zero: its interval means little."


def _on_runs(laws: LawChoice, data: RigData, left_out: Sequence[LeftOut]) -> Iterator[str]:
    fit = laws.fit
    if left_out:
        lines = ", ".join(str(one.line) for one in left_out)
        yield f"Left out: line{'s' if len(left_out) > 1 else ''} {lines}."
        kind = misread.pattern(data, [one.row for one in left_out])
        if kind:
            yield f"Left out are {kind}: check that setting, and whether the model holds there."
    if fit.widened > 1.0:
        tried = "with every creep law " if len(laws.candidates) > 1 else ""
        yield (
            f"The residuals are {tried}{plain(fit.widened, 2)} times what the rig's sensors explain, and all intervals are "
            "widened by that: look for a pattern in them, or for a sensor that is worse than [rig] says."
        )
    if not np.any(~data.pressed):
        yield "No run has the wheel lifted off: the nominal torque follows from the others by the model alone."
