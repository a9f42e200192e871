"""Bond graphs of the power motor and the steering servos of a machine of many contacts."""

from __future__ import annotations

from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import BondGraph, Parameter, Signal
from infinivar.drivetrain.graphs import pieces
from infinivar.drivetrain.moving.motors import PowerMotor, SteeringServo


def servo_plant(servo: SteeringServo, number: int) -> BondGraph:
    """Motor, gear and bell of one steered axis; measures its angle as "phi_<number>".

    Source: faulring2006, Fig 11.
    """
    plant, motor = servo.plant, servo.plant.motor
    stick = Parameter(r"\varepsilon_s", servo.stick_speed, "rad/s")
    motor_stick = Parameter(r"\varepsilon_{m,s}", servo.stick_speed * plant.ratio, "rad/s")
    elements, chains, _ = pieces.motor_terminals(
        motor, servo.amplifier, f"{{s{number}}}", "current", motor_stick, "steering", "steering."
    )
    bell = (
        pieces.friction("bearing", rf"T_{{b,{number}}}", servo.bell_friction, "N m", stick, "steering bearing"),
        pieces.friction("patch", rf"T_{{p,{number}}}", servo.patch_friction, "N m", stick, "steering patch"),
    )
    attached, attached_chains = pieces.attach(bell=bell)
    return BondGraph(
        f"Steering {number}",
        [
            *elements,
            bg.one("bell", rf"\dot{{\phi}}_{{{number}}}"),
            bg.inertia("J_b", "J_b", plant.bell_inertia, "kg m^2", title="bell"),
            pieces.gear("gear", "n_s", plant.ratio),
            *attached,
        ],
        [*chains, "rotor > gear > bell > J_b", *attached_chains],
        [
            Signal(name=f"phi_{number}", symbol=rf"\phi_{{{number}}}", of="bell", integral=True),
            Signal(name=f"phi_rate_{number}", symbol=rf"\dot{{\phi}}_{{{number}}}", of="bell"),
        ],
    )


def motor_plant(motor: PowerMotor) -> BondGraph:
    """The power motor with its gearhead, open at "shaft".

    Source: faulring2006, Fig 12.
    """
    stick = Parameter(r"\varepsilon_{m,c}", motor.stick_speed, "rad/s")
    elements, chains, signals = pieces.motor_terminals(motor.motor, motor.amplifier, "c", "current", stick, "", "")
    gear, gear_chains, gear_signals = pieces.gearhead(motor.gearhead, motor.motor, "c", stick)
    return BondGraph(
        "Power motor",
        [*elements, *gear, bg.one("shaft")],
        [*chains, *gear_chains, "rotor > gear > shaft"],
        [*signals, *gear_signals],
    )
