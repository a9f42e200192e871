"""Rods with mass and weight of a platform: against Lagrange's equations of points, statics, energies, and in motion."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from arms import MOTOR, balanced_in_all_quadrants, system_of
from infinivar.machines import PlatformDrive
from infinivar.motion import MachineScenario
from internals import PlatformLoad, c_library, compiled_motion, course_on_path, inputs_of
from machines import LEG, PLATFORM
from made import loaded

GRAVITY = (0.7, -1.1, -9.6)
MASSES = {"rod_mass": 0.08, "gravity": GRAVITY}
INERTIA = (3e-4, 4e-4, 5e-4)
SLANTED = iv.transmission.Platform(
    base=PLATFORM.base + np.array([[0.01, 0.0, 0.02 * place] for place in range(6)]),
    joints=PLATFORM.joints + np.array([[0.0, 0.003 * place, -0.01] for place in range(6)]),
    rod_length=0.16,
)
SEVEN = replace(
    SLANTED,
    base=np.vstack([SLANTED.base, [0.02, 0.0, 0.0]]),
    joints=np.vstack([SLANTED.joints, [0.0, 0.01, 0.0]]),
)
LOAD = PlatformLoad(platform=SLANTED, mass=0.4, inertia=np.array(INERTIA), **MASSES, link_mass=0.3)
GEOMETRY = loaded("six_leg_display").drives["one-motor"].geometry
MASS = 0.3
SHARED, OWN = (
    PlatformDrive(geometry=GEOMETRY, mass=MASS, inertia=INERTIA, **{field: drive}, **MASSES)
    for field, drive in (("leg", LEG), ("separate", MOTOR))
)


def poses(platform, count, seed):
    random = np.random.default_rng(seed)
    home = np.array([0.0, 0.0, platform.home, 0.0, 0.0, 0.0])
    return home + 0.2 * random.uniform(-1.0, 1.0, (count, 6)) * [0.05, 0.05, 0.05, 1.0, 1.0, 1.0]


# Lagrange's equations of points


def crossing(vector):
    x, y, z = vector
    return np.array([[0.0 * x, -z, y], [z, 0.0 * x, -x], [-y, x, 0.0 * x]])


def turned(theta):
    """Rodrigues' formula, also of complex numbers."""
    size = np.sqrt(np.sum(theta * theta))
    across = crossing(theta / size)
    return np.eye(3) + np.sin(size) * across + (1.0 - np.cos(size)) * across @ across


class Points:
    """Platform and rods as points at poses: four a rod at the places of Gauss, six for the moments of inertia."""

    def __init__(self, load):
        self.load, platform = load, load.platform
        places, weights = np.polynomial.legendre.leggauss(4)
        self.along, self.share = 0.5 * (1.0 + places), 0.5 * weights
        squares = 0.5 * load.inertia.sum() - load.inertia  # second moments along the axes
        corners = np.sqrt(3.0 * squares / load.mass)[:, None] * np.eye(3)
        self.corners = np.vstack([corners, -corners])
        rods = np.tile(load.rod_mass * self.share, len(platform.base))
        self.masses = np.concatenate([np.full(6, load.mass / 6.0), rods])

    def at(self, q):
        """Of all points. (k, 3)"""
        platform, turn = self.load.platform, turned(q[3:])
        upper = q[:3] + platform.joints @ turn.T
        apart = upper - platform.base
        lower = platform.base + 0.0 * upper
        lower[:, 2] += apart[:, 2] - np.sqrt(platform.rod_length**2 - apart[:, 0] ** 2 - apart[:, 1] ** 2)
        rods = lower[:, None] + self.along[:, None] * (upper - lower)[:, None]
        return np.concatenate([q[:3] + self.corners @ turn.T, rods.reshape(-1, 3)])

    def links(self, q):
        platform = self.load.platform
        apart = q[:3] + platform.joints @ turned(q[3:]).T - platform.base
        return apart[:, 2] - np.sqrt(platform.rod_length**2 - apart[:, 0] ** 2 - apart[:, 1] ** 2)


def slopes(function, q):
    """Derivatives by a step in the complex plane, exact to rounding. (..., 6)"""
    return np.stack([function(q + 1e-30j * one).imag / 1e-30 for one in np.eye(6)], axis=-1)


def along(function, q, rate, step=2e-3):
    """Derivative of a function along a rate: differences of the sixth order."""
    ways = ((1, 0.75), (2, -0.15), (3, 1.0 / 60.0))
    return sum(w * (function(q + n * step * rate) - function(q - n * step * rate)) for n, w in ways) / step


