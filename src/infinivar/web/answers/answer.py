"""An answer to the page: a header of plain values and arrays of numbers, packed into bytes; and the list of all answers.

The packed form: the length of the header as 4 bytes, little endian; the header as JSON in UTF-8, padded with spaces so that the
arrays start at a multiple of 8 bytes; the arrays one after another, each at a multiple of 8 bytes from the first. The header
lists them in `arrays`: name, dtype, shape and offset from the start of the first.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

_ALIGNED = 8
_DTYPES = ("float32", "float64", "uint8")


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
