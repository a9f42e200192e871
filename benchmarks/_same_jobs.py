"""What `benchmarks.same_numbers` runs on both sides: commands on the shipped studies, and scripts about names and messages.

The data of benches for geared motors are made here from laws in closed form, so that both sides read the same.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

STUDIES = Path(__file__).parents[1] / "studies"

STEADY = 1e-12
"""Relative tolerance where sums keep their order: two orders of hashing or summing may round differently, nothing else may."""

IN_TIME = 1e-9
"""Of energies integrated over time, and of fits and searches that iterate on them."""


class Job(NamedTuple):
    """Commands of one folder of results; `{studies}`, `{data}` and `{benchmarks}` are filled in."""

    commands: tuple[tuple[str, ...], ...]
    tolerance: float = STEADY


def jobs() -> dict[str, Job]:
    """All jobs by name, those that take longest first."""
    found: dict[str, Job] = {}
    for study in ("knee_walking", "hand_controller"):
        for objective in ("energy,mass", "mass"):
            search = ("size", _study(study), "--objective", objective, "--seed", "0", "--generations", "8")
            found[f"size {study} {objective}"] = _job(search, ("--builds", "16"), tolerance=IN_TIME)
    for name, table in _tables().items():
        found.update(_of_study(name, table))
    rig = ("-m", "infinivar", "rig", "{data}/bench.toml", "--ratios", "20,5,2", "--out", "rig.csv")
    found |= {
        "reproduce": _job(("reproduce",)),
        "sweep": _job(
            ("sweep", "size", _study("knee_walking"), "--folder", "chunks", "--set", "shipped", "--pairs", "20"),
            tolerance=IN_TIME,
        ),
        "calibrate transmission": Job((rig, *_calibrate("bench", "cobotic", "rig.csv").commands), IN_TIME),
        "calibrate dynamometer": _calibrate("geared", "joint", "{data}/dynamometer.csv"),
        "calibrate pendulum": _calibrate("geared", "joint", "{data}/swing.csv"),
        "motion": _job(("motion", "{data}/recorded.csv")),
        "catalogue": _job(("catalogue", "list"), out=False),
        "graph": _job(("graph", _study("hand_controller"), "cobotic")),
        "schema": _job(("schema",), out=False),
        "names": Job((("{benchmarks}/_public_names.py",),)),
        "messages": Job((("{benchmarks}/_messages.py", "{studies}"),)),
    }
    return found


def _of_study(name: str, table: Mapping[str, Any]) -> dict[str, Job]:
    """Jobs on one shipped study: each command that it can be given."""
    study, drives = _study(name), list(table["drives"])
    tasks = table.get("tasks", {})
    sessions = [task for task, one in tasks.items() if "type" in one]
    moves = [*table.get("paths", {}), *(task for task in tasks if task not in sessions)]
    found = {
        f"check {name}": _job(("check", study), out=False),
        f"compare {name}": _job(("compare", study)),
        f"contact {name}": _job(("contact", study)),
    }
    for task in sessions:
        found[f"session {name} {task}"] = _job(("session", study, "--task", task), tolerance=IN_TIME)
    for drive in drives if moves else []:
        found[f"simulate {name} {drive}"] = _job(("simulate", study, "--drive", drive), tolerance=IN_TIME)
    for scenario in table.get("scenarios", {}):
        for drive in (drives[0], drives[-1]):
            run = ("simulate", study, "--drive", drive, "--scenario", scenario)
            found[f"simulate {name} {drive} {scenario}"] = _job(run, tolerance=IN_TIME)
    what = "energy" if table.get("duty") else "power" if moves else "coverage"
    for drive in drives[:1] if sessions else [drives[0], drives[-1]]:
        rank = ("sensitivity", study, "--of", what, "--drive", drive)
        found[f"sensitivity {name} {drive}"] = _job(rank, tolerance=IN_TIME)
    return found


def _job(*words: tuple[str, ...], out: bool = True, tolerance: float = STEADY) -> Job:
    """One command of infinivar, with its JSON among the results."""
    command = ("-m", "infinivar", *(word for some in words for word in some), *(("--out", "out") if out else ()))
    return Job((command,), tolerance)


def _calibrate(study: str, drive: str, data: str) -> Job:
    words = ("calibrate", data, "--study", f"{{data}}/{study}.toml", "--drive", drive)
    return _job(words, tolerance=IN_TIME)


def _study(name: str) -> str:
    return f"{{studies}}/{name}.toml"


def _tables() -> dict[str, dict[str, Any]]:
    return {path.stem: tomllib.loads(path.read_text("utf-8")) for path in sorted(STUDIES.glob("*.toml"))}


BENCH = """title = "Transmission on the bench"
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[rig]
current_noise = "20 mA"
mass_deviation = "1 g"
"""

GEARED = """title = "Geared motor on the bench"
[requirement]
base = "faulring2006"
[drives.joint]
base = "faulring2006.motor1-gear1"
[rig]
current_gain_deviation = 0.005
torque_gain_deviation = 0.002
pendulum_mass = "150 g"
pendulum_length = "200 mm"
"""

_RATIO, _RESISTANCE, _CONSTANT, _FRICTION, _SHARE, _ROTOR = 11.0, 2.4, 0.027, 0.015, 0.03, 4.2e-6


def _current(torque: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Of a motor behind a gear whose friction has a constant part and a share of the load. [A]"""
    resisted = np.sign(speed) * (_FRICTION + _SHARE * np.abs(torque))
    return (torque + resisted) / (_RATIO * _CONSTANT)


