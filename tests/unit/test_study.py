"""Study files: what is laid over what, and where each number comes from."""

import dataclasses
import re
import tomllib
import typing
from dataclasses import replace

import pytest

import infinivar as iv
from infinivar import DutyCycle, InputError, Requirement, Scenario, gearheads, motors, units
from infinivar.study import Rig
from internals import SCHEMA_DRIVES as DRIVES
from internals import SCHEMA_KINDS as KINDS
from internals import (
    check_value,
    described,
    in_kinds,
    json_schema,
    parameter_set,
    parameter_sets,
    part_of,
    shipped_studies,
    shipped_study,
    study_template,
    turning,
)
from internals import study_schema as schema

MINIMAL = """
[requirement]
force = "50 N"
speed = "1 m/s"

[drives.mine]
base = "faulring2006.cobotic"
"""


def rows(study, owner):
    return {row.field: row for row in study.provenance if row.owner == owner}


def test_base_supplies_what_the_file_does_not_say(load):
    mine, shipped = load(MINIMAL), shipped_study("faulring2006")
    assert mine.drives["mine"] == shipped.drives["cobotic"]
    assert mine.titles["mine"] == shipped.titles["cobotic"]
    assert mine.reconstruction == shipped.reconstruction != ()


def test_override_replaces_one_value_and_its_provenance(load):
    study = load(MINIMAL + '[drives.mine.transmission]\npreload = "700 N"\n')
    element = study.drives["mine"].transmission
    assert element.preload == 700.0
    assert element.friction == 0.12
    found = rows(study, "mine")
    assert (found["transmission.preload"].kind, found["transmission.preload"].where) == ("assumed", "mine.toml")
    assert (found["transmission.friction"].kind, found["transmission.friction"].where) == ("stated", "III-B.2")


def test_value_tables_and_table_wide_provenance(load):
    study = load(
        MINIMAL
        + """
        [drives.mine.transmission]
        kind = "fitted"
        where = "rig, run 7"
        preload = "700 N"
        friction = { value = 0.2, kind = "stated", where = "handbook" }
        cylinder_radius = { value = 55, unit = "mm" }
        """
    )
    found = rows(study, "mine")
    assert (found["transmission.preload"].kind, found["transmission.preload"].where) == ("fitted", "rig, run 7")
    assert (found["transmission.friction"].kind, found["transmission.friction"].where) == ("stated", "handbook")
    assert found["transmission.cylinder_radius"].value == pytest.approx(0.055)
    assert found["transmission.cylinder_radius"].written == "55 mm"
    # The table's own kind is not that of the base's values.
    assert found["transmission.wheel_radius"].kind == "assumed"


def test_part_from_the_catalogue(load):
    study = load(MINIMAL + '[drives.mine.motor]\npart = "dcx-22-s-24v"\nvoltage = "18 V"\n')
    motor = study.drives["mine"].motor
    assert motor == dataclasses.replace(motors()["dcx-22-s-24v"], voltage=18.0)
    found = rows(study, "mine")
    assert found["motor.resistance"].kind == "catalogue"
    assert found["motor.voltage"].kind == "assumed"


def test_a_named_part_starts_afresh(load):
    """A base's scale or overrides belong to the base's part, not to the one named instead."""
    study = load(
        MINIMAL.replace("faulring2006.cobotic", "faulring2006.motor2-gear4")
        + '[drives.mine.motor]\npart = "re-40-24v"\n'
    )
    assert study.drives["mine"].motor == motors()["re-40-24v"]


def test_scale(load):
    study = load(MINIMAL + "[drives.mine.motor]\nscale = 2\n")
    assert study.drives["mine"].motor == motors()["dc-max-26-s-24v"].scaled(2.0)
    assert rows(study, "mine")["motor.scale"].value == 2.0


def test_geometry_follows_a_changed_load(load):
    """Creep stiffness grows with P^(2/3), hysteresis with P^(4/3): nothing of the base's contact stays behind."""
    base, changed = (
        load(MINIMAL + table).drives["mine"].transmission
        for table in ("", '[drives.mine.transmission]\npreload = "325 N"\n')
    )
    before, after = base.groups(14.0), changed.groups(14.0)
    assert after.slip_force == pytest.approx(before.slip_force / 2)
    assert after.creep_stiffness == pytest.approx(before.creep_stiffness / 2 ** (2 / 3))
    assert after.rolling_torque == pytest.approx(before.rolling_torque / 2 ** (4 / 3))
    assert after.bearing_torque < before.bearing_torque


