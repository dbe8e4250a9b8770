"""What becomes of missions in which something goes wrong: `python benchmarks/faults.py [--write]`.

Every fault is injected into a mission of its own, which is carried out, recovered and judged; the table goes to
standard output, and with `--write` into docs/faults.md.
"""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass
from pathlib import Path

from drake_ltl import mission
from drake_ltl.execution.recovery import FaultRun
from drake_ltl.scenario import loads
from drake_ltl.verification import verify
from drake_ltl.verification.verdict import Verdict

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = (ROOT / "benchmarks" / "missions", ROOT / "examples")
"""Of scenarios."""
PAGE = ROOT / "docs" / "faults.md"
BEGIN, END = "<!-- table of benchmarks/faults.py -->", "<!-- end of the table -->"


HEAD = ("| mission | what goes wrong | noticed | safe mode | then | verdict |", "|---|---|---|---|---|---|")


@dataclass(frozen=True)
class Case:
    """One row."""

    scenario: str
    fault: str
    """An entry of `faults:`."""
    says: str


CASES = (
    Case("relay", "{kind: agent_stops, agent: a2, time: 3.0}", "a2 stops on its way, brakes on"),
    Case("relay", "{kind: agent_stops, agent: a2, time: 3.0, how: limp}", "a2 stops on its way, no torque, no brakes"),
    Case(
        "relay",
        "{kind: agent_stops, agent: a2, time: 3.0, how: limp, friction: 8.0}",
        "the same, with a friction of 8 N s/m",
    ),
    Case("relay", "{kind: agent_stops, agent: a1, time: 1.0}", "a1 stops where it stands; nobody needs it"),
    Case("relay", "{kind: torque_limits, agent: a2, time: 2.0, factor: 0.05}", "a2 has 5 % of its torque"),
    Case("spare_hand", "{kind: agent_stops, agent: a2, time: 1.0}", "a2 stops on its way to the crate"),
    Case("spare_hand", "{kind: agent_stops, agent: a2, step: 2}", "a2 stops while it carries"),
    Case("spare_hand", "{kind: weld_breaks, agent: a2, step: 2}", "the grasp of a2 breaks, near its region"),
    Case("spare_hand", "{kind: weld_breaks, agent: a2, time: 10.5}", "the grasp of a2 breaks at full speed"),
    Case("spare_hand", "{kind: torque_limits, agent: a2, step: 2, factor: 0.02}", "a2 carries with 2 % of its torque"),
    Case(
        "spare_hand", "{kind: push, object: crate, time: 3.0, impulse: [0.3, 0.3]}", "the crate is pushed by 0.42 N s"
    ),
    Case(
        "spare_hand",
        "{kind: mass, object: crate, factor: 1.3}",
        "the crate is 30 % heavier; it is lifted from 8.1 s on",
    ),
    Case("spare_hand", "{kind: mass, object: crate, factor: 0.7}", "the crate is 30 % lighter"),
    Case("spare_hand", "{kind: mass, object: crate, factor: 10.0}", "the crate is ten times as heavy"),
    Case("relay", "{kind: sensors, delay: 0.02}", "all is seen 20 ms late"),
    Case("spare_hand", "{kind: sensors, delay: 0.02}", "all is seen 20 ms late; they start side by side"),
    Case("spare_hand", "{kind: sensors, delay: 0.05}", "all is seen 50 ms late"),
    Case(
        "spare_hand",
        "{kind: sensors, position_noise: 0.0002, velocity_noise: 0.002, delay: 0.01}",
        "noise of 0.2 mm and 2 mm/s, 10 ms late",
    ),
    Case("errand", "{kind: blocked_region, region: yard, time: 1.7}", "the yard is blocked, a1 is on its way there"),
    Case("errand", "{kind: blocked_region, region: yard, time: 2.85}", "the yard is blocked, a1 is about to enter"),
    Case("errand", "{kind: blocked_region, region: shed, time: 2.0}", "the shed is blocked; nobody needs it"),
    Case(
        "haul", "{kind: blocked_region, region: yard, time: 14.0}", "the yard is blocked, the crate is on its way there"
    ),
    Case("spare_hand", "{kind: blocked_region, region: yard, time: 14.0}", "the same; the crate has to come there"),
    Case("fleet", "{kind: agent_stops, agent: a2, time: 3.0}", "a2, a differential drive, stops on its way, brakes on"),
    Case("fleet", "{kind: agent_stops, agent: a2, time: 3.0, how: limp}", "the same, no torque, no brakes"),
    Case(
        "fleet",
        "{kind: agent_stops, agent: a2, time: 3.0, how: limp, friction: 0.1}",
        "the same, wheels that turn with a friction of 0.1 N m s",
    ),
    Case("fleet", "{kind: torque_limits, agent: a2, time: 2.0, factor: 0.1}", "a2 has 10 % of its torque"),
    Case("fleet", "{kind: blocked_region, region: shop, time: 6.0}", "the shop is blocked, a2 is on its way there"),
    Case(
        "fleet",
        "{kind: sensors, position_noise: 0.0002, velocity_noise: 0.002, delay: 0.01}",
        "noise of 0.2 mm and 2 mm/s, 10 ms late",
    ),
    Case("crossing", "{kind: sensors, delay: 0.04}", "drives alone, all is seen 40 ms late"),
    Case("courier", "{kind: push, object: crate, time: 2.0, impulse: [0.3, 0.3]}", "the crate is pushed by 0.42 N s"),
    Case("case_ii", "{kind: agent_stops, agent: a3, time: 20.0}", "a3 stops on its way; nobody else can help"),
    Case("case_ii", "{kind: weld_breaks, agent: a2, step: 3}", "the grasp of a2 breaks while it carries"),
)


