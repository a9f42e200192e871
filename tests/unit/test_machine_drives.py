"""Machines as drives: each against the transmission it is made of, its power balance, and motions in time."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.machines import ArmDrive, PlanarDrive, PlatformDrive, PlatformGeometry, SphereDrive, Wheel
from infinivar.motion import MachinePath, MachineTask, Point, Pose, Twist, Wrench
from internals import angular_velocity, as_machine, is_machine, refuse_machine, rotated
from internals import power_audit as audit
from made import loaded

STUDY = loaded("hand_controller")
LEG, SEPARATE = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
GEOMETRY = PlatformGeometry(
    rod_length=0.14, base_radius=0.08, joint_radius=0.04, base_spread=0.15, joint_spread=0.2, lowest=-0.05, highest=0.05
)
WHEEL = Wheel(
    wheel_radius=0.03,
    preload=200.0,
    friction=0.2,
    creep_stiffness=4000.0,
    rolling_torque=0.009,
    bearing_torque=0.006,
    creep_law="exact",
)
POINTS = (Point(x=0.4), Point(x=-0.2, y=0.25), Point(x=-0.2, y=-0.25))
PLATFORMS = {
    "legs": PlatformDrive(geometry=GEOMETRY, leg=LEG),
    "separate": PlatformDrive(geometry=GEOMETRY, separate=SEPARATE),
}
ARMS = {
    f"{name} {len(lengths)} {elbow}": ArmDrive(lengths=lengths, pulley_radius=0.05, elbow=elbow, **side)
    for lengths in ((0.3,), (0.3, 0.25), (0.3, 0.25, 0.1))
    for elbow in ("left", "right")
    for name, side in (("legs", {"leg": LEG}), ("separate", {"separate": SEPARATE}))
}
CARTS = {"three": PlanarDrive(wheel=WHEEL, positions=POINTS), "carriage": PlanarDrive(wheel=WHEEL)}
SPHERES = {
    layout: SphereDrive(
        motor=SEPARATE.motor, gearhead=LEG.gearhead, input_speed=40.0, sphere_radius=0.03, roller=WHEEL, layout=layout
    )
    for layout in ("tetrahedral", "cubic")
}
EVERY = {**PLATFORMS, **ARMS, **CARTS, **SPHERES}
SIZES = {
    PlatformDrive: (0.005, 0.1, 10.0),
    ArmDrive: (0.01, 0.1, 3.0),
    PlanarDrive: (0.0, 0.5, 15.0),
    SphereDrive: (0.0, 20.0, 0.03),
}


@pytest.mark.parametrize("name", EVERY)
def test_powers_balance_and_the_power_out_is_that_of_the_wrench(name):
    drive, rng = EVERY[name], np.random.default_rng(1)
    near, speed, force = SIZES[type(drive)]
    count, d = (60, 1) if isinstance(drive, SphereDrive) else (2000, len(drive.coordinates))
    pose = np.array(drive.home) + near * rng.uniform(-1, 1, (count, d))
    twist, wrench = speed * rng.uniform(-1, 1, (count, d)), force * rng.uniform(-1, 1, (count, d))
    if "rz" in drive.coordinates:
        wrench[:, 3:] *= 0.02
    point = drive.perform(pose=pose, twist=twist, wrench=wrench)
    known = np.isfinite(point.power_in)
    assert known.mean() > 0.5
    assert audit(point.power_in, point.power_out, point.losses, name) < 1e-9
    assert np.allclose(point.power_out[known], np.sum(wrench * twist, axis=-1)[known], rtol=0, atol=1e-7)
    assert point.part_losses.shape == (count, len(point.parts))
    assert np.array_equal(point.limit != iv.Limit.OK, ~(point.margin >= 1.0))


def test_platform_with_legs_is_the_legged_drive():
    drive = PLATFORMS["legs"]
    pose, twist, wrench = [0.01, 0.0, 0.13, 0.05, 0.0, 0.1], [0, 0.1, 0.1, 0, 0, 0.2], [0, 20.0, 20, 0, 0.1, 0]
    mine = drive.perform(pose=pose, twist=twist, wrench=wrench)
    other = iv.machines.LeggedDrive.of(LEG, 6).operate(
        drive.platform.at(pose[:3], pose[3:]), wrench=wrench, twist=twist
    )
    assert mine.power_in == other.power_in
    assert mine.margin == pytest.approx(other.margin)
    assert np.array_equal(mine.part_losses, other.legs.loss_of_legs)


@pytest.mark.parametrize("speed", [0.0, 0.1])
def test_separate_drives_are_summed_link_by_link(speed):
    drive = PLATFORMS["separate"]
    twist, wrench = np.array([0, speed, speed, 0, 0, 0]), np.array([0, 20.0, 20, 0, 0.1, 0])
    mine = drive.perform(pose=drive.home, twist=twist, wrench=wrench)
    jacobian = drive.configuration(drive.home).jacobian
    speeds, forces = jacobian @ twist, np.linalg.solve(jacobian.T, wrench)
    one = SEPARATE if speed else SEPARATE.without_static_friction()
    points = [one.operate(speed=a, force=b) for a, b in zip(speeds, forces, strict=True)]
    assert mine.power_in == pytest.approx(sum(float(point.power_in) for point in points), rel=1e-12)
    thermal = max(float(mine.demands[iv.Limit.THERMAL, part]) for part in mine.parts)
    assert thermal == pytest.approx(max(float(point.utilisation[iv.Limit.THERMAL]) for point in points), rel=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_joint_angles_bring_the_end_point_to_its_pose(name):
    drive, rng = ARMS[name], np.random.default_rng(2)
    pose = np.array(drive.home) + 0.05 * rng.uniform(-1, 1, (200, len(drive.home)))
    end = drive.arm.end_point(drive.angles(pose))
    found = {"x": end[..., 0], "y": end[..., 1], "angle": end[..., 2]}
    for place, coordinate in enumerate(drive.coordinates):
        assert np.allclose(found[coordinate], pose[..., place], rtol=0, atol=1e-12)
    if len(drive.lengths) > 1:
        assert np.all(np.sign(drive.angles(pose)[..., 1]) == (1.0 if drive.elbow == "right" else -1.0))


def test_arm_with_separate_rotary_drives_is_theirs():
    shaft = iv.ConventionalDrive(motor=SEPARATE.motor, gearhead=SEPARATE.gearhead, shaft=iv.parts.stage.Shaft())
    drive = ArmDrive(lengths=(0.3, 0.25), pulley_radius=0.05, separate=shaft)
    twist, wrench = [0.1, 0.05], [0.3, -0.2]
    mine = drive.perform(pose=drive.home, twist=twist, wrench=wrench)
    jacobian = drive.arm.jacobian(drive.angles(drive.home))[:2]
    rates, torques = np.linalg.solve(jacobian, twist), jacobian.T @ wrench
    assert mine.part_speeds == pytest.approx(rates)
    assert mine.part_forces == pytest.approx(torques)
    each = shaft.operate(speed=rates, force=torques)
    assert mine.power_in == pytest.approx(float(np.sum(each.power_in)))


def test_beyond_reach_is_a_limit_not_a_number():
    arm, platform = ARMS["legs 2 left"], PLATFORMS["separate"]
    for drive, pose in ((arm, [0.6, 0.0]), (platform, [0.2, 0, 0.1, 0, 0, 0])):
        point = drive.perform(pose=pose, twist=np.zeros(len(pose)), wrench=np.ones(len(pose)))
        assert point.limit == iv.Limit.LINKAGE
        assert np.isnan(point.power_in)


def test_source_of_a_cart_pushes_along_the_motion_only():
    drive, rng = CARTS["three"], np.random.default_rng(3)
    twist, wrench = rng.uniform(-1, 1, (300, 3)), 10.0 * rng.uniform(-1, 1, (300, 3))
    point = drive.operated(twist, wrench)
    source = wrench - np.asarray(point.applied)
    scale = drive.metric()
    along = twist * scale**2  # the wrench that works on this motion alone
    along = along / np.linalg.norm(along / scale, axis=-1, keepdims=True)
    push = np.sum(source / scale * (along / scale), axis=-1, keepdims=True)
    known = np.isfinite(push[:, 0])
    assert known.mean() > 0.5
    assert np.allclose(source[known], (push * along)[known], rtol=0, atol=1e-6)


def test_cart_under_a_side_load_is_that_of_the_mechanism():
    drive = CARTS["three"]
    mine = drive.perform(pose=drive.home, twist=[0.5, 0, 0], wrench=[0, 30.0, 0])
    slip = iv.transmission.RollingContact(**{name: getattr(WHEEL, name) for name in ("wheel_radius", "preload", "friction")},
                             creep_stiffness=4000.0, rolling_torque=0.009, bearing_torque=0.006, creep_law="exact")  # fmt: skip
    from internals import drift

    assert np.allclose(mine.steering, drift(slip, 10.0), rtol=1e-3)
    # Each wheel has 10 N of side load: rolling resistance, and creep of (u/v) times the force.
    assert mine.loss == pytest.approx(0.5 * (3 * 0.5 + 30.0 * np.tan(drift(slip, 10.0))), rel=2e-3)


def test_cart_at_rest_holds_by_friction_until_it_slips():
    drive = CARTS["three"]
    for load, feasible in ((119.9, True), (120.1, False)):
        point = drive.perform(pose=drive.home, twist=[0, 0, 0], wrench=[0, load, 0])
        assert bool(point.limit == iv.Limit.OK) is feasible
        assert point.power_in == 0.0


@pytest.mark.parametrize("layout", SPHERES)
def test_shaft_of_a_sphere_turns_as_asked_through_zero_in_both_senses(layout):
    drive = SPHERES[layout]
    speed = np.append(np.linspace(-60.0, 60.0, 12), [0.1])
    speed.sort()
    angle, point = drive.steer(speed, 0.05)
    assert np.allclose(point.output_speed, speed, rtol=0, atol=4e-8)
    assert np.all(np.diff(angle) < 0)
    again = drive.transmission.operate(steering_angle=angle, input_speed=40.0, output_torque=0.05)
    assert np.allclose(again.input_torque, point.input_torque, rtol=1e-9)
    losses = [float(drive.perform(pose=[0.0], twist=[slow], wrench=[0.05]).loss) for slow in (0.0, 0.05, 0.1, 0.2)]
    assert np.all(np.isfinite(losses))
    assert losses[0] == losses[1] == losses[2] == pytest.approx(losses[3], rel=0.01)


def test_sphere_that_turns_the_other_way_is_its_mirror_image():
    from dataclasses import replace

    one, other = SPHERES["cubic"], replace(SPHERES["cubic"], input_speed=-40.0)
    mine = one.perform(pose=[0.0], twist=[20.0], wrench=[0.05])
    mirrored = other.perform(pose=[0.0], twist=[-20.0], wrench=[-0.05])
    assert mine.power_in == pytest.approx(float(mirrored.power_in), rel=1e-6)


def test_a_drive_of_one_axis_is_a_machine_of_one_coordinate():
    machine = as_machine(LEG)
    assert machine.coordinates == ("x",)
    point = machine.perform(pose=[0.0], twist=[0.3], wrench=[20.0])
    assert point.power_in == pytest.approx(float(LEG.operate(speed=0.3, force=20.0).power_in))
    assert not is_machine(LEG)
    refuse_machine(LEG, "sensitivity")
    with pytest.raises(
        iv.ParameterError,
        match=r"drives\.cart is a machine of type planar: size .* commands .*: check, compare, sensitivity, export, session$",
    ):
        refuse_machine(CARTS["three"], "size", "drives.cart")


def test_angular_velocity_is_that_of_the_rotation():
    rng = np.random.default_rng(4)
    rotation, rate, h = rng.uniform(-2, 2, (50, 3)), rng.uniform(-1, 1, (50, 3)), 1e-6
    vectors = np.eye(3)
    ahead, behind = (np.stack(rotated(rotation + sign * h * rate, vectors), axis=-1) for sign in (1, -1))
    turned = np.stack(rotated(rotation, vectors), axis=-1)
    omega = angular_velocity(rotation, rate)
    assert np.allclose((ahead - behind) / (2 * h), np.cross(omega[:, None, :], turned), atol=1e-8)
    small = angular_velocity(1e-6 * rotation, rate)
    assert np.allclose(small, rate + 0.5 * np.cross(1e-6 * rotation, rate), rtol=0, atol=1e-10)


def test_a_circle_needs_the_centripetal_force_and_its_axis_turns():
    wave = {"distance": 0.02, "frequency": 1.0}
    path = MachinePath(
        x=iv.motion.Sinusoid(**wave),
        y=iv.motion.Sinusoid(**wave, start=0.25),
        load_mass=2.0,
        pose=Pose(z=0.1),
        wrench=Wrench(z=5.0),
    )
    at = path.instants(("x", "y", "z"), (0.0, 0.0, 0.3))
    turning = 2.0 * np.pi
    assert np.allclose(np.hypot(at.pose[:, 0], at.pose[:, 1]), 0.02)
    assert np.all(at.pose[:, 2] == 0.1)
    assert np.allclose(np.hypot(at.wrench[:, 0], at.wrench[:, 1]), 2.0 * 0.02 * turning**2)
    assert np.allclose(at.wrench[:, 2], 5.0)
    tilting = MachinePath(
        rx=iv.motion.Sinusoid(angle=0.3, frequency=1.0),
        ry=iv.motion.Sinusoid(angle=0.3, frequency=1.0, start=0.25),
        load_inertia=0.1,
    ).instants(("rx", "ry", "rz"), (0.0, 0.0, 0.0))
    step = tilting.time[1] - tilting.time[0]
    measured = (np.roll(tilting.twist, -1, 0) - np.roll(tilting.twist, 1, 0)) / (2 * step)
    assert np.allclose(tilting.wrench, 0.1 * measured, atol=2e-3 * np.abs(measured).max() * 0.1)
    assert np.abs(tilting.twist[:, 2]).max() > 0.1


def test_polytope_of_a_task_has_its_corners():
    task = MachineTask(wrench=Wrench(x=10.0), box=Wrench(x=2.0, z=3.0))
    corners = task.corners(("x", "y", "z"))
    assert corners[0].tolist() == [10.0, 0.0, 0.0]
    assert {tuple(row) for row in corners[1:]} == {(8, 0, -3), (8, 0, 3), (12, 0, -3), (12, 0, 3)}
    assert MachineTask(wrenches=[Wrench(x=1.0)]).corners(("x",)).tolist() == [[0.0], [1.0]]


@pytest.mark.parametrize("wrench", [(0.0, 0.0, 0.0), (0.0, 10.0, 0.0), (5.0, 0.0, 1.0)])
def test_a_cart_that_turns_about_a_wheel_is_the_limit_of_one_that_turns_next_to_it(wrench):
    """That wheel stands and holds; which way it heads before it stands changes what it holds, here by 0.4 % of the power."""
    cart = CARTS["three"]
    x, y = POINTS[0].row(("x", "y"))
    near = [np.array([y + a, -x + b, 1.0]) for a, b in ((1e-5, 0.0), (0.0, 1e-5), (-1e-5, -1e-5))]
    twists = np.array([[y, -x, 1.0], *near])
    found = cart.perform(pose=np.zeros((4, 3)), twist=twists, wrench=np.tile(wrench, (4, 1)))
    assert np.all(np.isfinite(found.power_in))
    np.testing.assert_allclose(found.power_in[0], found.power_in[1:], rtol=5e-3)
    assert found.part_losses[0, 0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_limits_between_the_ends_of_a_range_count_on_a_sphere():
    """Creep by spin makes the demand of a drive roller largest near no load."""
    drive = iv.load_study("sphere_joint").drives["tetrahedral"]
    roller = replace(drive.roller, preload=120.0)
    ball = replace(drive, roller=roller, steering_roller=replace(roller, friction=0.3))
    range_of = MachineTask(twist=Twist(angle=-12.0), wrenches=(Wrench(angle=0.2), Wrench(angle=-0.2)))
    found = iv.perform_task(ball, range_of)
    ends = [iv.perform_task(ball, replace(range_of, wrenches=None, wrench=one)).margin for one in range_of.wrenches]
    scanned = ball.perform(pose=[0.0], twist=[-12.0], wrench=np.linspace(-0.2, 0.2, 101)[:, None])
    worst = np.max(np.stack([np.broadcast_to(one, 101) for one in scanned.demands.values()]))
    assert found.margin < min(ends)
    assert found.margin == pytest.approx(1.0 / worst, rel=5e-3)


@pytest.mark.parametrize(
    ("task", "said"),
    [
        (MachineTask(twist=Twist(z=1.0)), "twist.z does not apply: the machine has angle only"),
        (MachineTask(box=Wrench(x=1.0)), "box.x does not apply"),
        ("turn", "task must be a MachineTask, got a str"),
    ],
)
def test_a_task_of_another_machine_is_refused(task, said):
    with pytest.raises(iv.ParameterError, match=said):
        iv.perform_task(SPHERES["cubic"], task)


def test_a_cart_on_two_wheels_turns_about_any_point_of_their_line():
    """Parallel wheels hold no moment: the source overcomes the rolling resistance of each, so that the power is that alone."""
    cart = PlanarDrive(wheel=WHEEL, positions=(Point(x=0.4), Point(x=-0.4)))
    centre = np.linspace(-3.0, 3.0, 62)
    twist = np.stack([0.0 * centre, -centre, np.ones(62)], axis=-1)
    found = cart.perform(pose=np.zeros((62, 3)), twist=twist, wrench=np.zeros((62, 3)))
    resistance = (WHEEL.rolling_torque + WHEEL.bearing_torque) / WHEEL.wheel_radius
    np.testing.assert_allclose(found.power_in, resistance * (np.abs(centre - 0.4) + np.abs(centre + 0.4)), rtol=1e-9)
    # Beside the line the wheels hold the moment, at the cost of a little creep.
    beside = cart.perform(pose=np.zeros(3), twist=[0.03, 0.6, 1.0], wrench=np.zeros(3))
    assert float(beside.power_in) == pytest.approx(0.6, rel=2e-2)
