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

_MUCH_LESS = 0.5
"""Share of its residual that a law leaves with two columns exchanged, below which the exchange is named."""

_TRIED = 6
"""Corrections of a file that are fitted."""

_LARGE = 0.5
"""Share of the squared residuals above which a drift is named; noise of 40 rows has 0.03, its 99.99 % point 0.3."""

_FEWEST = 8
"""Rows from which on a drift can be told."""


def _corrected(rows: MeasuredRows) -> Iterator[tuple[str, MeasuredRows]]:
    """Yield corrections of columns, each with what it would mean."""
    names = [*rows.law.known, *rows.signals]
    whole = dict(zip(names, np.concatenate([rows.columns, rows.read], axis=1).T, strict=True))
    unit = {name: rows.factors.get(name, 1.0) for name in names}
    varied = [name for name in names if len(np.unique(np.abs(whole[name]))) > 1]

    def made(sources: Mapping[str, tuple[str, float]]) -> MeasuredRows:
        """Rows in which columns are a multiple of others."""

        def changed(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
            new = {name: factor * columns[other] for name, (other, factor) in sources.items() if other in columns}
            return {**columns, **new}

        found = changed(whole)
        return replace(
            rows,
            columns=np.stack([found[name] for name in rows.law.known], axis=-1),
            read=np.stack([found[name] for name in rows.signals], axis=-1),
            history={run: changed(one) for run, one in rows.history.items()},
        )

    for one, other in itertools.combinations(varied, 2):
        ratio = unit[one] / unit[other]
        said = f"{one} and {other} fit if their columns are exchanged"
        yield said, made({one: (other, ratio), other: (one, 1.0 / ratio)})
    for name, (factor, cause) in itertools.product(varied, FACTORS.items()):
        yield f"{name} fits if divided by {plain(factor, 4)}: {cause}", made({name: (name, 1.0 / factor)})
    for place, name in enumerate(rows.signals):
        if rows.read[:, place].min() < 0.0 < rows.read[:, place].max():
            size = rows.read.copy()
            size[:, place] = np.abs(size[:, place])
            yield f"{name} fits without its sign: the bench has its size in both directions", replace(rows, read=size)


def of_rows(fit: Fit, rows: MeasuredRows) -> dict[int, str]:
    """Likely causes of the rows that do not fit, by index of the row; "" where no correction explains one."""
    if rows.law.evolves or not fit.outliers:
        return dict.fromkeys(fit.outliers, "")
    problem, far = fit.problem, {}
    for said, changed in _corrected(rows):
        with np.errstate(all="ignore"):
            off = np.abs(changed.read - problem.about(changed).expected(fit.unknowns)) / problem.noise
        for row in fit.outliers:
            worst = float(off[row].max())
            if worst < min(_SOUND, far.get(row, ("", _SOUND))[1]):
                far[row] = (said, worst)
    return {row: far[row][0] if row in far else "" for row in fit.outliers}


def of_columns(rows: MeasuredRows) -> list[str]:
    """Known columns that cannot be what they are read as, being out of their range."""
    found = []
    for name, (least, most) in rows.law.ranges.items():
        low, high = (float(one(rows.known_columns[name])) for one in (np.min, np.max))
        if low < least or high > most:
            unit = rows.law.known[name].removeprefix("1")
            read, allowed = (
                f"{plain(one, 4)} to {plain(other, 4)} {unit}".rstrip() for one, other in ((low, high), (least, most))
            )
            found.append(f"{name} reads {read}, but must be {allowed}: check its unit and column")
    return found


def of_file(rows: MeasuredRows) -> list[str]:
    """Faults of whole columns: the law fails, or parameters are far from their first guesses; and what corrects it.

    Only guesses that the set states count. The rows are under a form that has their parameters.
    """
    stated = {name: start for name, start in rows.starts.items() if name in rows.usual and start > 0.0}
    if not stated:
        return []
    # A correction that is wrong may have powers of negative numbers.
    with np.errstate(all="ignore"):
        found = _tried(rows)
        off = _suspicious(found, stated)
        if off:
            return [f"{'; '.join(off)}: {_remedy(rows, stated) or 'check the units and columns'}"]
        better = None if found is None or rows.law.evolves else _exchanged(rows, stated, _misfit(found))
        return [better] if better else []


def _exchanged(rows: MeasuredRows, stated: Mapping[str, float], left: float) -> str | None:
    """The exchange of two columns that leaves much less of the readings, by parameters as near to their first guesses."""
    best: tuple[float, str | None] = (_MUCH_LESS * left, None)
    for said, changed in _corrected(rows):
        if not said.endswith("exchanged"):
            return best[1]
        found = _tried(changed)
        if found is not None and _misfit(found) < best[0] and not _suspicious(found, stated):
            share = f"the law leaves {left:.2g} of the readings, and {_misfit(found):.2g}"
            best = _misfit(found), f"{share} with two columns exchanged: {said}"
    return best[1]


def _remedy(rows: MeasuredRows, stated: Mapping[str, float]) -> str:
    """The correction that brings the parameters nearest to their first guesses; "" if none does.

    Those that fit best with the first guesses are tried.
    """
    near = sorted(_corrected(rows), key=lambda one: _misfit_at(Problem.of(None, Rig(), one[1], rows.usual)))
    best: tuple[float, str] = (math.inf, "")
    for said, changed in near[:_TRIED]:
        found = _tried(changed)
        if found is None or not math.isfinite(found.chi_square) or _suspicious(found, stated):
            continue
        worst = max(abs(math.log(found.values[name] / start)) for name, start in stated.items()) + _misfit(found)
        if worst < best[0]:
            best = worst, said
    return best[1]


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
    return _misfit_at(fit.problem, fit.unknowns)


def _misfit_at(problem: Problem, unknowns: np.ndarray | None = None) -> float:
    """The same at other values, by default the first guesses; infinite where the law gives no number."""
    read = problem.data.read
    off = read - problem.expected(problem.start if unknowns is None else unknowns)
    found = float(np.sqrt(np.mean(np.mean(off**2, axis=0) / np.mean(read**2, axis=0))))
    return found if math.isfinite(found) else math.inf


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
