"""The report of a comparison of machines, with its data files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from infinivar.analysis.machine_tasks import TaskResult
from infinivar.analysis.machines import MachineComparison, MachineResult
from infinivar.analysis.pose_map import PoseMap, pose_map
from infinivar.analysis.sphere_map import sphere_map
from infinivar.analysis.tightest import vector_words
from infinivar.errors import InputError
from infinivar.figures import arm, machine, machine_tasks, planar_cobot, sphere, style, wrench_set
from infinivar.figures import sphere_map as sphere_figure
from infinivar.limits import words_of
from infinivar.machines.kinds.planar import PlanarDrive
from infinivar.machines.kinds.platform import ArmDrive, PlatformDrive
from infinivar.machines.kinds.sphere import SphereDrive
from infinivar.power import AUDIT_TOLERANCE
from infinivar.report.comparison import provenance_tables
from infinivar.report.output import all_or_nothing
from infinivar.report.page import render, to_json, write_csv

_SHARE = 0.95
"""Largest load of a sphere map, over the slip force."""

_ROUNDING = 1e-6
"""Demand over allowance below which it is rounding. [-]"""

Drawing = tuple[str, Callable[[], Any], str]
"""Name, function that draws, and caption of a figure."""


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
        audit_tolerance=AUDIT_TOLERANCE,
        degrees=np.degrees,
    )


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
        yield from _of_machine(name, one, assumed)


def _maps(comparison: MachineComparison) -> dict[str, PoseMap]:
    """Maps over positions of the machines that have them, in the first task."""
    task = next(iter(comparison.study.tasks.values()), None)
    if task is None:
        return {}
    spans = {one.title: (one.machine, getattr(one.machine, "span", None)) for one in comparison.results.values()}
    made = {title: pose_map(drive, task, span) for title, (drive, span) in spans.items() if span is not None}
    return {title: found for title, found in made.items() if found is not None}


def _of_machine(name: str, one: MachineResult, assumed: str) -> Iterator[Drawing]:
    """Yield the figures of one machine: its geometry with forces, its set of wrenches, or its map."""
    drive, task = one.machine, _drawn(one)
    if isinstance(drive, SphereDrive):
        ivt = drive.transmission
        angles = np.radians(np.linspace(-88.0, 88.0, 45))
        loads = np.linspace(0.0, _SHARE * float(ivt.drive.slip_force), 13)
        speed = abs(drive.input_speed) / float(ivt.ideal_speeds(0.5 * np.pi)[0])
        yield (
            f"sphere-{name}",
            lambda: sphere_figure.draw_all(sphere_map(ivt, angles, loads, sphere_speed=abs(speed))),
            f"{one.title}: efficiency and losses of the transmission over steering angle and load, at {abs(speed):.3g} rad/s of "
            "the sphere, without the motor.",
        )
        if task is not None:
            yield (
                f"machine-{name}",
                lambda: sphere.draw_all(ivt, drive.steer(task.twist[0], task.wrench[0])[1]),
                f"{one.title}, task {task.title}: the rollers in their places, and their forces on the sphere. A steered roller "
                "has its axle along that part of the axis of the sphere which is tangential there.",
            )
        return
    if task is None:
        return
    if isinstance(drive, PlanarDrive):
        cobot = drive.machine
        yield (
            f"machine-{name}",
            lambda: planar_cobot.draw_all(cobot, drive.operated(task.twist, task.wrench), task.wrench),
            f"{one.title}, task {task.title}: wheels along their headings, and the forces on the machine: those of the ground, "
            "of the source that pushes it, and of its load.",
        )
    if isinstance(drive, ArmDrive):
        yield (
            f"machine-{name}",
            lambda: arm.draw_all(drive, task.pose, task.twist, task.wrench),
            f"{one.title}, task {task.title}, drawn from its geometry: torques of the joints on the load, force and velocity "
            "of the end point, and the forces that it can exert there within all limits.",
        )
    legs = getattr(drive, "legs", None)
    if isinstance(drive, PlatformDrive) and legs is not None:
        pose = drive.configuration(task.pose)
        point = legs.operate(pose, wrench=-task.wrench, twist=task.twist).legs
        yield (
            f"machine-{name}",
            lambda: machine.draw_all(drive.platform, legs.legs, point, task.pose[:3], task.pose[3:]),
            f"{one.title}, task {task.title}, drawn from its geometry. Forces are those of the user on the machine.{assumed}",
        )
        yield (
            f"wrenches-{name}",
            lambda: wrench_set.draw_all(
                [legs.wrench_set(pose), legs.wrench_set(pose, twist=task.twist)], titles=("at rest", task.title)
            ),
            f"{one.title}: wrenches of the user that ideal wheels hold at the pose of {task.title}, at rest and in that motion.",
        )


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
