"""`infinivar size --builds`: what it prints and writes of builds within tolerances."""

import json
import re

import pytest

import infinivar as iv
from small_catalogue import SLIDE, slides

SPREAD = """
[drives.geared.guideway]
friction = "2 N"

[uncertainty.geared]
guideway.friction = "25 %"
"""


@pytest.fixture
def folder(tmp_path):
    return slides(tmp_path, SLIDE + SPREAD)


@pytest.mark.slow
def test_builds_are_in_terminal_files_and_report(infinivar, folder):
    done = infinivar("size", "slide.toml", "--set", "shelf.toml", "--builds", "64", "--out", "out")
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    start = lines.index("Within tolerances, 64 builds:")
    assert lines[start + 1].startswith("  design-01: ")
    assert "  spreads stated in the study: guideway friction of geared: 1.5 to 2.5 N" in lines
    assert (
        "  default spreads, as the study states none: winding resistance ± 12 % (95 %, parsons2019), torque constant ± 5 %, "
        "no-load current with constant friction ± 29 % (95 %, robotino2026), coulomb gear loss ± 78 % (95 %, duclusaud2025)"
        in lines
    )
    stated = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))["doubt"]
    study = iv.load_study(folder / "slide.toml")
    found = iv.doubt(iv.size(study, sets=folder / "shelf.toml"), builds=64)
    assert stated == json.loads(json.dumps(found.to_dict()))
    assert lines[start + 1] == f"  design-01: {found.verdict}"
    listed = [line for line in lines[start + 1 :] if line.startswith("  design-")]
    more = [int(line.split()[2]) for line in lines[start + 1 :] if line.startswith("  ... and") and "best in" in line]
    assert len(listed) + sum(more) == len(found.designs)
    never = len(found.designs) - 1 - len(found.runners_up)
    said = [line for line in lines[start + 1 :] if line.endswith("best in no build")]
    assert said == ([f"  ... and {never} more that {'is' if never == 1 else 'are'} best in no build"] if never else [])
    page = (folder / "out" / "sizing.html").read_text("utf-8")
    section = page.partition("Builds within tolerances")[2].partition("</table>")[0]
    names = re.findall(r"<tr><td>((?:design|front)-\d\d)</td>", section)
    assert names == [one.name for one in (*found.designs, *found.front)]
    assert found.designs[0].title in section


@pytest.mark.slow
def test_no_builds_and_wrong_numbers_of_builds(infinivar, folder):
    command = ("size", "slide.toml", "--set", "shelf.toml", "--top", "1", "--objective", "mass", "--out", "out")
    done = infinivar(*command, "--builds", "0", "--json")
    assert done.code == 0
    assert "doubt" not in json.loads(done.out)
    assert "Builds within" not in (folder / "out" / "sizing.html").read_text("utf-8")
    refused = infinivar(*command, "--builds", "100")
    assert refused.code == 2
    assert "builds must be a power of two from 16 to 1048576, got 100" in refused.err
    assert infinivar("size", "slide.toml", "--builds", "-1").code == 2


@pytest.mark.slow
def test_a_search_without_designs_has_no_builds(infinivar, folder):
    done = infinivar("size", "slide.toml", "--set", "shelf.toml", "--radius", "1 mm", "2 mm", "--out", "out")
    assert done.code == 1
    assert "Within tolerances" not in done.out
