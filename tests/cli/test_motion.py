"""`infinivar motion`: what is understood of a recording, in the terminal, as JSON and as a page; runs and strides in studies."""

import json
import math

import numpy as np
import pytest

import infinivar as iv
from folders import results
from internals import motion_advice as advice
from internals import motion_summary_figure as motion_figure

STUDY = """
[requirement]
force = "20 N"
speed = "0.4 m/s"
load_mass = "0.8 kg"
[drives.geared]
base = "faulring2006.motor2-gear4"
[duty.session]
shape = "file"
file = "log.csv"
{more}
"""


def log(path, *, duration=6.0, rate=200.0, heading="Time (s),Pos (mm),Fz (N)", scale=1.0, gap=None):
    """Strides of 1.2 s, 30 mm, against 6 N; 12 mm further on at the end of each second."""
    time = np.arange(round(duration * rate) + 1) / rate
    if gap is not None:
        time = time[(time <= gap) | (time >= gap + 0.1)]
    turn = 2.0 * math.pi / 1.2
    place, force = (
        scale * (30.0 * np.sin(turn * time) + 8.0 * np.sin(2 * turn * time + 0.4)),
        -6.0 - 4.0 * np.cos(turn * time),
    )
    rows = np.column_stack([time, place, force])
    np.savetxt(path, rows, delimiter=",", header=heading, comments="", fmt="%.7g")
    return path


def test_the_numbers_are_those_of_the_closed_form(tmp_path):
    """Five strides of two sinusoids: range, speed, acceleration, work and power of the force on the load."""
    found = iv.inspect_motion(log(tmp_path / "log.csv"), load_mass=0.8)
    turn = 2.0 * math.pi / 1.2
    time = np.linspace(0.0, 6.0, 60001)[:-1]
    speed = 1e-3 * (30.0 * turn * np.cos(turn * time) + 16.0 * turn * np.cos(2 * turn * time + 0.4))
    acceleration = -1e-3 * (30.0 * turn**2 * np.sin(turn * time) + 32.0 * turn**2 * np.sin(2 * turn * time + 0.4))
    power = (0.8 * acceleration + 6.0 + 4.0 * np.cos(turn * time)) * speed
    assert found.closed
    assert found.sampling.rows == 1201
    assert found.sampling.rate == pytest.approx(200.0)
    assert found.sampling.gaps == ()
    assert found.extremes["speed"][1] == pytest.approx(np.max(speed), rel=2e-3)
    assert found.extremes["speed"][2] == pytest.approx(np.sqrt(np.mean(speed**2)), rel=2e-3)
    assert found.extremes["acceleration"][2] == pytest.approx(np.sqrt(np.mean(acceleration**2)), rel=2e-3)
    assert np.max(found.power) == pytest.approx(np.max(power), rel=3e-3)
    assert np.mean(found.power) == pytest.approx(np.mean(power), rel=3e-3)
    given, taken = found.work
    assert given == pytest.approx(np.mean(np.clip(power, 0.0, None)) * 6.0, rel=3e-3)
    assert taken == pytest.approx(np.mean(np.clip(-power, 0.0, None)) * 6.0, rel=0.02)
    assert found.strides.period == pytest.approx(1.2, rel=1e-3)
    assert found.resting == 0.0


def test_the_spectrum_holds_the_power_of_the_motion(tmp_path):
    """Its integral is the variance (Parseval), and the advised cutoff lies above the second harmonic and well below the noise."""
    found = iv.inspect_motion(log(tmp_path / "log.csv", duration=24.0))
    spectrum = found.spectrum
    variance = 1e-6 * 0.5 * (30.0**2 + 8.0**2)
    assert np.sum(spectrum.power) * spectrum.frequency[0] == pytest.approx(variance, rel=0.02)
    assert 2 / 1.2 - 0.05 < spectrum.passed < 2.5
    assert spectrum.above < 1e-6
    slow = iv.inspect_motion(tmp_path / "log.csv", cutoff=1.2)
    assert slow.spectrum.above == pytest.approx(64.0 / 964.0, rel=0.02)  # the second harmonic alone
    assert any("suffices" in one for one in advice(slow))


