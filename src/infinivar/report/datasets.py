"""Results as labelled arrays: every quantity with a name, axes and a unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.labels import Labels
from infinivar._core.netcdf import Arrays
from infinivar.analysis.compare import DriveResult
from infinivar.analysis.cycles.cylinder_policy import Policy
from infinivar.analysis.cycles.duty_result import DutyResult
from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.analysis.design_trends import Trend
from infinivar.analysis.least_loss import LeastLoss
from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.motion_summary import MotionSummary
from infinivar.analysis.robustness.verdicts import BuildsMap
from infinivar.analysis.run import History
from infinivar.analysis.sessions.session_result import Session
from infinivar.analysis.sessions.stability import StabilityMap
from infinivar.analysis.sessions.z_width import ZWidth
from infinivar.analysis.simulate import Simulation
from infinivar.analysis.sphere_map import SphereMap
from infinivar.analysis.steady_map import SteadyMap
from infinivar.axis import Axis
from infinivar.bondgraph.audit import Trajectory
from infinivar.contact.exact.patch import SteadyRolling
from infinivar.contact.exact.transient import TransientRolling
from infinivar.drivetrain.drive import DrivePoint, MovingPoint
from infinivar.limits import Limit
from infinivar.parts.heat import Heat
from infinivar.transmission.operating_point import OperatingPoint

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


def _codes() -> dict[str, Any]:
    """CF attributes that explain the integer codes of limits."""
    return {
        "flag_values": np.array([limit.value for limit in Limit.every()], dtype=np.int8),
        "flag_meanings": " ".join(limit.name for limit in Limit.every()),
    }


def _losses(losses: Mapping[str, Any]) -> dict[str, tuple[Any, dict[str, Any]]]:
    return {f"loss_{_word(name)}": (loss, {"units": "W", "long_name": f"power lost in {name}"})
            for name, loss in losses.items()}  # fmt: skip


def _word(name: str) -> str:
    return name.replace(" ", "_")


def _demands(demands: Mapping[Any, Any]) -> dict[str, tuple[Any, dict[str, Any]]]:
    """Demands over allowances by limit, or by limit and part."""
    found = {}
    for key, demand in demands.items():
        limit, *part = key if isinstance(key, tuple) else (key,)
        name = "_".join(["demand", limit.name.lower(), *map(_word, part)])
        found[name] = (
            demand,
            {"units": "1", "long_name": f"{' of '.join([limit.words, *part])}: demand over allowance"},
        )
    return found


def _states(states: Mapping[str, Any]) -> dict[str, tuple[Any, dict[str, Any]]]:
    return {name: (value, {"units": unit_of(name)}) for name, value in states.items()}


def _spread(variables: Mapping[str, tuple[Any, dict[str, Any]]], labels: Labels | None, last: str = "") -> Arrays:
    """Variables of one shape; axes without labels are numbered, and the last one may have a name."""
    arrays = np.broadcast_arrays(*(np.asarray(value) for value, _ in variables.values()))
    count = arrays[0].ndim
    dims = tuple(f"axis_{place}" for place in range(count))
    if labels is not None:
        dims = labels.dims
    elif last and count:
        dims = (*dims[:-1], last)
    data = {name: (dims, array, attrs) for array, (name, (_, attrs)) in zip(arrays, variables.items(), strict=True)}
    if labels is None:
        return Arrays(data)
    taken = {name: variable for name, variable in labels.coords.items() if name not in data}
    return Arrays(data, taken)


def point(found: DrivePoint | OperatingPoint) -> Arrays:
    """Powers, losses, demands and states of an operating point."""
    fields = _POINT if isinstance(found, DrivePoint) else {**_ELEMENT, **_POINT}
    variables = {
        name: (getattr(found, name), {"units": unit, "long_name": meaning}) for name, (unit, meaning) in fields.items()
    }
    variables["limit"][1].update(_codes())
    variables |= _losses(found.losses) | _demands(found.utilisation)
    if isinstance(found, DrivePoint):
        variables |= _states(found.states)
    return _spread(variables, found.labels)


def moving_point(found: MovingPoint) -> Arrays:
    """Powers, losses, power stored, demands and states over the instants of a motion."""
    variables = {name: (getattr(found, name), {"units": unit, "long_name": meaning})
                 for name, (unit, meaning) in _POINT.items() if unit == "W"}  # fmt: skip
    stored = {f"stored_{_word(name)}": (value, {"units": "W", "long_name": f"power into the inertia of {name}"})
              for name, value in found.stored.items()}  # fmt: skip
    variables |= _losses(found.losses) | stored | _demands(found.utilisation) | _states(found.states)
    return _spread(variables, None, last="instant")


def steady_map(found: SteadyMap) -> Arrays:
    """The map over speed and force; labelled axes keep their dimensions, names and coordinates."""
    grid = ("speed", "force") if found.labels is None else found.labels.dims
    variables = {
        name: (getattr(found, name), {"units": unit, "long_name": meaning}) for name, (unit, meaning) in _POINT.items()
    }
    variables["limit"][1].update(_codes())
    order = ["power_in", "power_out", *(losses := _losses(found.losses)), "efficiency", "limit", "margin"]
    variables |= losses
    coords = _plane(found.axis, grid, found.speed, found.force)
    if found.labels is not None:
        # An axis with its own name is not repeated under the default name.
        named = dict(found.labels.coords)
        coords = {usual: axis for usual, axis in coords.items() if not _holds(named, axis)} | named
    data = {name: (grid, *variables[name]) for name in order}
    return Arrays(data, coords, {"audit_residual": found.audit_residual, "engine": found.engine})


def _holds(coords: Mapping[str, Any], axis: tuple[Any, ...]) -> bool:
    """Whether one of the coordinates is an axis of the map."""
    return any(tuple(dims) == (axis[0],) and np.array_equal(values, axis[1]) for dims, values, _ in coords.values())


def drive_result(found: DriveResult) -> Arrays:
    """The drive's map, with its verdict among the attributes."""
    made = steady_map(found.map)
    return made._replace(attributes={**made.attributes, "title": found.title, "verdict": found.verdict})


