"""Compare all that this checkout says with what another commit says: ``python -m benchmarks.same_numbers COMMIT``.

Runs every job of `benchmarks/_same_jobs.py` with the sources of both, one beside the other: commands on the shipped studies, the
messages of faulty studies, public names with signatures, the schema. Then compares

* numbers, truth values and keys in JSON, CSV and NetCDF files,
* words: what commands print, texts in these files, names, units and dimensions of variables, names of files.

Pictures and pages are drawn from the same values and are not compared. Differences on purpose stand in `intended.txt`: a regular
expression for each line of the comparison that may differ, with the reason. ``--keep FOLDER`` keeps what both said, and takes
from there what the other commit said before.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._same_jobs import DATA, Job, jobs

ROOT = Path(__file__).parents[1]
INTENDED = Path(__file__).with_name("intended.txt")
PRINTED = "printed.txt"
"""File with what the commands of a job print, and their exit codes."""
SHOWN = 60
"""Differences that are printed."""


def main() -> int:
    """Exit code: 0 if all agrees, or differs on purpose; 1 otherwise."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.same_numbers", description=__doc__)
    parser.add_argument("commit", help="the commit to compare with")
    parser.add_argument("--only", default="*", help="names of jobs, with wildcards, such as 'size*'")
    parser.add_argument("--keep", type=Path, help="folder that keeps the outputs of both")
    requested = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        before, out = Path(scratch, "before"), requested.keep or Path(scratch, "outputs")
        commit = _git("rev-parse", requested.commit).decode().strip()
        with tarfile.open(fileobj=io.BytesIO(_git("archive", commit))) as tar:
            tar.extractall(before, filter="data")
        wanted = {name: job for name, job in jobs().items() if fnmatch(name, requested.only)}
        data = (out / "data").absolute()
        for name, text in DATA.items():
            data.mkdir(parents=True, exist_ok=True)
            (data / name).write_text(text(), "utf-8")
        now = Path(scratch, "now")
        shutil.copytree(ROOT / "src", now / "src")  # what is edited meanwhile does not count
        sides = {"before": (before, (out / commit).absolute()), "now": (now, (out / "now").absolute())}
        with ThreadPoolExecutor(2) as both:
            for side, (checkout, folder) in sides.items():
                for name, job in wanted.items():
                    if side == "now" or not (folder / name / PRINTED).exists():
                        both.submit(_produce, checkout, job, folder / name, data)
        found = [_compared(name, job, *(folder / name for _, folder in sides.values())) for name, job in wanted.items()]
        return _report(found)


def _git(*words: str) -> bytes:
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, check=True).stdout


