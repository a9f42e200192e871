"""The plant of a machine of several coordinates, as other programs see it: the equations of its runs, with a user at the handle.

Its numbers are data of the C text, not parameters: many fields of a study decide one of them.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.collocation import Balance
from infinivar._core.described import suffix, unit_of
from infinivar.bondgraph.c_code import c_motion
from infinivar.bondgraph.compiled_step import NO_CONTROLLER
from infinivar.bondgraph.recorded import Recorded
from infinivar.bondgraph.tape import Value
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import ParameterError, printable
from infinivar.exports.plant import (
    Plant,
    Variable,
    behind_of,
    control_text,
    demand_of,
    distinct,
    letters,
    naming_laws,
    plant_text,
    rate_of,
)
from infinivar.machines.compiled import Acted, OpenInputs, record
from infinivar.machines.hand import Hand
from infinivar.machines.kind import MovingMachine
from infinivar.machines.system import Inputs, Outside, System

STICK_SPEED = 1e-4
"""Below which friction sticks, as in runs. [m s^-1]"""


class MovingPlant(NamedTuple):
    """A machine set up for export."""

    system: System
    start: np.ndarray
    """State: at home, at rest but for a cylinder or shaft at its speed and what rolls with it, with wheels straight ahead."""
    notes: tuple[str, ...]


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
    return MovingPlant(system, start, tuple(notes))


def machine_plant(made: MovingPlant, name: str, title: str) -> Plant:
    """The plant of a machine.

    Parameters
    ----------
    made : MovingPlant
    name, title : str   Identifier of at most 64 letters, and headline.

    Raises
    ------
    InputError
        If a law has no C.
    """
    system, start = made.system, made.start
    named = _Named()
    states = list(_states(system, start))
    inputs = list(_inputs(system))
    with naming_laws("machine"):
        recorded = record(system, functools.partial(_acting, system), functools.partial(_read, system, named))
        code = c_motion(recorded.tape, [one.name for one in states], [one.name for one in inputs], recorded.functions)
    given = code.given(recorded.tape.parameters)
    rows = [
        Variable("time", "time", "s", "time"),
        *states,
        *(rate_of(one, f"der({one.name})", "derivative", None) for one in states),
        *inputs,
        *named.outputs,
    ]
    variables = tuple(distinct(rows))
    return Plant(
        name=name,
        title=printable(title),
        variables=variables,
        text=plant_text(code, given.tolist(), variables),
        control=control_text(NO_CONTROLLER, variables, None),
        behind=behind_of(code, variables),
    )


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


def _inputs(system: System) -> Iterator[Variable]:
    """Yield what acts on a machine, in the order of `_acting`."""
    mechanics = system.mechanics
    for name in system.motors:
        yield _input(f"current.{name}", "A", "current of the motor")
    for name in map(_plain, mechanics.steered):
        if system.servo is not None:
            yield _input(f"current.{name}", "A", f"current of the servo of {name}")
        else:
            yield _input(f"rate.{name}", "rad/s", f"rate of {name}, which turns as commanded")
    for name in mechanics.coordinates[: len(mechanics.configuration)]:
        unit, word = _OF_USER[unit_of(name)]
        yield _input(f"user.{_plain(name)}", unit, f"{word} of user or load with {_plain(name)}")
    if system.hand is not None:
        for axis in system.hand.grip.axes:
            yield _input(f"handle.{axis}", "N", f"force of the user on the handle along {axis}, fixed in space")


def _input(name: str, unit: str, said: str) -> Variable:
    return Variable(name, "input", unit, said, 0.0)


def _acting(system: System, input_of: OpenInputs) -> Acted:
    """What acts on a machine: currents, rates of steering without servos, and a user."""
    mechanics, count = system.mechanics, len(system.motors)
    motors = input_of((count,))
    steering = input_of((len(mechanics.steered),))
    pushed = np.zeros((1, len(mechanics.coordinates)), dtype=object)
    pushed[:, : len(mechanics.configuration)] = input_of((1, len(mechanics.configuration)))
    force = None if system.hand is None else input_of((1, len(system.hand.grip.axes)))
    inputs = Inputs(
        currents=motors,
        steering=steering if system.servo is not None else np.zeros(0),
        turning=steering if system.servo is None else np.zeros(0),
        links=motors,
    )
    return inputs, Outside(pushed=Recorded(motors.tape, pushed), force=force)


class _Named:
    """Outputs of a machine, in the order in which they are read."""

    def __init__(self) -> None:
        self.outputs: list[Variable] = []
        self.columns: list[Any] = []

    def add(self, name: str, unit: str, said: str, column: Any) -> None:
        """One output; those that are the same number in all states are left out."""
        if isinstance(column, Value):
            self.outputs.append(Variable(name, "output", unit, said))
            self.columns.append(column)


def _read(system: System, named: _Named, balance: Balance, inputs: Inputs, state: Recorded) -> Mapping[str, Any]:
    """Outputs: the handle, voltages, energies, powers, losses and demands on limits."""
    mechanics, (first, second, _) = system.mechanics, system.places
    c, nu = state[:, :first], state[:, first:second]
    if system.hand is not None:
        held = system.hand.grip.at(c, nu)
        velocity = np.matmul(held.jacobian, nu[..., None])[..., 0]
        for place, axis in enumerate(system.hand.grip.axes):
            named.add(f"position.handle.{axis}", "m", f"position of the handle along {axis}", held.position[0, place])
            named.add(f"speed.handle.{axis}", "m/s", f"velocity of the handle along {axis}", velocity[0, place])
    shafts = system.shafts(inputs, state, system.steering(Outside(), state, inputs.turning)[1])
    for one in shafts:
        named.add(f"voltage.{one.name}", "V", f"voltage of {one.part}", one.voltage[0])
    energies = replace(system, hand=None).energies(np.zeros(1), state)
    for storage, column in zip(system.storages, energies[0], strict=False):
        named.add(f"energy.{storage}", "J", f"energy of motion and weight: {storage}", column)
    powers = balance.power[0].tolist()
    for source, column in zip(system.sources, powers, strict=False):
        named.add(f"power.{letters(source)}", "W", f"power supplied by {source}", column)
    for loss, column in zip(system.losses, powers[len(system.sources) :], strict=True):
        named.add(f"loss.{letters(loss)}", "W", f"power lost: {loss}", column)
    demands = [*zip(mechanics.demands, balance.demand[0].tolist(), strict=True)]
    demands += [(key, demand[0]) for one in shafts for key, demand in one.utilisation().items()]
    for (limit, part), column in demands:
        name, variable = demand_of(limit, part)
        named.add(name, "1", variable.description, column)
    return {"outputs": [named.columns]}
