"""Thousands of malformed scenarios, plans and recordings: each must end in exit status 2 with a line for each mistake.

    python benchmarks/malformed.py --inputs 10000 --seed 0

Commands run in this process, each input in a child of its own, some in the installed command as well. An input that is
spoilt without becoming malformed (another number, a sound formula) must end in 0 or 1, and is not counted. What goes
wrong is printed and kept. Part of `make soak`.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import contextlib
import io
import json
import resource
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import mutations
import numpy as np

from drake_ltl.cli import main as command
from drake_ltl.errors import InvalidInputError
from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.planning.plan_json import plan_to_json
from drake_ltl.planning.plan_reader import plan_from_json
from drake_ltl.processes import apart
from drake_ltl.scenario import load, loads

ROOT = Path(__file__).resolve().parents[1]
KINDS = ("scenario", "recording", "scenario", "plan")
SUFFIXES = {"scenario": "yaml", "recording": "npz", "plan": "json"}
BATCH = 250
"""Inputs that share a child. The first of each are given to the installed command as well."""
COMMANDS = 8
"""So many of each batch."""
HANGS = 60.0
"""Only a command that hangs takes so long [s]."""
PLANNED = 0.03
"""Share of what is spoilt and sound that is planned: that takes as long as many that are malformed."""
SOUND_TIME = "0.5"
"""For planning what is spoilt and sound [s]."""
SMALL = """
name: small
workspace: {radius: 12}
regions:
  pi1: {centre: [-3, 0, 0], radius: 2.5}
  pi2: {centre: [3, 0, 0], radius: 2.5}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-3, 0], spec: GF pi2}
objects:
  o1: {model: package://drake_ltl_models/objects/crate.sdf, position: [3, 0.5], power_needed: 1, spec: GF pi2}
simulation: {time_step: 0.02}
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=10_000, help="malformed ones to be reached")
    parser.add_argument("--commands", type=int, default=COMMANDS, help=f"of {BATCH} that the installed command gets")
    parser.add_argument("--seed", type=int, default=0, help="several may run at once")
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    args = parser.parse_args()
    folder = args.output / "malformed"
    folder.mkdir(parents=True, exist_ok=True)
    sources = Sources(folder)
    tally: dict[str, Counter[str]] = {kind: Counter() for kind in SUFFIXES}
    slowest, slow, wrong = dict.fromkeys((*SUFFIXES, "installed command"), 0.0), [], []
    began, number, commands, ends = time.perf_counter(), 0, 0, []
    signal.signal(signal.SIGINT, lambda *_: ends.append(True))  # what there is then is written
    while not ends and sum(counts["malformed"] for counts in tally.values()) < args.inputs:
        for kind, path, outcome in judged(args.seed, range(number, number + BATCH), sources):
            if outcome["status"] == 2:
                slowest[kind] = max(slowest[kind], outcome["seconds"])
                if outcome["seconds"] > 1.0:
                    slow.append({"input": path.name, **outcome})
            fine = outcome["status"] in (0, 1, 2) and not outcome["wrong"]
            tally[kind]["malformed" if outcome["status"] == 2 else "sound" if fine else "wrong"] += 1
            if not fine:
                wrong.append({"input": path.name, **outcome})
                print(json.dumps(wrong[-1])[:2000], flush=True)
        number += BATCH
        for found in commanded(args.seed, range(number - BATCH, number - BATCH + args.commands), sources):
            commands, refused = commands + 1, found["status"] == 2
            slowest["installed command"] = max(slowest["installed command"], found["seconds"] if refused else 0.0)
            if refused and found["seconds"] > 1.0:
                slow.append({"command": "installed", **found})
            if found["wrong"]:
                wrong.append(found)
                print(json.dumps(found)[:2000], flush=True)
    seconds = time.perf_counter() - began
    result = {
        "seed": args.seed,
        "inputs": number,
        "commands": commands,
        "wall_seconds": seconds,
        "tally": tally,
        "slow": slow,
        "wrong": wrong,
    }
    result["slowest_cpu_seconds"] = slowest
    (args.output / f"malformed_{args.seed}.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    print(json.dumps({key: value for key, value in result.items() if key not in ("slow", "wrong")}))
    sys.exit(1 if wrong else 0)


class Sources:
    """What is sound: the examples, the plan of a small scenario and the first seconds of its run."""

    def __init__(self, folder: Path, seconds: float = 2.0):
        self.folder = folder
        self.texts = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "examples").glob("*.yaml"))]
        self.small = loads(SMALL)
        models = measure(self.small)
        mission = plan_and_place(self.small, models)
        self.plan = json.dumps(plan_to_json(mission.plan, self.small))
        run = simulate(mission, self.small, models, report=stop_after(seconds))
        sound = folder / f"sound_{os.getpid()}.npz"
        run.recording.save(sound)
        with np.load(sound) as archive:
            self.arrays = {name: archive[name] for name in archive.files if name != "header"}
            self.header = json.loads(archive["header"].tobytes())
        sound.unlink()

    def spoil(self, seed: int, number: int) -> tuple[str, Path]:
        """Writes an input that may be malformed: half of them are scenarios."""
        chance, kind = Random(f"{seed} {number}"), KINDS[number % len(KINDS)]
        path = self.folder / f"{seed}_{number}.{SUFFIXES[kind]}"
        path.write_bytes(self.spoilt(chance, kind))
        return kind, path

    def spoilt(self, chance: Random, kind: str) -> bytes:
        """What may be malformed."""
        if kind == "recording":
            return mutations.recording(chance, self.header, self.arrays)
        if kind == "plan":
            return mutations.plan(chance, self.plan)
        return mutations.scenario(chance, chance.choice(self.texts))


