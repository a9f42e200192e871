"""Sets of parts from files: what each format gives, what is refused and why, and how sets are stored."""

import math

import numpy as np
import pytest

import infinivar as iv
import partfiles
from infinivar import units
from internals import importing, number_columns, part_set, text_columns
from internals import part_table as table


def lines(entries):
    return [str(entry) for entry in entries]


@pytest.fixture
def made(tmp_path):
    return iv.import_parts(partfiles.write_mgdb(tmp_path), name="made", date="2024")


def test_mgdb_keeps_good_rows_and_reports_the_others(made):
    assert made.parts.motors.part_keys == ("XX_A1", "XX_B2", "XX_C3")
    assert made.parts.gearheads.part_keys == ("XX_G16_R4:1", "XX_G16_R16:1", "XX_G22_R5:1")
    assert lines(made.faults) == [
        "made_motors.csv:5: XX_D4: column 'R': must be a finite number, got '0.5-3'",
        "made_motors.csv:6: XX_E5: column 'L': has no cell: line 1 has 21 headings, this line 7 cells",
        "made_motors.csv:7: XX_F6: resistance must be > 0 ohm, got -0.5",
        "made_gearboxes.csv:5: XX_G22_R5:1: the key is that of another gearhead, in line 4 of made_gearboxes.csv",
        "made_compatibility.csv:2: XX_H99: no gearhead has this key",
        "made_compatibility.csv:4: XX_F6: the motor was refused",
        "made_compatibility.csv:5: XX_H*: no gearhead has such a key",
    ]
    remarks = lines(made.remarks)
    for expected in (
        "made_motors.csv: max_int_torque is infinite, read as not stated (2 lines: 2, 3)",
        "made_motors.csv: the continuous torque is derived: k_t (I_nom - I_nl) (2 lines: 2, 3)",
        "made_motors.csv: Rth1 without Rth2 is a resistance from winding to ambient and was left out (1 line: 4)",
        "made_gearboxes.csv: inertia is 0, read as not stated (1 line: 2)",
        "made_compatibility.csv: no gearhead fits the motor (1 line: 3)",
    ):
        assert expected in remarks
    assert made.verdict == "3 motors, 3 gearheads, 4 compatible pairs; 7 rows refused"
    assert made.incomplete == {"motors": {"no_load_current": 1, "continuous_torque": 1}, "gearheads": {"efficiency": 1}}


def test_mgdb_values(made):
    motors, gearheads = made.parts.motors, made.parts.gearheads
    assert motors["voltage"].tolist() == [24.0, 24.0, 48.0]
    # Limits that are not stated are infinite in the file, values empty or NaN: all are nan here.
    np.testing.assert_array_equal(motors["peak_torque"], [math.nan, math.nan, 4.0])
    np.testing.assert_array_equal(motors["max_speed"], [1200.0, 1500.0, math.nan])
    np.testing.assert_array_equal(motors["winding_to_housing"], [2.0, math.nan, math.nan])
    np.testing.assert_array_equal(motors["viscous_friction"], [math.nan, 1.5e-6, math.nan])
    np.testing.assert_array_equal(gearheads["efficiency"], [0.9, 0.8, math.nan])
    np.testing.assert_array_equal(gearheads["intermittent_torque"], [0.3, 0.5, math.nan])
    first = motors.part("XX_A1")
    assert first.continuous_torque == pytest.approx(0.03 * (3 - 0.1), rel=1e-15)
    assert first.continuous_current == pytest.approx(3.0, rel=1e-15)
    assert (first.peak_torque, first.diameter, first.name) == (None, None, "Made Up A1")
    second = motors.part(1)
    assert second.viscous_friction == 1.5e-6
    assert second.friction_torque < second.no_load_torque
    assert gearheads.part("XX_G16_R16:1") == iv.parts.Gearhead(
        name="Made Up G16_R16:1",
        ratio=16,
        efficiency=0.8,
        continuous_torque=0.4,
        intermittent_torque=0.5,
        inertia=1e-8,
        mass=0.03,
    )
    assert motors.stated("XX_A1")["order_number"] == "A1"
    assert motors.stated("XX_A1")["source"] == "made_motors.csv"
    assert motors.stated("XX_A1")["date"] == "2024"


