"""Sensitivity of an outcome: derivatives and swings for single parameters, Sobol's indices for all together."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.bounds import permitted
from infinivar._core.described import at, derived, reported
from infinivar._core.engine import Engine
from infinivar._core.engine import check as check_engine
from infinivar._core.fields import quantities_of, value_at
from infinivar._core.result import Frozen, Result, result
from infinivar._core.text import capitalise
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.robustness import outcomes
from infinivar.analysis.robustness.derivatives import Method, gradient, values_of
from infinivar.analysis.robustness.outcomes import Outcome
from infinivar.analysis.robustness.sampling import WORTH_COMPILING, Batch, evaluated, low_discrepancy, placed
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import is_machine, type_words
from infinivar.errors import InputError, ParameterError
from infinivar.parts.bearing import SIZE_POWERS
from infinivar.study.check import check_study
from infinivar.study.spreads import Spread
from infinivar.study.study import Study
from infinivar.units import plain

TOLERANCE = 0.1
"""Relative spread of parameters for which the study states none."""

ASSUMED = f"± {100.0 * TOLERANCE:g} %"
"""`TOLERANCE` in words."""

LARGEST = 8
"""Number of parameters, by decreasing swing, for which Sobol's indices are computed."""

SAMPLES = 512
"""Base samples of Sobol's indices; the outcome is evaluated (parameters + 2) times per base sample."""

_NONE = 1e-9
"""Elasticities and relative swings below this count as zero."""

_POINTS = ("efficiency", "loss")
"""Outcomes at a single point, which are not worth compiling."""

_IDLE = "No parameter affects the outcome over its range."
"""The answer where there is no influence."""

_LEFT_OUT = ("control.", "transmission.cylinder_tube.")
"""Prefixes of fields that affect neither steady operation nor cycles, or are sizes of a part from stock."""


class Direction(NamedTuple):
    """A design change that the paper recommends: fields, and the power of the change by which each scales."""

    words: str
    powers: Mapping[str, float]


def _bearing(at: str) -> dict[str, float]:
    """Powers for a smaller bearing."""
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
"""Recommendations of section VII of the paper; fields that a drive lacks are skipped."""


class Conclusion(NamedTuple):
    """Effect of a recommendation of the paper on an outcome."""

    words: str
    elasticity: float
    """Relative change of the outcome per relative change in the recommended direction. [-]"""
    verdict: str
    """helps, hurts, or "no effect"."""


@result
class Influence(Frozen):
    """Influence of one parameter on an outcome.

    Attributes
    ----------
    path, unit, value     Path, unit and nominal value of the field.
    elasticity            Relative change of the outcome per relative change of the parameter. [-]
    low, high             Range over which the parameter alone is varied.
    at_low, at_high       Outcome at the ends; nan if infeasible, inf if unbounded.
    stated                Whether the study states the range.
    first, total          Sobol's indices: share of the variance that the parameter explains alone, and with interactions;
        None if not computed. [-]
    """

    path: str = reported()
    unit: str = reported()
    value: float = reported()
    elasticity: float = reported("1")
    low: float = reported()
    high: float = reported()
    at_low: float = reported()
    at_high: float = reported()
    stated: bool = reported(key="range_stated")
    first: float | None = reported("1", key="sobol_first", default=None)
    total: float | None = reported("1", key="sobol_total", default=None)

    @property
    def words(self) -> str:
        """Display name of the field, such as "motor torque constant"."""
        return self.path.replace(".", " ").replace("_", " ")

    @property
    def swing(self) -> float:
        """Change of the outcome over the range; inf if either end is not finite."""
        return abs(self.at_high - self.at_low) if self.finite else math.inf

    @property
    def finite(self) -> bool:
        """Whether the outcome is finite at both ends."""
        return math.isfinite(self.at_low) and math.isfinite(self.at_high)

    @property
    def lost(self) -> str:
        """Why the outcome has no finite value at an end of the range."""
        return "infeasible" if math.isnan(self.at_low + self.at_high) else "unbounded"


