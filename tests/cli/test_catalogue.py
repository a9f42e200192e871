"""`infinivar catalogue list|show|search|check|import`: what they print, exit codes and messages."""

import json

import pytest

import infinivar as iv
import partfiles
from internals import shipped

MORE = (
    '[motors.t3]\nvoltage = "24 V"\nresistance = "0.5 ohm"\ntorque_constant = "30 mN m/A"\nno_load_current = "0.1 A"\n'
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A user's folder of sets, empty, and files to import beside it."""
    monkeypatch.setenv("INFINIVAR_PARTS", str(tmp_path / "home"))
    return tmp_path


@pytest.fixture
def made(infinivar, folder):
    """The MGDB files of made-up parts, imported."""
    return infinivar("catalogue", "import", "made", *partfiles.write_mgdb(folder), "--date", "2024")


def test_import_keeps_good_rows_and_names_the_bad_ones(made, folder):
    assert made.code == 1
    assert made.err.splitlines() == [
        "infinivar: made_motors.csv:5: XX_D4: column 'R': must be a finite number, got '0.5-3'",
        "infinivar: made_motors.csv:6: XX_E5: column 'L': has no cell: line 1 has 21 headings, this line 7 cells",
        "infinivar: made_motors.csv:7: XX_F6: resistance must be > 0 ohm, got -0.5",
        "infinivar: made_gearboxes.csv:5: XX_G22_R5:1: the key is that of another gearhead, in line 4 of made_gearboxes.csv",
        "infinivar: made_compatibility.csv:2: XX_H99: no gearhead has this key",
        "infinivar: made_compatibility.csv:4: XX_F6: the motor was refused",
        "infinivar: made_compatibility.csv:5: XX_H*: no gearhead has such a key",
    ]
    assert made.out.splitlines() == [
        "3 motors, 3 gearheads, 4 compatible pairs; 7 rows refused",
        "  motors that do not state: viscous_friction 2, peak_torque 2, inductance 1, max_speed 1, winding_to_housing 2, "
        "housing_to_ambient 2, continuous_speed 2, stated_friction_torque 2",
        "  gearheads that do not state: continuous_torque 1, intermittent_torque 1, inertia 1, stages 1",
        "  1 motor does not state no_load_current: it cannot be used in a drive: XX_C3",
        "  1 motor does not state continuous_torque: it cannot be used in a drive: XX_C3",
        "  1 gearhead does not state efficiency: it cannot be used in a drive: XX_G22_R5:1",
        "  made_motors.csv: max_int_torque is infinite, read as not stated (2 lines: 2, 3)",
        "  made_motors.csv: max_cont_speed is infinite, read as not stated (2 lines: 2, 4)",
        "  made_motors.csv: max_cont_power is infinite, read as not stated (3 lines: 2, 3, 4)",
        "  made_motors.csv: the continuous torque is derived: k_t (I_nom - I_nl) (2 lines: 2, 3)",
        "  made_motors.csv: max_int_speed is infinite, read as not stated (1 line: 4)",
        "  made_motors.csv: Rth1 without Rth2 is a resistance from winding to ambient and was left out (1 line: 4)",
        "  made_gearboxes.csv: inertia is 0, read as not stated (1 line: 2)",
        "  made_gearboxes.csv: max_int_torque is infinite, read as not stated (1 line: 4)",
        "  made_gearboxes.csv: max_cont_torque is infinite, read as not stated (1 line: 4)",
        "  made_compatibility.csv: no gearhead fits the motor (1 line: 3)",
        f"Wrote {folder / 'home' / 'made.npz'}",
    ]
    assert iv.load_parts("made").motors.part("XX_A1").voltage == 24.0


def test_import_of_good_rows(infinivar, folder):
    path = partfiles.write(folder, "mine.toml", MORE)
    outcome = infinivar("catalogue", "import", "mine", path, "--to", "parts", "--source", "sheet 3", "--json")
    assert (outcome.code, outcome.err) == (0, "")
    result = json.loads(outcome.out)
    assert (result["file"], result["refused"]) == ("parts/mine.npz", [])
    others = dict.fromkeys(("gearheads", "bearings", "rails", "belts", "springs", "tubes", "materials"), 0)
    assert result["contents"] == {"motors": 1, **others}
    assert result["incomplete"] == {"motors": {"continuous_torque": 1}}
    again = infinivar("catalogue", "import", "mine", path, "--to", "parts")
    assert (again.code, again.err) == (
        2, "infinivar: parts/mine.npz: already exists; add --overwrite to replace it\n"
    )  # fmt: skip
    assert (
        infinivar("catalogue", "import", "mine", path, "--to", "parts", "--source", "sheet 3", "--overwrite").code == 0
    )
    shown = infinivar("catalogue", "show", "mine:t3").out
    assert "  from: sheet 3, imported 20" in shown
    assert "  cannot be used in a drive: continuous_torque not stated" in shown


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["import", "a b", "x.csv"], "'a b' is not a name for a set"),
        (["import", "shipped", "x.csv"], "'shipped' is not a name for a set"),
        (["import", "x", "x.csv"], "x.csv: no such file"),
        (["import", "x", "study.npz"], "study.npz: is a stored set already"),
        (["show", "re-40-24w"], "'re-40-24w' is not in the set shipped (did you mean 're-40-24v'?)"),
        (["show", "mine:a"], "'mine' is not a set of parts"),
        (["list", "mine"], "'mine' is not a set of parts"),
        (["list", "--kind", "wheels"], "'wheels' must be one of motors, gearheads, bearings, rails, belts, springs"),
        (["search", "wheels"], "'wheels' must be one of motors"),
        (["search", "motors", "mas < 1 kg"], "'mas' is no column of motors (did you mean 'mass'?)"),
        (["search", "motors", "--descending"], "--descending is of the column to sort by"),
        (["search", "motors", "--set", "x.toml"], "x.toml: no such file"),
        (["check", "nothing"], "'nothing' is not a set of parts"),
        (["--json", "list"], "--json must come after list"),
    ],
)
def test_what_is_refused(infinivar, folder, arguments, message):
    outcome = infinivar("catalogue", *arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert message in outcome.err
    assert len(outcome.err.splitlines()) == 1


def test_list(infinivar, folder, made):
    (folder / "parts").mkdir()
    partfiles.write(folder / "parts", "mine.toml", partfiles.TOML)
    partfiles.write(folder / "home", "bad.toml", "nonsense")
    listed = infinivar("catalogue", "list")
    home = folder / "home"
    assert listed.code == 0
    assert listed.out.splitlines() == [
        "shipped  22 motors, 46 gearheads, 40 bearings, 30 rails, 62 belts, 52 springs, 96 tubes, 7 materials  "
        "(comes with the program)",
        "mine     1 motor, 2 gearheads, 1 compatible pair; 1 row refused  (parts/mine.toml)",
        "made     3 motors, 3 gearheads, 4 compatible pairs  "
        f"({home / 'made.npz'})",
        f"bad      cannot be read: bad.toml: is not valid TOML: Expected '=' after a key in a key/value pair "
        f"(at end of document)  ({home / 'bad.toml'})",
    ]  # fmt: skip
    assert [row["name"] for row in json.loads(infinivar("catalogue", "list", "--json").out)] == [
        "shipped", "mine", "made", "bad"
    ]  # fmt: skip
    lines = infinivar("catalogue", "list", "made").out.splitlines()
    assert [line.split()[0] for line in lines if line] == [
        *("motor", "XX_A1", "XX_B2", "XX_C3", "gearhead", "XX_G16_R4:1", "XX_G16_R16:1", "XX_G22_R5:1")
    ]
    assert infinivar("catalogue", "list", "shipped").out == infinivar("catalogue").out
    assert infinivar("catalogue", "list", "made", "--kind", "gearheads").out.startswith("gearhead ")
    rows = json.loads(infinivar("catalogue", "list", "made", "--kind", "motors", "--json").out)["motors"]
    assert rows[0]["torque_constant"] == 0.03
    assert "peak_torque" not in rows[0]


def test_show(infinivar, made):
    text = infinivar("catalogue", "show", "made:XX_A1").out
    lines = text.splitlines()
    assert lines[:2] == ["motor made:XX_A1: Made Up A1", "  from: Made Up, A1, made_motors.csv, 2024"]
    assert any(line.split()[:3] == ["torque_constant", "30", "mN"] for line in lines)
    assert any(line.split()[:3] == ["max_speed", "11460", "rpm"] for line in lines)
    assert lines[-1] == "  gearheads: 3 fit (XX_G16_R4:1, XX_G16_R16:1, XX_G22_R5:1)"
    assert "peak_torque" not in text
    # A key may hold colons of its own.
    assert infinivar("catalogue", "show", "made:XX_G16_R4:1").out.startswith("gearhead made:XX_G16_R4:1: ")
    values = json.loads(infinivar("catalogue", "show", "re-40-24v", "--json").out)["motors"]
    assert values["resistance"] == iv.motors()["re-40-24v"].resistance
    assert values["order_number"] == "148867"
    assert "155 °C" in infinivar("catalogue", "show", "re-40-24v").out


def test_search(infinivar, made):
    found = infinivar(
        "catalogue", "search", "motors", "mass < 0.3 kg", "voltage = 24 V", "--sort", "mass", "--limit", "3"
    )
    assert (found.code, found.err) == (0, "")
    heading, *rows, verdict = found.out.splitlines()
    assert heading.split() == ["part", "mass", "voltage", "continuous_torque"]
    assert [row.split()[:3] for row in rows] == [
        ["dcx-16-l-24v", "42", "g"], ["dcx-19-s-24v", "50", "g"], ["dcx-22-s-24v", "66", "g"]
    ]  # fmt: skip
    expected = [key for key, motor in iv.motors().items() if motor.mass < 0.3 and motor.voltage == 24.0]
    assert verdict == f"{len(expected) + 1} of {len(iv.motors()) + 3} motors, 3 shown"
    own = infinivar("catalogue", "search", "motors", "mass = 200 g", "--set", "made", "--show", "type", "--json")
    result = json.loads(own.out)
    assert [part["part"] for part in result["parts"]] == ["made:XX_B2", "made:XX_C3"]
    assert result["parts"][0]["type"] == "BLDC"
    assert (result["count"], result["searched"]) == (2, 3)
    fitting = infinivar("catalogue", "search", "gearheads", "--fits", "made:XX_B2")
    assert [line.split()[0] for line in fitting.out.splitlines()] == ["part", "made:XX_G16_R4:1", "1"]
    none = infinivar("catalogue", "search", "gearheads", "efficiency > 99 %", "--set", "made")
    assert (none.code, none.out) == (1, "0 of 3 gearheads; 1 does not state efficiency\n")


def test_check(infinivar, made, folder):
    clean = infinivar("catalogue", "check", "shipped")
    assert (clean.code, clean.err) == (0, "")
    assert clean.out == f"{iv.check_parts(shipped()).verdict}\n"
    bad = partfiles.MGDB_MOTORS.replace("786", "300").replace("XX_A1", "XX_A9")
    path = partfiles.write(folder, "wrong.csv", bad)
    found = infinivar("catalogue", "check", path)
    assert found.code == 1
    assert "motor XX_A9: no-load speed 2865 rpm is stated, but (V - R I0)/K gives 7624 rpm (166.1 % off" in found.out
    assert "wrong.csv:5: XX_D4: column 'R': must be a finite number" in found.err
    results = json.loads(infinivar("catalogue", "check", path, "shipped", "--json").out)
    assert [one["set"] for one in results] == ["wrong", "shipped"]
    assert results[0]["contradictions"][0]["deviation"] == pytest.approx(1.661, abs=1e-3)
    assert len(results[0]["refused"]) == 3
    # All sets: those shipped and made; the latter agrees with itself.
    every = infinivar("catalogue", "check")
    assert every.code == 0
    assert [line.partition(":")[0] for line in every.out.splitlines() if line[0] != " "] == ["shipped", "made"]


def test_ten_worst_of_many(infinivar, folder):
    heading, row = partfiles.MGDB_MOTORS.splitlines()[:2]
    rows = [row.replace("XX_A1", f"XX_{speed}").replace("786", str(speed)) for speed in range(300, 420, 10)]
    partfiles.write(folder, "wrong.csv", "\n".join([heading, *rows]))
    found = infinivar("catalogue", "check", "wrong.csv").out.splitlines()
    assert found[0].endswith("12 rows contradict themselves")
    assert [line.split()[1] for line in found[1:11]] == [f"XX_{speed}:" for speed in range(300, 400, 10)]
    assert found[11:] == ["  ... and 2 more; --all lists them"]
    assert len(infinivar("catalogue", "check", "wrong.csv", "--all").out.splitlines()) == 13


def test_a_set_that_cannot_be_read_is_left_out_with_a_warning(infinivar, folder, made):
    """A search over all sets goes on; a check of all sets is not clean."""
    (folder / "home" / "bad.npz").write_bytes(b"PK nonsense")
    warning = "infinivar: the set bad was left out, as it cannot be read: "
    found = infinivar("catalogue", "search", "motors", "mass < 0.3 kg", "--json")
    assert found.code == 0
    assert found.err.startswith(warning)
    assert {one["set"] for one in json.loads(found.out)["parts"]} == {"made", "shipped"}
    outcome = infinivar("catalogue", "check")
    assert outcome.code == 1
    assert outcome.err.startswith(warning)
    assert "shipped: " in outcome.out
    named = infinivar("catalogue", "search", "motors", "--set", "bad")
    assert (named.code, named.out) == (2, "")
