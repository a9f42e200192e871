"""Fixtures and holding of planar cobots against rigid-body mechanics and a search by brute force."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import infinivar as iv
from internals import PlanarFixtureGuide, PlanarHoldGuide, locking_headings
from machines import HEXAPOD, IDEAL_WHEEL, LEG, REAL_WHEEL, cart

STEERING = replace(LEG.steering, patch_half_length=3e-4)
CART, REAL = (cart(wheel, steering=STEERING) for wheel in (IDEAL_WHEEL, REAL_WHEEL))
MASS, INERTIA = CART.cobot.mass, CART.cobot.inertia
CORNERS = [(0.3, 0.0), (-0.15, 0.2), (-0.15, -0.2)]


@pytest.mark.slow
def test_along_a_line_a_body_slides_as_a_bead_and_keeps_its_orientation():
    way, force = np.array([2.0, 1.0]) / np.sqrt(5.0), np.array([4.0, 1.0])
    task = iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=way.tolist()))
    run = iv.session(CART, task, user=force.tolist(), duration=0.3, servos="ideal")
    bead = 0.5 * (force @ way) / MASS * run.time[:, None] ** 2 * way
    assert_allclose(run.position, bead, atol=2e-6)
    assert_allclose(run.columns["angle_rad"], 0.0, atol=1e-6)
    assert run.closure < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("machine", "servos", "within"), [(CART, "ideal", 1e-5), (REAL, "real", 2e-4)])
def test_about_a_point_a_body_swings_as_on_a_pivot(machine, servos, within):
    centre, force = np.array([-0.3, 0.2]), np.array([4.0, 6.0])
    task = iv.motion.Fixture(allowed=iv.motion.AboutPoint(point=centre.tolist()))
    run = iv.session(machine, task, user=force.tolist(), duration=0.4, servos=servos)
    arm = -centre

    def swing(time, state):
        angle, rate = state
        out = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ arm
        return [rate, (out[0] * force[1] - out[1] * force[0]) / (INERTIA + MASS * arm @ arm)]

    pivot = solve_ivp(swing, [0.0, 0.4], [0.0, 0.0], t_eval=run.time, rtol=1e-9, atol=1e-12).y[0]
    out = run.position - centre
    around = np.unwrap(np.arctan2(out[:, 1], out[:, 0])) - np.arctan2(arm[1], arm[0])
    assert_allclose(np.hypot(*out.T), np.hypot(*arm), atol=within)
    if servos == "ideal":  # rolling friction slows the other
        assert_allclose(around, pivot, atol=1e-4)
    assert_allclose(run.columns["angle_rad"], around, atol=within / 0.3 + 2e-4)
    assert run.closure < 1e-6


def test_without_turning_a_body_is_free():
    fixed = iv.session(
        CART, iv.motion.Fixture(allowed=iv.motion.InPlane(normal=[0.0, 0.0, 1.0])), user=[3.0, 1.0], duration=0.05
    )
    free = iv.session(CART, iv.motion.Caster(), user=[3.0, 1.0], duration=0.05)
    assert_allclose(fixed.position, free.position, atol=1e-12)


def test_one_wheel_along_a_line():
    one = replace(CART, cobot=replace(CART.cobot, positions=[(0.0, 0.0)], contacts=IDEAL_WHEEL))
    task = iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[0.0, 1.0], turning=True))
    run = iv.session(one, task, user=[5.0, 2.0], duration=0.1, servos="ideal")
    assert_allclose(run.position[-1], [0.0, 0.5 * 2.0 / MASS * 0.01], atol=1e-6)


def test_locked_wheels_hold_without_power():
    run = iv.session(REAL, iv.motion.HoldingTask(), user=[30.0, 10.0], duration=0.1, handle=[0.1, 0.05], tolerance=1e-7)
    assert np.max(np.abs(run.position - run.position[0])) < 1e-7
    assert run.electrical_energy == 0.0


def test_beyond_the_slip_limit_nothing_holds():
    run = iv.session(REAL, iv.motion.HoldingTask(), user=[600.0, 0.0], duration=0.05)
    assert run.slips
    assert run.position[-1, 0] > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    "points", [CORNERS, [(0.3, 0.0), (0.1, 0.0), (-0.4, 0.0)], [(0.1, 0.1), (0.3, 0.2), (-0.2, 0.5)]]
)
def test_locking_headings_against_a_search_by_brute_force(points):
    placed = np.array(points) - np.mean(points, axis=0)
    placed = placed / np.sqrt(np.mean(np.sum(placed**2, axis=1)))

    def quality(headings):
        normals = np.stack([-np.sin(headings), np.cos(headings)], axis=-1)
        moments = normals[:, 1] * placed[:, 0] - normals[:, 0] * placed[:, 1]
        values = np.linalg.svd(np.column_stack([normals, moments]), compute_uv=False)
        return values[-1] / values[0]

    grid = np.linspace(0.0, np.pi, 24, endpoint=False)
    best = max(quality(np.array(one)) for one in itertools.product(grid, repeat=3))
    assert quality(locking_headings(points)) > 0.95 * best


def test_two_wheels_hold_nothing():
    two = replace(CART, cobot=replace(CART.cobot, positions=CORNERS[:2], contacts=IDEAL_WHEEL))
    with pytest.raises(iv.InputError, match="held by three wheels or more at different points, got 2"):
        iv.session(two, iv.motion.HoldingTask(), duration=0.1)
    with pytest.raises(iv.InputError, match="different points, got 3"):
        locking_headings([(0.1, 0.1)] * 3)


@pytest.mark.parametrize(
    ("allowed", "message"),
    [
        (iv.motion.AlongLine(direction=[1.0, 0.0], turning=True), "leaves 2 of x, y and angle free on 3 wheels"),
        (iv.motion.AboutPoint(point=[0.0, 0.0]), "must be 1 mm or more from the point"),
    ],
)
def test_what_wheels_cannot_do_is_said(allowed, message):
    with pytest.raises(iv.InputError, match=message):
        iv.session(CART, iv.motion.Fixture(allowed=allowed), duration=0.1)


def test_guides_are_of_planar_cobots():
    with pytest.raises(iv.InputError, match="holds a PlanarMachine"):
        iv.session(HEXAPOD, controller=PlanarHoldGuide(), duration=0.01)
    with pytest.raises(iv.InputError, match="guides a PlanarMachine"):
        iv.session(
            HEXAPOD,
            controller=PlanarFixtureGuide(allowed=iv.motion.AlongLine(direction=[1.0, 0.0, 0.0])),
            duration=0.01,
        )
    with pytest.raises(iv.InputError, match="allowed must be a fixture"):
        PlanarFixtureGuide(allowed=3)
