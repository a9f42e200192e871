"""Save a study as TOML that loads to the same study; tables and keys derive from the fields, as in `schema`."""

from __future__ import annotations

import collections
import dataclasses
import os
import re
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from infinivar import units
from infinivar._core import toml
from infinivar._core.fields import described, hints, in_kinds, part_of
from infinivar._core.result import equal
from infinivar._core.toml import Inline
from infinivar.axis import LINEAR
from infinivar.errors import InputError, printable
from infinivar.motion.files.fields import FILE_KEYS
from infinivar.motion.virtual.meshes import MeshFile
from infinivar.motion.virtual.tasks import TASKS
from infinivar.study import extensions
from infinivar.study.check import check_study
from infinivar.study.load import study_from_dict
from infinivar.study.messages import StudyError, quoted
from infinivar.study.provenance import DEFAULT, Provenance, Rows, by_field, recorded, same, text_of, unscaled
from infinivar.study.schema import (
    DRIVES,
    ORIGIN,
    Key,
    drive_type,
    kinds_for,
    table_keys,
)
from infinivar.study.sessions import SessionTask
from infinivar.study.spreads import DRAWS, Spread, Uncertainty
from infinivar.study.study import Study

Raw = dict[str, Any]


def to_toml(study: Study, folder: str | Path | None = None) -> str:
    """Return the text of a study file that loads to this study; see `Study.to_toml`."""
    return _Writing(study, None if folder is None else Path(folder)).text()


