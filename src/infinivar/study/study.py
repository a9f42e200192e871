"""A study: what is required, the drives to compare, and the provenance of each of their values."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, replace
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, overload

import numpy as np

from infinivar._core.result import Frozen, result
from infinivar.axis import LINEAR, Axis
from infinivar.contact import creep
from infinivar.drivetrain.buildable import impossible
from infinivar.drivetrain.cobotic import CoboticDrive, legs_of
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive, check_drive, is_machine
from infinivar.drivetrain.envelope import Envelope
from infinivar.drivetrain.service import Service, service_of
from infinivar.errors import InputError, ParameterError, nearest, require
from infinivar.motion.duty_cycles import DutyCycle, shares_of
from infinivar.motion.machine_tasks import MachinePath, MachineTask, named
from infinivar.motion.scenario import Scenario
from infinivar.motion.vectors import TRANSLATIONS
from infinivar.study.provenance import Provenance, completed
from infinivar.study.requirement import Requirement
from infinivar.study.rig import Rig
from infinivar.study.sessions import SessionTask
from infinivar.study.spreads import Uncertainty
from infinivar.units import plain, times

D = TypeVar("D")

LARGEST_FRICTION = 1.0
"""Friction coefficient above which a value is taken for a slip of the pen. [-]"""


@result
class Study(Frozen):
    """Contents of a study file, ready to compute with; built in Python, it holds the same.

    Attributes
    ----------
    name : str            Stem of the file name, or a given name.
    title, description    Headline and explanation for reports.
    requirement           Required region of force, speed and power; None if only motions are required.
    envelope              Largest size and mass of a drive; None if the study states none.
    drives                Drive-trains (`Drive`) and machines (`Machine`) by name, in the order of the file.
    titles                Titles of the drives in reports.
    scenarios             Runs to simulate, by name.
    duty                  Duty cycles (repeated motions), by name.
    tasks                 Wrenches at twists that machines must exert, by name.
    paths                 Motions of the end point of machines, by name.
    sessions              Tasks of a machine at a user's handle, by name; a file states them as tasks with a `type`.
    rig                   Test rig for a transmission.
    uncertainty           Spreads of the drives' values.
    provenance            One record per value; records that are missing or no longer true are made anew.
    reconstruction        Statements of the parameter sets used on what they reconstruct; may be empty.
    path                  The study's file; no part of its value.
    """

    name: str
    title: str = ""
    drives: Mapping[str, Drive]
    requirement: Requirement | None = None
    envelope: Envelope | None = None
    description: str = ""
    titles: Mapping[str, str] = field(default_factory=dict)
    scenarios: Mapping[str, Scenario] = field(default_factory=dict)
    duty: Mapping[str, DutyCycle] = field(default_factory=dict)
    tasks: Mapping[str, MachineTask] = field(default_factory=dict)
    paths: Mapping[str, MachinePath] = field(default_factory=dict)
    sessions: Mapping[str, SessionTask] = field(default_factory=dict)
    rig: Rig = field(default_factory=Rig)
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    provenance: tuple[Provenance, ...] = ()
    reconstruction: tuple[str, ...] = ()
    path: Path | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Freeze, and complete what is left out: titles, masses of loads, provenance."""
        self._check()
        made = {
            "title": self.title or self.name,
            "titles": _distinct({name: self.titles.get(name) or name for name in self.drives}),
            "scenarios": _named(self.scenarios, self.requirement),
            "duty": _named(self.duty, self.requirement),
            **_distinguished(named(self.tasks), named(self.paths)),
            "sessions": {name: one.titled(name) for name, one in self.sessions.items()},
            "provenance": completed(self._owners(), self.provenance),
        }
        for name, value in made.items():
            object.__setattr__(self, name, value)
        Frozen.__post_init__(self)
        shares_of(self.duty)
        machine_shares(self.tasks, self.paths)

    @property
    def shares(self) -> dict[str, float]:
        """Share of the time spent in each duty cycle, adding up to 1; empty if the study states none. [-]"""
        return shares_of(self.duty)

    @property
    def moves(self) -> bool:
        """Whether it has motions: duty cycles, or tasks and paths of machines."""
        return bool(self.duty or self.tasks or self.paths)

    @property
    def machine_shares(self) -> dict[str, float]:
        """Share of the time spent in each task and path, such as "tasks.lift", adding up to 1; empty if none is stated. [-]"""
        return machine_shares(self.tasks, self.paths)

    @property
    def travel(self) -> float | None:
        """Travel of the load from end to end, or the angle of the joint; None if not required. [m] or [rad]"""
        return None if self.requirement is None else self.requirement.travel

    def service(self, drive: Any) -> Service:
        """What motions and requirement ask of the output of a drive, by which its structure is sized."""
        return service_of(drive, self.duty, self.requirement, self.travel)

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

    def _check(self) -> None:
        """Refuse values of wrong types; the message names the first."""
        require(
            isinstance(self.name, str) and bool(self.name.strip()), "name", repr(self.name), "text that is not empty"
        )
        for name, drive in self.drives.items():
            if not is_machine(drive):
                check_drive(drive, f"drives.{name}")
            if isinstance(drive, CoboticDrive | ConventionalDrive):
                fault = impossible(drive, functools.partial(self.service, drive))
                if fault is not None:
                    raise ParameterError(f"drives.{name}.{fault}")
        kinds = {
            "scenarios": Scenario,
            "duty": DutyCycle,
            "tasks": MachineTask,
            "paths": MachinePath,
            "sessions": SessionTask,
        }
        tasks = {
            f"{group}.{name}": (task, kind)
            for group, kind in kinds.items()
            for name, task in getattr(self, group).items()
        }
        values = {
            "rig": (self.rig, Rig),
            **({"requirement": (self.requirement, Requirement)} if self.requirement else {}),
            **({"envelope": (self.envelope, Envelope)} if self.envelope else {}),
        }
        for where, (value, kind) in {**tasks, **values}.items():
            require(isinstance(value, kind), where, repr(value), f"a {kind.__name__}")
        both = next((name for name in self.sessions if name in self.tasks), None)
        if both is not None:
            raise ParameterError(
                f"sessions.{both} must have another name than tasks.{both}: a file has one table for both"
            )

    def _owners(self) -> dict[str, Any]:
        """What has values with a provenance, by name; the usual rig only if its values are recorded already."""
        rig = self.rig != Rig() or any(row.owner == "rig" for row in self.provenance)
        required = {"requirement": self.requirement.stated} if self.requirement else {}
        required |= {"envelope": self.envelope} if self.envelope else {}
        tasks = {f"tasks.{name}": task for name, task in self.tasks.items()}
        tasks |= {f"tasks.{name}": one for name, one in self.sessions.items()}
        paths = {f"paths.{name}": path for name, path in self.paths.items()}
        return {**required, **tasks, **paths, **self.drives, **({"rig": self.rig} if rig else {})}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Valid input that looks like an oversight."""
        return (
            *(
                f"drives.{name}.transmission: {excess}"
                for name, drive in self.drives.items()
                for excess in (*_overstress(drive), *_replaced_law(drive))
            ),
            *_frictions(self.provenance),
            *_speeds(self),
            *(f"duty.{task}: {warning}" for task, cycle in self.duty.items() for warning in cycle.warnings),
            *(f"paths.{name}.{warning}" for name, path in self.paths.items() for warning in path.warnings),
        )

    @classmethod
    def from_dict(cls, tables: Mapping[str, Any], *, name: str, folder: str | Path | None = None) -> Study:
        """Build a study from the tables of a study file, as `tomllib` reads them.

        Parameters
        ----------
        tables : mapping   Nested dictionaries with the keys of a study file; they are not changed.
        name : str         Name of the study, which messages and provenance use like the name of a file.
        folder : path      Folder of the files that the tables name; defaults to the working directory.

        Returns
        -------
        Study

        Raises
        ------
        InputError
            If the tables are invalid; the message has one line per fault, as for a file.
        """
        return _reader_and_writer("load").study_from_dict(tables, name=name, folder=folder)

    def to_toml(self, folder: str | Path | None = None) -> str:
        """Return the text of a study file that loads to this study.

        Parameters
        ----------
        folder : path   Folder to which paths of recordings are relative; absolute paths by default.

        Raises
        ------
        InputError
            If a value cannot be stated in a file; the message names it.
        """
        return _reader_and_writer("save").to_toml(self, folder)

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the study to a file; as `infinivar.save_study`."""
        return _reader_and_writer("save").save_study(self, path, overwrite=overwrite)

    def with_drives(self, names: str | Iterable[str]) -> Study:
        """Return the study restricted to these drives, or to one, in the study's order.

        Raises
        ------
        InputError
            If the study has no drive of a given name.
        """
        required = {name: self.drive(name) for name in ([names] if isinstance(names, str) else names)}
        dropped = set(self.drives) - set(required)
        return replace(
            self,
            drives={name: drive for name, drive in self.drives.items() if name in required},
            titles={name: title for name, title in self.titles.items() if name in required},
            provenance=tuple(row for row in self.provenance if row.owner not in dropped),
        )

    @overload
    def drive(self, name: str) -> Any: ...

    @overload
    def drive(self, name: str, kind: type[D]) -> D: ...

    def drive(self, name: str, kind: type | None = None) -> Any:
        """Return a drive by name.

        Parameters
        ----------
        name : str
        kind : type   Class that the drive must have, such as `infinivar.CoboticDrive`; editors then know its fields.

        Raises
        ------
        InputError
            If no drive has that name, with a list of the drives, or it is of another class.
        """
        if name not in self.drives:
            known = f"its drives: {', '.join(self.drives)}"
            raise InputError(f"the study has no drive {name!r}{nearest(name, self.drives)}; {known}")
        found = self.drives[name]
        if kind is not None and not isinstance(found, kind):
            raise InputError(f"drives.{name} must be a {kind.__name__}, got a {type(found).__name__}")
        return found


