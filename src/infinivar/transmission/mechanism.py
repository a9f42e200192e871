r"""Machines of rolling contacts: a kinematic map over one contact law.

The carrier of wheel k moves relative to its surface at ``V_k = A_k qdot`` in the tangent plane and turns about the normal at
``psi_k = S_k qdot`` plus the rate at which the wheel is steered. By virtual power the contacts exert the generalised forces

.. math:: Q = \sum_k \left(A_k^T f_k - S_k^T M_k\right), \qquad
    -Q \cdot \dot q + \sum_k M_k \dot h_k = \sum_k \mathrm{loss}_k \ge 0

for every machine and every law of the contact. In steady motion the machine applies ``Q`` to all that is connected to its
coordinates; a positive power ``Q qdot`` goes to a load, a negative one comes from a motor or a user.

The forces do not depend on the size of the velocities, only on their direction, with one exception: bearings and friction
limits that depend on speed. So at rest they are indeterminate, and a motion is determined by forces alone except for its speed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from infinivar._core.array_namespace import Array, _repeat, namespace
from infinivar.errors import ParameterError
from infinivar.transmission import mechanism_forward
from infinivar.transmission.contact_map import ContactMap, MechanismPoint
from infinivar.transmission.kinematics import Heading, applied_to
from infinivar.transmission.rolling_contact import RollingContact

_STEPS = 30

_SETTLED = 1e-13
"""Largest change of a force ratio at which the iteration ends."""

_CLOSE = 1e-9
"""Largest missing force over the slip force of headings that count as found."""

_INWARD = 0.1
"""Least distance from the slip limit after a step, over that before it. [-]"""

_RIDGE = 1e-15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mechanism(ContactMap):
    """A machine at one configuration, or at many.

    Attributes
    ----------
    contacts : RollingContact, or one for each of the k wheels
    jacobian : (..., k, 2, n) float   A: velocity of each carrier along x and y by each coordinate's rate.
    coordinates : n names             "q1", "q2", ... by default.
    spin : (..., k, n) float          S: turning of each carrier about the normal, relative to the surface; None: none.
    surface : (..., k, n) float       Speed of the surface at each wheel, by each coordinate's rate: bearing friction and a
        friction limit that falls with speed follow it. None: they follow |V|.

    Raises
    ------
    ParameterError
        If shapes do not fit, or a creep law has a flow loss (law "faulring"), which is defined for the wheel on a cylinder only.
    """

    def solve(
        self,
        *,
        heading: Heading,
        rates: Mapping[str, Array],
        applied: Mapping[str, Array],
        steering_rate: Array = 0.0,
    ) -> MechanismPoint:
        """Steady motion with some rates prescribed, and the forces that the machine applies on all other coordinates.

        Parameters
        ----------
        heading, steering_rate : as in `operate`.
        rates : mapping of coordinate to (...,) float     Prescribed rates.
        applied : mapping of coordinate to (...,) float   Forces Q that the machine must apply, on each coordinate whose rate is
            not prescribed.

        Returns
        -------
        MechanismPoint
            Forces agree with those prescribed to 1e-9 of the slip force; the balance of powers is exact. Where no steady motion
            is found, all is nan and the limit is SLIP. Where all prescribed rates are zero the machine rests: the forces of
            each wheel are indeterminate and nan, the applied forces are those prescribed (nan on the others), and the limit is
            OK if static friction can hold them: see `mechanism_forward.static_demand`.

        Raises
        ------
        ParameterError
            If a coordinate is in neither mapping, in both or unknown, or no rate is prescribed.

        Notes
        -----
        Newton's method with a falling residual, from the motion without creep. Given as nan are also motions in which a wheel
        is held by static friction while others move, and some that the prescribed rates hardly determine, because the machine
        moves across them: of random motions one in a thousand. At rest with arrays of other libraries than NumPy all is nan.
        """
        return mechanism_forward.solve(self, heading, rates, applied, steering_rate)

    def steer(
        self, *, rates: Array, applied: Mapping[str, Array] | None = None, steering_rate: Array = 0.0
    ) -> tuple[Array, Array]:
        """Headings for a motion: along the velocity of each carrier, less the slip angle that its load needs.

        Parameters
        ----------
        rates : (..., n) float or mapping of coordinate to (...,) float   qdot.
        applied : mapping of coordinate to (...,) float   Forces Q that the machine must apply, on at most k coordinates; the
            others follow. With fewer than k, the wheels share them with the smallest lateral forces (to first order in the slip
            angles). None: headings of pure rolling without lateral force.
        steering_rate : as in `operate`.

        Returns
        -------
        cosine, sine : (..., k) float   Of headings along the motion; a wheel that points the other way is the same wheel. nan
            where a wheel would slip, and where a carrier stands still, as any heading serves.

        Raises
        ------
        ParameterError
            If a coordinate is unknown, or more forces are prescribed than there are wheels.
        """
        return _steer(self, rates, applied or {}, steering_rate)


def _steer(
    mechanism: ContactMap, rates: Array, applied: Mapping[str, Array], steering_rate: Array
) -> tuple[Array, Array]:
    """See `Mechanism.steer`: rolling without slip, then corrected for creep under the load."""
    if isinstance(rates, Mapping):
        rates = mechanism.vector(rates, "rates")
    mechanism.known(applied, "applied")
    names, k = list(mechanism.coordinates), mechanism.wheels  # type: ignore[arg-type]
    if len(applied) > k:
        raise ParameterError(f"applied has {len(applied)} forces, but {k} headings can satisfy at most {k}")
    xp = namespace(mechanism.rows, rates, steering_rate, *applied.values())
    rates = mechanism.checked_rates(xp, rates)
    forces = mechanism.checked_values(xp, applied, "applied")
    points = {name: tuple(value.shape) for name, value in forces.items()}
    steering_rate = mechanism.checked_points(xp, steering_rate, rates=tuple(rates.shape[:-1]), **points)
    motion = mechanism.velocities(rates)
    vx, vy = motion[..., :k], motion[..., k : 2 * k]
    speed = xp.sqrt(vx * vx + vy * vy)
    moves = speed > 0
    along, sideways = (xp.where(moves, one / xp.where(moves, speed, 1.0), xp.nan) for one in (vx, vy))
    if not applied:
        return along, sideways
    places = xp.asarray([names.index(name) for name in applied], dtype=xp.int64)
    required = xp.stack(xp.broadcast_arrays(*forces.values()), axis=-1)
    surface = None if mechanism.surface is None else applied_to(mechanism.surface, rates)
    spin = mechanism.spins(motion, steering_rate)
    columns = (vx, vy, along, sideways, spin, surface)
    rows = xp.take(mechanism.rows, places, axis=-1)
    # Forces on coordinates of other units weigh alike.
    unit = xp.sqrt(xp.sum(rows[..., : 2 * k, :] ** 2, axis=-2) / k)
    unit = xp.where(unit > 0, unit, 1.0)
    rows, required = rows / unit[..., None, :], required / unit / mechanism.reference_force
    transposed = xp.matrix_transpose(rows)

    def exerting(ratio: Array) -> tuple[_Turned, Array]:
        """The wheels at these force ratios, and the forces that are missing then."""
        made = mechanism.by_contact(xp, _at_ratio, ratio, *columns)
        parts = [made.x, made.y] + ([-made.moment] if mechanism.spin is not None else [])
        exerted = applied_to(transposed, xp.concat(xp.broadcast_arrays(*parts), axis=-1))
        return made, exerted / mechanism.reference_force - required

    def forth(ratio: Array) -> Array:
        """One step of Newton's method."""
        made, missing = exerting(ratio)
        if xp.__name__ == "numpy" and xp.all(_ended(xp, missing)):
            return ratio
        slope = rows[..., :k, :] * made.dx[..., None] + rows[..., k : 2 * k, :] * made.dy[..., None]
        change = -_least(xp, xp.matrix_transpose(slope / mechanism.reference_force), missing)
        most = 1.0 - _INWARD * (1.0 - xp.abs(ratio))  # at the slip limit the slope of a nonlinear law diverges
        return xp.clip(ratio + change, -most, most)

    made, missing = exerting(_repeat(xp, forth, 0.0 * (vx + xp.sum(required, axis=-1)[..., None]), _STEPS))
    found = (xp.max(xp.abs(missing), axis=-1) <= _CLOSE) & (xp.max(made.slip_demand, axis=-1) <= 1.0)
    found = found[..., None]
    return xp.where(found, made.cosine, xp.nan), xp.where(found, made.sine, xp.nan)


