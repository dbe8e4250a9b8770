"""A plan as a table for a terminal, like Tables 1 and 2 of the paper."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.planning.stuttering import stutter_note
from drake_ltl.scenario.model import Scenario

_HARD_SPACE = "\N{NO-BREAK SPACE}"  # lines break between actions, not within


def plan_table(plan: Plan, scenario: Scenario) -> Table:
    """One row per state with the actions that lead to it; states of the suffix are marked with a star.

    The last row is the move that leads from the suffix's last state back to its first.
    """
    table = Table(
        title=f"Plan of {scenario.name}" if scenario.name else None,
        caption=_caption(plan, scenario),
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        row_styles=("", "dim"),
    )
    table.add_column("state", justify="right", no_wrap=True)
    table.add_column("actions that lead to it", overflow="fold")
    into = [_start(plan.states[0], scenario), *map(_actions, plan.moves)]
    for number in range(1, len(plan.states) + 1):
        starred = number > plan.loop
        if starred and number == plan.loop + 1 and number > 1:
            table.add_section()
        table.add_row(f"{number}*" if starred else f"{number} ", into[number - 1])
    table.add_row(f"\N{RIGHTWARDS ARROW} {plan.loop + 1}*", into[-1])
    return table


def action_text(action: Action) -> str:
    """One action, such as `a1: pi1 → pi2`, `a2 grasps o2` or `{a2, a3} carry o2: pi1 → pi3`."""
    way = f"{action.start} \N{RIGHTWARDS ARROW} {action.goal}"
    if action.kind == "travel":
        return f"{action.agents[0]}: {way}"
    if action.kind == "transport":
        if len(action.agents) == 1:
            return f"{action.agents[0]} carries {action.object}: {way}"
        return f"{{{', '.join(action.agents)}}} carry {action.object}: {way}"
    return f"{action.agents[0]} {action.kind}s {action.object}"


def _actions(actions: Iterable[Action]) -> Text:
    parts = [action_text(action).replace(" ", _HARD_SPACE) for action in actions]
    return Text("; ".join(parts) or "\N{EN DASH}")


def _start(state: State, scenario: Scenario) -> Text:
    members = (*scenario.agent_names, *scenario.object_names)
    where = zip(members, state.agents + state.objects, strict=True)
    parts = [f"{member} in {region}" for member, region in where]
    parts += [
        f"{agent} grasps {grasp}"
        for agent, grasp in zip(scenario.agent_names, state.grasps, strict=True)
        if grasp is not None
    ]
    return Text("start: " + ", ".join(part.replace(" ", _HARD_SPACE) for part in parts))


def _caption(plan: Plan, scenario: Scenario) -> str:
    costs = f"J = {plan.cost:.6g} = {plan.prefix_cost:.6g} (prefix) + {plan.suffix_cost:.6g} (suffix), {plan.status}"
    if plan.status != "optimal":
        costs += f"; at least {plan.lower_bound:.6g}"
    note = stutter_note(scenario)
    return "\n".join(["* repeated for ever", costs, *([escape(note)] if note else [])])
