"""The plant of a machine of several coordinates, as other programs see it: the equations of its runs, with a user at the handle,
and in a session the controller that guides it.

Its numbers are data of the C text, not parameters: many fields of a study decide one of them.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.collocation import Rates
from infinivar._core.described import suffix, unit_of
from infinivar.analysis.sessions.session import Setup
from infinivar.axis import LINEAR, ROTARY
from infinivar.bondgraph.c_code import c_motion, data_of, statements
from infinivar.bondgraph.compiled_step import NO_CONTROLLER, controller_text
from infinivar.bondgraph.compiled_step import Recorded as RecordedControl
from infinivar.bondgraph.recorded import Recorded
from infinivar.bondgraph.tape import Value
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import InputError, ParameterError, printable
from infinivar.exports import temperatures
from infinivar.exports.plant import Begun, Plant, behind_of, control_text, naming_laws, plant_text
from infinivar.exports.variables import Role, Variable, demand_of, distinct, letters, rate_of
from infinivar.machines.compiled import Acted, OpenInputs, record
from infinivar.machines.hand import Hand
from infinivar.machines.kind import MovingMachine
from infinivar.machines.motors import Shaft
from infinivar.machines.sampled import NO_FORMULA, formula, numbers_of
from infinivar.machines.system import Inputs, Outside, System
from infinivar.motion.vectors import ROTATING
from infinivar.parts.heat_steps import REFERENCE

STICK_SPEED = 1e-4
"""Below which friction sticks, as in runs. [m s^-1]"""


class MovingPlant(NamedTuple):
    """A machine set up for export."""

    system: System
    start: np.ndarray
    """State; without a session at home, at rest but for a cylinder or shaft at its speed and what rolls with it, with wheels
    straight ahead."""
    notes: tuple[str, ...]
    inputs: Inputs
    """At the start."""
    session: Setup | None = None
    controller: Any = None
    """Of a session, after its first sample; None: its commands are inputs."""


def moving_machine(drive: Any, load_mass: float | None = None) -> MovingMachine:
    """The machine that moves in time, of a drive of a study, or the drive itself if it moves.

    Raises
    ------
    ParameterError
        If it does not move in time, or lacks a value that motion needs.
    """
    if isinstance(drive, MovingMachine):
        if load_mass is not None:
            raise ParameterError("load_mass must be left out for a machine that has its masses")
        return drive
    if load_mass is None:
        return drive.moving()
    if "load_mass" not in drive.session:
        raise ParameterError(f"load_mass must be left out for a machine of type {drive.WORD}: its masses have the load")
    return drive.moving(load_mass=load_mass)


def moves(drive: Any) -> bool:
    """Whether a drive is a machine of several coordinates."""
    return isinstance(drive, MovingMachine) or is_machine(drive)


def moving_plant(machine: MovingMachine) -> MovingPlant:
    """A machine with its motors and a user at its handle.

    Raises
    ------
    ParameterError
        If a value that motion needs is missing.
    """
    mechanics, notes = machine.mechanics(STICK_SPEED), []
    servo = None
    if mechanics.steered:
        try:
            servo = machine.servo(STICK_SPEED)
        except ParameterError as problem:
            notes.append(f"rates of the steering angles are inputs, as the machine has no servos: {problem}")
    try:
        hand = Hand(grip=mechanics.grip())
    except ParameterError:
        hand = None  # shafts have no handle: the user acts on the coordinates alone
    system = System(
        mechanics=mechanics,
        motor=machine.power_motor(STICK_SPEED),
        links=machine.link_motors(STICK_SPEED),
        servo=servo,
        prescribed_steering=servo is None,
        wrench=lambda time: np.zeros(len(mechanics.configuration)),
        hand=hand,
    )
    rates = np.zeros(len(mechanics.coordinates))
    if system.motor is not None:
        rates[list(system.motor.coordinates)] = machine.set_speed
        rates = machine.roll(rates, np.zeros(len(mechanics.steered)))
    start = system.begun(np.asarray(machine.home, dtype=float), rates)
    return MovingPlant(system, start, tuple(notes), system.idle())


def session_plant(session: Setup, *, closed: bool) -> MovingPlant:
    """The machine of a session as it begins, without its controller or with it, whose first sample has then been taken.

    Raises
    ------
    ParameterError
        If the controller cannot begin.
    """
    guided, start = session.begun()
    inputs = guided.sample(0.0, start)
    return MovingPlant(
        replace(session.system, watch=None), start, (), inputs.copy(), session, guided if closed else None
    )


def machine_plant(made: MovingPlant, name: str, title: str) -> Plant:
    """The plant of a machine.

    Parameters
    ----------
    made : MovingPlant
    name, title : str   Identifier of at most 64 letters, and headline.

    Raises
    ------
    InputError
        If a law has no C, or the controller has no formula.
    """
    system, named = made.system, _Named()
    own, inputs, rates = list(_states(system, made.start)), list(_inputs(made)), list(_rates(made))
    states = [*own, *temperatures.states(_heated(made))]
    with naming_laws("machine"):
        recorded = record(system, functools.partial(_acting, made), functools.partial(_read, made, named))
        names = [one.name for one in states], [one.name for one in inputs]
        moving = [one.name.removesuffix("_rate") for one in rates]
        code = c_motion(recorded.tape, *names, recorded.functions, moving)
    control, begun, signals = NO_CONTROLLER, Begun(), ()
    if made.controller is not None and made.session is not None:
        commanded = [place for place, one in enumerate(inputs) if one.role == "command"]
        control = _control(made, made.session, commanded)
        begun = Begun(numbers_of(made.controller.memory), made.session.sensing.period, 1)
        signals = tuple(_signals(made, [one.name for one in own], names[1]))
    given = code.given(recorded.tape.parameters)
    rows = [
        Variable("time", "time", "s", "time"),
        *states,
        *(rate_of(one, f"der({one.name})", "derivative", None) for one in states),
        *inputs,
        *rates,
        *named.outputs,
    ]
    variables = tuple(distinct(rows))
    return Plant(
        name=name,
        title=printable(title),
        variables=variables,
        text=plant_text(code, given.tolist(), variables),
        control=control_text(control, variables, begun),
        behind=behind_of(code, variables),
        signals=signals,
    )


def _control(made: MovingPlant, session: Setup, places: list[int]) -> RecordedControl:
    """C of a sample of the controller, which reads the time, its signals and its memory; places: of what it commands."""
    guided, (first, second, _) = made.controller, made.system.places
    word, period = type(session.controller).__name__, session.sensing.period
    without = InputError(
        f"--loop: the controller of this session, {word}, decides in Python alone and has no C; --scenario with the same task "
        "exports the machine without it"
    )
    if guided.memory is None:
        raise without
    try:
        found = formula(guided, len(made.start), slice(first, second), period, feels=_feels(made))
        results = numbers_of([*_commands(made.system, found.inputs), *found.memory])
        body = statements(found.tape, results, "y")
    except NO_FORMULA as problem:
        raise without from problem
    memory = len(numbers_of(found.memory))
    return RecordedControl(controller_text(1, memory, places, body), np.zeros(1), np.append(data_of(found.tape), 0.0))


def _commands(system: System, inputs: Inputs) -> list[Any]:
    """What a controller may command: currents of motors, and currents or rates of steering."""
    motors = inputs.currents if system.links is None else inputs.links
    return [motors, inputs.turning if system.servo is None else inputs.steering]


def _feels(made: MovingPlant) -> bool:
    """Whether the sensors of a controller depend on accelerations."""
    return made.system.hand is not None and made.system.hand.arm is not None


def _signals(made: MovingPlant, states: Sequence[str], inputs: Sequence[str]) -> Iterator[str]:
    """Yield the names of what a controller reads, in the order of a formula, from those of states and inputs."""
    hand = [one for one in inputs if one.startswith(("handle.", "intention."))]
    yield from hand
    yield from (f"{one}_rate" for one in hand if one.startswith("intention."))
    yield from (one for one in inputs if one.startswith("noise."))
    if _feels(made):
        yield from (f"der({one})" for one in states)
    yield from states


_OF_USER = {"m/s": ("N", "force"), "rad/s": ("N m", "torque")}
"""What acts on a coordinate, by the unit of its rate."""


def _plain(name: str) -> str:
    """Name of a column without its unit."""
    return name.removesuffix(suffix(unit_of(name)))


def _states(system: System, start: np.ndarray) -> Iterator[Variable]:
    """Yield configuration, rates, steering angles and their rates."""
    mechanics = system.mechanics
    angles = mechanics.steered if system.servo is not None or system.prescribed_steering else ()
    turning = [one.replace("_rad", "_rate_rad_s") for one in angles] if system.servo is not None else []
    words = (
        (mechanics.configuration, "pose"),
        (mechanics.coordinates, "rate of a coordinate"),
        (angles, "steering angle"),
        (turning, "rate of a steering angle"),
    )
    every = [(name, said) for names, said in words for name in names]
    poses = [_plain(name) for name in mechanics.configuration]
    for place, ((name, said), value) in enumerate(zip(every, start.tolist(), strict=True)):
        again = "_rate" if place >= len(poses) and _plain(name) in poses else ""
        yield Variable(f"{_plain(name)}{again}", "state", unit_of(name), f"{said}: {_plain(name)}", value)


def _inputs(made: MovingPlant) -> Iterator[Variable]:
    """Yield what acts on a machine, in the order of `_acting`."""
    system, mechanics, outside = made.system, made.system.mechanics, made.system.outside(np.zeros(1))
    begun = iter(numbers_of(_commands(system, made.inputs)))
    role: Role = "input" if made.controller is None else "command"
    for name in system.motors:
        yield Variable(f"current.{name}", role, "A", "current of the motor", next(begun))
    for name in map(_plain, mechanics.steered):
        if system.servo is not None:
            yield Variable(f"current.{name}", role, "A", f"current of the servo of {name}", next(begun))
        else:
            yield Variable(f"rate.{name}", role, "rad/s", f"rate of {name}, which turns as commanded", next(begun))
    for name in mechanics.coordinates[: len(mechanics.configuration)] if outside.pushed is not None else ():
        unit, word = _OF_USER[unit_of(name)]
        yield Variable(f"user.{_plain(name)}", "input", unit, f"{word} of user or load with {_plain(name)}", 0.0)
    known = (
        ("handle", "force of the user on the handle along {}, fixed in space", "moment of the user on the handle: {}"),
        (
            "intention",
            "where the arm of the user wants the handle to be, along {}",
            "turn from the start to how the arm of the user wants the handle: {}",
        ),
        ("noise", "noise of the force sensor along {} at a sample", ""),
    )
    begins = (outside.force, outside.intended, _noise(made))
    for (name, along, about), begin in zip(known, begins, strict=True):
        for way, value in zip(_ways(system), [] if begin is None else np.ravel(begin).tolist(), strict=False):
            axis = ROTARY if way in ROTATING else LINEAR
            unit = axis.position_unit if name == "intention" else axis.force_unit
            yield Variable(f"{name}.{way}", "input", unit, (about if axis.rotary else along).format(way), value)
    if _heated(made):
        yield Variable(temperatures.AMBIENT, "input", "K", "ambient temperature of the motors", REFERENCE)


def _heated(made: MovingPlant) -> list[str]:
    """Motors with thermal data, by their names in demands."""
    return [one.what for one in _warmed(_shafts(made.system, made.inputs, made.start[None]))]


def _ways(system: System) -> tuple[str, ...]:
    return () if system.hand is None else system.hand.ways


def _noise(made: MovingPlant) -> np.ndarray:
    """Noise that a controller reads, at the start none."""
    return np.zeros(0 if made.controller is None else made.controller.sensors.drawn.shape[1])


def _rates(made: MovingPlant) -> Iterator[Variable]:
    """Yield rates of what a user does in a session: with them it goes on within a step, and the arm has a damper."""
    if made.session is None:
        return
    begin = made.system.outside(np.zeros(1)).intending
    starts = {} if begin is None else dict(zip(_ways(made.system), begin[0].tolist(), strict=True))
    for one in _inputs(made):
        kind, _, axis = one.name.partition(".")
        if kind in ("handle", "intention"):
            yield rate_of(one, f"{one.name}_rate", "rate", starts.get(axis, 0.0) if kind == "intention" else 0.0)


def _acting(made: MovingPlant, input_of: OpenInputs) -> Acted:
    """What acts on a machine: currents, rates of steering without servos, and a user."""
    system, ways = made.system, len(_ways(made.system))
    mechanics, count, outside = system.mechanics, len(system.motors), system.outside(np.zeros(1))
    motors = input_of((count,))
    steering = input_of((len(mechanics.steered),))
    pushed = None
    if outside.pushed is not None:
        pushed = Recorded(motors.tape, np.zeros(outside.pushed.shape, dtype=object))
        pushed[:, : len(mechanics.configuration)] = input_of((1, len(mechanics.configuration)))
    force = None if system.hand is None else input_of((1, ways))
    intended = intending = None
    if outside.intended is not None:
        intended = input_of((1, ways))
        intending = Recorded(motors.tape, [[motors.tape.input("rates", ways + place) for place in range(ways)]])
    input_of(np.shape(_noise(made)))
    input_of((int(bool(_heated(made))),))  # the ambient temperature
    inputs = Inputs(
        currents=motors,
        steering=steering if system.servo is not None else np.zeros(0),
        turning=steering if system.servo is None else np.zeros(0),
        links=motors,
    )
    return inputs, Outside(pushed=pushed, force=force, intended=intended, intending=intending)


class _Named:
    """Outputs of a machine, in the order in which they are read."""

    def __init__(self) -> None:
        self.outputs: list[Variable] = []
        self.columns: list[Any] = []

    def add(self, variable: Variable, column: Any) -> None:
        """One output; those that are the same number in all states are left out."""
        if isinstance(column, Value):
            self.outputs.append(variable)
            self.columns.append(column)

    def say(self, name: str, unit: str, said: str, column: Any) -> None:
        """One output, in words."""
        self.add(Variable(name, "output", unit, said), column)


def _read(made: MovingPlant, named: _Named, found: Rates, acted: Acted, state: Recorded) -> Mapping[str, Any]:
    """Outputs: the handle, voltages, energies, powers, losses and demands on limits; and what a controller reads."""
    system, balance, (inputs, outside) = made.system, found.balance(), acted
    mechanics, (first, second, _) = system.mechanics, system.places
    c, nu = state[:, :first], state[:, first:second]
    if system.hand is not None:
        _say_handle(named, system.hand, outside, (c, nu, found.derivative[:, first:second]))
    shafts = _shafts(system, inputs, state)
    for one in shafts:
        named.say(f"voltage.{one.name}", "V", f"voltage of {one.part}", one.voltage[0])
    energies = replace(system, hand=None).energies(np.zeros(1), state)
    for storage, column in zip(system.storages, energies[0], strict=False):
        named.say(f"energy.{storage}", "J", f"energy of motion and weight: {storage}", column)
    powers = balance.power[0].tolist()
    for source, column in zip(system.sources, powers, strict=False):
        named.say(f"power.{letters(source)}", "W", f"power supplied by {source}", column)
    for loss, column in zip(system.losses, powers[len(system.sources) :], strict=True):
        named.say(f"loss.{letters(loss)}", "W", f"power lost: {loss}", column)
    demands = [*zip(mechanics.demands, balance.demand[0].tolist(), strict=True)]
    demands += [(key, demand[0]) for one in shafts for key, demand in one.utilisation().items()]
    for (limit, part), column in demands:
        named.add(demand_of(limit, part), column)
    tape, motors = state.tape, [*_warmed(shafts)]
    added = [tape.input("states", state.shape[1] + place) for place in range(2 * len(motors))]
    given = [one.name for one in _inputs(made)]
    ambient = tape.input("inputs", given.index(temperatures.AMBIENT)) if motors else 0.0
    for variable, demand in temperatures.demands(motors, added, ambient):
        named.add(variable, demand)
    rows = {
        "motion": [[*found.derivative[0], *temperatures.rates(motors, added, ambient)]],
        "outputs": [named.columns],
    }
    if made.controller is None:
        return rows
    noise = [tape.input("inputs", place) for place, name in enumerate(given) if name.startswith("noise.")]
    felt = [found.derivative] if _feels(made) else []
    read = numbers_of([*(one for one in outside if one is not None), noise, *felt, state])
    return {**rows, "signals": [read]}


def _say_handle(named: _Named, hand: Hand, outside: Outside, moving: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    """Outputs of the handle of a machine that moves, by its configuration, rates and accelerations."""
    configuration, rates, _ = moving
    held = hand.grip.at(configuration, rates)
    velocity = np.matmul(held.jacobian, rates[..., None])[..., 0]
    for place, axis in enumerate(hand.grip.axes):
        named.say(f"position.handle.{axis}", "m", f"position of the handle along {axis}", held.position[0, place])
        named.say(f"speed.handle.{axis}", "m/s", f"velocity of the handle along {axis}", velocity[0, place])
    turns = hand.ways[len(hand.grip.axes) :]
    if turns and held.about is not None:
        turning = np.matmul(held.about().jacobian, rates[..., None])[..., 0]
        for turn, column in zip(turns, turning[0], strict=True):
            named.say(f"speed.handle.{turn}", "rad/s", f"angular velocity of the handle: {turn}", column)
    if hand.arm is None:
        return
    for way, column in zip(hand.ways, hand.felt(*outside[1:4], *moving)[0], strict=True):
        word, unit = ("moment", "N m") if way in turns else ("force", "N")
        said = f"{word} between hand and handle" + (f": {way}" if way in turns else f" along {way}")
        named.say(f"{word}.handle.{way}", unit, said, column)
    energy = hand.act(*outside[1:4], configuration, rates).energy(rates)[0]
    named.say("energy.arm", "J", "energy of the arm of the user: of its mass and in its spring", energy)


def _shafts(system: System, inputs: Inputs, state: np.ndarray) -> list[Shaft]:
    """Motors and servos at rows of states."""
    return system.shafts(inputs, state, system.steering(Outside(), state, inputs.turning)[1])


def _warmed(shafts: Iterable[Shaft]) -> Iterator[temperatures.Warmed]:
    """Yield what warms the motors that have thermal data."""
    for one in shafts:
        for motor in temperatures.with_data({one.part: one.motor}).values():
            loss, friction = one.heat
            yield temperatures.warmed(one.part, functools.partial(getattr, motor), loss[0], friction[0])
