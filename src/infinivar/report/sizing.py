"""The report of a search for the best drives, its results, and each winner as a study file."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from infinivar.figures import sizing as figure
from infinivar.figures import style
from infinivar.motion.scenario import Scenario
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json
from infinivar.sizing.design import SizedDrive, exceeded_words, limit_words
from infinivar.sizing.geared.sampled import TaskDemand
from infinivar.sizing.result import SearchRecord, Sizing
from infinivar.sizing.studies import motion_file, scenario_of, study_of
from infinivar.units import plain, show

LISTED = 10
"""Most designs that are printed in a terminal."""


def save(sizing: Sizing, directory: Path) -> list[Path]:
    """Write report, results, figure, and a study file of each design; `sizing.html` comes first."""
    with all_or_nothing(directory, "size") as scratch:
        drawn = style.write(figure.draw_all(sizing), scratch / "sizing-designs") if sizing.designs else []
        motions = _motions(sizing, scratch)
        studies = dict(_studies(sizing, directory, scratch, motions))
        for name, text_of in studies.items():
            (scratch / name).write_text(text_of, "utf-8", newline="\n")
        (scratch / "sizing.json").write_text(to_json(sizing.to_dict()), "utf-8")
        (scratch / "sizing.html").write_text(html(sizing, style.inline_svg(drawn) if drawn else ""), "utf-8")
        names = ["sizing.html", "sizing.json", *studies, *sorted(file.name for file in scratch.glob("motion-*.csv"))]
    return [directory / name for name in (*names, *(file.name for file in drawn))]


def file_of(group: str, place: int) -> str:
    """Name of the study file of a design, from 1."""
    return f"{group}-{place:02d}.toml"


def _motions(sizing: Sizing, scratch: Path) -> dict[str, Scenario]:
    """Motions as scenarios under the same name, with the files they read."""
    made: dict[str, Scenario] = {}
    if not sizing.designs:
        return made
    for name, duty in sizing.study.duty.items():
        content = motion_file(duty)
        if content is not None and name not in sizing.study.scenarios:
            file = scratch / f"motion-{name}.csv"
            file.write_text(content, "utf-8", newline="\n")
            made[name] = scenario_of(duty, file)
    return made


def _studies(
    sizing: Sizing, directory: Path, scratch: Path, motions: Mapping[str, Scenario]
) -> Iterator[tuple[str, str]]:
    """Text of each study file. Other files are named from the final folder; those of the motions are beside the study there."""
    beside = f"{Path(os.path.relpath(scratch, directory)).as_posix()}/"
    for group, designs in (("design", sizing.designs), ("front", sizing.front)):
        for place, design in enumerate(designs, 1):
            name = file_of(group, place)
            made = study_of(sizing.study, design, Path(name).stem, motions)
            yield name, made.to_toml(directory).replace(beside, "")


def text(sizing: Sizing) -> Iterator[str]:
    """Yield the lines for a terminal."""
    verdict = sizing.verdict
    yield f"{verdict[:1].upper()}{verdict[1:]}"
    for group, title, designs in (
        ("design", f"Least {sizing.objective[0]}:", sizing.designs),
        ("front", "Front of mass and energy:", sizing.front),
    ):
        if designs:
            yield title
            for place, design in enumerate(designs[:LISTED], 1):
                yield f"  {file_of(group, place).removesuffix('.toml')}: {design.verdict}"
            if len(designs) > LISTED:
                yield f"  ... and {len(designs) - LISTED} more"
    for name, search in sizing.searches.items():
        yield from _fates(name, search)
    for one in sizing.cautions:
        yield f"Note: {one}"


def _fates(name: str, search: SearchRecord) -> Iterator[str]:
    """Lines on what became of the candidates for a template."""
    yield (
        f"Template {name}: {search.candidates} pairs{_ranges(search)}; {search.left} left by closed forms, "
        f"{search.evaluated} evaluated at every instant"
    )
    for reason, number in search.excluded.items():
        yield f"  {reason}: {number} left out"
    for count in search.counts:
        if count.first:
            where = limit_words((count.task, count.limit, count.part))
            yield f"  {where}: rules out {count.first} of those left; on its own {count.exceeded} of {count.checked}"
    if search.nearest is not None:
        yield f"  nearest miss: {search.nearest.verdict}"
        yield f"    {exceeded_words(search.nearest)}"
    for (limit, _), number in search.unchecked.items():
        yield f"  {limit.words}: not stated, not checked for {number}"


def _ranges(search: SearchRecord) -> str:
    found = [
        f"{path.replace('.', ' ')} {show(1e3 * low, '1', 3)} to {show(1e3 * high, '1', 3)} mm"
        for path, (low, high) in search.ranges.items()
    ]
    return f", {', '.join(found)}" if found else ""


def html(sizing: Sizing, image: str) -> str:
    """The report as one self-contained page."""
    return render(
        "sizing.html",
        sizing=sizing,
        study=sizing.study,
        image=image,
        groups=[
            (group, title, designs, _limits(designs))
            for group, title, designs in (
                ("design", f"Designs of least {sizing.objective[0]}", sizing.designs),
                ("front", "Front of mass and energy", sizing.front),
            )
            if designs
        ],
        allowance=_allowance,
        limit_words=limit_words,
        exceeded_words=exceeded_words,
        file_of=file_of,
        ranges=_ranges,
        parts={part.part: part.where for one in (*sizing.designs, *sizing.front) for part in one.parts.values()},
    )


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
    return plain(1.0 / demand, 3) if demand > 1e-6 else "–"
