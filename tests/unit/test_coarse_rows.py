"""Coarse rows: cubic between rows, rest of several rows, and accelerations that are read two ways."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.motion import Recording
from sampled import sampled

SPAN = np.linspace(0.0, 1.0, 4001)[1:-1]


def harmonics(random):
    """A motion of one to four harmonics of a period [s], by its derivatives: a function of time and order."""
    period, count = random.uniform(0.5, 4.0), random.integers(1, 5)
    order = np.arange(1, count + 1)[:, None]
    turn = 2.0 * np.pi * order / period
    cosine, sine = (random.normal(size=(count, 1)) / order ** random.uniform(1.5, 3.0) for _ in range(2))

    def motion(time, derivative=0):
        phase = turn * time + 0.5 * np.pi * derivative
        return np.sum(turn**derivative * (cosine * np.cos(phase) + sine * np.sin(phase)), axis=0)

    return period, motion


def read(lasts, rows, motion, column="position", **options):
    time = np.linspace(0.0, lasts, rows + 1)
    values = motion(time, 1 if column == "speed" else 0)
    return Recording(file="rows.csv", time=time, rotary=True, **{column: values}, **options)


def error(found, motion):
    """Largest error of the acceleration, relative to the largest acceleration."""
    time = found.period * SPAN
    true = motion(time, 2)
    return float(np.max(np.abs(found.derivatives(time, 2)[2] - true)) / np.max(np.abs(true)))


def named(found):
    return any("do not determine the acceleration" in one or "of the power" in one for one in found.warnings)


def cosine(time, derivative=0):
    """With an acceleration of 10 rad/s^2."""
    return 10.0 * np.pi ** (derivative - 2) * np.cos(np.pi * time + 0.5 * np.pi * derivative)


@pytest.mark.parametrize("cutoff", [10.0, 5.0, 4.0])
@pytest.mark.parametrize("column", ["position", "speed"])
@pytest.mark.parametrize("closed", [True, False])
def test_twenty_rows_of_a_cosine(column, closed, cutoff):
    """Two rows in the middle are equal, as at every reversal between rows: the load does not rest there.

    An image by cubics at 19 rows a period has (1/18)^2 = 0.3 % of the acceleration. At the ends of a run the second derivative
    of a cubic spline is off by 11/12 h^2 of its fourth: 10 %.
    """
    found = read(2.0, 19, cosine, column, closed=closed, cutoff=cutoff)
    assert error(found, cosine) < (0.01 if closed else 0.1)
    assert not len(found.smoothed.stays)
    assert not named(found)


@sampled("count", [25, 100], slow=2)
@pytest.mark.parametrize(
    ("column", "closed"), [("position", True), ("position", False), ("speed", True), ("speed", False)]
)
def test_an_acceleration_is_within_ten_percent_or_named(count, column, closed):
    """Known motions at 10 to 50 rows a cycle; runs of one to three cycles that end anywhere."""
    random = np.random.default_rng(7)
    wrong = right = false = 0
    for _ in range(count):
        period, motion = harmonics(random)
        rows = int(random.integers(10, 51))
        cycles = 1.0 if closed else random.uniform(1.0, 3.0)
        found = read(cycles * period, max(8, round(rows * cycles)), motion, column, closed=closed)
        off = error(found, motion)
        assert off <= 0.1 or named(found), f"{off:.1%} with {rows} rows"
        wrong, right = wrong + (off > 0.1), right + (off <= 0.1)
        false += off <= 0.05 and named(found)
    print(f"{column}, closed {closed}: {right} within 10 %, {wrong} named")
    assert wrong <= (0.1 if closed else 0.5) * count
    assert false <= 0.1 * count


def noisy(seed, *, shares, count, closed=True, gap=False, column="position"):
    """Random motions with noise of given shares of the range: share, error of the acceleration, whether it is named."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        period, motion = harmonics(random)
        rows = int(random.integers(10, 51))
        lasts = period * (1.0 if closed else random.uniform(1.0, 3.0))
        time = np.linspace(0.0, lasts, max(8, round(rows * lasts / period)) + 1)
        values, share = motion(time, 1 if column == "speed" else 0), random.choice(shares)
        values = values + share * np.ptp(values) * random.standard_normal(len(time))
        if not share:
            values = np.array([float(f"{one:.5g}") for one in values])
        if closed:
            values[-1] = values[0]
        kept = np.ones(len(time), dtype=bool)
        if gap:
            first = int(random.integers(1, len(time) - 3))
            kept[first : first + 2] = False
        data = {"time": time[kept], column: values[kept]}
        recorded = Recording(file="rows.csv", rotary=True, closed=closed, **data)
        found.append((share, error(recorded, motion), named(recorded)))
    return np.array(found).T


