"""Load a study file into a frozen `Study`: read it, lay it over the shipped sets, validate, build."""

from __future__ import annotations

import contextlib
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from infinivar._core import files
from infinivar.axis import LINEAR
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import Drive
from infinivar.errors import InputError, nearest, printable
from infinivar.motion.duty_cycles import DutyCycle, shares_of
from infinivar.motion.scenario import Scenario
from infinivar.study.build import built
from infinivar.study.extend import extended
from infinivar.study.layers import LONGEST_TITLE, Raw, Remarks, annotated, over_base
from infinivar.study.messages import StudyError, quoted, short
from infinivar.study.requirement import JOINT_ONLY, LINE_ONLY, JointRequirement, Requirement
from infinivar.study.rig import Rig
from infinivar.study.schema import DRIVES, keys
from infinivar.study.shipped import parameter_set, study_file
from infinivar.study.spreads import uncertainty_from
from infinivar.study.study import Provenance, Study

_TOP = (
    "title", "description", "extends", "requirement", "drives", "scenarios", "duty", "rig", "uncertainty", "correlations",
)  # fmt: skip
_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
_MOST = 12
"""Most faults listed at once."""

_MOST_BYTES = 4_000_000
"""Largest study file; a hundred times the largest known one."""

_LONGEST_DESCRIPTION = 10_000
"""Characters."""


