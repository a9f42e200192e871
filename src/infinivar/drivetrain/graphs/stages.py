"""Bond-graph components of the output stages of a geared drive: pulley, screw, belt, rack and shaft."""

from __future__ import annotations

from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.graphs import compliances, pieces
from infinivar.errors import ParameterError
from infinivar.parts.gearhead import proportional_friction
from infinivar.units import plain

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


def check_inertias(drive: ConventionalDrive, load_mass: float, imposed_motion: bool) -> None:
    """Refuse what has no equations of motion: compliances without inertia beside them, and a self-locking stage that jams.

    Friction of a self-locking stage grows faster with the load's force than the torque of that force. If the load's inertia at
    the shaft, times how much the stage locks, exceeds the inertia that turns rigidly with the shaft, rigid bodies have no unique
    acceleration: the machine jams when the load drives it.

    Raises
    ------
    ParameterError
        If a value is missing or the drive jams; the message names the inertias.
    """
    stage, gear = drive.stage, drive.gearhead
    at_shaft = drive.gear_output_inertia or 0.0
    if stage.stiffness is not None and not (load_mass or imposed_motion):
        raise ParameterError(f"load_mass is missing: the stretch of the {stage.title} needs it")
    if gear.stiffness is not None and not at_shaft and (stage.stiffness is not None or not load_mass):
        raise ParameterError("output_inertia is missing: gearhead.stiffness needs it")
    backward = 1.0 if stage.efficiencies is None else float(stage.efficiencies[1])
    if backward >= 0.0 or stage.stiffness is not None:
        return
    if imposed_motion:
        raise ParameterError(f"link = 'imposed' cannot move a self-locking {stage.title}; use link = 'controlled'")
    turning = at_shaft + (0.0 if gear.stiffness is not None else compliances.rotor_inertia(drive))
    travel = float(stage.travel_per_radian)
    if turning + backward * load_mass * travel**2 <= 0.0:
        most = turning / (-backward * travel**2)
        raise ParameterError(
            f"load_mass must be < {plain(most, 3)} kg, got {plain(load_mass, 3)}: with a heavier load the self-locking "
            f"{stage.title} jams when the load drives it"
        )
