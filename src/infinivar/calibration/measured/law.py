"""Rows of a measured set as a bench of the calibration: what is known, what is read, and the law that connects them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.result import result
from infinivar.calibration.bench import Bench, Error, Parameter
from infinivar.study.rig import Rig


class Term(NamedTuple):
    """A parameter of a law, with its value before the fit."""

    parameter: Parameter
    start: float
    """First guess, known to 100 %. [SI]"""
    neutral: float = 0.0
    """Value in forms of the law without it. [SI]"""
    size: float = 0.0
    """Size that matters, where the first guess is zero. [SI]"""


class Form(NamedTuple):
    """One form of a law: the parameters in it, and the name of the creep law where it has one."""

    names: tuple[str, ...]
    creep_law: str = ""


class At(NamedTuple):
    """What a law is evaluated for."""

    known: Mapping[str, np.ndarray]
    """Known columns (n,). [SI]"""
    settings: Mapping[str, float]
    """Known numbers of the set. [SI]"""
    form: Form
    run: np.ndarray
    """Index of the run of each row. (n,)"""
    history: Mapping[int, Mapping[str, np.ndarray]]
    """All rows of each run, for laws that follow a run in time."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Law:
    """What one kind of measurement knows and reads, and the forms of its law, the simplest first.

    Attributes
    ----------
    name, title : word in files, and a line for people.
    known, read, settings : SI units of known columns, of readings, and of known numbers.
    terms : parameters by name.
    forms : forms of the law by name.
    expected : readings by name, each (..., n), of values, each broadcasting with (..., n), and of the errors that a run has.
    common : standard deviations of errors that each run has for itself, such as the time offset of a logger. [SI]
    from_second : whether the first run has none of these errors, as the others are relative to it.
    over : column over which residuals are shown.
    evolves : whether the law follows a run in time, from its first rows on.
    alike : whether the sensors of all readings are alike.
    ranges : least and largest value that a known column can have. [SI]
    """

    name: str
    title: str
    known: Mapping[str, str]
    read: Mapping[str, str]
    settings: Mapping[str, str]
    terms: Mapping[str, Term]
    forms: Mapping[str, Form]
    expected: Callable[[At, Mapping[str, Any], Mapping[str, Array]], Mapping[str, Array]]
    over: str
    common: Mapping[str, float] = dataclasses.field(default_factory=dict)
    from_second: bool = False
    evolves: bool = False
    alike: bool = False
    ranges: Mapping[str, tuple[float, float]] = dataclasses.field(default_factory=dict)


@result
class MeasuredRows(Bench):
    """Rows of a measured set under one form of a law.

    Attributes
    ----------
    law, form : the law, and the name of its form.
    columns : (n, k) known columns, in the order of the law. [SI]
    run : (n,) index of the run of each row.
    settings, starts : known numbers, and first guesses that replace those of the law. [SI]
    factors : SI over the unit of the file, by column.
    history : all rows of each run, where the law follows a run in time.
    read, signals, lines, name, empty : see `Bench`.
    """

    law: Law
    form: str
    columns: np.ndarray
    run: np.ndarray
    settings: Mapping[str, float]
    starts: Mapping[str, float]
    read: np.ndarray
    signals: tuple[str, ...]
    lines: tuple[int, ...]
    name: str
    empty: Mapping[int, str] = dataclasses.field(default_factory=dict)
    factors: Mapping[str, float] = dataclasses.field(default_factory=dict)
    history: Mapping[int, Mapping[str, np.ndarray]] = dataclasses.field(default_factory=dict)

    kind = "measured set"
    many = "{name}: {count} of {whole} rows are impossible: check units and columns"

    @property
    def parameters(self) -> Mapping[str, Parameter]:  # type: ignore[override]
        """What the law can fit, by name."""
        return {name: term.parameter for name, term in self.law.terms.items()}

    @property
    def units(self) -> Mapping[str, str]:  # type: ignore[override]
        """Units of the readings, by signal."""
        return self.law.read

    @property
    def alike(self) -> bool:  # type: ignore[override]
        """Whether the sensors of all readings are alike."""
        return self.law.alike

    @property
    def known_columns(self) -> dict[str, np.ndarray]:
        """Known columns by name. [SI]"""
        return {name: self.columns[:, place] for place, name in enumerate(self.law.known)}

    @property
    def abscissa(self) -> tuple[np.ndarray, str]:
        """What a figure shows the rows over, (n,), and its label."""
        over = self.law.over
        return self.known_columns[over], f"{over.replace('_', ' ')} [{self.law.known[over]}]"

    @property
    def usual(self) -> tuple[str, ...]:
        """Parameters of the form."""
        return self.law.forms[self.form].names

    def refusal(self, name: str) -> str | None:
        """None: every parameter of the form can be fitted."""
        return None if name in self.usual else f"{name} is not in the form {self.form}"

    def known(self, drive: Any = None) -> dict[str, float]:
        """First guesses of the form's parameters, and neutral values of the others. [SI]"""
        return {
            name: self.starts.get(name, term.start) if name in self.usual else term.neutral
            for name, term in self.law.terms.items()
        }

    def scales(self, drive: Any = None) -> dict[str, float]:
        """Sizes of the parameters. [SI]"""
        return {
            name: abs(self.starts.get(name, term.start)) or term.size or 1.0 for name, term in self.law.terms.items()
        }

    def errors(self, rig: Rig | None = None) -> dict[str, Error]:
        """Errors that a run has for itself."""
        runs = [run for run in np.unique(self.run).tolist() if run >= int(self.law.from_second)]
        return {f"{name}:{run}": Error(size) for name, size in self.law.common.items() for run in runs}

    def expected(
        self, drive: Any, rig: Rig | None, values: Mapping[str, Any], errors: Mapping[str, Array]
    ) -> np.ndarray:
        """Expected readings. (..., n, m)"""
        at = At(self.known_columns, self.settings, self.law.forms[self.form], self.run, self.history)
        common = {name: self._of_rows(name, errors) for name in self.law.common}
        found = self.law.expected(at, values, common)
        return np.stack(np.broadcast_arrays(*(found[name] for name in self.signals)), axis=-1)

    def _of_rows(self, name: str, errors: Mapping[str, Array]) -> Array:
        """An error of runs, by row. (..., n)"""
        found: Array = np.zeros(len(self.run))
        for run in np.unique(self.run).tolist():
            found = found + np.where(self.run == run, errors.get(f"{name}:{run}", 0.0), 0.0)
        return found
