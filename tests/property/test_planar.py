"""Steered wheels on a plane against closed forms: carriage, planar cobot, and their motion in time."""

import math

import array_api_strict as strict
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import infinivar as iv
from infinivar import Limit
from infinivar import array_namespace as namespace
from infinivar.contact import creep
from infinivar.transmission import PlanarCarriage, PlanarCobot
from internals import drift, instant_centre, turning
from jacobians import jacobian
from made import loaded
from sampled import examples, sampled

LAWS = ("linear", "vermeulen-johnson", "polach", "fastsim", "exact")
POINTS = ((0.3, 0.0), (-0.2, 0.25), (-0.2, -0.25))
seeds = st.integers(0, 2**32 - 1)
GEOMETRY = loaded("hand_controller").drives["cobotic"].transmission.geometry


def wheel(law="exact", resistance=0.5, stiffness=100.0, **changes):
    """A wheel that slips at 40 N, with its rolling resistance [N] and K."""
    values = {"wheel_radius": 0.03, "preload": 200.0, "friction": 0.2, "creep_stiffness": 40.0 * stiffness}
    torques = {"rolling_torque": 0.6 * 0.03 * resistance, "bearing_torque": 0.4 * 0.03 * resistance}
    return iv.transmission.RollingContact(**values | torques | {"creep_law": law} | changes)


def body(contacts=None, positions=POINTS, **changes):
    return PlanarCobot(contacts=contacts or wheel(), positions=positions, mass=20.0, inertia=1.5, **changes)


# ---- one wheel


@given(st.sampled_from(LAWS), st.sampled_from([0.05, 1.0, 1e6]), seeds)
def test_a_carriage_is_the_cylinder_unrolled(law, radius, seed):
    """At equal surface speed, for any radius: the plane moves back as the surface of the cylinder does."""
    random = np.random.default_rng(seed)
    contact = wheel(law)
    shared = {name: getattr(contact, name) for name in ("wheel_radius", "preload", "friction", "creep_stiffness")}
    shared |= {"rolling_torque": contact.rolling_torque, "bearing_torque": contact.bearing_torque, "creep_law": law}
    element = iv.RotaryLinearIVT(cylinder_radius=radius, **shared)
    surface, angle = random.uniform(-2, 2, 300), random.uniform(-1.4, 1.4, 300)
    link = -surface * np.tan(angle) + random.normal(0, 0.01, 300) * np.abs(surface)
    known = element.operate(cylinder_speed=surface / radius, steering_angle=angle, link_speed=link)
    heading = np.sin(angle)[:, None], np.cos(angle)[:, None]
    point = PlanarCarriage(contact=contact).mechanism.operate(rates={"x": link, "y": -surface}, heading=heading)
    assert_allclose(point.applied[:, 0], known.link_force, rtol=0, atol=1e-10)
    assert_allclose(point.applied[:, 1] * radius, known.torque, rtol=1e-9, atol=1e-10 * radius)
    assert_array_equal(point.limit, known.limit)
    for name, loss in known.losses.items():
        assert_allclose(point.losses[name], loss, rtol=1e-9, atol=1e-12)


@given(st.sampled_from(LAWS), st.floats(-0.95, 0.95), st.floats(-math.pi, math.pi))
def test_a_side_load_makes_the_path_drift_whatever_the_speed(law, share, angle):
    contact, speeds = wheel(law), np.array([1e-3, 0.3, 20.0])
    force = share * contact.slip_force
    # The wheel heads along `angle`; the side load is at a right angle to it, the user supplies the rest.
    cosine, sine = math.cos(angle), math.sin(angle)
    rotated = iv.transmission.Mechanism(
        contacts=contact, jacobian=[[[cosine, -sine], [sine, cosine]]], coordinates=("along", "across")
    )
    point = rotated.solve(heading=[angle], rates={"along": speeds}, applied={"across": -force})
    path = np.arctan2(point.rates[:, 1], point.rates[:, 0])
    creepage = contact.creepage(force)
    assert_allclose(path, np.arctan(creepage), rtol=1e-7, atol=1e-12)
    assert_allclose(drift(contact, force), np.arctan(creepage), rtol=1e-15)
    assert_allclose(point.losses["creep"], force * creepage * speeds, rtol=1e-7, atol=1e-15)


def test_no_drift_is_known_beyond_slip():
    contact = wheel()
    assert np.isnan(drift(contact, 1.01 * contact.slip_force))
    assert drift(contact, 0.0) == 0.0


# ---- three wheels


