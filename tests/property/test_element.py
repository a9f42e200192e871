"""Properties of the rolling-contact element that hold for every machine, in all four quadrants."""

from dataclasses import replace

import numpy as np
import pytest
from designs import POINTS, elements, laws, seeds, states
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from infinivar import Limit, power
from internals import contact_balance, relative_velocities

ROUNDING = 1e-12
"""Of the power or speed at hand: a few hundred float64 roundings, with the creep a thousandth of the rolling speed."""


def within_limits(point, least=0.5):
    """Where a point is within limits, which must be at more than a share of the points, or nothing is tested there."""
    ok = point.limit == Limit.OK
    assert ok.mean() > least, f"only {ok.mean():.0%} of the points are within limits"
    return ok


def assert_passive(point):
    """Every loss is at least zero, and together they are what goes in and does not come out."""
    scale = np.maximum(np.abs(point.power_in), np.abs(point.power_out))
    for name, loss in point.losses.items():
        assert np.all((loss >= -ROUNDING * scale) | np.isnan(loss)), name
    known = ~np.isnan(point.power_in)
    assert np.all(power.residual(point.power_in, point.power_out, point.losses)[known] < ROUNDING)


@given(elements(), seeds)
def test_passive_and_closed_at_prescribed_force(element, seed):
    speed, angle, force = states(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    assert_passive(point)
    # Beyond slip by force there is no motion; beyond it by creepage alone (Eq 17) there is one, and it is audited, too.
    assert np.all((point.limit == Limit.SLIP)[np.isnan(point.power_in)])
    assert np.mean(~np.isnan(point.power_in)) > 0.9  # the points are drawn up to slip: nearly all must roll


@given(elements(), seeds)
def test_passive_and_closed_at_prescribed_speed(element, seed):
    """Gross sliding included: most link speeds drawn here are far from what the wheel is steered for."""
    speed, angle, _ = states(element, seed)
    surface = element.cylinder_radius * speed
    link = -surface * np.tan(angle) + np.random.default_rng(seed).normal(0, 0.01, POINTS) * surface
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_speed=link)
    assert_passive(point)
    assert np.all(np.abs(point.lateral_force) <= element.slip_force * (1 + ROUNDING))


