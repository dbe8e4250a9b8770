"""`drake-ltl sweep`: on missions of seconds, and with runs of milliseconds that are interrupted."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from drake_ltl.cli import sweep
from drake_ltl.execution.recording import Recording
from drake_ltl.scenario import load
from drake_ltl.sweep import figure, one_run
from drake_ltl.sweep.outcome import Outcome
from drake_ltl.sweep.sweep import Sweep

FAKES = Path(__file__).parent.parent / "sweep"
PATIENCE = 40.0
"""Only a command that hangs takes so long [s]."""


@pytest.fixture
def in_this_process(monkeypatch) -> None:
    """No processes are started, which takes seconds: a thread carries the runs out. No picture is drawn."""

    @contextmanager
    def executor(address, jobs):
        with ThreadPoolExecutor(1) as threads:
            yield threads

    monkeypatch.setattr(sweep, "_executor", executor)
    monkeypatch.setattr(figure, "write_summary_figure", lambda *args: None)


def lines_of(folder: Path) -> dict[int, dict]:
    """The journal's outcomes by run, without the one number that changes."""
    lines = (folder / "runs.jsonl").read_text(encoding="utf-8").splitlines()[1:]
    outcomes = [json.loads(line) for line in lines]
    return {one["run"]: {key: value for key, value in one.items() if key != "wall_seconds"} for one in outcomes}


def test_a_run_of_a_sweep_can_be_done_alone(drake_ltl, shuttle_file, tmp_path):
    """Once in a process of its own, once in this one: who carries it out does not matter."""
    folder = tmp_path / "results"
    options = ("--seed", "5", "--jobs", "1", "--output", folder)
    first = drake_ltl("sweep", shuttle_file, "--runs", "1", *options)
    assert (first.status, first.err) == (0, "")
    assert first.out.startswith("ALL SATISFIED  shuttle, 1 of 1 runs")
    (before,) = lines_of(folder).values()
    assert {path.name for path in folder.iterdir()} == {"runs.jsonl", "summary.json", "summary.png"}
    assert imread(folder / "summary.png").std() > 0.01

    alone = drake_ltl("sweep", shuttle_file, "--seed", "5", "--only", "0", "--output", tmp_path / "alone")
    assert (alone.status, alone.err) == (0, "")
    assert alone.out.startswith("SATISFIED  shuttle")
    recording = Recording.load(tmp_path / "alone" / "run_0.npz")
    assert [step.duration for step in recording.steps] == before["durations"]
    written = load(tmp_path / "alone" / "run_0.yaml")
    assert list(written.agents[0].position) == before["drawn"]["positions"]["a1"]
    assert written.controller.force == before["drawn"]["gains"]["force"]


def test_more_runs_and_other_sweeps(drake_ltl, shuttle_file, tmp_path, in_this_process, monkeypatch):
    begun = []

    def satisfied(settings, number):
        begun.append(number)
        return Outcome(number, "satisfied", simulated_seconds=1.0)

    monkeypatch.setattr(one_run, "run_one", satisfied)
    monkeypatch.setattr(sweep, "_prepare", lambda args, scenario, models: Sweep(scenario, None, None, args.seed))
    options = ("--seed", "5", "--output", tmp_path)
    for runs in (1, 3, 3, 2):
        result = drake_ltl("sweep", shuttle_file, "--runs", runs, *options)
        assert result.status == 0
        assert result.out.startswith(f"ALL SATISFIED  shuttle, {runs} of {runs} runs")
        assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["satisfied"]["count"] == runs
    assert begun == [0, 1, 2]
    before = (tmp_path / "runs.jsonl").read_bytes()
    refused = drake_ltl("sweep", shuttle_file, "--runs", "4", "--seed", "6", "--output", tmp_path)
    assert refused.status == 2
    (line,) = refused.err.splitlines()
    assert "holds a sweep of another seed; name another folder" in line
    assert (tmp_path / "runs.jsonl").read_bytes() == before
    assert begun == [0, 1, 2]


def test_a_run_that_stalls_is_told_and_written(drake_ltl, shuttle_file, tmp_path, in_this_process):
    text = shuttle_file.read_text(encoding="utf-8") + "simulation: {step_time_limit: 1.0}\n"
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl("sweep", shuttle_file, "--runs", "1", "--output", tmp_path / "out")
    assert result.status == 1
    assert result.out.startswith("NOT ALL  shuttle, 1 of 1 runs")
    assert "run 0, stalled: the run ended early: step 1 did not finish within 1 s: a1" in " ".join(result.out.split())
    (unsatisfied,) = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["unsatisfied"]
    assert unsatisfied["status"] == "stalled"
    written = (tmp_path / "out" / "run_0.yaml").read_text(encoding="utf-8")
    assert written.startswith("# run 0 of seed 0, stalled: the run ended early: step 1 did not finish")
    assert load(tmp_path / "out" / "run_0.yaml").simulation.step_time_limit == 1.0


