"""The motions of a study, and the plane of motions that its drives can perform.

`motion` answers with the course of the load, and power, energy and temperature of each drive over time; `plane` with the
frequency-power plane: which motions of a mass each drive can shake, and how well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from infinivar.analysis.cycles.duty_cycle import duty_cycle
from infinivar.analysis.cycles.duty_result import DutyResult
from infinivar.analysis.cycles.shaking import DynamicMap, dynamic_map
from infinivar.analysis.machine_tasks import PathResult
from infinivar.analysis.performing import follow_path
from infinivar.axis import LINEAR
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import AuditError, InputError, ParameterError
from infinivar.figures import style
from infinivar.limits import words_of
from infinivar.motion.vectors import TRANSLATIONS
from infinivar.study.study import Study
from infinivar.web.answers import payload, words
from infinivar.web.answers.answer import Answer

MOST = 1000
"""Most instants of a curve sent to a page."""


FREQUENCIES, FRACTIONS, SAMPLES = 64, 48, 80
LOWEST, HIGHEST = 0.1, 30.0
"""Ends of the frequency axis, as in Fig 17 of faulring2006. [Hz]"""


def plane(study: Study, request: Mapping[str, Any], progress: Callable[[float], None] | None = None) -> Answer:
    """Performance of each drive in shaking a mass, over frequency and RMS power.

    Parameters
    ----------
    study : Study
    request : mapping   drives: names, by default all; motion: duty cycle whose mass and power count if nothing is required.
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
    names = payload.words(request, "drives", study.drives) or list(study.drives)
    size = shaken(study, request)
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


def shaken(study: Study, requested: Mapping[str, Any]) -> tuple[float, float] | str:
    """Largest power and mass of the plane, or why there are none. [W], [kg]"""
    required = study.requirement
    if required is not None and required.power and study.load_mass:
        return float(required.power), float(study.load_mass)
    only = motion_of(study, requested)[1] if study.duty and requested.get("motion") is not None else None
    for name, duty in study.duty.items():
        if only in (None, name) and duty.moved_mass:
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


def motion(study: Study, request: Mapping[str, Any], progress: Callable[[float], None] | None = None) -> Answer:
    """Course of one motion, and what each drive spends on it.

    Parameters
    ----------
    study : Study
    request : mapping   motion: name of a duty cycle or of a path, by default the first; drives: names, by default all.
    progress          Called with the share done, 0 to 1.

    Returns
    -------
    Answer
        Header: motion, title; closed: whether it repeats; period [s]; per: what energies refer to; course: curves of the load,
        each with name, label and unit; drives: by name, title, fault (None, or why there are no numbers), verdict, feasible,
        energy [J], mean_power [W], losses: rows of label, joules and colour; heat: rows of name, permissible [°C] and verdict.
        Arrays: time [s]; course/NAME; by drive NAME/power [W], NAME/energy: from the supply so far [J]; NAME/heat/K/time [s] and
        NAME/heat/K/winding [°C] of its motors, in the order of heat.

    Raises
    ------
    InputError
        If the study has no motion.
    """
    group, name = motion_of(study, request)
    drives = payload.words(request, "drives", study.drives) or list(study.drives)
    title = getattr(study, group)[name].title or name
    header: dict[str, Any] = {"motion": name, "group": group, "title": title, "drives": {}}
    arrays: dict[str, np.ndarray] = {}
    for place, drive in enumerate(drives):
        row: dict[str, Any] = {"title": study.titles[drive], "fault": None}
        header["drives"][drive] = row
        try:
            if group == "duty":
                found = _duty(study, drive, name)
                _duty_rows(found, row, arrays, header, drive)
            else:
                _path_rows(follow_path(study.drives[drive], study.paths[name]), row, arrays, header, drive)
        except (ParameterError, AuditError, InputError) as problem:
            row["fault"] = f"drives.{drive}: {problem}"
        if progress is not None:
            progress((place + 1) / len(drives))
    return Answer(header=header, arrays=words.single(arrays))


def motion_of(study: Study, request: Mapping[str, Any]) -> tuple[str, str]:
    """Group and name of the requested motion; the first by default, and if that name is gone by now.

    Raises
    ------
    InputError
        If the study has none.
    """
    names = {**dict.fromkeys(study.paths, "paths"), **dict.fromkeys(study.duty, "duty")}
    if not names:
        raise InputError("the study has no motion: add a table [duty.NAME], or [paths.NAME] for machines")
    first = next(iter(study.duty or study.paths))
    name = payload.text(request, "motion", first)
    name = name if name in names else first
    return names[name], name


