"""Requirement on a drive: a maximum force, a maximum speed and a maximum instantaneous power."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from annotated_types import Gt

from infinivar._core.fields import check, component, quantity
from infinivar.axis import LINEAR, ROTARY, Axis

Quadrants = Literal[1, 2, 4]

_QUADRANTS = "1: driving one way; 2: driving and braking; 4: both directions of each"

_SLOWEST = 1e-9
"""Slowest motion considered, as a share of the largest speed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Requirement:
    """Required region of the force-speed plane: |F| <= force, |v| <= speed, |F v| <= power.

    Without `power`, the required region is the whole rectangle. About a joint (`axis` is ROTARY) `force` is a moment [N m],
    `speed` an angular speed [rad/s], `load_mass` a moment of inertia [kg m^2] and `travel` an angle [rad];
    `JointRequirement` has these words.

    Source: faulring2006, section VI (the shaded region of Fig 15 and Fig 16).
    """

    force: float = quantity("N", Gt(0), "Largest force on the load")
    speed: float = quantity("m/s", Gt(0), "Largest speed of the load")
    power: float | None = quantity(
        "W", Gt(0), "Largest instantaneous power; defaults to force times speed", default=None
    )
    load_mass: float | None = quantity("kg", Gt(0), "Mass of the load, in addition to the drive's own", default=None)
    travel: float | None = quantity("m", Gt(0), "Travel of the load from end to end", default=None)
    quadrants: Quadrants = component(_QUADRANTS, default=1)
    axis: Axis = field(default=LINEAR)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def stated(self) -> Requirement | JointRequirement:
        """The requirement in the words of its axis, as a study states it."""
        if not self.axis.rotary:
            return self
        return JointRequirement(**self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers under the names of their keys in a study, for scripts."""
        named = {"force": self.force, "speed": self.speed, "power": self.power}
        named |= {"load_mass": self.load_mass, "travel": self.travel, "quadrants": self.quadrants}
        return {_JOINT_KEYS.get(key, key): value for key, value in named.items()} if self.axis.rotary else named

    def speed_at(self, force: Any) -> Any:
        """Return the largest required speed at a force. [m s^-1]"""
        import numpy as np

        force = np.abs(np.asarray(force, dtype=float))
        if self.power is None:
            return np.full_like(force, self.speed)
        # Avoids overflow at zero force.
        return self.power / np.maximum(force, self.power / self.speed)

    def contains(self, speed: Any, force: Any) -> Any:
        """Whether points of the plane are in the required region, in the quadrants required. [m s^-1], [N]"""
        import numpy as np

        speed, force = np.broadcast_arrays(np.asarray(speed, dtype=float), np.asarray(force, dtype=float))
        inside = (np.abs(force) <= self.force) & (np.abs(speed) <= self.speed_at(force))
        if self.quadrants < 4:
            inside = inside & (speed >= 0.0)
        return inside & (force >= 0.0) if self.quadrants == 1 else inside

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


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRequirement:
    """Required region about a joint: |M| <= moment, |w| <= angular_speed, |M w| <= power.

    `requirement` is the same in the terms that all analyses use.
    """

    moment: float = quantity("N m", Gt(0), "Largest moment on the load")
    angular_speed: float = quantity("rad/s", Gt(0), "Largest angular speed of the load")
    power: float | None = quantity(
        "W", Gt(0), "Largest instantaneous power; defaults to moment times angular speed", default=None
    )
    load_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Moment of inertia of the load about the joint, in addition to the drive's own", default=None
    )
    angle: float | None = quantity("rad", Gt(0), "Angle that the joint turns from end to end", default=None)
    quadrants: Quadrants = component(_QUADRANTS, default=1)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def requirement(self) -> Requirement:
        """The same, with `axis` ROTARY."""
        return Requirement(
            force=self.moment,
            speed=self.angular_speed,
            power=self.power,
            load_mass=self.load_inertia,
            travel=self.angle,
            quadrants=self.quadrants,
            axis=ROTARY,
        )


_JOINT_KEYS = {"force": "moment", "speed": "angular_speed", "load_mass": "load_inertia", "travel": "angle"}
"""Keys about a joint by the key along a line."""

LINE_ONLY, JOINT_ONLY = tuple(_JOINT_KEYS), tuple(_JOINT_KEYS.values())
"""Keys of a requirement along a line only, and about a joint only."""


def _cell_widths(nodes: Any) -> Any:
    """Return the axis length that each node represents: the weights of the trapezoidal rule."""
    import numpy as np

    half = 0.5 * np.diff(nodes)
    return np.concatenate([half, [0.0]]) + np.concatenate([[0.0], half])
