"""The map of lateral creep with spin: against the solver, limits, symmetry, dissipation, gradients and inverse."""

import math
from concurrent.futures import ThreadPoolExecutor
from importlib import resources

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
import tabulate_spin as tabulate
from infinivar.contact import kalker, spin
from internals import spin_maps as spin_map
from sampled import sampled

RNG_SEED = 31


def _creepages(rng, patch, count):
    """Lateral creepage and spin in all quadrants, from a thousandth of the slip limit to ten times it."""
    size = np.exp(rng.uniform(np.log(3e-3), np.log(30.0), (2, count))) * rng.choice([-1.0, 1.0], (2, count))
    return size[0] / patch.scale.c22, size[1] / (patch.scale.c22 * patch.scale.lever)


def _patches(rng, count):
    return [
        (float(np.exp(rng.uniform(np.log(0.05), np.log(20.0)))), float(rng.uniform(0.0, 0.5))) for _ in range(count)
    ]


def _errors(rng, low, high, count):
    """Errors of force and of moment over the lever at random points, against the solver's extrapolated value."""
    errors = []
    for _ in range(count):
        ratio, poisson = float(np.exp(rng.uniform(np.log(low), np.log(high)))), float(rng.uniform(0.0, 0.5))
        patch = iv.contact.spin_map(ratio, poisson)
        u, alpha = rng.uniform(0.02, 0.97), rng.uniform(-math.pi, math.pi)
        rho = spin_map.HALF * u / (1.0 - u) / patch.scale.c22
        lateral, turn = rho * math.cos(alpha), rho * math.sin(alpha) / patch.scale.lever
        off = np.abs(np.array(patch.forces(lateral, turn)) - tabulate.solved(ratio, poisson, lateral, turn))
        errors.append(off / [1.0, patch.scale.lever])
    return np.array(errors)


@pytest.mark.slow
def test_against_the_solver():
    """Within 0.008 of mu N, and 0.01 of mu N times the lever, between the nodes of the table."""
    errors = _errors(np.random.default_rng(RNG_SEED), 0.05, 20.0, 30)
    assert np.all(np.max(errors, axis=0) < [0.008, 0.01])
    assert np.sqrt(np.mean(errors**2)) < 0.002


@pytest.mark.parametrize(
    "share", [pytest.param(0.1, marks=pytest.mark.slow), pytest.param(1.0, marks=pytest.mark.full)]
)
@sampled(
    ("low", "high", "force", "moment"),
    [(0.05, 0.2, 0.006, 0.008), (0.2, 1.0, 0.008, 0.004), (1.0, 5.0, 0.008, 0.005), (5.0, 20.0, 0.008, 0.010)],
    slow=2,
)
def test_errors_of_the_documentation(low, high, force, moment, share):
    """The table of the contact page, by the ratio of the semi-axes, and the first of its points."""
    count = int(share * (300 if high <= 5.0 else 100))  # the solver takes longest for slender patches
    errors = _errors(np.random.default_rng(RNG_SEED + 1), low, high, count)
    assert np.max(errors[:, 0]) < force
    assert np.max(errors[:, 1]) < moment


@pytest.mark.slow
def test_a_sample_of_the_table_is_what_the_solver_finds():
    """Nodes of the stored table, computed anew; 1e-6 for its single precision, 0.005 with what is added for slender ones."""
    rng = np.random.default_rng(RNG_SEED)
    for _ in range(6):
        ratio, poisson = float(rng.choice(spin_map.A_OVER_B)), float(rng.choice(spin_map.POISSON))
        i, j = int(rng.integers(spin_map.SIZES - 1)), int(rng.integers(spin_map.ANGLES))
        u, alpha = (i + 1) / spin_map.SIZES, j * math.pi / spin_map.ANGLES
        patch = iv.contact.spin_map(ratio, poisson)
        rho = spin_map.HALF * u / (1.0 - u) / patch.scale.c22
        lateral, turn = rho * math.cos(alpha), rho * math.sin(alpha) / patch.scale.lever
        found = tabulate.solved(ratio, poisson, lateral, turn)
        room = 5e-3 if ratio > tabulate.SLENDER else 1e-6
        assert_allclose(patch.forces(lateral, turn), found, atol=room * patch.scale.lever)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [spin_map.A_OVER_B[0], spin_map.A_OVER_B[5], spin_map.A_OVER_B[-1]])
def test_the_stored_table_is_what_its_generator_makes(ratio):
    """Nodes of the file as the generator makes them, what is added for slender patches and full slip included."""
    with np.load(resources.files("infinivar.contact") / "data" / "spin_map.npz") as stored:
        values = stored["values"]
    rng, place = np.random.default_rng(RNG_SEED), spin_map.A_OVER_B.index(ratio)
    rows = [*rng.integers(spin_map.SIZES - 1, size=2), spin_map.SIZES - 1]
    for i in map(int, rows):
        j, number = int(rng.integers(1, spin_map.ANGLES)), int(rng.integers(len(spin_map.POISSON)))
        found = tabulate.node(ratio, spin_map.POISSON[number], i, j)
        assert_allclose(values[place, number, i, j], found, atol=1e-6)  # its single precision


