"""What steering does in the hands of a controller: closed forms of casters, walls, paths and constraint surfaces."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import infinivar as iv
from infinivar import Limit
from internals import creep_drift, drift

MASS, SLIP, STICK = 8.0, 40.0, 1e-7


def wheel(stiffness=4e5, law="linear", **changes):
    """A wheel that slips at 40 N, without resistance."""
    torques = {"rolling_torque": 0.0, "bearing_torque": 0.0}
    return iv.transmission.RollingContact(
        wheel_radius=0.03, preload=200.0, friction=0.2, creep_stiffness=stiffness, creep_law=law, **torques | changes
    )


def ridden(contact, *, speed, heading, duration, rate, push=lambda time: (0.0, 0.0)):
    """A carriage of mass `MASS` on one wheel: x, y, velocities and heading over time.

    `rate` steers by time, place, speed along the heading and the force that the user exerts across it.
    """
    machine = iv.transmission.PlanarCarriage(contact=contact).mechanism

    def rates(time, state):
        vx, vy, h = state[2:]
        force = np.array(push(time))
        ahead, across = np.array([math.cos(h), math.sin(h)]), np.array([-math.sin(h), math.cos(h)])
        along = (ahead[:1], ahead[1:])
        _, exerted = machine.forces(state[2:4], along, stick_speed=STICK)
        turning = rate(time, state[:2], state[2:4] @ ahead, force @ across)
        return [vx, vy, *((force + exerted) / MASS), turning]

    start = [0.0, 0.0, speed * math.cos(heading), speed * math.sin(heading), heading]
    return solve_ivp(rates, (0.0, duration), start, method="Radau", rtol=1e-10, atol=1e-12, dense_output=True)


# ---- virtual caster


def test_a_wheel_steered_as_a_caster_moves_as_a_free_mass():
    """Steered at ``F_n/(M u)`` with its own mass, the wheel has no side force: the path of a thrown stone, whatever its creep."""
    push = (1.5, -4.0)
    done = ridden(
        wheel(2000.0),
        speed=0.8,
        heading=0.7,
        duration=1.0,
        rate=lambda time, place, u, across: across / (MASS * u),
        push=lambda time: push,
    )
    start, time = np.array([0.8 * math.cos(0.7), 0.8 * math.sin(0.7)]), done.t
    for axis in range(2):
        free = start[axis] * time + 0.5 * push[axis] / MASS * time**2
        assert_allclose(done.y[axis], free, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, 3.0])
def test_a_caster_of_another_mass_feels_like_it_across(share):
    """Across its heading the wheel is a mass M: its side force is ``F_n (m/M - 1)``; along it the mass stays m."""
    push, virtual = np.array([1.0, 3.0]), share * MASS
    done = ridden(
        wheel(),
        speed=0.8,
        heading=0.0,
        duration=0.5,
        rate=lambda time, place, u, across: across / (virtual * u),
        push=lambda time: push,
    )
    for time in (0.1, 0.4):
        vx, vy, h = done.sol(time)[2:]
        ahead, across = np.array([math.cos(h), math.sin(h)]), np.array([-math.sin(h), math.cos(h)])
        step = 1e-4
        gained = (done.sol(time + step)[2:4] - done.sol(time - step)[2:4]) / (2.0 * step)
        side = MASS * gained @ across - push @ across
        assert_allclose(side, push @ across * (MASS / virtual - 1.0), rtol=2e-3)
        assert_allclose(MASS * gained @ ahead, push @ ahead, rtol=2e-3, atol=2e-3)
        assert math.hypot(vx, vy) > 0.8


# ---- wall


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.3, 1.0])
def test_a_wall_is_overrun_by_the_turn_into_it(angle):
    """Turning at the rate W from the wall on, at the speed u: ``(u/W)(1 - cos theta)`` deep."""
    speed, turning = 0.4, 6.0
    done = ridden(
        wheel(),
        speed=speed,
        heading=-angle,
        duration=angle / turning,
        rate=lambda time, place, u, across: turning,
    )
    assert_allclose(-done.y[1, -1], speed / turning * (1.0 - math.cos(angle)), rtol=1e-3)
    assert_allclose(np.hypot(*done.y[2:4]), speed, rtol=1e-3)  # steering does no work


def test_the_contact_bounds_the_rate_of_turning():
    """``W <= (mu P - F_n)/(m u)``: a wheel that turns faster slips, and runs through the wall."""
    speed, pushed = 0.5, 12.0
    most = (SLIP - pushed) / (MASS * speed)
    depth = {}
    for share in (0.98, 1.5):
        turning = share * most
        angle = 0.2
        # The user pushes into the wall, across the heading.
        done = ridden(
            wheel(4e4),
            speed=speed,
            heading=-angle,
            duration=angle / turning,
            rate=lambda time, place, u, across, turning=turning: turning,
            push=lambda time, turning=turning, angle=angle: (
                pushed * math.sin(turning * time - angle),
                -pushed * math.cos(turning * time - angle),
            ),
        )
        vx, vy, h = done.y[2:, -1]
        forces = wheel(4e4).act((np.array(vx), np.array(vy)), (np.cos(h), np.sin(h)), stick_speed=STICK)
        assert (forces.slip_demand > 1.0) == (share > 1.0)
        depth[share] = -done.y[1, -1] / (speed / turning * (1.0 - math.cos(angle)))
    assert_allclose(depth[0.98], 1.0, rtol=0.01)
    assert depth[1.5] > 1.1


# ---- path


def followed(contact, *, side, gain, fed_forward, offset, length):
    """Offset from a straight path along x by the way, of a wheel steered at ``dpsi/ds = -k1 d - k2 e``, k2 = 2 sqrt(k1)."""
    machine = iv.transmission.PlanarCarriage(contact=contact).mechanism
    slip_angle = float(drift(contact, side))

    def rates(way, state):
        d, h = state
        point = machine.solve(heading=[h], rates={"x": 1.0}, applied={"y": -side})
        off = h + (slip_angle if fed_forward else 0.0)
        turning = -gain * d - 2.0 * math.sqrt(gain) * off
        return [point.rates[1] / point.rates[0], turning]

    return solve_ivp(rates, (0.0, length), [offset, 0.0], rtol=1e-7, atol=1e-11, dense_output=True)


def test_a_path_is_approached_with_critical_damping():
    """``d = d0 (1 + k s) exp(-k s)`` with ``k = sqrt(k1)``, for small angles."""
    done = followed(wheel(), side=0.0, gain=25.0, fed_forward=False, offset=1e-3, length=1.0)
    way = np.linspace(0.0, 1.0, 11)
    assert_allclose(done.sol(way)[0], 1e-3 * (1.0 + 5.0 * way) * np.exp(-5.0 * way), atol=1e-8)


@pytest.mark.slow
def test_offset_from_a_path_by_creep():
    """A side load leaves the offset ``2 beta/sqrt(k1)``, none with the slip angle fed forward."""
    contact, side, gain = wheel(4000.0, "exact"), 15.0, 25.0
    left = followed(contact, side=side, gain=gain, fed_forward=False, offset=0.0, length=2.2).y[0, -1]
    assert_allclose(left, 2.0 * float(drift(contact, side)) / math.sqrt(gain), rtol=1e-3)
    exact = followed(contact, side=side, gain=gain, fed_forward=True, offset=1e-3, length=2.2).y[0, -1]
    assert abs(exact) < 1e-6


# ---- constraint surfaces of a platform on six legs

PLATFORM = iv.transmission.Platform.hexapod()
IDEAL = iv.RotaryLinearIVT(
    cylinder_radius=0.05,
    wheel_radius=0.01,
    preload=500.0,
    friction=0.12,
    creep_stiffness=1e4,
    rolling_torque=0.0,
    bearing_torque=0.0,
)


@pytest.mark.parametrize("freedoms", [1, 2, 3, 4, 5])
def test_motion_on_a_constraint_surface_does_not_leak(freedoms):
    """``A xi = 0`` through the inverse of six ideal legs and back: nothing across the surface but rounding."""
    random = np.random.default_rng(freedoms)
    pose = PLATFORM.at([0.01, -0.01, PLATFORM.home], [0.05, -0.1, 0.02])
    scale = np.array([1.0, 1.0, 1.0, 0.05, 0.05, 0.05])  # components in m/s and rad/s
    for _ in range(20):
        across = random.normal(size=(6 - freedoms, 6)) * scale
        within = np.linalg.svd(across)[2][6 - freedoms :]
        twist = random.normal(size=freedoms) @ within * 0.1
        legs = iv.transmission.Legs(transmission=IDEAL, count=6)
        point = legs.operate(pose, cylinder_speed=14.0, wrench=np.zeros(6), twist=twist)
        again = pose.twist_of(IDEAL.cylinder_radius * -14.0 * point.steering_tangent)
        assert np.max(np.abs(across @ again)) < 1e-14 * np.linalg.norm(twist) * np.linalg.norm(across)


@pytest.mark.parametrize("held", [1, 2, 3, 4, 5])
def test_motion_on_a_constraint_surface_keeps_its_energy(held):
    """``M dxi = A^T lambda, A dxi = -dA/dt xi`` without force, each twist passed through the six legs: energy is kept."""
    mass = np.diag([2.0, 2.0, 2.0, 3e-3, 3e-3, 4e-3])

    def normals(place):
        """Gradients of a sphere about a point, a wave and planes that hold the rotation, the first `held` of them."""
        x, y, z = place[:3]
        rows = np.zeros((5, 6))
        rows[0, :3] = x - 0.3, y, z
        rows[1, 3] = 1.0
        rows[2, 4] = 1.0
        rows[3, 5], rows[3, 0] = 1.0, 5.0 * math.cos(20.0 * x)
        rows[4, :3] = -0.4 * math.cos(8.0 * x), 1.0, 0.0
        return rows[:held]

    def rates(time, state):
        place, twist = state[:6], state[6:]
        pose = PLATFORM.at(place[:3] + np.array([0.0, 0.0, PLATFORM.home]), place[3:])
        through = pose.twist_of(pose.link_speeds(twist))
        a, step = normals(place), 1e-6
        turning = (normals(place + step * through) - normals(place - step * through)) / (2.0 * step)
        whole = np.block([[mass, a.T], [a, np.zeros((held, held))]])
        change = np.linalg.solve(whole, np.concatenate([np.zeros(6), -turning @ through]))[:6]
        return np.concatenate([through, change])

    start = np.linalg.svd(normals(np.zeros(6)))[2][held:].sum(axis=0) * 0.02
    done = solve_ivp(rates, (0.0, 0.5), np.concatenate([np.zeros(6), start]), rtol=1e-10, atol=1e-13)
    energy = 0.5 * np.einsum("it,ij,jt->t", done.y[6:], mass, done.y[6:])
    assert np.ptp(done.y[:6], axis=1).max() > 1e-3
    assert_allclose(energy, energy[0], rtol=4e-9)
    assert max(np.abs(normals(state[:6]) @ state[6:]).max() for state in done.y.T) < 1e-8


def test_creep_leaks_across_a_constraint_surface_in_proportion_to_the_push():
    """Leak per newton of a platform that is steered without regard to its load: that of the locked one, ``R omega/C``."""
    pose, push = PLATFORM.at([0.0, 0.0, PLATFORM.home]), np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    legs = iv.transmission.Legs(transmission=IDEAL, count=6)
    twist = np.array([0.05, 0.0, 0.0, 0.0, 0.0, 0.0])  # within the plane across z
    planned = legs.operate(pose, cylinder_speed=14.0, wrench=np.zeros(6), twist=twist)
    for size in (1.0, 20.0):
        force = pose.link_forces(size * push)
        wheels = IDEAL.operate(
            cylinder_speed=14.0, steering_angle=np.arctan(planned.steering_tangent), link_force=force
        )
        leak = pose.twist_of(wheels.link_speed) @ push
        known = creep_drift(pose.jacobian, size * push, 0.05 * 14.0, 1e4) @ push
        assert np.all(wheels.limit == Limit.OK)
        assert_allclose(leak, known, rtol=0.03)  # wheels at up to 10 degrees creep a little more
