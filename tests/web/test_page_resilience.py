"""The page when something is wrong or changes around it: bad values, reloads, links, files on disk, a server that ends."""

import base64
import json
import shutil
import zlib
from pathlib import Path

import pytest

from explorer_pages import Page
from internals import study_file
from serving import free_port, serving

pytestmark = pytest.mark.slow


@pytest.fixture
def page(browser, server):
    with Page(browser, server.address) as found:
        yield found.ready()


def linked(address, tables):
    """An address that holds these tables, and no valid state beside them."""
    pack = zlib.compressobj(wbits=-15)
    packed = pack.compress(json.dumps({"name": "mine", "tables": tables}).encode()) + pack.flush()
    return f"{address}#study={base64.urlsafe_b64encode(packed).decode().rstrip('=')}"


def refused(page):
    """The page tells what is wrong with the preload, beside the last valid maps."""
    page.page.locator("[data-at='drives.cobotic.transmission.preload'] .message:visible").wait_for()
    assert page.field("Preload").input_value() == "-5 N"
    assert page.page.locator(".map").count() == 2
    page.page.locator("#status", has_text="last valid state").wait_for()
    page.page.locator(".map[data-drive='cobotic']", has_text="covers").wait_for()


def test_a_bad_value_outlives_a_reload_beside_the_last_valid_state(page):
    page.enter("Preload", "700 N")
    shown = page.efficiency("cobotic")
    page.enter("Preload", "-5 N")
    page.page.reload()
    refused(page)
    assert page.efficiency("cobotic") == shown
    page.by_id("undo").click()
    page.page.locator("[data-shown='700 N']").wait_for()


def test_a_link_holds_a_bad_value_beside_the_last_valid_state(page, browser):
    page.enter("Preload", "700 N")
    shown = page.efficiency("cobotic")
    page.enter("Preload", "-5 N")
    with Page(browser, page.link()) as other:
        refused(other)
        assert other.efficiency("cobotic") == shown
        other.enter("Preload", "800 N")
        assert other.field("Preload").get_attribute("aria-invalid") is None


def test_a_study_that_was_never_valid_says_why_and_offers_another(browser, server):
    tables = {
        "requirement": {"base": "faulring2006"},
        "drives": {"one": {"base": "faulring2006.cobotic", "transmission": {"preload": "-5 N"}}},
    }
    with Page(browser, linked(server.address, tables)) as page:
        notice = page.page.locator("[data-notice=unusable]")
        notice.wait_for()
        assert 'preload = "-5 N" must be > 0 N' in notice.inner_text()
        notice.get_by_role("button", name="Open the study of the program").click()
        page.page.locator(".map").first.wait_for()
        page.page.locator("#study-title", has_text="mine").wait_for(state="detached")


def test_the_title_names_a_part_that_was_swapped(page):
    title = page.page.locator(".map[data-drive='cobotic']")
    before = title.inner_text().split("\n")[0]
    page.unfold("Gearhead")
    page.page.get_by_role("button", name="Choose another part: Gearhead").click()
    page.page.get_by_label("Search the catalogue").fill("gpx 32 up")
    page.page.get_by_role("dialog").get_by_role("button", name="GPX 32 UP").first.click()
    page.page.locator(".map[data-drive='cobotic']", has_text="with gearhead GPX 32 UP").wait_for()
    page.settled()
    page.by_id("undo").click()
    page.settled()
    page.until(lambda: title.inner_text().split("\n")[0] == before)


def test_tasks_are_asked_once_for_a_study(page):
    page.opened("two_joint_arm")
    table = page.page.locator("table.tasks")
    table.wait_for()
    page.settled()
    before = sum(url.endswith("/api/tasks") for url in page.requests)
    for place in (1, 0):
        table.locator("tbody tr").nth(place).locator("button").last.click()
        page.page.locator("table.tasks button[aria-pressed=true]").wait_for()
    page.settled()
    assert sum(url.endswith("/api/tasks") for url in page.requests) == before