def test_masses_are_unknown_to_the_controllers(case_ii, models, mission, program):
    """The plant's crate is heavier, with all of its inertia; what controllers know is not changed."""
    from drake_ltl.diagrams import MakeMissionDiagram

    from drake_ltl.sweep.one_run import scale_masses

    diagram = MakeMissionDiagram(mission, case_ii, models, num_steps=1)
    context = diagram.CreateStartContext()
    plant = diagram.transport_plant.plant
    plant_context = plant.GetMyContextFromRoot(context)

    def inertia(name: str) -> np.ndarray:
        (index,) = plant.GetBodyIndices(diagram.transport_plant.objects[name])
        return plant.get_body(index).CalcSpatialInertiaInBodyFrame(plant_context).CopyToFullMatrix6()

    before, known = {name: inertia(name) for name in ("o1", "o2")}, models.objects["o1"].mass
    scale_masses(diagram, context, {"o1": 1.25})
    np.testing.assert_allclose(inertia("o1"), 1.25 * before["o1"], rtol=1e-14)
    np.testing.assert_array_equal(inertia("o2"), before["o2"])
    assert diagram.models.objects["o1"].mass == known


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "write either `--runs N` or `--only K`"),
        (("--runs", "2", "--only", "1"), "write either"),
        (("--runs", "0"), "'0' is not a whole number from 1"),
        (("--runs", "1e3"), "'1e3' is not a whole number"),
        (("--runs", "9" * 5000), "is not a whole number"),
        (("--runs", "2", "--seed", "-1"), "--seed"),
        (("--runs", "2", "--jobs", "0"), "'0' is not a whole number from 1 to 256"),
        (("--runs", "2", "--jobs", "2", "--dask", "tcp://localhost:1"), "not allowed with"),
        (("--runs", "2", "--gains", "91"), "not a number of per cent from 0 to 90"),
        (("--runs", "2", "--masses", "nan"), "not a number of per cent from 0 to 90"),
        (("--runs", "2", "--output", ""), "the name is empty"),
    ],
)
def test_what_cannot_be_asked_for(drake_ltl, shuttle_file, tmp_path, options, words):
    result = drake_ltl("sweep", shuttle_file, *options)
    assert result.status == 2
    assert words in result.err
    assert [path.name for path in tmp_path.iterdir()] == [shuttle_file.name]


def test_bad_scenarios_and_folders(drake_ltl, shuttle_file, tmp_path):
    result = drake_ltl("sweep", tmp_path / "nothing.yaml", "--runs", "1", "--output", tmp_path / "out")
    assert (result.status, len(result.err.splitlines())) == (2, 1)
    result = drake_ltl("sweep", shuttle_file, "--runs", "1", "--output", shuttle_file)
    assert (result.status, len(result.err.splitlines())) == (2, 1)
    text = shuttle_file.read_text(encoding="utf-8").replace("GF near", "G !near")
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl("sweep", shuttle_file, "--runs", "1", "--output", tmp_path / "out")
    assert result.status == 1
    assert result.err.startswith("no plan: ")
    assert [path.name for path in tmp_path.iterdir()] == [shuttle_file.name]


PRELUDE = """
import sys, types
sys.path.insert(0, sys.argv.pop(1))
import fakes
import drake_ltl.cli as cli
from drake_ltl.cli import sweep

sys.modules["drake_ltl.sweep.one_run"] = types.SimpleNamespace(run_one=fakes.carried_out)
sys.modules["drake_ltl.sweep.figure"] = types.SimpleNamespace(write_summary_figure=lambda *args: None)
sweep._prepare = lambda args, scenario, models: fakes.Sweep(scenario.name, scenario.source, args.seed)
sys.argv[0] = "drake-ltl"
cli.entry_point()
"""


@pytest.fixture
def begin(shuttle_file, tmp_path) -> Iterator[Callable[[], subprocess.Popen]]:
    """begin(): a sweep of 5 runs in 2 processes; nothing of it is left when the test ends, however that ends."""
    command = [sys.executable, "-c", PRELUDE, str(FAKES), "sweep", str(shuttle_file), "--runs", "5", "--jobs", "2"]
    begun = []

    def start() -> subprocess.Popen:
        begun.append(
            subprocess.Popen(
                [*command, "--output", str(tmp_path / "out")],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
                env=os.environ | {"SWEEP_FOLDER": str(tmp_path)},
            )
        )
        return begun[-1]

    yield start
    for process in begun:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def wait_until(condition) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def calls(folder: Path) -> list[tuple[int, int]]:
    """Runs that were begun, with their processes."""
    file = folder / "calls"
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    return [(int(number), int(process)) for number, process in map(str.split, lines)]


def is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


def workers_are_gone(folder: Path) -> None:
    for _, process in calls(folder):
        wait_until(lambda process=process: is_gone(process))


def begun(folder: Path) -> list[int]:
    """How often each of the 5 runs was begun."""
    runs = [run for run, _ in calls(folder)]
    return [runs.count(run) for run in range(5)]


def test_a_sweep_that_is_killed_and_interrupted_goes_on(begin, tmp_path):
    """Runs 2 and 3 wait until they are let go: whenever they are seen, 0 and 1 are done."""
    command = begin()
    wait_until(lambda: begun(tmp_path) == [1, 1, 1, 1, 0])
    wait_until(lambda: set(lines_of(tmp_path / "out")) == {0, 1})
    os.kill(command.pid, signal.SIGKILL)
    workers_are_gone(tmp_path)
    command.communicate()

    command = begin()
    wait_until(lambda: begun(tmp_path) == [1, 1, 2, 2, 0])
    os.killpg(command.pid, signal.SIGINT)
    out, err = command.communicate(timeout=PATIENCE)
    assert (command.returncode, err) == (130, "interrupted; the same command goes on from here\n")
    assert out.startswith("UNFINISHED  shuttle, 2 of 5 runs")
    workers_are_gone(tmp_path)

    command = begin()
    wait_until(lambda: begun(tmp_path) == [1, 1, 3, 3, 0])
    os.kill(dict(calls(tmp_path))[2], signal.SIGKILL)  # one of the two processes
    wait_until(lambda: begun(tmp_path) == [1, 1, 3, 3, 1])  # its place is taken
    (tmp_path / "go").touch()
    out, err = command.communicate(timeout=PATIENCE)
    assert (command.returncode, err) == (0, "")
    assert out.startswith("ALL SATISFIED  shuttle, 5 of 5 runs")
    assert begun(tmp_path) == [1, 1, 4, 3, 1]
    assert set(lines_of(tmp_path / "out")) == set(range(5))
