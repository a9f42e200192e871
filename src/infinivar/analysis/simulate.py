"""Simulate the bond graph of a drive under a scenario, with controllers, limits as events, and an energy balance."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, overload

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis import machine_study, run_limits, sampled_springs
from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.run import Run, error_words
from infinivar.analysis.run_limits import Event
from infinivar.axis import Axis
from infinivar.bondgraph.audit import ClosureError, Trajectory
from infinivar.bondgraph.graph import JUNCTIONS, TWO_PORTS
from infinivar.bondgraph.march import Instants, Watch
from infinivar.bondgraph.solver import RTOL, solve
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive, axis_fault, check_drive, refuse_machine
from infinivar.drivetrain.graphs.closed_loop import ClosedLoop, closed_loop
from infinivar.drivetrain.graphs.output_pieces import names
from infinivar.drivetrain.output import Output, Place
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.machines.machine import Machine
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.motion.motion import states_over
from infinivar.motion.scenario import Scenario, check_scenario
from infinivar.parts.linkage import Linkage
from infinivar.parts.motor import Motor
from infinivar.transmission import creepage, turning
from infinivar.units import plain

STEPS = 1000
"""Default number of output steps of a run; limits are judged between them as well."""

_ERROR = "position error"
"""Key of what is watched besides limits."""


@result
class Simulation(Run, Result):
    """Result of a simulated scenario.

    Attributes
    ----------
    drive, scenario   Arguments of the call.
    title             Name of the drive for reports.
    trajectory        States, signals, efforts, flows and energies over time, with the audit.
    columns           Main time histories, under names that end in their unit: time_s, position_m, speed_m_s,
        wanted_position_m, force_N (external force on the load), motor_current_A, motor_voltage_V, supply_power_W; with a
        wheel also steering_angle_rad, cylinder_speed_rad_s, slip_ratio, steering_current_A, steering_voltage_V. About a
        joint, the first are angle_rad, speed_rad_s, wanted_angle_rad and moment_Nm. With springs or a linkage between drive
        and load also drive_position_m, drive_speed_m_s and deflections of series springs.
    events            Intervals in which a demand exceeds its allowance, by start time.
    root_mean_squares Root mean square of each demand that it limits, over the run after its settling time: current of each
        motor over its continuous current, output torque of the gearhead over its continuous torque. [-]
    largest_error     Largest position error of the load, between outputs as well. [m], [rad]
    """

    drive: CoboticDrive | ConventionalDrive
    scenario: Scenario
    title: str
    trajectory: Trajectory
    columns: Mapping[str, Any]
    events: tuple[Event, ...]
    root_mean_squares: Mapping[Demand, float]
    largest_error: float = 0.0

    @property
    def history(self) -> Trajectory:
        """The trajectory."""
        return self.trajectory

    @property
    def heating(self) -> dict[str, float]:
        """Root mean square of each motor's current over its continuous current, after settling. [-]"""
        return self._means(Limit.THERMAL)

    def _means(self, limit: Limit) -> dict[str, float]:
        return {what: share for (mean, what), share in self.root_mean_squares.items() if mean == limit}

    @property
    def position_error(self) -> Any:
        """Position error of the load over time. [m], [rad]"""
        position = self.drive.axis.columns[0]
        return np.abs(self.columns[position] - self.columns.get(f"wanted_{position}", self.columns[position]))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is doubtful in the motion's file, and resonances that the sampled controllers can excite, or that make them
        slower; see `analysis.sampled_springs`."""
        read = getattr(self.scenario.path, "warnings", ())
        return (*read, *sampled_springs.warnings(self.drive, self.scenario))

    @property
    def _settling_time(self) -> float | None:
        return self.scenario.settling_time

    def _achieved(self) -> Iterator[str]:
        if self.scenario.link == "controlled" and self.scenario.steering == "controlled":
            axis = self.drive.axis
            yield error_words(axis.position, axis.rotary, self.largest_error, float(self.position_error[-1]))

    def _spent(self) -> Iterator[str]:
        settled = f", {plain(self._from_supply(self._settled))} J of it after settling"
        yield f"{plain(self._from_supply())} J from the supply{'' if self._settling_time is None else settled}"

    def _doubts(self) -> tuple[str, ...]:
        return self.warnings

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON: final energies, events, verdict."""
        run = self.trajectory
        return {
            "drive": self.title,
            "scenario": self.scenario.title,
            **self._judgement(),
            **({"warnings": list(self.warnings)} if self.warnings else {}),
            f"largest_position_error_{self.drive.axis.position_unit}": self.largest_error,
            "rms_current_over_continuous": self.heating,
            "rms_gear_torque_over_continuous": self._means(Limit.GEAR),
            "duration_s": float(run.time[-1]),
            "settling_time_s": self.scenario.settling_time,
            "supplied_after_settling_J": self._from_supply(self._settled),
            **self._balance(),
            "elements_J": {
                element.name: {what: float(values[-1]) for what, values in run.energy(element.name)._asdict().items()}
                for element in run.graph.elements
            },
            "events": self._log(),
        }


