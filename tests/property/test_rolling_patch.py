"""Exact rolling contact: balances, symmetries, limits, derivatives and hard starts of the steady solver."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.contact import kalker

RNG_SEED = 20


def _random_case(rng, kind):
    """Patch and creepages from nearly no slip to gross slip: spin and lateral, combined, pure spin, all."""
    ratio = np.exp(rng.uniform(np.log(0.05), np.log(20.0)))
    turned = rng.choice([0.0, rng.uniform(-1.5, 1.5)])
    patch = iv.contact.RollingPatch(ratio, rng.uniform(0.0, 0.5), turned, int(rng.choice([10, 14])))
    direction = rng.normal(size=3) * [(0, 1, 1), (1, 1, 0), (0, 0, 1), (1, 1, 1)][kind]
    linear = kalker.coefficients(ratio, patch.poisson)
    size = np.exp(rng.uniform(np.log(0.05), np.log(4.0))) / np.linalg.norm(direction)
    return patch, size * direction * np.array([3.0 / linear.c11, 3.0 / linear.c22, 1.0 / linear.c23])


@pytest.mark.slow
def test_hard_starts():
    """Cold starts and reversals all converge, long patches under spin with 20 cells; friction dissipates.

    The power is the work of the forces to 2 % or 1e-4.
    """
    rng = np.random.default_rng(RNG_SEED)
    for number in range(100):
        patch, creepage = _random_case(rng, number % 4)
        forward = patch.steady(*creepage)
        if forward.outcome == "too few cells":
            assert patch.a_over_b > 10.0
            patch = replace(patch, cells=20)
            forward = patch.steady(*creepage)
        back = patch.steady(*-creepage, start=forward)
        for state, sign in ((forward, 1.0), (back, -1.0)):
            assert state.outcome == "converged"
            work = sign * creepage @ state.forces
            assert state.power >= 0.0
            assert_allclose(state.power, work, rtol=0.02, atol=1e-4)
            bound = state.grid.bound * (1.0 + 1e-7)
            assert np.all(np.hypot(*state.traction) <= bound)
        assert_allclose(back.forces, -forward.forces, atol=2e-7)


@pytest.mark.slow
def test_too_few_cells():
    """A small spin on a long patch: coarse grids give the moment the wrong sign, and say so; forces are extrapolated or nan."""
    long = iv.contact.RollingPatch(20.0, 0.5)
    coarse, fine = long.steady(spin=1e-3), replace(long, cells=40).steady(spin=1e-3)
    assert (coarse.outcome, fine.outcome) == ("too few cells", "converged")
    assert coarse.power < 0.0 < fine.power
    assert coarse.mz < 0.0 < fine.mz
    assert not iv.contact.rolling_forces(20.0, spin=1e-3, poisson=0.5).converged
    assert iv.contact.rolling_forces(20.0, spin=1e-3, poisson=0.5, cells=40).converged


@pytest.mark.parametrize("size", [1e-12, 1e-8, 1e-5])
def test_tiny_creepages_are_linear(size):
    patch = iv.contact.RollingPatch(1.0, cells=12)
    gradient = patch.steady(gradient=True).gradient
    state = patch.steady(lateral=size, spin=size)
    assert_allclose(state.forces[1:], gradient[1:, 1:] @ [size, size], rtol=3e-3)
    if size >= 1e-8:
        assert_allclose(patch.transient([20.0], lateral=size, spin=size).fy[-1], state.fy, rtol=1e-4)


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_start_does_not_matter(turned):
    """The solution is unique in practice: from a state of other creepages as from the coarser grid."""
    patch = iv.contact.RollingPatch(0.6, 0.3, turned, 14)
    other = patch.steady(0.2, -0.5, 0.4)
    for creepage in ((0.1, 0.3, 0.2), (0.0, 0.6, 0.0), (0.0, 0.0, 0.9)):
        assert_allclose(patch.steady(*creepage, start=other).forces, patch.steady(*creepage).forces, atol=1e-7)


@pytest.mark.parametrize("turned", [0.0, 0.4])
@pytest.mark.parametrize("creepage", [(0.1, 0.3, 0.2), (0.05, -0.2, 0.5), (0.0, 0.3, 0.2), (0.0, 0.4, 0.0)])
def test_gradient_is_that_of_the_forces(creepage, turned):
    """Against central differences; 1e-5 allows for cells that change between stick and slip within the step."""
    patch = iv.contact.RollingPatch(0.7, 0.3, turned, 14)
    state = patch.steady(*creepage, gradient=True)
    step = 1e-5
    differences = [
        (
            patch.steady(*(creepage + step * unit), start=state).forces
            - patch.steady(*(creepage - step * unit), start=state).forces
        )
        / (2.0 * step)
        for unit in np.eye(3)
    ]
    assert_allclose(state.gradient, np.transpose(differences), atol=1e-5)


def test_mirror_images():
    """Mirrored in the rolling direction, a patch has the longitudinal force of the other and the negative of the rest."""
    left, right = iv.contact.RollingPatch(0.5, 0.2, 0.6, 12), iv.contact.RollingPatch(0.5, 0.2, -0.6, 12)
    assert_allclose(right.steady(0.2, -0.3, -0.4).forces * [1, -1, -1], left.steady(0.2, 0.3, 0.4).forces, atol=1e-7)


def test_half_of_the_patch_serves_for_the_whole():
    """A longitudinal creepage too small to matter takes the equations of all cells; without it half of them are enough."""
    patch = iv.contact.RollingPatch(2.0, 0.3, 0.0, 14)
    assert_allclose(patch.steady(1e-12, 0.3, 0.2).forces, patch.steady(0.0, 0.3, 0.2).forces, atol=1e-8)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 4.0])
def test_both_aligned_limits_of_a_turned_patch(ratio):
    """Turned by a right angle, a patch is that of the inverse ratio; turned by little, it is nearly the one not turned."""
    creepage = (0.1, 0.2, 0.15)
    turned = iv.contact.RollingPatch(ratio, 0.3, np.pi / 2, 12).steady(*creepage)
    assert_allclose(
        turned.forces, iv.contact.RollingPatch(1.0 / ratio, 0.3, 0.0, 12).steady(*creepage).forces, atol=1e-7
    )
    near = iv.contact.RollingPatch(ratio, 0.3, 1e-7, 12).steady(*creepage)
    assert_allclose(near.forces, iv.contact.RollingPatch(ratio, 0.3, 0.0, 12).steady(*creepage).forces, atol=1e-6)


@pytest.mark.parametrize("turned", [0.0, 0.5])
@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5])
def test_full_slip_is_exactly_the_friction_limit(angle, turned):
    """To 1e-6 of mu N: the direction of slip varies by the displacements, which a creepage of 1000 leaves behind."""
    state = iv.contact.RollingPatch(0.4, 0.3, turned, 12).steady(1e3 * np.cos(angle), 1e3 * np.sin(angle))
    assert state.slip_share == 1.0
    assert_allclose([state.fx, state.fy], [np.cos(angle), np.sin(angle)], atol=1e-6)


def test_grid_shares_out_the_load():
    """The bounds of all cells add up to 1 on every grid, and their centre lies within a tenth of a cell of the middle."""
    for ratio, turned, cells in ((0.05, 0.0, 4), (1.0, 0.0, 20), (20.0, 1.0, 14)):
        grid = iv.contact.RollingPatch(ratio, 0.3, turned, cells).grid
        assert_allclose(np.sum(grid.area * grid.bound), 1.0, rtol=1e-14)
        assert abs(np.sum(grid.area * grid.bound * grid.x)) < 0.1 * np.max(grid.length)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"a_over_b": 0.01}, "a_over_b must be"),
        ({"a_over_b": 1.0, "poisson": 0.6}, "poisson must be"),
        ({"a_over_b": 1.0, "cells": 15}, "cells must be an even number from 4 to 60, got 15"),
        ({"a_over_b": 1.0, "turned": float("nan")}, "turned must be"),
    ],
)
def test_bad_patches(arguments, said):
    """One message that names the argument."""
    with pytest.raises(iv.ParameterError, match=said):
        iv.contact.RollingPatch(**arguments)


def test_bad_creepage():
    """Creepages must be finite."""
    with pytest.raises(iv.ParameterError, match="spin must be"):
        iv.contact.RollingPatch(1.0).steady(0.0, 0.1, float("inf"))
