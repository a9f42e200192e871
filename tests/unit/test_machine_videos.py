"""Machines in motion: where their parts are drawn, frames in real time, and files of them."""

import math

import numpy as np
import pytest
from matplotlib.animation import FuncAnimation
from PIL import Image

import infinivar as iv
from infinivar import InputError, ParameterError
from internals import LineGuideShape as Line
from internals import PlaneGuideShape as Plane
from internals import RodGuideShape as Rod
from internals import RoundGuideShape as Round
from internals import SolidGuideShape as Solid
from internals import TrackGuideShape as Track
from internals import guides_of, moving_machine, parts_of, video
from machine_runs import SHOWN, planar, platform, run, slide
from machines import HEXAPOD, MACHINES
from sampled import sampled


def test_a_cart_is_drawn_where_it_is():
    found = planar()
    numbers = moving_machine.data(found, moving_machine.instants(found, speed=0.25))
    strokes, last = numbers["frame"](len(numbers["time"]) - 1), numbers["time"][-1]
    assert last == found.time[-1]
    x, y, angle = (found.columns[name][-1] for name in ("x_m", "y_m", "angle_rad"))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    spots = np.array(found.machine.cobot.positions) @ turn.T + [x, y]
    wheels = [one.points for one in strokes if one.look.startswith("wheel")]
    np.testing.assert_allclose(np.mean(wheels, axis=1), spots, atol=1e-12)
    # A wheel is drawn along its heading, which turns with the body.
    heading = angle + found.columns["h_2_rad"][-1]
    half = 0.5 * (wheels[1][0] + wheels[1][1]) - spots[1]
    np.testing.assert_allclose(half, 0.02 * np.array([math.cos(heading), math.sin(heading)]), atol=1e-12)
    np.testing.assert_allclose(1e-3 * numbers["plane"]["handle"][-1], found.position[-1], atol=1e-12)
    np.testing.assert_allclose(numbers["force"], math.hypot(4.0, 6.0))


def test_rods_keep_their_length_and_meet_the_platform():
    found = platform()
    parts = parts_of(found)
    rods = parts.outline.rods(parts.configuration)
    np.testing.assert_allclose(np.linalg.norm(rods.upper - rods.lower, axis=-1), 0.14, rtol=1e-12)
    there = HEXAPOD.platform.at(parts.configuration[:, :3], parts.configuration[:, 3:])
    np.testing.assert_allclose(rods.link_position, there.link_position, atol=1e-15)
    np.testing.assert_allclose(parts.link_positions, there.link_position, atol=1e-15)
    np.testing.assert_allclose(parts.handle, found.position, atol=0.0)


def test_members_of_an_arm_end_where_its_end_point_is():
    found = run("arm")
    frame = moving_machine.data(found, found.time)["frame"]
    members = [next(one.points for one in frame(place) if one.look == "member") for place in range(len(found.time))]
    ends = found.machine.arm.end_point(parts_of(found).configuration)[:, :2]
    np.testing.assert_allclose(np.array(members)[:, -1], ends, atol=1e-15)
    assert parts_of(found).force is None


def test_a_cylinder_turns_as_far_as_its_speed_says():
    found = slide(1)
    angle = parts_of(found).cylinder_angle
    assert angle[0] == 0.0
    np.testing.assert_allclose(angle, found.columns["cylinder_speed_rad_s"].mean() * found.time, rtol=0.05, atol=1e-6)
    assert parts_of(slide(1, geared=True)).cylinder_angle is None


def test_instants_are_in_real_time_and_end_with_the_session():
    found = planar()
    time = moving_machine.instants(found, speed=0.1, frame_rate=25.0)
    np.testing.assert_allclose(np.diff(time)[:-1], 0.004)
    assert (time[0], time[-1]) == (0.0, found.time[-1])
    assert len(moving_machine.instants(found, speed=100.0)) == 2


