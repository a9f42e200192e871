"""Which machines of a study can be templates, and which options a search over them has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from infinivar._core.fields import quantities_of
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine, type_words
from infinivar.errors import InputError, ParameterError
from infinivar.machines.links import lacking_of_leg
from infinivar.sizing.cobotic.wheels import check_template
from infinivar.study.study import Study

_INNER = ("leg", "separate")
"""Fields of a machine with what moves its links."""

_ROLLING, _CROWN = "rolling", "geometry.crown_radius"

_UNUSED = {
    "life": "bearings of machines are not searched by their life; leave it out",
    "wheels": "each leg has one wheel; leave it out",
}
"""Options for drives of one axis only."""


def of_machines(study: Study) -> bool:
    """Whether a study has machines."""
    return any(is_machine(one) for one in study.drives.values())


def machine_templates(study: Study, drive: Sequence[str] | None) -> tuple[list[str], tuple[str, ...]]:
    """Names of the machines to search, and why others of their kind are none.

    Raises
    ------
    InputError
        If a machine that is named cannot be a template, or the study has none.
    """
    if not (study.tasks or study.paths):
        raise InputError(
            "the study says nothing of what its machines must do: add a table [tasks.NAME] or [paths.NAME]"
        )
    if drive is not None:
        for name in drive:
            fault = machine_fault(study.drive(name))
            if fault is not None:
                raise InputError(f"drives.{name} cannot be a template: {fault}")
        return list(drive), ()
    names, notes = [], []
    faults = {name: machine_fault(one) for name, one in study.drives.items()}
    for kind in (*_INNER, _ROLLING):
        known = [name for name, one in study.drives.items() if _kind_of(one) == kind]
        able = [name for name in known if faults[name] is None]
        names += able[:1]
        if known and not able:
            notes.append(f"drives.{known[0]} was not searched: {faults[known[0]]}")
    if not names:
        raise InputError(notes[0])
    notes += [
        f"drives.{name} was not searched: {faults[name]}" for name, one in study.drives.items() if not is_machine(one)
    ]
    return names, tuple(notes)


def _kind_of(machine: Any) -> str:
    """What is searched of a machine: its leg, its separate drives, or wheels that roll; "" of a drive of one axis."""
    own = [kind for kind in _INNER if getattr(machine, kind, None) is not None]
    return own[0] if own else _ROLLING if is_machine(machine) else ""


def searched_values(machine: Any) -> list[str]:
    """Paths of values searched of machines without links: preloads and radii of wheels, and the speed of a sphere's motor."""
    known = quantities_of(machine)
    wheels = [path.removesuffix(f".{_CROWN}") for path in known if path.endswith(f".{_CROWN}")]
    found = [
        path for wheel in wheels for name in ("preload", "wheel_radius", _CROWN) if (path := f"{wheel}.{name}") in known
    ]
    return [*(["input_speed"] if "input_speed" in known else []), *found]


def machine_fault(machine: Any) -> str | None:
    """Why a machine cannot be a template; None if it can."""
    leg, separate = (getattr(machine, kind, None) for kind in _INNER)
    if not is_machine(machine):
        return "with tasks and paths, the search is over machines, and this is a drive of one axis"
    if leg is None and separate is None:
        if searched_values(machine):
            return None
        return (
            f"the search over a machine of type {type_words(machine)} is over its wheels, and their geometry is missing: "
            "measured values of a contact hold for one wheel and preload only"
        )
    if leg is None:
        if not isinstance(separate, ConventionalDrive):
            return "the search is over separate drives of type conventional"
        return "separate has springs or a linkage" if separate.output.chain else None
    try:
        check_template(leg, True)
    except ParameterError as problem:
        return f"leg.{problem}"
    missing = lacking_of_leg(leg)
    return next(iter(missing.values()), None)


def check_machine_options(study: Study, names: Sequence[str], aims: Sequence[str], given: Mapping[str, Any]) -> None:
    """Raise InputError for an option that no machine of those searched has a use for; `given` has the options stated."""
    if "space" in aims:
        raise InputError("objective = space: the space of machines is not known; use energy, mass or price")
    for name in given:
        if name in _UNUSED:
            raise InputError(f"{name}: {_UNUSED[name]}")
    kinds = [_kind_of(study.drives[name]) for name in names]
    unweighed = [name for name in names if not weighed(study.drives[name])]
    if "mass" in aims and unweighed:
        kind = type_words(study.drives[unweighed[0]])
        raise InputError(
            f"objective = mass: what a machine of type {kind} weighs is not known; use energy: drives.{unweighed[0]}"
        )
    for options, kind, able in (
        (("steering_ratios", "slip_margin"), "a leg", "leg" in kinds),
        (("ranges", "generations", "seed"), "a leg or wheels that roll", {"leg", _ROLLING} & {*kinds}),
        (("radius",), "separate drives over a pulley", any(_pulley(study.drives[name]) for name in names)),
    ):
        useless = [name for name in options if name in given and not able]
        if useless:
            raise InputError(f"{', '.join(useless)}: for machines with {kind} only; none is searched")


def weighed(machine: Any) -> bool:
    """Whether the mass of what moves a machine is known."""
    return hasattr(machine, "drivetrain")


def _pulley(machine: Any) -> bool:
    return getattr(machine, "separate", None) is not None and machine.separate.pulley is not None