def load_study(path: str | Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : str or Path   TOML file, described by `infinivar schema` and the documentation, or the name of a shipped study,
        such as "hand_controller". A file of that name in the current folder takes precedence.

    Returns
    -------
    Study

    Raises
    ------
    InputError
        If the file cannot be read or is invalid; the message has one line per fault, with file, field, value and what
        would be right.
    """
    path = study_file(Path(path))
    raw = _read(path)
    try:
        return study_from(extended(raw, path, _read), name=path.stem, origin=path.name, path=path)
    except RecursionError as problem:
        raise InputError(f"{printable(path)}: is nested too deeply") from problem
    except StudyError as problems:
        lines = [f"{printable(path)}: {line}" for line in problems.lines[:_MOST]]
        more = len(problems.lines) - len(lines)
        raise InputError("\n".join([*lines, f"... and {more} more faults"] if more else lines)) from None


def _read(path: Path) -> Raw:
    """Read the tables of a study file, as written."""
    content = files.read(path, _MOST_BYTES)
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as problem:
        raise InputError(f"{printable(path)}: is not a text file in UTF-8 (byte {problem.start})") from problem
    except ValueError as problem:  # TOMLDecodeError, or a number with thousands of digits
        raise InputError(f"{printable(path)}: is not valid TOML: {str(problem).partition(';')[0]}") from problem
    except RecursionError as problem:
        raise InputError(f"{printable(path)}: is nested too deeply") from problem


def study_from(raw: Raw, *, name: str, origin: str, path: Path | None = None) -> Study:
    """Build a study from the nested tables of its file; `origin` is the source of values that state none."""
    _check_top(raw)
    loading = _Loading(raw, origin, path)
    requirement = loading.requirement()
    drives, titles = loading.drives()
    scenarios = loading.tasks("scenarios", Scenario, requirement)
    duty = loading.tasks("duty", DutyCycle, requirement)
    rig = loading.rig()
    with loading.collecting():
        _check_shares(duty)
    if loading.faults:
        raise StudyError(*loading.faults)
    warnings = [
        *loading.remarks.warnings,
        *(f"duty.{task}: {warning}" for task in duty for warning in duty[task].warnings),
    ]
    return Study(
        name=name,
        title=raw.get("title", name),
        description=raw.get("description", ""),
        requirement=requirement,
        drives=drives,
        titles=titles,
        scenarios=scenarios,
        duty=duty,
        rig=rig,
        # Spreads refer to values of the drives, so they are read only if the drives are valid.
        uncertainty=uncertainty_from(raw.get("uncertainty", {}), raw.get("correlations", []), drives, origin),
        provenance=tuple(loading.rows),
        reconstruction=tuple(loading.remarks.reconstruction.values()),
        warnings=tuple(warnings),
        path=path,
    )


def _check_top(raw: Raw) -> None:
    """Check the top-level keys, texts and tables of a study; raise the first fault."""
    for key in raw:
        if key not in _TOP:
            raise StudyError(f"{printable(key)} is not a known key{nearest(key, _TOP)}; known keys: {', '.join(_TOP)}")
    _check_text(raw, "title", LONGEST_TITLE)
    _check_text(raw, "description", _LONGEST_DESCRIPTION, lines=True)
    for key in ("scenarios", "duty"):
        if not isinstance(raw.get(key, {}), dict):
            raise StudyError(f"{key} = {quoted(raw[key])} must be tables [{key}.NAME]")
    if not raw.get("requirement") and not raw.get("duty"):
        raise StudyError("requirement is missing: write a table [requirement], or a motion in a table [duty.NAME]")
    if not raw.get("drives"):
        raise StudyError("drives is missing: write a table [drives.NAME]")
    for key, table in (("requirement", "requirement"), ("drives", "drives.NAME")):
        if not isinstance(raw.get(key, {}), dict):
            raise StudyError(f"{key} = {quoted(raw[key])} must be a table [{table}]")


def _check_shares(duty: Mapping[str, DutyCycle]) -> None:
    try:
        shares_of(duty)
    except InputError as problem:
        raise StudyError(str(problem)) from None


def _check_text(raw: Raw, key: str, longest: int, *, lines: bool = False) -> None:
    text = raw.get(key, "")
    if not isinstance(text, str) or len(text) > longest:
        raise StudyError(f"{key} = {quoted(text)} must be text of at most {longest} characters")
    if not (text.replace("\n", "") if lines else text).isprintable():
        raise StudyError(f"{key} = {quoted(text)} must be text without control characters")


@dataclass(slots=True)
class _Loading:
    """A study being loaded, section by section; faults are collected and reported together."""

    raw: Raw
    origin: str
    path: Path | None
    faults: list[str] = field(default_factory=list)
    rows: list[Provenance] = field(default_factory=list)
    remarks: Remarks = field(default_factory=Remarks)

    @contextlib.contextmanager
    def collecting(self) -> Iterator[None]:
        """Collect the faults raised within; values that could not be built are missing from the study."""
        try:
            yield
        except StudyError as found:
            self.faults += found.lines

    def requirement(self) -> Requirement | None:
        """Build the requirement, along a line or about a joint; None if the study states none."""
        if "requirement" not in self.raw:
            return None
        with self.collecting():
            tree = over_base(
                annotated(self.raw["requirement"], "requirement", self.origin), "requirement", self.remarks
            )
            line, joint = ([key for key in keys if key in tree] for keys in (LINE_ONLY, JOINT_ONLY))
            if line and joint:
                raise StudyError(
                    f"requirement.{joint[0]} does not apply beside {line[0]}: write {', '.join(LINE_ONLY)} along a line, or "
                    f"{', '.join(JOINT_ONLY)} about a joint"
                )
            if joint:
                return built(JointRequirement, tree, "requirement", "requirement", self.rows).requirement
            return built(Requirement, tree, "requirement", "requirement", self.rows)
        return None

    def drives(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Build the drives and their titles, by name."""
        drives, titles = {}, {}
        for drive, description in self.raw["drives"].items():
            where = f"drives.{drive}"
            with self.collecting():
                _check_name("drives", drive, self.raw["drives"])
                tree = over_base(annotated(_table(description, where), where, self.origin), where, self.remarks)
                kind = _type_of(tree, where)
                titles[drive] = tree.pop("title", drive)
                drives[drive] = built(DRIVES[kind], tree, where, drive, self.rows)
                self.remarks.warnings.extend(f"{where}.transmission: {excess}" for excess in _overstress(drives[drive]))
        return drives, titles

    def tasks(self, group: str, kind: type, requirement: Requirement | None) -> dict[str, Any]:
        """Build the scenarios or duty cycles, by name; the load mass defaults to the requirement's on the same axis."""
        made = {}
        for task, description in self.raw.get(group, {}).items():
            with self.collecting():
                _check_name(group, task, self.raw[group])
                built_task = _task(description, group, kind, task, self.origin, self.path)
                same = requirement is not None and requirement.axis is getattr(built_task, "axis", LINEAR)
                made[task] = built_task.loaded(requirement.load_mass) if same and requirement else built_task
        return made

    def rig(self) -> Rig:
        with self.collecting():
            if "rig" in self.raw:
                return built(
                    Rig, annotated(_table(self.raw["rig"], "rig"), "rig", self.origin), "rig", "rig", self.rows
                )
        return Rig()


def _table(value: object, where: str) -> Raw:
    if not isinstance(value, dict):
        raise StudyError(f"{where} = {quoted(value)} must be a table [{where}]")
    return value


def _overstress(drive: Drive) -> Iterator[str]:
    """Yield a phrase for each stress limit that the wheel's preload exceeds."""
    if isinstance(drive, CoboticDrive):
        for limit, demand in drive.transmission.utilisation.items():
            if demand > 1.0:
                yield f"{limit.words} exceeded, {demand:.2f} times the limit; run infinivar contact for details"


def _task(
    description: object, group: str, kind: type, name: str, origin: str, path: Path | None
) -> Scenario | DutyCycle:
    """Build a scenario or duty cycle from its table; file paths are relative to the study."""
    where = f"{group}.{name}"
    # Tasks are requests, not facts with a source, so their provenance is not recorded.
    tree = over_base(annotated(_table(description, where), where, origin), where, Remarks())
    for table in (tree, tree.get("motion", {}), tree.get("force", {})):
        file = table.get("file")
        if path is not None and isinstance(file, dict) and isinstance(file.get("value"), str):
            file["value"] = str(path.parent / file["value"])
    return built(kind, {"title": name, **tree}, where, name, [])


def _check_name(group: str, drive: str, others: Iterable[str]) -> None:
    """Refuse names that cannot become file names."""
    if not _NAME.fullmatch(drive):
        raise StudyError(f"{group}.{short(repr(drive))} must have a name of at most 64 letters, digits, - and _")
    twin = next((other for other in others if other.lower() == drive.lower()), drive)
    if twin != drive:
        raise StudyError(
            f"{group}.{drive} and {group}.{twin} differ only in case; rename one, as some file systems ignore case"
        )


def _type_of(tree: Raw, where: str) -> str:
    """Pop the type from a drive's table; if it is missing, report misspelt keys first."""
    kind = tree.pop("type", None)
    if kind in DRIVES:
        return kind
    if kind is not None:
        raise StudyError(f"{where}.type = {quoted(kind)} must be {' or '.join(DRIVES)}{nearest(kind, DRIVES)}")
    known = dict.fromkeys(key for part in DRIVES.values() for key in keys(part))
    unknown = [f"{where}.{printable(key)} is not a known key{nearest(key, known)}" for key in tree if key not in known]
    missing = f"{where}.type is missing: write {' or '.join(DRIVES)}, or name a shipped drive as base"
    raise StudyError(*(unknown or [missing]))


def shipped_study(name: str) -> Study:
    """Return a study of a whole shipped parameter set: its requirement, drives, scenarios and duty cycles.

    Raises
    ------
    InputError
        If no set has that name.
    """
    shipped = parameter_set(name)
    drives = {drive: {"base": f"{name}.{drive}"} for drive in shipped["drives"]}
    tasks = {
        group: {task: {"base": f"{name}.{task}"} for task in shipped.get(group, {})} for group in ("scenarios", "duty")
    }
    raw = {"title": shipped["title"], "requirement": {"base": name}, "drives": drives, **tasks}
    return study_from(raw, name=name, origin=name)
