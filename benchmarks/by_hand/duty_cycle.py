"""Inverse dynamics of the shipped cobotic drive over one duty cycle as bare NumPy: power from the supply, nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np


def power_in(p: dict[str, Any], course: dict[str, np.ndarray]) -> np.ndarray:
    """Power from the supply at each instant [W], braking burnt, each motor's by itself."""
    current, steered, phi1, _ = states(p, course)
    return cylinder_power(p, current, p["resistance"]) + steering_power(p, steered, phi1, p["steering_resistance"])


def cylinder_power(p: dict[str, Any], current: np.ndarray, resistance: Any) -> np.ndarray:
    """Power from the supply of the cylinder motor. [W]"""
    return np.maximum(current * voltage(p, current, resistance), 0)


def voltage(p: dict[str, Any], current: np.ndarray, resistance: Any) -> np.ndarray:
    """Voltage of the cylinder motor. [V]"""
    return current * resistance + p["torque_constant"] * p["gear_ratio"] * p["cylinder_speed"]


def steering_power(p: dict[str, Any], current: np.ndarray, rate: np.ndarray, resistance: Any) -> np.ndarray:
    """Power from the supply of the steering motor. [W]"""
    return np.maximum(current * steering_voltage(p, current, rate, resistance), 0)


def steering_voltage(p: dict[str, Any], current: np.ndarray, rate: np.ndarray, resistance: Any) -> np.ndarray:
    """Voltage of the steering motor. [V]"""
    return current * resistance + p["steering_constant"] * p["steering_ratio"] * rate


def states(p: dict[str, Any], course: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    """Currents of cylinder and steering motor, steering rate, and wheel force over slip force."""
    speed, acceleration, jerk, snap = (course[name] for name in ("speed", "acceleration", "jerk", "snap"))
    slip_force = p["friction"] * p["preload"]
    rolling_force = (p["rolling_torque"] + p["bearing_torque"]) / p["wheel_radius"]
    surface_speed = p["cylinder_radius"] * p["cylinder_speed"]
    h, k = rolling_force / slip_force, p["creep_stiffness"] / slip_force
    mass = p["load_mass"] + p["link_mass"]
    guideway = p["guideway_coefficient"] * p["preload"] * np.sign(speed)
    f = (mass * acceleration - course["force"] + guideway) / slip_force
    f1, f2 = (mass * jerk - course["force_rate"]) / slip_force, (mass * snap - course["force_curvature"]) / slip_force
    q, q1, q2 = speed / surface_speed, acceleration / surface_speed, jerk / surface_speed

    t = -q
    for _ in range(50):
        e = (h * t - f * np.sqrt(1 + t * t)) / k
        new = (e - q) / (1 + e * q)
        moved = np.max(np.abs(new - t))
        t = new
        if moved < 1e-9:
            break
    root = np.sqrt(1 + t * t)
    x = h * t - f * root
    e = x / k
    xt = h - f * t / root
    ge, gq = t * q - 1, 1 + t * e
    gt = 1 + e * q + ge * xt / k
    pull = -root * f1
    t1 = -(gq * q1 + ge * pull / k) / gt
    e1 = (xt * t1 + pull) / k
    bend = -(f / (root * root) * t1 * t1 + 2 * t * t1 * f1) / root - root * f2
    t2 = -(ge * bend / k + gq * q2 + 2 * t1 * (e1 * q + e * q1) + 2 * t * e1 * q1) / gt
    along = 1 / (1 + t * t)
    phi1 = t1 * along
    phi2 = t2 * along - 2 * t * phi1 * phi1

    torque = p["cylinder_radius"] * (slip_force * x * t / root + rolling_force / root)
    friction = (1 - p["gear_efficiency"]) * p["continuous_torque"]
    current = (torque / p["gear_ratio"] + friction) / p["torque_constant"] + p["no_load_current"]
    way = np.sign(phi1)
    inertia = p["bell_inertia"] + p["steering_ratio"] ** 2 * p["steering_rotor"]
    steering = (p["steering_friction"] * way + inertia * phi2) / p["steering_ratio"]
    steered = steering / p["steering_constant"] + p["steering_no_load"] * way
    return current, steered, phi1, x
