"""Sampled control of drives and machines: settings of a drive here, its loops and the controllers of one axis beside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from annotated_types import Gt

from infinivar._core.fields import check, given, quantity
from infinivar.errors import ParameterError

SPEED_BANDWIDTH = 25.0
LINK_BANDWIDTH = 4.0
"""Default bandwidths of a geared drive that is rigid. [Hz]"""


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
        _slower(self, cylinder_bandwidth=None, steering_bandwidth=None, link_bandwidth=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionalControl:
    """Loops of a conventional drive: motor speed, and an outer loop for load position."""

    sample_rate: float = quantity("Hz", Gt(0), "Rate at which controllers sample", default=1000.0)
    speed_bandwidth: float | None = quantity(
        "Hz",
        Gt(0),
        "Bandwidth of the speed loop; default: 25 Hz, or half of what is stable with a compliant gearhead or stage",
        default=None,
    )
    link_bandwidth: float | None = quantity(
        "Hz",
        Gt(0),
        "Bandwidth of the load's position loop; default: 4 Hz, or 0.16 of a slower speed loop",
        default=None,
    )
    current_limit: float | None = quantity(
        "A", Gt(0), "Current limit of the motor; default: stall current", default=None
    )
    rest_error: float = quantity(
        "m", Gt(0), "How far from its goal a load that is to stand still may be left at rest", default=1e-4
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        _slower(self, speed_bandwidth=SPEED_BANDWIDTH, link_bandwidth=LINK_BANDWIDTH)


def _slower(control: Any, **defaults: float | None) -> None:
    for name, usual in defaults.items():
        value = getattr(control, name) if usual is None else given(getattr(control, name), usual)
        if not value <= 0.1 * control.sample_rate:
            raise ParameterError(
                f"{name} must be <= a tenth of sample_rate ({0.1 * control.sample_rate:g} Hz), got {value}"
            )
