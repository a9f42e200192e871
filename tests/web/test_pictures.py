"""Maps as pictures: lines where margins are one, hatched beyond, grey while they load, and scales that say what exceeds them."""

import io

import matplotlib.image
import numpy as np
import pytest

import infinivar as iv
from explorer_pages import Page
from internals import of_study
from sampled import sampled

pytestmark = pytest.mark.slow

LEFT, RIGHT, TOP, BOTTOM = 50, 10, 6, 38
"""Around the plane of a map, for its axes. [pixels]"""


@pytest.fixture
def page(browser, server):
    with Page(browser, server.address) as found:
        yield found.ready()
        assert found.problems == []


def picture(page, drive):
    """The plane of a map: rows from the top, columns from the left, red, green and blue of 0 to 1."""
    plot = page.page.locator(f".map[data-drive='{drive}'] .plot:visible").last
    plot.scroll_into_view_if_needed()
    image = matplotlib.image.imread(io.BytesIO(plot.screenshot()))[..., :3]
    return image[TOP:-BOTTOM, LEFT:-RIGHT]


def ends(axis):
    """Ends of a map from the centres of its cells."""
    half = 0.5 * (axis[1] - axis[0])
    return axis[0] - half, axis[-1] + half


@sampled("count", ["60", "200"], slow=2)
def test_the_line_of_a_limit_is_where_the_margin_is_one(page, count):
    """Within 1.5 pixels, in columns where the line is not steep; a cell of the coarse maps is over 6 pixels high."""
    study, drive = iv.load_study("hand_controller"), "cobotic"
    speed, force = of_study(study).axes(4000)
    page.page.set_viewport_size({"width": 1000, "height": 1100})
    page.page.locator(".owner-line", has_text="Motor 2").get_by_role("checkbox").uncheck()
    page.by_id("count").select_option(count)
    page.settled()
    image = picture(page, drive).sum(axis=-1)
    height, width = image.shape
    assert height > 60 * 6
    across, up = ends(force), ends(speed)
    hair = height * (1.0 - (page.point()[0] - up[0]) / (up[1] - up[0]))
    found = 0
    for newtons in np.linspace(22.0, 66.0, 23):
        margin = iv.steady_map(study.drives[drive], speed, [newtons]).margin[:, 0]
        (passing,) = np.flatnonzero((margin[:-1] >= 1.0) & (margin[1:] < 1.0))
        expected = height * (1.0 - (speed[passing] - up[0]) / (up[1] - up[0]))
        if abs(expected - hair) < 12:
            continue  # the hair over the line
        found += 1
        column = image[:, int(width * (newtons - across[0]) / (across[1] - across[0]))]
        around = slice(int(expected) - 9, int(expected) + 10)
        dark = np.flatnonzero(column[around] < 0.6) + around.start + 0.5  # of 3: the line is nearly black
        assert dark.size, newtons
        assert abs(dark.mean() - expected) <= 1.5, newtons
    assert found >= 18


def test_regions_beyond_a_limit_are_hatched_and_those_within_are_not(page):
    page.opened("hand_controller")
    image = picture(page, "cobotic")
    height, width = image.shape[:2]
    beyond = image[int(0.30 * height) : int(0.40 * height), int(0.85 * width) : int(0.97 * width)].sum(axis=-1)
    within = image[int(0.60 * height) : int(0.66 * height), int(0.05 * width) : int(0.08 * width)].sum(axis=-1)

    def steps(values):
        """Largest difference of neighbours along a row."""
        return float(np.abs(np.diff(values, axis=1)).max())

    assert np.ptp(beyond) > 0.05
    assert steps(beyond) > 0.03
    # Oblique lines: a row is that above it, shifted by one pixel.
    assert np.abs(beyond[1:, :-1] - beyond[:-1, 1:]).mean() < 0.5 * np.abs(beyond[1:] - beyond[:-1]).mean()
    assert within.size > 8


def test_a_scale_says_what_exceeds_it(page):
    page.opened("knee_walking")
    study = iv.load_study("knee_walking")
    scale = page.by_id("scale")
    scale.locator("canvas.over").wait_for()
    end = float(scale.inner_text().split("load drives 0")[1].split(" W")[0])
    losses = []
    for drive in study.drives.values():
        made = iv.steady_map(drive, *of_study(study).axes(200))
        spent = (made.limit == 0) & (made.power_out < 0) & (made.power_in >= 0)
        losses.append(float(np.max(made.power_in - made.power_out, where=spent, initial=0.0)))
    assert max(losses) > end
    assert "W or more" in scale.inner_text()
    page.opened("hand_controller")
    scale.locator("canvas.over").wait_for(state="detached")
    assert "or more" not in scale.inner_text()


def test_maps_are_grey_and_of_their_size_while_they_load(page):
    held = []
    page.page.route("**/api/maps", lambda request: held.append(request))
    page.by_id("shipped").select_option("knee_walking")
    plots = page.page.locator(".plot:visible")
    page.page.locator(".map[data-drive=geared]").wait_for()
    page.page.wait_for_timeout(500)
    grey = picture(page, "geared")[2:-2, 2:-2]
    assert np.ptp(grey.reshape(-1, 3), axis=0).max() == 0.0
    sizes = [plot.bounding_box() for plot in plots.all()]
    for request in held:
        request.continue_()
    page.page.unroute("**/api/maps")
    page.settled()
    page.page.locator("#scale", has_text="load drives").wait_for()
    after = [plot.bounding_box() for plot in plots.all()]
    assert [(one["width"], one["height"]) for one in sizes] == [(one["width"], one["height"]) for one in after]
    assert np.ptp(picture(page, "geared").reshape(-1, 3), axis=0).min() > 0.5


@sampled("study", ["hand_controller", "knee_walking", "ankle_walking", "planar_cart"], slow=2)
def test_the_plane_of_frequency_and_power_is_offered_where_it_exists(page, study):
    page.opened(study)
    loaded = iv.load_study(study)
    required = loaded.requirement
    exists = bool(required is not None and required.power and loaded.load_mass)
    assert page.page.get_by_role("tab", name="Frequency and power").is_visible() == exists