def test_mgdb_pairs_are_rows_of_both_tables(made):
    keys = [
        (made.parts.motors.part_keys[motor], made.parts.gearheads.part_keys[gearhead])
        for motor, gearhead in made.parts.pairs
    ]
    assert keys == [
        ("XX_A1", "XX_G16_R4:1"),
        ("XX_A1", "XX_G16_R16:1"),
        ("XX_A1", "XX_G22_R5:1"),
        ("XX_B2", "XX_G16_R4:1"),
    ]
    assert made.parts.pairs_stated
    assert made.parts.gearheads_for("XX_A1") == ("XX_G16_R4:1", "XX_G16_R16:1", "XX_G22_R5:1")
    assert made.parts.gearheads_for("XX_C3") == ()


@pytest.mark.parametrize(
    ("kind", "key", "message"),
    [
        ("motors", "XX_C3", "motor XX_C3: no_load_current is not stated"),
        ("gearheads", "XX_G22_R5:1", "gearhead XX_G22_R5:1: efficiency is not stated"),
        ("motors", "XX_A11", r"'XX_A11' is not among the 3 motors \(did you mean 'XX_A1'\?\)"),
        ("motors", 3, "row 3 must be >= 0 and < 3"),
    ],
)
def test_rows_that_are_no_part(made, kind, key, message):
    with pytest.raises(iv.InputError, match=message):
        made.parts.tables[kind].part(key)


@pytest.fixture
def plain(tmp_path):
    return iv.import_parts(partfiles.write_csv(tmp_path), name="plain")


def test_csv_reads_the_units_of_its_headings(plain):
    motors = plain.parts.motors
    assert motors.part_keys == ("m1", "m2", "m3")
    # The same as a study file would read.
    assert motors["torque_constant"][0] == units.parse("30 mN m/A", "N m/A")
    assert motors["max_speed"][0] == units.parse("12000 rpm", "rad/s")
    np.testing.assert_array_equal(motors["mass"], [0.3, 0.2, math.nan])
    assert math.isnan(motors["max_speed"][1])
    assert plain.parts.gearheads["efficiency"].tolist() == [0.9, 0.8]
    assert motors.part("m1").name == "First"
    assert plain.parts.pairs.tolist() == [[0, 0], [0, 1], [1, 0]]
    assert lines(plain.faults) == [
        "motors.csv:5: m4: column 'resistance [ohm]': must be a finite number, got 'nought'",
        "motors.csv:6: m5: resistance must be > 0 ohm, got 0.0",
        "gearheads.csv:4: g3: efficiency must be > 0 and <= 1, got 1.8, written as 180 %",
        "pairs.csv:4: g9: no gearhead has this key",
    ]
    assert lines(plain.remarks) == ["motors.csv: column 'colour' is no column of motors and was left out"]
    assert plain.incomplete == {"motors": {"continuous_torque": 1}}


HEAD = "key,voltage [V],resistance [ohm],torque_constant [mN m/A]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            HEAD.replace(" [V]", "") + "a,1,2,3\n",
            r"x.csv: line 1, column 'voltage': must state its unit, such as 'voltage \[V\]'",
        ),
        (
            HEAD.replace("[V]", "[A]") + "a,1,2,3\n",
            r"x.csv: line 1, column 'voltage \[A\]': has the unit 'A' where V is needed",
        ),
        (HEAD.replace("mN m/A", "mNm") + "a,1,2,3\n", "has the unit 'mN m' where N m/A is needed"),
        (
            HEAD.replace("resistance [ohm]", "voltage [mV]") + "a,1,2,3\n",
            r"column 'voltage \[mV\]': stands there twice",
        ),
        ("name,colour\na,b\n", "must have headings with key and the columns of one kind of part"),
        ("", "the file is empty"),
        (HEAD, "no row could be read"),
        (HEAD + 'a,"1,2,3\nb,1,2,3\n', "x.csv: line 2: has a quote that is not closed"),
        (HEAD + "a\n", r"x.csv:2: a: column 'voltage \[V\]': has no cell: line 1 has 4 headings, this line 1 cell"),
        ("key,ratio,efficiency [%]\na,4,190\n", "efficiency must be > 0 and <= 1, got 1.9, written as 190 %"),
        (HEAD + "a,1,-2,3\n", "(?s)no row could be read.*x.csv:2: a: resistance must be > 0 ohm, got -2.0"),
        (HEAD + 'a,"1.001,5",2,3\n', "must have a decimal comma and no other mark, as cells above, got '1.001,5'"),
        (HEAD + ",1,2,3\n", "x.csv:2: key is missing"),
        ("motor,gearhead\na,b\n", "no row could be read"),
        (partfiles.MOTOR_HEADINGS + "\n" + "a," * 20 + "1_0\n", "column 'V': must be a finite number, got 'a'"),
    ],
)
def test_a_csv_file_that_cannot_be_read_says_why(tmp_path, text, message):
    with pytest.raises(iv.InputError, match=message):
        iv.import_parts(partfiles.write(tmp_path, "x.csv", text))