def test_measured_groups_stand_in_for_geometry(load):
    """All three of them, and what geometry would have given to the steering plant."""
    groups = 'creep_stiffness = "17 kN"\nrolling_torque = "0.2 mN m"\nbearing_torque = "2 mN m"\n'
    steering = '[drives.mine.steering]\npatch_half_length = "0.5 mm"\n'
    element = load(MINIMAL + "[drives.mine.transmission]\n" + groups + steering).drives["mine"].transmission
    assert element.geometry is None
    assert element.groups(14.0).creep_stiffness == 17e3
    with pytest.raises(iv.InputError, match=r"steering\.patch_half_length is missing"):
        load(MINIMAL + "[drives.mine.transmission]\n" + groups)
    with pytest.raises(
        iv.InputError, match=r"transmission\.rolling_torque is missing: give creep_stiffness, rolling_torque"
    ):
        load(MINIMAL + '[drives.mine.transmission]\ncreep_stiffness = "17 kN"\nbearing_torque = "2 mN m"\n')
    both = "[drives.mine.transmission]\n" + groups + '[drives.mine.transmission.geometry]\ncrown_radius = "8 mm"\n'
    with pytest.raises(iv.InputError, match="creep_stiffness and geometry exclude each other"):
        load(MINIMAL + both + steering)


def test_defaults_are_listed_as_assumed(load):
    found = rows(load(MINIMAL), "mine")
    assert found["amplifier.regeneration"].where == "program default"


def test_study_is_frozen(study):
    with pytest.raises(TypeError, match="frozen"):
        study.drives["new"] = None
    with pytest.raises(TypeError, match="frozen"):
        study.titles.update(new="x")
    with pytest.raises(dataclasses.FrozenInstanceError):
        study.title = "x"


@pytest.mark.parametrize("name", parameter_sets())
def test_shipped_sets_say_where_every_value_comes_from(name):
    study = shipped_study(name)
    assert parameter_set(name)["source"] in __import__("infinivar.references").references.entries()
    for row in study.provenance:
        assert row.kind in KINDS
        assert row.where, row


def test_catalogue_parts_all_build():
    assert len(motors()) == 22
    assert len(gearheads()) == 46
    assert gearheads()["gp-22-hd-53"].efficiency == 0.78


def test_template_is_a_study(load):
    study = load(study_template("mine", "Mine"))
    assert list(study.drives) == ["cobotic", "geared"]


def test_all_faults_are_named_at_once(load):
    with pytest.raises(InputError) as raised:
        load(MINIMAL + '[drives.mine.transmission]\npreload = "0 N"\nfrictoin = 0.1\n[drives.other]\n')
    lines = str(raised.value).splitlines()
    assert len(lines) == 3
    assert "drives.mine.transmission.preload" in lines[0]
    assert "did you mean 'friction'" in lines[1]
    assert "drives.other.type" in lines[2]


GEARED = 'base = "faulring2006.motor2-gear4"\n'


@pytest.mark.parametrize(
    ("table", "hint"),
    [
        (GEARED + "[drives.other.linkage]\n", "linkage is not a known key (did you mean 'output.linkage'?); known keys: "),
        ("[drives.other.linkage]\n", "linkage is not a known key (did you mean 'output.linkage'?)"),
        (GEARED + "friction = 2\n", "friction = 2 is not a known key (did you mean 'gearhead.friction' or 'guideway.friction'?)"),
        # More tables have it than a hint lists.
        (GEARED + "efficiency = 1\n", "efficiency = 1 is not a known key; known keys: motor, "),
    ],
)  # fmt: skip
def test_a_key_that_belongs_to_a_table_within(load, table, hint):
    with pytest.raises(InputError, match=re.escape(f"drives.other.{hint}")):
        load(MINIMAL + f"[drives.other]\n{table}")


def test_schema_knows_every_field():
    """Editors are offered each field of each part, with its meaning."""
    definitions = json_schema()["$defs"]
    for part in (*DRIVES.values(), iv.Requirement, iv.parts.Motor, iv.parts.Gearhead, iv.RotaryLinearIVT):
        properties = definitions[part.__name__]["properties"]
        for field in described(part):
            assert field.name in properties, field.name
            assert properties[field.name].get("description") or "$ref" in str(properties[field.name])
        assert "required" not in definitions[part.__name__]
    assert set(schema.table_keys(iv.parts.Motor)) == {
        *(field.name for field in dataclasses.fields(iv.parts.Motor)),
        "scale",
    }


def test_shipped_studies_are_valid(study):
    assert study.title == "Cobotic Hand Controller, one leg"
    with study.path.open("rb") as file:
        assert list(tomllib.load(file)["drives"]) == list(study.drives)


def test_a_drive_that_there_is_not(study):
    with pytest.raises(iv.InputError, match=r"the study has no drive 'cobotc' \(did you mean 'cobotic'\?\)"):
        study.drive("cobotc")
    assert study.drive("cobotic") is study.drives["cobotic"]


