"""Contradictions within rows, and searches: every relation by itself, and two ways to every derived figure."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.parts import heat
from internals import RELATIONS, contradictions_of, derived, derived_columns, part_set, shipped
from internals import DerivedRows as Rows
from internals import part_table as table
from internals import search_condition as condition

MOTOR = iv.parts.Motor(
    voltage=24.0,
    resistance=0.5,
    torque_constant=0.03,
    no_load_current=0.1,
    viscous_friction=1.5e-6,
    continuous_torque=0.09,
    peak_torque=0.3,
    demagnetisation_current=20.0,
    rotor_inertia=1e-5,
    mass=0.3,
    diameter=0.032,
    winding_to_housing=2.0,
    housing_to_ambient=6.0,
    max_winding_temperature=398.15,
)
GOOD = {
    "key": "m",
    **{field.name: value for field in fields(MOTOR) if (value := getattr(MOTOR, field.name)) is not None},
    "stated_no_load_speed": round(MOTOR.no_load_speed, 1),
    "stated_stall_torque": 1.44,
    "stated_stall_current": 48.0,
    "stated_continuous_current": 3.0,
    "stated_peak_efficiency": 0.91,
    "stated_friction_torque": round(MOTOR.friction_torque, 6),
}
GEARHEAD = {"key": "g", "ratio": 4.0, "efficiency": 0.9, "continuous_torque": 0.2, "intermittent_torque": 0.3}
BEARING = {"key": "b", "series": "60", "bore": 0.008, "outside_diameter": 0.022}
BEARING |= {"dynamic_rating": 3450.0, "static_rating": 1370.0}
SPRING = {"key": "s", "made_for": "extension", "stiffness": 1000.0, "initial_tension": 2.0, "permissible_force": 12.0}
SPRING |= {"wire_diameter": 1e-3, "outer_diameter": 9e-3, "body_length": 20.9e-3, "free_length": 0.03}
SPRING |= {"permissible_length": 0.04, "mass": 3.39e-3}
TUBE = {"key": "t", "metal": "steel", "outer_diameter": 0.02, "wall": 1e-3, "tube_density": 0.4686}


def checked(motor=GOOD, gearhead=GEARHEAD, bearing=BEARING, spring=SPRING, tube=TUBE):
    rows = {"motors": motor, "gearheads": gearhead, "bearings": bearing, "springs": spring, "tubes": tube}
    return iv.check_parts(part_set("x", [table(kind, [row]) for kind, row in rows.items()]))


def test_a_row_that_agrees_with_itself():
    found = checked()
    assert found.consistent
    # Every relation was tested: the row states all.
    assert all(count == 1 for count in found.tested.values())
    assert (
        found.verdict == "x: 1 motor, 1 gearhead, 1 bearing, 1 spring, 1 tube; "
        f"{len(RELATIONS)} comparisons; no row contradicts itself"
    )


BROKEN = {
    "no-load speed": {"stated_no_load_speed": 600.0},
    "no-load speed below V/K": {"stated_no_load_speed": 900.0},
    "stall torque": {"stated_stall_torque": 1.2},
    "stall current": {"stated_stall_current": 51.0},
    "continuous current": {"stated_continuous_current": 2.5},
    "peak efficiency": {"stated_peak_efficiency": 0.75},
    "friction torque": {"stated_friction_torque": 0.0009},
    "no-load current": {"no_load_current": 48.5},
    "continuous current below stall": {"stated_continuous_current": 50.0},
    "viscous friction": {"viscous_friction": 5e-6},
    "heat at continuous current": {"housing_to_ambient": 25.0},
    "continuous torque": {"peak_torque": 0.08},
    "demagnetisation current": {"demagnetisation_current": 1.0},
    "rotor inertia": {"rotor_inertia": 1e-4},
}


@pytest.mark.parametrize("relation", BROKEN)
def test_each_relation_of_a_motor_finds_its_contradiction(relation):
    found = checked(motor={**GOOD, **BROKEN[relation]})
    hit = [one for one in found.contradictions if one.relation == relation]
    assert [(one.kind, one.key) for one in hit] == [("motors", "m")]
    assert abs(hit[0].deviation) > hit[0].tolerance
    assert hit[0].text.startswith(f"motor m: {relation} ")
    assert not found.consistent
    assert found.verdict.endswith("1 row contradicts itself")


def test_every_relation_is_broken_once():
    assert set(BROKEN) == {one.name for one in RELATIONS if one.kind == "motors"}
    assert {one.kind for one in RELATIONS} == {"motors", "gearheads", "bearings", "springs", "tubes"}
    assert all(one.reason and one.follows and "Source: " in one.law.__doc__ for one in RELATIONS)


def test_contradictions_of_gearheads_and_bearings():
    found = checked(gearhead={**GEARHEAD, "intermittent_torque": 0.1}, bearing={**BEARING, "bore": 0.03})
    assert [one.text for one in found.contradictions] == [
        "gearhead g: continuous torque 0.2 N m exceeds the intermittent torque, 0.1 N m (100.0 % off, tolerance 1 %)",
        "bearing b: bore 30 mm exceeds the outside diameter, 22 mm (36.4 % off, tolerance 0 %)",
    ]


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        (
            {"stiffness": 1500.0, "permissible_length": 0.03667},
            "stiffness 1.5 N/mm is stated, but G d^4/(8 D^3 n) gives 0.999",
        ),
        (
            {"permissible_force": 15.0},
            "permissible force 15 N is stated, but stiffness times deflection at the permiss",
        ),
        (
            {"initial_tension": 13.0, "permissible_length": 0.03},
            "initial tension 13 N exceeds the permissible force, 12 N",
        ),
        ({"mass": 5e-3}, "mass 5 g is stated, but the mass of its wire gives 3.39"),
        ({"wire_diameter": 5e-3}, "wire 10 mm exceeds the outer diameter, 9 mm"),
    ],
)
def test_contradictions_of_springs(changed, text):
    assert [
        one.text
        for one in checked(spring={**SPRING, **changed}).contradictions
        if one.text.startswith(f"spring s: {text}")
    ]


def test_contradictions_of_tubes():
    """A mass without a metal is compared with that of steel; a stated density wins."""
    light = {**TUBE, "tube_density": 0.161}
    text = "tube t: mass over length 0.161 kg/m is stated, but section times density gives 0.4686"
    assert [one.text[: len(text)] for one in checked(tube=light).contradictions] == [text]
    assert checked(tube={**light, "metal": "aluminium"}).consistent
    assert checked(tube={**light, "density": 2700.0}).consistent
    full = checked(tube={**TUBE, "wall": 11e-3})
    assert any("tube t: wall 22 mm exceeds the outer diameter, 20 mm" in one.text for one in full.contradictions)
    assert full.unusable == ("tube t: wall must be < 10 mm, half of outer_diameter, got 11 mm",)


def test_a_complete_row_that_is_no_part():
    found = checked(bearing={**BEARING, "outside_diameter": 0.008})
    assert found.unusable == ("bearing b: outside_diameter must be > bore (0.008 m), got 0.008",)
    assert not found.consistent
    assert found.contradictions == ()
    assert (
        checked(bearing={**BEARING, "series": "other"}).unusable[0].startswith("bearing b: series must be the series")
    )


def test_a_gearhead_that_states_a_backdriving_efficiency():
    """It is used with loss in proportion to power only; a data sheet may state it whatever the model."""
    for model in ({}, {"loss_model": "coulomb"}, {"loss_model": "proportional"}):
        row = {**GEARHEAD, "backdriving_efficiency": 0.7, **model}
        assert checked(gearhead=row).unusable == ()
        part = table("gearheads", [row]).part("g")
        assert part.backdriving_efficiency == (0.7 if model.get("loss_model") == "proportional" else None)


def test_contradictions_of_some_parts():
    """The same as those of the whole set, of the parts asked for."""
    rows = [{**GOOD, "key": str(speed), "stated_no_load_speed": speed} for speed in (600.0, 700.0, 730.0, 500.0)]
    parts = part_set("x", [table("motors", rows), table("gearheads", [GEARHEAD])])
    every = iv.check_parts(parts).contradictions
    assert {one.key for one in every} >= {"600.0", "500.0"}
    for keys in (["600.0"], ["500.0", "600.0", "600.0"], [], ["730.0", "500.0"]):
        assert contradictions_of(parts, "motors", keys) == tuple(one for one in every if one.key in keys)
    assert contradictions_of(parts, "gearheads", ["g"]) == ()
    with pytest.raises(iv.InputError, match="'h' is not among the 1 gearheads"):
        contradictions_of(parts, "gearheads", ["h"])


def test_the_worst_come_first_and_rounding_is_no_contradiction():
    rows = [{**GOOD, "key": str(speed), "stated_no_load_speed": speed} for speed in (600.0, 700.0, 730.0, 500.0)]
    found = iv.check_parts(part_set("x", [table("motors", rows)]))
    assert [one.key for one in found.contradictions] == ["500.0", "600.0", "700.0"]
    assert found.contradictions[0].deviation == pytest.approx(MOTOR.no_load_speed / 500.0 - 1.0)
    # A friction torque stated to 0.01 mN m may be off by half of that, whatever share of it that is.
    small = replace(MOTOR, torque_constant=0.001, no_load_current=0.024, viscous_friction=None, peak_torque=None)
    row = {"key": "s", **{name: getattr(small, name) for name in ("voltage", "resistance", "torque_constant")}}
    row |= {"no_load_current": 0.024, "stated_friction_torque": 2e-5}
    assert iv.check_parts(part_set("x", [table("motors", [row])])).consistent
    assert not iv.check_parts(part_set("x", [table("motors", [{**row, "stated_friction_torque": 1e-5}])])).consistent


def test_figures_derived_from_each_other_are_not_compared():
    row = {**GOOD, "stated_continuous_current": MOTOR.continuous_current, "derived": "continuous_torque"}
    assert checked(motor=row).tested["motor: continuous current"] == 0
    assert checked().tested["motor: continuous current"] == 1


def test_no_shipped_row_contradicts_itself():
    found = iv.check_parts(shipped())
    assert found.contradictions == ()
    assert found.tested["motor: no-load speed"] == len(iv.motors())
    assert found.tested["motor: heat at continuous current"] == len(iv.motors())
    assert (found.incomplete, found.unusable) == ({}, ())
    assert shipped().motors.complete.all()


def test_shipped_tables_hold_the_shipped_parts():
    for kind, parts in (
        ("motors", iv.motors()),
        ("gearheads", iv.gearheads()),
        ("bearings", iv.bearings()),
        ("springs", iv.springs()),
        ("tubes", iv.tubes()),
        ("materials", iv.materials()),
    ):
        held = shipped().tables[kind]
        assert held.part_keys == tuple(parts)
        assert all(held.part(key) == part for key, part in parts.items())
        if kind != "materials":
            assert (held.texts["manufacturer"] != "").all()
            # Data of articles and web pages are undated.
            assert (held.texts["date"] != "").all() or kind in ("springs", "tubes")
        assert (held.texts["source"] != "").all()


def test_derived_figures_are_those_of_the_parts():
    """Two ways: a law over columns, and the motor operated at that point."""
    motors = shipped().motors
    for row, key in enumerate(motors.part_keys):
        motor = motors.part(key)
        speed = derived(motors, "no_load_speed")[row]
        assert float(motor.operate(torque=0.0, speed=speed).voltage) == pytest.approx(motor.voltage, rel=1e-12)
        torque = derived(motors, "stall_torque")[row]
        # Barely turning, so that friction opposes the motor.
        stalled = motor.operate(torque=torque, speed=1e-9)
        assert float(stalled.voltage) == pytest.approx(motor.voltage, rel=1e-9)
        assert float(stalled.current) == pytest.approx(derived(motors, "stall_current")[row], rel=1e-9)
        loads = np.linspace(0.0, torque, 4001)[1:-1]
        speeds = speed * (1.0 - loads / torque)
        point = motor.operate(torque=loads, speed=speeds)
        best = np.max(loads * speeds / point.power)
        assert derived(motors, "peak_efficiency")[row] == pytest.approx(best, rel=1e-4)
        assert derived(motors, "continuous_current")[row] == motor.continuous_current
    assert set(derived_columns("motors")) >= {"no_load_speed", "peak_efficiency"}
    with pytest.raises(AttributeError, match="ratio"):
        _ = Rows(motors).ratio


def test_the_bound_of_heat_is_that_of_the_thermal_model():
    """At the bound, the winding settles at its limit; friction heat is left out on both sides."""
    (relation,) = [one for one in RELATIONS if one.name == "heat at continuous current"]
    motors = shipped().motors
    bound = relation.deviations(motors)[1]
    for row, key in enumerate(motors.part_keys):
        motor = motors.part(key)
        found = heat.heat(motor, np.full(8, bound[row]), np.zeros(8), 1.0)
        assert found.winding == pytest.approx(motor.max_winding_temperature, abs=0.05)


def test_search_finds_what_a_loop_finds():
    found = iv.search_parts(
        shipped(), "motors", ["mass < 0.2 kg", "voltage = 24 V", "peak efficiency >= 85 %"], sort="mass"
    )
    expected = sorted(
        (motor.mass, key)
        for key, motor in iv.motors().items()
        if motor.mass < 0.2 and motor.voltage == 24.0 and motor.peak_efficiency >= 0.85
    )
    assert sorted((hit.values["mass"], hit.key) for hit in found.hits) == expected
    assert [hit.values["mass"] for hit in found.hits] == [mass for mass, _ in expected]
    assert (found.count, found.searched) == (len(expected), len(iv.motors()))
    few = iv.search_parts([shipped()], "motors", "mass < 200 g", sort="mass", descending=True, limit=3)
    assert [hit.values["mass"] for hit in few.hits] == sorted(
        (motor.mass for motor in iv.motors().values() if motor.mass < 0.2), reverse=True
    )[:3]
    assert few.verdict == f"{few.count} of {few.searched} motors, 3 shown"


def test_search_compares_texts_and_numbers_in_any_unit():
    def keys(kind, *conditions):
        return [hit.key for hit in iv.search_parts(shipped(), kind, conditions).hits]

    assert keys("motors", "name ~ dcx 22") == ["dcx-22-s-24v", "dcx-22-l-18v"]
    assert keys("motors", "order_number = 148867") == ["re-40-24v"]
    assert keys("motors", "manufacturer != maxon") == []
    assert keys("bearings", "bore = 0.8 cm", "mass < 10 g") == keys("bearings", "bore = 8 mm", "mass < 0.01 kg")
    assert keys("gearheads", "efficiency == 90 %") == keys("gearheads", "efficiency = 0.9") != []
    assert keys("gearheads", "ratio != 4.4", "ratio <= 4.4") == keys("gearheads", "ratio < 4.4")
    assert keys("gearheads", "friction.viscous > 0 N m s") == [
        key for key in iv.gearheads() if iv.gearheads()[key].friction
    ]


def test_search_for_what_fits():
    motors = table("motors", [{"key": "a"}, {"key": "b"}])
    gearheads = table("gearheads", [{"key": "g", "ratio": 4.0}, {"key": "h", "ratio": 9.0}])
    mine = part_set("mine", [motors, gearheads], np.array([[0, 0], [0, 1], [1, 1]]))
    both = [shipped(), mine]

    def keys(kind, fits, *conditions):
        return [hit.key for hit in iv.search_parts(both, kind, conditions, fits=fits).hits]

    assert keys("gearheads", "mine:a") == ["g", "h"]
    assert keys("gearheads", "mine:a", "ratio > 5") == keys("gearheads", "mine:b") == ["h"]
    assert keys("motors", "mine:h") == ["a", "b"]
    assert keys("motors", "mine:g") == ["a"]
    assert mine.motors_for("h") == ("a", "b")
    for kind, fits, message in [
        ("gearheads", "mine:c", "'c' is not among the 2 motors"),
        ("gearheads", "re-40-24v", "the set shipped does not state what fits together"),
        ("motors", "yours:g", "'yours' is not among the sets searched, shipped, mine"),
        (
            "motors",
            "mine:a",
            "'mine:a': this is among the motors of mine; what fits it is found among the gearheads, not",
        ),
        ("gearheads", "mine:h", "this is among the gearheads of mine; what fits it is found among the motors, not"),
        ("bearings", "mine:g", "is for motors and gearheads, not for bearings"),
    ]:
        with pytest.raises(iv.InputError, match=message):
            keys(kind, fits)


def test_rows_that_do_not_state_a_column_are_counted():
    found = iv.search_parts(shipped(), "gearheads", ["efficiency > 0.1"])
    measured = [key for key, gear in iv.gearheads().items() if gear.efficiency is None]
    assert found.unstated == {"efficiency": len(measured)}
    assert found.verdict.endswith(f"; {len(measured)} do not state efficiency")
    every = iv.search_parts(shipped(), "gearheads", sort="efficiency", show=["mass"])
    assert [hit.key for hit in every.hits[-len(measured) :]] == measured
    assert every.hits[-1].values == {"efficiency": None, "mass": None}
    assert every.hits[0].part == every.hits[0].key
    other = part_set("mine", [table("motors", [{"key": "a"}])])
    assert [hit.part for hit in iv.search_parts(other, "motors").hits] == ["mine:a"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mass", "must be COLUMN SIGN VALUE with one of"),
        ("mas < 1 kg", r"'mas' is no column of motors \(did you mean 'mass'\?\)"),
        ("mass < 1", "the value '1' needs a unit"),
        ("mass < 1 V", "has the unit 'V' where kg is needed"),
        ("mass ~ 1 kg", "mass is a number; ~ is for texts"),
        ("name < a", "name is text; use =, != or ~"),
        ("mass <", "must begin with a number"),
    ],
)
def test_conditions_that_cannot_be_understood(text, message):
    with pytest.raises(iv.InputError, match=message):
        condition("motors", text)


def test_searches_that_cannot_be_understood():
    for options, message in [
        ({"sort": "weight"}, "sort: 'weight' is no column of motors"),
        ({"show": ["weight"]}, "show: 'weight' is no column of motors"),
        ({"limit": 0}, "limit must be >= 1, got 0"),
    ]:
        with pytest.raises(iv.InputError, match=message):
            iv.search_parts(shipped(), "motors", **options)
    with pytest.raises(iv.InputError, match="'wheels' must be one of motors"):
        iv.search_parts(shipped(), "wheels")
    assert math.isnan(derived(table("motors", [{"key": "a"}]), "no_load_speed")[0])
