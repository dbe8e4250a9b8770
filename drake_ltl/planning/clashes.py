"""Whether some reasons clash, asked of whoever can tell: a simple proof, enumeration, the planner."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from drake_ltl.errors import CertificateError, InfeasibleError, SearchLimitError
from drake_ltl.planning.existence import Existence
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.refutation import Refutation
from drake_ltl.planning.relaxation import Problem, Reason, Start, starts_to_try

FindPlan = Callable[..., Plan]
"""Called as `find_plan(scenario, start, fits, can_carry=can_carry)`; raises InfeasibleError if there is no plan, and
SearchLimitError or TimeoutError if it cannot tell."""


class Clashes:
    """Answers for subsets of a problem's reasons, until a deadline (of `time.monotonic()`)."""

    def __init__(self, problem: Problem, find_plan: FindPlan, deadline: float):
        self._problem = problem
        self._find_plan = find_plan
        self._deadline = deadline
        self._existence = Existence(problem)
        self._refutation = Refutation(problem)
        self._begins: dict[frozenset[Reason], State | None] = {}
        self._plans: dict[frozenset[Reason], Plan] = {}  # that the planner found

    @property
    def late(self) -> bool:
        """Whether time is over."""
        return time.monotonic() > self._deadline

    def refuted(self, kept: frozenset[Reason]) -> bool:
        """Whether a simple proof shows that there is no plan with only these reasons."""
        return not self.late and self._refutation.refutes(kept)

    def clash(self, kept: frozenset[Reason]) -> bool | None:
        """Whether there is no plan with only these reasons; None if that is not known."""
        if self.late:
            return None
        if self._refutation.refutes(kept):
            return True
        try:
            return self._witness(kept) is None
        except SearchLimitError:
            return self._clash_by_planner(kept)

    def plans_without(self, reasons: Sequence[Reason]) -> dict[Reason, Plan]:
        """For each of some reasons that clash a plan for all others, as far as time allows.

        Raises:
            CertificateError: the planner contradicts what was found before.
        """
        found = {reason: self._plan_for(frozenset(reasons) - {reason}) for reason in reasons}
        self._confirm(frozenset(reasons))
        return {reason: plan for reason, plan in found.items() if plan is not None}

    def _witness(self, kept: frozenset[Reason]) -> State | None:
        """A state from which there is a plan; None if there is none."""
        if kept not in self._begins:
            self._begins[kept] = self._existence.witness(kept)
        return self._begins[kept]

    def _clash_by_planner(self, kept: frozenset[Reason]) -> bool | None:
        answers: list[bool | None] = []
        for start in starts_to_try(self._problem, kept):
            answers.append(self._clash_from(kept, start))
            if answers[-1] is False:
                return False
        all_starts = {reason for reason in self._problem.reasons if isinstance(reason, Start)}
        return True if all_starts <= kept and answers == [True] else None

    def _clash_from(self, kept: frozenset[Reason], start: State) -> bool | None:
        """Whether the planner says that there is no plan from a state."""
        if self.late:
            return None
        try:
            self._plans[kept] = self._plan(kept, start)
        except InfeasibleError:
            return True
        except (SearchLimitError, TimeoutError):
            return None
        return False

    def _confirm(self, kept: frozenset[Reason]) -> None:
        """The planner finds nothing either, if it can tell."""
        if not self.late and self._clash_from(kept, self._problem.start) is False:
            raise CertificateError(f"there should be no plan with {', '.join(map(str, kept))}")

    def _plan_for(self, kept: frozenset[Reason]) -> Plan | None:
        """The plan that exists with only these reasons; None if time is over or the planner cannot tell."""
        if kept in self._plans or self.late:
            return self._plans.get(kept)
        try:
            start = self._witness(kept)
            if start is None:
                raise InfeasibleError("by enumeration")
            return self._plan(kept, start)
        except InfeasibleError as error:
            reasons = ", ".join(map(str, kept))
            raise CertificateError(f"there should be a plan with only {reasons or 'no reasons'}: {error}") from error
        except (SearchLimitError, TimeoutError):
            return None

    def _plan(self, kept: frozenset[Reason], start: State) -> Plan:
        relaxed = self._problem.with_only(kept)
        return self._find_plan(relaxed.scenario, start, relaxed.fits, can_carry=relaxed.can_carry)
