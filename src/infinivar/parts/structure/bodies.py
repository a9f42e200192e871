"""Bodies between the bought parts: a crowned wheel, a ring, a bar that closes the path of a force, a wound spring."""

from __future__ import annotations

import math
from typing import NamedTuple

from infinivar._core.array_namespace import Array, as_floats, namespace

_GAP = 1e-3
"""Between parts that move. [m]"""


def close_span(wheel_width: Array, bearing_width: Array) -> Array:
    """Distance of the middles of two bearings that stand close to a wheel. [m]"""
    return wheel_width + bearing_width + 2.0 * _GAP


def crown_height(crown: Array, width: Array) -> Array:
    r"""How far the rim of a wheel falls to its sides, :math:`\varrho - \sqrt{\varrho^2 - (w/2)^2}`.

    Parameters
    ----------
    crown, width : (...,) float   As for `crowned_volume`. [m]

    Returns
    -------
    (...,) float   [m]

    Source: sagitta of an arc.
    """
    xp = namespace(crown, width)
    crown, width = as_floats(xp, crown, width)
    half = xp.minimum(0.5 * width, crown)
    # As a product, which rounding does not make negative where the crown is half as wide as the wheel.
    return crown - xp.sqrt((crown - half) * (crown + half))


def crowned_volume(radius: Array, crown: Array, width: Array) -> Array:
    r"""Volume of a wheel whose rim is an arc, :math:`\pi\int (r - \varrho + \sqrt{\varrho^2 - z^2})^2 dz` over its width.

    Parameters
    ----------
    radius, crown : (...,) float   Largest radius r, and radius of the arc across the rim. [m]
    width : (...,) float           At most twice the crown radius: a wider wheel counts as that wide. [m]

    Returns
    -------
    (...,) float   [m^3]

    Source: volume of a solid of revolution.
    """
    xp = namespace(radius, crown, width)
    radius, crown, width = as_floats(xp, radius, crown, width)
    half = xp.minimum(0.5 * width, crown)
    share, inner = half / crown, radius - crown
    arc = half * crown * xp.sqrt(xp.maximum(1.0 - share * share, 0.0)) + crown**2 * xp.asin(share)
    return math.pi * (2.0 * inner**2 * half + 2.0 * inner * arc + 2.0 * (crown**2 * half - half**3 / 3.0))


def ring_volume(inner: Array, wall: Array, length: Array) -> Array:
    """Volume of a ring or short tube. [m^3]"""
    return math.pi * ((inner + wall) ** 2 - inner**2) * length


class Bell(NamedTuple):
    """A ring around a wheel, closed by a disc, with square bosses for the bearings of its axle; arrays that broadcast."""

    wheel_radius: Array
    """[m]"""
    wheel_width: Array
    """[m]"""
    bearing_diameter: Array
    """Outside diameter of the axle's bearings. [m]"""
    bearing_width: Array
    """[m]"""
    wall: Array
    """Of ring and disc, and around the bearings. [m]"""

    @property
    def span(self) -> Array:
        """Between the middles of the axle's bearings. [m]"""
        return close_span(self.wheel_width, self.bearing_width)

    @property
    def inner(self) -> Array:
        """Inner radius of the ring: that of the corners of the wheel or of the bearings, and a gap. [m]"""
        xp = namespace(*self)
        radius, width, diameter, ends = as_floats(
            xp, self.wheel_radius, self.wheel_width, self.bearing_diameter, self.span + self.bearing_width
        )
        wheel, bearings = xp.sqrt(radius**2 + 0.25 * width**2), 0.5 * xp.sqrt(ends**2 + diameter**2)
        return xp.maximum(wheel, bearings) + _GAP

    @property
    def outer(self) -> Array:
        """Outer radius. [m]"""
        return self.inner + self.wall

    @property
    def height(self) -> Array:
        """Of the bosses. [m]"""
        return self.bearing_diameter + 2.0 * self.wall

    @property
    def drop(self) -> Array:
        """From the axis of the wheel to the lower edge of the ring, which clears what the wheel rolls on. [m]"""
        xp = namespace(*self)
        height, radius = as_floats(xp, self.height, self.wheel_radius)
        return xp.minimum(0.5 * height, radius - _GAP)

    @property
    def rise(self) -> Array:
        """From the axis of the wheel to the outer face of the disc, which clears wheel and bosses. [m]"""
        xp = namespace(*self)
        height, radius, wall = as_floats(xp, self.height, self.wheel_radius, self.wall)
        return xp.maximum(0.5 * height, radius + _GAP) + wall

    @property
    def volume(self) -> Array:
        """[m^3]"""
        ring, disc, bosses = self._volumes
        return ring + disc + bosses

    @property
    def second_moment(self) -> Array:
        """Of its volume about the steering axis. [m^5]

        Source: young2002, Table A.1 (ring and disc); bosses as plates at half the span.
        """
        ring, disc, bosses = self._volumes
        about = 0.25 * self.span**2 + (self.bearing_width**2 + self.height**2) / 12.0
        return ring * 0.5 * (self.inner**2 + self.outer**2) + disc * 0.5 * self.outer**2 + bosses * about

    @property
    def _volumes(self) -> tuple[Array, Array, Array]:
        ring = ring_volume(self.inner, self.wall, self.drop + self.rise - self.wall)
        boss = self.bearing_width * (self.height**2 - 0.25 * math.pi * self.bearing_diameter**2)
        return ring, math.pi * self.outer**2 * self.wall, 2.0 * boss


