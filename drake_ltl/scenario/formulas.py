"""Formulas: what their propositions mean, and the one formula that the whole team must satisfy.

Every member's own formula speaks of what that member experiences, so `pi3` in two formulas is two
propositions. Wherever several members meet, in automata, words and the global formula, the proposition p of
member m is called `m.p`. Names have no dot, so no two of them coincide; Spot reads `m.p` as one proposition.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.table import UnfitValueError, did_you_mean, listing, shown
from drake_ltl.spot_support import require_spot

MAX_LENGTH = 10_000
"""Characters of a formula; Spot's recursion exhausts the stack on nestings some ten times as deep."""
MAX_DEPTH = 200
"""Operators inside each other; what walks through formulas calls itself for each."""

_LOGIC = "write LTL: ! & | -> <-> X F G U W R M, parentheses and propositions"

Services = Mapping[str, Mapping[str, tuple[str, ...]]]


def global_formula(scenario: Scenario) -> str:
    """phi: the conjunction of all phi_i, all phi_j^O and the global formula, over propositions `m.p`."""
    spot = require_spot()
    formulas = [_relabelled(spot, member.spec, member.name) for member in (*scenario.agents, *scenario.objects)]
    return str(spot.formula.And([*formulas, spot.formula(scenario.spec)]))


def labels(scenario: Scenario, member: str, region: str) -> frozenset[str]:
    """L_i(pi_k) or L_j^O(pi_k): canonical propositions that hold for `member` while it is in `region`."""
    offered = offers(scenario.services, member, region)
    return frozenset(canonical(member, proposition) for proposition in offered)


def propositions(scenario: Scenario, member: str) -> tuple[str, ...]:
    """Psi_i or Psi_j^O: all that `member` can experience, under the names its own formula uses."""
    return own_propositions(scenario.services, member, scenario.region_names)


def canonical(member: str, proposition: str) -> str:
    """The name of a member's proposition where several members meet."""
    return f"{member}.{proposition}"


def offers(services: Services, member: str, region: str) -> tuple[str, ...]:
    """Services of `region` to `member`; a region of which nothing is said offers its own name."""
    return services.get(member, {}).get(region, (region,))


def own_propositions(services: Services, member: str, regions: Iterable[str]) -> tuple[str, ...]:
    """All services that any of `regions` offers to `member`, each once."""
    return tuple(dict.fromkeys(name for region in regions for name in offers(services, member, region)))


def check_member_formula(value: Any, known: Collection[str] | None) -> str:
    """A member's own formula on one line; `known` are its propositions, None lets any pass.

    Raises UnfitValueError if it is no such formula.
    """
    formula, used = _parsed(value)
    if known is None:
        return formula
    unknown = [name for name in used if name not in known]
    if unknown:
        raise _unknown(formula, unknown, f"{did_you_mean(unknown[0], known)}known propositions: {listing(known)}")
    return formula


def check_global_formula(value: Any, known: Mapping[str, Iterable[str]] | None) -> str:
    """The global formula on one line; `known` are the propositions of each member, None lets any pass.

    Raises UnfitValueError if it is no such formula.
    """
    formula, used = _parsed(value)
    if known is None:
        return formula
    everything = [canonical(member, name) for member, names in known.items() for name in names]
    unknown = [name for name in used if name not in everything]
    if unknown:
        member = unknown[0].partition(".")[0]
        choice = [canonical(member, own) for own in known.get(member, ())] or everything
        hint = f"{did_you_mean(unknown[0], everything)}write member.proposition; known: {listing(choice)}"
        raise _unknown(formula, unknown, hint)
    return formula


def _unknown(formula: str, names: list[str], remedy: str) -> UnfitValueError:
    kind = "the unknown proposition" if len(names) == 1 else "unknown propositions:"
    return UnfitValueError(f"{shown(formula)} names {kind} {', '.join(map(shown, names))}", remedy)


def _parsed(value: Any) -> tuple[str, list[str]]:
    """A formula on one line and its atomic propositions in alphabetical order."""
    if not isinstance(value, str):
        raise UnfitValueError(f"{shown(value)} is not a formula", 'write a text in quotes, such as "GF pi1"')
    formula = " ".join(value.split())
    if not (formula.isascii() and formula.isprintable()):
        raise UnfitValueError(f"{shown(formula)} has characters that no formula has", _LOGIC)
    if len(formula) > MAX_LENGTH:
        raise UnfitValueError(f"a formula of {len(formula)} characters", f"write at most {MAX_LENGTH}")
    if "[]" in formula:
        raise UnfitValueError(f"{shown(formula)} has the operator []", "write G for [] and F for <>")
    if "[" in formula:
        raise UnfitValueError(f"{shown(formula)} has a bounded operator", "write it out: F[1:2] p is X(p | X p)")
    opened, closed = formula.count("("), formula.count(")")
    if opened - closed > MAX_DEPTH:  # Spot looks for the end of each
        raise UnfitValueError(f"{shown(formula)} opens {opened} parentheses and closes {closed}", _LOGIC)
    spot = require_spot()
    result = spot.parse_infix_psl(formula)
    if result.errors:
        raise UnfitValueError(f"{shown(formula)} is no formula: {_first_error(spot, result)}", _LOGIC)
    if not result.f.is_ltl_formula():
        raise UnfitValueError(f"{shown(formula)} goes beyond linear temporal logic", _LOGIC)
    if _is_deeper(result.f, MAX_DEPTH):
        raise UnfitValueError(f"{shown(formula)} is nested too deeply", f"write at most {MAX_DEPTH} levels")
    return formula, sorted(proposition.ap_name() for proposition in spot.atomic_prop_collect(result.f))


def _is_deeper(formula: Any, most: int) -> bool:
    """Level by level: each part is looked at once on each, however often it occurs there."""
    level = {formula.id(): formula}
    for _ in range(most + 1):
        level = {part.id(): part for whole in level.values() for part in whole}
    return bool(level)


def _first_error(spot: Any, result: Any) -> str:
    """What Spot found first, and where: it underlines the place, below a copy of the formula."""
    stream = spot.ostringstream()
    result.format_errors(stream)
    copy, underline, message = stream.str().lstrip("\n").splitlines()[:3]
    start = underline.index("^") - len(">>> ")
    rest = copy[len(">>> ") + start :]
    place = f"at {shown(rest)} (column {start + 1})" if rest else "at its end"
    return f"{message.removeprefix('syntax error, ')} {place}"


def _relabelled(spot: Any, formula: str, member: str) -> Any:
    """The member's formula with each proposition p called `member.p`."""
    own = spot.formula(formula)
    renaming = spot.relabeling_map()
    for proposition in spot.atomic_prop_collect(own):
        renaming[proposition] = spot.formula.ap(canonical(member, proposition.ap_name()))
    return spot.relabel_apply(own, renaming)
