"""A report on a measured set as text and as dictionaries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from infinivar._core.described import dictionary
from infinivar.calibration.measured.outcome import Part, Residual
from infinivar.calibration.measured.sets import MeasuredSet
from infinivar.calibration.words import combined, estimate
from infinivar.units import plain

_SMALL = {"N m": ("mN m", 1e3, 0.1)}
"""Unit in which small values are shown, its factor, and the size below which they are small."""


def scaled(size: float, unit: str) -> tuple[str, float]:
    """Unit in which values of a size are shown, and its factor."""
    small, factor, below = _SMALL.get(unit, (unit, 1.0, 0.0))
    return (small, factor) if abs(size) < below else (unit, 1.0)


def shown(value: float, unit: str) -> str:
    """Format a residual."""
    used, factor = scaled(value, unit)
    return f"{plain(value * factor, 3)} {used}"


def residual_of(one: Residual) -> dict[str, Any]:
    """Dictionary of a residual."""
    return {**dictionary(one), "goal_met": one.met}


def part_of(part: Part) -> dict[str, Any]:
    """Dictionary of a part."""
    return {
        "part": part.name,
        "form": part.form,
        "at_bounds": list(part.at_bounds),
        "evidence": [dictionary(one) for one in part.evidence],
        **dictionary(part.fit),
        "residuals": [residual_of(one) for one in part.residuals],
        "left_out_lines": [one.to_dict() for one in part.left_out],
        "misread": list(part.misread),
        **({"predicted": [dictionary(one) for one in part.others]} if part.others else {}),
    }


def judged(one: Residual) -> str:
    """Goal of a residual, and whether it is met; "" without one."""
    if one.met is None:
        return ""
    said = f"goal {shown(one.goal, one.unit)}, {'met' if one.met else 'missed'}"
    return said if one.met or not one.reason else f"{said}: {one.reason}"


def lines(one: MeasuredSet, totals: Sequence[Residual], parts: Sequence[Part]) -> Iterator[str]:
    """The report as lines of text."""
    for residual in totals:
        yield _summary(one.name, residual)
    if len(parts) > 1:
        for part in parts:
            for residual in part.residuals:
                yield _summary(f"  {part.name}", residual)
    yield f"{one.title} ({one.source}, {one.licence})"
    for part in parts:
        yield from _details(part)
    if one.not_shown:
        yield f"Not shown: {one.not_shown}"


def _summary(head: str, one: Residual) -> str:
    sizes = f"{shown(one.rms, one.unit)} rms, {shown(one.worst, one.unit)} at worst, mean reading {shown(one.mean, one.unit)}"
    if one.rms_used < one.rms:
        sizes = f"{sizes}; {shown(one.rms_used, one.unit)} rms of the rows that fit"
    goal = judged(one)
    return f"{head}: {one.signal} {sizes}{goal and '; ' + goal}"


def _details(part: Part) -> Iterator[str]:
    fit = part.fit
    yield f"{part.name or 'all rows'}: {len(part.rows)} rows, form {part.form}"
    for name in fit.identifiable:
        yield f"  {name} = {estimate(fit, name).removesuffix(' 1')}"
    apart = [name for name in fit.names if name not in fit.identifiable]
    if apart:
        sums = "; ".join(combined(one, fit) for one in fit.combinations if len(one.weights) > 1)
        yield f"  Not identifiable: {' and '.join(apart)}{', only ' + sums if sums else ''}"
    if bound := part.at_bounds:
        yield f"  At a bound: {' and '.join(bound)}"
    least = min(one.bic for one in part.evidence)
    compared = ", ".join(f"{one.form} {plain(one.bic - least, 3)}" for one in part.evidence)
    yield f"  Evidence (BIC above the least): {compared}"
    for one in part.residuals:
        ranges = ", ".join(
            f"{name} {shown(rms, one.unit)} ({shown(far, one.unit)})" for name, (rms, far) in one.by_range.items()
        )
        yield f"  {one.signal} by thirds of {part.rows.law.over}, rms (worst): {ranges}"
        if math.isfinite(one.left_out_rms):
            yield (
                f"  {one.signal} of rows left out: {shown(one.left_out_rms, one.unit)} rms, "
                f"{shown(one.left_out_worst, one.unit)} at worst; {one.coverage:.0%} within their 95 % intervals"
            )
    for one in part.others:
        yield (
            f"  {one.signal} of {one.rows} further rows: {shown(one.rms, one.unit)} rms, {shown(one.worst, one.unit)} at worst; "
            f"{one.coverage:.0%} within their 95 % intervals"
        )
    for said in of_part(part):
        yield f"  {said}"


def of_part(part: Part) -> Iterator[str]:
    """Faults of columns, and rows that do not fit."""
    for said in part.misread:
        yield f"Misread? {said}"
    for row in part.left_out:
        yield f"Left out: line {row.line}: {row.reason}"


def faults(parts: Sequence[Part], empty: Mapping[int, str]) -> Iterator[str]:
    """Faults of all parts, and rows with empty cells."""
    for part in parts:
        head = f"{part.name}: " if part.name else ""
        yield from (f"{head}{said}" for said in of_part(part))
    yield from (f"Left out: line {line}: {said}" for line, said in empty.items())
