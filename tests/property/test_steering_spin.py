"""Steering as spin: signs and passivity of the contact, its inverse, drives that follow motions, and turning on the spot."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.contact import spin
from internals import Steering, relative_velocities, spin_calls, turning
from made import parameter_study

RNG_SEED = 17
SHEAR = parameter_study("faulring2006").drives["cobotic"]
DRIVE = replace(SHEAR, transmission=replace(SHEAR.transmission, steering_model="spin"))
ELEMENT = DRIVE.transmission
SPEED = DRIVE.cylinder_speed


def _patch():
    return turning.TurningPatch.of(ELEMENT, ELEMENT.groups(SPEED))


def _signed(rng, low, high, count):
    return np.exp(rng.uniform(np.log(low), np.log(high), count)) * rng.choice([-1.0, 1.0], count)


def test_contact_takes_power_in_all_quadrants():
    """200,000 random points over all patches; lateral force and moment are bounded by full slip."""
    rng = np.random.default_rng(RNG_SEED)
    for _ in range(40):
        ratio, lever = float(np.exp(rng.uniform(np.log(0.05), np.log(20.0)))), 10.0 ** rng.uniform(-5, -2)
        given = {"slip_force": 10.0 ** rng.uniform(0, 4), "lever": lever, "a_over_b": ratio}
        given |= {"poisson": float(rng.uniform(0.0, 0.5)), "stick_speed": float(rng.choice([0.0, 1e-4, 1e-2]))}
        given["creep_stiffness"] = given["slip_force"] * rng.uniform(50.0, 1000.0)
        u, v, rate = (_signed(rng, low, high, 5000) for low, high in ((1e-6, 1.0), (1e-4, 3.0), (1e-3, 300.0)))
        force, moment = turning.law(u, rate, v, **given)
        power = force * u + moment * rate
        assert np.min(power) >= 0.0
        assert np.max(np.abs(force)) <= 1.003 * given["slip_force"]
        assert np.max(np.abs(moment)) <= 1.003 * 3.0 * math.pi / 16.0 * given["slip_force"] * lever


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_signs_are_those_of_the_solver(way):
    """In axes that move with the wheel: x where it rolls to, y so that phi turns x towards y; both ways of rolling."""
    patch, contact = _patch(), ELEMENT.contact
    angle, rate, link_speed, surface = 0.3, 5.0 * way, 0.2, -0.6 * way
    u, v = relative_velocities(link_speed, surface, math.cos(angle), math.sin(angle))
    along, across = (math.sin(angle), math.cos(angle)), (math.cos(angle), -math.sin(angle))  # of v and u, in l and c
    x, y = np.multiply(np.sign(v), along), np.multiply(np.sign(v), across)
    later = np.multiply(np.sign(v), (math.sin(angle + 1e-6), math.cos(angle + 1e-6)))
    assert float((later - x) @ y) == pytest.approx(1e-6, rel=1e-5)  # phi turns x towards y

    wheel = link_speed * np.array([1.0, 0.0]) - surface * np.array([0.0, 1.0])  # velocity relative to the surface
    size = math.sqrt(contact.patch.a * contact.patch.b)
    scale = contact.shear_modulus * size**2 / patch.slip_force
    solved = iv.contact.RollingPatch(contact.axis_ratio, contact.poisson).steady(
        lateral=scale * float(wheel @ y) / abs(v), spin=scale * size * rate / abs(v)
    )
    force, moment = turning.law(u, rate, v, **patch._asdict())
    on_surface = patch.slip_force * solved.fy * y
    assert force == pytest.approx(float(on_surface @ across), abs=0.008 * patch.slip_force)
    assert moment == pytest.approx(patch.slip_force * size * solved.mz, abs=0.008 * patch.slip_force * patch.lever)


@pytest.mark.parametrize("law", ["linear", "exact"])
def test_delivered_motion(law):
    """Four quadrants: forces are those of the law, the power balance closes, and the angle gives the motion."""
    rng = np.random.default_rng(RNG_SEED)
    count = 4000
    omega, rate = SPEED * rng.choice([-1.0, 1.0], count), _signed(rng, 1e-2, 60.0, count)
    speed, force = _signed(rng, 1e-4, 2.0, count), 70.0 * rng.uniform(-1.0, 1.0, count)
    element = replace(ELEMENT, creep_law=law)  # with "exact", the creep stiffness changes with the angle
    point, moment = turning.deliver(
        element, cylinder_speed=omega, link_speed=speed, link_force=force, steering_rate=rate
    )
    found = np.isfinite(point.torque)
    assert np.mean(found) > 0.9
    assert np.all(found | (point.limit == int(iv.Limit.SLIP)))
    sine = np.sin(np.arctan(point.steering_tangent))
    patch = _patch()._replace(creep_stiffness=element.groups(SPEED).steered(sine * sine).creep_stiffness)
    lateral, again = turning.law(point.creep_speed, rate, point.rolling_speed, **patch._asdict())
    assert_allclose(lateral[found], point.lateral_force[found], atol=1e-7)
    assert_allclose(again[found], moment[found])
    assert_allclose(
        (point.power_in - point.power_out)[found], sum(point.losses.values())[found], atol=1e-12 * np.max(np.abs(force))
    )
    cosine = 1.0 / np.sqrt(1.0 + point.steering_tangent**2)
    u, v = relative_velocities(speed, ELEMENT.cylinder_radius * omega, cosine, point.steering_tangent * cosine)
    assert_allclose(u[found], point.creep_speed[found], atol=1e-12)
    assert_allclose(v[found], point.rolling_speed[found], atol=1e-12)
    assert np.all((point.losses["creep"] + moment * rate)[found] >= 0.0)


def test_steering_changes_creepage_at_equal_force():
    """Without force, spin makes the wheel creep; slowly steered, it creeps as it does without."""
    forces = np.array([0.0, 20.0, 20.0, 20.0])
    rates = np.array([6.0, 0.0, 6.0, -6.0])
    point, _ = turning.deliver(ELEMENT, cylinder_speed=SPEED, link_speed=0.0, link_force=forces, steering_rate=rates)
    creepage = point.creep_speed / np.abs(point.rolling_speed)
    assert abs(creepage[0]) > 5e-4
    slow = ELEMENT.groups(SPEED)
    exact = iv.contact.spin_map(ELEMENT.contact.axis_ratio, ELEMENT.contact.poisson)
    scaled = exact.lateral_creepage(point.lateral_force[1] / slow.slip_force, 0.0) * exact.scale.c22
    assert creepage[1] == pytest.approx(scaled / slow.creep_group, rel=1e-9)
    assert abs(creepage[2] - creepage[3]) > 1e-3


def test_following_a_motion_closes_the_balance():
    """Power in is power out, losses and stored; every loss takes power, and the steering motor feels the patch's moment."""
    rng = np.random.default_rng(RNG_SEED)
    for _ in range(5):
        motion = iv.motion.Sinusoid(distance=rng.uniform(0.01, 0.06), frequency=rng.uniform(0.5, 4.0))
        duty = iv.DutyCycle(motion=motion, load_mass=rng.uniform(0.2, 2.0))
        point = DRIVE.follow(duty.instants(orders=DRIVE.orders).course, load_mass=duty.moved_mass)
        rest = point.power_in - point.power_out - sum(point.losses.values()) - sum(point.stored.values())
        assert np.max(np.abs(rest)) < 1e-9 * np.max(np.abs(point.power_in))
        assert min(float(np.min(loss)) for loss in point.losses.values()) > -1e-12


