"""Text of a calibration: values with intervals, verdict, warnings and remarks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from infinivar import units
from infinivar._core.text import few, joined
from infinivar.calibration import misread, plan
from infinivar.calibration.bench import Bench, LeftOut, Parameter
from infinivar.calibration.fit import OUTLIER, Combination, Fit
from infinivar.calibration.geared import GearedBench
from infinivar.calibration.laws import DECIDED, LawChoice, curvature_error
from infinivar.calibration.problem import Problem
from infinivar.calibration.transmission import RigData
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

_CORRELATED = 0.9
"""Correlation above which two estimates are named as hard to separate."""

_MOST_LINES = 20
"""Excluded lines that a remark lists where windows of a recording or points are many."""

_OF_POWER = {"resistance", "torque_constant"}

_WIDER = 1.1
"""Widening factor of an interval above which its cause is named."""


def estimate(fit: Fit, name: str) -> str:
    """Format a fitted parameter with its 95 % interval."""
    return with_interval(fit.values[name], fit.deviations[name], fit.parameters[name])


def verdict(fit: Fit) -> str:
    """One line: identifiable parameters and sums with their intervals."""
    each = [f"{name} = {estimate(fit, name)}" for name in fit.identifiable]
    return "; ".join([*each, *(determined(one, fit) for one in fit.combinations)])


def determined(combination: Combination, fit: Fit) -> str:
    """Format what the data determine of parameters that are not identifiable separately.

    Sums hold anywhere for a transmission, and for a geared drive near the estimates.
    """
    said = combined(combination, fit)
    if isinstance(fit.problem.data, RigData):
        return said
    if set(combination.weights) == _OF_POWER:
        return f"resistance / torque_constant^2 = {_of_power(fit)}"
    return said if len(combination.weights) == 1 else f"{said}, near these values"


def combined(combination: Combination, fit: Fit) -> str:
    """Format a sum of parameters: "rolling_torque + 1.2 bearing_torque = 2.84 ± 0.21 mN m" (95 %)."""
    terms = []
    for name, weight in combination.weights.items():
        size = "" if abs(abs(weight) - 1.0) < 5e-4 else f"{plain(abs(weight), 3)} "
        sign = "-" if weight < 0 else "+"
        terms.append(f"{sign} {size}{name}" if terms else f"{'-' if weight < 0 else ''}{size}{name}")
    first = fit.parameters[next(iter(combination.weights))]
    return f"{' '.join(terms)} = {with_interval(combination.value, combination.deviation, first)}"


def _of_power(fit: Fit) -> str:
    """Resistance over the squared torque constant, which sets the winding loss of a torque, with its 95 % interval."""
    resistance, constant = fit.values["resistance"], fit.values["torque_constant"]
    slope = np.zeros(len(fit.names))
    slope[fit.names.index("resistance")] = 1.0 / resistance
    slope[fit.names.index("torque_constant")] = -2.0 / constant
    relative = math.sqrt(max(float(slope @ fit.covariance @ slope), 0.0))
    value = resistance / constant**2
    return f"{plain(value, 4)} ± {plain(NORMAL_95 * relative * value, 2)} W/(N m)^2"


def with_interval(value: float | None, deviation: float, parameter: Parameter) -> str:
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
    best, used, left, requested = laws.undecided[0], laws.fit.law, laws.undecided, laws.of_study
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
        for name in laws.fit.identifiable
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
                f"Not identifiable separately: {names}. The data determine only {combined(combination, fit)}; the calibrated "
                "drive keeps the proportions of the study."
            )
    for name in fit.names:
        if name not in fit.identifiable and not any(name in combination.weights for combination in fit.combinations):
            yield f"Not identifiable: {name}. It keeps the value of the study."
    apart = [name for name in fit.names if not math.isfinite(proposed.deviations[name])]
    if apart:
        yield (
            f"The proposed runs do not make {' and '.join(apart)} identifiable: with this rig's sensors, no preload from "
            f"{min(plan.PRELOADS):g} to {max(plan.PRELOADS):g} times the study's does."
        )
    yield from _on_bounds(fit, 1e-3, "lower bound, zero,")


def _on_bounds(fit: Fit, near: float, bound: str) -> Iterator[str]:
    """Parameters that a fit would make smaller than the model permits."""
    low = fit.problem.bounds[0]
    for place, name in enumerate(fit.names):
        if fit.unknowns[place] < low[place] + near:
            yield f"The fit of {name} ended at its {bound} so its interval is not meaningful."


def _on_left_out(left_out: Sequence[LeftOut], most: int) -> Iterator[str]:
    """The lines of excluded rows, at most `most`."""
    if left_out:
        lines = few([str(one.line) for one in left_out], most)
        yield f"Excluded: line{'s' if len(left_out) > 1 else ''} {lines}."


def _on_runs(laws: LawChoice, data: RigData, left_out: Sequence[LeftOut]) -> Iterator[str]:
    fit = laws.fit
    yield from _on_left_out(left_out, len(left_out))
    if left_out:
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


def remarks_on_gear(fit: Fit, left_out: Sequence[LeftOut]) -> Iterator[str]:
    """Remarks on the result, one sentence each."""
    problem, data = fit.problem, fit.problem.data
    yield from _on_inseparable(fit)
    if isinstance(data, GearedBench) and data.geared:
        yield (
            "Friction of motor and gear add up in these data: the motor keeps that of the study, "
            f"{plain(1e3 * problem.known['motor_friction'], 3)} mN m, and the gear has the rest."
        )
    yield from _on_correlations(fit)
    yield from _on_bounds(fit, 1e-4, "lower bound,")
    yield from _on_left_out(left_out, _MOST_LINES)
    yield (
        "The noise is taken from the residuals: "
        + ", ".join(
            f"{name} {_quantity(data, name, float(size), 3)}"
            for name, size in zip(data.signals, problem.noise, strict=True)
        )
        + ". If the model is wrong, this hides it in part: see the residuals."
    )


def _on_inseparable(fit: Fit) -> Iterator[str]:
    apart = [name for name in fit.names if name not in fit.identifiable]
    combinations = [one for one in fit.combinations if len(one.weights) > 1]
    if apart:
        each = len(apart) == 1
        known = "; ".join(determined(one, fit) for one in combinations)
        yield (
            f"Not identifiable{'' if each else ' separately'}: {' and '.join(apart)}. "
            + (f"The data determine only {known}; the" if known else "The")
            + " calibrated drive stays as close to the study as the data allow."
        )
        helps = plan.remedies(fit)
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


def why_outlier(problem: Problem, unknowns: np.ndarray, row: int) -> str:
    """How far a row, plausible by itself, is from a fit."""
    signal, read, expected, far = problem.first_off(unknowns, row, OUTLIER)
    off = f"the fit expects {_quantity(problem.data, signal, expected)} ({plain(far, 3)} standard deviations off)"
    why = off if math.isfinite(expected) else "by the fit the wheel would slip"
    return f"{signal} is {_quantity(problem.data, signal, read)}, but {why}"


def _quantity(data: Bench, signal: str, value: float, digits: int = 4) -> str:
    unit = data.units[signal]
    return plain(value, digits) if unit == "1" else f"{plain(value, digits)} {unit}"
