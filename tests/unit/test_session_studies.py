"""Sessions in studies: tables, checks, saving, and what a session of a study is."""

import importlib
import importlib.util
import json
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
import reference_meshes
from infinivar import study_session
from infinivar.study import SessionTask
from internals import check_sessions, json_schema, measures, session_motion, shipped_studies
from internals import schema_keys as keys
from rendering import rendered
from sampled import sampled
from session_studies import CART, tables, text

RNG_SEED = 30
NAMES = ("guided_cart", "one_axis_display", "tool_on_six_legs")


def test_tables_state_task_user_sensors_and_settings():
    study = iv.Study.from_dict(tables(), name="mine")
    one = study.sessions["path"]
    assert isinstance(one.task, iv.motion.VirtualPath)
    assert (one.title, one.duration, one.sensing.seed) == ("path", 0.02, 3)
    assert one.user == iv.motion.PushingUser(y=iv.motion.ConstantForce(size=2.0))
    assert study.sessions["free"].user.model is iv.motion.ArmModel.named("vanbeek2015")
    assert one.twist.row(("x", "y")).tolist() == [0.3, 0.0]
    assert not study.tasks
    assert "type" in keys(SessionTask)
    check_sessions(study)


@pytest.mark.parametrize("distance", ["50 mm", "1 mm", "10 um", "0.1 um"])
def test_a_motion_that_begins_at_rest_with_hardly_any_energy_takes_few_steps(distance):
    """What is missing in its first moments, over next to nothing, must not shorten all that follow."""
    raw = tables(("free", "user", "x", "distance", distance))
    found = iv.study_session(iv.Study.from_dict(raw, name="mine"), "free")
    assert found.complete, found.verdict
    assert found.closure < 1e-6


def test_a_session_of_a_study_is_that_of_python():
    study = iv.Study.from_dict(tables(), name="mine")
    found = iv.study_session(study, "path")
    one = study.sessions["path"]
    same = iv.session(
        study.drives["cart"].moving(),
        one.task,
        user=lambda time: [0.0, 2.0],
        duration=0.02,
        rates=[0.3, 0.0, 0.0],
        sensing=iv.machines.Sensing(seed=3),
    )
    assert_allclose(found.position, same.position, rtol=0, atol=1e-12)
    assert found.title == "cart, path"
    assert found.closure < 1e-6


def test_the_twist_is_in_fixed_axes():
    study = iv.Study.from_dict(tables(("path", "pose", {"angle": "90 deg"})), name="mine")
    found = iv.study_session(study, "path")
    assert_allclose(found.velocity[0], [0.3, 0.0], atol=1e-12)


def test_an_arm_reaches_from_where_the_handle_is():
    raw = tables(("free", "pose", {"x": "0.1 m"}), ("free", "user", {"type": "arm", "arm": "vanbeek2015"}))
    found = iv.study_session(iv.Study.from_dict(raw, name="mine"), "free")
    assert np.abs(found.force).max() < 1e-6
    assert_allclose(found.position[:, 0], 0.1, atol=1e-9)


def test_saved_studies_load_to_equal_ones(tmp_path):
    study = iv.Study.from_dict(tables(), name="mine")
    assert iv.load_study(iv.save_study(study, tmp_path / "mine.toml")) == study


@pytest.mark.parametrize("name", NAMES)
def test_shipped_sessions_can_begin_and_are_saved(name, tmp_path):
    study = iv.load_study(name)
    check_sessions(study)
    assert iv.load_study(iv.save_study(study, tmp_path / f"{name}.toml")) == study
    known = json_schema()["$defs"]["SessionTask"]["properties"]
    for table in tomllib.loads(shipped_studies()[name].read_text("utf-8"))["tasks"].values():
        assert set(table) <= set(known)
        assert set(table.get("surface", {})) <= set(known["surface"]["properties"])


@sampled("name", NAMES, slow=3)
def test_the_balance_closes_in_every_shipped_session(name):
    study = iv.load_study(name)
    for task in study.sessions:
        for drive in study.drives:
            assert iv.study_session(study, task, drive).closure < 1e-6


