"""Fixed-ratio gearhead: two loss models derived from one efficiency, and measured friction; none creates power."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.chain_rule import is_zero
from infinivar._core.fields import check, check_choice, component, given, quantity
from infinivar.contact.friction import coulomb
from infinivar.errors import ParameterError
from infinivar.limits import Limit
from infinivar.parts.gear_friction import GearFriction, stribeck_friction, terms

LossModel = Literal["coulomb", "proportional", "stribeck"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GearPoint:
    """Motor side of a gearhead at an output torque and speed; arrays that broadcast to one shape, SI."""

    motor_torque: Array
    motor_speed: Array
    loss: Array
    utilisation: Mapping[Limit, Array]


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
    xp = namespace(speed, torque, efficiency, backdriving_efficiency, stick_speed)
    load = xp.abs(torque)
    lost = xp.where(torque * speed > 0, (1.0 / efficiency - 1.0) * load, (1.0 - backdriving_efficiency) * load)
    return coulomb(speed, lost, stick_speed, held=torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gearhead:
    """Gearhead with ratio, efficiency and a loss model.

    - ``coulomb`` (the paper): constant friction torque ``(1 - efficiency) rated_torque`` at the motor. The loss remains at
      light load, so a lightly loaded gear is inefficient, as real gears are.
    - ``proportional``: power delivered is ``efficiency`` times the power received while the motor drives, and
      ``backdriving_efficiency`` times while the load drives: usually lower, and 0 for a self-locking gear.
    - ``stribeck``: measured friction of gear and motor together, which depends on load, direction and speed (`GearFriction`);
      it has no single efficiency.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    USES: ClassVar[tuple[str, ...]] = ("name", "ratio", "inertia", "stiffness", "operate", "without_friction")
    """What a drive uses of its gearhead: an object with these can take its place."""

    name: str = component("Name for reports", default="gearhead")
    ratio: float = quantity("1", Gt(0), "Reduction ratio, motor speed over output speed")
    efficiency: float | None = quantity(
        "1",
        Interval(gt=0, le=1),
        "Efficiency at rated torque; required unless the loss model is stribeck",
        default=None,
    )
    loss_model: LossModel = component(
        "coulomb (constant torque), proportional (to power) or stribeck (measured friction)", default="coulomb"
    )
    friction: GearFriction | None = component("Measured friction, for the stribeck loss model", default=None)
    backdriving_efficiency: float | None = quantity(
        "1",
        Interval(ge=0, le=1),
        "Efficiency while the load drives, for the proportional loss model; 0: self-locking; default: `efficiency`",
        default=None,
    )
    rated_torque: float | None = quantity(
        "N m",
        Gt(0),
        "Motor-side torque at which the efficiency is stated; default: the motor's continuous torque",
        default=None,
    )
    continuous_torque: float | None = quantity("N m", Gt(0), "Permissible continuous output torque", default=None)
    intermittent_torque: float | None = quantity(
        "N m", Gt(0), "Permissible intermittent output torque; bounds the peak", default=None
    )
    max_input_speed: float | None = quantity("rad/s", Gt(0), "Permissible speed on the motor side", default=None)
    inertia: float | None = quantity("kg m^2", Gt(0), "Inertia on the motor side", default=None)
    stiffness: float | None = quantity("N m/rad", Gt(0), "Torsional stiffness at the output", default=None)
    backlash: float | None = quantity(
        "rad", Ge(0), "Free angle at the output between both flanks, for simulation; needs `stiffness`", default=None
    )
    mass: float | None = quantity("kg", Gt(0), "Mass", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_choice(
            self,
            "loss_model",
            {"coulomb": ("efficiency",), "proportional": ("efficiency",), "stribeck": ("friction",)},
            {"proportional": ("backdriving_efficiency",)},
        )
        if self.slack and self.stiffness is None:
            raise ParameterError("stiffness is missing: backlash needs it")

    @property
    def slack(self) -> bool:
        """Whether the gear has backlash."""
        return self.backlash is not None and not is_zero(self.backlash)

    @property
    def lossless(self) -> bool:
        """Whether the gear has no friction."""
        if self.friction is not None:
            return self.friction.is_zero
        return min(self._forward, given(self.backdriving_efficiency, self._forward)) == 1.0

    @property
    def load_factors(self) -> tuple[Array, Array]:
        """Motor torque per load torque, both at the motor, without constant and measured friction: while the motor drives, and
        while the load drives. [-]"""
        if self.loss_model != "proportional":
            return 1.0, 1.0
        return 1.0 / self._forward, given(self.backdriving_efficiency, self._forward)

    @property
    def largest_load_factor(self) -> float:
        """Largest motor torque per load torque beyond constant friction, while the motor drives. [-]"""
        if self.friction is None:
            return float(self.load_factors[0])
        return self.friction.largest_load_factor

    @property
    def _forward(self) -> float:
        """Efficiency while the motor drives, of a gear that has one."""
        assert self.efficiency is not None
        return self.efficiency

    def without_friction(self) -> Gearhead:
        """The gearhead without loss."""
        if self.friction is not None:
            return replace(self, friction=GearFriction())
        return replace(self, efficiency=1.0, backdriving_efficiency=None)

    def operate(self, *, output_torque: Array, output_speed: Array, motor_rated_torque: Array) -> GearPoint:
        """Motor torque and speed for an output torque and speed, in all four quadrants.

        Parameters
        ----------
        output_torque, output_speed : (...,) float   At the output, power positive to the load. At exactly zero speed
            friction helps to hold. [N m], [rad s^-1]
        motor_rated_torque : float                   Used if `rated_torque` is None. [N m]

        Returns
        -------
        GearPoint
            Motor torque [N m], motor speed [rad s^-1], loss [W], utilisation of the limits that are known.

        Source: coulomb: faulring2006, section VI-A. proportional: definition of efficiency, taken in the direction in
        which power flows. stribeck: duclusaud2025.
        """
        ideal = output_torque / self.ratio
        motor_speed = output_speed * self.ratio
        if self.loss_model == "coulomb":
            friction = coulomb(motor_speed, self.coulomb_friction(motor_rated_torque), held=ideal)
        else:
            friction = self.load_friction(motor_speed, ideal)
        return GearPoint(
            motor_torque=ideal + friction,
            motor_speed=motor_speed,
            loss=friction * motor_speed,
            utilisation=self.utilisation(output_torque, output_speed),
        )

    def load_friction(self, speed: Array, torque: Array) -> Array:
        """Friction torque at the motor that depends on the load, 0 for the coulomb model; arguments of
        `proportional_friction`. [N m]"""
        if self.friction is not None:
            return stribeck_friction(speed, torque, self.ratio, **terms(self.friction))
        if self.loss_model == "coulomb":
            return 0.0
        back = given(self.backdriving_efficiency, self._forward)
        return proportional_friction(speed, torque, self._forward, back)

    def coulomb_friction(self, motor_rated_torque: Array) -> Array:
        """Constant friction torque at the motor, 0 for the other models; argument as in `operate`. [N m]"""
        if self.loss_model != "coulomb":
            return 0.0
        return coulomb_torque(self._forward, given(self.rated_torque, motor_rated_torque))

    def utilisation(self, output_torque: Array, output_speed: Array) -> dict[Limit, Array]:
        """Demand over allowance for continuous and intermittent output torque and for the input speed, of those known.

        Parameters
        ----------
        output_torque, output_speed : (...,) float   [N m], [rad s^-1]

        Returns
        -------
        dict of Limit to (...,) float   1 is at the limit. [-]

        Source: data sheets, maxon2020.
        """
        xp = namespace(self, output_torque, output_speed)
        demand = {}
        if self.continuous_torque is not None:
            demand[Limit.GEAR] = xp.abs(output_torque) / self.continuous_torque
        if self.intermittent_torque is not None:
            demand[Limit.GEAR_PEAK] = xp.abs(output_torque) / self.intermittent_torque
        if self.max_input_speed is not None:
            demand[Limit.GEAR_SPEED] = xp.abs(output_speed) * self.ratio / self.max_input_speed
        return demand
