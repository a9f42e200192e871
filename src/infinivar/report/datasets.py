"""Results as labelled arrays: every quantity with a name, axes and a unit."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar._core.netcdf import Arrays
from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.motion_summary import MotionSummary
from infinivar.analysis.run import History
from infinivar.analysis.sessions.session_result import Session
from infinivar.analysis.sessions.stability import StabilityMap
from infinivar.analysis.sessions.z_width import ZWidth
from infinivar.analysis.simulate import Simulation
from infinivar.bondgraph.audit import Trajectory

_ENDINGS = {
    "_m_s": "m/s",
    "_rad_s": "rad/s",
    "_rad": "rad",
    "_Nm": "N m",
    "_m": "m",
    "_N": "N",
    "_A": "A",
    "_V": "V",
    "_W": "W",
}
_POINT = {
    "power_in": ("W", "power from the supply"),
    "power_out": ("W", "power to the load"),
    "efficiency": ("1", "useful power over power spent"),
    "limit": ("1", "limit exceeded"),
    "margin": ("1", "allowance over demand of the tightest limit"),
}
_ELEMENT = {
    "cylinder_speed": ("rad s-1", "cylinder speed"),
    "steering_angle": ("rad", "steering angle"),
    "torque": ("N m", "torque on the cylinder"),
    "link_speed": ("m s-1", "link speed"),
    "link_force": ("N", "force on the link"),
    "rolling_speed": ("m s-1", "rolling speed"),
    "creep_speed": ("m s-1", "creep speed"),
    "lateral_force": ("N", "lateral force of the contact"),
}


def unit_of(name: str) -> str:
    """Unit at the end of a column name; "1" for a pure number."""
    return next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), "1")


def motion_summary(found: MotionSummary) -> Arrays:
    """The smoothed motion over time."""
    position, speed, force = found.axis.columns
    acceleration = "acceleration_rad_s2" if found.axis.rotary else "acceleration_m_s2"
    squared = "rad/s^2" if found.axis.rotary else "m/s^2"
    data: dict[str, Any] = {
        position: ("time", found.position, {"units": unit_of(position)}),
        speed: ("time", found.speed, {"units": unit_of(speed)}),
        acceleration: ("time", found.acceleration, {"units": squared}),
    }
    if found.force is not None:
        data[force] = ("time", found.force, {"units": unit_of(force)})
    if found.power is not None:
        data["power_W"] = ("time", found.power, {"units": "W"})
    return Arrays(
        data, {"time": ("time", found.time, {"units": "s"})}, {"title": found.table.file, "verdict": found.verdict}
    )


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


def z_width(found: ZWidth) -> Arrays:
    """Real and imaginary parts of the softest and the stiffest impedance."""
    data = {
        f"{name}_{part}": (
            "frequency",
            getattr(getattr(found, name), part),
            {"units": "N s m-1", "long_name": f"{part} part of the {name} impedance"},
        )
        for name in ("softest", "stiffest")
        for part in ("real", "imag")
    }
    attributes = {"display": found.display, "held": found.held, "wall_N_m": found.wall, "margin": found.margin}
    return Arrays(data, {"frequency": ("frequency", found.frequency, {"units": "Hz"})}, attributes)
