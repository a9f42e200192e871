"""Files of parts with random damage: every good row is kept, every bad one reported, and nothing else happens."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import infinivar as iv
import partfiles
from internals import importing

FILES = {
    "made_motors.csv": partfiles.MGDB_MOTORS,
    "made_gearboxes.csv": partfiles.MGDB_GEARBOXES,
    "made_compatibility.csv": partfiles.MGDB_COMPATIBILITY,
    "motors.csv": partfiles.CSV_MOTORS,
    "gearheads.csv": partfiles.CSV_GEARHEADS,
    "pairs.csv": partfiles.CSV_PAIRS,
    "mine.toml": partfiles.TOML,
}
DIRT = st.sampled_from(
    ["", ",", ";", "\n", "\r", "\t", '"', "'", "[", "]", "{", "}", "=", "#", "\x00", "\x1b[2J", "nan", "Inf", "-1e999", "1e-300",
     "é", "−", "*", "_", "0x1", "true", "[motors.t1]", "key", "[pairs]", "friction = 3", "1979-05-27", '"""']
)  # fmt: skip


@given(
    name=st.sampled_from(sorted(FILES)),
    wounds=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), DIRT), min_size=1, max_size=4),
)
def test_damage_is_reported_and_nothing_is_lost(tmp_path_factory, name, wounds):
    text = FILES[name]
    for where, cut, dirt in wounds:
        at = int(where * len(text))
        text = text[:at] + dirt + text[at + cut :]
    folder = tmp_path_factory.mktemp("damaged")
    (folder / name).write_text(text, "utf-8", newline="")
    message, found = outcome(iv.import_parts, folder / name)
    if found is None:
        assert name in message
        return
    for fault in found.faults:
        assert fault.file == name
        assert fault.reason
        assert str(fault).isprintable()
    for table in found.parts.tables.values():
        for column in table.columns.values():
            assert not np.isinf(column).any()
        for row in np.flatnonzero(table.complete):
            # Each value is permitted, but some may conflict.
            message, part = outcome(table.part, int(row))
            assert part is not None or table.part_keys[row] in message
    iv.check_parts(found.parts)
    again = importing.read(importing.write(found.parts, folder / "again.npz"), found.parts.name)
    assert again == found.parts


def outcome(call, *arguments):
    """Message of an input error, and what is returned otherwise."""
    try:
        return "", call(*arguments)
    except iv.InputError as problem:
        return str(problem), None


@given(rows=st.lists(st.sampled_from(["good", "short", "word", "negative", "twice", "empty"]), min_size=1, max_size=12))
def test_each_row_is_kept_or_reported(tmp_path_factory, rows):
    """The number of rows kept and that of rows refused add up to those of the file, whatever their order."""
    path = tmp_path_factory.mktemp("rows") / "rows.csv"
    text = {
        "good": "{0},24,0.5,30\n",
        "short": "{0},24,0.5\n",
        "word": "{0},24,half,30\n",
        "negative": "{0},24,-0.5,30\n",
        "twice": "same,24,0.5,30\n",
        "empty": "{0},,,\n",
    }
    lines = "".join(text[row].format(f"k{place}") for place, row in enumerate(rows))
    path.write_text(f"key,voltage [V],resistance [ohm],torque_constant [mN m/A]\n{lines}", "utf-8")
    good = [f"k{place}" for place, row in enumerate(rows) if row in ("good", "empty")] + ["same"] * ("twice" in rows)
    bad = sum(row in ("short", "word", "negative") for row in rows) + max(0, rows.count("twice") - 1)
    _, found = outcome(iv.import_parts, path)
    if found is None:
        assert not good
        return
    assert sorted(found.parts.motors.part_keys) == sorted(good)
    assert len(found.faults) == bad
    refused = [place + 2 for place, row in enumerate(rows) if row in ("short", "word", "negative")]
    assert set(refused) <= {fault.line for fault in found.faults}
