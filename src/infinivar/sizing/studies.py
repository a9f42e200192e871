"""Designs of a search as studies: with the source of each value, and the motions as runs to simulate."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.array_namespace import bisect
from infinivar._core.fields import described, value_at
from infinivar._core.frozen import FrozenDict
from infinivar._core.text import joined
from infinivar.drivetrain.drive import Drive, is_machine
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.motion.waypoints import RecordedForce, Waypoints
from infinivar.parts.motor import SCALED
from infinivar.sizing.design import (
    AXLE_BEARING,
    CYLINDER_BEARING,
    FOLLOWING,
    SCALES,
    STANDBY,
    STEERING_MOTOR,
    SizedDrive,
    path_words,
    role_words,
    short_path,
    tried_words,
)
from infinivar.study.provenance import DEFAULT, Provenance, recorded, same, text_of
from infinivar.study.spreads import Uncertainty
from infinivar.study.study import Study

_OF_STUDY, _OF_TASKS = ("requirement", "envelope", "rig"), ("tasks.", "paths.")
"""Whose values a design's study states as that of the search does, besides those of its template."""
_NODES = 400
"""Points of a file over one cycle."""
_TITLE = 120
"""Longest title of a study or drive."""
_STEPS = 400
"""Output steps over one cycle."""


def study_of(study: Study, design: SizedDrive, name: str, scenarios: Mapping[str, Scenario] | None = None) -> Study:
    """Return a study with a design as its only drive, and more scenarios beside its own.

    A scenario of a duty cycle that cannot be simulated with the design is left out.

    Its description says what was searched, as that of the study is on drives that it no longer has. Each value of a part has
    the source that its set states, each value that was searched says so. Spreads of replaced parts are left out.
    """
    owner = design.template
    kept = tuple(
        row
        for row in study.provenance
        if (row.owner in (owner, *_OF_STUDY) or row.owner.startswith(_OF_TASKS)) and not _replaced(design, row)
    )
    spreads = tuple(one for one in study.uncertainty.spreads.get(owner, ()) if not _within(design, one.path))
    paths = {one.path for one in spreads}
    able = {
        key: one
        for key, one in (scenarios or {}).items()
        if key not in study.duty or not_simulated(design.drive, study.duty[key]) is None
    }
    uncertainty = Uncertainty(
        spreads=FrozenDict({owner: spreads} if spreads else {}),
        correlations=FrozenDict(
            {
                key: value
                for key, value in study.uncertainty.correlations.items()
                if key[0] == owner and {*key[1:]} <= paths
            }
        ),
        draws=study.uncertainty.draws,
    )
    return replace(
        study,
        name=name,
        title=_shortened(f"{study.title}: {design.title}"),
        description=_description(study, design),
        reconstruction=_reconstruction(study, owner, kept),
        drives={owner: design.drive},
        titles={owner: _shortened(design.title)},
        scenarios={**study.scenarios, **able},
        uncertainty=uncertainty,
        provenance=(*kept, *_sources(owner, design), *_following(study, design)),
        path=None,
    )


def _shortened(title: str) -> str:
    """A title that a study file can have."""
    return title if len(title) <= _TITLE else f"{title[: _TITLE - 3].rstrip(' ,')}..."


def _description(study: Study, design: SizedDrive) -> str:
    """What a design is: that of the study describes its drives as they were."""
    chosen = [*map(role_words, design.parts), *map(path_words, design.free)]
    named = joined(chosen) if chosen else "nothing"
    stated = {"requirement": study.requirement, "motions": study.duty, "tasks": study.tasks, "paths": study.paths}
    kept = " and ".join(name for name, one in stated.items() if one)
    return (
        f"Result of a search over parts for the study {study.name}, with its drive {design.template} as the template. Searched: "
        f"{named}. All else in the drive is the template's; {kept} as in the study."
    )


