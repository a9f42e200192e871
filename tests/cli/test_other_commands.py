"""`schema`, `init`, `catalogue`, `--version`, wrong usage, and running as a module."""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import infinivar as iv
from folders import results
from infinivar import bearings, belts, gearheads, materials, motors, rails, springs, tubes
from infinivar.parts import Bearing
from internals import parameter_set
from sampled import sampled


def bash(command, folder):
    """A line typed in a shell where `infinivar` is installed."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    return subprocess.run(["bash", "-c", command], cwd=folder, capture_output=True, text=True, env=environment)


# A validator for the few words of JSON Schema that the schema uses: enough to try it on real studies.
WORDS = {"$schema", "$defs", "$ref", "title", "description", "examples", "type", "enum", "const", "pattern", "required"} | {
    "properties", "additionalProperties", "anyOf", "minProperties", "propertyNames", "items", "minItems", "maxItems",
    "exclusiveMinimum", "exclusiveMaximum",
}  # fmt: skip
TYPES = {"object": dict, "string": str, "number": (int, float), "integer": int, "array": list}


def valid(value, schema, root):
    assert schema.keys() <= WORDS, schema.keys() - WORDS
    if "$ref" in schema:
        return valid(value, root["$defs"][schema["$ref"].removeprefix("#/$defs/")], root)
    if "anyOf" in schema and not any(valid(value, option, root) for option in schema["anyOf"]):
        return False
    if "enum" in schema and value not in schema["enum"]:
        return False
    if "const" in schema and value != schema["const"]:
        return False
    if "type" in schema and (not isinstance(value, TYPES[schema["type"]]) or isinstance(value, bool)):
        return False
    if isinstance(value, str) and not re.search(schema.get("pattern", ""), value):
        return False
    if isinstance(value, list):
        count = schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
        return count and all(valid(item, schema.get("items", {}), root) for item in value)
    if isinstance(value, float) and not schema.get("exclusiveMinimum", -2) < value < schema.get(
        "exclusiveMaximum", 1e300
    ):
        return False
    if not isinstance(value, dict):
        return True
    known, other = schema.get("properties", {}), schema.get("additionalProperties", True)
    return (
        len(value) >= schema.get("minProperties", 0)
        and all(key in value for key in schema.get("required", ()))
        and all(valid(key, schema.get("propertyNames", {}), root) for key in value)
        and all(
            valid(item, known[key], root)
            if key in known
            else other
            if isinstance(other, bool)
            else valid(item, other, root)
            for key, item in value.items()
        )
    )


@pytest.fixture
def schema(infinivar):
    outcome = infinivar("schema")
    assert (outcome.code, outcome.err) == (0, "")
    return json.loads(outcome.out)


GOOD = {"requirement": {"force": "50 N", "speed": "1 m/s"}, "drives": {"mine": {"base": "faulring2006.cobotic"}}}


def test_schema_refers_only_to_what_it_defines(schema):
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    referred = set(re.findall(r'"#/\$defs/(\w+)"', json.dumps(schema)))
    assert referred == set(schema["$defs"])
    closed = {name: part["additionalProperties"] for name, part in schema["$defs"].items() if name != "Spreads"}
    assert set(closed.values()) == {False}


def test_schema_accepts_what_compare_accepts(schema, infinivar, tmp_path):
    infinivar("init", "mine")
    shipped = Path(__file__).parents[2] / "studies" / "hand_controller.toml"
    for path in (shipped, tmp_path / "mine.toml"):
        assert valid(tomllib.loads(path.read_text("utf-8")), schema, schema), path
    full = parameter_set("faulring2006")
    assert valid({key: full[key] for key in ("title", "requirement", "drives")}, schema, schema)
    assert valid(GOOD, schema, schema)
    assert valid({"extends": "other.toml"}, schema, schema)
    spread = {"transmission": {"preload": "5 %", "friction": {"low": 0.1, "high": 0.2}}, "kind": "assumed"}
    pair = {"drive": "mine", "between": ["transmission.preload", "transmission.friction"], "value": 0.5}
    more = {"rig": {"travel": "0.1 m"}, "uncertainty": {"draws": 64, "mine": spread}, "correlations": [pair]}
    assert valid({**GOOD, **more}, schema, schema)


@sampled(
    "change",
    [
        {"drivs": {}},
        {"drives": {}},
        {"drives": {"a b": {"base": "x.y"}}},
        {"requirement": {"forse": "50 N"}},
        {"requirement": {"force": 50}},
        {"requirement": {"force": "N"}},
        {"requirement": {"force": {"value": "50 N", "knd": "stated"}}},
        {"requirement": {"force": {"kind": "stated"}}},
        {"requirement": {"quadrants": 3}},
        {"drives": {"mine": {"type": "cobotix"}}},
        {"drives": {"mine": {"type": "cobotic", "motor": 5}}},
        {"drives": {"mine": {"type": "cobotic", "motor": {"resistence": "2 ohm"}}}},
        {"drives": {"mine": {"type": "conventional", "transmission": {}}}},
        {"drives": {"mine": {"amplifier": {"regeneration": "brun"}}}},
        {"title": 5},
        {"rig": {"travl": "1 m"}},
        {"uncertainty": {"draws": "many"}},
        {"correlations": [{"drive": "mine", "between": ["a"], "value": 0.5}]},
        {"correlations": [{"drive": "mine", "between": ["a", "b"], "value": 1.5}]},
    ],
    ids=str,
    every=3,
)
def test_schema_refuses_what_compare_refuses(schema, change):
    assert not valid({**GOOD, **change}, schema, schema)


@pytest.mark.slow
def test_init_writes_a_study_that_compare_takes(infinivar, tmp_path):
    outcome = infinivar("init", "my_hand-controller")
    assert (outcome.code, outcome.err) == (0, "")
    assert results(tmp_path) == ["infinivar.schema.json", "my_hand-controller.toml"]
    assert iv.load_study(tmp_path / "my_hand-controller.toml").title == "My hand controller"
    # It names the next command; take it at its word.
    command = re.search(r"infinivar (compare .*)\n", outcome.out)[1].split()
    assert infinivar(*command).code == 0
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("like", [(), ("--like", "knee_walking")], ids=["template", "shipped"])
def test_init_names_the_schema_that_it_writes(infinivar, schema, tmp_path, like):
    """The first line is the directive of Taplo, relative to the study: editors find the schema, and the study keeps it."""
    (tmp_path / "folder").mkdir()
    assert infinivar("init", "folder/mine", *like).code == 0
    study = tmp_path / "folder" / "mine.toml"
    directive = study.read_text("utf-8").split("\n")[0]
    assert re.fullmatch(r"#:schema \./\S+", directive)
    named = study.parent / directive.removeprefix("#:schema ")
    assert json.loads(named.read_text("utf-8")) == schema
    assert valid(tomllib.loads(study.read_text("utf-8")), schema, schema)


def test_init_leaves_a_schema_that_is_there(infinivar, tmp_path):
    (tmp_path / "infinivar.schema.json").write_text("{}", "utf-8")
    assert infinivar("init", "mine").code == 0
    assert (tmp_path / "infinivar.schema.json").read_text("utf-8") == "{}"


@pytest.mark.parametrize(("like", "command"), [("guided_cart", "session"), ("hand_controller", "compare")])
def test_init_names_a_command_that_takes_the_study(infinivar, tmp_path, like, command):
    assert f"Next: infinivar {command} mine.toml --out out" in infinivar("init", "mine", "--like", like).out


def test_init_copies_a_shipped_study(infinivar, tmp_path):
    assert infinivar("init", "mine", "--like", "hand_controller").code == 0
    assert iv.load_study(tmp_path / "mine.toml").drives == iv.load_study("hand_controller").drives
    outcome = infinivar("init", "other", "--like", "hand_controler")
    assert (outcome.code, outcome.out) == (2, "")
    assert "(did you mean 'hand_controller'?); shipped studies: ankle_walking, driven_cart, " in outcome.err
    assert not (tmp_path / "other.toml").exists()


@pytest.mark.parametrize("name", ["mine", "mine.toml"])
def test_init_replaces_nothing(infinivar, tmp_path, name):
    (tmp_path / "mine.toml").write_text("mine", "utf-8")
    outcome = infinivar("init", name)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("infinivar: mine.toml: ")
    assert (tmp_path / "mine.toml").read_text("utf-8") == "mine"


@pytest.mark.parametrize("name", ["none/mine", "file/mine", "x" * 300])
def test_init_where_no_file_can_be(infinivar, tmp_path, name):
    (tmp_path / "file").touch()
    outcome = infinivar("init", name)
    assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
    assert "cannot be written" in outcome.err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@sampled(
    "name",
    ["", ".", "..", " ", "folder/", 'a"b', "a\\b", "a\nb", "a'b", "{y}", "a{0}b{name}", "$x^$", "a b", "é", "\udcff"],
    every=3,
)
def test_init_either_refuses_a_name_or_writes_a_good_study(infinivar, tmp_path, name):
    """No name, however odd, gives a file that cannot be read, a hidden file, or a traceback."""
    (tmp_path / "folder").mkdir()
    outcome = infinivar("init", name)
    made = [path for path in tmp_path.rglob("*") if path.name not in ("folder", "infinivar.schema.json")]
    if outcome.code == 2:
        assert len(outcome.err.splitlines()) == 1
        assert results(tmp_path) == ["folder"]
        return
    assert (outcome.code, outcome.err, len(made)) == (0, "", 1)
    assert not made[0].name.startswith(".")
    assert iv.load_study(made[0]).title
    # What it says to type next works as typed.
    command = outcome.out.partition("Next: ")[2].replace(" --out out", " --out /dev/null")
    assert "/dev/null: " in bash(command, tmp_path).stderr


def test_catalogue_lists_every_part(infinivar):
    outcome = infinivar("catalogue")
    assert (outcome.code, outcome.err) == (0, "")
    listed = [line.split()[0] for line in outcome.out.splitlines() if line]
    assert listed == [
        *("motor", *motors(), "gearhead", *gearheads()),
        *("bearing", *bearings(), "rail", *rails(), "belt", *belts()),
        *("spring", *springs(), "tube", *tubes(), "material", *materials()),
    ]
    assert max(map(len, outcome.out.splitlines())) <= 120
    row = next(line for line in outcome.out.splitlines() if line.startswith("re-40-24v "))
    motor = motors()["re-40-24v"]
    assert f"{motor.voltage:g} V" in row
    assert f"{100 * motor.peak_efficiency:.4g} %" in row
    assert "e+" not in outcome.out


def test_catalogue_as_json(infinivar):
    outcome = infinivar("catalogue", "--json")
    parts = json.loads(outcome.out)
    assert list(parts) == ["motors", "gearheads", "bearings", "rails", "belts", "springs", "tubes", "materials"]
    assert list(parts["motors"]) == list(motors())
    assert list(parts["gearheads"]) == list(gearheads())
    assert iv.parts.Motor(**parts["motors"]["re-40-24v"]) == motors()["re-40-24v"]
    assert Bearing(**parts["bearings"]["608"]) == bearings()["608"]


def test_version(infinivar):
    assert infinivar("--version").out == f"infinivar {iv.__version__}\n"


def test_help_names_every_command(infinivar):
    outcome = infinivar("--help")
    assert outcome.code == 0
    assert all(
        f"\n  {name} " in outcome.out for name in ("compare", "contact", "reproduce", "schema", "init", "catalogue")
    )


@pytest.mark.parametrize(
    "arguments",
    [[], ["nonsense"], ["compare"], ["compare", "a", "b"], ["compare", "a", "--out"], ["init"], ["schema", "--json"]],
    ids=" ".join,
)
def test_wrong_usage(infinivar, tmp_path, arguments):
    outcome = infinivar(*arguments)
    assert outcome.code == 2
    assert "Traceback" not in outcome.err
    assert arguments == [] or "Error: " in outcome.err
    assert not list(tmp_path.iterdir())


def test_runs_as_a_module(tmp_path):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "infinivar", "--version"], cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, f"infinivar {iv.__version__}\n", "")


@pytest.mark.slow
@sampled("command", ["catalogue", "schema", "catalogue --json"], every=3)
def test_output_may_be_cut_short(tmp_path, command):
    """A reader that goes away, such as head, is no reason for a traceback."""
    done = bash(f"infinivar {command} | head -n 1", tmp_path)
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, which only Linux has")
@pytest.mark.slow
def test_a_full_disk_is_one_message(tmp_path):
    done = bash("infinivar schema > /dev/full", tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "No space left" in done.stderr


def completions(folder, *words):
    """What a shell offers when TAB is pressed behind the last word."""
    completion = {
        "_INFINIVAR_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
    command = Path(sys.executable).parent / "infinivar"
    if not command.exists():
        pytest.skip("the command is not installed")
    done = subprocess.run([command], cwd=folder, capture_output=True, text=True, env={**os.environ, **completion})
    assert done.stderr == ""
    return done.stdout.split()


@pytest.mark.slow
@sampled(
    ("words", "offered"),
    [
        (("infinivar", "comp"), ["compare"]),
        (("infinivar", "compare", "--qu"), ["--quick"]),
        (("infinivar", "compare", "hand"), ["hand_controller", "handy.toml"]),
        (("infinivar", "compare", "folder/"), ["folder/mine.toml"]),
        (("infinivar", "compare", "none/"), []),
        (("infinivar", "compare", "hand_controller", "--drive", "cob"), ["cobotic", "cobotic-b"]),
        (("infinivar", "simulate", "hand_controller", "--scenario", "r"), ["reach", "run-up"]),
        (("infinivar", "compare", "handy.toml", "--drive", "cob"), []),
    ],
    ids=lambda words: words[-1] if isinstance(words, tuple) else "",
    every=2,
)
def test_tab_completes_commands_studies_drives_and_scenarios(tmp_path, words, offered):
    (tmp_path / "handy.toml").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "mine.toml").touch()
    assert completions(tmp_path, *words) == offered


def test_help_of_each_command_fits_its_line(infinivar):
    """A command's first sentence is whole in the list of commands, and says what to do."""
    listed = infinivar("--help").out.partition("Commands:\n")[2].rstrip("\n").split("\n")
    assert len(listed) >= 12
    for line in listed:
        assert re.fullmatch(r"  [a-z]+ +[A-Z][a-z]+ .*\.", line)
        assert "..." not in line
