r"""Surfaces of solids as triangle meshes: exact signed distance, with its sign from angle-weighted normals.

The closest point c of a mesh lies on a face, an edge or a vertex. With the normal of that face, or the sum of the
normals of all faces around the edge or vertex, each weighted with the angle of its corner there, ``(p - c) . n > 0``
tells that p is outside. The normal of a single one of those faces would give the wrong sign beside a sharp edge.

Source: baerentzen2005.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from infinivar import units
from infinivar._core import extras, files
from infinivar._core.array_namespace import Array
from infinivar._core.arrays import HoldsArrays, Whole, real_array, shown
from infinivar._core.fields import check, component
from infinivar._core.frozen import frozen
from infinivar.errors import InputError, ParameterError, require
from infinivar.motion.virtual.rows import placed
from infinivar.motion.virtual.surfaces import Side
from infinivar.motion.virtual.triangles import CORNERS, check_mesh, closest_on_triangles

_MOST_BYTES = 1_000_000_000
"""Largest file of a mesh."""

FORMATS = (".stl", ".obj", ".ply")
"""Endings of the files that `TriangleMesh.read` knows."""

_FREE = "Free side: outside a solid, or inside a cavity"

_ON = 1e-9
"""Distance over the extent of the mesh, below which a point lies on it and its normal is that of the feature there."""

_SPREAD = 2.0
"""Radius of a sphere around a part of a triangle, over the median of all triangles, up to which it is not divided."""

_MOST_SPHERES = 4
"""Spheres a triangle, on average, above which no more triangles are divided."""

_PAIRS = 1 << 18
"""Pairs of points and triangles held at a time."""


class SurfacePoint(NamedTuple):
    """The point of a surface that is closest to a point; for rows of points, rows."""

    distance: np.ndarray
    """Signed, > 0 on the free side. (...,) [m]"""
    point: np.ndarray
    """(..., 3) [m]"""
    normal: np.ndarray
    """Gradient of the distance, towards the free side. (..., 3)"""
    hessian: np.ndarray
    """Second derivatives of the distance. (..., 3, 3) [m^-1]"""


class _Signed(NamedTuple):
    """Points near a mesh, (n, ...)."""

    distance: np.ndarray
    """> 0 outside."""
    point: np.ndarray
    gradient: np.ndarray
    on: np.ndarray
    """Whether the normal is that of the mesh itself: on it, or where a face is closest."""
    face: np.ndarray
    feature: np.ndarray
    """As in `ClosestOnTriangle`."""


class _Tables(NamedTuple):
    """What follows from vertices and faces."""

    corner: np.ndarray
    sides: np.ndarray
    """From the first corner to the second and third. (m, 2, 3)"""
    normals: np.ndarray
    """Of the face, its sides and its corners, by feature. (m, 7, 3)"""
    edges: np.ndarray
    """Unit vectors along the sides. (m, 3, 3)"""
    tree: Any
    radii: np.ndarray
    """Of spheres around parts of triangles. (k,)"""
    owner: np.ndarray
    """The triangle of each. (k,)"""
    extent: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TriangleMesh(HoldsArrays):
    """A solid, or a cavity, bounded by triangles.

    Where several points of the mesh are equally close to a point, the gradient is that of one of them. Whether triangles
    cross each other is not checked: if they do, the sign near the crossing is wrong.

    Raises
    ------
    ParameterError
        If the mesh is not closed, triangles are degenerate or inside out, or a value is not finite; the message names
        the fault.
    """

    vertices: Array = component("Corners of the triangles, (n, 3) [m]")
    faces: Array = component("Three places in vertices a triangle, counter-clockwise from outside, (m, 3)")
    free: Side = component(_FREE, default="outside")
    _tables: _Tables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Validate the mesh and make its tables."""
        check(self)
        vertices = real_array("vertices", self.vertices)
        fits = vertices.ndim == 2 and vertices.shape[-1:] == (3,) and len(vertices) > 3
        require(fits, "vertices", f"shape {vertices.shape}", "of shape (n, 3), with four vertices or more")
        wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
        if len(wrong):
            raise ParameterError(
                f"vertices must be finite, got {len(wrong)} that are not, the first vertex {wrong[0]}: "
                f"{vertices[wrong[0]].tolist()}"
            )
        placed("vertices", vertices, 3)
        faces = _whole(self.faces, len(vertices))
        check_mesh(vertices, faces)
        object.__setattr__(self, "vertices", frozen(vertices))
        object.__setattr__(self, "faces", frozen(faces))
        object.__setattr__(self, "_tables", _tables(vertices, faces))

    @classmethod
    def read(cls, file: str | Path, *, unit: str, free: Side = "outside") -> Self:
        """Read a mesh from an STL, OBJ or PLY file; vertices at one place are merged.

        Parameters
        ----------
        file : str or Path
        unit : str   In which the numbers of the file are lengths, such as "mm": the formats do not state it.
        free : str   As the field.

        Raises
        ------
        InputError
            If trimesh is not installed, or the file cannot be read or is no closed mesh; the message names the file.
        """
        named = isinstance(file, (str, Path))
        require(named, "file", shown(file), "the path of an STL, OBJ or PLY file")
        path = Path(file)
        if path.suffix.lower() not in FORMATS:
            raise InputError(f"{str(path)!r} must be a mesh file that ends in {', '.join(FORMATS)}")
        require(isinstance(unit, str), "unit", shown(unit), "a unit of length, such as 'mm'")
        try:
            scale = units.parse(f"1 {unit}", "m", "1 mm")
        except InputError as problem:
            raise InputError(f"unit = {unit!r} {problem}") from None
        vertices, faces = _loaded(path)
        try:
            return cls(vertices=scale * vertices, faces=faces, free=free)
        except ParameterError as problem:
            raise InputError(f"{path}: {problem}") from None

    @property
    def dimension(self) -> int:
        """Always 3."""
        return 3

    @property
    def volume(self) -> float:
        """Of the solid, or the cavity. [m^3]"""
        corners = self.vertices[self.faces]
        return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0

    def distance(self, point: Array) -> np.ndarray:
        """Signed distance of points (..., 3), > 0 on the free side. (...,) [m]"""
        points = placed("point", point, 3)
        return (self._side * self._signed(points.reshape(-1, 3)).distance).reshape(points.shape[:-1])

    def normal(self, point: Array) -> np.ndarray:
        """Gradient of the distance: a unit vector towards the free side. (..., 3)"""
        points = placed("point", point, 3)
        return (self._side * self._signed(points.reshape(-1, 3)).gradient).reshape(points.shape)

    def hessian(self, point: Array) -> np.ndarray:
        """Second derivatives of the distance: zero where a face is closest, large near an edge or vertex. (..., 3, 3) [m^-1]"""
        return self.closest(point).hessian

    def closest(self, point: Array) -> SurfacePoint:
        """Distance, closest point, normal and second derivatives at once: in a loop quicker than one after the other.

        Parameters
        ----------
        point : (..., 3) float   [m]

        Raises
        ------
        ParameterError
            If a point has not three finite coordinates.

        Source: baerentzen2005 for the sign; distances from a plane, a line and a point for the second derivatives.
        """
        points = placed("point", point, 3)
        found, shape = self._signed(points.reshape(-1, 3)), points.shape[:-1]
        return SurfacePoint(
            (self._side * found.distance).reshape(shape),
            found.point.reshape(*shape, 3),
            (self._side * found.gradient).reshape(*shape, 3),
            (self._side * self._bend(found)).reshape(*shape, 3, 3),
        )

    @property
    def _side(self) -> float:
        return 1.0 if self.free == "outside" else -1.0

    def _signed(self, points: np.ndarray) -> _Signed:
        """Distances of points (n, 3), > 0 outside."""
        found, face, feature = self._nearest(points)
        gap = points - found
        far = np.sqrt(np.einsum("ij,ij->i", gap, gap))
        normal = self._tables.normals[face, feature]
        outside = np.where(np.einsum("ij,ij->i", gap, normal) >= 0.0, 1.0, -1.0)
        on = (far <= _ON * self._tables.extent) | (feature == 0)
        gradient = np.where(on[:, None], normal, gap * (outside / np.where(on, 1.0, far))[:, None])
        return _Signed(outside * far, found, gradient, on, face, feature)

    def _bend(self, found: _Signed) -> np.ndarray:
        """Second derivatives of the distance outside: those of a plane, of a line or of a point. (n, 3, 3)"""
        across = np.eye(3) - found.gradient[:, :, None] * found.gradient[:, None, :]
        edge = self._tables.edges[found.face, np.clip(found.feature - 1, 0, 2)]
        along = ((found.feature > 0) & (found.feature < 4)).astype(float)
        across = across - along[:, None, None] * edge[:, :, None] * edge[:, None, :]
        return across / np.where(found.on, np.inf, found.distance)[:, None, None]

    def _nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Closest points (n, 3), their triangles (n,), and what of them they lie on (n,)."""
        tables = self._tables
        upper, _ = tables.tree.query(points)
        reach = upper + tables.radii.max() + 1e-12 * tables.extent
        near = tables.tree.query_ball_point(points, reach, return_sorted=False)
        counts = np.fromiter((len(one) for one in near), int, len(points))
        parts = []
        low = 0
        while low < len(points):
            high = max(low + 1, int(np.searchsorted(np.cumsum(counts[low:]), _PAIRS, side="right")) + low)
            parts.append(self._among(points[low:high], near[low:high], counts[low:high], upper[low:high]))
            low = high
        found, face, feature = (
            (np.concatenate(column) for column in zip(*parts, strict=True)) if parts else (points, *_NONE)
        )
        return found, face, feature

    def _among(
        self, points: np.ndarray, near: np.ndarray, counts: np.ndarray, upper: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The closest of some spheres' triangles for each point, which is at most `upper` from the closest centre."""
        tables = self._tables
        row, ball = np.repeat(np.arange(len(points)), counts), np.concatenate([np.asarray(one, int) for one in near])
        gap = tables.tree.data[ball] - points[row]
        kept = np.sqrt(np.einsum("ij,ij->i", gap, gap)) - tables.radii[ball] <= upper[row] + 1e-12 * tables.extent
        row, face = row[kept], tables.owner[ball[kept]]
        sides = tables.sides[face]
        closest = closest_on_triangles(points[row], tables.corner[face], sides[:, 0], sides[:, 1])
        gap = points[row] - closest.point
        order = np.lexsort((np.einsum("ij,ij->i", gap, gap), row))
        best = order[np.searchsorted(row[order], np.arange(len(points)))]
        return closest.point[best], face[best], closest.feature[best]


