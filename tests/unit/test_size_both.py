"""The public search over geared and cobotic drives together: against the analyses of single drives."""

import importlib.util
import itertools
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from internals import AXLE_BEARING, STEERING_MOTOR, motion_file, of_cobotic, scenario_of, value_at, with_values
from made import loaded
from small_catalogue import SLOW, changed

ROOT = Path(__file__).parents[2]
KNEE = loaded("knee_walking")
WALKING = replace(KNEE, requirement=None)
RANGES = {"preload": (1800.0, 2600.0), "wheel_radius": (0.018, 0.03), "crown_radius": (0.025, 0.025)}
ASKED = {"generations": 5, "radius": (0.003, 0.05), "ranges": RANGES, "steering_ratios": (16.0,), "top": 4}


@pytest.fixture(scope="module")
def shelf(tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "shelf.toml"
    path.write_text(SLOW, "utf-8")
    return path


@pytest.fixture(scope="module")
def said():
    return []


@pytest.fixture(scope="module")
def found(shelf, said):
    return iv.size(WALKING, sets=shelf, progress=lambda *words: said.append(words), **ASKED)


@pytest.mark.slow
def test_designs_of_both_are_in_one_order(found, said):
    assert list(found.searches) == ["geared", "cobotic"]
    powers = [one.power for one in found.designs]
    assert powers == sorted(powers)
    assert len(powers) == 4
    assert {name: one.template for name, one in found.best_of.items()} == {"geared": "geared", "cobotic": "cobotic"}
    assert found.best.power == min(one.power for one in found.best_of.values())
    assert {one.architecture for one in found.best_of.values()} == {"geared", "cobotic"}
    for one, two in itertools.pairwise(found.front):
        assert two.power > one.power
        assert two.mass < one.mass
    clouds = np.concatenate([record.cloud for record in found.searches.values()])
    for mass, power in clouds[np.isfinite(clouds).all(axis=1)]:
        # The cloud has links with the steering motor of the template, designs of the front with their own; of those within 3 %
        # of the mass of another, the front lists one.
        reached = any(one.mass <= mass * 1.05 and one.power <= power * 1.02 for one in found.front)
        assert reached, (mass, power)
    shares = [share for _, share in said]
    assert shares == sorted(shares)
    words = [one for one, _ in said]
    assert any(one.startswith("cobotic: best so far: ") and one.endswith(" W") for one in words)
    assert any(one.startswith("cobotic: best so far: ") and one.endswith(" kg") for one in words)
    assert words[-1] == "what would have to change"


@pytest.mark.slow
def test_a_design_as_a_study_says_what_it_is(found):
    """Statements of the study on the machine that the template was are no longer there."""
    for name, design in found.best_of.items():
        study = found.study_of(design, "winner")
        assert study.title.startswith(KNEE.title)
        assert f"for the study knee_walking, with its drive {name} as the template" in study.description
        assert "larger wheel" not in study.description
        assert not {*study.reconstruction} & {*KNEE.reconstruction}
        text = study.to_toml()
        assumed = sum(
            row.kind == "assumed" and "search" not in row.where and row.owner == name and row.where != "program default"
            for row in study.provenance
        )
        assert 0 < assumed <= int(study.reconstruction[0].split("takes over ")[1].split()[0])
        if name == "geared":
            drive = text[text.index("[drives.geared]") : text.index("[drives.geared.motor]")]
            assert 'where = "pulley and cable"\n' not in drive
            assert 'output_inertia = { value = "0.02 g m^2", kind = "assumed", where = "pulley and cable" }' in drive
            assert "Searched: motor, gearhead and pulley radius." in study.description


@pytest.mark.slow
def test_the_geared_side_is_that_of_a_search_of_its_own(found, shelf):
    alone = iv.size(WALKING, sets=shelf, drive="geared", radius=ASKED["radius"], top=4)
    assert found.best_of["geared"] == alone.best
    assert found.searches["geared"].left == alone.searches["geared"].left
    assert set(alone.searches) == {"geared"}


@pytest.mark.slow
def test_a_cobotic_design_as_a_study_compares_and_loads_again(found, tmp_path):
    best = found.best_of["cobotic"]
    study = found.study_of(best, "best")
    again = iv.load_study(study.save(tmp_path / "best.toml"))
    assert again == study
    cycle = iv.compare(again, quick=True).duty["walking"].results["cobotic"]
    assert cycle.feasible
    assert cycle.power_in == pytest.approx(best.power, rel=1e-9)
    slip = cycle.demands[Limit.SLIP, "wheel"]
    assert best.demands["walking", Limit.SLIP, "wheel"] == pytest.approx(1.1 * slip, rel=1e-9)


@pytest.mark.slow
def test_a_cobotic_design_keeps_all_of_its_template_but_what_was_searched(found):
    """The speed loop of the cylinder holds the constant speed that the search assumes, as its provenance says."""
    own, best = KNEE.drives["cobotic"], found.best_of["cobotic"].drive
    assert own.cylinder_bearings is not None
    bearings = ("transmission.geometry.axle_bearing.", "cylinder_bearings.bearing.")
    parts = ("motor.", "gearhead.", "steering.motor.", *bearings)
    others = {path for path in changed(own, best) if not path.startswith(parts)}
    free = {*found.best_of["cobotic"].free}
    tube = {f"transmission.cylinder_{name}" for name in ("wall", "length", "end_plate")}
    inertias = {"link_mass", "cylinder_inertia", "steering.bell_inertia", "steering.derived_inertia"}
    assert others <= {*free, *tube, *inertias, "control.cylinder_bandwidth", "steering.bells"}
    assert {"transmission.preload", "control.cylinder_bandwidth"} <= others
    rows = {row.field: row for row in found.study_of(found.best_of["cobotic"]).provenance}
    assert rows["control.cylinder_bandwidth"].where.startswith("as fast as the steering servo")
    assert all(rows[path].kind == "derived" for path in tube)
    assert not inertias & {*rows}
    assert best.mass_of_link == pytest.approx(own.mass_of_link, rel=0.8)


@pytest.mark.slow
def test_a_simulated_cobotic_design_needs_the_energy_it_was_chosen_for(found, tmp_path):
    walking, best = KNEE.duty["walking"], found.best_of["cobotic"]
    (tmp_path / "walking.csv").write_text(motion_file(walking), "utf-8")
    run = iv.simulate(best.drive, scenario_of(walking, tmp_path / "walking.csv"))
    half = len(run.trajectory.time) // 2
    drawn = sum(values[-1] - values[half] for name, values in run.trajectory.supplied.items() if "supply" in name)
    assert drawn / walking.period == pytest.approx(best.power, rel=0.05)
    assert run.verdict.startswith("within limits")


@pytest.mark.slow
def test_sources_of_nested_parts_and_values(found):
    best = found.best_of["cobotic"]
    rows = {row.field: row for row in found.study_of(best).provenance if row.owner == "cobotic"}
    part = best.parts[STEERING_MOTOR]
    assert rows[f"{STEERING_MOTOR}.resistance"].where == part.where
    assert rows["motor.resistance"].where == best.parts["motor"].where
    assert rows["transmission.preload"].kind == "derived"
    assert "search over parts" in rows["transmission.geometry.crown_radius"].where
    assert rows["steering.ratio"].value == 16.0
    assert rows["transmission.friction"] == next(
        row for row in KNEE.provenance if (row.owner, row.field) == ("cobotic", "transmission.friction")
    )
    assert rows["control.cylinder_bandwidth"].kind == "assumed"
    assert "constant speed" in rows["control.cylinder_bandwidth"].where
    assert best.drive.control.cylinder_bandwidth == KNEE.drives["cobotic"].control.steering_bandwidth
    for path, free in best.free.items():
        assert value_at(best.drive, path) == free.value
    for role, part in best.parts.items():
        assert value_at(best.drive, role).name == part.name
    # A bearing of the set brings its dimensions, the friction model stays that of the template.
    other = replace(best, parts={**best.parts, AXLE_BEARING: replace(part, key="wide", where="shelf:wide")})
    rows = {row.field: row for row in found.study_of(other).provenance if row.owner == "cobotic"}
    assert rows[f"{AXLE_BEARING}.bore"].where == "shelf:wide"
    assert rows[f"{AXLE_BEARING}.friction_model"].where == "knee_walking.toml"


@pytest.mark.slow
def test_bearings_are_those_of_the_set_that_fit_the_axle(found):
    assert found.searches["cobotic"].bearings == ("6000", "wide", "narrow")


@pytest.mark.slow
def test_spreads_of_nested_parts_are_left_out(found):
    best = found.best_of["cobotic"]
    spread = {
        "steering.motor.resistance": "5 %",
        "motor.resistance": "5 %",
        "transmission.friction": "10 %",
        "transmission.preload": "2 %",
    }
    text = (ROOT / "studies" / "knee_walking.toml").read_text("utf-8")
    lines = "\n".join(f'"{path}" = "{value}"' for path, value in spread.items())
    study = iv.Study.from_dict(tomllib.loads(f"{text}\n[uncertainty.cobotic]\n{lines}\n"), name="spread")
    study = replace(study, requirement=None)  # its travel is longer than the cylinder of a design for the motion alone
    kept = replace(found, study=study).study_of(best).uncertainty.spreads["cobotic"]
    assert [one.path for one in kept] == ["transmission.friction"]


@pytest.mark.slow
def test_the_nearest_cobotic_miss_exceeds_what_it_says(shelf):
    heavy = replace(WALKING.with_drives("cobotic"), requirement=None)
    weak = {**ASKED, "ranges": {**RANGES, "preload": (300.0, 400.0)}}
    weak.pop("radius")
    made = iv.size(heavy, sets=shelf, objective="energy", **weak)
    nearest = made.nearest
    assert not made.feasible
    assert made.searches["cobotic"].nearest == nearest
    assert next(iter(nearest.exceeded))[1] == Limit.SLIP
    assert "wheel slip" in made.verdict
    assert "no steady rolling" in made.verdict
    assert sum(made.searches["cobotic"].blocked.values()) > 0
    # With the friction that it is said to need, times the margin, the wheel rolls, and with less it slips or has less margin.
    change = made.what_if["cobotic"]
    (needed,) = change.allowances
    assert needed.words == "friction limit of the contact"
    for factor, enough in ((1.0, True), (0.98, False)):
        drive = with_values(nearest.drive, {"transmission.friction": factor * needed.needed})
        demand = iv.duty_cycle(drive, KNEE.duty["walking"]).demands[Limit.SLIP, "wheel"]
        assert (1.1 * demand <= 1.0 + 1e-6) == enough
    assert change.lines[0].startswith("enough for the wheel; ")
    none = replace(change, allowances=(replace(needed, needed=float("nan")),))
    assert none.lines[0].startswith("not enough for the wheel; ")


@pytest.mark.full
def test_the_nearest_miss_has_the_motors_nearest_to_feasible(tmp_path):
    weak = SLOW.replace('voltage = "24 V"', 'voltage = "3 V"')
    (tmp_path / "weak.toml").write_text(weak, "utf-8")
    options = {**ASKED, "generations": 2}
    options.pop("radius")
    made = iv.size(WALKING.with_drives("cobotic"), sets=tmp_path / "weak.toml", objective="energy", **options)
    assert not made.feasible
    nearest = made.nearest
    assert set(nearest.parts) >= {"motor", "gearhead", STEERING_MOTOR}
    cycle = iv.duty_cycle(nearest.drive, KNEE.duty["walking"])
    for (_, limit, part), demand in nearest.exceeded.items():
        if limit != Limit.SLIP:
            assert cycle.demands[limit, part] == pytest.approx(demand, rel=1e-6)
    # No other motors behind the same wheel come nearer.
    parts = iv.load_parts(tmp_path / "weak.toml")
    worst = max(demand for (_, _, part), demand in nearest.demands.items() if part in ("motor", "gearhead"))
    for motor, gear in parts.pairs:
        other = replace(
            nearest.drive,
            motor=parts.motors.part(int(motor)),
            gearhead=replace(parts.gearheads.part(int(gear)), loss_model=nearest.drive.gearhead.loss_model),
        )
        demands = iv.duty_cycle(other, KNEE.duty["walking"]).demands
        assert max(demands[key] for key in demands if key[1] in ("motor", "gearhead")) >= worst * (1.0 - 1e-9)


@pytest.mark.slow
def test_records_as_plain_numbers(found):
    stated = found.to_dict()
    record = stated["searches"]["cobotic"]
    assert record["candidates"] == len(found.sets) * 12 * 3 * 3 * 3 * 3  # with wheels and bearings of the cylinder
    assert record["ranges"]["transmission.preload"] == [1800.0, 2600.0]
    history = [one for one in record["history"] if one is not None]
    # The search has links with the steering motor of the template, 66 g, the design has its own, of up to 310 g.
    assert history[-1] == pytest.approx(found.best_of["cobotic"].power, rel=0.05)
    assert {one["template"] for one in stated["best_of"].values()} == {"geared", "cobotic"}
    assert not record["compiled"]
    assert list(found.to_dataframe()["template"]) == [one.template for one in found.designs]
    assert found.plot().axes[0].get_xlabel() == "mass of the whole drive [g]"


@pytest.mark.slow
def test_costless_ends_of_ranges_are_named(shelf):
    made = iv.size(
        WALKING.with_drives("cobotic"),
        sets=shelf,
        objective="energy",
        **{**ASKED, "radius": None, "ranges": {**RANGES, "wheel_radius": (0.0235, 0.0236)}},
    )
    assert any(one.startswith("wheel radius of the best design is at an end") for one in made.cautions)
    assert not any(one.startswith("crown radius of the best") for one in made.cautions)  # a fixed value has no end


def test_a_drive_that_cannot_be_searched_is_named(shelf):
    unable = replace(WALKING.drives["cobotic"], steering=None)
    study = replace(WALKING, drives={**WALKING.drives, "cobotic": unable})
    made = iv.size(study, sets=shelf, radius=ASKED["radius"], objective="mass", top=1)
    assert list(made.searches) == ["geared"]
    assert any(one.startswith("drives.cobotic was not searched: steering is missing") for one in made.cautions)
    assert np.isfinite(made.best.mass)


def test_laws_are_compiled_only_where_it_pays(monkeypatch):
    """With JAX, and with enough wheel designs to pay for compiling."""
    known = {"jax": True}
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: known.get(name) or None)
    assert of_cobotic._method(40) == "numpy"
    assert of_cobotic._method(2000) == "jax"
    known["jax"] = False
    assert of_cobotic._method(2000) == "numpy"
