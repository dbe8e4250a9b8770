"""Many rounds of a mission: do clearances, memory or the time of a step drift? Part of `make soak`.

    python benchmarks/long_run.py --rounds 100

Memory and CPU time are noted once every simulated second. The logs of a run grow with it, and are its recording when
it is over: memory is held against the size of the recording's arrays.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.execution.runner import RunProgress
from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.scenario import load, loads
from drake_ltl.verification import Verdict, verify
from drake_ltl.visualization.clearances import clearance_curves

ROOT = Path(__file__).resolve().parents[1]
PAGE = os.sysconf("SC_PAGE_SIZE")
SHARE = 0.1
"""Of all rounds: so many at the begin and at the end are held against each other."""
DRIFT = 1e-3
"""Of a clearance [m]: less than the least that planning keeps bodies apart."""
SLOWER = 1.25
"""Of CPU time for a simulated second: other work on the machine explains so much."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", type=Path, default=ROOT / "examples" / "case_ii.yaml")
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    parser.add_argument("--look", action="store_true", help="only look at a run that is there")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    run, notes = args.output / "long_run.npz", args.output / "long_run_notes.json"
    if not args.look:
        carry_out(args, run, notes)
    recording = Recording.load(run)
    result = findings(recording, json.loads(notes.read_text(encoding="utf-8")), verify(recording))
    (args.output / "long_run.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    print(json.dumps(result))
    sys.exit(0 if result["satisfied"] and not result["drifts"] else 1)


def carry_out(args: argparse.Namespace, run: Path, notes: Path) -> None:
    """Simulates, and writes the recording and what the process took."""
    scenario = load(args.scenario)
    models = measure(scenario)
    taken = Notes()
    result = simulate(plan_and_place(scenario, models), scenario, models, suffix_rounds=args.rounds, report=taken.take)
    result.recording.save(run)
    notes.write_text(json.dumps(taken.rows), encoding="utf-8")


@dataclass
class Notes:
    """What the process takes while it runs."""

    rows: list[tuple[float, int, float, int]] = field(default_factory=list)
    """Simulated time [s], steps done, CPU time [s], resident memory [bytes]."""

    def take(self, progress: RunProgress) -> None:
        resident = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * PAGE
        self.rows.append((progress.time, progress.step, time.process_time(), resident))


def findings(recording: Recording, notes: list[list[float]], verdict: Verdict) -> dict[str, Any]:
    """First rounds against last ones."""
    rounds = rounds_of(recording)
    some = max(1, round(SHARE * len(rounds)))
    groups = {"first": rounds[:some], "last": rounds[-some:]}
    clearances = {name: _least(recording, those) for name, those in groups.items()}
    seconds = {name: [end - start for start, end in those] for name, those in groups.items()}
    cost = {name: _cost(notes, those[0][0], those[-1][1]) for name, those in groups.items()}
    arrays = [*recording.q.values(), *recording.qd.values(), *recording.pose.values(), *recording.velocity.values()]
    found = {
        "scenario": loads(recording.scenario).name,
        "rounds": len(rounds),
        "compared": some,
        "simulated_seconds": float(recording.time[-1]),
        "satisfied": verdict.satisfied,
        "violations": [str(violation) for violation in verdict.violations],
        "least_clearance": clearances,
        "seconds_of_a_round": {name: [min(those), max(those)] for name, those in seconds.items()},
        "cpu_ms_per_simulated_second": {name: 1e3 * cpu for name, (cpu, _) in cost.items()},
        "memory_kb_per_simulated_second": {name: memory / 1e3 for name, (_, memory) in cost.items()},
        "states_kb_per_simulated_second": sum(a.nbytes for a in arrays) / recording.time[-1] / 1e3,
        "largest_memory_mb": max(row[3] for row in notes) / 1e6,
        "max_weld_error_mm": 1e3 * verdict.max_weld_error,
        "max_lyapunov_increase": verdict.max_lyapunov_increase,
    }
    return found | {"drifts": list(_drifts(found))}


def rounds_of(recording: Recording) -> list[tuple[float, float]]:
    """Begin and end of each finished round of the suffix [s]."""
    done = [step for step in recording.steps if step.finished]
    starts = range(recording.prefix_length, len(done) - recording.suffix_length + 1, recording.suffix_length)
    last = recording.suffix_length - 1
    return [(done[k].start, done[k + last].start + done[k + last].duration) for k in starts]


def _least(recording: Recording, rounds: list[tuple[float, float]]) -> dict[str, float]:
    """[m] of each kind within some rounds."""
    begin, end = rounds[0][0], rounds[-1][1]
    least: dict[str, float] = {}
    for curve in clearance_curves(recording, loads(recording.scenario)):
        inside = curve.value[(curve.time >= begin) & (curve.time <= end)]
        if len(inside):
            least[curve.kind] = min(least.get(curve.kind, np.inf), float(inside.min()))
    return least


def _cost(notes: list[list[float]], begin: float, end: float) -> tuple[float, float]:
    """CPU time [s] and memory [bytes] for each simulated second of a part of the run."""
    inside = [row for row in notes if begin <= row[0] <= end]
    lasted = inside[-1][0] - inside[0][0]
    return (inside[-1][2] - inside[0][2]) / lasted, (inside[-1][3] - inside[0][3]) / lasted


def _drifts(found: dict[str, Any]):
    """What changed from the first rounds to the last."""
    first, last = found["least_clearance"]["first"], found["least_clearance"]["last"]
    for kind in first:
        if last[kind] < first[kind] - DRIFT:
            yield f"clearance {kind}: {first[kind]:.4f} m, then {last[kind]:.4f} m"
    cpu = found["cpu_ms_per_simulated_second"]
    if cpu["last"] > SLOWER * cpu["first"]:
        yield f"a simulated second: {cpu['first']:.0f} ms, then {cpu['last']:.0f} ms"
    memory = found["memory_kb_per_simulated_second"]
    if memory["last"] > SLOWER * max(memory["first"], found["states_kb_per_simulated_second"]):
        yield f"memory for a simulated second: {memory['first']:.0f} kB, then {memory['last']:.0f} kB"


if __name__ == "__main__":
    main()
