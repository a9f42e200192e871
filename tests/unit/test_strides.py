"""Strides of a recording: found in three ways, resampled, averaged, and their energies beside that of the mean cycle."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, InputError, ParameterError
from infinivar.motion import Recording
from internals import find_strides
from internals import resampled_strides as resampled
from made import parameter_study

DRIVES = parameter_study("faulring2006").drives


def course(phase):
    return 0.03 * np.sin(2 * math.pi * phase) + 0.012 * np.sin(4 * math.pi * phase + 0.5)


def walk(count=24, scatter=0.0, sway=0.0, rate=200.0, push=-5.0, seed=3):
    """Rows of strides whose times and sizes differ, with the time at which each begins."""
    random = np.random.default_rng(seed)
    edges = np.concatenate([[0.0], np.cumsum(1.1 * (1.0 + scatter * random.uniform(-1.0, 1.0, count)))])
    time = np.arange(int(edges[-1] * rate) + 1) / rate
    phase = np.interp(time, edges, np.arange(count + 1.0))
    size = 1.0 + sway * np.sin(2.0 * math.pi * 3.0 * time / edges[-1])
    columns = {"time": time, "position": size * course(phase), "force": push - 6.0 * size * np.cos(2 * math.pi * phase)}
    return columns, phase, edges


def test_resampling_is_as_exact_as_stated():
    """A sinusoid of 1 Hz at 100 Hz: 3/128 h^4 (2 pi)^4 at most."""
    time = np.arange(501) / 100.0
    share = np.linspace(0.0, 1.0, 1001)
    found = resampled(time, np.sin(2 * math.pi * time), np.array([1.0, 2.0, 3.0]), share)
    off = np.max(np.abs(found - np.sin(2 * math.pi * share)))
    bound = 3.0 / 128.0 * 1e-8 * (2 * math.pi) ** 4
    assert 0.3 * bound < off <= bound * (1.0 + 1e-6)


@pytest.mark.parametrize("way", ["contact", "pulses", "times", "phase"])
def test_marked_strides_are_found_exactly(way):
    columns, phase, edges = walk(scatter=0.05)
    share = phase % 1.0
    marks = {
        "contact": {"heel_strikes": (share < 0.6).astype(float)},
        "pulses": {"heel_strikes": np.concatenate([[1.0], (np.diff(share) < 0).astype(float)])},
        "times": {"heel_strikes": edges},
        "phase": {"phase": share},
    }[way]
    found = find_strides("walk", columns, **marks)
    step = 0.005 if way in ("contact", "pulses") else 1e-4
    for edge in found.edges:
        assert np.min(np.abs(edges - edge)) <= step
    assert len(found) >= 22
    assert np.all(np.abs(found.times - 1.1) < 0.07)
    if way in ("times", "phase"):
        assert_allclose(found.mean["position"], course(found.share), atol=2e-4)
        assert np.max(found.spread["position"]) < 2e-4


def test_the_period_is_found_where_nothing_marks_it():
    """Equal strides exactly; strides that differ in time by up to 5 %: their mean time to 0.5 %, with their scatter."""
    columns, _, _ = walk()
    found = find_strides("walk", columns)
    assert_allclose(found.times, 1.1, atol=1e-4)
    assert "period (1.1 s" in found.method
    columns, _, edges = walk(scatter=0.05)
    found = find_strides("walk", columns)
    assert found.period == pytest.approx(np.mean(np.diff(edges)), rel=5e-3)
    assert 0.4 < found.scatter / np.std(np.diff(edges), ddof=1) < 1.2
    assert np.max(found.spread["position"]) < 0.2 * np.ptp(found.mean["position"])


@pytest.mark.parametrize("noise", [1e-5, 1e-3])
def test_noise_is_no_period(noise):
    columns, _, _ = walk(rate=500.0)
    noisy = columns["position"] + noise * np.random.default_rng(0).standard_normal(len(columns["time"]))
    assert find_strides("walk", {**columns, "position": noisy}).period == pytest.approx(1.1, rel=1e-3)


def test_a_period_asked_for_selects_its_peak():
    """Two steps a stride that differ a little: the motion nearly repeats with the step, and fully with the stride."""
    time = np.arange(6001) / 200.0
    steps = np.sin(2 * math.pi * time / 0.55) + 0.12 * np.sin(2 * math.pi * time / 1.1)
    columns = {"time": time, "position": steps}
    assert find_strides("walk", columns).period == pytest.approx(0.55, rel=0.01)
    assert find_strides("walk", columns, period=1.0).period == pytest.approx(1.1, rel=1e-3)


def test_no_strides_are_one_clear_message():
    time = np.arange(4001) / 200.0
    drift = np.cumsum(np.random.default_rng(1).standard_normal(time.size))
    with pytest.raises(InputError, match=r"walk: no repeated stride found: .* name a column of heel strikes"):
        find_strides("walk", {"time": time, "position": drift})
    with pytest.raises(
        InputError, match=r"walk: must have at least 2 whole strides to average, found 0 by heel strikes"
    ):
        find_strides("walk", {"time": time, "position": drift}, heel_strikes=np.zeros(time.size))
    with pytest.raises(ParameterError, match="period must be > 0"):
        find_strides("walk", {"time": time, "position": drift}, period=-1.0)


def test_outliers_are_reported_and_stay_in_the_mean():
    columns, _, edges = walk(count=20)
    place = columns["position"].copy()
    stumble = (columns["time"] > edges[7]) & (columns["time"] < edges[8])
    place[stumble] *= 0.4
    found = find_strides("walk", {**columns, "position": place}, heel_strikes=edges)
    assert list(found.outliers) == [8]
    assert "position off the median" in found.outliers[8]
    assert_allclose(found.mean["position"], np.mean(found.curves["position"], axis=0))
    assert "1 unusual" in found.verdict
    late = edges.copy()
    late[5] += 0.2
    assert {5, 6} <= set(find_strides("walk", columns, heel_strikes=late).outliers)


def test_a_study_averages_strides(tmp_path):
    """With a column of heel strikes, from a study; the mean cycle closes and is what `find_strides` averages."""
    columns, phase, _ = walk(scatter=0.03)
    strike = (phase % 1.0 < 0.5).astype(int)
    rows = [
        f"{t:.6g},{1e3 * x:.6f},{f:.6f},{s}"
        for t, x, f, s in zip(columns["time"], columns["position"], columns["force"], strike, strict=True)
    ]
    (tmp_path / "walk.csv").write_text(
        "\n".join(["time [s],position [mm],force [N],heel_strike", *rows]) + "\n", "utf-8"
    )
    (tmp_path / "study.toml").write_text(
        '[requirement]\nforce = "20 N"\nspeed = "0.4 m/s"\nload_mass = "0.8 kg"\n'
        '[drives.geared]\nbase = "faulring2006.motor2-gear4"\n'
        '[duty.walk]\nshape = "file"\nfile = "walk.csv"\nstrides = "average"\n',
        "utf-8",
    )
    duty = iv.load_study(tmp_path / "study.toml").duty["walk"]
    assert duty.motion.averaged.method == "heel strikes"
    assert duty.period == pytest.approx(1.1, rel=0.02)
    assert_allclose(
        duty.motion.derivatives(duty.motion.time[::20] % duty.period, 0)[0],
        course(duty.motion.averaged.share[::20]),
        atol=1e-3,
    )
    found = iv.duty_cycle(DRIVES["motor2-gear4"], duty)
    assert found.strides.singles.size == len(duty.motion.averaged)
    assert found.to_dict()["single_strides"]["strides"] == found.strides.singles.size


def test_strides_of_a_phase_alone_have_the_cycle_time(tmp_path):
    """As data sets of gait store them: stride after stride from 0 to 99.3 %, without times; of different size."""
    share = np.arange(150) / 150.0
    sizes = np.array([0.9, 1.0, 1.1, 1.0])
    rows = [f"{100 * p:.6f},{size * math.cos(2 * math.pi * p):.9f}" for size in sizes for p in share]
    (tmp_path / "gait.csv").write_text("\n".join(["phase [%],knee angle [rad]", *rows]) + "\n", "utf-8")
    motion = Recording.read(str(tmp_path / "gait.csv"), cycle_time=1.2, strides="average")
    found = motion.averaged
    assert found.method == "phase"
    assert_allclose(found.times, 1.2, atol=1e-9)
    assert len(found) == 3  # the last one does not reach 100 %
    assert_allclose(found.mean["position"][::20], np.cos(2 * math.pi * found.share[::20]), atol=0.05)
    assert motion.axis.rotary


def averaged(**options):
    columns, _, edges = walk(**options)
    found = find_strides("walk", columns, heel_strikes=edges)
    return DutyCycle(
        motion=Recording(file="walk", strides="average", averaged=found, **found.mean_cycle), load_mass=0.8
    )


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_equal_strides_spend_what_their_mean_spends(name):
    energies = iv.analysis.stride_energies(DRIVES[name], averaged(count=8))
    assert energies.mean == pytest.approx(energies.mean_cycle, rel=2e-3)
    assert energies.deviation < 2e-3 * energies.mean


def test_strides_that_differ_spend_more_than_their_mean_by_the_variance():
    """A drive without constant friction: with the size ``1 + s sin`` of motion and force, its current has that size, too.

    The mean cycle has the mean size, 1. The copper loss of the strides is the mean square of the size, ``1 + s^2/2``.
    """
    sway = 0.3
    drive = DRIVES["motor2-gear4"]
    drive = replace(
        drive,
        motor=replace(drive.motor, no_load_current=1e-9),
        guideway=replace(drive.guideway, friction=1e-9),
        gearhead=replace(drive.gearhead, efficiency=1.0),  # its friction torque does not depend on the load
    )
    duty = averaged(count=24, sway=sway, push=0.0)
    energies = iv.analysis.stride_energies(drive, duty)
    assert energies.singles.size >= 23
    assert energies.mean > 1.01 * energies.mean_cycle
    copper = {}
    for motion in (duty.motion, duty.motion.as_run):
        course = replace(duty, motion=motion).instants().course
        copper[motion.closed] = float(np.mean(drive.follow(course, load_mass=0.8).losses["winding"]))
    assert copper[False] / copper[True] == pytest.approx(1.0 + 0.5 * sway**2, rel=2e-3)


def test_strides_do_not_go_with_a_run():
    found = averaged(count=4).motion
    with pytest.raises(ParameterError, match="closed must be true with strides = 'average'"):
        replace(found, closed=False)
    with pytest.raises(ParameterError, match="stride_time does not apply with strides = 'one'"):
        Recording(file="walk", stride_time=1.0, time=found.time, position=found.position)
    assert (
        iv.analysis.stride_energies(
            DRIVES["cobotic"], DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=1.0))
        )
        is None
    )


def separate(path, sizes, *, rows=150):
    """Strides from 0 to 100 %, both included, each closed, of different sizes about an offset."""
    share = np.linspace(0.0, 1.0, rows)
    lines = []
    for size in sizes:
        place = size * (30.0 * np.sin(2 * math.pi * share) + 15.0)
        push = size * (6.0 * np.cos(2 * math.pi * share) - 2.0)
        lines += [f"{100 * one:.4f},{x:.6f},{force:.6f}" for one, x, force in zip(share, place, push, strict=True)]
    path.write_text("phase (%),Pos (mm),Fz (N)\n" + "\n".join(lines) + "\n")
    return str(path)


def test_the_row_at_100_percent_belongs_to_its_stride(tmp_path):
    """The next stride starts elsewhere; curves, mean and energies are nevertheless those of the strides alone."""
    sizes = (0.8, 0.9, 1.0, 1.1, 1.2)
    motion = Recording.read(separate(tmp_path / "all.csv", sizes), strides="average", cycle_time=1.1)
    turn = 2 * math.pi * motion.averaged.share
    assert_allclose(motion.averaged.curves["position"], 1e-3 * np.outer(sizes, 30.0 * np.sin(turn) + 15.0), atol=3e-7)
    assert_allclose(motion.averaged.curves["force"], np.outer(sizes, 6.0 * np.cos(turn) - 2.0), atol=1e-4)
    assert motion.warnings == ()
    drive = DRIVES["motor2-gear4"]
    alone = [
        1.1 * iv.duty_cycle(drive, DutyCycle(motion=Recording.read(file, cycle_time=1.1), load_mass=0.8)).cold_power
        for file in (separate(tmp_path / f"{size}.csv", [size]) for size in sizes)
    ]
    found = iv.analysis.stride_energies(drive, DutyCycle(motion=motion, load_mass=0.8))
    assert_allclose(found.singles, alone, rtol=1e-4)


def test_a_window_and_resampling_leave_the_ends_of_strides(tmp_path):
    file = separate(tmp_path / "all.csv", (0.8, 1.0, 1.2))
    for how in ({"window": (0.5, 3.3)}, {"sample_rate": 180.0, "resampling": "cubic"}):
        motion = Recording.read(file, strides="average", cycle_time=1.1, **how)
        assert_allclose(motion.averaged.curves["position"][-2:, -1], [0.015, 0.018], rtol=0.02)
