"""Ctrl-C, SIGTERM, time limits and streams that cannot be written: in processes of their own, as people use them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from drake_ltl.execution.recording import Recording

SCRIPT = Path(sys.executable).with_name("drake-ltl")
PATIENCE = 60.0
"""Only a command that hangs takes so long [s]."""

PRELUDE = """
import ctypes, os, sys, time
import drake_ltl.cli as cli

def stuck(*args, **options):
    "Ready, and deaf: sleeps without letting Python go on, like a library that computes."
    os.write(2, b"ready\\n")
    ctypes.PyDLL(None).sleep(100)
"""
EPILOGUE = "\nsys.argv[0] = 'drake-ltl'\ncli.entry_point()\n"

LOADING = "cli.make_parser = stuck"
PLANNING = "from drake_ltl.cli import planning; planning.plan_by = stuck"
SIMULATING = """
from drake_ltl.cli import simulate
original = simulate._reporter

def reporter(bar):
    report = original(bar)
    def reported(progress):
        report(progress)
        if progress.time >= 1.0:
            os.write(2, b"ready\\n")
            time.sleep(100)
    return reported

simulate._reporter = reporter
"""
JUDGING = SIMULATING + "import drake_ltl.verification; drake_ltl.verification.verify = stuck"


class Running:
    """A command whose code was changed at some place, in a process group of its own."""

    def __init__(self, change: str, *arguments: object, shell: str = ""):
        command = [sys.executable, "-c", PRELUDE + change + EPILOGUE, *map(str, arguments)]
        if shell:
            command = ["bash", "-c", f'{shell}; exec "$@"', "bash", *command]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True)

    def wait_for(self, line: str) -> None:
        for said in self.process.stderr:
            if said == f"{line}\n":
                return
        raise AssertionError(f"ended without {line!r}")

    def send(self, number: int, group: bool = False) -> None:
        (os.killpg if group else os.kill)(self.process.pid, number)

    def end(self) -> tuple[int, str]:
        """Exit status and the rest of stderr; nothing of the command is left running."""
        try:
            err = self.process.communicate(timeout=PATIENCE)[1]
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            raise
        with pytest.raises(ProcessLookupError):
            os.killpg(self.process.pid, 0)
        return self.process.returncode, err


@pytest.fixture
def hard_file(examples, tmp_path) -> Path:
    """Spot would translate its formula for minutes."""
    formula = " & ".join(f"F(pi2 & {'X' * n} pi1)" for n in range(1, 11))
    text = (examples / "case_i.yaml").read_text(encoding="utf-8")
    assert '"G !pi3"' in text
    path = tmp_path / "hard.yaml"
    path.write_text(text.replace('"G !pi3"', f'"{formula}"'), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("number", "group"),
    [(signal.SIGINT, False), (signal.SIGINT, True), (signal.SIGTERM, False), (signal.SIGTERM, True)],
)
def test_interrupted_inside_a_library(examples, number, group):
    command = Running(PLANNING, "plan", examples / "case_i.yaml")
    command.wait_for("ready")
    command.send(number, group)
    assert command.end() == (130, "interrupted\n")


def test_interrupted_while_modules_load(examples):
    command = Running(LOADING, "plan", examples / "case_i.yaml")
    command.wait_for("ready")
    command.send(signal.SIGINT)
    assert command.end() == (130, "interrupted\n")


@pytest.mark.parametrize("command", ["plan", "simulate"])
def test_interrupted_while_spot_translates(hard_file, command):
    say = "; import drake_ltl.spot_questions as q; apart = q.apart"
    say += "; q.apart = lambda *args, **options: (os.write(2, b'ready\\n'), apart(*args, **options))[1]"
    running = Running("pass" + say, command, hard_file)
    running.wait_for("ready")
    running.send(signal.SIGINT, group=True)
    assert running.end() == (130, "interrupted\n")


def test_an_ignored_interrupt_stays_ignored(examples):
    """As shells have it for jobs in the background, and `nohup` for SIGHUP."""
    change = "from drake_ltl import scenario; load = scenario.load\n"
    change += "scenario.load = lambda file: (os.kill(os.getppid(), 2), os.kill(os.getpid(), 2), load(file))[2]"
    command = Running(change, "plan", examples / "case_i.yaml", shell="trap '' INT")
    assert command.end() == (0, "")


def read_unknown(path: Path) -> None:
    data = json.loads(path.read_text(encoding="utf-8"))
    assert (data["scenario"], data["status"], data["cost"]) == ("case_i", "unknown", None)


@pytest.mark.parametrize("method", ["auto", "explicit", "bounded"])
def test_time_runs_out_inside_a_library(examples, tmp_path, method):
    options = ("--method", method, "--time-limit", "0.3", "--json", tmp_path / "plan.json")
    status, err = Running(PLANNING, "plan", examples / "case_i.yaml", *options).end()
    assert status == 1
    assert err == "ready\nno plan: the time limit of 0.3 s is over\n"
    read_unknown(tmp_path / "plan.json")


def test_time_runs_out_while_spot_translates(hard_file, tmp_path):
    command = Running("", "plan", hard_file, "--time-limit", "0.7", "--json", tmp_path / "plan.json")
    assert command.end() == (1, "no plan: the time limit of 0.7 s is over\n")
    read_unknown(tmp_path / "plan.json")


def test_time_runs_out_during_an_explanation(examples, tmp_path):
    """It is known by then that there is no plan."""
    text = (examples / "case_i.yaml").read_text(encoding="utf-8").replace('"GF pi3"', '"GF pi3 & G !pi3"')
    (tmp_path / "case_i.yaml").write_text(text, encoding="utf-8")
    change = "from drake_ltl.cli import infeasibility; infeasibility.explain = stuck"
    options = ("--time-limit", "2", "--json", tmp_path / "plan.json")
    status, err = Running(change, "plan", tmp_path / "case_i.yaml", *options).end()
    assert status == 1
    assert err.startswith("infeasible: ")
    assert "no plan" not in err
    assert json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))["status"] == "infeasible"


def test_a_command_that_is_killed(examples, tmp_path):
    """As the system does where memory is short."""
    change = "from drake_ltl.cli import planning; planning.plan_by = lambda *args, **options: os.kill(os.getpid(), 9)"
    assert Running(change, "plan", examples / "case_i.yaml").end() == (
        137,
        "ended by SIGKILL; perhaps memory was short\n",
    )
    options = ("--time-limit", "60", "--json", tmp_path / "plan.json")
    status, err = Running(change, "plan", examples / "case_i.yaml", *options).end()
    assert (status, err) == (1, "no result: ended by SIGKILL; perhaps memory was short\n")
    read_unknown(tmp_path / "plan.json")


@pytest.mark.parametrize(("number", "group"), [(signal.SIGINT, True), (signal.SIGTERM, False)])
def test_an_interrupted_simulation_is_saved(shuttle_file, tmp_path, number, group):
    out = tmp_path / "out"
    out.mkdir()
    options = ("--json", out / "verdict.json", "--recording", out / "run.npz")
    command = Running(SIMULATING, "simulate", shuttle_file, *options)
    command.wait_for("ready")
    command.send(number, group)
    assert command.end() == (130, "interrupted\n")
    assert sorted(path.name for path in out.iterdir()) == ["run.npz", "verdict.json"]
    assert Recording.load(out / "run.npz").reason == "interrupted"
    verdict = json.loads((out / "verdict.json").read_text(encoding="utf-8"))
    assert verdict["satisfied"] is False
    assert any("interrupted" in violation for violation in verdict["violations"])


def test_a_disk_that_is_full_when_a_run_is_over(shuttle_file, tmp_path):
    """It takes the verdict, which is small, and not the recording; that of an earlier run stays."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "run.npz").write_text("precious", encoding="utf-8")
    change = """
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
from drake_ltl.cli import simulate

def interrupt(progress):
    if progress.time >= 1.0:
        raise KeyboardInterrupt

simulate._reporter = lambda bar: interrupt
"""
    options = ("--json", out / "verdict.json", "--recording", out / "run.npz")
    status, err = Running(change, "simulate", shuttle_file, *options).end()
    assert (status, err) == (2, f"{out / 'run.npz'}: File too large\n")
    assert sorted(path.name for path in out.iterdir()) == ["run.npz", "verdict.json"]
    assert (out / "run.npz").read_text(encoding="utf-8") == "precious"
    assert json.loads((out / "verdict.json").read_text(encoding="utf-8"))["satisfied"] is False


