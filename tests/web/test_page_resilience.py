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


def packed(content):
    """The fragment of an address that holds bytes, by default those of a study."""
    pack = zlib.compressobj(wbits=-15)
    found = pack.compress(content if isinstance(content, bytes) else json.dumps(content).encode()) + pack.flush()
    return f"#study={base64.urlsafe_b64encode(found).decode().rstrip('=')}"


def linked(address, tables):
    """An address that holds these tables, and no valid state beside them."""
    return address + packed({"name": "mine", "tables": tables})


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


REQUIRED = {"requirement": {"base": "faulring2006"}}
HOSTILE = {
    "no base64": "#study=%00%3Cscript%3E",
    "no study": "#study=",
    "no compressed text": "#study=AAAA",
    "no JSON": packed(b"<script>alert(1)</script>"),
    "no name": packed({"tables": REQUIRED}),
    "a list": packed({"name": "mine", "tables": [REQUIRED]}),
    "too deep": packed(b'{"name": "mine", "tables": {"a": ' + b"[" * 100_000 + b"]" * 100_000 + b"}}"),
    "too large": packed({"name": "mine", "tables": {"title": "x" * 2**21}}),
    "no drive": packed({"name": "mine", "tables": {"drives": 5}, "drive": {}, "shown": [7], "point": {"speed": "x"}}),
    "another file": packed(
        {"name": "mine", "tables": {**REQUIRED, "duty": {"walk": {"shape": "recording", "file": "/etc/passwd"}}}}
    ),
    "another study": packed({"name": "mine", "tables": {"extends": "/etc/infinivar.toml"}}),
    "parts of a folder": packed({"name": "mine", "tables": {**REQUIRED, "parts": ["../.."]}}),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_address_gives_one_message_and_the_study_of_the_program(browser, server, case):
    with Page(browser, server.address + HOSTILE[case]) as page:
        page.page.locator(".notice.bad").wait_for()
        page.page.locator("#study-title", has_text="mine").wait_for(state="detached")
        page.ready()
        assert page.page.locator(".notice.bad").count() == 1
        assert page.page.locator(".map").count() == 2
        assert page.by_id("shipped").input_value() == "hand_controller"
        assert "Something went wrong" not in page.page.locator(".notice.bad").inner_text()
        assert page.problems == []


def test_a_study_that_was_never_valid_says_why(browser, server):
    tables = {**REQUIRED, "drives": {"one": {"base": "faulring2006.cobotic", "transmission": {"preload": "-5 N"}}}}
    with Page(browser, linked(server.address, tables)) as page:
        notice = page.page.locator("[data-notice=unusable]")
        notice.wait_for()
        assert 'preload = "-5 N" must be > 0 N' in notice.inner_text()
        page.page.locator(".map").first.wait_for()


def test_back_and_forward_restore_the_state_and_the_comments(page, tmp_path):
    source = tmp_path / "mine.toml"
    source.write_text(f"# of the rig\n{study_file(Path('hand_controller')).read_text()}")
    page.enter("Preload", "555 N")
    page.by_id("file").set_input_files(source)
    page.page.locator("[data-shown='555 N']").wait_for(state="detached")
    page.settled()
    page.enter("Preload", "666 N")
    page.link()
    page.page.go_back()
    page.page.locator("[data-shown='555 N']").wait_for(state="attached")
    page.page.go_forward()
    page.page.locator("[data-shown='666 N']").wait_for(state="attached")
    assert page.saved(tmp_path / "saved").read_text().startswith("# of the rig\n")
    page.page.goto("about:blank")
    page.page.go_back()
    page.page.locator("[data-shown='666 N']").wait_for(state="attached")
    assert page.saved(tmp_path / "again").read_text().startswith("# of the rig\n")
    assert page.problems == []


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
