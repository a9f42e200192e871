r"""Steady rolling with lateral creepage and spin, from a table of the solver's results.

The map serves where thousands of points are needed: microseconds each instead of several milliseconds. It covers a
patch whose axes lie along and across the rolling direction, without longitudinal creepage; `RollingPatch` has no such limits.

Creepages are scaled as there: c = sqrt(a b), mu N and G are the units of length, force and stress, the creepage is that of the
wheel on the track and the force that on the track, so that for small ones, with Kalker's coefficients,

.. math:: f_y = C_{22}\upsilon + C_{23}\varphi, \qquad m_z = C_{33}\varphi - C_{23}\upsilon .

With the lever h of the patch, the table is polar in

    x = C22 upsilon,    y = C22 h phi,    rho = hypot(x, y),    u = rho/(rho + 2),    alpha = atan2(y, x).

It holds ``[f/u - (1 - u) f_linear(alpha)]`` for the lateral force and for the moment over h, which vanishes with u and ends at
the forces of full slip. C22, C23 and C33 in it are those of `infinivar.contact.kalker`, so that the linear theory is exact in
them. Half a turn of alpha changes the sign of both forces.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Interval

from infinivar._core.array_namespace import Array, as_floats, namespace, rising_root
from infinivar._core.fields import check_value
from infinivar.contact import kalker, spin
from infinivar.contact.exact.grid import Floats
from infinivar.contact.kalker import poisson_weights

A_OVER_B = tuple(float(np.round(0.05 * 400.0 ** (i / 12), 12)) for i in range(13))
"""Semi-axis along the rolling direction over the lateral one, equally spaced in its logarithm. [-]"""

POISSON = (0.0, 0.25, 0.5)

SIZES = 28
"""Intervals of u from 0 to 1. The table has no row for u = 0, where it vanishes."""

ANGLES = 32
"""Intervals of alpha in half a turn."""

HALF = 2.0
"""rho at which u is one half."""

_SPOT = 3.0 * math.pi / 16.0
"""Moment that turns a patch on the spot, over mu N h."""


class Scales(NamedTuple):
    """What makes the creepages of a patch of given shape and material comparable."""

    lever: Array
    """h, the mean radius of the patch's edge over c: moment of turning on the spot over (3 pi/16) mu N c. [-]"""
    c22: Array
    by_spin: Array
    """C23/(C22 h): lateral force by y, and minus the moment over h by x, in the linear theory. [-]"""
    turning: Array
    """C33/(C22 h^2): moment over h by y in the linear theory. [-]"""


def scales(a_over_b: Array, poisson: Array) -> Scales:
    """Scales of a patch with semi-axes whose product is 1; arguments as in `infinivar.contact.kalker.coefficients`."""
    linear = kalker.coefficients(a_over_b, poisson)
    root = a_over_b**0.5
    lever = spin.ellipse_moment(1.0, root, 1.0 / root, 1.0) / _SPOT
    by_spin = linear.c23 / (linear.c22 * lever)
    return Scales(lever, linear.c22, by_spin, linear.c33 / (linear.c22 * lever * lever))


def linear_part(scale: Scales, x: Array, y: Array) -> tuple[Array, Array]:
    """Lateral force and moment over h in the linear theory, over mu N."""
    return x + scale.by_spin * y, scale.turning * y - scale.by_spin * x


_REACH = 0.995
"""Largest x/(x + 2 + |y|) of the lateral creepage that the inverse looks for: 150 times that of full slip, or 200 |y|."""

_STEPS = 60
"""Most steps of the inverse; 4 to 8 suffice, but near full slip each gains only half a digit."""

_FAR = 1e9
"""rho of a patch that turns on the spot; forces there differ by 1e-9 from the limit."""

_LARGEST = 1e30
"""Creepages beyond, infinite ones too, count as this. [-]"""

_CLOSE = 1e-11
"""Largest error of the force at a creepage that the inverse has found. [-]"""


class SpinForces(NamedTuple):
    """Forces of the wheel on the track: a positive creepage causes a positive force. [-]"""

    fy: Array
    """Lateral force over mu N."""
    mz: Array
    """Moment about the normal over mu N c."""


