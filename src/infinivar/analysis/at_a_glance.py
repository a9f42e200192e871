"""The answer at a glance: one row a drive or machine, with the figure that decides, the tightest limit and the mass."""

from __future__ import annotations

import math
from typing import NamedTuple

from infinivar.analysis.compare import Comparison
from infinivar.analysis.machines import MachineComparison
from infinivar.limits import words_of
from infinivar.units import margin_words, plain


class Row(NamedTuple):
    """What decides on one drive or machine."""

    name: str
    title: str
    able: bool
    """Whether it meets all that is required."""
    best: bool
    figure: float
    """That decides, see `Hanging.figure`; nan or inf if there is none."""
    shown: str
    more: str
    """How far that is above the least; "" where that says nothing."""
    limit: str
    """The tightest limit in all that is required."""
    margin: float
    margin_shown: str
    weighs: str
    """Mass in words; "" if it is not known."""


def at_a_glance(found: Comparison | MachineComparison) -> tuple[Row, ...]:
    """One row a drive or machine, of a comparison that states what it hangs on, as `compare` returns it."""
    hanging = found.hangs_on
    assert hanging is not None
    used, best = hanging.used, hanging.used.winner
    rows = []
    for name, title in hanging.titles.items():
        figure, (margin, limit) = used.figures[name], tightest(found, name)
        rows.append(
            Row(
                name=name,
                title=title,
                able=used.able[name],
                best=name == best,
                figure=figure,
                shown=f"{plain(figure, 3)} {hanging.unit}" if math.isfinite(figure) else "–",
                more="" if best in (None, name) else _more(figure, used.figures[best]),
                limit=limit,
                margin=margin,
                margin_shown=margin_words(margin) if math.isfinite(margin) else "",
                weighs=found.masses[name].known_words if isinstance(found, Comparison) and name in found.masses else "",
            )
        )
    return tuple(rows)


def _more(figure: float, least: float) -> str:
    """How far a figure is above the least one; "" where that says nothing."""
    return f"{100.0 * (figure / least - 1.0):+.0f} %" if least > 0.0 and math.isfinite(figure) else ""


def tightest(found: Comparison | MachineComparison, name: str) -> tuple[float, str]:
    """Least margin in all that is required, and the limit in words."""
    if isinstance(found, MachineComparison):
        tight = min(found.results[name].found.values(), key=lambda one: one.margin)
        return tight.margin, words_of(tight.demand)
    margins = [
        (cycle.results[name].tightest[1], words_of(cycle.results[name].tightest[0])) for cycle in found.duty.values()
    ]
    of_region = found.results[name].tightest
    if of_region is not None:
        margins.append((of_region.value, of_region.limit.words))
    return min(margins, default=(math.inf, ""))
