"""The search of `size` over cobotic drives from many starts: what the chunks keep is the result of `size`."""

import pickle
from dataclasses import replace

import pytest

import infinivar as iv
from internals import of_cobotic
from made import loaded
from sampled import sampled
from small_catalogue import SLOW

KNEE = loaded("knee_walking")
WALKING = replace(KNEE, requirement=None)
RANGES = {"preload": (1800.0, 2600.0), "wheel_radius": (0.018, 0.03), "crown_radius": (0.025, 0.025)}
ASKED = {"generations": 2, "ranges": RANGES, "steering_ratios": (16.0,)}


@pytest.fixture(scope="module")
def shelf(tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "shelf.toml"
    path.write_text(SLOW, "utf-8")
    return path


@pytest.fixture(autouse=True)
def few_wheels(monkeypatch):
    """Fewer wheel designs in each generation than `size` looks at, to be done sooner."""
    monkeypatch.setattr(of_cobotic, "POPULATION", 5)


def swept(problem, folder, monkeypatch):
    """A sweep, and its result from what the folder holds."""
    iv.sweep(problem, folder)

    def again(*arguments, **options):
        raise AssertionError("searched again")

    monkeypatch.setattr("infinivar.sweeps.cobotic.best_cobotic", again)
    return problem.sizing(iv.load_sweep(folder))


@sampled("objective", ["energy", ("mass", "energy")], slow=2)
def test_one_start_gives_the_result_of_size(shelf, tmp_path, monkeypatch, objective):
    whole = iv.size(WALKING, drive="cobotic", sets=shelf, objective=objective, seed=0, top=5, **ASKED)
    problem = iv.sweeps.cobotic_study_sweep(WALKING, starts=1, sets=shelf, objective=objective, top=5, **ASKED)
    assert isinstance(problem, iv.sweeps.CoboticStudySweep)
    found = swept(problem, tmp_path / "s", monkeypatch)
    assert found.designs
    assert found.designs == whole.designs
    assert found.front == whole.front
    assert found.best_of == whole.best_of
    assert found.notes == whole.notes
    assert found.verdict == whole.verdict
    # A sweep does not decide again with other answers to open choices.
    assert found.hangs_on is None
    assert found.cautions == tuple(one for one in whole.cautions if not one.startswith("what the verdict hangs on"))
    mine, theirs = (one.searches["cobotic"].to_dict() for one in (found, whole))
    assert mine.pop("history") == []
    assert theirs.pop("history")
    assert mine == theirs
    study = found.study_of(found.best)
    cycle = iv.compare(study, quick=True).duty["walking"].results["cobotic"]
    assert cycle.power_in == pytest.approx(found.best.power, rel=1e-9)


def test_another_first_objective_does_not_continue_a_sweep(shelf):
    """Workers get the problem, and a folder belongs to one order of designs."""
    both = [
        iv.sweeps.cobotic_study_sweep(WALKING, starts=2, sets=shelf, objective=aims, **ASKED)
        for aims in (("energy", "mass"), ("mass", "energy"))
    ]
    assert both[0].identity["options"] == both[1].identity["options"]
    assert both[0].identity != both[1].identity
    again = pickle.loads(pickle.dumps(both[0]))
    assert again.identity == both[0].identity
    assert again.study_request.aims == ("energy", "mass")


@pytest.mark.full
def test_of_several_starts_the_nearest_miss_is_kept(tmp_path, monkeypatch):
    """Where none is feasible: the nearest of what the starts find alone, whichever of them finds it."""
    (tmp_path / "weak.toml").write_text(SLOW.replace('voltage = "24 V"', 'voltage = "3 V"'), "utf-8")
    chosen = {**ASKED, "sets": tmp_path / "weak.toml", "objective": "energy"}
    alone = [iv.size(WALKING, drive="cobotic", seed=seed, **chosen).nearest for seed in range(2)]
    assert len({one.margin for one in alone}) == 2
    problem = iv.sweeps.cobotic_study_sweep(WALKING, starts=2, **chosen)
    found = swept(problem, tmp_path / "s", monkeypatch)
    assert not found.feasible
    assert found.nearest == max(alone, key=lambda one: one.margin)
    assert found.what_if["cobotic"].goal == "feasible"
    again = iv.load_sweep(tmp_path / "s")
    assert len(again.list("nearest")["list"]) == 1
    title, row = (line for line in again.lines() if line.startswith(("Nearest", "  1. ")))
    assert title == "Nearest miss, 1 design:"
    assert row.endswith(found.nearest.results[-1])
    assert problem.verdict(again).startswith("none of ")


@pytest.mark.full
def test_a_wheel_that_slips_has_no_motors_to_name(shelf, tmp_path, monkeypatch):
    chosen = {**ASKED, "ranges": {**RANGES, "preload": (300.0, 400.0)}, "sets": shelf, "objective": "energy"}
    problem = iv.sweeps.cobotic_study_sweep(WALKING, starts=2, **chosen)
    found = swept(problem, tmp_path / "s", monkeypatch)
    alone = [iv.size(WALKING, drive="cobotic", seed=seed, **chosen).nearest for seed in range(2)]
    assert found.nearest in alone
    assert found.nearest.title.startswith("wheel with any motors")
    assert found.what_if["cobotic"].slips
    (row,) = (line for line in iv.load_sweep(tmp_path / "s").lines() if line.startswith("  1. "))
    assert row.endswith("; infeasible (wheel slip, walking: no steady rolling)")
    assert "nan" not in row
    assert "; ;" not in row
