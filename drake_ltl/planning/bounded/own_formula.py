"""A member's own formula in the relaxation: steps of its product with an automaton, as numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from drake_ltl.planning.bounded.alone import Alone, Node, Step, Way
from drake_ltl.planning.bounded.program import Program, total

Counts = Mapping[tuple[str, Way], Sequence[Any]]
"""(phase, way) -> numbers whose sum is how often a member goes it in "prefix" or "suffix"."""


def add_own_formula(
    program: Program, lone: Alone, counts: Counts, end: Sequence[Any], whether: Mapping[tuple[str, Way], Any]
) -> None:
    """How often each step of the product is taken so that its ways add up to `counts` (`counting`, own formulas).

    Args:
        program: takes the constraints.
        lone: the product; nothing is added if it is not known after how many rounds its automaton settles.
        counts: ways of the member.
        end: for each region a literal, whether the suffix begins there.
        whether: literals, whether some way is gone at all; for those ways that have one.
    """
    if lone.settles is None:
        return
    _OwnFormula(program, lone, whether).add(counts, end)


class _OwnFormula:
    def __init__(self, program: Program, lone: Alone, whether: Mapping[tuple[str, Way], Any]):
        self._program, self._lone, self._whether = program, lone, whether
        self._final = {node: program.literal() for node in sorted(lone.nodes)}
        """Where the round begins that is repeated."""
        self._first = {step: program.number() for step in lone.steps}
        """How often each step is taken in the prefix and the rounds until the automaton has settled."""
        self._again = {step: program.number() for step in lone.steps}
        """How often each step is taken in one round after that."""

    def add(self, counts: Counts, end: Sequence[Any]) -> None:
        for k, literal in enumerate(end):
            self._program.add(total(self._final[node] for node in self._final if node[0] == k) == literal)
        self._add_flows()
        for way in {way for _, way in counts}:
            same = [s for s in self._lone.steps if (s.source[0], s.target[0]) == way]
            before, once = total(counts["prefix", way]), total(counts["suffix", way])
            self._program.add(total(self._first[s] for s in same) == before + self._lone.settles * once)
            self._program.add(total(self._again[s] for s in same) == once)
        self._accept()

    def _add_flows(self) -> None:
        first, again = self._first, self._again
        leaving: dict[Node, list[Step]] = {node: [] for node in self._final}
        entering: dict[Node, list[Step]] = {node: [] for node in self._final}
        for step in self._lone.steps:
            leaving[step.source].append(step)
            entering[step.target].append(step)
        for node, literal in self._final.items():
            balance = total(first[s] for s in leaving[node]) - total(first[s] for s in entering[node])
            self._program.add(balance == float(node == self._lone.start) - literal)
            self._program.add(total(again[s] for s in leaving[node]) == total(again[s] for s in entering[node]))
            self._program.add(total(again[s] for s in leaving[node]) >= literal)

    def _accept(self) -> None:
        """Of each mark that is wanted, one step is connected with the beginning of the round, there and back."""
        chosen = [self._program.literal() for _ in self._lone.clauses]
        self._program.add(total(chosen) == 1.0)
        for clause, literal in zip(self._lone.clauses, chosen, strict=True):
            for mark in clause.often:
                self._meet([s for s in self._lone.steps if mark in s.marks], literal)
            if len(self._lone.clauses) == 1:
                for step, number in self._again.items():
                    if step.marks & clause.never:
                        self._program.add(number <= 0.0)

    def _meet(self, marked: Sequence[Step], literal: Any) -> None:
        program, final = self._program, self._final
        hits = {step: program.number() for step in marked}
        program.add(total(hits.values()) == literal)
        begin = {node: program.number() for node in final}  # `final`, if this clause is the chosen one
        for node, part in begin.items():
            program.add(part <= final[node])
        there = {node: total(h for s, h in hits.items() if s.source == node) for node in final}
        back = {node: total(h for s, h in hits.items() if s.target == node) for node in final}
        for sources, sinks in ((begin, there), (back, begin)):
            flow = {step: program.number() for step in self._again}
            program.add_path({(step.source, step.target): number for step, number in flow.items()}, sources, sinks)
            for step, number in flow.items():
                self._cover(step, number)
        for step, hit in hits.items():
            self._cover(step, hit)

    def _cover(self, step: Step, flow: Any) -> None:
        """Where a path goes, the member goes."""
        self._program.add(flow <= self._again[step])
        way = (step.source[0], step.target[0])
        if ("suffix", way) in self._whether:
            self._program.add(flow <= self._whether["suffix", way])
