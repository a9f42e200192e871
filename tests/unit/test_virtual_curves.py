"""Curves of virtual paths: against closed forms, brute force, and their own derivatives; and messages."""

import math
import pickle
import time

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ellipe

import infinivar as iv
from infinivar.motion import ArcCurve, LineCurve, PointCurve

RNG = np.random.default_rng(3)
AROUND = np.arange(3000) * 2.0 * math.pi / 3000
ELLIPSE = PointCurve.through(np.stack([0.2 * np.cos(AROUND), 0.1 * np.sin(AROUND)], axis=1), closed=True)
CIRCLE = ArcCurve(centre=(0.1, 0.2), radius=0.3)
HELIX = ArcCurve(centre=(0.0, 0.0, 0.0), radius=0.1, axis=(0.0, 0.0, 1.0), pitch=0.05, turn=20.0)
WAVE = PointCurve.through(np.stack([np.linspace(0, 1, 40), 0.1 * np.sin(9 * np.linspace(0, 1, 40))], axis=1))
EIGHT = PointCurve.through(np.stack([np.sin(AROUND), 0.5 * np.sin(2 * AROUND)], axis=1), closed=True)


def test_a_circle_in_the_plane():
    """Closed form: the offset to the left, towards the centre, is the radius less the distance from the centre."""
    points = RNG.uniform(-0.4, 0.6, (300, 2))
    found = CIRCLE.nearest(points)
    away = points - [0.1, 0.2]
    far = np.hypot(*away.T)
    assert_allclose(found.offset, 0.3 - far, atol=1e-10)
    assert_allclose(found.point, [0.1, 0.2] + 0.3 * away / far[:, None], atol=1e-9)
    assert_allclose(found.curvature, 1.0 / 0.3, rtol=1e-6)
    assert_allclose(found.tangent, np.stack([-away[:, 1], away[:, 0]], axis=1) / far[:, None], atol=1e-7)
    assert_allclose(found.arc_length, 0.3 * np.mod(np.arctan2(away[:, 1], away[:, 0]), 2 * math.pi), atol=1e-8)
    assert CIRCLE.is_closed
    assert_allclose(CIRCLE.length, 0.6 * math.pi, rtol=1e-12)
    assert_allclose(CIRCLE.at(CIRCLE.length + 0.1), CIRCLE.at(0.1), atol=1e-12)


def test_a_turn_to_the_right_has_the_other_signs():
    right = ArcCurve(centre=(0.0, 0.0), radius=0.5, turn=-1.0)
    found = right.nearest([0.55, -0.1])
    assert found.curvature == pytest.approx(-2.0, rel=1e-7)
    assert found.offset == pytest.approx(math.hypot(0.55, 0.1) - 0.5, abs=1e-10)


def test_an_ellipse_against_its_elliptic_integral_and_brute_force():
    assert_allclose(ELLIPSE.length, 4.0 * 0.2 * ellipe(0.75), rtol=1e-9)
    u = np.linspace(0.0, 2.0 * math.pi, 200_001)
    dense = np.stack([0.2 * np.cos(u), 0.1 * np.sin(u)], axis=1)
    points = RNG.uniform(-0.3, 0.3, (40, 2))
    brute = [np.sqrt(np.min(np.sum((dense - one) ** 2, axis=1))) for one in points]
    assert_allclose(np.abs(ELLIPSE.nearest(points).offset), brute, atol=1e-8)
    assert_allclose(ELLIPSE.nearest([0.3, 0.0]).curvature, 0.2 / 0.1**2, rtol=1e-5)


