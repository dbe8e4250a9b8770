"""Formulas read aloud."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.planning.demands import Demand, demands
from drake_ltl.planning.sentences import sentence
from drake_ltl.scenario import load, loads

TEXT = """
workspace: {radius: 20}
regions:
  pi1: {centre: [-8, 0, 0], radius: 4}
  pi2: {centre: [8, 0, 0], radius: 4}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-8, 0]}
objects:
  o1: {model: package://drake_ltl_models/objects/crate.sdf, position: [8, 0]}
services: {a1: {pi2: [charge]}}
"""


@pytest.fixture(scope="module")
def scenario():
    return loads(TEXT)


@pytest.mark.parametrize(
    ("owner", "formula", "words"),
    [
        ("o1", "GF pi1", "o1 must visit pi1 again and again"),
        ("a1", "F charge", "a1 must experience charge at some time"),
        ("o1", "G(pi1 -> F pi2)", "whenever o1 is in pi1, then or later o1 is in pi2"),
        ("o1", "G(pi1 -> X pi2)", "whenever o1 is in pi1, in the next step o1 is in pi2"),
        ("o1", "pi1 U pi2", "o1 is in pi1 until o1 is in pi2, which must come"),
        ("o1", "pi1 W pi2", "o1 is in pi1 until o1 is in pi2, or for ever"),
        ("o1", "pi1 R pi2", "o1 is in pi2 until and while o1 is in pi1, or for ever"),
        ("o1", "pi1 M pi2", "o1 is in pi2 until and while o1 is in pi1, which must come"),
        ("o1", "pi1 <-> !pi2", "o1 is in pi1 exactly if o1 is not in pi2"),
        ("a1", "!charge U pi1", "a1 does not experience charge until a1 is in pi1, which must come"),
        ("", "G !(a1.charge & o1.pi2)", "never (a1 experiences charge and o1 is in pi2)"),
        ("", "GF(a1.pi1 | o1.pi1)", "again and again (a1 is in pi1 or o1 is in pi1)"),
        ("o1", "FG(pi1 | X pi1)", "from some time on always (o1 is in pi1 or (in the next step o1 is in pi1))"),
        ("o1", "G(pi1 -> (pi1 U pi2))", "whenever o1 is in pi1, (o1 is in pi1 until o1 is in pi2, which must come)"),
    ],
)
def test_words(scenario, owner, formula, words):
    assert sentence(scenario, Demand(owner, formula)) == words


FORMULAS = st.recursive(
    st.sampled_from(["pi1", "pi2", "!pi1", "1", "0"]),
    lambda inner: st.one_of(
        st.builds("{}({})".format, st.sampled_from(["X", "F", "G", "!"]), inner),
        st.builds("({}) {} ({})".format, inner, st.sampled_from(["&", "|", "->", "<->", "xor", *"UWRM"]), inner),
    ),
    max_leaves=6,
)


@given(formula=FORMULAS)
def test_every_formula_can_be_read_and_parentheses_match(scenario, formula):
    text = sentence(scenario, Demand("o1", formula))
    depth = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        assert depth >= 0
    assert depth == 0
    assert "must satisfy" not in text


def test_all_parts_of_the_paper_s_examples_have_words(examples):
    paper = load(examples / "case_ii.yaml")
    assert all("must satisfy" not in sentence(paper, part) for part in demands(paper))
