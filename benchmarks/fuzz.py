"""Fuzzing guided by coverage (atheris): scenarios, plans and recordings, spoilt wherever that reaches new lines.

    python benchmarks/fuzz.py                       # all three, 20000 inputs each
    python benchmarks/fuzz.py --kinds scenario --runs 1000 --seed 3

Every input must be read, or refused with a printable line for each mistake; anything else ends the fuzzing and is kept.
Part of `make soak`. Needs the extra `fuzz`, which `malformed.py` does without; says so where it is missing.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import importlib.util
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[1]
KINDS = ("scenario", "plan", "recording")
RUNS = 20_000
HANGS = 60
"""An input that takes so long has made the library hang [s]."""
INSTRUMENTED = ["drake_ltl.scenario", "drake_ltl.planning.plan_reader", "drake_ltl.execution", "drake_ltl.verification"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", nargs="*", default=KINDS, choices=KINDS)
    parser.add_argument("--runs", type=int, default=RUNS, help="inputs of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    parser.add_argument("--child", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if importlib.util.find_spec("atheris") is None:
        print("fuzzing is left out: there is no atheris; `pip install 'drake-ltl[fuzz]'` (Linux, from Python 3.11 on)")
        return
    if args.child is not None:
        fuzz(args.child, args.runs, args.seed, args.output)
        return
    found = [campaign(kind, args.runs, args.seed, args.output) for kind in args.kinds]
    sys.exit(1 if any(row["wrong"] for row in found) else 0)


def campaign(kind: str, runs: int, seed: int, output: Path) -> dict[str, object]:
    """In a process of its own: a fuzzer does not return. Writes and returns what came of it."""
    folder = output / "fuzz" / kind
    folder.mkdir(parents=True, exist_ok=True)
    arguments = ["--child", kind, "--runs", str(runs), "--seed", str(seed), "--output", str(folder)]
    began = time.perf_counter()
    done = subprocess.run([sys.executable, __file__, *arguments], capture_output=True, text=True, check=False)
    told = re.findall(r"#(\d+)\s+\w+\s+cov: (\d+)", done.stderr)
    slowest = re.findall(r"stat::slowest_unit_time_sec:\s+(\d+)", done.stderr)
    row = {
        "kind": kind,
        "seed": seed,
        "runs": int(told[-1][0]) if told else 0,
        "coverage": [int(told[0][1]), int(told[-1][1])] if told else [0, 0],
        "slowest_whole_seconds": int(slowest[-1]) if slowest else None,
        "wall_seconds": round(time.perf_counter() - began),
        "wrong": "" if done.returncode == 0 else done.stderr[-2000:],
    }
    (output / f"fuzz_{kind}.json").write_text(json.dumps(row, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(row), flush=True)
    return row


def fuzz(kind: str, runs: int, seed: int, folder: Path) -> None:
    """Does not return. Inputs that end it are written into the folder."""
    import atheris

    with atheris.instrument_imports(include=INSTRUMENTED):
        import malformed
    sources = malformed.Sources(folder, seconds=0.2)
    inputs = folder / "inputs"
    inputs.mkdir(exist_ok=True)
    for number in range(12):  # sound ones and their like to begin with
        _, path = sources.spoil(seed, 4 * number + malformed.KINDS.index(kind))
        path.rename(inputs / path.name)

    def change(data: bytes, most: int, number: int) -> bytes:
        """Half of them anew, in the manner of `malformed.py`, the others from what has reached something."""
        chance = Random(number)
        spoilt = sources.spoilt(chance, kind) if chance.random() < 0.5 else atheris.Mutate(data, most)
        return spoilt[:most]

    settings = [f"-runs={runs}", f"-seed={seed}", f"-timeout={HANGS}", f"-artifact_prefix={folder}/", "-max_len=300000"]
    look = looking(kind, sources)
    atheris.Setup([sys.argv[0], *settings, "-print_final_stats=1", str(inputs)], look, custom_mutator=change)
    atheris.Fuzz()


def looking(kind: str, sources) -> Callable[[bytes], None]:
    """What is done with an input; what it raises is a finding."""
    import malformed

    from drake_ltl.errors import InvalidInputError
    from drake_ltl.execution.recording import Recording
    from drake_ltl.planning.plan_reader import plan_from_json
    from drake_ltl.scenario import load
    from drake_ltl.verification import verify

    file = Path(tempfile.mkdtemp(prefix="drake_ltl_fuzz_")) / f"input.{malformed.SUFFIXES[kind]}"

    def read(data: bytes) -> None:
        if kind == "plan":
            try:
                data = json.loads(data)
            except (ValueError, RecursionError):
                return
            plan_from_json(data, sources.small)
            return
        file.write_bytes(data)
        if kind == "scenario":
            load(file)
        else:
            verify(Recording.load(file))

    def look(data: bytes) -> None:
        try:
            read(data)
        except InvalidInputError as error:
            lines = str(error).splitlines()
            if len(lines) != len(error.mistakes) or not all(map(malformed.is_complaint, lines)):
                raise AssertionError(f"not a line for each mistake: {error}") from error

    return look


if __name__ == "__main__":
    main()
