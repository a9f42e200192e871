"""Steady motion of a machine of rolling contacts under prescribed forces: Newton's method, and static friction at rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, _repeat, namespace
from infinivar.contact.exact.spin_map import spin_map
from infinivar.errors import ParameterError
from infinivar.transmission import spin_law
from infinivar.transmission.contact_map import ContactMap, MechanismPoint
from infinivar.transmission.kinematics import Heading, applied_to, directions
from infinivar.transmission.rolling_contact import RollingContact

_STEPS = 40
_FEW = 6
"""Steps of all points of a chunk; few points need more."""

_HALVINGS = 12
"""Most times that a step is halved until the residual falls."""

_FARTHEST = 10.0
"""Largest step over the velocities so far."""

_LEVEL = 1.0 + 1e-3
"""Largest residual after a step over that before it: beyond slip, forces do not change on the way back."""

_SETTLED = 1e-11
"""Largest residual over the slip forces at which an iteration ends early. [-]"""

_CLOSE = 1e-9
"""Largest residual over the slip forces of a solution. [-]"""

_CHUNK = 4096
"""Points solved together: those that need many steps hold up no others, and arrays stay in the cache."""

_RIDGE = 1e-14
"""Added to the diagonal of a system, over its trace, so that a singular one gives large numbers instead of an error."""

_SLOWEST = 1e-12
"""Rolling speed over velocity below which slopes of the forces count as constant. [-]"""


class Slopes(NamedTuple):
    """Derivatives of lateral force f_u and moment M of one contact."""

    force_by_creep: Array
    force_by_rolling: Array
    force_by_spin: Array
    moment_by_creep: Array
    moment_by_rolling: Array
    moment_by_spin: Array


def solve(
    mechanism: ContactMap,
    heading: Heading,
    rates: Mapping[str, Array],
    applied: Mapping[str, Array],
    steering_rate: Array,
) -> MechanismPoint:
    """See `Mechanism.solve`."""
    names = tuple(mechanism.coordinates)  # type: ignore[arg-type]
    _check(mechanism, names, rates, applied)
    given = (
        *rates.values(),
        *applied.values(),
        steering_rate,
        *(heading if isinstance(heading, tuple) else (heading,)),
    )
    xp = namespace(mechanism.rows, *given)
    cosine, sine = directions(xp, heading, mechanism.wheels)
    values = mechanism.checked_values(xp, rates, "rates") | mechanism.checked_values(xp, applied, "applied")
    known = [values[name] for name in names]
    free = [place for place, name in enumerate(names) if name in applied]
    points = {name: tuple(value.shape) for name, value in zip(names, known, strict=True)}
    steering_rate = mechanism.checked_points(xp, steering_rate, heading=tuple(cosine.shape[:-1]), **points)
    if not isinstance(steering_rate, (int, float)):
        known.append(steering_rate[..., 0] if steering_rate.ndim else steering_rate)
    like = xp.broadcast_arrays(*known, mechanism.rows[..., 0, 0], cosine[..., 0])
    prescribed = xp.stack(like[: len(names)], axis=-1)
    shape = prescribed.shape[:-1]
    batch = _Batch(mechanism.rows, mechanism.surface, prescribed, cosine, sine, steering_rate)
    found = _rates(xp, mechanism, free, batch, shape)
    forces, q = mechanism.forces(found, (cosine, sine), steering_rate)
    point = mechanism.point(found, q, (cosine, sine), steering_rate, forces)
    return _judged(xp, mechanism, point, free, prescribed)


def _check(
    mechanism: ContactMap, names: tuple[str, ...], rates: Mapping[str, Array], applied: Mapping[str, Array]
) -> None:
    mechanism.known(rates, "rates")
    mechanism.known(applied, "applied")
    for name in names:
        if (name in rates) == (name in applied):
            both = "both" if name in rates else "neither"
            raise ParameterError(f"give either the rate of {name} or the force applied to it, got {both}")
    if not rates:
        raise ParameterError(
            "rates is empty: forces alone leave the speed of a steady motion open, so give at least one rate"
        )


class _Batch(NamedTuple):
    """Points to solve: the map, what is prescribed, headings; what is common to all points has no axis of points."""

    rows: Array
    surface: Array | None
    prescribed: Array
    cosine: Array
    sine: Array
    steering_rate: Array

    def some(self, places: Any) -> _Batch:
        """Some of the points of a flat batch."""
        shapes, parts = (2, 2, 1, 1, 1, 1), tuple[Any, ...](self)
        found = (
            one[places] if getattr(one, "ndim", 0) > common else one for one, common in zip(parts, shapes, strict=True)
        )
        return _Batch(*found)


def _rates(xp: Any, mechanism: ContactMap, free: list[int], batch: _Batch, shape: tuple[int, ...]) -> Array:
    """Rates of all coordinates; those that are free are found."""
    if not free:
        return batch.prescribed
    if xp.__name__ != "numpy" or not shape:
        return _newton(xp, mechanism, free, batch)[0]
    count = 1
    for size in shape:
        count *= size

    def flat(value: Array, common: int, *last: int) -> Array:
        """One row of points; what is common to all points stays as it is."""
        if getattr(value, "ndim", 0) <= common:
            return value
        return xp.reshape(xp.broadcast_to(value, (*shape, *last)), (count, *last))

    k, n = mechanism.wheels, batch.prescribed.shape[-1]
    whole = _Batch(
        flat(batch.rows, 2, *batch.rows.shape[-2:]),
        None if batch.surface is None else flat(batch.surface, 2, k, n),
        flat(batch.prescribed, 1, n),
        flat(batch.cosine, 1, k),
        flat(batch.sine, 1, k),
        flat(batch.steering_rate, 1, k),
    )
    found = []
    for start in range(0, count, _CHUNK):
        part = whole.some(slice(start, start + _CHUNK))
        rates, at, size = _newton(xp, mechanism, free, part, steps=_FEW)
        (late,) = xp.nonzero(size > _SETTLED)
        if len(late):
            rates[late] = _newton(xp, mechanism, free, part.some(late), at[late])[0]
        found.append(rates)
    return xp.reshape(xp.concat(found, axis=0), (*shape, n)) if found else batch.prescribed


class _System:
    """Residual of the forces on the free coordinates and its slope, for one batch of points, in metres per second and newtons.

    Each coordinate is measured by the mean velocity that it gives the carriers, so that lengths and angles mix.
    """

    def __init__(self, xp: Any, mechanism: ContactMap, free: list[int], batch: _Batch) -> None:
        rows, surface, prescribed, cosine, sine, self.steering_rate = batch
        self.xp, self.mechanism, self.heading = xp, mechanism, (cosine, sine)
        k = mechanism.wheels
        unit = xp.sqrt(xp.sum(rows[..., : 2 * k, :] ** 2, axis=-2) / k)
        unit = xp.where(unit > 0, unit, 1.0)
        scaled = rows / unit[..., None, :]
        self.unit = unit
        at = xp.asarray(free, dtype=xp.int64)
        self.free = at
        self.rows = xp.take(scaled, at, axis=-1)
        fixed = xp.asarray([0.0 if place in free else 1.0 for place in range(prescribed.shape[-1])], dtype=xp.float64)
        self.fixed = fixed
        self.given = xp.where(fixed > 0, prescribed * unit, 0.0)
        self.base = applied_to(scaled, self.given)
        self.required = xp.take(prescribed / unit, at, axis=-1)
        self.surface = None if surface is None else surface / unit[..., None, :]
        count = prescribed.shape[-1]
        places = [[1.0 if place == one else 0.0 for one in free] for place in range(count)]
        self.scatter = xp.asarray(places, dtype=xp.float64)
        self.force = mechanism.reference_force
        k_range = slice(0, k), slice(k, 2 * k)
        cosine, sine = cosine[..., None], sine[..., None]
        self.along = cosine * self.rows[..., k_range[0], :] + sine * self.rows[..., k_range[1], :]
        self.across = cosine * self.rows[..., k_range[1], :] - sine * self.rows[..., k_range[0], :]
        self.turning = self.rows[..., 2 * k :, :] if mechanism.spin is not None else None

    def rolling(self) -> Array:
        """Scaled free rates of the motion closest to rolling without creep."""
        xp, k = self.xp, self.mechanism.wheels
        cosine, sine = self.heading
        slip = cosine * self.base[..., k : 2 * k] - sine * self.base[..., :k]
        transposed = xp.matrix_transpose(self.across)
        return -_solved(xp, xp.matmul(transposed, self.across), applied_to(transposed, slip))

    def all(self, free: Array) -> Array:
        """All rates in their own units."""
        return (self.given + applied_to(self.scatter, free)) / self.unit

    def residual(self, free: Array) -> tuple[Array, Array, Any]:
        """Missing force on the free coordinates over the slip force, its largest, and slopes of the contacts."""
        xp, k = self.xp, self.mechanism.wheels
        motion = self.base + applied_to(self.rows, free)
        speed = None if self.surface is None else applied_to(self.surface, self.given + applied_to(self.scatter, free))
        spin = self.mechanism.spins(motion, self.steering_rate)
        columns = (motion[..., :k], motion[..., k : 2 * k], *self.heading, spin, speed)
        made = self.mechanism.by_contact(xp, _push, *columns)
        exerted = -applied_to(xp.matrix_transpose(self.across), made.lateral)
        exerted = exerted - applied_to(xp.matrix_transpose(self.along), made.rolling)
        if self.turning is not None:
            exerted = exerted - applied_to(xp.matrix_transpose(self.turning), made.moment)
        missing = (exerted - self.required) / self.force
        return missing, xp.max(xp.abs(missing), axis=-1), made

    def slope(self, made: Any) -> Array:
        """Derivative of the residual by the scaled free rates, with the opposite sign."""
        xp = self.xp
        force = made.by_creep[..., None] * self.across + made.by_rolling[..., None] * self.along
        if self.turning is not None:
            force = force + made.by_spin[..., None] * self.turning
        found = xp.matmul(xp.matrix_transpose(self.across), force)
        if self.turning is not None:
            moment = made.moment_by_creep[..., None] * self.across + made.moment_by_rolling[..., None] * self.along
            moment = moment + made.moment_by_spin[..., None] * self.turning
            found = found + xp.matmul(xp.matrix_transpose(self.turning), moment)
        return found / self.force


_State = tuple[Array, Array, Array, Any]
"""Scaled free rates, and of `_System.residual`: the residual, its largest element, and the contacts."""


class _Search(NamedTuple):
    """A search along a step for a smaller residual."""

    at: Array
    step: Array
    size: Array
    share: Array
    trial: Any


def _newton(
    xp: Any, mechanism: ContactMap, free: list[int], batch: _Batch, start: Array | None = None, steps: int = _STEPS
) -> tuple[Array, Array, Array]:
    """Rates of all coordinates, nan where no solution is found; the free ones, scaled, and their residual."""
    system = _System(xp, mechanism, free, batch)
    quick = xp.__name__ == "numpy"

    def halve(state: _Search) -> _Search:
        """Halve the steps after which the residual would be larger."""
        worse = ~(state.trial[1] <= _LEVEL * state.size)
        if quick and not xp.any(worse & (state.size > _SETTLED)):
            return state
        share = xp.where(worse, 0.5 * state.share, state.share)
        trial = system.residual(state.at + share[..., None] * state.step)
        return state._replace(share=share, trial=trial)

    def forth(state: _State) -> _State:
        """One step of Newton's method."""
        at, missing, size, made = state
        if quick and xp.all((size <= _SETTLED) | xp.isnan(size)):
            return state
        step = _solved(xp, system.slope(made), missing)
        most = _FARTHEST * (xp.max(xp.abs(system.base), axis=-1) + xp.max(xp.abs(at), axis=-1))[..., None]
        step = xp.clip(xp.where(xp.isfinite(step), step, 0.0), -most, most)
        search = _Search(at, step, size, xp.ones_like(size), system.residual(at + step))
        search = _repeat(xp, halve, search, _HALVINGS)
        missing_, size_, made_ = search.trial
        better = (size_ <= _LEVEL * size) & (size > _SETTLED)
        wide = better[..., None]
        # Where no step helps, another of the kind would not either: it is as close as rounding permits, or lost.
        stuck = xp.where(size <= _CLOSE, 0.0 * size, xp.nan)
        return (
            xp.where(wide, at + search.share[..., None] * step, at),
            xp.where(wide, missing_, missing),
            xp.where(better, size_, stuck),
            _Push(*(xp.where(wide, new, old) for new, old in zip(made_, made, strict=True))),
        )

    at = system.rolling() if start is None else start
    at, _, size, _ = _repeat(xp, forth, (at, *system.residual(at)), steps)
    return system.all(xp.where((size <= _CLOSE)[..., None], at, xp.nan)), at, size


