"""The study with all its fields, opening and writing study files, and the shipped studies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from infinivar._core.toml import edited
from infinivar.analysis.plane import MAP_REACH, of_study
from infinivar.analysis.robustness.foremost import foremost as ranked
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine, type_words
from infinivar.errors import nearest
from infinivar.study.load import read_tables
from infinivar.study.schema import DRIVES
from infinivar.study.shipped import shipped_studies
from infinivar.study.study import Study
from infinivar.web.answers.answer import Answer, FaultyError, RefusedError
from infinivar.web.answers.document import (
    faults_by_field,
    name_and_tables,
    study_of,
    tables_of,
)
from infinivar.web.answers.fields import fields_of
from infinivar.web.answers.motion import shaken
from infinivar.web.answers.payload import text, word

LARGEST_TEXT = 400_000
"""Characters of a study file that is opened in the page."""


def study(payload: Mapping[str, Any]) -> Answer:
    """Everything about a study but its maps: titles, warnings, fields, the plane of the maps, motions and tasks."""
    found = study_of(payload)
    return Answer(
        header={
            "name": found.name,
            "title": found.title,
            "description": found.description,
            "warnings": list(found.warnings),
            "reconstruction": list(found.reconstruction),
            "plane": plane_of(found),
            "drives": [
                {
                    "name": name,
                    "title": found.titles[name],
                    "type": _type_of(drive),
                    "machine": is_machine(drive),
                }
                for name, drive in found.drives.items()
            ],
            "fields": fields_of(found),
            "requirement": required_of(found),
            "shakes": not isinstance(shaken(found, {}), str)
            and any(isinstance(drive, CoboticDrive | ConventionalDrive) for drive in found.drives.values()),
            "motions": _titled(found.duty),
            "scenarios": _titled(found.scenarios),
            "tasks": _titled(found.tasks),
            "paths": _titled(found.paths),
            "sessions": _titled(found.sessions),
            "faults": [],
        }
    )


def foremost(payload: Mapping[str, Any]) -> Answer:
    """Paths of the values of a `drive` that matter most, the first one most; none for machines and drives of other packages."""
    found = study_of(payload)
    drive = found.drives[word(payload, "drive", found.drives)]
    known = isinstance(drive, CoboticDrive | ConventionalDrive) and bool(found.requirement or found.duty)
    return Answer(header={"paths": list(ranked(found, payload["drive"])) if known else []})


def _titled(tasks: Mapping[str, Any]) -> list[dict[str, str]]:
    return [{"name": name, "title": one.title or name} for name, one in tasks.items()]


def _type_of(drive: Any) -> str:
    """The type of a drive as a study file names it."""
    if is_machine(drive):
        return type_words(drive)
    return next((word for word, kind in DRIVES.items() if type(drive) is kind), type(drive).__name__)


def plane_of(study: Study) -> dict[str, Any] | None:
    """Extent and units of the force-speed plane; None for machines."""
    if study.tasks or study.paths or study.sessions or not (study.duty or study.requirement):
        return None
    plane, axis = of_study(study), study.axis
    lows, highs = plane.low, plane.high
    reach = MAP_REACH * plane.speed, MAP_REACH * plane.force
    speed, force = ([low * size, high * size] for low, high, size in zip(lows, highs, reach, strict=True))
    return {
        "speed": speed,
        "force": force,
        "speed_unit": axis.speed_unit,
        "force_unit": axis.force_unit,
        "speed_name": axis.speed,
        "force_name": axis.force,
    }


def required_of(study: Study) -> dict[str, Any] | None:
    """What is required, as the maps draw it: the largest force and speed, and the outline of the region."""
    required = study.requirement
    if required is None:
        return None
    from infinivar.figures.operating_map import outline_of

    outline, signs = outline_of(required)
    return {
        "force": required.force,
        "speed": required.speed,
        "power": required.power,
        "quadrants": required.quadrants,
        "outline": outline[::8],
        "signs": signs,
    }


def opened(payload: Mapping[str, Any]) -> Answer:
    """Name, tables and text of a study file."""
    content = text(payload, "text", longest=LARGEST_TEXT)
    name = text(payload, "name").removesuffix(".toml") or "study"
    tables = tables_of(content, name)
    stated = tables.pop("name", name)
    found = {"name": stated if isinstance(stated, str) else name, "tables": tables, "text": content}
    study_of(found)
    return Answer(header=found)


def toml(payload: Mapping[str, Any]) -> Answer:
    """The text of the study file: with `text`, that of the file that was opened, its comments and layout stay."""
    name, tables = name_and_tables(payload)
    before = text(payload, "text", "", LARGEST_TEXT)
    study_of(payload)
    named = {"name": name} if "name" in tables_of(before, name) else {}
    try:
        content = edited(before, named | tables)
    except TypeError as problem:
        raise FaultyError([{"at": "", "message": str(problem)}]) from None
    with faults_by_field(name):
        tables_of(content, name)
    return Answer(header={"name": name, "text": content, "file": f"{file_stem(name)}.toml"})


def file_stem(name: str) -> str:
    """A name as the name of a file."""
    return "".join(letter if letter.isalnum() or letter in "-_" else "-" for letter in name)[:64] or "study"


def shipped(payload: Mapping[str, Any]) -> Answer:
    """Name, tables and text of a shipped study."""
    which = text(payload, "which")
    known = shipped_studies()
    if which not in known:
        raise RefusedError(f"which: there is no shipped study {which!r}{nearest(which, known)}")
    tables = read_tables(known[which])
    return Answer(header={"name": tables.pop("name", which), "tables": tables, "text": known[which].read_text("utf-8")})