def test_a_helix_in_space():
    """Closed forms: length, curvature, and the centre of curvature on the axis's side."""
    rise = 0.05 / (2.0 * math.pi)
    assert_allclose(HELIX.length, 20.0 * math.hypot(0.1, rise), rtol=1e-10)
    there = np.linspace(0.0, HELIX.length, 50)
    point, tangent, bend = HELIX.at(there)
    u = there / math.hypot(0.1, rise)
    assert_allclose(point, np.stack([0.1 * np.cos(u), 0.1 * np.sin(u), rise * u], axis=1), atol=1e-10)
    assert_allclose(np.linalg.norm(bend, axis=1), 0.1 / (0.1**2 + rise**2), rtol=1e-6)
    found = HELIX.nearest(point + 0.004 * bend / np.linalg.norm(bend, axis=1)[:, None])
    assert_allclose(found.arc_length, there, atol=1e-8)
    assert_allclose(found.offset, 0.004, rtol=1e-7)
    assert_allclose(found.tangent, tangent, atol=1e-7)


@pytest.mark.parametrize(
    "axis",
    [(1.0, 0.0, 0.0), (-2.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.8, -0.6, 0.3)],
    ids=["x", "-x", "diagonal", "slanted"],
)
def test_an_arc_about_any_axis_keeps_its_distance_and_advances_with_its_turn(axis):
    """By definition of the helix, and of where its angle is zero."""
    centre, along = np.array([0.1, -0.2, 0.3]), np.array(axis) / np.linalg.norm(axis)
    curve = ArcCurve(centre=centre.tolist(), radius=0.25, axis=axis, pitch=0.06, turn=4.0, start_angle=0.4)
    there, rise = np.linspace(0.0, curve.length, 40), 0.06 / (2.0 * math.pi)
    off = curve.at(there)[0] - centre
    advance = off @ along
    assert_allclose(np.linalg.norm(off - np.outer(advance, along), axis=1), 0.25, atol=1e-9)
    assert_allclose(advance, rise * there / math.hypot(0.25, rise), atol=1e-9)
    reference = np.eye(3)[1 if abs(along[0]) == 1.0 else 0]
    first = reference - (reference @ along) * along
    first /= np.linalg.norm(first)
    assert_allclose(off[0], 0.25 * (math.cos(0.4) * first + math.sin(0.4) * np.cross(along, first)), atol=1e-9)


@pytest.mark.parametrize(
    "curve", [CIRCLE, ELLIPSE, HELIX, WAVE, EIGHT], ids=["circle", "ellipse", "helix", "wave", "eight"]
)
def test_derivatives_by_the_arc_length(curve):
    """Tangent and curvature vector against differences of the point; the tangent is a unit vector."""
    there, step = np.linspace(0.01, 0.99, 57) * curve.length, 1e-5 * curve.length
    (before, early, _), (_, tangent, bend), (after, late, _) = (curve.at(there + shift) for shift in (-step, 0.0, step))
    assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, rtol=1e-14)
    assert_allclose((after - before) / (2.0 * step), tangent, atol=1e-7)
    assert_allclose((late - early) / (2.0 * step), bend, atol=2e-4 * np.max(np.abs(bend)))


@pytest.mark.parametrize(
    "curve", [CIRCLE, ELLIPSE, HELIX, WAVE, EIGHT], ids=["circle", "ellipse", "helix", "wave", "eight"]
)
def test_one_point_rows_and_the_branch_that_is_near_agree(curve):
    there = np.linspace(0.02, 0.97, 31) * curve.length
    point = curve.at(there)[0]
    points = point + 1e-3 * RNG.normal(size=point.shape)
    rows = curve.nearest(points)
    near = curve.nearest(points, near=there)
    for place, one in enumerate(points):
        for name, value in curve.nearest(one)._asdict().items():
            assert_allclose(value, getattr(rows, name)[place], atol=1e-7)
            if curve is not EIGHT:
                assert_allclose(getattr(near, name)[place], value, atol=1e-7)


def test_following_keeps_to_its_branch_where_a_curve_crosses_itself():
    """Around the crossing of an eight the arc length goes on, though the other branch is as close."""
    there, found = np.linspace(0.45, 0.55, 101) * EIGHT.length, 0.45 * EIGHT.length
    for expected in there:
        point = EIGHT.at(expected)[0] + [0.0, 2e-3]
        found = EIGHT.nearest(point, near=found).arc_length
        assert abs(found - expected) < 0.01


