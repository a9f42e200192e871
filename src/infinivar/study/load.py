"""From a study file to a frozen `Study`: read, lay over the shipped sets, validate, build."""

from __future__ import annotations

import dataclasses
import re
import tomllib
import typing
from importlib import resources
from pathlib import Path
from typing import Any

import pydantic

from infinivar.drivetrain.requirement import Requirement
from infinivar.errors import InputError, nearest
from infinivar.parts import catalogue
from infinivar.parts.motor import Motor
from infinivar.study.messages import explained, plain, quoted, short
from infinivar.study.schema import CATALOGUES, DRIVES, KINDS, Entry, part_of, table
from infinivar.study.study import Provenance, Study

_TOP = ("title", "description", "requirement", "drives")
# Keys that steer how a table is read; all other keys are fields of the part it describes.
_DIRECTIVES = ("base", "part", "type", "title")
_HEAD = ("base", "type", "title", "kind", "where")
_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
_LONGEST_TITLE = 120
_MOST = 12
"""Faults listed at once."""

Raw = dict[str, Any]


class _StudyError(Exception):
    """Faults found in a study, each "field = value must be ..."; the caller adds the file."""

    def __init__(self, *lines: str) -> None:
        super().__init__(*lines)
        self.lines = lines


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
    try:
        raw = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except FileNotFoundError as problem:
        raise InputError(f"{path}: no such file") from problem
    except IsADirectoryError as problem:
        raise InputError(f"{path}: is a folder, not a study file") from problem
    except OSError as problem:
        raise InputError(f"{path}: cannot be read: {problem.strerror}") from problem
    except UnicodeDecodeError as problem:
        raise InputError(f"{path}: is not a text file in UTF-8 (byte {problem.start})") from problem
    except ValueError as problem:  # TOMLDecodeError, or a number with thousands of digits
        raise InputError(f"{path}: is not valid TOML: {str(problem).partition(';')[0]}") from problem
    except RecursionError as problem:
        raise InputError(f"{path}: is nested too deeply") from problem
    try:
        return study_from(raw, name=path.stem, origin=path.name, path=path)
    except RecursionError as problem:
        raise InputError(f"{path}: is nested too deeply") from problem
    except _StudyError as problems:
        lines = [f"{path}: {line}" for line in problems.lines[:_MOST]]
        more = len(problems.lines) - len(lines)
        raise InputError("\n".join([*lines, f"and {more} more"] if more else lines)) from None


def study_from(raw: Raw, *, name: str, origin: str, path: Path | None = None) -> Study:
    """Study from the nested tables of a study file; `origin` stands as the source of values that name none."""
    for key in raw:
        if key not in _TOP:
            raise _StudyError(f"{plain(key)} is not a known key{nearest(key, _TOP)}; a study has {', '.join(_TOP)}")
    for key, longest in (("title", _LONGEST_TITLE), ("description", 10_000)):
        if not isinstance(raw.get(key, ""), str) or len(raw.get(key, "")) > longest:
            raise _StudyError(f"{key} = {quoted(raw[key])} must be text of up to {longest} letters")
    for key in ("requirement", "drives"):
        if not isinstance(raw.get(key), dict) or not raw[key]:
            said = f"= {quoted(raw[key])} must be" if raw.get(key) else "is missing: write"
            raise _StudyError(f"{key} {said} a table [{key}{'.NAME' if key == 'drives' else ''}]")

    problems: list[str] = []
    rows: list[Provenance] = []
    reconstruction: dict[str, str] = {}
    drives, titles, requirement = {}, {}, None
    seen: list[str] = []
    try:
        tree = _over_base(_annotated(raw["requirement"], "requirement", origin), "requirement", reconstruction)
        requirement = _built(Requirement, tree, "requirement", "requirement", rows)
    except _StudyError as found:
        problems += found.lines
    for drive, description in raw["drives"].items():
        where = f"drives.{drive}"
        try:
            if not _NAME.fullmatch(drive):
                raise _StudyError(
                    f"drives.{short(repr(drive))} must be named with up to 64 letters, digits, - and _ only"
                )
            twin = next((other for other in raw["drives"] if other != drive and other.lower() == drive.lower()), None)
            if twin is not None and twin in seen:
                raise _StudyError(
                    f"{where} and drives.{twin} differ in case only, which not every file system tells apart"
                )
            seen.append(drive)
            if not isinstance(description, dict):
                raise _StudyError(f"{where} = {quoted(description)} must be a table [{where}]")
            tree = _over_base(_annotated(description, where, origin), where, reconstruction)
            kind = tree.pop("type", None)
            if kind is None:
                known = dict.fromkeys(
                    [*_HEAD, *(field.name for part in DRIVES.values() for field in dataclasses.fields(part))]
                )
                unknown = [key for key in tree if key not in known]
                if unknown:
                    raise _StudyError(
                        *(f"{where}.{plain(key)} is not a known key{nearest(key, known)}" for key in unknown)
                    )
            if kind not in DRIVES:
                said = "is missing" if kind is None else f"= {kind!r}{nearest(str(kind), DRIVES)} is not known"
                raise _StudyError(
                    f"{where}.type {said}: must be {' or '.join(DRIVES)}, unless base names a shipped drive"
                )
            titles[drive] = tree.pop("title", drive)
            drives[drive] = _built(DRIVES[kind], tree, where, drive, rows)
        except _StudyError as found:
            problems += found.lines
    if problems or requirement is None:
        raise _StudyError(*problems)
    return Study(
        name=name,
        title=raw.get("title", name),
        description=raw.get("description", ""),
        requirement=requirement,
        drives=drives,
        titles=titles,
        provenance=tuple(rows),
        reconstruction=tuple(reconstruction.values()),
        path=path,
    )


