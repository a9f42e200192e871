"""What a drive asks of a kind of gear, whatever its loss: one class for each kind, and the two that have one efficiency."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import given
from infinivar._core.frozen import FrozenDict
from infinivar.bondgraph.graph import Law, Parameter
from infinivar.contact.friction import coulomb
from infinivar.limits import Limit

Column = Callable[..., Any]
"""Values of a field of many gearheads: by name, and what stands for those that are not stated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraphLaw:
    """Friction of a gear as the law of an element of a bond graph, over the motor's speed."""

    law: Law
    parameters: Mapping[str, Parameter]
    """All but the stick speed."""
    loaded: bool = True
    """Whether the torque that the gear transmits is the law's second argument."""
    solved: Law | None = None
    """As `infinivar.bondgraph.graph.Element.solved`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Torsion:
    """Torsional spring of a gear at its output: linear, or stiffer beyond corner torques."""

    stiffness: Array
    """From rest on. [N m rad^-1]"""
    corners: tuple[tuple[Array, Array], ...] = ()
    """Torques [N m] in rising order, each with the stiffness beyond it. [N m rad^-1]"""

    def twist(self, torque: Array) -> Array:
        """Angle that the spring turns under a torque. [rad]"""
        angle, softer = torque / self.stiffness, self.stiffness
        xp = namespace(self, torque)
        for corner, stiffness in self.corners:
            angle = angle + (1.0 / stiffness - 1.0 / softer) * (torque - xp.clip(torque, -corner, corner))
            softer = stiffness
        return angle

    def stiffness_at(self, torque: Array) -> Array:
        """Change of the torque per angle. [N m rad^-1]"""
        found: Array = self.stiffness
        xp = namespace(self, torque)
        for corner, stiffness in self.corners:
            found = xp.where(xp.abs(torque) > corner, stiffness, found)
        return found

    @property
    def steepest(self) -> Array:
        """Largest stiffness. [N m rad^-1]"""
        return max([self.stiffness, *(stiffness for _, stiffness in self.corners)])


@dataclass(frozen=True, slots=True, kw_only=True)
class GearLaw(ABC):
    """Law of a kind of gear: all that others ask of it, at the motor.

    Power that the gear transmits is positive while the motor drives. Unless a kind says otherwise, its friction torque is

    .. math:: f = T + c\\,|w| + k\\,|\\tau|, \\qquad k = a_+ - 1 \\;(\\tau w > 0), \\qquad k = 1 - a_- \\;(\\text{else})

    with the torque transmitted, the constant T, the viscous c and the load factors a. A kind states `constant`, `viscous` and
    `load_factors`, or `affine` = False and its own `size`.
    """

    ratio: Array
    """Motor speed over output speed. [-]"""
    motor_torque: Array | None = None
    """Continuous torque of the motor, for what refers to it. [N m]"""

    NEEDS: ClassVar[tuple[str, ...]] = ()
    """Fields of `Gearhead` that only some kinds have and this one requires; the law has them, too."""
    MAY: ClassVar[tuple[str, ...]] = ()
    """The same, optional."""
    WORDS: ClassVar[str] = ""
    """What its loss is, in reports."""
    CHOICE: ClassVar[str] = ""
    """The same as one of two choices where a data sheet states one efficiency; "" for a loss that has more."""
    OF_LOAD: ClassVar[str] = "depends on"
    """How the loss follows the load: "" if it does not."""
    ORIGIN: ClassVar[str] = "depends on the load and the speed"
    """Why some machines in motion do not have it."""
    SEARCHED: ClassVar[tuple[str, ...]] = ()
    """Columns that gearheads of tables must state for a search; empty if they cannot have it behind any motor."""
    MORE: ClassVar[tuple[str, ...]] = ()
    """Further columns that a search takes from tables where they are stated."""

    @property
    def constant(self) -> Array:
        """T. [N m]"""
        return 0.0

    @property
    def viscous(self) -> Array:
        """c. [N m s]"""
        return 0.0

    @property
    def load_factors(self) -> tuple[Array, Array]:
        """Motor torque per load torque, without what does not depend on it: while the motor drives, while the load drives. [-]"""
        return 1.0, 1.0

    @property
    def affine(self) -> bool:
        """Whether the three terms are the whole friction."""
        return True

    @property
    def factored(self) -> bool:
        """Whether the constant and the factors alone are the whole friction."""
        return self.affine and not self.viscous

    @property
    @abstractmethod
    def is_zero(self) -> bool:
        """Whether there is no friction."""

    @property
    def largest_load_factor(self) -> float:
        """Largest motor torque per load torque beyond constant friction, while the motor drives. [-]"""
        return float(self.load_factors[0])

    @property
    def corners(self) -> tuple[tuple[Array, Array], ...]:
        """See `Torsion.corners`."""
        return ()

    def fault(self) -> str | None:
        """Which values of the gearhead exclude each other; None if they agree."""
        return None

    def utilisation(self, output_torque: Array, output_speed: Array) -> Mapping[Limit, Array]:
        """Demand over allowance of limits that only this kind has, as `Gearhead.utilisation`. [-]"""
        return {}

    @property
    def largest_returned(self) -> float:
        """Share of the friction that the load's inertia takes from the load at which the gear jams; inf if it cannot. [-]"""
        return float("inf")

    def size(self, speed: Array, torque: Array) -> Array:
        """Friction in motion, or the largest at rest, >= 0.

        Parameters
        ----------
        speed, torque : (...,) float   Of the motor; of the torque the part that the gear transmits. [rad s^-1], [N m]

        Returns
        -------
        (...,) float   [N m]
        """
        return self.constant + self.beyond_constant(speed, torque)

    def beyond_constant(self, speed: Array, torque: Array) -> Array:
        """What `size` has beyond the constant. [N m]"""
        xp = namespace(self, speed, torque)
        return self.viscous * xp.abs(speed) + _share(speed, torque, self.load_factors)

    def friction_torque(self, speed: Array, torque: Array) -> Array:
        """Friction: opposes the motion, and helps to hold the torque at exactly zero speed; arguments as for `size`. [N m]"""
        return coulomb(speed, self.size(speed, torque), held=torque)

    def load_friction(self, speed: Array, torque: Array, stick_speed: Array | None = None) -> Array:
        """The same of the terms beyond the constant; `stick_speed` as in `infinivar.contact.friction.coulomb`. [N m]"""
        return coulomb(speed, self.beyond_constant(speed, torque), stick_speed, held=torque)

    @abstractmethod
    def without_friction(self) -> Mapping[str, Any]:
        """Fields of `Gearhead` with which it has no loss."""

    @abstractmethod
    def graph_law(self, tag: str) -> GraphLaw:
        """Friction as the law of an element; `tag` marks its symbols."""

    @abstractmethod
    def measured(self) -> Mapping[str, float]:
        """Fields of the `GearFriction` that is closest to it, from which a fit starts."""

    def stated_at(self) -> float | None:
        """Torque whose share (1 - efficiency) is the constant friction; None if no efficiency states it. [N m]"""
        return None

    @classmethod
    def columns(cls, column: Column, motor_torque: Array) -> dict[str, Any]:
        """Fields of many gearheads of tables as one, of those that only some kinds have.

        Parameters
        ----------
        column : callable            Values of a field, and what stands for those not stated.
        motor_torque : (k, 1) float  Continuous torque of their motors. [N m]
        """
        return {name: column(name) for name in cls.NEEDS}

    @classmethod
    def contradictions(cls, column: Column) -> list[tuple[str, np.ndarray]]:
        """What rows of tables state that excludes each other in words, and which rows; `column` as for `columns`."""
        return []