def dynamic_map(found: DynamicMap) -> Arrays:
    """Performance, limits and mean powers over frequency and share of the maximum power."""
    grid = ("frequency", "fraction")
    names = ", ".join(f"{place} {limit.name} ({what})" for place, (limit, what) in enumerate(found.demands, 1))
    data = {
        "amplitude": (grid, found.amplitude, {"units": "m"}),
        "performance": (grid, found.performance, {"units": "1", "long_name": found.definition.words}),
        "binding": (grid, found.binding, {"units": "1", "long_name": f"limit exceeded: 0 none, {names}"}),
        "margin": (grid, found.margin, {"units": "1"}),
        "power_in": (grid, found.power_in, {"units": "W"}),
        "exchanged": (grid, found.exchanged, {"units": "W"}),
        **{f"loss_{_word(name)}": (grid, loss, {"units": "W"}) for name, loss in found.losses.items()},
    }
    coordinates = {
        "frequency": ("frequency", found.frequency, {"units": "Hz"}),
        "fraction": ("fraction", found.fraction, {"units": "1", "long_name": "RMS power over the maximum power"}),
    }
    return Arrays(data, coordinates, {"power": found.power, "load_mass": found.load_mass})


def builds_map(found: BuildsMap) -> Arrays:
    """Share of samples within limits, and their efficiency, over speed and force."""
    grid = ("speed", "force")
    data = {
        "within": (grid, found.within, {"units": "1", "long_name": "share of samples within all limits"}),
        "efficiency": (grid, found.efficiency, {"units": "1", "long_name": "mean efficiency of samples within limits"}),
        "spread": (grid, found.spread, {"units": "1", "long_name": "standard deviation of that efficiency"}),
        **{
            f"limit_{limit.name.lower()}": (grid, share, {"units": "1", "long_name": f"share limited by {limit.words}"})
            for limit, share in found.limits.items()
        },
    }
    return Arrays(data, _plane(found.axis, grid, found.speed, found.force))


