"""Which parameters matter: derivatives and swings of an outcome one at a time, Sobol's indices all together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.bounds import permitted
from infinivar._core.fields import quantities_of, value_at
from infinivar._core.result import Frozen, Result, result
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness import outcomes
from infinivar.analysis.robustness.derivatives import Method, gradient, values_of
from infinivar.analysis.robustness.outcomes import Outcome
from infinivar.analysis.robustness.sampling import evaluated, low_discrepancy, placed
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import InputError, ParameterError
from infinivar.parts.bearing import SIZE_POWERS
from infinivar.study.spreads import Spread
from infinivar.study.study import Study
from infinivar.units import plain

TOLERANCE = 0.1
"""Of parameters about whose spread a study says nothing, relative."""

ASSUMED = f"{100.0 * TOLERANCE:g} % either way"
"""That in words."""

LARGEST = 8
"""Parameters among which Sobol's indices are computed, from the largest swing."""

SAMPLES = 512
"""Base samples of Sobol's indices: (parameters + 2) times as many evaluations."""

_NONE = 1e-9
"""Elasticities and relative swings below this are none worth the name."""

_LEFT_OUT = ("control.",)
"""Fields that steady operation and cycles do not depend on."""


class Direction(NamedTuple):
    """A change of design that the paper recommends: fields, and with which power of the change each goes."""

    words: str
    powers: Mapping[str, float]


def _bearing(at: str) -> dict[str, float]:
    """A smaller bearing."""
    return {f"{at}.{name}": -power for name, power in SIZE_POWERS.items()}


_GEOMETRY = "transmission.geometry"
DIRECTIONS = (
    Direction("higher friction, less preload", {"transmission.friction": 1.0, "transmission.preload": -1.0}),
    Direction(
        "stiffer wheel and cylinder, which creep less",
        {
            f"{_GEOMETRY}.wheel_material.youngs_modulus": 1.0,
            f"{_GEOMETRY}.cylinder_material.youngs_modulus": 1.0,
            "transmission.creep_stiffness": 1.0,
        },
    ),
    Direction(
        "less hysteresis",
        {
            f"{_GEOMETRY}.wheel_material.hysteresis_factor": -1.0,
            f"{_GEOMETRY}.cylinder_material.hysteresis_factor": -1.0,
            "transmission.rolling_torque": -1.0,
        },
    ),
    Direction("smaller axle bearings", {**_bearing(f"{_GEOMETRY}.axle_bearing"), "transmission.bearing_torque": -1.0}),
    Direction("smaller bell bearing", {**_bearing("steering.bell_bearing"), "steering.bell_friction": -1.0}),
    Direction("less steering inertia", {"steering.bell_inertia": -1.0, "steering.motor.rotor_inertia": -1.0}),
    Direction("lighter link", {"link_mass": -1.0}),
)
"""What section VII of the paper recommends; fields that a drive has not are passed over."""


@result
class Influence(Frozen):
    """What one parameter does to an outcome.

    Attributes
    ----------
    path, unit, value     Of the field.
    elasticity            Relative change of the outcome by relative change of the parameter. [-]
    low, high             Range over which the parameter is moved, alone.
    at_low, at_high       Outcome there; nan where the drive cannot do it, inf where it grows without bound.
    stated                Whether the study states the range.
    first, total          Sobol's indices: share of the variance that the parameter explains alone, and with others; None
        where not computed. [-]
    """

    path: str
    unit: str
    value: float
    elasticity: float
    low: float
    high: float
    at_low: float
    at_high: float
    stated: bool
    first: float | None = None
    total: float | None = None

    @property
    def words(self) -> str:
        """What people call the field: "motor torque constant"."""
        return self.path.replace(".", " ").replace("_", " ")

    @property
    def swing(self) -> float:
        """Difference of the outcome over the range; inf where one end has none."""
        return abs(self.at_high - self.at_low) if self.finite else math.inf

    @property
    def finite(self) -> bool:
        """Whether the outcome is a number at both ends."""
        return math.isfinite(self.at_low) and math.isfinite(self.at_high)

    @property
    def lost(self) -> str:
        """What becomes of the outcome at an end where it is no number, in words."""
        return "the drive cannot do it" if math.isnan(self.at_low + self.at_high) else "it grows without bound"


