"""A drive set up for a scenario: its graph, inputs, initial states and one_axis."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

from infinivar._core.fields import given
from infinivar.bondgraph.causality import assign
from infinivar.bondgraph.graph import BondGraph
from infinivar.bondgraph.inputs import Input
from infinivar.bondgraph.tape import Number
from infinivar.contact.friction import STICK_SPEED
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.control import CoboticControl, ConventionalControl, one_axis
from infinivar.drivetrain.control.loops import Servo, largest_current, speed_loop
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import check_graph
from infinivar.drivetrain.graphs import bandwidths, compliances, output_start, planned, plants, stages
from infinivar.drivetrain.graphs.planned import Planned
from infinivar.drivetrain.output import Output
from infinivar.errors import ParameterError
from infinivar.motion.forces import ConstantForce
from infinivar.motion.motion import Motion
from infinivar.motion.scenario import Scenario
from infinivar.parts.gear_law import GearLaw

_MOST_SAMPLES = 1e7
"""Most controller samples in a run; more would take hours."""

_HEAVY = 1e6
"""Load that friction cannot hold. [N]"""

_CRAWL = 1e-9
"""Speed at which viscous friction is negligible. [m s^-1]"""

_SLIGHT = 1e-6
"""Torque over which slopes are taken, relative to the continuous torque. [-]"""

_TRUSTED = 0.99
"""Fraction of the friction at rest that a controller relies on; with all of it the load would begin to slide."""


@dataclass(frozen=True, slots=True)
class ClosedLoop:
    """A graph with its external inputs, initial states and controller."""

    graph: BondGraph
    inputs: Mapping[str, float | Input]
    initial: Mapping[str, float]
    controller: Any


@dataclass(frozen=True, slots=True)
class _Speed:
    """The speed of a motion, as an input."""

    path: Motion

    @property
    def breaks(self) -> Any:
        return self.path.breaks

    def value(self, time: float) -> float:
        return self.path.at(time).speed

    def rate(self, time: float) -> float:
        return self.path.at(time).acceleration


def closed_loop(drive: CoboticDrive | ConventionalDrive, scenario: Scenario) -> ClosedLoop:
    """A drive set up for a scenario.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive   With the inertias that motion requires.
    scenario : Scenario

    Returns
    -------
    Machine   A running cylinder starts at its speed, with the current that maintains it; a controlled link starts with the
        position and speed of its motion.

    Raises
    ------
    ParameterError
        If a value that motion requires is missing, or the scenario requires a part that the drive lacks (a steered wheel).
    """
    check_graph(drive)
    if scenario.duration * drive.control.sample_rate > _MOST_SAMPLES:
        longest = _MOST_SAMPLES / drive.control.sample_rate
        raise ParameterError(
            f"duration must be <= {longest:g} s at this drive's one_axis.sample_rate, got {scenario.duration:g}"
        )
    output_start.check(drive.output, scenario)
    return _cobotic(drive, scenario) if isinstance(drive, CoboticDrive) else _conventional(drive, scenario)


def scenario_graph(drive: CoboticDrive | ConventionalDrive, scenario: Scenario) -> BondGraph:
    """The graph of a drive with the load, the amplifier and the stick speed of a scenario."""
    graph = plants.cobotic_graph if isinstance(drive, CoboticDrive) else plants.conventional_graph
    return graph(
        drive,  # type: ignore[arg-type]
        load_mass=scenario.moved_mass or None,
        electrical=scenario.electrical,
        imposed_motion=scenario.link == "imposed",
        stick_speed=_stick_speed(drive, scenario),
    )


def _stick_speed(drive: CoboticDrive | ConventionalDrive, scenario: Scenario) -> float:
    usual = STICK_SPEED if isinstance(drive, CoboticDrive) else plants.CONVENTIONAL_STICK_SPEED
    return given(scenario.stick_speed, usual)


def _path(drive: CoboticDrive | ConventionalDrive, scenario: Scenario, follows: bool) -> Motion:
    """Motion of the drive: that of the load, or what it asks for behind springs, a linkage and a stage that stretches."""
    stretch = _stretch(drive, scenario) if follows else None
    if not drive.output.chain and stretch is None:
        return scenario.path
    return planned.planned(
        drive.output,
        scenario.path,
        scenario.force,
        duration=scenario.duration,
        sample_time=1.0 / drive.control.sample_rate,
        mass=scenario.moved_mass,
        follows=follows,
        stretch=stretch,
    )


def _stretch(drive: CoboticDrive | ConventionalDrive, scenario: Scenario) -> planned.Stretch | None:
    """Stretch of the stage under load and guideway, which reverses as fast as the position loop follows."""
    if not isinstance(drive, ConventionalDrive) or drive.stage.stiffness is None:
        return None
    follows = bandwidths.of(drive, scenario.path.at(0.0).position, scenario.moved_mass).link
    lag = 1.0 / (2.0 * math.pi * follows)
    return planned.Stretch(float(drive.stage.stiffness), float(drive.guideway.friction_force()), lag)


_Driven = TypeVar("_Driven", CoboticDrive, ConventionalDrive)


def _bare(drive: _Driven) -> _Driven:
    """The drive without springs and linkage between it and its load."""
    return replace(drive, output=Output()) if drive.output.chain else drive


def _load_inputs(scenario: Scenario) -> dict[str, float | Input]:
    if scenario.link == "imposed":
        return {"motion": _Speed(scenario.path)}
    force = scenario.force
    return {"force": force.magnitude if isinstance(force, ConstantForce) else force or 0.0}


def _cobotic(drive: CoboticDrive, scenario: Scenario) -> ClosedLoop:
    stick_speed = _stick_speed(drive, scenario)
    turning = drive.gearhead.ratio**2 * _motor_inertia(drive)
    stages.check_gear_jamming(drive.gearhead, turning, drive.inertia_of_cylinder or 0.0, "cylinder_inertia")
    graph = scenario_graph(drive, scenario)
    held = _held_angle(scenario)
    path = _path(drive, scenario, held is None and scenario.link == "controlled")
    running = scenario.cylinder == "running" and drive.cylinder_speed != 0.0
    idle = float(_bare(drive).operate(speed=0.0, force=0.0).states["motor_current_A"]) if running else 0.0
    return ClosedLoop(
        graph,
        _load_inputs(scenario),
        _cobotic_start(drive, scenario, path, graph, held, running, idle),
        _cobotic_controller(drive, scenario, path, stick_speed, held, idle),
    )


def _held_angle(scenario: Scenario) -> float | None:
    """Steering angle that the scenario prescribes; None if the wheel is steered to follow the motion. [rad]"""
    if scenario.steering == "controlled":
        if scenario.link == "free":
            raise ParameterError(
                "steering = 'controlled' has no motion to follow with link = 'free'; use locked, decoupled or held"
            )
        return None
    return {"locked": 0.0, "decoupled": 0.5 * math.pi, "held": scenario.steering_angle}[scenario.steering]


def _cobotic_start(
    drive: CoboticDrive,
    scenario: Scenario,
    path: Motion,
    graph: BondGraph,
    held: float | None,
    running: bool,
    idle: float,
) -> dict[str, float]:
    """Initial states: a cylinder that runs is at speed, and a link that follows moves as its motion begins."""
    begin = path.at(0.0)
    imposed, follow = scenario.link == "imposed", held is None
    full_speed = drive.transmission.cylinder_radius * drive.cylinder_speed
    initial = {
        "cylinder.J_c": drive.cylinder_speed if running else 0.0,
        "phi": -math.atan(begin.speed / full_speed) if held is None else held,
        "l": begin.position if follow or imposed else 0.0,
    }
    if isinstance(path, Planned):
        speed = begin.speed if running and follow else 0.0
        load = scenario.path.at(0.0)._replace(**({} if running and follow else {"speed": 0.0}))
        initial["l"] = begin.position
        initial |= output_start.states(drive.output, graph, load, path.load_force)
        initial |= {"link.m_l": speed} if "link.m_l" in assign(graph).independent else {}
    elif not imposed:
        link = next(e.name for e in graph.elements if e.name in ("load_mass", "link.m_l"))
        initial[link] = begin.speed if running and follow else 0.0
    if scenario.electrical == "voltage":
        initial["cylinder.L"] = idle
    return initial


def _cobotic_controller(
    drive: CoboticDrive, scenario: Scenario, path: Motion, stick_speed: float, held: float | None, idle: float
) -> one_axis.CoboticController:
    settings, steering, gear, motor = drive.control, drive.steering, drive.gearhead.ratio, drive.motor
    assert steering is not None  # or there were no graph
    return one_axis.CoboticController(
        sample_time=1.0 / settings.sample_rate,
        cylinder=speed_loop(
            settings.cylinder_bandwidth,
            (drive.inertia_of_cylinder or 0.0) + gear**2 * _motor_inertia(drive),
            gear * motor.torque_constant,
            largest_current(settings.current_limit, motor),
        ),
        steering=Servo.place(
            settings.steering_bandwidth,
            steering.inertia_of_bell + steering.ratio**2 * (steering.motor.rotor_inertia or 0.0),
            steering.ratio * steering.motor.torque_constant,
            largest_current(settings.steering_current_limit, steering.motor),
            float(steering.coulomb_torque(drive.transmission)) + steering.ratio * steering.motor.friction_torque,
            stick_speed / drive.transmission.wheel_radius,
        ),
        link_gain=2.0 * math.pi * settings.link_bandwidth,
        surface_radius=drive.transmission.cylinder_radius,
        cylinder_speed=0.0 if scenario.cylinder == "at rest" else drive.cylinder_speed,
        run_up_time=scenario.run_up_time or 0.0,
        largest_angle=drive.transmission.steering_range,
        held_angle=held,
        path=path,
        standstill=_standstill(settings, stick_speed, 0.1),  # what is left of it goes on all the time
        started={"cylinder": idle},
        outputs=("I_c", "I_s") if scenario.electrical == "voltage" else ("cylinder.source", "steering.source"),
    )


def _conventional(drive: ConventionalDrive, scenario: Scenario) -> ClosedLoop:
    for field, value, usual in (
        ("steering", scenario.steering, "controlled"),
        ("cylinder", scenario.cylinder, "running"),
    ):
        if value != usual:
            raise ParameterError(f"{field} = {value!r} requires a cobotic drive; this drive is conventional")
    stick_speed = _stick_speed(drive, scenario)
    carried = output_start.carried(drive.output, scenario.path.at(0.0).position, scenario.moved_mass)
    stages.check_jamming(drive, carried, scenario.link == "imposed")
    graph = scenario_graph(drive, scenario)
    path = _path(drive, scenario, scenario.link == "controlled")
    return ClosedLoop(
        graph,
        _load_inputs(scenario),
        _conventional_start(drive, scenario, path, graph),
        _conventional_controller(drive, scenario, path, stick_speed),
    )


def _conventional_start(
    drive: ConventionalDrive, scenario: Scenario, path: Motion, graph: BondGraph
) -> dict[str, float]:
    """Initial states: a link that is followed moves as its motion begins, and compliances carry its force."""
    follow, begin = scenario.link != "free", path.at(0.0)
    ratio, radius = drive.gearhead.ratio, _travel(drive)
    scales = {"load_mass": 1.0, "J_gpc": 1.0 / radius, "J_m": ratio / radius, "J_g": ratio / radius}
    moving = [name for name in assign(graph).independent if name in scales]
    initial = {name: begin.speed * scales[name] if follow else 0.0 for name in moving}
    force = inertial = 0.0
    if follow:
        force = scenario.moved_mass * begin.acceleration - _outer_force(scenario)
        inertial = drive.gear_output_inertia * begin.acceleration / radius
    position = begin.position if follow else 0.0
    if isinstance(path, Planned):
        force, position = path.force(0.0), begin.position - path.stretch
        initial |= output_start.states(drive.output, graph, scenario.path.at(0.0), path.load_force)
    stretched = {f"{drive.stage.title}_spring": path.stretch} if isinstance(path, Planned) and path.stretch else {}
    return {"l": position, **initial, **compliances.at_rest(drive, force, inertial), **stretched}


def _outer_force(scenario: Scenario) -> float:
    """External force on the load at the start. [N]"""
    return 0.0 if scenario.force is None else scenario.force.value(0.0)


def _conventional_controller(
    drive: ConventionalDrive, scenario: Scenario, path: Motion, stick_speed: float
) -> one_axis.ConventionalController:
    settings, motor, ratio, radius = drive.control, drive.motor, drive.gearhead.ratio, _travel(drive)
    inertia, carried = drive.gear_output_inertia / radius**2, scenario.moved_mass
    if isinstance(path, Planned):  # the planned force includes the load's inertia
        carried = output_start.carried(drive.output, scenario.path.at(0.0).position, carried)
    else:
        inertia, carried = carried + inertia, 0.0
    rotor = (ratio / radius) ** 2 * _motor_inertia(drive)
    gain = motor.torque_constant * ratio / radius
    bandwidth = bandwidths.of(
        drive, scenario.path.at(0.0).position, scenario.moved_mass, imposed=scenario.link == "imposed"
    )
    gear = _gear_friction(_with_factors_alone(drive), gain)
    # Sampled controllers cannot resolve lower speeds, regardless of the stick speed.
    hardly = max(stick_speed, STICK_SPEED)
    return one_axis.ConventionalController(
        sample_time=1.0 / settings.sample_rate,
        speed=speed_loop(
            bandwidth.speed, inertia + carried + rotor, gain, largest_current(settings.current_limit, motor)
        ),
        link_gain=2.0 * math.pi * bandwidth.link,
        inertia=inertia / gain,
        rotor=rotor / gain,
        friction=gear.friction,
        motor_friction=gear.motor_friction,
        driving=gear.driving,
        driven=gear.driven,
        gear_friction=_friction_by_speed(drive),
        full_speed=hardly,
        path=path if scenario.link != "free" else None,
        planned=functools.partial(_planned_current, path, gain) if isinstance(path, Planned) else None,
        standstill=_standstill(settings, hardly, 0.5),
        holding=functools.partial(_holding, drive),
        encoder=_encoder(drive, scenario, path),
        # A gear that locks hardly shows which way its load acts.
        started=0.0 if drive.gearhead.law().factored or isinstance(path, Planned) else -_outer_force(scenario) / gain,
        outputs=("I_n",) if scenario.electrical == "voltage" else ("source",),
    )


def _encoder(drive: ConventionalDrive, scenario: Scenario, path: Motion) -> one_axis.Encoder:
    """What the controller measures: the load, or the motor where something between them gives way."""
    if drive.gearhead.stiffness is None and drive.stage.stiffness is None:
        return one_axis.Encoder()
    begin = path.at(0.0).position if scenario.link != "free" or isinstance(path, Planned) else 0.0
    return one_axis.Encoder("motor_angle", "motor_speed", _travel(drive) / drive.gearhead.ratio, begin)


class _GearFriction(NamedTuple):
    """Motor current per current that the load asks for, in either direction; currents that friction takes. [-], [A]"""

    driving: float
    driven: float
    friction: float
    motor_friction: float


def _gear_friction(drive: ConventionalDrive, gain: float) -> _GearFriction:
    """Friction on either side of the gear, from currents while the load is moved and while it moves the motor."""
    driving, driven = _passed(drive)
    bare = _bare(drive)
    # So slow that nothing but friction takes current.
    raised = float(bare.operate(speed=_CRAWL, force=0.0).states["motor_current_A"])
    lowered = driven * _HEAVY / gain - float(bare.operate(speed=-_CRAWL, force=_HEAVY).states["motor_current_A"])
    # What the gear passes on differently in the two directions lies behind it.
    friction = (raised - lowered) / (driving - driven) if driving != driven else 0.0
    return _GearFriction(driving, driven, friction, raised - driving * friction)


def _with_factors_alone(drive: ConventionalDrive) -> ConventionalDrive:
    """The drive without friction of its gearhead, unless that is a constant and a factor per load."""
    gear = drive.gearhead
    return drive if gear.law().factored else replace(drive, gearhead=gear.without_friction())


def _friction_by_speed(drive: ConventionalDrive) -> Callable[[Number, Number], tuple[Number, Number]]:
    """What friction of the gearhead takes that factors do not express; see `ConventionalController.gear_friction`."""
    law = drive.gearhead.law(drive.motor.continuous_torque)
    if law.factored:
        return _no_friction
    least = _SLIGHT * drive.motor.continuous_torque
    return functools.partial(_friction_current, law, drive.motor.torque_constant, _travel(drive), least)


def _friction_current(
    law: GearLaw, torque_constant: float, travel: float, step: float, current: Number, speed: Number
) -> tuple[Number, Number]:
    torque, turning = current * torque_constant, speed / travel * float(law.ratio)
    lost, more = (law.size(turning, one) for one in (torque, torque + step))
    return lost / torque_constant, (more - lost) / step


def _passed(drive: ConventionalDrive) -> tuple[float, float]:
    """Motor torque per torque of the load, over that without load-dependent friction: driving, and driven by the load."""
    gear, stage = drive.gearhead, drive.stage.efficiencies
    forward, backward = (1.0, 1.0) if stage is None else map(float, stage)
    law = gear.law()
    driving, returned = law.load_factors if law.factored else (1.0, 1.0)
    # The motor drives a self-locking stage through the gear in both directions.
    return driving / forward, backward * (returned if backward >= 0.0 else driving)


def _travel(drive: ConventionalDrive) -> float:
    """Travel of the load per angle of the gear's output. [m/rad]"""
    return float(drive.stage.travel_per_radian)


def _motor_inertia(drive: CoboticDrive | ConventionalDrive) -> float:
    """Of rotor and gearhead, at the motor shaft; 0 where not stated. [kg m^2]"""
    return (drive.motor.rotor_inertia or 0.0) + (drive.gearhead.inertia or 0.0)


def _standstill(settings: CoboticControl | ConventionalControl, stick_speed: float, slow: float) -> one_axis.Standstill:
    return one_axis.Standstill(
        error=settings.rest_error,
        slow=slow * stick_speed,
        sliding=stick_speed,
        starting=stick_speed * settings.sample_rate,
    )


def _holding(drive: ConventionalDrive, current: Number) -> Number:
    """Holding current with the help of friction, given the holding current without it. [A]"""
    motor = drive.motor
    force = current * motor.torque_constant * drive.gearhead.ratio / _travel(drive)
    helped = _bare(drive).operate(speed=0.0, force=force).states["motor_current_A"]
    return current + _TRUSTED * (helped - current)


def _planned_current(path: Planned, gain: float, time: float) -> float:
    """Current for the planned force at the drive's side of its output. [A]"""
    return path.force(time) / gain


def _no_friction(current: Number, speed: Number) -> tuple[float, float]:
    return 0.0, 0.0
