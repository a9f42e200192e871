"""A body on steered wheels whose axles motors turn: at prescribed torques, or with those that a wrench on its load needs.

Equations and source: `infinivar.transmission.planar`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array, bisect, check_broadcast
from infinivar._core.arrays import real_array
from infinivar.errors import require
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.kinematics import Heading, directions
from infinivar.transmission.mechanism import Mechanism, MechanismPoint, _least

_LARGEST = 0.9
"""Longitudinal creepage beyond which a wheel counts as sliding. [-]"""

_CLOSE = 1e-9
"""Force or torque that is missing, over that of slip, in a solution. [-]"""

_STEPS = 40

_SETTLED = 1e-13
"""Force that is missing over that of slip, at which the search ends. [-]"""

_BESIDE = 1e-6
"""Creepage over that of full slip by which forces are differenced. [-]"""

_KEPT = 0.9
"""Largest step over the distance from the slip limit. [-]"""


def driven(body: Mechanism, twist: Array, heading: Heading, torque: Array) -> MechanismPoint:
    """See `infinivar.transmission.planar.PlanarCobot.drive`; `body` is its mechanism."""
    k = body.wheels
    given, torques = real_array("twist", twist), real_array("torque", torque)
    d = len(body.coordinates)  # type: ignore[arg-type]
    require(given.shape[-1:] == (d,), "twist", f"shape {given.shape}", f"of shape (..., {d})")
    require(torques.shape[-1:] in ((), (1,), (k,)), "torque", f"shape {torques.shape}", f"one number, or {k} of them")
    for name, values in (("twist", given), ("torque", torques)):
        require(bool(np.all(np.isfinite(values))), name, "nan or inf", "finite")
    cosine, sine = directions(np, heading, k)
    shape = check_broadcast(twist=given.shape[:-1], heading=cosine.shape[:-1], torque=torques.shape[:-1])
    cosine, sine, torques = (np.broadcast_to(one, (*shape, k)) for one in (cosine, sine, torques))
    given = np.broadcast_to(given, (*shape, d))
    contacts = [DrivenContact.of(one) for one in body.contacts]  # type: ignore[union-attr]
    motion = body.velocities(given)
    along = cosine * motion[..., :k] + sine * motion[..., k : 2 * k]
    across = cosine * motion[..., k : 2 * k] - sine * motion[..., :k]
    spin = body.spins(motion, 0.0)
    spin = np.zeros_like(along) if spin is None else spin
    speeds = np.stack(
        [
            _speed(one, *(row[..., place] for row in (along, across, spin, torques)))
            for place, one in enumerate(contacts)
        ],
        axis=-1,
    )
    return _rolling(body, contacts, given, cosine, sine, speeds)


class _Creeping(NamedTuple):
    """Wheels at creepages along and across their headings, (..., k) each; forces and headings in axes of the body."""

    x: np.ndarray
    """Force on the wheel. [N]"""
    y: np.ndarray
    turning: np.ndarray
    """Moment on the wheel about the normal. [N m]"""
    torque: np.ndarray
    """That its motor must exert on the axle. [N m]"""
    cosine: np.ndarray
    """Of its heading."""
    sine: np.ndarray
    speed: np.ndarray
    """Of its axle. [rad s^-1]"""
    demand: np.ndarray
    """Of slip. [-]"""


def _creeping(
    contact: DrivenContact, along: Array, across: Array, ahead: Array, aside: Array, speed: Array, spin: Array
) -> _Creeping:
    """Wheels whose carriers move along unit vectors (`ahead`, `aside`) at a speed."""
    stretch = np.hypot(1.0 + along, across)
    # The carrier moves at the slip angle to the left of the heading.
    v, cosine, sine = speed / stretch, (1.0 + along) / stretch, across / stretch
    x, y = ahead * cosine + aside * sine, aside * cosine - ahead * sine
    found, groups = contact.act((along * v, across * v), spin=spin, surface_speed=v), contact.groups(v)
    return _Creeping(
        x=found.x * x - found.y * y,
        y=found.x * y + found.y * x,
        turning=-found.moment,
        torque=contact.wheel_radius * found.x + groups.rolling_torque + groups.bearing_torque,
        cosine=x,
        sine=y,
        speed=v / contact.wheel_radius,
        demand=found.slip_demand,
    )


def hauling(body: Mechanism, twist: Array, wrench: Array, motors: Array, steering_rate: Array = 0.0) -> MechanismPoint:
    """Steady motion of a body on steered wheels, some of which are driven, under a wrench on its load.

    All motors exert the same torque on their axles; the other axles turn freely. What headings and torque leave open is that
    with the smallest sum of squares of the forces on the wheels, to first order in the creepages.

    Parameters
    ----------
    body : Mechanism                   Map from d rates of the body to k carriers, at one configuration.
    twist, wrench : (..., d) float     The wrench is that of the body on its load.
    motors : k booleans                Whether a wheel is driven; one at least.
    steering_rate : (..., k) float     Of the headings, for contacts that turn with spin. [rad s^-1]

    Returns
    -------
    MechanismPoint
        As of `driven`, with headings along the motion of each wheel; forces agree with the wrench to 1e-9 of the slip force.
        nan where a wheel would slip or stands, or no headings and common torque balance the wrench.

    Source: as in `infinivar.transmission.planar`; Newton's method from the motion without creep, with steps that end within slip.
    """
    d, k = len(body.coordinates), body.wheels  # type: ignore[arg-type]
    contacts = [DrivenContact.of(one) for one in body.contacts]  # type: ignore[union-attr]
    own = Mechanism(contacts=contacts, jacobian=body.jacobian, spin=body.spin, coordinates=body.coordinates)
    rates, load, turning = (np.asarray(one, dtype=float) for one in (twist, wrench, steering_rate))
    shape = np.broadcast_shapes(rates.shape[:-1], load.shape[:-1], turning.shape[:-1])
    rates, load = (np.broadcast_to(one, (*shape, d)) for one in (rates, load))
    motion = own.velocities(rates)
    vx, vy = motion[..., :k], motion[..., k : 2 * k]
    speed, spin = np.hypot(vx, vy), own.spins(motion, turning)
    rolls = speed > 0.0
    safe = np.where(rolls, speed, 1.0)
    spin = np.zeros_like(speed) if spin is None else np.broadcast_to(spin, speed.shape)
    columns = (np.where(rolls, vx / safe, 1.0), vy / safe, safe, spin)
    balance, required = _balance(own, motors, load)
    scale = np.array([_full_slip(one) for one in contacts]).T

    def parts(scaled: np.ndarray) -> tuple[_Creeping, np.ndarray]:
        """Wheels at creepages (2, ..., k) over those of full slip, and what enters the balance: (..., 4, k)."""
        found = own.by_contact(
            np, _creeping, *(scale[:, None] * scaled.reshape(2, -1, k)).reshape(scaled.shape), *columns
        )
        return found, np.stack(np.broadcast_arrays(*found[:4]), axis=-2)

    at = np.zeros((2, *shape, k))
    for _ in range(_STEPS):
        _, here = parts(at)
        missing = np.einsum("mpk,...pk->...m", balance, here) - required
        if np.all(np.max(np.abs(missing), axis=-1) <= _SETTLED):
            break
        slopes = []
        for place in (0, 1):
            beside = at.copy()
            beside[place] += _BESIDE
            slopes.append(np.einsum("mpk,...pk->...mk", balance, (parts(beside)[1] - here) / _BESIDE))
        change = -_least(np, np.concatenate(slopes, axis=-1), missing)
        change = np.stack([change[..., :k], change[..., k:]])
        size, step = np.hypot(*at), np.hypot(*change)
        room = _KEPT * (1.0 - size)
        share = np.min(np.where(step > room, room / np.where(step > 0.0, step, 1.0), 1.0), axis=-1)
        at = at + share[..., None] * change
    found, here = parts(at)
    missing = np.einsum("mpk,...pk->...m", balance, here) - required
    solved = (
        (np.max(np.abs(missing), axis=-1) <= _CLOSE) & (np.max(found.demand, axis=-1) <= 1.0) & np.all(rolls, axis=-1)
    )
    lost = np.where(solved, 1.0, np.nan)[..., None]
    return _rolling(own, contacts, rates, found.cosine * lost, found.sine * lost, found.speed * lost, steering_rate)


def ground_forces(body: Mechanism, point: MechanismPoint) -> np.ndarray:
    """Forces of the ground on the wheels of a body at points of `driven` or `hauling`, in its axes: (..., k, 2). [N]"""
    contacts = [DrivenContact.of(one) for one in body.contacts]  # type: ignore[union-attr]
    cosine, sine = np.asarray(point.cosine), np.asarray(point.sine)
    still = np.ones(cosine.shape), np.zeros(cosine.shape)
    found, _ = _machine(body, contacts, cosine, sine).forces(np.asarray(point.rates), still, point.steering_rate)
    x, y = np.asarray(found.x), np.asarray(found.y)
    return np.stack([x * cosine - y * sine, x * sine + y * cosine], axis=-1)


def _full_slip(contact: DrivenContact) -> tuple[float, float]:
    """Creepages along and across the heading at which the wheel slips. [-]"""
    groups = contact.groups(0.0)
    across = float(groups.slip_creepage(contact.creep_law) / groups.creep_group)
    return across / contact.stiffness_ratio, across


def _balance(own: Mechanism, motors: Array, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What wheels must balance, without units: factors (d + k - 1, 4, k) of their forces, moments and torques, and the sums
    (..., d + k - 1), of forces on each coordinate, and of torques that are equal of motors and zero of other axles."""
    k, rows, force = own.wheels, np.asarray(own.rows), own.reference_force
    d = rows.shape[-1]
    unit = np.sqrt(np.sum(rows[: 2 * k] ** 2, axis=0) / k)
    unit = np.where(unit > 0.0, unit, 1.0) * force
    found = np.zeros((d + k - 1, 4, k))
    found[:d, : len(rows) // k] = (rows / unit).T.reshape(d, -1, k)
    lead, *others = np.flatnonzero(motors)
    equal = np.eye(k)
    equal[others, lead] = -1.0
    radii = np.array([one.wheel_radius for one in own.contacts])  # type: ignore[union-attr]
    found[d:, 3] = np.delete(equal, lead, axis=0) / (force * radii)
    return found, np.concatenate([load / unit, np.zeros((*load.shape[:-1], k - 1))], axis=-1)


def _rolling(
    body: Mechanism,
    contacts: list[DrivenContact],
    twist: np.ndarray,
    cosine: np.ndarray,
    sine: np.ndarray,
    speeds: np.ndarray,
    steering_rate: Array = 0.0,
) -> MechanismPoint:
    """Wheels whose axles turn at speeds, with what the motors exert on them."""
    machine = _machine(body, contacts, cosine, sine)
    rates = np.concatenate([np.broadcast_to(twist, (*speeds.shape[:-1], twist.shape[-1])), speeds], axis=-1)
    point = machine.operate(rates=rates, heading=np.zeros(len(contacts)), steering_rate=steering_rate)
    return _with_resistance(point, contacts, speeds, cosine, sine)


def _speed(contact: DrivenContact, along: Array, across: Array, spin: Array, torque: Array) -> np.ndarray:
    """Speed of the axle of one wheel; nan where no rolling wheel transmits the torque. [rad s^-1]"""
    way = np.sign(along)

    def missing(creepage: np.ndarray) -> np.ndarray:
        """Torque that remains at a creepage, which it rises with."""
        rolling = along / (1.0 + creepage * way)
        groups = contact.groups(rolling)
        found = contact.act((along - rolling, across), spin=spin, surface_speed=rolling)
        resisted = (groups.rolling_torque + groups.bearing_torque) * way
        return torque - contact.wheel_radius * found.x - resisted

    moves = way != 0
    along, way = np.where(moves, along, 1.0), np.where(moves, way, 1.0)
    ends = np.full(along.shape, _LARGEST)
    creepage = bisect(np, missing, -ends, ends)
    found = moves & (np.abs(missing(creepage)) <= _CLOSE * contact.slip_force * contact.wheel_radius)
    return np.where(found, along / (1.0 + creepage * way) / contact.wheel_radius, np.nan)


def _machine(body: Mechanism, contacts: list[DrivenContact], cosine: np.ndarray, sine: np.ndarray) -> Mechanism:
    """The kinematic map of body and axles, along and across each heading."""
    rows, k = np.asarray(body.jacobian), len(contacts)
    d = rows.shape[-1]
    radii = np.array([one.wheel_radius for one in contacts])
    jacobian = np.zeros((*cosine.shape, 2, d + k))
    jacobian[..., 0, :d] = cosine[..., None] * rows[:, 0] + sine[..., None] * rows[:, 1]
    jacobian[..., 1, :d] = cosine[..., None] * rows[:, 1] - sine[..., None] * rows[:, 0]
    places = np.arange(k)
    jacobian[..., places, 0, d + places] = -radii
    surface, spin = np.zeros((k, d + k)), np.zeros((k, d + k))
    surface[places, d + places] = radii
    if body.spin is not None:
        spin[:, :d] = body.spin
    names = (*body.coordinates, *(f"wheel{place + 1}" for place in places))  # type: ignore[misc]
    return Mechanism(contacts=contacts, jacobian=jacobian, spin=spin, surface=surface, coordinates=names)


def _with_resistance(
    point: MechanismPoint, contacts: list[DrivenContact], speeds: np.ndarray, cosine: np.ndarray, sine: np.ndarray
) -> MechanismPoint:
    """With the rolling and bearing torques, which the contact of a driven wheel leaves to its axle."""
    losses: dict[str, Any] = {name: np.array(loss) for name, loss in point.wheel_losses.items()}
    applied = np.array(point.applied)
    for place, contact in enumerate(contacts):
        speed = speeds[..., place]
        groups = contact.groups(contact.wheel_radius * speed)
        for name, torque in (("rolling", groups.rolling_torque), ("bearing", groups.bearing_torque)):
            losses[name][..., place] += torque * np.abs(speed)
            applied[..., -len(contacts) + place] -= torque * np.sign(speed)
    return replace(point, applied=applied, wheel_losses=losses, cosine=cosine, sine=sine)
