"""Reports as they are read: numbers in plain digits, tables and figures that stay inside the page, degrees."""

import os
import re
import subprocess
import sys
from html.parser import HTMLParser

NUMBER = re.compile(r"(?<![\w.])\d[\d.]*e[+-]?\d+")


class Page(HTMLParser):
    """Text of a page, and the tables and pictures that are not in an element that scrolls."""

    VOID = ("meta", "link", "br", "img", "hr")

    def __init__(self, text):
        super().__init__()
        self.inside, self.loose, self.text = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag in ("table", "img") and "scroll" not in self.inside:
            self.loose.append(tag)
        if tag not in self.VOID:
            self.inside.append(dict(attributes).get("class") if tag == "div" else tag)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            self.inside.pop()

    def handle_data(self, data):
        if "style" not in self.inside:
            self.text += data


def pages(folder):
    return {path.name: Page(path.read_text("utf-8")) for path in folder.glob("*.html")}


def test_large_forces_are_written_out(pressed):
    outcomes, folder = pressed
    found = pages(folder)
    assert set(found) == {"report.html", "sensitivity-energy.html"}
    for outcome in outcomes:
        assert outcome.code in (0, 1), outcome.err
        assert not NUMBER.search(outcome.out), NUMBER.findall(outcome.out)
    for name, page in found.items():
        assert not NUMBER.search(page.text), (name, NUMBER.findall(page.text))
    assert "1540 N" in found["report.html"].text.replace("\u00a0", " ")
    assert "1500 kg" in found["report.html"].text.replace("\u00a0", " ")


def test_no_page_has_padded_exponents(compared, walked, reproduced):
    for folder in (compared[1], walked[1], reproduced[1]):
        for name, page in pages(folder).items():
            found = re.findall(r".{20}\de[+-]?0\d.{10}|.{20}\de\+\d.{10}", page.text)
            assert not found, (name, found)


def test_no_line_ends_before_a_unit_and_percent_signs_stand_apart(pressed, compared, walked, reproduced):
    folders = [pressed[1], compared[1], walked[1], reproduced[1]]
    for path in (path for folder in folders for path in folder.glob("*.html")):
        text = path.read_text("utf-8")
        found = Page(text)
        assert not re.findall(r".{9}\d (?:%|°C|J|W|N|mm|mN m|m/s|s|g)(?!\w).{9}", found.text), path
        assert not re.findall(r".{9}\d%.{9}", found.text), path
        assert " × " not in found.text.replace("0.88 × 0.87", ""), path
        assert "\N{NO-BREAK SPACE}" not in text.partition("<body>")[0], path


def test_tables_and_figures_scroll_inside_the_page(pressed, compared, walked, reproduced):
    folders = [pressed[1], compared[1], walked[1], reproduced[1]]
    found = [page for folder in folders for page in pages(folder).values()]
    assert len(found) >= 5
    for page in found:
        assert page.text.strip()
        assert page.loose == []
        assert page.inside == []


def test_degrees_are_told_from_coulombs(walked):
    _, folder, said = walked
    text = pages(folder)["report.html"].text.replace("\u00a0", " ")
    assert re.search(r"\d °C of \d+ °C", text)
    assert not re.search(r"\d C\b", text)
    verdict = said["duty"]["walking"]["drives"]["cobotic"]["verdict"]
    assert re.search(r"winding settles at \d+ °C \(limit 100 °C\)", verdict)


def test_terminals_without_a_degree_sign(tmp_path, pressed):
    """LANG=C without Python's own cure for it: a sign that cannot be shown is replaced, and all else is as ever."""
    study = (pressed[1].parent / "press.toml").read_text("utf-8")
    (tmp_path / "press.toml").write_text(study.partition("[uncertainty")[0], "utf-8")
    bare = {key: value for key, value in os.environ.items() if not key.startswith(("LC_", "LANG", "PYTHONIO"))}
    environment = {**bare, "LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = [sys.executable, "-m", "infinivar", "compare", "press.toml", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    assert done.stderr == b""
    assert re.search(rb"settles at \d+ \?+C \(limit 155 \?+C\)", done.stdout), done.stdout
    assert (tmp_path / "out" / "report.html").is_file()
