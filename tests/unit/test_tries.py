"""Values of a template that `size` tries: each combination as a search of its own, and the best of all."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import TRIED_BESIDE, TRIED_FIRST, with_values
from made import loaded

KNEE = loaded("knee_walking")
GEARED = KNEE.drives["geared"]
SCREW = replace(GEARED, pulley=None, screw=iv.parts.Screw(lead=0.03, diameter=0.01, friction_coefficient=0.05))
SPRUNG = replace(SCREW, output=iv.Output(series_spring=iv.parts.Spring(stiffness=60e3)))
STUDY = replace(KNEE.with_drives("geared"), requirement=None, drives={"screw": SPRUNG}, titles={"screw": "Screw"})
LEADS, LEAD = "drives.screw.screw.lead", "screw.lead"
STIFFNESS = "output.series_spring.stiffness"
SPRING, MOTORS = f"drives.screw.{STIFFNESS}", "drives.screw.motor.scale"


def at(values):
    """The study with other values of its drive."""
    return replace(STUDY, drives={"screw": with_values(SPRUNG, values)})


def parts_of(design):
    return [(one.part, one.number) for one in design.parts.values()]


@pytest.fixture(scope="module")
def found(shelf):
    return iv.size(STUDY, sets=shelf, tries={LEADS: (0.02, 0.01, 0.04), SPRING: "20 N/mm, 100 N/mm"})


def test_every_combination_is_a_search_of_its_own(found, shelf):
    """The best of all, each combination of parts once with its best values, and one front without designs that are beaten."""
    combinations = list(itertools.product((0.01, 0.02, 0.04), (2e4, 1e5)))
    alone = {each: iv.size(at(dict(zip((LEAD, STIFFNESS), each, strict=True))), sets=shelf) for each in combinations}
    designs = sorted((one for each in alone.values() for one in each.designs), key=lambda one: one.power)
    first = {}
    for one in designs:
        first.setdefault(tuple(parts_of(one)), one)
    assert len(first) < len(designs)
    assert [one.drive for one in found.designs] == [one.drive for one in first.values()]
    assert found.best.power == designs[0].power
    assert {(one.mass, one.power) for one in found.front} <= {
        (one.mass, one.power) for each in alone.values() for one in each.front
    }
    record = found.searches["screw"]
    assert record.candidates == 7 * 6
    assert record.words == "42 candidates (7 pairs with 6 combinations of values each)"
    for name in ("left", "evaluated"):
        assert getattr(record, name) == sum(getattr(one.searches["screw"], name) for one in alone.values())
    excluded = {}
    for one in alone.values():
        for count in one.searches["screw"].counts:
            excluded[count[:3]] = excluded.get(count[:3], 0) + count.first
    assert {count[:3]: count.first for count in record.counts} == excluded
    assert len(record.cloud) == sum(len(one.searches["screw"].cloud) for one in alone.values())


def test_the_record_has_the_best_at_each_value(found):
    record = found.searches["screw"]
    assert [(one.path, one.value) for one in record.tried] == [
        (LEAD, 0.01),
        (LEAD, 0.02),
        (LEAD, 0.04),
        (STIFFNESS, 2e4),
        (STIFFNESS, 1e5),
    ]
    assert [one.candidates for one in record.tried] == [14, 14, 14, 21, 21]
    for path in (LEAD, STIFFNESS):
        able = [one for one in record.tried if one.path == path and one.feasible]
        assert min(one.power for one in able) == found.best.power
        assert all(one.design.free[path].value == one.value for one in able)
    rows = found.to_dict()["searches"]["screw"]["tried"]
    assert rows[1]["power_W"] == record.tried[1].power
    assert rows[1]["mass_kg"] == record.tried[1].mass
    assert rows[1]["unit"] == "m"


def test_a_design_says_what_was_tried_and_loads_again(found, tmp_path):
    free = found.best.free
    assert free[LEAD].tried == (0.01, 0.02, 0.04)
    assert free[STIFFNESS].words.endswith("N/mm (tried: 20 N/mm, 100 N/mm)")
    study = found.study_of(found.best)
    (row,) = [row for row in study.provenance if row.field == STIFFNESS]
    assert (row.kind, row.where) == ("derived", "search over parts, tried: 20 N/mm, 100 N/mm")
    again = iv.load_study(study.save(tmp_path / "best.toml"))
    assert again.drives["screw"].screw.lead == free[LEAD].value
    assert again.drives["screw"].output.series_spring.stiffness == free[STIFFNESS].value
    assert iv.compare(again, quick=True).duty["walking"].results["screw"].power_in == pytest.approx(found.best.power)
    ends = [one for one in found.cautions if "at an end of the values tried" in one]
    assert any(one.startswith("output series spring stiffness of the best design") for one in ends)


def test_a_range_is_refined_around_its_best(shelf):
    """Seven values in equal ratios, then two on each side of the best that has two neighbours."""
    made = iv.size(STUDY, sets=shelf, objective="energy", tries={LEADS: "4 mm..60 mm"})
    tried = [one.value for one in made.searches["screw"].tried]
    first = np.geomspace(0.004, 0.06, TRIED_FIRST)
    assert set(first) <= {*tried}
    assert len(tried) == TRIED_FIRST + 2 * TRIED_BESIDE
    assert tried == sorted(tried)
    powers = [one.power for one in made.searches["screw"].tried]
    best = int(np.nanargmin(powers))
    assert made.best.power == powers[best]
    assert made.best.free[LEAD].value == tried[best]
    coarse = min(first, key=lambda one: abs(math.log(one / tried[best])))
    assert tried[best] / coarse < (first[1] / first[0]) ** 0.51
    alone = iv.size(at({LEAD: tried[best]}), sets=shelf, objective="energy")
    assert alone.best.power == made.best.power
    assert not any("at an end of the values tried" in one for one in made.cautions)


def test_the_number_of_motors_on_a_shaft_is_tried(shelf, tmp_path):
    made = iv.size(STUDY, sets=shelf, tries={MOTORS: [1, 2, 3]}, objective="energy")
    each = {one.value: one for one in made.searches["screw"].tried}
    assert list(each) == [1.0, 2.0, 3.0]
    assert [one.design.parts["motor"].number for one in each.values()] == [1.0, 2.0, 3.0]
    alone = iv.size(STUDY, sets=shelf, objective="energy")
    assert each[1.0].power == alone.best.power
    assert each[1.0].design.drive == alone.best.drive
    two = each[2.0].design
    assert two.title.startswith("2 x ")
    assert two.free["motor.scale"].words == "2 (tried: 1, 2, 3)"
    study = made.study_of(two)
    assert "Searched: motor, gearhead and motors on one shaft." in study.description
    again = iv.load_study(study.save(tmp_path / "two.toml"))
    assert again.drives["screw"].motor == two.drive.motor
    assert iv.compare(again, quick=True).duty["walking"].results["screw"].power_in == pytest.approx(two.power)


def test_each_motor_has_an_amplifier_of_its_own(shelf, tmp_path):
    """Standby power of two amplifiers for two motors; a template of two motors states that of both."""
    idle = {"screw": with_values(SPRUNG, {"amplifier.standby_power": 0.5})}
    made = iv.size(replace(STUDY, drives=idle), sets=shelf, tries={MOTORS: [1, 2]}, objective="energy")
    without = iv.size(STUDY, sets=shelf, tries={MOTORS: [1, 2]}, objective="energy")
    more = [
        one.power - other.power
        for one, other in zip(made.searches["screw"].tried, without.searches["screw"].tried, strict=True)
    ]
    assert more == pytest.approx([0.5, 1.0])
    two = made.searches["screw"].tried[1].design
    again = iv.load_study(made.study_of(two).save(tmp_path / "two.toml"))
    assert again.drives["screw"].amplifier.standby_power == 1.0
    assert "an amplifier for each motor" in (tmp_path / "two.toml").read_text("utf-8")
    both = {MOTORS: [2], "drives.screw.amplifier.standby_power": [0.2]}
    stated = iv.size(replace(STUDY, drives=idle), sets=shelf, tries=both, objective="energy")
    assert stated.best.drive.amplifier.standby_power == 0.2


def test_teeth_of_a_range_are_whole(shelf):
    belt = replace(SCREW, screw=None, belt=iv.parts.Belt(pitch=0.003, teeth=16.0, efficiency=0.95))
    study = replace(STUDY, drives={"belt": belt})
    made = iv.size(study, sets=shelf, tries={"drives.belt.belt.teeth": "10..40"}, objective="energy")
    tried = [one.value for one in made.searches["belt"].tried]
    assert all(one.is_integer() for one in tried)
    assert (tried[0], tried[-1]) == (10.0, 40.0)
    assert len(tried) > TRIED_FIRST
    assert made.best.drive.belt.teeth == made.best.free["belt.teeth"].value


def test_where_nothing_is_feasible_the_nearest_of_all_is_found(shelf):
    weak = replace(STUDY, drives={"screw": with_values(SPRUNG, {"screw.permissible_force": 60.0})})
    made = iv.size(weak, sets=shelf, tries={LEADS: (0.01, 0.03)}, objective="energy")
    assert not made.feasible
    alone = [
        iv.size(
            replace(weak, drives={"screw": with_values(weak.drives["screw"], {LEAD: lead})}),
            sets=shelf,
            objective="energy",
        )
        for lead in (0.01, 0.03)
    ]
    assert made.nearest.margin == max(one.nearest.margin for one in alone)
    assert made.nearest.free[LEAD].tried == (0.01, 0.03)
    assert [one.feasible for one in made.searches["screw"].tried] == [False, False]
    assert all(math.isnan(one.power) and one.margin < 1.0 for one in made.searches["screw"].tried)


def test_cobotic_drives_are_searched_at_each_value():
    """Whole searches, with what each of them finds alone."""
    study = replace(KNEE.with_drives("cobotic"), requirement=None)
    options = {"sets": "shipped", "objective": "energy", "generations": 4, "top": 3}
    made = iv.size(study, tries={"drives.cobotic.transmission.friction": [0.08, 0.12]}, **options)
    drive = study.drives["cobotic"]
    alone = [
        iv.size(replace(study, drives={"cobotic": with_values(drive, {"transmission.friction": one})}), **options)
        for one in (0.08, 0.12)
    ]
    record = made.searches["cobotic"]
    for one, there in zip(record.tried, alone, strict=True):
        assert one.feasible == there.feasible
        if there.feasible:
            assert one.power == there.best.power
    assert record.wheels == sum(one.searches["cobotic"].wheels for one in alone)
    assert record.words.endswith("cobotic combinations (2 values of friction)")


@pytest.mark.parametrize(
    ("tries", "message"),
    [
        ({"screw.lead": [0.01]}, "tries: screw.lead must be drives.NAME.PATH, such as drives.screw.output"),
        ({"drives.screws.screw.lead": [0.01]}, "the study has no drive 'screws' (did you mean 'screw'?)"),
        ({"drives.other.screw.lead": [0.01]}, "drives.other is not searched, but screw; name it with drive"),
        ({"drives.screw.screw.led": [0.01]}, "drives.screw has no such value (did you mean 'screw.lead'?)"),
        ({"drives.screw.belt.teeth": [10]}, "drives.screw has no such value"),
        ({"drives.screw.screw": [10]}, "drives.screw has no such value"),
        (
            {"drives.screw.motor.resistance": [1.0]},
            "the search itself chooses the motor; only motor.scale can be tried",
        ),
        ({"drives.screw.gearhead.ratio": [5]}, "the search itself chooses the gearhead"),
        ({MOTORS: [1.5]}, f"{MOTORS} must be a whole number of motors, 1 or more, got 1.5"),
        ({MOTORS: "1, 2, 2"}, f"{MOTORS} must be different values, got 2 twice"),
        ({LEADS: []}, f"{LEADS} must be values, or a range LOW..HIGH"),
        ({LEADS: ""}, f"{LEADS} = '' must begin with a number"),
        ({LEADS: None}, f"{LEADS} must be values, or a range LOW..HIGH"),
        ({LEADS: ["fast"]}, f"{LEADS} = 'fast' must begin with a number"),
        ({LEADS: [math.nan]}, f"{LEADS} = 'nan' "),
        ({LEADS: [True]}, f"{LEADS} = 'True' "),
        ({LEADS: [-0.01]}, f"{LEADS} must be > 0, got -10 mm"),
        ({LEADS: "5 mm, 1 N"}, f"{LEADS} = '1 N' has the unit 'N' where m is needed"),
        ({LEADS: "5 mm..2 mm"}, "or a range LOW..HIGH above 0 with the least first, got '5 mm..2 mm'"),
        ({LEADS: "5 mm..6 mm..7 mm"}, "or a range LOW..HIGH above 0"),
        ({"drives.screw.screw.friction_coefficient": [-1]}, "must be >= 0, got -1"),
        ({"drives.screw.control.position_bandwidth": [5]}, "has no"),
        ({LEADS: np.geomspace(0.001, 0.1, 1001)}, "1,001 combinations of values for drives.screw; at most 1,000"),
        ([LEADS], "tries must be values by path"),
    ],
)
def test_what_cannot_be_tried_is_said_before_anything_is_computed(tries, message, monkeypatch):
    monkeypatch.setattr("infinivar.sizing.size.search_tries", None)
    study = replace(STUDY, drives={"screw": SPRUNG, "other": SCREW})
    with pytest.raises(iv.InputError) as caught:
        iv.size(study, drive="screw", sets="shipped", tries=tries)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("transmission.preload", "the search itself chooses it, as ranges says"),
        ("steering.ratio", "the search itself chooses it, as steering_ratios says"),
        ("steering.motor.resistance", "the search itself chooses the steering motor; only steering.motor.scale"),
        ("transmission.geometry.axle_bearing.bore", "the search itself chooses the axle bearing"),
        ("link_mass", "it follows from what the search chooses"),
    ],
)
def test_what_a_cobotic_search_chooses_is_not_tried(path, message):
    with pytest.raises(iv.InputError) as caught:
        iv.size(KNEE, drive="cobotic", sets="shipped", tries={f"drives.cobotic.{path}": [1.0]})
    assert message in str(caught.value)


def test_a_combination_that_the_template_refuses_is_said():
    guarded = replace(SPRUNG, screw=replace(SPRUNG.screw, root_diameter=0.008, length=0.1))
    with pytest.raises(iv.InputError, match=r"refuses screw\.root_diameter = 9 mm, screw\.diameter = 8 mm"):
        iv.size(
            replace(STUDY, drives={"screw": guarded}),
            sets="shipped",
            tries={"drives.screw.screw.root_diameter": [0.007, 0.009], "drives.screw.screw.diameter": [0.008, 0.012]},
        )