def shipped_study(name: str) -> Study:
    """Study of everything in a shipped parameter set: its requirement and all its drives.

    Raises
    ------
    InputError
        If there is no such set.
    """
    shipped = parameter_set(name)
    drives = {drive: {"base": f"{name}.{drive}"} for drive in shipped["drives"]}
    raw = {"title": shipped["title"], "requirement": {"base": name}, "drives": drives}
    return study_from(raw, name=name, origin=name)


def parameter_sets() -> tuple[str, ...]:
    """Names of the shipped parameter sets."""
    files = resources.files("infinivar.study") / "sets"
    return tuple(sorted(file.name.removesuffix(".toml") for file in files.iterdir() if file.name.endswith(".toml")))


def parameter_set(name: str) -> Raw:
    """Nested tables of a shipped parameter set, as written.

    Raises
    ------
    InputError
        If there is no such set; the message lists those there are.
    """
    if name not in parameter_sets():
        raise InputError(
            f"{name!r} is not a shipped parameter set{nearest(name, parameter_sets())}; "
            f"there is {', '.join(parameter_sets())}"
        )
    return tomllib.loads((resources.files("infinivar.study") / "sets" / f"{name}.toml").read_text("utf-8"))


def _annotated(tree: Any, path: str, where: str, kind: str = "assumed") -> Raw:
    """The table with kind and where spelled out at every value, so that tables of two sources can be laid over."""
    kind, where = tree.get("kind", kind), tree.get("where", where)
    if kind not in KINDS:
        raise _StudyError(f"{path}.kind = {quoted(kind)} must be one of {', '.join(KINDS)}{nearest(str(kind), KINDS)}")
    if not isinstance(where, str):
        raise _StudyError(f"{path}.where = {quoted(where)} must be text that names the source")
    result: Raw = {}
    for key, value in tree.items():
        if key in ("kind", "where"):
            continue
        if key in _DIRECTIVES:
            if not isinstance(value, str) or len(value) > _LONGEST_TITLE:
                raise _StudyError(f"{path}.{key} = {quoted(value)} must be text of up to {_LONGEST_TITLE} letters")
            result[key] = value
        elif not isinstance(value, dict):
            result[key] = {"value": value, "kind": kind, "where": where}
        elif "value" in value:
            result[key] = {"kind": kind, "where": where, **value}
        else:
            result[key] = _annotated(value, f"{path}.{key}", where, kind)
    return result


def _merged(under: Raw, over: Raw) -> Raw:
    """Table `under` with everything that `over` says instead; a table that names a part starts afresh."""
    if "part" in over:
        return over
    result = dict(under)
    for key, value in over.items():
        below = result.get(key)
        tables = isinstance(value, dict) and "value" not in value and isinstance(below, dict) and "value" not in below
        result[key] = _merged(typing.cast(Raw, below), value) if tables else value
    return result


