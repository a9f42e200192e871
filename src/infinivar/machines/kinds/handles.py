"""Where a hand holds each machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infinivar._core.arrays import real_array
from infinivar.errors import ParameterError, require
from infinivar.machines.hand import ArmGrip, BodyGrip, Grip, PointGrip
from infinivar.machines.kinds.rolling import PlanarMechanics, SerialArmMechanics
from infinivar.machines.kinds.slides import SlideLoad
from infinivar.machines.linkage import ArmLoad, LeggedMechanics, PlatformLoad
from infinivar.machines.separate import SeparateMechanics
from infinivar.machines.system import Mechanics


def grip_of(mechanics: Mechanics, handle: Sequence[float] = (0.0, 0.0)) -> Grip:
    """The handle of a machine: a point of a body in the plane, otherwise the origin of a platform, the end point of an arm, or
    the axes of a slide.

    Raises
    ------
    ParameterError
        If the machine has no handle.
    """
    if isinstance(mechanics, PlanarMechanics):
        point = real_array("handle", handle)
        fits = point.shape == (2,) and bool(np.all(np.isfinite(point)))
        require(fits, "handle", f"{handle}", "x and y, two finite numbers", "m")
        return BodyGrip(point=(float(point[0]), float(point[1])))
    require(not np.any(handle), "handle", f"{handle}", "left out: only a body in the plane is held at a point")
    count = len(mechanics.coordinates)
    load = mechanics.load if isinstance(mechanics, (LeggedMechanics, SeparateMechanics, SerialArmMechanics)) else None
    if isinstance(load, PlatformLoad):
        return PointGrip(axes=("x", "y", "z"), coordinates=count)
    if isinstance(load, ArmLoad):
        return ArmGrip(arm=load.arm, coordinates=count)
    if isinstance(load, SlideLoad):
        return PointGrip(axes=load.axes, coordinates=count)
    raise ParameterError(
        "machine must have a handle: a planar cobot, platform, arm or slide; shafts of a sphere have none"
    )
