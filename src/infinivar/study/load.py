"""Load a study file into a frozen `Study`: read it, lay it over the shipped sets, validate, build."""

from __future__ import annotations

import contextlib
import functools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from infinivar._core import files, plugins, toml
from infinivar.drivetrain.drive import Drive
from infinivar.drivetrain.envelope import Envelope
from infinivar.errors import InputError, ParameterError, nearest, path_of, printable
from infinivar.motion.duty_cycles import DutyCycle, shares_of
from infinivar.motion.files.fields import FILE_KEYS
from infinivar.motion.machine_tasks import MachinePath, MachineTask
from infinivar.motion.scenario import Scenario
from infinivar.motion.vectors import COORDINATES
from infinivar.study.build import built
from infinivar.study.extend import PARTS_FOLDER, extended, parts_of, unknown_keys
from infinivar.study.layers import INNER, LONGEST_TITLE, Raw, Remarks, annotated, layered, legs_over_base, over_base
from infinivar.study.messages import StudyError, quoted, short
from infinivar.study.provenance import Provenance
from infinivar.study.requirement import JOINT_ONLY, LINE_ONLY, JointRequirement, Requirement
from infinivar.study.rig import Rig
from infinivar.study.schema import DRIVES, drive_type, keys, suggestion
from infinivar.study.sessions import SessionTask, beside_study
from infinivar.study.shipped import shared_set, study_file
from infinivar.study.spreads import Uncertainty, uncertainty_from
from infinivar.study.study import Study, machine_shares

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
    path = study_file(path_of(path, "path"))
    with _reporting(printable(path)):
        raw = extended(read_tables(path), path, read_tables)
        return study_from(raw, name=_name_in(raw, path.stem), origin=path.name, path=path)


def study_from_dict(tables: Mapping[str, Any], *, name: str, folder: str | Path | None = None) -> Study:
    """Build a study from nested tables; see `Study.from_dict`."""
    if not isinstance(name, str) or not name.strip() or len(name) > LONGEST_TITLE or not name.isprintable():
        raise InputError(f"name must be text of 1 to {LONGEST_TITLE} characters, got {quoted(name)}")
    if not isinstance(tables, Mapping):
        raise InputError(f"{name}: must be tables by name, got {quoted(tables)}")
    place = Path() if folder is None else Path(folder)
    with _reporting(printable(name)):
        raw = extended(plain_table(tables, ""), place / name, read_tables)
        return study_from({key: raw[key] for key in raw if key != "name"}, name=name, origin=name, folder=place)


@contextlib.contextmanager
def _reporting(source: str) -> Iterator[None]:
    """Report faults in a study as one error, each line with the source: a file, or a name."""
    try:
        yield
    except RecursionError as problem:
        raise InputError(f"{source}: is nested too deeply") from problem
    except StudyError as problems:
        lines = [f"{source}: {line}" for line in problems.lines[:_MOST]]
        more = len(problems.lines) - len(lines)
        raise InputError("\n".join([*lines, f"... and {more} more faults"] if more else lines)) from None
    except ParameterError as problem:  # of parts that do not go together
        raise InputError(f"{source}: {problem}") from problem


def _name_in(raw: Raw, otherwise: str) -> str:
    """The name that a study states; by default that of its file."""
    _check_text(raw, "name", LONGEST_TITLE)
    return raw.get("name") or otherwise


def plain_table(table: Mapping[Any, Any], path: str) -> Raw:
    """A copy of a table with values of TOML only: text, numbers, lists and tables.

    Raises
    ------
    StudyError
        If it holds anything else.
    """
    for key in table:
        if not isinstance(key, str):
            raise StudyError(f"{path or 'the study'} has the key {quoted(key)}, which must be text")
    return {key: _plain(value, f"{path}.{key}" if path else key) for key, value in table.items()}


def _plain(value: Any, path: str) -> Any:
    if isinstance(value, Mapping):
        return plain_table(value, path)
    if isinstance(value, list | tuple):
        return [_plain(one, path) for one in value]
    if isinstance(value, Path):
        return str(value)
    if type(value).__module__ == "numpy" and hasattr(value, "tolist"):
        return _plain(value.tolist(), path)
    if not isinstance(value, str | int | float):
        raise StudyError(f"{path} = {quoted(value)} must be text, a number, a list or a table")
    return value


def read_tables(path: Path) -> Raw:
    """Read the tables of a study file, as written."""
    content = files.read(path, _MOST_BYTES)
    try:
        return toml.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as problem:
        raise InputError(f"{printable(path)}: is not a text file in UTF-8 (byte {problem.start})") from problem
    except InputError as problem:
        raise InputError(f"{printable(path)}: {problem}") from problem