def _solved(xp: Any, matrix: Array, right: Array) -> Array:
    """Solution of small systems; large numbers where singular."""
    m = matrix.shape[-1]
    if m == 1:
        pivot = matrix[..., 0, 0]
        return right / xp.where(pivot == 0, 1e-300, pivot)[..., None]
    trace = xp.sum(xp.abs(xp.linalg.diagonal(matrix)), axis=-1)
    ridge = xp.where(trace > 0, _RIDGE * trace, 1.0)
    matrix = matrix + ridge[..., None, None] * xp.eye(m, dtype=xp.float64)
    return xp.linalg.solve(matrix, right[..., None])[..., 0]


class _Push(NamedTuple):
    """Forces of contacts, and their slopes."""

    lateral: Array
    rolling: Array
    moment: Array
    by_creep: Array
    by_rolling: Array
    by_spin: Array
    moment_by_creep: Array
    moment_by_rolling: Array
    moment_by_spin: Array


def _push(
    contact: RollingContact, vx: Array, vy: Array, cosine: Array, sine: Array, spin: Array | None, speed: Array | None
) -> _Push:
    found = contact.act((vx, vy), (cosine, sine), spin=spin, surface_speed=speed)
    u, v, groups = contact.at((vx, vy), (cosine, sine), speed)
    xp = namespace(u, v, found.x)
    rolling = groups.rolling_force * xp.sign(v)
    return _Push(found.lateral_force, rolling, found.moment, *slopes(contact, groups, u, v, spin))


