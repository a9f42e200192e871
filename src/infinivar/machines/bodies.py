"""Inertia of rigid bodies and planar arms, and rates of rotation vectors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar.transmission.platform import rotation_matrix

_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]

_STILL = 1e-4
"""Angle [rad] below which the series of a coefficient is exact to rounding."""


def rotation_rate(vector: np.ndarray, turning: np.ndarray) -> np.ndarray:
    r"""Time derivative of a rotation vector at an angular velocity in fixed axes.

    .. math:: \dot\theta = \omega - \tfrac12\,\theta\times\omega
        + \left(\frac{1}{\vartheta^2} - \frac{\cot(\vartheta/2)}{2\vartheta}\right)\theta\times(\theta\times\omega)

    Parameters
    ----------
    vector : (..., 3) float    theta, shorter than 2 pi. [rad]
    turning : (..., 3) float   omega. [rad s^-1]

    Returns
    -------
    (..., 3) float   [rad s^-1]

    Source: inverse of the left Jacobian of the rotation group.
    """
    square = np.sum(vector * vector, axis=-1, keepdims=True)
    turns = square > _STILL**2
    angle = np.sqrt(np.where(turns, square, 1.0))
    share = np.where(turns, 1.0 / angle**2 - 0.5 / (angle * np.tan(0.5 * angle)), 1.0 / 12.0 + square / 720.0)
    along = np.sum(vector * turning, axis=-1, keepdims=True)
    return (1.0 - share * square) * turning - 0.5 * _crossed(vector, turning) + share * along * vector


def angular_velocity(vector: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Angular velocity in fixed axes of a rotation vector with a time derivative: the inverse of `rotation_rate`."""
    square = np.sum(vector * vector, axis=-1, keepdims=True)
    turns = square > _STILL**2
    angle = np.sqrt(np.where(turns, square, 1.0))
    one = np.where(turns, (1.0 - np.cos(angle)) / angle**2, 0.5 - square / 24.0)
    two = np.where(turns, (angle - np.sin(angle)) / angle**3, 1.0 / 6.0 - square / 120.0)
    once = _crossed(vector, rate)
    return rate + one * once + two * _crossed(vector, once)


