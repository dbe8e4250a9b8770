"""What people and programs get to read."""

from __future__ import annotations

import argparse
import dataclasses
import io
import json
import subprocess
import sys

import numpy as np
import pytest
from rich.console import Console

from drake_ltl.cli import verify as command
from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import NOTHING
from drake_ltl.verification import to_json, verdict_table, verify


@pytest.fixture
def broken(recording):
    """Two welds that open."""
    recording.grasp[120:130, 1] = NOTHING
    recording.grasp[370:380, 0] = NOTHING
    return recording


def printed(renderable, width: int) -> str:
    console = Console(width=width, file=io.StringIO())
    console.print(renderable)
    return console.file.getvalue()


def rendered(recording, scenario, width: int = 80) -> str:
    return printed(verdict_table(verify(recording), scenario), width)


def test_whose_potential_was_judged(recording, scenario):
    assert "V of version" not in rendered(recording, scenario)
    older = dataclasses.replace(recording, lacks=("gathering", "lift"))
    assert "rise of V of version 4" in rendered(older, scenario, 120)


def test_json_is_the_contract(recording):
    written = to_json(verify(recording), wall_seconds=3.0)
    assert list(written) == [
        "satisfied",
        "violations",
        "word",
        "steps",
        "min_clearance",
        "max_lyapunov_increase",
        "max_weld_error",
        "simulated_seconds",
        "wall_seconds",
        "realtime_factor",
    ]
    assert written["satisfied"] is True
    assert written["violations"] == []
    assert list(written["min_clearance"]) == ["agent_agent", "agent_object", "team_other", "forbidden_region"]
    assert written["steps"][2]["actions"] == [
        {"kind": "transport", "agents": ["a1", "a2"], "object": "o1", "from": "pi2", "to": "pi1"}
    ]
    assert written["word"][0] == ["a1.pi1", "a2.pi3", "a3.pi4", "o1.pi2", "o2.pi4"]
    assert written["realtime_factor"] == pytest.approx(3.0)
    assert json.loads(json.dumps(written, allow_nan=False)) == written


def test_json_knows_no_infinity(recording):
    recording.lyapunov[60:70] = 1.0  # from nothing, in a step in which V was zero
    written = to_json(verify(recording))
    assert written["max_lyapunov_increase"] is None
    assert written["wall_seconds"] is written["realtime_factor"] is None
    json.dumps(written, allow_nan=False)


def test_json_of_no_samples(recording):
    recording.time[0] = np.nan
    written = to_json(verify(recording))
    assert written["satisfied"] is False
    assert set(written["min_clearance"].values()) == {None}


def test_table_fits_80_columns(recording, scenario):
    text = rendered(recording, scenario)
    assert text.startswith("SATISFIED  drawn")
    assert max(map(len, text.splitlines())) <= 80
    assert "{a1, a2} carry o1: pi2 → pi1" in text
    assert "a2.dock" in text


def test_table_says_what_is_demanded_of_welds(recording, scenario):
    rows = {
        line.split("  ")[1].strip(): line.split() for line in rendered(recording, scenario).splitlines() if "  " in line
    }
    assert rows["gap of a weld"][-3:] == ["<=", "3", "mm"]
    assert rows["turn of a weld"][-3:] == ["<=", "0.5", "degrees"]
    lax = dataclasses.replace(scenario, tolerances=dataclasses.replace(scenario.tolerances, weld_position=0.02))
    assert "<= 0.02 m" in printed(verdict_table(verify(recording), lax), 80)


def test_table_says_nothing_of_welds_where_nothing_is_grasped(recording, scenario):
    verdict = verify(recording)
    travels = tuple(step for step in verdict.steps if all(action["kind"] == "travel" for action in step.actions))
    text = printed(verdict_table(dataclasses.replace(verdict, steps=travels), scenario), 80)
    assert travels
    assert "weld" not in text


def test_table_calls_a_step_without_actions_waiting(recording, scenario):
    verdict = verify(recording)
    idle = dataclasses.replace(verdict.steps[0], actions=())
    text = printed(verdict_table(dataclasses.replace(verdict, steps=(idle,)), scenario), 80)
    assert any(line.split()[:3] == ["1", "all", "wait"] for line in text.splitlines())


def test_table_names_every_violation_on_a_line_of_its_own(broken, scenario):
    lines = rendered(broken, scenario, 120).splitlines()
    assert lines[0].startswith("VIOLATED")
    assert [line.strip() for line in lines[1:3]] == [str(v) for v in verify(broken).violations]


def _run(*arguments: str) -> int:
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers())
    args = parser.parse_args(["verify", *arguments])
    return args.run(args)


def test_command_satisfied(recording, tmp_path, capsys):
    recording.save(tmp_path / "run.npz")
    assert _run(str(tmp_path / "run.npz"), "--json", str(tmp_path / "verdict.json")) == 0
    assert "SATISFIED" in capsys.readouterr().out
    assert json.loads((tmp_path / "verdict.json").read_text())["satisfied"] is True


def test_command_violated(broken, tmp_path, capsys):
    broken.save(tmp_path / "run.npz")
    assert _run(str(tmp_path / "run.npz")) == 1
    assert "a2 is welded to nothing instead of o1" in " ".join(capsys.readouterr().out.split())


def test_command_with_another_file(tmp_path):
    (tmp_path / "run.npz").write_text("nothing of the kind")
    with pytest.raises(InvalidInputError, match="is not a recording"):
        _run(str(tmp_path / "run.npz"))


def test_names_are_not_markup(recording, scenario):
    assert "[red]" in printed(verdict_table(verify(recording), dataclasses.replace(scenario, name="[red]")), 80)


def test_judges_without_what_it_judges():
    """Neither controllers nor runner are loaded by a verdict, and Drake only for the models."""
    program = (
        "import sys, drake_ltl.verification\n"
        "print(*[m for m in sys.modules if m.startswith('pydrake')])\n"
        "import drake_ltl.verification.models\n"
        "parts = ('systems', 'diagrams', 'navigation', 'execution.runner', "
        "'execution.log_reader', 'dynamics')\n"
        "print(*[m for m in sys.modules if m.startswith(tuple('drake_ltl.' + p for p in parts))])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
