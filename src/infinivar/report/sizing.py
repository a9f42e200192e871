"""The report of a search for the best drives, its results, and each winner as a study file."""

from __future__ import annotations

import csv
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from infinivar._core.fields import value_at
from infinivar._core.text import aligned, capitalise, counted, few
from infinivar.analysis.hanging import printed_lines
from infinivar.analysis.robustness.verdicts import percent
from infinivar.analysis.whole_mass import WholeMass
from infinivar.drivetrain.building.base import Load
from infinivar.figures import sheet, style
from infinivar.figures import sizing as figure
from infinivar.motion.scenario import Scenario
from infinivar.report import whole_mass
from infinivar.report.output import all_or_nothing, check_inputs
from infinivar.report.page import render, to_json
from infinivar.report.step import installed as step_installed
from infinivar.report.step import save_step
from infinivar.sizing.builds.result import Doubt
from infinivar.sizing.design import (
    AXLE_BEARING,
    CYLINDER_BEARING,
    INNER,
    ROLES,
    SCALES,
    STEERING_MOTOR,
    UNITS,
    SizedDrive,
    allowance_words,
    at_end,
    beyond_words,
    demand_words,
    exceeded_words,
    limit_words,
    path_words,
    role_words,
    shown,
    unit_of,
)
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.measures import Measure
from infinivar.sizing.pool import ChosenPart
from infinivar.sizing.records import SearchRecord, TriedValue, WheelRecord, limit_lines
from infinivar.sizing.result import Sizing
from infinivar.sizing.studies import motion_file, scenario_of, study_of
from infinivar.sizing.what_if import WhatIf, amount, needed_words, present_words
from infinivar.study.inputs import input_files
from infinivar.study.study import Study
from infinivar.units import plain, show

_KIND = "size"
_WRITTEN = re.compile(r"sizing\.(html|json)|sizing-designs\.\w+|(design|front)-\d{2,}\.toml")
"""Files of every search; those named after templates and motions come on top."""
LISTED = 5
"""Most designs that are printed in a terminal."""
TIGHTEST = 5
"""Limits of the best designs that are set side by side."""
_ABREAST = 8
"""Designs beside each other in a table of margins: as many as fit on a page."""
_LISTED_BUILDS = 5
"""Most runners-up, and most of the front, that are printed in a terminal."""


def save(sizing: Sizing, directory: Path) -> list[Path]:
    """Write report, results, figure, and a study file of each design; `sizing.html` comes first."""
    keep_inputs(sizing.study, directory)
    with all_or_nothing(directory, _KIND) as scratch:
        drawn = style.write(figure.draw_all(sizing), scratch / "sizing-designs") if sizing.designs else []
        motions = _motions(sizing, scratch)
        studies = dict(_studies(sizing, directory, scratch, motions))
        for name, text_of in studies.items():
            (scratch / name).write_text(text_of, "utf-8", newline="\n")
        masses = sizing.masses
        bills = {bill_file(name): (mass, sizing.best_of[name].inner_parts) for name, mass in masses.items()}
        for name, (mass, parts) in bills.items():
            write_bill(mass, parts, scratch / name)
        sheets = {
            name: style.write(sheet.draw_all(mass, _loads(sizing, name), f"like {name}"), scratch / sheet_file(name))
            for name, mass in masses.items()
            if mass.layout.solids
        }
        solids = [
            save_step(mass.layout.solids, scratch / step_file(name), f"{sizing.study.name}, like {name}")
            for name, mass in masses.items()
            if step_installed() and mass.layout.solids
        ]
        (scratch / "sizing.json").write_text(to_json(sizing.to_dict()), "utf-8")
        views = {name: style.inline_svg(files) for name, files in sheets.items()}
        (scratch / "sizing.html").write_text(
            html(sizing, masses, style.inline_svg(drawn) if drawn else "", views), "utf-8"
        )
        names = [
            "sizing.html",
            "sizing.json",
            *studies,
            *bills,
            *(file.name for file in solids),
            *sorted(file.name for file in scratch.glob("motion-*.csv")),
        ]
    pictures = [*drawn, *(file for files in sheets.values() for file in files)]
    return [directory / name for name in (*names, *(file.name for file in pictures))]


def _loads(sizing: Sizing, name: str) -> tuple[Load, ...]:
    """Loads on bearings and rail of the best design like a template."""
    drive: Any = sizing.best_of[name].drive
    return drive.loads(sizing.study.service(drive))


