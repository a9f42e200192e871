"""Duty cycles: motions, recordings, energy and verdicts of drives that repeat them, and what the cylinder's speed is worth."""

import functools
import math
import pickle
import re
import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import differential_evolution

import infinivar as iv
from infinivar import DutyCycle, Limit, duty_cycle
from infinivar.analysis import holding, policies, two_ways
from infinivar.drivetrain import MovingPoint
from infinivar.motion import Hold, Reaches, Recording, Running, Sinusoid, Tremor, Walking
from internals import POLICY_RANGE as RANGE
from internals import FourierSeries as Series
from internals import cycle_demands as demands
from internals import cylinder_policy, shipped_study
from internals import policy_schedule as schedule
from made import parameter_study

STUDY = parameter_study("faulring2006")
COBOTIC, GEARED = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
RNG_SEED = 31
KNEE = {"joint": "knee", "body_mass": 75.0, "stride_time": 1.1, "lever_arm": 0.05}
SHAPES = {
    "hold": DutyCycle(motion=Hold(time=2.0), force=-30.0, load_mass=0.8),
    "sinusoid": DutyCycle(motion=Sinusoid(distance=0.03, frequency=2.0), load_mass=0.8),
    "reaches": DutyCycle(motion=Reaches(distance=0.1, time=0.4, pause=0.3), force=-10.0, load_mass=0.8),
    "tremor": DutyCycle(motion=Tremor(distance=5e-4, low_frequency=8.0, high_frequency=12.0), load_mass=0.8),
    "walking": DutyCycle(motion=Walking(share=0.05, **KNEE), load_mass=0.0),
    "running": DutyCycle(motion=Running(joint="hip", body_mass=70.0, lever_arm=0.03, share=0.01), load_mass=0.0),
}


def duty(shape, **changed):
    return replace(SHAPES[shape], **changed)


def record(tmp_path, text):
    path = tmp_path / "recorded.csv"
    path.write_text(text, "utf-8")
    return str(path)


def wave(count=201, frequency=1.0, heading="time [s],position [mm],force [N]", size=50.0):
    time = np.linspace(0, 1 / frequency, count)
    rows = [
        f"{t:.9f},{size * math.sin(2 * math.pi * frequency * t):.9f},{-5 + math.cos(2 * math.pi * t):.9f}" for t in time
    ]
    return "\n".join([heading, *rows]) + "\n"


@pytest.mark.parametrize("shape", SHAPES)
def test_derivatives_follow_from_one_another(shape):
    """Position to snap, and force to its curvature, by differences away from the ends of reaches, where jerk jumps."""
    made = duty(shape)
    time = np.linspace(0.0, made.period, 60001)[1:-1]
    position, course = made.at(time)
    chain = [position, course.speed, course.acceleration, course.jerk, course.snap]
    push = [course.force, course.force_rate, course.force_curvature]
    inside = np.ones(time.size - 2, dtype=bool)
    if shape == "reaches":
        for edge in (0.4, 0.7, 1.1):
            inside &= np.abs(time[1:-1] - edge) > 1e-3
    for values in (chain, push):
        for lower, higher in pairwise(values):
            lower, higher = np.broadcast_to(lower, time.shape), np.broadcast_to(higher, time.shape)
            slope = (lower[2:] - lower[:-2]) / (time[2:] - time[:-2])
            scale = np.max(np.abs(higher)) + 1e-300
            assert_allclose(slope[inside], higher[1:-1][inside], atol=1e-5 * scale)


@pytest.mark.parametrize("shape", ["sinusoid", "tremor", "walking", "running"])
def test_whole_cycle_and_single_instants_agree(shape):
    """By fast Fourier transform, and wave by wave."""
    made = duty(shape)
    whole = made.instants()
    position, course = made.at(whole.time[3:40])
    assert_allclose(whole.position[3:40], position, atol=1e-12)
    assert_allclose(whole.course.snap[3:40], course.snap, rtol=1e-9, atol=1e-9 * np.max(np.abs(course.snap)))


@pytest.mark.parametrize("start", [0.0, 0.3, 17.123])
def test_long_recordings_take_little_memory(start):
    """Harmonics times instants were gigabytes for some minutes: of an even cycle, however it starts, and of any instants."""
    random = np.random.default_rng(1)
    many = Series(100.0, *random.standard_normal((2, 1000)))
    even = start + np.arange(20_000) * 0.005
    tracemalloc.start()
    whole = many.derivatives(even, 2)
    apart = many.derivatives(even[1:], 2)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 60e6  # 320 MB in one piece
    for one, other in zip(whole, apart, strict=True):
        assert_allclose(one[1:], other, atol=1e-9 * np.max(np.abs(one)))


