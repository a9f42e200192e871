"""Sweep over samples of a drive within its tolerances, each simulated in a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from infinivar._core.described import derived, reported
from infinivar._core.fields import with_values
from infinivar._core.result import Result, result
from infinivar.analysis.robustness.verdicts import band, percent
from infinivar.analysis.simulate import simulate
from infinivar.axis import LINEAR, Axis
from infinivar.errors import InputError, nearest
from infinivar.motion.scenario import Scenario
from infinivar.study.spreads import Spread
from infinivar.study.study import Study
from infinivar.sweeps.builds import Samples, sampled
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import CANDIDATES, Chunk
from infinivar.sweeps.sweep import Sweep, check_finished
from infinivar.units import plain

DRAWS = 1024
SIZE = 32


@result
class RunBuilds(Result):
    """Samples of a drive, each simulated in a scenario: arrays with one value per sample, nan where a run ended early.

    Attributes
    ----------
    spreads    Spreads of the fields that vary.
    values     (n, k) Values, one row per sample.
    energy     From the supply, after the settling time. [J]
    error      Largest position error of the load. [m], [rad]
    able       Whether the run is complete and within every limit.
    exceeded   Number of samples that exceed each limit, by its name; a run that ended early counts by its reason.
    """

    spreads: tuple[Spread, ...] = reported(key="varied")
    values: np.ndarray
    energy: np.ndarray = reported("J", convert=band)
    error: np.ndarray = reported(key="position_error_SI", convert=band)
    able: np.ndarray
    exceeded: Mapping[str, int] = reported()
    axis: Axis = LINEAR

    @derived(key="builds")
    def count(self) -> int:
        """Number of samples."""
        return len(self.values)

    @derived(key="able")
    def share(self) -> float:
        """Share of feasible samples. [-]"""
        return float(np.mean(self.able))

    @derived()
    def verdict(self) -> str:
        """One clause for people."""
        energy, error = band(self.energy), band(self.error)
        scale, unit = (1.0, "rad") if self.axis.rotary else (1e3, "mm")
        said = [f"feasible in {percent(self.share, self.count)} of {self.count} samples"]
        if energy["low"] is not None and energy["high"] is not None:
            said.append(f"{plain(energy['low'], 3)} to {plain(energy['high'], 3)} J in 90 % of them")
        if error["low"] is not None and error["high"] is not None:
            said.append(f"position error {plain(scale * error['low'], 2)} to {plain(scale * error['high'], 2)} {unit}")
        worst = sorted(self.exceeded.items(), key=lambda item: -item[1])
        said += [f"{name} exceeded in {percent(number / self.count, self.count)}" for name, number in worst]
        return "; ".join(said)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunsSweep(Samples):
    """Samples of which each is simulated in a scenario, by its name; see `Samples`."""

    kind: ClassVar[str] = "runs"
    scenario: str
    draws: int = DRAWS
    size: int = SIZE

    @property
    def title(self) -> str:
        """See `Problem`."""
        return f"{self.study.name}, builds of {self.drive} in {self.scenario}"

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`."""
        own = fingerprint(self.study.drives[self.drive])
        return {**self.drawn, "values of the drive": own, "scenario": fingerprint(self._scenario)}

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        at, rows = self.samples(number)
        paths, found, exceeded = [spread.path for spread in self.spreads], [], {}
        for values in at.tolist():
            drive = with_values(self.study.drives[self.drive], dict(zip(paths, values, strict=True)))
            made = simulate(drive, self._scenario)
            for name in made.exceeded if made.complete else (made.history.outcome,):
                exceeded[name] = exceeded.get(name, 0) + 1
            ended = (made.supplied_after_settling, made.largest_error) if made.complete else (np.nan, np.nan)
            found.append((*ended, made.feasible))
        rows |= dict(zip(("energy_J", "error", "able"), np.array(found, dtype=float).T, strict=True))
        return Chunk(rows, {CANDIDATES: len(at), "exceeded": exceeded})

    def best(self, chunk: Chunk) -> tuple[float, str] | None:
        """See `Problem`: the sample with the largest position error."""
        known = chunk.rows["error"][np.isfinite(chunk.rows["error"])]
        return None if not known.size else (-float(known.max()), f"largest position error so far: {known.max():.3g}")

    def result(self, sweep: Sweep) -> RunBuilds:
        """The samples and what became of them.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        check_finished(sweep)
        rows = sweep.rows
        return RunBuilds(
            spreads=self.spreads,
            values=self.values(sweep),
            energy=rows["energy_J"],
            error=rows["error"],
            able=rows["able"] > 0.5,
            exceeded={name: int(number) for name, number in sweep.counts["exceeded"].items()},
            axis=self._scenario.axis,
        )

    @property
    def _scenario(self) -> Scenario:
        return self.study.scenarios[self.scenario]


def runs_sweep(
    study: Study, drive: str | None = None, scenario: str | None = None, *, draws: int = DRAWS, size: int = SIZE
) -> RunsSweep:
    """Prepare simulations of samples of a drive within its tolerances as a sweep.

    Parameters
    ----------
    study : Study
    drive : str      Name of a drive with spreads; the first by default.
    scenario : str   Name of a scenario; the first by default.
    draws : int      Number of samples, a power of two.
    size : int       Samples in a chunk, a power of two.

    Raises
    ------
    InputError
        If drive or scenario do not exist, the drive has no spreads or cannot follow the scenario, or a number is no power of two.
    """
    name = sampled(study, drive, draws, size)
    known = study.scenarios
    chosen = next(iter(known), "") if scenario is None else scenario
    if chosen not in known:
        has = f"it has {', '.join(known)}" if known else "it has none: add a table [scenarios.NAME]"
        raise InputError(f"scenario {chosen!r} is not in the study{nearest(chosen, known)}; {has}")
    made = RunsSweep(study=study, drive=name, scenario=chosen, draws=draws, size=min(size, draws))
    simulate(study.drives[name], study.scenarios[chosen])  # says what the drive lacks before samples are drawn
    return made
