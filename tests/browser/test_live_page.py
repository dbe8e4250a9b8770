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
SLOWLY = "0.05"
"""Simulated seconds in one of the wall's clock: the first step goes on for more than a minute."""
MOST_LOOKS = 100
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
        found = filter(None, (re.search(r"http://localhost:\d+/", line) for line in process.stderr))
        browser.open(next(found).group(0))
        browser.wait("return document.querySelector('#steps button.now')")
        yield browser
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 130


def moved(page, milliseconds: int) -> float:
    """How far a1 goes within that time [m]."""
    before = page.position("a1")
    page.run(WAIT, milliseconds)
    return float(np.linalg.norm(np.subtract(page.position("a1"), before)))


def wait_until(page, *, moves: bool) -> None:
    """Until a1 moves, or stands: the scene is a moment behind the run, and a1 sets out slowly."""
    for _ in range(MOST_LOOKS):
        if (moved(page, 300) > 0.0) == moves:
            return
    raise AssertionError(f"a1 {'stands' if moves else 'moves'} all the time")


def wait_until_paused(page, *, yes: bool) -> None:
    page.wait(f"return document.getElementById('pause').textContent === '{'Go on' if yes else 'Pause'}'")


def test_pause_and_step(page, shot):
    page.wait("return document.querySelector('.heading').textContent.startsWith('Step 1')")
    page.wait("return !!viewer.scene_tree.children.mission?.children.members?.children.a1")
    assert "travels to far" in page.run("return document.getElementById('members').textContent")
    assert "GF far" in page.run("return document.getElementById('goals').textContent")
    wait_until(page, moves=True)
    page.press("pause")
    wait_until_paused(page, yes=True)
    wait_until(page, moves=False)
    assert moved(page, 400) == 0.0
    shot("live_page")
    page.resize((800, 500))

    page.press("pause")
    wait_until_paused(page, yes=False)
    wait_until(page, moves=True)
    page.press("pause")
    wait_until_paused(page, yes=True)
    assert page.text(".heading").startswith("Step 1 of 2")

    for _ in range(8):
        page.press("faster")
    page.wait("return document.getElementById('rate').textContent === 'max'")
    page.press("step")
    page.wait("return document.querySelector('.heading').textContent.startsWith('Step 2')")
    wait_until_paused(page, yes=True)
    wait_until(page, moves=False)
    assert page.text(".heading").startswith("Step 2 of 2")
    assert page.position("a1")[0] > 1.0  # in the region `far`, whose centre is at 2.7
    assert moved(page, 400) == 0.0
    assert page.errors() == []
