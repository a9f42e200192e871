"""Samples of a drive in time: against simulations of single drives, and against the energy of the motion without controllers."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.sweeps import builds_sweep, runs_sweep
from internals import with_values
from made import loaded

STUDY = loaded("hand_controller")
TEXT = """
extends = "hand_controller"
[uncertainty.cobotic.motor]
resistance = "10 %"
max_speed = { low = "600 rad/s", high = "1200 rad/s" }
[scenarios.short]
base = "faulring2006.reach"
duration = "0.2 s"
[scenarios.slow]
base = "faulring2006.hold"
duration = "0.1 s"
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("studies") / "mine.toml"
    path.write_text(TEXT, "utf-8")
    return iv.load_study(path)


@pytest.fixture(scope="module")
def found(study, tmp_path_factory):
    problem = runs_sweep(study, scenario="short", draws=32, size=16)
    return problem.result(iv.sweep(problem, tmp_path_factory.mktemp("sweep") / "runs"))


def test_each_sample_is_a_simulation_of_its_own(study, found):
    paths = [spread.path for spread in found.spreads]
    assert sorted(paths) == ["motor.max_speed", "motor.resistance"]
    assert found.count == 32
    for place in (0, 13, 31):
        drive = with_values(study.drives["cobotic"], dict(zip(paths, found.values[place].tolist(), strict=True)))
        run = iv.simulate(drive, study.scenarios["short"])
        assert found.energy[place] == run.supplied_after_settling
        assert found.error[place] == run.largest_error
        assert found.able[place] == run.feasible
    assert 0.0 < found.share < 1.0  # the cylinder turns the motor at 798 rad/s
    assert found.exceeded == {"motor permissible speed (motor)": np.sum(~found.able)}
    assert f"feasible in {round(100 * found.share)} % of 32 samples" in found.verdict
    assert found.to_dict()["energy_J"]["median"] == pytest.approx(np.median(found.energy))


def test_samples_are_those_of_the_static_sweep_and_of_any_chunks(study, found, tmp_path):
    resistance = builds_sweep(study, draws=32, size=16).run(1).rows["value: motor.resistance"]
    place = [spread.path for spread in found.spreads].index("motor.resistance")
    np.testing.assert_array_equal(resistance, found.values[16:, place])
    whole = runs_sweep(study, scenario="short", draws=32, size=32)
    again = whole.result(iv.sweep(whole, tmp_path / "whole"))
    np.testing.assert_array_equal(again.energy, found.energy)
    assert again.exceeded == found.exceeded


def test_more_resistance_takes_more_energy(found):
    place = [spread.path for spread in found.spreads].index("motor.resistance")
    order = np.argsort(found.values[:, place])
    assert np.all(np.diff(found.energy[order]) > 0.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scenario": "shrot"}, r"scenario 'shrot' is not in the study \(did you mean 'short'"),
        ({"drive": "motor1-gear1"}, r"drives.motor1-gear1 has no spreads: add a table \[uncertainty.motor1-gear1\]"),
        ({"draws": 100}, "draws must be a power of two from 16"),
    ],
)
def test_what_cannot_be_sampled_is_named(study, options, message):
    with pytest.raises(iv.InputError, match=message):
        runs_sweep(study, **options)


def test_a_scenario_that_a_drive_cannot_follow_is_refused_before_samples_are_drawn(study):
    geared = replace(study.uncertainty, spreads={"motor1-gear1": study.uncertainty.spreads["cobotic"]})
    with pytest.raises(iv.ParameterError, match="steering = 'locked' requires a cobotic drive"):
        runs_sweep(replace(study, uncertainty=geared), scenario="slow")
