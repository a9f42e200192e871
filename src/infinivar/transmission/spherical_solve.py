"""Steady operation of a sphere between rollers: Newton's method for its angular velocity and the free shaft speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.result import Result, result
from infinivar.contact.friction import coulomb
from infinivar.limits import Limit
from infinivar.power import PowerPoint
from infinivar.transmission.rolling_contact import ContactForces

_STEPS = 40
_HALVINGS = 14
"""Most times that a step is shortened until the residual falls."""

_BEYOND = 1.03
"""Force of the drive rollers without losses over the slip force, beyond which no steady motion is looked for, besides resistance
to rolling. [-]"""

_STALLED = 0.999
"""Residual after a step over that before it at which the iteration of a point ends. [-]"""

_WAY = (0.0, 0.5, 0.8, 0.94, 1.0)
"""Shares of the load on the way to a point that the iteration has not found. [-]"""

_CHUNK = 8192

STANDING = 1e-4
"""Rolling speed over that of the surface of the sphere, below which a roller creeps as if it rolled as fast. A loaded roller that
does not roll would not creep at all. [-]"""

_ASIDE = 2e-5
"""Change of the start of a second iteration, as friction is steep where a shaft stands still. [-]"""

_STEP = 1e-9
"""Velocity over that of the surface with which slopes are computed. [-]"""

_SETTLED = 1e-12
"""Largest residual over the slip force at which the iteration of a point ends. [-]"""

_CLOSE = 1e-9
"""Largest residual of a solution, over the slip force. [-]"""


@result
class SphericalPoint(PowerPoint, Result):
    """Steady operation: arrays over (...,) points, or (..., k) rollers, SI.

    Where a roller slips, speeds, forces and losses are nan, and the limit is SLIP.
    """

    contact: ClassVar[str] = "roller"
    """What touches."""
    kinds: tuple[str, ...]
    """"drive", "steering" or "idler", by roller."""
    steering_angle: Array
    """gamma. [rad]"""
    input_speed: Array
    """w_1. [rad s^-1]"""
    output_speed: Array
    """w_2. [rad s^-1]"""
    input_torque: Array
    """tau_1, applied to shaft 1. [N m]"""
    output_torque: Array
    """T_2, applied by shaft 2 to its load. [N m]"""
    sphere_velocity: Array
    """Angular velocity of the sphere. (..., 3) [rad s^-1]"""
    ideal_speeds: Array
    """w_1 and w_2 without creep, over the speed of the sphere. (..., 2) [-]"""
    roller_forces: Array
    """Tangential force between roller and sphere. (..., k) [N]"""
    contact_force: Array
    """Tangential force of each roller on the sphere, rolling resistance included. (..., k, 3) [N]"""
    spin: Array
    """psi. (..., k) [rad s^-1]"""
    roller_losses: Mapping[str, Array]
    """By name. (..., k) [W]"""
    slip_demand: Array
    """1 is the slip limit. (..., k) [-]"""
    pressed: Mapping[Limit, Array]
    """Demand over allowance for the limits that preload alone can exceed, of the worst roller. [-]"""

    @property
    def contact_losses(self) -> Mapping[str, Array]:
        """As `roller_losses`."""
        return self.roller_losses

    @property
    def losses(self) -> Mapping[str, Array]:
        """Losses of all rollers by name: creep, spin, rolling, bearing. [W]"""
        return {name: np.sum(loss, axis=-1) for name, loss in self.roller_losses.items()}

    @property
    def power_in(self) -> Array:
        """Power from the source into shaft 1. [W]"""
        return self.input_torque * self.input_speed

    @property
    def power_out(self) -> Array:
        """Power from shaft 2 into its load. [W]"""
        return self.output_torque * self.output_speed

    @property
    def slip(self) -> Array:
        """Loss of speed by creep, 1 - w_2 (w_1/w_2 without creep)/w_1; nan where a shaft stands still. [-]"""
        first, second = self.ideal_speeds[..., 0], self.ideal_speeds[..., 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            found = 1.0 - self.output_speed * first / (self.input_speed * second)
        return np.where(np.isfinite(found), found, np.nan)

    @property
    def utilisation(self) -> Mapping[Limit, Array]:  # type: ignore[override]
        """Demand over allowance by limit, of the worst roller. [-]"""
        return {Limit.SLIP: np.max(self.slip_demand, axis=-1), **self.pressed}


class _Batch(NamedTuple):
    """Points to solve, flat: prescribed motion and force, and the free unknowns' directions."""

    cosine: np.ndarray
    sine: np.ndarray
    axis: np.ndarray
    along: np.ndarray
    """Direction of the prescribed shaft speed, (m, 2)."""
    across: np.ndarray
    """Direction of the free one, whose torque is prescribed, (m, 2)."""
    speed: np.ndarray
    """Prescribed. [rad s^-1]"""
    torque: np.ndarray
    """Prescribed, on the load. [N m]"""
    turning: np.ndarray
    """Size of the speed of the sphere without creep. [rad s^-1]"""

    def take(self, places: np.ndarray) -> _Batch:
        return _Batch(*(one[places] for one in self))


