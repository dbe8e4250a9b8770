"""Plans as JSON: the contract of `drake-ltl plan --json`, and back."""

from __future__ import annotations

from typing import Any

from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.scenario.model import Scenario

COUNTS = ("ts_states", "ts_transitions", "automaton_states", "automaton_edges", "product_states")
SECONDS = ("transition_system", "automaton", "search", "total")


def plan_to_json(plan: Plan, scenario: Scenario) -> dict[str, Any]:
    """A plan in plain types.

    `steps[l]` are the actions that lead from state l to state l + 1 of prefix + suffix; the last ones lead back to
    the first state of the suffix. The weights `alpha` and `beta` of the costs are written where they are not 1.
    """
    weights = {"alpha": plan.alpha, "beta": plan.beta}
    return {
        "scenario": scenario.name,
        "status": plan.status,
        "prefix_cost": plan.prefix_cost,
        "suffix_cost": plan.suffix_cost,
        "cost": plan.cost,
        **({} if plan.alpha == plan.beta == 1.0 else weights),
        "lower_bound": plan.lower_bound,
        "prefix": [state_to_json(state, scenario) for state in plan.prefix],
        "suffix": [state_to_json(state, scenario) for state in plan.suffix],
        "steps": [[action_to_json(action) for action in actions] for actions in plan.moves],
        "counts": {key: plan.counts.get(key) for key in COUNTS},
        "seconds": {key: plan.seconds.get(key) for key in SECONDS},
    }


def no_plan_json(scenario: Scenario, status: str = "infeasible") -> dict[str, Any]:
    """What is written where there is no plan: `status` is `infeasible` or `unknown`, all else null."""
    keys = ("prefix_cost", "suffix_cost", "cost", "lower_bound", "prefix", "suffix", "steps")
    return {
        "scenario": scenario.name,
        "status": status,
        **dict.fromkeys(keys),
        "counts": dict.fromkeys(COUNTS),
        "seconds": dict.fromkeys(SECONDS),
    }


def state_to_json(state: State, scenario: Scenario) -> dict[str, Any]:
    """{"agents": {a1: pi1}, "objects": {o1: pi2}, "grasps": {a1: null}}"""
    agents, objects = scenario.agent_names, scenario.object_names
    return {
        "agents": dict(zip(agents, state.agents, strict=True)),
        "objects": dict(zip(objects, state.objects, strict=True)),
        "grasps": dict(zip(agents, state.grasps, strict=True)),
    }


def action_to_json(action: Action) -> dict[str, Any]:
    """{"kind": "transport", "agents": [a2, a3], "object": o2, "from": pi1, "to": pi3}"""
    return {
        "kind": action.kind,
        "agents": list(action.agents),
        "object": action.object,
        "from": action.start,
        "to": action.goal,
    }
