"""The creep law of exact theory on any patch: its shape as a curve, its inverse, and the wheels that use it."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from designs import seeds
from hypothesis import given
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar.contact import creep, exact_law, kalker
from internals import shipped_study
from sampled import examples

jax.config.update("jax_enable_x64", True)


def patches(seed, size=300):
    """Shapes and Poisson's ratios over the whole range."""
    random = np.random.default_rng(seed)
    return np.exp(random.uniform(np.log(0.05), np.log(20.0), size)), random.uniform(0.0, 0.5, size)


@given(seeds)
@examples(10)
def test_monotone_and_concave_on_every_patch(seed):
    """As the solver's curves are; with slope 1 at the start and slip at the creepage of theory."""
    a_over_b, poisson = patches(seed)
    full = kalker.full_slip_creepage(a_over_b, poisson, kalker.coefficients(a_over_b, poisson).c22)
    k = np.linspace(0.0, 1.0, 400)[:, None] * full / 3.0
    force = creep.lateral_force("exact", k, a_over_b, poisson)
    rise = np.diff(force, axis=0)
    assert np.all(rise > 0)
    assert np.all(np.diff(rise, axis=0) < 0)
    assert_array_equal(force[0], 0.0)
    assert_allclose(force[-1], 1.0, rtol=1e-15)
    assert_array_equal(creep.lateral_force("exact", -k, a_over_b, poisson), -force)
    small = 1e-9
    assert_allclose(creep.lateral_force("exact", small, a_over_b, poisson), 3.0 * small, rtol=1e-7)


@given(seeds)
@examples(10)
def test_inverse_and_slope_on_every_patch(seed):
    a_over_b, poisson = patches(seed)
    random = np.random.default_rng(seed)
    ratio = random.choice([-1, 1], 300) * np.where(random.random(300) < 0.5, 1.0, 10 ** random.uniform(-12, 0, 300))
    ratio = ratio * random.uniform(0.0, 1.0, 300)
    k = creep.lateral_creep("exact", ratio, a_over_b, poisson)
    assert_allclose(creep.lateral_force("exact", k, a_over_b, poisson), ratio, rtol=1e-11, atol=0)
    again = creep.lateral_creep("exact", creep.lateral_force("exact", k, a_over_b, poisson), a_over_b, poisson)
    formulas = creep.EXACT.on(a_over_b, poisson)
    assert np.all(np.abs(again - k) <= 1e-11 * (np.abs(k) + np.abs(ratio) * formulas.slope(ratio)))
    inner, step = np.clip(ratio, -0.99, 0.99), 1e-6
    difference = (formulas.creepage(inner + step) - formulas.creepage(inner - step)) / (2 * step)
    assert_allclose(formulas.slope(inner), difference, rtol=1e-6)


@given(seeds)
@examples(5)
def test_response(seed):
    """Force and derivative together are those of the separate formulas; flat from full slip."""
    a_over_b, poisson = patches(seed)
    formulas = creep.EXACT.on(a_over_b, poisson)
    creepage = np.random.default_rng(seed).uniform(-0.99, 0.99, 300) * formulas.slip_creepage
    force, rise = formulas.responding(creepage)
    assert_allclose(force, formulas.force(creepage), rtol=0, atol=1e-14)
    assert_allclose(rise * formulas.slope(force), 1.0, rtol=1e-6)
    force, rise = formulas.responding(-1.5 * formulas.slip_creepage)
    assert_array_equal(force, -1.0)
    assert np.all((rise > 0) & (rise < 1e-9))
    assert creep.POLACH.on(1.0, 0.3).responding(0.5) == (
        creep.POLACH.force(0.5),
        1.0 / creep.POLACH.slope(creep.POLACH.force(0.5)),
    )


def test_the_assumed_patch():
    """A patch that nothing is known of is a circle of steel; its slip is where theory has it."""
    by_hand = 1.5 * float(kalker.coefficients(1.0, 0.3).c22) * (0.5 * 0.7 + 0.375 * 0.3)
    assert pytest.approx(by_hand, rel=1e-14) == exact_law.STEEL_CIRCLE_SLIP
    assert exact_law.steel_circle().full_slip == pytest.approx(by_hand, rel=1e-14)
    k = np.linspace(-1.0, 1.0, 50)
    assert_allclose(creep.lateral_force("exact", k), creep.EXACT.force(3.0 * k), rtol=1e-13)
    assert creep.EXACT.on(1.0, 0.3).slip_creepage == pytest.approx(creep.EXACT.slip_creepage, rel=1e-14)


def test_beyond_the_fitted_range_the_end_serves():
    k = np.linspace(0.0, 1.0, 50)
    for beyond, end in ((0.01, 0.05), (60.0, 20.0)):
        assert_array_equal(creep.lateral_force("exact", k, beyond), creep.lateral_force("exact", k, end))
    with pytest.raises(ValueError, match="a_over_b must be > 0"):
        creep.lateral_force("exact", 0.1, 0.0)
    with pytest.raises(ValueError, match=r"poisson must be >= 0 and <= 0\.5"):
        creep.lateral_force("exact", 0.1, 1.0, 0.6)


