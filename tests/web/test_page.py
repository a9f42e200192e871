"""The page in real browsers: what a user does with it, and that its numbers are those of the public functions."""

import math

import pytest

import infinivar as iv
from explorer_pages import EACH_BROWSER, Page
from internals import foremost, of_study

pytestmark = [pytest.mark.slow, EACH_BROWSER]

COBOTIC, GEARED = "cobotic", "motor2-gear4"


@pytest.fixture
def page(browser, server):
    with Page(browser, server.address) as found:
        yield found.ready()
        assert found.problems == []


def at_cell(study, name, speed, force, count=200):
    """Efficiency of the cell of a map that holds a point, by the public function."""
    axes = of_study(study).axes(count)
    cell = [
        axis[[round((value - axis[0]) / (axis[1] - axis[0]))]] for axis, value in zip(axes, (speed, force), strict=True)
    ]
    return iv.steady_map(study.drives[name], *cell).efficiency.item()


def test_opens_with_the_maps_of_two_drives_and_a_tour(browser, server):
    with Page(browser, server.address) as page:
        page.ready(tour=True)
        assert page.page.locator(".map").count() == 2
        tour = page.page.get_by_role("dialog", name="A study")
        tour.wait_for()
        for _ in range(7):
            page.page.get_by_role("button", name="Next").click()
        page.page.get_by_role("button", name="Done").click()
        page.page.locator(".tour").wait_for(state="hidden")
        page.page.locator("#glance[aria-busy=false]").wait_for()  # else the reload ends the question, an error
        page.page.reload()
        page.page.locator("#status[data-first]").wait_for()
        page.settled()
        assert page.page.locator("[data-notice=tour]").count() == 0  # only on the first visit
        assert {url.split("/api")[0].split("/page")[0].rstrip("/") for url in page.requests} == {
            server.address.rstrip("/")
        }
        assert page.problems == []
        print(f"first map {page.by_id('status').get_attribute('data-first')} ms after navigation")


def test_the_answer_stands_above_the_maps(page):
    page.opened("hand_controller")
    compared = iv.compare(iv.load_study("hand_controller"), quick=True)
    answer = page.by_id("glance")
    answer.get_by_role("heading", name=compared.best.title).wait_for()
    assert answer.bounding_box()["y"] < page.by_id("maps").bounding_box()["y"]
    assert answer.locator("tbody tr").count() == len(compared.results)
    assert [row.inner_text().startswith("✓") for row in answer.locator("tbody th").all()] == [
        compared.able(name) for name in compared.results
    ]
    answer.get_by_role("button", name="Motor 2, 4:1").click()
    assert page.page.locator(".owner-line button[aria-pressed=true]").inner_text().startswith("Motor 2, 4:1")
    page.by_id("tab-balance").click()
    page.page.locator("#panel-balance strong", has_text="Motor 2, 4:1").wait_for()


def test_two_clicks_make_a_drive_feasible_and_one_undoes_it(page):
    page.opened("hand_controller")
    answer = page.by_id("glance")
    answer.get_by_role("button", name="Motor 1, 4:1").click()
    answer.get_by_role("button", name="What would mend it?").click()
    answer.get_by_role("button", name="Apply").first.wait_for()
    answer.get_by_role("button", name="Motor 2, 4:1").click()
    answer.get_by_role("button", name="Motor 1, 4:1").click()
    answer.get_by_role("button", name="Apply").first.click()
    row = answer.locator("tbody tr", has_text="Motor 1, 4:1")
    row.locator(".yes").wait_for()
    page.page.keyboard.press("Control+z")
    row.locator("span.no").wait_for()
    page.settled()


