"""Springs and linkage between a drive and its load as bond graphs.

Between the drive's 1-junction and that of the load, each element of `infinivar.drivetrain.output.Output.chain` becomes:

- a parallel spring: a C at the 1-junction, whose displacement is the position there;
- a series spring: a C at a 0-junction between two 1-junctions, whose displacement is the difference of their positions;
- a linkage: a transformer modulated by the joint angle, the integral of a 1-junction's flow;
- hysteresis of a spring: a C of stiffness sigma beside a conductance ``|x'|/F_c`` at a 0-junction, in parallel with the spring.
  Both flows add up to the deflection speed: ``x' = z'/sigma + |x'| z/F_c``, which is Dahl's law; the conductance never is
  negative, so the element is passive.

A linear spring is a linear C: its displacement is the deflection from the free state, ``F/k``, so preload counts as stored
energy. The law of another spring keeps the deflection itself.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import given
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter, Signal
from infinivar.drivetrain.graphs import pieces
from infinivar.drivetrain.output import Output, Place
from infinivar.parts.linkage import Linkage
from infinivar.parts.spring import Spring, TorsionSpring

AnySpring = Spring | TorsionSpring

_TAGS = {
    "parallel spring": "p",
    "series spring": "s",
    "parallel torsion spring": r"p,\theta",
    "series torsion spring": r"s,\theta",
}


class Spliced(NamedTuple):
    """Elements of an output, chains of bonds between them and to both ends, and signals."""

    elements: list[Element]
    chains: list[str]
    signals: list[Signal]


@dataclass(frozen=True, slots=True)
class Held:
    """Elements of one spring: the names of its elastic C, and of the C and conductance of its hysteresis; "" for none."""

    elastic: str
    bristle: str
    yielding: str


def names(place: Place) -> Held:
    """Names of the elements of a spring of the chain."""
    name = place.name.replace(" ", "_")
    assert not isinstance(place.part, Linkage)
    if not place.part.hysteretic:
        return Held(name, "", "")
    return Held(name, f"{name}_hysteresis", f"{name}_yield")


def between(output: Output, drive: str, load: str) -> Spliced:
    """Elements between the 1-junctions of a drive and of its load, with signals for the load's motion.

    Parameters
    ----------
    output : Output
    drive, load : str   Names of the 1-junctions; they may be the same if `output` has parallel springs only.

    Returns
    -------
    Spliced   With the signals "load" (position of the load) and "load_rate" if `output` has any element.
    """
    spliced = Spliced([], [], [])
    through = sum(place.kind != "parallel" for place in output.chain)
    here = load
    for place in output.chain:
        if place.kind == "parallel":
            _parallel(spliced, place, here)
            continue
        through -= 1
        # The 1-junction on the drive's side of this element.
        there = f"{place.name.replace(' ', '_')}_end" if through else drive
        if through:
            spliced.elements.append(bg.one(there))
        if place.kind == "linkage":
            _linkage(spliced, place, there, here, "load" if here == load else "joint")
        else:
            _series(spliced, place, there, here)
        here = there
    if here != drive:
        spliced.chains.append(f"{drive} > {here}")
    if output.chain:
        spliced.signals.append(Signal(name="load", symbol=_position(output), of=load, integral=True))
        spliced.signals.append(Signal(name="load_rate", symbol=speed_symbol(output), of=load))
    return spliced


def drive_end(output: Output) -> str:
    """Name of the drive's 1-junction: that of the load if only parallel springs are between them."""
    return "line" if any(place.kind != "parallel" for place in output.chain) else "load"


def speed_symbol(output: Output) -> str:
    """Symbol of the load's speed: that of the drive's line if the drive moves the load directly."""
    return rf"\dot{{{_position(output)}}}" if output.chain else r"\dot{l}"


def _position(output: Output) -> str:
    return "x" if output.linkage is None else r"\theta"


def _parallel(spliced: Spliced, place: Place, at: str) -> None:
    spliced.elements.append(_elastic(place))
    spliced.chains.append(f"{at} > {names(place).elastic}")
    _hysteresis(spliced, place, at)


