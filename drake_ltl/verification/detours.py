"""Steps in which movers had stalled, on a saddle or in a crowd, and then went on one by one."""

from __future__ import annotations

from drake_ltl.execution.recording import Recording

WORDS = "stalled, then one after another"


def detoured_steps(recording: Recording) -> tuple[int, ...]:
    """Numbers of the steps with an interval in which not all movers of the step move, though some do."""
    movers = [
        sum(
            len(action["agents"]) if action["kind"] == "travel" else action["kind"] == "transport" for action in actions
        )
        for actions in (step.actions for step in recording.steps)
    ]
    counts = ((interval.step, len(interval.travels) + len(interval.transports)) for interval in recording.intervals)
    return tuple(sorted({step for step, count in counts if step < len(movers) and 0 < count < movers[step]}))