@pytest.mark.source("faulring2006", "Eq 3", "Eq 4", "Eq 5", "Eq 6")
@given(elements(), seeds)
def test_satisfies_kinematics_and_balance(element, seed):
    """The explicit solution is one of Eqs 3 to 6, evaluated independently."""
    speed, angle, force = states(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = within_limits(point)
    surface = element.cylinder_radius * speed
    u, v = relative_velocities(point.link_speed, surface, np.cos(angle), np.sin(angle))
    scale = np.abs(surface) + np.abs(point.link_speed)
    assert np.all(np.abs(u - point.creep_speed)[ok] <= ROUNDING * scale[ok])
    assert np.all(np.abs(v - point.rolling_speed)[ok] <= ROUNDING * scale[ok])
    rolling = np.sign(point.rolling_speed) * element.groups(speed).rolling_force
    tau, fl = contact_balance(point.lateral_force, rolling, np.cos(angle), np.sin(angle), element.cylinder_radius)
    assert_allclose(fl[ok], force[ok], rtol=0, atol=ROUNDING * element.slip_force)
    assert_allclose(tau[ok], point.torque[ok], rtol=0, atol=ROUNDING * element.slip_force * element.cylinder_radius)


@pytest.mark.source("faulring2006", "Eq 8", "Eq 13", "Eq 14")
@given(elements(law=st.just("linear")), seeds)
def test_losses_are_those_of_the_velocities(element, seed):
    """Creep loses (|v|/C) fu^2, hysteresis tau_in |thetadot| and the bearings tau_wa |thetadot|, with v = r thetadot."""
    speed, angle, force = states(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = point.limit == Limit.OK
    v = point.link_speed * np.sin(angle) - element.cylinder_radius * speed * np.cos(angle)
    turning = np.abs(v) / element.wheel_radius
    creep = np.abs(v) / element.creep_stiffness * point.lateral_force**2
    scale = element.slip_force * (np.abs(v) + np.abs(point.link_speed))
    assert_allclose(point.losses["creep"][ok], creep[ok], rtol=0, atol=ROUNDING * scale[ok].max())
    assert_allclose(point.losses["rolling"][ok], (element.rolling_torque * turning)[ok], rtol=1e-9)
    assert_allclose(point.losses["bearing"][ok], (element.bearing_torque * turning)[ok], rtol=1e-9)


@pytest.mark.source("faulring2006", "Eq 7")
@given(elements(law=st.just("linear")), seeds)
def test_linear_law_holds(element, seed):
    """fu = C u/|v| wherever the wheel does not slip."""
    speed, angle, force = states(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = within_limits(point)
    law = element.creep_stiffness * point.creep_speed / np.abs(point.rolling_speed)
    assert_allclose(law[ok], point.lateral_force[ok], rtol=1e-9, atol=1e-12 * element.slip_force)


@given(elements(law=st.just("linear")), seeds)
def test_steer_inverts_operate(element, seed):
    # Beyond |tan phi| = K two angles give one motion; states stop short of it.
    speed, angle, force = states(element, seed, largest_angle=np.arctan(0.5 * element.groups(1.0).creep_group))
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = within_limits(point)
    found = element.steer(cylinder_speed=speed, link_speed=point.link_speed, link_force=force)
    # The tangent is found to rounding, and grows as 1/cos^2 towards the decoupled wheel while the angle does not.
    assert_allclose(found[ok], angle[ok], rtol=0, atol=1e-10)


@given(elements(law=st.just("faulring")), seeds)
def test_steer_finds_the_same_motion_nearer_to_locked(element, seed):
    """With Eq 17 the link slows again before slip, so two angles can give one motion."""
    speed, angle, force = states(element, seed, largest_angle=1.3)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = within_limits(point)
    found = element.steer(cylinder_speed=speed, link_speed=point.link_speed, link_force=force)
    again = element.operate(cylinder_speed=speed, steering_angle=found, link_force=force)
    scale = np.abs(point.link_speed) + element.cylinder_radius * np.abs(speed)
    wrong = np.abs(again.link_speed - point.link_speed) > 1e-8 * scale
    # At the fold itself the two angles meet; Newton's method need not settle within rounding of it.
    assert np.sum(ok & (wrong | np.isnan(found))) <= 0.002 * POINTS
    assert np.all((np.abs(found) <= np.abs(angle) + 1e-7)[ok & ~np.isnan(found)])


@given(elements(), seeds)
def test_speed_and_force_modes_agree(element, seed):
    speed, angle, force = states(element, seed, largest_angle=1.3)
    forward = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = within_limits(forward)
    back = element.operate(cylinder_speed=speed[ok], steering_angle=angle[ok], link_speed=forward.link_speed[ok])
    # Force follows from a creep that is 1/K of the rolling speed: rounding grows by K/cos(phi).
    assert_allclose(back.link_force, force[ok], rtol=0, atol=1e-10 * element.slip_force)


@given(elements(), seeds)
def test_mirror_symmetry(element, seed):
    """Mirroring the machine in the plane across the cylinder turns (phi, ldot, fl) and nothing else."""
    speed, angle, force = states(element, seed)
    one = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    other = element.operate(cylinder_speed=speed, steering_angle=-angle, link_force=-force)
    assert_array_equal(other.link_speed, -one.link_speed)
    assert_array_equal(other.torque, one.torque)
    assert_array_equal(other.limit, one.limit)
    for name, loss in one.losses.items():
        assert_array_equal(other.losses[name], loss)


@given(elements(), seeds)
def test_reversing_the_cylinder(element, seed):
    """A cylinder that turns the other way needs the wheel steered the other way, and gives the same motion."""
    speed, angle, force = states(element, seed)
    one = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    other = element.operate(cylinder_speed=-speed, steering_angle=-angle, link_force=force)
    assert_array_equal(other.link_speed, one.link_speed)
    assert_array_equal(other.torque, -one.torque)


def closed_form(element, angle, force):
    """Efficiency by Eq 16 of faulring2006 with k = C r, h = |tau_in + tau_wa|, |phi| and |fl|."""
    phi, fl, r = np.abs(angle), np.abs(force), element.wheel_radius
    h, k = element.rolling_torque + element.bearing_torque, element.creep_stiffness * r
    sine, cosine = np.sin(phi), np.cos(phi)
    above = -r * cosine**2 * fl * (sine * (h - k) + r * fl)
    return above / ((r * sine * fl + h) * (k * cosine**2 + r * sine * fl + sine**2 * h))


@pytest.mark.source("faulring2006", "Eq 15", "Eq 16")
@given(elements(law=st.just("linear")), seeds)
def test_equation_16_in_the_driving_quadrant(element, seed):
    speed, angle, force = states(element, seed)
    point = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    drives = (point.limit == Limit.OK) & (point.power_out > 0) & (point.power_in > 0)
    expected = closed_form(element, angle, force)
    assert drives.sum() > POINTS // 10
    assert_allclose(point.efficiency[drives], expected[drives], rtol=0, atol=1e-12)


@pytest.mark.source("faulring2006", "Eq 1", "Eq 2")
@given(elements(law=st.just("linear")), seeds)
def test_lossless_limit_is_equations_1_and_2(element, seed):
    """Without rolling loss and with a rigid contact: ldot = -R omega tan(phi), fl = -tau/(R tan(phi))."""
    rigid = replace(element, rolling_torque=0.0, bearing_torque=0.0, creep_stiffness=1e12 * element.slip_force)
    speed, angle, force = states(rigid, seed)
    point = rigid.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    ok = within_limits(point)
    radius = element.cylinder_radius
    ideal = -radius * speed * np.tan(angle)
    # The creep left is 1e-12 of the rolling speed, which is the link speed's hypotenuse.
    assert_allclose(point.link_speed[ok], ideal[ok], rtol=1e-9, atol=1e-10 * radius * 100)
    assert_allclose(point.torque[ok], (-force * radius * np.tan(angle))[ok], rtol=1e-9, atol=1e-12 * element.slip_force)


@given(elements(), seeds)
def test_deliver_is_steer_then_operate(element, seed):
    speed, angle, force = states(element, seed, largest_angle=1.2)
    link = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force).link_speed
    point = element.deliver(cylinder_speed=speed, link_speed=link, link_force=force)
    steered = element.steer(cylinder_speed=speed, link_speed=link, link_force=force)
    ok = within_limits(point)
    assert_allclose(point.steering_angle[ok], steered[ok], rtol=0, atol=1e-12)
    assert not np.any(np.isnan(point.power_in[ok]))
    assert np.all(np.isnan(steered[~ok]))


@given(elements(), laws, seeds)
def test_cylinder_at_rest_holds_until_slip(element, law, seed):
    """A standing cylinder holds the link without any power, and the smallest torque that holds never exceeds Eq 2."""
    element = replace(element, creep_law=law)
    random = np.random.default_rng(seed)
    angle, force = random.uniform(-1.5, 1.5, POINTS), random.uniform(-2, 2, POINTS) * element.slip_force
    point = element.operate(cylinder_speed=np.zeros(POINTS), steering_angle=angle, link_force=force)
    ok = within_limits(point, 0.2)
    assert np.any(~ok)
    assert_array_equal(ok, np.abs(point.lateral_force) <= element.slip_force)
    assert np.all(point.link_speed[ok] == 0)
    assert all(np.all(loss[ok] == 0) for loss in point.losses.values())
    assert np.all(np.abs(point.torque[ok]) <= np.abs(force * element.cylinder_radius * np.tan(angle))[ok] + 1e-12)
