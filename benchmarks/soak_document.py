"""docs/soak.md, from what the parts of `soak.py` have left in a folder."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SWEEPS = {"patrol": 1000, "case_ii": 100}
"""Example -> runs."""


def document(output: Path) -> Iterator[str]:
    """Its lines: a section for each part of which there are results."""
    yield "# Soak: what takes hours"
    yield ""
    yield "Written by `make soak` (`benchmarks/soak.py`), which takes hours."
    sections = (
        _malformed_section,
        _fuzz_section,
        _interruptions_section,
        _rounds_section,
        _many_runs_section,
        _agreement_section,
        _sweeps_section,
    )
    for section in sections:
        lines = list(section(output))
        if lines:
            yield ""
            yield from lines


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def _malformed_section(output: Path) -> Iterator[str]:
    parts = sorted((_read(file) for file in output.glob("malformed_*.json")), key=lambda part: part["seed"])
    if not parts:
        return
    found = _added(parts)
    yield "## Malformed inputs"
    yield ""
    yield "Examples, a plan and a recording, spoilt at random: entries, bytes, pieces of YAML, formulas, models,"
    yield "arrays. A malformed one must end in exit status 2, with a printable line for each mistake and no traceback."
    yield ""
    yield from _taste("python benchmarks/malformed.py --seed 1 --inputs 250 --commands 1 --output taste")
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
    slow = [row for row in found["slow"] if "command" not in row]
    yield f"{len(slow)} refusals took more than one second of CPU time."
    slow, slowest = len(found["slow"]) - len(slow), found["slowest_cpu_seconds"]["installed command"]
    yield f"{found['commands']} inputs went to the installed command as well, which loads Drake and solvers once a file"
    yield f"is sound as far as can be told without them; {slow} of these took more than a second of CPU time, at"
    yield f"most {slowest:.2f} s."
    if found["wrong"]:
        yield "What was wrong:"
        yield ""
        yield from (f"- {row['input']}: {str(row['wrong'])[:120]}" for row in found["wrong"])


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
        "wrong": [wrong for part in parts for wrong in part["wrong"]],
        "commands": sum(part["commands"] for part in parts),
        "slowest_cpu_seconds": {kind: max(one[kind] for one in slowest) for kind in slowest[0]},
    }


def _fuzz_section(output: Path) -> Iterator[str]:
    rows = [row for row in map(_read, sorted(output.glob("fuzz_*.json"))) if row is not None]
    if not rows:
        return
    yield "## Fuzzing guided by coverage"
    yield ""
    yield "`pip install 'drake-ltl[fuzz]'` (atheris), then `python benchmarks/fuzz.py`. Half of the inputs are spoilt"
    yield "in the same ways, the others are changes of what has reached code that nothing had reached before."
    yield ""
    yield "| kind | inputs | branches reached, at the begin and at the end | wrong |"
    yield "|---|---|---|---|"
    for row in rows:
        before, after = row["coverage"]
        wrong = "one, which ended it" if row["wrong"] else "none"
        yield f"| {row['kind']} | {row['runs']} | {before} to {after} | {wrong} |"


def _interruptions_section(output: Path) -> Iterator[str]:
    found = _read(output / "interruptions.json")
    if found is None:
        return
    yield "## Ctrl-C and full disks"
    yield ""
    yield "`python benchmarks/interruptions.py`: the installed command, interrupted at random moments, or unable to let"
    yield "files grow beyond a random size. Wrong would be a traceback, a hang, a file that is cut off or left behind,"
    yield "a recording that is lost, or a sweep that does not go on to what it comes to undisturbed. What Python itself"
    yield "says while it starts, before the first line of the command, is not the command's."
    yield ""
    yield "| | command | exit statuses, and how often | wrong |"
    yield "|---|---|---|---|"
    for key, name in (("interrupted", "Ctrl-C"), ("full_disk", "full disk")):
        for command, statuses in found[key]["statuses"].items():
            wrong = sum(row["command"] == command for row in found[key]["wrong"])
            told = ", ".join(f"{status} ({times})" for status, times in sorted(statuses.items()))
            yield f"| {name} | `{command}` | {told} | {wrong} |"


def _many_runs_section(output: Path) -> Iterator[str]:
    path = output / "many_runs.jsonl"
    rows = list(map(json.loads, path.read_text(encoding="utf-8").splitlines()[1:])) if path.is_file() else []
    if not rows:
        return
    yield "## Many runs of the two cases and of random missions"
    yield ""
    yield "`python benchmarks/many_runs.py --runs 1000`: starts, gains and masses drawn as in [sweeps](sweep.md),"
    yield "random missions of two to four robots, one or two crates and three or four regions. Each run is watched by"
    yield "the monitors, judged by `verify`, and judged once more from its file by a program that shares no code with"
    yield "either (`benchmarks/second_look.py`). Missions that have no plan, or that `simulate`"
    yield "refuses before it runs them, are drawn anew."
    yield ""
    yield '| mission | runs | satisfied | violated | stalled | others | collisions | false "satisfied" |'
    yield "|---|---|---|---|---|---|---|---|"
    for name in sorted({row["mission"] for row in rows}):
        yield _many_runs_row(name, [row for row in rows if row["mission"] == name])
    bad = [row for row in rows if row["status"] != "satisfied" or row["second_look"] or row["monitored"]]
    if bad:
        yield ""
        yield from (f"- run {row['run']}, {row['mission']}: {row['status']}. {_told(row)}" for row in bad)


def _many_runs_row(name: str, rows: list[dict[str, Any]]) -> str:
    statuses = Counter(row["status"] for row in rows)
    known = [statuses[status] for status in ("satisfied", "violated", "stalled")]
    bodies = ("agent_agent", "agent_object", "object_object", "team_other")
    collided = sum(
        any((row["min_clearance"].get(kind) or 1.0) <= 0.0 for kind in bodies)
        or any("overlap" in finding for finding in (*row["second_look"], *row["monitored"]))
        for row in rows
    )
    false = sum(row["status"] == "satisfied" and bool(row["second_look"] or row["monitored"]) for row in rows)
    return f"| {name} | {' | '.join(map(str, (len(rows), *known, len(rows) - sum(known), collided, false)))} |"


def _told(row: dict[str, Any]) -> str:
    return "; ".join([row["reason"], *row["monitored"], *row["second_look"]])[:300]


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
