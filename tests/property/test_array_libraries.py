"""One source of each formula for several array libraries: the standard's strict reference library, and JAX."""

from dataclasses import replace

import array_api_strict as strict
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from designs import amplifiers, elements, gearheads, laws, motors, seeds, states
from hypothesis import given
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.analysis import shaking
from internals import accumulated, shipped_study
from sampled import examples

jax.config.update("jax_enable_x64", True)

FIELDS = ("torque", "link_speed", "rolling_speed", "creep_speed", "power_in", "efficiency", "margin")


@given(elements(), seeds)
@examples(15)
def test_element_uses_only_the_standard(element, seed):
    """array-api-strict has nothing beyond the standard, and refuses to mix with NumPy: a slip would raise."""
    speed, angle, force = states(element, seed, largest_angle=1.3)
    expected = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    arrays = [strict.asarray(values) for values in (speed, angle, force)]
    point = element.operate(cylinder_speed=arrays[0], steering_angle=arrays[1], link_force=arrays[2])
    for field in FIELDS:
        assert_allclose(np.asarray(getattr(point, field)), getattr(expected, field), rtol=1e-13, atol=1e-13)
    held = element.operate(cylinder_speed=arrays[0], steering_angle=arrays[1], link_speed=arrays[2] * 0.001)
    assert held.link_force.shape == speed.shape
    steered = element.steer(cylinder_speed=arrays[0], link_speed=point.link_speed, link_force=arrays[2])
    again = element.steer(cylinder_speed=speed, link_speed=expected.link_speed, link_force=force)
    assert_allclose(np.asarray(steered), again, rtol=0, atol=1e-9)


@given(motors(), gearheads(), amplifiers(), elements(), seeds)
@examples(15)
def test_drives_use_only_the_standard(motor, gearhead, amplifier, element, seed):
    random = np.random.default_rng(seed)
    speed, force = random.uniform(-2, 2, 50), random.uniform(-1, 1, 50) * element.slip_force
    drives = (
        iv.ConventionalDrive(motor=motor, gearhead=gearhead, amplifier=amplifier, pulley=iv.parts.Pulley(radius=0.01)),
        iv.CoboticDrive(motor=motor, gearhead=gearhead, amplifier=amplifier, transmission=element, cylinder_speed=14.0),
    )
    for drive in drives:
        expected = drive.operate(speed=speed, force=force)
        point = drive.operate(speed=strict.asarray(speed), force=strict.asarray(force))
        assert_allclose(np.asarray(point.power_in), expected.power_in, rtol=1e-12)
        assert_allclose(np.asarray(point.efficiency), expected.efficiency, rtol=1e-12)
        assert_allclose(np.asarray(point.margin), expected.margin, rtol=1e-12)


@given(elements(), seeds)
@examples(3)
def test_jit_and_vmap_agree_with_numpy(element, seed):
    speed, angle, force = states(element, seed, largest_angle=1.2)
    expected = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)

    def solve(speed, angle, force):
        point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
        return tuple(getattr(point, field) for field in FIELDS)

    for compiled in (jax.jit(solve), jax.jit(jax.vmap(solve))):
        for field, found in zip(FIELDS, compiled(speed, angle, force), strict=True):
            assert_allclose(found, getattr(expected, field), rtol=1e-9, atol=1e-9, err_msg=field)


@pytest.mark.slow
@given(elements(largest_h=0.01, smallest_k=100.0), laws, seeds)
@examples(2)  # each compiles four derivatives
def test_gradients_agree_with_differences(element, law, seed):
    """Exact derivatives of the steering angle and the input power, by load and by speed, well inside slip."""
    element = replace(element, creep_law=law)
    random = np.random.default_rng(seed)
    omega = 14.0
    speeds = random.uniform(0.2, 1.5, 20) * element.cylinder_radius * omega
    forces = random.uniform(0.1, 0.35, 20) * element.slip_force

    def angle(speed, force):
        return element.steer(cylinder_speed=omega, link_speed=speed, link_force=force)

    def power_in(speed, force):
        return element.deliver(cylinder_speed=omega, link_speed=speed, link_force=force).power_in

    for function in (angle, power_in):
        exact = jax.jit(jax.vmap(jax.grad(function, argnums=(0, 1))))(speeds, forces)
        step = 1e-6
        differences = (
            (function(speeds * (1 + step), forces) - function(speeds * (1 - step), forces)) / (2 * step * speeds),
            (function(speeds, forces * (1 + step)) - function(speeds, forces * (1 - step))) / (2 * step * forces),
        )
        for derivative, difference in zip(exact, differences, strict=True):
            # Central differences in float64 with a relative step of 1e-6 keep about seven digits.
            assert_allclose(derivative, difference, rtol=1e-5, atol=1e-7 * np.max(np.abs(difference)))


