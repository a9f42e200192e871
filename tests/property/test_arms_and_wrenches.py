"""Arms driven from one shaft or joint to joint, and the set of wrenches that legs hold."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import linprog

import infinivar as iv
from infinivar import Limit
from infinivar.machines import LeggedDrive
from infinivar.transmission import Configuration, Legs, PlanarArm, Platform, WrenchSet
from jacobians import jacobian
from made import loaded
from sampled import sampled

LEG = loaded("hand_controller").drives["cobotic"]
MACHINE = LeggedDrive.of(LEG, 6)
PLATFORM = Platform.hexapod()
HOME = PLATFORM.at([0.0, 0.0, PLATFORM.home])
seeds = st.integers(0, 2**32 - 1)

MEASURED = {"wheel_radius": 0.012, "preload": 300.0, "friction": 0.2, "creep_stiffness": 9000.0}
WHEEL = iv.transmission.RollingContact(**MEASURED, rolling_torque=4e-3, bearing_torque=2e-3)
IVT = iv.RotaryLinearIVT(**MEASURED, rolling_torque=4e-3, bearing_torque=2e-3, cylinder_radius=0.05)


# Arms


def positions(lengths):
    """End point of an arm from its angles, written with other operations than the program's."""

    def end(*angles):
        from infinivar import array_namespace as namespace

        xp = namespace(*angles)
        x = y = total = 0.0
        for length, angle in zip(lengths, angles, strict=True):
            total = total + angle
            x, y = x + length * xp.cos(total), y + length * xp.sin(total)
        return x, y, total

    return end


@given(st.integers(1, 6), seeds)
def test_jacobian_of_an_arm_by_the_complex_step(joints, seed):
    random = np.random.default_rng(seed)
    lengths = random.uniform(0.1, 0.5, joints)
    angles = random.uniform(-3, 3, (5, joints))
    arm, end = PlanarArm(lengths=tuple(lengths)), positions(lengths)
    assert_allclose(arm.jacobian(angles), jacobian(end, *angles.T), rtol=0, atol=1e-13)
    assert_allclose(arm.end_point(angles), np.stack(end(*angles.T), axis=-1), rtol=0, atol=1e-13)
    force, rates = random.normal(size=(5, 3)), random.normal(size=(5, joints))
    velocity = np.einsum("...ij,...j", arm.jacobian(angles), rates)
    power = np.sum(arm.joint_torques(angles, force) * rates, axis=-1)
    assert_allclose(power, np.sum(force * velocity, axis=-1), rtol=0, atol=1e-12)


def test_parallel_arm_is_balanced_at_its_end_point():
    """Joints turn at ``-R omega tan(phi)/rho``, and the power at the end point is that of the cylinder less the losses."""
    arm, angles, pulley = PlanarArm(lengths=(0.3, 0.25)), np.array([0.4, 1.1]), np.array([0.03, 0.02])
    legs = Legs(transmission=IVT, count=2)
    rates, push = np.array([1.5, -2.0]), np.array([2.0, -1.0, 0.05])
    point = legs.operate(arm.parallel(pulley), cylinder_speed=14.0, wrench=arm.joint_torques(angles, push), twist=rates)
    assert point.limit == Limit.OK
    end = arm.jacobian(angles) @ rates
    assert 14.0 * point.torque - push @ end == pytest.approx(sum(point.losses.values()), rel=1e-12)
    ideal = iv.RotaryLinearIVT(
        **MEASURED | {"creep_stiffness": 1e12}, rolling_torque=0.0, bearing_torque=0.0, cylinder_radius=0.05
    )
    pure = Legs(transmission=ideal, count=2).operate(
        arm.parallel(pulley), cylinder_speed=14.0, wrench=[0.0, 0.0], twist=rates
    )
    assert_allclose(rates, -0.05 * 14.0 * pure.steering_tangent / pulley, rtol=1e-9)


