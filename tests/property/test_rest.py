"""Rest: one law of friction there, and one rule by which recordings, shapes and simulations come to it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar import DutyCycle, Scenario, duty_cycle
from infinivar.analysis import two_ways
from infinivar.motion import ConstantForce, Course, Hold, Reach, Reaches, Recording, Sinusoid
from internals import coulomb
from made import parameter_study
from motions import moves_and_dwells, recorded
from sampled import sampled

STUDY = parameter_study("faulring2006")
COBOTIC, STIFF, GEARED = (STUDY.drives[name] for name in ("cobotic", "cobotic-b", "motor2-gear4"))
DRIVES = {"cobotic": COBOTIC, "cobotic-b": STIFF, "geared": GEARED}


@given(st.floats(-100, 100), st.floats(0, 50), st.floats(-10, 10))
def test_friction_at_rest_takes_what_it_can(held, size, speed):
    """Never more than Coulomb's, always against what pushes; what is left is nothing, or the rest beyond its size."""
    left = held + coulomb(0.0, size, held=held)
    assert abs(left) == pytest.approx(max(abs(held) - size, 0.0), abs=1e-12)
    assert left * held >= 0
    if speed:
        assert coulomb(speed, size, held=held) == size * np.sign(speed)


@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
@given(force=st.floats(-60, 60))
def test_holding_lies_between_lifting_and_lowering(drive, force):
    """At rest the motor gives no more than on either side of rest, and takes no part in a force that friction holds."""
    at_rest, up, down = (
        np.abs(drive.operate(speed=speed, force=force).states["motor_current_A"]) for speed in (0.0, 1e-9, -1e-9)
    )
    assert at_rest <= max(up, down) * (1 + 1e-12)
    if drive is GEARED:
        assert at_rest <= min(up, down) * (1 + 1e-12)
        assert (at_rest == 0) == (
            abs(force) <= 4.5 + (0.03 * drive.motor.continuous_torque + drive.motor.friction_torque) * 800
        )


def test_setting_out_from_rest_meets_friction():
    """At the instant at which a load sets out, friction already acts against where it is about to go: not as if at rest."""
    course = Course(speed=np.zeros(3), acceleration=np.array([2.0, 0.0, -2.0]))
    assert_array_equal(course.at_rest, [False, True, False])
    torque = GEARED.follow(course, load_mass=0.8).states["gear_output_torque_Nm"]
    moved = Course(speed=np.array([1e-9, 0.0, -1e-9]), acceleration=course.acceleration)
    assert_allclose(torque, GEARED.follow(moved, load_mass=0.8).states["gear_output_torque_Nm"], rtol=1e-9)


@pytest.mark.parametrize("force", [None, -10.0, 3.0, -30.0])
@sampled("drive", DRIVES.values(), ids=DRIVES, every=2)
def test_holding_by_file_is_holding_by_shape(tmp_path, drive, force):
    shape = DutyCycle(motion=Hold(time=2.0), force=force, load_mass=0.8)
    by_shape = duty_cycle(drive, shape)
    for rate in (100, 1000):
        by_file = duty_cycle(drive, recorded(shape, tmp_path / "hold.csv", rate))
        assert by_file.energy == pytest.approx(by_shape.energy, rel=1e-9, abs=1e-12)
        assert by_file.without_help.energy == pytest.approx(by_shape.without_help.energy, rel=1e-9, abs=1e-12)


def agree(random, folder, names):
    """Deviations of the energy of one random motion: by recordings, simulated where controllers track, and as it turned.

    They track where load and cylinder are within 1 % of what is prescribed. Where the cylinder swings, inverse dynamics is
    given its speed, and where the controllers leave the load at rest, it rests: then nothing but the load's small errors is
    left between the two ways.
    """
    motion = moves_and_dwells(random)
    by_file, simulated, as_turning = [], [], []
    for name in names:
        drive = DRIVES[name]
        energy = duty_cycle(drive, motion).energy
        by_file += [
            abs(duty_cycle(drive, recorded(motion, folder / "motion.csv", rate)).energy / energy - 1.0)
            for rate in (100, 1000)
        ]
        both = two_ways(drive, motion)
        if both.rms_error < 0.01 * motion.motion.distance:
            as_turning.append(abs(both.followed / both.as_controlled - 1.0))
            if both.speed_ripple < 0.01:
                simulated.append(abs(both.followed / both.prescribed - 1.0))
    return by_file, simulated, as_turning


@pytest.mark.slow
@sampled("seed", range(3), every=3)
def test_a_motion_takes_the_same_by_shape_recorded_and_simulated(tmp_path, seed):
    """2 %: what smoothing at 10 Hz, rows 10 ms apart and controllers that stop a load leave.

    4 motions with -m slow, 200 with -m full.
    """
    by_file, simulated, as_turning = agree(np.random.default_rng(seed), tmp_path, ("cobotic", "geared"))
    assert max(by_file) < 0.02
    assert simulated
    assert max(simulated) < 0.02
    assert len(as_turning) == 2
    assert max(as_turning) < 0.02


