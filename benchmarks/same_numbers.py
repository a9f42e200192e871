"""Compare the numbers of this checkout with those of another commit: ``python -m benchmarks.same_numbers COMMIT``.

Runs `compare` on every study that ships with both, and `reproduce`, with the sources of both, then compares every number in
the JSON, CSV and NetCDF files. Words may differ; a number, a truth value or a key that only one side has is a difference.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

TOLERANCE = 1e-12
"""Relative to the number itself: two orders of hashing or summing may round differently, nothing else may."""
ROOT = Path(__file__).parents[1]


def main() -> int:
    """Exit code: 0 if all numbers agree within `TOLERANCE`, 1 otherwise."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.same_numbers", description=__doc__)
    parser.add_argument("commit", help="the commit to compare with")
    with tempfile.TemporaryDirectory() as scratch:
        before, outputs = Path(scratch, "before"), Path(scratch, "outputs")
        archive = subprocess.run(
            ["git", "archive", parser.parse_args().commit], cwd=ROOT, capture_output=True, check=True
        ).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(before, filter="data")
        studies = [
            study for study in sorted((ROOT / "studies").glob("*.toml")) if (before / "studies" / study.name).exists()
        ]
        for checkout, name in ((before, "before"), (ROOT, "now")):
            _produce(checkout, studies, outputs / name)
        return _report(outputs / "before", outputs / "now")


def _produce(checkout: Path, studies: list[Path], out: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(checkout / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    jobs = {study.stem: ["compare", str(study)] for study in studies}
    for name, job in {**jobs, "reproduce": ["reproduce"]}.items():
        print(f"{checkout.name}: {name}", flush=True)
        done = subprocess.run(
            [sys.executable, "-m", "infinivar", *job, "--out", str(out / name)],
            env=environment,
            cwd=checkout,
            capture_output=True,
            text=True,
        )
        if done.returncode not in (0, 1):
            raise SystemExit(f"{name} ended with exit code {done.returncode}: {done.stderr}")


def _report(before: Path, now: Path) -> int:
    different, count, largest = [], 0, 0.0
    for file in sorted(path for path in before.rglob("*") if path.suffix in _READERS):
        name = str(file.relative_to(before))
        old = dict(_READERS[file.suffix](file))
        new = dict(_READERS[file.suffix](now / name)) if (now / name).exists() else {}
        for place in sorted({*old, *new}):
            count += 1
            change = _change(old.get(place), new.get(place))
            largest = max(largest, change if change < np.inf else 0.0)
            if not change <= TOLERANCE:
                different.append(f"{name} {place}: {old.get(place)} -> {new.get(place)}")
    for line in different[:50]:
        print(line)
    print(f"{count} numbers compared, {len(different)} differ by more than {TOLERANCE:g}; largest change {largest:.1e}")
    return int(bool(different))


def _change(old: Any, new: Any) -> float:
    """Largest change relative to the size of the values; infinite where only one side has the value or shapes differ."""
    if old is None or new is None or np.shape(old) != np.shape(new):
        return float("inf")
    a, b = np.asarray(old, dtype=float), np.asarray(new, dtype=float)
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    if same.all():
        return 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        change = np.abs(a - b)[~same] / np.maximum(np.abs(a), np.abs(b))[~same]
    return float("inf") if np.isnan(change).any() else float(change.max())


def _json(file: Path) -> Iterator[tuple[str, float]]:
    def walk(value: Any, place: str) -> Iterator[tuple[str, float]]:
        if isinstance(value, dict):
            for key, inner in value.items():
                yield from walk(inner, f"{place}.{key}")
        elif isinstance(value, list):
            for index, inner in enumerate(value):
                yield from walk(inner, f"{place}[{index}]")
        elif isinstance(value, bool | int | float):
            yield place, float(value)

    yield from walk(json.loads(file.read_text("utf-8")), "")


def _csv(file: Path) -> Iterator[tuple[str, float]]:
    with file.open(encoding="utf-8", newline="") as text:
        for line, row in enumerate(csv.reader(text), start=1):
            for column, cell in enumerate(row, start=1):
                try:
                    yield f"line {line} column {column}", float(cell)
                except ValueError:
                    continue


def _netcdf(file: Path) -> Iterator[tuple[str, Any]]:
    import xarray as xr

    with xr.open_dataset(file, engine="scipy") as data:
        for name in (*data.coords, *data.data_vars):
            if np.issubdtype(data[name].dtype, np.number):
                yield str(name), data[name].to_numpy()


_READERS = {".json": _json, ".csv": _csv, ".nc": _netcdf}

if __name__ == "__main__":
    raise SystemExit(main())
