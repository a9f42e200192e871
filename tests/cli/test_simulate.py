"""`infinivar simulate` and `infinivar graph`: files, exit codes, and every typical mistake in one line."""

import json

import pytest

from folders import results
from sampled import sampled

STUDY = """
[requirement]
base = "faulring2006"

[drives.cobotic]
base = "faulring2006.cobotic"

[drives.geared]
base = "faulring2006.motor2-gear4"

[scenarios.reach]
duration = "0.1 s"
motion = { shape = "reach", distance = "10 mm", time = "0.05 s" }

[scenarios.locked]
duration = "0.05 s"
steering = "locked"
force = { size = "-90 N" }
"""


@pytest.mark.renders("svg")
def test_simulate_writes_report_and_data(infinivar, write, tmp_path):
    outcome = infinivar("simulate", write(STUDY), "--drive", "cobotic", "--scenario", "reach")
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith("Cobotic, Motor 1 (reconstruction A), reach: within limits; position error ")
    names = set(results(tmp_path / "out"))
    assert {"cobotic-reach.html", "cobotic-reach.csv", "cobotic-reach.nc", "cobotic-reach.json"} <= names
    assert "Reconstruction." in (tmp_path / "out" / "cobotic-reach.html").read_text("utf-8")


def test_json_is_printed(infinivar, write):
    outcome = infinivar("simulate", write(STUDY), "--drive", "geared", "--scenario", "reach", "--json")
    content = json.loads(outcome.out)
    assert content["scenario"] == "reach"
    assert content["closure"] < 1e-6


def test_a_limit_exceeded_is_exit_code_1(infinivar, write):
    outcome = infinivar("simulate", write(STUDY), "--drive", "cobotic", "--scenario", "locked")
    assert outcome.code == 1
    assert "limit exceeded: wheel slip (wheel)" in outcome.out
    assert "  wheel slip (wheel) exceeded from 5" in outcome.out  # within the first step, on the way to 90 N


def test_the_load_mass_is_the_requirements(infinivar, write):
    study = STUDY.replace(
        '[requirement]\nbase = "faulring2006"', '[requirement]\nbase = "faulring2006"\nload_mass = "2 kg"'
    )
    arguments = ("--drive", "geared", "--scenario", "reach", "--json")
    light, heavy = (json.loads(infinivar("simulate", write(text), *arguments).out) for text in (STUDY, study))
    assert heavy["lost_J"]["winding"] > light["lost_J"]["winding"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--drive", "cobotics", "--scenario", "reach"], "'cobotics' is not in the study (did you mean 'cobotic'?)"),
        (["--drive", "cobotic", "--scenario", "rech"], "'rech' is not in the study (did you mean 'reach'?)"),
        (
            ["--drive", "geared", "--scenario", "locked"],
            "drives.geared, scenarios.locked: steering = 'locked' requires a cobotic",
        ),
    ],
)
def test_names_that_are_not_there(infinivar, write, tmp_path, arguments, said):
    refused(infinivar("simulate", write(STUDY), *arguments), said, tmp_path)


