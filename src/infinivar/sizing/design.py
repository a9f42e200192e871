"""A design that a search found: parts, values chosen from ranges, and what it demands."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from infinivar._core.described import derived, reported, rows
from infinivar._core.result import Frozen, result
from infinivar.drivetrain.body import total
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive
from infinivar.drivetrain.masses import bodies_of
from infinivar.drivetrain.service import NO_SERVICE
from infinivar.limits import Demand, Limit
from infinivar.sizing.geared.tally import SPARE
from infinivar.sizing.margins import TaskDemand, margin_of, tightest_of
from infinivar.sizing.pool import ChosenPart
from infinivar.units import margin_words, plain, show, show_in, times

STEERING_MOTOR, STEERING_RATIO, WHEELS = "steering.motor", "steering.ratio", "transmission.wheels"
AXLE_BEARING, CYLINDER_BEARING = "transmission.geometry.axle_bearing", "cylinder_bearings.bearing"
"""Paths of parts and values of a cobotic drive."""

COBOTIC_PATHS = {
    "cylinder_radius": "transmission.cylinder_radius",
    "cylinder_speed": "cylinder_speed",
    "wheel_radius": "transmission.wheel_radius",
    "crown_radius": "transmission.geometry.crown_radius",
    "preload": "transmission.preload",
}
"""Paths of the free values of a wheel design, by name."""

RANGED = {**COBOTIC_PATHS, "input_speed": "input_speed"}
"""Paths of the values whose range can be stated, by name; the last is that of the motor of a sphere."""

UNITS = {
    "pulley.radius": "m",
    "screw.lead": "m",
    "input_speed": "rad/s",
    **dict(zip(COBOTIC_PATHS.values(), ("m", "rad/s", "m", "m", "N"), strict=True)),
    STEERING_RATIO: "1",
    WHEELS: "1",
}
"""SI unit of each free value, by path."""

ROLES = ("motor", "gearhead", STEERING_MOTOR, AXLE_BEARING, CYLINDER_BEARING)
"""Roles of parts that are searched."""

INNER = ("", "leg.", "separate.")
"""What precedes the path of a part in a drive of one axis, and in the machines whose links such drives move."""

SCALES = ("motor.scale", f"{STEERING_MOTOR}.scale")
"""Numbers of motors on one shaft, which are no fields of a drive."""

STANDBY = "amplifier.standby_power"
"""Path of what all amplifiers of a drive draw at all times."""

FOLLOWING = {
    "control.cylinder_bandwidth": (
        "assumed",
        "as fast as the steering servo, to hold the constant speed that the search over parts assumes",
    ),
    "transmission.cylinder_wall": ("derived", "thinnest wall that carries the preload, by structure.strength_margin"),
    "transmission.cylinder_length": ("derived", "travel, wheel, and room at both ends"),
    "transmission.cylinder_end_plate": ("derived", "structure.least_wall"),
    "cylinder_inertia": ("derived", "of the tube"),
    "link_mass": ("derived", "of what moves with the link"),
    "steering.bell_inertia": ("derived", "of bell and wheel"),
}
"""Values of cobotic drives that follow from those searched, where they come from; without one, the drive derives them itself."""

_FEW = 4
"""Most values tried that are listed one by one."""

_LEAD = {STEERING_MOTOR: "steering ", AXLE_BEARING: "bearings ", CYLINDER_BEARING: "cylinder on "}
"""What precedes the name of a part, by role."""


@result
class FreeValue(Frozen):
    """A value that the search chose from a range.

    Attributes
    ----------
    value          Chosen.
    low, high      Between these all limits are kept, with all else as chosen; nan if the design keeps them nowhere.
    unit           In SI.
    tried          Values of a template that were tried, of which it is one; empty if the search chose it from a range.
    """

    value: float = reported()
    low: float = reported()
    high: float = reported()
    unit: str = reported()
    tried: tuple[float, ...] = reported(default=(), optional=True)

    @property
    def words(self) -> str:
        """Value and range."""
        if self.tried:
            return f"{shown(self.value, self.unit)} ({tried_words(self.tried, self.unit)})"
        if math.isnan(self.low):
            return shown(self.value, self.unit)
        return f"{shown(self.value, self.unit)} (feasible from {shown(self.low, self.unit)} to {shown(self.high, self.unit)})"


DEMAND_ROWS = rows("task", "limit", "part", "demand_over_allowance")
"""What makes demands over allowances, by motion, limit and part, rows of a dictionary."""


def _limits(unchecked: tuple[Demand, ...]) -> list[str]:
    return [limit.name for limit, _ in unchecked]


def _tightest_words(tightest: TaskDemand | None) -> str | None:
    return None if tightest is None else limit_words(tightest)


@result
class SizedDrive(Frozen):
    """A candidate as a drive.

    Attributes
    ----------
    template       Drive of the study whose other parts it has.
    parts          Parts chosen, by role, which is their path in the drive: "motor", "gearhead"; of cobotic drives also
        "steering.motor", "transmission.geometry.axle_bearing" and "cylinder_bearings.bearing". Roles that keep the template's
        part are left out.
    free           Values chosen from a range, by their path in the drive, such as "pulley.radius" or "transmission.preload".
    drive          Ready for `duty_cycle`, `steady_map` and `simulate`.
    mass           Of the whole drive; nan if a body's is not known. [kg]
    power          Mean power from the supply over all motions; nan without a motion. [W]
    volume         Of the box around it; nan where no body is placed. [m^3]
    price          Of motors and gearhead, in the currency in which they state it; None if one does not.
    demands        Demand over allowance, by motion or "requirement", limit and part. [-]
    unchecked      Limits that the data sheets do not state.
    """

    template: str = reported()
    parts: Mapping[str, ChosenPart] = reported()
    free: Mapping[str, FreeValue] = reported()
    drive: Drive
    mass: float = reported("kg")
    power: float = reported("W")
    volume: float = reported("m^3")
    price: float | None = reported("1", optional=True)
    demands: Mapping[TaskDemand, float] = reported(convert=DEMAND_ROWS)
    unchecked: tuple[Demand, ...] = reported(convert=_limits)

    @derived()
    def title(self) -> str:
        """The parts by name; a wheel that slips has no motors chosen."""
        own = [] if any(short_path(role) == "motor" for role in self.parts) else ["wheel with any motors"]
        return ", ".join(
            [*own, *(f"{_LEAD.get(short_path(role), '')}{part.title}" for role, part in self.parts.items())]
        )

    @derived("kg")
    def motor_mass(self) -> float:
        """Of motors and gearheads; nan if one is not known. [kg]"""
        return float(total(body for body in bodies_of(self.drive, NO_SERVICE) if body.chosen))

    @property
    def inner_parts(self) -> dict[str, ChosenPart]:
        """Parts by role within the drive of a machine's links."""
        return {short_path(role): part for role, part in self.parts.items()}

    @property
    def inner_free(self) -> dict[str, FreeValue]:
        """Values by path within the drive of a machine's links."""
        return {short_path(path): value for path, value in self.free.items()}

    @property
    def architecture(self) -> str:
        """geared or cobotic."""
        return architecture_of(self.drive)

    @derived(convert=_tightest_words)
    def tightest(self) -> TaskDemand | None:
        """Motion, limit and part with the largest demand; None if no limit is loaded."""
        return tightest_of(self.demands)

    @derived("1")
    def margin(self) -> float:
        """Allowance over demand of the tightest limit. [-]"""
        return margin_of(self.demands)

    @property
    def exceeded(self) -> dict[TaskDemand, float]:
        """Demand over allowance of the limits exceeded, the worst first."""
        return exceeded_of(self.demands)

    @property
    def verdict(self) -> str:
        """One line: what it needs, weighs and keeps."""
        free = (f"{path_words(path)} {value.words}" for path, value in self.free.items())
        return "; ".join((self.title, *free, *self.results))

    @property
    def results(self) -> tuple[str, ...]:
        """Power, mass and margin, in words; instead of a margin the limit that is exceeded where that has no measure."""
        said = [show(self.power, "W", 3)] if math.isfinite(self.power) else []
        said.append("mass not stated" if math.isnan(self.mass) else show(self.mass, "kg", 3))
        return (*said, *outcome_words(self.demands))


