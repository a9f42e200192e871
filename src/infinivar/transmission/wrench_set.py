r"""Wrenches that legs can hold: the zonotope ``J^T [-F, F]^n`` of the largest forces F of the links, cut by other limits.

Source: mcmullen1971 for zonotopes; their facets by the null vectors of all sets of d - 1 generators.
"""

from __future__ import annotations

import itertools

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import real_array
from infinivar._core.fields import check_instance
from infinivar._core.result import Result, result
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit
from infinivar.transmission.configuration import Configuration

_FLAT = 1e-9
"""Relative size of a generator's component along a normal that counts as zero."""

_MOST_LINKS = 16


@result
class WrenchSet(Result):
    """A convex set of wrenches about the origin: all W of which no product with a normal is above its bound.

    Attributes
    ----------
    generators : (d, n) float   Wrench of the largest force of each link.
    normals : (m, d) float      Of the facets, outward; components in fixed units (N, N m).
    bounds : (m,) float         > 0, or 0 on a facet through the origin.
    limits : (m,) int           `Limit` beyond each facet.
    """

    generators: Array
    normals: Array
    bounds: Array
    limits: Array

    @classmethod
    def of(cls, configuration: Configuration, link_force: Array) -> WrenchSet:
        """The zonotope of one pose.

        Parameters
        ----------
        configuration : Configuration      One pose, within reach and not singular.
        link_force : float or (n,) float   Largest force of the links, such as mu P or `Legs.force_limits`, > 0. [N]

        Returns
        -------
        WrenchSet   With two facets for each set of d - 1 independent generators.

        Raises
        ------
        ParameterError
            If many poses are given, a force is not > 0, or the pose is singular or out of reach.
        """
        check_instance("configuration", configuration, Configuration)
        jacobian = np.asarray(configuration.jacobian)
        require(jacobian.ndim == 2, "configuration", f"{jacobian.shape[:-2]} poses", "one pose")
        force = real_array("link_force", link_force)
        require(bool(np.all(force > 0) and np.all(np.isfinite(force))), "link_force", force, "> 0", "N")
        require(
            force.shape in ((), (configuration.links,)),
            "link_force",
            f"shape {force.shape}",
            "one number, or one a link",
        )
        require(
            configuration.links <= _MOST_LINKS,
            "configuration",
            f"{configuration.links} links",
            f"of at most {_MOST_LINKS}",
        )
        d = configuration.freedoms
        singular = ParameterError(
            "configuration must be a regular pose within reach, got one whose links hold no full wrench"
        )
        if not np.all(np.isfinite(jacobian)):
            raise singular
        generators = jacobian.T * force
        # Rows of forces and moments differ in units; scaled alike, ranks mean something.
        size = np.max(np.abs(generators), axis=1)
        if np.any(size == 0) or np.linalg.matrix_rank(generators / size[:, None], tol=_FLAT) < d:
            raise singular
        normals = _normals(generators / size[:, None]) / size[:, None].T
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        bounds = np.sum(np.abs(normals @ generators), axis=1)
        return cls(
            generators=generators,
            normals=np.vstack([normals, -normals]),
            bounds=np.concatenate([bounds, bounds]),
            limits=np.full(2 * len(bounds), int(Limit.SLIP)),
        )

    def cut(self, normal: Array, bound: float, limit: Limit = Limit.THERMAL) -> WrenchSet:
        """The set with a further limit ``normal . W <= bound``, such as a power, for which the normal is ``-xi``.

        Parameters
        ----------
        normal : (d,) float   Not zero.
        bound : float         >= 0: without a wrench the limit must be kept.
        limit : Limit         What it is; by default the continuous torque of the motor.

        Raises
        ------
        ParameterError
            If the normal is zero or of another shape, or the bound is negative.
        """
        along = real_array("normal", normal)
        length = float(np.linalg.norm(along)) if along.shape == self.normals.shape[1:] else 0.0
        require(0.0 < length < np.inf, "normal", normal, f"{self.normals.shape[1]} finite numbers, not all 0")
        room = real_array("bound", bound)
        fits = room.ndim == 0 and bool(0.0 <= room < np.inf)
        require(fits, "bound", bound, ">= 0 and finite, as the set must contain the wrench 0")
        return WrenchSet(
            generators=self.generators,
            normals=np.vstack([self.normals, along / length]),
            bounds=np.append(self.bounds, bound / length),
            limits=np.append(self.limits, int(limit)),
        )

    def largest(self, direction: Array) -> np.ndarray:
        """Largest multiple of a wrench in the set.

        Parameters
        ----------
        direction : (..., d) float   A wrench, such as 1 N along x without a moment.

        Returns
        -------
        (...,) float   For a zonotope of as many links as components, F of equal links: ``F/max|J^-T d|``. [-]

        Raises
        ------
        ParameterError
            If the direction is zero, not finite or of another shape.
        """
        required = self._vector("direction", direction)
        require(bool(np.all(np.any(required != 0, axis=-1))), "direction", "0", "a wrench that is not 0")
        along = required @ self.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.min(np.where(along > 0, self.bounds / np.where(along > 0, along, 1.0), np.inf), axis=-1)

    def contains(self, wrench: Array, slack: float = 1e-9) -> np.ndarray:
        """Whether wrenches (..., d) are in the set, within a share `slack` of each bound."""
        return np.all(self._vector("wrench", wrench) @ self.normals.T <= self.bounds * (1.0 + slack), axis=-1)

    def _vector(self, name: str, value: Array) -> np.ndarray:
        """Wrenches (..., d); ParameterError if they are no such finite numbers."""
        given, d = real_array(name, value), self.normals.shape[1]
        require(given.shape[-1:] == (d,), name, f"shape {given.shape}", f"of shape (..., {d})")
        require(bool(np.all(np.isfinite(given))), name, "nan or inf", "finite")
        return given

    def vertices(self) -> np.ndarray:
        """Corners of the set, (v, d): for an uncut one of as many links as components, one for each combination of signs."""
        d, n = self.generators.shape
        if d == n and len(self.bounds) == 2 * n:
            return np.array(list(itertools.product((-1.0, 1.0), repeat=n))) @ self.generators.T
        return _corners(self.normals, self.bounds, np.max(np.abs(self.generators), axis=1))


