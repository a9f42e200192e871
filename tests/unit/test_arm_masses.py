"""Members with mass, weight and payload of an arm: against Pinocchio and MuJoCo, balances of power, and messages."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from arms import GRAVITY, LEG, MOTOR, STATES, mujoco_model, of, pin_model, states
from infinivar.machines import ArmDrive
from infinivar.motion import MachinePath
from internals import course_on_path, course_through, planar_arm


@pytest.mark.parametrize("count", [1, 2, 3])
def test_inertia_bias_and_inverse_dynamics_are_those_of_pinocchio(count):
    arm = of(count)
    pin, model, data = pin_model(arm)
    angles, rates, accelerations = states(count)
    found = arm._members().inertia(angles, rates)
    torques = found.forces(accelerations)
    for place, (q, v, a) in enumerate(zip(angles, rates, accelerations, strict=True)):
        assert_allclose(torques[place], pin.rnea(model, data, q, v, a), rtol=1e-9, atol=1e-9)
        assert_allclose(found.bias[place], pin.nonLinearEffects(model, data, q, v), rtol=1e-9, atol=1e-9)
        whole = pin.crba(model, data, q)
        assert_allclose(found.inertia[place], np.triu(whole) + np.triu(whole, 1).T, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_inertia_and_bias_are_those_of_mujoco(count):
    arm = of(count)
    mujoco, model, data = mujoco_model(arm)
    angles, rates, accelerations = states(count)
    torques = arm._members().inertia(angles, rates).forces(accelerations)
    for place in range(STATES):
        data.qpos[:], data.qvel[:], data.qacc[:] = angles[place], rates[place], accelerations[place]
        mujoco.mj_inverse(model, data)
        assert_allclose(torques[place], data.qfrc_inverse, rtol=1e-9, atol=1e-9)


def test_weight_is_the_slope_of_the_potential_energy():
    """Without another program: potential energy by hand, differenced in the complex plane."""
    arm = of(3)
    angles = states(3)[0]

    def potential(joints):
        """For complex angles as well."""
        place, turned, total = np.zeros((len(joints), 2), complex), 0.0, 0.0
        for length, mass, *centre, joint in zip(
            arm.lengths, arm.member_masses, arm.member_centres, arm.member_offsets, joints.T, strict=True
        ):
            turned = turned + joint
            ahead = np.stack([np.cos(turned), np.sin(turned)], -1)
            left = np.stack([-np.sin(turned), np.cos(turned)], -1)
            total = total - mass * (place + centre[0] * ahead + centre[1] * left) @ np.array(GRAVITY)
            place = place + length * ahead
        held = place + arm.payload_centre[0] * ahead + arm.payload_centre[1] * left
        return total - arm.payload_mass * held @ np.array(GRAVITY)

    slope = [potential(angles + 1e-30j * np.eye(3)[joint]).imag / 1e-30 for joint in range(3)]
    assert_allclose(arm._members().inertia(angles, 0.0 * angles).bias, np.stack(slope, -1), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("drive", [{"leg": LEG}, {"separate": MOTOR}], ids=["leg", "motor"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_power_balances_in_all_quadrants(count, drive):
    """Lifting the arm is stored, not delivered; joints exert weight besides the wrench."""
    arm = of(count, drive)
    d = len(arm.coordinates)
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 2)).reshape(2, -1).T
    twist, wrench = (np.repeat(signs[:, place : place + 1], d, axis=1) * size for place, size in ((0, 0.05), (1, 0.3)))
    point = arm.perform(pose=arm.home, twist=twist, wrench=wrench)
    assert_allclose(point.power_out, np.sum(twist * wrench, axis=-1), rtol=1e-12, atol=1e-15)
    kept = point.power_out + point.loss + sum(point.stored.values())
    assert_allclose(point.power_in, kept, rtol=1e-9, atol=1e-9)
    bare = replace(arm, gravity=None).perform(pose=arm.home, twist=twist, wrench=wrench)
    weight = point.part_forces - bare.part_forces
    angles = np.broadcast_to(arm.angles(arm.home), weight.shape)
    assert_allclose(weight, arm._members().inertia(angles, 0.0 * angles).bias, rtol=1e-9, atol=1e-12)
    assert_allclose(point.stored["machine"], np.sum(weight * point.part_speeds, axis=-1), rtol=1e-9, atol=1e-12)
    assert np.all(np.abs(point.stored["machine"]) > 1e-3)


def test_a_held_weight_is_that_of_the_steady_point():
    arm = of(2)
    wrench, still = np.array([[0.0, 2.0]]), np.zeros(2)
    held = arm.follow(course_through(np.array(arm.home), still, arm.coordinates, wrench))
    assert_allclose(held.part_forces, arm.perform(pose=arm.home, twist=still, wrench=wrench).part_forces, rtol=1e-9)
    assert_allclose(held.stored["machine"], 0.0, atol=1e-15)


@pytest.mark.parametrize("drive", [{"leg": LEG}, {"separate": MOTOR}], ids=["leg", "motor"])
def test_a_path_balances_and_gives_back_what_it_stored(drive):
    """Joint torques on a path are inverse dynamics by Pinocchio, within the error of the differences of rates (2e-5)."""
    arm = of(2, drive)
    path = MachinePath(
        x=iv.motion.Sinusoid(distance=0.03, frequency=1.0),
        y=iv.motion.Sinusoid(distance=0.04, frequency=1.0, start=0.2),
    )
    _, course = course_on_path(path, arm.coordinates, arm.home)
    point = arm.follow(course)
    kept = point.power_out + point.loss + sum(point.stored.values())
    assert_allclose(point.power_in, kept, rtol=1e-9, atol=1e-9)
    assert abs(np.mean(point.stored["machine"])) < 1e-3 * np.max(np.abs(point.stored["machine"]))
    pin, model, data = pin_model(arm)
    angles = arm.angles(course.pose[2])
    jacobian = arm._jacobian(angles)
    rates = np.linalg.solve(jacobian, course.twist[2][..., None])[..., 0]
    expected = np.empty_like(rates)
    for place, (q, v) in enumerate(zip(angles, rates, strict=True)):
        step = 1e-6
        ahead, behind = (arm._jacobian(q + sign * step * v) for sign in (1.0, -1.0))
        curved = (ahead - behind) @ v / (2.0 * step)
        a = np.linalg.solve(jacobian[place], course.acceleration[2, place] - curved)
        expected[place] = pin.rnea(model, data, q, v, a) + jacobian[place].T @ course.wrench[2, place]
    assert_allclose(point.part_forces, expected, atol=1e-4 * np.max(np.abs(expected)))


@pytest.mark.parametrize("drive", [{"leg": LEG}, {"separate": MOTOR}], ids=["leg", "motor"])
def test_uniform_members_without_weight_are_as_before_to_the_last_bit(drive):
    uniform = {"lengths": (0.3, 0.25), "member_masses": (0.4, 0.3), "pulley_radius": 0.05, **drive}
    bare = ArmDrive(**uniform)
    stated = ArmDrive(
        **uniform,
        member_centres=tuple(0.5 * length for length in bare.lengths),
        member_inertias=tuple(np.array(uniform["member_masses"]) * np.array(bare.lengths) ** 2 / 12.0),
        gravity=(0.0, 0.0),
    )
    path = MachinePath(x=iv.motion.Sinusoid(distance=0.03, frequency=1.0))
    one, other = (arm.follow(course_on_path(path, arm.coordinates, arm.home)[1]) for arm in (bare, stated))
    assert_array_equal(one.power_in, other.power_in)
    assert_array_equal(one.part_forces, other.part_forces)
    angles, rates, _ = states(2)
    args = (np.array([0.3, 0.25]), np.array([0.4, 0.3]), np.array([3e-3, 1e-3]), 0.2, angles, rates)
    middle = np.array([[0.15, 0.0], [0.125, 0.0]])
    for one, other in zip(planar_arm(*args), planar_arm(*args, centres=middle), strict=True):
        assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"member_masses": None}, "member_masses is missing: payload_mass is stated"),
        ({"member_inertias": None}, "member_inertias is missing: with member_centres, members are not uniform"),
        ({"member_centres": (0.1,)}, "member_centres must be 2, one for each member, got 1 values"),
        ({"member_inertias": (1e-3, -1e-3)}, "member_inertias[1] must be >= 0 kg m^2, got -0.001"),
        ({"gravity": (9.81,)}, "gravity must be 2: along x and y, got 1 values"),
        ({"payload_centre": (0.1, 0.0, 0.0)}, "payload_centre must be 2: along and to the left, got 3 values"),
        ({"payload_mass": 0.0}, "payload_mass is missing or 0 kg: payload_centre is stated"),
        ({"payload_mass": 0.0, "payload_centre": None}, "payload_mass is missing or 0 kg: payload_inertia is stated"),
        ({"member_masses": (0.4, 0.0)}, "member_masses must be > 0 kg"),
    ],
)
def test_faults_are_named(changes, said):
    with pytest.raises(iv.ParameterError) as problem:
        of(2, **changes)
    assert said in str(problem.value)
