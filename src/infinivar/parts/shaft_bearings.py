r"""Two bearings that hold a shaft under forces across and along it: a cylinder under its wheels, a pulley under its belt.

Signs of the cylinder: z along its axis from the first bearing to the second, which is at L; a wheel at place z = x and azimuth
0 presses along -e_r. It takes the torque tau from the cylinder and pushes its link with f_l, so that the cylinder receives
``-P e_r - (tau/R) e_t - f_l e_z`` at ``R e_r + x e_z``. Equilibrium of the cylinder gives the forces of the bearings on it,

.. math::
    F_1 &= \left[P\left(1 - \tfrac{x}{L}\right) + f_l\tfrac{R}{L}\right] e_r + \tfrac{\tau}{R}\left(1 - \tfrac{x}{L}\right) e_t \\
    F_2 &= \left[P\tfrac{x}{L} - f_l\tfrac{R}{L}\right] e_r + \tfrac{\tau}{R}\tfrac{x}{L} e_t

with the thrust ``f_l`` on the locating bearing. Forces of several wheels add up as vectors before their sizes are taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, NamedTuple

from annotated_types import Ge, Gt

from infinivar._core.array_namespace import Array, as_floats, namespace, plain
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, component, given, quantities, quantity
from infinivar.contact.friction import coulomb
from infinivar.errors import ParameterError, require
from infinivar.parts.bearing import Bearing

Locating = Literal["first", "second"]


class WheelLoad(NamedTuple):
    """What a wheel does to its cylinder; arrays that broadcast."""

    preload: Array
    """P. [N]"""
    torque: Array
    """tau, from the cylinder to the wheel. [N m]"""
    force: Array
    """f_l, of the transmission on the link. [N]"""
    radius: Array
    """R of the cylinder. [m]"""
    position: Array = 0.0
    """Of the link. [m]"""
    azimuth: float = 0.0
    """Around the cylinder. [rad]"""


def spread(load: WheelLoad, wheels: int) -> list[WheelLoad]:
    """Equal wheels evenly around the cylinder that share torque and force of a load; the preload is of each."""
    if wheels == 1:
        return [load]
    shared = load._replace(torque=load.torque / wheels, force=load.force / wheels)
    return [shared._replace(azimuth=load.azimuth + 2.0 * math.pi * place / wheels) for place in range(wheels)]


class Reactions(NamedTuple):
    """Sizes of the forces on two bearings; >= 0. [N]"""

    first: tuple[Array, Array]
    """Radial and axial."""
    second: tuple[Array, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftBearings:
    """Two equal bearings on a shaft, with one way to know their friction: a part, a coefficient, or a measured torque.

    Raises
    ------
    ParameterError
        If a field is out of range, the bearing cannot carry radial load, or not exactly one way is given.
    """

    title: ClassVar[str] = "shaft bearings"
    """Key of the loss in results."""

    bearing: Bearing | None = component("Each of the two bearings, with its friction model", default=None)
    friction_coefficient: float | None = quantity(
        "1", Ge(0), "Coefficient mu of friction mu F d/2 of each bearing, instead of a part", default=None
    )
    bore: float | None = quantity("m", Gt(0), "Bore d to which friction_coefficient refers", default=None)
    torque: float | None = quantity(
        "N m", Ge(0), "Measured friction torque of both bearings, independent of load; instead of a part", default=None
    )
    span: float | None = quantity(
        "m",
        Gt(0),
        "Distance between the bearings; without it each carries half, and tilting is neglected",
        default=None,
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)
        ways = [name for name in ("bearing", "friction_coefficient", "torque") if getattr(self, name) is not None]
        if len(ways) != 1:
            had = f"{' and '.join(ways)} exclude each other" if ways else "bearing is missing"
            raise ParameterError(f"{had}: give exactly one of bearing, friction_coefficient with bore, and torque")
        if (self.bore is None) != (self.friction_coefficient is None):
            required = "friction_coefficient needs it" if self.bore is None else "it belongs to friction_coefficient"
            raise ParameterError(f"bore {'is missing' if self.bore is None else 'does not apply'}: {required}")
        if self.bearing is not None:
            kind = self.bearing.type
            require(kind in ("deep_groove", "angular_contact"), "bearing.type", kind, _WANTED)

    @property
    def depends_on_load(self) -> bool:
        """Whether the friction depends on what the bearings carry."""
        return self.torque is None

    def static_demand(self, loads: Reactions) -> Array:
        """Equivalent static load over static rating of the more heavily loaded bearing, which must be a part. [-]

        Source: as `Bearing.static_safety`.
        """
        assert self.bearing is not None
        first, second = (1.0 / self.bearing.static_safety(*load) for load in loads)
        xp = namespace(first, second)
        return xp.maximum(*as_floats(xp, first, second))

    def life(self, loads: Reactions) -> Array:
        """Basic rating life of both bearings, which must be a part, under loads along the last axis, each as long as the others.

        Returns
        -------
        (...,) float   Revolutions that 90 % of pairs reach; without the last axis of the loads.

        Source: iso2007 (damage adds up); `Bearing.life_of_pair`.
        """
        assert self.bearing is not None
        damages = [self.bearing.damage(*one) for one in loads]
        return self.bearing.life_of_pair(*(namespace(one).mean(one, axis=-1) for one in damages))

    def journal_stress(self, loads: Reactions, torque: Array) -> Array:
        """Stress of the solid shaft in the more heavily loaded bearing, a part, under bending and torsion.

        Parameters
        ----------
        loads : Reactions
        torque : (...,) float   Through the shaft. [N m]

        Returns
        -------
        (...,) float   Equivalent stress by von Mises, for the force at the middle of the bearing and a shoulder at its side. [Pa]

        Source: budynas2011, section 7-4 (bending 32 M/(pi d^3), torsion 16 T/(pi d^3)).
        """
        assert self.bearing is not None
        radial = (loads.first[0], loads.second[0])
        xp = namespace(torque, *radial)
        moment = 0.5 * self.bearing.breadth * xp.maximum(*as_floats(xp, *radial))
        modulus = math.pi * self.bearing.bore**3 / 32.0
        return (moment**2 + 0.75 * torque**2) ** 0.5 / modulus

    def friction(self, loads: Reactions, speed: Array) -> Array:
        """Friction torque of both bearings under their loads.

        Parameters
        ----------
        loads : Reactions
        speed : (...,) float   Of the shaft; its sign does not matter. [rad s^-1]

        Returns
        -------
        (...,) float   >= 0. [N m]

        Source: that of `Bearing.moment`; with a coefficient, skf2013, Eq ``M = 0.5 mu P d`` with the resultant force for P.
        """
        (radial_1, axial_1), (radial_2, axial_2) = loads
        xp = namespace(self, radial_1, axial_1, speed)
        if self.bearing is not None:
            return self.bearing.moment(*loads.first, speed).total + self.bearing.moment(*loads.second, speed).total
        if self.friction_coefficient is not None and self.bore is not None:
            resultants = size(xp, radial_1, axial_1) + size(xp, radial_2, axial_2)
            return 0.5 * self.friction_coefficient * self.bore * resultants + 0.0 * xp.abs(speed)
        return self.torque + 0.0 * (radial_1 + xp.abs(speed))


_WANTED = "deep_groove or angular_contact, which carry load across and along the shaft"


def size(xp: Any, *components: Array) -> Array:
    """Size of a vector, with a finite gradient (0) at zero; nan of a part that is nan."""
    square = sum(one * one for one in components)
    return xp.where(square > 0, xp.sqrt(xp.where(square > 0, square, 1.0)), 0.0 * square)


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderBearings(ShaftBearings):
    """The cylinder's own bearings: they react the preload of every wheel, its tangential force, thrust and tilting moment.

    Backing rollers opposite the wheel, idle, steered with it and like it, carry the preload instead (one at 180 degrees, two at
    120 degrees): the cylinder's bearings keep tangential force, thrust and tilt, and each roller costs the rolling resistance of
    the wheel at the surface speed. What it costs beyond to roll along the link, and to steer the rollers, is not included.

    Raises
    ------
    ParameterError
        As `ShaftBearings`; if backing_rollers is not 0, 1 or 2, or if a place along the cylinder is given without span.
    """

    title: ClassVar[str] = "cylinder bearings"

    wheel_position: float | None = quantity(
        "m", FINITE, "Distance of the wheel from the first bearing with the link at 0; default: midway", default=None
    )
    locating: Locating = component("Bearing that takes the thrust of the link: first or second", default="first")
    pull: float = quantity(
        "N", Ge(0), "Constant force of a belt or gear that turns the cylinder, across it", default=0.0
    )
    pull_position: float | None = quantity(
        "m", FINITE, "Distance of that force from the first bearing; beyond the span it is overhung", default=None
    )
    pull_direction: float = quantity("rad", FINITE, "Its direction from that of the preload at azimuth 0", default=0.0)
    azimuths: tuple[float, ...] | None = quantities(
        "rad", FINITE, "Azimuth of each leg around a common cylinder; default: evenly spaced", default=None
    )
    backing_rollers: int = component("Idle rollers that carry the preload: 0, 1 or 2", default=0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        ShaftBearings.__post_init__(self)
        rollers = self.backing_rollers
        whole = isinstance(rollers, int) and not isinstance(rollers, bool) and 0 <= rollers <= 2
        require(whole, "backing_rollers", repr(rollers), "0, 1 (at 180 degrees) or 2 (at 120 degrees)")
        for name in ("wheel_position", "pull_position"):
            if getattr(self, name) is not None and self.span is None:
                raise ParameterError(f"span is missing: {name} needs it")
        if self.span is not None and self.pull_position is None and not _is_zero(self.pull):
            raise ParameterError("pull_position is missing: pull needs it where span is given")

    def around(self, count: int) -> tuple[float, ...]:
        """Azimuths of the legs of a common cylinder. [rad]

        Raises
        ------
        ParameterError
            If the azimuths given are not as many.
        """
        if self.azimuths is None:
            return tuple(2.0 * math.pi * place / count for place in range(count))
        require(
            len(self.azimuths) == count,
            "cylinder_bearings.azimuths",
            f"{len(self.azimuths)} values",
            f"{count}, one for each leg",
        )
        return self.azimuths

    def reactions(self, wheels: Sequence[WheelLoad]) -> Reactions:
        """Loads on both bearings.

        Parameters
        ----------
        wheels : sequence of WheelLoad   One or more; arrays that broadcast.

        Returns
        -------
        Reactions   [N]

        Source: static equilibrium of the cylinder; see the module.
        """
        xp = namespace(self, *(part for wheel in wheels for part in wheel))
        share = 0.5 if self.span is None or self.pull_position is None else self.pull_position / self.span
        (direction,) = as_floats(xp, self.pull_direction)
        across, beside = self.pull * xp.cos(direction), self.pull * xp.sin(direction)
        # Of the first bearing along and at right angles to azimuth 0, of the second likewise, and along the axis.
        sums: list[Any] = [across * (1.0 - share), beside * (1.0 - share), across * share, beside * share, 0.0]
        for wheel in wheels:
            held = 0.0 * wheel.preload if self.backing_rollers else wheel.preload
            tangential, tilt, share = wheel.torque / wheel.radius, 0.0 * wheel.force, 0.5
            if self.span is not None:
                begin = 0.5 * self.span if self.wheel_position is None else self.wheel_position
                share, tilt = (begin + wheel.position) / self.span, wheel.force * wheel.radius / self.span
            cosine, sine = math.cos(wheel.azimuth), math.sin(wheel.azimuth)
            for place, (along, round_) in enumerate(
                (
                    (held * (1.0 - share) + tilt, tangential * (1.0 - share)),
                    (held * share - tilt, tangential * share),
                )
            ):
                sums[2 * place] = sums[2 * place] + along * cosine - round_ * sine
                sums[2 * place + 1] = sums[2 * place + 1] + along * sine + round_ * cosine
            sums[4] = sums[4] + wheel.force
        first, second = size(xp, sums[0], sums[1]), size(xp, sums[2], sums[3])
        thrust = xp.abs(sums[4])
        none = 0.0 * thrust
        return (
            Reactions((first, thrust), (second, none))
            if self.locating == "first"
            else Reactions((first, none), (second, thrust))
        )

    def moment(self, wheels: Sequence[WheelLoad], speed: Array) -> Array:
        """Friction torque of both bearings under the wheels' loads; see `friction`. [N m]"""
        return self.friction(self.reactions(wheels), speed)

    def operate(
        self, wheels: Sequence[WheelLoad], speed: Array, *, torque: Array, rolling: Array = 0.0
    ) -> tuple[Array, dict[str, Array]]:
        """Torque that the cylinder's plant needs for bearings and backing rollers, and the losses in them.

        Parameters
        ----------
        wheels : sequence of WheelLoad
        speed : (...,) float     Of the cylinder. [rad s^-1]
        torque : (...,) float    On the cylinder without friction: at rest, friction helps to hold it. [N m]
        rolling : (...,) float   Rolling resistance of all wheels at the surface, (tau_in + tau_wa)/r. [N]

        Returns
        -------
        torque, losses : (...,) float, mapping   With the sign of the speed; losses by name. [N m], [W]

        Source: faulring2006, Fig 12 (cylinder bearings); `Bearing.moment`.
        """
        drag = coulomb(speed, self.moment(wheels, speed), held=torque)
        losses = {self.title: drag * speed}
        if not self.backing_rollers:
            return drag, losses
        backed = coulomb(speed, self.roller_torque(rolling, wheels[0].radius), held=torque + drag)
        return drag + backed, {**losses, ROLLERS: backed * speed}

    def roller_torque(self, rolling: Array, radius: Array) -> Array:
        """Torque on the cylinder of all backing rollers behind wheels of a rolling resistance [N]. [N m]"""
        return self.backing_rollers * rolling * radius

    def midway(self) -> CylinderBearings:
        """The bearings with their loads shared equally: a wheel that stays near the middle, without tilt."""
        return replace(self, span=None, wheel_position=None, pull_position=None)

    def unloaded(self, speed: float) -> CylinderBearings:
        """The bearings with all wheels lifted off: their friction at a speed [rad/s] as a constant torque."""
        lifted = WheelLoad(preload=0.0, torque=0.0, force=0.0, radius=1.0)
        alone = float(self.moment([lifted], speed))
        return replace(self, bearing=None, friction_coefficient=None, bore=None, torque=alone, backing_rollers=0)


