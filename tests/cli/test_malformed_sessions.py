"""Malformed tasks of sessions: one clear message that names file, field, value and what would be right, exit code 2, no files."""

import numpy as np
import pytest

import session_studies
import solids
from session_studies import tables

LINE = {"shape": "line", "start": ["0 m", "0 m"], "end": ["1 m", "0 m"]}
KINK = {
    "shape": "points",
    "x": ["0 m", "1 m", "2 m", "2 m", "2 m"],
    "y": ["0 m", "0 m", "0 m", "1 m", "2 m"],
}
SPACE = {"shape": "half-space", "point": ["0 m", "0 m", "-50 mm"], "direction": [0, 0, 1]}
ARM = {"type": "arm", "mass": "1 kg", "damping": "5 N s/m", "stiffness": "100 N/m"}
X = {"shape": "constant", "size": "2 N"}

# By task: what is changed, and what the message says after the name of the file.
FAULTS = {
    # task
    "unknown type": (
        "path",
        ("type", "pth"),
        "tasks.path.type = 'pth' must be one of path, wall, fixture, caster, coast, hold (did you mean 'path'?)",
    ),
    "type of a number": ("path", ("type", 3), "tasks.path.type = 3 must be text"),
    "no curve": (
        "path",
        ("curve", None),
        "tasks.path.curve is missing: type = 'path' needs it; write a table [tasks.path.curve]",
    ),
    "curve is a number": ("path", ("curve", 3), "tasks.path.curve = 3 must be a table [tasks.path.curve]"),
    "kink": (
        "path",
        ("curve", KINK),
        "tasks.path.curve.points must lie on a smooth curve, got a kink of 90 degrees at point 3",
    ),
    "one point": ("path", ("curve", {"shape": "points", "x": ["0 m"], "y": ["0 m"]}), "tasks.path.curve"),
    "curve in space": (
        "path",
        ("curve", {"shape": "line", "start": ["0 m", "0 m", "0 m"], "end": ["1 m", "0 m", "0 m"]}),
        "tasks.path.curve must be in 2 dimensions, those in which the handle moves, got one in 3",
    ),
    "curve of other shape": (
        "path",
        ("curve", {"shape": "circle"}),
        "tasks.path.curve.shape = 'circle' must be one of points, line, arc",
    ),
    "unit of a curve": ("path", ("curve", LINE | {"end": ["1 s", "0 m"]}), "has the unit 's' where m is needed"),
    "settling length": ("path", ("settling_length", "0 m"), "tasks.path.settling_length = '0 m' must be > 0 m"),
    "wall of wrong dimension": (
        "wall",
        ("surface", SPACE),
        "tasks.wall.surface must be in 2 dimensions, those in which the handle moves, got one in 3",
    ),
    "normal of zero": (
        "wall",
        ("surface", SPACE | {"direction": [0, 0, 0]}),
        "tasks.wall.surface.direction must be a direction, not zero",
    ),
    "unknown surface": (
        "wall",
        ("surface", {"shape": "cube"}),
        "tasks.wall.surface.shape = 'cube' must be one of half-space, ball, tube, flat walls, mesh",
    ),
    "key of another surface": (
        "wall",
        ("surface", SPACE | {"radius": "1 m"}),
        "tasks.wall.surface.radius does not apply with shape = 'half-space'; remove it",
    ),
    "key of another task": ("wall", ("mass", "3 kg"), "tasks.wall.mass does not apply with type = 'wall'; remove it"),
    "mesh that is not there": (
        "wall",
        ("surface", {"shape": "mesh", "file": "no.stl", "unit": "mm"}),
        "no.stl: no such file",
    ),
    "mesh without unit": (
        "wall",
        ("surface", {"shape": "mesh", "file": "no.stl"}),
        "tasks.wall.surface.unit is missing",
    ),
    "misspelt key": ("free", ("mas", "3 kg"), "tasks.free.mas = '3 kg' is not a known key (did you mean 'mass'?)"),
    "mass of zero": ("free", ("mass", "0 kg"), "tasks.free.mass = '0 kg' must be > 0 kg"),
    # fixtures, with a slide
    "dependent rows": (
        "slide",
        ("allowed", {"shape": "rows", "constraints": [{"x": 1}, {"x": 2}]}),
        "tasks.slide.allowed",
    ),
    "nothing free": (
        "slide",
        ("allowed", {"shape": "rows", "constraints": [{"x": 1}, {"y": 1}]}),
        "tasks.slide.allowed: the fixture leaves nothing free of a machine that moves x, y",
    ),
    "nothing constrained": (
        "slide",
        ("allowed", {"shape": "rows", "constraints": [{"z": 1}]}),
        "tasks.slide.allowed: the fixture constrains nothing of a machine that moves x, y",
    ),
    "fixture of a cart": (
        "slide",
        ("drive", "cart"),
        "tasks.slide.handle_masses does not apply: it is of a drive of one axis; remove it",
    ),
    "no masses": (
        "slide",
        ("handle_masses", None),
        "tasks.slide.handle_masses is missing: drives.slide moves one axis",
    ),
    "four masses": (
        "slide",
        ("handle_masses", ["1 kg"] * 4),
        "tasks.slide.handle_masses must be one to 3 values, got 4 values",
    ),
    "twist of a cylinder": (
        "slide",
        ("twist", {"x": "1 m/s"}),
        "tasks.slide.twist does not apply: a machine with a common cylinder starts at rest; remove it",
    ),
    "axis that the handle lacks": (
        "slide",
        ("user", {"type": "force", "z": X}),
        "tasks.slide.user.z does not apply: the handle of drives.slide moves along x, y only",
    ),
    # user
    "unknown user": ("path", ("user", {"type": "hand"}), "tasks.path.user.type = 'hand' must be one of force, arm"),
    "user without type": (
        "path",
        ("user", {"arm": "vanbeek2015"}),
        "tasks.path.user.type is missing: must be force or arm",
    ),
    "no force": ("path", ("user", {"type": "force"}), "tasks.path.user.x, y or z is missing"),
    "force with a wrong unit": (
        "path",
        ("user", {"type": "force", "x": X | {"size": "2 m"}}),
        "tasks.path.user.x.size = '2 m' has the unit 'm' where N is needed",
    ),
    "moment": (
        "path",
        ("user", {"type": "force", "x": {"shape": "constant", "moment": "1 N m"}}),
        "tasks.path.user.x must be a force along a line: state size",
    ),
    "recording that is not there": (
        "path",
        ("user", {"type": "force", "x": {"shape": "file", "file": "no.csv"}}),
        "no.csv",
    ),
    "arm of zero mass": (
        "path",
        ("user", ARM | {"mass": "0 kg"}),
        "tasks.path.user.mass = '0 kg' must be > 0 and <= 1000 kg",
    ),
    "arm of negative stiffness": (
        "path",
        ("user", ARM | {"stiffness": "-1 N/m"}),
        "tasks.path.user.stiffness = '-1 N/m' must be >= 0 and <= 1e+06 N/m",
    ),
    "arm without damping": (
        "path",
        ("user", {key: value for key, value in ARM.items() if key != "damping"}),
        "tasks.path.user.damping is missing",
    ),
    "unknown arm": (
        "path",
        ("user", {"type": "arm", "arm": "vanbeek2051"}),
        "arm must be one of vanbeek2015, got 'vanbeek2051' (did you mean 'vanbeek2015'?)",
    ),
    "arm named and by values": (
        "path",
        ("user", ARM | {"arm": "vanbeek2015"}),
        "tasks.path.user.mass does not apply beside arm",
    ),
    # sensing and session
    "sampling slower than the servo": (
        "path",
        ("sensing", {"sample_rate": "500 Hz"}),
        "tasks.path.sensing.sample_rate must be at least ten times control.steering_bandwidth, 60 Hz, got 500 Hz",
    ),
    "sampling too slow": (
        "path",
        ("sensing", {"sample_rate": "50 Hz"}),
        "tasks.path.sensing.sample_rate = '50 Hz' must be >= 500 and <= 10000 Hz",
    ),
    "filter beyond Nyquist": (
        "path",
        ("sensing", {"force_filter": "600 Hz"}),
        "tasks.path.sensing.force_filter must be below half of sample_rate, 500 Hz, got 600",
    ),
    "seed": ("path", ("sensing", {"seed": 1.5}), "tasks.path.sensing.seed = 1.5 must be a whole number"),
    "no duration": ("path", ("duration", None), "tasks.path.duration is missing"),
    "duration without unit": ("path", ("duration", 3), "tasks.path.duration = 3"),
    "negative duration": ("path", ("duration", "-1 s"), "tasks.path.duration = '-1 s' must be > 0"),
    "unknown drive": (
        "path",
        ("drive", "crt"),
        "tasks.path.drive = 'crt' is no drive of the study (did you mean 'cart'?)",
    ),
    "setting of another controller": (
        "path",
        ("controller", {"wall_time": "20 ms"}),
        "tasks.path.controller.wall_time does not apply",
    ),
    "pose beyond the machine": (
        "path",
        ("pose", {"z": "1 m"}),
        "tasks.path.pose.z does not apply: drives.cart has x, y, angle only",
    ),
    "load of a cart": (
        "path",
        ("load_mass", "1 kg"),
        "tasks.path.load_mass does not apply: it is of a platform or an arm; remove it",
    ),
}