def keep_inputs(study: Study, directory: Path, sets: Iterable[str | Path] | None = None) -> None:
    """Raise an error if the results of a search would replace a file that it reads.

    Parameters
    ----------
    study : Study
    directory : Path   Of the results.
    sets : names       Sets that are searched, by name or as files.

    Raises
    ------
    InputError
        With that file, and what it is.
    """
    own = {
        *map(best_file, study.drives),
        *map(bill_file, study.drives),
        *(f"{sheet_file(name)}.{one}" for name in study.drives for one in style.FORMATS),
        *map(_motion_csv, study.duty),
    }
    inputs = input_files(study, [Path("parts"), *map(Path, sets or ())])
    check_inputs(directory, _KIND, inputs, lambda name: name in own or _WRITTEN.fullmatch(name) is not None)


def file_of(group: str, place: int) -> str:
    """Name of the study file of a design, from 1."""
    return f"{group}-{place:02d}.toml"


def best_file(template: str) -> str:
    """Name of the study file of the best design like a template."""
    return f"best-{template}.toml"


def _motion_csv(name: str) -> str:
    """Name of the file of a motion."""
    return f"motion-{name}.csv"


def bill_file(template: str) -> str:
    """Name of the bill of materials of the best design like a template."""
    return f"best-{template}-bill.csv"


def step_file(template: str) -> str:
    """Name of the file with the solids of the best design like a template."""
    return f"best-{template}.step"


def sheet_file(template: str) -> str:
    """Name, without format, of the views, masses and loads of the best design like a template."""
    return f"best-{template}-sheet"


def write_bill(mass: WholeMass, parts: Mapping[str, ChosenPart], file: Path) -> None:
    """Write the bill of materials of a design as CSV: a row for each body, with the order number of what was chosen."""
    chosen = {name: part for role, part in parts.items() for name in _BODIES.get(role, ())}
    with file.open("w", newline="", encoding="utf-8") as target:
        writer = csv.writer(target)
        writer.writerow(["body", "what it is", "manufacturer", "order number", "mass [kg]", "kind"])
        for body in mass.bodies:
            known = "" if body.mass is None else f"{float(body.mass):.4g}"
            bought = [getattr(chosen.get(body.name), name, "") for name in ("manufacturer", "order_number")]
            writer.writerow([body.name, body.basis, *bought, known, body.kind])


_BODIES = {
    "motor": ("motor", "cylinder motor"),
    "gearhead": ("gearhead",),
    STEERING_MOTOR: ("steering motor",),
    AXLE_BEARING: ("axle bearings",),
    CYLINDER_BEARING: ("cylinder bearings",),
}
"""Bodies that the parts chosen by a search are, by role."""


def _motions(sizing: Sizing, scratch: Path) -> dict[str, Scenario]:
    """Motions as scenarios under the same name, with the files they read."""
    made: dict[str, Scenario] = {}
    if not sizing.designs:
        return made
    for name, duty in sizing.study.duty.items():
        content = motion_file(duty)
        if content is not None and name not in sizing.study.scenarios:
            file = scratch / _motion_csv(name)
            file.write_text(content, "utf-8", newline="\n")
            made[name] = scenario_of(duty, file)
    return made


def _studies(
    sizing: Sizing, directory: Path, scratch: Path, motions: Mapping[str, Scenario]
) -> Iterator[tuple[str, str]]:
    """Text of each study file. Other files are named from the final folder; those of the motions are beside the study there."""
    beside = f"{Path(os.path.relpath(scratch, directory)).as_posix()}/"
    named = [
        (file_of(group, place), design)
        for group, designs in (("design", sizing.designs), ("front", sizing.front))
        for place, design in enumerate(designs, 1)
    ]
    if len(sizing.searches) > 1:
        named += [(best_file(name), design) for name, design in sizing.best_of.items()]
    for name, design in named:
        made = study_of(sizing.study, design, Path(name).stem, motions)
        yield name, made.to_toml(directory).replace(beside, "")


def text(sizing: Sizing) -> Iterator[str]:
    """Yield the lines for a terminal: the answer, the best of each template, and what it hangs on; the report has the rest."""
    yield from _answer(sizing)
    for group, title, designs in (
        ("design", f"Least {sizing.objective[0]}", sizing.designs),
        ("front", "Front of mass and energy", sizing.front),
    ):
        if len(designs) > 1:
            yield ""
            yield from _listed(sizing, group, title, designs)
    for lines in (
        *(lines for name in sizing.searches for lines in _tried_lines(sizing, name)),
        sizing.carrying,
        printed_lines(sizing.hangs_on),
        *(_changes(one) for one in sizing.what_if.values()),
        () if sizing.doubt is None else _doubt_lines(sizing.doubt),
        _searched(sizing),
    ):
        block = [*lines]
        yield from ["", *block] if block else ()