WRITINGS = {
    "units behind the name": "key,ratio,efficiency_pct,continuous_torque_Nm\ng1,4,90,0.2\ng2,16,80,0.4\n",
    "a stroke and a leading sign": "key;Ratio;% efficiency;Continuous torque / Nm\ng1;4;90;0.2\ng2;16;80;0.4\n",
    "tabs and decimal commas": "key\tratio\tefficiency\tcontinuous_torque [N m]\ng1\t4\t0,9\t0,2\ng2\t16\t0,8\t0,4\n",
    "cells and headings left over": "key,ratio,efficiency,continuous_torque [N m],,\ng1,4,0.9,0.2,,,\ng2,16,0.8,0.4\n",
    "a heading on two lines": 'key,ratio,efficiency,"continuous torque\n(N m)"\ng1,4,0.9,0.2\n\ng2,16,0.8,0.4\n',
    "text behind a closing quote": 'key,ratio,efficiency,continuous_torque [N m]\n"g1" ,4,0.9,0.2\ng2, "16",0.8,0.4\n',
}


@pytest.mark.parametrize("name", WRITINGS)
def test_a_list_in_every_writing_is_one_list(tmp_path, name):
    found = iv.import_parts(partfiles.write(tmp_path, "gearheads.csv", WRITINGS[name]))
    assert (found.faults, found.remarks) == ((), ())
    gearheads = found.parts.gearheads
    assert gearheads.part_keys == ("g1", "g2")
    for column, values in {"ratio": [4, 16], "efficiency": [0.9, 0.8], "continuous_torque": [0.2, 0.4]}.items():
        assert gearheads[column].tolist() == values


def test_a_slip_in_quotes_costs_one_row(tmp_path):
    text = 'key,ratio,efficiency\na,"4"5,0.9\nb,"x"y,0.9\nc,16,0.8\n'
    found = iv.import_parts(partfiles.write(tmp_path, "g.csv", text))
    assert found.parts.gearheads["ratio"].tolist() == [45.0, 16.0]
    assert lines(found.faults) == ["g.csv:3: b: column 'ratio': must be a finite number, got 'xy'"]


def test_toml_takes_the_words_of_a_study(tmp_path):
    found = iv.import_parts(partfiles.write(tmp_path, "mine.toml", partfiles.TOML))
    assert found.parts.name == "mine"
    assert lines(found.faults) == [
        "mine.toml:16: t2: resistance = '0.5 ohm m' has the unit 'ohm m' where ohm is needed; write for example \"2.14 ohm\""
    ]
    assert found.parts.motors.stated("t1") | {"voltage": 24.0} == {
        "key": "t1", "name": "T 1", "manufacturer": "Made Up", "order_number": "4711", "source": "data sheet 7",
        "date": "2024-05", "kind": "catalogue", "voltage": 24.0, "resistance": 0.5, "torque_constant": 0.03,
        "no_load_current": 0.1, "continuous_torque": 0.09, "mass": 0.3,
    }  # fmt: skip
    assert found.parts.gearheads.part("h2").friction == iv.parts.GearFriction(friction=5.0)
    assert found.parts.pairs.tolist() == [[0, 0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[motors.a]\nvoltage = 3\n", "voltage = '3' needs a unit"),
        ("[motors.a]\nvoltag = '3 V'\n", r"voltag is not a known key of a motor \(did you mean 'voltage'\?\)"),
        ("[a]\nratio = 4\nkind = 'measured'\n", "kind = 'measured' must be one of stated, catalogue"),
        ("[a]\nname = 'x'\n", r"\[a\] has no value that tells its kind; write one of \[motors.a\]"),
        ("[bearings.a]\ntype = 'magnetic'\n", "type = 'magnetic' must be one of deep_groove"),
        ("[motors.a]\nvoltage = true\n", "voltage = 'True' must be a number with a unit"),
        ("motors = 3\n", "x.toml: motors must be a table of parts"),
        ("pairs = 3\n[a]\nratio = 4\n", "pairs must be a table"),
        ("[a]\nratio = 4\n[pairs]\nb = 3\n", "pairs.b must be a list of keys of gearheads"),
        ("[a\n", "x.toml: is not valid TOML"),
        ("[motors]\na = 3\n", "x.toml: a: must be a table of values"),
        ("[a]\nratio = 4\nname = ['x']\n", "name must be text"),
        ("[a]\nratio = {unit = '1'}\n", "ratio = .* must be a value, or a table with value"),
    ],
)
def test_a_toml_file_that_cannot_be_read_says_why(tmp_path, text, message):
    with pytest.raises(iv.InputError, match=message):
        iv.import_parts(partfiles.write(tmp_path, "x.toml", text))