def least_loss(found: LeastLoss) -> Arrays:
    """Best drive, its loss and its lead over speed and force."""
    grid = ("speed", "force")
    codes = {"flag_values": np.arange(len(found.titles), dtype=np.int8), "flag_meanings": " ".join(found.titles)}
    data = {
        "best": (
            grid,
            found.best,
            {"units": "1", "long_name": "drive with the least loss; -1 if none is feasible", **codes},
        ),
        "runner_up": (
            grid,
            found.runner_up,
            {"units": "1", "long_name": "drive with the next least loss; -1 if none", **codes},
        ),
        "loss": (grid, found.loss, {"units": "W", "long_name": "loss of the best drive"}),
        "saved": (grid, found.saved, {"units": "W", "long_name": "loss of the runner-up minus that of the best drive"}),
        "limit": (grid, found.limit, {"units": "1", "long_name": "limit where no drive is feasible", **_codes()}),
        "required": (grid, found.required.astype(np.int8), {"units": "1", "long_name": "1 in the required region"}),
    }
    return Arrays(data, _plane(found.axis, grid, found.speed, found.force))


def sphere_map(found: SphereMap) -> Arrays:
    """Speeds, torques, powers and losses of a sphere between rollers over steering angle and load."""
    grid = ("steering_angle", "load")
    named = {
        "input_speed": ("rad s-1", "speed of shaft 1"),
        "output_speed": ("rad s-1", "speed of shaft 2"),
        "input_torque": ("N m", "torque applied to shaft 1"),
        "output_torque": ("N m", "torque that shaft 2 applies to its load"),
        "power_in": ("W", "power into shaft 1"),
        "power_out": ("W", "power out of shaft 2"),
        "efficiency": ("1", "useful power over power spent"),
    }
    data: dict[str, Any] = {
        name: (grid, getattr(found, name), {"units": unit, "long_name": words}) for name, (unit, words) in named.items()
    }
    for name, (loss, attrs) in _losses(found.losses).items():
        data[name] = (grid, loss, attrs)
    data["limit"] = (grid, found.limit, {"units": "1", "long_name": "limit exceeded", **_codes()})
    data["ratio"] = ("steering_angle", found.ratio, {"units": "1", "long_name": "speed ratio without creep"})
    return Arrays(
        data,
        {
            "steering_angle": ("steering_angle", found.steering_angle, {"units": "rad", "long_name": "steering angle"}),
            "load": ("load", found.load, {"units": "N", "long_name": "scale of the forces of the drive rollers"}),
        },
    )


def _plane(axis: Axis, grid: tuple[str, ...], speed: np.ndarray, force: np.ndarray) -> dict[str, Any]:
    """Coordinates of a force-speed plane; about a joint, `speed` is an angular speed and `force` a moment."""
    units = ("rad s-1", "N m") if axis.rotary else ("m s-1", "N")
    return {
        "speed": (grid[0], speed, {"units": units[0], "long_name": f"{axis.speed} of the load"}),
        "force": (grid[1], force, {"units": units[1], "long_name": f"{axis.force} on the load"}),
    }


def duty(found: DutyResult) -> Arrays:
    """The cycle over time: motion, powers, states and losses."""
    columns = found.columns
    time = columns.pop("time_s")
    data: dict[str, Any] = {name: ("time", values, {"units": unit_of(name)}) for name, values in columns.items()}
    for name, (loss, attrs) in _losses(found.point.losses).items():
        data[name] = ("time", np.broadcast_to(loss, time.shape), attrs)
    attrs = {
        "title": found.title,
        "verdict": found.verdict,
        "energy_per_cycle_J" if found.duty.closed else "energy_over_run_J": found.energy,
    }
    return Arrays(data, {"time": ("time", time, {"units": "s"})}, attrs)


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


def heat(found: Heat) -> Arrays:
    """Temperatures over time, from a cold start."""
    data = {
        "winding": ("time", found.winding_history, {"units": "K"}),
        "housing": ("time", found.housing_history, {"units": "K"}),
    }
    return Arrays(data, {"time": ("time", found.time, {"units": "s"})}, {"permissible": found.permissible})


