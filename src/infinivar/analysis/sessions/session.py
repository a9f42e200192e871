"""A session of a user at the handle of a machine that a controller guides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.arrays import real_array
from infinivar._core.fields import check_number, given
from infinivar.analysis.marching import March, Record
from infinivar.analysis.sessions.session_result import Session, touches
from infinivar.errors import ParameterError, require
from infinivar.machines.compiled import Motion, compiled_motion, derivative_of
from infinivar.machines.control import loops as control
from infinivar.machines.control.controller import Plant, begun
from infinivar.machines.control.sampling import Sensing, check_rate
from infinivar.machines.control.sensing import GuidedController, Sensors
from infinivar.machines.control.tasks import controller_of, curve_of, surface_of
from infinivar.machines.hand import Grip, GrippingArm, Hand, Held
from infinivar.machines.kind import MovingMachine
from infinivar.machines.registry import MACHINES
from infinivar.machines.system import System
from infinivar.motion.machine_scenario import History, SideBySide, check_length, over_time
from infinivar.motion.virtual.tasks import TASKS, HandleTask
from infinivar.transmission.platform import rotation_vector

_DEPTH = 1e-3
"""Penetration of a wall that counts as one more allowance, for the search of its instant. [m]"""

_ARM, _ARM_TURNS = ("mass", "damping", "stiffness"), ("inertia", "turning_damping", "turning_stiffness")
"""Of an arm: along each axis, and about all."""

Servos = Literal["real", "ideal"]


@dataclass(slots=True, kw_only=True)
class Setup:
    """A session that is set up: arguments of `session`, checked and completed, and what moves. It can be run more than once.

    Raises
    ------
    ParameterError
        If an argument is out of range, or does not fit the machine.
    """

    machine: MovingMachine
    task: Any = None
    controller: Any = None
    user: Any = None
    duration: float
    intention: History | None = None
    force: History | None = None
    moment: History | None = None
    turned: History | None = None
    sensing: Sensing = field(default_factory=Sensing)
    servos: Servos = "real"
    wall: Any = None
    path: Any = None
    handle: Sequence[float] = (0.0, 0.0)
    pose: Sequence[float] | None = None
    rates: Sequence[float] | None = None
    stick_speed: float = 1e-4
    output_step: float | None = None
    tolerance: float = 1e-4
    title: str = ""
    grip: Grip = field(init=False)
    system: System = field(init=False)
    motion: Motion | None = field(init=False)
    """Of the system, where it is compiled."""
    state: np.ndarray = field(init=False)
    """At the start, before the controller commands anything."""

    def __post_init__(self) -> None:
        """Check the arguments, complete them by the task and controller, and set up what moves."""
        self._check()
        if self.controller is None and self.task is not None:
            self.controller = controller_of(self.task, self.machine)
        elif self.task is not None and not isinstance(self.task, HandleTask):
            kinds = ", ".join(kind.__name__ for kind in TASKS.values())
            raise ParameterError(f"task must be one of {kinds}, got {self.task!r}")
        self.wall = _known("wall", given(self.wall, surface_of(self.task)), self.controller)
        self.path = _known("curve", given(self.path, curve_of(self.task)), self.controller)
        curved = self.path is None or hasattr(self.path, "nearest")
        require(curved, "path", repr(self.path), "a curve: with nearest(point, near)")
        mechanics = self.machine.mechanics(self.stick_speed)
        self.grip = mechanics.grip(self.handle)
        start = _row("pose", self.pose, self.machine.home)
        self.system = self._moved(mechanics, start)
        self.motion = compiled_motion(self.system)
        self.state = self._at_start(start)

    def _check(self) -> None:
        """Refuse arguments out of range."""
        machine, duration, output_step, sensing = self.machine, self.duration, self.output_step, self.sensing
        if not isinstance(machine, MovingMachine):
            names = ", ".join(MACHINES)
            raise ParameterError(f"machine must be one of {names}, got {machine!r}")
        check_number("duration", duration, "s", Gt(0))
        check_number("stick_speed", self.stick_speed, "m/s", Gt(0))
        check_number("tolerance", self.tolerance, "1", Interval(gt=0, le=1e-4))
        if output_step is not None:
            check_number("output_step", output_step, "s", Gt(0))
        require(self.servos in ("real", "ideal"), "servos", repr(self.servos), "real or ideal")
        if not isinstance(sensing, Sensing):
            raise ParameterError(f"sensing must be a Sensing, got {sensing!r}")
        check_length(duration, sensing.sample_rate, output_step)
        check_rate(machine, sensing)

    def _moved(self, mechanics: Any, start: np.ndarray) -> System:
        """The machine with the user at its handle, who may want it to stay where it is at the start."""
        machine, stick_speed = self.machine, self.stick_speed
        at_home = self.grip.at(start[None], np.zeros((1, len(mechanics.coordinates))))
        return System(
            mechanics=mechanics,
            motor=machine.power_motor(stick_speed),
            links=machine.link_motors(stick_speed),
            servo=machine.servo(stick_speed) if self.servos == "real" and mechanics.steered else None,
            prescribed_steering=self.servos == "ideal" or not mechanics.steered,
            hand=_hand(self, at_home),
            watch=None if self.wall is None else _watching(self.wall, len(self.grip.axes)),
        )

    def _at_start(self, start: np.ndarray) -> np.ndarray:
        """State from a configuration, with wheels straight ahead."""
        system, mechanics = self.system, self.system.mechanics
        moving = np.zeros(len(mechanics.coordinates))
        if system.motor is not None:
            moving[list(system.motor.coordinates)] = self.machine.set_speed
        moving = _row("rates", self.rates, moving)
        state = system.begun(start, moving)
        if not np.all(np.isfinite(system.rates(system.idle(), np.zeros(1), state[None]).derivative)):
            raise ParameterError("pose must be within the reach of the machine at the start")
        return state

    def begun(self) -> tuple[GuidedController, np.ndarray]:
        """A controller before its first sample, and the state in which it begins."""
        system, period, state = self.system, self.sensing.period, self.state.copy()
        guided = GuidedController(
            loops=control.begun_loops(system, self.machine.control, state, period),
            sensors=Sensors(self.sensing, system, self.motion),
            law=begun(self.controller, Plant(machine=self.machine, system=system, grip=self.grip, period=period)),
        )
        first = guided.start(state)
        c, nu, _ = system.places
        if self.rates is None and system.motor is not None and first.currents is None:
            # A cylinder begins at the speed that is commanded, or at rest.
            state[c:nu][list(system.motor.coordinates)] = given(first.speed, 0.0)
        if first.steering is not None:
            state[nu : nu + len(system.mechanics.steered)] = first.steering
        return guided, state

    def check_begins(self) -> None:
        """Simulate one sample, to refuse a session whose controller cannot begin.

        Raises
        ------
        ParameterError
            If it commands what the machine does not have.
        """
        self._march(self.sensing.period, None).over(lambda share: None)

    def _march(self, duration: float, output_step: float | None) -> March:
        guided, state = self.begun()
        return March(
            system=self.system,
            motion=self.motion,
            state=state,
            controller=guided,
            period=self.sensing.period,
            duration=duration,
            output_step=output_step,
            tolerance=self.tolerance,
        )

    def over(self, progress: Callable[[float], None]) -> Session:
        """The session."""
        march = self._march(self.duration, self.output_step)
        found = march.over(progress)
        watched = found.watched.shape[1:] == (1,)
        return Session(
            machine=self.machine,
            task=self.task,
            controller=self.controller,
            user=self.user,
            sensing=self.sensing,
            title=self.title,
            axes=self.grip.axes,
            turns=self.turns,
            wall=self.wall,
            path=self.path,
            touches=touches(found.instants, _DEPTH * (found.watched[:, 0] - 1.0)) if watched else (),
            **found.of_result(self._at_handle(found, march.log.inputs)),
        )

    def _at_handle(self, found: Record, inputs: Sequence[Any]) -> dict[str, np.ndarray]:
        """Position and velocity of the handle, and the force of the user on it, at the results. (t,) each"""
        first, second, _ = self.system.places
        c, nu = found.states[:, :first], found.states[:, first:second]
        held = self.grip.at(c, nu)
        velocity = np.einsum("mdn,mn->md", held.jacobian, nu)
        forces = _felt(self.system, self.motion, found, inputs)
        columns = {}
        for place, axis in enumerate(self.grip.axes):
            columns[f"handle_{axis}_m"] = held.position[:, place]
            columns[f"handle_v_{axis}_m_s"] = velocity[:, place]
            columns[f"force_{axis}_N"] = forces[:, place]
        if not self.turns:
            return columns
        assert held.about is not None
        about, count = held.about(), len(self.grip.axes)
        angles = about.at if about.at.ndim == 2 else rotation_vector(about.at)
        turning = np.einsum("mkn,mn->mk", about.jacobian, nu)
        for place, turn in enumerate(self.turns):
            columns[f"handle_{turn}_rad"] = angles[:, place]
            columns[f"handle_{turn}_rate_rad_s"] = turning[:, place]
            columns[f"moment_{turn}_Nm"] = forces[:, count + place]
        return columns

    @property
    def turns(self) -> tuple[str, ...]:
        """Rotations about which the user acts."""
        assert self.system.hand is not None
        return self.system.hand.ways[len(self.grip.axes) :]


def session(
    machine: MovingMachine,
    task: Any = None,
    controller: Any = None,
    user: Any = None,
    *,
    duration: float,
    intention: History | None = None,
    force: History | None = None,
    moment: History | None = None,
    turned: History | None = None,
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
    moment : history            Moment on the handle, about x, y and z fixed in space or in the plane; it acts on the body alone,
        wherever it is held. An arm with a moment of inertia turns the handle, too. [N m]
    turned : history            How far from the start such an arm wants the handle turned: a rotation vector in fixed axes, or an
        angle in the plane; by default not at all. The handle stays within half a turn of it. [rad]
    sensing : Sensing           Sample rate and sensors; by default ideal sensors at 1 kHz.
    servos : str                "real": with the motors, inertia and friction of the steering; "ideal": wheels turn as commanded.
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
    return Setup(
        machine=machine,
        task=task,
        controller=controller,
        user=user,
        duration=duration,
        intention=intention,
        force=force,
        moment=moment,
        turned=turned,
        sensing=Sensing() if sensing is None else sensing,
        servos=servos,
        wall=wall,
        path=path,
        handle=handle,
        pose=pose,
        rates=rates,
        stick_speed=stick_speed,
        output_step=output_step,
        tolerance=tolerance,
        title=title,
    ).over(progress or (lambda share: None))


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


def _hand(setup: Setup, home: Held) -> Hand:
    """The user's hand, with force and moment over time, and an arm that may want the handle to stay at home."""
    user, force, grip = setup.user, setup.force, setup.grip
    arm = user if user is not None and hasattr(user, "stiffness") else None
    turning = arm is not None and getattr(arm, "inertia", None) is not None
    turns = setup.moment is not None or turning
    if turns and not grip.turns:
        name = "moment" if setup.moment is not None else "user.inertia"
        raise ParameterError(f"{name} does not apply: the handle of a {type(setup.machine).__name__} does not turn")
    if arm is None and setup.intention is not None:
        raise ParameterError("intention is of an arm: user must be one, with mass, damping and stiffness")
    if setup.turned is not None and not turning:
        raise ParameterError("turned is of an arm that turns: user must be one, with inertia")
    if arm is None and user is not None:
        if force is not None:
            raise ParameterError("user and force are both forces over time; give one of them")
        force = user
    count, turned = len(grip.axes), len(grip.turns) if turns else 0
    pushing = None if force is None else over_time("user" if force is user else "force", force, count)
    if turns and (pushing is not None or setup.moment is not None):
        about = over_time("moment", given(setup.moment, [0.0] * turned), turned)
        pushing = SideBySide((given(pushing, over_time("force", [0.0] * count, count)), about))
    if arm is None:
        return Hand(grip=grip, force=pushing, turns=turns)
    values = [np.broadcast_to(np.asarray(getattr(arm, name), dtype=float), (count,)) for name in _ARM]
    intended: Any = over_time("intention", given(setup.intention, home.position[0]), count)
    start = None
    if turns:
        assert home.about is not None
        resisting = [float(getattr(arm, name)) if turning else 0.0 for name in _ARM_TURNS]
        values = [np.append(one, np.full(turned, more)) for one, more in zip(values, resisting, strict=True)]
        wanted = over_time("turned", given(setup.turned, [0.0] * turned), turned)
        intended, start = SideBySide((intended, wanted)), home.about().at[0]
    return Hand(
        grip=grip,
        force=pushing,
        arm=GrippingArm(**dict(zip(_ARM, values, strict=True)), intention=intended, start=start),
        turns=turns,
    )