def refused(outcome, said, folder):
    assert outcome.code == 2, outcome.out
    assert said in outcome.err
    assert len(outcome.err.strip().splitlines()) == 1
    assert not (folder / "out").exists()


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('duration = "1 m"', "scenarios.x.duration = \"1 m\" has the unit 'm' where s is needed"),
        ("", "scenarios.x.duration is missing"),
        (
            'duration = "1 s"\nlink = "fre"',
            'scenarios.x.link = "fre" must be one of controlled, imposed, free (did you',
        ),
        ('duration = "1 s"\nmotions = 1', "scenarios.x.motions = 1 is not a known key (did you mean 'motion'?)"),
        (
            'duration = "1 s"\nmotion = { shape = "sinusoid", frequency = "3 Hz" }',
            "scenarios.x.motion.distance is missing: give distance, or angle about a joint",
        ),
        (
            'duration = "1 s"\nmotion = { shape = "hold", distance = "1 mm" }',
            "scenarios.x.motion.distance does not apply with shape = 'hold'",
        ),
        (
            'duration = "1 s"\nsteering = "held"',
            "scenarios.x.steering_angle is missing: steering = 'held' needs it",
        ),
        (
            'duration = "1 s"\nsteering_angle = "10 deg"',
            "scenarios.x.steering_angle does not apply with steering = 'controlled'; remove it",
        ),
        ('duration = "1 s"\ncylinder = "run-up"', "scenarios.x.run_up_time is missing: cylinder = 'run-up' needs it"),
        ('duration = "1 s"\nlink = "free"\nmotion = { shape = "hold" }', "scenarios.x.motion does not apply with link"),
        (
            'duration = "1 s"\nlink = "imposed"\nmotion = { shape = "step", distance = "1 mm" }',
            "motion.shape = 'step' cannot be imposed",
        ),
        (
            'duration = "1 s"\nlink = "imposed"\nmotion = { shape = "cruise", speed = "0.1 m/s", start = "0.2 s" }',
            "scenarios.x.motion.start must be 0 s for an imposed cruise",
        ),
        ('duration = "1 s"\nmotion = { shape = "file", file = "gone.csv" }', "gone.csv: no such file"),
        (
            'duration = "1 s"\nmotion = { shape = "sinusoid", distance = "1 mm", frequency = "3 rad/s" }',
            "must count cycles",
        ),
        (
            'duration = "1 s"\ncylinder = "at rest"',
            "scenarios.x.steering must be locked, decoupled or held with cylinder = 'at rest'",
        ),
        ('duration = "1 s"\ntolerance = 0.1', "scenarios.x.tolerance = 0.1 must be > 0 and <= 1e-3"),
        (
            'base = "faulring2006.shak"',
            "'faulring2006.shak' is not a shipped scenario (did you mean 'faulring2006.shake'?)",
        ),
    ],
)
def test_mistakes_in_a_scenario(infinivar, write, tmp_path, table, said):
    study = f"{STUDY}\n[scenarios.x]\n{table}\n"
    refused(infinivar("simulate", write(study), "--drive", "cobotic", "--scenario", "x"), said, tmp_path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "line 1: must name the columns, but the file is empty"),
        (
            "time,place\n0,1\n1,2\n",
            "line 1: must name a column of position or angle; found 'time' as time; other headings: 'place'",
        ),
        ("time,position\n0,0\n", "line 1, column 'time': must have at least two rows of numbers below, got 1"),
        ("time,position\n0,0\n0.1,x\n", "line 3, column 'position': must be a finite number, got 'x'"),
        ("time,position\n0,0\n0.1,nan\n", "line 3, column 'position': must be a finite number, got 'nan'"),
        ("time,position\n0,0\n0.1,1\n0.1,2\n", "line 4, column 'time': must have a later time"),
    ],
)
def test_mistakes_in_a_csv_file(infinivar, write, tmp_path, text, said):
    (tmp_path / "motion.csv").write_text(text, "utf-8")
    study = f'{STUDY}\n[scenarios.x]\nduration = "0.1 s"\nmotion = {{ shape = "file", file = "motion.csv" }}\n'
    outcome = infinivar("simulate", write(study), "--drive", "geared", "--scenario", "x")
    refused(outcome, said, tmp_path)
    assert "motion.csv" in outcome.err


def test_motion_and_force_from_files(infinivar, write, tmp_path):
    """Files lie beside the study, wherever the command is given."""
    (tmp_path / "motion.csv").write_text("time,position\n0,0\n0.05,0.002\n0.1,0\n", "utf-8")
    (tmp_path / "force.csv").write_text("Force , time\n0,0\n5,0.05\n0,0.1\n", "utf-8")
    study = f"""{STUDY}
[scenarios.x]
duration = "0.1 s"
motion = {{ shape = "file", file = "motion.csv" }}
force = {{ shape = "file", file = "force.csv" }}
"""
    path = tmp_path / write(study)
    (tmp_path / "elsewhere").mkdir()
    outcome = infinivar("simulate", path, "--drive", "geared", "--scenario", "x", "--out", "elsewhere")
    assert outcome.code == 0, outcome.err