@pytest.mark.parametrize("shape", SHAPES)
def test_cycles_can_be_sent_to_other_processes(shape):
    made = duty(shape)
    assert pickle.loads(pickle.dumps(made)).instants().course.speed == pytest.approx(made.instants().course.speed)


def test_tremor_has_its_size_in_its_band():
    whole = duty("tremor").instants()
    assert np.sqrt(np.mean(whole.position**2)) == pytest.approx(5e-4, rel=1e-9)
    spectrum = np.abs(np.fft.rfft(whole.position))
    frequency = np.arange(len(spectrum)) / duty("tremor").period
    outside = (frequency < 7.99) | (frequency > 12.01)
    assert np.max(spectrum[outside]) < 1e-9 * np.max(spectrum)
    # Schroeder's phases: a crest below that of a single wave times 1.5.
    assert np.max(np.abs(whole.position)) < 1.5 * math.sqrt(2) * 5e-4


GAIT = {  # range of motion [deg], largest torque [N m/kg] and power [W/kg], and where in the stride they are
    "ankle": {
        "range": (20, 35),
        "torque": (1.2, 1.7),
        "at": (0.45, 0.53),
        "power": (1.5, 4.0),
        "power_at": (0.50, 0.62),
    },
    "knee": {"range": (55, 70), "torque": (0.3, 0.7), "at": (0.08, 0.22)},
    "hip": {"range": (27, 50), "torque": (0.5, 1.1), "at": (0.02, 0.2)},
}


@pytest.mark.parametrize("joint", GAIT)
def test_walking_is_that_of_textbooks(joint):
    """Against ranges that normal level walking stays within (Winter, Biomechanics and Motor Control of Human Movement).

    The file is another data set. Degrees for radians, a torque that is not per mass, a sign, a joint in the place of another
    or a stride that begins elsewhere leave these ranges.
    """
    known, mass = GAIT[joint], 75.0
    whole = DutyCycle(motion=Walking(**{**KNEE, "joint": joint})).instants()
    share = whole.time / 1.1
    angle, torque = np.degrees(whole.position / 0.05), -whole.course.force * 0.05 / mass
    power = torque * whole.course.speed / 0.05
    assert known["range"][0] < np.ptp(angle) < known["range"][1]
    assert known["torque"][0] < torque.max() < known["torque"][1]
    assert known["at"][0] < share[np.argmax(torque)] < known["at"][1]
    work = np.mean(power) * 1.1
    if joint == "ankle":  # push-off
        assert known["power"][0] < power.max() < known["power"][1]
        assert known["power_at"][0] < share[np.argmax(power)] < known["power_at"][1]
    if joint == "knee":  # brakes on the whole, and bends most in the swing
        assert 0.65 < share[np.argmin(angle)] < 0.8
        assert -0.4 < work < -0.08
    else:
        assert 0.0 < work < 0.4
    if joint == "hip":  # most extended shortly before the foot leaves the ground
        assert 0.48 < share[np.argmax(angle)] < 0.6