def test_the_second_interrupt_ends_the_saving(shuttle_file):
    command = Running(JUDGING, "simulate", shuttle_file)
    for _ in range(2):
        command.wait_for("ready")
        command.send(signal.SIGINT, group=True)
    assert command.end() == (130, "interrupted\n")


def in_shell(arguments: str, redirection: str) -> subprocess.CompletedProcess:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    return subprocess.run(
        ["bash", "-c", f"'{SCRIPT}' {arguments} {redirection}"],
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
        env=environment,
    )


@pytest.mark.parametrize("redirection", [">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-", "2>/dev/full"])
def test_streams_that_are_closed(examples, tmp_path, redirection):
    """What was to be printed does not end up in the files."""
    result = in_shell(f"plan '{examples}/case_i.yaml' --json '{tmp_path}/plan.json'", redirection)
    assert result.returncode == 0
    assert result.stderr == ""
    assert bool(result.stdout) == (">&-" not in redirection.replace("2>&-", ""))
    assert json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))["status"] == "optimal"


@pytest.mark.parametrize("redirection", [">&-", "2>&-", ">&- 2>&-", "2>/dev/full"])
def test_complaints_that_nobody_hears(tmp_path, redirection):
    result = in_shell(f"verify '{tmp_path}/nothing.npz'", redirection)
    assert result.returncode == 2
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("arguments", ["plan '{}/case_i.yaml'", "--help"])
def test_a_full_disk_behind_stdout(examples, arguments):
    result = in_shell(arguments.format(examples), ">/dev/full")
    assert result.returncode == 2
    assert result.stderr == "standard output: No space left on device\n"
