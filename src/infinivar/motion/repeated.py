"""A sampled cycle of motion or force as a periodic spline, for scenarios that repeat it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from infinivar.axis import LINEAR, Axis
from infinivar.motion.motion import MotionState


class Repeated:
    """A motion or force of a duty cycle for a scenario: a periodic cubic spline, quick at single instants."""

    shape: ClassVar[str] = "duty cycle"
    breaks: Sequence[float] = ()

    def __init__(self, period: float, values: np.ndarray, axis: Axis = LINEAR) -> None:
        """From values at equal steps over a cycle."""
        from scipy.interpolate import CubicSpline

        self.axis: Axis = axis
        self.period: float = period
        self.step: float = period / len(values)
        nodes = np.arange(len(values) + 1) * self.step
        self.pieces: list[list[float]] = CubicSpline(
            nodes, np.append(values, values[0]), bc_type="periodic"
        ).c.T.tolist()

    def __eq__(self, other: object) -> bool:
        """Whether the other repeats the same spline."""
        return isinstance(other, Repeated) and vars(self) == vars(other)

    def at(self, time: float) -> MotionState:
        """Value and its first two derivatives at a time [s]."""
        since = time % self.period
        place = min(int(since / self.step), len(self.pieces) - 1)
        s = since - place * self.step
        cubic, square, linear, constant = self.pieces[place]
        return MotionState(
            constant + s * (linear + s * (square + s * cubic)),
            linear + s * (2.0 * square + 3.0 * s * cubic),
            2.0 * square + 6.0 * s * cubic,
        )

    def value(self, time: float) -> float:
        """Force at a time. [N]"""
        return self.at(time)[0]

    def rate(self, time: float) -> float:
        """Slope of the force over time. [N s^-1]"""
        return self.at(time)[1]
