"""Bad studies: exit code 2, one short message that names file, field, value and what would be right, nothing written."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from folders import results

REQUIREMENT = """
[requirement]
force = "50 N"
speed = "1.05 m/s"
power = "12 W"
"""

MINE = """
[drives.mine]
base = "faulring2006.cobotic"
"""

GEARED = """
[drives.geared]
type = "conventional"
[drives.geared.motor]
part = "dcx-32-l-24v"
[drives.geared.gearhead]
ratio = 3.9
efficiency = 0.96
[drives.geared.pulley]
radius = "8 mm"
"""

GOOD = REQUIREMENT + MINE + GEARED


def replaced(old, new):
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


def tables(text):
    """The requirement and what else is said."""
    return REQUIREMENT + text


def mine(keys):
    """A drive with a base and more keys."""
    return REQUIREMENT + MINE + keys


def check(outcome, folder, words, lines=1):
    """Exit code 2, so many lines that all name the file, all the words, nothing else said or written."""
    said = outcome.err.removeprefix("infinivar: ").splitlines()
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("infinivar: study.toml: ")
    assert all(line.startswith("study.toml: ") for line in said)
    assert len(said) == lines, outcome.err
    assert all(line.isprintable() for line in said)
    assert len(outcome.err) < 500 * lines
    for word in words:
        assert word in outcome.err
    assert [path.name for path in folder.iterdir()] == ["study.toml"]


def cases(table):
    return [pytest.param(text, words, id=name) for name, (text, *words) in table.items()]


def test_what_the_bad_ones_are_made_from_is_good(infinivar, write, tmp_path):
    outcome = infinivar("compare", write(GOOD), "--json")
    assert (outcome.code, outcome.err) == (0, "")
    assert list(json.loads(outcome.out)["drives"]) == ["mine", "geared"]


FILES = {
    "binary": (bytes(range(256)), "UTF-8"),
    "UTF-16": (GOOD.encode("utf-16"), "UTF-8"),
    "Latin-1": ("title = 'Größe'".encode("latin-1"), "UTF-8", "byte 11"),
    "zeros": (b"\0\0\0", "TOML", "line 1"),
    "JSON": ('{"requirement": {"force": "50 N"}}', "TOML", "line 1"),
    "YAML": ("requirement:\n  force: 50 N\n", "TOML", "line 1"),
    "open string": ('[requirement]\nforce = "50 N\nspeed = 3\n', "TOML", "line 2"),
    "comma in a number": ("[requirement]\nx = 0,12\n", "TOML", "line 2"),
    "key twice": ('[requirement]\nforce = "50 N"\nforce = "60 N"\n', "TOML", "line 3"),
    "table twice": (GOOD + MINE, "TOML", "drives", "mine", "line"),
    "nested without end": ("title = " + "[" * 5000, "nested"),
    "keys nested without end": (mine(".".join("a" * 3000) + " = 1"), "key of more than 64 parts"),
    "number of 5000 digits": (mine("[drives.mine.transmission]\nfriction = 1" + "0" * 5000), "TOML"),
}


@pytest.mark.parametrize(("text", "words"), cases(FILES))
def test_files_that_are_no_study(infinivar, write, tmp_path, text, words):
    check(infinivar("compare", write(text)), tmp_path, words)


@pytest.mark.parametrize("text", ["", "# nothing\n"])
def test_a_study_without_tables_lacks_both_sections(infinivar, write, tmp_path, text):
    words = ("requirement is missing", "[requirement]", "drives is missing", "[drives.NAME]")
    check(infinivar("compare", write(text)), tmp_path, words, lines=2)


STRUCTURE = {
    "no requirement": (MINE, "requirement is missing", "[requirement]"),
    "no drives": (REQUIREMENT, "drives is missing", "[drives.NAME]"),
    "drives empty": (tables("[drives]"), "drives", "[drives.NAME]"),
    "drives a number": ("drives = 5" + REQUIREMENT, "drives = 5", "[drives.NAME]"),
    "drives an array": (tables("[[drives]]\nbase = 'faulring2006.cobotic'"), "drives = ", "[drives.NAME]"),
    "requirement a text": ("requirement = 'faulring2006'" + MINE, "requirement = ", "faulring2006", "[requirement]"),
    "requirement an array": ("[[requirement]]\nforce = '50 N'" + MINE, "requirement = ", "50 N", "[requirement]"),
    "misspelt title": ("titel = 'x'" + GOOD, "titel", "'title'"),
    "misspelt requirement": (replaced("[requirement]", "[requirements]"), "requirements", "'requirement'"),
    "misspelt drives": (tables(MINE.replace("drives", "drive")), "drive", "'drives'"),
    "key with a line break": ('"a\\nb" = 1' + GOOD, "not a known key"),
    "title a number": ("title = 5" + GOOD, "title = 5", "text"),
    "title a list": ("title = []" + GOOD, "title = []", "text"),
    "title a truth value": ("title = true" + GOOD, "title = true", "text"),
    "description a list": ("description = ['a']" + GOOD, "description = ", "text"),
    "drive a number": (tables("[drives]\nmine = 5"), "drives.mine = 5", "[drives.mine]"),
    "drive a text": (tables("[drives]\nmine = 'faulring2006.cobotic'"), "faulring2006.cobotic", "[drives.mine]"),
    "drive an array": (tables("[[drives.mine]]\nbase = 'x.y'"), "drives.mine = ", "x.y", "[drives.mine]"),
    "drive empty": (tables("[drives.mine]"), "drives.mine.type is missing", "one of cobotic, conventional"),
    "names that differ in case": (mine(MINE.replace("mine", "MINE")), "mine", "MINE"),
    "base misspelt": (tables("[drives.mine]\nbsae = 'faulring2006.cobotic'"), "drives.mine.bsae", "'base'"),
    "type misspelt": (tables("[drives.mine]\ntyp = 'cobotic'"), "drives.mine.typ", "'type'"),
    "title of a drive misspelt": (mine("titel = 'x'"), "drives.mine.titel", "'title'"),
    "kind of a drive misspelt": (mine("kinf = 'stated'"), "drives.mine.kinf", "'kind'"),
    "type unknown": (tables("[drives.mine]\ntype = 'cobotix'"), "drives.mine.type", "cobotix", "'cobotic'"),
    "type a list": (mine("type = ['cobotic']"), "drives.mine.type", "cobotic"),
    "type against base": (mine("type = 'conventional'"), "drives.mine.type", "conventional", "'cobotic'"),
    "base of no set": (tables("[drives.mine]\nbase = 'nosuch.thing'"), "mine.base", "nosuch.thing", "faulring2006"),
    "base outside": (tables("[drives.mine]\nbase = '../x.y'"), "mine.base", "../x.y", "faulring2006"),
    "base of no drive": (replaced("2006.cobotic", "2006.cobotix"), "mine.base", "2006.cobotix", "2006.cobotic"),
    "base without drive": (replaced("2006.cobotic", "2006"), "mine.base", "'faulring2006'", "faulring2006.cobotic"),
    "base a table": (tables("[drives.mine]\nbase = {value = 'x'}"), "mine.base", "text"),
    "requirement from a drive": ("requirement.base = 'faulring2006.cobotic'" + MINE, "requirement.base", "'faulring2006'"),
    "title in requirement": (replaced("power", "title"), "requirement.title", "known keys: force"),
    "part misspelt": (replaced("32-l-24v", "32-l-24"), "geared.motor.part", "dcx-32-l-24'", "'dcx-32-l-24v'"),
    "part a number": (replaced('"dcx-32-l-24v"', "5"), "geared.motor.part = 5", "text"),
    "part a truth value": (replaced('"dcx-32-l-24v"', "true"), "geared.motor.part = true", "text"),
    "part in a pulley": (replaced('radius = "8 mm"', "part = 'x'"), "geared.pulley.part", "the catalogue has motors"),
    "part in a requirement": (replaced('power = "12 W"', "part = 'x'"), "requirement.part", "the catalogue has motors"),
    "part in a drive": (mine("part = 'dcx-32-l-24v'"), "drives.mine.part"),
    "motor a text": (mine("motor = 'dcx-32-l-24v'"), "drives.mine.motor", "dcx-32-l-24v", "part"),
    "motor a list": (mine("motor = []"), "drives.mine.motor = []", "[drives.mine.motor]"),
    "motor an array": (mine("[[drives.mine.motor]]\npart = 'x'"), "drives.mine.motor", "[drives.mine.motor]"),
    "motor a value": (mine("motor = {value = 5}"), "drives.mine.motor", "[drives.mine.motor]"),
    "gearhead a number": (mine("gearhead = 3.9"), "drives.mine.gearhead = 3.9", "[drives.mine.gearhead]"),
    "guideway a force": (mine("guideway = '3 N'"), "drives.mine.guideway", "3 N", "[drives.mine.guideway]"),
    "amplifier a date": (mine("amplifier = 2020-01-01"), "drives.mine.amplifier = 2020-01-01", "[drives.mine.amplifier]"),
    "steering a truth value": (mine("steering = true"), "drives.mine.steering = true", "[drives.mine.steering]"),
    "misspelt key": (mine("[drives.mine.transmission]\nprelaod = '650 N'"), "transmission.prelaod", "650 N", "'preload'"),
    "misspelt table": (mine("[drives.mine.transmision]\npreload = '650 N'"), "mine.transmision", "'transmission'"),
    "misspelt deep key": (mine("[drives.mine.steering.motor]\nmas = '1 kg'"), "steering.motor.mas", "1 kg", "'mass'"),
    "key of another drive": (GOOD + "[drives.geared.transmission]\npreload = '1 N'", "geared.transmission", "pulley"),
    "scale of a gearhead": (replaced("ratio = 3.9", "ratio = 3.9\nscale = 2"), "gearhead.scale = 2", "known keys:"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "words"), cases(STRUCTURE))
def test_wrong_structure(infinivar, write, tmp_path, text, words):
    check(infinivar("compare", write(text)), tmp_path, words)


@pytest.mark.parametrize("name", ["a/b", "a.b", "a b", "..", "", "../x", "é", "report.html", "a\\nb", "x" * 200])
def test_drive_names_are_file_names(infinivar, write, tmp_path, name):
    text = tables(f'[drives."{name}"]\nbase = "faulring2006.cobotic"\n')
    check(
        infinivar("compare", write(text)), tmp_path, [f"drives.{name!r}"[:40].replace("\\\\", "\\"), "letters, digits"]
    )


VALUE_TABLES = {
    "{}": ("value",),
    "{x = 1}": ("value",),
    "{valeu = '650 N'}": ("value",),
    "{kind = 'stated'}": ("value",),
    "{value = '650 N', knd = 'stated'}": ("650 N", "knd", "'kind'"),
    "{value = '650 N', kind = 'catalog'}": ("650 N", "catalog", "catalogue"),
    "{value = '650 N', kind = ['stated']}": ("650 N", "kind", "stated"),
    "{value = '650 N', where = 5}": ("650 N", "where", "text", "5"),
    "{value = '650 N', unit = 'N'}": ("650 N", "unit"),
    "{value = 650}": ("650", "needs a unit", '"50 N"'),
    "{value = 650, unit = ''}": ("650", "needs a unit", '"50 N"'),
    "{value = 650, unit = 'kg'}": ("650", "'kg'", '"50 N"'),
    "{value = 650, unit = 5}": ("650", "unit", "5"),
    "{value = true, unit = 'N'}": ("true", "number"),
    "{value = inf, unit = 'N'}": ("inf", "number", '"50 N"'),
    "{value = -650, unit = 'N'}": ("-650", "> 0 N"),
    "{value = {value = '650 N'}}": ("650 N", '"50 N"'),
}


@pytest.mark.parametrize("written", VALUE_TABLES)
def test_wrong_value_tables(infinivar, write, tmp_path, written):
    text = mine(f"[drives.mine.transmission]\npreload = {written}\n")
    check(infinivar("compare", write(text)), tmp_path, ["drives.mine.transmission.preload", *VALUE_TABLES[written]])


@pytest.mark.parametrize("line", ["kind = 'catalog'", "kind = ['stated']", "kind = {x = 1}", "where = 5", "where = []"])
def test_wrong_source_of_a_table(infinivar, write, tmp_path, line):
    key, value = line.split(" = ", 1)
    text = mine(f"[drives.mine.transmission]\n{line}\npreload = '650 N'\n")
    hint = "catalogue" if key == "kind" else "text"
    check(
        infinivar("compare", write(text)),
        tmp_path,
        [f"drives.mine.transmission.{key}", *re.findall(r"\w+", value), hint],
    )


# Field, what a user may write there, and advice that the message must give.
VALUES = [
    ("requirement.force", 50, '"50 N"'),
    ("requirement.force", 50.5, '"50 N"'),
    ("requirement.force", True, '"50 N"'),
    ("requirement.force", ["50 N"], '"50 N"'),
    ("requirement.force", [], '"50 N"'),
    ("requirement.force", "", '"50 N"'),
    ("requirement.force", "   ", '"50 N"'),
    ("requirement.force", "N", '"50 N"'),
    ("requirement.force", "50", '"50 N"'),
    ("requirement.force", "50 Nm", '"50 N"'),
    ("requirement.force", "50 N m", '"50 N"'),
    ("requirement.force", "50 kg", '"50 N"'),
    ("requirement.force", "50 lb", '"50 N"'),
    ("requirement.force", "50 n", "unknown unit 'n'"),
    ("requirement.force", "50 Newton", "unknown unit 'Newton'"),
    ("requirement.force", "50 kp", "unknown unit 'kp'"),
    ("requirement.force", "50 %", '"50 N"'),
    ("requirement.force", "50 N %", "N %"),
    ("requirement.force", "50±1 N", "±1 N"),
    ("requirement.force", "50 \\u200bN", "unit"),
    ("requirement.force", "50 N\\u0000", "unit"),
    ("requirement.force", "~50 N", '"50 N"'),
    ("requirement.force", "50 N (max)", "unknown unit 'N (max)'"),
    ("requirement.force", "50 [N]", "unknown unit"),
    ("requirement.force", "50 N + 3 N", "unknown unit"),
    ("requirement.force", "50 N/0", "unknown unit"),
    ("requirement.force", "1/2 N", "unknown unit"),
    ("requirement.force", "½ N", '"50 N"'),
    ("requirement.force", "0x10 N", "unknown unit"),
    ("requirement.force", "1_000 N", "unknown unit"),
    ("requirement.force", "1 000 N", "unknown unit"),
    ("requirement.force", "1,05 N", "point"),
    ("requirement.force", "1.000,5 N", "point"),
    ("requirement.force", "inf N", '"50 N"'),
    ("requirement.force", "nan N", '"50 N"'),
    ("requirement.force", "1e400 N", "finite"),
    ("requirement.force", "-50 N", "> 0 N"),
    ("requirement.force", "0 N", "> 0 N"),
    ("requirement.force", "1e-400 N", "> 0 N"),
    ("requirement.speed", "1.05 m", '"1.05 m/s"'),
    ("requirement.speed", "1.05 m/s^2", '"1.05 m/s"'),
    ("requirement.speed", "1.05 ms^-1", '"1.05 m/s"'),
    ("requirement.power", "12 N m", '"12 W"'),
    ("requirement.power", "12 W h", '"12 W"'),
    ("requirement.power", "12 dBm", '"12 W"'),
    ("requirement.power", "0 W", "> 0 W"),
    ("requirement.load_mass", "0.8 N", '"0.4 kg"'),
    ("requirement.load_mass", "20 degC", '"0.4 kg"'),
    ("requirement.quadrants", 3, "1, 2, 4"),
    ("requirement.quadrants", -1, "1, 2, 4"),
    ("requirement.quadrants", 2.5, "1, 2, 4"),
    ("requirement.quadrants", True, "1, 2, 4"),
    ("requirement.quadrants", "4", "1, 2, 4"),
    ("requirement.quadrants", "all", "1, 2, 4"),
    ("requirement.quadrants", [1, 2], "1, 2, 4"),
    ("drives.mine.transmission.friction", 0, "> 0"),
    ("drives.mine.transmission.friction", -0.1, "> 0"),
    ("drives.mine.transmission.friction", True, "number"),
    ("drives.mine.transmission.friction", float("inf"), "finite"),
    ("drives.mine.transmission.friction", float("nan"), "finite"),
    ("drives.mine.transmission.friction", 10**400, "finite"),
    ("drives.mine.transmission.friction", "abc", "number"),
    ("drives.mine.transmission.friction", "0,12", "point"),
    ("drives.mine.transmission.friction", "1/8", "'/8'"),
    ("drives.mine.transmission.friction", "0.12 N", "'N'"),
    # These have no dimension, but a friction coefficient in them is a slip of the pen, not a number.
    ("drives.mine.transmission.friction", "7 deg", "'deg'"),
    ("drives.mine.transmission.friction", "0.12 rad", "'rad'"),
    ("drives.mine.transmission.friction", "0.12 rev", "'rev'"),
    ("drives.mine.transmission.friction", "6 dB", "'dB'"),
    ("drives.mine.transmission.friction", "1 bit", "'bit'"),
    ("drives.mine.transmission.steering_range", 75, '"75 deg"'),
    ("drives.mine.transmission.steering_range", "0 deg", "> 0"),
    ("drives.mine.transmission.steering_range", "-20 deg", "> 0"),
    ("drives.mine.transmission.steering_range", "75 %", '"75 deg"'),
    ("drives.mine.transmission.steering_range", "0.5 1", '"75 deg"'),
    ("drives.mine.transmission.steering_range", "5 dB", '"75 deg"'),
    ("drives.mine.transmission.steering_range", "200 deg", "rad"),
    ("drives.mine.transmission.creep_law", "lienar", "'linear'"),
    ("drives.mine.transmission.creep_law", 5, "linear, faulring"),
    ("drives.mine.cylinder_speed", 14, '"8040 rpm"'),
    ("drives.mine.cylinder_speed", "0 rpm", "!= 0"),
    ("drives.mine.cylinder_speed", "133 Hz", "rpm"),
    ("drives.mine.cylinder_speed", "14 1/s", "rpm"),
    ("drives.mine.cylinder_speed", "133 1/min", "rpm"),
    ("drives.mine.cylinder_speed", "133 RPM", "rpm"),
    ("drives.mine.cylinder_speed", "14 m/s", "rpm"),
    ("drives.mine.cylinder_speed", "14 rad", '"8040 rpm"'),
    ("drives.mine.gearhead.ratio", 0, "> 0"),
    ("drives.mine.gearhead.ratio", "1:57", "':57'"),
    ("drives.mine.gearhead.ratio", "57 deg", "'deg'"),
    ("drives.mine.gearhead.efficiency", 0, "<= 1"),
    ("drives.mine.gearhead.efficiency", -0.1, "<= 1"),
    ("drives.mine.gearhead.efficiency", 1.0001, "<= 1"),
    ("drives.mine.gearhead.efficiency", 88, "<= 1"),
    ("drives.mine.gearhead.loss_model", "colomb", "'coulomb'"),
    ("drives.mine.motor.resistance", "0 ohm", "> 0 ohm"),
    ("drives.mine.motor.resistance", "-2.14 ohm", "> 0 ohm"),
    ("drives.mine.motor.resistance", "2.14 Ohm", "unknown unit 'Ohm'"),
    ("drives.mine.motor.torque_constant", "25.6 mNm/A", '"25.6 mN m/A"'),
    ("drives.mine.motor.torque_constant", "373 rpm/V", '"25.6 mN m/A"'),
    ("drives.mine.motor.no_load_current", "-1 mA", ">= 0 A"),
    ("drives.mine.motor.continuous_torque", "26.3 mNm", '"26.3 mN m"'),
    ("drives.mine.motor.continuous_torque", "26.3 oz in", '"26.3 mN m"'),
    ("drives.mine.motor.rotor_inertia", "14.9 gcm^2", "g cm^2"),
    ("drives.mine.motor.inductance", "0.278 mh", '"0.278 mH"'),
    ("drives.mine.motor.max_winding_temperature", "100 C", '"100 degC"'),
    ("drives.mine.motor.max_winding_temperature", "-300 degC", "> 0 K"),
    ("drives.mine.motor.winding_to_housing", "13.2 C/W", '"13.2 K/W"'),
    ("drives.mine.motor.scale", 0, "> 0"),
    ("drives.mine.motor.scale", "2.7 x", "'x'"),
    ("drives.mine.motor.name", "", "text"),
    ("drives.mine.motor.name", 5, "text"),
    ("drives.mine.amplifier.regeneration", "brun", "'burn'"),
    ("drives.mine.amplifier.regeneration", False, "burn, store, none"),
    ("drives.mine.amplifier.regeneration", ["burn"], "burn, store, none"),
    ("drives.mine.amplifier.standby_power", "-1 W", ">= 0 W"),
]


def toml(value):
    return (
        f'"{value}"' if isinstance(value, str) else json.dumps(value).replace("Infinity", "inf").replace("NaN", "nan")
    )


def with_value(field, value):
    """A good study in which one field is overridden."""
    owner, _, key = field.rpartition(".")
    if owner == "requirement":
        return re.sub(rf"{key} = .*\n", "", REQUIREMENT) + f"{key} = {toml(value)}\n" + MINE
    table = "" if owner == "drives.mine" else f"[{owner}]\n"
    return mine(f"{table}{key} = {toml(value)}\n")


@pytest.mark.parametrize(
    ("field", "value", "advice"),
    VALUES,
    ids=[f"{field.split('.')[-1]}={str(value)[:20]}" for field, value, _ in VALUES],
)
def test_wrong_values(infinivar, write, tmp_path, field, value, advice):
    shown = [] if not isinstance(value, str | int | float) else [toml(value)[:40].partition("\\u")[0]]
    check(infinivar("compare", write(with_value(field, value))), tmp_path, [field, *shown, advice])


@pytest.mark.parametrize("value", ["2020-01-01", "2020-01-01T00:00:00Z", "12:30:00"])
def test_dates_are_no_values(infinivar, write, tmp_path, value):
    text = replaced('force = "50 N"', f"force = {value}")
    check(infinivar("compare", write(text)), tmp_path, ["requirement.force", value[:10], '"50 N"'])


def test_store_needs_its_efficiency(infinivar, write, tmp_path):
    text = mine("amplifier = {regeneration = 'store'}")
    check(infinivar("compare", write(text)), tmp_path, ["drives.mine.amplifier.storage_efficiency", "store"])


def test_a_motor_must_be_able_to_turn(infinivar, write, tmp_path):
    """A no-load current above the stall current, here 11.2 A, is a slip of the pen: mA or A."""
    text = mine("motor = {no_load_current = '53 A'}")
    check(infinivar("compare", write(text)), tmp_path, ["drives.mine.motor.no_load_current", "53"])


def test_missing_fields_say_what_they_mean(infinivar, write, tmp_path):
    text = tables("[drives.bare]\ntype = 'conventional'\n[drives.bare.motor]\nvoltage = '24 V'\n")
    words = ["bare.motor.resistance is missing (Terminal resistance", "[drives.bare.gearhead]", "[drives.bare.pulley]"]
    check(infinivar("compare", write(text)), tmp_path, words, lines=6)


def test_every_fault_is_named_at_once(infinivar, write, tmp_path):
    text = (
        with_value("requirement.force", 50) + "[drives.mine.transmission]\nprelaod = '650 N'\n[drives.b]\ntype = 'z'\n"
    )
    words = ["requirement.force = 50", "drives.mine.transmission.prelaod", "drives.b.type"]
    check(infinivar("compare", write(text)), tmp_path, words, lines=3)


@pytest.mark.parametrize(
    "text",
    [
        mine("[drives.mine.transmission]\n" + "".join(f"key{i} = {i}\n" for i in range(200))),
        tables("".join(f"[drives.d{i}]\ntype = 'conventional'\n" for i in range(100))),
        with_value("requirement.force", "x" * 100_000),
        with_value("requirement.force", "50 " + "N " * 20_000),
        with_value("requirement.force", "9" * 10_000 + " N"),
        with_value("requirement.force", [1] * 20_000),
        with_value("requirement.force", "a\\nb\\nc"),
        with_value("requirement.force", "\\u001b[31mred"),
    ],
    ids=["200 keys", "100 drives", "long text", "long unit", "long number", "long list", "lines", "colours"],
)
def test_the_message_stays_readable(infinivar, write, tmp_path, text):
    """However long the study's fault, the message fits a screen and holds no control characters."""
    outcome = infinivar("compare", write(text))
    assert (outcome.code, outcome.out) == (2, "")
    assert len(outcome.err) < 6000
    assert len(outcome.err.splitlines()) <= 25
    assert all(line.isprintable() and line.removeprefix("infinivar: ") for line in outcome.err.splitlines())
    assert all("study.toml: " in line or line.endswith("more faults") for line in outcome.err.splitlines())


