"""Arms with members of any mass in motion: against Pinocchio, MuJoCo and closed forms, and balances of power."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ellipk

import infinivar as iv
from arms import LEG, MOTOR, STATES, balanced_in_all_quadrants, mujoco_model, of, pin_model, states, system_of
from infinivar.machines import ArmDrive
from infinivar.motion import MachineScenario
from internals import ArmLoad, CoboticControl, MovingMachine, SeparateMechanics, System, simulated
from made import loaded
from sampled import sampled

TWO = loaded("two_joint_arm")
UPRIGHT = {"member_inertias": (4e-3, 2e-3), "member_offsets": (0.01, -0.03), "gravity": (0.0, -9.81)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Free(MovingMachine):
    """An arm that nothing but weight and a wrench moves, without losses."""

    load: Any
    control = CoboticControl()
    pushed = True

    @property
    def home(self):
        return np.zeros(self.load.links)

    def mechanics(self, stick_speed):
        return SeparateMechanics(load=self.load, count=self.load.links, link_mass=0.0, stick_speed=stick_speed)


def swung(load, pose, duration, **given):
    """A run from rest."""
    scenario = MachineScenario(
        duration=duration,
        servos=False,
        steering="locked",
        source="none",
        pose=pose,
        rates=[0.0] * len(pose),
        output_step=1e-3,
        **given,
    )
    return iv.simulate_machine(Free(load=load), scenario)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_accelerations_are_those_of_pinocchio_and_mujoco(count):
    """Torques by both at 1,000 states, rates and the accelerations found, with joints pushed at random."""
    arm = of(count)
    pin, model, data = pin_model(arm)
    mujoco, other, known = mujoco_model(arm)
    angles, rates, torques = states(count)
    system = System(mechanics=Free(load=arm._members()).mechanics(1e-4))
    outside = system.outside(np.zeros(STATES))._replace(pushed=torques)
    found = system.moved(system.idle(), outside, np.concatenate([angles, rates], axis=1)).derivative[:, count:]
    for place in range(STATES):
        known.qpos[:], known.qvel[:], known.qacc[:] = angles[place], rates[place], found[place]
        mujoco.mj_inverse(other, known)
        scale = 1e-9 * (1.0 + np.abs(pin.crba(model, data, angles[place])).max() * np.abs(found[place]).max())
        by_pin = pin.rnea(model, data, angles[place], rates[place], found[place])
        assert_allclose(by_pin, torques[place], atol=scale)
        assert_allclose(known.qfrc_inverse, torques[place], atol=scale)


@pytest.mark.parametrize("drive", [{"leg": LEG}, {"separate": MOTOR}], ids=["leg", "motor"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_powers_are_the_rate_of_the_energies_in_all_quadrants(count, drive):
    machine = of(count, drive).moving()
    found = balanced_in_all_quadrants(system_of(machine), machine.home, each=25, farthest=3.0, fastest=4.0)
    assert len(list(found)) == 100


def test_a_falling_pendulum_has_the_period_and_speed_of_the_closed_form():
    """A rod released level: quarter period K(m) sqrt(I/(mgc)), and speed at the bottom sqrt(2 mgc/I)."""
    length, mass, fall = 0.4, 0.7, 9.81
    load = ArmLoad(
        arm=iv.transmission.PlanarArm(lengths=[length]),
        pulleys=np.ones(1),
        masses=np.array([mass]),
        gravity=(0.0, -fall),
    )
    stiff, inertia = mass * fall * 0.5 * length, mass * length**2 / 3.0
    run = swung(load, [0.0], 1.2, tolerance=1e-9)
    angle, rate = run.columns["q1_rad"], run.columns["q1_rate_rad_s"]
    quarter = ellipk(math.sin(0.25 * math.pi) ** 2) * math.sqrt(inertia / stiff)
    first = int(np.argmax(angle < -0.5 * math.pi))
    share = (-0.5 * math.pi - angle[first - 1]) / (angle[first] - angle[first - 1])
    assert run.time[first - 1] + share * 1e-3 == pytest.approx(quarter, rel=1e-5)
    assert np.abs(rate).max() == pytest.approx(math.sqrt(2.0 * stiff / inertia), rel=1e-5)
    assert np.ptp(run.stored["machine"]) < 1e-6 * run.stored["machine"].max()
    assert angle.min() == pytest.approx(-math.pi, abs=1e-4)


@pytest.mark.parametrize("count", [2, 3])
def test_a_free_swing_keeps_its_energy(count):
    run = swung(of(count)._members(), [0.4, 0.9, -0.3][:count], 1.0, tolerance=1e-9)
    assert run.outcome == ""
    energy = run.stored["machine"]
    assert np.ptp(run.columns["q1_rad"]) > 1.0
    assert np.ptp(energy) < 1e-6 * energy.max()


def test_energy_of_weight_is_0_where_the_arm_hangs_and_nowhere_less():
    arm = of(3)
    angles = states(3)[0]
    found = arm._members().inertia(angles, 0.0 * angles).potential
    assert found.min() > 0.0
    down = math.atan2(*arm.gravity[::-1])
    body = arm._members()
    moments = [one.mass * one.centre for one in body.bodies]
    beyond = np.cumsum(body.masses[::-1])[::-1][1:]
    for place, carried in enumerate(beyond):
        moments[place] = moments[place] + np.array([arm.lengths[place] * carried, 0.0])
    absolute = np.array([down - math.atan2(one[1], one[0]) for one in moments])
    hanging = np.diff(absolute, prepend=0.0)[None]
    lowest = body.inertia(hanging, 0.0 * hanging)
    assert_allclose(lowest.potential, 0.0, atol=1e-12)
    assert_allclose(lowest.bias, 0.0, atol=1e-12)


@sampled(("name", "task"), [(name, task) for task in ("hold", "push") for name in ("two-motors", "one-motor")], every=3)
def test_a_simulated_task_of_an_upright_arm_draws_the_power_of_its_verdict(name, task):
    """Within the 3 % that the manual states; the weight is a good part of it."""
    level, case = TWO.drives[name], TWO.tasks[task]
    drive = replace(level, **UPRIGHT)
    run, found = simulated(drive, case), iv.perform_task(drive, case)
    assert sum(run.mean_powers.values()) == pytest.approx(found.mean_power, rel=0.03)
    carried, bare = found.point.part_forces, iv.perform_task(level, case).point.part_forces
    assert np.abs(carried - bare).max() > 0.3 * np.abs(bare).max()
    settled = run.position_error[len(run.time) // 2 :]
    assert np.ptp(settled) < 1e-4, "it sinks"


@sampled("name", ["two-motors", "one-motor"], every=2)
def test_a_simulated_path_of_an_upright_arm_stores_what_it_lifts(name):
    drive = replace(TWO.drives[name], **UPRIGHT)
    run = simulated(drive, TWO.paths["reach"])
    found = iv.follow_path(drive, TWO.paths["reach"])
    assert sum(run.mean_powers.values()) == pytest.approx(found.controlled_power, rel=0.03)
    height = run.stored["machine"]
    # From end to end of the reach, at rest: the power by inverse dynamics that lifts the arm.
    step = TWO.paths["reach"].period / len(found.time)
    lifted = np.cumsum(found.point.stored["machine"]) * step
    assert np.ptp(height) == pytest.approx(np.ptp(lifted), rel=0.05)


def test_a_user_who_lets_an_upright_arm_go_sees_it_fall():
    """In a session the wheels are steered straight: the joints creep under the weight, and the energy closes."""
    machine = replace(TWO.drives["one-motor"], **UPRIGHT).moving(0.2)
    held = iv.session(machine, iv.motion.HoldingTask(), user=[0.0, 0.0], pose=[0.3, 0.8], duration=0.05)
    level = replace(TWO.drives["one-motor"]).moving(0.2)
    still = iv.session(level, iv.motion.HoldingTask(), user=[0.0, 0.0], pose=[0.3, 0.8], duration=0.05)
    assert held.position[-1, 1] - held.position[0, 1] < -1e-6
    assert abs(still.position[-1, 1] - still.position[0, 1]) < 1e-8


def test_an_arm_of_one_joint_still_has_no_load_of_a_mass():
    with pytest.raises(iv.ParameterError, match="load_mass must be 0 for an arm of one joint"):
        ArmDrive(lengths=(0.3,), pulley_radius=0.05, member_masses=(0.4,), separate=MOTOR, gravity=(0.0, -9.81)).moving(
            0.1
        )


def test_motors_that_turn_the_joints_need_no_pulley():
    """Any pulley gives the same powers, and none is drawn."""
    turned = loaded("driven_cart").drives["omniwheels"].separate
    arm = ArmDrive(lengths=(0.3, 0.25), separate=turned)
    task = iv.motion.MachineTask(pose=iv.motion.Pose(x=0.3, y=0.2), wrench=iv.motion.Wrench(y=5.0))
    found, over = (iv.perform_task(one, task) for one in (arm, replace(arm, pulley_radius=0.05)))
    assert found.mean_power == pytest.approx(over.mean_power, rel=1e-12)
    shown = arm.picture(found.steady, found.pose, found.twist, found.wrench)
    assert (shown.notes, shown.lever) == ((), 0.0)
    with pytest.raises(iv.ParameterError, match="pulley_radius is missing"):
        ArmDrive(lengths=(0.3, 0.25), separate=loaded("hand_controller").drives["motor2-gear4"])