def test_the_generator_writes_the_stored_file(tmp_path, monkeypatch):
    """A run that was interrupted goes on and writes the file; of the patch that it lacks, some nodes are computed."""
    with np.load(tabulate.FILE) as stored:
        values = stored["values"]
    (folder := tmp_path / "parts").mkdir()
    for place in np.ndindex(values.shape[:2]):
        if place != (6, 1):
            np.save(folder / f"{place[0]}_{place[1]}.npy", values[place])

    def table(a_over_b, poisson):
        made = values[6, 1].astype(float)
        for i, j in ((3, 5), (20, 30), (spin_map.SIZES - 1, 7)):
            made[i, j] = tabulate.node(a_over_b, poisson, i, j)
        return made

    monkeypatch.setattr(tabulate, "table", table)
    monkeypatch.setattr(tabulate, "ProcessPoolExecutor", lambda processes: ThreadPoolExecutor(processes))
    tabulate.main(["--processes", "1", "--parts", str(folder), "--to", str(tmp_path / "made.npz")])
    with np.load(tabulate.FILE) as stored, np.load(tmp_path / "made.npz") as made:
        assert sorted(made) == sorted(stored)
        for name in stored:
            assert made[name].dtype == stored[name].dtype
            assert_allclose(made[name], stored[name], atol=1e-6)  # its single precision


def test_friction_takes_power_everywhere():
    """200,000 random points in all quadrants."""
    rng = np.random.default_rng(RNG_SEED)
    for ratio, poisson in _patches(rng, 40):
        patch = iv.contact.spin_map(ratio, poisson)
        lateral, turn = _creepages(rng, patch, 5000)
        force, moment = patch.forces(lateral, turn)
        assert np.min(force * lateral + moment * turn) >= 0.0
        assert np.max(np.abs(force)) < 1.003
        assert np.max(np.abs(moment)) < 1.001 * spin.ellipse_moment(1.0, ratio**0.5, ratio**-0.5, 1.0)


def test_both_creepages_reversed_reverse_both_forces():
    """Mirrored in the rolling direction, it is the same patch."""
    rng = np.random.default_rng(RNG_SEED)
    for ratio, poisson in _patches(rng, 5):
        patch = iv.contact.spin_map(ratio, poisson)
        lateral, turn = _creepages(rng, patch, 200)
        assert_allclose(np.array(patch.forces(-lateral, -turn)), -np.array(patch.forces(lateral, turn)), atol=1e-13)


def test_small_creepages_are_those_of_the_linear_theory():
    """To first order exactly with the package's coefficients."""
    rng = np.random.default_rng(RNG_SEED)
    for ratio, poisson in [*_patches(rng, 5), (0.05, 0.0), (20.0, 0.5)]:
        linear = kalker.coefficients(ratio, poisson)
        _, gradient = iv.contact.spin_map(ratio, poisson).forces_and_gradient(0.0, 0.0)
        expected = (linear.c22, linear.c23, -linear.c23, linear.c33)
        assert_allclose(gradient, expected, rtol=1e-12)
        small = 1e-7
        assert_allclose(iv.contact.spin_map(ratio, poisson).forces(small, 0.0).fy, linear.c22 * small, rtol=1e-5)


@pytest.mark.parametrize("ratio", [0.05, 0.4, 1.0, 7.0, 20.0])
def test_full_slip(ratio):
    """Lateral slip gives mu N, turning on the spot the moment of a rigid patch; both lie within 1e-4 of the limit."""
    patch = iv.contact.spin_map(ratio, 0.3)
    assert_allclose(patch.forces(1e6, 0.0), (1.0, 0.0), atol=1e-4)
    spot = spin.ellipse_moment(1.0, ratio**0.5, ratio**-0.5, 1.0)
    found = patch.forces(0.0, 1e8)
    assert_allclose((found.fy, found.mz / spot), (0.0, 1.0), atol=1e-4)


def test_gradient():
    """Against central differences, and continuous where half a turn begins."""
    rng = np.random.default_rng(RNG_SEED)
    for ratio, poisson in _patches(rng, 4):
        patch = iv.contact.spin_map(ratio, poisson)
        lateral, turn = _creepages(rng, patch, 300)
        _, gradient = patch.forces_and_gradient(lateral, turn)
        step = 1e-5 * np.abs(lateral)
        ahead, behind = patch.forces(lateral + step, turn), patch.forces(lateral - step, turn)
        assert_allclose((ahead.fy - behind.fy) / (2 * step), gradient.fy_by_lateral, atol=1e-6 * patch.scale.c22)
        assert_allclose((ahead.mz - behind.mz) / (2 * step), gradient.mz_by_lateral, rtol=1e-5, atol=1e-5)
        step = 1e-5 * np.abs(turn)
        ahead, behind = patch.forces(lateral, turn + step), patch.forces(lateral, turn - step)
        assert_allclose((ahead.fy - behind.fy) / (2 * step), gradient.fy_by_spin, rtol=1e-5, atol=1e-5)
        assert_allclose((ahead.mz - behind.mz) / (2 * step), gradient.mz_by_spin, rtol=1e-5, atol=1e-5)
        sides = [patch.forces_and_gradient(side * 1e-12, 0.7) for side in (-1.0, 1.0)]
        assert_allclose(np.concatenate(sides[0]), np.concatenate(sides[1]), atol=1e-8)


