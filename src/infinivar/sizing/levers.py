"""What a designer could change in a drive: a value each, from what it is to the end of what is looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import with_rated_gear
from infinivar.limits import Limit
from infinivar.parts.bearing import COEFFICIENTS
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.parts.structure.tube import THICKEST
from infinivar.sizing.design import AXLE_BEARING, CYLINDER_BEARING, STEERING_MOTOR, SizedDrive

LEAST, MOST = 0.1, 10.0
"""Factors on values that cannot be 0, and on allowances. [-]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lever:
    """A value of a drive that could be another.

    Attributes
    ----------
    words   What it is.
    unit    In SI.
    start   As it is.
    end     Last value looked at.
    made    Makes a drive with a value from one.
    """

    words: str
    unit: str
    start: float
    end: float
    made: Callable[[Any, float], Any]


def levers(design: SizedDrive, goal: str) -> list[Lever]:
    """What could lower the power of a design (energy), its mass (mass), or the demands on its parts (feasible)."""
    if goal == "mass":
        return list(_masses(design))
    return [*_losses(design), *(_of_amplifier(design.drive) if goal == "energy" else ())]


def allowances(design: SizedDrive, limit: Limit, part: str) -> list[Lever]:
    """Values of a design that a limit of a part allows more with; empty if none is known.

    A gear keeps its friction when the motor's continuous torque changes, by which it is rated unless it states another torque.
    """
    drive, motor = design.drive, STEERING_MOTOR if part == "steering motor" else "motor"
    stated = {motor: Motor.ALLOWANCES, "gearhead": Gearhead.ALLOWANCES}
    table = {
        **{one: (one.words, (f"{of}.{name}",)) for of, names in stated.items() for one, name in names.items()},
        Limit.SLIP: ("friction limit of the contact", ("transmission.friction",)),
        Limit.BEARING: ("static rating of the axle bearings", (f"{AXLE_BEARING}.static_rating",)),
        Limit.YIELD: ("yield strength of wheel and cylinder", _of_materials("yield_strength")),
        Limit.HARDNESS: ("hardness of wheel and cylinder", _of_materials("hardness")),
        Limit.SUPPORT: ("static rating of the cylinder bearings", (f"{CYLINDER_BEARING}.static_rating",)),
        Limit.JOURNAL: ("bore of the cylinder bearings", (f"{CYLINDER_BEARING}.bore",)),
        Limit.SHAFT: ("radius of the pulley", ("pulley.radius",)),
        Limit.WALL: ("wall of the cylinder", ("transmission.cylinder_wall",)),
        Limit.TEMPERATURE: (
            "thermal conductances of the motor",
            (f"{motor}.winding_to_housing", f"{motor}.housing_to_ambient"),
        ),
    }
    if limit not in table:
        return []
    words, paths = table[limit]
    if motor == STEERING_MOTOR:
        words = words.replace("motor", "steering motor").replace("supply", "steering motor's supply")
    values = {path: value for path in paths if (value := _known(drive, path)) is not None}
    if not values:
        return []
    inverse = limit == Limit.TEMPERATURE
    first = next(iter(values.values()))
    start = 1.0 / first if inverse else first

    def made(drive: Any, value: float) -> Any:
        factor = start / value if inverse else value / start
        return with_values(with_rated_gear(drive), {path: one * factor for path, one in values.items()})

    unit = "W/K" if inverse else quantities_of(drive)[next(iter(values))].metadata["unit"]
    radius = _known(drive, "transmission.cylinder_radius")
    end = THICKEST * radius if limit == Limit.WALL and radius is not None else start * MOST
    return [Lever(words=words, unit=unit, start=start, end=end, made=made)]


def _of_materials(name: str) -> tuple[str, ...]:
    return tuple(f"transmission.geometry.{body}_material.{name}" for body in ("wheel", "cylinder"))


def _known(drive: Any, path: str) -> float | None:
    """A value above 0; None if the drive does not have it."""
    try:
        value = value_at(drive, path)
    except AttributeError:
        return None
    return float(value) if isinstance(value, int | float) and value > 0.0 else None


def _scaled(drive: Any, words: str, unit: str, paths: tuple[str, ...], end: float) -> Iterator[Lever]:
    """Values that one factor changes; the first is shown."""
    values = {path: value for path in paths if (value := _known(drive, path)) is not None}
    if values:
        start = next(iter(values.values()))

        def made(drive: Any, value: float) -> Any:
            return with_values(drive, {path: one * (value / start) for path, one in values.items()})

        yield Lever(words=words, unit=unit, start=start, end=start * end, made=made)


