"""Options of a search for the best drives; nothing heavy is imported before one is read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, get_args

from infinivar.errors import InputError, nearest
from infinivar.options import Options, amount, numbers, option, span

GENERATIONS = 40
"""Of the search over cobotic drives."""

SLIP_MARGIN = 1.1
"""Slip force over lateral force: a wheel that slips in a transient no longer steers."""

Aim = Literal["energy", "mass", "space", "price"]

BOTH = ("energy", "mass")
"""Objectives that may be given together."""

OBJECTIVES = "energy, mass, space or price, or energy and mass together"


def fine_aims(aims: Sequence[str]) -> bool:
    """Whether these are objectives that a search can have."""
    return (len(aims) == 1 and aims[0] in get_args(Aim)) or (len(aims) == 2 and {*aims} == {*BOTH})


def _objective(name: str, said: str) -> tuple[str, ...]:
    aims = tuple(part.strip() for part in said.split(","))
    if not fine_aims(aims):
        raise InputError(f"{name} {said!r} must be {OBJECTIVES}, such as energy,mass")
    return aims


def _radius(name: str, said: tuple[str, str]) -> tuple[float, float]:
    return span(name, f"{name} {said[0]!r} {said[1]!r}", *said, "m")


def _ranges(name: str, said: list[str]) -> dict[str, tuple[float, float]]:
    """Ranges by name. In SI."""
    named = [_named_range(name, text) for text in said]
    if len(dict(named)) < len(named):
        raise InputError(f"{name} names a value twice; give one range for each")
    return dict(named)


def _named_range(option: str, text: str) -> tuple[str, tuple[float, float]]:
    """Name and ends of a range such as "preload=800 N..3 kN". In SI."""
    from infinivar.sizing.design import RANGED, UNITS

    name, equals, ends = text.partition("=")
    name, (low, dots, high) = name.strip(), ends.partition("..")
    if not equals or not dots:
        raise InputError(f'{option} {text!r} must be NAME=LOW..HIGH, such as "preload=800 N..3 kN"')
    if name not in RANGED:
        known = ", ".join(RANGED)
        raise InputError(f"{option} {text!r}: {name!r} is not searched{nearest(name, RANGED)}; names: {known}")
    return name, span(f"{option} {name}", f"{option} {text!r}", low, high, UNITS[RANGED[name]])


def _ranges_shown(ranges: Mapping[str, tuple[float, float]]) -> str:
    from infinivar.sizing.design import RANGED, UNITS, shown

    def words() -> Iterator[str]:
        for name, ends in ranges.items():
            low, high = (shown(end, UNITS[RANGED[name]], 3) for end in ends)
            yield f"{name.replace('_', ' ')} from {low} to {high}"

    return ", ".join(words())


def _tries(name: str, said: list[str]) -> dict[str, str]:
    """Texts of values by path; each path is followed by "="."""
    found: dict[str, str] = {}
    last = ""
    for part in ",".join(said).split(","):
        path, equals, values = part.partition("=")
        if equals:
            last, values = path.strip(), values.strip()
            if last in found:
                raise InputError(f"{name} names {last} twice; give all its values at once")
            found[last] = values
        elif last:
            found[last] += f", {part.strip()}"
        if not last:
            raise InputError(f'{name} {part!r} must be PATH=VALUES, such as "drives.geared.screw.lead=2 mm, 5 mm"')
    return found


def _tries_shown(tries: Mapping[str, Any]) -> str:
    return "; ".join(f"{path} = {said if isinstance(said, str) else list(said)}" for path, said in tries.items())


@dataclass(frozen=True, slots=True, kw_only=True)
class SizeOptions(Options):
    """What `size` can be given beside the study and its templates."""

    command: ClassVar[str] = "size"

    objective: Aim | Sequence[Aim] | None = option(
        "energy, mass, space or price; or energy and mass, separated by a comma: designs are ordered by the first, and both give "
        "their front as well. Prices are those that parts state.",
        read=_objective,
        usual="energy,mass; mass for a study without motions",
    )
    top: int = option("Number of designs to list, besides those of the front.", int, least=1, default=20)
    sets: Sequence[str | Path] | None = option(
        "Search only this set, by name or as a file; repeat for more sets.",
        list[str],
        name="set",
        usual="all sets",
        of_files=True,
    )
    radius: tuple[float, float] | None = option(
        'Geared drives: least and largest radius of the pulley, such as "3 mm" "50 mm".',
        tuple[str, str],
        _radius,
        unit="m",
        usual="a fifth to five times the template's",
        metavar="LOW HIGH",
    )
    tries: Mapping[str, Any] | None = option(
        "Values of a template to try, each with everything that the search chooses: values separated by commas, such as "
        '"drives.geared.screw.lead=2 mm, 5 mm", or a range, such as '
        '"drives.geared.output.series_spring.stiffness=60 N/mm..300 N/mm"; repeat for more.',
        list[str],
        _tries,
        name="try",
        usual="the template's",
        metavar="PATH=VALUES",
        show=_tries_shown,
    )
    ranges: Mapping[str, tuple[float, float]] | None = option(
        "Cobotic drives: range of cylinder_radius, cylinder_speed, wheel_radius, crown_radius or preload, of a sphere's motor of "
        'input_speed, such as "preload=800 N..3 kN"; repeat for more.',
        list[str],
        _ranges,
        name="range",
        usual="half to twice the template's",
        metavar="NAME=LOW..HIGH",
        show=_ranges_shown,
    )
    steering_ratios: Sequence[float] | None = numbers(
        "Cobotic drives: ratios between steering motor and bell to try, separated by commas.",
        usual="five from half to twice the template's",
    )
    wheels: Sequence[int] | None = numbers(
        "Cobotic drives: numbers of wheels around the cylinder to try, separated by commas.", usual="1, 2, 3"
    )
    slip_margin: float | None = option(
        "Cobotic drives: required slip force over lateral force.", float, least=1.0, usual=f"{SLIP_MARGIN:g}"
    )
    life: float | None = amount('Cobotic drives: required life of axle and cylinder bearings, such as "5000 h".', "s")
    generations: int | None = option("Cobotic drives: length of the search.", int, least=1, usual=str(GENERATIONS))
    seed: int | None = option("Cobotic drives: the same seed gives the same result.", int, least=0, usual="0")
    carried: float | None = amount(
        'What a kilogram costs to carry, such as "5 W/kg": the least sum with the power is stated beside the verdict.',
        "W/kg",
    )
    builds: int = option(
        "Number of builds of the best designs within the spreads of their parts, a power of two; 0: none.",
        int,
        least=0,
        default=128,
    )

    GEARED: ClassVar[tuple[str, ...]] = ("radius",)
    COBOTIC: ClassVar[tuple[str, ...]] = ("ranges", "steering_ratios", "wheels", "slip_margin", "life")
    """Of one architecture only, and of every search over it."""
