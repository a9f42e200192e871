"""Closed forms for springs in parallel and in series with a drive, and joints computed in two ways."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar

import infinivar as iv
from infinivar import Output
from infinivar.parts import Linkage, Spring, TorsionSpring
from internals import LINEAR, chain
from internals import FourierSeries as Series
from made import loaded

STUDY = loaded("hand_controller")
COBOTIC, GEARED = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
DRIVES = {"cobotic": COBOTIC, "geared": GEARED}

CRANK = Linkage(shape="crank", arm=0.1, base=0.3, offset=1.5)

MASS, SIZE, FREQUENCY = 2.0, 0.03, 1.7
TURN = 2 * np.pi * FREQUENCY


def inward(output, course, mass):
    """Speed and force on the drive's side of an output, and their power. [m s^-1], [N], [W]"""
    found = chain.inward(output.chain, course, mass, LINEAR, (2, 0)).course
    return found.speed, -np.asarray(found.force), -np.asarray(found.force) * found.speed


def test_parallel_spring_tuned_to_the_motion_takes_the_inertial_power():
    """k = m w^2: spring and mass exchange their energy, and the drive has nothing to do.

    Source: resonance of a mass on a spring; verstraten2016 finds the same for a parallel elastic actuator. The tolerance is
    rounding.
    """
    instants = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=SIZE, frequency=FREQUENCY)).instants()
    tuned = Output(parallel_spring=Spring(stiffness=MASS * TURN**2))
    bare, sprung = (inward(output, instants.course, MASS)[2] for output in (Output(parallel_spring=None), tuned))
    # Without any part of an output the course keeps the mass: its power then is m x'' x'.
    inertial = MASS * instants.course.acceleration * instants.course.speed
    assert np.max(np.abs(inertial)) == pytest.approx(0.5 * MASS * SIZE**2 * TURN**3, rel=1e-5)
    assert np.max(np.abs(bare)) == 0.0
    assert np.max(np.abs(sprung)) < 1e-14 * np.max(np.abs(inertial))


@pytest.mark.parametrize("name", DRIVES)
def test_parallel_spring_leaves_a_drive_with_its_own_inertia_and_friction(name):
    """Behind the tuned spring a whole drive does what it does without a load."""
    loaded = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=SIZE, frequency=FREQUENCY), load_mass=MASS)
    tuned = replace(DRIVES[name], output=Output(parallel_spring=Spring(stiffness=MASS * TURN**2)))
    sprung, free = iv.duty_cycle(tuned, loaded), iv.duty_cycle(DRIVES[name], replace(loaded, load_mass=None))
    assert sprung.energy == pytest.approx(free.energy, rel=1e-9)
    assert iv.duty_cycle(DRIVES[name], loaded).energy > 1.001 * free.energy


@dataclass(frozen=True)
class Damped(iv.motion.Sinusoid):
    """A sinusoid against a viscous damper, -d x'."""

    damping: float = 0.0
    shape: ClassVar[str] = "sinusoid"

    def push(self, time, orders):
        return [-self.damping * row for row in self.derivatives(time, orders + 1)[1:]]


@pytest.mark.parametrize("damping", [3.0, 15.0, 60.0])
def test_series_spring_of_least_peak_power(damping):
    r"""The stiffness of least peak power is ``((m w^2)^2 + (d w)^2)/(m w^2)``, and the peak then is that of the damper alone.

    Derivation: theory page, "Springs and joints". Without damping it is the antiresonance ``m w^2`` of a series elastic
    actuator, where the drive stands still: verstraten2016. The tolerance on the place is the square root of rounding, as for
    any minimum.
    """
    motion = Damped(distance=SIZE, frequency=FREQUENCY, damping=damping)
    instants = iv.DutyCycle(motion=motion).instants()

    def peak(stiffness):
        power = inward(Output(series_spring=Spring(stiffness=stiffness)), instants.course, MASS)[2]
        mean, first, swing, *rest = np.abs(np.fft.rfft(power)) / len(power)
        assert max(first, *rest) < 1e-12 * (mean + swing)  # a constant and a sinusoid of twice the frequency
        return mean + 2.0 * swing

    inertial, viscous = MASS * TURN**2, damping * TURN
    best = (inertial**2 + viscous**2) / inertial
    found = minimize_scalar(peak, bounds=(0.3 * best, 3 * best), method="bounded", options={"xatol": 1e-9 * best})
    assert found.x == pytest.approx(best, rel=1e-6)
    assert peak(best) == pytest.approx(damping * (TURN * SIZE) ** 2, rel=1e-12)
    rigid = 0.5 * SIZE**2 * TURN * (viscous + np.hypot(inertial, viscous))
    assert peak(1e12) == pytest.approx(rigid, rel=1e-6)
    assert peak(best) < rigid


