"""Legs on a common cylinder: balanced in all quadrants, equal to one wheel, to any machine of contacts and to closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import infinivar as iv
from infinivar import Limit
from infinivar.transmission import Configuration, Legs, Platform
from internals import CREEP_LAWS as LAWS
from internals import legs as formulas
from made import loaded

HARD = loaded("hand_controller").drives["cobotic"].transmission
QUADRANTS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
seeds = st.integers(0, 2**32 - 1)


def wheel(law="linear", **changes):
    values = {
        "cylinder_radius": 0.05,
        "wheel_radius": 0.01,
        "preload": 300.0,
        "friction": 0.2,
        "creep_stiffness": 9000.0,
    }
    torques = {"rolling_torque": 4e-3, "bearing_torque": 2e-3}
    return iv.RotaryLinearIVT(**values | torques | {"creep_law": LAWS[law]} | changes)


IDEAL = {"rolling_torque": 0.0, "bearing_torque": 0.0}


def off_balance(point):
    """Residual of the balance of powers, over the powers that pass the contacts."""
    passed = np.abs(point.leg_torque * np.asarray(point.cylinder_speed)[..., None]).sum(axis=-1)
    passed = passed + np.abs(point.link_force * point.link_speed).sum(axis=-1)
    given = point.cylinder_speed * point.torque - np.sum(point.wrench * point.twist, axis=-1)
    return np.abs(given - sum(point.losses.values())) / passed


def random_points(random, count, links, freedoms, slip=60.0):
    """Machines, motions and loads from light to beyond slip."""
    jacobian = random.normal(size=(count, links, freedoms))
    force = random.uniform(-1.2, 1.2, (count, links)) * slip * random.uniform(0, 1, (count, 1)) ** 2
    wrench = np.matmul(np.swapaxes(jacobian, -1, -2), force[..., None])[..., 0]
    return Configuration(jacobian=jacobian), wrench, random.normal(0, 0.2, (count, freedoms))


@given(st.sampled_from(sorted(LAWS)), st.integers(1, 6), st.integers(0, 2), st.sampled_from([-1, 1]), seeds)
def test_legs_are_passive_and_balanced(law, freedoms, more, sign, seed):
    random = np.random.default_rng(seed)
    legs = Legs(transmission=wheel(law), count=freedoms + more, guideway=iv.parts.Guideway(friction=0.3))
    found, wrench, twist = random_points(random, 60, freedoms + more, freedoms)
    point = legs.operate(found, cylinder_speed=sign * random.uniform(2, 30, 60), wrench=wrench, twist=twist)
    holds = point.limit == Limit.OK
    assert np.all(off_balance(point)[holds] < 1e-9)
    for loss in point.losses.values():
        assert np.all(loss[holds] >= -1e-12)
    assert_allclose(np.sum(point.loss_of_legs, axis=-1)[holds], sum(point.losses.values())[holds], rtol=1e-12)
    balance = np.matmul(np.swapaxes(found.jacobian, -1, -2), point.link_force[..., None])[..., 0]
    assert_allclose(balance, wrench, rtol=0, atol=1e-8 * (1 + np.abs(wrench).max()))


@pytest.mark.slow
@pytest.mark.parametrize("law", sorted(LAWS))
def test_power_closure_at_many_points(law):
    """100,000 poses of six legs per law, each leg in any quadrant, locked and moving."""
    random = np.random.default_rng(7)
    legs = Legs(transmission=wheel(law), count=6, guideway=iv.parts.Guideway(friction=0.3))
    for motion in (True, False):
        for _ in range(5):
            found, wrench, twist = random_points(random, 10_000, 6, 6)
            speed = random.choice([-1, 1], 10_000) * random.uniform(1, 30, 10_000)
            point = legs.operate(found, cylinder_speed=speed, wrench=wrench, twist=twist if motion else None)
            holds = point.limit == Limit.OK
            assert 0.3 < np.mean(holds) < 0.99
            assert off_balance(point)[holds].max() < 1e-9
            if motion:
                signs = np.sign(point.link_speed * speed[:, None]), np.sign(point.link_force * speed[:, None])
                assert all(np.any((signs[0] == one) & (signs[1] == other)) for one, other in QUADRANTS)


@given(st.sampled_from(sorted(LAWS)), seeds)
def test_one_leg_is_the_wheel_on_a_cylinder(law, seed):
    random = np.random.default_rng(seed)
    force, speed = random.uniform(-70, 70, 50), random.uniform(-0.5, 0.5, 50)
    omega = random.choice([-1, 1], 50) * random.uniform(5, 20, 50)
    known = wheel(law).deliver(cylinder_speed=omega, link_speed=speed, link_force=force)
    one = Configuration(jacobian=[[1.0]])
    point = Legs(transmission=wheel(law), count=1).operate(
        one, cylinder_speed=omega, wrench=force[:, None], twist=speed[:, None]
    )
    assert_array_equal(point.torque, known.torque)
    assert_array_equal(point.steering_tangent[:, 0], known.steering_tangent)
    assert_array_equal(point.limit, known.limit)
    assert_array_equal(point.power_in, known.power_in)
    for name, loss in known.losses.items():
        assert_array_equal(point.losses[name], loss)
    locked = wheel(law).operate(cylinder_speed=omega, steering_angle=0.0, link_force=force)
    found = Legs(transmission=wheel(law), count=1).operate(one, cylinder_speed=omega, wrench=force[:, None])
    assert_array_equal(found.twist[:, 0], locked.link_speed)


@given(st.sampled_from(["linear", "vermeulen-johnson", "exact"]), st.integers(0, 2), seeds)
def test_legs_are_a_machine_of_contacts(law, more, seed):
    """The steering angles of the legs, given to the machine of any contacts, need the same wrench and torque."""
    random = np.random.default_rng(seed)
    legs = Legs(transmission=replace(HARD, creep_law=LAWS[law]), count=3 + more)
    found, wrench, twist = random_points(random, 10, 3 + more, 3, slip=40.0)
    point = legs.operate(found, cylinder_speed=14.0, wrench=wrench, twist=twist)
    cosine = 1.0 / np.sqrt(1.0 + point.steering_tangent**2)
    rates = np.concatenate([twist, np.full((10, 1), 14.0)], axis=-1)
    heading = (point.steering_tangent * cosine, cosine)
    same = legs.mechanism(found).operate(rates=rates, heading=heading)
    holds = point.limit == Limit.OK
    assert np.any(holds)
    # A link force follows from the slip angle, whose rounding the creep stiffness of 50 kN amplifies.
    assert_allclose(same.applied[holds, :3], wrench[holds], rtol=0, atol=1e-6)
    assert_allclose(same.applied[holds, 3], -point.torque[holds], rtol=0, atol=1e-7)
    for name, loss in same.losses.items():
        assert_allclose(loss[holds], point.losses[name][holds], rtol=1e-6, atol=1e-9)


def test_headings_of_the_machine_of_contacts_are_the_steering_angles():
    platform = Platform.hexapod()
    found = platform.at([0.01, -0.005, platform.home], [0.05, 0.1, -0.1])
    wrench, twist = np.array([10.0, -5.0, 20.0, 0.3, 0.2, -0.1]), np.array([0.1, 0.05, 0.1, 0.4, -0.3, 0.5])
    legs = Legs(transmission=HARD, count=6)
    point = legs.operate(found, cylinder_speed=14.0, wrench=wrench, twist=twist)
    machine = legs.mechanism(found)
    rates = np.append(twist, 14.0)
    cosine, sine = machine.steer(rates=rates, applied={f"xi{place + 1}": one for place, one in enumerate(wrench)})
    assert_allclose(cosine / sine, point.steering_tangent, rtol=0, atol=1e-9)
    assert_allclose(machine.operate(rates=rates, heading=(cosine, sine)).applied[6], -point.torque, rtol=1e-9)


def test_each_leg_may_have_its_own_preload():
    preload = np.array([300.0, 200.0, 400.0])
    found, force, speed = Configuration(jacobian=np.eye(3)), np.array([20.0, -10.0, 30.0]), np.array([0.1, -0.2, 0.3])
    point = Legs(transmission=wheel(preload=preload), count=3).operate(
        found, cylinder_speed=10.0, wrench=force, twist=speed
    )
    each = [
        wheel(preload=one).deliver(cylinder_speed=10.0, link_speed=v, link_force=f)
        for one, v, f in zip(preload, speed, force, strict=True)
    ]
    assert_allclose(point.torque, sum(one.torque for one in each), rtol=1e-14)
    with pytest.raises(iv.ParameterError, match="transmission must be one wheel for all legs"):
        Legs(transmission=wheel(preload=preload), count=3).mechanism(found)


# Platform


@given(seeds)
def test_jacobian_of_the_platform_against_differences(seed):
    random = np.random.default_rng(seed)
    platform = Platform.hexapod()
    position = np.array([0, 0, platform.home]) + random.uniform(-0.02, 0.02, 3)
    rotation = random.uniform(-0.3, 0.3, 3)
    found = platform.at(position, rotation)
    step = 1e-6

    def turned(axis, angle):
        """Rotation vector after a further small turn about a fixed axis."""
        from scipy.spatial.transform import Rotation

        return (Rotation.from_rotvec(angle * np.eye(3)[axis]) * Rotation.from_rotvec(rotation)).as_rotvec()

    for axis in range(3):
        shift = step * np.eye(3)[axis]
        moved = [platform.at(position + sign * shift, rotation).link_position for sign in (1, -1)]
        assert_allclose((moved[0] - moved[1]) / (2 * step), found.jacobian[:, axis], rtol=0, atol=1e-8)
        moved = [platform.at(position, turned(axis, sign * step)).link_position for sign in (1, -1)]
        assert_allclose((moved[0] - moved[1]) / (2 * step), found.jacobian[:, 3 + axis], rtol=0, atol=1e-9)


def test_rods_keep_their_length():
    from scipy.spatial.transform import Rotation

    platform, random = Platform.hexapod(), np.random.default_rng(1)
    position = np.array([0, 0, platform.home]) + random.uniform(-0.02, 0.02, (50, 3))
    rotation = random.uniform(-0.5, 0.5, (50, 3))
    found = platform.at(position, rotation)
    top = position[:, None] + np.array([Rotation.from_rotvec(one).apply(np.array(platform.joints)) for one in rotation])
    bottom = platform.base + found.link_position[..., None] * np.array([0, 0, 1])
    assert_allclose(np.linalg.norm(top - bottom, axis=-1), platform.rod_length, rtol=1e-14)
    assert np.all(top[..., 2] > bottom[..., 2])
    at_home = platform.at([0, 0, platform.home])
    assert abs(np.mean(at_home.link_position)) < 1e-15
    assert platform.provenance == "assumed"


def test_poses_out_of_reach_and_singular_poses_are_data():
    platform = Platform.hexapod()
    legs = Legs(transmission=HARD, count=6)
    positions = [[0, 0, platform.home], [0.3, 0, platform.home], [0, 0, platform.home + 0.06]]
    point = legs.operate(platform.at(positions), cylinder_speed=14.0, wrench=np.zeros(6), twist=np.zeros(6))
    assert_array_equal(point.limit, [Limit.OK, Limit.LINKAGE, Limit.TRAVEL])
    assert_array_equal(np.isnan(point.power_in), [False, True, False])
    assert point.utilisation[Limit.TRAVEL][2] == pytest.approx(0.06 / 0.05)
    # All rods vertical: nothing holds a force along x.
    upright = Platform(base=platform.base, joints=platform.base, rod_length=0.14).at([0, 0, 0.14])
    sideways = legs.operate(upright, cylinder_speed=14.0, wrench=[1.0, 0, 0, 0, 0, 0], twist=np.zeros(6))
    assert sideways.limit == Limit.SLIP
    mixed = Configuration(jacobian=np.stack([platform.at([0, 0, platform.home]).jacobian, upright.jacobian]))
    both = legs.operate(mixed, cylinder_speed=14.0, wrench=[1.0, 0, 0, 0, 0, 0], twist=np.zeros(6))
    assert_array_equal(both.limit, [Limit.OK, Limit.SLIP])


# Locked machines


def test_creep_drift_of_a_locked_platform():
    """``xi = -(R omega/C) (J^T J)^-1 W``, against the wrench; exact for the linear law."""
    platform, random = Platform.hexapod(), np.random.default_rng(2)
    found = platform.at(np.array([0, 0, platform.home]) + random.uniform(-0.02, 0.02, (40, 3)))
    wrench = random.normal(size=(40, 6)) * [10, 10, 10, 0.3, 0.3, 0.3]
    for omega in (14.0, -3.0):
        legs = Legs(transmission=HARD, count=6)
        point = legs.operate(found, cylinder_speed=omega, wrench=wrench)
        assert np.all(point.limit == Limit.OK)
        drift = formulas.creep_drift(
            found.jacobian, wrench, HARD.cylinder_radius * omega, HARD.groups(omega).creep_stiffness
        )
        assert_allclose(point.twist, drift, rtol=1e-9)
        assert np.all(np.sum(point.twist * wrench, axis=-1) < 0)
        assert np.all(off_balance(point) < 1e-12)


def test_locked_machine_with_the_cylinder_at_rest_holds_until_a_wheel_slips():
    legs, found = Legs(transmission=wheel(), count=2), Configuration(jacobian=[[1.0, 0.5], [0.2, 1.0]])
    direction = np.array([1.0, -2.0])
    most = 60.0 / np.max(np.abs(np.linalg.solve(found.jacobian.T, direction)))
    held = legs.operate(found, cylinder_speed=0.0, wrench=0.999 * most * direction)
    assert held.limit == Limit.OK
    assert_array_equal(held.twist, [0.0, 0.0])
    assert legs.operate(found, cylinder_speed=0.0, wrench=1.001 * most * direction).limit == Limit.SLIP


def test_guideway_holds_a_small_load_of_a_locked_link():
    legs = Legs(transmission=wheel(), count=1, guideway=iv.parts.Guideway(friction=2.0))
    free, stuck = (
        legs.operate(Configuration(jacobian=[[1.0]]), cylinder_speed=10.0, wrench=[-load]) for load in (5.0, 1.9)
    )
    assert stuck.twist[0] == 0.0
    assert free.twist[0] == pytest.approx(0.05 * 10.0 * 3.0 / 9000.0)
    assert free.losses["guideway"] == pytest.approx(2.0 * free.twist[0])
    assert off_balance(free) < 1e-12


# Choice of the cylinder speed


def small_creep_loss(speed, surface, force, stiffness):
    """By the linear law with ``fu = f/cos(phi)``, ``tan(phi) = -ldot/S`` and ``v = S/cos(phi)``."""
    return force**2 / stiffness * (surface**2 + speed**2) ** 1.5 / surface**2


def coupled_inertia(inertia, mass, radius, tangent):
    """Of a cylinder with ideal legs: coasting keeps its product with the square of the cylinder's speed."""
    return inertia + np.sum(np.asarray(mass) * np.square(radius * np.asarray(tangent)), axis=-1)


