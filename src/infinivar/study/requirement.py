"""Requirement on a drive: a maximum force, a maximum speed and a maximum instantaneous power."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from annotated_types import Gt

from infinivar._core.fields import check, component, quantity

_SLOWEST = 1e-9
"""Slowest motion considered, as a share of the largest speed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Requirement:
    """Required region of the force-speed plane: |F| <= force, |v| <= speed, |F v| <= power.

    Without `power`, the required region is the whole rectangle.

    Source: faulring2006, section VI (the shaded region of Fig 15 and Fig 16).
    """

    force: float = quantity("N", Gt(0), "Largest force on the load")
    speed: float = quantity("m/s", Gt(0), "Largest speed of the load")
    power: float | None = quantity(
        "W", Gt(0), "Largest instantaneous power; defaults to force times speed", default=None
    )
    load_mass: float | None = quantity("kg", Gt(0), "Mass of the load, in addition to the drive's own", default=None)
    travel: float | None = quantity("m", Gt(0), "Travel of the load from end to end", default=None)
    quadrants: Literal[1, 2, 4] = component(
        "1: driving one way; 2: driving and braking; 4: both directions of each", default=1
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    def speed_at(self, force: Any) -> Any:
        """Return the largest required speed at a force. [m s^-1]"""
        import numpy as np

        force = np.abs(np.asarray(force, dtype=float))
        if self.power is None:
            return np.full_like(force, self.speed)
        # Avoids overflow at zero force.
        return self.power / np.maximum(force, self.power / self.speed)

    def corners(self) -> dict[str, tuple[float, float]]:
        """Return the named corners of the region, where designs usually fail, as (speed, force). [m s^-1], [N]"""
        slow, fast = float(self.speed_at(self.force)), self.speed
        light = self.force if self.power is None else min(self.force, self.power / fast)
        points = {"maximum force": (slow, self.force)}
        if (fast, light) != (slow, self.force):
            points["maximum speed"] = (fast, light)
        if self.quadrants > 1:
            points |= {f"braking at {name}": (speed, -force) for name, (speed, force) in points.items()}
        return points

    def sample(self, count: int = 201) -> tuple[Any, Any, Any]:
        """Sample the region including its boundary; weight each point by the share of the area it represents.

        Parameters
        ----------
        count : int   Points along the force axis, and along the speed axis at each force.

        Returns
        -------
        speed, force, weight : (m,) float   Include the corners; weights add up to 1. [m s^-1], [N], [-]
        """
        import numpy as np

        corners = sorted({abs(force) for _, force in self.corners().values()})
        force = np.union1d(np.linspace(0.0, self.force, count), corners)
        if len(corners) > 1:
            # Where power limits the region, its width falls as 1/force: use steps proportional to the force.
            force = np.union1d(force, np.geomspace(corners[0], self.force, count)[1:-1])
        reach = self.speed_at(force)
        share = np.linspace(0.0, 1.0, count)
        share[0] = _SLOWEST  # slow motion instead of rest, where friction would help
        weight = (_cell_widths(force) * reach)[:, None] * _cell_widths(share)[None, :]
        speed, force = np.broadcast_arrays(share[None, :] * reach[:, None], force[:, None])
        signs = {1: [(1, 1)], 2: [(1, 1), (1, -1)], 4: [(1, 1), (1, -1), (-1, 1), (-1, -1)]}[self.quadrants]
        return (
            np.concatenate([a * speed.ravel() for a, _ in signs]),
            np.concatenate([b * force.ravel() for _, b in signs]),
            np.tile(weight.ravel(), len(signs)) / (weight.sum() * len(signs)),
        )


def _cell_widths(nodes: Any) -> Any:
    """Return the axis length that each node represents: the weights of the trapezoidal rule."""
    import numpy as np

    half = 0.5 * np.diff(nodes)
    return np.concatenate([half, [0.0]]) + np.concatenate([[0.0], half])
