"""Start of a run with springs and a linkage: what a scenario must give, and the initial states."""

from __future__ import annotations

from typing import Any

from infinivar.bondgraph.causality import assign
from infinivar.bondgraph.graph import BondGraph
from infinivar.drivetrain.graphs.output_pieces import names
from infinivar.drivetrain.output import Output, Place
from infinivar.errors import ParameterError
from infinivar.motion.motion import MotionState
from infinivar.motion.scenario import Scenario
from infinivar.parts.linkage import Linkage
from infinivar.parts.spring import TorsionSpring
from infinivar.units import show_in


def check(output: Output, scenario: Scenario) -> None:
    """Refuse a start at a dead centre, and a load without mass where it would determine a deflection that only a mass can.

    Raises
    ------
    ParameterError
        If the linkage cannot move the load at its start, if the force on a massless load would have to set the deflection of a
        spring that is not linear, or the force jumps.
    """
    start = scenario.path.at(0.0).position
    if output.linkage is not None and bool(output.linkage.beyond_reach(start)):
        raise ParameterError(
            f"the motion starts at {show_in(start, 'rad', 'deg')}, at or beyond a dead centre of the drive's linkage: change "
            "the linkage's offset, or where the motion starts"
        )
    if scenario.moved_mass or scenario.link == "imposed":
        return
    first = next((place for place in output.chain if place.kind == "series"), None)
    if first is None:
        return
    assert not isinstance(first.part, Linkage)
    rotary = isinstance(output.chain[0].part, (Linkage, TorsionSpring))
    key, what = ("load_inertia", "moment of inertia") if rotary else ("load_mass", "mass")
    if first.part.shape != "linear":
        raise ParameterError(
            f"{key} is missing: a {first.part.shape} {first.name} can be simulated only with a {what} at its end"
        )
    if scenario.force is not None and scenario.force.breaks:
        raise ParameterError(
            f"{key} is missing: the force jumps at {scenario.force.breaks[0]:g} s, and without a {what} the {first.name} "
            f"would have to jump with it"
        )


def states(output: Output, graph: BondGraph, load: MotionState, force: float) -> dict[str, float]:
    """Initial states of load, springs and linkage.

    Parameters
    ----------
    output, graph
    load : MotionState    Of the load at the start.
    force : float         Planned force on the load. [N] or [N m]
    """
    found = {"load": load.position, "load_mass": load.speed}
    position: Any = load.position
    for place in output.chain:
        if isinstance(place.part, Linkage):
            found["joint"] = float(position)
            position, arm = place.part.derivatives(position, 1)
            force = force / float(arm)
            continue
        found[names(place).elastic] = _displacement(place, float(position), force)
        if place.kind == "parallel":
            force = force + float(place.part.force(position))
        else:
            position = position + place.part.deflection(force)
    known = {*assign(graph).independent, *(signal.name for signal in graph.signals if signal.integral)}
    return {name: float(value) for name, value in found.items() if name in known}


def _displacement(place: Place, position: float, force: float) -> float:
    """Displacement of a spring's C at the start: the deflection, of a linear spring from its free state."""
    spring = place.part
    assert not isinstance(spring, Linkage)
    if spring.shape == "linear":
        assert spring.stiffness is not None
        return (float(spring.force(position)) if place.kind == "parallel" else force) / spring.stiffness
    return position if place.kind == "parallel" else float(spring.deflection(force))


def carried(output: Output, position: float, mass: float) -> float:
    """Part of the load's mass that moves rigidly with the drive, at the drive; 0 behind a series spring. [kg] or [kg m^2]"""
    for place in output.chain:
        if place.kind == "series":
            return 0.0
        if isinstance(place.part, Linkage):
            arm = float(place.part.derivatives(position, 1)[1])
            mass = mass / arm**2
    return mass
