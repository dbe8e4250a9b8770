"""The installed command, and what it loads."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import drake_ltl as drake_ltl_package

SCRIPT = shutil.which("drake-ltl", path=str(Path(sys.executable).parent))


def run(*arguments: object, **options) -> subprocess.CompletedProcess:
    assert SCRIPT is not None, "the package is not installed"
    command = [SCRIPT, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120, **options)


def python(code: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.parametrize(
    ("change", "status"), [(("", ""), 0), (("GF near", "G !near"), 1), (("power: 1", "power: 0"), 2)]
)
def test_exit_statuses(shuttle_file, change, status):
    text = shuttle_file.read_text(encoding="utf-8").replace(*change)
    shuttle_file.write_text(text, encoding="utf-8")
    result = run("plan", shuttle_file)
    assert result.returncode == status
    assert bool(result.stdout) == (status == 0)
    complaints = [line for line in result.stderr.splitlines() if not line.startswith("  ")]
    assert len(complaints) == (status != 0)


def test_no_command_is_a_mistake():
    result = run()
    assert result.returncode == 2
    assert "usage" in result.stderr


def test_version():
    assert run("--version").stdout.split() == ["drake-ltl", drake_ltl_package.__version__]


def test_help(drake_ltl):
    """Every command has one, with an example."""
    helped = drake_ltl("--help")
    assert helped.status == 0
    for command in ("new", "check", "draw", "explain", "plan", "simulate", "sweep", "verify", "view", "completion"):
        assert command in helped.out
        own = drake_ltl(command, "--help")
        assert own.status == 0
        assert f"drake-ltl {command} " in own.out.partition("example: ")[2]
        assert "--no-color" in own.out


def test_a_pipe_that_closes_does_not_end_the_work(shuttle_file, tmp_path):
    command = f"'{SCRIPT}' plan '{shuttle_file}' --json '{tmp_path}/plan.json' | true"
    result = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, check=False, timeout=120
    )
    assert result.returncode == 0
    assert result.stderr == ""
    assert json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))["status"] == "optimal"


def test_output_in_a_pipe_is_plain(examples):
    result = run("plan", examples / "case_ii.yaml")
    assert "\x1b" not in result.stdout
    assert max(len(line) for line in result.stdout.splitlines()) <= 120


def on_a_terminal(*arguments: object, progress: bool = False, **environment: str) -> str:
    """What the command writes to a terminal, with or without what it says on stderr while it works."""
    import pty

    assert SCRIPT is not None
    reading, writing = pty.openpty()
    with os.fdopen(reading, "rb", buffering=0) as terminal:
        command = [SCRIPT, *map(str, arguments)]
        plain = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
        settings = {**plain, "TERM": "xterm-256color", "COLUMNS": "80", **environment}
        stderr = writing if progress else subprocess.DEVNULL
        with subprocess.Popen(command, stdin=writing, stdout=writing, stderr=stderr, env=settings):
            os.close(writing)
            text = b""
            try:
                while more := terminal.read(4096):
                    text += more
            except OSError:  # how Linux says that nobody writes any more
                pass
    return text.decode()


@pytest.mark.parametrize(
    ("arguments", "environment", "coloured"),
    [((), {}, True), (("--no-color",), {}, False), ((), {"NO_COLOR": "1"}, False)],
)
def test_colours_on_a_terminal_unless_they_are_not_wanted(shuttle_file, arguments, environment, coloured):
    text = on_a_terminal("plan", shuttle_file, *arguments, **environment)
    assert "near → far" in text.replace("\N{NO-BREAK SPACE}", " ")
    assert ("\x1b[" in text) == coloured


def test_no_color_may_stand_before_the_command(shuttle_file):
    assert "\x1b[" not in on_a_terminal("--no-color", "plan", shuttle_file)


def test_progress_is_shown_on_a_terminal_and_nowhere_else(shuttle_file):
    shown = on_a_terminal("simulate", shuttle_file, progress=True)
    for work in ("loading the models", "planning", "simulating", "step 1 of 2", "step 2 of 2", "judging the run"):
        assert work in shown
    assert run("simulate", shuttle_file).stderr == ""


def test_letters_that_the_encoding_lacks(shuttle_file):
    result = run("plan", shuttle_file, env=os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"})
    assert (result.returncode, result.stderr) == (0, "")
    assert "near > far" in result.stdout
    assert result.stdout.isascii()


def test_names_that_the_encoding_lacks(tmp_path):
    result = run("plan", tmp_path / "\N{GREEK SMALL LETTER PI}.yaml", env=os.environ | {"PYTHONIOENCODING": "ascii"})
    assert result.returncode == 2
    (line,) = result.stderr.splitlines()
    assert "?.yaml" in line


ENDED_BY_A_TEXT = """
import sys
import drake_ltl.cli as cli
def fail(*args): raise SystemExit("Failure at multibody_tree.cc:1\\nin a function")
from drake_ltl.cli import completion
completion.add_parser = lambda commands: commands.add_parser("completion").set_defaults(run=fail)
"""


@pytest.mark.parametrize("end", ["cli.entry_point()", "sys.exit(cli.main())"])
def test_a_library_that_ends_the_process_with_a_text(end):
    """As Drake's failed conditions do in Python: no success."""
    result = python(f"{ENDED_BY_A_TEXT}sys.argv = ['drake-ltl', 'completion']\n{end}")
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr == "Failure at multibody_tree.cc:1\n"