def test_knee():
    """Energies per stride as the theory page states them; the losses of steering make the difference."""
    study = iv.load_study(Path(__file__).parents[2] / "studies" / "knee_walking.toml")
    drive, duty = study.drives["cobotic"], study.duty["walking"]
    constant = replace(drive, transmission=replace(drive.transmission, steering_model="shear"))
    shear, found = iv.duty_cycle(constant, duty), iv.duty_cycle(drive, duty)
    assert (shear.energy, found.energy) == (pytest.approx(6.997, abs=0.005), pytest.approx(5.698, abs=0.005))
    for loss, before, after in (
        ("steering winding", 1.577, 0.392),
        ("creep", 0.055, 0.082),
        ("steering patch", 0.256, 0.121),
    ):
        assert shear.losses[loss] == pytest.approx(before, abs=0.002)
        assert found.losses[loss] == pytest.approx(after, abs=0.002)


def test_rate_without_the_creep_by_spin():
    """The steering rate is that of a wheel without spin: differenced angles with spin agree to 1 % of the largest rate."""
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.06, frequency=2.0), load_mass=2.0)
    instants = duty.instants(orders=DRIVE.orders)
    point = DRIVE.follow(instants.course, load_mass=duty.moved_mass)
    time = np.asarray(instants.time)
    turned, _ = turning.deliver(
        ELEMENT,
        cylinder_speed=SPEED,
        link_speed=instants.course.speed,
        link_force=instants.course.driving_force(duty.moved_mass + DRIVE.link_mass).value,
        steering_rate=point.states["steering_rate_rad_s"],
    )
    differenced = np.gradient(np.arctan(turned.steering_tangent), time)
    rate = point.states["steering_rate_rad_s"]
    assert np.max(np.abs(differenced - rate)[2:-2]) < 0.01 * np.max(np.abs(rate))


