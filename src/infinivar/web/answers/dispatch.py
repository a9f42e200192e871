"""The list of all answers, and the answer to a request."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from infinivar._core.imported import imported
from infinivar.errors import InputError, nearest
from infinivar.web.answers.answer import Answer, FaultyError, RefusedError
from infinivar.web.answers.document import study_of

ANSWERS: dict[str, str] = {
    "start": "infinivar.web.answers.maps:start",
    "disk": "infinivar.web.answers.maps:disk",
    "study": "infinivar.web.answers.studies:study",
    "foremost": "infinivar.web.answers.studies:foremost",
    "open": "infinivar.web.answers.studies:opened",
    "shipped": "infinivar.web.answers.studies:shipped",
    "toml": "infinivar.web.answers.studies:toml",
    "parts": "infinivar.web.answers.catalogue:parts",
    "tried": "infinivar.web.answers.designs:tried",
    "maps": "infinivar.web.answers.maps:maps",
    "judge": "infinivar.web.answers.maps:judge",
    "glance": "infinivar.web.answers.glance:glance",
    "mend": "infinivar.web.answers.mend:mend",
    "options": "infinivar.web.answers.jobs:options",
    "tasks": "infinivar.web.answers.tasks:tasks",
    "export": "infinivar.web.answers.export:export",
    "design": "infinivar.web.answers.designs:design",
    "point": "infinivar.web.answers.point:point",
    "contact": "infinivar.web.answers.contact:contact",
    "motion": "infinivar.web.answers.motion:motion",
    "plane": "infinivar.web.answers.motion:plane",
    "drawing": "infinivar.web.answers.drawing:drawing",
}
"""Function of each answer, "module:function", imported by the first request: from the payload of a request to an `Answer`."""

OF_STUDY = frozenset({"design", "point", "contact", "motion", "plane", "drawing"})
"""Answers about one study: their functions take the study and the payload, and return an `Answer` or its header."""


def answered(name: str, payload: Any) -> Answer:
    """Answer a request; faults of the study are an answer, too.

    Raises
    ------
    RefusedError
        If there is no such answer, or the payload is not one that the page sends.
    """
    if name not in ANSWERS:
        raise RefusedError(f"{name!r} is not an answer{nearest(name, ANSWERS)}; answers: {', '.join(ANSWERS)}")
    if not isinstance(payload, dict):
        raise RefusedError("the request must be a JSON object")
    try:
        if name not in OF_STUDY:
            return function_of(name)(payload)
        found = function_of(name)(study_of(payload), payload)
        return found if isinstance(found, Answer) else Answer(header=found)
    except FaultyError as found:
        return Answer(header={"faults": found.faults})
    except InputError as problem:
        return Answer(header={"faults": [{"at": "", "message": line} for line in str(problem).split("\n")]})


def function_of(name: str) -> Callable[..., Any]:
    """The function of an answer."""
    return imported(ANSWERS[name])