@sampled("name", SHOWN, every=5)
def test_every_machine_is_drawn(name):
    found = SHOWN[name]()
    film = moving_machine.film(found, speed=10.0)
    film.show(len(film.time) - 1)
    film.figure.draw_without_rendering()
    renderer = film.figure.canvas.get_renderer() if hasattr(film.figure.canvas, "get_renderer") else None
    box = film.figure.bbox
    for ax in film.figure.axes:
        if ax.axison:
            assert ax.get_xlabel().endswith("]")
            assert ax.get_ylabel().endswith("]")
            for label in (ax.xaxis.label, ax.yaxis.label):
                here = label.get_window_extent(renderer)
                assert here.x0 >= box.x0
                assert here.x1 <= box.x1
                assert here.y0 >= box.y0


@pytest.mark.slow
def test_an_animation_is_one_of_matplotlib(tmp_path):
    made = planar().animation(speed=0.5)
    assert isinstance(made, FuncAnimation)
    made.save(tmp_path / "cart.gif", writer="pillow")
    with Image.open(tmp_path / "cart.gif") as image:
        assert image.n_frames == len(moving_machine.instants(planar(), speed=0.5))


@pytest.mark.slow
def test_a_gif_lasts_as_long_as_the_session_times_its_slowness(tmp_path):
    written = planar().save_video(tmp_path / "cart.gif", speed=0.2, frame_rate=20.0)
    assert written == tmp_path / "cart.gif"
    with Image.open(written) as image:
        lasted = 0.0
        for place in range(image.n_frames):
            image.seek(place)
            lasted += image.info["duration"]
    # The last frame is shown once, too.
    assert lasted == pytest.approx(1e3 * 0.03 / 0.2 + 50.0)
    assert [file.name for file in tmp_path.iterdir()] == ["cart.gif"]


@pytest.mark.slow
def test_an_mp4_has_the_frames_and_their_rate(tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the extra infinivar[robots] has it")
    shares = []
    written = planar().save_video(tmp_path / "cart.mp4", speed=0.25, frame_rate=30.0, progress=shares.append)
    frames, seconds = ffmpeg.count_frames_and_secs(str(written))
    assert frames == len(shares) == 5
    assert seconds == pytest.approx(5 / 30.0, abs=0.02)
    assert shares[-1] == 1.0


BAD = [
    ({"path": "cart.avi"}, r"cart\.avi: a video must end in \.gif or \.mp4"),
    ({"path": "cart"}, r"cart: a video must end in \.gif or \.mp4"),
    ({"speed": 0.0}, "speed must be > 0, got 0"),
    ({"speed": math.nan}, "speed must be > 0, got nan"),
    ({"speed": 1e-6}, "are 7.5e[+]05 frames, over 5000: raise speed, or lower frame_rate"),
    ({"frame_rate": -1.0}, "frame_rate must be > 0"),
    ({"frame_rate": 30.0}, "frame_rate must be 100 over a whole number for a GIF file"),
    ({"renderer": "povray"}, "renderer must be drawing or mujoco, got 'povray'"),
]


@pytest.mark.parametrize(("given", "message"), BAD)
def test_what_is_no_video_is_refused(tmp_path, given, message):
    options = dict(given)
    path = tmp_path / options.pop("path", "cart.gif")
    with pytest.raises(InputError, match=message):
        planar().save_video(path, **options)
    assert list(tmp_path.iterdir()) == []


def test_an_mp4_without_ffmpeg_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "_ffmpeg", lambda: None)
    with pytest.raises(InputError, match=r"needs ffmpeg, which is not found: install it, .* or write a \.gif file"):
        planar().save_video(tmp_path / "cart.mp4")
    assert list(tmp_path.iterdir()) == []


def test_an_ffmpeg_that_fails_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "_ffmpeg", lambda: "false")
    with pytest.raises(InputError, match="ffmpeg failed"):
        planar().save_video(tmp_path / "cart.mp4")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cart.gif", "cart.mp4"])
