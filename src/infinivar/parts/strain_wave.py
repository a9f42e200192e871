r"""Strain-wave gears: what a maker's catalogue states of them, and the law that follows.

At the motor, with its speed w, the torque :math:`\tau` that the gear transmits and the ratio n, friction is

.. math:: f = \theta\,\Bigl(T_s + (T_r - T_s)\,\frac{|w|}{w_r}\Bigr) + k\,|\tau|, \qquad
    k_+ = \frac1\eta - 1 - \frac{n T_r}{\tau_r}, \qquad k_- = 1 - \frac{n T_s}{\tau_b}, \qquad
    \theta = e^{-\beta(\vartheta - \vartheta_0)}

with the starting torque T_s, the running torque T_r without load at the rated speed w_r, and the efficiency :math:`\eta` at the
rated torque :math:`\tau_r` and that speed; :math:`k_+` holds while the motor drives, :math:`k_-` while the load drives, which
moves the motor from the back-driving torque :math:`\tau_b` on. Part of the loss does not fall with the load, so that the
efficiency does: the compensation coefficient of catalogues. Friction of the lubricant falls with its temperature
:math:`\vartheta`.

Source: harmonicdrive2014 for the values that are stated; tuttle1996 and taghirad1998 for constant, viscous and load-dependent
friction and a spring that stiffens. The straight line between standstill and rated speed, the exponential and its coefficient
are assumed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, quantity
from infinivar._core.frozen import FrozenDict
from infinivar.bondgraph.graph import Parameter
from infinivar.contact.friction import coulomb
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.gear_law import Column, GearLaw, GraphLaw
from infinivar.units import plain

RATED_SPEED = 209.44
"""Input speed at which catalogues rate strain-wave gears, 2000 rpm. [rad s^-1]"""

REFERENCE = 293.15
"""Temperature of a catalogue's values where none is stated; assumed. [K]"""

THINNING = 0.02
"""Relative fall of friction without load per kelvin; assumed. [K^-1]"""

_RISING = (
    ("starting_torque", "running_torque", "N m"),
    ("rated_torque", "momentary_torque", "N m"),
    ("rated_torque", "ratcheting_torque", "N m"),
    ("momentary_torque", "ratcheting_torque", "N m"),
)
"""Pairs of torques of which the second is at least the first, with their unit."""

