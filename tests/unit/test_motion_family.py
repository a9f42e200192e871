"""One family of motions: each kind's values at single instants and over a cycle agree; files are read once and held."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, Scenario
from infinivar.motion import (
    ConstantForce,
    Cruise,
    Hold,
    Reach,
    Reaches,
    RecordedForce,
    Recording,
    Rest,
    Running,
    Sinusoid,
    SinusoidalForce,
    Step,
    StepForce,
    Tremor,
    Walking,
    Waypoints,
)
from internals import CYCLES, FORCES, MOTIONS

TIME = np.linspace(0.0, 1.0, 101)
WAVE = {"time": TIME, "position": 0.05 * np.sin(2 * np.pi * TIME), "force": np.cos(2 * np.pi * TIME)}

REPEATED = [
    Hold(time=2.0),
    Sinusoid(distance=0.03, frequency=2.0),
    Sinusoid(distance=-0.03, frequency=2.0, start=0.1),
    Reaches(distance=-0.1, time=0.4, pause=0.3),
    Tremor(distance=5e-4, low_frequency=8.0, high_frequency=12.0),
    Walking(joint="knee", body_mass=75.0, stride_time=1.1, lever_arm=0.05),
    Running(joint="ankle", body_mass=70.0),
    Recording(file="wave", **WAVE),
]
ONCE = [
    Rest(),
    Cruise(speed=0.3, start=0.1),
    Step(distance=0.01),
    Reach(distance=0.1, time=0.5),
    Waypoints(file="way", time=[0.0, 0.1, 0.3], position=[0.0, 0.01, -0.01], start=0.1),
]
FORCED = [
    ConstantForce(size=-5.0),
    StepForce(size=3.0, start=0.1),
    SinusoidalForce(size=3.0, frequency=2.0),
    RecordedForce(file="push", time=[0.0, 1.0], force=[0.0, 5.0]),
]
STUDY = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[duty.recorded]
shape = "file"
file = "motion.csv"
cutoff = "8 Hz"
[scenarios.recorded]
duration = "0.2 s"
motion = { shape = "file", file = "way.csv" }
force = { shape = "file", file = "push.csv" }
"""
FILES = {"motion.csv": (0.05, "position [m]"), "way.csv": (0.01, "position"), "push.csv": (5.0, "force")}


def names(values):
    return [type(value).__name__ for value in values]


def written(folder, factor=1.0):
    """The study with its files."""
    for name, (size, heading) in FILES.items():
        rows = [f"{t:.2f},{factor * size * np.sin(2 * np.pi * t):.9f}" for t in TIME]
        (folder / name).write_text("\n".join([f"time{' [s]' if '[' in heading else ''},{heading}", *rows]), "utf-8")
    (folder / "study.toml").write_text(STUDY, "utf-8")
    return iv.load_study(folder / "study.toml")


def test_every_kind_is_in_a_family_and_tried_here():
    assert set(map(type, REPEATED)) == set(CYCLES.values())
    assert set(map(type, ONCE)) | {Sinusoid} == set(MOTIONS.values())
    assert set(map(type, FORCED)) == set(FORCES.values())
    for family in (CYCLES, MOTIONS, FORCES):
        assert all(kind.shape == word for word, kind in family.items())


@pytest.mark.parametrize("motion", REPEATED, ids=names(REPEATED))
def test_single_instants_are_those_of_the_cycle(motion):
    """What controllers follow, and what inverse dynamics prescribes; the second cycle is as the first."""
    whole = DutyCycle(motion=motion).instants()
    for place in range(7, len(whole.time), len(whole.time) // 9):
        expected = whole.position[place], whole.course.speed[place], whole.course.acceleration[place]
        for time in (whole.time[place], whole.time[place] + motion.period):
            assert_allclose(motion.at(float(time)), expected, rtol=1e-9, atol=1e-9)


def test_a_scenario_follows_a_motion_that_repeats():
    """One value serves both: a controller follows reaches as it follows each of them."""
    drive = written_drive()
    reaches, reach = Reaches(distance=0.01, time=0.1, pause=0.1), Reach(distance=0.01, time=0.1)
    runs = [
        iv.simulate(drive, Scenario(duration=0.2, load_mass=0.8, motion=motion, output_step=0.01))
        for motion in (reaches, reach)
    ]
    assert_allclose(*(run.columns["position_m"] for run in runs), atol=1e-6)


def written_drive():
    from internals import shipped_study

    return shipped_study("faulring2006").drives["cobotic"]


@pytest.mark.parametrize("value", [*REPEATED, *ONCE, *FORCED], ids=names([*REPEATED, *ONCE, *FORCED]))
def test_equal_values_are_equal_and_travel(value):
    sent = pickle.loads(pickle.dumps(value))
    assert sent == value == copy.deepcopy(value) == replace(value)
    assert hash(sent) == hash(value)
    assert value != 1
    assert len(repr(value)) < 200
    assert sum(value == other for other in [*REPEATED, *ONCE, *FORCED]) == 1
    for one in (value, sent, copy.deepcopy(value)):
        for name in ("time", "position", "force"):
            if isinstance(held := getattr(one, name, None), np.ndarray):
                with pytest.raises(ValueError, match="read-only"):
                    held[0] = 1.0


def test_a_recording_is_its_data():
    """Not the name of its file, nor the caller's array."""
    mine = WAVE["position"].copy()
    one = Recording(file="one.csv", time=TIME, position=mine)
    mine[:] = 0.0
    assert one == Recording(file="another.csv", time=TIME, position=WAVE["position"])
    assert one != Recording(file="one.csv", time=TIME, position=1.001 * WAVE["position"])
    assert one != replace(one, cutoff=5.0)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"time": TIME}, "position or speed must be given, but not both"),
        ({**WAVE, "speed": TIME}, "position or speed must be given, but not both"),
        ({**WAVE, "time": TIME[::-1]}, "time must increase from row to row"),
        ({**WAVE, "force": TIME[1:]}, "force must have as many numbers as time, 101, got shape"),
        ({**WAVE, "cutoff": 0.5}, r"cutoff must be >= 2 Hz, to keep one cycle in a recording of 1 s, got 0\.5"),
    ],
)
def test_recordings_that_cannot_be(columns, said):
    with pytest.raises(iv.ParameterError, match=said):
        Recording(file="wave", **columns)