def test_recorded_forces_and_meshes_are_files_beside_the_study(tmp_path):
    (tmp_path / "push.csv").write_text("time,force\n0,0\n0.01,5\n0.02,5\n", "utf-8")
    raw = tables(("path", "user", {"type": "force", "x": {"shape": "file", "file": "push.csv"}}))
    (tmp_path / "mine.toml").write_text(text(raw), "utf-8")
    study = iv.load_study(tmp_path / "mine.toml")
    assert study.sessions["path"].user.over_time(("x", "y"))(0.005).tolist() == [2.5, 0.0]
    assert study.sessions["path"].files == {tmp_path / "push.csv": "a recording"}


def test_files_of_sessions_are_saved_from_any_folder(tmp_path, monkeypatch):
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "push.csv").write_text("time,force\n0,0\n0.01,5\n", "utf-8")
    raw = tables(("path", "user", {"type": "force", "x": {"shape": "file", "file": "push.csv"}}), slide=True)
    if importlib.util.find_spec("trimesh") is not None:  # of the extra infinivar[robots]
        trimesh = importlib.import_module("trimesh")
        vertices, faces = reference_meshes.box((10.0, 20.0, 30.0))
        trimesh.Trimesh(vertices, np.asarray(faces), process=False).export(tmp_path / "one" / "block.stl")
        surface = {"shape": "mesh", "file": "block.stl", "unit": "mm"}
        raw["tasks"]["block"] = {"type": "wall", "duration": "3 ms", "handle_masses": ["1 kg"] * 3, "surface": surface}
    (tmp_path / "one" / "mine.toml").write_text(text(raw), "utf-8")
    monkeypatch.chdir(tmp_path)
    study = iv.load_study("one/mine.toml")
    for folder in ("one", "two"):
        assert iv.load_study(iv.save_study(study, f"{folder}/again.toml")) == study


def test_the_schema_knows_tasks_and_users_by_their_types():
    definitions = json_schema()["$defs"]
    task = definitions["SessionTask"]["properties"]
    assert "caster" in str(task["type"])
    assert {"shape", "x", "y", "radius"} <= set(task["curve"]["properties"])
    user = definitions["User"]["properties"]
    assert {"type", "arm", "mass", "x"} <= set(user)
    assert "distance" in user["x"]["properties"]


def test_names_of_sessions_and_steady_tasks_differ():
    study = iv.Study.from_dict(tables(), name="mine")
    with pytest.raises(iv.InputError, match=r"another name than tasks\.path"):
        iv.Study(name="mine", drives=study.drives, tasks={"path": iv.motion.MachineTask()}, sessions=study.sessions)


def test_a_study_of_sessions_alone_is_not_compared():
    with pytest.raises(iv.InputError, match="run with infinivar session"):
        iv.compare(iv.Study.from_dict(tables(), name="mine"))


def test_sessions_beside_steady_tasks_are_left_out_of_a_comparison():
    raw = tables()
    raw["tasks"]["roll"] = {"twist": {"x": "0.5 m/s"}}
    found = iv.compare(iv.Study.from_dict(raw, name="mine"))
    assert list(found.results["cart"].found) == ["tasks.roll"]


def test_measures_follow_from_the_histories():
    leg = iv.load_study("hand_controller").drives["cobotic"]
    machine = iv.machines.SlideMachine(leg=leg, masses=[0.5, 0.5])
    run = iv.session(
        machine,
        iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[1.0, 0.0, 0.0], turning=True)),
        user=[2.0, 5.0],
        duration=0.03,
    )
    found = {one.key: one for one in measures(run)}
    assert_allclose(found["drift_y_mm"].value, 1e3 * (run.position[-1, 1] - run.position[0, 1]))
    assert_allclose(found["leak_y_mm_s_N"].value, 1e3 * run.leak([0.0, 1.0]))
    assert "drift_x_mm" not in found
    assert_allclose(found["electrical_energy_J"].value, run.electrical_energy)
    free = iv.session(machine, iv.motion.Caster(mass=3.0), user=[2.0, 0.0], duration=0.05)
    felt = {one.key: one.value for one in measures(free)}
    assert_allclose(felt["felt_mass_x_kg"], 3.0, rtol=0.05)
    assert "felt_mass_y_kg" not in felt


def test_oblique_constraints_leak_at_an_angle():
    leg = iv.load_study("hand_controller").drives["cobotic"]
    run = iv.session(
        iv.machines.SlideMachine(leg=leg, masses=[0.5] * 3),
        iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[1.0, 1.0, 0.0], turning=True)),
        user=[2.0, 0.0, -5.0],
        duration=0.02,
    )
    found = {one.key: one.value for one in measures(run)}
    across = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    assert_allclose(abs(found["leak_oblique_mm_s_N"]), abs(1e3 * run.leak(across)))
    assert "leak_z_mm_s_N" in found