EXTREMES = [
    ("requirement.force", "5e-324 N"),
    ("requirement.force", "1e30 N"),
    ("requirement.force", "1e308 N"),
    ("requirement.speed", "1e200 m/s"),
    ("requirement.power", "1 GW"),
    ("requirement.power", "1e300 W"),
    ("drives.mine.cylinder_speed", "1e30 rpm"),
    ("drives.mine.gearhead.ratio", 1e-200),
    ("drives.mine.gearhead.ratio", 1e200),
    ("drives.mine.gearhead.rated_torque", "1e200 N m"),
    ("drives.mine.amplifier.standby_power", "1e200 W"),
    ("drives.mine.motor.scale", 1e-300),
    ("drives.mine.motor.no_load_current", "1e200 A"),
    ("drives.mine.motor.torque_constant", "1e-300 N m/A"),
    ("drives.mine.transmission.cylinder_radius", "1e300 m"),
    ("drives.mine.transmission.cylinder_radius", "1e-300 m"),
    ("drives.mine.transmission.preload", "1e300 N"),
    ("drives.mine.transmission.preload", "1e30 N"),
    ("drives.mine.transmission.friction", 1e-300),
]


@pytest.mark.parametrize(("field", "value"), EXTREMES)
@pytest.mark.renders("svg")
def test_extremes_are_refused_or_computed(infinivar, write, tmp_path, field, value):
    """No overflow, no warning (warnings are errors here), no share beyond 1, no nan passed on as an answer."""
    outcome = infinivar("compare", write(with_value(field, value)), "--json")
    if outcome.code == 2:
        check(outcome, tmp_path, [field, str(value)])
        return
    assert outcome.err == ""
    drive = json.loads(outcome.out)["drives"]["mine"]
    assert outcome.code == (0 if drive["tightest_margin"]["value"] >= 1 else 1)
    assert 0 <= drive["coverage"] <= 1
    # A drive that covers nothing at the tightest point does not cover nearly everything.
    assert drive["coverage"] < 0.9 or drive["tightest_margin"]["value"] > 0.5


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("none.toml", "none.toml: no such file"),
        (".", "is a folder"),
        ("file/below.toml", "file/below.toml: cannot be read"),
        ("x" * 5000, "cannot be read"),
    ],
    ids=["missing", "folder", "below a file", "long"],
)
def test_paths_that_are_no_file(infinivar, tmp_path, path, words):
    (tmp_path / "file").touch()
    outcome = infinivar("compare", path)
    assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
    assert words in outcome.err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_results_of_a_good_run_survive_a_bad_one(infinivar, write, tmp_path):
    (tmp_path / "out").mkdir()
    for name in ("report.html", "results.json", "mine.nc"):
        (tmp_path / "out" / name).write_text("before", "utf-8")
    assert infinivar("compare", write(REQUIREMENT)).code == 2
    assert results(tmp_path / "out") == ["mine.nc", "report.html", "results.json"]
    assert {(tmp_path / "out" / name).read_text("utf-8") for name in results(tmp_path / "out")} == {"before"}


