"""Which values of a drive matter most in a study: a ranking that costs no more than a map."""

from __future__ import annotations

from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array, namespace
from infinivar.analysis.robustness.sensitivity import elasticities, modelled
from infinivar.errors import InputError
from infinivar.limits import binding
from infinivar.study.study import Study

_LINES = 5
"""Lines along which the required region is sampled; more change no ranking that is shown."""

_INSTANTS = 20
"""Instants of a motion."""

_LEAST = 1e-3
"""Elasticity below which a value counts as without effect. [-]"""


def foremost(study: Study, name: str) -> tuple[str, ...]:
    """Paths of the values of a drive by their effect on its mean loss or on its tightest margin, whichever is larger.

    Both are taken over the required region and the motions of the study, at steady operation: what a motion adds by
    acceleration is left to `sensitivity`, which takes seconds where this takes some ten milliseconds.

    Parameters
    ----------
    study : Study   With a requirement or motions.
    name : str      Of a drive with one axis.

    Returns
    -------
    tuple of str   From the largest elasticity; values without effect are left out. [-]

    Raises
    ------
    InputError
        If the drive is unknown or a machine, or nothing is required of it.
    """
    drive = modelled(study, name)
    points = _points(study)
    point = drive.operate(speed=points[0], force=points[1])
    able = np.isfinite(np.broadcast_to(np.asarray(point.power_in - point.power_out, dtype=float), points[0].shape))
    speed, force, weight = points[:, able] if able.any() else points

    def loss(made: Any) -> Array:
        found = made.operate(speed=speed, force=force)
        lost = found.power_in - found.power_out
        return namespace(lost).sum(lost * weight, axis=-1)

    def margin(made: Any) -> Array:
        _, found = binding(made.operate(speed=speed, force=force).utilisation)
        return -namespace(found).max(-found, axis=-1)

    effects: dict[str, float] = {}
    for of in (loss, margin):
        paths, _, found = elasticities(of, drive, "complex")
        for path, one in zip(paths, np.nan_to_num(np.abs(found)), strict=True):
            effects[path] = max(effects.get(path, 0.0), float(one))
    return tuple(sorted((path for path, one in effects.items() if one > _LEAST), key=lambda path: -effects[path]))


def _points(study: Study) -> np.ndarray:
    """Speed, force and weight over all that is required. (3, n) [m s^-1], [N], [-]"""
    found = [] if study.requirement is None else [np.stack(study.requirement.sample(_LINES))]
    for motion in study.duty.values():
        course, one = motion.instants(_INSTANTS).course, np.ones(_INSTANTS)
        found.append(np.stack([course.speed * one, course.force * one, one / _INSTANTS]))
    if not found:
        raise InputError(f"{study.name}: neither a requirement nor a motion, over which values could be ranked")
    return np.concatenate(found, axis=1)