def test_planning_with_all_radii_given_needs_no_drake(examples):
    path = str(examples / "case_ii.yaml")
    code = f"import sys; from drake_ltl.cli import main; status = main(['plan', {path!r}]); "
    result = python(
        code + "print(json.dumps([status, 'pydrake' in sys.modules]))".replace("json.", "__import__('json').")
    )
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout.splitlines()[-1]) == [0, False]


SYMBOLIC = ("scenario", "planning", "navigation", "verification")
WITH_MODELS = "drake_ltl.verification.models"
"""The one module that works out, with Drake, what models make of a recording."""


@pytest.mark.parametrize("package", SYMBOLIC)
def test_the_symbolic_half_never_loads_drake(package):
    """Every module of it but one, not only what its package imports."""
    result = python(f"""
import importlib, pkgutil, sys
package = importlib.import_module("drake_ltl.{package}")
names = [found.name for found in pkgutil.walk_packages(package.__path__, package.__name__ + ".")]
names = [name for name in names if name != "{WITH_MODELS}"]
for name in names:
    importlib.import_module(name)
assert len(names) > 3, names
loaded = sorted(name for name in sys.modules if name.split(".")[0] in ("pydrake", "models", "diagrams"))
assert not loaded, loaded
assert "drake_ltl.systems" not in sys.modules
""")
    assert result.returncode == 0, result.stderr


def test_recordings_are_read_without_drake():
    code = "import sys, drake_ltl.execution.recording, drake_ltl.cli; assert 'pydrake' not in sys.modules"
    result = python(code)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("command", ["plan", "explain", "simulate", "check", "sweep"])
def test_a_malformed_scenario_is_refused_before_anything_large_is_loaded(tmp_path, command):
    """Loading takes longer than all that is done with such a file."""
    file = tmp_path / "bad.yaml"
    file.write_text("workspace: {radius: wide}", encoding="utf-8")
    more = ["--runs", "1"] if command == "sweep" else []
    code = f"""
import sys
from drake_ltl.cli import main
status = main({[command, str(file), *more]!r})
loaded = [name for name in ("numpy", "scipy", "pydrake", "ortools", "networkx") if name in sys.modules]
sys.exit(f"{{status}} {{loaded}}" if status != 2 or loaded else 0)
"""
    result = python(code)
    assert result.returncode == 0, result.stderr