def refused(infinivar, tmp_path, raw, task, message):
    """Run a session of a malformed study; assert one message, exit code 2, and that nothing is written."""
    (tmp_path / "mine.toml").write_text(session_studies.text(raw), "utf-8")
    before = sorted(tmp_path.iterdir())
    outcome = infinivar("session", tmp_path / "mine.toml", "--task", task, "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (2, "")
    said = outcome.err.replace('"', "'")
    assert said.startswith("infinivar: ")
    assert "mine.toml: " in said
    assert message in said
    assert said.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", FAULTS)
def test_one_clear_message_and_nothing_written(name, infinivar, tmp_path):
    task, (key, value), message = FAULTS[name]
    changes = [(task, key, value)]
    if name == "sampling slower than the servo":
        changes.append(("drives", "cart", "control", {"steering_bandwidth": "60 Hz"}))
    refused(infinivar, tmp_path, tables(*changes, slide=task == "slide"), task, message)


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("mass", "drives.cart.mass is missing: motion needs it"),
        ("inertia", "drives.cart.inertia is missing: motion needs it"),
        ("steering", "drives.cart.steering is missing: motion needs it"),
        ("positions", "drives.cart.positions is missing: a carriage on one wheel does not move in time"),
    ],
)
def test_machines_that_lack_what_motion_needs(key, message, infinivar, tmp_path):
    refused(infinivar, tmp_path, tables(("drives", "cart", key, None)), "path", message)


