"""What the page begins with: the study of the command line with its first maps, the shipped ones, and what was left behind."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

from infinivar import __version__
from infinivar.study.load import read_tables
from infinivar.study.shipped import shipped_studies
from infinivar.web.answers.answer import Answer, FaultyError
from infinivar.web.answers.document import begin_again, source, stamp
from infinivar.web.answers.maps import maps
from infinivar.web.answers.payload import MOST_CELLS, whole

MOST_MAPS = 2
"""Drives shown at first: the first, and the last, which a study lists to compare it with."""


def start(payload: Mapping[str, Any]) -> Answer:
    """What the page begins with; with `count`, also the maps of `most` drives, as `maps` answers them.

    With `again` the files of the study are read anew.
    """
    if payload.get("again") is True:
        begin_again()
    begun = source()
    header = {
        "version": __version__,
        "study": {"name": begun.name, "tables": begun.tables},
        "stamp": begun.stamp,
        "shipped": _shipped(),
        "recovered": _recovered(payload),
    }
    if "count" not in payload:
        return Answer(header=header)
    asked = {**header["study"], "count": whole(payload, "count", 8, MOST_CELLS)}
    names = list(begun.tables.get("drives", {}))
    shown = dict.fromkeys([*names[:1], *names[-1:]][: whole(payload, "most", 1, MOST_MAPS, MOST_MAPS)])
    try:
        made = maps({**asked, "drives": list(shown)})
    except FaultyError:  # a file may have changed since: the page asks again, and is told
        return Answer(header=header)
    return Answer(header={**header, "maps": made.header}, arrays=made.arrays)


def disk(payload: Mapping[str, Any]) -> Answer:
    """Whether the files of the study have changed: the same stamp as in `start` if they have not."""
    return Answer(header={"stamp": stamp()})


def _recovered(payload: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What pages of servers before this one edited last, as the server found it."""
    found = payload.get("recovered")
    listed = [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []
    return [
        {**{key: str(one.get(key, "")) for key in ("id", "name", "time")}, "tables": one["tables"]}
        for one in listed
        if isinstance(one.get("tables"), dict)
    ]


@functools.cache
def _shipped() -> list[dict[str, str]]:
    listed = []
    for name, file in shipped_studies().items():
        tables = read_tables(file)
        listed.append({"name": name, "title": tables.get("title", name), "description": tables.get("description", "")})
    return listed
