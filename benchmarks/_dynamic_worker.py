"""One task of the benchmark of dynamics: ``python -m benchmarks._dynamic_worker parameters|ours parameters.json result.bin``."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import _steady_map_worker
from infinivar.analysis.cycles.shaking import SAMPLES, dynamic_map
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.paper.claims.planes import PLANES
from infinivar.study.load import shipped_study

_PLANE = PLANES["fine", "linear"]


def drives() -> tuple[CoboticDrive, ConventionalDrive]:
    """The two that Fig 17 compares."""
    cobotic, conventional = (shipped_study("faulring2006").drives[name] for name in ("cobotic", "motor2-gear4"))
    assert isinstance(cobotic, CoboticDrive)
    assert isinstance(conventional, ConventionalDrive)
    return cobotic, conventional


def parameters() -> dict[str, Any]:
    """What the scripts compute with."""
    cobotic, conventional = drives()
    requirement = shipped_study("faulring2006").required("the benchmark")
    steering = cobotic.steering
    assert steering is not None
    motor = conventional.motor
    return {
        **_steady_map_worker.parameters(),
        "frequency": _PLANE.frequency.tolist(),
        "fraction": _PLANE.fraction.tolist(),
        "samples": SAMPLES,
        "power": requirement.power,
        "load_mass": requirement.load_mass,
        "link_mass": cobotic.link_mass,
        "bell_inertia": steering.bell_inertia,
        "steering_ratio": steering.ratio,
        "steering_rotor": steering.motor.rotor_inertia,
        "steering_constant": steering.motor.torque_constant,
        "steering_resistance": steering.motor.resistance,
        "steering_no_load": steering.motor.no_load_current,
        "steering_friction": sum(map(float, steering.friction_torques(cobotic.transmission).values())),
        "drag": conventional.guideway.friction,
        "pulley_radius": conventional.stage.travel_per_radian,
        "output_inertia": conventional.output_inertia,
        "large_ratio": conventional.gearhead.ratio,
        "large_efficiency": conventional.gearhead.efficiency,
        "large_torque": motor.continuous_torque,
        "large_rotor": motor.rotor_inertia,
        "large_constant": motor.torque_constant,
        "large_resistance": motor.resistance,
        "large_no_load": motor.no_load_current,
    }


def ours(given: dict[str, Any], result: Path) -> dict[str, float]:
    """Seconds of both maps; performances go to a file."""
    both = drives()
    options = {"power": given["power"], "load_mass": given["load_mass"]}
    start = time.perf_counter()
    maps = [dynamic_map(drive, _PLANE.frequency, _PLANE.fraction, **options) for drive in both]
    seconds = time.perf_counter() - start
    np.array([found.unlimited for found in maps]).tofile(result)
    return {"seconds": seconds}


def main() -> None:
    """Do the task that the command line names; its result goes out as JSON."""
    task, file, result = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    if task == "parameters":
        file.write_text(json.dumps(parameters()), encoding="utf-8")
    else:
        print(json.dumps(ours(json.loads(file.read_text("utf-8")), result)))


if __name__ == "__main__":
    main()