@pytest.mark.parametrize("count", [pytest.param(2, marks=pytest.mark.slow), pytest.param(200, marks=pytest.mark.full)])
def test_many_motions_take_the_same_three_ways(tmp_path, count):
    found = [agree(np.random.default_rng(1000 + seed), tmp_path, ("cobotic", "geared")) for seed in range(count)]
    by_file, simulated, as_turning = ([one for three in found for one in three[which]] for which in range(3))
    print(
        f"by file up to {max(by_file):.2%}; simulated up to {max(simulated):.2%} in {len(simulated)} of {2 * count} that "
        f"track, with the cylinder's speed of the simulation up to {max(as_turning):.2%} in {len(as_turning)}"
    )
    assert max(by_file) < 0.02
    assert max(simulated) < 0.02
    assert max(as_turning) < 0.02
    assert len(as_turning) > 1.9 * count
    assert len(simulated) > count


@pytest.mark.parametrize("cutoff", [5.0, 10.0, 25.0])
@pytest.mark.parametrize("column", ["position", "speed"])
def test_stays_are_found_at_any_cutoff(tmp_path, cutoff, column):
    """The stays of a clean recording to a fifth of a wave, exactly at rest in them, and moving outside."""
    motion = DutyCycle(motion=Reaches(distance=0.2, time=0.6, pause=0.5), load_mass=0.8)
    duty = recorded(motion, tmp_path / "reach.csv", 500, column=column)
    found = replace(duty.motion, cutoff=cutoff)
    begin, end, value = found.smoothed.stays.T
    assert_allclose(begin, [0.6, 1.7], atol=0.2 / cutoff)
    assert_allclose(end, [1.1, 2.2], atol=0.2 / cutoff)
    assert_allclose(value, [0.2, 0.0], atol=1e-3 if column == "speed" else 1e-6)
    time = np.linspace(0.0, 2.2, 5001)[:-1]
    resting = ((time > begin[0]) & (time < end[0])) | ((time > begin[1]) & (time < end[1]))
    speed = found.derivatives(time, 4)
    for order in range(1, 5):
        assert not np.any(speed[order][resting])
    assert np.mean(speed[1][~resting] == 0) < 2e-3  # some instants after the end, as a reach sets out slowly


@pytest.mark.parametrize("cutoff", [5.0, 25.0])
def test_a_speed_in_counts_resolves_how_far_it_leads_in_a_wave(tmp_path, cutoff):
    """Off by half a count for a wave of the cutoff: so far the position is open. Rounding looks like noise, too, of which the
    largest of a wave's values is taken: no more than three counts."""
    motion = DutyCycle(motion=Reaches(distance=0.2, time=0.6, pause=0.5), load_mass=0.8)
    count = 1e-3
    duty = recorded(motion, tmp_path / "counts.csv", 500, column="speed", count=count)
    found = replace(duty.motion, cutoff=cutoff).smoothed
    assert 0.5 * count / cutoff * (1 - 1e-9) <= found.resolution <= 3.0 * count / cutoff
    assert len(found.stays) == 2


@pytest.mark.parametrize(("count", "noise"), [(1e-5, 0.0), (1e-4, 0.0), (None, 5e-5), (None, 3e-4)])
def test_stays_are_found_through_counts_and_noise(tmp_path, count, noise):
    """Of a reach by 200 mm in 0.6 s and a stay of 1 s: rest is told within a tenth of a second at every end."""
    motion = DutyCycle(motion=Reaches(distance=0.2, time=0.6, pause=1.0), load_mass=0.8)
    random = np.random.default_rng(0)
    rough = noise * random.standard_normal(round(motion.period * 500) + 1) if noise else None
    if rough is not None:
        rough[-1] = rough[0]
    duty = recorded(motion, tmp_path / "rough.csv", 500, count=count, noise=rough)
    found = duty.motion.smoothed
    begin, end, _ = found.stays.T
    assert_allclose(begin, [0.6, 2.2], atol=0.1)
    assert_allclose(end, [1.6, 3.2], atol=0.1)
    assert found.resolution <= max(count or 0.0, 6.0 * noise)


def test_a_steady_motion_does_not_steer(tmp_path):
    """Away and back at constant speed, recorded: the wheel stands still but near the corners, and rests cost nothing."""
    knots, places = [0.0, 1.0, 1.5, 2.5, 3.0], [0.0, 0.3, 0.3, 0.0, 0.0]
    time = np.linspace(0.0, 3.0, 1501)
    rows = [f"{t:.6f},{x:.9f}" for t, x in zip(time, np.interp(time, knots, places), strict=True)]
    path = tmp_path / "trapezoid.csv"
    path.write_text("\n".join(["time [s],position [m]", *rows]), "utf-8")
    duty = DutyCycle(motion=Recording.read(str(path)), load_mass=0.8)
    found = duty_cycle(STIFF, duty)
    time, current = found.instants.time, found.point.states["steering_current_A"]
    corners = np.min(np.abs(time[:, None] - np.array(knots)), axis=1)
    assert not np.any(current[corners > 0.12])
    assert np.any(current[corners < 0.05])
    speed = found.instants.course.speed
    assert_allclose(np.abs(speed[(corners > 0.2) & (time % 1.5 < 1.0)]), 0.3, rtol=0.02)  # what smoothing rings


