"""What machines say: messages in the words of a study, each mistake once, warnings, titles and sources."""

import tomllib
import warnings
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit, follow_path, simulate_machine
from infinivar.motion import MachineScenario
from internals import check_continuous, words_of
from internals import machine_tasks_figure as machine_tasks
from internals import wheels_figure as wheels
from machine_studies import EVERY, PLANAR, PLATFORM
from machines import MACHINES
from made import loaded

CART = loaded("planar_cart").drives["three-wheels"]
HEXAPOD = loaded("six_leg_display").drives["one-motor"]


def made(text, name="mine"):
    return iv.Study.from_dict(tomllib.loads(text), name=name)


# Shapes and types


def test_shapes_that_do_not_broadcast_are_one_message():
    with pytest.raises(
        iv.ParameterError, match=r"pose and twist and wrench must broadcast to one shape, got shapes \(2, 3\)"
    ):
        CART.perform(pose=np.zeros((2, 3)), twist=np.zeros((3, 3)), wrench=np.zeros(3))


def test_no_points_are_no_results():
    point = CART.perform(pose=np.zeros((0, 3)), twist=np.zeros((0, 3)), wrench=np.zeros((0, 3)))
    assert np.shape(point.power_in) == (0,)
    assert np.shape(point.part_forces) == (0, 3)


def test_graph_of_a_drive_of_a_study_names_the_machines_that_have_one():
    for name in ("six_leg_display", "sphere_joint", "two_joint_arm"):
        drive = next(iter(iv.load_study(name).drives.values()))
        with pytest.raises(
            iv.ParameterError, match=f"machine must be one of PlatformMachine, .*, got a {type(drive).__name__}"
        ):
            iv.machine_graph(drive)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("x", 1.0), "function must be a function of time, got 'x'"),
        ((np.sin, 0.0), "duration must be > 0 s, got 0"),
        ((np.sin, 1.0, 1), "points must be a whole number, 2 or more, got 1"),
    ],
)
def test_histories_of_what_is_no_function(given, words):
    with pytest.raises(iv.ParameterError, match=words):
        iv.motion.VectorHistory.of(*given)


def test_a_step_of_prescribed_angles_is_bad_input():
    """At any instant; fast and kinked angles are continuous."""
    run = {"duration": 0.1, "source": "none", "servos": False, "rates": [0.5, 0.0, 0.0]}
    for at in (0.05, 0.0123456):
        jump = MachineScenario(**run, steering=lambda time, at=at: [0.02 * (time > at), 0.0, 0.0])
        words = rf"steering must be continuous where no servos follow it, got a step of 0.02 rad at {at:.6g} s"
        with pytest.raises(iv.ParameterError, match=words):
            simulate_machine(MACHINES["planar"][0], jump)
    check_continuous("steering", lambda time: [np.sin(300.0 * time), abs(time - 0.05)], np.linspace(0.0, 0.1, 11))


# Figures


def test_losses_of_a_machine_are_all_of_them():
    pose = [0.0, 0.0, HEXAPOD.platform.home]
    drive = HEXAPOD.legs
    point = drive.operate(HEXAPOD.platform.at(pose), wrench=[5.0, 0, 0, 0, 0, 0], twist=[0, 0, 0.3, 0, 0, 0])
    numbers = wheels.data(point)
    legs = sum(float(np.sum(loss)) for loss in numbers["losses"].values())
    assert legs + sum(numbers["shared"].values()) == pytest.approx(float(point.loss), rel=1e-12)
    title = point.plot().axes[0].get_title()
    assert title.startswith(f"losses {float(point.loss):.3g} W: legs {legs:.3g} W, motor, gearhead and amplifier ")


def test_a_path_at_rest_is_drawn_without_an_empty_legend():
    path = _resting()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawn = machine_tasks.draw_paths({"cart": follow_path(CART, path)})
    assert [text.get_text() for text in drawn.axes[0].texts] == ["at rest"]


def _resting():
    text = PLANAR.partition("[tasks")[0] + '[paths.p]\nx = { shape = "hold", time = "1 s" }\n'
    return next(iter(made(text).paths.values()))


# Words