def parts_of(part):
    """A part with all that its tables hold."""
    inner = [part_of(hint) for hint in typing.get_type_hints(part).values()]
    inner += [kind for field in in_kinds(part) for kind in field.metadata["kinds"].values()]
    return {part}.union(*(parts_of(one) for one in inner if one is not None))


def test_examples_are_permitted():
    """ "tolerance = 0.1 must be > 0 and <= 1e-3, such as 0.12" helped nobody."""
    kinds = set().union(*(parts_of(kind) for kind in (Requirement, Scenario, DutyCycle, Rig, *schema.DRIVES.values())))
    looked = [field for kind in kinds for field in dataclasses.fields(kind) if field.init and "unit" in field.metadata]
    assert len(looked) > 100
    for field in looked:
        unit, bound = field.metadata["unit"], field.metadata["bound"]
        check_value(field.name, units.parse(schema.example(unit, bound), unit), unit, bound)


@pytest.mark.parametrize(("law", "more"), [("linear", 1.22), ("polach", 1.08), ("exact", None)])
def test_a_creep_law_that_spin_replaces_in_motion_is_named(study, law, more):
    """By how much creep differs: from the creep law at steady points, and from the map of spin at no spin."""
    drive = study.drives["cobotic"]
    element = replace(drive.transmission, steering_model="spin", creep_law=law)
    said = replace(study, drives={"cobotic": replace(drive, transmission=element)}).warnings
    assert len(said) == (more is not None)
    if more is None:
        return
    assert 'drives.cobotic.transmission: steering_model = "spin" knows exact rolling theory only' in said[0]
    assert f"creeps {more:g} times as much" in said[0]
    speed = drive.cylinder_speed
    groups = element.groups(speed)
    steady = iv.contact.creep.lateral_creep(law, 0.5, element.contact.axis_ratio, 0.3) * 3.0 / groups.creep_group
    force, _ = turning.law(more * steady, 0.0, 1.0, **turning.TurningPatch.of(element, groups)._asdict())
    assert force / groups.slip_force == pytest.approx(0.5, abs=0.004)


def test_a_speed_that_no_machine_has_is_warned_of():
    """A slip of the unit, such as km/s for m/s; nothing else bounds a planar cart, which has no part with a speed limit."""
    text = shipped_studies()["planar_cart"].read_text("utf-8")
    assert not iv.Study.from_dict(tomllib.loads(text), name="cart").warnings
    study = iv.Study.from_dict(tomllib.loads(text.replace('x = "0.5 m/s" }', 'x = "47 km/s" }')), name="cart")
    assert any("47000 m/s is above 100 m/s" in one for one in study.warnings)
    drive = {"base": "faulring2006.motor2-gear4"}
    study = iv.Study.from_dict(
        {"requirement": {"force": "4 N", "speed": "1.9 km/s"}, "drives": {"one": drive}}, name="one"
    )
    assert study.warnings == (
        "requirement.speed = 1.9 km/s is above 100 m/s; no limit of a part bounds it, so check the unit",
    )


def slipped(name, before, after):
    """Warnings of a shipped study with a slip of a unit that nothing else bounds."""
    path = shipped_studies()[name]
    text = path.read_text("utf-8")
    assert before in text
    sound, wrong = (
        iv.Study.from_dict(tomllib.loads(one), name=name, folder=path.parent).warnings
        for one in (text, text.replace(before, after))
    )
    assert not [one for one in sound if "above 100 m/s" in one]
    return [one.partition(" is above 100 m/s; ")[0] for one in wrong if "above 100 m/s" in one]


def test_speeds_of_motions_sessions_and_parts_are_warned_of_too():
    assert slipped("guided_cart", '{ x = "0.3 m/s" }', '{ x = "300 m/s" }') == [
        "tasks.path.twist: 300 m/s",
        "tasks.free.twist: 300 m/s",
    ]
    assert slipped("two_joint_arm", 'distance = "80 mm", time = "0.6 s"', 'distance = "800 m", time = "0.6 s"')[
        0
    ].startswith("paths.reach.x: ")
    turning = slipped("planar_cart", 'angle = "0.25 rad/s"', 'angle = "500 rad/s"')
    assert turning == ["tasks.turn, parts of three-wheels: 200 m/s", "tasks.turn, parts of two-wheels: 200 m/s"]
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=2.0, frequency=100.0))
    drive = iv.load_study("hand_controller").drives["cobotic"]
    study = iv.Study(name="fast", duty={"fast": duty}, drives={"one": drive})
    assert [one.partition(" m/s is above")[0] for one in study.warnings if "above 100" in one] == ["duty.fast: 1257"]
