"""One task of the steady-map benchmark in a process of its own.

Run as ``python -m benchmarks._steady_map_worker parameters|ours|agree parameters.json [coarse.bin]``. The process that
starts it must stay small: on Linux a child's peak memory is never less than its parent's was.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._measure import STUDY
from benchmarks.by_hand import steady_map as by_hand
from infinivar import CoboticDrive, SteadyMap, load_study, steady_map

POINTS = 3000
STRIDE = 10
"""Octave hands over every tenth point along each axis."""
REACH = 1.4
"""The map reaches this far beyond the required force and speed."""

# Outputs in the order of Octave's file.
IN_OCTAVE = (
    *("power_in", "power_out", "limit", "margin", "efficiency"),
    *("winding", "motor friction", "gearhead", "amplifier", "creep", "rolling", "bearing", "guideway"),
)


def _drive() -> CoboticDrive:
    drive = load_study(STUDY).drives["cobotic"]
    assert isinstance(drive, CoboticDrive)
    return drive


def parameters() -> dict[str, Any]:
    """What the scripts compute with.

    Raises
    ------
    RuntimeError
        If there is more to the drive than the scripts know.
    """
    drive, requirement = _drive(), load_study(STUDY).required("the benchmark")
    motor, gear, element, amplifier = drive.motor, drive.gearhead, drive.transmission, drive.amplifier
    known = (
        drive.cylinder_speed > 0,
        element.creep_law.name == "linear",
        element.steering_range >= np.pi / 2,
        gear.loss_model == "coulomb",
        gear.rated_torque is None and gear.continuous_torque is None,
        motor.max_speed is not None,
        drive.guideway.friction == 0,
        amplifier.regeneration == "burn" and amplifier.efficiency == 1 and amplifier.standby_power == 0,
    )
    if not all(known):
        raise RuntimeError("the cobotic drive has changed: the scripts in benchmarks/by_hand must follow")
    groups = element.groups(drive.cylinder_speed)
    return {
        "points": POINTS,
        "stride": STRIDE,
        "top_speed": REACH * requirement.speed,
        "top_force": REACH * requirement.force,
        "cylinder_speed": drive.cylinder_speed,
        "cylinder_radius": element.cylinder_radius,
        "wheel_radius": element.wheel_radius,
        "preload": element.preload,
        "friction": element.friction,
        "creep_stiffness": float(groups.creep_stiffness),
        "rolling_torque": float(groups.rolling_torque),
        "bearing_torque": float(groups.bearing_torque),
        "guideway_coefficient": drive.guideway.coefficient,
        "gear_ratio": gear.ratio,
        "gear_efficiency": gear.efficiency,
        "voltage": motor.voltage,
        "resistance": motor.resistance,
        "torque_constant": motor.torque_constant,
        "no_load_current": motor.no_load_current,
        "continuous_torque": motor.continuous_torque,
        "max_speed": motor.max_speed,
    }


def ours(given: dict[str, Any]) -> dict[str, float]:
    """Seconds of our map, and the peak memory of this process."""
    drive, grid = _drive(), by_hand.axes(given)
    start = time.perf_counter()
    result = steady_map(drive, *grid)
    seconds = time.perf_counter() - start
    assert result.audit_residual < 1e-9
    return {"seconds": seconds, "maxrss": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}


def agree(given: dict[str, Any], coarse: Path) -> dict[str, dict[str, float]]:
    """Largest difference of each output from ours, relative to its value, by rival."""
    grid = by_hand.axes(given)
    result = _outputs(steady_map(_drive(), *grid))
    rivals = {"NumPy": _differences(result, by_hand.steady_map(given, *grid))}
    if coarse.exists():
        fields = np.fromfile(coarse).reshape(len(IN_OCTAVE), len(range(0, POINTS, STRIDE)), -1)
        thinned = {name: values[::STRIDE, ::STRIDE] for name, values in result.items()}
        rivals["Octave"] = _differences(thinned, dict(zip(IN_OCTAVE, fields, strict=True)))
    return rivals


def _outputs(result: SteadyMap) -> dict[str, np.ndarray]:
    names = ("power_in", "power_out", "limit", "margin", "efficiency")
    return {**{name: getattr(result, name) for name in names}, **result.losses}


def _differences(ours: dict[str, np.ndarray], theirs: dict[str, np.ndarray]) -> dict[str, float]:
    """Largest |a - b|/max(|a|, |b|) of each output; inf where only one side is nan, or limit codes differ."""
    if ours.keys() != theirs.keys():
        raise RuntimeError(f"the outputs are not the same: {sorted(ours)}, {sorted(theirs)}")
    worst = {}
    for name, a in ours.items():
        b = theirs[name]
        if name == "limit":
            worst[name] = 0.0 if np.array_equal(a, b) else np.inf
            continue
        undefined = np.isnan(a)
        if not np.array_equal(undefined, np.isnan(b)):
            worst[name] = np.inf
            continue
        a, b = a[~undefined], b[~undefined]
        size = np.maximum(np.abs(a), np.abs(b))
        worst[name] = float(np.max(np.abs(a - b) / np.where(size > 0, size, 1.0), initial=0.0))
    return worst


def main() -> None:
    """Do the task that the command line names; its result goes out as JSON."""
    task, file = sys.argv[1], Path(sys.argv[2])
    if task == "parameters":
        file.write_text(json.dumps(parameters()), encoding="utf-8")
        return
    given = json.loads(file.read_text("utf-8"))
    print(json.dumps(ours(given) if task == "ours" else agree(given, Path(sys.argv[3]))))


if __name__ == "__main__":
    main()
