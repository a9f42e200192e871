"""The page of maps without a server, opened as a file in a real Chromium: its numbers are those of the program."""

import importlib.util

import numpy as np
import pytest

import infinivar as iv
from explorer_pages import SIZES, started
from internals import c_library, of_study, with_values
from made import ROOT, loaded

pytestmark = pytest.mark.slow


def _extension():
    spec = importlib.util.spec_from_file_location("live_maps", ROOT / "docs" / "_ext" / "live_maps.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


live = _extension()
STARTS = {one["path"]: one["start"] for one in live.facts()["sliders"]}


@pytest.fixture(scope="module", params=["desktop", "narrow"])
def page(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("live")
    style = (ROOT / "docs" / "_static" / "live-maps.css").read_text("utf-8")
    script = live.script()
    assert len(script) < 2_000_000
    (folder / "live-maps.js").write_text(script, "utf-8")
    (folder / "page.html").write_text(
        f'<!doctype html><meta charset="utf-8"><meta name="viewport" content="width=device-width"><style>{style}</style>'
        '<div id="live-maps"></div><script src="live-maps.js" defer></script>',
        "utf-8",
    )
    with started() as browser:
        width, height = SIZES[request.param]
        found = browser.new_page(viewport={"width": width, "height": height})
        problems = []
        found.on("pageerror", lambda problem: problems.append(str(problem)))
        found.goto((folder / "page.html").as_uri())
        found.locator("#live-maps[data-painted]").wait_for()
        yield found
        assert problems == []


def place(page):
    return page.locator("#live-maps")


def points(name, changed):
    """Twenty points of the plane by the program: speed, force, efficiency, limit, power from the supply."""
    study = loaded(live.STUDY)
    drive = with_values(study.drives[name], changed)
    random = np.random.default_rng(3)
    speeds, forces = of_study(study).axes(224)
    for speed, force in zip(random.choice(speeds[:70], 20), random.choice(forces, 20), strict=True):
        found = iv.steady_map(drive, [speed], [force])
        yield speed, force, int(found.limit[0, 0]), found.power_in[0, 0], found.efficiency[0, 0]


@pytest.mark.parametrize("moved", [{}, {"motor.voltage": 18.0, "amplifier.standby_power": 0.7}])
@pytest.mark.parametrize("drive", range(2))
def test_its_numbers_are_those_of_the_program(page, drive, moved):
    own = (
        {
            0: {"cylinder_speed": 9.0, "transmission.friction": 0.1},
            1: {"gearhead.ratio": 8.0, "gearhead.efficiency": 0.8},
        }[drive]
        if moved
        else {}
    )
    changed, within = moved | own, 0
    give = "(given) => Object.assign(document.getElementById('live-maps').values, given)"
    page.evaluate(give, STARTS | changed)
    for speed, force, limit, power, efficiency in points(list(live.DRIVES)[drive], changed):
        call = "([drive, speed, force]) => document.getElementById('live-maps').at(drive, speed, force)"
        found = page.evaluate(call, [drive, float(speed), float(force)])
        assert found[2] == limit
        assert found[3] == pytest.approx(power, rel=1e-10, abs=1e-10, nan_ok=True)
        if not np.isnan(found[0]):
            within += 1
            assert found[0] == pytest.approx(efficiency, rel=1e-10)
    assert within >= 3


def test_sliders_move_the_maps_and_nothing_overflows(page):
    assert float(place(page).get_attribute("data-milliseconds")) < 1000.0
    note = page.locator(".live-note").nth(1)
    before, painted = note.text_content(), int(place(page).get_attribute("data-painted"))
    page.get_by_role("slider", name="Gear ratio").fill("40")
    page.wait_for_function(f"() => Number(document.getElementById('live-maps').dataset.painted) > {painted}")
    assert note.text_content() != before
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.skipif(c_library.zig() is None, reason="ziglang is not installed: the extra compiled, of 411 MB")
def test_the_law_is_what_the_generator_gives():
    assert live.compiled() == live.WASM.read_bytes()
