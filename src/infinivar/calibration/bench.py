"""What is measured on a bench: rows of readings, what a drive would give in their place, and the parameters that they show."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, NoReturn, Self

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.result import Frozen
from infinivar.errors import InputError
from infinivar.study.rig import Rig

FEW = 1.0 / 3.0
"""Largest share of rows that may be impossible or outliers; at one half, no fit could tell which half is right."""

_MOST = 12
"""Largest number of faults listed in one message."""


class Parameter(NamedTuple):
    """A parameter that can be fitted."""

    unit: str
    shown_in: str
    meaning: str
    divides: bool = False
    """Whether the model divides by it, so that a fit keeps it well above zero."""
    most: float = math.inf
    """Value that a fit stays below. [SI]"""
    least: float = 0.0
    """Value that a fit stays above. [SI]"""


class Error(NamedTuple):
    """An error of a sensor or a setting that all rows, or many, have in common."""

    deviation: float
    """Standard deviation. [SI]"""
    most: float = math.inf
    """Size at which the model is no longer valid. [SI]"""


class LeftOut(NamedTuple):
    """A row excluded from the fit."""

    row: int
    """Row of the data."""
    line: int
    """Line of the file."""
    reason: str

    def to_dict(self) -> dict[str, Any]:
        """Line and reason, for scripts."""
        return {"line": self.line, "reason": self.reason}


class Bench(Frozen, ABC):
    """Readings of a drive on a bench, and the model of that bench.

    Attributes
    ----------
    signals : names of the readings.
    read : (n, m) readings.
    lines : line of each row in the file.
    name : name of the file.
    empty : rows left out, as a cell is empty: what is said of each, by its line.
    """

    __slots__ = ()

    kind: ClassVar[str]
    """Word for this kind of data."""
    row: ClassVar[str] = "row"
    """Word for one row."""
    many: ClassVar[str]
    """Why data are refused of which {count} of {whole} rows are impossible."""
    parameters: ClassVar[Mapping[str, Parameter]]
    """What can be fitted, by name."""
    units: ClassVar[Mapping[str, str]]
    """Units of the readings, by signal."""
    uncertain: ClassVar[tuple[str, ...]] = ()
    """Signals whose expected readings depend on a law that may be bent."""
    shared_errors: ClassVar[bool] = False
    """Whether an error of one sensor is in the expected readings of several signals."""
    alike: ClassVar[bool] = False
    """Whether the sensors of all signals are alike, so that what the model leaves of each has one weight."""

    signals: tuple[str, ...]
    read: np.ndarray
    lines: tuple[int, ...]
    name: str
    empty: Mapping[int, str]

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.lines)

    def chosen(self, rows: Any) -> Self:
        """Select rows by index or mask."""
        arrays: dict[str, Any] = {one.name: getattr(self, one.name) for one in dataclasses.fields(self)}  # type: ignore[arg-type]
        picked = {name: value[rows] for name, value in arrays.items() if isinstance(value, np.ndarray)}
        return dataclasses.replace(self, **picked, lines=tuple(np.asarray(self.lines)[rows].tolist()))  # type: ignore[type-var]

    @property
    def abscissa(self) -> tuple[np.ndarray, str]:
        """What a figure shows the rows over, (n,), and its label."""
        return np.asarray(self.lines), "line of the data file"

    @property
    @abstractmethod
    def usual(self) -> tuple[str, ...]:
        """Parameters fitted by default."""

    @abstractmethod
    def refusal(self, name: str) -> str | None:
        """Why a parameter cannot be fitted to these readings, or None."""

    @abstractmethod
    def known(self, drive: Any) -> dict[str, float]:
        """The parameters as the study has them. [SI]"""

    @abstractmethod
    def scales(self, drive: Any) -> dict[str, float]:
        """The same, or a size that matters where they are zero. [SI]"""

    @abstractmethod
    def errors(self, rig: Rig) -> dict[str, Error]:
        """Errors that rows have in common, by name."""

    @abstractmethod
    def expected(self, drive: Any, rig: Rig, values: Mapping[str, Any], errors: Mapping[str, Array]) -> np.ndarray:
        """Readings of a drive with these values of all parameters and these errors; nan where it would slip.

        Parameters
        ----------
        values, errors : mapping   Each of a shape that broadcasts with (..., n); an error that is missing is zero. [SI]

        Returns
        -------
        (..., n, m) float
        """

    def whitening(self, drive: Any, rig: Rig) -> np.ndarray | None:
        """Matrices (n, m, m) that turn the errors of a row into independent unit errors, from the accuracy that the rig states.

        None where it states none, and the noise follows from the residuals.
        """
        return None


def refuse(data: Bench, faults: Mapping[int, str], closing: str = "") -> NoReturn:
    """Raise InputError with one line per fault, given by index of the row, and a closing line."""
    said = [f"{data.name}: line {data.lines[row]}: {faults[row]}" for row in sorted(faults)[:_MOST]]
    more = len(faults) - _MOST
    raise InputError("\n".join([*said, *([f"and {more} more"] if more > 0 else []), *([closing] if closing else [])]))


def refuse_unless_few(data: Bench, faults: Mapping[int, str]) -> None:
    """Raise InputError if more than a third of the rows are impossible."""
    if len(faults) > FEW * len(data):
        refuse(data, faults, data.many.format(name=data.name, count=len(faults), whole=len(data)))
