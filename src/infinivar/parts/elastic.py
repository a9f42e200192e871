r"""Elastic laws of springs, along a line or about a joint.

Signs: the deflection d of a spring grows with the position of what deflects it, and its force F(d) acts against that, so F
never falls as d grows. A parallel spring deflects with the position x of its load, d = x - rest, and the drive must exert
F(d) in addition to the force on the load. A series spring deflects by d = x_drive - x_load and pushes the load with F(d).

- ``linear``: :math:`F = F_0 + k\,d`;
- ``progressive``: :math:`F = F_0 + S(d)`, an interpolating spline of degree up to five through a table, continued along its
  tangents beyond it;
- ``one-sided``: :math:`F = F_0\,s(d/w) + k\,w \ln(1 + e^{d/w})` with :math:`s(u) = 1/(1 + e^{-u})`: no force before contact and
  :math:`F_0 + k\,d` after it, with a transition of width w; with ``side = "negative"`` mirrored, -F(-d).

Hysteresis of springs and belts is friction that follows the deflection x at any rate,

.. math:: \dot z = \sigma\,\dot x \left(1 - \mathrm{sgn}(\dot x)\,z/F_c\right), \qquad \sigma = F_c/x_s

where z is the friction force, positive where it opposes a growing deflection; F_c is its largest value and x_s the presliding
deflection. With the stored energy z^2/(2 sigma), the power lost is ``|x'| z^2/F_c >= 0``: the law never creates energy.

Source of the hysteresis: dahl1968, with exponent 1.
"""

from __future__ import annotations

import functools
import itertools
from typing import Any, Literal

import numpy as np
from annotated_types import Ge

from infinivar._core.array_namespace import Array, bisect, namespace, newton
from infinivar._core.chain_rule import inverse, is_zero
from infinivar._core.fields import check, check_choice, check_value, given
from infinivar._core.pieces import Pieces, through
from infinivar.errors import ParameterError
from infinivar.units import show


def after(force: Array, travel: Array, largest: Array, presliding: Array) -> Array:
    """Friction force after a one-way change of the deflection.

    Parameters
    ----------
    force : (...,) float        z before, of magnitude <= `largest`. [N] or [N m]
    travel : (...,) float       Change of the deflection, without reversal. [m] or [rad]
    largest : (...,) float      F_c, > 0. [N] or [N m]
    presliding : (...,) float   x_s, > 0. [m] or [rad]

    Returns
    -------
    (...,) float   z after it; inputs broadcast.

    Source: dahl1968, integrated along x.
    """
    xp = namespace(force, travel, largest, presliding)
    bound = largest * xp.sign(travel)
    return bound + (force - bound) * xp.exp(-xp.abs(travel) / presliding)


def slope(force: Array, direction: Array, largest: Array, presliding: Array) -> Array:
    """Slope dz/dx of the friction force by the deflection, >= 0.

    Parameters
    ----------
    force : (...,) float       z, of magnitude <= `largest`. [N] or [N m]
    direction : (...,) float   Sign of the deflection's speed, or the speed. At rest the slope is that of a reversal from z = 0.
    largest, presliding        As in `after`.

    Returns
    -------
    (...,) float   [N m^-1] or [N m rad^-1]

    Source: dahl1968.
    """
    xp = namespace(force, direction, largest, presliding)
    return (largest - xp.sign(direction) * force) / presliding


def derivatives(force: Array, direction: Array, largest: Array, presliding: Array, orders: int) -> list[Array]:
    """z and its derivatives by the deflection between reversals, up to an order.

    Source: dahl1968, differentiated.
    """
    xp = namespace(force, direction, largest, presliding)
    found = [force, slope(force, direction, largest, presliding)]
    for _ in range(orders - 1):
        found.append(-xp.sign(direction) * found[-1] / presliding)
    return found[: orders + 1]


def loss(force: Array, speed: Array, largest: Array) -> Array:
    """Power lost, ``|x'| z^2/F_c >= 0``. [W]

    Source: dahl1968; the remainder of ``z x'`` after the change of ``z^2/(2 sigma)``.
    """
    xp = namespace(force, speed, largest)
    return xp.abs(speed) * force * force / largest


def stored(force: Array, speed: Array, largest: Array, presliding: Array) -> Array:
    """Power into the stored energy ``z^2/(2 sigma)``: ``z z'/sigma``. [W]

    Source: dahl1968.
    """
    return force * slope(force, speed, largest, presliding) * speed * presliding / largest


def energy(force: Array, largest: Array, presliding: Array) -> Array:
    """Stored energy ``z^2/(2 sigma)``. [J]

    Source: dahl1968.
    """
    return 0.5 * force * force * presliding / largest


SpringShape = Literal["linear", "progressive", "one-sided"]
SpringSide = Literal["positive", "negative"]