def test_walking_scales_with_mass_and_lever():
    """Twice the lever: twice the way and half the force, at the same power; half the mass: half the force."""
    one = DutyCycle(motion=Walking(**KNEE)).instants()
    other = DutyCycle(motion=Walking(**{**KNEE, "lever_arm": 0.1, "body_mass": 37.5})).instants()
    for name in ("speed", "acceleration", "snap"):
        there, here = getattr(other.course, name), getattr(one.course, name)
        assert_allclose(there, 2.0 * here, rtol=1e-9, atol=1e-12 * np.max(np.abs(here)))
    assert_allclose(other.position, 2.0 * one.position, rtol=1e-9, atol=1e-15)
    assert_allclose(other.course.force * other.course.speed, 0.5 * one.course.force * one.course.speed, rtol=1e-9)
    assert_allclose(other.course.force_rate, 0.25 * one.course.force_rate, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("joint", ["ankle", "knee", "hip"])
def test_a_quicker_stride_bends_the_joint_as_far(joint):
    """The joint passes through the same angles under the same moments, only sooner: the speed rises, not the range falls."""
    usual = Walking(**{**KNEE, "joint": joint})
    quick = Walking(**{**KNEE, "joint": joint, "stride_time": 0.55})
    share = np.linspace(0.0, 1.0, 50)
    (there, speed), (far, fast) = usual.derivatives(1.1 * share, 1), quick.derivatives(0.55 * share, 1)
    assert_allclose(far, there, rtol=1e-12, atol=1e-15)
    assert_allclose(fast, 2.0 * speed, rtol=1e-12, atol=1e-12)
    assert_allclose(quick.push(0.55 * share, 0)[0], usual.push(1.1 * share, 0)[0], rtol=1e-12)


def test_recording_of_a_sinusoid_is_the_sinusoid(tmp_path):
    """Within the pass band: position, acceleration and snap as of the closed form, to what 201 rows carry."""
    made = DutyCycle(motion=Recording.read(record(tmp_path, wave()), cutoff=10.0), load_mass=0.8)
    assert made.warnings == ()
    assert made.period == pytest.approx(1.0)
    whole = made.instants()
    turn = 2 * math.pi
    phase = turn * whole.time
    assert_allclose(whole.position, 0.05 * np.sin(phase), atol=2e-5)
    assert_allclose(whole.course.acceleration, -0.05 * turn**2 * np.sin(phase), atol=2e-3)
    assert_allclose(whole.course.snap, 0.05 * turn**4 * np.sin(phase), rtol=0, atol=0.3)
    assert_allclose(whole.course.force, -5 + np.cos(phase), atol=1e-3)


def test_speed_instead_of_position(tmp_path):
    rows = [f"{t},{100 * math.cos(2 * math.pi * t / 500)}" for t in range(0, 501, 2)]
    text = "\n".join(["time (ms),speed (mm/s)", *rows])
    whole = DutyCycle(motion=Recording.read(record(tmp_path, text))).instants()
    turn = 2 * math.pi / 0.5
    assert_allclose(whole.course.speed, 0.1 * np.cos(turn * whole.time), atol=1e-4)
    assert_allclose(np.ptp(whole.position), 0.2 / turn, rtol=1e-3)


def test_cutoff_takes_noise_away(tmp_path):
    random = np.random.default_rng(1)
    time = np.linspace(0, 2, 401)
    noisy = 50 * np.sin(math.pi * time) + random.normal(0, 0.2, time.size) * (time * (2 - time))
    text = "time [s],position [mm]\n" + "\n".join(f"{t},{p}" for t, p in zip(time, noisy, strict=True))
    file = record(tmp_path, text)
    smooth = DutyCycle(motion=Recording.read(file, cutoff=3.0)).instants()
    rough = DutyCycle(motion=Recording.read(file, cutoff=30.0)).instants()
    true = -0.05 * math.pi**2 * np.sin(math.pi * smooth.time)
    error = np.sqrt(np.mean((smooth.course.acceleration - true) ** 2))
    assert error < 0.05
    there = np.interp(rough.time, smooth.time, true)
    assert np.sqrt(np.mean((rough.course.acceleration - there) ** 2)) > 20 * error


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            wave(heading="time [s],position,force [N]"),
            "line 1, column 'position': must state its unit, such as 'position [mm]'",
        ),
        (
            wave(heading="time,position [mm],force [N]"),
            "line 1, column 'time': must state its unit, such as 'time [s]'",
        ),
        (
            wave(heading="time [s],position [kg],force [N]"),
            "line 1, column 'position [kg]': has the unit 'kg' where m is needed",
        ),
        (
            wave(heading="time [s],place [mm],force [N]"),
            "line 1: must name a column of position or speed, or of angle or angular speed; found 'time [s]' as time",
        ),
        (wave().replace("0.005000000,", "nan,"), "line 3, column 'time [s]': must be a finite number, got 'nan'"),
        (
            re.sub(r"(?m)^0\.020000000,[^,]*", "0.020000000,nan", wave()),
            "line 6, column 'position [mm]': must be a finite number, got 'nan'",
        ),
        (
            wave().replace("0.030000000,", "0.003000000,"),
            "line 8, column 'time [s]': must have a later time than the row above",
        ),
        ("time [s],position [mm]\n0,0\n1,1\n2,0\n", "must have at least 8 rows of numbers, got 3"),
        (
            "time [s],position [m]\n" + "\n".join(f"{k},{0.1 * k}" for k in range(20)),
            "must be one cycle that ends where it starts, but the position ends 1.9 m from its start, 100 % of the range",
        ),
        (
            "time [s],speed [m/s]\n" + "\n".join(f"{k},{1 + (k % 2)}" for k in range(20)),
            "must be one cycle that ends where it starts, but the mean speed is 1.5 m/s",
        ),
    ],
)
def test_mistakes_in_recordings_are_named(tmp_path, text, said):
    with pytest.raises(iv.InputError, match=re.escape(said)):
        DutyCycle(motion=Recording.read(record(tmp_path, text), cutoff=2.0))


