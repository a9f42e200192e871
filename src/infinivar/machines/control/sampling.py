"""What a study states of the sensors and the sampling of controllers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check, component, quantity
from infinivar.errors import ParameterError, require

if TYPE_CHECKING:
    from infinivar.machines.kind import MovingMachine

SLOWEST, FASTEST = 500.0, 10_000.0
"""Sample rates of controllers. [Hz]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensing:
    """Sensors and sampling of the controllers of a session; by default ideal sensors, sampled at 1 kHz.

    What a controller computes from one sample acts from the next one on. Motors have tachometers that are exact.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    sample_rate: float = quantity(
        "Hz", Interval(ge=SLOWEST, le=FASTEST), "Rate of all controllers, servos included", default=1000.0
    )
    position_resolution: float = quantity("m", Ge(0), "Step of the encoders of lengths; 0: exact", default=0.0)
    angle_resolution: float = quantity("rad", Ge(0), "Step of the encoders of angles; 0: exact", default=0.0)
    steering_resolution: float = quantity("rad", Ge(0), "Step of the steering encoders; 0: exact", default=0.0)
    differenced: bool = component("Whether speeds are differences of what encoders read", default=False)
    speed_filter: float | None = quantity(
        "Hz", Gt(0), "Cut-off of a first-order filter of speeds; by default none", default=None
    )
    force_noise: float = quantity("N", Ge(0), "Standard deviation of the force sensor at each sample", default=0.0)
    force_filter: float | None = quantity(
        "Hz", Gt(0), "Cut-off of a first-order filter of force and moment; by default none", default=None
    )
    seed: int = component("Of the noise", default=0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        whole = isinstance(self.seed, int) and not isinstance(self.seed, bool) and self.seed >= 0
        require(whole, "seed", repr(self.seed), "a whole number, 0 or more")
        for name in ("speed_filter", "force_filter"):
            cut_off = getattr(self, name)
            if cut_off is not None:
                most = 0.5 * self.sample_rate
                require(cut_off < most, name, cut_off, f"below half of sample_rate, {most:g}", "Hz")

    @property
    def period(self) -> float:
        """Time between samples. [s]"""
        return 1.0 / self.sample_rate


def check_rate(machine: MovingMachine, sensing: Sensing) -> None:
    """Raise ParameterError unless the servos of a machine have ten samples in a period of their bandwidth."""
    for name in ("steering_bandwidth", "cylinder_bandwidth", "speed_bandwidth"):
        bandwidth = getattr(machine.control, name, None)
        if bandwidth is not None and not 10.0 * bandwidth <= sensing.sample_rate:
            raise ParameterError(
                f"sensing.sample_rate must be at least ten times control.{name}, {bandwidth:g} Hz, got {sensing.sample_rate:g} Hz"
            )
