"""Storage and motion files of OpenSim (.sto, .mot): a header that ends with ``endheader``, then columns between tabs or blanks.

Lengths, forces and moments of OpenSim are in SI; ``inDegrees`` states the unit of angles.
"""

from __future__ import annotations

import re
from typing import NamedTuple, NoReturn

from infinivar._core.encodings import Text
from infinivar.errors import InputError
from infinivar.motion.files.headings import Heading, bracketed, heading_of
from infinivar.motion.files.sheet import TextSheet, is_comment, shown

_END = "endheader"
_LONGEST_HEADER = 200
_LINE = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:=|\s)\s*(.*?)\s*")
_COUNTS = {"nrows": "rows", "datarows": "rows", "ncolumns": "columns", "datacolumns": "columns"}
_GENERALIZED = {"_moment": "N m", "_force": "N"}
"""Units of generalized forces by the end of their headings, as inverse dynamics writes them."""


class _Entry(NamedTuple):
    """An entry of the header: line, key and text."""

    line: int
    key: str
    text: str


def looks_like_opensim(lines: list[str]) -> bool:
    """Whether lines are those of an OpenSim file: its header ends with a certain word."""
    return any(line.strip().lower() == _END for line in lines[:_LONGEST_HEADER])


class OpenSimSheet(TextSheet):
    """Rows of an OpenSim file."""

    __slots__ = ()

    def usual_unit(self, role: str, heading: Heading) -> str | None:
        """Unit that the format states: by ``inDegrees`` for angles, else by the kind of generalized force."""
        if role in self.units:
            return self.units[role]
        ends = next((unit for end, unit in _GENERALIZED.items() if heading.text.endswith(end)), None)
        return ends if ends == {"moment": "N m", "force": "N"}.get(role) else None


def opensim(file: str, text: Text) -> OpenSimSheet:
    """Read the header of an OpenSim file and check what it states about its columns and rows.

    Raises
    ------
    InputError
        If the header does not end, or states other numbers of rows or columns than the file has; the message names the line.
    """
    lines = text.lines
    end = next((place for place, line in enumerate(lines) if line.strip().lower() == _END), None)
    if end is None:
        raise InputError(
            f"{file}: line {min(len(lines), _LONGEST_HEADER)}, column 1: must be {_END!r} here or above, the end of the header "
            "of an OpenSim file"
        )
    stated = _stated(file, lines[:end])
    below = [place for place in range(end + 1, len(lines)) if not is_comment(lines[place])]
    if not below:
        raise InputError(f"{file}: line {end + 2}, column 1: must name the columns below {_END!r}; the file ends there")
    header = below[0]
    mark = "\t" if "\t" in lines[header] else None
    written = [cell.strip() for cell in lines[header].strip().split(mark)]
    said = stated.get("indegrees", _Entry(0, "", ""))
    degrees = said.text.lower()
    angle = {"yes": "deg", "true": "deg", "1": "deg", "no": "rad", "false": "rad", "0": "rad"}.get(degrees)
    if degrees and angle is None:
        _refuse(file, said.line, said.key, f"must be yes or no, got {shown(degrees)}")
    sheet = OpenSimSheet(
        file=file,
        kind=f"OpenSim storage{f' with angles in {angle}' if angle else ''}",
        encoding=text.encoding,
        lines=[line.strip() for line in lines],
        mark=mark,
        header=header + 1,
        headings=tuple(bracketed(one) if "/" in one else heading_of(one) for one in written),
        start=header + 1,
        units={"time": "s", **({"angle": angle, "angular_speed": f"{angle}/s"} if angle else {})},
    )
    counts = {"rows": len(below) - 1, "columns": len(written)}
    for name, entry in stated.items():
        what = _COUNTS.get(name)
        if what is not None and entry.text != str(counts[what]):
            _refuse(file, entry.line, entry.key, f"states {shown(entry.text)} {what}, but the file has {counts[what]}")
    return sheet


def _stated(file: str, lines: list[str]) -> dict[str, _Entry]:
    """Return what the header states, by key in lower case."""
    found: dict[str, _Entry] = {}
    for number, line in enumerate(lines, 1):
        entry = _LINE.fullmatch(line)
        if entry:
            found[entry[1].lower()] = _Entry(number, entry[1], entry[2])
    line, _, kind = found.get("datatype", _Entry(0, "", "double"))
    if kind.lower() not in ("double", "float"):
        _refuse(file, line, "DataType", f"must be double, one number per column, got {shown(kind)}")
    return found


def _refuse(file: str, line: int, key: str, said: str) -> NoReturn:
    raise InputError(f"{file}: line {line}, {key}: {said}")
