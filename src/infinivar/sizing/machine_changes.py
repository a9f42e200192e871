"""Which values of an infeasible machine, changed, would bring it within all limits of the tasks and paths of its study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.bounds import ends
from infinivar._core.fields import quantities_of, value_at
from infinivar._core.frozen import FrozenDict
from infinivar.analysis.machines import MachineComparison, tasks_and_paths
from infinivar.analysis.performing import Prepared, power_and_margin
from infinivar.errors import InputError, ParameterError
from infinivar.sizing.mending import Demands, mending
from infinivar.sizing.what_if import Change
from infinivar.study.study import Study
from infinivar.units import plain, show

SOUGHT = (
    "preload", "wheel_radius", "cylinder_radius", "radius", "pulley_radius", "ratio", "cylinder_speed", "input_speed",
    "continuous_torque", "torque_constant", "voltage", "largest_push",
)  # fmt: skip
"""Fields that a designer chooses: of the contact, the gear and the motor."""

_SPAN = 5.0
"""Values are looked at from a fifth to five times the present one."""

TOGETHER = 2
"""Values that are changed together at most."""

_OFFERED = 4
"""Changes stated."""


def sufficient_changes(study: Study, machine: Any) -> tuple[Mapping[str, Change], ...]:
    """Changes that bring a machine within all limits, by path of the field: of one value, or where none is enough of two.

    Parameters
    ----------
    study : Study   With tasks or paths.
    machine         One of its machines by name, or another one.

    Returns
    -------
    tuple   The smallest change first; empty if the machine is feasible, or nothing tried is enough. Values of wheels, cylinder,
        gears and motors are tried from a fifth to five times the present one.
    """
    drive, demands = study.drives[machine] if isinstance(machine, str) else machine, machine_demands(study)
    if np.all(demands(drive) <= 1.0):
        return ()
    return mending(drive, _looked_at(drive), demands, TOGETHER)


def machine_demands(study: Study) -> Demands:
    """Demands over allowances of a machine: the largest in each task and on each path of a study."""
    wanted = tasks_and_paths(study)

    def demands(made: Any) -> np.ndarray:
        try:
            margins = [margin for _, margin in power_and_margin(made, Prepared(made, wanted)).values()]
        except InputError as problem:  # such as a pose out of reach
            raise ParameterError(str(problem)) from problem
        return np.array([1.0 / margin if margin > 0.0 else np.inf for margin in margins])

    return demands


def sought(path: str) -> bool:
    """Whether a field of a machine is one that a designer chooses."""
    return path.rpartition(".")[2] in SOUGHT


def _looked_at(drive: Any) -> dict[str, tuple[float, float]]:
    """Least and largest value looked at of each field."""
    found = {}
    for path, field in quantities_of(drive).items():
        value = value_at(drive, path)
        if sought(path) and isinstance(value, float) and value > 0.0:
            least, most = ends(field.metadata["bound"])
            found[path] = (max(value / _SPAN, least), min(value * _SPAN, most))
    return found


def with_changes(comparison: MachineComparison, progress: Any = None) -> MachineComparison:
    """The comparison with what would make each infeasible machine feasible, in words."""
    missed = [one for one in comparison.results.values() if not one.feasible]
    said = {}
    for place, one in enumerate(missed):
        if progress is not None:
            progress(f"changes that suffice: {one.title}", place / len(missed))
        said[one.name] = change_words(comparison.study, comparison.study.drives[one.name])
    return replace(comparison, changes=FrozenDict(said))


def change_words(study: Study, machine: Any) -> tuple[str, ...]:
    """The smallest of `sufficient_changes`, in words."""
    return tuple(_words(machine, each) for each in sufficient_changes(study, machine)[:_OFFERED])


def _words(drive: Any, changes: Mapping[str, Change]) -> str:
    """Such as "wheel.preload 541 N (2.71 times)"."""
    fields = quantities_of(drive)
    return " and ".join(
        f"{path} {show(change.stated, fields[path].metadata['unit'])} ({plain(change.times, 3)} times)"
        for path, change in changes.items()
    )
