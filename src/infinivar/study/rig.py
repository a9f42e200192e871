"""Test rig for a drive: its sensors, and how accurately its settings are known."""

from __future__ import annotations

from dataclasses import dataclass

from annotated_types import Ge, Gt

from infinivar._core.fields import check, quantity
from infinivar.units import STANDARD_GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class Rig:
    """Test rig: one transmission lifts and lowers known masses at fixed steering angles, as in the paper's experiment.

    A resolution is one count; a deviation is a standard deviation. Errors of zero, gain and settings stay the same in all
    runs of a session; noise and rounding to counts differ from run to run.

    Source: faulring2006, section IV-B.
    """

    cylinder_resolution: float = quantity("rad", Gt(0), "Cylinder angle per encoder count", default=5e-5)
    link_resolution: float = quantity("m", Gt(0), "Link travel per encoder count", default=2e-6)
    steering_resolution: float = quantity("rad", Gt(0), "Steering angle per encoder count", default=5e-5)
    steering_zero_deviation: float = quantity(
        "rad", Ge(0), "Deviation of the steering encoder's zero from the locked state", default=2e-4
    )
    sample_rate: float = quantity("Hz", Gt(0), "Sampling rate of current and voltage", default=1000.0)
    current_noise: float = quantity("A", Ge(0), "Noise of one motor current sample", default=0.02)
    current_gain_deviation: float = quantity("1", Ge(0), "Deviation of the current sensor's gain from 1", default=0.005)
    torque_gain_deviation: float = quantity(
        "1", Ge(0), "Deviation of a dynamometer's torque gain from 1", default=0.002
    )
    voltage_noise: float = quantity("V", Ge(0), "Noise of one motor voltage sample", default=0.05)
    preload_deviation: float = quantity("1", Ge(0), "Relative deviation of the preload spring's rate", default=0.01)
    mass_deviation: float = quantity("kg", Ge(0), "Deviation of the balance that weighs the masses", default=1e-3)
    gravity: float = quantity("m/s^2", Gt(0), "Gravitational acceleration at the rig", default=STANDARD_GRAVITY)
    pendulum_mass: float | None = quantity("kg", Gt(0), "Mass of a pendulum on a geared drive", default=None)
    pendulum_length: float | None = quantity(
        "m", Gt(0), "Distance of the pendulum's centre of mass from the axis", default=None
    )
    pendulum_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Inertia of the pendulum about the axis; by default mass times length squared", default=None
    )
    travel: float = quantity("m", Gt(0), "Longest link travel measured in a run", default=0.2)
    longest_run: float = quantity("s", Gt(0), "Longest time measured in a run", default=2.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