def test_motion_is_drawn_with_its_wall():
    run = iv.study_session(iv.Study.from_dict(tables(), name="mine"), "wall")
    (plane,) = session_motion.data(run)
    assert plane["axes"] == ["x", "y"]
    assert_allclose(plane["moved"], 1e3 * run.position)
    _, y = np.meshgrid(plane["wall"]["x"], plane["wall"]["y"])
    assert_allclose(plane["wall"]["distance"], y + 50.0, atol=1e-9)
    assert session_motion.draw_all(run) is not None
    slide = iv.machines.SlideMachine(leg=iv.load_study("hand_controller").drives["cobotic"], masses=[0.5])
    assert session_motion.draw_all(iv.session(slide, iv.motion.Caster(), user=[1.0], duration=0.005)) is None


@pytest.mark.slow
def test_report_of_a_session(tmp_path):
    run = iv.study_session(iv.Study.from_dict(tables(), name="mine"), "wall")
    with rendered(("svg",)):
        files = iv.save(run, tmp_path, name="cart-wall")
    assert files[0].name == "cart-wall.html"
    assert all(file.is_file() for file in files)
    page = files[0].read_text("utf-8")
    assert "Motion of the handle" in page
    saved = json.loads((tmp_path / "cart-wall.json").read_text("utf-8"))
    assert saved["task"] == "wall"
    assert saved["measures"]["penetration_mm"] == 0.0
    rows = (tmp_path / "cart-wall.csv").read_text("utf-8").splitlines()
    assert len(rows) == len(run.time) + 1


def test_walls_on_one_axis_are_half_spaces_of_one_coordinate():
    wall = iv.motion.HalfSpace(point=[0.02], direction=[-2.0])
    assert wall.dimension == 1
    assert_allclose(wall.distance(np.array([[0.0], [0.03]])), [0.02, -0.01])
    assert_allclose(wall.normal(np.array([0.0])), [-1.0])
    assert_allclose(wall.hessian(np.array([0.0])), [[0.0]])
    assert CART["type"] == "planar"


def at_a_wall(stiffness, damping):
    """The geared display at a wall of another stiffness [N/mm] and damping [N s/m]."""
    text = shipped_studies()["one_axis_display"].read_text("utf-8")
    text = text.replace('"4 N/mm"', f'"{stiffness} N/mm"').replace('"20 N s/m"', f'"{damping} N s/m"')
    return study_session(iv.Study.from_dict(tomllib.loads(text), name="wall"), "wall", "geared")


WALLS = [
    *((1, 60), (4, 20), (0.5, 200), (20, 0)),
    *(
        (round(20.0 * 40.0**-soft, 3), round(200.0 * damped, 1))
        for soft, damped in np.random.default_rng(RNG_SEED).uniform(size=(20, 2)).tolist()
    ),
]


@sampled(("stiffness", "damping"), WALLS, slow=6)
def test_the_stiffness_rendered_is_that_of_the_wall_whatever_its_damping(stiffness, damping):
    """Damper, inertia, friction and delay of the loop are no part of it; 1 % for the resolution of the encoder."""
    assert at_a_wall(stiffness, damping).rendered_stiffness == pytest.approx(1e3 * stiffness, rel=0.01)


@pytest.mark.slow
def test_a_stiffness_that_the_motion_does_not_show_is_not_stated():
    """Residuals that could hide 5 % of it: here the current of the motor, of which half is random."""
    run = at_a_wall(4, 20)
    words = "stiffness rendered: not determined, as the motion does not separate it from damping"
    assert words not in map(str, measures(run))
    current = run.columns["motor_1_current_A"]
    noise = np.random.default_rng(RNG_SEED).normal(0.0, np.std(current), current.size)
    noisy = replace(run, columns={**run.columns, "motor_1_current_A": current + noise})
    assert math.isnan(noisy.rendered_stiffness)
    assert words in map(str, measures(noisy))
    short = replace(run, wall=iv.motion.HalfSpace(point=[float(np.max(run.position)) - 1e-6], direction=[-1.0]))
    assert np.count_nonzero(short.penetration > 0.0) <= 3
    assert math.isnan(short.rendered_stiffness)
