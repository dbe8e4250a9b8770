"""What takes hours: malformed inputs, many rounds, many runs, plans of two methods. `make soak`.

    python benchmarks/soak.py                        # all of it, results into docs/soak.md
    python benchmarks/soak.py --parts malformed rounds
    python benchmarks/soak.py --parts                # only write the document, of what is in out/soak

Each part leaves its results in out/soak, and can be repeated by itself. Exit status 1 if one found something wrong.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SWEEPS = {"patrol": 1000, "case_ii": 100}
"""Example -> runs."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="*", default=list(PARTS), choices=list(PARTS))
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "soak")
    parser.add_argument("--document", type=Path, default=ROOT / "docs" / "soak.md")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    statuses = [PARTS[part](args.output) for part in args.parts]
    args.document.write_text("\n".join(document(args.output)) + "\n", encoding="utf-8")
    sys.exit(max(statuses, default=0))


# The parts: each runs a program, and returns its exit status


def malformed(output: Path) -> int:
    """Halves side by side."""
    arguments = ("--inputs", "5000", "--output", output)
    with ThreadPoolExecutor() as threads:
        return max(threads.map(lambda seed: _python("malformed.py", "--seed", seed, *arguments), (1, 2)))


def rounds(output: Path) -> int:
    return _python("long_run.py", "--rounds", "100", "--output", output)


def agreement(output: Path) -> int:
    with (output / "agreement.jsonl").open("w", encoding="utf-8") as file:
        return _python("agreement.py", "--problems", "1000", "--seconds", "1", stdout=file)


def sweeps(output: Path) -> int:
    """An interrupted one goes on where it was."""
    script, found = Path(sys.executable).with_name("drake-ltl"), []
    for name, runs in SWEEPS.items():
        folder = output / f"sweep_{name}"
        command = [script, "sweep", ROOT / "examples" / f"{name}.yaml", "--runs", str(runs), "--output", folder]
        found.append(subprocess.run([*command, "--seed", "1"], check=False).returncode)
    return max(found)


def _python(program: str, *arguments: object, stdout: Any = None) -> int:
    command = [sys.executable, str(HERE / program), *map(str, arguments)]
    return subprocess.run(command, stdout=stdout, check=False).returncode


PARTS = {"malformed": malformed, "rounds": rounds, "agreement": agreement, "sweeps": sweeps}


# The document


def document(output: Path) -> Iterator[str]:
    """Its lines: a section for each part of which there are results."""
    yield "# Soak: what takes hours"
    yield ""
    yield "Written by `make soak` (`benchmarks/soak.py`), which takes hours."
    sections = (_malformed_section, _rounds_section, _agreement_section, _sweeps_section)
    for section in sections:
        lines = list(section(output))
        if lines:
            yield ""
            yield from lines


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def _malformed_section(output: Path) -> Iterator[str]:
    files = sorted(output.glob("malformed_*.json"))
    if not files:
        return
    found = _added([_read(file) for file in files])
    yield "## Malformed inputs"
    yield ""
    yield "Examples, a plan and a recording, spoilt at random: entries, bytes, pieces of YAML, formulas, models,"
    yield "arrays. A malformed one must end in exit status 2, with a printable line for each mistake and no traceback."
    yield ""
    yield from _taste("python benchmarks/malformed.py --seed 1 --inputs 250 --output taste")
    seeds = ", ".join(f"{seed} ({number})" for seed, number in found["seeds"].items())
    yield f"Seeds, and how many malformed inputs each brought: {seeds}."
    yield ""
    yield "| kind | malformed, all refused so | spoilt, but sound | wrong | slowest refusal, CPU time |"
    yield "|---|---|---|---|---|"
    for kind, counts in found["tally"].items():
        numbers = [counts.get(key, 0) for key in ("malformed", "sound", "wrong")]
        slowest = found["slowest_cpu_seconds"][kind]
        yield f"| {kind} | {' | '.join(map(str, numbers))} | {slowest:.2f} s |"
    yield ""
    yield f"{len(found['slow'])} refusals took more than one second of CPU time. {found['commands']} inputs went to the"
    yield "installed command as well."