class SpinGradient(NamedTuple):
    """Derivatives of the forces by the scaled creepages. [-]"""

    fy_by_lateral: Array
    fy_by_spin: Array
    mz_by_lateral: Array
    mz_by_spin: Array


class SpinMap(NamedTuple):
    """The map for one shape and material, or for arrays of them: see `spin_map`."""

    scale: Scales
    coefficients: Array
    """Of cubic B-splines in u and alpha, for both forces: (..., SIZES + 3, ANGLES + 3, 2). [-]"""

    def forces(self, lateral: Array, spin: Array) -> SpinForces:
        """Forces under lateral creepage and spin, both scaled; see `forces`."""
        return self.forces_and_gradient(lateral, spin)[0]

    def forces_and_gradient(self, lateral: Array, spin: Array) -> tuple[SpinForces, SpinGradient]:
        """Forces, and their derivatives by both creepages.

        Parameters
        ----------
        lateral, spin : (...,) float   Scaled creepage and spin. [-]

        Returns
        -------
        SpinForces, SpinGradient   of (...,) float. [-]
        """
        xp = namespace(lateral, spin, self.coefficients)
        lever, c22 = self.scale.lever, self.scale.c22
        (force, by_x, by_y), (moment, moment_by_x, moment_by_y) = self._polar(xp, *self._scaled(xp, lateral, spin))
        turn = c22 * lever
        return SpinForces(force, lever * moment), SpinGradient(
            c22 * by_x, turn * by_y, turn * moment_by_x, turn * lever * moment_by_y
        )

    def lateral_force(self, lateral: Array, spin: Array) -> tuple[Array, Array, Array]:
        """Lateral force over mu N and its derivatives by both creepages, as in `forces_and_gradient`. [-]"""
        xp = namespace(lateral, spin, self.coefficients)
        ((force, by_x, by_y),) = self._polar(xp, *self._scaled(xp, lateral, spin), parts=(0,))
        return force, self.scale.c22 * by_x, self.scale.c22 * self.scale.lever * by_y

    def moment_ratio(self, x: Array, y: Array) -> Array:
        """Moment over mu N h under the scaled creepages x and y of `contact.exact.spin_map`. [-]"""
        xp = namespace(x, y, self.coefficients)
        x, y = (xp.clip(one, -_LARGEST, _LARGEST) for one in as_floats(xp, x, y))
        ((moment, _, _),) = self._polar(xp, *xp.broadcast_arrays(x, y), parts=(1,))
        return moment

    def _scaled(self, xp: Any, lateral: Array, spin: Array) -> tuple[Array, Array]:
        """x and y of `_polar`."""
        lateral, spin = (xp.clip(one, -_LARGEST, _LARGEST) for one in as_floats(xp, lateral, spin))
        return xp.broadcast_arrays(self.scale.c22 * lateral, self.scale.c22 * self.scale.lever * spin)

    def lateral_creepage(self, force: Array, spin: Array) -> Array:
        """Lateral creepage that a lateral force needs under a spin: the inverse of `forces`.

        Parameters
        ----------
        force : (...,) float   Lateral force over mu N. [-]
        spin : (...,) float    Scaled spin. [-]

        Returns
        -------
        (...,) float   Scaled creepage; the force there is the given one to 1e-11. nan where no creepage gives it, and for
            nan. [-]
        """
        xp = namespace(force, spin, self.coefficients)
        force, spin = as_floats(xp, force, spin)
        required, y = xp.broadcast_arrays(force, self.scale.c22 * self.scale.lever * spin)
        possible = (xp.abs(required) < 1.0) & xp.isfinite(y)
        aim, y = xp.where(possible, required, 0.0), xp.where(possible, y, 0.0)

        unit = HALF + xp.abs(y)

        def excess(place: Array) -> tuple[Array, Array]:
            rest = 1.0 - xp.abs(place)
            ((value, by_x, _),) = self._polar(xp, unit * place / rest, y, parts=(0,))
            return value - aim, by_x * unit / (rest * rest)

        edge = _REACH + 0.0 * aim
        place = rising_root(xp, excess, -edge, edge, _STEPS)
        reached = xp.abs(excess(place)[0]) <= _CLOSE
        creepage = unit * place / (1.0 - xp.abs(place)) / self.scale.c22
        return xp.where(possible & reached, creepage, xp.nan)

    def on_the_spot(self, force: Array) -> tuple[Array, Array]:
        """A loaded patch that turns without rolling: the limit of infinite spin.

        Parameters
        ----------
        force : (...,) float   Lateral force over mu N. [-]

        Returns
        -------
        creep, moment : (...,) float   Lateral displacement per angle turned, over c and with the sign of the force, and moment
            over mu N c; nan at and beyond full slip. [-]
        """
        xp = namespace(force, self.coefficients)
        (force,) = as_floats(xp, force)
        possible = xp.abs(force) < 1.0
        aim, lever = xp.where(possible, force, 0.0), self.scale.lever

        def turned(place: Array) -> tuple[Array, Array]:
            """Sine and cosine of the angle from pure spin."""
            return xp.sin(0.5 * math.pi * place), xp.cos(0.5 * math.pi * place)

        def excess(place: Array) -> tuple[Array, Array]:
            sine, cosine = turned(place)
            ((value, by_x, by_y),) = self._polar(xp, _FAR * sine, _FAR * cosine, parts=(0,))
            return value - aim, 0.5 * math.pi * _FAR * (by_x * cosine - by_y * sine)

        edge = 1.0 + 0.0 * aim
        sine, cosine = turned(rising_root(xp, excess, -edge, edge, _STEPS))
        ((moment, _, _),) = self._polar(xp, _FAR * sine, _FAR * cosine, parts=(1,))
        nothing = xp.where(possible, 0.0, xp.nan)
        return lever * sine / cosine + nothing, lever * moment + nothing

    def _polar(self, xp: Any, x: Array, y: Array, parts: Sequence[int] = (0, 1)) -> list[tuple[Array, Array, Array]]:
        """Lateral force (part 0) and moment over the lever (part 1), each with its derivatives by x and y."""
        square = x * x + y * y
        moves = square > 0.0
        rho = xp.sqrt(xp.where(moves, square, 1.0))
        sign = xp.where(x < 0.0, -1.0, 1.0)  # half a turn changes the sign of both forces
        cosine, sine = xp.where(moves, sign * x / rho, 1.0), xp.where(moves, sign * y / rho, 0.0)
        rho = xp.where(moves, rho, 0.0)
        rest = HALF / (HALF + rho)  # 1 - u
        u = 1.0 - rest
        angle = 0.5 + (2.0 / math.pi) * xp.atan(sine / (1.0 + cosine))
        tables = _tables(xp, self.coefficients, SIZES * u, ANGLES * angle, parts)
        linear_parts = linear_part(self.scale, x, y)
        slopes = ((1.0, self.scale.by_spin), (-self.scale.by_spin, self.scale.turning))

        grow = rest * rest / HALF  # du/drho; u/rho is rest/HALF
        made = []
        for part, (table, by_size, by_angle) in zip(parts, tables, strict=True):
            straight, (slope_x, slope_y) = linear_parts[part], slopes[part]
            outward = (table + u * SIZES * by_size) * grow - 2.0 * rest * grow * (sign * straight)
            around = rest / HALF * (ANGLES / math.pi) * by_angle
            linear = rest * rest
            made.append(
                (
                    straight * linear + sign * u * table,
                    slope_x * linear + outward * cosine - around * sine,
                    slope_y * linear + outward * sine + around * cosine,
                )
            )
        return made