def test_the_values_that_matter_most_stand_first_and_the_others_are_found(page):
    few = page.page.locator(".few .field")
    ranked = foremost(iv.load_study("hand_controller"), COBOTIC)
    paths = [one.get_attribute("data-at").removeprefix(f"drives.{COBOTIC}.") for one in few.all()]
    assert 5 <= len(paths) <= 8
    assert paths == list(ranked[: len(paths)])
    page.slide("Preload", 900)
    assert [one.get_attribute("data-at").removeprefix(f"drives.{COBOTIC}.") for one in few.all()] == paths
    hidden = page.field("Crown radius")
    assert not hidden.is_visible()
    page.by_id("find").fill("crown")
    hidden.wait_for()
    page.by_id("find").fill("")
    page.by_id("glance").get_by_role("button", name="Motor 2, 4:1").click()
    few.filter(has_text="Continuous torque").wait_for()
    assert page.page.locator(".owner-line", has_text="Motor 2, 4:1").locator(".letter").inner_text() == "F"


def test_a_slider_moves_the_numbers_to_those_of_the_public_functions(page, tmp_path):
    before = page.efficiency(COBOTIC)
    page.slide("Preload", 800)
    after = page.efficiency(COBOTIC)
    assert abs(after - before) > 0.01
    study = iv.load_study(page.saved(tmp_path))
    assert study.drives[COBOTIC].transmission.preload == pytest.approx(130 * 25**0.8, rel=1e-3)
    speed, force = page.point()
    for name in (COBOTIC, GEARED):
        expected = at_cell(study, name, speed, force)
        assert page.efficiency(name) == pytest.approx(expected, rel=1e-6)
        assert page.readout(name).startswith(f"{100 * expected:.1f} %")


def test_an_invalid_value_has_the_words_of_the_command_line_at_its_field(page, tmp_path):
    shown = page.efficiency(COBOTIC)
    page.enter("Preload", "-5 N")
    field = page.field("Preload")
    assert field.get_attribute("aria-invalid") == "true"
    message = page.by_id(field.get_attribute("aria-describedby")).inner_text()
    file = tmp_path / "study.toml"
    file.write_text(
        '[requirement]\nbase = "faulring2006"\n[drives.cobotic]\nbase = "faulring2006.cobotic"\ntransmission.preload = "-5 N"\n'
    )
    with pytest.raises(iv.InputError) as caught:
        iv.load_study(file)
    assert message in str(caught.value)
    assert "preload" in message
    assert page.efficiency(COBOTIC) == shown  # the last valid maps stay
    page.enter("Preload", "700 N")
    assert field.get_attribute("aria-invalid") is None


def test_a_saved_study_opens_in_the_same_state(page, browser, server, tmp_path):
    page.enter("Preload", "0.8 kN")
    page.enter("Cylinder speed", "150 rpm")
    numbers = [page.readout(name) for name in (COBOTIC, GEARED)]
    file = page.saved(tmp_path)
    with Page(browser, server.address) as other:
        other.ready()
        assert [other.readout(name) for name in (COBOTIC, GEARED)] != numbers
        other.by_id("file").set_input_files(file)
        other.page.get_by_label("Preload", exact=True).and_(other.page.locator("[data-shown='0.8 kN']")).wait_for()
        other.settled()
        assert other.field("Cylinder speed").input_value() == "150 rpm"
        assert [other.readout(name) for name in (COBOTIC, GEARED)] == numbers
        assert other.saved(tmp_path / "again").read_text() == file.read_text()


def test_a_link_holds_the_whole_study(page, browser, server):
    page.enter("Preload", "900 N")
    numbers, point = [page.efficiency(name) for name in (COBOTIC, GEARED)], page.point()
    address = page.link()
    with Page(browser, address) as other:
        other.ready()
        assert other.field("Preload").input_value() == "900 N"
        assert other.point() == point
        assert [other.efficiency(name) for name in (COBOTIC, GEARED)] == numbers
    with Page(browser, address[:-9]) as other:
        other.ready()
        assert "damaged" in other.page.locator(".notice").inner_text()


def test_a_pinned_state_stays_beside_the_changed_one(page):
    before = page.efficiency(COBOTIC)
    page.by_id("pin").click()
    page.slide("Preload", 800)
    now = page.efficiency(COBOTIC)
    change = f"{'−' if now < before else '+'}{100 * abs(now - before):.1f} points"
    assert f"before {100 * before:.1f} %" in page.readout(COBOTIC)
    assert change in page.readout(COBOTIC)
    assert page.page.locator(".map .plot:visible").count() == 4
    page.page.get_by_role("button", name="Difference").click()
    page.page.locator("#scale", has_text="points").wait_for()
    assert page.page.locator(".map .plot:visible").count() == 2
    page.by_id("pin").click()
    page.page.locator("#modes").wait_for(state="hidden")
    page.until(lambda: "before" not in page.readout(COBOTIC))


