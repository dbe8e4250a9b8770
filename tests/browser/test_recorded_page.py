"""The page of `--record`, opened from a file."""

from __future__ import annotations

import numpy as np
import pytest

pytestmark = pytest.mark.mission

INTERPOLATED = 0.02
"""Pages show a sixteenth of a second in a straight line; a1 turns and brakes by less than this [m] in that time."""


@pytest.fixture(scope="module")
def page(browser, shuttle_run):
    browser.open(shuttle_run.page.as_uri())
    browser.wait("return window.viewer && viewer.animator.duration > 0 && document.querySelector('#steps button.now')")
    return browser


def recorded(recording, time: float) -> np.ndarray:
    centre = recording.centre["a1"]
    return np.array([np.interp(time, recording.time, centre[:, axis]) for axis in range(3)])


def test_steps_are_sought_where_they_were_recorded(page, shuttle_run):
    for number, step in enumerate(shuttle_run.recording.steps):
        page.run("document.querySelectorAll('#steps button')[arguments[0]].click()", number)
        page.wait(f"return document.querySelectorAll('#plan li')[{number}].classList.contains('now')")
        assert page.text(".clock") == f"{step.start:.1f} s"
        assert page.position("a1") == pytest.approx(recorded(shuttle_run.recording, step.start), abs=INTERPOLATED)
        assert f"Step {number + 1} of 2" in page.text(".heading")


SCRUB = "const s = document.getElementById('scrubber'); s.value = arguments[0]; s.oninput({ target: s })"


def test_any_time_can_be_sought(page, shuttle_run):
    for time in (1.3, 3.1, 6.0):
        page.run(SCRUB, time)
        shown = page.run("return viewer.animator.time")
        assert shown == pytest.approx(time, abs=0.01)  # the scrubber's step
        assert page.position("a1") == pytest.approx(recorded(shuttle_run.recording, shown), abs=INTERPOLATED)


def test_a_single_step_ends_where_the_next_begins(page, shuttle_run):
    page.run("document.querySelectorAll('#steps button')[0].click()")
    for _ in range(4):
        page.press("faster")
    page.wait("return document.getElementById('rate').textContent === '×16'")
    page.press("step")
    page.wait("return !viewer.animator.playing")
    assert page.run("return viewer.animator.time") == pytest.approx(shuttle_run.recording.steps[1].start, abs=1e-3)
    for _ in range(4):
        page.press("slower")
    page.wait("return document.getElementById('rate').textContent === '×1'")


def test_it_plays_and_pauses(page):
    page.run(SCRUB, 1.0)  # a1 is on its way by then
    first = page.position("a1")
    for _ in range(2):
        page.press("slower")  # however slow the browser is, the end is far
    page.press("pause")
    page.wait("return viewer.animator.time > 1.2")
    page.press("pause")
    for _ in range(2):
        page.press("faster")
    time, here = page.run("return viewer.animator.time"), page.position("a1")
    assert np.linalg.norm(np.subtract(here, first)) > 0.01
    page.run("return new Promise((done) => setTimeout(done, 300))")
    assert page.run("return viewer.animator.time") == time
    assert page.position("a1") == here


def test_it_says_what_is_done_and_owed(page):
    page.run("document.querySelectorAll('#steps button')[0].click()")
    page.wait("return document.querySelector('#goals .owed') && document.querySelector('#goals .met')")
    page.run("document.getElementById('goals').open = document.getElementById('members').open = true")
    assert "GF far" in page.text("#goals")
    assert "still: F far" in page.text("#goals")
    assert "travels to far" in page.text("#members")


def test_cameras_follow_and_look_down(page):
    choose = "const c = document.getElementById('camera'); c.value = arguments[0]; c.onchange();"
    page.run(choose, "follow a1")
    page.wait("return viewer.controls.target.distanceTo(viewer.camera.position) < 8")
    target = page.run("return viewer.controls.target.toArray()")
    x, y, z = page.position("a1")
    assert target == pytest.approx([x, z, -y], abs=1e-6)  # Meshcat's own axes have y up
    page.run(choose, "top")
    away = page.run("return viewer.camera.position.clone().sub(viewer.controls.target).normalize().toArray()")
    assert away == pytest.approx([0.0, 1.0, 0.0], abs=1e-3)
    page.run(choose, "overview")


def test_pictures_are_kept(page, shot):
    page.run("document.querySelectorAll('#steps button')[1].click()")
    shot("recorded_page")


def test_nothing_is_asked_of_the_network_and_nothing_failed(page):
    assert page.requests() == []
    assert page.errors() == []
