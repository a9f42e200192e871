r"""What bounds a steered wheel that guides a load, whatever steers it: friction, and the time that turning takes.

A wheel that rolls at the speed u and turns at the rate W needs the lateral force :math:`m u W`. With a user who pushes into
the wall with :math:`F_n`, the contact has :math:`\mu P - F_n` left for it. A wheel that reaches a wall at the angle
:math:`\theta` and turns only from there on overruns it before it is parallel to it.
"""

from __future__ import annotations

import math

import numpy as np

from infinivar._core.array_namespace import Array


def largest_turn_rate(slip_force: Array, push: Array, mass: Array, speed: Array) -> np.ndarray:
    r"""Largest rate at which a steered wheel can turn its path away from a wall; beyond it, the wheel slips.

    .. math:: W \le \frac{\mu P - F_n}{m |u|}

    Parameters
    ----------
    slip_force : (...,) float   mu P of all wheels that guide the load, > 0. [N]
    push : (...,) float         F_n, with which the user pushes into the wall, >= 0. [N]
    mass : (...,) float         m that the wheel turns, > 0. [kg]
    speed : (...,) float        u, along the path, not 0. [m s^-1]

    Returns
    -------
    (...,) float   [rad s^-1]; 0 if the push alone makes the wheel slip.

    Source: Newton's law across the path of a mass that turns.
    """
    return np.maximum(slip_force - push, 0.0) / (mass * np.abs(speed))


def overrun(speed: float, turn_rate: float, angle: float) -> float:
    r"""How far a wheel runs through a wall if it turns only from the wall on: :math:`(u/W)(1 - \cos\theta)`. [m]

    Parameters
    ----------
    speed : float       u, > 0. [m s^-1]
    turn_rate : float   W, >= 0; a wheel that does not turn runs on, unless it runs along the wall. [rad s^-1]
    angle : float       theta, between path and wall, 0 to pi. [rad]

    Source: an arc of radius u/W.
    """
    depth = 1.0 - math.cos(angle)
    if depth == 0.0:
        return 0.0
    return speed / turn_rate * depth if turn_rate > 0 else math.inf


def stopping_distance(slip_force: float, push: float, mass: float, speed: float) -> float:
    r"""Least distance in which a link on a cylinder stops at a wall: :math:`m u^2/2(\mu P - F_n)`. [m]

    Parameters
    ----------
    slip_force, push, mass, speed : float   As in `largest_turn_rate`; of the link, which slips on if pushed harder.

    Source: constant deceleration at the slip limit.
    """
    spare = slip_force - push
    return 0.5 * mass * speed * speed / spare if spare > 0 else math.inf
