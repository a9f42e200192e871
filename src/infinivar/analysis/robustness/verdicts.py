"""How a drive's verdicts hold up over the builds that its tolerances allow."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from infinivar import power
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Result, result
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness import outcomes
from infinivar.analysis.robustness.derivatives import designs, jax_with_float64
from infinivar.analysis.robustness.sampling import draw, evaluated, in_pieces
from infinivar.limits import Limit, binding
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.study.requirement import Requirement
from infinivar.study.spreads import Spread, Uncertainty
from infinivar.units import plain

BAND = (0.05, 0.95)
"""Shares of builds between which nine in ten lie."""

_POINTS = 65_536
"""Computed at once: intermediate arrays stay within the processor's caches."""

_MAP_CELLS = 60


@result
class BuildsMap(Result):
    """Maps over speed (first axis) and force (second axis) of what builds of a drive do.

    Attributes
    ----------
    speed, force         Axes. [m/s], [N]
    within               Share of builds that keep every limit. [-]
    limits               Share of builds in which each limit binds. [-]
    efficiency, spread   Mean and standard deviation of the efficiency of the builds within limits; nan where there are none. [-]
    """

    speed: np.ndarray
    force: np.ndarray
    within: np.ndarray
    limits: Mapping[Limit, np.ndarray]
    efficiency: np.ndarray
    spread: np.ndarray


