"""A study file that is saved again keeps what its author wrote beside the values."""

import copy
import json
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from internals import shipped_studies, toml_tables
from sampled import examples

FILE = """# A drive
title = "Mine" # with a # in "quotes"

# What it must do
[requirement]
force = "50 N"   # measured = twice
"odd = key" = 1

# What the drive has
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
    lines = found.splitlines()
    changed = {'force = "50 N"   # measured = twice', '    "0.2 m", # lower', "ratio = 4 # first", "preload.value = 3"}
    assert set(FILE.splitlines()) - set(lines) == changed
    assert {'force = "40 N"   # measured = twice', '    "0.25 m", # lower', "ratio = 6 # first"} <= set(lines)
    assert lines.index('speed = "1 m/s"') == lines.index("# What the drive has") - 2


def test_rows_that_stay_keep_their_comments():
    tables = tomllib.loads(FILE)
    del tables["drives"]["a"]["lengths"][0]
    tables["drives"]["a"]["stages"].insert(0, {"ratio": 3})
    found = toml_tables.edited(FILE, tables)
    assert tomllib.loads(found) == tables
    assert '    "0.2 m", # lower\n' in found
    assert "upper" not in found
    assert found.index("ratio = 3\n") < found.index("ratio = 4 # first\n")


@pytest.mark.parametrize("text", ["", "title = ", "[[drives.a.stages]]\nratio = 1\n"])
def test_what_cannot_be_edited_is_written_anew(text):
    tables = copy.deepcopy(tomllib.loads(FILE))
    assert tomllib.loads(toml_tables.edited(text, tables)) == tables


def test_a_long_list_is_read_once():
    rows = [f"{0.001 * place:.3f}" for place in range(20_000)]
    text = "time = [\n" + "".join(f'  "{one} s",\n' for one in rows) + "]\n# end\n"
    tables = {"time": ["0 s", *tomllib.loads(text)["time"][1:]]}
    assert toml_tables.edited(text, tables).endswith("# end\n")


values = (
    st.text(max_size=8)
    | st.booleans()
    | st.integers(-9, 9)
    | st.floats(allow_nan=False)
    | st.lists(st.text(max_size=4), max_size=3)
)
added = values | st.dictionaries(st.text(max_size=4), values, max_size=2)


def annotated(text):
    """The text with a comment above and behind each statement of one line, and these statements by comment above."""
    lines, marked = [], {}
    for place, line in enumerate(text.splitlines()):
        try:
            statement = bool(tomllib.loads(line)) or line.startswith("[")
        except tomllib.TOMLDecodeError:
            statement = False
        if statement:
            marked[f"# above {place}"] = line = f"{line} # behind {place}"
            lines.append(f"# above {place}")
        lines.append(line)
    return "\n".join(lines) + "\n", marked


def within(value):
    """Every table and list in a value, itself included."""
    if isinstance(value, dict | list):
        yield value
        for one in value.values() if isinstance(value, dict) else value:
            yield from within(one)


@examples(60)
@given(data=st.data())
def test_any_edit_of_a_shipped_study_reads_back_and_keeps_the_comments_of_what_stays(data):
    file = data.draw(st.sampled_from(sorted(shipped_studies().values())))
    text, marked = annotated(file.read_text())
    tables = json.loads(json.dumps(tomllib.loads(text)))  # as the page sends them
    removed = False
    for _ in range(data.draw(st.integers(1, 5))):
        held = data.draw(st.sampled_from(list(within(tables))))
        places = list(held) if isinstance(held, dict) else list(range(len(held)))
        action = data.draw(st.sampled_from(["add", "change", "remove"] if places else ["add"]))
        if action == "add" and isinstance(held, dict):
            held.setdefault(data.draw(st.text(max_size=6)), data.draw(added))
        elif action == "add":
            held.insert(data.draw(st.integers(0, len(held))), data.draw(added))
        else:
            place = data.draw(st.sampled_from(places))
            removed |= action == "remove" or isinstance(held[place], dict | list)
            if action == "remove":
                del held[place]
            else:
                held[place] = data.draw(added)
    found = toml_tables.edited(text, tables)
    assert json.dumps(tomllib.loads(found), sort_keys=True) == json.dumps(tables, sort_keys=True)
    lines = found.splitlines()
    for above, line in marked.items():
        assert line not in lines or lines[lines.index(line) - 1] == above
        behind = line[line.rindex("# behind ") :]
        assert removed or (above in lines and any(one.endswith(behind) for one in lines))
