"""`drake-ltl explain FILE`: what a scenario asks for, how large the problem is, whether there is a plan."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from rich.text import Text

from drake_ltl.cli.arguments import SCENARIO_HELP, TIME_LIMIT_HELP, scenario_path, seconds
from drake_ltl.cli.outcome import console, working
from drake_ltl.cli.starting import measured_geometry
from drake_ltl.cli.statuses import FAILURE, SUCCESS
from drake_ltl.errors import DrakeLtlError, InfeasibleError, SearchLimitError

if TYPE_CHECKING:
    from drake_ltl.planning.fits import Fits
    from drake_ltl.planning.plan import Plan, State
    from drake_ltl.scenario.model import Scenario

WIDTH = 80
"""Columns, on terminals that have as many: longer lines of text are hard to read."""
EXPLANATION_TIME = 30.0
"""For finding out why there is no plan [s]."""


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "explain",
        help="say what a scenario asks for and whether it is possible",
        description="Says in words what the formulas ask for and which propositions they may use, how large automata "
        "and transition system are, which parts count plan steps, and whether there is a plan; if there is none, a "
        "smallest set of formulas and facts that clash. Exit status: 0 there is a plan, 1 there is none.",
        epilog="example: drake-ltl explain forbidden_room",
    )
    parser.add_argument("file", type=scenario_path, metavar="FILE", help=SCENARIO_HELP)
    parser.add_argument("--time-limit", type=seconds, metavar="S", help=TIME_LIMIT_HELP)
    parser.set_defaults(run=run, method="auto", json=None)


def run(args: argparse.Namespace) -> int:
    """Prints one section after the other; 0 if there is a plan, else 1."""
    from drake_ltl.scenario import load

    scenario = load(args.file)
    geometry = measured_geometry(scenario)

    # What plans takes a while to load: only now is it sure to be needed.
    from drake_ltl.api import planning_problem
    from drake_ltl.cli.planning import planned

    _show("What is asked for", formula_lines(scenario))
    _show("What formulas may name", proposition_lines(scenario))
    _show("What depends on the number of steps", stutter_lines(scenario))
    start, fits = planning_problem(scenario, geometry)
    _show("Where everybody starts", start_lines(scenario, start))
    with working("forming automata and transition system"):
        sizes = list(size_lines(scenario, start, fits))
    _show("How large it is", sizes)
    try:
        found, method = planned(args, scenario, start, fits)
    except InfeasibleError as error:
        with working("looking for the reason"):
            reasons = list(infeasibility_lines(scenario, start, fits))
        _show("Whether there is a plan", [f"No: {error}.", *reasons])
        return FAILURE
    except (SearchLimitError, TimeoutError) as error:
        _show("Whether there is a plan", [f"That is not known: {error}."])
        return FAILURE
    _show("Whether there is a plan", plan_lines(found, method))
    return SUCCESS


def formula_lines(scenario: Scenario) -> Iterator[str]:
    """Each part of each formula, and below it what it means."""
    from drake_ltl.planning.demands import demands, spaced
    from drake_ltl.planning.sentences import sentence

    parts = demands(scenario)
    names = {"": "all together"} | {agent.name: f"{agent.name} (agent)" for agent in scenario.agents}
    names |= {obj.name: f"{obj.name} (object)" for obj in scenario.objects}
    for owner in (*scenario.agent_names, *scenario.object_names, ""):
        own = [part for part in parts if part.owner == owner]
        if not own and owner:
            yield f"{names[owner]}: nothing of its own"
        elif own:
            yield names[owner]
        for part in own:
            yield f"  {spaced(part.formula)}"
            yield f"    {sentence(scenario, part)}"


def proposition_lines(scenario: Scenario) -> Iterator[str]:
    """Members that know the same propositions share a line; services say where they are offered."""
    from drake_ltl.scenario.formulas import offers, propositions

    alike: dict[tuple[str, ...], list[str]] = {}
    for member in (*scenario.agent_names, *scenario.object_names):
        where = {p: [r for r in scenario.region_names if p in offers(scenario.services, member, r)]
                 for p in propositions(scenario, member)}  # fmt: skip
        texts = tuple(p if regions == [p] else f"{p} (in {', '.join(regions)})" for p, regions in where.items())
        alike.setdefault(texts, []).append(member)
    for texts, members in alike.items():
        yield f"{', '.join(members)}: {', '.join(texts) or 'none'}"
    yield "The formula over everything writes member.proposition."


def stutter_lines(scenario: Scenario) -> Iterator[str]:
    """The parts that are not stutter-invariant."""
    from drake_ltl.planning.stuttering import stutter_sensitive_demands

    parts = stutter_sensitive_demands(scenario)
    if not parts:
        yield "Nothing: a step in which all wait changes no verdict."
        return
    yield "These parts: waiting a step more or less can change whether they hold."
    yield from (f"  {part}" for part in parts)


def start_lines(scenario: Scenario, start: State) -> Iterator[str]:
    """Members by region."""
    members = (*scenario.agent_names, *scenario.object_names)
    where = dict(zip(members, (*start.agents, *start.objects), strict=True))
    for region in scenario.region_names:
        there = [member for member in members if where[member] == region]
        yield f"{region}: {', '.join(there) or 'nobody'}"


def size_lines(scenario: Scenario, start: State, fits: Fits) -> Iterator[str]:
    """Automata and transition system."""
    from drake_ltl.planning.sizes import automaton_sizes

    sizes = automaton_sizes(scenario)
    if sizes.buchi is None:
        yield "Büchi automaton BA of the paper: takes too long to make"
    else:
        yield f"Büchi automaton BA of the paper: {_counted(sizes.buchi, 'edges')}"
    searched = "too large" if sizes.searched is None else _counted(sizes.searched, "edges")
    yield f"deterministic automaton that is searched: {searched}"
    yield from _system_lines(scenario, start, fits)


def _system_lines(scenario: Scenario, start: State, fits: Fits) -> Iterator[str]:
    from drake_ltl.planning.power import sum_rule
    from drake_ltl.planning.sizes import reachable_size
    from drake_ltl.planning.transition_system import form

    try:
        system = form(scenario, fits, sum_rule(scenario))
    except SearchLimitError as error:
        yield f"transition system TS: {error}"
        return
    yield f"transition system TS: {_counted((system.n_states, system.n_transitions), 'transitions')}"
    yield f"  reachable from the start: {_counted(reachable_size(system, start), 'transitions')}"


def _counted(size: tuple[int, int], edges: str) -> str:
    states, others = size
    return f"{states:,} state{'' if states == 1 else 's'}, {others:,} {edges if others != 1 else edges[:-1]}"


def plan_lines(found: Plan, method: str) -> Iterator[str]:
    """How long and how dear it is."""
    first, again = len(found.prefix), len(found.suffix)
    proof = "no plan costs less" if found.status == "optimal" else f"none costs less than {found.lower_bound:.6g}"
    steps = f"{first} step{'' if first == 1 else 's'}"
    yield f"Yes: {steps}, then {again} repeated for ever; cost {found.cost:.6g}, {proof}."
    if method == "bounded":
        yield "It was found by the bounded method: the problem is too large to enumerate."
    yield "`drake-ltl plan` shows it; whether the bodies find places, `drake-ltl simulate` finds out."


def infeasibility_lines(scenario: Scenario, start: State, fits: Fits) -> Iterator[str]:
    """Formulas and facts that clash, as far as they can be found in EXPLANATION_TIME."""
    from drake_ltl.planning.explanation import explain_infeasible

    try:
        yield from explain_infeasible(scenario, start, fits, time_limit=EXPLANATION_TIME).lines
    except (DrakeLtlError, ValueError):
        yield "Which formulas and facts clash could not be found out."


def _show(title: str, lines: Iterable[str]) -> None:
    """A heading and its lines; what is too long is broken and indented as far as its line."""
    out = console()
    width = min(WIDTH, out.width)
    out.print(Text(title, style="bold"))
    for line in lines:
        indent = " " * (2 + len(line) - len(line.lstrip(" ")))
        for row in textwrap.wrap(line.strip(), width, initial_indent=indent, subsequent_indent=indent):
            out.print(row, markup=False, highlight=False, soft_wrap=True)
    out.print()
    out.file.flush()
