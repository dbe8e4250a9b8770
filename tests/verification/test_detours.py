"""Steps that were finished one mover after another are named."""

from types import SimpleNamespace

import pytest

from drake_ltl.execution.recording import IntervalRecord, StepRecord
from drake_ltl.scenario import Scenario
from drake_ltl.verification import Verdict, verdict_table
from drake_ltl.verification.detours import WORDS, detoured_steps


def travel(*agents):
    return tuple({"kind": "travel", "agents": (a,), "object": None, "from": "p", "to": "q"} for a in agents)


CARRY = ({"kind": "transport", "agents": ("a2", "a3"), "object": "o1", "from": "p", "to": "q"},)
GRASP = ({"kind": "grasp", "agents": ("a1",), "object": "o1", "from": "p", "to": "p"},)


def recording(actions, *moving):
    """One step; for each interval the names of what moves."""
    intervals = tuple(
        IntervalRecord(0, phase, {n: () for n in names if n[0] == "a"}, {n: () for n in names if n[0] == "o"}, (), {})
        for phase, names in enumerate(moving)
    )
    return SimpleNamespace(steps=(StepRecord(0, actions, 0.0, 1.0, True),), intervals=intervals)


@pytest.mark.parametrize(
    ("actions", "moving", "found"),
    [
        (travel("a1", "a2"), [["a1", "a2"]], ()),
        (travel("a1", "a2"), [["a1", "a2"], ["a2"], ["a2"], ["a1"]], (0,)),
        (travel("a1", "a2"), [["a1", "a2"], ["a1", "a2"], []], ()),  # an approach was corrected, grasps came last
        (travel("a1") + CARRY, [["a1", "o1"]], ()),
        (travel("a1") + CARRY, [["a1", "o1"], ["o1"]], (0,)),
        (GRASP + CARRY, [["o1"]], ()),
        (GRASP, [[]], ()),
    ],
)
def test_a_step_in_which_some_moved_alone_is_a_detour(actions, moving, found):
    assert detoured_steps(recording(actions, *moving)) == found


def test_the_table_says_so(capsys):
    from rich.console import Console

    step = StepRecord(0, travel("a1", "a2"), 0.0, 1.0, True)
    scenario = Scenario("s", 1.0, (), (), ())
    kinds = ("agent_agent", "agent_object", "object_object", "team_other", "forbidden_region", "workspace")
    texts = []
    for detours in ((), (0,)):
        verdict = Verdict(True, (), (), (step,), dict.fromkeys(kinds), 0.0, 0.0, 0.0, 0.0, 1.0, detours)
        console = Console(width=200)
        console.print(verdict_table(verdict, scenario))
        texts.append(capsys.readouterr().out)

    assert WORDS not in texts[0]
    assert WORDS in texts[1]
