"""The first state of every run."""

from __future__ import annotations

from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import Starts


def initial_state(scenario: Scenario, starts: Starts) -> State:
    """pi_s,init of Def. 5: every member in the region in which it starts, nobody grasping."""
    return State(
        agents=tuple(starts.agents[name].region for name in scenario.agent_names),
        objects=tuple(starts.objects[name].region for name in scenario.object_names),
        grasps=(None,) * len(scenario.agents),
    )