def test_creep_loss_is_least_at_sqrt_2():
    """The closed form against the wheel itself, without rolling resistance and with a stiff contact."""
    stiff = wheel(creep_stiffness=9e7, **IDEAL)
    legs, one = Legs(transmission=stiff, count=1), Configuration(jacobian=[[1.0]])
    speed, force = 0.31, 17.0

    def loss(surface):
        point = legs.operate(one, cylinder_speed=surface / 0.05, wrench=[force], twist=[speed])
        return float(sum(point.losses.values()))

    for surface in (0.2, 0.5, 2.0):
        assert loss(surface) == pytest.approx(small_creep_loss(speed, surface, force, 9e7), rel=1e-5)
    found = minimize_scalar(loss, bounds=(0.1, 2.0), method="bounded", options={"xatol": 1e-10})
    assert found.x == pytest.approx(formulas.least_creep_speed(speed), rel=1e-5)
    assert found.fun / (force * speed) == pytest.approx(1.5 * math.sqrt(3.0) * force / 9e7, rel=1e-5)
    angle = legs.operate(one, cylinder_speed=found.x / 0.05, wrench=[force], twist=[speed]).steering_tangent
    assert math.degrees(math.atan(abs(angle[0]))) == pytest.approx(35.26, abs=0.01)


def test_rolling_and_creep_loss_of_a_leg():
    """``F0 sqrt(S^2 + ldot^2) + f^2 (S^2 + ldot^2)^1.5/(C S^2)`` for small creep, where rolling resistance is small beside f."""
    stiff, one = wheel(creep_stiffness=1e6, rolling_torque=4e-5, bearing_torque=2e-5), Configuration(jacobian=[[1.0]])
    for speed, surface, force in ((0.3, 0.4, 20.0), (0.1, 0.9, -35.0), (0.5, 0.5, 10.0)):
        point = Legs(transmission=stiff, count=1).operate(
            one, cylinder_speed=surface / 0.05, wrench=[force], twist=[speed]
        )
        assert point.losses["rolling"] + point.losses["bearing"] == pytest.approx(
            6e-5 / 0.01 * math.hypot(surface, speed), rel=1e-4
        )
        assert point.losses["creep"] == pytest.approx(small_creep_loss(speed, surface, force, 1e6), rel=2e-3)


