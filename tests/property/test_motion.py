"""Inverse dynamics of whole drives: power balances instant by instant, and how fast the wheel is steered."""

from dataclasses import replace

import numpy as np
from designs import POINTS, amplifiers, elements, gearheads, motors, seeds
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit, RotaryLinearIVT
from infinivar.motion import Course
from internals import Varying, steering_rates

ROUNDING = 1e-12


def with_rotor(motor, inertia):
    return replace(motor, rotor_inertia=inertia)


inertias = st.floats(1e-8, 1e-3)


@st.composite
def conventional_drives(draw):
    return iv.ConventionalDrive(
        motor=with_rotor(draw(motors()), draw(inertias)),
        gearhead=replace(draw(gearheads()), inertia=draw(inertias)),
        amplifier=draw(amplifiers()),
        pulley=iv.parts.Pulley(radius=draw(st.floats(0.001, 0.1)), friction_torque=draw(st.floats(0, 0.05))),
        guideway=iv.parts.Guideway(friction=draw(st.floats(0, 10))),
        output_inertia=draw(inertias),
    )


@st.composite
def cobotic_drives(draw):
    return iv.CoboticDrive(
        motor=with_rotor(draw(motors()), draw(inertias)),
        gearhead=replace(draw(gearheads()), inertia=draw(inertias)),
        amplifier=draw(amplifiers()),
        transmission=draw(elements(st.sampled_from(["linear", "vermeulen-johnson", "polach"]))),
        cylinder_speed=draw(st.floats(0.5, 200)) * draw(st.sampled_from([-1, 1])),
        guideway=iv.parts.Guideway(coefficient=draw(st.floats(0, 0.01)), friction=draw(st.floats(0, 2))),
        cylinder_inertia=draw(inertias),
        link_mass=draw(st.floats(0.01, 5)),
        steering=iv.drivetrain.SteeringPlant(
            motor=with_rotor(draw(motors()), draw(inertias)),
            ratio=draw(st.floats(0.5, 50)),
            bell_inertia=draw(inertias),
            sliding_friction=draw(st.floats(0.01, 0.5)),
            patch_half_length=draw(st.floats(1e-5, 1e-3)),
            bell_friction=draw(st.floats(0, 1e-3)),
        ),
    )


def courses(seed, speed=1.0, force=50.0):
    """Instants of anything, in all four quadrants."""
    random = np.random.default_rng(seed)
    sizes = {"speed": speed, "acceleration": 10 * speed, "jerk": 100 * speed, "snap": 1e3 * speed}
    sizes |= {"force": force, "force_rate": 10 * force, "force_curvature": 100 * force}
    return Course(**{name: random.uniform(-size, size, POINTS) for name, size in sizes.items()})


def assert_balanced(point, moves):
    """What comes from the supply goes to the load, is lost, or flows into an inertia."""
    shape = moves.shape
    flows = [point.power_in, -point.power_out, *(-loss for loss in point.losses.values())]
    flows += [-flow for flow in point.stored.values()]
    flows = [np.broadcast_to(flow, shape)[moves] for flow in flows]
    assert np.all(np.abs(sum(flows)) <= ROUNDING * sum(np.abs(flow) for flow in flows))
    total = sum(np.abs(flow) for flow in flows)
    for loss in point.losses.values():
        assert np.all(np.broadcast_to(loss, shape)[moves] >= -ROUNDING * total)


@given(conventional_drives(), st.floats(0, 5), seeds)
def test_conventional_drive_balances(drive, mass, seed):
    course = courses(seed)
    point = drive.follow(course, load_mass=mass)
    assert_balanced(point, np.ones(POINTS, dtype=bool))
    assert_allclose(point.power_out, (mass * course.acceleration - course.force) * course.speed, rtol=1e-12)


