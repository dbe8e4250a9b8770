"""A plan as a table for a terminal, like Tables 1 and 2 of the paper."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from drake_ltl.planning.plan import Action, Plan, State
from drake_ltl.planning.stuttering import stutter_note
from drake_ltl.scenario.model import Scenario

_HARD_SPACE = "\N{NO-BREAK SPACE}"  # lines break between actions, not within


def plan_table(plan: Plan, scenario: Scenario | None = None) -> RenderableType:
    """One row per step with its actions, numbered from 1 as in all outputs; steps of the suffix are marked with a star.

    The last step leads from the suffix's last state back to its first. Without the scenario nothing is said of the
    start, nor of formulas.
    """
    table = Table(box=box.SIMPLE_HEAD, row_styles=("", "dim"))
    table.add_column("step", justify="right", no_wrap=True)
    table.add_column("actions", overflow="fold")
    if scenario is not None:
        table.add_row("", _start(plan.states[0], scenario))
    for number, actions in enumerate(plan.moves, start=1):
        if number == plan.loop + 1:
            table.add_section()
        table.add_row(f"{number}*" if number > plan.loop else f"{number} ", _actions(actions))
    title = [Text(f"Plan of {scenario.name}", style="italic")] if scenario is not None and scenario.name else []
    return Group(*title, table, Text("\n".join(_notes(plan, scenario))))


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
    return Text("; ".join(parts) or "all wait")


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


def _notes(plan: Plan, scenario: Scenario | None) -> list[str]:
    costs = f"J = {plan.cost:.6g} = {plan.prefix_cost:.6g} (prefix) + {plan.suffix_cost:.6g} (suffix), {plan.status}"
    if plan.status != "optimal":
        costs += f"; at least {plan.lower_bound:.6g}"
    note = None if scenario is None else stutter_note(scenario)
    return ["* repeated for ever", costs, *([note] if note else [])]
