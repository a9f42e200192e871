r"""A thin tube under the wheels that press on it: how far its wall gives way, and what bends it.

Radial displacement w of a tube of mean radius R and wall t, closed by end plates that keep its ends round, by the equation
of Morley for thin cylinders,

.. math::
    D \nabla^4 \left(\nabla^2 + \tfrac{1}{R^2}\right)^2 w + \frac{E t}{R^2} \frac{\partial^4 w}{\partial x^4} = \nabla^4 p,
    \qquad D = \frac{E t^3}{12 (1 - \nu^2)}

With ``a = m pi/L``, a force P at x and N - 1 equal ones evenly around give w under each as a double sum of
``P sin^2(a x)/(pi R L)/k(m, n)`` over m > 0 and all multiples n of N, times N, where ``s = a^2 + n^2/R^2`` and
``k = D (s - 1/R^2)^2 + (E t/R^2) a^4/s^2``. The sum over n has a closed form: ``1/k`` is the imaginary part of two simple
fractions ``A_j/(s - s_j)`` at the roots of ``s^2 - s/R^2 = i a^2 sqrt(E t/(D R^2))``, and ``sum 1/(n^2 + z^2)`` over the
multiples is ``pi coth(pi z/N)/(N z)``. Terms of high m feel no curvature: their sum, that of a plate, is added in closed form.

The theory is that of thin walls, as which handbooks take those from ``R/t = 10`` on; below, it is an estimate.

Source: morley1959.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from infinivar._core.array_namespace import Array, as_floats, namespace

_TERMS, _MOST_TERMS = 96, 1200
"""Terms along the tube: at least, and at most."""
_PER_LENGTH = 4.0
"""Terms for each ``sqrt(R t)`` of the tube's length: those beyond are of a plate to 1e-3 of the whole."""


class Wall(NamedTuple):
    """The wall of a tube; arrays that broadcast."""

    radius: Array
    """Mean radius R. [m]"""
    thickness: Array
    """t. [m]"""
    length: Array
    """L, between the end plates. [m]"""
    youngs_modulus: Array
    """[Pa]"""
    poisson: Array
    """[-]"""

    @property
    def stiffness(self) -> Array:
        """Flexural rigidity of the wall, D. [N m]"""
        return self.youngs_modulus * self.thickness**3 / (12.0 * (1.0 - self.poisson**2))


def give(wall: Wall, place: Array, count: int = 1) -> Array:
    """Radial displacement of the wall under a force, over the force: what a round tube bends as a beam is left out.

    Parameters
    ----------
    wall : Wall
    place : (...,) float   Of the force, from one end plate; 0 < place < L. [m]
    count : int            Number of equal forces evenly around the tube, 1 to 3.

    Returns
    -------
    (...,) float   Inwards, under each force. [m/N]

    Source: morley1959; see the module.
    """
    xp, wave, shares, wall, place = _waves(wall, place)
    scale = 1.0 / (math.pi * wall.radius * wall.length)
    terms = shares * (_over_all(xp, wall, wave, count, 0)[0] - (_around_once(wall, wave) if count == 1 else 0.0))
    left = wave.shape[-1] * (wave.shape[-1] + 1)
    of_plate = wall.length[..., 0] ** 2 / (8.0 * math.pi**3 * wall.stiffness[..., 0] * left)
    return xp.sum(scale * terms, axis=-1) + of_plate


def bend(wall: Wall, place: Array) -> Array:
    """Displacement of a tube that stays round, by bending and shear, under one force, over the force: what `give` leaves out.

    Parameters and result as of `give`; long tubes bend as the beams of young2002, Table 8.1, case 1e.

    Source: morley1959; the waves n = 1.
    """
    xp, wave, shares, wall, _ = _waves(wall, place)
    return xp.sum(shares * _around_once(wall, wave) / (math.pi * wall.radius * wall.length), axis=-1)


def tension(wall: Wall, place: Array, area: Array, count: int = 1) -> Array:
    """Largest tensile stress at the inside of the wall, under a force on a small area, over the force.

    Parameters
    ----------
    wall, place, count     As in `give`.
    area : (...,) float    Radius of a circle that the force covers evenly. [m]

    Returns
    -------
    (...,) float   In the wall, from bending less the thrust in it. [Pa/N]

    Source: morley1959; young2002, Table 11.4 (what small areas count as, and its case 1b for walls without curvature).
    """
    xp, wave, shares, wall, place = _waves(wall, place)
    scale = 1.0 / (math.pi * wall.radius * wall.length)
    poisson, thickness = wall.poisson[..., 0], wall.thickness[..., 0]
    radius = 1.0 * area
    small = xp.sqrt(1.6 * radius**2 + thickness**2) - 0.675 * thickness
    radius = xp.where(radius < 0.5 * thickness, small, radius)
    plain, by_s, over_s, over_square = _over_all(xp, wall, wave, count, 0, 1, -1, -2)
    stiffness, along = wall.stiffness, (1.0 - wall.poisson) * wave**2
    plate = 0.5 * (1.0 + wall.poisson) * math.pi * wall.radius / wave

    def summed(terms: Array) -> Array:
        return xp.sum(scale * shares * terms, axis=-1)

    # The plate's own terms do not converge for a force at a point: those of an area, in closed form.
    width = 2.0 * wall.length[..., 0] * xp.sin(math.pi * place[..., 0] / wall.length[..., 0]) / math.pi
    of_plate = 0.25 * (1.0 + poisson) / math.pi * (xp.log(width / radius) + 0.5)
    apart = 0.125 * (1.0 - poisson) / math.pi
    moments = (
        summed(stiffness * (along * plain + wall.poisson * by_s) - plate) + of_plate + apart,
        summed(stiffness * (by_s - (along + 1.0 / wall.radius**2) * plain) - plate) + of_plate - apart,
    )
    membrane = wall.youngs_modulus / wall.radius
    thrusts = (
        summed(membrane * wave**2 * (over_s - wave**2 * over_square)),
        summed(membrane * wave**4 * over_square),
    )
    first, second = (6.0 * moment / thickness**2 - thrust for moment, thrust in zip(moments, thrusts, strict=True))
    return xp.maximum(first, second)


