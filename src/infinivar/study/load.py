"""From a study file to a frozen `Study`: read, lay over the shipped sets, validate, build."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from infinivar._core import files
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import Drive
from infinivar.errors import InputError, nearest, printable
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.study.build import built
from infinivar.study.extend import extended
from infinivar.study.layers import LONGEST_TITLE, Raw, Remarks, annotated, over_base
from infinivar.study.messages import StudyError, quoted, short
from infinivar.study.requirement import Requirement
from infinivar.study.rig import Rig
from infinivar.study.schema import DRIVES, keys
from infinivar.study.shipped import parameter_set
from infinivar.study.spreads import Uncertainty, uncertainty_from
from infinivar.study.study import Provenance, Study

_TOP = (
    "title", "description", "extends", "requirement", "drives", "scenarios", "duty", "rig", "uncertainty", "correlations",
)  # fmt: skip
_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
_MOST = 12
"""Faults listed at once."""

_MOST_BYTES = 4_000_000
"""Of a study: a hundred times the largest there is."""


def load_study(path: str | Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : str or Path   TOML file; `infinivar schema` and the documentation describe it.

    Returns
    -------
    Study

    Raises
    ------
    InputError
        If the file cannot be read or says something that cannot be; the message names file, field, value and what
        would be right, one line for each fault.
    """
    path = Path(path)
    raw = _read(path)
    try:
        return study_from(extended(raw, path, _read), name=path.stem, origin=path.name, path=path)
    except RecursionError as problem:
        raise InputError(f"{printable(path)}: is nested too deeply") from problem
    except StudyError as problems:
        lines = [f"{printable(path)}: {line}" for line in problems.lines[:_MOST]]
        more = len(problems.lines) - len(lines)
        raise InputError("\n".join([*lines, f"and {more} more"] if more else lines)) from None


def _read(path: Path) -> Raw:
    """Tables of a study file as written."""
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
    """Study from the nested tables of a study file; `origin` stands as the source of values that name none."""
    for key in raw:
        if key not in _TOP:
            raise StudyError(f"{printable(key)} is not a known key{nearest(key, _TOP)}; a study has {', '.join(_TOP)}")
    for key, longest in (("title", LONGEST_TITLE), ("description", 10_000)):
        said = raw.get(key, "")
        if not isinstance(said, str) or len(said) > longest:
            raise StudyError(f"{key} = {quoted(said)} must be text of up to {longest} letters")
        if not said.replace("\n", "" if key == "description" else "\n").isprintable() and said:
            raise StudyError(f"{key} = {quoted(said)} must be text without control characters")
    for key in ("scenarios", "duty"):
        if not isinstance(raw.get(key, {}), dict):
            raise StudyError(f"{key} = {quoted(raw[key])} must be tables [{key}.NAME]")
    for key in ("requirement", "drives"):
        if not isinstance(raw.get(key), dict) or not raw[key]:
            said = f"= {quoted(raw[key])} must be" if raw.get(key) else "is missing: write"
            raise StudyError(f"{key} {said} a table [{key}{'.NAME' if key == 'drives' else ''}]")

    problems: list[str] = []
    rows: list[Provenance] = []
    remarks = Remarks()
    drives, titles, requirement = {}, {}, None
    try:
        tree = over_base(annotated(raw["requirement"], "requirement", origin), "requirement", remarks)
        requirement = built(Requirement, tree, "requirement", "requirement", rows)
    except StudyError as found:
        problems += found.lines
    for drive, description in raw["drives"].items():
        where = f"drives.{drive}"
        try:
            _check_name("drives", drive, raw["drives"])
            if not isinstance(description, dict):
                raise StudyError(f"{where} = {quoted(description)} must be a table [{where}]")
            tree = over_base(annotated(description, where, origin), where, remarks)
            kind = _type_of(tree, where)
            titles[drive] = tree.pop("title", drive)
            drives[drive] = built(DRIVES[kind], tree, where, drive, rows)
            remarks.warnings.extend(f"{where}.transmission: {said}" for said in _overstress(drives[drive]))
        except StudyError as found:
            problems += found.lines
    scenarios: dict[str, Any] = {}
    duty: dict[str, Any] = {}
    load_mass = requirement.load_mass if requirement else None
    for group, kind, made in (("scenarios", Scenario, scenarios), ("duty", DutyCycle, duty)):
        for task, description in raw.get(group, {}).items():
            try:
                _check_name(group, task, raw[group])
                one = _task(description, group, kind, task, origin, path)
                walks = isinstance(one, DutyCycle) and one.shape == "walking"  # its torque moves the leg's mass, too
                made[task] = one if one.load_mass is not None or walks else replace(one, load_mass=load_mass)
            except StudyError as found:
                problems += found.lines
    rig, spread = Rig(), Uncertainty()
    try:
        if "rig" in raw:
            rig = built(Rig, annotated(_table(raw["rig"], "rig"), "rig", origin), "rig", "rig", rows)
    except StudyError as found:
        problems += found.lines
    if not problems:  # spreads are those of values that hold
        spread = uncertainty_from(raw.get("uncertainty", {}), raw.get("correlations", []), drives, origin)
    remarks.warnings.extend(f"duty.{task}: {said}" for task, one in duty.items() for said in one.warnings)
    if problems or requirement is None:
        raise StudyError(*problems)
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
        uncertainty=spread,
        provenance=tuple(rows),
        reconstruction=tuple(remarks.reconstruction.values()),
        warnings=tuple(remarks.warnings),
        path=path,
    )