NEEDS = {"linear": ("stiffness",), "progressive": ("deflections", "forces"), "one-sided": ("stiffness",)}
MAY = {
    "linear": ("hysteresis", "presliding"),
    "progressive": ("hysteresis", "presliding"),
    "one-sided": ("contact_width", "side"),
}
"""Fields of each shape: those it needs, and those it may have."""

_LOOSE = 1e-3
"""Force of a one-sided spring over ``stiffness contact_width`` below which, as a series spring, it counts as loose."""

_STEEP = 1.5
"""Largest ratio of slopes within a cell of the table that starts Newton's method; below 2 it converges from anywhere."""

_STEPS = 30

_NODES = 12
"""Nodes of the quadrature for the energy of a one-sided spring: the integrand's pole is far enough for 1e-16."""


def softplus(u: Array) -> Array:
    """``ln(1 + exp(u))`` without overflow. [-]"""
    xp = namespace(u)
    return xp.where(u > 0, u, 0.0) + xp.log(1.0 + xp.exp(-xp.abs(u)))


def softplus_area(u: Array) -> Array:
    """Integral of `softplus` from minus infinity, ``-Li2(-exp(u))``. [-]

    Source: the dilogarithm's integral, by Gauss-Legendre quadrature, exact to rounding for arguments down to -1; its inversion
    formula for u > 0.
    """
    xp = namespace(u)
    decayed = xp.exp(-xp.abs(u))
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    tail = sum(
        weight / (1.0 + node) * xp.log(1.0 + 0.5 * (1.0 + node) * decayed)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True)
    )
    return xp.where(u > 0, np.pi**2 / 6.0 + 0.5 * u * u - tail, tail)


def logistic(u: Array, orders: int) -> list[Array]:
    """``1/(1 + exp(-u))`` and its derivatives up to an order, at most the fifth. [-]"""
    xp = namespace(u)
    decayed = xp.exp(-xp.abs(u))
    one = xp.where(u > 0, 1.0, decayed) / (1.0 + decayed)
    bell = decayed / ((1.0 + decayed) * (1.0 + decayed))
    away = 1.0 - 2.0 * one
    third, fifth = bell * (1.0 - 6.0 * bell), bell * (1.0 - 30.0 * bell * (1.0 - 4.0 * bell))
    return [one, bell, bell * away, third, bell * away * (1.0 - 12.0 * bell), fifth][: orders + 1]


def transition(u: Array, orders: int) -> list[Array]:
    """`softplus` and its derivatives up to an order, at most the fifth. [-]"""
    return [softplus(u), *logistic(u, orders - 1)] if orders else [softplus(u)]


