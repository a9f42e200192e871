"""Robustness of a drive's verdicts: samples drawn within its tolerances."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar import power
from infinivar._core import engine as engines
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.described import derived, reported
from infinivar._core.engine import Engine
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness import outcomes
from infinivar.analysis.robustness.derivatives import designs
from infinivar.analysis.robustness.sampling import WORTH_COMPILING, Batch, draw, evaluated, in_pieces, padded
from infinivar.axis import LINEAR, PLANE, Axis, force_axis, speed_axis
from infinivar.limits import Limit, binding
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.study.requirement import Requirement
from infinivar.study.spreads import Spread, Uncertainty
from infinivar.units import plain

BAND = (0.05, 0.95)
"""Quantiles that bound 90 % of the samples."""

_POINTS = 65_536
"""Points computed at once, so that intermediate arrays fit the processor's caches."""

_COMPILED_POINTS = 3 * _POINTS
"""The same for compiled code."""

_MAP_CELLS = 60


@result
class BuildsMap(Result):
    """Statistics of the samples of a drive over speed (first axis) and force (second axis).

    Attributes
    ----------
    speed, force         Axes. [m/s], [N], or [rad/s], [N m] about a joint
    within               Share of samples within every limit. [-]
    limits               Share of samples in which each limit binds. [-]
    efficiency, spread   Mean and standard deviation of the efficiency of the samples within limits; nan without any. [-]
    """

    speed: np.ndarray = speed_axis()
    force: np.ndarray = force_axis()
    within: np.ndarray = reported("1", "share of samples within all limits", PLANE)
    limits: Mapping[Limit, np.ndarray] = reported("1", "share limited by {}", PLANE, variable="limit_{}")
    efficiency: np.ndarray = reported("1", "mean efficiency of samples within limits", PLANE)
    spread: np.ndarray = reported("1", "standard deviation of that efficiency", PLANE)
    axis: Axis = LINEAR


