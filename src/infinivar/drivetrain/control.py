"""Controller settings of a drive: sample rate, bandwidths and current limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from annotated_types import Gt

from infinivar._core.fields import check, quantity
from infinivar.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class CoboticControl:
    """Loops of a cobotic drive: cylinder speed, steering angle, and an outer loop for link position."""

    sample_rate: float = quantity("Hz", Gt(0), "Rate at which controllers sample", default=1000.0)
    cylinder_bandwidth: float = quantity("Hz", Gt(0), "Bandwidth of the cylinder's speed loop", default=4.0)
    steering_bandwidth: float = quantity("Hz", Gt(0), "Bandwidth of the steering servo", default=25.0)
    link_bandwidth: float = quantity("Hz", Gt(0), "Bandwidth of the link's position loop", default=4.0)
    current_limit: float | None = quantity(
        "A", Gt(0), "Current limit of the cylinder motor; default: stall current", default=None
    )
    steering_current_limit: float | None = quantity(
        "A", Gt(0), "Current limit of the steering motor; default: stall current", default=None
    )
    rest_error: float = quantity(
        "m", Gt(0), "How far from its goal a load that is to stand still may be left at rest", default=1e-4
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _slower(self, "cylinder_bandwidth", "steering_bandwidth", "link_bandwidth")


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalControl:
    """Loops of a conventional drive: motor speed, and an outer loop for load position."""

    sample_rate: float = quantity("Hz", Gt(0), "Rate at which controllers sample", default=1000.0)
    speed_bandwidth: float = quantity("Hz", Gt(0), "Bandwidth of the speed loop", default=25.0)
    link_bandwidth: float = quantity("Hz", Gt(0), "Bandwidth of the load's position loop", default=4.0)
    current_limit: float | None = quantity(
        "A", Gt(0), "Current limit of the motor; default: stall current", default=None
    )
    rest_error: float = quantity(
        "m", Gt(0), "How far from its goal a load that is to stand still may be left at rest", default=1e-4
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _slower(self, "speed_bandwidth", "link_bandwidth")


def _slower(control: Any, *names: str) -> None:
    for name in names:
        if not getattr(control, name) <= 0.1 * control.sample_rate:
            raise ParameterError(
                f"{name} must be <= a tenth of sample_rate ({0.1 * control.sample_rate:g} Hz), got {getattr(control, name)}"
            )