def stop_after(seconds: float):
    """A reporter of progress that interrupts the run, as Ctrl-C would."""

    def report(progress) -> None:
        if progress.time >= seconds:
            raise KeyboardInterrupt

    return report


def judged(seed: int, numbers: range, sources: Sources) -> list[tuple[str, Path, dict[str, Any]]]:
    """What becomes of inputs, in a child: a library may end it. If so, each again in a child of its own."""
    try:
        return apart(_judged, seed, numbers, sources, seconds=HANGS * len(numbers) ** 0.5)
    except Exception as error:
        if len(numbers) == 1:
            kind, path = sources.spoil(seed, numbers[0])
            return [(kind, path, {"status": None, "seconds": 0.0, "wrong": f"{type(error).__name__}: {error}"})]
    return [found for number in numbers for found in judged(seed, range(number, number + 1), sources)]


def _judged(seed: int, numbers: range, sources: Sources) -> list[tuple[str, Path, dict[str, Any]]]:
    found = []
    for number in numbers:
        kind, path = sources.spoil(seed, number)
        outcome = read_plan(path, sources.small) if kind == "plan" else run_command(kind, path)
        found.append((kind, path, outcome))
        if outcome["status"] in (0, 1, 2) and not outcome["wrong"]:
            path.unlink()
    return found


def run_command(kind: str, path: Path) -> dict[str, Any]:
    """`plan` or `verify`."""
    if kind == "scenario" and is_sound(path) and Random(path.name).random() > PLANNED:
        return {"status": 0, "seconds": 0.0, "wrong": ""}
    words = ["verify", str(path)] if kind == "recording" else ["plan", str(path), "--time-limit", SOUND_TIME]
    out, err = io.StringIO(), io.StringIO()
    began, wrong = time.process_time(), ""
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = command(words)
        except SystemExit as done:
            status = done.code
    seconds = time.process_time() - began
    if status == 2:
        wrong = next((line for line in err.getvalue().splitlines() if not is_complaint(line)), "")
        wrong = wrong or ("" if err.getvalue() else "says nothing")
    return {"status": status, "seconds": seconds, "wrong": wrong, "says": err.getvalue()[:300]}


def is_sound(path: Path) -> bool:
    try:
        load(path)
    except InvalidInputError:
        return False
    return True


def is_complaint(line: str) -> bool:
    """Where, what and a remedy; of problems beyond the planner's means, what alone."""
    return bool(line.strip()) and line.isprintable() and len(line) < 2000 and ": " in line and "Traceback" not in line


def read_plan(path: Path, scenario: Any) -> dict[str, Any]:
    """There is no command that reads plans; the library says the same of them."""
    began, wrong = time.process_time(), ""
    try:
        plan_from_json(json.loads(path.read_bytes()), scenario)
        status = 0
    except InvalidInputError as error:
        status, lines = 2, str(error).splitlines()
        if len(lines) != len(error.mistakes) or not all(map(is_complaint, lines)):
            wrong = str(error)
    except ValueError:  # no JSON: says so itself
        status = 2
    return {"status": status, "seconds": time.process_time() - began, "wrong": wrong}


def commanded(seed: int, numbers: range, sources: Sources) -> Iterator[dict[str, Any]]:
    """What the installed command says of inputs; no command reads plans."""
    for number in numbers:
        kind, path = sources.spoil(seed, number)
        if kind != "plan":
            found = installed(kind, path)
            yield {"input": path.name, **found}
            if found["wrong"]:
                continue
        path.unlink()


def installed(kind: str, path: Path) -> dict[str, Any]:
    """The same through the installed command, with the CPU time that Python and the library take to load."""
    words = ["verify", path] if kind == "recording" else ["plan", path, "--time-limit", SOUND_TIME]
    script, before = Path(sys.executable).with_name("drake-ltl"), _children_seconds()
    done = subprocess.run([script, *words], capture_output=True, text=True, timeout=10 * HANGS, check=False)
    status, lines = done.returncode, done.stderr.splitlines()
    bad = status not in (0, 1, 2) or (status == 2 and not (lines and all(map(is_complaint, lines))))
    return {"status": status, "seconds": _children_seconds() - before, "wrong": done.stderr[:500] if bad else ""}


def _children_seconds() -> float:
    """CPU time of all children that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
