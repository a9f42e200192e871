"""Scenes for MuJoCo: its kinematics and masses against those of the session, and what it draws."""

import os
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

# Read when MuJoCo is imported: it draws without a display.
os.environ.setdefault("MUJOCO_GL", "egl")
mujoco = pytest.importorskip("mujoco", reason="the extra infinivar[robots] has it")

import infinivar as iv  # noqa: E402
from infinivar import InputError  # noqa: E402
from internals import DRAWN_STICK_SPEED as STICK_SPEED  # noqa: E402
from internals import recorded_scene as recorded  # noqa: E402
from internals import rotation_matrix  # noqa: E402
from internals import scene_in_space as in_space  # noqa: E402
from machine_runs import SHOWN, planar, platform, slide  # noqa: E402
from machines import HEXAPOD  # noqa: E402
from sampled import sampled  # noqa: E402


def loaded(found):
    """Model, data and motion of a session."""
    scene = recorded(found)
    model = mujoco.MjModel.from_xml_string(scene.scene)
    return model, mujoco.MjData(model), scene


def placed(model, data, scene, place):
    data.qpos[:] = scene.qpos[place]
    mujoco.mj_forward(model, data)
    return data


def inertia(model, data):
    """Joint-space inertia by MuJoCo, and the first degree of freedom of each joint."""
    full = np.zeros((model.nv, model.nv))
    for column in range(model.nv):
        unit, product = np.zeros(model.nv), np.zeros(model.nv)
        unit[column] = 1.0
        mujoco.mj_mulM(model, data, product, unit)
        full[:, column] = product
    return full, {model.joint(place).name: model.jnt_dofadr[place] for place in range(model.njnt)}


@sampled("name", [name for name in SHOWN if name != "four axes"], every=4)
def test_the_handle_is_where_the_session_has_it(name):
    found = SHOWN[name]()
    model, data, scene = loaded(found)
    assert scene.qpos.shape == (len(found.time), model.nq)
    handle = in_space(scene.parts.handle)
    if hasattr(found, "position"):
        np.testing.assert_allclose(scene.parts.handle, found.position, atol=1e-15)
    for place in np.linspace(0, len(found.time) - 1, 7).astype(int):
        there = placed(model, data, scene, place).site("handle").xpos
        np.testing.assert_allclose(there, handle[place], atol=1e-12)


@pytest.mark.parametrize("name", ["platform", "geared platform", "run of a platform"])
def test_rods_meet_the_joints_of_the_platform(name):
    found = SHOWN[name]()
    model, data, scene = loaded(found)
    pose = scene.parts.configuration
    for place in np.linspace(0, len(pose) - 1, 5).astype(int):
        placed(model, data, scene, place)
        links = HEXAPOD.platform.at(pose[place, :3], pose[place, 3:]).link_position
        for rod in range(6):
            end, joint = data.site(f"rod_{rod + 1}_end").xpos, data.site(f"joint_{rod + 1}").xpos
            np.testing.assert_allclose(end, joint, atol=1e-12)
            np.testing.assert_allclose(data.body(f"link_{rod + 1}").xpos[2], links[rod], atol=1e-15)


def test_wheels_of_a_platform_roll_along_their_headings():
    """Of the cylinder's surface and the link, a wheel sees the velocity along its heading, but for creep and servo lag."""
    found = platform()
    model, data, scene = loaded(found)
    place = len(found.time) - 1
    placed(model, data, scene, place)
    speed = found.columns["cylinder_speed_rad_s"][place] * 0.05
    pace = scene.parts.configuration[place], scene.parts.configuration[place - 1]
    links = [HEXAPOD.platform.at(one[:3], one[3:]).link_position for one in pace]
    slid = (links[0] - links[1]) / (found.time[place] - found.time[place - 1])
    for wheel in range(6):
        body = data.body(f"wheel_{wheel + 1}")
        frame = body.xmat.reshape(3, 3)
        out = body.xpos * [1, 1, 0] / np.linalg.norm(body.xpos[:2])
        carrier = slid[wheel] * np.array([0, 0, 1.0]) - speed * np.cross([0, 0, 1.0], out)
        across = carrier @ frame[:, 1]
        np.testing.assert_allclose(frame[:, 2], out, atol=1e-12)
        assert abs(across) < 0.01 * speed


def test_wheels_of_a_slide_roll_along_their_headings():
    found = slide(3)
    model, data, scene = loaded(found)
    place = len(found.time) - 1
    placed(model, data, scene, place)
    middle = data.body("cylinder").xpos
    speed = found.columns["cylinder_speed_rad_s"][place] * 0.05
    assert found.velocity[place].min() > 0.01
    for wheel in range(3):
        body = data.body(f"wheel_{wheel + 1}")
        frame = body.xmat.reshape(3, 3)
        out = (body.xpos - middle) * [0, 1, 1]
        out /= np.linalg.norm(out)
        carrier = found.velocity[place, wheel] * np.array([1.0, 0, 0]) - speed * np.cross([1.0, 0, 0], out)
        np.testing.assert_allclose(frame[:, 2], out, atol=1e-12)
        assert abs(carrier @ frame[:, 1]) < 0.2 * found.velocity[place, wheel]


