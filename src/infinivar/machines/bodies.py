"""Inertia of rigid bodies and of arms in a plane and in space, and rates of rotation vectors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar.transmission.platform import AFTER, NEXT, crossed, rotation_matrix
from infinivar.transmission.turning_chain import Standing, TurningChain, swung

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
    return (1.0 - share * square) * turning - 0.5 * crossed(vector, turning) + share * along * vector


def angular_velocity(vector: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Angular velocity in fixed axes of a rotation vector with a time derivative: the inverse of `rotation_rate`."""
    square = np.sum(vector * vector, axis=-1, keepdims=True)
    turns = square > _STILL**2
    angle = np.sqrt(np.where(turns, square, 1.0))
    one = np.where(turns, (1.0 - np.cos(angle)) / angle**2, 0.5 - square / 24.0)
    two = np.where(turns, (angle - np.sin(angle)) / angle**3, 1.0 / 6.0 - square / 120.0)
    once = crossed(vector, rate)
    return rate + one * once + two * crossed(vector, once)


def rotation_between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotation vector, in fixed axes, of the turn from one rotation to another, shorter than pi. (3,) each [rad]

    Also of recorded numbers, as controllers use it; `rotation_vector` is exact near pi, too, and of numbers alone.
    """
    return turn_vector(rotation_matrix(end) @ rotation_matrix(start).T)


def turn_vector(turn: np.ndarray) -> np.ndarray:
    """Vector of a rotation shorter than pi, also of recorded numbers and smooth at 0. (..., 3, 3) to (..., 3) [rad]"""
    axis = 0.5 * (turn[..., AFTER, NEXT] - turn[..., NEXT, AFTER])
    square = np.sum(axis * axis, axis=-1, keepdims=True)
    turns = square > _STILL**2
    sine = np.sqrt(np.where(turns, square, 1.0))
    cosine = 0.5 * (turn[..., 0, 0] + turn[..., 1, 1] + turn[..., 2, 2] - 1.0)[..., None]
    return axis * np.where(turns, np.arctan2(sine, cosine) / sine, 1.0 + square / 6.0)


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


class SpatialBody(NamedTuple):
    """A rigid body in axes of its joint."""

    mass: float
    """[kg]"""
    centre: np.ndarray
    """Centre of mass from the joint. (3,) [m]"""
    inertia: np.ndarray
    """About the centre of mass. (3, 3) [kg m^2]"""


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
    bias[:, 3:] = crossed(turning, np.matmul(tensor, turning[..., None])[..., 0])
    return Moved(inertia, bias)


def point_masses(masses: np.ndarray, jacobian: np.ndarray, falling: np.ndarray, gravity: np.ndarray) -> Moved:
    """Point masses that move with coordinates; the bias holds their weights, their energy is not computed.

    Parameters
    ----------
    masses : (k,) float             [kg]
    jacobian : (m, k, 3, d) float   Of the velocity of each.
    falling : (m, k, 3) float       Its acceleration without one of the coordinates. [m s^-2]
    gravity : (3,) float            Acceleration of free fall. [m s^-2]

    Returns
    -------
    inertia, bias : (m, d, d), (m, d) float

    Source: Newton.
    """
    rows = jacobian.reshape(len(jacobian), -1, jacobian.shape[-1])
    weighted = np.swapaxes(rows * np.repeat(masses, 3)[:, None], -1, -2)
    fallen = (falling - gravity).reshape(len(jacobian), -1)
    return Moved(np.matmul(weighted, rows), np.matmul(weighted, fallen[..., None])[..., 0])


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


def joined_in_space(one: SpatialBody, other: SpatialBody) -> SpatialBody:
    """Two rigid bodies as one, in the same axes. Source: parallel axes."""
    mass = one.mass + other.mass
    share = other.mass / mass if mass else 0.0
    apart = other.centre - one.centre
    between = one.mass * share * (apart @ apart * np.eye(3) - np.outer(apart, apart))
    return SpatialBody(mass, one.centre + share * apart, one.inertia + other.inertia + between)


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


def spatial_arm(
    chain: TurningChain,
    at: Standing,
    bodies: Sequence[SpatialBody],
    load: SpatialBody,
    rates: np.ndarray,
    gravity: np.ndarray,
) -> Moved:
    """An arm in space, in joint angles, with a load on its last member whose weight is a part of the wrench.

    Parameters
    ----------
    chain : TurningChain
    at : Standing               Of its joints at m rows.
    bodies : n bodies           Behind the joints.
    load : SpatialBody          In axes of the last joint.
    rates : (m, n) float        [rad s^-1]
    gravity : (3,) float        Acceleration of free fall. [m s^-2]

    Returns
    -------
    Moved   As of `planar_arm`; the energy of the weight is nowhere negative.

    Source: featherstone2008, chapters 5 and 6: recursive Newton-Euler, and composite rigid bodies, about the joints.
    """
    n, still = len(bodies), 0.0 * at.place[0]
    levers = [at.place[joint] - at.place[joint - 1] for joint in range(1, n)]
    turning, falling, moved = [still], [still], still
    forces, moments, whole = [], [], []
    potential = 0.0 * rates[:, 0]
    for joint in range(n):
        own = at.axis[joint] * rates[:, joint, None]
        if joint:
            moved = moved + swung(turning[-1], falling[-1], levers[joint - 1])
        falling.append(falling[-1] + crossed(turning[-1], own))
        turning.append(turning[-1] + own)
        force = moment = first = still
        second, mass = 0.0 * at.turn[joint], 0.0
        for body in (bodies[joint], load) if joint == n - 1 else (bodies[joint],):
            centre = np.matmul(at.turn[joint], body.centre)
            tensor = np.matmul(np.matmul(at.turn[joint], body.inertia), np.swapaxes(at.turn[joint], -1, -2))
            pushed = body.mass * (moved + swung(turning[-1], falling[-1], centre))
            if body is not load:
                pushed = pushed - body.mass * gravity
                raised = at.place[joint] - at.place[0] + centre
                potential = potential - body.mass * np.sum(raised * gravity, axis=-1)
            force = force + pushed
            moment = moment + crossed(centre, pushed) + _applied(tensor, falling[-1])
            moment = moment + crossed(turning[-1], _applied(tensor, turning[-1]))
            first, mass = first + body.mass * centre, mass + body.mass
            second = second + tensor + _about(centre, body.mass * centre)
        forces.append(force)
        moments.append(moment)
        whole.append((mass, first, second))
    potential = potential + float(np.linalg.norm(gravity)) * chain_moment(chain, bodies)
    # From the last joint to the first: what is beyond acts at each one's place.
    rows: list[list[np.ndarray]] = [[still[:, 0]] * n for _ in range(n)]
    bias: list[np.ndarray] = [still[:, 0]] * n
    for joint in reversed(range(n)):
        mass, first, second = whole[joint]
        if joint < n - 1:
            lever, (further, beyond, about) = levers[joint], whole[joint + 1]
            forces[joint] = forces[joint] + forces[joint + 1]
            moments[joint] = moments[joint] + moments[joint + 1] + crossed(lever, forces[joint + 1])
            second = second + about + _about(lever, beyond) + _about(beyond, lever) + _about(lever, further * lever)
            mass, first = mass + further, first + beyond + further * lever
            whole[joint] = mass, first, second
        axis = at.axis[joint]
        bias[joint] = np.sum(axis * moments[joint], axis=-1)
        pushed, turned = crossed(axis, first), _applied(second, axis)
        for near in reversed(range(joint + 1)):
            rows[near][joint] = rows[joint][near] = np.sum(at.axis[near] * turned, axis=-1)
            if near:
                turned = turned + crossed(levers[near - 1], pushed)
    inertia = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return Moved(inertia, np.stack(bias, axis=-1), potential)


def chain_moment(chain: TurningChain, bodies: Sequence[SpatialBody]) -> float:
    """First moment of an arm that would hang stretched from its first joint: none of its poses has a larger one. [kg m]"""
    masses = np.array([body.mass for body in bodies])
    own = float(np.sum(masses * np.linalg.norm([body.centre for body in bodies], axis=-1)))
    beyond = np.cumsum(masses[::-1])[::-1][1:]
    return own + float(np.sum(beyond * np.linalg.norm(chain.places[1:], axis=-1)))


def _applied(tensor: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return np.matmul(tensor, vector[..., None])[..., 0]


def _about(lever: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Moment of inertia of a mass at a lever, whose first moment is given. (m, 3, 3)"""
    square = np.sum(lever * moment, axis=-1)[..., None, None]
    return square * np.eye(3) - moment[..., :, None] * lever[..., None, :]