def test_a_video_that_is_stopped_leaves_nothing(tmp_path, monkeypatch, name):
    if name.endswith("mp4"):
        pytest.importorskip("imageio_ffmpeg", reason="the extra infinivar[robots] has it")

    def stop(share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        planar().save_video(tmp_path / name, speed=0.25, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_a_sphere_has_no_handle_to_show(tmp_path):
    machine, given = MACHINES["sphere"]
    found = iv.simulate_machine(machine, iv.motion.MachineScenario(**{**given, "duration": 0.01}))
    with pytest.raises(InputError, match="a SphereMachine is not drawn in motion: only planar cobots, slides"):
        found.save_video(tmp_path / "sphere.gif")
    with pytest.raises(InputError, match="a SphereMachine is not drawn in motion"):
        found.to_mujoco(tmp_path / "sphere.xml")
    assert list(tmp_path.iterdir()) == []


def _guided(task):
    return guides_of(iv.session(HEXAPOD, task, duration=0.002))


def test_shapes_of_what_guides():
    (plane,) = guides_of(platform())
    assert isinstance(plane, Plane)
    assert not plane.solid
    np.testing.assert_allclose(plane.point, platform().position[0])
    (track,) = guides_of(planar())
    assert isinstance(track, Track)
    assert track.points.shape == (121, 3)
    (wall,) = guides_of(slide(1))
    assert (wall.upright, wall.solid, wall.point[0], wall.normal[0]) == (True, True, 0.001, -1.0)
    home = HEXAPOD.home[:3]
    ball, tube = (
        iv.motion.Ball(centre=home - [0.0, 0.0, 0.05], radius=0.02),
        iv.motion.Tube(point=home, axis=[0, 0, 2], radius=0.05, free="inside"),
    )
    both = _guided(iv.motion.VirtualWall(surface=iv.motion.Surfaces(surfaces=[ball, tube])))
    assert [type(one) for one in both] == [Round, Rod]
    np.testing.assert_allclose(both[1].axis, [0, 0, 1])
    assert [type(one) for one in _guided(iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[1, 0, 0])))] == [Line]
    assert guides_of(run("arm")) == ()
    about = iv.motion.Fixture(allowed=iv.motion.AboutPoint(point=[0.0, -0.1]))
    turned = iv.session(planar().machine, about, duration=0.002)
    (circle,) = guides_of(turned)
    np.testing.assert_allclose(np.linalg.norm(circle.points - [0.0, -0.1, 0.0], axis=1), 0.1)
    (drawn,) = moving_machine.data(turned, turned.time)["plane"]["lines"]
    np.testing.assert_allclose(drawn, 1e3 * circle.points[:, :2])
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.01
    mesh = iv.motion.TriangleMesh(vertices=corners, faces=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert [type(one) for one in _guided(iv.motion.VirtualWall(surface=mesh))] == [Solid]


@pytest.mark.parametrize("name", ["planar", "platform", "three axes", "geared arm"])
def test_the_arrow_of_the_force_is_within_the_drawing(name):
    found = SHOWN[name]()
    plane = moving_machine.data(found, found.time)["plane"]
    tails, (low, high) = plane["handle"] - plane["push"], plane["bounds"]
    assert np.all(tails > low)
    assert np.all(tails < high)
    pair = [found.axes.index(axis) for axis in plane["axes"]]
    force = found.force[:, pair]
    across = plane["push"][:, 0] * force[:, 1] - plane["push"][:, 1] * force[:, 0]
    np.testing.assert_allclose(across, 0.0, atol=1e-9)


def test_a_run_without_a_user_has_no_force():
    numbers = moving_machine.data(run("planar"), run("planar").time[:2])
    assert numbers["force"] is None


def test_an_animation_has_a_speed():
    with pytest.raises(ParameterError, match="speed"):
        planar().animation(speed=-1.0)