class Mapper:
    """Compute maps of samples of a drive repeatedly; with JAX, compile once.

    Parameters
    ----------
    drive : Drive             Provides the fields that do not vary.
    paths : sequence of str   Dotted paths of the fields that vary.
    speed, force : float      Axes of the map. [m/s], [N]
    method : str              numpy, jax, compiled, or auto: jax where it is installed and can compile the drive.

    Attributes
    ----------
    engine : str   numpy or jax, which computes.

    Raises
    ------
    InputError
        If JAX is requested and is not installed or cannot compile the drive.
    """

    def __init__(
        self,
        drive: AnyDrive,
        paths: Sequence[str],
        speed: Any,
        force: Any,
        *,
        method: Engine = "numpy",
    ) -> None:
        """Prepare the map, and compile it if so decided."""
        self.speed, self.force = np.asarray(speed, dtype=float), np.asarray(force, dtype=float)
        self._axis = getattr(drive, "axis", LINEAR)
        points = np.broadcast_arrays(self.speed[:, None], self.force[None, :])
        self._map = _mapped(drive, paths, *(axis.ravel() for axis in points))
        self._room = max(1, _POINTS // points[0].size)
        room = max(1, _COMPILED_POINTS // points[0].size)
        compiled, _ = engines.chosen(
            method, worth=True, compile=lambda: engines.compiled(self._map, [(room, len(paths))])
        )
        self.engine = "numpy" if compiled is None else "jax"
        if compiled is not None:
            self._map, self._room = functools.partial(padded, compiled, room), room

    def __call__(self, at: np.ndarray, progress: Callable[[float], None] | None = None) -> BuildsMap:
        """Return the statistics of samples.

        Parameters
        ----------
        at : (n, k) float   Values at the paths, one row per sample.
        progress            Called with the share done.
        """
        return self.statistics(self.counts(at, progress), len(at))

    def counts(self, at: np.ndarray, progress: Callable[[float], None] | None = None) -> np.ndarray:
        """Sums over samples, which may be added to those of other samples: see `statistics`. (limits + 3, speeds * forces)"""
        return functools.reduce(np.add, in_pieces(self._counted, at, self._room, progress=progress))

    def statistics(self, counts: np.ndarray, samples: int) -> BuildsMap:
        """Return the statistics of samples from the sum of their counts and their number."""
        counts = counts.reshape(-1, self.speed.size, self.force.size)
        known, mean, square = counts[-3:]
        some = known > 0
        average = np.where(some, mean / np.where(some, known, 1.0), np.nan)
        variance = np.where(some, square / np.where(some, known, 1.0), np.nan) - average**2
        binding_share = zip(Limit.every(), counts[: len(Limit.every())] / samples, strict=True)
        return BuildsMap(
            speed=self.speed,
            force=self.force,
            within=counts[0] / samples,
            limits=FrozenDict({limit: share for limit, share in binding_share if limit != Limit.OK and share.any()}),
            efficiency=average,
            spread=np.sqrt(np.clip(variance, 0.0, None)),
            axis=self._axis,
        )

    def _counted(self, at: np.ndarray) -> np.ndarray:
        """Count samples per binding limit at each point; within limits, also sum their efficiencies and the squares of these."""
        limit, found = self._map(at)
        known = (limit == Limit.OK) & np.isfinite(found)
        value = np.where(known, found, 0.0)
        rows = [np.sum(limit == code, axis=0, dtype=np.int32) for code in Limit.every()]
        return np.stack([*rows, np.sum(known, axis=0), np.sum(value, axis=0), np.sum(value * value, axis=0)])


def _mapped(
    drive: AnyDrive, paths: Sequence[str], speed: np.ndarray, force: np.ndarray
) -> Callable[[Any], tuple[Array, Array]]:
    """Return a function of samples that gives binding limit and efficiency at each point. (samples, points)"""

    def mapped(at: Any) -> tuple[Array, Array]:
        point = designs(drive, paths, at).operate(speed=speed, force=force)
        limit, _ = binding(point.utilisation)
        xp = namespace(point.power_in)
        shape = (at.shape[0], speed.size)
        found = power.efficiency(point.power_in, point.power_out + 0.0 * point.power_in)
        return xp.broadcast_to(xp.asarray(limit, dtype=xp.int8), shape), xp.broadcast_to(found, shape)

    return mapped


def band(values: np.ndarray) -> dict[str, float | None]:
    """Median and 90 % range over the feasible samples; inf where a value is unbounded."""
    known = values[~np.isnan(values)]
    if not known.size:
        return {"low": None, "median": None, "high": None}
    between = "linear" if np.isfinite(known).all() else "inverted_cdf"  # inf cannot be interpolated
    low, median, high = np.quantile(known, [BAND[0], 0.5, BAND[1]], method=between)
    return {"low": float(low), "median": float(median), "high": float(high)}


@result
class DutyBuilds(Result):
    """Samples of a drive in a duty cycle: arrays with one value per sample, nan where the wheel slips.

    Attributes
    ----------
    energy        Energy from the supply per cycle or over the run. [J]
    temperature   Highest winding temperature, settled or in the run; empty if no data sheet has thermal data. [K]
    able          Whether the sample is within every limit and no winding overheats.
    per           What the energy refers to: "per cycle" or "over the run".
    """

    energy: np.ndarray = reported("J", convert=band)
    temperature: np.ndarray = reported("K", convert=band)
    able: np.ndarray
    per: str = "per cycle"

    @derived(key="able")
    def share(self) -> float:
        """Share of feasible samples. [-]"""
        return float(np.mean(self.able))

    @property
    def verdict(self) -> str:
        """One clause for people."""
        found = band(self.energy)
        taken = (
            ""
            if found["low"] is None
            else f"; {plain(found['low'], 3)} to {plain(found['high'], 3)} J {self.per} in 90 % of samples"
        )
        return f"feasible in {percent(self.share, len(self.able))} of samples{taken}"


@result
class Builds(Result):
    """Samples of a drive within its tolerances, evaluated on a study's requirement and duty cycles.

    Attributes
    ----------
    spreads    Spreads of the fields that vary.
    values     (n, k) Values, one row per sample.
    coverage   Share of the required region in which a sample is within every limit; empty without a requirement. [-]
    margin     Tightest margin of a sample in the region; empty likewise. [-]
    loss       Loss of a sample at the corner of maximum force; nan where the wheel slips; empty likewise. [W]
    map        Statistics of all samples.
    duty       Results by name of the duty cycle.
    engine     numpy or jax, which computed the samples; "jax and numpy" if JAX could not compile all of it.
    """

    spreads: tuple[Spread, ...] = reported(key="varied")
    values: np.ndarray
    coverage: np.ndarray = reported("1", convert=band)
    margin: np.ndarray = reported("1", key="weakest_margin", convert=band)
    loss: np.ndarray = reported("W", key="loss_at_maximum_force_W", convert=band)
    map: BuildsMap
    duty: Mapping[str, DutyBuilds] = reported()
    engine: str = reported(default="numpy", compare=False)

    @derived(key="builds")
    def count(self) -> int:
        """Number of samples."""
        return len(self.values)

    @derived("1")
    def covering(self) -> float:
        """Share of samples that cover the requirement; nan without one. [-]"""
        return float(np.mean(self.margin >= 1.0)) if self.margin.size else float("nan")

    @derived()
    def verdict(self) -> str:
        """One clause for people."""
        if not self.margin.size:
            return f"{self.count} samples; no region is required"
        found = band(self.margin)
        spread = f"tightest margin {plain(found['low'], 3)} to {plain(found['high'], 3)} in 90 % of samples"
        return f"covers the requirement in {percent(self.covering, self.count)} of samples; {spread}"


def percent(share: float, count: int) -> str:
    """Format a share of samples; 100 % and 0 % only if no sample is an exception."""
    if share in (0.0, 1.0):
        return f"{100.0 * share:.0f} %"
    shown = min(max(100.0 * share, 0.1), 99.9) if count >= 1000 else min(max(round(100.0 * share), 1), 99)
    return f"{plain(shown, 3)} %"


def builds(
    drive: AnyDrive,
    name: str,
    uncertainty: Uncertainty,
    requirement: Requirement | None,
    duty: Mapping[str, DutyCycle],
    axes: tuple[np.ndarray, np.ndarray],
    progress: Callable[[float], None] | None = None,
    engine: Engine = "auto",
) -> Builds:
    """Sample a drive within its tolerances and evaluate the samples on a requirement and duty cycles.

    Parameters
    ----------
    drive, name       The drive and its name in the study.
    uncertainty       Contains spreads of that drive.
    requirement       Sampled on 41 lines of constant force; None if none is stated.
    duty              Duty cycles by name.
    axes              Speeds and forces that span the map. [m/s], [N]
    progress          Called with the share done.
    engine            As for `infinivar.analysis.robustness.sampling.evaluated`.

    Returns
    -------
    Builds   Quasi-Monte Carlo with a Sobol sequence: reproducible for the same study.

    Raises
    ------
    ParameterError
        If the drive lacks a value that a duty cycle requires.
    InputError
        If JAX is requested and is not installed or cannot compile the drive.
    """
    engines.check(engine)
    spreads = uncertainty.spreads[name]
    paths = [spread.path for spread in spreads]
    at = draw(spreads, uncertainty.correlation(name), uncertainty.draws)
    judged = judge(drive, spreads, at, requirement, duty, progress, engine)
    worth, stages = len(at) >= WORTH_COMPILING, 3 + len(duty)
    mapper = Mapper(drive, paths, *map_axes(axes), method=engine if worth or engine != "auto" else "numpy")
    return Builds(
        spreads=spreads,
        values=at,
        coverage=judged.region[:, 0],
        margin=judged.region[:, 1],
        loss=judged.loss,
        map=mapper(at, None if progress is None else lambda share: progress((stages - 1 + share) / stages)),
        duty=FrozenDict({task: duty_builds(found, duty[task]) for task, found in judged.duty.items()}),
        engine=" and ".join(sorted({*judged.engines, mapper.engine})),
    )


def map_axes(axes: tuple[np.ndarray, np.ndarray]) -> list[np.ndarray]:
    """Speeds and forces of the map of samples, within given ones."""
    return [np.linspace(axis[0], axis[-1], _MAP_CELLS) for axis in axes]


class SampleValues(NamedTuple):
    """Values of samples, one row each."""

    region: np.ndarray
    """Coverage and tightest margin; empty without a requirement. (n, 2) [-]"""
    loss: np.ndarray
    """At the corner of maximum force; empty likewise. (n,) [W]"""
    duty: Mapping[str, np.ndarray]
    """Energy, highest temperature, and whether feasible (1 or 0), by duty cycle. (n, 3) [J], [K], [-]"""
    engines: set[str]
    """What computed them."""


def judge(
    drive: AnyDrive,
    spreads: Sequence[Spread],
    at: np.ndarray,
    requirement: Requirement | None,
    duty: Mapping[str, DutyCycle],
    progress: Callable[[float], None] | None = None,
    engine: Engine = "numpy",
) -> SampleValues:
    """Evaluate samples on a requirement and duty cycles; arguments as for `builds`, with one row of `at` per sample."""
    paths, stages, used = [spread.path for spread in spreads], 3 + len(duty), set()
    worth = len(at) >= WORTH_COMPILING

    def progress_of(stage: int) -> Callable[[float], None]:
        return lambda share: progress((stage + share) / stages) if progress is not None else None

    def run(stage: int, of: Callable[[AnyDrive], Array], width: int) -> np.ndarray:
        batch = Batch(of, drive, paths, width=width, engine=engine, worth=worth)
        used.add(batch.engine)
        return batch(at, progress_of(stage))

    covered, loss = np.empty((0, 2)), np.empty(0)
    if requirement is not None:
        region, (speed, force) = requirement, requirement.corners()["maximum force"]
        covered = run(0, functools.partial(_covered, required=region), width=2)
        # A single point of each sample is not worth compiling.
        loss = evaluated(
            functools.partial(outcomes.loss, speed=speed, force=force), drive, paths, at, progress_of(1), engine="numpy"
        )
    travel = None if requirement is None else requirement.travel
    worked = {
        task: run(2 + place, functools.partial(outcomes.worked, duty=cycle, travel=travel), width=3)
        for place, (task, cycle) in enumerate(duty.items())
    }
    return SampleValues(covered, loss, worked, used)


def _covered(drive: AnyDrive, required: Requirement) -> Array:
    """Coverage and tightest margin of designs. (..., 2)"""
    found = outcomes.region(drive, required)
    return namespace(*found).stack(found, axis=-1)


def duty_builds(found: np.ndarray, duty: DutyCycle) -> DutyBuilds:
    """Samples in a duty cycle, from their values of `judge`."""
    heated = not np.isnan(found[:, 1]).all()
    return DutyBuilds(
        energy=found[:, 0],
        temperature=found[:, 1] if heated else np.empty(0),
        able=found[:, 2] > 0.5,
        per=duty.per,
    )
