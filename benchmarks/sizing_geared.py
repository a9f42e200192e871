"""Search over 60,143 pairs of motor and gearhead in a walking cycle of 1,000 instants, against a loop over `duty_cycle`.

The tables are drawn at random, in the number and the range of a large maker's catalogue. Where the environment names a folder
of the MGDB format in ``MGDB``, its maxon motors and gearheads are searched instead; thermal data that it lacks are assumed, for
the search with heat only. The loop is timed on some pairs, whose demands and energies must agree with those of the search, and
its time counts for all pairs in proportion.
"""

from __future__ import annotations

import csv
import os
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import infinivar as iv
from benchmarks._measure import ROOT, Line
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.sizing.geared import GearedSizing, size_geared
from infinivar.sizing.geared.candidates import candidates
from infinivar.sizing.geared.sampled import sample
from infinivar.sizing.geared.tasks import tasks_of

INSTANTS = 1000
MOTORS, GEARHEADS, PAIRS = 640, 1897, 60_143
RADII = (0.003, 0.05)
"""Range of the pulley's radius. [m]"""
LOOPED = 40
"""Pairs of which the loop is timed."""
RUNS = 3

Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Catalogue:
    """Tables of parts, and which of them fit together."""

    motors: Columns
    gearheads: Columns
    pairs: np.ndarray

    @property
    def heated(self) -> Catalogue:
        """The same with thermal data for every motor."""
        count = len(self.motors["voltage"])
        assumed = {"winding_time_constant": 15.0, "housing_time_constant": 700.0, "max_winding_temperature": 398.15}
        known = {"winding_to_housing": 3.0, "housing_to_ambient": 12.0}
        columns = {name: np.full(count, value) for name, value in {**known, **assumed}.items()}
        return Catalogue(motors={**columns, **self.motors}, gearheads=self.gearheads, pairs=self.pairs)


def run() -> Iterator[Line]:
    """Measure both searches and the loop."""
    study = iv.load_study(ROOT / "studies" / "knee_walking.toml")
    drive = study.drives["geared"]
    assert isinstance(drive, ConventionalDrive)
    folder = os.environ.get("MGDB")
    parts = drawn() if folder is None else read(Path(folder))

    fixed, found = _timed(drive, study, parts)
    print(f"sizing_geared: {found.candidates:,} pairs, {found.feasible.sum():,} feasible; {_firsts(found)}")
    looped = _loop(drive, study, parts) * len(parts.pairs)
    what = f"{len(parts.pairs):,} pairs x {INSTANTS:,} instants"
    yield Line(
        what=f"{what}, radius fixed: limits of all, energy of the feasible",
        ours=f"{fixed:.3g} s",
        theirs=f"loop over duty_cycle: {looped:.3g} s",
        ratio=f"{fixed / looped:.2g}",
        target="<= 1 s, 1/100",
        passed=fixed <= 1.0 and looped >= 100.0 * fixed,
    )
    free, best = _timed(drive, study, parts.heated, RADII)
    print(
        f"sizing_geared: radius free, {best.feasible.sum():,} pairs left by closed forms, {best.evaluated.sum()} evaluated"
    )
    yield Line(
        what=f"{what}, radius optimised, with heat: the 20 of least energy",
        ours=f"{free:.3g} s",
        theirs="",
        ratio="",
        target="<= 10 s",
        passed=free <= 10.0,
    )