def spin_map(a_over_b: Array, poisson: Array) -> SpinMap:
    """The map for a shape and material.

    Parameters
    ----------
    a_over_b : (...,) float   Semi-axis along the rolling direction over the other, 0.05 to 20. [-]
    poisson : (...,) float    Poisson's ratio, 0 to 0.5. [-]

    Returns
    -------
    SpinMap

    Raises
    ------
    ParameterError
        If a value is out of range. For traced arrays the result is nan there instead.

    Source: cubic splines in ln(a/b) through the table of `tools/tabulate_spin.py`, a parabola in Poisson's ratio.
    """
    if isinstance(a_over_b, (int, float)) and isinstance(poisson, (int, float)):
        return _known(float(a_over_b), float(poisson))
    return _made(a_over_b, poisson)


def forces(lateral: Array, spin: Array, a_over_b: Array, poisson: Array) -> SpinForces:
    """Lateral force and moment of a patch under lateral creepage and spin.

    Parameters
    ----------
    lateral : (...,) float    G c^2 upsilon/(mu N), with the creepage upsilon of the wheel on the track. [-]
    spin : (...,) float       G c^3 phi/(mu N), with the turning phi about the normal per distance rolled. [-]
    a_over_b : (...,) float   Semi-axis along the rolling direction over the other, 0.05 to 20. [-]
    poisson : (...,) float    Poisson's ratio, 0 to 0.5. [-]

    Returns
    -------
    SpinForces   of (...,) float; inputs broadcast. They differ from the solver's by up to 0.008; the moment, over
        the mean radius of the patch's edge, by 0.010. [-]

    Raises
    ------
    ParameterError
        If `a_over_b` or `poisson` is out of range.

    Source: `tools/tabulate_spin.py`, from `RollingPatch`.
    """
    return spin_map(a_over_b, poisson).forces(lateral, spin)