class Conclusion(NamedTuple):
    """A recommendation of the paper held against an outcome."""

    words: str
    elasticity: float
    """Relative change of the outcome by relative change in the direction recommended. [-]"""
    verdict: str
    """helps, hurts, or "does nothing"."""


@result
class Sensitivity(Result):
    """How an outcome of a drive depends on its parameters.

    Attributes
    ----------
    study, name, outcome   What was asked.
    value                  Of the outcome, of the drive as it is.
    influences             From the largest swing to the smallest.
    conclusions            The paper's recommendations, of a cobotic drive.
    impossible             Share of the samples of Sobol's indices which the drive cannot do. [-]
    beyond                 What the drive exceeds there, in words; "" where it keeps all limits.
    """

    study: Study
    name: str
    outcome: Outcome
    value: float
    influences: tuple[Influence, ...]
    conclusions: tuple[Conclusion, ...]
    impossible: float
    beyond: str

    @property
    def ranking(self) -> tuple[str, ...]:
        """The largest influences in words."""
        return tuple(_sentence(self, place, row) for place, row in enumerate(self.influences[:LARGEST]))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader has to know."""
        return (*self._on_limits(), *self._on_ranges(), *self._on_indices())

    def _on_limits(self) -> Iterator[str]:
        if self.beyond:
            what = (
                "do all of it within its limits"
                if self.outcome.of_limits
                else ("do this within its limits, so that these numbers are of no machine")
            )
            yield f"The drive cannot {what}: {self.beyond}."

    def _on_ranges(self) -> Iterator[str]:
        if not self.influences:
            yield "No parameter changes it over its range."
        assumed = [row for row in self.influences if not row.stated]
        if assumed:
            share = "All parameters" if len(assumed) == len(self.influences) else f"{len(assumed)} parameters"
            yield (
                f"{share} are moved by {ASSUMED}, as far as permitted, since the study states no range of theirs: "
                f"write [uncertainty.{self.name}] to say how far each may really be off."
            )
        ranked = {row.path for row in self.influences}
        idle = [spread for spread in self.study.uncertainty.spreads.get(self.name, ()) if spread.path not in ranked]
        for still, why in ((False, "change nothing here"), (True, "are not ranked: 1 % of zero is none")):
            named = ", ".join(spread.path for spread in idle if (spread.value == 0) == still)
            if named:
                yield f"Ranges that the study states and that {why}: {named}."

    def _on_indices(self) -> Iterator[str]:
        if self.impossible > 0:
            yield (
                f"{plain(100 * self.impossible, 2)} % of the samples cannot do it. They count as the worst of the others in "
                "Sobol's indices."
            )
        if any(owner == self.name for owner, _, _ in self.study.uncertainty.correlations):
            yield "Sobol's indices take the parameters as independent: the study's correlations do not enter."

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for scripts."""
        return {
            "drive": self.name,
            "of": self.outcome.name,
            "words": self.outcome.words,
            "unit": self.outcome.unit,
            "value": self.value,
            "parameters": [
                {
                    "path": row.path,
                    "value": row.value,
                    "unit": row.unit,
                    "elasticity": row.elasticity,
                    "low": row.low,
                    "high": row.high,
                    "at_low": row.at_low,
                    "at_high": row.at_high,
                    "range_stated": row.stated,
                    "sobol_first": row.first,
                    "sobol_total": row.total,
                }
                for row in self.influences
            ],
            "conclusions": [row._asdict() for row in self.conclusions],
            "impossible": self.impossible,
            "beyond_limits": self.beyond,
            "ranking": list(self.ranking),
            "remarks": list(self.remarks),
        }


