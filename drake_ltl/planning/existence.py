"""Whether there is a plan at all, for a problem of which parts are left out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.feasibility import feasible_starts
from drake_ltl.planning.plan import State
from drake_ltl.planning.relaxation import Power, Problem, Reason, Room, Start
from drake_ltl.planning.transition_system import TransitionSystem, form


class Existence:
    """Answers for subsets of a problem's reasons; remembers what the last answer was made of."""

    def __init__(self, problem: Problem):
        self._problem = problem
        self._formed: tuple[frozenset[Reason], TransitionSystem] | None = None
        self._answered: tuple[frozenset[Reason], NDArray[np.bool_]] | None = None

    def witness(self, kept: frozenset[Reason]) -> State | None:
        """An initial state from which the problem with only these reasons has a plan; None if there is none.

        Of several, one in which as many members as possible begin as they really do.

        Raises:
            SearchLimitError: the problem is too large to be enumerated.
        """
        system, feasible = self._feasible(frozenset(r for r in kept if not isinstance(r, Start)))
        alike = _alike(system, self._problem)
        members = self._problem.scenario.agent_names + self._problem.scenario.object_names
        fixed = [i for i, member in enumerate(members) if Start(member) in kept]
        candidates = np.flatnonzero(feasible & alike[:, fixed].all(axis=1))
        if not len(candidates):
            return None
        return system.state(int(candidates[alike[candidates].sum(axis=1).argmax()]))

    def _feasible(self, kept: frozenset[Reason]) -> tuple[TransitionSystem, NDArray[np.bool_]]:
        """The states of TS, and from which of them there is a plan."""
        relaxed = self._problem.with_only(kept)
        system = self._form(relaxed, kept)
        if self._answered is None or self._answered[0] != kept:
            self._answered = kept, feasible_starts(relaxed.scenario, system)
        return system, self._answered[1]

    def _form(self, relaxed: Problem, kept: frozenset[Reason]) -> TransitionSystem:
        facts = frozenset(reason for reason in kept if isinstance(reason, Power | Room))
        if self._formed is None or facts != self._formed[0]:
            self._formed = None  # not both in memory at once
            self._formed = facts, form(relaxed.scenario, relaxed.fits, relaxed.can_carry)
        return self._formed[1]


def _alike(system: TransitionSystem, problem: Problem) -> NDArray[np.bool_]:
    """(S, N + M): which members are, in each state, as in the problem's initial state."""
    scenario, start = problem.scenario, problem.start
    region = {name: k for k, name in enumerate(scenario.region_names)}
    grasping = {name: len(region) + j for j, name in enumerate(scenario.object_names)}
    options = [
        region[r] if held is None else grasping[held] for r, held in zip(start.agents, start.grasps, strict=True)
    ]
    agents = (system.options == options) & (system.agent_regions == [region[r] for r in start.agents])
    return np.hstack([agents, system.places == [region[r] for r in start.objects]])