def twists(random, count=50):
    return random.normal(size=(count, 3)) * [1.0, 1.0, 3.0]


@given(seeds)
def test_wheels_whose_normals_meet_can_roll(seed):
    """Rank 2 exactly if the normals meet in one point, or are parallel; each wheel then points across its line to it."""
    random = np.random.default_rng(seed)
    cobot, twist = body(), twists(random)
    twist[::10, 2] = 0.0  # parallel headings
    heading = cobot.headings(twist)
    free = cobot.freedom(heading)
    assert np.all(free.misalignment < 1e-14)
    found = free.twist / np.linalg.norm(free.twist, axis=-1, keepdims=True)
    expected = twist / np.linalg.norm(twist, axis=-1, keepdims=True)
    assert_allclose(found, expected, rtol=0, atol=1e-9)
    x, y = instant_centre(twist)
    turns = twist[:, 2] != 0
    assert np.all(np.isinf(x[~turns]) & np.isinf(y[~turns]))
    x, y, heading = x[turns], y[turns], heading[turns]
    for place, (a, b) in enumerate(POINTS):
        across = np.cos(heading[:, place]) * (a - x) + np.sin(heading[:, place]) * (b - y)
        assert_allclose(across / np.hypot(a - x, b - y), 0.0, atol=1e-9)


