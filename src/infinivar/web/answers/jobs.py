"""Long computations that the page asks for: sizing and the full comparison, with progress."""

from __future__ import annotations

import tempfile
import typing
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import infinivar as iv
from infinivar.analysis.options import CompareOptions
from infinivar.analysis.sessions.measures import measures
from infinivar.errors import InputError, nearest
from infinivar.figures import style
from infinivar.options import Option, Options
from infinivar.report.run import session_to_dict
from infinivar.report.saving import save
from infinivar.sizing.options import SizeOptions
from infinivar.web.answers.answer import Answer, FaultyError, RefusedError, plain
from infinivar.web.answers.document import study_of
from infinivar.web.answers.payload import flag, number, text, whole, word

JOBS = frozenset({"job"})
"""Names of requests for long computations."""

_KINDS = ("size", "compare", "session")

_OPTIONS: Mapping[str, type[Options]] = {"compare": CompareOptions, "size": SizeOptions}
"""Options of the computations that have any; the page offers all but those below and those that name files."""

_HELD = {"builds": 0}
"""Options with a value of the page's own, as it shows nothing of them."""

_MOST = {"top": 50, "generations": 100}
"""Largest numbers that a page may ask for."""

_WITHOUT_BOUND = 1_000_000_000
"""Largest whole number of other options."""

Report = Callable[[float, str], None]


def worked(payload: Mapping[str, Any], report: Report) -> Answer:
    """Do the work; `report` receives the share done and the current step."""
    kind = word(payload, "job", _KINDS)
    try:
        study = study_of(payload)
        if kind == "size":
            return _sized(study, payload, report)
        if kind == "session":
            return _session(study, payload, report)
        return _compared(study, payload, report)
    except FaultyError as found:
        return Answer(header={"faults": found.faults})
    except InputError as problem:
        return Answer(header={"faults": [{"at": "", "message": line} for line in str(problem).split("\n")]})


def options(payload: Mapping[str, Any]) -> Answer:
    """What the page asks for beside the study: rows of a form for each computation."""
    return Answer(header={"jobs": {job: list(_form(kind)) for job, kind in _OPTIONS.items()}})


def _offered(kind: type[Options]) -> Iterator[tuple[str, Option]]:
    """Yield the options that a page has, by name."""
    for name, known in kind.described().items():
        if not known.of_files and name not in _HELD:
            yield name, known


def _form(kind: type[Options]) -> Iterator[dict[str, Any]]:
    """Yield a row for each option: its name, label and help, what is entered, its bounds, choices and default."""
    for name, known in _offered(kind):
        shown = {bool: "flag", int: "whole", float: "number"}.get(known.stated, "text")
        yield {
            "name": name,
            "label": name.replace("_", " "),
            "help": known.help,
            "type": "choice" if known.choices else shown,
            "choices": list(known.choices) or None,
            "least": known.least,
            "most": _MOST.get(name),
            "usual": kind.usual(name),
        }


def stated(kind: type[Options], payload: Mapping[str, Any]) -> dict[str, Any]:
    """Options that a page states, as arguments; those it does not offer are refused.

    Raises
    ------
    RefusedError
        If a value is of another kind than the form gives.
    InputError
        If a text cannot be read.
    """
    said, offered = payload.get("options", {}), dict(_offered(kind))
    if not isinstance(said, dict):
        raise RefusedError("options must be a JSON object")
    for name in said:
        if name not in offered:
            raise RefusedError(f"options: {name!r} is not one{nearest(name, offered)}")
    read = kind.read({name: _entered(said, name, offered[name]) for name in said}, lambda name: name.replace("_", " "))
    return {name: _HELD.get(name, value) for name, value in read.arguments().items()}


def _entered(said: Mapping[str, Any], name: str, known: Option) -> Any:
    """One option as a form gives it."""
    least = known.least or 0
    if known.stated is bool:
        return flag(said, name)
    if known.stated is int:
        return whole(said, name, int(least), _MOST.get(name, _WITHOUT_BOUND))
    if known.stated is float:
        value = number(said, name)
        if value < least:
            raise RefusedError(f"{name} must be at least {least:g}")
        return value
    entered = text(said, name)
    several = typing.get_origin(known.stated)
    if several is None:
        return entered
    parts = [part.strip() for part in entered.split(",")]
    if several is tuple and len(parts) != len(typing.get_args(known.stated)):
        raise InputError(
            f"{name} {entered!r} must be {len(typing.get_args(known.stated))} values, separated by a comma"
        )
    return parts


def _compared(study: Any, payload: Mapping[str, Any], report: Report) -> Answer:
    """The comparison, by default with sampled builds and simulated duty cycles."""
    options = stated(CompareOptions, payload)
    found = iv.compare(study, **options, progress=lambda title, share: report(share, title))
    return Answer(
        header={
            "job": "compare",
            "verdict": found.verdict,
            "hangs": _hanging(found.hangs_on),
            "result": plain(found.to_dict()),
            "figures": _figures(found, report),
        }
    )


def _figures(found: Any, report: Report) -> list[dict[str, str]]:
    """The figures that the command writes, in its order: what each shows, and a drawing to be shown in a page."""
    report(1.0, "drawing")
    with tempfile.TemporaryDirectory() as folder, style.written_as("svg"):
        files = [one for one in save(found, Path(folder) / "report") if one.suffix == ".svg"]
        return [{"title": _title_of(one.stem), "image": style.inline_svg([one])} for one in files]


def _title_of(stem: str) -> str:
    """What a figure shows, from the name of its file: "Duty walking" of report-duty-walking."""
    return stem.partition("-")[2].replace("-", " ").capitalize()


def _hanging(found: iv.analysis.Hanging | None) -> dict[str, Any] | None:
    """What a verdict hangs on, as a table of texts; None if nothing has an effect."""
    if found is None or not found.rows:
        return None
    heads = [found.titles.get(head, head) for head in found.heading]
    return {"figure": found.figure, "heads": heads, "rows": [list(cells) for cells in found.cells]}


def _sized(study: Any, payload: Mapping[str, Any], report: Report) -> Answer:
    """The best drives among all parts of the catalogue."""
    options = stated(SizeOptions, payload)
    found = iv.size(study, **options, progress=lambda words, share: report(share, words))
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
            "figures": _figures(found, report),
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
            "figures": _figures(found, report),
        }
    )