def _produce(checkout: Path, job: Job, folder: Path, data: Path) -> None:
    """Run the commands of a job, with a checkout's sources and this one's studies, in a folder of its own."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    environment = os.environ | {
        "PYTHONPATH": str(checkout / "src"),
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "COLUMNS": "100",
    }
    lines = []
    for words in job.commands:
        filled = [word.format(studies=ROOT / "studies", data=data, benchmarks=ROOT / "benchmarks") for word in words]
        done = subprocess.run([sys.executable, *filled], env=environment, cwd=folder, capture_output=True, text=True)
        printed = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr).replace(str(data), "data")
        lines.append(f"$ {' '.join(words)}\n{printed.replace(str(ROOT), '')}exit code {done.returncode}\n")
    (folder / PRINTED).write_text("\n".join(lines), "utf-8")
    print(f"{checkout.name}: {folder.name}", flush=True)


def _compared(name: str, job: Job, before: Path, now: Path) -> tuple[int, float, list[str]]:
    """Values compared, the largest change of a number, and the differences of a job."""
    count, largest, different = 0, 0.0, []
    for file in sorted(
        {path.relative_to(side) for side in (before, now) for path in side.rglob("*") if path.is_file()}
    ):
        old, new = ({} if not (side / file).exists() else dict(_read(side / file)) for side in (before, now))
        if not (before / file).exists() or not (now / file).exists():
            different.append(f"{name}/{file}: {'new' if (now / file).exists() else 'gone'}")
            continue
        for place in dict.fromkeys((*old, *new)):
            count += 1
            change = _change(old.get(place), new.get(place))
            largest = max(largest, change if change < np.inf else 0.0)
            if not change <= job.tolerance:
                different.append(f"{name}/{file} {place}: {_short(old.get(place))} -> {_short(new.get(place))}")
    return count, largest, different


def _report(found: list[tuple[int, float, list[str]]]) -> int:
    rows = [line.split("  # ")[0].strip() for line in INTENDED.read_text("utf-8").splitlines() if line.strip()]
    intended = [re.compile(row) for row in rows if not row.startswith("#")]
    all_ = [line for _, _, lines in found for line in lines]
    different = [line for line in all_ if not any(one.search(line) for one in intended)]
    for line in different[:SHOWN]:
        print(line)
    if len(different) > SHOWN:
        print(f"... and {len(different) - SHOWN} more")
    print(
        f"{sum(count for count, _, _ in found)} values compared, {len(different)} differ, "
        f"{len(all_) - len(different)} on purpose; largest change of a number {max(one for _, one, _ in found):.1e}"
    )
    return int(bool(different))


def _short(value: Any) -> str:
    said = repr(value) if isinstance(value, str) else str(value).replace("\n", " ")
    return said if len(said) <= 160 else f"{said[:157]}..."


def _change(old: Any, new: Any) -> float:
    """Largest change relative to the size of the values; infinite where words or shapes differ, or one side has no value."""
    if isinstance(old, str) or isinstance(new, str) or old is None or new is None or np.shape(old) != np.shape(new):
        return 0.0 if isinstance(old, str) and old == new else float("inf")
    a, b = np.asarray(old, dtype=float), np.asarray(new, dtype=float)
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    if same.all():
        return 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        change = np.abs(a - b)[~same] / np.maximum(np.abs(a), np.abs(b))[~same]
    return float("inf") if np.isnan(change).any() else float(change.max())


def _read(file: Path) -> Iterator[tuple[str, Any]]:
    return _READERS.get(file.suffix, _unread)(file)


def _unread(file: Path) -> Iterator[tuple[str, Any]]:
    return iter(())


def _json(file: Path) -> Iterator[tuple[str, Any]]:
    def walk(value: Any, place: str) -> Iterator[tuple[str, Any]]:
        if isinstance(value, dict):
            for key, inner in value.items():
                yield from walk(inner, f"{place}.{key}")
        elif isinstance(value, list):
            for index, inner in enumerate(value):
                yield from walk(inner, f"{place}[{index}]")
        else:
            yield place, float(value) if isinstance(value, bool | int | float) else str(value)

    yield from walk(json.loads(file.read_text("utf-8")), "")


def _csv(file: Path) -> Iterator[tuple[str, Any]]:
    with file.open(encoding="utf-8", newline="") as text:
        for line, row in enumerate(csv.reader(text), start=1):
            for column, cell in enumerate(row, start=1):
                yield f"line {line} column {column}", _number(cell)


def _number(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


_CHANCE = re.compile(r"(?<= at )0x[0-9a-f]+|[\d.]+(?= a second and worker)")
"""Addresses and speeds, which differ from run to run."""


def _lines(file: Path) -> Iterator[tuple[str, Any]]:
    for number, line in enumerate(file.read_text("utf-8").splitlines(), start=1):
        yield f"line {number}", _CHANCE.sub("...", line)


def _netcdf(file: Path) -> Iterator[tuple[str, Any]]:
    import xarray as xr

    with xr.open_dataset(file, engine="scipy") as data:
        for name in (*data.coords, *data.data_vars):
            variable = data[name]
            words = {key: str(value) for key, value in sorted(variable.attrs.items())}
            yield f"{name} about", f"{variable.dims} {words}"
            if np.issubdtype(variable.dtype, np.number):
                yield str(name), variable.to_numpy()


_READERS: dict[str, Callable[[Path], Iterator[tuple[str, Any]]]] = {
    ".json": _json,
    ".csv": _csv,
    ".nc": _netcdf,
    ".txt": _lines,
    ".toml": _lines,
}

if __name__ == "__main__":
    raise SystemExit(main())