def rotation_between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotation vector, in fixed axes, of the turn from one rotation to another, shorter than pi. (3,) each [rad]"""
    turn = rotation_matrix(end) @ rotation_matrix(start).T
    axis = 0.5 * (turn[_AFTER, _NEXT] - turn[_NEXT, _AFTER])
    sine, cosine = np.sqrt(np.sum(axis * axis)), 0.5 * (np.trace(turn) - 1.0)
    turns = sine > 1e-12
    return axis * np.where(turns, np.arctan2(sine, cosine) / np.where(turns, sine, 1.0), 1.0)


def _crossed(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return one[..., _NEXT] * other[..., _AFTER] - one[..., _AFTER] * other[..., _NEXT]


class Moved(NamedTuple):
    """Inertia of a body, and the forces of its motion without acceleration."""

    inertia: np.ndarray
    bias: np.ndarray
    potential: Any = 0.0
    """Energy of its weight, nowhere negative. (m,) [J]"""

    def forces(self, acceleration: np.ndarray) -> np.ndarray:
        """Forces that give the bodies accelerations (..., d), in the order of their rows. (..., d)"""
        shape = acceleration.shape
        pushed = np.matmul(self.inertia.reshape(*shape, shape[-1]), acceleration[..., None])[..., 0]
        return pushed + self.bias.reshape(shape)


class PlanarBody(NamedTuple):
    """A rigid body in a plane."""

    mass: float
    """[kg]"""
    centre: np.ndarray
    """Centre of mass. (2,) [m]"""
    inertia: float
    """About the centre of mass. [kg m^2]"""


def rigid_body(mass: float, principal: np.ndarray, turn: np.ndarray, twist: np.ndarray) -> Moved:
    """A body of which the reference point is the centre of mass, in fixed axes.

    Parameters
    ----------
    mass : float               [kg]
    principal : (3,) float     Moments of inertia about the axes of the body. [kg m^2]
    turn : (m, 3, 3) float     Rotation matrix.
    twist : (m, 6) float       Velocity and angular velocity.

    Returns
    -------
    inertia, bias : (m, 6, 6), (m, 6) float

    Source: Newton and Euler.
    """
    tensor = np.matmul(turn * principal, np.swapaxes(turn, -1, -2))
    inertia = np.zeros_like(turn, shape=(len(turn), 6, 6))
    inertia[:, (0, 1, 2), (0, 1, 2)] = mass
    inertia[:, 3:, 3:] = tensor
    turning = twist[:, 3:]
    bias = np.zeros_like(turn, shape=(len(turn), 6))
    bias[:, 3:] = _crossed(turning, np.matmul(tensor, turning[..., None])[..., 0])
    return Moved(inertia, bias)


def joined(one: PlanarBody, other: PlanarBody) -> PlanarBody:
    """Two rigid bodies in a plane as one, in the same axes; one without mass adds its moment of inertia only.

    Source: parallel axes.
    """
    mass = one.mass + other.mass
    if not other.mass:
        return one._replace(inertia=one.inertia + other.inertia)
    apart = other.centre - one.centre
    reduced = one.mass * other.mass / mass
    return PlanarBody(
        mass, one.centre + other.mass / mass * apart, one.inertia + other.inertia + reduced * float(apart @ apart)
    )


def planar_arm(
    lengths: np.ndarray,
    masses: np.ndarray,
    inertias: np.ndarray,
    tip_mass: float,
    angles: np.ndarray,
    rates: np.ndarray,
    *,
    centres: np.ndarray | None = None,
    gravity: Sequence[float] | None = None,
) -> Moved:
    r"""An arm in a plane, with a mass at its end point, in joint angles.

    Parameters
    ----------
    lengths, masses, inertias : (n,) float   Of the members; inertias about the centres of mass.
    tip_mass : float                         At the end point, of a load whose weight is a part of the wrench. [kg]
    angles, rates : (m, n) float             Of the joints, each relative to the member before. [rad], [rad s^-1]
    centres : (n, 2) float                   Centres of mass, along and across the member from its joint; without them in the
                                             middle. [m]
    gravity : (2,) float                     Acceleration of free fall along x and y; without it none. [m s^-2]

    Returns
    -------
    inertia, bias : (m, n, n), (m, n) float   [kg m^2], [N m]; the bias holds the weight, as what the joints exert against it.
    potential : (m,) float                    0 where all members hang. [J]

    Notes
    -----
    Member j and all beyond it have the first moment :math:`s_j e^{i a_j}` about joint j, with :math:`s_j = m_j c_j + l_j b_j`,
    the centre c as a complex number and the mass b beyond. A pair (i, j) with i nearer to the base has
    :math:`H_{ij} = l_i\,\mathrm{Re}(s_j e^{i(a_j - a_i)})`, and weight exerts :math:`\mathrm{Re}(\bar g\, i s_j e^{i a_j})`, the
    derivative of its work :math:`\mathrm{Re}(\bar g\, s_j e^{i a_j})`.

    Source: d'Alembert in absolute angles: centrifugal moments are ``dH_ij/da_j (da_j/dt)^2``.
    """
    n = len(lengths)
    beyond = np.append(np.cumsum(masses[::-1])[::-1][1:], 0.0) + tip_mass  # masses carried by each member's end
    along, across = (np.full(n, 0.5), np.zeros(n)) if centres is None else (centres / lengths[:, None]).T
    coupling, skew = np.empty((n, n)), np.zeros((n, n))
    for i in range(n):
        for j in range(n):
            far, near = max(i, j), min(i, j)
            coupling[i, j] = lengths[near] * lengths[far] * (along[far] * masses[far] + beyond[far])
            skew[i, j] = np.sign(j - i) * lengths[near] * lengths[far] * across[far] * masses[far]
            if i == j:
                square = along[i] ** 2 + across[i] ** 2
                coupling[i, i] = inertias[i] + lengths[i] ** 2 * (square * masses[i] + beyond[i])
    absolute, turning = np.cumsum(angles, axis=-1), np.cumsum(rates, axis=-1)
    apart = absolute[:, :, None] - absolute[:, None, :]
    inertia, pulling = coupling * np.cos(apart), coupling * np.sin(apart)
    if np.any(skew):
        inertia, pulling = inertia + skew * np.sin(apart), pulling - skew * np.cos(apart)
    bias, potential = np.matmul(pulling, (turning * turning)[..., None])[..., 0], 0.0
    if gravity is not None:
        x, y = gravity
        sine, cosine = np.sin(absolute), np.cos(absolute)
        ahead, left = lengths * (along * masses + beyond - tip_mass), lengths * across * masses
        fallen, turned = x * cosine + y * sine, x * sine - y * cosine
        bias = bias + ahead * turned + left * fallen
        lowest = np.hypot(x, y) * np.sum(np.hypot(ahead, left))
        potential = lowest - np.sum(ahead * fallen - left * turned, axis=-1)
    # Absolute angles are sums of joint angles.
    outward = np.tril(np.ones((n, n)))
    return Moved(outward.T @ inertia @ outward, bias @ outward, potential)