@pytest.mark.parametrize(("law", "frequency"), [("linear", 1.0), ("exact", 2.0)])
@pytest.mark.slow
def test_simulated_and_prescribed_motion_take_the_same_energy(law, frequency):
    """Inverse dynamics and simulation book the same losses, as closely as without spin: controllers follow a motion roughly."""
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.03, frequency=frequency), load_mass=1.0)
    found = iv.analysis.two_ways(replace(DRIVE, transmission=replace(ELEMENT, creep_law=law)), duty)
    assert found.followed == pytest.approx(found.as_turning, rel=0.002)
    for loss in ("creep", "steering patch"):
        assert found.lost_followed[loss] == pytest.approx(found.lost_prescribed[loss], rel=0.05)
    assert found.lost_followed["slip"] == 0.0


@pytest.mark.slow
def test_audit_of_a_simulation():
    """Every element's balance and the energy balance over time are checked within; here the contact's own."""
    scenario = iv.Scenario(motion=iv.motion.Sinusoid(distance=0.04, frequency=3.0), load_mass=1.0, duration=0.5)
    run = iv.simulate(DRIVE, scenario)
    assert run.complete
    lost = run.trajectory.lost
    assert {"creep", "slip", "steering patch"} <= set(lost)
    assert all(np.min(np.diff(energy)) >= -1e-9 for energy in lost.values())


@pytest.mark.parametrize("share", [-0.8, 0.0, 0.5])
@pytest.mark.parametrize("rate", [2.0, -2.0])
def test_turning_on_the_spot(share, rate):
    """As the wheel ceases to roll, force and moment approach the limit, whichever way it is steered and rolled."""
    creep, moment = turning.on_the_spot(ELEMENT, share * ELEMENT.slip_force)
    for v, stick in ((1e-7, 0.0), (-1e-7, 0.0), (0.0, 1e-7)):
        force, found = turning.law(creep * abs(rate), rate, v, stick_speed=stick, **_patch()._asdict())
        assert force == pytest.approx(share * ELEMENT.slip_force, abs=1e-3 * ELEMENT.slip_force)
        assert found == pytest.approx(math.copysign(moment, rate), rel=1e-3)


def test_on_the_spot_without_load():
    """No creep, and the moment of a patch that slips as a rigid body; with load, a smaller one; nan from the slip force on."""
    patch = ELEMENT.contact.patch
    creep, moment = turning.on_the_spot(ELEMENT, np.array([0.0, 0.6, 1.0]) * ELEMENT.slip_force)
    assert creep[0] == pytest.approx(0.0, abs=1e-9)
    assert moment[0] == pytest.approx(
        spin.ellipse_moment(ELEMENT.preload, patch.a, patch.b, ELEMENT.friction), rel=1e-4
    )
    assert moment[1] < 0.95 * moment[0]
    assert creep[1] > 0.0
    assert np.isnan(creep[2])


def test_moment_grows_with_the_rate_to_that_on_the_spot():
    """6 rad/s at 0.7 m/s: spin alone causes 34 N of 78 N and a third of the moment of the patch that turns on the spot."""
    rates = np.array([1.0, 6.0, 20.0, 1e6])
    force, moment = turning.law(0.0, rates, 0.7, **_patch()._asdict())
    assert force[1] == pytest.approx(34.0, abs=0.6)
    assert ELEMENT.slip_force == pytest.approx(78.0)
    assert np.all(np.diff(moment) > 0.0)
    assert moment[-1] == pytest.approx(turning.on_the_spot(ELEMENT, 0.0)[1], rel=1e-3)


