"""Machines in tasks and on paths with steering, rotors and moving masses: against drives of one axis and closed forms."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from cobotic_study import unweighed
from infinivar import Limit
from infinivar.machines import ArmDrive
from infinivar.motion import Course, MachinePath, MachineTask
from internals import FRICTION_STICK_SPEED as STICK_SPEED
from internals import coulomb, evaluate_machine, machine_sensitivity, simulated
from internals import course_on_path as on_path
from machine_studies import PLANAR
from made import loaded

HAND = loaded("hand_controller").drives
SERVO = loaded("guided_cart").drives["cart"].steering
SIX, TWO = loaded("six_leg_display"), loaded("two_joint_arm")
SWING = MachinePath(angle=iv.motion.Sinusoid(angle=0.6, frequency=1.5), load_inertia=0.01)
RADIUS = 0.05


def joint(**changes):
    """One joint over a pulley, whose member of 0.4 kg and 0.3 m is a load of 12 g m^2."""
    return ArmDrive(lengths=(0.3,), pulley_radius=RADIUS, member_masses=(0.4,), **changes)


def on_one_axis(drive, lever):
    """Power in, and rows of a drive that moves the joint of `joint` on the path `SWING` over a lever. [W]"""
    time, course = on_path(SWING, ("angle",), (0.0,))
    start = SWING.motions["angle"].derivatives(time, 4)
    assert_allclose(start[1], course.twist[2, :, 0])
    inertia = 0.01 + 0.4 * 0.3**2 / 3.0
    moved = [one * lever for one in start]
    pushed = [-inertia * one / lever for one in start[2:]]
    return drive.follow(
        Course(
            speed=moved[1],
            acceleration=moved[2],
            jerk=moved[3],
            snap=moved[4],
            force=pushed[0],
            force_rate=pushed[1],
            force_curvature=pushed[2],
        )
    )


def test_a_leg_on_a_joint_spends_what_its_drive_spends():
    known = on_one_axis(HAND["cobotic"], RADIUS)
    found = iv.follow_path(joint(leg=HAND["cobotic"]), SWING)
    assert_allclose(found.point.power_in, known.power_in, rtol=1e-5)
    for name, loss in known.losses.items():
        alike = (
            found.point.losses["steering amplifier"] + found.point.losses["amplifier"]
            if name == "amplifier"
            else found.point.losses[name]
        )
        assert_allclose(alike, np.broadcast_to(loss, 400), rtol=1e-4, atol=1e-6, err_msg=name)
    assert found.steering_power > 0.2
    assert found.mean_power > found.steady_power


def test_a_motor_on_a_joint_spends_what_its_drive_spends():
    known = on_one_axis(HAND["motor2-gear4"], RADIUS)
    found = iv.follow_path(joint(separate=HAND["motor2-gear4"]), SWING)
    assert_allclose(found.point.power_in, known.power_in, rtol=1e-5, atol=1e-9)
    # The rotor behind 4:1 adds to the winding loss.
    assert found.losses["winding"] > 1.05 * float(np.mean(found.steady.losses["winding"]))


def test_wheels_turn_as_steady_angles_under_the_same_forces_do():
    """Rates of steering against differences of the steady angles of a platform that carries its own inertia."""
    drive, path = SIX.drives["one-motor-b"], SIX.paths["circle"]
    _, course = on_path(path, drive.coordinates, drive.home)
    point = drive.follow(course)
    angles = np.asarray(point.steering)
    step = path.period / len(angles)
    differences = (np.roll(angles, -1, axis=0) - np.roll(angles, 1, axis=0)) / (2.0 * step)
    plant = drive.leg.steering
    friction = plant.coulomb_torque(drive.leg.transmission)
    friction += plant.ratio * plant.motor.friction_torque
    rotor = plant.bell_inertia + plant.ratio**2 * plant.motor.rotor_inertia
    second = (np.roll(angles, -1, axis=0) - 2.0 * angles + np.roll(angles, 1, axis=0)) / step**2
    current = (friction * np.sign(differences) + rotor * second) / (plant.ratio * plant.motor.torque_constant)
    # At a reversal of a link its friction makes the angle jump, which the differences have and the motion leaves out.
    still = np.abs(differences) > 0.05
    smooth = still & (np.abs(second) < 10.0)
    by_hand = np.where(smooth, plant.motor.resistance * current**2, np.nan)
    assert smooth.mean() > 0.85
    assert np.nansum(by_hand) / smooth.mean() / len(angles) == pytest.approx(
        float(np.mean(point.losses["steering winding"])), rel=1e-2
    )


@pytest.mark.parametrize(("study", "task"), [(SIX, "wall"), (SIX, "idle"), (TWO, "hold")])
def test_a_held_task_takes_no_servo_work(study, task):
    for name, drive in study.drives.items():
        found = iv.perform_task(drive, study.tasks[task])
        assert found.mean_power == pytest.approx(found.steady_power, rel=1e-12, abs=1e-15)
        assert found.steering_power == 0.0
        assert bool(found.servo_words) is ("motors" not in name)
    held = iv.perform_task(study.drives["one-motor"], study.tasks[task])
    assert (held.load_work > 0.0) is (task != "idle")
    assert held.to_dict()["steady_power_W"] == held.steady_power


def test_load_turns_wheels_of_a_held_task_by_the_slip_angle():
    """A locked leg holds its share of the weight by a creepage f/C, the angle that its wheel turns by."""
    drive, task = SIX.drives["one-motor"], SIX.tasks["wall"]
    found = iv.perform_task(drive, task)
    wheel = drive.leg.transmission
    stiffness = float(wheel.groups(drive.leg.cylinder_speed).creep_stiffness)
    share = float(np.max(np.abs(found.point.part_forces)))
    drag = drive.leg.guideway.friction_force(wheel.preload)
    assert found.load_turns == pytest.approx((share - drag) / stiffness, rel=2e-2)
    bell = drive.leg.steering.coulomb_torque(wheel)
    assert found.load_work == pytest.approx(6.0 * float(bell) * found.load_turns, rel=1e-6)


@pytest.mark.slow
def test_verdicts_of_shipped_studies_count_steering_and_say_what_is_left_out():
    six, two = iv.compare(SIX), iv.compare(TWO)
    # At steady points, B and the arm on legs had the lowest power.
    assert min(six.results.values(), key=lambda one: one.steady_power).name == "one-motor-b"
    assert max(six.results.values(), key=lambda one: one.mean_power).name == "one-motor-b"
    assert six.best.name == "one-motor"
    assert min(two.results.values(), key=lambda one: one.steady_power).name == "one-motor"
    assert two.best.name == "two-motors"
    assert "(steady 3.95 W)" in six.verdict
    assert "Not counted" not in six.verdict
    assert six.to_dict()["drives"]["one-motor-b"]["steady_power_W"] == six.results["one-motor-b"].steady_power
    cart = iv.compare(iv.load_study("planar_cart"))
    assert "Not counted: steering (no steering plant is stated), moving masses (mass is missing)." in cart.verdict
    variant = evaluate_machine(SIX, "one-motor", replace(SIX.drives["one-motor"], mass=None))
    assert dict(variant.lacking) == {"moving masses": "mass is missing"}
    assert variant.mean_power == pytest.approx(six.results["one-motor"].mean_power, rel=1e-2)


@pytest.mark.parametrize(
    ("without", "said"),
    [
        (lambda leg: replace(leg, steering=None), {"steering": "no steering plant is stated"}),
        (unweighed, {"steering": "leg.link_mass is missing", "links": "leg.link_mass is missing"}),
    ],
)
def test_what_a_leg_lacks_is_said_and_left_out(without, said):
    drive, task = SIX.drives["one-motor"], SIX.tasks["push"]
    bare = replace(drive, leg=without(drive.leg))
    assert dict(bare.lacking) == said
    found = iv.perform_task(bare, task)
    assert found.steering_power == 0.0
    assert found.mean_power == pytest.approx(found.steady_power, rel=3e-2)


def test_limits_of_steering_motors_count():
    drive, task = SIX.drives["one-motor-b"], SIX.tasks["push"]
    found = iv.perform_task(drive, task)
    assert found.demand == (Limit.THERMAL, "steering motor 5")
    plant = drive.leg.steering
    current = float(plant.coulomb_torque(drive.leg.transmission)) / plant.ratio
    assert found.margin == pytest.approx(float(plant.motor.continuous_torque) / current, rel=2e-2)
    weak = replace(plant, bell_friction=2.0 * plant.bell_friction)
    assert not iv.perform_task(replace(drive, leg=replace(drive.leg, steering=weak)), task).feasible


@pytest.mark.slow
def test_sensitivity_perturbs_the_number_of_the_verdict():
    found = machine_sensitivity(TWO, "one-motor", "power", task="push")
    assert found.value == iv.perform_task(TWO.drives["one-motor"], TWO.tasks["push"]).mean_power
    effects = {one.path: one.elasticity for one in found.influences}
    # Twice the current of a winding costs four times: steering makes 63 % of the power.
    assert effects["leg.steering.motor.resistance"] == pytest.approx(0.63, abs=0.02)


CART = iv.Study.from_dict(tomllib.loads(PLANAR), name="p").drives["cart"]
HEAVY = replace(CART, mass=8.0, inertia=0.6, steering=SERVO)


def test_a_cart_in_a_bend_pulls_its_mass_to_the_middle():
    bend = MachineTask(twist=iv.motion.Twist(x=0.5, angle=0.25))
    held = MachineTask(twist=iv.motion.Twist(x=0.5, angle=0.25), wrench=iv.motion.Wrench(y=8.0 * 0.5 * 0.25))
    found, by_hand = iv.perform_task(HEAVY, bend), iv.perform_task(CART, held)
    assert found.mean_power == pytest.approx(by_hand.mean_power, rel=1e-9)
    assert found.steering_power == 0.0  # Headings of a steady bend are constant.


def test_a_weaving_cart_spends_the_current_against_friction_of_its_servos():
    weave = MachinePath(
        x=iv.motion.Sinusoid(distance=0.3, frequency=0.2), y=iv.motion.Sinusoid(distance=0.3, frequency=0.2, start=1.25)
    )
    found = iv.follow_path(HEAVY, weave)  # round a circle without turning: wheels turn at 2 pi 0.2 rad/s
    plant, wheel = SERVO, HEAVY.mechanism.kinds[0][0]
    torque = float(plant.coulomb_torque(wheel)) + plant.ratio * plant.motor.friction_torque
    current = torque / plant.ratio / plant.motor.torque_constant
    turned = 2.0 * np.pi * 0.2
    spent = 3.0 * (plant.motor.resistance * current**2 + torque * turned)
    assert found.steering_power == pytest.approx(spent, rel=3e-2)
    assert np.mean(sum(found.point.stored.values())) == pytest.approx(0.0, abs=1e-6)
    assert found.demands[Limit.THERMAL, "steering motor 2"] > 0.0


@pytest.mark.full
def test_a_sphere_on_a_path_agrees_with_its_simulation():
    drive = replace(iv.load_study("sphere_joint").drives["tetrahedral"], output_inertia=2e-4)
    path = MachinePath(
        angle=iv.motion.Sinusoid(angle=0.1, frequency=4.0), wrench=iv.motion.Wrench(angle=0.2), load_inertia=1e-3
    )
    found = iv.follow_path(drive, path)
    run = simulated(drive, path)
    assert found.mean_power == pytest.approx(run.mean_powers["supply"], rel=3e-2)
    assert "steering" in drive.lacking


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_a_path_of_one_axis_spends_what_the_duty_cycle_does(name):
    motion = iv.motion.Sinusoid(distance=0.05, frequency=1.5)
    known = iv.duty_cycle(HAND[name], iv.DutyCycle(motion=motion, load_mass=1.0))
    found = iv.follow_path(HAND[name], MachinePath(x=motion, load_mass=1.0))
    # A duty cycle warms the windings, which changes what comes back to the amplifier as well; a path does not.
    assert found.energy == pytest.approx(known.energy, rel=5e-3)
    for part, loss in known.losses.items():
        if "winding" not in part and "amplifier" not in part:
            assert found.losses[part] * motion.period == pytest.approx(loss, rel=1e-4, abs=1e-6), part
    assert found.steady_power < found.mean_power


@pytest.mark.parametrize(("name", "geared"), [("one-motor", False), ("two-motors", True)])
def test_friction_of_slow_parts_of_a_path_by_hand(name, geared):
    """The current of friction alone falls with its share s: by R (F/K)^2 (1 - s^2) on average.

    10 %: inertia of links, rotors and bells takes a few percent of that current at the ends.
    """
    drive = TWO.drives[name]
    path = MachinePath(
        pose=iv.motion.Pose(x=0.32, y=0.2),
        x=iv.motion.Reaches(distance=0.02, time=1.0, pause=0.2, profile="smooth"),
        load_mass=0.3,
    )
    found = iv.follow_path(drive, path)
    step = path.period / len(found.time)
    if geared:
        motors = drive.moving().link_motors(STICK_SPEED)
        moves, friction, gain = found.point.part_speeds * drive.pulley_radius, sum(motors.frictions), motors.gain
        winding, stick = motors.drive.motor.resistance, motors.stick_speed
    else:
        servo = drive.moving().servo(STICK_SPEED)
        angles = np.asarray(found.point.steering)
        moves = (np.roll(angles, -1, axis=0) - np.roll(angles, 1, axis=0)) / (2.0 * step)
        friction, gain, winding, stick = servo.friction, servo.gain, servo.plant.motor.resistance, servo.stick_speed
    share = np.abs(coulomb(moves, 1.0, stick))
    spared = np.where(np.abs(moves) > 1e-9, 1.0 - share * share, 0.0)
    by_hand = winding * (friction / gain) ** 2 * np.mean(np.sum(spared, axis=1))
    assert by_hand > 0.03 * found.mean_power
    assert found.mean_power - found.controlled_power == pytest.approx(by_hand, rel=0.1)
    assert found.to_dict()["controlled_power_W"] == found.controlled_power


@pytest.mark.parametrize("name", ["one-motor", "two-motors"])
def test_rates_of_joints_on_a_path_are_those_of_the_belts_over_the_pulley(name):
    """By inverse dynamics along the path, and from the geometry of each pose."""
    drive, path = TWO.drives[name], TWO.paths["reach"]
    found = iv.follow_path(drive, path)
    at = path.instants(drive.coordinates, drive.home)
    belts = drive.part_speeds(at.pose, at.twist)
    np.testing.assert_allclose(found.point.part_speeds * drive.pulley_radius, belts, rtol=1e-9, atol=1e-12)
