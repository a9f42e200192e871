"""Add a user's measurements to the known sets, after the checks that find misread files."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from infinivar.calibration.measured.outcome import Part
from infinivar.calibration.measured.report import MeasuredReport, measured_report
from infinivar.calibration.measured.sets import FILE, ROWS, MeasuredSet, described, known_sets, users_folder
from infinivar.errors import InputError, printable
from infinivar.units import show

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
"""What a set may be called."""


def add_set(
    source: str | Path, *, description: str | Path | None = None, name: str | None = None
) -> tuple[Path, MeasuredReport]:
    """Check a measured set and copy it into the user's folder of sets; nothing is written if a check fails.

    Parameters
    ----------
    source : str or Path        Folder with measured.toml and rows, or a CSV file.
    description : str or Path   TOML file of a CSV file; by default measured.toml beside it.
    name : str                  Name of the set; by default that of the folder or of the CSV file.

    Returns
    -------
    path, report   Folder of the copy, and the comparison of the set with its law. Single rows that do not fit are no fault of
        the file: they are in the report.

    Raises
    ------
    InputError
        If the description or a unit is missing or wrong, no first guess is stated by which misread columns can be told, a
        column or a drifting reading contradicts the law, the name is taken, or the folder cannot be written. The message
        names file, lines, column and what was expected.
    """
    given = Path(source)
    toml = Path(description) if description is not None else (given if given.is_dir() else given.parent) / FILE
    for path in (given, toml):
        if not path.exists():
            raise InputError(f"{printable(path)}: no such file{'' if path == given else ': it describes the rows'}")
    one = described(toml)
    rows = one.rows if given.is_dir() else given
    if rows is None or not rows.is_file():
        raise InputError(f"{printable(rows or given / ROWS)}: no such file: a set that is added has its rows")
    called = name or (given.resolve().name if given.is_dir() else given.stem)
    if not NAME.fullmatch(called):
        raise InputError(f"name = {called!r} must be letters, digits, - or _, at most 64: give one with --name")
    if called in known_sets():
        raise InputError(
            f"{called}: there is such a set already, in {printable(known_sets()[called])}; give another --name"
        )
    if not any(start > 0.0 for start in one.starts.values()):
        terms = ", ".join(one.law.terms)
        raise InputError(
            f"{printable(toml)}: [start] is missing: state a first guess, to a factor of 5, of a parameter that is not zero, as "
            f"swapped columns and wrong units are told by it; parameters of bench {one.law.name}: {terms}"
        )
    found = measured_report(one, rows=rows)
    faults = [said for part in found.parts for said in _faults(one, part, rows)]
    if faults:
        raise InputError("\n".join(faults))
    return _copied(called, toml, rows), found


def _faults(one: MeasuredSet, part: Part, rows: Path) -> Iterator[str]:
    """Faults of columns: file, lines, what is wrong with which column, and what was expected."""
    where = f"{printable(rows)}: lines {min(part.rows.lines)} to {max(part.rows.lines)}"
    starts = ", ".join(
        f"{name} near {show(value, one.law.terms[name].parameter.unit)}" for name, value in one.starts.items()
    )
    drifting = [said for said in part.misread if " drifts by " in said]
    # Residuals say nothing of a drift while the law does not fit the columns.
    for said in [said for said in part.misread if said not in drifting] or drifting:
        usual = "residuals without a trend" if drifting == list(part.misread) else f"by [start], {starts}"
        yield f"{where}{f' of {part.name}' if part.name else ''}: {said}; expected: {usual}"


def _copied(name: str, toml: Path, rows: Path) -> Path:
    """Copy description and rows; the folder appears whole or not at all."""
    folder = users_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".") as held:
            made = Path(held) / name
            made.mkdir()
            shutil.copyfile(toml, made / FILE)
            target = described(made / FILE).rows or made / ROWS
            if target.resolve().parent != made.resolve():
                raise InputError(f"{printable(toml)}: rows must be the name of a file beside it")
            shutil.copyfile(rows, target)
            made.rename(folder / name)
    except OSError as problem:
        raise InputError(f"{printable(folder)}: cannot be written: {problem.strerror or problem}") from problem
    return folder / name
