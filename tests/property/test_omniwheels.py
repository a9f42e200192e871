"""Omniwheels: kinematics by vectors, and the balance of powers at random poses, twists and wrenches."""

import numpy as np
import pytest

from infinivar import ParameterError
from internals import Omniwheels, in_fixed_axes
from machines import ring_of_omniwheels

_POINTS = 20_000


def _drawn(rng):
    count = int(rng.integers(3, 7))
    while True:
        try:
            return Omniwheels(
                positions=rng.uniform(-0.4, 0.4, (count, 2)),
                headings=rng.uniform(-np.pi, np.pi, count),
                roller_angles=rng.uniform(-1.2, 1.2, count),
            )
        except ParameterError:
            continue


@pytest.mark.parametrize("seed", range(20))
def test_the_hub_moves_with_the_rim_and_the_roller(seed):
    """V = v e + s f for each wheel, with V from the rotation of the body alone."""
    rng = np.random.default_rng(seed)
    wheels = _drawn(rng)
    angle, twist = rng.uniform(-4.0, 4.0, _POINTS), rng.normal(size=(_POINTS, 3))
    rims = wheels.at(angle).link_speeds(twist)
    rollers = np.matmul(in_fixed_axes(wheels.roller_rows, angle), twist[..., None])[..., 0]
    turn = angle[:, None] + np.asarray(wheels.headings)
    roller = turn + np.asarray(wheels.roller_angles)
    arm = np.asarray(wheels.positions)
    x = np.cos(angle)[:, None] * arm[:, 0] - np.sin(angle)[:, None] * arm[:, 1]
    y = np.sin(angle)[:, None] * arm[:, 0] + np.cos(angle)[:, None] * arm[:, 1]
    hub_x, hub_y = twist[:, :1] - twist[:, 2:] * y, twist[:, 1:2] + twist[:, 2:] * x
    np.testing.assert_allclose(rims * np.cos(turn) - rollers * np.sin(roller), hub_x, atol=1e-11)
    np.testing.assert_allclose(rims * np.sin(turn) + rollers * np.cos(roller), hub_y, atol=1e-11)


@pytest.mark.parametrize("seed", range(10))
def test_powers_balance_in_all_quadrants(seed):
    """Rims that hold a wrench on the load deliver its power, whatever the signs of wrench and twist."""
    rng = np.random.default_rng(100 + seed)
    wheels = _drawn(rng)
    angle, twist, wrench = rng.uniform(-4.0, 4.0, _POINTS), rng.normal(size=(_POINTS, 3)), rng.normal(size=(_POINTS, 3))
    here = wheels.at(angle)
    delivered = np.sum(here.link_forces(wrench) * here.link_speeds(twist), axis=-1)
    expected = np.sum(wrench * twist, axis=-1)
    assert {(a, b) for a in (-1, 1) for b in (-1, 1)} == set(
        map(tuple, np.sign(wrench[:, :2] * twist[:, :2]).astype(int))
    )
    np.testing.assert_allclose(delivered, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_a_ring_of_omniwheels_turns_all_rims_alike_and_its_rollers_not():
    ring = ring_of_omniwheels(5, 0.3)
    here = ring.at(np.array(0.7))
    np.testing.assert_allclose(here.link_speeds([0.0, 0.0, 2.0]), 0.6, rtol=1e-14)
    np.testing.assert_allclose(ring.roller_rows[:, 2], 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("headings", "positions"),
    [
        ((0.0, 0.0, 0.0), ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))),  # parallel
        ((0.0, np.pi / 2, np.pi / 4), ((1.0, 0.0), (0.0, 1.0), (0.5, 0.5))),  # through the origin
    ],
)
def test_wheels_that_leave_a_motion_free_are_refused(headings, positions):
    with pytest.raises(ParameterError, match="headings leave a motion that turns no wheel"):
        Omniwheels(positions=positions, headings=headings, roller_angles=(0.0, 0.0, 0.0))
