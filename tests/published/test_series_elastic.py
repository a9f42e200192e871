"""An ankle with a series spring, against two published series-elastic actuators: a robotic tendon and a powered prosthesis.

What is compared is the mechanical output of an actuator behind the spring: force times speed, without its friction, its rotor
and its motor's losses, as in both papers. The walkers differ. Ours (grimmer2014, stride time assumed as 1.1 s) need
1.65 W/kg at push-off at the pace of hollander2006, its walkers 3.1 W/kg. Ratios with and without a spring depend neither on the
body mass nor on the stride time, only on the shapes of moment and angle over the stride.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar

import infinivar as iv
from made import loaded
from sampled import sampled

STUDY = loaded("ankle_walking")
WALKING = STUDY.duty["walking"]
ARM = 0.05
LEVER = replace(STUDY.drives["geared"], output=iv.Output(linkage=iv.parts.Linkage(arm=ARM)))
"""A screw on a lever, so that a spring in its line is a spring about the ankle, with arm^2 times its stiffness."""


def walking(body_mass=80.0, stride_time=1.25):
    """One stride of a person of 80 kg at 0.8 Hz, as in hollander2006."""
    return replace(WALKING, motion=replace(WALKING.motion, body_mass=body_mass, stride_time=stride_time))


def output_power(stiffness=None, duty=None):
    """Power at the output of the actuator over a stride, with a spring of a stiffness about the ankle. [W], [N m/rad]"""
    spring = None if stiffness is None else iv.parts.Spring(stiffness=stiffness / ARM**2)
    drive = replace(LEVER, output=replace(LEVER.output, series_spring=spring))
    columns = iv.duty_cycle(drive, duty or walking()).columns
    return columns["moment_Nm"] / columns["lever_arm_m"] * columns["drive_speed_m_s"]


def work(power, period):
    """Work done and work received per stride. [J]"""
    return np.mean(np.clip(power, 0.0, None)) * period, np.mean(np.clip(-power, 0.0, None)) * period


def least(quantity, body_mass=80.0):
    """Stiffness about the ankle at which a quantity of the output power is least. [N m/rad]"""
    bounds = (2.0 * body_mass, 15.0 * body_mass)
    return minimize_scalar(lambda k: quantity(output_power(k)), bounds=bounds, method="bounded").x


@pytest.fixture(scope="module")
def of_least_peak():
    return least(np.max)


@pytest.fixture(scope="module")
def of_least_work():
    return least(lambda power: np.mean(np.abs(power)))


def test_output_power_is_moment_times_speed_behind_the_spring():
    """M (theta' + M'/k), from the Fourier series of the motion, to rounding; without a spring M theta'."""
    duty = walking()
    course = duty.instants().course
    moment, rate = -course.force, -course.force_rate
    largest = np.max(moment * course.speed)
    assert_allclose(output_power(), moment * course.speed, atol=1e-12 * largest)
    assert_allclose(output_power(400.0), moment * (course.speed + rate / 400.0), atol=1e-12 * largest)


def test_a_spring_without_loss_leaves_the_net_work_as_it_is(of_least_peak):
    rigid, sprung = (np.subtract(*work(output_power(k), 1.25)) for k in (None, of_least_peak))
    assert sprung == pytest.approx(rigid, rel=1e-12)


def test_the_ratio_depends_neither_on_the_body_nor_on_the_pace(of_least_peak):
    other = walking(body_mass=60.0, stride_time=0.9)
    ratio = np.max(output_power(of_least_peak)) / np.max(output_power())
    assert np.max(output_power(of_least_peak * 60 / 80, other)) / np.max(output_power(None, other)) == pytest.approx(
        ratio
    )


def shifted_ratio(shift):
    """Least peak power with a spring over that without, with the speed later by a share of the stride."""
    course = walking().instants().course
    moment, rate = -course.force, -course.force_rate
    speed = np.roll(course.speed, round(shift * len(moment)))

    def peak(stiffness):
        return np.max(moment * (speed + rate / stiffness))

    return minimize_scalar(peak, bounds=(160.0, 1200.0), method="bounded").fun / np.max(moment * speed)