def test_shares_below_one_percent_are_noted(tmp_path):
    """A fraction in a column of percent is most probably an error, which no check of the row can find."""
    path = partfiles.write(tmp_path, "g.csv", "key,ratio,efficiency [%]\na,4,0.9\nb,9,0.8\nc,16,-\n")
    found = iv.import_parts(path)
    assert found.parts.gearheads["efficiency"][:2].tolist() == pytest.approx([0.009, 0.008])
    assert lines(found.remarks) == [
        "g.csv: column 'efficiency [%]' was read in percent, 0.9 as 0.9 %; if its values are fractions, write efficiency [1]"
    ]
    assert not iv.import_parts(
        partfiles.write(tmp_path, "g.csv", "key,ratio,efficiency [%]\na,4,0.9\nb,9,80\n")
    ).remarks


def test_dates(tmp_path):
    path = partfiles.write(tmp_path, "g.csv", "key,ratio,date\na,4,2020-13-45\nb,9,2020-12\nc,9,\n")
    found = iv.import_parts(path, date="2024-05-31")
    assert found.parts.gearheads["date"].tolist() == ["2020-13-45", "2020-12", "2024-05-31"]
    assert lines(found.remarks) == [
        "g.csv: date '2020-13-45' is no date such as 2026, 2026-03 or 2026-03-31; it was kept as text (1 line: 2)"
    ]
    for date in ("banana", "2024-5", "31.5.2024"):
        with pytest.raises(iv.InputError, match=f"date '{date}' must be a year, month or day"):
            iv.import_parts(path, date=date)


def test_pairs_say_that_a_row_was_refused(tmp_path):
    motors = partfiles.write(tmp_path, "m.csv", HEAD + "a,1,2,3\nb,x,2,3\nc,1,-2,3\nd,1\n")
    gearheads = partfiles.write(tmp_path, "g.csv", "key,ratio\ng,4\n")
    pairs = partfiles.write(tmp_path, "p.csv", "motor,gearhead\na,g\nb,g\nc,g\nd,g\n")
    faults = lines(iv.import_parts([motors, gearheads, pairs]).faults)
    assert [line for line in faults if line.startswith("p.csv")] == [
        f"p.csv:{at}: {key}: the motor was refused" for at, key in ((3, "b"), (4, "c"), (5, "d"))
    ]


def test_files_that_hold_no_parts(tmp_path):
    for name, message in [
        ("x.npz", "is a stored set already"),
        ("x.xlsx", "must be a .csv or .toml file"),
        ("none.csv", "no such file"),
    ]:
        with pytest.raises(iv.InputError, match=message):
            iv.import_parts(tmp_path / name)
    (tmp_path / "x.csv").write_bytes(b"key,\x93\n")
    with pytest.raises(iv.InputError, match="is neither UTF-8 nor Latin-1"):
        iv.import_parts([tmp_path / "x.csv"])
    with pytest.raises(iv.InputError, match="at least one file"):
        iv.import_parts([])


def test_a_set_is_stored_without_loss(made, plain, tmp_path):
    for found in (made, plain):
        path = importing.write(found.parts, tmp_path / f"{found.parts.name}.npz")
        again = importing.read(path)
        assert again == found.parts
        assert again.path == path
        assert again.motors.part(0) == found.parts.motors.part(0)
    assert [one.name for one in tmp_path.glob(".*")] == []


