"""Rolling bearings: frictional moment, rating life and static safety, for single bearings and for pairs on an axle.

Formulas of the frictional moment for deep groove and angular contact bearings: skf2013, table 2a. Constants: skf2018,
where at least two independent public transcriptions of its tables agree. That covers every deep groove series, and the
row "other single row" of angular contact bearings (series 72 and 73 have separate rows). The constants of thrust ball
bearings come from one transcription. Roller bearings have the simple model only: their constants depend on the series,
and at most one transcription is available. Tapered roller bearings are not included, because their life requires factors
that differ for each bearing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, as_floats, namespace, safe_divide
from infinivar._core.bounds import QUARTER_TURN
from infinivar._core.fields import check, component, given, quantity
from infinivar.errors import require
from infinivar.parts.structure.beams import STEEL_DENSITY

BearingType = Literal["deep_groove", "angular_contact", "thrust_ball", "cylindrical", "needle"]
# fmt: off
Series = Literal[
    "other", "2", "3", "42", "43", "60", "630", "62", "622", "63", "623", "64", "160", "161",
    "617", "618", "628", "637", "638", "619", "639",
]
# fmt: on
FrictionModel = Literal["skf", "coefficient"]
Lubrication = Literal["grease", "oil_air", "oil_bath"]

COEFFICIENTS = {
    "deep_groove": 0.0015,
    "angular_contact": 0.0020,
    "thrust_ball": 0.0013,
    "cylindrical": 0.0011,
    "needle": 0.0020,
}
"""Constant coefficient of friction by type, for open bearings and rollers with a cage. Source: skf2013, table 1."""

SIZE_POWERS = {"bore": 1.0, "outside_diameter": 1.0, "dynamic_rating": 2.0, "static_rating": 2.0}
"""Exponent with which each field scales with bearing size; the ratings scale with area."""

_WIDTH_OVER_SECTION, _FILLED = 0.5, 0.67
"""Width over the difference of the diameters, and share of a solid ring of steel that a ball bearing weighs.

