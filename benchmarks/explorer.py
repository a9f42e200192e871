"""The explorer in a real browser: from a slider to repainted maps, and from navigation to the first map.

The page itself takes the time, from the event of the slider until the frame with both maps is handed over; a server of its own
answers, and nothing of an earlier map is known to it, as every value is new. Targets: two drives with all limits at 200 x 200
within 100 ms in the median and 150 ms at the 95th percentile, at 60 x 60 within 30 ms, first map within 300 ms.
"""

from __future__ import annotations

import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from typing import Any

from benchmarks._measure import ROOT, Line

MOVES, OPENED = 40, 5
_PAUSE = 0.6
"""Between moves, so that each is timed alone: verdicts and views of the move before are done. [s]"""

_SETTLED = 3.0
"""Until a new window has loaded the browser's own pages. [s]"""


def run() -> Iterator[Line]:
    """Measure the four lines.

    Raises
    ------
    RuntimeError
        If Chromium is not installed, or the server does not start.
    """
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium")
    if chromium is None:
        raise RuntimeError("Chromium is not installed")
    with tempfile.TemporaryDirectory() as state:
        server = subprocess.Popen(
            [sys.executable, "-m", "infinivar", "serve", "--no-browser"],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "INFINIVAR_STATE": state},
        )
        try:
            assert server.stdout is not None
            found = re.search(r"http://\S+", server.stdout.readline())
            if found is None:
                raise RuntimeError("the server did not start")
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
                yield from _measured(browser, found[0])
        finally:
            server.terminate()
            server.wait(20)


def _measured(browser: Any, address: str) -> Iterator[Line]:
    """Times of a page that is opened several times, and of its sliders."""
    first = []
    for _ in range(OPENED + 1):
        page = _opened(browser, address)
        first.append(_shown(page))
        page.context.close()
    page = _opened(browser, address)
    page.locator("[data-notice=tour]").get_by_role("button", name="Dismiss").click()
    yield _line("first map after navigation, median", statistics.median(first[1:]), 300)
    for count, limit in (("200", 100), ("60", 30)):
        page.locator("#count").select_option(count)
        time.sleep(3 * _PAUSE)
        times = _moved(page, 300 if count == "200" else 303)
        drives = f"two drives, {count} x {count}"
        yield _line(f"slider to painted maps, {drives}, median of {MOVES}", statistics.median(times), limit)
        last = statistics.quantiles(times, n=20)[-1]
        yield _line(f"slider to painted maps, {drives}, 95 %", last, 150 if count == "200" else None)


def _opened(browser: Any, address: str) -> Any:
    page = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
    time.sleep(_SETTLED)
    page.goto(address)
    return page


def _shown(page: Any) -> float:
    """Time of the first map after navigation. [ms]"""
    status = page.locator("#status[data-first]")
    status.wait_for()
    return float(status.get_attribute("data-first"))


def _moved(page: Any, start: int) -> list[float]:
    """Times from the slider to the painted maps of both drives, of which one has changed. [ms]"""
    times = []
    slider, status = page.get_by_role("slider", name="Preload, slider"), page.locator("#status")
    for move in range(MOVES):
        before = int(status.get_attribute("data-paints"))
        slider.fill(str(start + 7 * move))
        time.sleep(_PAUSE)  # whoever looks keeps the page from painting
        if int(status.get_attribute("data-paints")) == before:
            raise RuntimeError("the maps were not painted")
        times.append(float(status.get_attribute("data-took")))
    return times


def _line(what: str, took: float, at_most: float | None) -> Line:
    return Line(
        what=what,
        ours=f"{took:.0f} ms",
        theirs="",
        ratio="",
        target="" if at_most is None else f"<= {at_most:.0f} ms",
        passed=None if at_most is None else took <= at_most,
    )