@sampled("count", [20, 200], slow=2)
@sampled(("column", "closed"), [("speed", True), ("position", True), ("position", False)], every=2)
def test_noise_that_spoils_the_acceleration_is_named(column, closed, count):
    """Noise of 0.03 to 1 % of the range: at most 1 in 20 that are wrong goes unnamed, as the estimate promises."""
    _, off, said = noisy(1, shares=[3e-4, 1e-3, 3e-3, 1e-2], count=count, closed=closed, column=column)
    wrong = off > 0.1
    print(
        f"{column}, closed {closed}: {wrong.sum():.0f} wrong, {np.sum(wrong & (said > 0))} named, median {np.median(off):.1%}"
    )
    assert wrong.sum() > (0.1 if column == "speed" else 0.4) * count
    assert np.sum(wrong & (said == 0)) <= 0.05 * wrong.sum()


@sampled("count", [20, 200], slow=2)
@pytest.mark.parametrize("gap", [False, True])
def test_a_clean_cycle_is_named_only_where_it_is_wrong(gap, count):
    """Values of five digits, with and without two missing rows; one read within 5 % is not named."""
    _, off, said = noisy(2, shares=[0.0], count=count, gap=gap)
    assert not np.any((off > 0.1) & (said == 0))
    right = off <= 0.05
    assert right.sum() > 0.5 * count
    assert np.sum(right & (said > 0)) < 0.05 * right.sum()


def test_a_cutoff_advised_for_noise_reads_the_acceleration():
    """Noise of 0.1 % on 30 rows of two harmonics: the default reads the peak too high, the advised cutoff does not."""

    def motion(time, derivative=0):
        phase = 0.5 * np.pi * derivative
        return np.pi**derivative * (
            np.cos(np.pi * time + phase) + 2.0**derivative / 6.0 * np.cos(2.0 * np.pi * time + phase)
        )

    time = np.linspace(0.0, 2.0, 31)
    values = motion(time)
    values += 1e-3 * np.ptp(values) * np.random.default_rng(3).standard_normal(31)
    values[-1] = values[0]

    def found(**options):
        return Recording(file="rows.csv", time=time, position=values, rotary=True, **options)

    (said,) = [one for one in found().warnings if "do not determine" in one]
    assert "by their noise" in said
    assert said.endswith("record more rows, or read a column of angular speed")
    assert error(found(), motion) > 0.1
    better = found(cutoff=float(said.partition('cutoff = "')[2].partition(" ")[0]))
    assert not named(better)
    assert error(better, motion) < 0.1


def test_what_rows_do_not_determine_is_named_with_a_way_out():
    """Thirteen rows of four harmonics: a cutoff between the highest, 2 Hz, and its image at 4.5 Hz keeps the image out."""

    def motion(time, derivative=0):
        phase = 0.5 * np.pi * derivative
        slow, quick = np.pi * time + phase, 4.0 * np.pi * time + phase + 1.0
        return np.pi**derivative * (np.cos(slow) + 4.0**derivative / 8.0 * np.cos(quick))

    found = read(2.0, 13, motion)
    (said,) = [one for one in found.warnings if "do not determine" in one]
    assert "% by what is between them, of the largest, 25.6 rad" in said
    assert error(found, motion) > 0.1
    advised = float(said.rpartition('cutoff = "')[2].split(" ")[0])
    better = read(2.0, 13, motion, cutoff=advised)
    assert not any("do not determine" in one for one in better.warnings)
    assert error(better, motion) < 0.1


