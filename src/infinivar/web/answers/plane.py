"""The frequency-power plane: which motions of a mass each drive can shake, and how well."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from infinivar.analysis.cycles.shaking import DynamicMap, dynamic_map
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import AuditError, ParameterError
from infinivar.limits import words_of
from infinivar.study.study import Study
from infinivar.web.answers import payload, words
from infinivar.web.answers.answer import Answer
from infinivar.web.answers.motion import motion_of

FREQUENCIES, FRACTIONS, SAMPLES = 64, 48, 80
LOWEST, HIGHEST = 0.1, 30.0
"""Ends of the frequency axis, as in Fig 17 of faulring2006. [Hz]"""


def plane(study: Study, asked: Mapping[str, Any], progress: Callable[[float], None] | None = None) -> Answer:
    """Performance of each drive in shaking a mass, over frequency and RMS power.

    Parameters
    ----------
    study : Study
    asked : mapping   drives: names, by default all; motion: duty cycle whose mass and power are meant if there is no requirement.
    progress          Called with the share done, 0 to 1.

    Returns
    -------
    Answer
        Header: reason: why there is no plane, else None; power: largest RMS power of the plane [W]; load_mass, mass_unit;
        drives: by name, title, fault, limits: words by code, from 1, best: largest performance [-], share: of the plane within
        all limits [-].
        Arrays: frequency (n,) [Hz], power (m,) [W], the middles of equal cells; by drive NAME/performance (m, n), nan outside
        limits, NAME/limit (m, n) codes, NAME/edge (n,): largest power at which the drive is within all limits at each frequency,
        0 if at none. [W]
    """
    names = payload.words(asked, "drives", study.drives) or list(study.drives)
    size = _size(study, asked)
    header: dict[str, Any] = {"reason": None, "drives": {}}
    if isinstance(size, str):
        return Answer(header={**header, "reason": size})
    power, mass = size
    frequency = LOWEST * (HIGHEST / LOWEST) ** ((np.arange(FREQUENCIES) + 0.5) / FREQUENCIES)
    fraction = (np.arange(FRACTIONS) + 0.5) / FRACTIONS
    header.update(power=power, load_mass=mass, mass_unit=study.axis.mass_unit)
    arrays: dict[str, np.ndarray] = {"frequency": frequency, "power": power * fraction}
    for place, name in enumerate(names):
        row: dict[str, Any] = {"title": study.titles[name], "fault": None}
        header["drives"][name] = row
        drive = study.drives[name]
        if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
            row["fault"] = f"drives.{name}: the plane is of drives of one axis"
            continue
        try:
            found = dynamic_map(
                drive, frequency, fraction, power=power, load_mass=mass, travel=study.travel, samples=SAMPLES
            )
        except (ParameterError, AuditError) as problem:
            row["fault"] = f"drives.{name}: {problem}"
            continue
        row["limits"] = [words_of(key) for key in found.demands]
        row["best"] = _largest(found.performance)
        row["share"] = float(np.mean(found.works))
        arrays[f"{name}/performance"] = found.performance.T
        arrays[f"{name}/limit"] = found.binding.T.astype(np.uint8)
        arrays[f"{name}/edge"] = _edge(found, power)
        if progress is not None:
            progress((place + 1) / len(names))
    return Answer(header=header, arrays=words.single(arrays))


def _size(study: Study, asked: Mapping[str, Any]) -> tuple[float, float] | str:
    """Largest power and mass of the plane, or why there are none. [W], [kg]"""
    required = study.requirement
    if required is not None and required.power and study.load_mass:
        return float(required.power), float(study.load_mass)
    wanted = motion_of(study, asked)[1] if study.duty and asked.get("motion") is not None else None
    for name, duty in study.duty.items():
        if wanted in (None, name) and duty.moved_mass:
            course = duty.instants().course
            power = np.asarray(course.driving_force(duty.moved_mass).value * course.speed)
            if np.any(power):
                return float(np.sqrt(np.mean(power * power))), float(duty.moved_mass)
    what = ("load_inertia", "moment") if study.axis.rotary else ("load_mass", "force")
    return f"shaking needs a mass and a power: state power and {what[0]} in [requirement], or {what[0]} in a duty cycle"


def _largest(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return words.number(known.max()) if known.size else None


def _edge(found: DynamicMap, power: float) -> np.ndarray:
    """Largest power within all limits at each frequency, without gaps below it, by straight lines of the demand between cells."""
    count = found.works.shape[1]
    steps = np.cumprod(found.works, axis=1).sum(axis=1)
    last, first = np.clip(steps - 1, 0, None), np.clip(steps, None, count - 1)
    rows = np.arange(len(steps))
    low, high = (1.0 / found.margin[rows, at] for at in (last, first))
    rise = high - low
    share = np.where(np.isfinite(rise) & (rise > 0.0), (1.0 - low) / np.where(rise > 0.0, rise, 1.0), 0.0)
    reached = found.fraction[last] + np.clip(share, 0.0, 1.0) * (found.fraction[first] - found.fraction[last])
    return power * np.where(steps == 0, 0.0, np.where(steps == count, 1.0, reached))