def test_gaps_and_drift_are_reported(tmp_path):
    lines = wave().splitlines()
    gap = "\n".join([*lines[:50], *lines[70:]])
    (warning,) = DutyCycle(motion=Recording.read(record(tmp_path, gap))).warnings
    assert "line 51: 0.105 s without data, 21 times the median step; interpolated linearly" in warning
    drifting = [f"{t:.3f},{50 * math.sin(2 * math.pi * t) + 2 * t:.6f}" for t in np.linspace(0, 1, 201)]
    (warning,) = DutyCycle(
        motion=Recording.read(record(tmp_path, "\n".join(["time [s],position [mm]", *drifting]))), load_mass=1.0
    ).warnings
    assert "the position ends 0.002 m from its start, 2.0 % of the range; removed evenly" in warning
    sparse = wave(count=11)
    (warning,) = DutyCycle(motion=Recording.read(record(tmp_path, sparse))).warnings
    assert "a step of 0.1 s resolves frequencies up to 5 Hz only; the cutoff is 10 Hz" in warning


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (
            lambda: Tremor(distance=1e-3, low_frequency=12.0, high_frequency=12.0),
            "low_frequency must be < high_frequency = 12 Hz, got 12.0",
        ),
        (lambda: Sinusoid(distance=0.1, frequency=0.0), "frequency must be > 0 Hz, got 0.0"),
        (lambda: Walking(**{**KNEE, "joint": "toe"}), "joint must be one of ankle, knee, hip, got 'toe'"),
        (lambda: Walking(**KNEE, share=1.5), "share must be > 0 and <= 1, got 1.5"),
        (lambda: Hold(time=-1.0), "time must be > 0 s, got -1.0"),
    ],
)
def test_incomplete_cycles_are_refused(made, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        made()


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("drive", [COBOTIC, GEARED], ids=["cobotic", "geared"])
def test_cycles_close_and_samples_suffice(drive, shape):
    """Energy adds up to rounding, and twice the instants change it by less than 0.1 %."""
    made = duty(shape)
    found = duty_cycle(drive, made)
    assert found.closure < 1e-12
    given = found.energy + found.absorbed - found.delivered
    stored = sum(float(np.mean(flow)) for flow in found.point.stored.values()) * made.period
    assert sum(found.losses.values()) + stored == pytest.approx(given, rel=1e-9)
    assert abs(stored) < 1e-4 * sum(found.losses.values())
    finer = duty_cycle(drive, made, samples=2 * made.samples())
    assert finer.energy == pytest.approx(found.energy, rel=1e-3)
    assert len(next(iter(found.columns.values()))) == made.samples()


def test_holding_is_ohmic():
    """A geared motor that stands still burns I^2 R, warm: by hand, with the settled temperature of the winding."""
    found = duty_cycle(GEARED, duty("hold"))
    motor, gear = GEARED.motor, GEARED.gearhead
    # Each friction on the way takes what it can: guideway, gear (3 % of the continuous torque at the motor), motor.
    torque = (30.0 - 4.5) * GEARED.pulley.radius / gear.ratio - 0.03 * motor.continuous_torque - motor.friction_torque
    current = torque / motor.torque_constant
    hot = found.heat["motor"]
    resistance = motor.resistance * (1 + 0.0039 * (hot.mean_winding - 298.15))
    assert found.power_in == pytest.approx(current**2 * resistance, rel=1e-9)
    assert found.cold_power == pytest.approx(current**2 * motor.resistance, rel=1e-12)
    assert hot.winding == pytest.approx(
        298.15 + current**2 * resistance * (motor.winding_to_housing + motor.housing_to_ambient), rel=1e-6
    )
    assert found.holding.power == pytest.approx(found.cold_power)
    assert found.holding.parked is None
    # Without its help: the whole force, through lossless parts.
    unaided = 30.0 * GEARED.pulley.radius / (gear.ratio * motor.torque_constant)
    assert found.holding.without_help == pytest.approx(unaided**2 * motor.resistance, rel=1e-12)
    warmer = found.without_help.energy / found.duty.period
    assert unaided**2 * motor.resistance < warmer < 1.1 * unaided**2 * motor.resistance
    assert found.verdict.endswith(f"without friction holding the load, {found.without_help.energy:.3g} J per cycle")


def test_a_drive_that_can_hold_only_with_friction_says_so():
    """Between the currents with and without the help of friction the continuous torque is a limit of one only."""
    motor = GEARED.motor
    unaided = 30.0 * GEARED.pulley.radius / GEARED.gearhead.ratio
    geared = replace(GEARED, motor=replace(motor, continuous_torque=0.95 * unaided - motor.friction_torque))
    found = duty_cycle(geared, duty("hold"))
    assert found.feasible
    assert not found.without_help.feasible
    assert "; feasible only because friction helps to hold the load; without it " in found.verdict


def test_locked_wheel_holds_for_nothing():
    found = holding(COBOTIC, 30.0)
    assert found.parked == 0.0
    assert found.power > 1.0
    inertia = COBOTIC.cylinder_inertia + 57.0**2 * COBOTIC.motor.rotor_inertia
    assert found.run_up == pytest.approx(0.5 * inertia * 14.0**2)
    assert found.pays_after == pytest.approx(found.run_up / found.power)
    assert holding(COBOTIC, 100.0).limit == Limit.SLIP  # beyond mu P = 78 N


def test_verdicts():
    able = duty_cycle(COBOTIC, duty("reaches"))
    assert able.feasible
    assert able.verdict.startswith("feasible; tightest limit: motor: supply voltage (margin 1.")
    slipping = duty_cycle(COBOTIC, duty("hold", force=-100.0))
    assert not slipping.feasible
    assert slipping.verdict.startswith("infeasible: wheel slip, 1.2")
    assert math.isnan(slipping.energy)
    fast = duty_cycle(STUDY.drives["motor1-gear1"], duty("sinusoid", motion=Sinusoid(distance=0.2, frequency=2.0)))
    assert "infeasible: motor: supply voltage, " in fast.verdict
    hot = duty_cycle(STUDY.drives["motor1-gear3"], duty("hold", force=-36.0, ambient=330.0))
    assert not hot.feasible
    assert "motor winding reaches" in hot.verdict
    assert "limit 100 °C exceeded after" in hot.verdict


def test_travel_is_a_limit():
    assert duty_cycle(COBOTIC, duty("reaches"), travel=0.09).exceeded == ((Limit.TRAVEL, "load"),)
    assert duty_cycle(COBOTIC, duty("reaches"), travel=0.11).feasible


def test_unknown_heat_is_said():
    drive = replace(GEARED, motor=replace(GEARED.motor, housing_time_constant=None))
    found = duty_cycle(drive, duty("sinusoid"))
    assert found.heat == {"motor": None}
    assert found.lacking == {"motor": ("housing_time_constant",)}


def test_a_schedule_gives_its_own_derivatives():
    """Against central differences, for levels and harmonics drawn at random."""
    parameters = np.random.default_rng(RNG_SEED).uniform(-0.3, 0.3, 1 + 2 * cylinder_policy.HARMONICS)
    time, step = np.linspace(0.0, 0.7, 50), 1e-5
    before, found, after = (schedule(14.0, 0.7, parameters, time + shift) for shift in (-step, 0.0, step))
    assert_allclose(found.rate, (after.value - before.value) / (2.0 * step), rtol=1e-6, atol=1e-5)
    assert_allclose(found.curvature, (after.rate - before.rate) / (2.0 * step), rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("returned", [-90.0, 30.0])
def test_search_prefers_limits_kept_whatever_the_direction_of_power(returned):
    """A load that drives all the time returns power: what exceeds limits, and what slips, still costs more than what does not."""
    drawn, unknown = np.full(4, returned), np.full(4, np.nan)
    point = functools.partial(MovingPoint, power_out=0.9 * drawn, losses={}, stored={}, states={})
    kept = cylinder_policy._penalised(point(power_in=drawn, utilisation={(Limit.SLIP, "wheel"): 0.5 * np.ones(4)}))
    exceeded = cylinder_policy._penalised(point(power_in=drawn, utilisation={(Limit.SLIP, "wheel"): 1.2 * np.ones(4)}))
    slipping = cylinder_policy._penalised(point(power_in=unknown, utilisation={}))
    assert kept == returned < exceeded < slipping


@functools.cache
def policies_of(shape):
    """Of the shipped drive, for the tests that look at the same."""
    return policies(COBOTIC, duty(shape))


@pytest.mark.parametrize(
    "shape", ["sinusoid", *(pytest.param(shape, marks=pytest.mark.slow) for shape in ("reaches", "walking"))]
)  # tests/cli/test_duty.py has the walking of a shipped study
def test_policies_gain(shape):
    """A speed chosen is no worse than the one given, a schedule no worse than the best constant speed, all within limits."""
    own, chosen, scheduled, coasting = policies_of(shape)
    assert own.power_in == pytest.approx(duty_cycle(COBOTIC, duty(shape)).cold_power, rel=1e-12)
    assert own.feasible
    assert chosen.feasible
    assert scheduled.feasible
    assert scheduled.power_in <= chosen.power_in * (1 + 1e-3) <= own.power_in * (1 + 2e-3)
    assert scheduled.slowest < scheduled.fastest
    assert coasting.name == "inertia as a flywheel"


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["hold", "sinusoid"])
def test_constant_and_scheduled_speeds_search_the_same_range(shape):
    """Holding pays best at the lowest speed of the range: no schedule is slower, and none that is constant is better."""
    own, chosen, scheduled, _ = policies(COBOTIC, duty("hold", force=-10.0)) if shape == "hold" else policies_of(shape)
    for policy in (chosen, scheduled):
        assert policy.slowest >= RANGE[0] * own.slowest * (1 - 1e-9)
        assert policy.fastest <= RANGE[1] * own.fastest * (1 + 1e-9)
    if shape == "hold":
        assert scheduled.slowest == pytest.approx(scheduled.fastest)
        assert scheduled.slowest == pytest.approx(chosen.slowest)
        assert scheduled.power_in == pytest.approx(chosen.power_in)


@pytest.mark.slow
def test_best_speed_against_a_fine_scan():
    """Ten times as many speeds find nothing better than the search by more than a thousandth."""
    made = duty("walking")
    _, chosen, *_ = policies_of("walking")
    scanned = [
        duty_cycle(replace(COBOTIC, cylinder_speed=14.0 * factor), made, samples=400)
        for factor in np.geomspace(0.1, 2, 150)
    ]
    least = min(found.cold_power for found in scanned if not found.exceeded)
    assert chosen.power_in <= least * 1.002


@pytest.mark.slow
def test_best_schedule_against_a_search_without_slopes():
    """Differential evolution over the same waves, with 15,000 schedules, is not better by more than a hundredth."""
    made = duty("walking")
    _, chosen, scheduled, _ = policies_of("walking")
    instants = made.instants(400, COBOTIC.orders)
    level = math.log(chosen.slowest / COBOTIC.cylinder_speed)

    def cost(parameters):
        speed = schedule(COBOTIC.cylinder_speed, made.period, parameters.T, instants.time)
        point = COBOTIC.follow(instants.course, load_mass=made.moved_mass, cylinder_speed=speed)
        share = speed.value / COBOTIC.cylinder_speed
        excess = np.maximum(np.max(share, axis=-1) / RANGE[1], RANGE[0] / np.min(share, axis=-1)) - 1.0
        for demand in demands(point).values():
            excess = np.maximum(excess, np.nan_to_num(demand, nan=10.0, posinf=10.0) - 1.0)
        return np.nan_to_num(np.mean(point.power_in, axis=-1), nan=1e3) * (1.0 + 50.0 * np.maximum(0.0, excess))

    bounds = [(level - 1.0, level + 1.0), *[(-0.8, 0.8)] * 6]
    found = differential_evolution(
        cost, bounds, vectorized=True, updating="deferred", rng=1, popsize=10, maxiter=220, tol=0.0, polish=False
    )
    assert found.fun < 0.95 * chosen.power_in
    assert scheduled.power_in <= 1.01 * found.fun


def test_flywheel_keeps_its_motor_current():
    """At a constant torque of the motor the current is constant, and the kinetic energy comes back each cycle."""
    made = duty("sinusoid")
    course = made.instants().course
    turning = COBOTIC.coast(course, period=np.asarray(made.period), load_mass=0.8)
    assert np.mean(turning.value) == pytest.approx(14.0, rel=1e-9)
    point = COBOTIC.follow(course, load_mass=0.8, cylinder_speed=turning)
    current = point.states["motor_current_A"]
    assert np.ptp(current) < 1e-9
    assert abs(np.mean(point.stored["cylinder"] + point.stored["motor"])) < 1e-6
    step = made.period / len(turning.value)
    slope = (np.roll(turning.value, -1) - np.roll(turning.value, 1)) / (2 * step)
    assert_allclose(slope, turning.rate, atol=1e-3 * np.max(np.abs(turning.rate)))


def test_a_force_of_zero_is_none():
    """As in a recording, whose force may be zero."""
    made = [duty_cycle(GEARED, duty("sinusoid", **force)) for force in ({}, {"force": 0.0})]
    assert made[0].energy == made[1].energy


def test_an_energy_that_no_settled_motor_has_names_the_winding():
    found = duty_cycle(GEARED, duty("hold", force=-300.0))
    assert found.heat["motor"].winding == math.inf
    assert "W on average with motor winding at 100 °C" in found.verdict
    assert "with motor winding" not in duty_cycle(GEARED, duty("hold")).verdict


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drive", "shape", "tolerance"),
    [(COBOTIC, "sinusoid", 0.02), (GEARED, "sinusoid", 0.03), (GEARED, "walking", 0.04)],
    ids=["cobotic sinusoid", "geared sinusoid", "geared walking"],
)
def test_prescribed_and_followed_energy_agree(drive, shape, tolerance):
    """Inverse dynamics against the bond graph with controllers: two codes, one machine. What is left is their tracking."""
    both = two_ways(drive, duty(shape))
    assert both.followed == pytest.approx(both.prescribed, rel=tolerance)
    assert both.rms_error < 1e-3
    assert set(both.lost_prescribed) - {"pulley"} <= set(both.lost_followed)
    assert "RMS position error" in both.explanation
    difference, _, *parts = re.findall(r"([+-][\d.]+) (?:J|%)", both.explanation.split(";")[0])
    assert float(difference) == pytest.approx(
        both.followed - both.prescribed, abs=10.0 ** -len(difference.split(".")[1])
    )
    last_digit = 10.0 ** -len(difference.split(".")[1])  # of parts as well; those below half of it are not named
    assert parts == sorted(parts, key=lambda part: -abs(float(part))) or "other " in both.explanation
    assert sum(map(float, parts)) == pytest.approx(
        float(difference), abs=0.5 * (len(parts) + 2) * last_digit
    )  # and what is not named


