"""Text of a file and its encoding, as loggers, spreadsheets and editors write it."""

from __future__ import annotations

import re
from typing import NamedTuple

from infinivar.errors import InputError

_BINARY = {
    b"PK\x03\x04": "an Excel workbook or another archive; export the sheet as CSV",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook; export the sheet as CSV",
    b"\x89HDF": "an HDF5 or new MATLAB file; export the columns as CSV",
    b"MATLAB": "a MATLAB file; export the columns as CSV",
    b"\x1f\x8b": "compressed with gzip; decompress it first",
    b"%PDF": "a PDF document; export the columns as CSV",
}
"""First bytes of files that are no text, with what they are."""

_CONTROL = re.compile("[\x00-\x08\x0e-\x1f\x7f]")
_BESIDE_LATIN_1 = re.compile(b"[\x80-\x9f]")
"""Bytes that Latin-1 and Windows-1252 read differently."""


class Text(NamedTuple):
    """Lines of a text file, and the encoding that they were read with, in words."""

    lines: list[str]
    encoding: str


def text_of(file: str, content: bytes) -> Text:
    """Decode a text file: UTF-8 or UTF-16 by its byte-order mark, UTF-8, or headings in Latin-1.

    Parameters
    ----------
    file : str        Name of the file in messages, printable.
    content : bytes

    Returns
    -------
    Text   Lines without their ends.

    Raises
    ------
    InputError
        If the file is empty, no text, or in an encoding that it does not reveal; the message names the line.
    """
    if not content.strip():
        raise InputError(f"{file}: line 1: must name the columns, but the file is empty")
    for first, what in _BINARY.items():
        if content.startswith(first):
            raise InputError(f"{file}: line 1, character 1: is not text; the file seems to be {what}")
    text, encoding = _decoded(file, content)
    wrong = _CONTROL.search(text)
    if wrong:
        line = text.count("\n", 0, wrong.start()) + 1
        place = wrong.start() - (text.rfind("\n", 0, wrong.start()) + 1) + 1
        hint = "; UTF-16 needs a byte-order mark" if wrong[0] == "\0" else ""
        raise InputError(
            f"{file}: line {line}, character {place}: is {wrong[0]!r}, which is no text; the file may be binary{hint}"
        )
    return Text(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), encoding)


def _decoded(file: str, content: bytes) -> tuple[str, str]:
    """Return the text and its encoding in words."""
    marked = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        if marked:
            return content.decode("utf-16"), "UTF-16"
        if content.startswith(b"\xef\xbb\xbf"):
            return content.decode("utf-8-sig"), "UTF-8 with byte-order mark"
        return content.decode("utf-8"), "UTF-8"
    except UnicodeDecodeError as problem:
        if marked:
            raise InputError(
                f"{file}: byte {problem.start}: is not UTF-16, which its byte-order mark announces"
            ) from None
        line = content.count(b"\n", 0, problem.start) + 1
        place = problem.start - (content.rfind(b"\n", 0, problem.start) + 1) + 1
        if _BESIDE_LATIN_1.search(content):
            raise InputError(
                f"{file}: line {line}, character {place}: is neither UTF-8 nor Latin-1; save the file as UTF-8"
            ) from None
    return content.decode("latin-1"), "Latin-1"
