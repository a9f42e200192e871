"""What Python users see: typed drives, short representations, and messages that say what to write."""

import json
import pickle
import subprocess
import sys

import pytest

import infinivar as iv
from made import loaded

STUDY = loaded("hand_controller")
DRIVE, GEARED = STUDY.drives["cobotic"], STUDY.drives["motor2-gear4"]
SINE = iv.motion.Sinusoid(distance=0.02, frequency=1.0)
CYCLE = iv.DutyCycle(motion=SINE)
ARM = loaded("two_joint_arm")
MACHINE = next(iter(ARM.drives.values()))
TASK, PATH = next(iter(ARM.tasks.values())), next(iter(ARM.paths.values()))

DUTY = "duty must be a DutyCycle, got "
SCENARIO = "scenario must be a Scenario, got "
STUDY_WANTED = "study must be a Study, got 'hand_controller'; write iv.load_study('hand_controller')"
WRONG = {
    DUTY + "a Sinusoid; write iv.DutyCycle(motion=duty)": [
        lambda: iv.duty_cycle(DRIVE, SINE),
        lambda: iv.analysis.two_ways(DRIVE, SINE),
        lambda: iv.analysis.policies(DRIVE, SINE),
        lambda: iv.analysis.stride_energies(DRIVE, SINE),
    ],
    DUTY + "'shake'; write study.duty['shake']": [lambda: iv.duty_cycle(DRIVE, "shake")],
    DUTY + "a int": [lambda: iv.duty_cycle(DRIVE, 3)],
    SCENARIO + "a Sinusoid; write iv.Scenario(motion=scenario, duration=...)": [lambda: iv.simulate(DRIVE, SINE)],
    SCENARIO + "a DutyCycle; write iv.Scenario(motion=scenario.motion, duration=...)": [
        lambda: iv.simulate(DRIVE, CYCLE)
    ],
    SCENARIO + "'reach'; write study.scenarios['reach']": [lambda: iv.simulate(DRIVE, "reach")],
    "motion must be one of Rest, Cruise, Sinusoid, Step, Reach, Waypoints, got a DutyCycle; write its .motion": [
        lambda: iv.Scenario(motion=CYCLE, duration=1.0)
    ],
    "motion must be one of Hold, Sinusoid, Reaches, Tremor, Walking, Running, Recording, got a DutyCycle; write its .motion": [
        lambda: iv.DutyCycle(motion=CYCLE)
    ],
    "drive must be a drive, got a str, which has no method operate; write study.drives['cobotic']": [
        lambda: iv.steady_map("cobotic", [0.1], [1.0]),
        lambda: iv.simulate("cobotic", STUDY.scenarios["reach"]),
        lambda: iv.duty_cycle("cobotic", CYCLE),
    ],
    STUDY_WANTED: [
        lambda: iv.compare("hand_controller"),
        lambda: iv.size("hand_controller"),
        lambda: iv.sensitivity("hand_controller", "cobotic", "efficiency"),
        lambda: iv.contact_sheets("hand_controller"),
        lambda: iv.analysis.steering_steps("hand_controller"),
        lambda: iv.analysis.least_loss("hand_controller"),
        lambda: iv.study_session("hand_controller", "path"),
        lambda: iv.save_study("hand_controller", "study.toml"),
        lambda: iv.sweeps.builds_sweep("hand_controller"),
        lambda: iv.sweeps.cobotic_study_sweep("hand_controller", starts=2),
        lambda: iv.sweeps.geared_sweep("hand_controller"),
        lambda: iv.sweeps.sensitivity_sweep("hand_controller", "cobotic", "efficiency"),
        lambda: iv.sweeps.sessions_sweep("hand_controller", "cobotic"),
        lambda: iv.calibrate("hand_controller", "cobotic", "runs.csv"),
        lambda: iv.calibration.calibrate_cobotic("hand_controller", "cobotic", "runs.csv"),
        lambda: iv.calibration.calibrate_geared("hand_controller", "cobotic", "runs.csv"),
    ],
    "study must be a Study, got CoboticDrive(motor=": [lambda: iv.compare(DRIVE)],
    "path must be the path of a file or folder, got a int": [lambda: iv.load_study(5), lambda: iv.load_result(5)],
    "drive must be a drive, got a str, which has no method operate; write study.drives['arm']": [
        lambda: iv.perform_task("arm", TASK),
        lambda: iv.follow_path("arm", PATH),
    ],
    "task must be a MachineTask, got a MachinePath; write follow_path": [lambda: iv.perform_task(MACHINE, PATH)],
    "path must be a MachinePath, got a MachineTask; write perform_task": [lambda: iv.follow_path(MACHINE, TASK)],
}  # fmt: skip