def machine_shares(tasks: Mapping[str, MachineTask], paths: Mapping[str, MachinePath]) -> dict[str, float]:
    """Share of the time spent in each task and path, by its place in a study; empty if none is stated. [-]

    Raises
    ------
    InputError
        If only some state a share, or they do not add up to 100 %.
    """
    every = {f"tasks.{name}": task for name, task in tasks.items()} | {
        f"paths.{name}": one for name, one in paths.items()
    }
    return shares_of(every, "", "task and path")


def _distinct(titles: dict[str, str]) -> dict[str, str]:
    """Append the drive's name to titles that several drives share, as drives of the same base do."""
    while len({*titles.values()}) < len(titles):
        every = list(titles.values())
        titles = {name: title if every.count(title) == 1 else f"{title} ({name})" for name, title in titles.items()}
    return titles


def _reader_and_writer(name: str) -> Any:
    """The module that reads or writes study files, by name: both build on this one."""
    return import_module(f"infinivar.study.{name}")


T = TypeVar("T", DutyCycle, Scenario)


def _named(tasks: Mapping[str, T], requirement: Requirement | None) -> dict[str, T]:
    """The tasks, each with a title, its name by default, and the mass of its load, by default that of a requirement."""
    made = {name: task if task.title else replace(task, title=name) for name, task in tasks.items()}
    if requirement is None:
        return made
    mass, axis = requirement.load_mass, requirement.axis
    return {name: task.loaded(mass) if task.axis is axis else task for name, task in made.items()}


