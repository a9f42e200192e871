"""Triangles: the closest point on each, and faults of a mesh of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from infinivar.errors import ParameterError
from infinivar.motion.virtual.arc_length import coordinates

_THIN = 1e-12
"""Twice the area of a triangle over its longest side squared, below which it is degenerate."""

CORNERS = ((0, 1), (1, 2), (2, 0))
"""Corners at the ends of the sides of a triangle."""


class ClosestOnTriangle(NamedTuple):
    """The point of a triangle closest to a point, for n pairs of them."""

    point: np.ndarray
    """(n, 3) [m]"""
    feature: np.ndarray
    """What it lies on: 0 the face, 1 to 3 a side, between the corners `CORNERS`, 4 to 6 a corner. (n,)"""


def closest_on_triangles(points: np.ndarray, a: np.ndarray, ab: np.ndarray, ac: np.ndarray) -> ClosestOnTriangle:
    """Closest points on triangles with the corners a, b and c, by the region of the plane in which a point lies.

    Parameters
    ----------
    points, a : (n, 3) float    [m]
    ab, ac : (n, 3) float       From a to b and to c. [m]

    Source: ericson2005, section 5.1.5.
    """
    ap = points - a
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    ab_ab, ab_ac, ac_ac = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d3, d4 = d1 - ab_ab, d2 - ab_ac  # with p - b
    d5, d6 = d1 - ab_ac, d2 - ac_ac  # with p - c
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    at_a, at_b, at_c = (d1 <= 0.0) & (d2 <= 0.0), (d3 >= 0.0) & (d4 <= d3), (d6 >= 0.0) & (d5 <= d6)
    on_ab, on_ca = (vc <= 0.0) & (d1 >= 0.0) & (d3 <= 0.0), (vb <= 0.0) & (d2 >= 0.0) & (d6 <= 0.0)
    on_bc = (va <= 0.0) & (d4 - d3 >= 0.0) & (d5 - d6 >= 0.0)
    feature = np.zeros(len(points), dtype=int)
    for place, there in ((2, on_bc), (3, on_ca), (6, at_c), (1, on_ab), (5, at_b), (4, at_a)):  # the last one decides
        feature[there] = place
    along_bc = (d4 - d3) / np.where(on_bc, (d4 - d3) + (d5 - d6), 1.0)
    inner, on_1, on_2 = feature == 0, feature == 1, feature == 2
    whole = np.where(inner, va + vb + vc, 1.0)
    v = np.where(inner, vb / whole, np.where(on_1, d1 / ab_ab, np.where(on_2, 1.0 - along_bc, feature == 5)))
    w = np.where(inner, vc / whole, np.where(feature == 3, d2 / ac_ac, np.where(on_2, along_bc, feature == 6)))
    return ClosestOnTriangle(a + v[:, None] * ab + w[:, None] * ac, feature)


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", first, second)


def check_mesh(vertices: np.ndarray, faces: np.ndarray) -> None:
    """Raise ParameterError unless triangles bound a solid, with their normals outwards; the message names the fault.

    Whether they cross each other is not checked.

    Parameters
    ----------
    vertices : (n, 3) float   Finite. [m]
    faces : (m, 3) int        Corners of the triangles, counter-clockwise from outside.
    """
    corners = vertices[faces]
    sides = corners[:, [1, 2, 0]] - corners
    area = np.cross(sides[:, 0], -sides[:, 2])
    thin = np.flatnonzero(np.sqrt(np.sum(area**2, axis=1)) <= _THIN * np.max(np.sum(sides**2, axis=2), axis=1))
    if len(thin):
        raise ParameterError(
            f"faces must be triangles with an area, got {_some(len(thin), 'degenerate one')}, the first face {thin[0]} "
            f"with a corner at {coordinates(corners[thin[0], 0])}; remove them"
        )
    edges = np.concatenate([faces[:, pair] for pair in CORNERS])
    ordered = np.sort(edges, axis=1)
    both, which, count = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    rising = np.bincount(which.ravel(), weights=np.where(edges[:, 0] == ordered[:, 0], 1.0, -1.0), minlength=len(both))
    for wrong, what, help_ in (
        (count == 1, "open edge", "close the holes, or merge vertices that are the same"),
        (count > 2, "edge of more than two triangles", "make solids that touch separate meshes"),
        (
            (count == 2) & (rising != 0.0),
            "edge between triangles of opposite orientation",
            "orient all normals outwards",
        ),
    ):
        found = np.flatnonzero(wrong)
        if len(found):
            ends = " to ".join(coordinates(vertices[one]) for one in both[found[0]])
            raise ParameterError(
                f"the mesh must be closed, got {_some(len(found), what)}, the first from {ends}; {help_}"
            )
    middle = vertices.mean(axis=0)
    volume = float(np.einsum("ij,ij->", corners[:, 0] - middle, area)) / 6.0
    if volume <= 0.0:
        raise ParameterError(
            f"the mesh must have its normals outwards, got a volume of {volume:.4g} m^3; reverse the corners of every face"
        )


def _some(count: int, what: str) -> str:
    first, _, rest = what.partition(" ")
    if count == 1:
        return f"1 {what}"
    return f"{count} {first}s {rest}" if first == "edge" else f"{count} {what}s"
