"""Outcome of a comparison of a measured set with a law: evidence, residuals, and parts with their fits."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from infinivar._core.described import reported
from infinivar._core.result import Frozen, result
from infinivar.calibration.bench import LeftOut
from infinivar.calibration.fit import Fit
from infinivar.calibration.measured.law import MeasuredRows

_AT_BOUND = 1e-3
"""Distance from a bound, in sizes of the parameter, that counts as none."""


@result
class Evidence(Frozen):
    """One form of a law, fitted to the same rows as the others."""

    form: str = reported()
    parameters: int = reported()
    rms: tuple[float, ...] = reported()
    bic: float = reported()


@result
class Residual(Frozen):
    """Residuals of one signal.

    Attributes
    ----------
    signal, unit : reading, and its SI unit.
    rows : number of rows.
    rms, worst, mean : of the residuals of all rows, and mean size of the readings. [SI]
    rms_used : rms of the rows that fit. [SI]
    goal : largest rms that is hoped for; nan without one. [SI]
    by_range : rms and worst residual in the lower, middle and upper third of the range shown.
    left_out_rms, left_out_worst : of rows predicted by fits to the others; nan if there are too few.
    coverage : share of these rows in their 95 % prediction interval.
    reason : why a goal is missed.
    """

    signal: str = reported()
    unit: str = reported()
    rows: int = reported()
    rms: float = reported()
    rms_used: float = reported()
    worst: float = reported()
    mean: float = reported()
    goal: float = reported()
    by_range: Mapping[str, tuple[float, float]] = reported()
    left_out_rms: float = reported()
    left_out_worst: float = reported()
    coverage: float = reported()
    reason: str = reported()

    @property
    def met(self) -> bool | None:
        """Whether the goal is met by the rows fitted; None without a goal."""
        return None if math.isnan(self.goal) else self.rms <= self.goal


@result
class Predicted(Frozen):
    """Rows of another file, predicted by the fit."""

    signal: str = reported()
    unit: str = reported()
    rows: int = reported()
    rms: float = reported()
    worst: float = reported()
    coverage: float = reported()


@result
class Part(Frozen):
    """A part of a measured set with parameters of its own.

    Attributes
    ----------
    name : word of the part; "" if the set is one part.
    rows : rows used, under the chosen form.
    fit : fit of the chosen form.
    evidence : forms compared, the simplest first.
    left_out : rows that do not fit, with the reason.
    misread : faults of whole columns and drifts.
    expected : readings expected of the rows. (n, m)
    predicted : readings expected of each row by fits without its group; nan where none. (n, m)
    half : half-widths of their 95 % intervals. (n, m)
    residuals : by signal.
    others : rows of another file, predicted.
    """

    name: str = reported(key="part")
    rows: MeasuredRows
    fit: Fit = reported(key="*")
    evidence: tuple[Evidence, ...] = reported()
    left_out: tuple[LeftOut, ...] = reported(key="left_out_lines")
    misread: tuple[str, ...] = reported()
    expected: np.ndarray
    predicted: np.ndarray
    half: np.ndarray
    residuals: tuple[Residual, ...] = reported()
    others: tuple[Predicted, ...] = reported(default=())

    @property
    def form(self) -> str:
        """The form that the evidence chooses."""
        return self.rows.form

    @property
    def at_bounds(self) -> tuple[str, ...]:
        """Parameters at the least or the largest value that the fit may try."""
        return at_bounds(self.fit)


def at_bounds(found: Fit) -> tuple[str, ...]:
    """Parameters at the least or the largest value that a fit may try."""
    low, high = found.problem.bounds
    room = np.minimum(found.unknowns - low, high - found.unknowns)
    return tuple(name for name, left in zip(found.names, room, strict=False) if left < _AT_BOUND)
