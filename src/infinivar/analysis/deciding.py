"""What decides between the drives of a study, and between its machines, and what those decisions hang on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.fields import value_at, with_values
from infinivar.analysis.cycles.cylinder_policy import RANGE, best_common_speed
from infinivar.analysis.cycles.duty_comparison import DutyComparison
from infinivar.analysis.cycles.duty_cycle import energy_and_feasibility
from infinivar.analysis.hanging import Answered, Hanging, Judged, hang
from infinivar.analysis.machines import MachineComparison, decided_machine, judged_machine, tasks_and_paths
from infinivar.analysis.performing import Prepared
from infinivar.analysis.region import covers, covers_with_loss
from infinivar.analysis.whole_mass import doubts, mass_of, with_factor
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.study.choices import STANDBY_PER_AMPLIFIER, Variant, variants
from infinivar.study.study import Study
from infinivar.units import plain

_SPEEDS, _SECTIONS = 9, 4
"""Constant speeds of a first search over `RANGE`, in equal ratios, and golden sections after it."""

_GOLDEN = (5.0**0.5 - 1.0) / 2.0

_COARSE = 21
"""Points along each axis of the required region during a search."""

CYLINDER_SPEED = "cylinder speed"

SLOW_FRICTION = "friction at low speed"
"""Of machines on a path: simulated, it falls below their stick speed, as if a slow part were held without a controller's work."""


def hanging_drives(
    study: Study,
    free: Mapping[str, Judged],
    covers: Mapping[str, bool],
    fits: Mapping[str, bool],
    duty: Mapping[str, DutyComparison],
) -> Hanging:
    """What the verdict on drives of one axis hangs on.

    Known are what decides between them without the envelope, and whether each covers the requirement and is within the envelope.
    """
    used = {name: one._replace(able=one.able and fits[name]) for name, one in free.items()}
    figure, unit = _figure(study)

    def judge(name: str, drive: Any, variant: Variant) -> Judged:
        if not study.duty and variant.choice == STANDBY_PER_AMPLIFIER:
            # It is drawn at all times, and no limit depends on it.
            beside = drive.amplifier.standby_power - study.drives[name].amplifier.standby_power  # type: ignore[attr-defined]
            return Judged(used[name].able, (used[name].figure + beside,))
        found = _judge_drive(study, drive, variant, covers[name])
        return found._replace(able=found.able and fits[name])

    applicable = [one for one in variants(study) if study.duty or one.scope != "motion"]
    answers = [*applicable, *best_speeds(study)]
    return hang(
        answers,
        judge,
        used,
        study.titles,
        figure,
        unit,
        [*_simulated(study, used, duty), *_structures(study, free, fits)],
    )


def _structures(study: Study, free: Mapping[str, Judged], fits: Mapping[str, bool]) -> Iterator[Answered]:
    """Yield what decides if an assumed factor is wrong by `DOUBT`, where that changes which drives are within the envelope."""
    if study.envelope is None:
        return
    for name, by in doubts(space=True):
        now = dict(fits)
        for of, drive in study.drives.items():
            if hasattr(drive, "structure"):
                made = mass_of(with_factor(drive, name, by), study.service(drive), doubted=False)
                now[of] = made.within(study.envelope)
        if now != fits:
            judged = {of: one._replace(able=one.able and now[of]) for of, one in free.items()}
            yield (f"structure: {name.replace('_', ' ')}", "as used", f"times {by:.3g}"), judged


def _simulated(study: Study, used: Mapping[str, Judged], duty: Mapping[str, DutyComparison]) -> Iterator[Answered]:
    """Yield what decides if the motion is simulated with its controllers, where all feasible drives were."""
    ways = {name: [found.two_ways[name] for found in duty.values()] for name, one in used.items() if one.able}
    if not duty or not ways or any(isinstance(way, str) for found in ways.values() for way in found):
        return
    changed = {}
    for name, found in ways.items():
        more = [way.followed - way.prescribed for way in found if not isinstance(way, str)]
        if study.shares:
            periods = [cycle.duty.period for cycle in duty.values()]
            more = [
                sum(
                    map(
                        _times, study.shares.values(), (one / period for one, period in zip(more, periods, strict=True))
                    )
                )
            ]
        changed[name] = Judged(True, tuple(map(sum, zip(used[name].values, more, strict=True))))
    yield ("motion", "prescribed", "simulated with its controllers"), {**used, **changed}


def hanging_machines(comparison: MachineComparison) -> Hanging:
    """What the verdict on machines hangs on."""
    study = comparison.study
    tasks = tasks_and_paths(study)
    # No answer changes the geometry of a machine or what moves with its links.
    prepared = {name: Prepared(drive, tasks) for name, drive in study.drives.items()}

    def judge(name: str, drive: Any, variant: Variant) -> Judged:
        return decided_machine(drive, prepared[name], study.machine_shares)

    def best(name: str, drive: Any) -> float | None:
        path = _speed_path(drive)
        assert path is not None

        def cost(speed: float) -> float:
            found = decided_machine(with_values(drive, {path: speed}), prepared[name], study.machine_shares)
            return found.figure if found.able else math.inf

        return least(cost, value_at(drive, path))

    used = {name: judged_machine(one) for name, one in comparison.results.items()}
    figure = "mean power in mixed use" if study.machine_shares else "mean power, sum over tasks and paths"
    slow = {name: judged_machine(one, "controlled_power") for name, one in comparison.results.items()}
    also = [((SLOW_FRICTION, "in full", "as simulated"), slow)]
    return hang([*variants(study), *_at_least_loss(study, best)], judge, used, study.titles, figure, "W", also)


