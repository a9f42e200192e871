"""The public search for the best drives of a study: against the search it calls, and the analyses of single drives."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.parts import Screw
from internals import (
    candidates,
    motion_file,
    not_simulated,
    operated,
    scenario_of,
    size_geared,
    study_of,
)
from internals import pool_of_parts as pool
from made import loaded
from nearest import nearest_geared
from part_tables import part_tables
from small_catalogue import SHELF, changed

KNEE = loaded("knee_walking")
WALKING = replace(KNEE.with_drives("geared"), requirement=None)
"""With the requirement no pair of the shelf is feasible."""
RADII = (0.003, 0.05)


@pytest.fixture(scope="module")
def said():
    return []


@pytest.fixture(scope="module")
def found(shelf, said):
    return iv.size(WALKING, sets=shelf, radius=RADII, progress=lambda *words: said.append(words))


def test_designs_are_those_of_the_search_and_name_their_parts(found, shelf):
    parts = iv.load_parts(shelf)
    tables = [{**parts.tables[kind].columns, "name": parts.tables[kind]["key"]} for kind in ("motors", "gearheads")]
    options = {"duty": KNEE.duty, "radius": RADII}
    for designs, objective in ((found.designs, "energy"), (found.front, "front")):
        there = size_geared(KNEE.drives["geared"], *tables, parts.pairs, objective=objective, **options).designs
        assert [(parts.motors["key"][one.motor], parts.gearheads["key"][one.gearhead]) for one in there] == [
            (one.parts["motor"].key, one.parts["gearhead"].key) for one in designs
        ]
        for name in ("power", "mass", "margin"):
            np.testing.assert_array_equal(*([getattr(one, name) for one in some] for some in (there, designs)))
    part = next(one.parts["motor"] for one in found.designs if one.parts["motor"].key == "b")
    assert part.where == "shelf:b, Made Up 11, data sheet 7, 2024-05"
    assert part.name == "B"
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_simulated_design_needs_the_energy_it_was_chosen_for(found, tmp_path):
    walking = KNEE.duty["walking"]
    (tmp_path / "walking.csv").write_text(motion_file(walking), "utf-8")
    scenario = scenario_of(walking, tmp_path / "walking.csv")
    run = iv.simulate(found.best.drive, scenario)
    half = len(run.trajectory.time) // 2
    drawn = sum(values[-1] - values[half] for name, values in run.trajectory.supplied.items() if "supply" in name)
    assert run.trajectory.time[-1] - run.trajectory.time[half] == pytest.approx(walking.period, rel=1e-9)
    assert drawn / walking.period == pytest.approx(found.best.power, rel=0.05)
    assert run.to_dict()["supplied_after_settling_J"] == pytest.approx(drawn, rel=1e-9)


@pytest.mark.slow
def test_a_simulated_design_is_judged_as_it_was_chosen(found, tmp_path):
    """Root mean squares of the second cycle are those of the duty cycle, for motor and gearhead."""
    walking = KNEE.duty["walking"]
    (tmp_path / "walking.csv").write_text(motion_file(walking), "utf-8")
    drive = found.best.drive
    drive = replace(drive, gearhead=replace(drive.gearhead, continuous_torque=1.0, intermittent_torque=None))
    run = iv.simulate(drive, scenario_of(walking, tmp_path / "walking.csv"))
    # Simulated windings are cold, which has no effect on the current.
    demands = iv.duty_cycle(drive, walking).demands
    assert {key[1] for key in run.root_mean_squares} == {"motor", "gearhead"}
    for key, share in run.root_mean_squares.items():
        assert share == pytest.approx(demands[key], rel=0.02)


@pytest.mark.slow
def test_a_motion_is_a_scenario_where_it_can_be_simulated(found, shelf, tmp_path):
    """Behind a series spring the load needs a moment of inertia: said beforehand, as simulate would."""
    walking = KNEE.duty["walking"]
    path = tmp_path / "walking.csv"
    path.write_text(motion_file(walking), "utf-8")
    soft = replace(found.best.drive, output=iv.Output(series_spring=iv.parts.Spring(stiffness=6e4)))
    heavy = replace(walking, **{"load_inertia" if walking.axis.rotary else "load_mass": 0.05})
    for drive, duty, able in ((soft, walking, False), (soft, heavy, True), (found.best.drive, walking, True)):
        design = replace(found.best, drive=drive)
        study = replace(KNEE, duty={"walking": duty}, scenarios={})
        made = study_of(study, design, "x", {"walking": scenario_of(duty, path)})
        assert set(made.scenarios) == ({"walking"} if able else set())
        assert (not_simulated(drive, duty) is None) == able
        short = replace(scenario_of(duty, path), duration=0.01, settling_time=None)
        if able:
            assert iv.simulate(drive, short).trajectory.time[-1] == pytest.approx(0.01)
        else:
            with pytest.raises(iv.ParameterError, match=r"load_(mass|inertia) is missing"):
                iv.simulate(drive, short)
    stiff = replace(KNEE.drives["geared"], output=soft.output)
    study = replace(WALKING, drives={"geared": stiff})
    (said,) = [line for line in iv.size(study, sets=shelf, radius=RADII, top=1).cautions if "scenario" in line]
    assert said.startswith("duty.walking is not written as a scenario of designs like geared: behind a series spring")


def test_without_motions_the_least_mass_is_found():
    study = replace(
        KNEE.with_drives("geared"), duty={}, requirement=iv.Requirement(force=60.0, speed=0.2, power=6.0, travel=0.08)
    )
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


@pytest.mark.slow
def test_the_nearest_miss_is_nearest_of_all():
    motors, gearheads, pairs = part_tables(3, motors=5, gearheads=4)
    template = replace(KNEE.drives["geared"])
    region = iv.Requirement(force=900.0, speed=0.6, power=200.0)
    options = {"duty": {}, "requirement": region, "travel": 0.08}
    assert not size_geared(template, motors, gearheads, pairs, objective="mass", radius=RADII, **options).designs
    nearest = nearest_geared(template, motors, gearheads, pairs, radius=RADII, **options)
    # Every pair at many radii by the law of one drive, at fewer points of the region, its corners included.
    speed, force, _ = region.sample(21)

    def margin(drive, speed, force):
        return 1.0 / max(
            float(np.max(demand)) for demand in operated(drive, speed=speed, force=force).utilisation.values()
        )

    best = 0.0
    for radius in np.geomspace(*RADII, 40):
        stage = replace(template.pulley, radius=float(radius))
        found = candidates(template, motors, gearheads, pairs, loss_model="coulomb", moving=False, stated=())
        best = max(best, *(margin(found.drive(int(row), stage), speed, force) for row in found.usable))
    assert nearest.margin < 1.0
    assert best <= nearest.margin * 1.001
    assert nearest.margin == pytest.approx(best, rel=0.03)
    speed, force, _ = region.sample()
    assert margin(nearest.drive, speed, force) == pytest.approx(nearest.margin, rel=1e-9)


@pytest.mark.slow
def test_travel_does_not_decide_which_miss_is_nearest(shelf):
    study = replace(WALKING, requirement=iv.Requirement(force=10.0, speed=0.1, travel=0.008))
    made = iv.size(study, sets=shelf, radius=RADII)
    assert not made.feasible
    assert [limit.name for _, limit, _ in made.nearest.exceeded] == ["TRAVEL"]
    assert "travel, walking" in made.verdict
    assert made.to_dict()["searches"]["geared"]["nearest"]["tightest"] == "travel, walking"


def test_a_radius_at_the_end_of_its_range_is_said(found, shelf):
    assert not any("end of the range" in one for one in found.cautions)
    narrow = iv.size(WALKING, sets=shelf, radius=(0.0062, 0.05), objective="energy", top=1)
    assert any(one.startswith("pulley radius of the best design is at an end of the range") for one in narrow.cautions)


def test_progress_is_of_both_searches(found, said):
    assert said[0] == ("no feasible design yet", 0.0)
    shares = [share for _, share in said]
    assert shares == sorted(shares)
    assert 0.5 in shares
    assert max(shares) <= 1.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"objective": "speed"},
            "objective must be energy, mass, space or price, or energy and mass together, got speed",
        ),
        ({"objective": ()}, "objective must be energy, mass, space or price, or energy and mass together, got none"),
        ({"drive": ()}, "drive must name at least one drive"),
        ({"drive": "cobotic", "radius": (0.01, 0.02)}, "no geared drive is searched"),
        ({"drive": "geared", "steering_ratios": (8.0,)}, "no cobotic drive is searched"),
        ({"drive": "geared", "slip_margin": 1.5, "life": 3600.0}, "slip_margin, life: for cobotic drives only"),
        ({"drive": "geared", "generations": 3, "seed": 0}, "generations, seed: for cobotic drives only"),
        ({"ranges": {"preloads": (1.0, 2.0)}}, "unknown entry 'preloads' (did you mean 'preload'"),
        ({"ranges": {"preload": (2.0, 1.0)}}, "must be a range above 0"),
        ({"steering_ratios": (0.0,)}, "steering_ratios must be one ratio or several different ones, each > 0, got"),
        ({"wheels": (4,)}, "wheels must be one or several of 1, 2 and 3, each once, got"),
        ({"wheels": (2.5,)}, "wheels must be one or several of 1, 2 and 3, each once, got"),
        ({"wheels": ()}, "wheels must be one or several of 1, 2 and 3, each once, got"),
        ({"drive": "geared", "wheels": (2,)}, "no cobotic drive is searched"),
        ({"generations": 0}, "generations must be a whole number >= 1"),
        ({"seed": -1}, "seed must be a whole number >= 0"),
        ({"slip_margin": 0.5, "drive": "cobotic"}, "slip_margin must be >= 1"),
        ({"life": -1.0, "drive": "cobotic"}, "life must be > 0 s"),
        ({"drive": "gaered"}, "did you mean 'geared'"),
        ({"top": 0}, "top must be >= 1"),
        ({"radius": (0.02, 0.01)}, "radius must be a range above 0"),
        ({"sets": "shiped"}, "'shiped' is not a set of parts"),
        ({"sets": []}, "sets must name at least one set of parts"),
        ({"loss_model": "stribeck"}, "loss_model must be coulomb, proportional or strain wave"),
    ],
)
def test_wrong_arguments_are_named(options, message):
    with pytest.raises(iv.InputError, match=message.replace("(", r"\(")):
        iv.size(KNEE, **{"sets": "shipped", **options})


def test_what_a_study_lacks_is_named():
    with pytest.raises(iv.InputError, match=r"\[duty.NAME\]"):
        iv.size(replace(KNEE, duty={}), objective="energy", sets="shipped")
    unable = replace(KNEE.with_drives("cobotic"), drives={"cobotic": replace(KNEE.drives["cobotic"], steering=None)})
    with pytest.raises(iv.InputError, match=r"drives.cobotic was not searched: steering is missing"):
        iv.size(unable, sets="shipped")
    with pytest.raises(iv.InputError, match=r"drives.cobotic cannot be a template: steering is missing"):
        iv.size(unable, sets="shipped", drive="cobotic")
    with pytest.raises(iv.InputError, match="both missing"):
        iv.size(replace(KNEE, duty={}, requirement=None), sets="shipped")


def test_a_result_is_frozen_and_shows_itself(found, tmp_path):
    assert found == found
    assert len(repr(found).split("\n")) <= 10
    table = found.to_dataframe()
    assert list(table["motor"]) == [one.parts["motor"].part for one in found.designs]
    assert found.plot().axes[0].get_ylabel() == "mean power from the supply [W]"


def test_contradictions_of_the_designs_and_sets_that_cannot_be_read_are_noted(tmp_path, monkeypatch):
    """A winner by figures that contradict each other says so; a bad file does not keep the other sets from being searched."""
    path = tmp_path / "odd.toml"
    path.write_text(SHELF.replace("[motors.b]", '[motors.b]\nstated_no_load_speed = "500 rpm"'), "utf-8")
    found = iv.size(WALKING, objective="mass", sets=path, radius=RADII, top=1)
    assert found.best.parts["motor"].key == "b"
    said = [line for line in found.cautions if "contradicts itself" in line]
    assert len(said) == 1
    assert said[0].startswith("the data sheet contradicts itself: odd, motor b: no-load speed 500 rpm is stated, but")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("INFINIVAR_PARTS", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "bad.npz").write_bytes(b"PK nonsense")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "shelf.toml").write_text(SHELF, "utf-8")
    parts = pool(None, [tmp_path / "parts"])
    assert {one.name for one in parts.sets} == {"shelf", "shipped"}
    assert [line.partition(":")[0] for line in parts.unread] == ["the set bad was left out, as it cannot be read"]


@pytest.mark.slow
def test_pairs_that_cannot_be_judged_are_not_called_infeasible(tmp_path):
    path = tmp_path / "light.toml"
    path.write_text("\n".join(line for line in SHELF.splitlines() if not line.startswith("mass")), "utf-8")
    found = iv.size(WALKING, objective="mass", sets=path, radius=RADII)
    assert found.verdict == "none of 7 pairs of light can be judged: motor mass not stated (7)"
    assert found.nearest is None
    assert iv.size(WALKING, objective="energy", sets=path, radius=RADII).feasible


def test_a_radius_is_of_a_pulley(shelf):
    screw = replace(
        KNEE.drives["geared"], pulley=None, screw=Screw(shape="ball", lead=0.004, diameter=0.012, efficiency=0.9)
    )
    with pytest.raises(iv.InputError, match="radius: the template has no pulley, but a screw, which stays as it is"):
        iv.size(replace(WALKING, drives={"geared": screw}), sets=shelf, radius=RADII)


def test_a_search_keeps_the_number_of_motors_on_the_shaft(tmp_path):
    """Two motors on one shaft stay two; a scale that is no whole number is a motor of another size, which is replaced."""
    tables = {"base": "faulring2006.motor2-gear4", "motor": {"part": "dc-max-26-s-24v", "scale": 2}}
    need = {"force": "40 N", "speed": "0.3 m/s"}
    study = iv.Study.from_dict({"requirement": need, "drives": {"geared": tables}}, name="two")
    design = iv.size(study, sets="shipped", builds=0, objective="mass", top=1).designs[0]
    single = (
        iv.Study.from_dict(
            {"requirement": need, "drives": {"geared": {**tables, "motor": {"part": design.parts["motor"].key}}}},
            name="one",
        )
        .drives["geared"]
        .motor
    )
    assert design.drive.motor.mass == 2 * single.mass
    assert design.drive.motor == single.scaled(2)
    assert design.drive.motor.diameter == single.diameter
    assert design.title.startswith(f"2 x {single.name}")
    again = iv.load_study(iv.save_study(study_of(study, design, "design"), tmp_path / "design.toml"))
    assert again.drives["geared"].motor.continuous_torque == 2 * single.continuous_torque
    tables["motor"]["scale"] = 2.7
    study = iv.Study.from_dict({"requirement": need, "drives": {"geared": tables}}, name="larger")
    assert not iv.size(study, sets="shipped", builds=0, objective="mass", top=1).designs[0].title.startswith("2.7 x")


@pytest.mark.slow
def test_a_design_keeps_all_of_its_template_but_what_was_searched(shelf):
    """Parts of sets replace those of the template whole; what they do not state and the template has is said."""
    own = KNEE.drives["geared"]
    template = replace(
        own,
        motor=replace(own.motor, viscous_friction=3e-6),
        gearhead=replace(own.gearhead, stiffness=900.0, backlash=0.01),
        amplifier=replace(own.amplifier, efficiency=0.9, standby_power=0.7),
        guideway=replace(own.guideway, friction=3.0, coefficient=0.01),
        output=replace(own.output, parallel_spring=iv.parts.Spring(stiffness=300.0)),
        output_inertia=3e-6,
        control=replace(own.control, sample_rate=2000.0, speed_bandwidth=20.0),
    )
    assert template.pulley.bearings is not None
    study = replace(WALKING, drives={"geared": template})
    found = iv.size(study, sets=shelf, radius=RADII, objective="energy", top=1)
    searched = {path for path in changed(template, found.best.drive) if not path.startswith(("motor.", "gearhead."))}
    assert searched == {"pulley.radius"}
    walking = iv.duty_cycle(found.best.drive, study.duty["walking"])
    assert found.best.power == pytest.approx(walking.power_in, rel=1e-12)
    assert found.notes[:2] == (
        "drives.geared: designs like it do not count viscous_friction of its motor, which c does not state",
        "drives.geared: designs like it do not count stiffness and backlash of its gearhead, which p5 does not state",
    )
    assert not [one for one in iv.size(WALKING, sets=shelf, radius=RADII, top=1).notes if "do not count" in one]