def test_masses_of_a_platform_and_its_links():
    model, data, scene = loaded(platform())
    placed(model, data, scene, 0)
    full, first = inertia(model, data)
    assert model.body("platform").mass[0] == HEXAPOD.mass
    np.testing.assert_allclose(model.body("platform").inertia, HEXAPOD.inertia)
    for rod in range(6):
        assert model.body(f"link_{rod + 1}").mass[0] == HEXAPOD.leg.link_mass
    place = first["cylinder_turning"]
    np.testing.assert_allclose(full[place, place], HEXAPOD.leg.cylinder_inertia)
    steering = HEXAPOD.servo(STICK_SPEED).inertia
    place = first["wheel_1_steering"]
    np.testing.assert_allclose(full[place, place], steering, rtol=1e-6)


def test_rods_with_mass_move_as_in_the_machine():
    """Inertia about the twist, by MuJoCo's Jacobian of the ties between rods and platform."""
    machine = replace(HEXAPOD, rod_mass=0.2)
    found = iv.session(machine, iv.motion.Caster(), user=[5.0, 3.0, 4.0], moment=[0.1, 0.2, -0.1], duration=0.1)
    model, data, scene = loaded(found)
    placed(model, data, scene, -1)
    full, first = inertia(model, data)
    ties = data.efc_J.reshape(-1, model.nv)[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    body = first["platform_pose"] + np.arange(6)
    others = np.setdiff1d(np.arange(model.nv), body)
    pose = np.array([[found.columns[name][-1] for name in machine.mechanics(STICK_SPEED).configuration]])
    twist = np.zeros((model.nv, 6))
    twist[body] = np.eye(6)
    twist[body[3:], 3:] = rotation_matrix(pose[0, 3:]).T  # turning in axes of the body
    twist[others] = np.linalg.lstsq(ties[:, others], -ties @ twist, rcond=None)[0]
    assert np.abs(ties @ twist).max() < 1e-9
    load = machine.mechanics(STICK_SPEED).load
    _, known, _ = load.on_links(pose, np.zeros((1, 6)), machine.leg.link_mass)
    np.testing.assert_allclose(twist.T @ full @ twist, known[0], atol=1e-6 * np.abs(known).max())


def test_masses_of_a_cart():
    cobot = planar().machine.cobot
    model, data, scene = loaded(planar())
    placed(model, data, scene, -1)
    full, first = inertia(model, data)
    body = [first[name] for name in ("x", "y", "angle")]
    expected = np.diag([cobot.mass, cobot.mass, cobot.inertia])
    np.testing.assert_allclose(full[np.ix_(body, body)], expected, atol=1e-12)
    np.testing.assert_allclose(model.body_subtreemass[0], cobot.mass, rtol=1e-14)


@pytest.mark.parametrize(("count", "geared"), [(1, False), (1, True), (2, False), (3, False), (3, True)])
def test_each_axis_of_a_slide_moves_the_mass_of_the_session(count, geared):
    found = slide(count, geared)
    model, data, scene = loaded(found)
    placed(model, data, scene, 0)
    full, first = inertia(model, data)
    mechanics = found.machine.mechanics(STICK_SPEED)
    pose, rates = np.zeros((1, count)), np.zeros((1, len(mechanics.coordinates)))
    expected = np.diagonal(mechanics.at(pose, rates).inertia[0])[:count]
    for axis, name in enumerate(found.axes):
        moved = full[first[f"link_{axis + 1}_sliding"], first[f"link_{axis + 1}_sliding"]]
        if count > 1:
            moved += full[first[f"handle_{name}"], first[f"handle_{name}"]]
        np.testing.assert_allclose(moved, expected[axis], rtol=1e-8)


@pytest.mark.parametrize("name", ["arm", "serial arm", "geared arm"])
def test_inertia_of_an_arm_at_every_pose(name):
    found = SHOWN[name]()
    model, data, scene = loaded(found)
    mechanics = found.machine.mechanics(STICK_SPEED)
    pose = scene.parts.configuration[-1:] + np.linspace(0.3, -0.8, scene.parts.configuration.shape[1])
    data.qpos[:] = pose[0]
    mujoco.mj_forward(model, data)
    full, _ = inertia(model, data)
    count = pose.shape[1]
    expected = mechanics.at(pose, np.zeros((1, len(mechanics.coordinates)))).inertia[0, :count, :count]
    np.testing.assert_allclose(full, expected, atol=1e-12)


def test_files_hold_the_scene_its_motion_and_both_ends(tmp_path):
    found = planar()
    files = found.to_mujoco(tmp_path / "cart.xml")
    assert files == [tmp_path / "cart.xml", tmp_path / "cart.npz"]
    model = mujoco.MjModel.from_xml_path(str(files[0]))
    motion = np.load(files[1])
    assert motion["qpos"].shape == (len(found.time), model.nq)
    np.testing.assert_array_equal(motion["time"], found.time)
    np.testing.assert_array_equal(motion["force"], found.force)
    np.testing.assert_allclose(motion["handle"], found.position, atol=1e-15)
    np.testing.assert_array_equal(model.key("start").qpos, motion["qpos"][0])
    np.testing.assert_array_equal(model.key("end").qpos, motion["qpos"][-1])
    assert model.key("end").time == found.time[-1]


def test_the_page_replays_a_motion(tmp_path, monkeypatch, capsys):
    page = (Path(__file__).parents[2] / "docs" / "sessions.md").read_text("utf-8")
    (code,) = re.findall(r"^```py\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    platform().to_mujoco(tmp_path / "legs.xml")
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "page", "exec"), {})
    off = np.array(capsys.readouterr().out.strip(" []\n").split(), dtype=float)
    np.testing.assert_allclose(off, 0.0, atol=1e-12)


