"""What notebooks show: the answer first, HTML without code, with the numbers of the results."""

import html.parser
import re
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from explorer_pages import started
from sampled import sampled

VOID = {"br", "img"}


class Reader(html.parser.HTMLParser):
    """Cells of all tables by row, and what is wrong with the nesting of elements."""

    def __init__(self, page):
        super().__init__()
        self.rows, self.faults, self.open, self.tags, self.images = [], [], [], set(), 0
        self.feed(page)
        self.close()
        self.faults += self.open

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.images += tag == "img" and dict(attributes)["src"].startswith("data:image/png;base64,")
        self.faults += [name for name, _ in attributes if name.startswith("on")]
        if tag in VOID:
            return
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(tag)

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def read(shown):
    found = Reader(shown._repr_html_())
    assert found.faults == []
    assert "script" not in found.tags
    return found


@pytest.fixture(scope="module")
def knee():
    return iv.load_study("knee_walking")


@pytest.fixture(scope="module")
def compared(knee):
    return iv.compare(knee, quick=True)


def test_a_comparison_begins_with_its_answer_and_has_a_row_a_drive(compared):
    found = read(compared)
    page = compared._repr_html_()
    assert re.match(r"<p><b>[^<]*", page)[0].endswith(compared.hangs_on.headline)
    assert found.images == 1
    (cycle,) = compared.duty.values()
    rows = {row[1]: row for row in found.rows[1:]}
    for name, own in cycle.results.items():
        row = rows[own.title]
        assert row[0] == ("✓" if compared.able(name) else "✗")
        assert float(row[2].split()[0]) == pytest.approx(own.energy, rel=5e-3)
        assert float(row[5]) == pytest.approx(min(own.tightest[1], compared.results[name].tightest.value), rel=6e-3)
        assert row[6] == compared.masses[name].known_words
    assert [row[3] for row in found.rows[1:]].count("best") == 1


@sampled("name", ["two_joint_arm", "planar_cart", "six_leg_display"], slow=2)
def test_machines_have_a_row_each(name):
    compared = iv.compare(iv.load_study(name), quick=True)
    rows = {row[1]: row for row in read(compared).rows[1:]}
    assert list(rows) == [own.title for own in compared.results.values()]
    for own in compared.results.values():
        assert float(rows[own.title][5]) == pytest.approx(min(one.margin for one in own.found.values()), rel=6e-3)


def test_a_map_says_where_it_is_the_best_and_what_bounds_it(knee):
    made = iv.steady_map(knee.drives["geared"], np.linspace(0.01, 0.6, 30), np.linspace(1.0, 300.0, 40))
    found = read(made)
    best, force, speed = map(
        float, re.search(r"up to ([\d.]+) % at ([\d.]+) N, ([\d.]+) m/s", made._repr_html_()).groups()
    )
    within = np.where(made.limit == 0, made.efficiency, np.nan)
    row, column = np.unravel_index(np.nanargmax(within), within.shape)
    assert best == pytest.approx(100.0 * within[row, column], rel=5e-3)
    assert force == pytest.approx(made.force[column], rel=5e-3)
    assert speed == pytest.approx(made.speed[row], rel=5e-3)
    shares = {words: float(share.split()[0]) for words, share in found.rows[1:]}
    assert shares["within all limits"] == pytest.approx(100.0 * np.mean(made.limit == 0), rel=5e-3)
    for code in np.unique(made.limit[made.limit != 0]):
        expected = 100.0 * np.mean(made.limit == code)
        assert shares[f"beyond {iv.Limit(int(code)).words}"] == pytest.approx(expected, rel=5e-3)
    assert found.images == 1
    nowhere = replace(
        made, efficiency=np.full_like(made.efficiency, np.nan), limit=np.full_like(made.limit, iv.Limit.SPEED)
    )
    assert "No point of the plane has an efficiency" in nowhere._repr_html_()


def test_a_study_shows_the_answer_of_its_comparison_and_its_contents(knee, compared):
    page = knee._repr_html_()
    found = read(knee)
    assert page.startswith(f"<p><b>{knee.title}</b>")
    assert compared._repr_html_() in page
    assert ["drives", "cobotic, geared"] in found.rows


def test_a_study_of_sessions_shows_what_it_contains():
    assert ["sessions", "path, wall, crash, free"] in read(iv.load_study("guided_cart")).rows


def test_titles_are_text(knee):
    titles = {**knee.titles, "geared": "<script>alert(1)</script>&"}
    compared = iv.compare(replace(knee, titles=titles, title="<img src=x onerror=alert(1)>"), quick=True)
    assert "<script>alert(1)</script>&" in [row[1] for row in read(compared).rows[1:]]


@pytest.mark.slow
def test_a_browser_shows_it_without_an_error(knee, tmp_path):
    file = tmp_path / "notebook.html"
    file.write_text(f'<!doctype html><meta charset="utf-8"><title>notebook</title>{knee._repr_html_()}', "utf-8")
    with started() as browser:
        page = browser.new_page(viewport={"width": 900, "height": 900})
        problems = []
        page.on("pageerror", lambda problem: problems.append(str(problem)))
        page.on("console", lambda said: said.type == "error" and problems.append(said.text))
        page.goto(file.as_uri())
        assert page.locator("img").bounding_box()["height"] > 100
        assert page.get_by_role("row").count() > 2
        page.locator("summary", has_text="contents").click()
        page.get_by_text("cobotic, geared").first.wait_for()
        assert problems == []
