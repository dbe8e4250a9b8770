"""`drake-ltl completion`."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from drake_ltl.cli import make_parser
from drake_ltl.cli.completion_scripts import script

COMMANDS = {"new", "check", "draw", "explain", "plan", "simulate", "sweep", "verify", "view", "completion"}


@pytest.fixture
def complete(tmp_path, drake_ltl):
    """complete("drake-ltl", "pl"): what bash offers for the last word, in a folder with some files."""
    for name in ("cart.yaml", "cart.yml", "run.npz", "notes.txt", "two words.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "folder").mkdir()
    file = tmp_path / "completion"
    file.write_text(drake_ltl("completion", "bash").out, encoding="utf-8")

    def run(*words: str) -> set[str]:
        code = """
            source "$1"; shift
            COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
            _drake_ltl
            (( ${#COMPREPLY[@]} == 0 )) || printf '%s\\n' "${COMPREPLY[@]}"
        """
        command = ["bash", "--norc", "-eu", "-c", code, "bash", str(file), *words]
        result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, cwd=tmp_path)
        assert (result.returncode, result.stderr) == (0, "")
        return set(result.stdout.splitlines())

    return run


def test_commands(complete):
    assert complete("drake-ltl", "") == COMMANDS
    assert complete("drake-ltl", "pl") == {"plan"}
    assert complete("drake-ltl", "--no-color", "ver") == {"verify"}


def test_options(complete):
    assert complete("drake-ltl", "plan", "--m") == {"--method"}
    assert {"--meshcat", "--record", "--no-color"} <= complete("drake-ltl", "simulate", "-")
    assert "--version" in complete("drake-ltl", "-")


def test_values(complete):
    assert complete("drake-ltl", "plan", "--method", "") == {"auto", "explicit", "bounded"}
    assert complete("drake-ltl", "completion", "") == {"bash", "zsh", "fish"}
    assert complete("drake-ltl", "plan", "--time-limit", "") == set()
    for option in ("--jobs", "--dask", "--only", "--gains"):
        assert complete("drake-ltl", "sweep", option, "") == set()


def test_files(complete):
    assert complete("drake-ltl", "plan", "") == {"cart.yaml", "cart.yml", "two words.yaml", "folder"}
    assert complete("drake-ltl", "verify", "") == {"run.npz", "folder"}
    assert "notes.txt" in complete("drake-ltl", "plan", "cart.yaml", "--json", "")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_and_option_is_in_each_script(shell):
    text = script(shell, make_parser())
    for command in COMMANDS:
        assert command in text
    for option in ("no-color", "suffix-rounds", "output", "outputs", "record", "time-limit"):
        assert option in text


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_can_read_its_script(shell, tmp_path):
    path = shutil.which(shell)
    if path is None:
        pytest.skip(f"{shell} is not installed")
    file = tmp_path / "script"
    file.write_text(script(shell, make_parser()), encoding="utf-8")
    result = subprocess.run([path, "-n", str(file)], capture_output=True, text=True, check=False, timeout=60)
    assert (result.returncode, result.stderr) == (0, "")


def test_other_shells(drake_ltl):
    result = drake_ltl("completion", "csh")
    assert result.status == 2
    assert "csh" in result.err