def _timed(
    drive: ConventionalDrive, study: iv.Study, where: Catalogue, radius: tuple[float, float] | None = None
) -> tuple[float, GearedSizing]:
    """Median time of a search, and its result."""

    def once() -> tuple[float, GearedSizing]:
        start = time.perf_counter()
        tables = where.motors, where.gearheads, where.pairs
        found = size_geared(drive, *tables, duty=study.duty, radius=radius, samples=INSTANTS)
        return time.perf_counter() - start, found

    runs = sorted((once() for _ in range(RUNS)), key=lambda one: one[0])
    return runs[RUNS // 2]


def _firsts(found: GearedSizing) -> str:
    return ", ".join(f"{one.limit.words} excludes {one.first:,}" for one in found.counts if one.first)


def _loop(drive: ConventionalDrive, study: iv.Study, parts: Catalogue) -> float:
    """Seconds per pair of a loop over `duty_cycle`.

    Raises
    ------
    RuntimeError
        If a demand or an energy differs from that of the search.
    """
    made = candidates(drive, parts.motors, parts.gearheads, parts.pairs, loss_model="coulomb", moving=True, stated=())
    rows = np.random.default_rng(1).choice(made.usable, LOOPED, replace=False)
    (name, motion), *_ = study.duty.items()
    done = sample(made, rows, tasks_of(drive, study.duty, None, travel=None, samples=INSTANTS), drive.stage)
    drives = [made.drive(int(row), drive.stage) for row in rows]
    start = time.perf_counter()
    cycles = [iv.duty_cycle(one, motion, samples=INSTANTS) for one in drives]
    seconds = (time.perf_counter() - start) / LOOPED
    for place, cycle in enumerate(cycles):
        pairs = [(done.demands[name, limit, part][place], demand) for (limit, part), demand in cycle.demands.items()]
        for one, other in [*pairs, (done.power[name][place], cycle.power_in)]:
            if abs(one - other) > 1e-9 * abs(other):
                raise RuntimeError(f"the search finds {one} where duty_cycle finds {other}")
    return seconds


def drawn() -> Catalogue:
    """Tables at random."""
    random = np.random.default_rng(0)
    constant = np.exp(random.normal(np.log(0.015), 0.9, MOTORS))
    volts = random.choice([12.0, 18.0, 24.0, 36.0, 48.0], MOTORS)
    lasting = np.exp(random.normal(np.log(0.03), 1.0, MOTORS))
    current = lasting / constant
    ohms = 0.12 * volts / current
    motors = {
        "voltage": volts,
        "resistance": ohms,
        "torque_constant": constant,
        "no_load_current": 0.04 * current,
        "continuous_torque": lasting,
        "max_speed": 1.1 * volts / constant,
        "rotor_inertia": 2e-4 * lasting**1.4,
        "mass": 3.0 * lasting**0.75,
    }
    stages = random.integers(1, 4, GEARHEADS)
    torque = np.exp(random.normal(np.log(1.0), 1.2, GEARHEADS))
    gearheads = {
        "ratio": np.exp(random.uniform(0.8, 1.6, GEARHEADS) * stages),
        "efficiency": 0.9**stages,
        "inertia": 1e-7 * torque,
        "mass": 0.08 * torque**0.6,
        "continuous_torque": torque,
        "intermittent_torque": 1.5 * torque,
    }
    places = random.choice(MOTORS * GEARHEADS, PAIRS, replace=False)
    return Catalogue(motors=motors, gearheads=gearheads, pairs=np.stack(np.divmod(places, GEARHEADS), axis=-1))


def read(folder: Path) -> Catalogue:
    """Maxon motors and gearheads of a folder of the MGDB format."""

    def rows(name: str) -> list[dict[str, str]]:
        with (folder / f"maxon_{name}.csv").open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def columns(table: list[dict[str, str]], names: Mapping[str, str]) -> dict[str, np.ndarray]:
        return {ours: np.array([float(row[theirs] or "nan") for row in table]) for ours, theirs in names.items()}

    motors, gearheads = rows("motors"), rows("gearboxes")
    of_motor = {row["key"]: place for place, row in enumerate(motors)}
    of_gear = {row["key"]: place for place, row in enumerate(gearheads)}
    with (folder / "maxon_compatibility.csv").open(newline="", encoding="utf-8") as file:
        pairs = [(of_motor[line[0]], of_gear[key]) for line in csv.reader(file) for key in line[1:] if key]
    names = {"voltage": "V", "resistance": "R", "torque_constant": "k_t", "no_load_current": "I_nl", "mass": "mass"}
    names |= {"max_speed": "max_int_speed", "rotor_inertia": "inertia", "peak_torque": "max_int_torque"}
    names |= {"winding_to_housing": "Rth1", "housing_to_ambient": "Rth2"}
    found = columns(motors, names)
    lasting = columns(motors, {"current": "I_nom"})["current"]
    found["continuous_torque"] = found["torque_constant"] * (lasting - found["no_load_current"])
    gear_names = {name: name for name in ("ratio", "efficiency", "inertia", "mass")}
    gear_names |= {"continuous_torque": "max_cont_torque", "intermittent_torque": "max_int_torque"}
    return Catalogue(motors=found, gearheads=columns(gearheads, gear_names), pairs=np.array(pairs))
