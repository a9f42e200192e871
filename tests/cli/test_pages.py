"""Reports as they are read: numbers in plain digits, tables and figures that stay inside the page, degrees."""

import os
import re
import subprocess
import sys

import pytest

from internals import finished, report_page, style
from pages import is_set_well, losses_have_their_colour, pages

NUMBER = re.compile(r"(?<![\w.])\d[\d.]*e[+-]?\d+")


@pytest.mark.slow
def test_large_forces_are_written_out(pressed):
    outcomes, folders = pressed
    found = {name: page for folder in folders for name, page in pages(folder).items()}
    assert set(found) == {"report.html", "sensitivity-energy.html"}
    for outcome in outcomes:
        assert outcome.code in (0, 1), outcome.err
        assert not NUMBER.search(outcome.out), NUMBER.findall(outcome.out)
    for name, page in found.items():
        assert not NUMBER.search(page.text), (name, NUMBER.findall(page.text))
    assert "1540 N" in found["report.html"].text.replace("\u00a0", " ")
    assert "1500 kg" in found["report.html"].text.replace("\u00a0", " ")


def test_every_page_is_set_well(compared, walked):
    for folder in (compared[1], walked[1]):
        assert pages(folder)
        is_set_well(folder)
        losses_have_their_colour((folder / "report.html").read_text("utf-8"), style.loss_colour)


def test_notes_are_one_list_which_names_what_is_to_be_checked():
    """A single note stands as it is; several are folded, unless one is to be checked."""
    page = "{% import 'parts.html' as parts %}{{ parts.notes(reconstruction, checks, others) }}"
    template = report_page._environment("infinivar.report").from_string(page)

    def notes(*groups):
        return template.render(**dict(zip(("reconstruction", "checks", "others"), groups, strict=True))).strip()

    assert notes((), (), ()) == ""
    one = notes((), (), ("Only <this>.",))
    assert "<details" not in one
    assert "Only &lt;this&gt;." in one
    folded = notes(("Of a paper.",), (), ("First.", "Second."))
    assert '<details class="note"><summary>3 notes; the machine is a reconstruction</summary>' in folded
    assert folded.count("<li>") == 3
    assert '<details class="note" open><summary>2 notes, 1 to check</summary>' in notes((), ("Too thin.",), ("First.",))


def test_parts_that_scroll_have_the_name_of_their_heading():
    found = finished(
        '<h2>Loss &amp; <i>size</i></h2><div class="scroll"><table><tr><th>a</th><th class="number">b</th></tr>'
        "<tr><td>1</td></tr><tr><th>c</th></tr></table></div>"
    )
    assert 'tabindex="0" role="region" aria-label="Loss &amp; size"' in found
    assert '<table><thead><tr><th scope="col">a</th><th scope="col" class="number">b</th></tr></thead><tr><td>' in found
    assert found.count("<thead>") == 1


@pytest.mark.slow
def test_pages_with_large_forces_are_set_well(pressed):
    for folder in pressed[1]:
        assert pages(folder)
        is_set_well(folder)


def test_degrees_are_told_from_coulombs(walked):
    _, folder, said = walked
    text = pages(folder)["report.html"].text.replace("\u00a0", " ")
    assert re.search(r"\d °C of \d+ °C", text)
    assert not re.search(r"\d C\b", text)
    verdict = said["duty"]["walking"]["drives"]["cobotic"]["verdict"]
    assert re.search(r"winding settles at \d+ °C \(limit 100 °C\)", verdict)


@pytest.mark.full
def test_terminals_without_a_degree_sign(tmp_path, pressed):
    """LANG=C without Python's own cure for it: a sign that cannot be shown is replaced, and all else is as ever."""
    study = (pressed[1][0] / "press.toml").read_text("utf-8")
    (tmp_path / "press.toml").write_text(study.partition("[uncertainty")[0], "utf-8")
    bare = {key: value for key, value in os.environ.items() if not key.startswith(("LC_", "LANG", "PYTHONIO"))}
    environment = {**bare, "LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = [sys.executable, "-m", "infinivar", "compare", "press.toml", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    assert done.stderr == b""
    assert re.search(rb"settles at \d+ \?+C \(limit 155 \?+C\)", done.stdout), done.stdout
    assert (tmp_path / "out" / "report.html").is_file()
