"""Less common states of the page in real browsers: machines, sessions, parts, exports, long work, faults, a killed server."""

import re
import zipfile
from pathlib import Path

import pytest

from explorer_pages import EACH_BROWSER, SIZES, Page
from internals import shipped_studies, study_file
from sampled import sampled
from serving import free_port, serving

pytestmark = pytest.mark.slow


@pytest.fixture
def page(browser, server):
    with Page(browser, server.address) as found:
        yield found.ready()


@sampled("study", ["six_leg_display", "planar_cart", "sphere_joint", "two_joint_arm"], slow=3)
def test_machines_have_tasks_with_powers_and_limits(page, study):
    page.opened(study)
    table = page.page.locator("table.tasks")
    table.wait_for()
    header, _ = page_answer(page, "tasks")
    first = next(iter(header["machines"].values()))
    assert table.locator("tbody tr").count() == len(first["tasks"])
    assert table.locator("thead th").count() == 1 + len(header["machines"])
    assert first["tasks"][0]["tightest"] in table.inner_text()
    table.locator("tbody tr").nth(1).locator("button").last.click()
    page.page.locator("table.tasks button[aria-pressed=true]").wait_for()
    assert page.page.get_by_role("tab", selected=True).inner_text() == "Machine"
    page.page.locator("#panel-machine .why").wait_for(state="hidden")
    assert page.fits()
    assert page.problems == []


def page_answer(page, name):
    """What the server says of the study that the page shows."""
    from serving import unpacked

    address = page.page.url.partition("#")[0]
    shown = page.page.context.request.post(address + "api/shipped", data={"which": page.by_id("shipped").input_value()})
    study, _ = unpacked(shown.body())
    reply = page.page.context.request.post(address + f"api/{name}", data=study)
    return unpacked(reply.body())


def test_sessions_say_what_to_run_and_run_here(page):
    page.opened("guided_cart")
    assert "infinivar session guided_cart.toml --task wall" in page.by_id("strip").inner_text()
    page.by_id("panel-work").get_by_role("button", name="free, as 20 kg").click()
    page.by_id("panel-work").locator("table").wait_for(timeout=120000)
    figures = page.by_id("panel-work").locator("figure.drawing")
    assert figures.locator("figcaption").all_inner_texts() == ["Motion", "History", "Energy"]  # as the command draws
    for image in figures.locator("img").all():
        image.scroll_into_view_if_needed()
        page.until(lambda image=image: image.bounding_box()["height"] > 100)
    assert page.fits()
    assert page.problems == []


@EACH_BROWSER
@sampled("size", sorted(SIZES, key=lambda size: size != "narrow"), slow=3)
def test_every_shipped_study_fits_every_window(browser, server, size):
    with Page(browser, server.address, size) as page:
        page.ready()
        for study in shipped_studies():
            page.opened(study)
            assert page.fits(), study
        assert page.problems == []


def test_a_part_of_the_catalogue_is_found_and_picked(page):
    before = page.efficiency("cobotic")
    page.unfold("Gearhead")
    page.page.get_by_role("button", name="Choose another part: Gearhead").click()
    page.page.get_by_label("Search the catalogue").fill("gpx 32 up")
    dialog = page.page.get_by_role("dialog")
    dialog.get_by_role("button", name="GPX 32 UP").first.click()
    page.settled()
    assert page.page.locator(".pick .now", has_text="GPX 32 UP").count() == 1
    assert page.efficiency("cobotic") != before
    page.by_id("undo").click()
    page.settled()
    assert page.efficiency("cobotic") == before


def test_a_condition_that_is_not_whole_yet_is_told_at_the_search(page):
    page.unfold("Gearhead")
    page.page.get_by_role("button", name="Choose another part: Gearhead").click()
    search, found = page.page.get_by_label("Search the catalogue"), page.page.locator(".found")
    for text in ("mass < 0.3", "mass < abc", "<img src=x>", "mass < 1e400 kg"):
        search.fill(text)
        found.locator("p.no").wait_for()
        assert found.locator("button").count() == 0
    search.fill("mass < 300 g")
    found.locator("button").first.wait_for()
    assert page.problems == []


def test_rows_of_a_list_are_edited_and_the_saved_file_keeps_its_comments(page, tmp_path):
    source = tmp_path / "cart.toml"
    source.write_text(f"# mine\n{study_file(Path('planar_cart')).read_text()}# the end\n")
    page.by_id("file").set_input_files(source)
    page.page.locator("table.tasks").wait_for()
    page.settled()
    page.by_id("find").fill("positions")
    page.enter("Positions", "x = 0.5 m; x = -0.2 m, y = 0.25 m; x = -0.2 m, y = -0.25 m")
    page.page.locator(".field.changed", has_text="Positions").wait_for()
    assert page.field("Positions").input_value() == "x = 0.5 m\nx = -0.2 m, y = 0.25 m\nx = -0.2 m, y = -0.25 m"
    assert page.field("Positions").get_attribute("aria-invalid") is None
    saved = page.saved(tmp_path / "saved").read_text()
    before, after = source.read_text().splitlines(), saved.splitlines()
    assert [line for line in before if line not in after] == [
        line for line in before if 'x = "0.4 m" }, { x = "-0.2' in line
    ]
    assert '{ x = "0.5 m" }' in saved
    page.enter("Positions", "x = 0.5 m; y = 7")
    assert page.field("Positions").get_attribute("aria-invalid") == "true"


