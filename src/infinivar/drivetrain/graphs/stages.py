"""Bond-graph components of the output stages of a geared drive: pulley, screw, belt, rack and shaft."""

from __future__ import annotations

from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.graphs import compliances, pieces
from infinivar.errors import ParameterError
from infinivar.parts.gear_law import proportional_friction
from infinivar.parts.gearhead import Gearhead
from infinivar.units import plain


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
    name, tag = stage.title, stage.letter
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
                None if not inertia else bg.inertia("J_gpc", "J_{gpc}", inertia, "kg m^2", title=name),
                pieces.friction(f"{name}_friction", f"T_{tag}", float(stage.shaft_friction), "N m", stick, name),
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
    """Raise ParameterError if a compliance has no inertia beside it, so that nothing determines the speed there."""
    stage, gear = drive.stage, drive.gearhead
    if stage.stiffness is not None and drive.output.has_series_spring:
        raise ParameterError(
            f"{stage.title}.specific_stiffness does not apply beside a series spring: no mass lies between them"
        )
    if stage.stiffness is not None and not (load_mass or imposed_motion):
        raise ParameterError(f"load_mass is missing: the stretch of the {stage.title} needs it")
    alone = stage.stiffness is not None or drive.output.has_series_spring or not load_mass
    if gear.stiffness is not None and not drive.gear_output_inertia and alone:
        raise ParameterError("output_inertia is missing: gearhead.stiffness needs it")


def check_gear_jamming(
    gear: Gearhead, turning: float, carried: float, field: str, imposed_motion: bool = False
) -> None:
    """Refuse a gearhead whose measured friction jams when the load drives it, by the inertias on both sides.

    Parameters
    ----------
    gear : Gearhead
    turning, carried : float   Inertia that turns rigidly with the motor, and with the output; both at the output. [kg m^2]
    field : str                Of the inertia of the load, for the message.
    imposed_motion : bool      Whether the motion of the output is imposed.

    Raises
    ------
    ParameterError
        If it jams; the message states the largest inertia.
    """
    most = gear.law().largest_returned
    if imposed_motion and most <= 1.0:
        raise ParameterError("link = 'imposed' cannot move a self-locking gearhead; use link = 'controlled'")
    if carried >= most * (turning + carried):
        raise ParameterError(
            f"{field} is too large: inertias at the gearhead's output must be < {plain(turning * most / (1.0 - most), 3)} kg m^2 "
            f"in all, got {plain(carried, 3)}; with more, the self-locking gearhead jams when the load drives it"
        )


def check_jamming(drive: ConventionalDrive, carried_mass: float, imposed_motion: bool) -> None:
    """Refuse a self-locking stage or gearhead that jams when the load drives it.

    Friction of a self-locking stage grows faster with the load's force than the torque of that force. If the load's inertia at
    the shaft, times how much the stage locks, exceeds the inertia that turns rigidly with the shaft, rigid bodies have no unique
    acceleration: the machine jams. `carried_mass` is the mass that the stage moves rigidly, 0 behind a series spring.

    Raises
    ------
    ParameterError
        If the drive jams; the message names the largest mass.
    """
    stage, travel = drive.stage, float(drive.stage.travel_per_radian)
    soft = stage.stiffness is not None or drive.output.has_series_spring
    forward, backward = (1.0, 1.0) if stage.efficiencies is None else map(float, stage.efficiencies)
    if drive.gearhead.stiffness is None:
        # What the stage loses on the way to the load adds to the load's share.
        rigid = drive.gear_output_inertia + (0.0 if soft else carried_mass * travel**2 / forward)
        field = "load_inertia" if stage.axis.rotary else "load_mass"
        check_gear_jamming(drive.gearhead, compliances.rotor_inertia(drive), rigid, field, imposed_motion and not soft)
    if backward >= 0.0 or soft:
        return
    if imposed_motion:
        raise ParameterError(f"link = 'imposed' cannot move a self-locking {stage.title}; use link = 'controlled'")
    turning = drive.gear_output_inertia
    if drive.gearhead.stiffness is None:
        turning += compliances.rotor_inertia(drive) / drive.gearhead.largest_load_factor
    elif not turning:
        raise ParameterError(
            f"output_inertia is missing: a self-locking {stage.title} behind gearhead.stiffness jams without it"
        )
    if turning + backward * carried_mass * travel**2 <= 0.0:
        most = turning / (-backward * travel**2)
        if turning == 0.0:
            raise ParameterError(
                f"output_inertia must be > 0 kg m^2 with a self-locking {stage.title} behind gearhead.stiffness, or "
                f"leave that out: no inertia but that of the load is at the {stage.title}, which jams when the load drives it"
            )
        where = "" if drive.output.linkage is None else " at the screw"
        raise ParameterError(
            f"load_mass must be < {plain(most, 3)} kg{where}, got {plain(carried_mass, 3)}: with a heavier load the "
            f"self-locking {stage.title} jams when the load drives it"
        )