@pytest.mark.parametrize("shape", ["walking", "tremor"])
def test_steering_power_is_the_slope_of_its_energy(shape):
    """What flows into bell and rotor is d/dt of half J phidot^2 along the cycle, by differences away from reversals."""
    made = duty(shape)
    whole = made.instants(40_000)
    point = COBOTIC.follow(whole.course, load_mass=0.8)
    inertia = COBOTIC.steering.bell_inertia + COBOTIC.steering.ratio**2 * COBOTIC.steering.motor.rotor_inertia
    kinetic = 0.5 * inertia * point.states["steering_rate_rad_s"] ** 2
    slope = (kinetic[2:] - kinetic[:-2]) / (whole.time[2:] - whole.time[:-2])
    same_way = np.abs(np.diff(np.sign(whole.course.speed), 2)) == 0
    flow = point.stored["steering"][1:-1]
    assert_allclose(slope[same_way], flow[same_way], atol=1e-4 * np.max(np.abs(flow)))


def test_heat_alone_can_rule_a_drive_out():
    """Within its continuous torque, which holds at 25 C, a motor near an oven still gets too hot."""
    found = duty_cycle(GEARED, duty("hold", force=-50.0, ambient=350.0))
    assert found.exceeded == ()
    assert not found.feasible
    assert found.verdict.startswith("infeasible in continuous operation: motor winding reaches")