def _losses(design: SizedDrive) -> Iterator[Lever]:
    drive = design.drive
    yield from _scaled(drive, "motor resistance", "ohm", ("motor.resistance",), LEAST)
    yield from _scaled(drive, "motor torque constant at the same resistance", "N m/A", ("motor.torque_constant",), MOST)
    yield from _scaled(drive, "motor no-load current", "A", ("motor.no_load_current",), 0.0)
    yield from _gear_loss(drive)
    if isinstance(drive, CoboticDrive):
        yield from _of_wheel(drive)
    else:
        yield from _scaled(drive, "rotor inertia", "kg m^2", ("motor.rotor_inertia",), LEAST)
        yield from _scaled(drive, "output inertia", "kg m^2", ("output_inertia",), LEAST)
        yield from _scaled(drive, "pulley friction", "N m", ("pulley.friction_torque",), 0.0)
    guideway = getattr(drive, "guideway", None)
    constant, coefficient = (f"guideway.{name}" for name in getattr(guideway, "fields", ("friction", "coefficient")))
    yield from _scaled(drive, "guideway friction", "N", (constant,), 0.0)
    yield from _scaled(drive, "guideway friction coefficient", "1", (coefficient,), 0.0)


def _gear_loss(drive: Any) -> Iterator[Lever]:
    """What an efficiency lacks to 1."""
    paths = {f"gearhead.{name}": 1.0 for name in ("efficiency", "backdriving_efficiency")}
    values = {path: value for path in paths if (value := _known(drive, path)) is not None and value < 1.0}
    if values:
        start = 1.0 - next(iter(values.values()))

        def made(drive: Any, loss: float) -> Any:
            return with_values(drive, {path: 1.0 - (1.0 - one) * (loss / start) for path, one in values.items()})

        yield Lever(words="gear loss, 1 - efficiency", unit="1", start=start, end=0.0, made=made)


def _of_wheel(drive: CoboticDrive) -> Iterator[Lever]:
    element, geometry = drive.transmission, drive.transmission.geometry
    assert geometry is not None
    friction, preload = element.friction, element.preload

    def rougher(drive: Any, value: float) -> Any:
        return with_values(
            drive, {"transmission.friction": value, "transmission.preload": preload * (friction / value)}
        )

    yield Lever(
        words="friction limit of the contact, with the preload lowered in proportion",
        unit="1",
        start=friction,
        end=friction * MOST,
        made=rougher,
    )
    yield from _bearing_friction(drive)
    yield from _scaled(drive, "hysteresis of wheel and cylinder", "1", _of_materials("hysteresis_factor"), 0.0)
    yield from _scaled(drive, "steering motor resistance", "ohm", (f"{STEERING_MOTOR}.resistance",), LEAST)
    yield from _scaled(drive, "steering rotor inertia", "kg m^2", (f"{STEERING_MOTOR}.rotor_inertia",), LEAST)
    yield from _scaled(drive, "bell inertia", "kg m^2", ("steering.bell_inertia",), LEAST)
    yield from _scaled(drive, "friction of the bell's bearing over preload", "m", ("steering.bell_friction",), 0.0)


def _bearing_friction(drive: CoboticDrive) -> Iterator[Lever]:
    bearing = value_at(drive, AXLE_BEARING)
    if bearing.friction_model != "coefficient":
        paths = tuple(f"{AXLE_BEARING}.{name}" for name in ("boundary_friction", "ehl_friction"))
        yield from _scaled(drive, "sliding friction of the axle bearings", "1", paths, LEAST)
        return
    known = bearing.friction_coefficient
    start = COEFFICIENTS[bearing.type] if known is None else known

    def made(drive: Any, value: float) -> Any:
        return with_values(drive, {f"{AXLE_BEARING}.friction_coefficient": value})

    yield Lever(words="friction coefficient of the axle bearings", unit="1", start=start, end=start * LEAST, made=made)


def _of_amplifier(drive: Any) -> Iterator[Lever]:
    amplifier = drive.amplifier

    def returning(drive: Any, share: float) -> Any:
        stored = replace(drive.amplifier, regeneration="store", storage_efficiency=share)
        return replace(drive, amplifier=stored)

    if amplifier.regeneration != "none":
        start = amplifier.storage_efficiency or 0.0
        yield Lever(
            words="share of braking power returned to the supply", unit="1", start=start, end=1.0, made=returning
        )
    if amplifier.efficiency < 1.0:
        yield Lever(
            words="amplifier loss, 1 - efficiency",
            unit="1",
            start=1.0 - amplifier.efficiency,
            end=0.0,
            made=lambda drive, loss: with_values(drive, {"amplifier.efficiency": 1.0 - loss}),
        )
    yield from _scaled(drive, "standby power of the amplifier", "W", ("amplifier.standby_power",), 0.0)


def weighed(design: SizedDrive) -> Mapping[str, float]:
    """Masses that count, by path."""
    paths = [f"{role}.mass" for role in ("motor", "gearhead", STEERING_MOTOR) if role in design.parts]
    return {path: mass for path in paths if (mass := _known(design.drive, path)) is not None}


def _masses(design: SizedDrive) -> Iterator[Lever]:
    paths = tuple(weighed(design))
    for path in paths:
        words = f"mass of the {path.removesuffix('.mass').replace('.', ' ')}"
        yield from _scaled(design.drive, words, "kg", (path,), LEAST)
    total = sum(weighed(design).values())

    def made(drive: Any, mass: float) -> Any:
        return with_values(drive, {path: one * (mass / total) for path, one in weighed(design).items()})

    if total > 0.0:
        yield Lever(words="all these masses together", unit="kg", start=total, end=total * LEAST, made=made)