def _reconstruction(study: Study, owner: str, kept: Iterable[Provenance]) -> tuple[str, ...]:
    """What the design takes over from a reconstruction: the study's statements are on a machine with other parts."""
    assumed = sum(row.kind == "assumed" and row.where != DEFAULT for row in kept)
    if not study.reconstruction or not assumed:
        return ()
    return (
        f"The study {study.name} has a drive that is a reconstruction. This design takes over {assumed} assumed values from its "
        f"template {owner}, the requirement and the rig; the source beside each says where it is from. They are plausible but "
        "not validated.",
    )


_OF_FRICTION = (
    "friction_model",
    "friction_coefficient",
    "viscosity",
    "lubrication",
    "oil_level",
    "drag_factor",
    "boundary_friction",
    "starting_friction",
    "ehl_friction",
)

_KEPT = {"gearhead": ("loss_model",), AXLE_BEARING: _OF_FRICTION, CYLINDER_BEARING: _OF_FRICTION}
"""Fields that a part of a set does not bring with it, by role: those of the template stay."""


_COUNTED = {
    "motor": ("viscous_friction",),
    "gearhead": ("friction", "backdriving_efficiency", "stiffness", "backlash"),
    STEERING_MOTOR: ("viscous_friction",),
}
"""Fields of parts that change losses or motion and that most sets do not state, by role; limits have a line of their own."""


def _within(design: SizedDrive, path: str) -> bool:
    return path in design.free or any(path.startswith(f"{role}.") for role in design.parts)


def _replaced(design: SizedDrive, row: Provenance) -> bool:
    """Whether a value of the template is of a part that the design replaces."""
    role, _, name = row.field.rpartition(".")
    if row.owner == design.template and row.field in _following_of(design):
        value = _of_path(design.drive, row.field)
        return value is None or not same(row.value, value)
    return row.owner == design.template and name not in _KEPT.get(short_path(role), ()) and _within(design, row.field)


def _sources(owner: str, design: SizedDrive) -> Iterator[Provenance]:
    for role, part in design.parts.items():
        instance = value_at(design.drive, role)
        for field in described(type(instance)):
            value = getattr(instance, field.name)
            if (
                value is not None
                and not dataclasses.is_dataclass(value)
                and field.name not in _KEPT.get(short_path(role), ())
            ):
                several = part.number != 1.0 and field.name in SCALED
                kind = "derived" if field.name in part.derived or several else part.kind
                where = f"{part.number:g} on one shaft of {part.where}" if several else part.where
                yield _row(owner, f"{role}.{field.name}", field, value, kind, where)
    for path, free in design.free.items():
        if path in SCALES:  # the values of the motor say how many there are
            continue
        outer, _, inner = path.rpartition(".")
        stage = value_at(design.drive, outer) if outer else design.drive
        field = next(one for one in described(type(stage)) if one.name == inner)
        around = "" if math.isnan(free.low) else f", feasible from {free.low:.4g} to {free.high:.4g} {free.unit}"
        around = f", {tried_words(free.tried, free.unit)}" if free.tried else around
        yield _row(owner, path, field, free.value, "derived", f"search over parts{around}")


def _following_of(design: SizedDrive) -> dict[str, tuple[str, str]]:
    """Values of a design that follow from what was searched, and where they come from."""
    lead = "leg." if is_machine(design.drive) else ""
    found = {f"{lead}{path}": said for path, said in FOLLOWING.items()} if design.architecture == "cobotic" else {}
    if any(path in SCALES for path in design.free) and STANDBY not in design.free:
        found[STANDBY] = "derived", "an amplifier for each motor, like those of the template"
    return found


def _following(study: Study, design: SizedDrive) -> Iterator[Provenance]:
    """Sources of values that follow from what was searched, where they are not the template's."""
    for path, (kind, where) in _following_of(design).items():
        value = _of_path(design.drive, path)
        if value is not None and value != _of_path(study.drives[design.template], path):
            outer, _, inner = path.rpartition(".")
            owner = value_at(design.drive, outer) if outer else design.drive
            field = next(one for one in described(type(owner)) if one.name == inner)
            yield _row(design.template, path, field, value, kind, where)


def _of_path(drive: Drive, path: str) -> Any:
    """Value at a path; None where the drive has no such part."""
    value: Any = drive
    for step in path.split("."):
        value = getattr(value, step, None)
    return value


