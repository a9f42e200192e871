"""Long computations that the page asks for: sizing and the full comparison, with progress."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import infinivar as iv
from infinivar.analysis.sessions.measures import measures
from infinivar.errors import InputError
from infinivar.report.run import session_to_dict
from infinivar.web.answers.answer import Answer, FaultyError, plain
from infinivar.web.answers.document import study_of
from infinivar.web.answers.payload import text, whole, word

JOBS = frozenset({"job"})
"""Names under which a process is asked for a long computation."""

_KINDS = ("size", "compare", "session")
_MOST_DESIGNS = 50
_MOST_GENERATIONS = 100

Report = Callable[[float, str], None]


def worked(payload: Mapping[str, Any], report: Report) -> Answer:
    """Do the work; `report` is told the share done and what is being done."""
    kind = word(payload, "job", _KINDS)
    try:
        study = study_of(payload)
        if kind == "size":
            return _sized(study, payload, report)
        if kind == "session":
            return _session(study, payload, report)
        return _compared(study, report)
    except FaultyError as found:
        return Answer(header={"faults": found.faults})
    except InputError as problem:
        return Answer(header={"faults": [{"at": "", "message": line} for line in str(problem).split("\n")]})


def _compared(study: Any, report: Report) -> Answer:
    """The full comparison, with sampled builds and simulated duty cycles."""
    found = iv.compare(study, progress=lambda title, share: report(share, title))
    return Answer(
        header={
            "job": "compare",
            "verdict": found.verdict,
            "hangs": _hanging(found.hangs_on),
            "result": plain(found.to_dict()),
        }
    )


def _hanging(found: iv.Hanging | None) -> dict[str, Any] | None:
    """What a verdict hangs on, as a table of texts; None if nothing has an effect."""
    if found is None or not found.rows:
        return None
    heads = [found.titles.get(head, head) for head in found.heading]
    return {"figure": found.figure, "heads": heads, "rows": [list(cells) for cells in found.cells]}


def _sized(study: Any, payload: Mapping[str, Any], report: Report) -> Answer:
    """The best drives among all parts of the catalogue."""
    generations = whole(payload, "generations", 1, _MOST_GENERATIONS) if "generations" in payload else None
    found = iv.size(
        study,
        top=whole(payload, "top", 1, _MOST_DESIGNS, 10),
        generations=generations,
        progress=lambda words, share: report(share, words),
    )
    designs = [{"title": found.named(one), "verdict": found.words_of(one)} for one in found.designs]
    return Answer(
        header={
            "job": "size",
            "feasible": found.feasible,
            "verdict": found.verdict,
            "designs": designs,
            "searched": found.searched,
            "notes": list(found.notes),
            "result": plain(found.to_dict()),
        }
    )


def _session(study: Any, payload: Mapping[str, Any], report: Report) -> Answer:
    """A user at the handle of a machine, in one of the study's sessions."""
    task, drive = (text(payload, key, "") or None for key in ("task", "drive"))
    found = iv.study_session(study, task, drive, progress=lambda share: report(share, task or "session"))
    return Answer(
        header={
            "job": "session",
            "title": found.title,
            "feasible": found.feasible,
            "verdict": found.verdict,
            "measures": [str(one) for one in measures(found)],
            "events": list(found.event_lines),
            "result": plain(session_to_dict(found)),
        }
    )
