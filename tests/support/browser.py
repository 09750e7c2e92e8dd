"""A headless Chromium for the tests of pages: what it was asked for, what it said, what it shows."""
from __future__ import annotations

import base64
import json
import re
import shutil
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.support.wait import WebDriverWait

T = TypeVar("T")
PATIENCE = 120      # until something that should happen counts as not happening [s]
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars")


def find_browser() -> tuple[str, str] | None:
    """Paths of Chromium and its driver."""
    names = "chromium", "chromium-browser", "google-chrome"
    browser, driver = next(filter(None, map(shutil.which, names)), None), shutil.which("chromedriver")
    return (browser, driver) if browser and driver else None


class Browser:
    def __init__(self, driver: webdriver.Chrome) -> None:
        self.driver = driver

    def size(self, width: int, height: int, dark: bool = False) -> None:
        """Set the size of the window, and what the system prefers."""
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})

    def open(self, page: Path, fragment: str = "") -> None:
        """A page, until it says that it is ready."""
        self.driver.get("about:blank")
        self.log()
        self.requests()
        self.driver.get(f"{page.as_uri()}{fragment}")
        self.wait(lambda: self.run("return document.documentElement.dataset.ready") == "yes")

    def run(self, script: str, *values: object) -> object:
        return self.driver.execute_script(script, *values)

    def wait(self, found: Callable[[], T]) -> T:
        return WebDriverWait(self.driver, PATIENCE, poll_frequency=0.05).until(lambda _: found())

    def text(self, selector: str) -> str:
        return self.run("return document.querySelector(arguments[0]).textContent", selector)

    def texts(self, selector: str) -> list[str]:
        return self.run("return [...document.querySelectorAll(arguments[0])].map(e => e.textContent)", selector)

    def click(self, selector: str) -> None:
        self.run("document.querySelector(arguments[0]).click()", selector)

    def press(self, *keys: str) -> None:
        ActionChains(self.driver).send_keys(*keys).perform()

    def log(self) -> list[str]:
        """What the console got since the last time."""
        return [f"{entry['level']} {entry['message']}" for entry in self.driver.get_log("browser")]

    def requests(self) -> list[str]:
        """Addresses that were asked for since the last time."""
        messages = (json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance"))
        return [message["params"]["request"]["url"] for message in messages if message["method"] == "Network.requestWillBeSent"]

    def is_quiet(self, page: Path) -> None:
        """Check that nothing was said, and that nothing but the page was asked for."""
        assert self.log() == []
        assert {url.partition("#")[0] for url in self.requests() if not url.startswith("data:")} == {page.as_uri()}

    def mouse(self, kind: str, x: float, y: float, pressed: bool = True, **more: object) -> None:
        """An event of the mouse, with its left button pressed or not."""
        self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {
            "type": kind, "x": x, "y": y, "button": "left" if pressed else "none", "buttons": int(pressed), "clickCount": 1}
            | more)

    def box_of(self, chart: int) -> list[float]:
        """Left, right, top and bottom of the curves of a chart in the window, to which the page scrolls."""
        return self.run("""const {canvas, box} = ldbench.charts[arguments[0]]; canvas.scrollIntoView({block: 'center'});
          const place = canvas.getBoundingClientRect();
          return [place.x + box.left, place.x + box.right, place.y + box.top, place.y + box.bottom]""", chart)


def facts(page: Path) -> dict:
    """The facts that a page holds beside the rows of its runs."""
    packed = re.search(r'id="facts">(.*?)</script>', page.read_text(encoding="utf-8"))[1]
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def go(browser: Browser, t: float) -> None:
    """Go to a time, by the address."""
    browser.run("location.hash = arguments[0]", f"t={float(t)!r}")
    browser.wait(lambda: abs(browser.run("return ldbench.t") - t) < 1e-8)


@contextmanager
def started(profile: Path) -> Iterator[Browser]:
    """A browser with an empty profile."""
    found = find_browser()
    if not found:
        pytest.skip("no chromium with chromedriver: ./bootstrap --browser")
    options = webdriver.ChromeOptions()
    options.binary_location = found[0]
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(found[1]))
    driver.set_page_load_timeout(PATIENCE)
    driver.set_script_timeout(PATIENCE)
    try:
        yield Browser(driver)
    finally:
        driver.quit()