def test_unstated_pairs_stay_unstated(tmp_path):
    one = table("motors", [{"key": "a"}, {"key": "b"}])
    other = table("gearheads", [{"key": "g", "ratio": 3.0}, {"key": "h", "loss_model": "stribeck"}])
    parts = part_set("x", [one, other])
    # The friction of a whole actuator is of its own motor.
    assert parts.pairs.tolist() == [[0, 0], [1, 0]]
    assert not parts.pairs_stated
    assert importing.read(importing.write(parts, tmp_path / "x.npz")) == parts
    none = part_set("x", [one, other], np.empty((0, 2)))
    assert none.pairs_stated
    assert importing.read(importing.write(none, tmp_path / "x.npz")) == none


def test_a_file_that_is_no_set(made, tmp_path):
    path = tmp_path / "x.npz"
    with pytest.raises(iv.InputError, match="no such file"):
        importing.read(path)
    path.write_bytes(b"PK nonsense")
    with pytest.raises(iv.InputError, match="is no set of parts"):
        importing.read(path)
    importing.write(made.parts, path)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(iv.InputError, match="is no set of parts"):
        importing.read(path)
    np.savez(path, mass=np.array([1.0]))
    with pytest.raises(iv.InputError, match="is no set of parts, but a NumPy archive of something else"):
        importing.read(path)
    np.savez(path, format=np.array(99))
    with pytest.raises(iv.InputError, match="written by another version"):
        importing.read(path)
    np.savez(path, **{"format": np.array(1), "motors.key": np.array(["a"]), "motors.columns": np.array(["mass"]),
                      "motors.numbers": np.array([[1.0, 2.0]])})  # fmt: skip
    with pytest.raises(iv.InputError, match=r"motors\.mass is no column of 1 numbers"):
        importing.read(path)
    random = np.random.default_rng(3)
    for _ in range(60):
        damaged = bytearray(content)
        for place in random.integers(0, len(content), 5):
            damaged[place] = int(random.integers(256))
        path.write_bytes(bytes(damaged))
        try:
            importing.read(path)
        except iv.InputError:
            continue
    with pytest.raises(iv.InputError, match="cannot be written"):
        importing.write(made.parts, path / "below" / "x.npz")


def test_columns_are_the_fields_of_the_parts():
    """Another package may rely on these names: all fields of a part that are numbers, in SI."""
    assert {"voltage", "resistance", "torque_constant", "rotor_inertia", "mass"} <= set(number_columns("motors"))
    assert {"ratio", "efficiency", "continuous_torque", "inertia"} <= set(number_columns("gearheads"))
    assert number_columns("motors")["torque_constant"].unit == "N m/A"
    assert set(text_columns("bearings")) >= {"key", "manufacturer", "order_number", "source", "date", "series"}
    empty = table("motors", [])
    assert set(empty.columns) == set(number_columns("motors"))
    assert (len(empty), bool(empty)) == (0, False)


def test_tables_refuse_what_they_cannot_hold():
    for rows, message in [
        ([{"name": "a"}], r"motors\[0\].key must be text"),
        ([{"key": "a"}, {"key": "a"}], r"motors\[1\].key = 'a' must differ"),
        ([{"key": "a", "massive": 1.0}], r"'massive' is no column of motors \(did you mean 'mass'\?\)"),
    ]:
        with pytest.raises(iv.InputError, match=message):
            table("motors", rows)
    with pytest.raises(iv.InputError, match="must be one of motors"):
        table("wheels", [])
    with pytest.raises(iv.InputError, match="is no column of motors"):
        table("motors", [])["ratio"]
    with pytest.raises(iv.ParameterError, match="pairs must be rows of 1 motors and 0 gearheads"):
        part_set("x", [table("motors", [{"key": "a"}])], np.array([[0, 0]]))
    with pytest.raises(iv.ParameterError, match="tables must be of different kinds"):
        part_set("x", [table("motors", []), table("motors", [])])


def test_sets_are_frozen(made):
    with pytest.raises(ValueError, match="read-only"):
        made.parts.motors["mass"][0] = 1.0
    with pytest.raises(TypeError, match="frozen"):
        made.parts.motors.columns["mass"] = np.zeros(3)
    assert "3 motors, 3 gearheads" in repr(made.parts)
    assert "voltage: 24 to 48 V" in repr(made.parts.motors)
