"""Files to take away: the report of the comparison, its maps as a figure, and one map as CSV."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import infinivar as iv
from infinivar.analysis.plane import of_study
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import InputError
from infinivar.limits import Limit
from infinivar.report.saving import save
from infinivar.web.answers.answer import Answer
from infinivar.web.answers.document import study_of
from infinivar.web.answers.payload import MOST_CELLS, whole, word
from infinivar.web.answers.studies import file_stem

_TYPES = {
    "zip": "application/zip",
    "csv": "text/csv",
    "svg": "image/svg+xml",
    "png": "image/png",
    "pdf": "application/pdf",
}

_FIRST_DATE = (1980, 1, 1, 0, 0, 0)
"""Date of the files in an archive, so that equal reports give equal archives."""


def export(payload: Mapping[str, Any]) -> Answer:
    """A file: its name and type in the header, its bytes in the array `content`."""
    what = word(payload, "what", list(_MAKERS))
    study = study_of(payload)
    about, suffix, content = _MAKERS[what](study, payload)
    return Answer(
        header={"file": f"{file_stem(study.name)}-{about}.{suffix}", "type": _TYPES[suffix]},
        arrays={"content": np.frombuffer(content, np.uint8)},
    )


def _report(study: Any, payload: Mapping[str, Any]) -> tuple[str, str, bytes]:
    """What it is, suffix and bytes: the folder that `infinivar compare --quick` writes, and the study file, as an archive."""
    found = iv.compare(study, quick=True)
    made = io.BytesIO()
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in save(found, Path(folder) / "report"):
            _add(archive, file.name, file.read_bytes())
        try:
            _add(archive, f"{file_stem(study.name)}.toml", study.to_toml().encode())
        except InputError as problem:  # the report is of use without the file
            _add(archive, "study-not-written.txt", f"{problem}\n".encode())
    return "report", "zip", made.getvalue()


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(name, _FIRST_DATE)
    entry.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(entry, content)


def _figure(study: Any, payload: Mapping[str, Any]) -> tuple[str, str, bytes]:
    """The maps of all drives side by side, or the powers of machines, as `plot` draws them."""
    suffix = word(payload, "format", ["svg", "png", "pdf"], "svg")
    figure: Any = iv.compare(study, quick=True).plot()
    made = io.BytesIO()
    figure.savefig(made, format=suffix)
    return "figure", suffix, made.getvalue()


def _csv(study: Any, payload: Mapping[str, Any]) -> tuple[str, str, bytes]:
    """The map of one drive: a line a point, with powers, losses, efficiency and limit."""
    flat = [name for name, drive in study.drives.items() if not is_machine(drive)]
    if not flat or not (study.duty or study.requirement):
        raise InputError("export: machines have no map; take the report, which has their tables")
    name = word(payload, "drive", flat, flat[0])
    count = whole(payload, "count", 8, MOST_CELLS, 60)
    steady, axis = iv.steady_map(study.drives[name], *of_study(study).axes(count)), study.axis
    speed, force = np.meshgrid(steady.speed, steady.force, indexing="ij")
    _, speed_column, force_column = axis.columns
    columns: dict[str, Any] = {
        speed_column: speed,
        force_column: force,
        "power_in_W": steady.power_in,
        "power_out_W": steady.power_out,
        **{f"loss_{loss.replace(' ', '_')}_W": values for loss, values in steady.losses.items()},
        "efficiency": steady.efficiency,
        "margin": steady.margin,
    }
    numbers = np.column_stack([np.broadcast_to(values, speed.shape).ravel() for values in columns.values()])
    words = {int(code): Limit(int(code)).words for code in np.unique(steady.limit)}
    lines = [",".join([*columns, "limit"])]
    for row, code in zip(numbers.tolist(), steady.limit.ravel().tolist(), strict=True):
        lines.append(",".join([*("" if value != value else repr(value) for value in row), words[code]]))
    return f"{name}-map", "csv", ("\n".join(lines) + "\n").encode()


_MAKERS: dict[str, Callable[[Any, Mapping[str, Any]], tuple[str, str, bytes]]] = {
    "report": _report,
    "figure": _figure,
    "csv": _csv,
}
