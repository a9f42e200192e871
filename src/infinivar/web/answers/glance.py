"""The answer at a glance: which drive or machine is the best, by how much, what limits each, and what the answer hangs on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import infinivar as iv
from infinivar.analysis.at_a_glance import at_a_glance
from infinivar.analysis.compare import Comparison
from infinivar.analysis.machines import MachineComparison
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

    Rows: the fields of `at_a_glance.Row`.
    """
    study = study_of(payload)
    if not (study.requirement or study.duty or study.tasks or study.paths):
        return Answer(header={"rows": [], "reason": "sessions have no winner"})
    found = compared(payload)
    hanging = found.hangs_on
    assert hanging is not None  # of each comparison by `compare`
    return Answer(
        header={
            "rows": [row._asdict() for row in at_a_glance(found)],
            "what": "Drive" if isinstance(found, Comparison) else "Machine",
            "figure": hanging.figure,
            "headline": hanging.headline,
            "turned_by": hanging.turned_by,
            "decided": hanging.decided,
            "verdict": found.verdict,
        }
    )
