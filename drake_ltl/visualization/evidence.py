"""For every part of a specification: whether the run satisfied it, and where in the run this is seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from drake_ltl.planning.demands import Demand, demands
from drake_ltl.planning.remaining import pursuits
from drake_ltl.planning.sentences import sentence
from drake_ltl.scenario.formulas import canonical
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_support import require_spot
from drake_ltl.verification.ltl import holds

Letter = frozenset[str]


@dataclass(frozen=True)
class Evidence:
    """What the word of a run says of one demand."""

    demand: Demand
    meaning: str
    """In words."""
    verdict: str
    """`holds`, `fails`, or `open` where the run ended before one round of its suffix."""
    seen: str
    """After which steps the demand's propositions held, such as `o2.pi3: start, 3-10`."""


def evidence(scenario: Scenario, word: Sequence[Sequence[str]], prefix: int, suffix: int) -> tuple[Evidence, ...]:
    """For every demand of a scenario.

    Args:
        word: letters of the run: the start, then the end of each finished step; sorted canonical propositions.
        prefix: moves up to the first state of the suffix.
        suffix: moves of one round, 0 if there is none.
    """
    letters = [frozenset(letter) for letter in word]
    rounds = (len(letters) - 1 - prefix) // suffix if suffix else 0
    last = pursuits(scenario, letters, prefix, suffix)[-1] if letters else ()
    found = []
    for number, demand in enumerate(demands(scenario)):
        names = _propositions(demand)
        seen = "; ".join(f"{name}: {_positions(letters, name)}" for name in names)
        if rounds >= 1:
            end = prefix + rounds * suffix
            own = [frozenset(_own_name(demand, name) for name in names if name in letter) for letter in letters]
            good = holds(demand.formula, own[: end - suffix], own[end - suffix : end])
            verdict = "holds" if good else "fails"
        else:
            verdict = "fails" if last and last[number].standing.value == "broken" else "open"
        found.append(Evidence(demand, sentence(scenario, demand), verdict, seen))
    return tuple(found)


def _propositions(demand: Demand) -> list[str]:
    """Canonical names."""
    spot = require_spot()
    names = sorted(ap.ap_name() for ap in spot.atomic_prop_collect(spot.formula(demand.formula)))
    return [canonical(demand.owner, name) for name in names] if demand.owner else names


def _own_name(demand: Demand, name: str) -> str:
    return name.removeprefix(f"{demand.owner}.") if demand.owner else name


def _positions(letters: Sequence[Letter], name: str) -> str:
    """Steps after which it held, in ranges; 0 is the start."""
    true = [position for position, letter in enumerate(letters) if name in letter]
    ranges: list[list[int]] = []
    for position in true:
        if ranges and ranges[-1][1] == position - 1:
            ranges[-1][1] = position
        else:
            ranges.append([position, position])
    texts = [_place(first) if first == last else f"{_place(first)} to {last}" for first, last in ranges]
    return ", ".join(texts) or "never"


def _place(position: int) -> str:
    return "start" if position == 0 else str(position)
