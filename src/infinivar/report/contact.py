"""The contact sheet as text, and its figure and data as files."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from infinivar import units
from infinivar.analysis.contact_sheet import ContactSheet, Line
from infinivar.figures import contact_design, design_trends, style
from infinivar.report.output import all_or_nothing
from infinivar.study.provenance import DEFAULT, Provenance

WIDTH = 118


def text(sheet: ContactSheet) -> str:
    """The sheet for a terminal: results by section, then inputs with their sources."""
    blocks = [f"{sheet.title}\n{'=' * len(sheet.title)}", _filled(sheet.verdict)]
    for section, lines in groupby(sheet.lines, key=lambda line: line.section):
        blocks.append("\n".join([section, *(_result(line) for line in lines)]))
    chosen = [row for row in sheet.given if row.where != DEFAULT]
    blocks.append("\n".join(["Inputs and their sources", *_given(chosen)]))
    defaults = [  # rarely of interest: as running text
        f"{_words(_path(row))} {units.show(row.value, row.unit) if row.unit else row.value}"
        for row in sheet.given
        if row.where == DEFAULT
    ]
    blocks.append(_filled(f"Default values: {', '.join(defaults)}."))
    blocks += [_filled(f"Reconstruction. {statement}") for statement in sheet.reconstruction]
    return "\n\n".join(blocks) + "\n"


def _result(line: Line) -> str:
    known = line.value == line.value
    value = units.show_in(line.value, line.unit, line.shown_in) if known else "–"
    return f"  {line.name:<26} {line.symbol:<8} {value:>13}   {line.how}".rstrip()


def _given(rows: Sequence[Provenance]) -> Iterator[str]:
    """One line per value under its part; a repeated source is written as "same"."""
    part = said = None
    for row in rows:
        *owner, field = _path(row).split(".")
        if owner and owner != part:
            name = next((other.value for other in rows if _path(other).split(".") == [*owner, "name"]), "")
            yield f"  {_words('.'.join(owner))}: {name}".rstrip(": ")
        part = owner
        if field == "name":
            continue
        source = f"{row.kind}: {row.where}"
        indent = "    " if owner else "  "
        yield f"{indent + _words(field):<26} {row.written:>16}   {source if source != said else '  same'}"
        said = source


def _path(row: Provenance) -> str:
    return row.field.removeprefix("transmission.").removeprefix("geometry.")


def _words(path: str) -> str:
    return path.replace(".", " ").replace("_", " ")


def _filled(paragraph: str) -> str:
    return textwrap.fill(paragraph, WIDTH)


def save(sheets: ContactSheet | Sequence[ContactSheet], directory: Path) -> list[Path]:
    """Write the sheets as text and their figures; returns the files.

    Raises
    ------
    InputError
        If the directory cannot be written to; nothing is changed then.
    """
    with all_or_nothing(directory, "contact") as scratch:
        names = []
        for sheet in [sheets] if isinstance(sheets, ContactSheet) else sheets:
            name = f"contact-{sheet.name}"
            (scratch / f"{name}.txt").write_text(text(sheet), "utf-8")
            names.append(f"{name}.txt")
            if sheet.drive.transmission.geometry is not None:
                names += [file.name for file in style.write(contact_design.draw_all(sheet), scratch / name)]
                trends = design_trends.draw_all(sheet.drive)
                names += [file.name for file in style.write(trends, scratch / f"{name}-trends")]
    return [directory / name for name in names]
