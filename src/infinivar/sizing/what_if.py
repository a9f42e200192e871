"""What would have to change for another architecture to win, or to become feasible at all.

One value of the losing best design is changed at a time, all else stays as it is. Its power and its limits are those of
`duty_cycle`, and of the steady operating points of the required region.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.described import derived, reported
from infinivar._core.fields import value_at, with_values
from infinivar._core.result import Frozen, result
from infinivar.analysis.cycles.duty_cycle import duty_cycle
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.drive import operated
from infinivar.drivetrain.masses import shaft_demand
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.parts.amplifier import Amplifier
from infinivar.sizing.design import DEMAND_ROWS, SizedDrive, beyond_words
from infinivar.sizing.geared.candidates import ENVELOPE, STRUCTURE
from infinivar.sizing.geared.tasks import REQUIREMENT, RegionTask, judging_points
from infinivar.sizing.levers import Lever, allowances, levers, weighed
from infinivar.sizing.margins import TaskDemand
from infinivar.sizing.measures import MEASURES
from infinivar.sizing.options import BOTH
from infinivar.sizing.tables import equal_shares
from infinivar.study.study import Study
from infinivar.units import plain, show

_NODES = 4
"""Values between the present one and the end of its range that are looked at first."""
_HALVINGS = 16
_PASSES = 3
_ROUNDING = 1e-9
_OUT_OF_REACH = 1e9
_MOST_DIGITS = 12
_DIGITS = range(3, _MOST_DIGITS + 1)
"""Digits that a value may be stated with."""


@result
class Change(Frozen):
    """A value of a design, and what it would have to be.

    Attributes
    ----------
    words          Quantity.
    unit           In SI.
    start, end     As it is, and the last value looked at.
    needed         Nearest value that is enough; nan if none up to the end is.
    stated         For people: the needed value in few digits, rounded so that it is enough as well.
    times          For people: a factor on the present value, rounded likewise; nan if none is enough, or the present value is 0.
    best           Least value of the objective up to the end with all limits kept; nan where only limits count. [W] or [kg]
    """

    words: str = reported()
    unit: str = reported()
    start: float = reported()
    end: float = reported()
    needed: float = reported()
    stated: float = reported()
    times: float
    best: float = reported()

    @property
    def enough(self) -> bool:
        """Whether a value is enough."""
        return not math.isnan(self.needed)

    @derived("1")
    def factor(self) -> float:
        """Needed over present value; nan if none is enough, or the present value is 0. [-]"""
        return self.needed / self.start if self.start else math.nan


@result
class WhatIf(Frozen):
    """What would have to change in a losing design.

    Attributes
    ----------
    template       Drive of the study that the design is like.
    goal           energy or mass: no more of it than the winner; feasible: all limits kept.
    target         The winner's; nan if the goal is to be feasible. [W] or [kg]
    present        The design's, or its largest demand over allowance, once the power returned is absorbed.
    changes        Each alone, the enough ones first.
    allowances     To be feasible: what the limits exceeded would have to allow, all at once.
    together       Whether the design keeps all limits with all of these allowances as stated.
    remaining      If not: demand over allowance of the limits still exceeded, the worst first.
    slips          Whether the wheel of the design slips, so that demands on its motors are not known.
    absorbed       To be feasible: largest power returned that the amplifier accepts none of and would have to absorb; all else is
                   judged as if it did. 0 if none returns, or it is accepted. [W]
    """

    template: str = reported()
    goal: str = reported()
    target: float = reported()
    present: float = reported()
    changes: tuple[Change, ...] = reported()
    allowances: tuple[Change, ...] = reported(default=())
    together: bool = reported(default=False)
    remaining: Mapping[TaskDemand, float] = reported(convert=DEMAND_ROWS, default_factory=dict)
    slips: bool = reported(default=False)
    absorbed: float = reported(default=0.0)

    @property
    def wheel_enough(self) -> bool:
        """Whether the wheel that slips rolls with the allowances."""
        return self.slips and all(one.enough for one in self.allowances)

    @property
    def headline(self) -> str:
        """What has to be reached, in words."""
        if self.goal == "feasible":
            return f"What would have to change for {self.template} to be feasible (nearest miss, all else as it is)"
        unit = "kg" if self.goal == "mass" else "W"
        digits = next((some for some in _DIGITS if plain(self.target, some) != plain(self.present, some)), 3)
        amounts = f"{show(self.target, unit, digits)} instead of {show(self.present, unit, digits)}"
        return f"What would have to change for {self.template} to win ({amounts}, all else as it is)"

    @property
    def lines(self) -> tuple[str, ...]:
        """A line for the allowances, one for each change that is enough, and one for the others."""
        said = []
        needed = [*([self.amplifier_words] if self.absorbed else []), *map(change_words, self.allowances)]
        if needed:
            outcome = f"{'enough' if self.together else 'not enough'}{' together' if self.allowances else ''}"
            if self.slips:
                enough = "enough" if self.wheel_enough else "not enough"
                outcome = f"{enough} for the wheel; behind one that slips no motors are chosen"
            still = f"; still exceeded: {beyond_words(self.remaining)}" if self.remaining else ""
            said.append(f"{outcome}: {', '.join(needed)}{still}")
        elif self.remaining:
            said.append(f"no allowance looked at changes {beyond_words(self.remaining)}")
        alone = "" if self.goal != "feasible" else ", besides the amplifier" if self.absorbed else ", alone"
        said += [f"{change_words(one)}{alone}" for one in self.changes if one.enough]
        others = [one for one in self.changes if not one.enough]
        if others:
            said.append(f"not enough: {'; '.join(self._short(one) for one in others)}")
        return tuple(said)

    @property
    def amplifier_words(self) -> str:
        """The amplifier that the power returned needs."""
        most = Context(prec=_DIGITS[0], rounding=ROUND_CEILING).create_decimal_from_float(self.absorbed)
        return (
            f"an amplifier that absorbs the power returned, at most {show(float(most), 'W', _MOST_DIGITS)} "
            '(regeneration = "burn" or "store" instead of "none")'
        )

    def _short(self, change: Change) -> str:
        said = f"{change.words} {'up' if change.end > change.start else 'down'} to {amount(change.end, change.unit)}"
        if math.isnan(change.best):
            return said
        return f"{said} ({show(change.best, 'kg' if self.goal == 'mass' else 'W', 3)})"


def change_words(change: Change) -> str:
    """A change in words, such as "motor resistance 0.21 ohm instead of 0.62 ohm (0.34 times)"."""
    if not change.enough:
        return f"{change.words}: no value up to {amount(change.end, change.unit)} is enough"
    times = "" if math.isnan(change.times) else f" ({plain(change.times, _MOST_DIGITS)} times)"
    return f"{change.words} {needed_words(change)} instead of {present_words(change)}{times}"


def needed_words(change: Change) -> str:
    """The value stated, with its unit."""
    return show(change.stated, change.unit, _MOST_DIGITS)


def present_words(change: Change) -> str:
    """The present value with its unit, in as few digits as tell it from the value stated."""
    stated = plain(change.stated, _MOST_DIGITS)
    digits = next((some for some in _DIGITS if plain(change.start, some) != stated), 3)
    return show(change.start, change.unit, digits)


def amount(value: float, unit: str) -> str:
    """A value of a change with its unit."""
    return show(value, unit, 3)


class Judgement(NamedTuple):
    """What a drive needs, and its demands."""

    power: float
    demands: Mapping[TaskDemand, float]

    @property
    def worst(self) -> float:
        """Largest demand over allowance. [-]"""
        return max((math.inf if math.isnan(one) else one for one in self.demands.values()), default=0.0)

    @property
    def exceeded(self) -> dict[TaskDemand, float]:
        """Demands beyond their allowance, the worst first. [-]"""
        beyond = {key: math.inf if math.isnan(one) else one for key, one in self.demands.items() if not one <= 1.0}
        return dict(sorted(beyond.items(), key=lambda item: -item[1]))


class Judge:
    """Evaluates drives on the motions and the required region of a study."""

    def __init__(self, study: Study, slip_margin: float) -> None:
        """`slip_margin` is the slip force wanted over the lateral force."""
        self._study, self._slip_margin = study, slip_margin
        self._shares = equal_shares(study.duty)
        self._region = None
        if study.requirement is not None:
            speed, force, _ = study.requirement.sample()
            self._region = judging_points(RegionTask(speed=speed, force=force))

    def __call__(self, drive: Any) -> Judgement:
        """Power and demands of a drive."""
        demands: dict[TaskDemand, float] = {}
        power = 0.0 if self._study.duty else math.nan
        for name, duty in self._study.duty.items():
            cycle = duty_cycle(drive, duty, travel=self._study.travel)
            power += self._shares[name] * cycle.power_in
            demands |= {(name, *key): demand for key, demand in cycle.demands.items()}
            demands |= {
                (name, Limit.TEMPERATURE, part): heat.demand for part, heat in cycle.heat.items() if heat is not None
            }
        if self._region is not None:
            point = operated(drive, speed=self._region.speed, force=self._region.force)
            demands |= {(REQUIREMENT, limit, ""): float(np.max(demand)) for limit, demand in point.utilisation.items()}
        if isinstance(drive, CoboticDrive):
            static = drive.transmission.utilisation
            demands |= {("contact", limit, "wheel"): float(np.max(one)) for limit, one in static.items()}
        service = self._study.service(drive)
        demands |= {(STRUCTURE, *key): float(demand) for key, demand in shaft_demand(drive, service).items()}
        if self._study.envelope is not None:
            own = self._study.envelope.of(drive, service)
            demands |= {(ENVELOPE, *key): float(demand) for key, demand in own.items()}
        return Judgement(
            power,
            {key: demand * (self._slip_margin if key[1] == Limit.SLIP else 1.0) for key, demand in demands.items()},
        )

    def returned(self, drive: Any) -> float:
        """Largest power that returns from the motors, as an amplifier without losses would burn it. [W]"""
        bare = replace(drive, amplifier=Amplifier())
        points: list[Any] = [
            duty_cycle(bare, one, travel=self._study.travel).point for one in self._study.duty.values()
        ]
        if self._region is not None:
            points.append(operated(bare, speed=self._region.speed, force=self._region.force))
        return max(float(np.max(point.losses["amplifier"])) for point in points)


def what_if(
    study: Study,
    aim: str,
    best_of: Mapping[str, SizedDrive],
    nearest: Mapping[str, SizedDrive],
    slip_margin: float,
) -> dict[str, WhatIf]:
    """What would have to change for each template but the winner's, by template.

    Parameters
    ----------
    aim : str             What the search made small; of energy and mass, what would have to change to win as well.
    best_of, nearest      Best designs, and nearest misses of templates without one.
    slip_margin : float   Slip force over lateral force that is wanted. [-]
    """
    judge = Judge(study, slip_margin)
    needs = MEASURES[aim].of
    found: dict[str, WhatIf] = {}
    if len(best_of) > 1 and aim in BOTH:
        winner = min(best_of.values(), key=needs)
        for name, design in best_of.items():
            if design is not winner:
                found[name] = _to_win(design, judge, aim, needs(winner))
    for name, design in nearest.items():
        made = _to_be_feasible(design, judge)
        if made is not None:
            found[name] = made
    return found


def _to_win(design: SizedDrive, judge: Judge, aim: str, target: float) -> WhatIf:
    """What would have to change for a feasible design to need as little as the winner."""
    by_mass = aim == "mass"
    kept = design.mass - sum(weighed(design).values())
    allowed = max(1.0, judge(design.drive).worst) * (1.0 + _ROUNDING)

    def measured(drive: Any) -> tuple[float, float]:
        if by_mass:
            return kept + sum(value_at(drive, path) for path in weighed(design)), 1.0
        done = judge(drive)
        return done.power, done.worst

    changes = [nearest_change(one, design.drive, measured, target, allowed) for one in levers(design, aim)]
    return WhatIf(
        template=design.template,
        goal=aim,
        target=target,
        present=design.mass if by_mass else design.power,
        changes=_sorted(changes),
    )


def _to_be_feasible(design: SizedDrive, judge: Judge) -> WhatIf | None:
    """What would have to change for an infeasible design to keep all limits; None if that is not known.

    Behind a wheel that slips no motors were chosen: the friction limit of its contact is all that is looked at. Where the
    amplifier accepts no power and some returns, everything else is judged with one that burns it.
    """
    exceeded, absorbed = design.exceeded, 0.0
    if any(limit == Limit.REGENERATION for _, limit, _ in exceeded):
        absorbed = judge.returned(design.drive)
        burning = with_values(design.drive, {"amplifier.regeneration": "burn"})
        exceeded = {key: demand for key, demand in exceeded.items() if key[1] != Limit.REGENERATION}
        design = replace(design, drive=burning)
    present = judge(design.drive)
    slips = not math.isfinite(present.worst)
    if slips and not any(limit == Limit.SLIP for _, limit, _ in exceeded):
        return None
    own = [
        (lever, _of_limit(judge, limit, part))
        for limit, part in dict.fromkeys((limit, part) for _, limit, part in exceeded)
        for lever in allowances(design, limit, part)
        if limit == Limit.SLIP or not slips
    ]
    allowed: dict[str, Change] = {}
    drive = design.drive
    for _ in range(_PASSES):  # a value may shift what another limit needs
        for lever, measured in own:
            change = allowed[lever.words] = nearest_change(lever, drive, measured, math.inf, 1.0)
            drive = lever.made(drive, change.stated) if change.enough else drive
    remaining = {} if slips else judge(drive).exceeded
    others = [] if slips or not present.exceeded else levers(design, "feasible")
    changes = [nearest_change(one, design.drive, _of_all(judge), math.inf, 1.0) for one in others]
    return WhatIf(
        template=design.template,
        goal="feasible",
        target=math.nan,
        present=present.worst,
        changes=_sorted(changes),
        allowances=tuple(allowed.values()),
        together=bool(own or absorbed) and judge(drive).worst <= 1.0,
        remaining=remaining,
        slips=slips,
        absorbed=absorbed,
    )


Measured = Callable[[Any], tuple[float, float]]
"""Objective and largest demand over allowance of a drive."""


def _of_limit(judge: Judge, limit: Limit, part: str) -> Measured:
    """The largest demand of one limit; without an objective."""

    def measured(drive: Any) -> tuple[float, float]:
        found = [
            demand
            for (task, one, of), demand in judge(drive).demands.items()
            if one == limit and (of == part or (task == REQUIREMENT and part != "steering motor"))
        ]
        return math.nan, max((math.inf if math.isnan(one) else one for one in found), default=0.0)

    return measured


def _of_all(judge: Judge) -> Measured:
    """The largest demand of all limits; without an objective."""
    return lambda drive: (math.nan, judge(drive).worst)


def nearest_change(lever: Lever, drive: Any, measured: Measured, target: float, allowed: float) -> Change:
    """Nearest value of a lever at which the objective is at most the target, and demands at most what is allowed."""
    best = math.nan

    def excess(value: float) -> float:
        """Above 0 where the value is not enough."""
        nonlocal best
        try:
            least, worst = measured(lever.made(drive, value))
        except ParameterError:  # no such part
            return _OUT_OF_REACH
        if worst <= allowed and not math.isnan(least):
            best = least if math.isnan(best) else min(best, least)
        over = 0.0 if math.isinf(target) else least / target - 1.0
        found = max(over - _ROUNDING if over > 0.0 else over, worst / allowed - 1.0)
        return found if math.isfinite(found) else _OUT_OF_REACH

    geometric = lever.start > 0.0 and lever.end > 0.0
    values = (np.geomspace if geometric else np.linspace)(lever.start, lever.end, _NODES + 1)
    needed, before = math.nan, excess(lever.start)
    for last, value in itertools.pairwise(values):
        here = excess(float(value))
        if here <= 0.0:
            needed = lever.start if before <= 0.0 else _at_edge(excess, float(last), float(value))
            break
        before = here
    least, stated, times = best, needed, needed / lever.start if lever.start else math.nan
    if not math.isnan(needed):
        up = lever.end > lever.start
        stated = _rounded(needed, up, excess)
        times = _rounded(times, up, lambda factor: excess(factor * lever.start))
    return Change(
        words=lever.words,
        unit=lever.unit,
        start=lever.start,
        end=lever.end,
        needed=needed,
        stated=stated,
        times=times,
        best=least,
    )


def _rounded(value: float, up: bool, excess: Callable[[float], float]) -> float:
    """A value that is enough in the fewest digits, from three on, with which it still is; rounded to the nearest if that is."""
    for digits in _DIGITS if value else ():
        for rounding in (ROUND_HALF_EVEN, ROUND_CEILING if up else ROUND_FLOOR):
            found = float(Context(prec=digits, rounding=rounding).create_decimal_from_float(value))
            if excess(found) <= 0.0:
                return found
    return value


def _at_edge(excess: Callable[[float], float], outside: float, inside: float) -> float:
    """The value nearest to one that is not enough at which the excess is 0, by bisection: the excess may have steps."""
    for _ in range(_HALVINGS):
        middle = math.sqrt(outside * inside) if outside * inside > 0.0 else 0.5 * (outside + inside)
        if excess(middle) <= 0.0:
            inside = middle
        else:
            outside = middle
    return inside


def _sorted(changes: Sequence[Change]) -> tuple[Change, ...]:
    """Those that are enough first, the nearest to the present value before the others."""
    return tuple(sorted(changes, key=lambda one: (not one.enough, distance(one))))


def distance(change: Change) -> float:
    """How far a value is from the present one, as the logarithm of their ratio; infinite where that has none."""
    factor = change.factor
    if math.isnan(factor) or factor <= 0.0:
        return math.inf
    return abs(math.log(factor))
