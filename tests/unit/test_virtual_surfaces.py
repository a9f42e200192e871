"""Surfaces of virtual walls and meshes: against closed forms and differences; and messages."""

import math
import pickle
import sys
import time

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
import reference_meshes
from infinivar.motion import Ball, HalfSpace, Surfaces, TriangleMesh, Tube
from internals import FlatWalls, MeshFile, Surface

RNG = np.random.default_rng(5)
HALF = np.array([1.0, 2.0, 3.0])


def mesh(made, **options):
    vertices, faces = made
    return TriangleMesh(vertices=vertices, faces=faces, **options)


BOX = mesh(reference_meshes.box(HALF))
SPHERE = mesh(reference_meshes.sphere(0.1))
FLOOR, SIDE = HalfSpace(point=(0.0, 0.0), direction=(0.0, 2.0)), HalfSpace(point=(1.0, 0.0), direction=(-3.0, 0.0))
SURFACES = {
    "half-plane": HalfSpace(point=(0.1, 0.2), direction=(3.0, 4.0)),
    "half-space": HalfSpace(point=(0.1, 0.2, 0.3), direction=(1.0, 2.0, 2.0)),
    "disc": Ball(centre=(0.1, 0.2), radius=0.3),
    "hole": Ball(centre=(0.1, 0.2), radius=0.3, free="inside"),
    "ball": Ball(centre=(0.1, 0.2, -0.1), radius=0.3),
    "cavity": Ball(centre=(0.1, 0.2, -0.1), radius=0.3, free="inside"),
    "rod": Tube(point=(0.1, 0.2, -0.1), axis=(1.0, 1.0, 0.5), radius=0.3),
    "bore": Tube(point=(0.1, 0.2, -0.1), axis=(1.0, 1.0, 0.5), radius=0.3, free="inside"),
    "corner": Surfaces(surfaces=(FLOOR, SIDE)),
    "edge": FlatWalls(walls=(FLOOR, SIDE), free="any"),
    "box": BOX,
    "cavity in a mesh": mesh(reference_meshes.sphere(0.5, halvings=1), free="inside"),
}


@pytest.mark.parametrize("name", SURFACES)
def test_gradient_and_second_derivatives_are_those_of_the_distance(name):
    """Against central differences; points so close to a ridge that a difference straddles it are few and left out."""
    surface = SURFACES[name]
    d, step = surface.dimension, 1e-6
    points = RNG.uniform(-1.0, 1.0, (200, d)) * (3.0 if name == "box" else 1.0)
    shifts = step * np.eye(d)
    slope = np.stack(
        [(surface.distance(points + one) - surface.distance(points - one)) / (2 * step) for one in shifts], -1
    )
    bend = np.stack([(surface.normal(points + one) - surface.normal(points - one)) / (2 * step) for one in shifts], -1)
    normal, hessian = surface.normal(points), surface.hessian(points)
    wrong = (np.abs(slope - normal).max(-1) > 1e-7) | (
        np.abs(bend - hessian).max((-1, -2)) > 1e-5 * (1 + np.abs(hessian).max())
    )
    assert wrong.sum() <= 1
    assert_allclose(np.linalg.norm(normal, axis=-1), 1.0, rtol=1e-12)
    assert_allclose(hessian, np.swapaxes(hessian, -1, -2), atol=1e-12)
    assert_allclose(np.einsum("nij,nj->ni", hessian, normal), 0.0, atol=1e-9)
    assert isinstance(surface, Surface)
    for one in points[:5]:
        for what in ("distance", "normal", "hessian"):
            assert_allclose(getattr(surface, what)(one), getattr(surface, what)(one[None])[0], atol=1e-13)