def test_generated_code_calls_the_same_map():
    """Floats, arrays, JAX and CasADi: force and moment at random points, and at none."""
    rng = np.random.default_rng(RNG_SEED)
    x, y = rng.normal(size=(2, 50)) * 3.0
    patch = iv.contact.spin_map(0.6, 0.3)
    scale = patch.scale
    forces = patch.forces(x / scale.c22, y / (scale.c22 * scale.lever))
    expected = (forces.fy, forces.mz / scale.lever)
    calls = (spin_calls.force_ratio, spin_calls.moment_ratio)
    for call, values in zip(calls, expected, strict=True):
        assert_allclose([call(a, b, 0.6, 0.3) for a, b in zip(x.tolist(), y.tolist(), strict=True)], values, atol=1e-13)
        assert_allclose(call(x, y, 0.6, 0.3), values, atol=1e-13)
        assert call(0.0, 0.0, 0.6, 0.3) == 0.0
        assert math.isnan(call(math.nan, 0.0, 0.6, 0.3))
    casadi = pytest.importorskip("casadi")
    one, two = casadi.SX.sym("x"), casadi.SX.sym("y")
    found = casadi.Function("f", [one, two], [call(one, two, 0.6, 0.3) for call in calls])
    assert_allclose(
        [[float(value) for value in found(a, b)] for a, b in zip(x, y, strict=True)], np.transpose(expected), atol=1e-13
    )
    assert [float(value) for value in found(0.0, 0.0)] == [0.0, 0.0]


def test_spin_is_the_default_with_the_exact_law_and_needs_geometry():
    element = SHEAR.transmission
    assert not element.turns_with_spin
    exact = replace(element, creep_law="exact")
    assert exact.turns_with_spin
    assert not replace(exact, creep_law="polach").turns_with_spin
    assert not replace(exact, steering_model="shear").turns_with_spin
    measured = {"creep_stiffness": 3e4, "rolling_torque": 4e-4, "bearing_torque": 2e-3}
    with pytest.raises(iv.ParameterError, match="geometry is missing: steering_model = 'spin' needs it"):
        replace(ELEMENT, geometry=None, **measured)
    assert not replace(exact, geometry=None, **measured).turns_with_spin
    with pytest.raises(iv.ParameterError, match="steering_model must be one of shear, spin, got 'roll'"):
        replace(ELEMENT, steering_model="roll")


def test_transmission_plant_alone():
    """Its graph has the steering rate as a source, and power balances there."""
    assert "from_steering" in {element.name for element in iv.plant_graph(DRIVE, "transmission").elements}
    assert "from_steering" not in {element.name for element in iv.plant_graph(SHEAR, "transmission").elements}


def test_angle_of_a_motion_is_found_under_fast_steering():
    """From an angle and a creepage within slip to the motion and back, up to 0.95 of slip and an edge at 0.08 of the speed."""
    rng = np.random.default_rng(RNG_SEED)
    count = 4000
    element = replace(ELEMENT, creep_law="exact")
    groups, patch = element.groups(SPEED), _patch()
    surface = element.cylinder_radius * SPEED
    omega, rate = SPEED * rng.choice([-1.0, 1.0], count), _signed(rng, 0.1, 0.08 * surface / patch.lever, count)
    steering = Steering.at_angle(np, rng.uniform(-1.3, 1.3, count))
    local = groups.steered(steering.sine**2).creep_stiffness
    # The creepage is a share of that of full slip; it moves the link, which changes the rolling speed.
    share, rolling = rng.uniform(-0.9, 0.9, count), -element.cylinder_radius * omega * steering.cosine
    for _ in range(60):
        u = share * (groups.full_slip * groups.slip_force / local * np.abs(rolling) + patch.lever * np.abs(rate))
        speed = (u - element.cylinder_radius * omega * steering.sine) / steering.cosine
        rolling = speed * steering.sine - element.cylinder_radius * omega * steering.cosine
    lateral, moment = turning.law(u, rate, rolling, **patch._replace(creep_stiffness=local)._asdict())
    tangent = steering.sine / steering.cosine
    along = np.sign(omega) * groups.slip_force * groups.rolling_group * tangent
    force = steering.cosine * (along - lateral)
    point, found = turning.deliver(
        element, cylinder_speed=omega, link_speed=speed, link_force=force, steering_rate=rate
    )
    sure = (np.abs(lateral) < 0.95 * groups.slip_force) & (np.sign(rolling) == -np.sign(omega))
    assert np.mean(sure) > 0.7
    missed = sure & ~(np.abs(point.steering_tangent - tangent) < 1e-6 * (1.0 + np.abs(tangent)))
    assert np.mean(missed[sure]) < 1e-3
    assert_allclose(found[sure & ~missed], moment[sure & ~missed], atol=1e-6 * patch.slip_force * patch.lever)