def slopes(contact: RollingContact, groups: Any, u: Array, v: Array, spin: Array | None) -> Slopes:
    """Derivatives of a contact's forces by creep velocity, rolling velocity and spin, at constant groups.

    Parameters
    ----------
    contact : RollingContact
    groups : LossGroups       At the wheel's heading, of `RollingContact.at`.
    u, v : (...,) float       Creep and rolling velocity. [m s^-1]
    spin : (...,) float       psi, or None. [rad s^-1]

    Returns
    -------
    Slopes   Without spin, or without forces that depend on it, the last column and the last three rows are zero.
    """
    xp = namespace(u, v, spin)
    turns = spin is not None and contact.turns_with_spin
    patch = spin_law.TurningPatch.of(contact, groups) if turns else None
    across = xp.abs(u) if patch is None else xp.abs(u) + patch.lever * xp.abs(spin)
    size = xp.abs(v) + _SLOWEST * across
    size = xp.where(size > 0, size, 1.0)
    way = xp.where(v < 0, -xp.ones_like(v), 1.0)
    stiffness = groups.creep_group / size
    if patch is not None:
        known = spin_map(patch.a_over_b, patch.poisson)
        c22, turned = known.scale.c22, known.scale.c22 * known.scale.lever
        x, y = stiffness * u, stiffness * patch.lever * way * spin
        _, slope = known.forces_and_gradient(x / c22, y / turned)
        fx, fy = slope.fy_by_lateral / c22, slope.fy_by_spin / turned
        mx, my = slope.mz_by_lateral / (turned), slope.mz_by_spin / (turned * known.scale.lever)
        per_creep = groups.slip_force * stiffness
        per_spin, arm = per_creep * patch.lever * way, patch.lever * way
        by_size = -way * groups.slip_force / size
        return Slopes(
            per_creep * fx,
            by_size * (fx * x + fy * y),
            per_spin * fy,
            arm * per_creep * mx,
            arm * by_size * (mx * x + my * y),
            arm * per_spin * my,
        )
    law = groups.formulas(contact.creep_law)
    at = stiffness * u
    ratio, rise = law.responding(at)
    # Beyond slip the force is constant; the secant leads an iteration that overshot back.
    slips = xp.abs(at) >= law.slip_creepage
    rise = xp.where(slips, ratio / xp.where(slips, at, 1.0), rise)
    by_creep = groups.slip_force * stiffness * rise
    nothing = 0.0 * by_creep
    return Slopes(by_creep, -way * by_creep * (u / size), nothing, nothing, nothing, nothing)


