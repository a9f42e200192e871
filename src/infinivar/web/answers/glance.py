"""The answer at a glance: which drive or machine is the best, by how much, what limits each, and what the answer hangs on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import infinivar as iv
from infinivar.analysis.compare import Comparison
from infinivar.analysis.machines import MachineComparison
from infinivar.limits import words_of
from infinivar.units import margin_words, plain
from infinivar.web.answers.answer import Answer
from infinivar.web.answers.document import key_of, stamp, study_of
from infinivar.web.answers.recent import Recent

_KEPT = 16
"""Comparisons kept."""

_compared: Recent[str, Comparison | MachineComparison] = Recent(_KEPT)


def compared(payload: Mapping[str, Any]) -> Comparison | MachineComparison:
    """The quick comparison of the study of a request, which has drives or machines with something to do; kept."""
    study = study_of(payload)
    key = key_of(payload["name"], payload["tables"], stamp())
    if key not in _compared:
        _compared[key] = iv.compare(study, quick=True)
    return _compared[key]


def glance(payload: Mapping[str, Any]) -> Answer:
    """The answer in a sentence, what it hangs on, and one row a drive or machine; no rows for a study of sessions.

    Rows: name, title, whether it is able and the best, the figure that decides (as number and as text), how far that is above
    the least, the tightest limit, its margin (as number and as text), and the mass in words.
    """
    study = study_of(payload)
    if not (study.requirement or study.duty or study.tasks or study.paths):
        return Answer(header={"rows": [], "reason": "sessions have no winner"})
    found = compared(payload)
    hanging = found.hangs_on
    assert hanging is not None  # of each comparison by `compare`
    used, best = hanging.used, hanging.used.winner
    rows = []
    for name, title in hanging.titles.items():
        figure, (margin, limit) = used.figures[name], tightest(found, name)
        rows.append(
            {
                "name": name,
                "title": title,
                "able": used.able[name],
                "best": name == best,
                "figure": figure,
                "shown": f"{plain(figure, 3)} {hanging.unit}" if math.isfinite(figure) else "–",
                "more": "" if best in (None, name) else _more(figure, used.figures[best]),
                "limit": limit,
                "margin": margin,
                "margin_shown": margin_words(margin) if math.isfinite(margin) else "",
                "weighs": found.masses[name].known_words
                if isinstance(found, Comparison) and name in found.masses
                else "",
            }
        )
    return Answer(
        header={
            "rows": rows,
            "what": "Drive" if isinstance(found, Comparison) else "Machine",
            "figure": hanging.figure,
            "headline": hanging.headline,
            "turned_by": hanging.turned_by,
            "decided": hanging.decided,
            "verdict": found.verdict,
        }
    )


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
