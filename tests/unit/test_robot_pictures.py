"""Pictures of arms in space: places against Pinocchio, words against the operating point, and how they are painted."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.motion import Pose
from internals import DRAWN_STICK_SPEED as STICK_SPEED
from internals import drawing_answer as drawing
from internals import kinds_figure as kinds
from internals import moving_machine, robot_picture
from internals import pictures_figure as pictures
from internals import recorded_scene as recorded

pin = pytest.importorskip("pinocchio", reason="the extra infinivar[robots] has pin")
PICK = Path(__file__).parents[2] / "studies" / "robots" / "pick_and_place.toml"
LOADS = [
    (np.zeros(6), np.array([0.0, 0.0, 9.81, 0.0, 0.0, 0.0])),
    (np.linspace(0.1, -0.2, 6), np.linspace(-5.0, 8.0, 6)),
]


@pytest.fixture(scope="module")
def study():
    return iv.load_study(PICK)


@pytest.fixture(scope="module")
def drive(study):
    return study.drives["geared-120"]


def shown_at(drive, pose, twist, wrench):
    point = drive.perform(pose=pose, twist=twist, wrench=wrench)
    return point, drive.picture(point, pose, twist, wrench)


def words_of(picture):
    return [one for one in picture.strokes if type(one).__name__ == "Label" and one.words.startswith("joint")]


@pytest.mark.parametrize("moved", [(0.0, 0.0, 0.0), (-0.1, 0.2, 0.1)])
def test_joints_and_tool_are_where_pinocchio_has_them(drive, moved):
    pose = np.add(drive.home, [*moved, 0.0, 0.0, 0.0])
    _, picture = shown_at(drive, pose, *LOADS[0])
    model = pin.buildModelFromUrdf(drive.model)
    data = model.createData()
    pin.framesForwardKinematics(model, data, drive.angles(pose))
    places = [data.oMi[joint].translation for joint in range(1, 7)]
    tool = data.oMf[model.getFrameId("tool", pin.FrameType.BODY)].translation
    # Of a viewer far away, 62 degrees from x towards -y, 24 degrees above the plane.
    around, above = np.radians([-62.0, 24.0])
    right = np.array([-np.sin(around), np.cos(around), 0.0])
    up = np.array([-np.sin(above) * np.cos(around), -np.sin(above) * np.sin(around), np.cos(above)])
    expected = np.array([np.zeros(3), *places, tool]) @ np.stack([right, up], axis=-1)
    (member,) = (one for one in picture.strokes if one.look == "member")
    assert_allclose(member.points, expected, atol=1e-12)
    assert_allclose([one.centre for one in picture.strokes if one.look == "joint"], expected[1:-1], atol=1e-12)
    axes = [one.points for one in picture.strokes if one.look == "axis"]
    turned = [data.oMi[joint].rotation @ axis for joint, axis in zip(range(1, 7), drive.chain.axes, strict=True)]
    for (start, end), axis in zip(axes, np.array(turned) @ np.stack([right, up], axis=-1), strict=True):
        assert_allclose(end - start, 2.0 * 0.08 * drive.chain.reach * axis, atol=1e-12)


@pytest.mark.parametrize("load", range(2))
def test_words_are_those_of_the_operating_point(drive, load):
    point, picture = shown_at(drive, np.array(drive.home), *LOADS[load])
    said = {one.words.partition(": ")[0]: one for one in words_of(picture)}
    assert sorted(said) == sorted(point.parts)
    rows = dict(picture.rows)
    for part, torque in zip(point.parts, point.part_forces, strict=True):
        value, unit = said[part].words.partition(": ")[2].split(" ", 1)
        assert unit == "N m"
        assert float(value) == pytest.approx(float(torque), rel=5e-3, abs=1e-6)
        worst = max(float(demand) for (_, what), demand in point.demands.items() if what == part)
        assert float(said[part].more.split(" %")[0]) == pytest.approx(100.0 * worst, abs=0.51)
        assert rows[part] == f"{value} N m, {said[part].more}"
    keys = dict(picture.keys)
    assert float(re.search(r"load: ([\d.]+) N", keys["force"])[1]) == pytest.approx(
        np.linalg.norm(LOADS[load][1][:3]), rel=5e-3
    )
    velocity = np.linalg.norm(LOADS[load][0][:3])
    assert ("velocity" in keys) == (velocity > 0.0)
    assert velocity == 0.0 or float(keys["velocity"].split()[1]) == pytest.approx(velocity, rel=5e-3)


@pytest.mark.parametrize("load", range(2))
@pytest.mark.parametrize("moved", [(0.0, 0.0, 0.0), (-0.3, 0.2, 0.1), (-0.2, -0.5, -0.2)])
def test_words_neither_meet_nor_leave_the_figure(drive, load, moved):
    _, picture = shown_at(drive, np.add(drive.home, [*moved, 0.0, 0.0, 0.0]), *LOADS[load])
    made = pictures.draw_all(picture)
    made.draw_without_rendering()
    whole = made.bbox
    boxes = [text.get_window_extent() for text in made.axes[0].texts if text.get_text()]
    assert len(boxes) == 6 + 1 + 4 + 1  # joints, payload, axes with scale, gravity
    for place, one in enumerate(boxes):
        assert whole.x0 <= one.x0 < one.x1 <= whole.x1
        assert whole.y0 <= one.y0 < one.y1 <= whole.y1
        assert not any(one.overlaps(other) for other in boxes[:place])


def test_paths_of_the_tool_are_in_the_picture_of_a_report(drive, study):
    pose = np.array(drive.home) + np.outer(np.linspace(0.0, 1.0, 9), [-0.1, 0.2, 0.0, 0.0, 0.0, 0.0])
    _, picture = shown_at(drive, pose[0], *LOADS[0])
    found = robot_picture.traced(picture, drive, {"there": pose, "beyond": pose + 5.0})
    (track,) = (one for one in found.strokes if one.look == "track")
    (member,) = (one for one in picture.strokes if one.look == "member")
    assert_allclose(track.points[0], member.points[-1], atol=1e-9)
    assert_allclose(np.diff(track.points, axis=0), np.broadcast_to(np.diff(track.points, axis=0)[0], (8, 2)), atol=1e-8)
    assert dict(found.keys)["track"] == "path of the tool: there"
    assert robot_picture.traced(picture, drive, {"beyond": pose + 5.0}) is picture
    done = iv.perform_task(drive, study.tasks["wait"])
    ((name, draw, caption),) = kinds.drawings("geared-120", "motor", drive, done)
    assert name == "machine-geared-120"
    assert caption.startswith("motor, task waiting with a part, drawn")
    assert len(draw().axes) == 1


def test_each_stroke_has_a_look_on_the_page_and_a_pose_out_of_reach_says_so(study):
    rules = (Path(iv.__file__).parent / "web" / "page" / "views.css").read_text("utf-8")
    found = drawing.drawing(study, {"drive": "geared-80", "task": "wait"})
    (scene,) = found["scenes"]
    assert {one["look"] for one in scene["items"]} <= set(re.findall(r"\.m\.([a-z-]+)", rules))
    assert {one["look"] for one in scene["keys"]} == {"force", "gravity"}
    far = replace(study.tasks["wait"], pose=Pose(x=3.0), time_share=None)
    beyond = replace(study, tasks={"wait": far}, paths={})
    assert "does not reach" in drawing.drawing(beyond, {"drive": "geared-80", "task": "wait"})["reason"]


@pytest.fixture(scope="module")
def swayed(drive):
    """Pushed by a user."""
    return iv.session(drive.moving(load_mass=1.0, load_inertia=2e-3), user=[60.0, 200.0, -80.0], duration=0.02)


@pytest.mark.slow
def test_the_scene_of_a_robot_in_motion_has_its_places_and_inertia(swayed):
    mujoco = pytest.importorskip("mujoco", reason="the extra infinivar[robots] has it")
    scene = recorded(swayed)
    model = mujoco.MjModel.from_xml_string(scene.scene)
    data = mujoco.MjData(model)
    mechanics = swayed.machine.mechanics(STICK_SPEED)
    for place in (0, len(swayed.time) // 2, -1):
        data.qpos[:] = scene.qpos[place]
        mujoco.mj_forward(model, data)
        assert_allclose(data.site("handle").xpos, scene.parts.handle[place], atol=1e-12)
        full = np.zeros((6, 6))
        for column, unit in enumerate(np.eye(6)):
            mujoco.mj_mulM(model, data, full[column], unit)
        load = mechanics.load.inertia(scene.parts.configuration[[place]], np.zeros((1, 6))).inertia[0]
        assert_allclose(full - np.diag(model.dof_armature), load, atol=1e-6 * np.abs(load).max())


@pytest.mark.slow
def test_frames_of_a_robot_in_motion_show_it_where_it_is(swayed, tmp_path):
    time = np.linspace(0.0, swayed.time[-1], 3)
    numbers = moving_machine.data(swayed, time)
    assert numbers["kind"] == "space"
    low, high = numbers["machine"]["bounds"]
    for place in range(3):
        frame = numbers["frame"](place)
        (member,) = (one for one in frame if one.look == "member")
        assert_allclose(1e3 * member.points[-1], robot_picture.VIEW(numbers["machine"]["handle"][place]), atol=1e-9)
        assert np.all((1e3 * member.points >= low) & (1e3 * member.points <= high))
    assert swayed.save_video(tmp_path / "robot.gif", frame_rate=100.0).stat().st_size > 1000