def test_a_page_and_lines(infinivar, tmp_path):
    log(tmp_path / "log.csv", duration=5.1)
    outcome = infinivar("motion", "log.csv", "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    for said in (
        "does not close",
        "'Pos (mm)' in mm",
        "CSV with commas",
        "no gaps",
        "cutoff        10 Hz",
        "closed = false",
    ):
        assert said in outcome.out
    assert results(tmp_path / "out") == ["mean-cycle.csv", "motion-figure.svg", "motion.html", "motion.json"]
    page = (tmp_path / "out" / "motion.html").read_text("utf-8")
    for said in ("Pos (mm)", "does not close", "over the run", "Strides", "mean-cycle.csv"):
        assert said in page
    saved = json.loads((tmp_path / "out" / "motion.json").read_text("utf-8"))
    assert saved["strides"]["strides"] == 3
    again = infinivar("motion", "out/mean-cycle.csv", "--out", "again", "--json")
    assert json.loads(again.out)["closed"]
    assert json.loads(again.out)["duration_s"] == pytest.approx(1.2, rel=1e-3)


def test_rounding_is_shown_as_zero(infinivar, tmp_path):
    """A spring gives back what it took: the mean power is 0, not 1e-17 W, and so on the page."""
    time = np.arange(601) / 200.0
    wave = np.cos(2.0 * np.pi * time)
    rows = np.column_stack([time, 0.1 * wave, 5.0 * wave])
    np.savetxt(tmp_path / "spring.csv", rows, delimiter=",", header="time (s),position (m),force (N)", comments="")
    exact = iv.inspect_motion(tmp_path / "spring.csv")
    assert 0.0 < abs(np.mean(exact.power)) < 1e-12
    outcome = infinivar("motion", "spring.csv", "--out", "out")
    assert "power         -1.57 to 1.57 W, mean 0 W; 1.5 J to the load, 1.5 J from it" in outcome.out
    assert "closes: 0 m from the start" in outcome.out
    page = (tmp_path / "out" / "motion.html").read_text("utf-8")
    assert "10<sup>−1" not in page
    # What is small but not rounding stays.
    rows[:, 2] += 1e-6 * np.sin(2.0 * np.pi * time)
    np.savetxt(tmp_path / "spring.csv", rows, delimiter=",", header="time (s),position (m),force (N)", comments="")
    assert "mean 3.14e-7 W" in infinivar("motion", "spring.csv", "--out", "out").out