def test_drift_is_evened_out(tmp_path):
    """With 2 % of drift taken out over the cycle, the seam does not ring: speeds as of the sinusoid alone."""
    rows = [f"{t:.4f},{50 * math.sin(2 * math.pi * t) + 2 * t:.6f}" for t in np.linspace(0, 1, 401)]
    whole = DutyCycle(motion=Recording.read(record(tmp_path, "\n".join(["time [s],position [mm]", *rows])))).instants()
    turn = 2 * math.pi
    assert_allclose(whole.course.speed, 0.05 * turn * np.cos(turn * whole.time), atol=1e-4)


def test_smoothing_passes_what_it_says(tmp_path):
    """Waves of 1 to 10 Hz with a cut-off of 8 Hz: whole up to 4, half at 6, none from 8 on."""
    time = np.linspace(0, 1, 2001)
    total = sum(np.sin(2 * math.pi * k * time) for k in range(1, 11))
    text = "time [s],position [mm]\n" + "\n".join(f"{t:.6f},{p:.9f}" for t, p in zip(time, total, strict=True))
    whole = DutyCycle(motion=Recording.read(record(tmp_path, text), cutoff=8.0)).instants()
    spectrum = 2 * np.abs(np.fft.rfft(whole.position * 1e3)) / len(whole.position)
    expected = [1.0, 1.0, 1.0, 1.0, 0.5 + math.sqrt(0.125), 0.5, 0.5 - math.sqrt(0.125), 0.0, 0.0, 0.0]
    assert_allclose(spectrum[1:11], expected, atol=2e-3)


