"""A study file that is saved again keeps what its author wrote beside the values."""

import copy
import tomllib

import pytest

from internals import shipped_studies, toml_tables

FILE = """# A drive
title = "Mine" # with a # in "quotes"

# What it must do
[requirement]
force = "50 N"   # measured = twice
"odd = key" = 1

[drives.a]
lengths = [
    "0.3 m", # upper
    "0.2 m", # lower
]
motor = { voltage = "24 V" }
preload.value = 3

[[drives.a.stages]]
ratio = 4 # first
[[drives.a.stages]]
ratio = 5
"""


@pytest.mark.parametrize("text", [FILE, FILE.rstrip("\n"), *(one.read_text() for one in shipped_studies().values())])
def test_what_is_not_changed_stays_as_it_stands(text):
    assert toml_tables.edited(text, tomllib.loads(text)).rstrip("\n") == text.rstrip("\n")


def test_a_changed_value_stands_in_its_line_and_a_new_one_in_its_table():
    tables = tomllib.loads(FILE)
    tables["requirement"] |= {"force": "40 N", "speed": "1 m/s"}
    tables["drives"]["a"]["lengths"][1] = "0.25 m"
    tables["drives"]["a"]["stages"][0]["ratio"] = 6
    tables["drives"]["b"] = {"like": "a", "motor": {"voltage": "12 V"}}
    del tables["drives"]["a"]["preload"]
    found = toml_tables.edited(FILE, tables)
    assert tomllib.loads(found) == tables
    changed = ("upper", "lower", "twice", "first")
    kept = [line for line in FILE.splitlines() if "#" in line and not line.endswith(changed)]
    assert set(kept) <= set(found.splitlines())
    assert 'force = "40 N"  # measured = twice' in found
    assert "ratio = 6  # first" in found
    assert found.index("[requirement]") < found.index('speed = "1 m/s"') < found.index("[drives.a]")


@pytest.mark.parametrize("text", ["", "title = ", "[[drives.a.stages]]\nratio = 1\n"])
def test_what_cannot_be_edited_is_written_anew(text):
    tables = copy.deepcopy(tomllib.loads(FILE))
    assert tomllib.loads(toml_tables.edited(text, tables)) == tables


def test_a_long_list_is_read_once():
    rows = [f"{0.001 * place:.3f}" for place in range(20_000)]
    text = "time = [\n" + "".join(f'  "{one} s",\n' for one in rows) + "]\n# end\n"
    tables = {"time": ["0 s", *tomllib.loads(text)["time"][1:]]}
    assert toml_tables.edited(text, tables).endswith("# end\n")
