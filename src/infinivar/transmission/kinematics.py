"""Velocities and forces of a steered wheel between a turning surface and the link that carries it: Eq 3, Eq 4, Eq 5, Eq 6."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from infinivar._core.array_namespace import Array, check_broadcast, named_floats, namespace, signed_infinity
from infinivar.errors import require

BEYOND_ANY = 1e200
"""Secant of a right angle: finite, so that its product with a zero force is zero."""

Heading = Any
"""Angles (..., k) from x to the rolling direction of each wheel [rad], or a tuple of their cosines and sines."""

_ROUNDED = 1e-6
"""Error of the squares of a cosine and a sine that counts as rounding. [-]"""

RIGHT_ANGLE = 1e-15
"""A cosine below this counts as a right angle: cos(pi/2) is 6e-17 in float64."""


def relative_velocities(link_speed: Array, surface_speed: Array, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Creep velocity u and rolling velocity v of the wheel at the contact.

    Parameters
    ----------
    link_speed, surface_speed : (...,) float   ldot and R omega. [m s^-1]
    cosine, sine : (...,) float                Of the steering angle. [-]

    Returns
    -------
    u, v : (...,) float   [m s^-1]; inputs broadcast.

    Source: faulring2006, Eq 3 and Eq 4.
    """
    return link_speed * cosine + surface_speed * sine, link_speed * sine - surface_speed * cosine


def contact_balance(
    lateral_force: Array, rolling_force: Array, cosine: Array, sine: Array, cylinder_radius: Array
) -> tuple[Array, Array]:
    """Cylinder torque and link force that balance the contact forces.

    Parameters
    ----------
    lateral_force, rolling_force : (...,) float   f_u and f_r. [N]
    cosine, sine : (...,) float                   Of the steering angle. [-]
    cylinder_radius : (...,) float                R. [m]

    Returns
    -------
    tau, fl : (...,) float   [N m], [N]; inputs broadcast.

    Source: faulring2006, Eq 5 and Eq 6.
    """
    tau = cylinder_radius * (lateral_force * sine - rolling_force * cosine)
    return tau, -lateral_force * cosine - rolling_force * sine


@dataclass(frozen=True, slots=True)
class Steering:
    """Trigonometric functions of the steering angle, computed once for all formulas."""

    cosine: Array
    sine: Array
    tangent: Array
    secant: Array

    @classmethod
    def at_angle(cls, xp: Any, angle: Array) -> Steering:
        """From an angle, including right angles."""
        cosine, sine = xp.cos(angle), xp.sin(angle)
        right = xp.abs(cosine) < RIGHT_ANGLE
        safe = xp.where(right, 1.0, cosine)
        tangent = xp.where(right, signed_infinity(xp, sine), sine / safe)
        return cls(xp.where(right, 0.0, cosine), sine, tangent, xp.where(right, BEYOND_ANY, 1.0 / safe))

    @classmethod
    def at_tangent(cls, xp: Any, tangent: Array) -> Steering:
        """From a tangent, finite or nan."""
        secant = xp.sqrt(1.0 + tangent * tangent)
        cosine = 1.0 / secant
        return cls(cosine, tangent * cosine, tangent, secant)


def driven(
    xp: Any, surface_speed: Array, spin: Array, creepage: Array, steering: Steering, along: Array
) -> tuple[Array, Array]:
    """Rolling speed |v| and link speed of a wheel that rolls in the direction in which the cylinder drives it.

    `along` is ``cos(phi) + s e sin(phi)``, positive for such a wheel; otherwise the result is invalid.
    """
    rolling = surface_speed / xp.where(along > 0, along, 1.0)
    return rolling, rolling * (creepage * steering.cosine - spin * steering.sine)


def applied_to(matrix: Array, vector: Array) -> Array:
    """Product of a matrix (..., m, n) and a vector (..., n)."""
    xp = namespace(matrix, vector)
    if matrix.ndim == 2 and vector.ndim > 1:
        return xp.matmul(vector, xp.matrix_transpose(matrix))
    return xp.matmul(matrix, vector[..., None])[..., 0]


def directions(xp: Any, heading: Heading, wheels: int) -> tuple[Array, Array]:
    """Cosines and sines of headings.

    Raises
    ------
    ParameterError
        If there is not one heading for each wheel, or one for all.
    """
    parts = heading if isinstance(heading, tuple) else (heading,)
    require(
        len(parts) == 1 + isinstance(heading, tuple),
        "heading",
        f"a tuple of {len(parts)}",
        "angles, or a tuple of their cosines and sines",
    )
    given = tuple(named_floats(xp, heading=part)[0] for part in parts)
    for part in given:
        shape = tuple(part.shape)
        require(
            shape[-1:] in ((wheels,), (1,)),
            "heading",
            f"shape {shape}",
            f"of shape (..., {wheels}), one for each wheel",
        )
    if isinstance(heading, tuple):
        cosine, sine = given
        if xp.__name__ == "numpy":
            check_broadcast(cosines=cosine.shape, sines=sine.shape)
            squares = cosine * cosine + sine * sine
            off = xp.abs(squares - 1.0) > _ROUNDED
            require(not xp.any(off), "heading", squares[off][:1], "cosines and sines whose squares add up to 1")
        return cosine, sine
    return xp.cos(given[0]), xp.sin(given[0])
