"""Time histories and limits of the springs and the linkage between a drive and its load, from a simulated run."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar.axis import Axis
from infinivar.bondgraph.audit import Trajectory
from infinivar.bondgraph.march import Instants
from infinivar.drivetrain.graphs.output_pieces import names
from infinivar.drivetrain.output import Output, Place
from infinivar.limits import Demand, Limit
from infinivar.parts.linkage import Linkage


def load_columns(run: Trajectory | Instants, output: Output, axis: Axis) -> dict[str, Any]:
    """Position and speed of the load, under their names along a line or about a joint."""
    position, speed, _ = axis.columns
    of = ("load", "load_rate") if output.chain else ("l", "ldot")
    return {position: run.signals[of[0]], speed: run.signals[of[1]]}


def columns(run: Trajectory, output: Output, axis: Axis) -> dict[str, Any]:
    """Position and speed of the drive, and deflections of the series springs; none without springs and linkage.

    Parameters
    ----------
    run : Trajectory
    output : Output
    axis : Axis   Of the load.

    Returns
    -------
    dict of str to (n,) float   Under names that end in their unit.
    """
    if not output.chain:
        return {}
    linkage = output.linkage
    unit = "rad" if (axis.rotary if linkage is None else linkage.rotary_drive) else "m"
    found = {f"drive_position_{unit}": run.signals["l"], f"drive_speed_{unit}_s": run.signals["ldot"]}
    for place in output.chain:
        if place.kind == "series":
            unit = "rad" if "torsion" in place.name else "m"
            found[f"{place.name.replace(' ', '_')}_deflection_{unit}"] = _deflection(run, place)
    return found


def demands(run: Trajectory | Instants, output: Output) -> dict[Demand, Any]:
    """Travel of springs and range of the linkage over their allowance, over time."""
    found: dict[Demand, Any] = {}
    for place in output.chain:
        part = place.part
        if isinstance(part, Linkage):
            angle = run.signals["joint" if "joint" in run.signals else "load"]
            found[Limit.LINKAGE, place.name] = np.asarray(part.demand(angle))
        elif part.shape == "progressive":
            found[Limit.SPRING, place.name] = np.asarray(part.demand(_deflection(run, place)))
        elif part.shape == "one-sided" and place.kind == "series":
            found[Limit.SPRING, place.name] = np.asarray(part.pull_demand(run.at(names(place).elastic)[0]))
    return found


def _deflection(run: Trajectory | Instants, place: Place) -> Any:
    """Deflection of a spring; the state of a linear one is its deflection from the free state, if it has one."""
    assert not isinstance(place.part, Linkage)
    name = names(place).elastic
    return place.part.deflection(run.at(name)[0]) if place.part.shape == "linear" else run.states[name]
