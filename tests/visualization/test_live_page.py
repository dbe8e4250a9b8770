"""What lets people watch a run and hold it up: buttons, status and the page's server."""

from __future__ import annotations

import json
import urllib.error
import urllib.request

import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from pydrake.systems.analysis import Simulator

from drake_ltl.errors import ExecutionError
from drake_ltl.visualization import live_control
from drake_ltl.visualization.live_control import FASTER, PAUSE, SLOWER, STEP, LiveControl
from drake_ltl.visualization.live_page import ServeLivePage, live_page
from drake_ltl.visualization.meshcat_scene import MakeMeshcat
from drake_ltl.visualization.page_data import live_page_data
from drake_ltl.visualization.page_server import PageServer


@pytest.fixture(scope="module")
def diagram(case_ii, models, mission):
    return MakeMissionDiagram(mission, case_ii, models, num_steps=len(mission.steps))


@pytest.fixture
def meshcat():
    return MakeMeshcat()


@pytest.fixture
def simulator(diagram):
    simulator = Simulator(diagram.diagram, diagram.CreateStartContext())
    simulator.Initialize()
    return simulator


@pytest.fixture
def control(meshcat, diagram, case_ii, mission) -> LiveControl:
    return LiveControl(meshcat, diagram, case_ii, len(mission.steps))


def press(meshcat, name: str) -> None:
    """As a browser says it, in MessagePack."""

    def text(string: str) -> bytes:
        return bytes([0xA0 + len(string)]) + string.encode()

    meshcat._InjectWebsocketMessage(message=b"\x82" + text("type") + text("button") + text("name") + text(name))


def test_the_status_says_all_that_a_page_shows(control, simulator, case_ii):
    control.hold(simulator)
    status = control.answer("0.0")
    assert (status["index"], status["paused"]) == (0, False)
    assert status["heading"].startswith("Step 1 of ")
    assert [name for name, _ in status["activities"]] == [*case_ii.agent_names, *case_ii.object_names]
    assert ["owed", "F pi1"] in [list(goal) for goal in status["goals"]]
    json.dumps(status)


def test_slower_and_faster(control, simulator, meshcat):
    control.hold(simulator)
    assert simulator.get_target_realtime_rate() == 1.0
    for name, rate in ((SLOWER, 0.5), (SLOWER, 0.25), (FASTER, 0.5)):
        press(meshcat, name)
        control.hold(simulator)
        assert simulator.get_target_realtime_rate() == rate
    for _ in range(9):
        press(meshcat, FASTER)
    control.hold(simulator)
    assert simulator.get_target_realtime_rate() == 0.0  # as fast as the computer can
    assert control.status["rate"].startswith("max")


def test_a_paused_run_waits(control, simulator, meshcat, monkeypatch):
    waits = []

    def sleep(_: float) -> None:
        waits.append(dict(control.status))
        if len(waits) == 3:
            press(meshcat, PAUSE)

    monkeypatch.setattr(live_control.time, "sleep", sleep)
    press(meshcat, PAUSE)
    control.hold(simulator)
    assert len(waits) == 3
    assert all(status["paused"] for status in waits)
    assert not control.status["paused"]


def test_a_single_step_ends_with_the_step(control, simulator, meshcat, diagram, monkeypatch):
    press(meshcat, STEP)
    control.hold(simulator)
    assert not control.status["paused"]
    supervisor = diagram.supervisor
    context = supervisor.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    progress = supervisor.GetProgress(context)
    supervisor.SetProgress(context, progress.__class__(**{**vars(progress), "count": progress.count + 1}))
    waits = []

    def sleep(_: float) -> None:
        waits.append(control.status["heading"])
        press(meshcat, PAUSE)

    monkeypatch.setattr(live_control.time, "sleep", sleep)
    control.hold(simulator)
    assert [heading.partition(" of ")[0] for heading in waits] == ["Step 2"]


def test_a_page_that_falls_behind_is_waited_for(control, simulator, monkeypatch):
    simulator.AdvanceTo(1.0)
    seen = iter(("0.2", "0.4", "0.6"))
    answered = []

    def sleep(_: float) -> None:
        answered.append(control.answer(next(seen)))

    monkeypatch.setattr(live_control.time, "sleep", sleep)
    control.answer("0.0")
    control.hold(simulator)
    assert len(answered) == 3  # then it was less than half a second behind


def test_the_last_word(control, simulator):
    control.hold(simulator)
    control.finish(simulator, "a step did not finish")
    assert (control.status["heading"], control.status["lines"]) == ("Stopped", ["a step did not finish"])


def test_the_page_asks_meshcat_for_the_scene(meshcat, mission, case_ii):
    server = ServeLivePage(meshcat, live_page_data(mission, case_ii), lambda seen: {"seen": seen})
    try:
        page = read(server.url).decode()
        assert f'url = "{meshcat.web_url()}/";' in page
        assert "<title>case_ii</title>" in page
        assert json.loads(read(f"{server.url}status?1.5")) == {"seen": "1.5"}
        script = page.partition('src="')[2].partition('"')[0]
        assert b"THREE" in read(server.url + script)  # Meshcat's own files come from behind
    finally:
        server.close()


def test_other_pages_are_refused(mission, case_ii):
    with pytest.raises(ExecutionError, match="Meshcat's page"):
        live_page("<html><body></body></html>", "http://localhost:1", live_page_data(mission, case_ii))


def test_what_is_not_there():
    server = PageServer({"/": lambda _: "<p>page</p>"})
    try:
        assert read(server.url) == b"<p>page</p>"
        with pytest.raises(urllib.error.HTTPError) as error:
            urllib.request.urlopen(f"{server.url}nothing", timeout=30)
        assert error.value.code == 404
        error.value.close()
    finally:
        server.close()


def read(url: str) -> bytes:
    with urllib.request.urlopen(url, timeout=30) as answer:
        return answer.read()
