"""The views below the maps in a real Chromium: their numbers are those of the public functions, and they can be read by all."""

from __future__ import annotations

import re

import pytest

import infinivar as iv
from explorer_pages import Page
from internals import plain_units as plain
from internals import point_answer as point
from internals import shipped_studies
from sampled import sampled

pytestmark = pytest.mark.slow

PATIENCE = 60_000
"""Longest wait, for machines with other work to do. [ms]"""


@pytest.fixture(scope="module")
def window(browser, server):
    with Page(browser, server.address) as found:
        found.context.set_default_timeout(PATIENCE)
        yield found.ready()


@pytest.fixture
def page(window):
    """The page with the first study."""
    window.opened("hand_controller")
    yield window
    assert window.problems == []


def view(page, name):
    """The panel of a view, once it shows something."""
    page.by_id(f"tab-{name}").click()
    panel = page.by_id(f"panel-{name}")
    panel.locator(".view *").first.wait_for()
    return panel


def click(page, drive, across, up):
    """Choose a point by its place in a map, as shares of its box."""
    plot = page.page.locator(f".map[data-drive='{drive}'] .plot:visible").first
    box = plot.bounding_box()
    plot.click(position={"x": across * box["width"], "y": (1.0 - up) * box["height"]})
    page.settled()


def entry(panel, label):
    """The text of a term of a list."""
    return panel.locator("dt", has_text=re.compile(f"^{re.escape(label)}$")).locator("xpath=following-sibling::dd[1]")


def shown(panel, label, text):
    entry(panel, label).filter(has_text=re.compile(f"^{re.escape(text)}$")).wait_for()


def test_the_balance_is_that_of_the_drive_and_follows_the_point(page):
    study = iv.load_study(shipped_studies()["hand_controller"])
    panel = view(page, "balance")
    for across, up in ((0.35, 0.35), (0.5, 0.6), (0.2, 0.2)):
        click(page, "cobotic", across, up)
        speed, force = page.point()
        expected = study.drives["cobotic"].operate(speed=speed, force=force)
        shown(panel, "from the supply", f"{plain(float(expected.power_in), 3)} W")
        shown(panel, "to the load", f"{plain(float(expected.power_out), 3)} W")
        for name, loss in expected.losses.items():
            if loss > 0:
                assert panel.locator("svg text.loss", has_text=f"{name}{plain(float(loss), 3)} W").count() == 1
    picture = panel.get_by_role("img").first
    assert "Power flows from the supply to the load" in picture.locator("desc").text_content()


def test_where_the_load_drives_power_flows_back(page):
    page.opened("reach_and_hold")
    study = iv.load_study(shipped_studies()["reach_and_hold"])
    panel = view(page, "balance")
    click(page, "cobotic", 0.25, 0.6)
    speed, force = page.point()
    expected = study.drives["cobotic"].operate(speed=speed, force=force)
    assert expected.power_out < 0
    shown(panel, "to the load", f"{plain(float(expected.power_out), 3)} W")
    panel.get_by_text(f"the load gives {plain(-float(expected.power_out), 3)} W").wait_for()


def test_beyond_a_limit_the_view_says_which_and_by_how_much(page):
    study = iv.load_study(shipped_studies()["hand_controller"])
    panel = view(page, "balance")
    for drive in ("motor2-gear4", "cobotic"):
        click(page, drive, 0.97, 0.6)
        speed, force = page.point()
        expected = point.point(study, {"drive": drive, "speed": speed, "force": force})
        assert not expected["feasible"]
        panel.locator(".verdict", has_text=expected["verdict"]).wait_for()
        assert panel.locator(".shares .beyond").count() >= 1


def test_the_contact_stands_where_the_drive_says(page):
    panel = view(page, "contact")
    click(page, "cobotic", 0.4, 0.3)
    speed, force = page.point()
    drive = iv.load_study(shipped_studies()["hand_controller"]).drives["cobotic"]
    share = 100.0 * float(drive.operate(speed=speed, force=force).utilisation[iv.Limit.SLIP])
    shown(panel, "share of the slip limit", f"{plain(share, 3)} %")
    assert panel.locator("svg .slips").count() > 3
    assert panel.locator("svg .sticks").count() > 50
    click(page, "motor2-gear4", 0.4, 0.3)
    panel.get_by_text("has no rolling contact").wait_for()


def test_a_motion_has_the_verdicts_of_the_duty_cycle(page):
    page.opened("reach_and_hold")
    study = iv.load_study(shipped_studies()["reach_and_hold"])
    panel = view(page, "motion")
    panel.locator("canvas").nth(5).wait_for()
    names = [one.get_attribute("data-drive") for one in page.page.locator(".map").all()]
    for name in names:
        duty = study.duty["reach-and-hold"]
        expected = iv.duty_cycle(study.drives[name], duty, name=name, title=study.titles[name], travel=study.travel)
        assert panel.locator(".verdicts li", has_text=expected.verdict).count() == 1