@pytest.mark.slow  # JAX compiles for some seconds
def test_traced_patches():
    """jax.grad by shape and Poisson's ratio agrees with differences."""

    def force(k, a_over_b, poisson):
        return creep.lateral_force("exact", k, a_over_b, poisson)

    at = (0.4, 0.7, 0.25)
    value, found = jax.jit(jax.value_and_grad(force, argnums=(0, 1, 2)))(*at)
    step = 1e-6
    for i, slope in enumerate(found):
        more, less = ([value + way * step * (i == j) for j, value in enumerate(at)] for way in (1, -1))
        assert float(slope) == pytest.approx(float(force(*more) - force(*less)) / (2 * step), rel=1e-6)
    assert value == pytest.approx(float(force(*at)), rel=1e-13)


def element(crown=None):
    """The shipped wheel, with another crown if wanted."""
    found = replace(shipped_study("faulring2006").drives["cobotic"].transmission, creep_law="exact")
    return found if crown is None else replace(found, geometry=replace(found.geometry, crown_radius=crown))


def test_a_wheel_uses_the_law_of_its_patch():
    """Creepage at a force, by hand from the shape that its geometry gives."""
    for crown in (0.005, 0.2):
        wheel = element(crown)
        contact = wheel.contact
        point = wheel.operate(cylinder_speed=14.0, steering_angle=0.2, link_force=40.0)
        ratio = abs(point.lateral_force) / wheel.slip_force
        k = creep.lateral_creep("exact", ratio, contact.axis_ratio, contact.poisson)
        stiffness = wheel.groups(14.0).steered(np.sin(0.2) ** 2).creep_stiffness
        creepage = 3.0 * k * wheel.slip_force / stiffness
        assert abs(point.creep_speed / point.rolling_speed) == pytest.approx(float(creepage), rel=1e-12)
        # and by the force that this creepage gives back, and the steering angle for the motion
        back = wheel.operate(cylinder_speed=14.0, steering_angle=0.2, link_speed=point.link_speed)
        assert back.link_force == pytest.approx(40.0, rel=1e-9)
        angle = wheel.steer(cylinder_speed=14.0, link_speed=point.link_speed, link_force=40.0)
        assert angle == pytest.approx(0.2, rel=1e-9)
    a_over_b = [element(crown).contact.axis_ratio for crown in (0.005, 0.2)]
    assert max(a_over_b) > 2.0 * min(a_over_b)


@pytest.mark.parametrize("study", ["hand_controller", "knee_walking", "ankle_walking"])
def test_the_shape_of_a_steered_patch_hardly_matters(study):
    """Crowned wheels have another patch when steered; its law differs by 0.0013 at 45 degrees."""
    wheel = iv.load_study(study).drives["cobotic"].transmission
    k = np.linspace(0.0, 1.0, 100)
    straight, steered = (
        wheel.geometry.press(
            wheel_radius=wheel.wheel_radius,
            cylinder_radius=wheel.cylinder_radius,
            preload=wheel.preload,
            steering_angle=angle,
        )
        for angle in (0.0, np.pi / 4)
    )
    assert abs(steered.axis_ratio / straight.axis_ratio - 1.0) > 0.05
    one, other = (creep.lateral_force("exact", k, of.axis_ratio, of.poisson) for of in (straight, steered))
    assert np.max(np.abs(one - other)) < 0.0013


@pytest.mark.slow
def test_steering_angles_compile():
    """jax.jit of the steering angle for a motion, the iteration along the curve, with its derivative by load."""
    wheel = element()

    def angle(speed, force):
        return wheel.steer(cylinder_speed=14.0, link_speed=speed, link_force=force)

    speed, force = np.array([0.3, -0.1, 0.5]), np.array([40.0, 30.0, -60.0])
    found, slope = jax.jit(jax.vmap(jax.value_and_grad(angle, argnums=1)))(speed, force)
    assert_allclose(found, angle(speed, force), rtol=1e-12)
    step = 1e-4
    assert_allclose(slope, (angle(speed, force + step) - angle(speed, force - step)) / (2 * step), rtol=1e-6)


def test_measured_values_stand_on_a_circle():
    wheel = element()
    groups = wheel.groups(14.0)
    measured = replace(
        wheel,
        geometry=None,
        **{name: getattr(groups, name) for name in ("creep_stiffness", "rolling_torque", "bearing_torque")},
    )
    assumed = measured.groups(14.0)
    assert (assumed.axis_ratio, assumed.poisson) == (1.0, 0.3)
    point = measured.operate(cylinder_speed=14.0, steering_angle=0.2, link_force=40.0)
    ratio = abs(point.lateral_force) / wheel.slip_force
    creepage = creep.EXACT.creepage(ratio) / measured.groups(14.0).creep_group
    assert abs(point.creep_speed / point.rolling_speed) == pytest.approx(float(creepage), rel=1e-12)


