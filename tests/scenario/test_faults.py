"""The block `faults:`: what it means, and one clear line for each mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import loads
from drake_ltl.scenario.faults import KINDS, Fault

CASE_II = (Path(__file__).parents[2] / "examples" / "case_ii.yaml").read_text(encoding="utf-8")


def faults(*entries: str) -> tuple[Fault, ...]:
    return loads("\n".join([CASE_II, "faults:", *(f"  - {entry}" for entry in entries)])).faults


def mistakes(*entries: str) -> list[str]:
    with pytest.raises(InvalidInputError) as caught:
        faults(*entries)
    return [str(mistake) for mistake in caught.value.mistakes]


def test_without_the_block_nothing_goes_wrong():
    assert loads(CASE_II).faults == ()


def test_every_kind_is_read():
    found = faults(
        "{kind: agent_stops, agent: a1, time: 3}",
        "{kind: torque_limits, agent: a2, step: 2, factor: 0.5}",
        "{kind: weld_breaks, agent: a3, time: 0}",
        "{kind: push, object: o1, step: 1, impulse: [1, -2]}",
        "{kind: mass, object: o2, factor: 0.7}",
        "{kind: blocked_region, region: pi2, time: 4}",
        "{kind: sensors, delay: 0.01}",
    )
    assert {fault.kind for fault in found} == set(KINDS)
    assert found[0] == Fault("agent_stops", "a1", time=3.0, values={"how": "locked", "friction": 0.0})
    assert found[1] == Fault("torque_limits", "a2", step=2, values={"factor": 0.5})
    assert found[3].values == {"impulse": (1.0, -2.0)}
    assert (found[4].time, found[4].step) == (None, None)
    assert found[5] == Fault("blocked_region", "pi2", time=4.0)
    assert found[6].values == {"position_noise": 0.0, "velocity_noise": 0.0, "delay": 0.01}


@pytest.mark.parametrize(
    ("entry", "where", "says"),
    [
        ("{kind: agent_stop, agent: a1, time: 3}", "faults[0].kind", "did you mean `agent_stops`?"),
        ("{agent: a1}", "faults[0].kind", "is missing"),
        ("{kind: agent_stops, agent: o1, time: 3}", "faults[0].agent", "there is no agent 'o1'"),
        ("{kind: push, object: a1, time: 3, impulse: [1, 0]}", "faults[0].object", "there is no object 'a1'"),
        ("{kind: agent_stops, time: 3}", "faults[0].agent", "is missing"),
        ("{kind: agent_stops, agent: a1}", "faults[0]", "neither `time` nor `step`"),
        ("{kind: agent_stops, agent: a1, time: 3, step: 2}", "faults[0]", "both `time` and `step`"),
        ("{kind: agent_stops, agent: a1, time: -1}", "faults[0].time", "is not zero or a positive number"),
        ("{kind: agent_stops, agent: a1, step: 0}", "faults[0].step", "is not a whole number of at least 1"),
        ("{kind: agent_stops, agent: a1, time: 1, how: wild}", "faults[0].how", "write one of locked, limp"),
        ("{kind: agent_stops, agent: a1, time: 1, friction: 3}", "faults[0].friction", "is of no use where brakes"),
        ("{kind: torque_limits, agent: a1, time: 1, factor: 1.5}", "faults[0].factor", "is too large"),
        ("{kind: push, object: o1, time: 1, impulse: [0, 0]}", "faults[0].impulse", "is no push"),
        ("{kind: push, object: o1, time: 1, impulse: [1e6, 0]}", "faults[0].impulse", "is no push"),
        ("{kind: mass, object: o1, factor: 1.3, time: 2}", "faults[0].time", "is not a known key"),
        ("{kind: blocked_region, region: pi9, time: 2}", "faults[0].region", "there is no region 'pi9'"),
        ("{kind: blocked_region, region: a1, time: 2}", "faults[0].region", "known regions: pi1, pi2, pi3"),
        ("{kind: blocked_region, region: [pi1], time: 2}", "faults[0].region", "is not"),
        ("{kind: blocked_region, time: 2}", "faults[0].region", "is missing"),
        ("{kind: blocked_region, region: pi1}", "faults[0]", "neither `time` nor `step`"),
        ("{kind: blocked_region, region: pi1, agent: a1, time: 2}", "faults[0].agent", "is not a known key"),
        ("{kind: blocked_regions, region: pi1, time: 2}", "faults[0].kind", "did you mean `blocked_region`?"),
        ("{kind: sensors}", "faults[0]", "changes nothing"),
        ("{kind: sensors, delay: 1}", "faults[0].delay", "is too large"),
        ("7", "faults[0]", "is not a map"),
    ],
)
def test_a_mistake_is_one_line(entry, where, says):
    (line,) = mistakes(entry)
    assert line.startswith(f"{where}: ")
    assert says in line
    assert "\n" not in line


def test_all_mistakes_are_found_at_once():
    assert len(mistakes("{kind: sensors}", "{kind: nothing}", "7")) == 3


def test_measurements_are_spoken_of_once():
    (line,) = mistakes("{kind: sensors, delay: 0.1}", "{kind: sensors, delay: 0.2}")
    assert "stands twice" in line


def test_it_is_a_list_of_reasonable_length():
    with pytest.raises(InvalidInputError, match="faults: 7 is not a list"):
        loads(f"{CASE_II}\nfaults: 7")
    (line,) = mistakes(*["{kind: mass, object: o1, factor: 1.1}"] * 101)
    assert "too many" in line


def test_objects_that_are_turned_are_refused():
    text = CASE_II.replace("    power_needed: 5", "    headings: {pi1: 1.0}\n    power_needed: 5")
    with pytest.raises(InvalidInputError, match=r"faults: .* cannot turn objects, and o1 has `headings`"):
        loads(f"{text}\nfaults:\n  - {{kind: mass, object: o1, factor: 1.1}}")