def test_the_address_follows_the_state(page, browser):
    assert "#" not in page.page.url
    page.enter("Preload", "543 N")
    page.page.keyboard.press("Alt+m")
    page.page.keyboard.press("ArrowRight")
    page.by_id("glance").get_by_role("button", name="Motor 2, 4:1").click()
    page.field("Preload").wait_for(state="detached")
    point = page.point()

    page.page.wait_for_timeout(2000)  # the address follows after a pause
    with Page(browser, page.page.url) as other:
        other.ready()
        other.field("Preload").wait_for(state="detached")
        assert other.point() == point
    page.page.reload()
    page.page.locator("#status[data-first]").wait_for()
    page.settled()
    assert page.point() == point


def test_what_is_typed_is_in_the_file_that_a_key_saves(page, tmp_path):
    page.field("Preload").fill("432 N")
    with page.page.expect_download() as found:
        page.page.keyboard.press("Control+s")
    found.value.save_as(tmp_path / "saved.toml")
    assert "432 N" in (tmp_path / "saved.toml").read_text()


def test_map_and_view_say_the_same_of_the_point(page):
    for count in ("60", "200"):
        page.by_id("count").select_option(count)
        for key in ("Home", "ArrowRight", "Shift+ArrowUp", "ArrowDown"):
            page.page.keyboard.press("Alt+m")
            page.page.keyboard.press(key)
            page.settled()
            percent = page.readout("cobotic").partition(" %")[0] + " %"
            page.by_id("panel-balance").get_by_text(percent).first.wait_for()


def test_a_study_that_was_changed_is_a_step_away_when_another_is_opened(page):
    page.enter("Preload", "300 N")
    page.opened("knee_walking")
    page.page.get_by_role("button", name="Back to it").click()
    page.page.locator("[data-shown='300 N']").wait_for()
    page.settled()
    page.by_id("undo").click()
    page.settled()
    assert page.field("Preload").get_attribute("data-shown") == "650 N"
    page.opened("knee_walking")
    assert page.page.get_by_role("button", name="Back to it").count() == 0


@pytest.mark.full
def test_a_long_computation_ends_with_its_study(page):
    page.page.get_by_role("tab", name="Compare and size").click()
    panel = page.by_id("panel-work")
    panel.get_by_role("button", name="Compare all drives").click()
    panel.get_by_role("progressbar").wait_for()
    page.opened("knee_walking")
    panel.get_by_role("progressbar").wait_for(state="hidden")
    panel.get_by_role("button", name="Compare all drives").click()
    results = panel.locator("table").first
    results.wait_for(timeout=120000)
    assert results.locator("tbody tr").count() == 2


def test_the_tasks_of_machines_do_not_cover_what_is_below_them(browser, server):
    with Page(browser, server.address, "narrow") as page:
        page.ready()
        page.opened("six_leg_display")
        page.page.locator("table.tasks").wait_for()
        page.page.get_by_role("tab", name="Power balance").click()
        page.page.locator("#panel-balance .why").wait_for(state="hidden")
        assert page.fits()


def test_exports_are_files(page, tmp_path):
    for kind, end in (("Report", ".zip"), ("Figure", ".svg"), ("Data", ".csv")):
        page.by_id("export").click()
        with page.page.expect_download(timeout=60000) as found:
            page.page.get_by_role("dialog").get_by_role("button", name=re.compile(kind + " The")).click()
        assert found.value.suggested_filename.endswith(end)
        found.value.save_as(tmp_path / kind)
    assert "report.html" in zipfile.ZipFile(tmp_path / "Report").namelist()
    assert (tmp_path / "Figure").read_text().startswith("<?xml")
    lines = (tmp_path / "Data").read_text().splitlines()
    assert "efficiency" in lines[0]
    assert len(lines) == 1 + 200**2


def test_a_long_computation_shows_progress_and_can_be_cancelled(page):
    page.page.get_by_role("tab", name="Compare and size").click()
    panel = page.by_id("panel-work")
    panel.get_by_role("button", name="Compare all drives").click()
    panel.get_by_role("progressbar").wait_for()
    panel.get_by_role("button", name="Cancel").click()
    panel.get_by_text("Cancelled.").wait_for()
    panel.get_by_role("button", name="Compare all drives").click()
    results = panel.locator("table").first
    results.wait_for(timeout=120000)
    assert results.locator("tbody tr").count() == 6