def test_at_antiresonance_the_drive_stands_still():
    """k = m w^2 without damping: all of the motion is that of the spring; a load spring of stiffness c adds: k = m w^2 - c."""
    course = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=SIZE, frequency=FREQUENCY)).instants().course
    speed, force, _ = inward(Output(series_spring=Spring(stiffness=MASS * TURN**2)), course, MASS)
    assert np.max(np.abs(speed)) < 1e-14 * SIZE * TURN
    assert np.max(np.abs(force)) == pytest.approx(MASS * SIZE * TURN**2, rel=1e-5)
    beside = 0.4 * MASS * TURN**2
    both = Output(parallel_spring=Spring(stiffness=beside), series_spring=Spring(stiffness=MASS * TURN**2 - beside))
    assert np.max(np.abs(inward(both, course, MASS)[0])) < 1e-14 * SIZE * TURN


@pytest.mark.parametrize("name", DRIVES)
def test_a_stiff_series_spring_is_no_spring(name):
    """The energy per cycle approaches that without a spring in proportion to the compliance."""
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=SIZE, frequency=FREQUENCY), load_mass=MASS)
    rigid = iv.duty_cycle(DRIVES[name], duty).energy
    off = [
        abs(iv.duty_cycle(replace(DRIVES[name], output=Output(series_spring=Spring(stiffness=k))), duty).energy - rigid)
        for k in (1e6, 1e8, 1e12)
    ]
    assert off[0] < 1e-2 * rigid
    assert off[1] == pytest.approx(1e-2 * off[0], rel=0.1)
    assert off[2] < 1e-7 * rigid


@pytest.mark.parametrize("name", DRIVES)
def test_a_joint_with_a_lever_is_the_motion_along_the_line(name):
    """Walking about the joint through a lever, and walking with a lever arm, to rounding."""
    walk = {"joint": "ankle", "body_mass": 70.0, "stride_time": 1.1, "share": 0.02}
    along = iv.DutyCycle(motion=iv.motion.Walking(**walk, lever_arm=0.06))
    about = iv.DutyCycle(motion=iv.motion.Walking(**walk))
    joint = replace(DRIVES[name], output=Output(linkage=Linkage(arm=0.06)))
    one, other = iv.duty_cycle(DRIVES[name], along), iv.duty_cycle(joint, about)
    assert other.energy == pytest.approx(one.energy, rel=1e-12)
    assert_allclose(other.point.power_out, one.point.power_out, atol=1e-12 * np.max(np.abs(one.point.power_out)))
    assert_allclose(other.point.power_in, one.point.power_in, rtol=1e-9, atol=1e-9 * one.power_in)
    assert other.holding.power == pytest.approx(one.holding.power, rel=1e-9)


@dataclass(frozen=True)
class Mapped(iv.motion.Sinusoid):
    """The motion of an actuator at a joint, mapped at instants and differentiated by Fourier series."""

    linkage: Linkage = CRANK
    inertia: float = 0.0

    def _rows(self):
        time = np.arange(4000) * (self.period / 4000)
        angle, _, acceleration = super().derivatives(time, 2)
        position, arm = self.linkage.derivatives(angle, 1)
        force = -self.inertia * acceleration / arm
        return (Series.through(self.period, row, 200 / self.period) for row in (position, force))

    def derivatives(self, time, orders):
        return next(iter(self._rows())).derivatives(time, orders)

    def push(self, time, orders):
        return list(self._rows())[1].derivatives(time, orders)


