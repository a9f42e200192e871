"""Runs and maps of stability as labelled arrays; other results state theirs themselves, see `infinivar._core.described`."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar._core.described import unit_of
from infinivar._core.netcdf import Arrays
from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.run import History
from infinivar.analysis.sessions.session_result import Session
from infinivar.analysis.simulate import Simulation
from infinivar.bondgraph.audit import Trajectory
from infinivar.displays.stability import StabilityMap


def simulation(found: Simulation) -> Arrays:
    """Motion, forces and powers over time, and energies by source, loss, storage and element."""
    columns = {
        name: ("time", values, {"units": unit_of(name)}) for name, values in found.columns.items() if name != "time_s"
    }
    made = trajectory(found.trajectory)
    return made._replace(data={**columns, **made.data}, attributes={"title": found.title})


def machine_run(found: MachineRun | Session) -> Arrays:
    """Motion, forces and demands over time, and energies by source, loss and storage."""
    columns = {name: ("time", values, {"units": unit_of(name)}) for name, values in found.columns.items()}
    made = _energies(found)
    return made._replace(data={**columns, **made.data}, attributes={"title": found.title})


def _energies(run: History) -> Arrays:
    """Energies over time by source, loss and storage."""
    data: dict[str, Any] = {}
    groups = {"supplied": run.supplied, "lost": run.lost, "stored": run.stored}
    for kind, group in groups.items():
        data[f"energy_{kind}_J"] = ((kind, "time"), np.array(list(group.values())), {"units": "J"})
    meaning = "unaccounted energy over energy moved"
    data["energy_residual"] = ("time", run.residual, {"units": "1", "long_name": meaning})
    labels = {kind: list(group) for kind, group in groups.items()}
    return Arrays(data, {"time": ("time", run.time, {"units": "s"}), **labels})


def trajectory(run: Trajectory) -> Arrays:
    """Energies over time by source, loss and storage, and by element."""
    made = _energies(run)
    data = dict(made.data)
    elements = [element.name for element in run.graph.elements]
    energies = [run.energy(name) for name in elements]
    for what in energies[0]._fields:
        table = np.array([getattr(energy, what) for energy in energies])
        data[f"element_energy_{what}_J"] = (("element", "time"), table, {"units": "J"})
    return made._replace(data=data, coordinates={**made.coordinates, "element": elements})


def stability_map(found: StabilityMap) -> Arrays:
    """Growth per sample over both parameters, and the ends of the stable values of the first."""
    axes = (found.second, found.first)
    words = {"least": "from which all larger values are stable", "most": "up to which all smaller values are stable"}
    data = {"growth": (axes, found.growth, {"units": "1", "long_name": "largest growth per sample; stable up to 1"})}
    data |= {
        name: (axes[:1], getattr(found, name), {"units": found.units[0], "long_name": said})
        for name, said in words.items()
    }
    coords = {
        name: (name, values, {"units": unit})
        for name, values, unit in zip((found.first, found.second), (found.x, found.y), found.units, strict=True)
    }
    return Arrays(data, coords, {"display": found.display, "held": found.held})