def test_inverse():
    """The creepage that a force needs, to 1e-10; within 1 % of full slip, where the map is flat, another than it came from."""
    rng = np.random.default_rng(RNG_SEED)
    for ratio, poisson in _patches(rng, 8):
        patch = iv.contact.spin_map(ratio, poisson)
        lateral, turn = _creepages(rng, patch, 400)
        force = patch.forces(lateral, turn).fy
        found = patch.lateral_creepage(force, turn)
        inside = np.abs(force) < 1.0
        assert np.all(np.isfinite(found[inside]))
        assert_allclose(patch.forces(found, turn).fy[inside], force[inside], atol=1e-10)
        clear = np.abs(force) < 0.99
        assert_allclose(found[clear], lateral[clear], rtol=1e-6, atol=1e-9)


def test_no_creepage_gives_more_than_full_slip():
    """nan beyond full slip, and for nan."""
    patch = iv.contact.spin_map(0.7, 0.3)
    found = patch.lateral_creepage(np.array([1.0, -1.2, np.nan, np.inf, 0.2]), np.array([0.0, 0.3, 0.1, 0.0, np.nan]))
    assert np.all(np.isnan(found))


def test_force_rises_with_creepage():
    """At any spin, up to errors of the table near full slip: 0.006 of the initial slope, 0.03 for slender patches."""
    rng = np.random.default_rng(RNG_SEED)
    for ratio, poisson in _patches(rng, 20):
        patch = iv.contact.spin_map(ratio, poisson)
        _, gradient = patch.forces_and_gradient(*_creepages(rng, patch, 1000))
        assert np.min(gradient.fy_by_lateral) > -(0.03 if ratio > 4.0 else 0.006) * patch.scale.c22


def test_arrays_of_shapes():
    """One value for each shape is what each shape gives alone."""
    ratios, poissons = np.array([0.06, 0.9, 11.0]), np.array([0.0, 0.31, 0.5])
    lateral, turn = np.array([0.3, -0.2, 0.1]), np.array([0.1, 0.4, -0.2])
    together = spin_map.forces(lateral, turn, ratios, poissons)
    alone = [spin_map.forces(*one) for one in zip(lateral, turn, ratios.tolist(), poissons.tolist(), strict=True)]
    assert_allclose(np.array(together).T, np.array(alone), atol=1e-13)


@pytest.mark.full
def test_jax():
    """Values, gradient and the derivative of the inverse, for shapes that are traced as well; nan out of range."""
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    patch = iv.contact.spin_map(0.6, 0.3)
    creepage = patch.lateral_creepage(0.4, 0.3)
    _, gradient = patch.forces_and_gradient(creepage, 0.3)
    by_force, by_spin = jax.grad(patch.lateral_creepage, argnums=(0, 1))(0.4, 0.3)
    assert_allclose(by_force, 1.0 / gradient.fy_by_lateral, rtol=1e-9)
    assert_allclose(by_spin, -gradient.fy_by_spin / gradient.fy_by_lateral, rtol=1e-9)
    at = jax.jit(lambda ratio: spin_map.forces(creepage, 0.3, ratio, 0.3).mz)
    assert_allclose(at(0.6), patch.forces(creepage, 0.3).mz, rtol=1e-12)
    assert math.isnan(at(21.0))
    slopes = jax.grad(lambda lateral, turn: patch.forces(lateral, turn).fy, argnums=(0, 1))(0.0, 0.0)
    assert_allclose(slopes, patch.forces_and_gradient(0.0, 0.0)[1][:2], rtol=1e-12)


@pytest.mark.parametrize(
    ("ratio", "poisson", "message"),
    [(0.04, 0.3, "a_over_b must be .* got 0.04"), (1.0, 0.6, "poisson must be .* got 0.6")],
)
def test_out_of_range(ratio, poisson, message):
    with pytest.raises(iv.ParameterError, match=message):
        iv.contact.spin_map(ratio, poisson)


def test_large_creepages():
    """The inverse up to turning on the spot, and infinite creepages."""
    patch = iv.contact.spin_map(1.0, 0.3)
    spin = np.array([0.0, 1.0, 1e3, 1e6, 1e8])
    assert_allclose(patch.forces(patch.lateral_creepage(0.5, spin), spin).fy, 0.5, atol=1e-9)
    assert_allclose(patch.lateral_creepage(0.5, 1e8) / 1e8, patch.on_the_spot(0.5)[0], rtol=1e-6)
    assert_allclose(patch.forces(np.inf, 0.0).fy, 1.0, atol=1e-9)
    assert_allclose(patch.forces(0.0, np.inf), patch.forces(0.0, 1e12), atol=1e-9)
