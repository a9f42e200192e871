"""`infinivar size`: what it prints and writes, and that its study files run in the other commands."""

import json
import math
import re

import pytest

import infinivar as iv
from folders import results
from pages import Links, pages
from shelves import SHELF

STUDY = """
title = "Slide"

[drives.geared]
type = "conventional"
output_inertia = "0.02 g m^2"

[drives.geared.motor]
part = "dcx-32-l-24v"

[drives.geared.gearhead]
part = "gpx-32-up-16"
loss_model = "coulomb"

[drives.geared.pulley]
radius = "8 mm"

[duty.shake]
shape = "sinusoid"
distance = "60 mm"
frequency = "1.5 Hz"
load_mass = "3 kg"
force = "-30 N"
"""
HEAVY = STUDY.replace("-30 N", "-900 N")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "shelf.toml").write_text(SHELF, "utf-8")
    (tmp_path / "slide.toml").write_text(STUDY, "utf-8")
    (tmp_path / "heavy.toml").write_text(HEAVY, "utf-8")
    return tmp_path


def test_winners_run_in_the_other_commands(infinivar, folder):
    done = infinivar(
        "size", "slide.toml", "--set", "shelf.toml", "--top", "2", "--objective", "mass, energy", "--out", "out"
    )
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert lines[0].startswith("Least mass of 7 pairs of shelf: ")
    assert lines[1] == "Least mass:"
    assert lines[2].startswith("  design-01: ")
    assert re.search(
        r"^Template geared: 7 pairs, pulley radius 1\.6 to 40 mm; \d left by closed forms, ", done.out, re.MULTILINE
    )
    assert "motor peak torque: not stated, not checked for 6" in done.out  # p35 has no mass
    files = results(folder / "out")
    assert {"sizing.html", "sizing.json", "design-01.toml", "design-02.toml", "front-01.toml", "motion-shake.csv"} <= {
        *files
    }

    stated = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))
    compared = infinivar("compare", "out/front-01.toml", "--quick", "--json")
    assert compared.code == 0
    drawn = json.loads(compared.out)["duty"]["shake"]["drives"]["geared"]["power_from_supply_net_W"]
    assert drawn == pytest.approx(stated["front"][0]["power_W"], rel=1e-9)
    run = infinivar("simulate", "out/front-01.toml", "--scenario", "shake", "--out", "run", "--json")
    assert run.code == 0, run.out + run.err

    page = (folder / "out" / "sizing.html").read_text("utf-8")
    links = Links(page)
    assert not links.scripts
    assert not links.open
    assert all(one.startswith("data:") for one in links.fetched)
    assert not pages(folder / "out")["sizing.html"].loose
    named = set(re.findall(r'href="([a-z]+-\d+\.toml)"', page))
    assert named == {name for name in files if re.fullmatch(r"(design|front)-\d+\.toml", name)}
    assert "Made Up 10" in page
    assert "data sheet 7" in page


def test_no_feasible_design(infinivar, folder):
    (folder / "shelf.toml").write_text(SHELF.replace('resistance = "2 ohm"', 'resistance = "-2 ohm"'), "utf-8")
    done = infinivar("size", "heavy.toml", "--set", "shelf.toml", "--out", "out")
    assert done.code == 1
    assert "resistance" in done.err  # the row that was refused
    assert results(folder / "out") == ["sizing.html", "sizing.json"]
    found = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))
    assert not found["feasible"]
    assert not found["designs"]
    search = found["searches"]["geared"]
    assert sum(one["first"] for one in search["limits"]) == 5
    nearest = search["nearest"]
    assert nearest["margin"] < 1.0
    assert done.out.startswith(f"None of 5 pairs of shelf is feasible; nearest miss: {nearest['title']}, ")
    (searched,) = found["sets"]
    assert searched["pairs"] == 5
    assert any("resistance" in one for one in searched["refused"])
    assert "times the allowance" in found["verdict"]
    assert re.search(r"^  nearest miss: .*margin 0\.", done.out, re.MULTILINE)
    assert found["verdict"][1:] in (folder / "out" / "sizing.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--objective", "speed"), "--objective 'speed' must be energy, mass, or both, such as energy,mass"),
        (("--objective", "mass,mass"), "--objective 'mass,mass' must be"),
        (("--radius", "5 mm", "2 mm"), "--radius '5 mm' '2 mm' must be a range above 0"),
        (("--radius", "5 s", "2 mm"), "--radius '5 s'"),
        (("--set", "nosuch"), "slide.toml: 'nosuch' is not a set of parts"),
        (("--drive", "gears"), "slide.toml: the study has no drive 'gears'"),
    ],
)
def test_bad_options_exit_with_2(infinivar, folder, options, message):
    done = infinivar("size", "slide.toml", *options)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert not (folder / "out").exists()


def test_a_recording_is_named_from_the_new_folder(infinivar, folder):
    rows = "\n".join(f"{0.01 * k},{0.03 * (1 - math.cos(2 * math.pi * k / 100))}" for k in range(100))
    (folder / "made").mkdir()
    (folder / "made" / "log.csv").write_text(f"time [s],position [m]\n{rows}\n", "utf-8")
    text = STUDY[: STUDY.index("[duty.shake]")] + '[duty.log]\nshape = "file"\nfile = "log.csv"\nload_mass = "3 kg"\n'
    (folder / "made" / "log.toml").write_text(text, "utf-8")
    done = infinivar(
        "size", "made/log.toml", "--set", "shelf.toml", "--top", "1", "--objective", "energy", "--out", "far/out"
    )
    assert done.code == 0, done.err
    study = iv.load_study(folder / "far" / "out" / "design-01.toml")
    assert study.duty["log"].motion == iv.load_study(folder / "made" / "log.toml").duty["log"].motion
    assert 'file = "motion-log.csv"' in (folder / "far" / "out" / "design-01.toml").read_text("utf-8")
