"""Messages about parts, motions and benches: they name the field, and what would be right."""

import numpy as np
import pytest

import infinivar as iv
import plugin_package
from internals import read_dynamometer

HEAD = """
[requirement]
force = "200 N"
speed = "0.1 m/s"
[drives.lift]
type = "conventional"
motor = { part = "dcx-32-l-24v" }
gearhead = { part = "gpx-32-up-3-9" }
"""
SCREW = """[drives.lift.screw]
lead = "5 mm"
diameter = "16 mm"
"""
DUTY = """[duty.d]
shape = "sinusoid"
distance = "20 mm"
frequency = "0.5 Hz"
load_mass = "5 kg"
"""


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("", r"drives\.lift\.screw\.friction_coefficient is missing: state the friction of the thread as one of"),
        (
            'efficiency = 0.9\nends = "fixed-fixed"\n',
            r"drives\.lift\.screw\.ends does not apply without length and root_diameter",
        ),
        ('efficiency = 0.9\nyield_strength = "400 MPa"\n', r"screw\.yield_strength does not apply without length"),
    ],
)
def test_faults_of_a_screw_in_a_study(load, lines, words):
    with pytest.raises(iv.InputError, match=words):
        load(HEAD + SCREW + lines)


def test_a_self_locking_screw_behind_an_elastic_gear_needs_an_inertia():
    drive = iv.ConventionalDrive(
        motor=iv.motors()["dcx-32-l-24v"],
        gearhead=iv.parts.Gearhead(ratio=5.0, efficiency=0.9, stiffness=400.0),
        screw=iv.parts.Screw(lead=0.01, diameter=0.016, friction_coefficient=0.22),
    )
    scenario = iv.Scenario(duration=0.05, load_mass=0.5, motion=iv.motion.Sinusoid(distance=0.01, frequency=1.0))
    with pytest.raises(iv.ParameterError, match=r"^output_inertia (must be > 0 kg m\^2|is missing)"):
        iv.simulate(drive, scenario)


MOTIONS = """[infinivar.motions]
two-tones = {0}:TwoTones
faulty = math:sin
"""


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ("two-tone", r"must be one of hold, .*two-tones.*\(did you mean 'two-tones'\?\)$"),
        ("faulty", r"the motion 'faulty'"),
    ],
)
def test_words_of_packages_for_motions(tmp_path, monkeypatch, load, shape, words):
    folder = tmp_path / "site"
    folder.mkdir()
    plugin_package.install(folder, monkeypatch, MOTIONS, package="nearlab")
    duty = DUTY.replace("sinusoid", shape)
    with pytest.raises(iv.InputError, match=words) as caught:
        load(f"{HEAD}{SCREW}efficiency = 0.9\n{duty}")
    assert len(str(caught.value).splitlines()) == 1


def test_headings_of_a_bench_may_have_blanks(tmp_path):
    file = tmp_path / "bench.csv"
    file.write_text("motor speed (rpm),torque (N m),current (mA)\n600,1,500\n1200,1,510\n", "utf-8")
    found = read_dynamometer(file, 20.0)
    np.testing.assert_allclose(found.speed, np.array([600.0, 1200.0]) * np.pi / 30.0 / 20.0)
    file.write_text("velocity (rpm),torque (N m),current (mA)\n600,1,500\n1200,1,510\n", "utf-8")
    with pytest.raises(iv.InputError, match="speed or motor_speed; neither is among those read: torque, current"):
        read_dynamometer(file, 20.0)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("1,2\n3,4\n", "torque or motor_torque; neither is among those read: none"),
        ("1,2\n", "line 1, column 'a': must have at least two rows of numbers below, got 1"),
        ("1\n2\n", "line 2, column 'b': has no cell: line 1 has 2 headings, this line 1 cell"),
    ],
)
def test_a_bench_without_any_known_column_says_so(tmp_path, rows, words):
    file = tmp_path / "bench.csv"
    file.write_text(f"a,b\n{rows}", "utf-8")
    with pytest.raises(iv.InputError, match=words):
        read_dynamometer(file, 20.0)


class Strong:
    """A drive without limits."""

    def operate(self, *, speed, force):
        out = force * speed
        losses = {"brake": np.maximum(-out, 0.0)}
        return iv.drivetrain.DrivePoint(
            power_in=np.maximum(out, 0.0), power_out=out, losses=losses, utilisation={}, states={}
        )


def test_a_drive_without_limits_says_so():
    study = iv.Study(name="m", requirement=iv.Requirement(force=40.0, speed=0.5), drives={"strong": Strong()})
    verdict = iv.compare(study, quick=True).results["strong"].verdict
    assert verdict == "covers 100 % of the required region; no limit is loaded"


def test_no_energy_is_stated_where_a_spring_would_have_to_pull(load):
    spring = '[drives.lift.output.series_spring]\nshape = "one-sided"\nstiffness = "30 N/mm"\n'
    study = load(f"{HEAD}{SCREW}efficiency = 0.9\n{spring}{DUTY}")
    found = iv.duty_cycle(study.drives["lift"], study.duty["d"])
    assert not found.feasible
    assert found.verdict == "infeasible: series spring: spring travel, 1.33 times the allowance"
    assert np.isnan(found.energy)
    pushed = iv.DutyCycle(motion=study.duty["d"].motion, load_mass=5.0, force=-80.0)
    assert iv.duty_cycle(study.drives["lift"], pushed).energy > 0.0
    steady = iv.steady_map(study.drives["lift"], [0.05], [-100.0, 100.0])
    assert np.isnan(steady.power_in).ravel().tolist() == [True, False]