def test_peak_power_falls_to_a_third(of_least_peak):
    """hollander2006: from 250 W to 77 W, 0.31; ours: 0.32.

    The tolerance is computed: moment and speed of our data come from two fits. If one is late by 2 % of the stride, about the
    time between two frames of a gait laboratory at 50 Hz, the ratio moves between 0.27 and 0.36.
    """
    published = 77.0 / 250.0
    ours = np.max(output_power(of_least_peak)) / np.max(output_power())
    assert ours == pytest.approx(shifted_ratio(0.0), rel=1e-4)
    early, late = shifted_ratio(-0.02), shifted_ratio(0.02)
    assert early == pytest.approx(0.27, abs=0.01)
    assert late == pytest.approx(0.36, abs=0.01)
    assert early < published < late
    assert ours == pytest.approx(published, abs=0.5 * (late - early))


def test_energy_per_stride_falls_to_six_tenths(of_least_peak):
    """hollander2006: from nearly 36 J to 21 J per step, 0.58, with the spring of least peak power.

    The abstract leaves open whether work received counts. Ours is 0.61 for the work done, where braking costs nothing, and 0.54
    for work done and received together, where braking costs as much as driving; the published ratio lies between.
    """
    published = 21.0 / 36.0
    done, received = zip(*(work(output_power(k), 1.25) for k in (of_least_peak, None)), strict=True)
    driving = done[0] / done[1]
    both = (done[0] + received[0]) / (done[1] + received[1])
    assert both == pytest.approx(0.54, abs=0.01)
    assert driving == pytest.approx(0.61, abs=0.01)
    assert both < published < driving


def test_the_walkers_of_the_robotic_tendon_are_quicker():
    """Why watts and joules are not compared: at 80 kg and 0.8 Hz ours need 0.53 of the 250 W and 0.71 of the 36 J."""
    power = output_power()
    assert np.max(power) / 250.0 == pytest.approx(0.53, abs=0.01)
    assert sum(work(power, 1.25)) / 36.0 == pytest.approx(0.71, abs=0.01)


TABLE = {
    # nut, ankle in all, work done, work received, spring
    "walking, measured": (0.14, 0.20, 0.15, 0.05, 0.11),
    "walking, model": (0.17, 0.24, 0.19, 0.05, 0.15),
    "running, measured": (0.21, 0.44, 0.32, 0.12, 0.23),
    "running, model": (0.23, 0.51, 0.36, 0.15, 0.25),
}
"""grimmer2016, Table 1, walking at 1.6 m/s and running at 2.6 m/s. [J/kg]: our reading, as ankle work of this size is per stride
and kilogram, and the ankle's total is the sum of work done and received in every row."""

ROUNDING = 0.005


@pytest.mark.parametrize("row", TABLE)
def test_our_reading_of_the_table_is_consistent(row):
    nut, total, done, received, _ = TABLE[row]
    assert total == pytest.approx(done + received, abs=3 * ROUNDING)
    assert nut >= done - received - 3 * ROUNDING  # no spring supplies net work


def saved(nut, total, net):
    """Share of the work beyond the net work that the spring saves."""
    return (total - nut) / (total - net)


@pytest.mark.slow
@pytest.mark.parametrize("row", ["walking, measured", "walking, model"])
def test_the_spring_saves_as_much_of_the_avoidable_work_as_in_a_prosthesis(row, of_least_work):
    """Of the work beyond the net work, our spring of least work saves 0.71 in walking, grimmer2016 0.60 (measured) and 0.70.

    Work done and received counts as in the paper. The net work differs (ours 0.06 J/kg, theirs 0.10 to 0.14), so the ratio of
    the totals does too: 0.42 and 0.70. The tolerance is the rounding of the table.
    """
    nut, total, done, received, _ = TABLE[row]
    done_rigid, received_rigid = work(output_power(), 1.25)
    ours = saved(sum(work(output_power(of_least_work), 1.25)), done_rigid + received_rigid, done_rigid - received_rigid)
    assert ours == pytest.approx(0.71, abs=0.01)
    lowest = saved(nut + ROUNDING, total - ROUNDING, done - received - 2 * ROUNDING)
    highest = saved(nut - ROUNDING, total + ROUNDING, done - received + 2 * ROUNDING)
    assert lowest < ours < highest


