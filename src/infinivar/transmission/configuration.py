"""Where a machine of links stands: the kinematic map from its twist to the speeds of its links, and what of it is in reach."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import field

import numpy as np

from infinivar._core.array_namespace import Array, check_broadcast
from infinivar._core.arrays import real_array, shown
from infinivar._core.result import Result, result
from infinivar.errors import ParameterError, require
from infinivar.limits import Limit

_ROUNDING = 1e-12
"""Speed over the largest of its kind that is rounding. [-]"""


def without_rounding(speeds: np.ndarray) -> np.ndarray:
    """Speeds (..., n) of one kind, exactly 0 where they are rounding beside the largest: what stands has no friction to pay."""
    size = np.abs(speeds)
    return np.where(size <= _ROUNDING * size.max(axis=-1, keepdims=True), 0.0, speeds)


@result
class Configuration(Result):
    """A machine of n links at one pose, or at many; NumPy arrays.

    Attributes
    ----------
    jacobian : (..., n, d) float         J: link speeds ``ldot = J xi`` of a twist xi of d <= n components.
    link_position : (..., n) float       Of each link along its guideway; 0 if not given. [m]
    utilisation : Limit to (...) float   Demand over allowance of the kinematics, such as reach and travel. Beyond reach the
        jacobian is nan. [-]

    Raises
    ------
    ParameterError
        If the jacobian has more columns than rows: links that cannot hold a wrench.
    """

    jacobian: Array
    link_position: Array = 0.0
    utilisation: Mapping[Limit, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Validate the fields and lock them."""
        jacobian = real_array("jacobian", self.jacobian)
        shape = jacobian.shape
        require(
            jacobian.ndim >= 2 and 0 < shape[-1] <= shape[-2],
            "jacobian",
            f"shape {shape}",
            "of shape (..., links, components), with at least as many links as components",
        )
        object.__setattr__(self, "jacobian", jacobian)
        known = {"link_position": (self.link_position, shape[:-1])}
        if not isinstance(self.utilisation, Mapping):
            raise ParameterError(f"utilisation must be a mapping of Limit, got {shown(self.utilisation)}")
        for limit, demand in self.utilisation.items():
            require(isinstance(limit, Limit), "utilisation", f"a demand of {limit!r}", "a mapping of Limit")
            known[f"utilisation of {limit.name}"] = demand, shape[:-2]
        for name, (value, required) in known.items():
            given = real_array(name, value).shape
            fits = len(given) <= len(required) and check_broadcast(**{name: given, "jacobian": required}) == required
            require(fits, name, f"shape {given}", f"one number, or of shape {required}")
        Result.__post_init__(self)

    @property
    def links(self) -> int:
        """Number of links, n."""
        return self.jacobian.shape[-2]

    @property
    def freedoms(self) -> int:
        """Number of components of the twist, d."""
        return self.jacobian.shape[-1]

    def vector(self, value: Array, name: str) -> np.ndarray:
        """A twist or wrench as an array (..., d).

        Raises
        ------
        ParameterError
            If its last axis is not d long, a value is not finite, or the shape does not fit the poses.
        """
        given = real_array(name, value)
        fits = given.ndim > 0 and given.shape[-1] == self.freedoms
        require(
            fits, name, f"shape {given.shape}", f"of shape (..., {self.freedoms}), as many as the jacobian has columns"
        )
        require(bool(np.all(np.isfinite(given))), name, "nan or inf", "finite")
        check_broadcast(**{"configuration": self.jacobian.shape[:-2], name: given.shape[:-1]})
        return given

    def link_speeds(self, twist: Array) -> np.ndarray:
        """``J xi``; exactly 0 where it is that but for rounding, as a drive that stands spends less than one that creeps.

        Parameters
        ----------
        twist : (..., d) float   xi.

        Returns
        -------
        (..., n) float   [m s^-1]
        """
        return without_rounding(np.matmul(self.jacobian, self.vector(twist, "twist")[..., None])[..., 0])

    def link_forces(self, wrench: Array) -> np.ndarray:
        """Forces of the links on the machine with which it exerts a wrench on its load: ``J^T f = W``.

        Parameters
        ----------
        wrench : (..., d) float   W, which the machine applies to its load: ``W xi`` is the power to the load.

        Returns
        -------
        (..., n) float   With more links than components, those of the smallest sum of squares. At singular poses inf. [N]

        Source: principle of virtual power.
        """
        required = self.vector(wrench, "wrench")
        if self.links == self.freedoms:
            return solved(np.swapaxes(self.jacobian, -1, -2), required)
        return np.matmul(self.jacobian, solved(self.squared(), required)[..., None])[..., 0]

    def twist_of(self, link_speeds: Array) -> np.ndarray:
        """Twist of a machine with as many links as components, from its link speeds. (..., d)

        Raises
        ------
        ParameterError
            If there are more links, whose speeds are not independent, or there is not one speed for each link.
        """
        if self.links != self.freedoms:
            raise ParameterError(
                f"the speeds of {self.links} links of a machine with {self.freedoms} components of twist are not independent"
            )
        speeds = real_array("link_speeds", link_speeds)
        fits = speeds.shape[-1:] == (self.links,)
        require(fits, "link_speeds", f"shape {speeds.shape}", f"of shape (..., {self.links}), one for each link")
        check_broadcast(configuration=self.jacobian.shape[:-2], link_speeds=speeds.shape[:-1])
        return solved(self.jacobian, speeds)

    def squared(self) -> np.ndarray:
        """``J^T J``. (..., d, d)"""
        return np.matmul(np.swapaxes(self.jacobian, -1, -2), self.jacobian)

    def at(self, place: slice) -> Configuration:
        """Some of many poses, along the first axis."""
        kept = np.broadcast_to(self.link_position, self.jacobian.shape[:-1])[place]
        demands = {
            limit: np.broadcast_to(demand, self.jacobian.shape[:-2])[place]
            for limit, demand in self.utilisation.items()
        }
        return Configuration(jacobian=self.jacobian[place], link_position=kept, utilisation=demands)


def solved(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Solution of square systems; inf where a matrix is singular to rounding, nan where it is nan."""
    shape = np.broadcast_shapes(matrix.shape[:-1], vector.shape)
    try:
        found = np.linalg.solve(matrix, vector[..., None])[..., 0]
    except np.linalg.LinAlgError:
        with np.errstate(invalid="ignore"):
            sound: np.ndarray = np.asarray(np.linalg.det(matrix) != 0.0)
        regular = np.where(sound[..., None, None], matrix, np.eye(matrix.shape[-1]))
        found = np.where(sound[..., None], np.linalg.solve(regular, vector[..., None])[..., 0], np.inf)
    return np.broadcast_to(found, shape)


def over_links(operation: np.ufunc, values: np.ndarray) -> np.ndarray:
    """An operation such as `np.add` over the last axis; for a few links several times faster than its `reduce`."""
    return functools.reduce(operation, (values[..., place] for place in range(values.shape[-1])))