def text_of(case: Case) -> str:
    """The scenario with this fault alone."""
    name = f"{case.scenario}.yaml"
    text = next(folder / name for folder in FOLDERS if (folder / name).is_file()).read_text(encoding="utf-8")
    return f"{re.split(r'^faults:', text, flags=re.MULTILINE)[0]}\nfaults:\n  - {case.fault}\n"


def carry_out(case: Case) -> tuple[FaultRun, Verdict]:
    """Planned, carried out and judged."""
    scenario = loads(text_of(case), source_name=case.scenario)
    models = mission.measure(scenario)
    planned = mission.plan_and_place(scenario, models)
    run = mission.simulate(planned, scenario, models, keep_going=True, announce=lambda line: None)
    return run, verify(run.recording, scenario)


def row(case: Case, run: FaultRun, verdict: Verdict) -> str:
    """One line of the table."""
    cells = (case.scenario, case.says, _noticed(run), _safe(run), _on(run), _judged(verdict))
    return f"| {' | '.join(cells)} |"


def _noticed(run: FaultRun) -> str:
    if not run.noticed:
        return "no"
    seen = run.noticed[0].seen
    if not run.happened:
        return f"{seen.monitor}, at {seen.time:.2f} s"
    return f"{seen.monitor}, after {max(seen.time - run.happened[0][0], 0.005):.3g} s"


def _safe(run: FaultRun) -> str:
    halted = [step for step in run.recording.steps if step.halted]
    if not halted:
        return ""
    seconds = run.recording.time[-1] if not halted[0].finished else halted[0].start + halted[0].duration
    column = run.recording.grasp[(run.recording.step == halted[0].number)]
    lets_go = len(column) and bool(((column[0] >= 0) & (column[-1] < 0)).any())
    what = "set down" if lets_go else "held"
    return f"{what} after {float(seconds) - run.noticed[0].seen.time:.1f} s"


def _on(run: FaultRun) -> str:
    if not run.noticed:
        return "went on"
    how = run.noticed[-1].went_on
    return how if len(how) <= 150 else f"{how[:150].rsplit(' ', 1)[0]} .."


def _judged(verdict: Verdict) -> str:
    if verdict.satisfied:
        return "satisfied"
    own = [violation for violation in verdict.violations if violation.kind not in ("run", "monitor")]
    kinds = [violation.what.split(":")[0] for violation in own]
    ended = any(violation.kind == "run" for violation in verdict.violations)
    text = "; ".join(dict.fromkeys(kinds))
    return f"violated: {'ended early' if ended else ''}{'; ' if ended and text else ''}{text}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put the rows into the table of docs/faults.md")
    parser.add_argument("--only", default="", help="cases whose mission or fault contains this")
    args = parser.parse_args()
    print("\n".join(HEAD), flush=True)
    rows: dict[str, str] = {}
    for case in CASES:
        if args.only in f"{case.scenario} {case.fault}":
            rows[key(case)] = row(case, *carry_out(case))
            print(rows[key(case)], flush=True)
    if args.write:
        page = PAGE.read_text(encoding="utf-8")
        before, rest = page.split(BEGIN)
        old, after = rest.split(END)
        rows = {
            **{key(case): line for case in CASES for line in old.splitlines() if line.startswith(key(case))},
            **rows,
        }
        table = "\n".join([*HEAD, *(rows[key(case)] for case in CASES if key(case) in rows)])
        PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


def key(case: Case) -> str:
    """How its row begins."""
    return f"| {case.scenario} | {case.says} |"


if __name__ == "__main__":
    main()
