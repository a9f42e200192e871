"""Bibliography: the works that docstrings, parameter sets and reports cite by key."""

from __future__ import annotations

import functools
import re
from importlib import resources

_ENTRY = re.compile(r"@\w+\{(?P<key>[^,]+),(?P<body>.*?)\n\}", re.DOTALL)
_FIELD = re.compile(r"^\s*(?P<name>\w+)\s*=\s*\{(?P<value>.*?)\},?\s*$", re.MULTILINE | re.DOTALL)


@functools.cache
def entries() -> dict[str, dict[str, str]]:
    """Fields of each entry in ``references.bib``, by key."""
    text = (resources.files("infinivar") / "references.bib").read_text("utf-8")
    return {
        match["key"]: {
            field["name"]: " ".join(field["value"].split()).strip("{}") for field in _FIELD.finditer(match["body"])
        }
        for match in _ENTRY.finditer(text)
    }


def cite(key: str) -> str:
    """One line for a reference list: authors, title, publication, year.

    Raises
    ------
    KeyError
        If the key is not in ``references.bib``.
    """
    entry = entries()[key]
    place = entry.get("journal") or entry.get("booktitle") or entry.get("publisher") or entry.get("howpublished", "")
    return f"{entry['author'].replace(' and ', ', ')}. {entry['title']}. {place}{', ' if place else ''}{entry['year']}."
