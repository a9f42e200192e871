"""An answer to the page: a header of plain values and arrays of numbers, packed into bytes; and the list of all answers.

The packed form: the length of the header as 4 bytes, little endian; the header as JSON in UTF-8, padded with spaces so that the
arrays start at a multiple of 8 bytes; the arrays one after another, each at a multiple of 8 bytes from the first. The header
lists them in `arrays`: name, dtype, shape and offset from the start of the first.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np

from infinivar.errors import InputError, nearest

_ALIGNED = 8
_DTYPES = ("float32", "float64", "uint8")

ANSWERS: dict[str, str] = {
    "start": "infinivar.web.answers.start:start",
    "disk": "infinivar.web.answers.start:disk",
    "study": "infinivar.web.answers.studies:study",
    "open": "infinivar.web.answers.studies:opened",
    "shipped": "infinivar.web.answers.studies:shipped",
    "toml": "infinivar.web.answers.studies:toml",
    "parts": "infinivar.web.answers.catalogue:parts",
    "maps": "infinivar.web.answers.maps:maps",
    "judge": "infinivar.web.answers.maps:judge",
    "tasks": "infinivar.web.answers.tasks:tasks",
    "export": "infinivar.web.answers.export:export",
    "point": "infinivar.web.answers.point:point",
    "contact": "infinivar.web.answers.contact:contact",
    "motion": "infinivar.web.answers.motion:motion",
    "plane": "infinivar.web.answers.plane:plane",
    "drawing": "infinivar.web.answers.drawing:drawing",
}
"""Function of each answer, "module:function", loaded when first asked: from the payload of a request to an `Answer`."""

OF_STUDY = frozenset({"point", "contact", "motion", "plane", "drawing"})
"""Answers about one study: their functions take the study and the payload, and return an `Answer` or its header."""


class RefusedError(Exception):
    """A request that no page of the explorer sends; the message says what is wrong with it."""


class FaultyError(Exception):
    """A study with faults: where each is, as a path such as "drives.cobotic.transmission", and what is wrong, in words."""

    def __init__(self, faults: list[dict[str, str]]) -> None:
        """State the faults."""
        super().__init__("; ".join(fault["message"] for fault in faults))
        self.faults = faults


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What the page gets.

    Attributes
    ----------
    header   Plain values: text, numbers, lists and mappings. Numbers that are not finite become null.
    arrays   By name, of float32, float64 or uint8; nan stands for "no value here".
    """

    header: Mapping[str, Any]
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict)

    def pack(self) -> bytes:
        """The answer in bytes."""
        listed, parts, offset = [], [], 0
        for name, array in self.arrays.items():
            if array.dtype.name not in _DTYPES:
                raise TypeError(f"array {name} of {array.dtype.name} must be one of {', '.join(_DTYPES)}")
            content = np.ascontiguousarray(array.astype(array.dtype.newbyteorder("<"), copy=False)).tobytes()
            listed.append({"name": name, "dtype": array.dtype.name, "shape": list(array.shape), "offset": offset})
            padded = content + b"\0" * (-len(content) % _ALIGNED)
            parts.append(padded)
            offset += len(padded)
        return b"".join([_packed_header({**self.header, "arrays": listed}), *parts])


def _packed_header(header: Mapping[str, Any]) -> bytes:
    text = json.dumps(plain(header), separators=(",", ":"), allow_nan=False).encode("ascii")
    text += b" " * (-(len(text) + 4) % _ALIGNED)
    return struct.pack("<I", len(text)) + text


def unpack(content: bytes) -> Answer:
    """The answer that was packed; the arrays are read-only."""
    (length,) = struct.unpack_from("<I", content)
    header = json.loads(content[4 : 4 + length])
    start, arrays = 4 + length, {}
    for one in header.pop("arrays"):
        count = math.prod(one["shape"])
        dtype = np.dtype(one["dtype"]).newbyteorder("<")
        found = np.frombuffer(content, dtype, count, start + one["offset"])
        arrays[one["name"]] = found.reshape(one["shape"])
    return Answer(header=header, arrays=arrays)


def plain(value: Any) -> Any:
    """A value as JSON has it: numbers that are not finite become None, tuples lists, arrays nested lists."""
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int | bool):
        return value
    return str(value)


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
        from infinivar.web.answers.document import study_of

        found = function_of(name)(study_of(payload), payload)
        return found if isinstance(found, Answer) else Answer(header=found)
    except FaultyError as found:
        return Answer(header={"faults": found.faults})
    except InputError as problem:
        return Answer(header={"faults": [{"at": "", "message": line} for line in str(problem).split("\n")]})


def function_of(name: str) -> Callable[..., Any]:
    """The function of an answer."""
    module, _, function = ANSWERS[name].partition(":")
    return getattr(import_module(module), function)