_UNBOUNDED = 1e300
"""Upper bound of the larger of two values, so that a bond graph's equations have no branch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StrainWave:
    """Values of a strain-wave gear as its maker's catalogue states them; the gearhead's `stiffness` is K1.

    Raises
    ------
    ParameterError
        If a field is outside its range, or values exclude each other.
    """

    efficiency: float = quantity("1", Interval(gt=0, le=1), "Efficiency at rated torque and rated speed")
    rated_torque: float = quantity("N m", Gt(0), "Rated torque at the output")
    rated_speed: float = quantity("rad/s", Gt(0), "Rated speed at the motor", default=RATED_SPEED)
    starting_torque: float = quantity("N m", Ge(0), "Torque at the motor that starts the gear without load")
    running_torque: float = quantity(
        "N m", Ge(0), "Torque at the motor that turns the gear without load at rated speed"
    )
    backdriving_torque: float | None = quantity(
        "N m",
        Gt(0),
        "Torque at the output that starts the gear with the motor free; default: the load loses one share in both directions",
        default=None,
    )
    torque_1: float | None = quantity("N m", Gt(0), "Torque up to which the stiffness is K1, T1", default=None)
    stiffness_2: float | None = quantity("N m/rad", Gt(0), "Torsional stiffness beyond T1, K2", default=None)
    torque_2: float | None = quantity("N m", Gt(0), "Torque up to which the stiffness is K2, T2", default=None)
    stiffness_3: float | None = quantity("N m/rad", Gt(0), "Torsional stiffness beyond T2, K3", default=None)
    momentary_torque: float | None = quantity(
        "N m", Gt(0), "Output torque that it withstands a few times in its life; bounds the peak", default=None
    )
    ratcheting_torque: float | None = quantity(
        "N m", Gt(0), "Output torque at which its teeth skip; bounds the peak", default=None
    )
    temperature: float | None = quantity(
        "K", Gt(0), "Temperature of the lubricant; default: that of the catalogue's values", default=None
    )
    reference_temperature: float = quantity("K", Gt(0), "Temperature of the catalogue's values", default=REFERENCE)
    thinning: float = quantity(
        "1/K", Ge(0), "Relative fall of friction without load per rise of the temperature", default=THINNING
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        for corner, beyond in (("torque_1", "stiffness_2"), ("torque_2", "stiffness_3")):
            if (getattr(self, corner) is None) != (getattr(self, beyond) is None):
                missing, other = (corner, beyond) if getattr(self, corner) is None else (beyond, corner)
                raise ParameterError(f"{missing} is missing: {other} needs it")
        if self.torque_2 is not None and self.torque_1 is None:
            raise ParameterError("torque_1 is missing: torque_2 needs it")
        if isinstance(self.torque_1, (int, float)) and isinstance(self.torque_2, (int, float)):
            require(self.torque_2 > self.torque_1, "torque_2", self.torque_2, f"> torque_1, {self.torque_1:g} N m")
        for less, more, unit in (*_RISING, ("stiffness_2", "stiffness_3", "N m/rad")):
            low, high = getattr(self, less), getattr(self, more)
            if isinstance(low, (int, float)) and isinstance(high, (int, float)):
                require(high >= low, more, high, f">= {less}, {plain(low, 4)} {unit}")


@dataclass(frozen=True, slots=True, kw_only=True)
class StrainWaveLaw(GearLaw):
    """Law of a strain-wave gear; see this module."""

    strain_wave: StrainWave

    NEEDS: ClassVar[tuple[str, ...]] = ("strain_wave",)
    WORDS: ClassVar[str] = "strain wave"
    SEARCHED: ClassVar[tuple[str, ...]] = tuple(
        f"strain_wave.{name}" for name in ("efficiency", "rated_torque", "starting_torque", "running_torque")
    )
    MORE: ClassVar[tuple[str, ...]] = tuple(
        f"strain_wave.{name}"
        for name in (
            "rated_speed",
            "backdriving_torque",
            "momentary_torque",
            "ratcheting_torque",
            "temperature",
            "reference_temperature",
            "thinning",
        )
    )

    @property
    def constant(self) -> Array:
        """Friction without load at standstill. [N m]"""
        return self._warmth * self.strain_wave.starting_torque

    @property
    def viscous(self) -> Array:
        """Its rise with speed. [N m s]"""
        said = self.strain_wave
        return self._warmth * (said.running_torque - said.starting_torque) / said.rated_speed

    @property
    def load_factors(self) -> tuple[Array, Array]:
        """1 + k while the motor drives, 1 - k while the load drives. [-]"""
        said = self.strain_wave
        driving = 1.0 / said.efficiency - self.ratio * said.running_torque / said.rated_torque
        if said.backdriving_torque is None:
            return driving, 1.0 / driving
        return driving, self.ratio * said.starting_torque / said.backdriving_torque

    @property
    def _warmth(self) -> Array:
        """Friction without load over that at the temperature of the catalogue. [-]"""
        said = self.strain_wave
        if said.temperature is None:
            return 1.0
        return namespace(said).exp(-said.thinning * (said.temperature - said.reference_temperature))

    @property
    def is_zero(self) -> bool:
        """Whether it loses nothing."""
        return not self.constant and not self.viscous and self.load_factors == (1.0, 1.0)

    @property
    def corners(self) -> tuple[tuple[Array, Array], ...]:
        """T1 with K2, and T2 with K3."""
        said = self.strain_wave
        pairs = ((said.torque_1, said.stiffness_2), (said.torque_2, said.stiffness_3))
        return tuple((torque, beyond) for torque, beyond in pairs if torque is not None and beyond is not None)

    def utilisation(self, output_torque: Array, output_speed: Array) -> Mapping[Limit, Array]:
        """Output torque over momentary and over ratcheting torque, where stated. [-]

        Source: harmonicdrive2014, rating table and technical terms.
        """
        load, said = namespace(self, output_torque).abs(output_torque), self.strain_wave
        stated = {Limit.GEAR_MOMENTARY: said.momentary_torque, Limit.RATCHETING: said.ratcheting_torque}
        return {limit: load / allowed for limit, allowed in stated.items() if allowed is not None}

    def fault(self) -> str | None:
        """An efficiency or back-driving torque that the torques without load exclude."""
        said, (driving, driven) = self.strain_wave, self.load_factors
        if not isinstance(driving + driven, (int, float)):
            return None
        if driving < 1.0 - 1e-12:
            most = 1.0 / (1.0 + self.ratio * said.running_torque / said.rated_torque)
            return (
                f"strain_wave.efficiency must be <= {plain(most, 4)}, which running_torque leaves at rated torque, got "
                f"{said.efficiency:g}"
            )
        if driven > 1.0 + 1e-12:
            least = plain(self.ratio * said.starting_torque, 4)
            return (
                f"strain_wave.backdriving_torque must be >= {least} N m, ratio times starting_torque, got "
                f"{said.backdriving_torque:g}"
            )
        return None

    def transmitted(self, speed: Array, motor_torque: Array) -> Array:
        """Torque transmitted at a motor torque, the inverse of torque plus `friction_torque`; in motion. [N m]

        Parameters
        ----------
        speed, motor_torque : (...,) float   Of the motor; speed is not 0. [rad s^-1], [N m]
        """
        xp = namespace(self, speed, motor_torque)
        driving, driven = self.load_factors
        way = xp.sign(speed)
        left = motor_torque * way - self.constant - self.viscous * xp.abs(speed)
        return way * left / xp.where(left > 0.0, driving, driven)

    def without_friction(self) -> Mapping[str, Any]:
        """No torque without load, and an efficiency of 1."""
        changes = {"starting_torque": 0.0, "running_torque": 0.0, "efficiency": 1.0, "backdriving_torque": None}
        return {"strain_wave": replace(self.strain_wave, **changes)}

    def graph_law(self, tag: str) -> GraphLaw:
        """`strain_wave_friction`."""
        driving, driven = self.load_factors
        parameters = {
            "constant": Parameter(f"T_{{s,{tag}}}", float(self.constant), "N m"),
            "viscous": Parameter(f"c_{{g,{tag}}}", float(self.viscous), "N m s"),
            "driving": Parameter(f"k_{{+,{tag}}}", float(driving) - 1.0),
            "driven": Parameter(f"k_{{-,{tag}}}", 1.0 - float(driven)),
        }
        return GraphLaw(law=strain_wave_friction, parameters=FrozenDict(parameters), solved=strain_wave_friction)

    @classmethod
    def columns(cls, column: Column, motor_torque: Array) -> dict[str, Any]:
        """Catalogue values; defaults of `StrainWave` and limits out of reach where they are not stated."""
        others = {
            "rated_speed": RATED_SPEED,
            "momentary_torque": np.inf,
            "ratcheting_torque": np.inf,
            "reference_temperature": REFERENCE,
            "thinning": THINNING,
        }
        needed = ("efficiency", "rated_torque", "starting_torque", "running_torque")
        said: dict[str, Any] = {name: column(f"strain_wave.{name}") for name in needed}
        said |= {name: column(f"strain_wave.{name}", other) for name, other in others.items()}
        said["temperature"] = column("strain_wave.temperature", said["reference_temperature"])
        ratio = column("ratio")
        driving, _ = cls(ratio=ratio, strain_wave=StrainWave(**said)).load_factors
        alike = ratio * said["starting_torque"] * driving
        return {"strain_wave": StrainWave(**said, backdriving_torque=column("strain_wave.backdriving_torque", alike))}

    @classmethod
    def contradictions(cls, column: Column) -> list[tuple[str, np.ndarray]]:
        """Torques without load that fall with speed, or that exclude the efficiency or the back-driving torque."""
        ratio, (efficiency, rated, starting, running) = column("ratio"), map(column, cls.SEARCHED)
        with np.errstate(divide="ignore", invalid="ignore"):
            return [
                *(
                    (
                        f"gearhead strain_wave.{more} below its {less.replace('_', ' ')}",
                        column(f"strain_wave.{more}") < column(f"strain_wave.{less}"),
                    )
                    for less, more, _ in _RISING
                ),
                (
                    "gearhead strain_wave.efficiency above what its running torque leaves",
                    1.0 / efficiency - ratio * running / rated < 1.0 - 1e-12,
                ),
                (
                    "gearhead strain_wave.backdriving_torque below ratio times its starting torque",
                    column("strain_wave.backdriving_torque") < ratio * starting * (1.0 - 1e-12),
                ),
            ]

    def measured(self) -> Mapping[str, float]:
        """Terms that are the same while the motor drives."""
        share = float(self.load_factors[0]) - 1.0
        load = share / (2.0 + share)
        ratio = float(self.ratio) * (1.0 - load)
        return {
            "friction": ratio * float(self.constant),
            "viscous": ratio * float(self.ratio) * float(self.viscous),
            "load_motor": load,
            "load_output": load,
        }


def strain_wave_friction(
    speed: Array,
    torque: Array,
    *,
    constant: Array,
    viscous: Array,
    driving: Array,
    driven: Array,
    stick_speed: Array | None = None,
    gain: Array = 0.0,
) -> Array:
    """Friction torque at the motor: constant, with speed, and a share of the load in each direction.

    Parameters
    ----------
    speed : (...,) float            Motor speed. [rad s^-1]
    torque : (...,) float           Torque that the gear transmits, at the motor and without friction. [N m]
    constant, viscous : (...,) float   At standstill, and per speed. [N m], [N m s]
    driving, driven : (...,) float  k while the motor and while the load drives, 0 to 1 for the latter. [-]
    stick_speed : (...,) float      As in `infinivar.contact.friction.coulomb`. [rad s^-1]
    gain : (...,) float             Change of the transmitted torque from `torque` per friction torque, -1 to 0. [-]

    Returns
    -------
    (...,) float   Opposes the motion. At rest it helps to hold the torque. [N m]

    Source: see `infinivar.parts.strain_wave`; solved for the friction here, which is the larger of two straight lines.
    """
    xp = namespace(speed, torque, constant, viscous, driving, driven, stick_speed, gain)
    acting = 1.0 if stick_speed is None else xp.abs(coulomb(speed, 1.0, stick_speed))
    returned = -gain * acting
    load = xp.abs(torque)
    ahead = xp.where(torque * speed > 0, load, -load)
    base = constant + viscous * xp.abs(speed)
    moved = (base + driving * ahead) / (1.0 + driving * returned)
    size = xp.clip(moved, (base - driven * ahead) / (1.0 - driven * returned), _UNBOUNDED)
    return coulomb(speed, size, stick_speed, held=torque)
