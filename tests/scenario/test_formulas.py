"""Formulas of members become one formula of the team."""

from __future__ import annotations

import dataclasses
import itertools
import string

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.scenario import formulas, loads, table
from drake_ltl.scenario.names import RESERVED
from drake_ltl.spot_support import require_spot

spot = require_spot()

names = st.from_regex(r"[a-z_][a-z0-9_]{0,6}", fullmatch=True).filter(lambda name: name not in RESERVED)


def is_whole(word: str) -> bool:
    """Whether Spot takes `word` for an atomic proposition wherever one can stand."""
    for template in ("{}", "({} & q)", "q U {}", "!{} -> X{}", "G{} | q", "{} & q", "{} | {}"):
        parsed = spot.parse_infix_psl(template.format(word, word))
        if parsed.errors or word not in {ap.ap_name() for ap in spot.atomic_prop_collect(parsed.f)}:
            return False
    between = spot.parse_infix_psl(f"p {word} q")  # an operator would be welcome here
    return bool(between.errors)


def test_reserved_are_the_words_that_spot_reads_otherwise():
    short = map("".join, itertools.chain(*(itertools.product(string.ascii_lowercase, repeat=n) for n in (1, 2, 3))))
    likely = "true false not and or xor nor nand implies iff equiv until release weak strong next always never "
    likely += "eventually globally finally first_match first match since once then else if before t tt ff"
    assert {word for word in {*short, *likely.split()} if not is_whole(word)} == RESERVED


@given(names)
def test_names_are_whole_for_spot(name):
    assert is_whole(name)


@given(names, names, names)
def test_canonical_names_are_whole_and_tell_members_apart(member, other, proposition):
    name = formulas.canonical(member, proposition)
    assert is_whole(name)
    assert (formulas.canonical(other, proposition) == name) == (member == other)
    assert formulas.canonical(proposition, member) == name or proposition != member


def test_global_formula_is_the_conjunction_over_canonical_names(data):
    data["agents"]["a2"]["spec"] = "pi1 U dock"
    data["services"] = {"a2": {"pi2": ["dock"]}}
    data["spec"] = "G(a1.pi2 -> o1.pi1 | a2.dock)"
    scenario = loads(yaml.safe_dump(data, sort_keys=False))
    expected = "GF a1.pi2 & (a2.pi1 U a2.dock) & F o1.pi1 & G(a1.pi2 -> (o1.pi1 | a2.dock))"
    assert spot.are_equivalent(formulas.global_formula(scenario), expected)


def test_global_formula_of_nobody_demands_nothing(data):
    for kind, member in (("agents", "a1"), ("objects", "o1")):
        del data[kind][member]["spec"]
    assert formulas.global_formula(loads(yaml.safe_dump(data))) == "1"


@given(names, names)
def test_global_formula_survives_being_printed(member, region):
    """Spot prints without quotes, `GFa.b`, and must read the same again."""
    formula = formulas._relabelled(spot, f"G F {region} & ({region} U X {region})", member)
    assert spot.formula(str(formula)) == formula
    assert [ap.ap_name() for ap in spot.atomic_prop_collect(formula)] == [f"{member}.{region}"]


def test_labels_are_services_or_the_region_s_name(data):
    data["services"] = {"a1": {"pi2": ["charge", "dock"]}, "a2": {"pi1": []}}
    data["agents"]["a1"]["spec"] = "GF charge"
    scenario = loads(yaml.safe_dump(data, sort_keys=False))
    assert formulas.labels(scenario, "a1", "pi1") == {"a1.pi1"}
    assert formulas.labels(scenario, "a1", "pi2") == {"a1.charge", "a1.dock"}
    assert formulas.labels(scenario, "a2", "pi1") == frozenset()
    assert formulas.labels(scenario, "o1", "pi2") == {"o1.pi2"}
    assert formulas.propositions(scenario, "a1") == ("pi1", "charge", "dock")
    assert formulas.propositions(scenario, "a2") == ("pi2",)


def test_formula_over_several_lines_is_stored_on_one(data):
    data["agents"]["a1"]["spec"] = "GF pi2\n  & F pi1\n"
    assert loads(yaml.safe_dump(data)).agents[0].spec == "GF pi2 & F pi1"


@pytest.mark.parametrize("nesting", ["!", "(", "pi1 U "])
def test_longest_formulas_do_not_exhaust_the_stack(data, nesting):
    """Spot simplifies all these as it reads them."""
    depth = (formulas.MAX_LENGTH - 3) // (len(nesting) + nesting.count("("))
    data["agents"]["a1"]["spec"] = nesting * depth + "pi1" + ")" * (nesting.count("(") * depth)
    scenario = loads(yaml.safe_dump(data, width=10**6))
    assert spot.formula(formulas.global_formula(scenario)).is_ltl_formula()


def test_longer_formulas_are_refused(data, complaints):
    data["agents"]["a1"]["spec"] = "X" * formulas.MAX_LENGTH + "pi1"
    (mistake,) = complaints(data)
    assert mistake.where == "agents.a1.spec"
    assert dataclasses.asdict(mistake)["remedy"] == f"write at most {formulas.MAX_LENGTH}"


@pytest.mark.parametrize(
    "formula",
    [
        "X" * 201 + " pi1",
        " -> ".join(["pi1", "pi2"] * 110),
        "pi1" + " U (pi2 R (pi1" * 101 + "))" * 101,
    ],
)
def test_formulas_that_are_nested_too_deeply(formula):
    with pytest.raises(table.UnfitValueError, match="nested too deeply"):
        formulas.check_member_formula(formula, None)


@pytest.mark.parametrize(
    "formula", ["X" * 200 + " pi1", "(" * 4000 + "pi1" + ")" * 4000, " & ".join(["F pi1", "pi2"] * 500)]
)
def test_long_formulas_that_are_not(formula):
    assert formulas.check_member_formula(formula, None) == formula