def _row(owner: str, path: str, field: dataclasses.Field[Any], value: Any, kind: str, where: str) -> Provenance:
    return Provenance(
        owner=owner,
        field=path,
        written=text_of(field, value),
        value=recorded(value),
        unit=field.metadata.get("unit", ""),
        kind=kind,
        where=where,
    )


def not_taken_over(study: Study, best_of: Mapping[str, SizedDrive]) -> Iterator[str]:
    """What a template's motors and gearhead have and those of its best design do not, a line for each part."""
    for template, design in best_of.items():
        for role in design.parts:
            own, other = value_at(study.drives[template], role), value_at(design.drive, role)
            lost = [
                name for name in _COUNTED.get(short_path(role), ()) if _stated(own, name) and not _stated(other, name)
            ]
            more = {one.name for one in dataclasses.fields(own)} - {one.name for one in dataclasses.fields(other)}
            if lost or more:
                yield (
                    f"drives.{template}: designs like it do not count {' and '.join([*lost, *sorted(more)])} of its "
                    f"{role_words(role)}, which {design.parts[role].name} does not state"
                )


def _stated(part: Any, name: str) -> bool:
    return getattr(part, name, None) is not None


def not_simulated(drive: Drive, duty: DutyCycle) -> str | None:
    """Why a motion from a file cannot be simulated with a drive; None if it can.

    The force of a file is linear between its times. Where its slope jumps, so does the rate of a spring that a load without
    inertia follows, see `drivetrain.graphs.output_start`.
    """
    output = getattr(drive, "output", None)
    if duty.moved_mass or output is None or not output.has_series_spring:
        return None
    key, what = ("load_inertia", "moment of inertia") if duty.axis.rotary else ("load_mass", "mass")
    return f"behind a series spring, a simulation needs a {what} of the load; add {key} to the duty cycle"


def motion_file(duty: DutyCycle) -> str | None:
    """Two cycles of a motion from an instant at rest on, as a CSV file for scenarios; None for a run, or one never at rest."""
    begin = _resting_instant(duty)
    if begin is None:
        return None
    time = np.arange(2 * _NODES + 1) * (duty.period / _NODES)
    position, course = duty.at((begin + time) % duty.period)
    force = np.broadcast_to(np.asarray(course.force, dtype=float), time.shape)
    axis = duty.axis
    lines = [
        f"time [s],{axis.position} [{axis.position_unit}],{axis.force} [{axis.force_unit}]",
        *(
            f"{at!r},{where!r},{push!r}"
            for at, where, push in zip(time.tolist(), position.tolist(), force.tolist(), strict=True)
        ),
    ]
    return "\n".join(lines) + "\n"


def scenario_of(duty: DutyCycle, file: Path) -> Scenario:
    """Two cycles of a motion to simulate, from its file: the first to settle, the second to evaluate."""
    mass, rotary = duty.moved_mass, duty.axis.rotary
    return Scenario(
        title=duty.title,
        duration=2.0 * duty.period,
        output_step=duty.period / _STEPS,
        settling_time=duty.period,
        motion=Waypoints.read(str(file)),
        force=RecordedForce.read(str(file)),
        load_mass=None if rotary else mass or None,
        load_inertia=mass or None if rotary else None,
    )


def _resting_instant(duty: DutyCycle) -> float | None:
    """An instant of a closed cycle at which the load is at rest. [s]"""
    if not duty.closed:
        return None
    time = np.arange(_NODES + 1) * (duty.period / _NODES)
    speed = np.broadcast_to(np.asarray(duty.at(time % duty.period)[1].speed, dtype=float), time.shape)
    still = np.flatnonzero(speed == 0.0)
    if still.size:
        return float(time[still[0]])
    turns = np.flatnonzero(speed[1:] * speed[:-1] < 0.0)
    if not turns.size:
        return None
    between = time[turns[0] : turns[0] + 2, None]
    way = np.sign(speed[turns[0] + 1])
    rest = bisect(np, lambda at: way * np.asarray(duty.at(at % duty.period)[1].speed), *between)
    return float(rest[0])
