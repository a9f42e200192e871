"""Results of all drives of a study in one duty cycle, and the answer over several."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any

from infinivar._core.described import at, derived
from infinivar._core.result import Result, result
from infinivar.analysis.cycles.cylinder_policy import Policy
from infinivar.analysis.cycles.duty_result import DutyResult
from infinivar.axis import Axis
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.units import plain

if TYPE_CHECKING:
    from infinivar.analysis.cycles.tracking import TwoWays

FEW = 3
"""Most duty cycles that the answer speaks of one by one."""


@result
class DutyComparison(Result):
    """Results of all drives of a study in one duty cycle.

    Attributes
    ----------
    results         By drive.
    policies        Cylinder speed policies, by cobotic drive.
    two_ways        Energy by inverse dynamics and by simulation, by drive, or why it was not simulated.
    cautions        Why the loops of a drive with a compliant gearhead or stage are unstable, by drive; others are left out.
    """

    duty: DutyCycle
    results: Mapping[str, DutyResult]
    policies: Mapping[str, tuple[Policy, ...]]
    two_ways: Mapping[str, TwoWays | str]
    cautions: Mapping[str, str] = field(default_factory=dict)

    _also = (at("duty.title"),)

    @property
    def axis(self) -> Axis:
        """Whether the load moves along a line or about a joint."""
        return self.duty.axis

    @property
    def best(self) -> DutyResult | None:
        """The feasible drive with the lowest energy; None if no drive is feasible."""
        able = [result for result in self.results.values() if result.feasible]
        return min(able, key=lambda result: result.energy, default=None)

    @property
    def verdict(self) -> str:
        """One clause: how many drives are feasible, and the one with the lowest energy, or that comes closest; cautions."""
        best, count = self.best, len(self.results)
        if best is None:
            closest = max(self.results.values(), key=lambda result: result.tightest[1])
            if count == 1:
                return f"{closest.title} is infeasible; {closest.tightest_words}"
            return f"none of the {count} drives is feasible; closest: {closest.title}, {closest.tightest_words}"
        caution = self.cautions.get(best.name, "")
        energy = f"{plain(best.energy, 3)} J {self.duty.per}"
        tight = f"{best.tightest_words}; {caution}" if caution else best.tightest_words
        if count == 1:
            return f"{best.title} is feasible with {energy}; {tight}"
        able = sum(result.feasible for result in self.results.values())
        shown = f"{able} of {count} drives {'is' if able == 1 else 'are'} feasible"
        return f"{shown}; lowest energy: {best.title} with {energy}; {tight}"

    @derived()
    def _drives(self) -> dict[str, dict[str, Any]]:
        """Result of each drive, with the policies of its cylinder, its simulation or why there is none, and its caution."""
        return {
            name: {
                **result.to_dict(),
                "cylinder": [policy.to_dict() for policy in self.policies.get(name, ())],
                "simulated": {"left_out": both} if isinstance(both := self.two_ways[name], str) else both.to_dict(),
                **({"caution": self.cautions[name]} if name in self.cautions else {}),
            }
            for name, result in self.results.items()
        }


def over_all(duty: Mapping[str, DutyComparison], titles: Mapping[str, str]) -> str:
    """Answer over several duty cycles that no shares weigh: how many drives are feasible in all of them, and the best."""
    able = [name for name in titles if all(found.results[name].feasible for found in duty.values())]
    cycles = f"all {len(duty)} duty cycles"
    if len(titles) == 1:
        (title,) = titles.values()
        return (
            f"{title} is feasible in {cycles}"
            if able
            else f"{title} is not feasible in {cycles}{_failing(duty, titles)}"
        )
    if not able:
        return f"None of the {len(titles)} drives is feasible in {cycles}{_failing(duty, titles)}"
    head = f"{len(able)} of {len(titles)} drives {'is' if len(able) == 1 else 'are'} feasible in {cycles}"
    leading = {min(able, key=lambda name: found.results[name].energy) for found in duty.values()}
    if len(able) == 1:
        return f"{head}: {titles[able[0]]}"
    if len(leading) > 1:
        return f"{head}; no drive has the lowest energy in each"
    return f"{head}; lowest energy in each: {titles[leading.pop()]}"


def _failing(duty: Mapping[str, DutyComparison], titles: Mapping[str, str]) -> str:
    """Name the drive that comes closest in its worst duty cycle, that cycle and the limit."""
    worst = {name: min(duty.values(), key=lambda found: found.results[name].tightest[1]) for name in titles}
    closest = max(worst, key=lambda name: worst[name].results[name].tightest[1])
    found = worst[closest]
    title = "" if len(worst) == 1 else f"closest: {titles[closest]}, "
    return f"; {title}{found.results[closest].tightest_words} in {found.duty.title}"
