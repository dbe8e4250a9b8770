"""A real browser, and pages to open in it. Screenshots are kept under out/browser."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

REQUIRED = "DRAKE_LTL_BROWSER"
"""Set in the environment: without a browser tests fail instead of being skipped."""
SCREENSHOTS = Path(__file__).parents[2] / "out" / "browser"
ARGUMENTS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost, EXCLUDE 127.0.0.1",
)
DESKTOP, NARROW = (1280, 800), (400, 800)
SMALL = (800, 500)
"""Pages are drawn by the processor here: small ones keep up."""


class Browser:
    """Chromium, driven by Selenium."""

    def __init__(self, driver: Any):
        self.driver = driver

    def open(self, url: str, size: tuple[int, int] = SMALL) -> None:
        """A page; what earlier ones wrote is forgotten."""
        self.resize(size)
        for kind in ("browser", "performance"):
            self.driver.get_log(kind)
        self.driver.get(url)

    def resize(self, size: tuple[int, int]) -> None:
        width, height = size
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    def run(self, script: str, *arguments: Any) -> Any:
        """The value that the script returns."""
        return self.driver.execute_script(script, *arguments)

    def wait(self, script: str, seconds: float = 30.0) -> Any:
        """Until the script returns something that is true."""
        from selenium.webdriver.support.ui import WebDriverWait

        return WebDriverWait(self.driver, seconds, poll_frequency=0.05).until(lambda _: self.run(script))

    def press(self, element: str) -> None:
        """As a user does, with the mouse."""
        self.driver.find_element("id", element).click()

    def text(self, selector: str) -> str:
        return self.driver.find_element("css selector", selector).text

    def position(self, member: str) -> list[float] | None:
        """Where a page of Meshcat's shows a member, in W [m]; None until it does."""
        return self.run(POSITION, member)

    def errors(self) -> list[str]:
        """What the page complained of on its console."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]

    def requests(self) -> list[str]:
        """Addresses that the page asked the network for: not its own file, nor data in it."""
        sent = (json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance"))
        urls = [m["params"]["request"]["url"] for m in sent if m["method"] == "Network.requestWillBeSent"]
        return [url for url in urls if not url.startswith(("file:", "data:", "blob:"))]

    def shoot(self, name: str) -> Path:
        """A picture of the window."""
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        path = SCREENSHOTS / f"{name}.png"
        assert self.driver.save_screenshot(str(path))
        return path


POSITION = """
let node = window.viewer && viewer.scene_tree;
for (const name of ["mission", "members", arguments[0]]) node = node && node.children[name];
if (!node) return null;
viewer.scene.updateMatrixWorld(true);
const e = node.object.matrixWorld.elements;
return [e[12], -e[14], e[13]];
"""


@pytest.fixture(scope="session")
def browser(tmp_path_factory) -> Iterator[Browser]:
    driver = _driver(tmp_path_factory.mktemp("profile"))
    yield Browser(driver)
    driver.quit()


def _driver(profile: Path) -> Any:
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    chromedriver = shutil.which("chromedriver")
    if chromium is None or chromedriver is None:
        return _without("Chromium and chromedriver (Debian's `chromium` and `chromium-driver`)")
    try:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
    except ImportError:
        return _without("Selenium (`pip install selenium`)")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for argument in (*ARGUMENTS, f"--user-data-dir={profile}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service(chromedriver), options=options)


def _without(what: str) -> None:
    if os.environ.get(REQUIRED):
        pytest.fail(f"{REQUIRED} is set, but there is no browser: install {what}")
    pytest.skip(f"pages are tried in a browser only where there are {what}")


@pytest.fixture(scope="session")
def shuttle_run(browser, shuttle_text, tmp_path_factory) -> SimpleNamespace:
    """The quickest mission, carried out: recording, verdict, page and report."""
    from drake_ltl import mission
    from drake_ltl.scenario import loads
    from drake_ltl.verification import verify
    from drake_ltl.visualization.report import write_report

    folder = tmp_path_factory.mktemp("shuttle")
    scenario = loads(shuttle_text)
    models = mission.measure(scenario)
    planned = mission.plan_and_place(scenario, models)
    recording = mission.simulate(planned, scenario, models, page=folder / "page.html").recording
    files = write_report(
        folder / "report", recording, scenario, verify(recording, scenario), geometry=models.geometry, plan=planned.plan
    )
    return SimpleNamespace(recording=recording, page=folder / "page.html", report=files[0])


@pytest.fixture
def shot(browser) -> Callable[[str], None]:
    """shot("page"): pictures at a desktop's and at a telephone's width."""

    def take(name: str) -> None:
        for size in (DESKTOP, NARROW):
            browser.resize(size)
            browser.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            assert browser.shoot(f"{name}_{size[0]}").stat().st_size > 5_000  # not an empty page

    return take
