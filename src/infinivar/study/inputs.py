"""Files that a study is made of: none of them may be replaced by a result of the study."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from infinivar.motion.files.fields import FILE_KEYS
from infinivar.motion.vectors import COORDINATES
from infinivar.parts.tables.stores import places
from infinivar.study.extend import extended_file, parts_of
from infinivar.study.load import read_tables
from infinivar.study.study import Study

STUDY, BELOW, PARTS, RECORDING = "the study itself", "a study that it extends", "a set of parts", "a recording"
ROBOT = "the model of a robot"
"""What an input is, in words."""


def input_files(study: Study, beside: Iterable[Path] = ()) -> dict[Path, str]:
    """Files that a study was read from, and what each is; those of sets whether or not the study names one of their parts.

    Parameters
    ----------
    study : Study
    beside : paths   More files and folders with sets of parts.

    Raises
    ------
    InputError
        If the study's file has become invalid since it was read.
    """
    found: dict[Path, str] = {}
    stores = [*beside]
    path = study.path
    while path is not None and path not in found and path.is_file():
        found[path] = BELOW if found else STUDY
        raw = read_tables(path)
        stores += [path.parent / one for one in parts_of(raw)]
        path = extended_file(path.parent, raw["extends"]) if "extends" in raw else None
    for task in (*study.duty.values(), *study.scenarios.values(), *study.paths.values()):
        for name in ("motion", "force", *COORDINATES):
            for file in (getattr(getattr(task, name, None), key, None) for key in FILE_KEYS):
                if file:
                    found.setdefault(Path(file), RECORDING)
    for drive in study.drives.values():
        for key in getattr(type(drive), "FILES", ()):
            found.setdefault(Path(getattr(drive, key)), ROBOT)
    for one in study.sessions.values():
        for file, words in one.files.items():
            found.setdefault(file, words)
    for folder in stores:  # one by one: a set hides those of the same name in later folders
        for place in places([folder]):
            if place.path is not None:
                found.setdefault(place.path, PARTS)
    return found
