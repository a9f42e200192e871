"""What models leave of measured sets: forms compared by evidence, parameters, residuals, and rows predicted from others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.described import derived
from infinivar._core.result import Result, result
from infinivar.calibration.bench import LeftOut
from infinivar.calibration.fit import Fit, estimate, fit
from infinivar.calibration.measured import misread, words
from infinivar.calibration.measured.law import MeasuredRows
from infinivar.calibration.measured.outcome import Evidence, Part, Predicted, Residual, at_bounds
from infinivar.calibration.measured.sets import MeasuredSet, Table, cold, goal_of, read_rows, read_set
from infinivar.calibration.problem import Problem
from infinivar.calibration.words import why_outlier
from infinivar.errors import InputError
from infinivar.study.rig import Rig

DECIDED = 2.0
"""Difference of the Bayesian information criterion below which the simpler form is kept."""

FOLDS = 8
"""Most groups that are left out one after another."""

_THIRDS = ("low", "middle", "high")


@result
class MeasuredReport(Result):
    """A measured set compared with its law.

    Attributes
    ----------
    set : what was measured.
    parts : each part with its fit.
    empty : rows left out as a cell is empty.
    """

    set: MeasuredSet
    parts: tuple[Part, ...]
    empty: Mapping[int, str]

    @derived(key="set")
    def _set(self) -> dict[str, Any]:
        one = self.set
        return {
            "name": one.name,
            "title": one.title,
            "bench": one.law.name,
            "licence": one.licence,
            "source": one.source,
        }

    @derived(key="parts")
    def _parts(self) -> list[dict[str, Any]]:
        return [words.part_of(part) for part in self.parts]

    @derived(key="totals")
    def _totals(self) -> list[dict[str, Any]]:
        return [words.residual_of(one) for one in self.totals]

    @property
    def totals(self) -> tuple[Residual, ...]:
        """Residuals of all parts together, by signal."""
        return tuple(
            _total(self.set, [part.residuals[place] for part in self.parts])
            for place in range(len(self.parts[0].residuals))
        )

    @property
    def sound(self) -> bool:
        """Whether no column is misread and no row was left out."""
        return not any(part.misread or part.left_out for part in self.parts)

    @property
    def lines(self) -> tuple[str, ...]:
        """The report as text."""
        return tuple(words.lines(self.set, self.totals, self.parts))

    @property
    def faults(self) -> tuple[str, ...]:
        """Faults of columns, rows that do not fit, and rows with empty cells."""
        return tuple(words.faults(self.parts, self.empty))

    @property
    def verdict(self) -> str:
        """Residuals of the first line."""
        return self.lines[0]


def measured_report(
    name: str | Path | MeasuredSet, *, rows: str | Path | None = None, predict: str | Path | None = None
) -> MeasuredReport:
    """Compare a measured set with its law.

    Every form of the law is fitted; the Bayesian information criterion chooses one, without those whose parameters end at a
    bound. Groups of rows are then left out one after
    another and predicted by the fit to the others. The half-width of a prediction interval follows from the residuals of the
    *other* left-out groups, so errors of the model count.

    Parameters
    ----------
    name : str, Path or MeasuredSet   Name of a shipped set, or a folder.
    rows : str or Path                File in place of the set's own rows, with the same headings.
    predict : str or Path             File of further rows to predict, not to fit.

    Returns
    -------
    MeasuredReport

    Raises
    ------
    InputError
        If the set cannot be read, or too many rows deviate.

    Source: schwarz1978 (criterion); barber2021 (intervals from left-out residuals).
    """
    one = name if isinstance(name, MeasuredSet) else read_set(name)
    table = read_rows(one, rows)
    other = None if predict is None else read_rows(one, predict)
    for file in (table, other):
        if file is not None and (chilly := cold(file, one.law)):
            raise InputError(f"{file.name}: {' and '.join(chilly)} fall below 150 K: are the values in degC?")
    names = dict.fromkeys(table.texts.get("by", ("",)))
    parts = tuple(_part(one, table, name, other) for name in names)
    return MeasuredReport(set=one, parts=parts, empty=dict(table.empty))


def rows_of(
    one: MeasuredSet, table: Table, part: str, form: str, *, thinned: bool = True
) -> tuple[MeasuredRows, np.ndarray]:
    """Rows of a part under a form, and the group of each row that is left out together."""
    members = np.asarray([said == part for said in table.texts["by"]]) if one.by else np.ones(len(table), dtype=bool)
    names = table.texts.get("run", ("",) * len(table))
    known = sorted(set(np.asarray(names)[members].tolist()))
    run = np.asarray([known.index(said) if said in known else -1 for said in names])
    history = {
        place: {name: values[members & (run == place)] for name, values in table.numbers.items()}
        for place in range(len(known))
        if one.law.evolves
    }
    for place in history:
        lines = np.asarray(table.lines)[members & (run == place)]
        if (late := np.diff(history[place]["time"]) <= 0.0).any():
            where = f"{table.name}: line {lines[1:][late][0]}: time"
            raise InputError(f"{where} does not increase within a run: check columns and the order of rows")
    used = members.copy()
    if thinned:
        for name, least in one.least.items():
            used &= np.abs(table.numbers[name]) >= least
        for name, most in one.most.items():
            used &= np.abs(table.numbers[name]) <= most
        place = np.cumsum(members) - 1
        used &= place % one.every == 0
    if not used.any():
        raise InputError(
            f"{table.name}: no row{' of ' + part if part else ''} is within [least] and [most]: check the units"
        )
    said = table.texts.get("leave_out") or table.texts.get("run")
    groups = np.arange(len(table)) if said is None else np.unique(said, return_inverse=True)[1]
    law = one.law
    rows = MeasuredRows(
        law=law,
        form=form,
        columns=np.stack([table.numbers[name][used] for name in law.known], axis=-1),
        run=run[used],
        settings=one.settings,
        starts=one.starts,
        read=np.stack([table.numbers[name][used] for name in law.read], axis=-1),
        signals=tuple(law.read),
        lines=tuple(np.asarray(table.lines)[used].tolist()),
        name=table.name,
        factors=table.factors,
        history=history,
    )
    order = np.unique(groups[used], return_inverse=True)[1]
    return rows, order % FOLDS


def _fitted(rows: MeasuredRows) -> Fit:
    return fit(Problem.of(None, Rig(), rows, rows.usual))


def _part(one: MeasuredSet, table: Table, part: str, other: Table | None) -> Part:
    fits: dict[str, Fit] = {}
    refused: InputError | None = None
    for form in one.law.forms:
        rows, _ = rows_of(one, table, part, form)
        if len(rows) * len(rows.signals) < 2 * len(rows.usual):
            continue
        try:
            fits[form] = _fitted(rows)
        except InputError as problem:
            refused = problem
    if not fits:
        count = len(rows_of(one, table, part, next(iter(one.law.forms)))[0])
        within = " within [least] and [most]" if one.least or one.most else ""
        raise refused or InputError(f"{table.name}: {count} rows{within} are too few to fit: check the units")
    out = np.zeros(len(rows_of(one, table, part, next(iter(fits)))[0]), dtype=bool)
    for found in fits.values():
        out[list(found.outliers)] = True
    evidence = tuple(_evidence(form, found, out) for form, found in fits.items())
    inside = [one for one in evidence if not at_bounds(fits[one.form])] or evidence
    least = min(one.bic for one in inside)
    form = min((one for one in inside if one.bic <= least + DECIDED), key=lambda one: (one.parameters, one.bic)).form
    chosen = fits[form]
    rows, groups = rows_of(one, table, part, form)
    problem = chosen.problem.about(rows)
    expected = problem.expected(chosen.unknowns)
    beyond = np.zeros(len(rows), dtype=bool)
    beyond[list(chosen.outliers)] = True
    predicted = _left_out(problem, chosen.unknowns, groups, beyond)
    half = _half_widths(rows.read - predicted, groups, beyond)
    causes = misread.of_rows(chosen, rows)
    guessed = next((known for known, found in fits.items() if set(one.starts) <= set(found.names)), form)
    return Part(
        name=part,
        rows=rows,
        fit=chosen,
        evidence=evidence,
        left_out=tuple(
            LeftOut(row, rows.lines[row], _why(problem, chosen, row, causes[row])) for row in chosen.outliers
        ),
        misread=(
            *misread.of_columns(rows),
            *misread.of_file(rows_of(one, table, part, guessed)[0].chosen(~beyond)),
            *misread.drifts(rows, rows.read - expected),
        ),
        expected=expected,
        predicted=predicted,
        half=half,
        residuals=tuple(
            _residual(one, part, rows, expected, predicted, half, beyond, place) for place in range(len(rows.signals))
        ),
        others=() if other is None else _others(one, other, part, form, chosen, half),
    )


def _why(problem: Problem, chosen: Fit, row: int, cause: str) -> str:
    said = why_outlier(problem.separate, chosen.unknowns, row)
    return f"{said}; {cause}" if cause else said


def _evidence(form: str, found: Fit, out: np.ndarray) -> Evidence:
    """Evidence of a form on the rows that no form leaves out."""
    rows = found.problem.data
    kept = ~out[~np.isin(np.arange(len(out)), list(found.outliers))]
    off = (rows.read - found.problem.expected(found.unknowns))[kept]
    mean = np.maximum(np.mean(off**2, axis=0), 1e-300)
    count = len(found.names)
    weighed = np.full(mean.shape, mean.mean()) if rows.alike else mean
    bic = float(len(off) * np.sum(np.log(weighed)) + count * math.log(off.size))
    return Evidence(form=form, parameters=count, rms=tuple(np.sqrt(mean).tolist()), bic=bic)


def _left_out(problem: Problem, start: np.ndarray, groups: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """Readings of each row, predicted by fits without its group; an error of a run that is left out whole is its own."""
    found = np.full(problem.data.read.shape, np.nan)
    for group in np.unique(groups):
        out = groups == group
        kept = ~(out | beyond)
        if np.count_nonzero(kept) * len(problem.noise) < len(problem.names) + 2:
            return found
        unknowns = estimate(replace(problem, whitening=None), start, out | beyond).unknowns
        found[out] = _own(problem, unknowns, out)
    return found


def _own(problem: Problem, unknowns: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Readings of rows left out, after fitting the errors that only their runs have."""
    data: Any = problem.data
    gone = set(np.unique(data.run[out]).tolist()) - set(np.unique(data.run[~out]).tolist())
    free = [len(problem.names) + place for place, name in enumerate(problem.errors) if int(name.split(":")[1]) in gone]
    return _with_free(problem, unknowns, free, out)[out]