def test_a_drive_without_an_inertia_is_refused(infinivar, write, tmp_path):
    study = STUDY.replace('base = "faulring2006.motor2-gear4"', 'base = "faulring2006.motor2-gear4"\nmotor = { %s }')
    motor = 'voltage = "24 V", resistance = "1 ohm", torque_constant = "20 mN m/A", no_load_current = "50 mA", '
    outcome = infinivar(
        "simulate",
        write(study.replace("%s", motor + 'continuous_torque = "30 mN m", part = "none"')),
        "--drive",
        "geared",
        "--scenario",
        "reach",
    )
    assert outcome.code == 2  # no such part: one line, as ever
    bare = STUDY.replace(
        '[drives.geared]\nbase = "faulring2006.motor2-gear4"',
        f"""[drives.geared]
type = "conventional"
motor = {{ {motor} continuous_torque = "30 mN m" }}
gearhead = {{ ratio = 5, efficiency = 0.9 }}
pulley = {{ radius = "8 mm" }}""",
    )
    outcome = infinivar("simulate", write(bare), "--drive", "geared", "--scenario", "reach")
    refused(outcome, "motor.rotor_inertia is missing: motion needs it", tmp_path)


@sampled("plant", ["system", "lossless", "transmission", "steering", "cylinder", "link"], every=2)
@pytest.mark.renders("svg")
def test_graph_draws_every_plant(infinivar, write, tmp_path, plant):
    outcome = infinivar("graph", write(STUDY), "cobotic", "--plant", plant, "--out", "fig.svg")
    assert outcome.code == 0, outcome.err
    assert (tmp_path / "fig.svg").read_text("utf-8").startswith("<?xml")


@pytest.mark.slow
@pytest.mark.renders("png", "pdf")
def test_graph_writes_equations(infinivar, write, tmp_path):
    outcome = infinivar("graph", write(STUDY), "geared", "--out", "fig14.pdf", "--equations", "fig14.tex")
    assert outcome.out == "Wrote fig14.pdf, fig14.tex\n"
    assert r"\frac{d}{dt} \dot{l} &=" in (tmp_path / "fig14.tex").read_text("utf-8")
    infinivar(
        "graph", write(STUDY), "cobotic", "--out", "fig10.png", "--equations", "fig10.txt", "--electrical", "voltage"
    )
    assert "steering.L" in (tmp_path / "fig10.txt").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["cobotic", "--out", "fig.gif"], "--out fig.gif: must end in .png, .svg, .pdf"),
        (["cobotic", "--equations", "eq.doc"], "--equations eq.doc: must end in .tex or .txt"),
        (["cobotic", "--plant", "wheel"], "drives.cobotic: plant must be one of system, lossless"),
        (["geared", "--plant", "steering"], "drives.geared: plant must be one of system, got 'steering'"),
        (["cobotic", "--electrical", "amps"], "electrical must be current or voltage, got 'amps'"),
        (["gered"], "drive 'gered' is not in the study (did you mean 'geared'?)"),
    ],
)
def test_mistakes_with_graph(infinivar, write, tmp_path, arguments, said):
    outcome = infinivar("graph", write(STUDY), *arguments)
    assert outcome.code == 2, outcome.out
    assert said in outcome.err
    assert {file.name for file in tmp_path.iterdir()} == {"study.toml"}


@pytest.mark.slow
def test_first_drive_and_scenario_unless_named(infinivar, write):
    """A line on stderr says which is taken; where there is only one, the result names it."""
    said = "infinivar: no --{} given: using {}, the first of {}\n"
    outcome = infinivar("simulate", write(STUDY))
    assert outcome.err == said.format("drive", "cobotic", "cobotic, geared") + said.format(
        "scenario", "reach", "reach, locked"
    )
    assert outcome.out == infinivar("simulate", "study.toml", "--drive", "cobotic", "--scenario", "reach").out