def _answer(sizing: Sizing) -> Iterator[str]:
    """The verdict, and a table with a column for the best design like each template."""
    if sizing.best is None:
        yield capitalise(sizing.verdict)
        return
    if sizing.hangs_on is not None and sizing.hangs_on.prefix:
        yield sizing.hangs_on.prefix.strip()
    like = [sizing.best.template] if len(sizing.searches) > 1 else []
    yield f"{capitalise(sizing.least)}: {', '.join([*like, *sizing.measured(sizing.best), *sizing.best.results])}"
    yield ""
    facts = {name: _facts(design, sizing.measure) for name, design in sizing.best_of.items()}
    if len(sizing.searches) > 1:
        facts = {name: {**said, "study file": best_file(name)} for name, said in facts.items()}
    words = dict.fromkeys(word for said in facts.values() for word in said)
    yield from aligned([("", *facts), *((word, *(said.get(word, "–") for said in facts.values())) for word in words)])
    for name, search in sizing.searches.items():
        if name not in facts:
            nearest = search.nearest
            miss = "" if nearest is None else f"; nearest miss: {exceeded_words(nearest)}"
            yield f"{name}: no feasible design{miss}"


def _facts(design: SizedDrive, measure: Measure | None) -> dict[str, str]:
    """What a design needs, weighs and keeps, its parts and its values, by their names."""
    names = (*([] if measure is None else [measure.words]), "mean power", "whole mass")
    figures = zip(names, _figures(design, measure), strict=False)
    motors = {"motors and gearheads": show(design.motor_mass, "kg", 3)} if math.isfinite(design.motor_mass) else {}
    limit = {} if design.tightest is None else {"tightest limit": limit_words(design.tightest)}
    parts = {role_words(role): part.title for role, part in design.parts.items()}
    return {
        **dict(figures),
        **motors,
        **limit,
        **parts,
        **{path_words(path): value.words for path, value in design.free.items()},
    }


def _figure_names(sizing: Sizing) -> tuple[str, ...]:
    """Heads of the columns of `_figures`."""
    return (*([] if sizing.measure is None else [sizing.objective[0]]), "power", "mass", "margin")


def _figures(design: SizedDrive, measure: Measure | None) -> tuple[str, ...]:
    """What else the objective asks for, then mean power, mass and margin; "–" where there is none."""
    own = [] if measure is None else [measure.shown(measure.of(design))]
    power = show(design.power, "W", 3) if math.isfinite(design.power) else "–"
    mass = show(design.mass, "kg", 3) if math.isfinite(design.mass) else "not stated"
    return (*own, power, mass, "–" if design.tightest is None else _allowance(design, design.tightest))


def _listed(sizing: Sizing, group: str, title: str, designs: tuple[SizedDrive, ...]) -> Iterator[str]:
    """Lines of a table with a row for each of the first designs."""
    several = len(sizing.searches) > 1
    table = [(title, *(["drive"] if several else []), *_figure_names(sizing), "parts")]
    for place, design in enumerate(designs[:LISTED], 1):
        like = [design.template] if several else []
        figures = _figures(design, sizing.measure)
        table.append((file_of(group, place).removesuffix(".toml"), *like, *figures, design.title))
    yield from aligned(table, whole=range(1, len(table[0]) - 1))
    if len(designs) > LISTED:
        yield f"... and {len(designs) - LISTED} more in the report"


def tried_of(search: SearchRecord | WheelRecord) -> dict[str, list[TriedValue]]:
    """Values that were tried, by path."""
    paths = dict.fromkeys(one.path for one in search.tried)
    return {path: [one for one in search.tried if one.path == path] for path in paths}


def tried_cells(one: TriedValue, measure: Measure | None) -> tuple[str, ...]:
    """A value that was tried, and of the best design with it its figures and parts, or what its nearest miss exceeds."""
    value, none = shown(one.value, one.unit), ("–",) * (3 if measure is None else 4)
    if one.design is None:
        return value, *none, "no candidate"
    if not one.feasible:
        return value, *none, f"infeasible: {exceeded_words(one.design)}"
    return value, *_figures(one.design, measure), one.design.title


def tried_end(path: str, design: SizedDrive | None) -> str:
    """Where the best design lies among the values that were tried."""
    free = None if design is None else design.free.get(path)
    if free is None or len(free.tried) < 2:
        return ""
    if path in SCALES and free.value == 1.0:
        return "best with a single motor"
    return f"best {'at an end of' if at_end(path, free) else 'inside'} the values tried: {shown(free.value, free.unit)}"


