"""Mixed use: the duty cycles of a study weighed into one figure by the shares of time spent in each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from infinivar._core.described import derived, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.cycles.duty_comparison import FEW
from infinivar.analysis.cycles.duty_result import DutyResult
from infinivar.limits import words_of
from infinivar.units import margin_words, plain


@result
class MixedUse(Result):
    """Drives in mixed use. Each duty cycle counts as settled and warm, repeated without end.

    Attributes
    ----------
    shares       Share of the time spent in each duty cycle, adding up to 1. [-]
    titles       Titles of the drives, by name.
    cycles       Titles of the duty cycles, by name.
    power        Mean power from the supply, by drive; nan if the wheel slips in a cycle. [W]
    feasible     Whether the drive is feasible in every cycle, by drive.
    per_kilogram Mean power per kilogram, by drive; empty unless all cycles refer to the same mass. [W/kg]
    per_metre    Energy per metre covered, by drive; empty unless a cycle states its distance. Cycles without one cover none,
                 and their energy counts. [J/m]
    tightest     Cycle with the least margin, the limit and the margin, by drive.
    """

    shares: Mapping[str, float] = reported("1")
    titles: Mapping[str, str]
    cycles: Mapping[str, str]
    power: Mapping[str, float]
    feasible: Mapping[str, bool]
    per_kilogram: Mapping[str, float]
    per_metre: Mapping[str, float]
    tightest: Mapping[str, tuple[str, str, float]]

    @property
    def watt_hours(self) -> Mapping[str, float]:
        """Energy from the supply per hour, by drive. [W h]"""
        return self.power

    @derived()
    def best(self) -> str | None:
        """Name of the feasible drive with the lowest mean power; None if no drive is feasible."""
        able = [name for name, good in self.feasible.items() if good]
        return min(able, key=lambda name: self.power[name], default=None)

    @property
    def words(self) -> str:
        """The cycles and their shares, such as "60 % walking, 40 % standing"."""
        return ", ".join(f"{plain(100 * share, 3)} % {self.cycles[task]}" for task, share in self.shares.items())

    @derived()
    def verdict(self) -> str:
        """One clause: how many drives are feasible in every cycle, and the one with the lowest mean power or the closest."""
        count, able = len(self.titles), sum(self.feasible.values())
        head = (
            f"Mixed use ({self.words})" if len(self.shares) <= FEW else f"Mixed use of {len(self.shares)} duty cycles"
        )
        if self.best is None:
            closest = max(self.titles, key=lambda name: self.tightest[name][2])
            tight = f"{self.titles[closest]}{' is infeasible; ' if count == 1 else ', '}{self._tight(closest)}"
            return (
                f"{head}: {tight}"
                if count == 1
                else f"{head}: none of the {count} drives is feasible; closest: {tight}"
            )
        drawn, tight = self._drawn(self.best), self._tight(self.best)
        least = f"{self.titles[self.best]} with {drawn}"
        if count == 1:
            return f"{head}: {least}, feasible in every cycle; {tight}"
        return (
            f"{head}: {able} of {count} drives {'is' if able == 1 else 'are'} feasible; lowest energy: {least}; {tight}"
        )

    def verdict_on(self, name: str) -> str:
        """One clause on a drive: feasibility, tightest limit over all cycles, mean power."""
        drawn = self._drawn(name)
        if name in self.per_kilogram:
            drawn += f", {plain(self.per_kilogram[name], 3)} W/kg"
        if self.power[name] != self.power[name]:
            drawn = "power unknown: the wheel slips"
        able = "feasible" if self.feasible[name] else "infeasible"
        return f"{able}; {self._tight(name)}; {drawn}"

    def _drawn(self, name: str) -> str:
        """Mean power of a drive, and its energy per metre where known."""
        power = f"{plain(self.power[name], 3)} W on average"
        return f"{power}, {plain(self.per_metre[name], 3)} J/m" if name in self.per_metre else power

    def _tight(self, name: str) -> str:
        """Tightest limit of a drive over all cycles as a clause."""
        task, limit, margin = self.tightest[name]
        return f"tightest limit: {limit} in {self.cycles[task]} (margin {margin_words(margin)})"

    @derived()
    def _drives(self) -> dict[str, dict[str, Any]]:
        return {
            name: {
                "title": title,
                "verdict": self.verdict_on(name),
                "feasible": self.feasible[name],
                "power_W": self.power[name],
                "energy_per_hour_Wh": self.watt_hours[name],
                "power_per_mass_W_kg": self.per_kilogram.get(name),
                "energy_per_distance_J_m": self.per_metre.get(name),
                "tightest": dict(zip(("duty", "limit", "margin"), self.tightest[name], strict=True)),
            }
            for name, title in self.titles.items()
        }


def mixed_use(results: Mapping[str, Mapping[str, DutyResult]], shares: Mapping[str, float]) -> MixedUse:
    """Weigh the results of drives in several duty cycles.

    Parameters
    ----------
    results : mapping   Results by drive, by duty cycle; the same drives in every cycle.
    shares : mapping    Share of the time spent in each duty cycle; they add up to 1. [-]

    Returns
    -------
    MixedUse   The mean power is the sum of the cycles' mean powers times their shares: a share of the time at a power is that
        share of an hour's energy.
    """
    first = next(iter(results.values()))
    masses = {found.duty.reference_mass for done in results.values() for found in done.values()}
    mass = masses.pop() if len(masses) == 1 else None
    cycles = {task: next(iter(done.values())).duty for task, done in results.items()}
    speed = sum(shares[task] * (cycle.distance_per_cycle or 0.0) / cycle.period for task, cycle in cycles.items())
    power = {name: sum(shares[task] * done[name].power_in for task, done in results.items()) for name in first}
    return MixedUse(
        shares=FrozenDict(shares),
        titles=FrozenDict({name: found.title for name, found in first.items()}),
        cycles=FrozenDict({task: cycle.title or task for task, cycle in cycles.items()}),
        power=FrozenDict(power),
        feasible=FrozenDict({name: all(done[name].feasible for done in results.values()) for name in first}),
        per_kilogram=FrozenDict({} if mass is None else {name: drawn / mass[0] for name, drawn in power.items()}),
        per_metre=FrozenDict({name: drawn / speed for name, drawn in power.items()} if speed > 0.0 else {}),
        tightest=FrozenDict({name: _tightest(name, results) for name in first}),
    )


def _tightest(name: str, results: Mapping[str, Mapping[str, DutyResult]]) -> tuple[str, str, float]:
    """Cycle in which a drive has the least margin, the limit in words, and the margin."""
    margins = {task: done[name].tightest for task, done in results.items()}
    task = min(margins, key=lambda one: margins[one][1])
    limit, margin = margins[task]
    return task, words_of(limit), margin
