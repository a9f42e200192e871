"""The page of the explorer in real browsers, for tests: locators only, as its policy forbids code in text."""

from __future__ import annotations

import contextlib
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

BROWSERS = {
    "chromium": (("chromium",), {"args": ["--no-sandbox"]}),
    "firefox": (("firefox", "firefox-esr"), {"channel": "moz-firefox"}),
}
"""Programs of each browser, as the system installs it, and how it is started."""

EACH_BROWSER = pytest.mark.parametrize("browser", BROWSERS, indirect=True)
"""Marks tests that take the fixture `browser`, to run in each."""
SIZES = {"desktop": (1280, 720), "tablet": (820, 1180), "narrow": (420, 860)}


@contextlib.contextmanager
def started(name: str = "chromium") -> Iterator[Any]:
    """A browser; a test that asks for it is skipped where there is none."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    programs, options = BROWSERS[name]
    program = next(filter(None, map(shutil.which, programs)), None)
    if program is None:
        pytest.skip(f"{name} is not installed")
    with api.sync_playwright() as playwright:
        browser = getattr(playwright, name).launch(executable_path=program, **options)
        try:
            yield browser
        finally:
            browser.close()


class Page:
    """One window with the page."""

    def __init__(self, browser: Any, address: str, size: str = "desktop", **options: Any) -> None:
        width, height = SIZES[size]
        self.context = browser.new_context(viewport={"width": width, "height": height}, **options)
        self.context.set_default_timeout(40000)
        self.page = self.context.new_page()
        self.problems: list[str] = []
        self.requests: list[str] = []
        self.page.on("pageerror", lambda problem: self.problems.append(str(problem)))
        self.page.on("console", lambda said: said.type == "error" and self.problems.append(said.text))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: object) -> None:
        self.context.close()

    def by_id(self, name: str) -> Any:
        return self.page.locator(f"#{name}")

    def ready(self, tour: bool = False) -> Page:
        """Wait for the first maps; take the tour that the first visit offers, or not."""
        self.page.locator("#status[data-first]").wait_for()
        self.settled()
        offer = self.page.locator("[data-notice=tour]")
        offer.get_by_role("button", name="Take the tour" if tour else "Dismiss").click()
        return self

    def opened(self, study: str) -> None:
        """Choose a shipped study unless it is shown, and wait until it is."""
        title = self.by_id("shipped").locator(f"option[value={study}]").inner_text()
        if self.page.get_by_role("heading", name=title, exact=True).count() == 0:
            self.by_id("shipped").select_option(study)
            self.page.get_by_role("heading", name=title, exact=True).wait_for()
        self.settled()

    def settled(self) -> None:
        """Wait until study and maps are those of the last change."""
        self.page.locator("#study[aria-busy=false]").wait_for()
        self.page.locator("#maps[aria-busy=false]").wait_for()

    def until(self, met: Callable[[], bool], seconds: float = 40.0) -> None:
        """Wait for what no locator says; the clock of the page goes on."""
        end = time.monotonic() + seconds
        while not met():
            assert time.monotonic() < end, f"not met after {seconds} s"
            self.page.wait_for_timeout(5)

    def paints(self) -> int:
        return int(self.by_id("status").get_attribute("data-paints") or 0)

    def painted(self, after: int, seconds: float = 40.0) -> float:
        """Wait for maps painted after so many; how long they took, by the clock of the page. [ms]"""
        self.until(lambda: self.paints() > after, seconds)
        return float(self.by_id("status").get_attribute("data-took"))

    def field(self, label: str) -> Any:
        return self.page.get_by_label(label, exact=True)

    def enter(self, label: str, text: str) -> None:
        """Type a value and confirm it."""
        self.field(label).fill(text)
        self.field(label).press("Enter")
        self.settled()

    def edit_and_lose(self, server: Any) -> None:
        """Edit the preload, kill the server once that is written, edit on, and see that nothing answers."""
        self.enter("Preload", "777 N")
        self.page.wait_for_timeout(1500)  # what was sent is written within a second
        server.stop(signal.SIGKILL)
        self.field("Preload").fill("778 N")
        self.field("Preload").press("Enter")
        self.page.get_by_role("alert").filter(has_text="is `infinivar serve` still running?").wait_for()

    def unfold(self, part: str) -> None:
        """Open a part behind "All values"."""
        self.page.locator("summary", has_text="All values").click()
        self.page.locator("summary", has_text=part).first.click()

    def slider(self, label: str) -> Any:
        return self.page.get_by_role("slider", name=f"{label}, slider")

    def slide(self, label: str, place: int) -> None:
        """Move a slider to a place, 0 to 1000, and wait for its maps."""
        before = self.paints()
        self.slider(label).fill(str(place))
        self.painted(before)
        self.settled()

    def efficiency(self, drive: str) -> float:
        """Efficiency of the map of a drive at the point, unrounded."""
        return float(self.page.locator(f".map[data-drive='{drive}'] .readout").get_attribute("data-efficiency"))

    def readout(self, drive: str) -> str:
        return self.page.locator(f".map[data-drive='{drive}'] .readout").inner_text()

    def point(self) -> tuple[float, float]:
        """Speed and force."""
        place = self.by_id("where")
        return float(place.get_attribute("data-speed")), float(place.get_attribute("data-force"))

    def saved(self, folder: Path) -> Path:
        """The study file that the page saves."""
        if self.context.browser.browser_type.name == "firefox":
            pytest.skip(
                "what Firefox downloads does not reach the test: Playwright does not hand it on over WebDriver BiDi"
            )
        with self.page.expect_download() as found:
            self.by_id("save").click()
        file = folder / found.value.suggested_filename
        found.value.save_as(file)
        return file

    def link(self) -> str:
        """The address that the page copies."""
        self.by_id("link").click()
        self.page.locator("#said", has_text="Link copied").or_(self.page.locator("#link-text")).first.wait_for()
        return self.page.url

    def fits(self) -> bool:
        """Whether nothing is wider than the window: the last column of its pixels is reached without scrolling."""
        width = self.page.viewport_size["width"]
        boxes = [one.bounding_box() for one in self.page.locator("header, main, section:visible, .strip, .tabs").all()]
        return all(box is None or (box["x"] >= -0.5 and box["x"] + box["width"] <= width + 0.5) for box in boxes)