def limit_words(key: TaskDemand) -> str:
    """Limit and part of a motion or the requirement, such as "motor continuous torque, walking"."""
    task, limit, part = key
    if limit in (Limit.SPACE, Limit.MASS):
        return f"{part} of the envelope"
    if limit == Limit.SHAFT:
        return limit.words
    return f"{demand_words(limit, part)}, {task}"


def demand_words(limit: Limit, part: str) -> str:
    """A limit of a part; of steering motors with their name, as they have the limits of the other motor."""
    return f"{part} {limit.words.removeprefix('motor ')}" if part == "steering motor" else limit.words


def exceeded_of(demands: Mapping[TaskDemand, float]) -> dict[TaskDemand, float]:
    """Demand over allowance of the limits exceeded, the worst first; nan is out of reach."""
    beyond = {key: demand for key, demand in demands.items() if not demand <= 1.0 + SPARE}
    return dict(sorted(beyond.items(), key=lambda item: -math.inf if math.isnan(item[1]) else -item[1]))


def outcome_words(demands: Mapping[TaskDemand, float]) -> list[str]:
    """Margin of the tightest limit in words, or the worst limit where that has no measure; empty if no limit is loaded."""
    if not all(map(math.isfinite, demands.values())):
        return [f"infeasible ({beyond_words(dict([*exceeded_of(demands).items()][:1]))})"]
    tightest = tightest_of(demands)
    return [] if tightest is None else [f"margin {allowance_words(demands[tightest])} ({limit_words(tightest)})"]