def test_signed_distances_by_hand():
    assert SURFACES["half-plane"].distance([0.1 + 0.6, 0.2 + 0.8]) == pytest.approx(1.0)
    assert SURFACES["ball"].distance([0.1, 0.2, 0.4]) == pytest.approx(0.2)
    assert SURFACES["cavity"].distance([0.1, 0.2, 0.1]) == pytest.approx(0.1)
    assert_allclose(SURFACES["cavity"].normal([0.1, 0.2, 0.1]), [0.0, 0.0, -1.0])
    rod = Tube(point=(0.0, 0.0, 5.0), axis=(0.0, 0.0, 1.0), radius=0.5)
    assert rod.distance([3.0, 4.0, -7.0]) == pytest.approx(4.5)
    assert_allclose(rod.hessian([3.0, 4.0, -7.0]), np.array([[0.64, -0.48, 0], [-0.48, 0.36, 0], [0, 0, 0]]) / 5.0)


def test_centres_and_axes_have_a_normal():
    for surface, place in ((SURFACES["ball"], (0.1, 0.2, -0.1)), (SURFACES["rod"], (0.1, 0.2, -0.1))):
        assert surface.distance(place) == pytest.approx(-0.3)
        assert_allclose(np.linalg.norm(surface.normal(place)), 1.0)
        assert np.isfinite(surface.hessian(place)).all()


def test_walls_of_a_corner_that_count():
    """In a corner both walls hold; outside a block only the face, or at its edge two."""
    corner = SURFACES["corner"]
    assert corner.distance([0.3, 0.2]) == pytest.approx(0.2)
    assert corner.active([0.3, 0.2]) == ()
    assert [one.place for one in corner.active([0.95, 0.02], within=0.1)] == [0, 1]
    assert [one.place for one in corner.active([1.2, -0.1])] == [1, 0]
    assert corner.active([1.2, 0.5])[0].distance == pytest.approx(-0.2)
    assert_allclose(corner.active([1.2, 0.5])[0].normal, [-1.0, 0.0])
    edge = Surfaces(surfaces=(FLOOR, SIDE), free="any")
    assert [one.place for one in edge.active([1.5, -0.01], within=0.02)] == [0]
    assert [one.place for one in edge.active([1.01, -0.012], within=0.02)] == [1, 0]
    assert edge.active([0.5, -0.5], within=0.02) == ()
    assert edge.distance([1.5, 0.2]) == pytest.approx(0.2)


@pytest.mark.parametrize(("free", "sign"), [("inside", 1.0), ("outside", -1.0)])
def test_a_path_along_a_round_wall_turns_to_the_free_side_inside_it(free, sign):
    """Curvature of the path that keeps its distance, along the normal: ``-t^T H t``."""
    wall = Ball(centre=(0.0, 0.0), radius=0.25, free=free)
    across = np.array([0.0, 1.0])
    assert -across @ wall.hessian([0.25, 0.0]) @ across == pytest.approx(4.0 * sign)
    assert_allclose(FLOOR.hessian([0.25, 0.0]), 0.0)
    tube = Tube(point=(0, 0, 0), axis=(0, 0, 1), radius=0.25, free=free)
    slanting = np.array([0.0, 1.0, 1.0]) / math.sqrt(2.0)
    assert -slanting @ tube.hessian([0.25, 0, 0]) @ slanting == pytest.approx(2.0 * sign)


def test_distance_from_a_box_inside_outside_and_beside_its_edges():
    points = RNG.uniform(-5.0, 5.0, (3000, 3))
    assert_allclose(BOX.distance(points), reference_meshes.distance_from_box(points, HALF), atol=1e-13)
    assert BOX.volume == pytest.approx(48.0)
    near = np.array(
        [[1.0, 2.0, 3.0], [1.0, 2.0, 0.3], [1.0, 0.7, 0.2], [-1.0, -2.0, -3.0]]
    )  # vertex, edge, face, vertex
    for step in (1e-3, 1e-6):
        outwards = near + step * np.sign(near)
        inwards = near - step * np.sign(near)
        assert_allclose(BOX.distance(outwards), reference_meshes.distance_from_box(outwards, HALF), rtol=1e-6)
        assert_allclose(BOX.distance(inwards), reference_meshes.distance_from_box(inwards, HALF), rtol=1e-6)
    assert_allclose(BOX.distance(near), 0.0, atol=1e-15)
    on = BOX.normal(near)
    assert_allclose(on[0], np.ones(3) / math.sqrt(3.0), rtol=1e-12)  # three right angles weigh the same
    assert_allclose(on[1], [math.sqrt(0.5), math.sqrt(0.5), 0.0], atol=1e-12)
    assert_allclose(on[2], [1.0, 0.0, 0.0], atol=1e-12)
    assert_allclose(BOX.hessian([1.0, 0.7, 0.2]), 0.0)


