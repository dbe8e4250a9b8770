"""A plan's own check, in plain Python: shares no code with the search and trusts none of its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from drake_ltl.errors import CertificateError
from drake_ltl.planning.actions import apply_actions
from drake_ltl.planning.costs import Chi, path_cost, sum_of_ways
from drake_ltl.planning.fits import Content, Fits, content_of
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.planning.words import letter_of, satisfies
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario

RELATIVE_TOLERANCE = 1e-9
"""For sums of the same costs in another order."""


def check(
    plan: Plan,
    scenario: Scenario,
    start: State,
    fits: Fits,
    can_carry: CanCarry | None = None,
    chi: Chi | None = None,
    seen: Sequence[State] = (),
) -> None:
    """Check that a plan is what it says: a run of TS from `start` that satisfies the formula at the stated cost.

    Args:
        plan: the plan.
        scenario: the problem.
        start: the initial state.
        fits: P_s.
        can_carry: Lambda; None takes the sum rule.
        chi: cost of a transition; None takes the scenario's.
        seen: states that were passed before `start`; the word begins with theirs.

    Raises:
        CertificateError: names the first thing that does not hold.
    """
    can_carry, chi = can_carry or sum_rule(scenario), chi or sum_of_ways(scenario)
    _check_shape(plan, start)
    run = (*plan.states, plan.suffix[0])
    for step, (before, after) in enumerate(pairwise(run)):
        fault = state_fault(scenario, before, fits) if step == 0 else None  # later ones were reached by a step
        fault = fault or state_fault(scenario, after, fits) or _step_fault(scenario, before, after, fits, can_carry)
        if fault is None and apply_actions(scenario, before, plan.moves[step]) != after:
            fault = f"the actions {plan.moves[step]} do not lead there"
        if fault is not None:
            raise CertificateError(f"step {step + 1}, from {before} to {after}: {fault}")
    _check_costs(plan, chi)
    word = [letter_of(scenario, state) for state in plan.states]
    before = [letter_of(scenario, state) for state in seen]
    formula = global_formula(scenario)
    if not satisfies(formula, before + word[: plan.loop], word[plan.loop :]):
        raise CertificateError(f"the plan's word does not satisfy {formula}")


def _check_shape(plan: Plan, start: State) -> None:
    if not plan.suffix:
        raise CertificateError("the suffix is empty")
    if plan.states[0] != start:
        raise CertificateError(f"the plan begins in {plan.states[0]} instead of {start}")
    if len(plan.moves) != len(plan.states):
        raise CertificateError(f"{len(plan.moves)} moves for {len(plan.states)} states")


def _check_costs(plan: Plan, chi: Chi) -> None:
    prefix = path_cost((*plan.prefix, plan.suffix[0]), chi)
    suffix = path_cost((*plan.suffix, plan.suffix[0]), chi)
    tolerance = RELATIVE_TOLERANCE * (prefix + suffix)
    for name, stated, found in (
        ("prefix", plan.prefix_cost, prefix),
        ("suffix", plan.suffix_cost, suffix),
    ):
        if not abs(stated - found) <= tolerance:
            raise CertificateError(f"the {name} is said to cost {stated} and costs {found}")
    tolerance *= max(plan.alpha, plan.beta)
    least = plan.cost if plan.status == "optimal" else 0.0
    if not least - tolerance <= plan.lower_bound <= plan.cost + tolerance:
        raise CertificateError(f"{plan.lower_bound} is no lower bound of a plan that is {plan.status}")


def transition_fault(scenario: Scenario, before: State, after: State, fits: Fits, can_carry: CanCarry) -> str | None:
    """What of Def. 5 forbids a transition; None if it is allowed. Clauses (1) to (5) are those of part (iii)."""
    fault = state_fault(scenario, before, fits) or state_fault(scenario, after, fits)
    return fault or _step_fault(scenario, before, after, fits, can_carry)


def _step_fault(scenario: Scenario, before: State, after: State, fits: Fits, can_carry: CanCarry) -> str | None:
    """Of a transition between two states of Pi_s."""
    for i, agent in enumerate(scenario.agent_names):
        held, holds = before.grasps[i], after.grasps[i]
        if (held is None) != (holds is None) and before.agents[i] != after.agents[i]:
            return f"{agent} moves while it grasps or releases (1, 2)"
        if held is not None and holds is not None and held != holds:
            return f"{agent} goes from grasping {held} to grasping {holds} (3)"
    for j, obj in enumerate(scenario.object_names):
        if before.objects[j] == after.objects[j]:
            continue
        team, team_after = _team(scenario, before, obj), _team(scenario, after, obj)
        if not team or team != team_after:
            return f"{obj} is moved by {sorted(team)}, then by {sorted(team_after)} (4)"
        if not can_carry(obj, team):
            return f"{sorted(team)} cannot carry {obj} (5)"
    return _transport_fault(scenario, before, after, fits)


def state_fault(scenario: Scenario, state: State, fits: Fits) -> str | None:
    """What of Def. 5 (i) keeps a state out of Pi_s; None if it belongs to it."""
    place = dict(zip(scenario.object_names, state.objects, strict=True))
    for agent, region, grasp in zip(scenario.agent_names, state.agents, state.grasps, strict=True):
        if grasp is not None and place[grasp] != region:
            return f"{agent} in {region} grasps {grasp} in {place[grasp]}"
    for region in sorted({*state.agents, *state.objects}):
        content = content_of(scenario, state, region)
        if not fits(scenario.region(region), content):
            return f"{region} has no room for {_said(content)}"
    return None


def _transport_fault(scenario: Scenario, before: State, after: State, fits: Fits) -> str | None:
    """Teams must fit as one sphere where they leave and where they arrive."""
    ways = zip(scenario.object_names, before.objects, after.objects, strict=True)
    moved = [(obj, start, goal) for obj, start, goal in ways if start != goal]
    for state, at in ((before, 1), (after, 2)):
        for region in sorted({way[at] for way in moved}):
            carried = frozenset(way[0] for way in moved if way[at] == region)
            content = content_of(scenario, state, region, carried)
            if not fits(scenario.region(region), content):
                return f"{region} has no room for {_said(content)}"
    return None


def _team(scenario: Scenario, state: State, obj: str) -> frozenset[str]:
    pairs = zip(scenario.agent_names, state.grasps, strict=True)
    return frozenset(agent for agent, grasp in pairs if grasp == obj)


def _said(content: Content) -> str:
    holds = [f"{agent} {'carrying' if obj in content.carried else 'grasping'} {obj}" for agent, obj in content.holds]
    return ", ".join([*content.free_agents, *content.objects, *holds])
