"""`drake-ltl view`, and what it shows."""

from __future__ import annotations

import dataclasses
import shutil
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from drake_ltl.execution.recording import Recording

SCRIPT = shutil.which("drake-ltl", path=str(Path(sys.executable).parent))


@pytest.fixture(scope="module")
def scene(case_ii, models, mission, tmp_path_factory):
    """Case ii's start and a second in which all robots turn their first arm joint, as a recording and as a file."""
    return make_recording(case_ii, models, mission, tmp_path_factory.mktemp("view") / "scene.npz")


def make_recording(scenario, models, mission, path: Path) -> tuple[Recording, Path]:
    from drake_ltl.systems.program import start_configuration

    time = np.linspace(0.0, 1.0, 201)
    start = mission.steps[0].before
    q, centre = {}, {}
    for name, model in models.agents.items():
        q[name] = np.tile(start_configuration(start.agents[name], name, models), (len(time), 1))
        q[name][:, 0] += 0.5 * time
        centre[name] = np.array([model.centre(row) for row in q[name]])
    upright = [1.0, 0.0, 0.0, 0.0]
    pose = {name: np.tile([*upright, *p_WO], (len(time), 1)) for name, p_WO in start.objects.items()}
    n = len(models.agents)
    mode = np.zeros((len(time), n), dtype=int)
    mode[100:, 1:] = 3  # from 0.5 s on all but the first carry the first object
    recording = Recording(
        scenario=scenario.source,
        versions={},
        agents=scenario.agent_names,
        objects=scenario.object_names,
        agent_radius=models.geometry.agent_radius,
        object_radius=models.geometry.object_radius,
        team_radius=models.geometry.team_radius,
        prefix_length=0,
        suffix_length=0,
        steps=(),
        completed=False,
        reason="made up",
        intervals=(),
        time=time,
        q=q,
        qd={name: np.zeros_like(rows) for name, rows in q.items()},
        centre=centre,
        pose=pose,
        velocity={name: np.zeros((len(time), 6)) for name in pose},
        step=np.zeros(len(time), dtype=int),
        phase=np.zeros(len(time), dtype=int),
        mode=mode,
        grasp=np.full((len(time), n), -1),
        lyapunov=np.zeros(len(time)),
        effort=np.zeros((len(time), n)),
        manipulability=np.ones((len(time), n)),
    )
    recording.save(path)
    return recording, path


def test_bodies_end_where_they_were_recorded(scene, case_ii, models):
    """Without an animation what is published last is what a browser would be sent."""
    from drake_ltl.visualization.meshcat_scene import MakeMeshcat
    from drake_ltl.visualization.mission_overlay import member_path, team_path
    from drake_ltl.visualization.replay import PublishReplay

    recording, _ = scene
    meshcat = MakeMeshcat()
    shares = []
    PublishReplay(recording, case_ii, models, meshcat, report=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    for name, points in {**recording.centre, **recording.object_origin}.items():
        assert packed_translation(meshcat, member_path(name)) == pytest.approx(points[-1], abs=1e-6)
    shown = {name: packed_visibility(meshcat, team_path(name)) for name in recording.objects}
    assert shown == {"o1": True, "o2": False}


def packed_translation(meshcat, path: str) -> list[float]:
    """Meshcat's message ends with 16 numbers, column by column, each as a float64 with one byte before it."""
    numbers = np.frombuffer(
        meshcat._GetPackedTransform(path)[-144:], dtype=np.dtype([("kind", "u1"), ("value", ">f8")])
    )
    return numbers["value"][12:15].tolist()


def packed_visibility(meshcat, path: str) -> bool:
    """The last byte of the message: MessagePack's true or false."""
    return {0xC3: True, 0xC2: False}[meshcat._GetPackedProperty(path, "visible")[-1]]


def test_frames_cover_the_whole_run():
    from drake_ltl.visualization.mission_overlay import PUBLISH_PERIOD
    from drake_ltl.visualization.replay import frame_times, row_at

    time = 0.005 * np.arange(301)
    frames = frame_times(time)
    assert (frames[0], frames[-1]) == (time[0], time[-1])
    assert np.all(np.diff(frames) > 0)
    assert np.diff(frames).max() <= PUBLISH_PERIOD + 1e-12
    assert [row_at(time, t) for t in (-1.0, 0.0, 0.0049, 0.005, 1.5, 9.0)] == [0, 0, 0, 1, 300, 300]


def test_a_page_is_written(drake_ltl, scene, tmp_path):
    result = drake_ltl("view", scene[1], "--record", tmp_path / "page.html")
    assert (result.status, result.err) == (0, "")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "case_ii" in page
    assert "pi1" in page
    assert "MeshCat" in page


def test_who_writes_files_shows_nothing(drake_ltl, scene, tmp_path):
    result = drake_ltl("view", scene[1], "--report", tmp_path / "report", "--meshcat-host", "localhost")
    assert result.status == 2
    assert result.err.startswith("--meshcat-host: has nothing to show;")
    assert not (tmp_path / "report").exists()


def test_what_is_no_recording(drake_ltl, tmp_path, examples):
    for path in (tmp_path / "none.npz", examples / "case_ii.yaml"):
        result = drake_ltl("view", path)
        assert (result.status, result.out) == (2, "")
        assert len(result.err.splitlines()) == 1
        assert str(path) in result.err


def test_a_run_without_samples(drake_ltl, scene, tmp_path):
    """Nothing that is finite was recorded."""
    recording, _ = scene
    lost = {name: np.full_like(q, np.nan) for name, q in recording.q.items()}
    dataclasses.replace(recording, q=lost).save(tmp_path / "lost.npz")
    result = drake_ltl("view", tmp_path / "lost.npz")
    assert result.status == 2
    assert "before its first sample" in result.err


def test_it_is_shown_until_ctrl_c(scene):
    command = [SCRIPT, "view", scene[1], "--meshcat-host", "127.0.0.1"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        line = process.stderr.readline()
        address = next(word for word in line.split() if word.startswith("http://127.0.0.1:"))
        with urllib.request.urlopen(address, timeout=30) as answer:
            assert b"meshcat" in answer.read().lower()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 0
