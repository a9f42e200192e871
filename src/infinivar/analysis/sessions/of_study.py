"""Sessions of a study: its task, user and sensors, with one of its drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from infinivar.analysis.sessions.session import Setup
from infinivar.analysis.sessions.session_result import Session
from infinivar.errors import InputError, nearest
from infinivar.study.check import check_study
from infinivar.study.sessions import check_settings, session_arguments
from infinivar.study.study import Study


def study_session(
    study: Study,
    task: str | None = None,
    drive: str | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> Session:
    """Simulate a session that a study states in a table ``[tasks.NAME]`` with a `type`.

    Parameters
    ----------
    study : Study
    task : str            Its name; by default the first.
    drive : str           Whose handle is held; by default that of the task, or the first of the study.
    progress : callable   Called with the share done.

    Returns
    -------
    Session

    Raises
    ------
    InputError
        If a name is unknown, or the drive cannot do the task; the message names the place.
    """
    check_study(study)
    setup = Setup(**_arguments(study, *named_session(study, task, drive)))
    return setup.over(progress or (lambda share: None))


def _arguments(study: Study, task: str, drive: str) -> dict[str, Any]:
    """Of `Setup`."""
    one = study.sessions[task]
    found = session_arguments(one, study.drives[drive], f"tasks.{task}", f"drives.{drive}")
    return {**found, "title": f"{study.titles[drive]}, {one.title}"}


def named_session(study: Study, task: str | None, drive: str | None) -> tuple[str, str]:
    """Names of a session's task and drive, by default the first ones.

    Raises
    ------
    InputError
        If the study has no sessions, or none of that name, or no such drive.
    """
    if not study.sessions:
        raise InputError(
            'the study has no tasks of sessions: add a table [tasks.NAME] with a type, such as type = "caster"'
        )
    if task is None:
        task = next(iter(study.sessions))
    task = task.removeprefix("tasks.")
    if task in study.tasks:
        raise InputError(
            f"tasks.{task} is steady, without a user: infinivar compare judges it; sessions: {_listed(study)}"
        )
    if task not in study.sessions:
        raise InputError(f"task {task!r} is not in the study{nearest(task, study.sessions)}; it has {_listed(study)}")
    chosen = study.sessions[task].drive if drive is None else drive
    if chosen is None:
        chosen = next(iter(study.drives))
    if chosen not in study.drives:
        place = f"tasks.{task}.drive = {chosen!r}" if drive is None else f"drive {chosen!r}"
        raise InputError(
            f"{place} is no drive of the study{nearest(chosen, study.drives)}; it has {', '.join(study.drives)}"
        )
    return task, chosen


def check_sessions(study: Study) -> None:
    """Refuse a study with a session that cannot begin: each is simulated for one sample.

    Raises
    ------
    InputError
        One line for each such session.
    """
    faults = []
    for name in study.sessions:
        try:
            checked_session(study, *named_session(study, name, None))
        except InputError as problem:
            faults.append(str(problem))
    if faults:
        raise InputError("\n".join(faults))


def checked_session(study: Study, task: str, drive: str) -> Setup:
    """A session set up, of which one sample has been simulated.

    Raises
    ------
    InputError
        If it cannot begin; with the place of the fault.
    """
    arguments = _arguments(study, task, drive)
    check_settings(study.sessions[task], study.drives, f"tasks.{task}")
    try:
        setup = Setup(**arguments)
        setup.check_begins()
    except InputError as problem:
        raise InputError(f"tasks.{task}: {problem}") from None
    return setup


def _listed(study: Study) -> str:
    return ", ".join(f"tasks.{name}" for name in study.sessions)


__all__ = ["check_sessions", "checked_session", "named_session", "study_session"]
