r"""Lead and ball screws: friction in both directions, self-locking, and limits of the screw as a column, a shaft and a bearing.

With the lead angle :math:`\lambda` and the friction angle :math:`\rho`, the torque that raises a load is
:math:`F (d/2)\tan(\lambda + \rho)`, the torque that lowers it :math:`-F (d/2)\tan(\rho - \lambda)`: from
:math:`\rho = \lambda` on the screw is self-locking.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from annotated_types import Ge, Gt, Interval, Le

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.fields import check, check_choice, component, given, quantity
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.parts.stage import OutputStage, force_limit
from infinivar.parts.structure import beams
from infinivar.parts.structure.beams import STEEL_DENSITY, STEEL_MODULUS

ScrewKind = Literal["lead", "ball"]
Ends = Literal["fixed-free", "supported-supported", "fixed-supported", "fixed-fixed"]

FIXITY: dict[str, float] = {
    "fixed-free": 0.25,
    "supported-supported": 1.0,
    "fixed-supported": 2.045748,
    "fixed-fixed": 4.0,
}
"""Euler load over that of a column with both ends supported. Source: young2002, Table 15.1."""

DEFAULT_ENDS: Ends = "fixed-supported"

_MILLION = 1e6
"""Revolutions of the basic dynamic load rating."""


def lead_angle(lead: Array, diameter: Array) -> Array:
    """Lead angle at the pitch diameter, ``atan(lead/(pi d))``. [rad]

    Source: budynas2011, section 8-2.
    """
    xp = namespace(lead, diameter)
    lead, diameter = as_floats(xp, lead, diameter)
    return xp.atan(lead / (math.pi * diameter))


def friction_angle(coefficient: Array, flank_angle: Array = 0.0) -> Array:
    """Friction angle of a thread, ``atan(mu/cos(alpha))``; alpha is half the thread angle. [rad]

    Neglects the lead angle in the angle of the flanks, as usual.

    Source: budynas2011, section 8-2.
    """
    xp = namespace(coefficient, flank_angle)
    coefficient, flank_angle = as_floats(xp, coefficient, flank_angle)
    return xp.atan(coefficient / xp.cos(flank_angle))


def screw_efficiencies(lead_angle: Array, friction_angle: Array) -> tuple[Array, Array]:
    r"""Efficiencies of a screw while the screw drives and while the load drives, without bearings and preload.

    .. math:: \eta = \frac{\tan\lambda}{\tan(\lambda + \rho)}, \qquad \eta' = \frac{\tan(\lambda - \rho)}{\tan\lambda}

    Parameters
    ----------
    lead_angle, friction_angle : (...,) float   lambda > 0 and rho >= 0, together below pi/2. [rad]

    Returns
    -------
    efficiency, backdriving_efficiency : (...,) float   The second is 0 at rho = lambda and negative beyond: the screw is
        self-locking, and must be turned to lower the load. [-]

    Source: budynas2011, section 8-2; a ball screw has the friction angle of rolling.
    """
    xp = namespace(lead_angle, friction_angle)
    lead_angle, friction_angle = as_floats(xp, lead_angle, friction_angle)
    slope = xp.tan(lead_angle)
    return slope / xp.tan(lead_angle + friction_angle), xp.tan(lead_angle - friction_angle) / slope


def friction_angle_from(efficiency: Array, lead_angle: Array) -> Array:
    """Friction angle at which a screw has a given efficiency while it drives. [rad]

    Source: inverse of `screw_efficiencies`.
    """
    xp = namespace(efficiency, lead_angle)
    efficiency, lead_angle = as_floats(xp, efficiency, lead_angle)
    return xp.atan(xp.tan(lead_angle) / efficiency) - lead_angle


def buckling_load(
    diameter: Array, length: Array, ends: str, modulus: Array = STEEL_MODULUS, yield_strength: Array | None = None
) -> Array:
    r"""Axial load at which a round column buckles.

    .. math:: F = n \pi^2 E I/L^2, \quad I = \pi d^4/64, \qquad\text{or}\quad
        F = A \left(\sigma_y - \left(\frac{\sigma_y L}{2\pi k}\right)^2 \frac{1}{n E}\right), \quad k = d/4

    Parameters
    ----------
    diameter : (...,) float         Root diameter of the thread. [m]
    length : (...,) float           Largest length under compression. [m]
    ends : str                      A key of `FIXITY`, which gives n.
    modulus : (...,) float          Elastic modulus. [Pa]
    yield_strength : (...,) float   With it, columns with half the yield strength or more as Euler stress follow Johnson's
        parabola, the second formula. Without it, Euler's formula applies to all lengths. [Pa]

    Returns
    -------
    (...,) float   [N]

    Source: Euler's load with coefficients of young2002, Table 15.1; Johnson's parabola: budynas2011, section 4-13.
    """
    xp = namespace(diameter, length, modulus, yield_strength)
    area, gyration = math.pi * diameter**2 / 4.0, diameter / 4.0
    elastic = FIXITY[ends] * math.pi**2 * modulus * (gyration / length) ** 2
    if yield_strength is None:
        return area * elastic
    johnson = yield_strength * (1.0 - yield_strength / (4.0 * elastic))
    return area * xp.where(elastic < 0.5 * yield_strength, elastic, johnson)


def critical_speed(
    diameter: Array, length: Array, ends: str, modulus: Array = STEEL_MODULUS, density: Array = STEEL_DENSITY
) -> Array:
    """First critical speed of a round shaft in bending.

    Parameters
    ----------
    diameter : (...,) float   Root diameter of the thread. [m]
    length : (...,) float     Largest length between supports. [m]
    ends : str                A key of `beams.BENDING`.
    modulus, density          Of the shaft. [Pa], [kg m^-3]

    Returns
    -------
    (...,) float   [rad s^-1]

    Source: blevins1979, Table 8-1, by `beams.critical_speed`.
    """
    return beams.critical_speed(beams.Section(0.5 * diameter), length, ends, modulus, density)


def life_demand(force: Array, speed: Array, dynamic_load: Array, life: Array) -> Array:
    r"""Force over the force at which the basic life equals the wanted life, at constant speed.

    The basic life is :math:`L_{10} = 10^6 (C/F)^3` revolutions. The demand at time t is
    :math:`(F/C)\,(|\omega| T/(2\pi\,10^6))^{1/3}` for a wanted life T, so the cubic mean of the demand over a cycle is the demand
    of the cycle: it is 1 where damage over the wanted life is 1.

    Parameters
    ----------
    force, speed : (...,) float   Axial force and speed of the screw. [N], [rad s^-1]
    dynamic_load : (...,) float   C, basic dynamic load rating for 1e6 revolutions. [N]
    life : (...,) float           T, time of operation wanted. [s]

    Returns
    -------
    (...,) float   [-]

    Source: iso2006a (life and cubic mean load).
    """
    xp = namespace(force, speed, dynamic_load, life)
    revolutions = xp.abs(speed) * life / (2.0 * math.pi * _MILLION)
    # A cube root of exactly zero has no derivative; at rest no life is used.
    turns = revolutions > 0
    return xp.where(turns, xp.abs(force) / dynamic_load * xp.where(turns, revolutions, 1.0) ** (1.0 / 3.0), 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Screw(OutputStage):
    """Lead or ball screw, turned by the gearhead's shaft; the nut moves the load.

    Friction of the thread is stated in one way: as `friction_coefficient` (of a lead screw also with `flank_angle`), as
    `friction_angle`, or as `efficiency`. The efficiency while the load drives follows from the same friction angle unless
    `backdriving_efficiency` states it.

    Raises
    ------
    ParameterError
        If a field is outside its range, or friction is stated in no way or in several; the message names field, value and
        unit.
    """

    title: ClassVar[str] = "screw"
    letter: ClassVar[str] = "s"

    shape: ScrewKind = component("lead (sliding) or ball (rolling)", default="lead")
    lead: float = quantity("m", Gt(0), "Travel of the nut per revolution", per="rev")
    diameter: float = quantity("m", Gt(0), "Pitch diameter of the thread, or diameter of the ball centres")
    friction_coefficient: float | None = quantity("1", Ge(0), "Friction coefficient of the thread", default=None)
    flank_angle: float | None = quantity(
        "rad",
        Interval(ge=0, lt=1.5),
        "Half the thread angle of a lead screw; 15 deg for a trapezoidal thread",
        default=None,
    )
    friction_angle: float | None = quantity("rad", Interval(ge=0, lt=1.5), "Friction angle of the thread", default=None)
    efficiency: float | None = quantity("1", Interval(gt=0, le=1), "Efficiency while the screw drives", default=None)
    backdriving_efficiency: float | None = quantity(
        "1", Le(1), "Efficiency while the load drives; 0 or less: self-locking", default=None
    )
    friction_torque: float = quantity(
        "N m", Ge(0), "Friction torque independent of the load: bearings, seals, preload of a ball nut", default=0.0
    )
    inertia: float | None = quantity("kg m^2", Gt(0), "Moment of inertia of the screw", default=None)
    length: float | None = quantity(
        "m", Gt(0), "Largest unsupported length, for buckling and critical speed", default=None
    )
    root_diameter: float | None = quantity("m", Gt(0), "Root diameter, for buckling and critical speed", default=None)
    ends: Ends = component("Fixity of both ends", default=DEFAULT_ENDS)
    modulus: float = quantity("Pa", Gt(0), "Elastic modulus", default=STEEL_MODULUS)
    yield_strength: float | None = quantity(
        "Pa", Gt(0), "Yield strength, for short screws under compression", default=None
    )
    buckling_safety: float = quantity("1", Ge(1), "Buckling load over permissible force", default=2.0)
    critical_share: float = quantity("1", Interval(gt=0, le=1), "Permissible speed over critical speed", default=0.8)
    max_speed: float | None = quantity(
        "rad/s", Gt(0), "Permissible speed, of a ball screw from its DN value", default=None
    )
    permissible_force: float | None = quantity(
        "N", Gt(0), "Permissible axial force, such as the static rating", default=None
    )
    dynamic_load: float | None = quantity("N", Gt(0), "Basic dynamic load rating of a ball screw", default=None)
    life: float | None = quantity("s", Gt(0), "Time of operation wanted of a ball screw", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        check_choice(
            self, "shape", {"lead": (), "ball": ()}, {"lead": ("flank_angle",), "ball": ("dynamic_load", "life")}
        )
        stated = [
            name for name in ("friction_coefficient", "friction_angle", "efficiency") if getattr(self, name) is not None
        ]
        if len(stated) != 1:
            how = f"{' and '.join(stated)} are given" if stated else "friction_coefficient is missing"
            raise ParameterError(
                f"{how}: state the friction of the thread as one of friction_coefficient, friction_angle and efficiency"
            )
        if self.flank_angle is not None and self.friction_coefficient is None:
            raise ParameterError(f"flank_angle does not apply with {stated[0]}; remove it")
        self._check_limits()
        steep = self.angle + self.lead_angle
        if isinstance(steep, float):
            require(
                steep < 0.5 * math.pi,
                stated[0],
                getattr(self, stated[0]),
                "less: with the lead angle it reaches 90 deg",
            )

    def _check_limits(self) -> None:
        """Raise ParameterError if values that belong together are not stated together."""
        for one, other in (("length", "root_diameter"), ("dynamic_load", "life")):
            for has, lacks in ((one, other), (other, one)):
                if getattr(self, has) is not None and getattr(self, lacks) is None:
                    raise ParameterError(f"{lacks} is missing: {has} needs it")
        if self.length is None:
            for name, unset in (("ends", DEFAULT_ENDS), ("yield_strength", None)):
                if getattr(self, name) != unset:
                    raise ParameterError(
                        f"{name} does not apply without length and root_diameter, which buckling and critical speed need; "
                        "state them, or remove it"
                    )
        if isinstance(self.root_diameter, float) and isinstance(self.diameter, float):
            require(
                self.root_diameter <= self.diameter,
                "root_diameter",
                self.root_diameter,
                f"<= diameter = {self.diameter:g} m",
            )

    @property
    def travel_per_radian(self) -> Array:
        """Lead over a full turn. [m/rad]"""
        return self.lead / (2.0 * math.pi)

    @property
    def lead_angle(self) -> Array:
        """Lead angle at the pitch diameter. [rad]"""
        return lead_angle(self.lead, self.diameter)

    @property
    def angle(self) -> Array:
        """Friction angle of the thread, however friction is stated. [rad]"""
        if self.friction_angle is not None:
            return self.friction_angle
        if self.friction_coefficient is not None:
            return friction_angle(self.friction_coefficient, given(self.flank_angle, 0.0))
        return friction_angle_from(self.efficiency, self.lead_angle)

    @property
    def efficiencies(self) -> tuple[Array, Array]:
        """Efficiencies while the screw drives and while the load drives, without the constant friction torque. [-]"""
        forward, backward = screw_efficiencies(self.lead_angle, self.angle)
        return given(self.efficiency, forward), given(self.backdriving_efficiency, backward)

    @property
    def own_inertia(self) -> float | None:
        """Moment of inertia of the screw; None if not stated. [kg m^2]"""
        return self.inertia

    @property
    def self_locking(self) -> bool:
        """Whether friction of the thread holds any load without torque."""
        return bool(self.efficiencies[1] <= 0.0)

    def without_friction(self) -> Screw:
        """The screw without losses."""
        return replace(
            self,
            friction_coefficient=None,
            flank_angle=None,
            friction_angle=0.0,
            efficiency=None,
            backdriving_efficiency=None,
            friction_torque=0.0,
        )

    @property
    def buckling_load(self) -> Array | None:
        """Load at which the screw buckles; None without its dimensions. See `buckling_load`. [N]"""
        if self.length is None or self.root_diameter is None:
            return None
        return buckling_load(self.root_diameter, self.length, self.ends, self.modulus, self.yield_strength)

    @property
    def critical_speed(self) -> Array | None:
        """First critical speed in bending; None without its dimensions. See `critical_speed`. [rad/s]"""
        if self.length is None or self.root_diameter is None:
            return None
        return critical_speed(self.root_diameter, self.length, self.ends, self.modulus)

    def utilisation(self, *, force: Array, speed: Array) -> dict[Limit, Array]:
        """Demand over allowance of the limits whose values are stated.

        Parameters
        ----------
        force, speed : (...,) float   Of the nut. Either sign of the force counts as compression, as the screw's direction is
            not stated. [N], [m s^-1]

        Returns
        -------
        dict of Limit to (...,) float   Permissible force and speed, buckling, critical speed, rated life. [-]

        Source: see `buckling_load`, `critical_speed` and `life_demand`.
        """
        xp = namespace(self, force, speed)
        size, turning = xp.abs(force), xp.abs(speed / self.travel_per_radian)
        demand = force_limit(force, self.permissible_force)
        if self.max_speed is not None:
            demand[Limit.OUTPUT_SPEED] = turning / self.max_speed
        buckles, whirls = self.buckling_load, self.critical_speed
        if buckles is not None:
            demand[Limit.BUCKLING] = size * self.buckling_safety / buckles
        if whirls is not None:
            demand[Limit.CRITICAL_SPEED] = turning / (self.critical_share * whirls)
        if self.dynamic_load is not None:
            demand[Limit.LIFE] = life_demand(size, turning, self.dynamic_load, self.life)
        return demand
