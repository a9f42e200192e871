"""Sweep over samples for Sobol's indices: those of `sensitivity`, in chunks and without end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from infinivar.analysis.robustness.sampling import Batch
from infinivar.analysis.robustness.sensitivity import (
    Sensitivity,
    index_values,
    modelled,
    ranked_spreads,
    sensitivity,
    with_indices,
)
from infinivar.errors import InputError, require
from infinivar.study.check import check_study
from infinivar.study.study import Study
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import CANDIDATES, Chunk, Problem
from infinivar.sweeps.sweep import Sweep, check_finished

SAMPLES = 2**16
SIZE = 2**11
_MOST = 2**30


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensitivitySweep(Problem):
    """Samples of Sobol's indices in chunks, by their number in one sequence.

    Attributes
    ----------
    nominal    The sensitivity without indices.
    samples    Number of base samples, a power of two; each is evaluated once more for every parameter, and twice.
    size       Base samples in a chunk, a power of two.
    """

    kind: ClassVar[str] = "sensitivity"
    nominal: Sensitivity
    samples: int = SAMPLES
    size: int = SIZE

    @property
    def title(self) -> str:
        """See `Problem`."""
        return f"{self.nominal.study.name}, {self.nominal.outcome.words} of {self.nominal.name}"

    @property
    def chunks(self) -> int:
        """See `Problem`."""
        return max(1, self.samples // self.size)

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`."""
        study, name = self.nominal.study, self.nominal.name
        return {
            "study": study.name,
            "drive": name,
            "values of the drive": fingerprint(study.drives[name]),
            "outcome": self.nominal.outcome.words,
            "requirement": fingerprint(study.requirement),
            "motions": fingerprint(study.duty),
            "spreads": fingerprint(ranked_spreads(self.nominal)),
            "samples": self.samples,
            "samples in a chunk": self.size,
        }

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        start, count = number * self.size, min(self.size, self.samples)
        requested, drive = self.nominal.outcome, modelled(self.nominal.study, self.nominal.name)
        spreads = ranked_spreads(self.nominal)
        batch = Batch(requested.of, drive, [spread.path for spread in spreads], engine="numpy")
        values = index_values(batch, spreads, count, start)
        rows = {"sample": np.arange(start, start + count), **dict(zip(self._columns, values, strict=True))}
        return Chunk(rows, {CANDIDATES: values.size})

    def result(self, sweep: Sweep) -> Sensitivity:
        """The sensitivity with indices of all samples.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        check_finished(sweep)
        values = np.stack([sweep.rows[name] for name in self._columns])
        return with_indices(self.nominal, ranked_spreads(self.nominal), values)

    @property
    def _columns(self) -> tuple[str, ...]:
        return "first", "second", *(f"mixed: {spread.path}" for spread in ranked_spreads(self.nominal))


def sensitivity_sweep(
    study: Study,
    drive: str,
    kind: str,
    *,
    speed: float | None = None,
    force: float | None = None,
    duty: str | None = None,
    samples: int = SAMPLES,
    size: int = SIZE,
    progress: Callable[[str, float], None] | None = None,
) -> SensitivitySweep:
    """Prepare Sobol's indices of an outcome as a sweep.

    Parameters
    ----------
    study, drive, kind, speed, force, duty   As for `sensitivity`, which ranks the parameters first.
    samples : int   Number of base samples, a power of two.
    size : int      Base samples in a chunk, a power of two.

    Raises
    ------
    InputError
        As `sensitivity` does, or if fewer than two parameters have an influence, or a number is no power of two.
    """
    check_study(study)
    for name, number in (("samples", samples), ("size", size)):
        whole = isinstance(number, int) and not isinstance(number, bool) and 16 <= number <= _MOST
        require(whole and number & (number - 1) == 0, name, number, f"a power of two from 16 to {_MOST}")
    nominal = sensitivity(study, drive, kind, speed=speed, force=force, duty=duty, samples=0, progress=progress)
    if len(ranked_spreads(nominal)) < 2:
        raise InputError(f"drives.{drive}: {nominal.outcome.words}: fewer than two parameters have an influence")
    return SensitivitySweep(nominal=nominal, samples=samples, size=size)