def test_the_options_of_a_computation_are_a_form(page):
    page.opened("knee_walking")
    page.page.get_by_role("tab", name="Compare and size").click()
    panel = page.by_id("panel-work")
    panel.get_by_text("Options").first.click()
    panel.get_by_label("quick").check()
    panel.get_by_label("engine").select_option("numpy")
    panel.get_by_role("button", name="Compare all drives").click()
    panel.locator("table").first.wait_for(timeout=120000)
    panel.get_by_text("Options").last.click()
    assert panel.get_by_label("top").get_attribute("placeholder") == "20"
    panel.get_by_label("life").fill("2 N")
    panel.get_by_role("button", name="Search the catalogue").click()
    panel.get_by_text("life '2 N'").wait_for(timeout=60000)


def test_a_view_that_is_missing_leaves_the_rest_alone(browser, server):
    with Page(browser, server.address) as page:
        page.page.route("**/views/contact.js", lambda route: route.abort())
        page.ready()
        page.page.get_by_role("tab", name="Rolling contact").click()
        page.by_id("panel-contact").get_by_text("could not be loaded").wait_for()
        page.slide("Preload", 700)
        page.page.get_by_role("tab", name="Power balance").click()
        page.page.locator("#panel-balance .why").wait_for(state="hidden")


def test_files_that_are_no_study_are_refused_in_words(page, tmp_path):
    file = tmp_path / "no study.toml"
    file.write_text("[drives.cobotic\n")
    page.by_id("file").set_input_files(file)
    notice = page.page.get_by_role("alert").filter(has_text="was not opened")
    notice.wait_for()
    assert "not valid TOML" in notice.inner_text()
    file.write_text("#" * 5_000_000)
    page.by_id("file").set_input_files(file)
    notice.filter(has_text="5000000 bytes").wait_for()
    page.by_id("file").set_input_files(study_file(Path("knee_walking")))
    page.page.locator("#study-title", has_text="knee").wait_for()
    notice.wait_for(state="detached")


@pytest.mark.full
def test_a_study_is_offered_again_after_a_kill(browser, tmp_path):
    port = str(free_port())
    with serving("--port", port, folder=tmp_path) as first, Page(browser, first.address) as page:
        page.ready()
        page.edit_and_lose(first)
    with serving("--port", port, folder=tmp_path) as second, Page(browser, second.address) as page:
        page.ready()
        assert page.field("Preload").input_value() == "650 N"
        page.page.get_by_role("button", name="Restore").click()
        page.page.locator("[data-shown='777 N']").wait_for()


def test_loading_the_page_again_keeps_what_was_edited(page):
    page.enter("Preload", "700 N")
    page.page.reload()
    page.page.locator("[data-shown='700 N']").wait_for()
    page.settled()
    page.page.get_by_role("button", name="Reset Preload").click()
    page.settled()
    assert page.field("Preload").get_attribute("data-shown") == "650 N"


@pytest.mark.parametrize("asked", [False, True])
def test_without_the_program_the_page_says_so_and_goes_on_when_it_is_back(page, asked):
    page.page.route("**/api/*", lambda route: route.abort())
    page.field("Preload").fill("800 N")
    page.field("Preload").press("Enter")
    page.page.get_by_role("alert").filter(has_text="is `infinivar serve` still running?").wait_for()
    if asked:  # the page itself asks for this answer until it comes: without it, only the button goes on
        page.page.route("**/api/disk", lambda route: route.abort())
    page.page.unroute("**/api/*")
    if asked:
        page.page.get_by_role("button", name="Try again").click()
    page.page.locator("[data-notice=broken]").wait_for(state="detached")
    page.settled()
    assert page.field("Preload").get_attribute("data-shown") == "800 N"


@pytest.mark.parametrize("dark", [False, pytest.param(True, marks=pytest.mark.full)])
@sampled("state", ["tabs", "pinned", "machine", "sessions", "part", "help"], slow=6)
def test_axe_finds_no_fault_in_other_states(browser, server, state, dark):
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed"
    ).Axe()
    with Page(browser, server.address, color_scheme="dark" if dark else "light", bypass_csp=True) as page:
        page.ready()
        if state == "pinned":
            page.by_id("pin").click()
            page.slide("Preload", 800)
        elif state in ("machine", "sessions"):
            page.opened({"machine": "six_leg_display", "sessions": "guided_cart"}[state])
        elif state == "part":
            page.unfold("Gearhead")
            page.page.get_by_role("button", name="Choose another part: Gearhead").click()
            page.page.locator(".found button").first.wait_for()
        elif state == "help":
            page.page.keyboard.press("F1")
            page.page.get_by_role("dialog").wait_for()
        tabs = page.page.get_by_role("tab").all() if state == "tabs" else [None]
        for tab in tabs:
            if tab is not None and tab.is_visible():
                tab.click()
                page.page.wait_for_timeout(1500)
            found = axe.run(page.page).response["violations"]
            assert [(one["id"], one["help"], [node["target"] for node in one["nodes"][:4]]) for one in found] == []