@pytest.mark.parametrize("fate", ["gone", "changed"])
def test_files_are_read_when_the_study_is_loaded_and_never_again(tmp_path, fate):
    study, unmoved = written(tmp_path), tmp_path / "unmoved"
    unmoved.mkdir()
    expected = written(unmoved)
    for name in FILES:
        if fate == "gone":
            (tmp_path / name).unlink()
        else:
            (tmp_path / name).write_text("no longer a table\n", "utf-8")
    drive = study.drives["cobotic"]
    assert study.duty == expected.duty
    assert study.scenarios == expected.scenarios
    assert pickle.loads(pickle.dumps(study)).duty == expected.duty
    duty, scenario = study.duty["recorded"], study.scenarios["recorded"]
    assert replace(duty, load_mass=1.0, motion=replace(duty.motion, cutoff=5.0)).period == duty.period
    assert iv.duty_cycle(drive, duty).energy == iv.duty_cycle(drive, expected.duty["recorded"]).energy
    found = [
        iv.simulate(drive, replace(one, duration=0.05)).columns["position_m"]
        for one in (scenario, expected.scenarios["recorded"])
    ]
    assert np.array_equal(*found)


def test_other_data_are_another_study(tmp_path):
    before = written(tmp_path)
    after = written(tmp_path, factor=1.01)
    assert before.duty != after.duty
    assert before.scenarios != after.scenarios


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("[duty.d]\nshape = 'hold'", ["duty.d.time is missing: shape = 'hold' needs it"]),
        (
            "[duty.d]\nshape = 'hold'\ntime = '1 s'\npause = '1 s'\nshare = 0.5",
            [
                "duty.d.pause does not apply with shape = 'hold'; remove it",
                "duty.d.share does not apply with shape = 'hold'; remove it",
            ],
        ),
        (
            "[duty.d]\nshape = 'reachs'",
            [
                'duty.d.shape = "reachs" must be one of hold, sinusoid, reaches, tremor, walking, running, file (did you mean '
                "'reaches'?)"
            ],
        ),
        (
            "[duty.d]\nshape = 'tremor'\ndistance = '-1 mm'\nlow_frequency = '8 Hz'\nhigh_frequency = '9 m'",
            [
                'duty.d.distance = "-1 mm" must be > 0 m, such as',
                "duty.d.high_frequency = \"9 m\" has the unit 'm' where Hz is needed",
            ],
        ),
        (
            "[duty.d]\nshape = 'sinusoid'\ndistanse = '1 mm'",
            ["duty.d.frequency is missing", "duty.d.distanse", "(did you mean 'distance'?)"],
        ),
        (
            "[scenarios.s]\nduration = '-1 s'\nmotion = { shape = 'reach', distanse = '1 mm' }",
            [
                "scenarios.s.duration",
                "scenarios.s.motion.distanse = \"1 mm\" is not a known key (did you mean 'distance'?); known keys: shape, ",
            ],
        ),
        (
            "[scenarios.s]\nduration = '1 s'\nmotion = 'reach'",
            ['scenarios.s.motion = "reach" must be a table [scenarios.s.motion]'],
        ),
        (
            "[scenarios.s]\nduration = '1 s'\nforce = { shape = 'sinusoid', size = '1 N', start = 2 }",
            ["scenarios.s.force.start = 2 needs a unit"],
        ),
        (
            "[scenarios.s]\nduration = '1 s'\nforce = {}",
            ["scenarios.s.force.size is missing: give size, or moment about a joint"],
        ),
    ],
)
def test_faults_of_a_kind_are_named(tmp_path, table, said):
    """Every fault of a table in one go, each with its path, and bounds of the kind that is asked for."""
    (tmp_path / "study.toml").write_text(STUDY.split("[duty")[0] + table, "utf-8")
    with pytest.raises(iv.InputError) as caught:
        iv.load_study(tmp_path / "study.toml")
    for words in said:
        assert words in str(caught.value)
