"""Carts whose wheels motors drive: balances in four quadrants, closed forms, and a search of another kind."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import root

import infinivar as iv
from infinivar import Limit
from infinivar.machines import PlanarDrive, Wheel
from infinivar.motion import Point
from internals import power_audit as audit
from internals import wheeled_picture as wheeled
from made import loaded

SLIP, STIFFNESS, RADIUS, RESISTANCE = 240.0, 12000.0, 0.05, 6.6
WHEEL = Wheel(
    wheel_radius=RADIUS,
    preload=600.0,
    friction=0.4,
    creep_stiffness=STIFFNESS,
    rolling_torque=0.8 * RADIUS * RESISTANCE,
    bearing_torque=0.2 * RADIUS * RESISTANCE,
    creep_law="exact",
)
FREE = replace(WHEEL, rolling_torque=0.0, bearing_torque=0.0)
POINTS = (Point(x=0.4), Point(x=-0.2, y=0.25), Point(x=-0.2, y=-0.25))
MOTOR = loaded("hand_controller").drives["motor2-gear4"]
STORING = replace(MOTOR, amplifier=iv.parts.Amplifier(regeneration="store", storage_efficiency=0.8, efficiency=0.95))
CARTS = {
    "all wheels": PlanarDrive(wheel=WHEEL, positions=POINTS, drive=STORING),
    "rear wheels": PlanarDrive(wheel=WHEEL, positions=POINTS, drive=MOTOR, driven_wheels=(2, 3)),
    "two wheels": PlanarDrive(wheel=WHEEL, positions=POINTS[:2], drive=STORING, pulley_radius=0.02),
    "carriage": PlanarDrive(wheel=WHEEL, drive=STORING),
    "with spin": PlanarDrive(
        wheel=Wheel(
            wheel_radius=0.012,
            preload=65.0,
            friction=0.2,
            geometry=loaded("hand_controller").drives["cobotic"].transmission.geometry,
        ),
        positions=POINTS,
        drive=STORING,
    ),
}


@pytest.mark.parametrize("name", CARTS)
def test_powers_balance_in_four_quadrants(name):
    """2,000 points: electrical power in is power out and losses to 1e-9, torques are equal, and no loss is negative."""
    cart, random = CARTS[name], np.random.default_rng(5)
    slip = WHEEL.friction * WHEEL.preload if name != "with spin" else 13.0
    twist = random.uniform(-1, 1, (2000, 3)) * [0.5, 0.5, 0.8]
    wrench = random.uniform(-1, 1, (2000, 3)) * [slip, slip, 0.3 * slip]
    d = len(cart.coordinates)
    twist, wrench = twist[:, :d], wrench[:, :d]
    point = cart.perform(pose=np.zeros(d), twist=twist, wrench=wrench)
    known = np.isfinite(point.power_in)
    assert known.mean() > 0.5
    assert audit(point.power_in, point.power_out, point.losses, name) < 1e-9
    signs = {tuple(one) for one in np.sign(np.stack([twist[known, 0], wrench[known, 0]], -1)).astype(int)}
    assert signs == {(1, 1), (1, -1), (-1, 1), (-1, -1)}
    if cart.drive is STORING and name != "with spin":  # whose forces are below the friction of its drives
        assert np.any(point.power_in[known] < 0.0)
    wheels = cart.operated(twist[known], wrench[known])
    assert_allclose(wheels.applied[:, :d], wrench[known], rtol=0, atol=1e-8 * slip)
    torque = -wheels.applied[:, d:]
    assert np.max(np.ptp(torque[:, cart.driven], axis=1)) <= 1e-9 * slip
    free = np.delete(torque, cart.driven, axis=1)
    assert np.all(np.abs(free) <= 1e-9 * slip)


@pytest.mark.parametrize("driven", [(1, 2, 3), (2, 3), (1,)])
@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("force", [150.0, -60.0])
def test_straight_ahead_in_closed_form(driven, way, force):
    """Each of n motors drives its own wheel, with an n-th of the force and of the rolling resistance of the free ones."""
    cart = PlanarDrive(wheel=WHEEL, positions=POINTS, drive=MOTOR, driven_wheels=driven)
    twist, wrench = np.array([way * 0.5, 0.0, 0.0]), np.array([way * force, 0.0, 0.0])
    point, count = cart.perform(pose=np.zeros(3), twist=twist, wrench=wrench), len(driven)
    traction = (force + (3 - count) * RESISTANCE) / count
    rolled = 0.5 / (1.0 - WHEEL.on("plane").creepage(traction))
    motor = MOTOR.operate(speed=rolled, force=traction + RESISTANCE)
    assert_allclose(point.power_in, count * motor.power_in, rtol=1e-8)
    assert_allclose(point.states["traction_N"], count * (traction + RESISTANCE), rtol=1e-9)
    assert_allclose(point.demands[Limit.THERMAL, f"motor {driven[0]}"], motor.utilisation[Limit.THERMAL], rtol=1e-8)
    assert_allclose(point.demands[Limit.VOLTAGE, f"motor {driven[-1]}"], motor.utilisation[Limit.VOLTAGE], rtol=1e-8)


def test_headings_and_torque_of_two_wheels_by_another_search():
    """Two wheels leave nothing open: `scipy.optimize.root` of `PlanarCobot.drive` finds the same headings and torque."""
    cart, random = CARTS["two wheels"], np.random.default_rng(6)
    for twist, wrench in zip(
        random.uniform(-1, 1, (8, 3)) * [0.5, 0.5, 0.5], random.uniform(-60, 60, (8, 3)), strict=True
    ):
        wrench[2] *= 0.3
        found = cart.operated(twist, wrench)
        assert found.limit == Limit.OK

        def missing(unknown, twist=twist, wrench=wrench):
            made = cart.machine.drive(twist=twist, heading=unknown[:2], torque=unknown[2])
            return made.applied[:3] - wrench

        ahead = cart.machine.headings(twist)
        other = root(missing, [*ahead, 0.0], tol=1e-11)
        assert np.max(np.abs(other.fun)) < 1e-5
        assert_allclose(other.x[:2], found.heading, rtol=0, atol=1e-6)
        assert_allclose(other.x[2], -found.applied[3], rtol=1e-5, atol=1e-6)


def test_a_cart_without_traction_is_pushed_by_nobody():
    """Where the load pulls as much as creep brakes, motors exert nothing, and wheels are steered as those of a pushed cart."""
    pushed = PlanarDrive(wheel=FREE, positions=POINTS[:2])
    driven = replace(pushed, drive=MOTOR)
    twist, across = np.array([0.5, 0.1, 0.2]), np.array([-20.0, 100.0, 10.0])
    wrench = across - twist * (across @ twist) / (twist @ twist)
    for _ in range(20):  # the source then supplies nothing
        lost = sum(pushed.operated(twist, wrench).losses.values())
        wrench = wrench - twist * (wrench @ twist + lost) / (twist @ twist)
    one, other = (cart.perform(pose=np.zeros(3), twist=twist, wrench=wrench) for cart in (pushed, driven))
    assert lost > 0.05
    assert_allclose(one.states["push_N"], 0.0, atol=1e-9)
    assert_allclose(other.states["traction_N"], 0.0, atol=1e-7)
    assert_allclose(other.steering, one.steering, rtol=0, atol=1e-9)
    assert_allclose(other.losses["creep"], one.losses["creep"], rtol=1e-7)


def test_traction_and_side_load_share_one_slip_limit():
    """With linear creep the demand of a wheel is the size of its force over mu P; beyond it no motion is found."""
    cart = PlanarDrive(wheel=replace(WHEEL, creep_law="linear"), positions=(Point(x=0.3), Point(x=-0.3)), drive=MOTOR)
    for size, fits in ((0.9, True), (0.99, True), (1.02, False)):
        wrench = 2.0 * size * SLIP * np.array([0.8, 0.6, 0.0])
        point = cart.perform(pose=np.zeros(3), twist=np.array([0.5, 0.0, 0.0]), wrench=wrench)
        demand = point.demands[Limit.SLIP, "wheel 1"]
        assert [bool(demand <= 1.0), bool(point.limit != Limit.SLIP)] == [fits, fits]
        if fits:
            assert demand == pytest.approx(size, rel=1e-9)


def test_speed_limit_of_the_fastest_wheel():
    cart = replace(CARTS["rear wheels"], largest_speed=1.25)
    point = cart.perform(pose=np.zeros(3), twist=np.array([0.5, 0.0, 2.0]), wrench=np.zeros(3))
    fastest = np.hypot(0.5 + 2.0 * 0.25, -2.0 * 0.2)
    assert point.demands[Limit.OUTPUT_SPEED, "cart, largest_speed"] == pytest.approx(fastest / 1.25)


def test_path_of_a_cart_that_hardly_creeps_is_that_of_its_motors():
    """A path along x by inverse dynamics: three motors move a third of the cart each, with their rotors."""
    stiff = replace(WHEEL, creep_stiffness=1e6, creep_law="linear")
    cart = PlanarDrive(wheel=stiff, positions=POINTS, drive=MOTOR, mass=60.0, inertia=5.0)
    path = iv.motion.MachinePath(
        x=iv.motion.Sinusoid(distance=0.5, frequency=0.2), wrench=iv.motion.Wrench(x=30.0), load_mass=12.0
    )
    found = iv.follow_path(cart, path)
    assert set(found.point.stored) == {"machine", "rotors"}
    rate = 2.0 * np.pi * 0.2
    speed = found.twist[:, 0]
    acceleration = -(rate**2) * found.pose[:, 0]
    push = (30.0 + 72.0 * acceleration) / 3.0 + np.sign(speed) * RESISTANCE
    course = iv.motion.Course(speed=speed, acceleration=acceleration, force=-push)
    motor = MOTOR.follow(course)
    moves = np.abs(speed) > 0.02
    assert_allclose(found.point.power_in[moves], 3.0 * motor.power_in[moves], rtol=2e-4, atol=1e-3)
    assert found.audit_residual < 1e-9
    assert np.mean(found.point.losses["winding"]) == pytest.approx(3.0 * np.mean(motor.losses["winding"]), rel=2e-2)


def test_path_with_steering_closes_and_counts_all():
    """Along a curve with reversals, powers balance at every instant with servos, rotors and masses."""
    plant = loaded("guided_cart").drives["cart"].steering
    cart = replace(CARTS["rear wheels"], mass=60.0, inertia=5.0, steering=plant)
    assert cart.lacking == {}
    path = iv.motion.MachinePath(
        x=iv.motion.Sinusoid(distance=0.5, frequency=0.2),
        y=iv.motion.Sinusoid(distance=0.2, frequency=0.2, start=1.0),
        wrench=iv.motion.Wrench(x=20.0),
    )
    found = iv.follow_path(cart, path)
    assert np.all(np.isfinite(found.point.power_in))
    assert set(found.point.stored) == {"machine", "rotors", "steering"}
    assert found.audit_residual < 1e-9
    assert found.mean_power > found.steady_power > 0.0
    # A machine that returns to where it was stores nothing.
    for stored in found.point.stored.values():
        assert abs(np.mean(stored)) < 1e-3 * found.mean_power


MESSAGES = {
    "largest_push must be left out: drive, not a user, moves the cart, got 60.0 N": {"largest_push": 60.0},
    "driven_wheels must be different numbers of wheels, from 1 to 3, got 1, 4": {"driven_wheels": (1, 4)},
    "driven_wheels must be different numbers of wheels, from 1 to 3, got 2, 2": {"driven_wheels": (2, 2)},
    "driven_wheels must be different numbers of wheels, from 1 to 3, got none": {"driven_wheels": ()},
    "driven_wheels does not apply without drive: a user or a slide pushes the cart": {
        "driven_wheels": (1,),
        "drive": None,
    },
    "pulley_radius does not apply without drive: a user or a slide pushes the cart": {
        "pulley_radius": 0.1,
        "drive": None,
    },
}


@pytest.mark.parametrize("message", MESSAGES)
def test_messages(message):
    with pytest.raises(iv.ParameterError) as caught:
        replace(CARTS["all wheels"], **MESSAGES[message])
    assert str(caught.value) == message


def test_drawn_forces_of_a_driven_cart_and_of_omniwheels():
    """The ground's forces on the wheels are those on the load; tractions drive the wheels that have motors."""
    cart, twist, wrench = CARTS["rear wheels"], np.array([0.5, 0.0, 0.3]), np.array([150.0, 20.0, 4.0])
    found = wheeled.steered(cart.machine, cart.operated(twist, wrench), wrench)
    moments = found.positions[:, 0] * found.force[:, 1] - found.positions[:, 1] * found.force[:, 0]
    assert_allclose([*found.force.sum(axis=0), moments.sum()], wrench, rtol=0, atol=1e-7)
    ((look, name, load),) = found.applied
    assert (look, name) == ("load-force", "force of the load")
    assert_allclose(load, -wrench, rtol=0, atol=1e-7)
    assert abs(found.traction[0]) < 1e-7
    assert_allclose(
        found.traction[1:], cart.perform(pose=np.zeros(3), twist=twist, wrench=wrench).states["traction_N"] / 2
    )
    shown = cart.picture(None, np.zeros(3), twist, wrench)
    assert f"traction of a motor, {found.traction[1]:.3g} N at most" in [words for _, words in shown.keys]
    assert "the tractions of its motors, and of its load" in cart.shown
    platform = loaded("omniwheel_platform").drives["three-motors"]
    task = loaded("omniwheel_platform").tasks["push"]
    done = iv.perform_task(platform, task)
    other = wheeled.rolled(platform, done.steady, done.pose, done.twist, done.wrench)
    work = np.sum(other.traction * other.rolling) - platform.rolling_friction * platform.load_of_wheel * np.sum(
        np.abs(other.rolling)
    )
    assert work == pytest.approx(done.wrench @ done.twist + done.steady.losses["rollers"], rel=1e-9)
