"""The report of a comparison of machines, with its data files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.described import suffix, unit_of
from infinivar.analysis.machine_tasks import TaskResult
from infinivar.analysis.machines import MachineComparison, MachineResult, change_lines
from infinivar.analysis.pose_map import PoseMap, pose_map
from infinivar.analysis.tightest import vector_words
from infinivar.errors import InputError
from infinivar.figures import kinds, machine_tasks, style
from infinivar.figures.kinds import Drawing
from infinivar.limits import words_of
from infinivar.machines.machine import SLOW_FRICTION
from infinivar.power import AUDIT_TOLERANCE
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json, write_csv
from infinivar.report.provenance import provenance_tables
from infinivar.units import show

_ROUNDING = 1e-6
"""Demand over allowance below which it is rounding. [-]"""


def save(comparison: MachineComparison, directory: Path) -> list[Path]:
    """Write report, figures, results and one CSV per machine and path; the report comes first."""
    with all_or_nothing(directory, "compare") as scratch:
        figures, captions = {}, {}
        for name, draw, caption in drawings(comparison):
            try:
                figures[name] = style.write(draw(), scratch / f"report-{name}")
            except InputError:  # a pose that cannot be drawn: beyond reach, or slipping
                continue
            captions[name] = caption
        images = {name: (style.inline_svg(files), captions[name]) for name, files in figures.items()}
        (scratch / "report.html").write_text(html(comparison, images), "utf-8")
        (scratch / "results.json").write_text(to_json(results(comparison)), "utf-8")
        cycles = []
        for name, one in comparison.results.items():
            for path, found in one.paths.items():
                cycles.append(f"{name}-{path}.csv")
                write_csv(found.columns, scratch / cycles[-1])
    drawn = [file.name for files in figures.values() for file in files]
    return [directory / name for name in ("report.html", "results.json", *cycles, *drawn)]


def results(comparison: MachineComparison) -> dict[str, Any]:
    """All results of the report as plain numbers."""
    content = comparison.to_dict()
    content["provenance"] = [
        {**asdict(row), "value": _plain(row.value, row.written)} for row in comparison.study.provenance
    ]
    return content


def _plain(value: Any, written: str) -> Any:
    return value if isinstance(value, (int, float, str, bool)) else written


def html(comparison: MachineComparison, images: Mapping[str, tuple[str, str]]) -> str:
    """The report as one self-contained page; `images` are the figures with their captions, by name."""
    return render(
        "machines.html",
        study=comparison.study,
        comparison=comparison,
        images=images,
        provenance=provenance_tables(comparison.study.provenance),
        words_of=words_of,
        described=lambda found, what: ", ".join(vector_words(found.coordinates, getattr(found, what), what)),
        demands=_demands,
        source_words=_source_words,
        change_lines=change_lines,
        audit_tolerance=AUDIT_TOLERANCE,
        degrees=np.degrees,
    )


def _source_words(machine: Any, found: TaskResult) -> str:
    """What feeds a machine in a task, and the forces, currents and speeds of the source that it states."""
    states = {name: float(value) for name, value in found.point.states.items() if name != SLOW_FRICTION}
    said = [
        f"{name.removesuffix(suffix(unit)).replace('_', ' ')} {show(value, unit, 3)}"
        for name, value in states.items()
        if (unit := unit_of(name)) != "1"
    ]
    return ", ".join((getattr(machine, "source", "supply"), *said))


def _demands(found: TaskResult) -> list[tuple[str, float]]:
    """The largest demand on each limit, with its part, from the largest."""
    worst: dict[int, tuple[str, float]] = {}
    for (limit, part), demand in found.point.demands.items():
        value = float(demand)
        if limit.value not in worst or value > worst[limit.value][1]:
            worst[limit.value] = words_of((limit, part)), value
    return sorted((one for one in worst.values() if one[1] > _ROUNDING), key=lambda one: -one[1])


def drawings(comparison: MachineComparison) -> Iterator[Drawing]:
    """Yield every figure of the report."""
    yield "losses", lambda: machine_tasks.draw_all(comparison), _LOSSES
    first = next(iter(comparison.results.values()))
    for path in first.paths:
        found = {one.title: one.paths[path] for one in comparison.results.values()}
        yield f"path-{path}", lambda found=found: machine_tasks.draw_paths(found), _PATH
    maps = _maps(comparison)
    if maps:
        yield "positions", lambda: machine_tasks.draw_maps(maps), _MAP
    for name, one in comparison.results.items():
        rows = [row for row in comparison.study.provenance if row.owner == name and row.field.startswith("geometry.")]
        assumed = (
            " Dimensions of its rods and joints are assumed." if any(row.kind == "assumed" for row in rows) else ""
        )
        yield from kinds.drawings(name, one.title, one.machine, _drawn(one), assumed, one.paths)


def _maps(comparison: MachineComparison) -> dict[str, PoseMap]:
    """Maps over positions of the machines that have them, in the first task."""
    task = next(iter(comparison.study.tasks.values()), None)
    if task is None:
        return {}
    spans = {one.title: (one.machine, getattr(one.machine, "span", None)) for one in comparison.results.values()}
    made = {title: pose_map(drive, task, span) for title, (drive, span) in spans.items() if span is not None}
    return {title: found for title, found in made.items() if found is not None}


def _drawn(one: MachineResult) -> TaskResult | None:
    """The task drawn: the first in motion with a finite power, else the first."""
    known = [task for task in one.tasks.values() if np.isfinite(task.mean_power)]
    return next((task for task in known if np.any(task.twist)), next(iter(known), None))


_LOSSES = (
    "Losses by part in each task and on each path (means over the period). Pale bars lie beyond a limit. No bar where a wheel "
    "slips or the machine does not reach, as no steady motion exists."
)
_PATH = (
    "Displacement of the end point from its mean, power from the source and to the load, with steering and inertias that are "
    "stated."
)
_MAP = (
    "Loss of steady points over positions of the end point in the first task, where all limits hold; elsewhere the tightest "
    "limit. The other coordinates, twist and wrench are those of the task."
)