def study_from(raw: Raw, *, name: str, origin: str, path: Path | None = None, folder: Path | None = None) -> Study:
    """Build a study from the nested tables of its file.

    Parameters
    ----------
    raw : dict      Tables, those of extended files included.
    name : str      Name of the study.
    origin : str    Source of values that state none.
    path : Path     The file, if there is one.
    folder : Path   Folder of the files that the tables name; defaults to that of the file.
    """
    loading = _Loading({}, origin, path.parent if folder is None and path is not None else folder)
    loading.raw = loading.sections(raw)
    loading.beside = tuple(loading.places_of_parts())
    requirement = loading.requirement()
    drives, titles = loading.drives()
    scenarios = loading.tasks("scenarios", Scenario)
    duty = loading.tasks("duty", DutyCycle)
    tasks = loading.tasks("tasks", MachineTask)
    sessions = {name: one for name, one in tasks.items() if isinstance(one, SessionTask)}
    tasks = {name: one for name, one in tasks.items() if name not in sessions}
    paths = loading.tasks("paths", MachinePath)
    envelope = loading.envelope()
    rig = loading.rig()
    with loading.collecting():
        if len(duty) == len(loading.raw.get("duty", {})):  # the share of an invalid table is not known
            shares_of(duty)
        groups = (("tasks", {**tasks, **sessions}), ("paths", paths))
        if all(len(found) == len(loading.raw.get(group, {})) for group, found in groups):
            machine_shares(tasks, paths)
    uncertainty = loading.uncertainty(drives)
    if loading.faults:
        raise StudyError(*loading.faults)
    return Study(
        name=name,
        title=raw.get("title", name),
        description=raw.get("description", ""),
        requirement=requirement,
        drives=drives,
        titles=titles,
        scenarios=scenarios,
        duty=duty,
        tasks=tasks,
        paths=paths,
        sessions=sessions,
        envelope=envelope,
        rig=rig,
        uncertainty=uncertainty,
        provenance=tuple(loading.rows),
        reconstruction=tuple(dict.fromkeys([*loading.remarks.reconstruction.values(), *raw.get("reconstruction", [])])),
        path=path,
    )


def _faults_at_top(raw: Raw) -> Iterator[tuple[str, str]]:
    """Yield each invalid top-level key of a study, and what is wrong with it."""
    unknown = unknown_keys(raw)
    yield from unknown.items()
    for key, longest, lines in (("title", LONGEST_TITLE, False), ("description", _LONGEST_DESCRIPTION, True)):
        try:
            _check_text(raw, key, longest, lines=lines)
        except StudyError as found:
            yield key, found.lines[0]
    for key in ("scenarios", "duty", "tasks", "paths"):
        if not isinstance(raw.get(key, {}), dict):
            yield key, f"{key} = {quoted(raw[key])} must be tables [{key}.NAME]"
    statements = raw.get("reconstruction", [])
    if not isinstance(statements, list) or not all(isinstance(text, str) and text.strip() for text in statements):
        yield "reconstruction", f"reconstruction = {quoted(statements)} must be a list of texts"
    for key, table in (("requirement", "requirement"), ("drives", "drives.NAME")):
        if key in raw and raw[key] != {} and not isinstance(raw[key], dict):
            yield key, f"{key} = {quoted(raw[key])} must be a table [{table}]"
    if not unknown:  # a misspelt key may be what is missing
        yield from _what_is_missing(raw)


