"""Contact sheets and steps of the steering angle as text, and as a page with figures and data."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TypeVar

import numpy as np

from infinivar import units
from infinivar.analysis.contact_sheet import ContactSheet, Line
from infinivar.analysis.steering_step import SteeringStep
from infinivar.figures import contact_design, design_trends, steering_step, style
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render
from infinivar.report.provenance import provenance_tables
from infinivar.study.provenance import DEFAULT, Provenance
from infinivar.units import plain

WIDTH = 118

_ROWS = 12
"""Distances in the table of a step."""

_FIGURES = {
    "": "Patch, creep curve of each law, and losses over preload",
    "-trends": "Efficiency over preload, friction and radii, and losses with other materials; grey: a limit is exceeded",
}
"""What the figures of a sheet show, by the ending of their names."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _Table:
    """A table of texts under a heading; `numbers` are the places of columns that are set to the right."""

    heading: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Part:
    """One drive on the page: images by their meaning, tables, and the sources of its inputs."""

    title: str
    verdict: str
    exceeded: bool = False
    images: Mapping[str, str]
    tables: tuple[_Table, ...]
    given: tuple[Provenance, ...] = ()


def text(sheet: ContactSheet) -> str:
    """The sheet for a terminal: results by section, then inputs with their sources."""
    blocks = [f"{sheet.title}\n{'=' * len(sheet.title)}", _filled(sheet.verdict)]
    for table in _sheet_tables(sheet):
        lines = (f"  {name:<26} {symbol:<8} {value:>13}   {how}".rstrip() for name, symbol, value, how in table.rows)
        blocks.append("\n".join([table.heading, *lines]))
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


def _sheet_tables(sheet: ContactSheet) -> Iterator[_Table]:
    """Yield the results, section by section."""
    heads = ("quantity", "symbol", "value", "formula, condition or source")
    for section, lines in groupby(sheet.lines, key=lambda line: line.section):
        yield _Table(section, heads, tuple(_result(line) for line in lines), (2,))


def _result(line: Line) -> tuple[str, ...]:
    known = line.value == line.value
    value = units.show_in(line.value, line.unit, line.shown_in) if known else "–"
    return line.name, line.symbol, value, line.how


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


def step_text(step: SteeringStep) -> str:
    """The step for a terminal: relaxation lengths, then forces and slip angles by distance."""
    setting, lengths, course = _step_tables(step)
    blocks = [
        [f"{step.title}\n{'=' * len(step.title)}"],
        [step.verdict],
        [setting.heading, *(f"  {name:<28} {value:>10}   {how}" for name, value, how in setting.rows)],
        [lengths.heading, *("  {:<28} {:>10} {:>8} {:>10}   {}".format(*row) for row in lengths.rows)],
        ["{:>10} {:>9} {:>12} {:>9} {:>11}".format(*row) for row in (course.heads, *course.rows)],
    ]
    return "\n\n".join("\n".join(lines) for lines in blocks) + "\n"


def _step_tables(step: SteeringStep) -> tuple[_Table, _Table, _Table]:
    """What is done and what follows, the relaxation lengths, and the course by distance."""
    turning = "at once" if step.rate is None else f"at {plain(step.rate, 3)} rad/s"
    setting = (
        ("step of the steering angle", f"{plain(1e3 * step.angle, 3)} mrad", f"{turning}; the link keeps its speed"),
        (
            "steady lateral force",
            f"{plain(step.steady_force, 3)} N",
            f"{step.steady_force / step.slip_force:.2f} of mu P",
        ),
        (
            "steady moment",
            f"{plain(1e3 * step.steady_moment, 3)} mN m",
            "of the contact on the wheel, against the turn",
        ),
        ("largest moment", f"{plain(1e3 * float(np.nanmax(step.moment)), 3)} mN m", "while turning"),
    )
    lengths = (
        ("this step", step.relaxation_length, "the wheel turns, which is spin"),
        ("small steps", step.linear_relaxation_length, "linear theory, at once: the patch sticks"),
        ("lateral creep alone", step.creep_relaxation_length, "same slip angle without a turn: the link changes speed"),
        ("  small steps", step.linear_creep_relaxation_length, "linear theory"),
    )
    return (
        _Table("Step", ("quantity", "value", "condition"), setting, (1,)),
        _Table(
            "Relaxation length: 63 % of the steady force",
            ("after", "length", "over a", "time", "condition"),
            tuple(_length(step, *line) for line in lengths),
            (1, 2, 3),
        ),
        _Table("Course", ("distance", "time", "slip angle", "force", "moment"), tuple(_course(step)), (0, 1, 2, 3, 4)),
    )