@overload
def simulate(
    drive: Drive, scenario: Scenario, *, title: str = "", progress: Callable[[float], None] | None = None
) -> Simulation: ...


@overload
def simulate(
    drive: Machine,
    scenario: MachinePath | MachineTask,
    *,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> MachineRun: ...


def simulate(
    drive: Any,
    scenario: Scenario | MachinePath | MachineTask,
    *,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> Simulation | MachineRun:
    """Simulate a drive under a scenario, or a machine on a path or in a task.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive   Must have the inertias that motion requires. Or a PlatformDrive,
        ArmDrive or SphereDrive.
    scenario : Scenario                         For a machine a MachinePath or MachineTask; see `machine_study`.
    title : str                                 Name for reports.
    progress : callable                         Called with the share done.

    Returns
    -------
    Simulation or MachineRun   An exceeded limit is an event, not an error. If the solver fails, the run ends early and
        states the reason.

    Raises
    ------
    ParameterError
        If the drive lacks a value that motion requires, a machine cannot be simulated or leaves its reach, the scenario
        requires a part that the drive lacks (a steered wheel), the load of one moves along a line and that of the other about
        a joint, or the tolerance is too large for the energy balance to close.
    AuditError
        If the energy balance does not close at the default tolerance: an error in the program.

    Source: faulring2006, section V, Fig 10 and Fig 14.
    """
    if isinstance(scenario, (MachinePath, MachineTask)):
        return machine_study.simulated(drive, scenario, title=title, progress=progress)
    refuse_machine(drive, "a scenario")
    check_drive(drive, "drive")
    check_scenario(scenario)
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        raise ParameterError(f"a drive of type {type(drive).__name__} has no bond graph")
    if scenario.states_axis and (fault := axis_fault(drive, scenario.axis, "the drive", "the scenario")):
        raise ParameterError(fault)
    loop = closed_loop(drive, scenario)
    try:
        run = _run(loop, scenario, progress, functools.partial(_watched, drive, scenario))
    except ClosureError as problem:
        if scenario.tolerance <= RTOL:
            raise
        raise ParameterError(f"tolerance must be smaller than {scenario.tolerance:g}: {problem}") from problem
    columns = _columns(drive, scenario, run)
    settled = run_limits.first_settled(run.time, scenario.settling_time)
    utilisation = demands_at(drive, run.instants)
    for limit, what in [key for key in utilisation if key[0] == Limit.LIFE]:
        # The rated life limits the cubic mean over the whole run.
        lasting = np.cbrt(run_limits.lasting(run.time, run.cubes[limit, what], settled))
        utilisation[limit, what] = np.where(np.arange(len(run.time)) < settled, 0.0, lasting)
    peaks = {key: peak for key, peak in run.peaks.items() if key in utilisation and key[0] != Limit.LIFE}
    return Simulation(
        drive=drive,
        scenario=scenario,
        title=title,
        trajectory=run,
        columns=columns,
        events=run_limits.events(run.time, utilisation, settled, peaks),
        root_mean_squares=FrozenDict(run_limits.root_mean_squares(run.time, utilisation, settled, run.squares)),
        largest_error=float(max(np.max(run.peaks.get(_ERROR, 0.0)), _error(drive, scenario, run.instants).max())),
    )


def _run(loop: ClosedLoop, scenario: Scenario, progress: Callable[[float], None] | None, watch: Watch) -> Trajectory:
    step = scenario.output_step or scenario.duration / STEPS
    count = max(round(scenario.duration / step), 1)
    return solve(
        loop.graph,
        np.linspace(0.0, scenario.duration, count + 1),
        inputs=loop.inputs,
        initial=loop.initial,
        controller=loop.controller,
        method=scenario.method,
        rtol=scenario.tolerance,
        # The current loops settle within a fraction of a sample.
        energies_as_states=scenario.electrical == "voltage",
        progress=progress,
        watch=watch,
    )


def _watched(drive: CoboticDrive | ConventionalDrive, scenario: Scenario, at: Instants) -> dict[Demand | str, Any]:
    """What is judged at each instant, however far apart the outputs are."""
    return {**demands_at(drive, at), _ERROR: _error(drive, scenario, at)}


def _error(drive: CoboticDrive | ConventionalDrive, scenario: Scenario, at: Instants) -> Any:
    """Position error of the load. [m], [rad]"""
    position = _load_columns(at, drive.output, drive.axis)[drive.axis.columns[0]]
    if scenario.link == "free":
        return 0.0 * position
    return np.abs(position - states_over(scenario.path, at.time)[:, 0])


def _columns(drive: CoboticDrive | ConventionalDrive, scenario: Scenario, run: Trajectory) -> dict[str, Any]:
    cobotic = isinstance(drive, CoboticDrive)
    prefix = "cylinder." if cobotic else ""
    voltage, current = run.at(f"{prefix}source")
    prescribed = states_over(scenario.path, run.time)[:, 0]
    position, _, force = drive.axis.columns
    columns = {
        "time_s": run.time,
        **_load_columns(run, drive.output, drive.axis),
        **({f"wanted_{position}": prescribed} if scenario.link != "free" else {}),
        force: run.at("motion" if scenario.link == "imposed" else "force")[0],
        "motor_current_A": current,
        "motor_voltage_V": voltage,
        **_output_columns(run, drive.output, drive.axis),
    }
    supplied = [np.asarray(run.power(f"{prefix}source"))]
    if cobotic:
        steering_voltage, steering_current = run.at("steering.source")
        columns |= {
            "steering_angle_rad": run.signals["phi"],
            "cylinder_speed_rad_s": run.signals["omega"],
            "steering_current_A": steering_current,
            "steering_voltage_V": steering_voltage,
            "slip_ratio": _slip_ratio(drive, run.instants),
        }
        supplied.append(run.power("steering.source"))
    amplifiers = [drive.amplifier, *([drive.steering_amplifier] if cobotic else [])]
    columns["supply_power_W"] = sum(
        amplifier.supply(power)[0] for amplifier, power in zip(amplifiers, supplied, strict=True)
    )
    return columns


def demands_at(drive: CoboticDrive | ConventionalDrive, run: Instants) -> dict[Demand, Any]:
    """Demand over allowance of every limit at instants; of the rated life that of each instant."""
    found: dict[Demand, Any] = {}

    def motor(part: Motor, what: str, prefix: str) -> None:
        voltage, current = run.at(f"{prefix}source")
        speed = run.at(f"{prefix}motor")[0] / part.torque_constant
        _, _, returned = drive.amplifier.supply(voltage * current)
        demands = {**part.utilisation(current=current, voltage=voltage, speed=speed), **returned}
        found.update({(limit, what): demand for limit, demand in demands.items()})

    cobotic = isinstance(drive, CoboticDrive)
    prefix = "cylinder." if cobotic else ""
    if cobotic:
        # The larger demand of force and creepage; in slip only the creepage grows.
        found[Limit.SLIP, "wheel"] = np.maximum(_creep_demand(drive, run), np.abs(_slip_ratio(drive, run)))
        if drive.transmission.steering_range < 0.5 * math.pi:
            found[Limit.STEERING, "wheel"] = np.abs(run.signals["phi"]) / drive.transmission.steering_range
        assert drive.steering is not None
        motor(drive.steering.motor, "steering motor", "steering.")
    motor(drive.motor, "motor", prefix)
    (out,) = (bond for bond in run.graph.bonds_of(f"{prefix}gear") if bond.tail == f"{prefix}gear")
    output_speed = run.at(f"{prefix}motor")[0] / drive.motor.torque_constant / drive.gearhead.ratio
    for limit, demand in drive.gearhead.utilisation(run.efforts[out.tail, out.head], output_speed).items():
        found[limit, "gearhead"] = demand
    if not cobotic:
        found.update(_stage_utilisation(drive, run))
    return {**found, **_output_demands(run, drive.output)}


def _slip_ratio(drive: CoboticDrive, run: Instants) -> Any:
    """Lateral force over the slip force, over time."""
    return run.at("transmission.creep")[0] / drive.transmission.groups(drive.cylinder_speed).slip_force


def _creep_demand(drive: CoboticDrive, run: Instants) -> Any:
    """Creepage over that of full slip, over time."""
    parameters = {symbol: parameter.value for symbol, parameter in run.graph.parameters.items()}
    groups = drive.transmission.groups(drive.cylinder_speed)
    contact = {
        "slip_force": parameters[r"\mu P"],
        "creep_stiffness": parameters["C"] / groups.compliance(np.sin(run.signals["phi"]) ** 2)[0],
        "stick_speed": parameters[r"v_{\varepsilon}"],
    }
    u, v, full = run.at("transmission.creep")[1], run.signals["v"], parameters[r"\xi_s"]
    if drive.transmission.turns_with_spin:
        contact |= {"lever": turning.TurningPatch.of(drive.transmission, groups).lever, "slip_creepage": full}
        return turning.slip_demand(u, run.signals["phi_rate"], v, **contact)
    return np.abs(creepage.scaled_creepage(u, v, **contact)) / full


def _stage_utilisation(drive: ConventionalDrive, run: Instants) -> dict[Demand, Any]:
    """Demand over allowance of the output stage, over time."""
    stage, inner = drive.stage, (*JUNCTIONS, *TWO_PORTS)
    last = stage.title if stage.axis.rotary else f"r_{stage.title}"
    (out,) = (b for b in run.graph.bonds_of(last) if b.tail == last and run.graph[b.head].kind in inner)
    found = stage.utilisation(force=run.efforts[out.tail, out.head], speed=run.signals["ldot"])
    return {(limit, stage.title): demand for limit, demand in found.items()}


def _load_columns(run: Trajectory | Instants, output: Output, axis: Axis) -> dict[str, Any]:
    """Position and speed of the load, under their names along a line or about a joint."""
    position, speed, _ = axis.columns
    of = ("load", "load_rate") if output.chain else ("l", "ldot")
    return {position: run.signals[of[0]], speed: run.signals[of[1]]}


def _output_columns(run: Trajectory, output: Output, axis: Axis) -> dict[str, Any]:
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


def _output_demands(run: Trajectory | Instants, output: Output) -> dict[Demand, Any]:
    """Travel of springs and range of the linkage over their allowance, over time."""
    found: dict[Demand, Any] = {}
    for place in output.chain:
        part = place.part
        if isinstance(part, Linkage):
            angle = run.signals["joint" if "joint" in run.signals else "load"]
            found[Limit.LINKAGE, place.name] = np.asarray(part.demand(angle))
            continue
        demands = []
        if part.limited:
            demands.append(part.demand(_deflection(run, place)))
        if part.shape == "one-sided" and place.kind == "series":
            demands.append(part.pull_demand(run.at(names(place).elastic)[0]))
        if demands:
            found[Limit.SPRING, place.name] = functools.reduce(np.maximum, demands)
    return found


def _deflection(run: Trajectory | Instants, place: Place) -> Any:
    """Deflection of a spring; the state of a linear one is its deflection from the free state, if it has one."""
    assert not isinstance(place.part, Linkage)
    name = names(place).elastic
    return place.part.deflection(run.at(name)[0]) if place.part.shape == "linear" else run.states[name]
