"""Fixed-ratio gearhead: two loss models derived from one efficiency, and measured friction; none creates power."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.chain_rule import is_zero
from infinivar._core.fields import check, check_choice, component, quantity
from infinivar.errors import ParameterError, require
from infinivar.limits import ROOT_MEAN_SQUARE, Limit
from infinivar.parts.gear_friction import GearFriction, MeasuredLoss
from infinivar.parts.gear_law import ConstantLoss, GearLaw, ProportionalLoss, Torsion
from infinivar.parts.strain_wave import StrainWave, StrainWaveLaw
from infinivar.units import plain

LossModel = Literal["coulomb", "proportional", "stribeck", "strain wave"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GearPoint:
    """Motor side of a gearhead at an output torque and speed; arrays that broadcast to one shape, SI."""

    motor_torque: Array
    motor_speed: Array
    loss: Array
    utilisation: Mapping[Limit, Array]


LAWS: Mapping[LossModel, type[GearLaw]] = {
    "coulomb": ConstantLoss,
    "proportional": ProportionalLoss,
    "stribeck": MeasuredLoss,
    "strain wave": StrainWaveLaw,
}
"""Law of each kind of gear: another kind is a `GearLaw` here, with a component of `Gearhead` for what only it has."""

PARTS_OF_LAWS: Mapping[str, type] = {"friction": GearFriction, "strain_wave": StrainWave}
"""Components that only some kinds have, by field."""

_NEEDS = {word: law.NEEDS for word, law in LAWS.items()}
_MAY = {word: tuple(name for name in law.MAY if name != "rated_torque") for word, law in LAWS.items()}
"""Without the rated torque, which stays when a study changes the kind."""


def foreign_fields(loss_model: str, *, needed: bool = False) -> tuple[str, ...]:
    """Optional fields that a kind of gear does not have, as other kinds do; with `needed` also those that these require.

    Parameters
    ----------
    loss_model : str   An unknown one has every field.
    """
    if loss_model not in LAWS:
        return ()
    tables = (_MAY, _NEEDS) if needed else (_MAY,)
    every = {name: None for table in tables for names in table.values() for name in names}
    own = {*_NEEDS[loss_model], *_MAY[loss_model]}
    return tuple(name for name in every if name not in own)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gearhead:
    """Gearhead with ratio, efficiency and a loss model.

    - ``coulomb`` (the paper): constant friction torque ``(1 - efficiency) rated_torque`` at the motor. The loss remains at
      light load, so a lightly loaded gear is inefficient, as real gears are.
    - ``proportional``: power delivered is ``efficiency`` times the power received while the motor drives, and
      ``backdriving_efficiency`` times while the load drives: usually lower, and 0 for a self-locking gear.
    - ``stribeck``: measured friction of gear and motor together, which depends on load, direction and speed (`GearFriction`);
      it has no single efficiency.
    - ``strain wave``: a strain-wave gear by the values of its maker's catalogue (`StrainWave`).

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    USES: ClassVar[tuple[str, ...]] = ("name", "ratio", "inertia", "stiffness", "operate", "without_friction")
    """What a drive uses of its gearhead: an object with these can take its place."""

    ALLOWANCES: ClassVar[Mapping[Limit, str]] = {
        Limit.GEAR: "continuous_torque",
        Limit.GEAR_PEAK: "intermittent_torque",
        Limit.GEAR_SPEED: "max_input_speed",
    }
    """Field that states what each limit of `utilisation` allows; a law may have more limits."""

    name: str = component("Name for reports", default="gearhead")
    ratio: float = quantity("1", Gt(0), "Reduction ratio, motor speed over output speed")
    efficiency: float | None = quantity(
        "1",
        Interval(gt=0, le=1),
        "Efficiency at rated torque; required with the loss models coulomb and proportional",
        default=None,
    )
    loss_model: LossModel = component(
        "coulomb (constant torque), proportional (to power), stribeck (measured friction) or strain wave",
        default="coulomb",
    )
    friction: GearFriction | None = component("Measured friction, for the stribeck loss model", default=None)
    strain_wave: StrainWave | None = component("Catalogue values of a strain-wave gear", default=None)
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
    diameter: float | None = quantity("m", Gt(0), "Outer diameter", default=None)
    length: float | None = quantity("m", Gt(0), "Length without shafts", default=None)
    price: float | None = quantity("1", Ge(0), "Price, in one currency for all parts", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_choice(self, "loss_model", _NEEDS, _MAY)
        if self.slack and self.stiffness is None:
            raise ParameterError("stiffness is missing: backlash needs it")
        law = self.law()
        fault = law.fault()
        if fault:
            raise ParameterError(fault)
        if law.corners and self.stiffness is None:
            raise ParameterError("stiffness is missing: corners of the torsional spring need it")
        for _, beyond in law.corners[:1]:
            if isinstance(beyond, (int, float)) and isinstance(self.stiffness, (int, float)):
                most = f"<= {plain(beyond, 4)} N m/rad, that beyond the first corner"
                require(self.stiffness <= beyond, "stiffness", self.stiffness, most)
        if self.slack and law.corners:
            raise ParameterError("backlash does not apply to a gearhead that is stiffer under load; remove one of them")

    @property
    def slack(self) -> bool:
        """Whether the gear has backlash."""
        return self.backlash is not None and not is_zero(self.backlash)

    def law(self, motor_torque: Array | None = None) -> GearLaw:
        """Law of its kind.

        Parameters
        ----------
        motor_torque : (...,) float   Continuous torque of the motor; needed for constant friction without `rated_torque`. [N m]
        """
        kind = LAWS[self.loss_model]
        own = {name: getattr(self, name) for name in (*kind.NEEDS, *kind.MAY)}
        return kind(ratio=self.ratio, motor_torque=motor_torque, **own)

    @property
    def torsion(self) -> Torsion | None:
        """Its torsional spring; None if it is rigid."""
        if self.stiffness is None:
            return None
        return Torsion(stiffness=self.stiffness, corners=self.law().corners)

    @property
    def lossless(self) -> bool:
        """Whether the gear has no friction."""
        return self.law().is_zero

    @property
    def load_factors(self) -> tuple[Array, Array]:
        """Motor torque per load torque, both at the motor, without constant and measured friction: while the motor drives, and
        while the load drives. [-]"""
        return self.law().load_factors

    @property
    def largest_load_factor(self) -> float:
        """Largest motor torque per load torque beyond constant friction, while the motor drives. [-]"""
        return self.law().largest_load_factor

    @property
    def loss_words(self) -> str:
        """What its loss is, for reports."""
        return LAWS[self.loss_model].WORDS

    def without_friction(self) -> Gearhead:
        """The gearhead without loss."""
        return replace(self, **self.law().without_friction())

    def rated_at(self, motor_torque: float) -> Gearhead:
        """The gearhead with an explicit rated torque, where its friction is stated at that of the motor. [N m]"""
        if "rated_torque" not in LAWS[self.loss_model].MAY or self.rated_torque is not None:
            return self
        return replace(self, rated_torque=motor_torque)

    def alternatives(self) -> dict[str, dict[str, Any]]:
        """Other losses that the same data sheet permits, in words, with the fields that they change; empty for a known loss."""
        own = LAWS[self.loss_model]
        if not own.CHOICE or self.lossless:
            return {}
        return {
            law.CHOICE: {"loss_model": word, **dict.fromkeys(set(_MAY[self.loss_model]) - set(_MAY[word]))}
            for word, law in LAWS.items()
            if law.CHOICE and law is not own
        }

    def measured_friction(self, motor_torque: float) -> GearFriction:
        """Load-dependent friction that is closest to its loss; argument as for `law`."""
        return GearFriction(**self.law(motor_torque).measured())

    def with_measured(self, friction: GearFriction) -> Gearhead:
        """The gearhead with measured friction in place of its loss."""
        dropped = dict.fromkeys(foreign_fields("stribeck", needed=True))
        return replace(self, **{**dropped, "loss_model": "stribeck", "friction": friction})

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
        friction = self.law(motor_rated_torque).friction_torque(motor_speed, ideal)
        return GearPoint(
            motor_torque=ideal + friction,
            motor_speed=motor_speed,
            loss=friction * motor_speed,
            utilisation=self.utilisation(output_torque, output_speed),
        )

    def load_friction(self, speed: Array, torque: Array) -> Array:
        """Friction torque at the motor beyond constant friction; arguments of `GearLaw.size`. [N m]"""
        return self.law().load_friction(speed, torque)

    def coulomb_friction(self, motor_rated_torque: Array) -> Array:
        """Constant friction torque at the motor, 0 for the other models; argument as in `operate`. [N m]"""
        return self.law(motor_rated_torque).constant

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
        return {**demand, **self.law().utilisation(output_torque, output_speed)}

    def extreme_utilisation(self, peak: Array, lasting: Array, fastest: Array) -> dict[Limit, Array]:
        """Largest demands over a motion, as `utilisation`: that for speed first.

        Parameters
        ----------
        peak, lasting : (...,) float   Largest output torque, and that whose limits apply to its root mean square. [N m]
        fastest : (...,) float         Largest output speed. [rad s^-1]
        """
        once, on_average = self.utilisation(peak, fastest), self.utilisation(lasting, fastest)
        found = {limit: on_average[limit] if limit in ROOT_MEAN_SQUARE else demand for limit, demand in once.items()}
        return {limit: found[limit] for limit in sorted(found, key=lambda limit: limit != Limit.GEAR_SPEED)}
