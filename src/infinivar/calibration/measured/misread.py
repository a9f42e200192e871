"""Misread data: swapped columns, wrong units, sensors that drift; of single rows and of whole files."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from infinivar.calibration.fit import OUTLIER, Fit, estimate
from infinivar.calibration.measured.law import MeasuredRows
from infinivar.calibration.problem import Problem
from infinivar.study.rig import Rig
from infinivar.units import plain

FACTORS = {
    1e3: "is it in thousandths of the unit?",
    1e-3: "is it in thousands of the unit?",
    30.0 / math.pi: "is it in rpm?",
    180.0 / math.pi: "is it in degrees?",
    math.pi / 30.0: "was rpm stated for rad/s?",
    math.pi / 180.0: "were degrees stated for radians?",
}
"""Value read over the right one, where a unit is wrong, and the likely cause."""

FAR = 5.0
"""Factor on a first guess beyond which a parameter is suspicious."""

_SOUND = 3.0
"""Deviation of a corrected reading that counts as explained, in standard deviations."""

_FAILS = 0.5
"""Share of the readings, root mean square, that a law leaves when it fails; laws of measured sets leave 0.1 to 20 %."""

_LARGE = 0.5
"""Share of the squared residuals above which a drift is named; noise of 40 rows has 0.03, its 99.99 % point 0.3."""

_FEWEST = 8
"""Rows from which on a drift can be told."""


def _corrected(rows: MeasuredRows) -> Iterator[tuple[str, MeasuredRows]]:
    """Yield corrections of columns, each with what it would mean."""
    names = [*rows.law.known, *rows.signals]
    whole = np.concatenate([rows.columns, rows.read], axis=1)
    units = np.array([rows.factors.get(name, 1.0) for name in names])
    varied = [place for place in range(len(names)) if len(np.unique(np.abs(whole[:, place]))) > 1]

    def made(changed: np.ndarray) -> MeasuredRows:
        split = rows.columns.shape[1]
        return replace(rows, columns=changed[:, :split], read=changed[:, split:])

    for one, other in itertools.combinations(varied, 2):
        changed = whole.copy()
        changed[:, [one, other]] = whole[:, [other, one]] * (units[[one, other]] / units[[other, one]])
        yield f"{names[one]} and {names[other]} fit if their columns are exchanged", made(changed)
    for place, (factor, cause) in itertools.product(varied, FACTORS.items()):
        changed = whole.copy()
        changed[:, place] /= factor
        yield f"{names[place]} fits if divided by {plain(factor, 4)}: {cause}", made(changed)


def of_rows(fit: Fit, rows: MeasuredRows) -> dict[int, str]:
    """Likely causes of the rows that do not fit, by index of the row; "" where no correction explains one."""
    if rows.law.evolves or not fit.outliers:
        return dict.fromkeys(fit.outliers, "")
    problem, far = fit.problem, {}
    for said, changed in _corrected(rows):
        off = np.abs(changed.read - problem.about(changed).expected(fit.unknowns)) / problem.noise
        for row in fit.outliers:
            worst = float(off[row].max())
            if worst < min(_SOUND, far.get(row, ("", _SOUND))[1]):
                far[row] = (said, worst)
    return {row: far[row][0] if row in far else "" for row in fit.outliers}


def of_file(rows: MeasuredRows) -> list[str]:
    """Faults of whole columns: the law fails, or parameters are far from their first guesses; and what corrects it.

    Only guesses that the set states count. The rows are under a form that has their parameters.
    """
    stated = {name: start for name, start in rows.starts.items() if name in rows.usual and start > 0.0}
    if not stated:
        return []
    whole = _tried(rows)
    off = _suspicious(whole, stated)
    if not off:
        return []
    best: tuple[float, str] = (math.inf, "")
    for said, changed in _corrected(rows):
        found = _tried(changed)
        if found is None or _suspicious(found, stated):
            continue
        worst = max(abs(math.log(found.values[name] / start)) for name, start in stated.items()) + _misfit(found)
        if worst < best[0]:
            best = worst, said
    return [f"{'; '.join(off)}: {best[1] or 'check the units and columns'}"]


def _tried(rows: MeasuredRows) -> Fit | None:
    """Least squares from the first guesses; None if it fails."""
    problem = Problem.of(None, Rig(), rows, rows.usual)
    try:
        return estimate(problem, problem.start, np.zeros(len(rows), dtype=bool))
    except (ValueError, np.linalg.LinAlgError):
        return None


def _suspicious(fit: Fit | None, stated: Mapping[str, float]) -> list[str]:
    if fit is None:
        return ["the law cannot be fitted"]
    left = _misfit(fit)
    found = [f"the law leaves {left:.0%} of the readings"] if left > _FAILS else []
    for name, start in stated.items():
        ratio = max(fit.values[name], 1e-300) / start
        # A small value that is uncertain is no contradiction.
        near = abs(fit.values[name] - start) < OUTLIER * fit.deviations[name] and math.isfinite(fit.deviations[name])
        if not 1.0 / FAR < ratio < FAR and not near:
            found.append(f"{name} is {plain(ratio, 3)} times the first guess")
    return found


def _misfit(fit: Fit) -> float:
    """Root mean square of the residuals over that of the readings."""
    data = fit.problem.data
    off = data.read - fit.problem.expected(fit.unknowns)
    return float(np.sqrt(np.mean(np.mean(off**2, axis=0) / np.mean(data.read**2, axis=0))))


def drifts(rows: MeasuredRows, residual: np.ndarray) -> list[str]:
    """Readings whose residuals follow a line over the rows of the file, where no column of the set does."""
    found = []
    count = len(rows)
    if count < _FEWEST or rows.law.evolves:
        return []
    order = np.argsort(rows.lines)
    time = np.linspace(-1.0, 1.0, count)
    for place, name in enumerate(rows.signals):
        off = residual[order, place] - residual[:, place].mean()
        slope = float(off @ time / (time @ time))
        share = slope**2 * float(time @ time) / max(float(off @ off), 1e-300)
        if share > _LARGE:
            change = f"{plain(2.0 * slope, 3)} {rows.units[name]}"
            found.append(
                f"{name} drifts by {change} from the first row to the last, {share:.0%} of the squared residuals"
            )
    return found
