r"""What bounds a steered wheel that guides a load, whatever steers it: friction, and the time that turning takes.

A wheel that rolls at the speed u and turns at the rate W needs the lateral force :math:`m u W`. With a user who pushes into
the wall with :math:`F_n`, the contact has :math:`\mu P - F_n` left for it. A wheel that reaches a wall at the angle
:math:`\theta` and turns only from there on overruns it before it is parallel to it.
"""

from __future__ import annotations

import math

from annotated_types import Ge, Gt, Interval

from infinivar._core.array_namespace import Array, namespace
from infinivar._core.fields import check_value

_BOUNDS = {
    "slip_force": (Gt(0), "N"),
    "push": (Ge(0), "N"),
    "mass": (Gt(0), "kg"),
    "speed": (Gt(0), "m/s"),
    "angle": (Interval(ge=0, le=math.pi), "rad"),
    "turn_rate": (Ge(0), "rad/s"),
}


def _checked(**values: Array) -> None:
    for name, value in values.items():
        bound, unit = _BOUNDS[name]
        check_value(name, value, unit, bound)


def largest_turn_rate(slip_force: Array, push: Array, mass: Array, speed: Array) -> Array:
    r"""Largest rate at which a steered wheel can turn its path away from a wall.

    .. math:: W \le \frac{\mu P - F_n}{m u}

    Parameters
    ----------
    slip_force : (...,) float   mu P of all wheels that guide the load, > 0. [N]
    push : (...,) float         F_n, with which the user pushes into the wall, >= 0. [N]
    mass : (...,) float         m, > 0. [kg]
    speed : (...,) float        u, along the path, > 0. [m s^-1]

    Returns
    -------
    (...,) float   [rad s^-1]; 0 if the push alone makes the wheel slip.

    Source: Newton's law across the path of a mass that turns.
    """
    _checked(slip_force=slip_force, push=push, mass=mass, speed=speed)
    xp = namespace(slip_force, push, mass, speed)
    spare = slip_force - push
    return xp.where(spare > 0, spare, 0.0 * spare) / (mass * speed)


def overrun(speed: Array, turn_rate: Array, angle: Array) -> Array:
    r"""How far a wheel runs through a wall if it turns only from the wall on.

    .. math:: \frac{u}{W} (1 - \cos\theta)

    Parameters
    ----------
    speed : (...,) float       u, > 0. [m s^-1]
    turn_rate : (...,) float   W, >= 0. [rad s^-1]
    angle : (...,) float       theta, between path and wall, 0 to pi. [rad]

    Returns
    -------
    (...,) float   [m]; infinite for a wheel that does not turn, unless it runs along the wall.

    Source: an arc of radius u/W.
    """
    _checked(speed=speed, turn_rate=turn_rate, angle=angle)
    xp = namespace(speed, turn_rate, angle)
    depth = 1.0 - xp.cos(xp.asarray(angle, dtype=xp.float64))
    turns = turn_rate > 0
    radius = xp.where(turns, speed / xp.where(turns, turn_rate, 1.0), xp.inf)
    return xp.where(depth > 0, radius * xp.where(depth > 0, depth, 1.0), 0.0)


def stopping_distance(slip_force: Array, push: Array, mass: Array, speed: Array) -> Array:
    r"""Least distance in which a link on a cylinder stops at a wall.

    .. math:: \frac{m u^2}{2 (\mu P - F_n)}

    Parameters
    ----------
    slip_force, push, mass, speed : (...,) float   As in `largest_turn_rate`; of the link. [N], [N], [kg], [m s^-1]

    Returns
    -------
    (...,) float   [m]; infinite if the push alone makes the wheel slip.

    Source: constant deceleration at the slip limit.
    """
    _checked(slip_force=slip_force, push=push, mass=mass, speed=speed)
    xp = namespace(slip_force, push, mass, speed)
    spare = slip_force - push
    holds = spare > 0
    return xp.where(holds, 0.5 * mass * speed * speed / xp.where(holds, spare, 1.0), xp.inf)
