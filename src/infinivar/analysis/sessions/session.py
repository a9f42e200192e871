"""A session of a user at the handle of a machine that a controller guides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.arrays import real_array
from infinivar._core.fields import check_number, given
from infinivar.analysis.marching import March
from infinivar.analysis.sessions.session_result import Session, touches
from infinivar.errors import ParameterError, require
from infinivar.machines.control import loops as control
from infinivar.machines.control.controller import Plant, begun
from infinivar.machines.control.sensing import GuidedController, Sensing, Sensors, check_rate
from infinivar.machines.control.tasks import controller_of, curve_of, surface_of
from infinivar.machines.hand import GrippingArm, Hand
from infinivar.machines.kind import Machine
from infinivar.machines.registry import MACHINES
from infinivar.machines.system import System
from infinivar.motion.machine_scenario import History, over_time
from infinivar.motion.virtual.tasks import TASKS, HandleTask

_DEPTH = 1e-3
"""Penetration of a wall that counts as one more allowance, for the search of its instant. [m]"""

_MOST_SAMPLES = 1e6
"""Of a session; more would take hours."""

Servos = Literal["real", "ideal"]


def session(
    machine: Machine,
    task: Any = None,
    controller: Any = None,
    user: Any = None,
    *,
    duration: float,
    intention: History | None = None,
    force: History | None = None,
    sensing: Sensing | None = None,
    servos: Servos = "real",
    wall: Any = None,
    path: Any = None,
    handle: Sequence[float] = (0.0, 0.0),
    pose: Sequence[float] | None = None,
    rates: Sequence[float] | None = None,
    stick_speed: float = 1e-4,
    output_step: float | None = None,
    tolerance: float = 1e-4,
    title: str = "",
    progress: Callable[[float], None] | None = None,
) -> Session:
    """Simulate a session: a user at the handle, and a controller that guides the machine by its task.

    Parameters
    ----------
    machine : PlanarMachine, PlatformMachine, ArmMachine, SerialArmMachine, SeparateMachine, SlideMachine or GearedSlideMachine
    task : VirtualPath, VirtualWall, Fixture, Caster, Coasting or HoldingTask   None: what the controller makes of it.
    controller : Controller or function   None: that of the task; without a task, nothing is commanded.
    user : history or ArmModel   A force on the handle over time, or an arm with mass, damping and stiffness that pulls the
        handle towards an intention. None: nobody. [N]
    duration : float            [s]
    intention : history         Where an arm wants the handle to be; by default where it is at the start. [m]
    force : history             Force on the handle beside that of an arm. [N]
    sensing : Sensing           Sample rate and sensors; by default ideal sensors at 1 kHz.
    servos : str                "real": with the motors, inertia and friction of the steering; "ideal": wheels turn as told.
    wall : surface              To measure penetration; by default that of the task or controller. One of fewer dimensions than
        the handle extends along the others.
    path : curve                To measure offsets; by default that of the task or controller.
    handle : (2,) float         Of a body in the plane: where it is held, in its axes. [m]
    pose, rates : (c,), (N,) float   At the start; by default at home and at rest, with a power motor at its set speed.
    stick_speed : float         Speed below which friction sticks. [m s^-1]
    output_step : float         Time between results; by default a thousandth of the session, or a sample. [s]
    tolerance : float           Relative, of states and energies.
    title : str                 Name for reports.
    progress : callable         Called with the share done.

    Returns
    -------
    Session   An exceeded limit is an event, not an error. If a rod leaves its reach or the integration fails, the session ends
        early and states the reason.

    Raises
    ------
    ParameterError
        If an argument is out of range, or does not fit the machine.
    ClosureError
        If the energy balance does not close: an error in the program.

    Source: `infinivar.machines.system` for the equations of motion.
    """
    if not isinstance(machine, Machine):
        names = ", ".join(kind.__name__ for kind in MACHINES)
        raise ParameterError(f"machine must be one of {names}, got {machine!r}")
    check_number("duration", duration, "s", Gt(0))
    check_number("stick_speed", stick_speed, "m/s", Gt(0))
    check_number("tolerance", tolerance, "1", Interval(gt=0, le=1e-4))
    if output_step is not None:
        check_number("output_step", output_step, "s", Gt(0))
    require(servos in ("real", "ideal"), "servos", repr(servos), "real or ideal")
    sensing = Sensing() if sensing is None else sensing
    if not isinstance(sensing, Sensing):
        raise ParameterError(f"sensing must be a Sensing, got {sensing!r}")
    few = duration * max(sensing.sample_rate, 0.0 if output_step is None else 1.0 / output_step) <= _MOST_SAMPLES
    require(few, "duration", f"{duration:g} s", "at most a million samples long")
    check_rate(machine, sensing)
    if controller is None and task is not None:
        controller = controller_of(task, machine)
    elif task is not None and not isinstance(task, HandleTask):
        raise ParameterError(f"task must be one of {', '.join(kind.__name__ for kind in TASKS.values())}, got {task!r}")
    wall = _known("wall", given(wall, surface_of(task)), controller)
    path = _known("curve", given(path, curve_of(task)), controller)
    require(path is None or hasattr(path, "nearest"), "path", repr(path), "a curve: with nearest(point, near)")

    mechanics = machine.mechanics(stick_speed)
    grip = mechanics.grip(handle)
    start = _row("pose", pose, machine.home)
    at_home = grip.at(start[None], np.zeros((1, len(mechanics.coordinates)))).position[0]
    hand = Hand(grip=grip, **_user(user, intention, force, at_home))
    system = System(
        mechanics=mechanics,
        motor=machine.power_motor(stick_speed),
        links=machine.link_motors(stick_speed),
        servo=machine.servo(stick_speed) if servos == "real" and mechanics.steered else None,
        prescribed_steering=servos == "ideal" or not mechanics.steered,
        hand=hand,
        watch=None if wall is None else _watching(wall, len(grip.axes)),
    )
    moving = np.zeros(len(mechanics.coordinates))
    if system.motor is not None:
        moving[list(system.motor.coordinates)] = machine.set_speed
    moving = _row("rates", rates, moving)
    steered = np.zeros(len(mechanics.steered))
    parts = [start, moving, steered, *([np.zeros_like(steered)] if system.servo is not None else [])]
    state = np.concatenate(parts)
    if not np.all(np.isfinite(system.rates(system.idle(), np.zeros(1), state[None]).derivative)):
        raise ParameterError("pose must be within the reach of the machine at the start")

    guided = GuidedController(
        loops=_loops(machine, system, state, sensing.period),
        sensors=Sensors(sensing, system),
        law=begun(controller, Plant(machine=machine, system=system, grip=grip, period=sensing.period)),
    )
    first = guided.start(state)
    if rates is None and system.motor is not None and first.currents is None:
        # A cylinder begins at the speed that is commanded, or at rest.
        begin = state[len(start) : len(start) + len(moving)]
        begin[list(system.motor.coordinates)] = given(first.speed, 0.0)
    if first.steering is not None:
        place = len(start) + len(moving)
        state[place : place + len(steered)] = first.steering
    march = March(
        system=system,
        state=state,
        controller=guided,
        period=sensing.period,
        duration=duration,
        output_step=output_step,
        tolerance=tolerance,
    )
    found = march.over(progress or (lambda share: None))
    held = grip.at(found.states[:, : len(start)], found.states[:, len(start) : len(start) + len(moving)])
    velocity = np.einsum("mdn,mn->md", held.jacobian, found.states[:, len(start) : len(start) + len(moving)])
    forces = _felt(system, found, march.log.inputs)
    columns = dict(found.columns)
    for place, axis in enumerate(grip.axes):
        columns[f"handle_{axis}_m"] = held.position[:, place]
        columns[f"handle_v_{axis}_m_s"] = velocity[:, place]
        columns[f"force_{axis}_N"] = forces[:, place]
    return Session(
        machine=machine,
        task=task,
        controller=controller,
        user=user,
        sensing=sensing,
        title=title,
        axes=grip.axes,
        wall=wall,
        path=path,
        time=found.time,
        columns=columns,
        supplied=found.supplied,
        lost=found.lost,
        stored=found.stored,
        residual=found.residual,
        events=found.events,
        touches=touches(found.instants, _DEPTH * (found.watched[:, 0] - 1.0))
        if found.watched.shape[1:] == (1,)
        else (),
        root_mean_squares=found.root_mean_squares,
        outcome=found.outcome,
    )


def _known(name: str, given: Any, controller: Any) -> Any:
    """A wall or path, or that of the controller."""
    return getattr(controller, name, None) if given is None else given


def _watching(wall: Any, axes: int) -> Callable[[np.ndarray], np.ndarray]:
    """Demand that passes 1 where the handle passes a wall."""
    for name in ("distance", "normal"):
        if not hasattr(wall, name):
            raise ParameterError(f"wall must have distance and normal, but a {type(wall).__name__} has no {name}")
    dimension = getattr(wall, "dimension", axes)
    require(dimension <= axes, "wall", f"one in {dimension} dimensions", f"in no more than the handle has, {axes}")

    def watch(position: np.ndarray) -> np.ndarray:
        return 1.0 - np.asarray(wall.distance(position[:, :dimension]))[:, None] / _DEPTH

    return watch


def _row(name: str, given: Sequence[float] | None, usual: np.ndarray) -> np.ndarray:
    if given is None:
        return np.array(usual, dtype=float)
    values = real_array(name, given)
    fits = values.shape == usual.shape and bool(np.all(np.isfinite(values)))
    require(fits, name, f"{given}", f"{len(usual)} finite numbers")
    return np.array(values, dtype=float)


def _user(user: Any, intention: History | None, force: History | None, home: np.ndarray) -> dict[str, Any]:
    """Force and arm of a user."""
    count = len(home)
    arm = None
    if user is not None and hasattr(user, "stiffness"):
        values = {name: np.broadcast_to(np.asarray(getattr(user, name), dtype=float), (count,)) for name in
                  ("mass", "damping", "stiffness")}  # fmt: skip
        wanted: Any = home if intention is None else intention
        arm = GrippingArm(**values, intention=over_time("intention", wanted, count))
    elif intention is not None:
        raise ParameterError("intention is of an arm: user must be one, with mass, damping and stiffness")
    elif user is not None:
        if force is not None:
            raise ParameterError("user and force are both forces over time; give one of them")
        force = user
    pushing = None if force is None else over_time("user" if force is user else "force", force, count)
    return {"force": pushing, "arm": arm}


def _loops(machine: Machine, system: System, state: np.ndarray, period: float) -> control.Loops:
    first, second, _ = system.places
    motor, integrals = None, np.zeros(0)
    if system.motor is not None:
        columns = list(system.motor.coordinates)
        place = system.mechanics.at(state[None, :first], state[None, first:second])
        inertia = np.diagonal(place.inertia[0])[columns]
        motor = control.placed_motor(system, machine.control, float(np.max(inertia)))
        # The current that keeps the speed at the start.
        rest = system.rates(system.idle(), np.zeros(1), state[None]).derivative[0, first:second]
        integrals = -(inertia + system.motor.inertia) * rest[columns] / system.motor.gain
    servo = control.placed_servo(system, machine.control)
    return control.Loops(system=system, period=period, motor=motor, servo=servo, integrals=integrals)


def _felt(system: System, found: Any, inputs: Sequence[Any]) -> np.ndarray:
    """Force of the user on the handle at the results. (t, d)"""
    first, second, _ = system.places
    c, nu = found.states[:, :first], found.states[:, first:second]
    hand = system.hand
    assert hand is not None
    acceleration = np.zeros_like(nu)
    if hand.arm is not None:
        for row, (one, time) in enumerate(zip(inputs, found.time, strict=True)):
            rates = system.rates(one, np.array([time]), found.states[row : row + 1])
            acceleration[row] = rates.derivative[0, first:second]
    return hand.felt(found.time, c, nu, acceleration)