@pytest.mark.parametrize("blank", ["\u00a0", "\u202f", " "])
def test_headings_of_spreadsheets_are_shown_with_spaces(infinivar, tmp_path, blank):
    """Blanks at which no line breaks stand for spaces, in names and in units."""
    time = np.arange(201) / 200.0
    rows = np.column_stack([time, 30.0 * np.cos(2.0 * np.pi * time), 10.0 * np.cos(2.0 * np.pi * time)])
    head = "time (s),knee angle (deg),moment (N m)".replace(" ", blank)
    np.savetxt(tmp_path / "knee.csv", rows, delimiter=",", header=head, comments="", encoding="utf-8")
    outcome = infinivar("motion", "knee.csv", "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    assert "  angle         'knee angle (deg)' in deg: " in outcome.out
    assert "  moment        'moment (N m)' in N m: " in outcome.out
    assert "  angular speed -3.29 to 3.29 rad/s" in outcome.out
    assert all(line.isprintable() for line in outcome.out.splitlines())
    assert "\\" not in outcome.out


def test_a_joint_is_shown_with_its_words(infinivar, tmp_path):
    time = np.arange(401) / 100.0
    rows = np.column_stack(
        [100.0 * time / 4.0, 20.0 * np.sin(2 * np.pi * time / 4.0), 0.5 * np.cos(2 * np.pi * time / 4.0)]
    )
    head = "Gait cycle [%];Knee angle (deg);Knee moment [Nm/kg]"
    np.savetxt(tmp_path / "knee.csv", rows, delimiter=";", header=head, comments="", fmt="%.6f")
    outcome = infinivar("motion", "knee.csv", "--cycle-time", "1.2 s", "--body-mass", "75 kg", "--out", "out", "--json")
    assert (outcome.code, outcome.err) == (0, "")
    said = json.loads(outcome.out)
    assert said["about_a_joint"]
    assert said["closed"]
    assert said["position"]["highest"] == pytest.approx(math.radians(20.0), rel=1e-3)
    assert said["force"]["highest"] == pytest.approx(37.5, rel=1e-3)
    page = (tmp_path / "out" / "motion.html").read_text("utf-8")
    assert "moment on the load" in page
    assert "N m" in page


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["log.csv", "--columns", "time"], "must be roles and headings"),
        (["log.csv", "--columns", "time="], "must be roles and headings"),
        (["log.csv", "--columns", " =Time (s)"], "must be roles and headings"),
        (["log.csv", "--columns", "tme=Time (s)"], "tme"),
        (["log.csv", "--window", "2 s"], "must be a start and an end"),
        (["log.csv", "--window", "2 s, 90 s"], "outside"),
        (["log.csv", "--cutoff", "0.01 Hz"], "to keep one cycle in a recording of 6 s"),
        (["log.csv", "--body-mass", "75 kg"], "per kilogram"),
        (["log.csv", "--load-mass", "3 N"], "--load-mass '3 N' must be a mass such as \"0.8 kg\""),
        (["log.csv", "--load-mass", "0.8 kg m^2"], "is a moment of inertia, but the motion is along a line"),
        (["log.csv", "--load-mass=-1 kg"], "--load-mass '-1 kg' must be >= 0"),
        (["turn.csv", "--load-mass", "1 kg"], "is a mass, but the motion is about a joint"),
        (["log.csv", "--stride-time", "0 s"], "stride_time must be > 0 s, got 0"),
        (["log.csv", "--cutoff", "500 Hz"], "cutoff must be <= 100 Hz, half the sample rate, got 500"),
        (["turn.csv", "--body-mass", "0 kg"], "body_mass must be > 0 kg"),
        (["none.csv"], "none.csv"),
    ],
)
def test_bad_input_is_one_message_and_writes_nothing(infinivar, tmp_path, arguments, message):
    log(tmp_path / "log.csv")
    log(tmp_path / "turn.csv", heading="Time (s),Angle (deg),Moment (Nm)")
    outcome = infinivar("motion", *arguments, "--out", "out")
    assert outcome.code == 2
    assert message in outcome.err
    assert outcome.err.count("infinivar:") == 1
    assert results(tmp_path) == ["log.csv", "turn.csv"]


def test_a_gap_is_shown(tmp_path):
    found = iv.inspect_motion(log(tmp_path / "log.csv", gap=2.0))
    ((start, length),) = found.sampling.gaps
    assert (start, length) == (pytest.approx(2.0), pytest.approx(0.1))
    assert found.sampling.jitter < 1e-6
    assert len(found.warnings) == 1


def test_the_figure_draws_the_whole_run(tmp_path):
    from internals import motion_summary_figure as motion_summary

    found = iv.inspect_motion(log(tmp_path / "log.csv", duration=25.3))
    numbers = motion_summary.data(found)
    for curves in numbers["panels"].values():
        for time, values in curves.values():
            assert (time[0], time[-1]) == (pytest.approx(0.0, abs=0.02), pytest.approx(25.3, abs=0.02))
            assert np.all(np.diff(time) > 0.0)
            assert np.all(np.isfinite(values))
    raw = next(iter(numbers["panels"].values()))["raw"][1]
    assert np.max(raw) == pytest.approx(1e3 * np.max(found.table.values["position"]))
    share, rows, mean, spread = next(iter(numbers["strides"].values()))
    assert rows.shape == (len(found.strides), share.size)
    assert mean.shape == spread.shape == share.shape