def twists(q):
    """Matrix that makes twists of rates of a pose, from the derivative of the rotation."""
    found, turn = np.zeros((6, 6)), turned(q[3:])
    found[:3, :3] = np.eye(3)
    for column in range(3, 6):
        across = turned(q[3:] + 1e-30j * np.eye(6)[column, 3:]).imag / 1e-30 @ turn.T
        found[3:, column] = across[2, 1], across[0, 2], across[1, 0]
    return found


@pytest.mark.parametrize("platform", [SLANTED, SEVEN])
def test_forces_are_those_of_lagrange(platform):
    load = replace(LOAD, platform=platform)
    points, random = Points(load), np.random.default_rng(2)
    rows = poses(platform, 40, 1)
    motion, acceleration = random.normal(0.0, 1.0, (2, len(rows), 6)) * [0.3, 0.3, 0.3, 3.0, 3.0, 3.0]
    found = load.at(rows, motion).moved
    forces = found.forces(acceleration)
    for q, twist, changes, force, inertia in zip(rows, motion, acceleration, forces, found.inertia, strict=True):
        matrix = twists(q)
        rate = np.linalg.solve(matrix, twist)
        second = np.linalg.solve(matrix, changes - along(twists, q, rate) @ rate)
        jacobian = slopes(points.at, q)
        accelerated = jacobian @ second + along(lambda q: slopes(points.at, q), q, rate) @ rate
        pushed = points.masses[:, None] * (accelerated - np.array(GRAVITY))
        generalised = np.einsum("kid,ki->d", jacobian, pushed)
        generalised = generalised - load.link_mass * GRAVITY[2] * slopes(points.links, q).sum(axis=0)
        known = np.linalg.solve(matrix.T, generalised)
        assert_allclose(force, known, atol=1e-9 * np.abs(known).max())
        kinetic = 0.5 * np.einsum("kid,kie,k,d,e->", jacobian, jacobian, points.masses, rate, rate)
        assert 0.5 * twist @ inertia @ twist == pytest.approx(kinetic, rel=1e-9)


@pytest.mark.parametrize("platform", [SLANTED, SEVEN])
def test_the_energy_of_weights_falls_by_what_they_work(platform):
    load = replace(LOAD, platform=platform)
    points, rows = Points(load), poses(platform, 20, 4)
    potential = load.at(rows, np.zeros((20, 6))).moved.potential

    def energy(q):
        heavy = points.masses @ points.at(q) @ np.array(GRAVITY)
        return -heavy - load.link_mass * GRAVITY[2] * points.links(q).sum()

    known = np.array([energy(q) for q in rows])
    assert_allclose(potential - potential[0], known - known[0], atol=1e-12)
    assert np.all(potential >= 0.0)


def test_without_masses_of_rods_and_weight_it_is_the_platform_alone():
    plain, zero = replace(LOAD, rod_mass=0.0, gravity=None), replace(LOAD, rod_mass=0.0, gravity=(0.0, 0.0, 0.0))
    rows, random = poses(SLANTED, 10, 5), np.random.default_rng(1)
    twist = random.normal(size=(10, 6))
    one, other = (load.at(rows, twist).moved for load in (plain, zero))
    assert_allclose(other.inertia, one.inertia, rtol=1e-15)
    assert_allclose(other.bias, one.bias, rtol=1e-15)
    assert one.potential == 0.0


# Statics


@pytest.mark.parametrize("drive", [SHARED, OWN])
def test_links_carry_all_weights(drive):
    """Along the cylinder each link adds its whole force, whatever the pose."""
    pose = np.asarray(drive.home) + np.array([0.01, -0.005, 0.01, 0.1, -0.05, 0.2])
    links = 0.0 if drive.leg is None else float(drive.leg.mass_of_link)
    heavy = MASS + 6.0 * (0.08 + links)
    for wrench in (np.zeros(6), np.array([0.0, 0.0, 4.0, 0.0, 0.0, 0.0])):
        point = drive.perform(pose=pose, twist=np.zeros(6), wrench=wrench)
        assert np.sum(point.part_forces) == pytest.approx(wrench[2] - heavy * GRAVITY[2], rel=1e-12)
    rising = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    point = drive.perform(pose=pose, twist=rising, wrench=np.zeros(6))
    assert float(point.stored["machine"]) == pytest.approx(-heavy * GRAVITY[2] * 0.1, rel=1e-12)
    assert float(point.power_out) == pytest.approx(0.0, abs=1e-12)
    balance = point.power_in - point.power_out - sum(point.losses.values()) - sum(point.stored.values())
    assert abs(float(balance)) < 1e-12 * abs(float(point.power_in))


