"""A study: the requirement, the drives that compete for it, and where each of their numbers comes from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from infinivar._core.result import Frozen, result
from infinivar.drivetrain.drive import Drive
from infinivar.errors import InputError, nearest
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.study.requirement import Requirement
from infinivar.study.rig import Rig
from infinivar.study.spreads import Uncertainty

DEFAULT = "default of the program"
"""Source of values that nobody gave."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Where one value comes from."""

    owner: str
    """Drive the value belongs to, or "requirement"."""
    field: str
    """Path of the field in the owner's table, such as "transmission.preload"."""
    written: str
    """The value as written in the file."""
    value: Any
    """The value in SI, or the word chosen."""
    unit: str
    """SI unit, "1" for pure numbers, "" for words."""
    kind: str
    """stated, catalogue, derived, fitted or assumed."""
    where: str
    """Place in the source, catalogue key or file."""


@result
class Study(Frozen):
    """What a study file says, ready to compute with.

    Attributes
    ----------
    name : str            Stem of the file, or a name given.
    title, description    Headline and explanation for reports.
    requirement           Force-speed-power region to cover.
    drives                Drive-trains by name, in the order of the file.
    titles                Their names for reports.
    scenarios             Runs in time for simulation, by name.
    duty                  Motions that the drives repeat, by name.
    rig                   On which a transmission is measured.
    uncertainty           How far values of the drives may be off.
    provenance            One record a value.
    reconstruction        Statements of the parameter sets used about what in them is reconstructed; may be empty.
    warnings              What looks like an oversight, though it can be computed.
    """

    name: str
    title: str
    requirement: Requirement
    drives: Mapping[str, Drive]
    description: str = ""
    titles: Mapping[str, str] = field(default_factory=dict)
    scenarios: Mapping[str, Scenario] = field(default_factory=dict)
    duty: Mapping[str, DutyCycle] = field(default_factory=dict)
    rig: Rig = field(default_factory=Rig)
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    provenance: tuple[Provenance, ...] = ()
    reconstruction: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    path: Path | None = None

    def __post_init__(self) -> None:
        """Freeze; drives without a title go by their name."""
        titles = _told_apart({name: self.titles.get(name, name) for name in self.drives})
        object.__setattr__(self, "titles", titles)
        Frozen.__post_init__(self)

    def with_drives(self, names: Iterable[str]) -> Study:
        """The study with these drives only, in its own order.

        Raises
        ------
        InputError
            If there is none of a name.
        """
        wanted = {name: self.drive(name) for name in names}
        dropped = set(self.drives) - set(wanted)
        return replace(
            self,
            drives={name: drive for name, drive in self.drives.items() if name in wanted},
            titles={name: title for name, title in self.titles.items() if name in wanted},
            provenance=tuple(row for row in self.provenance if row.owner not in dropped),
        )

    def drive(self, name: str) -> Drive:
        """The drive of that name.

        Raises
        ------
        InputError
            If there is none; the message names those that there are.
        """
        if name not in self.drives:
            known = f"the study has {', '.join(self.drives)}"
            raise InputError(f"there is no drive {name!r}{nearest(name, self.drives)}; {known}")
        return self.drives[name]


def _told_apart(titles: dict[str, str]) -> dict[str, str]:
    """Titles, with the name behind those that several drives share (those of one base do)."""
    every = list(titles.values())
    return {name: title if every.count(title) == 1 else f"{title} ({name})" for name, title in titles.items()}