def sensitivity(
    study: Study,
    name: str,
    kind: str,
    *,
    speed: float | None = None,
    force: float | None = None,
    duty: str | None = None,
    method: Method = "complex",
    samples: int = SAMPLES,
    progress: Callable[[str, float], None] | None = None,
) -> Sensitivity:
    """Sensitivity of one outcome of a drive to its parameters.

    Parameters
    ----------
    study, name          The study, and the drive in it.
    kind, speed, force, duty   Of the outcome, as in `infinivar.analysis.robustness.outcomes.outcome`.
    method : str         Of the derivatives: ``complex``, ``jax`` or ``difference``.
    samples : int        Base samples of Sobol's indices, a power of two; 0 for none.
    progress             Called with what is done and the share done.

    Returns
    -------
    Sensitivity   Parameters without influence are left out.

    Raises
    ------
    InputError
        If drive or outcome are not known, the drive cannot do it at all, or lacks a value that it needs.

    Source: sobol2001 for the indices; squire1998 for the derivatives.
    """
    drive = _modelled(study, name)
    asked = outcomes.outcome(study, kind, speed=speed, force=force, duty=duty)
    tell = progress or (lambda title, share: None)
    tell("derivatives", 0.0)
    try:
        paths, value, elasticities = _elasticities(asked, drive, method)
    except ParameterError as problem:
        raise InputError(f"drives.{name}: {problem}") from problem
    _check_finite(asked, drive, name, value)
    stated = {spread.path: spread for spread in study.uncertainty.spreads.get(name, ())}
    fields = quantities_of(drive)
    spreads = [stated.get(path) or _assumed(drive, name, path, fields[path]) for path in paths]
    tell("swings", 0.1)
    influences = _influences(asked, drive, spreads, elasticities, stated)
    chosen = [row for row in influences if row.high > row.low][:LARGEST]
    impossible = 0.0
    if samples and len(chosen) > 1:
        by_path = {spread.path: spread for spread in spreads}
        first, total, impossible = _indices(
            asked,
            drive,
            [by_path[row.path] for row in chosen],
            samples,
            lambda share: tell("Sobol's indices", 0.2 + 0.8 * share),
        )
        told = {row.path: replace(row, first=a, total=b) for row, a, b in zip(chosen, first, total, strict=True)}
        influences = tuple(told.get(row.path, row) for row in influences)
    return Sensitivity(
        study=study,
        name=name,
        outcome=asked,
        value=value,
        influences=influences,
        conclusions=conclusions(asked, dict(zip(paths, elasticities, strict=True)), drive),
        impossible=impossible,
        beyond=asked.beyond(drive),
    )


def _modelled(study: Study, name: str) -> AnyDrive:
    drive = study.drive(name)
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        raise InputError(f"drives.{name}: a drive of type {type(drive).__name__} has no outcomes")
    return drive


def _check_finite(asked: Outcome, drive: AnyDrive, name: str, value: float) -> None:
    """Refuse an outcome that is no number: nothing can be ranked by it."""
    if math.isnan(value):
        raise InputError(f"drives.{name}: {asked.words}: the drive cannot do it, so there is nothing to compare")
    if math.isinf(value):
        why = asked.beyond(drive) or "it grows without bound"
        raise InputError(f"drives.{name}: {asked.words}: has no end, so there is nothing to rank: {why}")


def _elasticities(asked: Outcome, drive: AnyDrive, method: Method) -> tuple[list[str], float, np.ndarray]:
    """Paths of all fields that could have an influence, the outcome, and its relative derivatives by them."""
    paths = [path for path in quantities_of(drive) if not path.startswith(_LEFT_OUT) and value_at(drive, path) != 0]
    value, slopes = gradient(asked.of, drive, paths, method=method)
    return paths, float(value), slopes * values_of(drive, paths) / (float(value) or 1.0)


def _assumed(drive: AnyDrive, name: str, path: str, field: Field[Any]) -> Spread:
    """The range of a parameter about which the study says nothing."""
    value = float(value_at(drive, path))
    least, largest = permitted(field.metadata["bound"], value)
    size = TOLERANCE * abs(value)
    return Spread(
        owner=name,
        path=path,
        unit=field.metadata["unit"],
        value=value,
        low=max(value - size, least),
        high=min(value + size, largest),
        deviation=None,
        kind="assumed",
        where=ASSUMED,
    )


def _influences(
    asked: Outcome, drive: AnyDrive, spreads: Sequence[Spread], elasticities: np.ndarray, stated: Mapping[str, Spread]
) -> tuple[Influence, ...]:
    """Every parameter moved to the ends of its range, alone; of a normal spread those of 95 %."""
    paths = [spread.path for spread in spreads]
    if not paths:
        return ()
    ends = np.asarray(
        [spread.at(np.array([0.025, 0.975]) if spread.deviation else np.array([0.0, 1.0])) for spread in spreads]
    )
    at = np.repeat(values_of(drive, paths)[None, :], 2 * len(paths), axis=0)
    for place in range(len(paths)):
        at[2 * place : 2 * place + 2, place] = ends[place]
    found = evaluated(asked.of, drive, paths, at).reshape(-1, 2)
    rows = [
        Influence(
            path=spread.path,
            unit=spread.unit,
            value=spread.value,
            elasticity=float(elasticities[place]),
            low=float(ends[place, 0]),
            high=float(ends[place, 1]),
            at_low=float(found[place, 0]),
            at_high=float(found[place, 1]),
            stated=spread.path in stated,
        )
        for place, spread in enumerate(spreads)
    ]
    moved = [row for row in rows if abs(row.elasticity) > _NONE or row.swing > _NONE * abs(row.at_low)]
    return tuple(sorted(moved, key=lambda row: -row.swing))


