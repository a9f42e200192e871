"""Studies and recordings with random faults: a message or a result, never a traceback, a warning or a silent nan."""

import json
import math

import numpy as np
import pytest

import fault_generator
import infinivar as iv
from infinivar import CoboticDrive, InputError


def written(folder, random):
    """A study with its recording, either or both with faults."""
    (folder / "recording.csv").write_bytes(fault_generator.recording(random))
    study = folder / "study.toml"
    study.write_text(fault_generator.text(fault_generator.mutated(fault_generator.study(random), random)), "utf-8")
    return study


def nans(value, path=""):
    """Where a result has numbers that are none, in words, too."""
    if isinstance(value, dict):
        return [found for key, one in value.items() for found in nans(one, f"{path}/{key}")]
    if isinstance(value, (list, tuple)):
        return [found for one in value for found in nans(one, path)]
    if isinstance(value, float) and math.isnan(value):
        return [path]
    return [f"{path}: {value}"] if isinstance(value, str) and "nan" in value.replace(",", " ").split() else []


def check_comparison(found):
    """Energies, margins and temperatures are numbers but where the verdict says that the drive cannot do it."""
    report = json.loads(json.dumps(found.to_dict()))
    for result in report["drives"].values():
        assert not nans(result) or result["coverage"] == 0.0, result
    for cycle in report.get("duty", {}).values():
        for result in cycle["drives"].values():
            if result["feasible"]:
                alternatives = result.pop("cylinder", [])
                assert not nans(result), result
                assert not any(nans(one) for one in alternatives if one.get("feasible")), alternatives
            else:
                assert result["verdict"].startswith(("infeasible", "cannot")), result["verdict"]
                assert not nans(result["verdict"])


def check_message(message):
    assert "\x1b" not in message
    assert "study.toml" in message or "recording.csv" in message


def work(folder, seed):
    """What becomes of one study: refused, or compared and simulated."""
    random = np.random.default_rng(seed)
    try:
        study = iv.load_study(written(folder, random))
    except InputError as found:
        check_message(str(found))
        return "refused"
    try:
        check_comparison(iv.compare(study))
        for scenario in study.scenarios.values():
            for drive in study.drives.values():
                kept = scenario.steering != "controlled" or scenario.cylinder != "running"
                if kept and not isinstance(drive, CoboticDrive):
                    continue
                run = iv.simulate(drive, scenario)
                assert not nans(run.to_dict())
                assert all(np.all(np.isfinite(column)) for column in run.columns.values())
    except InputError:
        return "refused later"
    return "computed"


def most(outcomes, seeds):
    """Enough of them get as far as results, or the test says nothing."""
    assert outcomes.count("computed") > 0.35 * len(seeds), outcomes
    assert outcomes.count("refused") > 0.1 * len(seeds), outcomes


def test_faulty_studies(tmp_path):
    """4 of them here, 500 with -m full."""
    seeds = (0, 1, 3, 4)
    most([work(tmp_path, seed) for seed in seeds], seeds)


@pytest.mark.full
def test_many_faulty_studies(tmp_path):
    seeds = range(1000, 1500)
    outcomes = [work(tmp_path, seed) for seed in seeds]
    print({outcome: outcomes.count(outcome) for outcome in sorted(set(outcomes))})
    most(outcomes, seeds)