def _check_turn(time: np.ndarray, apart: np.ndarray) -> None:
    """Raise ParameterError where the turn (t, k) to where an arm wants the handle passes half a turn: it would pull back."""
    if apart.shape[-1] < 2:  # about one axis, turns add up
        return
    far = np.linalg.norm(apart, axis=-1) > 0.5 * np.pi
    jumped = far[1:] & far[:-1] & (np.sum(apart[1:] * apart[:-1], axis=-1) < 0.0)
    if np.any(jumped):
        raise ParameterError(
            f"the arm wants the handle turned by half a turn or more from where it is, at {time[1:][jumped][0]:.3g} s, and would "
            "turn it back: lower the turn that it wants, or raise its turning_stiffness"
        )


def _felt(system: System, motion: Motion | None, found: Record, inputs: Sequence[Any]) -> np.ndarray:
    """Force and moment of the user on the handle at the results. (t, d + k)"""
    first, second, _ = system.places
    c, nu = found.states[:, :first], found.states[:, first:second]
    hand = system.hand
    assert hand is not None
    acceleration = np.zeros_like(nu)
    outside = system.outside(found.time)
    if hand.arm is not None:
        _check_turn(found.time, hand.apart(outside.intended, outside.intending, c, nu)[:, len(hand.grip.axes) :])
        derivative = derivative_of(system, motion)
        for row, one in enumerate(inputs):
            acceleration[row] = derivative(one, outside.row(row), found.states[row])[first:second]
    return hand.felt(outside.force, outside.intended, outside.intending, c, nu, acceleration)