@given(seeds)
def test_wheels_whose_normals_miss_are_a_brake(seed):
    """The determinant of the lateral directions decides; the least creep is that of no motion found by search."""
    random = np.random.default_rng(seed)
    cobot = body()
    heading = random.uniform(-np.pi, np.pi, 3)
    free = cobot.freedom(heading)
    e = np.stack([np.cos(heading), np.sin(heading)], -1)
    lateral = np.stack([-e[:, 1], e[:, 0], e[:, 0] * np.array(POINTS)[:, 0] + e[:, 1] * np.array(POINTS)[:, 1]], -1)
    assert (abs(np.linalg.det(lateral)) < 1e-9) == (free.misalignment < 1e-9)
    jacobian_ = np.asarray(cobot.mechanism.jacobian)
    for twist in (*twists(random, 300), free.twist):
        creep, moves = lateral @ twist, jacobian_ @ twist
        assert np.sqrt(np.mean(creep**2) / np.mean(np.sum(moves**2, -1))) >= free.misalignment - 1e-12
    assert_allclose(np.sqrt(np.mean((lateral @ free.twist) ** 2)), free.misalignment, rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("positions", [((0.2, 0.1),), ((0.2, 0.1), (-0.3, 0.0))])
def test_one_wheel_or_two_can_always_roll(positions):
    cobot = body(positions=positions)
    heading = np.random.default_rng(1).uniform(-3, 3, (20, len(positions)))
    free = cobot.freedom(heading)
    assert_array_equal(free.misalignment, 0.0)
    assert free.twist.shape == (20, 3)
    creep = cobot.mechanism.operate(rates=free.twist, heading=heading).creep_speed
    assert_allclose(creep, 0.0, atol=1e-14)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("toe", [1e-4, 2e-3, 0.05])
def test_toe_in_costs_what_its_internal_force_loses(law, toe):
    """Two parallel wheels that toe in by an angle: each creeps by its tangent, whatever the track; no rank test sees it."""
    contact = wheel(law, stiffness=150.0)
    cobot = body(contact, ((0.0, 0.2), (0.0, -0.2)))
    point = cobot.mechanism.operate(rates=[0.4, 0.0, 0.0], heading=np.array([-toe, toe]))
    scaled = 150.0 * math.tan(toe)
    lateral = 40.0 * float(creep.law(law).force(scaled))
    expected = 2.0 * (lateral * math.sin(toe) + 0.5 * math.cos(toe))
    assert_allclose(point.applied, [-expected, 0.0, 0.0], rtol=1e-12, atol=1e-12)
    assert_allclose(point.losses["creep"], 2.0 * lateral * math.sin(toe) * 0.4, rtol=1e-12)
    assert (point.limit == Limit.SLIP) == (point.slip_demand.max() > 1.0)
    if toe < 1e-3:  # C toe^2 per wheel and distance
        assert_allclose(point.losses["creep"], 2.0 * 6000.0 * toe**2 * 0.4, rtol=2e-2)
    three = body(contact, ((0.0, 0.2), (0.0, -0.2), (-0.5, 0.0)))
    assert_allclose(three.freedom([-toe, toe, 0.0]).misalignment, _least_creep(toe), rtol=1e-9)


def _least_creep(toe):
    """Least rms creep of two wheels with toe-in and one behind: by symmetry the motion is straight."""
    return math.sqrt(2.0 * math.sin(toe) ** 2 / 3.0)


@pytest.mark.slow
@examples(12)
@given(st.sampled_from(LAWS), seeds)
def test_the_user_supplies_the_losses(law, seed):
    """W . xi = -loss under a steady wrench, found by forces; the same point by rates: users and motors differ in nothing."""
    random = np.random.default_rng(seed)
    cobot = body(wheel(law), ((0.3, 0.0), (-0.2, 0.25), (-0.2, -0.25), (0.1, 0.3)))
    heading = cobot.headings(twists(random, 60)) + 1e-3 * random.normal(size=(60, 4))
    loads = 8.0 * random.normal(size=(2, 60)) * [[1.0], [0.2]]
    point = cobot.mechanism.solve(
        heading=heading, rates={"x": random.choice([-0.4, 0.7], 60)}, applied={"y": loads[0], "angle": loads[1]}
    )
    found = ~np.isnan(point.rates[:, 0])
    assert found.mean() > 0.8  # the others cannot move along x with such headings
    supplied = -np.sum(point.applied * point.rates, axis=-1)
    assert_allclose(supplied[found], sum(point.losses.values())[found], rtol=1e-9, atol=1e-9)
    again = cobot.mechanism.operate(rates=point.rates[found], heading=heading[found])
    assert_allclose(again.applied, point.applied[found], rtol=1e-12, atol=1e-12)


def test_a_load_at_the_centre_of_parallel_wheels_makes_the_body_drift():
    contact = wheel()
    cobot = body(contact, ((0.3, 0.1), (-0.15, 0.1), (-0.15, -0.2)))
    point = cobot.mechanism.solve(heading=np.zeros(3), rates={"x": 0.5}, applied={"y": -30.0, "angle": 0.0})
    assert_allclose(np.arctan2(point.rates[1], point.rates[0]), drift(contact, 10.0), rtol=1e-8)
    assert_allclose(point.rates[2], 0.0, atol=1e-9)
    assert_allclose(point.lateral_force, 10.0, rtol=1e-8)


def test_a_cart_at_rest_holds_what_static_friction_can():
    """Three parallel wheels hold 40 N each across and 0.5 N along; wheels that brake hold any force."""
    cobot = body()
    across = cobot.mechanism.solve(
        heading=np.zeros((2, 3)), rates={"x": 0.0}, applied={"y": [119.9, 120.1], "angle": [0.0, 0.0]}
    )
    assert_array_equal(across.limit, [Limit.SLIP, Limit.SLIP])  # the wheels are not centred: one carries more
    centred = body(positions=((0.4, 0.0), (-0.2, 0.25), (-0.2, -0.25))).mechanism
    across = centred.solve(
        heading=np.zeros((2, 3)), rates={"x": 0.0}, applied={"y": [119.9, 120.1], "angle": [0.0, 0.0]}
    )
    assert_array_equal(across.limit, [Limit.OK, Limit.SLIP])
    assert_allclose(across.utilisation[Limit.SLIP], [119.9 / 120, 120.1 / 120], rtol=1e-9)
    along = centred.solve(heading=np.zeros((2, 3)), rates={"y": 0.0}, applied={"x": [1.49, 1.51], "angle": [0.0, 0.0]})
    assert_array_equal(along.limit, [Limit.OK, Limit.SLIP])
    brake = centred.solve(heading=[0.0, 1.0, -1.0], rates={"y": 0.0}, applied={"x": 20.0, "angle": 0.0})
    assert brake.limit == Limit.OK


@given(seeds)
def test_headings_under_a_load_give_the_motion(seed):
    random = np.random.default_rng(seed)
    cobot, twist = body(), twists(random) * [1.0, 0.3, 1.0]
    heading = cobot.headings(twist, {"y": 5.0, "angle": 1.0})
    found = ~np.isnan(heading[:, 0])
    assert found.mean() > 0.8  # across the load; along it, wheels cannot supply the force
    point = cobot.mechanism.operate(rates=twist[found], heading=heading[found])
    assert_allclose(point.applied[:, 1:], np.broadcast_to([5.0, 1.0], (found.sum(), 2)), rtol=0, atol=1e-7)


def test_wheels_with_geometry_feel_the_spin_of_the_body():
    """A body that turns about its only wheel: the moment is that of a patch that turns on the spot."""
    contact = iv.transmission.RollingContact(wheel_radius=0.012, preload=300.0, friction=0.2, geometry=GEOMETRY)
    cobot = body(contact, ((0.0, 0.0),))
    point = cobot.mechanism.operate(rates=[0.0, 0.0, 2.0], heading=[0.3])
    _, moment = turning.on_the_spot(contact, 0.0)
    assert_allclose(point.applied, [0.0, 0.0, -moment], rtol=1e-9, atol=1e-9)
    assert_allclose(point.losses["spin"], 2.0 * moment, rtol=1e-9)
    straight = cobot.mechanism.operate(rates=[0.5, 0.0, 0.0], heading=[0.0], steering_rate=[1.0])
    assert straight.steering_power > 0.0
    given_ = straight.steering_power.sum() - straight.power.sum()
    assert_allclose(given_, sum(straight.losses.values()), rtol=1e-12)


def test_kinematic_map_is_the_derivative_of_the_positions():
    """Positions of the wheels in the plane by the pose, in axes of the body at angle 0."""

    def places(x, y, angle):
        xp = namespace(x, y, angle)
        cosine, sine = xp.cos(angle), xp.sin(angle)
        return [part for a, b in POINTS for part in (x + cosine * a - sine * b, y + sine * a + cosine * b)]

    found = jacobian(places, 0.3, -0.1, 0.0)
    assert_allclose(found, np.asarray(body().mechanism.jacobian).reshape(6, 3), rtol=0, atol=1e-15)
    step, at = 1e-6, np.array([0.3, -0.1, 0.4])
    steps = [at + step * row for row in np.eye(3)], [at - step * row for row in np.eye(3)]
    central = [
        (np.array(places(*high)) - np.array(places(*low))) / (2 * step) for high, low in zip(*steps, strict=True)
    ]
    assert_allclose(jacobian(places, *at), np.stack(central, -1), rtol=0, atol=1e-9)


@sampled("law", LAWS, slow=3)
def test_the_strict_array_library_computes_the_same(law):
    """Nothing beyond the array standard, and no NumPy in between."""
    cobot, twist = body(wheel(law)), twists(np.random.default_rng(4), 5)
    machine, heading = cobot.mechanism, cobot.headings(twist)
    jacobian_, spin = (strict.asarray(np.asarray(part)) for part in (machine.jacobian, machine.spin))
    other = iv.transmission.Mechanism(
        contacts=wheel(law), jacobian=jacobian_, spin=spin, coordinates=machine.coordinates
    )
    point = other.operate(rates=strict.asarray(twist), heading=strict.asarray(heading + 1e-3))
    expected = machine.operate(rates=twist, heading=heading + 1e-3)
    assert_allclose(np.asarray(point.applied), expected.applied, rtol=1e-12, atol=1e-12)
    assert_array_equal(np.asarray(point.limit), expected.limit)
    loads = {"y": np.full(5, 3.0), "angle": np.full(5, 0.2)}
    given_ = {name: strict.asarray(load) for name, load in loads.items()}
    steered = other.steer(rates=strict.asarray(twist), applied=given_)
    assert_allclose(np.asarray(steered[0]), machine.steer(rates=twist, applied=loads)[0], rtol=0, atol=1e-12)
    solved = other.solve(heading=strict.asarray(heading), rates={"x": strict.asarray(twist[:, 0])}, applied=given_)
    again = machine.solve(heading=heading, rates={"x": twist[:, 0]}, applied=loads)
    assert_allclose(np.asarray(solved.rates), again.rates, rtol=1e-9, atol=1e-12)


def in_float64(jax):
    return jax.enable_x64(True) if hasattr(jax, "enable_x64") else jax.experimental.enable_x64()


@pytest.mark.slow
def test_jax_computes_the_same():
    jax = pytest.importorskip("jax")
    cobot, twist = body(), twists(np.random.default_rng(4), 20)
    heading = cobot.headings(twist)
    expected = cobot.mechanism.operate(rates=twist, heading=heading + 1e-3)
    with in_float64(jax):
        point = cobot.mechanism.operate(rates=jax.numpy.asarray(twist), heading=jax.numpy.asarray(heading + 1e-3))
        steered = cobot.mechanism.steer(rates=jax.numpy.asarray(twist))
    assert_allclose(np.asarray(point.applied), expected.applied, rtol=1e-9, atol=1e-9)
    assert_allclose(np.arctan2(np.asarray(steered[1]), np.asarray(steered[0])), heading, atol=1e-12)


@pytest.mark.slow
def test_jax_solves_the_same():
    jax = pytest.importorskip("jax")
    cobot, twist = body(), twists(np.random.default_rng(4), 20)
    machine, heading, loads = cobot.mechanism, cobot.headings(twist), {"y": 3.0, "angle": 0.2}
    solved = machine.solve(heading=heading, rates={"x": np.sign(twist[:, 0])}, applied=loads)
    steered = machine.steer(rates=twist, applied=loads)
    with in_float64(jax):
        again = jax.jit(lambda h, x: machine.solve(heading=h, rates={"x": x}, applied=loads).rates)(
            heading, np.sign(twist[:, 0])
        )
        turned = jax.jit(lambda rates: machine.steer(rates=rates, applied=loads))(twist)
    assert_allclose(np.asarray(again), solved.rates, rtol=1e-6, atol=1e-8)
    assert_allclose(np.asarray(turned), np.asarray(steered), rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("quadrant", [(1, 1), (-1, 1), (-1, -1), (1, -1)])
@pytest.mark.parametrize("law", LAWS)
def test_power_closure_at_many_points(law, quadrant):
    """100,000 points per law and quadrant of the speeds along x and y, for the carriage and for a body on three wheels."""
    random = np.random.default_rng(6)
    moves = np.abs(random.normal(size=(100_000, 3))) * [*quadrant, 1]
    for machine in (PlanarCarriage(contact=wheel(law)).mechanism, body(wheel(law)).mechanism):
        rates = moves[:, : len(machine.coordinates)]
        cosine, sine = machine.steer(rates=rates)
        off = 0.015 * random.normal(size=cosine.shape)
        point = machine.operate(rates=rates, heading=np.arctan2(sine, cosine) + off)
        left = np.abs(point.power.sum(axis=-1) + sum(point.losses.values()))
        assert np.max(left / np.abs(point.power).sum(axis=-1)) < 1e-9
        assert 0.05 < np.mean(point.limit == Limit.OK) < 0.95


@pytest.mark.slow
def test_power_closure_with_spin_at_many_points():
    random = np.random.default_rng(7)
    cobot = body(iv.transmission.RollingContact(wheel_radius=0.012, preload=300.0, friction=0.2, geometry=GEOMETRY))
    rates = twists(random, 100_000)
    cosine, sine = cobot.mechanism.steer(rates=rates)
    off = 2e-3 * random.normal(size=cosine.shape)
    turning = random.normal(size=cosine.shape)
    heading = np.arctan2(sine, cosine) + off
    point = cobot.mechanism.operate(rates=rates, heading=heading, steering_rate=turning)
    left = np.abs(point.steering_power.sum(axis=-1) - point.power.sum(axis=-1) - sum(point.losses.values()))
    assert np.max(left / (np.abs(point.power).sum(axis=-1) + np.abs(point.steering_power).sum(axis=-1))) < 1e-9
    assert all(np.all(loss >= -1e-9) for loss in point.losses.values())


# ---- motion in time


def turning_way(cobot):
    """Steering that swings the instant centre from side to side."""
    return lambda time: cobot.headings([1.0, 0.3 * math.sin(2.0 * time), 1.2 * math.sin(3.0 * time)])


START = (0.5, 0.0, 0.0)


def ideal(cobot, way, duration):
    """Energy along the motion of a body on wheels that neither creep nor resist: multipliers for the lateral velocities."""
    mass = np.diag([cobot.mass, cobot.mass, cobot.inertia])
    jacobian_ = np.asarray(cobot.mechanism.jacobian)

    def lateral(time):
        h = way(time)
        return -np.sin(h)[:, None] * jacobian_[:, 0] + np.cos(h)[:, None] * jacobian_[:, 1]

    def rates(time, twist):
        n, step = lateral(time), 1e-5
        turning = (lateral(time + step) - lateral(time - step)) / (2.0 * step)
        gyric = cobot.mass * twist[2] * np.array([twist[1], -twist[0], 0.0])
        whole = np.block([[mass, n.T], [n, np.zeros((len(n), len(n)))]])
        return np.linalg.lstsq(whole, np.concatenate([gyric, -turning @ twist]), rcond=1e-10)[0][:3]

    found = solve_ivp(rates, (0.0, duration), START, rtol=1e-11, atol=1e-13)
    return 0.5 * np.einsum("it,ij,jt->t", found.y, mass, found.y)


def moved(cobot, steering, duration, **scenario):
    """A run of a cobot that coasts from `START`, or is pushed."""
    machine = iv.machines.PlanarMachine(cobot=cobot)
    given_ = {"source": "none", "servos": False, "rates": START, "stick_speed": 1e-5, "tolerance": 1e-7}
    return iv.simulate_machine(
        machine, iv.motion.MachineScenario(duration=duration, steering=steering, **given_ | scenario)
    )


@pytest.mark.slow
def test_a_coasting_cobot_keeps_its_energy_without_losses():
    """xi^T M xi under any steering: with multipliers exactly, and as the limit of stiff wheels, in proportion to 1/C."""
    cobot = body(wheel(resistance=0.0))
    energy = ideal(cobot, turning_way(cobot), 0.4)
    assert_allclose(energy, energy[0], rtol=1e-8)
    lost = []
    for stiffness in (100.0, 1000.0, 10000.0):
        stiff = body(wheel(resistance=0.0, stiffness=stiffness))
        run = moved(stiff, turning_way(stiff), 0.4, output_step=0.04)
        assert run.closure < 1e-6
        assert run.complete
        assert not run.slips
        energy = run.stored["machine"]
        lost.append(1.0 - energy[-1] / energy[0])
    assert_allclose(np.array(lost[:2]) / lost[1:], 10.0, rtol=0.02)
    assert 0.0 < lost[-1] < 5e-5


@pytest.mark.slow
def test_a_coasting_cobot_comes_to_rest_by_its_losses():
    """Straight on, rolling resistance alone stops it: v^2/(2 a)."""
    cobot = body(wheel(resistance=2.0))
    slowing = 3 * 2.0 / cobot.mass
    run = moved(cobot, [0.0, 0.0, 0.0], 0.5 / slowing + 0.1, output_step=0.01)
    energy, speed = run.stored["machine"], run.columns["v_x_m_s"]
    assert run.closure < 1e-6
    assert_allclose(speed, np.maximum(0.5 - slowing * run.time, 0.0), atol=1e-4)
    assert energy[-1] < 1e-9 * energy[0]
    end = [run.columns[name][-1] for name in ("x_m", "y_m", "angle_rad")]
    assert_allclose(end, [0.25 / (2 * slowing), 0.0, 0.0], rtol=1e-4, atol=1e-9)
    assert_allclose(run.lost["rolling"][-1], 0.6 * energy[0], rtol=1e-5)


@pytest.mark.slow
def test_a_pushed_cobot_balances_work_and_losses():
    """Pushed across its wheels until they slip, which is an event."""
    cobot = body()
    run = moved(cobot, turning_way(cobot), 1.0, wrench=lambda time: -np.array([5.0, 160.0 * time, 0.0]))
    demand = np.stack([run.columns[f"slip_demand_wheel_{place}"] for place in (1, 2, 3)], axis=-1)
    assert run.closure < 1e-6
    assert len(run.slips) >= 1
    assert demand[run.time < run.slips[0]].max() <= 1.0 + 1e-6
    assert demand[-1].max() > 1.0
    assert run.supplied["user"][-1] > run.lost["rolling"][-1]


@pytest.mark.slow
def test_steering_under_load_makes_its_own_losses():
    """With the forces of spin the steering does work, which the balance counts."""
    contact = iv.transmission.RollingContact(wheel_radius=0.012, preload=65.0, friction=0.2, geometry=GEOMETRY)
    cobot = body(contact)
    run = moved(cobot, turning_way(cobot), 0.1, output_step=0.02)
    assert run.closure < 1e-6
    assert run.lost["spin"][-1] > 0.0
    assert run.supplied["steering"][-1] != 0.0


# ---- messages

BAD = {
    "positions must be one row of x and y for each wheel, got shape (2,)": {"positions": (1.0, 2.0)},
    "positions must be finite m, got nan or infinity": {"positions": ((0.0, math.nan),)},
    "contacts must be 3, one for each position, got 2": {"contacts": (wheel(), wheel())},
    "contacts must be RollingContact, got 'wheel'": {"contacts": ("wheel",) * 3},
    "mass must be > 0 kg, got -1.0": {"mass": -1.0},
    "surface must be 'plane' for a machine on a plane, got 'sphere'": {"contacts": wheel(surface="sphere")},
}


@pytest.mark.parametrize("message", BAD)
def test_wrong_bodies_are_refused(message):
    good = {"contacts": wheel(), "positions": POINTS, "mass": 1.0, "inertia": 1.0}
    with pytest.raises(iv.ParameterError) as caught:
        PlanarCobot(**good | BAD[message])
    assert message in str(caught.value)