def point(
    kinds: tuple[str, ...], frames: Any, angle: np.ndarray, speed: np.ndarray, force: np.ndarray, along_shaft: bool
) -> SphericalPoint:
    """See `SphericalIVT.operate`; arguments have one shape, and `kinds` are those of the rollers."""
    shape = angle.shape
    gamma, given, load = (one.reshape(-1) for one in (angle, speed, force))
    axis = frames.axis(gamma)
    ideal = frames.ideal(axis)
    if along_shaft:
        first = ideal[:, 0]
        locked = np.abs(first) < 1e-12 * np.abs(ideal[:, 1])
        turns = np.where(locked, np.nan, given / np.where(locked, 1.0, first))
        turns = np.where(given == 0, 0.0, turns)
        ones, zeros = np.ones_like(gamma), np.zeros_like(gamma)
        along, across = np.stack([ones, zeros], -1), np.stack([zeros, ones], -1)
        torque = load
    else:
        size = np.linalg.norm(ideal, axis=-1)
        along = ideal / size[:, None]
        across = np.stack([along[:, 1], -along[:, 0]], -1)
        turns, torque = given, -load * frames.sphere_radius / size
    # Forces do not depend on the size of the speed, except by bearings: at rest they are those of slow motion.
    rests = turns == 0
    moving = np.where(rests, 1e-6, turns)
    own = np.sum(ideal * along, axis=-1)
    prescribed = np.where(rests, moving * own, given if along_shaft else given * own)
    cosine, sine = frames.headings(gamma)
    batch = _Batch(cosine, sine, axis, along, across, prescribed, torque, np.abs(moving))
    rates = np.empty((gamma.size, 5))
    for start in range(0, gamma.size, _CHUNK):
        part = slice(start, start + _CHUNK)
        rates[part] = _solved(frames, _Batch(*(one[part] for one in batch)), moving[part, None] * ideal[part])
    return _point(kinds, frames, batch, rates, ideal, rests, angle, shape)


def _solved(frames: Any, batch: _Batch, ideal: np.ndarray) -> np.ndarray:
    """Rates (m, 5); nan where no solution is found."""
    scale = frames.sphere_radius * batch.turning
    free = np.sum(ideal * batch.across, axis=-1) * _radius(frames) / scale
    signed = np.where(np.sum(ideal * frames.ideal(batch.axis), axis=-1) < 0, -1.0, 1.0)
    start = np.concatenate([free[:, None], signed[:, None] * batch.axis], axis=-1)
    demand = _static_demand(frames, batch, ideal)
    found = _newton(frames, batch, np.where((demand < _beyond(frames))[:, None], start, np.nan))
    # Near slip, and near a locked shaft, the way there is followed from no load, where the drive rollers can transmit the force.
    lost = np.flatnonzero(np.isnan(found[:, 0]) & np.isfinite(start[:, 0]))
    lost = lost[demand[lost] < 1.0]
    if lost.size:
        at = start[lost] + _ASIDE
        for share in _WAY:
            part = batch.take(lost)
            at = _newton(frames, part._replace(torque=share * part.torque), at)
            reached = ~np.isnan(at[:, 0])
            lost, at = lost[reached], at[reached]
        found[lost] = at
    known = ~np.isnan(found[:, 0])
    rates = np.full((len(scale), 5), np.nan)
    rates[known] = _rates(frames, batch.take(known), found[known])
    return rates


def _beyond(frames: Any) -> float:
    """Static demand beyond which there is no steady motion: resistance to rolling relieves a drive roller by no more."""
    resisting = sum(float(np.max(one.groups(0.0).rolling_force)) for one in frames.contacts)
    return _BEYOND + resisting / _reference(frames)


def _reference(frames: Any) -> float:
    """Slip force of a drive roller. [N]"""
    return frames.contacts[int(np.flatnonzero(frames.shaft)[0])].slip_force


