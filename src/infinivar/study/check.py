"""Check, before computing anything, that the drives of a study have the values its motions need."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from typing import Any

from infinivar._core.arrays import shown
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import axis_fault, check_drive, is_machine, smoothness_fault, type_words
from infinivar.drivetrain.graphs.closed_loop import closed_loop
from infinivar.errors import InputError, ParameterError
from infinivar.machines.machine import as_machine
from infinivar.motion.vectors import ROTATIONS, TRANSLATIONS
from infinivar.study.study import Study


def check_duty(study: Study) -> None:
    """Refuse a study whose drives cannot follow its duty cycles, or that requires a joint of drives along a line.

    Raises
    ------
    InputError
        One line for each drive that lacks a value, with the name of the value.
    """
    _refuse(_machine_faults(study))
    _refuse([*_axis_faults(study), *_duty_faults(study)])


def check_study(study: Any) -> None:
    """Raise ParameterError unless it is a study; the message says what to write in place of a name."""
    if not isinstance(study, Study):
        named = isinstance(study, str | PathLike)
        how = f"; write iv.load_study({str(study)!r})" if named else ""
        raise ParameterError(f"study must be a Study, got {repr(study) if named else shown(study)}{how}")


def check_machines(study: Study) -> None:
    """Refuse a study whose drives lack a coordinate that its tasks or paths state, or machines with a requirement of one axis.

    Raises
    ------
    InputError
        One line for each drive and task that do not fit.
    """
    _refuse(_machine_faults(study))


def check_demands(study: Study, command: str) -> None:
    """Refuse a study that states sessions of a user only to a command that needs what the drives must do.

    Raises
    ------
    InputError
        With what to do instead.
    """
    if study.sessions and not any((study.tasks, study.paths, study.duty, study.requirement)):
        names = ", ".join(f"tasks.{name}" for name in study.sessions)
        raise InputError(
            f"{names}: what a user does at a handle is run with infinivar session; {command} needs a motion, a requirement, "
            "or, for a machine, a path or a task without type"
        )


def check_spreads(study: Study) -> None:
    """Refuse spreads of a drive of another package, of which no builds can be sampled.

    Raises
    ------
    InputError
        One line for each such drive.
    """
    _refuse(_spread_faults(study))


def check(study: Study) -> None:
    """Refuse a study whose drives cannot follow its duty cycles, or with scenarios that none of its drives can run.

    Raises
    ------
    InputError
        One line per fault.
    """
    _refuse(_machine_faults(study))
    _refuse([*_axis_faults(study), *_duty_faults(study), *_scenario_faults(study), *_spread_faults(study)])


def _refuse(faults: Iterator[str] | list[str]) -> None:
    lines = list(faults)
    if lines:
        raise InputError("\n".join(lines))


def _machine_faults(study: Study) -> Iterator[str]:
    stated = next((key for key in ("requirement", "duty", "scenarios") if getattr(study, key)), None)
    for name, drive in study.drives.items():
        if is_machine(drive) and stated is not None:
            yield (
                f"{stated} is of drives of one axis; drives.{name} is a machine of type {type_words(drive)}: state what it must "
                "do in tables [tasks.NAME] or [paths.NAME]"
            )
            continue
        known = as_machine(drive).coordinates
        words = f"drives.{name} has {', '.join(known)} only"
        for group, requests in (("tasks", study.tasks), ("paths", study.paths)):
            for task, one in requests.items():
                for key, vector in one.vectors.items():
                    for coordinate in vector.beyond(known):
                        yield f"{group}.{task}.{key}.{coordinate} does not apply: {words}"
        for task, path in study.paths.items():
            for coordinate in path.beyond(known):
                yield f"paths.{task}.{coordinate} does not apply: {words}"
            for key, moved in (("load_mass", TRANSLATIONS), ("load_inertia", (*ROTATIONS, "angle"))):
                if getattr(path, key) is not None and not set(moved) & set(known):
                    yield f"paths.{task}.{key} does not apply: {words}"


def _axis_faults(study: Study) -> Iterator[str]:
    required = study.requirement
    if required is None:
        return
    for name, drive in study.drives.items():
        fault = axis_fault(drive, required.axis, f"drives.{name}", "requirement.moment")
        if fault is not None and required.axis.rotary:
            yield fault
        elif fault is not None:
            yield f"requirement.force is along a line; drives.{name} moves a joint: write moment and angular_speed"


def _duty_faults(study: Study) -> Iterator[str]:
    if not study.duty:
        return
    tasks = ", ".join(f"duty.{task}" for task in study.duty)
    for name, drive in study.drives.items():
        try:
            check_drive(drive, f"drives.{name}", ("operate", "follow"))
        except ParameterError as problem:
            yield f"{problem}, for {tasks}"
            continue
        try:
            getattr(drive, "check_motion", lambda: None)()
        except ParameterError as problem:
            yield f"drives.{name}: {problem}, for {tasks}"
            continue
        for task, cycle in study.duty.items():
            where = f"duty.{task}", f"drives.{name}"
            found = axis_fault(drive, cycle.axis, where[1], where[0]) or smoothness_fault(
                drive, cycle, where[1], where[0]
            )
            if found is not None:
                yield found


def _spread_faults(study: Study) -> Iterator[str]:
    for name, spreads in study.uncertainty.spreads.items():
        drive = study.drives.get(name)
        if spreads and not isinstance(drive, (CoboticDrive, ConventionalDrive)):
            yield (
                f"uncertainty.{name}: builds of {_described(drive)} cannot be sampled; those of a cobotic or conventional "
                "drive can"
            )


def _described(drive: object) -> str:
    """A drive by its type, such as 'a machine of type platform'."""
    return f"a {'machine' if is_machine(drive) else 'drive'} of type {type_words(drive)}"


def _scenario_faults(study: Study) -> Iterator[str]:
    for task, scenario in study.scenarios.items():
        found = {}
        for name, drive in study.drives.items():
            if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
                found[name] = f"{_described(drive)} has no bond graph"
                continue
            fault = axis_fault(drive, scenario.axis, f"drives.{name}", f"scenarios.{task}")
            if fault is not None:
                found[name] = fault
                continue
            try:
                closed_loop(drive, scenario)
            except ParameterError as problem:
                found[name] = str(problem)
        if len(found) == len(study.drives):
            reasons = "; ".join(f"drives.{name}: {reason}" for name, reason in found.items())
            yield f"scenarios.{task}: no drive can run it: {reasons}"
