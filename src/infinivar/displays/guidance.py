"""Limits that no controller removes: what the contact allows at a wall, what leaks through it, and when it slips."""

from __future__ import annotations

import math

import numpy as np
from annotated_types import Ge, Gt, Interval

from infinivar._core.described import derived, finite, reported
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.errors import ParameterError
from infinivar.transmission.guiding import largest_turn_rate, overrun, stopping_distance
from infinivar.transmission.legs import creep_drift
from infinivar.transmission.planar import PlanarCobot
from infinivar.transmission.spin_law import on_the_spot
from infinivar.units import plain


@result
class GuidanceLimits(Result):
    """What the contacts of a machine allow at a wall, as returned by `guidance_limits`.

    Attributes
    ----------
    machine : str             "link" for a cobotic drive, "body" for a planar cobot.
    push, speed, mass, angle : float   As given. [N], [m s^-1], [kg], [rad]
    slip_force : float        mu P, of all wheels: a push beyond it makes them slip. [N]
    rolling_speed : float     Of the wheels: R omega for a link, the speed of a body. [m s^-1]
    leak : float              Speed through the constraint per force, small forces: of a locked link while the cylinder turns,
        or of a body as it rolls along. 0 at rest. [m s^-1 N^-1]
    leak_speed : float        Speed through the constraint under the push, with the creep law of the wheels; nan beyond slip.
        [m s^-1]
    leak_per_angle : float    Creep under the push per angle steered at rest, to either side: why a controller must not
        dither. nan where spin of the contact is not known. [m rad^-1]
    turn_rate : float         Largest rate at which a body turns from the wall; nan for a link. [rad s^-1]
    overrun : float           How far it runs through the wall if it turns only from there on, or, for a link, in which
        distance it stops. [m]
    """

    machine: str = reported()
    push: float = reported("N", convert=finite)
    speed: float = reported("m/s", convert=finite)
    mass: float = reported("kg", convert=finite)
    angle: float = reported("rad", convert=finite)
    slip_force: float = reported("N", convert=finite)
    rolling_speed: float = reported("m/s", convert=finite)
    leak: float = reported("m/s/N", convert=finite)
    leak_speed: float = reported("m/s", convert=finite)
    leak_per_angle: float = reported("m/rad", convert=finite)
    turn_rate: float = reported("rad/s", convert=finite)
    overrun: float = reported("m", convert=finite)

    @derived()
    def slips(self) -> bool:
        """Whether the push makes the wheels slip, however they are steered."""
        return self.push >= self.slip_force

    @derived()
    def verdict(self) -> str:
        """One-sentence answer: slip, or overrun and leak."""
        if self.slips:
            return (
                f"Slips: the push of {plain(self.push, 3)} N is {self.push / self.slip_force:.2f} of the slip limit of "
                f"{plain(self.slip_force, 3)} N; no steering holds it."
            )
        passed = f"{plain(1e3 * self.overrun, 3)} mm past a wall met at {plain(self.speed, 3)} m/s"
        turning = f" (turning at {plain(self.turn_rate, 3)} rad/s at most)" if math.isfinite(self.turn_rate) else ""
        return (
            f"At least {passed}{turning} under a push of {plain(self.push, 3)} N, {self.push / self.slip_force:.2f} of the slip "
            f"limit; leak {plain(1e3 * self.leak, 3)} mm/s per N."
        )


def guidance_limits(
    machine: CoboticDrive | PlanarCobot,
    *,
    speed: float,
    push: float = 0.0,
    mass: float | None = None,
    angle: float = 0.5 * math.pi,
) -> GuidanceLimits:
    """What the contacts of a machine allow at a wall, whatever the controller.

    Parameters
    ----------
    machine : CoboticDrive or PlanarCobot
    speed : float   At which it meets the wall, > 0. [m s^-1]
    push : float    Of the user into the wall, >= 0. [N]
    mass : float    That moves, with what the user adds; by default that of the link or of the body. [kg]
    angle : float   Between path and wall of a body, 0 to pi; a link meets its wall head on. [rad]

    Returns
    -------
    GuidanceLimits   Of several wheels, with all their slip forces: the best that any share between them allows.

    Raises
    ------
    ParameterError
        If an argument is out of range, the machine is of another kind, or its mass is not known.

    Source: `infinivar.transmission.guiding`, `infinivar.transmission.legs.creep_drift` and the creep law of the wheels.
    """
    for name, value, unit, bound in (
        ("speed", speed, "m/s", Gt(0)),
        ("push", push, "N", Ge(0)),
        ("angle", angle, "rad", Interval(ge=0, le=math.pi)),
    ):
        check_number(name, value, unit, bound)
    if isinstance(machine, CoboticDrive):
        own, wheels, kind = machine.mass_of_link, (machine.transmission.wheel,) * machine.transmission.wheels, "link"
        rolling = abs(float(machine.transmission.cylinder_radius * machine.cylinder_speed))
    elif isinstance(machine, PlanarCobot):
        own, wheels, rolling, kind = machine.mass, tuple(machine.contacts), speed, "body"  # type: ignore[arg-type]
    else:
        raise ParameterError(f"machine must be a CoboticDrive or a PlanarCobot, got a {type(machine).__name__}")
    if mass is None and own is None:
        raise ParameterError("mass is missing: the machine does not state its own")
    moving = float(own if mass is None else mass)  # type: ignore[arg-type]
    check_number("mass", moving, "kg", Gt(0))
    groups = [wheel.groups(rolling) for wheel in wheels]
    slip_force = float(sum(one.slip_force for one in groups))
    stiffness = float(sum(one.creep_stiffness for one in groups))
    shares = [push * float(one.slip_force) / slip_force for one in groups]
    # Wheels side by side creep alike; with shares by slip force the worst one is an upper bound, and exact for equal wheels.
    creepage = max(
        float(wheel.creepage(share, groups=at)) for wheel, share, at in zip(wheels, shares, groups, strict=True)
    )
    known = all(wheel.contact is not None for wheel in wheels) and push < slip_force
    turned = [
        float(on_the_spot(wheel, np.float64(share))[0]) for wheel, share in zip(wheels, shares, strict=True) if known
    ]
    rate = float(largest_turn_rate(slip_force, push, moving, speed))
    bodily = kind == "body"
    return GuidanceLimits(
        machine=kind,
        push=float(push),
        speed=float(speed),
        mass=moving,
        angle=float(angle),
        slip_force=slip_force,
        rolling_speed=rolling,
        leak=float(creep_drift(np.eye(1), -np.ones(1), np.float64(rolling), np.float64(stiffness))[0]),
        leak_speed=rolling * creepage if push < slip_force else math.nan,
        leak_per_angle=max(turned) if turned else math.nan,
        turn_rate=rate if bodily else math.nan,
        overrun=overrun(speed, rate, angle) if bodily else stopping_distance(slip_force, push, moving, speed),
    )
