"""Programs with a mistake in them carry missions out: who notices? `python benchmarks/mutants.py [--write]`.

Each mistake is put into the program for one short run, which goes on whatever monitors see. The table goes to standard
output, and with `--write` into docs/monitors.md. Tests demand the same (tests/execution/test_mutants.py).
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from unittest.mock import patch

import second_look
from drake_ltl.diagrams import mission_diagram

from drake_ltl import mission
from drake_ltl.execution import runner
from drake_ltl.execution.recording import Recording
from drake_ltl.scenario import loads
from drake_ltl.systems import arrival, mission_controller, orders, program, step_field
from drake_ltl.verification import verify

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "monitors.md"
BEGIN, END = "<!-- table of benchmarks/mutants.py -->", "<!-- end of the table -->"
SECONDS = 12.0
"""Of each run: in half of that the sound ones are done with what the mistakes are in."""
FORMULAS = {
    "apart": (("X", ("is", "a1", "nw")), ("X", ("is", "a2", "ne"))),
    "fetch": (("F", ("is", "o1", "pi2")),),
}
"""Of the missions, as trees."""


@dataclass(frozen=True)
class Mutant:
    """A mistake, the mission in which it is made, and how."""

    says: str
    mission: str
    mistake: Callable[[], AbstractContextManager] = nullcontext
    planned_for: tuple[str, str] = ("", "")
    """What the planner reads in place of what in the scenario's text."""


@dataclass(frozen=True)
class Noticed:
    """What each of the three says of a run: kinds of violations, or findings."""

    monitors: tuple[str, ...]
    verdict: tuple[str, ...]
    second_look: tuple[str, ...]


def swapped(agent: str, start: str, goal: str, q_goal, right=program.TravelTask):
    """Each drives to where the other should, mirrored by x = 0; nothing else is wrong with the run."""
    other = {"nw": "ne", "ne": "nw"}.get(goal, goal)
    return right(agent, start, other, q_goal * [-1.0 if other != goal else 1.0, 1.0, *[1.0] * (len(q_goal) - 2)])


def uphill(*args, right=mission_controller.evaluate_field):
    """Movers are driven away from their goals."""
    value = right(*args)
    signs = {field: {name: -slope for name, slope in getattr(value, field).items()} for field in ("agents", "objects")}
    return dataclasses.replace(value, **signs)


def leave_open(mission_diagram, root_context, *_):
    """The supervisor is told that welds are closed."""
    supervisor = mission_diagram.supervisor
    supervisor.acknowledge(supervisor.GetMyMutableContextFromRoot(root_context))


def share(factor: float, agent: str, rows: slice, share: float, spring, right=orders.Carrier):
    """Shares that are checked to sum to one act as if they summed to another number."""
    return right(agent, rows, factor * share, spring)


def without_pairs(*args, right=step_field.step_relations, **more):
    """The potential knows nothing of pairs of movers."""
    step = right(*args, **more)
    apart = tuple(pair for pair in step.relations.apart if max(pair.a, pair.b) >= step.n_movers)
    return dataclasses.replace(step, relations=dataclasses.replace(step.relations, apart=apart))


def without_first_step(*args, right=mission_diagram.mission_program):
    """The run does in the first step what it should do in the second."""
    whole = right(*args)
    return dataclasses.replace(whole, steps=(whole.steps[1], *whole.steps[1:]))


def content(models, scenario, right=arrival.Arrival.of):
    """Whoever is within 5 m of a place has come there."""
    easy = dataclasses.replace(scenario.tolerances, position=5.0, joint=3.0, speed=10.0)
    return right(models, dataclasses.replace(scenario, tolerances=easy))


NONE = Mutant("nothing", "apart")
MUTANTS = (
    Mutant("two robots' goals are swapped", "apart", partial(patch.object, program, "TravelTask", swapped)),
    Mutant(
        "the gradient has the wrong sign", "apart", partial(patch.object, mission_controller, "evaluate_field", uphill)
    ),
    Mutant("a weld is left open", "fetch", partial(patch.object, runner, "ApplyGrasps", leave_open)),
    Mutant("the planner negates a formula", "apart", planned_for=('"X nw"', '"!(X nw)"')),
    Mutant("a team lifts 1.3 times its load", "fetch", partial(patch.object, orders, "Carrier", partial(share, 1.3))),
    Mutant("a team lifts 0.7 times its load", "fetch", partial(patch.object, orders, "Carrier", partial(share, 0.7))),
    Mutant(
        "the potential lacks pairs of movers",
        "apart",
        partial(patch.object, step_field, "step_relations", without_pairs),
    ),
    Mutant(
        "a step of the plan is left out",
        "apart",
        partial(patch.object, mission_diagram, "mission_program", without_first_step),
    ),
    Mutant("5 m off is there", "apart", partial(patch.object, arrival.Arrival, "of", content)),
)


def carry_out(mutant: Mutant) -> Recording:
    """Until the mission is done, or time is over."""
    text = (ROOT / "benchmarks" / "missions" / f"{mutant.mission}.yaml").read_text(encoding="utf-8")
    scenario = loads(text)
    models = mission.measure(scenario)

    def report(progress) -> None:
        if progress.time >= SECONDS:
            raise KeyboardInterrupt

    with mutant.mistake():
        planned = mission.plan_and_place(loads(text.replace(*mutant.planned_for)), models)
        return mission.simulate(planned, scenario, models, keep_going=True, report=report).recording


def noticed(recording: Recording, formulas: tuple) -> Noticed:
    """By the monitors while it went on, by the verdict, and by the second look."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        recording.save(path)
        looked = second_look.findings(path, formulas)
    kinds = [violation.kind for violation in verify(recording).violations if violation.kind != "monitor"]
    return Noticed(
        *(tuple(dict.fromkeys(found)) for found in ([s.monitor for s in recording.monitored], kinds, looked))
    )


def row(mutant: Mutant) -> str:
    """One line of the table."""
    try:
        found = noticed(carry_out(mutant), FORMULAS[mutant.mission])
    except ValueError as error:
        return f"| {mutant.says} | the program itself: {error} | | |"
    cells = (", ".join(found.monitors) or "nothing", ", ".join(found.verdict) or "nothing")
    return f"| {mutant.says} | {' | '.join(cells)} | {found.second_look[0] if found.second_look else 'nothing'} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put the table into docs/monitors.md")
    args = parser.parse_args()
    lines = ["| mistake | monitors | verdict | second look, the first of its findings |", "|---|---|---|---|"]
    lines += map(row, (NONE, *MUTANTS))
    print("\n".join(lines))
    if args.write:
        before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
        table = "\n".join(lines)
        PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