def policy(found: Policy) -> Arrays:
    """Cylinder speed over the cycle; a constant speed has two equal points."""
    speed = found.slowest if found.cylinder_speed is None else found.cylinder_speed.value
    values = np.broadcast_to(speed, (2,)) if np.ndim(speed) == 0 else np.asarray(speed)
    share = {
        "share": (
            "share",
            (np.arange(values.size) + 0.5) / values.size,
            {"units": "1", "long_name": "share of the cycle"},
        )
    }
    data = {"cylinder_speed": ("share", values, {"units": "rad s-1"})}
    return Arrays(data, share, {"name": found.name, "power_in": found.power_in})


def trend(found: Trend) -> Arrays:
    """Efficiency, losses and limit over the values of the design parameter."""
    at = ("value",)
    data = {
        "efficiency": (at, found.efficiency, {"units": "1"}),
        **{name: (at, *variable) for name, variable in _losses(found.losses).items()},
        "limit": (at, np.array(found.limit, dtype=np.int8), {"units": "1", **_codes()}),
    }
    return Arrays(data, {"value": ("value", found.values, {})}, {"parameter": found.parameter})


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


def steady_rolling(found: SteadyRolling) -> Arrays:
    """Tractions, slip and bounds of the cells of a patch, and its forces. Units are those of `SteadyRolling`."""
    cells, vectors = ("row", "cell"), ("component", "row", "cell")
    data = {
        "x": (cells, found.grid.x, {"units": "1", "long_name": "along the rolling direction, over c"}),
        "y": ("row", found.grid.y, {"units": "1", "long_name": "lateral, over c"}),
        "traction": (vectors, found.traction, {"units": "1", "long_name": "traction on the track times c^2/(mu N)"}),
        "slip": (vectors, found.slip, {"units": "1", "long_name": "slip of the wheel times G c^2/(mu N V)"}),
        "bound": (cells, found.grid.bound, {"units": "1", "long_name": "largest traction times c^2/(mu N)"}),
        "slides": (cells, found.slides.astype(np.int8), {"units": "1", "long_name": "1 on the friction bound"}),
        "area": (cells, np.broadcast_to(found.grid.area, found.slides.shape), {"units": "1", "long_name": "over c^2"}),
    }
    totals = {"fx": found.fx, "fy": found.fy, "mz": found.mz, "power": found.power}
    data |= {name: ((), np.asarray(value), {"units": "1"}) for name, value in totals.items()}
    return Arrays(data, {"component": ["x", "y"]}, {"outcome": found.outcome, "a_over_b": found.grid.a_over_b})


def transient_rolling(found: TransientRolling) -> Arrays:
    """Forces and energies by distance rolled, tractions and slip where they are kept. Units are those of `TransientRolling`."""
    cells, vectors = ("kept", "row", "cell"), ("kept", "component", "row", "cell")
    series = ("fx", "fy", "mz", "energy", "work", "dissipated")
    data = {name: ("distance", getattr(found, name), {"units": "1"}) for name in series}
    data |= {
        "converged": ("distance", np.array([one == "converged" for one in found.outcome], np.int8), {"units": "1"}),
        "x": (cells[1:], found.grid.x, {"units": "1", "long_name": "along the rolling direction, over c"}),
        "y": ("row", found.grid.y, {"units": "1", "long_name": "lateral, over c"}),
        "traction": (vectors, found.traction, {"units": "1", "long_name": "traction on the track times c^2/(mu N)"}),
        "slip": (vectors, found.slip, {"units": "1", "long_name": "slip of the wheel per distance times G c^2/(mu N)"}),
        "slides": (cells, found.slides.astype(np.int8), {"units": "1", "long_name": "1 on the friction bound"}),
    }
    axes = {
        "distance": ("distance", found.distance, {"units": "1", "long_name": "distance rolled over c"}),
        "kept": ("kept", found.distance[found.kept], {"units": "1", "long_name": "distance rolled over c"}),
        "component": ["x", "y"],
    }
    return Arrays(data, axes, {"start_energy": found.start_energy, "a_over_b": found.grid.a_over_b})


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
