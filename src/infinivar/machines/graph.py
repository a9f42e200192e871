"""Bond graphs of machines of many contacts, from the description that their equations of motion have.

A kind gives its coordinates with their mass matrix, its contacts with their rows of the Jacobian and the gyrators of axes that
turn, see `infinivar.machines.bonds`; motors and servos come from the same parts. The tests compare both at random states, and
whole motions of the machines with a constant Jacobian.
"""

from __future__ import annotations

from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import BondGraph, Signal
from infinivar.errors import ParameterError
from infinivar.machines.bonds import motor_plant, servo_plant
from infinivar.machines.kind import MovingMachine
from infinivar.machines.registry import MACHINES


def machine_graph(
    machine: MovingMachine, *, stick_speed: float = 1e-4, servos: bool = True, source: bool = True
) -> BondGraph:
    """The bond graph of a machine that moves.

    Parameters
    ----------
    machine : PlatformMachine, ArmMachine, SerialArmMachine, PlanarMachine or SphereMachine
    stick_speed : float    Speed below which friction sticks. [m s^-1]
    servos : bool          Whether servos steer the wheels; without, the angles are inputs.
    source : bool          Whether the power motor is part of it.

    Returns
    -------
    BondGraph
        Inputs are forces of the user ("user_1" ...), currents of motor ("motor.source") and servos ("servo_1.source" ...) or
        angles ("phi_1" ...). For a platform the entries of the Jacobian ("J_11" ...) are inputs as well, of which the rates
        count: its body turns in its own axes, so that they are those of an angular velocity in these axes.

    Raises
    ------
    ParameterError
        If it is another machine, a value that motion requires is missing, or a contact turns with spin, which these graphs do
        not have.
    """
    if not isinstance(machine, MovingMachine):
        names = ", ".join(MACHINES)
        raise ParameterError(f"machine must be one of {names}, got a {type(machine).__name__}")
    if machine.ungraphed:
        raise ParameterError(machine.ungraphed)
    if any(contact.turns_with_spin for contact in machine.contacts):
        raise ParameterError(
            "steering_model must be 'shear' for the bond graph of a machine of many contacts, got 'spin'; simulate_machine "
            "has contacts that turn with spin"
        )
    elements, chains, signals = machine.bonds(stick_speed)
    steered = range(1, len(machine.mechanics(stick_speed).steered) + 1)
    servo = machine.servo(stick_speed) if servos else None
    parts: dict[str, BondGraph] = {}
    if servo is None:
        signals = [*signals, *(Signal(name=f"phi_{place}", symbol=rf"\phi_{{{place}}}") for place in steered)]
    else:
        parts |= {f"servo_{place}": servo_plant(servo, place) for place in steered}
    motor = machine.power_motor(stick_speed) if source else None
    if motor is not None:
        parts["motor"] = motor_plant(motor)
        chains = [*chains, f"motor.shaft > {machine.driven}"]
    return bg.join(type(machine).__name__, parts, chains, elements=elements, signals=signals)