def _figure(study: Study) -> tuple[str, str]:
    """What decides, and its unit."""
    if study.shares:
        return "mean power in mixed use", "W"
    if len(study.duty) == 1:
        (duty,) = study.duty.values()
        return f"energy {duty.per}", "J"
    if study.duty:
        return "energy of all duty cycles, one of each", "J"
    return "mean loss over the required region", "W"


def _judge_drive(study: Study, drive: Any, variant: Variant, covered: bool) -> Judged:
    """What decides on a changed drive; `covered` is whether it covers the requirement as it is."""
    required = study.requirement
    if not study.duty:
        assert required is not None
        able, loss = covers_with_loss(drive, required)
        return Judged(able, (loss,))
    found = [energy_and_feasibility(drive, duty, study.travel) for duty in study.duty.values()]
    able = all(feasible for _, feasible in found)
    if variant.scope == "all" and required is not None and able:
        covered = covers(drive, required)
    if not study.shares:
        return Judged(able and covered, tuple(energy for energy, _ in found))
    powers = [energy / duty.period for (energy, _), duty in zip(found, study.duty.values(), strict=True)]
    return Judged(able and covered, (sum(map(_times, study.shares.values(), powers)),))


def _times(share: float, power: float) -> float:
    return share * power


def _at_least_loss(study: Study, best: Callable[[str, Any], float | None]) -> Iterator[Variant]:
    """Yield the study with its cylinders at the constant speed of least loss, which is free, as the wheel converts it.

    A source states it for one machine and one use; so it is no value of the machine, and nothing but the search settles it. With
    duty cycles it is that of the motion alone: the region that is required beside them keeps the speed of the study.
    """
    changed, used, instead = {}, [], []
    for name, drive in study.drives.items():
        path = _speed_path(drive)
        speed = None if path is None else best(name, drive)
        if path is None or speed is None:
            continue
        changed[name] = with_values(drive, {path: speed})
        used.append(f"{plain(abs(value_at(drive, path)), 3)} rad/s")
        instead.append(f"{plain(abs(speed), 3)}")
    if changed:
        where = " in motion" if study.duty and study.requirement is not None else ""
        words = f"least loss{where}: {', '.join(instead)} rad/s"
        yield Variant(CYLINDER_SPEED, ", ".join(dict.fromkeys(used)), words, changed, "run")


def best_speeds(study: Study) -> Iterator[Variant]:
    """Yield a study of drives of one axis with each cylinder at its speed of least loss; nothing if none has a cylinder."""
    yield from _at_least_loss(study, lambda name, drive: _best_speed(study, drive))


def _speed_path(drive: Any) -> str | None:
    """Path of the cylinder speed in a drive; None without a cylinder."""
    if isinstance(drive, CoboticDrive):
        return "cylinder_speed"
    return "leg.cylinder_speed" if isinstance(getattr(drive, "leg", None), CoboticDrive) else None


def _best_speed(study: Study, drive: CoboticDrive) -> float | None:
    """Of least loss in the duty cycles, or over the required region. [rad s^-1]"""
    if study.duty:
        weights = study.shares or {name: duty.period for name, duty in study.duty.items()}
        return best_common_speed(drive, study.duty, weights)
    required = study.requirement
    assert required is not None

    def cost(speed: float) -> float:
        able, loss = covers_with_loss(replace(drive, cylinder_speed=speed), required, _COARSE)
        return loss if able else math.inf

    return least(cost, drive.cylinder_speed)


def least(cost: Callable[[float], float], nominal: float) -> float | None:
    """Speed of the least cost within `RANGE` times a nominal one; None if none has a finite cost."""
    logs = np.log(np.geomspace(*RANGE, _SPEEDS))
    costs = [cost(nominal * math.exp(log)) for log in logs]
    place = int(np.argmin(costs))
    if not math.isfinite(costs[place]):
        return None
    low, high = float(logs[max(place - 1, 0)]), float(logs[min(place + 1, _SPEEDS - 1)])
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at = {log: cost(nominal * math.exp(log)) for log in (left, right)}
    for _ in range(_SECTIONS):
        if at[left] < at[right]:
            high, right, left = right, left, right - _GOLDEN * (right - low)
            new = left
        else:
            low, left, right = left, right, left + _GOLDEN * (high - left)
            new = right
        at[new] = cost(nominal * math.exp(new))
    at[float(logs[place])] = costs[place]
    return nominal * math.exp(min(at, key=lambda log: at[log]))
