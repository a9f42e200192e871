"""Virtual constraints in random places: closest points, signed distances and projections."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import reference_meshes
from constraints import constrained_motion, free_projection
from infinivar.motion import (
    AboutAxis,
    AboutPoint,
    AlongLine,
    Ball,
    HalfSpace,
    InPlane,
    PointCurve,
    Surfaces,
    TriangleMesh,
    Tube,
)
from internals import closest_on_triangles, free_basis

SPACE = ("x", "y", "z", "rx", "ry", "rz")
seeds = st.integers(0, 2**32 - 1)
lengths = st.floats(0.01, 10.0)


@given(seeds, st.integers(2, 3), st.booleans())
def test_no_point_of_a_spline_is_closer_than_the_closest(seed, d, closed):
    """Against a dense row of its points: the closest is at least as close, and the gap is across the tangent."""
    random = np.random.default_rng(seed)
    u = np.linspace(0.0, 2.0 * math.pi, 30)[: 29 if closed else 30]
    parts = [
        sum(random.normal() / (k + 1) ** 2 * np.sin((k + 1) * u + random.uniform(0, 7)) for k in range(3))
        for _ in range(d)
    ]
    parts[0] = parts[0] + 3.0 * np.sin(u)
    parts[1] = parts[1] + 3.0 * np.cos(u)
    curve = PointCurve.through(np.array(parts).T, closed=closed)
    dense = curve.at(np.linspace(0.0, curve.length, 4001))[0]
    points = random.normal(size=(20, d)) * 3.0
    found = curve.nearest(points)
    far = np.linalg.norm(points - found.point, axis=1)
    brute = np.array([np.sqrt(np.min(np.sum((dense - one) ** 2, axis=1))) for one in points])
    assert np.all(far <= brute + 1e-9)
    # The dense points are 1/4000 of the length apart: the closest of them is at most half of that too far.
    assert np.all(far >= brute - curve.length / 8000 * 1.001)
    across = np.sum((points - found.point) * found.tangent, axis=1) - found.beyond
    assert_allclose(across, 0.0, atol=1e-9)
    assert_allclose(np.abs(found.offset), np.sqrt(np.maximum(far**2 - np.asarray(found.beyond) ** 2, 0.0)), atol=1e-8)
    for one, place in zip(points[:4], found.arc_length[:4], strict=True):
        single = curve.nearest(one)
        assert np.linalg.norm(one - single.point) == pytest.approx(np.linalg.norm(one - curve.at(place)[0]), abs=1e-9)


def ellipse(a, b):
    """Half axes along x and y, through so many points that the curve between them matters little."""
    around = np.arange(3000) * 2.0 * math.pi / 3000
    return PointCurve.through(np.stack([a * np.cos(around), b * np.sin(around)], axis=1), closed=True)


@pytest.mark.slow
@given(lengths, lengths, st.floats(0.0, 6.0))
def test_an_ellipse_of_any_shape(a, b, angle):
    """Closed forms of tangent and curvature; a point near on the normal comes back to its foot."""
    assume(0.1 < a / b < 10.0)
    curve = ellipse(a, b)
    foot = np.array([a * math.cos(angle), b * math.sin(angle)])
    slope = np.array([-a * math.sin(angle), b * math.cos(angle)])
    speed = float(np.hypot(*slope))
    curvature = a * b / speed**3
    normal = np.array([-slope[1], slope[0]]) / speed
    offset = 0.3 * min(a, b) ** 2 / max(a, b)
    found = curve.nearest(foot + offset * normal)
    assert_allclose(found.point, foot, atol=1e-7 * max(a, b))
    assert_allclose(found.offset, offset, rtol=1e-6)
    assert_allclose(found.tangent, slope / speed, atol=1e-5)
    assert_allclose(found.curvature, curvature, rtol=1e-3, atol=1e-3 / max(a, b))


@pytest.mark.slow
@given(seeds)
def test_following_a_motion_finds_what_the_search_finds(seed):
    """A point that moves along beside an ellipse, within its radius of curvature: from one sample to the next, as over all."""
    random = np.random.default_rng(seed)
    curve = ellipse(2.0, 1.0)
    there = random.uniform(0.0, curve.length)
    offset = random.uniform(-0.4, 0.4)
    for _ in range(20):
        moved = there + random.uniform(-0.2, 0.2)
        point, tangent, _ = curve.at(moved)
        found = curve.nearest(point + offset * np.array([-tangent[1], tangent[0]]), near=there)
        gap = (found.arc_length - moved + 0.5 * curve.length) % curve.length - 0.5 * curve.length
        assert abs(gap) < 1e-7
        assert found.offset == pytest.approx(offset, abs=1e-8)
        there = found.arc_length


@given(seeds, lengths, st.sampled_from(["outside", "inside"]))
def test_from_any_point_the_distance_along_the_normal_leads_to_the_surface(seed, radius, free):
    random = np.random.default_rng(seed)
    centre, axis = random.normal(size=3), random.normal(size=3)
    surfaces = (
        HalfSpace(point=tuple(centre), direction=tuple(axis)),
        Ball(centre=tuple(centre), radius=radius, free=free),
        Tube(point=tuple(centre), axis=tuple(axis), radius=radius, free=free),
    )
    points = random.normal(size=(10, 3)) * 5.0
    for surface in surfaces:
        foot = points - surface.distance(points)[:, None] * surface.normal(points)
        assert_allclose(surface.distance(foot), 0.0, atol=1e-12 * (10.0 + radius))
        # Newton's second order: the distance at a step is that of its expansion, to the third order.
        step = 1e-4 * random.normal(size=(10, 3))
        expansion = (
            surface.distance(points)
            + np.einsum("ni,ni->n", surface.normal(points), step)
            + 0.5 * np.einsum("ni,nij,nj->n", step, surface.hessian(points), step)
        )
        near = np.abs(surface.distance(points)) < 0.5 * radius
        assert_allclose(surface.distance(points + step)[near], expansion[near], atol=1e-9 / min(radius, 1.0) ** 2)
    both, either = Surfaces(surfaces=surfaces), Surfaces(surfaces=surfaces, free="any")
    every = np.array([one.distance(points) for one in surfaces])
    assert_allclose(both.distance(points), every.min(axis=0))
    assert_allclose(either.distance(points), every.max(axis=0))


@given(seeds, st.floats(0.1, 10.0), st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_distances_from_boxes_turned_in_any_way(seed, a, b, c):
    random = np.random.default_rng(seed)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    half, shift = np.array([a, b, c]), random.normal(size=3)
    vertices, faces = reference_meshes.box(half)
    mesh = TriangleMesh(vertices=vertices @ turn.T + shift, faces=faces[random.permutation(12)])
    points = random.uniform(-1.5, 1.5, (60, 3)) * half
    points[:20] = np.sign(points[:20]) * half * (1.0 + 1e-3 * random.normal(size=(20, 3)))  # beside the vertices
    points[20:30, 0] = a * (1.0 + 1e-6 * random.normal(size=10))  # beside faces and edges
    distance, normal = mesh.distance(points @ turn.T + shift), mesh.normal(points @ turn.T + shift)
    assert_allclose(distance, reference_meshes.distance_from_box(points, half), atol=1e-12 * half.max())
    assert mesh.volume == pytest.approx(8.0 * a * b * c)
    foot = points @ turn.T + shift - distance[:, None] * normal
    assert_allclose(mesh.distance(foot), 0.0, atol=1e-8 * half.max())


def directions(random):
    return tuple(random.normal(size=3))


KINDS = {
    1: lambda random: AboutAxis(point=directions(random), axis=directions(random), pitch=random.normal()),
    2: lambda random: AboutAxis(point=directions(random), axis=directions(random), sliding=True),
    3: lambda random: AboutPoint(point=directions(random)),
    4: lambda random: AlongLine(direction=directions(random), turning=True),
    5: lambda random: InPlane(normal=directions(random), turning="any"),
}


@given(seeds, st.sampled_from(sorted(KINDS)))
def test_projections_by_a_mass(seed, free):
    """``P^2 = P``, ``A P = 0``, ``M P = P^T M``; what is kept and what is stopped have separate energies."""
    random = np.random.default_rng(seed)
    A, dA = KINDS[free](random).rows(SPACE, directions(random), random.normal(size=6))
    root = random.normal(size=(6, 6))
    M = root @ root.T + np.diag(random.uniform(0.1, 10.0, 6))
    P, N = free_projection(A, M), free_basis(A, M)
    size = np.abs(M).max() * np.abs(P).max()
    assert N.shape == (6, free)
    assert_allclose(P @ P, P, atol=1e-9 * np.abs(P).max() ** 2)
    assert_allclose(A @ P, 0.0, atol=1e-9 * np.abs(A).max() * np.abs(P).max())
    assert_allclose(M @ P, (M @ P).T, atol=1e-9 * size)
    assert_allclose(N.T @ M @ N, np.eye(free), atol=1e-9)
    assert_allclose(N @ N.T @ M, P, atol=1e-8 * (1.0 + np.abs(P).max()))
    twist = random.normal(size=6)
    kept, stopped = P @ twist, twist - P @ twist
    energy = [one @ M @ one for one in (twist, kept, stopped)]
    assert energy[0] == pytest.approx(energy[1] + energy[2], rel=1e-9)
    # Equations of motion, and the reactions' power of a free twist.
    force = random.normal(size=6)
    acceleration, reaction = constrained_motion(M, force, A, dA, kept)
    assert_allclose(M @ acceleration, force + A.T @ reaction, atol=1e-8 * size)
    assert_allclose(A @ acceleration, -dA @ kept, atol=1e-8 * (1.0 + np.abs(dA @ kept).max()))
    assert kept @ A.T @ reaction == pytest.approx(0.0, abs=1e-8 * size)


@given(seeds)
def test_no_point_of_a_triangle_is_closer_than_the_closest(seed):
    """Triangles of any shape, against many points of them, and the feature on which the closest point lies."""
    random = np.random.default_rng(seed)
    a, b, c = random.normal(size=(3, 8, 3))
    b[:2] = a[:2] + 1e-2 * random.normal(size=(2, 3))  # thin ones
    points = 2.0 * random.normal(size=(8, 3))
    found = closest_on_triangles(points, a, b - a, c - a)
    grid = np.array([(i, j) for i in range(41) for j in range(41 - i)]) / 40.0
    dense = a[:, None] + grid[:, :1] * (b - a)[:, None] + grid[:, 1:] * (c - a)[:, None]
    far = np.linalg.norm(points - found.point, axis=1)
    brute = np.linalg.norm(points[:, None] - dense, axis=2).min(axis=1)
    longest = np.max(np.linalg.norm([b - a, c - b, a - c], axis=2), axis=0)
    assert np.all(far <= brute + 1e-12)
    assert np.all(far >= brute - longest / 40.0)
    share = np.array(
        [
            np.linalg.lstsq(np.array([q - p, r - p]).T, x - p, rcond=None)[0]
            for p, q, r, x in zip(a, b, c, found.point, strict=True)
        ]
    )
    weights = np.column_stack([1.0 - share.sum(axis=1), share])  # of the corners
    assert_allclose(np.einsum("nk,nkd->nd", weights, np.stack([a, b, c], axis=1)), found.point, atol=1e-9)
    zero = {0: (), 1: (2,), 2: (0,), 3: (1,), 4: (1, 2), 5: (0, 2), 6: (0, 1)}
    for row, feature in zip(weights, found.feature.tolist(), strict=True):
        assert np.all(row > -1e-7)
        assert_allclose(row[list(zero[feature])], 0.0, atol=1e-7)
