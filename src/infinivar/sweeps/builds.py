"""Sweep over samples of a drive within its tolerances: what `compare` draws, in chunks and without end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar.analysis.cycles.performance import AnyDrive
from infinivar.analysis.plane import of_drives
from infinivar.analysis.robustness.sampling import draw
from infinivar.analysis.robustness.verdicts import Builds, Mapper, duty_builds, judge, map_axes
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import type_words
from infinivar.errors import InputError, require
from infinivar.study.check import check_duty, check_spreads, check_study
from infinivar.study.spreads import Spread
from infinivar.study.study import Study
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import CANDIDATES, Chunk, Problem
from infinivar.sweeps.sweep import Sweep, check_finished

DRAWS = 2**16
SIZE = 2**12
_MOST = 2**30
"""Points of a Sobol sequence with 30 bits."""
_VALUES = ("energy_J", "temperature_K", "able")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples(Problem):
    """Samples of a drive in chunks, by their number in one sequence: the samples are those of `compare` with as many draws.

    Attributes
    ----------
    study      With spreads of the drive, and what samples are judged by.
    drive      Name of the drive.
    draws      Number of samples, a power of two.
    size       Samples in a chunk, a power of two.
    """

    study: Study
    drive: str
    draws: int = DRAWS
    size: int = SIZE

    @property
    def chunks(self) -> int:
        """See `Problem`."""
        return max(1, self.draws // self.size)

    @property
    def spreads(self) -> tuple[Spread, ...]:
        """Spreads of the fields that vary."""
        return self.study.uncertainty.spreads[self.drive]

    @property
    def drawn(self) -> dict[str, Any]:
        """What identifies the samples."""
        return {
            "study": self.study.name,
            "drive": self.drive,
            "spreads": fingerprint(self.spreads, self.study.uncertainty.correlation(self.drive)),
            "draws": self.draws,
            "draws in a chunk": self.size,
        }

    def samples(self, number: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Values of a chunk, one row per sample, and the columns that have them. (n, k)"""
        start, count = number * self.size, min(self.size, self.draws)
        at = draw(self.spreads, self.study.uncertainty.correlation(self.drive), count, start=start)
        values = {f"value: {spread.path}": at[:, place] for place, spread in enumerate(self.spreads)}
        return at, {"draw": np.arange(start, start + count), **values}

    def values(self, sweep: Sweep) -> np.ndarray:
        """Values of all samples of a sweep, one row each. (n, k)"""
        return np.stack([sweep.rows[f"value: {spread.path}"] for spread in self.spreads], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BuildsSweep(Samples):
    """Samples that are judged by the requirement and the duty cycles of their study; see `Samples`."""

    kind: ClassVar[str] = "builds"

    @property
    def title(self) -> str:
        """See `Problem`."""
        return f"{self.study.name}, builds of {self.drive}"

    @property
    def identity(self) -> Mapping[str, Any]:
        """See `Problem`."""
        return {
            **self.drawn,
            "values of the drives": fingerprint(self.study.drives),
            "requirement": fingerprint(self.study.requirement),
            "motions": fingerprint(self.study.duty),
        }

    def run(self, number: int) -> Chunk:
        """See `Problem`."""
        at, rows = self.samples(number)
        found = judge(self._sampled, self.spreads, at, self.study.requirement, self.study.duty)
        if self.study.requirement is not None:
            rows |= {"coverage": found.region[:, 0], "margin": found.region[:, 1], "loss_W": found.loss}
        for task, values in found.duty.items():
            rows |= {f"{task}: {name}": values[:, place] for place, name in enumerate(_VALUES)}
        return Chunk(rows, {CANDIDATES: len(at), "map": self._mapper.counts(at)})

    def best(self, chunk: Chunk) -> tuple[float, str] | None:
        """See `Problem`: the weakest sample."""
        if "margin" not in chunk.rows:
            return None
        least = float(np.nanmin(chunk.rows["margin"]))
        return least, f"tightest margin so far: {least:.3g}"

    def result(self, sweep: Sweep) -> Builds:
        """The samples as `compare` returns them; sums over the map differ from its by rounding.

        Raises
        ------
        InputError
            If the sweep is not finished.
        """
        check_finished(sweep)
        rows, empty = sweep.rows, np.empty(0)
        cycles = {task: np.stack([rows[f"{task}: {name}"] for name in _VALUES], axis=-1) for task in self.study.duty}
        return Builds(
            spreads=self.spreads,
            values=self.values(sweep),
            coverage=rows.get("coverage", empty),
            margin=rows.get("margin", empty),
            loss=rows.get("loss_W", empty),
            map=self._mapper.statistics(sweep.counts["map"], sweep.candidates),
            duty=FrozenDict({task: duty_builds(found, self.study.duty[task]) for task, found in cycles.items()}),
        )

    @property
    def _sampled(self) -> AnyDrive:
        found = self.study.drives[self.drive]
        assert isinstance(found, (CoboticDrive, ConventionalDrive))
        return found

    @property
    def _mapper(self) -> Mapper:
        axes = of_drives(self.study).axes()
        return Mapper(self._sampled, [spread.path for spread in self.spreads], *map_axes(axes))


def builds_sweep(study: Study, drive: str | None = None, *, draws: int = DRAWS, size: int = SIZE) -> BuildsSweep:
    """Prepare samples of a drive within its tolerances as a sweep.

    Parameters
    ----------
    study : Study
    drive : str   Name of a drive with spreads; the first by default.
    draws : int   Number of samples, a power of two.
    size : int    Samples in a chunk, a power of two.

    Raises
    ------
    InputError
        If the drive does not exist or has no spreads, a number is no power of two, or the drives cannot be judged.
    """
    name = sampled(study, drive, draws, size)
    check_duty(study)
    check_spreads(study)
    return BuildsSweep(study=study, drive=name, draws=draws, size=size)


def sampled(study: Study, drive: str | None, draws: int, size: int) -> str:
    """Name of the drive of which samples are drawn; arguments and errors as for `builds_sweep`."""
    check_study(study)
    spread = [name for name in study.drives if study.uncertainty.spreads.get(name)]
    if drive is None and not spread:
        raise InputError("the study states no spreads: add a table [uncertainty.NAME] for one of its drives")
    name = spread[0] if drive is None else drive
    found = study.drive(name)
    if name not in spread:
        raise InputError(f"drives.{name} has no spreads: add a table [uncertainty.{name}] to the study")
    if not isinstance(found, (CoboticDrive, ConventionalDrive)):
        raise InputError(
            f"drives.{name} cannot be sampled: it is of type {type_words(found)}, and only cobotic and conventional drives can"
        )
    for what, number in (("draws", draws), ("size", size)):
        whole = isinstance(number, int) and not isinstance(number, bool) and 16 <= number <= _MOST
        require(whole and number & (number - 1) == 0, what, number, f"a power of two from 16 to {_MOST}")
    return name
