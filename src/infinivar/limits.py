"""Operating limits, as data: a point outside one is a result with a name, not an error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum

from infinivar._core.array_namespace import Array, namespace


class Limit(IntEnum):
    """What binds at an operating point. The numbers are those stored in maps and NetCDF files."""

    OK = 0
    """Within every limit."""
    SLIP = 1
    """The contact would need more than mu P of lateral force, or no steady rolling solution exists."""
    THERMAL = 2
    """The motor current exceeds what its winding can carry continuously."""
    VOLTAGE = 3
    """The motor needs more than the supply voltage at this speed and torque."""
    STEERING = 4
    """The wheel would have to be steered beyond its mechanical range."""
    SPEED = 5
    """The motor turns faster than its permissible speed."""
    GEAR = 6
    """The gearhead carries more than its continuous output torque."""
    REGENERATION = 7
    """Electrical power comes back and the amplifier can neither burn nor store it."""
    YIELD = 8
    """The wheel's contact yields below its surface."""
    HARDNESS = 9
    """The mean pressure of the wheel's contact exceeds the indentation hardness."""
    BEARING = 10
    """An axle bearing carries more than its static rating."""
    PEAK = 11
    """The motor gives more torque than it bears for a moment."""
    TRAVEL = 12
    """The load moves further than its guideway lets it."""
    FLYWHEEL = 13
    """The cylinder, left to its inertia, would stop, or slow down so far that the wheel slips."""

    @property
    def words(self) -> str:
        """What a designer calls it."""
        return _WORDS[self]


_WORDS = {
    Limit.OK: "within limits",
    Limit.SLIP: "wheel slip",
    Limit.THERMAL: "motor continuous torque",
    Limit.VOLTAGE: "supply voltage",
    Limit.STEERING: "steering range",
    Limit.SPEED: "motor permissible speed",
    Limit.GEAR: "gearhead continuous torque",
    Limit.REGENERATION: "regeneration",
    Limit.YIELD: "contact yield",
    Limit.HARDNESS: "contact hardness",
    Limit.BEARING: "bearing static load",
    Limit.PEAK: "motor peak torque",
    Limit.TRAVEL: "travel",
    Limit.FLYWHEEL: "inertia as a flywheel",
}


Demand = tuple[Limit, str]
"""A limit and what it is a limit of: "motor", "steering motor", "wheel", "gearhead" ..."""


def words_of(demand: Demand) -> str:
    """What a designer calls a limit of a part: "steering motor: continuous torque", or "wheel slip" where that says it."""
    limit, what = demand
    if what in limit.words or what == "load":
        return limit.words
    return f"{what}: {limit.words.removeprefix('motor ')}"


def binding(utilisation: Mapping[Limit, Array]) -> tuple[Array, Array]:
    """Which limit binds, and how far away it is.

    Parameters
    ----------
    utilisation : mapping of Limit to (...,) float   Demand over allowance of each limit; 1 is the limit. nan where a
        quantity is not defined because the wheel slips. [-]

    Returns
    -------
    limit : (...,) int8     The limit with the largest utilisation where that exceeds 1, else Limit.OK. Slip comes
        before all others: without steady motion there is nothing else to name.
    margin : (...,) float   Allowance over demand of the tightest limit; below 1 outside, inf where nothing is demanded.
    """
    return _binding([(limit, int(limit), demand) for limit, demand in utilisation.items()])


def binding_demand(utilisation: Mapping[Demand, Array]) -> tuple[Array, Array]:
    """As `binding`, where one limit can stand for several parts: the limit is its place in the mapping, from 1."""
    return _binding([(limit, place, demand) for place, ((limit, _), demand) in enumerate(utilisation.items(), 1)])


def _binding(demands: Sequence[tuple[Limit, int, Array]]) -> tuple[Array, Array]:
    """The code that goes with the largest demand where that exceeds 1, else 0, and the margin."""
    xp = namespace(*(demand for _, _, demand in demands))
    worst, code = 0.0, 0
    for _, number, demand in demands:
        tighter = demand > worst
        worst = xp.where(tighter, demand, worst)
        code = xp.where(tighter, xp.asarray(number, dtype=xp.int8), xp.asarray(code, dtype=xp.int8))
    for limit, number, demand in demands:
        if limit == Limit.SLIP:
            slips = demand > 1.0
            worst = xp.where(slips, demand, worst)
            code = xp.where(slips, xp.asarray(number, dtype=xp.int8), code)
    margin = xp.where(worst > 0, 1.0 / xp.where(worst > 0, worst, 1.0), xp.inf)
    return xp.where(worst > 1.0, code, xp.asarray(0, dtype=xp.int8)), margin