def save_study(study: Study, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a study to a TOML file that loads to the same study (``==``).

    Each value is written as the study's own file stated it, with its kind and source; values given in Python in a usual
    unit, or in SI where only that gives exactly the same number. Recordings are named by their path from the new file; data
    without a file are written as CSV beside it.

    Parameters
    ----------
    study : Study
    path : str or Path   Ends in ``.toml``.
    overwrite : bool     Whether to replace files that exist; comments and layout of a replaced file are lost.

    Returns
    -------
    Path   Of the file written.

    Raises
    ------
    InputError
        If a value cannot be stated in a file, the message names it, or if a file exists or cannot be written. Nothing is
        written then.
    """
    check_study(study)
    path = Path(path)
    if path.suffix != ".toml":
        raise InputError(f"{printable(path)}: must end in .toml")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".infinivar-") as scratch:
            writing = _Writing(study, path.parent, Path(scratch), path.stem)
            files = {path.name: writing.text(), **writing.files}
            taken = [name for name in files if (path.parent / name).exists()]
            if taken and not overwrite:
                raise InputError(
                    f"{printable(path.parent / taken[0])}: already exists; set overwrite=True to replace it"
                )
            for name, text in files.items():
                (Path(scratch) / name).write_text(text, "utf-8", newline="\n")
            for name in files:
                (Path(scratch) / name).replace(path.parent / name)
    except OSError as problem:
        raise InputError(f"{printable(path)}: cannot be written: {problem.strerror}") from problem
    return path


@dataclass(slots=True)
class _Writing:
    """A study being written."""

    study: Study
    folder: Path | None
    """Folder to which paths are relative."""
    scratch: Path | None = None
    """Folder for data that have no file; without it they cannot be written."""
    stem: str = ""
    files: dict[str, str] = dataclasses.field(default_factory=dict)
    """Data written beside the study, by name of the file."""
    rows: Rows = dataclasses.field(init=False)

    def __post_init__(self) -> None:
        self.rows = by_field(self.study.provenance)

    def text(self) -> str:
        """Text of the file; checked to give the same study."""
        try:
            text = toml.dumps(self._tables())
        except StudyError as problems:
            raise InputError("\n".join(f"{self.study.name}: {line}" for line in problems.lines)) from None
        self._check(text)
        return text

    def _check(self, text: str) -> None:
        """Refuse a text that does not give the same study; this would take values that no file can state."""
        tables = tomllib.loads(text)
        for name in self.files:  # not in place yet
            tables = _with_file(tables, name, str((self.scratch or Path()) / name))
        folder = Path() if self.folder is None else self.folder
        again = study_from_dict(tables, name=self.study.name, folder=folder.absolute())
        for field in dataclasses.fields(Study):
            if field.compare and not equal(getattr(self.study, field.name), getattr(again, field.name)):
                raise InputError(
                    f"{self.study.name}: {_difference(self.study, again, field.name)} cannot be stated in a study file"
                )

    def _tables(self) -> Raw:
        study = self.study
        made: Raw = {} if study.name == self.stem else {"name": study.name}
        if study.title != study.name:
            made["title"] = study.title
        if study.description:
            made["description"] = study.description
        if study.reconstruction:
            made["reconstruction"] = list(study.reconstruction)
        if study.requirement is not None:
            made["requirement"] = self._sourced(study.requirement.stated, "requirement", "requirement")
        if study.envelope is not None:
            made["envelope"] = self._sourced(study.envelope, "envelope", "envelope")
        made["drives"] = {name: self._drive(name) for name in study.drives}
        for group in ("scenarios", "duty", "tasks", "paths"):
            if tasks := getattr(study, group):
                made[group] = {name: self._task(one, f"{group}.{name}", name) for name, one in tasks.items()}
        for name, one in study.sessions.items():
            made.setdefault("tasks", {})[name] = self._session(one, f"tasks.{name}", name)
        if any(owner == "rig" for owner, _ in self.rows):
            made["rig"] = self._sourced(study.rig, "rig", "rig")
        return {**made, **_spreads(study.uncertainty)}

    def _drive(self, name: str) -> Raw:
        drive, path = self.study.drives[name], f"drives.{name}"
        kind = type(drive)
        word = DRIVES.word_of(kind) or extensions.word_of("infinivar.drives", kind, drive_type)
        if word is None:
            raise StudyError(
                f"{path} is a {type(drive).__name__}, for which there is no type in study files; register it by the entry "
                "point group infinivar.drives"
            )
        title = self.study.titles[name]
        return {"type": word, **({} if title == name else {"title": title}), **self._sourced(drive, path, name)}

    def _sourced(self, instance: Any, path: str, owner: str) -> Raw:
        """Table of a drive, the requirement and so on; a source that several values share is stated once."""
        return _headed(_table(instance, path, owner, self.rows), ("", ""))

    def _session(self, one: SessionTask, path: str, name: str) -> Raw:
        """Table of a task of a session."""
        word = next(word for word, kind in TASKS.items() if type(one.task) is kind)
        title, untitled = _without_title(one.task, path, name)
        task = _table(untitled, path, path, self.rows)
        made = _headed({**task, **_table(one, path, path, self.rows)}, ("", ""))
        made = self._kinds(one.task, {"type": word, **title, **made}, path)
        return self._kinds(one, made, path)

    def _task(self, one: Any, path: str, name: str) -> Raw:
        """Table of a scenario, a duty cycle, or a task or path of a machine."""
        title, untitled = _without_title(one, path, name)
        return {**title, **self._kinds(one, self._sourced(untitled, path, path), path)}

    def _kinds(self, task: Any, made: Raw, path: str, prefix: str = "") -> Raw:
        """A table with the values of a task that come in kinds, with their sources if it has some.

        `path` is that of the table, `prefix` that of its fields in the provenance of the task.
        """
        owner = path.removesuffix(f".{prefix.removesuffix('.')}") if prefix else path
        for field in in_kinds(type(task)):
            value, key, flat = getattr(task, field.name), field.metadata["key"], field.metadata["flat"]
            if value is None or (flat and key in made):  # a session states its task itself
                continue
            here = path if flat else f"{path}.{field.name}"
            word = _word(field, type(value), here)
            inside = prefix if flat else f"{prefix}{field.name}."
            stored = hasattr(type(value), "read")
            around = (made.get(ORIGIN[0], ""), made.get(ORIGIN[1], ""))
            inner = _table(value, here, owner, self.rows, inside, FILE_KEYS if stored else ())
            table = {key: word, **_headed(inner, around)}
            row = self.rows.get((owner, f"{inside}{key}"))
            if row is not None and row.where != DEFAULT:
                source = {"kind": row.kind, "where": row.where}
                if any(table.get(name, said) != source[name] for name, said in zip(ORIGIN, around, strict=True)):
                    table[key] = Inline(value=word, **source)
            if stored:
                table |= self._file(value, here, table)
            elif isinstance(value, MeshFile):
                table["file"] = self._named(value.file)
            for one in FILE_KEYS:
                row = self.rows.get((owner, f"{inside}{one}"))
                stated = one in table and table[one] not in self.files
                if row is not None and stated and (table.get("kind"), table.get("where")) != (row.kind, row.where):
                    table[one] = Inline(value=table[one], kind=row.kind, where=row.where)
            table = self._kinds(value, table, here, inside)
            made = {**made, **table} if flat else {**made, field.name: table}
        return made

    def _named(self, file: str) -> str:
        """Path of a file as the study names it."""
        found = Path(file).absolute()
        return found.as_posix() if self.folder is None else _relative(found, self.folder)

    def _file(self, value: Any, path: str, table: Raw) -> Raw:
        """Key `file` of a motion or force: the path of its data; without a file, they become one.

        Keys on how to read the lost file do not apply to the new one, and are taken out of the table.
        """
        given = {
            field.name: getattr(value, field.name)
            for field in described(type(value))
            if field.name in table or (field.name in FILE_KEYS[1:] and getattr(value, field.name))
        }
        if os.path.isfile(value.file) and _reads(value, {**given, "file": value.file}):  # noqa: PTH113 (raises on odd names)
            return {key: self._named(getattr(value, key)) for key in FILE_KEYS if getattr(value, key, None)}
        if self.scratch is None:
            raise StudyError(f"{path}.file: the data have no file; save_study writes them beside the study")
        name = f"{self.stem}-{path.replace('.', '-')}.csv"
        self.files[name] = _csv(value)
        there = self.scratch / name
        there.write_text(self.files[name], "utf-8", newline="\n")
        for field in described(type(value)):
            if not field.compare:
                table.pop(field.name, None)
                given.pop(field.name, None)
        if not _reads(value, {**given, "file": str(there)}):
            raise StudyError(f"{path}.file: the data have no file, and cannot be written as CSV")
        return {"file": name}


def _without_title(task: Any, path: str, name: str) -> tuple[Raw, Any]:
    """The title of a task, unless it is its name, and the task without it: a title has no source."""
    key = table_keys(type(task))["title"]
    title = {} if task.title == name else {"title": _raw(key, task.title, [task.title], f"{path}.title")}
    return title, dataclasses.replace(task, title="")


def _word(field: dataclasses.Field[Any], kind: type, path: str) -> str:
    """The word by which a study asks for a kind of a field; of another package if it is registered."""
    word = next((word for word, one in field.metadata["kinds"].items() if one is kind), None)
    word = word or extensions.word_of(f"infinivar.{field.name}s", kind, lambda word: kinds_for(field, word)[word])
    if word is None:
        raise StudyError(
            f"{path}: a {kind.__name__} has no {field.metadata['key']} in study files; register it by the entry point group "
            f"infinivar.{field.name}s"
        )
    return word


def _reads(value: Any, given: Mapping[str, Any]) -> bool:
    """Whether reading a file gives the value."""
    try:
        return type(value).read(**given) == value
    except (InputError, TypeError):
        return False


def _relative(file: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file, folder.absolute())).as_posix()
    except ValueError:  # another drive of Windows
        return file.as_posix()


def _with_file(value: Any, name: str, there: str) -> Any:
    """The tables with another path for one file."""
    if isinstance(value, dict):
        return {
            key: there if key == "file" and one == name else _with_file(one, name, there) for key, one in value.items()
        }
    return value


def _csv(value: Any) -> str:
    """The arrays of a motion or force as columns, with numbers that give the same floats."""
    axis = getattr(value, "axis", LINEAR)
    headings = {
        "time": "time [s]",
        "position": f"{axis.position} [{axis.position_unit}]",
        "speed": f"{axis.speed} [{axis.speed_unit}]",
        "force": f"{axis.force} [{axis.force_unit}]",
    }
    columns = {
        heading: getattr(value, name).tolist()
        for name, heading in headings.items()
        if isinstance(getattr(value, name, None), np.ndarray)
    }
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n"


def _headed(table: Raw, around: tuple[str, str]) -> Raw:
    """The table with its most frequent kind and source at its head, unless they are those of the table around it.

    The source of a single value stays with it where it would also stand above inner tables.
    """
    counts = collections.Counter((one["kind"], one["where"]) for one in table.values() if _has_source(one))
    usual, most = counts.most_common(1)[0] if counts else (around, 0)
    head: Raw = {}
    whole = not any(isinstance(value, dict) and not isinstance(value, Inline) for value in table.values())
    if most > counts[around] and (most > 1 or (whole and not around[0])):
        head, around = dict(zip(ORIGIN, usual, strict=True)), usual
    made: Raw = {**head}
    for key, value in table.items():
        if _has_source(value):
            rest = {"value": value["value"]}
            rest |= {name: value[name] for name, said in zip(ORIGIN, around, strict=True) if value[name] != said}
            made[key] = Inline(rest) if len(rest) > 1 else value["value"]
        else:
            made[key] = _headed(value, around) if isinstance(value, dict) and not isinstance(value, Inline) else value
    return made


def _has_source(value: Any) -> bool:
    return isinstance(value, Inline) and value.keys() == {"value", *ORIGIN}


def _table(instance: Any, path: str, owner: str, rows: Rows, prefix: str = "", skip: Sequence[str] = ()) -> Raw:
    """Table of a part, by its fields; values with a known source are tables of their own."""
    single = unscaled(instance, rows, owner, prefix) if hasattr(instance, "scaled") else None
    instance = instance if single is None else single
    made: Raw = {}
    keys = table_keys(type(instance))
    for field in described(type(instance)):
        value, here = getattr(instance, field.name), f"{path}.{field.name}"
        if value is None or field.name in skip:
            continue
        inner = part_of(hints(type(instance))[field.name])
        if inner is not None:
            table = _part(value, inner, here, owner, rows, f"{prefix}{field.name}.")
            # A part with nothing to state is there nevertheless, unless it is by default.
            if table or field.default_factory is dataclasses.MISSING:
                made[field.name] = table
        elif (
            found := _field(field, keys[field.name], value, here, rows.get((owner, prefix + field.name)))
        ) is not None:
            made[field.name] = found
    if single is not None:
        scale = rows[owner, f"{prefix}scale"]
        made["scale"] = _field(None, keys["scale"], scale.value, f"{path}.scale", scale)
    return made


def _part(value: Any, inner: type, path: str, owner: str, rows: Rows, prefix: str) -> Raw:
    if type(value) is inner:
        return _table(value, path, owner, rows, prefix)
    word = extensions.word_of("infinivar.parts", type(value), extensions.part)
    if word is None or not issubclass(type(value), inner):
        raise StudyError(
            f"{path} is a {type(value).__name__}, which a study file cannot state, only a {inner.__name__}; register it by "
            "the entry point group infinivar.parts"
        )
    return {extensions.VARIANT: word, **_table(value, path, owner, rows, prefix)}


def _field(field: dataclasses.Field[Any] | None, key: Key, value: Any, path: str, row: Provenance | None) -> Any:
    """A value as it stands in a file: bare, or with its source; None for a default that needs no mention."""
    if row is not None and not same(row.value, recorded(value)):
        row = None
    if row is not None and row.where == DEFAULT:
        return None  # which the part chooses again, by its other values
    if row is None and field is not None and same(value, field.default):
        return None
    texts = [] if row is None else [row.written]
    raw = _raw(key, value, [*texts, *([] if field is None else [text_of(field, value)])], path)
    return raw if row is None else Inline(value=raw, kind=row.kind, where=row.where)


def _raw(key: Key, value: Any, texts: Iterable[str], path: str) -> Any:
    """The first form of a value that the key reads as the same value."""
    assert key.read is not None
    for raw in _candidates(value, texts) if key.several is None else _lists(texts):
        try:
            if same(key.read(raw).value, value):
                return raw
        except ValueError:
            continue
    raise StudyError(f"{path} = {quoted(value)} cannot be stated in a study file")


def _candidates(value: Any, texts: Iterable[str]) -> Iterator[Any]:
    """What TOML could hold for a value, whose texts are these."""
    if isinstance(value, bool):
        yield value
    elif isinstance(value, Mapping):
        yield Inline(value)
    elif isinstance(value, tuple):
        yield from ([next(_forms(one)) for one in text.split(", ")] for text in texts)
    else:
        yield from (raw for text in texts for raw in _forms(text))


def _lists(texts: Iterable[str]) -> Iterator[list[Inline]]:
    """What TOML holds for several tables, whose texts are these, as `text_of` writes them."""
    for text in texts:
        yield [Inline(re.findall(r"(\w+) = (.*?)(?:, (?=\w+ = )|$)", one)) for one in text.split("; ")]


def _forms(text: str) -> Iterator[Any]:
    """What TOML could hold for a text: a number if it is written as Python writes it, or the text."""
    for number in (int, float):
        try:
            if str(number(text)) == text:
                yield number(text)
        except ValueError:
            continue
    yield text


def _spreads(uncertainty: Uncertainty) -> Raw:
    """Tables of the spreads and their correlations."""
    made: Raw = {} if uncertainty.draws == DRAWS else {"draws": uncertainty.draws}
    for drive, spreads in uncertainty.spreads.items():
        table = made.setdefault(drive, {})
        for spread in spreads:
            *outer, last = spread.path.split(".")
            inner = table
            for step in outer:
                inner = inner.setdefault(step, {})
            inner[last] = _spread(spread)
    pairs = [
        {"drive": drive, "between": [one, other], "value": value}
        for (drive, one, other), value in uncertainty.correlations.items()
    ]
    return {**({"uncertainty": made} if made else {}), **({"correlations": pairs} if pairs else {})}


def _spread(spread: Spread) -> Inline:
    def written(value: float) -> Any:
        text = units.exact(value, spread.unit)
        return next(_forms(text)) if spread.unit == "1" else text

    if spread.deviation is not None:
        size = {"deviation": written(spread.deviation)}
    else:
        size = {"low": written(spread.low), "high": written(spread.high)}
    return Inline(**size, kind=spread.kind, where=spread.where)


def _difference(study: Study, again: Study, name: str) -> str:
    """Path of the first value that differs."""
    one, other = getattr(study, name), getattr(again, name)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return next((f"{name}.{key}" for key in one if key not in other or not equal(one[key], other[key])), name)
    return name
