"""Kinematics of omniwheels against published forms."""

import numpy as np
import pytest

from internals import Omniwheels
from machines import ring_of_omniwheels


@pytest.mark.source("siegwart2004", "Eq 3.19", "Eq 3.20")
@pytest.mark.parametrize("seed", range(5))
def test_rolling_constraint_of_a_swedish_wheel(seed):
    """Rim speed by alpha, beta, l and gamma of the book; tolerance: rounding.

    The book's second constraint gives the rollers' speed with the wheel term's sign reversed: see the module.
    """
    rng = np.random.default_rng(seed)
    alpha, beta, gamma, length = *rng.uniform(-1.2, 1.2, (3, 3)), rng.uniform(0.1, 0.5, 3)
    wheels = Omniwheels(
        positions=np.stack([length * np.cos(alpha), length * np.sin(alpha)], axis=-1),
        headings=alpha + beta - np.pi / 2,
        roller_angles=gamma,
    )
    total = alpha + beta + gamma
    rolling = np.stack([np.sin(total), -np.cos(total), -length * np.cos(beta + gamma)], axis=-1)
    sliding = np.stack([np.cos(total), np.sin(total), length * np.sin(beta + gamma)], axis=-1)
    np.testing.assert_allclose(wheels.rim_rows * np.cos(gamma)[:, None], rolling, atol=1e-14)
    rollers = sliding + np.sin(gamma)[:, None] * wheels.rim_rows
    np.testing.assert_allclose(wheels.roller_rows, rollers, atol=1e-14)
    ahead = np.stack([np.cos(wheels.headings), np.sin(wheels.headings), np.zeros(3)], axis=-1)
    np.testing.assert_allclose(np.sum(wheels.roller_rows * ahead, axis=-1), 0.0, atol=1e-14)  # straight ahead


@pytest.mark.source("muir1987")
def test_four_mecanum_wheels_have_the_usual_matrix():
    """Rim speeds v_x -+ v_y -+ (l_x + l_y) omega of wheels with rollers at 45 degrees; tolerance: rounding."""
    lx, ly = 0.25, 0.2
    wheels = Omniwheels(
        positions=((lx, ly), (lx, -ly), (-lx, ly), (-lx, -ly)),
        headings=(0.0,) * 4,
        roller_angles=tuple(np.array([-1, 1, 1, -1]) * np.pi / 4),
    )
    usual = [[1, -1, -(lx + ly)], [1, 1, lx + ly], [1, 1, -(lx + ly)], [1, -1, lx + ly]]
    np.testing.assert_allclose(wheels.rim_rows, usual, atol=1e-15)


def test_three_wheels_at_120_degrees_share_a_force_by_two_thirds():
    """The rims of a regular ring push with 2/n of a force times its component: sum of squares, closed form."""
    ring = ring_of_omniwheels(3, 0.2)
    forces = ring.at(np.array(0.0)).link_forces([9.0, 0.0, 0.0])
    places = 2 * np.pi * np.arange(3) / 3 + np.pi / 2
    np.testing.assert_allclose(forces, 2 / 3 * 9.0 * np.cos(places), atol=1e-14)
