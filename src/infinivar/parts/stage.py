"""Output stages of a geared drive: what pulley, screw, belt, rack and shaft have in common, and the plain shaft."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, quantity
from infinivar.axis import LINEAR, ROTARY, Axis
from infinivar.contact.friction import coulomb
from infinivar.limits import Limit


def stage_friction(
    speed: Array, torque: Array, efficiency: Array, backdriving_efficiency: Array, friction_torque: Array
) -> Array:
    """Friction torque at the shaft of a stage: a part proportional to the load, and a constant part.

    Parameters
    ----------
    speed : (...,) float             Shaft speed. [rad s^-1]
    torque : (...,) float            Torque at the shaft without friction. [N m]
    efficiency : (...,) float        Efficiency while the shaft drives, in (0, 1], without the constant part. [-]
    backdriving_efficiency : (...,) float   The same while the load drives, <= 1; at 0 and below the stage is
        self-locking: a negative value is the power that the shaft must supply, over the power of the load. [-]
    friction_torque : (...,) float   Constant part, >= 0. [N m]

    Returns
    -------
    (...,) float   Opposes the motion. At rest it helps to hold the torque, up to the friction when the load drives. [N m]

    Source: definition of efficiency, taken in the direction in which power flows; Coulomb's law.
    """
    xp = namespace(speed, torque, efficiency, backdriving_efficiency, friction_torque)
    load = xp.abs(torque)
    lost = xp.where(torque * speed > 0, (1.0 / efficiency - 1.0) * load, (1.0 - backdriving_efficiency) * load)
    return coulomb(speed, lost + friction_torque, held=torque)


class OutputStage:
    """Base of the stages between the gearhead's output shaft and the load.

    Subclasses are dataclasses with a field `friction_torque` [N m]. They set `title`, define `travel_per_radian` and, where
    they apply, the other properties.
    """

    __slots__ = ()

    title: ClassVar[str]
    """Key of the stage in studies, and of its loss in results."""
    letter: ClassVar[str]
    """Subscript of its symbols in a bond graph."""
    axis: ClassVar[Axis] = LINEAR
    friction_torque: float

    @property
    def travel_per_radian(self) -> Array:
        """Travel of the load per angle of the shaft. [m/rad]; of a shaft: 1."""
        raise NotImplementedError

    @property
    def efficiencies(self) -> tuple[Array, Array] | None:
        """Efficiencies while the shaft drives and while the load drives, without constant friction; None if lossless. [-]"""
        return None

    @property
    def own_inertia(self) -> float | None:
        """Moment of inertia of the stage at its shaft, beyond that stated for the gear output; None if not stated. [kg m^2]"""
        return None

    @property
    def stiffness(self) -> Array | None:
        """Stiffness in series with the load, at the load; None if rigid. [N/m]"""
        return None

    @property
    def shaft_friction(self) -> Array:
        """Coulomb friction torque at the shaft: as stated, and of bearings under a stated pull. [N m]"""
        bearings = getattr(self, "bearings", None)
        return self.friction_torque if bearings is None else self.friction_torque + bearings.friction_torque

    def without_friction(self) -> Any:
        """The stage without losses."""
        bare = {"bearings": None} if getattr(self, "bearings", None) is not None else {}
        return replace(self, friction_torque=0.0, **bare)  # type: ignore[type-var]

    def utilisation(self, *, force: Array, speed: Array) -> dict[Limit, Array]:
        """Demand over allowance of the stage's limits at a force and speed of the load; empty if none is known. [-]"""
        return {}

    def friction(self, *, speed: Array, torque: Array) -> Array:
        """Friction torque at a shaft speed and a torque without friction; see `stage_friction`. [N m]"""
        if self.efficiencies is None:
            return coulomb(speed, self.shaft_friction, held=torque)
        return stage_friction(speed, torque, *self.efficiencies, self.shaft_friction)

    def operate(self, *, force: Array, speed: Array) -> tuple[Array, Array, Array]:
        """Shaft torque and speed for a force and speed of the load; at rest, friction helps to hold.

        Parameters
        ----------
        force, speed : (...,) float   At the load, power positive to the load. [N], [m s^-1]

        Returns
        -------
        torque, speed, loss : (...,) float   Torque and speed at the shaft, loss in the stage. [N m], [rad s^-1], [W]

        Source: faulring2006, Fig 14 (transformer r_pulley); friction: see `stage_friction`.
        """
        turning = speed / self.travel_per_radian
        torque = force * self.travel_per_radian
        friction = self.friction(speed=turning, torque=torque)
        return torque + friction, turning, friction * turning


def force_limit(force: Array, permissible: float | None) -> dict[Limit, Array]:
    """Utilisation of a permissible force or torque; empty if that is not known. [-]"""
    if permissible is None:
        return {}
    return {Limit.OUTPUT_FORCE: namespace(force).abs(force) / permissible}


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaft(OutputStage):
    """Rotary output: the gearhead's output shaft turns the load. Speeds are in rad/s, forces are moments in N m."""

    title: ClassVar[str] = "shaft"
    letter: ClassVar[str] = "o"
    axis: ClassVar[Axis] = ROTARY

    friction_torque: float = quantity(
        "N m", Ge(0), "Coulomb friction torque of the shaft's bearings and seals", default=0.0
    )
    permissible_torque: float | None = quantity("N m", Gt(0), "Permissible torque", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def travel_per_radian(self) -> float:
        """1: the load turns with the shaft."""
        return 1.0

    def utilisation(self, *, force: Array, speed: Array) -> dict[Limit, Array]:
        """Demand over allowance of the permissible torque; see `OutputStage.utilisation`. [-]"""
        return force_limit(force, self.permissible_torque)