class Mapper:
    """Maps builds of a drive, again and again: with JAX compiled once.

    Parameters
    ----------
    drive : drive             Gives what does not vary.
    paths : sequence of str   Fields that vary, by dotted path.
    speed, force : float      Axes of the map. [m/s], [N]
    method : str              numpy, on all processors; or jax, compiled at the first call.

    Raises
    ------
    InputError
        If JAX is asked for and not installed.
    """

    def __init__(
        self,
        drive: AnyDrive,
        paths: Sequence[str],
        speed: Any,
        force: Any,
        *,
        method: Literal["numpy", "jax"] = "numpy",
    ) -> None:
        """Get ready; nothing is computed yet."""
        self.speed, self.force = np.asarray(speed, dtype=float), np.asarray(force, dtype=float)
        points = np.broadcast_arrays(self.speed[:, None], self.force[None, :])
        self._map = _mapped(drive, paths, *(axis.ravel() for axis in points))
        self._room, self._workers, self._padded = max(1, _POINTS // points[0].size), None, False
        if method == "jax":
            # It has threads of its own (the second here counts meanwhile), and compiles anew for each size of a piece.
            self._map = jax_with_float64().jit(self._map)
            self._room, self._workers, self._padded = 3 * self._room, 2, True

    def __call__(self, at: np.ndarray, progress: Callable[[float], None] | None = None) -> BuildsMap:
        """Maps of builds together.

        Parameters
        ----------
        at : (n, k) float   Values at the paths, a build a row.
        progress            Called with the share done.
        """
        pieces = in_pieces(self._counted, at, self._room, workers=self._workers, progress=progress)
        counts = functools.reduce(np.add, pieces).reshape(-1, self.speed.size, self.force.size)
        known, mean, square = counts[-3:]
        some = known > 0
        average = np.where(some, mean / np.where(some, known, 1.0), np.nan)
        variance = np.where(some, square / np.where(some, known, 1.0), np.nan) - average**2
        binding_share = zip(Limit, counts[: len(Limit)] / len(at), strict=True)
        return BuildsMap(
            speed=self.speed,
            force=self.force,
            within=counts[0] / len(at),
            limits=FrozenDict({limit: share for limit, share in binding_share if limit != Limit.OK and share.any()}),
            efficiency=average,
            spread=np.sqrt(np.clip(variance, 0.0, None)),
        )

    def _counted(self, at: np.ndarray) -> np.ndarray:
        """At each point: builds that each limit binds; of those within: how many have an efficiency, its sum and of squares."""
        count = len(at)
        if self._padded:
            at = np.concatenate([at, np.repeat(at[:1], self._room - count, axis=0)])
        limit, found = (np.asarray(part)[:count] for part in self._map(at))
        known = (limit == Limit.OK) & np.isfinite(found)
        value = np.where(known, found, 0.0)
        rows = [np.sum(limit == code, axis=0, dtype=np.int32) for code in Limit]
        return np.stack([*rows, np.sum(known, axis=0), np.sum(value, axis=0), np.sum(value * value, axis=0)])


def _mapped(
    drive: AnyDrive, paths: Sequence[str], speed: np.ndarray, force: np.ndarray
) -> Callable[[Any], tuple[Array, Array]]:
    """Function of builds: which limit binds at each point, and the efficiency there. (builds, points)"""

    def mapped(at: Any) -> tuple[Array, Array]:
        point = designs(drive, paths, at).operate(speed=speed, force=force)
        limit, _ = binding(point.utilisation)
        xp = namespace(point.power_in)
        shape = (at.shape[0], speed.size)
        found = power.efficiency(point.power_in, point.power_out + 0.0 * point.power_in)
        return xp.broadcast_to(xp.asarray(limit, dtype=xp.int8), shape), xp.broadcast_to(found, shape)

    return mapped


@result
class DutyBuilds(Result):
    """Builds of a drive in a duty cycle: arrays of a value a build; nan where it slips.

    Attributes
    ----------
    energy        From the supply in a cycle. [J]
    temperature   Highest winding temperature, settled; empty where no data sheet tells. [K]
    able          Whether the build keeps every limit and no winding gets too hot.
    """

    energy: np.ndarray
    temperature: np.ndarray
    able: np.ndarray

    @property
    def share(self) -> float:
        """Of builds that do it. [-]"""
        return float(np.mean(self.able))

    @property
    def verdict(self) -> str:
        """One clause for people."""
        found = band(self.energy)
        taken = (
            ""
            if found["low"] is None
            else f"; nine in ten take {plain(found['low'], 3)} to {plain(found['high'], 3)} J a cycle"
        )
        return f"{percent(self.share, len(self.able))} of builds do it{taken}"


@result
class Builds(Result):
    """Builds of a drive within its tolerances, held against a study's requirement and duty cycles.

    Attributes
    ----------
    spreads    What varies.
    values     (n, k) A build a row.
    coverage   Share of the required region in which a build keeps every limit. [-]
    margin     Weakest margin of a build in the region. [-]
    loss       Of a build at the corner of maximum force; nan where it slips. [W]
    map        Of all builds together.
    duty       By name of the duty cycle.
    """

    spreads: tuple[Spread, ...]
    values: np.ndarray
    coverage: np.ndarray
    margin: np.ndarray
    loss: np.ndarray
    map: BuildsMap
    duty: Mapping[str, DutyBuilds]

    @property
    def count(self) -> int:
        """Builds drawn."""
        return len(self.values)

    @property
    def covering(self) -> float:
        """Share of builds that cover the requirement. [-]"""
        return float(np.mean(self.margin >= 1.0))

    @property
    def verdict(self) -> str:
        """One clause for people."""
        found = band(self.margin)
        nine = f"nine in ten have a weakest margin from {plain(found['low'], 3)} to {plain(found['high'], 3)}"
        return f"covers the requirement in {percent(self.covering, self.count)} of builds; {nine}"

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        return {
            "builds": self.count,
            "verdict": self.verdict,
            "covering": self.covering,
            "coverage": band(self.coverage),
            "weakest_margin": band(self.margin),
            "loss_at_maximum_force_W": band(self.loss),
            "varied": [
                {"path": s.path, "unit": s.unit, "value": s.value, "range": s.words, "kind": s.kind, "where": s.where}
                for s in self.spreads
            ],
            "duty": {
                name: {"able": found.share, "energy_J": band(found.energy), "temperature_K": band(found.temperature)}
                for name, found in self.duty.items()
            },
        }


def percent(share: float, count: int) -> str:
    """A share of builds in words: 100 % and 0 % only if there is no exception among them."""
    if share in (0.0, 1.0):
        return f"{100.0 * share:.0f} %"
    shown = min(max(100.0 * share, 0.1), 99.9) if count >= 1000 else min(max(round(100.0 * share), 1), 99)
    return f"{plain(shown, 3)} %"


def band(values: np.ndarray) -> dict[str, float | None]:
    """Median and the range of nine builds in ten, of those that can do it; inf where a value grows without bound."""
    known = values[~np.isnan(values)]
    if not known.size:
        return {"low": None, "median": None, "high": None}
    between = "linear" if np.isfinite(known).all() else "inverted_cdf"  # there is no line to infinity
    low, median, high = np.quantile(known, [BAND[0], 0.5, BAND[1]], method=between)
    return {"low": float(low), "median": float(median), "high": float(high)}


def builds(
    drive: AnyDrive,
    name: str,
    uncertainty: Uncertainty,
    requirement: Requirement,
    duty: Mapping[str, DutyCycle],
    axes: tuple[np.ndarray, np.ndarray],
    progress: Callable[[float], None] | None = None,
) -> Builds:
    """Draw builds of a drive and hold them against a requirement and duty cycles.

    Parameters
    ----------
    drive, name       The drive and its name in the study.
    uncertainty       With spreads of that drive.
    requirement       Sampled on 41 lines of constant force.
    duty              By name.
    axes              Speeds and forces whose span the map covers. [m/s], [N]
    progress          Called with the share done.

    Returns
    -------
    Builds   Quasi-Monte Carlo by Sobol's sequence: the same for the same study.

    Raises
    ------
    ParameterError
        If the drive lacks a value that a duty cycle needs.
    """
    spreads = uncertainty.spreads[name]
    paths = [spread.path for spread in spreads]
    at = draw(spreads, uncertainty.correlation(name), uncertainty.draws)
    stages = 3 + len(duty)

    def told(stage: int) -> Callable[[float], None]:
        return lambda share: progress((stage + share) / stages) if progress is not None else None

    speed, force = requirement.corners()["maximum force"]
    covered = evaluated(
        lambda d: np.stack(outcomes.region(d, requirement), axis=-1), drive, paths, at, told(0), width=2
    )
    return Builds(
        spreads=spreads,
        values=at,
        coverage=covered[:, 0],
        margin=covered[:, 1],
        loss=evaluated(lambda d: outcomes.loss(d, speed, force), drive, paths, at, told(1)),
        map=Mapper(drive, paths, *(np.linspace(axis[0], axis[-1], _MAP_CELLS) for axis in axes))(at, told(2)),
        duty=FrozenDict(
            {
                task: _worked(drive, paths, at, cycle, requirement.travel, told(3 + place))
                for place, (task, cycle) in enumerate(duty.items())
            }
        ),
    )


def _worked(
    drive: AnyDrive,
    paths: Sequence[str],
    at: np.ndarray,
    duty: DutyCycle,
    travel: float | None,
    progress: Callable[[float], None],
) -> DutyBuilds:
    found = evaluated(lambda d: outcomes.worked(d, duty, travel), drive, paths, at, progress, width=3)
    heated = not np.isnan(found[:, 1]).all()
    return DutyBuilds(
        energy=found[:, 0],
        temperature=found[:, 1] if heated else np.empty(0),
        able=found[:, 2] > 0.5,
    )
