"""Bond-graph components of the output stages of a geared drive: pulley, screw, belt, rack and shaft."""

from __future__ import annotations

from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.graphs import pieces
from infinivar.parts.gearhead import proportional_friction

SYMBOLS = {"pulley": "p", "screw": "s", "belt": "b", "rack": "r", "shaft": "o"}
"""Subscripts of the stages."""


def output_stage(drive: ConventionalDrive, stick_speed: float) -> tuple[list[Element], list[str], list[Signal], str]:
    """The 1-junction of the stage's shaft with its inertia and friction, and its transformer.

    Parameters
    ----------
    drive : ConventionalDrive
    stick_speed : float   Speed of the load below which friction sticks. [m s^-1]

    Returns
    -------
    elements, chains, signals, path   Path: the chain from the shaft to the load's junction, exclusive.
    """
    stage = drive.stage
    name, tag = stage.title, SYMBOLS[stage.title]
    stick = Parameter(rf"\varepsilon_{tag}", stick_speed / float(stage.travel_per_radian), "rad/s")
    signals: list[Signal] = []
    loss = None
    if stage.efficiencies is not None and min(stage.efficiencies) < 1.0:
        passed = f"{name}_torque"
        signals.append(Signal(name=passed, symbol=f"T_{{{tag}}}", of=f"r_{name}"))
        parameters = {
            "efficiency": Parameter(rf"\eta_{tag}", float(stage.efficiencies[0])),
            "backdriving_efficiency": Parameter(rf"\eta'_{tag}", float(stage.efficiencies[1])),
            "stick_speed": stick,
        }
        loss = bg.resistance(
            f"{name}_loss",
            f"T_{{l,{tag}}}",
            proportional_friction,
            signals=(passed,),
            parameters=parameters,
            title=name,
        )
    inertia = drive.gear_output_inertia
    attached, chains = pieces.attach(
        **{
            name: (
                None if inertia is None else bg.inertia("J_gpc", "J_{gpc}", inertia, "kg m^2", title=name),
                pieces.friction(f"{name}_friction", f"T_{tag}", float(stage.friction_torque), "N m", stick, name),
                loss,
            )
        }
    )
    elements = [*attached, bg.one(name, rf"\omega_{tag}")]
    if stage.axis.rotary:
        return elements, chains, signals, name
    elements.append(bg.transformer(f"r_{name}", f"r_{tag}", float(stage.travel_per_radian), "m"))
    return elements, chains, signals, f"{name} > r_{name}"
