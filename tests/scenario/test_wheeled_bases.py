"""Bases that cannot move sideways are no agents of scenarios: one line says so, whatever is asked of the file."""

from __future__ import annotations

import pytest

from drake_ltl.cli import main
from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import loads

BASE = "package://drake_ltl_models/bases/differential_drive.urdf"


@pytest.fixture
def text(shuttle_text) -> str:
    return shuttle_text.replace("package://drake_ltl_models/agents/planar_arm.urdf", BASE)


def test_one_line_says_what_an_agent_is(text):
    with pytest.raises(InvalidInputError) as caught:
        loads(text)
    (mistake,) = caught.value.mistakes
    assert mistake.where == "agents.a1.model"
    assert "(left, right)" in mistake.what
    assert "prismatic x and y of its base" in mistake.remedy


@pytest.mark.parametrize("command", ["check", "plan", "draw", "explain", "simulate"])
def test_every_command_says_so(text, tmp_path, capsys, command):
    path = tmp_path / "shuttle.yaml"
    path.write_text(text)
    assert main([command, str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("agents.a1.model: ")
    assert err.count("\n") == 1