def test_each_gesture_is_undone_and_redone_as_one(page):
    first = page.efficiency(COBOTIC)
    slider = page.slider("Preload")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    page.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.page.mouse.down()
    for step in range(1, 6):
        page.page.mouse.move(box["x"] + box["width"] * (0.5 + 0.06 * step), box["y"] + box["height"] / 2)
    page.page.mouse.up()
    page.settled()
    dragged = page.efficiency(COBOTIC)
    assert dragged != first
    page.enter("Cylinder speed", "20 rad/s")
    page.page.keyboard.press("Control+z")
    page.settled()
    assert page.efficiency(COBOTIC) == dragged
    page.page.keyboard.press("Control+z")
    page.settled()
    assert page.efficiency(COBOTIC) == first
    assert page.by_id("undo").is_disabled()
    assert page.field("Preload").input_value() == "650 N"
    page.page.keyboard.press("Control+Shift+Z")
    page.settled()
    assert page.efficiency(COBOTIC) == dragged


def test_keys_alone_change_a_value_move_the_point_and_open_a_view(page):
    press = page.page.keyboard.press
    press("Alt+f")
    page.page.keyboard.type("preload")
    field = page.field("Preload")
    for _ in range(12):
        press("Tab")
        if field.and_(page.page.locator(":focus")).count():
            break
    press("Control+a")
    page.page.keyboard.type("1 kN")
    press("Enter")
    page.settled()
    assert field.get_attribute("data-shown") == "1 kN"
    press("Alt+m")
    speed, force = page.point()
    for key in ("ArrowRight", "Shift+ArrowUp"):
        press(key)
    assert page.point() == pytest.approx((speed + 0.147, force + 0.7))
    press("Alt+v")
    press("End")
    assert page.page.get_by_role("tab", selected=True).inner_text() == "Compare and size"
    press("Alt+b")
    assert page.by_id("pin").get_attribute("aria-pressed") == "true"


@pytest.mark.parametrize("size", ["desktop", "tablet", "narrow"])
def test_nothing_is_wider_than_the_window(browser, server, size):
    with Page(browser, server.address, size, has_touch=size != "desktop") as page:
        page.ready()
        assert page.fits()
        assert page.page.locator(".map").count() == (1 if size == "narrow" else 2)
        page.slider("Preload").scroll_into_view_if_needed()
        page.slide("Preload", 700)
        shown = page.page.locator(".map .plot:visible").first.bounding_box()
        assert shown["y"] >= 0  # the map is in sight while its slider is moved
        assert shown["y"] + shown["height"] <= page.page.viewport_size["height"]


@pytest.mark.parametrize("dark", [False, pytest.param(True, marks=pytest.mark.full)])
def test_axe_finds_no_fault(browser, server, dark):
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed"
    ).Axe()
    # axe is evaluated as text, which the policy of the page forbids to all else.
    with Page(browser, server.address, color_scheme="dark" if dark else "light", bypass_csp=True) as page:
        page.ready()
        assert _violations(axe, page) == []
        page.enter("Preload", "-5 N")
        assert _violations(axe, page) == []


def _violations(axe, page):
    found = axe.run(page.page).response["violations"]
    return [(one["id"], one["help"], [node["target"] for node in one["nodes"][:4]]) for one in found]


def test_the_time_from_a_slider_to_the_painted_maps_is_told(page):
    times = []
    for place in (520, 540, 560, 580, 600):
        before = page.paints()
        page.slider("Preload").fill(str(place))
        times.append(page.painted(before))
    assert all(math.isfinite(one) and one > 0 for one in times)
    print(f"slider to painted maps, two drives, 200 x 200: {sorted(times)[2]:.0f} ms (median of 5)")