@pytest.mark.parametrize("name", DRIVES)
def test_a_crank_is_the_motion_of_its_actuator(name):
    """By the chain rule through the crank, and by mapping angle and moment sample by sample beforehand."""
    inertia = 0.02
    joint = replace(DRIVES[name], output=Output(linkage=CRANK))
    about = iv.duty_cycle(
        joint, iv.DutyCycle(motion=iv.motion.Sinusoid(angle=0.4, frequency=FREQUENCY), load_inertia=inertia)
    )
    along = iv.duty_cycle(DRIVES[name], iv.DutyCycle(motion=Mapped(distance=0.4, frequency=FREQUENCY, inertia=inertia)))
    assert about.energy == pytest.approx(along.energy, rel=1e-6)
    assert_allclose(about.point.power_in, along.point.power_in, atol=1e-6 * np.max(about.point.power_in))


def test_hysteresis_costs_the_area_of_its_loop():
    """The loss per cycle of a parallel spring is the integral of its hysteresis force over the position.

    Source: the closed loop of dahl1968 between -X and X. The sum over 2000 samples is good to 1e-3.
    """
    largest, presliding = 3.0, 1e-3
    spring = Spring(stiffness=100.0, hysteresis=largest, presliding=presliding)
    drive = replace(GEARED, output=Output(parallel_spring=spring))
    found = iv.duty_cycle(drive, iv.DutyCycle(motion=iv.motion.Sinusoid(distance=SIZE, frequency=FREQUENCY)))
    # From -z0 at one end the force follows F_c - (F_c + z0) exp(-s/x_s) over the way s = 2 X, to z0 at the other end.
    decay = np.exp(-2 * SIZE / presliding)
    start = largest * (1 - decay) / (1 + decay)
    area = 2 * (largest * 2 * SIZE - (largest + start) * presliding * (1 - decay))
    assert found.losses["parallel spring hysteresis"] == pytest.approx(area, rel=1e-3)
    assert found.closure < 1e-12


def test_springs_about_a_joint_and_along_its_lever_are_one():
    """k_joint = k_line arm^2, for parallel and series springs."""
    arm = 0.05
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(angle=0.5, frequency=1.1), load_inertia=0.01, moment=0.3)
    lever = Linkage(arm=arm)
    line = Output(linkage=lever, parallel_spring=Spring(stiffness=800.0), series_spring=Spring(stiffness=3e3))
    joint = Output(
        linkage=lever,
        parallel_torsion_spring=TorsionSpring(stiffness=800.0 * arm**2, at="load"),
        series_torsion_spring=TorsionSpring(stiffness=3e3 * arm**2),
    )
    one, other = (iv.duty_cycle(replace(COBOTIC, output=output), duty) for output in (line, joint))
    assert other.energy == pytest.approx(one.energy, rel=1e-10)
    assert_allclose(other.point.power_in, one.point.power_in, rtol=1e-9)


@pytest.mark.parametrize("name", DRIVES)
def test_a_reach_whose_jerk_jumps_is_refused_behind_a_series_spring(name):
    drive = replace(DRIVES[name], output=Output(series_spring=Spring(stiffness=1e4)))
    reaches = iv.motion.Reaches(distance=0.05, time=0.4, pause=0.2)
    with pytest.raises(iv.ParameterError, match="set profile = 'smooth'"):
        iv.duty_cycle(drive, iv.DutyCycle(motion=reaches, load_mass=1.0))
    smooth = iv.duty_cycle(drive, iv.DutyCycle(motion=replace(reaches, profile="smooth"), load_mass=1.0))
    assert smooth.closure < 1e-9
    assert smooth.without_help is not None


def test_a_smooth_reach_has_four_derivatives_that_vanish_at_its_ends():
    reach = iv.motion.Reaches(distance=0.1, time=0.5, pause=0.1, profile="smooth")
    rows = reach.derivatives(np.array([0.0, 0.5 - 1e-12, 0.25]), 6)
    assert_allclose([row[:2] for row in rows[1:5]], 0.0, atol=1e-5)
    assert_allclose(rows[0], [0.0, 0.1, 0.05], atol=1e-12)
    time = np.linspace(0.05, 0.45, 21)
    for order in range(6):
        step = 1e-4
        above, below = (reach.derivatives(time + way, order)[order] for way in (step, -step))
        expected = (above - below) / (2 * step)
        assert_allclose(reach.derivatives(time, order + 1)[order + 1], expected, atol=2e-5 * np.max(np.abs(expected)))