def _tried_lines(sizing: Sizing, name: str) -> Iterator[list[str]]:
    """Yield the lines on the best design of a template with each value of a path that was tried."""
    for path, tried in tried_of(sizing.searches[name]).items():
        like = f" of {name}" if len(sizing.searches) > 1 else ""
        head = (f"{capitalise(path_words(path))}{like}", *_figure_names(sizing), "parts of the best")
        end = tried_end(path, sizing.best_of.get(name))
        rows = [tried_cells(one, sizing.measure) for one in tried]
        yield [*aligned([head, *rows], whole=range(len(head) - 1)), *([f"  {end}"] if end else [])]


def _changes(change: WhatIf) -> Iterator[str]:
    """Lines on what would have to change for another outcome."""
    yield f"{change.headline}:"
    yield from (f"  {line}" for line in change.lines)


def _searched(sizing: Sizing) -> Iterator[str]:
    """Lines on what was searched, and what excluded it where nothing is feasible; then the notes."""
    for name, search in sizing.searches.items():
        lines = [*(_fates(name, search) if isinstance(search, SearchRecord) else _wheel_fates(name, search))]
        yield from lines[:1] if name in sizing.best_of else lines
    yield from (f"Note: {one}" for one in sizing.cautions)


def _fates(name: str, search: SearchRecord) -> Iterator[str]:
    """Lines on what became of the candidates for a geared template."""
    left = f"{search.left:,} left by closed forms, " if search.closed else ""
    yield f"Template {name}: {search.words}{_ranges(search)}; {left}{search.evaluated:,} evaluated at every instant"
    for reason, number in search.excluded.items():
        yield f"  {reason}: {number:,} left out"
    yield from (f"  {line}" for line in limit_lines(search.counts))
    yield from _missed(search)


def _wheel_fates(name: str, search: WheelRecord) -> Iterator[str]:
    """Lines on what became of the candidates for a cobotic template."""
    times = "" if search.stages == 1 else f" ({search.stages:,} {search.stage_words})"
    yield f"Template {name}: {counted(search.candidates, 'combinations')} of parts{times}{_ranges(search)}"
    yield (
        f"  {counted(search.wheels, 'wheel designs')}, {search.rolled:,} of which roll, cover "
        f"{counted(_rounded(search.drives), 'drives')}; {counted(search.evaluated, 'motors')} evaluated at every instant, "
        f"with {'JAX' if search.compiled else 'NumPy'}"
    )
    for reason, number in search.excluded.items():
        yield f"  {reason}: {number:,} left out"
    for key, number in search.blocked.items():
        yield f"  {limit_words(key)}: tightest limit of {counted(number, 'infeasible wheel designs')}"
    yield from _missed(search)


def _missed(search: SearchRecord | WheelRecord) -> Iterator[str]:
    """Lines on the nearest miss, and on limits that were not checked."""
    if search.nearest is not None:
        yield f"  nearest miss: {search.nearest.verdict}"
        yield f"    {exceeded_words(search.nearest)}"
    for (limit, part), number in search.unchecked.items():
        yield f"  {demand_words(limit, part)}: not stated, not checked for {number:,}"


def _ranges(search: SearchRecord | WheelRecord) -> str:
    found = [
        f"{path_words(path)} {_without_unit(low, unit_of(path))} to {shown(high, unit_of(path), 3)}"
        for path, (low, high) in search.ranges.items()
    ]
    return f", {', '.join(found)}" if found else ""


def _rounded(number: float) -> int:
    """A large number to three digits."""
    return int(float(f"{number:.3g}"))


def _without_unit(value: float, unit: str) -> str:
    return plain(1e3 * value if unit == "m" else value, 3)


def html(sizing: Sizing, masses: Mapping[str, WholeMass], image: str, sheets: Mapping[str, str]) -> str:
    """The report as one self-contained page."""
    known = [*sizing.designs, *sizing.front, *sizing.best_of.values()]
    tried = [one.path for search in sizing.searches.values() for one in search.tried]
    return render(
        "sizing.html",
        sizing=sizing,
        study=sizing.study,
        motions=[*sizing.study.duty.values(), *sizing.study.tasks.values(), *sizing.study.paths.values()],
        image=image,
        beside_mass=sizing.measure.words if sizing.measure else "power" if sizing.study.moves else "margin",
        notes=[f"{capitalise(one)}." for one in (*sizing.cautions, *_refused(sizing))],
        groups=[
            (group, title, designs, _limits(designs))
            for group, title, designs in (
                ("design", f"Designs of least {sizing.objective[0]}", sizing.designs),
                ("front", "Front of mass and energy, least power first", sizing.front),
            )
            if designs
        ],
        abreast=_ABREAST,
        allowance=_allowance,
        unchecked=_unchecked,
        limit_words=limit_words,
        **whole_mass.words(),
        masses=masses,
        sheets=sheets,
        mass_titles={name: f"like {name}" for name in sizing.best_of},
        doubt=sizing.doubt,
        percent=percent,
        beyond_words=beyond_words,
        exceeded_words=exceeded_words,
        file_of=file_of,
        best_file=best_file,
        path_words=path_words,
        tried_of=tried_of,
        tried_cells=tried_cells,
        tried_end=tried_end,
        roles=[role for role in ROLES if any(role in one.inner_parts for one in known)],
        frees=_frees(known, tried),
        role_words=role_words,
        part_in=_part_in,
        tightest=_tightest,
        demand_words=demand_words,
        shown=shown,
        amount=amount,
        needed_words=needed_words,
        present_words=present_words,
        ranges=_ranges,
        bought={part.part: part for one in known for part in one.parts.values()},
        counted=counted,
        rounded=_rounded,
    )


