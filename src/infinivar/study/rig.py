"""The rig on which a transmission is measured: its sensors, and how well its settings are known."""

from __future__ import annotations

from dataclasses import dataclass

from annotated_types import Ge, Gt

from infinivar._core.fields import check, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Rig:
    """A single transmission that lifts and lowers known masses at fixed steering angles, as in the paper's experiment.

    Resolutions are those of one count; deviations are standard deviations. Zero, gain and settings are off by the same
    amount in all runs of a session, noise and counts in each run anew.

    Source: faulring2006, section IV-B.
    """

    cylinder_resolution: float = quantity(
        "rad", Gt(0), "Angle of the cylinder to one count of its encoder", default=5e-5
    )
    link_resolution: float = quantity("m", Gt(0), "Travel of the link to one count of its encoder", default=2e-6)
    steering_resolution: float = quantity("rad", Gt(0), "Steering angle to one count of its encoder", default=5e-5)
    steering_zero_deviation: float = quantity(
        "rad", Ge(0), "Of the steering encoder's zero from the locked state", default=2e-4
    )
    sample_rate: float = quantity("Hz", Gt(0), "Rate at which current and voltage are sampled", default=1000.0)
    current_noise: float = quantity("A", Ge(0), "Of one sample of the motor current", default=0.02)
    current_gain_deviation: float = quantity("1", Ge(0), "Of the current sensor's gain from 1", default=0.005)
    voltage_noise: float = quantity("V", Ge(0), "Of one sample of the motor voltage", default=0.05)
    preload_deviation: float = quantity("1", Ge(0), "Of the preload spring's rate, relative", default=0.01)
    mass_deviation: float = quantity("kg", Ge(0), "Of the balance that weighs the masses", default=1e-3)
    gravity: float = quantity("m/s^2", Gt(0), "Acceleration of free fall where the rig stands", default=9.80665)
    travel: float = quantity("m", Gt(0), "Way of the link over which a run is measured, at most", default=0.2)
    longest_run: float = quantity("s", Gt(0), "Time over which a run is measured, at most", default=2.0)

    def __post_init__(self) -> None:
        """Refuse what is not physical."""
        check(self)
