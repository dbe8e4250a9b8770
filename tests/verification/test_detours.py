"""Steps that were finished by way of detours are named."""

from types import SimpleNamespace

import pytest

from drake_ltl.execution.recording import IntervalRecord, StepRecord
from drake_ltl.scenario import Scenario
from drake_ltl.verification import Verdict, verdict_table
from drake_ltl.verification.detours import EXCHANGED, WORDS, detoured_steps, exchanged_steps

TRAVEL = {"kind": "travel", "agents": ("a1",), "object": None, "from": "p", "to": "q"}


def recording(*moving):
    """One step; for each interval what moves, and where to."""
    intervals = tuple(
        IntervalRecord(
            0,
            phase,
            {name: (x,) for name, x in goals.items() if name[0] == "a"},
            {name: (x,) for name, x in goals.items() if name[0] == "o"},
            (),
            {},
        )
        for phase, goals in enumerate(moving)
    )
    return SimpleNamespace(intervals=intervals)


@pytest.mark.parametrize(
    ("moving", "found"),
    [
        ([{"a1": 1.0, "o1": 2.0}], ()),
        ([{"a1": 1.0, "a2": 2.0}, {"a2": 2.0}, {"a1": 1.0}], (0,)),
        ([{"a1": 1.0}, {"a1": 0.5}, {"a1": 1.0}], (0,)),  # alone, by way of a point
        ([{"o1": 1.0}, {"o1": 0.5}, {"o1": 1.0}], (0,)),
        ([{"a1": 1.0}, {"a1": 1.0}, {}], ()),  # an approach was corrected, grasps came last
        ([{}], ()),
        ([], ()),
    ],
)
def test_a_step_in_which_somebody_took_another_way_is_a_detour(moving, found):
    assert detoured_steps(recording(*moving)) == found


@pytest.mark.parametrize(
    ("moving", "found"),
    [
        ([{"a1": 1.0, "a2": 2.0}, {"a1": 2.0, "a2": 1.0}], (0,)),
        ([{"a1": 1.0, "a2": 2.0}, {"a2": 2.0}, {"a1": 2.0, "a2": 1.0}], (0,)),  # between them, one went alone
        ([{"a1": 1.0, "a2": 2.0}, {"a1": 1.0, "a2": 2.0}], ()),
        ([{"a1": 1.0}, {"a1": 0.5}, {"a1": 1.0}], ()),
        ([{"a1": 1.0, "a2": 2.0}, {"a2": 2.0}], ()),
    ],
)
def test_a_step_in_which_places_were_exchanged_is_named_so(moving, found):
    assert exchanged_steps(recording(*moving)) == found


def test_who_exchanged_places_was_not_led_around():
    assert detoured_steps(recording({"a1": 1.0, "a2": 2.0}, {"a1": 2.0, "a2": 1.0})) == ()


def test_the_table_says_so(capsys):
    from rich.console import Console

    step = StepRecord(0, (TRAVEL,), 0.0, 1.0, True)
    scenario = Scenario("s", 1.0, (), (), ())
    kinds = ("agent_agent", "agent_object", "object_object", "team_other", "forbidden_region", "workspace")
    texts = []
    for detours, exchanges in (((), ()), ((0,), ()), ((), (0,))):
        verdict = Verdict(
            True, (), (), (step,), dict.fromkeys(kinds), 0.0, 0.0, 0.0, 0.0, 1.0, detours, exchanges=exchanges
        )
        console = Console(width=200)
        console.print(verdict_table(verdict, scenario))
        texts.append(capsys.readouterr().out)

    assert WORDS not in texts[0]
    assert WORDS in texts[1]
    assert EXCHANGED not in texts[1]
    assert EXCHANGED in texts[2]