@given(st.floats(0.05, 0.95), st.floats(0.01, 1.0))
def test_slowest_cylinder_before_slip(share, speed):
    stiff = wheel(creep_stiffness=9e9, **IDEAL)
    legs, one = Legs(transmission=stiff, count=1), Configuration(jacobian=[[1.0]])
    surface = formulas.least_surface_speed(speed, share * 60.0, 60.0)
    for factor, limit in ((1.001, Limit.OK), (0.999, Limit.SLIP)):
        point = legs.operate(one, cylinder_speed=factor * surface / 0.05, wrench=[share * 60.0], twist=[speed])
        assert point.limit == limit
    assert legs.force_limits([speed], surface / 0.05) == pytest.approx(share * 60.0, rel=1e-9)
    assert formulas.least_surface_speed(speed, 60.0, 60.0) == np.inf


# Coasting


def test_coasting_keeps_the_energy_of_ideal_legs():
    """Two legs steered as their cylinder turns freely: ``(J + sum m (R t)^2) omega^2`` stays, and energy with losses exactly."""
    inertia, mass, radius = 2e-3, np.array([0.4, 0.7]), 0.05
    stiff = wheel(creep_stiffness=4e4, preload=900.0, **IDEAL)

    def angles(time):
        return np.array([0.5 + 0.3 * np.sin(4.0 * time), -0.4 + 0.35 * np.sin(3.0 * time)])

    def rates(time, state):
        point = stiff.operate(cylinder_speed=state[0], steering_angle=angles(time), link_speed=state[1:3])
        return [-np.sum(point.torque) / inertia, *(point.link_force / mass), np.sum(point.losses["creep"])]

    start = 14.0
    links = -radius * start * np.tan(angles(0.0))
    done = solve_ivp(rates, (0.0, 1.0), [start, *links, 0.0], method="LSODA", rtol=1e-10, atol=1e-12)
    omega, link, lost = done.y[0], done.y[1:3], done.y[3]
    energy = 0.5 * inertia * omega**2 + 0.5 * np.sum(mass[:, None] * link**2, axis=0)
    assert_allclose(energy + lost, energy[0], rtol=1e-8)
    tangent = np.tan(angles(done.t)).T
    kept = coupled_inertia(inertia, mass, radius, tangent) * omega**2
    assert np.ptp(omega) > 0.5
    assert_allclose(kept, kept[0], rtol=1e-3)  # the creep loss itself is 3e-4 of the energy
    assert 0 < lost[-1] / energy[0] < 1e-3


