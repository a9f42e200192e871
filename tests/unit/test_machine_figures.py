"""Figures of machines: numbers drawn against the computation by another way."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog

import infinivar as iv
from internals import arm_figure as arm
from internals import drift, sphere_picture
from internals import machine_figure as machine
from internals import pictures_figure as pictures
from internals import wheeled_picture as wheeled
from internals import wheels_figure as wheels
from internals import workspace_figure as workspace
from internals import wrench_set_figure as wrench_set
from made import loaded

MACHINE = iv.machines.LeggedDrive.of(loaded("hand_controller").drives["cobotic"], 6)
PLATFORM = iv.transmission.Platform.hexapod()
HOME = PLATFORM.at([0.0, 0.0, PLATFORM.home])
RISING = np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])


def in_space(points, plane):
    made = np.zeros((len(points), 6))
    made[:, plane] = points
    return made


@pytest.mark.parametrize("plane", [[0, 1], [0, 2], [3, 4]])
def test_outlines_of_a_wrench_set(plane):
    """Section by the largest multiple of each wrench, projection by linear programs over wrenches, limits by the legs."""
    found = MACHINE.wrench_set(HOME, twist=RISING)
    numbers = wrench_set.data(found, tuple(plane))
    section, limits, projection = (numbers[name] for name in ("section", "limits", "projection"))
    middles = 0.5 * (section + np.roll(section, -1, axis=0))
    for points in (section, middles):
        assert_allclose(found.largest(in_space(points, plane)), 1.0, rtol=1e-6)
    beyond = 1.001 * in_space(middles, plane)
    most = MACHINE.legs.force_limits(HOME.link_speeds(RISING), MACHINE.cylinder_speed)
    slips = np.any(np.abs(HOME.link_forces(beyond)) > most, axis=-1)
    assert_allclose(np.where(slips, iv.Limit.SLIP, iv.Limit.THERMAL), limits)
    assert (iv.Limit.THERMAL in limits) == (2 in plane)
    for angle in np.linspace(0.1, 6.0, 7):
        direction = in_space([[np.cos(angle), np.sin(angle)]], plane)[0]
        best = linprog(-direction, A_ub=found.normals, b_ub=found.bounds, bounds=[(None, None)] * 6)
        assert np.max(projection @ direction[plane]) == pytest.approx(-best.fun, rel=1e-6)


def test_figure_of_a_wrench_set():
    """Every limit drawn is named; a set of three components has two planes, one of one component none."""
    made = wrench_set.draw_all([MACHINE.wrench_set(HOME), MACHINE.wrench_set(HOME, twist=RISING)], ["rest", "rising"])
    assert len(made.axes) == 6
    words = [text.get_text() for text in made.legends[0].get_texts()]
    assert words[:2] == [f"limit: {limit.words}" for limit in (iv.Limit.SLIP, iv.Limit.THERMAL)]
    square = iv.transmission.WrenchSet.of(iv.transmission.Configuration(jacobian=np.eye(3)), [1.0, 2.0, 3.0])
    assert len(square.plot().axes) == 2
    outline = wrench_set.data(square, (0, 2))["section"]
    assert_allclose(np.abs(outline), [[1.0, 3.0]] * 4)
    with pytest.raises(iv.InputError, match="plane must be two of the components 0 to 2 of the wrench"):
        wrench_set.data(square, (0, 3))
    with pytest.raises(iv.InputError, match="one component cannot be drawn"):
        iv.transmission.WrenchSet.of(iv.transmission.Configuration(jacobian=[[1.0]]), 1.0).plot()


def test_drawn_machine():
    """Rods pull and push so that the platform is in equilibrium; wheels touch the cylinder and roll along their headings."""
    position, rotation = np.array([0.01, 0.005, PLATFORM.home]), [0.0, 0.1, 0.05]
    wrench = np.array([30.0, -15.0, -60.0, 0.4, -0.3, 0.2])
    point = MACHINE.operate(PLATFORM.at(position, rotation), wrench=wrench, twist=[0.0, 0.1, 0.15, 0.3, 0.0, 0.0]).legs
    numbers = machine.data(PLATFORM, MACHINE.legs, point, position, rotation)
    there = numbers["machine"]
    rods = there.lower - there.upper
    length = np.linalg.norm(rods, axis=1)
    assert_allclose(length, PLATFORM.rod_length, rtol=1e-12)
    pulls = numbers["tension"][:, None] * rods / length[:, None]
    moments = np.cross(there.upper - position, pulls)
    assert_allclose(np.concatenate([pulls.sum(axis=0), moments.sum(axis=0)]), wrench, rtol=1e-9)
    assert_allclose(np.hypot(*there.contacts[:, :2].T), there.cylinder_radius, rtol=1e-12)
    turning = np.cross([0.0, 0.0, float(point.cylinder_speed)], there.contacts)
    carrier = point.link_speed[:, None] * [0.0, 0.0, 1.0] - turning
    assert np.max(np.linalg.norm(np.cross(carrier, there.headings), axis=1)) < 0.01 * numbers["surface_speed"]
    # An ideal wheel has no rolling resistance.
    assert_allclose(np.abs(numbers["tension"]) / numbers["limit"], numbers["slip"], atol=0.02)
    made = machine.draw_all(PLATFORM, MACHINE.legs, point, position, rotation)
    words = [text.get_text() for text in made.axes[2].texts]
    assert "wheel slips beyond these lines" in words
    assert words[1:] == [f"{100 * share:.0f} %" for share in numbers["slip"]]
    slips = MACHINE.operate(HOME, wrench=1e3 * wrench, twist=RISING).legs
    with pytest.raises(iv.InputError, match="one pose within reach and below the slip limit"):
        machine.data(PLATFORM, MACHINE.legs, slips, [0.0, 0.0, PLATFORM.home])


MEASURED = {"wheel_radius": 0.03, "preload": 200.0, "friction": 0.2, "creep_stiffness": 4000.0}
WHEEL = iv.transmission.RollingContact(**MEASURED, rolling_torque=0.009, bearing_torque=0.006, creep_law="exact")
CART = iv.transmission.PlanarCobot(contacts=WHEEL, positions=[(0.4, 0.0), (-0.2, 0.25), (-0.2, -0.25)])


def test_drawn_planar_cobot():
    """The forces drawn are in equilibrium and lose the power of the point; headings are off the circles by the slip angles."""
    twist = np.array([0.5, 0.0, 0.7])
    point = CART.mechanism.operate(rates=twist, heading=CART.headings(twist, {"y": -50.0, "angle": -4.0}))
    found = wheeled.steered(CART, point)
    ((_, name, applied),) = found.applied
    assert name == "applied force"
    spots, force = found.positions, found.force
    moments = spots[:, 0] * force[:, 1] - spots[:, 1] * force[:, 0]
    assert_allclose([*force.sum(axis=0), moments.sum()], -applied, atol=1e-9)
    assert_allclose(applied[1:], [50.0, 4.0], atol=1e-6)
    radius = spots - found.centre
    velocity = twist[2] * np.stack([-radius[:, 1], radius[:, 0]], axis=-1)
    assert -np.sum(force * velocity) == pytest.approx(sum(point.losses.values()), rel=1e-9)
    heading = found.headings
    turned = heading[:, 0] * velocity[:, 1] - heading[:, 1] * velocity[:, 0]
    side_load = heading[:, 1] * force[:, 0] - heading[:, 0] * force[:, 1]
    slip_angle = np.arctan2(turned, np.sum(heading * velocity, axis=1))
    assert_allclose(slip_angle, drift(WHEEL, side_load), rtol=1e-6)
    made = point.plot(cobot=CART)
    words = [text.get_text() for text in made.axes[0].texts]
    assert "instant centre" in words
    assert f"{100 * found.slip[0]:.0f} % of slip limit" in " ".join(words)


def test_source_and_load_of_a_drawn_cart_are_told_apart():
    """A source that tows a load of 200 N gives that and what the wheels lose, and none of what acts across."""
    wheel = iv.machines.Wheel(
        **{**MEASURED, "preload": 1000.0}, rolling_torque=0.4, bearing_torque=0.006, creep_law="exact"
    )
    drive = iv.machines.PlanarDrive(wheel=wheel, positions=[iv.motion.Point(x=x, y=y) for x, y in CART.positions])
    twist, wrench = np.array([0.5, 0.0, 0.0]), np.array([200.0, 60.0, 0.0])
    point = drive.operated(twist, wrench)
    found = wheeled.steered(drive.machine, point, wrench)
    (_, _, source), (_, _, load) = found.applied
    assert source[0] == pytest.approx((wrench @ twist + sum(point.losses.values())) / 0.5, rel=1e-9)
    assert source[0] > 220.0
    assert_allclose(source[1:], 0.0, atol=1e-6)
    assert_allclose(load, -wrench)
    assert_allclose([*found.force.sum(axis=0)], -(source + load)[:2], atol=1e-9)
    words = key(pictures.draw_all(wheeled.picture(found)))
    assert f"push of the user {source[0]:.3g} N, with 0 N m" in words
    assert "force of the load 209 N, with 0 N m" in words
    assert any(word.startswith("applied force ") for word in key(point.plot(cobot=drive.machine)))


def key(made):
    return [text.get_text() for text in made.legends[0].get_texts()]


def test_planar_cobots_that_roll_straight_or_rest():
    straight = CART.mechanism.operate(rates=[0.5, 0.0, 0.0], heading=np.zeros(3))
    assert straight.plot(cobot=CART).axes[0].get_title() == "instant centre at infinity"
    wide = CART.mechanism.operate(rates=[0.5, 0.0, 0.1], heading=CART.headings([0.5, 0.0, 0.1]))
    assert wide.plot(cobot=CART).axes[0].get_title() == "instant centre at (0, 5) m"
    for rates in ([0.0, 0.0, 0.0], [[0.5, 0.0, 0.0]] * 2):
        point = CART.mechanism.operate(rates=rates, heading=np.zeros(3))
        with pytest.raises(iv.InputError, match="drawn at one point in steady motion"):
            wheeled.steered(CART, point)


def sphere(layout):
    ball = iv.transmission.RollingContact(**MEASURED, rolling_torque=0.009, bearing_torque=0.006, surface="sphere")
    return iv.SphericalIVT(sphere_radius=0.09, drive=ball, layout=layout)


@pytest.mark.parametrize("layout", ["tetrahedral", "cubic"])
def test_drawn_sphere(layout):
    """The forces drawn on the sphere are tangential and in equilibrium, with those of idlers; headings roll with the sphere."""
    ivt = sphere(layout)
    point = ivt.operate(steering_angle=0.5, sphere_speed=20.0, load=15.0)
    found = sphere_picture.placed(ivt, point)
    normals, force = found.normals, np.asarray(point.contact_force)
    assert_allclose(np.sum(normals * force, axis=1), 0.0, atol=1e-12)
    assert_allclose(np.cross(normals, force).sum(axis=0), 0.0, atol=1e-6)
    surface = np.cross(point.sphere_velocity, normals)
    steered = np.array(point.kinds) == "steering"
    assert_allclose(np.sum(surface * found.axles, axis=1)[steered], 0.0, atol=1e-12)
    drives = force[np.array(point.kinds) == "drive"]
    across = np.cross(found.axles[:2], normals[:2])
    torques = np.abs(np.sum(drives * across, axis=1)) * 0.03
    resisted = 0.015 * np.sign([point.input_torque, -point.output_torque])
    assert_allclose(torques, np.abs([point.input_torque, point.output_torque]) - resisted, rtol=1e-9)
    made = point.plot(ivt=ivt)
    assert sum(" of slip limit" in text.get_text() for text in made.axes[0].texts) == len(normals)
    slips = ivt.operate(steering_angle=0.5, sphere_speed=20.0, load=1e3)
    with pytest.raises(iv.InputError, match="at which it turns and no roller slips"):
        slips.plot(ivt=ivt)
    with pytest.raises(iv.InputError, match="ivt must be the machine of the point, with the rollers drive"):
        point.plot(ivt=sphere("cubic" if layout == "tetrahedral" else "tetrahedral"))


def test_points_plot_themselves():
    """Losses by wheel without a machine; with it the machine."""
    pose = [0.0, 0.0, PLATFORM.home]
    machine_point = MACHINE.operate(PLATFORM.at(pose), wrench=[5.0, 0, 0, 0, 0, 0], twist=RISING)
    cart_point = CART.mechanism.operate(rates=[0.5, 0.0, 0.1], heading=CART.headings([0.5, 0.0, 0.1], {"y": 30.0}))
    ball_point = sphere("cubic").operate(steering_angle=0.5, sphere_speed=20.0, load=15.0)
    for point, legs in ((machine_point.legs, 6), (cart_point, 3), (ball_point, 6)):
        numbers = wheels.data(point)
        assert len(numbers["names"]) == legs
        total = sum(float(np.sum(loss)) for loss in numbers["losses"].values())
        assert total == pytest.approx(float(sum(point.losses.values())), rel=1e-12)
        assert point.plot().axes[0].get_title() == f"losses {total:.3g} W, within limits"
    machine_of = {"machine": MACHINE, "platform": PLATFORM, "position": pose}
    assert len(machine_point.plot(**machine_of).axes) == 4
    assert len(machine_point.legs.plot(**machine_of | {"machine": MACHINE.legs}).axes) == 4
    assert len(machine_point.plot().axes) == 1
    assert cart_point.plot(cobot=CART).axes[0].get_xlabel() == "x of the body [m]"
    with pytest.raises(
        iv.InputError, match="position is missing: a machine is drawn from machine, platform and position"
    ):
        machine_point.plot(machine=MACHINE, platform=PLATFORM)
    with pytest.raises(iv.InputError, match="cobot must be a PlanarCobot, got 3"):
        cart_point.plot(cobot=3)
    many = CART.mechanism.operate(rates=[[0.5, 0.0, 0.1]] * 2, heading=np.zeros(3))
    with pytest.raises(iv.InputError, match=r"losses by wheel are drawn at one point, got points of shape \(2,\)"):
        many.plot()
    slips = MACHINE.operate(PLATFORM.at(pose), wrench=[1e4, 0, 0, 0, 0, 0], twist=RISING)
    with pytest.raises(iv.InputError, match="losses by leg are undefined at this point: wheel slip"):
        slips.plot()


@pytest.mark.slow
def test_drawn_arm():
    """Members end at the pose; the joints hold the wrench; forces of ideal legs at rest are their parallelogram."""
    study = iv.load_study("two_joint_arm")
    drive = next(one for one in study.drives.values() if one.leg is not None)
    pose, twist, wrench = np.array([0.35, 0.2]), np.array([0.05, -0.1]), np.array([6.0, 3.0])
    operated = drive.perform(pose=pose, twist=twist, wrench=wrench)
    picture = drive.picture(operated, pose, twist, wrench)
    points = next(one.points for one in picture.strokes if one.look == "member")
    assert_allclose(points[-1], pose, atol=1e-12)
    assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), drive.lengths)
    levers = pose - points[:-1]
    assert_allclose(operated.part_forces, levers[:, 0] * wrench[1] - levers[:, 1] * wrench[0], rtol=1e-9)
    sets = arm.data(drive, pose, twist, wrench)
    outline, limits = sets["at rest"]
    most = drive.legs.legs.transmission.slip_force * drive.pulley_radius
    torques = levers[:, 0] * outline[:, 1:] - levers[:, 1] * outline[:, :1]
    assert_allclose(np.max(np.abs(torques), axis=1), most, rtol=0.05)
    assert set(limits) == {iv.Limit.SLIP}
    inside = drive.perform(pose=pose, twist=twist, wrench=0.999 * sets["in the task"][0])
    beyond = drive.perform(pose=pose, twist=twist, wrench=1.001 * sets["in the task"][0])
    assert np.all(inside.limit == iv.Limit.OK)
    assert not np.any(beyond.limit == iv.Limit.OK)
    made = arm.draw_all(drive, operated, pose, twist, wrench)
    assert len(made.axes) == 2
    for joint, (text, torque) in enumerate(zip(made.axes[0].texts[-2:], operated.part_forces, strict=True), 1):
        assert text.get_text().startswith(f"joint {joint}: {torque:.3g} N m,\n")
    far = {"pose": [2.0, 0.0], "twist": twist, "wrench": wrench}
    with pytest.raises(iv.InputError, match="an arm is drawn at one pose within reach"):
        drive.picture(drive.perform(**far), **far)


@pytest.mark.slow
@pytest.mark.parametrize("joints", [1, 3])
def test_arms_of_other_numbers_of_joints_are_drawn(joints):
    drive = next(one for one in iv.load_study("two_joint_arm").drives.values() if one.leg is not None)
    drive = type(drive)(lengths=(0.3, 0.25, 0.1)[:joints], pulley_radius=drive.pulley_radius, leg=drive.leg)
    given = np.linspace(0.02, 0.05, joints)
    task = drive.home, given, 10.0 * given
    operated = drive.perform(pose=task[0], twist=task[1], wrench=task[2])
    ((_, said), *_) = drive.picture(operated, *task).keys
    assert said.endswith(f"{10.0 * given[-1]:.3g} N m")
    assert {*arm.data(drive, *task)} == (set() if joints == 1 else {"at rest", "in the task"})
    assert len(arm.draw_all(drive, operated, *task).axes) == (1 if joints == 1 else 2)


def test_drawn_carriage_on_one_wheel():
    carriage = iv.transmission.PlanarCarriage(contact=WHEEL)
    point = carriage.mechanism.operate(rates=[0.3, 0.4], heading=[np.arctan2(0.4, 0.3)])
    found = wheeled.steered(carriage, point)
    assert_allclose(found.force.sum(axis=0), -found.applied[0][2][:2], atol=1e-9)
    assert pictures.draw_all(wheeled.picture(found)).axes[0].get_title() == "instant centre at infinity"


def test_map_of_a_workspace_has_the_points_of_each_height():
    z = PLATFORM.home + np.linspace(-0.03, 0.03, 3)
    span = np.linspace(-0.12, 0.12, 9)
    found = iv.analysis.workspace_map(
        MACHINE, PLATFORM, x=span, y=span[:7], z=z, wrench=[5.0, 0, 0, 0, 0, 0], twist=RISING
    )
    numbers = workspace.data(found)
    assert [one["title"] for one in numbers] == [f"z = {1e3 * height:.4g} mm" for height in z]
    centre = MACHINE.operate(PLATFORM.at([0.0, span[3], z[2]]), wrench=[5.0, 0, 0, 0, 0, 0], twist=RISING)
    assert numbers[2]["loss"][4, 3] == pytest.approx(float(centre.loss), rel=1e-9)
    assert np.all(np.isnan(numbers[0]["loss"]) == (found.points.limit[:, :, 0] != iv.Limit.OK))
    made = found.plot()
    named = {text.get_text() for text in made.legends[0].get_texts()}
    assert named == {iv.Limit(int(code)).words for code in np.unique(found.points.limit) if code != iv.Limit.OK}
    with pytest.raises(iv.InputError, match="one position along x or y cannot be drawn"):
        iv.analysis.workspace_map(MACHINE, PLATFORM, x=[0.0], y=span, z=z, wrench=[0.0] * 6).plot()


@pytest.mark.slow
def test_best_cylinder_speeds_are_drawn_with_their_powers():
    wrench, twist = np.array([[0, 0, 20.0, 0, 0, 0]]), np.outer([1.0, 0.5, -1.0], RISING)
    found = iv.analysis.best_cylinder_speed(MACHINE, HOME, wrench=wrench, twist=twist)
    made = found.plot()
    assert [line.get_label() for line in made.axes[0].lines] == ["nominal", "best constant", "best of each motion"]
    assert made.axes[1].texts[1].get_text() == f" {found.fixed_power:.3g} W"
    none = iv.analysis.best_cylinder_speed(MACHINE, HOME, wrench=1e4 * wrench, twist=twist)
    assert none.plot().axes[1].texts[1].get_text().startswith(" infeasible")
