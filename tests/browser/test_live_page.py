"""The page of `simulate --meshcat`, while the run goes on."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.mission

SCRIPT = shutil.which("drake-ltl", path=str(Path(sys.executable).parent))
SLOWLY = "0.25"
"""Simulated seconds in one of the wall's clock: the mission is still in its first step when the page has loaded."""
WAIT = "return new Promise((done) => setTimeout(done, arguments[0]))"


@pytest.fixture(scope="module")
def page(browser, shuttle_text, tmp_path_factory):
    folder = tmp_path_factory.mktemp("live")
    file = folder / "shuttle.yaml"
    file.write_text(shuttle_text, encoding="utf-8")
    command = [SCRIPT, "simulate", file, "--meshcat", "--realtime-rate", SLOWLY]
    with (
        open(folder / "out.txt", "w", encoding="utf-8") as out,
        subprocess.Popen(command, stdout=out, stderr=subprocess.PIPE, text=True) as process,
    ):
        address = re.search(r"http://localhost:\d+/", process.stderr.readline()).group(0)
        browser.open(address)
        browser.wait("return document.querySelector('#steps button.now')")
        yield browser
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 130


def moved(page, milliseconds: int) -> float:
    """How far a1 goes within that time [m]."""
    before = page.position("a1")
    page.run(WAIT, milliseconds)
    return float(np.linalg.norm(np.subtract(page.position("a1"), before)))


def paused(page, yes: bool) -> None:
    """Waits until it is so, and until what was sent before has arrived."""
    page.wait(f"return document.getElementById('pause').textContent === '{'Go on' if yes else 'Pause'}'")
    page.run(WAIT, 300)


def test_pause_and_step(page, shot):
    page.wait("return document.querySelector('.heading').textContent.startsWith('Step 1')")
    assert "travels to far" in page.run("return document.getElementById('members').textContent")
    assert "GF far" in page.run("return document.getElementById('goals').textContent")
    while page.position("a1") is None or moved(page, 400) < 1e-3:
        pass  # it sets out slowly
    page.press("pause")
    paused(page, True)
    while moved(page, 300):
        pass  # the scene is a moment behind the run
    assert moved(page, 400) == 0.0
    shot("live_page")
    page.resize((800, 500))

    page.press("pause")
    paused(page, False)
    assert moved(page, 600) > 1e-3
    page.press("pause")
    paused(page, True)

    for _ in range(5):
        page.press("faster")
    page.press("step")
    page.wait("return document.querySelector('.heading').textContent.startsWith('Step 2')")
    paused(page, True)
    while moved(page, 300):
        pass  # the scene is a moment behind the run
    assert page.text(".heading").startswith("Step 2 of 2")
    assert page.position("a1")[0] > 1.0  # in the region `far`, whose centre is at 2.7
    assert moved(page, 400) == 0.0
    assert page.errors() == []
