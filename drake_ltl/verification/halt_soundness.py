"""Whether steps were halted by faults of the scenario: by some that had happened, as often as these can be noticed.

Much is excused in a step that a fault has halted. How a run goes on after faults (`execution.recovery`) bounds how
often that can be.
"""

from __future__ import annotations

from collections.abc import Iterator

from drake_ltl.errors import Mistake
from drake_ltl.execution.recording import Recording, StepRecord
from drake_ltl.scenario.faults import Fault
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.table import listing
from drake_ltl.verification.befallen import NAMELESS, since

NOTICES = 2
"""As often a fault halts steps that is none of an agent: a load may be weighed on the floor, and again in the air.
Agents are out of service, or grasp nothing any more, once something of them has been noticed."""
SAME_TIME = 1e-9
"""Times this close [s] are one."""
_REMEDY = "make a new recording with `simulate`"


def halt_mistakes(recording: Recording, scenario: Scenario) -> Iterator[Mistake]:
    """Halts for which there is no cause, or none any more, of a recording whose steps are sound."""
    agents, named = set(recording.agents), set[str]()
    without_agent: list[bool] = []  # of halts that name no agent: whether they name something
    for record in recording.steps:
        where = f"recording.steps.{record.number}"
        if acting := _acting(record) & named:
            yield Mistake(where, f"{listing(sorted(acting))} cannot grasp or carry after an earlier fault", _REMEDY)
        if not record.halted:
            continue
        causes = [fault for fault in scenario.faults if _may_halt(fault, record, recording)]
        befallen = agents.intersection(record.faulty)
        without_agent += [bool(record.faulty)] * (not befallen)
        if not causes:
            end = record.start + record.duration
            yield Mistake(where, f"was halted by a fault at {end:.6g} s, and no fault had happened", _REMEDY)
        elif again := sorted(befallen & named):
            what = f"was halted by a fault of {listing(again)}, which an earlier one had befallen"
            yield Mistake(where, what, _REMEDY)
        elif not befallen and (count := without_agent.count(bool(record.faulty))) > (most := NOTICES * len(causes)):
            what = f"is halt {count} by faults of no agent, which can be noticed {most} times"
            yield Mistake(where, what, _REMEDY)
        if recording.completed and record.number >= recording.prefix_length:
            yield Mistake(where, "was halted by a fault, and is one of those that repeat for ever", _REMEDY)
        named |= befallen


def _may_halt(fault: Fault, record: StepRecord, recording: Recording) -> bool:
    """Whether it had happened by the step's end, and is of somebody if somebody is named: noise is of everybody."""
    fits = fault.kind in NAMELESS if not record.faulty else fault.kind != "blocked_region"
    return fits and since(fault, recording) <= record.start + record.duration + SAME_TIME


def _acting(record: StepRecord) -> set[str]:
    """Who grasps or carries."""
    return {name for action in record.actions if action["kind"] in ("grasp", "transport") for name in action["agents"]}
