r"""Hertzian contact: line, ellipse, and a crowned wheel on a cylinder at any steering angle.

The undeformed gap between the bodies is ``(c_x x^2 + c_y y^2)/2``. x is the rolling direction and y the lateral one; the
contact has semi-axes a along x and b along y.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from annotated_types import Gt

from infinivar._core.array_namespace import Array, as_floats, namespace, newton, rising_root
from infinivar._core.fields import check_value
from infinivar.contact.bodies import Surface, Wheel, plane_strain_modulus
from infinivar.contact.elliptic import carlson_rd, ellipse_integrals

_BESIDE, _STEPS = 1e-4, 24
"""Share of a depth to places above and below it, by which the shear is found to rise or fall; most steps of the search."""


class Ellipse(NamedTuple):
    """Elliptical contact; arrays that broadcast to one shape."""

    a: Array
    """Semi-axis along x. [m]"""
    b: Array
    """Semi-axis along y. [m]"""
    peak_pressure: Array
    """Pressure at the centre, p0. [Pa]"""
    approach: Array
    """Approach of distant points of the bodies. [m]"""

    @property
    def mean_pressure(self) -> Array:
        """Load over area, two thirds of the peak. [Pa]"""
        return self.peak_pressure * (2.0 / 3.0)


class Crossed(NamedTuple):
    """Contact of a wheel steered on a cylinder."""

    ellipse: Ellipse
    """Its a is the semi-axis closer to the rolling direction."""
    rotation: Array
    """Angle of that axis from the rolling direction, towards lateral, within +-45 degrees. [rad]"""


def line(load_per_length: Array, radius: Array, e_star: Array) -> tuple[Array, Array]:
    r"""Half-width and peak pressure of a line contact.

    .. math:: a = \sqrt{4 P' R / (\pi E^*)}, \qquad p_0 = 2 P' / (\pi a)

    Parameters
    ----------
    load_per_length : (...,) float   Normal load per contact length, > 0. [N m^-1]
    radius : (...,) float            Relative radius 1/(1/R1 + 1/R2), > 0. [m]
    e_star : (...,) float            Plane-strain modulus, > 0. [Pa]

    Returns
    -------
    half_width, peak_pressure : (...,) float   [m], [Pa]; inputs broadcast.

    Raises
    ------
    ParameterError
        If an argument is not above zero.

    Notes
    -----
    Valid for a half-width much smaller than the radius, and below first yield.

    Source: johnson1985, section 4.2(c).
    """
    check_value("load_per_length", load_per_length, "N/m", Gt(0))
    check_value("radius", radius, "m", Gt(0))
    check_value("e_star", e_star, "Pa", Gt(0))
    xp = namespace(load_per_length, radius, e_star)
    load, radius, e_star = as_floats(xp, load_per_length, radius, e_star)
    half_width = xp.sqrt(4.0 / math.pi * load * radius / e_star)
    return half_width, 2.0 * load / (math.pi * half_width)


def ellipse(load: Array, curvature_x: Array, curvature_y: Array, e_star: Array) -> Ellipse:
    r"""Semi-axes, peak pressure and approach of an elliptical contact.

    .. math:: \frac{c_x}{c_y} = \frac{X(a/b)}{Y(a/b)}, \quad b^3 = \frac{3 P (X + Y)}{2\pi E^* (c_x + c_y)}, \quad
        p_0 = \frac{3P}{2\pi a b}, \quad \delta = \frac{3 P F}{4 \pi E^* b}

    with the integrals X, Y, F of `ellipse_integrals`. The axis ratio is found by Newton's method.

    Parameters
    ----------
    load : (...,) float                       Normal load P, > 0. [N]
    curvature_x, curvature_y : (...,) float   Relative principal curvatures, gap = (c_x x^2 + c_y y^2)/2, > 0 (a
        curvature of 0 is a line contact). Ratios to 1e12. [1/m]
    e_star : (...,) float                     Plane-strain modulus, > 0. [Pa]

    Returns
    -------
    Ellipse   Inputs broadcast. Relative error about 1e-12.

    Raises
    ------
    ParameterError
        If an argument is not above zero.

    Notes
    -----
    Valid for semi-axes far below the radii of curvature, smooth surfaces, and below first yield.

    Source: johnson1985, section 4.2(b).
    """
    check_value("load", load, "N", Gt(0))
    check_value("curvature_x", curvature_x, "1/m", Gt(0))
    check_value("curvature_y", curvature_y, "1/m", Gt(0))
    check_value("e_star", e_star, "Pa", Gt(0))
    xp = namespace(load, curvature_x, curvature_y, e_star)
    load, c_x, c_y, e_star = xp.broadcast_arrays(*as_floats(xp, load, curvature_x, curvature_y, e_star))
    required = xp.log(c_x) - xp.log(c_y)

    def step(logarithm: Array) -> Array:
        """One Newton step for ln(X/Y) = ln(c_x/c_y) in ln(a/b), which is nearly linear."""
        g = xp.exp(logarithm)
        _, along_a, along_b, mixed = ellipse_integrals(g)
        slope = -3.0 + mixed / along_a + g * g * mixed / along_b
        return logarithm - (xp.log(along_a / along_b) - required) / slope

    # -3/2 is the slope at the circle; far from it the slope tends to -2.
    ratio = xp.exp(newton(xp, step, -required / 1.75, steps=12))
    plain, along_a, along_b, _ = ellipse_integrals(ratio)
    b = (1.5 / math.pi * load * (along_a + along_b) / (e_star * (c_x + c_y))) ** (1.0 / 3.0)
    a = ratio * b
    return Ellipse(a, b, 1.5 / math.pi * load / (a * b), 0.75 / math.pi * load * plain / (e_star * b))


def crossed(load: Array, wheel: Wheel, surface: Surface, steering_angle: Array) -> Crossed:
    r"""Contact of a crowned wheel on a cylinder, a sphere or a plane, at a steering angle.

    The cylinder has curvature 1/R along its circumference, at the steering angle to the rolling direction. Its sum with the
    wheel's curvatures 1/r and 1/r_c has principal axes at

    .. math:: \tan 2\theta = \frac{-\sin 2\phi / R}{1/r - 1/r_c + \cos 2\phi / R}

    On a sphere or a plane, whose curvature is the same in all directions, they lie along and across the rolling direction.

    Parameters
    ----------
    load : (...,) float             Normal load, > 0. [N]
    wheel : infinivar.contact.bodies.Wheel   Rolling radius, crown radius and material.
    surface : Cylinder, Sphere or Plane   Radius and material.
    steering_angle : (...,) float   phi; at 0 the wheel rolls along the circumference, at +-pi/2 along the axis. [rad]

    Returns
    -------
    Crossed   Ellipse and its rotation from the rolling direction; the rotation of a circular patch is 0.

    Raises
    ------
    ParameterError
        If the load is not above zero.

    Source: johnson1985, section 4.1 (sum of the curvatures of two bodies at an angle).
    """
    xp = namespace(load, steering_angle, wheel, surface)
    load, angle = as_floats(xp, load, steering_angle)
    rolling, crown = 1.0 / wheel.rolling_radius, 1.0 / wheel.crown_radius
    around, axial = surface.curvatures
    mean, across = 0.5 * (rolling + crown + around + axial), around - axial
    along = 0.5 * (rolling - crown + across * xp.cos(2.0 * angle))
    shear = -0.5 * across * xp.sin(2.0 * angle)
    half = xp.sqrt(along * along + shear * shear)
    # Where `along` is positive, the axis closer to the rolling direction is the more curved one.
    half = xp.where(along < 0, -half, half)
    level = along == 0
    quarter = 0.25 * math.pi * xp.sign(shear)
    rotation = xp.where(level, quarter, 0.5 * xp.atan(shear / xp.where(level, 1.0, along)))
    e_star = plane_strain_modulus(wheel.material, surface.material)
    return Crossed(ellipse(load, mean + half, mean - half, e_star), rotation + 0.0)  # no negative zero


def axis_stresses(depth: Array, a: Array, b: Array, peak_pressure: Array, poisson: Array) -> tuple[Array, Array, Array]:
    r"""Principal stresses below the centre of an elliptical contact; tension is positive.

    Parameters
    ----------
    depth : (...,) float           Depth below the surface, > 0. [m]
    a, b : (...,) float            Semi-axes, > 0. [m]
    peak_pressure : (...,) float   p0. [Pa]
    poisson : (...,) float         Poisson's ratio of this body. [-]

    Returns
    -------
    sigma_x, sigma_y, sigma_z : (...,) float   [Pa]; inputs broadcast.

    Source: johnson1985, section 3.2 (potential functions of a pressure on a half-space).
    """
    xp = namespace(depth, a, b, peak_pressure, poisson)
    z, a, b, p0, nu = as_floats(xp, depth, a, b, peak_pressure, poisson)
    scale = xp.sqrt(a * b)  # normalise, so that no product overflows
    z, a, b = z / scale, a / scale, b / scale
    from_a, from_b, from_z = a * a + z * z, b * b + z * z, z * z
    # Derivatives of the pressure's potential, and of its integral over depth, divided by pi p0 a b/2.
    # All three integrals in one call.
    from_a, from_b, from_z = xp.broadcast_arrays(from_a, from_b, from_z)
    first, second = xp.stack([from_z, from_z, from_a]), xp.stack([from_b, from_a, from_b])
    integrals = -4.0 / 3.0 * carlson_rd(first, second, xp.stack([from_a, from_b, from_z]))
    by_xx, by_yy, by_z = integrals[0, ...], integrals[1, ...], z * integrals[2, ...]
    root_a, root_b = xp.sqrt(from_a), xp.sqrt(from_b)
    sideways_x = 4.0 / (root_a * (root_a + root_b)) + z * by_xx
    sideways_y = 4.0 / (root_b * (root_a + root_b)) + z * by_yy
    size = 0.25 * p0 * a * b
    return (
        size * (2.0 * nu * by_z - z * by_xx - (1.0 - 2.0 * nu) * sideways_x),
        size * (2.0 * nu * by_z - z * by_yy - (1.0 - 2.0 * nu) * sideways_y),
        size * (by_z + z * (by_xx + by_yy)),
    )


def largest_shear(a: Array, b: Array, peak_pressure: Array, poisson: Array) -> tuple[Array, Array]:
    """Largest shear stress below the centre of an elliptical contact, and its depth.

    Parameters
    ----------
    a, b : (...,) float            Semi-axes, > 0. [m]
    peak_pressure : (...,) float   p0. [Pa]
    poisson : (...,) float         Poisson's ratio of this body, 0 to 0.5. [-]

    Returns
    -------
    shear, depth : (...,) float   [Pa], [m]; relative error of the depth about 1e-7, of the shear much less. The depth is 0
        if the shear is largest at the surface (long patches with a Poisson ratio below about 0.2).

    Notes
    -----
    Neglects surface traction, which adds little for a friction coefficient below 0.3.

    Source: johnson1985, section 4.5.
    """
    xp = namespace(a, b, peak_pressure, poisson)
    a, b, p0, nu = xp.broadcast_arrays(*as_floats(xp, a, b, peak_pressure, poisson))
    width = xp.minimum(a, b)

    def shear(depth: Array) -> Array:
        """In the planes of both axes, at a depth for each, as either may have the largest. (..., 2, *shape)"""
        sigma_x, sigma_y, sigma_z = axis_stresses(depth * width, a, b, p0, nu)
        return 0.5 * (xp.where(first, sigma_x, sigma_y) - sigma_z)

    def falling(depth: Array) -> tuple[Array, Array]:
        here = shear(xp.stack([depth * (1.0 - _BESIDE), depth, depth * (1.0 + _BESIDE)])) / p0
        above, middle, below = (here[place, ...] for place in range(3))
        return above - below, 2.0 * (2.0 * middle - above - below) / (_BESIDE * depth)

    one = xp.stack([xp.ones_like(width)] * 2)
    first = xp.stack([width > 0.0, width < 0.0])
    depth = rising_root(xp, falling, 1e-3 * one, 1.2 * one, _STEPS)
    inside, surface = shear(depth), xp.max(shear(1e-9 * one), axis=0)
    larger = inside[0, ...] >= inside[1, ...]
    inside, depth = (xp.where(larger, part[0, ...], part[1, ...]) for part in (inside, depth))
    return xp.maximum(inside, surface), xp.where(surface > inside, 0.0, depth * width)