def _added(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Several campaigns as one."""
    tally: dict[str, Counter[str]] = {kind: Counter() for kind in parts[0]["tally"]}
    for part in parts:
        for kind, counts in part["tally"].items():
            tally[kind].update(counts)
    slowest = [part["slowest_cpu_seconds"] for part in parts]
    return {
        "seeds": {part["seed"]: sum(counts.get("malformed", 0) for counts in part["tally"].values()) for part in parts},
        "tally": tally,
        "slow": [slow for part in parts for slow in part["slow"]],
        "commands": sum(part["commands"] for part in parts),
        "slowest_cpu_seconds": {kind: max(one[kind] for one in slowest) for kind in slowest[0]},
    }


def _rounds_section(output: Path) -> Iterator[str]:
    found = _read(output / "long_run.json")
    if found is None:
        return
    some = found["compared"]
    verdict = "satisfied" if found["satisfied"] else "VIOLATED"
    drifts = "; ".join(found["drifts"]) or "nothing drifts"
    yield "## Many rounds"
    yield ""
    yield from _taste("drake-ltl simulate patrol --suffix-rounds 5")
    yield f"{found['scenario']}, {found['rounds']} rounds of its suffix, {found['simulated_seconds']:.0f} simulated"
    yield f"seconds: {verdict}; {drifts}. Rise of V {found['max_lyapunov_increase']:.1e}, gap of a weld"
    memory = found["largest_memory_mb"]
    yield f"{found['max_weld_error_mm']:.3f} mm, largest memory {memory:.0f} MB, which holds the logs."
    yield ""
    yield f"| | first {some} rounds | last {some} rounds |"
    yield "|---|---|---|"
    least = found["least_clearance"]
    for kind in (kind for kind in least["first"] if kind != "held"):  # that one is a bound, not a distance
        yield f"| clearance {kind.replace('_', ' to ')}, m | {least['first'][kind]:.4f} | {least['last'][kind]:.4f} |"
    lasts = found["seconds_of_a_round"]
    spans = [" to ".join(f"{number:.2f}" for number in lasts[name]) for name in ("first", "last")]
    yield f"| length of a round, s | {' | '.join(spans)} |"
    for key, name in (
        ("cpu_ms_per_simulated_second", "CPU time for a simulated second, ms"),
        ("memory_kb_per_simulated_second", "memory for a simulated second, kB"),
    ):
        yield f"| {name} | {found[key]['first']:.0f} | {found[key]['last']:.0f} |"


def _agreement_section(output: Path) -> Iterator[str]:
    path = output / "agreement.jsonl"
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    found = json.loads(lines[-1]) if lines else {}
    if "problems" not in found:
        return
    yield "## Two methods, one optimum"
    yield ""
    yield from _taste("python benchmarks/agreement.py --problems 3 --seconds 1")
    wrong, reached, proved = (found.get(key, 0) for key in ("disagreements", "optimum reached", "optimal"))
    yield f"{found['problems']} random problems planned by both methods, {wrong} disagreements; within a second the"
    yield f"bounded method reached the optimum of {reached} and proved it of {proved}."


def _sweeps_section(output: Path) -> Iterator[str]:
    found = {name: _read(output / f"sweep_{name}" / "summary.json") for name in SWEEPS}
    if not any(found.values()):
        return
    yield "## Many runs"
    yield ""
    yield "See [sweeps](sweep.md) for what is drawn."
    for name, summary in found.items():
        if summary is not None:
            yield ""
            yield f"`drake-ltl sweep {name} --runs {SWEEPS[name]} --seed 1`:"
            yield ""
            yield "```json"
            yield json.dumps({key: summary[key] for key in ("done", "statuses", "satisfied", "collided")}, indent=2)
            yield "```"


def _taste(command: str) -> Iterator[str]:
    """A part made so small that readers can afford it, and tests can run it."""
    yield "A taste of it:"
    yield ""
    yield "```sh"
    yield command
    yield "```"
    yield ""


if __name__ == "__main__":
    main()
