"""Which machines of a study can be templates, and which options a search over them has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine, type_words
from infinivar.errors import InputError, ParameterError
from infinivar.machines.links import lacking_of_leg
from infinivar.sizing.cobotic.wheels import check_template
from infinivar.study.study import Study

_INNER = ("leg", "separate")
"""Fields of a machine with what moves its links: searched is the first machine of the study with each."""

_SEARCHED = "machines with a leg or separate drives: platform, arm, robot and omniwheels"

_UNUSED = {
    "tries": "values of machines are not tried",
    "life": "bearings of machines are not searched by their life",
    "wheels": "each leg has one wheel",
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
    for kind in _INNER:
        known = [name for name, one in study.drives.items() if getattr(one, kind, None) is not None]
        able = [name for name in known if faults[name] is None]
        names += able[:1]
        if known and not able:
            notes.append(f"drives.{known[0]} was not searched: {faults[known[0]]}")
    if not names:
        name = next(iter(study.drives))
        raise InputError(notes[0] if notes else f"drives.{name} cannot be a template: {faults[name]}")
    return names, tuple(notes)


def machine_fault(machine: Any) -> str | None:
    """Why a machine cannot be a template; None if it can."""
    leg, separate = (getattr(machine, kind, None) for kind in _INNER)
    if not is_machine(machine) or (leg is None and separate is None):
        kind = type_words(machine) if is_machine(machine) else "one axis"
        return f"with tasks and paths, the search is over {_SEARCHED}; this one is of type {kind}"
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
    legs = [study.drives[name].leg is not None for name in names]
    for options, kind, able in (
        (("ranges", "steering_ratios", "slip_margin", "generations", "seed"), "a leg", any(legs)),
        (("radius",), "separate drives over a pulley", any(_pulley(study.drives[name]) for name in names)),
    ):
        useless = [name for name in options if name in given and not able]
        if useless:
            raise InputError(f"{', '.join(useless)}: for machines with {kind} only; none is searched")


def _pulley(machine: Any) -> bool:
    return machine.separate is not None and machine.separate.pulley is not None