@pytest.mark.slow
def test_gradient_by_a_design_parameter(element):
    """Validation lets traced values through, so designs can be differentiated."""

    def power_in(preload):
        return replace(element, preload=preload).deliver(cylinder_speed=14.0, link_speed=0.3, link_force=30.0).power_in

    step = 1e-3
    difference = (power_in(element.preload + step) - power_in(element.preload - step)) / (2 * step)
    assert float(jax.jit(jax.grad(power_in))(element.preload)) == pytest.approx(float(difference), rel=1e-5)


def test_mixed_libraries_are_refused(element):
    with pytest.raises(TypeError, match="mixed"):
        element.steer(cylinder_speed=strict.asarray(14.0), link_speed=jax.numpy.asarray(0.1), link_force=1.0)


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_inverse_dynamics_uses_only_the_standard(name):
    drive, course = shipped_study("faulring2006").drives[name], shaking(0.02, 3.0, 200)
    if name == "cobotic":  # a contact from geometry is NumPy's
        measured = {"creep_stiffness": 17e3, "rolling_torque": 1e-3, "bearing_torque": 1e-3}
        drive = replace(
            drive,
            transmission=replace(drive.transmission, geometry=None, **measured),
            steering=replace(drive.steering, patch_half_length=5e-4, bell_bearing=None, bell_friction=2e-5),
        )
    expected = drive.follow(course, load_mass=0.8)
    arrays = iv.motion.Course(
        **{what: strict.asarray(getattr(course, what)) for what in ("speed", "acceleration", "jerk", "snap")}
    )
    point = drive.follow(arrays, load_mass=0.8)
    assert_allclose(np.asarray(point.power_in), expected.power_in, rtol=1e-12)
    for what, loss in point.losses.items():
        assert_allclose(np.asarray(loss), expected.losses[what], rtol=1e-9, atol=1e-15)


@pytest.mark.slow
def test_energy_of_a_cycle_has_a_gradient():
    """Power from the supply by the bell's inertia and the link's mass, compiled by JAX, against differences."""
    drive, course = shipped_study("faulring2006").drives["cobotic"], shaking(0.02, 8.0, 400)

    def power(bell, link, xp):
        changed = replace(drive, link_mass=link, steering=replace(drive.steering, bell_inertia=bell))
        arrays = iv.motion.Course(
            **{what: xp.asarray(getattr(course, what)) for what in ("speed", "acceleration", "jerk", "snap")}
        )
        return xp.mean(changed.follow(arrays, load_mass=0.8).power_in)

    at = (drive.steering.bell_inertia, drive.link_mass)
    found = jax.jit(jax.grad(lambda pair: power(*pair, jax.numpy)))(at)
    for index, slope in enumerate(found):
        step = 1e-4 * at[index]
        ends = [
            power(*(value + (sign * step if k == index else 0.0) for k, value in enumerate(at)), np) for sign in (-1, 1)
        ]
        assert slope == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 8, 33])
def test_accumulated_is_one_after_the_other(count):
    """Affine maps, whose order matters, in pairs, as a loop in JAX, and one by one."""
    random = np.random.default_rng(count)
    slope, offset = random.normal(size=(2, 3, count))

    def after(xp, first, second):
        return second[0] * first[0], second[0] * first[1] + second[1]

    expected = [(slope[:, 0], offset[:, 0])]
    for place in range(1, count):
        expected.append(after(np, expected[-1], (slope[:, place], offset[:, place])))
    for xp in (np, jnp, strict):
        found = accumulated(xp, after, (xp.asarray(slope), xp.asarray(offset)))
        for part, ways in zip(found, zip(*expected, strict=True), strict=True):
            assert_allclose(np.asarray(part), np.stack(ways, axis=-1), rtol=1e-12)
