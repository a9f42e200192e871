"""Simulate a machine of many contacts under a scenario, with sampled controllers, limits as events, and an energy balance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from infinivar._core.collocation import Collocation, Step, StuckError
from infinivar._core.fields import given
from infinivar.analysis import run_limits
from infinivar.analysis.machine_run import MachineRun, first_settled
from infinivar.analysis.run_limits import Event
from infinivar.bondgraph.audit import CLOSURE, ClosureError
from infinivar.drivetrain.moving import control
from infinivar.drivetrain.moving.legged import LeggedMechanics
from infinivar.drivetrain.moving.machines import (
    MACHINES,
    Machine,
    PlanarMachine,
    SeparateMachine,
    SerialArmMachine,
    SphereMachine,
)
from infinivar.drivetrain.moving.separate import LinkController, SeparateMechanics
from infinivar.drivetrain.moving.system import Inputs, System
from infinivar.errors import ParameterError, require
from infinivar.limits import Demand, Limit
from infinivar.motion.histories import VectorHistory
from infinivar.motion.machine_scenario import MachineScenario, check_continuous, over_time

_RESULTS = 1000
"""Default number of results of a run."""

_NEARLY = 0.99
"""Reach of a rod over its length, beyond which a run that stops has reached the end of it."""

_HALVINGS = 40
"""Of the step in which a demand passes its allowance."""


def simulate_machine(
    machine: Machine,
    scenario: MachineScenario,
    *,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> MachineRun:
    """Simulate a machine of many contacts under a scenario.

    Parameters
    ----------
    machine : PlatformMachine, ArmMachine, SerialArmMachine, PlanarMachine or SphereMachine
    scenario : MachineScenario
    title : str             Name for reports.
    progress : callable     Called with the share done.

    Returns
    -------
    MachineRun   An exceeded limit is an event, not an error. If a rod leaves its reach or the integration fails, the run ends
        early and states the reason.

    Raises
    ------
    ParameterError
        If the machine lacks a value that the scenario requires, or a number of values does not fit.
        Angles prescribed without servos have a step.
    ClosureError
        If the energy balance does not close: an error in the program.

    Source: faulring2006, section V, for plants and controllers; `infinivar.transmission.mechanism` for the contacts.
    """
    if not isinstance(machine, MACHINES):
        names = ", ".join(kind.__name__ for kind in MACHINES)
        raise ParameterError(f"machine must be one of {names}, got {machine!r}")
    if not isinstance(scenario, MachineScenario):
        raise ParameterError(f"scenario must be a MachineScenario, got {scenario!r}")
    return _Run(machine, scenario).over(title, progress or (lambda share: None))


@dataclass(slots=True)
class _Log:
    """What a run leaves behind at its results, and at its steps."""

    states: list[np.ndarray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    energies: list[np.ndarray] = field(default_factory=list)
    inputs: list[Inputs] = field(default_factory=list)
    instants: list[float] = field(default_factory=list)
    demands: list[np.ndarray] = field(default_factory=list)
    sampled: list[tuple[float, dict[str, float]]] = field(default_factory=list)


class _Run:
    """A machine set up for a scenario."""

    def __init__(self, machine: Machine, scenario: MachineScenario) -> None:
        self.machine, self.scenario = machine, scenario
        self.mechanics = machine.mechanics(scenario.stick_speed)
        steers = len(self.mechanics.steered)
        self.angles = None
        if not isinstance(scenario.steering, str):
            self.angles = over_time("steering", scenario.steering, steers)
        elif scenario.steering == "locked":
            self.angles = lambda time: np.zeros(steers)
        elif not scenario.servos:
            raise ParameterError("steering = 'controlled' needs servos; leave servos true, or prescribe angles")
        self.wrenched = self._user_coordinates()
        wrench = None if scenario.wrench is None else over_time("wrench", scenario.wrench, self.wrenched)
        motor = None if scenario.source == "none" else machine.power_motor(scenario.stick_speed)
        moves_links = isinstance(machine, SeparateMachine)
        if moves_links and (scenario.source != "held" or scenario.steering != "controlled"):
            raise ParameterError(
                "source must be 'held', and steering 'controlled', for a machine with a motor for each link"
            )
        if scenario.source == "held" and motor is None and not isinstance(machine, (PlanarMachine, SeparateMachine)):
            raise ParameterError("source must be 'none' for a machine without a motor, got 'held'")
        self.system = System(
            mechanics=self.mechanics,
            motor=motor,
            links=machine.link_motors(scenario.stick_speed) if moves_links else None,
            servo=machine.servo(scenario.stick_speed) if scenario.servos else None,
            angles=None if scenario.servos else self.angles,
            wrench=wrench,
        )
        self.state = self._start()
        rate = machine.control.sample_rate if scenario.sample_rate is None else scenario.sample_rate
        self.sampled = self.system.links is not None or (
            scenario.servos or (motor is not None and scenario.source == "held")
        )
        self.period = 1.0 / rate
        self.controller = self._controller() if self.sampled else None

    def _user_coordinates(self) -> int:
        """Number of coordinates on which a user acts."""
        if isinstance(self.mechanics, LeggedMechanics):
            return len(self.mechanics.coordinates) - 1
        return min(len(self.mechanics.coordinates), max(len(self.mechanics.configuration), 2))

    def _start(self) -> np.ndarray:
        scenario, mechanics = self.scenario, self.mechanics
        pose, rates = self.machine.home, np.zeros(len(mechanics.coordinates))
        if scenario.motion is not None:
            count = len(mechanics.configuration)
            require(scenario.motion.count == count, "motion", f"{scenario.motion.count} values", f"{count} values")
            pose = scenario.motion(0.0)
            if isinstance(mechanics, (LeggedMechanics, SeparateMechanics)):
                pose, twist = control.pose_twist(mechanics.load, scenario.motion, 0.0)
                rates[: len(twist)] = twist
        if self.system.motor is not None and scenario.source == "held":
            rates[self.system.motor.coordinate] = self.machine.set_speed
            if self.angles is not None:
                rates = _rolling(self.machine, rates, np.asarray(self.angles(0.0), dtype=float))
        for name, usual in (("pose", pose), ("rates", rates)):
            value = getattr(scenario, name)
            if value is not None:
                require(len(value) == len(usual), name, f"{len(value)} values", f"{len(usual)} values")
        pose = pose if scenario.pose is None else np.array(scenario.pose)
        rates = rates if scenario.rates is None else np.array(scenario.rates)
        parts = [pose, rates]
        if self.system.servo is not None:
            parts += [self._first_angles(pose, rates), np.zeros(len(mechanics.steered))]
        state = np.concatenate(parts)
        found = self.system.rates(Inputs(steering=np.zeros(len(mechanics.steered))), np.zeros(1), state[None])
        if not np.all(np.isfinite(found.derivative)):
            raise ParameterError("pose must be within the reach of the machine at the start")
        return state

    def _first_angles(self, pose: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Angles of rolling at the start, or those prescribed."""
        if self.angles is not None:
            return np.asarray(self.angles(0.0), dtype=float)
        wanted = self._wanted()
        assert wanted is not None
        return wanted(0.0, pose, rates, np.zeros(len(self.mechanics.steered)))[0]

    def _wanted(self) -> control.Wanted | None:
        if self.angles is not None:
            return control.following_angles(self.angles)
        assert not isinstance(self.machine, SeparateMachine)
        settings, scenario, mechanics = self.machine.control, self.scenario, self.mechanics
        gain = 2.0 * math.pi * settings.link_bandwidth
        motion = scenario.motion
        if isinstance(mechanics, LeggedMechanics):
            if motion is None:
                pose = self.machine.home if scenario.pose is None else np.array(scenario.pose)
                motion = VectorHistory(time=[0.0, scenario.duration], values=[pose, pose])
            return control.following_pose(
                mechanics.load,
                motion,
                gain=gain,
                radius=mechanics.transmission.cylinder_radius,
                set_speed=self.machine.set_speed,
                largest=mechanics.transmission.steering_range,
            )
        if isinstance(self.machine, PlanarMachine):
            if motion is None:
                raise ParameterError("motion is missing: steering = 'controlled' follows it")
            return control.following_path(self.machine.cobot, motion, gain=gain)
        raise ParameterError(
            "steering must be 'locked' or angles over time for a sphere or a serial arm; only a platform, an arm on a common "
            "cylinder and a planar cobot follow a motion"
        )

    def _controller(self) -> control.MachineController:
        system, scenario = self.system, self.scenario
        first, second, _ = system.places
        if isinstance(self.machine, SeparateMachine):
            return self._of_links(np.array(self.state[:first]))
        settings, motor, idle = self.machine.control, None, 0.0
        if system.motor is not None and scenario.source == "held":
            place = self.mechanics.at(self.state[None, :first], self.state[None, first:second])
            column = system.motor.coordinate
            motor = control.placed_motor(system, settings, float(place.inertia[0, column, column]))
            # The current that keeps the speed at the start.
            rest = system.rates(Inputs(steering=np.zeros(len(self.mechanics.steered))), np.zeros(1), self.state[None])
            inertia = float(place.inertia[0, column, column]) + system.motor.inertia
            idle = -inertia * float(rest.derivative[0, first:second][column]) / system.motor.gain
        return control.MachineController(
            system=system,
            period=self.period,
            duration=scenario.duration,
            set_speed=self.machine.set_speed,
            motor=motor,
            servo=control.placed_servo(system, settings, 10.0 * system.servo.stick_speed if system.servo else 1.0),
            wanted=self._wanted() if system.servo is not None else None,
            integral=idle,
        )

    def _of_links(self, pose: np.ndarray) -> control.MachineController:
        """Controller of a motor on each link, which start with the currents that hold the user."""
        system, motion = self.system, self.scenario.motion
        assert system.links is not None
        assert isinstance(self.mechanics, SeparateMechanics)
        if motion is None:
            motion = VectorHistory(time=[0.0, self.scenario.duration], values=[pose, pose])
        links = LinkController(
            motors=system.links,
            mechanics=self.mechanics,
            motion=motion,
            integral=-system.user(np.zeros(1))[0],
        )
        return control.MachineController(
            system=system,
            period=self.period,
            duration=self.scenario.duration,
            set_speed=0.0,
            motor=None,
            servo=None,
            wanted=None,
            links=links,
        )

    def _scale(self) -> np.ndarray:
        """Size of each state."""
        first, second, third = self.system.places
        scale = np.full(len(self.state), 0.1)
        fastest = np.abs(self.state[first:second])
        scale[first:second] = np.maximum(0.1 * fastest, 1e-2)
        scale[third:] = 1.0
        return scale

    def over(self, title: str, progress: Callable[[float], None]) -> MachineRun:
        """The run."""
        scenario, system, log = self.scenario, self.system, _Log()
        inputs = Inputs(steering=np.zeros(len(self.mechanics.steered)))
        total = np.zeros(len(system.sources) + len(system.losses))
        state = self.state

        def rates(time: np.ndarray, states: np.ndarray) -> Any:
            return system.rates(inputs, time, states)

        marching = Collocation(rates, system.balance, self._scale(), scenario.tolerance)

        def accept(step: Step) -> None:
            total[:] += step.energy
            self._watch(log, step, rates)

        def keep(time: float) -> None:
            log.times.append(time)
            log.states.append(state)
            log.energies.append(total.copy())
            log.inputs.append(replace(inputs, steering=inputs.steering.copy()))

        outcome, ends, kept = "", *self._segments()
        if system.angles is not None:
            check_continuous("steering", system.angles, [0.0, *ends])
        begin = 0.0
        for place, end in enumerate(ends):
            if self.controller is not None:
                inputs = self.controller.sample(begin, state)
                log.sampled.append((begin, dict(self.controller.saturated)))
            if place == 0:
                keep(0.0)
            try:
                state = marching.over(begin, end, state, accept)
            except StuckError as problem:
                outcome = f"stopped at {float(problem.args[0]):.6g} s: {self._why(marching.last, state)}"
                break
            if place + 1 in kept:
                keep(end)
                progress(end / scenario.duration)
            begin = end
        return self._result(title, log, outcome)

    def _segments(self) -> tuple[np.ndarray, set[int]]:
        """Ends of the segments, and the numbers of those that are results."""
        duration = self.scenario.duration
        step = self.scenario.output_step or max(duration / _RESULTS, self.period if self.sampled else 0.0)
        if not self.sampled:
            count = max(round(duration / step), 1)
            return np.linspace(0.0, duration, count + 1)[1:], set(range(1, count + 1))
        whole = math.floor(duration / self.period * (1.0 + 1e-12))
        ends = self.period * np.arange(1, whole + 1)
        if not whole or duration - ends[-1] > 1e-9 * duration:
            ends = np.append(ends, duration)
        every = max(round(step / self.period), 1)
        return ends, {*range(every, len(ends) + 1, every), len(ends)}

    def _watch(self, log: _Log, step: Step, rates: Callable[..., Any]) -> None:
        """Keep the demands at the ends of a step, and at the instants at which one passes its allowance."""
        if not log.instants:
            log.instants.append(step.begin)
            log.demands.append(step.demand_before)
        crossed = (step.demand_before - 1.0) * (step.demand - 1.0) < 0.0
        found = []
        for place in np.flatnonzero(crossed):
            low, high, rises, demand = 0.0, 1.0, step.demand[place] > 1.0, step.demand
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                time = step.begin + middle * (step.end - step.begin)
                demand = rates(np.array([time]), step.at(middle)[None]).demand[0]
                low, high = (low, middle) if (demand[place] > 1.0) == rises else (middle, high)
            demand = np.where(np.arange(len(demand)) == place, 1.0, demand)
            found.append((step.begin + high * (step.end - step.begin), demand))
        for time, demand in sorted(found, key=lambda pair: pair[0]):
            if time > log.instants[-1]:
                log.instants.append(time)
                log.demands.append(demand)
        if step.end > log.instants[-1]:
            log.instants.append(step.end)
            log.demands.append(step.demand)

    def _why(self, last: Step | None, state: np.ndarray) -> str:
        if isinstance(self.mechanics, LeggedMechanics):
            first, second, _ = self.system.places
            at = (state if last is None else last.points[-1])[None]
            place = self.mechanics.load.at(at[:, :first], at[:, first : second - 1])
            if place.demand.size and not place.demand[0, 0] < _NEARLY:
                return "a rod is at the end of its reach"
        return "the integration fails; try a larger stick_speed"

    def _result(self, title: str, log: _Log, outcome: str) -> MachineRun:
        system, states, time = self.system, np.array(log.states), np.array(log.times)
        energies = np.array(log.energies)
        stored = system.energies(states)
        count = len(system.sources)
        supplied, lost = energies[:, :count], energies[:, count:]
        missing = stored.sum(-1) - stored[0].sum() + lost.sum(-1) - supplied.sum(-1)
        moved = np.max(np.abs(supplied).sum(-1) + np.abs(lost).sum(-1)) + np.max(stored.sum(-1))
        residual = np.abs(missing) / max(float(moved), 1e-300)
        if not np.max(residual) <= CLOSURE:
            raise ClosureError(
                f"the energy balance has a residual of {np.max(residual):.2g} of the energy moved, above the limit of {CLOSURE:g}"
            )
        kept = {name: column for name, column in zip(system.losses, lost.T, strict=True) if np.any(column)}
        columns = self._columns(time, states, log)
        settled = first_settled(time, self.scenario.settling_time)
        # Sub-steps in which a wheel slips count as well.
        utilisation: dict[Demand, Any] = dict(
            zip(self.mechanics.demands, np.array(log.demands).T if log.demands else np.zeros((0, 0)), strict=False)
        )
        instants = np.array(log.instants)
        early = first_settled(instants, self.scenario.settling_time)
        found = run_limits.events(instants, utilisation, early) if log.instants else ()
        others = self._motor_demands(columns)
        found = tuple(sorted((*found, *run_limits.events(time, others, settled), *self._saturation(log)), key=_start))
        slip = {f"slip_demand_{what.replace(' ', '_')}": place for place, (limit, what) in enumerate(self.mechanics.demands)
                if limit == Limit.SLIP}  # fmt: skip
        if log.instants:
            rows = np.searchsorted(log.instants, time - 1e-12).clip(max=len(log.instants) - 1)
            columns |= {name: np.array(log.demands)[rows, place] for name, place in slip.items()}
        return MachineRun(
            machine=self.machine,
            scenario=self.scenario,
            title=title,
            time=time,
            columns=columns,
            supplied=dict(zip(system.sources, supplied.T, strict=True)),
            lost=kept,
            stored=dict(zip(("machine", "motor", "steering"), stored.T, strict=True)),
            residual=residual,
            events=found,
            root_mean_squares=run_limits.root_mean_squares(time, others, settled),
            outcome=outcome,
        )

    def _columns(self, time: np.ndarray, states: np.ndarray, log: _Log) -> dict[str, np.ndarray]:
        system, mechanics = self.system, self.mechanics
        first, second, _ = system.places
        names = [*mechanics.configuration, *mechanics.coordinates]
        columns = {name: states[:, place] for place, name in enumerate(names)}
        angles, turning = system.steering(time, states)
        for place, name in enumerate(mechanics.steered):
            columns[name] = angles[:, place]
            columns[name.replace("_rad", "_rate_rad_s")] = (turning + 0.0 * angles)[:, place]
        pushed = system.user(time)
        columns |= {f"user_{place + 1}": pushed[:, place] for place in range(self.wrenched)}
        if system.motor is not None:
            current = np.array([one.current for one in log.inputs])
            shaft = system.motor.gearhead.ratio * states[:, first:second][:, system.motor.coordinate]
            columns["motor_current_A"] = current
            columns["motor_voltage_V"] = (
                system.motor.motor.resistance * current + system.motor.motor.torque_constant * shaft
            )
        if system.links is not None:
            currents = np.array([one.links for one in log.inputs])
            speeds = mechanics.at(states[:, :first], states[:, first:second]).kinematics.speed
            motor = system.links.drive.motor
            voltages = motor.resistance * currents + motor.torque_constant * system.links.ratio * speeds
            for place in range(currents.shape[1]):
                columns[f"motor_{place + 1}_current_A"] = currents[:, place]
                columns[f"motor_{place + 1}_voltage_V"] = voltages[:, place]
        if system.servo is not None:
            currents = np.array([one.steering for one in log.inputs])
            for place, name in enumerate(mechanics.steered):
                columns[name.replace("_rad", "_current_A")] = currents[:, place]
        return columns

    def _motor_demands(self, columns: Mapping[str, np.ndarray]) -> dict[Demand, Any]:
        """Demand over allowance of the motors at the results."""
        system, found = self.system, {}
        if system.motor is not None:
            motor = system.motor.motor
            current, voltage = columns["motor_current_A"], columns["motor_voltage_V"]
            speed = (voltage - motor.resistance * current) / motor.torque_constant
            for limit, demand in motor.utilisation(current=current, voltage=voltage, speed=speed).items():
                found[limit, "motor"] = demand
        if system.links is not None and isinstance(self.machine, SeparateMachine):
            motor = system.links.drive.motor
            for place in range(self.machine.links):
                current, voltage = (columns[f"motor_{place + 1}_{what}"] for what in ("current_A", "voltage_V"))
                speed = (voltage - motor.resistance * current) / motor.torque_constant
                for limit, demand in motor.utilisation(current=current, voltage=voltage, speed=speed).items():
                    found[limit, f"motor {place + 1}"] = demand
        if system.servo is not None:
            plant = system.servo.plant
            for name in self.mechanics.steered:
                current = columns[name.replace("_rad", "_current_A")]
                speed = plant.ratio * columns[name.replace("_rad", "_rate_rad_s")]
                voltage = plant.motor.resistance * current + plant.motor.torque_constant * speed
                part = f"steering motor {name.split('_')[1]}" if "_" in name else "steering motor"
                for limit, demand in plant.motor.utilisation(current=current, voltage=voltage, speed=speed).items():
                    found[limit, part] = demand
        return found

    def _saturation(self, log: _Log) -> tuple[Event, ...]:
        """Samples at which a controller's current is at its limit."""
        if not log.sampled:
            return ()
        found = []
        for part in log.sampled[-1][1]:
            limited = np.array([said.get(part, 0.0) >= 1.0 for _, said in log.sampled])
            edges = np.flatnonzero(np.diff(np.concatenate([[False], limited, [False]]).astype(int)))
            for begin, end in zip(edges[::2], edges[1::2], strict=True):
                begins = log.sampled[begin][0]
                ends = log.sampled[end][0] if end < len(log.sampled) else self.scenario.duration
                event = Event(limit=Limit.PEAK, what=f"current limit of {part}", start=begins, end=ends, worst=1.0)
                settling = given(self.scenario.settling_time, 0.0)
                if begins < settling < ends:
                    found.append(replace(event, end=settling, settling=True))
                    event = replace(event, start=settling)
                found.append(replace(event, settling=ends <= settling))
        return tuple(found)


def _rolling(machine: Machine, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Rates at which all contacts roll, from that of the motor's coordinate, where they determine all others."""
    if isinstance(machine, SphereMachine):
        return machine.ivt.rolling_rates(float(angles[0]), machine.set_speed)
    if isinstance(machine, SerialArmMachine):
        return machine.set_speed * np.cumprod([1.0, *(-np.tan(angles))])
    return rates


def _start(event: Event) -> float:
    return event.start
