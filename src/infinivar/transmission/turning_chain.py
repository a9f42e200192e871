r"""Arms in space: n joints that turn, each about an axis of the member before, and a tool on the last member.

With the turn of joint j about its axis a, :math:`R_j = R_{j-1} P_j\,(a a^T + \cos q_j (1 - a a^T) + \sin q_j [a]_\times)`, and
the twist of the tool is ``xi = J qdot`` with columns :math:`(a_j \times (p - o_j),\ a_j)` in axes of the base.

Source: the chain rule; Rodrigues' formula.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from infinivar.transmission.platform import crossed, rotation_matrix, rotation_vector

_STAGES, _TRIES = 8, 40
"""Poses between home and a goal through which joint angles are followed, and steps at the goal at most."""

_DAMPING = 1e-9
"""Of the steps towards a pose, over the square of the largest singular value."""

_FOUND = 1e-11
"""Error of a pose over the reach or a radian, at which it is found."""

_SINGULAR = 1e-6
"""Smallest singular value of a Jacobian over the largest, below which the pose is singular."""


class Standing(NamedTuple):
    """Where the joints of a chain are at m rows: n arrays each."""

    turn: list[np.ndarray]
    """Axes of the members behind the joints, as columns. (m, 3, 3)"""
    place: list[np.ndarray]
    """(m, 3) [m]"""
    axis: list[np.ndarray]
    """(m, 3)"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TurningChain:
    """Joints that turn, from the base to the tool."""

    names: tuple[str, ...]
    turns: np.ndarray
    """Axes of each joint at angle 0 in those of the member before, as columns. (n, 3, 3)"""
    places: np.ndarray
    """Of each joint in axes of the member before. (n, 3) [m]"""
    axes: np.ndarray
    """Of each joint, in its own axes. (n, 3)"""
    tool_turn: np.ndarray
    """Axes of the tool in those of the last member, as columns. (3, 3)"""
    tool_place: np.ndarray
    """(3,) [m]"""
    ranges: tuple[tuple[float, float] | None, ...]
    """Lowest and highest angle of each joint; None: unlimited. [rad]"""

    @property
    def reach(self) -> float:
        """Length of all members. [m]"""
        rows = [*self.places[1:], self.tool_place]
        return float(sum(np.linalg.norm(row) for row in rows)) or 1.0

    def standing(self, angles: np.ndarray) -> Standing:
        """The joints at angles (m, n)."""
        found = Standing([], [], [])
        for joint, (turn, place, axis) in enumerate(zip(self.turns, self.places, self.axes, strict=True)):
            along = np.outer(axis, axis)
            cosine, sine = np.cos(angles[:, joint])[:, None, None], np.sin(angles[:, joint])[:, None, None]
            own = turn @ along + cosine * (turn @ (np.eye(3) - along)) + sine * (turn @ _across(axis))
            if joint:
                place = found.place[-1] + np.matmul(found.turn[-1], place)
                own = np.matmul(found.turn[-1], own)
            found.turn.append(own)
            found.place.append(place + 0.0 * angles[:, :1])
            found.axis.append(np.matmul(own, axis))
        return found

    def tool(self, at: Standing) -> tuple[np.ndarray, np.ndarray]:
        """Place (m, 3) and axes (m, 3, 3) of the tool."""
        return at.place[-1] + np.matmul(at.turn[-1], self.tool_place), np.matmul(at.turn[-1], self.tool_turn)

    def jacobian(self, at: Standing) -> np.ndarray:
        """Of the tool's velocity and angular velocity by the joint rates. (m, 6, n)"""
        end, _ = self.tool(at)
        columns = [
            np.concatenate([crossed(axis, end - place), axis], axis=-1)
            for axis, place in zip(at.axis, at.place, strict=True)
        ]
        return np.stack(columns, axis=-1)

    def drift(self, at: Standing, rates: np.ndarray) -> np.ndarray:
        """Acceleration of the tool, and angular acceleration, without one of the joints, at rates (m, n). (m, 6)"""
        ends = [*at.place[1:], self.tool(at)[0]]
        turning = falling = found = 0.0 * at.place[0]
        for joint, (axis, place, end) in enumerate(zip(at.axis, at.place, ends, strict=True)):
            own = axis * rates[:, joint, None]
            falling, turning = falling + crossed(turning, own), turning + own
            found = found + swung(turning, falling, end - place)
        return np.concatenate([found, falling], axis=-1)

    def pose(self, angles: np.ndarray) -> np.ndarray:
        """Place and rotation vector of the tool at angles (n,). (6,) [m], [rad]"""
        place, turn = self.tool(self.standing(np.asarray(angles, dtype=float)[None]))
        return np.concatenate([place[0], rotation_vector(turn[0])])

    def angles(self, home: np.ndarray, pose: np.ndarray, rows: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Joint angles at which the tool is at poses, reached from home without passing a singular pose.

        Parameters
        ----------
        home : (n,) float      Joint angles. [rad]
        pose : (m, n) float    What is stated of place and rotation vector. [m], [rad]
        rows : n int           Which of the six these are; all three rotations, or none.

        Returns
        -------
        angles : (m, n) float    nan beyond reach. [rad]
        singular : (m,) float    Demand on the regularity of the Jacobian, 1 at singular poses. [-]

        Notes
        -----
        Of all solutions it is the one that a straight line from the pose at home leads to, so that neighbours have neighbouring
        angles. Source: Newton's method with damped steps.
        """
        goal, start = np.asarray(pose, dtype=float), self.pose(home)
        moves, turns = [row for row in rows if row < 3], any(row >= 3 for row in rows)
        way = goal[:, : len(moves)] - start[moves]
        first = rotation_matrix(start[None, 3:])
        turned = rotation_vector(rotation_matrix(goal[:, len(moves) :]) @ first.swapaxes(-1, -2)) if turns else None
        angles = np.repeat(np.asarray(home, dtype=float)[None], len(goal), axis=0)
        size = np.array([self.reach] * len(moves) + [1.0] * (len(rows) - len(moves)))
        error, jacobian = np.full(len(goal), np.inf), np.zeros((len(goal), len(rows), len(rows)))
        for count in range(1, _STAGES + _TRIES):
            share = min(count / _STAGES, 1.0)
            at = self.standing(angles)
            place, turn = self.tool(at)
            missing = [start[moves] + share * way - place[:, moves]]
            if turned is not None:
                missing.append(rotation_vector(rotation_matrix(share * turned) @ first @ turn.swapaxes(-1, -2)))
            off = np.concatenate(missing, axis=-1) / size
            jacobian = self.jacobian(at)[:, rows] / size[:, None]
            if share == 1.0:
                error = np.abs(off).max(axis=-1, initial=0.0)
                if count > _STAGES and np.all((error < _FOUND) | (np.abs(angles).max(axis=-1) > 1e3)):
                    break
            square = jacobian @ jacobian.swapaxes(-1, -2)
            damped = square + _DAMPING * np.trace(square, axis1=-2, axis2=-1)[:, None, None] * np.eye(len(rows))
            step = (jacobian.swapaxes(-1, -2) @ np.linalg.solve(damped, off[..., None]))[..., 0]
            largest = np.abs(step).max(axis=-1, keepdims=True, initial=0.0)
            angles = angles + step * np.minimum(1.0, 0.5 / np.maximum(largest, 1e-300))
        values = np.linalg.svd(jacobian, compute_uv=False)
        least = values[:, -1] / values[:, 0]
        found = (error < _FOUND)[:, None]
        return np.where(found, angles, np.nan), np.where(found[:, 0], _SINGULAR / np.maximum(least, 1e-300), np.inf)


def swung(turning: np.ndarray, falling: np.ndarray, lever: np.ndarray) -> np.ndarray:
    """Acceleration of a point beside another of the same body, by angular velocity and acceleration. (..., 3)"""
    return crossed(falling, lever) + crossed(turning, crossed(turning, lever))


def _across(axis: np.ndarray) -> np.ndarray:
    """Matrix of the cross product with an axis. (3, 3)"""
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