@pytest.mark.full
def test_a_file_that_changes_on_disk_is_told_and_read_again(browser, tmp_path):
    file = tmp_path / "mine.toml"
    shutil.copy(study_file(Path("hand_controller")), file)
    with (
        serving(str(file), "--port", str(free_port()), folder=tmp_path) as server,
        Page(browser, server.address) as page,
    ):
        page.ready()
        page.page.locator("body").dispatch_event("focus")
        page.settled()
        text = file.read_text()
        assert page.page.locator("[data-notice=disk]").count() == 0
        file.write_text(text.replace('title = "', 'title = "Newer '))
        page.page.locator("body").dispatch_event("focus")
        page.page.get_by_role("button", name="Read it again").click()
        page.page.locator("#study-title", has_text="Newer").wait_for()
        file.write_text("nonsense")
        page.page.locator("body").dispatch_event("focus")
        page.page.get_by_role("button", name="Read it again").click()
        page.page.locator("[data-notice=disk]", has_text="Not read").wait_for()
        page.page.locator("#study-title", has_text="Newer").wait_for()  # what is shown stays


@pytest.mark.full
def test_the_page_goes_on_by_itself_when_the_program_is_back(browser, tmp_path):
    port = str(free_port())
    with serving("--port", port, folder=tmp_path) as first, Page(browser, first.address) as page:
        page.ready()
        page.edit_and_lose(first)
        with serving("--port", port, folder=tmp_path):
            page.page.locator("[data-notice=broken]").wait_for(state="detached")
            page.settled()
            assert page.field("Preload").get_attribute("data-shown") == "778 N"
            page.enter("Preload", "777 N")
            page.page.reload()
            page.page.locator("[data-shown='777 N']").wait_for()
            page.settled()
            assert page.page.locator(".notice").count() == 0  # what the page holds is not offered to it


@pytest.mark.full
def test_the_tour_is_offered_once_and_speaks_of_what_is_shown(page, browser, server):
    with Page(browser, server.address) as other:
        other.page.locator("[data-notice=tour]").wait_for()
        other.page.reload()  # without an answer
        other.page.locator("#status[data-first]").wait_for()
        other.settled()
        other.page.wait_for_timeout(300)
        assert other.page.locator("[data-notice=tour]").count() == 0
    page.opened("planar_cart")
    page.page.locator("table.tasks").wait_for()
    page.page.keyboard.press("F1")
    page.page.get_by_role("button", name="Start the tour").click()
    words = []
    while page.page.locator(".tour:not([hidden])").count():
        words.append(page.page.locator(".tour").inner_text())
        page.page.locator(".tour .main").click()
    assert len(words) == 7
    assert not any("efficiency of a drive" in one for one in words)


def test_keys_pressed_in_a_row_are_undone_as_one(page):
    first = page.field("Preload").input_value()
    slider = page.slider("Preload")
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
    page.settled()
    assert page.field("Preload").input_value() != first
    page.page.wait_for_timeout(4500)
    slider.press("ArrowRight")
    page.settled()
    page.by_id("undo").click()
    page.by_id("undo").click()
    page.until(lambda: page.field("Preload").get_attribute("data-shown") == first)
    assert page.by_id("undo").is_disabled()


def test_a_wheel_that_rolls_does_not_make_an_infeasible_point_good(page):
    """Beyond the speed limit, where the wheel rolls: the view of its contact has no colour of success."""
    page.page.get_by_role("tab", name="Rolling contact").click()
    plot = page.page.locator(".map[data-drive='cobotic'] .plot:visible").first
    box = plot.bounding_box()
    plot.click(position={"x": 0.52 * box["width"], "y": 0.03 * box["height"]})
    page.settled()
    assert "infeasible" in page.readout("cobotic") or "beyond" in page.readout("cobotic")
    page.page.locator("#panel-contact .verdict", has_text="of the slip limit").wait_for()
    assert page.page.locator("#panel-contact .verdict.yes").count() == 0


def test_a_view_says_that_it_computes(page):
    page.page.route("**/api/contact", lambda route: (page.page.wait_for_timeout(400), route.continue_()))
    page.page.get_by_role("tab", name="Rolling contact").click()
    page.page.locator("#panel-contact .why", has_text="Computing").wait_for()
    page.page.locator("#panel-contact .verdict").wait_for()