def _normals(generators: np.ndarray) -> np.ndarray:
    """A unit null vector for each set of d - 1 independent generators (d, n), each facet once: (m, d)."""
    d, n = generators.shape
    if d == 1:
        return np.ones((1, 1))
    found: list[np.ndarray] = []
    for chosen in itertools.combinations(range(n), d - 1):
        _, size, rows = np.linalg.svd(generators[:, chosen].T)
        if size[-1] <= _FLAT * size[0]:
            continue
        normal = rows[-1]
        if not any(abs(abs(float(normal @ other)) - 1.0) < _FLAT for other in found):
            found.append(normal)
    return np.array(found)


def _corners(normals: np.ndarray, bounds: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Corners of ``normals . W <= bounds``, computed in units in which all components are alike."""
    from scipy.spatial import HalfspaceIntersection

    scaled = normals * size
    length = np.linalg.norm(scaled, axis=1)
    planes = np.column_stack([scaled / length[:, None], -bounds / length])
    corners = HalfspaceIntersection(planes, _inner(planes)).intersections
    corners = corners[np.all(np.isfinite(corners), axis=1)]
    return np.unique(np.round(corners, 10), axis=0) * size


def _inner(planes: np.ndarray) -> np.ndarray:
    """Centre of the largest ball within planes, whose normals have length 1."""
    from scipy.optimize import linprog

    d = planes.shape[1] - 1
    cost = np.append(np.zeros(d), -1.0)
    above = np.column_stack([planes[:, :-1], np.ones(len(planes))])
    found = linprog(cost, A_ub=above, b_ub=-planes[:, -1], bounds=[(None, None)] * d + [(0.0, None)])
    return found.x[:d]