ROLLERS = "backing rollers"
"""Key of the loss of backing rollers in results."""


def _is_zero(value: Array) -> bool:
    return isinstance(value, (int, float)) and value == 0


@dataclass(frozen=True, slots=True, kw_only=True)
class PulleyBearings(ShaftBearings):
    """Bearings of the shaft of a pulley, belt wheel or pinion under the pull of belt, cable or teeth.

    The tensions of a belt that stays taut on both sides add up to twice its initial tension, whatever torque it transmits, so
    that the load is constant: 2 to 3 times the largest force that the belt has to transmit.

    Raises
    ------
    ParameterError
        As `ShaftBearings`, and if position is given without span.
    """

    title: ClassVar[str] = "pulley bearings"

    pull: float | None = quantity(
        "N",
        Ge(0),
        "Force across the shaft: sum of the tensions of both spans, 2 to 3 times the largest belt force",
        default=None,
    )
    position: float | None = quantity(
        "m",
        FINITE,
        "Distance of the pull from the first bearing; default: midway; beyond the span it is overhung",
        default=None,
    )
    speed: float = quantity("rad/s", Ge(0), "Shaft speed at which a maker's model is evaluated", default=10.0)

    def __post_init__(self) -> None:
        """Validate the fields."""
        ShaftBearings.__post_init__(self)
        if self.position is not None and self.span is None:
            raise ParameterError("span is missing: position needs it")
        if self.pull is None and self.depends_on_load:
            raise ParameterError("pull is missing: the friction depends on it")

    @property
    def friction_torque(self) -> Array:
        """Coulomb friction torque at the shaft. [N m]

        Source: static equilibrium of the shaft; that of `friction`.
        """
        share = 0.5 if self.span is None or self.position is None else self.position / self.span
        xp, pull = namespace(self), given(self.pull, 0.0)
        if not self.depends_on_load:
            return self.torque
        loads = Reactions((xp.abs(pull * (1.0 - share)), 0.0), (xp.abs(pull * share), 0.0))
        found = self.friction(loads, self.speed)
        # A constant of the drive: a plain number goes with arrays of any library.
        return plain(found)
