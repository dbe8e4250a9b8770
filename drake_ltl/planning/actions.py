"""From two consecutive states to the actions between them, and back."""

from __future__ import annotations

from collections.abc import Iterable

from drake_ltl.planning.plan import Action, State
from drake_ltl.scenario.model import Scenario


def actions_between(scenario: Scenario, before: State, after: State) -> tuple[Action, ...]:
    """The actions of a transition of Def. 5, in the order of the scenario's agents; a transport stands once.

    Agents that do nothing, or merely keep hold of an object that stays, have none.
    """
    places_before = dict(zip(scenario.object_names, before.objects, strict=True))
    places_after = dict(zip(scenario.object_names, after.objects, strict=True))
    actions: list[Action] = []
    for i, agent in enumerate(scenario.agent_names):
        start, goal = before.agents[i], after.agents[i]
        held, holds = before.grasps[i], after.grasps[i]
        if held is None and holds is not None:
            actions.append(Action("grasp", (agent,), start, start, holds))
        elif held is not None and holds is None:
            actions.append(Action("release", (agent,), start, start, held))
        elif held is None and start != goal:
            actions.append(Action("travel", (agent,), start, goal))
        elif held is not None and places_before[held] != places_after[held]:
            pairs = zip(scenario.agent_names, before.grasps, strict=True)
            team = tuple(name for name, grasp in pairs if grasp == held)
            if agent == team[0]:
                actions.append(Action("transport", team, places_before[held], places_after[held], held))
    return tuple(actions)


def apply_actions(scenario: Scenario, state: State, actions: Iterable[Action]) -> State:
    """The state after some actions that begin together."""
    agents = dict(zip(scenario.agent_names, state.agents, strict=True))
    objects = dict(zip(scenario.object_names, state.objects, strict=True))
    grasps = dict(zip(scenario.agent_names, state.grasps, strict=True))
    for action in actions:
        for agent in action.agents:
            agents[agent] = action.goal
            if action.kind in ("grasp", "release"):
                grasps[agent] = action.object if action.kind == "grasp" else None
        if action.kind == "transport" and action.object is not None:
            objects[action.object] = action.goal
    return State(tuple(agents.values()), tuple(objects.values()), tuple(grasps.values()))
