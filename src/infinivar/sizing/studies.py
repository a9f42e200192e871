"""Designs of a search as studies: with the source of each value, and the motions as runs to simulate."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core.array_namespace import bisect
from infinivar._core.frozen import FrozenDict
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.motion.waypoints import RecordedForce, Waypoints
from infinivar.sizing.design import SizedDrive
from infinivar.study.provenance import Provenance, recorded, text_of
from infinivar.study.schema import described
from infinivar.study.spreads import Uncertainty
from infinivar.study.study import Study

_NODES = 400
"""Points of a file over one cycle."""
_STEPS = 400
"""Output steps over one cycle."""


def study_of(study: Study, design: SizedDrive, name: str, scenarios: Mapping[str, Scenario] | None = None) -> Study:
    """Return a study with a design as its only drive, and more scenarios beside its own.

    Each value of a part has the source that its set states, each value that was searched says so. Spreads of replaced parts
    are left out.
    """
    owner = design.template
    kept = tuple(
        row for row in study.provenance if row.owner in (owner, "requirement", "rig") and not _replaced(design, row)
    )
    spreads = tuple(one for one in study.uncertainty.spreads.get(owner, ()) if not _within(design, one.path))
    paths = {one.path for one in spreads}
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
        title=f"{study.title}: {design.title}",
        drives={owner: design.drive},
        titles={owner: design.title},
        scenarios={**study.scenarios, **(scenarios or {})},
        uncertainty=uncertainty,
        provenance=(*kept, *_sources(owner, design)),
        path=None,
    )


def _within(design: SizedDrive, path: str) -> bool:
    return path in design.free or path.partition(".")[0] in design.parts


def _replaced(design: SizedDrive, row: Provenance) -> bool:
    """Whether a value of the template is of a part that the design replaces; the loss model is not of a part."""
    return row.owner == design.template and row.field != "gearhead.loss_model" and _within(design, row.field)


def _sources(owner: str, design: SizedDrive) -> Iterator[Provenance]:
    for role, part in design.parts.items():
        instance = getattr(design.drive, role)
        for field in described(type(instance)):
            value = getattr(instance, field.name)
            if value is not None and not dataclasses.is_dataclass(value) and field.name != "loss_model":
                kind = "derived" if field.name in part.derived else part.kind
                yield _row(owner, f"{role}.{field.name}", field, value, kind, part.where)
    for path, free in design.free.items():
        outer, _, inner = path.partition(".")
        stage = getattr(design.drive, outer)
        field = next(one for one in described(type(stage)) if one.name == inner)
        around = "" if math.isnan(free.low) else f", feasible from {free.low:.4g} to {free.high:.4g} {free.unit}"
        yield _row(owner, path, field, free.value, "derived", f"search over parts{around}")


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