def test_raised_it_stores_its_weight():
    load = replace(LOAD, load_mass=0.1)
    rows = np.repeat(poses(SLANTED, 1, 3), 2, axis=0)
    rows[1, 2] += 0.02
    raised = np.diff(load.at(rows, np.zeros((2, 6))).moved.potential)[0]
    # Without the load, whose weight is a part of the wrench.
    assert raised == pytest.approx((0.4 - 0.1 + 6 * (0.08 + 0.3)) * 9.6 * 0.02, rel=1e-12)


# In motion


@pytest.mark.parametrize("drive", [SHARED, OWN])
def test_powers_are_the_rate_of_the_energies_in_all_quadrants(drive):
    system = system_of(drive.moving(0.1, 1e-4))
    motion = compiled_motion(system)
    assert (motion is None) is (c_library.compiler() is None)
    for inputs, outside, state, moved in balanced_in_all_quadrants(
        system, np.asarray(drive.home), each=10, farthest=0.05, fastest=0.3
    ):
        if motion is not None:
            known = motion.called("rates_at", motion.states, state, inputs_of(inputs, outside))
            assert_allclose(known, moved.derivative[0], rtol=1e-7, atol=1e-7 * np.abs(moved.derivative).max())


def test_motors_hold_it_in_time_as_at_a_steady_point():
    frictionless = replace(
        MOTOR,
        motor=replace(MOTOR.motor, no_load_current=0.0),
        gearhead=replace(MOTOR.gearhead, efficiency=1.0),
        guideway=iv.parts.Guideway(),
    )
    drive = replace(OWN, separate=frictionless)
    machine = drive.moving()
    run = iv.simulate_machine(machine, MachineScenario(duration=1.0))
    gain = machine.link_motors(1e-4).gain
    held = gain * np.array([run.columns[f"motor_{place}_current_A"][-1] for place in range(1, 7)])
    pose = np.array([run.columns[name][-1] for name in machine.mechanics(1e-4).configuration])
    steady = drive.perform(pose=pose, twist=np.zeros(6), wrench=np.zeros(6))
    assert_allclose(held, steady.part_forces, rtol=1e-3, atol=1e-3)
    assert run.closure < 1e-6


@pytest.mark.parametrize("drive", [SHARED, OWN])
def test_a_path_balances_with_weights(drive):
    path = iv.motion.MachinePath(
        z=iv.motion.Sinusoid(distance=0.01, frequency=2.0), rx=iv.motion.Sinusoid(angle=0.1, frequency=2.0)
    )
    _, course = course_on_path(path, drive.coordinates, drive.home)
    point = drive.follow(course)
    balance = point.power_in - point.power_out - sum(point.losses.values()) - sum(point.stored.values())
    assert_allclose(balance, 0.0, atol=1e-9 * np.abs(point.power_in).max())
    assert abs(np.mean(point.stored["machine"])) < 1e-3 * np.abs(point.stored["machine"]).max()


def test_a_session_holds_it_up():
    machine = SHARED.moving()
    run = iv.session(machine, iv.motion.Caster(), duration=0.05)
    # Legs move as a virtual mass under the user alone: weights are carried, with the slip angles that they need.
    assert np.abs(run.position - run.position[0]).max() < 2e-5
    assert run.closure < 1e-6
    lifted = iv.session(machine, iv.motion.Caster(mass=2.0), user=[0.0, 0.0, 10.0], duration=0.1)
    rise = lifted.position[-1, 2] - lifted.position[0, 2]
    assert rise == pytest.approx(0.5 * 10.0 / 2.0 * 0.1**2, rel=0.05)
    heavy = MASS + 6.0 * (0.08 + float(LEG.mass_of_link))
    gained = lifted.stored["machine"][-1] - lifted.stored["machine"][0]
    assert gained > 0.9 * heavy * 9.6 * rise
    assert lifted.closure < 1e-6


# Messages


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"gravity": (0.0, -9.8)}, "gravity must be 3: along x, y and z, got 2 values"),
        ({"rod_mass": -0.1}, "rod_mass must be >= 0 kg"),
        ({"mass": None}, "mass is missing: rod_mass is stated"),
        ({"rod_mass": 0.0, "inertia": None}, "inertia is missing: gravity is stated"),
    ],
)
def test_bad_masses_have_one_clear_message(given, message):
    with pytest.raises(iv.ParameterError, match=message):
        replace(SHARED, **given)


def test_a_bond_graph_refuses_them_by_name():
    with pytest.raises(iv.ParameterError, match="rod_mass must be left out for a bond graph"):
        iv.machine_graph(SHARED.moving())