@result
class Sensitivity(Result):
    """Sensitivity of an outcome of a drive to its parameters.

    Attributes
    ----------
    study, name, outcome   Arguments of the call.
    value                  Outcome of the nominal drive.
    influences             Influences by decreasing swing.
    conclusions            Effects of the paper's recommendations, for a cobotic drive.
    impossible             Share of infeasible samples among those of Sobol's indices. [-]
    beyond                 Limits that the nominal drive exceeds, in words; "" if none.
    engine                 numpy or jax, which computed the samples of Sobol's indices.
    """

    study: Study
    name: str = reported(key="drive")
    outcome: Outcome
    value: float = reported()
    influences: tuple[Influence, ...] = reported(key="parameters", table="path")
    conclusions: tuple[Conclusion, ...] = reported()
    impossible: float = reported("1")
    beyond: str = reported(key="beyond_limits")
    engine: str = reported(default="numpy", compare=False)

    _also = (at("outcome.name", key="of"), at("outcome.words"), at("outcome.unit"))

    @derived()
    def ranking(self) -> tuple[str, ...]:
        """The largest influences, one sentence each."""
        return tuple(f"{place}. {_sentence(self, row)}" for place, row in enumerate(self.influences[:LARGEST], 1))

    @property
    def answer(self) -> str:
        """Which parameter has most influence, in one sentence."""
        return f"{capitalise(_sentence(self, self.influences[0]))}." if self.influences else _IDLE

    @derived()
    def remarks(self) -> tuple[str, ...]:
        """Remarks on limits, ranges and indices."""
        return (*self._on_limits(), *self._on_ranges(), *self._on_indices())

    def _on_limits(self) -> Iterator[str]:
        if self.beyond:
            meaning = "" if self.outcome.of_limits else ", so these numbers describe an infeasible operation"
            yield f"The drive exceeds its limits{meaning}: {self.beyond}."

    def _on_ranges(self) -> Iterator[str]:
        if not self.influences:
            yield _IDLE
        assumed = [row for row in self.influences if not row.stated]
        if assumed:
            share = "All parameters" if len(assumed) == len(self.influences) else f"{len(assumed)} parameters"
            yield (
                f"{share} without a range in the study are varied by {ASSUMED} within their bounds: "
                f"add [uncertainty.{self.name}] to state their actual spreads."
            )
        ranked = {row.path for row in self.influences}
        idle = [spread for spread in self.study.uncertainty.spreads.get(self.name, ()) if spread.path not in ranked]
        for still, why in ((False, "have no effect here"), (True, "cannot be ranked, as their nominal value is zero")):
            named = ", ".join(spread.path for spread in idle if (spread.value == 0) == still)
            if named:
                yield f"Parameters with a stated range that {why}: {named}."

    def _on_indices(self) -> Iterator[str]:
        if self.engine == "jax":
            yield "The samples of Sobol's indices were computed by compiled code (JAX)."
        if self.impossible > 0:
            yield (
                f"{plain(100 * self.impossible, 2)} % of the samples are infeasible; Sobol's indices count them as the worst "
                "feasible sample."
            )
        if any(owner == self.name for owner, _, _ in self.study.uncertainty.correlations):
            yield "Sobol's indices treat the parameters as independent and ignore the study's correlations."


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
    engine: Engine = "auto",
    progress: Callable[[str, float], None] | None = None,
) -> Sensitivity:
    """Compute the sensitivity of one outcome of a drive to its parameters.

    Parameters
    ----------
    study, name          The study and the name of a drive in it.
    kind, speed, force, duty   Outcome, as in `infinivar.analysis.robustness.outcomes.outcome`.
    method : str         Method of the derivatives: ``complex``, ``jax`` or ``difference``.
    samples : int        Base samples of Sobol's indices, a power of two; 0 skips the indices.
    engine : str         For the samples of Sobol's indices: numpy; jax, compiled, with the same numbers to rounding; or auto: jax
        for many samples, where it is installed and can compile the outcome.
    progress             Called with the current step and the share done.

    Returns
    -------
    Sensitivity   Parameters without influence are omitted.

    Raises
    ------
    InputError
        If the drive or the outcome is unknown, the outcome is infeasible, the drive lacks a required value, or JAX is requested
        and is not installed or cannot compile the outcome.

    Source: sobol2001 for the indices; squire1998 for the derivatives.
    """
    check_study(study)
    check_engine(engine)
    drive = modelled(study, name)
    outcome = outcomes.outcome(study, kind, speed=speed, force=force, duty=duty)
    tell = progress or (lambda title, share: None)
    tell("derivatives", 0.0)
    try:
        paths, value, slopes = elasticities(outcome.of, drive, method)
    except ParameterError as problem:
        raise InputError(f"drives.{name}: {problem}") from problem
    _check_finite(outcome, drive, name, value)
    stated = {spread.path: spread for spread in study.uncertainty.spreads.get(name, ())}
    fields = quantities_of(drive)
    spreads = [stated.get(path) or _assumed(drive, name, path, fields[path]) for path in paths]
    tell("swings", 0.1)
    influences = _influences(outcome, drive, spreads, slopes, stated)
    found = Sensitivity(
        study=study,
        name=name,
        outcome=outcome,
        value=value,
        influences=influences,
        conclusions=conclusions(outcome, dict(zip(paths, slopes, strict=True)), drive),
        impossible=0.0,
        beyond=outcome.beyond(drive),
    )
    ranked = ranked_spreads(found)
    if samples and len(ranked) > 1:
        batch = Batch(
            outcome.of,
            drive,
            [spread.path for spread in ranked],
            engine=engine,
            worth=outcome.name not in _POINTS and samples * (len(ranked) + 2) >= WORTH_COMPILING,
        )
        report = functools.partial(tell, "Sobol's indices")
        values = index_values(batch, ranked, samples, progress=lambda share: report(0.2 + 0.8 * share))
        found = replace(with_indices(found, ranked, values), engine=batch.engine)
    return found


