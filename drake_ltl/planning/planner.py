"""From a scenario and its initial state to the plan of least cost, with its certificate checked."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import pairwise

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.actions import actions_between
from drake_ltl.planning.automaton import Automaton, buchi_size, letters, tabulate, translate
from drake_ltl.planning.certificate import check, state_fault
from drake_ltl.planning.costs import Chi, path_cost, sum_of_ways
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.planning.search import Lasso, cheapest_lasso, has_lasso
from drake_ltl.planning.transition_system import TransitionSystem, form
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario


def plan(
    scenario: Scenario,
    start: State,
    fits: Fits,
    *,
    can_carry: CanCarry | None = None,
    chi: Chi | None = None,
    forbidden: frozenset[tuple[State, State]] = frozenset(),
    system: TransitionSystem | None = None,
) -> Plan:
    """The plan of least J = cost(prefix) + cost(suffix), of those one with the fewest moves and
    actions.

    Optimal among all lassos of TS (Def. 5) whose word satisfies the formula; `search` says how far that is proven
    where the automaton is unusually large (`Plan.status`, `Plan.lower_bound`).

    Args:
        scenario: the problem.
        start: initial state.
        fits: P_s, asked once for each different content of a region.
        can_carry: Lambda; None takes the sum rule of the scenario's powers.
        chi: cost of a transition; None takes the scenario's `cost`.
        forbidden: transitions that the plan must not use, as pairs (before, after).
        system: TS, if `form` was called before with the same fits, can_carry and chi; saves time when planning
            again.

    Returns:
        A plan that passed `certificate.check`. `Plan.counts` are those of the paper: all of TS, the complete
        Buchi automaton BA with acceptance on states, and TS x BA.

    Raises:
        InfeasibleError: no plan satisfies the formula; says which formula is to blame if one alone is.
        SearchLimitError: TS is too large to be enumerated.
        InvalidInputError: `start` does not belong to the scenario, or chi returned no cost.
    """
    can_carry = can_carry or sum_rule(scenario)
    began = time.perf_counter()
    system = system or form(scenario, fits, can_carry, chi)
    first = system.index(start)
    if first < 0:
        raise InfeasibleError(f"the initial state is impossible: {state_fault(scenario, start, fits)}")
    formed = time.perf_counter()
    letter, automaton = _automaton(scenario, system)
    states, edges = buchi_size(global_formula(scenario))
    translated = time.perf_counter()
    lasso = cheapest_lasso(system.without(forbidden), letter, automaton, first)
    if lasso is None:
        raise InfeasibleError(_reason(scenario, system, first, forbidden))
    found = _plan(scenario, system, lasso, chi or sum_of_ways(scenario))
    check(found, scenario, start, fits, can_carry, chi)
    searched = time.perf_counter()
    return replace(
        found,
        counts={
            "ts_states": system.n_states,
            "ts_transitions": system.n_formed,
            "automaton_states": states,
            "automaton_edges": edges,
            "product_states": system.n_states * states,
        },
        seconds={
            "transition_system": formed - began,
            "automaton": translated - formed,
            "search": searched - translated,
            "total": searched - began,
        },
    )


def _automaton(scenario: Scenario, system: TransitionSystem) -> tuple[object, Automaton]:
    """The letter of each state and the automaton of the scenario's formula."""
    automaton = translate(global_formula(scenario))
    propositions = [ap.ap_name() for ap in automaton.ap()]
    different, letter = letters(system, propositions)
    return letter, tabulate(automaton, propositions, different)


def _plan(scenario: Scenario, system: TransitionSystem, lasso: Lasso, chi: Chi) -> Plan:
    prefix = tuple(system.state(index) for index in lasso.prefix)
    suffix = tuple(system.state(index) for index in lasso.suffix)
    run = (*prefix, *suffix, suffix[0])
    prefix_cost, suffix_cost = path_cost((*prefix, suffix[0]), chi), path_cost((*suffix, suffix[0]), chi)
    return Plan(
        prefix=prefix,
        suffix=suffix,
        moves=tuple(actions_between(scenario, *ends) for ends in pairwise(run)),
        prefix_cost=prefix_cost,
        suffix_cost=suffix_cost,
        lower_bound=(prefix_cost + suffix_cost) * (1.0 - lasso.gap),
        status="optimal" if lasso.optimal else "feasible",
    )


def _reason(scenario: Scenario, system: TransitionSystem, first: int, forbidden: frozenset) -> str:
    """Why there is no plan: one formula alone if possible."""
    if translate(global_formula(scenario)).is_empty():
        whole = "no word at all satisfies the formulas together"
    else:
        whole = "no run from the initial state satisfies the formulas together"
    for name, alone in _alone(scenario):
        formula = global_formula(alone)
        if translate(formula).is_empty():
            return f"no word at all satisfies {name}: {formula}"
        letter, automaton = _automaton(alone, system)
        if not has_lasso(system, letter, automaton, first):
            return f"no run from the initial state satisfies {name}, even without the others: {formula}"
    if forbidden:
        whole += f", with {len(forbidden)} transitions excluded"
    return f"{whole}, though each of them can be satisfied alone"


def _alone(scenario: Scenario) -> list[tuple[str, Scenario]]:
    """The scenario with each of its formulas as the only one."""
    agents = tuple(replace(agent, spec="1") for agent in scenario.agents)
    objects = tuple(replace(obj, spec="1") for obj in scenario.objects)
    empty = replace(scenario, agents=agents, objects=objects, spec="1")
    cases = [("the global formula", replace(empty, spec=scenario.spec))]
    for i, agent in enumerate(scenario.agents):
        cases.append((f"the formula of {agent.name}", replace(empty, agents=(*agents[:i], agent, *agents[i + 1 :]))))
    for j, obj in enumerate(scenario.objects):
        cases.append((f"the formula of {obj.name}", replace(empty, objects=(*objects[:j], obj, *objects[j + 1 :]))))
    return cases
