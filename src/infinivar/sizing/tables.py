"""A search over tables of parts: one frozen value with all its options, whatever the architecture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.envelope import Envelope
from infinivar.errors import ParameterError, require
from infinivar.motion.duty_cycles import DutyCycle, shares_of
from infinivar.parts.bearing import Bearing
from infinivar.parts.gearhead import LossModel
from infinivar.parts.stage import OutputStage
from infinivar.study.requirement import Requirement

Objective = Literal["energy", "mass", "space", "price", "front"]

MOVING = ("energy", "front")
"""Objectives that need a motion."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Request:
    """What a search over tables of parts has to find, and among what.

    Attributes
    ----------
    template      Everything but what is searched; gearheads count as rigid.
    motors, gearheads   Columns by the names of the fields of `Motor` and `Gearhead`, in SI, nan where not stated.
    pairs         Row of the motor and of the gearhead of each pair. (n, 2) int
    duty          Motions by name; may be empty.
    requirement   Required region.
    objective     energy, mass, space, price, or front, which is that of energy and mass.
    travel        End-to-end travel of the load. [m]
    loss_model    Of all gearheads; None for that of the template's.
    samples       Instants of a motion; None for as many as `duty_cycle` has by default.
    top           Number of designs to return.
    envelope      Largest size and mass; None for any.
    prune         Whether bounds spare candidates the evaluation at every instant.
    """

    template: ConventionalDrive | CoboticDrive
    motors: Mapping[str, Any]
    gearheads: Mapping[str, Any]
    pairs: Any
    duty: Mapping[str, DutyCycle]
    requirement: Requirement | None = None
    objective: Objective = "energy"
    travel: float | None = None
    loss_model: LossModel | None = None
    samples: int | None = None
    top: int = 20
    envelope: Envelope | None = None
    prune: bool = True

    def __post_init__(self) -> None:
        """Check the options that need no table."""
        known = self.objective in get_args(Objective)
        require(known, "objective", repr(self.objective), "energy, mass, space, price or front")
        require(isinstance(self.top, int) and self.top >= 1, "top", self.top, ">= 1")

    @property
    def moving(self) -> bool:
        """Whether there are motions."""
        return bool(self.duty)

    @property
    def weighed(self) -> bool:
        """Whether masses must be known."""
        return self.objective not in ("energy", "price") or self.envelope is not None

    @property
    def stated(self) -> tuple[str, ...]:
        """What every part must state."""
        return (*["mass"] * self.weighed, *["price"] * (self.objective == "price"))

    @property
    def gear_law(self) -> LossModel:
        """Loss model of all gearheads."""
        return self.loss_model or self.template.gearhead.loss_model

    @property
    def shares(self) -> dict[str, float]:
        """Share of time of each motion. [-]"""
        return equal_shares(self.duty)

    def check_motions(self) -> None:
        """Raise ParameterError if the objective needs a motion and there is none."""
        if self.objective in MOVING and not self.duty:
            raise ParameterError(
                "duty is empty: the energy needs a motion; with a required region only, use objective = 'mass'"
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GearedRequest(Request):
    """A search over geared drives; see `size_geared`.

    Attributes
    ----------
    stages   Output stages to try with every pair; empty for that of the template.
    radius   Least and largest radius of the template's pulley, instead of `stages`. [m]
    """

    template: ConventionalDrive
    stages: tuple[OutputStage, ...] = ()
    radius: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check the options that need no table."""
        Request.__post_init__(self)
        if self.radius is None:
            return
        check_stages_or_radius(self.stages, self.radius)
        title = self.template.stage.title
        if self.template.pulley is None:
            raise ParameterError(
                f"radius does not apply to a {title}: only a pulley has a continuous range; state the {title}s to try as stages"
            )
        low, high = self.radius
        require(0.0 < low <= high < math.inf, "radius", self.radius, "a range above 0 m, the least radius first")
        object.__setattr__(self, "radius", (float(low), float(high)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CoboticRequest(Request):
    """A search over cobotic drives; see `size_cobotic`.

    Attributes
    ----------
    steering_motors    As `motors`.
    steering_ratios    Of the gear between steering motor and bell. [-]
    bearings           Of the axle.
    wheels             Numbers of wheels around the cylinder; empty: the template's.
    cylinder_bearings  Of the cylinder; empty: the template's.
    ranges             Least and largest value by name; by default half and twice the template's.
    slip_margin        Slip force over lateral force that is wanted. [-]
    life               Wanted life of axle and cylinder bearings; None for any. [s]
    population, generations, seed   Of differential evolution.
    first_samples      Instants of a motion, at most, of most generations.
    method             numpy or jax.
    """

    template: CoboticDrive
    steering_motors: Mapping[str, Any]
    steering_ratios: tuple[float, ...]
    bearings: tuple[Bearing, ...]
    ranges: Mapping[str, tuple[float, float]]
    slip_margin: float = 1.0
    life: float | None = None
    wheels: tuple[int, ...] = ()
    cylinder_bearings: tuple[Bearing, ...] = ()
    population: int = 40
    generations: int = 100
    seed: int = 0
    first_samples: int = 100
    method: Literal["numpy", "jax"] = "numpy"

    def __post_init__(self) -> None:
        """Check the options that need no table."""
        Request.__post_init__(self)
        require(self.method in ("numpy", "jax"), "method", repr(self.method), "numpy or jax")
        for name, least in (("population", 5), ("generations", 1), ("first_samples", 2)):
            number = getattr(self, name)
            require(isinstance(number, int) and number >= least, name, number, f"a whole number >= {least}")
        require(1.0 <= self.slip_margin < math.inf, "slip_margin", self.slip_margin, ">= 1 and finite")
        require(self.life is None or self.life > 0.0, "life", self.life, "> 0", "s")
        steering = self.template.steering
        if self.objective == "price" and not self.duty and steering is not None and steering.motor.price is None:
            raise ParameterError(
                "steering.motor.price is missing: without a motion no other steering motor is searched"
            )
        if self.life is not None and not self.duty:
            raise ParameterError("life needs a motion, which tells how far the wheel rolls: duty is empty")


def check_stages_or_radius(stages: object, radius: object) -> None:
    """Raise ParameterError if output stages and a range of radii are both given."""
    if stages and radius is not None:
        raise ParameterError("stages and radius are both given: state stages to try, or the range of a pulley's radius")


def equal_shares(duty: Mapping[str, DutyCycle]) -> dict[str, float]:
    """Share of time of each motion; equal if none states one. [-]"""
    return shares_of(duty) or dict.fromkeys(duty, 1.0 / max(len(duty), 1))
