"""The report, opened from a file."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.mission

LOADED = (
    "return [...document.images].every((image) => image.complete && image.naturalWidth > 0) && document.images.length"
)


@pytest.fixture(scope="module")
def page(browser, shuttle_run):
    browser.open(shuttle_run.report.as_uri(), (1280, 800))
    return browser


def test_every_picture_is_there(page):
    page.run("for (const part of document.querySelectorAll('details')) part.open = true")
    assert page.wait(LOADED) >= 8  # map, Gantt chart, two steps and their sheet, clearances, V, torques, automaton


@pytest.mark.parametrize("width", [1280, 400])
def test_the_page_is_as_wide_as_the_window(page, width):
    page.resize((width, 800))
    assert page.run("return document.documentElement.scrollWidth") <= width


def test_its_sections_can_be_reached(page):
    page.resize((1280, 800))
    anchors = page.run("return [...document.querySelectorAll('nav a')].map((a) => a.getAttribute('href').slice(1))")
    assert {"verdict", "scenario", "plan", "steps", "clearances", "automata", "versions"} <= set(anchors)
    assert page.run("return arguments[0].every((name) => document.getElementById(name))", anchors)
    assert page.text(".badge") == "satisfied"


def test_pictures_are_kept(page, shot):
    page.run("window.scrollTo(0, 0)")
    shot("report")


def test_nothing_is_asked_of_the_network_and_nothing_failed(page):
    assert page.requests() == []
    assert page.errors() == []