def test_the_sign_beside_a_sharp_notch():
    """A slit cut deep into a block: beside its rim and its bottom the closest face alone would tell the wrong side."""
    outline = np.array([[-2, -2], [2, -2], [2, 2], [0.1, 2], [0, -1.5], [-0.1, 2], [-2, 2]], dtype=float)
    triangles = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (4, 5, 6), (0, 4, 6)]
    count = len(outline)
    low, high = (np.column_stack([outline, np.full(count, z)]) for z in (-1.0, 1.0))
    faces = [(c, b, a) for a, b, c in triangles] + [(a + count, b + count, c + count) for a, b, c in triangles]
    for one in range(count):
        two = (one + 1) % count
        faces += [(one, two, two + count), (one, two + count, one + count)]
    solid = TriangleMesh(vertices=np.concatenate([low, high]), faces=faces)
    points = np.column_stack([RNG.uniform(-2.5, 2.5, (4000, 2)), RNG.uniform(-0.1, 0.1, 4000)])
    points[:2000, :2] *= [0.05, 1.0]
    x, y = points[:, 0], points[:, 1]
    slit = (np.abs(x) < 0.1 * (y + 1.5) / 3.5) & (y > -1.5)
    inside = (np.abs(x) < 2.0) & (np.abs(y) < 2.0) & ~slit
    assert np.array_equal(solid.distance(points) < 0.0, inside)


def test_a_mesh_of_a_sphere_is_the_sphere_to_its_coarseness():
    """Chords of the triangles lie within the sphere: the error is between 0 and the largest sagitta."""
    points = RNG.uniform(-0.25, 0.25, (500, 3))
    exact = np.linalg.norm(points, axis=1) - 0.1
    error = SPHERE.distance(points) - exact
    assert error.min() > -1e-12
    assert error.max() < 5e-4
    assert np.array_equal(mesh(reference_meshes.sphere(0.1), free="inside").distance(points), -SPHERE.distance(points))


def test_few_large_triangles_beside_many_small_ones():
    """A thin long box whose one end is a fine sphere's size: large triangles are covered by several spheres."""
    vertices, faces = reference_meshes.sphere(0.05, halvings=2)
    raised = vertices + np.array([0.0, 0.0, 3.0])
    long, sides = reference_meshes.box((20.0, 0.3, 0.3))
    both = TriangleMesh(vertices=np.concatenate([raised, long]), faces=np.concatenate([faces, sides + len(vertices)]))
    points = RNG.uniform(-1.0, 1.0, (300, 3)) * [20.0, 1.0, 4.0]
    expected = np.minimum(
        reference_meshes.distance_from_box(points, (20.0, 0.3, 0.3)), mesh((raised, faces)).distance(points)
    )
    assert_allclose(both.distance(points), expected, atol=1e-12)


def test_a_mesh_of_thousands_of_triangles_serves_a_fast_loop():
    """About 0.2 ms a query near the surface of 5120 triangles; the bound leaves room for slow machines."""
    fine = mesh(reference_meshes.sphere(0.1, halvings=4))
    assert len(fine.faces) == 5120
    spent = []
    for one in RNG.normal(size=(40, 3)):
        point = one / np.linalg.norm(one) * 0.099
        start = time.perf_counter()
        fine.closest(point)
        spent.append(time.perf_counter() - start)
    assert np.median(spent) < 3e-3


