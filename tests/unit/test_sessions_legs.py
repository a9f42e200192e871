"""Sessions of displays: legs on a common cylinder and geared slides, against closed forms and estimates."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import session
from infinivar.machines import (
    AdmittanceGuide,
    Commands,
    GearedSlideMachine,
    HoldGuide,
    ImpedanceGuide,
    Measured,
    PathGuide,
    SlideMachine,
)
from internals import GuidedPlant as Plant
from internals import PlatformLoad, SeparateMachine, System, creep_drift, nearest_within, wall_force
from internals import controllers_begun as begun
from machines import HEXAPOD, LEG, MACHINES, PLATFORM, ideal_leg
from made import loaded
from sampled import sampled

DRIVE = loaded("hand_controller").drives["motor1-gear1"]
FRICTIONLESS = replace(
    DRIVE,
    motor=replace(DRIVE.motor, no_load_current=0.0),
    gearhead=replace(DRIVE.gearhead, efficiency=1.0),
    guideway=iv.parts.Guideway(),
)
SLIDE = SlideMachine(leg=LEG, masses=[0.5])


@dataclass
class Arm:
    mass: float = 0.554
    damping: float = 6.45
    stiffness: float = 135.0


class Found:
    def __init__(self, rows):
        self.rows = rows


class Plane:
    """Keeps z, and does not turn."""

    def rows(self, coordinates, position=None, twist=None):
        assert coordinates == ("x", "y", "z", "rx", "ry", "rz")
        return Found(np.eye(6)[2:])


class Floor:
    """Free above a height."""

    def __init__(self, height, dimension=3):
        self.height, self.dimension = height, dimension

    def distance(self, point):
        return np.asarray(point)[..., -1] - self.height

    def normal(self, point):
        up = np.zeros(self.dimension)
        up[-1] = 1.0
        return np.broadcast_to(up, np.shape(point))


# A user's arm


@pytest.mark.slow
def test_arm_on_a_slide_without_friction_swings_by_the_closed_form():
    machine = GearedSlideMachine(drive=FRICTIONLESS, masses=[0.5])
    arm, step = Arm(mass=2.0, damping=8.0, stiffness=500.0), 0.03
    run = session(machine, user=arm, intention=[step], duration=0.5, output_step=0.01)
    mass = 0.5 + machine.link_motors(1e-4).moved_mass + arm.mass
    decay, circular = 0.5 * arm.damping / mass, math.sqrt(arm.stiffness / mass)
    ring = math.sqrt(circular**2 - decay**2)
    known = step * (
        1.0 - np.exp(-decay * run.time) * (np.cos(ring * run.time) + decay / ring * np.sin(ring * run.time))
    )
    assert_allclose(run.position[:, 0], known, atol=1e-7)
    # The intention stands still: the spring alone gives energy.
    assert_allclose(run.supplied["user"], 0.0, atol=1e-12)
    assert_allclose(run.stored["arm"][0], 0.5 * arm.stiffness * step**2, rtol=1e-12)
    lost = np.trapezoid(arm.damping * run.velocity[:, 0] ** 2, run.time)
    assert_allclose(run.lost["arm"][-1], lost, rtol=1e-3)
    # Between hand and handle acts what moves the machine alone.
    moved = (mass - arm.mass) * np.gradient(run.velocity[:, 0], run.time)
    assert_allclose(run.force[2:-2, 0], moved[2:-2], atol=0.05)


def test_free_geared_slide_feels_as_its_reflected_mass():
    machine = GearedSlideMachine(drive=FRICTIONLESS, masses=[0.5, 0.7])
    run = session(machine, controller=ImpedanceGuide(), user=[5.0, 7.0], duration=0.05)
    motor = machine.link_motors(1e-4)
    ratio = DRIVE.gearhead.ratio / DRIVE.stage.radius
    assert_allclose(
        motor.moved_mass, DRIVE.motor.rotor_inertia * ratio**2 + DRIVE.output_inertia / DRIVE.stage.radius**2
    )
    assert_allclose(run.felt_mass(), np.array([0.5, 0.7]) + motor.moved_mass, rtol=1e-6)
    assert "steering" not in run.supplied


@pytest.mark.slow
def test_held_point_and_wall_yield_by_their_stiffness():
    machine = GearedSlideMachine(drive=FRICTIONLESS, masses=[0.5])
    held = session(
        machine,
        controller=ImpedanceGuide(hold=[0.0], stiffness=4000.0, damping=300.0),
        user=[-12.0],
        duration=0.5,
        output_step=0.01,
    )
    assert_allclose(held.position[-1], -12.0 / 4000.0, rtol=1e-3)
    wall = session(
        machine,
        controller=ImpedanceGuide(wall=Floor(0.0, 1), stiffness=4000.0, damping=300.0),
        user=lambda time: [-10.0 - 10.0 * min(max(time - 0.4, 0.0) / 0.2, 1.0)],
        duration=1.0,
        output_step=0.01,
    )
    assert_allclose(wall.penetration[-1], 20.0 / 4000.0, rtol=5e-3)
    assert len(wall.touches) == 1
    later = replace_from(wall, 0.35)
    assert_allclose(later, 4000.0, rtol=0.1)
    assert wall_force(np.array([-1.0, 1e-3]), np.array([0.0, -1e3]), 1e3, 5.0).tolist() == [0.0, 0.0]


def replace_from(run, start):
    """Rendered stiffness from an instant on, between two steady pushes."""
    first, last = np.searchsorted(run.time, start), -1
    return (run.wall_force[last] - run.wall_force[first]) / (run.penetration[last] - run.penetration[first])


@pytest.mark.slow
def test_platform_with_a_motor_for_each_link_is_held_at_its_handle():
    load = PlatformLoad(platform=PLATFORM, mass=1.0, inertia=np.array([1e-3, 1e-3, 2e-3]))
    machine = SeparateMachine(separate=FRICTIONLESS, load=load, home=HEXAPOD.home)
    home = HEXAPOD.home[:3]
    run = session(
        machine,
        controller=ImpedanceGuide(hold=home, stiffness=8000.0, damping=900.0),
        user=[4.0, 0.0, -8.0],
        duration=0.3,
        output_step=0.01,
    )
    assert_allclose(run.position[-1] - home, np.array([4.0, 0.0, -8.0]) / 8000.0, rtol=0.1, atol=1e-6)
    assert run.closure < 1e-6


# Cobotic slides and platforms


@pytest.mark.slow
def test_admittance_renders_its_virtual_mass():
    run = session(
        SLIDE, controller=AdmittanceGuide(mass=2.0), user=lambda time: [2.0 * math.sin(10.0 * time)], duration=0.3
    )
    assert_allclose(run.felt_mass(0.0, 0.15), 2.0, rtol=0.02)
    assert run.closure < 1e-6
    assert run.feasible
    # The power motor moves the handle, not the user.
    assert run.supplied["supply"][-1] > 10.0 * abs(run.supplied["user"][-1])


def test_locked_machine_holds_without_electrical_power():
    run = session(SLIDE, controller=HoldGuide(), user=lambda time: [40.0 * min(40.0 * time, 1.0)], duration=0.05)
    assert run.electrical_energy == 0.0
    assert abs(run.position[-1, 0]) < 1e-7
    assert run.feasible
    standing = replace(LEG, amplifier=replace(LEG.amplifier, standby_power=3.0))
    idle = session(replace(SLIDE, leg=standing), controller=HoldGuide(), user=[40.0], duration=0.03)
    assert_allclose(idle.supplied["supply"][-1], 3.0 * 0.03, rtol=1e-9)


def test_locked_machine_leaks_by_creep_while_its_cylinder_turns():
    machine = replace(HEXAPOD, leg=ideal_leg(stiffness=3e4))
    force = np.array([0.0, 0.0, 12.0])
    run = session(machine, controller=HoldGuide(stop_cylinder=False), user=force, duration=0.03, output_step=0.002,
                  servos="ideal")  # fmt: skip
    jacobian = PLATFORM.at(machine.home[:3]).jacobian
    expected = creep_drift(jacobian, -np.array([*force, 0.0, 0.0, 0.0]), 0.05 * 14.0, 3e4)
    assert_allclose(run.leak([0.0, 0.0, 1.0], 0.01), expected[2] / 12.0, rtol=5e-3)


def test_constraint_does_not_leak_through_the_ideal_six_legs():
    guide = AdmittanceGuide(constraint=Plane(), slip_feedforward=False, gain=0.0)
    mechanics = HEXAPOD.mechanics(1e-4)
    system = System(mechanics=mechanics, motor=HEXAPOD.power_motor(1e-4))
    grip = mechanics.grip()
    law = begun(guide, Plant(machine=HEXAPOD, system=system, grip=grip, period=1e-3))
    rng = np.random.default_rng(4)
    pose = HEXAPOD.home
    jacobian = PLATFORM.at(pose[:3]).jacobian
    moved = 0.0
    for sample in range(200):
        commands = law(
            Measured(
                time=1e-3 * sample,
                configuration=pose,
                rates=np.array([*np.zeros(6), 14.0]),
                position=pose[:3],
                velocity=np.zeros(3),
                force=rng.normal(0.0, 30.0, 3),
                steering=np.zeros(6),
                steering_rate=np.zeros(6),
            )
        )
        # Ideal wheels: each link moves at -R omega tan(phi), and these six give the twist.
        twist = np.linalg.solve(jacobian, -0.05 * 14.0 * np.tan(commands.steering))
        moved = max(moved, float(np.abs(twist[:2]).max()))
        assert np.abs(twist[2:]).max() < 1e-12
    assert moved > 0.05


@pytest.mark.slow
def test_fixture_leaks_little_with_servos_and_creep():
    home = HEXAPOD.home[:3]
    run = session(
        HEXAPOD,
        controller=AdmittanceGuide(mass=2.0, damping=5.0, constraint=Plane()),
        user=Arm(),
        intention=lambda time: home + np.array([0.03 * math.sin(8.0 * time), 0.0, -0.05]),
        duration=0.08,
        output_step=0.005,
    )
    assert np.ptp(run.position[:, 2]) < 2e-5
    assert run.position[-1, 0] > 1e-4
    assert run.closure < 1e-6


def test_wall_of_the_admittance_stops_the_handle():
    height = -0.001
    run = session(
        SLIDE,
        controller=AdmittanceGuide(mass=2.0, damping=5.0, wall=Floor(height, 1)),
        user=[-6.0],
        duration=0.12,
        output_step=0.005,
    )
    assert run.penetration.max() < 2e-5
    assert abs(run.penetration[-1]) < 2e-5
    assert run.wall_force[-1] > 5.0


@pytest.mark.parametrize("away", [3e-4, -3e-4])
def test_approach_of_a_wall_is_bounded_while_the_pose_error_is_corrected(away):
    """Whatever the correction of the pose adds, the handle is not sent to the wall faster than distance over time constant."""
    height, wall_time = HEXAPOD.home[2] - 1e-3, 0.02
    guide = AdmittanceGuide(wall=Floor(height), slip_feedforward=False, wall_time=wall_time)
    system = System(mechanics=HEXAPOD.mechanics(1e-4), motor=HEXAPOD.power_motor(1e-4))
    law = begun(guide, Plant(machine=HEXAPOD, system=system, grip=system.mechanics.grip(), period=1e-3))
    for sample, off in enumerate((0.0, away, away)):
        pose = HEXAPOD.home + np.array([0.0, 0.0, off, 0.0, 0.0, 0.0])
        commands = law(
            Measured(
                time=1e-3 * sample,
                configuration=pose,
                rates=np.array([*np.zeros(6), 14.0]),
                position=pose[:3],
                velocity=np.zeros(3),
                force=np.array([0.0, 0.0, -400.0]),
                steering=np.zeros(6),
                steering_rate=np.zeros(6),
            )
        )
        twist = np.linalg.solve(PLATFORM.at(pose[:3]).jacobian, -0.05 * 14.0 * np.tan(commands.steering))
        fastest = (pose[2] - height) / wall_time
        assert -twist[2] <= fastest * (1.0 + 1e-6)
        assert sample == 0 or -twist[2] > 0.99 * fastest  # the push is strong enough to reach the bound


@pytest.mark.slow
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_legs_stop_the_handle_at_the_ends_of_an_open_path(way):
    machine = SlideMachine(leg=LEG, masses=[0.5, 0.5])
    curve = iv.motion.LineCurve(start=[-0.003, -0.003], end=[0.003, 0.003])
    runs = {
        ends: session(machine, iv.motion.VirtualPath(curve=curve, ends=ends), user=[way * 10.0, 0.0], duration=0.15)
        for ends in ("stop", "free")
    }
    assert max((one.distance for one in runs["stop"].overruns), default=0.0) < 1e-4
    assert np.linalg.norm(runs["stop"].position[-1] - way * np.array([0.003, 0.003])) < 3e-4
    assert runs["free"].overruns[0].distance > 5e-3
    assert "past the end" in runs["free"].verdict
    with pytest.raises(iv.ParameterError, match="ends must be a curve"):
        AdmittanceGuide(ends="stop")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "user"), [(HEXAPOD, [5.0, 0.0, -20.0]), (SLIDE, [25.0]), (SLIDE, lambda time: [25.0 * (time > 0.02)])]
)
def test_held_handle_does_not_jump(machine, user):
    held, strict = (
        session(machine, iv.motion.HoldingTask(stop_cylinder=True), user=user, duration=0.05, **usual)
        for usual in ({}, {"tolerance": 1e-7})
    )
    moved = np.linalg.norm(held.position - held.position[0], axis=-1)
    assert np.max(moved) < 1e-8
    assert_allclose(held.position, strict.position, atol=2e-9)


@pytest.mark.slow
def test_speed_of_the_cylinder_follows_what_the_legs_need():
    slow = session(
        SLIDE,
        controller=AdmittanceGuide(mass=2.0, damping=5.0, cylinder="least loss"),
        user=lambda time: [2.0 * math.sin(10.0 * time)],
        duration=0.15,
        output_step=0.005,
    )
    fast = session(
        SLIDE,
        controller=AdmittanceGuide(mass=2.0, damping=5.0),
        user=lambda time: [2.0 * math.sin(10.0 * time)],
        duration=0.15,
        output_step=0.005,
    )
    assert slow.columns["cylinder_speed_rad_s"].max() < 0.8 * 14.0
    assert slow.supplied["supply"][-1] < 0.5 * fast.supplied["supply"][-1]
    assert_allclose(slow.position[-1], fast.position[-1], atol=5e-4)


def test_limits_of_the_legs_bind_in_the_metric_of_the_mass():
    rng = np.random.default_rng(2)
    for _ in range(50):
        expected, limits = rng.normal(size=3), rng.normal(size=(5, 3))
        least = -rng.uniform(0.1, 1.0, 5)
        found = nearest_within(expected, limits, least)
        assert np.all(limits @ found >= least - 1e-8)
        # No feasible point nearby is nearer.
        for _ in range(30):
            other = found + rng.normal(scale=0.05, size=3)
            if np.all(limits @ other >= least):
                assert np.linalg.norm(other - expected) >= np.linalg.norm(found - expected) - 1e-9
    inside = np.array([0.1, 0.0, 0.0])
    assert nearest_within(inside, np.eye(3), -np.ones(3)) is inside


def test_arms_have_a_handle_at_their_end_point():
    machine, _ = MACHINES["arm"]
    mechanics = machine.mechanics(1e-4)
    grip = mechanics.grip()
    c, nu = np.array([[0.4, -0.7]]), np.array([[0.8, 0.5, 14.0]])
    held = grip.at(c, nu)
    assert_allclose(held.position[0], machine.arm.end_point(c[0])[:2])
    step = 1e-6
    ahead, behind = (grip.at(c + way * step * nu[:, :2], nu) for way in (1.0, -1.0))
    velocity = held.jacobian[0] @ nu[0]
    assert_allclose((ahead.position - behind.position)[0] / (2 * step), velocity, rtol=1e-6)
    change = (ahead.jacobian @ nu[0] - behind.jacobian @ nu[0])[0] / (2 * step)
    assert_allclose(change, held.bias()[0], rtol=1e-6)


# Audit


KINDS = ("slide", "geared", "arm", "platform")


def _random_session(seed):
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    arm = Arm(*(rng.uniform(0.3, 3.0), rng.uniform(0.0, 20.0), rng.uniform(20.0, 800.0)))
    count = int(rng.integers(1, 7))
    rate, size = rng.uniform(3.0, 15.0), rng.uniform(0.002, 0.03)
    if kind == "slide":
        machine, home = SlideMachine(leg=LEG, masses=rng.uniform(0.2, 2.0, count).tolist()), np.zeros(count)
        guide = AdmittanceGuide(mass=rng.uniform(1.0, 4.0), damping=rng.uniform(0.0, 10.0))
    elif kind == "geared":
        machine, home = GearedSlideMachine(drive=DRIVE, masses=rng.uniform(0.2, 2.0, count).tolist()), np.zeros(count)
        guide = ImpedanceGuide(
            hold=np.zeros(count), stiffness=rng.uniform(0.0, 5000.0), damping=10.0, compensation=rng.uniform(0.0, 0.9)
        )
    elif kind == "arm":
        machine = MACHINES["arm"][0]
        home = np.asarray(machine.arm.end_point(np.array([0.3, 0.8])))[:2]
        guide = AdmittanceGuide(mass=rng.uniform(2.0, 5.0), damping=rng.uniform(2.0, 20.0))
    else:
        machine, home = HEXAPOD, HEXAPOD.home[:3]
        guide = AdmittanceGuide(mass=rng.uniform(1.0, 4.0), damping=rng.uniform(2.0, 20.0))
    way = rng.normal(size=len(home))
    way /= np.linalg.norm(way)
    return session(
        machine,
        controller=guide,
        user=arm,
        intention=lambda time: home + size * math.sin(rate * time) * way,
        force=rng.normal(0.0, 2.0, len(home)),
        duration=0.04,
        pose=[0.3, 0.8] if kind == "arm" else None,
        output_step=0.005,
    )


@sampled("seed", range(6), every=3)
def test_balance_closes_in_random_sessions(seed):
    run = _random_session(seed)
    assert run.complete, run.outcome
    assert run.closure < 1e-6


@sampled("seed", range(100, 130), slow=5)
def test_balance_closes_in_many_random_sessions(seed):
    run = _random_session(seed)
    assert run.complete, run.outcome
    assert run.closure < 1e-6


# Misuse


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: session(SLIDE, controller=ImpedanceGuide(), duration=0.1), "ImpedanceGuide drives a motor for each link"),
        (lambda: session(SLIDE, controller=PathGuide(curve=object()), duration=0.1), "curve must have nearest"),
        (lambda: session(GearedSlideMachine(drive=DRIVE, masses=[1.0]), controller=HoldGuide(), duration=0.1),
         "HoldGuide holds legs"),
        (lambda: session(GearedSlideMachine(drive=DRIVE, masses=[1.0]), controller=AdmittanceGuide(), duration=0.1),
         "AdmittanceGuide moves legs"),
        (lambda: session(GearedSlideMachine(drive=DRIVE, masses=[1.0]), controller=ImpedanceGuide(hold=[0.0, 1.0]),
                         duration=0.1), "hold must be 1 finite numbers"),
        (lambda: session(MACHINES["sphere"][0], duration=0.1), "machine must have a handle"),
        (lambda: session(HEXAPOD, pose=[1.0, 0.0, 0.1, 0.0, 0.0, 0.0], duration=0.1), "pose must be within the reach"),
        (lambda: GearedSlideMachine(drive=LEG, masses=[1.0]), "drive must be a ConventionalDrive"),
        (lambda: GearedSlideMachine(drive=DRIVE, masses=[]), "masses must be one value for each axis"),
        (lambda: GearedSlideMachine(drive=DRIVE, masses=[-1.0]), "masses"),
        (lambda: GearedSlideMachine(drive=replace(DRIVE, gearhead=replace(DRIVE.gearhead, stiffness=50.0)), masses=[1.0]),
         "drive.gearhead must be rigid"),
        (lambda: GearedSlideMachine(drive=replace(DRIVE, gearhead=replace(
            DRIVE.gearhead, loss_model="proportional")), masses=[1.0]), "drive.gearhead.loss_model must be 'coulomb'"),
        (lambda: SlideMachine(leg=LEG, masses=[]), "masses must be one value for each axis"),
        (lambda: AdmittanceGuide(constraint=3), "constraint must have rows"),
        (lambda: AdmittanceGuide(wall=3), "wall must have distance and normal"),
        (lambda: AdmittanceGuide(mass=0.0), "mass must be > 0"),
        (lambda: ImpedanceGuide(wall=3), "wall must have distance and normal"),
        (lambda: begun(lambda measured: Commands(), None) and begun(3, None), "controller must be a function"),
    ],
)  # fmt: skip
def test_bad_displays_have_one_clear_message(make, message):
    with pytest.raises(iv.ParameterError) as caught:
        make()
    assert message in str(caught.value)
