"""The report of a search for the best drives, its results, and each winner as a study file."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from infinivar._core.fields import value_at
from infinivar._core.text import counted
from infinivar.analysis.hanging import told
from infinivar.analysis.robustness.verdicts import percent
from infinivar.figures import sizing as figure
from infinivar.figures import style
from infinivar.motion.scenario import Scenario
from infinivar.report import sizing_doubt
from infinivar.report.output import all_or_nothing, check_inputs
from infinivar.report.page import render, to_json
from infinivar.sizing.design import (
    ROLES,
    UNITS,
    SizedDrive,
    allowance_words,
    beyond_words,
    demand_words,
    exceeded_words,
    limit_words,
    path_words,
    role_words,
    shown,
)
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.records import SearchRecord, WheelRecord, limit_lines
from infinivar.sizing.result import Sizing
from infinivar.sizing.studies import motion_file, scenario_of, study_of
from infinivar.sizing.what_if import amount, needed_words, present_words
from infinivar.study.inputs import input_files
from infinivar.study.study import Study
from infinivar.units import plain

_KIND = "size"
_WRITTEN = re.compile(r"sizing\.(html|json)|sizing-designs\.\w+|(design|front)-\d{2,}\.toml")
"""Files of every search; those named after templates and motions come on top."""
LISTED = 10
"""Most designs that are printed in a terminal."""
TIGHTEST = 5
"""Limits of the best designs that are set side by side."""
_ABREAST = 8
"""Designs beside each other in a table of margins: as many as fit on a page."""


def save(sizing: Sizing, directory: Path) -> list[Path]:
    """Write report, results, figure, and a study file of each design; `sizing.html` comes first."""
    keep_inputs(sizing.study, directory)
    with all_or_nothing(directory, _KIND) as scratch:
        drawn = style.write(figure.draw_all(sizing), scratch / "sizing-designs") if sizing.designs else []
        motions = _motions(sizing, scratch)
        studies = dict(_studies(sizing, directory, scratch, motions))
        for name, text_of in studies.items():
            (scratch / name).write_text(text_of, "utf-8", newline="\n")
        (scratch / "sizing.json").write_text(to_json(sizing.to_dict()), "utf-8")
        (scratch / "sizing.html").write_text(html(sizing, style.inline_svg(drawn) if drawn else ""), "utf-8")
        names = ["sizing.html", "sizing.json", *studies, *sorted(file.name for file in scratch.glob("motion-*.csv"))]
    return [directory / name for name in (*names, *(file.name for file in drawn))]


def keep_inputs(study: Study, directory: Path, sets: Iterable[str] | None = None) -> None:
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
    own = {*map(best_file, study.drives), *map(_motion_csv, study.duty)}
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
    """Yield the lines for a terminal."""
    verdict = sizing.verdict
    yield f"{verdict[:1].upper()}{verdict[1:]}"
    yield from told(sizing.hangs_on)
    for group, title, designs in (
        ("design", f"Least {sizing.objective[0]}:", sizing.designs),
        ("front", "Front of mass and energy, least power first:", sizing.front),
    ):
        if designs:
            yield title
            for place, design in enumerate(designs[:LISTED], 1):
                yield f"  {file_of(group, place).removesuffix('.toml')}: {sizing.words_of(design)}"
            if len(designs) > LISTED:
                yield f"  ... and {len(designs) - LISTED} more"
    if len(sizing.searches) > 1:
        yield "Best of each:"
        for name in sizing.searches:
            yield f"  {best_words(sizing, name)}"
    for one in sizing.what_if.values():
        yield f"{one.headline}:"
        for line in one.lines:
            yield f"  {line}"
    for name, search in sizing.searches.items():
        yield from _fates(name, search) if isinstance(search, SearchRecord) else _wheel_fates(name, search)
    if sizing.doubt is not None:
        yield from sizing_doubt.text(sizing.doubt)
    for one in sizing.cautions:
        yield f"Note: {one}"


def best_words(sizing: Sizing, name: str) -> str:
    """The best design like a template, or the nearest miss."""
    best = sizing.best_of.get(name)
    if best is not None:
        return f"{best_file(name).removesuffix('.toml')}: {best.verdict}"
    nearest = sizing.searches[name].nearest
    return f"{name}: no feasible design" + ("" if nearest is None else f"; nearest miss: {exceeded_words(nearest)}")


def _fates(name: str, search: SearchRecord) -> Iterator[str]:
    """Lines on what became of the candidates for a geared template."""
    yield (
        f"Template {name}: {search.words}{_ranges(search)}; {search.left:,} left by closed forms, "
        f"{search.evaluated:,} evaluated at every instant"
    )
    for reason, number in search.excluded.items():
        yield f"  {reason}: {number:,} left out"
    yield from (f"  {line}" for line in limit_lines(search.counts))
    yield from _missed(search)


def _wheel_fates(name: str, search: WheelRecord) -> Iterator[str]:
    """Lines on what became of the candidates for a cobotic template."""
    yield f"Template {name}: {counted(search.candidates, 'combinations')} of parts{_ranges(search)}"
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
        f"{path_words(path)} {_without_unit(low, UNITS[path])} to {shown(high, UNITS[path], 3)}"
        for path, (low, high) in search.ranges.items()
    ]
    return f", {', '.join(found)}" if found else ""


def _rounded(number: float) -> int:
    """A large number to three digits."""
    return int(float(f"{number:.3g}"))


def _without_unit(value: float, unit: str) -> str:
    return plain(1e3 * value if unit == "m" else value, 3)


def html(sizing: Sizing, image: str) -> str:
    """The report as one self-contained page."""
    known = [*sizing.designs, *sizing.front, *sizing.best_of.values()]
    return render(
        "sizing.html",
        sizing=sizing,
        study=sizing.study,
        image=image,
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
        doubt=sizing.doubt,
        percent=percent,
        beyond_words=beyond_words,
        exceeded_words=exceeded_words,
        file_of=file_of,
        best_file=best_file,
        path_words=path_words,
        roles=[role for role in ROLES if any(role in one.parts for one in known)],
        frees=[path for path in UNITS if any(path in one.free for one in known)],
        role_words=role_words,
        part_in=_part_in,
        tightest=_tightest,
        demand_words=demand_words,
        shown=shown,
        amount=amount,
        needed_words=needed_words,
        present_words=present_words,
        ranges=_ranges,
        parts={part.part: part for one in known for part in one.parts.values()},
        counted=counted,
        rounded=_rounded,
    )


def _part_in(design: SizedDrive, role: str) -> str | None:
    """Name of a part that a design keeps from its template; None if the drive has no such part."""
    try:
        return str(getattr(value_at(design.drive, role), "name", None) or "not named")
    except AttributeError:
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