def test_surfaces_are_values():
    for surface in (SURFACES["ball"], SURFACES["rod"], SURFACES["half-plane"], SURFACES["corner"], BOX):
        copy = pickle.loads(pickle.dumps(surface))
        assert copy == surface
        assert hash(copy) == hash(surface)
        point = np.full(surface.dimension, 0.3)
        assert_allclose(copy.distance(point), surface.distance(point), atol=0.0)
    assert Ball(centre=(0.0, 0.0), radius=1.0) != Ball(centre=(0.0, 0.0), radius=2.0)
    with pytest.raises(ValueError, match="read-only"):
        BOX.vertices[0, 0] = 3.0
    assert BOX.distance(np.zeros((0, 3))).shape == (0,)


# ---- files


@pytest.mark.parametrize("ending", ["stl", "ply", "obj"])
def test_meshes_from_files(tmp_path, ending):
    """In the units that the caller states; repeated vertices of STL files are merged."""
    trimesh = pytest.importorskip("trimesh", reason="the extra infinivar[robots] has it")
    vertices, faces = reference_meshes.box((10.0, 20.0, 30.0))
    file = tmp_path / f"block.{ending}"
    trimesh.Trimesh(vertices, faces, process=False).export(file)
    read = TriangleMesh.read(file, unit="mm")
    assert len(read.vertices) == 8
    points = RNG.uniform(-0.04, 0.04, (50, 3))
    assert_allclose(read.distance(points), reference_meshes.distance_from_box(points, (0.01, 0.02, 0.03)), atol=1e-9)
    kept = MeshFile(file=str(file), unit="mm", free="inside")
    assert_allclose(kept.distance(points), -read.distance(points))
    assert_allclose(kept.normal(points), -read.normal(points))
    assert_allclose(kept.hessian(points), -read.hessian(points))
    assert isinstance(kept, Surface)
    trimesh.Trimesh(vertices, faces[1:], process=False).export(file)
    with pytest.raises(
        iv.InputError, match=rf"block.{ending}: the mesh must be closed, got 3 open edges, the first from"
    ):
        TriangleMesh.read(file, unit="mm")
    file.write_bytes(b"no mesh at all")
    with pytest.raises(iv.InputError, match=f"cannot read the mesh file '.*block.{ending}'"):
        TriangleMesh.read(file, unit="mm")


def test_messages_about_files(tmp_path, monkeypatch):
    with pytest.raises(iv.InputError, match=r"must be a mesh file that ends in .stl, .obj, .ply"):
        TriangleMesh.read("hand.step", unit="mm")
    with pytest.raises(iv.InputError, match="unit = 'hectares'"):
        TriangleMesh.read("hand.stl", unit="hectares")
    with pytest.raises(iv.InputError, match="unit = 's'"):
        TriangleMesh.read("hand.stl", unit="s")
    with pytest.raises(iv.InputError, match="file must be the path of an STL, OBJ or PLY file"):
        TriangleMesh.read(3, unit="mm")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(iv.InputError, match="no such file"):
        TriangleMesh.read(tmp_path / "hand.stl", unit="mm")
    (tmp_path / "hand.stl").touch()
    with pytest.raises(iv.InputError, match=r"needs trimesh; install it with: pip install 'infinivar\[robots\]'"):
        TriangleMesh.read(tmp_path / "hand.stl", unit="mm")


# ---- messages

V, F = reference_meshes.box(HALF)


def bad(faces=F, vertices=V, **options):
    return lambda: TriangleMesh(vertices=vertices, faces=faces, **options)


def with_nan():
    wrong = V.copy()
    wrong[3, 1] = math.nan
    return wrong


