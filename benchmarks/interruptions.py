"""Ctrl-C at random moments, and disks that are full after random numbers of bytes. Part of `make soak`.

    python benchmarks/interruptions.py --interruptions 100 --full-disks 40 --seed 1

Commands are those that people install, in processes of their own. Whatever happens, none may show a traceback, hang,
or leave files behind that are cut off; a recording that was there before stays if no new one takes its place; a sweep
goes on, and comes to what it comes to undisturbed. A full disk is a limit on the size of files here, at which writing
fails in the same way.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import malformed

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import Recording

ROOT = Path(__file__).resolve().parents[1]
COMMANDS = {
    "plan": ["plan", "small.yaml", "--json", "plan.json"],
    "plan, in CP-SAT": ["plan", "gathering", "--method", "bounded", "--time-limit", "4", "--json", "plan.json"],
    "simulate": ["simulate", "small.yaml", "--recording", "run.npz", "--json", "verdict.json"],
    "verify": ["verify", "sound.npz", "--json", "verdict.json"],
    "view": ["view", "sound.npz", "--record", "page.html", "--report", "report"],
    "sweep": ["sweep", "small.yaml", "--runs", "2", "--jobs", "1", "--output", "sweep"],
}
INTERRUPTED = 130
GONE = -int(signal.SIGINT)
"""Ended by the signal itself, before Python had begun to listen."""
STARTING = "before Python has started"
"""A status of its own: Ctrl-C ended Python while it looked for its packages, before the first line of the command."""
ENDS = {".html": b"</html>", ".png": b"IEND\xaeB`\x82", ".svg": b"</svg>"}
"""Last bytes of files that are whole."""
PATIENCE = 300.0
"""Only a command that hangs takes so long [s]."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--interruptions", type=int, default=400)
    parser.add_argument("--full-disks", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what is ignored here, as in the background, is so there
    names = list(COMMANDS)
    with tempfile.TemporaryDirectory() as folder:
        undisturbed = Undisturbed(Path(folder) / "undisturbed")
        result = {
            "seed": args.seed,
            "interrupted": tried(
                undisturbed, [names[k % len(names)] for k in range(args.interruptions)], interrupted, args.seed
            ),
            "full_disk": tried(
                undisturbed, [names[k % len(names)] for k in range(args.full_disks)], full_disk, args.seed
            ),
        }
    interruptions = sum(statuses[str(INTERRUPTED)] for statuses in result["interrupted"]["statuses"].values())
    if args.interruptions and not interruptions:
        sys.exit("no command was interrupted: nothing has been tried")
    (args.output / "interruptions.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(result, indent=2))
    sys.exit(1 if any(row["wrong"] for row in (result["interrupted"], result["full_disk"])) else 0)


def tried(undisturbed: Undisturbed, names: list[str], way: Any, seed: int) -> dict[str, Any]:
    """How often commands ended with which status, and all that was wrong."""
    statuses: dict[str, Counter[str]] = {name: Counter() for name in COMMANDS}
    wrong = []
    for number, name in enumerate(names):
        folder = undisturbed.folder.parent / f"{way.__name__}_{number}"
        undisturbed.prepare(folder)
        try:
            status, err = way(Random(f"{seed} {way.__name__} {number}"), name, folder, undisturbed)
        except KeyboardInterrupt:  # what there is then is written
            break
        statuses[name][str(status)] += 1
        found = [*_complaints(status, err), *_damage(name, folder, undisturbed, status)]
        if found:
            wrong.append({"number": number, "command": name, "status": status, "wrong": found, "says": err[-500:]})
            print(json.dumps(wrong[-1]), flush=True)
        shutil.rmtree(folder)
    return {"tried": sum(sum(found.values()) for found in statuses.values()), "statuses": statuses, "wrong": wrong}


class Undisturbed:
    """What commands come to when nothing happens, and how long they take."""

    def __init__(self, folder: Path):
        self.folder = folder
        folder.mkdir()
        (folder / "small.yaml").write_text(malformed.SMALL.replace("GF pi2", "F pi2"), encoding="utf-8")
        _end(_begin("simulate", folder))
        (folder / "run.npz").rename(folder / "sound.npz")
        self.seconds, self.files = {}, {path.name for path in folder.iterdir()}
        for name in COMMANDS:
            began = time.perf_counter()
            status, err = _end(_begin(name, folder))
            self.seconds[name] = time.perf_counter() - began
            if status != 0:
                sys.exit(f"{name} ends with {status} when nothing happens: {err}")
        self.files |= {"plan.json", "verdict.json", "run.npz", "sweep", "page.html", "report"}

    def prepare(self, folder: Path) -> None:
        """A folder with the inputs, and a recording of an earlier run."""
        folder.mkdir()
        for name in ("small.yaml", "sound.npz"):
            shutil.copy(self.folder / name, folder)
        shutil.copy(self.folder / "sound.npz", folder / "run.npz")

    def outcomes(self) -> list[dict[str, Any]]:
        return _outcomes(self.folder)


# Two ways to disturb


def interrupted(chance: Random, name: str, folder: Path, undisturbed: Undisturbed) -> tuple[int | str, str]:
    """Ctrl-C in a terminal reaches all processes of a command; `kill -INT` one."""
    command = _begin(name, folder)
    time.sleep(chance.uniform(0.0, undisturbed.seconds[name]))
    if command.poll() is None:
        (os.killpg if chance.random() < 0.7 else os.kill)(command.pid, signal.SIGINT)
    status, err = _end(command)
    return (STARTING if _is_starting(status, err) else status), err


def _is_starting(status: int, err: str) -> bool:
    """Whether no line of the script or of the library has been reached."""
    ours = re.search(r'File ".*(/bin/drake-ltl|/drake_ltl/[^"]*)"', err)
    return status == 1 and err.rstrip().endswith("KeyboardInterrupt") and ours is None


def full_disk(chance: Random, name: str, folder: Path, undisturbed: Undisturbed) -> tuple[int, str]:
    """Files may grow by so many bytes: up to half as large as the largest is in the end."""
    sizes = [path.stat().st_size for path in undisturbed.folder.rglob("*") if path.is_file()]
    most = int(10.0 ** chance.uniform(0.0, 5.0)) % (max(sizes) // 2)
    return _end(_begin(name, folder, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))))


def _begin(name: str, folder: Path, **more: Any) -> subprocess.Popen:
    command = [Path(sys.executable).with_name("drake-ltl"), *COMMANDS[name]]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "stdin": subprocess.DEVNULL}
    return subprocess.Popen(command, cwd=folder, start_new_session=True, text=True, **pipes, **more)


