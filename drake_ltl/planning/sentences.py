"""Formulas of linear temporal logic as sentences about robots and objects."""

from __future__ import annotations

from typing import Any

from drake_ltl.planning.demands import Demand, in_words
from drake_ltl.scenario.formulas import offers
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_support import require_spot


def sentence(scenario: Scenario, demand: Demand) -> str:
    """What a part of a formula asks for, such as `whenever o1 is in pi1, then or later o1 is in pi4`.

    No full stop, no formula. Where operators are nested, parentheses say what belongs together.
    """
    short = in_words(scenario, demand).removesuffix(f" ({demand})")
    if " must satisfy " not in short:
        return short
    return _Speaker(scenario, demand.owner).say(require_spot().formula(demand.formula))


class _Speaker:
    """Reads formulas aloud; propositions without a member are those of `owner`."""

    def __init__(self, scenario: Scenario, owner: str):
        self._scenario, self._owner = scenario, owner

    def say(self, formula: Any) -> str:
        """A clause that is true at one step of the plan."""
        kind, parts = formula.kindstr(), list(formula)
        if kind in ("tt", "ff"):
            return "anything" if kind == "tt" else "nothing at all is possible"
        if kind == "ap":
            return self._fact(formula.ap_name(), "is in", "experiences")
        if kind == "Not":
            return self._denied(parts[0])
        if kind in ("And", "Or"):
            return f" {kind.lower()} ".join(self._part(part) for part in parts)
        if kind == "Xor":
            return f"either {self._part(parts[0])} or {self._part(parts[1])}"
        if kind == "Implies":
            return f"if {self._part(parts[0])}, then {self._part(parts[1])}"
        if kind == "Equiv":
            return f"{self._part(parts[0])} exactly if {self._part(parts[1])}"
        if kind in ("F", "G", "X"):
            return self._temporal(kind, parts[0])
        return self._between(kind, self._part(parts[0]), self._part(parts[1]))

    def _temporal(self, kind: str, inner: Any) -> str:
        below = inner.kindstr()
        if kind == "G" and below == "Implies":
            before, after = inner
            return f"whenever {self._part(before)}, {self._then(after)}"
        if kind == "G" and below == "F":
            return f"again and again {self._part(inner[0])}"
        if kind == "F" and below == "G":
            return f"from some time on always {self._part(inner[0])}"
        if kind == "G" and below == "Not":
            return f"never {self._part(inner[0])}"
        lead = {"F": "at some time", "G": "always", "X": "in the next step"}[kind]
        return f"{lead} {self._part(inner)}"

    def _then(self, after: Any) -> str:
        """What follows a `whenever`."""
        kind = after.kindstr()
        if kind == "F":
            return f"then or later {self._part(after[0])}"
        return self.say(after) if kind == "X" else self._part(after)

    def _between(self, kind: str, left: str, right: str) -> str:
        """U, W, R and M."""
        if kind == "U":
            return f"{left} until {right}, which must come"
        if kind == "W":
            return f"{left} until {right}, or for ever"
        if kind == "R":
            return f"{right} until and while {left}, or for ever"
        return f"{right} until and while {left}, which must come"

    def _denied(self, inner: Any) -> str:
        if inner.kindstr() == "ap":
            return self._fact(inner.ap_name(), "is not in", "does not experience")
        return f"not {self._part(inner)}"

    def _part(self, formula: Any) -> str:
        """In parentheses unless it is a plain fact."""
        fact = formula.kindstr() == "ap" or (formula.kindstr() == "Not" and formula[0].kindstr() == "ap")
        return self.say(formula) if fact else f"({self.say(formula)})"

    def _fact(self, name: str, of_region: str, of_service: str) -> str:
        member, proposition = (self._owner, name) if self._owner else name.split(".", 1)
        offering = [r for r in self._scenario.region_names if proposition in offers(self._scenario.services, member, r)]
        return f"{member} {of_region if offering == [proposition] else of_service} {proposition}"