def _what_is_missing(raw: Raw) -> Iterator[tuple[str, str]]:
    """Yield what a study lacks at its top level, or has beside what excludes it."""
    required = [key for key in ("requirement", "duty", "scenarios", "envelope") if raw.get(key)]
    of_machines = [key for key in ("tasks", "paths") if raw.get(key)]
    if of_machines:
        for key in required:
            yield (
                key,
                f"{key} does not apply beside {of_machines[0]}: {key} is of drives of one axis, tasks and paths of machines; "
                "write two studies",
            )
    elif not raw.get("requirement") and not raw.get("duty"):
        yield (
            "requirement",
            "requirement is missing: write a table [requirement], or a motion in a table [duty.NAME]; for a machine, a table "
            "[tasks.NAME] or [paths.NAME]",
        )
    if not raw.get("drives"):
        yield "drives", "drives is missing: write a table [drives.NAME]"


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
    folder: Path | None
    faults: list[str] = field(default_factory=list)
    beside: tuple[Path, ...] = ()
    rows: list[Provenance] = field(default_factory=list)
    remarks: Remarks = field(default_factory=Remarks)

    @contextlib.contextmanager
    def collecting(self) -> Iterator[None]:
        """Collect the faults raised within; values that could not be built are missing from the study."""
        try:
            yield
        except StudyError as found:
            self.faults += found.lines
        except InputError as found:
            self.faults.append(str(found))

    def sections(self, raw: Raw) -> Raw:
        """The sections that can be read; what is wrong with the others is a fault."""
        found = list(_faults_at_top(raw))
        self.faults += [fault for _, fault in found]
        wrong = {key for key, _ in found}
        return {key: value for key, value in raw.items() if key not in wrong}

    def places_of_parts(self) -> Iterator[Path]:
        """Yield the files and folders of sets of parts: by default the folder `parts` beside the study, if there is one."""
        if self.folder is None:
            return
        with self.collecting():
            named = parts_of(self.raw)
            for name in named:
                path = self.folder / name
                if path.exists():
                    yield path
                elif path.name != PARTS_FOLDER:
                    self.faults.append(f"parts = {quoted(name)}: no such file or folder")

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
        faults: dict[str, list[str]] = {}
        for drive, description in self.raw.get("drives", {}).items():
            where = f"drives.{drive}"
            try:
                _check_name("drives", drive, self.raw["drives"])
                tree = self._like(drive, _table(description, where), where)
                tree = over_base(tree, where, self.remarks)
                kind = _type_of(tree, where)
                self._beside(kind, tree)
                titles[drive] = tree.pop("title", drive)
                drives[drive] = built(kind, tree, where, drive, self.rows, self.beside)
            except StudyError as found:
                faults[drive] = list(found.lines)
        for drive, lines in faults.items():
            known = self._known(drive, faults)
            self.faults += [line for line in lines if line not in known]
        return drives, titles

    def _beside(self, kind: type, tree: Raw) -> None:
        """Resolve the files that a drive names against the folder of the study."""
        for key in getattr(kind, "FILES", ()):
            file = tree.get(key)
            if self.folder is not None and isinstance(file, dict) and isinstance(file.get("value"), str):
                file["value"] = str((self.folder / file["value"]).absolute())

    def _known(self, drive: str, faults: Mapping[str, list[str]]) -> set[str]:
        """Faults of a drive that are those of the drives that it is like, where they are reported."""
        known: set[str] = set()
        others, name, seen = self.raw["drives"], drive, {drive}
        while isinstance(others.get(name), dict):
            like = others[name].get("like")
            if not isinstance(like, str) or like in seen:
                break
            name = like
            seen.add(name)
            stated = re.compile(rf"\bdrives\.{re.escape(name)}(?![\w-])")
            known |= {stated.sub(lambda _: f"drives.{drive}", line) for line in faults.get(name, ())}
        return known

    def _like(self, drive: str, description: Raw, where: str, seen: tuple[str, ...] = ()) -> Raw:
        """The table of a drive, laid over that of another drive of the study if it names one by `like`."""
        tree = legs_over_base(annotated(description, where, self.origin), where, self.remarks)
        like = tree.pop("like", None)
        if like is None:
            return tree
        others = self.raw.get("drives", {})
        seen = (*seen, drive)
        if like not in others or like in seen:
            known = [name for name in others if name not in seen]
            words = f"the name of another drive{nearest(like, known)}" + (f": {', '.join(known)}" if known else "")
            raise StudyError(f"{where}.like = {quoted(like)} must be {words}")
        under = self._like(like, _table(others[like], f"drives.{like}"), f"drives.{like}", seen)
        under.pop("title", None)
        for key in INNER:  # a drive within that starts from a base of its own takes nothing from the other
            if isinstance(description.get(key), dict) and "base" in description[key]:
                under.pop(key, None)
        if "base" in under and "base" in tree:
            raise StudyError(f"{where}.base does not apply beside like, as drives.{like} has a base; remove one")
        if "type" in tree and tree["type"] != under.get("type", tree["type"]):
            raise StudyError(
                f"{where}.type = {tree['type']!r} must be {under['type']!r} as that of {like}; correct or remove it"
            )
        return layered(under, tree)

    def tasks(self, group: str, kind: type) -> dict[str, Any]:
        """Build the scenarios, duty cycles, tasks or paths, by name."""
        made = {}
        for task, description in self.raw.get(group, {}).items():
            with self.collecting():
                _check_name(group, task, self.raw[group])
                rows = self.rows if group in ("tasks", "paths") else []
                made[task] = _task(description, group, kind, task, self.origin, self.folder, rows)
        return made

    def envelope(self) -> Envelope | None:
        """Build the envelope; None if the study states none."""
        with self.collecting():
            if "envelope" in self.raw:
                tree = annotated(_table(self.raw["envelope"], "envelope"), "envelope", self.origin)
                return built(Envelope, tree, "envelope", "envelope", self.rows)
        return None

    def rig(self) -> Rig:
        with self.collecting():
            if "rig" in self.raw:
                return built(
                    Rig, annotated(_table(self.raw["rig"], "rig"), "rig", self.origin), "rig", "rig", self.rows
                )
        return Rig()

    def uncertainty(self, drives: Mapping[str, Drive]) -> Uncertainty:
        """Read the spreads; they refer to values of the drives, so those of invalid drives are not checked."""
        with self.collecting():
            requested = self.raw.get("drives", {})
            raw = self.raw.get("uncertainty", {})
            if isinstance(raw, dict):
                raw = {key: table for key, table in raw.items() if key in drives or (drives and key not in requested)}
            invalid = len(drives) < len(requested) or not requested
            return uncertainty_from(raw, [] if invalid else self.raw.get("correlations", []), drives, self.origin)
        return Uncertainty()