def _share(speed: Array, torque: Array, factors: tuple[Array, Array]) -> Array:
    xp = namespace(speed, torque, *factors)
    load = xp.abs(torque)
    return xp.where(torque * speed > 0, (factors[0] - 1.0) * load, (1.0 - factors[1]) * load)


def coulomb_torque(efficiency: Array, rated_torque: Array) -> Array:
    """Constant friction torque at the motor that gives the stated efficiency at rated torque.

    Parameters
    ----------
    efficiency : (...,) float     At rated torque, in (0, 1]. [-]
    rated_torque : (...,) float   Motor-side torque at which the efficiency is stated. [N m]

    Returns
    -------
    (...,) float   [N m]

    Source: faulring2006, section VI-A.
    """
    return (1.0 - efficiency) * rated_torque


def proportional_friction(
    speed: Array, torque: Array, efficiency: Array, backdriving_efficiency: Array, stick_speed: Array | None = None
) -> Array:
    """Friction torque at the motor of a gear whose loss is proportional to power, in either direction.

    Parameters
    ----------
    speed : (...,) float         Motor speed. [rad s^-1]
    torque : (...,) float        Torque that the gear transmits, at the motor and without friction. [N m]
    efficiency : (...,) float    Efficiency while the motor drives, in (0, 1]. [-]
    backdriving_efficiency : (...,) float   Efficiency while the load drives, in [0, 1]; 0 is a self-locking gear. [-]
    stick_speed : (...,) float   As in `infinivar.contact.friction.coulomb`. [rad s^-1]

    Returns
    -------
    (...,) float   Opposes the motion. At rest it helps to hold the torque, up to the friction when the load drives. [N m]

    Source: definition of efficiency, taken in the direction in which power flows.
    """
    lost = _share(speed, torque, (1.0 / efficiency, backdriving_efficiency))
    return coulomb(speed, lost, stick_speed, held=torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstantLoss(GearLaw):
    """Constant friction torque ``(1 - efficiency) rated_torque`` at the motor.

    Source: faulring2006, section VI-A.
    """

    efficiency: Array
    rated_torque: Array | None

    NEEDS: ClassVar[tuple[str, ...]] = ("efficiency",)
    MAY: ClassVar[tuple[str, ...]] = ("rated_torque",)
    WORDS: ClassVar[str] = "constant torque"
    CHOICE: ClassVar[str] = "constant torque"
    OF_LOAD: ClassVar[str] = ""
    SEARCHED: ClassVar[tuple[str, ...]] = ("efficiency",)
    MORE: ClassVar[tuple[str, ...]] = ("rated_torque",)

    @property
    def constant(self) -> Array:
        """Friction torque; arguments of `coulomb_torque`. [N m]"""
        return coulomb_torque(self.efficiency, given(self.rated_torque, self.motor_torque))

    @property
    def is_zero(self) -> bool:
        """Whether the efficiency is 1."""
        return self.efficiency == 1.0

    def beyond_constant(self, speed: Array, torque: Array) -> Array:
        """Nothing."""
        return 0.0

    def without_friction(self) -> Mapping[str, Any]:
        """An efficiency of 1."""
        return {"efficiency": 1.0}

    def graph_law(self, tag: str) -> GraphLaw:
        """Coulomb friction."""
        size = Parameter(f"{{T_{{g,{tag}}}}}^0", float(self.constant), "N m")
        return GraphLaw(law=coulomb, parameters=FrozenDict(size=size), loaded=False)

    def measured(self) -> Mapping[str, float]:
        """Constant friction."""
        return {"friction": self.ratio * float(self.constant)}

    def stated_at(self) -> float | None:
        """Rated torque. [N m]"""
        return given(self.rated_torque, self.motor_torque)

    @classmethod
    def columns(cls, column: Column, motor_torque: Array) -> dict[str, Any]:
        """Efficiency, and rated torque: that of the motor where none is stated."""
        return {"efficiency": column("efficiency"), "rated_torque": column("rated_torque", motor_torque)}


@dataclass(frozen=True, slots=True, kw_only=True)
class ProportionalLoss(GearLaw):
    """Loss proportional to power: one efficiency while the motor drives, another while the load drives."""

    efficiency: Array
    backdriving_efficiency: Array | None

    NEEDS: ClassVar[tuple[str, ...]] = ("efficiency",)
    MAY: ClassVar[tuple[str, ...]] = ("backdriving_efficiency",)
    WORDS: ClassVar[str] = "proportional to power"
    CHOICE: ClassVar[str] = "share of power"
    OF_LOAD: ClassVar[str] = "is proportional to"
    SEARCHED: ClassVar[tuple[str, ...]] = ("efficiency",)
    MORE: ClassVar[tuple[str, ...]] = ("backdriving_efficiency",)

    @property
    def load_factors(self) -> tuple[Array, Array]:
        """By the efficiencies. [-]"""
        return 1.0 / self.efficiency, self._back

    @property
    def _back(self) -> Array:
        return given(self.backdriving_efficiency, self.efficiency)

    @property
    def is_zero(self) -> bool:
        """Whether both efficiencies are 1."""
        return min(self.efficiency, self._back) == 1.0

    def beyond_constant(self, speed: Array, torque: Array) -> Array:
        """Share of the load. [N m]"""
        return _share(speed, torque, self.load_factors)

    def size(self, speed: Array, torque: Array) -> Array:
        """Share of the load. [N m]"""
        return self.beyond_constant(speed, torque)

    def without_friction(self) -> Mapping[str, Any]:
        """Efficiencies of 1."""
        return {"efficiency": 1.0, "backdriving_efficiency": None}

    def graph_law(self, tag: str) -> GraphLaw:
        """`proportional_friction`."""
        return GraphLaw(
            law=proportional_friction,
            parameters=FrozenDict(
                efficiency=Parameter(rf"\eta_{tag}", self.efficiency),
                backdriving_efficiency=Parameter(rf"\eta'_{tag}", self._back),
            ),
        )

    def measured(self) -> Mapping[str, float]:
        """The load share that gives its efficiency while the motor drives, ``(1 - eta)/(1 + eta)``."""
        share = (1.0 - float(self.efficiency)) / (1.0 + float(self.efficiency))
        return {"load_motor": share, "load_output": share}

    @classmethod
    def columns(cls, column: Column, motor_torque: Array) -> dict[str, Any]:
        """Efficiencies: in both directions alike where only one is stated."""
        efficiency = column("efficiency")
        return {
            "efficiency": efficiency,
            "backdriving_efficiency": column("backdriving_efficiency", efficiency),
        }