Fitted to the catalogue of deep groove bearings, whose rows deviate by up to 20 % in width and 10 % in mass.
"""

_DEEP_GROOVE = {  # R1, R2, S1, S2
    ("2", "3"): (4.4e-7, 1.7, 2.00e-3, 100.0),
    ("42", "43"): (5.4e-7, 0.96, 3.00e-3, 40.0),
    ("60", "630"): (4.1e-7, 1.7, 3.73e-3, 14.6),
    ("62", "622"): (3.9e-7, 1.7, 3.23e-3, 36.5),
    ("63", "623"): (3.7e-7, 1.7, 2.84e-3, 92.8),
    ("64",): (3.6e-7, 1.7, 2.43e-3, 198.0),
    ("160", "161"): (4.3e-7, 1.7, 4.63e-3, 4.25),
    ("617", "618", "628", "637", "638"): (4.7e-7, 1.7, 6.50e-3, 0.78),
    ("619", "639"): (4.3e-7, 1.7, 4.75e-3, 3.6),
}
_BY_SERIES = {series: row for group, row in _DEEP_GROOVE.items() for series in group}
_ANGULAR_CONTACT = (5.03e-7, 1.97, 1.90e-12, 1.30e-2, 0.68, 1.91e-12)  # R1, R2, R3, S1, S2, S3
_THRUST_BALL = (1.03e-6, 1.6e-2)  # R1, S1
_K_Z = {"deep_groove": 3.1, "angular_contact": 4.4, "thrust_ball": 3.8}
_K_RS = {"grease": 6e-8, "oil_air": 6e-8, "oil_bath": 3e-8}

# iso2007, table 3: deep groove, Y by f0 Fa/C0; angular contact, X and Y by contact angle. iso2006, table 2: Y0 by it.
_F0_FA_C0 = (0.172, 0.345, 0.689, 1.03, 1.38, 2.07, 3.45, 5.17, 6.89)
_Y_DEEP_GROOVE = (2.30, 1.99, 1.71, 1.55, 1.45, 1.31, 1.15, 1.04, 1.00)
_ANGLE = tuple(math.radians(angle) for angle in (20, 25, 30, 35, 40, 45))
_X_ANGLE = (0.43, 0.41, 0.39, 0.37, 0.35, 0.33)
_Y_ANGLE = (1.00, 0.87, 0.76, 0.66, 0.57, 0.50)
_Y0_ANGLE = (0.42, 0.38, 0.33, 0.29, 0.26, 0.22)

_RATING_LIFE = 1e6
"""Revolutions at the dynamic rating."""


def _interpolated(xp: Any, at: Array, points: tuple[float, ...], values: tuple[float, ...]) -> Array:
    """Piecewise linear through the points, constant beyond the first and the last."""
    result = values[0] + 0.0 * at
    for low, high, first, last in zip(points, points[1:], values, values[1:], strict=False):
        result = result + (last - first) / (high - low) * xp.clip(at - low, 0.0, high - low)
    return result


def _power(xp: Any, base: Array, exponent: float) -> Array:
    """`base ** exponent` for base >= 0, with a finite gradient (0) at 0 for an exponent below 1."""
    positive = base > 0
    return xp.where(positive, xp.where(positive, base, 1.0) ** exponent, 0.0)


def ring_mass(bore: Array, outside_diameter: Array, width: Array) -> Array:
    """Estimate of the mass of a ball bearing by its size. [m], [m], [m] -> [kg]

    Source: `_FILLED`, fitted to the catalogue.
    """
    return _FILLED * STEEL_DENSITY * 0.25 * math.pi * (outside_diameter**2 - bore**2) * width


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingMoment:
    """Frictional moment of a bearing by source; arrays of one shape, >= 0, opposing rotation. [N m]"""

    rolling: Array
    sliding: Array
    seal: Array
    drag: Array

    @property
    def total(self) -> Array:
        """Sum of all sources; multiplied by the speed it gives the loss. [N m]"""
        return self.rolling + self.sliding + self.seal + self.drag


@dataclass(frozen=True, slots=True, kw_only=True)
class Bearing:
    """Rolling bearing with its catalogue data, lubricant and a friction model.

    - ``skf``: rolling, sliding, seal and drag moments of the SKF model, for ball bearings. The load-dependent moments
      grow with powers of the load (sliding with Fr^(5/3)). As speed builds up a film of lubricant with `viscosity`, the
      sliding coefficient changes from `boundary_friction` to `ehl_friction`.
    - ``coefficient``: ``0.5 mu P d`` at any speed, with the bore d and the equivalent load P of `life`. SKF states it for
      loads of about a tenth of the dynamic rating and good lubrication.

    The signs of loads and speed do not matter. A thrust ball bearing carries no radial load, and a roller bearing (with
    rings without flanges) no axial load: under such a load, life and static safety are 0 and the moment ignores it.

    The lubricant's defaults are assumptions: a grease with mineral base oil of 100 mm^2/s at running temperature.
    `calculation_factor` defaults to the value behind textbook tables of Y over Fa/C0.

    Raises
    ------
    ParameterError
        If a field is out of range, if the ``skf`` model has no constants for the type or series, or if `oil_level` and
        `drag_factor` are missing for an oil bath.
    """

    name: str = component("Name for reports", default="bearing")
    type: BearingType = component("Bearing type, single row with a cage", default="deep_groove")
    series: Series = component("Series of a deep groove bearing; required by the skf model", default="other")
    bore: float = quantity("m", Gt(0), "Bore diameter d")
    outside_diameter: float = quantity("m", Gt(0), "Outside diameter D")
    dynamic_rating: float = quantity("N", Gt(0), "Basic dynamic load rating C")
    static_rating: float = quantity("N", Gt(0), "Basic static load rating C0")
    calculation_factor: float = quantity(
        "1", Gt(0), "Factor f0 for the axial load of a deep groove bearing", default=12.3
    )
    contact_angle: float = quantity(
        "rad",
        Interval(gt=0, le=QUARTER_TURN),
        "Contact angle of angular contact bearings, 20 to 45 deg",
        default=math.radians(40),
    )
    friction_model: FrictionModel = component("skf (ball bearings) or coefficient (simple)", default="skf")
    friction_coefficient: float | None = quantity(
        "1", Ge(0), "Friction coefficient of the simple model; default: the catalogue value for the type", default=None
    )
    viscosity: float = quantity(
        "m^2/s", Gt(0), "Kinematic viscosity of the (base) oil at running temperature", default=100e-6
    )
    lubrication: Lubrication = component("grease, oil_air, or oil_bath with a low oil level", default="grease")
    oil_level: float | None = quantity("m", Gt(0), "Depth H of an oil bath in the bearing", default=None)
    drag_factor: float | None = quantity("1", Ge(0), "Factor V_M of an oil bath, from SKF's diagram", default=None)
    boundary_friction: float = quantity("1", Ge(0), "Sliding coefficient without a film, when turning", default=0.12)
    starting_friction: float = quantity("1", Ge(0), "Sliding coefficient at rest", default=0.15)
    ehl_friction: float = quantity(
        "1", Ge(0), "Sliding coefficient with a full film; synthetic oil 0.04, transmission fluid 0.1", default=0.05
    )
    seal_torque: float = quantity("N m", Ge(0), "Constant moment of contact seals", default=0.0)
    width: float | None = quantity("m", Gt(0), "Width B; default: half of outside diameter less bore", default=None)
    mass: float | None = quantity("kg", Gt(0), "Mass; default: two thirds of that of a solid ring", default=None)

    def __post_init__(self) -> None:
        """Validate the fields, and that the friction model has constants for the bearing."""
        check(self)
        if isinstance(self.bore, (int, float)) and isinstance(self.outside_diameter, (int, float)):
            required = f"> bore ({self.bore:g} m)"
            require(self.outside_diameter > self.bore, "outside_diameter", self.outside_diameter, required)
        if self.friction_model == "skf":
            required = f"coefficient for a {self.type} bearing (the skf model has no confirmed constants for this type)"
            require(self.type in _K_Z, "friction_model", self.friction_model, required)
            named = self.type != "deep_groove" or self.series != "other"
            require(named, "series", self.series, "the series of the deep groove bearing, which the skf model requires")
            for field in ("oil_level", "drag_factor"):
                bath, given = self.lubrication == "oil_bath", getattr(self, field)
                require((given is not None) == bath, field, given, "set if, and only if, lubrication = oil_bath")

    @property
    def breadth(self) -> Array:
        """Width B: as stated, else estimated. [m]

        Source: `_WIDTH_OVER_SECTION`, fitted to the catalogue.
        """
        return given(self.width, _WIDTH_OVER_SECTION * (self.outside_diameter - self.bore))

    @property
    def weight(self) -> Array:
        """Mass: as stated, else estimated; see `ring_mass`. [kg]"""
        return given(self.mass, ring_mass(self.bore, self.outside_diameter, self.breadth))

    def moment(self, radial: Array, axial: Array, speed: Array) -> BearingMoment:
        """Frictional moment under a load at a speed.

        Parameters
        ----------
        radial, axial : (...,) float   Loads; their sign does not matter. [N]
        speed : (...,) float           Relative speed of the rings; its sign does not matter. [rad s^-1]

        Returns
        -------
        BearingMoment
            By source; inputs broadcast. The simple model reports rolling and sliding together in `sliding`. At speed 0
            this is the starting moment: sliding with `starting_friction`, and seals. [N m]

        Notes
        -----
        The published model has two steps. When rotation starts, the sliding coefficient falls from `starting_friction`
        to `boundary_friction`. The sliding moment of a deep groove bearing jumps as soon as any axial load acts: the
        exponent of the mean diameter in mm is -0.26 without axial load and -0.145 with it, a factor of dm^0.115 (1.37
        for a 608).

        Source: skf2013, tables 1 and 2a; skf2018 (constants, starting and running coefficient).
        """
        xp, radial, axial, speed = self._loads(radial, axial, speed)
        seal = xp.zeros_like(radial) + self.seal_torque
        if self.friction_model == "skf":
            rolling, sliding, drag = self._skf(xp, radial, axial, speed)
        else:
            known = self.friction_coefficient
            coefficient = COEFFICIENTS[self.type] if known is None else known
            rolling = drag = xp.zeros_like(radial)
            sliding = 0.5 * coefficient * self.bore * self._equivalent(xp, radial, axial)[0]
        return BearingMoment(rolling=rolling, sliding=sliding, seal=seal, drag=drag)

    def starting_moment(self, radial: Array, axial: Array) -> Array:
        """Moment that starts the bearing turning, as `moment` at speed 0.

        Parameters
        ----------
        radial, axial : (...,) float   Loads; their sign does not matter. [N]

        Returns
        -------
        (...,) float   [N m]

        Source: skf2018 (sliding and seal moment, no film).
        """
        return self.moment(radial, axial, 0.0).total

    def life(self, radial: Array, axial: Array) -> Array:
        """Basic rating life, which 90 % of such bearings reach.

        Parameters
        ----------
        radial, axial : (...,) float   Constant loads; their sign does not matter. [N]

        Returns
        -------
        (...,) float   Revolutions; infinite without load.

        Notes
        -----
        Valid for normal clearance. The equivalent load is the greater of Fr and X Fr + Y Fa; the standard's limit e gives
        the same result within 0.6 %, with a step at e. Y is interpolated in f0 Fa/C0 (or in the contact angle), and
        constant beyond the table.

        Source: iso2007, Eq 1 and table 3.
        """
        damage = self.damage(radial, axial)
        return safe_divide(namespace(damage), _RATING_LIFE, damage, math.inf)

    def life_of_pair(self, first: Array, second: Array) -> Array:
        """Revolutions that 90 % of pairs of such bearings reach, of the damage of each, or its mean over a motion.

        Source: product of Weibull distributions of one slope, 10/9 for ball and 9/8 for roller bearings.
        """
        xp = namespace(first, second)
        slope = 9.0 / 8.0 if self.type in ("cylindrical", "needle") else 10.0 / 9.0
        return safe_divide(xp, _RATING_LIFE, _power(xp, first**slope + second**slope, 1.0 / slope), math.inf)

    def static_safety(self, radial: Array, axial: Array) -> Array:
        """Static load rating over equivalent static load, s0.

        Parameters
        ----------
        radial, axial : (...,) float   Greatest loads; their sign does not matter. [N]

        Returns
        -------
        (...,) float   Infinite without load; below about 1 the raceways are indented. [-]

        Source: iso2006, Eq for P0 and table 2.
        """
        xp, radial, axial, _ = self._loads(radial, axial, 0.0)
        safety = safe_divide(xp, self.static_rating, self._equivalent(xp, radial, axial)[1], math.inf)
        return xp.where(self._refused(radial, axial) > 0, 0.0, safety)

    def _loads(self, radial: Array, axial: Array, speed: Array) -> tuple[Any, Array, Array, Array]:
        """Array namespace, and magnitudes of the loads and the speed in one shape."""
        xp = namespace(self, radial, axial, speed)
        return xp, *xp.broadcast_arrays(*(xp.abs(value) for value in as_floats(xp, radial, axial, speed)))

    def _refused(self, radial: Array, axial: Array) -> Array:
        """Load that a bearing of this type cannot carry."""
        return {"thrust_ball": radial, "cylindrical": axial, "needle": axial}.get(self.type, 0.0 * radial)

    def _equivalent(self, xp: Any, radial: Array, axial: Array) -> tuple[Array, Array]:
        """Equivalent dynamic and static load, ignoring loads that the type cannot carry."""
        if self.type == "thrust_ball":
            return axial, axial
        if self.type in ("cylindrical", "needle"):
            return radial, radial
        if self.type == "deep_groove":
            y = _interpolated(xp, self.calculation_factor * axial / self.static_rating, _F0_FA_C0, _Y_DEEP_GROOVE)
            mixed, static = 0.56 * radial + y * axial, 0.6 * radial + 0.5 * axial
        else:
            (angle,) = as_floats(xp, self.contact_angle)
            x, y, y0 = (_interpolated(xp, angle, _ANGLE, values) for values in (_X_ANGLE, _Y_ANGLE, _Y0_ANGLE))
            mixed, static = x * radial + y * axial, 0.5 * radial + y0 * axial
        return xp.maximum(radial, mixed), xp.maximum(radial, static)

    def damage(self, radial: Array, axial: Array) -> Array:
        """Fraction of its rating life that a million revolutions under constant loads [N] consume; as for `life`. [-]"""
        xp, radial, axial, _ = self._loads(radial, axial, 0.0)
        exponent = 10.0 / 3.0 if self.type in ("cylindrical", "needle") else 3.0
        damage = (self._equivalent(xp, radial, axial)[0] / self.dynamic_rating) ** exponent
        return xp.where(self._refused(radial, axial) > 0, math.inf, damage)

    def _skf(self, xp: Any, radial: Array, axial: Array, speed: Array) -> tuple[Array, Array, Array]:
        """Rolling, sliding and drag moment of the SKF model. [N m]"""
        # All but the last line use the model's units: mm, N, r/min, mm2/s and N mm.
        bore, outside = 1e3 * self.bore, 1e3 * self.outside_diameter
        mean, turns, viscosity = 0.5 * (bore + outside), speed * (30.0 / math.pi), 1e6 * self.viscosity

        g_rr, g_sl = self._load_variables(xp, radial, axial, turns, mean)
        k_z, slenderness = _K_Z[self.type], (outside + bore) / (outside - bore)
        shear_heating = 1.0 / (1.0 + 1.84e-9 * (turns * mean) ** 1.28 * viscosity**0.64)
        gaps = (bore + outside) * (k_z / (2.0 * (outside - bore))) ** 0.5
        starvation = xp.exp(-_K_RS[self.lubrication] * viscosity * turns * gaps)
        rolling = shear_heating * starvation * g_rr * _power(xp, viscosity * turns, 0.6)

        boundary = xp.exp(-2.6e-8 * (turns * viscosity) ** 1.4 * mean)
        running = boundary * self.boundary_friction + (1.0 - boundary) * self.ehl_friction
        sliding = g_sl * xp.where(turns > 0, running, self.starting_friction)

        drag = xp.zeros_like(radial)
        if self.oil_level is not None and self.drag_factor is not None:
            rows = 2.0 if self.series in ("42", "43") else 1.0
            (depth,) = as_floats(xp, 1e3 * self.oil_level / (0.6 * mean))
            wetted = 2.0 * xp.acos(xp.clip(1.0 - depth, -1.0, 1.0))
            f_t = xp.where(wetted <= math.pi, xp.sin(0.5 * wetted), 1.0)
            r_s = 0.36 * mean**2 * (wetted - xp.sin(wetted)) * 0.05 * k_z * slenderness
            churning = 0.4 * self.drag_factor * rows * k_z * slenderness * 1e-12 * mean**5 * turns**2
            # n^2 (n dm^2 f_t / nu)^-1.379 with the powers of n combined, so that it is 0 at rest.
            scale = _power(xp, turns, 2.0 - 1.379) * (mean**2 * f_t / viscosity) ** -1.379
            drag = churning + 1.093e-7 * mean**3 * scale * r_s
        return 1e-3 * rolling, 1e-3 * sliding, 1e-3 * drag

    def _load_variables(self, xp: Any, radial: Array, axial: Array, turns: Array, mean: float) -> tuple[Array, Array]:
        """G_rr and G_sl for a mean diameter in mm, turns in r/min."""
        if self.type == "deep_groove":
            r1, r2, s1, s2 = _BY_SERIES[self.series]
            pushed = axial > 1e-15 * self.static_rating  # powers of smaller loads underflow
            push = xp.where(pushed, axial, 1.0)
            # The formula holds for axial loads below the static rating; at 200 times that the angle exceeds 90 degrees.
            angle = math.radians(24.6) * (push / self.static_rating) ** 0.24
            # Smallest angles of loads that count are 1e-4; without a load generated code divides by the sine all the same.
            sine = xp.sin(xp.clip(angle, 1e-6, 0.5 * math.pi))
            g_rr = r1 * mean**1.96 * _power(xp, radial + xp.where(pushed, r2 / sine * push, 0.0), 0.54)
            combined = mean**-0.145 * (radial**5 + s2 * mean**1.5 / sine * push**4) ** (1.0 / 3.0)
            return g_rr, s1 * xp.where(pushed, combined, mean**-0.26 * radial ** (5.0 / 3.0))
        if self.type == "angular_contact":
            r1, r2, r3, s1, s2, s3 = _ANGULAR_CONTACT
            spin = mean**4 * turns**2
            g_rr = r1 * mean**1.97 * _power(xp, radial + r3 * spin + r2 * axial, 0.54)
            return g_rr, s1 * mean**0.26 * ((radial + s3 * spin) ** (4.0 / 3.0) + s2 * axial ** (4.0 / 3.0))
        r1, s1 = _THRUST_BALL
        return r1 * mean**1.83 * _power(xp, axial, 0.54), s1 * mean**0.05 * axial ** (4.0 / 3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PairMoment:
    """Frictional moments of the two bearings of a pair."""

    first: BearingMoment
    second: BearingMoment

    @property
    def total(self) -> Array:
        """Moment of both bearings; multiplied by the speed it gives the loss. [N m]"""
        return self.first.total + self.second.total


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingPair:
    """Two equal bearings on one axle that carry a radial preload and a lateral force at a lever arm (the wheel radius).

    Each carries half the preload, plus or minus the tilting moment over the span; a negative load acts in the opposite
    direction. One bearing alone carries the lateral force axially: the one with the greater radial load, which is the
    worse case (the first if they are equal). Axial forces that angular contact bearings exert on each other are not
    included.

    Raises
    ------
    ParameterError
        If a field is out of range, or if the bearings cannot carry radial load.
    """

    bearing: Bearing = component("Each of the two bearings")
    span: float | None = quantity(
        "m", Gt(0), "Distance between the bearings; without it tilting is neglected", default=None
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        require(self.bearing.type != "thrust_ball", "bearing", self.bearing.type, "a type that carries radial load")

    def loads(self, preload: Array, lateral: Array, lever: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Radial and axial load of the first and of the second bearing.

        Parameters
        ----------
        preload : (...,) float   Radial force on the axle, midway between the bearings, >= 0. [N]
        lateral : (...,) float   Force along the axle, at the lever; positive loads the first bearing. [N]
        lever : (...,) float     Distance of the lateral force from the axle. [m]

        Returns
        -------
        (radial, axial), (radial, axial) : (...,) float   All >= 0, inputs broadcast. [N]

        Source: static equilibrium of the axle.
        """
        xp = namespace(self, preload, lateral, lever)
        preload, lateral, lever = xp.broadcast_arrays(*as_floats(xp, preload, lateral, lever))
        tilt = xp.zeros_like(lateral) if self.span is None else lateral * lever / self.span
        first, second = xp.abs(0.5 * preload + tilt), xp.abs(0.5 * preload - tilt)
        locating, thrust = first >= second, xp.abs(lateral)
        return (first, xp.where(locating, thrust, 0.0)), (second, xp.where(locating, 0.0, thrust))

    def moment(self, preload: Array, lateral: Array, lever: Array, speed: Array) -> PairMoment:
        """Frictional moments of the pair, in total and by bearing.

        Parameters
        ----------
        preload, lateral, lever : (...,) float   As for `loads`. [N], [N], [m]
        speed : (...,) float                     Of the axle; its sign does not matter. [rad s^-1]

        Returns
        -------
        PairMoment   [N m]

        Notes
        -----
        The locating bearing's sliding moment jumps as a lateral force appears; see `Bearing.moment`.

        Source: as `Bearing.moment`.
        """
        first, second = self.loads(preload, lateral, lever)
        return PairMoment(first=self.bearing.moment(*first, speed), second=self.bearing.moment(*second, speed))

    def starting_moment(self, preload: Array, lateral: Array, lever: Array) -> Array:
        """Moment that starts the axle turning, as `moment` at speed 0.

        Parameters
        ----------
        preload, lateral, lever : (...,) float   As for `loads`. [N], [N], [m]

        Returns
        -------
        (...,) float   [N m]

        Source: as `Bearing.starting_moment`.
        """
        return self.moment(preload, lateral, lever, 0.0).total

    def life(self, preload: Array, lateral: Array, lever: Array) -> Array:
        """Basic rating life of the pair: revolutions that 90 % of pairs reach without a failure of either bearing.

        Survival probabilities multiply, so the pair's life is below the shorter of the two: 0.54 of it if they are equal.

        Parameters
        ----------
        preload, lateral, lever : (...,) float   Constant, as for `loads`. [N], [N], [m]

        Returns
        -------
        (...,) float   Revolutions; infinite without load.

        Source: iso2007 for each bearing; `Bearing.life_of_pair`.
        """
        first, second = self.loads(preload, lateral, lever)
        return self.bearing.life_of_pair(self.bearing.damage(*first), self.bearing.damage(*second))

    def static_safety(self, preload: Array, lateral: Array, lever: Array) -> Array:
        """The lesser static safety of the two bearings.

        Parameters
        ----------
        preload, lateral, lever : (...,) float   Greatest loads, as for `loads`. [N], [N], [m]

        Returns
        -------
        (...,) float   Infinite without load. [-]

        Source: as `Bearing.static_safety`.
        """
        first, second = self.loads(preload, lateral, lever)
        xp = namespace(self, first[0])
        return xp.minimum(self.bearing.static_safety(*first), self.bearing.static_safety(*second))