@functools.lru_cache(maxsize=64)
def _known(a_over_b: float, poisson: float) -> SpinMap:
    made = _made(a_over_b, poisson)
    return SpinMap(Scales(*map(float, made.scale)), made.coefficients)


def _made(a_over_b: Array, poisson: Array) -> SpinMap:
    check_value("a_over_b", a_over_b, "1", Interval(ge=A_OVER_B[0], le=A_OVER_B[-1]))
    check_value("poisson", poisson, "1", Interval(ge=0.0, le=0.5))
    xp = namespace(a_over_b, poisson)
    ratio, nu = xp.broadcast_arrays(*as_floats(xp, a_over_b, poisson))
    valid = (ratio >= A_OVER_B[0]) & (ratio <= A_OVER_B[-1]) & (nu >= 0.0) & (nu <= 0.5)
    ratio, nu = xp.where(valid, ratio, 1.0), xp.where(valid, nu, 0.25)
    count = len(A_OVER_B) - 1
    place = xp.log(ratio / A_OVER_B[0]) * (count / math.log(A_OVER_B[-1] / A_OVER_B[0]))
    shapes = _splines(xp, place, count)
    weights = poisson_weights(nu)
    # One product of matrices for all patches, several times faster than one of each Poisson's ratio and patch.
    both = xp.concat([weight[..., None] * shapes for weight in weights], axis=-1)
    flat = xp.matmul(xp.where(valid[..., None], both, xp.nan), xp.asarray(_coefficients(), dtype=xp.float64))
    return SpinMap(scales(ratio, nu), xp.reshape(flat, (*ratio.shape, SIZES + 3, ANGLES + 3, 2)))


def _tables(
    xp: Any, coefficients: Array, size: Array, angle: Array, parts: Sequence[int]
) -> list[tuple[Array, Array, Array]]:
    """Tables of the parts at places along u and alpha in steps of their nodes, each with its derivatives by these places.

    From the sixteen splines that are not 0 there; coefficients of many patches broadcast against the places.
    """
    first, by_size, d_size = _four(xp, size, SIZES)
    start, by_angle, d_angle = _four(xp, angle, ANGLES)
    columns = ANGLES + 3
    patches = coefficients.shape[:-3]
    corner = 2 * (first * columns + start)
    if patches:
        corner = corner + xp.reshape(xp.arange(math.prod(patches)) * (2 * (SIZES + 3) * columns), patches)
    found, flat = [], xp.reshape(coefficients, (-1,))
    for part in parts:
        value = d_first = d_second = 0.0
        for i in range(4):
            row = [xp.take(flat, corner + (2 * (i * columns + j) + part)) for j in range(4)]
            along = sum(weight * one for weight, one in zip(by_angle, row, strict=True))
            value = value + by_size[i] * along
            d_first = d_first + d_size[i] * along
            d_second = d_second + by_size[i] * sum(weight * one for weight, one in zip(d_angle, row, strict=True))
        found.append((value, d_first, d_second))
    return found


