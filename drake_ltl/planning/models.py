"""The transition system as planning uses it: listed as a whole, or factored where that would be too much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.automaton import Automaton, letters
from drake_ltl.planning.factored import FactoredSearch, MergedStates, check_product, check_size, crowds
from drake_ltl.planning.factors import n_choices
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.planning.search import cheapest_lasso, has_lasso
from drake_ltl.planning.transition_system import TransitionSystem, digits_of, state_of
from drake_ltl.scenario.model import Scenario

MOST_LISTED = 1_000_000
"""So many transitions are listed (`n_choices`); it takes longer to list more than to do without."""


@dataclass(frozen=True)
class Route:
    """States of the run prefix, suffix, suffix .."""

    prefix: tuple[State, ...]
    suffix: tuple[State, ...]
    optimal: bool
    """Whether it is proven that no other is cheaper, nor as cheap with fewer steps or actions."""
    gap: float
    """What a cheaper one could save at most, as a share of J."""


class Model(Protocol):
    """TS with its letters. States are numbered; letters too, (S,)."""

    @property
    def n_states(self) -> int:
        """Number of states of TS."""

    @property
    def n_transitions(self) -> int | None:
        """Number of transitions of TS, if they were counted."""

    def has(self, state: State) -> bool:
        """Whether a state belongs to TS; InvalidInputError if it speaks of what is not in the scenario."""

    def letters(self, propositions: list[str]) -> tuple[NDArray, NDArray]:
        """The different letters (L, P) and the letter of each state."""

    def cheapest(self, letter: NDArray, automaton: Automaton, start: State, alpha: float, beta: float) -> Route | None:
        """The lasso of least J; None if there is none."""

    def has_lasso(self, letter: NDArray, automaton: Automaton, start: State) -> bool:
        """Whether any run from a state is accepted."""


def is_listed(scenario: Scenario) -> bool:
    """Whether TS has so few transitions that they are rather listed."""
    return n_choices(scenario) <= MOST_LISTED


def factored(scenario: Scenario, fits: Fits, can_carry: CanCarry | None) -> Factored:
    """The factored model; can_carry None stands for the sum rule.

    Raises:
        SearchLimitError: there are too many states even so.
    """
    merge = can_carry is None and getattr(fits, "counts_agents", False)
    states = MergedStates(scenario, fits, crowds(scenario, merge))
    check_size(states)
    return Factored(states, can_carry or sum_rule(scenario))


@dataclass(frozen=True, eq=False)
class Listed:
    """All states and transitions, without some that are forbidden."""

    system: TransitionSystem
    forbidden: frozenset[tuple[State, State]] = frozenset()

    @property
    def n_states(self) -> int:
        return self.system.n_states

    @property
    def n_transitions(self) -> int | None:
        return self.system.n_formed

    def has(self, state: State) -> bool:
        return self.system.index(state) >= 0

    def letters(self, propositions: list[str]) -> tuple[NDArray, NDArray]:
        return letters(self.system, propositions)

    def cheapest(self, letter: NDArray, automaton: Automaton, start: State, alpha: float, beta: float) -> Route | None:
        system = self.system
        lasso = cheapest_lasso(system.without(self.forbidden), letter, automaton, system.index(start), alpha, beta)
        if lasso is None:
            return None
        prefix, suffix = (tuple(system.state(i) for i in part) for part in (lasso.prefix, lasso.suffix))
        return Route(prefix, suffix, lasso.optimal, lasso.gap)

    def has_lasso(self, letter: NDArray, automaton: Automaton, start: State) -> bool:
        return has_lasso(self.system, letter, automaton, self.system.index(start))


@dataclass(frozen=True, eq=False)
class Factored:
    """Interchangeable agents merged, transitions never listed."""

    states: MergedStates
    can_carry: CanCarry

    @property
    def n_states(self) -> int:
        return self.states.n_possible

    @property
    def n_transitions(self) -> int | None:
        return None

    def has(self, state: State) -> bool:
        digits = digits_of(self.states.scenario, state)
        return digits is not None and self.states.number(*digits) >= 0

    def letters(self, propositions: list[str]) -> tuple[NDArray, NDArray]:
        letter = np.zeros(self.states.possible.shape, dtype=np.int64)
        different, letter[self.states.possible] = letters(
            self.states.listed(np.flatnonzero(self.states.possible)), propositions
        )
        return different, letter

    def cheapest(self, letter: NDArray, automaton: Automaton, start: State, alpha: float, beta: float) -> Route | None:
        check_product(self.states, automaton)
        scenario = self.states.scenario
        search = FactoredSearch(self.states, self.can_carry, letter, automaton, digits_of(scenario, start), alpha, beta)
        route = search.run()
        if route is None:
            return None
        prefix, suffix = (tuple(state_of(scenario, *state) for state in part) for part in (route.prefix, route.suffix))
        return Route(prefix, suffix, route.optimal, route.gap)

    def has_lasso(self, letter: NDArray, automaton: Automaton, start: State) -> bool:
        check_product(self.states, automaton)
        start = digits_of(self.states.scenario, start)
        return FactoredSearch(self.states, self.can_carry, letter, automaton, start).has_lasso()