def _static_demand(frames: Any, batch: _Batch, ideal: np.ndarray) -> np.ndarray:
    """Force of the drive rollers without losses, over the slip force. [-]"""
    across = np.stack([ideal[:, 1], -ideal[:, 0]], axis=-1)
    share = np.sum(across * batch.across, axis=-1)
    torque = across * (batch.torque / np.where(share == 0, np.nan, share))[:, None]
    worst = np.zeros(len(torque))
    for shaft in (1, 2):
        places = np.flatnonzero(frames.shaft == shaft)
        most = sum(frames.radii[one] * frames.contacts[one].slip_force for one in places)
        worst = np.maximum(worst, np.abs(torque[:, shaft - 1]) / most)
    return worst


def _newton(frames: Any, batch: _Batch, start: np.ndarray) -> np.ndarray:
    """Unknowns (m, 4) of the solution; nan where none is found."""
    unknown, found = start.copy(), np.full(start.shape, np.nan)
    active = np.flatnonzero(np.all(np.isfinite(unknown), axis=-1))
    missing, size = _residual(frames, batch.take(active), unknown[active])
    for _ in range(_STEPS):
        if not active.size:
            break
        part, here = batch.take(active), unknown[active]
        trial, there, size_there = _improved(frames, part, here, missing, size)
        better = size_there <= size
        unknown[active] = np.where(better[:, None], trial, here)
        missing = np.where(better[:, None], there, missing)
        now = np.where(better, size_there, size)
        ended = (now <= _SETTLED) | (now > _STALLED * size)
        close = active[ended & (now <= _CLOSE)]
        found[close] = unknown[close]
        active, missing, size = active[~ended], missing[~ended], now[~ended]
    return found