def _waves(wall: Wall, place: Array) -> tuple[Any, Array, Array, Wall, Array]:
    """Namespace, wave numbers, what a force at a place has of each, and wall and place with an axis for them."""
    xp = namespace(*wall, place)
    *values, place = (value[..., None] for value in xp.broadcast_arrays(*as_floats(xp, *wall, place)))
    wall = Wall(*values)
    terms = _TERMS
    if xp.__name__ == "numpy":  # a number of terms depends on no value that is traced
        longest = float(np.max(wall.length / np.sqrt(wall.radius * wall.thickness), initial=0.0))
        terms = int(np.clip(math.ceil(_PER_LENGTH * longest), _TERMS, _MOST_TERMS)) if longest < math.inf else _TERMS
    wave = xp.asarray(np.arange(1, terms + 1) * math.pi) / wall.length
    return xp, wave, xp.sin(wave * place) ** 2, wall, place


def _over_all(xp: Any, wall: Wall, wave: Array, count: int, *powers: int) -> list[Array]:
    """Sums of ``s^power/k`` over all multiples of `count`, times it. (..., m) each"""
    curved = 1.0 / wall.radius**2
    coupled = xp.sqrt(wall.youngs_modulus * wall.thickness / wall.stiffness) / wall.radius * wave**2
    spread = _root(xp, (curved**2 + 0.0 * coupled, 4.0 * coupled))
    found: list[Array] = [0.0] * len(powers)
    for sign in (1.0, -1.0):
        root = 0.5 * (curved + sign * spread[0]), 0.5 * sign * spread[1]
        z = _root(xp, (wave**2 - root[0], -root[1]))
        below = _times(
            spread, _times(z, _tanh(xp, math.pi * wall.radius * z[0] / count, math.pi * wall.radius * z[1] / count))
        )
        found = [
            sum_ + sign * _over(_power(root, 2 + power), below)[1] for sum_, power in zip(found, powers, strict=True)
        ]
    return [math.pi * wall.radius * one / (wall.stiffness * coupled) for one in found]


_Complex: TypeAlias = tuple[Array, Array]
"""Real and imaginary part: array libraries that carry derivatives have no complex numbers."""


def _times(one: _Complex, other: _Complex) -> _Complex:
    return one[0] * other[0] - one[1] * other[1], one[0] * other[1] + one[1] * other[0]


def _over(one: _Complex, other: _Complex) -> _Complex:
    square = other[0] ** 2 + other[1] ** 2
    real, imaginary = _times(one, (other[0], -other[1]))
    return real / square, imaginary / square


def _power(one: _Complex, exponent: int) -> _Complex:
    """For exponents from 0 to 3."""
    found: _Complex = (1.0, 0.0)
    for _ in range(exponent):
        found = _times(found, one)
    return found


def _root(xp: Any, one: _Complex) -> _Complex:
    """Square root with a positive real part, of numbers that are not real."""
    size = xp.sqrt(one[0] ** 2 + one[1] ** 2)
    # The larger of both parts has no cancellation, and their product is known.
    large = xp.sqrt(0.5 * (size + xp.abs(one[0])))
    small = 0.5 * xp.abs(one[1]) / large
    real, imaginary = xp.where(one[0] > 0, large, small), xp.where(one[0] > 0, small, large)
    return real, xp.where(one[1] > 0, imaginary, -imaginary)


def _tanh(xp: Any, real: Array, imaginary: Array) -> _Complex:
    """For a positive real part."""
    faded = xp.exp(-2.0 * real)
    below = 1.0 + 2.0 * faded * xp.cos(2.0 * imaginary) + faded * faded
    return (1.0 - faded * faded) / below, 2.0 * faded * xp.sin(2.0 * imaginary) / below


def _around_once(wall: Wall, wave: Array) -> Array:
    """The terms n = 1 and -1, which bend the tube as a beam. (..., m)"""
    s = wave**2 + 1.0 / wall.radius**2
    membrane = wall.youngs_modulus * wall.thickness / wall.radius**2
    return 2.0 / (wall.stiffness * wave**4 + membrane * wave**4 / s**2)
