"""Spreads of a design's values, those of the study or default ones, and samples that designs with the same part share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.bounds import permitted
from infinivar._core.described import dictionary
from infinivar._core.fields import quantities_of, value_at
from infinivar.analysis.robustness.sampling import correlated, low_discrepancy
from infinivar.drivetrain.drive import Drive
from infinivar.sizing.design import SizedDrive
from infinivar.study.default_spreads import default_spreads, rule_of
from infinivar.study.spreads import Spread, Uncertainty


class Varied(NamedTuple):
    """A value of a design that differs from build to build."""

    owner: str
    """Part to which it belongs, such as "motor maxon:4711"; or the template, of a value that all its designs share."""
    spread: Spread

    def to_dict(self) -> dict[str, Any]:
        """The spread as plain numbers and texts, with its owner."""
        return {"owner": self.owner, **dictionary(self.spread)}

    @property
    def assumed(self) -> bool:
        """Whether the spread is a default, as the study states none."""
        return rule_of(self.spread) is not None

    @property
    def words(self) -> str:
        """Value and range; of a default spread the rule, which is the same for all parts."""
        rule = rule_of(self.spread)
        if rule is not None:
            return rule.words
        return f"{self.spread.path.replace('.', ' ').replace('_', ' ')} of {self.owner}: {self.spread.words}"


class Draws(NamedTuple):
    """Samples common to several designs."""

    varied: Mapping[tuple[str, str], Varied]
    """Every value that varies, once, by owner and path in the drive."""
    values: Sequence[Mapping[str, np.ndarray]]
    """Of each design, samples by path. (n,)"""


def varied_of(design: SizedDrive, uncertainty: Uncertainty) -> tuple[Varied, ...]:
    """Values of a design that vary: those shared by all designs of a template first, then those of its parts."""
    drive = design.drive
    stated = {spread.path: spread for spread in uncertainty.spreads.get(design.template, ())}
    found = [made for spread in stated.values() if (made := _carried(spread, drive)) is not None]
    found += [spread for spread in default_spreads(design.template, drive) if spread.path not in stated]
    made = [Varied(_owner(design, spread.path), spread) for spread in found if spread.low < spread.high]
    return tuple(sorted(made, key=lambda one: one.owner != design.template))


def draw(designs: Sequence[SizedDrive], uncertainty: Uncertainty, count: int, seed: int = 0) -> Draws:
    """Draw samples of all values that vary; a value of one owner has the same samples in every design.

    Parameters
    ----------
    count : int   Number of samples, a power of two.
    seed : int    Seed of the scrambling.

    Returns
    -------
    Draws   Quasi-Monte Carlo with a Sobol sequence: reproducible. Correlations stated for the template apply in each design.

    Source: sobol1967, by `infinivar.analysis.robustness.sampling`.
    """
    each = [varied_of(design, uncertainty) for design in designs]
    every: dict[tuple[str, str], Varied] = {}
    for rows in each:
        for one in rows:
            every.setdefault((one.owner, one.spread.path), one)
    places = {key: place for place, key in enumerate(every)}
    shares = low_discrepancy(count, len(every), seed) if every else np.empty((count, 0))
    values = []
    for design, rows in zip(designs, each, strict=True):
        columns = shares[:, [places[one.owner, one.spread.path] for one in rows]]
        columns = correlated(columns, _correlation(uncertainty, design.template, rows))
        values.append({one.spread.path: one.spread.at(columns[:, place]) for place, one in enumerate(rows)})
    return Draws(every, values)


def _carried(spread: Spread, drive: Drive) -> Spread | None:
    """A spread of the template for the value that a design has instead: relative to it, of an efficiency relative to the loss.

    None if the design does not state the value.
    """
    fields = quantities_of(drive)
    if spread.path not in fields:
        return None
    value, ends = value_at(drive, spread.path), permitted(fields[spread.path].metadata["bound"], spread.value)
    if value == spread.value:
        return spread
    factor = value / spread.value if spread.value else 1.0
    if spread.path.endswith("efficiency") and spread.value < 1.0:
        factor = (1.0 - value) / (1.0 - spread.value)
    low, high = (value + factor * (end - spread.value) for end in (spread.low, spread.high))
    if spread.deviation is not None:
        low, high = ends
    return replace(
        spread,
        value=value,
        low=max(low, ends[0]),
        high=min(high, ends[1]),
        deviation=None if spread.deviation is None else abs(factor) * spread.deviation,
    )


def _owner(design: SizedDrive, path: str) -> str:
    """Part of the design to which a path leads, with its role: two motors of one type are two motors."""
    roles = [role for role in design.parts if path.startswith(f"{role.replace(' ', '.')}.")]
    role = max(roles, key=len, default=None)
    return design.template if role is None else f"{role.replace('.', ' ')} {design.parts[role].part}"


def _correlation(uncertainty: Uncertainty, template: str, rows: Sequence[Varied]) -> np.ndarray:
    """Correlation matrix of the values of a design that vary. (k, k)"""
    paths = [one.spread.path for one in rows]
    matrix: Any = np.eye(len(paths))
    for (owner, one, other), value in uncertainty.correlations.items():
        if owner == template and one in paths and other in paths:
            i, j = paths.index(one), paths.index(other)
            matrix[i, j] = matrix[j, i] = value
    return matrix
