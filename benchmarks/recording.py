"""A 60 s recording at 1 kHz through a cobotic and a geared drive with series springs, against bare NumPy of the same equations.

Both sides evaluate the derivatives of the same smoothed series at the same instants, invert the spring, steer the wheel, heat
the windings from a cold start, and compute the energy with warm windings and the limits (``by_hand/recording.py``). Ours also
gives losses by element, the power for holding, verdicts and the energy audit. With reading, both sides read and smooth a CSV
file first; ours also finds out its format, rests, gaps and resolution. A ratio counts only if both agree.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import _dynamic_worker
from benchmarks._measure import Line, in_turn, ratio_line, timed
from benchmarks.by_hand import recording as by_hand
from infinivar import DutyCycle, Output, duty_cycle, inspect_motion
from infinivar.limits import Limit
from infinivar.motion import Recording
from infinivar.parts import Spring
from infinivar.report.saving import save

PAIRS = 9
AGREEMENT = 5e-6
"""Largest accepted relative difference of energies, temperatures and demands, from the same smoothed series. By hand the loss is
constant within a step of the windings; ours keeps what varies within it, 2.3e-6 of the absolute temperature."""
READ_AGREEMENT = 1e-4
"""The same where each side smooths the file itself: by hand the ends of the run are continued in a simpler way."""
CUTOFF = 10.0
"""[Hz]"""
SPRING = 20e3
"""[N/m]"""
LOAD_MASS = 0.8
"""[kg]"""
_PAGE = 2.0
"""Longest time for the page of `infinivar motion`. [s]"""


def run() -> Iterator[Line]:
    """Measure both, and the page on the recording."""
    drives = [
        replace(drive, output=Output(series_spring=Spring(stiffness=SPRING))) for drive in _dynamic_worker.drives()
    ]
    with tempfile.TemporaryDirectory() as directory:
        file = Path(directory) / "log.csv"
        log(file)
        read = Recording.read(str(file), cutoff=CUTOFF, closed=False)
        given = _parameters(drives, DutyCycle(motion=read, load_mass=LOAD_MASS).samples())
        series = [_run(part) for part in (read._motion, read._push)]

        def ours(recording: Recording) -> dict[str, Any]:
            task = DutyCycle(motion=recording, load_mass=LOAD_MASS)
            return {name: duty_cycle(drive, task) for name, drive in zip(("cobotic", "geared"), drives, strict=True)}

        def ours_with_reading() -> dict[str, Any]:
            return ours(Recording.read(str(file), cutoff=CUTOFF, closed=False))

        def theirs() -> dict[str, Any]:
            return by_hand.through_drives(given, read.period, series[0], series[1])

        def theirs_with_reading() -> dict[str, Any]:
            return by_hand.through_drives(given, *by_hand.read(str(file), CUTOFF))

        _agree("", ours(read), theirs(), AGREEMENT)
        _agree(", each with its own reading,", ours_with_reading(), theirs_with_reading(), READ_AGREEMENT)
        for what, one, other, most in (
            ("60 s at 1 kHz, both drives", lambda: ours(read), theirs, 5.0),
            ("the same with reading the file", ours_with_reading, theirs_with_reading, 5.0),
        ):
            a, b = in_turn(timed(one), timed(other), PAIRS)
            yield ratio_line(what, a, b, rival="bare NumPy", at_most=most)
        yield _page(file, Path(directory) / "out")


def log(file: Path) -> None:
    """Write a synthetic log: some slow waves, noise, and a force with a stiffness and a tremor, so that nothing ever rests."""
    time = np.arange(60_001) * 1e-3
    random = np.random.default_rng(2)
    waves = [(30.0, 0.35, 0.0), (10.0, 0.9, 1.0), (4.0, 1.7, 2.0), (1.0, 3.1, 0.5)]
    position = sum(size * np.sin(2.0 * np.pi * rate * time + phase) for size, rate, phase in waves)
    force = -5.0 - 0.1 * position + 0.4 * np.sin(2.0 * np.pi * 4.3 * time) + random.normal(0.0, 0.01, time.size)
    rows = np.column_stack([time, position + random.normal(0.0, 0.005, time.size), force])
    np.savetxt(file, rows, delimiter=",", header="Time (s),Pos (mm),Fz (N)", comments="", fmt="%.6g")


def _parameters(drives: list[Any], instants: int) -> dict[str, Any]:
    cobotic, geared = drives
    steering = cobotic.steering.motor
    return {
        **_dynamic_worker.parameters(),
        "instants": instants,
        "spring": SPRING,
        "load_mass": LOAD_MASS,
        "steering_voltage": steering.voltage,
        "steering_max_speed": steering.max_speed,
        "large_max_speed": geared.motor.max_speed,
        "heat": {
            name: {
                "resistance": motor.resistance,
                "inner": motor.winding_to_housing,
                "outer": motor.housing_to_ambient,
                "winding_lag": motor.winding_time_constant,
                "housing_lag": motor.housing_time_constant,
                "permissible": motor.max_winding_temperature,
            }
            for name, motor in (("motor", cobotic.motor), ("steering", steering), ("large", geared.motor))
        },
    }


def _run(smoothed: Any) -> by_hand.Run:
    """The smoothed series of a recording, for the other side.

    Raises
    ------
    RuntimeError
        If the recording rests, which the other side does not know.
    """
    if len(smoothed.stays) or len(smoothed.steady):
        raise RuntimeError("the recording rests: the script in benchmarks/by_hand must follow")
    series = smoothed.series
    waves = series.series
    return by_hand.Run(
        series.lead, waves.period, np.asarray(waves.cosine), np.asarray(waves.sine), np.array(series.polynomial)
    )


def _outcomes(found: dict[str, Any]) -> dict[str, dict[str, float]]:
    """What the other side computes, of our results."""
    wanted = {
        (Limit.VOLTAGE, "motor"): "voltage",
        (Limit.SPEED, "motor"): "speed",
        (Limit.VOLTAGE, "steering motor"): "steering voltage",
        (Limit.SPEED, "steering motor"): "steering speed",
        (Limit.SLIP, "wheel"): "slip",
    }
    return {
        name: {
            "energy": one.energy,
            "winding": one.heat["motor"].winding,
            **({"steering winding": one.heat["steering motor"].winding} if "steering motor" in one.heat else {}),
            **{wanted[key]: demand for key, demand in one.demands.items() if key in wanted},
        }
        for name, one in found.items()
    }


def _agree(how: str, ours: dict[str, Any], theirs: dict[str, Any], most: float) -> None:
    here = _outcomes(ours)
    if {name: set(one) for name, one in here.items()} != {name: set(one) for name, one in theirs.items()}:
        raise RuntimeError(f"the outcomes are not the same: {here}, {theirs}")
    worst = max(abs(value - theirs[name][key]) / abs(value) for name, one in here.items() for key, value in one.items())
    print(f"recording: NumPy by hand{how} agrees within {worst:.0e}")
    if not worst <= most:
        raise RuntimeError(f"NumPy by hand does not compute the same: {worst:g}; {here}, {theirs}")


def _page(file: Path, out: Path) -> Line:
    """Time of the page on the recording, with its plots."""

    def seconds() -> float:
        start = time.perf_counter()
        save(inspect_motion(file, load_mass=LOAD_MASS), out)
        return time.perf_counter() - start

    seconds()
    best = min(seconds() for _ in range(3))
    return Line(
        what="page on the recording",
        ours=f"{best:.3g} s",
        theirs="",
        ratio="",
        target=f"<= {_PAGE:g} s",
        passed=best <= _PAGE,
    )
