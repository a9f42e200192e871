"""What notebooks show of results before their figure: the answer first, then one row a drive or machine; plain HTML."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

import numpy as np

from infinivar.analysis.at_a_glance import at_a_glance
from infinivar.analysis.compare import Comparison, compare
from infinivar.analysis.machines import MachineComparison
from infinivar.analysis.plane import place
from infinivar.analysis.steady_map import SteadyMap
from infinivar.errors import InfinivarError
from infinivar.limits import Limit
from infinivar.study.study import Study
from infinivar.units import plain

_LEFT = "text-align:left"


def comparison(found: Comparison | MachineComparison) -> str:
    """Headline, what it hangs on, and one row a drive or machine."""
    hanging = found.hangs_on
    if hanging is None:
        return _answer(type(found).__name__, found.verdict)
    heads = (
        "",
        "Drive" if isinstance(found, Comparison) else "Machine",
        hanging.figure,
        "above best",
        "tightest limit",
        "margin",
    )
    rows = at_a_glance(found)
    weighed = any(one.weighs for one in rows)
    cells = [
        (
            "✓" if one.able else "✗",
            one.title,
            one.shown,
            "best" if one.best else one.more,
            one.limit,
            one.margin_shown,
            *([one.weighs] if weighed else []),
        )
        for one in rows
    ]
    bold = {place for place, one in enumerate(rows) if one.best}
    table = _table((*heads, *(["mass"] if weighed else [])), cells, bold)
    return _answer(hanging.headline, hanging.turned_by) + table + _folded("verdict", found.verdict)


def steady_map(found: SteadyMap) -> str:
    """Best efficiency and where, and the share of the plane within limits and beyond each."""
    within = found.limit == Limit.OK
    known = np.where(within, found.efficiency, np.nan)
    if np.isfinite(known).any():
        row, column = np.unravel_index(np.nanargmax(known), known.shape)
        where = place(found.axis, float(found.force[column]), float(found.speed[row]))
        best = f"Efficiency up to {plain(100.0 * float(known[row, column]), 3)} % at {where}"
    else:
        best = "No point of the plane has an efficiency"
    codes, counts = np.unique(found.limit[~within], return_counts=True)
    shares = sorted(
        ((int(count), Limit(int(code)).words) for code, count in zip(codes, counts, strict=True)), reverse=True
    )
    cells = [("within all limits", f"{_percent(within.mean())} %")]
    cells += [(f"beyond {words}", f"{_percent(count / within.size)} %") for count, words in shares]
    speeds, forces = found.axis.speed_unit, found.axis.force_unit
    size = f"{len(found.speed)} x {len(found.force)} points"
    plane = (
        f"{plain(float(found.speed[0]), 3)} to {plain(float(found.speed[-1]), 3)} {speeds}, "
        f"{plain(float(found.force[0]), 3)} to {plain(float(found.force[-1]), 3)} {forces}, {size}"
    )
    return _answer(best, plane) + _table(("", "share of the plane"), cells)


def study(found: Study) -> str:
    """The quick comparison of its drives or machines, where it requires something of them; else what it contains."""
    contents = _table(
        ("", "contents"), [(name, value) for name, value in found._rows() if name not in ("title", "description")]
    )
    if not (found.requirement or found.duty or found.tasks or found.paths):
        return _answer(found.title, found.description) + contents
    try:
        shown = compare(found, quick=True)._repr_html_()
    except InfinivarError as problem:  # a study that cannot be compared can be looked at
        shown = _answer("", str(problem))
    return _answer(found.title, found.description) + shown + f"<details><summary>contents</summary>{contents}</details>"


def _percent(share: float) -> str:
    return plain(100.0 * float(share), 3)


def _answer(first: str, then: str) -> str:
    return f"<p><b>{html.escape(first)}</b><br>{html.escape(then)}</p>"


def _folded(title: str, text: str) -> str:
    return f"<details><summary>{html.escape(title)}</summary><p>{html.escape(text)}</p></details>"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], bold: Iterable[int] = ()) -> str:
    """A table of texts, some rows in bold."""
    head = "".join(f"<th style='{_LEFT}'>{html.escape(one)}</th>" for one in heads)
    body = []
    for place_, cells in enumerate(rows):
        weight = ";font-weight:bold" if place_ in set(bold) else ""
        body.append("".join(f"<td style='{_LEFT}{weight}'>{html.escape(one)}</td>" for one in cells))
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(f'<tr>{one}</tr>' for one in body)}</tbody></table>"