def bar_height(
    force: Array, moment: Array, span: Array, width: Array, *, modulus: Array, sag: Array, strength: Array
) -> Array:
    r"""Height of a bar that carries a force at its middle and a moment along its whole length, between two supports.

    .. math:: \frac{b h^3}{12} \ge \frac{F L^3/48 + M L^2/8}{E \delta}, \qquad \frac{b h^2}{6} \ge \frac{F L/4 + M}{\sigma}

    Parameters
    ----------
    force, moment : (...,) float   F and M, >= 0. [N], [N m]
    span, width : (...,) float     L and b. [m]
    modulus : (...,) float         E. [Pa]
    sag, strength : (...,) float   Permissible deflection at the middle, and stress. [m], [Pa]

    Returns
    -------
    (...,) float   The larger of both heights. [m]

    Source: young2002, Table 8.1, case 1e, case 3e for equal and opposite moments at both ends, and Table A.1.
    """
    xp = namespace(force, moment, span, width, modulus, sag, strength)
    force, moment, span, width = as_floats(xp, force, moment, span, width)
    stiff = 12.0 * (force * span**3 / 48.0 + moment * span**2 / 8.0) / (modulus * sag * width)
    strong = 6.0 * (0.25 * force * span + moment) / (strength * width)
    return xp.maximum(stiff ** (1.0 / 3.0), strong**0.5)


def ring_moments(load: Array, radius: Array, count: int) -> tuple[Array, Array]:
    r"""Largest bending moment, and the tension with it, in a ring under equal radial loads from inside, evenly around.

    .. math:: M = \frac{P R}{2}\left(\frac{1}{\theta} - \cot\theta\right), \qquad
        N = \frac{P}{2}\cot\theta, \qquad \theta = \frac{\pi}{n}

    Parameters
    ----------
    load, radius : (...,) float   P of each, and R of the mean line. [N], [m]
    count : int                   n, 2 or more.

    Returns
    -------
    moment, tension : (...,) float   At each load. [N m], [N]

    Source: young2002, Table 9.2, equal radial loads evenly around, for a thin ring.
    """
    half = math.pi / count
    slope = 1.0 / math.tan(half) if count > 2 else 0.0  # rounding leaves 6e-17 of a right angle
    return 0.5 * load * radius * (1.0 / half - slope), 0.5 * load * slope


def ring_thickness(load: Array, radius: Array, count: int, width: Array, strength: Array) -> Array:
    r"""Radial thickness of a ring of a width [m] whose stress ``6 M/(w t^2) + N/(w t)`` reaches a strength [Pa]. [m]

    Other parameters and source as of `ring_moments`.
    """
    moment, tension = ring_moments(load, radius, count)
    share = 0.5 * tension / (width * strength)
    return share + (share**2 + 6.0 * moment / (width * strength)) ** 0.5


def wire_mass(energy: Array, strength: Array, modulus: Array, density: Array, *, bent: bool = False) -> Array:
    r"""Mass of the active wire of a helical spring that stores an energy: the lightest of round wire.

    .. math:: m = \frac{4 \varrho G U}{\tau^2} \quad\text{(pulled or pressed)}, \qquad
        m = \frac{8 \varrho E U}{\sigma^2} \quad\text{(wound up)}

    Parameters
    ----------
    energy : (...,) float               U. [J]
    strength, modulus : (...,) float    tau and G; wound up, sigma and E. [Pa]
    density : (...,) float              [kg m^-3]
    bent : bool                         Whether the spring is wound up: a torsion spring, whose wire bends.

    Returns
    -------
    (...,) float   Without end coils; the curvature of the wire is left out. [kg]

    Source: wahl1963: wire in torsion stores ``tau^2/(4 G)`` a volume, in bending ``sigma^2/(8 E)``.
    """
    return (8.0 if bent else 4.0) * density * modulus * energy / strength**2