@given(cobotic_drives(), st.floats(0, 5), st.booleans(), st.booleans(), seeds)
def test_cobotic_drive_balances(drive, mass, common_bus, flywheel, seed):
    """With the cylinder at constant speed or not, and with one DC bus or two; nan only where the wheel slips."""
    random = np.random.default_rng(seed)
    course = courses(seed, force=0.3 * drive.transmission.slip_force)
    turning = None
    if flywheel:
        turning = Varying(
            *(drive.cylinder_speed * random.uniform(*ends, POINTS) for ends in ((0.5, 2), (-5, 5), (-50, 50)))
        )
    point = drive.follow(course, load_mass=mass, cylinder_speed=turning, common_bus=common_bus)
    moves = ~np.isnan(np.broadcast_to(point.power_in, (POINTS,)))
    assert np.all(moves | (point.utilisation[Limit.SLIP, "wheel"] > 1))
    assert_balanced(point, moves)


@given(cobotic_drives(), st.floats(0.1, 2), seeds)
def test_standing_still_is_the_steady_point(drive, mass, seed):
    """Without acceleration, jerk and changes of force, motion is steady operation; the wheel is not steered."""
    random = np.random.default_rng(seed)
    speed, force = random.uniform(-1, 1, POINTS), random.uniform(-1, 1, POINTS) * drive.transmission.slip_force
    point = drive.follow(Course(speed=speed, acceleration=0.0 * speed, force=-force), load_mass=mass)
    steady = drive.operate(speed=speed, force=force)
    standby = drive.amplifier.standby_power
    assert_allclose(point.power_in - standby, steady.power_in - standby, rtol=1e-9, atol=1e-9)
    assert np.all(np.nan_to_num(point.states["steering_rate_rad_s"]) == 0)


@given(elements(st.sampled_from(["linear", "vermeulen-johnson", "polach", "fastsim"])), st.sampled_from([-1, 1]), seeds)
@example(
    RotaryLinearIVT(
        cylinder_radius=0.5,
        wheel_radius=0.125,
        preload=1.0,
        friction=1.0,
        creep_stiffness=20.0,
        rolling_torque=0.0,
        bearing_torque=0.001953125,
        creep_law="vermeulen-johnson",
    ),
    -1,
    7545581,
)
def test_steering_rates_are_those_of_the_angle(element, way, seed):
    """Against differences of `steer` over time, along smooth motions with a cylinder that changes its speed.

    The differences of fourth order leave 1e-9 of the rate and 1e-5 of the acceleration. Where the force changes its sign
    between them, the third derivative of a nonlinear law jumps, and they differ from those of second order: left out.
    """
    random = np.random.default_rng(seed)
    w, phase = random.uniform(1, 8, 3), random.uniform(0, 6, 3)
    omega, surface = 14.0, 14.0 * element.cylinder_radius
    sizes = (2.0 * way, 0.8 * surface, 0.5 * element.slip_force)
    offsets = (omega * way, 0.0, 0.0)

    def jet(index, time):
        turn = w[index] * time + phase[index]
        size, rate = sizes[index], w[index]
        return Varying(
            offsets[index] + size * np.sin(turn), size * rate * np.cos(turn), -size * rate * rate * np.sin(turn)
        )

    def angle(time):
        cylinder, speed, force = (jet(index, time).value for index in range(3))
        return element.steer(cylinder_speed=cylinder, link_speed=speed, link_force=force)

    time = random.uniform(0, 3, 40)
    cylinder, speed, force = (jet(index, time) for index in range(3))
    rate, acceleration = steering_rates(
        element, tangent=np.tan(angle(time)), cylinder_speed=cylinder, link_speed=speed, link_force=force
    )
    step = 1e-4
    before2, before, here, after, after2 = (angle(time + shift * step) for shift in (-2, -1, 0, 1, 2))
    known = ~np.isnan(before2 + before + here + after + after2)
    differences = (before2 - 8 * before + 8 * after - after2) / (12 * step)
    second = (-before2 + 16 * before - 30 * here + 16 * after - after2) / (12 * step**2)
    plain = (before - 2 * here + after) / step**2
    known &= np.abs(plain - second) < 5e-5 * (np.abs(second) + np.max(w) ** 2)
    assert_allclose(rate[known], differences[known], rtol=1e-7, atol=1e-7 * np.max(w))
    assert_allclose(acceleration[known], second[known], rtol=1e-4, atol=1e-4 * np.max(w) ** 2)
