"""What is wrong with a study file, in one short line each: field, value, what would be right."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from typing import Any

from infinivar.errors import nearest, printable
from infinivar.study.schema import keys, part_of


class StudyError(Exception):
    """Faults found in a study, each "field = value must be ..."; the caller adds the file."""

    @property
    def lines(self) -> tuple[str, ...]:
        """The faults, a line each."""
        return self.args


def explained(error: Mapping[str, Any], part: type, path: str) -> str:
    """A pydantic error as one line: field, value, what would be right."""
    *tables, name = (str(step) for step in error["loc"])
    for step in tables:
        part = typing.cast(type, part_of(typing.get_type_hints(part)[step]))
    field = ".".join([path, *tables, name])
    raw = error["input"]
    shown = f" = {quoted(raw['value'])}" if isinstance(raw, dict) and "value" in raw else ""
    if error["type"] == "missing":
        meaning = next(f.metadata.get("meaning", "") for f in dataclasses.fields(part) if f.name == name)
        table_hint = f"; write a table [{field}]" if part_of(typing.get_type_hints(part)[name]) else ""
        return f"{field} is missing ({meaning}){table_hint}"
    if error["type"] == "extra_forbidden":
        known = keys(part)
        field = ".".join([path, *tables, printable(name)])
        return f"{field}{shown} is not a known key{nearest(name, known)}; known are {', '.join(known)}"
    if error["type"] in ("model_type", "model_attributes_type") or "ctx" not in error:
        return f"{field}{shown} must be a table [{field}]"
    return f"{field}{shown} {error['ctx']['error']}"


def quoted(value: Any) -> str:
    """A value about as the file has it, on one short line."""
    if isinstance(value, str):
        return short(f'"{printable(value)}"')
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**60:
        return "an integer of more than 60 digits" if abs(value) >= 10**4000 else short(str(value))
    return short(printable(str(value).lower() if isinstance(value, bool) else str(value)))


def short(text: str) -> str:
    """Text cut in the middle if it is long."""
    return text if len(text) <= 80 else f"{text[:60]} ... {text[-15:]}"