def test_a_pause_of_coarse_rows_is_still_rest():
    """Ten rows a second, of which ten rest."""
    motion = iv.motion.Reaches(distance=0.2, time=1.0, pause=1.0, profile="smooth")
    time = np.linspace(0.0, 4.0, 41)
    position = motion.derivatives(np.minimum(time, 4.0 * (1 - 1e-12)), 0)[0]
    found = Recording(file="rows.csv", time=time, position=position)
    begin, end, value = found.smoothed.stays.T
    assert len(begin) == 2
    assert np.all(np.abs(end - begin - 1.0) < 0.35)
    assert value == pytest.approx([0.2, 0.0], abs=1e-3)


@pytest.mark.parametrize("rows", [12, 19, 20, 30])
def test_other_ways_to_coarse_rows(tmp_path, rows):
    """A phase, a higher sample rate, and the mean of strides: none adds accelerations that the rows do not state."""
    phase = np.arange(6 * rows) / rows
    columns = np.column_stack([2.0 * phase, phase % 1.0, cosine(2.0 * phase)])
    path = tmp_path / "rows.csv"

    def written(heading, values):
        np.savetxt(path, values, delimiter=",", header=heading, comments="", fmt="%.9g")
        return str(path)

    once = columns[: rows + 1]
    for found in (
        Recording.read(written("phase [1],angle [rad]", once[:-1, 1:]), cycle_time=2.0),
        Recording.read(written("time [s],angle [rad]", once[:, [0, 2]]), sample_rate=200.0),
        Recording.read(written("time [s],phase [1],angle [rad]", columns), strides="average"),
    ):
        assert error(found, cosine) < 0.1
        assert not len(found.smoothed.stays)


@pytest.mark.slow
def test_a_coarse_cycle_does_not_kink_at_its_join():
    """A cubic through eight of ten rows does not follow two harmonics: it is no kink."""
    random = np.random.default_rng(0)
    for rows in (10, 13, 15):
        for _ in range(10):
            period, motion = harmonics(random)
            assert not any("jumps" in one for one in read(period, rows, motion).warnings)


@sampled("rows", [19, 10, 12, 20, 30, 50], slow=6)
def test_the_sized_motor_does_not_change_with_the_rows(rows):
    """60 kg moved by a cosine: of the shipped parts the lightest pair, by its shape and from 10 to 50 rows a cycle."""
    knee = iv.load_study("knee_walking")

    def sized(motion):
        duty = {"move": iv.DutyCycle(motion=motion, load_mass=60.0)}
        study = replace(knee, duty=duty, requirement=None)
        best = iv.size(study, drive="geared", objective="mass", top=1).verdict
        return best.partition("; pulley")[0]

    by_shape = sized(iv.motion.Sinusoid(distance=1.0 / np.pi**2, frequency=0.5, start=0.5))
    time = np.linspace(0.0, 2.0, rows + 1)
    assert sized(Recording(file="rows.csv", time=time, position=0.1 * cosine(time))) == by_shape


@pytest.mark.parametrize("rows", [10, 20, 50])
def test_waypoints_that_begin_in_motion_are_named(rows):
    """A spline from rest jumps to the motion's speed within a row; one that does begin at rest is as it is."""
    time = np.linspace(0.0, 2.0, rows + 1)
    at_rest = iv.motion.Waypoints(file="rows.csv", time=time, position=cosine(time), rotary=True)
    assert not at_rest.warnings
    moving = iv.motion.Waypoints(file="rows.csv", time=time, position=cosine(time + 0.5), rotary=True)
    (said,) = moving.warnings
    assert "the rows begin at 3." in said
    most = max(abs(moving.at(instant).acceleration) for instant in np.linspace(0.0, 2.0, 2001))
    assert most > 20.0
    assert f"up to {most:.3g}" in said


def test_a_simulation_says_what_is_doubtful_in_its_file():
    time = np.linspace(0.0, 0.4, 9)
    motion = iv.motion.Waypoints(file="rows.csv", time=time, position=0.05 * np.sin(8.0 * time))
    scenario = iv.Scenario(duration=0.05, motion=motion, load_mass=0.5)
    run = iv.simulate(iv.load_study("hand_controller").drives["motor2-gear4"], scenario)
    assert "rows.csv: the rows begin at 0.4" in run.verdict
    assert run.to_dict()["warnings"] == list(run.warnings)
