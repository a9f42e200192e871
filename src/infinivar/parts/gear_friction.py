r"""Friction of a geared actuator: Stribeck friction that depends on the load, from either side.

With the torque :math:`\tau_i` that enters the gear and the torque :math:`\tau_o` that leaves it, both at the output, the
friction torque at the output at a speed w is

.. math::

    \tau_i - \tau_o = f\,\mathrm{sgn}\,w, \qquad
    f = F + c|w| + |K_i\tau_i + K_o\tau_o| + S(w)\,(F_s + |K_{is}\tau_i + K_{os}\tau_o| + Q), \qquad
    S = e^{-|w/w_s|^\alpha}

with :math:`Q = Q_o \tau_o^2` while the motor drives, :math:`Q_i \tau_i^2` while the load drives, and 0 while both brake.
As f contains :math:`\tau_i = \tau_o \pm f`, the law is implicit. The right-hand side is a convex function of f with a slope
below 1, so that there is exactly one solution; it is positive, and the element dissipates in all four quadrants.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check, quantity
from infinivar._core.frozen import FrozenDict
from infinivar.bondgraph.graph import Parameter
from infinivar.contact.friction import coulomb
from infinivar.errors import require
from infinivar.parts.gear_law import GearLaw, GraphLaw

_UNBOUNDED = 1e300
"""Upper bound of the larger of two values: clipped, they stay one function in the equations of a bond graph, where a maximum
would branch, and branches within branches take minutes to derive."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GearFriction:
    """Friction of a geared actuator at its output, with terms for load and for slow motion.

    Terms left out are zero: ``friction`` and ``viscous`` alone are Coulomb and viscous friction.

    Raises
    ------
    ParameterError
        If a field is outside its range, or the load terms of the motor's side add up to 1 or more.
    """

    friction: float = quantity("N m", Ge(0), "Constant friction torque, F", default=0.0)
    viscous: float = quantity("N m s", Ge(0), "Friction torque per speed, c", default=0.0)
    friction_stribeck: float = quantity("N m", Ge(0), "Additional friction torque at rest, F_s", default=0.0)
    stribeck_speed: float = quantity("rad/s", Gt(0), "Output speed at which Stribeck terms fall to 1/e", default=1.0)
    stribeck_exponent: float = quantity("1", Gt(0), "Exponent of the fall of Stribeck terms with speed", default=1.0)
    load_motor: float = quantity("1", Ge(0), "Friction per torque from the motor, K_i", default=0.0)
    load_output: float = quantity("1", Ge(0), "Friction per torque on the load, K_o", default=0.0)
    load_motor_stribeck: float = quantity("1", Ge(0), "The same, additional at rest, K_is", default=0.0)
    load_output_stribeck: float = quantity("1", Ge(0), "The same, additional at rest, K_os", default=0.0)
    load_motor_squared: float = quantity(
        "1/(N m)",
        Ge(0),
        "Additional friction at rest per squared motor torque, while the load drives, Q_i",
        default=0.0,
    )
    load_output_squared: float = quantity(
        "1/(N m)",
        Ge(0),
        "Additional friction at rest per squared load torque, while the motor drives, Q_o",
        default=0.0,
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        jammed = self.load_motor + self.load_motor_stribeck
        if isinstance(jammed, (int, float)):
            require(
                jammed < 1.0, "load_motor + load_motor_stribeck", jammed, "< 1 (else no motor torque moves the gear)"
            )

    @property
    def largest_returned(self) -> float:
        """Smallest `returned` at which `friction_budget` has no unique solution: the gear jams. Infinity if there is none. [-]

        It exists where friction grows faster with the load than the load that drives the gear. Source: definition of f.
        """
        found = [math.inf]
        for one, other in itertools.product((1.0, -1.0), repeat=2):
            slope = one * self.load_motor + other * self.load_motor_stribeck
            fall = -one * (self.load_motor + self.load_output)
            fall -= other * (self.load_motor_stribeck + self.load_output_stribeck)
            if fall > 0.0:
                found.append((1.0 - slope) / fall)
        return min(found)

    @property
    def largest_load_factor(self) -> float:
        """Motor torque per torque on the load at rest, without constant and squared terms, while the motor drives. [-]"""
        out, entering = self.load_output + self.load_output_stribeck, self.load_motor + self.load_motor_stribeck
        return (1.0 + out) / (1.0 - entering)

    @property
    def is_zero(self) -> bool:
        """Whether every term is zero."""
        scales = ("stribeck_speed", "stribeck_exponent")
        return not any(getattr(self, one.name) for one in dataclasses.fields(self) if one.name not in scales)


def stribeck_factor(speed: Array, stribeck_speed: Array, exponent: Array) -> Array:
    """Share of the Stribeck terms at a speed: 1 at rest, 0 far above the Stribeck speed.

    Parameters
    ----------
    speed : (...,) float            Its sign does not matter. [rad s^-1]
    stribeck_speed : (...,) float   > 0. [rad s^-1]
    exponent : (...,) float         > 0. [-]

    Returns
    -------
    (...,) float   [-]

    Source: duclusaud2025, model M2.
    """
    xp = namespace(speed, stribeck_speed, exponent)
    relative = xp.abs(speed / stribeck_speed)
    moving = relative > 0
    # The power has an infinite slope at rest for an exponent below 1.
    return xp.where(moving, xp.exp(-(xp.where(moving, relative, 1.0) ** exponent)), 1.0)


def friction_budget(
    speed: Array,
    torque: Array,
    *,
    friction: Array,
    viscous: Array,
    friction_stribeck: Array,
    stribeck_speed: Array,
    stribeck_exponent: Array,
    load_motor: Array,
    load_output: Array,
    load_motor_stribeck: Array,
    load_output_stribeck: Array,
    load_motor_squared: Array,
    load_output_squared: Array,
    returned: Array = 0.0,
) -> Array:
    """Friction torque of a gear in motion, or the largest at rest, for the torque that leaves it.

    Parameters
    ----------
    speed, torque : (...,) float   Output speed, and torque on the load; at rest, the load is about to drive. [rad s^-1], [N m]
    returned : (...,) float        Fall of the torque that leaves the gear from `torque` per f, in the direction of motion, as
        friction between two inertias slows both; 0 to 1, and below `GearFriction.largest_returned`. [-]
    others : (...,) float          Fields of `GearFriction`.

    Returns
    -------
    (...,) float   f >= 0, at the output. [N m]

    Notes
    -----
    Identified from torques up to a few times the constant friction. The squared terms grow without bound: do not use them far
    beyond the loads that they were identified from. Inertia of the motor acts before the gear; the source counts it as part
    of the motor's torque, so the two differ while the speed changes.

    Source: duclusaud2025, model M6; solved for f here.
    """
    loads = (
        load_motor,
        load_output,
        load_motor_stribeck,
        load_output_stribeck,
        load_motor_squared,
        load_output_squared,
    )
    xp = namespace(
        speed, torque, friction, viscous, friction_stribeck, stribeck_speed, stribeck_exponent, *loads, returned
    )
    share = stribeck_factor(speed, stribeck_speed, stribeck_exponent)
    base = friction + viscous * xp.abs(speed) + share * friction_stribeck
    load = xp.abs(torque)
    ahead = xp.where(torque * speed > 0, load, -load)
    both, both_slow = load_motor + load_output, share * (load_motor_stribeck + load_output_stribeck)
    slope, slope_slow = load_motor - returned * both, share * load_motor_stribeck - returned * both_slow
    out, entering = share * load_output_squared, share * load_motor_squared
    # Each absolute value is the larger of two straight lines, and one of the squares is zero, so the solution is the largest of
    # those of the pieces.
    found = base
    for one, other in itertools.product((1.0, -1.0), repeat=2):
        left, piece = 1.0 - one * slope - other * slope_slow, base + (one * both + other * both_slow) * ahead
        for square in ((out, ahead, returned), (entering, -ahead, 1.0 - returned)):
            found = xp.clip(found, _piece(xp, left, piece, *square), _UNBOUNDED)
    return found


def _piece(xp: Array, left: Array, piece: Array, squared: Array, load: Array, returned: Array) -> Array:
    """Solution f of ``left f = piece + squared max(load - returned f, 0)^2``."""
    room = xp.clip(left * load - returned * piece, 0.0, _UNBOUNDED)
    torque = 2.0 * room / (left + xp.sqrt(left * left + 4.0 * returned * squared * room))
    return (piece + squared * torque * torque) / left


def stribeck_friction(
    speed: Array, torque: Array, ratio: Array, stick_speed: Array | None = None, *, gain: Array = 0.0, **terms: Array
) -> Array:
    """Friction torque at the motor of a gear with load-dependent Stribeck friction.

    Parameters
    ----------
    speed : (...,) float         Motor speed. [rad s^-1]
    torque : (...,) float        Torque that the gear transmits, at the motor and without friction. [N m]
    ratio : (...,) float         Motor speed over output speed. [-]
    stick_speed : (...,) float   As in `infinivar.contact.friction.coulomb`. [rad s^-1]
    gain : (...,) float          Change of the transmitted torque from `torque` per friction torque, -1 to 0. [-]
    terms                        Fields of `GearFriction`, at the output.

    Returns
    -------
    (...,) float   Opposes the motion. At rest it helps to hold the torque. [N m]

    Source: duclusaud2025, model M6.
    """
    xp = namespace(speed, torque, ratio, stick_speed, gain, *terms.values())
    acting = 1.0 if stick_speed is None else xp.abs(coulomb(speed, 1.0, stick_speed))
    size = friction_budget(speed / ratio, torque * ratio, returned=-gain * acting, **terms) / ratio
    return coulomb(speed, size, stick_speed, held=torque)


def terms(friction: GearFriction) -> dict[str, float]:
    """Fields by name, as `stribeck_friction` takes them."""
    return {one.name: getattr(friction, one.name) for one in dataclasses.fields(friction)}


_SYMBOLS = {
    "friction": "F_{{g,{0}}}",
    "viscous": "c_{{g,{0}}}",
    "friction_stribeck": "F_{{s,{0}}}",
    "stribeck_speed": r"\omega_{{s,{0}}}",
    "stribeck_exponent": r"\alpha_{0}",
    "load_motor": "K_{{i,{0}}}",
    "load_output": "K_{{o,{0}}}",
    "load_motor_stribeck": "K_{{is,{0}}}",
    "load_output_stribeck": "K_{{os,{0}}}",
    "load_motor_squared": "Q_{{i,{0}}}",
    "load_output_squared": "Q_{{o,{0}}}",
}
"""Symbols by field."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredLoss(GearLaw):
    """Measured friction of gear and motor together; it has no single efficiency."""

    friction: GearFriction

    NEEDS: ClassVar[tuple[str, ...]] = ("friction",)
    WORDS: ClassVar[str] = "measured friction"
    ORIGIN: ClassVar[str] = "is measured"

    @property
    def affine(self) -> bool:
        """No: load and speed act together."""
        return False

    @property
    def is_zero(self) -> bool:
        """Whether every term is zero."""
        return self.friction.is_zero

    @property
    def largest_load_factor(self) -> float:
        """See `GearFriction.largest_load_factor`. [-]"""
        return self.friction.largest_load_factor

    @property
    def largest_returned(self) -> float:
        """See `GearFriction.largest_returned`. [-]"""
        return self.friction.largest_returned

    def beyond_constant(self, speed: Array, torque: Array) -> Array:
        """All of it: `friction_budget`. [N m]"""
        return friction_budget(speed / self.ratio, torque * self.ratio, **terms(self.friction)) / self.ratio

    def without_friction(self) -> Mapping[str, Any]:
        """Every term zero."""
        return {"friction": GearFriction()}

    def graph_law(self, tag: str) -> GraphLaw:
        """`stribeck_friction`."""
        named = {name: Parameter(_SYMBOLS[name].format(tag), value) for name, value in terms(self.friction).items()}
        parameters = {"ratio": Parameter(f"n_{tag}", self.ratio), **named}
        return GraphLaw(law=stribeck_friction, parameters=FrozenDict(parameters), solved=stribeck_friction)

    def measured(self) -> Mapping[str, float]:
        """Its terms."""
        return terms(self.friction)