@pytest.mark.parametrize("said", WRONG)
def test_a_value_of_another_kind_is_refused_with_what_to_write(said):
    for call in WRONG[said]:
        with pytest.raises(iv.ParameterError) as refused:
            call()
        assert str(refused.value).startswith(said)


@pytest.mark.parametrize(
    ("call", "hint"),
    [
        (lambda: STUDY.drives["cobotc"], "(did you mean 'cobotic'?); keys: cobotic, cobotic-b, "),
        (lambda: STUDY.scenarios["reech"], "(did you mean 'reach'?); keys: "),
        (lambda: iv.motors()["dcx-32-l-24"], "(did you mean 'dcx-32-l-24v'?); keys: "),
        (lambda: iv.gearheads()["gpx-22-up-3-8"], "(did you mean 'gpx-22-up-3-9'?); keys: "),
        (lambda: DRIVE.operate(speed=0.1, force=10.0).losses["guidway"], "(did you mean 'guideway'?); keys: "),
    ],
)
def test_a_misspelt_key_suggests_the_right_one(call, hint):
    with pytest.raises(KeyError) as missing:
        call()
    assert hint in str(missing.value)
    assert str(pickle.loads(pickle.dumps(missing.value))) == str(missing.value)


def test_a_dictionary_of_a_result_is_still_a_dictionary():
    assert STUDY.drives.get("cobotc") is None
    assert "cobotc" not in STUDY.drives
    with pytest.raises(KeyError, match="3; keys: "):
        STUDY.drives[3]


@pytest.mark.parametrize("name", ["hand_controller", "six_leg_display", "two_joint_arm", "guided_cart", "sphere_joint"])
def test_the_representation_of_a_drive_is_short(name):
    for drive in iv.load_study(name).drives.values():
        assert repr(drive).startswith(f"{type(drive).__name__}(")
        assert len(repr(drive)) < 320
        assert "\n" not in repr(drive)


def test_the_representation_of_a_drive_names_its_parts_and_values():
    assert "gearhead='cylinder gearing, 57:1', " in repr(DRIVE)
    assert "cylinder_speed=14 rad/s, " in repr(DRIVE)
    assert repr(iv.machines.LeggedDrive.of(DRIVE, 6)).startswith("LeggedDrive(motor='DC-max 26 S, 24 V', ")


def test_a_drive_of_a_class():
    assert STUDY.drive("cobotic", iv.CoboticDrive) is DRIVE
    with pytest.raises(iv.InputError, match=r"drives.motor2-gear4 must be a CoboticDrive, got a ConventionalDrive"):
        STUDY.drive("motor2-gear4", iv.CoboticDrive)


TYPED = """
import infinivar as iv
study = iv.load_study("hand_controller")
reveal_type(study.drives["cobotic"])
reveal_type(study.drive("cobotic", iv.CoboticDrive))
reveal_type(study.duty["shake"])
reveal_type(iv.duty_cycle(study.drives["cobotic"], study.duty["shake"]))
iv.steady_map(study.drives["cobotic"], [0.1], [1.0])
"""


@pytest.mark.slow
def test_a_type_checker_knows_what_a_study_holds(tmp_path):
    pytest.importorskip("pyright")
    (tmp_path / "typed.py").write_text(TYPED)
    call = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "--outputjson", str(tmp_path / "typed.py")]
    done = subprocess.run(call, capture_output=True, text=True, timeout=300, check=False)
    found = json.loads(done.stdout)["generalDiagnostics"]
    assert [one["message"] for one in found if one["severity"] == "error"] == []
    assert [one["message"].partition(" is ")[2] for one in found if one["severity"] == "information"] == [
        '"Drive"', '"CoboticDrive"', '"DutyCycle"', '"DutyResult"',
    ]  # fmt: skip
