"""Paths through waypoints: against reaches, their limits, derivatives, messages, and in a study."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.motion import MachinePath, Pose, Reaches
from internals import study_file
from made import loaded

CYCLE = (Pose(x=0.0), Pose(z=0.05), Pose(x=0.08, angle=0.4), Pose(z=0.0), Pose(z=0.05))
NAMES, HOME = ("x", "z", "angle"), np.zeros(3)
LIMITS = {"speed": 0.5, "acceleration": 2.0, "turning_speed": 1.5, "turning_acceleration": 6.0}


def path(**changes):
    return MachinePath(**({"waypoints": CYCLE} | LIMITS | changes))


@pytest.mark.parametrize("profile", ["minimum-jerk", "smooth"])
@pytest.mark.parametrize("back", [True, False])
def test_two_waypoints_are_a_reach(profile, back):
    """The speed is that at which a reach of 0.7 s is fastest, by its own samples."""
    one = Reaches(distance=0.1, time=0.7, pause=0.2, profile=profile, back=back)
    fastest = np.max(one.derivatives(np.linspace(0.0, 0.7, 2001), 1)[1])
    two = MachinePath(waypoints=(Pose(x=0.0), Pose(x=0.1)), speed=fastest, pause=0.2, profile=profile, back=back)
    expected = MachinePath(x=one).instants(("x",), [0.3])
    for found, known in zip(two.instants(("x",), [0.3]), expected, strict=True):
        assert_allclose(found, known, rtol=1e-9, atol=1e-12)
    assert two.closed is back


@pytest.mark.parametrize("profile", ["minimum-jerk", "smooth", "trapezoid"])
@given(speed=st.floats(0.05, 5.0), acceleration=st.floats(0.1, 50.0))
def test_limits_are_kept_and_one_is_reached_in_each_move(profile, speed, acceleration):
    made = path(profile=profile, speed=speed, acceleration=acceleration, pause=0.1)
    moves = next(iter(made.motions.values())).times
    shares = []
    for place, duration in enumerate(moves):
        begin = sum(moves[:place]) + 0.1 * place
        time = begin + duration * np.append(np.linspace(0.0, 1.0, 1001)[:-1], 1.0 - 1e-9)
        found = made.at(time, NAMES, HOME)
        shares.append(
            [
                np.max(np.linalg.norm(found.twist[:, :2], axis=1)) / speed,
                np.max(np.linalg.norm(found.acceleration[:, :2], axis=1)) / acceleration,
                np.max(np.abs(found.twist[:, 2])) / 1.5,
                np.max(np.abs(found.acceleration[:, 2])) / 6.0,
            ]
        )
    # Samples miss a maximum by less than 1e-4 of it.
    assert np.max(shares) <= 1.0 + 1e-9
    if profile != "trapezoid":
        assert np.min(np.max(shares, axis=1)) >= 1.0 - 1e-4


@pytest.mark.parametrize("profile", ["minimum-jerk", "smooth", "trapezoid"])
def test_every_waypoint_is_visited_and_rates_are_derivatives(profile):
    made = path(profile=profile, pause=0.2)
    moves = np.array(next(iter(made.motions.values())).times)
    ends = np.cumsum(moves + 0.2) - 0.1
    known = [[0.0, 0.05, 0.0], [0.08, 0.05, 0.4], [0.08, 0.0, 0.4], [0.08, 0.05, 0.4], [0.0, 0.0, 0.0]]
    assert_allclose(made.at(ends, NAMES, HOME).pose, known, atol=1e-15)
    time = np.sort(np.random.default_rng(2).uniform(0.01, made.period - 0.01, 400))
    step = 1e-6
    ahead, behind = (made.at(time + sign * step, NAMES, HOME) for sign in (1.0, -1.0))
    assert_allclose(made.at(time, NAMES, HOME).twist, (ahead.pose - behind.pose) / (2.0 * step), atol=1e-5)
    near = made.at(time, NAMES, HOME).acceleration - (ahead.twist - behind.twist) / (2.0 * step)
    assert np.mean(np.abs(near).max(axis=1) > 1e-4) < 0.02  # but where an acceleration jumps


def test_a_trapezoid_takes_the_least_time():
    """Distance over speed and speed over acceleration; a short move has no constant speed."""
    one = {"speed": 0.5, "acceleration": 2.0, "profile": "trapezoid", "back": False}
    far = MachinePath(waypoints=(Pose(x=0.0), Pose(x=0.4)), **one)
    near = MachinePath(waypoints=(Pose(x=0.0), Pose(x=0.02)), **one)
    assert far.period == pytest.approx(0.4 / 0.5 + 0.5 / 2.0)
    assert near.period == pytest.approx(2.0 * np.sqrt(0.02 / 2.0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waypoints": (Pose(x=0.0),)}, "waypoints must be two or more"),
        ({"waypoints": (Pose(x=0.0), Pose(x=0.0), Pose(x=0.1))}, "waypoints 2 is that before it"),
        ({"speed": None}, "speed is missing"),
        ({"turning_speed": None}, "turning_speed is missing"),
        ({"profile": "trapezoid", "acceleration": None}, "acceleration is missing: a trapezoid"),
        ({"x": Reaches(distance=0.1, time=1.0)}, "x and waypoints exclude each other"),
        ({"waypoints": None, "x": Reaches(distance=0.1, time=1.0)}, "speed does not apply without waypoints"),
        ({"profile": "square"}, "profile"),
        ({"speed": -1.0}, "speed must be > 0"),
    ],
)
def test_what_does_not_fit_is_named(changes, message):
    with pytest.raises(iv.ParameterError, match=message):
        path(**changes)


def test_an_arm_visits_waypoints():
    """The same path by waypoints and as a reach gives the same energy."""
    arm = loaded("two_joint_arm").drives["two-motors"]
    reach = Reaches(distance=0.05, time=0.8, pause=0.2, profile="smooth")
    fastest = np.max(reach.derivatives(np.linspace(0.0, 0.8, 2001), 1)[1])
    ways = MachinePath(waypoints=(Pose(x=0.0), Pose(x=0.05)), speed=fastest, pause=0.2, profile="smooth")
    assert iv.follow_path(arm, ways).energy == pytest.approx(iv.follow_path(arm, MachinePath(x=reach)).energy, rel=1e-9)


def test_a_study_keeps_its_waypoints(tmp_path):
    (tmp_path / "visits.toml").write_text(
        study_file(Path("two_joint_arm")).read_text("utf-8").partition("[paths.reach]")[0]
        + '[paths.visits]\ntitle = "visits"\ntime_share = "25 %"\n'
        + 'waypoints = [{ x = "0 mm" }, { y = "20 mm" }, { x = "30 mm" }]\n'
        + 'speed = "0.2 m/s"\nacceleration = "1 m/s^2"\nprofile = "trapezoid"\n'
    )
    study = iv.load_study(tmp_path / "visits.toml")
    known = MachinePath(
        title="visits",
        time_share=0.25,
        waypoints=(Pose(x=0.0), Pose(y=0.02), Pose(x=0.03)),
        speed=0.2,
        acceleration=1.0,
        profile="trapezoid",
    )
    assert study.paths["visits"] == known
    iv.save_study(study, tmp_path / "again.toml")
    assert iv.load_study(tmp_path / "again.toml").paths["visits"] == known