def test_schedules_follow_their_derivatives():
    parameters = np.array([0.1, 0.3, -0.2, 0.1, 0.05, -0.1, 0.2])
    time = np.linspace(0, 1.1, 20001)
    speed = schedule(14.0, 1.1, parameters, time)
    step = time[1] - time[0]
    for lower, higher in ((speed.value, speed.rate), (speed.rate, speed.curvature)):
        slope = (lower[2:] - lower[:-2]) / (2 * step)
        assert_allclose(slope, higher[1:-1], atol=1e-6 * np.max(np.abs(higher)))
    assert speed.value[0] == pytest.approx(speed.value[-1])


@pytest.mark.parametrize("drive", [COBOTIC, GEARED])
def test_peak_torques_are_torques_and_peak_currents_currents(drive):
    found = duty_cycle(drive, duty("reaches"))
    said, states = found.to_dict(), found.point.states
    columns = {"motor": "motor", "steering motor": "steering"}
    motors = {"motor" if role != "steering" else "steering motor": motor for role, motor in drive.motors.items()}
    assert set(said["peak_torque_over_continuous"]) == set(said["peak_current_over_continuous"]) == set(motors)
    for what, motor in motors.items():
        torque = float(np.max(np.abs(states[f"{columns[what]}_torque_Nm"])))
        current = float(np.max(np.abs(states[f"{columns[what]}_current_A"])))
        assert said["peak_torque_over_continuous"][what] == pytest.approx(torque / motor.continuous_torque)
        assert said["peak_current_over_continuous"][what] == pytest.approx(current / motor.continuous_current)
        assert said["peak_torque_over_continuous"][what] != pytest.approx(said["peak_current_over_continuous"][what])