def _four(xp: Any, place: Array, count: int) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
    """Number of the first cubic B-spline that is not 0 at a place, and the four values and derivatives."""
    whole = xp.clip(xp.floor(xp.where(xp.isfinite(place), place, 0.0)), 0.0, count - 1.0)
    s = place - whole
    r, square = 1.0 - s, s * s
    slopes = (-0.5 * r * r, s * (1.5 * s - 2.0), 0.5 + s - 1.5 * square, 0.5 * square)
    return xp.astype(whole, xp.int64), four_splines(s), slopes


def four_splines(share: Array) -> tuple[Array, Array, Array, Array]:
    """The four cubic B-splines that are not 0 between two nodes, at a share of the way from one to the next."""
    rest, square = 1.0 - share, share * share
    cube = square * share
    return (
        rest * rest * rest / 6.0,
        2.0 / 3.0 + square * (0.5 * share - 1.0),
        1.0 / 6.0 + 0.5 * (share + square - cube),
        cube / 6.0,
    )


def _splines(xp: Any, place: Array, count: int) -> Array:
    """Cubic B-splines about the places -1 to `count` + 1: (..., count + 3)."""
    size = xp.abs(place[..., None] - xp.arange(-1.0, count + 2.0, dtype=xp.float64))
    tail = xp.where(size < 2.0, 2.0 - size, 0.0)
    return xp.where(size < 1.0, 2.0 / 3.0 + size * size * (0.5 * size - 1.0), tail * tail * tail / 6.0)


@functools.cache
def _coefficients() -> Floats:
    """Coefficients of the B-splines through the table: (POISSON (A_OVER_B + 2), (SIZES + 3) (ANGLES + 3) 2)."""
    with (resources.files("infinivar.contact") / "data" / "spin_map.npz").open("rb") as file, np.load(file) as stored:
        values = stored["values"].astype(float)
    values = np.concatenate([np.zeros_like(values[:, :, :1]), values], axis=2)
    values = _through_half_turn(values)
    values = _through(_through(values, 2), 0)
    return np.ascontiguousarray(np.swapaxes(values, 0, 1)).reshape(values.shape[0] * values.shape[1], -1)


def _through(values: Floats, axis: int) -> Floats:
    """Coefficients of the uniform cubic spline along an axis whose third derivative is continuous at the first inner node."""
    count = values.shape[axis]
    system = np.zeros((count + 2, count + 2))
    for node in range(count):
        system[node + 1, node : node + 3] = (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0)
    system[0, :5] = system[-1, -5:] = (1.0, -4.0, 6.0, -4.0, 1.0)
    right = np.moveaxis(values, axis, 0)
    nothing = np.zeros((1, *right.shape[1:]))
    right = np.concatenate([nothing, right, nothing])
    return np.moveaxis(np.linalg.solve(system, right.reshape(count + 2, -1)).reshape(right.shape), 0, axis)


def _through_half_turn(values: Floats) -> Floats:
    """Coefficients along the angles, the last axis but one, of a spline that changes its sign after half a turn."""
    system = (2.0 / 3.0) * np.eye(ANGLES) + (1.0 / 6.0) * (np.eye(ANGLES, k=1) + np.eye(ANGLES, k=-1))
    system[0, -1] = system[-1, 0] = -1.0 / 6.0
    found = np.einsum("ij,...jk->...ik", np.linalg.inv(system), values)
    # From -pi/2, which is half a turn from the node at pi/2, to pi/2.
    half = ANGLES // 2
    return np.concatenate([-found[..., half - 1 :, :], found[..., : half + 2, :]], axis=-2)
