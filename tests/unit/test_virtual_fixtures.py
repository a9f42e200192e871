"""Fixtures of 1 to 5 free dimensions, and motion under them; and messages."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import infinivar as iv
from constraints import constrained_motion, free_projection
from infinivar.motion import AboutAxis, AboutPoint, AlongLine, ArcCurve, Ball, InPlane, OnCurve, OnSurface, PointCurve
from internals import ByRows, free_basis
from internals import FixtureRow as Row

SPACE, PLANE, CARRIAGE = ("x", "y", "z", "rx", "ry", "rz"), ("x", "y", "angle"), ("x", "y")
RNG = np.random.default_rng(11)
HELIX = ArcCurve(centre=(0.0, 0.0, 0.0), radius=0.1, axis=(0.2, 0.1, 1.0), pitch=0.05, turn=12.0)
AROUND = np.arange(3000) * 2.0 * math.pi / 3000
ELLIPSE = PointCurve.through(np.stack([0.2 * np.cos(AROUND), 0.1 * np.sin(AROUND)], axis=1), closed=True)
CASES = {
    "line": (AlongLine(direction=(1.0, 2.0, -0.5)), SPACE, 1),
    "line, turning": (AlongLine(direction=(1.0, 2.0, -0.5), turning=True), SPACE, 4),
    "line in the plane": (AlongLine(direction=(1.0, 2.0)), PLANE, 1),
    "line in the plane, turning": (AlongLine(direction=(1.0, 2.0), turning=True), PLANE, 2),
    "line of a carriage": (AlongLine(direction=(1.0, 2.0)), CARRIAGE, 1),
    "plane": (InPlane(normal=(1.0, 2.0, -0.5)), SPACE, 2),
    "plane, turning": (InPlane(normal=(1.0, 2.0, -0.5), turning="normal"), SPACE, 3),
    "point in a plane": (InPlane(normal=(1.0, 2.0, -0.5), turning="any"), SPACE, 5),
    "axis": (AboutAxis(point=(0.1, 0.2, 0.3), axis=(1.0, 2.0, -0.5)), SPACE, 1),
    "screw": (AboutAxis(point=(0.1, 0.2, 0.3), axis=(1.0, 2.0, -0.5), pitch=0.01), SPACE, 1),
    "shaft": (AboutAxis(point=(0.1, 0.2, 0.3), axis=(1.0, 2.0, -0.5), sliding=True), SPACE, 2),
    "axis in the plane": (AboutAxis(point=(0.1, 0.2)), PLANE, 1),
    "ball joint": (AboutPoint(point=(0.1, 0.2, 0.3)), SPACE, 3),
    "ball joint in the plane": (AboutPoint(point=(0.1, 0.2)), PLANE, 1),
    "rows": (ByRows(constraints=(Row(x=1.0, rz=-0.2), Row(y=1.0, ry=0.1))), SPACE, 4),
    "on a ball": (OnSurface(surface=Ball(centre=(0.0, 0.1, 0.0), radius=0.3)), SPACE, 5),
    "on a ball, no turning": (OnSurface(surface=Ball(centre=(0.0, 0.1, 0.0), radius=0.3), turning=False), SPACE, 2),
    "on a disc": (OnSurface(surface=Ball(centre=(0.0, 0.1), radius=0.3)), PLANE, 2),
    "on a helix": (OnCurve(curve=HELIX, turning=True), SPACE, 4),
    "on an ellipse": (OnCurve(curve=ELLIPSE), PLANE, 1),
}


@pytest.mark.parametrize("name", CASES)
def test_free_dimensions_and_rates(name):
    """The count, and dA/dt against a difference of A along the motion."""
    fixture, coordinates, free = CASES[name]
    place = np.array([0.07, 0.12, 0.03])[: 3 if coordinates == SPACE else 2]
    assert fixture.freedoms(coordinates, place) == free
    twist = RNG.normal(size=len(coordinates))
    A, dA = fixture.rows(coordinates, place, twist)
    step = 1e-6
    ahead, behind = (fixture.rows(coordinates, place + sign * step * twist[: len(place)]).rows for sign in (1.0, -1.0))
    assert_allclose(dA, (ahead - behind) / (2.0 * step), atol=1e-6 * (1.0 + np.abs(dA).max()))
    assert_allclose(A @ free_basis(A), 0.0, atol=1e-14)
    assert_allclose(fixture.rows(coordinates, place).rates, 0.0)


def test_free_twists_by_hand():
    """What slides, turns and screws: the twist of a body point by the velocity of a rigid body."""
    axis, centre, place = np.array([0.0, 0.6, 0.8]), np.array([0.1, 0.2, 0.3]), np.array([0.5, -0.1, 0.2])
    for pitch in (0.0, 0.02):
        A = AboutAxis(point=tuple(centre), axis=(0.0, 3.0, 4.0), pitch=pitch).rows(SPACE, place).rows
        twist = np.concatenate([np.cross(axis, place - centre) + pitch / (2.0 * math.pi) * axis, axis])
        assert_allclose(A @ twist, 0.0, atol=1e-15)
    A = AboutPoint(point=tuple(centre)).rows(SPACE, place).rows
    turn = np.array([0.3, -0.4, 0.7])
    assert_allclose(A @ np.concatenate([np.cross(turn, place - centre), turn]), 0.0, atol=1e-15)
    A = AlongLine(direction=(0.0, 3.0, 4.0)).rows(SPACE).rows
    assert_allclose(np.abs(free_basis(A)[:, 0]), [0.0, 0.6, 0.8, 0.0, 0.0, 0.0], atol=1e-15)
    assert_allclose(AlongLine(direction=(3.0, 4.0)).rows(CARRIAGE).rows, [[-0.8, 0.6]])
    A = AboutAxis(point=(0.1, 0.2)).rows(PLANE, (0.4, 0.2)).rows
    assert_allclose(A @ [0.0, 0.3, 1.0], 0.0, atol=1e-15)
    assert AlongLine(direction=(0.0, 0.0, 1.0)).rows(("x", "y", "z")).rows.shape == (2, 3)
    assert InPlane(normal=(0.0, 0.0, 1.0)).rows(SPACE).rows.shape == (4, 6)


def positive(d):
    root = RNG.normal(size=(d, d))
    return root @ root.T + 0.2 * np.eye(d)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["on a ball", "ball joint", "on a helix", "screw", "on an ellipse", "line, turning"])
def test_motion_under_a_fixture_keeps_energy_and_constraint(name):
    """``M dxi = F + A^T lambda`` without force: the kinetic energy stays, to the integrator, and the constraint does not leak."""
    fixture, coordinates, _ = CASES[name]
    d = len(coordinates)
    M = positive(d)
    place = np.zeros(3 if d == 6 else 2)
    if name.startswith("on a"):
        target = getattr(fixture, "curve", None)
        place = target.at(0.3 * target.length)[0] if target is not None else np.array([0.0, 0.4, 0.0])
    start = free_projection(fixture.rows(coordinates, place).rows, M) @ RNG.normal(size=d)
    start *= 0.3 / np.linalg.norm(start[: len(place)] if len(place) == 2 else start[:3])

    def rates(time, state):
        here, twist = state[: len(place)], state[len(place) :]
        A, dA = fixture.rows(coordinates, here, twist)
        acceleration, _ = constrained_motion(M, np.zeros(d), A, dA, twist)
        return np.concatenate([twist[: len(place)], acceleration])

    done = solve_ivp(rates, (0.0, 0.3), np.concatenate([place, start]), method="DOP853", rtol=1e-9, atol=1e-11)
    twists = done.y[len(place) :].T
    energy = 0.5 * np.einsum("ti,ij,tj->t", twists, M, twists)
    assert_allclose(energy, energy[0], rtol=1e-6)
    leak = [np.abs(fixture.rows(coordinates, one[: len(place)]).rows @ one[len(place) :]).max() for one in done.y.T]
    assert max(leak) < 1e-6
    if name == "on a ball":
        assert_allclose(fixture.surface.distance(done.y[:3].T), 0.0, atol=1e-7)
    elif name.startswith("on a"):
        assert_allclose(fixture.curve.nearest(done.y[: len(place)].T).offset, 0.0, atol=1e-7)


def test_reactions_balance_a_push_across_and_do_no_work():
    A = AlongLine(direction=(3.0, 4.0)).rows(CARRIAGE).rows
    M, push = 8.0 * np.eye(2), np.array([3.0, 4.0]) + 10.0 * np.array([-4.0, 3.0])
    acceleration, reaction = constrained_motion(M, push, A, np.zeros_like(A), np.zeros(2))
    assert_allclose(acceleration, np.array([3.0, 4.0]) / 8.0)
    assert_allclose(push + A.T @ reaction, [3.0, 4.0])


def test_a_circle_needs_the_centripetal_reaction():
    """A mass m at the speed u on a circle of radius r: ``m u^2/r``."""
    fixture = OnSurface(surface=Ball(centre=(0.0, 0.0), radius=0.25, free="inside"))
    A, dA = fixture.rows(CARRIAGE, (0.25, 0.0), (0.0, 2.0))
    acceleration, reaction = constrained_motion(3.0 * np.eye(2), np.zeros(2), A, dA, np.array([0.0, 2.0]))
    assert_allclose(reaction, [3.0 * 4.0 / 0.25])
    assert_allclose(acceleration, [-16.0, 0.0], atol=1e-12)


LINE = AlongLine(direction=(1.0, 0.0))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: AlongLine(direction=(0.0, 0.0, 0.0)), "direction must be a direction, not zero"),
        (lambda: AlongLine(direction=(1.0,)), "direction must be a point of two or three coordinates"),
        (lambda: AlongLine(direction=(1.0, 0.0), turning="no"), "turning must be true or false"),
        (lambda: InPlane(normal=(0.0, 1.0)), "normal must be points of 3 coordinates"),
        (
            lambda: InPlane(normal=(0.0, 0.0, 1.0), turning="normals"),
            "turning must be one of none, normal, any, got 'normals'",
        ),
        (lambda: AboutAxis(point=(0.0, 0.0), axis=(0.0, 0.0, 0.0)), "axis must be a direction, not zero"),
        (lambda: AboutAxis(point=(0.0, 0.0), pitch=0.1, sliding=True), "pitch and sliding exclude each other"),
        (lambda: AboutAxis(point=(0.0, 0.0), pitch=math.nan), "pitch must be finite m, got nan"),
        (lambda: AboutPoint(point=(0.0, math.inf)), r"point\[1\] must be finite m"),
        (lambda: ByRows(constraints=()), "constraints must be one Row or more, got none"),
        (lambda: ByRows(constraints=(Row(x=1.0), Row(x=2.0))), "constraints must be independent: .*, got 2 of rank 1"),
        (lambda: ByRows(constraints=tuple(Row(x=1.0, y=float(k)) for k in range(6))), "constraints must be at most 5"),
        (lambda: Row(), "row must be a constraint"),
        (lambda: OnSurface(surface=LINE), "surface must be a surface"),
        (lambda: OnCurve(curve=LINE), "curve must be a curve"),
        (lambda: LINE.rows(("x", "w")), "coordinates must be some of x, y, z, rx, ry, rz, angle, got 'w'"),
        (lambda: LINE.rows("xy"), "coordinates must be some of"),
        (lambda: LINE.rows(()), "coordinates must be some of .*, got none"),
        (lambda: LINE.rows(CARRIAGE, np.zeros((4, 3))), r"position must be one point, got shape \(4, 3\)"),
        (lambda: LINE.rows(("x", "x")), "coordinates must be different"),
        (lambda: LINE.rows(("x", "rz", "angle")), "without rx, ry and rz beside angle"),
        (lambda: LINE.rows(("x",)), "constrains nothing of a machine that moves x"),
        (lambda: AlongLine(direction=(0.0, 1.0)).rows(("x",)), "leaves nothing free of a machine that moves x"),
        (lambda: LINE.rows(CARRIAGE, (0.0, math.nan)), "position must be finite"),
        (lambda: LINE.rows(CARRIAGE, (0.0, 0.0), (1.0, 2.0, 3.0)), r"twist must be of shape \(2,\), got shape \(3,\)"),
        (lambda: LINE.rows(CARRIAGE, (0.0, 0.0), (1.0, math.inf)), "twist must be finite"),
        (
            lambda: OnCurve(curve=ArcCurve(centre=(0.0, 0.0), radius=1.0)).rows(CARRIAGE, (0.0, 0.0)),
            "a centre of curvature",
        ),
        (lambda: free_basis([[1.0, 0.0], [0.0, 1.0]]), "rows must be of shape"),
        (lambda: free_basis([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), "rows must be independent, got 2 rows of rank 1"),
        (lambda: free_basis([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), "got only zeros in row 2"),
        (lambda: free_basis([[1.0, math.nan]]), "rows must be finite"),
        (lambda: free_basis([[1.0, 0.0]], np.eye(3)), r"mass must be of shape \(2, 2\)"),
        (lambda: free_basis([[1.0, 0.0]], [[1.0, 2.0], [0.0, 1.0]]), "mass must be symmetric"),
        (lambda: free_basis([[1.0, 0.0]], [[1.0, 2.0], [2.0, 1.0]]), "mass must be positive definite"),
    ],
)
def test_one_clear_message(make, message):
    with pytest.raises(iv.InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