def _duty(study: Study, drive: str, name: str) -> DutyResult:
    """One drive in one duty cycle, as `compare` has it."""
    if is_machine(study.drives[drive]):
        raise ParameterError("a machine follows paths, not duty cycles")
    duty = study.duty[name]
    return duty_cycle(study.drives[drive], duty, name=drive, title=study.titles[drive], travel=study.travel)


def _duty_rows(
    found: DutyResult, row: dict[str, Any], arrays: dict[str, np.ndarray], header: dict[str, Any], drive: str
) -> None:
    columns, duty = found.columns, found.duty
    if "time" not in arrays:
        axis = duty.axis
        position, speed, force = axis.columns
        scale = 1e3 if axis is LINEAR else 180.0 / np.pi
        header.update(closed=duty.closed, period=duty.period, per=duty.per)
        header["course"] = [
            {"name": "position", "label": axis.position, "unit": "mm" if axis is LINEAR else "°"},
            {"name": "speed", "label": axis.speed, "unit": axis.speed_unit},
            {"name": "force", "label": f"{axis.force} on the load", "unit": axis.force_unit},
        ]
        arrays["time"] = words.thin(columns["time_s"], MOST)
        arrays["course/position"] = scale * words.thin(columns[position], MOST)
        arrays["course/speed"] = words.thin(columns[speed], MOST)
        arrays["course/force"] = words.thin(columns[force], MOST)
    row.update(verdict=found.verdict, feasible=found.feasible, energy=words.number(found.energy))
    row.update(mean_power=words.number(found.power_in), losses=_losses(found.losses), heat=[])
    _powers(columns["time_s"], columns["power_from_supply_W"], arrays, drive, duty.period)
    for what, hot in found.heat.items():
        lacks = ", ".join(found.lacking.get(what, ()))
        label = {
            "name": what,
            "permissible": None if hot is None else words.number(hot.permissible - 273.15),
            "verdict": hot.verdict if hot is not None else f"temperature unknown: the motor lacks {lacks}",
        }
        row["heat"].append(label)
        if hot is not None:
            key = f"{drive}/heat/{len(row['heat']) - 1}"
            arrays[f"{key}/time"] = words.thin(hot.time, MOST)
            arrays[f"{key}/winding"] = words.thin(hot.winding_history, MOST) - 273.15


def _path_rows(
    found: PathResult, row: dict[str, Any], arrays: dict[str, np.ndarray], header: dict[str, Any], drive: str
) -> None:
    if "time" not in arrays:
        header.update(closed=True, period=found.period, per=found.per, course=[])
        arrays["time"] = words.thin(found.time, MOST)
        middle = found.pose.mean(axis=0)
        for index, name in enumerate(found.coordinates):
            if not np.ptp(found.pose[:, index]) > 0.0:
                continue
            along = name in TRANSLATIONS
            header["course"].append({"name": name, "label": name, "unit": "mm" if along else "°"})
            arrays[f"course/{name}"] = words.thin(
                (1e3 if along else 180.0 / np.pi) * (found.pose[:, index] - middle[index]), MOST
            )
    able = "feasible" if found.feasible else "infeasible"
    energy, mean = words.quantity(found.energy, "J"), words.quantity(found.mean_power, "W")
    verdict = f"{able}; {found.tightest_words}; {energy} {found.per}, {mean} on average"
    row.update(verdict=verdict, feasible=found.feasible, energy=words.number(found.energy), heat=[])
    losses = {name: loss * found.period for name, loss in found.losses.items()}
    row.update(mean_power=words.number(found.mean_power), losses=_losses(losses))
    shape = found.time.shape
    _powers(found.time, np.broadcast_to(np.asarray(found.point.power_in), shape), arrays, drive, found.period)


def _powers(time: np.ndarray, power: np.ndarray, arrays: dict[str, np.ndarray], drive: str, period: float) -> None:
    """Power from the supply, and its energy up to the end of each of the equal steps."""
    step = period / len(time)
    arrays[f"{drive}/power"] = words.thin(power, MOST)
    arrays[f"{drive}/energy"] = words.thin(np.cumsum(power) * step, MOST)


def _losses(losses: Mapping[str, float]) -> list[dict[str, Any]]:
    """Rows from the largest loss; none of 0."""
    return [
        {"label": name, "joules": words.number(joules), "colour": style.loss_colour(name)}
        for name, joules in sorted(losses.items(), key=lambda one: -np.nan_to_num(one[1]))
        if joules != 0.0
    ]