@given(st.integers(2, 5), seeds)
def test_serial_arm_turns_its_joints_by_the_steering_angles(joints, seed):
    random = np.random.default_rng(seed)
    arm = PlanarArm(lengths=tuple(random.uniform(0.1, 0.5, joints)))
    machine = arm.serial(WHEEL, random.uniform(0.02, 0.05, joints - 1))
    phi = random.uniform(0.2, 1.2, joints - 1) * random.choice([-1, 1], joints - 1)
    first = random.uniform(1, 3)
    rates = first * np.concatenate([[1.0], np.cumprod(-np.tan(phi))])
    heading = machine.steer(rates=rates)
    assert_allclose(np.abs(heading[0] / heading[1]), np.abs(np.tan(phi)), rtol=1e-12)
    # n - 1 wheels leave one freedom: rates that are not coupled make a wheel slide.
    sliding = machine.operate(rates=rates * np.append(np.ones(joints - 1), 1.5), heading=heading)
    assert sliding.limit == Limit.SLIP
    angles, push = random.uniform(-2, 2, joints), random.normal(size=3)
    # The wrench on the load at the end point, exerted by a motor at the first joint.
    torque = arm.joint_torques(angles, push)
    scale = 1e-1 / np.max(np.abs(torque))
    applied = {f"q{place + 1}": scale * torque[place] for place in range(1, joints)}
    point = machine.solve(heading=heading, rates={"q1": first}, applied=applied)
    assert point.limit == Limit.OK
    motor = scale * torque[0] - point.applied[0]
    end = arm.jacobian(angles) @ point.rates
    assert motor * point.rates[0] - scale * push @ end == pytest.approx(sum(point.losses.values()), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("ways", [(1, 1), (-1, 1), (-1, -1), (1, -1)])
@sampled("law", ["linear", "vermeulen-johnson", "polach", "fastsim", "exact"], slow=4)
def test_power_closure_of_arms_at_many_points(law, ways):
    """100,000 points per law and quadrant of the first two joint rates: joint to joint, and from one shaft."""
    random, count = np.random.default_rng(8), 100_000
    arm, wheel = PlanarArm(lengths=(0.3, 0.2, 0.1)), replace(WHEEL, creep_law=law)
    rates = random.uniform(0.3, 3.0, (count, 3)) * [*ways, 1] * random.choice([-1, 1], (count, 1)) ** [0, 0, 1]
    chain = arm.serial(wheel, [0.05, 0.03])
    cosine, sine = chain.steer(rates=rates)
    point = chain.operate(rates=rates, heading=np.arctan2(sine, cosine) + 0.015 * random.normal(size=cosine.shape))
    off = np.abs(point.power.sum(axis=-1) + sum(point.losses.values()))
    assert np.max(off / np.abs(point.power).sum(axis=-1)) < 1e-9
    assert 0.02 < np.mean(point.limit == Limit.OK) < 0.98
    assert all(np.all(loss >= 0.0) for loss in point.wheel_losses.values())
    legs = Legs(transmission=replace(IVT, creep_law=law), count=3)
    angles, push = random.uniform(-3, 3, (count, 3)), random.normal(size=(count, 3)) * [4.0, 4.0, 0.4]
    torques = arm.joint_torques(angles, push)
    shaft = legs.operate(arm.parallel([0.04, 0.03, 0.02]), cylinder_speed=14.0, wrench=torques, twist=rates)
    holds = shaft.limit == Limit.OK
    assert 0.3 < np.mean(holds) <= 1.0
    end = np.matmul(arm.jacobian(angles), rates[..., None])[..., 0]
    left = shaft.power_in - np.sum(push * end, axis=-1) - sum(shaft.losses.values())
    size = np.maximum(np.abs(shaft.power_in), np.abs(np.sum(push * end, axis=-1)))
    assert np.max(np.abs(left[holds]) / size[holds]) < 1e-9


def test_malformed_arms():
    arm = PlanarArm(lengths=(0.3, 0.2))
    cases = [
        (lambda: PlanarArm(lengths=()), "lengths must be one length or more"),
        (lambda: PlanarArm(lengths=(0.3, -0.1)), r"lengths\[1\] must be > 0 m, got -0.1"),
        (lambda: arm.jacobian([0.1]), r"angles must be of shape \(..., 2\), got shape \(1,\)"),
        (lambda: arm.parallel(0.0), "pulley_radius must be > 0 m"),
        (lambda: arm.parallel([0.1, 0.1, 0.1]), "pulley_radius must be one number, or 2 of them"),
        (lambda: arm.serial(WHEEL, [0.1, 0.1]), "drum_radius must be one number, or 1 of them"),
        (lambda: PlanarArm(lengths=(0.3,)).serial(WHEEL, 0.1), "two members or more"),
    ]
    for call, message in cases:
        with pytest.raises(iv.ParameterError, match=message):
            call()


# Wrenches


def test_zonotope_of_the_platform():
    slip = float(LEG.transmission.slip_force)
    found = WrenchSet.of(HOME, slip)
    corners = found.vertices()
    assert corners.shape == (64, 6)
    assert found.normals.shape == (12, 6)
    # At a corner every wheel is at its slip limit; a facet is one wheel's.
    assert_allclose(np.abs(HOME.link_forces(corners)), slip, rtol=1e-9)
    assert np.all(found.contains(corners))
    assert not np.any(found.contains(1.001 * corners))
    for direction in np.eye(6):
        most = slip / np.max(np.abs(np.linalg.solve(HOME.jacobian.T, direction)))
        assert found.largest(direction) == pytest.approx(most, rel=1e-9)
    inside = np.random.default_rng(0).normal(size=(500, 6)) * [60, 60, 200, 6, 6, 5]
    legs = np.max(np.abs(HOME.link_forces(inside)), axis=-1) <= slip
    assert 0.05 < np.mean(legs) < 0.95
    assert_allclose(found.contains(inside), legs)


@given(st.integers(1, 4), st.integers(0, 2), seeds)
def test_facets_against_linear_programs(freedoms, more, seed):
    """The largest multiple of a wrench that some link forces hold, with more links than components."""
    random = np.random.default_rng(seed)
    found = Configuration(jacobian=random.normal(size=(freedoms + more, freedoms)))
    limits = random.uniform(0.5, 2.0, freedoms + more)
    wrenches = WrenchSet.of(found, limits)
    direction = random.normal(size=freedoms)
    equations = np.column_stack([found.jacobian.T, direction])
    bounds = [*((-one, one) for one in limits), (0.0, None)]
    best = linprog(np.append(np.zeros(freedoms + more), -1.0), A_eq=equations, b_eq=np.zeros(freedoms), bounds=bounds)
    assert wrenches.largest(direction) == pytest.approx(-best.fun, rel=1e-7)
    if freedoms > 1:
        corners = wrenches.vertices()
        assert np.all(wrenches.contains(corners, 1e-7))
        signs = np.array(list(itertools.product((-1, 1), repeat=freedoms + more)))
        support = np.max(signs @ (wrenches.generators.T @ direction))
        assert np.max(corners @ direction) == pytest.approx(support, rel=1e-7)


def test_largest_wrench_of_real_wheels_is_near_that_of_ideal_ones():
    """At rest to 1.5 %: creep and rolling resistance; within all limits just below it, beyond one just above."""
    directions = np.eye(6)
    poses = Configuration(jacobian=np.broadcast_to(HOME.jacobian, (6, 6, 6)))
    ideal = MACHINE.wrench_set(HOME).largest(directions)
    for twist in (None, np.zeros(6)):
        most = MACHINE.largest_wrench(poses, directions, twist=twist)
        assert_allclose(most, ideal, rtol=0.015)
        for factor, limits in ((1 - 1e-9, {Limit.OK}), (1 + 1e-9, {Limit.SLIP})):
            point = MACHINE.operate(poses, wrench=factor * most[:, None] * directions, twist=twist)
            assert set(point.limit) == limits


def test_motor_limits_cut_the_zonotope():
    """Upward at 0.3 m/s the motor's continuous torque, not slip, limits the force, whether it drives or brakes."""
    rising = np.array([0, 0, 0.3, 0, 0, 0])
    cut, slip = MACHINE.wrench_set(HOME, twist=rising), MACHINE.wrench_set(HOME)
    both = np.array([[0, 0, 1.0, 0, 0, 0], [0, 0, -1.0, 0, 0, 0]])
    poses = Configuration(jacobian=np.broadcast_to(HOME.jacobian, (2, 6, 6)))
    real = MACHINE.largest_wrench(poses, both, twist=rising)
    assert np.all(cut.largest(both) < 0.25 * slip.largest(both))
    assert_allclose(cut.largest(both), real, rtol=0.02)
    beyond = MACHINE.operate(poses, wrench=1.001 * real[:, None] * both, twist=rising)
    assert set(beyond.limit) == {Limit.THERMAL}
    corners = cut.vertices()
    assert np.all(cut.contains(corners, 1e-7))
    power = corners @ rising
    driving, braking = MACHINE.continuous_power(14.0), MACHINE.continuous_power(14.0, braking=True)
    assert np.max(power) == pytest.approx(driving - _idle(rising), rel=1e-6)
    assert -np.min(power) == pytest.approx(braking + _idle(rising), rel=1e-6)


def _idle(twist):
    return float(MACHINE.operate(HOME, wrench=np.zeros(6), twist=twist).legs.power_in)


def test_malformed_wrench_sets():
    zonotope = WrenchSet.of(Configuration(jacobian=np.eye(2)), 1.0)
    weak = replace(MACHINE, motor=replace(MACHINE.motor, continuous_torque=1e-4))
    cases = [
        (lambda: WrenchSet.of(Configuration(jacobian=np.ones((3, 2, 2))), 1.0), "configuration must be one pose"),
        (lambda: WrenchSet.of(Configuration(jacobian=np.ones((2, 2))), 1.0), "must be a regular pose within reach"),
        (lambda: WrenchSet.of(PLATFORM.at([1.0, 0, 0.1]), 1.0), "must be a regular pose within reach"),
        (lambda: WrenchSet.of(Configuration(jacobian=np.eye(2)), 0.0), "link_force must be > 0 N"),
        (lambda: WrenchSet.of(Configuration(jacobian=np.eye(2)), [1.0, 2.0, 3.0]), "link_force must be one number"),
        (lambda: WrenchSet.of(Configuration(jacobian=np.ones((17, 1))), 1.0), "configuration must be of at most 16"),
        (lambda: zonotope.cut([0.0, 0.0], 1.0), "normal must be 2 finite numbers, not all 0"),
        (lambda: zonotope.cut([1.0, 0.0], -1.0), "bound must be >= 0"),
        (lambda: weak.wrench_set(HOME, twist=[0, 0, 0.3, 0, 0, 0]), "falls short by"),
        (lambda: MACHINE.largest_wrench(HOME, [1.0, 0.0]), r"direction must be of shape \(..., 6\)"),
    ]
    for call, message in cases:
        with pytest.raises(iv.ParameterError, match=message):
            call()


def test_cut_square():
    """A square cut at a corner, by hand."""
    square = WrenchSet.of(Configuration(jacobian=np.eye(2)), 1.0)
    cut = square.cut([1.0, 1.0], 1.5)
    corners = cut.vertices()
    assert len(corners) == 5
    assert_allclose(cut.largest([[1.0, 1.0], [1.0, 0.0], [-1.0, -1.0]]), [0.75, 1.0, 1.0])
    x, y = corners[np.argsort(np.arctan2(corners[:, 1], corners[:, 0]))].T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area == pytest.approx(4.0 - 0.125)
    assert math.isclose(square.cut([-2.0, 0.0], 1.0).largest([-1.0, 0.0]), 0.5)