def test_a_mesh_with_holes(infinivar, tmp_path):
    trimesh = pytest.importorskip("trimesh", reason="the extra infinivar[robots] has it")
    vertices, faces = solids.box((10.0, 20.0, 30.0))
    trimesh.Trimesh(vertices, np.asarray(faces)[1:], process=False).export(tmp_path / "open.stl")
    surface = {"shape": "mesh", "file": "open.stl", "unit": "mm"}
    message = "the mesh must be closed, got 3 open edges, the first from (-0.01, -0.02, -0.03) m"
    refused(infinivar, tmp_path, tables(("wall", "surface", surface)), "wall", message)


@pytest.mark.parametrize(("last", "code"), [(4.0, 2), (0.0, 0)])
def test_a_recorded_force_that_stops_while_it_pushes(infinivar, tmp_path, last, code):
    (tmp_path / "push.csv").write_text(f"time [s],force [N]\n0,0\n0.001,4\n0.002,{last}\n", "utf-8")
    raw = tables(("path", "user", {"type": "force", "x": {"shape": "file", "file": "push.csv"}}))
    (tmp_path / "mine.toml").write_text(session_studies.text(raw), "utf-8")
    outcome = infinivar("check", tmp_path / "mine.toml")
    assert outcome.code == code, outcome.err
    if code:
        assert "tasks.path.user.x: the recording ends at 0.002 s with 4 N, before the session of" in outcome.err


def test_a_task_that_is_not_there(infinivar, tmp_path):
    refused(
        infinivar, tmp_path, tables(), "pth", "task 'pth' is not in the study (did you mean 'path'?); it has tasks.path"
    )


def test_a_steady_task_is_no_session(infinivar, tmp_path):
    raw = tables()
    raw["tasks"]["roll"] = {"twist": {"x": "0.5 m/s"}}
    refused(infinivar, tmp_path, raw, "roll", "tasks.roll is steady, without a user: infinivar compare judges it")


def test_a_study_without_sessions(infinivar, tmp_path):
    raw = tables()
    raw["tasks"] = {"roll": {"twist": {"x": "0.5 m/s"}}}
    refused(
        infinivar, tmp_path, raw, "roll", "the study has no tasks of sessions: add a table [tasks.NAME] with a type"
    )


def test_check_names_every_session_that_cannot_begin(infinivar, tmp_path):
    raw = tables(("path", "drive", "crt"), ("wall", "surface", SPACE))
    (tmp_path / "mine.toml").write_text(session_studies.text(raw), "utf-8")
    outcome = infinivar("check", tmp_path / "mine.toml")
    assert outcome.code == 2
    assert [line.split(": ", 1)[1].split(" ")[0] for line in outcome.err.replace("infinivar: ", "").splitlines()] == [
        "tasks.path.drive",
        "tasks.wall.surface",
    ]