def test_mass_that_a_user_feels():
    """Pushed by a user, one leg with a free cylinder accelerates as the mass ``m + J/(R t)^2``."""
    inertia, mass, angle, force = 2e-3, 0.5, 0.6, 3.0
    stiff = wheel(creep_stiffness=4e5, **IDEAL)

    def rates(time, state):
        point = stiff.operate(cylinder_speed=state[0], steering_angle=angle, link_speed=state[1])
        return [-point.torque / inertia, (force + point.link_force) / mass]

    start = [5.0, -0.05 * 5.0 * np.tan(angle)]
    done = solve_ivp(rates, (0.0, 0.1), start, method="LSODA", rtol=1e-9, atol=1e-12)
    felt = formulas.reflected_mass(mass, inertia, 0.05, np.tan(angle))
    assert (done.y[1, -1] - done.y[1, 0]) / 0.1 == pytest.approx(force / felt, rel=1e-3)
    assert formulas.reflected_mass(mass, inertia, 0.05, 0.0) == np.inf
    energy = 0.5 * coupled_inertia(inertia, [mass], 0.05, [np.tan(angle)]) * 25.0
    assert energy == pytest.approx(0.5 * felt * start[1] ** 2)


# Messages

GOOD_BASE = Platform.hexapod().base
BAD_PLATFORMS = {
    r"base must be of shape \(rods, 3\), with six rods or more, got shape \(5, 3\)": {"base": GOOD_BASE[:5]},
    "base must be finite, got nan or inf": {"base": GOOD_BASE * np.nan},
    "joints must be one for each of 6 guideways, got 7 rows": {"joints": np.ones((7, 3))},
    "rod_length must be > 0 m, got 0.0": {"rod_length": 0.0},
    r"stroke must be a range from the lowest to the highest position, got \(0.1, 0.1\) m": {"stroke": (0.1, 0.1)},
    r"stroke must be a range from the lowest to the highest position, got 5 m": {"stroke": 5},
    "base must be a real number or an array of them, got 'hexagon'": {"base": "hexagon"},
}