_NONE = (np.zeros(0, int), np.zeros(0, int))


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshFile(Whole):
    """The surface of a solid, or a cavity, from a mesh file, as studies state it; see `TriangleMesh.read`.

    Raises
    ------
    InputError
        If trimesh is not installed, or the file cannot be read or is no closed mesh; the message names the file.
    """

    shape: ClassVar[str] = "mesh"
    file: str = component("STL, OBJ or PLY file, relative to the study's folder", compare=False)
    unit: str = component("Unit of length of the file's numbers, such as mm")
    free: Side = component(_FREE, default="outside")
    mesh: TriangleMesh = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Read the file."""
        check(self)
        object.__setattr__(self, "mesh", TriangleMesh.read(self.file, unit=self.unit, free=self.free))

    @property
    def dimension(self) -> int:
        """Always 3."""
        return 3

    def distance(self, point: Array) -> np.ndarray:
        """As `TriangleMesh.distance`. (...,) [m]"""
        return self.mesh.distance(point)

    def normal(self, point: Array) -> np.ndarray:
        """As `TriangleMesh.normal`. (..., 3)"""
        return self.mesh.normal(point)

    def hessian(self, point: Array) -> np.ndarray:
        """As `TriangleMesh.hessian`. (..., 3, 3) [m^-1]"""
        return self.mesh.hessian(point)


def _whole(faces: Array, count: int) -> np.ndarray:
    """Faces as integers; raises ParameterError if they are no places among the vertices."""
    given = real_array("faces", faces)
    fits = given.ndim == 2 and given.shape[-1:] == (3,) and len(given) > 3
    require(fits, "faces", f"shape {given.shape}", "of shape (m, 3), with four triangles or more")
    wrong = np.flatnonzero(~((given == np.floor(given)) & (given >= 0) & (given < count)).all(axis=1))
    if len(wrong):
        raise ParameterError(
            f"faces must hold whole numbers from 0 to {count - 1}, the places of {count} vertices, got face {wrong[0]}: "
            f"{shown(given[wrong[0]].tolist())}"
        )
    return given.astype(np.int64)


def _tables(vertices: np.ndarray, faces: np.ndarray) -> _Tables:
    from scipy.spatial import KDTree

    corners = vertices[faces]
    sides = corners[:, 1:] - corners[:, :1]
    normal = np.cross(sides[:, 0], sides[:, 1])
    normal /= np.sqrt(np.sum(normal**2, axis=1))[:, None]
    edges = corners[:, [1, 2, 0]] - corners
    edges /= np.sqrt(np.sum(edges**2, axis=2))[:, :, None]
    centres, radii, owner = _spheres(corners)
    return _Tables(
        corners[:, 0].copy(),
        sides,
        _normals(normal, edges, faces, len(vertices)),
        edges,
        KDTree(centres),
        radii,
        owner,
        float(np.max(np.ptp(vertices, axis=0))),
    )


def _normals(normal: np.ndarray, edges: np.ndarray, faces: np.ndarray, count: int) -> np.ndarray:
    """Normals of faces, of their sides and of their corners; at a corner weighted with its angle. (m, 7, 3)

    Source: baerentzen2005.
    """
    at_corner = np.zeros((count, 3))
    for place in range(3):
        cos = -np.einsum("ij,ij->i", edges[:, place], edges[:, place - 1])
        sin = np.sqrt(np.sum(np.cross(edges[:, place], edges[:, place - 1]) ** 2, axis=1))
        np.add.at(at_corner, faces[:, place], np.arctan2(sin, cos)[:, None] * normal)
    pairs = np.sort(np.concatenate([faces[:, pair] for pair in CORNERS]), axis=1)
    _, which = np.unique(pairs, axis=0, return_inverse=True)
    which = which.ravel()
    at_edge = np.zeros((int(which.max()) + 1, 3))
    np.add.at(at_edge, which, np.tile(normal, (3, 1)))
    every = np.concatenate(
        [normal[:, None], at_edge[which].reshape(3, len(faces), 3).transpose(1, 0, 2), at_corner[faces]], axis=1
    )
    size = np.sqrt(np.sum(every**2, axis=2, keepdims=True))
    # Two faces folded onto each other have no normal at their edge; any of the two will do.
    return np.where(size > 1e-12, every / np.where(size > 1e-12, size, 1.0), normal[:, None])


def _spheres(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Spheres that cover triangles, with their centres on them: large ones are divided, so that few reach far."""
    count = len(corners)
    owner = np.arange(count)
    centres, radii = _around(corners)
    limit = _SPREAD * float(np.median(radii))
    while len(corners) < _MOST_SPHERES * count + 256 and (radii > limit).any():
        large = radii > limit
        a, b, c = corners[large].transpose(1, 0, 2)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        quarters = [np.stack(one, axis=1) for one in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        owner = np.concatenate([*[owner[large]] * 4, owner[~large]])
        corners = np.concatenate([*quarters, corners[~large]])
        centres, radii = _around(corners)
    return centres, radii, owner


def _around(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    centres = corners.mean(axis=1)
    return centres, np.sqrt(np.max(np.sum((corners - centres[:, None]) ** 2, axis=2), axis=1))


def _loaded(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, without repeated ones, and faces of a file, as trimesh reads it."""
    content = files.read(path, _MOST_BYTES)
    trimesh = extras.load("trimesh", "robots", "a mesh from a file")
    try:
        kind = path.suffix[1:].lower()
        mesh = trimesh.load(io.BytesIO(content), file_type=kind, force="mesh", process=False)
        vertices, faces = np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64)
    except Exception as problem:  # readers of many formats, each with errors of its own
        said = str(problem).splitlines()
        raise InputError(
            f"cannot read the mesh file {str(path)!r}: {said[0] if said else type(problem).__name__}"
        ) from None
    if vertices.ndim != 2 or faces.ndim != 2 or not len(faces):
        raise InputError(f"cannot read the mesh file {str(path)!r}: it has no triangles")
    unique, place = np.unique(vertices, axis=0, return_inverse=True)
    return unique, place.ravel()[faces]