def _judged(
    xp: Any, mechanism: ContactMap, point: MechanismPoint, free: list[int], prescribed: Array
) -> MechanismPoint:
    """The point with SLIP where no motion was found, and with static friction where the machine rests."""
    import dataclasses

    lost = xp.any(xp.isnan(point.rates), axis=-1)
    demand = xp.where(lost[..., None], xp.inf, point.slip_demand)
    applied, rates = point.applied, point.rates
    if free and xp.__name__ == "numpy":
        fixed = [place for place in range(prescribed.shape[-1]) if place not in free]
        rests = xp.broadcast_to(xp.all(prescribed[..., fixed] == 0, axis=-1), lost.shape)
        if xp.any(rests):
            rates, applied = xp.array(rates), xp.array(applied)
            rates[rests] = 0.0
            applied[rests] = xp.nan
            required = xp.broadcast_to(prescribed, applied.shape)
            for place in free:
                applied[rests, place] = required[rests, place]
            demand = xp.array(demand)
            held = static_demand(mechanism, (point.cosine, point.sine), applied, rests, free)
            demand[rests] = held[:, None]
    return dataclasses.replace(point, rates=rates, applied=applied, slip_demand=demand)


def static_demand(
    mechanism: ContactMap, heading: tuple[Array, Array], applied: Array, rests: Array, free: list[int]
) -> Array:
    """Share of the static friction of all wheels with which they apply forces at rest: of the best distribution, the worst wheel.

    A wheel at rest holds a lateral force up to mu P and a rolling one up to F0; its steering is locked, and friction about
    the normal is neglected. Minimising the largest share is a linear program.

    Parameters
    ----------
    mechanism : ContactMap
    heading : two of (..., k) float   Cosines and sines.
    applied : (..., n) float          Q. [N] or [N m]
    rests : (...,) bool               The points to judge, p of them.
    free : list of int                Coordinates whose forces are prescribed.

    Returns
    -------
    (p,) float   Above 1 the machine cannot rest; inf where the wheels cannot exert those forces. [-]

    Source: Coulomb's law as an inequality.
    """
    import numpy as np
    from scipy.optimize import linprog

    k, shape = mechanism.wheels, rests.shape
    a = np.broadcast_to(mechanism.rows[..., : 2 * k, :], (*shape, 2 * k, applied.shape[-1]))[rests]
    cosine, sine = (np.broadcast_to(part, (*shape, k))[rests] for part in heading)
    loads = applied[rests]
    groups = [contact.groups(0.0) for contact in mechanism.contacts]  # type: ignore[union-attr]
    lateral = np.array([float(np.ravel(one.slip_force)[0]) for one in groups])
    rolling = np.array([float(np.ravel(one.rolling_force)[0]) for one in groups])
    found = np.empty(len(loads))
    for place, load in enumerate(loads):
        across = cosine[place][:, None] * a[place, k:] - sine[place][:, None] * a[place, :k]
        along = cosine[place][:, None] * a[place, :k] + sine[place][:, None] * a[place, k:]
        balance = np.vstack([lateral[:, None] * across, rolling[:, None] * along]).T[free]
        scale = np.maximum(np.abs(balance).max(axis=1, initial=0.0), 1e-300)
        equal = np.hstack([balance / scale[:, None], np.zeros((len(free), 1))])
        ones = np.eye(2 * k)
        below = np.vstack([np.hstack([ones, -np.ones((2 * k, 1))]), np.hstack([-ones, -np.ones((2 * k, 1))])])
        least = linprog(
            np.r_[np.zeros(2 * k), 1.0],
            A_ub=below,
            b_ub=np.zeros(4 * k),
            A_eq=equal,
            b_eq=load[free] / scale,
            bounds=[(None, None)] * (2 * k) + [(0.0, None)],
        )
        found[place] = least.fun if least.status == 0 else np.inf
    return found