@pytest.mark.parametrize("json_too", [[], ["--json"]])
def test_console_script(write, tmp_path, json_too):
    """The installed program says the same: exit code 2, the message on stderr, nothing on stdout."""
    done = subprocess.run(
        [Path(sys.executable).with_name("infinivar"), "compare", write(with_value("requirement.force", 50)), *json_too],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    expected = 'infinivar: study.toml: requirement.force = 50 needs a unit; write for example "50 N"\n'
    assert (done.returncode, done.stdout, done.stderr) == (2, "", expected)


GOOD_WRITINGS = {
    "force": [
        "50 N",
        "50N",
        "5e1 N",
        "+50 N",
        " 50  N ",
        "0.05 kN",
        "50 newton",
        "50 kg m/s²",
        "50 kg·m/s^2",
        "50 J/m",
    ],
    "speed": ["1.05 m/s", "1.05 m s^-1", "3.78 km/h", "1050 mm/s", "1.05 m / s", "63 m/min"],
    "power": ["12 W", "12000 mW", "12 V A", "12 J/s", "12 N m/s", "0.012 kW"],
}


@pytest.mark.parametrize(("key", "text"), [(key, text) for key, texts in GOOD_WRITINGS.items() for text in texts])
def test_well_meant_writings_are_understood(write, tmp_path, key, text):
    from infinivar import load_study

    requirement = load_study(tmp_path / write(with_value(f"requirement.{key}", text))).requirement
    found = (requirement.force, requirement.speed, requirement.power)
    assert found == pytest.approx((50.0, 1.05, 12.0), rel=1e-12)


@pytest.mark.parametrize(
    "encode", [lambda text: text.replace("\n", "\r\n").encode(), lambda text: text.encode("utf-8-sig")]
)
def test_files_from_other_editors_are_read(write, tmp_path, encode):
    """Line ends and byte-order mark as editors on Windows write them."""
    from infinivar import load_study

    assert list(load_study(tmp_path / write(encode(GOOD))).drives) == ["mine", "geared"]
