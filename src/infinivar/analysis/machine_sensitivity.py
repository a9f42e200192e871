"""Rank the values of a machine by their effect on its power, loss or margin in a task or on a path."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.bounds import fits
from infinivar._core.described import reported
from infinivar._core.fields import quantities_of, value_at, with_values
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis.machine_tasks import PathResult, TaskResult
from infinivar.analysis.performing import follow_path, perform_task
from infinivar.drivetrain.drive import with_rated_gear
from infinivar.errors import InputError, ParameterError, nearest
from infinivar.motion.machine_tasks import MachineTask
from infinivar.study.check import check_study
from infinivar.study.layers import INNER
from infinivar.study.study import Study
from infinivar.units import show, signed

OUTCOMES = {"power": "W", "loss": "W", "margin": "1"}
"""Results whose derivatives are available, with their units."""

_STEP = 1e-3
"""Relative step of central differences; their error is of the order of its square."""

_LEAST = 1e-6
"""Elasticity below which a value counts as without effect. [-]"""


@result
class MachineInfluence(Frozen):
    """Effect of one value.

    Attributes
    ----------
    path : str             Of the field, such as "leg.transmission.preload".
    value, unit            Of the field, in SI.
    elasticity : float     Relative change of the result per relative change of the value. [-]
    """

    path: str
    value: float
    unit: str
    elasticity: float

    @property
    def words(self) -> str:
        """One line."""
        return f"{self.path} ({show(self.value, self.unit)}): {signed(self.elasticity)} % per +1 %"


@result
class MachineSensitivity(Result):
    """Effects of all values on one result, as returned by `machine_sensitivity`.

    Attributes
    ----------
    drive, task, of : str    Drive; task or path, such as "tasks.lift"; result.
    value : float            Of the result.
    feasible : bool          Whether all limits hold.
    influences : tuple       From the largest; those without effect are left out.
    left_out : tuple         Paths of values at which the result is undefined next to theirs.
    """

    drive: str = reported()
    task: str = reported()
    of: str = reported()
    value: float = reported()
    feasible: bool = reported()
    influences: tuple[MachineInfluence, ...] = reported()
    left_out: tuple[str, ...] = reported()

    @property
    def lines(self) -> Iterator[str]:
        """Yield the result, then the ten largest effects."""
        beyond = "" if self.feasible else ", limit exceeded"
        yield f"{self.of} of {self.drive} in {self.task}: {show(self.value, OUTCOMES[self.of])}{beyond}"
        yield from (f"  {one.words}" for one in self.influences[:10])


def machine_sensitivity(
    study: Study,
    drive: str,
    of: str = "power",
    *,
    task: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> MachineSensitivity:
    """Rank the values of a machine by their effect.

    Parameters
    ----------
    study : Study    With tasks or paths.
    drive : str      Name of one of its machines.
    of : str         "power" from the source, "loss", or "margin" of the tightest limit.
    task : str       Task or path, such as "tasks.lift" or "lift"; the first by default.
    progress         Called with the share of work done, 0 to 1.

    Returns
    -------
    MachineSensitivity   By central differences, at an end of a permitted range by those to one side. A margin has a kink where
        another limit becomes the tightest. Measured losses of a wheel scale with its preload, as in `sensitivity`.

    Raises
    ------
    InputError
        If a name is unknown, or the result is undefined or 0, so that it has no relative change.
    """
    check_study(study)
    if of not in OUTCOMES:
        raise InputError(f"of must be one of {', '.join(OUTCOMES)}, got {of!r}{nearest(of, OUTCOMES)}")
    name, one = task_of(study, task)
    machine = _with_rated_gears(study.drive(drive))
    perform: Any = perform_task if isinstance(one, MachineTask) else follow_path

    def outcome(made: Any) -> tuple[float, bool]:
        found: TaskResult | PathResult = perform(made, one)
        values = {"power": found.mean_power, "loss": sum(found.losses.values()), "margin": found.margin}
        return values[of], found.feasible

    value, feasible = outcome(machine)
    if not np.isfinite(value) or value == 0.0:
        raise InputError(f"drives.{drive}: {of} in {name} is {value:g}, which has no relative change")
    influences, left_out = [], []
    fields = quantities_of(machine)
    for place, (path, field) in enumerate(fields.items()):
        if progress is not None:
            progress(place / len(fields))
        at = float(value_at(machine, path))
        if at == 0.0:
            continue
        # Weights of the values at these steps, for the slope; all errors are of second order.
        ways: list[dict[int, float]] = [{-1: -0.5, 1: 0.5}, {0: -1.5, 1: 2.0, 2: -0.5}, {0: 1.5, -1: -2.0, -2: 0.5}]
        inside = [way for way in ways if all(fits(field.metadata["bound"], at * (1.0 + step * _STEP)) for step in way)]
        slope = math.nan
        if inside:
            try:
                changed = {step: outcome(_changed(machine, path, at * (1.0 + step * _STEP)))[0] for step in inside[0]}
                slope = sum(weight * changed[step] for step, weight in inside[0].items()) / (_STEP * value)
            except ParameterError:  # values that belong together
                slope = math.nan
        if not np.isfinite(slope):
            left_out.append(path)
        elif abs(slope) > _LEAST:
            influences.append(MachineInfluence(path=path, value=at, unit=field.metadata["unit"], elasticity=slope))
    influences.sort(key=lambda found: -abs(found.elasticity))
    return MachineSensitivity(
        drive=drive,
        task=name,
        of=of,
        value=value,
        feasible=feasible,
        influences=tuple(influences),
        left_out=tuple(left_out),
    )


def _changed(machine: Any, path: str, value: float) -> Any:
    """The machine with another value, to whose preload measured losses scale."""
    part, _, name = path.partition(".")
    if path == "transmission.preload":
        return machine.pressed(value)
    if name in ("preload", "transmission.preload"):
        return replace(machine, **{part: getattr(machine, part).pressed(value)})
    return with_values(machine, {path: value})


def task_of(study: Study, task: str | None) -> tuple[str, Any]:
    """A task or path by its name, with or without its group; the first one by default.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    every = {f"tasks.{name}": one for name, one in study.tasks.items()}
    every |= {f"paths.{name}": one for name, one in study.paths.items()}
    if task is None:
        return next(iter(every.items()))
    found = [name for name in every if task in (name, name.partition(".")[2])]
    if not found:
        known = [*every, *(name.partition(".")[2] for name in every)]
        raise InputError(f"task {task!r} is not in the study{nearest(task, known)}; it has {', '.join(every)}")
    return found[0], every[found[0]]


def _with_rated_gears(machine: Any) -> Any:
    """The machine with explicit rated torques of its gears, which must not follow a change of the motor."""
    inner = {key: with_rated_gear(made) for key in INNER if (made := getattr(machine, key, None)) is not None}
    return replace(machine, **inner) if inner else with_rated_gear(machine)