class _Turned(NamedTuple):
    """A wheel at a force ratio: its heading, forces, and derivatives of the forces by the ratio."""

    cosine: Array
    sine: Array
    x: Array
    y: Array
    moment: Array
    dx: Array
    dy: Array
    slip_demand: Array


def _ended(xp: Any, missing: Array) -> Array:
    largest = xp.max(xp.abs(missing), axis=-1)
    return (largest <= _SETTLED) | xp.isnan(largest)


def _at_ratio(
    contact: RollingContact,
    ratio: Array,
    vx: Array,
    vy: Array,
    along: Array,
    sideways: Array,
    spin: Array | None,
    surface: Array | None,
) -> _Turned:
    """Heading at which a wheel has a force ratio, its forces there, and their derivatives by the ratio."""
    xp = namespace(ratio, vx, along)
    # The stiffness at the heading of pure rolling differs from that at the heading by the square of a slip angle at most,
    # which the slip angle found takes up: forces are those of the heading.
    _, v, groups = contact.at((vx, vy), (along, sideways), surface)
    force = ratio * groups.slip_force
    creepage = contact.creepage(force, groups=groups, spin=spin, rolling_speed=v)
    root = xp.sqrt(1.0 + creepage * creepage)
    cosine, sine = (along + creepage * sideways) / root, (sideways - creepage * along) / root
    found = contact.act((vx, vy), (cosine, sine), spin=spin, surface_speed=surface)
    law = groups.formulas(contact.creep_law)
    rise = law.slope(ratio) / groups.creep_group / (1.0 + creepage * creepage)  # of the slip angle
    rolling, lateral = groups.rolling_force, found.lateral_force
    dx = groups.slip_force * sine + (rolling * -sine - lateral * cosine) * rise
    dy = -groups.slip_force * cosine + (rolling * cosine - lateral * sine) * rise
    return _Turned(cosine, sine, found.x, found.y, found.moment, dx, dy, found.slip_demand)


def _least(xp: Any, matrix: Array, right: Array) -> Array:
    """Least solution of matrix (..., m, k) times x = right, m <= k."""
    transposed = xp.matrix_transpose(matrix)
    square = xp.matmul(matrix, transposed)
    m = square.shape[-1]
    trace = xp.sum(xp.linalg.diagonal(square), axis=-1)
    ridge = xp.where(trace > 0, _RIDGE * trace, 1.0)
    weights = xp.linalg.solve(square + ridge[..., None, None] * xp.eye(m, dtype=xp.float64), right[..., None])
    return xp.matmul(transposed, weights)[..., 0]