def test_walls_of_all_kinds_are_in_the_scene():
    home = HEXAPOD.home[:3]
    corners = home + np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.01 - 0.03
    surfaces = [
        iv.motion.HalfSpace(point=home - [0, 0, 0.01], direction=[0, 0, 1]),
        iv.motion.Ball(centre=home - [0, 0, 0.05], radius=0.02),
        iv.motion.Tube(point=home + np.array([0.1, 0, 0]), axis=[0, 1, 0], radius=0.05),
        iv.motion.TriangleMesh(vertices=corners, faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    ]
    bare = loaded(iv.session(HEXAPOD, duration=0.002))[0]
    found = iv.session(HEXAPOD, iv.motion.VirtualWall(surface=iv.motion.Surfaces(surfaces=surfaces)), duration=0.002)
    model, data, scene = loaded(found)
    placed(model, data, scene, 0)
    clear = [place for place in range(model.ngeom) if model.geom_rgba[place, 3] < 0.5]
    kinds = sorted(int(model.geom_type[place]) for place in clear)
    geom = mujoco.mjtGeom
    assert kinds == sorted(
        int(one) for one in (geom.mjGEOM_BOX, geom.mjGEOM_SPHERE, geom.mjGEOM_CYLINDER, geom.mjGEOM_MESH)
    )
    assert model.ngeom == bare.ngeom + 4
    # The face of the box is the wall.
    box = next(place for place in clear if model.geom_type[place] == geom.mjGEOM_BOX)
    face = data.geom_xpos[box] + data.geom_xmat[box].reshape(3, 3)[:, 2] * model.geom_size[box, 2]
    np.testing.assert_allclose(surfaces[0].distance(face), 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["cart.txt", "cart"])
def test_a_scene_ends_in_xml(tmp_path, name):
    with pytest.raises(InputError, match=rf"{name}: a scene must end in \.xml"):
        planar().to_mujoco(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_video_by_mujoco_or_a_message_why_not(tmp_path):
    path, said = tmp_path / "legs.gif", ""
    try:
        platform().save_video(path, renderer="mujoco", speed=0.25)
    except InputError as problem:
        said = str(problem)
    if said:
        assert re.search("MUJOCO_GL is .* set MUJOCO_GL to egl or osmesa", said)
        assert list(tmp_path.iterdir()) == []
        return
    with Image.open(path) as image:
        assert image.size == (640, 480)
        assert image.n_frames == 3
        seen = np.asarray(image.convert("RGB")).reshape(-1, 3)
    # The machine stands before a white sky.
    assert 0.05 < np.mean(seen.min(axis=1) < 200) < 0.9


def test_a_machine_that_cannot_draw_says_so(tmp_path, monkeypatch):
    def none(*arguments):
        raise RuntimeError("no display")

    monkeypatch.setattr(mujoco, "Renderer", none)
    with pytest.raises(
        InputError, match=r"MuJoCo cannot draw without a display here .* set MUJOCO_GL to egl or osmesa"
    ):
        planar().save_video(tmp_path / "cart.gif", renderer="mujoco")
    assert list(tmp_path.iterdir()) == []


def test_without_mujoco_the_message_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(InputError, match=r"a video by MuJoCo needs mujoco; .*'infinivar\[robots\]'"):
        planar().save_video(tmp_path / "cart.gif", renderer="mujoco")
    planar().to_mujoco(tmp_path / "cart.xml")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["cart.npz", "cart.xml"]
