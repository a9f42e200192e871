"""What a session says of odd users, controllers and places, and of a session in which nothing happens."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.machines import Commands
from internals import collocation, measures
from machines import HEXAPOD, LEG, REAL_WHEEL, cart
from made import loaded

CART = cart(REAL_WHEEL, steering=replace(LEG.steering, patch_half_length=3e-4))
SLIDE = iv.machines.SlideMachine(leg=LEG, masses=[0.3])
GEARED = iv.machines.GearedSlideMachine(drive=loaded("hand_controller").drives["motor1-gear1"], masses=[0.5])
FLOOR = iv.motion.HalfSpace(point=[0.0, 0.0], direction=[0.0, 1.0])


def guided():
    return iv.session(CART, iv.motion.Caster(), duration=0.02)


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_session_in_which_nothing_happens_is_all_zero(tmp_path):
    run = guided()
    assert run.joules["from user"] == 0.0
    assert not run.lost
    files = iv.save(run, tmp_path / "out")
    assert all(file.stat().st_size for file in files)
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(tmp_path / "out" / "session.nc") as read:
        assert_allclose(read["handle_x_m"], 0.0)


@pytest.mark.parametrize(
    ("machine", "said", "message"),
    [
        (CART, 5, "controller must return Commands, got 5"),
        (CART, None, "controller must return Commands, got None"),
        (CART, Commands(steering=np.full(3, math.nan)), "command steering by 3 finite numbers"),
        (CART, Commands(steering=np.zeros(2)), "command steering by 3 finite numbers"),
        (CART, Commands(steering=np.zeros(3), steering_rate=np.zeros(2)), "command steering_rate by 3 finite numbers"),
        (SLIDE, Commands(speed=math.nan), "command a finite speed, got nan"),
        (SLIDE, Commands(currents=np.array([math.inf])), "command currents by 1 finite numbers"),
        (GEARED, Commands(currents=np.zeros(2)), "command currents by 1 finite numbers"),
    ],
)
def test_what_a_controller_returns_is_checked(machine, said, message):
    with pytest.raises(iv.ParameterError, match=message):
        iv.session(machine, controller=lambda measured: said, duration=0.02)
    late = iter([Commands(), Commands(), said])
    with pytest.raises(iv.ParameterError, match=message):
        iv.session(machine, controller=lambda measured: next(late), duration=0.02)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: iv.session(CART, path=FLOOR, duration=0.02), "path must be a curve"),
        (lambda: iv.session(SLIDE, handle=[0.1, 0.0], duration=0.02), "handle must be left out"),
        (lambda: guided().leak([0.0, 0.0]), "direction must be 2 finite numbers, not all"),
        (lambda: guided().leak([1.0]), "direction must be 2 finite numbers"),
        (lambda: iv.motion.ArmModel(name="me", mass=1.0, damping=1.0, stiffness=1e12), "stiffness must be >= 0 and <= 1e.06 N/m"),
    ],
)  # fmt: skip
def test_odd_arguments_are_named(call, message):
    with pytest.raises(iv.ParameterError, match=message):
        call()


def test_users_whose_functions_go_wrong_are_named():
    with pytest.raises(iv.ParameterError, match=r"user must be finite numbers at each instant, got .*nan.* at 0\.0"):
        iv.session(CART, iv.motion.Caster(), user=lambda time: [1.0 if time < 0.01 else math.nan, 0.0], duration=0.02)
    with pytest.raises(iv.ParameterError, match="user must be as many numbers at each instant"):
        iv.session(CART, iv.motion.Caster(), user=lambda time: [1.0, 0.0][: 2 if time < 0.0104 else 1], duration=0.02)


def test_a_session_that_needs_endless_steps_ends_and_says_why(monkeypatch):
    monkeypatch.setattr(collocation, "CALLS", 40)
    monkeypatch.setattr(collocation, "CALLS_EACH", 0)
    run = iv.session(CART, iv.motion.Caster(), user=[3.0, 1.0], duration=0.1)
    assert not run.complete
    assert "the integration takes too many steps" in run.verdict


def test_leak_without_a_force_is_unknown():
    assert math.isnan(iv.session(CART, iv.motion.Caster(), duration=0.02).leak([1.0, 0.0]))


def test_who_begins_beyond_the_wall_is_told():
    wall = iv.motion.VirtualWall(surface=iv.motion.HalfSpace(point=[0.05, 0.0], direction=[1.0, 0.0]))
    assert "the handle begins 50 mm beyond the wall" in iv.session(CART, wall, duration=0.02).verdict


@pytest.mark.slow
def test_work_at_the_handle_is_what_an_arm_leaves_of_its_own():
    arm = iv.motion.ArmModel(name="me", mass=0.3, damping=8.0, stiffness=200.0)
    run = iv.session(
        SLIDE, iv.motion.Caster(), user=arm, intention=lambda time: [0.02 * math.sin(8.0 * time)], duration=0.2
    )
    kept = run.joules["lost in arm"] + run.joules["stored in arm"]
    assert_allclose(run.handle_work, run.joules["from user"] - kept, rtol=5e-3)
    assert {one.key: one.value for one in measures(run)}["handle_work_J"] == run.handle_work


def test_a_machine_at_rest_has_no_leak_but_one_whose_cylinder_turns_has():
    for stop, leaks in ((True, False), (False, True)):
        run = iv.session(HEXAPOD, iv.motion.HoldingTask(stop_cylinder=stop), user=[10.0, 0.0, 0.0], duration=0.01)
        assert any(one.key.startswith("leak") for one in measures(run)) is leaks


def test_sessions_of_a_study_are_equal_if_their_inputs_are():
    study = iv.load_study("guided_cart")
    short = replace(study, sessions={"path": replace(study.sessions["path"], duration=0.02)})
    assert iv.study_session(short) == iv.study_session(short)