def _table(value: object, where: str) -> Raw:
    if not isinstance(value, dict):
        raise StudyError(f"{where} = {quoted(value)} must be a table [{where}]")
    return value


def _overstress(drive: Drive) -> Iterator[str]:
    """What the preload of a wheel exceeds, in words."""
    if isinstance(drive, CoboticDrive):
        for limit, demand in drive.transmission.utilisation.items():
            if demand > 1.0:
                yield f"{limit.words}, {demand:.2f} times what is allowed; see: infinivar contact"


def _task(
    description: object, group: str, kind: type, name: str, origin: str, path: Path | None
) -> Scenario | DutyCycle:
    """Scenario or duty cycle from its table; files that it names lie beside the study."""
    where = f"{group}.{name}"
    if not isinstance(description, dict):
        raise StudyError(f"{where} = {quoted(description)} must be a table [{where}]")
    # What is asked for is no fact with a source, so nothing is noted of where its values come from.
    tree = over_base(annotated(description, where, origin), where, Remarks())
    for table in (tree, tree.get("motion", {}), tree.get("force", {})):
        file = table.get("file")
        if path is not None and isinstance(file, dict) and isinstance(file.get("value"), str):
            file["value"] = str(path.parent / file["value"])
    return built(kind, {"title": name, **tree}, where, name, [])


def _check_name(group: str, drive: str, others: Iterable[str]) -> None:
    """Names of drives and scenarios become names of files."""
    if not _NAME.fullmatch(drive):
        raise StudyError(f"{group}.{short(repr(drive))} must be named with up to 64 letters, digits, - and _ only")
    twin = next((other for other in others if other.lower() == drive.lower()), drive)
    if twin != drive:
        raise StudyError(
            f"{group}.{drive} and {group}.{twin} differ in case only, which not every file system tells apart"
        )


def _type_of(tree: Raw, where: str) -> str:
    """Take the type out of a drive's table; where there is none, a misspelt key may be why."""
    kind = tree.pop("type", None)
    if kind in DRIVES:
        return kind
    if kind is not None:
        raise StudyError(f"{where}.type = {quoted(kind)} must be {' or '.join(DRIVES)}{nearest(kind, DRIVES)}")
    known = dict.fromkeys(key for part in DRIVES.values() for key in keys(part))
    unknown = [f"{where}.{printable(key)} is not a known key{nearest(key, known)}" for key in tree if key not in known]
    missing = f"{where}.type is missing: must be {' or '.join(DRIVES)}, unless base names a shipped drive"
    raise StudyError(*(unknown or [missing]))


def shipped_study(name: str) -> Study:
    """Study of everything in a shipped parameter set: its requirement, all its drives, scenarios and duty cycles.

    Raises
    ------
    InputError
        If there is no such set.
    """
    shipped = parameter_set(name)
    drives = {drive: {"base": f"{name}.{drive}"} for drive in shipped["drives"]}
    tasks = {
        group: {task: {"base": f"{name}.{task}"} for task in shipped.get(group, {})} for group in ("scenarios", "duty")
    }
    raw = {"title": shipped["title"], "requirement": {"base": name}, "drives": drives, **tasks}
    return study_from(raw, name=name, origin=name)
