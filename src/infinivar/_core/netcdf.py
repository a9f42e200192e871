"""NetCDF files (version 3, which every reader knows) from labelled arrays, written by SciPy alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

Variable = tuple[str | tuple[str, ...], Any, Mapping[str, Any]]
"""Dimensions, values and attributes, in the order in which xarray takes them."""


class Arrays(NamedTuple):
    """Labelled arrays: what `xarray.Dataset` is made of."""

    data: Mapping[str, Variable]
    """Variables by name."""
    coordinates: Mapping[str, Variable | list[str]] = {}
    """Axes by name; a list of texts names the places along the axis of its name."""
    attributes: Mapping[str, Any] = {}
    """Attributes of the whole."""


def write(path: str | Path, arrays: Arrays) -> None:
    """Write labelled arrays as `xarray.Dataset(*arrays)` would be written.

    Parameters
    ----------
    path : str or Path
    arrays : Arrays

    Notes
    -----
    Texts become arrays of characters, as NetCDF 3 knows no texts; xarray puts them together again. Arrays without a value are
    left out, such as the losses of a session in which nothing moves.
    """
    from scipy.io import netcdf_file

    with netcdf_file(path, "w", version=2) as file:
        for name, value in arrays.attributes.items():
            setattr(file, name, _attribute(value))
        for name, content in {**arrays.coordinates, **arrays.data}.items():
            dimensions, values, notes = (name, content, {}) if isinstance(content, list) else content
            dimensions = (dimensions,) if isinstance(dimensions, str) else dimensions
            if isinstance(content, list):
                texts = np.array([text.encode() for text in content])
                values = texts.view("S1").reshape(len(content), -1) if content else np.empty((0, 1), "S1")
                dimensions, notes = (*dimensions, f"string{values.shape[1]}"), {"_Encoding": "utf-8"}
            values = np.asarray(values)
            if not values.size:
                continue  # NetCDF 3 takes a length of zero for one that grows
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.createDimension(dimension, size)
            variable = file.createVariable(name, values.dtype, dimensions)
            if values.dtype.kind == "f":
                variable._FillValue = values.dtype.type("nan")
            for key, note in notes.items():
                setattr(variable, key, _attribute(note))
            variable[...] = values


def _attribute(value: Any) -> Any:
    """An attribute as SciPy writes it in full: text beyond ASCII as bytes, a number in eight bytes instead of four."""
    if isinstance(value, str):
        return value.encode("utf-8")
    return np.float64(value) if isinstance(value, float) else value
