"""Where the rollers of a spherical transmission stand: drive rollers on two shafts, steered rollers and idlers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from infinivar._core.arrays import real_array
from infinivar.errors import ParameterError, require

LayoutName = Literal["tetrahedral", "cubic"]

_EXACT = 1e-4
"""Error of unit vectors, of right angles and of the balance of preloads that counts as rounding of what was typed. [-]"""

_FLAT = 1e-3
"""Least singular value of positions over the largest with which rollers hold the sphere in all directions. [-]"""

_ALIGNED = 1e-4
"""Least angle between the planes that steered and driven rollers leave to the axis. [rad]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Roller:
    """One roller on the sphere.

    Attributes
    ----------
    position : x, y, z    Unit vector from the centre of the sphere to the contact.
    axis : x, y, z        Unit vector along a fixed axle, at a right angle to `position`; None: the roller is steered.
    shaft : 1, 2 or None  Shaft of a drive roller; a roller with a fixed axle and without a shaft is an idler.

    Raises
    ------
    ParameterError
        If a vector is not a unit vector, the axle is not tangential, or a steered roller has a shaft.
    """

    position: Sequence[float]
    axis: Sequence[float] | None = None
    shaft: Literal[1, 2] | None = None

    def __post_init__(self) -> None:
        """Validate the fields and store vectors of exact length 1."""
        position = _unit("position", self.position)
        object.__setattr__(self, "position", tuple(map(float, position)))
        known = self.shaft is None or (type(self.shaft) is int and self.shaft in (1, 2))
        require(known, "shaft", repr(self.shaft), "1, 2 or None")
        if self.axis is None:
            if self.shaft is not None:
                raise ParameterError(f"axis is missing: the drive roller of shaft {self.shaft} needs a fixed axle")
            return
        axis = _unit("axis", self.axis)
        off = float(position @ axis)
        require(abs(off) <= _EXACT, "axis", tuple(map(float, axis)), "at a right angle to position")
        axis = axis - off * position
        object.__setattr__(self, "axis", tuple(map(float, axis / np.linalg.norm(axis))))

    @property
    def kind(self) -> str:
        """ "drive", "steering" or "idler"."""
        return "steering" if self.axis is None else "idler" if self.shaft is None else "drive"


def _unit(name: str, given: Any) -> np.ndarray:
    vector = real_array(name, given)
    require(vector.shape == (3,), name, f"shape {vector.shape}", "three numbers x, y and z")
    length = float(np.linalg.norm(vector))
    require(abs(length - 1.0) <= _EXACT, name, f"one of length {length:.6g}", "a unit vector")
    return vector / length


_DRIVES = (
    Roller(position=(1.0, 0.0, 0.0), axis=(0.0, -1.0, 0.0), shaft=1),
    Roller(position=(0.0, 1.0, 0.0), axis=(-1.0, 0.0, 0.0), shaft=2),
)

LAYOUTS: Mapping[str, tuple[Roller, ...]] = {
    "tetrahedral": (
        *_DRIVES,
        Roller(position=(-0.5, -0.5, math.sqrt(0.5))),
        Roller(position=(-0.5, -0.5, -math.sqrt(0.5))),
    ),
    "cubic": (
        *_DRIVES,
        Roller(position=(-1.0, 0.0, 0.0), axis=(0.0, -1.0, 0.0)),
        Roller(position=(0.0, -1.0, 0.0), axis=(-1.0, 0.0, 0.0)),
        Roller(position=(0.0, 0.0, 1.0)),
        Roller(position=(0.0, 0.0, -1.0)),
    ),
}
"""Drive rollers a quarter turn apart at x and y. Tetrahedral: two steered rollers, such that equal preloads balance. Cubic: two
idlers opposite to the drive rollers, and two steered rollers at right angles to all others."""


def basis(rollers: Sequence[Roller]) -> tuple[np.ndarray, np.ndarray]:
    """Axes of rotation p, at which shaft 1 stands still, and q, a quarter turn from it, in the plane of all fixed axles."""
    first = next(one for one in rollers if one.shaft == 1)
    return np.array(first.position), -np.array(first.axis)


def check_rollers(rollers: Sequence[Roller], preloads: Sequence[float]) -> None:
    """Check that rollers hold the sphere, that their preloads balance, and that it can roll on all of them.

    Raises
    ------
    ParameterError
        Otherwise; the message says what is wrong and what would be right.
    """
    for one in rollers:
        if not isinstance(one, Roller):
            raise ParameterError(f"rollers must be Roller, got {one!r}")
    for shaft in (1, 2):
        if not any(one.shaft == shaft for one in rollers):
            raise ParameterError(f"rollers have none on shaft {shaft}: each shaft needs a drive roller")
    if not any(one.kind == "steering" for one in rollers):
        raise ParameterError("rollers have no steered one (without axis): nothing determines the axis of the sphere")
    positions = np.array([one.position for one in rollers])
    for place, one in enumerate(positions):
        near = np.linalg.norm(positions[:place] - one, axis=1)
        if np.any(near < _EXACT):
            raise ParameterError(f"rollers {int(np.argmin(near)) + 1} and {place + 1} have the same position")
    values = np.linalg.svd(positions, compute_uv=False)
    if len(values) < 3 or values[-1] < _FLAT * values[0]:
        raise ParameterError(
            "positions of all rollers lie in one plane with the centre: nothing holds the sphere across it"
        )
    loads = np.array(preloads)
    missing = loads @ positions
    if np.linalg.norm(missing) > _EXACT * loads.max():
        said = ", ".join(f"{one:.4g}" for one in missing)
        raise ParameterError(
            f"preloads of the rollers do not balance: their sum is ({said}) N; choose positions and preloads with the sum 0"
        )
    _check_axles(rollers)


def _check_axles(rollers: Sequence[Roller]) -> None:
    p, q = basis(rollers)
    normal = np.cross(p, q)
    for place, one in enumerate(rollers):
        if one.axis is None:
            continue
        across = np.cross(one.position, one.axis)
        if abs(abs(float(across @ normal)) - 1.0) > _ALIGNED**2:
            raise ParameterError(
                f"roller {place + 1} does not roll with the others: position and axis of all rollers with a fixed axle must "
                "lie in one plane, that of the axis of the sphere"
            )
    for shaft in (1, 2):
        axes = np.array([one.axis for one in rollers if one.shaft == shaft])
        if np.max(np.abs(axes - axes[0])) > _ALIGNED:
            raise ParameterError(f"rollers of shaft {shaft} must have the same axis, got {len(axes)} that differ")
    second = next(one for one in rollers if one.shaft == 2)
    if abs(float(np.array(second.axis) @ p)) < _ALIGNED:
        raise ParameterError(
            "axes of the drive rollers of both shafts are parallel: the ratio would not depend on the steering"
        )
