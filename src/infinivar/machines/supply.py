"""A machine on a battery: its operating points with current, loss and limit of the battery."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infinivar.machines.machine import TaskPoint
from infinivar.parts.battery import Battery

CURRENT = "battery_current_A"
"""State: current from the battery, negative where it is charged."""


def source_of(battery: Battery | None) -> str:
    """What feeds a machine with motors."""
    return "supply" if battery is None else "battery"


def fed(point: TaskPoint, battery: Battery | None) -> TaskPoint:
    """The point with power in from the cells of a battery, which loses some in its resistance; as it is without one."""
    if battery is None:
        return point
    found = battery.supply(np.asarray(point.power_in))
    return replace(
        point,
        power_in=found.power,
        losses={**point.losses, "battery": found.loss},
        demands={**point.demands, **{(limit, "battery"): demand for limit, demand in found.utilisation.items()}},
        states={**point.states, CURRENT: found.current},
    )
