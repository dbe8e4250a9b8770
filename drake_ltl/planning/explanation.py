"""Why there is no plan: a smallest set of formulas and facts that clash, found by leaving out what can be."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from drake_ltl.planning.clashes import Clashes, FindPlan
from drake_ltl.planning.demands import Demand
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.planning.relaxation import Power, Problem, Reason, Room, Start
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
        if self.minimal:
            found = ", found and checked" if self.verified else ""
            there_is = "any one of them the others alone have a plan" if several else "it there is a plan"
            lines.append(f"without {there_is}{found}")
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
    Where it cannot be found out whether there is a plan at all, the caller is believed that there is none.

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
    clashes = Clashes(problem, find_plan, time.monotonic() + time_limit)
    kept, unsure = _minimise(problem.reasons, clashes)
    reasons = tuple(reason for reason in problem.reasons if reason in kept)
    return Explanation(
        reasons,
        tuple(reason_in_words(problem, reason) for reason in reasons),
        remarks(problem, reasons),
        frozenset(unsure),
        {} if unsure else clashes.plans_without(reasons),
    )


def _minimise(reasons: Sequence[Reason], clashes: Clashes) -> tuple[frozenset[Reason], set[Reason]]:
    """The reasons that are needed for a clash, and those of them of which that is not sure.

    First all is given up that a simple proof can do without; that is quick, and little is left then.
    """
    kept, groups = frozenset(reasons), _groups(reasons)
    if clashes.refuted(kept):
        for group in groups:
            kept = _delete(kept, group, clashes.refuted, set())
        groups = [[reason] for group in groups for reason in group if reason in kept]
    elif clashes.clash(kept) is False:
        raise ValueError("there is a plan: nothing to explain")
    unsure: set[Reason] = set()
    for group in groups:
        kept = _delete(kept, group, clashes.clash, unsure)
    return kept, unsure


def _delete(
    kept: frozenset[Reason],
    group: Sequence[Reason],
    clash: Callable[[frozenset[Reason]], bool | None],
    unsure: set[Reason],
) -> frozenset[Reason]:
    """Gives up all of a group that a clash can do without: at once if possible, else half by half.

    Args:
        kept: they clash.
        group: some of them.
        clash: whether some reasons clash; None if that is not known.
        unsure: those that are kept because it was not known are added.
    """
    if not group:
        return kept
    answer = clash(kept.difference(group))
    if answer:
        return kept.difference(group)
    if len(group) == 1:
        unsure.update(group if answer is None else ())
        return kept
    half = len(group) // 2
    return _delete(_delete(kept, group[:half], clash, unsure), group[half:], clash, unsure)


def _groups(reasons: Sequence[Reason]) -> list[list[Reason]]:
    """In the order in which they are given up: facts first, so that what remains is about formulas if possible."""
    kinds = [[r for r in reasons if isinstance(r, kind)] for kind in (Room, Power, Start)]
    formulas = [r for r in reasons if isinstance(r, Demand)]
    return [*kinds, [r for r in formulas if not r.owner], [r for r in formulas if r.owner]]
