"""Sweeps over measuring sessions: against single calibrations, and what they tell of a parameter."""

import json

import numpy as np
import pytest

import infinivar as iv
from infinivar import calibrate
from internals import calibration_model as model
from internals import experiment, protocol
from made import loaded

STUDY = loaded("hand_controller")
RUNS = {"ratios": (20.0, 4.0), "loads": (0.2, 0.5)}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    problem = iv.sweeps.sessions_sweep(STUDY, "cobotic", **RUNS, creep_laws=("linear",), sessions=5, size=2)
    return problem, iv.sweep(problem, tmp_path_factory.mktemp("sweeps") / "sessions")


@pytest.mark.slow
def test_sessions_are_those_of_the_rig_calibrated_one_by_one(done):
    problem, swept = done
    drive, known = STUDY.drives["cobotic"], model.known_values(STUDY.drives["cobotic"])
    settings = protocol(drive, STUDY.rig, **RUNS)
    fits = [
        calibrate(
            STUDY,
            "cobotic",
            experiment(drive, STUDY.rig, settings, seed=seed, simulated=False).data,
            creep_laws=("linear",),
        ).fit
        for seed in range(5)
    ]
    found = problem.result(swept)
    assert (found.sessions, found.refused, dict(found.laws)) == (5, 0, {"linear": 5})
    for name in ("creep_stiffness", "guideway_friction"):
        errors = np.array([fit.values[name] - known[name] for fit in fits])
        ends = [fit.interval(name) for fit in fits]
        one = found.parameters[name]
        assert one.identifiable == 1.0
        assert one.bias == pytest.approx(errors.mean(), rel=1e-12)
        assert one.scatter == pytest.approx(errors.std(), rel=1e-12)
        assert one.covered == np.mean([low <= known[name] <= high for low, high in ends])
    both = found.parameters["rolling_torque + bearing_torque"]
    sums = [fit.combinations[0] for fit in fits]
    truth = [sum(weight * known[name] for name, weight in one.weights.items()) for one in sums]
    assert both.bias == pytest.approx(
        np.mean([one.value - true for one, true in zip(sums, truth, strict=True)]), rel=1e-9
    )
    assert found.parameters["rolling_torque"].identifiable == 0.0
    assert "not identifiable by itself" in found.parameters["rolling_torque"].verdict


@pytest.mark.slow
def test_fewer_runs_tell_less(done, tmp_path):
    """A quarter of the runs: the scatter of the friction grows, and the fits say so."""
    problem, swept = done
    few = iv.sweeps.sessions_sweep(
        STUDY, "cobotic", ratios=(20.0,), loads=(0.2,), creep_laws=("linear",), sessions=5, size=5
    )
    less, more = few.result(iv.sweep(few, tmp_path / "few")), problem.result(swept)
    assert less.parameters["guideway_friction"].stated > more.parameters["guideway_friction"].stated


def test_wrong_questions_are_refused_before_anything_runs():
    for options, words in (
        ({"sessions": 0}, "sessions must be a whole number >= 1"),
        ({"parameters": ("mass",)}, "'mass' cannot be fitted"),
        ({"loads": (1.5,)}, "loads must be"),
        ({"creep_laws": ("soft",)}, "soft"),
    ):
        with pytest.raises(iv.InputError, match=words):
            iv.sweeps.sessions_sweep(STUDY, "cobotic", **{**RUNS, **options})
    with pytest.raises(iv.InputError, match="motor1-gear1"):
        iv.sweeps.sessions_sweep(STUDY, "motor1-gear1")


@pytest.mark.slow
def test_the_result_is_plain_numbers(done):
    problem, swept = done
    said = problem.result(swept).to_dict()
    assert json.loads(json.dumps(said))["sessions"] == 5
    assert set(said["parameters"]["creep_stiffness"]) == {
        "identifiable",
        "bias",
        "scatter",
        "stated",
        "covered",
        "unit",
    }