def _table(value: object, where: str) -> Raw:
    if not isinstance(value, dict):
        raise StudyError(f"{where} = {quoted(value)} must be a table [{where}]")
    return value


def _task(
    description: object, group: str, kind: type, name: str, origin: str, folder: Path | None, rows: list[Provenance]
) -> Any:
    """Build a scenario, duty cycle, task or path from its table; file paths are relative to the folder.

    Runs and motions are requests, not facts with a source, so that their provenance is not recorded. Tasks and paths of machines
    are their requirement, so that it is.
    """
    where = f"{group}.{name}"
    tree = over_base(annotated(_table(description, where), where, origin), where, Remarks())
    if group == "tasks" and "type" in tree:
        beside_study(tree, folder)
        tree["type"] = {"value": tree["type"]}
        return built(SessionTask, {"title": name, **tree}, where, where, rows)
    for table in (tree, *(tree.get(key, {}) for key in ("motion", "force", *COORDINATES))):
        for file in (table.get(key) for key in FILE_KEYS):
            if folder is not None and isinstance(file, dict) and isinstance(file.get("value"), str):
                file["value"] = str(folder / file["value"])
    return built(kind, {"title": name, **tree}, where, where, rows)


def _check_name(group: str, drive: str, others: Iterable[str]) -> None:
    """Refuse names that cannot become file names."""
    if not _NAME.fullmatch(drive):
        raise StudyError(f"{group}.{short(repr(drive))} must have a name of at most 64 letters, digits, - and _")
    twin = next((other for other in others if other.lower() == drive.lower()), drive)
    if twin != drive:
        raise StudyError(
            f"{group}.{drive} and {group}.{twin} differ only in case; rename one, as some file systems ignore case"
        )


def _type_of(tree: Raw, where: str) -> type:
    """Pop the type from a drive's table; if it is missing, report misspelt keys first."""
    kind = tree.pop("type", None)
    if kind == "arm" and "model" in tree:
        kind = "robot"
    try:
        found = drive_type(kind)
    except InputError as problem:
        raise StudyError(f"{where}.type: {problem}") from None
    if found is not None:
        return found
    if kind is not None:
        words = [*DRIVES, *plugins.registered("infinivar.drives")]
        raise StudyError(f"{where}.type = {quoted(kind)} must be one of {', '.join(words)}{nearest(kind, words)}")
    parts = DRIVES.values()
    known = {key for part in parts for key in keys(part)}
    unknown = [
        f"{where}.{printable(key)} is not a known key{suggestion(key, parts)}" for key in tree if key not in known
    ]
    missing = f"{where}.type is missing: write one of {', '.join(DRIVES)}, or name a shipped drive as base"
    raise StudyError(*(unknown or [missing]))


@functools.cache
def shipped_study(name: str) -> Study:
    """Return a study of a whole shipped parameter set, read once: its requirement, drives, scenarios and duty cycles.

    Raises
    ------
    InputError
        If no set has that name.
    """
    shipped = shared_set(name)
    drives = {drive: {"base": f"{name}.{drive}"} for drive in shipped["drives"]}
    tasks = {
        group: {task: {"base": f"{name}.{task}"} for task in shipped.get(group, {})} for group in ("scenarios", "duty")
    }
    raw = {"title": shipped["title"], "requirement": {"base": name}, "drives": drives, **tasks}
    return study_from(raw, name=name, origin=name)
