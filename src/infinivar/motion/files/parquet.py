"""Parquet files, such as those of the LocoHub standard of locomotion data; needs pyarrow."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from infinivar._core import extras
from infinivar.errors import InputError, printable
from infinivar.motion.files.headings import Heading, heading_of
from infinivar.motion.files.sheet import MOST_ROWS, fault, shown

MAGIC = b"PAR1"


class ParquetSheet:
    """Columns of a Parquet file, read when chosen."""

    place = "row"
    tabular = True
    top = "schema"

    def __init__(self, file: str, content: bytes) -> None:
        """Open the file.

        Raises
        ------
        InputError
            If pyarrow is missing, or the file is broken or too long.
        """
        extras.load("pyarrow", "parquet", f"{file}: a Parquet file")
        arrow, parquet = (importlib.import_module(name) for name in ("pyarrow", "pyarrow.parquet"))
        self.file = file
        try:
            self._data: Any = parquet.ParquetFile(arrow.BufferReader(content))
            names = list(self._data.schema_arrow.names)
            rows = int(self._data.metadata.num_rows)
        except (OSError, ValueError, NotImplementedError) as problem:
            raise InputError(
                f"{file}: is not a whole Parquet file: {printable(str(problem).splitlines()[0])}"
            ) from problem
        self.headings: Sequence[Heading] = tuple(map(heading_of, names))
        if rows > MOST_ROWS:
            raise InputError(
                f"{file}: row {MOST_ROWS + 1}: is beyond the {MOST_ROWS} rows allowed; choose some of its strides"
            )
        if rows < 2:
            raise InputError(
                f"{file}: row 1, column {shown(names[0] if names else '')}: must have at least two rows, got {rows}"
            )

    def usual_unit(self, role: str, heading: Heading) -> str | None:
        """Unit that the format itself states: none."""
        del role, heading
        return None

    def passed_over(self, lines: np.ndarray) -> tuple[str, ...]:
        """Return a remark about what was not read: none, as the format has no comments."""
        del lines
        return ()

    def numbers(self, places: Sequence[int], *, blank: bool = False) -> tuple[np.ndarray, np.ndarray, str]:
        """Return the columns at some places, the number of each row, and the format in words."""
        names = [self.headings[place].text for place in places]
        read = self._data.read(columns=names, use_threads=False)
        values = np.empty((read.num_rows, len(places)))
        for one, (place, name) in enumerate(zip(places, names, strict=True)):
            column = read.column(name)
            try:
                values[:, one] = column.cast("float64").to_numpy()
            except (ValueError, NotImplementedError):
                fault(self, 1, place, f"must hold numbers, got {column.type}")
            missing = np.isnan(values[:, one]) if blank else False
            wrong = np.flatnonzero(~(np.isfinite(values[:, one]) | missing))
            if wrong.size:
                got = values[wrong[0], one]
                fault(self, int(wrong[0]) + 1, place, f"must be a finite number, got {float(got)!r}")
        return values, np.arange(1, len(values) + 1), "Parquet"
