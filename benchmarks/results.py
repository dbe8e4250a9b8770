"""The paper's two cases against ours: python benchmarks/results.py --document docs/results.md

Plans, checks the paper's own plans, carries both missions out, and puts three tables into the document. Planning is
measured with all libraries loaded, the least of several times; missions in seconds of one core.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import drake_ltl
from drake_ltl.planning.table import action_text

RUNS = 7
PAPER = {  # TS states and transitions, BA states and edges, product states; seconds for TS, for product and path
    "case_i": (560, 7680, 7, 29, 3920, 3.19, 2.79),
    "case_ii": (3112, 154960, 9, 49, 28008, 100.74, 4573.89),
}
TABLE_1 = (
    "a2: pi3 -> pi1",
    "a1 grasps o2; a2 grasps o2",
    "{a1, a2} carry o2: pi1 -> pi4",
    "{a1, a2} carry o2: pi4 -> pi1",
    "a1 releases o2; a2 releases o2",
    "a1: pi1 -> pi2; a2: pi1 -> pi2",
    "a1 grasps o1; a2 grasps o1",
    "{a1, a2} carry o1: pi2 -> pi4",
    "a1 releases o1; a2 releases o1",
    "a2: pi4 -> pi3",
    "a1: pi4 -> pi1; a2: pi3 -> pi1",
    "a1 grasps o2; a2 grasps o2",
    "{a1, a2} carry o2: pi1 -> pi2",
    "a1 releases o2; a2 releases o2",
    "a1: pi2 -> pi4; a2: pi2 -> pi4",
    "a1 grasps o1; a2 grasps o1",
    "{a1, a2} carry o1: pi4 -> pi1",
    "{a1, a2} carry o1: pi1 -> pi4",
    "a2 releases o1",
    "a2: pi4 -> pi3",
    "a2: pi3 -> pi4",
    "a2 grasps o1",
    "{a1, a2} carry o1: pi4 -> pi1",
    "{a1, a2} carry o1: pi1 -> pi4",
    "a2 releases o1",
)
TABLE_2 = (
    "a1: pi1 -> pi2; a2: pi3 -> pi1; a3: pi4 -> pi1",
    "a2 grasps o2; a3 grasps o2",
    "{a2, a3} carry o2: pi1 -> pi3",
    "a3 releases o2",
    "a3: pi3 -> pi2",
    "a1 grasps o1; a3 grasps o1",
    "{a1, a3} carry o1: pi2 -> pi1",
    "{a1, a3} carry o1: pi1 -> pi4",
    "{a1, a3} carry o1: pi4 -> pi1",
    "{a1, a3} carry o1: pi1 -> pi4",
    "{a1, a3} carry o1: pi4 -> pi1",
)
PUBLISHED = {"case_i": (TABLE_1, 19), "case_ii": (TABLE_2, 9)}
"""The plans of its Tables 1 and 2, with what is misprinted there put right: actions, and steps of the prefix."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--document", type=Path, help="put the tables into this document, between their marks")
    args = parser.parse_args()
    tables = {"plans": plans(), "steps": steps(), "missions": missions()}
    for name, rows in tables.items():
        text = markdown(rows)
        print(f"\n{text}")
        if args.document:
            write_into(args.document, name, text)


def plans() -> list[Sequence[str]]:
    """Sizes, times and costs."""
    rows: list[Sequence[str]] = [("", "case (i), paper", "case (i), here", "case (ii), paper", "case (ii), here")]
    columns = [column for case in PAPER for column in columns_of(case)]
    names = ("TS states", "TS transitions", "BA states", "BA edges", "product states", "TS [s]", "automata, search [s]")
    names += ("J of the plan", "steps, of these in the loop")
    return rows + list(zip(names, *columns, strict=True))