class NoHessian:
    dimension = 2

    def distance(self, point):
        return 0.0

    def normal(self, point):
        return 0.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (bad(faces=F[1:]), r"must be closed, got 3 open edges, the first from \(-1, -2, -3\) m to"),
        (bad(faces=F[3:]), r"must be closed, got \d+ open edges"),
        (bad(faces=np.concatenate([F, F[:1]])), "3 edges of more than two triangles"),
        (bad(faces=np.concatenate([F[1:], F[:1, ::-1]])), "3 edges between triangles of opposite orientation"),
        (bad(faces=F[:, ::-1]), r"must have its normals outwards, got a volume of -48 m\^3"),
        (
            bad(faces=np.concatenate([F, [[0, 1, 1]]])),
            "must be triangles with an area, got 1 degenerate one, the first face 12",
        ),
        (
            bad(faces=np.concatenate([F[1:], [[0, 1, 8]]])),
            "whole numbers from 0 to 7, the places of 8 vertices, got face 11",
        ),
        (bad(faces=F + 0.5), "faces must hold whole numbers"),
        (bad(faces=F[:2]), "four triangles or more"),
        (bad(faces="all"), "faces must be a real number or an array"),
        (bad(vertices=with_nan()), r"vertices must be finite, got 1 that are not, the first vertex 3"),
        (bad(vertices=V[:, :2]), r"vertices must be of shape \(n, 3\)"),
        (bad(free="up"), "free must be one of outside, inside, got 'up'"),
        (lambda: HalfSpace(point=(0.0, 0.0), direction=(0.0, 0.0)), "direction must be a direction, not zero"),
        (lambda: HalfSpace(point=(0.0, 0.0), direction=(0.0, 0.0, 1.0)), "direction must be points of 2 coordinates"),
        (
            lambda: HalfSpace(point=(0.0,) * 4, direction=(1.0,) * 4),
            "point must be a point of one to three coordinates",
        ),
        (lambda: Ball(centre=(0.0,), radius=1.0), "centre must be a point of two or three coordinates"),
        (lambda: Ball(centre=(0.0, 0.0), radius=-1.0), r"radius must be >= 1e-09 and <= 1e\+09 m, got -1"),
        (lambda: Ball(centre=(0.0, math.nan), radius=1.0), r"centre\[1\] must be finite m, got nan"),
        (lambda: Ball(centre=(0.0, 0.0), radius=1.0, free="out"), "free must be one of outside, inside, got 'out'"),
        (lambda: Tube(point=(0.0, 0.0), axis=(0.0, 1.0), radius=1.0), "point must be points of 3 coordinates"),
        (lambda: Surfaces(surfaces=()), "surfaces must be one surface or more"),
        (lambda: Surfaces(surfaces=(FLOOR, BOX)), "surfaces 2 must be in 2 dimensions, as surfaces 1"),
        (lambda: Surfaces(surfaces=(FLOOR, 3)), "surfaces 2 must be a surface, such as a HalfSpace"),
        (lambda: Surfaces(surfaces=(FLOOR, NoHessian())), "a NoHessian has no hessian"),
        (lambda: FlatWalls(walls=(FLOOR, SURFACES["disc"])), "walls 2 must be a HalfSpace"),
        (lambda: SURFACES["corner"].active([0.0, 0.0], within=-1.0), "within must be >= 0 m"),
        (lambda: SURFACES["corner"].active([[0.0, 0.0]]), "point must be one point of 2 coordinates"),
        (lambda: BOX.distance([0.0, 0.0]), "point must be points of 3 coordinates"),
        (lambda: BOX.distance([0.0, 0.0, 1e200]), r"point must be within 1e\+09 m of the origin"),
        (bad(vertices=V * 1e200), r"vertices must be within 1e\+09 m of the origin"),
        (lambda: BOX.distance([0.0, 0.0, math.inf]), "point must be finite"),
    ],
)
def test_one_clear_message(make, message):
    with pytest.raises(iv.InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