def _improved(
    frames: Any, batch: _Batch, here: np.ndarray, missing: np.ndarray, size: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unknowns after a step that is shortened until the residual falls, the missing forces there and the largest of them."""
    # All four directions at once: with few points, calls cost more than their lengths.
    count = len(here)
    aside = (here[:, None, :] + _STEP * np.eye(4)).reshape(-1, 4)
    off = _residual(frames, batch.take(np.repeat(np.arange(count), 4)), aside)[0].reshape(count, 4, 4)
    slope = np.swapaxes(off - missing[:, None, :], 1, 2) / _STEP
    step = _steps(slope, missing)
    share, trial = np.ones(len(here)), here - step
    there, size_there = _residual(frames, batch, trial)
    for _ in range(_HALVINGS):
        worse = np.flatnonzero(~(size_there <= size * (1.0 - 1e-4)) & (size > _SETTLED))
        if not worse.size:
            break
        share[worse] *= 0.5
        trial[worse] = here[worse] - share[worse, None] * step[worse]
        there[worse], size_there[worse] = _residual(frames, batch.take(worse), trial[worse])
    return trial, there, size_there


def _steps(slope: np.ndarray, missing: np.ndarray) -> np.ndarray:
    """Newton steps, of singular systems short ones."""
    ridge = 1e-13 * np.max(np.abs(slope), axis=(1, 2))
    ridge = np.where(ridge > 0, ridge, 1.0)
    slope = np.where(np.isfinite(slope), slope, 0.0) + ridge[:, None, None] * np.eye(4)
    step = np.linalg.solve(slope, np.where(np.isfinite(missing), missing, 0.0)[..., None])[..., 0]
    # No more than a part of the velocity of the surface.
    most = np.max(np.abs(step), axis=-1, keepdims=True)
    return step * np.minimum(1.0, 0.05 / np.where(most > 0, most, 1.0))


def _radius(frames: Any) -> float:
    return float(frames.radii[np.flatnonzero(frames.shaft)[0]])


def _rates(frames: Any, batch: _Batch, unknown: np.ndarray) -> np.ndarray:
    scale = (frames.sphere_radius * batch.turning)[:, None]
    free = unknown[:, :1] * scale / _radius(frames)
    shafts = batch.along * batch.speed[:, None] + batch.across * free
    return np.concatenate([shafts, unknown[:, 1:] * scale / frames.sphere_radius], axis=-1)


def _residual(frames: Any, batch: _Batch, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Missing forces over the slip force, (m, 4), and the largest of a point."""
    rates = _rates(frames, batch, unknown)
    exerted = _forces(frames, batch, rates)[1]
    reference = _reference(frames)
    torque = batch.torque - np.sum(exerted[:, :2] * batch.across, axis=-1)
    missing = (
        np.concatenate([torque[:, None] / _radius(frames), -exerted[:, 2:] / frames.sphere_radius], axis=-1) / reference
    )
    size = np.max(np.abs(missing), axis=-1)
    return missing, np.where(np.isnan(size), np.inf, size)


_Forces = tuple[ContactForces, np.ndarray, dict[str, np.ndarray], np.ndarray]


def _forces(frames: Any, batch: _Batch, rates: np.ndarray) -> _Forces:
    """Forces of the contacts, those on the coordinates with the resistance of rollers on fixed axles, losses by it, its force."""
    return forces_at(frames, (batch.cosine, batch.sine), rates, STANDING * frames.sphere_radius * batch.turning)


def forces_at(
    frames: Any, heading: tuple[np.ndarray, np.ndarray], rates: np.ndarray, stick: Any, steering_rate: Any = 0.0
) -> _Forces:
    """The same at headings (m, k), rates (m, 5) and stick speeds (m,) or one [m s^-1], while rollers are steered."""
    mechanism = frames.mechanism(*heading)
    sticks = stick[:, None] if isinstance(stick, np.ndarray) else stick
    forces, exerted = mechanism.forces(rates, heading, steering_rate, stick_speed=sticks)
    losses, held = {"rolling": 0.0 * forces.x, "bearing": 0.0 * forces.x}, 0.0 * forces.x
    for place in np.flatnonzero(~frames.steered):
        row, contact = frames.rolling_rows[place], frames.contacts[place]
        speed = rates @ row
        groups = contact.groups(speed)
        for name, torque in (("rolling", groups.rolling_torque), ("bearing", groups.bearing_torque)):
            resisted = coulomb(speed, torque / contact.wheel_radius, stick)
            exerted = exerted - resisted[:, None] * row
            losses[name][:, place] = resisted * speed
            held[:, place] += resisted
    return forces, exerted, losses, held


def _point(
    kinds: tuple[str, ...],
    frames: Any,
    batch: _Batch,
    rates: np.ndarray,
    ideal: np.ndarray,
    rests: np.ndarray,
    angle: np.ndarray,
    shape: tuple[int, ...],
) -> SphericalPoint:
    forces, exerted, shaft_losses, held = _forces(frames, batch, rates)
    # What the forces on the sphere miss to balance, within rounding, does no work of its own.
    turns = batch.speed != 0
    over = np.sum(exerted[:, 2:] * rates[:, 2:], axis=-1) * turns / np.where(turns, batch.speed, 1.0)
    exerted = np.concatenate([exerted[:, :2] + over[:, None] * batch.along, exerted[:, 2:]], axis=-1)
    k = len(frames.contacts)
    at_rest = rests[:, None]
    losses = {}
    for name in ("creep", "spin", "rolling", "bearing"):
        known = forces.losses.get(name, 0.0 * forces.x) + shaft_losses.get(name, 0.0)
        losses[name] = np.where(at_rest, 0.0, known).reshape(*shape, k)
    lost = np.any(np.isnan(rates), axis=-1)
    rates = np.where(at_rest & ~lost[:, None], 0.0, rates)
    demand = np.where(lost[:, None], np.inf, forces.slip_demand)
    # On the sphere; the resistance of a drive roller acts on its shaft, that of an idler on the sphere.
    along = -forces.x + np.where(~frames.steered & (frames.shaft == 0), held, 0.0)
    pushed = along[..., None] * frames.tangents[0] - forces.y[..., None] * frames.tangents[1]
    force = np.hypot(forces.x, forces.y)
    force = np.where(frames.steered, np.abs(forces.lateral_force), force)
    pressed: dict = {}
    for contact in {id(one): one for one in frames.contacts}.values():
        for limit, value in contact.utilisation.items():
            pressed[limit] = max(pressed.get(limit, 0.0), float(value))
    return SphericalPoint(
        kinds=kinds,
        steering_angle=angle,
        input_speed=rates[:, 0].reshape(shape),
        output_speed=rates[:, 1].reshape(shape),
        input_torque=-exerted[:, 0].reshape(shape),
        output_torque=exerted[:, 1].reshape(shape),
        sphere_velocity=rates[:, 2:].reshape(*shape, 3),
        ideal_speeds=ideal.reshape(*shape, 2),
        roller_forces=force.reshape(*shape, k),
        contact_force=pushed.reshape(*shape, k, 3),
        spin=(rates @ frames.spin.T).reshape(*shape, k),
        roller_losses=losses,
        slip_demand=demand.reshape(*shape, k),
        pressed=pressed,
    )