def columns_of(case: str) -> Iterator[tuple[str, ...]]:
    """The paper's, then ours."""
    scenario = drake_ltl.load(case)
    found = [drake_ltl.plan(scenario) for _ in range(RUNS)]
    actions, prefix = PUBLISHED[case]
    theirs = drake_ltl.own_plan(scenario, prefix=actions[:prefix], suffix=actions[prefix:])
    ours = found[0]
    *sizes, ts, search = PAPER[case]
    yield (*(f"{size:,}" for size in sizes), f"{ts:g}", f"{search:g}", *lengths(theirs))
    counts = ("ts_states", "ts_transitions", "automaton_states", "automaton_edges", "product_states")
    ts = min(plan.seconds["transition_system"] for plan in found)
    rest = min(plan.seconds["automaton"] + plan.seconds["search"] for plan in found)
    yield (*(f"{ours.counts[key]:,}" for key in counts), f"{ts:.3f}", f"{rest:.3f}", *lengths(ours))


def lengths(plan: drake_ltl.Plan) -> tuple[str, str]:
    least = " (least)" if plan.status == "optimal" else ""
    return f"{plan.cost:g}{least}", f"{len(plan.moves)}, {len(plan.suffix)}"


def steps() -> list[Sequence[str]]:
    """Case (ii), side by side."""
    scenario = drake_ltl.load("case_ii")
    plan, (theirs, prefix) = drake_ltl.plan(scenario), PUBLISHED["case_ii"]
    ours = ["; ".join(action_text(action) for action in actions) for actions in plan.moves]
    starred = [
        [f"{text}{' *' if number >= loop else ''}".replace("->", "→") for number, text in enumerate(texts)]
        for texts, loop in ((theirs, prefix), (ours, plan.loop))
    ]
    longest = max(map(len, starred))
    columns = [texts + [""] * (longest - len(texts)) for texts in starred]
    return [
        ("step", "paper, Table 2", "here"),
        *((str(n), *row) for n, row in enumerate(zip(*columns, strict=True), 1)),
    ]


def missions() -> list[Sequence[str]]:
    """Both carried out, with one round of the loop."""
    columns = []
    for case in PAPER:
        scenario = drake_ltl.load(case)
        began = time.process_time()
        run = drake_ltl.simulate(scenario)
        seconds, verdict = time.process_time() - began, drake_ltl.verify(run)
        least = verdict.min_clearance
        columns.append(
            (
                "SATISFIED" if verdict.satisfied else "VIOLATED",
                f"{verdict.simulated_seconds:.1f} s in {len(verdict.steps)} steps",
                f"{seconds:.0f} s; {verdict.simulated_seconds / run.cpu_seconds:.0f} times as fast as real time",
                f"{1e3 * least['agent_agent']:.0f} mm",
                f"{1e3 * least['agent_object']:.0f} mm",
                f"{least['forbidden_region']:.1f} m",
                f"{1e3 * verdict.min_inside_teams:.0f} mm",
                f"{verdict.max_lyapunov_increase:.1g}",
                f"{1e3 * verdict.max_weld_error:.2f} mm",
                f"{100 * max(verdict.max_effort.values()):.0f} %",
            )
        )
    names = ("verdict", "simulated", "loaded, planned, placed and simulated in", "least clearance between robots")
    names += ("between robots and objects", "of movers to other regions", "between bodies inside teams")
    names += ("largest rise of V, relative", "largest gap of a weld", "largest torque, of its limit")
    return [("", "case (i)", "case (ii)"), *zip(names, *columns, strict=True)]


def markdown(rows: Sequence[Sequence[str]]) -> str:
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def write_into(document: Path, name: str, text: str) -> None:
    """Between the marks of that name."""
    start, end = f"<!-- {name}: python benchmarks/results.py --document docs/results.md -->", f"<!-- end of {name} -->"
    before, found, rest = document.read_text(encoding="utf-8").partition(start)
    _, ended, after = rest.partition(end)
    if not (found and ended):
        raise SystemExit(f"{document}: no lines {start!r} and {end!r}")
    document.write_text(f"{before}{start}\n\n{text}\n\n{end}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