@pytest.mark.parametrize("message", BAD_PLATFORMS)
def test_malformed_platforms(message):
    good = {"base": GOOD_BASE, "joints": Platform.hexapod().joints, "rod_length": 0.14}
    with pytest.raises(iv.ParameterError, match=message):
        Platform(**good | BAD_PLATFORMS[message])


def test_malformed_legs_and_arguments():
    one = Configuration(jacobian=[[1.0]])
    legs = Legs(transmission=wheel(), count=1)
    cases = [
        (lambda: Legs(transmission=wheel(), count=0), "count must be a whole number of legs, 1 or more, got 0"),
        (lambda: Legs(transmission=wheel(), count=True), "count must be a whole number"),
        (
            lambda: Legs(transmission=wheel(cylinder_radius=np.array([0.05, 0.06])), count=2),
            "the legs share the cylinder",
        ),
        (lambda: Configuration(jacobian=np.ones((2, 3))), "at least as many links as components"),
        (lambda: Configuration(jacobian=np.ones(3)), r"jacobian must be of shape \(..., links, components\)"),
        (
            lambda: legs.operate(Configuration(jacobian=np.eye(2)), cylinder_speed=1.0, wrench=[0, 0]),
            "configuration must be of 1, as many as there are legs, got 2 links",
        ),
        (lambda: legs.operate(one, cylinder_speed=1.0, wrench=[1.0, 2.0]), r"wrench must be of shape \(..., 1\)"),
        (lambda: legs.operate(one, cylinder_speed=1.0, wrench=[np.nan]), "wrench must be finite, got nan or inf"),
        (lambda: legs.operate(one, cylinder_speed=1.0, wrench=[1.0], twist=3.0), r"twist must be of shape \(..., 1\)"),
        (
            lambda: Legs(transmission=wheel(), count=2).operate(
                Configuration(jacobian=np.ones((2, 1))), cylinder_speed=1.0, wrench=[1.0]
            ),
            "the speeds of 2 links of a machine with 1 components of twist are not independent",
        ),
        (lambda: legs.operate(one, cylinder_speed=np.nan, wrench=[1.0]), "cylinder_speed must be finite rad/s"),
        (
            lambda: legs.operate(one, cylinder_speed="fast", wrench=[1.0]),
            "cylinder_speed must be a real number or an array",
        ),
        (
            lambda: legs.operate(one, cylinder_speed=1.0, wrench=[[1.0], [1.0, 2.0]]),
            "wrench must be a real number or an array",
        ),
        (lambda: Platform.hexapod(rod_length=0.03).home, "rod_length must be > 0.05562 m to reach the platform"),
        (lambda: Platform.hexapod().at([0.0, 0.1]), r"position must be of shape \(..., 3\), got shape \(2,\)"),
        (lambda: Platform.hexapod().at([0, 0, np.inf]), "position must be finite"),
    ]
    for call, message in cases:
        with pytest.raises(iv.ParameterError, match=message):
            call()