def ranked_spreads(found: Sensitivity) -> list[Spread]:
    """Spreads of the parameters whose Sobol's indices are computed, by decreasing swing."""
    drive = modelled(found.study, found.name)
    stated = {spread.path: spread for spread in found.study.uncertainty.spreads.get(found.name, ())}
    fields = quantities_of(drive)
    paths = [row.path for row in found.influences if row.high > row.low][:LARGEST]
    return [stated.get(path) or _assumed(drive, found.name, path, fields[path]) for path in paths]


def modelled(study: Study, name: str) -> AnyDrive:
    """A drive of a study, of a type whose parameters can be ranked; InputError otherwise."""
    drive = study.drive(name)
    if is_machine(drive):
        raise ParameterError(
            f"drives.{name} is a machine of type {type_words(drive)}: use machine_sensitivity, for a task or path"
        )
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        raise InputError(f"drives.{name}: sensitivity is not defined for a drive of type {type(drive).__name__}")
    return drive


def _check_finite(outcome: Outcome, drive: AnyDrive, name: str, value: float) -> None:
    """Refuse an outcome that is not finite, as it cannot rank parameters."""
    if math.isnan(value):
        raise InputError(f"drives.{name}: {outcome.words}: infeasible, so parameters cannot be ranked")
    if math.isinf(value):
        why = outcome.beyond(drive) or "it diverges"
        raise InputError(f"drives.{name}: {outcome.words}: unbounded, so parameters cannot be ranked: {why}")


def elasticities(of: Callable[[Any], Any], drive: AnyDrive, method: Method) -> tuple[list[str], float, np.ndarray]:
    """Paths of all candidate fields, the outcome of a drive, and its elasticities. (k,) [-]"""
    paths = [path for path in quantities_of(drive) if not path.startswith(_LEFT_OUT) and value_at(drive, path) != 0]
    value, slopes = gradient(of, drive, paths, method=method)
    return paths, float(value), slopes * values_of(drive, paths) / (float(value) or 1.0)


def _assumed(drive: AnyDrive, name: str, path: str, field: Field[Any]) -> Spread:
    """Assumed range of a parameter for which the study states none."""
    value = float(value_at(drive, path))
    least, largest = permitted(field.metadata["bound"], value)
    tube = drive.transmission.cylinder_tube if isinstance(drive, CoboticDrive) else None
    if tube is not None and path == "transmission.cylinder_radius":
        least, largest = tube.radii
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
    outcome: Outcome, drive: AnyDrive, spreads: Sequence[Spread], elasticities: np.ndarray, stated: Mapping[str, Spread]
) -> tuple[Influence, ...]:
    """Vary each parameter alone to the ends of its range, the 95 % range for a normal spread."""
    paths = [spread.path for spread in spreads]
    if not paths:
        return ()
    ends = np.asarray(
        [spread.at(np.array([0.025, 0.975]) if spread.deviation else np.array([0.0, 1.0])) for spread in spreads]
    )
    at = np.repeat(values_of(drive, paths)[None, :], 2 * len(paths), axis=0)
    for place in range(len(paths)):
        at[2 * place : 2 * place + 2, place] = ends[place]
    found = evaluated(outcome.of, drive, paths, at).reshape(-1, 2)
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


