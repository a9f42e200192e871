"""Text of a calibration: values with intervals, verdict on the creep law, warnings and remarks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from infinivar import units
from infinivar._core.text import joined
from infinivar.calibration import misread, model, plan
from infinivar.calibration.data import LeftOut, RigData
from infinivar.calibration.fit import Fit
from infinivar.calibration.laws import DECIDED, LawChoice, curvature_error
from infinivar.calibration.virtual_rig import Setting
from infinivar.contact import creep
from infinivar.contact.exact_law import STEEL_CIRCLE
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.spreads import NORMAL_95
from infinivar.transmission.rolling_contact import MEASURED
from infinivar.units import plain

_ALIKE = 0.01
"""Chi-square difference below which two laws are indistinguishable; rounding is far smaller."""

_PLENTY = 100.0
"""Number of standard deviations above which the exact number is irrelevant."""

_SHAPED = 0.002
"""Difference of forces, over the slip force, above which the patch of the calibrated study is named; the law is good to this."""

_WIDER = 1.1
"""Widening factor of an interval above which its cause is named."""


def combined(combination: Any, parameters: Mapping[str, model.Parameter] = model.PARAMETERS) -> str:
    """Format a sum of parameters: "rolling_torque + 1.2 bearing_torque = 2.84 ± 0.21 mN m" (95 %)."""
    terms = []
    for name, weight in combination.weights.items():
        size = "" if abs(abs(weight) - 1.0) < 5e-4 else f"{plain(abs(weight), 3)} "
        sign = "-" if weight < 0 else "+"
        terms.append(f"{sign} {size}{name}" if terms else f"{'-' if weight < 0 else ''}{size}{name}")
    first = parameters[next(iter(combination.weights))]
    return f"{' '.join(terms)} = {with_interval(combination.value, combination.deviation, first)}"


def with_interval(value: float | None, deviation: float, parameter: model.Parameter) -> str:
    """Format a value, if any, and half its 95 % interval in the display unit."""
    scale = units.parse(f"1 {parameter.shown_in}", parameter.unit) if parameter.shown_in != "1" else 1.0
    half = NORMAL_95 * deviation / scale
    digits = max(0, 1 - math.floor(math.log10(half))) if 0 < half < math.inf else 3
    shown = "inf" if math.isinf(half) else f"{half:.{digits}f}"
    return f"{'' if value is None else f'{value / scale:.{digits}f} '}± {shown} {parameter.shown_in}"


def described(setting: Setting) -> str:
    """Describe a run."""
    if setting.preload == 0:
        return "wheel lifted off, cylinder at speed"
    weight = f"{setting.mass:.3f} kg, preload {plain(setting.preload)} N"
    if setting.steering_angle == 0:
        return f"locked, {weight}"
    degrees = math.degrees(setting.steering_angle)
    return f"{plain(1.0 / abs(math.tan(setting.steering_angle)), 3)}:1 ({degrees:+.3f} deg), {weight}"


def on_law(laws: LawChoice) -> str:
    """Verdict of the data on the creep law, with odds, and the law used."""
    best, used, left, requested = laws.undecided[0], laws.fit.law, laws.undecided, laws.asked
    approximate = _on_approximations(laws)
    if laws.contradicted:
        behind = None if (own := laws.candidate(requested)) is None else own.behind - _behind(laws, best)
        said = (
            f"The study's creep law, {requested}, was not among the candidates; {best} fits best."
            if behind is None
            else f"The data contradict the study's creep law: {best} fits better than {requested} by {_by(behind)}."
        )
        between = f" Not excluded: {_apart(laws)}." if len(left) > 1 else ""
        return f"{said}{between} The fit and the calibrated study use {used}.{approximate}"
    if len(left) == 1 and requested == best:
        second = next((one for one in laws.candidates if one.law not in laws.left), None)
        by = (
            ""
            if second is None
            else f": the next best, {second.law}, is worse by {_by(second.behind - _behind(laws, best))}"
        )
        return f"The data support the study's creep law, {used}{by}.{approximate}"
    if len(left) == 1:
        return (
            f"The data support {best}, which the study's creep law, {requested}, approximates. The fit uses the study's law."
            f"{approximate}"
        )
    said = f"The data do not discriminate between the creep laws {_apart(laws)}."
    return f"{said} The fit uses the study's law, {used}.{approximate}"


def _on_approximations(laws: LawChoice) -> str:
    """The approximations of a law that is left, each with its chi-square beside it; as a sentence after another."""
    found = []
    for law in laws.undecided:
        agreeing = [one for one in laws.agreeing if creep.LAWS[one].approximates == law]
        if agreeing:
            verbs = ("approximate", "agree") if len(agreeing) > 1 else ("approximates", "agrees")
            beside = joined([f"{_behind(laws, one) - _behind(laws, law):+.1f}" for one in agreeing])
            found.append(
                f" {joined(agreeing)} {verbs[0]} {law} and {verbs[1]} with it within the data (chi-square {beside})."
            )
    return "".join(found)


def _behind(laws: LawChoice, law: str) -> float:
    return next(one.behind for one in laws.candidates if one.law == law)


def _by(behind: float) -> str:
    odds = f"{math.exp(0.5 * behind):.1g} to 1" if behind < 60.0 else "more than 1e13 to 1"
    return f"{plain(behind, 3)} in chi-square (odds of {odds})"


def _apart(laws: LawChoice) -> str:
    """The laws not excluded, each with its chi-square relative to the best."""
    best, *others = (one for one in laws.candidates if one.law in laws.undecided)
    alike, worse = f"indistinguishable from {best.law}", "{} worse"
    said = [f"{one.law} ({alike if one.behind < _ALIKE else worse.format(plain(one.behind, 2))})" for one in others]
    return joined([best.law, *said])


def warnings(laws: LawChoice) -> Iterator[str]:
    """Warnings that come before any number of the result."""
    if laws.gain >= DECIDED:
        yield (
            f"No creep law fits as published: with free curvature, {laws.best.law} fits better by {_by(laws.gain)}. "
            "The intervals allow for unknown curvature."
        )
    if laws.contradicted:
        yield on_law(laws)


def remarks(
    laws: LawChoice, proposed: plan.Plan, data: RigData, left_out: Sequence[LeftOut], drive: CoboticDrive
) -> Iterator[str]:
    """Warnings and remarks on the result, one sentence each."""
    yield from warnings(laws)
    yield from _on_fit_of_laws(laws, proposed)
    yield from _on_parameters(laws.fit, proposed)
    yield from _on_runs(laws, data, left_out)
    yield from _on_patch(laws.fit, drive)
    of_load = drive.gearhead.law().OF_LOAD
    if of_load:
        yield (
            f"The gearhead loss {of_load} its load. Eq 18 attributes it to the transmission, so those efficiencies "
            "are too low; the fit accounts for it."
        )


def _on_fit_of_laws(laws: LawChoice, proposed: plan.Plan) -> Iterator[str]:
    if len(laws.candidates) > 1 and not laws.contradicted:
        yield on_law(laws)
    wider = [
        f"{name} by a factor of {plain(laws.fit.deviations[name] / laws.alone.deviations[name], 2)}"
        for name in laws.fit.told
        if laws.fit.deviations[name] > _WIDER * laws.alone.deviations[name]
    ]
    if wider:
        bend = _on_curvature(laws.left) if laws.gain < DECIDED else "free curvature of the law"
        differences = "the differences between laws not excluded" if len(laws.left) > 1 else ""
        counted = ", and ".join(part for part in (differences, bend) if part)
        yield f"The uncertainty of the creep law widens the interval of {joined(wider)}. It includes {counted}."
    for one in proposed.telling:
        yield _on_telling(one)


def _on_curvature(left: Sequence[str]) -> str:
    """The errors of the laws that are not excluded; "" if all are straight."""
    bent = [law for law in left if not creep.LAWS[law].straight]
    if not bent:
        return ""
    first, *others = sorted({curvature_error(law) for law in bent}, reverse=True)
    own = [
        f", of {100 * other:.0f} % in that of {joined([x for x in bent if curvature_error(x) == other])}"
        for other in others
    ]
    return f"an error of {100 * first:.0f} % in the curvature of a law{''.join(own)}"


def _on_patch(fit: Fit, drive: CoboticDrive) -> Iterator[str]:
    """What a law of the patch loses in the calibrated study, which has no geometry."""
    contact, law = drive.transmission.contact, creep.LAWS[fit.law]
    if contact is None or law.on_patch is None or not any(name in fit.names for name in MEASURED):
        return
    scaled = np.linspace(0.0, 3.0, 100)
    own, assumed = law.on(contact.axis_ratio, contact.poisson), law.on(*STEEL_CIRCLE)
    apart = float(np.abs(own.force(scaled) - assumed.force(scaled)).max())
    if apart > _SHAPED:
        yield (
            f"The calibrated study has measured values in place of the geometry, and its law {law} is that of a circle: forces "
            f"differ by up to {plain(apart, 2)} of the slip force from those of the fitted patch (a/b = "
            f"{plain(contact.axis_ratio, 3)})."
        )


def _on_telling(one: plan.Telling) -> str:
    names, run = " and ".join(one.between), described(one.setting)
    if one.apart**2 < DECIDED:
        return (
            f"No single run discriminates between {names}: their readings differ most, by {plain(one.apart, 2)} standard "
            f"deviations, at {run}."
        )
    size = plain(one.apart, 2) if one.apart < _PLENTY else f"more than {_PLENTY:.0f}"
    return f"To discriminate between {names}, measure {run}: the readings differ by {size} standard deviations."


def _on_parameters(fit: Fit, proposed: plan.Plan) -> Iterator[str]:
    for combination in fit.combinations:
        names = " and ".join(combination.weights)
        if len(combination.weights) > 1:
            yield (
                f"Not identifiable separately: {names}. The data determine only {combined(combination)}; the calibrated drive "
                "keeps the proportions of the study."
            )
    for name in fit.names:
        if name not in fit.told and not any(name in combination.weights for combination in fit.combinations):
            yield f"Not identifiable: {name}. It keeps the value of the study."
    apart = [name for name in fit.names if not math.isfinite(proposed.deviations[name])]
    if apart:
        yield (
            f"The proposed runs do not make {' and '.join(apart)} identifiable: with this rig's sensors, no preload from "
            f"{min(plan.PRELOADS):g} to {max(plan.PRELOADS):g} times the study's does."
        )
    low = fit.problem.bounds[0]
    for place, name in enumerate(fit.names):
        if fit.unknowns[place] < low[place] + 1e-3:
            yield f"The fit of {name} ended at its lower bound, zero, so its interval is not meaningful."


def _on_runs(laws: LawChoice, data: RigData, left_out: Sequence[LeftOut]) -> Iterator[str]:
    fit = laws.fit
    if left_out:
        lines = ", ".join(str(one.line) for one in left_out)
        yield f"Excluded: line{'s' if len(left_out) > 1 else ''} {lines}."
        kind = misread.pattern(data, [one.row for one in left_out])
        if kind:
            yield f"Excluded are {kind}: check that setting, and whether the model is valid there."
    if fit.widened > 1.0:
        tried = " with every creep law" if len(laws.candidates) > 1 else ""
        yield (
            f"The residuals exceed the sensor errors{tried} by a factor of {plain(fit.widened, 2)}, and all intervals are "
            "widened accordingly: look for a pattern in the residuals, or for a sensor worse than stated in [rig]."
        )
    if not np.any(~data.pressed):
        yield "No run has the wheel lifted off, so the nominal torque follows from the other runs through the model only."
