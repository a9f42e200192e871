"""Malformed machines of rolling contacts: one message each, or a point that names its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv

MEASURED = {
    "wheel_radius": 0.03,
    "preload": 200.0,
    "friction": 0.2,
    "creep_stiffness": 4000.0,
    "rolling_torque": 0.009,
    "bearing_torque": 0.006,
}
WHEEL = iv.RollingContact(**MEASURED)
BALL = iv.RollingContact(**MEASURED, surface="sphere")
WITH_FLOW_LOSS = replace(WHEEL, creep_law="faulring")
STUDY = iv.load_study("hand_controller")
LEG, SEPARATE = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
DRIVE, PLATFORM = iv.LeggedDrive.of(LEG, 6), iv.Platform.hexapod()
PAIR = iv.LeggedDrive.of(LEG, 2)
HOME = PLATFORM.at([0.0, 0.0, PLATFORM.home])
POINTS = ((0.4, 0.0), (-0.2, 0.25), (-0.2, -0.25))
CART = iv.PlanarCobot(contacts=WHEEL, positions=POINTS, mass=20.0, inertia=1.5)
MACHINE = CART.mechanism
SPHERE = iv.SphericalIVT(sphere_radius=0.03, drive=BALL)
ARM = iv.PlanarArm(lengths=(0.3, 0.25))
ROOT = math.sqrt(0.5)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
FIRST, SECOND = iv.Roller(position=X, axis=(0, -1, 0), shaft=1), iv.Roller(position=Y, axis=(-1, 0, 0), shaft=2)
STEERED = (iv.Roller(position=(-0.5, -0.5, ROOT)), iv.Roller(position=(-0.5, -0.5, -ROOT)))
AHEAD = [0.0, 0.0, 0.0]
NOT_A_ROW = "must be a real number or an array of them, got"


def cobot(**changed):
    return iv.PlanarCobot(**{"contacts": WHEEL, "positions": POINTS} | changed)


def sphere(**changed):
    return iv.SphericalIVT(**{"sphere_radius": 0.03, "drive": BALL} | changed)


def platform(**changed):
    return iv.Platform(**{"base": PLATFORM.base, "joints": PLATFORM.joints, "rod_length": 0.14} | changed)


def machine(**changed):
    return iv.Mechanism(**{"contacts": WHEEL, "jacobian": np.ones((1, 2, 2))} | changed)


def links(jacobian, **more):
    return iv.Configuration(jacobian=jacobian, **more)


def solve(rates, heading=AHEAD, **applied):
    return MACHINE.solve(heading=heading, rates=rates, applied={"y": 0.0, "angle": 0.0} | applied)


def moving(**changed):
    good = {"twist": [0.5, 0.0, 0.0], "steering": lambda time, pose: AHEAD, "duration": 0.1}
    return iv.planar_motion(CART, **good | changed)


def share(**changed):
    return iv.share_motor(LEG, SEPARATE, **{"force": [1.0]} | changed)


def chosen(**changed):
    tasks = {"steering_angle": 0.1, "input_speed": 1.0, "output_torque": 0.1}
    return iv.choose_rollers(SPHERE, **{"preload": [100.0], "wheel_radius": [0.01]} | tasks | changed)


def common(motions=1, **changed):
    given = {"wrench": np.zeros((motions, 6)), "twist": np.full((motions, 6), 0.01)} | changed
    return iv.best_cylinder_speed(given.pop("drive", DRIVE), given.pop("configuration", HOME), **given)


def static(**changed):
    given = {"position": [0.0, 0.0, 0.1], "wrench": np.zeros(6)} | changed
    return iv.static_points(given.pop("drive", DRIVE), given.pop("platform", PLATFORM), **given)


def mapped(**changed):
    return iv.workspace_map(DRIVE, PLATFORM, **{"x": [0.0], "y": [0.0], "z": [0.1], "wrench": np.zeros(6)} | changed)


BAD = {
    # one contact
    "preload must be > 0 N, got 0.0": lambda: replace(WHEEL, preload=0.0),
    "preload must be a number > 0 N, got '200 N'": lambda: replace(WHEEL, preload="200 N"),
    "preload must be a number > 0 N, got 'more'": lambda: WHEEL.pressed("more"),
    "friction must be > 0, got nan": lambda: replace(WHEEL, friction=math.nan),
    "wheel_radius must be > 0 m, got -0.01": lambda: replace(WHEEL, wheel_radius=-0.01),
    "creep_law must be one of linear, faulring, vermeulen-johnson, polach, fastsim, exact, got 3": lambda: replace(
        WHEEL, creep_law=3
    ),
    "steering_model must be one of shear, spin, got 'spn' (did you mean 'spin'?)": lambda: replace(
        WHEEL, steering_model="spn"
    ),
    "geometry is missing: steering_model = 'spin' needs it": lambda: replace(WHEEL, steering_model="spin"),
    # any machine
    f"jacobian {NOT_A_ROW} None": lambda: machine(jacobian=None),
    f"jacobian {NOT_A_ROW} [[[1, 0], [0]]]": lambda: machine(jacobian=[[[1, 0], [0]]]),
    f"jacobian {NOT_A_ROW} an array of shape (1, 2, 2)": lambda: machine(jacobian=1j * np.ones((1, 2, 2))),
    "jacobian must be of shape (..., wheels, 2, coordinates), got shape (1, 3, 2)": lambda: machine(
        jacobian=np.ones((1, 3, 2))
    ),
    f"surface {NOT_A_ROW} 'flat'": lambda: machine(surface="flat"),
    "jacobian and spin must broadcast to one shape, got shapes (2,) and (3,)": lambda: machine(
        jacobian=np.ones((2, 1, 2, 2)), spin=np.ones((3, 1, 2))
    ),
    "contacts must be RollingContact, one for all or one for each wheel of the jacobian, got None": lambda: machine(
        contacts=None
    ),
    "coordinates must be 2 different names, got 3": lambda: machine(coordinates=3),
    "coordinates must be 2 different names, got (1, 2)": lambda: machine(coordinates=(1, 2)),
    "creep_law must be one without a flow loss, got 'faulring'": lambda: machine(contacts=WITH_FLOW_LOSS),
    f"rates {NOT_A_ROW} 'fast'": lambda: MACHINE.operate(rates="fast", heading=AHEAD),
    "rates must be finite, got [inf]": lambda: MACHINE.operate(rates=[math.inf, 0, 0], heading=AHEAD),
    "rates and heading must broadcast to one shape, got shapes (2,) and (3,)": lambda: MACHINE.operate(
        rates=np.ones((2, 3)), heading=np.zeros((3, 3))
    ),
    f"heading {NOT_A_ROW} None": lambda: MACHINE.operate(rates=X, heading=None),
    "heading must be angles, or a tuple of their cosines and sines, got a tuple of 3": lambda: MACHINE.operate(
        rates=X, heading=(0.0, 0.0, 0.0)
    ),
    "heading must be cosines and sines whose squares add up to 1, got [4.]": lambda: MACHINE.operate(
        rates=X, heading=([2.0, 2.0, 2.0], AHEAD)
    ),
    "steering_rate must be one number, or of shape (..., 3), got shape (2,)": lambda: MACHINE.operate(
        rates=X, heading=AHEAD, steering_rate=[1.0, 2.0]
    ),
    "steering_rate must be finite rad/s, got nan": lambda: MACHINE.operate(
        rates=X, heading=AHEAD, steering_rate=math.nan
    ),
    "stick_speed must be > 0 m/s, got -1.0": lambda: MACHINE.operate(rates=X, heading=AHEAD, stick_speed=-1.0),
    f"rates of x {NOT_A_ROW} 'fast'": lambda: solve({"x": "fast"}),
    "rates must be a mapping of coordinate to value, got [1.0]": lambda: solve([1.0]),
    "applied of y must be finite, got [inf]": lambda: solve({"x": 1.0}, y=math.inf),
    "x and y must broadcast to one shape, got shapes (2,) and (3,)": lambda: solve({"x": np.ones(2)}, y=np.ones(3)),
    "applied must be a mapping of coordinate to value, got [1.0]": lambda: MACHINE.steer(rates=X, applied=[1.0]),
    # steered wheels on a plane
    "contact must be a RollingContact, got None": lambda: iv.PlanarCarriage(contact=None),
    "surface must be 'plane' for a machine on a plane, got 'sphere'": lambda: iv.PlanarCarriage(contact=BALL),
    "contacts must be RollingContact, one for all or one for each position, got 3": lambda: cobot(contacts=3),
    "contacts must be 3, one for each position, got 2": lambda: cobot(contacts=(WHEEL, WHEEL)),
    "positions must be one row of x and y for each wheel, got shape (0,)": lambda: cobot(positions=[]),
    "positions must be one row of x and y for each wheel, got shape (2,)": lambda: cobot(positions=[0.0, 1.0]),
    "positions must be one row of x and y for each wheel, got shape (1, 3)": lambda: cobot(positions=[(0, 0, 0)]),
    "positions must be finite m, got nan or infinity": lambda: cobot(positions=[(0, 0), (1, math.inf), (0, 1)]),
    f"positions {NOT_A_ROW} [(0, 0), (1,)]": lambda: cobot(positions=[(0, 0), (1,)]),
    "mass must be one number in kg, got an array of shape (2,)": lambda: cobot(mass=np.array([1.0, 2.0])),
    "inertia must be > 0 kg m^2, got nan": lambda: cobot(inertia=math.nan),
    f"twist {NOT_A_ROW} 'forward'": lambda: CART.headings("forward"),
    "twist must be of shape (..., 3), got shape (2,)": lambda: CART.headings([1.0, 0.0]),
    "wrench has an unknown coordinate 'z'; coordinates: x, y, angle": lambda: CART.headings(X, {"z": 1.0}),
    "heading must be finite, got nan": lambda: CART.freedom([0.0, 0.0, math.nan]),
    "heading must be of shape (..., 3), one for each wheel, got shape (2,)": lambda: CART.freedom([0.0, 0.0]),
    "steering must be a function of time and pose, got None": lambda: moving(steering=None),
    "steering must be finite, got [nan nan nan] at 0 s": lambda: moving(steering=lambda time, pose: [math.nan] * 3),
    "steering must be finite, got [nan nan nan] at 0.0": lambda: moving(
        steering=lambda time, pose: [math.nan if time > 0.05 else 0.0] * 3
    ),
    "wrench must be a function of time and pose, got [1.0, 0, 0]": lambda: moving(wrench=[1.0, 0, 0]),
    "wrench must be of shape (3,), two forces and a moment, got shape (2,)": lambda: moving(
        wrench=lambda time, pose, twist: [1.0, 0.0]
    ),
    "pose must be three finite numbers, got [nan, 0, 0]": lambda: moving(pose=[math.nan, 0, 0]),
    "duration must be one number in s, got '1 s'": lambda: moving(duration="1 s"),
    # a sphere between rollers
    "sphere_radius must be one number, got an array of shape (2,)": lambda: sphere(sphere_radius=np.ones(2)),
    "drive must be a RollingContact, got None": lambda: sphere(drive=None),
    "drive.preload must be one number, got an array of shape (2,)": lambda: sphere(
        drive=replace(BALL, preload=np.array([100.0, 200.0]))
    ),
    "rollers must be a row of Roller, got 3": lambda: sphere(rollers=3),
    "rollers have none on shaft 1: each shaft needs a drive roller": lambda: sphere(rollers=[]),
    "positions of all rollers lie in one plane with the centre: nothing holds the sphere across it": lambda: sphere(
        rollers=[FIRST, SECOND, iv.Roller(position=(-ROOT, -ROOT, 0))]
    ),
    "preloads of the rollers do not balance": lambda: sphere(steering=replace(BALL, preload=50.0)),
    "roller 2 does not roll with the others": lambda: sphere(
        rollers=[FIRST, iv.Roller(position=Y, axis=Z, shaft=2), *STEERED]
    ),
    "position must be a unit vector, got one of length nan": lambda: iv.Roller(position=(math.nan, 0, 1)),
    "shaft must be 1, 2 or None, got True": lambda: iv.Roller(position=X, axis=Y, shaft=True),
    "factor must be > 0, got 0.0": lambda: SPHERE.pressed(0.0),
    "wheel_radius must be > 0 m, got 0.0": lambda: SPHERE.with_roller_radius(0.0),
    f"steering_angle {NOT_A_ROW} '45 deg'": lambda: SPHERE.ideal_speeds("45 deg"),
    "steering_angle must be finite, got nan": lambda: SPHERE.operate(steering_angle=math.nan, sphere_speed=1, load=1),
    "sphere_speed must be finite, got inf": lambda: SPHERE.operate(steering_angle=0.1, sphere_speed=math.inf, load=1),
    "steering_angle and sphere_speed must broadcast to one shape, got shapes (2,) and (3,)": lambda: SPHERE.operate(
        steering_angle=np.ones(2), sphere_speed=np.ones(3), load=1
    ),
    "ivt must be a SphericalIVT, got 3": lambda: iv.sphere_map(3, [0.1], [1.0], sphere_speed=1.0),
    "sphere_speed must be one number in rad/s, got None": lambda: iv.sphere_map(
        SPHERE, [0.1], [1.0], sphere_speed=None
    ),
    "load must be a row of finite numbers, got []": lambda: iv.sphere_map(SPHERE, [0.1], [], sphere_speed=1.0),
    "preload must be > 0 N, got [0.]": lambda: chosen(preload=[0.0]),
    "input_speed must be finite, got nan": lambda: chosen(input_speed=math.nan),
    # legs, platforms and arms
    f"jacobian {NOT_A_ROW} 'six'": lambda: links("six"),
    "jacobian must be of shape (..., links, components), with at least": lambda: links(np.ones((2, 3))),
    "link_position and jacobian must broadcast to one shape, got shapes (3,) and (2,)": lambda: links(
        np.eye(2), link_position=[1.0, 2.0, 3.0]
    ),
    "utilisation must be a mapping of Limit, got a demand of 'slip'": lambda: links(np.eye(2), utilisation={"slip": 1}),
    "utilisation of TRAVEL must be one number": lambda: links(np.eye(2), utilisation={iv.Limit.TRAVEL: np.ones(3)}),
    "link_speeds must be of shape (..., 2), one for each link, got shape (3,)": lambda: links(np.eye(2)).twist_of(
        [1.0, 2.0, 3.0]
    ),
    "transmission must be a RotaryLinearIVT, got RollingContact": lambda: iv.Legs(transmission=WHEEL, count=2),
    "count must be a whole number of legs, 1 or more, got 2.0": lambda: replace(DRIVE.legs, count=2.0),
    "transmission.preload must be one number, or one for each of 3 legs, got shape (2,)": lambda: iv.Legs(
        transmission=replace(LEG.transmission, preload=np.array([100.0, 200.0])), count=3
    ),
    "configuration must be a Configuration, got array([[1.]])": lambda: DRIVE.legs.operate(
        np.eye(1), cylinder_speed=1.0, wrench=[1.0]
    ),
    "configuration must be a Configuration, got None": lambda: DRIVE.legs.mechanism(None),
    f"wrench {NOT_A_ROW} None": lambda: DRIVE.operate(HOME, wrench=None),
    "cylinder_speed and wrench must broadcast to one shape, got shapes (3,) and (2,)": lambda: PAIR.legs.operate(
        links(np.eye(2)), cylinder_speed=np.ones(3), wrench=np.ones((2, 2))
    ),
    "base must be of shape (rods, 3), with six rods or more, got shape (5, 3)": lambda: platform(base=np.ones((5, 3))),
    "rod_length must be one number in m, got an array of shape (6,)": lambda: platform(rod_length=np.full(6, 0.1)),
    "rod_length must be > 0.05562 m to reach the platform on the axis": lambda: (
        iv.Platform.hexapod(rod_length=0.03).home
    ),
    "stroke must be a range from the lowest to the highest position, got (nan, 1.0) m": lambda: platform(
        stroke=(math.nan, 1.0)
    ),
    "base_radius must be > 0 m, got -1.0": lambda: iv.Platform.hexapod(base_radius=-1.0),
    "base_spread must be one number in rad, got 'wide'": lambda: iv.Platform.hexapod(base_spread="wide"),
    "position and rotation must broadcast to one shape, got shapes (2,) and (3,)": lambda: PLATFORM.at(
        np.zeros((2, 3)), np.zeros((3, 3))
    ),
    "lengths must be a row of numbers, got 3.0": lambda: iv.PlanarArm(lengths=3.0),
    "lengths must be one length or more, got none": lambda: iv.PlanarArm(lengths=()),
    "angles must be finite rad, got nan or inf": lambda: ARM.jacobian([math.nan, 0]),
    "force must be of shape (..., 3), got shape (2,)": lambda: ARM.joint_torques([0, 0], [1.0, 2.0]),
    "angles and force must broadcast to one shape, got shapes (2,) and (3,)": lambda: ARM.joint_torques(
        np.zeros((2, 2)), np.ones((3, 3))
    ),
    "pulley_radius must be > 0 m, got nan": lambda: ARM.parallel(math.nan),
    "wheel must be a RollingContact, got None": lambda: ARM.serial(None, 0.05),
    "wheel.surface must be 'plane', got 'sphere'": lambda: ARM.serial(BALL, 0.05),
    # many legs on one motor
    "cylinder_speed must be != 0 rad/s, got 0.0": lambda: replace(DRIVE, cylinder_speed=0.0),
    "motor must be a Motor, got None": lambda: replace(DRIVE, motor=None),
    f"cylinder_speed {NOT_A_ROW} 'fast'": lambda: DRIVE.operate(HOME, wrench=np.zeros(6), cylinder_speed="fast"),
    "cylinder_acceleration must be finite rad/s^2, got nan or inf": lambda: DRIVE.operate(
        HOME, wrench=np.zeros(6), cylinder_acceleration=math.nan
    ),
    "direction must be a wrench that is not 0, got 0": lambda: DRIVE.largest_wrench(HOME, np.zeros(6)),
    "cylinder_speed must be other than 0 rad/s to move the machine, got 0": lambda: DRIVE.wrench_set(
        HOME, twist=[0, 0, 0.1, 0, 0, 0], cylinder_speed=0.0
    ),
    "configuration must be of 2, as many as there are legs, got 6 links": lambda: PAIR.wrench_set(HOME),
    "twist must be one row of 6, got shape (2, 6)": lambda: DRIVE.wrench_set(HOME, twist=np.ones((2, 6))),
    "configuration must be a regular pose within reach, got one whose links hold no full wrench": lambda: (
        DRIVE.wrench_set(platform(joints=np.zeros((6, 3))).at([0, 0, 0.1]))
    ),
    "link_force must be > 0 N, got nan": lambda: iv.WrenchSet.of(HOME, math.nan),
    "bound must be >= 0 and finite": lambda: DRIVE.wrench_set(HOME).cut(np.ones(6), math.nan),
    "wrench must be of shape (..., 6), got shape (1,)": lambda: DRIVE.wrench_set(HOME).contains([1.0]),
    "drive must be a LeggedDrive, got 3": lambda: static(drive=3),
    "platform must be a Platform, got 3": lambda: static(platform=3),
    "position must be of shape (..., 3), got shape ()": lambda: static(position=0.1),
    "wrench must be finite, got nan or inf": lambda: static(wrench=np.full(6, math.nan)),
    "workers must be a whole number of threads, 1 or more, got 0": lambda: static(workers=0),
    "x must be finite m, got nan or inf": lambda: mapped(x=[math.nan]),
    "wrench must be 6 numbers, got shape ()": lambda: mapped(wrench=None),
    "wrench and twist must be those of one motion or more, got none": lambda: common(0),
    "wrench and twist must be those of 12 instants of a cycle or more, got 2": lambda: common(2, period=1.0),
    "period must be one number in s, got 'long'": lambda: common(12, period="long"),
    "force must be a row of forces >= 0 that rise N, got []": lambda: share(force=[]),
    "legs must be whole numbers, 1 or more, got six": lambda: share(legs="six"),
    "speed must be finite m/s, got nan": lambda: share(speed=math.nan),
    "run_up_time must be one number in s, got None": lambda: share(run_up_time=None),
    "duty must be between 0 and 1, got []": lambda: share(duty=[]),
}


@pytest.mark.parametrize("message", BAD)
def test_malformed_machines(message):
    with pytest.raises(iv.InputError) as caught:
        BAD[message]()
    assert str(caught.value).startswith(message)


SINGULAR = platform(joints=np.zeros((6, 3))).at([0.0, 0.0, 0.1])
ACROSS = 0.5 * math.pi * np.ones(3)
BEYOND = {
    "all wheels across the way": (iv.Limit.SLIP, lambda: solve({"x": 1.0}, ACROSS)),
    "a load beyond slip": (iv.Limit.SLIP, lambda: solve({"x": 1.0}, y=1e5)),
    "an unknown heading": (iv.Limit.SLIP, lambda: MACHINE.operate(rates=X, heading=[math.nan, 0, 0])),
    "an unknown rate": (iv.Limit.SLIP, lambda: MACHINE.operate(rates=[math.nan, 0, 0], heading=AHEAD)),
    "a sphere that slips": (iv.Limit.SLIP, lambda: SPHERE.operate(steering_angle=0.7, sphere_speed=1.0, load=1e4)),
    "a locked shaft": (iv.Limit.SLIP, lambda: SPHERE.operate(steering_angle=0.0, input_speed=1.0, output_torque=0.1)),
    "links in one plane": (iv.Limit.SLIP, lambda: PAIR.operate(links(np.ones((2, 2))), wrench=[1, 0], twist=[0.1, 0])),
    "links that move nothing": (iv.Limit.SLIP, lambda: PAIR.operate(links(np.zeros((2, 2))), wrench=[1.0, 0.0])),
    "a singular pose": (iv.Limit.SLIP, lambda: DRIVE.operate(SINGULAR, wrench=np.ones(6), twist=np.zeros(6))),
    "a singular pose, locked": (iv.Limit.SLIP, lambda: DRIVE.operate(SINGULAR, wrench=np.ones(6))),
    "rods too short": (
        iv.Limit.LINKAGE,
        lambda: DRIVE.operate(platform(rod_length=0.03).at([0, 0, 0.1]), wrench=np.zeros(6), twist=np.zeros(6)),
    ),
    "rods too short, many poses": (iv.Limit.LINKAGE, lambda: static(platform=platform(rod_length=0.03))),
    "a pose out of reach": (iv.Limit.LINKAGE, lambda: static(position=[1.0, 0.0, 0.1])),
    "a link beyond its stroke": (iv.Limit.TRAVEL, lambda: static(position=[0, 0, PLATFORM.home + 0.1])),
    "a wheel on a cylinder at rest": (
        iv.Limit.SLIP,
        lambda: DRIVE.operate(HOME, wrench=np.zeros(6), twist=[0, 0, 0.1, 0, 0, 0], cylinder_speed=0.0),
    ),
    "a speed without any feasible one": (iv.Limit.SLIP, lambda: common(2, wrench=np.full((2, 6), 1e5))),
}


@pytest.mark.parametrize("case", BEYOND)
def test_infeasible_points_name_their_limit(case):
    limit, make = BEYOND[case]
    assert np.all(np.asarray(make().limit) == limit)


def test_infeasible_forces_of_a_shared_motor_name_their_limit():
    found = share(force=[10.0, 1e5], legs=(1, 6))
    assert np.all(found.turning_limit == [[iv.Limit.OK, iv.Limit.SLIP]] * 2)
    assert found.separate_limit[0] == iv.Limit.OK != found.separate_limit[1]
    assert np.all(np.isfinite(found.turning[..., 0]))
    assert np.array_equal(found.turning_feasible, found.turning_limit == iv.Limit.OK)
    assert np.array_equal(found.separate_feasible, [True, False])
