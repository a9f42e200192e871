"""Why a machine cannot, where and by how much; and which changes would do."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.motion import MachineTask, Twist, Wrench
from internals import evaluate_machine, plain_units, sufficient_changes, with_changes, with_values
from made import loaded
from run_cli import run

WEAK = """
extends = "planar_cart"
[drives.three-wheels.wheel]
friction = 0.05
"""


@pytest.fixture(scope="module")
def weak(tmp_path_factory):
    file = tmp_path_factory.mktemp("weak") / "weak.toml"
    file.write_text(WEAK, "utf-8")
    return file


def margins(study, name, drive):
    return [one.margin for one in evaluate_machine(study, name, drive).found.values()]


@pytest.mark.parametrize("name", ["three-wheels", "two-wheels"])
def test_each_change_is_enough_and_a_smaller_one_is_not(weak, name):
    study = iv.load_study(weak)
    drive = study.drives[name]
    assert min(margins(study, name, drive)) < 1.0
    found = sufficient_changes(study, name)
    assert found
    for changes in found:
        assert min(margins(study, name, with_values(drive, {path: one.stated for path, one in changes.items()}))) >= 1.0
        if len(changes) == 1:
            ((path, one),) = changes.items()
            less = one.start + 0.98 * (one.needed - one.start)
            assert min(margins(study, name, with_values(drive, {path: less}))) < 1.0


def test_a_change_is_sought_for_several_tasks_of_legs_and_of_motors():
    """Each checked in all tasks and on the path."""
    study = loaded("two_joint_arm")
    tasks = {key: replace(one, wrench=replace(one.wrench, x=40.0)) for key, one in study.tasks.items()}
    study = replace(study, tasks=tasks)
    for name, drive in study.drives.items():
        assert min(margins(study, name, drive)) < 1.0
        for changes in sufficient_changes(study, name):
            changed = with_values(drive, {path: one.stated for path, one in changes.items()})
            assert min(margins(study, name, changed)) >= 1.0


def test_of_a_feasible_machine_no_change_is_sought():
    assert sufficient_changes(loaded("planar_cart"), "three-wheels") == ()


def test_a_task_says_how_much_of_its_wrench_is_borne():
    cart = loaded("planar_cart").drives["three-wheels"]
    task = MachineTask(title="wall", twist=Twist(x=0.5), wrench=Wrench(y=150.0))
    found = iv.perform_task(cart, task)
    assert not found.feasible
    assert f"bears {100 * found.bears:.0f} % of its load" in found.tightest_words
    for share, able in ((found.bears, True), (found.bears + 0.01, False)):
        assert iv.perform_task(cart, replace(task, wrench=Wrench(y=150.0 * share))).feasible is able
    assert np.isnan(iv.perform_task(cart, replace(task, wrench=Wrench(y=10.0))).bears)


def test_a_path_says_where(tmp_path):
    """Where its own demand is the largest: in a reach of 80 mm in 0.1 s a wheel slips."""
    file = tmp_path / "fast.toml"
    quick = 'shape = "reaches", distance = "80 mm", time = "0.1 s", pause = "0.2 s", profile = "smooth"'
    file.write_text(f'extends = "two_joint_arm"\n[paths.reach]\nx = {{ {quick} }}\ny = {{ {quick} }}\n', "utf-8")
    study = iv.load_study(file)
    found = iv.follow_path(study.drives["one-motor"], study.paths["reach"])
    assert not found.feasible
    assert found.demand[0] is iv.Limit.SLIP
    values = np.asarray(found.point.demands[found.demand])
    assert found.instant == np.argmax(np.where(np.isnan(values), np.inf, values))
    assert f" at {plain_units(found.time[found.instant], 3)} s (x " in found.tightest_words


def test_the_command_and_its_report_name_changes(weak, tmp_path):
    done = run("compare", weak, "--out", tmp_path / "out", folder=tmp_path)
    assert done.code == 1
    (line,) = [one for one in done.out.splitlines() if one.startswith("cart on three wheels would be feasible with ")]
    assert "wheel.preload" in line
    assert line.replace(" N", "\N{NO-BREAK SPACE}N") in (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "would be feasible" not in run("compare", weak, "--quick", folder=tmp_path).out


def test_a_machine_that_nothing_helps_says_so():
    study = loaded("planar_cart")
    tasks = {"wall": replace(study.tasks["wall"], wrench=Wrench(y=1e6), time_share=None)}
    study = replace(study, tasks=tasks, drives={"two-wheels": study.drives["two-wheels"]})
    comparison = with_changes(iv.compare(study))
    assert comparison.changes == {"two-wheels": ()}
