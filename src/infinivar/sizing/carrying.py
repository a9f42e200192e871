"""What a cost of carried mass does to the choice: power plus that cost, over all designs of the fronts.

A drive that its user carries costs more than its power. A sum of power and a multiple of the mass is least on the front of both,
so that the fronts have the answer for every cost.

Source: huang2014 for one such cost (metabolic, of a backpack, 7.6 W/kg); weighted sums for the rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from infinivar._core.described import derived, reported
from infinivar._core.result import Frozen, result
from infinivar.sizing.design import SizedDrive
from infinivar.units import show


@result
class Carried(Frozen):
    """The design of least power and cost of its mass, over a range of that cost.

    Attributes
    ----------
    cost       From which on it is the best, up to that of the next. [W/kg]
    template   Drive that it is like.
    power      [W]
    mass       [kg]
    """

    cost: float = reported("W kg^-1")
    template: str = reported()
    power: float = reported("W")
    mass: float = reported("kg")

    def at(self, cost: float) -> float:
        """Power and cost of the mass. [W/kg] -> [W]"""
        return self.power + cost * self.mass

    @derived()
    def words(self) -> str:
        """The design in short."""
        return f"{self.template}, {show(self.power, 'W', 3)} and {show(self.mass, 'kg', 3)}"


def best_carried(designs: Sequence[SizedDrive]) -> tuple[Carried, ...]:
    """The best of all designs found by what a kilogram costs to carry, from no cost to any.

    Source: lower envelope of the lines ``power + cost mass``.
    """
    every = [
        Carried(cost=0.0, template=one.template, power=one.power, mass=one.mass)
        for one in designs
        if math.isfinite(one.power) and math.isfinite(one.mass)
    ]
    if not every:
        return ()
    best = min(every, key=lambda one: (one.power, one.mass))
    found = [best]
    while lighter := [one for one in every if one.mass < best.mass]:
        crossing = [replace(one, cost=(one.power - best.power) / (best.mass - one.mass)) for one in lighter]
        best = min(crossing, key=lambda one: (one.cost, one.mass))
        found.append(best)
    return tuple(found)


def at_cost(designs: Sequence[Carried], cost: float) -> Carried:
    """The best design where a kilogram costs so much to carry. [W/kg]"""
    return [one for one in designs if one.cost <= cost][-1]


def carried_lines(designs: Sequence[Carried], cost: float | None) -> list[str]:
    """In words: from which cost on a drive like another template is the best, and what is the best at a stated cost."""
    turns = [one for one, before in zip(designs[1:], designs, strict=False) if one.template != before.template]
    lines = []
    if turns:
        over = ", ".join(f"{one.template} from {show(one.cost, 'W/kg', 3)} on" for one in turns)
        lines.append(f"If carrying a kilogram costs power: {designs[0].template}, {over}")
    if cost is not None and designs:
        best = at_cost(designs, cost)
        lines.append(f"At {show(cost, 'W/kg', 3)}: {best.words}, {show(best.at(cost), 'W', 3)} together")
    return lines