def test_a_run_in_a_study_has_the_words_of_a_run(infinivar, tmp_path):
    log(tmp_path / "log.csv", duration=5.1)
    (tmp_path / "study.toml").write_text(STUDY.format(more='closed = false\nstart_temperature = "50 degC"'), "utf-8")
    outcome = infinivar("compare", "study.toml", "--out", "out")
    assert outcome.code == 0, outcome.err
    assert "J over the run" in outcome.out
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    session = page[page.index("Duty cycle:") :]
    for said in (
        "Recorded run",
        "Duration",
        "motors start at 50",
        "over the run",
        "highest in the run",
        "a run is not simulated",
    ):
        assert said in session, said
    for not_said in ("per cycle", "repeated until", "a cycle<", "settled"):
        assert not_said not in session, not_said
    drive = json.loads((tmp_path / "out" / "results.json").read_text("utf-8"))["duty"]["session"]["drives"]["geared"]
    assert drive["closed"] is False
    assert drive["heat"]["motor"]["winding_C"] >= 49.9


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ('closed = "no"', 'duty.session.closed = "no" must be true or false'),
        ("", "set closed = false"),
        ('closed = false\nstrides = "average"', "closed must be true with strides = 'average'"),
        ('closed = false\nstride_time = "1 s"', "stride_time does not apply"),
        ('strides = "average"\nstart_temperature = "50 degC"', "start_temperature does not apply to a cycle"),
        ('strides = "averge"', "must be one of one, average"),
    ],
)
def test_keys_that_do_not_fit_are_refused(infinivar, tmp_path, more, message):
    log(tmp_path / "log.csv", duration=5.1)
    (tmp_path / "study.toml").write_text(STUDY.format(more=more), "utf-8")
    outcome = infinivar("check", "study.toml")
    assert outcome.code == 2
    assert message in outcome.err


def test_a_load_without_force_and_mass_is_an_oversight(infinivar, tmp_path):
    log(tmp_path / "log.csv", duration=5.1)
    text = STUDY.format(
        more='closed = false\ncolumns = { time = "Time (s)", position = "Pos (mm)" }\nload_mass = "0 kg"'
    )
    (tmp_path / "study.toml").write_text(text, "utf-8")
    assert "the load has no force or mass, so that drives move only themselves" in infinivar("check", "study.toml").err
    (tmp_path / "study.toml").write_text(text.replace("0 kg", "1 kg"), "utf-8")
    assert "only themselves" not in infinivar("check", "study.toml").err


def test_strides_are_not_called_a_cycle(infinivar, tmp_path):
    """Five strides that close: time and work are those of the recording, and the work of a stride is a fifth."""
    found = iv.inspect_motion(log(tmp_path / "log.csv"), load_mass=0.8)
    assert found.closed
    assert found.work_per_stride == pytest.approx([one / 5.0 for one in found.work], rel=1e-3)
    assert found.to_dict()["power"]["work_on_load_per_stride_J"] == found.work_per_stride[0]
    outcome = infinivar("motion", str(tmp_path / "log.csv"), "--load-mass", "0.8 kg", "--out", str(tmp_path / "out"))
    assert "J from it over the recording" in outcome.out
    assert "per stride" in outcome.out
    page = (tmp_path / "out" / "motion.html").read_text("utf-8")
    assert "per stride, on average" in page
    assert "per cycle" not in page
    assert "time in the recording [s]" in [ax.get_xlabel() for ax in motion_figure.draw_all(found).axes]


def test_one_cycle_has_no_strides_to_miss(infinivar, tmp_path):
    found = iv.inspect_motion(log(tmp_path / "log.csv", duration=1.2))
    assert found.strides is None
    assert found.no_strides == "no stride repeats within the one cycle"
    assert found.work_per_stride is None
    assert "time in the cycle [s]" in [ax.get_xlabel() for ax in motion_figure.draw_all(found).axes]