def index_values(
    batch: Batch,
    spreads: Sequence[Spread],
    samples: int,
    start: int = 0,
    progress: Callable[[float], None] | None = None,
) -> np.ndarray:
    """Outcomes at two samples, and at the first with the column of one parameter each taken from the second. (k + 2, samples)

    Parameters
    ----------
    batch : Batch          Evaluates an outcome for values of the parameters.
    spreads : sequence     Of k parameters that vary.
    samples, start : int   Number of samples, and of the first one, so that a part of a larger sample can be had alone.
    """
    size = len(spreads)
    shares = low_discrepancy(samples, 2 * size, start=start)
    first, second = (placed(spreads, part) for part in np.split(shares, 2, axis=1))
    mixed = np.repeat(first[None], size, axis=0)
    for place in range(size):
        mixed[place, :, place] = second[:, place]
    at = np.concatenate([first, second, mixed.reshape(-1, size)])
    return batch(at, progress).reshape(size + 2, samples)


def indices(outcome: Outcome, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Sobol's first-order and total indices from values of `index_values`, and the share of infeasible samples. (k,), (k,)"""
    lost = ~np.isfinite(values)
    if lost.all():
        none = np.full(len(values) - 2, np.nan)
        return none, none, 1.0
    worst = np.min(values[~lost]) if outcome.better > 0 else np.max(values[~lost])
    known = np.where(lost, worst, values)
    return *sobol(known[0], known[1], known[2:]), float(np.mean(lost))


def with_indices(found: Sensitivity, spreads: Sequence[Spread], values: np.ndarray) -> Sensitivity:
    """The same with Sobol's indices of some parameters, from values of `index_values`."""
    own, total, lost = indices(found.outcome, values)
    estimated = {spread.path: (a, b) for spread, a, b in zip(spreads, own.tolist(), total.tolist(), strict=True)}
    rows = [
        replace(row, first=estimated[row.path][0], total=estimated[row.path][1]) if row.path in estimated else row
        for row in found.influences
    ]
    return replace(found, influences=tuple(rows), impossible=lost)


def sobol(first: np.ndarray, second: np.ndarray, mixed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Estimate Sobol's indices from function values at two independent samples and their mixtures.

    Parameters
    ----------
    first, second : (n,) float   Values at samples A and B.
    mixed : (k, n) float         Values at A with the column of one parameter taken from B.

    Returns
    -------
    first order, total : (k,) float   nan if the function is constant. [-]

    Source: sobol2001; estimators of saltelli2010, by SciPy.
    """
    from scipy.stats import sobol_indices

    if np.ptp(np.concatenate([first, second])) <= 1e-14 * np.max(np.abs(first)):
        return np.full(len(mixed), np.nan), np.full(len(mixed), np.nan)
    found = sobol_indices(func={"f_A": first[None], "f_B": second[None], "f_AB": mixed[:, None, :]}, n=len(first))
    return np.atleast_1d(np.squeeze(found.first_order)), np.atleast_1d(np.squeeze(found.total_order))


def _sentence(found: Sensitivity, row: Influence) -> str:
    from infinivar import units

    change = "raises" if row.elasticity > 0 else "lowers"
    varied = f"{units.show(row.low, row.unit)} to {units.show(row.high, row.unit)}"
    if not row.finite:
        span = f"{row.lost} at one end of {varied}"
    else:
        span = f"{plain(row.at_low)} to {units.show(row.at_high, found.outcome.unit)} over the range {varied}"
    share = "" if row.total is None or math.isnan(row.total) else f"; {100 * max(row.total, 0.0):.0f} % of the variance"
    outcome = "temperature rise" if found.outcome.name == "temperature" else found.outcome.name
    effect = f"+1 % {change} the {outcome} by {plain(abs(row.elasticity), 3)} %"
    return f"{row.words}: {effect}; {span}{share}"


def conclusions(outcome: Outcome, elasticities: Mapping[str, float], drive: AnyDrive) -> tuple[Conclusion, ...]:
    """Evaluate the paper's recommendations for an outcome of a cobotic drive; empty for other drives.

    Source: faulring2006, section VII.
    """
    if not isinstance(drive, CoboticDrive):
        return ()
    known, found = quantities_of(drive), []
    for direction in DIRECTIONS:
        if not any(path in known for path in direction.powers):
            continue
        slope = sum(power * elasticities.get(path, 0.0) for path, power in direction.powers.items())
        verdict = "no effect" if abs(slope) < 1e-6 else "helps" if slope * outcome.better > 0 else "hurts"
        found.append(Conclusion(direction.words, float(slope), verdict))
    return tuple(found)
