"""Simulate a machine of many contacts under a scenario, with sampled controllers, limits as events, and an energy balance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.marching import March
from infinivar.errors import ParameterError, require
from infinivar.machines.compiled import compiled_motion
from infinivar.machines.control import loops as control
from infinivar.machines.control.loops import LinkController
from infinivar.machines.kind import MovingMachine
from infinivar.machines.motors import LinkMotors
from infinivar.machines.registry import MACHINES
from infinivar.machines.system import System
from infinivar.motion.machine_scenario import MachineScenario, over_time


def simulate_machine(
    machine: MovingMachine,
    scenario: MachineScenario,
    *,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> MachineRun:
    """Simulate a machine of many contacts under a scenario.

    Parameters
    ----------
    machine : PlatformMachine, ArmMachine, SerialArmMachine, PlanarMachine, SphereMachine, SlideMachine or GearedSlideMachine
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
    if not isinstance(machine, MovingMachine):
        names = ", ".join(MACHINES)
        raise ParameterError(f"machine must be one of {names}, got {machine!r}")
    if not isinstance(scenario, MachineScenario):
        raise ParameterError(f"scenario must be a MachineScenario, got {scenario!r}")
    return _Run(machine, scenario).over(title, progress or (lambda share: None))


class _Run:
    """A machine set up for a scenario."""

    def __init__(self, machine: MovingMachine, scenario: MachineScenario) -> None:
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
        self.wrenched = len(self.mechanics.configuration)
        wrench = None if scenario.wrench is None else over_time("wrench", scenario.wrench, self.wrenched)
        motor = None if scenario.source == "none" else machine.power_motor(scenario.stick_speed)
        links = machine.link_motors(scenario.stick_speed)
        if links is not None and (scenario.source != "held" or scenario.steering != "controlled"):
            raise ParameterError(
                "source must be 'held', and steering 'controlled', for a machine with a motor for each link"
            )
        if scenario.source == "held" and motor is None and links is None and not machine.pushed:
            raise ParameterError("source must be 'none' for a machine without a motor, got 'held'")
        self.system = System(
            mechanics=self.mechanics,
            motor=motor,
            links=links,
            servo=machine.servo(scenario.stick_speed) if scenario.servos else None,
            angles=None if scenario.servos or not steers else self.angles,
            wrench=wrench,
        )
        self.state = self._start()
        rate = machine.control.sample_rate if scenario.sample_rate is None else scenario.sample_rate
        self.sampled = self.system.links is not None or (
            scenario.servos or (motor is not None and scenario.source == "held")
        )
        self.period = 1.0 / rate
        self.controller = self._controller() if self.sampled else None

    def _start(self) -> np.ndarray:
        scenario, mechanics = self.scenario, self.mechanics
        pose, rates = self.machine.home, np.zeros(len(mechanics.coordinates))
        if scenario.motion is not None:
            count = len(mechanics.configuration)
            require(scenario.motion.count == count, "motion", f"{scenario.motion.count} values", f"{count} values")
            pose, rates = mechanics.start(scenario.motion)
        if self.system.motor is not None and scenario.source == "held" and not self.machine.tracks:
            rates[list(self.system.motor.coordinates)] = self.machine.set_speed
            if self.angles is not None:
                rates = self.machine.roll(rates, np.asarray(self.angles(0.0), dtype=float))
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
        found = self.system.rates(self.system.idle(), np.zeros(1), state[None])
        if not np.all(np.isfinite(found.derivative)):
            raise ParameterError("pose must be within the reach of the machine at the start")
        return state

    def _first_angles(self, pose: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Angles of rolling at the start, or those prescribed."""
        if self.angles is not None:
            return np.asarray(self.angles(0.0), dtype=float)
        law = self._steering_law()
        assert law is not None
        return law(0.0, pose, rates, np.zeros(len(self.mechanics.steered)))[0]

    def _steering_law(self) -> control.SteeringLaw | None:
        if self.angles is not None:
            return control.following_angles(self.angles)
        pose = self.machine.home if self.scenario.pose is None else np.array(self.scenario.pose)
        return self.machine.follow(self.mechanics, self.scenario.motion, pose, self.scenario.duration)

    def _controller(self) -> control.MachineController:
        system, settings, held = self.system, self.machine.control, self.scenario.source == "held"
        return control.MachineController(
            loops=control.begun_loops(system, settings, self.state, self.period, held),
            duration=self.scenario.duration,
            set_speed=self.machine.set_speed,
            steering_law=self._steering_law() if system.servo is not None else None,
            links=self._tracking(),
        )

    def _tracking(self) -> control.LinkController | control.TractionController | None:
        """Controller of motors that follow the motion, if the machine has such."""
        if self.system.links is not None:
            return self._links(self.system.links)
        if not self.machine.tracks or self.scenario.motion is None:
            return None
        return self.machine.traction(self.mechanics, self.scenario.motion, self.system.user(np.zeros(1))[0])  # type: ignore[attr-defined]

    def _links(self, motors: LinkMotors) -> control.LinkController:
        """Controller of a motor on each link, which start with the currents that hold the user."""
        motion, pose = self.scenario.motion, np.array(self.state[: self.system.places[0]])
        if motion is None:
            motion = control.standing(pose, self.scenario.duration)
        return LinkController(
            motors=motors,
            mechanics=self.mechanics,  # type: ignore[arg-type]
            motion=motion,
            integral=-self.system.user(np.zeros(1))[0],
        )

    def over(self, title: str, progress: Callable[[float], None]) -> MachineRun:
        """The run."""
        scenario = self.scenario
        march = March(
            system=self.system,
            motion=compiled_motion(self.system),
            state=self.state,
            controller=self.controller,
            period=self.period,
            duration=scenario.duration,
            output_step=scenario.output_step,
            settling_time=scenario.settling_time,
            tolerance=scenario.tolerance,
        )
        found = march.over(progress)
        pushed = self.system.user(found.time)
        return MachineRun(
            machine=self.machine,
            scenario=scenario,
            title=title,
            **found.of_result({f"user_{place + 1}": pushed[:, place] for place in range(self.wrenched)}),
        )
