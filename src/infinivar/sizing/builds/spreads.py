"""Spreads of a design's values, those of the study or assumed, and samples that designs with the same part share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.bounds import permitted
from infinivar._core.described import dictionary
from infinivar._core.fields import quantities_of, value_at
from infinivar.analysis.robustness.sampling import correlated, low_discrepancy
from infinivar.drivetrain.drive import Drive
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.sizing.design import SizedDrive
from infinivar.study.spreads import Spread, Uncertainty
from infinivar.units import plain

TORQUE_CONSTANT, RESISTANCE, GEAR_LOSS, FRICTION = 0.05, 0.10, 0.20, 0.15
"""Tolerances to either side, relative to the value, that are assumed where a study states none: torque constant and resistance of
motors, gear loss ``1 - efficiency``, and friction coefficient of the rolling contact. [-]"""

_ASSUMED = "assumed, as the study states no spread"
_WORDS = {
    "torque_constant": f"torque constant ± {plain(100.0 * TORQUE_CONSTANT)} %",
    "resistance": f"winding resistance ± {plain(100.0 * RESISTANCE)} %",
    "efficiency": f"gear loss ± {plain(100.0 * GEAR_LOSS)} %",
    "friction": f"friction coefficient of the contact ± {plain(100.0 * FRICTION)} %",
}


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
        """Whether the program assumes the spread, as the study states none."""
        return self.spread.where == _ASSUMED

    @property
    def words(self) -> str:
        """Value and range; of an assumed spread the rule, which is the same for all parts."""
        path = self.spread.path
        if self.assumed:
            return _WORDS[path.rpartition(".")[2]]
        return f"{path.replace('.', ' ').replace('_', ' ')} of {self.owner}: {self.spread.words}"


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
    found += [spread for spread in _assumed(design.template, drive) if spread.path not in stated]
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


def _assumed(template: str, drive: Drive) -> Iterator[Spread]:
    """Spreads of motors, gearheads and the rolling contact where none is stated."""
    for path, field in quantities_of(drive).items():
        owner, _, name = path.rpartition(".")
        part = value_at(drive, owner) if owner else drive
        value = getattr(part, name)
        tolerance = None
        if isinstance(part, Motor):
            tolerance = {"torque_constant": TORQUE_CONSTANT, "resistance": RESISTANCE}.get(name)
        elif isinstance(part, Gearhead) and name == "efficiency":
            tolerance = GEAR_LOSS * (1.0 - value) / value
        elif path == "transmission.friction":
            tolerance = FRICTION
        if tolerance is not None:
            ends = permitted(field.metadata["bound"], value)
            yield Spread(
                owner=template,
                path=path,
                unit=field.metadata["unit"],
                value=value,
                low=max(value * (1.0 - tolerance), ends[0]),
                high=min(value * (1.0 + tolerance), ends[1]),
                deviation=None,
                kind="assumed",
                where=_ASSUMED,
            )


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