def test_the_plane_of_frequency_and_power(page):
    panel = view(page, "plane")
    panel.locator("figure").nth(1).wait_for()
    panel.get_by_text("Shaking 0.8 kg").wait_for()
    panel.locator("figure svg").first.hover()
    panel.get_by_text(re.compile(r"Hz, .* W: ")).first.wait_for()


def test_the_machine_moves_until_it_is_paused(page):
    panel = view(page, "machine")
    marks = panel.locator("svg line.m.tread")
    marks.first.wait_for(state="attached")

    def places():
        return [one.get_attribute("y1") for one in marks.all()]

    def moves():
        before = places()
        page.page.wait_for_timeout(250)
        return places() != before

    assert moves()
    panel.get_by_role("button", name="Pause").click()
    panel.get_by_role("button", name="Play").wait_for()
    assert not moves()
    panel.get_by_role("button", name="Play").click()
    assert moves()
    panel.get_by_text(re.compile("times slower than the machine")).wait_for()
    panel.get_by_text(re.compile("Contact ellipse, magnified")).wait_for()


def test_who_wants_less_motion_gets_a_machine_at_rest(browser, server):
    with Page(browser, server.address, reduced_motion="reduce") as page:
        panel = view(page.ready(), "machine")
        panel.get_by_role("button", name="Play").wait_for()
        assert page.problems == []


def test_the_wheels_of_a_machine_can_be_chosen(page):
    page.opened("six_leg_display")
    panel = view(page, "contact")
    panel.locator("select").select_option("3")
    panel.locator(".verdict", has_text="leg 3:").wait_for()


@pytest.mark.parametrize("size", [pytest.param("tablet", marks=pytest.mark.slow), "narrow"])
def test_nothing_is_wider_than_a_small_screen(browser, server, size):
    with Page(browser, server.address, size, color_scheme="dark") as page:
        page.context.set_default_timeout(PATIENCE)
        page.ready().opened("reach_and_hold")
        width = page.page.viewport_size["width"]
        for name in ("balance", "contact", "motion", "plane", "machine"):
            panel = view(page, name)
            panel.locator("svg, canvas").first.wait_for()
            page.page.wait_for_timeout(100)
            for one in panel.locator("svg, canvas, table:visible").all():
                box = one.bounding_box()
                assert box is None or box["x"] + box["width"] <= width + 1.0, name
        assert page.problems == []


TEXT_OUTSIDE = """picture => [...picture.querySelectorAll("text")].filter((text) => {
  const [own, all] = [text.getBoundingClientRect(), picture.getBoundingClientRect()];
  return own.left < all.left - 1 || own.right > all.right + 1 || own.top < all.top - 1 || own.bottom > all.bottom + 1;
}).map((text) => text.textContent)"""


@pytest.mark.parametrize("size", ["desktop", "narrow"])
def test_the_drawing_of_a_machine_stays_in_its_picture_and_no_label_is_cut(browser, server, size):
    with Page(browser, server.address, size) as page:
        page.ready()
        for study in ("planar_cart", "sphere_joint", "knee_walking"):
            page.opened(study)
            panel = view(page, "machine")
            panel.locator(".scene > svg text").first.wait_for()
            for picture in panel.locator(".scene > svg").all():
                assert picture.evaluate(TEXT_OUTSIDE) == []
                assert picture.evaluate("one => getComputedStyle(one).overflow") == "hidden"


def test_every_picture_has_a_text_instead(page):
    page.opened("reach_and_hold")
    for name in ("balance", "contact", "motion", "plane", "machine"):
        panel = view(page, name)
        panel.get_by_role("img").first.wait_for()
        for one in panel.get_by_role("img").all():
            title = one.locator("title").first
            words = one.get_attribute("aria-label") or (title.text_content() if title.count() else "")
            assert len(words) > 10, name


@sampled("study", sorted(set(shipped_studies()) - {"guided_cart", "one_axis_display", "tool_on_six_legs"}), slow=3)
def test_every_view_of_every_shipped_study(page, study):
    page.opened(study)
    for name in ("balance", "contact", "motion", "plane", "machine"):
        if page.by_id(f"tab-{name}").is_hidden():
            continue
        panel = view(page, name)
        said = ".view svg:visible, .view canvas:visible, .blank:visible, .why:visible"
        panel.locator(said).first.wait_for()  # a sphere between rollers takes seconds
        assert panel.get_by_text("This view failed").count() == 0