def _end(command: subprocess.Popen) -> tuple[int, str]:
    try:
        err = command.communicate(timeout=PATIENCE)[1]
    except subprocess.TimeoutExpired:
        os.killpg(command.pid, signal.SIGKILL)
        command.communicate()
        return command.returncode, "hangs"
    return command.returncode, err


# What may be wrong


def _complaints(status: int, err: str) -> Iterator[str]:
    if status == STARTING:
        return
    if "Traceback" in err or "hangs" in err:
        yield "a traceback, or no end"
    if status not in (0, 1, 2, INTERRUPTED, GONE):
        yield f"ends with {status}"
    if status in (2, INTERRUPTED) and not (err and all(line.isprintable() for line in err.splitlines())):
        yield "says nothing, or what cannot be printed"


def _damage(name: str, folder: Path, undisturbed: Undisturbed, status: int) -> Iterator[str]:
    for path in folder.iterdir():
        if path.name not in undisturbed.files:
            yield f"left {path.name} behind"
    for path in folder.rglob("*.json"):
        try:
            json.loads(path.read_text(encoding="utf-8"))
        except ValueError:
            yield f"{path.name} is cut off"
    for path in (*folder.rglob("*.html"), *folder.rglob("*.png"), *folder.rglob("*.svg")):
        if not path.read_bytes().rstrip().endswith(ENDS[path.suffix]):
            yield f"{path.name} is cut off"
    try:
        Recording.load(folder / "run.npz")  # the new one, if only of a part, or the one that was there
    except InvalidInputError as error:
        yield str(error)
    if name == "sweep" and status != 0:
        again, err = _end(_begin(name, folder))
        if again != 0 or _outcomes(folder) != undisturbed.outcomes():
            yield f"does not go on: {again}, {err[-300:]}"


def _outcomes(folder: Path) -> list[dict[str, Any]]:
    """Of the sweep, without what the clock adds."""
    lines = (folder / "sweep" / "runs.jsonl").read_text(encoding="utf-8").splitlines()[1:]
    rows = sorted((json.loads(line) for line in lines), key=lambda row: row["run"])
    return [{key: value for key, value in row.items() if key != "wall_seconds"} for row in rows]


if __name__ == "__main__":
    main()