def test_a_resolution_given_decides(tmp_path):
    """A recording that wanders by 0.5 mm is at rest all along if that is what it resolves, and never by itself."""
    time = np.linspace(0.0, 2.0, 401)
    wander = 5e-4 * np.sin(2 * np.pi * time)
    path = tmp_path / "wander.csv"
    path.write_text(
        "\n".join(["time [s],position [m]", *(f"{t:.6f},{x:.12f}" for t, x in zip(time, wander, strict=True))]), "utf-8"
    )
    moving = DutyCycle(motion=Recording.read(str(path)), load_mass=0.8)
    resting = DutyCycle(motion=Recording.read(str(path), resolution=6e-4), load_mass=0.8)
    assert not np.any(moving.instants().course.at_rest)
    assert np.all(resting.instants().course.at_rest)
    assert duty_cycle(GEARED, resting).energy == 0.0
    assert duty_cycle(GEARED, moving).energy > 0.05


@pytest.mark.slow
@pytest.mark.parametrize("force", [None, -25.0])
@sampled("drive", DRIVES.values(), ids=DRIVES, every=2)
def test_controllers_come_to_rest(drive, force):
    """Half a second after a reach nothing swings any more, and it takes what holding takes by itself."""

    run = iv.simulate(
        drive,
        Scenario(
            duration=3.0,
            motion=Reach(distance=0.2, time=0.6, start=0.3),
            force=ConstantForce(size=force) if force else None,
            load_mass=0.8,
        ),
    )
    resting = run.columns["time_s"] > 1.5
    for name in ("motor_current_A", "steering_current_A"):
        current = run.columns.get(name, np.zeros(resting.size))[resting]
        assert np.ptp(current) <= 1e-3 * max(np.max(np.abs(current)), 0.1)
    assert np.max(np.abs(run.columns["speed_m_s"][resting])) <= 1e-4
    held = duty_cycle(drive, DutyCycle(motion=Hold(time=1.0), force=force, load_mass=0.8)).holding
    drawn = np.mean(run.columns["supply_power_W"][resting])
    assert drawn == pytest.approx(held.power, rel=0.05, abs=1e-3)


STAYS = [(force, efficiency) for force in (-20.0, 10.0) for efficiency in (0.4, 0.8, None)]


@sampled(("force", "efficiency", "pause"), [(*stay, pause) for stay in STAYS for pause in (0.5, 4.0)], slow=5)
def test_long_stays_take_what_holding_takes(force, efficiency, pause):
    """By a controller that has lowered or lifted the load before, behind gears that pass on more or less of it."""
    gear = GEARED.gearhead
    if efficiency is not None:
        gear = replace(gear, loss_model="proportional", efficiency=efficiency, rated_torque=None)
    duty = DutyCycle(motion=Reaches(distance=0.1, time=0.5, pause=pause), force=force, load_mass=0.8)
    both = two_ways(replace(GEARED, gearhead=gear), duty)
    assert both.rms_error < 1e-3 * duty.motion.distance
    assert both.followed == pytest.approx(both.prescribed, rel=0.01)


def test_where_a_motion_reverses_it_does_not_rest():
    """A reversal at a sample of the controllers is no standstill: the current peaks as for a reversal between samples."""
    peaks = []
    for start in (0.0, 0.3e-3, 0.5e-3):
        motion = Sinusoid(distance=0.03, frequency=2.5, start=start)
        run = iv.simulate(GEARED, Scenario(duration=0.4, output_step=0.5e-3, load_mass=2.0, motion=motion))
        peaks.append(np.max(np.abs(run.columns["motor_current_A"])))
    assert max(peaks) == pytest.approx(min(peaks), rel=0.05)


@pytest.mark.parametrize("start", [0.0, 0.3e-3, 0.5e-3])
def test_friction_reverses_with_the_motion(start):
    """Controllers hold their current over a sample and turn friction with the motion: peaks are those of inverse dynamics."""
    motion = Sinusoid(distance=0.03, frequency=2.5, start=start)
    scenario = Scenario(duration=0.8, output_step=0.5e-3, settling_time=0.4, load_mass=2.0, motion=motion)
    run = iv.simulate(GEARED, scenario)
    point = duty_cycle(GEARED, DutyCycle(motion=motion, load_mass=2.0)).point
    after = run.columns["motor_current_A"][len(run.trajectory.time) // 2 :]
    expected = np.max(np.abs(point.states["motor_current_A"]))
    assert np.max(np.abs(after)) == pytest.approx(expected, rel=0.04)