def test_limit_of_the_push_is_named_like_its_field():
    point = CART.perform(pose=[0.0] * 3, twist=[0.5, 0.0, 0.0], wrench=[10.0, 0.0, 0.0])
    (demand,) = [key for key in point.demands if key[0] is Limit.OUTPUT_FORCE]
    assert words_of(demand) == "source, largest_push: permissible output force"


def test_a_point_of_a_cart_has_no_z():
    text = PLANAR.partition("[tasks")[0]
    tables = tomllib.loads(text)
    drive = next(name for name, one in tables["drives"].items() if one.get("type") == "planar")
    tables["drives"][drive]["positions"] = []
    with pytest.raises(iv.InputError, match=r"such as \[\{ x = ... \}, ...\]; keys: x, y$"):
        iv.Study.from_dict(tables, name="mine")


def test_a_mistake_is_reported_for_the_drive_that_states_it():
    """Not for those that are like it, in any order, whose own mistakes are."""
    tables = tomllib.loads(iv.load_study("planar_cart").to_toml())
    base = tables["drives"]["three-wheels"]
    base["wheel"]["preload"] = "-1 N"
    tables["drives"] = {
        "first": {"like": "three-wheels"},
        "three-wheels": base,
        "second": {"like": "first", "largest_push": "-5 N"},
    }
    with pytest.raises(iv.InputError) as found:
        iv.Study.from_dict(tables, name="mine")
    lines = str(found.value).splitlines()
    assert [line.partition(" ")[0] for line in lines] == ["mine:", "drives.second.largest_push"] or len(lines) == 2
    assert sum("wheel.preload" in line for line in lines) == 1
    assert "drives.three-wheels.wheel.preload" in str(found.value)


def test_a_task_and_a_path_of_one_name_are_told_apart():
    study = iv.load_study("two_joint_arm")
    task, path = next(iter(study.tasks.values())), next(iter(study.paths.values()))
    same = replace(
        study,
        tasks={"t": replace(task, title="", time_share=None)},
        paths={"t": replace(path, title="", time_share=None)},
        provenance=(),
    )
    assert (same.tasks["t"].title, same.paths["t"].title) == ("task t", "path t")


def test_contact_is_not_said_to_need_one_axis():
    from internals import refuse_machine

    with pytest.raises(
        iv.ParameterError, match="type planar: contact does not work with it; commands for this machine: check"
    ):
        refuse_machine(CART, "contact")


def test_an_implausible_friction_coefficient_is_a_warning():
    tables = tomllib.loads(iv.load_study("planar_cart").to_toml())
    assert iv.Study.from_dict(tables, name="mine").warnings == ()
    tables["drives"]["three-wheels"]["wheel"]["friction"] = 30
    (said,) = [one for one in iv.Study.from_dict(tables, name="mine").warnings if "three-wheels" in one]
    assert said.startswith("drives.three-wheels.wheel.friction = 30 is a coefficient")


@pytest.mark.parametrize("name", EVERY)
def test_usual_machines_have_no_warning_of_friction(name):
    assert not [one for one in made(EVERY[name]).warnings if "friction" in one]


# Sources


def test_motions_of_paths_have_sources():
    text = PLATFORM.replace('y = { shape = "sinusoid"', 'y = { kind = "stated", where = "Table 3", shape = "sinusoid"')
    study = made(text)
    rows = {row.field: row for row in study.provenance if row.owner == "paths.circle"}
    assert rows["x.shape"].value == "sinusoid"
    assert (rows["x.distance"].written, rows["x.distance"].unit) == ("20 mm", "m")
    assert rows["x.frequency"].value == pytest.approx(1.0)
    assert (rows["y.start"].kind, rows["y.start"].where) == ("stated", "Table 3")
    assert "x.time" not in rows
    again = made(study.to_toml())
    assert again == study
    row = next(row for row in again.provenance if row.field == "y.start")
    assert row.where == "Table 3"


def test_motions_given_in_python_have_sources():
    study = made(PLATFORM)
    path = study.paths["circle"]
    changed = replace(study, paths={"circle": replace(path, x=replace(path.x, distance=0.03))})
    rows = {row.field: row for row in changed.provenance if row.owner == "paths.circle"}
    assert (rows["x.distance"].value, rows["x.distance"].where) == (0.03, "given in Python")
    assert rows["y.distance"].written == "20 mm"
