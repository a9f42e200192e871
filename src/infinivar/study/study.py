"""A study: what is required, the drives to compare, and the provenance of each of their values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from infinivar._core.result import Frozen, result
from infinivar.axis import LINEAR, Axis
from infinivar.drivetrain.drive import Drive
from infinivar.errors import InputError, nearest
from infinivar.motion.duty_cycles import DutyCycle, shares_of
from infinivar.motion.scenario import Scenario
from infinivar.study.requirement import Requirement
from infinivar.study.rig import Rig
from infinivar.study.spreads import Uncertainty

DEFAULT = "program default"
"""Source of values that the study does not state."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Provenance of one value."""

    owner: str
    """Drive that the value belongs to, or "requirement"."""
    field: str
    """Path of the field in the owner's table, such as "transmission.preload"."""
    written: str
    """The value as written in the file."""
    value: Any
    """The value in SI, or the word chosen."""
    unit: str
    """SI unit; "1" for pure numbers, "" for words."""
    kind: str
    """stated, catalogue, derived, fitted or assumed."""
    where: str
    """Place in the source, catalogue key or file."""


@result
class Study(Frozen):
    """Contents of a study file, ready to compute with.

    Attributes
    ----------
    name : str            Stem of the file name, or a given name.
    title, description    Headline and explanation for reports.
    requirement           Required region of force, speed and power; None if only motions are required.
    drives                Drive-trains by name, in the order of the file.
    titles                Titles of the drives in reports.
    scenarios             Runs to simulate, by name.
    duty                  Duty cycles (repeated motions), by name.
    rig                   Test rig for a transmission.
    uncertainty           Spreads of the drives' values.
    provenance            One record per value.
    reconstruction        Statements of the parameter sets used on what they reconstruct; may be empty.
    warnings              Valid input that looks like an oversight.
    """

    name: str
    title: str
    drives: Mapping[str, Drive]
    requirement: Requirement | None = None
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
        """Freeze; the title of a drive defaults to its name."""
        titles = _distinct({name: self.titles.get(name, name) for name in self.drives})
        object.__setattr__(self, "titles", titles)
        Frozen.__post_init__(self)
        shares_of(self.duty)

    @property
    def shares(self) -> dict[str, float]:
        """Share of the time spent in each duty cycle, adding up to 1; empty if the study states none. [-]"""
        return shares_of(self.duty)

    @property
    def travel(self) -> float | None:
        """Travel of the load from end to end, or the angle of the joint; None if not required. [m] or [rad]"""
        return None if self.requirement is None else self.requirement.travel

    @property
    def load_mass(self) -> float | None:
        """Mass of the load, or its moment of inertia, by the requirement; None if not stated. [kg] or [kg m^2]"""
        return None if self.requirement is None else self.requirement.load_mass

    @property
    def axis(self) -> Axis:
        """Whether the load moves along a line or about a joint: as required, else as the motions, else as the drives do."""
        owners = [
            *([] if self.requirement is None else [self.requirement]),
            *self.duty.values(),
        ]
        return next((getattr(owner, "axis", LINEAR) for owner in [*owners, *self.drives.values()]), LINEAR)

    def required(self, what: str) -> Requirement:
        """Return the requirement.

        Raises
        ------
        InputError
            If the study has none; the message names `what` needs it.
        """
        if self.requirement is None:
            keys = "moment and angular_speed" if self.axis.rotary else "force and speed"
            raise InputError(f"{what}: the study has no requirement; add a table [requirement] with {keys}")
        return self.requirement

    def with_drives(self, names: str | Iterable[str]) -> Study:
        """Return the study restricted to these drives, or to one, in the study's order.

        Raises
        ------
        InputError
            If the study has no drive of a given name.
        """
        wanted = {name: self.drive(name) for name in ([names] if isinstance(names, str) else names)}
        dropped = set(self.drives) - set(wanted)
        return replace(
            self,
            drives={name: drive for name, drive in self.drives.items() if name in wanted},
            titles={name: title for name, title in self.titles.items() if name in wanted},
            provenance=tuple(row for row in self.provenance if row.owner not in dropped),
        )

    def drive(self, name: str) -> Drive:
        """Return a drive by name.

        Raises
        ------
        InputError
            If no drive has that name; the message lists the drives.
        """
        if name not in self.drives:
            known = f"its drives: {', '.join(self.drives)}"
            raise InputError(f"the study has no drive {name!r}{nearest(name, self.drives)}; {known}")
        return self.drives[name]


def _distinct(titles: dict[str, str]) -> dict[str, str]:
    """Append the drive's name to titles that several drives share, as drives of the same base do."""
    every = list(titles.values())
    return {name: title if every.count(title) == 1 else f"{title} ({name})" for name, title in titles.items()}