def _frees(known: Iterable[SizedDrive], tried: Iterable[str]) -> list[str]:
    """Paths of the values of designs, in the order in which reports list them."""
    found = dict.fromkeys(path for one in known for path in one.inner_free)
    listed = [path for path in dict.fromkeys((*UNITS, *tried)) if path in found]
    return [*listed, *(path for path in found if path not in listed)]


def _refused(sizing: Sizing) -> Iterator[str]:
    """Yield what was refused of each set, with some reasons."""
    for one in sizing.sets:
        if one.refused:
            were = "was" if len(one.refused) == 1 else "were"
            yield f"{counted(len(one.refused), 'rows')} of {one.name} {were} refused: {few(one.refused, 3, '; ')}"


def _part_in(design: SizedDrive, role: str) -> str | None:
    """Name of a part that a design keeps from its template; None if the drive has no such part."""
    for lead in INNER:
        try:
            return str(getattr(value_at(design.drive, f"{lead}{role}"), "name", None) or "not named")
        except AttributeError:
            continue
    return None


def _tightest(design: SizedDrive) -> list[tuple[str, str]]:
    """The tightest limits of a design with their margins."""
    keys = sorted(design.demands, key=lambda key: -design.demands[key])[:TIGHTEST]
    return [(limit_words(key), _allowance(design, key)) for key in keys if design.demands[key] > 1e-6]


def _limits(designs: tuple[SizedDrive, ...]) -> list[TaskDemand]:
    """Limits that were evaluated for any design and are not at rest, the tightest first."""
    worst: dict[TaskDemand, float] = {}
    for design in designs:
        for key, demand in design.demands.items():
            worst[key] = max(worst.get(key, 0.0), demand)
    return [key for key in sorted(worst, key=lambda key: -worst[key]) if worst[key] > 1e-6]


def _allowance(design: SizedDrive, key: TaskDemand) -> str:
    """Allowance over demand of a limit; "–" where it is not checked or not loaded."""
    demand: Any = design.demands.get(key, math.nan)
    return allowance_words(demand) if demand > 1e-6 else "–"


def _unchecked(group: str, designs: tuple[SizedDrive, ...]) -> Iterator[str]:
    """Yield each limit that the data sheets of some designs do not state, with their names where they are not all."""
    for key in dict.fromkeys(key for design in designs for key in design.unchecked):
        names = [
            file_of(group, place).removesuffix(".toml")
            for place, design in enumerate(designs, 1)
            if key in design.unchecked
        ]
        yield demand_words(*key) + (f" ({', '.join(names)})" if len(names) < len(designs) else "")


def _doubt_lines(doubt: Doubt) -> Iterator[str]:
    """Yield the lines on the builds of designs within their tolerances, for a terminal."""
    yield f"Within tolerances, {counted(doubt.count, 'builds')}:"
    yield f"  {doubt.designs[0].name}: {doubt.verdict}"
    for one in doubt.runners_up[:_LISTED_BUILDS]:
        yield f"  {one.name}: least {doubt.objective} in {percent(one.best_share, one.count)}; {one.verdict}"
    more = len(doubt.runners_up) - _LISTED_BUILDS
    if more > 0:
        yield f"  ... and {more} more that {'is' if more == 1 else 'are'} best in some builds"
    never = len(doubt.designs) - 1 - len(doubt.runners_up)
    if never:
        yield f"  ... and {never} more that {'is' if never == 1 else 'are'} best in no build"
    if doubt.stated:
        yield f"  spreads stated in the study: {'; '.join(doubt.stated)}"
    if doubt.assumed:
        yield f"  default spreads, as the study states none: {', '.join(doubt.assumed)}"