def _dynamometer() -> str:
    noise = np.random.default_rng(0)
    speed, torque = (part.ravel() for part in np.meshgrid(np.linspace(10, 60, 6), [0.05, 0.15, 0.25]))
    current = _current(torque, speed)
    voltage = _RESISTANCE * current + _CONSTANT * _RATIO * speed
    current, voltage = (one + noise.normal(0.0, size, len(one)) for one, size in ((current, 0.005), (voltage, 0.02)))
    return _csv(["speed [rad/s]", "torque [N m]", "current [A]", "voltage [V]"], speed, torque, current, voltage)


def _swing() -> str:
    noise = np.random.default_rng(1)
    time = np.arange(0.0, 20.0, 0.004)
    parts = [(amplitude, 2.0 * math.pi * frequency) for frequency, amplitude in ((0.5, 1.0), (1.3, 0.3))]
    angle = sum(amplitude * np.sin(rate * time) for amplitude, rate in parts)
    speed = sum(amplitude * rate * np.cos(rate * time) for amplitude, rate in parts)
    faster = sum(-amplitude * rate**2 * np.sin(rate * time) for amplitude, rate in parts)
    inertia = 0.15 * 0.2**2
    load = inertia * faster + 0.15 * 9.80665 * 0.2 * np.sin(angle)
    current = _current(load, np.asarray(speed)) + _ROTOR * _RATIO * faster / _CONSTANT
    current = current + noise.normal(0.0, 0.02, len(time))
    return _csv(["time [s]", "angle [rad]", "current [A]"], time, angle + noise.normal(0.0, 2e-4, len(time)), current)


def _recorded() -> str:
    time = np.arange(0.0, 8.0, 0.01)
    position = 20.0 * np.sin(2.0 * math.pi * 1.1 * time) + np.random.default_rng(3).normal(0.0, 0.05, len(time))
    return _csv(["time [s]", "position [mm]", "force [N]"], time, position, 5.0 * np.cos(2.0 * math.pi * 1.1 * time))


def _csv(heads: list[str], *columns: Any) -> str:
    rows = [",".join(heads), *(",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True))]
    return "\n".join(rows) + "\n"


DATA: Mapping[str, Callable[[], str]] = {
    "bench.toml": lambda: BENCH,
    "geared.toml": lambda: GEARED,
    "dynamometer.csv": _dynamometer,
    "swing.csv": _swing,
    "recorded.csv": _recorded,
}
"""Files that commands read, by name."""
