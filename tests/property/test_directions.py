"""Displays of several axes: the worst direction against the whole coupled loop, and the worst of several hands."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

import infinivar as iv

ARM = iv.motion.ArmModel.named("vanbeek2015")
STIFF = replace(ARM, name="stiff", damping=4.0, stiffness=1000.0)
DRIVES = iv.load_study("hand_controller").drives
GEARED = iv.displays.ImpedanceDisplay(
    drive=DRIVES["motor2-gear4"], viscous_friction=2.0, handle_mass=0.5, wall_damping=60.0
)
COBOTIC = iv.displays.AdmittanceDisplay(
    drive=DRIVES["cobotic"], virtual_mass=1.0, handle_mass=0.5, filter_frequency=100.0, wall_damping=60.0
)
JACOBIAN = np.array([[1.0, 0.2], [0.4, 0.7]])


def _growth(display, jacobian, arm, stiffness):
    """Of both axes and the plane of the handle at once, with a wall on every axis, one sample late."""
    axes, m = np.asarray(jacobian), display.drive_mass
    mass = m * axes.T @ axes + (display.handle_mass + arm.mass) * np.eye(2)
    rub = display.viscous_friction * axes.T @ axes + arm.damping * np.eye(2)
    system = np.zeros((6, 6))
    system[:2, 2:4] = np.eye(2)
    system[2:4, :2], system[2:4, 2:4] = -np.linalg.solve(mass, arm.stiffness * np.eye(2)), -np.linalg.solve(mass, rub)
    system[2:4, 4:] = np.linalg.solve(mass, axes.T)
    step = expm(1e-3 * system)
    # State, forces that wait, last positions of the axes.
    closed = np.zeros((8, 8))
    closed[:4, :4], closed[:4, 4:6] = step[:4, :4], step[:4, 4:]
    damper = display.wall_damping / 1e-3
    closed[4:6, :2], closed[4:6, 6:] = -(stiffness + damper) * axes, damper * np.eye(2)
    closed[6:, :2] = axes
    return np.max(np.abs(np.linalg.eigvals(closed)))


def test_walls_of_two_axes_against_the_whole_loop():
    """In no direction softer than found, all at once: the wall of the axes at 0.95 of the softest is stable, at 1.05 not."""
    found = iv.displays.worst_direction(GEARED, JACOBIAN, ARM, margin=1.0)
    axis = np.min(found.wall / found.travel**2)
    assert _growth(GEARED, JACOBIAN, ARM, 0.95 * axis) < 1.0
    assert _growth(GEARED, JACOBIAN, ARM, 1.05 * axis) > 1.0
    whole = GEARED.drive_mass * JACOBIAN.T @ JACOBIAN + 0.5 * np.eye(2)
    np.testing.assert_allclose(np.sort(found.least_mass), np.linalg.eigvalsh(whole), rtol=1e-9)
    for one, mass in zip(found.direction, found.least_mass, strict=True):
        assert one @ whole @ one == pytest.approx(mass, rel=1e-9)


def test_one_axis_is_itself():
    found = iv.displays.worst_direction(COBOTIC, [[1.0]], ARM)
    least = iv.displays.least_stable_mass(COBOTIC.softest(), ARM)
    wall = iv.displays.stiffest_wall(replace(COBOTIC, virtual_mass=1.1 * least), ARM) / 1.1
    assert found.least_mass[0] == pytest.approx(1.1 * least + 0.5)
    assert found.wall[0] == pytest.approx(wall)
    assert found.verdict.startswith("Worst directions: 1.4")


def test_a_rotation_changes_nothing_but_the_directions():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    one, other = (iv.displays.worst_direction(GEARED, jacobian, ARM) for jacobian in (JACOBIAN, turn @ JACOBIAN))
    np.testing.assert_allclose(one.wall, other.wall, rtol=1e-6)
    np.testing.assert_allclose(np.abs(one.direction), np.abs(other.direction), rtol=1e-6)


def test_the_worst_of_several_hands():
    both = iv.displays.worst_direction(COBOTIC, np.eye(2), [ARM, STIFF])
    each = [iv.displays.worst_direction(COBOTIC, np.eye(2), hand) for hand in (ARM, STIFF)]
    np.testing.assert_allclose(both.least_mass, np.max([one.least_mass for one in each], axis=0))
    np.testing.assert_allclose(both.wall, np.min([one.wall for one in each], axis=0))
    heavy = max(each, key=lambda one: one.least_mass[0]).mass_hand[0]
    assert both.mass_hand == (heavy, heavy)
    assert f"with {heavy}" in both.verdict


@pytest.mark.parametrize(
    ("jacobian", "hands", "message"),
    [
        ([[1.0, 2.0]], ARM, "jacobian must be"),
        ([[1.0, 1.0], [1.0, 1.0]], ARM, "jacobian must be one that leaves no direction free"),
        ([[1.0]], [], "hands must be one or several ArmModels"),
        ([[1.0]], ["me"], "hands must be ArmModels"),
    ],
)
def test_bad_input(jacobian, hands, message):
    with pytest.raises(iv.InputError, match=message):
        iv.displays.worst_direction(GEARED, jacobian, hands)