def _distinguished(tasks: dict[str, Any], paths: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Tasks and paths by group; those of one title are called "task T" and "path T"."""
    both = {one.title for one in tasks.values()} & {one.title for one in paths.values()}
    return {
        group: {
            name: replace(one, title=f"{what} {one.title}") if one.title in both else one for name, one in found.items()
        }
        for group, what, found in (("tasks", "task", tasks), ("paths", "path", paths))
    }


_FASTEST = 100.0
"""Speed above which a value looks like a slip of the unit: the rim of a steel cylinder then has a hoop stress of 80 MPa, and
rolling bearings and contacts run at a tenth of it. [m/s]"""

_INSTANTS = 401
"""Of a path, among which its largest speed is looked for."""


def _speeds(study: Study) -> Iterator[str]:
    """Yield each speed of a load or a surface that no machine of this kind has."""
    said = f"is above {_FASTEST:g} m/s; no limit of a part bounds it, so check the unit"
    for row in study.provenance:
        if (
            row.owner == "requirement"
            and row.unit == "m/s"
            and isinstance(row.value, int | float)
            and abs(row.value) > _FASTEST
        ):
            yield f"{row.owner}.{row.field} = {row.written} {said}"
    for name, drive in study.drives.items():
        radius, speed = (
            getattr(getattr(drive, "transmission", None), "cylinder_radius", None),
            getattr(drive, "cylinder_speed", None),
        )
        if isinstance(radius, int | float) and isinstance(speed, int | float) and abs(radius * speed) > _FASTEST:
            yield f"drives.{name}: the surface of the cylinder moves at {plain(abs(radius * speed))} m/s, which {said}"
    along = {where: fastest for where, fastest in _along_axes(study) if fastest > _FASTEST}
    of_parts = {
        where: fastest
        for where, fastest in _of_parts(study)
        if fastest > _FASTEST and not any(one.startswith(f"{where.partition(',')[0]}.") for one in along)
    }
    for where, fastest in {**along, **of_parts}.items():
        yield f"{where}: {plain(fastest)} m/s {said}"


def _along_axes(study: Study) -> Iterator[tuple[str, float]]:
    """Yield the largest speed of each motion and session along an axis. [m s^-1]"""
    for name, duty in study.duty.items():
        if not duty.axis.rotary:
            time = np.linspace(0.0, duty.period, duty.samples())
            yield f"duty.{name}", _largest(duty.motion.derivatives(time, 1)[1])
    for name, task in (*study.tasks.items(), *study.sessions.items()):
        yield f"tasks.{name}.twist", _largest(task.twist.row(TRANSLATIONS))
    for name, path in study.paths.items():
        time = np.linspace(0.0, path.period, _INSTANTS)
        for axis, motion in path.motions.items():
            if axis in TRANSLATIONS:
                yield f"paths.{name}.{axis}", _largest(motion.derivatives(time, 1)[1])


def _of_parts(study: Study) -> Iterator[tuple[str, float]]:
    """Yield the largest speed of the links or wheels of each machine in each task and path. [m s^-1]"""
    machines: dict[str, Any] = {name: one for name, one in study.drives.items() if hasattr(one, "part_speeds")}
    for title, drive in machines.items():
        names, home = drive.coordinates, drive.home
        moves = [
            (f"tasks.{name}", task.pose.row(names, home), task.twist.row(names))
            for name, task in study.tasks.items()
            if not any(task.twist.beyond(names))
        ]
        for name, path in study.paths.items():
            if not any(path.beyond(names)):
                at = path.at(np.linspace(0.0, path.period, _INSTANTS), names, home)
                moves.append((f"paths.{name}", at.pose, at.twist))
        for where, pose, twist in moves:
            with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
                yield f"{where}, parts of {title}", _largest(drive.part_speeds(pose, twist))


def _largest(speeds: Any) -> float:
    """Largest magnitude of those that are known; 0 of none."""
    found = np.abs(np.asarray(speeds, dtype=float))
    return float(np.max(found, where=np.isfinite(found), initial=0.0))


def _frictions(rows: tuple[Provenance, ...]) -> Iterator[str]:
    """Yield a phrase for each friction coefficient too large to be one."""
    for row in rows:
        if row.unit == "1" and row.field.rpartition(".")[2] == "friction" and row.value > LARGEST_FRICTION:
            where = row.owner if row.owner in ("requirement", "envelope", "rig") else f"drives.{row.owner}"
            yield (
                f"{where}.{row.field} = {row.value:g} is a coefficient, of 0.05 to {LARGEST_FRICTION:g} in rolling contacts: a "
                "wheel would slip far earlier"
            )


def _replaced_law(drive: Any) -> Iterator[str]:
    """Yield a phrase if steering as spin replaces another creep law than exact theory while the wheel is steered."""
    wheeled = drive if isinstance(drive, CoboticDrive) else legs_of(drive)
    if wheeled is None:
        return
    element = wheeled.transmission
    contact, law = element.contact, element.creep_law
    if element.turns_with_spin and law != creep.EXACT and contact is not None:
        patch = contact.axis_ratio, contact.poisson
        more = creep.lateral_creep("exact", 0.5, *patch) / creep.lateral_creep(law, 0.5, *patch)
        yield (
            f'steering_model = "spin" knows exact rolling theory only, so motion in time does not use creep_law = "{law}": at '
            f"half of the slip force the wheel creeps {plain(float(more), 3)} times as much there as at steady points "
            '(creep_law = "exact" has one law for both, steering_model = "shear" keeps the creep law)'
        )


def _overstress(drive: Any) -> Iterator[str]:
    """Yield a phrase for each stress limit that the wheel's preload exceeds."""
    wheeled = drive if isinstance(drive, CoboticDrive) else legs_of(drive)
    if wheeled is not None:
        for limit, demand in wheeled.transmission.utilisation.items():
            if demand > 1.0:
                yield f"{limit.words} exceeded, {times(demand)} the limit; run infinivar contact for details"
