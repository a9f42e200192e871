"""Every command runs on every supported version of Python and its libraries, and says what it should first.

What each command says is tested elsewhere, with pinned versions; here it is enough that nothing breaks.
"""

import json
import re

import pytest

from infinivar.cli import app
from small_catalogue import SLOW

pytestmark = [pytest.mark.slow, pytest.mark.every_version]
RECORDED = "time [s],position [mm]\n" + "".join(f"{0.01 * row:.2f},{abs(50 - row % 100)}\n" for row in range(401))
BENCH = """
[requirement]
base = "faulring2006"
[drives.joint]
base = "faulring2006.motor1-gear1"
"""
POINTS = "speed [rad/s],torque [N m],current [A],voltage [V]\n" + "".join(
    f"{speed},{torque},{(1.03 * torque + 0.015) / 0.297:.4f},{2.4 * (1.03 * torque + 0.015) / 0.297 + 0.297 * speed:.4f}\n"
    for speed in (10, 20, 40, 60)
    for torque in (0.05, 0.15, 0.25)
)

COMMANDS = {
    "init": (["init", "mine"], "mine"),
    "check": (["check", "knee_walking"], "no faults found"),
    "compare": (["compare", "hand_controller", "--drive", "motor2-gear4", "--quick"], "covers"),
    "size": (["size", "knee_walking", "--drive", "geared", "--set", "few.toml", "--builds", "0"], "energy of "),
    "contact": (["contact", "knee_walking"], "contact.html"),
    "motion": (["motion", "recorded.csv"], "recorded.csv: time, position in 401 rows"),
    "simulate": (["simulate", "hand_controller", "--scenario", "push", "--drive", "motor2-gear4"], "J from the supply"),
    "session": (["session", "one_axis_display", "--task", "hold"], "J "),
    "sensitivity": (["sensitivity", "hand_controller", "--of", "loss", "--force", "20 N", "--speed", "0.3 m/s"], "%"),
    "graph": (["graph", "hand_controller", "motor2-gear4"], "Wrote graph.svg"),
    "export": (["export", "hand_controller", "motor2-gear4", "--as", "fmu3"], "Wrote out/motor2_gear4.fmu"),
    "rig": (["rig", "hand_controller", "--ratios", "8", "--loads", "0.5"], "runs written to rig.csv"),
    "measured": (["measured", "list"], "screws_and_worm"),
    "calibrate": (["calibrate", "bench.csv", "--study", "bench.toml", "--drive", "joint"], "torque_constant = "),
    "reproduce": (["reproduce", "--figure", "7"], "claim"),
    "schema": (["schema"], '"$schema"'),
    "serve": (["serve", "missing.toml"], "missing.toml"),
    "catalogue": (["catalogue", "search", "motors", "mass < 0.3 kg"], "g"),
    "sweep": (["sweep", "show", "missing"], "missing"),
}
"""Arguments of each command, and what it prints."""

FAILS = {"serve": 2, "sweep": 2}
"""Exit codes of those that are only asked for something that is not there."""


def test_no_command_is_left_out():
    names = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert names | {group.name for group in app.registered_groups} == set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_it_runs(name, infinivar, tmp_path):
    given = {"recorded.csv": RECORDED, "bench.toml": BENCH, "bench.csv": POINTS, "few.toml": SLOW}
    for file, text in given.items():
        (tmp_path / file).write_text(text, "utf-8")
    arguments, said = COMMANDS[name]
    outcome = infinivar(*arguments)
    printed = re.sub(r"\s+", " ", outcome.out + outcome.err)
    assert outcome.code == FAILS.get(name, 0), printed
    assert said in printed
    for result in tmp_path.rglob("*.json"):
        json.loads(result.read_text("utf-8"))