def test_the_energy_in_the_spring_is_that_of_the_prosthesis(of_least_work):
    """0.13 J/kg at the largest moment; grimmer2016: 0.11 measured, 0.15 in the model, with one spring for walking and running."""
    largest = np.max(-walking().instants().course.force)
    stored = largest**2 / (2.0 * of_least_work) / 80.0
    measured, model = TABLE["walking, measured"][-1], TABLE["walking, model"][-1]
    assert measured - ROUNDING < stored < model + ROUNDING


@pytest.mark.slow
@pytest.mark.parametrize("row", ["running, measured", "running, model"])
def test_running_is_not_reproduced(row):
    """Of the avoidable work our spring saves 0.66 in running, theirs more than 0.85 within rounding.

    The data differ, not the law: our one runner at 2.7 m/s (duarte2018) moves 1.19 J/kg per stride at the ankle, more than twice
    the 0.44 to 0.51 J/kg of the table, and its moment follows the angle less closely.
    """
    duty = iv.DutyCycle(motion=iv.motion.Running(joint="ankle", body_mass=80.0))

    def amount(stiffness):
        return sum(work(output_power(stiffness, duty), duty.period))

    best = minimize_scalar(amount, bounds=(200.0, 3000.0), method="bounded").fun
    done_rigid, received_rigid = work(output_power(None, duty), duty.period)
    assert (done_rigid + received_rigid) / 80.0 == pytest.approx(1.19, abs=0.01)
    ours = saved(best, done_rigid + received_rigid, done_rigid - received_rigid)
    assert ours == pytest.approx(0.66, abs=0.01)
    nut, total, done, received, _ = TABLE[row]
    assert saved(nut + ROUNDING, total - ROUNDING, done - received - 2 * ROUNDING) > 0.85
    assert total < 0.5 * (done_rigid + received_rigid) / 80.0


def test_what_a_real_motor_adds(of_least_peak):
    """At the shaft of the shipped screw drive the ratio is 0.45: its rotors need power too, also with a spring.

    Without rotor and screw inertia, and without friction of the screw, it is that of the output.
    """
    duty = walking(75.0, 1.1)
    sprung, rigid = STUDY.drives["geared-series"], STUDY.drives["geared"]
    shaft = [iv.duty_cycle(drive, duty).powers["motor_shaft_power_peak_W"] for drive in (sprung, rigid)]
    assert shaft[0] / shaft[1] == pytest.approx(0.45, abs=0.01)

    light = replace(
        LEVER,
        motor=replace(LEVER.motor, rotor_inertia=1e-12, no_load_current=0.0),
        gearhead=replace(LEVER.gearhead, inertia=None, efficiency=1.0),
        screw=replace(LEVER.screw.without_friction(), inertia=1e-12),
    )
    peaks = []
    for stiffness in (of_least_peak * 75 / 80, None):
        spring = None if stiffness is None else iv.parts.Spring(stiffness=stiffness / ARM**2)
        drive = replace(light, output=replace(light.output, series_spring=spring))
        peaks.append(
            np.max((columns := iv.duty_cycle(drive, duty).columns)["motor_torque_Nm"] * columns["motor_speed_rad_s"])
        )
    assert peaks[0] / peaks[1] == pytest.approx(np.max(output_power(of_least_peak)) / np.max(output_power()), rel=1e-4)


@pytest.mark.parametrize("name", STUDY.drives)
def test_the_drives_of_the_study_close_their_energy_balance(name):
    found = iv.duty_cycle(STUDY.drives[name], WALKING)
    assert found.closure < 1e-9
    assert found.feasible is (name != "geared")


@sampled("name", sorted(STUDY.drives, key=lambda name: name != "geared-series"), slow=3)
def test_prescribed_and_simulated_energies_agree(name):
    both = iv.analysis.two_ways(STUDY.drives[name], WALKING)
    assert both.followed == pytest.approx(both.prescribed, rel=0.02)
    assert both.rms_error < 2e-3
