"""Order of designs, and the values that a design is returned with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.pareto import front
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.candidates import LIMIT_FIELDS, Candidates
from infinivar.sizing.geared.result import Design, Objective
from infinivar.sizing.geared.sampled import UNCHECKED, Sampled


def unchecked(found: Candidates, stages: int) -> dict[Any, int]:
    """Number of candidates whose data sheets do not state a limit, of those that are judged."""
    missing = {key: int(np.sum(~found.stated(key, found.usable))) * stages for key in LIMIT_FIELDS}
    return {key: number for key, number in missing.items() if number}


def mixed(power: Mapping[str, np.ndarray], shares: Mapping[str, float]) -> Any:
    """Mean power over all motions, by their shares of time; nan without a motion. [W]"""
    return sum(shares[name] * drawn for name, drawn in power.items()) if power else np.nan


def ranked(
    found: Candidates,
    rows: np.ndarray,
    stage: OutputStage,
    done: Sampled,
    shares: Mapping[str, float],
    objective: Objective,
    top: int,
) -> list[tuple[tuple[float, ...], Design]]:
    """The best feasible designs at a stage, each with its rank."""
    able = np.flatnonzero(done.feasible)
    drawn = np.broadcast_to(mixed(done.power, shares), rows.shape)
    first = found.mass(rows) if objective == "mass" else drawn
    if objective == "front":
        order = able[front(found.mass(rows[able]), drawn[able])]
    else:
        order = able[np.lexsort((rows[able], done.worst[able], first[able]))][:top]
    return [
        (
            (float(first[place]), float(done.worst[place]), int(rows[place])),
            design(found, int(rows[place]), stage, done, int(place), float(drawn[place])),
        )
        for place in order
    ]


def design(
    found: Candidates,
    row: int,
    stage: OutputStage,
    done: Sampled,
    place: int,
    power: float,
    radii: tuple[float, float] = (np.nan, np.nan),
) -> Design:
    """A candidate as a design, with what was found at a place of a sample."""
    lacking = tuple(key for key in LIMIT_FIELDS if not found.stated(key, np.array([row]))[0])
    return Design(
        pair=row,
        motor=int(found.pairs[row, 0]),
        gearhead=int(found.pairs[row, 1]),
        stage=stage,
        drive=found.drive(row, stage),
        mass=float(found.mass(np.array([row]))[0]),
        power=power,
        radii=radii,
        demands={
            key: float(demand[place])
            for key, demand in done.demands.items()
            if key[1:] not in lacking and demand[place] != UNCHECKED
        },
        unchecked=lacking,
    )
