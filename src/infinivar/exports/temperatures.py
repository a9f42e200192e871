"""Temperatures of motors as states of a plant: they follow its losses, and do not act on it.

The plant keeps the resistance of its windings; heat counts with that at the temperature of the winding, as in duty cycles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from infinivar.bondgraph.graph import Parameter
from infinivar.bondgraph.tape import Number
from infinivar.exports.variables import Variable, demand_of, letters
from infinivar.limits import Limit
from infinivar.parts import heat
from infinivar.parts.heat_steps import REFERENCE, Nodes, warmth
from infinivar.parts.motor import Motor

AMBIENT = "ambient_temperature"
"""Symbol of a parameter."""

_UNITS = dict(zip(heat.NEEDED, ("K/W", "K/W", "s", "s", "K"), strict=True))


class Warmed(NamedTuple):
    """What warms a motor."""

    what: str
    nodes: Nodes
    permissible: Any
    """Temperature of the winding. [K]"""
    winding_loss: Number
    """With the resistance of the plant. [W]"""
    friction_power: Number
    """[W]"""


def with_data(motors: Mapping[str, Motor]) -> dict[str, Motor]:
    """Motors with thermal data, by their names in demands."""
    return {what: motor for what, motor in motors.items() if not heat.missing(motor)}


def parameters(motors: Mapping[str, Motor]) -> dict[str, Parameter]:
    """Thermal data of motors, and the ambient temperature, by their symbols."""
    known = {
        f"{name} {what}": Parameter(f"{name} {what}", getattr(motor, name), unit)
        for what, motor in with_data(motors).items()
        for name, unit in _UNITS.items()
    }
    return {**known, AMBIENT: Parameter(AMBIENT, REFERENCE, "K")} if known else {}


def warmed(what: str, get: Callable[[str], Any], winding_loss: Number, friction_power: Number) -> Warmed:
    """What warms a motor whose fields, numbers or values of parameters, a function gets."""
    *nodes, permissible = map(get, heat.NEEDED)
    return Warmed(what, Nodes(*nodes), permissible, winding_loss, friction_power)


def states(motors: Iterable[str]) -> Iterator[Variable]:
    """Yield the temperatures of winding and housing of each motor."""
    for what in motors:
        for node in ("winding", "housing"):
            said = f"temperature of the {node}: {what}"
            yield Variable(f"temperature.{node}.{letters(what)}", "state", "K", said, REFERENCE)


def demands(
    motors: Iterable[Warmed], temperatures: Sequence[Number], ambient: Number
) -> Iterator[tuple[Variable, Number]]:
    """Yield the rise of each winding over the permissible rise."""
    for one, winding in zip(motors, temperatures[::2], strict=True):
        yield demand_of(Limit.TEMPERATURE, one.what), (winding - ambient) / (one.permissible - ambient)


def rates(motors: Iterable[Warmed], temperatures: Sequence[Number], ambient: Number) -> Iterator[Number]:
    """Yield the rates of the temperatures, in the order of `states`. [K/s]"""
    for one, winding, housing in zip(motors, temperatures[::2], temperatures[1::2], strict=True):
        loss = one.winding_loss * warmth(winding)
        yield from one.nodes.rates(loss, one.friction_power, winding, housing, ambient)