def _with_free(problem: Problem, unknowns: np.ndarray, free: list[int], rows: np.ndarray) -> np.ndarray:
    """Readings expected of all rows after fitting some errors to some rows."""
    from scipy.optimize import least_squares

    if not free:
        return problem.expected(unknowns)

    def changed(values: np.ndarray) -> np.ndarray:
        again = unknowns.copy()
        again[free] = values
        return again

    def off(values: np.ndarray) -> np.ndarray:
        residual = (problem.data.read - problem.expected(changed(values)))[rows] / problem.noise
        return np.concatenate([residual.ravel(), values])

    return problem.expected(changed(least_squares(off, np.zeros(len(free)), diff_step=1e-4).x))


def _half_widths(off: np.ndarray, groups: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """Half-widths of 95 % intervals, from the left-out residuals of the other groups. (n, m)"""
    from scipy.special import stdtrit

    half = np.full(off.shape, np.nan)
    for group in np.unique(groups):
        others = (groups != group) & ~beyond & np.isfinite(off[:, 0])
        if np.count_nonzero(others) > 2:
            count = np.count_nonzero(others)
            half[groups == group] = stdtrit(count, 0.975) * np.sqrt(np.mean(off[others] ** 2, axis=0))
    return half


def _residual(
    one: MeasuredSet,
    part: str,
    rows: MeasuredRows,
    expected: np.ndarray,
    predicted: np.ndarray,
    half: np.ndarray,
    beyond: np.ndarray,
    place: int,
) -> Residual:
    signal, off = rows.signals[place], (rows.read - expected)[:, place]
    mean = float(np.mean(np.abs(rows.read[:, place])))
    far = np.abs((rows.read - predicted)[:, place])
    there = np.isfinite(far) & np.isfinite(half[:, place])
    return Residual(
        signal=signal,
        unit=rows.law.read[signal],
        rows=len(rows),
        rms=_rms(off),
        rms_used=_rms(off[~beyond]),
        worst=float(np.max(np.abs(off))),
        mean=mean,
        goal=goal_of(one, f"{signal} {part}", mean),
        by_range=dict(_by_range(rows, off)),
        left_out_rms=_rms(far[np.isfinite(far)]),
        left_out_worst=float(np.max(far[np.isfinite(far)], initial=-math.inf)) if np.isfinite(far).any() else math.nan,
        coverage=float(np.mean(far[there] <= half[there, place])) if there.any() else math.nan,
        reason=one.reasons.get(f"{signal} {part}", ""),
    )


def _total(one: MeasuredSet, each: list[Residual]) -> Residual:
    """Residual of a signal over all parts."""
    rows = np.array([residual.rows for residual in each], dtype=float)
    share = rows / rows.sum()
    there = np.array([math.isfinite(residual.coverage) for residual in each])

    def together(name: str, power: float, weight: np.ndarray) -> float:
        values = np.array([getattr(residual, name) for residual in each])[weight > 0]
        return float((weight[weight > 0] @ values**power / weight.sum()) ** (1.0 / power)) if values.size else math.nan

    first, mean = each[0], together("mean", 1.0, share)
    return replace(
        first,
        rows=int(rows.sum()),
        rms=together("rms", 2.0, share),
        rms_used=together("rms_used", 2.0, share),
        worst=max(residual.worst for residual in each),
        mean=mean,
        goal=goal_of(one, first.signal, mean),
        by_range={},
        left_out_rms=together("left_out_rms", 2.0, share * there),
        left_out_worst=max(
            (residual.left_out_worst for residual in each if math.isfinite(residual.coverage)), default=math.nan
        ),
        coverage=together("coverage", 1.0, share * there),
        reason=one.reasons.get(first.signal, ""),
    )


def _by_range(rows: MeasuredRows, off: np.ndarray) -> list[tuple[str, tuple[float, float]]]:
    """Root mean square and worst residual in thirds of the abscissa's size."""
    over = np.abs(rows.abscissa[0])
    third = np.minimum((3.0 * (over - over.min()) / max(float(np.ptp(over)), 1e-300)).astype(int), 2)
    found = []
    for place, name in enumerate(_THIRDS):
        inside = off[third == place]
        if inside.size:
            found.append((name, (_rms(inside), float(np.max(np.abs(inside))))))
    return found


def _others(
    one: MeasuredSet, other: Table, part: str, form: str, chosen: Fit, half: np.ndarray
) -> tuple[Predicted, ...]:
    """Rows of another file, predicted; errors that only their runs have are fitted to them."""
    if one.by and part not in other.texts["by"]:
        return ()
    rows, _ = rows_of(one, other, part, form)
    problem = replace(Problem.of(None, Rig(), rows, chosen.names), noise=chosen.problem.noise)
    size = len(chosen.names)
    unknowns = np.concatenate([chosen.unknowns[:size], np.zeros(len(problem.errors))])
    expected = _with_free(problem, unknowns, list(range(size, unknowns.size)), np.ones(len(rows), dtype=bool))
    off = np.abs(rows.read - expected)
    width = np.nanmax(half, axis=0, initial=-math.inf) if np.isfinite(half).any() else np.full(off.shape[1], np.nan)
    return tuple(
        Predicted(
            signal=signal,
            unit=rows.law.read[signal],
            rows=len(rows),
            rms=_rms(off[:, place]),
            worst=float(off[:, place].max()),
            coverage=float(np.mean(off[:, place] <= width[place])),
        )
        for place, signal in enumerate(rows.signals)
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else math.nan
