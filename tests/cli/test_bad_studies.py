"""Studies that are bad in ways that are no rows of tests/faults, that are extreme, and that look bad but are good."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from faults.rows import PIECES, check_lines, with_value
from folders import results
from sampled import sampled

GOOD = PIECES["good"]


def test_what_the_bad_ones_are_made_from_is_good(infinivar, write, tmp_path):
    outcome = infinivar("compare", write(GOOD), "--json")
    assert (outcome.code, outcome.err) == (0, "")
    assert list(json.loads(outcome.out)["drives"]) == ["mine", "geared"]


@pytest.mark.parametrize(
    "text",
    [
        GOOD + "[drives.mine.transmission]\n" + "".join(f"key{i} = {i}\n" for i in range(200)),
        PIECES["requirement"] + "".join(f"[drives.d{i}]\ntype = 'conventional'\n" for i in range(100)),
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


@sampled(("field", "value"), EXTREMES, every=3)
@pytest.mark.renders("svg")
def test_extremes_are_refused_or_computed(infinivar, write, tmp_path, field, value):
    """No overflow, no warning (warnings are errors here), no share beyond 1, no nan passed on as an answer."""
    outcome = infinivar("compare", write(with_value(field, value)), "--json")
    if outcome.code == 2:
        check_lines(outcome, [field, str(value)])
        assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]
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
    assert infinivar("compare", write(PIECES["requirement"])).code == 2
    assert results(tmp_path / "out") == ["mine.nc", "report.html", "results.json"]
    assert {(tmp_path / "out" / name).read_text("utf-8") for name in results(tmp_path / "out")} == {"before"}


@sampled("json_too", [[], ["--json"]], every=2)
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
