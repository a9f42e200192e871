"""Loading sets of parts: the shipped catalogue, and a stored set of the size of a large manufacturer's catalogue.

The stored set has 640 motors, 1,897 gearheads and 60,143 compatible pairs of made-up figures; the file is read anew each time.
The other side reads the same figures from CSV files with the standard library and converts them to numbers, which is the least
that a script does. Both sides end with one array per column and the pairs as rows of both tables.
"""

from __future__ import annotations

import csv
import statistics
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from benchmarks._measure import Line, in_turn, ratio_line, timed
from infinivar.parts import catalogue
from infinivar.parts.tables import importing, stores
from infinivar.parts.tables.table import PartSet, part_set, table

PAIRS = 15
MOTORS, GEARHEADS, FITS = 640, 1897, 60_143
MOST = 0.050
"""Longest time to load a set. [s]"""
_MOTOR = ("voltage", "resistance", "torque_constant", "no_load_current", "continuous_torque", "inductance", "rotor_inertia",
          "mass", "max_speed", "winding_to_housing", "housing_to_ambient", "stated_no_load_speed")  # fmt: skip
_GEARHEAD = ("ratio", "efficiency", "continuous_torque", "inertia", "mass", "stages", "intermittent_torque")


def run() -> Iterator[Line]:
    """Measure loading of both sets."""
    with tempfile.TemporaryDirectory() as directory:
        folder = Path(directory)
        parts = made_up()
        file = importing.write(parts, folder / "made.npz")
        _write_csv(parts, folder)
        if importing.read(file) != parts:
            raise RuntimeError("what was stored is not what is read")
        _agree(parts, _by_hand(folder))
        yield _line("load 640 motors, 1,897 gearheads, 60,143 pairs", timed(lambda: importing.read(file)))
        ours, theirs = in_turn(timed(lambda: importing.read(file)), timed(lambda: _by_hand(folder)), PAIRS)
        yield ratio_line("the same against CSV by hand", ours, theirs, rival="csv and NumPy", at_most=0.5)
    yield _line("the shipped catalogue as tables", timed(_shipped))


def made_up() -> PartSet:
    """A set of made-up figures."""
    random = np.random.default_rng(5)
    texts = {"manufacturer": "Made Up", "source": "benchmark", "date": "2026", "kind": "catalogue"}

    def rows(letter: str, names: tuple[str, ...], count: int) -> list[dict[str, object]]:
        figures = random.uniform(0.1, 0.9, (count, len(names)))
        return [
            {"key": f"{letter}{place:05d}", "order_number": str(place), **texts, **dict(zip(names, row, strict=True))}
            for place, row in enumerate(figures.tolist())
        ]

    fits = random.choice(MOTORS * GEARHEADS, FITS, replace=False)
    pairs = np.stack(np.divmod(np.sort(fits), GEARHEADS), axis=-1)
    tables = [table("motors", rows("M", _MOTOR, MOTORS)), table("gearheads", rows("G", _GEARHEAD, GEARHEADS))]
    return part_set("made", tables, pairs)


def _write_csv(parts: PartSet, folder: Path) -> None:
    for kind, names in (("motors", _MOTOR), ("gearheads", _GEARHEAD)):
        held = parts.tables[kind]
        with (folder / f"{kind}.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["key", *names])
            columns = [held.part_keys, *(map(repr, held[name].tolist()) for name in names)]
            writer.writerows(zip(*columns, strict=True))
    motors, gearheads = parts.motors.part_keys, parts.gearheads.part_keys
    with (folder / "pairs.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows((motors[a], gearheads[b]) for a, b in parts.pairs.tolist())


def _by_hand(folder: Path) -> tuple[dict[str, dict[str, np.ndarray]], np.ndarray]:
    """Columns by kind, and pairs, from the CSV files."""
    columns, rows = {}, {}
    for kind in ("motors", "gearheads"):
        with (folder / f"{kind}.csv").open(newline="", encoding="utf-8") as file:
            heading, *lines = csv.reader(file)
        figures = np.array([[float(cell) for cell in line[1:]] for line in lines]).T
        columns[kind] = dict(zip(heading[1:], figures, strict=True))
        rows[kind] = {line[0]: place for place, line in enumerate(lines)}
    with (folder / "pairs.csv").open(newline="", encoding="utf-8") as file:
        pairs = [(rows["motors"][a], rows["gearheads"][b]) for a, b in csv.reader(file)]
    return columns, np.array(pairs)


def _agree(parts: PartSet, other: tuple[dict[str, dict[str, np.ndarray]], np.ndarray]) -> None:
    columns, pairs = other
    same = all(
        np.array_equal(parts.tables[kind][name], column)
        for kind, one in columns.items()
        for name, column in one.items()
    )
    if not same or not np.array_equal(parts.pairs, pairs):
        raise RuntimeError("the files do not hold the same figures")


def _shipped() -> PartSet:
    stores.shipped.cache_clear()
    catalogue.data.cache_clear()
    return stores.shipped()


def _line(what: str, seconds: Callable[[], float]) -> Line:
    seconds()
    middle = statistics.median(seconds() for _ in range(PAIRS))
    return Line(
        what=what,
        ours=f"{middle * 1e3:.3g} ms",
        theirs="",
        ratio="",
        target=f"<= {MOST * 1e3:g} ms",
        passed=middle <= MOST,
    )
