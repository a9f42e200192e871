"""Steady map of one cobotic drive-train as a private NumPy script: whole arrays at once, no package.

Run as ``python steady_map.py parameters.json``; prints seconds and peak memory (getrusage) as JSON.
"""

import json
import resource
import sys
import time
from pathlib import Path

import numpy as np

OK, SLIP, THERMAL, VOLTAGE, SPEED = 0, 1, 2, 3, 5


def axes(p):
    """Load speeds [m/s] and forces [N] of the grid."""
    return np.linspace(0.0, p["top_speed"], p["points"]), np.linspace(0.0, p["top_force"], p["points"])


def steady_map(p, speed, force):
    """Powers and losses [W], efficiency, limit code and margin; speed along the first axis, force along the second."""
    v, f = speed[:, None], force[None, :]
    slip_force = p["friction"] * p["preload"]
    rolling_force = (p["rolling_torque"] + p["bearing_torque"]) / p["wheel_radius"]
    surface_speed = p["cylinder_radius"] * p["cylinder_speed"]  # > 0
    h, k = rolling_force / slip_force, p["creep_stiffness"] / slip_force

    # Steering: t = tan(phi) = (e - q)/(1 + e q), q link over surface speed. The creepage e is small and hardly depends
    # on t: each fixed-point step leaves an error about 200 times smaller than itself.
    # At rest friction takes what it can of the load.
    size = p["guideway_coefficient"] * p["preload"]
    guideway = np.where(v > 0.0, size, -np.minimum(f, size))
    load = (f + guideway) / slip_force
    q = v / surface_speed
    t = -q
    for _ in range(50):
        e = (h * t - load * np.sqrt(1.0 + t * t)) / k
        new = (e - q) / (1.0 + e * q)
        moved = np.max(np.abs(new - t))
        t = new
        if moved < 1e-9:
            break

    # Contact forces and speeds; beyond slip there is no steady motion.
    cosine = 1.0 / np.sqrt(1.0 + t * t)
    sine = t * cosine
    ratio = h * t - load / cosine
    demand = np.abs(ratio)
    ratio = np.where(demand <= 1.0, ratio, np.nan)
    e = ratio / k
    rolling_speed = surface_speed / (cosine + e * sine)
    lateral = slip_force * ratio
    torque = p["cylinder_radius"] * (lateral * sine + rolling_force * cosine)

    # Gear with constant friction torque, motor, amplifier that burns what comes back.
    motor_speed = p["gear_ratio"] * p["cylinder_speed"]
    gear_friction = (1.0 - p["gear_efficiency"]) * p["continuous_torque"]
    current = (torque / p["gear_ratio"] + gear_friction) / p["torque_constant"] + p["no_load_current"]
    voltage = current * p["resistance"] + p["torque_constant"] * motor_speed
    electrical = voltage * current
    power_in = np.maximum(electrical, 0.0)
    power_out = f * v
    shape = power_out.shape
    # What is the same at all points, or at all points of one speed, is not copied.
    losses = {
        "winding": current**2 * p["resistance"],
        "motor friction": np.broadcast_to(p["torque_constant"] * p["no_load_current"] * motor_speed, shape),
        "gearhead": np.broadcast_to(gear_friction * motor_speed, shape),
        "amplifier": np.maximum(-electrical, 0.0),
        "creep": lateral * e * rolling_speed,
        "rolling": p["rolling_torque"] / p["wheel_radius"] * rolling_speed,
        "bearing": p["bearing_torque"] / p["wheel_radius"] * rolling_speed,
        "guideway": guideway * v,
    }

    # The limit that binds is the one with the largest demand over allowance.
    continuous_current = p["continuous_torque"] / p["torque_constant"] + p["no_load_current"]
    worst, limit = demand, np.full(shape, SLIP, dtype=np.int8)
    others = {
        THERMAL: np.abs(current) / continuous_current,
        VOLTAGE: np.abs(voltage) / p["voltage"],
        SPEED: abs(motor_speed) / p["max_speed"],
    }
    for code, used in others.items():
        tighter = used > worst
        limit[tighter] = code
        worst = np.fmax(worst, used)
    limit[worst <= 1.0] = OK
    margin = 1.0 / worst

    # Useful over spent power; on this grid the load never drives.
    useful = (limit == OK) & (power_in > 0) & (power_out >= 0)
    efficiency = np.full(shape, np.nan)
    np.divide(power_out, power_in, out=efficiency, where=useful)
    return {
        "power_in": power_in,
        "power_out": power_out,
        **losses,
        "efficiency": efficiency,
        "limit": limit,
        "margin": margin,
    }


if __name__ == "__main__":
    parameters = json.loads(Path(sys.argv[1]).read_text())
    grid = axes(parameters)
    start = time.perf_counter()
    result = steady_map(parameters, *grid)
    seconds = time.perf_counter() - start
    print(json.dumps({"seconds": seconds, "maxrss": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}))