def test_following_finds_the_way_from_far():
    """From the wrong side of a circle, and from its centre, where nothing is downhill."""
    found = CIRCLE.nearest([0.45, 0.2], near=0.35 * CIRCLE.length)
    assert_allclose(found.point, [0.4, 0.2], atol=1e-9)
    at_centre = CIRCLE.nearest([0.1, 0.2], near=0.3)
    assert abs(at_centre.offset) == pytest.approx(0.3, abs=1e-9)


def test_past_the_ends_of_an_open_curve():
    line = LineCurve(start=(0.0, 0.0), end=(2.0, 0.0))
    for near in (None, 0.5):
        after, before = line.nearest([2.5, 0.3], near), line.nearest([-0.5, -0.3], near)
        assert (after.arc_length, after.beyond, after.offset) == pytest.approx((2.0, 0.5, 0.3))
        assert (before.arc_length, before.beyond, before.offset) == pytest.approx((0.0, -0.5, -0.3))
    assert line.nearest([1.0, 0.3]).beyond == 0.0
    assert_allclose(line.nearest([[2.5, 0.3], [1.0, 0.3]]).beyond, [0.5, 0.0])
    assert_allclose(line.ends, [[0.0, 0.0], [2.0, 0.0]])
    assert_allclose(line.at(5.0)[0], [2.0, 0.0])
    in_space = LineCurve(start=(0.0, 0.0, 0.0), end=(0.0, 0.0, 2.0)).nearest([0.3, 0.4, 2.5])
    assert (in_space.beyond, in_space.offset) == pytest.approx((0.5, 0.5))


def test_a_spline_goes_through_its_points_and_closes_smoothly():
    angle = np.arange(24) * 2.0 * math.pi / 24
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    curve = PointCurve.through(points, closed=True)
    assert np.max(np.abs(curve.nearest(points).offset)) < 1e-12
    assert_allclose(curve.length, 2.0 * math.pi, rtol=2e-5)
    for shift in (1e-9, -1e-9):
        assert_allclose(curve.at(shift)[1], [0.0, 1.0], atol=1e-3)
        assert_allclose(curve.at(shift)[2], [-1.0, 0.0], atol=2e-2)
    assert PointCurve.through([[0, 0], [1, 0], [1, 1], [0, 1]], closed=True).is_closed  # a round outline of four points


def test_far_from_the_origin():
    """Rounding of the coordinates, 1e-8 m, is all that is lost."""
    far = ArcCurve(centre=(1e8, 0.0), radius=1.0)
    found = far.nearest([1e8 + 0.5, 0.5])
    assert found.offset == pytest.approx(1.0 - math.sqrt(0.5), abs=1e-7)
    assert far.nearest([1e8 + 0.5, 0.5], near=0.6).offset == pytest.approx(found.offset, abs=1e-7)


def test_no_points_give_no_rows():
    assert CIRCLE.nearest(np.zeros((0, 2))).point.shape == (0, 2)
    assert CIRCLE.nearest(np.zeros((0, 2)), near=0.0).offset.shape == (0,)


def test_curves_are_values():
    again = PointCurve.through(np.array([WAVE.x, WAVE.y]).T)
    assert again == WAVE
    assert hash(again) == hash(WAVE)
    copy = pickle.loads(pickle.dumps(WAVE))
    assert copy == WAVE
    assert_allclose(copy.at(0.3)[0], WAVE.at(0.3)[0], atol=0.0)


def test_a_query_in_a_loop_is_quick():
    """One closest point near the last costs about 20 us, and 60 us without; the bounds leave room for slow machines."""
    for curve in (ELLIPSE, HELIX):
        point = curve.at(0.3)[0] + 0.01
        for near, most in ((0.29, 400e-6), (None, 1500e-6)):
            spent = []
            for _ in range(50):
                start = time.perf_counter()
                curve.nearest(point, near)
                spent.append(time.perf_counter() - start)
            assert np.median(spent) < most


