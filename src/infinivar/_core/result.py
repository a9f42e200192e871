"""What all results have in common: they are frozen for good, compare without surprises and show themselves in a few lines."""

from __future__ import annotations

import dataclasses
import functools
import html
import math
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, dataclass_transform

import numpy as np

from infinivar._core import described, extras, netcdf, presentation
from infinivar._core.frozen import frozen, rebuilt
from infinivar.errors import InfinivarError, ParameterError

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from matplotlib.figure import Figure

_LINES, _WIDTH = 8, 100
"""Of what `repr` shows below the first line."""

_RESIDUALS = ("audit_residual", "residual")
"""Fields that hold rounding errors, whose relative difference says nothing."""

_DPI = 80
"""Of the small figure in a notebook."""

C = TypeVar("C", bound=type)


@dataclass_transform(
    kw_only_default=True,
    frozen_default=True,
    eq_default=False,
    field_specifiers=(dataclasses.field, described.reported),
)
def result(cls: C) -> C:
    """Make a class a frozen dataclass with slots whose equality and `repr` are those of `Frozen`."""
    return dataclasses.dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)(cls)


class Frozen:
    """A value made of fields: NumPy arrays are copied and locked, dictionaries frozen.

    Two are equal (`==`) if they are of one type and their fields hold the same numbers; nan equals nan. The answer is
    always a bool. As they may hold arrays, they have no hash.
    """

    __slots__ = ("__dict__",)  # for what is computed of it once, by `functools.cached_property`

    def __post_init__(self) -> None:
        """Copy and lock what could be changed."""
        for name in self.__slots__:  # the fields: bases have none
            value = getattr(self, name)
            kept = frozen(value)
            if kept is not value:
                object.__setattr__(self, name, kept)

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Copies and pickles are locked again: NumPy does not keep the lock."""
        return rebuilt, (type(self), {name: getattr(self, name) for name in _names(type(self))})

    def equals(self, other: object, rtol: float = 0.0, atol: float = 0.0) -> bool:
        """Whether another is of the same type and holds the same numbers, within tolerances.

        Parameters
        ----------
        other : object
        rtol, atol : float   Largest difference of two numbers: ``atol + rtol * abs(number)``, >= 0. nan equals nan. [-]
            With a tolerance, residuals of the energy audit are not compared: they are rounding errors.

        Raises
        ------
        ParameterError
            If a tolerance is negative or nan.
        """
        for name, value in (("rtol", rtol), ("atol", atol)):
            if not value >= 0.0:
                raise ParameterError(f"{name} must be >= 0, got {value}")
        return _same(self, other, rtol, atol)

    def __eq__(self, other: object) -> bool:
        """Whether `equals` without tolerance."""
        return _same(self, other, 0.0, 0.0)

    def to_dict(self) -> dict[str, Any]:
        """What the result states, as plain numbers and texts: for scripts and JSON.

        Raises
        ------
        TypeError
            If results of this type state nothing for a dictionary.
        """
        made = described.dictionary(self)
        if not made:
            raise TypeError(f"there is no dictionary of {type(self).__name__}")
        return made

    def __repr__(self) -> str:
        """Type and main contents in at most ten lines."""
        rows = list(self._rows())
        lines = [f"  {name}: {value}" if name else f"  {value}" for name, value in rows[:_LINES]]
        more = [f"  ... and {len(rows) - _LINES} more"] if len(rows) > _LINES else []
        return "\n".join([type(self).__name__, *map(_cut, lines), *more])

    def _repr_html_(self) -> str:
        """What a notebook shows: the answer first where the type has one, else a table of the same."""
        shown = presentation.presenter(type(self), "notebook")
        if shown is not None:
            return shown(self)
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name)}</th><td style='text-align:left'>{html.escape(value)}</td></tr>"
            for name, value in self._rows()
        )
        return f"<p><b>{type(self).__name__}</b></p><table>{rows}</table>"

    def _rows(self) -> Iterator[tuple[str, str]]:
        """Names and contents, the verdict first; of what has verdicts itself, each of them."""
        if isinstance(getattr(type(self), "verdict", None), property):
            yield "verdict", str(self.verdict)  # type: ignore[attr-defined]
        for name in (field.name for field in dataclasses.fields(type(self)) if field.repr):  # type: ignore[arg-type]
            value = getattr(self, name)
            if isinstance(value, Mapping) and value and all(hasattr(item, "verdict") for item in value.values()):
                yield from ((str(key), item.verdict) for key, item in value.items())
            elif value is not None and not (isinstance(value, str | tuple | Mapping) and not value):
                yield name.replace("_", " "), short(value)


class Result(Frozen):
    """What a calculation returns: a `Frozen` value with a figure, labelled arrays and a table."""

    __slots__ = ()

    def plot(self, **options: Any) -> Figure:
        """Draw the result; `Figure.savefig` writes it to a file.

        Raises
        ------
        TypeError
            If there is no figure of this type.
        """
        return self._presenter("plot")(self, **options)

    def to_xarray(self) -> xarray.Dataset:
        """The numbers as labelled arrays, with units; needs the extra ``xarray``.

        Raises
        ------
        TypeError
            If results of this type are not labelled.
        """
        xarray = extras.load("xarray", "xarray", "a labelled data set")
        made = self._arrays()
        if made is not None:
            return xarray.Dataset(*made)
        stated = described.table(self) is not None
        return xarray.Dataset.from_dataframe(self.to_dataframe() if stated else self._presenter("table")(self))

    def to_netcdf(self, path: str | Path) -> None:
        """Write the labelled arrays as NetCDF (version 3); xarray is not needed.

        Raises
        ------
        TypeError
            If results of this type are not labelled arrays.
        """
        made = self._arrays()
        if made is None:
            raise TypeError(f"there is no data set of {type(self).__name__}: its fields state no dimensions")
        netcdf.write(path, made)

    def to_dataframe(self) -> pd.DataFrame:
        """The numbers as a table; needs the extra ``xarray``, which brings pandas.

        Raises
        ------
        TypeError
            If there is no table of this type.
        """
        found = presentation.presenter(type(self), "table")
        if found is not None:
            return found(self)
        if (stated := described.table(self)) is not None:
            rows, index = stated
            made = extras.load("pandas", "xarray", "a table").DataFrame(rows)
            return made.set_index(index) if index and rows else made
        labelled = self.to_xarray()
        return (labelled if labelled.sizes else labelled.expand_dims("point")).to_dataframe()

    def _repr_html_(self) -> str:
        """The table, and a small figure if there is one."""
        table = super()._repr_html_()
        try:
            made = self.plot()
        except (TypeError, InfinivarError):  # a figure is a bonus: not every result can be drawn
            return table
        return table + _inline(made)

    def _arrays(self) -> netcdf.Arrays | None:
        """Labelled arrays: those of a registered function, else what fields and properties state; None if they state none."""
        found = presentation.presenter(type(self), "dataset")
        if found is not None:
            return found(self)
        return described.arrays(self) if described.is_labelled(type(self)) else None

    def _presenter(self, kind: presentation.Kind) -> Callable[..., Any]:
        found = presentation.presenter(type(self), kind)
        if found is None:
            named = {"plot": "figure", "save": "report"}
            words = named.get(kind, kind)
            raise TypeError(
                f"there is no {words} of {type(self).__name__}, only of {', '.join(presentation.presented(kind))}"
            )
        return found


def short(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, bool | int | str):
        return str(value)
    if isinstance(value, float | np.number):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(" ".join(map(_word, key)) if isinstance(key, tuple) else _word(key) for key in value)
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        kinds = {type(item).__name__ for item in value}
        few = len(value) <= 3 or kinds <= {"str", "Limit"}
        return (
            ", ".join(map(short, value)) if few and "Spread" not in kinds else f"{len(value)} {'/'.join(sorted(kinds))}"
        )
    name = getattr(value, "title", "") or getattr(value, "name", "")
    return f"{type(value).__name__} {name}" if isinstance(name, str) and name else type(value).__name__


def _word(value: Any) -> str:
    return value.name if isinstance(value, Enum) else str(value)


def _array(array: np.ndarray) -> str:
    if array.ndim == 0 and array.dtype.kind in "fiub":
        return f"{array[()]:.6g}"
    shape = f"({', '.join(map(str, array.shape))}{',' * (array.ndim == 1)})"
    if array.dtype.kind == "b":
        return f"{shape} true in {100.0 * float(array.mean()) if array.size else 0.0:.3g} %"
    known = array[np.isfinite(array)] if array.dtype.kind in "fiu" else array[:0]
    if not known.size:
        return f"{shape} {array.dtype}"
    lost = "" if known.size == array.size else f", {100.0 * (1.0 - known.size / array.size):.3g} % not finite"
    return f"{shape} from {known.min():.4g} to {known.max():.4g}{lost}"


def _cut(line: str) -> str:
    line = " ".join(line.splitlines())
    return line if len(line) <= _WIDTH else f"{line[: _WIDTH - 4]} ..."


def _inline(made: Any) -> str:
    """A figure as an image that needs no file."""
    import base64
    import io

    drawing = io.BytesIO()
    made.savefig(drawing, format="png", dpi=_DPI)
    content = base64.b64encode(drawing.getvalue()).decode()
    return f"<img alt='its figure' style='max-width:100%' src='data:image/png;base64,{content}'>"


@functools.cache
def _names(cls: type) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(cls))


@functools.cache
def _compared(cls: type) -> tuple[str, ...]:
    """Fields that are part of the value: not names of files, and not what is computed from other fields."""
    return tuple(field.name for field in dataclasses.fields(cls) if field.compare)


def equal(one: Any, other: Any) -> bool:
    """Whether two values hold the same numbers, as `==` of results."""
    return _same(one, other, 0.0, 0.0)


def _same(one: Any, other: Any, rtol: float, atol: float) -> bool:
    """Whether two values hold the same numbers; what cannot be compared counts as the same only if it is the same object."""
    if one is other:
        return True
    if _numeric(one) and _numeric(other):
        return _same_numbers(one, other, rtol, atol)
    if type(one) is not type(other):
        return False
    if dataclasses.is_dataclass(one):
        names = [name for name in _compared(type(one)) if rtol == atol == 0.0 or name not in _RESIDUALS]
        return all(_same(getattr(one, name), getattr(other, name), rtol, atol) for name in names)
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(_same(item, other[key], rtol, atol) for key, item in one.items())
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(lambda a, b: _same(a, b, rtol, atol), one, other))
    if isinstance(one, functools.partial):
        return _same((one.func, one.args, one.keywords), (other.func, other.args, other.keywords), rtol, atol)
    try:
        return bool(one == other)
    except Exception:  # a foreign type may refuse in any way; `==` of results must not
        return False


def _numeric(value: Any) -> bool:
    return isinstance(value, float | int | complex | np.ndarray | np.generic) or hasattr(value, "__array_namespace__")


def _same_numbers(one: Any, other: Any, rtol: float, atol: float) -> bool:
    if isinstance(one, float) and isinstance(other, float) and rtol == atol == 0.0:
        return one == other or (math.isnan(one) and math.isnan(other))
    try:
        one, other = np.asarray(one), np.asarray(other)
    except Exception:  # a traced array has no numbers to compare yet
        return False
    if one.shape != other.shape:
        return False
    if one.dtype.kind not in "fciub" or other.dtype.kind not in "fciub":
        return bool(np.array_equal(one, other))
    return bool(np.allclose(one, other, rtol=rtol, atol=atol, equal_nan=True))
