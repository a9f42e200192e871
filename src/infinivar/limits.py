"""Operating limits as data: an infeasible point is a result that names its limit, not an error."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from enum import IntEnum, unique
from typing import Any

from infinivar._core import plugins
from infinivar._core.array_namespace import Array, namespace
from infinivar.errors import InputError, ParameterError, require


@unique
class Limit(IntEnum):
    """Limit that an operating point exceeds. Maps and NetCDF files store the integer values."""

    OK = 0
    """Within every limit."""
    SLIP = 1
    """Wheel slip: the lateral force required exceeds mu P, or no steady rolling solution exists."""
    THERMAL = 2
    """The motor current exceeds the continuous current of the winding."""
    VOLTAGE = 3
    """The motor voltage required at this speed and torque exceeds the supply voltage."""
    STEERING = 4
    """The steering angle required exceeds the mechanical range."""
    SPEED = 5
    """The motor speed exceeds the permissible speed."""
    GEAR = 6
    """The output torque of the gearhead exceeds its continuous rating."""
    REGENERATION = 7
    """The motor returns electrical power that the amplifier can neither dissipate nor store."""
    YIELD = 8
    """The wheel contact yields below the surface."""
    HARDNESS = 9
    """The mean contact pressure exceeds the indentation hardness."""
    BEARING = 10
    """The load on an axle bearing exceeds its static rating."""
    PEAK = 11
    """The motor torque exceeds the peak torque."""
    TRAVEL = 12
    """The load travels beyond the end of its guideway."""
    FLYWHEEL = 13
    """A free-running cylinder would stop, or slow down until the wheel slips."""
    SPRING = 14
    """A spring deflects beyond its table or its permissible force, or a one-sided series spring would have to pull."""
    LINKAGE = 15
    """The joint turns beyond a dead centre of its linkage, or beyond the table of lever arms."""
    OUTPUT_FORCE = 16
    """The force or torque exceeds what the output stage permits."""
    OUTPUT_SPEED = 17
    """The shaft speed exceeds what the output stage permits."""
    CRITICAL_SPEED = 18
    """The speed of a screw is too near its first critical speed in bending."""
    BUCKLING = 19
    """A screw under compression buckles."""
    LIFE = 20
    """The rolling-contact life of a screw is shorter than required."""
    TEMPERATURE = 21
    """The winding becomes hotter than permissible. Counts rises above ambient; only over a motion, never at a point."""
    GEAR_PEAK = 22
    """The output torque of the gearhead exceeds its intermittent rating."""
    GEAR_SPEED = 23
    """The motor turns faster than the gearhead permits at its input."""
    GEAR_MOMENTARY = 24
    """The output torque of a strain-wave gear exceeds what it withstands a few times in its life."""
    RATCHETING = 25
    """The teeth of a strain-wave gear skip under its output torque."""
    DEMAGNETISATION = 26
    """The motor current would demagnetise the magnets for good."""
    WALL = 27
    """The wall of the cylinder yields under the wheel."""
    AXLE = 28
    """The bending stress of the wheel's axle exceeds what is permitted."""
    CLEARANCE = 29
    """The bearings of the wheel's axle are larger than the wheel, and touch what it rolls on."""
    SUPPORT = 32
    """The static load on a bearing of the cylinder exceeds its rating."""
    JOURNAL = 33
    """The shaft in the bearings of the cylinder is overstressed by bending and torsion."""
    SHAFT = 34
    """A pulley or pinion is thinner than the shaft in the bearings that carry its pull."""
    SPACE = 30
    """The drive is larger than its envelope."""
    MASS = 31
    """The drive is heavier than its envelope permits."""
    BATTERY = 35
    """The current exceeds what the battery gives, or what may charge it."""

    @property
    def words(self) -> str:
        """Name in a designer's terms."""
        return _WORDS[self]

    @classmethod
    def own(cls, name: str, code: int, words: str) -> Limit:
        """Return a limit of another package, which maps, files and reports then know like those of the program.

        Parameters
        ----------
        name : str    In capitals, such as "TENDON": its name in files.
        code : int    100 to 127, unique among the packages that you use: maps store it.
        words : str   Name in a designer's terms, such as "tendon strength".

        Returns
        -------
        Limit   The same for the same arguments.

        Raises
        ------
        ParameterError
            If an argument is out of range, or another limit has the name or the code.
        """
        return _own(name, code, words)

    @classmethod
    def every(cls) -> tuple[Limit, ...]:
        """All limits, those of other packages last."""
        return (*cls, *_OWN.values())

    @classmethod
    def _missing_(cls, value: object) -> Limit:
        """A limit of another package, by its code; packages may register it as an entry point."""
        if isinstance(value, int) and value not in _OWN:
            for name in plugins.registered("infinivar.limits"):
                with contextlib.suppress(InputError):  # of another limit than this one
                    plugins.load("infinivar.limits", name, _not_a_limit)
        if value in _OWN:
            return _OWN[value]  # type: ignore[index]
        raise ValueError(f"{value!r} is not the code of a limit; {_HOW}")

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        """Pickle a limit of another package with all that registers it anew."""
        return (_own, (self.name, self.value, self.words)) if self.value in _OWN else (Limit, (self.value,))


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
    Limit.SPRING: "spring travel",
    Limit.LINKAGE: "linkage range",
    Limit.OUTPUT_FORCE: "permissible output force",
    Limit.OUTPUT_SPEED: "permissible output speed",
    Limit.CRITICAL_SPEED: "critical speed",
    Limit.BUCKLING: "buckling",
    Limit.LIFE: "rated life",
    Limit.TEMPERATURE: "motor winding temperature",
    Limit.GEAR_PEAK: "gearhead intermittent torque",
    Limit.GEAR_SPEED: "gearhead input speed",
    Limit.GEAR_MOMENTARY: "gearhead momentary torque",
    Limit.RATCHETING: "gearhead ratcheting torque",
    Limit.DEMAGNETISATION: "motor demagnetisation current",
    Limit.WALL: "cylinder wall",
    Limit.AXLE: "axle strength",
    Limit.CLEARANCE: "clearance of the axle bearings",
    Limit.SUPPORT: "static load of the cylinder bearings",
    Limit.JOURNAL: "journal strength of the cylinder",
    Limit.SHAFT: "room for the shaft of the pulley",
    Limit.SPACE: "envelope",
    Limit.MASS: "mass limit",
    Limit.BATTERY: "battery current",
}