def _series(spliced: Spliced, place: Place, drive: str, load: str) -> None:
    """A spring at a 0-junction; with hysteresis at a 1-junction of the deflection, which both branches share."""
    assert not isinstance(place.part, Linkage)
    node, held = f"{place.name.replace(' ', '_')}_node", names(place)
    spliced.elements.append(bg.zero(node))
    spliced.chains.append(f"{drive} > {node} > {load}")
    at = node
    if held.bristle:
        at = f"{node}_rate"
        spliced.elements.append(bg.one(at))
        spliced.chains.append(f"{node} > {at}")
    spliced.elements.append(_elastic(place))
    spliced.chains.append(f"{at} > {held.elastic}")
    _hysteresis(spliced, place, at)


def _elastic(place: Place) -> Element:
    spring, name, tag = place.part, names(place).elastic, _TAGS[place.name]
    assert not isinstance(spring, Linkage)
    turning = isinstance(spring, TorsionSpring)
    if spring.shape == "linear":
        assert spring.stiffness is not None
        unit = "rad/(N m)" if turning else "m/N"
        return bg.compliance(name, f"c_{{{tag}}}", 1.0 / spring.stiffness, unit, title=place.name)
    return bg.compliance(
        name,
        f"{'M' if turning else 'F'}_{{{tag}}}",
        functools.partial(_force, spring),
        energy=functools.partial(_energy, spring),
        title=place.name,
    )


def _hysteresis(spliced: Spliced, place: Place, at: str) -> None:
    """Dahl's friction at the 1-junction of the deflection speed."""
    spring, held, tag = place.part, names(place), _TAGS[place.name]
    if isinstance(spring, Linkage) or spring.hysteresis is None or not spring.hysteretic:
        return
    node, rate = f"{held.elastic}_friction", f"{held.elastic}_rate"
    turning = isinstance(spring, TorsionSpring)
    unit, travel = ("N m", "rad/(N m)") if turning else ("N", "m/N")
    largest = {"largest": Parameter(f"z^0_{{{tag}}}", spring.hysteresis, unit)}
    bristle = spring.hysteresis_travel / spring.hysteresis
    elements = [
        bg.zero(node, f"z_{{{tag}}}"),
        bg.compliance(held.bristle, f"c_{{z,{tag}}}", bristle, travel, title=f"{place.name} hysteresis"),
        bg.conductance(
            held.yielding,
            f"w_{{{tag}}}",
            _yield_speed,
            signals=(rate,),
            parameters=largest,
            title=f"{place.name} hysteresis",
        ),
    ]
    spliced.elements.extend(elements)
    spliced.chains.extend([f"{at} > {node} > {held.bristle}", f"{node} > {held.yielding}"])
    spliced.signals.append(Signal(name=rate, symbol=rf"\dot{{q}}_{{{tag}}}", of=at))


def _linkage(spliced: Spliced, place: Place, drive: str, load: str, joint: str) -> None:
    """A transformer whose ratio, joint speed over drive speed, is the inverse of the lever arm at the joint angle."""
    assert isinstance(place.part, Linkage)
    spliced.chains.append(f"{drive} > linkage > {load}")
    if place.part.shape == "lever":
        spliced.elements.append(pieces.gear("linkage", r"r_\theta", given(place.part.arm, 1.0), "m"))
        return
    law = functools.partial(_joint_per_drive, place.part)
    spliced.elements.append(bg.transformer("linkage", r"1/r_\theta", law, signals=(joint,), title="linkage"))
    if joint != "load":
        spliced.signals.append(Signal(name=joint, symbol=r"\theta_J", of=load, integral=True))


def _force(spring: AnySpring, deflection: Array) -> Array:
    return spring.force(deflection)


def _energy(spring: AnySpring, deflection: Array) -> Array:
    return spring.energy(deflection)


def _yield_speed(force: Array, speed: Array, largest: Array) -> Array:
    """Flow of the conductance: what hysteresis gives way at its force and the speed of the deflection.

    Source: dahl1968.
    """
    return namespace(force, speed, largest).abs(speed) * force / largest


def _joint_per_drive(linkage: Linkage, angle: Array) -> Array:
    return 1.0 / linkage.derivatives(angle, 1)[1]
