"""Labelled inputs (`xarray.DataArray`): numbers go in without their labels, which come back with the result."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from infinivar._core.result import Frozen, result
from infinivar.errors import ParameterError

if TYPE_CHECKING:
    import xarray

P = ParamSpec("P")
R = TypeVar("R")


@result
class Labels(Frozen):
    """Dimensions of a result, and coordinates along them, among them the inputs.

    Attributes
    ----------
    dims     Names of the axes.
    coords   By name: dimensions, values and attributes of each.
    """

    dims: tuple[str, ...]
    coords: Mapping[str, tuple[tuple[str, ...], Any, Mapping[str, Any]]]

    def array(self, values: Any) -> xarray.DataArray:
        """An array with these labels."""
        import xarray

        return xarray.DataArray(values, dims=self.dims, coords={**self.coords})


def is_labelled(value: Any) -> bool:
    """Whether it is an array of xarray; xarray is not imported for the question."""
    return type(value).__module__.partition(".")[0] == "xarray" and hasattr(value, "dims")


def labels_of(arrays: Mapping[str, Any], dims: tuple[str, ...]) -> Labels:
    """Labels of a result on these dimensions from the arrays, by argument, that went in."""
    coords: dict[str, tuple[tuple[str, ...], Any, Mapping[str, Any]]] = {}
    for argument, array in arrays.items():
        for name, coordinate in array.coords.items():
            coords.setdefault(str(name), _variable(coordinate))
        coords.setdefault(str(array.name or argument), _variable(array))
    return Labels(dims=dims, coords=coords)


def _variable(array: Any) -> tuple[tuple[str, ...], Any, Mapping[str, Any]]:
    return tuple(map(str, array.dims)), array.values, dict(array.attrs)


def labelled(method: Callable[P, R]) -> Callable[P, R]:
    """Let a method of keyword arguments take labelled arrays, which broadcast by the names of their dimensions.

    A result with a field `labels` gets them there; an array comes back as a labelled one.
    """

    @functools.wraps(method)
    def call(*args: P.args, **arguments: P.kwargs) -> R:
        for value in arguments.values():
            if is_labelled(value):
                break
        else:
            return method(*args, **arguments)
        values, labels = _aligned(arguments)
        found: Any = method(*args, **values)  # type: ignore[arg-type]
        if dataclasses.is_dataclass(found) and not isinstance(found, type):
            return dataclasses.replace(found, labels=labels)  # type: ignore[return-value, type-var]
        return labels.array(found)  # type: ignore[return-value]

    return call


def _aligned(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], Labels]:
    """Arguments as arrays of one shape, or plain numbers, and the labels of that shape.

    Raises
    ------
    ParameterError
        If coordinates differ, or an array without labels stands beside one with labels.
    """
    import numpy as np
    import xarray

    arrays = {name: value for name, value in arguments.items() if is_labelled(value)}
    for name, value in arguments.items():
        if name not in arrays and value is not None and np.ndim(value) > 0:
            raise ParameterError(f"{name} has no labels, but {next(iter(arrays))} has: label all arrays or none")
    try:
        spread = xarray.broadcast(*xarray.align(*arrays.values(), join="exact"))
    except ValueError as problem:
        raise ParameterError(f"labels of {' and '.join(arrays)} differ: {problem}") from problem
    values = {name: array.values for name, array in zip(arrays, spread, strict=True)}
    return {**arguments, **values}, labels_of(arrays, tuple(map(str, spread[0].dims)))