U_TURN = [[0, 0], [1, 0], [0, 0.01]]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: PointCurve.through([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2]]),
            r"kink of 90 degrees at point 3, \(2, 0\) m",
        ),
        (lambda: PointCurve.through(U_TURN), r"kink of 179 degrees at point 2, \(1, 0\) m"),
        (lambda: PointCurve.through([[0, 0]]), "points must be 2 or more of an open curve, got 1"),
        (
            lambda: PointCurve.through([[0, 0], [1, 0]], closed=True),
            "points must be 3 or more of a closed curve, got 2",
        ),
        (
            lambda: PointCurve.through([[0, 0], [1, 0], [1, 0], [2, 1]]),
            r"points 2 and 3 must differ, got \(1, 0\) m twice",
        ),
        (lambda: PointCurve.through([[0, 0], [1, 0], [0, 1], [0, 0]], closed=True), "remove point 4"),
        (lambda: PointCurve.through([[0, 0], [1, math.nan]]), "point 2 must have finite coordinates"),
        (lambda: PointCurve.through([[0, 0, 0, 0], [1, 1, 1, 1]]), r"of shape \(n, 2\) or \(n, 3\)"),
        (lambda: PointCurve(x=(0.0, 1.0), y=(0.0, 1.0, 2.0)), "y must be as many as x: 2, got 3 values"),
        (lambda: PointCurve(x=(0.0, math.inf), y=(0.0, 1.0)), r"x\[1\] must be finite m, got inf"),
        (lambda: PointCurve(x=(0.0, 1.0), y=(0.0, 1.0), closed="yes"), "closed must be true or false"),
        (lambda: LineCurve(start=(0.0, 0.0), end=(0.0, 0.0)), "end must be another point than start"),
        (lambda: LineCurve(start=(0.0, 0.0), end=(0.0, 0.0, 1.0)), "end must be points of 2 coordinates"),
        (lambda: LineCurve(start=(0.0,), end=(1.0,)), "start must be a point of two or three coordinates"),
        (lambda: ArcCurve(centre=(0.0, 0.0), radius=0.0), r"radius must be >= 1e-09 and <= 1e\+09 m, got 0"),
        (lambda: ArcCurve(centre=(0.0, 0.0), radius=1.0, turn=7.0), "turn must be at most 360 degrees"),
        (lambda: ArcCurve(centre=(0.0, 0.0), radius=1.0, pitch=0.1), "pitch must be left out in the plane"),
        (lambda: ArcCurve(centre=(0.0, 0.0, 0.0), radius=1.0), "axis must be given in space"),
        (
            lambda: ArcCurve(centre=(0.0, 0.0, 0.0), radius=1.0, axis=(0.0, 0.0, 0.0)),
            "axis must be a direction, not zero",
        ),
        (lambda: CIRCLE.nearest([1.0, 2.0, 3.0]), "point must be points of 2 coordinates"),
        (lambda: CIRCLE.nearest([1.0, math.nan]), "point must be finite"),
        (lambda: CIRCLE.nearest([1.0, 2.0], near=math.nan), "near must be finite m"),
        (lambda: CIRCLE.nearest([1.0, 2.0], near="here"), "near must be a real number"),
        (lambda: CIRCLE.nearest([1.0, 2.0], near=(1.0, 2.0)), "near must be one number, got shape"),
        (lambda: CIRCLE.nearest([[1.0, 2.0]], near=(1.0, 2.0)), "near must be one number, or 1 of them, got shape"),
        (lambda: CIRCLE.nearest([1e200, 2.0]), r"point must be within 1e\+09 m of the origin, got 1e\+200 m"),
        (lambda: PointCurve.through([[0, 0], [1e200, 0]]), r"points must be within 1e\+09 m of the origin"),
        (lambda: ArcCurve(centre=(1e9, 0.0), radius=1e-3), "too small for its distance from the origin"),
        (lambda: CIRCLE.at(math.inf), "arc_length must be finite m"),
    ],
)
def test_one_clear_message(make, message):
    with pytest.raises(iv.InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
