"""Spot's judgement against the semantics of LTL written out."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.verification.ltl import holds

PROPOSITIONS = ("a1.pi1", "a1.pi2", "o1.pi1")

formulas = st.recursive(
    st.sampled_from([("1",), *((name,) for name in PROPOSITIONS)]),
    lambda part: st.one_of(
        st.tuples(st.sampled_from("!XFG"), part),
        st.tuples(st.sampled_from(["&", "|", "U", "R", "W", "M", "->", "<->", "xor"]), part, part),
    ),
    max_leaves=8,
)
letters = st.frozensets(st.sampled_from(PROPOSITIONS))


JOINS = {
    "&": lambda a, b: a and b,
    "|": lambda a, b: a or b,
    "->": lambda a, b: not a or b,
    "<->": lambda a, b: a == b,
    "xor": lambda a, b: a != b,
}


def written(formula: tuple) -> str:
    if len(formula) == 1:
        return formula[0]
    if len(formula) == 2:
        return f"{formula[0]}({written(formula[1])})"
    return f"({written(formula[1])}) {formula[0]} ({written(formula[2])})"


def truth(formula: tuple, word: list, loop: int) -> list[bool]:
    """Truth at every position of word, whose last letter is followed by word[loop]."""
    head, *parts = formula
    values = [truth(part, word, loop) for part in parts]
    n = len(word)
    after = [*range(1, n), loop]
    if not parts:
        return [head == "1" or head in letter for letter in word]
    if head == "!":
        return [not value for value in values[0]]
    if head == "X":
        return [values[0][after[k]] for k in range(n)]
    if head in JOINS:
        return [JOINS[head](a, b) for a, b in zip(*values, strict=True)]
    if head == "W":  # p U q or G p
        return truth(("|", ("U", *parts), ("G", parts[0])), word, loop)
    if head == "M":  # p R q and F p
        return truth(("&", ("R", *parts), ("F", parts[0])), word, loop)
    left, right = {
        "F": ([True] * n, values[-1]),
        "U": (values[0], values[-1]),
        "G": ([False] * n, values[-1]),
        "R": (values[0], values[-1]),
    }[head]
    least = head in "FU"  # least fixed point of until, greatest of release
    result = [not least] * n
    for _ in range(2 * n):
        for k in reversed(range(n)):
            following = result[after[k]]
            result[k] = right[k] or (left[k] and following) if least else right[k] and (left[k] or following)
    return result


@settings(max_examples=300)
@given(formulas, st.lists(letters, max_size=3), st.lists(letters, min_size=1, max_size=3))
def test_agrees_with_the_semantics(formula, prefix, cycle):
    expected = truth(formula, prefix + cycle, len(prefix))[0]
    # Spot reads a1.pi1 as one proposition
    assert holds(written(formula), prefix, cycle) == expected


@settings(max_examples=100)
@given(formulas, st.lists(letters, max_size=3), st.lists(letters, min_size=1, max_size=3), st.data())
def test_one_word_written_in_many_ways(formula, prefix, cycle, data):
    """A cycle that is unrolled, or begun elsewhere, is the same word."""
    turns, more = data.draw(st.integers(1, 3)), data.draw(st.integers(0, len(cycle)))
    other = (prefix + cycle[:more], (cycle[more:] + cycle[:more]) * turns)
    assert holds(written(formula), prefix, cycle) == holds(written(formula), *other)


def test_nothing_repeats():
    with pytest.raises(ValueError, match="at least one letter"):
        holds("1", [{"a"}], [])
