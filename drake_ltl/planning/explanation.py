"""Why there is no plan: a smallest set of formulas and facts that clash, found by leaving out what can be."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drake_ltl.errors import CertificateError, InfeasibleError, SearchLimitError
from drake_ltl.planning.demands import Demand
from drake_ltl.planning.existence import Existence, FindPlan
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.planning.refutation import Refutation
from drake_ltl.planning.relaxation import Power, Problem, Reason, Room, Start, starts_to_try
from drake_ltl.planning.remarks import reason_in_words, remarks
from drake_ltl.scenario.model import Scenario


@dataclass(frozen=True)
class Explanation:
    """Formulas and facts that cannot hold together. Prints as lines for people."""

    reasons: tuple[Reason, ...]
    """They clash; formulas first."""
    texts: tuple[str, ...]
    """Each reason in words."""
    remarks: tuple[str, ...]
    """What follows from the facts: which teams could carry what where, what has no room."""
    unsure: frozenset[Reason] = frozenset()
    """Reasons of which it is not known whether the clash needs them: time was over, or the problem too large."""
    without: Mapping[Reason, Plan] = field(default_factory=dict, compare=False)
    """For each reason the plan that was found when it, and all that is no reason, was left out."""

    @property
    def minimal(self) -> bool:
        """Whether without any one of the reasons there is a plan."""
        return not self.unsure

    @property
    def verified(self) -> bool:
        """Whether those plans were found and checked, one for each reason."""
        return set(self.without) == set(self.reasons)

    @property
    def lines(self) -> tuple[str, ...]:
        """Without full stops; what belongs together is indented."""
        pairs = list(zip(self.reasons, self.texts, strict=True))
        sure = [text for reason, text in pairs if reason not in self.unsure]
        perhaps = [text for reason, text in pairs if reason in self.unsure]
        several = len(pairs) > 1
        paragraphs = (
            ("these cannot hold together:" if several else "this cannot hold:", sure),
            ("together with these, or some of them:" if sure else "these, or some of them, clash:", perhaps),
            ("for", self.remarks),
        )
        lines = [line for title, texts in paragraphs if texts for line in (title, *(f"  {text}" for text in texts))]
        if self.verified:
            lines.append(f"without {'any one of them' if several else 'it'} there is a plan")
        return tuple(lines)

    def __str__(self) -> str:
        return "\n".join(self.lines)


def explain_infeasible(
    scenario: Scenario,
    start: State,
    fits: Fits,
    *,
    can_carry: CanCarry | None = None,
    find_plan: FindPlan = plan,
    time_limit: float = 30.0,
) -> Explanation:
    """A minimal set of reasons why there is no plan.

    Reasons are the formulas, split at their conjunctions, and the facts: which teams can carry an object, what
    fits in a region, where a member starts. Facts are given up before formulas, so a clash of formulas alone is
    shown as one. Each reason left out makes at least the same runs possible; so what was needed once stays needed.

    Args:
        scenario: the problem.
        start: initial state.
        fits: P_s.
        can_carry: Lambda; None takes the sum rule of the scenario's powers.
        find_plan: verifies the result, and decides where the problem is too large to be enumerated.
        time_limit: no new question is asked after so many seconds; the one that is being answered is not
            interrupted (a `find_plan` may have a limit of its own and raise TimeoutError).

    Returns:
        The reasons. With time and within size they are minimal (`Explanation.minimal`), and for each the problem
        without it was planned and the plan checked (`Explanation.verified`).

    Raises:
        ValueError: there is a plan.
        CertificateError: `find_plan` contradicts the explanation: a defect.
    """
    problem = Problem(scenario, start, fits, can_carry or sum_rule(scenario))
    search = _Search(problem, find_plan, time.monotonic() + time_limit)
    return search.explain()


class _Search:
    """Deletes reasons while the rest still clashes."""

    def __init__(self, problem: Problem, find_plan: FindPlan, deadline: float):
        self._problem = problem
        self._find_plan = find_plan
        self._deadline = deadline
        self._existence = Existence(problem)
        self._refutation = Refutation(problem)
        self._unsure: set[Reason] = set()
        self._begins: dict[frozenset[Reason], State] = {}  # from which the planner found a plan

    def explain(self) -> Explanation:
        problem = self._problem
        kept = frozenset(problem.reasons)
        if self._clash(kept) is False:
            raise ValueError("there is a plan: nothing to explain")
        for group in _groups(problem.reasons):
            kept = self._delete(kept, group)
        reasons = tuple(reason for reason in problem.reasons if reason in kept)
        return Explanation(
            reasons,
            tuple(reason_in_words(problem, reason) for reason in reasons),
            remarks(problem, reasons),
            frozenset(self._unsure),
            {} if self._unsure else self._verify(reasons),
        )

    def _delete(self, kept: frozenset[Reason], group: Sequence[Reason]) -> frozenset[Reason]:
        """Gives up all of a group that is not needed: at once if possible, else half by half."""
        if not group:
            return kept
        clash = self._clash(kept.difference(group))
        if clash:
            return kept.difference(group)
        if clash is None and (len(group) == 1 or self._late):
            self._unsure.update(group)
            return kept
        if len(group) == 1:
            return kept
        half = len(group) // 2
        return self._delete(self._delete(kept, group[:half]), group[half:])

    @property
    def _late(self) -> bool:
        return time.monotonic() > self._deadline

    def _clash(self, kept: frozenset[Reason]) -> bool | None:
        """Whether there is no plan; None if that is not known."""
        if self._late:
            return None
        try:
            return self._existence.witness(kept) is None
        except SearchLimitError:
            return self._clash_beyond_enumeration(kept)

    def _clash_beyond_enumeration(self, kept: frozenset[Reason]) -> bool | None:
        """The same for problems that cannot be enumerated: a simple proof, or what the planner says."""
        if self._refutation.refutes(kept):
            return True
        answers: list[bool | None] = []
        for start in starts_to_try(self._problem, kept):
            answers.append(self._clash_from(kept, start))
            if answers[-1] is False:
                self._begins[kept] = start
                return False
        all_starts = {reason for reason in self._problem.reasons if isinstance(reason, Start)}
        return True if all_starts <= kept and answers == [True] else None

    def _clash_from(self, kept: frozenset[Reason], start: State) -> bool | None:
        """Whether the planner says that there is no plan from a state."""
        if self._late:
            return None
        try:
            self._plan(kept, start)
        except InfeasibleError:
            return True
        except (SearchLimitError, TimeoutError):
            return None
        return False

    def _verify(self, reasons: Sequence[Reason]) -> dict[Reason, Plan]:
        """The plans without each of the reasons, as far as time allows."""
        found: dict[Reason, Plan] = {}
        self._confirm(reasons)
        for reason in reasons:
            if self._late:
                break
            kept = frozenset(reasons) - {reason}
            try:
                found[reason] = self._plan(kept, self._begin(kept))
            except (SearchLimitError, TimeoutError):
                continue
            except InfeasibleError as error:
                raise CertificateError(f"there should be a plan without {reason}: {error}") from error
        return found

    def _confirm(self, reasons: Sequence[Reason]) -> None:
        """The planner finds nothing either."""
        try:
            self._plan(frozenset(reasons), self._problem.start)
        except (InfeasibleError, SearchLimitError, TimeoutError):
            return
        raise CertificateError(f"there should be no plan with {', '.join(map(str, reasons))}")

    def _begin(self, kept: frozenset[Reason]) -> State:
        """A state from which there is a plan."""
        if kept in self._begins:
            return self._begins[kept]
        try:
            return self._existence.witness(kept) or self._problem.start
        except SearchLimitError:
            return self._problem.start

    def _plan(self, kept: frozenset[Reason], start: State) -> Plan:
        relaxed = self._problem.with_only(kept)
        return self._find_plan(relaxed.scenario, start, relaxed.fits, can_carry=relaxed.can_carry)


def _groups(reasons: Sequence[Reason]) -> list[list[Reason]]:
    """In the order in which they are given up: facts first, so that what remains is about formulas if possible."""
    kinds = [[r for r in reasons if isinstance(r, kind)] for kind in (Room, Power, Start)]
    formulas = [r for r in reasons if isinstance(r, Demand)]
    return [*kinds, [r for r in formulas if not r.owner], [r for r in formulas if r.owner]]
