"""Automata that read the word of a lasso: their states as literals of the model.

A deterministic automaton reads prefix and suffix once, then the suffix again for as many rounds as it needs to
settle; in one more round it is back where it was, and the marks of this round are those that recur. So a lasso need
not close in the automaton after its first round, and J counts the suffix only once.
"""

from __future__ import annotations

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.bounded.conjuncts import Conjunct, Cube, Edge
from drake_ltl.planning.bounded.lassos import Lassos, Literal

_ROUNDS_IF_UNKNOWN = 2


class Reader:
    """Adds one automaton to the model."""

    def __init__(self, lassos: Lassos, conjunct: Conjunct, letters: Letters):
        self._lassos, self._model, self._conjunct, self._letters = lassos, lassos.model, conjunct, letters
        first, _ = conjunct.read(conjunct.initial, lassos.problem.first_letter)
        if first is None:
            raise InfeasibleError(f"the initial state already violates {conjunct.formula}")
        self._read_all(first)

    def _read_all(self, first: int) -> None:
        """One pass over the lasso, then passes over its suffix."""
        rounds = self._conjunct.settles
        passes = (_ROUNDS_IF_UNKNOWN if rounds is None else rounds) + 1
        state = [self._lassos.true if q == first else None for q in range(self._conjunct.n_states)]
        for n in range(max(passes - 1, 1)):
            reads = self._lassos.active if n == 0 else self._in_suffix()
            chain = self._chain(state, reads)
            state = chain[-1]
        if passes > 1:
            reads = self._in_suffix()
            chain = self._chain(state, reads)
        if rounds is None:
            self._same(chain[0], chain[-1])
        self._accept(chain, self._in_suffix())

    def _in_suffix(self) -> list[Literal]:
        """[t]: step t is one of the suffix."""
        return self._letters.in_suffix

    def _chain(self, first: list[Literal | None], reads: list[Literal]) -> list[list[Literal | None]]:
        """States at all positions; the state stays the same in steps that are not read."""
        chain = [first]
        for t, reading in enumerate(reads):
            state = [self._model.new_bool_var("") for _ in range(self._conjunct.n_states)]
            self._model.add_exactly_one(state)
            for q, before in enumerate(chain[-1]):
                if before is not None:
                    self._model.add_bool_or([reading, before.negated(), state[q]])
            for edge in self._conjunct.edges:
                for condition in self._conditions(chain[-1], edge, t, reading):
                    target = [] if edge.target is None else [state[edge.target]]
                    self._model.add_bool_or([*(literal.negated() for literal in condition), *target])
            chain.append(state)
        return chain

    def _conditions(self, state: list[Literal | None], edge: Edge, t: int, reading: Literal) -> list[list[Literal]]:
        """Conjunctions of literals, at least one of which holds if the edge is taken in step t."""
        source = state[edge.source]
        if source is None:
            return []
        return [[reading, source, *letter] for letter in self._letters.of(edge.cube, t + 1)]

    def _same(self, first: list[Literal | None], last: list[Literal | None]) -> None:
        for a, b in zip(first, last, strict=True):
            if a is not None and b is not None:
                self._model.add(a == b)

    def _accept(self, chain: list[list[Literal | None]], reads: list[Literal]) -> None:
        """Some clause of the acceptance holds for the marks met in the last round."""
        choices = []
        for clause in self._conjunct.clauses:
            if not clause.often and not clause.never:
                return
            chosen = self._model.new_bool_var("")
            choices.append(chosen)
            for mark in clause.often:
                self._meets(chain, reads, mark, chosen)
            for mark in clause.never:
                self._avoids(chain, reads, mark, chosen)
        self._model.add_bool_or(choices)

    def _meets(self, chain: list[list[Literal | None]], reads: list[Literal], mark: int, chosen: Literal) -> None:
        hits = []
        for t, reading in enumerate(reads):
            hit = self._model.new_bool_var("")
            self._model.add_implication(hit, reading)
            for edge in self._conjunct.edges:
                if mark not in edge.marks:
                    for condition in self._conditions(chain[t], edge, t, reading):
                        self._model.add_bool_or([hit.negated(), *(literal.negated() for literal in condition)])
            hits.append(hit)
        self._model.add_bool_or([chosen.negated(), *hits])

    def _avoids(self, chain: list[list[Literal | None]], reads: list[Literal], mark: int, chosen: Literal) -> None:
        for t, reading in enumerate(reads):
            for edge in self._conjunct.edges:
                if mark in edge.marks:
                    for condition in self._conditions(chain[t], edge, t, reading):
                        self._model.add_bool_or([chosen.negated(), *(literal.negated() for literal in condition)])


class Letters:
    """What holds at each position, as literals of the model."""

    def __init__(self, lassos: Lassos):
        self._lassos = lassos
        self._propositions: dict[tuple[str, int], Literal] = {}
        model = lassos.model
        self.in_suffix = [model.new_bool_var("") for _ in range(lassos.horizon)]
        """[t]: step t belongs to the suffix."""
        for both, active, inside in zip(self.in_suffix, lassos.active, lassos.inside, strict=True):
            model.add_implication(both, active)
            model.add_implication(both, inside)
            model.add_bool_or([both, active.negated(), inside.negated()])

    def of(self, cube: Cube, t: int) -> list[list[Literal]]:
        """Conjunctions of literals that together, one or the other, say that the letter at t lies in a cube.

        A cube about one member alone says in which regions it is.
        """
        members = {name.partition(".")[0] for name, _ in cube}
        if len(members) == 1:
            return [[literal] for literal in self._regions(members.pop(), cube, t)]
        literals = [(self._holds(name, t), truth) for name, truth in cube]
        return [[literal if truth else literal.negated() for literal, truth in literals]]

    def _regions(self, member: str, cube: Cube, t: int) -> list[Literal]:
        problem = self._lassos.problem
        at = self._lassos.at[t][problem.members.index(member)]
        return [
            at[k]
            for k in range(problem.n_regions)
            if all((name in problem.labels[member, k]) == truth for name, truth in cube)
        ]

    def _holds(self, name: str, t: int) -> Literal:
        if (name, t) not in self._propositions:
            model, regions = self._lassos.model, self._regions(name.partition(".")[0], ((name, True),), t)
            literal = model.new_bool_var("")
            model.add(literal == sum(regions)) if regions else model.add_bool_or([literal.negated()])
            self._propositions[name, t] = literal
        return self._propositions[name, t]
