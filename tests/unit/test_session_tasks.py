"""Tasks as sessions: each kind finds its controller, and what it promises is measured."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from internals import SETTLING_LENGTH, controller_of
from internals import session_figure as figure
from machines import HEXAPOD, LEG, MACHINES, REAL_WHEEL, cart
from made import loaded

CART = cart(REAL_WHEEL, steering=replace(LEG.steering, patch_half_length=3e-4))
COBOTIC = iv.machines.SlideMachine(leg=LEG, masses=[0.5] * 3)
GEARED = iv.machines.GearedSlideMachine(drive=loaded("hand_controller").drives["motor1-gear1"], masses=[0.5] * 3)
ARM = iv.motion.ArmModel.named("vanbeek2015")
LINE = iv.motion.LineCurve(start=[0.0, 0.0, 0.0], end=[0.1, 0.1, 0.0])
FLOOR = iv.motion.HalfSpace(point=[0.0, 0.0, -0.0005], direction=[0.0, 0.0, 1.0])


def down(time):
    return [0.1 * math.sin(6.0 * time), 0.05 * math.sin(5.0 * time), -0.05]


def felt(machine, task, duration=0.1, **given):
    return iv.session(machine, task, user=ARM, intention=down, duration=duration, output_step=0.005, **given)


@pytest.mark.slow
def test_path_in_the_plane_is_followed_both_ways_with_the_settling_length():
    curve = iv.motion.PointCurve.through(np.array([[0.0, 0.0], [0.1, 0.05], [0.25, 0.0], [0.4, 0.1]]))
    tangent = np.asarray(curve.at(0.0)[1])
    task = iv.motion.VirtualPath(curve=curve, settling_length=0.02)
    assert controller_of(task, CART).k1 == pytest.approx(2500.0)
    run = iv.session(CART, task, user=[3.0, 0.0], duration=0.3, rates=[*(0.4 * tangent), 0.0], output_step=0.01)
    assert np.abs(run.path_offset).max() < 4e-4
    assert run.feasible


def test_two_sided_wall_in_the_plane_is_a_path_along_it():
    task = iv.motion.VirtualWall(surface=iv.motion.Ball(centre=[0.0, 0.0], radius=0.3), sides="two")
    run = iv.session(CART, task, duration=0.2, rates=[0.0, 0.3, 0.0], pose=[0.302, 0.0, 0.0], output_step=0.01)
    # Critically damped over the usual settling length.
    lengths = 0.3 * 0.2 / SETTLING_LENGTH
    assert_allclose(run.penetration[-1], -0.002 * (1.0 + lengths) * math.exp(-lengths), rtol=0.02)


@pytest.mark.slow
def test_walls_of_both_displays():
    cobotic = felt(COBOTIC, iv.motion.VirtualWall(surface=FLOOR), 0.12)
    assert cobotic.penetration.max() < 1e-4
    assert cobotic.wall_force[-1] > 2.0
    task = iv.motion.VirtualWall(surface=FLOOR, stiffness=3000.0, damping=30.0)
    guide = controller_of(task, GEARED)
    assert (guide.stiffness, guide.damping, guide.two_sided) == (3000.0, 30.0, False)


@pytest.mark.slow
def test_fixtures_and_paths_of_legs_leave_only_what_is_free():
    line = felt(COBOTIC, iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[1.0, 1.0, 0.0], turning=True)), 0.05)
    across = line.position @ np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])
    assert np.abs(across).max() < 2e-5
    path = felt(COBOTIC, iv.motion.VirtualPath(curve=LINE), 0.06)
    assert np.abs(path.path_offset).max() < 2e-5
    assert path.position[-1, 0] > 1e-4
    plane = iv.session(
        HEXAPOD,
        iv.motion.Fixture(allowed=iv.motion.InPlane(normal=[0.0, 0.0, 1.0])),
        user=[4.0, 0.0, -6.0],
        duration=0.05,
        output_step=0.005,
    )
    assert np.ptp(plane.position[:, 2]) < 2e-5
    assert plane.position[-1, 0] > 1e-4


def test_holding_and_coasting():
    held = iv.session(
        COBOTIC, iv.motion.HoldingTask(stop_cylinder=True), user=[10.0, -5.0, 20.0], duration=0.02, output_step=0.01
    )
    assert held.electrical_energy == 0.0
    assert np.abs(held.position).max() < 1e-7
    turning = iv.session(COBOTIC, iv.motion.HoldingTask(), user=[10.0, -5.0, 20.0], duration=0.02, output_step=0.01)
    assert turning.electrical_energy > 0.02
    coasting = iv.session(CART, iv.motion.Coasting(), duration=0.05, rates=[0.3, 0.1, 0.0], output_step=0.01)
    assert_allclose(coasting.position[-1, 1] / coasting.position[-1, 0], 1.0 / 3.0, rtol=1e-3)
    geared = iv.session(GEARED, iv.motion.HoldingTask(), user=[0.0, 0.0, 12.0], duration=0.03, output_step=0.01)
    assert 0.0 < geared.position[-1, 2] < 12.0 / 1000.0


def test_session_is_drawn_and_labelled():
    run = felt(COBOTIC, iv.motion.VirtualWall(surface=FLOOR), 0.05, title="Floor")
    numbers = figure.data(run)
    assert set(numbers["position"]) == {"x", "y", "z"}
    assert_allclose(numbers["left"]["beyond the wall"], 1e3 * run.penetration)
    assert run.plot().axes[0].get_title() == "Floor"
    labelled = run.to_xarray()
    assert labelled["force_x_N"].attrs["units"] == "N"
    assert labelled["energy_lost_J"].shape == (len(run.lost), len(run.time))


@pytest.mark.slow
@pytest.mark.parametrize(
    "task",
    [
        iv.motion.VirtualPath(curve=LINE),
        iv.motion.Fixture(allowed=iv.motion.AlongLine(direction=[1.0, 1.0, 0.0], turning=True)),
    ],
)
def test_a_geared_display_holds_the_handle_to_a_line_by_springs(task):
    along, across = np.array([1.0, 1.0, 0.0]) / math.sqrt(2.0), np.array([1.0, -1.0, 0.0]) / math.sqrt(2.0)
    run = iv.session(GEARED, task, user=(60.0 * along + 20.0 * across).tolist(), duration=0.5, output_step=0.01)
    guide = controller_of(task, GEARED)
    offset = run.position[-1] @ across
    assert 0.5 * 20.0 / guide.stiffness < offset < 20.0 / guide.stiffness  # friction holds the rest
    assert run.position[-1] @ along > 10.0 * offset
    assert run.closure < 1e-6


@pytest.mark.slow
def test_an_open_path_of_a_geared_display_stops_at_its_ends_unless_free():
    short = iv.motion.LineCurve(start=[-0.1, 0.0, 0.0], end=[0.002, 0.0, 0.0])
    far = [
        iv.session(GEARED, iv.motion.VirtualPath(curve=short, ends=ends), user=[50.0, 0.0, 0.0], duration=0.5).position[
            -1, 0
        ]
        for ends in ("stop", "free")
    ]
    assert far[0] < 0.002 + 1.2 * 50.0 / 5000.0  # friction keeps a part of the overshoot
    assert far[1] > 0.03


@pytest.mark.parametrize(
    ("machine", "task", "message"),
    [
        (CART, iv.motion.VirtualPath(curve=LINE), "task must be in the plane"),
        (CART, iv.motion.VirtualWall(surface=FLOOR), "task must be in the plane"),
        (
            GEARED,
            iv.motion.Fixture(allowed=iv.motion.OnSurface(surface=iv.motion.Ball(centre=[0.0] * 3, radius=0.1))),
            "fixtures of fixed directions only",
        ),
        (MACHINES["serial arm"][0], iv.motion.Caster(), "task Caster has no controller for a SerialArmMachine"),
        (COBOTIC, "wall", "task must be one of VirtualPath"),
    ],
)
def test_tasks_that_a_machine_cannot_do_have_one_clear_message(machine, task, message):
    with pytest.raises(iv.InputError) as caught:
        iv.session(machine, task, duration=0.1)
    assert message in str(caught.value)


@pytest.mark.parametrize("machine", [COBOTIC, GEARED])
def test_slides_have_no_bond_graph_of_their_own(machine):
    with pytest.raises(iv.ParameterError, match="plant_graph has one"):
        iv.machine_graph(machine)


@pytest.mark.slow
def test_slides_follow_motions_of_scenarios():
    motion = iv.motion.VectorHistory.of(lambda time: [0.01 * math.sin(9.0 * time) ** 2, 0.0, 0.0], 0.1)
    for machine in (COBOTIC, GEARED):
        run = iv.simulate_machine(
            machine, iv.motion.MachineScenario(duration=0.1, motion=motion, wrench=[-5.0, 4.0, 0.0], output_step=0.01)
        )
        assert run.complete
        assert run.position_error.max() < 4e-4
        assert run.closure < 1e-6