def _over_base(tree: Raw, path: str, reconstruction: dict[str, str]) -> Raw:
    """The table laid over the shipped one that its `base` names, if any; notes what that set reconstructs."""
    base = tree.pop("base", None)
    if base is None:
        return tree
    name, _, member = base.partition(".")
    try:
        shipped = parameter_set(name)
        if path == "requirement":
            if member or "requirement" not in shipped:
                raise InputError(f"{base!r} must be the name of a parameter set, such as 'faulring2006'")
            under = shipped["requirement"]
        else:
            choices = [f"{name}.{drive}" for drive in shipped["drives"]]
            if base not in choices:
                raise InputError(
                    f"{base!r} is not a shipped drive{nearest(base, choices)}; {name} has {', '.join(choices)}"
                )
            under = shipped["drives"][member]
    except InputError as problem:
        raise _StudyError(f"{path}.base = {quoted(base)}: {problem}") from None
    if "reconstruction" in shipped:
        reconstruction[name] = shipped["reconstruction"]
    under = _annotated(under, path, shipped["source"])
    if "type" in tree and tree["type"] != under.get("type"):
        raise _StudyError(
            f"{path}.type = {tree['type']!r} must be {under['type']!r}, as base {base!r} is, or be left out"
        )
    return _merged(under, tree)


def _over_parts(part: type, tree: Raw, path: str) -> Raw:
    """The table with every `part` key replaced by that catalogue entry's values."""
    result = dict(tree)
    name = result.pop("part", None)
    if name is not None:
        if part not in CATALOGUES:
            raise _StudyError(
                f"{path}.part = {quoted(name)}: only a motor or a gearhead can be taken from the catalogue"
            )
        try:
            entry = catalogue.entry(CATALOGUES[part], name)
        except InputError as problem:
            raise _StudyError(f"{path}.part = {problem}") from None
        result = _merged(_annotated(entry, path, "catalogue"), result)
    hints = typing.get_type_hints(part)
    for key, value in result.items():
        inner = part_of(hints.get(key))
        if inner is not None and "value" in value:
            hint = ' with part = "..."' if inner in CATALOGUES else ""
            raise _StudyError(f"{path}.{key} = {quoted(value['value'])} must be a table [{path}.{key}]{hint}")
        if inner is not None:
            result[key] = _over_parts(inner, value, f"{path}.{key}")
    return result


def built_part(part: type, key: str) -> Any:
    """A motor or gearhead as the catalogue has it.

    Raises
    ------
    InputError
        If the catalogue has no such part.
    """
    try:
        return _built(part, {"part": key}, CATALOGUES[part], key, [])
    except _StudyError as problems:
        raise InputError("\n".join(problems.lines)) from None


def _built(part: type, tree: Raw, path: str, owner: str, rows: list[Provenance]) -> Any:
    """The dataclass that a table describes; appends the provenance of its values to `rows`."""
    tree = _over_parts(part, tree, path)
    try:
        checked = table(part).model_validate(tree)
    except pydantic.ValidationError as problem:
        raise _StudyError(*(explained(error, part, path) for error in problem.errors(include_url=False))) from None
    return _instance(part, checked, path, owner, "", rows)


def _instance(part: type, checked: Any, path: str, owner: str, prefix: str, rows: list[Provenance]) -> Any:
    """Dataclass instance from a validated table, its parts first."""
    hints = typing.get_type_hints(part)
    values: dict[str, Any] = {}
    for field in dataclasses.fields(part):
        given = getattr(checked, field.name)
        unit = field.metadata.get("unit", "")
        here = f"{prefix}{field.name}"
        inner = part_of(hints[field.name])
        if isinstance(given, Entry):
            values[field.name] = given.value
            rows.append(_row(owner, here, given, unit))
        elif inner is not None and given is not None:
            values[field.name] = _instance(inner, given, f"{path}.{field.name}", owner, f"{here}.", rows)
        elif inner is not None and field.default_factory is not dataclasses.MISSING:
            empty = table(inner).model_validate({})
            values[field.name] = _instance(inner, empty, f"{path}.{field.name}", owner, f"{here}.", rows)
        elif inner is None and field.default not in (None, dataclasses.MISSING) and field.name != "name":
            default = Entry(field.default, field.default, "assumed", "default of the program")
            rows.append(_row(owner, here, default, unit))
    try:
        instance = part(**values)
    except ValueError as problem:
        raise _StudyError(f"{path}.{problem}") from None
    if part is Motor and instance.no_load_current > (stall := instance.voltage / instance.resistance):
        raise _StudyError(
            f"{path}.no_load_current = {instance.no_load_current:g} A must be below the stall current {stall:.3g} A"
        )
    scale = getattr(checked, "scale", None)
    if part is Motor and scale is not None:
        rows.append(_row(owner, f"{prefix}scale", scale, "1"))
        instance = instance.scaled(scale.value)
    return instance


def _row(owner: str, field: str, entry: Entry, unit: str) -> Provenance:
    return Provenance(
        owner=owner,
        field=field,
        written=str(entry.written),
        value=entry.value,
        unit=unit,
        kind=entry.kind or "assumed",
        where=entry.where or "",
    )