def codes(_: Any = None) -> dict[str, Any]:
    """CF attributes that explain the integer codes of limits in a data set."""
    import numpy as np

    return {
        "flag_values": np.array([limit.value for limit in Limit.every()], dtype=np.int8),
        "flag_meanings": " ".join(limit.name for limit in Limit.every()),
    }


LEADING = (Limit.SLIP, Limit.LINKAGE)
"""Limits that take precedence where they are exceeded, the last one first: without motion other demands are undefined."""

ROOT_MEAN_SQUARE = (Limit.THERMAL, Limit.GEAR)
"""Limits on heating or fatigue: over a motion they apply to the root mean square instead of the peak."""

_OWN: dict[int, Limit] = {}
"""Limits of other packages, by code."""

_CODES = range(100, 128)
"""Codes of limits of other packages; maps store codes in one byte."""

_HOW = "a limit of another package is registered by Limit.own before it is used"


def _own(name: str, code: int, words: str) -> Limit:
    """Register a limit; see `Limit.own`."""
    usable = isinstance(name, str) and name.isidentifier() and name.isascii() and name.isupper()
    require(usable, "name", repr(name), "in capitals, such as 'TENDON'")
    require(isinstance(words, str) and bool(words.strip()), "words", repr(words), "text that is not empty")
    known = isinstance(code, int) and not isinstance(code, bool) and code in _CODES
    require(known, "code", repr(code), f"from {_CODES[0]} to {_CODES[-1]}")
    for other in Limit.every():
        if other.value == code or other.name == name:
            if (other.value, other.name, other.words) == (code, name, words):
                return other
            raise ParameterError(
                f"the limit {name} with code {code} and words {words!r} clashes with {other.name} with code {other.value} and "
                f"words {other.words!r}"
            )
    made = int.__new__(Limit, code)
    made._name_, made._value_ = name, code
    _OWN[code], _WORDS[made] = made, words
    return made


def _not_a_limit(loaded: Any) -> str | None:
    return None if isinstance(loaded, Limit) and loaded.value in _OWN else "a limit made by Limit.own"


Demand = tuple[Limit, str]
"""A limit and the part it belongs to: "motor", "steering motor", "wheel", "gearhead" ..."""


def words_of(demand: Demand) -> str:
    """Limit of a part in a designer's terms: "steering motor: continuous torque", or "wheel slip" if that is enough."""
    limit, what = demand
    if what in limit.words or what == "load":
        return limit.words
    return f"{what}: {limit.words.removeprefix('motor ')}"


def binding(utilisation: Mapping[Limit, Array]) -> tuple[Array, Array]:
    """Find the tightest limit and its margin.

    Parameters
    ----------
    utilisation : mapping of Limit to (...,) float   Demand over allowance for each limit; 1 is at the limit. nan where a
        quantity is undefined because the wheel slips or a linkage cannot reach. [-]

    Returns
    -------
    limit : (...,) int8     The limit with the largest utilisation if that exceeds 1, else Limit.OK. A linkage out of reach,
        then slip take precedence: without motion the other demands are undefined.
    margin : (...,) float   Allowance over demand for the tightest limit; below 1 if infeasible, inf without any demand.
    """
    return _binding([(limit, int(limit), demand) for limit, demand in utilisation.items()])


def binding_demand(utilisation: Mapping[Demand, Array]) -> tuple[Array, Array]:
    """As `binding`, for limits of several parts: the code is the limit's position in the mapping, counted from 1."""
    return _binding([(limit, place, demand) for place, ((limit, _), demand) in enumerate(utilisation.items(), 1)])


def _binding(demands: Sequence[tuple[Limit, int, Array]]) -> tuple[Array, Array]:
    """Code of the largest demand where it exceeds 1, else 0, and the margin."""
    xp = namespace(*(demand for _, _, demand in demands))
    worst, code = 0.0, 0
    for _, number, demand in demands:
        tighter = demand > worst
        worst = xp.where(tighter, demand, worst)
        code = xp.where(tighter, xp.asarray(number, dtype=xp.int8), xp.asarray(code, dtype=xp.int8))
    for leading in LEADING:
        for limit, number, demand in demands:
            if limit == leading:
                leads = demand > 1.0
                worst = xp.where(leads, demand, worst)
                code = xp.where(leads, xp.asarray(number, dtype=xp.int8), code)
    margin = xp.where(worst > 0, 1.0 / xp.where(worst > 0, worst, 1.0), xp.inf)
    return xp.where(worst > 1.0, code, xp.asarray(0, dtype=xp.int8)), margin