class Elastic:
    """Laws shared by springs along a line and about a joint; the fields are those of `infinivar.parts.spring.Spring`."""

    __slots__ = ()

    shape: SpringShape
    stiffness: Any  # a number where the shape needs it
    rest: float
    preload: float
    deflections: Any  # tuples of numbers where the shape needs them
    forces: Any
    hysteresis: float | None
    presliding: float | None
    side: SpringSide | None

    def _validate(self, unit: str) -> None:
        """Validate the fields and their combination; `unit` is that of deflections."""
        check(self)
        check_choice(self, "shape", NEEDS, MAY)
        if self.hysteresis is None and self.presliding is not None:
            raise ParameterError("presliding does not apply without hysteresis; remove it")
        if self.absent and (self.hysteretic or not is_zero(self.preload)):
            raise ParameterError("stiffness must be > 0 with a preload or hysteresis, got 0")
        if self.shape == "one-sided":
            check_value("preload of a one-sided spring", self.preload, "N m" if unit == "rad" else "N", Ge(0))
        if self.deflections is None:
            return
        rising_rows("deflections", self.deflections, unit)
        same_length("deflections", self.deflections, "forces", self.forces)
        place, least = through(self.deflections, self.forces, "line").lowest(1)
        if not least > 0:
            low, high = (show(end, unit) for end in interval(self.deflections, place))
            raise ParameterError(
                f"forces must rise with the deflection, also on the smooth curve through them; it falls between {low} and "
                f"{high}: change the values there, or add some"
            )

    @property
    def width(self) -> float:
        """Width of the transition at the contact of a one-sided spring. [m] or [rad]"""
        raise NotImplementedError

    @property
    def hysteretic(self) -> bool:
        """Whether the spring has hysteresis."""
        return self.hysteresis is not None and not is_zero(self.hysteresis)

    @property
    def absent(self) -> bool:
        """Whether the spring exerts no force anywhere: a stiffness of 0 stands for no spring."""
        return self.stiffness is not None and is_zero(self.stiffness)

    @property
    def _sign(self) -> float:
        """1, or -1 for a one-sided spring on the negative side."""
        return -1.0 if self.side == "negative" else 1.0

    @property
    def hysteresis_travel(self) -> float:
        """Presliding deflection; by default the one at which hysteresis and elastic stiffness are equal. [m] or [rad]

        0 without hysteresis.
        """
        if not self.hysteretic or self.presliding is not None:
            return given(self.presliding, 0.0)
        if self.deflections is not None:
            return self.hysteresis * (self.deflections[-1] - self.deflections[0]) / (self.forces[-1] - self.forces[0])
        return self.hysteresis / self.stiffness

    def force(self, position: Array) -> Array:
        """Elastic force at a position, without hysteresis.

        Parameters
        ----------
        position : (...,) float   Position of the load, or deflection of a series spring. [m] or [rad]

        Returns
        -------
        (...,) float   Against the deflection. [N] or [N m]

        Source: Hooke's law; tables: the spring's data.
        """
        return self.derivatives(position, 0)[0]

    def derivatives(self, position: Array, orders: int) -> list[Array]:
        """Elastic force and its derivatives by the position, up to an order, at most the fifth; see `force`."""
        since = position - self.rest
        if self.shape == "progressive":
            found = self._curve.derivatives(since, orders)
        elif self.shape == "linear":
            found = [self.stiffness * since, self.stiffness, *[0.0] * (orders - 1)][: orders + 1]
        else:
            width = self.width
            u = self._sign * since / width
            found = [self.stiffness * width ** (1 - k) * d for k, d in enumerate(transition(u, orders))]
            if not is_zero(self.preload):
                steps = logistic(u, orders)
                found = [
                    one + self.preload * width**-k * step
                    for k, (one, step) in enumerate(zip(found, steps, strict=True))
                ]
            return [self._sign ** (k + 1) * one for k, one in enumerate(found)]
        return [found[0] + self.preload, *found[1:]]

    def energy(self, position: Array) -> Array:
        """Elastic energy: the integral of `force` from the rest position, of a one-sided spring from no contact.

        Parameters
        ----------
        position : (...,) float   [m] or [rad]

        Returns
        -------
        (...,) float   May be negative with a preload. [J]

        Source: Hooke's law, integrated; `softplus_area`.
        """
        since = position - self.rest
        if self.shape == "progressive":
            return self._curve.integral().derivatives(since, 0)[0] + self.preload * since
        if self.shape == "linear":
            return since * (self.preload + 0.5 * self.stiffness * since)
        width = self.width
        u = self._sign * since / width
        return self.preload * width * softplus(u) + self.stiffness * width**2 * softplus_area(u)

    def deflection(self, force: Array) -> Array:
        """Deflection of a series spring under a force, without hysteresis: the inverse of `force`.

        Parameters
        ----------
        force : (...,) float   Force on the load. [N] or [N m]

        Returns
        -------
        (...,) float   A one-sided spring acts one way: from nearly no force on it stays at its loose end. [m] or [rad]
        """
        return self.deflection_derivatives(force, 0)[0]

    def deflection_derivatives(self, force: Array, orders: int) -> list[Array]:
        """Deflection and its derivatives by the force, up to an order, at most the fourth; see `deflection`.

        Source: `force`, inverted by Newton's method where no formula exists; derivatives of the inverse function.
        """
        xp = namespace(self, force)
        if self.shape == "linear":
            found = [self.rest + (force - self.preload) / self.stiffness, 1.0 / self.stiffness, *[0.0] * (orders - 1)]
            return found[: orders + 1]
        if self.shape == "progressive":
            at = self._inverted(xp, force) + self.rest
            return inverse(self.derivatives(at, orders), at)
        least = self.stiffness * self.width * _LOOSE
        along = self._sign * force
        loose = along <= least
        at = self._sign * self._compressed(xp, xp.where(loose, least, along)) + self.rest
        found = inverse(self.derivatives(at, orders), at)
        return [found[0], *(xp.where(loose, 0.0, one) for one in found[1:])]

    @property
    def limited(self) -> bool:
        """Whether its deflection has a limit."""
        return self.deflections is not None

    def demand(self, position: Array) -> Array:
        """Deflection over that at the end of the table: 1 at either end; 0 for other shapes. [-]"""
        xp = namespace(self, position)
        if self.deflections is None:
            return 0.0 * position
        low, high = self.deflections[0], self.deflections[-1]
        return xp.abs(position - self.rest - 0.5 * (low + high)) / (0.5 * (high - low))

    def pull_demand(self, force: Array) -> Array:
        """Above 1 where a one-sided series spring would have to pull (with a negative side: push); 0 for other shapes. [-]

        The allowance is a thousandth of ``stiffness contact_width`` below no force.
        """
        xp = namespace(self, force)
        if self.shape != "one-sided":
            return 0.0 * force
        return xp.clip(1.0 - _LOOSE - self._sign * force / (self.stiffness * self.width), 0.0, xp.inf)

    @property
    def _curve(self) -> Pieces:
        return through(self.deflections, self.forces, "line")

    def _inverted(self, xp: object, force: Array) -> Array:
        """Deflection of a progressive spring at which its table's curve has the force."""
        curve, required = self._curve, force - self.preload
        places, values, slopes = _cells(curve)
        start: Array = places[0] + (required - values[0]) / slopes[0]
        for place, value, slope in zip(places, values, slopes[1:], strict=True):
            start = xp.where(required > value, place + (required - value) / slope, start)  # type: ignore[attr-defined]

        def step(x: Array) -> Array:
            value, slope = curve.derivatives(x, 1)
            return x - (value - required) / slope

        return newton(xp, step, start, _STEPS)

    def _compressed(self, xp: object, force: Array) -> Array:
        """Deflection of a one-sided spring under a positive force."""
        scale, width, preload = self.stiffness * self.width, self.width, self.preload
        if is_zero(preload):
            share = force / scale
            return width * (share + xp.log(1.0 - xp.exp(-share)))  # type: ignore[attr-defined]

        def excess(u: Array) -> Array:
            return preload * logistic(u, 0)[0] + scale * softplus(u) - force

        def step(u: Array) -> Array:
            steps = logistic(u, 1)
            return u - excess(u) / (preload * steps[1] + scale * steps[0])

        low = xp.log(force / (preload + scale)) - 1.0 + 0.0 * force  # type: ignore[attr-defined]
        return width * newton(xp, step, bisect(xp, excess, low, force / scale + 1.0, 40), _STEPS)

    def hysteresis_after(self, force: Array, travel: Array) -> Array:
        """Hysteresis force after a one-way deflection; see `infinivar.parts.elastic.after`. [N] or [N m]"""
        return after(force, travel, self.hysteresis, self.hysteresis_travel)

    def hysteresis_derivatives(self, force: Array, direction: Array, orders: int) -> list[Array]:
        """Hysteresis force and its derivatives by the deflection; see `infinivar.parts.elastic.derivatives`."""
        return derivatives(force, direction, self.hysteresis, self.hysteresis_travel, orders)

    def hysteresis_loss(self, force: Array, speed: Array) -> Array:
        """Power lost to hysteresis at a hysteresis force and a speed of the deflection. [W]"""
        return loss(force, speed, self.hysteresis)

    def hysteresis_stored(self, force: Array, speed: Array) -> Array:
        """Power stored by hysteresis at a hysteresis force and a speed of the deflection. [W]"""
        return stored(force, speed, self.hysteresis, self.hysteresis_travel)