def _length(step: SteeringStep, name: str, length: float, how: str) -> tuple[str, ...]:
    of_patch = f"{length / step.half_length:.2f} a"
    time = f"{plain(1e3 * length / step.surface_speed, 3)} ms"
    return name, f"{plain(1e3 * length, 3)} mm", of_patch, time, how


def _course(step: SteeringStep) -> Iterator[tuple[str, ...]]:
    """Yield force and slip angle at distances in equal steps."""
    for distance in np.linspace(0.0, float(step.distance[-1]), _ROWS + 1):
        angle, force, moment = (
            float(np.interp(distance, step.distance, values)) for values in (step.slip_angle, step.force, step.moment)
        )
        yield (
            f"{1e3 * distance:.3f} mm",
            f"{1e3 * distance / step.surface_speed:.3f} ms",
            f"{1e3 * angle:.3f} mrad",
            f"{force:.2f} N",
            f"{1e3 * moment:.2f} mN m",
        )


def save(sheets: ContactSheet | Sequence[ContactSheet], directory: Path) -> list[Path]:
    """Write the sheets as a page and as text, and their figures; `contact.html` comes first.

    Raises
    ------
    InputError
        If the directory cannot be written to; nothing is changed then.
    """
    with all_or_nothing(directory, "contact") as scratch:
        names, parts = [], []
        several = _several(sheets)
        known = [one for one in several if one.drive.transmission.geometry is not None]
        drawn = style.write_all(
            scratch,
            {f"contact-{one.name}": (contact_design.draw_all, one) for one in known}
            | {f"contact-{one.name}-trends": (design_trends.draw_all, one.drive) for one in known},
        )
        for sheet in several:
            name, images = f"contact-{sheet.name}", {}
            (scratch / f"{name}.txt").write_text(text(sheet), "utf-8")
            names.append(f"{name}.txt")
            for stem, meaning in _FIGURES.items():
                files = drawn.get(name + stem, [])
                names += [file.name for file in files]
                images |= {meaning: style.inline_svg(files)} if files else {}
            part = _Part(
                title=sheet.title,
                verdict=sheet.verdict,
                exceeded=bool(sheet.exceeded),
                images=images,
                tables=tuple(_sheet_tables(sheet)),
                given=sheet.given,
            )
            parts.append(part)
        reconstruction = tuple(dict.fromkeys(said for sheet in several for said in sheet.reconstruction))
        (scratch / "contact.html").write_text(_html("Wheel contact", parts, reconstruction), "utf-8")
    return [directory / name for name in ("contact.html", *names)]


def save_steps(steps: SteeringStep | Sequence[SteeringStep], directory: Path) -> list[Path]:
    """Write the steps as a page and as text, and their figures; `contact-transient.html` comes first.

    Raises
    ------
    InputError
        If the directory cannot be written to; nothing is changed then.
    """
    with all_or_nothing(directory, "contact-transient") as scratch:
        names, parts = [], []
        for step in _several(steps):
            name = f"contact-{step.name}-transient"
            (scratch / f"{name}.txt").write_text(step_text(step), "utf-8")
            files = style.write(steering_step.draw_all(step), scratch / name)
            names += [f"{name}.txt", *(file.name for file in files)]
            images = {"Lateral force, moment and slip angle over the distance rolled": style.inline_svg(files)}
            parts.append(_Part(title=step.title, verdict=step.verdict, images=images, tables=_step_tables(step)))
        (scratch / "contact-transient.html").write_text(_html("Step of the steering angle", parts), "utf-8")
    return [directory / name for name in ("contact-transient.html", *names)]


def _several(found: T | Sequence[T]) -> Sequence[T]:
    """One or several results as a sequence."""
    return found if isinstance(found, Sequence) else [found]


def _html(what: str, parts: Sequence[_Part], reconstruction: tuple[str, ...] = ()) -> str:
    """The page on all drives."""
    sources = [provenance_tables(part.given) for part in parts]
    return render("contact.html", what=what, drives=parts, sources=sources, reconstruction=reconstruction)
