"""Leg joints over a stride, from published data."""

from __future__ import annotations

import abc
import functools
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core import files
from infinivar._core.fields import check_real, component, given, quantity
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.motion.fourier import Series
from infinivar.motion.motion import PeriodicMotion

_STRIDE_TIME = "Time of one stride (two steps); it does not change the joint angles"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gait(PeriodicMotion):
    """A leg joint over a stride, with the joint torque as the motion's force: `Walking` and `Running`.

    With a `lever_arm` the motion and its force are those of a drive along a line, coupled to the joint by a lever; else they are
    the angle and the moment of the joint. Extension is positive, at the ankle plantarflexion.

    Raises
    ------
    ParameterError
        If a field is outside its range.
    """

    activity: ClassVar[str]
    """The gait, in words."""
    joint: Literal["ankle", "knee", "hip"] = component("Joint: ankle, knee or hip")
    body_mass: float = quantity("kg", Gt(0), "Body mass of the person")
    stride_time: float | None = quantity("s", Gt(0), _STRIDE_TIME, default=None)
    lever_arm: float | None = quantity(
        "m",
        Gt(0),
        "Lever arm of the drive about the joint; without it the motion is about the joint",
        default=None,
    )
    share: float = quantity("1", Interval(gt=0, le=1), "Share of the joint torque that the drive supplies", default=1.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)

    @property
    @abc.abstractmethod
    def data(self) -> dict[str, Any]:
        """Torque per body mass [N m/kg] and speed [rad/s] of the joints as Fourier series, their stride time and source."""

    @property
    def source(self) -> str:
        """Key of the source in the references."""
        return self.data["source"]

    @property
    def period(self) -> float:
        """Time of one cycle. [s]"""
        return given(self.stride_time, self.data["stride_time"])

    @property
    def fastest(self) -> float:
        """Highest frequency in the motion and its force. [Hz]"""
        return (max(len(table["cosine"]) for table in self.data[self.joint].values()) - 1) / self.period

    @property
    def axis(self) -> Axis:
        """Whether the motion is along a line or about the joint."""
        return ROTARY if self.lever_arm is None else LINEAR

    @property
    def _arm(self) -> float:
        """Lever arm [m], or 1 rad per rad about the joint."""
        return 1.0 if self.lever_arm is None else self.lever_arm

    def _series(self, name: str) -> Series:
        table = self.data[self.joint][name]
        return Series(self.period, np.array(table["cosine"]), np.array(table["sine"]))

    def derivatives(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return position [m] and its time derivatives up to an order, at times in 0 to `period` [s]."""
        # A quicker stride turns the joint through the same angles.
        quicker = self.data["stride_time"] / self.period
        return self._series("speed").scaled(self._arm * quicker).integral().derivatives(time, orders)

    def push(self, time: Any, orders: int) -> list[np.ndarray]:
        """Return the joint's force on the load [N] and its derivatives up to an order."""
        factor = -self.body_mass * self.share / self._arm
        return self._series("torque").scaled(factor).derivatives(time, orders)


@dataclass(frozen=True, slots=True, kw_only=True)
class Walking(Gait):
    """A leg joint in level walking: means over walkers. Source: grimmer2014."""

    shape: ClassVar[str] = "walking"
    activity: ClassVar[str] = "level walking"
    stride_time: float = quantity("s", Gt(0), _STRIDE_TIME)

    @property
    def data(self) -> dict[str, Any]:
        """Torque per body mass and speed of the joints, from heel strike."""
        return _stride("walking")


@dataclass(frozen=True, slots=True, kw_only=True)
class Running(Gait):
    """A leg joint in level running at 2.7 m/s: one stride of one runner, of 0.7067 s unless `stride_time` is set.

    Source: duarte2018, with the body of rajagopal2016.
    """

    shape: ClassVar[str] = "running"
    activity: ClassVar[str] = "running at 2.7 m/s"

    @property
    def data(self) -> dict[str, Any]:
        """Torque per body mass and speed of the joints, from foot contact."""
        return _stride("running")


@functools.cache
def _stride(gait: str) -> dict[str, Any]:
    return files.shipped("motion", gait)
