"""The parts of a specification: each formula split at its conjunctions, and what each part asks for in words."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from drake_ltl.scenario.formulas import canonical, offers, propositions
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_support import require_spot

_REGION_WORDS = {
    "p": "must start in {}",
    "!p": "must not start in {}",
    "F p": "must visit {} at some time",
    "G p": "must stay in {} all the time",
    "GF p": "must visit {} again and again",
    "FG p": "must stay in {} from some time on",
    "F !p": "must be out of {} at some time",
    "G !p": "must never enter {}",
    "GF !p": "must be out of {} again and again",
    "FG !p": "must leave {} for good",
}
_SERVICE_WORDS = {
    "p": "must experience {} at the start",
    "!p": "must not experience {} at the start",
    "F p": "must experience {} at some time",
    "G p": "must experience {} all the time",
    "GF p": "must experience {} again and again",
    "FG p": "must experience {} all the time from some time on",
    "F !p": "must be without {} at some time",
    "G !p": "must never experience {}",
    "GF !p": "must be without {} again and again",
    "FG !p": "must give up {} for good",
}


@dataclass(frozen=True)
class Demand:
    """One part of a formula that must hold together with all others."""

    owner: str
    """The member whose own formula it belongs to; empty for the global formula."""
    formula: str
    """Over the owner's own propositions; the global formula's are `member.proposition`."""

    def __str__(self) -> str:
        """Such as `a1: G !pi3`."""
        return f"{self.owner or 'spec'}: {spaced(self.formula)}"


def demands(scenario: Scenario) -> tuple[Demand, ...]:
    """All formulas of a scenario, split at their top-level conjunctions: agents, objects, the global formula.

    Parts that are always true are left out.
    """
    spot = require_spot()
    found = []
    for owner, formula in _formulas(scenario):
        found += [Demand(owner, str(part)) for part in parts(spot.formula(formula)) if not part.is_tt()]
    return tuple(found)


def parts(formula: Any) -> Iterator[Any]:
    """Spot's formula, split at its top-level conjunctions; `G(p & q)` is `G p & G q`."""
    spot = require_spot()
    if formula._is(spot.op_And):
        for part in formula:
            yield from parts(part)
    elif formula._is(spot.op_G):
        for part in parts(formula[0]):
            yield spot.formula.G(part)
    else:
        yield formula


def with_demands(scenario: Scenario, kept: Iterable[Demand]) -> Scenario:
    """The same scenario with only some parts of its formulas."""
    kept_of: dict[str, list[str]] = {}
    for demand in kept:
        kept_of.setdefault(demand.owner, []).append(f"({demand.formula})")
    specs = {owner: " & ".join(formulas) for owner, formulas in kept_of.items()}
    return replace(
        scenario,
        agents=tuple(replace(agent, spec=specs.get(agent.name, "1")) for agent in scenario.agents),
        objects=tuple(replace(obj, spec=specs.get(obj.name, "1")) for obj in scenario.objects),
        spec=specs.get("", "1"),
    )


def spaced(formula: str) -> str:
    """Spot's text of a formula with the spaces that people write: `GFpi1` becomes `GF pi1`."""
    return re.sub(r"([XFG])(?=[a-z_!\"])", r"\1 ", formula)


def in_words(scenario: Scenario, demand: Demand) -> str:
    """What a part asks for, such as `o2 must visit pi3 again and again (o2: GF pi3)`."""
    pattern, proposition = _pattern(demand.formula)
    member = demand.owner
    if not member and proposition is not None:
        member, _, proposition = proposition.partition(".")
    if proposition is None or not member:
        members = speaks_of(scenario, demand)
        subject = next(iter(members)) if len(members) == 1 else "the team"
        return f"{subject} must satisfy {spaced(demand.formula)}"
    words = _REGION_WORDS if _is_region(scenario, member, proposition) else _SERVICE_WORDS
    return f"{member} {words[pattern].format(proposition)} ({demand})"


def speaks_of(scenario: Scenario, demand: Demand) -> frozenset[str]:
    """The members whose propositions occur in a part."""
    if demand.owner:
        return frozenset({demand.owner})
    spot = require_spot()
    names = {ap.ap_name() for ap in spot.atomic_prop_collect(spot.formula(demand.formula))}
    members = (*scenario.agent_names, *scenario.object_names)
    return frozenset(m for m in members if names & {canonical(m, p) for p in propositions(scenario, m)})


def _formulas(scenario: Scenario) -> list[tuple[str, str]]:
    own = [(member.name, member.spec) for member in (*scenario.agents, *scenario.objects)]
    return [*own, ("", scenario.spec)]


def _pattern(formula: str) -> tuple[str, str | None]:
    """The formula with p for its only proposition, and that proposition; None for it if there are no words for it."""
    spot = require_spot()
    operators, rest = "", spot.formula(formula)
    while rest._is(spot.op_F) or rest._is(spot.op_G):
        operators, rest = operators + ("F" if rest._is(spot.op_F) else "G"), rest[0]
    literal = "p"
    if rest._is(spot.op_Not):
        literal, rest = "!p", rest[0]
    pattern = f"{operators} {literal}".strip()
    known = rest._is(spot.op_ap) and pattern in _REGION_WORDS
    return pattern, rest.ap_name() if known else None


def _is_region(scenario: Scenario, member: str, proposition: str) -> bool:
    """Whether a member experiences the proposition exactly in the region of that name."""
    offering = [r for r in scenario.region_names if proposition in offers(scenario.services, member, r)]
    return offering == [proposition]