def _indices(
    asked: Outcome, drive: AnyDrive, spreads: Sequence[Spread], samples: int, progress: Callable[[float], None]
) -> tuple[list[float], list[float], float]:
    """First and total indices of Sobol, and the share of samples that cannot be done."""
    size = len(spreads)
    shares = low_discrepancy(samples, 2 * size)
    first, second = (placed(spreads, part) for part in np.split(shares, 2, axis=1))
    mixed = np.repeat(first[None], size, axis=0)
    for place in range(size):
        mixed[place, :, place] = second[:, place]
    at = np.concatenate([first, second, mixed.reshape(-1, size)])
    found = evaluated(asked.of, drive, [spread.path for spread in spreads], at, progress)
    lost = ~np.isfinite(found)
    if lost.all():
        return [math.nan] * size, [math.nan] * size, 1.0
    worst = np.min(found[~lost]) if asked.better > 0 else np.max(found[~lost])
    found = np.where(lost, worst, found)
    own, total = sobol(found[:samples], found[samples : 2 * samples], found[2 * samples :].reshape(size, samples))
    return own.tolist(), total.tolist(), float(np.mean(lost))


def sobol(first: np.ndarray, second: np.ndarray, mixed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sobol's indices from a function's values at two independent samples and at the mixtures of both.

    Parameters
    ----------
    first, second : (n,) float   At samples A and B.
    mixed : (k, n) float         At A with the column of one parameter from B.

    Returns
    -------
    first order, total : (k,) float   nan where nothing varies. [-]

    Source: sobol2001; estimators of saltelli2010, by SciPy.
    """
    from scipy.stats import sobol_indices

    if np.ptp(np.concatenate([first, second])) <= 1e-14 * np.max(np.abs(first)):
        return np.full(len(mixed), np.nan), np.full(len(mixed), np.nan)
    found = sobol_indices(func={"f_A": first[None], "f_B": second[None], "f_AB": mixed[:, None, :]}, n=len(first))
    return np.atleast_1d(np.squeeze(found.first_order)), np.atleast_1d(np.squeeze(found.total_order))


def conclusions(asked: Outcome, elasticities: Mapping[str, float], drive: AnyDrive) -> tuple[Conclusion, ...]:
    """The paper's recommendations held against an outcome of a cobotic drive; nothing for another.

    Source: faulring2006, section VII.
    """
    if not isinstance(drive, CoboticDrive):
        return ()
    known, found = quantities_of(drive), []
    for direction in DIRECTIONS:
        if not any(path in known for path in direction.powers):
            continue
        slope = sum(power * elasticities.get(path, 0.0) for path, power in direction.powers.items())
        verdict = "does nothing" if abs(slope) < 1e-6 else "helps" if slope * asked.better > 0 else "hurts"
        found.append(Conclusion(direction.words, float(slope), verdict))
    return tuple(found)


def _sentence(found: Sensitivity, place: int, row: Influence) -> str:
    from infinivar import units

    more = "more" if row.elasticity > 0 else "less"
    moved = f"{units.show(row.low, row.unit)} to {units.show(row.high, row.unit)}"
    if not row.finite:
        span = f"over {moved} there are values with which {row.lost}"
    else:
        ends = f"{plain(row.at_low)} to {units.show(row.at_high, found.outcome.unit)}"
        span = f"from {moved} it goes from {ends}"
    share = "" if row.total is None or math.isnan(row.total) else f"; {100 * max(row.total, 0.0):.0f} % of the variance"
    return f"{place + 1}. {row.words}: 1 % more of it makes {plain(abs(row.elasticity), 3)} % {more}; {span}{share}"