@given(seeds)
@examples(10)
def test_passive_in_four_quadrants(seed):
    random = np.random.default_rng(seed)
    wheel = element(float(10 ** random.uniform(-2.5, -0.5)))
    speed, angle = random.choice([-1, 1], 400) * 14.0, random.uniform(-1.5, 1.5, 400)
    force = random.uniform(-1.2, 1.2, 400) * wheel.slip_force
    points = (
        wheel.operate(cylinder_speed=speed, steering_angle=angle, link_force=force),
        wheel.operate(cylinder_speed=speed, steering_angle=angle, link_speed=random.uniform(-1, 1, 400)),
        wheel.deliver(cylinder_speed=speed, link_speed=random.uniform(-0.5, 0.5, 400), link_force=force),
    )
    for point in points:
        moves = np.isfinite(point.power_in)
        lost = sum(point.losses.values())
        assert moves.any()
        assert np.all(point.losses["creep"][moves] >= 0)
        assert_allclose((point.power_in - point.power_out)[moves], lost[moves], rtol=1e-9, atol=1e-9)


def softer(a_over_b, poisson):
    """An own law that depends on the patch: xi = x + k x|x|, softer on slender patches."""
    k = 0.25 + 0.05 * a_over_b

    def force(xi):
        size = np.minimum(np.abs(xi), 1.0 + k)
        return np.sign(xi) * 2.0 * size / (1.0 + np.sqrt(1.0 + 4.0 * k * size))

    return creep.Formulas(
        creepage=lambda x: x + k * x * np.abs(x),
        slope=lambda x: 1.0 + 2.0 * k * np.abs(x),
        force=force,
        slip_creepage=1.0 + k,
    )


def own(**changes):
    usual = dict(zip(("creepage", "slope", "force", "slip_creepage"), softer(1.0, 0.3), strict=False))
    return creep.CreepLaw(**{"name": "softer", "on_patch": softer, **usual, **changes})


def test_own_laws_may_depend_on_the_patch():
    law = own()
    wheel = replace(element(), creep_law=law)
    point = wheel.operate(cylinder_speed=14.0, steering_angle=0.0, link_force=40.0)
    ratio = float(abs(point.lateral_force) / wheel.slip_force)
    k = 0.25 + 0.05 * wheel.contact.axis_ratio
    expected = (ratio + k * ratio**2) / wheel.groups(14.0).creep_group
    assert abs(point.creep_speed / point.rolling_speed) == pytest.approx(expected, rel=1e-12)
    with pytest.raises(ValueError, match="on_patch must be a function or None, got 3"):
        own(on_patch=3)
    with pytest.raises(ValueError, match="slope must be the derivative of creepage"):
        own(on_patch=lambda a_over_b, poisson: softer(a_over_b, poisson)._replace(slope=lambda x: 1.0 + 0.0 * x))


def test_pinned_to_one_patch():
    """A law of one patch by itself, as fits to measured values need it; other laws stay what they are."""
    law = creep.pinned(creep.EXACT, 0.3, 0.25)
    x = np.linspace(-1.0, 1.0, 21)
    assert_array_equal(law.creepage(x), creep.EXACT.on(0.3, 0.25).creepage(x))
    assert law.on(5.0, 0.1).slip_creepage == law.slip_creepage
    assert creep.pinned(creep.POLACH, 0.3, 0.25) is creep.POLACH


@pytest.mark.slow
@pytest.mark.parametrize("crown", [None, 0.2])
def test_simulated_creep_is_the_laws(crown):
    """A locked link under a push creeps at each instant as the law of its patch says; the equations have their own copy."""
    drive = replace(shipped_study("faulring2006").drives["cobotic"], transmission=element(crown))
    wheel = drive.transmission
    push = iv.motion.StepForce(size=-0.6 * wheel.slip_force, start=0.02)
    run = iv.simulate(drive, iv.Scenario(duration=0.1, steering="locked", load_mass=0.8, force=push))
    assert run.complete
    contact = ("transmission.lateral", "transmission.creep")
    force, creep_speed = run.trajectory.efforts[contact], run.trajectory.flows[contact]
    assert np.max(np.abs(force)) > 0.5 * wheel.slip_force
    groups = wheel.groups(drive.cylinder_speed)
    creepage = creep_speed / (wheel.cylinder_radius * drive.cylinder_speed) * groups.creep_group
    expected = wheel.slip_force * groups.formulas(wheel.creep_law).force(creepage)
    assert_allclose(force, expected, rtol=0, atol=1e-3 * wheel.slip_force)
