"""The public search for the best drives of a study: against the search it calls, and the analyses of single drives."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from infinivar.drivetrain.drive import operated
from infinivar.sizing.geared import nearest_geared, size_geared
from infinivar.sizing.geared.candidates import candidates
from infinivar.sizing.pool import pool
from infinivar.sizing.studies import motion_file, scenario_of
from part_tables import part_tables
from shelves import SHELF

ROOT = Path(__file__).parents[2]
KNEE = iv.load_study(ROOT / "studies" / "knee_walking.toml")
WALKING = replace(KNEE, requirement=None)
"""With the requirement no pair of the shelf is feasible."""
RADII = (0.003, 0.05)


@pytest.fixture(scope="module")
def shelf(tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "shelf.toml"
    path.write_text(SHELF, "utf-8")
    return path


@pytest.fixture(scope="module")
def said():
    return []


@pytest.fixture(scope="module")
def found(shelf, said):
    return iv.size(WALKING, sets=shelf, radius=RADII, progress=lambda *words: said.append(words))


def test_designs_are_those_of_the_search_and_name_their_parts(found, shelf):
    parts = iv.load_parts(shelf)
    tables = [{**parts.tables[kind].columns, "name": parts.tables[kind]["key"]} for kind in ("motors", "gearheads")]
    asked = {"duty": KNEE.duty, "radius": RADII}
    for designs, objective in ((found.designs, "energy"), (found.front, "front")):
        there = size_geared(KNEE.drives["geared"], *tables, parts.pairs, objective=objective, **asked).designs
        assert [(parts.motors["key"][one.motor], parts.gearheads["key"][one.gearhead]) for one in there] == [
            (one.parts["motor"].key, one.parts["gearhead"].key) for one in designs
        ]
        for name in ("power", "mass", "margin"):
            np.testing.assert_array_equal(*([getattr(one, name) for one in some] for some in (there, designs)))
    part = next(one.parts["motor"] for one in found.designs if one.parts["motor"].key == "a")
    assert part.where == "shelf:a, Made Up 10, data sheet 7, 2024-05"
    assert part.name == "A"
    assert found.best.power == min(one.power for one in found.designs)
    record = found.searches["geared"]
    assert record.candidates == 7
    assert record.excluded == {"gearhead mass not stated: left out of the front": 1}
    assert record.evaluated <= record.left <= record.candidates
    assert len(found.designs) == record.left


def test_no_design_of_the_front_is_beaten(found):
    values = np.array([(one.mass, one.power) for one in found.front])
    for mass, power in values:
        assert not ((values <= [mass, power]).all(axis=1) & (values < [mass, power]).any(axis=1)).any()
    known = np.concatenate([found.searches["geared"].cloud, values])
    for mass, power in known[np.isfinite(known).all(axis=1)]:
        assert ((values <= [mass * (1 + 1e-9), power * (1 + 1e-9)]).all(axis=1)).any()


def test_each_design_as_a_study_compares_and_loads_again(found, tmp_path):
    for place, design in enumerate((*found.designs[:2], found.front[-1])):
        study = found.study_of(design, f"d{place}")
        again = iv.load_study(study.save(tmp_path / f"d{place}.toml"))
        assert again == study
        assert list(again.drives) == ["geared"]
        cycle = iv.compare(again, quick=True).duty["walking"].results["geared"]
        assert cycle.feasible
        assert cycle.power_in == pytest.approx(design.power, rel=1e-9)


def test_sources_of_a_design_are_those_of_its_parts(found):
    design = next(one for one in found.designs if one.parts["motor"].key == "c")
    rows = {row.field: row for row in found.study_of(design).provenance if row.owner == "geared"}
    assert rows["motor.torque_constant"].where.startswith("shelf:c, Made Up")
    assert rows["motor.voltage"].value == KNEE.drives["geared"].motor.voltage  # equal, yet not the template's
    assert rows["motor.voltage"].where.startswith("shelf:c")
    assert rows["gearhead.loss_model"].where == "knee_walking.toml"
    assert rows["pulley.radius"].kind == "derived"
    assert "search over parts" in rows["pulley.radius"].where
    assert rows["output_inertia"].where == "pulley and cable"
    assert all("dcx" not in row.where for row in rows.values())


def test_spreads_of_replaced_parts_are_left_out(shelf):
    tables = {
        "duty": {"w": {"shape": "sinusoid", "distance": "60 mm", "frequency": "1 Hz", "load_mass": "2 kg"}},
        "drives": {
            "geared": {
                "type": "conventional",
                "motor": {"part": "dcx-32-l-24v"},
                "gearhead": {"part": "gpx-32-up-16", "loss_model": "coulomb"},
                "pulley": {"radius": "8 mm"},
                "guideway": {"friction": "2 N"},
            }
        },
        "uncertainty": {
            "geared": {"motor.torque_constant": "5 %", "guideway.friction": "20 %", "pulley.radius": "1 %"}
        },
        "correlations": [{"drive": "geared", "between": ["motor.torque_constant", "guideway.friction"], "value": 0.5}],
    }
    study = iv.Study.from_dict(tables, name="spread")
    made = iv.size(study, sets=shelf, objective="mass", top=1)
    kept = made.study_of(made.best).uncertainty
    assert [one.path for one in kept.spreads["geared"]] == ["guideway.friction"]
    assert not kept.correlations
    made.study_of(made.best, "again").to_toml()  # refuses what does not load to the same


def test_a_simulated_design_needs_the_energy_it_was_chosen_for(found, tmp_path):
    walking = KNEE.duty["walking"]
    (tmp_path / "walking.csv").write_text(motion_file(walking), "utf-8")
    scenario = scenario_of(walking, tmp_path / "walking.csv")
    run = iv.simulate(found.best.drive, scenario)
    half = len(run.trajectory.time) // 2
    drawn = sum(values[-1] - values[half] for name, values in run.trajectory.supplied.items() if "supply" in name)
    assert run.trajectory.time[-1] - run.trajectory.time[half] == pytest.approx(walking.period, rel=1e-9)
    assert drawn / walking.period == pytest.approx(found.best.power, rel=0.05)


def test_without_motions_the_least_mass_is_found():
    study = replace(KNEE, duty={}, requirement=iv.Requirement(force=60.0, speed=0.2, power=6.0))
    made = iv.size(study, sets="shipped", top=3)
    assert made.objective == ("mass",)
    assert len(made.designs) == 3
    assert not made.front
    masses = [one.mass for one in made.designs]
    assert masses == sorted(masses)
    assert np.isnan(made.best.power)
    coverage = iv.compare(made.study_of(made.best), quick=True).results["geared"].coverage
    assert coverage == pytest.approx(1.0, abs=1e-9)


def test_pairs_of_several_sets_keep_to_their_set(shelf):
    both = pool(["shipped", shelf])
    shipped = iv.load_parts()
    assert len(both.pairs) == len(shipped.pairs) + 7
    last = [both.part("motors", int(both.pairs[-1, 0])), both.part("gearheads", int(both.pairs[-1, 1]))]
    assert [one.part for one in last] == ["shelf:c", "shelf:p35"]
    assert both.motors["resistance"][both.pairs[-1, 0]] == 0.35
    assert both.part("motors", 0).set == "shipped"
    assert [(one.name, one.pairs_stated) for one in both.sets] == [("shipped", False), ("shelf", True)]


def test_the_nearest_miss_is_nearest_of_all():
    motors, gearheads, pairs = part_tables(3, motors=5, gearheads=4)
    template = replace(KNEE.drives["geared"])
    region = iv.Requirement(force=900.0, speed=0.6, power=200.0)
    asked = {"duty": {}, "requirement": region}
    assert not size_geared(template, motors, gearheads, pairs, objective="mass", radius=RADII, **asked).designs
    nearest = nearest_geared(template, motors, gearheads, pairs, radius=RADII, **asked)
    # Every pair at many radii by the law of one drive, at fewer points of the region, its corners included.
    speed, force, _ = region.sample(21)

    def margin(drive, speed, force):
        return 1.0 / max(
            float(np.max(demand)) for demand in operated(drive, speed=speed, force=force).utilisation.values()
        )

    best = 0.0
    for radius in np.geomspace(*RADII, 40):
        stage = replace(template.pulley, radius=float(radius))
        found = candidates(template, motors, gearheads, pairs, loss_model="coulomb", moving=False, weighed=False)
        best = max(best, *(margin(found.drive(int(row), stage), speed, force) for row in found.usable))
    assert nearest.margin < 1.0
    assert best <= nearest.margin * 1.001
    assert nearest.margin == pytest.approx(best, rel=0.03)
    speed, force, _ = region.sample()
    assert margin(nearest.drive, speed, force) == pytest.approx(nearest.margin, rel=1e-9)


def test_travel_does_not_decide_which_miss_is_nearest(shelf):
    study = replace(WALKING, requirement=iv.Requirement(force=10.0, speed=0.1, travel=0.008))
    made = iv.size(study, sets=shelf, radius=RADII)
    assert not made.feasible
    assert [limit.name for _, limit, _ in made.nearest.exceeded] == ["TRAVEL"]
    assert "travel, walking" in made.verdict
    assert made.to_dict()["searches"]["geared"]["nearest"]["tightest"] == "travel, walking"


def test_a_radius_at_the_end_of_its_range_is_said(found, shelf):
    assert not any("end of the range" in one for one in found.cautions)
    narrow = iv.size(
        WALKING, sets=shelf, radius=(0.003, 0.9 * found.best.free["pulley.radius"].value), objective="energy", top=1
    )
    assert narrow.cautions[0].startswith("pulley radius of the best design is at an end of the range searched")


def test_progress_is_of_both_searches(found, said):
    assert said[0] == ("no feasible design yet", 0.0)
    shares = [share for _, share in said]
    assert shares == sorted(shares)
    assert 0.5 in shares
    assert max(shares) <= 1.0


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"objective": "speed"}, "objective must be energy, mass or both, got speed"),
        ({"objective": ()}, "objective must be energy, mass or both, got none"),
        ({"drive": "cobotic"}, "drives.cobotic cannot be a template"),
        ({"drive": "gaered"}, "did you mean 'geared'"),
        ({"top": 0}, "top must be >= 1"),
        ({"radius": (0.02, 0.01)}, "radius must be a range above 0"),
        ({"sets": "shiped"}, "'shiped' is not a set of parts"),
        ({"sets": []}, "sets must name at least one set of parts"),
        ({"loss_model": "stribeck"}, "loss_model must be coulomb or proportional"),
    ],
)
def test_wrong_arguments_are_named(asked, message):
    with pytest.raises(iv.InputError, match=message.replace("(", r"\(")):
        iv.size(KNEE, **{"sets": "shipped", **asked})


def test_what_a_study_lacks_is_named():
    with pytest.raises(iv.InputError, match=r"\[duty.NAME\]"):
        iv.size(replace(KNEE, duty={}), objective="energy", sets="shipped")
    with pytest.raises(iv.InputError, match=r"\[drives.NAME\] with type"):
        iv.size(KNEE.with_drives("cobotic"), sets="shipped")
    with pytest.raises(iv.InputError, match="both missing"):
        iv.size(replace(KNEE, duty={}, requirement=None), sets="shipped")


def test_a_result_is_frozen_and_shows_itself(found, tmp_path):
    assert found == found
    assert len(repr(found).split("\n")) <= 10
    table = found.to_dataframe()
    assert list(table["motor"]) == [one.parts["motor"].part for one in found.designs]
    assert found.plot().axes[0].get_ylabel() == "mean power from the supply [W]"