@functools.lru_cache(maxsize=64)
def _cells(curve: Pieces) -> tuple[list[float], list[float], list[float]]:
    """Places so close that the slope varies little between neighbours, the values there, and slopes between.

    The first and last slope hold beyond the first and last place.
    """
    places = list(curve.edges)
    for _ in range(12):
        found = [places[0]]
        for low, high in itertools.pairwise(places):
            some = curve.derivatives(np.linspace(low, high, 5), 1)[1][1:-1]
            ends = np.append(
                some, [curve.derivatives(np.array([0.9 * low + 0.1 * high, 0.1 * low + 0.9 * high]), 1)[1]]
            )
            found += [0.5 * (low + high), high] if ends.max() > _STEEP * ends.min() else [high]
        if len(found) == len(places):
            break
        places = found
    values = curve.derivatives(np.array(places), 0)[0].tolist()
    slopes = np.diff(values) / np.diff(places)
    beyond = curve.coefficients[1]
    return places, values, [beyond[0], *slopes.tolist(), beyond[-1]]


def rising_rows(name: str, row: tuple[float, ...], unit: str) -> None:
    """Raise ParameterError unless a row has at least two values and increases."""
    if len(row) < 2:
        raise ParameterError(f"{name} must have at least two values, got {len(row)}")
    for place in range(1, len(row)):
        if not row[place] > row[place - 1]:
            before, here = (show(value, unit) for value in row[place - 1 : place + 1])
            raise ParameterError(f"{name} must increase, but {here} follows {before}")


def same_length(name: str, row: tuple[float, ...], other_name: str, other: tuple[float, ...]) -> None:
    """Raise ParameterError unless two rows have the same number of values."""
    if len(row) != len(other):
        raise ParameterError(f"{other_name} must have as many values as {name}, {len(row)}, got {len(other)}")


def interval(row: tuple[float, ...], place: float) -> tuple[float, float]:
    """Neighbouring values of an increasing row between which a place lies."""
    upper = min(max(int(np.searchsorted(row, place)), 1), len(row) - 1)
    return row[upper - 1], row[upper]
