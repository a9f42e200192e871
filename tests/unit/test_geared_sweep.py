"""The search over geared drives in chunks: the same designs, front and counts as the search in one piece."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from internals import size_geared
from made import loaded
from sampled import sampled
from small_catalogue import SHELF

pytestmark = pytest.mark.slow

KNEE = loaded("knee_walking")
WALKING = replace(KNEE, requirement=None)
RADII = (0.003, 0.05)
WARM = """
winding_to_housing = "20 K/W"
housing_to_ambient = "20 K/W"
winding_time_constant = "0.2 s"
housing_time_constant = "600 s"
max_winding_temperature = "155 degC"
"""
LEADS = "drives.screw.screw.lead"


@pytest.fixture(scope="module")
def problem(shelf):
    return iv.sweeps.geared_sweep(WALKING, sets=shelf, radius=RADII, size=4)


@pytest.fixture(scope="module")
def swept(problem, tmp_path_factory):
    return iv.sweep(problem, tmp_path_factory.mktemp("swept") / "s")


def test_over_the_radius_designs_front_and_counts_are_those_of_size(problem, swept, shelf):
    found, whole = problem.result(swept), iv.size(WALKING, sets=shelf, radius=RADII, drive="geared")
    assert swept.chunks == problem.chunks == 2
    for mine, theirs in ((found.designs, whole.designs), (found.front, whole.front)):
        assert [one.title for one in mine] == [one.title for one in theirs]
        for one, other in zip(mine, theirs, strict=True):
            assert one.equals(other, rtol=1e-9)
    mine, theirs = (one.searches["geared"] for one in (found, whole))
    for name in ("candidates", "left", "excluded", "counts", "unchecked", "ranges"):
        assert getattr(mine, name) == getattr(theirs, name)
    assert found.verdict == whole.verdict
    assert len(found.designs) > 3
    assert len(found.front) > 1


def test_with_given_stages_designs_front_and_counts_are_those_of_the_search(shelf, tmp_path):
    problem = iv.sweeps.geared_sweep(
        WALKING, sets=shelf, radius=(0.005, 0.012), radii=3, objective=("mass", "energy"), size=3, top=4
    )
    found = problem.result(iv.sweep(problem, tmp_path / "s"))
    parts = problem.parts
    tables = WALKING.drives["geared"], parts.motors, parts.gearheads, parts.pairs
    stages = [replace(tables[0].pulley, radius=radius) for radius in np.geomspace(0.005, 0.012, 3)]
    assert problem.chunks == 9
    for objective, mine in (("mass", found.designs), ("front", found.front)):
        whole = size_geared(*tables, duty=WALKING.duty, stages=stages, objective=objective, top=4)
        assert len(mine) > 1
        for one, other in zip(mine, whole.designs, strict=True):
            assert one.drive == other.drive
            assert one.demands == pytest.approx(other.demands, rel=1e-9)
            assert (one.mass, one.power) == pytest.approx((other.mass, other.power), rel=1e-9)
        if objective == "mass":
            record = found.searches["geared"]
            assert (record.candidates, record.left) == (whole.candidates, whole.evaluated.sum())
            assert record.counts == whole.counts
            assert record.unchecked == whole.unchecked


def test_candidates_left_are_those_evaluated_where_stages_are_given(tmp_path):
    """Closed forms leave drives whose windings turn out too hot: they are evaluated, and infeasible."""
    (tmp_path / "hot.toml").write_text(SHELF.replace('mass = "310 g"', f'mass = "310 g"\n{WARM}'), "utf-8")
    problem = iv.sweeps.geared_sweep(WALKING, sets=tmp_path / "hot.toml", radius=RADII, radii=6, objective="mass")
    swept = problem.result(iv.sweep(problem, tmp_path / "s")).searches["geared"]
    screws = [iv.parts.Screw(lead=lead, diameter=0.01, friction_coefficient=0.05) for lead in (0.01, 0.02, 0.03)]
    study = replace(WALKING, drives={"screw": replace(WALKING.drives["geared"], pulley=None, screw=screws[0])})
    chosen = {"sets": tmp_path / "hot.toml", "objective": "mass"}
    sized = iv.size(study, tries={LEADS: [one.lead for one in screws]}, **chosen).searches["screw"]
    same = iv.sweeps.geared_sweep(study, stages=screws, **chosen)
    assert same.result(iv.sweep(same, tmp_path / "t")).searches["screw"].left == sized.left
    for record in (swept, sized):
        hot = sum(one.first for one in record.counts if one.limit == Limit.TEMPERATURE)
        feasible = record.candidates - sum(record.excluded.values()) - sum(one.first for one in record.counts)
        assert hot > 0
        assert feasible < record.left == record.evaluated < record.candidates


@pytest.mark.full
def test_where_nothing_is_feasible_the_nearest_miss_is_that_of_size(shelf, tmp_path):
    shake = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.06, frequency=2.0), load_mass=1.5, force=-900.0)
    study = replace(WALKING, duty={"shake": shake})
    problem = iv.sweeps.geared_sweep(study, sets=shelf, radius=RADII, size=5)
    found, whole = (
        problem.result(iv.sweep(problem, tmp_path / "s")),
        iv.size(study, sets=shelf, radius=RADII, drive="geared"),
    )
    assert not found.designs
    assert found.verdict == whole.verdict
    assert found.searches["geared"].counts == whole.searches["geared"].counts
    assert found.searches["geared"].nearest == whole.searches["geared"].nearest


@sampled("objective", ["mass", "energy"], every=2)
def test_of_equal_misses_a_sweep_finds_the_one_that_size_does(shelf, tmp_path, objective):
    """All exceed what the screw permits; what else they exceed decides, and for the least mass whether they state one."""
    screws = [
        iv.parts.Screw(lead=lead, diameter=0.01, friction_coefficient=0.05, permissible_force=60.0)
        for lead in (0.01, 0.03)
    ]
    study = replace(WALKING, drives={"screw": replace(WALKING.drives["geared"], pulley=None, screw=screws[0])})
    problem = iv.sweeps.geared_sweep(study, sets=shelf, stages=screws, objective=objective, size=2)
    found = problem.result(iv.sweep(problem, tmp_path / "s")).searches["screw"]
    leads = [one.lead for one in screws]
    whole = iv.size(study, sets=shelf, tries={LEADS: leads}, objective=objective).searches["screw"]
    assert found.nearest.tightest[1] == Limit.OUTPUT_FORCE
    lead = whole.nearest.free["screw.lead"]
    assert (lead.value, lead.tried) == (found.nearest.free["screw.lead"].value, (0.01, 0.03))
    assert found.nearest == replace(whole.nearest, free=found.nearest.free)
    assert found.counts == whole.counts


def test_the_nearest_miss_of_least_mass_states_its_mass(tmp_path):
    """The heaviest pair would be nearest, but nothing says what it weighs."""
    (tmp_path / "set.toml").write_text(SHELF.replace('mass = "310 g"\n', ""), "utf-8")
    shake = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.06, frequency=2.0), load_mass=1.5, force=-900.0)
    study = replace(WALKING, duty={"shake": shake})
    for objective, named in (("mass", "b"), ("energy", "c")):
        problem = iv.sweeps.geared_sweep(
            study, sets=tmp_path / "set.toml", radius=(0.005, 0.012), radii=3, objective=objective
        )
        found = problem.result(iv.sweep(problem, tmp_path / objective))
        assert found.nearest.parts["motor"].key == named


def test_a_sweep_that_is_not_finished_has_no_result(problem, swept, tmp_path):
    with pytest.raises(iv.InputError, match="the sweep is not finished: 1 of 2 chunks are done"):
        problem.result(replace(swept, done=1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"top": 3}, "top: 50 there, 3 here"),
        ({"radius": (0.004, 0.05)}, r"radius \[m\]: 0\.003, 0\.05 there, 0\.004, 0\.05 here"),
        ({"objective": "mass"}, "objective: energy, mass there, mass here"),
        ({"size": 3}, "pairs in a chunk: 4 there, 3 here"),
        (
            {"study": replace(WALKING, duty={"walking": replace(WALKING.duty["walking"], ambient=300.0)})},
            "motions: the content",
        ),
        ({"study": KNEE}, "requirement: the content differs"),
    ],
)
def test_other_options_do_not_continue_a_sweep(swept, shelf, change, message):
    options = {"study": WALKING, "radius": RADII, "size": 4, **change}
    other = iv.sweeps.geared_sweep(options.pop("study"), sets=shelf, **options)
    with pytest.raises(iv.InputError, match=message):
        iv.sweep(other, swept.folder, resume=True)


def test_options_that_do_not_fit_are_refused(shelf):
    with pytest.raises(iv.ParameterError, match="stages and radius are both given"):
        iv.sweeps.geared_sweep(
            WALKING, sets=shelf, stages=[WALKING.drives["geared"].pulley], radius=RADII, drive="geared"
        )
    with pytest.raises(iv.ParameterError, match="radii must be a whole number >= 2, got 1"):
        iv.sweeps.geared_sweep(WALKING, sets=shelf, radii=1)
    with pytest.raises(iv.ParameterError, match="size must be >= 1, got 0"):
        iv.sweeps.geared_sweep(WALKING, sets=shelf, size=0)