def exceeded_words(design: SizedDrive) -> str:
    """Limits that a design exceeds, and by how much."""
    return beyond_words(design.exceeded)


def beyond_words(exceeded: Mapping[TaskDemand, float]) -> str:
    """Demands over allowance of limits in words, three of them at most."""
    said = [f"{limit_words(key)}: {_times(key[1], demand)}" for key, demand in exceeded.items()]
    return "; ".join(said[:3]) + (f"; {len(said) - 3} more" if len(said) > 3 else "")


def _times(limit: Limit, demand: float) -> str:
    if math.isfinite(demand):
        return f"{times(demand)} the allowance"
    return _UNMEASURED.get(limit, "out of reach")


_UNMEASURED = {
    Limit.SLIP: "no steady rolling",
    Limit.REGENERATION: "the motor returns power, and the amplifier accepts none",
}
"""What a demand without a measure means, by limit."""


def allowance_words(demand: float) -> str:
    """Allowance over demand to three digits, with more where a limit is exceeded by little; "infinite" for no demand."""
    margin = 1.0 / demand if demand > 0.0 else math.inf
    return plain(margin, 3) if demand <= 1.0 + SPARE else margin_words(margin, 3)


def shown(value: float, unit: str, digits: int = 4) -> str:
    """A free value with its unit."""
    small = {"m": "mm", "N/m": "N/mm"}
    return show_in(value, unit, small[unit], digits) if unit in small else show(value, unit, digits)


def tried_words(values: Sequence[float], unit: str) -> str:
    """Values that were tried, or the ends of many."""
    if len(values) <= _FEW:
        return f"tried: {', '.join(shown(one, unit) for one in values)}"
    return f"{len(values)} values tried from {shown(values[0], unit)} to {shown(values[-1], unit)}"


def at_end(path: str, free: FreeValue) -> bool:
    """Whether a value is the first or last of those tried; a single motor on a shaft is no end."""
    ends = free.tried[-1:] if path in SCALES and free.tried[:1] == (1.0,) else (free.tried[:1] + free.tried[-1:])
    return len(free.tried) > 1 and free.value in ends


def short_path(path: str) -> str:
    """Path within the drive of a machine's links, such as that of its leg; of a drive of one axis the path itself."""
    return next((path.removeprefix(lead) for lead in INNER if lead and path.startswith(lead)), path)


def unit_of(path: str) -> str:
    """SI unit of a free value, by path."""
    return next(unit for known, unit in UNITS.items() if known.rpartition(".")[2] == path.rpartition(".")[2])


def path_words(path: str) -> str:
    """Path of a value in a drive, in words."""
    if path in SCALES:
        return f"{role_words(path.removesuffix('.scale'))}s on one shaft"
    short = short_path(path).removeprefix("transmission.").replace("geometry.", "")
    short = short.replace("bearings.bearing", "bearing").replace("wheel.wheel_", "wheel.")
    return short.replace(".", " ").replace("_", " ")


def role_words(role: str) -> str:
    """Role of a part in words."""
    return path_words(role)


def architecture_of(drive: Drive) -> str:
    """Geared or cobotic."""
    geared = isinstance(drive, ConventionalDrive) or getattr(drive, "separate", None) is not None
    return "geared" if geared else "cobotic"
