"""From a scenario and its initial state to the plan of least cost, with its certificate checked."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import InfeasibleError, InvalidInputError, Mistake, SearchLimitError
from drake_ltl.planning.actions import actions_between
from drake_ltl.planning.automaton import Automaton, joint
from drake_ltl.planning.certificate import check, state_fault
from drake_ltl.planning.conjunction import propositions_of, tabulate_all, translate_each
from drake_ltl.planning.costs import Chi, path_cost, sum_of_ways
from drake_ltl.planning.counts import Counts
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.models import Listed, Model, Route, factored, is_listed
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.planning.transition_system import TransitionSystem, digits_of, form
from drake_ltl.planning.words import letter_of
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
    alpha: float = 1.0,
    beta: float = 1.0,
    seen: Sequence[State] = (),
) -> Plan:
    """The plan of least J = alpha cost(prefix) + beta cost(suffix), of those one with the fewest moves and
    actions.

    Optimal among all lassos of TS (Def. 5) whose word satisfies the formula; `search` says how far that is proven
    where the automaton is unusually large (`Plan.status`, `Plan.lower_bound`). Where TS has too many transitions to
    be listed they stay factored (`planning.factored`), unless chi, forbidden transitions or TS itself are given.

    Args:
        scenario: the problem.
        start: state in which the run begins, the initial one or, mid-mission, any other.
        fits: P_s, asked once for each different content of a region.
        can_carry: Lambda; None takes the sum rule of the scenario's powers.
        chi: cost of a transition; None takes the scenario's `cost`.
        forbidden: transitions that the plan must not use, as pairs (before, after).
        system: TS, if `form` was called before with the same fits, can_carry and chi; saves time when planning
            again.
        alpha: weight of the prefix's cost, at least 0.
        beta: weight of the suffix's cost, at least 0.
        seen: states that were passed before `start`, from the initial one: the formula speaks of the whole run,
            J of what is still to come.

    Returns:
        A plan that passed `certificate.check`. `Plan.counts` are those of the paper: all of TS, the complete
        Buchi automaton BA with acceptance on states, and TS x BA; transitions that stay factored are not counted.

    Raises:
        InfeasibleError: no plan satisfies the formula; says which formula is to blame if one alone is.
        SearchLimitError: TS is too large to be enumerated.
        InvalidInputError: a state does not belong to the scenario, or chi, alpha or beta is no cost.
    """
    _check_weights(alpha, beta)
    began = time.perf_counter()

    def listed() -> Model:
        return Listed(system or form(scenario, fits, can_carry or sum_rule(scenario), chi), forbidden)

    makes: list[Callable[[], Model]] = [listed]
    if chi is None and system is None and not forbidden:  # the factored model has none of these
        makes.insert(is_listed(scenario), lambda: factored(scenario, fits, can_carry))
    model, route, seconds = _search(scenario, makes, start, fits, alpha, beta, seen)
    if route is None:
        raise InfeasibleError(_reason(scenario, model, start, forbidden, seen))
    found = _plan(scenario, route, chi or sum_of_ways(scenario), alpha, beta)
    check(found, scenario, start, fits, can_carry or sum_rule(scenario), chi, seen)
    total = time.perf_counter() - began
    return replace(
        found,
        counts=Counts(model.n_states, model.n_transitions, global_formula(scenario)),
        seconds={**seconds, "search": total - sum(seconds.values()), "total": total},
    )


def _search(
    scenario: Scenario,
    makes: Sequence[Callable[[], Model]],
    start: State,
    fits: Fits,
    alpha: float,
    beta: float,
    seen: Sequence[State],
) -> tuple[Model, Route | None, dict[str, float]]:
    """The plan of least J by the first model that proves it, else the first plan; and what forming the model took.

    Raises:
        SearchLimitError: all models are too large.
    """
    found: tuple[Model, Route | None, dict[str, float]] | None = None
    for make in makes:
        began = time.perf_counter()
        try:
            model = make()
            if not model.has(start):
                raise InfeasibleError(f"the initial state is impossible: {state_fault(scenario, start, fits)}")
            formed = time.perf_counter()
            letter, automaton = _automaton(scenario, model, seen)
            translated = time.perf_counter()
            route = model.cheapest(letter, automaton, start, alpha, beta)
        except SearchLimitError as error:
            problem = error
            continue
        seconds = {"transition_system": formed - began, "automaton": translated - formed}
        if route is None or route.optimal:
            return model, route, seconds
        found = found or (model, route, seconds)
    if found is None:
        raise problem
    return found


def _check_weights(alpha: float, beta: float) -> None:
    for name, weight in (("alpha", alpha), ("beta", beta)):
        if not 0.0 <= weight < math.inf:
            raise InvalidInputError([Mistake(name, f"is {weight}", "a weight must be finite and at least zero")])


def _automaton(scenario: Scenario, model: Model, seen: Sequence[State] = ()) -> tuple[NDArray, Automaton]:
    """The letter of each state, and the automaton of the scenario's formula after what was seen."""
    for state in seen:
        digits_of(scenario, state)  # complains of what is not in the scenario
    shown = [letter_of(scenario, state) for state in seen]
    for effort in ("low", "medium"):  # more is only worth its time where it spares the search a detour
        automata = translate_each(global_formula(scenario), effort)
        propositions = propositions_of(automata)
        different, letter = model.letters(propositions)
        word = np.array([[p in s for p in propositions] for s in shown], dtype=bool)
        word = word.reshape(len(seen), len(propositions))
        table = tabulate_all(automata, propositions, np.concatenate([different, word])).simplified()
        if table.never_counts:
            break
    return letter, table.after(range(len(different), len(different) + len(seen)))


def _plan(scenario: Scenario, route: Route, chi: Chi, alpha: float, beta: float) -> Plan:
    prefix, suffix = route.prefix, route.suffix
    run = (*prefix, *suffix, suffix[0])
    prefix_cost, suffix_cost = path_cost((*prefix, suffix[0]), chi), path_cost((*suffix, suffix[0]), chi)
    return Plan(
        prefix=prefix,
        suffix=suffix,
        moves=tuple(actions_between(scenario, *ends) for ends in pairwise(run)),
        prefix_cost=prefix_cost,
        suffix_cost=suffix_cost,
        lower_bound=(alpha * prefix_cost + beta * suffix_cost) * (1.0 - route.gap),
        status="optimal" if route.optimal else "feasible",
        alpha=alpha,
        beta=beta,
    )


def _reason(scenario: Scenario, model: Model, start: State, forbidden: frozenset, seen: Sequence[State]) -> str:
    """Why there is no plan: one formula alone if possible."""
    if _is_contradiction(global_formula(scenario)):
        whole = "no word at all satisfies the formulas together"
    else:
        whole = "no run from the initial state satisfies the formulas together"
    for name, alone in _alone(scenario):
        formula = global_formula(alone)
        if _is_contradiction(formula):
            return f"no word at all satisfies {name}: {formula}"
        letter, automaton = _automaton(alone, model, seen)
        if not model.has_lasso(letter, automaton, start):
            return f"no run from the initial state satisfies {name}, even without the others: {formula}"
    if forbidden:
        whole += f", with {len(forbidden)} transitions excluded"
    return f"{whole}, though each of them can be satisfied alone"


def _is_contradiction(formula: str) -> bool:
    """Whether no word satisfies a formula, as far as that is found out."""
    try:
        return bool(joint(formula).is_empty())
    except SearchLimitError:
        return False


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
