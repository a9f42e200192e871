r"""Laws that guide a body in the plane by turning its direction of motion :math:`\psi`, without forces along it.

The wheels let the handle move along psi only, at the speed u that the user gives it. Whatever turns psi does no work.
"""

from __future__ import annotations

import math


def path_turning(curvature: float, offset: float, angle: float, k1: float, k2: float) -> float:
    r"""Turning per metre that leads a point back to a path.

    .. math:: \frac{d\psi}{ds} = \frac{\kappa \cos e}{1 - \kappa d} - k_1 d - k_2 e

    Near the path ``d'' + k2 d' + k1 d = 0`` by travelled length, critically damped for ``k2 = 2 sqrt(k1)``.

    Parameters
    ----------
    curvature : float   kappa of the path at the closest point, positive to the left. [m^-1]
    offset : float      d, of the point to the left of the path; below the radius of curvature. [m]
    angle : float       e, from the path's tangent to the direction of motion. [rad]
    k1 : float          [m^-2]
    k2 : float          [m^-1]

    Returns
    -------
    float   [rad m^-1]

    Source: kinematics of a point beside a curve.
    """
    beside = max(1.0 - curvature * offset, 0.1)  # beyond the centre of curvature there is no way around
    return curvature * math.cos(angle) / beside - k1 * offset - k2 * angle


def creep_offset(slip_angle: float, k1: float) -> float:
    r"""Offset at which `path_turning` settles if a slip angle is not fed forward: :math:`2\beta/\sqrt{k_1}` if critically damped.

    Parameters
    ----------
    slip_angle : float   From heading to path, positive to the left. [rad]
    k1 : float           [m^-2]

    Returns
    -------
    float   [m]

    Source: `path_turning` at rest, with e = -beta.
    """
    return 2.0 * slip_angle / math.sqrt(k1)


def caster_rate(force: float, mass: float, speed: float) -> float:
    r"""Rate at which a free mass turns under a force across its motion, :math:`F_n/(M u)`. [rad s^-1]

    With the mass of the machine itself it moves as a free mass; the force along the motion always acts on the machine's mass.

    Parameters
    ----------
    force : float   F_n, to the left of the direction of motion. [N]
    mass : float    M, wanted. [kg]
    speed : float   u along the direction of motion, not 0; negative backwards. [m s^-1]

    Source: Newton.
    """
    return force / (mass * speed)


def contact_turning_limit(slip_force: float, force: float, mass: float, speed: float) -> float:
    r"""Fastest turn of a wheel that carries the body, :math:`(\mu P - F_n)/(m |u|)`; beyond it, the wheel slips. [rad s^-1]

    Parameters
    ----------
    slip_force : float   mu P. [N]
    force : float        F_n, of the user against the turn, >= 0 where it takes from the turn. [N]
    mass : float         m, that the wheel turns. [kg]
    speed : float        u, not 0. [m s^-1]

    Returns
    -------
    float   0 where the user's force alone exceeds the slip force.

    Source: Newton, with mu P as the largest lateral force.
    """
    return max(slip_force - force, 0.0) / (mass * abs(speed))


def wall_overshoot(speed: float, rate: float, angle: float) -> float:
    r"""Depth to which a wall is overrun by a wheel that turns only from the wall on: :math:`(u/W)(1 - \cos\theta)`. [m]

    Parameters
    ----------
    speed : float   u > 0. [m s^-1]
    rate : float    W > 0, at which the wheel turns. [rad s^-1]
    angle : float   theta, from the wall to the direction of approach. [rad]

    Source: an arc of radius u/W.
    """
    return speed / rate * (1.0 - math.cos(angle))