def test_bars_of_losses_are_titled_so():
    from internals import duty_cycle_data as data

    found = duty_cycle(GEARED, duty("reaches"), name="geared", title="Geared")
    bars = data(iv.analysis.DutyComparison(duty=found.duty, results={"geared": found}, policies={}, two_ways={}))[
        "losses"
    ]
    assert bars["title"] == "losses per cycle"
    assert bars["losses"]["Geared"] == found.losses


def test_a_net_power_of_rounding_is_zero():
    net = duty_cycle(GEARED, duty("sinusoid")).powers["power_to_load_net_W"]
    assert net == 0.0 or abs(net) > 1e-9


def test_policies_need_a_cylinder():
    drive = shipped_study("faulring2006").drives["motor1-gear1"]
    with pytest.raises(iv.ParameterError, match="a drive of type ConventionalDrive has no cylinder"):
        policies(drive, DutyCycle(motion=Sinusoid(distance=0.01, frequency=1.0), load_mass=1.0))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("stiffness", [1e200, 1e300])
def test_an_absurd_value_is_refused_without_warnings(stiffness):
    drive = shipped_study("faulring2006").drives["motor1-gear1"]
    drive = replace(drive, output=iv.Output(parallel_spring=iv.parts.Spring(stiffness=stiffness)))
    with pytest.raises(iv.ParameterError, match="shake: the power exceeds all numbers"):
        duty_cycle(drive, DutyCycle(motion=Sinusoid(distance=0.01, frequency=1.0), load_mass=1.0, title="shake"))
